from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import ClassVar

from actspec.audit.known import KnownJoint, Likeness, likenesses, same
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import SPEEDS, driving_limit, finite, is_exporters, shown, top_speed, unit
from actspec.fields import PLACEHOLDER, is_placeholder, is_power_of_ten
from actspec.ir import JointKind
from actspec.readings.artifact import FileKind
from actspec.readings.compare import DEGREES, RPM
from actspec.readings.ledger import LedgerRow
from actspec.units import format_number

_OTHER_MOTORS = 0.5
"""Share of the least published torque below which, at every joint, a robot of a known one's name and joints is another
machine. Chosen: whoever drives a robot gently keeps half."""

_ROTOR = 0.1
"""Relative difference up to which an armature is the published one without its gear. Chosen: a stage's own inertia is
some per cent of the rotor's behind its gear."""


class FarFromPublished(RuleOver[Likeness]):
    code = "KNW103"
    name = "armature-or-speed-is-not-the-published-one"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    options: ClassVar[dict[str, float]] = {"armature": 5.0, "speed": 1.3}
    written_over = frozenset({"actuators", "speeds", "armatures", "urdf_velocity"})
    needs = "no robot among the files whose armatures or speeds are published"

    def subjects(self, case: Case) -> Iterable[Likeness]:
        """Artifacts that are known robots, with their motors; a program's own list states neither for a simulator."""
        return [
            known
            for known in case.once(likenesses)
            if case.artifacts[known.index].kind is not FileKind.DEPLOY
            and not _has_other_motors(case, known)
            and any(
                one.top_speed or one.armature or known.robot.armatures
                for variant in known.robot.variants.values()
                for one in variant.values()
            )
        ]

    def judge(self, case: Case, subject: Likeness) -> Iterator[Finding]:
        """Hold armature and top speed of each joint to all that is published of it."""
        for row, names in subject.read("armature"):
            yield from self._armature(subject, row, names, self.option(case, "armature"))
        for row, names in subject.read(*SPEEDS):
            yield from self._speed(case, subject, row, names, self.option(case, "speed"))

    def _armature(
        self, subject: Likeness, row: LedgerRow, names: tuple[str, ...], times: float
    ) -> Iterator[Finding]:
        """An armature far from all that any source gives; one that is missing is GEA104's."""
        figures = {**subject.robot.armatures}
        # 0.1 kg*m^2 for every joint, of a waist as of a wrist, is a default: where nothing else is known a wrist may
        # well have less.
        derived = any(len(figures) > 1 and not is_power_of_ten(figure) for figure in figures)
        gears = set()
        for one in (joints[name] for joints in subject.robot.variants.values() for name in names):
            if one.armature:
                figures[one.armature] = one.source_of("armature")
                derived = True
                gears.add((one.armature, one.gear))
        # One below 0 is SGN101's.
        mine = finite(row.armature)
        if not figures or mine is None:
            return
        nearest = min(figures) if mine < min(figures) else max(figures)
        if min(figures) < times * mine and mine < times * max(figures):
            return
        if mine < nearest and not derived:
            return
        text = shown(row, "armature", nearest)
        rotor = next(
            (gear for figure, gear in gears if gear and math.isclose(mine * gear**2, figure, rel_tol=_ROTOR)),
            None,
        )
        why = "" if rotor is None else f"; it is the rotor's, without the square of the gear of {rotor:.4g}"
        yield Finding(
            self.code,
            f"the armature of {shown(row, 'armature', mine)} is {format_number(mine / nearest, 3)} times what is "
            f"published for {subject.robot.name}: {text}{why}",
            row.place("armature"),
            row.joint,
            mine,
            unit(row, "armature"),
            nearest,
            help="; ".join(
                f"{shown(row, 'armature', figure)}: {figures[figure]}" for figure in sorted(figures)
            ),
            fields=("armature",),
        )

    def _speed(
        self, case: Case, subject: Likeness, row: LedgerRow, names: tuple[str, ...], times: float
    ) -> Iterator[Finding]:
        """A top speed above all that any source gives; a lower one may be chosen."""
        published = _with_speed(subject, names)
        mine = top_speed(row) or _beyond_any(case, subject, row)
        if not published or mine is None:
            return
        best = max(published, key=lambda one: one.top_speed or 0.0)
        limit = best.top_speed or 0.0
        if mine < times * limit:
            return
        source = best.source_of("speed")
        if _slip(mine, limit) is None:
            slipped = {speed: title for speed, title in best.slower.items() if _slip(mine, speed) is not None}
            limit, source = next(iter(slipped.items()), (limit, source))
        field = next(name for name in SPEEDS if getattr(row, name) == mine)
        text = shown(row, field, limit)
        noun = "velocity limit" if field == "velocity_limit" else "no-load speed"
        yield Finding(
            self.code,
            f"the {noun} of {shown(row, field, mine, 6)} is {format_number(mine / limit, 3)} times what is "
            f"published for {subject.robot.name}: {text}",
            row.place(field),
            row.joint,
            mine,
            unit(row, field),
            limit,
            help=f"{_meant(mine, row, field, limit)}{text}: {source}",
            fields=(field,),
            # Of a description that no program there names, the speeds limit nothing; an ideal PD does not look at
            # them, and the solver's bound beside it is to be beyond the motor's.
            noted_in_folders=(row.control == "ideal_pd" and _slip(mine, limit) is None)
            if case.artifacts[row.artifact].kind is FileKind.CFG
            else not case.is_run(row.place(field)),
        )


def _has_other_motors(case: Case, subject: Likeness) -> bool:
    """Whether no file of the robot has half of the torque that is published of any joint: `go2_mini` is no Go2.

    Placeholders, zeros and what an exporter writes tell of no motor. Where each has its point in the wrong place, they
    are the robot's all the same.
    """
    files = case.robot_of(subject.index).artifacts
    limits = [
        (limit, subject.robot.efforts(name))
        for known in case.once(likenesses)
        if known.index in files and known.robot.name == subject.robot.name
        for row, names in known.read("effort_limit", "stall_torque")
        if not is_exporters(row) and (limit := finite(driving_limit(row)[1])) and not is_placeholder(limit)
        for name in names
    ]
    # One figure for all may be a tenth by chance.
    slipped = len({limit for limit, _ in limits}) > 1 and any(
        all(any(same(times * limit, effort) for effort in efforts) for limit, efforts in limits)
        for times in (10.0, 100.0)
    )
    return bool(limits) and not slipped and all(limit < _OTHER_MOTORS * min(its) for limit, its in limits)


def _with_speed(subject: Likeness, names: tuple[str, ...]) -> list[KnownJoint]:
    """What is published of joints, of all variants, as far as a top speed is."""
    variants = subject.robot.variants.values()
    return [one for joints in variants for one in (joints[name] for name in names) if one.top_speed]


def _beyond_any(case: Case, subject: Likeness, row: LedgerRow) -> float | None:
    """A hinge's speed limit that no joint reaches [rad/s], where it is no placeholder.

    Those are powers of ten, or one figure for all joints of a file: unless it is at each of them what a wrong unit, or
    a point in the wrong place, makes of a published one.
    """
    limit = finite(row.velocity_limit)
    if limit is None or limit >= PLACEHOLDER or row.kind is JointKind.SLIDE or is_exporters(row):
        return None
    if is_power_of_ten(limit):
        return None
    rows = case.rows_of(row.artifact)
    every = {one.velocity_limit for one in rows if one.kind is not JointKind.SLIDE and one.velocity_limit}
    of_known = [_with_speed(subject, names) for _, names in subject.read(*SPEEDS)]
    if len(every) == 1 and not all(
        any(_is_any(limit, joint) for joint in published) for published in of_known if published
    ):
        return None
    return limit


_SLIPS = ((DEGREES, "deg/s"), (RPM, "rpm"))
_SLIP = 0.02
"""Relative difference up to which a speed is another one in another unit, or with its point in the wrong place. Chosen:
makers round to three digits, and files to two."""


def _slip(speed: float, published: float) -> str | None:
    """What makes a speed of another one: a unit; "" of the point; None: nothing does."""
    for times, words in (*_SLIPS, (10.0, ""), (100.0, "")):
        if published and math.isclose(speed, times * published, rel_tol=_SLIP):
            return words
    return None


def _is_any(speed: float, joint: KnownJoint) -> bool:
    """Whether a speed is a published one in another unit, or with the point in the wrong place.

    One with a single digit, as 200 or 3000, may be what somebody wrote who meant no figure.
    """
    top = joint.top_speed or 0.0
    told = len(str(int(speed)).rstrip("0")) > 1
    return bool(_slip(speed, top)) or (
        told and any(_slip(speed, each) is not None for each in (top, *joint.slower))
    )


def _meant(speed: float, row: LedgerRow, field: str, published: float) -> str:
    """What a speed may be that is so far from the published one, for the beginning of a help."""
    slip = _slip(speed, published)
    if slip is None or row.kind is JointKind.SLIDE:
        return ""
    if slip:
        in_si = speed / {words: times for times, words in _SLIPS}[slip]
        return f"is it in {slip}? Then it is {shown(row, field, in_si, 4)}; "
    return "is the point in the wrong place? "
