"""Shipped files are found in an installation and in a checkout, and nothing else is."""

from __future__ import annotations

import importlib.util
import shutil
from pathlib import Path
from types import ModuleType

import pytest

from actspec import resources as original


@pytest.fixture
def resources(tmp_path: Path) -> ModuleType:
    """The module, in a package folder of its own; the folder's parent is not a checkout yet."""
    folder = tmp_path / "actspec"
    (folder / "_data" / "robots").mkdir(parents=True)
    (tmp_path / "robots").mkdir()
    copy = shutil.copy(original.__file__, folder)
    spec = importlib.util.spec_from_file_location("resources_elsewhere", copy)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_installed_file_comes_first(resources: ModuleType, tmp_path: Path) -> None:
    """Where both have a file, the installed one is meant; what only the checkout has is found there."""
    installed = tmp_path / "actspec" / "_data" / "robots"
    (tmp_path / "pyproject.toml").touch()
    (tmp_path / "robots" / "a1.yaml").touch()
    (tmp_path / "robots" / "b2.yaml").touch()
    (installed / "a1.yaml").touch()
    assert resources.data_path("robots", "a1.yaml") == installed / "a1.yaml"
    assert resources.data_path("robots", "b2.yaml") == tmp_path / "robots" / "b2.yaml"
    assert resources.data_path("robots") == installed


def test_site_packages_is_no_checkout(resources: ModuleType, tmp_path: Path) -> None:
    """A folder of the same name beside an installed package is somebody else's."""
    (tmp_path / "robots" / "a1.yaml").touch()
    with pytest.raises(
        FileNotFoundError, match=r"^robots/a1\.yaml is not part of this actspec installation$"
    ):
        resources.data_path("robots", "a1.yaml")


@pytest.mark.parametrize("name", ["../pyproject.toml", "a1/../../x", "/etc/hosts", "..\\x", "C:x"])
def test_names_stay_inside(resources: ModuleType, tmp_path: Path, name: str) -> None:
    """A name that leaves the folder is refused before anything is looked for."""
    (tmp_path / "pyproject.toml").touch()
    with pytest.raises(ValueError, match="is not a path inside the folder"):
        resources.data_path("robots", name)
