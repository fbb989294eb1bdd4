"""Network files for tests: the least TorchScript archive, and ONNX perceptrons and LSTMs by onnx itself."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Sequence
from typing import Any

import numpy as np


def torchscript(mark: str = "network") -> bytes:
    """An archive with the parts by which TorchScript is known; it holds no weights."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as archive:
        for name, text in (("constants.pkl", "."), ("code/__torch__.py", mark), ("data.pkl", ".")):
            archive.writestr(zipfile.ZipInfo(f"net/{name}"), text)
    return out.getvalue()


def onnx_mlp(layers: Sequence[tuple[Any, Any, str]]) -> bytes:
    """A perceptron: weight (n_out, n_in), bias, ONNX activation or "" of each layer."""
    from onnx import TensorProto, helper, numpy_helper

    nodes, tensors, now = [], [], "x"
    for k, (weight, bias, activation) in enumerate(layers):
        for name, value in ((f"w{k}", weight), (f"b{k}", bias)):
            tensors.append(numpy_helper.from_array(np.asarray(value, dtype=np.float32), name))
        nodes.append(helper.make_node("Gemm", [now, f"w{k}", f"b{k}"], [f"y{k}"], transB=1))
        now = f"y{k}"
        if activation:
            nodes.append(helper.make_node(activation, [now], [f"a{k}"]))
            now = f"a{k}"
    width = np.asarray(layers[0][0]).shape[1]
    graph = helper.make_graph(
        nodes,
        "net",
        [helper.make_tensor_value_info("x", TensorProto.FLOAT, ["n", width])],
        [helper.make_tensor_value_info(now, TensorProto.FLOAT, ["n", 1])],
        tensors,
    )
    return bytes(helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)]).SerializeToString())


def onnx_operation(kind: str) -> bytes:
    """A network of one operation, without weights."""
    from onnx import TensorProto, helper

    ends = [helper.make_tensor_value_info(name, TensorProto.FLOAT, None) for name in ("x", "y")]
    graph = helper.make_graph([helper.make_node(kind, ["x"], ["y"])], "net", ends[:1], ends[1:])
    return bytes(helper.make_model(graph).SerializeToString())
