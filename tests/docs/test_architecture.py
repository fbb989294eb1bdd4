"""docs/architecture.md names what there is: parts, files, and the functions of a compile in the order of the calls."""

from __future__ import annotations

import re
import sys
from pathlib import Path
from types import FrameType
from typing import Any

import pytest

from actspec.cli.main import main
from tests.meta.test_imports import LAYERS

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8")
WAY = [
    (file, name)
    for name, file in re.findall(r"^\| \[`([\w.]+)`\]\(\.\./(actspec/[\w/]+\.py)\) \|", PAGE, re.MULTILINE)
]


def test_the_way_of_a_number_is_the_one_that_a_compile_goes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Compiling the A1 calls the functions of the table, in its order; others between them."""
    assert len(WAY) > 30
    calls: list[tuple[str, str]] = []
    wanted = set(WAY)
    names: dict[Any, tuple[str, str]] = {}

    def note(frame: FrameType, event: str, argument: object) -> None:
        code = frame.f_code
        if event == "call" and code.co_filename.startswith(str(ROOT)):
            if code not in names:
                # Before Python 3.11 code has no qualified name: the class is that of `self`.
                owner = type(frame.f_locals["self"]).__name__ + "." if "self" in frame.f_locals else ""
                names[code] = (Path(code.co_filename).relative_to(ROOT).as_posix(), owner + code.co_name)
            if names[code] in wanted:
                calls.append(names[code])

    monkeypatch.chdir(ROOT)
    sys.setprofile(note)
    try:
        status = main(["compile", "robots/a1.yaml", "-t", "mujoco", "-o", str(tmp_path)])
    finally:
        sys.setprofile(None)
    capsys.readouterr()
    assert status == 0
    left = iter(calls)
    for step in WAY:
        assert step in left, f"{step[1]} of {step[0]} is not called where the page has it"


def test_the_line_is_that_of_the_spec() -> None:
    """The page begins with the line that robots/a1.yaml has."""
    (block,) = re.findall(r"```text\n( +kp:.*\n)```", PAGE)
    assert block in (ROOT / "robots" / "a1.yaml").read_text(encoding="utf-8")


def test_every_part_of_the_package_has_its_line() -> None:
    """The table of layers names each part that the test of imports knows, and no other."""
    table = PAGE[PAGE.index("## Layers") : PAGE.index("Outside the package")]
    named = re.findall(r"`([\w/.]+)`", "".join(re.findall(r"^\| (`[^|]*) \|", table, re.MULTILINE)))
    there = {path.name + ("/" if path.is_dir() else "") for path in (ROOT / "actspec").iterdir()}
    assert [name for name in named if name not in there] == []
    parts = {re.sub(r"/|\.py", "", name) for name in named}
    known = set().union(*LAYERS) - {"", "__main__"}
    assert parts == known


def test_files_that_the_page_names_are_there() -> None:
    """Paths of the package, of the tests and of the docs exist."""
    found = re.findall(r"`((?:actspec|tests|docs|templates|schemas|robots|benchmarks)/[\w/.]*)`", PAGE)
    assert len(found) > 12
    placeholders = ("CODE", "KIND", "SIMULATOR")
    assert [n for n in found if not any(p in n for p in placeholders) and not (ROOT / n).exists()] == []


def test_a_field_takes_ten_files_at_most() -> None:
    """The table of a new field lists no more."""
    table = PAGE[PAGE.index("### A field of a joint") :]
    assert len(re.findall(r"^\| `actspec/", table, re.MULTILINE)) <= 10
