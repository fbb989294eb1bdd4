"""The tokens of USD's text form, with their places."""

from __future__ import annotations

import re
from bisect import bisect_right
from dataclasses import dataclass

from actspec.diagnostics import Diagnostic, RobotError, Severity, Span, shortened

SYNTAX = "USDA001"
"""The text is not of the form, or of a version that is not known."""
NOT_READ = "USDA002"
"""USD has a meaning for it, and this reader does not."""
TOO_MUCH = "USDA003"
"""It is larger, or nested deeper, than any overlay."""

# Unrolled, so that no string makes the matching slow; a literal is of one line unless it has three quotes.
_STRINGS = r"""
    "{3}[^"\\]*(?:(?:\\.|"(?!""))[^"\\]*)*"{3} | '{3}[^'\\]*(?:(?:\\.|'(?!''))[^'\\]*)*'{3}
    | "(?!"")[^"\\\n]*(?:\\[^\n][^"\\\n]*)*" | '(?!'')[^'\\\n]*(?:\\[^\n][^'\\\n]*)*'
"""
_TOKEN = re.compile(
    rf"""
    (?P<gap>[ \t\r]+|\n|(?:\#|//)[^\n]*|/\*[^*]*\*+(?:[^/*][^*]*\*+)*/)
    | (?P<string>{_STRINGS})
    | (?P<asset>@@@(?:\\@@@|(?!@@@)[^\n])*@@@|@(?!@@)[^@\n]*@)
    | (?P<path><[^<>\n]+>)
    | (?P<number>-?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?(?![\w.])|-inf(?!\w))
    | (?P<word>[^\W\d]\w*(?:[:.]\w+)*)
    | (?P<mark>[()\[\]{{}}=,;:])
    """,
    re.VERBOSE | re.DOTALL,
)
_ESCAPE = re.compile(r"\\(?:x([0-9A-Fa-f]{1,2})|([0-7]{1,3})|(.))", re.DOTALL)
_LETTERS = {"a": "\a", "b": "\b", "f": "\f", "n": "\n", "r": "\r", "t": "\t", "v": "\v"}


@dataclass(frozen=True, slots=True)
class Token:
    """One token.

    Attributes:
        kind: `string`, `asset`, `path`, `number`, `word`, `mark`, or `end`.
        text: As written; of a string or an asset what is between its delimiters.
        start: Offset in the text.
        first: Whether it is the first of its line.
    """

    kind: str
    text: str
    start: int
    first: bool


class Scanner:
    """A text, token by token.

    Attributes:
        path: The file, for places.
        token: The one that comes next.
        head: Comments before the first token.
    """

    def __init__(self, text: str, path: str, start: int) -> None:
        self.path = path
        self._text = text
        self._lines = [0, *(match.end() for match in re.finditer("\n", text))]
        self._at = start
        self.head: list[str] = []
        self.token = Token("", "", start, True)
        self.token = self._scan()

    def next(self) -> Token:
        """The token, which is passed."""
        token = self.token
        self.token = self._scan()
        return token

    def at(self, *texts: str) -> bool:
        """Whether one of these marks or words comes next."""
        return self.token.kind in ("mark", "word") and self.token.text in texts

    def take(self, text: str) -> bool:
        """Pass a mark or word if it comes next."""
        found = self.at(text)
        if found:
            self.next()
        return found

    def expect(self, kind: str, what: str) -> Token:
        """Pass a token of a kind.

        Raises: RobotError: another one comes; `what` says what was wanted.
        """
        if self.token.kind != kind:
            raise self.unexpected(what)
        return self.next()

    def mark(self, text: str) -> Token:
        """Pass a mark; see `expect`."""
        if not self.at(text):
            raise self.unexpected(f"'{text}'")
        return self.next()

    def span(self, token: Token) -> Span:
        """Where a token is."""
        return self._span(token.start)

    def unexpected(self, wanted: str) -> RobotError:
        """The error of the token that comes next."""
        token = self.token
        got = "the end of the file" if token.kind == "end" else f"'{shortened(token.text)}'"
        return self.error(token, SYNTAX, f"{wanted} belongs here, got {got}")

    def error(self, token: Token, code: str, message: str, help: str | None = None) -> RobotError:
        """An error at a token."""
        return refusal(code, message, self.span(token), help)

    def _span(self, at: int) -> Span:
        line = bisect_right(self._lines, at)
        return Span(self.path, line, at - self._lines[line - 1] + 1)

    def _scan(self) -> Token:
        first = self.token.kind == ""
        while self._at < len(self._text):
            start = self._at
            match = _TOKEN.match(self._text, start)
            if match is None:
                raise refusal(SYNTAX, _unreadable(self._text[start]), self._span(start))
            self._at = match.end()
            kind, text = str(match.lastgroup), match[0]
            if kind != "gap":
                return Token(kind, _bare(kind, text), start, first)
            first = first or text == "\n"
            if text.startswith("#") and self.token.kind == "":
                self.head.append(text[1:].strip())
        return Token("end", "", self._at, True)


def refusal(code: str, message: str, span: Span, help: str | None = None) -> RobotError:
    """The error of a layer that is not read."""
    return RobotError([Diagnostic(code, Severity.ERROR, message, "", span, help)])


def _unreadable(character: str) -> str:
    quotes = {'"': "a string that does not end", "'": "a string that does not end"}
    others = {
        "@": "an asset path that does not end",
        "<": "a path that does not end",
        "/": "a remark that does not end",
    }
    return (quotes | others).get(character) or f"{character!r} belongs to no word of USD"


def _bare(kind: str, text: str) -> str:
    if kind == "asset":
        return text[3:-3].replace(r"\@@@", "@@@") if text.startswith("@@@") else text[1:-1]
    if kind == "path":
        return text[1:-1]
    if kind != "string":
        return text
    size = 3 if text[:3] in ('"""', "'''") else 1
    return _ESCAPE.sub(_unescaped, text[size:-size])


def _unescaped(match: re.Match[str]) -> str:
    hexadecimal, octal, letter = match.groups()
    if hexadecimal or octal:
        return chr(int(hexadecimal, 16) if hexadecimal else int(octal, 8) & 255)
    return _LETTERS.get(letter, letter)
