"""What `actspec import` writes of published robots draws no doubt about a number."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from actspec import api
from actspec.cli.main import main
from actspec.spec.plausible import BY_CODE

ROOT = Path(__file__).resolve().parents[2]
CORPUS = Path(os.environ.get("ACTSPEC_CORPUS", ROOT.parent / "shared" / "corpus"))
FILES = sorted(path for path in CORPUS.rglob("*") if path.suffix in (".xml", ".urdf"))

pytestmark = [pytest.mark.slow, pytest.mark.skipif(not FILES, reason="no corpus of real robot files")]


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(CORPUS)))
def test_an_import_is_sound(path: Path, tmp_path: Path) -> None:
    spec = tmp_path / "robot.yaml"
    if main(["import", str(path), "-o", str(spec)]) != 0:
        pytest.skip("no robot")
    assert [str(item) for item in api.resolve(spec).diagnostics if item.code in BY_CODE] == []
