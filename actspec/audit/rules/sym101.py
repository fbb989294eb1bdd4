from __future__ import annotations

import math
import os
import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from itertools import combinations
from operator import attrgetter, eq
from typing import ClassVar

from actspec.audit.known import GRIPS
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.crowded import crowded
from actspec.audit.rules.joints import (
    is_held,
    is_nobodys,
    is_undriven,
    names_undriven,
    own_figure,
    partner_rows,
    shown,
    undriven_joints,
)
from actspec.audit.rules.limits_of_files import mimics
from actspec.audit.rules.same_joint import is_one_joint
from actspec.audit.rules.sided import are_of_two_sides, mirrors, of_its_leg
from actspec.audit.rules.source_pairs import is_one_machine
from actspec.audit.rules.urdf_drives import is_left_undriven
from actspec.diagnostics import one_line
from actspec.fields import PLACEHOLDER_SPEED
from actspec.ir import JointKind
from actspec.joints import SIDE_WORDS, WORD
from actspec.readings.artifact import FileKind
from actspec.readings.called import telling
from actspec.readings.ledger import LedgerRow
from actspec.units import format_quantity

_DRIVE = (
    "kp",
    "kd",
    "effort_limit",
    "velocity_limit",
    "stall_torque",
    "no_load_speed",
    "delay",
    "action_scale",
)

_LIMITS = ("effort_limit", "velocity_limit")

_PASSIVE = ("armature", "frictionloss", "joint_damping", "actuator_damping")

_MOTOR = ("effort_limit", "velocity_limit", "stall_torque", "no_load_speed", "armature")
"""What joints of one motor and gear have in common, however each is tuned and was identified."""

_REPLACED = {"gains": ("kp", "kd"), "urdf_effort": ("effort_limit",), "urdf_velocity": ("velocity_limit",)}
"""What a program of a folder writes over, of all joints alike."""

_COMPARED = attrgetter("control", *_DRIVE, *_PASSIVE)

_PD = ("position", "implicit", "ideal_pd", "dc_motor")

_SHARED = 0.8
"""Share of a file's joints that another must mirror to be its other side. Chosen: as for pairing files."""

_SEVERAL = 3
"""Pairs of joints from which a file shows whether each joint was identified by itself."""

_SIDED = 2
"""Pairs of joints that are driven on both sides, from which a file shows that a third should be. Chosen."""

_ABSURD = 10.0
"""From here one of two limits is no motor's. Chosen: gears and motors of one joint differ by less."""

_MEANING = {FileKind.URDF, FileKind.MJCF, FileKind.CFG}
"""Kinds of files that give each side its own figure alike where somebody means it. Chosen: a model is often made of the
other, and a compile writes an MJCF, a configuration and a deploy file of one spec."""

_ROUGH = 0.1
"""Share of a dry friction up to which two figures of it are one, and of a joint's inertia up to which two armatures
are. Chosen: identification tells them no better."""

_FELT = 0.26
"""Share of an armature up to which two are one. Chosen: nobody acted on Gym's humanoid, with 0.01 and 0.008 kg*m^2 at
its hips and 0.0068 and 0.0051 at its shoulders (docs/survey.md)."""

_DERIVED = 0.05
"""Share of a gain up to which two are one. Chosen: a damping ratio makes such gains of the masses of two sides."""

_NEAR = 1.0 / 15.0
"""Share of a speed limit up to which two are one. Chosen: nobody acts on 8.37 and 8.9 rad/s; the least difference of
limits that anybody has reported is 1/15."""

_AXES = 4
"""Names that differ in a letter alone, from which it is an axis'. Chosen: sides are two, or three with a middle."""

_Rows = Mapping[str, Sequence[LedgerRow]]


class LeftRightDiffer(RuleOver[tuple[Sequence[LedgerRow], Sequence[LedgerRow]]]):
    code = "SYM101"
    name = "left-right-asymmetry"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    noted_in_folders = True
    counts_where_run = True
    paired = True
    needs = "no joints whose names mirror each other among the files"
    options: ClassVar[dict[str, float]] = {"relative": 0.01, "angle": 0.02}

    def subjects(self, case: Case) -> Iterator[tuple[Sequence[LedgerRow], Sequence[LedgerRow]]]:
        yield from case.once(pairs)

    def judge(
        self, case: Case, subject: tuple[Sequence[LedgerRow], Sequence[LedgerRow]]
    ) -> Iterator[Finding]:
        """Compare every pair."""
        left, right = subject
        if (left[0].control == "none") != (right[0].control == "none"):
            finding = self._drive(case, left[0], right[0])
            if finding is not None:
                yield finding
            return
        # ORD103 tells of the actuator that is another joint's.
        own = {(row.artifact, row.joint) for row in (left[0], right[0])}
        crowd = any((found.artifact, found.joint) in own for found in case.once(crowded))
        finding = None if crowd else self._figures(case, left, right)
        if finding is not None:
            yield finding
        finding = self._range(case, left[0], right[0])
        if finding is not None:
            yield finding

    def _figures(self, case: Case, left: Sequence[LedgerRow], right: Sequence[LedgerRow]) -> Finding | None:
        if len(left) == len(right) and all(map(eq, map(_COMPARED, left), map(_COMPARED, right))):
            return None
        relative = self.option(case, "relative")
        differing: list[tuple[str, float, float]] = []
        idle = all(row.control in _PD and row.kp == 0.0 == row.kd for row in (*left, *right))
        for field in (*_DRIVE, *_PASSIVE):
            for one, other in zip(left, right, strict=False):
                if idle and field == "effort_limit":
                    # A drive without gains gives no torque to be limited.
                    continue
                if one.control != other.control and field in ("kp", "kd"):
                    # Which gains there are goes with the kind of drive.
                    continue
                a: float | None = getattr(one, field)
                b: float | None = getattr(other, field)
                if field in _LIMITS and (is_nobodys(one, field) or is_nobodys(other, field)):
                    continue
                if a is not None and b is not None and abs(abs(a) - abs(b)) > relative * max(abs(a), abs(b)):
                    differing.append((field, a, b))
                    break
        kinds = [(a.control, b.control) for a, b in zip(left, right, strict=False) if a.control != b.control]
        if not kinds and not differing:
            return None
        # Where one side has 0, that one is the odd one; then the one that other files of its robot contradict; then the
        # one that joints like it tell; else the second, the first being the pattern.
        field, a, b = differing[0] if differing else ("", 1.0, 1.0)
        sides = left[0], right[0]
        doubted = [
            bool(field) and _is_contradicted(case, *each, field, relative) for each in (sides, sides[::-1])
        ]
        if 0.0 in (a, b):
            first = a == 0.0
        elif doubted[0] is not doubted[1]:
            first = doubted[0]
        else:
            first = _is_odd(case, *sides, field, a, b)
        odd, other = (left[0], right[0]) if first else (right[0], left[0])
        # In two files the reader has the place of one side alone before him.
        here = ("", "") if odd.file == other.file else (" here", " on the other side")[:: 1 if first else -1]
        texts = [f"{one}{here[0]} and {its}{here[1]}" for one, its in kinds[:1]]
        for name, first_value, second in differing:
            ends = (
                [own_figure(row, name) for row in (left[0], right[0])]
                if name == "effort_limit"
                else [shown(left[0], name, value) for value in (first_value, second)]
            )
            texts.append(f"{name.replace('_', ' ')} {ends[0]}{here[0]} and {ends[1]}{here[1]}")
        dead = 0.0 in (a, b) and field == "effort_limit"
        identified = not kinds and (
            (all(name in _PASSIVE for name, _, _ in differing) and left[0].artifact in case.once(_identified))
            or all(_is_a_line_of_each(left[0], right[0], name) for name, _, _ in differing)
        )
        unfelt = not kinds and all(_is_unfelt(case, sides, *one) for one in differing)
        names = {name for name, _, _ in differing}
        # Where joints of both sides have 0 as well, it stands for a limit that nobody looked up.
        empty = dead and left[0].artifact in case.once(_without_limits)
        meant = not kinds and (
            _is_chosen(case, left[0], right[0], names)
            or _is_meant(case, left[0], right[0], differing, relative)
        )
        machines = not dead and left[0].artifact in case.once(_of_two_machines)
        quiet = identified or unfelt or empty or meant or machines
        over = case.written(odd.place(field), odd.joint)
        replaced = {name for figure, own in _REPLACED.items() if figure in over for name in own}
        return Finding(
            self.code,
            f"left and right differ: {', '.join(texts)}",
            odd.place(field),
            odd.joint,
            help="the same motor has the same figures on both sides",
            related=(other.place(field),),
            severity=Severity.INFO if quiet else Severity.ERROR if dead else self.severity,
            confidence=Confidence.LOW if quiet else Confidence.HIGH if dead else self.confidence,
            fields=tuple(name for name, _, _ in differing),
            # What holds a joint without a drive is there by intent more often than not.
            noted_in_folders=not (kinds or (dead and "urdf_drive" not in over))
            and names <= {*_PASSIVE, *replaced},
            about=" ".join(
                (
                    *(f"{one} {its}" for one, its in kinds[:1]),
                    *(f"{name} {one:.3g} {its:.3g}" for name, one, its in differing),
                )
            ),
        )

    def _drive(self, case: Case, left: LedgerRow, right: LedgerRow) -> Finding | None:
        odd, other = (left, right) if left.control == "none" else (right, left)
        if (odd.artifact, odd.joint) not in case.once(_forgotten):
            return None
        return Finding(
            self.code,
            f"no actuator drives it, and {one_line(other.joint)} on the other side has one",
            odd.span,
            odd.joint,
            help="give it the actuator of the other side",
            related=(other.span,),
            about="none",
        )

    def _range(self, case: Case, left: LedgerRow, right: LedgerRow) -> Finding | None:
        if left.position_range is None or right.position_range is None or left.kind is not JointKind.HINGE:
            return None
        (low, high), ours = left.position_range, right.position_range
        angle = self.option(case, "angle")
        for mirrored in ((low, high), (-high, -low)):
            if all(abs(one - other) <= angle for one, other in zip(mirrored, ours, strict=True)):
                return None
        texts = (
            f"{format_quantity(a, '', 3)} to {format_quantity(b, 'rad', 3)}" for a, b in ((low, high), ours)
        )
        return Finding(
            self.code,
            f"left and right have other ranges: {' and '.join(texts)}",
            right.place("position_range"),
            right.joint,
            help="ranges of the two sides are equal, or mirrored",
            related=(left.place("position_range"),),
            severity=Severity.INFO,
            confidence=Confidence.LOW,
            about=" ".join(f"{end:.3g}" for end in (low, high, *ours)),
        )


def _is_odd(case: Case, left: LedgerRow, right: LedgerRow, field: str, one: float, other: float) -> bool:
    """Whether the figure of the left joint is the slip, by those of joints like it.

    What fewer of them have is: of its kind on all legs, else of those with its motor and a word of its name, or with
    its motor alone where all others of these have one gain, damping or friction. Where they do not tell either, the
    figure that more of the other joints have was taken from them, unless it is a digit off.
    """
    rows = [row for index in {left.artifact, right.artifact} for row in case.rows_of(index) if field]
    kind, words = of_its_leg(left.joint), _words(left.joint)
    motor = [(name, value) for name in _MOTOR if (value := getattr(left, name)) == getattr(right, name)]
    kin = [row for row in rows if of_its_leg(row.joint) == kind]
    near = [row for row in rows if all(getattr(row, name) == its for name, its in motor)]
    others = {getattr(row, field) for row in near if row.joint not in (left.joint, right.joint)}
    if words and (field in _MOTOR or len(others) > 1):
        near = [row for row in near if words & _words(row.joint)]
    counts = [[getattr(row, field) for row in alike] for alike in (kin, near, rows)]
    *told, (ours, theirs) = ((values.count(one), values.count(other)) for values in counts)
    for mine, its in told:
        if mine != its:
            return mine < its
    return ours < theirs if _is_absurd(one, other) else ours > theirs


def _words(joint: str) -> frozenset[str]:
    """What a joint's name says of its place on a leg: of `left_hip_roll_joint` hip and roll, of `l_joint4` nothing."""
    words = (word.lower() for word in WORD.findall(of_its_leg(joint)))
    return frozenset(word for word in words if word.isalpha()) - {"joint"}


def _is_contradicted(case: Case, row: LedgerRow, twin: LedgerRow, field: str, relative: float) -> bool:
    """Whether other files of the robot state another figure for the joint, and none the same.

    One that has the figures of both sides repeats the fault, and speaks for neither.
    """

    def has(other: LedgerRow, mine: LedgerRow) -> bool:
        one, its = getattr(other, field), getattr(mine, field)
        return one is not None and math.isclose(one, its, rel_tol=relative)

    others = [
        has(other, row)
        for other in partner_rows(case, row)
        if field in other.stated
        and getattr(other, field) is not None
        and not (
            has(other, row)
            and any(has(beside, twin) for beside in case.joints.get((other.artifact, twin.joint), ()))
        )
    ]
    return bool(others) and not any(others)


def _is_a_line_of_each(left: LedgerRow, right: LedgerRow, field: str) -> bool:
    """Whether one group gives each side its own end of a torque-speed line: somebody measured them."""
    return field == "no_load_speed" and left.actuator == right.actuator


def _is_chosen(case: Case, left: LedgerRow, right: LedgerRow, fields: Set[str]) -> bool:
    """Whether somebody set up each side by itself: two groups of a configuration that have both gains apart.

    A figure that was corrected on one side alone is one figure. Whole sides differ where one arm works and the other
    is held.
    """
    is_config = case.artifacts[left.artifact].kind is FileKind.CFG
    return is_config and left.actuator != right.actuator and {"kp", "kd"} <= fields


def _is_meant(
    case: Case,
    left: LedgerRow,
    right: LedgerRow,
    differing: Sequence[tuple[str, float, float]],
    relative: float,
) -> bool:
    """Whether both models and a configuration give each side its own figure, the same in all: another gear or tool.

    A digit too many, or 0, is meant by nobody, however often it was copied; nor is what one kind of file has alone.
    """
    if left.artifact != right.artifact:
        return False
    stating: list[set[FileKind]] = []
    for field, *figures in differing:
        kinds: set[FileKind] = set()
        if _is_absurd(*figures):
            return False
        for index in case.robot_of(left.artifact).artifacts:
            rows = [case.joints.get((index, row.joint), ()) for row in (left, right)]
            if not all(own and field in own[0].stated for own in rows):
                continue
            theirs = [getattr(own[0], field) for own in rows]
            if not all(
                its is not None and math.isclose(its, figure, rel_tol=relative)
                for its, figure in zip(theirs, figures, strict=True)
            ):
                return False
            kinds.add(case.artifacts[index].kind)
        stating.append(kinds)
    return any(kinds >= _MEANING for kinds in stating) and all(len(kinds) > 1 for kinds in stating)


def _is_unfelt(case: Case, sides: tuple[LedgerRow, LedgerRow], field: str, one: float, other: float) -> bool:
    """Whether it makes no difference: friction, gains, speeds or inertias nearly equal, or a speed out of reach."""
    if field in ("kp", "kd"):
        return abs(one - other) <= _DERIVED * max(abs(one), abs(other))
    rough = abs(one - other) <= _ROUGH * max(abs(one), abs(other))
    if field == "frictionloss":
        return rough
    if field == "armature":
        inertia = min(row.inertia_min or 0.0 for row in sides)
        if abs(one - other) <= max(_ROUGH * inertia, _FELT * max(abs(one), abs(other))):
            return True
    if field == "joint_damping" and rough:
        return True
    if field == "velocity_limit" and (
        min(abs(one), abs(other)) >= PLACEHOLDER_SPEED
        or abs(one - other) <= _NEAR * max(abs(one), abs(other))
    ):
        return True
    if field.endswith("limit") and all(is_left_undriven(case, row) for row in sides):
        return True
    # Of a pair of fingers often one follows the other.
    return any(
        (row.artifact, row.joint) in case.once(mimics)
        or (field.endswith("limit") and (is_undriven(case, row) or is_held(row)))
        for row in sides
    )


def doubted_limits(case: Case) -> frozenset[tuple[int, str]]:
    """Joints, each with its artifact, whose effort limit is far from that of the other side: evidence of nothing."""
    return _of_unlike_efforts(case, lambda one, other: one != other and _is_absurd(one, other))


def _is_absurd(one: float, other: float) -> bool:
    """Whether two figures are a digit apart, as 35.55 and 3.555 are."""
    ends = sorted((abs(one), abs(other)))
    return ends[0] * _ABSURD <= ends[1] * (1.0 + 1e-9)


def unlike_sides(case: Case) -> frozenset[tuple[int, str]]:
    """Joints, each with its artifact, whose effort limit is not that of the other side: no gear is told from it."""
    return _of_unlike_efforts(case, lambda one, other: abs(one - other) > _DERIVED * max(one, other))


def _of_unlike_efforts(case: Case, unlike: Callable[[float, float], bool]) -> frozenset[tuple[int, str]]:
    """Joints of both sides, each with its artifact, by their effort limits; a placeholder casts no doubt on the other
    side's.
    """
    found: set[tuple[int, str]] = set()
    for pair in case.once(pairs):
        one, other = (rows[0] for rows in pair)
        a, b = one.effort_limit, other.effort_limit
        nobodys = any(is_nobodys(row, "effort_limit") for row in (one, other))
        if a is not None and b is not None and not nobodys and unlike(a, b):
            found |= {(row.artifact, row.joint) for row in (one, other)}
    return frozenset(found)


def pairs(case: Case) -> tuple[tuple[Sequence[LedgerRow], Sequence[LedgerRow]], ...]:
    """Rows of left and right joints, in one file or in two."""
    return tuple(_each_pair(case))


def _each_pair(case: Case) -> Iterator[tuple[Sequence[LedgerRow], Sequence[LedgerRow]]]:
    joints = case.joints_by_artifact
    single = []
    for artifact, own in joints.items():
        met = _mirrored(own, own)
        if met:
            yield from met
        else:
            single.append(artifact)
    # Most of them have no such names at all.
    sided = {artifact for artifact in single if any(map(mirrors, joints[artifact]))}
    yield from _of_equal_names(case, single)
    for one, other in combinations(single, 2):
        if one not in sided and other not in sided:
            continue
        if case.artifacts[one].kind is not case.artifacts[other].kind:
            continue
        if not _are_two_sides(case.artifacts[one].path, case.artifacts[other].path):
            continue
        for left, right in ((joints[one], joints[other]), (joints[other], joints[one])):
            met = _mirrored(left, right)
            if len(met) >= max(2.0, _SHARED * max(len(left), len(right))):
                yield from met


def _of_equal_names(
    case: Case, artifacts: Iterable[int]
) -> Iterator[tuple[Sequence[LedgerRow], Sequence[LedgerRow]]]:
    """Joints of one name in two files whose paths differ in the side alone: `left/hand.urdf`, `right/hand.urdf`."""
    homes: dict[tuple[FileKind, str], list[int]] = {}
    for index in artifacts:
        path = os.path.splitext(os.path.abspath(case.artifacts[index].path))[0]
        key = case.artifacts[index].kind, WORD.sub(_without_side, path)
        homes.setdefault(key, []).append(index)
    for group in homes.values():
        for one, other in combinations(group, 2):
            left, right = (case.joints_by_artifact[index] for index in (one, other))
            shared = [name for name in left if name in right]
            if (
                are_of_two_sides(case, one, other)
                and len(shared) >= max(2.0, _SHARED * max(len(left), len(right)))
                and is_one_machine(case, one, other)
            ):
                # One base may carry two arms.
                own = [name for name in shared if is_one_joint(case, one, other, name)]
                yield from ((left[name], right[name]) for name in own)


def _are_two_sides(one: str, other: str) -> bool:
    """Whether names allow that two files are the sides of one robot: the left hand of one maker is not another's right.

    What is left of the files' names without their sides has a word in common, or nothing of one is left.
    """
    mine, its = (
        telling(WORD.sub(_without_side, os.path.splitext(os.path.basename(path))[0])) for path in (one, other)
    )
    return not mine or not its or bool(mine & its)


def _without_side(word: re.Match[str]) -> str:
    return "-" if word[0].lower() in SIDE_WORDS else word[0]


def _mirrored(left: _Rows, right: _Rows) -> list[tuple[Sequence[LedgerRow], Sequence[LedgerRow]]]:
    found = []
    for name, rows in left.items():
        other = next((text for text in mirrors(name) if text in right), None)
        if (
            other is not None
            and _is_of_one_kind(rows[0], right[other][0])
            and not _are_axes(name, other, left)
        ):
            found.append((rows, right[other]))
    return found


def _is_of_one_kind(one: LedgerRow, other: LedgerRow) -> bool:
    """Whether both slide or both turn; a configuration does not say."""
    return one.kind is other.kind or one.kind is None or other.kind is None


def _are_axes(one: str, other: str, names: Iterable[str]) -> bool:
    """Whether two names are those of axes that are called by letters: S, L, U, R, B and T of an arm."""
    words, its = WORD.findall(one), WORD.findall(other)
    at = [i for i, (a, b) in enumerate(zip(words, its, strict=True)) if a != b]
    if any(len(words[i]) > 1 for i in at):
        return False
    letters = {
        tuple(found[i] for i in at)
        for name in names
        if len(found := WORD.findall(name)) == len(words)
        and all(
            found[i] == words[i] or (i in at and len(found[i]) == 1 and found[i].isalpha())
            for i in range(len(words))
        )
    }
    return len(letters) >= _AXES


def _forgotten(case: Case) -> frozenset[tuple[int, str]]:
    """Joints, each with its artifact, that nothing drives though their like on the other side is driven.

    A model drives both sides of its other pairs: of an arm that hangs more than one joint is not driven. Springs hold
    some, and of a gripper's fingers one follows the other.
    """
    lone: dict[int, list[str]] = {}
    whole: Counter[int] = Counter()
    for left, right in case.once(pairs):
        one, other = left[0], right[0]
        if one.artifact != other.artifact:
            continue
        if (one.control == "none") != (other.control == "none"):
            lone.setdefault(one.artifact, []).append((one if one.control == "none" else other).joint)
        elif one.control != "none":
            whole[one.artifact] += 1
    undriven = case.once(undriven_joints) if lone else {}
    found = set()
    for index, joints in lone.items():
        robot, joint = case.artifacts[index].robot, joints[0]
        view = None if robot is None else robot.joint(joint)
        if (
            view is not None
            and len(joints) == 1
            and whole[index] >= _SIDED
            and joint in undriven.get(index, ())
            and not (view.stiffness or GRIPS.search(joint) or names_undriven(joint))
            and not any(map(is_held, case.joints[index, joint]))
        ):
            found.add((index, joint))
    return frozenset(found)


def _without_limits(case: Case) -> frozenset[int]:
    """Artifacts with a pair of joints of which neither has a limit but 0."""
    return frozenset(
        left[0].artifact
        for left, right in case.once(pairs)
        if left[0].artifact == right[0].artifact and left[0].effort_limit == 0.0 == right[0].effort_limit
    )


def _identified(case: Case) -> frozenset[int]:
    """Artifacts in which at least half of all pairs differ in what friction and rotors do: measured joint by joint."""
    differ: dict[int, list[bool]] = {}
    for left, right in case.once(pairs):
        own = (
            (getattr(a, field), getattr(b, field))
            for field in _PASSIVE
            for a, b in zip(left, right, strict=False)
        )
        unlike = any(a is not None and b is not None and a != b for a, b in own)
        differ.setdefault(left[0].artifact, []).append(unlike)
    return frozenset(
        index for index, found in differ.items() if len(found) >= _SEVERAL and 2 * sum(found) >= len(found)
    )


def _of_two_machines(case: Case) -> frozenset[int]:
    """Artifacts in which the motors of most pairs differ: two arms of two makers on one bench.

    Limits ten times apart, and those of 0, are slips of whole hands too.
    """
    unlike: dict[int, list[bool]] = {}
    for left, right in case.once(pairs):
        one, other = left[0].effort_limit, right[0].effort_limit
        if one is not None and other is not None:
            differ = not math.isclose(one, other, rel_tol=_DERIVED) and not _is_absurd(one, other)
            unlike.setdefault(left[0].artifact, []).append(differ)
    return frozenset(
        index for index, found in unlike.items() if len(found) >= _SEVERAL and 2 * sum(found) > len(found)
    )
