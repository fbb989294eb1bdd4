"""The order in which several processes run the tests: each of them once."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from tests.ordering import FRAMEWORKS, parts


def file_of(path: Path, count: int, slow: bool = False) -> list[Any]:
    """Of one file; the last is slow."""
    return [
        SimpleNamespace(
            path=path, name=f"{path.name}::{i}", get_closest_marker=lambda _, i=i: slow and i == count - 1
        )
        for i in range(count)
    ]


@pytest.mark.parametrize("quick", [3, 50, 1000])
@pytest.mark.parametrize("count", [1, 2, 3, 8])
def test_each_test_stands_in_one_part(count: int, quick: int) -> None:
    """As many in each as xdist cuts off, where there are quick ones enough; slow files first, a simulator in one."""
    here = Path("here")
    items = [
        *file_of(here / "test_a.py", quick),
        *file_of(here / "test_slow.py", 4, True),
        *file_of(FRAMEWORKS / "test_mjlab.py", 30),
        *file_of(FRAMEWORKS / "test_playground.py", 2),
        *file_of(here / "test_slower.py", 5, True),
        *file_of(here / "test_slowest.py", 2, True),
        *file_of(here / "test_b.py", 7),
    ]
    found = parts(items, count)
    assert len(found) == count
    names = [item.name for part in found for item in part]
    assert Counter(names) == Counter(item.name for item in items)
    first = found[0]
    assert [item.name for item in first[:4]] == [f"test_slow.py::{i}" for i in range(4)]
    assert sum(item.path.name == "test_mjlab.py" for item in first) == 30
    if quick == 1000:
        assert max(map(len, found)) - min(map(len, found)) <= 1
    if count == 2:
        assert [item.name for item in found[1][:9]] == [
            *(f"test_slower.py::{i}" for i in range(5)), "test_slowest.py::0", "test_slowest.py::1",
            "test_playground.py::0", "test_playground.py::1",
        ]  # fmt: skip
