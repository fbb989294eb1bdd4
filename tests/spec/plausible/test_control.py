"""Numbers of control, joints and randomisation: just inside and just outside of the bounds, and what was meant."""

from __future__ import annotations

import pytest

from actspec.cli.main import main
from actspec.diagnostics import ActspecError, Diagnostic
from tests.fitting import fit, spec_of
from tests.spec.plausible.test_bounds import REST, codes, said

LEGS = "name: leg, model: none, joints: [hip, calf, {name: slide, kind: slide}]"
ARM = "name: arm, model: none, joints: [hip, elbow, {name: slide, kind: slide}]"
MOTORS = "{m: {side: joint, stall_torque: 20, no_load_speed: 10 rad/s}}"


def of_group(fields: str, *, more: str = "") -> str:
    """A spec with one hinge that has a motor of 20 N*m and 10 rad/s."""
    gains = "kp: 20, kd: 1, " * (not fields.startswith(("kp:", "command:")))
    groups = f"legs: {{joints: [hip], level: ideal_pd, motor: m, {gains}{fields}}}, {REST}"
    return spec_of(groups, motors=MOTORS, more=more)


def one(text: str) -> tuple[str, str, str | None]:
    """Code, place and help of the only thing that is said."""
    (found,) = said(text)
    return found.code, found.where, found.help


@pytest.mark.parametrize(
    ("robot", "timing", "help"),
    [
        # 1 / (5 ms x 50) = 4 Hz, and 4 steps are 50 Hz; 1 / (5 ms x 40) = 5 Hz.
        (LEGS, "physics_dt: 5 ms, decimation: 50", "did you mean 4 (50 Hz)?"),
        (LEGS, "physics_dt: 5 ms, decimation: 40", "did you mean 5 (40 Hz)?"),
        # 1 / (2 ms x 50) = 10 Hz, 10 steps are 50 Hz.
        (LEGS, "physics_dt: 2 ms, decimation: 50", "did you mean 10 (50 Hz)?"),
        # 1 / (1 ms x 50) = 20 Hz, at which an A1 learned to walk.
        (LEGS, "physics_dt: 1 ms, decimation: 50", None),
        # 9.8 Hz are no legs', and 50 steps of 2.05 ms no whole number of Hz; 10.2 Hz may be.
        (LEGS, "physics_dt: 2.05 ms, decimation: 50", "decimation is the number"),
        (LEGS, "physics_dt: 1.95 ms, decimation: 50", None),
        # 10 Hz, and 20 is no rate of `RATES`.
        (LEGS, "physics_dt: 5 ms, decimation: 20", None),
        (LEGS, "physics_dt: 5 ms, decimation: 4", None),
        # Arms are controlled at 5 Hz, too; beyond 0.5 s nothing is.
        (ARM, "physics_dt: 5 ms, decimation: 40", None),
        (ARM, "physics_dt: 10 ms, decimation: 100", "did you mean 1 (100 Hz)?"),
    ],
)
def test_a_rate_as_a_number_of_steps(robot: str, timing: str, help: str | None) -> None:
    groups = "a: {joints: [hip], level: ideal_pd, kp: 20, kd: 1}, " + REST
    if robot == ARM:
        groups = groups.replace("calf", "elbow")
    found = said(spec_of(groups, robot=robot, more=f"timing: {{{timing}}}"))
    assert [(item.code, item.where) for item in found] == [("SPEC186", "timing.decimation")] * (
        help is not None
    )
    assert all((item.help or "").startswith(help or "") for item in found)


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        ("delay: 5 ms, randomize: {delay: {add: [0 s, 0.25 s]}}", []),
        ("delay: 5 ms, randomize: {delay: {add: [0 s, 0.26 s]}}", ["SPEC186"]),
        ("delay: 5 ms, randomize: {delay: {add: [0 s, 10 s]}}", ["SPEC186!"]),
        # A jitter is below 0 as often, or as small as one likes.
        ("delay: 5 ms, randomize: {delay: {add: [-2 ms, 2 ms]}}", []),
        ("delay: 5 ms, randomize: {delay: {add: [-10 us, 10 us]}}", []),
        ("delay: 5 ms, randomize: {delay: {abs: [5 s, 15 s]}}", ["SPEC186!"]),
        ("delay: 5 ms, randomize: {delay: {abs: [2 ms, 15 ms]}}", []),
        # 4.5 x 5 ms.
        ("delay: 5 ms, randomize: {delay: {scale: [0.5, 4.5]}}", []),
        # The control period is 5 ms x 4.
        ("randomize: {kp: {scale: [0.9, 1.1], when: interval, every: [5 ms, 20 ms]}}", []),
        ("randomize: {kp: {scale: [0.9, 1.1], when: interval, every: [5 ms, 19 ms]}}", ["SPEC186"]),
        ("randomize: {kp: {scale: [0.9, 1.1], when: interval, every: [0 ms, 0 ms]}}", []),
        # Of 20 N*m: half, and 5 x 2 N*m; what the drive never overcomes, whatever the kinetic one is.
        ("effort_limit: 20, friction: {coulomb: 2, static: 9.9}", []),
        ("effort_limit: 20, friction: {coulomb: 2, static: 10.1}", ["FRC101"]),
        ("effort_limit: 20, friction: {coulomb: 9, static: 18}", []),
        ("effort_limit: 20, friction: {coulomb: 9, static: 20}", ["FRC101"]),
        ("effort_limit: 20, friction: {coulomb: 2, static: 41}", ["FRC101!"]),
        # Without an effort limit of the spec the motor's 20 N*m.
        ("friction: {coulomb: 2, static: 10.1}", ["FRC101"]),
        # Each number once.
        ("effort_limit: 20, friction: {coulomb: 12, static: 15}", ["FRC101"]),
        ("friction: {coulomb: 0.1, static: 0.2, stribeck_velocity: 9.9 rad/s}", []),
        ("friction: {coulomb: 0.1, static: 0.2, stribeck_velocity: 10.1 rad/s}", ["SPEC184"]),
        # 20 x 0.0101 and 20 x 0.0099 of 0.2 N*m.
        ("friction: {coulomb: 0.2}, action_scale: 0.0101", []),
        ("friction: {coulomb: 0.2}, action_scale: 0.0099", ["SPEC193"]),
        # The sign of a unit of action is what the policy was trained with.
        ("friction: {coulomb: 0.2}, action_scale: -0.25", []),
        ("armature: {value: 0.01, std: 0.1}", []),
        ("armature: {value: 0.01, std: 0.101}", ["SPEC188"]),
        ("friction: {coulomb: {value: 0.01, std: 0.11}}", ["SPEC188"]),
        ("encoder_bias: {value: 0.0001 rad, std: 0.01 rad}", []),
        # Five times the motor's 10 rad/s: 90 x 0.10472 = 9.4 rad/s, 119 x 0.0174533 = 2.08.
        ("command: velocity, kd: 1, command_range: [-49 rad/s, 49 rad/s]", []),
        ("command: velocity, kd: 1, command_range: [-90 rad/s, 90 rad/s]", ["SPEC190"]),
        ("command: velocity, kd: 1, command_range: [-119 rad/s, 5 rad/s]", ["SPEC190"]),
        ("command: velocity, kd: 1, command_range: [-1000 rad/s, 1000 rad/s]", []),
        ("command: effort, command_range: [-239 N*m, 239 N*m]", []),
        ("command: effort, command_range: [-241 N*m, 241 N*m]", ["SPEC190"]),
    ],
)
def test_groups(fields: str, expected: list[str]) -> None:
    assert codes(of_group(fields, more="timing: {physics_dt: 5 ms, decimation: 4}")) == expected


@pytest.mark.parametrize(
    ("fields", "where", "help"),
    [
        (
            "effort_limit: 20, friction: {coulomb: 0.8, static: 12}",
            "friction.static",
            "did you mean 1.2 N*m?",
        ),
        (
            "effort_limit: 20, friction: {coulomb: 0.8, static: 120}",
            "friction.static",
            "did you mean 1.2 N*m?",
        ),
        (
            "delay: 5 ms, randomize: {delay: {add: [0 s, 10 s]}}",
            "randomize.delay.add[1]",
            "did you mean 10 ms?",
        ),
        ("delay: 4 us", "delay", "did you mean 4 ms?"),
        ("delay: {nominal: 4 us, range: [2 us, 8 us]}", "delay.nominal", "did you mean 4 ms?"),
        # One end of two.
        ("randomize: {kd: {scale: [0.5, 1500]}}", "randomize.kd.scale[1]", "did you mean 1.5?"),
        # 0.00436 / 0.0174533 = 0.2498.
        (
            "friction: {coulomb: 0.2}, action_scale: 0.00436",
            "action_scale",
            "is it turned from degrees into rad twice? Once it is 0.2498.",
        ),
        # 20 N*m / 1 are 20 rad and 20 / 2.1 are 9.5; 1 x 0.25 and 2.1 x 0.25 = 0.525 are below the friction.
        (
            "kp: 1, kd: 0.02, friction: {coulomb: 0.3}, action_scale: 0.25",
            "kp",
            "is it per degree? Per radian it is 57.3 N*m/rad, and kd 57.3 times as well",
        ),
        (
            "kp: 2.1, kd: 0.04, friction: {coulomb: 0.6}, action_scale: 0.25",
            "action_scale",
            # Not from degrees: 0.25 / 0.0174533 = 14.32 rad is more than twice a whole turn, 12.57 rad.
            "look for the point in the wrong place",
        ),
        # The friction holds it within 0.6 / 2.1 = 0.29 rad, and kd is below the viscous friction.
        (
            "kp: 2.1, kd: 0.04, friction: {coulomb: 0.6, viscous: 0.05}, action_scale: 0.25",
            "kp",
            "is it per degree? Per radian it is 120.3 N*m/rad, and kd 57.3 times as well",
        ),
        # Within 0.6 / 20 = 0.03 rad: the gains are sound, and 0.01 / 0.0174533 = 0.573.
        (
            "kp: 20, kd: 0.5, friction: {coulomb: 0.6, viscous: 0.6}, action_scale: 0.01",
            "action_scale",
            "is it turned from degrees into rad twice? Once it is 0.573.",
        ),
        # By 60 x 20 N*m / 0.1 rad = 12000 N*m/rad, and 0.6 x 20 / 0.001745 = 6875 N*m/rad.
        (
            "kp: {derive: torque_at_error, fraction: 60, error: 0.1 rad}, kd: 1, effort_limit: 20",
            "kp.fraction",
            "is it in %? 60 % is 0.6",
        ),
        (
            "kp: {derive: torque_at_error, fraction: 0.6, error: 0.1 deg}, kd: 1, effort_limit: 20",
            "kp.error",
            "is it in rad? Then write 0.1 rad",
        ),
        # 20 x 0.6 / 57.3 rad = 0.21 N*m/rad: an error of 95 rad for the limit.
        (
            "kp: {derive: torque_at_error, fraction: 0.6, error: 57.3 rad}, kd: 0.1, effort_limit: 20",
            "kp.error",
            "is it in degrees? Then write 57.3 deg",
        ),
        # 628 / 2 pi = 99.95; 10 kHz / 1000.
        (
            "kp: {derive: natural_frequency, frequency: 628 Hz, inertia: 0.1}, kd: 1",
            "kp.frequency",
            "is it in rad/s? Then it is 99.95 Hz",
        ),
        (
            "kp: {derive: natural_frequency, frequency: 10 kHz, inertia: 0.1}, kd: 1",
            "kp.frequency",
            "did you mean 10 Hz?",
        ),
        (
            "command: velocity, kd: 1, command_range: [-90 rad/s, 90 rad/s]",
            "command_range",
            "is it in rpm? Then write [-90 rpm, 90 rpm]",
        ),
        ("command: velocity, kd: 1, action_scale: 400", "action_scale", "is it in deg/s? Then write 6.98132"),
    ],
)
def test_what_was_meant(fields: str, where: str, help: str) -> None:
    code, place, said_help = one(of_group(fields))
    assert place == f"actuators.legs.{where}", code
    assert (said_help or "").startswith(help)


MODEL = """<mujoco><compiler angle="radian"/><worldbody><body>
<joint name="hip" axis="0 1 0"/><inertial pos="0 0 0" mass="1" diaginertia="1 0.1 1"/></body>
</worldbody></mujoco>"""
"""A link of 0.1 kg*m^2 about its joint."""


@pytest.mark.parametrize(
    ("fields", "model", "expected"),
    [
        # 20 N*m turn 1.01 kg*m^2 in 1.01 x 10 / 20 = 0.505 s to 10 rad/s, which is 10.1 times the link.
        ("kp: 60, kd: 2, armature: 1.01", MODEL, ["SPEC191"]),
        ("kp: 60, kd: 2, armature: 0.99", MODEL, []),
        # The link is not known: sqrt(36 / 1.01) = 5.97 rad/s, sqrt(37 / 1.01) = 6.05.
        ("kp: 36, kd: 2, armature: 1.01", None, ["SPEC191"]),
        ("kp: 37, kd: 2, armature: 1.01", None, []),
    ],
)
def test_a_heavy_armature(fields: str, model: str | None, expected: list[str]) -> None:
    robot = "name: leg, model: robot.xml" if model else "name: leg, model: none, joints: [hip]"
    groups = f"legs: {{joints: [hip], level: ideal_pd, motor: m, {fields}}}"
    assert codes(spec_of(groups, robot=robot, motors=MOTORS), model) == expected


@pytest.mark.parametrize(
    ("ends", "help"),
    [
        ("[-1.57 deg, 1.57 deg]", "is it in rad? Then write [-1.57 rad, 1.57 rad]"),
        # pi / 4 and 2 pi / 3.
        ("[0 deg, 2.094 deg]", "is it in rad? Then write [0 rad, 2.094 rad]"),
        ("[-1.6 deg, 1.6 deg]", None),
        ("[-1.57 deg, 2 deg]", None),
        ("[-90 deg, 90 deg]", None),
        ("[-1.57 rad, 1.57 rad]", None),
    ],
)
def test_a_range_in_rad_as_degrees(ends: str, help: str | None) -> None:
    robot = f"name: arm, model: none, joints: [{{name: hip, range: {ends}}}]"
    found = said(spec_of("a: {joints: [hip], level: ideal_pd, kp: 1, kd: 0.1}", robot=robot))
    assert [(item.code, item.where, item.help) for item in found] == (
        [("SPEC190", "robot.joints[0].range", help)] if help else []
    )


@pytest.mark.parametrize(
    ("bandwidth", "help"),
    [("2 Hz", None), ("1.9 Hz", "is it in kHz? Then it is 1900 Hz"), ("0.5 Hz", "500 Hz")],
)
def test_a_bandwidth_in_kilohertz(bandwidth: str, help: str | None) -> None:
    text = spec_of(
        f"a: {{joints: [hip], level: ideal_pd, motor: m, kp: 20, kd: 1}}, {REST}",
        motors=f"{{m: {{bandwidth: {bandwidth}}}}}",
    )
    found = said(text)
    assert [item.where for item in found] == ["motors.m.bandwidth"] * (help is not None)
    assert all((item.help or "").endswith(help or "") for item in found)


SERVO = """<mujoco><worldbody><body><joint name="hip"/><geom size="0.1"/></body></worldbody>
<actuator><position joint="hip" kp="25" kv="0.5"/></actuator></mujoco>"""


@pytest.mark.parametrize(
    ("kp", "kd", "expected"),
    [
        # kp alone: 0.025 of 25, a thousandth, beside a kd that would take 0.5 / 0.025 = 20 s.
        ("0.025", "0.5", [("SPEC194", "kp")]),
        # Both, exchanged: 0.5 of 25 and 25 of 0.5.
        ("0.5", "25", [("SPEC192", "kp")]),
    ],
)
def test_gains_of_a_source_have_one_message(kp: str, kd: str, expected: list[tuple[str, str]]) -> None:
    text = spec_of(
        f"legs: {{joints: [hip], level: ideal_pd, kp: {{value: {kp}, source: file}}, "
        f"kd: {{value: {kd}, source: file}}}}",
        robot="name: leg, model: robot.xml",
        more="sources: {file: {title: T, page: robot.xml}}",
    )
    assert [(item.code, item.where.rpartition(".")[2]) for item in said(text, SERVO)] == expected


@pytest.mark.parametrize(
    ("step", "help"),
    [
        # 1 / 200 Hz = 5 ms; a tenth of 200 ms.
        ("200 ms", "is it a rate? The step of 200 Hz is 5 ms; or did you mean 20 ms?"),
        ("500 s", "is it a rate? The step of 500 Hz is 2 ms"),
        # 1 / 100 Hz and a tenth of 100 ms, a thousandth of 1000 ms and 1 / 1000 Hz are one.
        ("100 ms", "is it a rate? The step of 100 Hz is 10 ms"),
        ("1000 ms", "is it a rate? The step of 1000 Hz is 1 ms"),
        ("220 ms", "did you mean 22 ms?"),
        ("0.2 s", "did you mean 20 ms?"),
    ],
)
def test_a_step_that_is_a_rate(step: str, help: str) -> None:
    groups = f"a: {{joints: [hip], level: ideal_pd, kp: 20, kd: 1}}, {REST}"
    assert one(spec_of(groups, more=f"timing: {{physics_dt: {step}}}")) == (
        "SPEC186",
        "timing.physics_dt",
        help,
    )


@pytest.mark.parametrize(
    ("cutoff", "help"),
    [
        # 1 / (2 pi 0.0053 s) = 30.03 Hz, and 0.0053 kHz.
        (
            "0.0053 Hz",
            "is it a time constant of 0.0053 s? Then it is 30.03 Hz; or is it in kHz? Then it is 5.3 Hz",
        ),
        # 1 / (2 pi 0.05 s) = 3.183 Hz.
        (
            "0.05 Hz",
            "is it in kHz? Then it is 50 Hz; or is it a time constant of 0.05 s? Then it is 3.183 Hz",
        ),
        # 0.1 Hz is none; 1 / (2 pi 1e-4 s) = 1592 Hz.
        ("0.0001 Hz", "is it a time constant of 0.0001 s? Then it is 1592 Hz"),
        ("30 kHz", "look for a wrong unit, or the point in the wrong place"),
    ],
)
def test_a_cutoff_that_is_a_time_constant(cutoff: str, help: str) -> None:
    text = of_group(f"command_filter: {{cutoff: {cutoff}}}")
    assert one(text) == ("SPEC186", "actuators.legs.command_filter.cutoff", help)


@pytest.mark.parametrize(
    ("field", "said_of"),
    [
        (
            "effort_limit: {value: 4 mN*m, source: file}",
            "4 mN*m names file as its source, the robot's file, which has 4 N*m: did you mean 4 N*m?",
        ),
        (
            "kp: {value: 25 N*m/deg, source: file}",
            "25 N*m/deg names file as its source, the robot's file, which has 25 N*m/rad: did you mean 25 N*m/rad?",
        ),
        # 4000 N*m is another number: the unit is as good as any.
        (
            "effort_limit: {value: 0.004 N*m, source: file}",
            "0.004 N*m names file as its source, the robot's file, which has 4 N*m: is the point in the wrong place? "
            "Then it is 4 N*m",
        ),
        (
            "armature: {value: 50 kg*m^2, source: file}",
            "50 kg*m^2 names file as its source, the robot's file, which has 0.05 kg*m^2: is it in g*m^2? Then it is "
            "0.05 kg*m^2",
        ),
    ],
)
def test_the_unit_as_written_is_the_suspect(field: str, said_of: str) -> None:
    text = spec_of(
        f"legs: {{joints: [hip], level: ideal_pd, kd: 0.5, {'' if 'kp' in field else 'kp: 25, '}{field}}}",
        robot="name: leg, model: robot.xml",
        more="sources: {file: {title: T, page: robot.xml}}",
    )
    servo = SERVO.replace('kv="0.5"', 'kv="0.5" forcerange="-4 4"').replace(
        'joint name="hip"', 'joint name="hip" armature="0.05"'
    )
    found = next(item for item in said(text, servo) if item.code == "SPEC194")
    assert f"{found.message.partition(': ')[2]}: {found.help}" == said_of


@pytest.mark.parametrize(
    ("armature", "help"),
    [
        # 20 / 1e-6 = 2e7 rad/s^2; 20 / 0.01 = 2000, and of 1e-5 kg*m^2 2e6.
        (
            "0.01 kg*cm^2",
            "did you mean 0.01 kg*m^2? Or is it the rotor's own, before the gear? The armature is rotor inertia x "
            "gear^2",
        ),
        # 20 / 1e-5, and nothing else is written.
        ("0.00001 kg*m^2", "is it the rotor's own, before the gear? The armature is rotor inertia x gear^2"),
        # 400 kg*m^2 are no armature, either: 20 / 400 = 0.05.
        ("400 g*mm^2", "is it the rotor's own, before the gear? The armature is rotor inertia x gear^2"),
    ],
)
def test_an_armature_in_a_unit_of_rotors(armature: str, help: str) -> None:
    text = spec_of(
        f"legs: {{joints: [hip], level: ideal_pd, kp: 20, kd: 1, effort_limit: 20, armature: {armature}}}",
        robot="name: leg, model: robot.xml",
    )
    (found,) = said(text, MODEL)
    assert (found.code, found.help) == ("SPEC191", help)


def test_a_viscous_friction_per_degree() -> None:
    """1 N*m*s/deg are 57.3, times 10 rad/s 573 of 20 N*m; 1 N*m*s/rad takes 10 N*m, half of that, so 0.9 is less."""
    text = of_group("level: dc_motor, friction: {viscous: 0.9 N*m*s/deg}").replace(
        "level: ideal_pd, motor", "motor"
    )
    code, where, help = one(text)
    assert (code, where) == ("FRC106", "actuators.legs.friction.viscous")
    assert help is not None and help.startswith("did you mean 0.9 N*m*s/rad? ")


@pytest.mark.parametrize(
    ("kp", "help"),
    [
        # The file's own: whatever it is, it was not mistyped.
        ("300000", None),
        # 4 / 200000 = 2e-5 rad, 0.8 / 200000 = 4e-6 s; of 20 N*m/rad 0.2 rad and 0.04 s, both as usual.
        ("200000", "did you mean 20 N*m/rad?"),
    ],
)
def test_a_stiff_servo_without_a_motor(kp: str, help: str | None) -> None:
    text = spec_of(
        f"legs: {{joints: [hip], level: ideal_pd, kp: {kp}, kd: 0.8, effort_limit: 4}}",
        robot="name: leg, model: robot.xml",
    )
    servo = SERVO.replace('kp="25" kv="0.5"', 'kp="300000" kv="0.8" forcerange="-4 4"')
    assert [(item.code, item.where, item.help) for item in said(text, servo)] == [
        ("SPEC192", "actuators.legs.kp", help)
    ] * (help is not None)


def test_a_gain_of_a_slide_per_millimetre() -> None:
    """2 of the file's 2000 N/m, which N/mm are; beside it kd, which the file has."""
    text = spec_of(
        "a: {joints: [hip], level: ideal_pd, kp: {value: 2 N/m, source: file}, kd: {value: 20 N*s/m, source: file}}",
        robot="name: leg, model: robot.xml",
        more="sources: {file: {title: T, page: robot.xml}}",
    )
    model = SERVO.replace('"hip"/><', '"hip" type="slide"/><').replace(
        'kp="25" kv="0.5"', 'kp="2000" kv="20"'
    )
    (found,) = said(text, model)
    assert (found.code, found.help) == ("SPEC194", "is it per mm? Then it is 2000 N/m")


def validated(text: str, tmp_path: object, capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    """Exit code and output of `actspec validate`."""
    path = f"{tmp_path}/s.yaml"
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)
    code = main(["validate", path])
    caught = capsys.readouterr()
    return code, caught.out + caught.err


RANDOM = "targets: {randomization: {for: [json]}}"


@pytest.mark.parametrize(
    ("entry", "more", "expected"),
    [
        # 200 to 300 for a nominal 20 N*m/rad are all above ten times that, which is told itself; 25 to 30 are not.
        ("kp: {abs: [25, 30]}", RANDOM, ["RND006"]),
        ("kp: {abs: [201, 300]}", RANDOM, ["SPEC188"]),
        ("friction.coulomb: {add: [0.8 N*m, 1.2 N*m]}", RANDOM, ["RND006"]),
        # 20 x (0.8 - 3 x 1.2) = -56.
        ("kp: {scale: [0.8, 1.2], distribution: gaussian}", RANDOM, ["RND005"]),
        ("friction.coulomb: {add: [-0.3 N*m, 0.1 N*m]}", RANDOM, ["RND004"]),
        ("kp: {scale: [0.8, 1.2]}", RANDOM, []),
        # No target draws them.
        ("kp: {abs: [25, 30]}", "", []),
    ],
)
def test_validate_tells_what_the_target_would(
    entry: str, more: str, expected: list[str], tmp_path: object, capsys: pytest.CaptureFixture[str]
) -> None:
    """Those of `compile`, each once there and here."""
    text = of_group(f"friction: {{coulomb: 0.2}}, randomize: {{{entry}}}", more=more)
    code, output = validated(text, tmp_path, capsys)
    assert [word for word in output.split() if word.startswith(("RND0", "SPEC18", "SPEC19"))] == expected
    assert code == (2 if "RND004" in expected else 0)
    main(["compile", f"{tmp_path}/s.yaml", "-o", f"{tmp_path}/out"])
    caught = capsys.readouterr()
    told = [
        word for word in (caught.out + caught.err).split() if word.startswith(("RND0", "SPEC18", "SPEC19"))
    ]
    assert told == expected


@pytest.mark.parametrize(
    ("entry", "code", "help"),
    [
        # Of 60 N*m/rad a tenth or a hundredth of that is none; 1 lies between them.
        ("kp: {abs: [0.8, 1.2]}", "SPEC188", "are they factors? Then write `scale: [0.8, 1.2]`"),
        # No tenth of these has 2 or 60 in it.
        ("kd: {abs: [48, 72]}", "SPEC188", "look for a wrong unit, or another joint's range"),
        ("kp: {abs: [610, 720]}", "SPEC188", "look for a wrong unit, or another joint's range"),
        ("kp: {abs: [4.8, 5.9]}", "SPEC188", "look for a wrong unit, or another joint's range"),
        ("kp: {abs: [0.48, 0.72]}", "SPEC188", "did you mean 48 N*m/rad and 72 N*m/rad?"),
        # What has a unit is no factor; nor is what would be told as one, of an effort limit of 20 N*m.
        (
            "kp: {abs: [0.8 N*m/rad, 1.2 N*m/rad]}",
            "SPEC188",
            "look for a wrong unit, or another joint's range",
        ),
        (
            "effort_limit: {abs: [0.8 N*m, 1.2 N*m]}",
            "SPEC188",
            "look for a wrong unit, or another joint's range",
        ),
        ("effort_limit: {abs: [0.8, 4.1]}", "RND006", "widen the range, or correct the nominal"),
        ("effort_limit: {abs: [0.8, 3]}", "RND006", "are they factors? Then write `scale: [0.8, 3]`"),
        # An armature of 0.0125 kg*m^2; it has a nominal of the motor alone.
        ("armature: {abs: [0.9, 1.1]}", "SPEC188", "are they factors? Then write `scale: [0.9, 1.1]`"),
        ("friction.coulomb: {scale: [0.2, 0.6]}", "RND006", "are they values? Then write `abs: [0.2, 0.6]`"),
        ("friction.coulomb: {scale: [0.5, 0.7]}", "RND006", "widen the range"),
        # Factors, and not above the static friction of 0.65 N*m as well (RND007).
        ("friction.coulomb: {abs: [0.5, 1.5]}", "RND006", "are they factors? Then write `scale: [0.5, 1.5]`"),
        ("kp: {abs: [65, 70]}", "RND006", "widen the range, or correct the nominal"),
    ],
)
def test_a_range_that_is_offered_has_the_nominal_in_it(
    entry: str, code: str, help: str, tmp_path: object, capsys: pytest.CaptureFixture[str]
) -> None:
    fields = f"friction: {{coulomb: 0.4, static: 0.65}}, randomize: {{{entry}}}"
    text = of_group(f"kp: 60, kd: 2, {fields}", more=RANDOM)
    text = text.replace("side: joint, ", "side: joint, reflected_inertia: 0.0125, ")
    _, output = validated(text, tmp_path, capsys)
    assert [word for word in output.split() if word.startswith(("RND0", "SPEC1"))] == [code]
    assert f"  help: {help}\n" in output


@pytest.mark.parametrize(
    ("fields", "help"),
    [
        # 32 / 40 = 0.8, 48 / 40 = 1.2; in % they would be 0.32 and 0.48, which 40 is never drawn with.
        (
            "kp: 40, kd: 1, randomize: {kp: {scale: [32, 48]}}",
            "are they values? Then write `abs: [32 N*m/rad, 48 N*m/rad]`, or `scale: [0.8, 1.2]`",
        ),
        # 8 / 40 = 0.2: one end alone is above ten.
        (
            "kp: 40, kd: 1, randomize: {kp: {scale: [8, 48]}}",
            "are they values? Then write `abs: [8 N*m/rad, 48 N*m/rad]`, or `scale: [0.2, 1.2]`",
        ),
        # Mean and standard deviation: 40 / 40 and 4 / 40.
        (
            "kp: 40, kd: 1, randomize: {kp: {scale: [40, 4], distribution: gaussian}}",
            "are they values? Then write `abs: [40 N*m/rad, 4 N*m/rad]`, or `scale: [1, 0.1]`",
        ),
        # 88 / 110 and 132 / 110, or 88 % and 132 %.
        (
            "kp: 110, kd: 1, randomize: {kp: {scale: [88, 132]}}",
            "are they values? Then write `abs: [88 N*m/rad, 132 N*m/rad]`, or `scale: [0.8, 1.2]`; or is it in %? "
            "Then write 0.88 and 1.32",
        ),
        (
            "effort_limit: 20, randomize: {effort_limit: {scale: [16, 24]}}",
            "are they values? Then write `abs: [",
        ),
        # 4 / 6 = 0.667 and 8 / 6 = 1.333; as factors both are above any that is published.
        (
            "kp: 40, kd: 1, friction: {coulomb: 6}, randomize: {friction.coulomb: {scale: [4, 8]}}",
            "are they values? Then write `abs: [4 N*m, 8 N*m]`, or `scale: [0.6667, 1.333]`",
        ),
        # Nobody says what the nominal kp is.
        (
            "kp: unknown, kd: 1, randomize: {kp: {scale: [32, 48]}}",
            "are they values? Then write `abs: [32, 48]`",
        ),
        # Those of 40 that are no values: 80 and 120 are two and three times that, 0.8 is a factor.
        ("kp: 40, kd: 1, randomize: {kp: {scale: [80, 120]}}", "is it in %? Then write 0.8 and 1.2"),
        ("kp: 40, kd: 1, randomize: {kp: {scale: [8, 12]}}", "did you mean 0.8 and 1.2?"),
        ("kp: 5, kd: 1, randomize: {kp: {scale: [0.8, 12]}}", "did you mean 1.2?"),
        ("randomize: {strength: {scale: [80, 120]}}", "is it in %? Then write 0.8 and 1.2"),
        ("randomize: {strength: {scale: [32, 48]}}", "is the point in the wrong place?"),
    ],
)
def test_factors_that_are_values(fields: str, help: str) -> None:
    code, _, offered = one(of_group(fields))
    assert code == "SPEC188"
    assert (offered or "").startswith(help)
    if not help.endswith("["):
        assert offered == help


def test_a_gaussian_that_looks_like_a_range(tmp_path: object, capsys: pytest.CaptureFixture[str]) -> None:
    """0.8 and 1.2 rise like two ends; 1 and 0.5 do not."""
    for ends, asked in (("[0.8, 1.2]", True), ("[1, 0.5]", False)):
        text = of_group(f"randomize: {{kp: {{scale: {ends}, distribution: gaussian}}}}", more=RANDOM)
        _, output = validated(text, tmp_path, capsys)
        assert ("is it a range? `gaussian` takes mean and standard deviation" in output) is asked


def test_an_unknown_nominal_of_a_text_may_need_a_compilation(
    tmp_path: object, capsys: pytest.CaptureFixture[str]
) -> None:
    """kp follows from the inertia of the joint, which the text of a model does not tell."""
    with open(f"{tmp_path}/robot.xml", "w", encoding="utf-8") as file:
        file.write(SERVO)
    text = spec_of(
        "legs: {joints: [hip], level: ideal_pd, kp: {derive: natural_frequency, frequency: 2 Hz, inertia: joint}, "
        "kd: 0.5, randomize: {kp: {scale: [0.9, 1.1]}}}",
        robot="name: leg, model: robot.xml",
        more=RANDOM,
    )
    assert validated(text, tmp_path, capsys)[0] == 0


@pytest.mark.parametrize("sure", [False, True])
@pytest.mark.parametrize(
    ("fields", "place"),
    [
        # 20 N*m/rad x 0.25 = 5 N*m, which a friction of 150 N*m holds, and one of 14 N*m of 20, too: 70 %.
        ("friction: {coulomb: {value: 150 N*m, sure: SURE}}, action_scale: 0.25", "friction.coulomb"),
        ("friction: {coulomb: {value: 14 N*m, sure: SURE}}, action_scale: 0.25", "friction.coulomb"),
        # 1318 deg/s are 23 rad/s, at which 0.2 N*m*s/rad take 4.6 of 200 N*m; at 1318 rad/s 264.
        (
            "effort_limit: 200, velocity_limit: {value: 1318 rad/s, sure: SURE}, friction: {viscous: 0.2}",
            "velocity_limit",
        ),
    ],
)
def test_what_follows_from_a_wrong_number_is_not_told(fields: str, place: str, sure: bool) -> None:
    fields = fields.replace("SURE", str(sure).lower())
    text = of_group(fields)
    if place == "velocity_limit":
        # Of a motor that states its speed a velocity limit is not judged.
        text = text.replace("motor: m, ", "")
    found = said(text)
    assert [item.where for item in found] == [f"actuators.legs.{place}"] * (not sure)


def test_figures_whose_side_nobody_states_are_not_judged() -> None:
    """152 rad/s may be a rotor's, of 20 rad/s behind a gear of 7.6: without a side that is not told as an output's."""
    motors = "{m: {stall_torque: 4.9, no_load_speed: 152 rad/s, gear_ratio: 7.6}}"
    every = everything(
        spec_of(f"legs: {{joints: [hip], motor: m, level: dc_motor, kp: 20, kd: 1}}, {REST}", motors=motors)
    )
    assert [item.code for item in every] == ["SPEC130"]


@pytest.mark.parametrize(
    ("fields", "expected"),
    [
        # 1 x 10 rad/s = 10 N*m, which a friction of 25 N*m holds; the motor has 20.
        ("command: velocity, kd: 1, friction: {coulomb: 25}", ["FRC101"]),
        # 0.01 x 10 rad/s = 0.1 N*m of 0.2, of which the motor takes no notice.
        ("command: velocity, kd: 0.01, friction: {coulomb: 0.2}", ["SPEC192"]),
    ],
)
def test_a_friction_that_no_drive_overcomes_says_nothing_of_gains(fields: str, expected: list[str]) -> None:
    assert codes(of_group(fields)) == expected


@pytest.mark.parametrize(
    ("side", "viscous", "expected"),
    [
        ("motor", 0.02, []),
        # 2080 rpm at the output are 218 rad/s, and 0.02 x 218 = 4.4 N*m of 3.2.
        ("joint", 0.02, ["SPEC184"]),
        # 14.5 rad/s behind the gear: 2 x 14.5 = 29 N*m of 48.
        ("motor", 2.0, ["FRC106"]),
    ],
)
def test_a_motor_of_the_wrong_side_says_nothing_of_friction(
    side: str, viscous: float, expected: list[str]
) -> None:
    figures = "stall_torque: 13.4, peak_torque: 3.2, continuous_torque: 0.988, no_load_speed: 2080 rpm"
    figures += ", gear_ratio: 15"
    motors = f"{{m: {{side: {side}, {figures}}}}}"
    group = f"command: velocity, kd: 4, effort_limit: continuous, friction: {{viscous: {viscous}}}"
    legs = f"legs: {{joints: [hip], motor: m, level: dc_motor, {group}}}, {REST}"
    assert codes(spec_of(legs, motors=motors)) == expected


def test_two_inertias_are_one_message() -> None:
    """607 g*cm^2 at an output of 18 N*m would be 297 000 rad/s^2, but either of the two may be the wrong one."""
    motors = (
        "{m: {side: joint, peak_torque: 18, no_load_speed: 60 rad/s, gear_ratio: 9, "
        "rotor_inertia: 607 g*cm^2, reflected_inertia: 607 g*cm^2}}"
    )
    every = everything(
        spec_of(f"legs: {{joints: [hip], motor: m, level: ideal_pd, kp: 20, kd: 1}}, {REST}", motors=motors)
    )
    assert [item.code for item in every] == ["SPEC132"]


def everything(text: str) -> tuple[Diagnostic, ...]:
    """All that is said of a spec that is not valid."""
    with pytest.raises(ActspecError) as caught:
        fit(text)
    return caught.value.diagnostics
