from __future__ import annotations

from actspec.audit.rules.remarks import RemarkRule


class UnknownIgnore(RemarkRule):
    code = "ACT003"
    name = "unknown-ignore"
