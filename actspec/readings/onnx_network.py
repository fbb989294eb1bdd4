"""A network file in ONNX as layers: data, read by onnx and never run.

Chains of what actuator networks are made of are known: affine layers, activations, factors and offsets, one LSTM.
Whatever else stands in a file is named, and the file is refused.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from actspec.laws.network import Dense, Layers, LstmLayer

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MOST_NODES = 1000
"""Most operations of a network. Chosen: actuator networks have some ten."""
MOST_WEIGHTS = 20_000_000
"""Most numbers of a network. Chosen: actuator networks have some thousands."""

ACTIVATIONS: Mapping[str, tuple[str, float]] = {
    "Relu": ("relu", 0.0),
    "LeakyRelu": ("leaky_relu", 0.01),
    "Elu": ("elu", 1.0),
    "Selu": ("selu", 0.0),
    "Tanh": ("tanh", 0.0),
    "Sigmoid": ("sigmoid", 0.0),
    "Softsign": ("softsign", 0.0),
    "Softplus": ("softplus", 0.0),
}
"""Operation to the activation and the default of its `alpha`. Source: ONNX operator schemas."""
_SHAPING = {"Identity", "Dropout", "Flatten", "Squeeze", "Unsqueeze", "Reshape", "Cast", "Transpose"}
"""Operations that change no number."""


class NetworkFileError(ValueError):
    """A file is no network that is known; its text says why."""


class NetworkUnknown(NetworkFileError):
    """An ONNX file holds what actuator networks are not made of."""


class OnnxMissing(ImportError):
    """onnx is not installed."""


def read_onnx(data: bytes) -> Layers:
    """The layers of an ONNX file.

    Raises:
        NetworkFileError: it is none, is cut off, or names other files.
        NetworkUnknown: it holds an operation that is not known.
        OnnxMissing: onnx is not installed.
    """
    graph = graph_of(data)
    reader = _Chain(constants_of(graph))
    inputs = [item.name for item in graph.input if item.name not in reader.constants]
    if not inputs or not graph.output:
        raise NetworkFileError("it has no input or no output")
    reader.now = {inputs[0]}
    for node in graph.node:
        reader.take(node)
    if graph.output[0].name not in reader.now:
        raise NetworkUnknown("its output does not follow from its input in one chain")
    return reader.layers()


def graph_of(data: bytes) -> Any:
    """The operations of an ONNX file, as onnx has them; see `read_onnx` for errors."""
    try:
        import onnx
        from google.protobuf.message import DecodeError  # type: ignore[import-untyped]
    except ImportError as err:
        raise OnnxMissing("onnx is not installed") from err
    if not data:
        raise NetworkFileError("it is empty")
    try:
        model = onnx.load_model_from_string(data)
    except DecodeError as err:
        raise NetworkFileError("it is no ONNX file, or it is cut off") from err
    graph = model.graph
    if not graph.node:
        raise NetworkFileError("it is no ONNX file, or it holds no operation")
    if len(graph.node) > MOST_NODES:
        raise NetworkFileError(f"it has {len(graph.node)} operations, at most {MOST_NODES} are read")
    return graph


def constants_of(graph: Any) -> dict[str, Array]:
    """Its weights and other constants by name, checked; see `read_onnx` for errors."""
    import numpy as np
    from onnx import TensorProto, numpy_helper

    tensors = {item.name: item for item in graph.initializer}
    for node in graph.node:
        stated = [item.t for item in node.attribute if item.name == "value"]
        if node.op_type == "Constant" and node.output and stated:
            tensors[node.output[0]] = stated[0]
    total = 0
    found = {}
    for name, tensor in tensors.items():
        if tensor.data_location == TensorProto.EXTERNAL or tensor.external_data:
            raise NetworkFileError("its weights are in another file: write them into the ONNX file")
        total += int(np.prod([float(size) for size in tensor.dims]))
        if total > MOST_WEIGHTS:
            raise NetworkFileError(f"it has more than {MOST_WEIGHTS} weights")
        try:
            found[name] = np.asarray(numpy_helper.to_array(tensor), dtype=float)
        except (ValueError, TypeError, KeyError) as err:
            raise NetworkFileError(f"its tensor '{name[:60]}' cannot be read") from err
        if not np.isfinite(found[name]).all():
            raise NetworkFileError(f"its tensor '{name[:60]}' is not finite")
    return found


@dataclass(slots=True)
class _Chain:
    """What has been read up to a tensor."""

    constants: dict[str, Array]
    now: set[str] = field(default_factory=set)
    dense: list[Dense] = field(default_factory=list)
    recurrent: list[LstmLayer] = field(default_factory=list)
    sizes: dict[str, tuple[str, float]] = field(default_factory=dict)
    """Tensor to x and c, where it is |x| + c."""

    def take(self, node: Any) -> None:
        """The next operation."""
        kind, inputs = node.op_type, list(node.input)
        if self._softsign(kind, inputs, node.output[0] if node.output else ""):
            return
        if kind == "Constant" or not self.now & set(inputs):
            if kind != "Constant" and not all(name in self.constants or not name for name in inputs):
                raise NetworkUnknown(f"its operation {kind} is not part of one chain")
            return
        attributes = {item.name: item for item in node.attribute}
        if kind == "Gemm":
            self._gemm(inputs, attributes)
        elif kind == "MatMul":
            if inputs[0] not in self.now or inputs[1] not in self.constants:
                raise NetworkUnknown("it multiplies by something that is no constant")
            weight = self.constants[inputs[1]].T
            self._add(Dense(weight, 0.0 * weight[:, 0]))
        elif kind in ("Add", "Sub", "Mul", "Div"):
            self._by_constant(kind, inputs)
        elif kind in ACTIVATIONS:
            name, alpha = ACTIVATIONS[kind]
            stated = attributes.get("alpha")
            self._activate(name, float(stated.f) if stated is not None else alpha)
        elif kind == "LSTM":
            self._lstm(inputs, attributes)
            # Of its three outputs the sequence goes on.
            self.now = {node.output[0], *(list(node.output)[1:2])}
            return
        elif kind not in _SHAPING:
            raise NetworkUnknown(f"its operation {kind[:40]} is not one of an actuator network")
        self.now = {node.output[0]}

    def layers(self) -> Layers:
        """All of it."""
        if not self.dense:
            raise NetworkUnknown("it has no layer")
        return Layers(tuple(self.recurrent), tuple(self.dense))

    def _add(self, layer: Dense) -> None:
        before = self.dense[-1] if self.dense else None
        width = before.weight.shape[0] if before is not None else None
        if before is None and self.recurrent:
            width = self.recurrent[-1].hidden.shape[1]
        if layer.weight.ndim != 2 or (width is not None and layer.weight.shape[1] != width):
            raise NetworkFileError("the sizes of its layers do not fit")
        self.dense.append(layer)

    def _gemm(self, inputs: list[str], attributes: Mapping[str, Any]) -> None:
        weight = self.constants.get(inputs[1])
        if weight is None or weight.ndim != 2 or (attributes.get("transA") and attributes["transA"].i):
            raise NetworkUnknown("it multiplies by something that is no constant")
        transposed = "transB" in attributes and attributes["transB"].i
        weight = (weight if transposed else weight.T) * _factor(attributes, "alpha")
        bias = self.constants.get(inputs[2]) if len(inputs) > 2 and inputs[2] else 0.0 * weight[:, 0]
        if bias is None or bias.size not in (1, len(weight)):
            raise NetworkFileError("the sizes of its layers do not fit")
        bias = bias.reshape(-1) * _factor(attributes, "beta") + 0.0 * weight[:, 0]
        self._add(Dense(weight, bias))

    def _by_constant(self, kind: str, inputs: list[str]) -> None:
        """A factor or an offset, which goes into an affine layer."""
        import numpy as np

        mine = inputs[0] in self.now
        other = self.constants.get(inputs[1] if mine else inputs[0])
        if other is None:
            raise NetworkUnknown(f"its operation {kind} joins two branches")
        last = self.dense[-1] if self.dense else None
        width = other.size if last is None else last.weight.shape[0]
        value = other.reshape(-1)
        if value.size not in (1, width) or (kind == "Div" and (not mine or not value.all())):
            raise NetworkUnknown(f"its operation {kind} is not one of an actuator network")
        if last is None or last.activation != "identity":
            if last is None and value.size == 1:
                raise NetworkUnknown(f"its operation {kind} comes before the number of inputs is known")
            self._add(Dense(np.eye(width), np.zeros(width)))
        layer = self.dense[-1]
        weight, bias = layer.weight, layer.bias
        if kind in ("Mul", "Div"):
            factor = value if kind == "Mul" else 1.0 / value
            weight, bias = weight * factor.reshape(-1, 1), bias * factor
        elif kind == "Add":
            bias = bias + value
        else:
            weight, bias = (weight, bias - value) if mine else (-weight, value - bias)
        self.dense[-1] = replace(layer, weight=weight, bias=bias)

    def _activate(self, name: str, alpha: float) -> None:
        import numpy as np

        if not self.dense:
            raise NetworkUnknown("it begins with an activation")
        if self.dense[-1].activation != "identity":
            width = len(self.dense[-1].bias)
            self.dense.append(Dense(np.eye(width), np.zeros(width)))
        self.dense[-1] = replace(self.dense[-1], activation=name, alpha=alpha)

    def _softsign(self, kind: str, inputs: list[str], output: str) -> bool:
        """Whether an operation is one of the three of x / (|x| + 1), as which torch exports a Softsign."""
        if kind == "Abs" and inputs[0] in self.now:
            self.sizes[output] = inputs[0], 0.0
            return True
        if kind == "Add" and len(inputs) == 2:
            for size, other in (inputs, inputs[::-1]):
                value = self.constants.get(other)
                if size in self.sizes and value is not None and value.size == 1:
                    base, before = self.sizes[size]
                    self.sizes[output] = base, before + float(value.item())
                    return True
        if kind == "Div" and inputs[0] in self.now and self.sizes.get(inputs[1]) == (inputs[0], 1.0):
            self._activate("softsign", 0.0)
            self.now = {output}
            return True
        return False

    def _lstm(self, inputs: list[str], attributes: Mapping[str, Any]) -> None:
        import numpy as np

        stated = attributes.get("direction")
        if stated is not None and stated.s not in (b"", b"forward"):
            raise NetworkUnknown("its LSTM runs backwards")
        strange = [name for name in ("activations", "clip", "input_forget") if name in attributes]
        if strange or len([name for name in inputs[7:] if name]):
            raise NetworkUnknown("its LSTM has peepholes, clips or activations of its own")
        if self.dense:
            raise NetworkUnknown("it has layers before the LSTM")
        weights = [self.constants.get(name) for name in inputs[1:3]]
        bias = self.constants.get(inputs[3]) if len(inputs) > 3 and inputs[3] else None
        if len(weights) != 2 or any(w is None or w.ndim != 3 or len(w) != 1 for w in weights):
            raise NetworkUnknown("the weights of its LSTM are no constants")
        w, r = (weight[0] for weight in weights if weight is not None)
        n = r.shape[1]
        both = np.zeros(8 * n) if bias is None else bias.reshape(-1)
        if w.shape[0] != 4 * n or r.shape[0] != 4 * n or both.size != 8 * n:
            raise NetworkFileError("the sizes of its LSTM do not fit")
        width = self.recurrent[-1].hidden.shape[1] if self.recurrent else w.shape[1]
        if w.shape[1] != width:
            raise NetworkFileError("the sizes of its layers do not fit")
        # ONNX has input, output, forget, cell; torch input, forget, cell, output.
        order = np.concatenate([np.arange(k * n, (k + 1) * n) for k in (0, 2, 3, 1)])
        self.recurrent.append(LstmLayer(w[order], r[order], (both[: 4 * n] + both[4 * n :])[order]))


def _factor(attributes: Mapping[str, Any], name: str) -> float:
    return float(attributes[name].f) if name in attributes else 1.0
