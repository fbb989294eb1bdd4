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


GEARED = """actspec: 1
robot: {name: r, model: none, joints: [a]}
motors: {m: {side: joint, gear_ratio: 6, peak_torque: 12 N*m}}
actuators:
  g: {joints: [a], motor: m, level: ideal_pd, kp: 20 N*m/rad, kd: 0.5 N*m*s/rad, effort_limit: peak, @}
"""


@pytest.mark.parametrize(
    ("line", "message", "help"),
    [
        ("transmission: 9", "transmission: must be a list, got 9", "write `[{ratio: 9}]`"),
        ("transmission: '9:1'", "transmission: must be a list, got '9:1'", "write `[{ratio: 9}]`"),
        ("transmission: belt", "transmission: must be a list, got 'belt'", "write `[{ratio: ...}]`"),
        ("transmission: {ratio: 9}", "transmission: must be a list, got {ratio: 9}", "write `[{ratio: 9}]`"),
        ("transmission: [9]", "transmission[0]: must be a mapping, got 9", "write `{ratio: 9}`"),
        ("transmission: {}", "transmission: must be a list, got {}", None),
        ("reduction: {ratio: 9}", "reduction: must be a ratio, got {ratio: 9}", "write `9`"),
        ("reduction: [{ratio: 9}]", "reduction: must be a ratio, got [{ratio: 9}]", "write `9`"),
    ],
)
def test_a_stage_in_another_form(tmp_path: Path, line: str, message: str, help: str | None) -> None:
    """One message with what to write, which is right."""
    path = tmp_path / "r.yaml"
    path.write_text(GEARED.replace("@", line), encoding="utf-8")
    (found,) = said_of(path)
    assert f"{found.where}: {found.message}" == f"actuators.g.{message}"
    assert found.help == help
    key, _, given = line.partition(": ")
    if help is not None and "..." not in help:
        right = help.removeprefix("write ").strip("`")
        right = f"[{right}]" if given.startswith("[9") else right
        path.write_text(GEARED.replace("@", f"{key}: {right}"), encoding="utf-8")
        load_spec(str(path))


PLANETARY = "{planetary: {sun: 18, ring: 90}}"
TEETH = "{teeth: {driving: 20, driven: 32}}"


@pytest.mark.parametrize(
    ("field", "where", "right"),
    [
        ("gear_ratio: {sun: 18, ring: 90}", "gear_ratio", f"gearbox: [{PLANETARY}]"),
        (f"gear_ratio: {PLANETARY}", "gear_ratio", f"gearbox: [{PLANETARY}]"),
        ("gear_ratio: {driving: 20, driven: 32}", "gear_ratio", f"gearbox: [{TEETH}]"),
        ("planetary: {sun: 18, ring: 90}", "planetary", f"gearbox: [{PLANETARY}]"),
        ("teeth: {driving: 20, driven: 32}", "teeth", TEETH),
        ("belt: {driving: 20, driven: 32}", "belt", TEETH),
    ],
)
def test_teeth_in_place_of_a_ratio(tmp_path: Path, field: str, where: str, right: str) -> None:
    """One message with the stage to write, which is right."""
    path = tmp_path / "r.yaml"
    text = GEARED.replace(", @", "")
    path.write_text(text.replace("gear_ratio: 6", field), encoding="utf-8")
    (found,) = said_of(path)
    assert found.where == f"motors.m.{where}"
    assert f"`{right}`" in (found.help or "")
    right = right if right.startswith("gearbox") else f"gearbox: [{right}]"
    path.write_text(text.replace("gear_ratio: 6", right), encoding="utf-8")
    load_spec(str(path))
