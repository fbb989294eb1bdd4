"""A network's drive: an ONNX file, whose metadata are written from the manifest."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import shortened
from actspec.ir import Command
from actspec.spec.results import NetworkManifest
from actspec.targets.kit.network import NetworkFile, read_network, tap_stride
from actspec.targets.newton.usda import Attribute, asset

if TYPE_CHECKING:
    from actspec.targets.newton.joint_prims import Joint

TENSORS = (
    "input_name",
    "hidden_in_name",
    "cell_in_name",
    "output_name",
    "hidden_out_name",
    "cell_out_name",
)
"""Names of an lstm's inputs and outputs, which Newton takes from the file's own metadata."""


def network_attributes(joint: Joint) -> tuple[list[Attribute], tuple[str, bytes]] | None:
    """`newton:modelPath` and the file; None after an error."""
    network = joint.actuator.network
    found = read_network(network, joint.where, joint.actuator.span, joint.collector)
    if found is None or network is None:
        return None
    manifest, span, where = found.manifest, network.span, f"{joint.where}.network"
    if not joint.dialect.networks:
        joint.collector.error(
            "NWT003",
            f"Newton {joint.dialect.text} reads no ONNX, and gives a network the velocity's error for the velocity",
            where=where,
            span=span,
            help="write for Newton 1.4 or later, or leave this target out",
        )
        return None
    if joint.actuator.command is not Command.POSITION:
        joint.collector.error(
            "NWT002",
            f"Newton's network takes position errors, got command {joint.actuator.command.value}",
            where=f"{joint.where}.command",
            span=span,
            help="write command: position, or leave this target out",
        )
    if manifest.kind == "gru":
        joint.collector.error(
            "NWT003",
            "actspec writes no network of kind gru for Newton, whose inputs it names otherwise",
            where=where,
            span=span,
            help="use an mlp or an lstm, or leave this target out",
        )
    stride = tap_stride(manifest, joint.step, where, span, joint.collector)
    metadata = None if stride is None else _metadata(joint, found, stride)
    if metadata is None or joint.collector.failed:
        return None
    if manifest.initial_history == "first_sample" and manifest.kind == "mlp" and any(manifest.taps):
        joint.approximate(
            "network.initial_history",
            "first_sample",
            "zero",
            "Newton clears a network's history at a reset",
            joint.both_limits,
        )
    # Newton takes a file for torch's by the end of its name.
    name = f"{os.path.splitext(found.name)[0]}.onnx"
    return [Attribute("asset", "newton:modelPath", asset(name))], (name, with_metadata(found.data, metadata))


def _metadata(joint: Joint, file: NetworkFile, stride: int) -> dict[str, Any] | None:
    """What Newton is to read of the network; None after an error."""
    assert joint.actuator.network is not None
    manifest, where, span = file.manifest, f"{joint.where}.network", joint.actuator.network.span
    try:
        own = read_metadata(file.data)
    except NotOnnx as err:
        torch = file.data.startswith(b"PK")
        joint.collector.error(
            "NWT004",
            f"'{shortened(file.name)}' is no ONNX file, which Newton runs: "
            + ("it is an archive, as torch writes them" if torch else str(err)),
            where=where,
            span=span,
            help="export it with torch.onnx.export, and name that file and its manifest for this target; "
            "Newton 1.8 refuses TorchScript",
        )
        return None
    asked = _asked(manifest, stride)
    for scale in ("pos_scale", "vel_scale", "effort_scale"):
        if asked[scale] == 0.0:
            joint.collector.error(
                "NWT006",
                f"Newton takes no {scale} of 0",
                where=where,
                span=span,
                help="fold it into the network",
            )
    if "torque_scale" in own:
        own.setdefault("effort_scale", own.pop("torque_scale"))
    for key, value in asked.items():
        if key in own and not _same(own[key], value):
            joint.collector.error(
                "NWT006",
                f"the network's own metadata have {key} {shortened(str(own[key]))}, its manifest has {value}",
                where=where,
                span=span,
                help="correct the one that is wrong: Newton reads the file's, and actspec writes the manifest's there",
            )
    if manifest.kind == "lstm":
        _check_lstm(joint, manifest, {**own, **asked}, stride)
    return {**own, **asked}


def _asked(manifest: NetworkManifest, stride: int) -> dict[str, Any]:
    found: dict[str, Any] = {
        "model_type": manifest.kind,
        "input_order": "pos_vel" if manifest.inputs == "position_velocity" else "vel_pos",
        "input_idx": [tap * stride for tap in manifest.taps],
        "pos_scale": manifest.position_scale,
        "vel_scale": manifest.velocity_scale,
        "effort_scale": manifest.torque_scale,
    }
    if manifest.kind == "lstm":
        sizes = (("hidden_size", manifest.hidden_size), ("num_layers", manifest.num_layers))
        found |= {name: size for name, size in sizes if size is not None}
    return found


def _check_lstm(joint: Joint, manifest: NetworkManifest, metadata: dict[str, Any], stride: int) -> None:
    assert joint.actuator.network is not None
    where, span = f"{joint.where}.network", joint.actuator.network.span
    missing = [name for name in (*TENSORS, "hidden_size", "num_layers") if name not in metadata]
    if missing:
        joint.collector.error(
            "NWT006",
            f"neither the lstm's own metadata nor its manifest have {', '.join(missing)}",
            where=where,
            span=span,
            help="export the network with them: Newton finds its tensors by these names",
        )
    if manifest.taps != (0,) or manifest.inputs != "position_velocity" or stride != 1:
        joint.collector.error(
            "NWT003",
            "Newton gives an lstm position error and velocity of each physics step, in this order, got "
            f"{manifest.inputs}, taps {list(manifest.taps)} every {stride * joint.step * 1e3:g} ms",
            where=where,
            span=span,
            help=f"train it on position_velocity, taps [0], every {joint.step * 1e3:g} ms",
        )


def _same(own: Any, value: Any) -> bool:
    if isinstance(value, float) and isinstance(own, int | float):
        return math.isclose(own, value, rel_tol=1e-6)
    return bool(own == value)


GRAPH, METADATA = 7, 14
"""Fields of ModelProto."""

KEY = "metadata"
"""Property whose value is Newton's JSON."""

MAX_RECORDS = 10_000
"""Most records of a message. Chosen: a model has some tens; a file of none but empty ones would take minutes."""


class NotOnnx(ValueError):
    """The bytes are no ONNX model."""


def read_metadata(data: bytes) -> dict[str, Any]:
    """What the file says of itself, as Newton reads it: the JSON of `metadata`, else each property.

    Raises: NotOnnx: it is no ONNX file, or its metadata is no JSON object.
    """
    found: dict[str, str] = {}
    graph = False
    for field, _, value in _records(data):
        graph = graph or field == GRAPH
        if field == METADATA:
            key, text = _entry(value)
            found[key] = text
    if not graph:
        raise NotOnnx("it holds no graph")
    if KEY not in found:
        return {key: _json(text) for key, text in found.items()}
    own = _json(found[KEY])
    if not isinstance(own, dict):
        raise NotOnnx(f"its property '{KEY}' is no JSON object")
    return own


def with_metadata(data: bytes, metadata: Mapping[str, Any]) -> bytes:
    """The same network with other metadata; every other byte stays."""
    kept = b"".join(
        record for field, record, value in _records(data) if field != METADATA or _entry(value)[0] != KEY
    )
    text = json.dumps(dict(metadata), sort_keys=True)
    entry = _text(1, KEY) + _text(2, text)
    return kept + _varint(METADATA << 3 | 2) + _varint(len(entry)) + entry


def _json(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text


def _entry(value: bytes) -> tuple[str, str]:
    """Key and value of one property."""
    parts = {1: "", 2: ""}
    for field, _, text in _records(value):
        if field in parts:
            parts[field] = text.decode("utf-8", "replace")
    return parts[1], parts[2]


def _records(data: bytes) -> Iterator[tuple[int, bytes, bytes]]:
    """Every record of a message: field, its bytes whole, and its value where that is bytes."""
    at = count = 0
    while at < len(data):
        start, count = at, count + 1
        if count > MAX_RECORDS:
            raise NotOnnx(f"it has more than {MAX_RECORDS} records")
        tag, at = _read_varint(data, at)
        kind, value = tag & 7, b""
        if kind == 0:
            _, at = _read_varint(data, at)
        elif kind == 2:
            size, at = _read_varint(data, at)
            value = data[at : at + size]
            at += size
        elif kind in (1, 5):
            at += 8 if kind == 1 else 4
        else:
            raise NotOnnx("it is no protobuf message")
        if at > len(data) or tag >> 3 == 0:
            raise NotOnnx("it is no protobuf message, or cut off")
        yield tag >> 3, data[start:at], value


def _read_varint(data: bytes, at: int) -> tuple[int, int]:
    value = 0
    for shift in range(0, 70, 7):
        if at >= len(data):
            break
        byte = data[at]
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value, at
    raise NotOnnx("it is no protobuf message, or cut off")


def _text(field: int, text: str) -> bytes:
    data = text.encode("utf-8")
    return _varint(field << 3 | 2) + _varint(len(data)) + data


def _varint(value: int) -> bytes:
    found = bytearray()
    while value > 0x7F:
        found.append(value & 0x7F | 0x80)
        value >>= 7
    found.append(value)
    return bytes(found)
