"""Robot files as ActuatorSets: numbers at the joint, their origin and place, and what is left alone."""

from __future__ import annotations

import math

import pytest

from actspec.ir import Command, JointActuator, Level, Origin, Quantity
from actspec.lift import Lifted, lift_robot
from actspec.robot.read_mjcf_text import read_mjcf_text
from actspec.robot.read_urdf import read_urdf
from actspec.robot.view import ModelFile
from actspec.robot.xml import parse_document
from tests.compiling import view_of

INERTIAL = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'


def mjcf(joints: str, actuators: str = "", head: str = "", tail: str = "") -> str:
    """A chain of bodies, one for each line of `joints`; the first joint is in line 2."""
    lines = [line.strip() for line in joints.strip().split("\n")]
    body = "".join(f"<body>\n{line}\n{INERTIAL}" for line in lines) + "</body>" * len(lines)
    section = f"<actuator>\n{actuators}\n</actuator>" if actuators else ""
    return f'<mujoco model="bot">{head}<worldbody>{body}</worldbody>{section}{tail}</mujoco>'


def lifted(joints: str, actuators: str = "", head: str = "", tail: str = "") -> Lifted:
    """What the compiled reader makes of a chain."""
    return lift_robot(view_of(mjcf(joints, actuators, head, tail), folder=""))


def only(found: Lifted) -> JointActuator:
    """The one joint that is lifted."""
    (actuator,) = found.actuators.joints
    return actuator


def said(quantity: Quantity | None) -> tuple[float | None, str, str]:
    """Value, unit and origin."""
    assert quantity is not None
    return quantity.value, quantity.unit, quantity.origin.value


def test_servo_behind_a_gear() -> None:
    """Gains times gear squared, the limit times gear, the clamp over gear; the formula tells, and a note."""
    found = lifted(
        '<joint name="j" damping="0.3" armature="0.02" frictionloss="0.1" range="-1 1"/>',
        '<position name="a" joint="j" kp="10" kv="0.5" gear="3" forcerange="-4 4" ctrlrange="-6 3"/>',
        '<compiler angle="radian"/>',
    )
    actuator = only(found)
    assert (actuator.level, actuator.command, actuator.group) == (Level.IDEAL_PD, Command.POSITION, "a")
    assert said(actuator.kp) == (90.0, "N*m/rad", "model")  # 10 x 9
    assert said(actuator.kd) == (4.5, "N*m*s/rad", "model")  # 0.5 x 9
    assert said(actuator.effort_limit) == (12.0, "N*m", "model")  # 4 x 3
    assert said(actuator.armature) == (0.02, "kg*m^2", "model")
    assert said(actuator.friction_coulomb) == (0.1, "N*m", "model")
    assert said(actuator.friction_viscous) == (0.3, "N*m*s/rad", "model")
    assert actuator.command_range is not None
    assert [end.value for end in actuator.command_range] == [-2.0, 1.0]
    assert actuator.kp is not None and actuator.kp.formula == "10 x 3^2 (gear)"
    assert found.notes == {"j": ("the file's gear of 3 go: after a compile the control is in joint units",)}


def test_slide_units() -> None:
    """A prismatic joint is in N and m."""
    actuator = only(lifted('<joint name="j" type="slide" damping="2"/>', '<position joint="j" kp="100"/>'))
    units = {name: quantity.unit for name, quantity in actuator.quantities()}
    assert (units["kp"], units["kd"], units["effort_limit"]) == ("N/m", "N*s/m", "N")
    assert (units["armature"], units["friction_viscous"], units["velocity_limit"]) == ("kg", "N*s/m", "m/s")


def test_places() -> None:
    """A number is at the element that states it: the joint, the actuator, or their default class."""
    head = '<default>\n<joint armature="0.1"/>\n<position kv="3"/>\n</default>'
    actuator = only(lifted('<joint name="j" damping="1"/>', '<position joint="j" kp="5"/>', head))
    # Lines: 1 to 4 the class, 4 the body, 5 the joint, 6 the inertial, 7 the actuator.
    lines = {name: quantity.span and quantity.span.line for name, quantity in actuator.quantities()}
    assert (lines["armature"], lines["kd"], lines["friction_viscous"], lines["kp"]) == (2, 3, 5, 7)
    assert actuator.kp is not None and actuator.kp.source == "robot.xml"


def test_unstated_and_stated_zero() -> None:
    """What the file does not state is MuJoCo's default, what it states as 0 is the file's; no limit is unknown."""
    stated = only(lifted('<joint name="j" armature="0" damping="0"/>', '<position joint="j" kp="1" kv="0"/>'))
    silent = only(lifted('<joint name="j"/>', '<position joint="j" kp="1"/>'))
    for actuator, origin in ((stated, Origin.MODEL), (silent, Origin.DEFAULT)):
        assert (actuator.armature.value, actuator.armature.origin) == (0.0, origin)
        assert actuator.kd is not None and (actuator.kd.value, actuator.kd.origin) == (0.0, origin)
        assert actuator.effort_limit.origin is Origin.UNKNOWN
    assert silent.kd is not None and silent.kd.note == "the file's servo has no kv: MuJoCo takes 0"


def test_filter_delay_bias() -> None:
    """A time constant of 0.05 s is 3.183 Hz, a delay stays, and 5 N*m of constant force at kp 50 is a bias of -0.1."""
    actuator = only(
        lifted(
            '<joint name="j"/>',
            '<general joint="j" biastype="affine" gainprm="50" biasprm="5 -50 -2" dyntype="filterexact" '
            'dynprm="0.05" delay="0.004" nsample="2"/>',
        )
    )
    assert actuator.filter_cutoff is not None
    assert actuator.filter_cutoff.value == pytest.approx(3.18309886184, rel=1e-11)  # 1 / (2 pi 0.05)
    assert actuator.delay is not None
    assert (actuator.delay.nominal.value, actuator.delay.low, actuator.delay.high) == (0.004, 0.004, 0.004)
    assert actuator.encoder_bias.value == -0.1


def test_at_the_actuator() -> None:
    """Actuator-level damping and armature act on the joint, times gear squared, with the joint's own."""
    actuator = only(
        lifted(
            '<joint name="j" damping="0.5" armature="0.1"/>',
            '<motor joint="j" gear="2" damping="0.2" armature="0.03" forcerange="-1 1"/>',
        )
    )
    assert said(actuator.friction_viscous) == (1.3, "N*m*s/rad", "model")  # 0.5 + 4 x 0.2
    assert said(actuator.armature) == (0.22, "kg*m^2", "model")  # 0.1 + 4 x 0.03
    assert actuator.armature.formula == "0.1 (joint) + 0.12 (actuator)"


@pytest.mark.parametrize(
    ("actuator", "joint", "limit", "clamp"),
    [
        ('gainprm="2" gear="5" ctrlrange="-1.5 1.5"', "", 15.0, None),  # 5 x 2 x 1.5
        ('ctrlrange="-4 9"', "", 9.0, (-4.0, 9.0)),
        ('ctrlrange="-4 4" forcerange="-7 7"', "", 4.0, None),
        ('ctrlrange="-4 3" forcerange="-7 7"', "", 4.0, (-4.0, 3.0)),
        ('ctrlrange="-9 8" forcerange="-7 7"', "", 7.0, None),
        ('ctrlrange="-9 9"', 'actuatorfrcrange="-5 5"', 5.0, None),
        ('gear="-2" ctrlrange="-1 3" forcerange="-10 10"', "", 6.0, (-6.0, 2.0)),
    ],
    ids=["the limit", "not symmetric", "tighter", "inside", "outside", "at the joint", "turned"],
)
def test_control_range_of_a_motor(
    actuator: str, joint: str, limit: float, clamp: tuple[float, float] | None
) -> None:
    """A torque motor's control range is its limit, or a clamp of the command where only that says the same."""
    found = only(lifted(f'<joint name="j" {joint}/>', f'<general joint="j" {actuator}/>'))
    assert (found.command, found.kp, found.kd) == (Command.EFFORT, None, None)
    assert found.effort_limit.value == limit
    ends = found.command_range and tuple(end.value for end in found.command_range)
    assert ends == clamp


@pytest.mark.parametrize("text_only", [False, True], ids=["compiled", "text"])
@pytest.mark.parametrize(
    ("words", "command", "gains"),
    [
        ('input="pos" controller="80 0 2 0 0 24"', Command.POSITION, (80.0, 2.0)),
        ('input="vel" controller="0 0 2 0 0 24"', Command.VELOCITY, (None, 2.0)),
        ('input="ff" controller="0 0 0 0 0 24"', Command.EFFORT, (None, None)),
    ],
    ids=["position", "velocity", "effort"],
)
def test_dcmotor(
    words: str, command: Command, gains: tuple[float | None, float | None], text_only: bool
) -> None:
    """A dcmotor with one input is a torque-speed line, whatever the input; gear 3 turns 45 at 30 into 135 at 10."""
    text = mjcf(
        '<joint name="j"/>', f'<dcmotor joint="j" nominal="24 45 30" saturation="24 0 0" gear="3" {words}/>'
    )
    view = view_of(text, folder="")
    if text_only:
        view = read_mjcf_text(parse_document(view.files), "asked for")
    found = only(lift_robot(view))
    assert (found.level, found.command) == (Level.DC_MOTOR, command)
    assert (found.kp and found.kp.value, found.kd and found.kd.value) == tuple(g and g * 9 for g in gains)
    assert found.stall_torque is not None and found.no_load_speed is not None
    assert found.stall_torque.value == pytest.approx(135.0)
    assert found.no_load_speed.value == pytest.approx(10.0)
    assert found.effort_limit.value == 72.0  # 24 x 3


def test_old_dcmotor() -> None:
    """Volts of 3.7 to 3.11, from the text: V = 24, K = 24/30 = 0.8, R = 0.8 x 24/45 = 0.4267; kp R/K, kd R/K - K."""
    text = mjcf(
        '<joint name="j"/>',
        '<dcmotor joint="j" nominal="24 45 30" saturation="24 0 0" input="position" '
        'controller="42.666666666666664 0 0.26666666666666661 0 0 24"/>',
    )
    files = (ModelFile("robot.xml", "", text.encode()),)
    found = lift_robot(read_mjcf_text(parse_document(files), "it is of MuJoCo 3.10"))
    actuator = only(found)
    assert actuator.kp is not None and actuator.kp.value == pytest.approx(80.0)
    assert actuator.kd is not None and actuator.kd.value == pytest.approx(2.0)
    assert found.notes[""] == ("read from the text alone: it is of MuJoCo 3.10",)


def test_pair_becomes_one() -> None:
    """A position and a velocity actuator on one joint are one servo, and a note says so."""
    found = lifted('<joint name="j"/>', '<position joint="j" kp="30"/><velocity joint="j" kv="4"/>')
    actuator = only(found)
    assert (actuator.kp and actuator.kp.value, actuator.kd and actuator.kd.value) == (30.0, 4.0)
    assert found.notes["j"] == ("2 actuators in the file (position, velocity) become one",)


@pytest.mark.parametrize(
    ("joint", "actuators", "head", "tail", "why", "line"),
    [
        ("", "", "", "", "no actuator", 2),
        ("", '<position joint="j" kp="-5"/>', "", "", "a position servo with gain -5 and stiffness -5", 6),
        (
            "",
            '<general joint="j" biastype="affine" gainprm="49" biasprm="0 -50 -2"/>',
            "",
            "",
            "a position servo with gain 49 and stiffness 50",
            6,
        ),
        (
            "",
            '<general joint="j" biastype="affine" biasprm="3"/>',
            "",
            "",
            "a motor with a velocity term or a constant force",
            6,
        ),
        (
            "",
            '<intvelocity joint="j" kp="3" actrange="-1 1"/>',
            "",
            "",
            "an actuator of another kind (intvelocity)",
            6,
        ),
        ("", '<muscle joint="j" lengthrange="0.1 1"/>', "", "", "an actuator of another kind (muscle)", 6),
        ("", '<motor joint="j"/><motor joint="j"/>', "", "", "2 actuators (motor, motor)", 6),
        (
            "",
            '<position joint="j" forcerange="-1 1"/><velocity joint="j"/>',
            "",
            "",
            "2 actuators, each with its own clamp, filter or delay",
            6,
        ),
        ("", '<motor joint="j" gear="0"/>', "", "", "an actuator with gear 0", 6),
        ("", '<motor joint="j" gear="2" group="4"/>', '<option actuatorgroupdisable="4"/>', "",
         "an actuator that the file switches off", 6),
        (
            "",
            '<dcmotor joint="j" motorconst="0.5" resistance="1"/>',
            "",
            "",
            "a dcmotor that is more than a PD within its voltage, or is commanded in volts",
            6,
        ),
        ('damping="-0.5"', '<motor joint="j"/>', "", "", "its damping is -0.5", 2),
        (
            "",
            '<motor tendon="t"/>',
            "",
            '<tendon><fixed name="t"><joint joint="j" coef="1"/></fixed></tendon>',
            "driven through the tendon 't'",
            2,
        ),
        (
            "",
            "",
            "",
            '<equality><joint joint1="j" joint2="k"/></equality>',
            "follows 'k' (equality)",
            2,
        ),
    ],
    ids=[
        "passive",
        "kp sign",
        "gain not kp",
        "offset",
        "integrator",
        "muscle",
        "two",
        "two clamps",
        "gear 0",
        "switched off",
        "volts",
        "negative damping",
        "tendon",
        "equality",
    ],
)  # fmt: skip
def test_left_alone(joint: str, actuators: str, head: str, tail: str, why: str, line: int) -> None:
    """What the law has no words for is left alone with the reason and the place; the other joint is lifted."""
    found = lifted(
        f'<joint name="j" {joint}/>\n<joint name="k"/>', f'{actuators}<motor joint="k"/>', head, tail
    )
    (item,) = found.left_alone
    assert (item.joint, item.why, item.span and item.span.line) == ("j", why, line)
    assert [actuator.joint for actuator in found.actuators.joints] == ["k"]
    assert found.actuators.unmanaged == ("j",)


LOOP = """<mujoco><worldbody>
<body name="base">INERTIAL<joint name="root"/>
<body name="crank"><joint name="crank"/>INERTIAL
<frame><body name="rod"><joint name="rod"/>INERTIAL<site name="tip"/></body></frame></body>
<body name="rocker"><joint name="rocker"/>INERTIAL<site name="pin"/></body>
<body name="tail"><joint name="tail"/>INERTIAL</body></body>
<body name="ball"><freejoint/>INERTIAL</body><body name="hand" mocap="true"/>
</worldbody><equality>EQUALITY</equality>ACTUATORS</mujoco>""".replace("INERTIAL", INERTIAL)


@pytest.mark.parametrize(
    "equality, members, loop",
    [
        (
            '<connect name="bar" body1="rod" body2="rocker" anchor="0 0 0"/>',
            ["crank", "rod", "rocker"],
            "the closed loop 'bar' (connect)",
        ),
        (
            '<weld body1="rod" body2="rocker"/>',
            ["crank", "rod", "rocker"],
            "the closed loop of rod and rocker (weld)",
        ),
        (
            '<connect site1="pin" site2="tip"/>',
            ["crank", "rod", "rocker"],
            "the closed loop of pin and tip (connect)",
        ),
        (
            '<connect body1="rod" body2="crank" anchor="0 0 0"/>',
            ["rod"],
            "the closed loop of rod and crank (connect)",
        ),
        ('<connect active="false" body1="rod" body2="rocker" anchor="0 0 0"/>', [], ""),
        ('<connect body1="rod" anchor="0 0 0"/>', [], ""),
        ('<weld body1="rod" body2="ball"/>', [], ""),
        ('<weld body1="hand" body2="tail"/>', [], ""),
    ],
    ids=["named", "weld", "sites", "parent", "off", "to the world", "floating", "mocap"],
)
def test_closed_loops(equality: str, members: list[str], loop: str) -> None:
    """Joints between the two bodies of a loop are left alone by its name where nothing drives them; no others are."""
    text = LOOP.replace("EQUALITY", equality)
    bare = lift_robot(view_of(text.replace("ACTUATORS", ""), folder=""))
    assert [(item.joint, item.why, item.undriven) for item in bare.left_alone] == [
        (name, f"in {loop}", True) for name in members
    ]
    assert [a.joint for a in bare.actuators.joints] == [
        name for name in ("root", "crank", "rod", "rocker", "tail") if name not in members
    ]
    motors = "".join(f'<motor joint="{name}"/>' for name in ("root", "crank", "tail"))
    driven = lift_robot(view_of(text.replace("ACTUATORS", f"<actuator>{motors}</actuator>"), folder=""))
    assert [a.joint for a in driven.actuators.joints] == ["root", "crank", "tail"]
    assert [item.why for item in driven.left_alone] == [
        f"no actuator, in {loop}" if name in members else "no actuator" for name in ("rod", "rocker")
    ]


def test_what_is_no_joint_of_ours() -> None:
    """Balls, free joints and joints without a name are in neither list."""
    text = """<mujoco><worldbody><body><freejoint name="base"/><geom size="0.1"/>
      <body><joint type="ball" name="b"/><geom size="0.1"/>
      <body><joint/><geom size="0.1"/></body></body></body></worldbody></mujoco>"""
    found = lift_robot(view_of(text, folder=""))
    assert (found.actuators.joints, found.left_alone) == ((), ())


def test_bare_model() -> None:
    """In a file without actuators gains are the controller's: unknown, and the command is a position."""
    actuator = only(lifted('<joint name="j" damping="0.5" actuatorfrcrange="-7 7"/>'))
    assert actuator.command is Command.POSITION
    assert actuator.kp is not None and actuator.kd is not None
    assert (actuator.kp.origin, actuator.kd.origin) == (Origin.UNKNOWN, Origin.UNKNOWN)
    assert actuator.kp.note == "the file has no actuators: gains are the controller's"
    assert actuator.effort_limit.value == 7.0


def test_pose_and_step() -> None:
    """The first keyframe is the default pose and the option the step, at their lines; else they are defaults."""
    found = lifted(
        '<joint name="j"/>',
        '<motor joint="j"/>',
        '<option timestep="0.004"/>',
        '\n<keyframe><key qpos="0.7"/><key qpos="0.9"/></keyframe>',
    )
    pose, step = only(found).default_position, found.actuators.physics_dt
    assert (pose.value, pose.origin, pose.span and pose.span.line) == (0.7, Origin.MODEL, 6)
    assert (step.value, step.origin, step.span and step.span.line) == (0.004, Origin.MODEL, 1)
    plain = lifted('<joint name="j" ref="0.2"/>', '<motor joint="j"/>', '<compiler angle="radian"/>')
    assert (only(plain).default_position.value, only(plain).default_position.origin) == (0.2, Origin.DEFAULT)
    assert (plain.actuators.physics_dt.value, plain.actuators.physics_dt.origin) == (0.002, Origin.DEFAULT)


def test_notes() -> None:
    """What stays in the model or is said otherwise: an uneven limit, a spring, polynomial damping, a dampratio."""
    found = lifted(
        '<joint name="j" stiffness="3" damping="1 0.2"/>',
        '<position joint="j" kp="5" dampratio="1" forcerange="-2 6"/>',
    )
    assert only(found).effort_limit.value == 6.0
    assert found.notes["j"] == (
        "the file's limit is not symmetric (-2 to 6), a spec has one number: the larger",
        "the file's polynomial damping stays in the model: a spec cannot express it",
        "the joint's own spring (3 N*m/rad) stays in the model: a spec cannot express it",
        "the file's dampratio becomes the kd that MuJoCo makes of it",
    )


@pytest.mark.parametrize(
    "actuator",
    [
        '<motor joint="j"/>',
        '<velocity joint="j" kv="2"/>',
        '<general joint="j" gainprm="5" biastype="affine" biasprm="0 -5 0"/>',
    ],
)
def test_a_dampratio_of_a_class_is_only_said_of_what_has_it(actuator: str) -> None:
    """The class also holds `<position dampratio="1"/>`, which no actuator of the file is."""
    classes = '<default><position kp="50" dampratio="1"/></default>'
    assert not lifted('<joint name="j"/>', actuator, classes).notes.get("j")


def test_text_does_not_tell() -> None:
    """From the text alone a dampratio gives no kd and an inherited range no clamp: unknown, never 0."""
    text = mjcf(
        '<joint name="j" range="-1 1"/>', '<position joint="j" kp="5" dampratio="1" inheritrange="1"/>'
    )
    files = (ModelFile("robot.xml", "", text.encode()),)
    actuator = only(lift_robot(read_mjcf_text(parse_document(files), "refused")))
    assert actuator.kd is not None and (actuator.kd.value, actuator.kd.origin) == (None, Origin.UNKNOWN)
    assert actuator.command_range is not None
    assert [end.value for end in actuator.command_range] == [None, None]


URDF = """<robot name="arm"><link name="a"/><link name="b"/><link name="c"/><link name="d"/>
<joint name="shoulder" type="revolute"><parent link="a"/><child link="b"/>
<limit lower="-1" upper="1" effort="40" velocity="3.5"/>
<dynamics damping="0.2" friction="0"/></joint>
<joint name="elbow" type="prismatic"><parent link="b"/><child link="c"/>
<limit lower="0" upper="0.1" effort="0" velocity="0"/></joint>
<joint name="hook" type="revolute"><parent link="c"/><child link="d"/>
<limit lower="0" upper="1" effort="1" velocity="1"/><mimic joint="elbow"/></joint></robot>"""


def test_urdf() -> None:
    """Limits and friction with their lines; armature is unknown; 0 of a limit is nobody's number; mimic follows."""
    found = lift_robot(read_urdf((ModelFile("arm.urdf", "", URDF.encode()),)))
    shoulder, elbow = found.actuators.joints
    assert said(shoulder.effort_limit) == (40.0, "N*m", "model")
    assert said(shoulder.velocity_limit) == (3.5, "rad/s", "model")
    assert said(shoulder.friction_viscous) == (0.2, "N*m*s/rad", "model")
    assert said(shoulder.friction_coulomb) == (0.0, "N*m", "model")
    assert said(shoulder.armature) == (None, "kg*m^2", "unknown")
    assert shoulder.friction_viscous.span is not None and shoulder.friction_viscous.span.line == 4
    assert shoulder.position_range == (-1.0, 1.0)
    assert said(elbow.effort_limit) == (None, "N", "unknown")
    assert elbow.effort_limit.note == "the file says 0 N, which is a placeholder"
    assert elbow.velocity_limit.span is not None and elbow.velocity_limit.note is not None
    assert said(elbow.friction_viscous) == (0.0, "N*s/m", "default")
    assert [(item.joint, item.why) for item in found.left_alone] == [("hook", "follows 'elbow' (mimic)")]
    assert found.actuators.physics_dt.origin is Origin.UNKNOWN


@pytest.mark.parametrize(
    ("text", "note"),
    [
        # What Gazebo writes of a limit that is not there is none either.
        ("1.79769e+308", "1.79769e308 rad/s is no limit"),
        # Beyond the largest number, which is 1.8e308, as without an end.
        ("1e999", "the file has no limit"),
        ("inf", "the file has no limit"),
    ],
)
def test_a_speed_of_a_urdf_that_is_no_limit(text: str, note: str) -> None:
    """It is told with its line, as an effort is: what nobody states has neither."""
    endless = URDF.replace('velocity="3.5"', f'velocity="{text}"').replace('effort="40"', f'effort="{text}"')
    (joint, *_) = lift_robot(read_urdf((ModelFile("arm.urdf", "", endless.encode()),))).actuators.joints
    for limit, unit in ((joint.velocity_limit, "rad/s"), (joint.effort_limit, "N*m")):
        assert (limit.value, limit.note) == (None, note.replace("rad/s", unit))
        assert limit.span is not None and limit.span.line == 3
    bare = URDF.replace(' velocity="3.5"', "")
    (joint, *_) = lift_robot(read_urdf((ModelFile("arm.urdf", "", bare.encode()),))).actuators.joints
    assert (joint.velocity_limit.value, joint.velocity_limit.span) == (None, None)


def test_inertia_comes_along() -> None:
    """M_jj of a bar of 1 kg m^2 behind an armature of 0.5 is 1.5, others held or free."""
    actuator = only(lifted('<joint name="j" armature="0.5"/>', '<motor joint="j"/>'))
    assert actuator.inertia_held is not None and actuator.inertia_free is not None
    assert math.isclose(actuator.inertia_held.reference, 1.5)
    assert math.isclose(actuator.inertia_free.reference, 1.5)
