"""Reading of a spec's text: values, places, includes, limits; by libyaml's parser and by the pure one."""

from __future__ import annotations

import hashlib
import os
from pathlib import Path
from typing import Any

import pytest
import yaml

from actspec.diagnostics import Diagnostic, Span, SpecError
from actspec.spec.document import (
    MAX_ALIASES,
    MAX_BYTES,
    MAX_DEPTH,
    MAX_ERRORS,
    MAX_INCLUDES,
    MAX_NODES,
    document_from_text,
    load_document,
)

LIBYAML = hasattr(yaml, "CSafeLoader")


@pytest.fixture(params=["libyaml", "pure"], autouse=True)
def parser(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every test holds for a PyYAML with libyaml and for one without it."""
    if request.param == "pure":
        monkeypatch.delattr(yaml, "CSafeLoader", raising=False)
    elif not LIBYAML:
        pytest.skip("this PyYAML has no libyaml")


def errors(text: str | bytes) -> tuple[Diagnostic, ...]:
    """The diagnostics of a text that is not valid."""
    with pytest.raises(SpecError) as caught:
        document_from_text(text, "s.yaml")
    return caught.value.diagnostics


def said(text: str | bytes) -> list[str]:
    """The same as `code line:col message`."""
    return [f"{d.code} {d.span.line}:{d.span.column} {d.message}" for d in errors(text) if d.span]


# --- values --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("written", "value"),
    [
        ("1e-3", 0.001),
        ("1E3", 1000.0),
        ("+1.5e+2", 150.0),
        ("-.5", -0.5),
        ("1.", 1.0),
        ("0.0", 0.0),
        ("010", 10),
        ("-08", -8),
        ("+12", 12),
        ("0", 0),
        ("0o17", 15),
        ("0x1F", 31),
        ("0xfF", 255),
        ("9007199254740993", 9007199254740993),
        ("on", "on"),
        ("off", "off"),
        ("yes", "yes"),
        ("No", "No"),
        ("y", "y"),
        ("true", True),
        ("True", True),
        ("FALSE", False),
        ("tRUE", "tRUE"),
        ("12:30", "12:30"),
        ("1:2:3.5", "1:2:3.5"),
        ("~", None),
        ("null", None),
        ("NULL", None),
        ("", None),
        ("nUll", "nUll"),
        ("none", "none"),
        ("2026-11-21", "2026-11-21"),
        ("2026-11-21T10:00:00Z", "2026-11-21T10:00:00Z"),
        ("1_000", "1_000"),
        ("0b11", "0b11"),
        ("0o18", "0o18"),
        ("-0o7", "-0o7"),
        ("-0x1F", "-0x1F"),
        ("1e", "1e"),
        ("e5", "e5"),
        (".", "."),
        ("-", [None]),
        ("+", "+"),
        ("inf", "inf"),
        ("nan", "nan"),
        ("\u0661", "\u0661"),  # an Arabic digit one, which int() would read
        ("1\u0661", "1\u0661"),
        ("=", "="),
        ("<<", "<<"),
        ("25 N*m/rad", "25 N*m/rad"),
        ("'10'", "10"),
        ('"~"', "~"),
        ("''", ""),
        ("!!str 10", "10"),
        ("!!float 1", 1.0),
        ("!!int '0x10'", 16),
        ("!!null ''", None),
        ("!!bool 'true'", True),
        ("!!seq [1]", [1]),
        ("!!map {a: 1}", {"a": 1}),
        ("a#b", "a#b"),
        ("a # b", "a"),
        (".*_hip_joint", ".*_hip_joint"),
        ("'.*\\d'", ".*\\d"),
    ],
    ids=lambda value: repr(value),
)
def test_a_scalar_reads_as_yaml_1_2_has_it(written: str, value: Any) -> None:
    """Value and type, for both are the meaning: 10 is not 10.0 and True is not 1."""
    read = document_from_text(f"k:\n {written}").data["k"]
    assert (read, type(read)) == (value, type(value))
    if not isinstance(value, list) and written != "":
        flow = document_from_text(f"k: [\n {written}\n ]").data["k"]
        assert (flow[0], type(flow[0])) == (value, type(value))


@pytest.mark.parametrize(
    "written",
    [".inf", "-.Inf", "+.INF", ".nan", ".NaN", "1e999", "-1e999", "9" * 310, "9" * 5000, "0x" + "f" * 300],
)
def test_a_number_must_be_finite(written: str) -> None:
    """No quantity of a spec is infinite, and a very long number costs no quadratic conversion."""
    shown = written if len(written) <= 80 else written[:77] + "..."
    assert errors(f"a: {{kp: {written}}}") == (
        Diagnostic(
            "SPEC016",
            errors("a: .inf")[0].severity,
            f"must be a finite number, got {shown}",
            "a.kp",
            Span("s.yaml", 1, 9),
            "for a figure that nobody states write `unknown`; for a word, quote it",
        ),
    )


def test_block_texts_and_folded_texts_are_read() -> None:
    """Notes may span lines."""
    text = "a: |\n  x\n   y\nb: >\n  x\n  y\nc: x\n  y\nd: 'it''s'\ne: \"\\u00b5\\t\"\n"
    assert document_from_text(text).data == {
        "a": "x\n y\n",
        "b": "x y\n",
        "c": "x y",
        "d": "it's",
        "e": "\u00b5\t",
    }


def test_byte_order_mark_crlf_and_directive_are_accepted() -> None:
    """A file of a Windows editor reads as any other, and the mark takes no column."""
    document = document_from_text(b"\xef\xbb\xbf%YAML 1.2\r\n---\r\na: 1\r\nb:\r\n  c: x\r\n")
    assert document.data == {"a": 1, "b": {"c": "x"}}
    assert document.spans.value(("b", "c")) == Span("<text>", 5, 6)
    assert document_from_text("\ufeffa: 1").spans.key(("a",)) == Span("<text>", 1, 1)


def test_an_alias_is_a_copy() -> None:
    """Who changes one of the two does not change the other."""
    data = document_from_text("a: &x {k: [1]}\nb: *x\n").data
    assert data == {"a": {"k": [1]}, "b": {"k": [1]}}
    data["b"]["k"].append(2)
    assert data["a"] == {"k": [1]}


def test_an_anchor_written_again_holds_from_there_on() -> None:
    """YAML: an alias is the last anchor of that name above it."""
    assert document_from_text("a: &x 1\nb: *x\nc: &x 2\nd: *x\n").data == {"a": 1, "b": 1, "c": 2, "d": 2}


def test_a_key_may_be_quoted_to_be_text() -> None:
    """A joint pattern that looks like a number, and the two characters << as a name."""
    assert document_from_text("'12': 1\n\"<<\": 2\n'true': 3\non: 4\n").data == {
        "12": 1,
        "<<": 2,
        "true": 3,
        "on": 4,
    }


def test_two_loads_are_equal_and_the_hash_is_that_of_the_bytes() -> None:
    """Without includes `sha256sum` of the file gives the same."""
    text = b"\xef\xbb\xbfa: \xc2\xb5 # x\n"
    document = document_from_text(text, "x.yaml")
    assert document.text_sha256 == hashlib.sha256(text).hexdigest()
    assert (document.path, document.includes) == ("x.yaml", ())


# --- places --------------------------------------------------------------------------------------

PLACES = """\
# comment
actuators:
  legs:
    joints:
      - FL
      -   [a, {b: c}]
    kp: 25
    'kd' : {value: 1, note: "x"}
    empty:
timing: {physics_dt: 5 ms,
  decimation: 4}
µ: &m {k: 1}
again: *m
"""


@pytest.mark.parametrize(
    ("path", "key", "value"),
    [
        ((), (2, 1), (2, 1)),
        (("actuators",), (2, 1), (3, 3)),
        (("actuators", "legs"), (3, 3), (4, 5)),
        (("actuators", "legs", "joints"), (4, 5), (5, 7)),
        (("actuators", "legs", "joints", 0), (5, 9), (5, 9)),
        (("actuators", "legs", "joints", 1), (6, 11), (6, 11)),
        (("actuators", "legs", "joints", 1, 0), (6, 12), (6, 12)),
        (("actuators", "legs", "joints", 1, 1, "b"), (6, 16), (6, 19)),
        (("actuators", "legs", "kp"), (7, 5), (7, 9)),
        (("actuators", "legs", "kd"), (8, 5), (8, 12)),
        (("actuators", "legs", "kd", "note"), (8, 23), (8, 29)),
        (("actuators", "legs", "empty"), (9, 5), (9, 11)),
        (("timing", "decimation"), (11, 3), (11, 15)),
        (("µ", "k"), (12, 8), (12, 11)),
        (("again",), (13, 1), (13, 8)),
        (("again", "k"), (12, 8), (12, 11)),
    ],
    ids=str,
)
def test_key_and_value_have_their_place(
    path: tuple[str | int, ...], key: tuple[int, int], value: tuple[int, int]
) -> None:
    """Line and column from 1, counted by hand in the text above; columns count characters, not bytes."""
    spans = document_from_text(PLACES, "p.yaml").spans
    assert spans.key(path) == Span("p.yaml", *key)
    assert spans.value(path) == Span("p.yaml", *value)


@pytest.mark.parametrize(
    ("path", "nearest"),
    [
        (("actuators", "legs", "delay"), ("actuators", "legs")),
        (("actuators", "legs", "joints", 7), ("actuators", "legs", "joints")),
        (("actuators", "legs", "joints", -1), ("actuators", "legs", "joints")),
        (("actuators", "legs", "joints", True), ("actuators", "legs", "joints")),
        (
            ("actuators", "legs", "Quantity", "kd", "function-after[f(), str]", "note"),
            ("actuators", "legs", "kd", "note"),
        ),
        (("actuators", 0, "legs", "kp", "float"), ("actuators", "legs", "kp")),
        (("nowhere", "at", "all"), ()),
    ],
    ids=str,
)
def test_a_path_without_a_node_falls_back(
    path: tuple[str | int, ...], nearest: tuple[str | int, ...]
) -> None:
    """Union tags of pydantic and missing keys are passed over."""
    spans = document_from_text(PLACES).spans
    assert (spans.key(path), spans.value(path)) == (spans.key(nearest), spans.value(nearest))


def test_a_missing_value_at_the_end_of_a_text_has_its_place() -> None:
    """No place lies behind the end of the text, which libyaml calls the next line."""
    assert document_from_text("? kp").spans.value(("kp",)) == Span("<text>", 1, 5)
    assert document_from_text("? kp\n").spans.value(("kp",)) == Span("<text>", 2, 1)


# --- what is refused in the text -----------------------------------------------------------------


def test_all_errors_of_a_file_are_told_at_once() -> None:
    """Keys, merge keys, tags, numbers and the syntax error that ends the reading, in order of place."""
    text = "a: 1\na: 2\nb: {x: 1, 'x': 2}\n<<: *q\n"
    assert said(
        "q: &q {z: 1}\n" + text + "12: x\n~: x\nc: !!python/object/apply:os.system [x]\nd: !foo x\ne: a: b\n"
    ) == [
        "SPEC006 3:1 the key 'a' is repeated, first at s.yaml:2:1",
        "SPEC006 4:11 the key 'x' is repeated, first at s.yaml:4:5",
        "SPEC007 5:1 the merge key << is not allowed",
        "SPEC009 6:1 the key 12 reads as a number, and keys are text",
        "SPEC009 7:1 the key null reads as nothing, and keys are text",
        "SPEC008 8:4 the tag !!python/object/apply:os.system is not allowed",
        "SPEC008 9:4 the tag !foo is not allowed",
        "SPEC004 10:5 the `: ` inside this text begins a mapping",
    ]


def test_spaces_of_other_kinds_stand_in_texts() -> None:
    """What looks like a mark of YAML is told where it must be one, and nowhere else."""
    text = "a: b\u00a0c\nd: {e: 5\u00a0N*m, f: \u201cg\u201d}\n'h\uff1a i': j\uff0ck\nl\uff1am: 1\n\"\u00a0n\": 2\n"
    assert document_from_text(text).data == {
        "a": "b\u00a0c",
        "d": {"e": "5\u00a0N*m", "f": "\u201cg\u201d"},
        "h\uff1a i": "j\uff0ck",
        "l\uff1am": 1,
        "\u00a0n": 2,
    }


def test_a_repeated_key_is_refused_in_full() -> None:
    """Place, place of the first, where, help."""
    assert [str(d) for d in errors("m:\n  legs: {kp: 1,\n    kp: 2}\n")] == [
        "s.yaml:3:5: SPEC006 m.legs: the key 'kp' is repeated, first at s.yaml:2:10"
        "\n  help: keep one of the two"
    ]


def test_a_header_too_far_in_is_told_once_at_its_own_line() -> None:
    """Its keys are repeated in the mapping above: four of them, one twice; that of another mapping stays as it is."""
    text = (
        "m:\n  legs:\n    a: 1\n    b: 1\n    c: {d}\n    arms:\n    a: 2\n    x: 2\n    b: 2\n    b: 3\n"
        "n: {y: 1, y: 2}\n"
    )
    assert [str(d) for d in errors(text)] == [
        "s.yaml:6:5: SPEC006 m.legs: `arms` is empty in `legs`, and what follows is repeated there: `a`, `b`"
        "\n  help: indent `arms:` by 2 spaces as `legs:`, if that is its own",
        "s.yaml:11:11: SPEC006 n: the key 'y' is repeated, first at s.yaml:11:5\n  help: keep one of the two",
    ]


def test_a_header_two_levels_too_far_in_is_told_too() -> None:
    """It ends up below the last field of the mapping above."""
    text = "m:\n   legs:\n      a: 1\n      b:\n         c: 1\n         arms:\n      a: 2\n"
    assert [str(d).splitlines() for d in errors(text)] == [
        [
            "s.yaml:6:10: SPEC006 m.legs: `arms` is empty in `legs`, and what follows is repeated there: `a`",
            "  help: indent `arms:` by 3 spaces as `legs:`, if that is its own",
        ]
    ]


def test_a_section_too_far_in_is_told_by_one_name_that_is_repeated() -> None:
    """A group called as a motor is repeated among the motors, though not as the first behind `actuators:`."""
    text = "motors:\n  hip: {a: 1}\n  knee: {a: 1}\n  actuators:\n  legs: {b: 1}\n  knee: {b: 1}\n"
    assert [str(d).splitlines() for d in errors(text)] == [
        [
            "s.yaml:4:3: SPEC006 motors: `actuators` is empty in `motors`, and what follows is repeated there: `knee`",
            "  help: indent `actuators:` by 0 spaces as `motors:`, if that is its own",
        ]
    ]
    (only,) = said(text.replace("actuators", "wrist"))
    assert "the key 'knee' is repeated" in only


@pytest.mark.parametrize(
    "text",
    [
        pytest.param("m:\n  l:\n    a: 1\n    b:\n    c: 1\n    a: 2\n", id="one key, and not the next"),
        pytest.param("m:\n  l:\n    b:\n    a: 1\n    a: 2\n", id="above both"),
        pytest.param("m:\n  l:\n    a: 1\n    b: {c}\n    a: 2\n", id="in braces"),
        pytest.param("a: 1\nb:\na: 2\n", id="at the left edge"),
        pytest.param("m:\n  l:\n    a: 1\n    a: 2\n    b:\n", id="below both"),
    ],
)
def test_an_empty_key_is_no_header_of_what_is_repeated_elsewhere(text: str) -> None:
    """The repeated key is told."""
    (only,) = said(text)
    assert "the key 'a' is repeated" in only


def test_a_merge_key_points_to_overrides() -> None:
    """The language has its own way to say `the same but`."""
    (error,) = errors("a: &a {k: 1}\nb:\n  <<: *a\n  l: 2\n")
    assert (error.code, error.where, error.span) == ("SPEC007", "b", Span("s.yaml", 3, 3))
    assert error.help == "use `overrides` for the joints that differ, or a motor by name for what is shared"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        pytest.param(
            "true: 1", "SPEC009 1:1 the key true reads as a truth value, and keys are text", id="bool key"
        ),
        pytest.param(
            "1.5: 1", "SPEC009 1:1 the key 1.5 reads as a number, and keys are text", id="float key"
        ),
        pytest.param(
            ".inf: 1", "SPEC009 1:1 the key inf reads as a number, and keys are text", id="infinite key"
        ),
        pytest.param("[a]: 1", "SPEC009 1:1 a key must be a word, not a list", id="list key"),
        pytest.param("? {a: 1}\n: 1", "SPEC009 1:3 a key must be a word, not a mapping", id="mapping key"),
        pytest.param("a: !x [1]", "SPEC008 1:4 the tag !x is not allowed", id="tag on a list"),
        pytest.param("a: !!set {b}", "SPEC008 1:4 the tag !!set is not allowed", id="set"),
        pytest.param("a: !!map [b]", "SPEC008 1:4 the tag !!map is not allowed", id="list tagged as mapping"),
        pytest.param("a: ! 1", "SPEC008 1:4 the tag ! is not allowed", id="bare tag"),
        pytest.param("a: !<x:y> 1", "SPEC008 1:4 the tag !<x:y> is not allowed", id="verbatim tag"),
        pytest.param(
            "!!python/name:os.x a: 1",
            "SPEC008 1:1 the tag !!python/name:os.x is not allowed",
            id="tagged key",
        ),
        pytest.param(
            "a: !!int 1.5", "SPEC008 1:4 !!int does not fit the text '1.5'", id="tag that does not fit"
        ),
        pytest.param("a: !!float x", "SPEC008 1:4 !!float does not fit the text 'x'", id="no float"),
        pytest.param("a: !!bool 1", "SPEC008 1:4 !!bool does not fit the text '1'", id="no bool"),
        pytest.param(
            "%YAML 1.1\n---\na: 1", "SPEC008 1:1 the directive '%YAML 1.1' is not allowed", id="YAML 1.1"
        ),
        pytest.param(
            "# c\n\n%TAG !e! x:y\n---\na: 1",
            "SPEC008 3:1 the directive '%TAG !e! x:y' is not allowed",
            id="%TAG",
        ),
        pytest.param("a: 1\n---\nb: 1", "SPEC005 2:1 a second document begins here", id="two documents"),
        pytest.param("a: 1\n...\nb: 1", "SPEC004 3:1 the text goes on after its end", id="after the end"),
        pytest.param("", "SPEC005 0:0 the file is empty", id="empty"),
        pytest.param("# only this\n\n", "SPEC005 0:0 the file is empty", id="comment only"),
        pytest.param("---\n", "SPEC005 0:0 the file is empty", id="empty document"),
        pytest.param("\ufeff", "SPEC005 0:0 the file is empty", id="byte order mark only"),
        pytest.param("- a", "SPEC005 1:1 must be a mapping of keys, got a list", id="list"),
        pytest.param("\n x", "SPEC005 2:2 must be a mapping of keys, got the value 'x'", id="word"),
        pytest.param("~", "SPEC005 1:1 must be a mapping of keys, got the value null", id="null"),
        pytest.param("a:\tb", "SPEC003 1:3 a tab is not allowed", id="tab between"),
        pytest.param("a:\n\tb: 1", "SPEC003 2:1 a tab is not allowed", id="tab as indentation"),
        pytest.param("a: b\t# c", "SPEC003 1:5 a tab is not allowed", id="tab before a comment"),
        pytest.param("a: b#c\td", "SPEC003 1:7 a tab is not allowed", id="no comment"),
        pytest.param("a: x\0", "SPEC003 1:5 the character U+0000 is not allowed", id="NUL"),
        pytest.param(
            "a:\n  x\x1b[0m", "SPEC003 2:4 the character U+001B is not allowed", id="escape character"
        ),
        pytest.param("a: x\x85b", "SPEC003 1:5 the character U+0085 is not allowed", id="NEL"),
        pytest.param("a: x\u2028b", "SPEC003 1:5 the character U+2028 is not allowed", id="line separator"),
        pytest.param(
            "a: \ufeffb", "SPEC003 1:4 the character U+FEFF is not allowed", id="byte order mark inside"
        ),
        pytest.param(
            'a: "x\\0"', "SPEC003 1:4 a text may not hold NUL or half of a surrogate pair", id="escaped NUL"
        ),
        pytest.param(
            b"a: 1\nb\xc3\xb6: \xff", "SPEC003 2:5 the file is not UTF-8, got the byte 0xff", id="not UTF-8"
        ),
        pytest.param(
            "a: \ud800", "SPEC003 1:4 the file is not UTF-8, got the byte 0xed", id="lone surrogate"
        ),
        pytest.param("a: 1".encode("utf-16"), "SPEC003 1:1 the file is UTF-16, not UTF-8", id="UTF-16"),
        pytest.param("a: *x", "SPEC010 1:4 the alias *x has no anchor &x above it", id="unknown alias"),
        pytest.param(
            "a: *x\nb: &x 1", "SPEC010 1:4 the alias *x has no anchor &x above it", id="alias before anchor"
        ),
        pytest.param(
            "a: &x [*x]",
            "SPEC010 1:8 the alias *x is recursive: it stands inside its own anchor",
            id="recursive list",
        ),
        pytest.param(
            "a: &x {b: {c: *x}}",
            "SPEC010 1:15 the alias *x is recursive: it stands inside its own anchor",
            id="recursive mapping",
        ),
        pytest.param(
            "&x a: 1\n? *x\n: 2",
            "SPEC006 2:3 the key 'a' is repeated, first at s.yaml:1:1",
            id="alias as a key",
        ),
    ],
)
def test_what_is_refused_says_where(text: str | bytes, expected: str) -> None:
    """One error, at its place."""
    assert said(text) == [expected]


@pytest.mark.parametrize(
    ("text", "line", "message", "help"),
    [
        pytest.param(
            "- *_hip_joint",
            1,
            "the alias *_hip_joint has no anchor &_hip_joint above it",
            "a joint pattern must be quoted: '.*_hip_joint'",
            id="glob read as alias",
        ),
        pytest.param(
            "a: &legs 1\nb: *lges",
            2,
            "the alias *lges has no anchor &lges above it",
            "did you mean *legs?",
            id="misspelt alias",
        ),
        pytest.param(
            "a: *.hip",
            1,
            "`*` begins an alias here, and this is no alias",
            "a joint pattern must be quoted: '.*_hip_joint'",
            id="star",
        ),
        pytest.param(
            'a: "\\d"',
            1,
            "this backslash begins no escape of double quotes",
            "put a pattern into single quotes, such as '\\d+'",
            id="backslash in double quotes",
        ),
        pytest.param("a: 1\nb: 'x\nc: 1\n", 2, "this quote is never closed", "close it", id="open quote"),
        pytest.param(
            "a: [x,\n y", 1, "this list lacks a `,` or its `]`", "close it with `]`", id="open list"
        ),
        pytest.param(
            "a: {x: 1\nb: 1}",
            1,
            "this mapping lacks a `,` or its `}`, and line 2 does not go on with it",
            "close it with `}`",
            id="missing comma",
        ),
        pytest.param(
            "a: @x",
            1,
            "a value cannot begin with @",
            "quote text that begins with one of [ ] { } * & ! | > % @ `",
            id="reserved",
        ),
        pytest.param(
            "- [a-z]+x",
            1,
            "a list item must begin with `- ` at the indentation of its list",
            "quote text that begins with one of [ ] { } * & ! | > % @ `",
            id="pattern with a class",
        ),
        pytest.param(
            "a: b\n- c",
            2,
            "this `- ` begins a list, and keys stand beside it",
            "write `c` without `- `",
            id="list at key level",
        ),
        pytest.param(
            "a: 1\n  b: 2",
            2,
            "this line is indented by 2 spaces, below line 1 which has 0 and a value already",
            "indent it by 0 spaces as line 1, if it is a key beside it, or line 1 by 2",
            id="indentation",
        ),
        pytest.param(
            "a:\n  b:\n    c: 1\n  d: {e: 1}\n    f: 2",
            5,
            "this line is indented by 4 spaces, below line 4 which has 2 and a value already",
            "indent it by 2 spaces as line 4, if it is a key beside it, or line 4 by 4",
            id="a key too far left, and the next one not",
        ),
        pytest.param(
            "a:\n  b: 1\n  c:\n      d: 1\n    e: 2",
            5,
            "this line is indented by 4 spaces, and what is open above it by 0, 2, 6",
            "indent it by 6 spaces as line 4, or by 2 as line 3",
            id="no level",
        ),
        pytest.param(
            "a:\n  c:\n      d: 1\n    e: 2\n    f: 3",
            3,
            "this line is indented by 6 spaces, and those below it in the same mapping by 4",
            "indent it by 4 spaces",
            id="the first key further in than the rest",
        ),
        pytest.param(
            'a:\n  kp: "160" N*m/rad',
            2,
            "`N*m/rad` stands behind the closing quote of a value",
            "write `kp: 160 N*m/rad`, or all of it in quotes",
            id="a quoted number and its unit",
        ),
        pytest.param(
            "a:\n  b: 1\nc:\n    d: 1\n  e: 2",
            5,
            "this line is indented by 2 spaces, and what is open above it by 0, 4",
            "indent it by one of these, or check the indentation of line 3",
            id="no level, by the line of the key above",
        ),
        pytest.param(
            "a:\n  b: 1\n  - c:  # d\n",
            3,
            "this `- ` begins a list, and keys stand beside it",
            "write `c:` without `- `",
            id="list among keys with a comment",
        ),
        pytest.param(
            "a: 1\nb = 2  # c\nd: 3",
            2,
            "`b = 2` has `=` in place of `:`",
            "write `b: 2`",
            id="equals with a comment",
        ),
        pytest.param(
            'a: "b"; "c"\nd: 1',
            1,
            "what stands behind `a:` is several texts, and no list",
            'write `a: ["b", "c"]`',
            id="list without brackets",
        ),
        pytest.param(
            "a: {b: %25, c: 1}", 1, "a value cannot begin with %", "write `25 %`", id="percent before"
        ),
        pytest.param(
            "a: [>= 3 Hz]",
            1,
            "a value cannot begin with >",
            'a bound stands in a note: write `{value: 3 Hz, note: ">= 3 Hz"}`',
            id="bound in a list",
        ),
        pytest.param(
            "a: 1\nb:\u00a02\nc: 3",
            2,
            "the character U+00A0, no-break space, stands where a space must",
            "replace it by a space, or remove it",
            id="no-break space behind a colon",
        ),
        pytest.param(
            "a: 1\n\u3000b: 2\nc: 3\n  d: 4",
            2,
            "the character U+3000, ideographic space, stands where a space must",
            "replace it by a space, or remove it",
            id="ideographic space before a key",
        ),
        pytest.param(
            "a: {b: 1,\u00a0c: 2}",
            1,
            "the character U+00A0, no-break space, stands where a space must",
            "replace it by a space, or remove it",
            id="no-break space behind a comma",
        ),
        pytest.param(
            "a: 1\nb\uff1a 2\nc: 3",
            2,
            "the character U+FF1A, fullwidth colon, is a letter to YAML, and no `:`",
            "write `:`",
            id="fullwidth colon",
        ),
        pytest.param(
            'a: ["b"\uff0c "c"]',
            1,
            "the character U+FF0C, fullwidth comma, is a letter to YAML, and no `,`",
            "write `,`",
            id="fullwidth comma",
        ),
        pytest.param(
            'a: ["b\u201d]\nc: "d"',
            1,
            "this quote is not closed on its line",
            'write `"b"`',
            id="quotes of two kinds",
        ),
        pytest.param(
            "a: 1\nb:2\nc: 3", 2, "`b:2` lacks a space behind its colon", "write `b: 2`", id="no space"
        ),
        pytest.param("a: 1\nb = 2\nc: 3", 2, "`b = 2` has `=` in place of `:`", "write `b: 2`", id="equals"),
        pytest.param(
            "t:\n  a:2 ms\n  b: 10",
            2,
            "`a:2 ms` lacks a space behind its colon",
            "write `a: 2 ms`",
            id="no space behind a mapping's first colon",
        ),
        pytest.param(
            "a: Manual: part 2",
            1,
            "the `: ` inside this text begins a mapping",
            'put it into quotes: a: "Manual: part 2"',
            id="colon in a text",
        ),
        pytest.param(
            "a: - 1",
            1,
            "a list item `- ` cannot stand behind its key",
            "write the items on lines of their own, or in [ ]",
            id="item behind its key",
        ),
    ],
)
def test_a_syntax_error_is_told_in_plain_words(text: str, line: int, message: str, help: str) -> None:
    """One diagnostic whose help is the usual remedy; the two parsers agree on line and words."""
    (error,) = errors(text)
    assert error.span is not None
    assert (error.span.line, error.message, error.help) == (line, message, help)


@pytest.mark.parametrize(
    ("text", "place", "message", "help"),
    [
        pytest.param("a:\n  b c\n  d: 1", "2:3", "`b` has no `:`", "write `b: c`", id="first of a mapping"),
        pytest.param("a:\n  x: 1\n  b c\n  d: 1", "3:3", "`b` has no `:`", "write `b: c`", id="inside"),
        pytest.param("a:\n  x: 1\n  b c # d\nd: 1", "3:3", "`b` has no `:`", "write `b: c`", id="last"),
        pytest.param("a: 1\n\nb\n  c:\n    d: 1", "3:1", "`b` has no `:`", "write `b:`", id="section"),
        pytest.param(
            "a:\n  b: 1\n  c\n    '.*': {d: 1}", "3:3", "`c` has no `:`", "write `c:`", id="above a quote"
        ),
        pytest.param("a 1\nb: 1", "1:1", "`a` has no `:`", "write `a: 1`", id="first of all"),
        pytest.param(
            "a:\n  b: 1\n  kp {value: 8, s: t}\n  c: 1",
            "3:3",
            "`kp` has no `:`",
            "write `kp: {value: 8, s: t}`",
            id="before a brace",
        ),
        pytest.param(
            "a:\n  '.*x' 0.4 rad\n  b: 1", "2:3", "`'.*x'` has no `:`", "write `'.*x': 0.4 rad`", id="quoted"
        ),
        pytest.param(
            "a:\n  b: v: 5 rpm, s: t}\n  c: 1",
            "2:6",
            "this mapping lacks its `{`",
            "write `b: {v: 5 rpm, s: t}`",
            id="no opening brace",
        ),
        pytest.param(
            "a:\n  b: 'x', 'y']\n  c: 1",
            "2:6",
            "this list lacks its `[`",
            "write `b: ['x', 'y']`",
            id="no opening bracket",
        ),
        pytest.param("a: {b: 1}}\nc: 1", "1:10", "this `}` closes nothing", "remove it", id="extra brace"),
        pytest.param("a: [b, c]]\nd: 1", "1:10", "this `]` closes nothing", "remove it", id="extra bracket"),
        pytest.param("a: ['b' 'c']", "1:9", "a `,` is missing before `'c'`", None, id="no comma in a list"),
        pytest.param("a: {b: 4 N*m s: t}", "1:14", "a `,` is missing before `s`", None, id="in a mapping"),
        pytest.param("a: {b: [1, 2] s: t}", "1:15", "a `,` is missing before `s`", None, id="behind a list"),
        pytest.param("a: [b, c}", "1:9", "this list ends with `}`", "close it with `]`", id="other bracket"),
        pytest.param(
            'a: 1\nb: [".*x]\nc: 1\nd: [".*y"]',
            "2:5",
            "this quote is not closed on its line",
            'write `".*x"`',
            id="quote in a list",
        ),
        pytest.param(
            'a:\n  ".*x: 1\n  ".*y": 2',
            "2:3",
            "this quote is not closed on its line",
            'write `".*x"`',
            id="quote of a key",
        ),
        pytest.param(
            "a:\n  - b: 1\n  c: 2",
            "2:3",
            "this `- ` begins a list, and keys stand beside it",
            "write `b: 1` without `- `",
            id="hyphen before the first key",
        ),
        pytest.param(
            "motors:\n  a:\n    b: 1\nc:\n    b: 1\n  d:\n    b: 1",
            "4:1",
            "`c` stands at the left edge, and is no section; what follows is indented by 2",
            "indent it by 2 spaces",
            id="a name at the left edge",
        ),
        # Whose items go on, or whose key is further in, is a list.
        pytest.param(
            "a:\n  - b: 1\n  c: 2\n  - d: 3",
            "3:3",
            "this line is indented by 2 spaces, and the first key of its item, in line 2, by 4",
            "indent it by 4 spaces",
            id="a key of an item below its hyphen",
        ),
        pytest.param(
            "a:\n  - b: 1\n   c: 2",
            "3:4",
            "this line is indented by 3 spaces, and the first key of its item, in line 2, by 4",
            "indent it by 4 spaces",
            id="a key of an item one space short",
        ),
        pytest.param(
            "a:\n  - b: 1\n     c: 2",
            "3:6",
            "this line is indented by 5 spaces, and the first key of its item, in line 2, by 4",
            "indent it by 4 spaces",
            id="a key of an item one space too far",
        ),
        pytest.param(
            "a:\n  - {b: 1}\n    {c: 2}",
            "3:5",
            "this item lacks its `- `",
            "write `- {c: 2}`, indented by 2",
            id="second item without its hyphen",
        ),
        pytest.param(
            "a:\n  - {b: 1}\n  -{c: 2, d: 3}",
            "3:3",
            "`-{c: 2, d: 3}` lacks a space behind its hyphen",
            "write `- {c: 2, d: 3}`",
            id="no space behind the hyphen of a mapping",
        ),
        pytest.param(
            "a: []\n  b: 1",
            "1:1",
            "`a: []` is empty, and what belongs to it stands below",
            "write `a:`",
            id="keys below an empty list",
        ),
        pytest.param(
            "a:\n  b: 1\n  - c: 2\n  d: 3",
            "3:3",
            "this `- ` begins a list, and keys stand beside it",
            "write `c: 2` without `- `",
            id="hyphen before another",
        ),
        pytest.param(
            "a:\n  - b\n  - c\n  d: 1",
            "4:3",
            "a list item must begin with `- ` at the indentation of its list",
            "quote text that begins with one of [ ] { } * & ! | > % @ `",
            id="a list with a key below it",
        ),
        pytest.param(
            "a:\n  b: some long\n    text\n    c: 1",
            "4:6",
            "a `: ` is not expected here",
            "check the indentation, or quote the text",
            id="a text that goes on",
        ),
        pytest.param(
            "t: lo [ hi\nkp {v: 1, s: t}",
            "2:1",
            "`kp` has no `:`",
            "write `kp: {v: 1, s: t}`",
            id="below a bracket in a text",
        ),
        pytest.param(
            "t: it's\nkp {v: 1, s: t}",
            "2:1",
            "`kp` has no `:`",
            "write `kp: {v: 1, s: t}`",
            id="below an apostrophe",
        ),
        pytest.param(
            "a:\n  [FR]L_x: {v: 1}\n  b: 2",
            "2:3",
            "a key that begins with `[` is a list to YAML, and no pattern",
            'write `"[FR]L_x":`',
            id="pattern as the first key",
        ),
        pytest.param(
            "a:\n  b: 2\n  [FR][LR]_x: 1",
            "3:3",
            "a key that begins with `[` is a list to YAML, and no pattern",
            'write `"[FR][LR]_x":`',
            id="pattern as another key",
        ),
        pytest.param(
            "a:\n  - b\n    c\n  - d",
            "3:5",
            "this item lacks its `- ` and goes on with the one above it",
            "write `- c`",
            id="no hyphen in a list",
        ),
        # The second item is further in than the first: a place of its own, not `- ` among keys.
        pytest.param(
            "a:\n  g:\n    - {r: 14}\n      - {r: 2}",
            "4:7",
            "this item is indented by 6 spaces, and that of line 3, in the same list, by 4",
            "indent it by 4 spaces",
            id="an item in braces further in",
        ),
        pytest.param(
            "a:\n  g:\n  - {r: 14}\n    - {r: 2}",
            "4:5",
            "this item is indented by 4 spaces, and that of line 3, in the same list, by 2",
            "indent it by 2 spaces",
            id="an item further in than a list at its key",
        ),
        pytest.param(
            "a:\n  g:\n    - {r: 14}\n  - {r: 2}",
            "4:3",
            "this item is indented by 2 spaces, and that of line 3, in the same list, by 4",
            "indent it by 4 spaces",
            id="an item further out",
        ),
        pytest.param(
            "a:\n  g:\n    - r: 14\n      e: 1\n      - r: 2\n        e: 1",
            "5:7",
            "this item is indented by 6 spaces, and that of line 3, in the same list, by 4",
            "indent it by 4 spaces",
            id="an item at the keys of the one before",
        ),
        pytest.param(
            "a:\n  g:\n    - r: 14\n        - r: 2",
            "4:9",
            "this item is indented by 8 spaces, and that of line 3, in the same list, by 4",
            "indent it by 4 spaces",
            id="an item in the text of the one before",
        ),
        pytest.param(
            "a:\n  - b\n    - c\n  - d",
            "3:5",
            "this item is indented by 4 spaces, and that of line 2, in the same list, by 2",
            "indent it by 2 spaces",
            id="a word further in",
        ),
        pytest.param(
            "a:\n  - b\n    - c\n    - d",
            "2:3",
            "this item is indented by 2 spaces, and that of line 3, in the same list, by 4",
            "indent it by 4 spaces",
            id="the first word further out than all others",
        ),
        # A list that has ended is not this one's.
        pytest.param(
            "a:\n  b:\n    - c\n  d: 1\n  - e: 2",
            "5:3",
            "this `- ` begins a list, and keys stand beside it",
            "write `e: 2` without `- `",
            id="hyphen behind a key that has a list",
        ),
        pytest.param(
            'a: {t: "Servo 430, 12 V}\nb: "x"',
            "1:8",
            "this quote is not closed on its line",
            'write `"Servo 430, 12 V"`',
            id="quote of a text with a comma",
        ),
        pytest.param(
            'a: {t: "Servo 430, 12 V, p: 3}\nb: "x"',
            "1:8",
            "this quote is not closed on its line",
            'write `"Servo 430, 12 V"`',
            id="quote of a text with a comma before a key",
        ),
        pytest.param(
            'a:\n  t: "Servo: 430, 12 V  # c\nb: "x"',
            "2:6",
            "this quote is not closed on its line",
            'write `"Servo: 430, 12 V"`',
            id="quote of a text that is the rest of its line",
        ),
        pytest.param(
            "a: {n: 4 ms, r=[2 ms, 8 ms]}",
            "1:14",
            "`r` has `=` in place of `:`",
            "write `r: [2 ms, 8 ms]`",
            id="equals before a list in braces",
        ),
        pytest.param(
            "a: {v: 5 ms, note: delay: 5 steps}\nb: 1",
            "1:25",
            "the `: ` inside this text begins a mapping",
            'put it into quotes: note: "delay: 5 steps"',
            id="colon behind the first word of a note",
        ),
        pytest.param(
            'a: [".*x", ".*y, ".*z"]',
            "1:12",
            "this quote is not closed before the `,`",
            'write `".*y"`',
            id="quote before a pattern",
        ),
        pytest.param(
            "a: ['x, 'y', 'z']",
            "1:5",
            "this quote is not closed before the `,`",
            "write `'x'`",
            id="quote before a letter",
        ),
        pytest.param(
            "a:\n  b: 1\n  kp = {value: 8, s: t}\n  c: 1",
            "3:3",
            "`kp = {value: 8, s: t}` has `=` in place of `:`",
            "write `kp: {value: 8, s: t}`",
            id="equals before a brace",
        ),
        pytest.param(
            "a: {v: 1, s: t # checked}\nb: 1",
            "1:16",
            "the `}` of this mapping stands in a comment, which begins with the `#`",
            "write the `}` before the `#`",
            id="brace in a comment",
        ),
        pytest.param(
            "a: [b,\n  c # all]\nd: 1",
            "2:5",
            "the `]` of this list stands in a comment, which begins with the `#`",
            "write the `]` before the `#`",
            id="bracket in a comment of the next line",
        ),
    ],
)
def test_the_line_that_lacks_a_mark_is_blamed(text: str, place: str, message: str, help: str | None) -> None:
    """Not the line after it, on which the parser stops; the two parsers agree."""
    (error,) = errors(text)
    assert error.span is not None
    assert (f"{error.span.line}:{error.span.column}", error.message, error.help) == (place, message, help)


@pytest.mark.parametrize(
    "text",
    [
        "a: 'one\n  two'\nb: [1\nc: 2",
        "t: it's [5, 6[ wide\nb: [1\nc: 2",
        "t: x # [ {\nb: [1\nc: 2",
        "t: [1,\n  2]\nb: [1\nc: 2",
        "t: 1\nb: [1\n  # [2]\nc: 2",
        "t: 1\nb: [1\n, ' # ]'\nc: 2",
    ],
)
def test_marks_that_mean_nothing_are_not_blamed(text: str) -> None:
    """A quote over two lines, apostrophes and brackets in texts and comments: the list that is open is told."""
    (error,) = errors(text)
    assert error.span is not None
    assert error.message.startswith("this list lacks a `,` or its `]`")
    assert error.span.line == text.split("\n").index("b: [1") + 1


@pytest.mark.parametrize(
    "text", ['a: "\\uD800"', 'a: "\\U99999999"', "a: [1, ", "a: |2x\n b", "a: &", "? [", "{a"]
)
def test_any_other_broken_text_is_one_error_too(text: str) -> None:
    """No exception of the parser gets out, whichever parser it is."""
    (error,) = errors(text)
    assert error.code in ("SPEC003", "SPEC004")


def test_a_key_with_nothing_behind_it_has_no_value() -> None:
    """What stands below it is not blamed for its indentation."""
    assert said("a:\n  [b, c]d: 1") == [
        "SPEC009 2:3 a key must be a word, not a list",
        "SPEC004 2:9 a key is expected here, at the indentation of its mapping",
    ]


def test_a_text_of_several_words_a_line_goes_on() -> None:
    """Only an item that has one word on each of its lines is several; a text may go on, in [ ] too."""
    text = "a:\n  - some long\n    text\nb: [c\n d]"
    assert document_from_text(text, "s.yaml").data == {"a": ["some long text"], "b": ["c d"]}


def test_an_empty_file_points_to_init() -> None:
    """Who has no spec yet learns how to get one."""
    assert errors("")[0].help == "`actspec init` writes a first one"


@pytest.mark.slow
def test_errors_are_bounded() -> None:
    """A file of a hundred thousand errors is not told in a hundred thousand lines."""
    found = errors("a: 1\n" * 100_000)
    assert len(found) == MAX_ERRORS + 1
    assert (found[-1].code, found[-1].message) == ("SPEC019", "more than 50 errors; reading stopped here")


# --- limits --------------------------------------------------------------------------------------


def test_a_billion_laughs_ends_early() -> None:
    """Nine levels of nine aliases would be 9^9 values; the sixth already passes the limit."""
    lines = ["a: &a [x,x,x,x,x,x,x,x,x]"]
    lines += [f"{c}: &{c} [{','.join(['*' + p] * 9)}]" for p, c in zip("abcdefgh", "bcdefghi", strict=True)]
    # Expanded sizes: a 10, b 1 + 9*10 = 91, c 820, d 7381, e 66 430: the second *e of f passes 100 000.
    (error,) = errors("\n".join(lines))
    assert error.code == "SPEC011"
    assert error.message == "the file has more than 100000 values, aliases expanded"
    assert error.span is not None and error.span.line == 6


def test_aliases_are_counted() -> None:
    """A hundred aliases are read, one more is not."""
    anchor = "a: &x 1\n"
    assert document_from_text(anchor + "b: [" + "*x ," * MAX_ALIASES + "]").data["b"] == [1] * 100
    assert said(anchor + "b: [" + "*x ," * (MAX_ALIASES + 1) + "]") == ["SPEC010 2:405 more than 100 aliases"]


@pytest.mark.slow
def test_values_are_counted_without_aliases_too() -> None:
    """The root, a key, its list and the items: 3 + items."""
    if not hasattr(yaml, "CSafeLoader"):
        pytest.skip("the count is the same code, and the pure parser is slow")
    assert len(document_from_text("a: [" + "1," * (MAX_NODES - 3) + "]").data["a"]) == 99_997
    assert [d.code for d in errors("a: [" + "1," * (MAX_NODES - 2) + "]")] == ["SPEC011"]


@pytest.mark.parametrize(("begin", "end"), [("[", "]"), ("{a: ", "}")], ids=["lists", "mappings"])
def test_nesting_is_bounded(begin: str, end: str) -> None:
    """Forty levels with the root are read, forty-one are not, a hundred thousand stop at once."""
    deep = MAX_DEPTH - 1
    assert document_from_text("a: " + begin * deep + "1" + end * deep).data
    deep += 1
    column = 4 + len(begin) * (deep - 1)
    assert said("a: " + begin * deep + "1" + end * deep) == [
        f"SPEC011 1:{column} nested more than 40 levels deep"
    ]
    assert [d.code for d in errors("a: " + begin * 100_000)] == ["SPEC011"]


def test_nesting_through_aliases_is_bounded() -> None:
    """Each line is two levels deep, the expanded value is one deeper than the line above."""
    lines = ["k0: &k0 [1]"] + [f"k{i}: &k{i} [*k{i - 1}]" for i in range(1, 60)]
    # k0 is 1 level, k_i is i + 1; under the root k38 has 1 + 39 = 40 levels, and k39 has 41.
    assert len(document_from_text("\n".join(lines[:39])).data) == 39
    (error,) = errors("\n".join(lines))
    assert error.message == "nested more than 40 levels deep, aliases expanded"
    assert error.span == Span("s.yaml", 40, 12)


def test_a_huge_file_is_refused_by_its_size(tmp_path: Path) -> None:
    """The size is looked at first: a sparse terabyte is not read."""
    path = tmp_path / "huge.yaml"
    with path.open("wb") as file:
        file.truncate(1 << 40)
    with pytest.raises(SpecError) as caught:
        load_document(str(path))
    (error,) = caught.value.diagnostics
    assert (error.code, error.span) == ("SPEC002", Span(str(path)))
    assert error.message.endswith("is too large, got 1099511627776 bytes, at most 1048576 bytes are read")


@pytest.mark.slow
def test_the_largest_file_is_read() -> None:
    """A text of exactly a mebibyte is read, a byte more is not."""
    text = "a: 1\n#" + "x" * (MAX_BYTES - 6)
    assert document_from_text(text).data == {"a": 1}
    assert [d.message for d in errors(text + "x")] == [
        "the text is too large, got 1048577 bytes, at most 1048576 bytes are read"
    ]


# --- files ---------------------------------------------------------------------------------------


def failure(path: str) -> Diagnostic:
    """The only diagnostic of a file that cannot be loaded."""
    with pytest.raises(SpecError) as caught:
        load_document(path)
    (error,) = caught.value.diagnostics
    return error


def test_a_missing_file_names_the_nearest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A slip of the keys, a folder without such a file, an empty folder, no folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "notes.txt").write_text("x")
    assert failure("robots/a1.yaml") == Diagnostic(
        "SPEC001",
        failure("x").severity,
        "there is no file 'robots/a1.yaml'",
        "",
        Span("robots/a1.yaml"),
        "the folder has no .yaml file; `actspec init` writes one",
    )
    (tmp_path / "robots" / "a1.yaml").write_text("a: 1")
    (tmp_path / "robots" / "spot.yml").write_text("a: 1")
    assert failure("robots/a11.yaml").help == "did you mean 'robots/a1.yaml'?"
    assert failure("robots/xyzzy").help == "the folder has a1.yaml, spot.yml"
    assert failure("robos/a1.yaml").help == "there is no folder 'robos' either"
    assert failure("robots/a1.yaml/x.yaml").message == "there is no file 'robots/a1.yaml/x.yaml'"


def test_what_is_no_readable_file_is_refused(tmp_path: Path) -> None:
    """A folder, a pipe that nobody writes to, a loop of links, a name with NUL or too long."""
    assert failure(str(tmp_path)).message == f"'{tmp_path}' is a folder"
    os.mkfifo(tmp_path / "pipe")
    assert failure(str(tmp_path / "pipe")).message == f"'{tmp_path / 'pipe'}' is not a regular file"
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    for name in (str(tmp_path / "loop"), "a\0b", "x" * 5000):
        error = failure(name)
        assert error.code == "SPEC001" and "cannot be read: " in error.message and "\0" not in error.message


@pytest.mark.skipif(getattr(os, "geteuid", int)() == 0, reason="root reads everything")
def test_a_file_without_permission_is_refused(tmp_path: Path) -> None:
    """The reason is named."""
    path = tmp_path / "a.yaml"
    path.write_text("a: 1")
    path.chmod(0)
    assert failure(str(path)).message == f"'{path}' may not be read"


def test_a_spec_reached_by_a_link_is_read(tmp_path: Path) -> None:
    """The user's own path may be a link; messages keep the user's name for it."""
    (tmp_path / "a.yaml").write_text("a: 1")
    (tmp_path / "b.yaml").symlink_to("a.yaml")
    document = load_document(str(tmp_path / "b.yaml"))
    assert (document.data, document.path) == ({"a": 1}, str(tmp_path / "b.yaml"))


# --- includes ------------------------------------------------------------------------------------


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with a file outside of the spec's own, which is the working folder's `robots`."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robots" / "motors").mkdir(parents=True)
    (tmp_path / "robots-evil").mkdir()
    for name in ("outside.yaml", "robots-evil/m.yaml"):
        (tmp_path / name).write_text("motors: {evil: {gear_ratio: 1}}")
    return tmp_path


def put(text: str, name: str = "spec.yaml") -> str:
    """Write a file below `robots` and give its path."""
    path = Path("robots") / name
    path.write_text(text)
    return str(path)


def refused(text: str) -> list[str]:
    """The diagnostics of a spec with includes."""
    path = put(text)
    with pytest.raises(SpecError) as caught:
        load_document(path)
    return [str(d) for d in caught.value.diagnostics]


def test_includes_are_merged(tree: Path) -> None:
    """Motors and sources of all files by name; order, spans, hash and names of the files."""
    one = put("sources: {s1: {title: x}}\nmotors:\n  m1: {peak_torque: 1 N*m}\n", "motors/one.yaml")
    two = put("motors: {m2: {}}\n", "two.yaml")
    text = "actspec: 1\ninclude: [motors/one.yaml, ./two.yaml]\nmotors:\n  m0: {}\n"
    document = load_document(put(text))
    assert document.data == {
        "actspec": 1,
        "motors": {"m0": {}, "m1": {"peak_torque": "1 N*m"}, "m2": {}},
        "sources": {"s1": {"title": "x"}},
    }
    assert list(document.data["motors"]) == ["m0", "m1", "m2"]
    assert document.includes == ("motors/one.yaml", "./two.yaml")
    spans = document.spans
    assert spans.value(("motors", "m1", "peak_torque")) == Span("robots/motors/one.yaml", 3, 21)
    assert spans.key(("motors", "m2")) == Span("robots/two.yaml", 1, 10)
    assert spans.key(("motors",)) == Span("robots/spec.yaml", 3, 1)
    assert spans.key(("sources",)) == Span("robots/motors/one.yaml", 1, 1)
    assert spans.value(("include",)) == spans.value(())
    hashed = text.encode()
    for name, path in (("motors/one.yaml", one), ("./two.yaml", two)):
        hashed += b"\0" + name.encode() + b"\0" + Path(path).read_bytes()
    assert document.text_sha256 == hashlib.sha256(hashed).hexdigest()


def test_the_hash_holds_the_order_and_the_contents(tree: Path) -> None:
    """Order, a comment in an include, and a name are all part of what was compiled."""
    put("motors: {m1: {}}", "one.yaml")
    put("motors: {m2: {}}", "two.yaml")
    put("motors: {m2: {}}", "three.yaml")
    orders = ("one.yaml, two.yaml", "two.yaml, one.yaml", "one.yaml, three.yaml")
    hashes = {load_document(put(f"include: [{names}]")).text_sha256 for names in orders}
    put("motors: {m2: {}} # x", "two.yaml")
    hashes.add(load_document(put("include: [one.yaml, two.yaml]")).text_sha256)
    assert len(hashes) == 4


def test_null_sections_are_no_sections(tree: Path) -> None:
    """`motors:` without a value holds nothing, in the spec and in an include."""
    put("motors: {m1: {}}\nsources:\n", "one.yaml")
    document = load_document(put("motors:\ninclude: [one.yaml]\n"))
    assert document.data == {"motors": {"m1": {}}}


HELP = "\n  help: an include is a relative path inside the folder of the spec, such as motors/unitree.yaml"


@pytest.mark.parametrize(
    ("name", "problem"),
    [
        ("../outside.yaml", "leaves the folder of the spec by `..`"),
        ("motors/../../outside.yaml", "leaves the folder of the spec by `..`"),
        ("../robots/one.yaml", "leaves the folder of the spec by `..`"),
        ("../robots-evil/m.yaml", "leaves the folder of the spec by `..`"),
        ("/etc/passwd", "is an absolute path"),
        ("C:/x.yaml", "is an absolute path"),
        ("\\\\host\\x.yaml", "is an absolute path"),
        ("motors\\one.yaml", "has a backslash; folders are separated by `/`"),
        ("https://example.org/m.yaml", "is a URL, and only files are read"),
        ("file:///etc/passwd", "is a URL, and only files are read"),
        ("out.yaml", "leaves the folder of the spec by a symbolic link"),
        ("linked/outside.yaml", "leaves the folder of the spec by a symbolic link"),
        ("sibling.yaml", "leaves the folder of the spec by a symbolic link"),
        ("linked/../one.yaml", "leaves the folder of the spec by a symbolic link"),
    ],
)
def test_an_include_stays_in_the_folder(tree: Path, name: str, problem: str) -> None:
    """The rule that was broken is named; nothing of the outside file is shown."""
    put("motors: {}", "one.yaml")
    (tree / "robots" / "out.yaml").symlink_to("../outside.yaml")
    (tree / "robots" / "sibling.yaml").symlink_to("../robots-evil/m.yaml")
    (tree / "far" / "deep").mkdir(parents=True)
    (tree / "far" / "one.yaml").write_text("motors: {evil: {}}")
    (tree / "robots" / "linked").symlink_to("../far/deep")
    assert refused(f"include:\n  - one.yaml\n  - '{name}'\n") == [
        f"robots/spec.yaml:3:5: SPEC013 include[1]: '{name}' {problem}{HELP}"
    ]


def test_a_link_inside_the_folder_is_followed(tree: Path) -> None:
    """Only leaving is refused; a linked robots folder is its own folder."""
    put("motors: {m: {}}", "motors/one.yaml")
    (tree / "robots" / "alias.yaml").symlink_to("motors/one.yaml")
    put("include: [alias.yaml]")
    (tree / "way").symlink_to("robots")
    document = load_document("way/spec.yaml")
    assert document.data == {"motors": {"m": {}}}
    assert document.spans.key(("motors", "m")) == Span("way/alias.yaml", 1, 10)


def test_a_name_is_defined_once(tree: Path) -> None:
    """In the spec and an include, and in two includes: both places are named."""
    put("motors:\n  m1: {}\nsources: {s: {}}", "one.yaml")
    put("sources:\n  s: {}\nmotors: {m2: {}, m1: {}}", "two.yaml")
    text = "include: [one.yaml, two.yaml]\nmotors: {m2: {}}\n"
    help = "\n  help: rename one of the two, or remove it"
    twice = "is defined twice, first at robots"
    assert refused(text) == [
        f"robots/two.yaml:2:3: SPEC015 sources.s: 's' {twice}/one.yaml:3:11{help}",
        f"robots/two.yaml:3:10: SPEC015 motors.m2: 'm2' {twice}/spec.yaml:2:10{help}",
        f"robots/two.yaml:3:18: SPEC015 motors.m1: 'm1' {twice}/one.yaml:2:3{help}",
    ]


def test_an_included_file_holds_motors_and_sources_only(tree: Path) -> None:
    """Each other key at its own place, in the file that has it, and all of them."""
    put("motors: {}\nactuators: {}\ninclude: [x.yaml]\nsources: [1]\n", "one.yaml")
    assert refused("include: [one.yaml]") == [
        "robots/one.yaml:2:1: SPEC014 actuators: an included file cannot hold 'actuators',"
        " only `motors` and `sources`"
        "\n  help: move it into the spec",
        "robots/one.yaml:3:1: SPEC014 include: an included file cannot include another"
        "\n  help: include both files in the spec",
        "robots/one.yaml:4:10: SPEC014 sources: `sources` must be a mapping of names",
    ]


def test_a_whole_spec_is_told_once_where_it_is_included(tree: Path) -> None:
    """Not once a section, and not once a motor that both have."""
    own = "motors: {m: {}}\nrobot: {}\ntiming: {}\nactuators: {}\ntargets: {}\ninclude: [x.yaml]\n"
    put(f"actspec: 1\n{own}", "whole.yaml")
    assert refused("motors: {m: {}}\ninclude: [whole.yaml]") == [
        "robots/spec.yaml:2:11: SPEC014 include[0]: 'whole.yaml' is a whole spec, with `robot`, `timing`, `actuators`, "
        "`targets`; an included file holds `motors` and `sources` only"
        "\n  help: put its `motors` into a file of their own, and include that in both",
    ]


def test_errors_of_all_files_are_told_at_once(tree: Path) -> None:
    """The spec's own, two broken includes, a missing, an empty, a repeated one, and the spec itself."""
    put("motors: {a: 1, a: 2}", "one.yaml")
    put("motors: [", "two.yaml")
    put("", "empty.yaml")
    names = "one.yaml, two.yaml, on.yaml, empty.yaml, motors/../one.yaml, spec.yaml, motors"
    found = refused(f"k: .inf\ninclude: [{names}]\n")
    assert [line.split(": ")[0] + " " + line.split(": ")[1] for line in found if "two.yaml" not in line] == [
        "robots/empty.yaml SPEC005",
        "robots/one.yaml:1:16 SPEC006 motors",
        "robots/spec.yaml:1:4 SPEC016 k",
        "robots/spec.yaml:2:31 SPEC001 include[2]",
        "robots/spec.yaml:2:52 SPEC013 include[4]",
        "robots/spec.yaml:2:72 SPEC013 include[5]",
        "robots/spec.yaml:2:83 SPEC001 include[6]",
    ]
    assert [line for line in found if line.startswith("robots/two.yaml:") and "SPEC004" in line]
    assert "help: did you mean 'robots/one.yaml'?" in "\n".join(found)
    assert "help: write `motors:` or `sources:`" in "\n".join(found)


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        (
            "one.yaml",
            "1:10: SPEC012 include: must be a list of file names\n  help: write `include: [one.yaml]`",
        ),
        ("", "1:9: SPEC012 include: must be a list of file names\n  help: write `include: [motors.yaml]`"),
        ("[[one.yaml]]", "1:11: SPEC012 include[0]: must be a file name, as text"),
        ("[1]", "1:11: SPEC012 include[0]: must be a file name, as text"),
        ("['']", "1:11: SPEC012 include[0]: must be a file name, as text"),
        (
            "[" + "x," * (MAX_INCLUDES + 1) + "]",
            "1:10: SPEC012 include: 65 files are included, at most 64 are read"
            "\n  help: put the motors into fewer files",
        ),
    ],
    ids=["word", "nothing", "list", "number", "empty", "many"],
)
def test_include_is_a_list_of_names(tree: Path, written: str, expected: str) -> None:
    """Anything else is refused, with the form that is right."""
    assert refused(f"include: {written}\n") == [f"robots/spec.yaml:{expected}"]


def test_text_includes_only_from_a_named_folder(tree: Path) -> None:
    """A text has no folder of its own, and the working folder is not guessed."""
    put("motors: {m: {}}", "one.yaml")
    text = "include: [one.yaml]"
    assert said(text) == ["SPEC013 1:11 a text without a folder cannot include files"]
    document = document_from_text(text, base="robots")
    assert document.data == {"motors": {"m": {}}}
    assert document.spans.key(("motors", "m")) == Span("robots/one.yaml", 1, 10)


def test_sections_of_the_wrong_kind_are_left_to_the_models(tree: Path) -> None:
    """`motors: [a]` in the spec is an error of the language, told with the others of its stage."""
    put("motors: {m: {}}", "one.yaml")
    assert load_document(put("include: [one.yaml]\nmotors: [a]")).data == {"motors": ["a"]}


@pytest.mark.parametrize(
    ("name", "text", "code"),
    [
        # A line of prose is no key without its colon.
        ("README.md", "# leg\n\nit learns to\nwalk: on another\nrobot\n", "SPEC104"),
        # It says that it is one, or is named like one.
        ("README.md", "actspec: 1\nit learns to\nwalk: on another\nrobot\n", "SPEC004"),
        ("leg.yaml", "# leg\n\nit learns to\nwalk: on another\nrobot\n", "SPEC004"),
    ],
)
def test_a_file_of_another_kind(tmp_path: Path, name: str, text: str, code: str) -> None:
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    with pytest.raises(SpecError) as caught:
        load_document(str(path), is_spec=True)
    assert {item.code for item in caught.value.diagnostics} == {code}
