"""What a YAML parser found, in plain words: the line that is wrong, and what to write in its place."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from actspec.diagnostics import many
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

_NO_SPACE = re.compile(r"([A-Za-z_][A-Za-z_0-9-]*):(\S.*)")
_PAIR = re.compile(r"""(["'])([A-Za-z_][A-Za-z_0-9-]*): +(\S.*)\1""")
_ITEM = re.compile(r"-([^\s-].*)")
_EQUALS = re.compile(r"([A-Za-z_][A-Za-z_0-9-]*)\s*=\s*(\S.*)")
_NAME = r"""[A-Za-z_][A-Za-z_0-9.-]*|"[^"]*"|'[^']*'"""
_BEFORE_BRACKET = re.compile(rf"({_NAME})\s+([\[{{].*)")
_BEHIND_QUOTE = re.compile(r"""("[^"]*"|'[^']*')\s+([^:\s].*)""")
_ALONE = re.compile(rf"({_NAME})(?:\s+(.*))?")
_ONE_WORD = re.compile(_NAME)
_SECOND_KEY = re.compile(r"\s([A-Za-z_][A-Za-z_0-9-]*):\s$")
_RATIO = re.compile(r"(\d+(?:\.\d+)?)\s*:\s*([1-9]\d*(?:\.\d+)?)")
_IN_BRACES = re.compile(r"[{,]\s*([A-Za-z_][A-Za-z_0-9-]*):\s")
_LIST_VALUE = re.compile(r"([A-Za-z_][A-Za-z_0-9-]*): +([^\[\]{}]+)$")
_NAMES = re.compile(rf"((?:{_NAME})(?:\s*,\s*(?:{_NAME}))+)\s*:(?:\s.*)?")
_COMMENT = re.compile(r"(?:^|(?<!\s)\s+)#.*")
_WORD = re.compile(r""""[^"]*"|'[^']*'|[^\s,:\[\]{}]+""")
_IN_TEXT = re.compile(r"""[{,]\s*(note|title):\s+(?=[^\s"'\[\]{},])(?=[^\[\]{},]*$)""")
"""A text in { } that stands open at the end."""
_END_OF_TEXT = re.compile(rf"\s*(?:\}}|,\s*(?:{_NAME}):\s)")
_OPENS, _CLOSES = {"[": "]", "{": "}"}, {"]": "list", "}": "mapping"}
_KEY = re.compile(r"""(?:- +)?("[^"]*"|'[^']*'|[^\s#'"\[{][^#]*?):(?:\s|$)""")


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
class _Mark:
    """A place as PyYAML has it: line and column from 0."""

    line: int
    column: int


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
    found = _look_alike(lines, mark, start)
    if found is not None:
        return found
    if "node content" in problem and at == "-":
        return Problem("a list in [ ] has no `- `", "remove the `- `, or the `[`", mark)
    if "node content" in problem and at == ",":
        return Problem("nothing stands before this `,`", "remove it", mark)
    if "cannot start any token" in problem:
        rest = lines[mark.line][mark.column :] if at else ""
        meant = _bound(at, rest, lines[mark.line][: mark.column]) if at else None
        return Problem(f"a value cannot begin with {at or 'this character'}", meant or _QUOTE, mark)
    if "alias" in context:
        help = "a joint pattern must be quoted: '.*_hip_joint'"
        return Problem("`*` begins an alias here, and this is no alias", help, mark)
    if "anchor" in context:
        return Problem("`&` begins an anchor here, and this is no anchor", "quote the text", mark)
    if "block scalar" in context and start is not None and start.line < len(lines):
        return _folded(lines[start.line], start)
    if mark is not None and mark.line < len(lines) and "end of stream" not in problem:
        found = _marks(lines, mark)
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
        found = _no_colon(line, start) or _lacks_colon(lines[start.line], start.line, _ALONE)
        if found is not None:
            return found
    if "mapping values are not allowed" in problem and mark is not None:
        found = _second_colon(lines, mark)
        if found is not None:
            return found
    if "flow" in context and ("',' or ']'" in problem or "',' or '}'" in problem) and start is not None:
        kind, end = ("list", "]") if "]" in problem else ("mapping", "}")
        found = None if mark is None else _no_comma(lines, mark, kind, end)
        if found is not None:
            return found
        ends = mark is None or not "".join(lines[mark.line :])[mark.column :].strip()
        until = "" if ends else f", and line {mark.line + 1} does not go on with it"
        return Problem(f"this {kind} lacks a `,` or its `{end}`{until}", f"close it with `{end}`", start)
    for part, message, advice in _PROBLEMS:
        if part in problem:
            return Problem(message, advice, mark)
    if "block" in context and mark is not None:
        found = _no_level(lines, mark)
        if found is not None:
            return found
    if "block collection" in context:
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
        if at == "-" and mark.column == _indent(lines[mark.line]):
            above = _above(lines, mark.line)
            first = "" if above is None else _COMMENT.sub("", lines[above])
            if first.strip()[:1] in _OPENS and _indent(first) == mark.column and above is not None:
                return Problem(
                    "this item lacks its `- `", f"write `- {cut(first.strip())}`", _Mark(above, mark.column)
                )
            return _item_among_keys(lines[mark.line], mark)
        found = None if mark is None or at in (",", ";") else _below_a_value(lines, mark.line)
        if found is not None:
            return found
        if at in (",", ";"):
            return _ends_nothing(lines[mark.line], mark)
        return Problem("a key is expected here, at the indentation of its mapping", _QUOTE, mark)
    message = f"not valid YAML: {problem or 'no reason given'}" + (f", {context}" if context else "")
    return Problem(message, None, mark)


def _look_alike(lines: list[str], mark: Any, start: Any) -> Problem | None:
    """A character that looks like one of YAML's, where the parser stopped, where it began or on the line above."""
    at = [place.line for place in (mark, start) if place is not None]
    above = None if mark is None else _above(lines, mark.line)
    for number in sorted({*at, *([] if above is None else [above])}):
        line = lines[number] if number < len(lines) else ""
        stray = stray_character(_COMMENT.sub("", line))
        if stray is not None:
            return Problem(stray[1], stray[2], _Mark(number, stray[0]))
        if line.lstrip().startswith(("//", "/*")):
            remark = line.strip().strip("/* ")
            return Problem(
                f"`{cut(line.strip()[:2])}` begins no comment",
                f"write `# {cut(remark)}`",
                _Mark(number, _indent(line)),
            )
    return None


def _bound(sign: str, rest: str, before: str) -> str | None:
    """What to write in place of `>30 Hz` and `%25` in [ ] and { }.

    Args:
        sign: What the value begins with.
        rest: The line from there on.
        before: The line up to there.
    """
    value = re.split(r"[\],}]|: | #", rest)[0].strip()
    number = value.lstrip("><=~|@%` ").rstrip("` ")
    if not number[:1].isdigit():
        return None
    if sign != ">":
        return f"write `{cut(number)}{' %' * (sign == '%')}`"
    pair = f'value: {cut(number)}, note: "{cut(value)}"'
    inside = before.rstrip().endswith("value:")
    return f"a bound stands in a note: write `{pair if inside else f'{{{pair}}}'}`"


def _folded(line: str, start: Any) -> Problem:
    """`> 60 Hz`, of which the `>` begins a text of several lines."""
    sign, value = line[start.column], _COMMENT.sub("", line[start.column :]).strip()
    number = value.lstrip(">|= ")
    help = "quote it, if it is text"
    if number[:1].isdigit():
        help = f'a bound stands in a note: write `{{value: {cut(number)}, note: "{cut(value)}"}}`'
    return Problem(
        f"`{sign}` begins a text of several lines, and `{cut(value)}` goes on behind it", help, start
    )


def _no_colon(line: str, start: Any) -> Problem | None:
    """A line `kd:0.5` or `kd = 0.5`, on which the parser waits for a colon."""
    line = _COMMENT.sub("", line)
    pair = _PAIR.fullmatch(line)
    if pair is not None:
        return Problem(
            "the quotes hold a key and its value together", f"write `{pair[2]}: {cut(pair[3])}`", start
        )
    item = _ITEM.fullmatch(line)
    if item is not None:
        return Problem(f"`{cut(line)}` lacks a space behind its hyphen", f"write `- {cut(item[1])}`", start)
    for form, what in ((_NO_SPACE, "lacks a space behind its colon"), (_EQUALS, "has `=` in place of `:`")):
        match = form.fullmatch(line)
        if match is not None:
            return Problem(f"`{cut(line)}` {what}", f"write `{match[1]}: {cut(match[2])}`", start)
    return None


def _lacks_colon(line: str, number: int, form: re.Pattern[str]) -> Problem | None:
    """A line `motor ak80`, `motors` or `kp {value: 20}`: a key without its colon."""
    text = _COMMENT.sub("", line.strip())
    match = form.fullmatch(text)
    if match is None or (form is _ALONE and (": " in text or text.endswith(":"))):
        return None
    meant = f"{match[1]}: {match[2]}" if match[2] else f"{match[1]}:"
    return Problem(f"`{cut(match[1])}` has no `:`", f"write `{cut(meant)}`", _Mark(number, _indent(line)))


def _marks(lines: list[str], mark: Any) -> Problem | None:
    """A quote that ends on another line, a key before a bracket, or a bracket that closes nothing, at a place.

    Args:
        lines: The file.
        mark: Where the parser stopped.
    """
    opened: list[str] = []
    closed = False
    quote: tuple[str, int, int] | None = None
    for number, line in enumerate(lines[: mark.line + 1]):
        here = number == mark.line
        if here and not opened and quote is None:
            for form in (_BEFORE_BRACKET, _BEHIND_QUOTE):
                found = _lacks_colon(line, number, form)
                if found is not None:
                    return found
        before, closed = "", False
        for column, char in enumerate(line):
            if quote is not None:
                if char == quote[0] and not (char == '"' and line[:column].endswith("\\")):
                    if here and quote[1] < number and column <= mark.column:
                        return _not_closed(lines, quote)
                    quote, before = None, char
                continue
            if char == "#" and not line[:column].strip(" ") + line[column - 1 : column].strip(" "):
                break
            # In a text of a block these characters have no meaning.
            begins = not before or before in "[{," or (before in ":-" and line[column - 1] == " ")
            if char in "\"'" and begins:
                quote = char, number, column
            elif char in _OPENS and (begins or opened):
                opened.append(char)
            elif (
                char == "]"
                and opened[-1:] == ["{"]
                and here
                and (begun := _LIST_VALUE.search(line[max(0, column - 200) : column]))
            ):
                help = f"write `{begun[1]}: [{cut(begun[2])}]`"
                return Problem("this list lacks its `[`", help, _Mark(number, column - len(begun[2])))
            elif char in _CLOSES and opened:
                opened.pop()
                closed = True
            elif char in _CLOSES and here:
                return _closes_nothing(line, _Mark(number, column), closed)
            elif char == "#" and line[column - 1] == " ":
                break
            if char != " ":
                before = char
    return None


def _not_closed(lines: list[str], quote: tuple[str, int, int]) -> Problem:
    char, number, column = quote
    text = _COMMENT.sub("", lines[number][column + 1 :])
    word = re.split(r"[\],}]|: ", text)[0].rstrip("\u201c\u201d\u00bb\u2019")
    return Problem(
        "this quote is not closed on its line", f"write `{char}{cut(word)}{char}`", _Mark(number, column)
    )


def _closes_nothing(line: str, mark: _Mark, closed: bool) -> Problem:
    """A `]` or `}` without the one that opens.

    Args:
        line: Where it stands.
        mark: Its place.
        closed: Whether another that was open is closed on this line.
    """
    end = line[mark.column]
    glued = _NO_SPACE.fullmatch(line.strip())
    if glued is not None and glued[2][0] in _OPENS:
        # `delay:{nominal: 4 ms}` begins no mapping.
        return _no_colon(line.strip(), _Mark(mark.line, _indent(line))) or _end_without_begin(end, mark)
    key = _KEY.match(line.strip())
    if closed or key is None:
        return _end_without_begin(end, mark)
    begin = next(char for char, other in _OPENS.items() if other == end)
    value = line[_indent(line) + key.end() : mark.column + 1].strip()
    help = f"write `{cut(f'{key[1]}: {begin}{value}')}`"
    return Problem(f"this {_CLOSES[end]} lacks its `{begin}`", help, _Mark(mark.line, line.index(value)))


def _end_without_begin(end: str, mark: _Mark) -> Problem:
    return Problem(f"this `{end}` closes nothing", "remove it", mark)


def _no_comma(lines: list[str], mark: Any, kind: str, end: str) -> Problem | None:
    """An item of a list or mapping that stands behind another on its line without a comma."""
    line = lines[mark.line] if mark.line < len(lines) else ""
    at = line[mark.column : mark.column + 1]
    if at in _CLOSES:
        return Problem(f"this {kind} ends with `{at}`", f"close it with `{end}`", mark)
    if at == ":":
        word = next((m for m in _WORD.finditer(line) if m.end() == len(line[: mark.column].rstrip())), None)
    else:
        word = _WORD.match(line, mark.column)
    if word is None or word.start() == _indent(line):
        return None
    text = _IN_TEXT.search(line, 0, word.start())
    if at == ":" and text is not None:
        rest = _END_OF_TEXT.split(line[text.end() :], maxsplit=1)[0].rstrip()
        help = f'put it into quotes: {text[1]}: "{cut(rest)}"' if '"' not in rest else "quote the text"
        return Problem("the `: ` inside this text begins a mapping", help, _Mark(mark.line, mark.column))
    return Problem(f"a `,` is missing before `{cut(word[0])}`", None, _Mark(mark.line, word.start()))


def _ends_nothing(line: str, mark: Any) -> Problem:
    """A `,` or `;` behind the value of a key, or behind an item."""
    names = _NAMES.fullmatch(_COMMENT.sub("", line.strip()))
    if names is not None:
        help = "write a line for each, or one pattern, such as `(left|right)_knee`"
        return Problem(
            f"`{cut(names[1])}` are several keys before one `:`", help, _Mark(mark.line, _indent(line))
        )
    key, rest = _KEY.match(line.strip()), _COMMENT.sub("", line[mark.column :])
    if key is None or len(rest) < 2:
        return Problem(
            f"this `{line[mark.column]}` ends nothing, as the end of the line does", "remove it", mark
        )
    value = _COMMENT.sub("", line.strip()[key.end() :]).strip(" ,;")
    close = _OPENS.get(value[:1])
    if close is None:
        message = f"what stands behind `{cut(key[1])}:` is several texts, and no list"
        whole = f"[{value.replace(';', ',')}]"
    else:
        message = f"the `{close}` before this `{line[mark.column]}` ends the {_CLOSES[close]}"
        whole = f"{value.replace(close, '', 1).rstrip(close)}{close}"
    return Problem(message, f"write `{cut(f'{key[1]}: {whole}')}`", mark)


def _items(lines: list[str], column: int) -> int:
    return sum(_indent(line) == column and line.lstrip().startswith("- ") for line in lines)


def _item_among_keys(line: str, mark: Any) -> Problem:
    text = _COMMENT.sub("", line.strip()).removeprefix("-").strip()
    return Problem(
        "this `- ` begins a list, and keys stand beside it", f"write `{cut(text)}` without `- `", mark
    )


def _second_colon(lines: list[str], mark: Any) -> Problem | None:
    """A `: ` where a value stands already: in a text, or on a line that is indented below a value."""
    line = lines[mark.line] if mark.line < len(lines) else ""
    key = _KEY.match(line.strip())
    if key is not None and len(line) - len(line.lstrip()) + key.end(1) < mark.column:
        value = line.strip()[key.end() :].strip()
        ratio = _RATIO.fullmatch(_COMMENT.sub("", value))
        if ratio is not None:
            help = f"write `{key[1]}: {float(ratio[1]) / float(ratio[2]):.6g}`"
            return Problem(f"`{cut(value)}` is two numbers, not a ratio", help, mark)
        second = _SECOND_KEY.search(line[: mark.column + 2].rstrip() + " ")
        found = None if second is None else _on_one_line(key[1], value, second[1], mark.line, second.start(1))
        if found is not None:
            return found
        bare = _COMMENT.sub("", value)
        if bare[0] + bare[-1] == "()":
            help = f"write `{cut(f'{key[1]}: {{{bare[1:-1]}}}')}`"
            return Problem("( ) holds no keys, which { } does", help, mark)
        help = f'put it into quotes: {key[1]}: "{cut(value)}"' if '"' not in value else "quote the text"
        return Problem("the `: ` inside this text begins a mapping", help, mark)
    above = _above(lines, mark.line)
    if above is None:
        return None
    own, number = _indent(line), above
    if _indent(lines[number]) == own:
        # `kd:0.5` is a text, which goes on here.
        found = _no_colon(lines[number].strip(), _Mark(number, own))
        if found is not None:
            return found
    # So is `kd 0.5`, but not below a key that has a value already.
    first: int | None = None
    over: int | None = above
    while over is not None and _indent(lines[over]) == own:
        first, over = over, _above(lines, over)
    if first is not None and (over is None or _COMMENT.sub("", lines[over]).rstrip().endswith(":")):
        found = _lacks_colon(lines[first], first, _ALONE)
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
    first, mark = value[: value.index(second)].strip(), _Mark(line, column)
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
    above = _above(lines, number)
    if above is None or number >= len(lines):
        return None
    own, its = _indent(lines[number]), _indent(lines[above])
    if own <= its:
        return None
    if _ONE_WORD.fullmatch(_COMMENT.sub("", lines[above].strip())):
        return _lacks_colon(lines[above], above, _ALONE)
    section = _section_below(lines, number) if its == 0 else None
    if section is not None:
        message = f"what begins here belongs to `{section}`: the line `{section}:` is missing above"
        return Problem(message, f"write `{section}:` at the left edge, above this line", _Mark(number, own))
    return Problem(
        f"this line is indented by {many(own, 'space')}, below line {above + 1} which has {its} and a value already",
        f"indent it by {many(its, 'space')} as line {above + 1}, if it is a key beside it, or line {above + 1} "
        f"by {own}",
        _Mark(number, own),
    )


def _section_below(lines: list[str], number: int) -> str | None:
    """The section of which lines are that stand below the left edge; None: unclear, or the file has it.

    Args:
        lines: The file.
        number: The first of them.
    """
    # The models take time to load, and a file that is right needs none of them here.
    from actspec.spec.shape import section_of

    own = _indent(lines[number])
    outer: list[str] = []
    inner: list[str] = []
    for line in lines[number:]:
        if line.strip() and not line.lstrip().startswith("#") and _indent(line) < own:
            break
        key = _KEY.match(line.strip())
        if key is not None:
            (outer if _indent(line) == own else inner).append(key[1])
            inner += _IN_BRACES.findall(line) if _indent(line) == own else []
    section = section_of(inner, outer)
    have = section is None or any(line.startswith(f"{section}:") for line in lines)
    return None if have else section


def _no_level(lines: list[str], mark: Any) -> Problem | None:
    """A line whose indentation is none of those that are open above it."""
    if mark.line >= len(lines) or not lines[mark.line].strip():
        return None
    own = _indent(lines[mark.line])
    open_levels: list[tuple[int, int]] = []
    for number, line in enumerate(lines[: mark.line]):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        while open_levels and open_levels[-1][0] >= _indent(line):
            open_levels.pop()
        open_levels.append((_indent(line), number))
    levels = [level for level, _ in open_levels]
    if own in levels or not levels or own > levels[-1]:
        return None
    # The key that is open between the levels around it: its own indentation may be what is wrong.
    outer = next((number for level, number in reversed(open_levels) if level < own), None)
    if outer is not None:
        found = _nameless(lines, outer, own)
        if found is not None:
            return found
    named = ", ".join(str(level) for level in levels)
    if any(_indent(line) == own and line.strip() for n, line in enumerate(lines) if n != mark.line):
        # Others are indented so, and one above them may be wrong.
        help = f"indent it by one of these, or check the indentation of line {(outer or 0) + 1}"
    else:
        lower = max((held for held in open_levels if held[0] < own), default=None)
        (deeper, beside) = min(held for held in open_levels if held[0] > own)
        help = f"indent it by {many(deeper, 'space')} as line {beside + 1}"
        if lower is not None:
            help += f", or by {lower[0]} as line {lower[1] + 1}"
    message = f"this line is indented by {many(own, 'space')}, and what is open above it by {named}"
    return Problem(message, help, _Mark(mark.line, own))


def _nameless(lines: list[str], header: int, own: int) -> Problem | None:
    """Fields that stand where a section has names, further in than the names further down.

    Args:
        lines: The file.
        header: Where the section begins.
        own: Indentation of the names.
    """
    from actspec.spec.shape import word_for

    first = next((n for n in range(header + 1, len(lines)) if _above(lines, n + 1) == n), None)
    if first is None or _indent(lines[first]) <= own:
        return None
    section, key = (_KEY.match(lines[n].strip()) for n in (header, first))
    word = None if section is None or key is None else word_for(section[1], key[1])
    if section is None or key is None or word is None:
        return None
    message = f"`{key[1]}` is a field of a {word}, and the line with the name of that {word} is missing above"
    help = f"write the name above this line, such as `{word}_1:`, indented by {many(own, 'space')}"
    return Problem(message, help, _Mark(first, _indent(lines[first])))


def _above(lines: list[str], number: int) -> int | None:
    """The last line above one that holds something."""
    for other in range(min(number, len(lines)) - 1, -1, -1):
        if lines[other].strip() and not lines[other].lstrip().startswith("#"):
            return other
    return None


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip(" "))
