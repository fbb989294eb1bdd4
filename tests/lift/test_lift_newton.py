"""Overlays with NewtonActuators as ActuatorSets: degrees and radians, what acts, and what is left alone."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from actspec.ir import Command, JointActuator, JointKind, Level, Origin, Quantity
from actspec.lift import Lifted, lift_newton
from actspec.robot.usda import layer_of
from tests.compiling import view_of

pytest.importorskip("pxr", reason="usd-core is not installed")

HIP = """over "hip" (prepend apiSchemas = ["NewtonJointAPI", "PhysicsDriveAPI:angular"]) {
float drive:angular:physics:stiffness = 0
float drive:angular:physics:maxForce = 20
float newton:armature = 0.02
float newton:friction = 0.3
float newton:damping = 0.01
float newton:velocityLimit = 900
}
"""
ROD = """over "rod" (prepend apiSchemas = ["PhysicsDriveAPI:linear"]) {
float newton:damping = 5
float newton:velocityLimit = 3
}
"""
PD = "NewtonPDControlAPI"
MODEL = """<mujoco model="leg"><compiler angle="radian"/><worldbody>
<body name="a"><joint name="hip" range="-1 2"/><geom size="0.1"/>
<body name="b"><joint name="rod" type="slide" range="-0.1 0.2"/><geom size="0.1"/></body></body>
</worldbody></mujoco>"""


def actuator(
    attributes: str, *apis: str, joint: str = "hip", name: str = "drive", begin: str = "def NewtonActuator"
) -> str:
    """A NewtonActuator of a joint; its attributes begin in its third line."""
    listed = ", ".join(f'"{api}"' for api in apis or (PD,))
    return (
        f'{begin} "{name}" (prepend apiSchemas = [{listed}]) {{\nrel newton:targets = </leg/{joint}>\n'
        f"{attributes}\n}}\n"
    )


PATHS = {"hip": "/leg/hip", "rod": "/leg/rod"}


def lifted(
    *prims: str, names: tuple[str, ...] = ("hip",), paths: Mapping[str, str] = PATHS, dt: float = 0.005
) -> Lifted:
    """What is made of an overlay of the robot `/leg`, whose prims begin in line 3."""
    layer = layer_of(f'#usda 1.0\nover "leg" {{\n{"".join(prims)}}}\n'.encode(), "usd/leg.usda")
    joints = view_of(MODEL).joints
    return lift_newton(layer, [joint for joint in joints if joint.name in names], paths, dt)


def only(found: Lifted) -> JointActuator:
    """The one joint that is lifted."""
    (actuator,) = found.actuators.joints
    return actuator


def said(quantity: Quantity | None) -> tuple[float | None, str, str]:
    """Value, unit and origin."""
    assert quantity is not None
    return quantity.value, quantity.unit, quantity.origin.value


def test_hinge() -> None:
    """Of a hinge the joint's prim is in degrees and the actuator in radians."""
    found = lifted(HIP, actuator("float newton:kp = 40\nfloat newton:kd = 1.5"))
    joint = only(found)
    assert (joint.joint, joint.kind, joint.group) == ("hip", JointKind.HINGE, "drive")
    assert (joint.level, joint.command) == (Level.IDEAL_PD, Command.POSITION)
    assert said(joint.kp) == (40.0, "N*m/rad", "model")
    assert said(joint.kd) == (1.5, "N*m*s/rad", "model")
    assert said(joint.armature) == (0.02, "kg*m^2", "model")
    assert said(joint.friction_coulomb) == (0.3, "N*m", "model")
    # 0.01 N*m*s/deg x 57.29577951 deg/rad
    assert said(joint.friction_viscous) == (0.5729578, "N*m*s/rad", "model")
    assert joint.friction_viscous.formula == "0.01 N*m*s/deg"
    # 900 deg/s are 5 pi rad/s, to seven digits
    assert joint.velocity_limit.value == 15.70796
    assert said(joint.effort_limit) == (None, "N*m", "unknown")
    assert found.left_alone == ()
    assert joint.position_range == (-1.0, 2.0)
    assert (found.actuators.robot, found.actuators.physics_dt.value) == ("leg", None)


def test_slide() -> None:
    """A slide has no angle in it."""
    joint = only(
        lifted(ROD, actuator("float newton:kp = 900\nfloat newton:kd = 40", joint="rod"), names=("rod",))
    )
    assert joint.kind is JointKind.SLIDE
    assert said(joint.kp) == (900.0, "N/m", "model")
    assert said(joint.friction_viscous) == (5.0, "N*s/m", "model")
    assert said(joint.velocity_limit) == (3.0, "m/s", "model")


def test_place() -> None:
    """A number is at its attribute, the actuator at its prim."""
    joint = only(lifted(HIP, actuator("float newton:kp = 40\nfloat newton:kd = 1.5")))
    # Line 3 is the hip's, 11 the actuator's.
    assert joint.span is not None and joint.span.line == 11
    lines = {name: quantity.span.line for name, quantity in joint.quantities() if quantity.span is not None}
    assert lines == {
        "kp": 13, "kd": 14, "armature": 6, "friction_coulomb": 7, "friction_viscous": 8, "velocity_limit": 9,
    }  # fmt: skip
    assert joint.armature.source == "usd/leg.usda"


@pytest.mark.parametrize(
    ("attributes", "apis", "level", "limit", "line"),
    [
        ("float newton:maxEffort = 24", ("NewtonMaxEffortClampingAPI",), Level.IDEAL_PD, 24.0, None),
        ("float newton:maxEffort = inf", ("NewtonMaxEffortClampingAPI",), Level.IDEAL_PD, None, None),
        ("float newton:maxEffort = 24", (), Level.IDEAL_PD, None, None),
        (
            "float newton:saturationEffort = 36\nfloat newton:velocityLimit = 30\nfloat newton:maxMotorEffort = 22",
            ("NewtonDCMotorClampingAPI",),
            Level.DC_MOTOR,
            22.0,
            (36.0, 30.0),
        ),
        (
            "float newton:saturationEffort = 36\nfloat newton:velocityLimit = 30",
            ("NewtonDCMotorClampingAPI",),
            Level.DC_MOTOR,
            None,
            (36.0, 30.0),
        ),
        # Both clamps are in force, one behind the other.
        (
            "float newton:saturationEffort = 36\nfloat newton:velocityLimit = 30\nfloat newton:maxMotorEffort = 22\n"
            "float newton:maxEffort = 20",
            ("NewtonDCMotorClampingAPI", "NewtonMaxEffortClampingAPI"),
            Level.DC_MOTOR,
            20.0,
            (36.0, 30.0),
        ),
        # A line that falls nowhere is a limit.
        (
            "float newton:saturationEffort = 36\nfloat newton:maxMotorEffort = 1e9",
            ("NewtonDCMotorClampingAPI",),
            Level.IDEAL_PD,
            36.0,
            None,
        ),
        (
            "float newton:saturationEffort = 36\nfloat newton:velocityLimit = inf\nfloat newton:maxMotorEffort = 22",
            ("NewtonDCMotorClampingAPI",),
            Level.IDEAL_PD,
            22.0,
            None,
        ),
    ],
    ids=["limit", "infinite", "no schema", "line", "line alone", "both clamps", "flat line", "infinite line"],
)
def test_clamps(
    attributes: str,
    apis: tuple[str, ...],
    level: Level,
    limit: float | None,
    line: tuple[float, float] | None,
) -> None:
    """A clamp is there where its schema is applied; no limit is unknown, not infinite."""
    joint = only(lifted(actuator(f"float newton:kp = 5\n{attributes}", PD, *apis)))
    assert (joint.level, joint.effort_limit.value) == (level, limit)
    found = (
        joint.stall_torque and joint.stall_torque.value,
        joint.no_load_speed and joint.no_load_speed.value,
    )
    assert found == (line or (None, None))


@pytest.mark.parametrize(
    ("attributes", "command", "gains"),
    [
        ("float newton:kp = 5", Command.POSITION, (5.0, 0.0)),
        ("float newton:kp = 0\nfloat newton:kd = 2", Command.VELOCITY, (None, 2.0)),
        ("float newton:kd = 0", Command.EFFORT, (None, None)),
        ("float newton:kp = -5", Command.POSITION, (-5.0, 0.0)),
        ("foo newton:kp = 5", Command.EFFORT, (None, None)),
        ("float newton:kp = nan", Command.EFFORT, (None, None)),
    ],
    ids=["position", "velocity", "effort", "negative", "type", "nan"],
)
def test_command(attributes: str, command: Command, gains: tuple[float | None, float | None]) -> None:
    """A drive without stiffness follows a speed, one without gains a torque; what is not written is Newton's 0."""
    joint = only(lifted(actuator(attributes)))
    assert joint.command is command
    assert (joint.kp and joint.kp.value, joint.kd and joint.kd.value) == gains
    if command is Command.POSITION:
        assert joint.kd is not None and joint.kd.origin is Origin.DEFAULT


def test_bias() -> None:
    """-1.2 N*m before the clamp at 60 N*m/rad is an encoder that says 0.02 rad too much."""
    joint = only(lifted(actuator("float newton:kp = 60\nfloat newton:constEffort = -1.2")))
    assert (joint.encoder_bias.value, joint.encoder_bias.formula) == (0.02, "1.2 / 60 (stiffness)")


def test_delay() -> None:
    """Three steps of 4 ms."""
    delay = only(
        lifted(
            actuator("float newton:kp = 5\nint newton:delaySteps = 3", PD, "NewtonActuatorDelayAPI"), dt=0.004
        )
    ).delay
    assert delay is not None and (delay.nominal.value, delay.low, delay.high) == (0.012, 0.012, 0.012)


@pytest.mark.parametrize(
    ("attributes", "apis"),
    [("int newton:delaySteps = 0", (PD, "NewtonActuatorDelayAPI")), ("int newton:delaySteps = 3", (PD,))],
    ids=["0", "no schema"],
)
def test_no_delay(attributes: str, apis: tuple[str, ...]) -> None:
    """No step is no delay, and so are steps without the schema."""
    assert only(lifted(actuator(f"float newton:kp = 5\n{attributes}", *apis))).delay is None


def test_network() -> None:
    """A network's file is beside the overlay; its clamp is read, and there are no gains."""
    found = lifted(
        HIP,
        actuator(
            "asset newton:modelPath = @./nets/a.onnx@\nfloat newton:maxEffort = 9\nfloat newton:kp = 3",
            *("NewtonNeuralControlAPI", "NewtonMaxEffortClampingAPI"),
        ),
    )
    joint = only(found)
    assert (joint.level, joint.command) == (Level.ACTUATOR_NET, Command.POSITION)
    assert joint.network is not None
    assert Path(joint.network.file).parts == ("usd", "nets", "a.onnx")
    assert (joint.kp, joint.kd, joint.effort_limit.value) == (None, None, 9.0)


@pytest.mark.parametrize(
    ("prims", "why"),
    [
        ((HIP,), "no NewtonActuator"),
        ((HIP, actuator(""), actuator("", name="again")), "2 NewtonActuators"),
        ((actuator("", "NewtonMaxEffortClampingAPI"),), "an actuator with no drive, which Newton refuses"),
        (
            (actuator("", PD, "NewtonPIDControlAPI"),),
            "an actuator with NewtonPDControlAPI and NewtonPIDControlAPI, which Newton refuses",
        ),
        ((actuator("float newton:ki = 2", "NewtonPIDControlAPI"),), "a PID drive"),
        (
            (actuator("", PD, "NewtonPositionBasedClampingAPI"),),
            "a torque limit that depends on the position",
        ),
        (
            (actuator("", PD, "NewtonActuatorDelayAPI"),),
            "a delay without newton:delaySteps, which Newton refuses",
        ),
        ((actuator("float newton:constEffort = 3"),), "a constant torque without a stiffness"),
    ],
    ids=["bare", "two", "none", "both", "pid", "position", "delay", "constant"],
)  # fmt: skip
def test_left_alone(prims: tuple[str, ...], why: str) -> None:
    """What a spec cannot say is left alone, with the reason and the place."""
    found = lifted(*prims)
    assert found.actuators.joints == ()
    (alone,) = found.left_alone
    assert (alone.joint, alone.why, alone.span and alone.span.line) == ("hip", why, 3 + 8 * (len(prims) > 1))
    assert found.actuators.unmanaged == ("hip",)


def test_pid_without_an_integral_is_a_pd() -> None:
    """A PID drive whose ki is 0 is a PD drive."""
    assert only(lifted(actuator("float newton:kp = 3", "NewtonPIDControlAPI"))).level is Level.IDEAL_PD


@pytest.mark.parametrize(
    "text",
    [
        actuator("", begin="over NewtonActuator"),
        'def NewtonActuator "drive" {}\n',
        actuator("", begin="class NewtonActuator"),
    ],
    ids=["over", "no target", "class"],
)
def test_actuators_that_are_none(text: str) -> None:
    """What Newton does not take for an actuator drives nothing."""
    assert [alone.why for alone in lifted(text).left_alone] == ["no NewtonActuator"]


def test_switched_off() -> None:
    """An actuator below a prim that is off does not act."""
    scope = 'def Scope "s" (active = false) {\n' + actuator("float newton:kp = 3") + "}\n"
    assert [alone.why for alone in lifted(HIP, scope).left_alone] == ["no NewtonActuator"]


def test_joints_of_a_robot() -> None:
    """A robot's joints come in its order, with their kind and range, whatever their prims are called."""
    found = lifted(
        actuator("float newton:kp = 5", joint="x", name="one"),
        actuator("float newton:kp = 6", name="two"),
        actuator("float newton:kp = 7", name="three", joint="wheel"),
        names=("hip", "rod"),
        paths={"rod": "/leg/x", "hip": "/leg/hip"},
    )
    assert [(a.joint, a.kind, a.group, a.position_range) for a in found.actuators.joints] == [
        ("hip", JointKind.HINGE, "two", (-1.0, 2.0)),
        ("rod", JointKind.SLIDE, "one", (-0.1, 0.2)),
    ]


def test_first_of_several_targets() -> None:
    """Newton takes the first."""
    found = lifted(
        actuator("float newton:kp = 5", joint="rod>, </leg/hip")
        .replace("= </", "= [</")
        .replace("hip>", "hip>]"),
        names=("hip", "rod"),
    )
    assert only(found).joint == "rod"
    assert [alone.joint for alone in found.left_alone] == ["hip"]
