"""Orders of joints that a deploy file states beside that of its lists, under whatever keys."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import yaml

from actspec.diagnostics import Span
from actspec.readings.artifact import RobotConfig
from actspec.readings.deploy_steps import nearest
from actspec.readings.yaml_nodes import number_of

MOST_BLOCKS = 50
"""Chosen: blocks with gains of one file up to which each is held to every list."""

MOST_VALUES = 20_000
"""Chosen: values in rows of one file that are looked at, aliases counted each time."""

_MOST_KEYS = 32
"""Chosen: keys of a joint's own mapping."""

_READ = ("joint_mapping", "joint_ids_map")
"""Keys of numbers that have brought the lists of a file into the order of its names already."""

_NONE = "-1"
"""The place of a joint that the other order lacks."""

_NUMBER = re.compile(r"[0-9]{1,6}")
"""Digits that count joints; int() refuses thousands of them."""

_Rows = list[tuple[str, yaml.Node]]
"""Values in a row, each with the name that it stands behind; empty in a list."""


def with_orders(
    configs: Sequence[RobotConfig], blocks: Iterable[Mapping[str, yaml.Node]], figures: Collection[str]
) -> tuple[RobotConfig, ...]:
    """The blocks of a deploy file, told whether another list or mapping of the file has their joints in another order.

    That has most of the names, in a list, as keys of a mapping, or in a list of mappings; or places from 0 or 1 on,
    each once, in a list, or beside the names.

    Args:
        configs: What was read of each.
        blocks: Every mapping of the file.
        figures: Keys whose numbers are figures of joints, and no places.
    """
    if len(configs) > MOST_BLOCKS:
        return tuple(configs)
    known: list[tuple[_Rows, bool]] = []
    left = MOST_VALUES
    for key, rows in _all_rows(blocks):
        left -= len(rows)
        if left < 0:
            break
        known.append((rows, key not in figures))
    return tuple(
        replace(config, reordered=any(_reorders(rows, places, config) for rows, places in known))
        if "joint_order" in config.settings
        else config
        for config in configs
    )


def in_policy_order(
    names: dict[str, Span] | None, scopes: Sequence[Mapping[str, yaml.Node]], count: int | None
) -> dict[str, Span] | None:
    """The names as the lists have them: `joint_mapping` has the place of each joint of the policy among the names.

    Source: rl_sar, rl_real_a1.cpp: motorCmd[joint_mapping[i]].Kp = motor_command.kp[i], and its lists are by i.

    Args:
        names: Each with its place; None: there are none.
        scopes: Mappings in which the places may stand, the nearest first.
        count: Entries of the gains' lists; None: they are none. A policy may have fewer joints than the robot.
    """
    found = nearest(scopes, ("joint_mapping",))
    if names is None or found is None or not isinstance(found[1], yaml.SequenceNode):
        return names
    places = [number_of(item) for item in found[1].value]
    known = set(range(len(names)))
    if len(places) not in (len(names), count) or len({*places} & known) < len(places):
        return names
    pairs = list(names.items())
    return dict(pairs[int(place)] for place in places if place is not None)


def _all_rows(blocks: Iterable[Mapping[str, yaml.Node]]) -> Iterator[tuple[str, _Rows]]:
    """What every value of a file has in rows, each with its key."""
    for block in blocks:
        for key, node in block.items():
            if key not in _READ:
                yield from _rows_of(key, node)


def _rows_of(key: str, node: yaml.Node) -> Iterator[tuple[str, _Rows]]:
    """What a list or a mapping has in a row, and what its mappings have at each of their keys; each with its key."""
    rows = _rows(node)
    if not rows:
        return
    yield key, rows
    below = [
        (name, value)
        for name, value in rows
        if isinstance(value, yaml.MappingNode) and len(value.value) <= _MOST_KEYS
    ]
    for inner, _ in _rows(below[0][1]) if below else ():
        yield (
            inner,
            [(name, one) for name, value in below for at, one in _rows(value) if inner and at == inner],
        )


def _rows(node: yaml.Node) -> _Rows:
    if isinstance(node, yaml.SequenceNode):
        return [("", item) for item in node.value]
    if not isinstance(node, yaml.MappingNode):
        return []
    rows = [(str(key.value), value) for key, value in node.value if isinstance(key, yaml.ScalarNode)]
    if rows and all(_NUMBER.fullmatch(key) for key, _ in rows):
        # By place: `{0: hip, 1: knee}`.
        return [("", value) for _, value in sorted(rows, key=lambda row: int(row[0]))]
    return rows


def _reorders(rows: _Rows, places: bool, config: RobotConfig) -> bool:
    """Whether a row has the joints of a block in another order than its list of names, or their places there."""
    order = config.settings["joint_order"]
    names = tuple(map(str, order.value)) if isinstance(order.value, tuple) else ()
    if 2 * len(rows) <= len(names):
        return False
    # `joint_mapping` has moved them; where they stand tells how they were.
    written = sorted(names, key=lambda name: (order.place(name).line, order.place(name).column))
    texts = [value.value for _, value in rows if value.tag.endswith(":str")]
    for row in ([name for name, _ in rows], texts):
        common = {*row} & {*names}
        if 2 * len(common) > len(names) and len(common) == min(len({*row}), len(names)):
            here = [name for name in dict.fromkeys(row) if name in common]
            if all(here != [name for name in own if name in common] for own in (names, written)):
                return True
    if any(name for name, _ in rows):
        beside = dict(rows)
        rows = [(name, beside[name]) for name in names if name in beside]
    if not places or not all(_is_place(value) for _, value in rows):
        return False
    numbers = [int(value.value) for _, value in rows if value.value != _NONE]
    many = 2 * len(numbers) > len(names) and len({*numbers}) == len(numbers)
    return many and max(numbers) <= len(names) and numbers != sorted(numbers)


def _is_place(node: yaml.Node) -> bool:
    """Whether a value counts joints."""
    number = isinstance(node, yaml.ScalarNode) and node.tag.endswith(":int")
    return number and (node.value == _NONE or _NUMBER.fullmatch(node.value) is not None)
