"""From cfgs to the groups of a cfg: which joints share one, what it is called, scalar or dict."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from actspec.ir import ActuatorSet
from actspec.simulators.isaaclab import IsaacLabDialect
from actspec.targets.base import Approximation
from actspec.targets.isaaclab.fields import CfgField
from actspec.targets.isaaclab.joint_cfg import CUSTOM, JointCfg
from actspec.targets.kit.provenance import sections, written_by
from actspec.targets.kit.python_text import (
    DIGITS,
    WIDTH,
    comment_lines,
    environment,
    free_name,
    grouped,
    identifier,
    import_lines,
    joint_patterns,
    keyword_lines,
    module_name,
    py,
    section_lines,
)
from actspec.units import format_quantity


@dataclass(frozen=True, slots=True)
class DictEntry:
    """One key of a dict: a pattern, its number and what stands behind it."""

    key: str
    value: float
    note: str


@dataclass(frozen=True, slots=True)
class Keyword:
    """One keyword of a cfg, a scalar or a dict over all of the group's joints.

    Attributes:
        name: Keyword.
        value: The scalar; of no meaning where there are entries.
        entries: The dict; empty for a scalar.
        note: What stands behind the keyword; empty where the entries have notes of their own.
        file: The value is a file beside the module.
    """

    name: str
    value: float | str | list[int] | None
    entries: tuple[DictEntry, ...]
    note: str
    file: bool


@dataclass(frozen=True, slots=True)
class CfgGroup:
    """One group of joints.

    Attributes:
        name: Its key.
        cls: Name of the class without `Cfg`.
        patterns: Expressions that match its joints, each once.
        keywords: The rest of the cfg.
        remarks: Comments.
        cfgs: Its joints.
    """

    name: str
    cls: str
    patterns: tuple[str, ...]
    keywords: tuple[Keyword, ...]
    remarks: tuple[str, ...]
    cfgs: tuple[JointCfg, ...]


def groups_of(cfgs: Sequence[JointCfg], names: Sequence[str]) -> tuple[CfgGroup, ...]:
    """Split the spec's groups where a cfg takes one value, and merge the rest.

    Args:
        cfgs: One a joint, in the robot's order.
        names: All of the robot's joints.
    """
    found: list[CfgGroup] = []
    taken: set[str] = set()
    for spec_group, members in grouped(cfgs, lambda cfg: cfg.actuator.group):
        parts = [part for _, part in grouped(members, _shared)]
        for label, part in zip(_labels(spec_group, parts), parts, strict=True):
            name = free_name(label, taken)
            taken.add(name)
            found.append(_group(name, part, names))
    return tuple(found)


def _shared(cfg: JointCfg) -> tuple[object, ...]:
    """What all joints of a group must have in common; `None` fits in no dict."""
    fields = tuple((f.name, repr(f.value) if f.scalar or f.value is None else "") for f in cfg.fields)
    return (cfg.cls, fields)


def _labels(name: str, parts: Sequence[Sequence[JointCfg]]) -> list[str]:
    """Names of a split group's parts: with the words that all of a part's joints have and no other's."""
    if len(parts) == 1:
        return [name]
    words = [[_words(cfg.actuator.joint) for cfg in part] for part in parts]
    labels = []
    for index, mine in enumerate(words):
        others = [
            word for other, part in enumerate(words) if other != index for joint in part for word in joint
        ]
        common = [word for word in mine[0] if all(word in joint for joint in mine) and word not in others]
        labels.append("_".join([name, *common]))
    return labels


def _words(joint: str) -> list[str]:
    return [word for word in re.split(r"[^A-Za-z0-9]+", joint) if word]


def _group(name: str, cfgs: Sequence[JointCfg], names: Sequence[str]) -> CfgGroup:
    keywords = []
    for index, first in enumerate(cfgs[0].fields):
        members = [(cfg, cfg.fields[index]) for cfg in cfgs]
        keywords.append(_merged(first, members, names))
    remarks = tuple(dict.fromkeys(remark for cfg in cfgs for remark in cfg.remarks))
    patterns = joint_patterns([cfg.actuator for cfg in cfgs], names)
    return CfgGroup(name, cfgs[0].cls, patterns, tuple(keywords), remarks, tuple(cfgs))


def _merged(first: CfgField, members: list[tuple[JointCfg, CfgField]], names: Sequence[str]) -> Keyword:
    notes = list(dict.fromkeys(field.note for _, field in members))
    note = notes[0] if len(notes) == 1 else ""
    if all(field.value == first.value for _, field in members):
        return Keyword(first.name, first.value, (), note or "; ".join(filter(None, notes)), first.file)
    entries = []
    for (value, own), part in grouped(members, lambda member: (member[1].value, member[1].note)):
        assert isinstance(value, int | float)
        for pattern in joint_patterns([cfg.actuator for cfg, _ in part], names):
            entries.append(DictEntry(pattern, value, "" if note else own))
    return Keyword(first.name, None, tuple(entries), note, first.file)


def class_name(robot: str) -> str:
    """Name of the robot's own actuator class: `UnitreeA1Actuator`."""
    words = identifier(robot).split("_")
    return "".join(word[:1].upper() + word[1:] for word in words) + "Actuator"


def module_text(
    actuators: ActuatorSet,
    groups: Sequence[CfgGroup],
    approximations: Sequence[Approximation],
    dialect: IsaacLabDialect,
    model: str,
) -> str:
    """The whole module.

    Args:
        actuators: What was compiled.
        groups: What the cfg holds.
        approximations: What was lost.
        dialect: Version that is written.
        model: File name of the robot's model; "" without one.
    """
    own = class_name(actuators.robot)
    constant = f"{identifier(actuators.robot).upper()}_ACTUATORS"
    custom = [group for group in groups if group.cls == CUSTOM]
    features = {keyword.name for group in custom for keyword in group.keywords}
    stock = {f"{group.cls}Cfg" for group in groups if group.cls != CUSTOM}
    if custom:
        stock |= {"IdealPDActuator", "IdealPDActuatorCfg"}
    remarks = _shared_remarks(groups)
    return (
        environment("isaaclab")
        .get_template("cfg.py.j2")
        .render(
            header=list(_header(actuators, groups, approximations, dialect, model)),
            constant=constant,
            robot_constant=f"{identifier(actuators.robot).upper()}_CFG",
            module=module_name(actuators.robot),
            version=dialect.text,
            timing=_timing(actuators, groups),
            imports=import_lines("isaaclab.actuators", sorted(stock)),
            files=any(keyword.file for group in groups for keyword in group.keywords),
            custom=bool(custom),
            own=own,
            features=features,
            stages=_stages(features),
            remarks=[line for remark in remarks for line in comment_lines(remark)],
            groups=[
                {
                    "name": group.name,
                    "cls": own if group.cls == CUSTOM else group.cls,
                    "rows": list(_rows(group, remarks)),
                }
                for group in groups
            ],
        )
    )


def _counts_steps(groups: Sequence[CfgGroup]) -> bool:
    """Whether something acts by the length of a physics step."""
    timed = {"max_delay", "physics_dt", "network_file"}
    return any(keyword.name in timed for group in groups for keyword in group.keywords)


def _timing(actuators: ActuatorSet, groups: Sequence[CfgGroup]) -> str:
    """For which steps it is made; a step that nobody chose only where something counts it."""
    counts = _counts_steps(groups)
    step = py(actuators.physics_dt.require())
    if actuators.assumed_step:
        return (
            f"Delays, filters and networks count physics steps of {step} s,\n{actuators.assumed_step}."
            if counts
            else "No step of the simulation is stated, and nothing here counts one."
        )
    text = f"Made for ``SimulationCfg(dt={step})``"
    if actuators.decimation is not None and actuators.control_period is not None:
        text += f" and ``decimation={actuators.decimation}``"
    return f"{text}: delays, filters and networks count physics steps." if counts else f"{text}."


def _stages(features: set[str]) -> list[str]:
    """What our own class does with a command, in order, as lines of a docstring."""
    stages = []
    if features & {"command_low", "command_high"}:
        stages.append("clamp of the command")
    if "max_delay" in features:
        stages.append("delay")
    if "filter_cutoff" in features:
        stages.append("first-order filter")
    stages.append("PD on the encoder's position" if "encoder_bias" in features else "PD")
    stages.append("torque-speed curve" if features & {"stall_torque", "drive_torque"} else "torque limit")
    return textwrap.wrap(f"In the order of a physics step: {', '.join(stages)}.", WIDTH - 4)


def _shared_remarks(groups: Sequence[CfgGroup]) -> tuple[str, ...]:
    """Remarks that hold for every group: said once, above them all."""
    if len(groups) < 2:
        return ()
    return tuple(r for r in groups[0].remarks if all(r in group.remarks for group in groups))


def _rows(group: CfgGroup, said: Sequence[str]) -> Iterator[str]:
    """The lines between the cfg's parentheses, without the remarks that are said above."""
    indent = " " * 8
    for remark in group.remarks:
        if remark not in said:
            yield from comment_lines(remark, indent=indent)
    yield from keyword_lines("joint_names_expr", list(group.patterns), indent)
    for keyword in group.keywords:
        yield from _keyword(keyword, indent)


def _keyword(keyword: Keyword, indent: str) -> Iterator[str]:
    if keyword.entries:
        yield _noted(f"{indent}{keyword.name}={{", keyword.note)
        for entry in keyword.entries:
            yield _noted(f"{indent}    {py(entry.key)}: {py(float(entry.value))},", entry.note)
        yield f"{indent}}},"
        return
    value = keyword.value
    text = f"os.path.join(FOLDER, {py(value)})" if keyword.file else py(value)
    yield _noted(f"{indent}{keyword.name}={text},", keyword.note)


def _noted(code: str, note: str) -> str:
    """A line with its comment, shortened part by part until it fits."""
    parts = note.split("; ")
    while parts and parts[0]:
        (comment,) = comment_lines("; ".join(parts))[:1]
        if len(code) + 2 + len(comment) <= WIDTH and len(comment_lines("; ".join(parts))) == 1:
            return f"{code}  {comment}"
        parts = parts[:-1]
    return code


def _header(
    actuators: ActuatorSet,
    groups: Sequence[CfgGroup],
    approximations: Sequence[Approximation],
    dialect: IsaacLabDialect,
    model: str,
) -> Iterator[str]:
    title = f"Isaac Lab {dialect.text} on Isaac Sim {dialect.sim_text} ({dialect.backend_text})"
    yield from comment_lines(written_by(f" for {title}"))
    if not dialect.executed:
        yield from comment_lines("Text-checked, not run: no package of this version could be had.")
    for line in actuators.spec_lines:
        yield from comment_lines(line)
    if model:
        yield from comment_lines(f"model {model}")
    if _counts_steps(groups) or not actuators.assumed_step:
        # It is read back (`readings.versions.step_of`): with the digits that numbers have below.
        step = format_quantity(actuators.physics_dt.value, actuators.physics_dt.unit, DIGITS)
        yield from comment_lines(f"physics_dt {step}")
    heading = "Approximations (what these classes cannot hold):"
    said = sections(actuators, approximations, heading, digits=4)
    yield from section_lines(said, bullet="  ", hang="    ")
