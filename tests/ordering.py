"""Which test comes when in a run of several processes: long ones early, and one simulator in one process.

xdist's `worksteal` gives each process a part of the list, in its order, and one that is done takes from another's end.
So each part begins with files of slow tests, goes on with simulators, which `prepare` may still be fetching, and ends
with thousands of quick tests, which even the parts out. Without this, simulators stand in the middle of one part, a
second process steals them, and imports and runs each of them once more.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import pytest

FRAMEWORKS = Path(__file__).parent / "frameworks"
ALONE = {"test_playground.py", "test_mjlab_versions.py", "test_python_reader.py"}
"""Files of simulators that share no process with the others; see `forking`."""


def parts(items: Sequence[pytest.Item], count: int) -> list[list[pytest.Item]]:
    """The tests of each of `count` processes, as many as worksteal gives it, in their order."""
    files: dict[Path, list[pytest.Item]] = {}
    for item in items:
        files.setdefault(item.path, []).append(item)
    found: list[list[pytest.Item]] = [[] for _ in range(count)]
    simulators: list[list[pytest.Item]] = [[] for _ in range(count)]
    # The first has most of the simulators, and half as many slow files as another.
    turns = [*range(count), *range(1, count)]
    slow, quick = 0, []
    for path, tests in files.items():
        if path.parent == FRAMEWORKS:
            simulators[path.name in ALONE and count > 1] += tests
        elif any(item.get_closest_marker("slow") for item in tests):
            found[turns[slow % len(turns)]] += tests
            slow += 1
        else:
            quick += tests
    left = len(items)
    for number, part in enumerate(found):
        part += simulators[number]
        size = left // (count - number)
        # One that has too many gives them to the next: the list is cut by number alone.
        more = max(0, size - len(part))
        part += quick[:more]
        del quick[:more]
        left -= size
    return found


def order(items: list[pytest.Item]) -> None:
    """Sort what was collected, where several processes share it."""
    count = int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1"))
    if count > 1:
        items[:] = [item for part in parts(items, count) for item in part]
