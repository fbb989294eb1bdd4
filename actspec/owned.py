"""What commands write: over a file of their own kind, over nothing of anybody else's.

A file tells by its beginning which command wrote it: `format` of JSON, the tool of SARIF, the first line of text, YAML
and Markdown, the generator of a page or a picture. Files of a network are told by the manifest beside them, the CSV of
a picture by the picture. Specs, which people edit, and logs tell nothing: the same bytes alone replace them.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Iterable, Sequence
from typing import Any

from actspec.diagnostics import Collector, EmitError, Span
from actspec.files import FAULTS, noting, read_regular, was_read
from actspec.placing import finish, is_stream, place, replace_file

MOST_BYTES = 256 << 20
"""Chosen: a log of an hour at 1 kHz. A larger file is never replaced."""
_MOST_JSON = 64 << 20
"""Chosen: that of a baseline."""

_HEADS = {
    "page": rb'<!DOCTYPE html>\r?\n<html lang="en">\r?\n<head>\r?\n<meta charset="utf-8">\r?\n'
    rb'<meta name="generator" content="actspec">',
    "junit": rb'<\?xml version="1\.0" encoding="utf-8"\?>\r?\n<testsuites name="actspec audit"',
    "markdown": rb"### actspec audit: ",
    "rules": rb"# (?:[A-Z]{3}\d{3} [a-z-]+|Rules of `actspec audit`)\r?\n",
    "svg": rb"<svg [^>]*>\r?\n<!-- Written by `actspec`",
    "png": rb"\x89PNG\r\n\x1a\n.{,200}tEXtSoftware\0actspec",
    "pdf": rb"%PDF-.*/Creator \(actspec\)",
}
"""How files of other forms begin."""
_HEADS_OF = {kind: re.compile(pattern, re.DOTALL) for kind, pattern in _HEADS.items()}
_WRITTEN = re.compile(rb"(?:#|<!--) Written by `actspec ([a-z ]+)`")


def head_of(command: str) -> str:
    """The first line of a text that a command writes.

    Args:
        command: Without `actspec`, such as `sysid fit`.
    """
    return f"# Written by `actspec {command}`."


def put(files: Sequence[tuple[str, bytes]], *, force: bool) -> None:
    """Put files in place, all or none; their folders are made. See `placing.place`.

    Args:
        files: Path and bytes of each.
        force: Whether files of others are replaced too.

    Raises:
        EmitError: a file would be lost; nothing has changed.
        OSError, ValueError: one cannot be written; nothing has changed.
    """
    check_kept(files, force=force)
    place(files)


def put_file(path: str, data: bytes, *, force: bool) -> None:
    """Put one file in place; its folder is there. See `put`."""
    check_kept([(path, data)], force=force)
    replace_file(path, data)


def check_free(path: str, sources: Sequence[str], force: bool, *, again: bool = False) -> None:
    """Refuse a path that cannot be written, or where a file would be lost, before the work.

    Args:
        path: The file to be.
        sources: Files that it is made from, which stay as they are.
        force: Whether another file may be replaced.
        again: Whether the command makes the same bytes each time and its files tell nothing: then a file that is there
            is judged when they are known.

    Raises: EmitError: it cannot be written.
    """
    if os.path.isdir(path) or not os.path.basename(path):
        raise EmitError.of(
            "OUT001", "is a folder", Span(path), help="name the file to write, e.g. robots/my_robot.yaml"
        )
    finish([path])
    if not os.path.lexists(path):
        return
    out = Collector()
    check_not_among(sources, [path], out)
    out.raise_if_failed(EmitError)
    if is_stream(path):
        return
    if not os.path.isfile(path):
        raise EmitError.of("OUT001", "exists and is not a regular file", Span(path))
    if not force and not again and not is_own(path):
        say_lost(path, out)
        raise EmitError(out.sorted())


def check_not_among(sources: Sequence[str], paths: Iterable[str], out: Collector) -> None:
    """Report of files that are to be written that they are about to be read."""
    for path in filter(os.path.exists, paths):
        if any(os.path.exists(source) and os.path.samefile(path, source) for source in sources):
            say_read(path, out)


def is_own(path: str) -> bool:
    """Whether a file that is there is of a kind that actspec writes, or empty."""
    try:
        old = _there(path, MOST_BYTES)
    except FAULTS:
        return False
    return not old.strip() or kind_of(old) is not None or _is_named_beside(path, old)


def kind_of(data: bytes) -> str | None:
    """What actspec wrote these bytes as; None: they do not tell."""
    if data[:1] == b"{":
        return _json_kind(data) if len(data) <= _MOST_JSON else None
    written = _WRITTEN.match(data)
    if written is not None:
        return written[1].decode("ascii")
    head = data[:1024] if data[:5] != b"%PDF-" else data
    return next((kind for kind, pattern in _HEADS_OF.items() if pattern.match(head)), None)


def _json_kind(data: bytes) -> str | None:
    try:
        found: Any = json.loads(data)
        if isinstance(found.get("format"), str):
            name, _, version = found["format"].partition("/")
            return name if name.startswith("actspec-") and version.isdigit() else None
        tools = [run["tool"]["driver"]["name"] for run in found["runs"]]
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
    return "sarif" if tools and set(tools) == {"actspec"} else None


def check_kept(files: Sequence[tuple[str, bytes]], *, force: bool) -> None:
    """Refuse files that would be lost; see `put`. Of what this run has read `force` is no reason to lose any.

    Raises: EmitError: they would be.
    """
    finish(path for path, _ in files)
    out = Collector()
    for path, data in files:
        read = was_read(path)
        if (read or not force) and not _may_replace(path, data):
            (say_read if read else say_lost)(path, out)
    out.raise_if_failed(EmitError)


def _there(path: str, most: int) -> bytes:
    """What lies where something is to be written: read to be judged, and not as this run's input."""
    with noting():
        return read_regular(path, most)


def _may_replace(path: str, data: bytes) -> bool:
    """Whether nothing of anybody else's is lost; what cannot be read or is no file, placing refuses."""
    if not os.path.isfile(path) or is_stream(path):
        return True
    try:
        old = _there(path, max(MOST_BYTES, len(data)))
    except FAULTS:
        return False
    if old == data or not old.strip():
        return True
    if _is_named_beside(path, old):
        return old[:2] == data[:2]
    kind = kind_of(old)
    return kind is not None and kind == kind_of(data)


def _is_named_beside(path: str, data: bytes) -> bool:
    """Whether a file that actspec wrote beside a network, or the CSV of a picture, names it by hash."""
    stem, ending = os.path.splitext(path)
    other = {".onnx": ".json", ".pt": ".json", ".csv": ".svg"}.get(ending)
    if other is None:
        return False
    try:
        beside = _there(stem + other, _MOST_JSON)
    except FAULTS:
        return False
    return kind_of(beside) is not None and hashlib.sha256(data).hexdigest().encode("ascii") in beside


def say_lost(path: str, out: Collector) -> None:
    """Say of a file that it would be lost."""
    help = "name another file, or replace it with --force"
    out.error("OUT003", "exists already, and would be lost", span=Span(path), help=help)


def say_read(path: str, out: Collector, help: str = "name another file to write") -> None:
    """Say of a file that what it holds goes into this run."""
    out.error("OUT003", "is read by this command", span=Span(path), help=help)
