"""Patterns and names that a person would write, and text that is always valid YAML."""

from __future__ import annotations

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from actspec.draft.names import body_part, group_name, joint_patterns, parts_of_body
from actspec.draft.text import comment, figure, quantity_text, scalar, sourced, time_text
from actspec.ir import Origin, Quantity
from actspec.patterns import MAX_PATTERN, compile_pattern, covering_pattern
from actspec.spec.document import document_from_text
from tests.importing import NASTY

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


@pytest.mark.slow
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
        (["FL_calf_joint", "RR_calf_joint"], "calves"),
        (["FL_calf_joint"], "calf"),
        (["LL_HR", "LR_HR"], "hip_rotation"),
        (["LL_HAA", "LR_HFE"], "hips"),
        (["LL_KFE", "LR_KFE"], "knees"),
        (["LL_FFE", "LR_FAA"], "ankles"),
        (["LL_HR", "LL_KFE"], "legs"),
        (["LL_1", "LR_2"], "joints"),
        (["fl_kn", "hr_kn"], "knees"),
        (["left_elbow", "right_elbow"], "elbows"),
        (["torso_to_abduct_fr_j", "abduct_fr_to_thigh_fr_j", "thigh_hl_to_knee_hl_j"], "legs"),
        (["thigh_fr_to_knee_fr_j", "thigh_hl_to_knee_hl_j"], "knees"),
        (["left_hip_pitch_joint", "right_hip_pitch_joint"], "hip_pitch"),
        (["left_hip_pitch_joint", "right_hip_roll_joint"], "hips"),
        (["FL_hip_joint", "FL_calf_joint"], "legs"),
        (["LeftShoulderYaw", "RightElbow"], "arms"),
        (["L_thumb_1", "L_index_2"], "hands"),
        (["front_wheel", "rear_caster_wheel"], "wheels"),
        (["torso_joint", "left_hip_joint"], "torso_hip"),
        (["joint1", "joint2"], "joints"),
        (["on"], "joints"),
        (["Д", "1"], "joints"),
        (["gripper: {x}"], "gripper_x"),
        (["LHipYaw", "RHipRoll", "LKneePitch"], "legs"),
        (["RLEG_HIP_R", "LLEG_HIP_P"], "leg_hip"),
        (["LShoulderPitch_joint", "TrunkYaw"], "shoulder_trunk"),
        (["j2s6s200_joint_1", "j2s6s200_joint_2"], "joints"),
        (["not_use_joint"], "unused"),
        (["joint1", "jointGripper"], "joints"),
        (["torso_yaw", "velodyne_joint", "d435_head_joint"], "torso_head"),
        (["left_one_joint", "left_two_joint"], "joints"),
        (["FL_hip_joint", "FL_thigh_joint", "FL_calf_joint", "FL_wheel_joint"], "legs_wheels"),
        (["waist", "l_hip", "l_knee", "l_elbow"], "body"),
        (["waist", "chest", "l_elbow", "l_wrist"], "upper_body"),
        (["shoulder", "elbow", "wrist", "gripper"], "arm"),
        (["shoulder_1", "elbow_1", "shoulder_2", "elbow_2"], "arms"),
        (["bthigh", "bshin", "bfoot"], "legs"),
        (["robot0_FFJ3", "robot0_MFJ2"], "fingers"),
        (["L_ff_j1", "R_rf_j1"], "fingers"),
        (["L_th_j0", "R_th_j1"], "thumbs"),
        (["L_TH", "R_TH"], "th"),
        (["RF_J1", "LF_J1"], "joints"),
        (["R_UTHUMB", "L_UTHUMB"], "thumbs"),
        (["openarm_left_joint1", "openarm_right_joint1"], "arms"),
        (["openarm_lifter_joint"], "lifter"),
        (["openarm_left_finger_joint1", "openarm_right_finger_joint1"], "fingers"),
        (["orcahand_left_i-mcp", "orcahand_left_Carpals"], "hands"),
        (["orcahand_left_Carpals", "orcahand_right_Carpals"], "hand_carpals"),
        (["LNeckYaw", "HeadPitch"], "neck_head"),
        (["left_hip_pitch", "left_knee_pitch"], "legs"),
        (["iiwa7_joint_1", "iiwa7_joint_2"], "iiwa"),
        ([f"iiwa7_joint_{n}" for n in range(1, 8)], "arm"),
        (["lhumerusrx", "rradiusrx", "lclaviclerz"], "arms"),
        (["lfemurrz", "rtibiarx"], "legs"),
        (["lowerbackrx", "thoraxry"], "torso"),
        (["lowerneckrz", "upperneckry"], "neck"),
        (["middle_lumbar_Z", "middle_cervical_X"], "torso"),
        (["middle_1", "middle_2"], "middle"),
        (["tail_twist", "finright_pitch", "finleft_pitch", "tail1"], "tail_fin"),
        (["rx_head_Armature", "ry_head_Armature"], "head"),
        (
            [
                "rx_head_Armature",
                "rx_femur_T1_left_Armature",
                "rx_tibia_T1_left_Armature",
                "rx_abdomen_Armature",
                "rx_rostrum_Armature",
            ],
            "body",
        ),
        (
            [
                *(
                    "head_pan",
                    "head_tilt",
                    "l_sho_pitch",
                    "l_sho_roll",
                    "l_el",
                    "r_sho_pitch",
                    "r_sho_roll",
                    "r_el",
                ),
                *("l_hip_yaw", "l_knee", "l_ank_pitch", "r_hip_yaw", "r_knee", "r_ank_pitch"),
            ],
            "body",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_group_names(joints: list[str], expected: str) -> None:
    """A group is called after what its joints have in common."""
    assert group_name(joints, ()) == expected


CHAIN = {f"joint{i}": frozenset(f"joint{j}" for j in range(1, i)) for i in range(1, 7)}
HAND = {
    f"Roll_{f}{i}L": frozenset(f"Roll_{f}{j}L" for j in range(1, i)) for f in range(1, 6) for i in range(1, 4)
}
LEGS = {
    f"{leg}_{part}": frozenset(f"{leg}_{other}" for other in ("HAA", "HFE", "KFE")[:at])
    for leg in ("LF", "RF", "LH", "RH")
    for at, part in enumerate(("HAA", "HFE", "KFE"))
}
LETTERS = ("s0", "s1", "e0", "e1", "w0", "w1", "w2")
ARMS = {
    f"{side}_{part}": frozenset(f"{side}_{other}" for other in LETTERS[:at])
    for side in ("left", "right")
    for at, part in enumerate(LETTERS)
}
GRIPPING = {name: chain for name, chain in ARMS.items() if "w2" not in name}
GRIPPING |= {
    f"{side}_grip_1": frozenset(name for name in GRIPPING if side in name) for side in ("left", "right")
}
"""Arms of six joints, as legs may have them, each with a gripper."""
QUADRUPED = {name: chain for name, chain in HAND.items() if "_5" not in name}


@pytest.mark.parametrize(
    "joints, above, expected",
    [
        (["joint1", "joint3"], CHAIN, "arm"),
        (["joint2"], CHAIN, "arm_joint2"),
        (["joint1", "jointGripper"], {**CHAIN, "jointGripper": frozenset(CHAIN)}, "arm"),
        (["jointGripper"], {**CHAIN, "jointGripper": frozenset(CHAIN)}, "gripper"),
        (["joint2", "joint3"], {**CHAIN, **LEGS}, "arm"),
        (["joint2", "LF_KFE"], {**CHAIN, **LEGS}, "joints"),
        (["right_s0", "left_e1"], ARMS, "arms"),
        (
            ["right_s0", "left_e1"],
            {name: chain for name, chain in ARMS.items() if "w2" not in name},
            "joints",
        ),
        (["joint1", "joint2"], dict(list(CHAIN.items())[:3]), "joints"),
        (["Roll_11L", "Roll_12L"], HAND, "finger"),
        (["Roll_21L", "Roll_32L"], HAND, "fingers"),
        (["Roll_21L", "Roll_32L"], QUADRUPED, "roll"),
        (["hip_1", "hip_2"], HAND, "hips"),
        (["L_th_j0", "L_th_j1"], {"L_th_j0": frozenset(), "L_th_j1": frozenset({"L_th_j0"})}, "thumb"),
        (["left_s0", "right_s1"], GRIPPING, "arms"),
    ],
)
def test_group_names_by_the_tree(joints: list[str], above: dict[str, frozenset[str]], expected: str) -> None:
    """Where names have no words, one chain of four joints is an arm, and five branches of a base are fingers."""
    assert group_name(joints, (), above) == expected
    if len(joints) > 1 and expected == "fingers":
        assert group_name(joints, [expected], above) == "fingers_2"


def test_a_second_group_of_an_arm_has_its_joints_numbers() -> None:
    """`arm_2` would be another arm."""
    assert group_name(["joint2", "joint3"], ["arm"], CHAIN) == "arm_2_3"
    assert group_name(["joint4", "joint5", "joint6"], ["arm"], CHAIN) == "arm_4_to_6"
    assert group_name(["arm_left_5_joint", "arm_left_6_joint"], ["arm", "arms"]) == "arms_5_6"
    assert group_name(["joint1", "joint3", "joint6"], ["arm"], CHAIN) == "arm_2"


@pytest.mark.parametrize(
    "joints, taken, robot, expected",
    [
        (["joint_1", "joint_2"], (), "gen3", "arm"),
        (["joint_1", "joint_2"], ("arm",), "gen3", "arm_1_2"),
        (["joint_5", "knee"], (), "gen3", "joints"),
        (["joint_8", "joint_9"], (), "allegro_hand_left", "fingers"),
        (["cam_1", "cam_2"], (), "x", "cam"),
        (["iris_rotor_1", "iris_rotor_2"], (), "iris", "rotor"),
        (["cart_to_pole", "pole_to_cart"], (), "cart_pole", "cart_pole"),
    ],
)
def test_group_names_of_a_configuration(
    joints: list[str], taken: tuple[str, ...], robot: str, expected: str
) -> None:
    """Joints without words have the name of their group in the configuration; the robot's name is no word."""
    given = {
        "joint_1": "arm",
        "joint_2": "arm",
        "joint_5": "arm",
        "cam_1": "all",
        "cam_2": "all",
        "knee": "legs",
    }
    assert group_name(joints, taken, {}, {**dict.fromkeys(joints, ""), **given}, robot) == expected


DYNA = ["SH_ROT", "SH_FLE", "EL_FLE", "FA_ROT", "WRIST_FLE", "WRIST_ROT"]
NUMBERED = [f"{side}_{joint}" for side in "LR" for joint in ("J0", "J1", "J2", "J3", "J4", "J5", "A0", "A1")]


@pytest.mark.parametrize(
    ("joints", "every", "called", "taken", "expected"),
    [
        (DYNA[:2], DYNA, "arm", (), "shoulders"),
        (["EL_FLE"], DYNA, "arm", (), "elbow_flexion"),
        (["FA_ROT"], DYNA, "arm", (), "forearm_rotation"),
        (DYNA[3:], DYNA, "arm", ("arm",), "forearm_wrist"),
        # Without a turn behind it an elevation is no elbow.
        (["el_joint"], ["az_joint", "el_joint"], "mount", (), "mount_el"),
        (["ll_akp", "lr_akp"], ["ll_akp", "lr_akp", "ll_hy"], "g1", (), "ankle_pitch"),
        (["l_abd", "r_abd"], ["l_abd", "r_abd", "l_hip"], "abd_hip", (), "abd"),
        (["l_qx", "r_qx"], ["l_qx", "r_qx", "l_qy"], "rear", (), "rear_qx"),
        (["L_J3", "R_J3"], NUMBERED, "all", (), "j3"),
        (["L_J4", "R_J4", "L_J5", "R_J5"], NUMBERED, "all", (), "j4_j5"),
        (["L_J0", "L_J1", "L_J2", "R_J0", "R_J1", "R_J2"], NUMBERED, "all", (), "j0_to_j2"),
        (["L_A0", "L_A1", "R_A0", "R_A1"], NUMBERED, "all", (), "a0_a1"),
        (["L_A0", "L_A1", "R_A0", "R_A1"], NUMBERED, "all", ("a0_a1",), "joints"),
        # 0 and 5 are no range: the numbers between them are others.
        (["L_J0", "L_J5", "R_J0", "R_J5"], NUMBERED, "all", (), "j0_j5"),
        (["L_J0", "R_J2", "L_J5"], NUMBERED, "all", (), "joints"),
        (["L_J0", "R_A1"], NUMBERED, "all", (), "joints"),
    ],
)
def test_group_names_of_codes(
    joints: list[str], every: list[str], called: str, taken: tuple[str, ...], expected: str
) -> None:
    """Codes of a robot's parts are its words; others stand behind what the configuration calls their group."""
    assert group_name(joints, taken, {}, dict.fromkeys(every, called), "robot") == expected


@pytest.mark.parametrize(
    "joints, others, expected",
    [
        (["right_hip_X"], ["left_hip_X"], "right_hip_x"),
        (["hip_X_L", "knee_L"], ["knee_R", "hip_X_R"], "left_legs"),
        (["right_hip_X"], ["left_hip_Y"], "hip_x"),
        (["left_hip_X", "right_hip_X"], ["right_hip_Y"], "hip_x"),
        (["left_x", "left_y"], ["right_x", "right_y"], "left_joints"),
        (["FL_knee"], ["FR_knee"], "left_knee"),
        (["FL_knee"], ["FR_knee", "RL_knee", "RR_knee"], "front_left_knee"),
        (["LH_HAA", "RH_HAA"], ["LF_HAA", "RF_HAA"], "rear_hip_abduction"),
        (["lm_coxa", "rm_coxa"], ["lf_coxa", "rf_coxa", "lh_coxa", "rh_coxa"], "middle_coxa"),
        (["FL_thigh", "RR_thigh"], ["FR_thigh", "RL_thigh"], "thighs"),
        (["LL_HR"], ["LR_HR"], "hip_rotation"),
        (["rh_THJ1"], ["lh_THJ1"], "right_thumb"),
        (["B_wheel_j1"], ["L_wheel_j1", "R_wheel_j1"], "rear_wheel"),
        (["L_wheel_j1", "R_wheel_j1"], ["B_wheel_j1"], "wheels"),
        (["RLEG_KNEE"], ["LLEG_KNEE"], "right_leg_knee"),
    ],
)
def test_one_side_alone(joints: list[str], others: list[str], expected: str) -> None:
    """Joints of one side whose counterparts are in another group have the side in their name."""
    assert group_name(joints, (), {}, dict.fromkeys([*joints, *others], "")) == expected


def test_the_model_s_number_before_a_joint_is_no_word() -> None:
    """`b2_` and `z1_` are the robot's: legs, and an arm by the tree; of another robot they may be words."""
    legs = [f"b2_{leg}_{part}_joint" for leg in ("FL", "FR", "RL", "RR") for part in ("hip", "thigh", "calf")]
    arm = [f"z1_joint{number}" for number in range(1, 7)]
    above = {name: frozenset(arm[:at]) for at, name in enumerate(arm)}
    above |= {name: frozenset(legs[at - at % 3 : at]) for at, name in enumerate(legs)}
    assert group_name(legs, (), above, {}, "b2_z1_scene") == "legs"
    assert group_name(arm, ("legs",), above, {}, "b2_z1_scene") == "arm"


def test_an_axis_is_no_name() -> None:
    """Where `torso` is taken, what turns about x is called after its parts."""
    assert group_name(["lowerbackrx", "thoraxrx"], ["torso"]) == "lowerback_thorax"


def test_group_names_are_unique() -> None:
    """A name that is taken gives way to the next best, then to a number; none has a word in place of a number."""
    taken: list[str] = []
    for _ in range(4):
        taken.append(group_name(["FL_calf_joint", "RR_calf_joint"], taken))
    assert taken == ["calves", "calves_2", "calves_3", "calves_4"]


# --- text -----------------------------------------------------------------------------------------


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


@pytest.mark.parametrize(
    "joints, expected",
    [
        (["FL_hip_joint", "RR_calf_joint"], "legs"),
        (["lf_coxa", "lm_coxa", "rh_tibia", "MR_femur"], "legs"),
        (["left_elbow_joint"], "arms"),
        (["waist_yaw_joint"], "torso"),
        (["left_hip_joint", "waist_yaw_joint"], None),
        (["joint1"], None),
    ],
    ids=["legs", "hexapod", "arms", "torso", "two", "none"],
)
def test_body_parts(joints: list[str], expected: str | None) -> None:
    """Joints are of a body part where all of their names say so."""
    assert body_part(joints) == expected


def test_a_joint_beside_those_of_its_leg() -> None:
    """A word that is no part's is of the leg whose end and side it has (mujina's collars), and of nothing else.

    `lf` and `rf` are a little and a ring finger too, and a humanoid's collar is beside arms and legs.
    """
    corners = [f"{end}{side}_{part}_joint" for end in "FR" for side in "LR" for part in ("collar", "hip")]
    assert set(parts_of_body(corners).values()) == {"legs"}
    assert parts_of_body(["lf_mcp", "rf_mcp", "thumb"])["lf_mcp"] is None
    assert parts_of_body(["FL_collar", "FL_hip", "FL_elbow"])["FL_collar"] is None
    assert parts_of_body(["left_collar", "left_hip", "left_elbow"])["left_collar"] is None
    assert group_name(corners, ()) == "legs"
    assert (
        group_name([name for name in corners if "collar" in name], (), given=dict.fromkeys(corners, ""))
        == "collar"
    )


@pytest.mark.parametrize(
    "value, computed, expected",
    [
        (0.1 + 0.2, False, "0.3 N*m"),
        (1 / 3, False, "0.333333333333 N*m"),
        (0.12345678901234, False, "0.12345678901234 N*m"),
        (0.12345678901234, True, "0.123456789012 N*m"),
        (25.0, False, "25 N*m"),
        (-0.0, False, "0 N*m"),
        (1e-7, False, "1e-07 N*m"),
    ],
    ids=["sum", "quotient", "written", "by a formula", "whole", "minus zero", "small"],
)
def test_figure(value: float, computed: bool, expected: str) -> None:
    """What somebody may have written keeps every digit, what was computed has 12."""
    assert figure(value, "N*m", computed=computed) == expected


@pytest.mark.parametrize(
    "seconds, expected",
    [
        (0.002, "2 ms"),
        (0.0012345, "1.2345 ms"),
        (0.0012345678901234567, "0.0012345678901234567 s"),
        (0.0007, "0.7 ms"),
    ],
    ids=["whole", "digits", "all digits", "fraction"],
)
def test_time(seconds: float, expected: str) -> None:
    """A time is in milliseconds where that is the same double."""
    assert time_text(seconds) == expected


def test_sourced() -> None:
    """A number carries source and deviation in its own unit; without both it stands alone."""
    found = Quantity(0.5, "N*m*s/rad", Origin.MODEL, source="a1_cfg", std=0.01)
    assert sourced(found) == "{value: 0.5 N*m*s/rad, std: 0.01 N*m*s/rad, source: a1_cfg}"
    assert sourced(Quantity(0.25, "", Origin.MODEL)) == "0.25"
    assert quantity_text(Quantity(0.005, "s", Origin.MODEL, formula="1 steps x 0.005 s")) == "5 ms"
