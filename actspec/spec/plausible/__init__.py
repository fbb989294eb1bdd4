"""Impossible numbers: what a spec's figures imply, told at the number that cannot be right.

`check_numbers` (module `numbers`) needs no robot and runs in `validate`; `check_joints` (module `joints`) judges what a
spec gives at its robot's joints and runs in `resolve`, so that `show` and `compile` have both. The table of all checks
is in `table`. The audit asks `gains` of files without a spec, for which neither that nor this loads the models of one.
"""

from __future__ import annotations

from actspec.spec.plausible.table import BY_CODE, CHECKS, Check

__all__ = ["BY_CODE", "CHECKS", "Check"]
