"""`actspec.mjlab` where mjlab cannot be used; tests/frameworks has it where it can."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

import pytest

from actspec.mjlab import articulation

A1 = Path(__file__).parents[3] / "robots" / "a1.yaml"


@pytest.mark.skipif(bool(find_spec("mjlab") and find_spec("torch")), reason="mjlab can be imported here")
def test_without_mjlab() -> None:
    """The error names the package that is missing, not a line of the emitted text."""
    with pytest.raises(ModuleNotFoundError, match=r"mjlab is (not )?installed here"):
        articulation(A1)
