"""Included files: which a spec may name, what they may hold, and where that goes."""

from __future__ import annotations

import os
import re

from actspec.diagnostics import Collector, Span
from actspec.spec.yaml_text import cut
from actspec.spec.yaml_tree import Node

MAX_INCLUDES = 64
"""Most included files. Chosen: one a motor, with room."""
INCLUDED_KEYS = ("motors", "sources")
"""What an included file may hold."""

_URL = re.compile(r"[A-Za-z][A-Za-z0-9+.-]+://.*|file:.*", re.S)
_DRIVE = re.compile(r"[A-Za-z]:.*", re.S)


def included_names(node: Node, collector: Collector) -> list[tuple[str, Span]]:
    """The names under `include`, all of them checked to be text."""
    if not isinstance(node.value, list):
        text = node.value if isinstance(node.value, str) else "motors.yaml"
        help = f"write `include: [{cut(text)}]`"
        collector.error("SPEC012", "must be a list of file names", where="include", span=node.span, help=help)
        return []
    if len(node.value) > MAX_INCLUDES:
        message = f"{len(node.value)} files are included, at most {MAX_INCLUDES} are read"
        help = "put the motors into fewer files"
        collector.error("SPEC012", message, where="include", span=node.span, help=help)
        return []
    names = []
    for index, item in enumerate(node.value):
        if isinstance(item.value, str) and item.value:
            names.append((item.value, item.span))
        else:
            message = "must be a file name, as text"
            collector.error("SPEC012", message, where=f"include[{index}]", span=item.span)
    return names if len(names) == len(node.value) else []


def path_inside(
    name: str, base: str | None, index: int, span: Span, collector: Collector
) -> tuple[str, str] | None:
    """The include's path for messages and its real path, if that is inside the folder of the spec."""
    problem = None
    real = ""
    if base is None:
        problem = "a text without a folder cannot include files"
    elif _URL.fullmatch(name):
        problem = "is a URL; only files are included"
    elif name.startswith(("/", "\\")) or _DRIVE.fullmatch(name):
        problem = "is an absolute path"
    elif "\\" in name:
        problem = "has a backslash; folders are separated by `/`"
    elif _climbs(name):
        problem = "leaves the folder of the spec by `..`"
    else:
        root = os.path.realpath(base)
        real = os.path.realpath(os.path.join(root, name))
        if os.path.commonpath([root, real]) != root:
            problem = "leaves the folder of the spec by a symbolic link"
    if problem is None:
        return os.path.normpath(os.path.join(base or "", name)), real
    collector.error(
        "SPEC013",
        f"'{cut(name)}' {problem}" if base is not None else problem,
        where=f"include[{index}]",
        span=span,
        help="an include is a relative path inside the folder of the spec, such as motors/unitree.yaml",
    )
    return None


def _climbs(name: str) -> bool:
    depth = 0
    for part in name.split("/"):
        depth += -1 if part == ".." else part not in ("", ".")
        if depth < 0:
            return True
    return False


def check_included(root: Node, collector: Collector) -> None:
    """An included file holds motors and sources by name, and nothing else."""
    assert isinstance(root.value, dict)
    for key, (span, node) in root.value.items():
        if key == "include":
            message = "an included file cannot include another"
            collector.error("SPEC014", message, where=key, span=span, help="include both files in the spec")
        elif key not in INCLUDED_KEYS:
            message = f"an included file cannot hold '{cut(key)}', only `motors` and `sources`"
            collector.error("SPEC014", message, where=cut(key), span=span, help="move it into the spec")
        elif not isinstance(node.value, dict) and node.value is not None:
            collector.error("SPEC014", f"`{key}` must be a mapping of names", where=key, span=node.span)


def merge(into: Node, part: Node, collector: Collector) -> None:
    """Add an included file's motors and sources; a name that is there already is an error."""
    assert isinstance(into.value, dict) and isinstance(part.value, dict)
    for section in INCLUDED_KEYS:
        if section not in part.value:
            continue
        key_span, added = part.value[section]
        own_span, own = into.value.get(section, (key_span, Node(added.span, None)))
        if not isinstance(added.value, dict) or not (own.value is None or isinstance(own.value, dict)):
            continue
        names = dict(own.value or {})
        for name, entry in added.value.items():
            if name in names:
                collector.error(
                    "SPEC015",
                    f"'{cut(name)}' is defined twice, first at {names[name][0]}",
                    where=f"{section}.{cut(name)}",
                    span=entry[0],
                    help="rename one of the two, or remove it",
                )
            else:
                names[name] = entry
        into.value[section] = (own_span, Node(own.span, names))
