"""Changes of a file by its structure: what has a name or a value in it is replaced, doubled, moved, nested or left out.

Each format only says where its parts are (`parts`). All edits are edits of text at those places, so that comments
and layout stay, and one set of edits serves YAML, JSON, XML, Python, TOML, CSV and USD.
"""

from __future__ import annotations

import ast
import json
import random
import re
from collections.abc import Callable, Iterator
from functools import lru_cache

import yaml

Span = tuple[int, int]

MARKER = "pwned"
"""The name in everything that is meant to become code: what is written must not have it as a name."""

_NUMBERS = (
    *(
        "nan",
        "inf",
        "-inf",
        ".nan",
        ".inf",
        "1e400",
        "-1",
        "0",
        "-0.0",
        "1e-320",
        "1e200",
        "9" * 5000,
        "0x1F",
    ),
    *("1_000", "1e", "--1", "1 N*m", "1 rad", "1 kg", "1e309 N*m", "nan N*m/rad", "5 ms", "1 N*m/rad^99999"),
    *("50 %", "1/0", "2**9999", "1 N**m", "1 N*m*s/rad", "1 ms..2 ms", "true", "1,5", "٣", "1 μs", "1e-9 Hz"),
)
_TEXTS = (
    *(
        "",
        " ",
        "~",
        "null",
        "unknown",
        "identified",
        "none",
        "''",
        '""',
        "x" * 100_000,
        "\x1b[31m",
        "\x00",
        "\x7f",
    ),
    *(
        "\x85",
        "\u2028",
        "\u202e",
        "\ufeff",
        "é",
        "\U0001f916",
        "a\nb",
        "a\r\nb",
        "a\tb",
        "\\",
        "\\u0000",
        "'",
        '"',
    ),
    *(
        "{{ 7*7 }}",
        "{% raw %}",
        "${HOME}",
        "%s%n",
        "`id`",
        "$(id)",
        "#",
        "-->",
        "<!--",
        "]]>",
        "&lt;",
        "&x;",
        "--",
    ),
    *(
        f"__import__('os').system('{MARKER}')",
        f"'); {MARKER}(); ('",
        f'"""\n{MARKER}()\n"""',
        f"\n{MARKER}()\n",
    ),
    *(f"x\\\n{MARKER}()", f"'+{MARKER}()+'", f"\r{MARKER}()", f"\u2028{MARKER}()", f"{{{MARKER}()}}", MARKER),
    *(
        ".*",
        "(a+)+$",
        "(" * 500,
        "[",
        "a{9999}",
        "(?P<x>",
        "\\1",
        "^(?=.*a)",
        "a|b",
        ".*" * 50,
        "hip",
        "knee",
    ),
    *(
        "../../../etc/hostname",
        "/etc/hostname",
        "/dev/zero",
        "//x/y",
        "C:\\x",
        "file:///etc/hostname",
        "x/" * 3000,
    ),
    *("http://localhost:1/x", "CON", "con.yaml", ".", "..", "plain.yaml", "#", "x#y", "-o", "\udcff"),
)
_STRUCTURES = {
    "yaml": (
        *("[]", "{}", "[[]]", "{a: b}", "[1, 2, 3]", "[nan]", "&a [*a]", "*nothing", "&a {<<: *a}", "<<: *a"),
        *(
            "!!python/object/apply:os.system [pwned]",
            "!!binary aGk=",
            "!!set {a}",
            "!!timestamp 2020-01-01",
            "!x 1",
        ),
        *(
            "!!float x",
            "!!int x",
            "2026-11-21",
            "? [a]\n: b",
            "|\n  text",
            ">-\n text",
            "@x",
            "%YAML 1.1",
            "---",
            "...",
        ),
        "&a [1,2,3,4,5,6,7,8,9]\nb: &b [*a,*a,*a,*a,*a,*a,*a,*a]\nc: [*b,*b,*b,*b,*b,*b,*b,*b]",
    ),
    "json": (
        "[]",
        "{}",
        "[[]]",
        '{"a": 1}',
        "null",
        "true",
        "NaN",
        "Infinity",
        "-1",
        "1e400",
        '"\\ud800"',
        "[1,2]",
    ),
    "xml": (
        *(
            "<!-- -->",
            "<![CDATA[x]]>",
            "<?x y?>",
            "<x/>",
            "<joint name='hip'/>",
            "<include file='biped.xml'/>",
        ),
        *("<default><default/></default>", "<frame/>", "<replicate count='3'/>", "&x;", "&#0;", "&#x110000;"),
        *(
            "<worldbody/>",
            "<attach model='a' body='b' prefix='c'/>",
            "<option timestep='nan'/>",
            "<key qpos='1'/>",
        ),
        *(
            "<equality><joint joint1='hip' joint2='hip'/></equality>",
            "<mimic joint='hip'/>",
            "<x xmlns='y'/>",
        ),
    ),
    "python": (
        *(
            "[]",
            "{}",
            "()",
            "None",
            "...",
            "lambda: 0",
            "[x for x in y]",
            "f'{x}'",
            "f'{x!r:>{y}}'",
            "x := 1",
            "*x",
        ),
        *(
            "2 ** 10 ** 10",
            "'a' * 10 ** 10",
            "1 << 10 ** 9",
            "{**x}",
            "x[0]",
            "x.y.z",
            "dict(a=1)",
            "-(-(-1))",
        ),
        *(
            "__import__('os').system('pwned')",
            "open('/tmp/pwned', 'w')",
            "1j",
            "b'x'",
            "1 if x else 2",
            "not x",
        ),
        *(
            "(" * 300 + ")" * 300,
            "await x",
            "yield",
            "'\\ud800'",
            "0.1.real",
            "float('nan')",
            "1e400",
            "ord('a')",
        ),
        *(
            "math.inf",
            "dict([(1, 2)])",
            "range(10**12)",
            "[0] * 10**9",
            "'%s' % ('a' * 9,)",
            "x = y = 1",
            "del x",
        ),
    ),
    "toml": (
        "[]",
        "{}",
        "[[1]]",
        "{a = 1}",
        "true",
        "nan",
        "inf",
        "-1",
        "1e400",
        "1979-05-27",
        '"""x',
        "'''\n'''",
    ),
    "csv": (
        "",
        ",",
        ";",
        "nan",
        "1e400",
        "1e300",
        "inf",
        '"',
        '"a\nb"',
        "x" * 200_000,
        "0x1",
        "1;2",
        "\x00",
        "time",
    ),
    "usda": (
        "[]",
        "()",
        "{}",
        "None",
        "nan",
        "1e400",
        '"""',
        "@/etc/hostname@",
        "@./x.usda@",
        "</a/b>",
        "#",
        "def X",
    ),
}
_PROLOGUES = {
    "xml": (
        '<!DOCTYPE x [<!ENTITY x SYSTEM "file:///etc/hostname">]>',
        '<!DOCTYPE x [<!ENTITY a "aaaaaaaaaa"><!ENTITY x "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">]>',
        '<?xml version="1.0" encoding="UTF-7"?>',
        '<?xml version="1.1"?>',
        '<?xml version="1.0" encoding="nothing"?>',
        '<!DOCTYPE x SYSTEM "http://localhost:1/x.dtd">',
    ),
    "yaml": ("%YAML 1.1\n---\n", "%TAG ! tag:x,2000:\n---\n", "--- !!set\n", "a: 1\n---\n", "&x\n", "\t"),
    "python": (
        "# -*- coding: utf-7 -*-\n",
        "# coding: nothing\n",
        "from x import *\n",
        "import os; os.x\n",
        "if x:\n",
    ),
    "usda": ("#usda 9.9\n", "#usda 1.0\n(subLayers = [@/etc/hostname@])\n", "PK\x03\x04"),
}
_UNIT = re.compile(r"(?<=[\d.] )[A-Za-z%][\w*/^%]*")
_NUMBER = re.compile(r"(?<![\w.])[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?(?![\w.])", re.IGNORECASE)


def mutated(text: str, donor: str, kind: str, choice: random.Random, *, gently: bool = False) -> bytes:
    """The text with one to four changes.

    Args:
        donor: Another text of the format, to take parts from.
        kind: "yaml", "json", "xml", "python", "toml", "csv" or "usda".
        gently: Only changes after which a text often has a meaning still, so that what comes later is reached.
    """
    if gently:
        span = choice.choice(parts(text, kind))
        new = choice.choice(_GENTLE)(text, span, donor, kind, choice)
        return (text[: span[0]] + new + text[span[1] :]).encode("utf-8", "surrogatepass")
    edits: list[tuple[Span, str]] = []
    spans = parts(text, kind)
    for _ in range(choice.choice((1, 1, 1, 2, 2, 3, 4))):
        if spans:
            span = choice.choice(spans)
            edits.append((span, choice.choice(_EDITS)(text, span, donor, kind, choice)))
    end = len(text) + 1
    for (start, stop), new in sorted(edits, key=lambda edit: edit[0], reverse=True):
        if stop <= end:  # else it is inside of what another edit has changed
            text, end = text[:start] + new + text[stop:], start
    if choice.random() < 0.05 and kind in _PROLOGUES:
        text = choice.choice(_PROLOGUES[kind]) + text
    data = text.encode("utf-8", "surrogatepass")
    return _damaged(data, choice) if choice.random() < 0.1 else data


@lru_cache(maxsize=2048)
def parts(text: str, kind: str) -> tuple[Span, ...]:
    """Where the keys, values, elements and attributes of a sound text are, and every number and unit."""
    found = set(_PARTS[kind](text))
    found.update(match.span() for match in _NUMBER.finditer(text))
    found.update(match.span() for match in _UNIT.finditer(text))
    return tuple(sorted(span for span in found if span[0] < span[1]))


def _yaml(text: str) -> Iterator[Span]:
    todo = [yaml.compose(text)]
    while todo:
        node = todo.pop()
        yield node.start_mark.index, node.end_mark.index
        if isinstance(node, yaml.MappingNode):
            for key, value in node.value:
                yield key.start_mark.index, value.end_mark.index
                todo += key, value
        elif isinstance(node, yaml.SequenceNode):
            todo += node.value


_TAG = re.compile(r"<(/?)([\w:]+)((?:\s+[\w:]+=(?:\"[^\"]*\"|'[^']*'))*)\s*(/?)>")
_ATTRIBUTE = re.compile(r"\s+([\w:]+)=[\"']([^\"']*)[\"']")


def _xml(text: str) -> Iterator[Span]:
    opened = []
    for tag in _TAG.finditer(text):
        closes, _, _, empty = tag.groups()
        if closes:
            yield opened.pop(), tag.end()
        elif empty:
            yield tag.span()
        else:
            opened.append(tag.start())
        yield tag.span(2)
        for attribute in _ATTRIBUTE.finditer(text, tag.start(3), tag.end(3)):
            yield from (attribute.span(), attribute.span(1), attribute.span(2))


def _python(text: str) -> Iterator[Span]:
    # ast counts bytes; the seeds are ASCII, so bytes are characters.
    lines = [0, *(match.end() for match in re.finditer("\n", text))]
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.expr | ast.stmt | ast.keyword) and node.end_lineno and node.end_col_offset:
            yield lines[node.lineno - 1] + node.col_offset, lines[node.end_lineno - 1] + node.end_col_offset


def _words(pattern: str) -> Callable[[str], Iterator[Span]]:
    return lambda text: (match.span() for match in re.finditer(pattern, text, re.MULTILINE))


_PARTS: dict[str, Callable[[str], Iterator[Span]]] = {
    "yaml": _yaml,
    "json": _yaml,
    "xml": _xml,
    "python": _python,
    "toml": _words(r"^.+\n|(?<== ).+$|[\w.-]+|\"[^\"\n]*\"|\[.*\]"),
    "csv": _words(r"^.*\n|[^,\n]+"),
    "usda": _words(r"^.*\n|\"[^\"\n]*\"|[\w:]+|(?<== ).+$|[({\[][^(){}\[\]]*[)}\]]"),
}

_Edit = Callable[[str, Span, str, str, random.Random], str]


def _hostile(text: str, span: Span, donor: str, kind: str, choice: random.Random) -> str:
    new = choice.choice(choice.choice((_NUMBERS, _TEXTS, _STRUCTURES[kind])))
    how = choice.random()
    if how < 0.4:
        return json.dumps(new)
    if how < 0.5 and kind == "xml":
        return new.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
    if how < 0.5 and kind == "python":
        return repr(new)
    if how < 0.6:
        # Inside of the quotes that are there.
        old = text[slice(*span)]
        return (
            old[0] + new + old[-1]
            if old[0] in "\"'[{("
            else old[: len(old) // 2] + new + old[len(old) // 2 :]
        )
    return new


def _number(text: str, span: Span, donor: str, kind: str, choice: random.Random) -> str:
    """Another number or unit in the same words."""
    old = text[slice(*span)]
    if choice.random() < 0.3:
        units = ("N*m", "rad", "kg*m^2", "ms", "Hz", "N*m/rad", "deg", "%", "x")
        return _UNIT.sub(lambda _: choice.choice(units), old)
    factors = ("0", "-", "1e9", "1e-9", "e300", "e-300", "0000", ".", "e5")
    return _NUMBER.sub(lambda match: match[0] + choice.choice(factors), old, count=choice.choice((1, 1, 0)))


def _nested(text: str, span: Span, donor: str, kind: str, choice: random.Random) -> str:
    deep = choice.choice((1, 2, 30, 120, 3000))
    old = text[slice(*span)]
    if kind == "xml":
        return "<body>" * deep + old + "</body>" * deep
    opening, closing = choice.choice(("[]", "()") if kind in ("python", "usda") else ("[]", ("{a: ", "}")))
    return opening * deep + old + closing * deep


def _doubled(text: str, span: Span, donor: str, kind: str, choice: random.Random) -> str:
    old = text[slice(*span)]
    column = span[0] - (text.rfind("\n", 0, span[0]) + 1)
    between = choice.choice(("", " ", ", ", "\n" + " " * column))
    return between.join([old] * choice.choice((2, 2, 2, 3, 500)))


def _other(text: str, span: Span, donor: str, kind: str, choice: random.Random) -> str:
    """A part of this text, or of the other one."""
    source = choice.choice((text, donor))
    spans = parts(source, kind)
    return source[slice(*choice.choice(spans))] if spans else ""


def _merged(text: str, span: Span, donor: str, kind: str, choice: random.Random) -> str:
    return text[slice(*span)] + choice.choice(("\n", "", ", ")) + _other(text, span, donor, kind, choice)


def _left_out(text: str, span: Span, donor: str, kind: str, choice: random.Random) -> str:
    return ""


_EDITS: tuple[_Edit, ...] = (
    _hostile,
    _hostile,
    _hostile,
    _number,
    _nested,
    _doubled,
    _other,
    _merged,
    _left_out,
)
_GENTLE: tuple[_Edit, ...] = (_number, _number, _other, _left_out)


def _damaged(data: bytes, choice: random.Random) -> bytes:
    """Bytes cut off, changed or put in."""
    at = choice.randrange(len(data) + 1)
    how = choice.randrange(4)
    if how == 0:
        return data[:at]
    if how == 1:
        return data[:at] + bytes([choice.randrange(256)]) + data[at + 1 :]
    if how == 2:
        return (
            data[:at] + choice.choice((b"\x00", b"\xff", b"\xed\xa0\x80", b"\r", b"\xef\xbb\xbf")) + data[at:]
        )
    return choice.choice((data.decode("utf-8", "replace").encode("utf-16"), data + b"\n" + data, b""))
