from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding
from actspec.audit.known import Likeness, likenesses, same
from actspec.audit.rules.clamped import bound_of, is_in_doubt
from actspec.audit.rules.joints import effort_noun, is_called_undriven, is_held, is_undriven
from actspec.audit.rules.source_blame import GRAVE, Disagreement, is_met
from actspec.audit.rules.source_pairs import are_variants, disagreements
from actspec.audit.rules.source_rule import (
    TIMES,
    SourceRule,
    are_alternatives,
    is_a_digit_off,
    is_beyond_the_joint,
    is_no_limit,
    is_of_control,
    is_small,
    is_times,
    is_times_off,
    shown,
)
from actspec.audit.rules.sym101 import doubted_limits
from actspec.diagnostics import SEVERITIES, Severity
from actspec.fields import PLACEHOLDER, is_placeholder
from actspec.ir import JointKind
from actspec.readings.artifact import FileKind, Robot
from actspec.readings.ledger import LedgerRow
from actspec.units import format_number

_UNLIKE = 0.01
"""Chosen: limits that differ by more are of two motors, as `tolerance`."""

_NONE_LEFT = 1e-3
"""Below this a ratio is given as a factor. Chosen: three digits make 100 % less of 99.97 %."""

_SEVERAL = 4
"""Joints from which one limit for all tells that nobody looked the motors up. Chosen: a leg may have three alike."""


class EffortLimit(SourceRule):
    code = "SRC101"
    name = "effort-limit-disagrees"
    noted_in_folders = True
    groups = (("effort_limit",), ("stall_torque",))
    needs = "an effort limit of one joint"

    def is_none(self, case: Case, found: Disagreement, tolerance: float) -> bool:
        """A placeholder; or a limit that two actuators of a joint have each, and another file has for the joint.

        A torque at standstill that is no digit off: the effort limit cuts it, and many write that in its place.
        """
        if found.field == "stall_torque" and not is_a_digit_off(found.ratio):
            return True
        each = any(
            len(side.rows) > 1 and same(side.mine.value, len(side.rows) * (side.theirs.value or 0.0))
            for side in (found, found.turned)
        )
        return each or is_no_limit(found)

    def findings(self, case: Case, disagreements: Sequence[Disagreement]) -> list[Finding]:
        """One each; those with a file that has one limit for joints of which another tells the motors apart are one."""
        found: list[Finding] = []
        alone: list[Disagreement] = []
        uniform: dict[tuple[int, bool], list[tuple[Disagreement, Disagreement]]] = {}
        for item in disagreements:
            sides = {(side.rows[0].artifact, _is_slide(side.rows[0])): side for side in (item, item.turned)}
            one = [which for which in sides if which in case.once(_of_one_limit)]
            # Of a limit that is far from the other side's, another file's one limit is not what is wrong.
            is_slip = any(
                (row.artifact, row.joint) in case.once(doubted_limits)
                for row in (item.rows[0], item.others[0])
            )
            if len(one) == 1 and not is_small(item) and not is_slip and item.field == "effort_limit":
                uniform.setdefault(one[0], []).append((item, sides[one[0]]))
            else:
                alone.append(item)
        nobodys, blamed = set(), set()
        for held in uniform.values():
            each = [self.finding(case, item) for item, _ in held]
            told = self._of_one_limit(case, each, [side for _, side in held])
            found += told or each
            if told:
                nobodys.add(_limit_of(case, held[0][1]))
                blamed |= {(side.rows[0].artifact, side.rows[0].joint) for _, side in held}
        for item in alone:
            if item.field == "stall_torque":
                found.append(self.finding(case, max((item, item.turned), key=_off_its_limit)))
                continue
            # One limit in a variant of such a file is wrong there too, where the other file has one for its joints.
            if _limit_of(case, item) not in nobodys and _limit_of(case, item.turned) in nobodys:
                item = item.turned
                at = (item.rows[0].artifact, item.rows[0].joint)
                if at in blamed:
                    continue
                blamed.add(at)
            found.append(self.finding(case, item))
        return found

    def _of_one_limit(
        self, case: Case, found: Sequence[Finding], held: Sequence[Disagreement]
    ) -> list[Finding]:
        """What is said of a file with one limit, at each joint; nothing where the others have one for those joints."""
        limits = sorted(side.theirs.value or 0.0 for side in held)
        if limits[-1] <= limits[0] * (1.0 + _UNLIKE):
            return []
        unit = held[0].mine.unit
        worst = max(found, key=lambda one: SEVERITIES.index(one.severity or self.severity))
        if all(is_of_control(case, side.rows) for side in held):
            # A range for whatever the task commands is no motor's.
            worst = replace(worst, severity=Severity.INFO, confidence=Confidence.LOW)
        message = (
            f"the effort limit is {shown(held[0].mine.value, unit)} on every joint of this file, and "
            f"{shown(limits[0], unit)} to {shown(limits[-1], unit)} in another file of the robot: unlike motors have "
            "no limit in common"
        )
        joints = {side.rows[0].joint: side for side in held}
        return [
            replace(
                worst,
                message=message,
                span=side.mine.place,
                joint=joint,
                value=side.mine.value,
                expected=side.theirs.value,
                help="state each motor's limit",
                related=(side.theirs.place,),
            )
            for joint, side in joints.items()
        ]

    def severity_of(self, case: Case, found: Disagreement) -> tuple[Severity, Confidence]:
        """A note where nothing meets the limit, where it is a task's, and of a robot program's margin."""
        nothing = _is_of_task(case, found) or _limits_nothing(case, found) or _is_margin(case, found)
        nothing = nothing or _reached(case, found).ratio == 1.0
        return (Severity.INFO if nothing else self.severity), self.confidence

    def grave(self, case: Case, found: Disagreement) -> Severity | None:
        """Twice or half the limit, or more, is an error; a warning where only a control's range makes one of them, in
        models with the same joints, and of a torque at standstill.
        """
        if found.field == "stall_torque":
            return None
        if _limits_nothing(case, found) or not is_times_off(case, found):
            return None
        if not is_times(_reached(case, found).ratio):
            return None
        if not any(is_of_control(case, rows) for rows in (found.rows, found.others)):
            return Severity.ERROR
        other_joints = are_variants(case, found.rows[0].artifact, found.others[0].artifact)
        return None if other_joints or _is_of_task(case, found) else self.severity

    def consequence(self, case: Case, found: Disagreement) -> str:
        """How much torque, or force of a slide."""
        assert found.ratio is not None
        effort = effort_noun(found.rows[0])
        if found.field == "stall_torque":
            return f"the torque-speed line falls from {format_number(found.ratio, 3)} times the {effort} here"
        reached = _reached(case, found)
        bound = f"the clamped command bounds the {effort} {reached.bound}" if reached.bound else ""
        if reached.ratio == 1.0:
            return f"{bound}, no more than the lower limit"
        if not _NONE_LEFT <= reached.ratio < TIMES:
            has = f"has {format_number(reached.ratio, 3)} times the {effort} here"
        else:
            share = abs(reached.ratio - 1.0) * 100.0
            has = f"has {share:.3g} % {'more' if reached.ratio > 1.0 else 'less'} {effort} here"
        return f"{bound}, and the joint {has}" if bound else f"the joint {has}"


def placeholders_beside_limits(case: Case) -> dict[tuple[int, str], LedgerRow]:
    """Joints with a placeholder, by artifact, to the row of another file of the robot that limits them, where a smaller
    figure would be an error of SRC101; of files that somebody named.
    """
    rule = EffortLimit()
    found: dict[tuple[int, str], LedgerRow] = {}
    for item in disagreements(case, ("effort_limit",), rule.option(case, "tolerance")):
        sides = [
            side
            for side in (item, item.turned)
            if is_placeholder(side.mine.value or 0.0) and 0.0 < (side.theirs.value or 0.0) < PLACEHOLDER
        ]
        graver = item.one_machine and not is_met(case, item) and not is_called_undriven(item.rows[0])
        if sides and graver and rule.grave(case, item) is Severity.ERROR:
            found |= {(side.rows[0].artifact, side.rows[0].joint): side.others[0] for side in sides}
    return found


def _limit_of(case: Case, found: Disagreement) -> tuple[Robot, FileKind, float | None]:
    """The limit that departs, with the robot and the kind of file that have it."""
    artifact = found.rows[0].artifact
    return case.robot_of(artifact), case.artifacts[artifact].kind, found.mine.value


def _limits_nothing(case: Case, found: Disagreement) -> bool:
    """Whether one of the limits is of a joint that no actuator of its file drives, or whose range holds it.

    Slides of two models of one kind have none to compare: fingers close as hard as the task of each asks. Nor have
    joints of two MJCFs that are set up otherwise as a whole.
    """
    both = (found.rows[0], found.others[0])
    if are_alternatives(case, found) and (all(_is_slide(row) for row in both) or _is_set_up_twice(found)):
        return True
    return is_beyond_the_joint(case, found) or any(is_undriven(case, row) or is_held(row) for row in both)


@dataclass(frozen=True, slots=True)
class _Reached:
    """What of a disagreement a joint ever meets.

    Attributes:
        ratio: How many times what the other file lets the joint have; 1 where that is no less.
        bound: In which file and at what the larger limit's servo is bounded below it by its clamped command.
    """

    ratio: float
    bound: str = ""


def _reached(case: Case, found: Disagreement) -> _Reached:
    """The disagreement in what the joint can have: a servo's clamped command may never ask for all of a limit."""
    ratio = found.ratio or 1.0
    side, where = (found, "here") if ratio > 1.0 else (found.turned, "there")
    robot, row = case.artifacts[side.rows[0].artifact].robot, side.rows[0]
    view = next((one for one in robot.actuators if one.span == row.span), None) if robot is not None else None
    if view is None or len(side.rows) > 1 or found.field != "effort_limit" or is_in_doubt(case, row):
        return _Reached(ratio)
    bound, how = bound_of(row, view)
    limit, least = side.mine.value or 0.0, side.theirs.value or 0.0
    if bound is None or bound >= limit or least <= 0.0:
        return _Reached(ratio)
    times = max(bound / least, 1.0)
    bounded = f"{where} at {shown(bound, side.mine.unit)} ({how})"
    return _Reached(times if ratio > 1.0 else 1.0 / times, bounded)


def _is_of_task(case: Case, found: Disagreement) -> bool:
    """Whether a limit is what a task may command: the range of a control that is 1, one of all motors of its file, or
    less than twice the other limit or more than half of it.
    """
    return any(
        rows[0].effort_limit == 1.0
        or rows[0].artifact in case.once(_of_one_control)
        or not is_times(found.ratio)
        for rows in (found.rows, found.others)
        if is_of_control(case, rows)
    )


def _of_one_control(case: Case) -> frozenset[int]:
    """Models that let a task command the same of several motors, all of them."""
    found = set()
    for index, _ in case.of_kind(FileKind.MJCF):
        ranges = [row.command_range for row in case.rows_of(index) if row.control == "motor"]
        if len(ranges) >= _SEVERAL and len(set(ranges)) == 1:
            found.add(index)
    return frozenset(found)


def _is_margin(case: Case, found: Disagreement) -> bool:
    """Whether a robot's program stays below the limit that its models have, by less than half: on purpose."""
    is_program = case.artifacts[found.rows[0].artifact].kind is FileKind.DEPLOY
    return is_program and found.ratio is not None and 1.0 / GRAVE < found.ratio < 1.0


def _is_set_up_twice(found: Disagreement) -> bool:
    """Whether a joint has a larger drive in one of two MJCFs, with all that goes along: each task set up its own.

    Then gains and rotor are larger by as much as makes a limit an error, and the command error at which the drive
    saturates is about the same. A limit that goes farther than its gains, or the other way, is one that nobody set up.
    """
    limit = found.ratio or 1.0
    ratios: list[float] = []
    for name in ("kp", "kd", "armature"):
        mine, theirs = (getattr(rows[0], name) for rows in (found.rows, found.others))
        if not (mine and theirs and mine > 0.0 and theirs > 0.0):
            return False
        ratios.append(mine / theirs if limit > 1.0 else theirs / mine)
    return min(ratios) >= GRAVE and max(limit, 1.0 / limit) < GRAVE * ratios[0]


def _of_one_limit(case: Case) -> frozenset[tuple[int, bool]]:
    """Files that state one effort limit for several joints, all of them; with whether these are slides or hinges.

    Not those of a robot whose motors have that limit in common, as is published.
    """
    published = {known.index for known in case.once(likenesses) if _is_published(known)}
    found = set()
    for artifact in range(len(case.artifacts)):
        for slides in (False, True):
            limits = [
                row.effort_limit
                for row in case.rows_of(artifact)
                if "effort_limit" in row.stated and row.joint and _is_slide(row) is slides
            ]
            if len(limits) >= _SEVERAL and len(set(limits)) == 1 and artifact not in published:
                found.add((artifact, slides))
    return frozenset(found)


def _is_published(known: Likeness) -> bool:
    """Whether every joint has the limit that is published for it."""
    limits = [
        (row.effort_limit, known.robot.variants[v][name].effort)
        for row, names in known.joints
        for v in known.variants
        for name in names
    ]
    return all(limit is not None and same(limit, effort) for limit, effort in limits)


def _off_its_limit(found: Disagreement) -> float:
    """How many times the torque at standstill is the effort limit, or that is it: motors stay near."""
    stall, limit = found.mine.value, found.rows[0].effort_limit
    ratio = stall / limit if stall and limit and 0.0 < limit < PLACEHOLDER else 1.0
    return max(ratio, 1.0 / ratio)


def _is_slide(row: LedgerRow) -> bool:
    return row.kind is JointKind.SLIDE
