"""Manifest of an actuator network: the conventions that a network file alone does not tell."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from actspec.spec.base import Strict
from actspec.spec.values import Number, SpecValue
from actspec.units import Kind


class NetworkManifest(Strict):
    """Inputs, scales, order and period of an actuator network.

    The law is tau = torque_scale * net([position_scale * e(t - k T) ..., velocity_scale * qd(t - k T) ...])
    with e = target - measured and T = tap_period.
    """

    format: Literal["actspec-network/1"]
    """Format of this file."""
    kind: Literal["mlp", "lstm", "gru"]
    """Kind of network."""
    inputs: Literal["position_velocity", "velocity_position"]
    """Which block of inputs comes first."""
    error: Literal["target_minus_measured"] = "target_minus_measured"
    """Sign of the position error; scales carry a minus where the network was trained the other way."""
    taps: Annotated[tuple[Annotated[int, Field(ge=0)], ...], Field(min_length=1)]
    """Which past samples, in order; 0 is now."""
    tap_period: Annotated[SpecValue, Number(Kind.TIME, above=0.0)]
    """Time between samples, T [s]."""
    position_scale: float
    """Factor on the position error [1/rad or 1/m]."""
    velocity_scale: float
    """Factor on the velocity [s/rad or s/m]."""
    torque_scale: float
    """Factor on the output [N*m or N]."""
    initial_history: Literal["zero", "first_sample"]
    """What stands in the history at a reset."""
    hidden_size: Annotated[int, Field(ge=1)] | None = None
    """Of an lstm or gru."""
    num_layers: Annotated[int, Field(ge=1)] | None = None
    """Of an lstm or gru."""
    joints: tuple[str, ...] = ()
    """Joints that the network was trained on; empty: not recorded."""
    sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")] | None = None
    """Hash of the network file."""
    note: str | None = None
    """Remark."""
