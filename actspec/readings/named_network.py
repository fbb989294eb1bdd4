"""The network that a group or a spec names, and what the manifest beside it says."""

from __future__ import annotations

from dataclasses import dataclass

from actspec.diagnostics import Span


@dataclass(frozen=True, slots=True)
class NetworkConventions:
    """What the manifest of an actuator network says.

    Attributes:
        path: The manifest.
        kind: `mlp`, `lstm` or `gru`.
        velocity_first: Whether the velocities come before the position errors.
        taps: Which past samples, in order; 0 is now.
        tap_period: Time between samples [s]; None: unknown.
        position_scale: Factor on target - measured.
        velocity_scale: Factor on the measured velocity.
        torque_scale: Factor on the output.
    """

    path: str
    kind: str
    velocity_first: bool
    taps: tuple[int, ...]
    tap_period: float | None
    position_scale: float
    velocity_scale: float
    torque_scale: float


@dataclass(frozen=True, slots=True)
class NetworkReading:
    """The network that a group names; its file is never opened.

    Attributes:
        file: As written; `{NAME}` stands for what is not known.
        span: Where it is written.
        local: Whether it is the path of a local file, and all of it is known.
        path: Where that file is; None: not found.
        manifest: What the manifest beside it says; None without one.
        problem: Why that manifest cannot be read; None when it can, or when there is none.
    """

    file: str
    span: Span
    local: bool
    path: str | None = None
    manifest: NetworkConventions | None = None
    problem: str | None = None
