"""One slip of the hand in a spec that is right gives one message, and that names the slip."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

from actspec.diagnostics import Diagnostic, SpecError
from actspec.spec.validate import load_spec

ROBOTS = Path(__file__).parents[2] / "robots"
SPECS = sorted(path.name for path in ROBOTS.glob("*.yaml"))
_HEADER = re.compile(r"([a-z]+):\s*(?:#.*)?")


def said_of(path: Path) -> tuple[Diagnostic, ...]:
    """The errors of a spec that must have some."""
    with pytest.raises(SpecError) as caught:
        load_spec(str(path))
    return caught.value.diagnostics


@pytest.fixture
def copied(tmp_path: Path) -> Path:
    """A folder with the motors that the robots include."""
    shutil.copytree(ROBOTS / "motors", tmp_path / "motors")
    return tmp_path


@pytest.mark.parametrize("name", SPECS)
def test_a_lost_header_is_told_once(name: str, copied: Path) -> None:
    """Without the line of a section, the one message stands at the first line below it and names the section."""
    lines = (ROBOTS / name).read_text(encoding="utf-8").split("\n")
    headers = [(number, found[1]) for number, line in enumerate(lines) if (found := _HEADER.fullmatch(line))]
    assert "actuators" in dict(map(reversed, headers))
    for number, section in headers:
        file = copied / name
        file.write_text("\n".join(lines[:number] + lines[number + 1 :]), encoding="utf-8")
        (item,) = said_of(file)
        if item.code == "SPEC006":
            # The G1 has a linkage and a group of one name.
            assert (name, section) == ("g1.yaml", "actuators")
            assert "line of the section" in str(item.help)
            continue
        below = next(
            line for line in range(number, len(lines)) if lines[line + 1].lstrip().split("#")[0].strip()
        )
        assert item.span is not None and item.span.line == below + 1, section
        assert f"the line `{section}:` is missing above" in item.message
