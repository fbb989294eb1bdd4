from __future__ import annotations

from actspec.audit.rules.spec_pairs import SpecRule


class SpecCommand(SpecRule):
    code = "SPC104"
    name = "command-path-departs-from-spec"
    fields = ("delay", "action_scale", "default_position")
    absolute = 1e-3
