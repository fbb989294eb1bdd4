from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from os.path import basename
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import by_joint, keeps_for_model, limiting_row, shown, unit
from actspec.audit.rules.sym101 import doubted_limits
from actspec.diagnostics import Span
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow

_Subject = tuple[LedgerRow, float, LedgerRow, float]

_SURE = 2.0
"""Dry friction over the effort limit from which it is a warning. Chosen: MuJoCo's is soft, and a light gripper whose
friction is its limit closes at four fifths of its speed."""

_CREEPS = 0.01
"""Speed from which a joint that the drive moves against MuJoCo's friction is said to creep [rad/s or m/s]. Chosen."""


class FrictionNotBelowEffort(RuleOver[_Subject]):
    code = "FRC101"
    name = "friction-not-below-effort"
    aliases: ClassVar[dict[str, str]] = {"FRC001": "dry-friction-above-the-limit"}
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    noted_in_folders = True
    paired = True
    needs = "no joint with dry friction and an effort limit among the files"

    def subjects(self, case: Case) -> Iterable[_Subject]:
        """Each joint's friction once, with the least limit: a model that several scenes include has its line once."""
        least: dict[tuple[str, Span], _Subject] = {}
        for rows in by_joint(case).values():
            row = rows[0]
            friction = row.frictionloss
            if friction is None or not ("frictionloss" in row.stated or keeps_for_model(case, row)):
                continue
            limiting = limiting_row(case, row)
            if limiting is None or limiting.effort_limit is None:
                continue
            place = row.joint, row.place("frictionloss")
            if place not in least or limiting.effort_limit < least[place][3]:
                least[place] = row, friction, limiting, limiting.effort_limit
        return least.values()

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Compare dry friction with the effort limit."""
        row, friction, limiting, limit = subject
        if friction < limit:
            return
        speed, held = self._creep(case, row, limit)
        effect = "the drive cannot move the joint"
        if speed >= _CREEPS:
            effect = (
                "a real drive cannot move the joint, and MuJoCo's, whose friction is soft, has it creep at "
                f"{shown(row, 'velocity_limit', speed, 2)}"
            )
        where = "" if limiting.file == row.file else f" in {basename(limiting.file)}"
        yield Finding(
            self.code,
            f"the dry friction of {shown(row, 'effort_limit', friction)} is not below the effort limit of "
            f"{shown(row, 'effort_limit', limit)}{where}: {effect}",
            row.place("frictionloss"),
            row.joint,
            friction,
            unit(row, "frictionloss"),
            help=f"is it in m{unit(row, 'frictionloss')} ({shown(row, 'frictionloss', friction / 1000.0)}), or a "
            "dimensionless coefficient?",
            related=(limiting.place("effort_limit"),),
            fields=("frictionloss",),
            # It is the limit that is wrong where SYM101 tells so; and a dry friction just as large leaves a motion.
            severity=Severity.INFO
            if friction < _SURE * limit
            or not held
            or (limiting.artifact, limiting.joint) in case.once(doubted_limits)
            else None,
        )

    def _creep(self, case: Case, row: LedgerRow, limit: float) -> tuple[float, bool]:
        """How fast the full limit moves the joint in MuJoCo [rad/s or m/s], and whether friction brakes it most.

        Below its limit, friction is a constraint that brakes in proportion to speed and to the joint's inertia: a
        light joint, or one with more damping than that, hardly feels it.
        """
        from actspec.simulate.reference import SOFT_RATE, SOFT_SHARE

        inertia, damping = row.inertia_free_min, row.joint_damping or 0.0
        if case.artifacts[row.artifact].kind is not FileKind.MJCF or inertia is None:
            return 0.0, True
        brakes = inertia * SOFT_RATE * SOFT_SHARE / (1.0 - SOFT_SHARE)
        speed = limit / (brakes + damping) if brakes + damping > 0.0 else math.inf
        return speed, brakes > damping
