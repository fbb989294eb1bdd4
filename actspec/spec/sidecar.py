"""The YAML file beside a recording of a robot: how it was made, and what its columns are."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal, TypeVar

from pydantic import Field

from actspec.patterns import match_names
from actspec.spec.values import Name, Number, SpecValue, Strict
from actspec.units import Kind

FORMAT = "actspec-log/1"
T = TypeVar("T")


class LogGains(Strict):
    """Gains as they were sent to the drive."""

    kp: Annotated[SpecValue, Number(Kind.STIFFNESS, at_least=0.0, unknown=False)]
    """Position gain [N*m/rad or N/m]."""
    kd: Annotated[SpecValue, Number(Kind.VELOCITY_GAIN, at_least=0.0, unknown=False)]
    """Velocity gain [N*m*s/rad or N*s/m]."""


class LogBase(Strict):
    """A base that is held still."""

    orientation: Annotated[tuple[float, ...], Field(min_length=4, max_length=4)]
    """Quaternion w, x, y, z from the base to the world."""


class Accuracy(Strict):
    """How far figures that the fit takes as given may be off, as standard deviations."""

    torque: Annotated[SpecValue, Number(Kind.RATIO, at_least=0.0, at_most=1.0, unknown=False)] | None = None
    """Scale of the torque that was logged [-]."""
    masses: Annotated[SpecValue, Number(Kind.RATIO, at_least=0.0, at_most=1.0, unknown=False)] | None = None
    """Masses and inertias of the model [-]."""


class Sidecar(Strict):
    """What is known of a recording."""

    format: Literal["actspec-log/1"] = FORMAT  # type: ignore[assignment]
    """Format of this file."""
    robot: Name | None = None
    """Name of the robot."""
    date: str | None = None
    """Day of the experiment, YYYY-MM-DD."""
    temperature: Literal["cold", "warm"] | None = None
    """Whether the motors were cold or warm."""
    supply: Annotated[SpecValue, Number(Kind.VOLTAGE, above=0.0, unknown=False)] | None = None
    """Voltage of the supply [V]."""
    units: dict[str, str] = Field(default_factory=dict)
    """Unit of a column without one in its header, by the column's name or by that of a signal."""
    columns: dict[str, str] = Field(default_factory=dict)
    """The file's name of a column to `JOINT.SIGNAL` or `time`."""
    torque: Literal["drive", "joint"] | None = None
    """Where the torque was measured: at the drive, before friction, or at the joint, behind it."""
    gains: dict[str, LogGains] = Field(default_factory=dict)
    """Joint, or pattern of joints, to the gains that the drive had."""
    torque_constant: dict[
        str, Annotated[SpecValue, Number(Kind.TORQUE_CONSTANT, above=0.0, unknown=False)]
    ] = Field(default_factory=dict)
    """Joint, or pattern of joints, to its torque per current, at the joint: gears count [N*m/A or N/A]."""
    base: LogBase | None = None
    """How the base was held."""
    pose: dict[str, Annotated[SpecValue, Number(Kind.POSITION, unknown=False)]] = Field(default_factory=dict)
    """Joint that has no column, or pattern of joints, to where it was held [rad or m]."""
    accuracy: Accuracy = Accuracy()
    """Of figures that the fit takes as given."""
    note: str | None = None
    """Remark."""

    def gains_of(self, joint: str) -> LogGains | None:
        """Gains that the drive of a joint had: by its name, else by the first pattern that matches it.

        Raises:
            PatternError: a pattern is refused.
        """
        return _of(self.gains, joint)

    def torque_constant_of(self, joint: str) -> float | None:
        """Torque per current that is stated of a joint, likewise [N*m/A or N/A]."""
        found = _of(self.torque_constant, joint)
        return None if found is None else found.value

    def pose_of(self, joint: str) -> float | None:
        """Where a joint was held that has no column, likewise [rad or m]."""
        found = _of(self.pose, joint)
        return None if found is None else found.value


def _of(stated: Mapping[str, T], joint: str) -> T | None:
    """What is stated of a joint, by its name or by the first pattern that matches it."""
    if joint in stated:
        return stated[joint]
    return next((value for text, value in stated.items() if match_names(text, [joint])), None)
