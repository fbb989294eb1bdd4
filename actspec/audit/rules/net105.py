from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.drawn import rows_in
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.readings.artifact import (
    ActuatorGroup,
    FileKind,
    RandomizedRange,
    RobotConfig,
)
from actspec.readings.config import is_network

_Subject = tuple[int, RobotConfig, list[RandomizedRange]]


class GainsRandomisedOnNetwork(RuleOver[_Subject]):
    code = "NET105"
    name = "gains-randomised-on-a-network"
    noted_in_folders = True
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    needs = "no configuration with actuator groups randomises gains"

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for index, artifact in case.of_kind(FileKind.CFG):
            config = artifact.config
            ranges = (
                [one for one in config.randomize if one.field in ("kp", "kd")] if config is not None else []
            )
            if config is None or not config.groups or not ranges:
                continue
            yield index, config, ranges

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Hold the ranges of gains against the groups."""
        index, config, ranges = subject
        for group in config.groups:
            for one in ranges if is_network(config.framework, group) else ():
                for joint in _joints(case, index, group, one):
                    yield Finding(
                        self.code,
                        f"this range of {one.field} does nothing: a network gives the joint's torque, and has no "
                        "gains",
                        one.span,
                        joint,
                        help="randomise the torque instead, or train the network on several gains",
                        related=(group.span,),
                        # What a configuration inherits is there for others.
                        severity=Severity.INFO if one.span.path != group.span.path else None,
                        about=one.field,
                    )


def _joints(case: Case, index: int, group: ActuatorGroup, one: RandomizedRange) -> list[str]:
    """Joints of a group in a range; legged_gym's network drives them all."""
    rows = [row.joint for row in rows_in(case, index, one) if row.actuator == group.name]
    return rows or ([""] if group.joints is None and one.joints is None else [])
