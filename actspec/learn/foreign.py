"""Networks of others as layers: ONNX, which is data, and TorchScript, which is a program and runs by consent alone."""

from __future__ import annotations

import os
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Span
from actspec.files import NotRegular, TooLarge, read_regular
from actspec.laws.network import ACTIVATIONS, Dense, Layers, LstmLayer
from actspec.learn.files import torch_activation
from actspec.learn.torchscript import loaded, pickled
from actspec.logs import LogError
from actspec.readings.onnx_network import NetworkFileError, NetworkUnknown, read_onnx

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MAX_BYTES = 64 * 1024 * 1024
"""Largest file [bytes]. Chosen: actuator networks have some tens of kilobytes."""
SAME = 1e-4
"""Largest difference between the layers and the file's own answer, as a share of its size. Chosen: float32."""
PROBES = 64
_SILENT = {"Identity", "Dropout", "Sequential", "ModuleList"}


def read_network_file(path: str, *, trust: bool) -> Layers:
    """The layers of a network file.

    Args:
        path: ONNX or TorchScript.
        trust: Whether a TorchScript file, which is a program, may run.

    Raises:
        LogError: it is no network, is not known, or may not run.
    """
    data = network_bytes(path)
    saved = pickled(data)
    if saved or data[:1] == b"\x80":
        by = " by torch.save, of a module or of weights alone" if saved else ""
        message = f"it is a pickle{by}: such a file may run anything, and is not read"
        help = (
            "its owner exports the module, into which weights are loaded first: "
            "torch.jit.save(torch.jit.script(network), 'net.pt'), or torch.onnx.export"
        )
        raise LogError.of("LRN016", message, Span(path), help=help)
    try:
        if not data.startswith(b"PK"):
            return read_onnx(data)
        if not trust:
            help = "an ONNX file needs no trust; --trust runs this one, if you know who made it"
            raise LogError.of(
                "LRN016", "TorchScript is a program, and is not run unasked", Span(path), help=help
            )
        return _by_torch(data)
    except NetworkFileError as err:
        name = os.path.basename(path)
        help = (
            "read are linear layers and LSTMs with one activation behind each layer: write it as torch.nn.Sequential "
            f"of those ({', '.join(list(ACTIVATIONS)[1:])}), and save it by torch.jit.script"
        )
        known = isinstance(err, NetworkUnknown)
        raise LogError.of(
            "LRN013", f"'{name}' cannot be read: {err}", Span(path), help=help if known else None
        ) from err


def network_bytes(path: str) -> bytes:
    """Bytes of a network file.

    Raises:
        LogError: it cannot be read.
    """
    try:
        return read_regular(path, MAX_BYTES)
    except (FileNotFoundError, NotADirectoryError) as err:
        raise LogError.of("LRN013", "there is no such file", Span(path)) from err
    except (NotRegular, TooLarge, OSError, ValueError) as err:
        raise LogError.of("LRN013", f"cannot be read: {err}", Span(path)) from err


def _by_torch(data: bytes) -> Layers:
    """Layers of a TorchScript file, held to what the file itself answers."""
    import torch

    try:
        module = loaded(data)
    except (RuntimeError, ValueError) as err:
        raise NetworkFileError(
            "torch does not load it as TorchScript: it is something else, or damaged"
        ) from err
    found = _layers(module)
    layers = found[0]
    random = torch.Generator().manual_seed(0)
    x = torch.randn((PROBES, layers.inputs), generator=random)
    try:
        with torch.no_grad():
            if layers.recurrent:
                shape = (len(layers.recurrent), PROBES, layers.hidden)
                theirs = module(x[:, None], (torch.zeros(shape), torch.zeros(shape)))[0]
            else:
                theirs = module(x)
    except RuntimeError as err:
        raise NetworkFileError("it does not take the inputs of an actuator network") from err
    answers = theirs.reshape(PROBES, -1)[:, :1].double().numpy()
    for layers in found:
        ours = layers(x.double().numpy())[0][:, :1]
        if abs(answers - ours).max() <= SAME * max(abs(answers).max(), 1e-9):
            return layers
    raise NetworkUnknown("it does more than its layers: what it answers is not what they give")


def _layers(module: Any) -> list[Layers]:
    """What its parts may be together; the caller compares answers.

    They stand in the order in which they were made. One activation may be called after every layer but the last,
    and what is called as a function is no part at all.
    """
    known = {type(torch_activation(name)).__name__: name for name in ACTIVATIONS if name != "identity"}
    dense: list[Dense] = []
    recurrent: list[LstmLayer] = []
    activations: list[tuple[str, float]] = []
    in_place = True
    for part in module.modules():
        kind = getattr(part, "original_name", "")
        if kind == "Linear":
            weight = _array(part.weight)
            bias = getattr(part, "bias", None)
            dense.append(Dense(weight, 0.0 * weight[:, 0] if bias is None else _array(bias)))
        elif kind == "LSTM":
            recurrent += _recurrent(dict(part.named_parameters()))
        elif kind in known:
            alpha = float(getattr(part, "negative_slope" if kind == "LeakyReLU" else "alpha", 1.0))
            activations.append((known[kind], alpha))
            if dense and dense[-1].activation == "identity":
                dense[-1] = replace(dense[-1], activation=known[kind], alpha=alpha)
            else:
                in_place = False
        elif not any(True for _ in part.children()) and kind not in _SILENT:
            raise NetworkUnknown(
                f"its part {kind[:40] or 'without a name'} is not one of an actuator network"
            )
    if not dense:
        raise NetworkUnknown("it has no linear layer that could be read: a frozen file has lost them")
    found = [dense] if in_place else []
    for name, alpha in activations or [
        (name, 0.01 if name == "leaky_relu" else 1.0) for name in known.values()
    ]:
        found.append([replace(layer, activation=name, alpha=alpha) for layer in dense[:-1]])
        found[-1].append(replace(dense[-1], activation="identity"))
    return [Layers(tuple(recurrent), tuple(layers)) for layers in found]


def _recurrent(weights: dict[str, Any]) -> list[LstmLayer]:
    found: list[LstmLayer] = []
    while (key := f"weight_ih_l{len(found)}") in weights:
        k = len(found)
        hidden = _array(weights[f"weight_hh_l{k}"])
        parts = [weights.get(f"bias_{side}_l{k}") for side in ("ih", "hh")]
        bias = sum((_array(part) for part in parts if part is not None), 0.0 * hidden[:, 0])
        found.append(LstmLayer(_array(weights[key]), hidden, bias))
    return found


def _array(tensor: Any) -> Array:
    found: Array = tensor.detach().double().numpy()
    return found
