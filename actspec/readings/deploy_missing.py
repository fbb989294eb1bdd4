"""What a deploy file lacks: gains that are read, where it has keys of gains, and a joint in one of its mappings."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping

import yaml

from actspec.diagnostics import Collector, nearest, shortened
from actspec.readings.artifact import Setting
from actspec.readings.dict_keys import PLAIN

MISSPELT = "DEPLOY006"
"""Code of a joint that stands in one mapping and not in another, whose name is nearly its."""

NO_GAINS = "it has no gains (kp, kps, stiffness, ...)"

_SELECT = ("joint_names_expr", "target_names_expr")
"""Keys by which an actuator group of Isaac Lab or mjlab selects its joints, in the YAML of a run too."""


_OF_A_RUN = (
    "its gains are of actuator groups, as Isaac Lab writes them into params/env.yaml of a run, which is not read: name "
    "the Python configuration that the run had"
)


def why_without_gains(
    root: yaml.Node | None,
    keys: Collection[str],
    mapping: Callable[[yaml.MappingNode], Mapping[str, yaml.Node]],
    number: Callable[[yaml.Node], float | None],
) -> tuple[str, yaml.Node | None]:
    """Why nothing of a file is taken as gains, with what to do, and where; the first key of gains decides.

    Args:
        root: The file; None: it is empty.
        keys: All names of gains.
        mapping: A mapping's own and merged keys.
        number: A node as a number; None for any other.
    """
    for block in _blocks(root, mapping):
        for key, value in block.items():
            if number(value) is not None and key in keys:
                if any(name in block for name in _SELECT):
                    return _OF_A_RUN, value
                beside = f"write joint_names: [...] there, or {key}: {{JOINT: NUMBER, ...}}"
                return (
                    f"its {key} is one number, and no list of joint names stands beside kp and kd: {beside}",
                    value,
                )
            if key not in keys and key.lower() in keys and isinstance(value, yaml.CollectionNode):
                return f"'{shortened(key)}' is no key that is read: write {key.lower()}", value
    return NO_GAINS, None


_LONGER = 2
"""Letters by which a name that holds another one whole is longer and still a slip. Chosen: `hip` is `hip_joint`'s."""


def misspelt(mappings: Mapping[str, Mapping[str, Setting]], out: Collector) -> None:
    """Say which joint of a mapping is another one's in the first mapping, by a slip of the pen.

    Args:
        mappings: Key of the file to its figures by joint; no list names the joints.
        out: Is told.
    """
    first, *others = mappings
    known = mappings[first]
    for key in others:
        own = mappings[key]
        if known.keys().isdisjoint(own):
            # A part of names here, whole names there.
            continue
        missing = [name for name in known if name not in own]
        # The YAML of a run has patterns.
        for name in (name for name in own if name not in known and PLAIN.fullmatch(name)):
            meant = slip(name, missing)
            if meant is not None:
                message = f"it has '{shortened(name)}' where {first} has '{shortened(meant)}': neither has both figures"
                help = "write the joint's name alike in both"
                out.warning(MISSPELT, message, where=key, span=own[name].span, help=help)


def slip(name: str, names: Iterable[str]) -> str | None:
    """The name that was meant by one that is none; None where no slip explains it."""
    meant = nearest(name, list(names))
    if meant is None:
        return None
    short, long = sorted((name, meant), key=len)
    return None if short in long and len(long) - len(short) > _LONGER else meant


def _blocks(
    root: yaml.Node | None, mapping: Callable[[yaml.MappingNode], Mapping[str, yaml.Node]]
) -> Iterator[Mapping[str, yaml.Node]]:
    """Every mapping of a file once, in its order; an alias may be one that it is in."""
    waiting, seen = [] if root is None else [root], set()
    while waiting:
        node = waiting.pop()
        if id(node) in seen:
            continue
        seen.add(id(node))
        if isinstance(node, yaml.MappingNode):
            block = mapping(node)
            yield block
            waiting += reversed(list(block.values()))
        elif isinstance(node, yaml.SequenceNode):
            waiting += reversed(node.value)
