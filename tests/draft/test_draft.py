"""Importing one robot file: figures, groups, remarks, what is left alone, and that a compile changes nothing."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from actspec import api
from actspec.diagnostics import ActspecError, RobotError
from actspec.draft import starting_spec
from actspec.readings.joint import read_joint
from actspec.resolution.quantities import finite_limit
from actspec.robot.load import load_robot
from actspec.robot.view import RobotView
from actspec.simulators.mujoco import DcMotorDialect, installed_dialect
from actspec.spec.document import document_from_text
from actspec.spec.validate import validate
from tests.importing import INERTIAL, NASTY, Imported, bare, imported, mjcf

TOLERANCE = 1e-9
"""Relative; computed numbers are written with 12 digits."""


def drafted(folder: Path, text: str, name: str = "robot.xml", damping: str | None = None) -> Imported:
    """A robot file, imported."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return imported([path], folder, damping=damping)


def groups(folder: Path, text: str, name: str = "robot.xml") -> dict[str, Any]:
    """The groups of a robot file's spec, without `value` and `source` around the numbers."""
    found: dict[str, Any] = bare(drafted(folder, text, name).data["actuators"])
    return found


def effective(robot: RobotView) -> dict[str, tuple[float, ...]]:
    """What acts on each joint: kp, kd, passive damping, dry friction, armature, limit."""
    found = {}
    for joint in robot.joints:
        reading = read_joint(robot, joint.name)
        own = [drive.view for drive in reading.drives]
        limit = finite_limit(reading.drive_limit)
        found[joint.name] = (
            sum(a.kp for a in own),
            sum(a.kd for a in own),
            joint.damping + sum(a.gear**2 * a.damping[0] for a in own),
            joint.frictionloss,
            joint.armature + sum(a.gear**2 * a.armature for a in own),
            0.0 if limit is None else limit.require(),
        )
    return found


def recompiled(folder: Path, text: str) -> tuple[RobotView, RobotView]:
    """A robot before and after its spec is compiled into it."""
    spec = folder / "spec.yaml"
    spec.write_text(drafted(folder, text).draft.text, encoding="utf-8")
    before = load_robot(str(folder / "robot.xml"))
    version = installed_dialect().text
    compilation = api.compile(spec, targets=[f"mujoco=={version}"], output=str(folder / "out"))
    target = folder / "out" / "mujoco"
    target.mkdir(parents=True)
    for file in compilation.emissions[0].files:
        (target / file.path).write_bytes(file.data)
    return before, load_robot(str(target / "robot.xml"))


# --- figures --------------------------------------------------------------------------------------


def test_servo(tmp_path: Path) -> None:
    """A position servo gives kp and kd at the joint, gear squared, and the file's passive values."""
    text = mjcf(
        '<joint name="j" damping="0.3" armature="0.02" frictionloss="0.1" range="-1 1"/>',
        '<position name="a" joint="j" kp="10" kv="0.5" gear="3" forcerange="-4 4"/>',
    )
    # kp 9 x 10, kd 9 x 0.5, limit 3 x 4.
    assert groups(tmp_path, text) == {
        "joints": {
            "joints": ["j"],
            "level": "ideal_pd",
            "command": "position",
            "kp": "90 N*m/rad",
            "kd": "4.5 N*m*s/rad",
            "effort_limit": "12 N*m",
            "armature": "0.02 kg*m^2",
            "friction": {"coulomb": "0.1 N*m", "viscous": "0.3 N*m*s/rad"},
        }
    }


def test_slide_units(tmp_path: Path) -> None:
    """A prismatic joint is written in N and m."""
    text = mjcf(
        '<joint name="finger" type="slide" damping="2" armature="0.5"/>',
        '<position joint="finger" kp="100" kv="7" forcerange="-20 20"/>',
    )
    found = groups(tmp_path, text)["finger"]
    assert (found["kp"], found["kd"], found["effort_limit"]) == ("100 N/m", "7 N*s/m", "20 N")
    assert (found["armature"], found["friction"]["viscous"]) == ("0.5 kg", "2 N*s/m")


def test_unstated_is_unknown(tmp_path: Path) -> None:
    """What the file does not state is unknown, and what it states as 0 is 0."""
    text = mjcf('<joint name="hip" armature="0"/>\n<joint name="knee"/>', '<motor joint="hip"/>')
    found = drafted(tmp_path, text.replace("</actuator>", '<motor joint="knee"/></actuator>'))
    legs = found.data["actuators"]["legs"]
    assert legs["joints"] == [".*"]
    assert bare(legs["armature"]) == "0 kg*m^2"
    assert legs["friction"] == {"coulomb": "unknown", "viscous": "unknown"}
    assert legs["effort_limit"] == "unknown"
    assert "velocity_limit" not in legs
    assert legs["overrides"] == {"knee": {"armature": "unknown"}}
    assert found.draft.unknown["armature", ""] == ("legs (knee)",)


def test_some_joints_lack_a_figure(tmp_path: Path) -> None:
    """A group of which one joint lacks a kd is told with that joint, one that lacks it whole by its name."""
    names = ("shoulder", "elbow", "wrist")
    text = mjcf(
        "\n".join(f'<joint name="{name}" armature="1"/>' for name in names),
        "".join(
            f'<position joint="{name}" kp="50" forcerange="-5 5"{kv}/>'
            for name, kv in zip(names, (' kv="5"', "", ' kv="5"'), strict=True)
        ),
    )
    unknown = drafted(tmp_path, text).draft.unknown
    assert unknown["kd", ""] == ("arm (elbow)",)
    assert unknown["friction.coulomb", ""] == ("arm",)
    assert ("armature", "") not in unknown


def test_stated_by_class(tmp_path: Path) -> None:
    """What a default class states is stated."""
    head = '<default><joint armature="0.01" damping="0"/></default>'
    found = groups(tmp_path, mjcf('<joint name="j"/>', '<motor joint="j"/>', head))["joints"]
    assert found["armature"] == "0.01 kg*m^2"
    assert found["friction"] == {"coulomb": "unknown", "viscous": "0 N*m*s/rad"}


def test_motor(tmp_path: Path) -> None:
    """A torque motor has neither kp nor kd; its control range times gear and gain is its limit."""
    text = mjcf('<joint name="j"/>', '<general joint="j" gainprm="2" gear="5" ctrlrange="-1.5 1.5"/>')
    found = drafted(tmp_path, text)
    group = found.data["actuators"]["joints"]
    assert group["command"] == "effort"
    assert "kp" not in group and "kd" not in group and "command_range" not in group
    assert bare(group["effort_limit"]) == "15 N*m"  # 5 x 2 x 1.5
    assert "gear and gain of 10 go: after a compile the control is in N*m at the joint" in found.draft.text


def test_velocity(tmp_path: Path) -> None:
    """A velocity servo has kd alone, and its clamp is a speed, divided by the gear."""
    text = mjcf('<joint name="j"/>', '<velocity joint="j" kv="2" gear="-4" ctrlrange="-8 12"/>')
    found = groups(tmp_path, text)["joints"]
    assert found["command"] == "velocity"
    assert "kp" not in found
    assert found["kd"] == "32 N*m*s/rad"  # 16 x 2
    assert found["command_range"] == ["-3 rad/s", "2 rad/s"]  # [12, -8] / -4


def test_filter_and_delay(tmp_path: Path) -> None:
    """A servo's filter and delay are kept, the time constant as a cutoff."""
    text = mjcf(
        '<joint name="j"/>', '<position joint="j" kp="5" timeconst="0.05" delay="0.004" nsample="2"/>'
    )
    found = groups(tmp_path, text)["joints"]
    # 1 / (2 pi 0.05 s) = 3.18309886184 Hz
    assert found["command_filter"] == {"cutoff": "3.18309886184 Hz"}
    assert found["delay"] == "4 ms"


def test_constant_force(tmp_path: Path) -> None:
    """A servo's constant force is an encoder bias: -offset / kp."""
    text = mjcf('<joint name="j"/>', '<general joint="j" biastype="affine" gainprm="50" biasprm="5 -50 -2"/>')
    found = groups(tmp_path, text)["joints"]
    assert (found["kp"], found["kd"], found["encoder_bias"]) == ("50 N*m/rad", "2 N*m*s/rad", "-0.1 rad")


def test_actuator_damping_and_armature(tmp_path: Path) -> None:
    """Actuator-level damping and armature act on the joint, times gear squared."""
    text = mjcf(
        '<joint name="j" damping="0.5" armature="0.1"/>',
        '<motor joint="j" gear="2" damping="0.2" armature="0.03" forcerange="-1 1"/>',
    )
    found = groups(tmp_path, text)["joints"]
    assert found["friction"]["viscous"] == "1.3 N*m*s/rad"  # 0.5 + 4 x 0.2
    assert found["armature"] == "0.22 kg*m^2"  # 0.1 + 4 x 0.03


def dcmotor(dialect: DcMotorDialect, extra: str = "") -> str:
    """kp 80, kd 2, stall torque 45, no-load speed 30, limit 24, in the installed version's words.

    V = 24: K = V / 30 = 0.8, R = K V / 45 = 0.426667; in volts kp R/K = 42.666667, kd R/K - K = 0.266667.
    """
    gains = "80 0 2" if dialect is DcMotorDialect.TORQUE else "42.666666666666664 0 0.26666666666666661"
    word = "pos" if dialect is DcMotorDialect.TORQUE else "position"
    return (
        f'<dcmotor name="m" joint="j" nominal="24 45 30" saturation="24 0 0" input="{word}" '
        f'controller="{gains} 0 0 24" {extra}/>'
    )


def test_dcmotor(tmp_path: Path) -> None:
    """A dcmotor under a voltage limit gives its torque-speed line, and keeps it through a compile."""
    text = mjcf('<joint name="j"/>', dcmotor(installed_dialect().dcmotor))
    found = drafted(tmp_path, text)
    (motor,) = found.data["motors"].values()
    assert bare(motor) == {"side": "joint", "stall_torque": "45 N*m", "no_load_speed": "30 rad/s"}
    group = bare(found.data["actuators"]["joints"])
    assert (group["level"], group["kp"], group["kd"]) == ("dc_motor", "80 N*m/rad", "2 N*m*s/rad")
    assert group["effort_limit"] == "24 N*m"
    before, after = recompiled(tmp_path, text)
    assert before.actuators[0].line == pytest.approx((45, 30), rel=TOLERANCE)
    assert after.actuators[0].line == pytest.approx((45, 30), rel=TOLERANCE)
    assert effective(after)["j"] == pytest.approx(effective(before)["j"], rel=TOLERANCE)


def test_dcmotor_gear(tmp_path: Path) -> None:
    """Behind a gear of 3 the stall torque is three times as high, the no-load speed a third."""
    text = mjcf('<joint name="j"/>', dcmotor(installed_dialect().dcmotor, 'gear="3"'))
    (motor,) = drafted(tmp_path, text).data["motors"].values()
    assert bare(motor)["stall_torque"] == "135 N*m"
    assert bare(motor)["no_load_speed"] == "10 rad/s"


# --- what a spec cannot say -----------------------------------------------------------------------


@pytest.mark.parametrize(
    "joint, actuators, why",
    [
        ("", "", "no actuator"),
        ("", '<position joint="j" kp="-50"/>', "a position servo with gain -50 and stiffness -50"),
        (
            "",
            '<general joint="j" biastype="affine" gainprm="49" biasprm="0 -50 -2"/>',
            "a position servo with gain 49 and stiffness 50",
        ),
        (
            "",
            '<general joint="j" biastype="affine" biasprm="3"/>',
            "a motor with a velocity term or a constant force",
        ),
        ("", '<intvelocity joint="j" kp="3" actrange="-1 1"/>', "an actuator of another kind (intvelocity)"),
        ("", '<damper joint="j" kv="3" ctrlrange="0 1"/>', "an actuator of another kind (damper)"),
        ("", '<motor joint="j"/><motor name="b" joint="j"/>', "2 actuators (motor, motor)"),
        (
            "",
            '<position joint="j" forcerange="-1 1"/><velocity name="b" joint="j"/>',
            "2 actuators, each with its own clamp, filter or delay",
        ),
        ("", '<motor joint="j" gear="0"/>', "an actuator with gear 0"),
        (
            "",
            '<dcmotor joint="j" motorconst="0.5" resistance="1"/>',
            "a dcmotor that is more than a PD within its voltage, or is commanded in volts",
        ),
        ('damping="-0.5"', '<motor joint="j"/>', "its damping is -0.5"),
    ],
    ids=[
        "passive",
        "kp sign",
        "gain not kp",
        "offset",
        "intvelocity",
        "damper",
        "two",
        "clamps",
        "gear",
        "volts",
        "negative",
    ],
)
def test_left_alone(tmp_path: Path, joint: str, actuators: str, why: str) -> None:
    """A joint that the law cannot describe is unmanaged, with the reason beside it."""
    text = mjcf(f'<joint name="j" {joint}/>\n<joint name="other"/>', f'{actuators}<motor joint="other"/>')
    found = drafted(tmp_path, text)
    assert [(item.joint, item.why) for item in found.combined.left_alone] == [("j", why)]
    assert found.data["robot"]["unmanaged"] == ["j"]
    assert f'- "j"    # {why}' in found.draft.text
    assert list(found.data["actuators"]) == ["other"]


def test_tendon(tmp_path: Path) -> None:
    """Joints that a tendon pulls are left alone; the reason names the tendon."""
    text = mjcf(
        '<joint name="a"/>\n<joint name="b"/>\n<joint name="c"/>',
        '<position tendon="pull" kp="3"/><motor joint="a"/>',
        tail='<tendon><fixed name="pull"><joint joint="b" coef="1"/><joint joint="c" coef="2"/></fixed></tendon>',
    )
    found = drafted(tmp_path, text)
    assert found.data["robot"]["unmanaged"] == ["[bc]"]
    assert {item.why for item in found.combined.left_alone} == {"driven through the tendon 'pull'"}


def test_pair_becomes_one(tmp_path: Path) -> None:
    """A position and a velocity actuator on one joint are one servo, and the draft says so."""
    text = mjcf('<joint name="j"/>', '<position joint="j" kp="30"/><velocity joint="j" kv="4"/>')
    found = drafted(tmp_path, text)
    group = bare(found.data["actuators"]["joints"])
    assert (group["command"], group["kp"], group["kd"]) == ("position", "30 N*m/rad", "4 N*m*s/rad")
    assert "# 2 actuators in the file (position, velocity) become one" in found.draft.text


def test_asymmetric_limit(tmp_path: Path) -> None:
    """A limit that is not symmetric is written as its larger side, with a remark."""
    text = mjcf('<joint name="j"/>', '<motor joint="j" forcerange="-10 20"/>')
    found = drafted(tmp_path, text)
    assert bare(found.data["actuators"]["joints"]["effort_limit"]) == "20 N*m"
    assert "not symmetric (-10 to 20), a spec has one number: the larger" in found.draft.text


@pytest.mark.parametrize(
    "joints, actuators, code",
    [
        ('<joint type="ball" name="b"/>', "", "DRF001"),
        ("<joint/>", "", "DRF001"),
        ('<joint name="j"/>', '<intvelocity joint="j" kp="3" actrange="-1 1"/>', "DRF002"),
        (f'<joint name="{"x" * 300}"/>\n<joint name="k" type="slide"/>', "", "DRF003"),
    ],
    ids=["ball", "no name", "nothing to say", "long name"],
)
def test_nothing_to_draft(tmp_path: Path, joints: str, actuators: str, code: str) -> None:
    """A file without a joint for a group is refused, with the reason and help."""
    with pytest.raises(RobotError) as caught:
        drafted(tmp_path, mjcf(joints, actuators))
    (item,) = caught.value.diagnostics
    assert item.code == code
    assert item.help
    assert item.span is not None and item.span.path.endswith("robot.xml")


def test_every_reason_with_its_joints(tmp_path: Path) -> None:
    """Tendons and servos of many names and gains are two reasons, however many joints have them."""
    joints = "".join(f'<joint name="{name}"/>' for name in ("a", "b", "c", "d"))
    actuators = (
        '<general joint="a" biastype="affine" gainprm="2" biasprm="0 -3"/>'
        '<general joint="b" biastype="affine" gainprm="5" biasprm="0 -3"/>'
        '<motor tendon="t"/><motor tendon="u"/>'
    )
    tendons = (
        '<tendon><fixed name="t"><joint joint="c" coef="1"/></fixed>'
        '<fixed name="u"><joint joint="d" coef="1"/></fixed></tendon>'
    )
    with pytest.raises(RobotError) as caught:
        drafted(tmp_path, mjcf(joints, actuators).replace("<actuator>", f"{tendons}<actuator>"))
    (item,) = caught.value.diagnostics
    assert item.message == (
        "none of its 4 joints can go into a group: position servos whose gain is not their stiffness: a, b; "
        "driven through tendons: c, d"
    )


# --- bare models ----------------------------------------------------------------------------------


def test_bare_mjcf(tmp_path: Path) -> None:
    """A model without actuators gives position groups whose gains are unknown."""
    found = drafted(tmp_path, mjcf('<joint name="j" damping="0.5" actuatorfrcrange="-7 7"/>'))
    group = found.data["actuators"]["joints"]
    assert (group["command"], group["kp"], group["kd"]) == ("position", "unknown", "unknown")
    assert bare(group["effort_limit"]) == "7 N*m"
    assert "\n  # Joint damping, or the drive's kd? j: no kd, and joint damping" in found.draft.text


URDF = """<robot name="arm">
  <link name="base"/>
  <link name="one">MASS</link>
  <link name="two">MASS</link>
  <link name="three">MASS</link>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="one"/>
    <limit lower="-1" upper="1" effort="40" velocity="3.5"/><dynamics damping="0.2" friction="0"/></joint>
  <joint name="elbow" type="continuous"><parent link="one"/><child link="two"/></joint>
  <joint name="hook" type="revolute"><parent link="two"/><child link="three"/>
    <limit lower="0" upper="1" effort="1" velocity="1"/><mimic joint="elbow"/></joint>
</robot>""".replace(
    "MASS",
    '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>',
)


def test_urdf(tmp_path: Path) -> None:
    """A URDF states limits and friction; gains and armature are unknown; a mimic joint is left alone."""
    found = drafted(tmp_path, URDF, "arm.urdf")
    assert found.data["robot"] == {"name": "arm", "model": "arm.urdf", "unmanaged": ["hook"]}
    assert bare(found.data["actuators"]) == {
        "shoulder": {
            "joints": ["shoulder"],
            "level": "ideal_pd",
            "command": "position",
            "kp": "unknown",
            "kd": "unknown",
            "effort_limit": "40 N*m",
            "velocity_limit": "3.5 rad/s",
            "armature": "unknown",
            "friction": {"coulomb": "0 N*m", "viscous": "0.2 N*m*s/rad"},
        },
        "elbow": {
            "joints": ["elbow"],
            "level": "ideal_pd",
            "command": "position",
            "kp": "unknown",
            "kd": "unknown",
            "effort_limit": "unknown",
            "velocity_limit": "unknown",
            "armature": "unknown",
            "friction": {"coulomb": "unknown", "viscous": "unknown"},
        },
    }
    assert found.draft.unknown["kp", ""] == ("shoulder", "elbow")
    assert "timing" not in found.data


# --- remarks --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "damping, kp, expected", [(0.5, 100, True), (0.1, 100, True), (0.05, 100, False)], ids=str
)
def test_damping_meant_as_kd(tmp_path: Path, damping: float, kp: float, expected: bool) -> None:
    """A servo without kv on a damped joint: kd is unknown, and large damping is suspected to be it."""
    text = mjcf(f'<joint name="j" damping="{damping}"/>', f'<position joint="j" kp="{kp}"/>')
    found = drafted(tmp_path, text)
    assert found.data["actuators"]["joints"]["kd"] == "unknown"
    assert "kd: unknown    # the file's servo has no kv: MuJoCo takes 0" in found.draft.text
    # 1 ms is the bound: 0.1 / 100 reaches it, 0.05 / 100 does not.
    assert ("Joint damping, or the drive's kd?" in found.draft.text) is expected


TWO = mjcf(
    '<joint name="left_knee" damping="2"/>\n<joint name="elbow" damping="3"/>\n<joint name="wrist" damping="0.5"/>',
    '<position joint="left_knee" kp="100"/><position joint="elbow" kp="50"/><position joint="wrist" kp="9" kv="1"/>',
)


@pytest.mark.parametrize("answer", [None, "as-kd", "as-friction"])
def test_damping_is_settled_once(tmp_path: Path, answer: str | None) -> None:
    """One question for all groups, or one answer; a servo with a kv has its kd already."""
    found = drafted(tmp_path, TWO, damping=answer)
    # The servos in the way of groups: 2 and 3 N*m*s/rad are asked about, the wrist's 0.5 is not.
    assert found.draft.text.count("or the drive's kd?") == (1 if answer is None else 0)
    gains = {
        name: (group["kd"], group["friction"]["viscous"])
        for name, group in bare(found.data["actuators"]).items()
    }
    if answer == "as-kd":
        assert gains == {
            "knee": ("2 N*m*s/rad", "0 N*m*s/rad"),
            "elbow": ("3 N*m*s/rad", "0 N*m*s/rad"),
            "wrist": ("1 N*m*s/rad", "0.5 N*m*s/rad"),
        }
    else:
        # Friction is no kd: MuJoCo's 0 is the servo's.
        kd = "unknown" if answer is None else "0 N*m*s/rad"
        assert gains == {
            "knee": (kd, "2 N*m*s/rad"),
            "elbow": (kd, "3 N*m*s/rad"),
            "wrist": ("1 N*m*s/rad", "0.5 N*m*s/rad"),
        }
        told = "left_knee, elbow: joint damping is friction, and kd is 0 (--damping as-friction)"
        assert (told in found.draft.inferred) is (answer == "as-friction")


@pytest.mark.parametrize(
    "answer, kd, viscous", [(None, "unknown", "2 N*s/m"), ("as-kd", "2 N*s/m", "0 N*s/m")], ids=str
)
def test_damping_of_a_stiff_servo(tmp_path: Path, answer: str | None, kd: str, viscous: str) -> None:
    """2 N*s/m / 5000 N/m is too little to be asked about, and kd all the same for who says so, which is told."""
    (tmp_path / "gripper.xml").write_text(
        f'<mujoco><worldbody><body name="palm">{INERTIAL}<joint name="finger" type="slide" damping="2"/></body>'
        "</worldbody></mujoco>",
        encoding="utf-8",
    )
    text = (
        '<mujoco><asset><model name="g" file="gripper.xml"/></asset><worldbody><frame>'
        '<attach model="g" body="palm" prefix="g_"/></frame></worldbody>'
        '<actuator><position joint="g_finger" kp="5000"/></actuator></mujoco>'
    )
    found = drafted(tmp_path, text, damping=answer)
    group = bare(found.data["actuators"]["g_finger"])
    assert (group["kd"], group["friction"]["viscous"]) == (kd, viscous)
    assert found.draft.inferred == (("g_finger: joint damping is kd (--damping as-kd)",) if answer else ())


def test_friction_says_nothing_of_a_controllers_kd(tmp_path: Path) -> None:
    """A URDF has no gains: that its damping is friction leaves its controller's kd unknown."""
    found = drafted(tmp_path, URDF, "arm.urdf", damping="as-friction")
    assert bare(found.data["actuators"]["shoulder"]["kd"]) == "unknown"
    assert "shoulder: joint damping is friction (--damping as-friction)" in found.draft.inferred


def test_no_damping_to_settle(tmp_path: Path) -> None:
    """An answer to what no joint asks is told, and changes nothing."""
    text = mjcf('<joint name="knee" damping="2"/>', '<position joint="knee" kp="100" kv="3"/>')
    found = drafted(tmp_path, text, damping="as-kd")
    assert bare(found.data["actuators"]["knee"]["kd"]) == "3 N*m*s/rad"
    assert found.draft.inferred == ("no drive without kd has joint damping (--damping as-kd)",)


def test_completion_is_explained(tmp_path: Path) -> None:
    """The schema of the first line is not there by itself: the head has the command that writes it."""
    first, *head = drafted(tmp_path, mjcf('<joint name="j"/>')).draft.text.splitlines()
    assert first == "# yaml-language-server: $schema=actspec-v1.schema.json"
    assert (
        "# For completion in an editor: `actspec schema > actspec-v1.schema.json` beside this file." in head
    )


def test_lines_of_the_file(tmp_path: Path) -> None:
    """Each group names the lines that its numbers stand in, of a drive without any those of the drive."""
    text = mjcf('<joint name="a"/>\n<joint name="b"/>', '<motor joint="b"/>\n<motor joint="a"/>')
    lines = text.split("\n")
    # Counted from 1: the bodies open in lines 1 and 3, the actuators follow the last body's end.
    assert [n for n, line in enumerate(lines, 1) if line.startswith(("<joint", "<motor"))] == [2, 4, 6, 7]
    assert "    # robot.xml:6, 7\n" in drafted(tmp_path, text).draft.text


@pytest.mark.parametrize(
    "option, expected",
    [
        ('<option timestep="0.002"/>', "2 ms"),
        ('<option timestep="0.0012345"/>', "1.2345 ms"),
        ('<option timestep="0.00069999999999999999"/>', "0.7 ms"),
        ('<option timestep="0.0012345678901234567"/>', "0.0012345678901234567 s"),
        ("<option/>", None),
    ],
    ids=["2 ms", "digits", "0.7 ms", "more digits", "none"],
)
def test_timestep(tmp_path: Path, option: str, expected: str | None) -> None:
    """The file's step is written where the file states one, and comes back as the same number."""
    text = mjcf('<joint name="j"/>', '<motor joint="j"/>', option)
    found = drafted(tmp_path, text)
    if expected is None:
        assert "timing" not in found.data
        assert "no file states a time step: MuJoCo takes 2 ms" in found.draft.text
        return
    assert bare(found.data["timing"]) == {"physics_dt": expected}
    spec = validate(document_from_text(found.draft.text))
    assert spec.model.timing.physics_dt is not None
    assert spec.model.timing.physics_dt.value == load_robot(str(tmp_path / "robot.xml")).timestep


def test_command_ranges(tmp_path: Path) -> None:
    """A clamp that is the joint's range is the word; other clamps that differ are overrides."""
    joints = "\n".join(f'<joint name="{name}" range="-1 1"/>' for name in "abc")
    servos = "".join(f'<position joint="{name}" ctrlrange="-1 1"/>' for name in "abc")
    radians = mjcf(joints, servos, '<compiler angle="radian"/>')
    assert groups(tmp_path, radians)["joints"]["command_range"] == "joint"
    text = radians.replace('joint="b" ctrlrange="-1 1"', 'joint="b" ctrlrange="-0.5 2"')
    text = text.replace('joint="c" ctrlrange="-1 1"', 'joint="c"')
    group = groups(tmp_path, text)["joints"]
    assert group["joints"] == [".*"]
    assert "command_range" not in group
    assert group["overrides"] == {
        "a": {"command_range": "joint"},
        "b": {"command_range": ["-0.5 rad", "2 rad"]},
    }


def test_groups_by_distinct_numbers(tmp_path: Path) -> None:
    """Joints with the same numbers share a group; one number apart within a limb makes an override."""
    names = [f"{side}_{part}_joint" for side in ("FL", "FR") for part in ("hip", "thigh", "calf")]
    joints = "\n".join(
        f'<joint name="{name}" armature="{0.02 if "calf" in name else 0.01}"/>' for name in names
    )
    actuators = "".join(f'<position joint="{name}" kp="25" kv="1"/>' for name in names)
    found = drafted(tmp_path, mjcf(joints, actuators))
    assert {key: group["joints"] for key, group in found.data["actuators"].items()} == {
        "legs": [".*"],
    }
    assert bare(found.data["actuators"]["legs"]["overrides"]) == {
        ".*_calf_joint": {"armature": "0.02 kg*m^2"}
    }
    assert dict(found.draft.groups) == {"legs": 6}


# --- nothing changes ------------------------------------------------------------------------------

ALL_KINDS = mjcf(
    """<joint name="a" damping="0.3" armature="0.02" frictionloss="0.1" range="-1 1"/>
    <joint name="b" type="slide" damping="0.1" armature="0.5"/>
    <joint name="c" actuatorfrcrange="-3 3" springdamper="0.5 0.7"/>
    <joint name="d" damping="0.25"/>
    <joint name="e"/>
    <joint name="f" frictionloss="0.05"/>
    <joint name="g" damping="1.5"/>""",
    """<position name="pa" joint="a" kp="10" kv="0.5" gear="3" forcerange="-4 4" ctrlrange="-2 2"/>
    <motor name="mb" joint="b" gear="-5" ctrlrange="-2 2" damping="0.02" armature="0.01"/>
    <velocity name="vc" joint="c" kv="2"/>
    <position name="pd" joint="d" kp="7.7" timeconst="0.02"/>
    <intvelocity name="ie" joint="e" kp="3" actrange="-1 1"/>
    <position name="pf" joint="f" kp="30"/>
    <velocity name="vf" joint="f" kv="4"/>
    <general name="bg" joint="g" biastype="affine" gainprm="50" biasprm="5 -50 -2" forcerange="-9 9"/>""",
    '<option timestep="0.001"/>',
)


def test_compiling_a_draft_changes_nothing(tmp_path: Path) -> None:
    """kp, kd, passive values, armature and limit of every joint are the same after a compile of the draft."""
    before, after = recompiled(tmp_path, ALL_KINDS)
    assert after.timestep == before.timestep
    old, new = effective(before), effective(after)
    assert list(new) == list(old)
    for name, numbers in old.items():
        assert new[name] == pytest.approx(numbers, rel=TOLERANCE), name
    by_joint = {a.target: a for a in after.actuators}
    assert by_joint["d"].time_constant == pytest.approx(0.02, rel=TOLERANCE)
    assert by_joint["g"].offset == pytest.approx(5, rel=TOLERANCE)
    # The clamp of +-2 in units of the actuator is +-2/3 at the joint, behind a gear of 3.
    assert by_joint["a"].control_range == pytest.approx((-2 / 3, 2 / 3), rel=TOLERANCE)
    assert by_joint["e"].control == "intvelocity"


def nasty_robot(names: list[str], actuated: bool) -> str:
    """A robot whose joints, tendon, model and actuators have these names."""
    joints = "\n".join(f"<joint name={attribute(name)}/>" for name in names)
    if not actuated:
        return mjcf(joints).replace('model="robot"', f"model={attribute(names[0])}")
    actuators = "".join(f"<motor name={attribute(name)} joint={attribute(name)}/>" for name in names[1:])
    tendon = f"<tendon><fixed name={attribute(names[0])}><joint joint={attribute(names[0])} coef='1'/></fixed></tendon>"
    pull = f"<motor tendon={attribute(names[0])}/>"
    return mjcf(joints, actuators + pull, tail=tendon).replace(
        'model="robot"', f"model={attribute(names[0])}"
    )


def attribute(name: str) -> str:
    """A name as an XML attribute that comes back the same."""
    return quoteattr(name, {"\n": "&#10;", "\t": "&#9;", "\r": "&#13;"})


@pytest.mark.parametrize("actuated", [True, False], ids=["motors", "bare"])
def test_nasty_names(tmp_path: Path, actuated: bool) -> None:
    """With every nasty name in one robot the draft is valid, and fits the robot joint by joint."""
    found = drafted(tmp_path, nasty_robot(NASTY, actuated))
    path = tmp_path / "spec.yaml"
    path.write_text(found.draft.text, encoding="utf-8")
    actuators = api.resolve(path)
    managed = {joint.joint for joint in actuators.joints}
    assert managed == (set(NASTY[1:]) if actuated else set(NASTY))
    assert set(actuators.unmanaged) == set(NASTY) - managed


@pytest.mark.slow
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    names=st.lists(
        st.text(
            st.characters(exclude_categories=("Cs", "Cc", "Cn")) | st.sampled_from("\n\t\"'\\:#{}[]*"),
            min_size=1,
            max_size=20,
        ),
        min_size=2,
        max_size=6,
        unique=True,
    ),
    actuated=st.booleans(),
)
def test_any_names(tmp_path: Path, names: list[str], actuated: bool) -> None:
    """Whatever a robot file calls its joints, the draft is valid and binds each of them."""
    try:
        found = drafted(tmp_path, nasty_robot(names, actuated))
    except ActspecError:
        # MuJoCo's own limits on names; nothing is drafted then.
        return
    path = tmp_path / "spec.yaml"
    path.write_text(found.draft.text, encoding="utf-8")
    actuators = api.resolve(path)
    assert {joint.joint for joint in actuators.joints} | set(actuators.unmanaged) == set(names)


def test_starting_spec_is_valid() -> None:
    """The starting spec passes validation, and all of its lines of settings are explained."""
    text = starting_spec()
    spec = validate(document_from_text(text))
    assert spec.model.robot.model == "my_robot.xml"
    assert text.startswith("# yaml-language-server: $schema=")
    assert max(map(len, text.splitlines())) <= 130
    assert len(text.splitlines()) <= 90
    assert "unknown" in text
    unexplained = [
        line
        for line in text.splitlines()
        if ":" in line
        and "#" not in line
        and not line.strip().startswith(("title:", "url:", "page:", "accessed:"))
    ]
    # Only openings of sections and names, which the lines around them explain.
    assert unexplained == [
        "robot:",
        "timing:",
        "  datasheet:",
        "  my_motor:",
        "  legs:",
        '      ".*_calf_joint": {effort_limit: 30 N*m}',
        "      kp: {scale: [0.8, 1.2], when: reset, per: joint}",
    ]


def test_drafted_name(tmp_path: Path) -> None:
    """The robot's name is its model's as a folder may be called, else that of its file."""
    for model, file, expected in (
        ("a1 scene/..", "x.xml", "a1_scene"),
        ("", "my robot.xml", "my_robot"),
        ("関節", "x.xml", "x"),
        ("関節", "関.xml", "robot"),
    ):
        text = mjcf('<joint name="j"/>').replace('model="robot"', f'model="{model}"')
        folder = tmp_path / expected
        os.makedirs(folder, exist_ok=True)
        assert drafted(folder, text, file).data["robot"]["name"] == expected
