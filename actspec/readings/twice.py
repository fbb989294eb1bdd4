"""What a deploy file has twice: a key, of which readers take one value or the other, and the name of a joint."""

from __future__ import annotations

import yaml

from actspec.diagnostics import Collector, Diagnostic, shortened
from actspec.readings.yaml_nodes import node_span

TWICE = "DEPLOY004"
"""Code of both."""

_MOST_COMPARED = 10_000
"""Chosen: values of two keys of one name that are held against each other; beyond, they differ."""


def keys_twice(root: yaml.Node) -> tuple[Diagnostic, ...]:
    """Keys that a mapping has twice, with another value.

    YAML 1.2 (3.2.1.1) allows none, and readers take either: PyYAML makes a dict of the pairs in their order, so that
    the last stays; yaml-cpp keeps them all and looks for the first (`node_data::get`).

    Args:
        root: The file's nodes.
    """
    out = Collector()
    waiting, seen = [root], {id(root)}
    while waiting:
        node = waiting.pop()
        inner = list(node.value) if isinstance(node, yaml.SequenceNode) else []
        if isinstance(node, yaml.MappingNode):
            _of_mapping(node, out)
            inner = [value for _, value in node.value]
        for item in inner:
            if id(item) not in seen:
                seen.add(id(item))
                waiting.append(item)
    return out.sorted()


def _of_mapping(node: yaml.MappingNode, out: Collector) -> None:
    last: dict[tuple[str, str], yaml.Node] = {}
    for key, value in node.value:
        if not isinstance(key, yaml.ScalarNode) or key.tag == "tag:yaml.org,2002:merge":
            continue
        word = str(key.value)
        before = last.get((key.tag, word))
        if before is not None and not _is_same(before, value):
            line = before.start_mark.line + 1
            message = (
                f"'{shortened(word)}' stands a second time, with another value than in line {line}: "
                "PyYAML takes the last one, yaml-cpp the first"
            )
            out.warning(TWICE, message, span=node_span(key), help="keep one of them")
        last[(key.tag, word)] = value


OF_LISTS = "which joint a value of the lists belongs to is not known"


def name_twice(names: yaml.SequenceNode, out: Collector, why: str = OF_LISTS) -> None:
    """Report the first name that a list of joints has twice.

    Args:
        names: The list, of scalars.
        out: Gets it.
        why: What it leaves open.
    """
    first: dict[str, yaml.Node] = {}
    for item in names.value:
        before = first.setdefault(str(item.value), item)
        if before is not item:
            place = node_span(before)
            message = (
                f"the joint names have '{shortened(str(item.value))}' twice, first at {place.line}:{place.column}: "
                f"{why}"
            )
            help = "name each joint once" + (", in the order of the lists" if why == OF_LISTS else "")
            out.warning(TWICE, message, span=node_span(item), help=help)
            return


def _is_same(one: yaml.Node, other: yaml.Node) -> bool:
    """Whether two values are written alike, but for spaces and quotes."""
    waiting = [(one, other)]
    for _ in range(_MOST_COMPARED):
        if not waiting:
            return True
        a, b = waiting.pop()
        if a is b:
            continue
        if type(a) is not type(b) or a.tag != b.tag:
            return False
        if isinstance(a, yaml.ScalarNode):
            if a.value != b.value:
                return False
        elif len(a.value) != len(b.value):
            return False
        elif isinstance(a, yaml.SequenceNode):
            waiting += zip(a.value, b.value, strict=True)
        else:
            pairs = zip(a.value, b.value, strict=True)
            waiting += [both for own, its in pairs for both in zip(own, its, strict=True)]
    return False
