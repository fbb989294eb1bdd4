"""The YAML file beside a recording: how it was made, and what its columns are."""

from __future__ import annotations

import os
from typing import Annotated, Literal

from pydantic import Field

from actspec.diagnostics import Collector, SpecError
from actspec.logs.log import LogError
from actspec.spec.document import load_document
from actspec.spec.validate import checked
from actspec.spec.values import Name, Number, SpecValue, Strict
from actspec.units import Kind

FORMAT = "actspec-log/1"


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
    """Scale of the torque that was logged."""
    masses: Annotated[SpecValue, Number(Kind.RATIO, at_least=0.0, at_most=1.0, unknown=False)] | None = None
    """Masses and inertias of the model."""


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
    supply: Annotated[SpecValue, Number(Kind.VOLTAGE, above=0.0)] | None = None
    """Voltage of the supply [V]."""
    units: dict[str, str] = Field(default_factory=dict)
    """Unit of a column without one in its header, by the column's name or by that of a signal."""
    columns: dict[str, str] = Field(default_factory=dict)
    """The file's name of a column to `JOINT.SIGNAL` or `time`."""
    torque: Literal["drive", "joint"] | None = None
    """Where the torque was measured: at the drive, before friction, or at the joint, behind it."""
    gains: dict[str, LogGains] = Field(default_factory=dict)
    """Joint, or pattern of joints, to the gains that the drive had."""
    base: LogBase | None = None
    """How the base was held."""
    accuracy: Accuracy = Accuracy()
    """Of figures that the fit takes as given."""
    note: str | None = None
    """Remark."""


def sidecar_path(path: str) -> str:
    """Where the sidecar of a log stands: the log's name with `.yaml`."""
    return os.path.splitext(path)[0] + ".yaml"


def load_sidecar(path: str) -> Sidecar:
    """The sidecar of a log; one with nothing stated where there is no file.

    Args:
        path: Of the log.

    Raises:
        LogError: with every error of the file.
    """
    beside = sidecar_path(path)
    if not os.path.lexists(beside):
        return Sidecar()
    collector = Collector()
    try:
        document = load_document(beside)
        if "format" not in document.data:
            collector.error(
                "LOG010",
                "the file beside the log does not name its format",
                span=document.spans.value(()),
                help=f"write `format: {FORMAT}`, or give the file another name",
            )
        found = checked(Sidecar, document, collector)
    except SpecError as err:
        raise LogError(err.diagnostics) from err
    collector.raise_if_failed(LogError)
    assert found is not None
    return found
