"""USD's text form, read without USD: what it means, where it is, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import pytest

from actspec.diagnostics import RobotError, Span
from actspec.robot.read_usda import MAX_BYTES, MAX_DEPTH, MAX_ITEMS, MAX_NESTING, MAX_PATH, read_usda
from actspec.robot.usda import UsdaLayer
from tests.robot.usda_texts import (
    HEAD,
    NOT_READ,
    REFUSED,
    REFUSED_LAYERS,
    SCHEMAS,
    TARGETS,
    VALUES,
    within,
)


def read(text: str) -> UsdaLayer:
    """A layer of this text."""
    return read_usda(text.encode(), "a.usda")


def refused(text: str | bytes) -> str:
    """What is said against a text, without the file."""
    with pytest.raises(RobotError) as caught:
        read_usda(text if isinstance(text, bytes) else text.encode(), "a.usda")
    (found,) = caught.value.diagnostics
    return str(found).removeprefix("a.usda").removeprefix(":").strip()


@pytest.mark.parametrize("statement", VALUES)
def test_value(statement: str) -> None:
    """A statement gives its attribute the value that USD gives it."""
    found = read(within(statement)).prims["/a"].attributes["x"].value
    assert (found, type(found)) == (VALUES[statement], type(VALUES[statement]))


def test_not_a_number() -> None:
    """`nan` is a number, and equals none."""
    found = read(within("float x = nan")).prims["/a"].attributes["x"].value
    assert isinstance(found, float) and math.isnan(found)


@pytest.mark.parametrize("statement", REFUSED)
def test_refused(statement: str) -> None:
    """What USD does not take is refused, with the line."""
    assert "USDA001" in refused(within(statement))


@pytest.mark.parametrize("text", REFUSED_LAYERS)
def test_refused_layer(text: str) -> None:
    """So is a layer of a wrong build."""
    assert "USDA001" in refused(HEAD + text)


@pytest.mark.parametrize("statement", NOT_READ)
def test_not_read(statement: str) -> None:
    """What USD has a meaning for and this reader has not is said, and not passed over."""
    assert refused(within(statement)) == NOT_READ[statement]


@pytest.mark.parametrize("metadata", SCHEMAS)
def test_schemas(metadata: str) -> None:
    """Edits of the list of schemas come out as in USD: the last of each kind, deletions for weaker layers only."""
    assert read(within("", metadata)).prims["/a"].apis == SCHEMAS[metadata]


@pytest.mark.parametrize("statement", TARGETS)
def test_targets(statement: str) -> None:
    """A relationship's paths are from the root on."""
    assert read(within(statement)).prims["/a"].attributes["r"].value == TARGETS[statement]


def test_prims() -> None:
    """Prims in the file's order, with specifier, type and place; below one that is switched off all are off."""
    layer = read(
        '#usda 1.0 \n# one\n#two  \n(\n    subLayers = [@b.usda@]\n)\n# three\nover "a"\n{\n'
        '    def Scope "b" (\n        active = false\n        inherits = </c>\n    )\n    {\n'
        '        def NewtonActuator "関節" {\n        }\n    }\n    class "c" {}\n}\ndef "d" {}'
    )
    found = [(p.path, p.specifier, p.type, p.active, p.span.line, p.name) for p in layer.prims.values()]
    assert found == [
        ("/a", "over", "", True, 8, "a"),
        ("/a/b", "def", "Scope", False, 10, "b"),
        ("/a/b/関節", "def", "NewtonActuator", False, 15, "関節"),
        ("/a/c", "class", "", True, 18, "c"),
        ("/d", "def", "", True, 20, "d"),
    ]
    assert layer.head == ("one", "two")
    assert layer.unfollowed == (
        ("subLayers", Span("a.usda", 5, 5)),
        ("inherits", Span("a.usda", 12, 9)),
    )


def test_place() -> None:
    """An attribute is where its statement begins, the second one on a line too."""
    attributes = read(within("    float x = 1; custom float n:y = 2")).prims["/a"].attributes
    assert {name: (a.span.line, a.span.column) for name, a in attributes.items()} == {
        "x": (3, 5),
        "n:y": (3, 18),
    }


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "1: USDA001: a layer in text form begins with '#usda 1.0', got ''"),
        ("<mujoco/>", "1: USDA001: a layer in text form begins with '#usda 1.0', got '<mujoco/>'"),
        ("#usda 2.0\n", "1: USDA002: a version that is not known: '#usda 2.0'\n  help: known: 1.0, 1.1"),
        (
            b"PXR-USDC\0\0",
            "USDA002: a binary layer of USD, and only its text form is read\n"
            "  help: write it as text, e.g. with usdcat -o FILE.usda",
        ),
        (
            b"PK\x03\x04",
            "USDA002: a package of USD, and only its text form is read\n"
            "  help: write it as text, e.g. with usdcat -o FILE.usda",
        ),
        (HEAD.encode() + b'\ndef "\xff', "3: USDA001: the file is not UTF-8: byte 0xff"),
        (within("float x = two"), "3:11: USDA001: a value belongs here, got 'two'"),
        (within('int x = "2"'), "3:9: USDA001: x is of type int, got 2"),
        (within("float x = 1 2"), "3:13: USDA001: a new line belongs here, got '2'"),
        (within('string x = "a'), "3:12: USDA001: a string that does not end"),
        (within("float x = 1\nint x = 2"), "4:5: USDA001: x is of type int here and float in line 3"),
        (within('def "b" {}\nover "b" {}'), "4:6: USDA001: the layer has the prim /a/b already"),
        (
            within('def "b c" {}'),
            "3:5: USDA001: 'b c' is no name of a prim\n  help: a name has letters, digits and _",
        ),
        (within("rel r = <../../b>"), "3:9: USDA001: <../../b> is no path of a prim or property"),
        (HEAD + 'def "a" {', "2:10: USDA001: an attribute, a prim or '}' belongs here, got the end of the file"),
    ],
    ids=lambda value: repr(value)[:24],
)  # fmt: skip
def test_message(text: str | bytes, message: str) -> None:
    """What is wrong is said with its place, and what would be right where that is known."""
    assert refused(text) == message


HOSTILE: dict[str, Any] = {
    "large": (HEAD + "#" * MAX_BYTES, f"bytes, more than {MAX_BYTES}"),
    "deep": (HEAD + 'def "a" {\n' * (MAX_DEPTH + 1), f"prims are nested deeper than {MAX_DEPTH}"),
    "nested": (within("float3 x = " + "(" * 9999), f"values are nested deeper than {MAX_NESTING}"),
    "nested metadata": (HEAD + "(a = " + "[" * 9999, f"values are nested deeper than {MAX_NESTING}"),
    "many": (HEAD + "".join(f'def "a{k}" {{}}\n' for k in range(MAX_ITEMS + 1)), f"more than {MAX_ITEMS}"),
    "many paths": (within(f"rel r = [{', '.join(f'<b{k}>' for k in range(MAX_ITEMS))}]"), f"more than {MAX_ITEMS}"),
    "long path": (HEAD + f'def "{"a" * MAX_PATH}" {{}}', f"a path of more than {MAX_PATH}"),
    "quotes": (HEAD + '"' + "\\a" * 400_000, "a string that does not end"),
    "remarks": (HEAD + "/*" + "*/ /*" * 200_000, "a remark that does not end"),
    "names": (within("float " + "a:" * 400_000), "a new line belongs here"),
    "ups": (within(f"rel r = <{'../' * 300_000}x>"), "is no path"),
}  # fmt: skip


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile(name: str) -> None:
    """What is larger or deeper than any overlay is refused, and no text makes the reader stand still or break."""
    text, message = HOSTILE[name]
    assert message in refused(text)


def test_limits_themselves_are_taken() -> None:
    """What is as deep as is read is read, and nothing deeper."""
    text = HEAD + 'def "a" {\n' * MAX_DEPTH + "}\n" * MAX_DEPTH
    assert len(read(text).prims) == MAX_DEPTH
    for more in (0, 1):
        text = within("opaque x = " + "(" * (MAX_NESTING + more) + "1" + ")" * (MAX_NESTING + more))
        if more:
            assert "nested deeper" in refused(text)
        else:
            assert read(text).prims["/a"].attributes["x"].value is not None


def test_long_numbers() -> None:
    """A number of any length is read: an integer beyond its type is refused, a float is infinite."""
    assert read(within("float x = " + "9" * 5000)).prims["/a"].attributes["x"].value == math.inf
    assert "int" in refused(within("int x = " + "9" * 5000))
