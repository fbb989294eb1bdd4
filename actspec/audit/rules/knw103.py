from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import ClassVar

from actspec.audit.known import Likeness, likenesses
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import SPEEDS, shown, top_speed, unit
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow
from actspec.units import format_number

_ROTOR = 0.1
"""Relative difference up to which an armature is the published one without its gear. Chosen: a stage's own inertia is
some per cent of the rotor's behind its gear."""


class FarFromPublished(RuleOver[Likeness]):
    code = "KNW103"
    name = "armature-or-speed-is-not-the-published-one"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    noted_in_folders = True
    options: ClassVar[dict[str, float]] = {"armature": 5.0, "speed": 1.3}
    needs = "no robot among the files whose armatures or speeds are published"

    def subjects(self, case: Case) -> Iterable[Likeness]:
        """Artifacts that are known robots; a program's own list states neither for a simulator."""
        return [
            known
            for known in case.once(likenesses)
            if case.artifacts[known.index].kind is not FileKind.DEPLOY
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
            yield from self._speed(subject, row, names, self.option(case, "speed"))

    def _armature(
        self, subject: Likeness, row: LedgerRow, names: tuple[str, ...], times: float
    ) -> Iterator[Finding]:
        """An armature far from all that any source gives; one that is missing is GEA104's."""
        figures = {**subject.robot.armatures}
        gears = set()
        for one in (joints[name] for joints in subject.robot.variants.values() for name in names):
            if one.armature:
                figures[one.armature] = one.source_of("armature")
                gears.add((one.armature, one.gear))
        mine = row.armature
        if not figures or not mine or not math.isfinite(mine):
            return
        nearest = min(figures) if mine < min(figures) else max(figures)
        if min(figures) < times * mine and mine < times * max(figures):
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
        self, subject: Likeness, row: LedgerRow, names: tuple[str, ...], times: float
    ) -> Iterator[Finding]:
        """A top speed above all that any source gives; a lower one may be chosen."""
        published = [
            one
            for joints in subject.robot.variants.values()
            for one in (joints[name] for name in names)
            if one.top_speed
        ]
        mine = top_speed(row)
        if not published or mine is None:
            return
        best = max(published, key=lambda one: one.top_speed or 0.0)
        limit = best.top_speed or 0.0
        if mine < times * limit:
            return
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
            help=f"{text}: {best.source_of('speed')}",
            fields=(field,),
        )
