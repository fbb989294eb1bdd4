"""An ONNX file as a function of arrays: data, read by onnx and computed by numpy or torch, never run.

For networks that are no chain of layers, such as those of a delta action. The operations are few and have no state;
whatever else stands in a file is named, and the file is refused.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from actspec.laws.arrays import array_namespace
from actspec.laws.network import ACTIVATIONS as FUNCTIONS
from actspec.readings.onnx_network import (
    ACTIVATIONS,
    NetworkFileError,
    NetworkUnknown,
    constants_of,
    graph_of,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MOST_NUMBERS = 50_000_000
"""Most numbers that an operation may make of one row. Chosen: 200 MB."""


@dataclass(frozen=True, slots=True)
class _Node:
    """One operation."""

    kind: str
    inputs: tuple[str, ...]
    output: str
    attributes: dict[str, Any]


class Graph:
    """A network of one input and one output, rows first; of numpy arrays or torch tensors, in their precision.

    Args:
        data: Bytes of the file.

    Raises:
        NetworkFileError: it is none, is cut off, or names other files.
        NetworkUnknown: it holds an operation that is not known.
        OnnxMissing: onnx is not installed.
    """

    def __init__(self, data: bytes) -> None:
        from onnx import helper

        graph = graph_of(data)
        self._constants = constants_of(graph)
        inputs = [item.name for item in graph.input if item.name not in self._constants]
        if len(inputs) != 1 or len(graph.output) != 1:
            raise NetworkUnknown(
                f"it has {len(inputs)} inputs and {len(graph.output)} outputs, and one of each is read"
            )
        self.input, self.output = inputs[0], graph.output[0].name
        self._nodes, known = [], {*self._constants, self.input}
        for node in graph.node:
            if node.op_type == "Constant":
                continue
            if (node.op_type not in OPERATIONS and node.op_type not in ACTIVATIONS) or node.domain not in (
                "",
                "ai.onnx",
            ):
                raise NetworkUnknown(f"its operation {node.op_type[:40]} is not one that is known")
            names = tuple(name for name in node.input if name)
            if not names or not set(names) <= known or len(node.output) != 1:
                raise NetworkFileError("its operations are in no order")
            attributes = {item.name: helper.get_attribute_value(item) for item in node.attribute}
            self._nodes.append(_Node(node.op_type, names, node.output[0], attributes))
            known.add(node.output[0])
        if self.output not in known:
            raise NetworkFileError("nothing gives its output")
        self._cast: dict[Any, dict[str, Any]] = {}

    def __call__(self, x: Any) -> Any:
        """Outputs, shape (n, n_out), of inputs, shape (n, n_in).

        Raises:
            NetworkFileError: sizes do not fit.
        """
        xp = array_namespace(x)
        values = dict(self._like(xp, x))
        values[self.input] = x
        try:
            for node in self._nodes:
                if node.kind in ACTIVATIONS:
                    name, alpha = ACTIVATIONS[node.kind]
                    alpha = float(node.attributes.get("alpha", alpha))
                    found = FUNCTIONS[name](xp, values[node.inputs[0]], alpha)
                else:
                    found = OPERATIONS[node.kind](xp, [values[name] for name in node.inputs], node.attributes)
                size = 1
                for part in found.shape:
                    size *= int(part)
                if size > MOST_NUMBERS * max(len(x), 1):
                    raise NetworkFileError("it makes too many numbers of a row")
                values[node.output] = found
        except (ValueError, RuntimeError, IndexError, KeyError, TypeError, AttributeError) as err:
            if isinstance(err, NetworkFileError):
                raise
            raise NetworkFileError(f"its sizes do not fit: {str(err).splitlines()[0][:200]}") from err
        return values[self.output]

    def _like(self, xp: Any, x: Any) -> dict[str, Any]:
        """Constants of the inputs' library, precision and device; those that stand for places are integers."""
        torch = xp.__name__ == "torch"
        key = (xp.__name__, str(x.dtype), str(x.device) if torch else "")
        if key not in self._cast:
            places = {
                name
                for node in self._nodes
                for name in (node.inputs[1:2] if node.kind in ("Gather", "Reshape") else ())
            }
            made = {}
            for name, value in self._constants.items():
                if name in places:
                    value = value.astype("int64")
                    made[name] = xp.asarray(value, device=x.device) if torch else value
                else:
                    made[name] = xp.asarray(value, dtype=x.dtype, **({"device": x.device} if torch else {}))
            self._cast[key] = made
        return self._cast[key]


def _gather(xp: Any, inputs: list[Any], attributes: dict[str, Any]) -> Any:
    x, places = inputs
    axis = int(attributes.get("axis", 0)) % x.ndim
    return x[(slice(None),) * axis + (places,)]


def _gemm(xp: Any, inputs: list[Any], attributes: dict[str, Any]) -> Any:
    a, b = inputs[:2]
    a = a.T if attributes.get("transA") else a
    b = b.T if attributes.get("transB") else b
    found = float(attributes.get("alpha", 1.0)) * (a @ b)
    return found + float(attributes.get("beta", 1.0)) * inputs[2] if len(inputs) > 2 else found


def _transpose(xp: Any, inputs: list[Any], attributes: dict[str, Any]) -> Any:
    order = [int(k) for k in attributes.get("perm", range(inputs[0].ndim)[::-1])]
    return inputs[0].permute(order) if hasattr(inputs[0], "permute") else inputs[0].transpose(order)


def _reshape(xp: Any, inputs: list[Any], attributes: dict[str, Any]) -> Any:
    x, wanted = inputs
    shape = [int(size) for size in wanted]
    return x.reshape([x.shape[k] if size == 0 else size for k, size in enumerate(shape)])


OPERATIONS: dict[str, Callable[[Any, list[Any], dict[str, Any]], Any]] = {
    "Add": lambda xp, x, _: x[0] + x[1],
    "Sub": lambda xp, x, _: x[0] - x[1],
    "Mul": lambda xp, x, _: x[0] * x[1],
    "Div": lambda xp, x, _: x[0] / x[1],
    "MatMul": lambda xp, x, _: x[0] @ x[1],
    "Identity": lambda xp, x, _: x[0],
    "Concat": lambda xp, x, given: xp.concatenate(x, axis=int(given["axis"])),
    "Gather": _gather,
    "Gemm": _gemm,
    "Transpose": _transpose,
    "Reshape": _reshape,
}
"""Operation to its function of namespace, arrays and attributes, beside the activations of networks. Source: ONNX
operator schemas."""
