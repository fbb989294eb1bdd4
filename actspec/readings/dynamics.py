"""Effective dynamics of the robots in files: what all actuators of a joint and its passive part do together.

From ledger rows, and from the artifact for what the ledger has no column for. None is unknown, never zero.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace

from actspec.diagnostics import Span, listed
from actspec.fields import BY_IR, FIELDS, LIMITS, Role
from actspec.files import NotRegular, TooLarge, read_regular
from actspec.ir import JointActuator, Origin, Quantity
from actspec.readings.artifact import ActuatorGroup, Artifact, FileKind, Framework, RobotConfig
from actspec.readings.compare import Figure, same
from actspec.readings.dict_keys import plain_name
from actspec.readings.joint import read_joints
from actspec.readings.ledger import LedgerRow
from actspec.readings.networks import network_paths
from actspec.robot.view import ActuatorView, JointView, RobotView
from actspec.units import format_number

SETTING_NOUNS = {
    "physics_dt": "physics step",
    "decimation": "decimation",
    "control_dt": "control period",
    "integrator": "integrator",
}
"""What concerns the whole robot, in words, in the order in which it is shown."""

ORDERS = {
    "ctrl": "ctrl[{place}] drives",
    "actuators": "ctrl[{place}] is",
    "joint_order": "entry {entry} of the joint names",
    "sdk_order": "entry {entry} of the robot's joint order",
}
"""What stands at a place of a list, in words; `place` counts from 0 and `entry` from 1."""

OF_CONTROLS = frozenset({"gear", "torque_per_control"})
"""Figures of what a control of 1 does, which other kinds of drive and files do not have."""

_SAID = ("model", "soft_joint_pos_limit_factor")
"""Settings of a configuration that are no figure of a joint, and concern all of them."""

_BOUNDS = LIMITS | {"command_low", "command_high", "position_low", "position_high"}
"""Fields that may be infinite."""
_SERVOS = frozenset({"position", "dcmotor", "pid"})
"""Controls that are a target of the position where they have a kp."""

_FRICTION_AS_WRITTEN = frozenset({"friction_setting", "dynamic_friction_setting"})
"""Friction in the unit that the file's Isaac Lab reads it in."""

_MOST_NETWORK_BYTES = 1 << 28
"""Chosen: actuator networks have some 10 kB."""
_OF_ROW = tuple(
    name
    for name, field in FIELDS.items()
    if name in LedgerRow.__dataclass_fields__ and field.role is not Role.DERIVED
)


@dataclass(frozen=True, slots=True)
class JointDynamics:
    """What acts on one joint.

    Attributes:
        joint: Its name; `actuator NAME` for what drives a tendon, site or body.
        control: The controls of its actuators (`CONTROLS`), joined by `+`.
        place: Where the actuator (or the bare joint) is written.
        figures: Field of `FIELDS` to its figure; a command gain only where it is not 1.
        network: SHA-256 of its actuator network, or the network's name where only that is known; None: none.
        inertia: Least and largest inertia of the links over the poses, armature left out; None when unknown.
        natural_frequency: [rad/s]; None when unknown.
        damping_ratio: [-]; None when unknown.
        ranges: What is randomised to how, in words; None where nobody knows.
        axis: As in `JointView`; None when unknown.
        by_key: Fields of which `RobotDynamics.by_key` has what is known of a pattern.
    """

    joint: str
    control: str
    place: Span
    figures: Mapping[str, Figure]
    network: str | None = None
    inertia: tuple[float, float] | None = None
    natural_frequency: float | None = None
    damping_ratio: float | None = None
    ranges: Mapping[str, str] | None = None
    axis: tuple[float, float, float] | None = None
    by_key: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class RobotDynamics:
    """One robot as one file has it.

    Attributes:
        name: Its name there.
        file: The file as the user named it.
        kind: What the file is.
        joints: Name to joint, in the file's order.
        settings: Name of `SETTING_NOUNS` to the value [s, -]; a text for the integrator. Unknown ones are left out.
        unstated: Settings that no file states: they are an engine's default.
        orders: Names by place, by a key of `ORDERS`; None where nobody knows of any, as in a lock of an older actspec.
        entries: Numbers that no figure is made from and that may be of a joint, or of all as a step, by where they
            stand; None likewise.
        others: Other values that no figure is made from, by where they stand.
        unread: What is not read that concerns the actuators, and why.
        patterns: Those of `joints` that are patterns of a configuration whose robot is not at hand.
        undriven: Joints of a model that no actuator drives, where others have one.
        framework: Whose conventions a configuration follows; None of other files.
        by_key: Field to keys and figures of the dicts of a configuration of which nobody knows which joints they are
            for, in the order that counts; a key of several dicts once for each figure. None where joints are known, or
            in a lock of an older actspec.
    """

    name: str
    file: str
    kind: FileKind
    joints: Mapping[str, JointDynamics]
    settings: Mapping[str, float | str] = field(default_factory=dict)
    unstated: frozenset[str] = frozenset()
    orders: Mapping[str, tuple[str, ...]] | None = None
    entries: Mapping[str, float] | None = None
    others: Mapping[str, float | str] = field(default_factory=dict)
    unread: Mapping[str, str] = field(default_factory=dict)
    patterns: frozenset[str] = frozenset()
    undriven: frozenset[str] = frozenset()
    framework: Framework | None = None
    by_key: Mapping[str, Sequence[tuple[str, Figure]]] | None = None


def dynamics_of(artifact: Artifact, own: Sequence[LedgerRow]) -> RobotDynamics:
    """The effective dynamics of one artifact.

    Args:
        artifact: The robot in one file.
        own: Its rows of the ledger.
    """
    rows: dict[str, list[LedgerRow]] = {}
    for row in own:
        if row.joint:
            rows.setdefault(row.joint, []).append(row)
    joints = {name: _joint(artifact, found) for name, found in rows.items()}
    joints.update((loose.joint, loose) for loose in _loose(artifact))
    entries, others = _beside(artifact.config)
    patterns = _patterns(artifact.config, own)
    return RobotDynamics(
        artifact.name,
        artifact.path,
        artifact.kind,
        joints,
        settings_of(artifact),
        _unstated(artifact),
        _orders(artifact),
        entries,
        others,
        unread_of(artifact.config),
        patterns,
        undriven(artifact.robot),
        None if artifact.config is None else artifact.config.framework,
        _by_key(own) if patterns else None,
    )


def figure(rows: Sequence[LedgerRow], name: str) -> Figure:
    """A field of a joint from all rows of the joint in one artifact.

    Args:
        rows: Of one joint, one an actuator; at least one.
        name: Field of a row that is a number.
    """
    if len(rows) == 1:
        row = rows[0]
        made = row.made.get(name, "")
        return Figure(getattr(row, name), row.unit(name), row.place(name), name in row.stated, made)
    said = [row for row in rows if name in row.stated]
    values: list[float | None] = [getattr(row, name) for row in rows]
    value = values[0]
    if FIELDS[name].summed and len(rows) > 1:
        known = [item for item in values if item is not None]
        value = math.fsum(known) if len(known) == len(values) else None
    first = said[0] if said else rows[0]
    return Figure(value, rows[0].unit(name), first.place(name), bool(said), rows[0].made.get(name, ""))


def undriven(robot: RobotView | None) -> frozenset[str]:
    """Joints of a model that no actuator drives, where others have one.

    A model without any, as a URDF, leaves all drives to others. What feels a tendon or a site, or moves with another
    joint, needs none of its own.
    """
    if robot is None:
        return frozenset()
    readings = read_joints(robot)
    if not any(reading.drives for reading in readings.values()):
        return frozenset()
    return frozenset(
        name
        for name, reading in readings.items()
        if not (reading.drives or reading.movers or reading.joint.mimic) and name not in robot.coupled
    )


def settings_of(artifact: Artifact, *, bare_dt: bool = True) -> dict[str, float | str]:
    """What an artifact says of the whole robot's steps, by the names of `SETTING_NOUNS`.

    Args:
        artifact: The robot in one file.
        bare_dt: Take the `dt` of a deploy file too, for what the keys beside it make of it.
    """
    found: dict[str, float | str] = {}
    if artifact.robot is not None and artifact.robot.timestep is not None:
        found["physics_dt"] = artifact.robot.timestep
        if artifact.robot.integrator:
            lost = artifact.robot.integrator == "Euler" and not artifact.robot.eulerdamp
            found["integrator"] = artifact.robot.integrator + (" without eulerdamp" if lost else "")
    elif artifact.spec is not None:
        if artifact.spec.physics_dt.value is not None:
            found["physics_dt"] = artifact.spec.physics_dt.value
        if artifact.spec.decimation is not None:
            found["decimation"] = float(artifact.spec.decimation)
        if artifact.spec.control_period is not None:
            found["control_dt"] = artifact.spec.control_period
    elif artifact.config is not None:
        for name in ("physics_dt", "decimation", "control_dt"):
            setting = artifact.config.settings.get(name)
            if setting is not None and setting.unknown is None and isinstance(setting.value, int | float):
                found[name] = float(setting.value)
        of, dt = (artifact.config.settings.get(name) for name in ("dt_of", "dt"))
        if bare_dt and of is not None and dt is not None and dt.number is not None:
            found.setdefault(str(of.value), dt.number)
    step, decimation = found.get("physics_dt"), found.get("decimation")
    if artifact.spec is None and isinstance(step, float) and isinstance(decimation, float):
        found.setdefault("control_dt", step * decimation)
    return found


def setting_place(artifact: Artifact, name: str) -> Span:
    """Where a configuration or spec writes a step, or what it is computed from; else the file."""
    if artifact.spec is not None:
        return artifact.spec.physics_dt.span or Span(artifact.path)
    settings = {} if artifact.config is None else artifact.config.settings
    found = next((settings[key] for key in (name, "dt", "decimation", "physics_dt") if key in settings), None)
    return found.span if found is not None else Span(artifact.path)


def _unstated(artifact: Artifact) -> frozenset[str]:
    """Settings of an engine, which no file states: a step of MuJoCo's own."""
    if artifact.spec is not None:
        return frozenset({"physics_dt"} if artifact.spec.physics_dt.origin is Origin.DEFAULT else ())
    if artifact.kind is FileKind.MJCF:
        stated = {"physics_dt": b"timestep", "integrator": b"integrator"}
        return frozenset(name for name, attribute in stated.items() if not artifact.states(attribute))
    return frozenset()


def _orders(artifact: Artifact) -> dict[str, tuple[str, ...]]:
    """What stands at which place of a list, where the place counts: of controls, and of joints."""
    if artifact.robot is not None:
        drives = sorted(artifact.robot.actuators, key=lambda drive: drive.index)
        if not drives:
            return {}
        targets = (
            drive.target if drive.transmission == "joint" else f"{drive.transmission} {drive.target}"
            for drive in drives
        )
        return {"ctrl": tuple(targets), "actuators": tuple(drive.name for drive in drives)}
    settings = {} if artifact.config is None else artifact.config.settings
    found = {}
    for name in ("joint_order", "sdk_order"):
        value = settings[name].value if name in settings else None
        if isinstance(value, tuple) and value:
            found[name] = tuple("none" if one is None else str(one) for one in value)
    return found


def _beside(config: RobotConfig | None) -> tuple[dict[str, float], dict[str, float | str]]:
    """What no figure is made from: numbers that may be of a joint, and other values as they are written."""
    if config is None:
        return {}, {}
    entries = {where: number for where, one in config.entries.items() if (number := one.number) is not None}
    others = {
        where: str(one.value) if one.number is None else one.number
        for where, one in config.others.items()
        if one.unknown is None
    }
    for name in _SAID:
        if name in config.settings:
            one = config.settings[name]
            others[name] = one.unknown or (str(one.value) if one.number is None else one.number)
    for drawn in config.randomize:
        joints = "" if drawn.joints is None else f" of {listed(drawn.joints)}"
        how = ", ".join(filter(None, (drawn.distribution, drawn.when)))
        name = f"randomization of {drawn.field}{joints}"
        text = f"{drawn.operation} {format_number(drawn.low)} to {format_number(drawn.high)} ({how})"
        # A figure that is drawn at the start and at every reset has two.
        others[name] = f"{others[name]}, {text}" if name in others else text
    return entries, others


def _patterns(config: RobotConfig | None, rows: Sequence[LedgerRow]) -> frozenset[str]:
    """Rows that stand for every joint that a pattern selects: of a robot that is at hand the kind is known."""
    if config is None:
        return frozenset()
    return frozenset(
        row.joint for row in rows if row.kind is None and plain_name(config.framework, row.joint) is None
    )


def _by_key(rows: Sequence[LedgerRow]) -> dict[str, tuple[tuple[str, Figure], ...]]:
    """What dicts have by pattern; friction as it is written only where it is no torque."""
    found: dict[str, dict[tuple[str, float], Figure]] = {}
    for row in rows:
        for name, numbers in row.by_key.items():
            if not (name in _FRICTION_AS_WRITTEN and "frictionloss" in row.by_key):
                for key, (number, place) in numbers.items():
                    figure = Figure(number, row.unit(name), place, True)
                    found.setdefault(name, {}).setdefault((key, number), figure)
    return {
        name: tuple((key, one) for (key, _), one in every.items() if is_figure(name, one.value))
        for name, every in found.items()
    }


def unread_of(config: RobotConfig | None) -> dict[str, str]:
    """What of a configuration is not read, and why; without what figures of its joints are unknown for."""
    if config is None:
        return {}
    beyond = {where: one.unknown for where, one in config.others.items() if one.unknown is not None}
    if config.framework is Framework.DEPLOY:
        return beyond
    told = {f"{group.name}.{name}" for group in config.groups if group.joints for name in group.settings}
    if config.groups:
        told |= {"default_position", "action_scale"}
    return beyond | {
        note.where: note.message
        for note in config.notes
        # Of a configuration the ranges of randomization are not compared at all.
        if note.where and note.where not in (*told, *_SAID) and not note.where.startswith("events")
    }


def _group(artifact: Artifact, row: LedgerRow) -> ActuatorGroup | None:
    """The actuator cfg that a row is made from."""
    groups = artifact.config.groups if artifact.config is not None else ()
    return next((g for g in groups if (g.name, g.span) == (row.actuator, row.span)), None)


def _network_name(artifact: Artifact, row: LedgerRow) -> str | None:
    """The file of a configuration's network, as written."""
    group = _group(artifact, row)
    setting = group.settings.get("network_file") if group is not None else None
    return setting.value if setting is not None and isinstance(setting.value, str) else None


def _joint(artifact: Artifact, rows: Sequence[LedgerRow]) -> JointDynamics:
    first = rows[0]
    figures = {name: figure(rows, name) for name in _OF_ROW}
    if artifact.config is not None and len(rows) > 1:
        # Groups of one joint that no program takes together: what they do not have alike nobody has.
        figures = {name: replace(one, value=_common(rows, name)) for name, one in figures.items()}

    def add(name: str, value: float | None, place: Span | None = None) -> None:
        figures[name] = Figure(value, first.unit(name), place or first.span, True)

    command = _least_range([row.command_range for row in rows])
    for name, ends in (("command", command), ("position", first.position_range)):
        if ends is not None:
            place = first.place(f"{name}_range")
            add(f"{name}_low", ends[0], place)
            add(f"{name}_high", ends[1], place)
    network = ranges = axis = None
    if artifact.spec is not None:
        actuator = artifact.spec.joint(first.joint)
        if actuator is not None:
            if actuator.default_position.origin is Origin.DEFAULT:
                # The zero that a spec without a pose compiles with is nobody's pose.
                pose = figures["default_position"]
                figures["default_position"] = replace(pose, value=None)
            for name, value in _of_spec(actuator):
                add(name, value)
            network = _network(actuator)
            ranges = {one.field: one.words for one in actuator.randomize}
            if actuator.delay is not None and actuator.delay.low != actuator.delay.high:
                ranges["delay"] = f"drawn each {actuator.delay.sampling}"
    elif artifact.robot is not None:
        view = artifact.robot.joint(first.joint)
        axis = None if view is None else view.axis
        drives = [a for a in artifact.robot.actuators if a.target == first.joint]
        for name, value, at in _of_model(view, drives):
            add(name, value, at)
        for name, value, at in _of_controls(drives):
            figures[name] = Figure(value, first.unit(name), at, False)
    else:
        network = _network_name(artifact, first)
        for name, value in first.more.items():
            # Friction as it is written is of interest where it is no torque.
            if name not in _FRICTION_AS_WRITTEN or first.frictionloss is None:
                add(name, value, first.place(name))
    return JointDynamics(
        first.joint,
        "+".join(dict.fromkeys(row.control for row in rows)),
        first.span,
        {name: _figure(name, figures[name]) for name in FIELDS if name in figures},
        network,
        _links(first),
        first.natural_frequency,
        first.damping_ratio,
        ranges,
        axis,
        frozenset().union(*(row.by_key for row in rows)),
    )


def _common(rows: Sequence[LedgerRow], name: str) -> float | None:
    """What all rows have of a field; None where they differ."""
    values = {getattr(row, name) for row in rows}
    return values.pop() if len(values) == 1 else None


def is_figure(name: str, value: float | None) -> bool:
    """Whether a field can have a value: no limit is infinite, and anything else that is says nothing."""
    return value is None or math.isfinite(value) or (name in _BOUNDS and not math.isnan(value))


def _figure(name: str, figure: Figure) -> Figure:
    return figure if is_figure(name, figure.value) else replace(figure, value=None)


def _of_spec(actuator: JointActuator) -> Iterator[tuple[str, float | None]]:
    """What a spec says beyond the ledger."""
    for figure in BY_IR.values():
        if figure.role is Role.PASSIVE and figure.name not in _OF_ROW:
            quantity: Quantity | None = getattr(actuator, figure.ir)
            if quantity is not None:
                yield figure.name, quantity.value
    if actuator.curve is not None:
        for part in fields(actuator.curve):
            yield f"curve.{part.name}", getattr(actuator.curve, part.name).value
    if actuator.filter_cutoff is not None:
        yield "filter_cutoff", actuator.filter_cutoff.value
    if actuator.delay is not None and actuator.delay.low != actuator.delay.high:
        yield "delay_low", actuator.delay.low
        yield "delay_high", actuator.delay.high
    if actuator.encoder_bias.value:
        yield "encoder_bias", actuator.encoder_bias.value


def _of_model(
    view: JointView | None, drives: Sequence[ActuatorView]
) -> Iterator[tuple[str, float | None, Span | None]]:
    """What a model says beyond the ledger."""
    if view is not None and view.spring:
        yield "spring", view.spring, None
    for drive in drives:
        if drive.time_constant > 0.0 and "time_constant" not in drive.unknown:
            yield "filter_cutoff", 1.0 / (2.0 * math.pi * drive.time_constant), None
        gain = _command_gain(drive)
        if gain is not None:
            yield "command_gain", gain, drive.places.get("gainprm", drive.span)
        if drive.offset and _is_servo(drive):
            # A constant force of a servo is what a zero that is off makes of its stiffness.
            bias = -drive.offset * drive.gear / drive.kp
            yield "encoder_bias", bias, drive.places.get("biasprm", drive.span)


def _of_controls(drives: Sequence[ActuatorView]) -> Iterator[tuple[str, float, Span]]:
    """What a control of 1 does at the joint, with its sign: a motor's torque; of others the gear.

    A servo's target is divided by it, and its sign is the command gain's. Actuators of one kind that do
    not agree have no such figure together.
    """
    found: dict[str, dict[float, Span]] = {}
    for drive in drives:
        motor = drive.control == "motor"
        if drive.disabled or "gear" in drive.unknown or (motor and "gain" in drive.unknown):
            continue
        gear = abs(drive.gear) if _command_gain(drive) is not None else drive.gear
        name, value = ("torque_per_control", drive.gear * drive.gain) if motor else ("gear", gear)
        found.setdefault(name, {}).setdefault(value, drive.places.get("gear", drive.span))
    for name, places in found.items():
        if len(places) == 1:
            yield (name, *next(iter(places.items())))


def _command_gain(drive: ActuatorView) -> float | None:
    """Where a servo of a position settles over its target; None: there, or unknown.

    That is its gain over its stiffness, and on the other side of 0 where its gear is negative, which is all that is
    asked of a `dcmotor` and a `pid`. Source: MuJoCo 4.0, measured.
    """
    if not _is_servo(drive):
        return -1.0 if is_turned(drive) else None
    if "gain" in drive.unknown:
        return None
    settles = drive.gain * drive.gear * abs(drive.gear) / drive.kp
    return settles if math.isfinite(settles) and not same(settles, 1.0) else None


def is_turned(drive: ActuatorView) -> bool:
    """Whether an actuator is a servo of a position that goes to minus its target, because its gear is negative."""
    return drive.gear < 0.0 and _is_servo(drive, _SERVOS)


def _is_servo(drive: ActuatorView, kinds: Collection[str] = ("position",)) -> bool:
    """Whether it acts as a servo of a position, with a stiffness that is known."""
    known = drive.control in kinds and not {"kp", "gear"} & drive.unknown
    return known and not drive.disabled and drive.kp != 0.0


def levelled(joint: JointDynamics, other: JointDynamics) -> JointDynamics:
    """A joint with what no file states, where another's servo does not settle at its target.

    That is a command gain of 1; and an encoder bias of 0 where the other is a model's servo, which has all of its law.

    Args:
        joint: The joint as one file has it.
        other: As another has it.
    """
    kp = joint.figures.get("kp")
    if kp is None or not kp.value:
        return joint
    usual = {"command_gain": 1.0} | ({"encoder_bias": 0.0} if "position" in other.control.split("+") else {})
    missing = {
        name: replace(kp, value=value, unit=other.figures[name].unit)
        for name, value in usual.items()
        if name in other.figures and name not in joint.figures
    }
    return replace(joint, figures={**joint.figures, **missing}) if missing else joint


def _network(actuator: JointActuator) -> str | None:
    """What stands for a network: the hash of its bytes."""
    import hashlib

    if actuator.network is None:
        return None
    path = next(iter(network_paths(actuator.network).values()), None)
    try:
        return hashlib.sha256(read_regular(path or "", _MOST_NETWORK_BYTES)).hexdigest()
    except (OSError, ValueError, NotRegular, TooLarge):
        return actuator.network.name


def _links(row: LedgerRow) -> tuple[float, float] | None:
    """Inertia of the links alone."""
    if row.inertia_min is None or row.inertia_max is None:
        return None
    own = row.armature or 0.0
    return row.inertia_min - own, row.inertia_max - own


def _least_range(ranges: Sequence[tuple[float, float] | None]) -> tuple[float, float] | None:
    """The command range of a joint's first actuator that has one."""
    return next((ends for ends in ranges if ends is not None), None)


def _loose(artifact: Artifact) -> Iterator[JointDynamics]:
    """What drives a tendon, site or body, with its figures at the transmission, in units that the file knows."""
    if artifact.robot is None:
        return
    for drive in artifact.robot.actuators:
        if drive.is_direct:
            continue
        values: dict[str, float | None] = {
            name: None if name in drive.unknown else value
            for name, value in (("kp", drive.kp), ("kd", drive.kd))
        }
        gain = _command_gain(drive)
        if gain is not None:
            values["command_gain"] = gain
        if drive.force_range is not None:
            values["effort_limit"] = abs(drive.gear) * max(abs(end) for end in drive.force_range)
        figures = {name: Figure(value, "", drive.span, True) for name, value in values.items()}
        if drive.transmission == "tendon":
            # The first number of a site's gear is one of six.
            figures.update((name, Figure(value, "", at, False)) for name, value, at in _of_controls([drive]))
        name = f"actuator {drive.name or drive.index}"
        yield JointDynamics(name, drive.control, drive.span, figures)
