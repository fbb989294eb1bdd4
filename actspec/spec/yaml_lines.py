"""A line of YAML as people write it: its key, its comment, its indentation, and a key that lacks its colon."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from actspec.diagnostics import many
from actspec.spec.yaml_text import cut

NO_SPACE = re.compile(r"([A-Za-z_][A-Za-z_0-9-]*):(\S.*)")
_PAIR = re.compile(r"""(["'])([A-Za-z_][A-Za-z_0-9-]*): +(\S.*)\1""")
_ITEM = re.compile(r"-([^\s-].*)")
EQUALS = re.compile(r"([A-Za-z_][A-Za-z_0-9-]*)\s*=\s*(\S.*)")
NAME = r"""[A-Za-z_][A-Za-z_0-9.-]*|"[^"]*"|'[^']*'"""
ALONE = re.compile(rf"({NAME})(?:\s+(.*))?")
COMMENT = re.compile(r"(?:^|(?<!\s)\s+)#.*")
OPENS, CLOSES = {"[": "]", "{": "}"}, {"]": "list", "}": "mapping"}
KEY = re.compile(r"""(?:- +)?("[^"]*"|'[^']*'|[^\s#'"\[{][^#]*?):(?:\s|$)""")


@dataclass(frozen=True, slots=True)
class Problem:
    """What is wrong with a text.

    Attributes:
        message: In plain words.
        help: What to write; None: nothing is known.
        mark: PyYAML's mark of the place, or one like it; None: unknown.
    """

    message: str
    help: str | None
    mark: Any


@dataclass(frozen=True, slots=True)
class Mark:
    """A place as PyYAML has it: line and column from 0."""

    line: int
    column: int


def no_colon(line: str, start: Any) -> Problem | None:
    """A line `kd:0.5` or `kd = 0.5`, on which the parser waits for a colon."""
    line = COMMENT.sub("", line)
    pair = _PAIR.fullmatch(line)
    if pair is not None:
        return Problem(
            "the quotes hold a key and its value together", f"write `{pair[2]}: {cut(pair[3])}`", start
        )
    item = _ITEM.fullmatch(line)
    if item is not None:
        return Problem(f"`{cut(line)}` lacks a space behind its hyphen", f"write `- {cut(item[1])}`", start)
    for form, what in ((NO_SPACE, "lacks a space behind its colon"), (EQUALS, "has `=` in place of `:`")):
        match = form.fullmatch(line)
        if match is not None:
            return Problem(f"`{cut(line)}` {what}", f"write `{match[1]}: {cut(match[2])}`", start)
    return None


def lacks_colon(line: str, number: int, form: re.Pattern[str]) -> Problem | None:
    """A line `motor ak80`, `motors` or `kp {value: 20}`: a key without its colon."""
    text = COMMENT.sub("", line.strip())
    match = form.fullmatch(text)
    if match is None or (form is ALONE and (": " in text or text.endswith(":"))):
        return None
    meant = f"{match[1]}: {match[2]}" if match[2] else f"{match[1]}:"
    return Problem(f"`{cut(match[1])}` has no `:`", f"write `{cut(meant)}`", Mark(number, indent(line)))


def line_above(lines: list[str], number: int) -> int | None:
    """The last line above one that holds something."""
    for other in range(min(number, len(lines)) - 1, -1, -1):
        if lines[other].strip() and not lines[other].lstrip().startswith("#"):
            return other
    return None


def indent(line: str) -> int:
    return len(line) - len(line.lstrip(" "))


def off_level(lines: list[str], number: int) -> Problem | None:
    """An item that is indented otherwise than the one before it in its list; the first, where those below are as this.

    Args:
        lines: The file.
        number: The line of the item.
    """
    own = indent(lines[number]) if number < len(lines) else 0
    above = _item_above(lines, number)
    if above is None or not _is_item(lines[number]) or indent(lines[above]) == own:
        return None
    its = indent(lines[above])
    below = next((n for n in range(number + 1, len(lines)) if line_above(lines, n + 1) == n), None)
    first = _item_above(lines, above)
    alone = first is None or indent(lines[first]) != its
    odd, right = number, above
    if alone and below is not None and _is_item(lines[below]) and indent(lines[below]) == own:
        odd, right = above, number
    one, other = indent(lines[odd]), indent(lines[right])
    beside = f"that of line {right + 1}, in the same list, by {other}"
    message = f"this item is indented by {many(one, 'space')}, and {beside}"
    return Problem(message, f"indent it by {many(other, 'space')}", Mark(odd, one))


def off_item(lines: list[str], number: int, column: int) -> Problem | None:
    """A key of an item that does not stand below its first one, or an item without its `- `.

    Args:
        lines: The file.
        number: The line behind the item.
        column: Where the list's items begin.
    """
    own, text = indent(lines[number]), COMMENT.sub("", lines[number].strip())
    items = (n for n in range(number - 1, -1, -1) if _is_item(lines[n]) and indent(lines[n]) == column)
    above = next(items, None)
    if above is None or own < column or _is_item(lines[number]):
        return None
    first = lines[above][column + 1 :]
    right = column + 1 + indent(first)
    if KEY.match(text) is None:
        lacks = own > column and KEY.match(first.strip()) is None
        help = f"write `- {cut(text)}`, indented by {column}"
        return Problem("this item lacks its `- `", help, Mark(number, own)) if lacks else None
    below = next((n for n in range(number + 1, len(lines)) if line_above(lines, n + 1) == n), None)
    goes_on = below is not None and _is_item(lines[below]) and indent(lines[below]) == column
    if KEY.match(first.strip()) is None or own == right or (own == column and not goes_on):
        return None
    message = (
        f"this line is indented by {many(own, 'space')}, and the first key of its item, in line {above + 1}, "
    )
    return Problem(f"{message}by {right}", f"indent it by {many(right, 'space')}", Mark(number, own))


def _item_above(lines: list[str], number: int) -> int | None:
    """The item before one in its list, at whatever indentation; None: it is the first, or stands among keys."""
    own, among_keys = indent(lines[number]), False
    above = line_above(lines, number)
    while above is not None:
        if _is_item(lines[above]):
            return None if among_keys and indent(lines[above]) + 2 != own else above
        if indent(lines[above]) < own:
            return None
        among_keys = among_keys or indent(lines[above]) == own
        above = line_above(lines, above)
    return None


def _is_item(line: str) -> bool:
    return line.lstrip().startswith("- ")
