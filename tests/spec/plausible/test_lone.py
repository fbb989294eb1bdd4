"""Figures of joints without a motor, and gains that stand alone: the odd one is told, and none that is right."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from actspec.cli.main import main
from tests.fitting import spec_of
from tests.spec.plausible.test_bounds import REST, said

MOTOR = "{m: {side: joint, stall_torque: 40, no_load_speed: 25 rad/s}}"
FIGURES = {
    "kp": "40 N*m/rad",
    "kd": "1 N*m*s/rad",
    "effort_limit": "40 N*m",
    "velocity_limit": "25 rad/s",
    "armature": "0.01 kg*m^2",
    "friction": "{coulomb: 0.3 N*m, viscous: 0.05 N*m*s/rad}",
}
"""Of a leg, sound: 1 kW, 4000 rad/s^2, an error of 1 rad, kd over kp 25 ms."""
SLIDE = {
    "kp": "5000 N/m",
    "kd": "200 N*s/m",
    "effort_limit": "200 N",
    "velocity_limit": "0.5 m/s",
    "armature": "2 kg",
    "friction": "{coulomb: 5 N, viscous: 10 N*s/m}",
}
HINGE = (
    '<mujoco><worldbody><body><joint name="hip" axis="0 1 0"/><geom type="sphere" size=".1" mass="1"/>'
    '<body><joint name="calf" axis="0 1 0"/><geom size=".1" mass="1"/>'
    '<body><joint name="slide" type="slide"/><geom size=".1" mass="1"/></body></body></body></worldbody></mujoco>'
)
"""A sphere of 1 kg and 0.1 m: 0.4 x 0.01 = 0.004 kg*m^2, with those behind it more."""


OWN = "is it the rotor's own, before the gear? The armature is rotor inertia x gear^2. Or is the limit wrong (PLACE)?"


def told(
    model: str | None = None, motor: bool = False, joint: str = "hip", **wrong: str | None
) -> list[tuple[str, str, str]]:
    """Code, field and help of what is said of one joint, a place as PLACE."""
    figures = {**(SLIDE if joint == "slide" else FIGURES), **wrong}
    stated = "".join(f", {key}: {value}" for key, value in figures.items() if value is not None)
    rest = "rest: {joints: [hip, calf], level: ideal_pd, kp: 1, kd: 1}" if joint == "slide" else REST
    driven = ", motor: m" if motor else ""
    groups = f"own: {{joints: [{joint}], level: ideal_pd{driven}{stated}}}, {rest}"
    robot = {} if model is None else {"robot": "name: leg, model: leg.xml"}
    text = spec_of(groups, motors=MOTOR if motor else "{}", **robot)
    return [
        (
            item.code,
            item.where.removeprefix("actuators.own."),
            re.sub(r"s\.yaml:[0-9:]+", "PLACE", item.help or ""),
        )
        for item in said(text, model)
    ]


def test_the_figures_are_sound() -> None:
    assert told() == told(motor=True) == told(joint="slide") == told(HINGE) == []


@pytest.mark.parametrize(
    ("wrong", "expected"),
    [
        # 400 x 25 = 10 kW, 400 / 0.01 = 40000 rad/s^2, 400 / 40 = 10 rad: three of three. 400 kgf*cm are 39.2 N*m.
        ({"effort_limit": "400 N*m"}, ("SPEC183", "effort_limit", "is it in kgf*cm? Then it is 39.23 N*m; or is the")),
        ({"effort_limit": "4000 N*m"}, ("SPEC183", "effort_limit", "is it in mN*m? Then it is 4 N*m; or is the")),
        # 0.408 N*m is not offered beside dry friction of 0.3.
        ({"effort_limit": "408 N*m"}, ("SPEC183", "effort_limit", "is it in kgf*cm? Then it is 40.01 N*m; or")),
        # 8.75 kW: two of three.
        ({"effort_limit": "350 N*m"}, None),
        # Beyond every published limit one figure of a usual size is enough: 25 x sqrt(4000) = 1581.
        ({"effort_limit": "4000 N*m", "kp": "unknown", "armature": None}, ("SPEC183", "effort_limit", "")),
        ({"effort_limit": "4000 N*m", "kp": "unknown", "velocity_limit": None}, ("SPEC183", "effort_limit", "")),
        # 0.04 / 0.01 = 4 rad/s^2, and 0.04 / 40 = 1 mrad.
        ({"effort_limit": "0.04 N*m", "friction": None}, ("SPEC183", "effort_limit", "is the point")),
        # The odd one is the other.
        ({"velocity_limit": "239 rad/s"}, ("SPEC184", "velocity_limit", "is it in deg/s? Then it is 4.171 rad/s; or")),
        ({"armature": "1e-4 kg*m^2"}, ("SPEC191", "armature", "is it the rotor's own")),
        ({"armature": "10 kg*m^2"}, ("SPEC191", "armature", "look for a wrong unit")),
        # Both of no usual size, both of one: 600 N*m are published, and 45 rad/s may be.
        (
            {"effort_limit": "4000 N*m", "velocity_limit": "250 rad/s", "kp": "unknown", "armature": None},
            ("SPEC184", "velocity_limit", "one of 2 numbers is wrong. velocity_limit: is it in deg/s"),
        ),
        (
            {"effort_limit": "600 N*m", "velocity_limit": "45 rad/s", "kp": "unknown", "armature": None},
            ("SPEC184", "velocity_limit", "one of 2 numbers is wrong. velocity_limit: is it in deg/s"),
        ),
        (
            {"effort_limit": "4000 N*m", "armature": "1e-4 kg*m^2", "kp": "unknown", "velocity_limit": None},
            ("SPEC191", "armature", OWN),
        ),
    ],
)  # fmt: skip
def test_the_odd_one_of_limit_speed_and_armature(
    wrong: dict[str, str | None], expected: tuple[str, str, str] | None
) -> None:
    found = told(**wrong)
    assert [item[:2] for item in found] == ([] if expected is None else [expected[:2]])
    assert all(item[2].startswith(expected[2]) for item in found if expected is not None)
    # Without a verdict the other is named, with its place.
    both = bool(found) and ("one of 2" in found[0][2] or "Or is the limit wrong" in found[0][2])
    assert both == (bool(found) and "PLACE" in found[0][2])


@pytest.mark.parametrize(
    ("kd", "motor", "help"),
    [
        # 0.0001 x 25 = 0.0025 of 0.3 N*m dry friction; 0.011 x 25 = 0.275, and 57.3 times that is 15.8.
        ("0.0001", False, "is the point in the wrong place?"),
        ("0.011", False, "is it per degree? Per radian it is 0.6303 N*m*s/rad. Or is the point in the wrong place?"),
        ("0.011", True, "is it per degree? Per radian it is 0.6303 N*m*s/rad. Or is the point in the wrong place?"),
        ("0.013", False, None),
        ("3900", True, None),
        # 40 N*m at less than 0.01 rad/s.
        ("4100", True, "is the point in the wrong place?"),
        ("10000", False, "is the point in the wrong place?"),
    ],
)  # fmt: skip
def test_the_only_gain_of_a_drive_of_speeds(kd: str, motor: bool, help: str | None) -> None:
    found = told(motor=motor, command="velocity", kp=None, kd=f"{kd} N*m*s/rad")
    assert found == ([] if help is None else [("SPEC192", "kd", help)])


def test_what_holds_a_drive_of_speeds() -> None:
    """0.0001 x 25 rad/s."""
    gains = "command: velocity, kd: 0.0001, effort_limit: 40, velocity_limit: 25 rad/s"
    for friction, held in (
        (", friction: {coulomb: 0.3}", "the joint's own dry friction of 0.3 N*m holds it"),
        ("", "of an effort limit of 40 N*m"),
    ):
        (item,) = said(spec_of(f"own: {{joints: [hip], level: ideal_pd, {gains}{friction}}}, {REST}"))
        given = "hip: kd 0.0001 N*m*s/rad gives 0.0025 N*m at rest where 25 rad/s are commanded"
        assert item.message.startswith(given)
        assert item.message.endswith(held)


def test_a_drive_of_speeds_of_a_simulator() -> None:
    """1e5 is how rigid wheels are written; beside dry friction somebody describes a real drive."""
    figures: dict[str, str | None] = {"command": "velocity", "kp": None, "kd": "100000", "armature": None}
    assert told(**figures, friction=None) == []
    assert [item[:2] for item in told(**figures)] == [("SPEC192", "kd")]
    # Without friction a thousandth of the limit: 0.0015 x 25 and 0.0017 x 25 of 40 N*m.
    for kd, count in (("0.0015", 1), ("0.0017", 0)):
        assert len(told(command="velocity", kp=None, kd=kd, friction=None)) == count


@pytest.mark.parametrize(
    ("kd", "expected"),
    [("1e-6", 1), ("0.0039", 1), ("0.0041", 0), ("57.3", 0), ("3900", 0), ("4100", 1), ("1e8", 1)],
)
def test_a_kd_whose_kp_is_unknown(kd: str, expected: int) -> None:
    """1e-4 s/rad of 40 N*m is 0.004; 40 N*m at 0.01 rad/s are 4000."""
    found = told(kp="unknown", kd=f"{kd} N*m*s/rad")
    assert [item[:2] for item in found] == [("SPEC192", "kd")] * expected


@pytest.mark.parametrize(
    ("kp", "motor", "help"),
    [
        # 40 / 0.698 = 57.3 rad.
        ("0.698", False, "is kp per degree? Per radian it is 39.99 N*m/rad"),
        ("0.001", False, "did you mean 10 N*m/rad?"),
        ("0.81", False, None),
        ("4", False, None),
        # 0.01 rad; of an unknown kd nothing is exchanged.
        ("4000", False, "is the point in the wrong place?"),
        ("4000", True, "is the point in the wrong place?"),
        # 50 x 57.3; 40 / 2865 = 0.014 rad.
        ("2865", True, "is kp multiplied by 57.3? Without that it is 50 N*m/rad"),
        ("2600", False, None),
    ],
)
def test_a_kp_whose_kd_is_unknown(kp: str, motor: bool, help: str | None) -> None:
    found = told(motor=motor, kp=f"{kp} N*m/rad", kd="unknown", friction="{coulomb: 0.3 N*m}")
    assert found == ([] if help is None else [("SPEC192", "kp", help)])


def test_an_unknown_kd_is_no_0() -> None:
    text = spec_of(
        "legs: {joints: [hip], level: ideal_pd, motor: m, kp: 4000 N*m/rad, kd: unknown, effort_limit: 40}, "
        + REST,
        motors=MOTOR,
    )
    (item,) = said(text)
    assert item.message == "kp 4000 N*m/rad asks for the effort limit of 40 N*m at an error of 0.01 rad"


@pytest.mark.parametrize(
    ("kp", "friction", "expected"),
    [
        # Placeholders of a rigid joint: published 2e-5 s. Beside dry friction a joint is described.
        ("1e5", None, 0),
        ("1e8", None, 1),
        ("1e5", "{coulomb: 0.3}", 1),
        ("1e8", "{coulomb: 0.3}", 1),
    ],
)
def test_a_power_of_ten_without_a_motor(kp: str, friction: str | None, expected: int) -> None:
    found = told(kp=kp, friction=friction)
    assert [item[:2] for item in found] == [("SPEC192", "kp")] * expected


def test_both_gains_per_degree_and_times_573() -> None:
    """40 / 57.3 = 0.698, 1 / 57.3 = 0.0175; 40 x 57.3 = 2292: 2292 / 0.0354 kg*m^2 is 254 rad/s squared."""
    per = "are kp and kd per degree? Per radian they are 39.99 N*m/rad and 1.003 N*m*s/rad"
    for motor in (False, True):
        assert told(motor=motor, kp="0.698", kd="0.0175") == [("SPEC192", "kp", per)]
    times = "are kp and kd multiplied by 57.3? Without that they are 40 N*m/rad and 1 N*m*s/rad"
    figures = {"kp": "2292", "kd": "57.3"}
    assert told(HINGE, **figures) == [("SPEC192", "kp", times)]
    # Of others, and without the links' inertia, nothing tells it from a simulator's servo.
    assert told(HINGE, kp="2300", kd="57.3") == told(**figures) == []


def test_a_drive_without_gains() -> None:
    (found,) = told(kp="0", kd="0")
    assert found[:2] == ("SPEC192", "kp")
    assert "`command: effort`" in found[2]
    assert told(kp="0", kd="1") == []


@pytest.mark.parametrize(
    ("wrong", "help"),
    [
        # 200 N / 5 N/m = 40 m.
        (
            {"kp": "5 N/m", "kd": "0.2 N*s/m"},
            "are kp and kd per mm? Per metre they are 5000 N/m and 200 N*s/m",
        ),
        ({"kp": "5 N/m", "kd": "unknown"}, "is kp per mm? Per metre it is 5000 N/m"),
        # 0.04 mm, and 210 / 5e6 = 0.042 ms.
        ({"kp": "5e6 N/m"}, "did you mean 5000 N/m?"),
        ({"kp": "1.9e6 N/m"}, None),
        # 200 / 20.1 = 9.95 m.
        ({"kp": "20.1 N/m", "kd": "2 N*s/m"}, None),
    ],
)
def test_a_slide(wrong: dict[str, str], help: str | None) -> None:
    assert told(joint="slide", **wrong) == ([] if help is None else [("SPEC192", "kp", help)])


def test_gains_per_degree_by_the_inertia() -> None:
    """A dog's 30 N*m/rad and 1 N*m*s/rad over 57.3, with 24 N*m: 46 rad, of 50 that are told without inertia."""
    figures = {"kp": "0.52 N*m/rad", "kd": "0.0175 N*m*s/rad", "effort_limit": "24 N*m"}
    help = "are kp and kd per degree? Per radian they are 29.79 N*m/rad and 1.003 N*m*s/rad"
    assert told(HINGE, **figures) == [("SPEC192", "kp", help)]
    assert told(**figures) == told(HINGE, **{**figures, "kp": "30 N*m/rad", "kd": "1 N*m*s/rad"}) == []


TENTH = (
    '<mujoco><worldbody><body><joint name="hip" axis="0 1 0"/>'
    '<inertial pos="0 0 0" mass="1" diaginertia="1 0.1 1"/></body>'
    '<body><joint name="calf"/><geom size=".1" mass="1"/></body>'
    '<body><joint name="slide" type="slide"/><geom size=".1" mass="1"/></body></worldbody></mujoco>'
)
"""A hip of 0.1 kg*m^2."""


@pytest.mark.parametrize(
    ("kp", "limit", "friction", "expected"),
    [
        # 9.95 rad/s and 10.01 rad; 10.05 rad/s; 4.9 rad/s and 5.04 rad.
        ("9.9", "99.1", "{coulomb: 0.1}", 1),
        ("9.9", "99.1", None, 0),
        ("9.9", "98.9", "{coulomb: 0.1}", 0),
        ("10.1", "110", "{coulomb: 0.1}", 0),
        ("2.4", "12.1", "{coulomb: 0.1}", 1),
        ("2.4", "11.9", "{coulomb: 0.1}", 0),
        ("2.6", "25", "{coulomb: 0.1}", 0),
        # A limit that is a power of ten is often nobody's.
        ("2.4", "100", "{coulomb: 0.1}", 0),
    ],
)
def test_a_weak_drive_by_its_inertia(kp: str, limit: str, friction: str | None, expected: int) -> None:
    found = told(
        TENTH, kp=kp, kd="0.2", effort_limit=limit, friction=friction, armature=None, velocity_limit=None
    )
    assert [item[:2] for item in found] == [("SPEC192", "kp")] * expected


@pytest.mark.parametrize(
    ("kp", "kd", "limit", "expected"),
    [
        # 10.1 and 9.9 rad; kd over kp of 0.105 s.
        ("1.9", "0.18", "19.2", 1),
        ("1.9", "0.18", "18.8", 0),
        ("1.9", "0.2", "19.2", 0),
        # 25.2 and 24.8 rad.
        ("2.1", "0.18", "53", 1),
        ("2.1", "0.18", "52", 0),
        # 25.3 rad at 9.95 rad/s and 10.05 rad/s.
        ("9.9", "0.9", "250", 1),
        ("10.1", "0.9", "260", 0),
        # A limit that is a power of ten is often nobody's, and without kd it may be a spring.
        ("1.9", "0.18", "100", 0),
        ("1.9", "0", "19.2", 0),
    ],
)
def test_a_weak_servo_by_its_inertia(kp: str, kd: str, limit: str, expected: int) -> None:
    """Nobody states motor or friction: only what no imported spec comes to, and with a usual kd."""
    found = told(TENTH, kp=kp, kd=kd, effort_limit=limit, friction=None, armature=None, velocity_limit=None)
    assert [item[:2] for item in found] == [("SPEC192", "kp")] * expected
    assert all(item[2].startswith("are kp and kd per degree?") for item in found)


ROD = (
    '<mujoco><worldbody><body><joint name="hip"/><geom size=".1" mass="1"/>'
    '<body><joint name="calf"/><geom size=".1" mass="1"/>'
    '<body><joint name="slide" type="slide" range="0 0.1" limited="true"/><geom size=".1" mass="1"/>'
    "</body></body></body></worldbody></mujoco>"
)
"""A slide of 1 kg that travels 0.1 m."""
TRAVEL: dict[str, str | None] = {"armature": None, "friction": None}
DRIVEN = (
    "actspec: 1\nrobot: {name: leg, model: leg.xml}\n"
    "motors: {m: {side: joint, peak_torque: 2000 N, no_load_speed: 0.2 m/s}}\n"
    "actuators: {own: {joints: [slide], level: ideal_pd, motor: m, GAINS, effort_limit: peak}, "
    "rest: {joints: [hip, calf], level: ideal_pd, kp: 1, kd: 1}}\n"
)


@pytest.mark.parametrize(
    ("gains", "limit", "field", "help"),
    [
        # 2000 / 30 = 66.7 m, 667 times 0.1 m, at 5.5 rad/s.
        ("30 1", "2000", "kp", "are kp and kd per mm? Per metre they are 30000 N/m and 1000 N*s/m"),
        # 2.51 and 2.49 m at 5.9 rad/s; 15.1 and 14.9 m at 10 rad/s, which may be a finger's.
        ("35 1", "87.9", "kp", "are kp and kd per mm? Per metre they are 35000 N/m and 1000 N*s/m"),
        ("35 1", "87.1", None, ""),
        ("100 3", "1490", None, ""),
        (
            "100 3",
            "1510",
            "kp",
            "one of 2 numbers is wrong. kp: are kp and kd per mm? Per metre they are 100000 N/m and 3000 N*s/m. Or "
            "the effort limit (PLACE): look for a wrong unit",
        ),
        # 141 rad/s; a thousand times as much would be 4472.
        ("20000 800", "400000", "effort_limit", "look for a wrong unit or power of ten"),
        # A limit that is a power of ten is often nobody's.
        ("20 1", "1000", None, ""),
    ],
)
def test_a_slide_by_its_travel(gains: str, limit: str, field: str | None, help: str) -> None:
    kp, _, kd = gains.partition(" ")
    figures = {**TRAVEL, "kp": f"{kp} N/m", "kd": f"{kd} N*s/m", "effort_limit": f"{limit} N"}
    assert told(ROD, joint="slide", **figures) == ([] if field is None else [("SPEC192", field, help)])


@pytest.mark.parametrize(("kp", "field"), [("790", "kp"), ("810", None)])
def test_a_driven_slide_by_its_travel(kp: str, field: str | None) -> None:
    """2000 N over 790 N/m are 2.53 m, 25.3 times 0.1 m."""
    found = said(DRIVEN.replace("GAINS", f"kp: {kp} N/m, kd: 20 N*s/m"), ROD)
    assert [(item.code, item.where) for item in found] == (
        [] if field is None else [("SPEC192", "actuators.own.kp")]
    )


@pytest.mark.parametrize("motor", [False, True])
@pytest.mark.parametrize("kd", ["100", "200", "500", "1000", "5000"])
def test_a_wrong_kd_beside_a_right_kp(kd: str, motor: bool) -> None:
    """kp takes the limit at 1 rad, as legs do; with the two exchanged kd alone would take it at 1 rad/s."""
    assert told(motor=motor, kd=kd) == [("SPEC192", "kd", "is the point in the wrong place?")]


@pytest.mark.parametrize(("kp", "kd"), [("1", "40"), ("0.5", "25"), ("2", "100")])
def test_an_exchange_is_still_one(kp: str, kd: str) -> None:
    ((code, where, help),) = told(kp=kp, kd=kd)
    assert (code, where) == ("SPEC192", "kp")
    assert help.startswith("are the two exchanged?")


def test_gains_that_no_slip_explains() -> None:
    """1e8 is the odd one beside a kp of a usual size; of two odd ones neither is blamed alone."""
    look = "look for a wrong unit or power of ten"
    assert told(kd="1e8") == [("SPEC192", "kd", look)]
    assert told(kp="1e-8", kd="1e8") == [
        ("SPEC192", "kp", f"one of 2 numbers is wrong, kp or kd (PLACE): {look}")
    ]


SHEET = {
    "side": "joint",
    "stall_torque": "40 N*m",
    "no_load_speed": "25 rad/s",
    "peak_torque": "40 N*m",
    "gear_ratio": "8",
    "rotor_inertia": "1.5e-4 kg*m^2",
}


@pytest.mark.parametrize("gear", ["1e9", "8e5"])
def test_a_figure_that_contradicts_all_others(gear: str) -> None:
    """No slip of a few powers of ten: only with another gear do torque, speed and rotor agree."""
    sheet = ", ".join(f"{key}: {value}" for key, value in {**SHEET, "gear_ratio": gear}.items())
    groups = "own: {joints: [hip], motor: m, level: ideal_pd, kp: 40, kd: 1}, " + REST
    (item,) = said(spec_of(groups, motors=f"{{m: {{{sheet}}}}}"))
    assert (item.code, item.where) == ("SPEC184", "motors.m.gear_ratio")
    assert item.help == "all other figures agree with each other: look for a wrong unit or power of ten"


@pytest.mark.parametrize(
    ("stall", "free", "where"),
    [
        # 25 N*m of 40: the line ends at 40 rad/s, which is the limit's number.
        ("25 N*m", "40 rad/s", "motors.m.stall_torque"),
        ("25 N*m", "41 rad/s", "actuators.own.effort_limit"),
        ("33 N*m", "40 rad/s", None),
    ],
)
def test_the_ends_of_a_line_exchanged(stall: str, free: str, where: str | None) -> None:
    groups = "own: {joints: [hip], motor: m, level: dc_motor, kp: 40, kd: 1, effort_limit: 40}, " + REST
    motor = f"{{m: {{side: joint, stall_torque: {stall}, no_load_speed: {free}}}}}"
    found = said(spec_of(groups, motors=motor))
    assert [(item.code, item.where) for item in found] == ([] if where is None else [("SPEC187", where)])
    if where is not None and where.startswith("motors"):
        assert (found[0].help or "").endswith("exchanged? Then they are 40 N*m and 25 rad/s")


@pytest.mark.parametrize("level", ["ideal_pd", "dc_motor"])
def test_exchanged_motors_are_told_once(level: str) -> None:
    """60 N*m of a motor of 40, and 40 of one of 60: the lines are told, and no limit that is held against them."""
    groups = (
        f"hips: {{joints: [hip], motor: big, level: {level}, kp: 40, kd: 1, effort_limit: 40}}, "
        f"knees: {{joints: [calf], motor: small, level: {level}, kp: 40, kd: 1, effort_limit: 60}}, "
        "rest: {joints: [slide], level: ideal_pd, kp: 1, kd: 1}"
    )
    sheets = "".join(
        f"{name}: {{side: joint, stall_torque: {torque}, peak_torque: {torque}, no_load_speed: 20 rad/s}}, "
        for name, torque in (("small", 40), ("big", 60))
    )
    (item,) = said(spec_of(groups, motors=f"{{{sheets[:-2]}}}"))
    assert item.code == "SPEC187"
    assert item.where.endswith(".motor")


@pytest.mark.parametrize(
    ("entry", "expected"),
    [
        # 40 - 50 = -10 N*m/rad; 40 - 40 is 0.
        ("kp: {add: [-50, 50]}", "kp is drawn below 0: -10 N*m/rad"),
        ("kp: {add: [-40, 50]}", None),
        ("kp: {add: [0, 50], distribution: gaussian}", None),
        ("armature: {add: [-0.02, 0]}", "armature is drawn below 0: -0.01 kg*m^2"),
        ("encoder_bias: {add: [-0.02 rad, 0.02 rad]}", None),
        ("strength: {scale: [0.1, 5]}", "a factor of 5 on the nominal value: no motor gives 3 times its torque"),
        ("effort_limit: {scale: [0.5, 3.1]}", "a factor of 3.1 on the nominal value: no motor"),
        ("strength: {scale: [0.5, 3]}", None),
        ("kp: {scale: [0.5, 3.1]}", None),
        # Values, of which the nominal 1 N*m*s/rad is none, would be as odd as these factors are.
        ("kd: {scale: [3.5, 5]}", None),
    ],
)  # fmt: skip
def test_ranges(entry: str, expected: str | None) -> None:
    figures = "".join(f", {key}: {value}" for key, value in FIGURES.items())
    groups = f"own: {{joints: [hip], level: ideal_pd{figures}, randomize: {{{entry}}}}}, {REST}"
    found = said(spec_of(groups))
    assert [item.code for item in found] == ["SPEC188"] * (expected is not None)
    assert all(item.message.startswith(expected or "") for item in found)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        # 1e-5 kg*m^2 x 30^2 = 0.009 kg*m^2, and 0.009 - 0.02 = -0.011; 0.009 - 0.009 is 0.
        ("armature: {add: [-0.02, 0.02]}", "hip: armature is drawn below 0: -0.011 kg*m^2"),
        ("armature: {add: [-0.009, 0.02]}", None),
        ("armature: {add: [0, 0.02], distribution: gaussian}", None),
        # What the motor's peak torque is: 12 N*m.
        ("effort_limit: {add: [-20, 0]}", "hip: effort_limit is drawn below 0: -8 N*m"),
    ],
)
def test_ranges_about_what_follows_from_the_motor(entry: str, message: str | None) -> None:
    motors = (
        "{m: {side: joint, peak_torque: 12, stall_torque: 12, no_load_speed: 20 rad/s, gear_ratio: 30, "
        "rotor_inertia: 1e-5}}"
    )
    group = "own: {joints: [hip], motor: m, level: dc_motor, kp: 40, kd: 1, effort_limit: peak"
    group += f", randomize: {{{entry}}}}}"
    found = said(spec_of(f"{group}, {REST}", motors=motors))
    assert [(item.code, item.message) for item in found] == ([("SPEC188", message)] if message else [])
    drawn = "targets: {random: {target: randomization, for: [json]}}"
    assert said(spec_of(f"{group}, {REST}", motors=motors, more=drawn)) == []


@pytest.mark.parametrize(
    ("entry", "far", "help"),
    [
        # Of 1e-5 kg*m^2 x 30^2 = 0.009 kg*m^2.
        (
            "armature: {abs: [0.5, 1.5]}",
            "0.5 to 1.5 in place of the nominal 0.009 kg*m^2 is 55.6 to 167 times as much",
            "are they factors? Then write `scale: [0.5, 1.5]`",
        ),
        (
            "armature: {abs: [8 kg*cm^2, 8.5 kg*cm^2]}",
            "0.0008 kg*m^2 to 0.00085 kg*m^2 in place of the nominal 0.009 kg*m^2 is 0.0889 to 0.0944 times as much",
            "look for a wrong unit, or another joint's range",
        ),
        # A tenth and ten times may be meant: 0.0009 and 0.09 kg*m^2.
        ("armature: {abs: [0.0005, 0.001]}", None, None),
        ("armature: {abs: [0.085, 0.2]}", None, None),
        ("armature: {abs: [0.006, 0.012]}", None, None),
        ("armature: {abs: [0.85, 0.1], distribution: gaussian}", "0.85 in place", "did you mean 0.0085 kg*m^2?"),
    ],
)  # fmt: skip
def test_values_in_place_of_what_follows_from_the_motor(
    entry: str, far: str | None, help: str | None
) -> None:
    motors = "{m: {side: joint, peak_torque: 12, stall_torque: 12, no_load_speed: 20 rad/s, gear_ratio: 30, "
    motors += "rotor_inertia: 1e-5}}"
    group = "own: {joints: [hip], motor: m, level: dc_motor, kp: 40, kd: 1, effort_limit: peak"
    group += f", randomize: {{{entry}}}}}"
    found = said(spec_of(f"{group}, {REST}", motors=motors))
    assert [(item.code, item.help) for item in found] == ([] if far is None else [("SPEC188", help)])
    assert all(item.message.startswith(f"hip: {far}") for item in found)


def test_a_range_below_0_is_told_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A target that draws refuses it; without one it is a warning."""
    groups = (
        "own: {joints: [hip], level: ideal_pd, kp: 40, kd: 1, randomize: {kp: {add: [-50, 50]}}}, " + REST
    )
    path = tmp_path / "s.yaml"
    for more, code in (
        ("", "SPEC188"),
        ("targets: {random: {target: randomization, for: [json]}}", "RND004"),
    ):
        path.write_text(spec_of(groups, more=more), encoding="utf-8")
        for command in (["validate", str(path)], ["compile", str(path), "-o", str(tmp_path / "out")]):
            main(command)
            caught = capsys.readouterr()
            words = [word for word in (caught.out + caught.err).split() if word[:4] in ("SPEC", "RND0")]
            assert words[:1] == [code] if command[0] == "validate" else code in words
            assert not {"SPEC188", "RND004"}.difference([code]).intersection(words)


@pytest.mark.parametrize(
    ("error", "help"), [("5.7 rad", "is it in degrees? Then write 5.7 deg"), ("3.1 rad", None)]
)
def test_an_error_beyond_half_a_turn(error: str, help: str | None) -> None:
    found = told(kp=f"{{derive: torque_at_error, fraction: 0.6, error: {error}}}", armature=None)
    assert found == ([] if help is None else [("SPEC192", "kp.error", help)])
