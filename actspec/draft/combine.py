"""One robot as several files have it, put together: which file says what, and where they disagree.

Each number is that of the first file that states it, in this order: training configurations, deploy files,
then the robot file that the training reads (the URDF for Isaac Lab and legged_gym, else the MJCF), then the
other one. A drive (command, gains, torque-speed line) is taken whole from the first file that has one.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

from actspec.draft.deploy_lists import lists_of, with_reasons
from actspec.draft.ranges import with_ranges
from actspec.draft.sources import RobotReading, keyed, robot_name, source_keys, sources_of, stated
from actspec.fields import BY_IR, Role
from actspec.ir import (
    ActuatorSet,
    Command,
    Delay,
    JointActuator,
    JointKind,
    Level,
    Quantity,
    whole_steps,
)
from actspec.lift.lifted import LeftAlone
from actspec.readings.artifact import FileKind, Framework
from actspec.readings.compare import COPIED, same
from actspec.robot.view import joints_above

NO_DRIVE = "what drives it is not stated"
"""Why a joint without a drive is left alone where others have one."""

_DRIVE = ("kp", "kd", "stall_torque", "no_load_speed")
"""What only a file with the same kind of drive says."""

_OWN_WAY = ("friction_static", "delay")
"""What is put together in a way of its own: with the dry friction, with its range."""
_PASSIVE = (
    *("peak_torque", "continuous_torque", "reflected_inertia"),
    *(ir for ir, field in BY_IR.items() if "." not in ir and ir not in (*_DRIVE, *_OWN_WAY)),
)
"""What any file may say, whoever drives the joint."""


@dataclass(frozen=True, slots=True)
class Disagreement:
    """A field that two files give differently.

    Attributes:
        field: Its name in a spec.
        joints: For which joints.
        taken: What the spec gets.
        lost: What another file says.
    """

    field: str
    joints: tuple[str, ...]
    taken: Quantity
    lost: Quantity


@dataclass(frozen=True, slots=True)
class Combined:
    """A robot out of one or more files.

    Attributes:
        actuators: One entry a joint that a spec can describe; `source` of each number is a key of `sources`,
            `lost` what other files say otherwise.
        left_alone: The other hinges and slides.
        notes: Joint to remarks; "": on the whole robot.
        disagreements: Every field that two files give differently.
        model: The robot file that the spec is to name; None: there is none.
        kinds: What the files are.
        names: All hinges and slides, in the robot's order.
        above: Joint to those between it and the base, where a robot file says so.
    """

    actuators: ActuatorSet
    left_alone: tuple[LeftAlone, ...] = ()
    notes: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    disagreements: tuple[Disagreement, ...] = ()
    model: RobotReading | None = None
    kinds: tuple[FileKind, ...] = ()
    names: tuple[str, ...] = ()
    above: Mapping[str, frozenset[str]] = field(default_factory=dict)

    def reasons(self) -> dict[str, tuple[str, ...]]:
        """Reason to the joints that are left alone for it; those that follow many joints have one in common."""
        found: dict[str, list[LeftAlone]] = {}
        for item in self.left_alone:
            found.setdefault(item.kind or item.why, []).append(item)
        return {
            items[0].why if len({item.why for item in items}) == 1 else kind: tuple(i.joint for i in items)
            for kind, items in found.items()
        }


def combine(readings: Sequence[RobotReading]) -> Combined:
    """Put the files of one robot together.

    Args:
        readings: At least one; of one robot.
    """
    model = next(
        (r for kind in (FileKind.MJCF, FileKind.URDF) for r in readings if r.kind is kind),
        None,
    )
    keys = source_keys(readings)
    # An environment lends the robot what may stand in a base of its own.
    files = {file: keys[r.path] for r in readings if r.path in keys for file in r.includes} | keys
    ranked = [keyed(reading, files) for reading in in_order(readings)]
    every = [(r.kind, joint) for r in ranked for joint in r.lifted.actuators.joints]
    # Gains that a configuration has and that could not be read are no torque motor's.
    drives = frozenset(id(joint) for kind, joint in every if kind is FileKind.CFG or _has_drive(joint))
    # Gains for the robot say nothing of the motor that a simulator has behind them.
    deploy = frozenset(id(joint) for kind, joint in every if kind is FileKind.DEPLOY)
    base = next((r for r in ranked if model is not None and r.path == model.path), None)
    order = _joint_order(ranked, base)
    alone = _left_alone(ranked, base, order, drives)
    lists = {field: one for r in reversed(ranked) for field, one in lists_of(r.artifact.config).items()}
    joints = []
    ranges: dict[str, tuple[str, ...]] = {}
    for name in order:
        said = [j for r in ranked for j in r.lifted.actuators.joints if j.joint == name]
        if name in alone or not said:
            continue
        if drives and not any(id(joint) in drives for joint in said):
            alone[name] = _reason(ranked, name) or LeftAlone(name, NO_DRIVE, said[0].span, undriven=True)
            continue
        joint, remarks = with_ranges(with_reasons(_joint(said, drives, deploy), lists), said)
        joints.append(joint)
        ranges[name] = remarks
    sets = [reading.lifted.actuators for reading in ranked]
    step = _first([actuators.physics_dt for actuators in sets])
    assert step is not None
    control = _first([_control_dt(actuators) for actuators in sets])
    actuators = ActuatorSet(
        robot=robot_name(base or _named_by(ranked)),
        joints=tuple(joints),
        unmanaged=tuple(name for name in order if name in alone),
        physics_dt=step,
        decimation=whole_steps(
            None if control is None else control.value, step.value if stated(step) else None
        ),
        control_dt=control,
        delta_action=next((s.delta_action for s in sets if s.delta_action is not None), None),
        sources=tuple(sources_of(readings, keys, sets)),
    )
    left = tuple(alone[name] for name in order if name in alone)
    return Combined(
        actuators,
        left,
        _notes(ranked, actuators, ranges),
        tuple(_disagreements(actuators)),
        model,
        tuple(reading.kind for reading in readings),
        tuple(order),
        {} if base is None else _above(base),
    )


def _named_by(ranked: Sequence[RobotReading]) -> RobotReading:
    """The file that names a robot without a model: of configurations the robot's own, not an environment's."""
    alike = [reading for reading in ranked if reading.kind is ranked[0].kind]
    configs = [(reading, reading.artifact.config) for reading in alike]
    own = (r for r, config in configs if config and any(g.span.path == r.path for g in config.groups))
    return next(own, ranked[0])


def in_order(readings: Sequence[RobotReading]) -> list[RobotReading]:
    """The files in the order in which they are believed."""
    frameworks = {r.framework for r in readings if r.kind is FileKind.CFG}
    from_urdf = frameworks & {Framework.ISAACLAB, Framework.LEGGED_GYM} and Framework.MJLAB not in frameworks
    robots = [FileKind.MJCF, FileKind.URDF]
    rank = [FileKind.CFG, FileKind.DEPLOY, *(reversed(robots) if from_urdf else robots)]
    return sorted(readings, key=lambda r: rank.index(r.kind) if r.kind in rank else len(rank))


def _has_drive(joint: JointActuator) -> bool:
    """Whether a file says what drives a joint."""
    return (
        joint.command is Command.EFFORT
        or joint.level is Level.ACTUATOR_NET
        or any(gain is not None and gain.known for gain in (joint.kp, joint.kd))
    )


def _joint_order(ranked: Sequence[RobotReading], base: RobotReading | None) -> list[str]:
    """Names of the robot file's joints in its order; without one, of all files."""
    if base is not None:
        robot = base.artifact.robot
        if robot is not None:
            return [joint.name for joint in robot.scalar_joints]
        ranked = [base]
    names: dict[str, None] = {}
    for reading in ranked:
        names.update(dict.fromkeys(joint.joint for joint in reading.lifted.actuators.joints))
        names.update(dict.fromkeys(item.joint for item in reading.lifted.left_alone))
    return list(names)


def _above(reading: RobotReading) -> dict[str, frozenset[str]]:
    """Each joint of a robot file with those between it and the base, which a free joint is one with."""
    robot = reading.artifact.robot
    if robot is None:
        return {}
    free = {joint.name for joint in robot.joints if joint.kind is JointKind.FREE}
    return {name: chain for name, chain in joints_above((robot,)).items() if name not in free}


def _left_alone(
    ranked: Sequence[RobotReading], base: RobotReading | None, order: Sequence[str], drives: frozenset[int]
) -> dict[str, LeftAlone]:
    """Joints that a file gives a reason to leave alone, the spec's own robot file first.

    What the robot file cannot say no other file mends; a joint that it merely does not drive, another may.
    """
    found: dict[str, LeftAlone] = {}
    every = [joint for r in ranked for joint in r.lifted.actuators.joints]
    said, driven = {j.joint for j in every}, {j.joint for j in every if id(j) in drives}
    for reading in ([base] if base is not None else []) + [r for r in ranked if r is not base]:
        for item in reading.lifted.left_alone:
            if item.joint not in order or item.joint in found:
                continue
            mended = item.joint in (driven if item.undriven else said if reading is not base else ())
            if not mended:
                found[item.joint] = item
    return found


def _reason(ranked: Sequence[RobotReading], joint: str) -> LeftAlone | None:
    """The first reason that a file has to leave a joint alone."""
    return next((item for r in ranked for item in r.lifted.left_alone if item.joint == joint), None)


def _joint(said: Sequence[JointActuator], drives: frozenset[int], deploy: frozenset[int]) -> JointActuator:
    """One joint out of what the files say of it, the most believed first.

    Args:
        said: At least one.
        drives: Identities of those that say what drives a joint.
        deploy: Identities of those from deploy files.
    """
    lead = next((joint for joint in said if id(joint) in drives), said[0])
    if id(lead) in deploy:
        lead = _with_line(lead, [j for j in said if id(j) in drives and id(j) not in deploy])
    alike = [joint for joint in said if joint.command is lead.command]
    numbers: dict[str, Quantity | None] = {}
    for name in _PASSIVE:
        numbers[name] = _first([getattr(joint, name) for joint in said])
    for name in _DRIVE:
        own = getattr(lead, name)
        fitting = [j for j in alike if name in ("kp", "kd") or j.level is lead.level]
        others = [getattr(joint, name) for joint in fitting if joint is not lead]
        numbers[name] = None if own is None else _first([own, *others])
    coulomb = numbers["friction_coulomb"]
    holder = next((j for j in said if coulomb is not None and j.friction_coulomb.span == coulomb.span), lead)
    return replace(
        lead,
        **numbers,  # type: ignore[arg-type]
        friction_static=holder.friction_static,
        delay=_delay([joint.delay for joint in said]),
        command_range=lead.command_range,
        position_range=next((j.position_range for j in said if j.position_range is not None), None),
        network=lead.network,
        inertia_held=next((j.inertia_held for j in said if j.inertia_held is not None), None),
        inertia_free=next((j.inertia_free for j in said if j.inertia_free is not None), None),
    )


def _with_line(lead: JointActuator, others: Sequence[JointActuator]) -> JointActuator:
    """Gains without a word of the motor, with the torque-speed line that the next drive of the same kind has."""
    other = next((joint for joint in others if joint.command is lead.command), None)
    if other is None or other.level is not Level.DC_MOTOR:
        return lead
    return replace(
        lead,
        level=other.level,
        stall_torque=other.stall_torque,
        no_load_speed=other.no_load_speed,
        curve=other.curve,
    )


def _first(candidates: Sequence[Quantity | None]) -> Quantity | None:
    """The first that a file states, those that differ recorded as lost; else a default; else unknown.

    What one file writes and nobody can read is unknown, whatever another assumes in its silence.
    """
    present = [item for item in candidates if item is not None]
    said = [item for item in present if stated(item)]
    if not said:
        unread = next((item for item in present if not item.known and item.span is not None), None)
        return unread or next((item for item in present if item.known), present[0] if present else None)
    winner, *others = said
    return winner.losing(*(other for other in others if not same(winner.value, other.value, COPIED)))


def _delay(delays: Sequence[Delay | None]) -> Delay | None:
    present = [delay for delay in delays if delay is not None]
    if not present:
        return None
    winner, *others = present
    within = [
        other.nominal
        for other in others
        if winner.nominal.known
        or (other.nominal.value is not None and winner.low <= other.nominal.value <= winner.high)
    ]
    nominal = _first([winner.nominal, *within])
    return winner if nominal is None else replace(winner, nominal=nominal)


def _control_dt(actuators: ActuatorSet) -> Quantity | None:
    """What one file says of the control period, itself or by steps of a time that it states, too."""
    own, step = actuators.control_dt, actuators.physics_dt
    if (own is not None and own.known) or actuators.decimation is None or not stated(step):
        return own
    return replace(step, value=step.require() * actuators.decimation, lost=())


def _disagreements(actuators: ActuatorSet) -> Iterator[Disagreement]:
    """Fields that two files give differently, the joints with the same figures together."""
    found: dict[tuple[object, ...], list[tuple[str, Quantity, Quantity]]] = {}
    named = [(j.joint, name, q) for j in actuators.joints for name, q in j.quantities()]
    control = () if actuators.control_dt is None else (("", "control_dt", actuators.control_dt),)
    for joint, name, taken in [*named, ("", "physics_dt", actuators.physics_dt), *control]:
        for lost in taken.lost if not joint or name in BY_IR else ():
            key = (name, taken.value, taken.source, lost.value, lost.source)
            found.setdefault(key, []).append((joint, taken, lost))
    for figures, entries in found.items():
        joints = tuple(joint for joint, _, _ in entries if joint)
        yield Disagreement(_word(str(figures[0])), joints, entries[0][1], entries[0][2])


def _word(name: str) -> str:
    """A number of the IR as the spec calls it."""
    field = BY_IR.get(name)
    if field is None:
        return name
    # Figures of a motor have one name for their loss, and keys of their own.
    return field.name if field.role is Role.LIMIT else field.spec


def _notes(
    ranked: Sequence[RobotReading], actuators: ActuatorSet, ranges: Mapping[str, tuple[str, ...]]
) -> dict[str, tuple[str, ...]]:
    """Remarks of all files, each with its file where there are several; of the whole robot each once.

    On a joint it is the file in which its group is written: an environment that imports a robot says the same of it.

    Args:
        ranked: The files.
        actuators: What they say.
        ranges: Joint to remarks on its ranges, which name their files.
    """
    managed = {joint.joint for joint in actuators.joints}
    files = {reading.path for reading in ranked}
    found: dict[str, dict[str, None]] = {}
    whole: set[str] = set()
    for reading in ranked:
        groups = () if reading.artifact.config is None else reading.artifact.config.groups
        written = {group.span.path for group in groups}
        home = written.pop() if len(written) == 1 and written <= files else reading.path
        for joint, remarks in reading.lifted.notes.items():
            if joint == "":
                remarks = tuple(text for text in remarks if text not in whole)
                whole.update(remarks)
            if joint == "" or joint in managed:
                start = f"{os.path.basename(home if joint else reading.path)}: " if len(ranked) > 1 else ""
                found.setdefault(joint, {}).update(dict.fromkeys(start + text for text in remarks))
    for joint, said in ranges.items():
        if said:
            found.setdefault(joint, {}).update(dict.fromkeys(said))
    return {joint: tuple(remarks) for joint, remarks in found.items()}
