"""The text of a spec: decoded, without what parsers or versions of YAML read differently."""

from __future__ import annotations

import re

from actspec.diagnostics import Collector, Span, shortened

BREAK = re.compile(r"\r\n|\r|\n")
# Named one by one: a set of what is allowed takes 20 times as long to compile, at every start.
_FORBIDDEN = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\u2028\u2029\ud800-\udfff\ufeff\ufffe\uffff]")


class Stop(Exception):
    """The text has no further meaning; what is wrong is in the collector."""


def text_of(data: bytes, path: str, collector: Collector) -> str:
    """Decode, and refuse what PyYAML's two parsers or YAML's two versions read differently."""
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        message = "the file is UTF-16, not UTF-8"
        collector.error("SPEC003", message, span=Span(path, 1, 1), help="save it as UTF-8")
        raise Stop
    data = data.removeprefix(b"\xef\xbb\xbf")
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError as err:
        span = place(data[: err.start].decode("utf-8"), path)
        message = f"the file is not UTF-8, got the byte 0x{data[err.start]:02x}"
        collector.error("SPEC003", message, span=span, help="save it as UTF-8")
        raise Stop from None
    bad = _FORBIDDEN.search(text)
    if bad is not None:
        message = f"the character U+{ord(bad[0]):04X} is not allowed"
        help = f"remove it; inside double quotes it can be written as an escape, \\u{ord(bad[0]):04x}"
        collector.error(
            "SPEC003",
            message,
            span=place(text[: bad.start()], path),
            help=help if ord(bad[0]) else "a text file has no NUL; is this another kind of file?",
        )
        raise Stop
    if "\t" in text:
        _refuse_tab(text, path, collector)
    for number, line in enumerate(BREAK.split(text), 1):
        if line.startswith("%"):
            if re.fullmatch(r"%YAML +1\.2 *(#.*)?", line):
                continue
            help = "remove it; the text is always read as YAML 1.2"
            message = f"the directive {got(line)} is not allowed"
            collector.error("SPEC008", message, span=Span(path, number, 1), help=help)
            raise Stop
        if line.strip() and not line.lstrip().startswith("#"):
            break
    return text


def _refuse_tab(text: str, path: str, collector: Collector) -> None:
    """Only comments may hold tabs: elsewhere their meaning differs from parser to parser."""
    for number, line in enumerate(BREAK.split(text), 1):
        tab = line.find("\t")
        comment = re.search(r"(?:^|\s)#", line)
        if tab >= 0 and (comment is None or tab <= comment.start()):
            help = "use spaces; inside double quotes write \\t"
            collector.error("SPEC003", "a tab is not allowed", span=Span(path, number, tab + 1), help=help)
            raise Stop


def place(before: str, path: str) -> Span:
    """The place just after the text `before`."""
    lines = BREAK.split(before)
    return Span(path, len(lines), len(lines[-1]) + 1)


def got(value: object) -> str:
    """A value for a message: quoted if it is text."""
    if value is None:
        return "null"
    if isinstance(value, bool):
        return str(value).lower()
    return f"'{cut(value)}'" if isinstance(value, str) else cut(str(value))


def cut(text: str) -> str:
    """Text of the file for a message."""
    return shortened(text, 80)
