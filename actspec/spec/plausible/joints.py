"""Checks of what a spec gives at its robot's joints: pose, inertia, gains, friction, action scale."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from actspec.diagnostics import Collector, Diagnostic, Path, Span, dotted
from actspec.fields import GRAVITY, LONGEST_LEVER
from actspec.ir import Command, JointActuator, JointKind, Origin, Quantity
from actspec.spec.document import Document, SourceMap
from actspec.spec.models import SpecModel
from actspec.spec.plausible import number_doubts
from actspec.spec.plausible.armatures import armature_found, beside, odd_armature_found
from actspec.spec.plausible.clamps import TURN, clamp_words, turned_words
from actspec.spec.plausible.drive import Drive
from actspec.spec.plausible.driven import AGREES, FASTEST_SLIDE, unreached_limit
from actspec.spec.plausible.gains import Gains, gain_words
from actspec.spec.plausible.groups import friction_words, reduction_of
from actspec.spec.plausible.motors import FASTEST_BY_TORQUE
from actspec.spec.plausible.relations import DEGREE, RPM
from actspec.spec.plausible.repairs import misread_speeds
from actspec.spec.plausible.table import (
    BY_CODE,
    Doubt,
    Found,
    by_number,
    found_at,
    in_file,
    is_stated,
    shown,
    tell,
)
from actspec.spec.plausible.witnesses import witnessed
from actspec.units import format_quantity

VISCOUS_SHARE = 0.5
"""Of the effort limit, at the motor's no-load speed; as rule FRC106 of the audit."""
UNREACHED = 3.0
"""The same where no torque-speed line acts: a belt takes 1.24 at a speed that it never comes near."""
WHOLE = 1.0
"""The same at a velocity limit."""
POSE_TOLERANCE = {JointKind.HINGE: 0.05, JointKind.SLIDE: 0.005}
"""A default position may be this far beyond the range [rad or m]."""
SOFT = 6.0
"""Natural frequency [rad/s]: noticed where the limit needs an error above `SOFT_ERROR`."""
SOFT_ERROR = 10.0
"""[rad]."""
TOO_SOFT = 1.0
STIFF = 150.0
"""Natural frequency [rad/s]: noticed where the limit needs an error below `STIFF_ERROR`."""
STIFF_ERROR = 0.06
"""[rad]."""
STIFF_LINK = 1e-3
"""Joints of less are fingers, which are stiff for their inertia [kg*m^2]."""
DAMPING_RATIO = (0.015, 60.0)
"""kd and viscous friction over 2 sqrt(kp I)."""
SCALE = 2.0
"""One unit of action over the joint's range and, by kp, over the effort limit."""
USUAL_SHARE = 0.25
"""Of the effort limit that one unit of action asks for by kp: mjlab computes scales so."""
RATE_SCALE = 10.0
"""One unit of action over the fastest speed or the effort limit."""
FASTEST_LIMIT = 200.0
"""Velocity limit of a hinge [rad/s]. Published: to 200 (gripper of the reBot), 110 at 26 N*m (Qinglong)."""
WHOLE_ROBOT = 6
"""Hinges from which on a model is a robot: a test stand has a strong motor and a light link."""
HOPELESS_LEVER = 10.0
HOPELESS_SCALE = 20.0
"""An error from this many times the bound on."""

_OF_INERTIA = frozenset(("SPEC191", "SPEC192"))
"""Checks that need the inertia of a compiled model."""
_TO_INERTIA = frozenset(("gear_ratio", "side", "rotor_inertia", "reflected_inertia", "reduction"))
"""Figures of a motor from which the inertia at its joint follows."""


def check_joints(
    joints: Sequence[JointActuator],
    model: SpecModel,
    document: Document,
    collector: Collector,
    mass: float | None,
) -> None:
    """Report the numbers that can hardly be right at the joints of the robot, each once, at its worst joint.

    Args:
        joints: The resolved spec.
        model: The spec.
        document: Where it says what it says.
        collector: Takes warnings, and errors where nothing could be right.
        mass: Of the robot [kg]; None: unknown.
    """
    # What the spec alone implies is judged again, beside the limits of the robot's file.
    collector.forget(BY_CODE)
    levers = _levers(joints, model, mass)
    strong = {f"actuators.{joint.group}" for joint in joints if levers[joint.joint]}
    # Gains that are judged by a wrong limit say nothing.
    doubts = [
        doubt
        for doubt in number_doubts(model, document, joints)
        if doubt.code != "SPEC192" or strong.isdisjoint(_sections([doubt.diagnostic]))
    ]
    tell(doubts, document, model.accept, collector)
    # What follows from a number is not told when the author is sure of that: else each `sure` brings the next.
    found = {doubt.diagnostic for doubt in doubts}
    # Where dry friction contradicts a limit, either may be wrong: what else is judged by it says no more.
    rubbed = {span for doubt in doubts if doubt.code == "FRC101" for span in doubt.judged}
    drives = {drive.name: drive for drive in witnessed(joints, model, document.spans)}
    told = _joint_doubts_of(joints, model, drives, found, rubbed, levers, document.spans)
    tell(by_number(told), document, model.accept, collector)
    kept = {key: code for key in model.accept if (code := key.partition(".")[2]) in BY_CODE}
    # Another variant may need what this one does not.
    if kept and not model.variants:
        _check_kept(kept, joints, model, document, collector, mass)


def doubted_drives(joints: Iterable[JointActuator], diagnostics: Iterable[Diagnostic]) -> frozenset[str]:
    """Joints of which a gain, or what their inertia follows from, is reported: their stability says nothing."""
    sections = _sections(
        item
        for item in diagnostics
        if item.code in _OF_INERTIA or (item.code in BY_CODE and item.where.rpartition(".")[2] in _TO_INERTIA)
    )
    return frozenset(
        joint.joint
        for joint in joints
        if not sections.isdisjoint((f"actuators.{joint.group}", f"motors.{joint.motor}"))
    )


def _sections(diagnostics: Iterable[Diagnostic]) -> set[str]:
    """The motors and groups that they are about: `motors.hip`."""
    return {".".join(item.where.split(".")[:2]) for item in diagnostics}


def _check_kept(
    kept: Mapping[str, str],
    joints: Sequence[JointActuator],
    model: SpecModel,
    document: Document,
    collector: Collector,
    mass: float | None,
) -> None:
    """Warn of a check whose findings `accept` keeps, and which finds nothing; `kept` has its code by the key there."""
    every = Collector()
    bare = model.model_copy(update={"accept": {}})
    check_joints(joints, bare, document, every, mass)
    found = {item.code for item in every}
    if any(joint.inertia_held is None for joint in joints):
        # The text of a model does not tell inertia.
        found |= _OF_INERTIA
    for key, code in kept.items():
        if code not in found:
            collector.at(f"accept.{key}", document.spans.key(("accept", key))).warning(
                "SPEC164", f"{code} finds nothing in this spec: nothing is kept by it", "remove it"
            )


def _linked(model: SpecModel) -> dict[str, str]:
    """Joint to the linkage that drives it."""
    return {joint: name for name, linkage in model.linkages.items() for joint in linkage.joints}


def _levers(
    joints: Sequence[JointActuator], model: SpecModel, mass: float | None
) -> dict[str, Sequence[Found]]:
    """What is found of each joint's limit by the weight of the whole robot."""
    linked = _linked(model)
    whole = mass if sum(joint.kind is JointKind.HINGE for joint in joints) >= WHOLE_ROBOT else None
    return {joint.joint: tuple(_lever(joint, whole, linked.get(joint.joint))) for joint in joints}


def _joint_doubts_of(
    joints: Sequence[JointActuator],
    model: SpecModel,
    drives: Mapping[str, Drive],
    told: Collection[Diagnostic],
    rubbed: Collection[Span | None],
    levers: Mapping[str, Sequence[Found]],
    spans: SourceMap,
) -> Iterator[Found]:
    """What is found at the joints, but for what follows from numbers that are found already, reported or kept."""
    reported = _sections(told)
    gained = _sections(item for item in told if item.code == "SPEC192")
    parts = (re.split(r"[.\[]", item.where) for item in told)
    reduced = {".".join(part[:2]) for part in parts if {"reduction", "transmission"}.intersection(part)}
    places = {item.span for item in told}.union(rubbed)
    linked = _linked(model)
    # A motor's torque that is none too large at other joints is not what is wrong, but what reduces it here.
    sound = {joint.effort_limit.span for joint in joints if not levers[joint.joint]}
    for joint in joints:
        linkage = linked.get(joint.joint)
        lever = levers[joint.joint]
        for found in (*lever, *_viscous(joint, drives), *_joint_doubts(joint, joints)):
            doubt = found.doubt
            reduction = reduction_of(joint.group, model.actuators[joint.group])
            if doubt.code == "SPEC183" and reduction is not None and doubt.span in sound:
                yield replace(found, doubt=_of_reduction(doubt, *reduction, spans))
                continue
            if lever and joint.effort_limit.span in doubt.judged:
                # What is judged by a wrong limit says nothing.
                continue
            doubtful = f"motors.{joint.motor}" in reported or f"actuators.{joint.group}" in reduced
            doubtful |= f"linkages.{linkage}" in reported
            if (found.derived and doubtful) or not places.isdisjoint((doubt.span, *doubt.judged)):
                # It follows from a number that is found itself.
                continue
            if doubt.code == "SPEC192" and f"actuators.{joint.group}" in gained:
                # A derivation's frequency or ratio, or the same two gains by other words.
                continue
            yield found


def _joint_doubts(joint: JointActuator, joints: Sequence[JointActuator]) -> Iterator[Found]:
    for check in (_pose, _command_range, _scale, _velocity, unreached_limit):
        yield from check(joint)
    yield from _friction(joint, joints)
    inertia = list(armature_found(joint)) or list(odd_armature_found(joint, joints))
    # With a wrong inertia gains say nothing.
    yield from inertia or _gains(joint)


def _pose(joint: JointActuator) -> Iterator[Found]:
    """A default position outside of the range (published: to 0.02 rad, a B2), or beyond a turn if it has none."""
    pose = joint.default_position
    if pose.value is None or pose.origin is not Origin.AUTHORED:
        return
    if joint.position_range is None:
        if joint.kind is JointKind.HINGE and abs(pose.value) > TURN + POSE_TOLERANCE[joint.kind]:
            turns = format_quantity(abs(pose.value) / TURN, "turns", 3)
            message = f"the default position {shown(pose)} is {turns} from the joint's zero"
            help = f"is it in degrees? Then write {pose.value:g} deg, {format_quantity(pose.value * DEGREE, 'rad', 4)}"
            doubt = Doubt("SPEC190", message, "robot.default_pose", pose.span, help)
            yield Found(doubt, joint.joint, abs(pose.value))
        return
    found = _outside(joint.joint, joint.kind, joint.position_range, pose.value, pose.span)
    if found is not None:
        yield found


def _outside(
    joint: str, kind: JointKind, limits: tuple[float, float], pose: float, span: Span | None
) -> Found | None:
    """A position beyond the range."""
    (low, high), tolerance = limits, POSE_TOLERANCE[kind]
    beyond = max(low - pose, pose - high)
    if beyond <= tolerance:
        return None
    help = None
    unit = "rad" if kind is JointKind.HINGE else "m"
    # No joint but a wheel turns further, so that it may be the sign.
    turned = kind is JointKind.HINGE and abs(pose) > math.pi
    if low <= -pose <= high and not turned:
        help = f"is the sign wrong? {format_quantity(-pose, unit)} is inside"
        if kind is JointKind.HINGE:
            help += f", {-pose / DEGREE:.4g} deg"
    elif kind is JointKind.HINGE and low - tolerance <= pose * DEGREE <= high + tolerance:
        help = f"is it in degrees? Then write {pose:g} deg, {format_quantity(pose * DEGREE, unit, 4)}"
    elif kind is JointKind.SLIDE and low - tolerance <= pose * 1e-3 <= high + tolerance:
        help = f"is {'the point wrong, or is ' * (low <= 0.1 * pose <= high)}it in mm? Then write {pose:g} mm"
    message = (
        f"the default position {format_quantity(pose, unit, 4)} is outside of the joint's range, "
        f"{format_quantity(low, unit, 4)} to {format_quantity(high, unit, 4)}"
    )
    error = beyond > (max(high - low, math.pi) if kind is JointKind.HINGE else high - low)
    doubt = Doubt("SPEC190", message, "robot.default_pose", span, help, error=error)
    return Found(doubt, joint, beyond, False)


def _command_range(joint: JointActuator) -> Iterator[Found]:
    """A clamp of commands of position that is many times as wide as the joint's range, or a range in degrees."""
    clamp, own, hinge = joint.command_range, joint.position_range, joint.kind is JointKind.HINGE
    if clamp is None or joint.command is not Command.POSITION or not is_stated(clamp[0]):
        return
    low, high = clamp[0].value, clamp[1].value
    if low is None or high is None or (own is None and not hinge):
        return
    words = turned_words((low, high)) if own is None else clamp_words((low, high), own, hinge)
    if words is None:
        return
    ratio, help = words
    far, unit = format_quantity(ratio, "", 3), clamp[0].unit
    message = (
        f"a command range of {format_quantity(low, unit, 4)} to {format_quantity(high, unit, 4)} is {far} "
    )
    if own is None:
        message += "turns wide"
    else:
        ends = " to ".join(format_quantity(end, unit, 4) for end in own)
        message += f"times as wide as the joint's range, {ends}"
    where = f"actuators.{joint.group}.command_range"
    yield found_at(joint, "SPEC190", where, max(ratio, 1.0 / ratio), message, help, clamp[0])


def _lever(joint: JointActuator, mass: float | None, linkage: str | None) -> Iterator[Found]:
    """An effort limit that would hold the whole robot on a lever which no robot has."""
    limit = joint.effort_limit
    if not mass or joint.kind is not JointKind.HINGE or not limit.value or not is_stated(limit):
        return
    if joint.motor is None:
        # It may be a toy: gymnasium's ant has 150 N*m and less than 1 kg.
        return
    lever = limit.value / (mass * GRAVITY)
    if not LONGEST_LEVER < lever < math.inf:
        return
    yield found_at(
        joint,
        "SPEC183",
        f"actuators.{joint.group}.effort_limit",
        lever,
        f"an effort limit of {shown(limit)} would hold the whole robot, {format_quantity(mass, 'kg', 3)}, on a lever "
        f"of {format_quantity(lever, 'm', 3)}",
        "look for a wrong unit, gear_ratio or side" + (f", or at the linkage '{linkage}'" if linkage else ""),
        limit,
        error=lever > HOPELESS_LEVER * LONGEST_LEVER,
    )


def _of_reduction(doubt: Doubt, path: Path, size: float, spans: SourceMap) -> Doubt:
    """What is told of a limit, told of the reduction that it comes by."""
    help = f"look at the reduction of {size:g}: it is turns of the motor's output in one turn of the joint"
    return replace(
        doubt, where=dotted(path), span=spans.value(path), help=help, judged=(doubt.span, *doubt.judged)
    )


def _friction(joint: JointActuator, joints: Sequence[JointActuator]) -> Iterator[Found]:
    """Dry friction against the effort limit, where one of the two is the motor's or the results'."""
    coulomb, limit = joint.friction_coulomb, joint.effort_limit
    if not coulomb.value or not limit.value or not (is_stated(coulomb) or is_stated(limit)):
        return
    place = limit.span if is_stated(coulomb) and is_stated(limit) else None
    known = in_file(*coulomb.lost)
    usual = None if known is None else known.value
    others = sorted(other.friction_coulomb.value or 0.0 for other in beside(joint, joints))
    if not usual and others:
        usual = others[len(others) // 2]
    words = friction_words(coulomb.value, coulomb.unit, limit.value, limit.unit, place, usual)
    if words is None:
        return
    message, help, error = words
    number, other, field = (
        (coulomb, limit, "friction.coulomb") if is_stated(coulomb) else (limit, coulomb, "effort_limit")
    )
    where = f"actuators.{joint.group}.{field}"
    yield found_at(
        joint, "FRC101", where, coulomb.value / limit.value, message, help, number, other, error=error
    )


def _viscous(joint: JointActuator, drives: Mapping[str, Drive]) -> Iterator[Found]:
    """Viscous friction at the end of the torque-speed line, whatever the level; published: to 0.43 (ANYmal D).

    Where no line acts also at a stated velocity limit; what the robot's file has as well is not mistyped.
    """
    viscous, limit = joint.friction_viscous, joint.effort_limit
    if not is_stated(viscous) or not viscous.value or not limit.value:
        return
    line = joint.no_load_speed if joint.curve is None else joint.curve.no_load_speed
    clamp, motors = joint.velocity_limit, _own_speed(joint) if line is None else line
    asked = [] if motors is None else [(motors, UNREACHED if line is None else VISCOUS_SHARE)]
    if line is None and clamp.value and is_stated(clamp) and not math.log10(clamp.value).is_integer():
        asked += [] if _is_files(viscous) else [(clamp, WHOLE)]
    takes = ((speed, viscous.value * (speed.value or 0.0), share * limit.value) for speed, share in asked)
    speed, torque, most = next((item for item in takes if item[1] >= item[2]), (clamp, 0.0, math.inf))
    if not torque:
        return
    lined = speed is not clamp
    message = (
        f"the viscous friction of {shown(viscous)} takes {format_quantity(torque, limit.unit, 3)} at the joint's "
        f"{'' if lined else 'velocity limit of '}{shown(speed)}, of an effort limit of {shown(limit)}"
    )
    # Any of them may be: a figure would be a guess.
    times = "times 57.3, " if joint.kind is JointKind.HINGE else ""
    help = f"is it in m{viscous.unit}, {times}or the point in the wrong place?"
    where, number, other = f"actuators.{joint.group}.friction.viscous", viscous, speed
    drive = drives.get(joint.motor or "")
    readings = [
        reading
        for reading in (misread_speeds(drive) if drive is not None and lined else ())
        if torque * reading.factor < most
    ]
    if readings:
        fast = "; or ".join(reading.help for reading in readings)
        known = in_file(*viscous.lost)
        own = 0.0 if known is None else known.value or 0.0
        if own / AGREES < viscous.value < own * AGREES or any(reading.likelier for reading in readings):
            # The robot's file has that friction, or the speed is odd by itself, too.
            where, number, other = dotted(readings[0].path), speed, viscous
            help = f"no_load_speed: {fast}. Or viscous ({viscous.span}): {help}"
        else:
            help = f"viscous: {help} Or no_load_speed ({speed.span}): {fast}"
        help = f"one of 2 numbers is wrong. {help}"
    elif lined:
        help += " The slope of the torque-speed line belongs to the motor, not to friction"
    yield found_at(joint, "FRC106", where, torque / limit.value, message, help, number, other, limit)


def _is_files(quantity: Quantity) -> bool:
    """Whether the robot's file says a number as well."""
    said = in_file(*quantity.lost)
    return (
        said is not None
        and said.value is not None
        and math.isclose(said.value, quantity.require(), rel_tol=0.01)
    )


def _own_speed(joint: JointActuator) -> Quantity | None:
    """Speed at the joint [rad/s or m/s] at which its motor has no torque left, at whichever level; None: unknown."""
    line = joint.motor_line
    return None if line is None else line.no_load_speed if line.curve is None else line.curve.no_load_speed


def _gains(joint: JointActuator) -> Iterator[Found]:
    """kp and kd by natural frequency and damping ratio."""
    kp, kd, held, limit = joint.kp, joint.kd, joint.inertia_held, joint.effort_limit
    if (
        kp is None
        or not kp.value
        or not (is_stated(kp) or is_stated(kd))
        or joint.command is not Command.POSITION
    ):
        return
    number, other = (kp, kd) if is_stated(kp) and kp.span is not None else (kd, kp)
    assert number is not None
    active = (kd.value if kd is not None else None) or 0.0
    hinge = joint.kind is JointKind.HINGE
    gains = Gains(
        kp.value,
        active,
        joint.friction_viscous.value or 0.0,
        limit.value if hinge else None,
        joint.motor is not None,
        "N*m" if hinge else "N",
    )
    alone = gain_words(gains)
    words: tuple[str, str | None, float] | None = None
    if alone is not None:
        words = (alone[1], alone[2], abs(math.log(max(active, 1e-9) / kp.value)))
        if alone[0] == "kd" and kd is not None and is_stated(kd):
            number, other = kd, kp
    elif (
        joint.motor is not None
        and held is not None
        and joint.kind is JointKind.HINGE
        and held.reference > 0.0
    ):
        # Without a motor they may be a simulator's own servos, of any stiffness.
        words = _by_frequency(kp, joint, held.reference, limit.value)
        if words is None and active and kd is not None and is_stated(kd):
            number, other = kd, kp
            words = _by_damping(kp, kd, joint, held.reference)
    if words is not None:
        message, help, size = words
        where = f"actuators.{joint.group}.{'kp' if number is kp else 'kd'}"
        others = (other, limit, joint.armature)
        yield found_at(joint, "SPEC192", where, size, message, help, number, *others)


def _by_frequency(
    kp: Quantity, joint: JointActuator, inertia: float, limit: float | None
) -> tuple[str, str, float] | None:
    """Message, help and size where the natural frequency is no joint's."""
    stiffness = kp.require()
    frequency = math.sqrt(stiffness / inertia)
    error = None if limit is None else limit / stiffness
    message = (
        f"kp {shown(kp)} makes {format_quantity(frequency, 'rad/s', 3)} of the joint's "
        f"{format_quantity(inertia, 'kg*m^2', 3)}"
    )
    if error is not None:
        message += f", and needs an error of {format_quantity(error, 'rad', 3)} for the effort limit"
    if frequency < TOO_SOFT or (frequency < SOFT and error is not None and error > SOFT_ERROR):
        degrees = format_quantity(stiffness / DEGREE, kp.unit, 4)
        help = f"is it per degree? Per radian it is {degrees}, and kd 57.3 times as well"
        armature = joint.armature
        links = inertia - (armature.value or 0.0)
        if armature.origin is Origin.DERIVED and stiffness > SOFT**2 * links:
            help += f". Or is a gear too large? {shown(armature)} of the inertia is the armature: {armature.formula}"
        return message, help, 1 / frequency
    tight = error is not None and error < STIFF_ERROR
    if inertia >= STIFF_LINK and frequency > STIFF and tight:
        radians = format_quantity(stiffness * DEGREE, kp.unit, 4)
        return message, f"is it multiplied by 57.3? Without that it is {radians}", frequency
    return None


def _by_damping(
    kp: Quantity, kd: Quantity, joint: JointActuator, inertia: float
) -> tuple[str, str, float] | None:
    """Message, help and size where the damping ratio is no joint's."""
    damping = kd.require() + (joint.friction_viscous.value or 0.0)
    ratio = damping / (2.0 * math.sqrt(kp.require() * inertia))
    if DAMPING_RATIO[0] <= ratio <= DAMPING_RATIO[1]:
        return None
    message = (
        f"kd {shown(kd)} beside kp {shown(kp)} gives a damping ratio of {format_quantity(ratio, '', 2)} with the "
        f"joint's {format_quantity(inertia, 'kg*m^2', 3)}"
    )
    per = "per degree? Per radian it is " if ratio < 1 else "multiplied by 57.3? Without that it is "
    meant = kd.require() / DEGREE if ratio < 1 else kd.require() * DEGREE
    return message, f"is kd {per}{format_quantity(meant, kd.unit, 4)}", max(ratio, 1 / ratio)


def _velocity(joint: JointActuator) -> Iterator[Found]:
    """A velocity limit beyond any joint's, where no motor's speed stands: with one it is judged by that.

    What the robot's file says as well is not mistyped, and powers of ten are placeholders.
    """
    limit, force, own = joint.velocity_limit, joint.effort_limit, _own_speed(joint)
    fast = limit.value
    if own is not None and own.value:
        return
    if not fast or limit.origin is not Origin.AUTHORED or math.log10(fast).is_integer():
        return
    if _is_files(limit):
        return
    hinge = joint.kind is JointKind.HINGE
    strong = force.value if hinge and force.value and force.value < math.inf else 0.0
    most = FASTEST_BY_TORQUE / math.sqrt(strong) if strong else math.inf
    if fast <= min(most, FASTEST_LIMIT if hinge else FASTEST_SLIDE):
        return
    words = f"a velocity limit of {shown(limit)}"
    if fast > most:
        power = f"{strong * fast / 1000.0:.3g} kW"
        words += f" is {power} beside the effort limit of {shown(force)}: no joint of such a torque is nearly as fast"
    else:
        words += f": the fastest {joint.kind.value}s of robots have {'200 rad/s' if hinge else '10 m/s'}"
    slips = [(DEGREE, "deg/s"), (RPM, "rpm")] if hinge else [(1e-3, "mm/s")]
    usual = 50.0 if hinge else 5.0
    readings = [
        f"is it in {unit}? Then it is {format_quantity(fast * factor, limit.unit, 4)}"
        for factor, unit in slips
        if fast * factor <= min(0.5 * most, usual)
    ]
    yield found_at(
        joint,
        "SPEC184",
        f"actuators.{joint.group}.velocity_limit",
        fast,
        words,
        "; or ".join(readings) or "look for a wrong unit",
        limit,
        force if fast > most else None,
    )


def _scale(joint: JointActuator) -> Iterator[Found]:
    """One unit of action against range, speed and effort limit; published: 0.41 of the range, 0.75 of the limit."""
    scale, limit = joint.action_scale, joint.effort_limit
    if scale is None or not scale.value:
        return
    reach = abs(scale.value)
    if joint.command is Command.POSITION:
        span = None if joint.position_range is None else joint.position_range[1] - joint.position_range[0]
        if span is None and joint.kind is JointKind.HINGE:
            span = 2.0 * math.pi
        torque = None if joint.kp is None or not joint.kp.value else joint.kp.value * reach
        if not span or reach <= SCALE * span:
            return
        if torque is not None and limit.value and torque <= SCALE * limit.value:
            return
        size, unit = reach / span / SCALE, joint.default_position.unit
        words = (
            f"one unit of action is {format_quantity(reach, unit, 4)} of command, "
            f"{format_quantity(reach / span, '', 3)} times the joint's whole range"
        )
        if torque is not None and limit.value:
            words += f", and asks for {format_quantity(torque, limit.unit, 3)} of {shown(limit)}"
    else:
        speed = joint.no_load_speed if joint.curve is None else joint.curve.no_load_speed
        fast = speed if speed is not None and speed.value else joint.velocity_limit
        most = fast if joint.command is Command.VELOCITY else limit
        if not most.value or reach <= RATE_SCALE * most.value:
            return
        size = reach / most.value / RATE_SCALE
        words = f"one unit of action is {format_quantity(reach, most.unit, 4)} of command, the joint has {shown(most)}"
    readings = [(0.01, "is it in %")] if size >= 5.0 else []
    if joint.command is Command.POSITION and joint.kind is JointKind.HINGE:
        readings.insert(0, (DEGREE, "is it in degrees"))
        if joint.kp is not None and joint.kp.value and limit.value:
            share = joint.kp.value * reach / limit.value
            readings.sort(key=lambda reading: abs(math.log(share * reading[0] / USUAL_SHARE)))
    help = "; or ".join(f"{asked}? Then write {scale.value * factor:.6g}" for factor, asked in readings)
    yield found_at(
        joint,
        "SPEC193",
        f"actuators.{joint.group}.action_scale",
        size,
        words,
        help or None,
        scale,
        joint.kp,
        error=size >= HOPELESS_SCALE,
    )
