"""The module's text: layout by templates/mjlab, everything else decided here."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from actspec.ir import ActuatorSet, Command, JointActuator, Origin
from actspec.simulators.mjlab import MjlabDialect
from actspec.targets.base import Approximation
from actspec.targets.kit.provenance import sections, written_by
from actspec.targets.kit.python_text import (
    comment_lines,
    environment,
    grouped,
    identifier,
    import_lines,
    keyword_lines,
    py,
    section_lines,
)
from actspec.targets.mjlab.joint_cfg import CfgField, JointCfg

WIDTH = 88
"""Columns of mjlab's own code."""

Names = Callable[[Sequence[JointActuator], Sequence[str]], tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class Preparation:
    """What has to be changed in the robot's model before mjlab adds actuators.

    Attributes:
        removes: Whether the model has actuators: those of the driven joints have to go.
        widened: Joints whose own force range is narrower than the effort limit, with that limit.
    """

    removes: bool
    widened: tuple[tuple[str, float], ...]

    @property
    def needed(self) -> bool:
        """Whether there is anything to do."""
        return self.removes or bool(self.widened)


def constant_name(robot: str) -> str:
    """What its constants begin with: `UNITREE_A1`."""
    return identifier(robot).upper()


def module_text(
    actuators: ActuatorSet,
    cfgs: Sequence[JointCfg],
    approximations: Sequence[Approximation],
    dialect: MjlabDialect,
    names: Names,
    preparation: Preparation,
    model: str,
) -> str:
    """The whole module.

    Args:
        actuators: What was compiled.
        cfgs: One a joint, in the robot's order.
        approximations: What was lost.
        dialect: Version that is written.
        names: Joints to the patterns that select exactly them; patterns to try first.
        preparation: What the model needs.
        model: File name of the robot's model; "" without one.
    """
    merged = grouped(cfgs, lambda cfg: cfg.key)
    constants = _constants(constant_name(actuators.robot), [key[0] for key, _ in merged])
    blocks = []
    classes = set()
    said = ""
    for constant, (_, members) in zip(constants, merged, strict=True):
        first = members[0].actuator
        about = f"{first.group}: {first.level.value}, {first.command.value} command."
        # Once for the parts of a group.
        head = [] if about == said else comment_lines(about, width=WIDTH)
        said = about
        blocks.append([*head, *_block(constant, members, names([m.actuator for m in members], ()), dialect)])
        classes.add(members[0].kind)
        if members[0].delay and not dialect.delay_fields:
            classes.add("DelayedActuatorCfg")
    return (
        environment("mjlab")
        .get_template("cfg.py.j2")
        .render(
            robot=identifier(actuators.robot),
            version=dialect.text,
            header=list(_header(actuators, approximations, dialect, preparation, model)),
            folder=any(cfg.network is not None for cfg in cfgs),
            imports=import_lines("mjlab.actuator", sorted(classes), indent="  ", width=WIDTH),
            actuators=blocks,
            driven=[cfg.actuator.joint for cfg in cfgs],
            prepare=list(_prepared(preparation)),
            removes=preparation.removes,
            widened=preparation.widened,
            constant=constant_name(actuators.robot),
            actuator_lines=list(_actuator_lines(constants)),
            action_scale=_by_value(actuators, _action_scale, lambda members: names(members, ())),
            default_pose=_by_value(
                actuators, _default_position, lambda members: names(members, actuators.default_pose)
            ),
        )
    )


def _constants(robot: str, groups: Sequence[Any]) -> list[str]:
    """`<ROBOT>_<GROUP>_ACTUATOR`, numbered where a group needs several or two groups read alike."""
    stems = [f"{robot}_{identifier(str(group), fallback='group').upper()}_ACTUATOR" for group in groups]
    counts: dict[str, int] = {}
    found = []
    for stem in stems:
        counts[stem] = counts.get(stem, 0) + 1
        found.append(stem if stems.count(stem) == 1 else f"{stem}_{counts[stem]}")
    return found


def _block(
    constant: str, members: Sequence[JointCfg], names: Sequence[str], dialect: MjlabDialect
) -> Iterator[str]:
    """One constant."""
    first = members[0]
    wrapped = bool(first.delay) and not dialect.delay_fields
    indent = "    " if wrapped else "  "
    yield f"{constant} = {'DelayedActuatorCfg' if wrapped else first.kind}("
    if wrapped:
        yield f"  base_cfg={first.kind}("
    yield from keyword_lines("target_names_expr", tuple(names), indent, step="  ", width=WIDTH)
    for field in _agreed(members, wrapped):
        yield from _row(field, indent)
    if wrapped:
        yield "  ),"
        command = first.actuator.command
        target = "position" if command is Command.POSITION else command.value
        yield f"  delay_target={py(target)},"
        for field in first.delay:
            yield from _row(field, "  ")
    yield ")"


def _agreed(members: Sequence[JointCfg], wrapped: bool) -> Iterator[CfgField]:
    """The fields of a cfg; a note only where all of its joints have the same."""
    rows = [cfg.fields if wrapped else (*cfg.fields, *cfg.delay) for cfg in members]
    for same in zip(*rows, strict=True):
        notes = {field.note for field in same}
        yield same[0] if len(notes) == 1 else CfgField(same[0].name, same[0].text)


def _actuator_lines(constants: Sequence[str]) -> Iterator[str]:
    """The articulation's tuple: a single one stays on its line, as the formatter of mjlab's code has it."""
    line = f"  actuators=({constants[0]},)," if len(constants) == 1 else ""
    if line and len(line) <= WIDTH:
        yield line
    else:
        yield from ("  actuators=(", *(f"    {constant}," for constant in constants), "  ),")


def _row(field: CfgField, indent: str) -> Iterator[str]:
    line = f"{indent}{field.name}={field.text},"
    behind = f"{line}  # {field.note}"
    if not field.note:
        yield line
    elif len(behind) <= WIDTH:
        yield behind
    else:
        yield from (*comment_lines(field.note, indent=indent, width=WIDTH), line)


def _prepared(preparation: Preparation) -> Iterator[str]:
    if preparation.removes:
        yield "The model's own actuators on these joints go, with their sensors: they would act"
        yield "beside those above. Its keyframes lose their controls, whose number changes."
    if preparation.widened:
        yield "Where the joint's own force range is narrower than effort_limit, it is widened."


def _header(
    actuators: ActuatorSet,
    approximations: Sequence[Approximation],
    dialect: MjlabDialect,
    preparation: Preparation,
    model: str,
) -> Iterator[str]:
    def said(text: str) -> list[str]:
        return comment_lines(text, width=WIDTH)

    step = actuators.physics_dt.require()
    yield from said(written_by())
    for line in actuators.spec_lines:
        yield from said(line)
    if model:
        yield from said(f"model {model}")
    if not dialect.run:
        yield from said(f"Text-checked against the fields of mjlab {dialect.text}, not run with it.")
    yield "#"
    constant = constant_name(actuators.robot)
    spec_fn = "lambda: prepare_spec(mujoco.MjSpec.from_file(...))" if preparation.needed else "..."
    yield "# Use:"
    yield "#   EntityCfg("
    yield f"#     spec_fn={spec_fn},"
    yield f"#     articulation={constant}_ARTICULATION,"
    yield "#   )"
    rates = f"SimulationCfg(mujoco=MujocoCfg(timestep={py(step)}))"
    rates += (
        f", decimation={actuators.decimation}"
        if actuators.control_period is not None and actuators.decimation is not None
        else ""
    )
    lags = (
        f": lags are steps of {step * 1e3:g} ms" if any(a.delay is not None for a in actuators.joints) else ""
    )
    yield from said(f"with {rates}{lags}.")
    if actuators.assumed_step:
        yield from said(f"The step is {actuators.assumed_step}.")
    yield from said("soft_joint_pos_limit_factor is left to the task.")
    below = sections(actuators, approximations, "Approximations (what mjlab cannot hold):")
    yield from section_lines(below, bullet="- ", hang="  ", width=WIDTH)


def _action_scale(actuator: JointActuator) -> float | None:
    return None if actuator.action_scale is None else actuator.action_scale.value


def _default_position(actuator: JointActuator) -> float | None:
    position = actuator.default_position
    return None if position.origin is Origin.DEFAULT else position.value


def _by_value(
    actuators: ActuatorSet,
    value: Callable[[JointActuator], float | None],
    names: Callable[[Sequence[JointActuator]], tuple[str, ...]],
) -> list[tuple[str, float]]:
    """Patterns with their value; joints without one are left out."""
    known = [actuator for actuator in actuators.joints if value(actuator) is not None]
    rows = []
    for number, members in grouped(known, value):
        assert number is not None
        rows += [(name, number) for name in names(members)]
    return rows
