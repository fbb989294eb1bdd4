"""Limits below what the drive gives, and stall torques of a winding: choices, and no mistakes in other figures."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.cli.main import main
from actspec.diagnostics import ResolveError
from tests.fitting import fit, spec_of
from tests.spec.plausible.test_bounds import REST, codes, said

D6374 = (
    "side: motor, gear_ratio: 8, torque_constant: 0.0551 N*m/A, peak_current: 70 A, nominal_current: 40 A, "
    "no_load_speed: 8400 rpm, nominal_voltage: 56 V, rotor_inertia: 2 kg*cm^2"
)
U15 = "side: motor, gear_ratio: 1, peak_torque: 7, no_load_speed: 3840 rpm, rotor_inertia: 16.5 kg*cm^2"
AK80 = (
    "side: joint, gear_ratio: 9, peak_torque: 18, continuous_torque: 9, stall_torque: 28.5, no_load_speed: 570 rpm, "
    "rotor_inertia: 607 g*cm^2"
)


def of_motor(motor: str, fields: str = "effort_limit: peak") -> str:
    """A spec of one hinge that the motor drives."""
    return spec_of(
        f"legs: {{joints: [hip], motor: m, level: dc_motor, kp: 20, kd: 0.6, {fields}}}, {REST}",
        motors=f"{{m: {{{motor}}}}}",
    )


@pytest.mark.parametrize(
    ("motor", "expected"),
    [
        # 0.0551 x 56 / 0.039 = 79 N*m, of which the drive's 70 A give 3.86.
        (f"{D6374}, stall_torque: 79", []),
        # 24 V of the D5065, 18.8 N*m, and 65 A of it 2 N*m.
        (
            "side: motor, gear_ratio: 8, torque_constant: 0.0306 N*m/A, peak_current: 65 A, stall_torque: 18.8, "
            "no_load_speed: 6480 rpm, nominal_voltage: 24 V, rotor_inertia: 0.9 kg*cm^2",
            [],
        ),
        # 3.86 of 964 N*m is a 250th, of 966 less: that is no winding's.
        (f"{D6374}, stall_torque: 964", []),
        (f"{D6374}, stall_torque: 966", ["SPEC183"]),
        (f"{D6374}, stall_torque: 79000", ["SPEC183!"]),
        # Without a current nobody knows what the drive gives.
        (f"{D6374.replace('peak_current: 70 A, ', '')}, stall_torque: 79", ["SPEC183"]),
    ],
)
def test_the_stall_torque_of_a_winding_whose_drive_is_stated_by_its_current(
    motor: str, expected: list[str]
) -> None:
    assert codes(of_motor(motor, "effort_limit: 20")) == expected


@pytest.mark.parametrize(
    ("motor", "expected"),
    [
        # 402 rad/s x sqrt(7) = 1064 of 1000. 7 x 402 / 48 = 58.6 A; of 28 V, 100.5 A.
        (f"{U15}, nominal_voltage: 48 V", []),
        (f"{U15}, nominal_voltage: 28.2 V", []),
        (f"{U15}, nominal_voltage: 28.1 V", ["SPEC184"]),
        (U15, ["SPEC184"]),
        # A constant says more: 0.0119 x 402 of 48 V is a tenth.
        (f"{U15}, nominal_voltage: 48 V, torque_constant: 0.0119 N*m/A", ["SPEC181"]),
    ],
)
def test_a_direct_drive_is_as_fast_as_its_voltage_feeds(motor: str, expected: list[str]) -> None:
    assert codes(of_motor(motor)) == expected


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        # 0.03 x 59.69 rad/s = 1.79 N*m, a tenth of the drive's 18 N*m, whatever the limit is.
        ("effort_limit: 3 N*m, friction: {viscous: 0.03}", None),
        ("effort_limit: peak, friction: {viscous: 0.03}", None),
        (
            "effort_limit: 3 N*m, friction: {viscous: 0.16}",
            "9.55 N*m at the joint's 59.69 rad/s, of the drive's 18",
        ),
        (
            "effort_limit: peak, friction: {viscous: 0.16}",
            "at the joint's 59.69 rad/s, of an effort limit of 18 N*m",
        ),
    ],
)
def test_viscous_friction_is_judged_by_what_the_drive_gives(fields: str, message: str | None) -> None:
    found = said(of_motor(AK80, fields))
    assert [item.code for item in found] == ["FRC106"] * (message is not None)
    assert all((message or "") in item.message for item in found)


SERVO = "side: joint, gear_ratio: 9, no_load_speed: 10 rad/s"


@pytest.mark.parametrize(
    ("motor", "fields", "message"),
    [
        # 0.3 x 10 = 3 N*m, of the 20 that the motor has at rest, of which 5 N*m are allowed, or are what it keeps.
        ("stall_torque: 20", "effort_limit: 5, friction: {viscous: 0.3}", None),
        ("stall_torque: 20, continuous_torque: 5", "friction: {viscous: 0.3}", None),
        (
            "stall_torque: 20",
            "level: ideal_pd, effort_limit: 5, velocity_limit: 9 rad/s, friction: {viscous: 0.6}",
            None,
        ),
        # 1.01 x 10 = 10.1 N*m of 20.
        ("stall_torque: 20", "effort_limit: 5, friction: {viscous: 1.01}", "FRC106 of the drive's 20 N*m"),
        # Of 51 N*m, a winding's, nobody knows what the drive gives; nor is more than the peak torque.
        (
            "stall_torque: 51",
            "effort_limit: 5, friction: {viscous: 0.3}",
            "FRC106 of an effort limit of 5 N*m",
        ),
        (
            "stall_torque: 20, peak_torque: 5",
            "friction: {viscous: 0.3}",
            "FRC106 of an effort limit of 5 N*m",
        ),
        # 5 / 2 is 2.5 rad/s^2 and 20 / 2 is 10; 20 / 4.1 is 4.88.
        ("stall_torque: 20", "effort_limit: 5, armature: 2", None),
        (
            "stall_torque: 20",
            "effort_limit: 5, armature: 4.1",
            "SPEC191 the drive's 20 N*m would turn the rotor alone",
        ),
        (
            "stall_torque: 20, peak_torque: 5",
            "armature: 2",
            "SPEC191 the effort limit of 5 N*m would turn the rotor",
        ),
    ],
)
def test_a_stall_torque_that_stands_alone_is_what_the_drive_gives(
    motor: str, fields: str, message: str | None
) -> None:
    text = of_motor(f"{SERVO}, {motor}", fields)
    if fields.startswith("level"):
        text = text.replace("level: dc_motor, ", "")
    if "armature" in fields:
        # A speed that is reached in 0.2 s would do.
        text = text.replace("no_load_speed: 10 rad/s", "no_load_speed: 20 rad/s").replace("kp: 20", "kp: 80")
    found = said(text)
    code, _, words = (message or "").partition(" ")
    assert [item.code for item in found] == [code] * (message is not None)
    assert all(words in item.message for item in found)


LIFT = (
    "side: motor, stall_torque: 1.46, peak_torque: 0.4, continuous_torque: 0.128, no_load_speed: 6110 rpm, "
    "rotor_inertia: 181 g*cm^2"
)


@pytest.mark.parametrize(
    ("gearbox", "fields", "expected"),
    [
        # 181 g*cm^2 x (2 pi / 10 mm)^2 = 7.146 kg; 23 N of 226 N.
        ("[{lead: 10 mm/rev, efficiency: 0.9}]", "effort_limit: 23 N", []),
        # x 25 x 4, 714.6 kg: its 1257 N are 1.76 m/s^2, and take it to 0.102 m/s in 0.06 s.
        ("[{ratio: 5}, {lead: 5 mm/rev, efficiency: 0.5}]", "effort_limit: 300 N", []),
        # g as kg: 226 N of 7146 kg.
        ("[{lead: 10 mm/rev, efficiency: 0.9}]", "effort_limit: 23 N, armature: 7146", ["SPEC191"]),
    ],
)
def test_a_screw_whose_force_is_limited_turns_its_rotor(
    gearbox: str, fields: str, expected: list[str]
) -> None:
    motor = LIFT.removesuffix(", rotor_inertia: 181 g*cm^2") if expected else LIFT
    text = spec_of(
        f"lift: {{joints: [slide], motor: m, level: ideal_pd, kp: 20000 N/m, kd: 600 N*s/m, {fields}}}, "
        "legs: {joints: [hip, calf], level: ideal_pd, command: effort}",
        motors=f"{{m: {{{motor}, gearbox: {gearbox}}}}}",
    )
    found = said(text)
    assert [item.code for item in found] == expected
    assert all(
        "the drive's 226.2 N would turn the rotor alone with 0.0317 m/s^2" in item.message for item in found
    )


@pytest.mark.parametrize(
    ("scale", "help"),
    [
        # 50 mm of 350; 0.5 m, as a percentage, would be more than the whole range.
        ("50", "is it in mm? Then write 0.05"),
        ("20", "is it in mm? Then write 0.02; or is it in %? Then write 0.2"),
        ("400", None),
    ],
)
def test_what_is_offered_for_one_unit_of_action_lies_within_the_range(scale: str, help: str | None) -> None:
    robot = "name: leg, model: none, joints: [hip, calf, {name: slide, kind: slide, range: [0 m, 0.35 m]}]"
    text = spec_of(
        "lift: {joints: [slide], level: ideal_pd, kp: 20000 N/m, kd: 600 N*s/m, effort_limit: 226 N, "
        f"action_scale: {scale}}}, legs: {{joints: [hip, calf], level: ideal_pd, command: effort}}",
        robot=robot,
    )
    (found,) = said(text)
    assert (found.code, found.help) == ("SPEC193", help)


def test_a_wheel_with_a_wrong_speed_has_no_wrong_action_scale_beside_it() -> None:
    """3.19 rpm for 3190 behind a gear of 6 are 0.056 rad/s, of which 10 rad/s are 180 times."""
    motor = "side: motor, gear_ratio: 6, stall_torque: 4.94, peak_torque: 1.4, no_load_speed: 3.19 rpm"
    text = of_motor(motor, "effort_limit: peak, command: velocity, action_scale: 10").replace("kp: 20, ", "")
    (found,) = said(text)
    assert (found.code, found.where) == ("SPEC184", "motors.m.no_load_speed")


MODEL = """<mujoco><worldbody><body name="link"><joint name="hip" axis="0 1 0"/>
<inertial pos="0 0 -0.2" mass="1" diaginertia="0.02 0.02 0.02"/></body></worldbody></mujoco>"""


@pytest.mark.parametrize(("viscous", "told"), [(0.03, 0), (0.3, 1)])
def test_the_audit_says_of_a_spec_and_its_build_what_the_spec_is_told(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    viscous: float,
    told: int,
) -> None:
    """With 3 N*m allowed of 18: 0.3 x 59.69 is 17.9 N*m, which is told once, of the spec."""
    monkeypatch.chdir(tmp_path)
    text = spec_of(
        "legs: {joints: [hip], motor: m, level: dc_motor, kp: 20, kd: 0.6, effort_limit: 3 N*m, "
        f"friction: {{coulomb: 0.25, viscous: {viscous}}}}}",
        robot="name: leg, model: leg.xml",
        motors=f"{{m: {{{AK80}}}}}",
        more="targets: {isaaclab: {}, mjlab: {}}",
    )
    (tmp_path / "leg.xml").write_text(MODEL, encoding="utf-8")
    (tmp_path / "leg.yaml").write_text(text, encoding="utf-8")
    assert main(["compile", "leg.yaml", "-o", "out"]) == 0
    capsys.readouterr()
    for files in (["leg.yaml", "out"], ["leg.yaml"]):
        main(["audit", *files, "--exit-zero"])
        said_of = "".join(capsys.readouterr())
        assert said_of.count("FRC106 [warning]") == told, said_of
    # Alone a file knows of its drive what its torque-speed line says: 28.5 N*m.
    main(["audit", "out", "--exit-zero"])
    assert ("FRC106" in "".join(capsys.readouterr())) == bool(told)


@pytest.mark.parametrize(
    "fields",
    [
        "kp: 20000 N/m, kd: 600 N*s/m, effort_limit: 0.4 N*m",
        "kp: 20000 N/m, kd: 600 N*s/m, velocity_limit: 5 rad/s",
        "kp: 5 N*m/rad, kd: 600 N*s/m",
    ],
)
def test_of_a_number_of_the_wrong_kind_of_joint_nothing_else_is_told(fields: str) -> None:
    text = spec_of(
        f"lift: {{joints: [slide], motor: m, level: ideal_pd, {fields}}}, "
        "legs: {joints: [hip, calf], level: ideal_pd, command: effort}",
        motors=f"{{m: {{{LIFT}, gearbox: [{{lead: 10 mm/rev, efficiency: 0.9}}]}}}}",
    )
    with pytest.raises(ResolveError) as caught:
        fit(text)
    assert [item.code for item in caught.value.diagnostics] == ["RES001"]
