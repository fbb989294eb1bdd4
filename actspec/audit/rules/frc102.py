from __future__ import annotations

import math
from collections.abc import Iterator
from os.path import basename
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.configs import groups_of
from actspec.audit.rules.joints import partner_rows, shown, unit
from actspec.diagnostics import Span
from actspec.readings.artifact import FileKind, Framework, Setting
from actspec.readings.ledger import LedgerRow
from actspec.readings.versions import Versions, friction_unit_of, is_native
from actspec.simulators.isaaclab import FrictionUnit
from actspec.units import format_number

SAME = 0.01
"""Relative difference up to which two frictions are one figure. Chosen: rounding of published figures."""


def _place(versions: Versions) -> str:
    """`Isaac Lab 2.3 on Isaac Sim 5.1`."""
    lab = f"Isaac Lab {versions.isaaclab}" if versions.isaaclab else ""
    under = f"Isaac Sim {versions.isaac_sim}" if versions.isaac_sim else ""
    if versions.backend and not under:
        under = {"physx": "PhysX", "ovphysx": "OVPhysX", "newton": "Newton"}.get(versions.backend, "")
    return " on ".join(filter(None, (lab, under)))


_Subject = tuple[Setting, LedgerRow, float]


class FrictionUnitByBackend(RuleOver[_Subject]):
    code = "FRC102"
    name = "friction-unit-by-backend"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    needs = "no Isaac Lab configuration with friction among the files"
    options: ClassVar[dict[str, float]] = {"ratio": 10.0}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for group in groups_of(case, Framework.ISAACLAB):
            setting = group.written("friction")
            for row in group.rows:
                friction = group.number(setting, row.joint)
                if setting is not None and friction is not None and friction > 0.0:
                    yield setting, row, friction

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Hold friction against what the named versions make of it."""
        setting, row, friction = subject
        yield from self._judge(case, row, friction, setting.span)

    def _judge(self, case: Case, row: LedgerRow, friction: float, span: Span) -> Iterator[Finding]:
        versions = case.versions_of(row.artifact)
        found, place = friction_unit_of(versions), _place(versions)
        if found is None:
            by_backend = is_native(versions)
            named = "backend" if by_backend else "version"
            yield Finding(
                self.code,
                "this friction is a dimensionless coefficient on Isaac Sim 4.5 and OVPhysX, and a torque in "
                f"{unit(row, 'frictionloss')} from Isaac Lab 2.3 on Isaac Sim 5: which of the two "
                f"depends on the {named}, and none is named",
                span,
                row.joint,
                help="name it: --target backend==physx (or ovphysx, newton)"
                if by_backend
                else "name them: --target isaaclab==2.3 --target isaac_sim==5.1",
                severity=Severity.INFO,
                confidence=Confidence.HIGH,
            )
            return
        if found is FrictionUnit.DEAD:
            yield Finding(
                self.code,
                f"this friction does nothing: {place} never writes it to the solver",
                span,
                row.joint,
                help="go to Isaac Lab 2.3, and give dynamic_friction too",
                confidence=Confidence.HIGH,
            )
            return
        for other in partner_rows(case, row, FileKind.MJCF, FileKind.URDF, FileKind.SPEC):
            torque = other.frictionloss
            if torque is None or torque <= 0.0:
                continue
            text, file = shown(row, "frictionloss", torque), basename(other.file)
            if found.coefficient and math.isclose(friction, torque, rel_tol=SAME):
                yield Finding(
                    self.code,
                    f"on {place} friction is a dimensionless coefficient, and {file} has the same figure as a torque, "
                    f"{text}: the joint gets {format_number(friction, 3)} times its load instead",
                    span,
                    row.joint,
                    friction,
                    "1",
                    help="find the coefficient that gives this torque under the joint's load, or go to Isaac Lab 2.3 "
                    "on Isaac Sim 5",
                    related=(other.place("frictionloss"),),
                )
                return
            if found.torque and torque >= self.option(case, "ratio") * friction:
                yield Finding(
                    self.code,
                    f"on {place} friction is a torque, here {shown(row, 'frictionloss', friction)}, and {file} has "
                    f"{text}: is this a coefficient from Isaac Sim 4.5?",
                    span,
                    row.joint,
                    friction,
                    unit(row, "frictionloss"),
                    torque,
                    f"friction={format_number(torque)}, dynamic_friction={format_number(torque)}",
                    (other.place("frictionloss"),),
                    severity=Severity.INFO,
                )
                return
