"""Fixtures that hand out MuJoCo releases."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from actspec.verify.environments import EngineUnavailableError
from tests.agree.engines import VERSIONS, Engine, parse

HERE = Path(__file__).parent

# The first release that needs a newer Python than actspec does.
NEEDS_PYTHON = {(4, 0, 0): (3, 11)}


def _engine(version: str) -> Engine:
    for since, python in NEEDS_PYTHON.items():
        if parse(version) >= since and sys.version_info < python:
            pytest.skip(f"mujoco {version} needs Python {'.'.join(map(str, python))}")
    try:
        return Engine.of(version)
    except EngineUnavailableError as err:
        # In CI a release that silently stops being tested is a failure.
        (pytest.fail if os.environ.get("CI") else pytest.skip)(f"mujoco cannot be had: {err}")


@pytest.fixture(scope="session")
def engine_of(forked: None) -> Callable[[str], Engine]:
    """Hand out a release by version; skips where it cannot be had."""
    return _engine


@pytest.fixture(scope="session", params=VERSIONS, ids=lambda version: f"mujoco-{version}")
def engine(request: pytest.FixtureRequest, forked: None) -> Engine:
    """Each release in turn."""
    return _engine(request.param)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what needs a release, so that `-m "not engine"` is quick and offline."""
    for item in items:
        if item.path.is_relative_to(HERE) and {"engine", "engine_of"} & set(
            getattr(item, "fixturenames", ())
        ):
            item.add_marker(pytest.mark.engine)
