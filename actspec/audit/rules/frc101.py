from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from os.path import basename
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import by_joint, keeps_for_model, limiting_row, own_figure, shown, unit
from actspec.audit.rules.limits_of_files import mimics
from actspec.audit.rules.sym101 import doubted_limits
from actspec.diagnostics import Span
from actspec.fields import FRICTION_SHARE
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow
from actspec.units import format_number

_Subject = tuple[LedgerRow, float, LedgerRow, float]

_SURE = 2.0
"""Dry friction over the effort limit from which it is a warning where another file has the limit, or it is none of an
MJCF. Chosen: published grippers have 1 (Talos), where nobody acted on it."""

_CREEPS = 0.01
"""Speed from which a joint that the drive moves against MuJoCo's friction is said to creep [rad/s or m/s]. Chosen."""


class FrictionNotBelowEffort(RuleOver[_Subject]):
    code = "FRC101"
    name = "friction-not-below-effort"
    aliases: ClassVar[dict[str, str]] = {"FRC001": "dry-friction-above-the-limit"}
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    noted_in_folders = True
    counts_where_run = True
    written_over = frozenset({"dynamics", "urdf_dynamics", "friction", "urdf_effort"})
    paired = True
    needs = "no joint with dry friction and an effort limit among the files"

    def subjects(self, case: Case) -> Iterable[_Subject]:
        """Each joint's friction once, with the least limit: a model that several scenes include has its line once.

        A joint that follows another one has no drive of its own.
        """
        followers = case.once(mimics)
        least: dict[tuple[str, Span], _Subject] = {}
        for rows in by_joint(case).values():
            row = rows[0]
            friction = row.frictionloss
            if friction is None or (row.artifact, row.joint) in followers:
                continue
            if not ("frictionloss" in row.stated or keeps_for_model(case, row)):
                continue
            limiting = limiting_row(case, row)
            if limiting is None or limiting.effort_limit is None:
                continue
            place = row.joint, row.place("frictionloss")
            # Of a part alone the inertia is not known, of the model that includes it it may be.
            if place not in least or _rank(limiting.effort_limit, row) < _rank(
                least[place][3], least[place][0]
            ):
                least[place] = row, friction, limiting, limiting.effort_limit
        return least.values()

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Compare dry friction with the effort limit."""
        row, friction, limiting, limit = subject
        # Whoever states both in one MJCF has them act on each other, and so has a class with a curve and a friction.
        of_class = limiting is row and "curve.drive_torque" in row.more
        own = of_class or (
            limiting.artifact == row.artifact and case.artifacts[row.artifact].kind is FileKind.MJCF
        )
        if friction < (FRICTION_SHARE if own else 1.0) * limit:
            return
        speed, held = self._creep(case, row, limit)
        share = f"is not below the effort limit of {own_figure(limiting, 'effort_limit')}"
        effect = "the drive cannot move the joint" if held else "a real drive cannot move the joint"
        if friction < limit:
            left = shown(row, "effort_limit", limit - friction)
            share = f"takes {format_number(100.0 * friction / limit, 3)} % of the effort limit of "
            share += own_figure(limiting, "effort_limit")
            effect = f"that leaves {'' if held else 'a real drive '}{left} to drive the joint"
        elif speed >= _CREEPS:
            effect = (
                "a real drive cannot move the joint, and MuJoCo's, whose friction is soft, has it creep at "
                f"{shown(row, 'velocity_limit', speed, 2)}"
            )
        where = "" if limiting.file == row.file else f" in {basename(limiting.file)}"
        yield Finding(
            self.code,
            f"the dry friction of {shown(row, 'effort_limit', friction)} {share}{where}: {effect}",
            row.place("frictionloss"),
            row.joint,
            friction,
            unit(row, "frictionloss"),
            help=f"is it in m{unit(row, 'frictionloss')} ({shown(row, 'frictionloss', friction / 1000.0)}), or a "
            "dimensionless coefficient?",
            related=(limiting.place("effort_limit"),),
            fields=("frictionloss",),
            # It is the limit that is wrong where SYM101 tells so; and other importers make little of a URDF's friction.
            severity=Severity.INFO
            if friction < (FRICTION_SHARE if own else _SURE) * limit
            or not held
            or (limiting.artifact, limiting.joint) in case.once(doubted_limits)
            else None,
        )

    def _creep(self, case: Case, row: LedgerRow, limit: float) -> tuple[float, bool]:
        """How fast the full limit moves the joint in MuJoCo [rad/s or m/s], and whether friction brakes it most.

        Below its limit, friction is a constraint that brakes in proportion to speed and to the joint's inertia: a
        light joint, or one with more damping than that, hardly feels it. Of one of unknown inertia nobody knows, nor
        where a model says itself how soft its friction is.
        """
        from actspec.simulate.reference import SOFT_RATE, SOFT_SHARE

        inertia, damping = row.inertia_free_min, row.joint_damping or 0.0
        artifact = case.artifacts[row.artifact]
        if artifact.kind is not FileKind.MJCF:
            return 0.0, True
        if inertia is None or artifact.states(b"solreffriction") or artifact.states(b"solimpfriction"):
            return 0.0, False
        brakes = inertia * SOFT_RATE * SOFT_SHARE / (1.0 - SOFT_SHARE)
        speed = limit / (brakes + damping) if brakes + damping > 0.0 else math.inf
        return speed, brakes > damping


def _rank(limit: float, row: LedgerRow) -> tuple[float, bool]:
    """By which of two lines for one joint the one that is judged is chosen, the least."""
    return limit, row.inertia_free_min is None
