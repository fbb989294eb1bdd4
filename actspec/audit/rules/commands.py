"""What the clamp of a servo's command leaves of its torque."""

from __future__ import annotations

from actspec.audit.case import Case
from actspec.audit.rules.joints import shown
from actspec.audit.rules.unt101 import ranges_in_doubt
from actspec.readings.ledger import LedgerRow, bound_of_command
from actspec.robot.view import ActuatorView


def bound_of(row: LedgerRow, view: ActuatorView) -> tuple[float | None, str]:
    """As `bound_of_command`: the largest torque, and how it comes about in words."""
    found = bound_of_command(row, view)
    if found is None:
        return None, ""
    gain, reach = found
    field, of, name = (
        ("kd", "velocity_limit", "kv") if row.control == "velocity" else ("kp", "default_position", "kp")
    )
    return gain * reach, f"{name} {shown(row, field, gain)} x {shown(row, of, reach)}"


def is_in_doubt(case: Case, row: LedgerRow) -> bool:
    """Whether the range of a joint or of its command is in another unit than it is read in."""
    places = (row.place(field).path for field in ("position_range", "command_range"))
    return any((path, row.joint) in case.once(ranges_in_doubt) for path in places)
