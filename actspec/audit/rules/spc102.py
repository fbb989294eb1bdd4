from __future__ import annotations

from actspec.audit.rules.spec_pairs import SpecRule


class SpecLimit(SpecRule):
    code = "SPC102"
    name = "limit-departs-from-spec"
    fields = ("effort_limit", "velocity_limit", "stall_torque", "no_load_speed")
