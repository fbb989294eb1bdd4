"""The module's text: layout by templates/isaaclab, everything else decided here."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Sequence

import actspec
from actspec.ir import ActuatorSet
from actspec.simulators.isaaclab import IsaacLabDialect
from actspec.targets.base import Approximation
from actspec.targets.isaaclab.drive import CUSTOM
from actspec.targets.isaaclab.groups import Group, Keyword
from actspec.targets.provenance import known_quantities, loss_lines, source_lines
from actspec.targets.python_text import WIDTH, comment_lines, environment, identifier, py
from actspec.units import format_quantity


def module_name(robot: str) -> str:
    """Name of the module: `unitree_a1_cfg`."""
    return f"{identifier(robot).lower()}_cfg"


def class_name(robot: str) -> str:
    """Name of the robot's own actuator class: `UnitreeA1Actuator`."""
    words = identifier(robot).split("_")
    return "".join(word[:1].upper() + word[1:] for word in words) + "Actuator"


def module_text(
    actuators: ActuatorSet,
    groups: Sequence[Group],
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
            header=list(_header(actuators, approximations, dialect, model)),
            constant=constant,
            robot_constant=f"{identifier(actuators.robot).upper()}_CFG",
            module=module_name(actuators.robot),
            version=dialect.text,
            timing=_timing(actuators, groups),
            imports=list(_imports(sorted(stock))),
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


def _imports(names: Sequence[str]) -> Iterator[str]:
    """The import of the stock classes, on one line where it fits."""
    line = f"from isaaclab.actuators import {', '.join(names)}"
    if len(line) <= WIDTH:
        yield line
    else:
        yield from ("from isaaclab.actuators import (", *(f"    {name}," for name in names), ")")


def _timing(actuators: ActuatorSet, groups: Sequence[Group]) -> str:
    text = f"Made for ``SimulationCfg(dt={py(actuators.physics_dt.require())})``"
    if actuators.decimation is not None:
        text += f" and ``decimation={actuators.decimation}``"
    timed = {"max_delay", "physics_dt", "network_file"}
    if any(keyword.name in timed for group in groups for keyword in group.keywords):
        text += ": delays, filters and networks count physics steps"
    return f"{text}."


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


def _shared_remarks(groups: Sequence[Group]) -> tuple[str, ...]:
    """Remarks that hold for every group: said once, above them all."""
    if len(groups) < 2:
        return ()
    return tuple(r for r in groups[0].remarks if all(r in group.remarks for group in groups))


def _rows(group: Group, said: Sequence[str]) -> Iterator[str]:
    """The lines between the cfg's parentheses, without the remarks that are said above."""
    indent = " " * 8
    for remark in group.remarks:
        if remark not in said:
            yield from comment_lines(remark, indent=indent)
    one = f"{indent}joint_names_expr={py(list(group.patterns))},"
    if len(one) <= WIDTH:
        yield one
    else:
        yield f"{indent}joint_names_expr=["
        yield from (f"{indent}    {py(pattern)}," for pattern in group.patterns)
        yield f"{indent}],"
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
    actuators: ActuatorSet, approximations: Sequence[Approximation], dialect: IsaacLabDialect, model: str
) -> Iterator[str]:
    title = f"Isaac Lab {dialect.text} on Isaac Sim {dialect.sim_text} ({dialect.backend_text})"
    yield from comment_lines(
        f"Written by actspec {actspec.__version__} for {title}. Do not edit: change the spec and compile again."
    )
    if not dialect.executed:
        yield from comment_lines("Text-checked, not run: no package of this version could be had.")
    yield from comment_lines(f"spec sha256 {actuators.spec_sha256}")
    if model:
        yield from comment_lines(f"model {model}")
    yield from comment_lines(
        f"physics_dt {format_quantity(actuators.physics_dt.value, actuators.physics_dt.unit)}"
    )
    if approximations:
        yield from comment_lines("")
        yield from comment_lines("Approximations (what these classes cannot hold):")
        for line in loss_lines(approximations, digits=4):
            yield from comment_lines(f"  {line}", hang="    ")
    cited = list(source_lines(actuators, known_quantities(actuators)))
    if cited:
        yield from comment_lines("")
        yield from comment_lines("Sources:")
        for line in cited:
            yield from comment_lines(f"  {line}", hang="    ")
