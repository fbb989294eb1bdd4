"""Codes of a verification are explained, and there are no others."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from actspec.verify.engines.asking import PROBES
from actspec.verify.environments import SHARED

ROOT = Path(__file__).resolve().parents[2]


def test_every_code_is_explained() -> None:
    """docs/verify.md has a row for each code that the source gives, and for no other."""
    sources = "".join(
        path.read_text("utf-8")
        for folder in ("verify", "cli")
        for path in sorted((ROOT / "actspec" / folder).rglob("*.py"))
    )
    given = set(re.findall(r'"(VFY\d{3})"', sources))
    page = (ROOT / "docs" / "verify.md").read_text("utf-8")
    assert set(re.findall(r"^\| (VFY\d{3}) \|", page, re.MULTILINE)) == given


@pytest.mark.parametrize("probe", [*sorted(PROBES.glob("*.py")), *SHARED], ids=lambda path: path.stem)
def test_probes_know_nothing_of_actspec(probe: Path) -> None:
    """What runs in a simulator's environment imports no module of actspec: an agreement is one of two programs."""
    names = [
        name
        for node in ast.walk(ast.parse(probe.read_text("utf-8")))
        for name in (
            [alias.name for alias in node.names]
            if isinstance(node, ast.Import)
            else [node.module or ""]
            if isinstance(node, ast.ImportFrom)
            else []
        )
    ]
    assert names and not [name for name in names if name.split(".")[0] == "actspec"]
