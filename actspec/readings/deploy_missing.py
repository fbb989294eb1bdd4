"""What a deploy file lacks: gains that are read, where it has keys of gains, and a joint in one of its mappings."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import yaml

from actspec.diagnostics import Collector, listed, nearest, shortened
from actspec.readings.artifact import Setting
from actspec.readings.deploy_keys import STANDING, gain_of, joint_lists, own_gains
from actspec.readings.deploy_numbers import by_side
from actspec.readings.dict_keys import PLAIN
from actspec.readings.yaml_nodes import number_of

MISSPELT = "DEPLOY006"
"""Code of a joint that stands in one mapping and not in another, whose name is nearly its."""

NO_GAINS = "it has no gains (kp, kps, stiffness, ...)"

_SELECT = ("joint_names_expr", "target_names_expr")
"""Keys by which an actuator group of Isaac Lab or mjlab selects its joints, in the YAML of a run too."""


_OF_A_RUN = (
    "its gains are of actuator groups, without the scene, sim and decimation of a run's params/env.yaml: name that "
    "file, or the Python configuration that the run had"
)


@dataclass(frozen=True, slots=True)
class Lack:
    """Why nothing of a file is taken as gains.

    Attributes:
        why: In a sentence, with what to do.
        node: What it is about; None: the file.
        of_joints: Whether the file has gains of joints, whatever they are called, and as many names.
    """

    why: str
    node: yaml.Node | None = None
    of_joints: bool = False


def why_without_gains(
    root: yaml.Node | None,
    gains: Mapping[str, Sequence[str]],
    names: Sequence[str],
    mapping: Callable[[yaml.MappingNode], Mapping[str, yaml.Node]],
) -> Lack:
    """Why nothing of a file is taken as gains; the first key of gains of joints decides, else the first like one.

    Args:
        root: The file; None: it is empty.
        gains: `kp` and `kd` to all keys of either.
        names: Keys of the list of joint names.
        mapping: A mapping's own and merged keys.
    """
    lists = joint_lists(blocks_of(root, mapping))
    for block in blocks_of(root, mapping):
        own = own_gains(block, lists, mapping)
        if len(own) > 1:
            keys = listed(dict.fromkeys(shortened(one.kp) for one in own))
            why = f"it has gains as {keys}, and does not say which the joints run: write those as kp and kd"
            return Lack(why, own[0].node, any(one.named for one in own))
        if own:
            return Lack(_other_key(own[0].kp), own[0].node, own[0].named)
    known = [key for keys in gains.values() for key in keys]
    for block in blocks_of(root, mapping):
        for key, value in block.items():
            if key in known and number_of(value) is not None:
                return Lack(_of_one_number(key, block, gains, names), value)
            if key in known and isinstance(value, yaml.MappingNode):
                sides = by_side([*mapping(value).items()])
                if sides:
                    return Lack(f"its {key} has {sides}", value)
            if key in known or not isinstance(value, yaml.CollectionNode):
                continue
            if key in STANDING:
                why = f"its {key} is of getting up and lying down, and the policy's gains (rl_kp, rl_kd) are not here"
                return Lack(why, value)
            if key.lower() in known:
                return Lack(_other_key(key), value)
            if gain_of(key) is not None:
                why = f"{NO_GAINS}: '{shortened(key)}' is no key that is read"
                return Lack(why, value)
    return Lack(NO_GAINS)


def _other_key(key: str) -> str:
    found = gain_of(key)
    return (
        f"'{shortened(key)}' is no key that is read: write {found[0] if found and found[1] else key.lower()}"
    )


def _of_one_number(
    key: str, block: Mapping[str, yaml.Node], gains: Mapping[str, Sequence[str]], names: Sequence[str]
) -> str:
    """Why one number is no gain of joints."""
    if any(name in block for name in _SELECT):
        return _OF_A_RUN
    of_joints = f"{key}: {{JOINT: NUMBER, ...}}"
    lists = [name for name in names if isinstance(block.get(name), yaml.SequenceNode)]
    other = next(gain for gain, keys in gains.items() if key not in keys)
    if lists and not any(one in block for one in gains[other]):
        return (
            f"its {key} is one number, and no {other} stands beside it: write {other} there, or {of_joints}"
        )
    if lists:
        return f"its {key} is one number, and {lists[0]} is no list with each joint's name once"
    beside = f"write joint_names: [...] there, or {of_joints}"
    return f"its {key} is one number, and no list of joint names stands beside kp and kd: {beside}"


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


def blocks_of(
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
