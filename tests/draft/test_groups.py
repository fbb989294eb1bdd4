"""How joints are sorted into groups: limbs, motors, names that a configuration has, and gears that limits give away."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from actspec import api
from actspec.draft.names import given_name, one_pattern
from tests.importing import Imported, bare, imported, mjcf, write

LINK = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'

HUMANOID = ("hip_yaw", "hip_pitch", "knee", "ankle", "shoulder_pitch", "shoulder_yaw", "elbow")
"""Joints of one side, the leg's and the arm's a chain each, from the torso."""


def humanoid(limits: dict[str, tuple[float, float]], torso: tuple[float, float] = (200, 23)) -> str:
    """A URDF with (effort, velocity) of each joint."""

    def joint(name: str, parent: str, effort: float, speed: float) -> str:
        return (
            f'<link name="{name}">{LINK}</link><joint name="{name}_joint" type="revolute"><parent link="{parent}"/>'
            f'<child link="{name}"/><limit lower="-1" upper="1" effort="{effort}" velocity="{speed}"/></joint>'
        )

    text = '<robot name="h1"><link name="pelvis"/>' + joint("torso", "pelvis", *torso)
    for side in ("left", "right"):
        parent = "pelvis"
        for part in HUMANOID:
            parent = "torso" if part == "shoulder_pitch" else parent
            text += joint(f"{side}_{part}", parent, *limits[part])
            parent = f"{side}_{part}"
    return text + "</robot>"


def groups(found: Imported) -> dict[str, tuple[list[str], dict[str, Any]]]:
    """DraftGroup to its patterns and the limits in its overrides."""
    return {
        name: (group["joints"], {p: o.get("effort_limit") for p, o in group.get("overrides", {}).items()})
        for name, group in bare(found.data["actuators"]).items()
    }


def test_limbs_that_share_limits(tmp_path: Path) -> None:
    """The H1's limits, 200 N*m at hips and torso and 40 at ankles and shoulders, give legs, torso and arms."""
    limits: dict[str, tuple[float, float]] = {
        "hip_yaw": (200, 23),
        "hip_pitch": (200, 23),
        "knee": (300, 14),
        "ankle": (40, 9),
        "shoulder_pitch": (40, 9),
        "shoulder_yaw": (18, 7),
        "elbow": (18, 7),
    }
    found = imported(write(tmp_path, h1_urdf=humanoid(limits)), tmp_path)
    assert groups(found) == {
        "torso": (["torso_joint"], {}),
        "legs": (
            [".*_hip_.*", ".*_knee_joint", ".*_ankle_joint"],
            {".*_knee_joint": "300 N*m", ".*_ankle_joint": "40 N*m"},
        ),
        "arms": (
            [".*_shoulder_.*", ".*_elbow_joint"],
            {".*_pitch_joint": "40 N*m"},
        ),
    }


VEGA = {
    "torso_j1": ("base", 700), "torso_j2": ("torso_j1", 380), "head_j1": ("torso_j2", 6),
    "L_arm_j1": ("torso_j2", 150), "L_arm_j2": ("L_arm_j1", 25),
    **{f"L_{finger}_j1": ("L_arm_j2", 0.5) for finger in ("ff", "mf", "rf", "lf")}, "L_th_j0": ("L_arm_j2", 0.1),
    "B_wheel_j1": ("base", 1), "L_wheel_j1": ("base", 16), "knee": ("base", 16),
}  # fmt: skip
"""Joints as of dexmate-urdf's vega_1p_f5d6, and a knee: the link before each, and its torque [N*m]."""


def test_joints_without_gains_are_grouped_by_limb_and_torque(tmp_path: Path) -> None:
    """kp and kd of a URDF are to be filled in, once a group: not for a torso, arms, fingers and a thumb together."""
    text = '<robot name="vega"><link name="base"/>'
    for name, (parent, effort) in VEGA.items():
        text += (
            f'<link name="{name}">{LINK}</link><joint name="{name}" type="revolute"><parent link="{parent}"/>'
            f'<child link="{name}"/><limit lower="-1" upper="1" effort="{effort}" velocity="9"/></joint>'
        )
    found = imported(write(tmp_path, vega_urdf=text + "</robot>"), tmp_path)
    assert groups(found) == {
        "torso": (["torso_.*"], {"torso_j2": "380 N*m"}),
        # 150 N*m are 6 times the wrist's 25.
        "arm": (["L_arm_.*"], {"L_arm_j2": "25 N*m"}),
        "head": (["head_j1"], {}),
        "hands": (["L_[flmr]f_j1", "L_th_j0"], {"L_th_j0": "0.1 N*m"}),
        "knee": (["knee"], {}),
        "rear_wheel": (["B_wheel_j1"], {}),
        "left_wheel": (["L_wheel_j1"], {}),
    }


def test_wheels_without_gains_are_no_legs(tmp_path: Path) -> None:
    """As of Upkie: a wheel at a leg has gains of its own, also with the knee's torque; with gains all are one."""
    legs = mjcf(
        '<joint name="hip"/>\n<joint name="knee"/>\n<joint name="wheel"/>',
        "".join(f'<position joint="{name}" kp="10" kv="1"/>' for name in ("hip", "knee", "wheel")),
    ).replace("<joint ", '<joint actuatorfrcrange="-16 16" ')
    assert list(groups(imported(write(tmp_path, leg_xml=legs), tmp_path))) == ["hip_knee_wheel"]
    legs = legs[: legs.index("<actuator>")] + legs[legs.index("</actuator>") + len("</actuator>") :]
    for text in (legs, legs.replace('16 16" name="wheel"', '16 16" name="wheel" frictionloss="1"')):
        assert list(groups(imported(write(tmp_path, leg_xml=text), tmp_path))) == ["legs", "wheel"]


def test_what_is_between_two_limbs_makes_no_limb_of_them(tmp_path: Path) -> None:
    """A torso and fingers are in one chain with three joints without words, and no group with them both."""
    names = ("torso", "a1", "b2", "c3", "finger")
    chain = mjcf(
        "\n".join(f'<joint name="{name}"/>' for name in names),
        "".join(
            f'<position joint="{name}" kp="10" kv="1" forcerange="-{effort} {effort}"/>'
            for name, effort in zip(names, (70, 9, 9, 9, 1), strict=True)
        ),
    )
    found = groups(imported(write(tmp_path, robot_xml=chain), tmp_path))
    assert [joints for joints, _ in found.values()] == [["torso", "a1", "b2", "c3"], ["finger"]]


def test_joints_with_gains_share_a_group_whatever_their_torques(tmp_path: Path) -> None:
    """With kp and kd known nothing is to be filled in: a shoulder of 100 N*m and a wrist of 1 are one arm."""
    arm = mjcf(
        '<joint name="shoulder"/>\n<joint name="elbow"/>\n<joint name="wrist"/>',
        "".join(
            f'<position joint="{name}" kp="10" kv="1" forcerange="-{effort} {effort}"/>'
            for name, effort in (("shoulder", 100), ("elbow", 100), ("wrist", 1))
        ),
    )
    assert list(groups(imported(write(tmp_path, arm_xml=arm), tmp_path))) == ["arm"]
    bare_arm = arm[: arm.index("<actuator>")] + arm[arm.index("</actuator>") + len("</actuator>") :]
    limits = bare_arm.replace('name="wrist"', 'name="wrist" actuatorfrcrange="-1 1"')
    for name in ("shoulder", "elbow"):
        limits = limits.replace(f'name="{name}"', f'name="{name}" actuatorfrcrange="-100 100"')
    assert list(groups(imported(write(tmp_path, arm_xml=limits), tmp_path))) == ["arm", "wrist"]


def test_limbs_of_which_nothing_is_known(tmp_path: Path) -> None:
    """Without gains and torques nobody says that a hip and a shoulder have one motor."""
    text = humanoid(dict.fromkeys(HUMANOID, (200.0, 23.0))).replace('effort="200', 'effort="0')
    found = imported(write(tmp_path, h1_urdf=text), tmp_path)
    assert groups(found).keys() == {"torso", "legs", "arms"}


def test_one_group_where_one_is_enough(tmp_path: Path) -> None:
    """A robot whose joints are all the same is one group, also over several limbs."""
    found = imported(write(tmp_path, h1_urdf=humanoid(dict.fromkeys(HUMANOID, (200.0, 23.0)))), tmp_path)
    assert [joints for joints, _ in groups(found).values()] == [[".*"]]


MJLAB = """from mjlab.actuator import BuiltinPositionActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg

H1_BIG_ACTUATOR_CFG = BuiltinPositionActuatorCfg(
    target_names_expr=(".*_hip_.*", "torso_joint"), stiffness=80.0, damping=4.0, effort_limit=200.0, armature=0.06
)
H1_SMALL_ACTUATOR_CFG = BuiltinPositionActuatorCfg(
    target_names_expr=(".*_knee_joint", ".*_ankle_joint", ".*_shoulder_.*", ".*_elbow_joint"),
    stiffness=40.0, damping=2.0, effort_limit=40.0, armature=0.01
)
H1_ARTICULATION = EntityArticulationInfoCfg(actuators=(H1_BIG_ACTUATOR_CFG, H1_SMALL_ACTUATOR_CFG))
"""


def test_motors_over_limbs_stay_one_group(tmp_path: Path) -> None:
    """What a configuration drives alike in several limbs is one group, with the configuration's name for it."""
    model = humanoid(dict.fromkeys(HUMANOID, (500.0, 23.0)), (500, 23))
    found = imported(write(tmp_path, h1_urdf=model, h1_py=MJLAB), tmp_path)
    assert {name: len(joints) for name, (joints, _) in groups(found).items()} == {"big": 2, "small": 4}
    assert groups(found)["big"][0] == ["torso_joint", ".*_hip_.*"]


@pytest.mark.parametrize(
    "given, robot, expected",
    [
        ("legs", "a1", "legs"),
        ("GO1_HIP_ACTUATOR_CFG", "unitree_go1", "hip"),
        ("G1_ACTUATOR_5020", "g1_29dof", "actuator_5020"),
        ("ACTUATOR_DM_4310", "yam", "dm_4310"),
        ("M107_15", "h1_2", "m107_15"),
        ("N7520_14p3", "h1_2", "n7520_14p3"),
        ("leftKneePitch", "val", "left_knee_pitch"),
        ("KneeActuatorCfg", "val", "knee"),
        ("actuators[0]", "yam", ""),
        ("null", "a1", ""),
        ("", "a1", ""),
        ("x: {{ y }}", "a1", ""),
    ],
    ids=[
        *("plain", "constant", "number", "prefix", "a motor", "a motor with a point", "words", "a class"),
        *("no name", "reserved", "none", "hostile"),
    ],
)
def test_given_names(given: str, robot: str, expected: str) -> None:
    """A configuration's name for a group becomes its key, without the robot's and without `actuator`."""
    assert given_name(["a", "b"], {"a": given, "b": given, "c": "other"}, robot) == expected


def test_given_name_of_part_of_a_group() -> None:
    """Half of a configuration's group has not its name, nor have two groups together."""
    assert given_name(["a"], {"a": "legs", "b": "legs"}, "bot") == ""
    assert given_name(["a", "b"], {"a": "hips", "b": "knees"}, "bot") == ""


@pytest.mark.parametrize(
    "wanted, expected",
    [
        (["l_wrist_pitch_joint", "l_wrist_yaw_joint"], ("l_wrist_(pitch|yaw)_joint",)),
        (["l_wrist_pitch_joint"], ("l_wrist_pitch_joint",)),
        (["l_elbow_joint", "l_hip_yaw_joint"], ("l_elbow_joint", "l_hip_yaw_joint")),
    ],
    ids=["one word", "one joint", "other words"],
)
def test_one_pattern(wanted: list[str], expected: tuple[str, ...]) -> None:
    """Joints that differ in one word have one pattern; others as many as they need."""
    names = [
        "l_wrist_pitch_joint",
        "l_wrist_roll_joint",
        "l_wrist_yaw_joint",
        "l_elbow_joint",
        "l_hip_yaw_joint",
    ]
    assert one_pattern(wanted, names) == expected


def test_numbered_joints_are_one_row(tmp_path: Path) -> None:
    """Without a robot file, joint1 to joint3 are taken for one limb: a group with overrides, not three groups."""
    drives = "".join(
        f'"{name}": ImplicitActuatorCfg(joint_names_expr=["{name}"], stiffness={kp}, damping=1.0),\n'
        for name, kp in (("joint1", 10.0), ("joint2", 20.0), ("joint3", 30.0))
    )
    text = (
        "from isaaclab.actuators import ImplicitActuatorCfg\nfrom isaaclab.assets import ArticulationCfg\n"
        f"ARM_CFG = ArticulationCfg(actuators={{{drives}}})\n"
    )
    found = imported(write(tmp_path, arm_py=text), tmp_path)
    (group,) = bare(found.data["actuators"]).values()
    assert group["joints"] == [".*"]
    assert group["overrides"] == {"joint2": {"kp": "20 N*m/rad"}, "joint3": {"kp": "30 N*m/rad"}}


LEG = """<robot name="leg"><link name="base"/><link name="a">LINK</link><link name="b">LINK</link>
<link name="c">LINK</link>
<joint name="hip" type="revolute"><parent link="base"/><child link="a"/><limit lower="-1" upper="1" HIP/></joint>
<joint name="knee" type="revolute"><parent link="a"/><child link="b"/><limit lower="-1" upper="1" KNEE/></joint>
<joint name="ankle" type="revolute"><parent link="b"/><child link="c"/><limit lower="-1" upper="1" ANKLE/></joint>
</robot>""".replace("LINK", LINK)


def leg(hip: tuple[float, float], knee: tuple[float, float], ankle: tuple[float, float]) -> str:
    """A leg with (effort, velocity) of its joints."""
    text = LEG
    for part, (effort, speed) in (("HIP", hip), ("KNEE", knee), ("ANKLE", ankle)):
        text = text.replace(part, f'effort="{effort}" velocity="{speed}"')
    return text


def test_motor_that_not_all_joints_have(tmp_path: Path) -> None:
    """A joint without the inferred motor is no override of those that have it; the motor is called after these."""
    # 10 x 40 and 20 x 20 are one power, 60 x 9 is another.
    found = imported(write(tmp_path, leg_urdf=leg((60, 9), (20, 20), (10, 40))), tmp_path)
    assert list(bare(found.data["motors"])) == ["legs_motor"]
    made = bare(found.data["actuators"])
    assert {name: ("motor" in group, group["joints"]) for name, group in made.items()} == {
        "hip": (False, ["hip"]),
        "legs": (True, ["knee", "ankle"]),
    }
    (tmp_path / "spec.yaml").write_text(found.draft.text, encoding="utf-8")
    limits = {joint.joint: joint.effort_limit.value for joint in api.resolve(tmp_path / "spec.yaml").joints}
    assert limits == {"hip": 60.0, "knee": 20.0, "ankle": 10.0}


def config(cls: str, more: str = "") -> str:
    """A configuration that gives all three joints 10 N*m."""
    return f"""from isaaclab.actuators import {cls}
from isaaclab.assets import ArticulationCfg

LEG_CFG = ArticulationCfg(
    actuators={{"leg": {cls}(joint_names_expr=[".*"], effort_limit=10.0, stiffness=40.0, damping=1.0{more})}},
)
"""


def test_gear_that_only_another_file_gives_away(tmp_path: Path) -> None:
    """A URDF's 24 x 12 and 12 x 24 are one motor, though the configuration that counts has 10 N*m at both joints."""
    model = leg((12, 24), (24, 12), (12, 24))
    found = imported(write(tmp_path, leg_urdf=model, leg_py=config("IdealPDActuatorCfg")), tmp_path)
    assert bare(found.data["motors"]) == {"leg_motor": {"side": "joint", "peak_torque": "10 N*m"}}
    (group,) = bare(found.data["actuators"]).values()
    assert group["effort_limit"] == "10 N*m"
    assert group["overrides"] == {"knee": {"reduction": 2, "velocity_limit": "12 rad/s"}}
    assert found.draft.inferred == (
        "knee: inferred: 24 N*m x 12 rad/s are the 12 N*m x 24 rad/s of hip behind 2 times the gear in leg_urdf",
    )


def test_gear_that_a_line_speaks_against(tmp_path: Path) -> None:
    """Where the configuration's torque-speed line is the hip's at the knee too, the gear is a question, no number."""
    model = leg((12, 24), (24, 12), (12, 24))
    line = config("DCMotorCfg", ", saturation_effort=12.0, velocity_limit=24.0")
    found = imported(write(tmp_path, leg_urdf=model, leg_py=line), tmp_path)
    (group,) = bare(found.data["actuators"]).values()
    assert group["overrides"] == {"knee": {"velocity_limit": "12 rad/s"}}
    told = "knee: the motor of hip behind 2 times the gear? 24 N*m x 12 rad/s are its 12 N*m x 24 rad/s in leg_urdf"
    assert found.draft.inferred == (told,)
    assert f"    # {told}\n" in found.draft.text


def test_other_limits_of_an_overruled_file_are_no_difference(tmp_path: Path) -> None:
    """Knee and ankle with one figure in the spec are one override, though a file that does not count differs."""
    model = leg((12, 24), (24, 20), (25, 20)).replace('"knee"', '"l_knee"').replace('"ankle"', '"r_knee"')
    found = imported(write(tmp_path, leg_urdf=model, leg_py=config("IdealPDActuatorCfg")), tmp_path)
    (group,) = bare(found.data["actuators"]).values()
    assert group["overrides"] == {"hip": {"velocity_limit": "24 rad/s"}}
    wide = model.replace("</robot>", EXTRA + "</robot>")
    found = imported(write(tmp_path, leg_urdf=wide, leg_py=config("IdealPDActuatorCfg")), tmp_path)
    (group,) = bare(found.data["actuators"]).values()
    assert group["overrides"] == {".*_knee": {"velocity_limit": "20 rad/s"}}


EXTRA = "".join(
    f'<link name="{name}">{LINK}</link><joint name="{name}_hip" type="revolute"><parent link="base"/>'
    f'<child link="{name}"/><limit lower="-1" upper="1" effort="12" velocity="24"/></joint>'
    for name in ("FL", "FR", "RL")
)


def test_equal_motors_of_a_leg_whose_words_are_not_all_known(tmp_path: Path) -> None:
    """Collar and hip of mujina have one motor and one figure each: one group of the legs, knees are its exception."""
    legs = ("FL", "FR", "RL", "RR")
    hips, knees = (
        [f"{leg}_{part}" for leg in legs for part in ("collar", "hip")],
        [f"{leg}_knee" for leg in legs],
    )
    text = f"""from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets import ArticulationCfg
CFG = ArticulationCfg(actuators={{
    "hips": IdealPDActuatorCfg(joint_names_expr={hips}, effort_limit=12.0, stiffness=30.0, damping=1.0),
    "knees": IdealPDActuatorCfg(joint_names_expr={knees}, effort_limit=24.0, stiffness=30.0, damping=1.0),
}})
"""
    found = imported(write(tmp_path, dog_cfg_py=text), tmp_path)
    assert groups(found) == {"legs": ([".*"], {".*_knee": "24 N*m"})}
