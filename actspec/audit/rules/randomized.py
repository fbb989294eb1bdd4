"""The joints that a range randomises, and what their nominal values are."""

from __future__ import annotations

from collections.abc import Iterator
from os.path import basename

from actspec.audit.case import Case
from actspec.audit.rules.configs import groups_of
from actspec.audit.rules.joints import unit
from actspec.readings.artifact import FileKind, Framework, RandomizedRange, RobotConfig
from actspec.readings.ledger import LedgerRow
from actspec.units import format_number, format_quantity

DEVIATIONS = 3.0
"""Half width of a normal distribution's range, in deviations. Chosen: 99.7 % of the draws."""

FIELDS = {
    "kp": "kp",
    "kd": "kd",
    "armature": "armature",
    "friction": "frictionloss",
    "joint_damping": "joint_damping",
    "effort_limit": "effort_limit",
}
"""Field of a range to the field of a row."""

_OF_THE_MODEL = ("armature", "frictionloss", "joint_damping")
"""Those of them that a joint of a model has."""


def ranges(case: Case) -> Iterator[tuple[int, RobotConfig, RandomizedRange]]:
    """Every range of every configuration: artifact, configuration, range.

    A base without actuators is left out for what configurations with actuators inherit from it: they say what it does.
    So is a range of the start that every reset draws anew, from the nominal values.
    """
    configs = [(index, one.config) for index, one in case.of_kind(FileKind.CFG) if one.config is not None]
    inherited = {one.span for _, config in configs if config.groups for one in config.randomize}
    for index, config in configs:
        for one in config.randomize:
            if (config.groups or one.span not in inherited) and not _is_drawn_anew(config, one):
                yield index, config, one


def _is_drawn_anew(config: RobotConfig, one: RandomizedRange) -> bool:
    """Whether a range of the start is drawn again at every reset, for the same joints or all.

    Isaac Lab's and mjlab's events start from the configuration's values and not from what was drawn before.
    """
    return one.when in ("startup", "prestartup") and any(
        other.when == "reset" and other.field == one.field and _takes_all_of(other, one)
        for other in config.randomize
    )


def _takes_all_of(later: RandomizedRange, one: RandomizedRange) -> bool:
    """Whether a range takes every joint of another one."""
    return later.actuators == one.actuators and (
        later.joints is None or ".*" in later.joints or later.joints == one.joints
    )


def whose(row: LedgerRow, one: RandomizedRange) -> str:
    """Whose figure it is, in a sentence: that of the file with the range, or another's."""
    return "the configuration's" if row.file == one.span.path else f"{basename(row.file)}'s"


def nominal(case: Case, config: RobotConfig, row: LedgerRow, one: RandomizedRange) -> float | None:
    """What is stated for the randomised field of a joint, in the range's own unit."""
    if one.field == "friction" and config.framework is Framework.ISAACLAB:
        # A coefficient or a torque: the range is in the same unit as the setting.
        for group in groups_of(case, Framework.ISAACLAB):
            if row in group.rows:
                return group.number(group.written("friction"), row.joint)
        return None
    field = FIELDS.get(one.field)
    if field is None or _is_set_on_the_spec(case.artifacts[row.artifact].config, row, field):
        return None
    value: float | None = getattr(row, field)
    return value


def _is_set_on_the_spec(config: RobotConfig | None, row: LedgerRow, field: str) -> bool:
    """Whether the function that loads mjlab's model sets a joint's figure there, and no actuator cfg after it."""
    edit = field.removeprefix("joint_")
    own = field in row.stated and row.place(field).path == row.file
    return config is not None and edit in config.edited and field in _OF_THE_MODEL and not own


def range_unit(config: RobotConfig, row: LedgerRow, one: RandomizedRange) -> str:
    """Unit of the nominal value; `1` where the version decides on it."""
    if one.field == "friction" and config.framework is Framework.ISAACLAB:
        return "1"
    return unit(row, FIELDS[one.field])


def ends(one: RandomizedRange) -> tuple[float, float]:
    """Least and greatest value that is drawn; of a normal distribution within three deviations."""
    if one.distribution == "gaussian":
        half = DEVIATIONS * abs(one.high)
        return one.low - half, one.low + half
    return min(one.low, one.high), max(one.low, one.high)


def about_range(one: RandomizedRange) -> str:
    """What tells a range from others of its file: its field, how it is drawn, and its ends as they are written."""
    return f"{one.field} {one.operation} {one.low:.4g} {one.high:.4g}"


def written(low: float, high: float, unit: str = "1") -> str:
    """`0.8 to 1.2`."""
    return f"{format_number(low, 3)} to {format_quantity(high, unit, 3)}"
