"""Assignments to what is not read: a robot that comes from elsewhere, of which a task sets a gain.

`scene.robot.actuators["legs"].stiffness = 40.0` is of no joint that anybody here knows. The numbers are kept under the
text of their target, for `diff` and `lock`, which compare them as they stand.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from actspec.diagnostics import Span
from actspec.readings.artifact import RobotConfig, Setting
from actspec.readings.config import IN_FIGURES
from actspec.readings.python.values import (
    MAX_NESTING,
    Cls,
    External,
    Func,
    Obj,
    Seq,
    Table,
    Unknown,
    Value,
    reason_of,
)

MOST_ASSIGNED = 2000
"""Chosen: assignments of one file, and numbers of one of them, that are kept. The fullest task seen has 40."""

MOST_TEXT = 200
"""Chosen: characters of a target or value that is kept as text."""

MORE = "more than is read"

_OF_ROBOTS = frozenset({"robot", "robot_cfg", "actuators", "articulation", "init_state", "actions"})
"""Parts of a target that are about a robot; of the hundred others (rewards, terrain, sensors) nothing is read."""

_OF_DRIVES = IN_FIGURES | {"actuators", "joint_pos", "scale"}
"""Of these, those that a figure would be made from."""

_ALONE = frozenset(name for name in IN_FIGURES if "friction" not in name)
"""Settings that are a drive's whatever they are of; the ground has a friction too."""


@dataclass(frozen=True, slots=True)
class Assigned:
    """One assignment that changes nothing that is read.

    Attributes:
        target: As it is written, without `self`.
        value: What is assigned.
        text: That as it is written, after its operator where that is not `=`; "" where it is no statement.
        span: Where.
        stored: Whether it is kept in an object whose class is not read, of which some fields are read.
    """

    target: str
    value: Value
    text: str
    span: Span
    stored: bool


@dataclass(slots=True)
class Unapplied:
    """Gathers them while a file is folded.

    Attributes:
        found: In the order in which they happen.
        statement: That which assigns now; None outside of one.
    """

    found: list[Assigned] = field(default_factory=list)
    statement: ast.stmt | None = None
    _texts: dict[ast.AST, str] = field(default_factory=dict)

    def add(self, owner: Value, target: ast.expr, value: Value, span: Span) -> None:
        """Keep an assignment to an attribute or item of what is not read."""
        data = owner.data
        stored = isinstance(data, Obj) and data.open is not None
        # What may be one of several objects makes their figures unknown.
        gone = isinstance(data, External) or (isinstance(data, Unknown) and not data.among)
        if stored or gone:
            statement = self.statement
            written = statement if isinstance(statement, ast.AugAssign) else getattr(statement, "value", None)
            text = self._text(written) if isinstance(written, ast.AST) else ""
            if written is statement:
                # `*= 2.0`: by how much is told, of what nobody knows.
                text = text.removeprefix(self._text(target)).strip()
            self._keep(Assigned(self._text(target).removeprefix("self."), value, text, span, stored))

    def replaced(self, what: External, named: dict[str, Value], span: Span) -> None:
        """Keep what `.replace()` of something that is not read is given."""
        owner = what.dotted.split(".")[-2] if "." in what.dotted else what.dotted
        for name, value in named.items():
            self._keep(Assigned(f"{owner}.replace.{name}", value, "", span, False))

    def _keep(self, one: Assigned) -> None:
        words = _words(one.target)
        if len(self.found) < MOST_ASSIGNED and (not _OF_ROBOTS.isdisjoint(words) or words[-1] in _ALONE):
            self.found.append(one)

    def _text(self, node: ast.AST) -> str:
        """A node as text, made once: a function may be called often."""
        if node not in self._texts:
            try:
                self._texts[node] = ast.unparse(node)[:MOST_TEXT]
            except RecursionError:
                self._texts[node] = "..."
        return self._texts[node]


def sorted_out(
    assigned: Sequence[Assigned], config: RobotConfig, prefix: str = ""
) -> tuple[dict[str, Setting], dict[str, Setting]]:
    """Numbers that a drive's figure would be made from, and other values, by where they are assigned to.

    Args:
        assigned: In order; the last one counts.
        config: The configuration that they belong to: what it has read is left out.
        prefix: Before each target.
    """
    taken = {setting.span for setting in config.settings.values()}
    taken |= {setting.span for group in config.groups for setting in group.settings.values()}
    entries: dict[str, Setting] = {}
    others: dict[str, Setting] = {}
    left = MOST_ASSIGNED
    for one in assigned:
        if one.stored and (one.value.span in taken or isinstance(one.value.data, (Obj, Table))):
            continue
        for where, value, text in _leaves(one.target, one.value, one.text, left):
            left -= 1
            number = isinstance(value, (int, float)) and not isinstance(value, bool)
            place = entries if number and not _OF_DRIVES.isdisjoint(_words(where)) else others
            cut = MORE if text == MORE else None
            place[prefix + where] = Setting(value if number else text, one.span, cut)
            (others if place is entries else entries).pop(prefix + where, None)
    return entries, others


def _words(target: str) -> list[str]:
    return re.findall(r"\w+", target) or [""]


def _leaves(target: str, value: Value, text: str, most: int) -> Iterator[tuple[str, float | str | None, str]]:
    """Each number or text in a value, where it stands, and it as text; so many at most."""
    waiting: list[tuple[str, Value, int]] = [(target, value, 0)]
    count = 0
    while waiting:
        if count >= most:
            yield target, None, MORE
            return
        count += 1
        where, one, depth = waiting.pop()
        data = one.data
        inner: list[tuple[str, Value]] = []
        if isinstance(data, Obj):
            inner = [(f"{where}.{name}", held) for name, held in data.fields.items()]
        elif isinstance(data, Table):
            inner = [(f"{where}[{key!r}]", held) for key, held in data.items.items()]
        elif isinstance(data, Seq):
            inner = [(f"{where}[{place}]", held) for place, held in enumerate(data.items)]
        count += len(inner)
        if inner and depth < MAX_NESTING:
            waiting += [(name[:MOST_TEXT], held, depth + 1) for name, held in reversed(inner)]
        elif data is None or isinstance(data, (bool, int, float, str)):
            yield where, data, str(data)[:MOST_TEXT]
        else:
            name = data.name if isinstance(data, (Cls, External, Func)) else reason_of(data) or ""
            yield where, None, text if depth == 0 and text else name[:MOST_TEXT]
