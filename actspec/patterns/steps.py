"""How many steps Python's `re` may take: an upper bound, from the parse tree alone."""

from __future__ import annotations

from typing import Any


def steps(tree: Any, length: int, most: int) -> int | None:
    """Upper bound of the steps that backtracking takes on a name of `length`; None above `most`.

    Counts the paths by which the matcher can reach each position, as if every character class
    matched every character; each path that arrives at a node is one step there.
    """
    counter = _Counter(most)
    try:
        counter.sequence(tree, [1] + [0] * length)
    except _TooMany:
        return None
    return counter.steps


class _TooMany(Exception):
    pass


class _Counter:
    def __init__(self, most: int) -> None:
        self.most = most
        self.steps = 0

    def spend(self, paths: list[int]) -> int:
        arriving = sum(paths)
        self.steps += arriving
        if self.steps > self.most:
            raise _TooMany
        return arriving

    def sequence(self, tree: Any, paths: list[int]) -> list[int]:
        """Number of paths at each position after the sequence, from those before it."""
        for op, value in tree:
            if not self.spend(paths):
                break
            paths = self.node(op, value, paths)
        return paths

    def node(self, op: Any, value: Any, paths: list[int]) -> list[int]:
        name = str(op)
        if name in ("LITERAL", "NOT_LITERAL", "ANY", "IN"):
            return [0, *paths[:-1]]
        if name == "SUBPATTERN":
            return self.sequence(value[3], paths)
        if name == "BRANCH":
            total = [0] * len(paths)
            for alternative in value[1]:
                total = [a + b for a, b in zip(total, self.sequence(alternative, paths), strict=True)]
            return total
        if name in ("MAX_REPEAT", "MIN_REPEAT"):
            return self.repeat(value, paths)
        if name in ("ASSERT", "ASSERT_NOT"):
            self.sequence(value[1], paths)
        return paths

    def repeat(self, value: Any, paths: list[int]) -> list[int]:
        low, high, body = value
        total = list(paths) if low == 0 else [0] * len(paths)
        done = 0
        while done < high and self.spend(paths):
            paths = self.sequence(body, paths)
            done += 1
            if done >= low:
                total = [a + b for a, b in zip(total, paths, strict=True)]
        return total
