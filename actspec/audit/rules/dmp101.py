from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from os.path import basename
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.damping_parts import INTENT, Parts, parts_by_joint, same
from actspec.audit.rules.joints import by_joint, effort_noun, keeps_for_model, partner_rows, shown, unit
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow


class DriveAndJointDamping(RuleOver[tuple[Sequence[LedgerRow], Parts]]):
    code = "DMP101"
    name = "kv-and-joint-damping"
    aliases: ClassVar[dict[str, str]] = {"DMP001": "damping-may-be-counted-twice"}
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    noted_in_folders = True
    needs = "no MJCF with a drive that has a velocity gain among the files"
    options: ClassVar[dict[str, float]] = {"share": 0.1, "large": 0.5}

    def subjects(self, case: Case) -> Iterator[tuple[Sequence[LedgerRow], Parts]]:
        everything = case.once(parts_by_joint)
        for key, rows in by_joint(case, FileKind.MJCF).items():
            parts = everything[key]
            if parts is None or parts.kd <= 0.0:
                continue
            yield rows, parts
        for key, rows in by_joint(case, FileKind.SPEC).items():
            parts = everything[key]
            unstated = "kd" in rows[0].stated and "joint_damping" not in rows[0].stated
            if parts is not None and parts.kd > 0.0 and unstated and keeps_for_model(case, rows[0]):
                yield rows, parts

    def judge(self, case: Case, subject: tuple[Sequence[LedgerRow], Parts]) -> Iterator[Finding]:
        """Find joints with both."""
        rows, parts = subject
        if parts.passive <= self.option(case, "share") * parts.kd or parts.in_three_places:
            return
        if case.artifacts[rows[0].artifact].kind is FileKind.SPEC:
            yield self._unstated(rows[0], parts)
            return
        others = list(partner_rows(case, rows[0], *INTENT))
        if any(_declares(row, parts) for row in others):
            return
        yield self._finding(case, rows, parts, others)

    def _unstated(self, row: LedgerRow, parts: Parts) -> Finding:
        """The file of a spec's robot has damping that the spec does not mention."""
        passive = shown(row, "kd", parts.passive)
        return Finding(
            self.code,
            f"damping may be counted twice: the drive has kd {shown(row, 'kd', parts.kd)}, and the robot's file adds "
            f"{passive} of joint damping that the spec does not mention; together {shown(row, 'kd', parts.total)}",
            row.place("joint_damping"),
            row.joint,
            parts.passive,
            unit(row, "kd"),
            help=f"state friction: {{viscous: ...}} in the group: `0` if the file's damping was the drive's, "
            f"`{passive}` if it is the bearing's",
            related=(row.place("kd"),),
        )

    def _finding(
        self, case: Case, rows: Sequence[LedgerRow], parts: Parts, others: Sequence[LedgerRow]
    ) -> Finding:
        row = rows[0]
        share = parts.passive / parts.kd
        # Back-EMF beside friction is what a motor has; DMP104 knows when they are one.
        own = parts.kd - sum(row.back_emf or 0.0 for row in rows)
        large = share >= self.option(case, "large") and own > 0.0
        # One that states another damping of the joint beside it means both, and SRC105 tells of them.
        alone = (other for other in others if not (other.joint_damping and "joint_damping" in other.stated))
        intent = next((other for other in alone if other.kd and same(other.kd, parts.kd)), None)
        sure = same(share, 1.0) or intent is not None
        field = "joint_damping" if parts.joint > 0.0 else "actuator_damping"
        limited = row.effort_limit is not None and row.effort_limit < math.inf
        inside, outside = (f" inside the {effort_noun(row)} limit", " outside it") if limited else ("", "")
        ratio = ""
        if large and row.damping_ratio is not None and row.damping_ratio > 0.0:
            without = row.damping_ratio * parts.kd / parts.total
            ratio = f", a damping ratio of {row.damping_ratio:.2g} instead of {without:.2g}"
        known = "" if intent is None else f"; {basename(intent.file)} has the drive's gain alone"
        if row.control == "velocity" and large:
            return self._lagging(row, parts, field)
        return Finding(
            self.code,
            f"the drive brakes with {shown(row, 'kd', parts.kd)}{inside} and the joint's damping with "
            f"{shown(row, 'kd', parts.passive)}{outside}: together {shown(row, 'kd', parts.total)}{ratio}{known}",
            row.place(field),
            row.joint,
            parts.passive,
            unit(row, "kd"),
            help="if the damping repeats the D gain, keep one of them; if it is measured friction, state it as "
            "friction.viscous in a spec, or set the finding aside with that reason",
            related=(row.span,) if intent is None else (row.span, intent.place("kd")),
            fields=(field,),
            # A file with the drive's gain alone shows that it is counted twice; the same number twice is worth a look.
            severity=self.severity if large and sure else Severity.INFO,
            confidence=Confidence.LOW if not large else Confidence.HIGH if sure else self.confidence,
        )

    def _lagging(self, row: LedgerRow, parts: Parts, field: str) -> Finding:
        """A servo of speed, whose damping is not counted twice but kept from its target."""
        return Finding(
            self.code,
            f"the velocity servo of kv {shown(row, 'kd', parts.kd)} works against a damping of "
            f"{shown(row, 'kd', parts.passive)}: it settles at {parts.kd / parts.total:.2g} of the speed that is "
            "commanded",
            row.place(field),
            row.joint,
            parts.passive,
            unit(row, "kd"),
            help="a velocity servo brakes by itself: leave the joint's damping out, or raise kv to many times as much",
            related=(row.span,),
            fields=(field,),
            confidence=Confidence.HIGH,
        )


def _declares(row: LedgerRow, parts: Parts) -> bool:
    """Whether a spec or configuration means the passive part, or the sum."""
    passive = row.joint_damping if "joint_damping" in row.stated else None
    if passive is not None and same(passive, parts.passive):
        return True
    return not passive and row.kd is not None and same(row.kd, parts.total)
