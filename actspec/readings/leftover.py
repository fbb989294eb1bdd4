"""Values of a deploy file that no figure is made from: for `diff` and `lock`, which compare them as they stand.

A list without names says by its place alone which joint an entry is of, and so does a map of indices. Nobody guesses
the joint; but that the entry is another one can be told.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import yaml

from actspec.diagnostics import Span
from actspec.readings.artifact import RobotConfig, Setting
from actspec.readings.yaml_nodes import node_span, number_of, setting_of

MOST_VALUES = 20_000
"""Chosen: values of one file that are kept. The fullest deploy file seen has 700."""

MOST_LEVELS = 20
"""Chosen: lists and mappings within each other; aliases may form a circle."""

_STEP = re.compile(r"(?:^|\.)(?:dt|decimation|\w+_(?:dt|decimation))(?: of entry .*)?$")

_HASH = re.compile(r"[0-9a-f]{64}")


@dataclass(slots=True)
class Leftover:
    """Collects what no configuration of a file has taken.

    Attributes:
        configs: Of the file, in order.
        mapping: A mapping's own and merged keys.
        least: Numbers in one list or mapping from which on they may be of joints; fewer may be the ends of a range.
        left: Values that may still be looked at.
        cut: Whether that was not enough, and was said.
    """

    configs: Sequence[RobotConfig]
    mapping: Callable[[yaml.MappingNode], Mapping[str, yaml.Node]]
    least: int
    left: int = MOST_VALUES
    cut: bool = False

    def kept(self, root: yaml.Node) -> tuple[RobotConfig, ...]:
        """The configurations with what is left over: each with what stands in its block, the first with the rest."""
        taken = {setting.span for config in self.configs for setting in _settings(config)}
        orders = [set(_texts(config.settings.get("joint_order"))) for config in self.configs]
        owners: dict[Span, int] = {}
        for index, config in enumerate(self.configs):
            owners.setdefault(config.span, index)
        entries: list[dict[str, Setting]] = [{} for _ in self.configs]
        others: list[dict[str, Setting]] = [{} for _ in self.configs]
        for owner, where, value, counted in self._values(root, "", 0, taken, orders, owners, 0):
            (entries if counted else others)[owner][where] = value
        return tuple(
            replace(config, entries=own, others=other)
            for config, own, other in zip(self.configs, entries, others, strict=True)
        )

    def _values(
        self,
        node: yaml.Node,
        where: str,
        owner: int,
        taken: set[Span],
        orders: Sequence[set[str]],
        owners: Mapping[Span, int],
        depth: int,
    ) -> Iterator[tuple[int, str, Setting, bool]]:
        """Owner, place in words, value, and whether it may be of a joint, or of all as a step."""
        span = node_span(node)
        size = len(node.value) if isinstance(node, yaml.SequenceNode) else 0
        if self.left <= size or depth > MOST_LEVELS:
            if not self.cut:
                yield owner, where, Setting(None, span, "more than is read"), False
            self.cut = self.left <= 0
            return
        # Aliases make few nodes many: a list costs its length each time.
        self.left -= 1 + size
        if isinstance(node, yaml.ScalarNode):
            # A hash is of what is compared, or of what its file has.
            if span not in taken and not _HASH.fullmatch(node.value):
                value = _scalar(node)
                yield owner, where, value, is_step(where) and value.number is not None
            return
        if span in taken and isinstance(node, yaml.SequenceNode):
            return
        inner: list[tuple[str, yaml.Node]]
        if isinstance(node, yaml.MappingNode):
            owner = owners.get(span, owner)
            inner = [(_below(where, key), one) for key, one in self.mapping(node).items()]
        else:
            texts = {one.value for one in node.value if isinstance(one, yaml.ScalarNode)}
            if texts and texts in orders:
                return
            inner = [(f"entry {place} of {where}", one) for place, one in enumerate(node.value, 1)]
            if any(node_span(one) in taken for _, one in inner):
                # A list that is taken, with `null` or a word among its numbers.
                return
        counted = len(inner) >= self.least and all(number_of(one) is not None for _, one in inner)
        for name, one in inner:
            if counted:
                if node_span(one) not in taken:
                    yield owner, name, _scalar(one), True
            else:
                yield from self._values(one, name, owner, taken, orders, owners, depth + 1)


def _scalar(node: yaml.Node) -> Setting:
    return setting_of(node) or Setting(str(node.value), node_span(node))


def is_step(where: str) -> bool:
    """Whether a place is called a step or a period, which acts on every joint, whosever it is."""
    return _STEP.search(where) is not None


def _below(where: str, key: str) -> str:
    if not where:
        return key
    return f"{key} of {where}" if where.startswith("entry ") else f"{where}.{key}"


def _settings(config: RobotConfig) -> Iterable[Setting]:
    yield from config.settings.values()
    for term in config.actions:
        yield from (one for one in (term.scale, term.zero, term.clip) if one is not None)
    for group in config.groups:
        yield from group.settings.values()


def _texts(setting: Setting | None) -> tuple[str, ...]:
    value = () if setting is None else setting.value
    return tuple(one for one in value if isinstance(one, str)) if isinstance(value, tuple) else ()
