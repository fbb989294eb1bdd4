"""What a YAML parser found, in plain words: the line that is wrong, and what to write in its place."""

from __future__ import annotations

import re
from typing import Any

from actspec.diagnostics import many
from actspec.spec.yaml_flow import bound, brackets, folded, in_comment, list_as_key, no_comma, open_quote
from actspec.spec.yaml_lines import (
    ALONE,
    CLOSES,
    COMMENT,
    KEY,
    NAME,
    OPENS,
    Mark,
    Problem,
    indent,
    lacks_colon,
    line_above,
    no_colon,
    off_item,
    off_level,
)
from actspec.spec.yaml_text import BREAK, cut, stray_character

_QUOTE = "quote text that begins with one of [ ] { } * & ! | > % @ `"
_SINGLE = "put text with backslashes into single quotes"
_PROBLEMS: tuple[tuple[str, str, str | None], ...] = (
    (
        "mapping values are not allowed",
        "a `: ` is not expected here",
        "check the indentation, or quote the text",
    ),
    ("could not find expected ':'", "this key has no `:`", "write `key: value`; check the indentation"),
    (
        "unknown escape character",
        "this backslash begins no escape of double quotes",
        "put a pattern into single quotes, such as '\\d+'",
    ),
    ("invalid Unicode", "an escape in double quotes names no character", None),
    ("hexdecimal", "an escape in double quotes lacks digits", _SINGLE),
    ("hexadecimal", "an escape in double quotes lacks digits", _SINGLE),
    ("unexpected end of stream", "this quote is never closed", "close it"),
    ("node content", "a value is expected here", None),
    ("<document start>", "the text goes on after its end", "check the indentation; begin with `actspec: 1`"),
    (
        "sequence entries are not allowed",
        "a list item `- ` cannot stand behind its key",
        "write the items on lines of their own, or in [ ]",
    ),
    (
        "mapping keys are not allowed",
        "a `?` is no value",
        "for a figure that nobody states write `unknown`",
    ),
)

_ONE_WORD = re.compile(NAME)
_SECOND_KEY = re.compile(r"\s([A-Za-z_][A-Za-z_0-9-]*):\s$")
_RATIO = re.compile(r"(\d+(?:\.\d+)?)\s*:\s*([1-9]\d*(?:\.\d+)?)")
_IN_BRACES = re.compile(r"[{,]\s*([A-Za-z_][A-Za-z_0-9-]*):\s")
_QUOTED = re.compile(
    r"""(\s*(?:- +)?[A-Za-z_][A-Za-z_0-9-]*:\s+)(?P<quote>["'])(?P<text>[^"'\\]*)(?P=quote)\s*"""
)
"""What stands before text behind a quoted value."""
_EMPTY = re.compile(rf"\s*((?:{NAME}):)\s+(?:\[ *\]|\{{ *\}})")
_NAMES = re.compile(rf"((?:{NAME})(?:\s*,\s*(?:{NAME}))+)\s*:(?:\s.*)?")


def too_deep(problem: str) -> bool:
    """Whether PyYAML ended at libyaml's own bound, which it meets first where it reads ahead."""
    return "maximum nesting depth" in problem


def plain_problem(problem: str, context: str, text: str, mark: Any, start: Any) -> Problem:
    """An error of the parser in plain words.

    Args:
        problem: What PyYAML found.
        context: What it was reading.
        text: The file.
        mark: PyYAML's place of the error; None: unknown.
        start: Where what it was reading begins; None: unknown.
    """
    lines = BREAK.split(text)
    at = ""
    if mark is not None and mark.line < len(lines):
        at = lines[mark.line][mark.column : mark.column + 1]
    found = _look_alike(lines, mark, start) or list_as_key(lines, mark)
    if found is not None:
        return found
    if "node content" in problem and at == "-":
        return Problem("a list in [ ] has no `- `", "remove the `- `, or the `[`", mark)
    if "node content" in problem and at == ",":
        return Problem("nothing stands before this `,`", "remove it", mark)
    if "cannot start any token" in problem:
        rest = lines[mark.line][mark.column :] if at else ""
        meant = bound(at, rest, lines[mark.line][: mark.column]) if at else None
        return Problem(f"a value cannot begin with {at or 'this character'}", meant or _QUOTE, mark)
    if "alias" in context:
        help = "a joint pattern must be quoted: '.*_hip_joint'"
        return Problem("`*` begins an alias here, and this is no alias", help, mark)
    if "anchor" in context:
        return Problem("`&` begins an anchor here, and this is no anchor", "quote the text", mark)
    if "block scalar" in context and start is not None and start.line < len(lines):
        return folded(lines[start.line], start)
    if mark is not None and mark.line < len(lines) and "end of stream" not in problem:
        found = brackets(lines, mark)
        if found is not None:
            return found
    if at and "flow" in context:
        found = open_quote(lines[mark.line], mark)
        if found is not None:
            return found
    before = "" if mark is None else lines[mark.line][: mark.column][-1:] if at else ""
    if at.isalnum() and before in ("'", '"'):
        help = (
            "write it twice, or put the text into double quotes"
            if before == "'"
            else 'write `\\"` in the text'
        )
        return Problem(f"the `{before}` before this letter ends the text", help, mark)
    if "could not find expected ':'" in problem and start is not None and start.line < len(lines):
        line = lines[start.line].strip()
        found = no_colon(line, start) or lacks_colon(lines[start.line], start.line, ALONE)
        if found is not None:
            return found
    if "mapping values are not allowed" in problem and mark is not None:
        found = _second_colon(lines, mark)
        if found is not None:
            return found
    if "flow" in context and ("',' or ']'" in problem or "',' or '}'" in problem) and start is not None:
        kind, end = ("list", "]") if "]" in problem else ("mapping", "}")
        found = in_comment(lines, start, mark, kind, end) or (
            None if mark is None else no_comma(lines, mark, kind, end)
        )
        if found is not None:
            return found
        ends = mark is None or not "".join(lines[mark.line :])[mark.column :].strip()
        until = "" if ends else f", and line {mark.line + 1} does not go on with it"
        return Problem(f"this {kind} lacks a `,` or its `{end}`{until}", f"close it with `{end}`", start)
    for part, message, advice in _PROBLEMS:
        if part in problem:
            return Problem(message, advice, mark)
    if "block" in context and mark is not None:
        found = off_level(lines, mark.line) or _no_level(lines, mark)
        if found is not None:
            return found
    if "block collection" in context:
        found = None if start is None or mark is None else off_item(lines, mark.line, start.column)
        if found is not None:
            return found
        if (
            start is not None
            and mark is not None
            and _items(lines[start.line : mark.line], start.column) == 1
        ):
            return _item_among_keys(lines[start.line], start)
        if at in (",", ";"):
            return _ends_nothing(lines[mark.line], mark)
        return Problem("a list item must begin with `- ` at the indentation of its list", _QUOTE, mark)
    if "block mapping" in context:
        if at == "-" and mark.column == indent(lines[mark.line]):
            above = line_above(lines, mark.line)
            first = "" if above is None else COMMENT.sub("", lines[above])
            if first.strip()[:1] in OPENS and indent(first) == mark.column and above is not None:
                return Problem(
                    "this item lacks its `- `", f"write `- {cut(first.strip())}`", Mark(above, mark.column)
                )
            return _item_among_keys(lines[mark.line], mark)
        found = None if mark is None or at in (",", ";") else _below_a_value(lines, mark.line)
        if found is not None:
            return found
        if at in (",", ";"):
            return _ends_nothing(lines[mark.line], mark)
        quoted = _QUOTED.fullmatch(lines[mark.line][: mark.column]) if at else None
        if quoted is not None:
            rest = COMMENT.sub("", lines[mark.line][mark.column :]).strip()
            meant = f"{quoted[1]}{quoted['text']} {rest}"
            return Problem(
                f"`{cut(rest)}` stands behind the closing quote of a value",
                f"write `{cut(meant.strip())}`, or all of it in quotes",
                mark,
            )
        return Problem("a key is expected here, at the indentation of its mapping", _QUOTE, mark)
    message = f"not valid YAML: {problem or 'no reason given'}" + (f", {context}" if context else "")
    return Problem(message, None, mark)


def _look_alike(lines: list[str], mark: Any, start: Any) -> Problem | None:
    """A character that looks like one of YAML's, where the parser stopped, where it began or on the line above."""
    at = [place.line for place in (mark, start) if place is not None]
    above = None if mark is None else line_above(lines, mark.line)
    for number in sorted({*at, *([] if above is None else [above])}):
        line = lines[number] if number < len(lines) else ""
        stray = stray_character(COMMENT.sub("", line))
        if stray is not None:
            return Problem(stray[1], stray[2], Mark(number, stray[0]))
        if line.lstrip().startswith(("//", "/*")):
            remark = line.strip().strip("/* ")
            return Problem(
                f"`{cut(line.strip()[:2])}` begins no comment",
                f"write `# {cut(remark)}`",
                Mark(number, indent(line)),
            )
    return None


def _ends_nothing(line: str, mark: Any) -> Problem:
    """A `,` or `;` behind the value of a key, or behind an item."""
    names = _NAMES.fullmatch(COMMENT.sub("", line.strip()))
    if names is not None:
        help = "write a line for each, or one pattern, such as `(left|right)_knee`"
        return Problem(
            f"`{cut(names[1])}` are several keys before one `:`", help, Mark(mark.line, indent(line))
        )
    key, rest = KEY.match(line.strip()), COMMENT.sub("", line[mark.column :])
    if key is None or len(rest) < 2:
        return Problem(
            f"this `{line[mark.column]}` ends nothing, as the end of the line does", "remove it", mark
        )
    value = COMMENT.sub("", line.strip()[key.end() :]).strip(" ,;")
    close = OPENS.get(value[:1])
    if close is None:
        message = f"what stands behind `{cut(key[1])}:` is several texts, and no list"
        whole = f"[{value.replace(';', ',')}]"
    else:
        message = f"the `{close}` before this `{line[mark.column]}` ends the {CLOSES[close]}"
        whole = f"{value.replace(close, '', 1).rstrip(close)}{close}"
    return Problem(message, f"write `{cut(f'{key[1]}: {whole}')}`", mark)


def _items(lines: list[str], column: int) -> int:
    return sum(indent(line) == column and line.lstrip().startswith("- ") for line in lines)


def _item_among_keys(line: str, mark: Any) -> Problem:
    text = COMMENT.sub("", line.strip()).removeprefix("-").strip()
    return Problem(
        "this `- ` begins a list, and keys stand beside it", f"write `{cut(text)}` without `- `", mark
    )


def _second_colon(lines: list[str], mark: Any) -> Problem | None:
    """A `: ` where a value stands already: in a text, or on a line that is indented below a value."""
    line = lines[mark.line] if mark.line < len(lines) else ""
    key = KEY.match(line.strip())
    if key is not None and len(line) - len(line.lstrip()) + key.end(1) < mark.column:
        value = line.strip()[key.end() :].strip()
        ratio = _RATIO.fullmatch(COMMENT.sub("", value))
        if ratio is not None:
            help = f"write `{key[1]}: {float(ratio[1]) / float(ratio[2]):.6g}`"
            return Problem(f"`{cut(value)}` is two numbers, not a ratio", help, mark)
        second = _SECOND_KEY.search(line[: mark.column + 2].rstrip() + " ")
        found = None if second is None else _on_one_line(key[1], value, second[1], mark.line, second.start(1))
        if found is not None:
            return found
        bare = COMMENT.sub("", value)
        if bare[0] + bare[-1] == "()":
            help = f"write `{cut(f'{key[1]}: {{{bare[1:-1]}}}')}`"
            return Problem("( ) holds no keys, which { } does", help, mark)
        help = f'put it into quotes: {key[1]}: "{cut(value)}"' if '"' not in value else "quote the text"
        return Problem("the `: ` inside this text begins a mapping", help, mark)
    above = line_above(lines, mark.line)
    if above is None:
        return None
    own, number = indent(line), above
    if indent(lines[number]) == own:
        # `kd:0.5` is a text, which goes on here.
        found = no_colon(lines[number].strip(), Mark(number, own))
        if found is not None:
            return found
    # So is `kd 0.5`, but not below a key that has a value already.
    first: int | None = None
    over: int | None = above
    while over is not None and indent(lines[over]) == own:
        first, over = over, line_above(lines, over)
    if first is not None and (over is None or COMMENT.sub("", lines[over]).rstrip().endswith(":")):
        found = lacks_colon(lines[first], first, ALONE)
        if found is not None:
            return found
    return _below_a_value(lines, mark.line)


def _on_one_line(key: str, value: str, second: str, line: int, column: int) -> Problem | None:
    """`kp: 400 N*m/rad kd: 25 N*m*s/rad` and `friction: coulomb: 1 N*m`: two keys on one line.

    Args:
        key: The first.
        value: What stands behind it.
        second: The other.
        line: Where they stand, from 0.
        column: Where the other stands, from 0.
    """
    first, mark = value[: value.index(second)].strip(), Mark(line, column)
    if not first and value.partition(":")[2].strip()[:1].isdigit():
        message = f"`{second}:` stands on the line of `{key}:`"
        return Problem(message, f"write `{key}: {{{cut(value)}}}`, or it below, indented further", mark)
    if not first or (not first[0].isdigit() and " " in first) or key in ("title", "note", "page"):
        return None
    message = f"`{second}:` stands behind the value of `{key}`"
    if second in ("source", "note", "std", "unit", "sure"):
        rest = value[value.index(second) :]
        return Problem(message, f"write `{key}: {{value: {cut(first.rstrip(','))}, {cut(rest)}}}`", mark)
    return Problem(message, "write it on a line of its own", mark)


def _below_a_value(lines: list[str], number: int) -> Problem | None:
    """A line that is indented below one that has a value already."""
    above = line_above(lines, number)
    if above is None or number >= len(lines):
        return None
    own, its = indent(lines[number]), indent(lines[above])
    item = off_level(lines, number)
    if item is None and lines[above].lstrip().startswith("- "):
        item = off_item(lines, number, its)
    if item is not None:
        return item
    if own <= its or COMMENT.sub("", lines[above]).rstrip().endswith(":"):
        return None
    if _ONE_WORD.fullmatch(COMMENT.sub("", lines[above].strip())):
        return lacks_colon(lines[above], above, ALONE)
    empty = _EMPTY.fullmatch(COMMENT.sub("", lines[above]).rstrip())
    if empty is not None:
        message = f"`{cut(lines[above].strip())}` is empty, and what belongs to it stands below"
        return Problem(message, f"write `{cut(empty[1])}`", Mark(above, its))
    group = _fallen_out(lines, above, own)
    if group is not None:
        message = f"this line is indented by {many(its, 'space')}, and those above and below it, of `{group}`, by {own}"
        return Problem(message, f"indent it by {many(own, 'space')}", Mark(above, its))
    section = _section_below(lines, number) if its == 0 else None
    if section is not None:
        message = f"what begins here belongs to `{section}`: the line `{section}:` is missing above"
        return Problem(message, f"write `{section}:` at the left edge, above this line", Mark(number, own))
    return Problem(
        f"this line is indented by {many(own, 'space')}, below line {above + 1} which has {its} and a value already",
        f"indent it by {many(its, 'space')} as line {above + 1}, if it is a key beside it, or line {above + 1} "
        f"by {own}",
        Mark(number, own),
    )


_NAMED_ITEMS = frozenset(("motors", "actuators", "sources", "linkages"))
"""Sections whose items are mappings: beside their names no other value stands."""


def _fallen_out(lines: list[str], number: int, own: int) -> str | None:
    """The name of the group or motor that a line belongs to, whose keys around it are further in.

    It stands among names, and has a value that no name has. None: the line may be right.

    Args:
        lines: The file.
        number: The line.
        own: Indentation of the line below it.
    """
    its, before = indent(lines[number]), line_above(lines, number)
    pair = KEY.match(lines[number].strip())
    if pair is None or lines[number].strip()[len(pair[0]) :][:1] in ("", "{", "&", "*", "#"):
        return None
    name: str | None = None
    if before is None or indent(lines[before]) < own:
        return None
    while indent(lines[before]) > 0:
        if name is None and indent(lines[before]) <= its:
            header = KEY.match(lines[before].strip())
            if header is None or indent(lines[before]) < its:
                return None
            name = header[1]
        elif indent(lines[before]) < its:
            return None
        before = line_above(lines, before)
        if before is None:
            return None
    section = KEY.match(lines[before])
    return name if section is not None and section[1] in _NAMED_ITEMS else None


def _section_below(lines: list[str], number: int) -> str | None:
    """The section of which lines are that stand below the left edge; None: unclear, or the file has it.

    Args:
        lines: The file.
        number: The first of them.
    """
    # The models take time to load, and a file that is right needs none of them here.
    from actspec.spec.shape import section_of

    own = indent(lines[number])
    outer: list[str] = []
    inner: list[str] = []
    for line in lines[number:]:
        if line.strip() and not line.lstrip().startswith("#") and indent(line) < own:
            break
        key = KEY.match(line.strip())
        if key is not None:
            (outer if indent(line) == own else inner).append(key[1])
            inner += _IN_BRACES.findall(line) if indent(line) == own else []
    section = section_of(inner, outer)
    have = section is None or any(line.startswith(f"{section}:") for line in lines)
    return None if have else section


def _no_level(lines: list[str], mark: Any) -> Problem | None:
    """A line whose indentation is none of those that are open above it."""
    if mark.line >= len(lines) or not lines[mark.line].strip():
        return None
    own = indent(lines[mark.line])
    open_levels: list[tuple[int, int]] = []
    for number, line in enumerate(lines[: mark.line]):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        while open_levels and open_levels[-1][0] >= indent(line):
            open_levels.pop()
        open_levels.append((indent(line), number))
    levels = [level for level, _ in open_levels]
    if own in levels or not levels or own > levels[-1]:
        return None
    # The key that is open between the levels around it: its own indentation may be what is wrong.
    outer = next((number for level, number in reversed(open_levels) if level < own), None)
    if outer is not None:
        found = _nameless(lines, outer, own)
        if found is not None:
            return found
    if outer is not None and (above := line_above(lines, outer)) is not None:
        one, header = indent(lines[outer]), KEY.match(COMMENT.sub("", lines[above]).rstrip())
        key = KEY.match(COMMENT.sub("", lines[outer].strip()))
        # A section of names without one: the first of them stands beside it.
        if (
            one == indent(lines[above]) == 0
            and header is not None
            and header[1] in _NAMED_ITEMS
            and COMMENT.sub("", lines[above]).rstrip().endswith(":")
            and key is not None
            and key[1] not in _NAMED_ITEMS
        ):
            message = f"`{key[1]}` stands beside `{header[1]}`, which is empty, and what follows is indented by {own}"
            return Problem(message, f"indent it by {many(own, 'space')}", Mark(outer, one))
    if outer is not None and (name := _name_at_edge(lines, outer)) is not None:
        message = (
            f"`{cut(name)}` stands at the left edge, and is no section; what follows is indented by {own}"
        )
        return Problem(message, f"indent it by {many(own, 'space')}", Mark(outer, 0))
    if outer is not None and (odd := _odd_first(lines, outer, mark.line)) is not None:
        one = indent(lines[odd])
        return Problem(
            f"this line is indented by {many(one, 'space')}, and those below it in the same mapping by {own}",
            f"indent it by {many(own, 'space')}",
            Mark(odd, one),
        )
    named = ", ".join(str(level) for level in levels)
    if any(indent(line) == own and line.strip() for n, line in enumerate(lines) if n != mark.line):
        # Others are indented so, and one above them may be wrong.
        help = f"indent it by one of these, or check the indentation of line {(outer or 0) + 1}"
    else:
        lower = max((held for held in open_levels if held[0] < own), default=None)
        (deeper, beside) = min(held for held in open_levels if held[0] > own)
        help = f"indent it by {many(deeper, 'space')} as line {beside + 1}"
        if lower is not None:
            help += f", or by {lower[0]} as line {lower[1] + 1}"
    message = f"this line is indented by {many(own, 'space')}, and what is open above it by {named}"
    return Problem(message, help, Mark(mark.line, own))


def _name_at_edge(lines: list[str], number: int) -> str | None:
    """The name of a line at the left edge that is no section, where the section above it holds names; None: it is."""
    from actspec.spec.shape import is_section

    key = None if indent(lines[number]) else KEY.match(lines[number])
    sections = (found[1] for line in reversed(lines[:number]) if (found := KEY.match(line)) is not None)
    named = key is not None and not is_section(key[1]) and next(sections, None) in _NAMED_ITEMS
    return key[1] if key is not None and named else None


def _odd_first(lines: list[str], header: int, at: int) -> int | None:
    """The one key below a header that is further in than two or more keys that follow it; None: it is another fault.

    Args:
        lines: The file.
        header: The line of the header.
        at: The first of the keys that follow.
    """
    own, outer = indent(lines[at]), indent(lines[header])

    def keys(numbers: range) -> list[int]:
        return [n for n in numbers if lines[n].strip() and not lines[n].lstrip().startswith("#")]

    above = keys(range(header + 1, at))
    ends = next((n for n in keys(range(at, len(lines))) if indent(lines[n]) <= outer), len(lines))
    below = [n for n in keys(range(at, ends)) if indent(lines[n]) == own]
    alone = len(above) == 1 and own < indent(lines[above[0]])
    return above[0] if alone and len(below) > 1 and all(KEY.match(lines[n].strip()) for n in below) else None


def _nameless(lines: list[str], header: int, own: int) -> Problem | None:
    """Fields that stand where a section has names, further in than the names further down.

    Args:
        lines: The file.
        header: Where the section begins.
        own: Indentation of the names.
    """
    from actspec.spec.shape import word_for

    first = next((n for n in range(header + 1, len(lines)) if line_above(lines, n + 1) == n), None)
    if first is None or indent(lines[first]) <= own:
        return None
    section, key = (KEY.match(lines[n].strip()) for n in (header, first))
    word = None if section is None or key is None else word_for(section[1], key[1])
    if section is None or key is None or word is None:
        return None
    message = f"`{key[1]}` is a field of a {word}, and the line with the name of that {word} is missing above"
    help = f"write the name above this line, such as `{word}_1:`, indented by {many(own, 'space')}"
    return Problem(message, help, Mark(first, indent(lines[first])))
