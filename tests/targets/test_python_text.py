"""Python text from a stranger's words and numbers."""

from __future__ import annotations

import ast
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from actspec.targets.kit.python_text import comment_lines, identifier, joint_patterns, py
from tests.fitting import joint, spec_of


@pytest.mark.parametrize(
    "value, text",
    [
        (25.0, "25.0"),
        (0.5, "0.5"),
        (1e-5, "1e-05"),
        (-0.0, "0.0"),
        (0.1 + 0.2, "0.3"),
        (np.float64(2.5), "2.5"),
        (3, "3"),
        (True, "True"),
        (None, "None"),
        ("a", '"a"'),
        ("it's", '"it\'s"'),
        ('"', "'\"'"),
        ([0, 2], "[0, 2]"),
        ((1.0,), "(1.0,)"),
        ({".*_hip": 1.0}, '{".*_hip": 1.0}'),
    ],
    ids=repr,
)
def test_literals(value: Any, text: str) -> None:
    """Numbers are short, text is in double quotes where that needs no escape."""
    assert py(value) == text


@pytest.mark.parametrize(
    "value", [float("inf"), float("nan"), object(), np.arange(2)], ids=lambda v: type(v).__name__
)
def test_what_has_no_literal(value: object) -> None:
    """A number that is not finite would be a name that nobody imported."""
    with pytest.raises(ValueError):
        py(value)


@pytest.mark.parametrize(
    "text", ["\\", "'\"", '"""', "\n", "\u2028", "\x00", "{{ x }}", "é", "\ud800", "\\N{DIGIT ONE}"]
)
def test_text_comes_back(text: str) -> None:
    """A literal is what it was, whatever it is, on one line."""
    literal = py(text)
    assert ast.literal_eval(literal) == text
    assert len(literal.splitlines()) == 1


@pytest.mark.parametrize(
    "name, found",
    [
        ("unitree_a1", "unitree_a1"),
        ("Go-1 (v2)", "Go_1_v2"),
        ("2legs", "robot_2legs"),
        ("class", "robot_class"),
        ("é", "robot"),
    ],
)
def test_identifiers(name: str, found: str) -> None:
    """Any name becomes an ASCII identifier that is no keyword."""
    assert identifier(name) == found


def test_comments_end_nowhere() -> None:
    """A comment holds its text on `#` lines of at most 120 columns, hung where it goes on."""
    lines = comment_lines(
        "  a: " + "word " * 60 + "\nimport os\r\x0c\u2028x = 1", indent="    ", hang="      "
    )
    assert all(line.startswith("    # ") and len(line) <= 120 for line in lines)
    assert lines[1].startswith("    #       word")
    assert len("\n".join(lines).splitlines()) == len(lines)


@pytest.mark.parametrize(
    "patterns, wanted, names, found",
    [
        ([".*_hip"] * 2, ["a_hip", "b_hip"], ["a_hip", "b_hip", "knee"], (".*_hip",)),
        ([".*"], ["a_hip"], ["a_hip", "knee"], ("a_hip",)),
        ([".*_hip", ".*"], ["a_hip", "knee"], ["a_hip", "knee"], (".*_hip", "knee")),
        (["a.b"], ["a.b"], ["a.b", "axb"], (r"a\.b",)),
        (["a.b"], ["a.b"], ["a.b"], ("a.b",)),
    ],
    ids=["author-s", "reaches-too-far", "overlap", "escaped", "exact"],
)
def test_patterns(patterns: list[str], wanted: list[str], names: list[str], found: tuple[str, ...]) -> None:
    """All joints are matched by exactly one pattern, and no other joint by any."""
    base = joint(
        spec_of(
            "legs: {joints: [hip], level: ideal_pd, kp: 1 N*m/rad, kd: 0 N*m*s/rad}, "
            "rest: {joints: [calf, slide], level: ideal_pd, kp: unknown, kd: unknown}"
        )
    )
    actuators = [replace(base, joint=j, pattern=p) for j, p in zip(wanted, patterns, strict=True)]
    got = joint_patterns(actuators, names)
    assert got == found
    for name in names:
        assert sum(re.fullmatch(p, name) is not None for p in got) == (name in wanted)
