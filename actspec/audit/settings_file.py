"""Where the settings of an audit stand, and reading that file; what is in it is judged in `actspec.audit.settings`."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from typing import Any

from actspec.audit.places import toml_fault
from actspec.diagnostics import Collector, Span
from actspec.files import FAULTS, place_of, read_regular, why

OWN_FILE = "actspec.toml"
SHARED_FILE = "pyproject.toml"

MOST_BYTES = 1 << 20
"""Chosen: a settings file is written by hand."""


def find_settings(
    config: str | None, start: str, collector: Collector
) -> tuple[str, dict[str, Any], str] | None:
    """The settings file, its TOML and its text; None where there is none.

    Args:
        config: The file; None: the nearest one, from `start` upwards. In one folder actspec.toml goes before
            pyproject.toml, and a pyproject.toml without `[tool.actspec]` is passed over.
        start: Folder to begin in.
        collector: For errors.
    """
    if config is not None:
        return (config, *_read(config, collector))
    return next(_candidates(start, collector), None)


def passed_over(path: str) -> str | None:
    """The pyproject.toml with `[tool.actspec]` beside an actspec.toml, which goes before it; None: there is none."""
    folder, name = os.path.split(path)
    shared = os.path.join(folder, SHARED_FILE)
    if name != OWN_FILE or not os.path.isfile(shared):
        return None
    tool = _read(shared, Collector(), quietly=True)[0].get("tool")
    return shared if isinstance(tool, dict) and "actspec" in tool else None


def excluded(config: str | None) -> tuple[tuple[str, ...], str, bool]:
    """Globs of what is passed over, the folder that they are relative to, and whether that goes for named files too.

    Files are read before the settings are judged: what is wrong with the file is reported later.
    """
    found = find_settings(config, ".", Collector())
    if found is None:
        return (), ".", False
    path, data, _ = found
    table: Any = data.get("tool", {}) if os.path.basename(path) == SHARED_FILE else {"actspec": data}
    for key in ("actspec", "audit"):
        table = table.get(key) if isinstance(table, dict) else None
    own = table if isinstance(table, dict) else {}
    globs = own.get("exclude")
    texts = tuple(glob for glob in globs if isinstance(glob, str)) if isinstance(globs, list) else ()
    return texts, os.path.dirname(path) or ".", own.get("force-exclude") is True


def _candidates(start: str, collector: Collector) -> Iterator[tuple[str, dict[str, Any], str]]:
    folder = os.path.abspath(start)
    while not collector.failed:
        own = _shown(os.path.join(folder, OWN_FILE))
        if os.path.isfile(own):
            yield (own, *_read(own, collector))
        shared = _shown(os.path.join(folder, SHARED_FILE))
        if os.path.isfile(shared):
            data, text = _read(shared, collector, quietly=True)
            tool = data.get("tool")
            if isinstance(tool, dict) and "actspec" in tool:
                yield shared, data, text
        parent = os.path.dirname(folder)
        if parent == folder:
            return
        folder = parent


def _shown(path: str) -> str:
    """A path as the user would write it from the working folder."""
    try:
        return os.path.relpath(path)
    except ValueError:  # another drive
        return path


def _read(path: str, collector: Collector, *, quietly: bool = False) -> tuple[dict[str, Any], str]:
    """A TOML file and its text; empty after an error, which is collected.

    Args:
        path: The file.
        collector: For errors.
        quietly: A file that is not TOML is somebody else's trouble unless it speaks of actspec.
    """
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        import tomli as tomllib

    try:
        data = read_regular(path, MOST_BYTES)
    except FAULTS as err:
        collector.error("AUD001", f"the settings cannot be read: {why(err)}", span=Span(path))
        return {}, ""
    try:
        text = data.decode("utf-8")
        return tomllib.loads(text), text
    except UnicodeDecodeError as err:
        message = f"the file is not UTF-8, got the byte 0x{data[err.start]:02x}"
        span = Span(path, *place_of(data, err.start))
    except (ValueError, RecursionError) as err:
        at, why_not = toml_fault(data, err)
        message, span = f"this is not TOML: {why_not}", Span(path, *at)
    if not quietly or b"actspec" in data:
        collector.error("AUD001", message, span=span)
    return {}, ""
