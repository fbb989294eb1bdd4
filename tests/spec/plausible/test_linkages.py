"""Linkages: a row that does not fit the others, a pose that no joint has, a limit that the robot's file contradicts."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.diagnostics import Diagnostic
from actspec.resolution import resolve
from actspec.robot.load import joints_of_text
from actspec.spec.document import document_from_text
from actspec.spec.plausible import BY_CODE
from actspec.spec.validate import validate

ROWS = (("-2.5", "-39.4"), ("-2", "-63.4"), ("-1.5", "-75.2"), ("-1", "-68.2"), ("-0.5", "-40.4"))
"""As the knee of Spot: position [rad] and motor speed per joint speed."""
URDF = """<robot name="leg"><link name="a"/><link name="b"/><link name="c"/>
  <joint name="knee" type="revolute"><parent link="a"/><child link="b"/>
    <limit lower="-2.8" upper="-0.2" effort="{effort}" velocity="12"/></joint>
  <joint name="roll" type="revolute"><parent link="b"/><child link="c"/>
    <limit lower="-1" upper="1" effort="{effort}" velocity="12"/></joint>
</robot>
"""


def said(folder: Path, linkage: str, effort: float = 113) -> list[Diagnostic]:
    """What is said of a linkage whose motors have 1.5 N*m."""
    path = folder / "leg.urdf"
    path.write_text(URDF.format(effort=effort), encoding="utf-8")
    text = (
        "actspec: 1\nrobot: {name: leg, model: leg.urdf, default_pose: {knee: -1.5 rad}}\n"
        "motors: {m: {side: joint, peak_torque: 1.5 N*m, continuous_torque: unknown}}\n"
        f"linkages: {{l: {linkage}}}\n"
        "actuators: {leg: {joints: [.*], level: ideal_pd, kp: 60, kd: 1.5}}\n"
    )
    spec = validate(document_from_text(text, str(folder / "s.yaml")))
    return [item for item in resolve(spec, joints_of_text(str(path))).diagnostics if item.code in BY_CODE]


def table(**wrong: str) -> str:
    """The table with other entries: `y2` is the Jacobian of the third row, `x2` its pose."""
    rows = [(wrong.get(f"x{i}", x), wrong.get(f"y{i}", y)) for i, (x, y) in enumerate(ROWS)]
    text = ", ".join(f"{{at: [{x} rad], jacobian: [[{y}]]}}" for x, y in rows)
    # `roll` has a linkage of its own, so that every joint has a motor.
    return (
        f"{{joints: [knee], motors: [m], table: [{text}]}}, r: {{joints: [roll], motors: [m], factor: 75.3}}"
    )


@pytest.mark.parametrize(
    ("wrong", "place", "help"),
    [
        ({"y2": "-752"}, "table[2].jacobian[0][0]", "did you mean -75.2?"),
        ({"y2": "-7.52"}, "table[2].jacobian[0][0]", "did you mean -75.2?"),
        ({"y2": "75.2"}, "table[2].jacobian[0][0]", "did you mean -75.2?"),
        ({"y0": "-394"}, "table[0].jacobian[0][0]", "did you mean -39.4?"),
        # -75.2, -68.2: -61.2 would follow.
        ({"y4": "40.4"}, "table[4].jacobian[0][0]", "did you mean -40.4?"),
        # -85.9 deg is -1.499 rad.
        ({"x2": "-85.9"}, "table[2].at[0]", "is it in deg? Then write -85.9 deg, -1.499 rad"),
        ({"x2": "1.5"}, "table[2].at[0]", "is the sign wrong? Then it is -1.5 rad"),
        ({"x3": "-10"}, "table[3].at[0]", "did you mean -1 rad?"),
        # In order, and outside of the joint's range.
        ({"x4": "0.5"}, "table[4].at[0]", "is the sign wrong? Then it is -0.5 rad"),
    ],
)
def test_a_row_that_does_not_fit(tmp_path: Path, wrong: dict[str, str], place: str, help: str) -> None:
    (found,) = said(tmp_path, table(**wrong))
    assert (found.code, found.where, found.help) == ("SPEC195", f"linkages.l.{place}", help)


@pytest.mark.parametrize(
    "wrong",
    [
        {},
        # To a dead point, and past it: -7 follows from -24.6 and -15.8.
        {"y2": "-33.4", "y3": "-15.8", "y4": "-1.6"},
        {"y2": "-33.4", "y3": "-15.8", "y4": "2"},
        # Steep, and no power of ten.
        {"y2": "-200"},
        # In no order, but one that a slip would not mend.
        {"x0": "-1.2"},
    ],
)
def test_a_table_that_may_be_meant(tmp_path: Path, wrong: dict[str, str]) -> None:
    # 200 x 1.5 N*m are 2.7 times the file's, 33.4 of it 0.44.
    assert said(tmp_path, table(**wrong)) == []


def test_three_rows_tell_nothing(tmp_path: Path) -> None:
    rows = "{at: [-2 rad], jacobian: [[-60]]}, {at: [-1.5 rad], jacobian: [[75]]}, {at: [-1 rad], jacobian: [[-60]]}"
    linkage = (
        f"{{joints: [knee], motors: [m], table: [{rows}]}}, r: {{joints: [roll], motors: [m], factor: 75.3}}"
    )
    assert said(tmp_path, linkage) == []


@pytest.mark.parametrize(
    ("sign", "told"),
    [
        # 1 x -0.6 - 0.6 x 1 = -1.2 at each pose; with 0.6 below it is 0.6 - 0.6 x 1 = 0: 0.8 makes 0.2.
        ("-0.6", False),
        ("0.8", True),
    ],
)
def test_a_pose_of_the_other_hand(tmp_path: Path, sign: str, told: bool) -> None:
    rows = [f"{{at: [{x} rad, 0 rad], jacobian: [[1, 0.6], [1, {y}]]}}" for x, y in (
        ("-2", "-0.6"), ("-1.5", "-0.6"), ("-1", sign), ("-0.5", "-0.6"),
    )]  # fmt: skip
    linkage = f"{{joints: [knee, roll], motors: [m, m], table: [{', '.join(rows)}]}}"
    found = said(tmp_path, linkage, effort=3.5)
    assert [item.where for item in found] == ["linkages.l.table[2].jacobian"] * told


@pytest.mark.parametrize(
    ("factor", "effort", "told"),
    [
        # 2 x 1.5 N*m x 100 = 300 of the file's 3.
        ("100", 3, True),
        ("10", 3, True),
        ("1", 3, False),
        # 5.5 times, and no power of ten; a placeholder.
        ("5.5", 3, False),
        ("100", 10, False),
    ],
)
def test_a_factor_against_the_file(tmp_path: Path, factor: str, effort: float, told: bool) -> None:
    found = said(tmp_path, f"{{joints: [knee, roll], motors: [m, m], factor: {factor}}}", effort)
    assert [item.where for item in found] == ["linkages.l.factor"] * told
    for item in found:
        assert item.message.startswith("knee: ")
        # It may be the motor's torque: both places are named.
        assert (
            item.help == f"look at the factor here, or the torque of the motor ({tmp_path / 's.yaml'}:3:40)"
        )


@pytest.mark.parametrize(
    ("factors", "place", "help"),
    [
        # 1.5 N*m x 2 of the file's 3; times 10 it is 30 at one joint, or at both.
        (("2", "2"), "", ""),
        (
            ("20", "2"),
            "linkages.l.factor",
            "look at the factor here: other linkages of this motor agree with the file",
        ),
        # A gear that is counted twice, no power of ten: 1.5 N*m x 32 = 48 of the file's 3.
        (
            ("32", "2"),
            "linkages.l.factor",
            "look at the factor here: other linkages of this motor agree with the file",
        ),
        # 1.5 N*m x 12 = 18 and 1.5 x 5 = 7.5: no linkage agrees.
        (("12", "12"), "", ""),
        (("12", "5"), "", ""),
        (("20", "20"), "motors.m.peak_torque", "look at the torque here, or at the linkages l, r ("),
    ],
)
def test_a_motor_of_several_linkages(tmp_path: Path, factors: tuple[str, str], place: str, help: str) -> None:
    one, two = factors
    linkages = (
        f"{{joints: [knee], motors: [m], factor: {one}}}, r: {{joints: [roll], motors: [m], factor: {two}}}"
    )
    found = said(tmp_path, linkages, effort=3)
    assert [item.where for item in found] == [place] * bool(place)
    assert all((item.help or "").startswith(help) for item in found)
