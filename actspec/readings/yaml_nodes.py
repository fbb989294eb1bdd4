"""A stranger's YAML as nodes: nothing is constructed, tags are looked at and never acted upon."""

from __future__ import annotations

import io
import math
from typing import Any

import yaml

from actspec.diagnostics import Span, one_line
from actspec.files import place_of
from actspec.readings.artifact import Setting
from actspec.spec.yaml_problems import too_deep

MOST_STEPS = 200_000
"""Chosen: values visited in one file, aliases counted each time."""
MOST_DEPTH = 40
"""Chosen: deepest nesting that is followed."""


class Unfit(Exception):
    """The file is no YAML that can be read, or too much of it.

    Attributes:
        at: Line and column, from 1; 0 where there is none.
    """

    def __init__(self, message: str, at: tuple[int, int] = (0, 0)) -> None:
        super().__init__(message)
        self.at = at

    def span(self, path: str) -> Span:
        """The place in a file."""
        return Span(path, *self.at)


class _Text(io.StringIO):
    """A text that its marks know by the name of its file."""

    def __init__(self, text: str, name: str) -> None:
        super().__init__(text)
        self.name = name


def compose(data: bytes, path: str = "") -> yaml.Node | None:
    """The nodes of a YAML text, nothing constructed; None for an empty one.

    Args:
        data: The text.
        path: Its file, for `node_span`.

    Raises:
        Unfit: it is no YAML, or too much of it.
    """
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as err:
        at = err.start + len(data) - len(err.object)
        raise Unfit(f"it is not UTF-8, byte 0x{err.object[err.start]:02x}", place_of(data, at)) from None
    loader = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    try:
        depth = 0
        # libyaml's composer recurses on the C stack: a deep file would end the process.
        for count, event in enumerate(yaml.parse(text, Loader=loader)):
            depth += isinstance(event, yaml.CollectionStartEvent) - isinstance(event, yaml.CollectionEndEvent)
            if depth > MOST_DEPTH:
                raise Unfit(f"it is nested more than {MOST_DEPTH} deep", position(event.start_mark))
            if count > MOST_STEPS:
                raise Unfit(f"it has more than {MOST_STEPS} values", position(event.start_mark))
        node: yaml.Node | None = yaml.compose(_Text(text, path), Loader=loader)
    except yaml.MarkedYAMLError as err:
        mark = err.problem_mark or err.context_mark
        place = position(mark) if mark else (0, 0)
        if too_deep(err.problem or ""):
            raise Unfit(f"it is nested more than {MOST_DEPTH} deep", place) from None
        raise Unfit(f"it is not YAML: {one_line(err.problem or 'malformed')}", place) from None
    except yaml.reader.ReaderError as err:
        before = text[: err.position]
        place = before.count("\n") + 1, len(before) - before.rfind("\n")
        raise Unfit(f"it is not YAML: {one_line(err.reason)}", place) from None
    except (yaml.YAMLError, ValueError) as err:
        raise Unfit(f"it is not YAML: {one_line(str(err))}") from None
    return node


def position(mark: Any) -> tuple[int, int]:
    """Line and column of a mark, from 1."""
    return mark.line + 1, mark.column + 1


def number_of(node: yaml.Node) -> float | None:
    """A finite number; None for anything else, a word that Python's YAML takes for text included."""
    whole = node.tag == "tag:yaml.org,2002:int"
    if not isinstance(node, yaml.ScalarNode) or not (whole or node.tag == "tag:yaml.org,2002:float"):
        return None
    construct: Any = yaml.constructor.SafeConstructor()
    try:
        # As the robot's own YAML reader does it: `010` is eight there.
        value = float(construct.construct_yaml_int(node) if whole else construct.construct_yaml_float(node))
    except (ValueError, OverflowError):
        return None
    return value if math.isfinite(value) else None


def node_span(node: yaml.Node) -> Span:
    """Where a node begins, in the file that it was composed of."""
    return Span(node.start_mark.name, *position(node.start_mark))


def setting_of(node: yaml.Node) -> Setting | None:
    """A finite number with its place; None for anything else."""
    value = number_of(node)
    return None if value is None else Setting(value, node_span(node))
