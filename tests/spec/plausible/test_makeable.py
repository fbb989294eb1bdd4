"""Gears that nobody can make, motors that travel, numbers that stand in each other's place."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.diagnostics import ActspecError, Diagnostic
from actspec.resolution import resolve
from actspec.robot.load import joints_of_text
from actspec.spec.document import document_from_text
from actspec.spec.plausible import BY_CODE
from actspec.spec.validate import validate
from tests.fitting import faults_of, fit, spec_of

REST = "rest: {joints: [calf, slide], level: ideal_pd, kp: 1, kd: 1}"


def said(
    motor: str, fields: str = "", group: str = "joints: [hip]", rest: str = REST
) -> list[tuple[str, str, str]]:
    """Code, place and help of what is said of a motor and the group that has it."""
    text = spec_of(
        f"legs: {{{group}, motor: m, level: ideal_pd{fields}}}, {rest}", motors=f"{{m: {{{motor}}}}}"
    )
    try:
        found: list[Diagnostic] = [*fit(text).diagnostics]
    except ActspecError as err:
        found = [*err.diagnostics]
        assert all(item.code in BY_CODE for item in found), found
    return [(item.code, item.where, item.help or "") for item in found if item.code in BY_CODE]


SERVO = "side: joint, peak_torque: 25, rotor_inertia: 0.139e-4, gearbox: "


@pytest.mark.parametrize(
    ("stages", "expected"),
    [
        ("[{planetary: {sun: 18, ring: 46}}]", []),
        ("[{planetary: {sun: 1.8, ring: 46}}]", [("sun", "did you mean 18?")]),
        # 365 teeth would be a stage of 18.
        (
            "[{teeth: {driving: 20, driven: 36.5}}]",
            [("driven", "write `ratio` where the teeth are not known")],
        ),
        ("[{teeth: {driving: 3.6, driven: 40}}]", [("driving", "did you mean 36?")]),
        # 1 + 139/10 = 14.9 and 1 + 141/10 = 15.1.
        ("[{planetary: {sun: 10, ring: 139}}]", []),
        (
            "[{planetary: {sun: 10, ring: 141}}]",
            [("sun", "look for a wrong number of teeth, or write `ratio`")],
        ),
        # A strain wave gear is no planetary stage.
        ("[{ratio: 100}]", []),
    ],
)
def test_gears_that_nobody_can_make(stages: str, expected: list[tuple[str, str]]) -> None:
    """The ratio of 26.6 for 3.6 would make an armature 50 times as large: told once, at the teeth."""
    found = said(f"{SERVO}{stages}", ", kp: 40, kd: 1")
    assert [(code, where.rpartition(".")[2]) for code, where, _ in found] == [
        ("SPEC182", key) for key, _ in expected
    ]
    assert all(help.startswith(start) for (_, _, help), (_, start) in zip(found, expected, strict=True))


CYLINDER = "peak_torque: FORCE, no_load_speed: SPEED"
SLIDE = "rest: {joints: [hip, calf], level: ideal_pd, kp: 1, kd: 1}"


@pytest.mark.parametrize(
    ("motor", "help"),
    [
        ("peak_torque: 3200 N, stall_torque: 3200 N, no_load_speed: 1.6 m/s", None),
        (
            "peak_torque: 3200 N, stall_torque: 3200 N, no_load_speed: 1600 m/s",
            "is it in mm/s? 1600 mm/s is 1.6 m/s",
        ),
        # 6800 x 13 = 88.4 kW; 180 kN x 0.5 m/s = 90 kW of an excavator without a battery.
        (
            "peak_torque: 6800 N, no_load_speed: 13 m/s, nominal_voltage: 24 V",
            "is it in mm/s? 13 mm/s is 0.013 m/s",
        ),
        ("peak_torque: 180000 N, no_load_speed: 0.5 m/s", None),
    ],
)
def test_a_motor_that_travels(motor: str, help: str | None) -> None:
    """The friction that the wrong speed makes too large is not told, nor the armature that it moves."""
    friction = (
        ", kp: 1e5, kd: 3e3, armature: 5000 kg, friction: {viscous: 1000 N*s/m}"
        if help
        else ", kp: 1e5, kd: 3e3"
    )
    found = said(f"side: joint, {motor}", friction, "joints: [slide]", SLIDE)
    assert found == ([] if help is None else [("SPEC184", "motors.m.no_load_speed", help)])


@pytest.mark.parametrize(
    ("arm", "help"),
    [("43 mm", None), ("2.9 m", None), ("43 m", "did you mean 43 mm?"), ("430 m", "did you mean 430 mm?")],
)
def test_a_lever_of_many_metres(arm: str, help: str | None) -> None:
    motor = "side: joint, peak_torque: 3200 N, stall_torque: 3200 N"
    found = said(motor, f", kp: 300, kd: 10, transmission: [{{lever_arm: {arm}}}]")
    levers = [item for item in found if item[1].endswith("lever_arm")]
    assert levers == ([] if help is None else [("SPEC184", "actuators.legs.transmission[0].lever_arm", help)])


def test_a_stall_torque_in_the_place_of_the_speed() -> None:
    """120 N*m and 7.5 rad/s; the other way round the peak of 80 N*m would be above it."""
    sheet = "side: joint, peak_torque: 80, stall_torque: {} N*m, no_load_speed: {} rad/s"
    assert said(sheet.format(120, 7.5), ", kp: 40, kd: 1") == []
    (found,) = said(sheet.format(7.5, 120), ", kp: 40, kd: 1")
    assert found[2] == "are the two exchanged? Then stall_torque is 120 N*m, no_load_speed 7.5 rad/s"


def test_two_radii_that_are_exchanged() -> None:
    """85.5 rad/s x 15 / 90 = 14.25 rad/s; exchanged 513 rad/s."""
    motor = "side: joint, peak_torque: 5, no_load_speed: 85.5 rad/s"
    right = ", kp: 40, kd: 1, transmission: [{radius: 15 mm}, {radius: 90 mm}]"
    assert said(motor, right) == []
    wrong = right.replace("15 mm", "9 mm").replace("90 mm", "15 mm").replace("9 mm", "90 mm")
    (found,) = said(motor, wrong)
    assert found[2] == "are the two radii, 90 mm and 15 mm, exchanged?"


def test_a_small_rotor_in_another_unit() -> None:
    """0.0012 / 1.8e-9 = 6.7e5 rad/s^2, as of such motors; a hundredth would be 6.7e4."""
    (found,) = said(
        "side: motor, gear_ratio: 256, peak_torque: 0.0012, rotor_inertia: 0.018 kg*cm^2", ", kp: 1, kd: 0.05"
    )
    assert found[1:] == ("motors.m.rotor_inertia", "is it in g*cm^2? 0.018 g*cm^2 is 1.8e-09 kg*m^2")


def test_a_voltage_beside_a_constant_that_gives_the_torque() -> None:
    """0.091 N*m/A x 24 A = 2.18 N*m of 5.4, x 502.7 rad/s = 45.7 V of 48; at the rotor of a gear of 9 0.0112 N*m/A."""
    sheet = (
        "side: motor, torque_constant: 0.091, peak_current: 24 A, nominal_voltage: 4.8 V, no_load_speed: 4800 rpm, "
        "stall_torque: STALL, gear_ratio: 9, efficiency: 90 %"
    )
    (found,) = said(sheet.replace("STALL", "5.4"), ", kp: 40, kd: 1")
    assert found[:2] == ("SPEC181", "motors.m.nominal_voltage")
    assert found[2].startswith(
        "one of 2 numbers is wrong. nominal_voltage: did you mean 48 V? Or torque_constant ("
    )
    # Without a current nothing is said of the constant.
    (found,) = said(sheet.replace("STALL", "5.4").replace("peak_current: 24 A, ", ""), ", kp: 40, kd: 1")
    assert found[1] == "motors.m.torque_constant"


@pytest.mark.parametrize(
    ("delay", "where", "help"),
    [
        # Either may be wrong: 4 ms of 8 ms, or 40 ms of 80 ms.
        (
            "{nominal: 40 ms, range: [0 ms, 8 ms]}",
            "nominal",
            "nominal: did you mean 4 ms? Or range: did you mean [0 ms, 80 ms]? Or widen",
        ),
        # No delay is 5 s, and none 0.4 ms.
        ("{nominal: 5 s, range: [1 ms, 8 ms]}", "nominal", "nominal: did you mean 5 ms? Or widen"),
        ("{nominal: 4 ms, range: [0 ms, 0.8 ms]}", "range", "range: did you mean [0 ms, 8 ms]? Or widen"),
        ("{nominal: 9 ms, range: [5 ms, 8 ms]}", "range", "widen the range or move"),
    ],
)
def test_a_delay_beside_its_range(delay: str, where: str, help: str) -> None:
    text = spec_of(f"legs: {{joints: [hip], level: ideal_pd, kp: 9, kd: 1, delay: {delay}}}, {REST}")
    (found,) = faults_of(text)
    assert found.startswith(f"SPEC110 actuators.legs.delay.{where}: the nominal delay ")
    with pytest.raises(ActspecError) as caught:
        fit(text)
    assert (caught.value.diagnostics[0].help or "").startswith(help)


def test_limits_in_each_others_place(tmp_path: Path) -> None:
    """The file has 1.4 N*m and 12 rad/s: told once, at the effort limit."""
    urdf = (
        '<robot name="arm"><link name="a"/><link name="b"/><joint name="hip" type="revolute"><parent link="a"/>'
        '<child link="b"/><limit lower="-1" upper="1" effort="1.4" velocity="12"/></joint></robot>'
    )
    path = tmp_path / "arm.urdf"
    path.write_text(urdf, encoding="utf-8")
    for source in (", source: own", ""):
        limits = f"effort_limit: {{value: 12{source}}}, velocity_limit: {{value: 1.4 rad/s{source}}}"
        text = (
            "actspec: 1\nrobot: {name: arm, model: arm.urdf}\nsources: {own: {title: file, page: arm.urdf}}\n"
            f"actuators: {{arm: {{joints: [hip], level: ideal_pd, kp: 1, kd: 0.1, {limits}}}}}\n"
        )
        spec = validate(document_from_text(text, str(tmp_path / "s.yaml")))
        items = resolve(spec, joints_of_text(str(path))).diagnostics
        (found,) = [item for item in items if item.code in BY_CODE]
        assert found.where == "actuators.arm.effort_limit"
        assert "exchanged? The file has 1.4 N*m and 12 rad/s" in (found.help or "")
