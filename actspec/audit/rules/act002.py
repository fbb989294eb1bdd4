from __future__ import annotations

from actspec.audit.rules.remarks import RemarkRule


class UnusedIgnore(RemarkRule):
    code = "ACT002"
    name = "unused-ignore"
