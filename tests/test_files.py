"""Where a path that a stranger wrote leads."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from actspec.files import leads_into


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """`robots/leg.xml`, `robots-old/leg.xml` beside it, and links from the one to the other."""
    for folder in ("robots", "robots-old"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "leg.xml").touch()
    (tmp_path / "robots" / "far").symlink_to(tmp_path / "robots-old")
    (tmp_path / "robots" / "far.xml").symlink_to(tmp_path / "robots-old" / "leg.xml")
    (tmp_path / "robots" / "loop").symlink_to("loop")
    (tmp_path / "robots" / "same.xml").symlink_to("leg.xml")
    (tmp_path / "way").symlink_to("robots")
    monkeypatch.chdir(tmp_path)
    return Path(os.path.realpath(tmp_path))


@pytest.mark.parametrize(
    "path",
    [
        "robots/leg.xml",
        "robots/same.xml",
        "way/leg.xml",
        "robots/gone/leg.xml",
        "robots-old/../robots/leg.xml",
    ],
)
def test_what_is_in_a_folder(tree: Path, path: str) -> None:
    assert leads_into(path, [str(tree / "robots")])
    assert leads_into(path, [str(tree / "nowhere"), str(tree / "robots")])


@pytest.mark.parametrize(
    "path",
    [
        "robots",
        ".",
        "robots/../robots-old/leg.xml",
        "robots-old/leg.xml",
        "robots/far/leg.xml",
        "robots/far/../robots-old/leg.xml",
        "robots/far.xml",
        "/etc/hostname",
        "robots/\0.xml",
    ],
)
def test_what_is_not(tree: Path, path: str) -> None:
    """A folder is not in itself; one that only begins with the same letters is another; `..` counts behind a link."""
    assert not leads_into(path, [str(tree / "robots")])


def test_a_root_that_is_a_link(tree: Path) -> None:
    """Roots are real: what is named by a link is for the caller to follow, or not."""
    assert not leads_into("robots/leg.xml", [str(tree / "way")])
    assert leads_into("robots/leg.xml", [os.sep])
