"""Overlays with NewtonActuators as ActuatorSets: degrees and radians, what acts, and what is left alone."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.ir import Command, JointActuator, JointKind, Level, Origin, Quantity
from actspec.lift import Lifted, lift_newton
from actspec.robot.usda import layer_of
from actspec.robot.view import RobotView
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


def lifted(*prims: str, head: str = "", **options: object) -> Lifted:
    """What is made of an overlay of the robot `/leg`, whose prims begin in line 3."""
    text = f'#usda 1.0{head}\nover "leg" {{\n{"".join(prims)}}}\n'
    return lift_newton(layer_of(text.encode(), "usd/leg.usda"), **options)  # type: ignore[arg-type]


def only(found: Lifted) -> JointActuator:
    """The one joint that is lifted."""
    (actuator,) = found.actuators.joints
    return actuator


def said(quantity: Quantity | None) -> tuple[float | None, str, str]:
    """Value, unit and origin."""
    assert quantity is not None
    return quantity.value, quantity.unit, quantity.origin.value


def robot() -> RobotView:
    """A robot whose hip and rod are those of the overlay."""
    return view_of(MODEL)


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
    assert found.notes == {
        "hip": ("drive:angular:physics:maxForce clips at 20 N*m too, where it is in force",)
    }
    assert (found.actuators.robot, found.actuators.physics_dt.value) == ("leg", None)


def test_slide() -> None:
    """A slide has no angle in it."""
    joint = only(lifted(ROD, actuator("float newton:kp = 900\nfloat newton:kd = 40", joint="rod")))
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
    found = lifted(actuator(attributes))
    joint = only(found)
    assert joint.command is command
    assert (joint.kp and joint.kp.value, joint.kd and joint.kd.value) == gains
    if command is Command.POSITION:
        assert joint.kd is not None and joint.kd.origin is Origin.DEFAULT
    told = [note for note in found.notes["hip"] if note.startswith("newton:kp")]
    assert told == NOTES.get(attributes, [])


NOTES = {
    "float newton:kp = -5": ["newton:kp is -5: Newton takes no negative number"],
    "foo newton:kp = 5": ["newton:kp is of type foo: Newton takes a number"],
}
"""What is told of such gains."""


def test_bias() -> None:
    """-1.2 N*m before the clamp at 60 N*m/rad is an encoder that says 0.02 rad too much."""
    joint = only(lifted(actuator("float newton:kp = 60\nfloat newton:constEffort = -1.2")))
    assert (joint.encoder_bias.value, joint.encoder_bias.formula) == (0.02, "1.2 / 60 (stiffness)")


HEAD = "\n# Written by actspec 0.1.0 for Newton 1.8.\n# Every physics step of 2.5 ms: control.joint_f.zero_()"


@pytest.mark.parametrize(
    ("head", "given", "seconds"),
    [
        (HEAD, None, 0.0075),
        (HEAD, 0.004, 0.012),
        ("", 0.004, 0.012),
        ("", None, None),
        ("\n# Every physics step of 2.5 ms: of somebody else", None, None),
    ],
    ids=["head", "given wins", "given", "nobody", "not ours"],
)
def test_delay(head: str, given: float | None, seconds: float | None) -> None:
    """Three steps are as long as the step is, which the caller says, or the head where actspec wrote it."""
    found = lifted(
        actuator("float newton:kp = 5\nint newton:delaySteps = 3", PD, "NewtonActuatorDelayAPI"),
        head=head,
        physics_dt=given,
    )
    delay = only(found).delay
    assert delay is not None and delay.nominal.value == seconds
    assert (delay.low, delay.high) == (seconds or 0.0, seconds or 0.0)
    told = "delay: 3 physics steps, whose length no file states" in found.notes.get("hip", ())
    assert told == (seconds is None)
    assert found.actuators.physics_dt.value == (0.0025 if head == HEAD else None)


@pytest.mark.parametrize(
    ("attributes", "apis"),
    [("int newton:delaySteps = 0", (PD, "NewtonActuatorDelayAPI")), ("int newton:delaySteps = 3", (PD,))],
    ids=["0", "no schema"],
)
def test_no_delay(attributes: str, apis: tuple[str, ...]) -> None:
    """No step is no delay, and so are steps without the schema, which is told."""
    found = lifted(actuator(f"float newton:kp = 5\n{attributes}", *apis), physics_dt=0.005)
    assert only(found).delay is None
    told = "newton:delaySteps does nothing without NewtonActuatorDelayAPI" in found.notes["hip"]
    assert told == (len(apis) == 1)


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
    assert found.notes == {
        "hip": ("newton:kp does nothing without NewtonPDControlAPI or NewtonPIDControlAPI",)
    }


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
    ("prims", "note"),
    [
        (
            (actuator("", begin="over NewtonActuator"),),
            "/leg/drive is no def: left to the stage, if it has one",
        ),
        (('def NewtonActuator "drive" {}\n',), "/leg/drive has no target, which Newton refuses"),
        (
            (actuator("", begin="class NewtonActuator"),),
            "/leg/drive is no def: left to the stage, if it has one",
        ),
    ],
    ids=["over", "no target", "class"],
)
def test_actuators_that_are_none(prims: tuple[str, ...], note: str) -> None:
    """What Newton does not take for an actuator is told, and drives nothing."""
    found = lifted(*prims)
    assert found.actuators.joints == ()
    assert found.notes[""] == (note,)


def test_switched_off() -> None:
    """An actuator below a prim that is off does not act."""
    scope = 'def Scope "s" (active = false) {\n' + actuator("float newton:kp = 3") + "}\n"
    assert [alone.why for alone in lifted(HIP, scope).left_alone] == ["no NewtonActuator"]


def test_the_stages_own_drive_is_told() -> None:
    """Gains of the joint's own drive act beside the actuator's."""
    text = HIP.replace("stiffness = 0", "stiffness = 3")
    found = lifted(text, actuator("float newton:kp = 3"))
    assert (
        "the stage's own drive acts beside the actuator (drive:angular:physics:stiffness)"
        in found.notes["hip"]
    )


def test_nothing_is_followed() -> None:
    """A layer that only brings in others has no actuators, and says why."""
    found = lifted(head="\n(subLayers = [@a.usda@, @b.usda@])")
    assert found.actuators.joints == ()
    assert found.notes == {"": ("subLayers are not followed: what they bring in is not here",)}


def test_joints_of_a_robot() -> None:
    """A robot's joints come in its order, with their kind and range, whatever their prims are called."""
    prims = {"rod": "/leg/x", "hip": "/leg/hip"}
    found = lifted(
        actuator("float newton:kp = 5", joint="x", name="one"),
        actuator("float newton:kp = 6", name="two"),
        actuator("float newton:kp = 7", name="three", joint="wheel"),
        joints=robot().joints,
        prims=prims,
    )
    assert [(a.joint, a.kind, a.group, a.position_range) for a in found.actuators.joints] == [
        ("hip", JointKind.HINGE, "two", (-1.0, 2.0)),
        ("rod", JointKind.SLIDE, "one", (-0.1, 0.2)),
    ]
    assert found.notes == {"": ("actuators at /leg/wheel, which is none of the joints",)}


def test_joints_by_name_alone() -> None:
    """Without a robot's file the kind is the drive's axis, else a hinge, which is told; two of one name keep paths."""
    prims = (ROD, actuator("float newton:kp = 5", joint="rod"), actuator("float newton:kp = 6", name="h"))
    found = lifted(*prims, joints=["hip", "rod", "knee"])
    assert [(a.joint, a.kind) for a in found.actuators.joints] == [
        ("hip", JointKind.HINGE),
        ("rod", JointKind.SLIDE),
    ]
    assert found.notes == {"hip": ("the kind of the joint is not stated: it is taken as a hinge",)}
    assert [(alone.joint, alone.span) for alone in found.left_alone] == [("knee", None)]
    twice = lifted(actuator("", joint="a/hip"), actuator("", joint="b/hip", name="two"))
    assert [a.joint for a in twice.actuators.joints] == ["/leg/a/hip", "/leg/b/hip"]


def test_stage_of_its_own() -> None:
    """A whole stage has its joints as prims of their types; several targets are told, and the first is the joint."""
    found = lifted(
        'def PhysicsPrismaticJoint "rod" {\n}\n',
        'def PhysicsRevoluteJoint "hip" {\n}\n',
        actuator("float newton:kp = 5", joint="rod>, </leg/hip")
        .replace("= </", "= [</")
        .replace("hip>", "hip>]"),
    )
    assert (only(found).joint, only(found).kind) == ("rod", JointKind.SLIDE)
    assert found.notes[""] == ("/leg/drive has 2 targets: Newton takes the first",)
    assert [alone.joint for alone in found.left_alone] == ["hip"]
