"""What the overlay says: joints' prims, actuators, losses, header."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from actspec.ir import DeltaAction, Source
from tests.targets.leg import LEG, REST, group
from tests.targets.newton.emitting import THIGH, emitted, written

HIP = f"{THIGH}/hip"
ROD = f"{THIGH}/shank/foot/rod"
DRIVE = "/leg/NewtonActuators/hip"
ALL = "armature: 0.01 kg*m^2, friction: {coulomb: 0.2 N*m, viscous: 0.04 N*m*s/rad}, velocity_limit: 20 rad/s"


def test_joint_numbers_of_a_hinge() -> None:
    """Viscous friction is per degree, a speed limit in degrees a second; the other numbers are as they are."""
    found = written(group(effort_limit="24 N*m")[:-1] + f", {ALL}}}")
    assert found.prims[HIP]["is"] == "over"
    assert found.prims[HIP]["apis"] == ["NewtonJointAPI", "PhysicsDriveAPI:angular"]
    assert found.attributes(HIP) == {
        "drive:angular:physics:stiffness": 0.0,
        "drive:angular:physics:damping": 0.0,
        "drive:angular:physics:maxForce": 24.0,
        "newton:armature": 0.01,
        "newton:friction": 0.2,
        # 0.04 N*m*s/rad x 0.01745 rad/deg; 20 rad/s x 57.30 deg/rad.
        "newton:damping": pytest.approx(6.981317e-4, rel=1e-6),
        "newton:velocityLimit": pytest.approx(1145.9156, rel=1e-6),
    }


def test_joint_numbers_of_a_slide() -> None:
    """A slide has no angle in it: its numbers are as they are."""
    spec = (
        "  rod: {joints: [rod], level: ideal_pd, kp: 900 N/m, kd: 40 N*s/m, effort_limit: 90 N, armature: 0.3 kg,"
        " friction: {coulomb: 2 N, viscous: 5 N*s/m}, velocity_limit: 3 m/s}"
    )
    found = written(spec, robot='unmanaged: ["hip", "calf"]')
    assert found.prims[ROD]["apis"] == ["NewtonJointAPI", "PhysicsDriveAPI:linear"]
    assert found.attributes(ROD) == {
        "drive:linear:physics:stiffness": 0.0,
        "drive:linear:physics:damping": 0.0,
        "drive:linear:physics:maxForce": 90.0,
        "newton:armature": 0.3,
        "newton:friction": 2.0,
        "newton:damping": 5.0,
        "newton:velocityLimit": 3.0,
    }
    assert found.attributes("/leg/NewtonActuators/rod") == {
        "newton:targets": f"<{ROD}>", "newton:kp": 900.0, "newton:kd": 40.0, "newton:maxEffort": 90.0,
    }  # fmt: skip


def test_what_nobody_states_is_the_stages() -> None:
    """Neither a number that only an engine's default has nor an unknown limit is written, and no clamp is made up."""
    model = LEG.replace(' armature="0.003" frictionloss="0.04" damping="0.1"', "")
    found = written(group(effort_limit="unknown"), model)
    assert found.attributes(HIP) == {
        "drive:angular:physics:stiffness": 0.0,
        "drive:angular:physics:damping": 0.0,
    }
    assert found.prims[DRIVE]["apis"] == ["NewtonPDControlAPI"]
    assert found.attributes(DRIVE) == {"newton:targets": f"<{HIP}>", "newton:kp": 25.0, "newton:kd": 0.5}


def test_the_models_own_numbers_are_written() -> None:
    """What the robot's file states goes into the stage, which may be made from another."""
    found = written(group(effort_limit="24 N*m"))
    assert found.attributes(HIP)["newton:armature"] == 0.003
    assert found.attributes(HIP)["newton:friction"] == 0.04
    assert "float newton:armature = 0.003  # kg*m^2, model" in found.text


@pytest.mark.parametrize(
    ("fields", "apis", "numbers"),
    [
        ({"effort_limit": "24 N*m"}, ["NewtonMaxEffortClampingAPI"], {"kp": 25, "kd": 0.5, "maxEffort": 24}),
        (
            {"level": "dc_motor", "motor": "line", "effort_limit": "20 N*m"},
            ["NewtonDCMotorClampingAPI"],
            {"kp": 25, "kd": 0.5, "saturationEffort": 45, "velocityLimit": 30, "maxMotorEffort": 20},
        ),
        (
            {"level": "dc_motor", "motor": "line", "effort_limit": "unknown"},
            ["NewtonDCMotorClampingAPI"],
            {"kp": 25, "kd": 0.5, "saturationEffort": 45, "velocityLimit": 30, "maxMotorEffort": math.inf},
        ),
        (
            {"command": "velocity", "kp": "", "effort_limit": "9 N*m"},
            ["NewtonMaxEffortClampingAPI"],
            {"kp": 0, "kd": 0.5, "maxEffort": 9},
        ),
        (
            {"command": "effort", "kp": "", "kd": "", "effort_limit": "7 N*m"},
            ["NewtonMaxEffortClampingAPI"],
            {"kp": 0, "kd": 0, "maxEffort": 7},
        ),
        (
            # -25 N*m/rad x 0.04 rad.
            {"encoder_bias": "0.04 rad", "effort_limit": "24 N*m"},
            ["NewtonMaxEffortClampingAPI"],
            {"kp": 25, "kd": 0.5, "constEffort": -1, "maxEffort": 24},
        ),
        (
            {"command": "velocity", "kp": "", "encoder_bias": "0.04 rad", "effort_limit": "9 N*m"},
            ["NewtonMaxEffortClampingAPI"],
            {"kp": 0, "kd": 0.5, "maxEffort": 9},
        ),
        (
            {"delay": "10 ms", "effort_limit": "24 N*m"},
            ["NewtonMaxEffortClampingAPI", "NewtonActuatorDelayAPI"],
            {"kp": 25, "kd": 0.5, "maxEffort": 24, "delaySteps": 2},
        ),
        (
            # Below half a step of 5 ms there is no delay.
            {"delay": "2 ms", "effort_limit": "24 N*m"},
            ["NewtonMaxEffortClampingAPI"],
            {"kp": 25, "kd": 0.5, "maxEffort": 24},
        ),
    ],
    ids=["position", "dc", "dc-unlimited", "velocity", "effort", "bias", "bias-of-velocity", "delay", "short-delay"],
)  # fmt: skip
def test_actuator(fields: dict[str, str], apis: list[str], numbers: dict[str, float]) -> None:
    """Each level and command has its schemas and, in radians, every number of the law; no more."""
    found = written(group(**fields))
    assert found.prims[DRIVE]["is"] == "def NewtonActuator"
    assert found.prims[DRIVE]["apis"] == ["NewtonPDControlAPI", *apis]
    expected = {f"newton:{name}": pytest.approx(float(value)) for name, value in numbers.items()}
    assert found.attributes(DRIVE) == {"newton:targets": f"<{HIP}>", **expected}
    assert {loss.field for loss in found.emission.approximations} <= {"delay"}


def test_curve() -> None:
    """Of an asymmetric curve the line through knee and no-load speed is left, cut at the drive torque."""
    found = written(group(level="dc_motor", motor="curve", effort_limit="24 N*m"))
    # 20 N*m at 14 rad/s falls to 0 at 30 rad/s: 20 / (1 - 14/30) = 37.5 N*m at standstill.
    assert found.attributes(DRIVE) | {
        "newton:saturationEffort": 37.5, "newton:velocityLimit": 30.0, "newton:maxMotorEffort": 20.0,
    } == found.attributes(DRIVE)  # fmt: skip
    loss = found.lost("torque_speed_curve")
    assert (loss.asked, loss.emitted, loss.why) == (
        "curve: drive 20 N*m, brake 25 N*m, knee 14, no load 30",
        "line from 37.5 to 30, cut at 20",
        "Newton has one line for driving and braking",
    )
    # Braking at 60 rad/s the curve has nothing left, the line all of its 20 N*m.
    assert loss.max_torque_error == pytest.approx(20.0)


@pytest.mark.parametrize(
    ("delay", "steps", "losses"),
    [
        ("7 ms", 1, {"delay": ("7 ms", "1 step of 5 ms", 12.0)}),
        ("8 ms", 2, {"delay": ("8 ms", "2 steps of 5 ms", 12.0)}),
        (
            "{nominal: 5 ms, range: [0 ms, 15 ms]}",
            1,
            {"delay.range": ("0 to 15 ms, drawn each episode", "1 step of 5 ms", 12.0)},
        ),
        (
            "{nominal: unknown, range: [0 ms, 15 ms], sampling: step}",
            None,
            {"delay.range": ("0 to 15 ms, drawn each step", "none", 12.0)},
        ),
        ("{nominal: unknown, range: [10 ms, 10 ms]}", 2, {}),
    ],
    ids=["less", "more", "range", "unknown", "one-end"],
)
def test_delay_that_is_not_held(
    delay: str, steps: int | None, losses: dict[str, tuple[str, str, float]]
) -> None:
    """One fixed whole number of steps is what there is; the rest is sized by half the limit."""
    found = written(group(delay=delay, effort_limit="24 N*m"))
    assert found.attributes(DRIVE).get("newton:delaySteps") == steps
    got = {x.field: (x.asked, x.emitted, x.max_torque_error) for x in found.emission.approximations}
    assert got == losses


def test_command_path_losses() -> None:
    """A filter and a clamp of the command are lost, and sized."""
    found = written(
        group(effort_limit="24 N*m", command_filter="{cutoff: 30 Hz}", command_range="[-0.5 rad, 0.5 rad]")
    )
    # Half of 24 N*m after a step of 0.5 L/kp with the joint held.
    assert found.lost("command_filter").max_torque_error == 12.0
    loss = found.lost("command_range")
    assert (loss.asked, loss.emitted) == ("-0.5 to 0.5 rad", "none")
    # From -24 to 24 N*m at an end of the joint's range, 1 rad, with the command out of it.
    assert loss.max_torque_error is not None and 24.0 < loss.max_torque_error <= 48.0


def test_sticking_and_speed_losses() -> None:
    """Static friction and Stribeck are lost; a speed limit is written, and said not to be everywhere in force."""
    friction = "{coulomb: 0.2 N*m, static: 0.5 N*m, stribeck_velocity: 0.1 rad/s, viscous: 0 N*m*s/rad}"
    found = written(group(effort_limit="24 N*m", friction=friction, velocity_limit="20 rad/s"))
    for field in ("friction.static", "friction.stribeck_velocity"):
        assert found.lost(field).max_torque_error == pytest.approx(0.3)
    assert found.lost("friction.static").emitted == "0.2 N*m"
    assert found.lost("velocity_limit").emitted == "newton:velocityLimit, which not all solvers take"
    assert found.lost("velocity_limit").max_torque_error is None


def test_before_joint_damping() -> None:
    """Newton 1.3 reads neither a joint's damping nor its speed limit: both are lost, the first sized by the fastest."""
    found = written(group(effort_limit="24 N*m")[:-1] + f", {ALL}}}", version="1.3")
    assert {"newton:damping", "newton:velocityLimit"}.isdisjoint(found.attributes(HIP))
    assert found.attributes(HIP)["newton:friction"] == 0.2
    loss = found.lost("friction.viscous")
    # kd alone takes 24 N*m at 48 rad/s: 2 x 48 x 0.04.
    assert loss.emitted == "none"
    assert loss.max_torque_error == pytest.approx(3.84)
    assert found.lost("velocity_limit").emitted == "none"


def test_the_models_own_actuators_are_switched_off() -> None:
    """The prims that a converter makes of actuators on driven joints; one on another joint or a tendon stays."""
    model = LEG.replace(
        "</worldbody>",
        "</worldbody><tendon><fixed name='t'><joint joint='calf' coef='1'/></fixed></tendon><actuator>"
        "<motor name='own' joint='hip'/><motor name='other' joint='calf'/><motor name='pull' tendon='t'/></actuator>",
    )
    found = written(group(effort_limit="24 N*m"), model)
    assert found.prims["/leg/Physics/own"] == {"is": "over", "apis": [], "active": False}
    assert not {"/leg/Physics/other", "/leg/Physics/pull"} & found.prims.keys()


def test_stated_paths_leave_no_guess_at_actuators() -> None:
    """Where the spec says where the joints are, the stage is not that of a converter."""
    model = LEG.replace("</worldbody>", "</worldbody><actuator><motor name='own' joint='hip'/></actuator>")
    found = written(group(effort_limit="24 N*m"), model, joint_paths=((".*", "joints/{joint}"),))
    assert "/leg/joints/hip" in found.prims
    assert not any(path.startswith("/leg/Physics") for path in found.prims)
    assert "joint_paths" not in found.text


@pytest.mark.parametrize(("version", "run"), [("1.8", True), ("1.7", False), ("1.3.0", True), ("1.2", False)])
def test_head_says_what_was_run(version: str, run: bool) -> None:
    """A version in whose release nothing was run says so."""
    text = written(group(effort_limit="24 N*m"), version=version).text
    number = version[:3]
    assert text.startswith("#usda 1.0\n# Written by actspec ")
    assert f"for Newton {number}. Do not edit: change the spec and compile again." in text
    assert ("reads, not run with it." not in text) == run
    assert "Isaac Sim 6 and Isaac Lab 3 read the same prims: not run there." in text


def test_delta_action_is_not_there() -> None:
    """A residual policy is no actuator's."""
    one = written(group(effort_limit="24 N*m"))
    delta = DeltaAction("nets/delta.json")
    again = emitted(replace(one.actuators, delta_action=delta), one.robot)
    loss = again.lost("delta_action")
    assert (loss.joint, loss.asked, loss.emitted, loss.max_torque_error) == ("", "delta.json", "none", None)


def test_every_joint_is_explicit() -> None:
    """Newton computes the torque before the step: the checks of stability take it for explicit."""
    assert written(group(effort_limit="24 N*m")).emission.explicit == {"hip"}


def test_text_is_deterministic() -> None:
    """The same spec gives the same bytes."""
    one = written(group(effort_limit="24 N*m"))
    again = emitted(one.actuators, one.robot)
    assert one.emission.files == again.emission.files
    assert [file.path for file in one.emission.files] == ["probe_newton.usda"]


def test_hostile_words_stay_in_comments() -> None:
    """A source's title cannot end its comment, and a robot's name cannot leave the file's name."""
    one = written(group(effort_limit="24 N*m"))
    (hip,) = one.actuators.joints
    hip = replace(hip, group='"}\ndef Scope "evil" {}', effort_limit=replace(hip.effort_limit, source="x"))
    sources = (Source("x", 'a\n}\ndef Scope "evil" {}\n#"""\x00'),)
    actuators = replace(one.actuators, robot='../..\\x"\n@', joints=(hip,), sources=sources)
    found = emitted(actuators, one.robot)
    (file,) = found.emission.files
    assert file.path == "x_newton.usda"
    assert found.text.count("evil") == 2
    assert all(line.strip().startswith("#") for line in found.text.splitlines() if "evil" in line)
    assert all(line.isprintable() for line in found.text.splitlines())


def test_actuators_of_joints_with_one_last_name() -> None:
    """Two joints whose prims end alike, or whose names read alike as identifiers, have actuators of their own."""
    spec = (
        '  leg: {joints: [".*_.*"], level: ideal_pd, kp: 25 N*m/rad, kd: 0.5 N*m*s/rad, effort_limit: 9 N*m}'
    )
    found = written(
        spec,
        None,
        robot="model: none, joints: [{name: a_b}, {name: a-_b}]",
        joint_paths=(("a_b", "one/joint"), ("a-_b", "two/joint")),
    )
    targets = {
        path: prim["newton:targets"]
        for path, prim in found.prims.items()
        if prim["is"] == "def NewtonActuator"
    }
    assert len(targets) == 2
    assert sorted(targets.values()) == ["</probe/one/joint>", "</probe/two/joint>"]


def test_unmanaged_joints_are_left() -> None:
    """A joint that the spec does not manage has no prim here."""
    found = written(group(effort_limit="24 N*m"), robot=REST)
    assert [path for path in found.prims if path.endswith(("calf", "rod"))] == []
