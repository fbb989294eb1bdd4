from __future__ import annotations

from collections.abc import Iterator
from os.path import basename

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.friction import MILLI
from actspec.audit.rules.joint_units import shown, unit
from actspec.audit.rules.partners import by_joint, limiting_row
from actspec.diagnostics import Severity


class FrictionNotBelowEffort(Rule):
    code = "FRC101"
    name = "friction-not-below-effort"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    paired = True

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Compare dry friction with the effort limit."""
        looked = False
        for rows in by_joint(case).values():
            row = rows[0]
            friction = row.frictionloss
            if friction is None or "frictionloss" not in row.stated:
                continue
            limiting = limiting_row(case, row)
            if limiting is None or limiting.effort_limit is None:
                continue
            looked = True
            limit = limiting.effort_limit
            if friction < limit:
                continue
            where = "" if limiting.file == row.file else f" in {basename(limiting.file)}"
            yield Finding(
                self.code,
                f"the dry friction of {shown(row, 'effort_limit', friction)} is not below the effort limit of "
                f"{shown(row, 'effort_limit', limit)}{where}: the drive cannot move the joint",
                row.place("frictionloss"),
                row.joint,
                friction,
                unit(row, "frictionloss"),
                help=f"is it in m{unit(row, 'frictionloss')} ({shown(row, 'frictionloss', friction / MILLI)}), or a "
                "dimensionless coefficient?",
                related=(limiting.place("effort_limit"),),
            )
        if not looked:
            yield Skipped(self.code, "no joint with dry friction and an effort limit among the files")
