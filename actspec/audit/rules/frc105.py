from __future__ import annotations

from collections.abc import Iterator, Sequence

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.readings.artifact import FileKind, Robot
from actspec.readings.ledger import LedgerRow

_Subject = tuple[Robot, list[LedgerRow], list[LedgerRow], set[str], LedgerRow]


class NoFrictionAnywhere(RuleOver[_Subject]):
    code = "FRC105"
    name = "no-friction-anywhere"
    severity = Severity.INFO
    confidence = Confidence.MEDIUM
    needs = "no MJCF or URDF with driven joints among the files"

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for robot in case.robots:
            rows = [row for index in robot.artifacts for row in case.rows_of(index) if row.joint]
            models = [
                row for row in rows if case.artifacts[row.artifact].kind in (FileKind.MJCF, FileKind.URDF)
            ]
            driven = _driven(case, rows)
            first = next((row for row in models if row.joint in driven), None)
            if first is None:
                continue
            yield robot, rows, models, driven, first

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Look for friction of driven joints in all files of each robot."""
        robot, rows, models, driven, first = subject
        if all(_frictionless(case, row) for row in rows if row.joint in driven) and not _elsewhere(
            case, robot
        ):
            others = {row.artifact: row.span for row in reversed(models) if row.joint in driven}
            # Variants of a robot have joints that this file has not.
            own = tuple(
                dict.fromkeys(
                    row.joint for row in models if row.artifact == first.artifact and row.joint in driven
                )
            )
            who = (
                f"none of the {len(own)} driven joints has" if len(own) > 1 else "the one driven joint has no"
            )
            what = "dry or viscous friction in any file of the robot"
            yield Finding(
                self.code,
                f"{who} {what}: a policy trained on it first meets friction on the real robot",
                first.span,
                joints=own,
                help="measure the torque at several constant speeds: its offset is the dry, its slope the "
                "viscous friction",
                related=tuple(span for index, span in sorted(others.items()) if index != first.artifact),
                confidence=self.confidence if any(row.control != "none" for row in rows) else Confidence.LOW,
            )


def _driven(case: Case, rows: Sequence[LedgerRow]) -> set[str]:
    """Joints with an actuator in any file; without any, those that a URDF gives an effort."""
    found = {row.joint for row in rows if row.control != "none"}
    if found:
        return found
    urdf = [row for row in rows if case.artifacts[row.artifact].kind is FileKind.URDF]
    return {row.joint for row in urdf if row.effort_limit is not None and row.effort_limit > 0.0}


def _frictionless(case: Case, row: LedgerRow) -> bool:
    """Whether a row has no friction; what a configuration does not say is none of its own."""
    parts = (row.frictionloss, row.joint_damping, row.actuator_damping)
    if case.artifacts[row.artifact].kind in (FileKind.CFG, FileKind.DEPLOY):
        stated = {"frictionloss", "joint_damping"} & row.stated
        return not any(parts) and all(getattr(row, field) is not None for field in stated)
    return not any(parts) and None not in (row.frictionloss, row.joint_damping)


def _elsewhere(case: Case, robot: Robot) -> bool:
    """Whether a configuration of the robot supplies friction that the ledger does not carry."""
    for index in robot.artifacts:
        config = case.artifacts[index].config
        if config is None:
            continue
        if any(one.field in ("friction", "joint_damping") for one in config.randomize):
            return True
        for group in config.groups:
            settings = (group.settings.get("friction"), group.settings.get("dynamic_friction"))
            if any(one is not None and (one.unknown or one.value) for one in settings):
                return True
    return False
