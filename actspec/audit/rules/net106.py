from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.configs import Group, groups_of
from actspec.audit.rules.joints import shown
from actspec.readings.artifact import Framework
from actspec.readings.versions import isaaclab_row


class NetworkWithoutSpeedClip(RuleOver[Group]):
    code = "NET106"
    name = "network-without-speed-clip"
    severity = Severity.INFO
    confidence = Confidence.HIGH
    needs = "no network of Isaac Lab among the files"

    def subjects(self, case: Case) -> Iterator[Group]:
        if _concerned(case):
            classes = frozenset({"ActuatorNetLSTMCfg", "ActuatorNetMLPCfg"})
            yield from groups_of(case, Framework.ISAACLAB, classes)

    def lacks(self, case: Case) -> str:
        """A version, or a network."""
        return self.needs if _concerned(case) else "no Isaac Lab 2.2 or 2.3 is named"

    def judge(self, case: Case, group: Group) -> Iterator[Finding]:
        """Find LSTM networks in Isaac Lab 2.x."""
        named = case.versions.isaaclab
        for row in group.rows if group.cfg.cls == "ActuatorNetLSTMCfg" else ():
            limit, speed = row.effort_limit, row.no_load_speed
            if limit is not None and speed is not None:
                yield Finding(
                    self.code,
                    f"Isaac Lab {named} takes this network's torque-speed line at standstill: it may give "
                    f"{shown(row, 'effort_limit', limit)} at {shown(row, 'no_load_speed', speed)}, where the line "
                    f"has {shown(row, 'effort_limit', 0.0)}",
                    group.cfg.span,
                    row.joint,
                    help="clip in a subclass, or check that the network's training log covers these speeds",
                )


def _concerned(case: Case) -> bool:
    """Whether the files are meant for a version that does this."""
    row = isaaclab_row(case.versions)
    return row is not None and row.lstm_standstill
