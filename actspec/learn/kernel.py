"""A perceptron on many rows as fast as the processor takes it: in blocks that stay in its cache, in place.

A forward pass as libraries write it allocates each layer's outputs anew; of 4096 environments these do not fit a
cache. The same arithmetic on blocks of rows, into arrays that are used again, takes less time than the pass alone.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from actspec.laws.network import ACTIVATIONS, Dense, Layers

if TYPE_CHECKING:
    from collections.abc import Sequence

CACHE = 1 << 19
"""Numbers of a block, rows times the widest layer. Measured by benchmarks/runtime.py on 2 threads: 0.86 to 0.93 of the
bare pass; a quarter and four times as many are slower for the small network."""


def numpy_forward(layers: Layers, dtype: Any) -> Callable[[Any], Any]:
    """The network as a function of inputs, shape (n, n_in), to outputs, shape (n,), by numpy.

    Scratch arrays are the function's own: two threads need two of them.
    """
    import numpy as np

    parts = [
        (np.ascontiguousarray(d.weight.T.astype(dtype)), d.bias.astype(dtype), _numpy_activation(d, dtype))
        for d in layers.dense
    ]
    scratch: list[tuple[Any, Any]] = []
    most = _rows(layers)

    def block(x: Any) -> Any:
        for (weight, bias, act), (to, other) in zip(parts, scratch, strict=True):
            np.matmul(x, weight, out=to)
            to += bias
            if act is not None:
                act(to, other)
            x = to
        return x[:, 0]

    def run(x: Any) -> Any:
        n = min(len(x), most)
        if not scratch or len(scratch[0][0]) != n:
            scratch[:] = [
                (np.empty((n, len(bias)), dtype), np.empty((n, len(bias)), dtype)) for _, bias, _ in parts
            ]
        if len(x) == n:
            return block(x)
        whole = len(x) - len(x) % n
        rest = numpy_forward(layers, dtype)(x[whole:]) if whole < len(x) else x[:0, 0]
        return np.concatenate([*(block(x[k : k + n]).copy() for k in range(0, whole, n)), rest])

    return run


def _rows(layers: Layers) -> int:
    """Rows of a block."""
    return max(CACHE // max(len(dense.bias) for dense in layers.dense), 1)


def _numpy_activation(dense: Dense, dtype: Any) -> Callable[[Any, Any], object] | None:
    """Of an array in place, with another of its shape for what is between; None: identity."""
    import numpy as np

    kind = dense.activation
    # Numbers of Python are converted anew in each call, which takes as long as the arithmetic.
    zero, one = np.zeros((), dtype), np.ones((), dtype)

    def elu(x: Any, low: Any) -> None:
        # Not expm1, which takes ten times as long; what it would add is below 1e-16.
        np.exp(np.minimum(x, zero, out=low), out=low)
        low -= one
        # exp(x) - 1 is nowhere below x, and 0 where x is positive.
        np.maximum(x, low, out=x)

    def softsign(x: Any, low: Any) -> None:
        np.abs(x, out=low)
        low += one
        x /= low

    def other(x: Any, _: Any) -> None:
        x[...] = ACTIVATIONS[kind](np, x, dense.alpha)

    functions: dict[str, Callable[[Any, Any], object] | None] = {
        "identity": None,
        "relu": lambda x, _: np.maximum(x, zero, out=x),
        "tanh": lambda x, _: np.tanh(x, out=x),
        "softsign": softsign,
        "elu": elu if dense.alpha == 1.0 else other,
    }
    return functions.get(kind, other)


def torch_forward(layers: Layers, dtype: Any, device: Any) -> Callable[[Any, Any], Any]:
    """Likewise by torch, on a device: of inputs by column, shape (n_in, n), and the first layer's weights for them.

    A history of samples is such a matrix as it stands, a row a sample: the weights are put in the order of its rows,
    and nothing is copied. On a GPU it is one block.
    """
    import torch

    def tensor(value: Any) -> Any:
        return torch.as_tensor(value, dtype=dtype, device=device)

    parts = [(tensor(d.weight), tensor(d.bias)[:, None], _torch_activation(d)) for d in layers.dense]
    on_cpu = torch.device(device).type == "cpu"
    size = _rows(layers) if on_cpu else 0
    scratch = [torch.empty((len(bias), size), dtype=dtype) for _, bias, _ in parts] if on_cpu else []

    def run(x: Any, first: Any) -> Any:
        count = x.shape[1]
        with torch.no_grad():
            out = torch.empty(count, dtype=dtype, device=device)
            for begin in range(0, count, size or count):
                now = x[:, begin : begin + (size or count)]
                n = now.shape[1]
                for i, (weight, bias, act) in enumerate(parts):
                    space = scratch[i][:, :n] if n == size else None
                    now = act(torch.addmm(bias, first if i == 0 else weight, now, out=space))
                out[begin : begin + n] = now[0]
            return out

    return run


def _torch_activation(dense: Dense) -> Callable[[Any], Any]:
    import torch

    functions: dict[str, Callable[[Any], Any]] = {
        "identity": lambda x: x,
        "relu": torch.relu_,
        "tanh": torch.tanh_,
        "sigmoid": torch.sigmoid_,
        "elu": lambda x: torch.nn.functional.elu_(x, dense.alpha),
        "selu": torch.selu_,
        "leaky_relu": lambda x: torch.nn.functional.leaky_relu_(x, dense.alpha),
        "softsign": lambda x: x.div_(x.abs().add_(1.0)),
        "softplus": torch.nn.functional.softplus,
        "silu": lambda x: torch.nn.functional.silu(x, inplace=True),
    }
    return functions[dense.activation]


def recurrent_forward(layers: Layers, like: Any) -> tuple[Layers, Sequence[int]]:
    """An LSTM's layers as arrays like one's own, and the shape of a state without rows: layers, numbers."""
    from actspec.laws.arrays import array_namespace
    from actspec.laws.network import LstmLayer

    xp = array_namespace(like)

    def array(value: Any) -> Any:
        if xp.__name__ == "torch":
            return xp.as_tensor(value, dtype=like.dtype, device=like.device)
        return xp.asarray(value, dtype=like.dtype)

    recurrent = tuple(LstmLayer(array(r.inputs), array(r.hidden), array(r.bias)) for r in layers.recurrent)
    dense = tuple(Dense(array(d.weight), array(d.bias), d.activation, d.alpha) for d in layers.dense)
    return Layers(recurrent, dense), (len(recurrent), layers.hidden)
