"""A network as three files: ONNX, TorchScript and the manifest that names both.

    write_network("nets/legs", layers, {"inputs": "position_velocity", "taps": [0, 1], "tap_period": "5 ms"})

All bytes are made and read back before the first is written; the manifest, which names the others by hash, comes last.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Collector, Span
from actspec.files import json_of
from actspec.laws.network import Dense, Layers
from actspec.learn.torchscript import loaded, program_of
from actspec.logs import LogError
from actspec.owned import check_not_among, is_own, put, say_lost
from actspec.placing import finish
from actspec.readings.onnx_network import ACTIVATIONS, NetworkFileError, read_onnx

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

OPSET, IR_VERSION = 17, 8
"""Of the ONNX file. Chosen: every runtime since 2022 reads them."""
SAME = 1e-5
"""Largest difference of the files' outputs, as a share of their size. Chosen: that of float32 arithmetic."""
SUFFIXES = {"onnx": ".onnx", "torchscript": ".pt", "manifest": ".json"}
"""What a network's name is followed by."""
_OPERATIONS = {name: (kind, default) for kind, (name, default) in ACTIVATIONS.items()}
"""Activation to its operation in ONNX, and the default of its `alpha`."""
_CELL = ("h0", "c0", "h1", "c1")
_NEWTON = ("input_name", "hidden_in_name", "cell_in_name", "output_name", "hidden_out_name", "cell_out_name")


def network_paths_of(path: str) -> dict[str, str]:
    """Paths of a network's files, by what they are.

    Args:
        path: `DIR/NAME`; `.json` at its end is left out.
    """
    base = path.removesuffix(SUFFIXES["manifest"])
    return {part: base + suffix for part, suffix in SUFFIXES.items()}


def check_output(path: str, *, force: bool, sources: Sequence[str] = ()) -> None:
    """Refuse a name that cannot be written, before the work.

    Args:
        path: `DIR/NAME`.
        force: Whether other files that are there are replaced.
        sources: Files that the network is made from, which stay as they are.

    Raises:
        LogError: a file is there already and `force` is not given, it is a source, or the name is none.
    """
    out = Collector()
    paths = network_paths_of(path)
    name = os.path.basename(paths["onnx"]).removesuffix(".onnx")
    if not name or len(name) > 180 or any(mark in name for mark in "\\:") or any(ord(c) < 32 for c in name):
        message = "-o takes DIR/NAME; the files are NAME.onnx, NAME.pt and NAME.json"
        out.error("LRN001", message, where="-o", help="write -o nets/legs")
    folder = os.path.dirname(path)
    while folder and not os.path.exists(folder):
        folder = os.path.dirname(folder)
    if folder and not os.path.isdir(folder):
        out.error("LRN001", "not a folder", where="-o", span=Span(folder))
    finish(paths.values())
    check_not_among(sources, paths.values(), out)
    for there in (there for there in paths.values() if os.path.lexists(there) and not force):
        if not is_own(there):
            say_lost(there, out)
    out.raise_if_failed(LogError)


def write_network(
    path: str, layers: Layers, manifest: Mapping[str, Any], *, force: bool = False
) -> dict[str, str]:
    """Write a network's files.

    Args:
        path: `DIR/NAME`; folders that are not there are made.
        layers: The network; its weights are written as float32.
        manifest: Keys of `actspec-network/1`; format, kind, sizes and files are filled in.
        force: Whether other files that are there are replaced.

    Returns: The paths, as `network_paths_of`.

    Raises:
        NetworkFileError: an activation has no ONNX operation, or a file read back gives other torques.
        LogError: a file cannot be written; those from before are whole.
    """
    paths = network_paths_of(path)
    layers = single(layers)
    data = {"onnx": onnx_bytes(layers), "torchscript": torchscript_bytes(layers)}
    _check(layers, data)
    entries = dict(manifest)
    entries |= {"format": "actspec-network/1", "kind": "lstm" if layers.recurrent else "mlp"}
    if layers.recurrent:
        entries |= {"hidden_size": layers.hidden, "num_layers": len(layers.recurrent)}
    entries["files"] = file_entries(paths, data)
    write_files(path, data, manifest_text(entries), force=force)
    return paths


def file_entries(paths: Mapping[str, str], data: Mapping[str, bytes]) -> dict[str, dict[str, str]]:
    """A manifest's `files`."""
    return {
        form: {"path": os.path.basename(paths[form]), "sha256": hashlib.sha256(found).hexdigest()}
        for form, found in data.items()
    }


def write_files(path: str, data: Mapping[str, bytes], manifest: str, *, force: bool) -> None:
    """Write a network's files, all or none.

    Raises:
        EmitError: another file is there, and not `force`; nothing was written.
        LogError: one cannot be written; nothing was.
    """
    paths = network_paths_of(path)
    try:
        files = [(paths[form], found) for form, found in data.items()]
        put([*files, (paths["manifest"], manifest.encode())], force=force)
    except OSError as err:
        message = f"cannot be written: {err.strerror or err}"
        raise LogError.of("LRN001", message, Span(err.filename or path)) from err


def manifest_text(entries: Mapping[str, Any]) -> str:
    """A manifest as JSON, its keys in the model's order.

    Raises:
        ValueError: it is no manifest.
    """
    from actspec.spec.network import NetworkManifest

    NetworkManifest.model_validate(entries)
    order = list(NetworkManifest.model_fields)
    kept = {name: entries[name] for name in order if entries.get(name) is not None}
    return json_of(kept) + "\n"


def single(layers: Layers) -> Layers:
    """The layers with weights that float32 holds."""
    import numpy as np

    def of(array: Any) -> Array:
        return np.asarray(array, dtype=np.float32).astype(float)

    return Layers(
        tuple(
            replace(layer, inputs=of(layer.inputs), hidden=of(layer.hidden), bias=of(layer.bias))
            for layer in layers.recurrent
        ),
        tuple(
            replace(
                layer,
                weight=of(layer.weight),
                bias=of(layer.bias),
                alpha=float(np.float32(layer.alpha)),
            )
            for layer in layers.dense
        ),
    )


def _check(layers: Layers, data: Mapping[str, bytes]) -> None:
    """Whether both files give the layers' torques."""
    import numpy as np
    import torch

    x = np.random.default_rng(0).standard_normal((64, layers.inputs))
    expected, _ = layers(x)
    size = SAME * max(1.0, float(np.abs(expected).max()))
    again, _ = read_onnx(data["onnx"])(x)
    module = loaded(data["torchscript"])
    with torch.inference_mode():
        given = torch.tensor(x, dtype=torch.float32)
        if layers.recurrent:
            state = torch.zeros(len(layers.recurrent), len(x), layers.hidden)
            run, _ = module(given[:, None], (state, state.clone()))
        else:
            run = module(given)
    for name, found in (("ONNX", again), ("TorchScript", run.numpy())):
        if not np.abs(found - expected).max() <= 10.0 * size:
            raise NetworkFileError(f"its {name} file gives other torques than its layers")


def onnx_bytes(layers: Layers) -> bytes:
    """A network as an ONNX file, with the names by which Newton finds an LSTM's tensors.

    A perceptron takes `x`, shape (n, n_in), and gives `y`, shape (n, n_out). An LSTM takes `x`, shape (1, n, n_in),
    and the states `h0` and `c0`, shape (1, n, n_hidden), and gives `h1` and `c1` too; further layers have states
    `h0_1`, `c0_1` and so on.

    Raises:
        NetworkFileError: an activation has no operation in ONNX.
    """
    import numpy as np
    from onnx import TensorProto, checker, helper, numpy_helper

    nodes, tensors = [], []

    def constant(name: str, value: Array) -> str:
        tensors.append(numpy_helper.from_array(np.ascontiguousarray(value, dtype=np.float32), name))
        return name

    inputs: dict[str, list[Any]] = {"x": ["n", layers.inputs]}
    outputs: dict[str, list[Any]] = {"y": ["n", layers.outputs]}
    now = "x"
    if layers.recurrent:
        inputs["x"] = [1, "n", layers.inputs]
        tensors.append(helper.make_tensor("axis0", TensorProto.INT64, [1], [0]))
        tensors.append(helper.make_tensor("axis1", TensorProto.INT64, [1], [1]))
    for k, layer in enumerate(layers.recurrent):
        n = layer.hidden.shape[1]
        # torch has input, forget, cell, output; ONNX input, output, forget, cell.
        order = np.concatenate([np.arange(g * n, (g + 1) * n) for g in (0, 3, 1, 2)])
        h0, c0, h1, c1 = (name if k == 0 else f"{name}_{k}" for name in _CELL)
        weights = [
            constant(f"lstm{k}.w", layer.inputs[order][None]),
            constant(f"lstm{k}.r", layer.hidden[order][None]),
            constant(f"lstm{k}.b", np.concatenate([layer.bias[order], 0.0 * layer.bias])[None]),
        ]
        nodes.append(
            helper.make_node(
                "LSTM", [now, *weights, "", h0, c0], [f"lstm{k}.y", h1, c1], hidden_size=n, name=f"lstm{k}"
            )
        )
        inputs |= {h0: [1, "n", n], c0: [1, "n", n]}
        outputs |= {h1: [1, "n", n], c1: [1, "n", n]}
        last = k == len(layers.recurrent) - 1
        source, axis = (h1, "axis0") if last else (f"lstm{k}.y", "axis1")
        now = f"lstm{k}.out"
        nodes.append(helper.make_node("Squeeze", [source, axis], [now]))
    for k, dense in enumerate(layers.dense):
        end = k == len(layers.dense) - 1
        active = dense.activation != "identity"
        weights = [constant(f"dense{k}.w", dense.weight), constant(f"dense{k}.b", dense.bias)]
        out = "y" if end and not active else f"dense{k}.out"
        nodes.append(helper.make_node("Gemm", [now, *weights], [out], transB=1))
        now = out
        if active:
            out = "y" if end else f"dense{k}.active"
            nodes.append(onnx_activation(dense, now, out))
            now = out
    graph = helper.make_graph(
        nodes,
        "actuator_network",
        [helper.make_tensor_value_info(name, TensorProto.FLOAT, shape) for name, shape in inputs.items()],
        [helper.make_tensor_value_info(name, TensorProto.FLOAT, shape) for name, shape in outputs.items()],
        tensors,
    )
    model = helper.make_model(
        graph,
        opset_imports=[helper.make_opsetid("", OPSET)],
        ir_version=IR_VERSION,
        producer_name="actspec",
    )
    if len(layers.recurrent) == 1:
        names = ("x", "h0", "c0", "y", "h1", "c1")
        helper.set_model_props(model, {"metadata": json.dumps(dict(zip(_NEWTON, names, strict=True)))})
    checker.check_model(model)
    return bytes(model.SerializeToString(deterministic=True))


def onnx_activation(dense: Dense, now: str, out: str) -> Any:
    """A layer's activation as ONNX's node.

    Raises:
        NetworkFileError: ONNX has none of the name.
    """
    from onnx import helper

    if dense.activation not in _OPERATIONS:
        raise NetworkFileError(f"ONNX has no operation for the activation {dense.activation}")
    kind, default = _OPERATIONS[dense.activation]
    return helper.make_node(kind, [now], [out], **({"alpha": float(dense.alpha)} if default else {}))


def torchscript_bytes(layers: Layers) -> bytes:
    """A network as TorchScript.

    A perceptron takes (n, n_in) and gives (n, n_out); an LSTM takes (n, 1, n_in) with the states
    (n_layer, n, n_hidden), and has its recurrent part as `lstm`: as Isaac Lab's classes call them.

    Raises:
        NetworkFileError: an activation is none of torch's.
    """
    # Scripted, a perceptron's text has its sizes in another order each time.
    return program_of(torch_module(layers), None if layers.recurrent else layers.inputs)


def torch_linear(dense: Dense) -> Any:
    """The weights of a layer as torch's, in float32."""
    import torch

    affine = torch.nn.Linear(dense.weight.shape[1], dense.weight.shape[0])
    with torch.no_grad():
        affine.weight[:] = torch.as_tensor(dense.weight, dtype=torch.float32)
        affine.bias[:] = torch.as_tensor(dense.bias, dtype=torch.float32)
    return affine


def torch_module(layers: Layers) -> Any:
    """The layers as a module of float32."""
    import torch

    head = torch.nn.Sequential()
    for dense in layers.dense:
        head.append(torch_linear(dense))
        if dense.activation != "identity":
            head.append(torch_activation(dense.activation, dense.alpha))
    if not layers.recurrent:
        return head
    lstm = torch.nn.LSTM(layers.inputs, layers.hidden, len(layers.recurrent), batch_first=True)
    with torch.no_grad():
        for k, layer in enumerate(layers.recurrent):
            for name, value in (
                ("weight_ih", layer.inputs),
                ("weight_hh", layer.hidden),
                ("bias_ih", layer.bias),
            ):
                getattr(lstm, f"{name}_l{k}")[:] = torch.as_tensor(value, dtype=torch.float32)
            getattr(lstm, f"bias_hh_l{k}")[:] = 0.0
    return recurrent_module(lstm, head)


def recurrent_module(lstm: Any, head: Any) -> Any:
    """An LSTM with its head, called with inputs and states."""
    import torch

    class Recurrent(torch.nn.Module):  # type: ignore[misc]
        def __init__(self, lstm: torch.nn.LSTM, head: torch.nn.Sequential) -> None:
            super().__init__()
            self.lstm = lstm
            self.head = head

        def forward(
            self, x: torch.Tensor, state: tuple[torch.Tensor, torch.Tensor]
        ) -> tuple[torch.Tensor, tuple[torch.Tensor, torch.Tensor]]:
            y, state = self.lstm(x, state)
            return self.head(y[:, -1]), state

    return Recurrent(lstm, head)


def torch_activation(name: str, alpha: float = 1.0) -> Any:
    """An activation of `laws.network` as torch's module.

    Raises:
        NetworkFileError: torch has none of the name.
    """
    from torch import nn

    made = {
        "relu": nn.ReLU,
        "leaky_relu": lambda: nn.LeakyReLU(alpha),
        "elu": lambda: nn.ELU(alpha),
        "selu": nn.SELU,
        "tanh": nn.Tanh,
        "sigmoid": nn.Sigmoid,
        "softsign": nn.Softsign,
        "softplus": nn.Softplus,
        "silu": nn.SiLU,
    }
    if name not in made:
        raise NetworkFileError(f"torch has no activation {name}")
    return made[name]()
