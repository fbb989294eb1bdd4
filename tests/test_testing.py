"""`actspec.testing`: a spec beside files and live objects, with the places of what differs."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import mujoco
import pytest

import actspec
from actspec.diagnostics import AuditError
from actspec.testing import assert_agrees, compared

MODEL = """<mujoco model="leg">
  <compiler angle="radian"/>
  <worldbody><body>
    <joint name="hip" axis="0 1 0" armature="0.01" frictionloss="0.2" damping="0.05"/>
    <geom size="0.1"/>
    <body pos="0 0 -0.3"><joint name="knee" axis="0 1 0" armature="0.01" frictionloss="0.2" damping="0.05"/>
    <geom size="0.05"/></body>
  </body></worldbody>
  <actuator>
    <position name="hip" joint="hip" kp="40" kv="2" forcerange="-30 30"/>
    <position name="knee" joint="knee" kp="10" kv="0.5" gear="2" forcerange="-15 15"/>
  </actuator>
</mujoco>
"""
# Gear 2: kp 2^2 x 10 = 40, kd 2^2 x 0.5 = 2, limit 2 x 15 = 30 at the knee.

SPEC = """actspec: 1
robot:
  name: leg
  model: leg.xml
actuators:
  leg:
    joints: [".*"]
    level: ideal_pd
    command: position
    kp: 40 N*m/rad
    kd: 2 N*m*s/rad
    effort_limit: 30 N*m
    armature: 0.01 kg*m^2
    friction: {coulomb: 0.2 N*m, viscous: 0.05 N*m*s/rad}
"""


@pytest.fixture
def leg(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the model and its spec, to work in."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "leg.xml").write_text(MODEL)
    (tmp_path / "leg.yaml").write_text(SPEC)
    return tmp_path


LINE = """actspec: 1
robot: {name: leg, model: none, joints: [hip, knee]}
motors: {m: {side: joint, stall_torque: 40 N*m, no_load_speed: 21 rad/s}}
actuators:
  leg: {joints: [".*"], motor: m, level: dc_motor, kp: 40 N*m/rad, kd: 2 N*m*s/rad, effort_limit: 30 N*m}
"""

JOINT = """<link name="{0}_link"/><joint name="{0}" type="revolute">
<parent link="base"/><child link="{0}_link"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="30" velocity="{1}"/></joint>
"""


def test_a_speed_that_the_motor_does_not_reach(leg: Path) -> None:
    """A URDF's 60 rad/s are 60 / 21 = 2.86 times the line's end; 41 / 21 = 1.95 may be a solver's, and 100 nobody's."""
    (leg / "line.yaml").write_text(LINE)
    said = {}
    for speed in (41, 60, 100):
        text = f'<robot name="leg"><link name="base"/>{JOINT.format("hip", 21)}{JOINT.format("knee", speed)}</robot>'
        (leg / f"{speed}.urdf").write_text(text)
        said[speed] = compared("line.yaml", f"{speed}.urdf").wrong()
    assert said == {
        41: [],
        60: [
            "knee: the velocity limit is 60 rad/s (60.urdf:6:1), and by the spec it turns at 21 rad/s (line.yaml:3:64) "
            "without load (x2.86)"
        ],
        100: [],
    }
    with pytest.raises(AssertionError, match="does not agree with line"):
        assert_agrees("line.yaml", "60.urdf")
    assert not compared("line.yaml", "60.urdf", joints="hip").wrong()
    assert not compared("line.yaml", "60.urdf", fields="effort_limit").wrong()


DRIVE = '    <position name="knee" joint="knee" kp="10" kv="0.5" gear="2" forcerange="-15 15"/>\n'


@pytest.mark.parametrize(
    "model, undriven",
    [
        (MODEL.replace(DRIVE, ""), ("knee",)),
        # Nobody is driven in the file itself.
        (MODEL[: MODEL.index("  <actuator>")] + "</mujoco>", ()),
        # A tendon moves it.
        (
            MODEL.replace(DRIVE, '    <motor tendon="t"/>\n').replace(
                "  <actuator>",
                '  <tendon><fixed name="t"><joint joint="knee" coef="1"/></fixed></tendon>\n  <actuator>',
            ),
            (),
        ),
        # It moves with the hip.
        (
            MODEL.replace(DRIVE, "").replace(
                "  <actuator>", '  <equality><joint joint1="knee" joint2="hip"/></equality>\n  <actuator>'
            ),
            (),
        ),
    ],
    ids=["one", "all", "tendon", "coupled"],
)
def test_a_joint_without_its_drive(model: str, undriven: tuple[str, ...], leg: Path) -> None:
    """It fails where another joint of the model has an actuator, whatever its passive part; so do objects."""
    Path("bare.xml").write_text(model)
    for other in ("bare.xml", mujoco.MjSpec.from_string(model)):
        assert compared("leg.yaml", other).undriven == undriven
    if undriven:
        with pytest.raises(AssertionError, match=r"\n  knee: no actuator drives it in bare\.xml"):
            assert_agrees("leg.yaml", "bare.xml")
        # Who asks for the armature alone does not ask for the drive, nor who asks for the hip.
        assert_agrees("leg.yaml", "bare.xml", fields="armature")
        assert_agrees("leg.yaml", "bare.xml", joints="hip")


DEPLOY = "joint_names: [hip, knee]\nkp: [40, 40]\nkd: [2, 2]\n"


def test_the_control_period(leg: Path) -> None:
    """Five steps of 4 ms are 20 ms; it is compared where both state it and nobody asked for other figures."""
    Path("leg.yaml").write_text(SPEC + "timing: {physics_dt: 4 ms, decimation: 5}\n")
    Path("leg_deploy.yaml").write_text(DEPLOY)
    assert assert_agrees("leg.yaml", "leg_deploy.yaml").count == 4
    Path("leg_deploy.yaml").write_text(DEPLOY + "control_dt: 0.02\n")
    assert assert_agrees("leg.yaml", "leg_deploy.yaml").count == 5
    Path("leg_deploy.yaml").write_text(DEPLOY + "dt: 0.01\n")
    with pytest.raises(AssertionError) as error:
        assert_agrees("leg.yaml", "leg_deploy.yaml")
    assert str(error.value).splitlines() == [
        "leg_deploy.yaml does not agree with leg.yaml (5 figures compared):",
        "  the control period is 0.01 s (leg_deploy.yaml:4:5), 0.02 s (leg.yaml:15:22) in the spec (x0.5)",
    ]
    assert assert_agrees("leg.yaml", "leg_deploy.yaml", fields=["kp", "kd"]).count == 4
    # A spec without a rate asks for none.
    Path("leg.yaml").write_text(SPEC)
    assert assert_agrees("leg.yaml", "leg_deploy.yaml").count == 4


def test_gains_of_0_are_no_drive(leg: Path) -> None:
    """A spec of a joint with kp 0 and kd 0 asks for no actuator."""
    Path("leg.xml").write_text(MODEL.replace(DRIVE, ""))
    passive = "    overrides: {knee: {kp: 0 N*m/rad, kd: 0 N*m*s/rad}}\n"
    Path("leg.yaml").write_text(SPEC.replace("    effort_limit: 30 N*m\n", "") + passive)
    assert compared("leg.yaml", "leg.xml").undriven == ()


def test_a_file_that_agrees(leg: Path) -> None:
    """Both joints have the six figures of the spec, behind gear 1 and behind gear 2."""
    found = assert_agrees("leg.yaml", "leg.xml")
    assert (found.spec, found.other, found.count) == ("leg.yaml", "leg.xml", 2 * 6)
    assert str(found) == ""


def test_a_difference_names_both_sides(leg: Path) -> None:
    """What the file has and what the spec has, with units and places; 45 / 30 = 1.5, 2 x 15 -> 2 x 22.775 = 45.55."""
    (leg / "leg.xml").write_text(MODEL.replace("-15 15", "-22.775 22.775").replace('kp="40"', 'kp="4"'))
    with pytest.raises(AssertionError) as error:
        assert_agrees("leg.yaml", "leg.xml")
    assert str(error.value).splitlines() == [
        "leg.xml does not agree with leg.yaml (12 figures compared):",
        "  hip: the stiffness kp is 4 N*m/rad (leg.xml:10:5), 40 N*m/rad (leg.yaml:10:9) in the spec (x0.1)",
        "  knee: the effort limit is 45.55 N*m (leg.xml:11:5), 30 N*m (leg.yaml:12:19) in the spec (x1.52)",
    ]


_GOOD = "joint_names: [hip, knee]\nkp: [40, 40]\nkd: [2, 2]\n"
_BY_NAME = "kp: {hip: 40, knee: 40}\nkd: {hip: 2, knee: 2}\n"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            _GOOD.replace("40, 40", '40, "400"'),
            '2:10: kp: knee has "400", which is no number as YAML reads it',
        ),
        (
            _BY_NAME.replace("knee: 40", "knee: 4O0"),
            "1:21: kp: knee has 4O0, which is no number as YAML reads it",
        ),
        (_GOOD.replace("[2, 2]", "0,5"), "3:5: kd: it has 0,5, which is no number as YAML reads it"),
        (_GOOD.replace("40, 40", "40"), "2:5: kp: it has 1 value for 2 joint names"),
        (_BY_NAME.replace("knee: 40", "kne: 400"), "2:20: kd: it has 'knee' where kp has 'kne'"),
        (f"kp: [400, 400]\n{_GOOD}", "3:1: 'kp' stands a second time, with another value than in line 1"),
        (
            "joint_names: [hip, knee, hip]\nkp: [40, 40, 400]\nkd: {hip: 2, knee: 2}\n",
            "1:26: the joint names have 'hip' twice, first at 1:15",
        ),
    ],
    ids=["text", "text by name", "one text", "too few", "misspelt", "a key twice", "a name twice"],
)
def test_a_figure_that_is_not_read_fails(text: str, told: str, leg: Path) -> None:
    """What is left agrees, and the robot may run another number: the reader's own sentence, at its place."""
    (leg / "leg_deploy.yaml").write_text(text)
    with pytest.raises(AssertionError) as error:
        assert_agrees("leg.yaml", "leg_deploy.yaml")
    first, second = str(error.value).splitlines()
    assert first.startswith("leg_deploy.yaml does not agree with leg.yaml (")
    assert second.startswith(f"  leg_deploy.yaml:{told}")
    assert len(compared("leg.yaml", "leg_deploy.yaml").not_taken) == 1


def test_what_is_not_read_of_something_else(leg: Path) -> None:
    """Text in a field that is not asked for, in another robot's block, or in a range where only kp is asked for."""
    (leg / "leg_deploy.yaml").write_text(_GOOD.replace("[2, 2]", "0,5"))
    assert assert_agrees("leg.yaml", "leg_deploy.yaml", fields="kp").count == 2
    two = f"leg:\n  {_GOOD}arm:\n  {_GOOD.replace('[2, 2]', '0,5')}".replace("\nk", "\n  k")
    (leg / "leg_deploy.yaml").write_text(two)
    assert assert_agrees("leg.yaml", "leg_deploy.yaml", robot="leg").count == 4
    (leg / "leg.xml").write_text(MODEL.replace('name="hip"', 'name="hip" range="1 -1"', 1))
    assert assert_agrees("leg.yaml", "leg.xml", fields="kp").count == 2
    with pytest.raises(AssertionError, match=r'leg.xml:\d+:\d+: hip: range="1 -1" begins above its end'):
        assert_agrees("leg.yaml", "leg.xml")


def test_text_in_a_configuration_fails(leg: Path) -> None:
    """As in a deploy file."""
    cfg = (
        "from isaaclab.actuators import IdealPDActuatorCfg\nfrom isaaclab.assets import ArticulationCfg\n"
        'LEG_CFG = ArticulationCfg(actuators={"leg": IdealPDActuatorCfg(joint_names_expr=["hip", "knee"], '
        'stiffness="400", damping=2.0)})\n'
    )
    (leg / "leg_cfg.py").write_text(cfg)
    with pytest.raises(AssertionError, match=r"leg_cfg.py:3:\d+: .*\(CFG003\)"):
        assert_agrees("leg.yaml", "leg_cfg.py")


@pytest.mark.parametrize(("tolerance", "agrees"), [(1e-3, True), (1e-5, False)])
def test_tolerance_is_relative(leg: Path, tolerance: float, agrees: bool) -> None:
    """39.99 is 2.5e-4 off 40."""
    (leg / "leg.xml").write_text(MODEL.replace('kp="40"', 'kp="39.99"'))
    assert (compared("leg.yaml", "leg.xml", tolerance=tolerance).differences == ()) is agrees


def test_a_servo_without_a_limit_is_unlimited(leg: Path) -> None:
    """A limit that a servo's file leaves out is none, and not unknown."""
    (leg / "leg.xml").write_text(MODEL.replace(' forcerange="-30 30"', ""))
    (line,) = compared("leg.yaml", "leg.xml").wrong()
    assert line == "hip: the effort limit is unlimited (leg.xml:10:5), 30 N*m (leg.yaml:12:19) in the spec"


def test_a_servo_whose_gain_is_not_its_stiffness(leg: Path) -> None:
    """MuJoCo settles at the figure times the target: 2 x 10 u = 10 (2 q) is q = u where u is 0.2 rad, and not u / 2.

    The links hang on a joint without gravity.
    """
    model = mujoco.MjModel.from_xml_string(MODEL)
    model.opt.gravity[:], model.dof_frictionloss[:] = 0.0, 0.0
    data = mujoco.MjData(model)
    rest = []
    for _ in range(2):
        data.ctrl[1] = 0.2
        mujoco.mj_step(model, data, 10_000)
        rest.append(data.qpos[1])
        model.actuator_gainprm[1, 0] *= 2.0
    model = mujoco.MjModel.from_xml_string(MODEL)
    model.actuator_gainprm[1, 0] *= 2.0
    for fields in ((), "kp", ["kp"]):
        ((joints, one),) = compared("leg.yaml", model, fields=fields).differences
        assert (joints, one.field, one.expected) == (("knee",), "command_gain", 1.0)
        assert one.value == pytest.approx(rest[1] / rest[0], rel=1e-6)
    assert not compared("leg.yaml", model, fields="kd").differences


def test_a_servo_whose_gear_is_negative(leg: Path) -> None:
    """kp and kd go by the square of the gear, and the knee settles at minus its target."""
    model = mujoco.MjModel.from_xml_string(MODEL)
    model.actuator_gear[1, 0] = -2.0
    ((joints, one),) = compared("leg.yaml", model).differences
    assert (joints, one.field, one.value, one.expected) == (("knee",), "command_gain", -1.0, 1.0)


def test_a_servo_with_a_constant_force(leg: Path) -> None:
    """5 N*m beside 40 N*m/rad: the servo rests where 40 q = 40 u + 5, 0.125 rad beyond its target; q + bias is u there.

    So it is in a model that was compiled; a spec that has the bias agrees.
    """
    servo = '<general name="hip" joint="hip" gainprm="40" biastype="affine" biasprm="5 -40 -2" forcerange="-30 30"/>'
    (leg / "leg.xml").write_text(
        MODEL.replace('<position name="hip" joint="hip" kp="40" kv="2" forcerange="-30 30"/>', servo)
    )
    for thing in ("leg.xml", mujoco.MjModel.from_xml_path("leg.xml")):
        for fields in ((), "encoder_bias"):
            ((joints, one),) = compared("leg.yaml", thing, fields=fields).differences
            assert (joints, one.field, one.expected) == (("hip",), "encoder_bias", 0.0)
            assert one.value == pytest.approx(-0.125)
    assert compared("leg.yaml", "leg.xml").wrong() == [
        "hip: the encoder bias is -0.125 rad (leg.xml:10:5), 0 rad (leg.yaml:10:9) in the spec"
    ]
    (leg / "leg.yaml").write_text(f"{SPEC}    overrides:\n      hip: {{encoder_bias: -0.125 rad}}\n")
    assert_agrees("leg.yaml", "leg.xml")


MOTORS = MODEL.replace("<position", "<motor").replace(' kp="40" kv="2"', "").replace(' kp="10" kv="0.5"', "")


def test_what_is_not_stated_is_listed(leg: Path) -> None:
    """Behind motors the gains and the delay are a controller's: 2 x 4 figures are left, 3 are listed."""
    (leg / "leg.xml").write_text(MOTORS)
    (leg / "leg.yaml").write_text(SPEC + "    delay: 10 ms\n")
    found = assert_agrees("leg.yaml", "leg.xml")
    assert found.count == 2 * 4
    assert str(found).splitlines() == [
        "hip, knee: the stiffness kp is not stated, 40 N*m/rad (leg.yaml:10:9) in the spec",
        "hip, knee: the drive gain kd is not stated, 2 N*m*s/rad (leg.yaml:11:9) in the spec",
        "hip, knee: the delay is not stated, 0.01 s (leg.yaml:15:12) in the spec",
    ]
    with pytest.raises(AssertionError, match=r"\n  hip, knee: the delay is not stated, 0\.01 s"):
        assert_agrees("leg.yaml", "leg.xml", missing="error")
    assert_agrees("leg.yaml", "leg.xml", missing="error", fields=["armature", "friction.viscous"])


def test_nothing_compared_is_a_failure(leg: Path) -> None:
    """A test that compares nothing must not be green."""
    (leg / "leg.xml").write_text(MOTORS)
    with pytest.raises(
        AssertionError, match=r"^no figure of leg\.xml can be compared with leg\.yaml:\n  hip, "
    ):
        assert_agrees("leg.yaml", "leg.xml", fields=["kp"])


def test_a_joint_that_is_missing(leg: Path) -> None:
    """A deploy file of one joint."""
    (leg / "leg_deploy.yaml").write_text("joint_names: [hip, ankle]\nkp: [40, 7]\nkd: [2, 7]\n")
    with pytest.raises(AssertionError, match=r"\n  knee: not in leg_deploy\.yaml$"):
        assert_agrees("leg.yaml", "leg_deploy.yaml")
    assert assert_agrees("leg.yaml", "leg_deploy.yaml", joints="hip").count == 2


def test_what_the_spec_does_not_state_is_not_compared(leg: Path) -> None:
    """The spec takes the armature of its model, 0.01; the file with 0.05 contradicts nobody."""
    (leg / "leg.yaml").write_text(SPEC.replace("    armature: 0.01 kg*m^2\n", ""))
    (leg / "other.xml").write_text(MODEL.replace("0.01", "0.05"))
    assert assert_agrees("leg.yaml", "other.xml").count == 2 * 5


def test_configurations_are_read_and_not_run(leg: Path) -> None:
    """kd 4 / 2 = 2 is folded; what the file does besides is not done."""
    text = (
        "from isaaclab.actuators import IdealPDActuatorCfg\nopen('ran', 'w')\n"
        "LEG = {'leg': IdealPDActuatorCfg(joint_names_expr=['.*'], stiffness=40.0, damping=4 / 2, effort_limit=31)}\n"
    )
    (leg / "leg_cfg.py").write_text(text)
    (line,) = compared("leg.yaml", "leg_cfg.py").wrong()
    assert line.startswith("hip, knee: the effort limit is 31 N*m (leg_cfg.py:3:")
    assert not (leg / "ran").exists()


@pytest.mark.parametrize("kind", ["model", "spec", "entity"])
def test_live_models(leg: Path, kind: str) -> None:
    """Compiled models and models that are being built, with gears applied as in the file."""

    class Entity:
        spec = mujoco.MjSpec.from_string(MODEL)

    thing = {"model": mujoco.MjModel.from_xml_string(MODEL), "spec": Entity.spec, "entity": Entity()}[kind]
    spec = actspec.resolve("leg.yaml")
    assert assert_agrees(spec, thing).count == 2 * 6
    if kind == "model":
        thing.dof_frictionloss[1] = 0.35
        (line,) = compared(spec, thing).wrong()
        assert (
            line
            == "knee: the dry friction is 0.35 N*m (MjModel), 0.2 N*m (leg.yaml:14:25) in the spec (x1.75)"
        )


def test_one_of_several_configurations(leg: Path) -> None:
    """The patterns of the one that is named are the spec's joints; without a name it is not known which, nor how."""
    group = "{{'leg': IdealPDActuatorCfg(joint_names_expr=['.*'], stiffness={}, damping=2.0)}}"
    cfg = "ArticulationCfg(actuators={})".format
    lines = (
        "from isaaclab.actuators import IdealPDActuatorCfg",
        "from isaaclab.assets import ArticulationCfg",
        f"SOFT_CFG = {cfg(group.format(40.0))}",
        f"HARD_CFG = {cfg(group.format(60.0))}",
    )
    (leg / "cfg.py").write_text("\n".join(lines))
    assert assert_agrees("leg.yaml", "cfg.py", robot="SOFT_CFG").count == 2 * 2
    (line,) = compared("leg.yaml", "cfg.py", robot="HARD_CFG").wrong()
    assert line.startswith("hip, knee: the stiffness kp is 60 N*m/rad (cfg.py:4:")
    with pytest.raises(
        AuditError, match=r"it is not known which robots are the same.*\n.*name one with robot='NAME'"
    ):
        assert_agrees("leg.yaml", "cfg.py")


@dataclasses.dataclass
class IdealPDActuatorCfg:
    """As Isaac Lab's, field for field; the real class is held to the spec in tests/frameworks/test_live.py."""

    joint_names_expr: list[str]
    stiffness: Any
    damping: Any
    effort_limit: Any = None
    armature: Any = dataclasses.field(default_factory=lambda: dataclasses.MISSING)
    class_type: type = dict


def test_live_configurations(leg: Path) -> None:
    """A place is the way to the number; what is None or missing is not stated."""
    cfg = {"leg": IdealPDActuatorCfg([".*"], {"hip": 40.0, "knee": 60.0}, 2.0)}
    found = compared(actspec.load("leg.yaml"), cfg)
    assert found.count == 2 * 2
    assert found.wrong() == [
        "knee: the stiffness kp is 60 N*m/rad (actuators['leg'].stiffness), 40 N*m/rad (leg.yaml:10:9) in the spec"
        " (x1.5)"
    ]
    assert len(found.unknown) == 4


def test_wrong_arguments(leg: Path) -> None:
    """Each is an error of its own, before or beside any comparison."""
    with pytest.raises(TypeError, match=r"got set$"):
        assert_agrees("leg.yaml", {"leg.xml"})
    for nothing in (None, b"leg.yaml", {"leg": 1}):
        kind = type(nothing).__name__
        with pytest.raises(
            TypeError, match=rf"a spec is its path, or what actspec.load makes of it, got {kind}$"
        ):
            assert_agrees(nothing, "leg.xml")  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"a spec has no figure 'stiffness'; it has kp, kd, "):
        assert_agrees("leg.yaml", "leg.xml", fields=["stiffness"])
    with pytest.raises(ValueError, match=r"a spec has no figure 'stiffness'; it has kp, kd, "):
        assert_agrees("leg.yaml", "leg.xml", fields="stiffness")
    with pytest.raises(AuditError, match=r"no robot is called 'lag': leg\.yaml has leg; leg\.xml has leg$"):
        assert_agrees("leg.yaml", "leg.xml", robot="lag")
    with pytest.raises(ValueError, match=r"is not a regular expression"):
        assert_agrees("leg.yaml", "leg.xml", joints="(")
    with pytest.raises(ValueError, match=r"no joint of leg\.yaml matches 'ankle'; it has hip, knee"):
        assert_agrees("leg.yaml", "leg.xml", joints=["hip", "ankle"])
    with pytest.raises(ValueError, match=r"missing is 'ignore' or 'error', got 'fail'"):
        assert_agrees("leg.yaml", "leg.xml", missing="fail")  # type: ignore[arg-type]
    for wrong in ("x", -1, float("nan")):
        with pytest.raises(ValueError, match=rf"tolerance is a number of 0 or more, got {wrong!r}"):
            assert_agrees("leg.yaml", "leg.xml", tolerance=wrong)  # type: ignore[arg-type]
    with pytest.raises(AuditError, match="must be NAME==VERSION, got 'isaaclab'"):
        assert_agrees("leg.yaml", "leg.xml", target="isaaclab")
    with pytest.raises(AuditError, match="cannot be read"):
        assert_agrees("leg.yaml", "none.xml")


def test_a_release_that_nobody_knows_is_told(leg: Path) -> None:
    """It is taken for the last one that is known; it was, without a word."""
    with pytest.warns(
        UserWarning, match=r"^isaaclab==9: actspec knows Isaac Lab up to .*, and takes 9 for that"
    ) as said:
        assert_agrees("leg.yaml", "leg.xml", target="isaaclab==9")
    assert [Path(one.filename).name for one in said] == ["test_testing.py"]


def test_the_place_of_a_keyframes_pose(leg: Path) -> None:
    """It is the key's, where an actuator drives the joint too; a ratio of two signs is none: 2.5 beside -1.5 rad."""
    key = '<keyframe>\n<key name="home" qpos="0.5 2.5"/></keyframe></mujoco>'
    text = MODEL.replace("</mujoco>", key)
    (leg / "leg.xml").write_text(text)
    line = text[: text.index("<key name")].count("\n") + 1
    pose = "  default_pose:\n    hip: 0.5 rad\n    knee: -1.5 rad\n"
    (leg / "leg.yaml").write_text(SPEC.replace("actuators:", f"{pose}actuators:"))
    assert compared("leg.yaml", "leg.xml").wrong() == [
        f"knee: the default position is 2.5 rad (leg.xml:{line}:1), -1.5 rad (leg.yaml:7:11) in the spec"
    ]


def test_lists_without_names_say_why_joints_are_missing(leg: Path) -> None:
    """A deploy file of lists alone has the joints, and does not name them: what to add is said."""
    (leg / "leg_deploy.yaml").write_text("kp: [40, 41]\nkd: [2, 3]\n")
    with pytest.raises(AssertionError) as failed:
        assert_agrees("leg.yaml", "leg_deploy.yaml")
    said = "leg_deploy.yaml:1:5: no joint is named for kp, kd, so they are not compared: add joint_names: [...] in the "
    assert f"{said}order of its lists (DEPLOY002)" in str(failed.value)
