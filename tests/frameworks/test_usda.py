"""The real USD as the second reader of layers: the same prims, schemas, values and refusals."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from actspec.diagnostics import RobotError
from actspec.robot.read_usda import read_usda
from actspec.robot.usda import Asset, Value
from tests.frameworks.prepare import Frameworks
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

PROBE = Path(__file__).with_name("usda_probe.py")
ROOT = Path(__file__).resolve().parents[2]

SINGLE = 2.0**-24
"""Relative: USD has single precision where this reader has the text's."""

TAKEN = {
    **{text: within(text) for text in (*VALUES, *TARGETS, *NOT_READ)},
    **{text: within("", text) for text in SCHEMAS},
}
WRONG = {
    **{f"in a prim: {text}": within(text) for text in REFUSED},
    **{f"in a layer: {text}": HEAD + text for text in REFUSED_LAYERS},
}
OVERLAYS = sorted(str(path.relative_to(ROOT)) for path in ROOT.glob("tests/golden/*/newton/*.usda"))


@pytest.fixture(scope="module")
def said(frameworks: Frameworks) -> dict[str, Any]:
    """What USD says of all texts, and of what the robots compile to."""
    overlays = {name: (ROOT / name).read_text("utf-8") for name in OVERLAYS}
    found: dict[str, Any] = frameworks.run_probe(PROBE, {**TAKEN, **WRONG, **overlays}).said
    return found


def plain(value: Value) -> Any:
    """A value as the probe has it."""
    if isinstance(value, Asset):
        return {"asset": value.path}
    return [plain(item) for item in value] if isinstance(value, tuple) else value


def same(ours: Any, theirs: Any) -> bool:
    """Whether two values are one, but for USD's precision."""
    if isinstance(ours, list) and isinstance(theirs, list):
        return len(ours) == len(theirs) and all(map(same, ours, theirs))
    if isinstance(theirs, float) and isinstance(ours, int | float):
        # A whole number in a vector stays as it is written.
        return math.isclose(ours, theirs, rel_tol=SINGLE)
    return type(ours) is type(theirs) and bool(ours == theirs)


def differences(text: str, theirs: dict[str, Any]) -> list[str]:
    """Everything in which the reader differs from USD."""
    prims = read_usda(text.encode(), "a.usda").prims
    if list(prims) != list(theirs):
        return [f"prims {list(prims)}, USD has {list(theirs)}"]
    found = []
    for path, prim in prims.items():
        told = theirs[path]
        ours = {"specifier": prim.specifier, "type": prim.type, "apis": list(prim.apis)}
        found += [
            f"{path}: {key} {value}, USD has {told[key]}" for key, value in ours.items() if value != told[key]
        ]
        if prim.active and not told["active"]:
            found.append(f"{path}: USD has it switched off")
        values = {name: [a.type, plain(a.value)] for name, a in prim.attributes.items()}
        found += [
            f"{path}.{name}: {values.get(name)}, USD has {told['values'].get(name)}"
            for name in {**values, **told["values"]}
            if not same(values.get(name), told["values"].get(name))
        ]
    return found


@pytest.mark.parametrize("text", [text for text in TAKEN if text not in NOT_READ])
def test_what_usd_takes(text: str, said: dict[str, Any]) -> None:
    """Each kind of statement means what it means to USD."""
    assert said[text] is not None
    assert differences(TAKEN[text], said[text]) == []


@pytest.mark.parametrize("text", WRONG)
def test_what_usd_refuses(text: str, said: dict[str, Any]) -> None:
    """What the reader calls no text of USD is none to USD."""
    assert said[text] is None
    with pytest.raises(RobotError):
        read_usda(WRONG[text].encode(), "a.usda")


@pytest.mark.parametrize("text", NOT_READ)
def test_what_is_not_read_here(text: str, said: dict[str, Any]) -> None:
    """What the reader says that it does not read is text of USD."""
    assert said[text] is not None


@pytest.mark.parametrize("name", OVERLAYS)
def test_overlays_of_the_robots(name: str, said: dict[str, Any]) -> None:
    """Every prim, schema and number of what the robots' specs compile to."""
    text = (ROOT / name).read_text("utf-8")
    assert len(said[name]) > 20
    assert differences(text, said[name]) == []
