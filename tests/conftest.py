"""Options of the whole test suite."""

from __future__ import annotations

import gc
import os
import re
import sys
from collections.abc import Iterator
from importlib import metadata
from itertools import count
from pathlib import Path

import pytest

from actspec.processes import IsolatedCall, Pool
from actspec.robot.usda import read_usda
from tests.frameworks.forking import forking
from tests.frameworks.prepare import RELEASES
from tests.in_process import in_process
from tests.ordering import order
from tests.remembering import remembering

# Processes of the run share the cores: threads would wait for each other, and burn the time. Before numpy is there.
os.environ.setdefault("OMP_NUM_THREADS", "1")

MJLAB = RELEASES["mjlab"][0]
"""The release whose robots the tests read."""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--regen", action="store_true", help="write golden files and error texts anew")


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Behind what leaves some out."""
    order(items)


def pytest_collection() -> None:
    """Ten thousand tests are no garbage: who looks for some need not walk through them each time."""
    gc.disable()


def pytest_collection_finish() -> None:
    """From here on there is some, but not among them."""
    gc.collect()
    gc.freeze()
    gc.enable()


FOLDERS = count()


@pytest.fixture
def tmp_path(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of the test's own. pytest's looks through those of all tests before it for the next free name."""
    name = re.sub(r"\W", "_", request.node.name)[:20]
    path = tmp_path_factory.getbasetemp() / f"{name}_{next(FOLDERS)}"
    path.mkdir(mode=0o700)
    return path


@pytest.fixture(scope="session")
def mjlab_installed() -> Iterator[Path]:
    """Folder that holds the mjlab distribution: this environment's, else its wheel, unpacked, on sys.path.

    Nothing of it is imported: actspec finds its models by the distribution's list of files.
    """
    from actspec.verify.environments import EngineUnavailableError, prepare_release

    try:
        found = metadata.distribution("mjlab")
    except metadata.PackageNotFoundError:
        pass
    else:
        if found.version == MJLAB:
            yield Path(str(found.locate_file("")))
            return
    try:
        folder = prepare_release("mjlab", MJLAB)
    except EngineUnavailableError as err:
        # In CI robots that silently stop being tested are a failure.
        (pytest.fail if os.environ.get("CI") else pytest.skip)(f"mjlab cannot be had: {err}")
    sys.path.insert(0, str(folder))
    yield folder
    sys.path.remove(str(folder))


@pytest.fixture(scope="session")
def forked() -> Iterator[None]:
    """Probes of simulators are forks of processes that have imported them."""
    with forking():
        yield


@pytest.fixture(scope="session", autouse=True)
def _in_process() -> Iterator[None]:
    """Files are read in this process, and references remembered: see the files of these names."""
    with in_process(), remembering():
        yield


@pytest.fixture
def processes(monkeypatch: pytest.MonkeyPatch) -> None:
    """Files are read in other processes, as users have it."""
    monkeypatch.setattr("actspec.readings.named.Pool", Pool)
    monkeypatch.setattr("actspec.audit.fix.IsolatedCall", IsolatedCall)
    monkeypatch.setattr("actspec.verify.readback.read_usda", read_usda)
