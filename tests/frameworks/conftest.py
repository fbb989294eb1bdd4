"""The fixture that hands out the frameworks' environment."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from actspec.verify.environments import EngineUnavailableError
from tests.frameworks.prepare import PYTHONS, Frameworks, prepare

HERE = Path(__file__).parent


@pytest.fixture(scope="session")
def frameworks(forked: None) -> Frameworks:
    """The prepared environment, whose packages are imported once; skips where it cannot be had."""
    import sys

    try:
        made = prepare()
    except EngineUnavailableError as err:
        # In CI a framework that silently stops being tested is a failure, unless no release is for this Python.
        usable = PYTHONS[0] <= sys.version_info[:2] <= PYTHONS[1]
        (pytest.fail if os.environ.get("CI") and usable else pytest.skip)(f"no frameworks: {err}")
    return made


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark what needs the frameworks, so that `-m "not engine"` is quick and offline."""
    for item in items:
        if item.path.is_relative_to(HERE) and "frameworks" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.engine)
