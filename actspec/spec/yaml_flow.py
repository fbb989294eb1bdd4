"""What is wrong with brackets, braces and quotes: one that opens or closes nothing, a missing comma, an open text."""

from __future__ import annotations

import re
from typing import Any

from actspec.spec.yaml_lines import (
    CLOSES,
    COMMENT,
    EQUALS,
    KEY,
    NAME,
    NO_SPACE,
    OPENS,
    Mark,
    Problem,
    indent,
    lacks_colon,
    no_colon,
)
from actspec.spec.yaml_text import cut

_BEFORE_BRACKET = re.compile(rf"({NAME})\s+([\[{{].*)")
_BEHIND_QUOTE = re.compile(r"""("[^"]*"|'[^']*')\s+([^:\s].*)""")
_LIST_VALUE = re.compile(r"([A-Za-z_][A-Za-z_0-9-]*): +([^\[\]{}]+)$")
_WORD = re.compile(r""""[^"]*"|'[^']*'|[^\s,:\[\]{}]+""")
_IN_TEXT = re.compile(r"""[{,]\s*(note|title):\s+(?=[^\s"'\[\]{},])(?=[^\[\]{},]*$)""")
"""A text in { } that stands open at the end."""
_NOT_CLOSED = re.compile(r"""(["'])([^"']*),\s*\1$""")
"""A text in quotes with a comma at its end, as far as to the quote that should open the next one."""
_LIST_KEY = re.compile(r"(?:- +)?(\[[^\[\],{}\s]*\][^\s,{}]+?)\s*:(?:\s|$)")
"""A joint pattern that begins with `[`, as a key."""
_EQUALS = re.compile(rf"({NAME})\s*=\s*$")
_END_OF_TEXT = re.compile(rf"\s*(?:\}}|,\s*(?:{NAME}):\s)")


def brackets(lines: list[str], mark: Any) -> Problem | None:
    """A quote that ends on another line, a key before a bracket, or a bracket that closes nothing, at a place.

    Args:
        lines: The file.
        mark: Where the parser stopped.
    """
    opened: list[str] = []
    closed = False
    quote: tuple[str, int, int, str] | None = None
    for number, line in enumerate(lines[: mark.line + 1]):
        here = number == mark.line
        if here and not opened and quote is None:
            text = COMMENT.sub("", line.strip())
            equals = EQUALS.fullmatch(text)
            if equals is not None and equals[2][0] in OPENS:
                return no_colon(text, Mark(number, indent(line)))
            for form in (_BEFORE_BRACKET, _BEHIND_QUOTE):
                found = lacks_colon(line, number, form)
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
                quote = char, number, column, "".join(opened[-1:])
            elif char in OPENS and (begins or opened):
                opened.append(char)
            elif (
                char == "]"
                and opened[-1:] == ["{"]
                and here
                and (begun := _LIST_VALUE.search(line[max(0, column - 200) : column]))
            ):
                help = f"write `{begun[1]}: [{cut(begun[2])}]`"
                return Problem("this list lacks its `[`", help, Mark(number, column - len(begun[2])))
            elif char in CLOSES and opened:
                opened.pop()
                closed = True
            elif char in CLOSES and here:
                return _closes_nothing(line, Mark(number, column), closed)
            elif char == "#" and line[column - 1] == " ":
                break
            if char != " ":
                before = char
    return None


def _not_closed(lines: list[str], quote: tuple[str, int, int, str]) -> Problem:
    """What to write for a text that begins with a quote, at a line and column, in a `[`, a `{` or none of them."""
    char, number, column, inside = quote
    text = COMMENT.sub("", lines[number][column + 1 :])
    is_value = lines[number][:column].rstrip().endswith(":")
    ends = r"[\],}]|: "
    if is_value and inside != "[":
        # A comma in braces ends a value where a key follows.
        ends = _END_OF_TEXT.pattern if inside else r"\s*$"
    word = re.split(ends, text)[0].rstrip("\u201c\u201d\u00bb\u2019")
    return Problem(
        "this quote is not closed on its line", f"write `{char}{cut(word)}{char}`", Mark(number, column)
    )


def _closes_nothing(line: str, mark: Mark, closed: bool) -> Problem:
    """A `]` or `}` without the one that opens.

    Args:
        line: Where it stands.
        mark: Its place.
        closed: Whether another that was open is closed on this line.
    """
    end = line[mark.column]
    glued = NO_SPACE.fullmatch(line.strip())
    if (glued is not None and glued[2][0] in OPENS) or line.strip()[:2] in ("-[", "-{"):
        # `delay:{nominal: 4 ms}` and `-{ratio: 5}` begin no mapping.
        return no_colon(line.strip(), Mark(mark.line, indent(line))) or _end_without_begin(end, mark)
    key = KEY.match(line.strip())
    if closed or key is None:
        return _end_without_begin(end, mark)
    begin = next(char for char, other in OPENS.items() if other == end)
    value = line[indent(line) + key.end() : mark.column + 1].strip()
    help = f"write `{cut(f'{key[1]}: {begin}{value}')}`"
    return Problem(f"this {CLOSES[end]} lacks its `{begin}`", help, Mark(mark.line, line.index(value)))


def _end_without_begin(end: str, mark: Mark) -> Problem:
    return Problem(f"this `{end}` closes nothing", "remove it", mark)


def no_comma(lines: list[str], mark: Any, kind: str, end: str) -> Problem | None:
    """An item of a list or mapping that stands behind another on its line without a comma."""
    line = lines[mark.line] if mark.line < len(lines) else ""
    at = line[mark.column : mark.column + 1]
    if at in CLOSES:
        return Problem(f"this {kind} ends with `{at}`", f"close it with `{end}`", mark)
    equals = _EQUALS.search(line, 0, mark.column)
    if at in OPENS and equals is not None:
        rest = line[mark.column :].partition(OPENS[at])[0] + OPENS[at]
        message = f"`{equals[1]}` has `=` in place of `:`"
        return Problem(message, f"write `{equals[1]}: {cut(rest)}`", Mark(mark.line, equals.start(1)))
    if at == ":":
        word = next((m for m in _WORD.finditer(line) if m.end() == len(line[: mark.column].rstrip())), None)
    else:
        word = _WORD.match(line, mark.column)
    if word is None or word.start() == indent(line):
        return None
    text = _IN_TEXT.search(line, 0, word.end())
    if at == ":" and text is not None:
        rest = _END_OF_TEXT.split(line[text.end() :], maxsplit=1)[0].rstrip()
        help = f'put it into quotes: {text[1]}: "{cut(rest)}"' if '"' not in rest else "quote the text"
        return Problem("the `: ` inside this text begins a mapping", help, Mark(mark.line, mark.column))
    return Problem(f"a `,` is missing before `{cut(word[0])}`", None, Mark(mark.line, word.start()))


def open_quote(line: str, mark: Any) -> Problem | None:
    """A text of [ ] or { } without its second quote, `"a, "b"`, where the parser stands behind the next one's first."""
    found = _NOT_CLOSED.search(line[: mark.column])
    if found is None or line[mark.column :][:1] in ("", " ", ":"):
        return None
    help = f"write `{found[1]}{cut(found[2].partition(',')[0])}{found[1]}`"
    return Problem("this quote is not closed before the `,`", help, Mark(mark.line, found.start()))


def in_comment(lines: list[str], start: Any, mark: Any, kind: str, end: str) -> Problem | None:
    """The end of a list or mapping that stands behind a `#`.

    Args:
        lines: The file.
        start: Where the list or mapping begins.
        mark: Where the parser stopped; None: unknown.
        kind: Which of the two it is.
        end: What closes it.
    """
    begin = next(char for char, other in OPENS.items() if other == end)
    for number in range(start.line, min(len(lines), start.line + 1 if mark is None else mark.line + 1)):
        line = lines[number]
        comment = COMMENT.search(line)
        before = "" if comment is None else line[: comment.start()]
        more = comment is not None and comment[0].count(end) > comment[0].count(begin)
        if more and before.count('"') % 2 == before.count("'") % 2 == 0:
            message = f"the `{end}` of this {kind} stands in a comment, which begins with the `#`"
            return Problem(
                message, f"write the `{end}` before the `#`", Mark(number, line.index("#", len(before)))
            )
    return None


def list_as_key(lines: list[str], mark: Any) -> Problem | None:
    """A key such as `[FR]L_hip:`, of which YAML takes the beginning for a list."""
    line = lines[mark.line] if mark is not None and mark.line < len(lines) else ""
    key = _LIST_KEY.match(line.lstrip())
    if key is None:
        return None
    message = "a key that begins with `[` is a list to YAML, and no pattern"
    return Problem(message, f'write `"{cut(key[1])}":`', Mark(mark.line, line.index(key[1])))


def bound(sign: str, rest: str, before: str) -> str | None:
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


def folded(line: str, start: Any) -> Problem:
    """`> 60 Hz`, of which the `>` begins a text of several lines."""
    sign, value = line[start.column], COMMENT.sub("", line[start.column :]).strip()
    number = value.lstrip(">|= ")
    help = "quote it, if it is text"
    if number[:1].isdigit():
        help = f'a bound stands in a note: write `{{value: {cut(number)}, note: "{cut(value)}"}}`'
    return Problem(
        f"`{sign}` begins a text of several lines, and `{cut(value)}` goes on behind it", help, start
    )
