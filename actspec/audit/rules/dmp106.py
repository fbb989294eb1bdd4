from __future__ import annotations

from collections.abc import Iterator
from os.path import basename
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.damping_parts import first_rows, same
from actspec.audit.rules.joints import by_joint, shown, unit
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow

_Subject = tuple[LedgerRow, float, LedgerRow]


class UrdfDamping(RuleOver[_Subject]):
    code = "DMP106"
    name = "urdf-damping-has-four-meanings"
    severity = Severity.INFO
    confidence = Confidence.MEDIUM
    paired = True
    needs = "no URDF with damping beside another file of the same robot"
    options: ClassVar[dict[str, float]] = {"share": 0.1}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for rows in by_joint(case, FileKind.URDF).values():
            row = rows[0]
            damping = row.joint_damping
            if damping is None or damping <= 0.0:
                continue
            for other in first_rows(case, row, FileKind.MJCF, FileKind.SPEC, FileKind.CFG):
                yield row, damping, other

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Compare the URDF's damping with the other files'."""
        row, damping, other = subject
        instead = self._other(case, other, damping)
        if instead is not None:
            yield Finding(
                self.code,
                f"the URDF's damping of {shown(row, 'kd', damping)} meets {instead} in {basename(other.file)}: "
                "it is joint damping in MuJoCo, the drive's kd in Newton and nothing in Isaac Sim 6.1",
                row.place("joint_damping"),
                row.joint,
                damping,
                unit(row, "kd"),
                help="give the URDF the friction that the other files have, or 0 where they hold it all",
                related=(other.place("joint_damping"),),
            )

    def _other(self, case: Case, other: LedgerRow, damping: float) -> str | None:
        """What the other file has instead; None where they agree or nobody can tell."""
        passive = other.joint_damping
        if case.artifacts[other.artifact].kind is not FileKind.CFG or "joint_damping" in other.stated:
            if passive is None or same(passive, damping):
                return None
            return f"a joint damping of {shown(other, 'kd', passive)}"
        if other.kd is None or other.kd <= 0.0 or damping < self.option(case, "share") * other.kd:
            return None
        return f"a kd of {shown(other, 'kd', other.kd)} and no passive part"
