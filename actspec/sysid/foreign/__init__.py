"""Results of other identification tools as results of actspec: what they found, in SI, and what they have no place for.

Nothing of a file is executed or unpickled. A number without a standard deviation stays without one.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

from actspec.diagnostics import Collector, Span, listed
from actspec.files import FAULTS, TooLarge, read_regular, why
from actspec.logs import LogError
from actspec.logs.tables import PICKLES
from actspec.owned import head_of
from actspec.spec.results import FORMAT
from actspec.sysid.foreign.figures import Found, Given, Options

TOOLS: Mapping[str, str] = {
    "bam": "actspec.sysid.foreign.bam",
    "pace": "actspec.sysid.foreign.pace",
    "mujoco-sysid": "actspec.sysid.foreign.mujoco_params",
    "line": "actspec.sysid.foreign.line",
}
"""Tool to the module whose `read` understands its files, and whose `EXPORT` makes text of a pickle."""

HEAD = f"{head_of('sysid import')} A spec takes it by `identified: THIS FILE` in a group.\n"
MAX_BYTES = 4 * 2**20
"""Largest file [bytes]. Chosen: a thousand times what the tools write."""


def read_foreign(tool: str, path: str, options: Options, collector: Collector) -> Found:
    """What a tool found.

    Args:
        tool: One of `TOOLS`.
        path: Its file.
        options: What the file does not say.
        collector: Takes what was left out, as warnings and notes.

    Raises:
        LogError: the file is not the tool's, cannot be read, or an option is missing.
    """
    module = import_module(TOOLS[tool])
    data = _read(path, module.EXPORT)
    for key in ("layout", "step", "commit", "names", "linear"):
        if getattr(options, key) and key not in module.OPTIONS:
            option = "--map" if key == "names" else f"--{key}"
            raise LogError.of("SYS071", f"`{option}` says nothing about a file of {tool}", where=option)
    if not all(name.strip() for name in options.joints):
        raise LogError.of("SYS071", "a joint has no name", where="--joint")
    twice = {joint for joint in options.joints if options.joints.count(joint) > 1}
    if twice:
        raise LogError.of("SYS071", f"a joint is named twice: {listed(sorted(twice))}", where="--joint")
    read: Callable[[Given, Options, Collector], Found] = module.read
    found = read(Given(path, data, hashlib.sha256(data).hexdigest()), options, collector)
    collector.raise_if_failed(LogError)
    if not any(joint.figures for joint in found.joints.values()):
        help = "what was left out, and why, stands above" if any(collector) else None
        collector.error("SYS070", "nothing in it is a figure of a joint", span=Span(path), help=help)
    collector.raise_if_failed(LogError)
    return found


class _Reasons(dict[str, str]):
    """What was left out, one a line."""


def foreign_text(found: Found, robot: str) -> str:
    """The results file's YAML.

    Args:
        found: What was read.
        robot: Name of the robot.
    """
    import yaml

    class Dumper(yaml.SafeDumper):
        """Numbers in one line each, reasons in lines of their own."""

    Dumper.add_representer(
        _Reasons,
        lambda dumper, data: dumper.represent_mapping("tag:yaml.org,2002:map", data, flow_style=False),
    )
    data: dict[str, Any] = {"format": FORMAT, "robot": robot, "method": found.method}
    if found.commit:
        data["commit"] = found.commit
    data["data"] = [{"path": found.given.path, "sha256": found.given.sha256}]
    if found.note:
        data["note"] = found.note
    data["joints"] = {}
    for name, joint in found.joints.items():
        entry: dict[str, Any] = {}
        for field, figure in joint.figures.items():
            section, _, key = field.rpartition(".")
            number = {"value": figure.value, "unit": figure.unit}
            if figure.std is not None:
                number["std"] = figure.std
            if figure.note is not None:
                number["note"] = figure.note
            (entry.setdefault(section, {}) if section else entry)[key] = number
        if joint.bounds_hit:
            entry["bounds_hit"] = list(joint.bounds_hit)
        if joint.left_out:
            entry["left_out"] = _Reasons(joint.left_out)
        data["joints"][name] = entry
    text: str = yaml.dump(
        data, Dumper=Dumper, sort_keys=False, default_flow_style=None, width=110, allow_unicode=True
    )
    return HEAD + text


def _read(path: str, export: str) -> bytes:
    """A file's bytes; a pickle is refused before it is opened, and by its first bytes."""
    named = path.lower().endswith(PICKLES)
    data = b""
    if not named:
        try:
            data = read_regular(path, MAX_BYTES)
        except TooLarge as err:
            message = f"the file has {err.size} bytes, at most {MAX_BYTES} are read"
            raise LogError.of("SYS070", message, Span(path)) from err
        except FAULTS as err:
            raise LogError.of("SYS070", f"the file cannot be read: {why(err)}", Span(path)) from err
    if named or data.startswith((b"\x80", b"PK\x03\x04", b"\x93NUMPY")):
        raise LogError.of(
            "SYS075", "such a file may run code when it is opened, and is not read", Span(path), help=export
        )
    return data
