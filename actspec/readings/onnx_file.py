"""The outermost records of an ONNX file, for its metadata; the network is not loaded, and onnx not needed.

An ONNX file is one protobuf message, `ModelProto`. Of it only the outermost records are walked: its graph (field 7)
is passed by, its `metadata_props` (field 14, pairs of key and value) are read, and one is appended. Newton reads a
network's order, taps and scales from the property `metadata`, as JSON.
Source: onnx.proto of ONNX 1.23; newton 1.8.0 newton/_src/actuators/utils.py.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

GRAPH, METADATA = 7, 14
"""Fields of ModelProto."""

KEY = "metadata"
"""Property whose value is Newton's JSON."""

MAX_RECORDS = 10_000
"""Most records of a message. Chosen: a model has some tens; a file of none but empty ones would take minutes."""


class NotOnnx(ValueError):
    """The bytes are no ONNX model."""


def check_onnx(data: bytes) -> None:
    """Whether a file is an ONNX model as far as its outermost records tell: none is cut off, one is a graph.

    Raises: NotOnnx: it is none.
    """
    if GRAPH not in [field for field, *_ in _records(data)]:
        raise NotOnnx("it holds no graph")


def read_metadata(data: bytes) -> dict[str, Any]:
    """What the file says of itself, as Newton reads it: the JSON of `metadata`, else each property.

    Raises: NotOnnx: it is no ONNX file, or its metadata is no JSON object.
    """
    check_onnx(data)
    found = dict(_entry(value) for field, _, value in _records(data) if field == METADATA)
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
