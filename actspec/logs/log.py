"""What a recording holds, in SI units."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import ActspecError, Span, nearest, shortened
from actspec.fields import units_of
from actspec.joints import JointKind
from actspec.units import Kind

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from actspec.spec.sidecar import Sidecar

    Array = NDArray[np.float64]


class LogError(ActspecError):
    """A recording is no log, or cannot be used."""


SIGNALS: Mapping[str, Kind | None] = {
    "command": Kind.POSITION,
    "position": Kind.POSITION,
    "velocity": Kind.SPEED,
    "velocity_command": Kind.SPEED,
    "torque": Kind.TORQUE,
    "torque_command": Kind.TORQUE,
    "current": Kind.CURRENT,
    "enabled": None,
}
"""What a column `JOINT.SIGNAL` may be, and of which kind; `enabled` is 0 or 1."""


def signal_like(name: str) -> str | None:
    """The signal that a short or misspelt name may stand for, such as `pos`; None: none is near."""
    name = name.lower()
    begins = [signal for signal in SIGNALS if len(name) >= _SHORTEST and signal.startswith(name)]
    return min(begins, key=len) if begins else nearest(name, list(SIGNALS))


_SHORTEST = 3
"""Letters of an abbreviation. Chosen: `t` and `q` are many things."""

BASE: Mapping[str, tuple[str, str]] = {
    "position": ("xyz", "m"),
    "orientation": ("wxyz", ""),
    "linear_velocity": ("xyz", "m/s"),
    "angular_velocity": ("xyz", "rad/s"),
}
"""What columns `base.SIGNAL.COMPONENT` may be: components, a column each, and unit."""


@dataclass(frozen=True, slots=True)
class BaseLog:
    """How a base that is free moved; None: not recorded. A cell without a number is NaN.

    Attributes:
        position: In the world [m], shape (n, 3).
        orientation: Quaternion w, x, y, z from the base to the world, shape (n, 4).
        linear_velocity: In the world [m/s], shape (n, 3).
        angular_velocity: In the base's own axes, as a gyroscope reads it [rad/s], shape (n, 3).
    """

    position: Array | None = None
    orientation: Array | None = None
    linear_velocity: Array | None = None
    angular_velocity: Array | None = None


@dataclass(frozen=True, slots=True)
class JointLog:
    """One joint's columns; None: not recorded. A cell without a number is NaN.

    Attributes:
        name: Of the joint.
        linear: Whether its units are those of a slide; None where none tells.
        command: Position command, sent at the row's time and held until the next [rad or m], shape (n,).
        position: As read at the row's time, bias included [rad or m], likewise.
        velocity: [rad/s or m/s].
        velocity_command: [rad/s or m/s].
        torque: Before or behind friction, as the sidecar says [N*m or N].
        torque_command: [N*m or N].
        current: [A].
        enabled: Whether the drive was on: 1 or 0.
    """

    name: str
    linear: bool | None = None
    command: Array | None = None
    position: Array | None = None
    velocity: Array | None = None
    velocity_command: Array | None = None
    torque: Array | None = None
    torque_command: Array | None = None
    current: Array | None = None
    enabled: Array | None = None

    @property
    def kind(self) -> JointKind:
        """A slide where its units say so, else a hinge."""
        return JointKind.SLIDE if self.linear else JointKind.HINGE

    def unlike(self, kind: JointKind) -> str | None:
        """Why columns in such units are none of a joint of this kind; None: they may be."""
        if self.linear is None or self.kind is kind:
            return None
        return f"its columns are in {units_of(self.kind).position}, but the joint is a {kind.value}"

    @property
    def signals(self) -> dict[str, Array]:
        """Those that were recorded, by name."""
        return {name: found for name in SIGNALS if (found := getattr(self, name)) is not None}


@dataclass(frozen=True, slots=True)
class Log:
    """A recording. A row is what was read at its time and the command sent then, held until the next row.

    Attributes:
        path: As the user named it.
        sha256: Of its bytes.
        time: From the first row on [s], shape (n,); it grows from row to row.
        joints: By name, in the order of the columns.
        sidecar: What stands in the YAML file beside it; with nothing stated where there is none.
        ignored: Columns that are no signal of a joint or of the base.
        first_row: Line of the first row in the file, from 1.
        base: How the base moved; None: no column tells.
    """

    path: str
    sha256: str
    time: Array
    joints: Mapping[str, JointLog]
    sidecar: Sidecar
    ignored: tuple[str, ...] = ()
    first_row: int = 1
    base: BaseLog | None = None

    @property
    def step(self) -> float:
        """The usual time between two rows, their median [s]."""
        import numpy as np

        return float(np.median(np.diff(self.time)))

    def misnamed(self, joint: str, signals: Iterable[str]) -> str | None:
        """Help where a joint lacks signals: a column of it that may be one of them by another name; None: it has none.

        Args:
            joint: Its name.
            signals: What it lacks.
        """
        lacking = frozenset(signals)
        for column in self.ignored:
            owner, _, name = column.rpartition(".")
            if owner == joint and (signal := signal_like(name)) in lacking:
                return f"is it '{shortened(column)}'? Name that column `{joint}.{signal}`"
        return None

    def span(self, index: int) -> Span:
        """Place of a row, counted from 0."""
        return Span(self.path, self.first_row + index)
