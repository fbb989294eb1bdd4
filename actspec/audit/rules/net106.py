from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.rule import Rule
from actspec.audit.rules.cfg_groups import groups_of
from actspec.audit.rules.joint_units import shown
from actspec.diagnostics import Severity
from actspec.readings.artifact import (
    Framework,
)
from actspec.readings.versions import release


class NetworkWithoutSpeedClip(Rule):
    code = "NET106"
    name = "network-without-speed-clip"
    severity = Severity.INFO
    confidence = Confidence.HIGH

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """Find LSTM networks in Isaac Lab 2.x."""
        named = case.versions.isaaclab
        if named is None or not (2, 2) <= release(named)[:2] < (3,):
            yield Skipped(self.code, "no Isaac Lab 2.2 or 2.3 is named")
            return
        looked = False
        for group in groups_of(
            case, Framework.ISAACLAB, frozenset({"ActuatorNetLSTMCfg", "ActuatorNetMLPCfg"})
        ):
            looked = True
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
        if not looked:
            yield Skipped(self.code, "no network of Isaac Lab among the files")
