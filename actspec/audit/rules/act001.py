from __future__ import annotations

from actspec.audit.rules.remarks import RemarkRule


class IgnoreWithoutReason(RemarkRule):
    code = "ACT001"
    name = "ignore-without-reason"
