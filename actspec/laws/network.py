"""The law of an actuator network: perceptron or LSTM, evaluated by arrays of any library.

    tau = torque_scale * net([position_scale * e(t - k T) ..., velocity_scale * qd(t - k T) ...])

with e = target - measured. Clamps and joint friction are not in it, as in the other laws.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from actspec.laws.actuator import TorqueLaw
from actspec.laws.arrays import Array, array_namespace


def _elu(xp: Any, x: Array, alpha: float) -> Array:
    return xp.where(x > 0, x, alpha * (xp.exp(xp.minimum(x, 0.0 * x)) - 1.0))


def _softplus(xp: Any, x: Array, alpha: float) -> Array:
    return xp.maximum(x, 0.0 * x) + xp.log(1.0 + xp.exp(-xp.abs(x)))


SELU_ALPHA, SELU_SCALE = 1.6732632423543772, 1.0507009873554805
"""Source: G. Klambauer et al., Self-Normalizing Neural Networks, 2017, section 2."""

ACTIVATIONS: Mapping[str, Callable[[Any, Array, float], Array]] = {
    "identity": lambda xp, x, alpha: x,
    "relu": lambda xp, x, alpha: xp.maximum(x, 0.0 * x),
    "leaky_relu": lambda xp, x, alpha: xp.where(x > 0, x, alpha * x),
    "elu": _elu,
    "selu": lambda xp, x, alpha: SELU_SCALE * _elu(xp, x, SELU_ALPHA),
    "tanh": lambda xp, x, alpha: xp.tanh(x),
    "sigmoid": lambda xp, x, alpha: 0.5 * (xp.tanh(0.5 * x) + 1.0),
    "softsign": lambda xp, x, alpha: x / (1.0 + xp.abs(x)),
    "softplus": _softplus,
    "silu": lambda xp, x, alpha: x * 0.5 * (xp.tanh(0.5 * x) + 1.0),
}
"""Activation to its function of namespace, argument and its one parameter."""


@dataclass(frozen=True, slots=True, eq=False)
class Dense:
    """A layer: activation(weight x + bias).

    Attributes:
        weight: Shape (n_out, n_in).
        bias: Shape (n_out,).
        activation: One of `ACTIVATIONS`.
        alpha: Its parameter: slope of `leaky_relu`, limit of `elu`.
    """

    weight: Array
    bias: Array
    activation: str = "identity"
    alpha: float = 1.0

    def __call__(self, x: Array) -> Array:
        """Of inputs, shape (..., n_in), the outputs, shape (..., n_out)."""
        xp = array_namespace(self.weight, x)
        return ACTIVATIONS[self.activation](xp, x @ self.weight.T + self.bias, self.alpha)


@dataclass(frozen=True, slots=True, eq=False)
class LstmLayer:
    """A layer of an LSTM; gates in torch's order: input, forget, cell, output.

    Attributes:
        inputs: Shape (4 n_hidden, n_in).
        hidden: Shape (4 n_hidden, n_hidden).
        bias: Sum of both biases, shape (4 n_hidden,).
    """

    inputs: Array
    hidden: Array
    bias: Array

    def __call__(self, x: Array, state: tuple[Array, Array]) -> tuple[Array, Array]:
        """Hidden and cell state after one sample, from those before it; shapes (..., n_hidden)."""
        xp = array_namespace(self.inputs, x)
        h, c = state
        n = self.hidden.shape[1]
        gates = x @ self.inputs.T + h @ self.hidden.T + self.bias
        i, f, o = (ACTIVATIONS["sigmoid"](xp, gates[..., k * n : (k + 1) * n], 1.0) for k in (0, 1, 3))
        c = f * c + i * xp.tanh(gates[..., 2 * n : 3 * n])
        return o * xp.tanh(c), c


@dataclass(frozen=True, slots=True, eq=False)
class Layers:
    """A network without its conventions.

    Attributes:
        recurrent: Layers of an LSTM, in order; empty for a perceptron.
        dense: Layers after them; the last one gives the output.
    """

    recurrent: tuple[LstmLayer, ...]
    dense: tuple[Dense, ...]

    @property
    def inputs(self) -> int:
        """Number of inputs."""
        first = self.recurrent[0].inputs if self.recurrent else self.dense[0].weight
        return int(first.shape[1])

    @property
    def outputs(self) -> int:
        """Number of outputs."""
        return int(self.dense[-1].weight.shape[0])

    @property
    def hidden(self) -> int:
        """Size of the LSTM's state; 0 for a perceptron."""
        return int(self.recurrent[0].hidden.shape[1]) if self.recurrent else 0

    def __call__(self, x: Array, state: tuple[Array, Array] | None = None) -> tuple[Array, Any]:
        """Outputs, shape (..., n_out), and the state after this sample.

        Args:
            x: Inputs, shape (..., n_in).
            state: Of an LSTM, hidden and cell, shapes (n_layer, ..., n_hidden); None: zero, or a perceptron.
        """
        if not self.recurrent:
            return self._head(x), None
        xp = array_namespace(x)
        if state is None:
            zero = 0.0 * (x @ self.recurrent[0].inputs[: self.hidden].T)
            state = (xp.stack([zero] * len(self.recurrent)), xp.stack([zero] * len(self.recurrent)))
        after = []
        for layer, h, c in zip(self.recurrent, state[0], state[1], strict=True):
            x, c = layer(x, (h, c))
            after.append((x, c))
        return self._head(x), (xp.stack([h for h, _ in after]), xp.stack([c for _, c in after]))

    def _head(self, x: Array) -> Array:
        for layer in self.dense:
            x = layer(x)
        return x


@dataclass(frozen=True, slots=True, eq=False)
class NetworkLaw:
    """A network with its conventions: torque of a drive, without clamps.

    Attributes:
        layers: The network.
        taps: Which past samples, in order; 0 is now.
        tap_period: Time between samples [s].
        velocity_first: Whether the velocities come before the position errors.
        position_scale: Factor on target - measured [1/rad or 1/m].
        velocity_scale: Factor on the velocity [s/rad or s/m].
        torque_scale: Factor on the output [N*m or N].
        backfill: Whether a history begins with its first sample; else with zeros.
    """

    layers: Layers
    taps: tuple[int, ...]
    tap_period: float
    velocity_first: bool = False
    position_scale: float = 1.0
    velocity_scale: float = 1.0
    torque_scale: float = 1.0
    backfill: bool = True

    @property
    def inputs(self) -> int:
        """Number of inputs that the conventions give."""
        return 2 * len(self.taps)

    def torque(
        self, error: Array, velocity: Array, state: tuple[Array, Array] | None = None
    ) -> tuple[Array, Any]:
        """Torque [N*m or N], shape (...), and an LSTM's state after this sample.

        Args:
            error: target - measured at the taps, in their order [rad or m], shape (..., n_tap).
            velocity: Likewise [rad/s or m/s].
            state: See `Layers`.
        """
        xp = array_namespace(error, velocity)
        parts = [self.position_scale * error, self.velocity_scale * velocity]
        found, after = self.layers(xp.concat(parts[::-1] if self.velocity_first else parts, axis=-1), state)
        return self.torque_scale * found[..., 0], after


@dataclass(frozen=True, slots=True, eq=False)
class NetworkDrive:
    """A network in its drive.

    Attributes:
        network: Its taps are physics steps.
        clip: What comes before it, of a command that is a position: clamp, delay, filter and encoder bias; and after
            it: limit and torque-speed line. Its own command is the torque.
        most: Largest error and speed in the training data [rad or m, rad/s or m/s]; None: unknown.
    """

    network: NetworkLaw
    clip: TorqueLaw
    most: tuple[float, float] | None = None


def sequence(law: NetworkLaw, error: Array, velocity: Array, stride: int) -> Array:
    """Torque along courses of even steps, each begun at a reset; numpy.

    Args:
        law: The network.
        error: target - measured [rad or m], shape (n_step, ...).
        velocity: [rad/s or m/s], likewise.
        stride: Steps between two taps.

    Returns:
        Torque in each step [N*m or N], likewise.
    """
    import numpy as np

    if law.layers.recurrent:
        out, state = [], None
        for e, w in zip(error, velocity, strict=True):
            tau, state = law.torque(e[..., None], w[..., None], state)
            out.append(tau)
        return np.stack(out)
    reach = stride * max(law.taps)

    def history(x: Array) -> Array:
        begin = np.repeat(x[:1] if law.backfill else 0.0 * x[:1], reach, axis=0)
        padded = np.concatenate([begin, x])
        return np.stack([padded[reach - stride * tap :][: len(x)] for tap in law.taps], axis=-1)

    found: Array = law.torque(history(error), history(velocity))[0]
    return found
