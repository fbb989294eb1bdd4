from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import ClassVar

from actspec.audit.finding import Fix, Safety, TextEdit
from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.actuator_texts import written_actuators, written_in_degrees
from actspec.audit.rules.joints import by_joint, own_figure, partner_rows, shown
from actspec.audit.rules.whose_angle import data_of, graded, is_of_a_part, lacks_angle, of_a_part, unless
from actspec.diagnostics import Span
from actspec.fields import PLACEHOLDER_SPEED, is_power_of_ten
from actspec.ir import JointKind
from actspec.readings.artifact import Artifact, FileKind, without_comments
from actspec.readings.compare import DEGREES
from actspec.readings.drive import largest
from actspec.readings.ledger import LedgerRow
from actspec.robot.view import JointView
from actspec.robot.xml_edit import exact_number
from actspec.units import format_number


class RangeInDegrees(RuleInParts):
    code = "UNT101"
    name = "position-range-in-degrees"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    noted_in_folders = True
    counts_where_run = True
    written_over = frozenset({"range"})
    paired = True
    fix = Safety.UNSAFE
    needs = "no MJCF or URDF with a limited hinge among the files"
    options: ClassVar[dict[str, float]] = {"least": 12.6, "most": 720.0}

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        """What LIM101 asks for too."""
        yield from case.once(_told)

    def ranges(self, case: Case) -> Iterator[Iterable[Finding]]:
        """Compare ranges with each other and with what joints do."""
        locked = case.once(read_as_degrees)
        scaled = _scaled(case)
        least = self.option(case, "least")
        found: list[LedgerRow] = []
        turning: list[LedgerRow] = []
        for (index, _), rows in by_joint(case, FileKind.MJCF).items():
            # It is judged with what includes it.
            for row in () if case.has_angle_of_another(index) else rows:
                command, joint = row.command_range, row.position_range
                if row.control != "position" or row.kind is not JointKind.HINGE:
                    continue
                if command is None or joint is None:
                    continue
                yield ()
                # Of a control that is no position neither its range in radians nor what to write is known.
                if index in locked or row.span in scaled:
                    continue
                artifact = case.artifacts[index]
                in_degrees = (joint[0] * DEGREES, joint[1] * DEGREES)
                if is_degrees_of(command, in_degrees) and not artifact.states(b"radian"):
                    yield (graded(case, self._of_both(row, command, joint), artifact),)
                elif is_degrees_of(command, joint):
                    found.append(row)
                elif is_degrees_of(joint, command) and largest(joint) > _TURN:
                    turning.append(row)
                elif (
                    joint[0] < joint[1]
                    and largest(joint) <= _TURN
                    and least <= largest(command) <= self.option(case, "most")
                ):
                    speed = _speed_of(case, row, command)
                    if speed is not None:
                        yield (graded(case, self._of_speed(row, command, joint, speed), artifact),)
                    elif not _is_left(case, index, row.joint, command):
                        is_part = is_of_a_part(case, artifact, row.place("position_range"))
                        yield self._of_degrees(row, command, joint, is_part)
        # One range that is radians by its servo tells that all of the file are, endless joints' too; ±90 is none's.
        radians = Counter(row.artifact for row in found if not _turns(row))
        fixes = _range_fixes(case) if any(_turns(row) for row in found) else {}
        of_parts: dict[tuple[int, str], list[LedgerRow]] = {}
        for row in found:
            place, artifact = row.place("position_range"), case.artifacts[row.artifact]
            if _turns(row) or (is_of_a_part(case, artifact, place) and radians[row.artifact] == 1):
                continue
            if _is_in_radians(artifact, place.path):
                of_parts.setdefault((row.artifact, place.path), []).append(row)
        for (index, part), rows in of_parts.items():
            yield (graded(case, self._of_includer(case, index, part, rows), case.artifacts[index]),)
        told_of = {row.span: row for rows in of_parts.values() for row in rows}
        for row in found:
            if told_of.get(row.span) is row:
                continue
            assert row.command_range is not None and row.position_range is not None
            is_part = is_of_a_part(case, case.artifacts[row.artifact], row.place("position_range"))
            if _turns(row) and (row.artifact not in radians or _is_whole_degrees(row.command_range)):
                found_here = self._of_control(row, row.command_range, row.position_range, fixes.get(row.span))
                # Included by a file in radians, both would be the same few turns.
                few = is_part and largest(row.command_range) < least
                yield (of_a_part(found_here) if few else found_here,)
            elif not is_part or radians[row.artifact] > 1:
                # One servo of a part with the range of its joint is as it should be where the includer has radians.
                found_here = self._of_range(case, row, row.command_range, row.position_range, is_part)
                yield (graded(case, found_here, case.artifacts[row.artifact]),)
        told = Counter(row.artifact for row in turning)
        for row in turning:
            assert row.command_range is not None and row.position_range is not None
            artifact = case.artifacts[row.artifact]
            # As above, of one servo of a part either range may be the right one.
            if not is_of_a_part(case, artifact, row.place("position_range")) or told[row.artifact] > 1:
                found_here = self._of_turns(row, row.command_range, row.position_range)
                yield (graded(case, found_here, artifact),)
        by_servo = {(row.artifact, row.joint) for row in turning}
        for index, artifact in case.of_kind(FileKind.MJCF, FileKind.URDF):
            if case.has_angle_of_another(index):
                continue
            hinges = _limited_hinges(artifact)
            if index in locked:
                yield (graded(case, self._of_file(case, index, _moving(hinges)), artifact),)
                continue
            far_hinges = [hinge for hinge in hinges if self._is_far(case, hinge)]
            virtual = _placeholder_ranges(artifact)
            virtual |= {one.range for one in far_hinges if _is_left(case, index, one.name, one.range)}
            # Several angles that are no turns are no joints of many turns.
            several = {hinge.range for hinge in far_hinges} - virtual
            several = {ends for ends in several if not all(map(_is_turns, ends or ()))}
            far = sum(hinge.range in several for hinge in hinges)
            in_radians = artifact.kind is FileKind.URDF or artifact.states(b"radian")
            all_of_it = in_radians and len(several) >= _SEVERAL and 2 * far >= len(_moving(hinges))
            for hinge in hinges:
                quiet = hinge.range in virtual or (index, hinge.name) in by_servo
                yield () if quiet else self._of_joint(case, hinge, index in told or all_of_it)

    def _of_range(
        self,
        case: Case,
        row: LedgerRow,
        command: tuple[float, float],
        joint: tuple[float, float],
        is_part: bool,
    ) -> Finding:
        low, high = (shown(row, "default_position", end) for end in joint)
        return Finding(
            self.code,
            f"the joint's range is {low} ... {high}, and its servo's control range {DEGREES:.3g} times that: radians, "
            f"which MuJoCo takes for degrees in this file{unless(is_part)}",
            row.place("position_range"),
            row.joint,
            largest(joint),
            "rad",
            largest(command),
            _help(case, row.artifact, 'write the range in degrees, or add <compiler angle="radian"/>'),
        )

    def _of_includer(self, case: Case, index: int, part: str, rows: Sequence[LedgerRow]) -> Finding:
        """Of a model without the angle of a part that it includes, all of whose ranges are in radians."""
        row = rows[0]
        assert row.position_range is not None
        place, why = lacks_angle(case, index, part)
        low, high = (shown(row, "default_position", end) for end in row.position_range)
        return Finding(
            self.code,
            f"{why}; {row.joint} gets {low} ... {high}, and its servo's control range is {DEGREES:.3g} times that",
            place,
            help=_help(case, index, _ANGLE_OR_DEGREES),
            joints=tuple(one.joint for one in rows),
            related=tuple(dict.fromkeys(one.place("position_range") for one in rows)),
        )

    def _of_control(
        self, row: LedgerRow, command: tuple[float, float], joint: tuple[float, float], fix: Fix | None
    ) -> Finding:
        low, high = (shown(row, "default_position", end) for end in command)
        message = (
            f"the control range is {low} ... {high}, {DEGREES:.3g} times the joint's: degrees, which MuJoCo takes for "
            "radians here whatever the file's angle is"
        )
        return self._as_joint(row, command, joint, message, fix)

    def _of_speed(
        self, row: LedgerRow, command: tuple[float, float], joint: tuple[float, float], speed: LedgerRow
    ) -> Finding:
        (low, high), (least, most) = (
            (shown(row, "default_position", end) for end in ends) for ends in (command, joint)
        )
        message = (
            f"the control range of this position servo, {low} ... {high}, is the joint's speed limit, "
            f"{own_figure(speed, 'velocity_limit')} in {speed.file}: it clamps no position of a joint that has {least} "
            f"... {most}"
        )
        return self._as_joint(row, command, joint, message, None)

    def _as_joint(
        self,
        row: LedgerRow,
        command: tuple[float, float],
        joint: tuple[float, float],
        message: str,
        fix: Fix | None,
    ) -> Finding:
        """Of a control range in whose place the joint's is right."""
        return Finding(
            self.code,
            message,
            row.place("command_range"),
            row.joint,
            largest(command),
            "rad",
            largest(joint),
            f"write {_written(joint)}",
            fix=fix,
        )

    def _of_both(self, row: LedgerRow, command: tuple[float, float], joint: tuple[float, float]) -> Finding:
        ranges = ((shown(row, "default_position", end) for end in ends) for ends in (joint, command))
        (low, high), (left, right) = ranges
        return Finding(
            self.code,
            f"the joint's range is {low} ... {high} and its servo's control range {left} ... {right}: they are "
            "exchanged, radians that MuJoCo takes for degrees, and degrees that it takes for radians",
            row.place("position_range"),
            row.joint,
            largest(joint),
            "rad",
            largest(joint) * DEGREES,
            f'write range="{_written(command)}" and ctrlrange="{_written(command, 1.0 / DEGREES)}"',
            related=(row.place("command_range"),),
        )

    def _of_degrees(
        self, row: LedgerRow, command: tuple[float, float], joint: tuple[float, float], is_part: bool
    ) -> Iterator[Finding]:
        """A control range of whole degrees that is another than the joint's."""
        share = (command[1] - command[0]) / ((joint[1] - joint[0]) * DEGREES)
        near = 1.0 / _NEAR <= share <= _NEAR and all(end % _WHOLE == 0.0 for end in command)
        if not near and any(end % 90.0 for end in command):
            return
        low, high = (shown(row, "default_position", end) for end in command)
        found = Finding(
            self.code,
            f"the control range is {low} ... {high}, {(command[1] - command[0]) / _TURN:.2g} full turns, of a joint "
            f"that has {format_number(joint[1] - joint[0], 3)} rad: it looks like degrees, which MuJoCo takes for "
            "radians here whatever the file's angle is",
            row.place("command_range"),
            row.joint,
            largest(command),
            "rad",
            largest(command) / DEGREES,
            f"write {_written(command, 1.0 / DEGREES)}",
            confidence=Confidence.MEDIUM,
            noted_in_folders=True,
        )
        yield of_a_part(found) if _is_placeholder(command) or is_part else found

    def _of_turns(self, row: LedgerRow, command: tuple[float, float], joint: tuple[float, float]) -> Finding:
        low, high = (shown(row, "default_position", end) for end in joint)
        return Finding(
            self.code,
            f"the joint's range is {low} ... {high}, {DEGREES:.3g} times its servo's control range: degrees, where the "
            "file is read in radians",
            row.place("position_range"),
            row.joint,
            largest(joint),
            "rad",
            largest(command),
            f"write {_written(joint, 1.0 / DEGREES)}",
        )

    def _of_joint(self, case: Case, joint: JointView, told: bool) -> Iterator[Finding]:
        """A hinge of several turns: of whole or half radians, or in a file that is known to be in degrees."""
        ends = joint.range or (0.0, 0.0)
        most = largest(ends)
        if not self._is_far(case, joint):
            return
        if not told and not all(math.isclose(2.0 * end, round(2.0 * end), abs_tol=1e-9) for end in ends):
            return
        # 100 to both sides is what toys and mounts have whose joints shall have no end.
        guess, or_none = ("it looks like degrees where the file is read in radians", "")
        if _is_no_range(ends):
            guess = "degrees, where the file is read in radians, or a stand-in for a joint without an end"
            or_none = ", or no limit"
        yield Finding(
            self.code,
            f"this hinge may turn from {format_number(ends[0], 4)} to {format_number(ends[1], 4)} rad, "
            f"{(ends[1] - ends[0]) / _TURN:.2g} full turns: {guess}",
            joint.places.get("range", joint.span),
            joint.name,
            most,
            "rad",
            most / DEGREES,
            f"write {_written(ends, 1.0 / DEGREES)}{or_none}",
            confidence=Confidence.MEDIUM,
            noted_in_folders=True,
        )

    def _is_far(self, case: Case, joint: JointView) -> bool:
        """Whether a hinge may turn as many turns as an angle in degrees would be."""
        most = largest(joint.range or (0.0, 0.0))
        return self.option(case, "least") <= most <= self.option(case, "most")

    def _of_file(self, case: Case, index: int, joints: list[JointView]) -> Finding:
        first, artifact = joints[0], case.artifacts[index]
        place = first.places.get("range", first.span)
        ends = first.range or (0.0, 0.0)
        most = max(largest(joint.range or (0.0, 0.0)) for joint in joints) * DEGREES
        found = Finding(
            self.code,
            f"none of the {len(joints)} limited hinges may move by more than {most:.3g} degrees from 0, the first from "
            f"{format_number(ends[0], 3)} to {format_number(ends[1], 3)} rad: radians, read as degrees"
            + unless(is_of_a_part(case, artifact, place)),
            place,
            "",
            largest(ends),
            "rad",
            largest(ends) * DEGREES,
            _help(case, index, 'add <compiler angle="radian"/>'),
            joints=tuple(joint.name for joint in joints),
        )
        if not _is_in_radians(artifact, place.path) or is_of_a_part(case, artifact, place):
            return found
        there, why = lacks_angle(case, index, place.path)
        message = f"{why}; {found.message.partition(': radians')[0]}"
        return replace(
            found, message=message, span=there, help=_help(case, index, _ANGLE_OR_DEGREES), related=(place,)
        )


def _told(case: Case) -> tuple[tuple[Finding, ...], ...]:
    """What is said of each range."""
    return tuple(tuple(part) for part in RangeInDegrees().ranges(case))


def ranges_in_doubt(case: Case) -> frozenset[tuple[str, str]]:
    """Files and joints with a range that is in another unit than it is read in: no torque follows from it."""
    return frozenset(
        (place.path, joint)
        for part in case.once(_told)
        for one in part
        for place in (one.span, *one.related)
        for joint in one.joints or (one.joint,)
    )


def ranges_told(case: Case) -> frozenset[Span]:
    """Where the ranges are written of which something is said."""
    return frozenset(place for part in case.once(_told) for one in part for place in (one.span, *one.related))


_LOCKED = 3.2 / DEGREES
"""Largest angle that a range in radians can become when read in degrees. Chosen: a little above pi / 57.3."""

_LOCKED_TURN = 6.4 / DEGREES
"""Likewise where most ends are no half degrees, which people write: a Go2's thigh goes to 4.5379. Chosen: a little
above 2 pi / 57.3."""

_SEVERAL = 3

_ANGLE_OR_DEGREES = 'add <compiler angle="radian"/>, or write the ranges in degrees'

_NEAR = 2.5
"""Factor between the span of a control range in degrees and the joint's up to which they are one joint's. Chosen: a
half or a whole turn is written for a hinge that turns half of it."""


_WHOLE = 5.0
"""What ends of a range in degrees are mostly a multiple of [degrees]. Chosen."""

_ROUNDED = 0.02
"""Difference up to which a position is a number of half turns [rad]. Chosen: strangers write 31.4 for 10 pi."""

_NO_ROOM = 100.0
"""Least end of a virtual slide's range [m]. Chosen: no machine has such a slide."""

_TURN = 2.0 * math.pi
"""Chosen: a target beyond a full turn is in degrees; below it is the joint's range that is not."""


def _is_turns(end: float) -> bool:
    """Whether a position is half a turn, or a number of these, as files round them."""
    return abs(end - math.pi * round(end / math.pi)) <= _ROUNDED


def _written(ends: tuple[float, float], factor: float = 1.0) -> str:
    """A range as it is to be written."""
    return " ".join(format_number(end * factor, 4) for end in ends)


def _help(case: Case, index: int, usual: str) -> str:
    """What to do of ranges in radians: not what would turn a pose that is in degrees, as it is read."""
    other = written_in_degrees(case, index)
    return usual if other is None else f"write the ranges in degrees, as {other} is"


def _scaled(case: Case) -> set[Span]:
    """Servos whose control is no position: gain and offset make one of it."""
    return {
        view.span
        for _, artifact in case.of_kind(FileKind.MJCF)
        for view in (() if artifact.robot is None else artifact.robot.actuators)
        if view.is_scaled
    }


def _is_left(case: Case, index: int, joint: str, ends: tuple[float, float] | None) -> bool:
    """Whether a keyframe or a configuration of the robot has the joint outside of a range, were that in degrees.

    It is inside of it in radians then: the range is a wide one, of which nobody meant degrees.
    """
    low, high = ends or (0.0, 0.0)
    own = case.joints.get((index, joint), ())
    rows = (*own, *(other for row in own[:1] for other in partner_rows(case, row)))
    poses = [row.default_position for row in rows if row.default_position is not None]
    return any(
        max(low, -_TURN) <= pose <= min(high, _TURN)
        and not low / DEGREES - _ROUNDED <= pose <= high / DEGREES + _ROUNDED
        for pose in poses
    )


def _speed_of(case: Case, row: LedgerRow, command: tuple[float, float]) -> LedgerRow | None:
    """Another file's row of a joint with a speed limit that is the control range to both sides; None: no file's is.

    From 100 rad/s on nobody knows: the limit may be a placeholder, and the range one too.
    """
    others = (other for other in partner_rows(case, row) if (other.velocity_limit or 0.0) < PLACEHOLDER_SPEED)
    alike = (other for other in others if math.isclose(other.velocity_limit or 0.0, command[1], rel_tol=1e-3))
    return next(alike, None) if command[0] == -command[1] else None


def _turns(row: LedgerRow) -> bool:
    """Whether a control range that is 57.3 times the joint's is the one that cannot be in radians."""
    return row.command_range is not None and largest(row.command_range) > _TURN


def _is_whole_degrees(command: tuple[float, float]) -> bool:
    """Whether a control range is what people write in degrees: up to half a turn, and none that is to hold nothing."""
    return (
        largest(command) <= 180.0
        and all(end % _WHOLE == 0.0 for end in command)
        and not _is_placeholder(command)
    )


def _is_placeholder(ends: tuple[float, float]) -> bool:
    """Whether a range is of round figures, which may be there to hold nothing."""
    return all(end == 0.0 or is_power_of_ten(abs(end)) for end in ends)


def read_as_degrees(case: Case) -> frozenset[int]:
    """MJCFs without `angle="radian"` in which no hinge may move: their ranges are in radians."""
    return frozenset(
        index
        for index, artifact in case.of_kind(FileKind.MJCF)
        if not artifact.states(b"radian")
        and len(hinges := _moving(_limited_hinges(artifact))) >= _SEVERAL
        and not _are_degrees_by_servos(case, index)
        and _are_locked([joint.range or (0.0, 0.0) for joint in hinges])
    )


def _are_degrees_by_servos(case: Case, index: int) -> bool:
    """Whether each servo's own control range, in radians always, is its joint's range as that is read: a fine stage."""
    servos = [
        (row.command_range, row.position_range)
        for rows in case.joints_by_artifact.get(index, {}).values()
        for row in rows
        if row.control == "position" and row.kind is JointKind.HINGE
        if row.command_range is not None and row.position_range is not None
    ]
    return (
        bool(servos)
        and not case.artifacts[index].states(b"inheritrange")
        and all(_is_near(command, joint, joint[1] - joint[0]) for command, joint in servos)
    )


def _are_locked(ranges: Sequence[tuple[float, float]]) -> bool:
    """Whether hinges in degrees would be held to a few of them, all of them."""
    most = max(map(largest, ranges))
    if most <= _LOCKED:
        return True
    halves = [2.0 * DEGREES * end for ends in ranges for end in ends]
    odd = sum(not math.isclose(half, round(half), abs_tol=1e-6) for half in halves)
    return most <= _LOCKED_TURN and 2 * odd > len(halves)


def _is_in_radians(artifact: Artifact, path: str) -> bool:
    """Whether a file is a part without `<compiler>` that a model includes, and all ranges in it would lock its joints.

    The file that includes it lacks the angle then: the part is as it should be.
    """
    data = data_of(artifact, path)
    if path == artifact.path or data is None or b"<compiler" in without_comments(data):
        return False
    ranges = [
        joint.range or (0.0, 0.0)
        for joint in _moving(_limited_hinges(artifact))
        if joint.places.get("range", joint.span).path == path
    ]
    return bool(ranges) and _are_locked(ranges)


def _limited_hinges(artifact: Artifact) -> list[JointView]:
    """Without those of a URDF that move no link: no reader of URDFs takes them, and whose unit it is nobody knows."""
    joints = () if artifact.robot is None else artifact.robot.joints
    return [
        joint
        for joint in joints
        if joint.kind is JointKind.HINGE and joint.range is not None and "range" not in joint.unknown
        if joint.body or artifact.kind is not FileKind.URDF
    ]


def _moving(hinges: Iterable[JointView]) -> list[JointView]:
    """Those that are not held at 0, which is 0 in any unit."""
    return [joint for joint in hinges if joint.range != (0.0, 0.0)]


def _placeholder_ranges(artifact: Artifact) -> set[tuple[float, float] | None]:
    """Ranges that were written for one that is none.

    Those that slides of the file have too: a base that floats on virtual joints gets one for all, or beside slides of
    100 m and more a smaller power of ten. And those of several hinges, the same to both sides, where others of the file
    have radians: joints without an end.
    """
    joints = () if artifact.robot is None else artifact.robot.joints
    hinges = Counter(joint.range for joint in _limited_hinges(artifact))
    radians = any(0.0 < largest(ends or (0.0, 0.0)) <= _TURN for ends in hinges)
    endless = {
        ends for ends, count in hinges.items() if ends and radians and count > 1 and ends[0] == -ends[1]
    }
    slides = {joint.range for joint in joints if joint.kind is JointKind.SLIDE}
    floating = any(_is_no_range(ends) and largest(ends or (0.0, 0.0)) >= _NO_ROOM for ends in slides)
    return slides | endless | ({ends for ends in hinges if _is_no_range(ends)} if floating else set())


def _is_no_range(ends: tuple[float, float] | None) -> bool:
    """Whether a range is a power of ten to both sides."""
    return ends is not None and ends[0] == -ends[1] and is_power_of_ten(ends[1])


def is_degrees_of(command: tuple[float, float], joint: tuple[float, float]) -> bool:
    """Whether a range is another one in degrees; ends of 0 agree in both."""
    span = (joint[1] - joint[0]) * DEGREES
    return _is_near(command, (joint[0] * DEGREES, joint[1] * DEGREES), span)


def _is_near(one: tuple[float, float], other: tuple[float, float], span: float) -> bool:
    """Whether two ranges are one, as files round them."""
    return span > 0.0 and all(abs(a - b) <= 0.02 * span for a, b in zip(one, other, strict=True))


def _range_fixes(case: Case) -> dict[Span, Fix]:
    """For each actuator with a `ctrlrange` of its own, the edit that sets it to the joint's range."""
    found = {}
    for one in written_actuators(case, b"ctrlrange"):
        attribute = one.element.attributes.get("ctrlrange")
        joint = None if one.artifact.robot is None else one.artifact.robot.joint(one.view.target)
        if attribute is None or joint is None or joint.range is None or one.document.is_repeated(one.element):
            continue
        ends = " ".join(exact_number(end) for end in joint.range)
        path = one.document.files[one.element.file].path
        edit = TextEdit(path, attribute.value_start, attribute.value_end, ends.encode())
        found[one.view.span] = Fix(
            f"Set ctrlrange to {ends}", Safety.UNSAFE, (edit,), ("actuator_ctrlrange",)
        )
    return found
