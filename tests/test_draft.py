"""Drafting a spec from a robot file: groups, figures, patterns, names, and text that is always valid."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from actspec import api
from actspec.diagnostics import RobotError
from actspec.draft import Draft, draft_spec, starting_spec
from actspec.draft.facts import figure
from actspec.draft.names import group_name, joint_patterns
from actspec.draft.text import comment, scalar
from actspec.patterns import MAX_PATTERN, compile_pattern, covering_pattern
from actspec.resolution.model_values import actuators_of, effort_bound
from actspec.robot.load import load_robot
from actspec.robot.view import RobotView
from actspec.spec.document import document_from_text
from actspec.spec.validate import validate
from actspec.targets.mujoco.emit import installed_dialect
from actspec.targets.versions import DcMotorDialect

INERTIAL = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
TOLERANCE = 1e-9
"""Relative; computed numbers are written with 12 digits."""


def mjcf(joints: str, actuators: str = "", head: str = "", tail: str = "") -> str:
    """A chain of bodies, one for each line of `joints`."""
    lines = [line.strip() for line in joints.strip().split("\n")]
    body = "".join(f"<body>\n{line}\n{INERTIAL}" for line in lines) + "</body>" * len(lines)
    section = f"<actuator>\n{actuators}\n</actuator>" if actuators else ""
    return f'<mujoco model="robot">{head}<worldbody>{body}</worldbody>{section}{tail}</mujoco>'


def read(folder: Path, text: str, name: str = "robot.xml") -> RobotView:
    """Write a robot file and read it."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return load_robot(str(path))


def drafted(folder: Path, text: str, name: str = "robot.xml") -> tuple[Draft, dict[str, Any]]:
    """The draft of a robot file and what its YAML holds; validity is checked on the way."""
    draft = draft_spec(read(folder, text, name), name)
    return draft, validate(document_from_text(draft.text)).document.data


def groups(folder: Path, text: str, name: str = "robot.xml") -> dict[str, Any]:
    """The groups of a robot file's draft, without `value` and `source` around the numbers."""
    return {key: bare(group) for key, group in drafted(folder, text, name)[1]["actuators"].items()}


def bare(node: Any) -> Any:
    """Numbers of the file without their source, which must be the file."""
    if isinstance(node, dict):
        if "value" in node:
            assert node == {"value": node["value"], "source": "model_file"}
            return node["value"]
        return {key: bare(value) for key, value in node.items()}
    return [bare(item) for item in node] if isinstance(node, list) else node


def effective(robot: RobotView) -> dict[str, tuple[float, ...]]:
    """What acts on each joint: kp, kd, passive damping, dry friction, armature, limit."""
    found = {}
    for joint in robot.joints:
        own = actuators_of(robot, joint.name)
        found[joint.name] = (
            sum(a.kp for a in own),
            sum(a.kd for a in own),
            joint.damping + sum(a.gear**2 * a.damping[0] for a in own),
            joint.frictionloss,
            joint.armature + sum(a.gear**2 * a.armature for a in own),
            effort_bound(joint, own) or 0.0,
        )
    return found


def recompiled(folder: Path, text: str) -> tuple[RobotView, RobotView]:
    """A robot before and after its draft is compiled into it."""
    before = read(folder, text)
    spec = folder / "spec.yaml"
    spec.write_text(draft_spec(before, "robot.xml").text, encoding="utf-8")
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
    draft, data = drafted(tmp_path, text.replace("</actuator>", '<motor joint="knee"/></actuator>'))
    hip, knee = data["actuators"]["hip"], data["actuators"]["knee"]
    assert bare(hip["armature"]) == "0 kg*m^2"
    assert knee["armature"] == "unknown"
    assert knee["friction"] == {"coulomb": "unknown", "viscous": "unknown"}
    assert knee["effort_limit"] == "unknown"
    assert "velocity_limit" not in knee
    assert draft.unknown["armature"] == ("knee",)
    assert draft.unknown["effort_limit"] == ("hip", "knee")


def test_stated_by_class(tmp_path: Path) -> None:
    """What a default class states is stated."""
    head = '<default><joint armature="0.01" damping="0"/></default>'
    found = groups(tmp_path, mjcf('<joint name="j"/>', '<motor joint="j"/>', head))["joints"]
    assert found["armature"] == "0.01 kg*m^2"
    assert found["friction"] == {"coulomb": "unknown", "viscous": "0 N*m*s/rad"}


def test_motor(tmp_path: Path) -> None:
    """A torque motor has neither kp nor kd; its control range times gear and gain is its limit."""
    text = mjcf('<joint name="j"/>', '<general joint="j" gainprm="2" gear="5" ctrlrange="-1.5 1.5"/>')
    draft, data = drafted(tmp_path, text)
    group = data["actuators"]["joints"]
    assert group["command"] == "effort"
    assert "kp" not in group and "kd" not in group and "command_range" not in group
    assert bare(group["effort_limit"]) == "15 N*m"  # 5 x 2 x 1.5
    assert "gear and gain of 10 go: after a compile the control is in N*m at the joint" in draft.text


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
    assert found["delay"] == "0.004 s"


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
    data = drafted(tmp_path, text)[1]
    (motor,) = data["motors"].values()
    assert bare(motor) == {"side": "joint", "stall_torque": "45 N*m", "no_load_speed": "30 rad/s"}
    group = bare(data["actuators"]["joints"])
    assert (group["level"], group["kp"], group["kd"]) == ("dc_motor", "80 N*m/rad", "2 N*m*s/rad")
    assert group["effort_limit"] == "24 N*m"
    before, after = recompiled(tmp_path, text)
    assert before.actuators[0].line == pytest.approx((45, 30), rel=TOLERANCE)
    assert after.actuators[0].line == pytest.approx((45, 30), rel=TOLERANCE)
    assert effective(after)["j"] == pytest.approx(effective(before)["j"], rel=TOLERANCE)


def test_dcmotor_gear(tmp_path: Path) -> None:
    """Behind a gear of 3 the stall torque is three times as high, the no-load speed a third."""
    text = mjcf('<joint name="j"/>', dcmotor(installed_dialect().dcmotor, 'gear="3"'))
    (motor,) = drafted(tmp_path, text)[1]["motors"].values()
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
    draft, data = drafted(tmp_path, text)
    assert [(item.joint, item.why) for item in draft.left_alone] == [("j", why)]
    assert data["robot"]["unmanaged"] == ["j"]
    assert f'- "j"    # {why}' in draft.text
    assert list(data["actuators"]) == ["other"]


def test_tendon(tmp_path: Path) -> None:
    """Joints that a tendon pulls are left alone; the reason names the tendon."""
    text = mjcf(
        '<joint name="a"/>\n<joint name="b"/>\n<joint name="c"/>',
        '<position tendon="pull" kp="3"/><motor joint="a"/>',
        tail='<tendon><fixed name="pull"><joint joint="b" coef="1"/><joint joint="c" coef="2"/></fixed></tendon>',
    )
    draft, data = drafted(tmp_path, text)
    assert data["robot"]["unmanaged"] == ["[bc]"]
    assert {item.why for item in draft.left_alone} == {"driven through the tendon 'pull'"}


def test_pair_becomes_one(tmp_path: Path) -> None:
    """A position and a velocity actuator on one joint are one servo, and the draft says so."""
    text = mjcf('<joint name="j"/>', '<position joint="j" kp="30"/><velocity joint="j" kv="4"/>')
    draft, data = drafted(tmp_path, text)
    group = bare(data["actuators"]["joints"])
    assert (group["command"], group["kp"], group["kd"]) == ("position", "30 N*m/rad", "4 N*m*s/rad")
    assert "# 2 actuators in the file (position, velocity) become one" in draft.text


def test_asymmetric_limit(tmp_path: Path) -> None:
    """A limit that is not symmetric is written as its larger side, with a remark."""
    text = mjcf('<joint name="j"/>', '<motor joint="j" forcerange="-10 20"/>')
    draft, data = drafted(tmp_path, text)
    assert bare(data["actuators"]["joints"]["effort_limit"]) == "20 N*m"
    assert "not symmetric (-10 to 20), a spec has one number: the larger" in draft.text


@pytest.mark.parametrize(
    "joints, actuators, code",
    [
        ('<joint type="ball" name="b"/>', "", "DRF001"),
        ("<joint/>", "", "DRF001"),
        ('<joint name="j"/>', '<intvelocity joint="j" kp="3" actrange="-1 1"/>', "DRF002"),
        (f'<joint name="{"x" * 300}"/>\n<joint name="k" armature="1"/>', "", "DRF003"),
    ],
    ids=["ball", "no name", "nothing to say", "long name"],
)
def test_nothing_to_draft(tmp_path: Path, joints: str, actuators: str, code: str) -> None:
    """A file without a joint for a group is refused, with the reason and help."""
    with pytest.raises(RobotError) as caught:
        draft_spec(read(tmp_path, mjcf(joints, actuators)), "robot.xml")
    (item,) = caught.value.diagnostics
    assert item.code == code
    assert item.help
    assert item.span is not None and item.span.path.endswith("robot.xml")


# --- bare models ----------------------------------------------------------------------------------


def test_bare_mjcf(tmp_path: Path) -> None:
    """A model without actuators gives position groups whose gains are unknown."""
    draft, data = drafted(tmp_path, mjcf('<joint name="j" damping="0.5" actuatorfrcrange="-7 7"/>'))
    group = data["actuators"]["joints"]
    assert (group["command"], group["kp"], group["kd"]) == ("position", "unknown", "unknown")
    assert bare(group["effort_limit"]) == "7 N*m"
    assert "    # the bearing's, or the drive's kd in disguise? Then move it to kd, and put 0" in draft.text


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
    draft, data = drafted(tmp_path, URDF, "arm.urdf")
    assert data["robot"] == {"name": "arm", "model": "arm.urdf", "unmanaged": ["hook"]}
    assert bare(data["actuators"]) == {
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
    assert draft.unknown["kp"] == ("shoulder", "elbow")
    assert "timing" not in data


# --- remarks --------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "damping, kp, expected", [(0.5, 100, True), (0.1, 100, True), (0.05, 100, False)], ids=str
)
def test_damping_meant_as_kd(tmp_path: Path, damping: float, kp: float, expected: bool) -> None:
    """A servo without kv on a damped joint: kd is unknown, and large damping is suspected to be it."""
    text = mjcf(f'<joint name="j" damping="{damping}"/>', f'<position joint="j" kp="{kp}"/>')
    draft, data = drafted(tmp_path, text)
    assert data["actuators"]["joints"]["kd"] == "unknown"
    assert "kd: unknown    # the file's servo has no kv: MuJoCo takes 0" in draft.text
    # 1 ms is the bound: 0.1 / 100 reaches it, 0.05 / 100 does not.
    assert ("perhaps the drive's kd" in draft.text) is expected
    assert ("perhaps its joint damping is meant for it" in draft.text) is expected


def test_lines_of_the_file(tmp_path: Path) -> None:
    """Each group names the lines of its joints and actuators."""
    text = mjcf('<joint name="a"/>\n<joint name="b"/>', '<motor joint="b"/>\n<motor joint="a"/>')
    lines = text.split("\n")
    # Counted from 1: the bodies open in lines 1 and 3, the actuators follow the last body's end.
    assert [n for n, line in enumerate(lines, 1) if line.startswith(("<joint", "<motor"))] == [2, 4, 6, 7]
    assert "    # robot.xml:2, 4 (joints), 6, 7 (actuators)\n" in drafted(tmp_path, text)[0].text


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
    robot = read(tmp_path, text)
    draft, data = drafted(tmp_path, text)
    if expected is None:
        assert "timing" not in data
        assert "the file states no time step: MuJoCo takes 2 ms" in draft.text
        return
    assert bare(data["timing"]) == {"physics_dt": expected}
    spec = validate(document_from_text(draft.text))
    assert spec.model.timing.physics_dt is not None
    assert spec.model.timing.physics_dt.value == robot.timestep


def test_command_ranges(tmp_path: Path) -> None:
    """A clamp that is the joint's range is the word; other clamps that differ are overrides."""
    joints = "\n".join(f'<joint name="{name}" range="-1 1"/>' for name in "abc")
    servos = "".join(f'<position joint="{name}" ctrlrange="-1 1"/>' for name in "abc")
    radians = mjcf(joints, servos, '<compiler angle="radian"/>')
    assert groups(tmp_path, radians)["a_b_c"]["command_range"] == "joint"
    text = radians.replace('joint="b" ctrlrange="-1 1"', 'joint="b" ctrlrange="-0.5 2"')
    text = text.replace('joint="c" ctrlrange="-1 1"', 'joint="c"')
    group = groups(tmp_path, text)["a_b_c"]
    assert group["joints"] == [".*"]
    assert "command_range" not in group
    assert group["overrides"] == {
        "a": {"command_range": "joint"},
        "b": {"command_range": ["-0.5 rad", "2 rad"]},
    }


def test_groups_by_distinct_numbers(tmp_path: Path) -> None:
    """Joints with the same numbers share a group; one number apart makes another."""
    names = [f"{side}_{part}_joint" for side in ("FL", "FR") for part in ("hip", "thigh", "calf")]
    joints = "\n".join(
        f'<joint name="{name}" armature="{0.02 if "calf" in name else 0.01}"/>' for name in names
    )
    actuators = "".join(f'<position joint="{name}" kp="25" kv="1"/>' for name in names)
    draft, data = drafted(tmp_path, mjcf(joints, actuators))
    assert {key: group["joints"] for key, group in data["actuators"].items()} == {
        "legs": [".*_hip_joint", ".*_thigh_joint"],
        "calf": [".*_calf_joint"],
    }
    assert dict(draft.groups) == {"legs": 4, "calf": 2}


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


# --- patterns and names ---------------------------------------------------------------------------

QUADRUPED = [f"{leg}_{part}_joint" for leg in ("FL", "FR", "RL", "RR") for part in ("hip", "thigh", "calf")]
ARM = [f"panda_joint{n}" for n in range(1, 8)]
HUMANOID = [
    f"{side}_{part}_joint"
    for side in ("left", "right")
    for part in ("hip_pitch", "hip_roll", "knee", "shoulder_pitch", "shoulder_roll", "elbow")
] + ["waist_yaw_joint"]


@pytest.mark.parametrize(
    "wanted, names, expected",
    [
        (QUADRUPED, QUADRUPED, (".*",)),
        ([n for n in QUADRUPED if "calf" in n], QUADRUPED, (".*_calf_joint",)),
        ([n for n in QUADRUPED if "calf" not in n], QUADRUPED, (".*_hip_joint", ".*_thigh_joint")),
        ([n for n in QUADRUPED if n[0] == "F"], QUADRUPED, ("FL_.*", "FR_.*")),
        ([n for n in QUADRUPED if n[0] == "F" and "hip" in n], QUADRUPED, ("F[LR]_hip_joint",)),
        (ARM[:4], ARM, ("panda_joint[1-4]",)),
        ([ARM[0], ARM[2]], ARM, ("panda_joint[13]",)),
        ([n for n in HUMANOID if "shoulder" in n], HUMANOID, (".*_shoulder_.*",)),
        ([n for n in HUMANOID if "hip" in n or "waist" in n], HUMANOID, (".*_hip_.*", "waist_yaw_joint")),
        (["LeftHipYaw", "RightHipYaw"], ["LeftHipYaw", "RightHipYaw", "LeftKnee"], (".*Yaw",)),
        (["LeftYaw", "RightYaw"], ["LeftYaw", "RightYaw", "spare-Yaw"], ("LeftYaw", "RightYaw")),
        (["a.b", "a+b"], ["a.b", "a+b", "axb", "aab"], (r"a\.b", r"a\+b")),
        (["hip"], ["hip", "hips"], ("hip",)),
        (["a\n_x", "b\n_x"], ["a\n_x", "b\n_x"], ("a\n_x", "b\n_x")),
    ],
    ids=[
        "all", "suffix", "two suffixes", "prefixes", "class of letters", "class of digits", "gap in the class",
        "middle", "middle and a name", "camel case", "camel case that matches more", "metacharacters", "one", "newline",
    ],
)  # fmt: skip
def test_patterns(wanted: list[str], names: list[str], expected: tuple[str, ...]) -> None:
    """Patterns are few and short, and match the wanted joints only."""
    found = joint_patterns(wanted, names)
    assert found == expected
    assert covering_pattern(found, set(wanted), names)


NAMES = st.text(
    st.sampled_from("abLR12_-. /:éд") | st.characters(exclude_categories=("Cs",)), min_size=1, max_size=12
)


@given(st.lists(NAMES, min_size=1, max_size=12, unique=True), st.data())
def test_patterns_of_any_names(names: list[str], data: st.DataObject) -> None:
    """Whatever the names, the patterns are accepted, not longer than allowed, and match exactly."""
    wanted = data.draw(st.lists(st.sampled_from(names), min_size=1, unique=True))
    found = joint_patterns(wanted, names)
    assert covering_pattern(found, set(wanted), names)
    assert len(found) <= len(wanted)
    for pattern in found:
        assert len(pattern) <= MAX_PATTERN
        compile_pattern(pattern)


@pytest.mark.parametrize(
    "joints, expected",
    [
        (["FL_calf_joint", "RR_calf_joint"], "calf"),
        (["left_hip_pitch_joint", "right_hip_pitch_joint"], "hip_pitch"),
        (["left_hip_pitch_joint", "right_hip_roll_joint"], "hip"),
        (["FL_hip_joint", "FL_calf_joint"], "legs"),
        (["LeftShoulderYaw", "RightElbow"], "arms"),
        (["L_thumb_1", "L_index_2"], "hands"),
        (["front_wheel", "rear_caster_wheel"], "wheel"),
        (["torso_joint", "left_hip_joint"], "torso_hip"),
        (["joint1", "joint2"], "joints"),
        (["on"], "joints"),
        (["Д", "1"], "joints"),
        (["gripper: {x}"], "gripper_x"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_group_names(joints: list[str], expected: str) -> None:
    """A group is called after what its joints have in common."""
    assert group_name(joints, ()) == expected


def test_group_names_are_unique() -> None:
    """A name that is taken gives way to the next best, then to a number."""
    taken: list[str] = []
    for _ in range(4):
        taken.append(group_name(["FL_calf_joint", "RR_calf_joint"], taken))
    assert taken == ["calf", "joints", "calf_2", "calf_3"]


# --- text -----------------------------------------------------------------------------------------

NASTY = [
    'quote"s',
    "it's",
    "back\\slash\\",
    "back\\slash's",
    "a: b",
    "a #b",
    "# hash",
    "- dash",
    "&anchor",
    "*alias",
    "!tag",
    "{a: b}",
    "[x]",
    "yes",
    "null",
    "1e3",
    "0x1F",
    "~",
    "line\nbreak",
    "tab\there",
    " lead",
    "trail ",
    "per%cent",
    "@at",
    "`tick`",
    "д",
    "関節",
    "\u2028sep",
    "\x85next",
    "\ufeffbom",
    "😀",
    "a|b",
    "(((((",
    "(a+)+$",
    ".*",
    "^x$",
    "]",
    "{{ jinja }}",
    "{% if %}",
    "${shell}",
    "--><!--",
    "x" * 150,
]


@pytest.mark.parametrize("text", [*NASTY, "", "plain", "hip_joint"], ids=ascii)
@pytest.mark.parametrize("quoted", [False, True], ids=["free", "quoted"])
def test_scalar(text: str, quoted: bool) -> None:
    """Any text comes back the same: as key, value and item, by PyYAML and by actspec's own reader."""
    written = scalar(text, quoted=quoted)
    assert "\n" not in written
    block = f"key: {written}\nflow: [{written}, {written}]\nmap: {{{written}: 1}}\n"
    expected = {"key": text, "flow": [text, text], "map": {text: 1}}
    assert yaml.safe_load(block) == expected
    assert document_from_text(block).data == expected


@given(st.text())
def test_scalar_of_any_text(text: str) -> None:
    """Text of any characters that UTF-8 has comes back the same through PyYAML."""
    written = scalar(text)
    assert yaml.safe_load(f"a: [{written}]") == {"a": [text]}


@given(st.text())
def test_comment_ends_with_its_line(text: str) -> None:
    """A comment cannot start a line of its own, whatever is in it."""
    assert document_from_text(f"a: 1    # {comment(text)}\nb: 2\n").data == {"a": 1, "b": 2}


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
    robot = read(tmp_path, nasty_robot(NASTY, actuated))
    draft = draft_spec(robot, "robot.xml")
    path = tmp_path / "spec.yaml"
    path.write_text(draft.text, encoding="utf-8")
    actuators = api.resolve(path)
    managed = {joint.joint for joint in actuators.joints}
    assert managed == (set(NASTY[1:]) if actuated else set(NASTY))
    assert set(actuators.unmanaged) == set(NASTY) - managed


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
        robot = read(tmp_path, nasty_robot(names, actuated))
    except RobotError:
        # MuJoCo's own limits on names; nothing is drafted then.
        return
    path = tmp_path / "spec.yaml"
    path.write_text(draft_spec(robot, "robot.xml").text, encoding="utf-8")
    actuators = api.resolve(path)
    assert {joint.joint for joint in actuators.joints} | set(actuators.unmanaged) == {
        j.name for j in robot.joints
    }


@pytest.mark.parametrize(
    "value, exact, expected",
    [
        (0.1 + 0.2, False, "0.3 N*m"),
        (0.1 + 0.2, True, "0.30000000000000004 N*m"),
        (25.0, True, "25 N*m"),
        (-0.0, True, "0 N*m"),
        (1e-7, True, "1e-07 N*m"),
    ],
    ids=["computed", "exact", "whole", "minus zero", "small"],
)
def test_figure(value: float, exact: bool, expected: str) -> None:
    """The file's own numbers keep every digit, computed ones have 12."""
    assert figure(value, "N*m", exact) == expected


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
        assert drafted(folder, text, file)[1]["robot"]["name"] == expected
