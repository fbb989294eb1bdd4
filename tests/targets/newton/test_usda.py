"""USD's text form: what strangers' names and words become in it."""

from __future__ import annotations

import pytest

from actspec.targets.newton.usda import (
    Prim,
    UsdAttribute,
    asset,
    is_identifier,
    prim_lines,
    prim_path,
    string,
)


@pytest.mark.parametrize(
    ("text", "literal"),
    [
        ("a", '"a"'),
        ('a"b', r'"a\"b"'),
        ("a\\b", r'"a\\b"'),
        ('\\"', r'"\\\""'),
        ("a\nb", r'"a\\nb"'),
        ("ü", '"ü"'),
    ],
)
def test_string(text: str, literal: str) -> None:
    """Quotes and backslashes are escaped, a line break is written out."""
    assert string(text) == literal


@pytest.mark.parametrize(
    ("name", "path"),
    [
        ("net.onnx", "@./net.onnx@"),
        ("a@b.onnx", "@@@./a@b.onnx@@@"),
        ("a@@@b.onnx", r"@@@./a\@@@b.onnx@@@"),
        ("a\nb.onnx", r"@./a\nb.onnx@"),
    ],
)
def test_asset(name: str, path: str) -> None:
    """An @ in a file's name does not end the path."""
    assert asset(name) == path


def test_paths() -> None:
    """Names as USD takes them, letters of any script included; nothing else."""
    assert prim_path("/World/Robot_1") == ("World", "Robot_1")
    assert prim_path("/関節/b") == ("関節", "b")
    assert [prim_path(text) for text in ("World", "/a//b", "/a/../b", "/a b", "/1a", "/a}", "")] == [None] * 7
    assert is_identifier("left_hip_2") and not is_identifier("左") and not is_identifier("a-b")


def test_prims_are_nested() -> None:
    """Prims below each other share the overs on the way; words of strangers stay behind their #."""
    note = 'N*m\n}\ndef Scope "evil" {}'
    prims = [
        Prim(("a", "b"), apis=("X", "Y"), attributes=(UsdAttribute("float", "n:x", "1.0", note),)),
        Prim(("a", "b", "c"), specifier="def Scope", comments=("one\ntwo",)),
        Prim(("a", "d"), active=False),
    ]
    assert list(prim_lines(prims)) == [
        "",
        'over "a"',
        "{",
        '    over "b" (',
        '        prepend apiSchemas = ["X", "Y"]',
        "    )",
        "    {",
        '        float n:x = 1.0  # N*m\\n}\\ndef Scope "evil" {}',
        "",
        "        # one\\ntwo",
        '        def Scope "c"',
        "        {",
        "        }",
        "    }",
        "",
        '    over "d" (',
        "        active = false",
        "    )",
        "    {",
        "    }",
        "}",
    ]
