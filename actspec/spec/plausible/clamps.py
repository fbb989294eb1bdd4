"""Positions: default ones, ranges of commands against the joint's own, ranges that a spec states of its joints."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from actspec.diagnostics import Path, Span, listed
from actspec.fields import is_power_of_ten
from actspec.ir import Command, JointActuator, JointKind, Origin
from actspec.poses import POSE_TOLERANCE, ROUNDED_ANGLE, far_words, is_round_angle, outside_words, shown_in
from actspec.spec.document import SourceMap
from actspec.spec.models import ListedJoint, SpecModel
from actspec.spec.plausible.relations import DEGREE
from actspec.spec.plausible.slips import amount_of
from actspec.spec.plausible.table import Doubt, Found, at
from actspec.spec.values import SpecValue
from actspec.units import format_quantity

WIDE = 12.0
"""Width of a clamp of position commands over the joint's range. Chosen: degrees are 57, mm 1000."""
WIDEST = (4.0, 20.0)
"""Range of a joint [turns, m]. Chosen: hinges with a range have to 2 turns (UR), winches more; rails 10 m."""
TURN = 2.0 * math.pi
"""[rad]"""
SAME_END = 0.15
"""An end of a range in another unit is the joint's own if they differ by no more than this part of its width."""
PART = 0.2
"""What is inside of the joint's range in another unit is meant so if it is this part of it."""


def clamp_words(
    clamp: tuple[float, float], own: tuple[float, float], hinge: bool
) -> tuple[float, str] | None:
    """How many times as wide as the joint's range a clamp is, and a help; None where it may be meant.

    A power of ten for both ends, as 100 rad, is a placeholder: some programs have to state one.

    Args:
        clamp: Range of the commands [rad or m].
        own: Range of the joint [rad or m].
        hinge: The joint turns.
    """
    (low, high), width = clamp, own[1] - own[0]
    if not 0.0 < width < math.inf or not low < high or is_open(low, high):
        return None
    ratio = (high - low) / width
    small, words, short, si = (DEGREE, "degrees", "deg", "rad") if hinge else (1e-3, "mm", "mm", "m")
    if _is_like(low * small, high * small, own) or (
        ratio > WIDE and _is_part(low * small, high * small, own)
    ):
        return ratio, f"is it in {words}? Then write [{low:.5g} {short}, {high:.5g} {short}]"
    low, high = low / small, high / small
    if ratio < 1.0 and _is_like(low, high, own):
        return ratio, f"did you mean [{low:.4g} {si}, {high:.4g} {si}]?"
    return (ratio, "write `command_range: joint` for the joint's own range") if ratio > WIDE else None


def range_doubts(model: SpecModel, spans: SourceMap) -> Iterator[Doubt]:
    """Ranges in degrees or mm, of the joints of a spec without a model file."""
    for index, joint in enumerate(model.robot.joints):
        if not isinstance(joint, ListedJoint) or joint.range is None:
            continue
        low, high = (end.value for end in joint.range)
        path: Path = ("robot", "joints", index, "range")
        if low is None or high is None:
            continue
        if any(end.written.endswith(("deg", "mm")) for end in joint.range):
            if all(end.written.endswith("deg") and _is_round(end.value or 0.0) for end in joint.range):
                low, high = low / DEGREE, high / DEGREE
                message = f"{joint.name}: a range of {low:.4g} deg to {high:.4g} deg, parts of pi"
                help = f"is it in rad? Then write [{low:.4g} rad, {high:.4g} rad]"
                yield at(spans, "SPEC190", message, path, help, (*path, 0), (*path, 1))
            continue
        ends = f"{joint.name}: a range of {joint.range[0].written} to {joint.range[1].written} is"
        if joint.kind == "hinge":
            words = turned_words((low, high), WIDEST[0])
            if words is not None:
                wide = format_quantity(words[0], "turns", 3)
                yield at(spans, "SPEC190", f"{ends} {wide} wide", path, words[1], (*path, 0), (*path, 1))
        elif high - low > WIDEST[1] and not is_open(low, high):
            message = f"{ends} {format_quantity(high - low, 'm', 3)} wide"
            help = f"is it in mm? Then write [{low:.5g} mm, {high:.5g} mm]"
            yield at(spans, "SPEC190", message, path, help, (*path, 0), (*path, 1))


def _is_round(angle: float) -> bool:
    """Whether an angle in degrees [rad] is the number of a round one in rad: 1.57, 0.785; to three digits.

    By chance one of a hundred numbers is so near, and both ends of a range are asked.
    """
    number = abs(angle) / DEGREE
    return number <= TURN + ROUNDED_ANGLE and is_round_angle(number)


def is_open(low: float, high: float) -> bool:
    """Whether both ends are one power of ten, which is a placeholder."""
    return -low == high and is_power_of_ten(high)


def turned_words(clamp: tuple[float, float], most_turns: float = WIDE) -> tuple[float, str] | None:
    """How many turns a range lets a hinge make, and a help; None where it may be meant.

    Only what is a part of a turn in degrees is doubted: what is wound up makes many.

    Args:
        clamp: Range of the commands, or of the joint [rad].
        most_turns: What may be meant [turns].
    """
    low, high = clamp
    turns, most = (high - low) / TURN, max(abs(low), abs(high))
    if turns <= most_turns or most * DEGREE > TURN or is_open(low, high):
        return None
    return turns, f"is it in degrees? Then write [{low:.5g} deg, {high:.5g} deg]"


def _is_like(low: float, high: float, own: tuple[float, float]) -> bool:
    """Whether a range is the joint's own, about."""
    return max(abs(low - own[0]), abs(high - own[1])) <= SAME_END * (own[1] - own[0])


def _is_part(low: float, high: float, own: tuple[float, float]) -> bool:
    """Whether a range lies inside of the joint's own, and is not a tiny part of it."""
    slack = SAME_END * (own[1] - own[0])
    inside = own[0] - slack <= low and high <= own[1] + slack
    return inside and high - low >= PART * (own[1] - own[0])


def is_posed(joint: JointActuator, poses: Span | None) -> bool:
    """Whether a joint's default position is one that the spec has: itself, or as the 0 of a joint that it leaves out.

    A spec without `default_pose` may be of an arm for which zero is no pose, such as a Panda. Speeds and torques are
    not added to a pose.

    Args:
        joint: The joint.
        poses: Where the spec states default positions; None: it states none.
    """
    stated = joint.default_position.origin is Origin.AUTHORED
    return stated or (poses is not None and joint.command is Command.POSITION)


@dataclass(frozen=True, slots=True)
class Poses:
    """What spec and robot say of default positions.

    Attributes:
        place: Where the spec states default positions; None: it states none.
        units: The unit that it writes all those of a kind of joint in, as `deg` or `mm`.
        keyframe: Positions in the first keyframe of the robot's file, by joint, as far as they are known [rad or m].
        shared: Where one default position is written for several joints.
        exchanged: Where one is written that is outside of its range and fits another joint whose own fits here.
    """

    place: Span | None
    units: Mapping[JointKind, str]
    keyframe: Mapping[str, float]
    shared: Collection[Span]
    exchanged: Mapping[Span, JointActuator]

    def inside(self, joint: JointActuator) -> float | None:
        """Position of a joint in the keyframe, if that is in the joint's range [rad or m]."""
        at, limits = self.keyframe.get(joint.joint), joint.position_range
        return at if at is not None and limits is not None and limits[0] <= at <= limits[1] else None


def poses_of(
    model: SpecModel,
    joints: Iterable[JointActuator],
    spans: SourceMap,
    keyframe: Mapping[str, float],
    sure: Collection[Span],
) -> Poses:
    """The default positions of a spec, beside its robot's keyframe, and where the author is sure of a number."""
    units = {}
    for kind in (JointKind.HINGE, JointKind.SLIDE):
        stated = (
            pose for pose in model.robot.default_pose.values() if pose.linear is (kind is JointKind.SLIDE)
        )
        written = {amount_of(pose)[1] for pose in stated}
        units[kind] = written.pop() if len(written) == 1 else ""
    place = spans.value(("robot", "default_pose")) if model.robot.default_pose else None
    counts = Counter(joint.default_position.span for joint in joints)
    shared = {span for span, count in counts.items() if span and count > 1}
    return Poses(place, units, keyframe, shared, _exchanged(joints, sure))


def _exchanged(joints: Iterable[JointActuator], sure: Collection[Span]) -> dict[Span, JointActuator]:
    """Pairs of default positions that are outside of their ranges and each inside of the other's, and of no third."""
    held: dict[Span, list[JointActuator]] = {}
    for joint in joints:
        pose = joint.default_position
        if (
            pose.span is not None
            and pose.span not in sure
            and pose.origin is Origin.AUTHORED
            and joint.position_range is not None
        ):
            held.setdefault(pose.span, []).append(joint)
    off = {span: mine for span, mine in held.items() if not any(_takes(joint, joint) for joint in mine)}
    fits = {
        span: [
            other
            for other, theirs in off.items()
            if all(_takes(one, two) and _takes(two, one) for one in mine for two in theirs)
        ]
        for span, mine in off.items()
    }
    alone = {span: others[0] for span, others in fits.items() if len(others) == 1}
    return {span: off[other][0] for span, other in alone.items() if alone.get(other) == span}


def _takes(joint: JointActuator, other: JointActuator) -> bool:
    """Whether the default position of another joint is in the range of this one."""
    pose, limits = other.default_position.value, joint.position_range
    slack = POSE_TOLERANCE[joint.kind]
    inside = pose is not None and limits is not None and limits[0] - slack <= pose <= limits[1] + slack
    return inside and joint.kind is other.kind


def pose_found(joint: JointActuator, written: Mapping[Span, SpecValue], poses: Poses) -> Iterator[Found]:
    """A default position outside of the range (published: to 0.02 rad, a B2), or beyond a turn if it has none.

    Args:
        joint: The joint.
        written: Numbers as they are written, by where.
        poses: Beside what else is stated.
    """
    pose, kind, limits = joint.default_position, joint.kind, joint.position_range
    if pose.value is None or pose.origin is not Origin.AUTHORED:
        return
    value = None if pose.span is None else written.get(pose.span)
    # A 0 has no unit.
    own = poses.units[kind] if value is None else amount_of(value)[1] or poses.units[kind]
    if limits is None:
        if kind is JointKind.HINGE and (words := far_words(pose.value, own)) is not None:
            doubt = Doubt("SPEC190", words[0], "robot.default_pose", pose.span, words[1])
            yield Found(doubt, joint.joint, abs(pose.value))
        return
    found = outside_words(kind, limits, pose.value, POSE_TOLERANCE[kind], own)
    if found is None:
        return
    (low, high), (beyond, message, help) = limits, found
    other = None if pose.span is None else poses.exchanged.get(pose.span)
    if other is not None:
        yield from _told_together(joint, other, beyond, message, own)
        return
    # What the keyframe has is one joint's, and a number that several have is another one for each.
    at = None if pose.span in poses.shared else poses.inside(joint)
    meant = None if at is None else shown_in(at, pose.unit, own)
    if meant is not None and meant not in (help or ""):
        help = f"{help}. Or did" if help else "did"
        help += f" you mean {meant}, as in the first keyframe?"
    error = beyond > (max(high - low, math.pi) if kind is JointKind.HINGE else high - low)
    doubt = Doubt("SPEC190", message, "robot.default_pose", pose.span, help, error=error)
    yield Found(doubt, joint.joint, beyond, False)


def _told_together(
    joint: JointActuator, other: JointActuator, beyond: float, message: str, own: str
) -> Iterator[Found]:
    """Two default positions that are exchanged, at the first of them.

    Args:
        joint: The joint.
        other: The one that has its position.
        beyond: How far the joint's is outside of its range.
        message: That it is.
        own: The unit in which all are written; empty: rad or m.
    """
    first, second, limits = joint.default_position, other.default_position, other.position_range
    if first.span is None or second.span is None or second.span < first.span or limits is None:
        return
    theirs, *ends = (shown_in(at, second.unit, own) for at in (second.value or 0.0, *limits))
    message += f"; and {theirs} of {other.joint} outside of {' to '.join(ends)}"
    help = f"are the two exchanged ({second.span})? Each is inside of the other's range"
    doubt = Doubt("SPEC190", message, "robot.default_pose", first.span, help, (second.span,))
    yield Found(doubt, joint.joint, beyond, False)


def left_out_doubts(joints: Sequence[JointActuator], poses: Poses) -> Iterator[Doubt]:
    """Joints that `default_pose` leaves out, and that are at 0 for that, outside of their ranges: all in one."""
    said: dict[str, list[JointActuator]] = {}
    for joint in joints:
        pose, limits, own = joint.default_position, joint.position_range, poses.units[joint.kind]
        if pose.value is None or pose.origin is Origin.AUTHORED or limits is None:
            continue
        if not is_posed(joint, poses.place):
            continue
        if max(limits[0] - pose.value, pose.value - limits[1]) > POSE_TOLERANCE[joint.kind]:
            zero, *ends = (shown_in(end, pose.unit, own) for end in (pose.value, *limits))
            message = f"no default position is stated, so that it is {zero}, outside of the joint's range, "
            said.setdefault(message + " to ".join(ends), []).append(joint)
    if said:
        told = (f"{listed([joint.joint for joint in alike], 3)}: {text}" for text, alike in said.items())
        offers = (offer for alike in said.values() for offer in _offers(alike, poses))
        help = "; ".join(("name it here with the position of zero action", *offers))
        yield Doubt("SPEC190", "; ".join(told), "robot.default_pose", poses.place, help)


def _offers(joints: Sequence[JointActuator], poses: Poses) -> Iterator[str]:
    """What may be stated of joints with one range: what the keyframe has, each figure once, else the middle."""
    own, unit, limits = poses.units[joints[0].kind], joints[0].default_position.unit, joints[0].position_range
    assert limits is not None
    at: dict[str, str] = {}
    for joint in joints:
        position = poses.inside(joint)
        if position is not None:
            at.setdefault(shown_in(position, unit, own), joint.joint)
    if at:
        figures = listed([f"`{name}: {position}`" for position, name in at.items()], 3)
        yield f"{figures} {'is that' if len(at) == 1 else 'are those'} of the first keyframe"
    else:
        middle = shown_in(sum(limits) / 2.0, unit, own)
        yield f"`{joints[0].joint}: {middle}` is the middle of its range"
