"""A gear with its point in the wrong place, which friction of the joint contradicts: a telescope's mount."""

from __future__ import annotations

import pytest

from actspec.diagnostics import ActspecError, Severity
from actspec.spec.plausible import BY_CODE
from tests.fitting import fit, spec_of

REST = "rest: {joints: [calf, slide], level: ideal_pd, kp: 1, kd: 1}"
# 0.4 x 720 x 0.4 = 115.2 N*m and 62.8 / 720 = 0.0873 rad/s: 8 N*m are 0.07, 20 N*m*s/rad 0.015 of it.
STEPPER = (
    "side: motor, gear_ratio: {value: GEAR, sure: SURE}, efficiency: 0.4, stall_torque: 0.44, peak_torque: 0.4, "
    "no_load_speed: 600 rpm, rotor_inertia: 57 g*cm^2"
)


def told(
    gear: str,
    friction: str = "coulomb: 8, viscous: 20",
    limit: str = "peak",
    sure: bool = False,
    more: str = "",
) -> list[tuple[str, str, str, str]]:
    """Code, with `!` for an error, place, message and help of what the checks report."""
    motor = STEPPER.replace("GEAR", gear).replace("SURE", str(sure).lower()) + more
    text = spec_of(
        f"axes: {{joints: [hip], motor: m, level: ideal_pd, effort_limit: {limit}, kp: 3e4, kd: 1500, "
        f"friction: {{{friction}}}}}, {REST}",
        motors=f"{{m: {{{motor}}}}}",
    )
    try:
        found = fit(text).diagnostics
    except ActspecError as err:
        found = err.diagnostics
    return [
        (item.code + "!" * (item.severity is Severity.ERROR), item.where, item.message, item.help or "")
        for item in found
        if item.code in BY_CODE
    ]


def test_the_gear_that_is_right() -> None:
    assert told("720") == []


@pytest.mark.parametrize("friction", ["coulomb: 8, viscous: 20", "coulomb: 8"])
def test_a_gear_that_friction_refuses_is_not_offered(friction: str) -> None:
    """1152 N*m behind 7200 turns; 7.2 would leave 1.15, 72 11.5 N*m, of which the friction takes 0.69."""
    ((code, where, _, help),) = told("7200", friction)
    assert (code, where) == ("SPEC183", "motors.m.gear_ratio")
    assert help == "did you mean 720? `sure: true` beside it keeps a number that is right"


def test_without_friction_nothing_tells_which_gear_it_is() -> None:
    ((_, where, _, help),) = told("7200", "coulomb: unknown, viscous: unknown")
    assert where == "motors.m.gear_ratio" and "720?" not in help


def test_a_gear_that_both_frictions_contradict_is_told_itself() -> None:
    """1.152 N*m and 8.73 rad/s: 8 N*m, and 20 x 8.73 = 175 N*m."""
    ((code, where, message, help),) = told("7.2")
    assert (code, where, help) == ("SPEC182!", "motors.m.gear_ratio", "did you mean 720?")
    assert message == (
        "behind 7.2 turns the joint's limit is 1.152 N*m, and dry and viscous friction take too much of it: coulomb "
        "(s.yaml:4:121), viscous (s.yaml:4:133)"
    )
    ((_, _, message, _),) = told("7.2", limit="continuous", more=", continuous_torque: 0.2")
    assert message.startswith("behind 7.2 turns the joint's limit is 0.576 N*m,")
    # Who is sure of it has one of the frictions wrong; so has a joint whose limit is stated.
    assert [item[0] for item in told("7.2", sure=True)] == ["FRC101!", "FRC106"]
    assert "SPEC182!" not in [item[0] for item in told("7.2", limit="1.1")]


def test_beside_one_friction_the_gear_is_named() -> None:
    """11.52 N*m: 8 N*m are 69 % of it, and may be mN*m."""
    ((code, where, _, help),) = told("72")
    assert (code, where) == ("FRC101", "actuators.axes.friction.coulomb")
    assert help.endswith(
        " Or is the limit wrong (s.yaml:3:115)? Or gear_ratio (s.yaml:3:39): did you mean 720?"
    )
    # Sure of it, or with 0.5 N*m, which no gear explains with its point one place further: it is not named.
    for found in (told("72", sure=True), told("720", "coulomb: 8000")):
        ((code, *_, help),) = found
        assert code.startswith("FRC101") and "gear_ratio" not in help


def test_a_gear_that_dry_friction_contradicts_before_a_speed() -> None:
    """An excavator's swing: 560 x 1.6 x 0.9 = 806 N*m at 124 rad/s; 2 kN*m of friction leave the gear of 160 alone."""
    motor = "side: motor, gear_ratio: 1.6, efficiency: 0.9, peak_torque: 560, no_load_speed: 1900 rpm, "
    own = "joints: [hip], motor: m, level: ideal_pd, command: velocity, effort_limit: peak, kd: 5e4"
    friction = "friction: {coulomb: 2 kN*m, viscous: 1 kN*m*s/rad}"
    text = spec_of(f"axes: {{{own}, {friction}}}, {REST}", motors=f"{{m: {{{motor}rotor_inertia: 0.02}}}}")
    (found,) = (item for item in fit(text).diagnostics if item.code in BY_CODE)
    assert (found.code, found.where, found.help) == ("SPEC184", "motors.m.gear_ratio", "did you mean 160?")


CASSIE = (
    "side: motor, gear_ratio: {}, peak_torque: {}, stall_torque: {}, no_load_speed: {}, rotor_inertia: 6.1e-5"
)


@pytest.mark.parametrize(
    ("sheet", "viscous", "gear"),
    [
        # 1 N*m*s/rad x 12.1 of 112 N*m; behind 2.5 turns 121 of 11.2.
        (("25", "4.5", "4.5", "2900 rpm"), "1", None),
        (("2.5", "4.5", "4.5", "2900 rpm"), "1", "25"),
        (("5", "0.9", "0.9", "5500 rpm"), "0.5", "50"),
        # 0.01 x 715 = 7.15 N*m of 1.3 x 1.4; behind 14 turns it is 0.715 of 18.2, and 71.5 rad/s.
        (("1.4", "1.3", "5.6", "9560 rpm"), "0.01", "14"),
        # A friction that is wrong itself beside a usual gear; a direct drive.
        (("9", "2", "2", "2000 rpm"), "5", ""),
        (("1", "4.5", "4.5", "1000 rpm"), "1", ""),
    ],
)
def test_beside_viscous_friction_a_gear_that_is_too_small_is_named(
    sheet: tuple[str, ...], viscous: str, gear: str | None
) -> None:
    text = spec_of(
        f"legs: {{joints: [hip], motor: m, level: dc_motor, effort_limit: peak, kp: 90, kd: 9, "
        f"friction: {{viscous: {viscous}}}}}, {REST}",
        motors=f"{{m: {{{CASSIE.format(*sheet)}}}}}",
    )
    found = [item for item in fit(text).diagnostics if item.code in BY_CODE and item.code != "SPEC192"]
    assert [item.where for item in found] == ["actuators.legs.friction.viscous"] * (gear is not None)
    for item in found:
        named = f"Or gear_ratio (s.yaml:3:39): did you mean {gear}?" if gear else "gear_ratio"
        assert (named in (item.help or "")) is bool(gear)


LIFT = (
    "side: motor, gearbox: [{ratio: 4.43, efficiency: 0.9}, {radius: RADIUS, efficiency: 0.95, inertia: 0.5 kg}], "
    "peak_torque: 1.26, no_load_speed: 1000 rpm, rotor_inertia: 300 g*cm^2"
)


def lifted(radius: str, friction: str) -> list[tuple[str, str, str]]:
    """Code, place and help of what is told of a lift's motor and friction."""
    own = "joints: [slide], motor: m, level: ideal_pd, effort_limit: peak, kp: 20000 N/m, kd: 800 N*s/m"
    rest = "rest: {joints: [hip, calf], level: ideal_pd, kp: 1, kd: 1}"
    motors = f"{{m: {{{LIFT.replace('RADIUS', radius)}}}}}"
    text = spec_of(f"axes: {{{own}, friction: {{{friction}}}}}, {rest}", motors=motors)
    return [
        (item.code, item.where, item.help or "") for item in fit(text).diagnostics if item.code in BY_CODE
    ]


def test_two_frictions_and_one_length() -> None:
    """1.26 x 4.43 x 0.855 / 0.0132 = 361.5 N at 0.312 m/s; behind 132 mm 36.15 N at 3.12 m/s, of 30 N and 156 N."""
    both = "coulomb: 30 N, viscous: 50 N*s/m"
    assert lifted("13.2 mm", both) == []
    ((code, where, help),) = lifted("132 mm", both)
    assert (code, where) == ("FRC101", "motors.m.gearbox[0].ratio")
    assert help.startswith("one of 2 numbers is wrong. ratio: did you mean 44.3? Or radius (s.yaml:3:")
    assert help.endswith("Or are the frictions in another unit?")


def test_dry_friction_alone_names_the_length() -> None:
    ((code, where, help),) = lifted("132 mm", "coulomb: 30 N")
    assert (code, where) == ("FRC101", "actuators.axes.friction.coulomb")
    assert " Or radius (s.yaml:3:" in help and help.endswith("did you mean 13.2 mm?")
    # 300 N would take 83 % of it.
    ((code, where, help),) = lifted("13.2 mm", "coulomb: 300 N")
    assert code == "FRC101" and "radius" not in help


@pytest.mark.parametrize("sure", [False, True])
def test_two_groups_and_one_torque(sure: bool) -> None:
    """450 N for 450 kN of cylinders: 450 x 0.8 = 360 N*m of 3000, and 292.5 of 2000; nor does it turn 77 kg*m^2."""
    force = "{value: 450 N, sure: true}" if sure else "450 N"
    own = "{joint}: {{joints: [{joint}], motor: m, transmission: [{{lever_arm: {arm}}}], level: ideal_pd, "
    own += "effort_limit: peak, kp: 2e6, kd: 2e5, friction: {{coulomb: {dry} N*m}}}}"
    groups = [
        own.format(joint="hip", arm="0.8 m", dry=3000),
        own.format(joint="calf", arm="0.65 m", dry=2000),
    ]
    text = spec_of(
        ", ".join([*groups, "rest: {joints: [slide], level: ideal_pd, kp: 1, kd: 1}"]),
        motors=f"{{m: {{side: joint, peak_torque: {force}, reflected_inertia: 120 kg}}}}",
        more="accept: {spec.lever_arm: mid stroke}",
    )
    with pytest.raises(ActspecError) as caught:
        fit(text)
    found = [item for item in caught.value.diagnostics if item.code in BY_CODE]
    if sure:
        assert [item.where for item in found if item.code == "FRC101"] == [
            "actuators.hip.friction.coulomb",
            "actuators.calf.friction.coulomb",
        ]
        return
    assert [(item.code, item.where) for item in found] == [("FRC101", "motors.m.peak_torque")]
    assert found[0].message == (
        "hip: dry friction takes too much of what the motor 'm' gives: 3000 N*m at hip (s.yaml:4:155) of 360 N*m, "
        "2000 N*m at calf (s.yaml:4:312) of 292.5 N*m"
    )
