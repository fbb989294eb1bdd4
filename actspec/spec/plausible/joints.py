"""Checks of what a spec gives at its robot's joints: pose, inertia, gains, friction, action scale."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

from actspec.diagnostics import Collector, Diagnostic, Path, Span, alternatives, dotted, listed
from actspec.fields import FRICTION_SHARE, is_power_of_ten
from actspec.ir import JointActuator, JointKind, Origin
from actspec.spec.document import Document, SourceMap
from actspec.spec.fields import DerivedGain
from actspec.spec.models import Motor, SpecModel
from actspec.spec.plausible.armatures import armature_found, beside, odd_armature_found
from actspec.spec.plausible.clamps import Poses, left_out_doubts, pose_found, poses_of
from actspec.spec.plausible.commands import command_range_found, own_speed, scale_found
from actspec.spec.plausible.draws import drawn_found
from actspec.spec.plausible.drive import Drive
from actspec.spec.plausible.driven import AGREES, UNREACHED, WINDING, given_at, unreached_limit
from actspec.spec.plausible.gains import blamed
from actspec.spec.plausible.groups import friction_words, layers, reduction_of, static_words, written_numbers
from actspec.spec.plausible.limits import levers_of, slow_found, velocity_found
from actspec.spec.plausible.numbers import number_doubts
from actspec.spec.plausible.relations import DEGREE, Repair
from actspec.spec.plausible.repairs import misread_lengths, misread_speeds
from actspec.spec.plausible.robots import odd_limit_found, other_unit_found
from actspec.spec.plausible.rubbing import likelier_gear, next_gear
from actspec.spec.plausible.servos import GEAR_TOO_LARGE, gains_found
from actspec.spec.plausible.slips import in_si
from actspec.spec.plausible.table import (
    BY_CODE,
    Doubt,
    Found,
    Kept,
    by_number,
    found_at,
    in_file,
    is_files,
    is_stated,
    kept_of,
    shown,
    tell,
)
from actspec.spec.plausible.witnesses import left_out_reduction, witnessed
from actspec.spec.values import SpecValue
from actspec.units import format_quantity

VISCOUS_SHARE = 0.5
"""Of the effort limit, at the motor's no-load speed; as rule FRC106 of the audit. Where no line acts: `UNREACHED`."""
WHOLE = 1.0
"""The same at a velocity limit."""
WHOLE_ROBOT = 6
"""Hinges from which on a model is a robot: a test stand has a strong motor and a light link."""
WHOLE_BODY = (4, 5.0)
"""Joints and mass [kg] from which on it is one that a slide may lift: a gripper alone, or a cylinder, has fewer."""

_OF_INERTIA = frozenset(("SPEC191", "SPEC192"))
"""Checks that need the inertia of a compiled model."""
_OF_NETWORKS = frozenset(("NET017", "NET018"))
"""Checks that need the files of networks."""
_CONSEQUENCES = frozenset(("SPEC193", "FRC106"))
"""Checks of action scale and viscous friction by limits, gains and friction: where one of those is found itself, they
say nothing, though the author is sure of it.
"""
_TO_INERTIA = frozenset(
    ("gear_ratio", "side", "rotor_inertia", "reflected_inertia", "reduction", "motors_per_joint")
)
"""Figures of a motor from which the inertia at its joint follows."""
_BETWEEN = frozenset(("reduction", "transmission", "motors_per_joint"))
"""What stands between a motor and its joints."""
_SIZES = ("_torque", ".no_load_speed")
"""Figures from which it does not."""


def check_joints(
    joints: Sequence[JointActuator],
    model: SpecModel,
    document: Document,
    collector: Collector,
    mass: float | None,
    keyframe: Mapping[str, float],
) -> None:
    """Report the numbers that can hardly be right at the joints of the robot, each once, at its worst joint.

    Args:
        joints: The resolved spec.
        model: The spec.
        document: Where it says what it says.
        collector: Takes warnings, and errors where nothing could be right.
        mass: Of the robot [kg]; None: unknown.
        keyframe: Positions in the first keyframe of the robot's file, by joint, as far as they are known [rad or m].
    """
    # What the spec alone implies is judged again, beside the limits of the robot's file.
    collector.forget(BY_CODE)
    kept = kept_of(document, model.accept)
    levers = _levers(joints, model, document.spans, mass, kept)
    strong = {f"actuators.{joint.group}" for joint in joints if levers[joint.joint]}
    # Gains that are judged by a wrong limit say nothing.
    doubts = [
        doubt
        for doubt in number_doubts(model, document, kept, joints)
        if doubt.code != "SPEC192" or strong.isdisjoint(_sections([doubt.diagnostic]))
    ]
    tell(doubts, kept, collector)
    # What follows from a number is not told when the author is sure of that: else each `sure` brings the next.
    # A size alone says nothing of other numbers.
    found = {doubt.diagnostic for doubt in doubts if doubt.code != "SPEC183" or not kept.has(doubt)}
    # Where dry friction contradicts a limit, either may be wrong: what else is judged by it says no more.
    rubbed = {span for doubt in doubts if doubt.code == "FRC101" for span in doubt.judged}
    rubbed.update(span for doubt in doubts if doubt.diagnostic in found for span in doubt.blamed)
    drives = {drive.name: drive for drive in witnessed(joints, model, document.spans, kept)}
    poses = poses_of(model, joints, document.spans, keyframe, kept.sure)
    told = _joint_doubts_of(joints, model, poses, drives, found, rubbed, levers, document.spans, kept)
    tell([*by_number(told), *left_out_doubts(joints, poses)], kept, collector)
    accepted = {key: code for key in model.accept if (code := key.partition(".")[2]) in BY_CODE}
    # Another variant may need what this one does not.
    if accepted and not model.variants:
        _check_kept(accepted, joints, model, document, collector, mass, keyframe)


def forget_unfit(model: SpecModel, collector: Collector) -> None:
    """Take back what is judged by a number of the wrong kind of joint (RES001), of its group and of the group's motor.

    Args:
        model: The spec.
        collector: Has what was reported of it.
    """
    unfit = _sections(item for item in collector if item.code == "RES001")
    for path, fields, group in layers(model):
        ends = {".".join(map(str, path[:2])), f"motors.{fields.motor or group.motor}"}
        unfit |= ends if not unfit.isdisjoint(ends) else set()
    judged = (item for item in collector if item.code in BY_CODE and _sections([item]) <= unfit)
    collector.forget(BY_CODE, {item.where for item in judged})


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
    keyframe: Mapping[str, float],
) -> None:
    """Warn of a check whose findings `accept` keeps, and which finds nothing; `kept` has its code by the key there."""
    every = Collector()
    bare = model.model_copy(update={"accept": {}})
    check_joints(joints, bare, document, every, mass, keyframe)
    found = {item.code for item in every}
    if any(joint.inertia_held is None for joint in joints):
        # The text of a model does not tell inertia.
        found |= _OF_INERTIA
    if any(joint.network is not None for joint in joints):
        # They are read afterwards.
        found |= _OF_NETWORKS
    for key, code in kept.items():
        if code not in found:
            collector.at(f"accept.{key}", document.spans.key(("accept", key))).warning(
                "SPEC164", f"{code} finds nothing in this spec: nothing is kept by it", "remove it"
            )


def _linked(model: SpecModel) -> dict[str, str]:
    """Joint to the linkage that drives it."""
    return {joint: name for name, linkage in model.linkages.items() for joint in linkage.joints}


def _levers(
    joints: Sequence[JointActuator], model: SpecModel, spans: SourceMap, mass: float | None, kept: Kept
) -> dict[str, Sequence[Found]]:
    """What is found of each joint's limit by the weight of the whole robot, and by its other joints."""
    linked = _linked(model)
    whole = mass if sum(joint.kind is JointKind.HINGE for joint in joints) >= WHOLE_ROBOT else None
    body = mass if len(joints) >= WHOLE_BODY[0] and (mass or 0.0) >= WHOLE_BODY[1] else None
    return {
        joint.joint: [
            found
            for found in (
                list(levers_of(joint, whole, body, linked.get(joint.joint)))
                or odd_limit_found(joint, joints, model, spans)
            )
            if not kept.has(found.doubt)
        ]
        for joint in joints
    }


def _joint_doubts_of(
    joints: Sequence[JointActuator],
    model: SpecModel,
    poses: Poses,
    drives: Mapping[str, Drive],
    told: Collection[Diagnostic],
    rubbed: Collection[Span | None],
    levers: Mapping[str, Sequence[Found]],
    spans: SourceMap,
    kept: Kept,
) -> Iterator[Found]:
    """What is found at the joints, but for what follows from numbers that are found already, reported or kept."""
    # What is beyond any motor is the torque's matter: of gear and rotor it says nothing.
    reported = _sections(item for item in told if item.code != "SPEC183" or not item.where.endswith(_SIZES))
    gained = _sections(item for item in told if item.code == "SPEC192")
    parts = (re.split(r"[.\[]", item.where) for item in told)
    reduced = {".".join(part[:2]) for part in parts if _BETWEEN.intersection(part)}
    places = {item.span for item in told}.union(rubbed)
    linked, written = _linked(model), written_numbers(model, spans)
    # A motor's torque that is none too large at other joints is not what is wrong, but what reduces it here.
    sound = {joint.effort_limit.span for joint in joints if not levers[joint.joint]}
    every = {
        joint.joint: [
            *levers[joint.joint],
            *_viscous(joint, drives, written, spans, kept),
            *_joint_doubts(joint, joints, model, poses, written, drives, spans, kept),
        ]
        for joint in joints
    }
    shared = _held_torques(joints, every, spans, kept)
    yield from shared
    places.update(found.doubt.span for found in shared)
    causes = {
        one.doubt.span for found in every.values() for one in found if one.doubt.code not in _CONSEQUENCES
    }
    rubs = {one.doubt.span for found in every.values() for one in found if one.doubt.code == "FRC101"}
    for joint in joints:
        linkage = linked.get(joint.joint)
        lever = levers[joint.joint]
        for found in every[joint.joint]:
            doubt = found.doubt
            if doubt.code in _CONSEQUENCES and not causes.isdisjoint(doubt.judged):
                continue
            if doubt.code == "SPEC192" and not rubs.isdisjoint(doubt.judged):
                # What no drive overcomes says nothing of gains.
                continue
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
            yield (
                replace(found, doubt=_of_derivation(doubt, model, spans))
                if doubt.code == "SPEC192"
                else found
            )


def _held_torques(
    joints: Sequence[JointActuator], every: Mapping[str, Sequence[Found]], spans: SourceMap, kept: Kept
) -> list[Found]:
    """A motor's torque that the dry friction of several groups is not below: one mistake, and not one in each."""
    held: dict[Span, dict[Span | None, tuple[JointActuator, Found]]] = {}
    for joint in joints:
        limit = joint.effort_limit
        if limit.origin is Origin.DERIVED and limit.span is not None and limit.span not in kept.sure:
            rubbed = (found for found in every[joint.joint] if found.doubt.code == "FRC101")
            for found in rubbed:
                held.setdefault(limit.span, {}).setdefault(found.doubt.span, (joint, found))
    return [_held(span, list(found.values()), spans) for span, found in held.items() if len(found) > 1]


def _held(span: Span, rubbed: Sequence[tuple[JointActuator, Found]], spans: SourceMap) -> Found:
    """What several dry frictions say of the torque that is written there."""
    parts = [
        f"{shown(joint.friction_coulomb)} at {joint.joint} ({found.doubt.span}) of {shown(joint.effort_limit)}"
        for joint, found in rubbed
    ]
    joint, found = rubbed[0]
    paths: list[Path] = [
        ("motors", str(joint.motor), f"{word}_torque") for word in ("peak", "continuous", "stall")
    ]
    doubt = replace(
        found.doubt,
        where=next((dotted(path) for path in paths if spans.value(path) == span), f"motors.{joint.motor}"),
        span=span,
        message=f"dry friction takes too much of what the motor '{joint.motor}' gives: {listed(parts, 4)}",
        help="look for a wrong unit or power of ten here. Or are the frictions in another unit?",
        judged=tuple(other.doubt.span for _, other in rubbed),
        error=any(other.doubt.error for _, other in rubbed),
    )
    return replace(found, doubt=doubt)


def _of_derivation(doubt: Doubt, model: SpecModel, spans: SourceMap) -> Doubt:
    """A doubt about a gain; of a derived one it is told of what it is derived by."""
    field = doubt.where.rpartition(".")[2]
    for path, fields, _ in layers(model) if field in ("kp", "kd") else ():
        gain, place = getattr(fields, field), (*path, field)
        if isinstance(gain, DerivedGain) and spans.value(place) == doubt.span:
            return blamed(gain, place, doubt, spans)
    return doubt


def _joint_doubts(
    joint: JointActuator,
    joints: Sequence[JointActuator],
    model: SpecModel,
    poses: Poses,
    written: Mapping[Span, SpecValue],
    drives: Mapping[str, Drive],
    spans: SourceMap,
    kept: Kept,
) -> Iterator[Found]:
    yield from pose_found(joint, written, poses)
    yield from command_range_found(joint, poses.place)
    yield from drawn_found(joint, model, spans)
    for check in (scale_found, velocity_found, _stribeck, unreached_limit):
        yield from check(joint)
    motor, alone = model.motors.get(joint.motor or ""), model.robot.model == "none"
    yield from slow_found(joint, motor)
    yield from other_unit_found(joint, joints, written)
    yield from left_out_reduction(joint, model, spans)
    yield from _friction(joint, joints, drives, spans, kept)
    inertia = list(armature_found(joint, motor, alone, written)) or list(odd_armature_found(joint, joints))
    # With a wrong inertia gains say nothing.
    gains = inertia or gains_found(joint)
    yield from gains if motor is None else (_at_gear(found, joint, motor, model, spans) for found in gains)


def _at_gear(found: Found, joint: JointActuator, motor: Motor, model: SpecModel, spans: SourceMap) -> Found:
    """What is asked of the gear of a joint, with where the gear is written, and the reduction behind it."""
    help = found.doubt.help or ""
    if GEAR_TOO_LARGE not in help:
        return found
    field = "gear_ratio" if motor.gearbox is None else "gearbox"
    places: list[Path] = [("motors", str(joint.motor), field)]
    reduction = reduction_of(joint.group, model.actuators[joint.group])
    places += [] if reduction is None else [reduction[0]]
    there = f"{GEAR_TOO_LARGE[:-1]} ({listed([str(spans.value(place)) for place in places], 2)})?"
    return replace(found, doubt=replace(found.doubt, help=help.replace(GEAR_TOO_LARGE, there)))


def _of_reduction(doubt: Doubt, path: Path, size: float, spans: SourceMap) -> Doubt:
    """What is told of a limit, told of the reduction that it comes by."""
    help = f"look at the reduction of {size:g}: it is turns of the motor's output in one turn of the joint"
    return replace(
        doubt, where=dotted(path), span=spans.value(path), help=help, judged=(doubt.span, *doubt.judged)
    )


def _friction(
    joint: JointActuator,
    joints: Sequence[JointActuator],
    drives: Mapping[str, Drive],
    spans: SourceMap,
    kept: Kept,
) -> Iterator[Found]:
    """Dry friction against the effort limit, where one of the two is the motor's or the results'."""
    coulomb, limit = joint.friction_coulomb, joint.effort_limit
    if not coulomb.value or not limit.value or not (is_stated(coulomb) or is_stated(limit)):
        return
    place = limit.span if is_stated(coulomb) and is_stated(limit) and limit.span not in kept.sure else None
    known = in_file(*coulomb.lost)
    usual = None if known is None else known.value
    others = sorted(other.friction_coulomb.value or 0.0 for other in beside(joint, joints))
    if not usual and others:
        usual = others[len(others) // 2]
    words = friction_words(coulomb.value, coulomb.unit, limit.value, limit.unit, place, usual)
    if words is None:
        yield from _static(joint, kept)
        return
    message, help, error = words
    number, other, field = (
        (coulomb, limit, "friction.coulomb") if is_stated(coulomb) else (limit, coulomb, "effort_limit")
    )
    drive = drives.get(joint.motor or "") if limit.origin is Origin.DERIVED else None
    gear = None if drive is None else next_gear(drive) or likelier_gear(drive)
    help += _or_gear(gear, spans, kept)
    if drive is not None and gear is None:
        # Another length gives another force.
        lengths = (item for item in misread_lengths(drive) if item.path not in kept.paths)
        length = next(
            (item for item in lengths if item.factor * coulomb.value < FRICTION_SHARE * limit.value), None
        )
        help += "" if length is None else f" Or {length.path[-1]} ({spans.value(length.path)}): {length.help}"
    where = f"actuators.{joint.group}.{field}"
    yield found_at(
        joint, "FRC101", where, coulomb.value / limit.value, message, help, number, other, error=error
    )


def _or_gear(gear: Repair | None, spans: SourceMap, kept: Kept) -> str:
    """A gear ratio that may be meant, beside what friction may be."""
    if gear is None or not kept.paths.isdisjoint(gear.paths):
        return ""
    return f" Or gear_ratio ({spans.value(gear.paths[0])}): {gear.help}"


def _static(joint: JointActuator, kept: Kept) -> Iterator[Found]:
    """Break-away friction against the effort limit."""
    static, limit = joint.friction_static, joint.effort_limit
    if static is None or not static.value or not limit.value or not is_stated(static):
        return
    place = limit.span if is_stated(limit) and limit.span not in kept.sure else None
    kinetic = joint.friction_coulomb.value
    words = static_words(static.value, static.unit, limit.value, limit.unit, place, kinetic)
    if words is not None:
        message, help, error = words
        where = f"actuators.{joint.group}.friction.static"
        size = static.value / limit.value
        yield found_at(joint, "FRC101", where, size, message, help, static, limit, error=error)


def _stribeck(joint: JointActuator) -> Iterator[Found]:
    """A Stribeck velocity that the joint never comes to; published: to 1 rad/s. What is fitted may lie anywhere."""
    velocity, own = joint.stribeck_velocity, own_speed(joint)
    fast = joint.velocity_limit if own is None or not own.value else own
    if velocity is None or not velocity.value or velocity.origin is not Origin.AUTHORED:
        return
    if not fast.value or velocity.value < fast.value:
        return
    message = (
        f"a Stribeck velocity of {shown(velocity)}, at which static friction has fallen to the kinetic one: the joint "
        f"ends at {shown(fast)}"
    )
    help = "look for the point in the wrong place"
    if joint.kind is JointKind.HINGE:
        help = f"is it in deg/s ({format_quantity(velocity.value * DEGREE, velocity.unit, 4)})? Or {help}"
    where, size = f"actuators.{joint.group}.friction.stribeck_velocity", velocity.value / fast.value
    yield found_at(joint, "SPEC184", where, size, message, help, velocity, fast)


def _viscous(
    joint: JointActuator,
    drives: Mapping[str, Drive],
    written: Mapping[Span, SpecValue],
    spans: SourceMap,
    kept: Kept,
) -> Iterator[Found]:
    """Viscous friction at the end of the torque-speed line, whatever the level; published: to 0.43 (ANYmal D).

    Where no line acts also at a stated velocity limit; what the robot's file has as well is not mistyped.
    """
    viscous, limit = joint.friction_viscous, given_at(joint)
    if not is_stated(viscous) or not viscous.value or not limit.value or not joint.effort_limit.value:
        return
    whose = "an effort limit of" if limit is joint.effort_limit else "the drive's"
    line = joint.no_load_speed if joint.curve is None else joint.curve.no_load_speed
    clamp, motors = joint.velocity_limit, own_speed(joint) if line is None else line
    asked = [] if motors is None else [(motors, UNREACHED if line is None else VISCOUS_SHARE)]
    if line is None and clamp.value and is_stated(clamp) and not is_power_of_ten(clamp.value):
        asked += [] if is_files(viscous) else [(clamp, WHOLE)]
    takes = ((speed, viscous.value * (speed.value or 0.0), share * limit.value) for speed, share in asked)
    speed, torque, most = next((item for item in takes if item[1] >= item[2]), (clamp, 0.0, math.inf))
    if not torque:
        return
    lined = speed is not clamp
    message = (
        f"the viscous friction of {shown(viscous)} takes {format_quantity(torque, limit.unit, 3)} at the joint's "
        f"{'' if lined else 'velocity limit of '}{shown(speed)}, of {whose} {shown(limit)}"
    )
    # Any of them may be: a figure would be a guess.
    times = "times 57.3, " if joint.kind is JointKind.HINGE else ""
    help = f"is it in m{viscous.unit}, {times}or the point in the wrong place?"
    plain = None if viscous.span is None else in_si(written.get(viscous.span))
    if plain is not None and torque * (plain.value or 0.0) < most * viscous.value:
        # Of a friction per degree the unit is the likeliest.
        help = f"did you mean {plain.written}?"
    own = joint.motor_line
    stall = None if own is None else own.stall_torque
    strong = 0.0 if stall is None else stall.value or 0.0
    if strong >= WINDING * limit.value and torque < VISCOUS_SHARE * strong and limit.span not in kept.sure:
        at_rest = format_quantity(strong, limit.unit, 4)
        help += f" Or is the limit wrong ({limit.span})? The motor has {at_rest} at rest."
    where, number, other = f"actuators.{joint.group}.friction.viscous", viscous, speed
    drive = drives.get(joint.motor or "")
    help += _or_gear(None if drive is None else likelier_gear(drive), spans, kept)
    readings = [
        reading
        for reading in (
            misread_speeds(drive) if drive is not None and lined and speed.span not in kept.sure else ()
        )
        if torque * reading.factor < most
    ]
    place = speed.span
    if not readings and drive is not None and lined and limit.origin is Origin.DERIVED:
        # Another length gives another force, too.
        lengths = [item for item in misread_lengths(drive) if torque * item.factor**2 < most]
        readings = [item for item in lengths if item.path == lengths[0].path and item.path not in kept.paths][
            :1
        ]
        place = spans.value(readings[0].path) if readings else place
    if readings:
        fast, named = alternatives(reading.help for reading in readings), readings[0].path[-1]
        known = in_file(*viscous.lost)
        bearing = 0.0 if known is None else known.value or 0.0
        if bearing / AGREES < viscous.value < bearing * AGREES or any(
            reading.likelier for reading in readings
        ):
            # The robot's file has that friction, or the speed is odd by itself, too.
            where, number, other = dotted(readings[0].path), replace(speed, span=place), viscous
            help = f"{named}: {fast}{'' if fast.endswith('?') else '.'} Or viscous ({viscous.span}): {help}"
        else:
            help = f"viscous: {help} Or {named} ({place}): {fast}"
        help = f"one of 2 numbers is wrong. {help}"
    elif lined:
        help += " The slope of the torque-speed line belongs to the motor, not to friction"
    found = found_at(joint, "FRC106", where, torque / limit.value, message, help, number, other, limit)
    # What is doubted of the motor itself is told there.
    yield replace(found, derived=found.derived or lined)
