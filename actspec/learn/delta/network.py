"""The network of a delta action: raw columns in, limited corrections out.

    delta = max_delta * tanh(f(columns))

One perceptron for all joints, each joint with its own columns and first bias, or one for the whole robot.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from actspec.laws.network import Dense
from actspec.learn.files import IR_VERSION, OPSET, onnx_activation, torch_activation, torch_linear
from actspec.learn.torchscript import program_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

TURN = tuple(f"base.orientation.{component}" for component in "wxyz")
"""Columns of which the network makes the way down in the base's axes: heading and sign of the quaternion are none of
its business."""
PAIRS = ((0, 2), (1, 3), (2, 3), (0, 1), (1, 1), (2, 2))
"""Parts of a quaternion w, x, y, z whose products tell the way down."""
DOWN = (
    (2.0, 0.0, 0.0),
    (-2.0, 0.0, 0.0),
    (0.0, -2.0, 0.0),
    (0.0, -2.0, 0.0),
    (0.0, 0.0, 2.0),
    (0.0, 0.0, 2.0),
)
"""What each product adds to it: R^T (0, 0, -1), less the -1 of its last part, which a bias takes."""


@dataclass(frozen=True, slots=True, eq=False)
class DeltaLayers:
    """The network.

    Attributes:
        columns: Names of its inputs.
        picked: Inputs of each part, by index; those behind the columns are the way down. Shape (n_part, n_pick).
        first: Weights of the first layer, shape (n_part, n_pick, n_hidden).
        bias: Of it, shape (n_part, n_hidden).
        activation: Behind it.
        dense: Further layers; the last one gives each part's outputs.
        max_delta: Largest correction [rad or m].
    """

    columns: tuple[str, ...]
    picked: NDArray[np.intp]
    first: Array
    bias: Array
    activation: str
    dense: tuple[Dense, ...]
    max_delta: float

    @property
    def turn(self) -> tuple[int, ...] | None:
        """Where the base's quaternion stands among the columns; None: nowhere."""
        return tuple(self.columns.index(name) for name in TURN) if TURN[0] in self.columns else None

    @property
    def outputs(self) -> int:
        """How many corrections."""
        return len(self.picked) * len(self.dense[-1].bias)


@cache
def _module_class() -> Any:
    """The class of the network as a module, made where torch is first needed."""
    import torch

    class DeltaAction(torch.nn.Module):  # type: ignore[misc]
        def __init__(self, layers: DeltaLayers) -> None:
            super().__init__()
            self.parts, self.picks = layers.picked.shape
            self.max_delta = layers.max_delta
            turn = layers.turn
            self.turns = turn is not None
            sides = [[(turn or (0, 0, 0, 0))[k] for k in side] for side in zip(*PAIRS, strict=True)]
            for name, value in (
                ("picked", torch.as_tensor(layers.picked.reshape(-1))),
                ("one", torch.as_tensor(sides[0])),
                ("other", torch.as_tensor(sides[1])),
                ("down", torch.tensor(DOWN)),
                ("first", torch.as_tensor(layers.first, dtype=torch.float32)),
                ("bias", torch.as_tensor(layers.bias, dtype=torch.float32)[:, None]),
            ):
                self.register_buffer(name, value)
            rest: list[Any] = [torch_activation(layers.activation)]
            for dense in layers.dense:
                rest.append(torch_linear(dense))
                if dense.activation != "identity":
                    rest.append(torch_activation(dense.activation))
            self.rest = torch.nn.Sequential(*rest)

        def forward(self, x: torch.Tensor) -> torch.Tensor:
            if self.turns:
                x = torch.cat([x, (x[:, self.one] * x[:, self.other]) @ self.down], dim=1)
            parts = x[:, self.picked].reshape(-1, self.parts, self.picks).transpose(0, 1)
            out = self.rest(torch.matmul(parts, self.first) + self.bias)
            return self.max_delta * torch.tanh(out.transpose(0, 1).reshape(x.shape[0], -1))

    return DeltaAction


def torchscript_of(layers: DeltaLayers) -> bytes:
    """The network as TorchScript, of columns (n, n_column) to corrections (n, n_output), in single precision."""
    module = _module_class()(layers).eval()
    for parameter in module.parameters():
        parameter.requires_grad_(False)
    return program_of(module, len(layers.columns))


def onnx_of(layers: DeltaLayers) -> bytes:
    """The network as ONNX: `x`, shape (n, n_column), to `y`, shape (n, n_output)."""
    import numpy as np
    from onnx import TensorProto, checker, helper, numpy_helper

    nodes: list[Any] = []
    tensors: list[Any] = []

    def constant(name: str, value: Any, kind: Any = np.float32) -> str:
        tensors.append(numpy_helper.from_array(np.ascontiguousarray(value, dtype=kind), name))
        return name

    def add(kind: str, inputs: list[str], out: str, **attributes: Any) -> str:
        nodes.append(helper.make_node(kind, inputs, [out], **attributes))
        return out

    now = "x"
    if (turn := layers.turn) is not None:
        sides = [
            constant(f"pair{k}", [turn[p] for p in side], np.int64)
            for k, side in enumerate(zip(*PAIRS, strict=True))
        ]
        halves = [add("Gather", ["x", side], f"half{k}", axis=1) for k, side in enumerate(sides)]
        product = add("Mul", halves, "products")
        down = add("MatMul", [product, constant("down", DOWN)], "way_down")
        now = add("Concat", ["x", down], "columns", axis=1)
    now = add("Gather", [now, constant("picked", layers.picked, np.int64)], "picks", axis=1)
    now = add("Transpose", [now], "parts", perm=[1, 0, 2])
    now = add("MatMul", [now, constant("first.w", layers.first)], "first.y")
    now = add("Add", [now, constant("first.b", layers.bias[:, None])], "first.out")
    nodes.append(onnx_activation(Dense(layers.first, layers.bias, layers.activation), now, "first.active"))
    now = "first.active"
    for k, dense in enumerate(layers.dense):
        now = add("MatMul", [now, constant(f"dense{k}.w", dense.weight.T)], f"dense{k}.y")
        now = add("Add", [now, constant(f"dense{k}.b", dense.bias)], f"dense{k}.out")
        if dense.activation != "identity":
            nodes.append(onnx_activation(dense, now, f"dense{k}.active"))
            now = f"dense{k}.active"
    now = add("Transpose", [now], "by_row", perm=[1, 0, 2])
    now = add("Reshape", [now, constant("shape", [-1, layers.outputs], np.int64)], "sum")
    now = add("Tanh", [now], "share")
    add("Mul", [now, constant("max_delta", layers.max_delta)], "y")
    graph = helper.make_graph(
        nodes,
        "delta_action",
        [helper.make_tensor_value_info("x", TensorProto.FLOAT, ["n", len(layers.columns)])],
        [helper.make_tensor_value_info("y", TensorProto.FLOAT, ["n", layers.outputs])],
        tensors,
    )
    opsets = [helper.make_opsetid("", OPSET)]
    model = helper.make_model(graph, opset_imports=opsets, ir_version=IR_VERSION, producer_name="actspec")
    checker.check_model(model)
    return bytes(model.SerializeToString(deterministic=True))
