from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import (
    by_joint,
    finite,
    keeps_for_model,
    limiting_row,
    own_figure,
    partner_rows,
    shown,
    top_speed,
    unit,
)
from actspec.readings.artifact import FileKind
from actspec.readings.ledger import LedgerRow

_Subject = tuple[LedgerRow, float, LedgerRow, float, float]


class ViscousTakesTheLimit(RuleOver[_Subject]):
    code = "FRC106"
    name = "viscous-takes-the-limit"
    aliases: ClassVar[dict[str, str]] = {"FRC002": "viscous-friction-that-takes-the-whole-drive"}
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    paired = True
    needs = "no configuration or spec with viscous friction, effort limit and speed limit"
    options: ClassVar[dict[str, float]] = {"share": 0.5}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for rows in by_joint(case, FileKind.CFG, FileKind.DEPLOY, FileKind.SPEC).values():
            row = rows[0]
            viscous = row.joint_damping
            limiting = limiting_row(case, row)
            speeds = (_end_of_curve(case, row), *map(top_speed, (row, *partner_rows(case, row))))
            speed = min(filter(None, speeds), default=None)
            if (
                viscous is None
                or not ("joint_damping" in row.stated or keeps_for_model(case, row))
                or limiting is None
                or speed is None
                or (limiting is not row and _has_solvers_limit(case, row))
            ):
                continue
            limit = limiting.effort_limit
            assert limit is not None
            if not _is_told(case, row):
                yield row, viscous, limiting, speed, max(limit, _given(case, row))

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Compare viscous friction at the joint's speed with the limit."""
        row, viscous, limiting, speed, limit = subject
        if viscous * speed < self.option(case, "share") * limit:
            return
        whose = f"an effort limit of {own_figure(limiting, 'effort_limit')}"
        if limit != limiting.effort_limit:
            whose = f"the drive's {shown(row, 'effort_limit', limit)}"
        yield Finding(
            self.code,
            f"the viscous friction of {shown(row, 'kd', viscous)} takes "
            f"{shown(row, 'effort_limit', viscous * speed)} at the joint's "
            f"{shown(row, 'velocity_limit', speed)}, of {whose}",
            row.place("joint_damping"),
            row.joint,
            viscous,
            unit(row, "joint_damping"),
            help=f"is it in m{unit(row, 'kd')} ({shown(row, 'kd', viscous / 1000.0)})? The slope of the "
            "torque-speed line belongs to the motor, not to friction",
            related=(limiting.place("effort_limit"),),
        )


def _given(case: Case, row: LedgerRow) -> float:
    """What the drive is known to give [N*m or N], to which a lower limit is a choice; 0: nothing is known."""
    known = [row.stall_torque]
    for one in (row, *partner_rows(case, row, FileKind.SPEC)):
        spec = case.artifacts[one.artifact].spec
        actuator = None if spec is None else spec.joint(one.joint)
        known += [] if actuator is None else [actuator.peak_torque.value, actuator.continuous_torque.value]
    return max((torque for torque in map(finite, known) if torque is not None), default=0.0)


def _is_told(case: Case, row: LedgerRow) -> bool:
    """Whether the spec, which is told when it is read, has this friction."""
    for one in (row, *partner_rows(case, row, FileKind.SPEC)):
        spec = case.artifacts[one.artifact].spec
        told = () if spec is None else spec.diagnostics
        if one.joint_damping == row.joint_damping and any(
            (item.code, item.span) == (ViscousTakesTheLimit.code, one.place("joint_damping")) for item in told
        ):
            return True
    return False


def _has_solvers_limit(case: Case, row: LedgerRow) -> bool:
    """Whether a group limits the solver alone: which versions of Isaac Lab clip at that, CFG104 says."""
    config = case.artifacts[row.artifact].config
    groups = () if config is None else config.groups
    return any(
        {"effort_limit_sim", "joint_effort_limit"} & set(group.settings)
        for group in groups
        if (group.name, group.span) == (row.actuator, row.span)
    )


def _end_of_curve(case: Case, row: LedgerRow) -> float | None:
    """Speed at which the asymmetric curve of a spec's motor ends; None without one."""
    spec = case.artifacts[row.artifact].spec
    actuator = None if spec is None else spec.joint(row.joint)
    return None if actuator is None or actuator.curve is None else actuator.curve.no_load_speed.value
