"""What written files say of each joint, read back without running them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from actspec.diagnostics import ActspecError, Collector, Span
from actspec.fields import is_placeholder, unit_of
from actspec.files import FAULTS, read_regular
from actspec.ir import ActuatorSet, JointActuator
from actspec.lift import lift_newton
from actspec.lift.newton import READ, TARGETS, NewtonJoint, newton_joints
from actspec.readings.artifact import (
    ActuatorGroup,
    Artifact,
    FileKind,
    FileReading,
    RandomizedRange,
)
from actspec.readings.compare import Figure
from actspec.readings.config import IN_FIGURES, figures_of, rows_of_config
from actspec.readings.dynamics import OF_CONTROLS, JointDynamics, dynamics_of
from actspec.readings.ledger import LedgerRow, rows_of_robot, rows_of_spec
from actspec.readings.named import PendingFiles
from actspec.readings.versions import Versions
from actspec.robot.usda import MAX_BYTES, MISSING, Asset, UsdaAttribute, UsdaLayer, read_usda
from actspec.robot.view import ModelFormat, RobotView
from actspec.targets.base import TargetOptions
from actspec.targets.newton.paths import StagePaths, converted_actuators, lay_out
from actspec.targets.newton.usda import path_text

OVERLAY_FIELDS = (
    *("kp", "kd", "effort_limit", "stall_torque", "no_load_speed", "delay_low", "delay_high"),
    *("joint_damping", "frictionloss", "armature", "encoder_bias", "velocity_limit"),
)
"""What an overlay of Newton can hold."""

_OF_PRIM = ("newton:armature", "newton:friction", "newton:damping", "newton:velocityLimit")

ABSENT = {
    **dict.fromkeys(("delay_nominal", "delay_low", "delay_high", "encoder_bias", "default_position"), 0.0),
    **dict.fromkeys(("filter_cutoff", "command_high", "stall_torque", "no_load_speed"), math.inf),
    **dict.fromkeys(("curve.drive_torque", "curve.brake_torque", "curve.knee_speed"), math.inf),
    "command_low": -math.inf,
}
"""What a field is where there is no such thing: no delay, no filter, no clamp, no line; a joint that no pose names."""

Figures = Mapping[str, Mapping[str, Figure]]
"""Joint to field to what is said of it."""


@dataclass(frozen=True, slots=True)
class FileFigures:
    """One file, read back.

    Attributes:
        path: The file.
        reason: Why it cannot be read; None: it was.
        refusal: Why MuJoCo does not take it, whose numbers are then the text's; None: it does, or was not asked.
        refused_at: Where that was met; None: it is not known.
        figures: Of each joint that has any.
        order: Joints in the file's order: of its actuators where it has some.
        controls: Joint to what drives it.
        settings: Of the whole file: `physics_dt` [s] and others.
        raw: Joint to settings of its cfg that are no figure: texts, lists, networks' scales.
        gears: Joint to the gear of its actuator (MJCF).
        ranges: Its randomisation.
    """

    path: str
    reason: str | None = None
    refusal: str | None = None
    refused_at: Span | None = None
    figures: Figures = field(default_factory=dict)
    order: tuple[str, ...] = ()
    controls: Mapping[str, str] = field(default_factory=dict)
    settings: Mapping[str, float] = field(default_factory=dict)
    raw: Mapping[str, Mapping[str, object]] = field(default_factory=dict)
    gears: Mapping[str, float] = field(default_factory=dict)
    ranges: tuple[RandomizedRange, ...] = ()


@dataclass(frozen=True, slots=True)
class Asked:
    """A file to read back, and which target's it is."""

    path: str
    options: TargetOptions


def read_back(asked: Sequence[Asked], actuators: ActuatorSet, robot: RobotView) -> tuple[FileFigures, ...]:
    """Read files of targets, all in a few processes of their own.

    Args:
        asked: The files.
        actuators: What the spec asks for; its joints and step are those of a cfg.
        robot: The robot, likewise.

    Returns: One reading for each, in their order.
    """
    paths = list(dict.fromkeys(one.path for one in asked))
    found = {}
    if paths:
        with PendingFiles(paths) as pending:
            found = {reading.path: reading for reading in pending.finish()}
    return tuple(_reading(found[one.path], one.options, actuators, robot) for one in asked)


def spec_figures(actuators: ActuatorSet, path: str) -> Figures:
    """What the spec says, in the words of `read_back`.

    Args:
        actuators: The spec, resolved.
        path: Of the spec, for places.
    """
    artifact = Artifact(path, FileKind.SPEC, actuators.robot, spec=actuators)
    dynamics = dynamics_of(artifact, rows_of_spec(artifact, 0))
    found = {}
    for actuator in actuators.joints:
        figures = dict(dynamics.joints[actuator.joint].figures)
        figures.update(_of_spec(actuator, path))
        found[actuator.joint] = figures
    return found


def _of_spec(actuator: JointActuator, path: str) -> Iterator[tuple[str, Figure]]:
    """What a spec says beyond the audit's figures; what is not there as what it amounts to."""
    delay, ends, curve = actuator.delay, actuator.command_range, actuator.curve
    low, high = (None, None) if ends is None else (end.value for end in ends)
    values = {
        "delay_nominal": 0.0 if delay is None else delay.nominal.value,
        "delay_low": 0.0 if delay is None else delay.low,
        "delay_high": 0.0 if delay is None else delay.high,
        "encoder_bias": actuator.encoder_bias.value,
        "filter_cutoff": math.inf if actuator.filter_cutoff is None else actuator.filter_cutoff.value,
        "command_low": -math.inf if low is None else low,
        "command_high": math.inf if high is None else high,
        "curve.drive_torque": math.inf if curve is None else curve.drive_torque.value,
        "curve.brake_torque": math.inf if curve is None else curve.brake_torque.value,
        "curve.knee_speed": math.inf if curve is None else curve.knee_speed.value,
    }
    stall = None if curve is not None else actuator.stall_torque
    no_load = actuator.no_load_speed if curve is None else curve.no_load_speed
    values["stall_torque"] = math.inf if stall is None else stall.value
    values["no_load_speed"] = math.inf if no_load is None else no_load.value
    for name, value in values.items():
        yield (
            name,
            Figure(
                value, unit_of(name, actuator.kind, actuator.command.value), actuator.span or Span(path), True
            ),
        )


def _reading(
    reading: FileReading, options: TargetOptions, actuators: ActuatorSet, robot: RobotView
) -> FileFigures:
    if reading.reason is not None:
        return FileFigures(reading.path, reading.reason, refused_at=reading.refused)
    kind = {ModelFormat.MJCF: FileKind.MJCF, ModelFormat.URDF: FileKind.URDF}.get(robot.format)
    spec = Artifact("", FileKind.SPEC, actuators.robot, spec=actuators)
    partners = [spec] if kind is None else [Artifact(robot.path, kind, robot.name, robot=robot), spec]
    versions = versions_of(options)
    best = FileFigures(reading.path, "it has no robot")
    for artifact in reading.artifacts:
        rows = (
            rows_of_robot(artifact, 0)
            if artifact.robot is not None
            else rows_of_config(artifact, 0, partners, versions)
        )
        dynamics = dynamics_of(artifact, rows)
        figures, raw = {}, {}
        for name, joint in dynamics.joints.items():
            own = [row for row in rows if row.joint == name]
            figures[name] = _complete(artifact, own, joint, options, actuators)
            raw[name] = dict(_raw(artifact, own))
        found = FileFigures(
            path=reading.path,
            refusal=artifact.text_only,
            refused_at=artifact.refused_at,
            figures=figures,
            order=_order(artifact, tuple(figures)),
            controls={name: joint.control for name, joint in dynamics.joints.items()},
            settings={name: value for name, value in dynamics.settings.items() if isinstance(value, float)},
            raw=raw,
            gears=_gears(artifact),
            ranges=artifact.config.randomize if artifact.config is not None else (),
        )
        if best.reason is not None or len(found.figures) > len(best.figures):
            best = found
    return best


def versions_of(options: TargetOptions) -> Versions:
    """What a target's files are meant for, in the audit's words."""
    from actspec.targets.isaaclab import dialect_for

    if options.kind == "mujoco":
        return Versions(mujoco=options.version)
    if options.kind == "mjlab":
        return Versions(mjlab=options.version)
    if options.kind == "isaaclab":
        dialect = dialect_for(options)
        return Versions(isaaclab=options.version, isaac_sim=dialect.sim_text, backend=dialect.backend)
    return Versions()


def _complete(
    artifact: Artifact,
    rows: Sequence[LedgerRow],
    joint: JointDynamics,
    options: TargetOptions,
    actuators: ActuatorSet,
) -> dict[str, Figure]:
    """A joint's figures with those that the audit does not compare, and one for all that is passive."""
    # The gear is compared by itself (`gears`), with the way that it turns a servo.
    found = {name: one for name, one in joint.figures.items() if name not in OF_CONTROLS}
    gain = found.get("command_gain")
    if gain is not None and gain.value == -1.0:
        del found["command_gain"]
    damping, more = found.get("joint_damping"), found.get("actuator_damping")
    if damping is not None and damping.value is not None and more is not None and more.value:
        found["joint_damping"] = replace(damping, value=damping.value + more.value)
    if artifact.robot is not None:
        found.update(_of_model(artifact.robot, joint))
    elif artifact.config is not None and rows:
        found.update(_of_config(artifact, rows[0], options, actuators, found))
    return found


def _of_model(robot: RobotView, joint: JointDynamics) -> Iterator[tuple[str, Figure]]:
    if robot.format is not ModelFormat.MJCF:
        return
    drives = [drive for drive in robot.actuators if drive.target == joint.joint]
    delay = joint.figures.get("delay")
    value = 0.0 if delay is None or delay.value is None else delay.value
    place = joint.place if delay is None else delay.place
    yield "delay_low", Figure(value, "s", place, True)
    yield "delay_high", Figure(value, "s", place, True)
    if drives and "encoder_bias" not in joint.figures:
        yield "encoder_bias", Figure(0.0, "", drives[0].span, True)


_OF_MODEL = ("position_low", "position_high")
"""What the row of a configuration has from the model beside it; the file's own comes before that."""


def _of_config(
    artifact: Artifact,
    row: LedgerRow,
    options: TargetOptions,
    actuators: ActuatorSet,
    found: Mapping[str, Figure],
) -> Iterator[tuple[str, Figure]]:
    config, group = artifact.config, _group(artifact, row)
    if config is None or group is None:
        return
    step, joint = actuators.physics_dt.require(), row.joint
    own = actuators.joint(joint)
    kind, command = (None, "") if own is None else (own.kind, own.command.value)
    for name, one in figures_of(config, group, joint, joint, (joint,), versions_of(options), step).items():
        if (name not in found or name in _OF_MODEL) and one.stated and one.value is not None:
            yield name, Figure(one.value, unit_of(name, kind, command), one.span, True)
    for name in ("stall_torque", "no_load_speed"):
        figure = found.get(name)
        if figure is not None and figure.value is not None and is_placeholder(figure.value):
            yield name, replace(figure, value=math.inf)


def _group(artifact: Artifact, row: LedgerRow) -> ActuatorGroup | None:
    groups = artifact.config.groups if artifact.config is not None else ()
    return next((g for g in groups if (g.name, g.span) == (row.actuator, row.span)), None)


def _raw(artifact: Artifact, rows: Sequence[LedgerRow]) -> Iterator[tuple[str, object]]:
    """Settings of a joint's cfg that are in no figure, and its class."""
    for row in rows:
        group = _group(artifact, row)
        if group is None:
            continue
        yield "class", group.cls
        for name, setting in group.settings.items():
            if name not in IN_FIGURES and setting.unknown is None:
                yield name, setting.value


def _order(artifact: Artifact, joints: tuple[str, ...]) -> tuple[str, ...]:
    if artifact.robot is not None and artifact.robot.actuators:
        return tuple(actuator.target for actuator in artifact.robot.actuators)
    return joints


def _gears(artifact: Artifact) -> dict[str, float]:
    if artifact.robot is None:
        return {}
    return {actuator.target: actuator.gear for actuator in artifact.robot.actuators}


def read_overlay(path: str, options: TargetOptions, actuators: ActuatorSet, robot: RobotView) -> FileFigures:
    """Read an overlay.

    Args:
        path: The file.
        options: Where its joints are in the stage.
        actuators: What the spec asks for; its step is that of the delays.
        robot: The robot.

    Raises: RobotError: `usd-core` is not installed.
    """
    said = Collector()
    layout = lay_out(actuators, robot, options, said)
    if said.failed:
        return FileFigures(path, said.sorted()[0].message)
    try:
        layer = read_usda(read_regular(path, MAX_BYTES), path)
    except ActspecError as err:
        if err.diagnostics[0].code == MISSING:
            raise
        first = err.diagnostics[0]
        return FileFigures(path, first.message, refused_at=first.span)
    except FAULTS as err:
        return FileFigures(path, str(err))
    prims = {name: path_text(parts) for name, parts in layout.joints.items()}
    views = [view for actuator in actuators.joints if (view := robot.joint(actuator.joint)) is not None]
    whole = lift_newton(layer, views, prims, actuators.physics_dt.require())
    lifted = whole.actuators
    figures: dict[str, dict[str, Figure]] = {
        name: {field: figure for field, figure in found.items() if field in OVERLAY_FIELDS}
        for name, found in spec_figures(lifted, path).items()
    }
    joints = newton_joints(layer, views, prims)
    raw = {joint.name: dict(_overlay_raw(joint)) for joint in joints}
    for name, prim, active in _own_actuators(layer, robot, layout):
        raw.setdefault(name, {})[f"active of {prim}"] = active
    for joint in joints:
        own = lifted.joint(joint.name)
        if own is not None:
            figures[joint.name].update(_placed(joint, own, figures[joint.name]))
    controls = {actuator.joint: actuator.level.value for actuator in lifted.joints}
    for alone in whole.left_alone:
        # There, with no drive, several, or one that Newton refuses.
        if alone.span is not None:
            figures[alone.joint], controls[alone.joint] = {}, "none"
    return FileFigures(
        path=path,
        figures=figures,
        controls=controls,
        raw=raw,
    )


def _placed(
    joint: NewtonJoint, actuator: JointActuator, figures: dict[str, Figure]
) -> Iterator[tuple[str, Figure]]:
    """Figures at the place of their attribute, and the force limit of the joint's own prim."""
    delay = actuator.delay
    if delay is not None and delay.nominal.span is not None:
        for name in ("delay_low", "delay_high"):
            yield name, replace(figures[name], place=delay.nominal.span)
    if actuator.encoder_bias.span is not None:
        yield "encoder_bias", replace(figures["encoder_bias"], place=actuator.encoder_bias.span)
    for name, attribute in _of_prim(joint).items():
        if name.endswith(":maxForce") and isinstance(attribute.value, float):
            unit = actuator.effort_limit.unit
            yield "solver_effort_limit", Figure(attribute.value, unit, attribute.span, True)


def _of_prim(joint: NewtonJoint) -> dict[str, UsdaAttribute]:
    return {} if joint.prim is None else dict(joint.prim.attributes)


def _overlay_raw(joint: NewtonJoint) -> Iterator[tuple[str, object]]:
    """Schemas, and attributes that are in no figure."""
    if joint.prim is not None:
        yield "schemas of the joint", joint.prim.apis
    for name, attribute in _of_prim(joint).items():
        if name not in _OF_PRIM and not name.endswith(":maxForce"):
            yield name, attribute.value
    for prim in joint.actuators:
        yield "schemas of the actuator", prim.apis
        for name, attribute in prim.attributes.items():
            if isinstance(attribute.value, Asset):
                yield name, attribute.value.path
            elif name not in (TARGETS, *READ):
                yield name, attribute.value


def _own_actuators(layer: UsdaLayer, robot: RobotView, layout: StagePaths) -> Iterator[tuple[str, str, bool]]:
    """Whether the prims of the model's own actuators, which would act beside, are left on: joint, prim, answer."""
    targets = {actuator.name: actuator.target for actuator in robot.actuators}
    for parts in converted_actuators(robot, layout):
        prim = layer.prims.get(path_text(parts))
        yield targets[parts[-1]], path_text(parts), prim is None or prim.active
