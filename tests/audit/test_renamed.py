"""Joints, gains and lists that two files of a named robot have otherwise: told once, where the mistake is."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.settings import Settings

NAMES = ("left_hip_pitch", "left_knee_pitch", "right_hip_pitch", "right_knee_pitch")


def _urdf(names: tuple[str, ...] = NAMES, more: str = "") -> str:
    links = ("left_thigh", "left_shank", "right_thigh", "right_shank")
    parents = ("trunk", "left_thigh", "trunk", "right_thigh")
    joints = "\n".join(
        f'<link name="{link}"/><joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{link}"/>'
        f'<limit lower="-2" upper="1" effort="42" velocity="18"/></joint>'
        for name, link, parent in zip(names, links, parents, strict=True)
    )
    return f'<robot name="strutter"><link name="trunk"/>\n{joints}\n{more}</robot>\n'


def _config(knees: str = '".*_knee_pitch"', kp: float = 60.0, kd: float = 2.0, pose: str = "") -> str:
    return f"""
from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets import ArticulationCfg

STRUTTER_CFG = ArticulationCfg(
    {pose}
    actuators={{
        "hips": IdealPDActuatorCfg(joint_names_expr=[".*_hip_pitch"], effort_limit=42.0, stiffness=50.0, damping=1.5),
        "knees": IdealPDActuatorCfg(joint_names_expr=[{knees}], effort_limit=42.0, stiffness={kp}, damping={kd}),
    }},
)
"""


def _deploy(names: tuple[str, ...] = NAMES, kp: str = "50, 60, 50, 60", more: str = "") -> str:
    return f"joint_names: [{', '.join(names)}]\nkp: [{kp}]\nkd: [1.5, 2, 1.5, 2]\n{more}"


def _told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, named: bool = True, **files: str
) -> list[tuple[str, ...]]:
    """Code, file, line, joint and message of warnings and errors."""
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    for name, text in files.items():
        Path("r", f"strutter.{name[1:]}").write_text(text)
    return [
        (one.finding.code, f"{Path(one.finding.span.path).suffix}:{one.finding.span.line}", one.finding.joint,
         one.finding.message)
        for one in audit(["r"], Settings(as_named=named)).findings
        if one.severity.value != "info"
    ]  # fmt: skip


OTHER = (*NAMES[:3], "right_knee")


def test_a_deploy_file_names_a_joint_that_no_model_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = _told(tmp_path, monkeypatch, _urdf=_urdf(), _py=_config(), _yaml=_deploy(OTHER))
    assert told == [
        (
            "ORD104",
            ".yaml:1",
            "right_knee",
            "no file of the robot has a joint 'right_knee': strutter.urdf has 'right_knee_pitch', which this list "
            "leaves out",
        )
    ]


def test_a_joint_is_renamed_in_the_model_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told = _told(tmp_path, monkeypatch, _urdf=_urdf(OTHER), _py=_config(), _yaml=_deploy())
    # Deploy file and configuration agree, so it is the URDF's line: 2 and 3 of the joints before it.
    assert told == [
        (
            "CFG102",
            ".urdf:5",
            "right_knee",
            "this joint is called right_knee_pitch in strutter.yaml, and no actuator group selects it by the name that "
            "it has here",
        )
    ]


FIXED = '<link name="head"/><joint name="head_yaw" type="fixed"><parent link="trunk"/><child link="head"/></joint>'
MIMIC = (
    '<link name="claw"/><joint name="left_claw" type="revolute"><parent link="trunk"/><child link="claw"/>'
    '<limit lower="-1" upper="1" effort="1" velocity="1"/><mimic joint="left_hip_pitch"/></joint>'
)
WHEEL = '<link name="w"/><joint name="left_caster" type="continuous"><parent link="trunk"/><child link="w"/></joint>'
HAND = (
    '<link name="h"/><joint name="left_hand" type="revolute"><parent link="trunk"/><child link="h"/>'
    '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
)


@pytest.mark.parametrize(
    ("model", "name"),
    [
        # The model has none of the hand; the joint is fixed there; the model's own are driven by others, or by none.
        ("", "left_hand_thumb"),
        (FIXED, "head_yaw"),
        (MIMIC, "left_claw_joint"),
        (WHEEL, "left_caster_wheel"),
        (HAND + WHEEL + MIMIC, ""),
    ],
)
def test_parts_of_a_robot_are_not_misnamed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, model: str, name: str
) -> None:
    deploy = f"joint_names: [{', '.join((*NAMES, name) if name else NAMES)}]\n"
    deploy += "kp: [50, 60, 50, 60, 9]\nkd: [1.5, 2, 1.5, 2, 1]\n" if name else "kp: [50, 60, 50, 60]\n"
    assert _told(tmp_path, monkeypatch, _urdf=_urdf(more=model), _py=_config(), _yaml=deploy) == []


def test_a_joint_that_the_deploy_file_drives_is_in_no_group(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    told = _told(tmp_path, monkeypatch, _urdf=_urdf(), _py=_config('"left_knee_pitch"'), _yaml=_deploy())
    assert [one[:3] for one in told] == [("CFG102", ".py:5", "right_knee_pitch")]
    assert told[0][3] == (
        "strutter.yaml drives this joint, left_knee_pitch is in a group, and no actuator group selects it: it swings "
        "freely"
    )


def test_a_joint_that_another_configuration_selects(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A base, and the whole robot in the same file."""
    both = _config('"left_knee_pitch"') + _config().replace("STRUTTER_CFG", "STRUTTER_WHOLE_CFG")
    assert _told(tmp_path, monkeypatch, _urdf=_urdf(), _py=both, _yaml=_deploy()) == []


def test_a_joint_without_gains_may_be_in_no_group(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    deploy = _deploy(kp="50, 60, 50, 0").replace("1.5, 2]", "1.5, 0]")
    told = _told(tmp_path, monkeypatch, _urdf=_urdf(), _py=_config('"left_knee_pitch"'), _yaml=deploy)
    # That the other knee has gains there is the deploy file's own matter.
    assert [one[0] for one in told] == ["SYM101"]


def test_kp_and_kd_are_exchanged(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    told = _told(tmp_path, monkeypatch, _urdf=_urdf(), _py=_config(kp=2.0, kd=60.0), _yaml=_deploy())
    # kd over kp: 60 / 2 = 30 s in the configuration, 2 / 60 = 0.033 s in the deploy file.
    assert [one[:3] for one in told] == [
        ("SRC103", ".py:9", "left_knee_pitch"),
        ("SRC103", ".py:9", "right_knee_pitch"),
    ]
    assert {one[3] for one in told} == {
        "kp and kd are exchanged: 2 N*m/rad and 60 N*m*s/rad here, 60 N*m/rad and 2 N*m*s/rad in r/strutter.yaml: with "
        "these a joint takes 30 s to follow its command"
    }


def test_of_gains_nearly_alike_nobody_knows_which_file_is_odd(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # 1.5 / 2 = 0.75 s and 2 / 1.5 = 1.3 s: small motors have either.
    deploy = _deploy(kp="50, 1.5, 50, 1.5")
    told = _told(tmp_path, monkeypatch, _urdf=_urdf(), _py=_config(kp=2.0, kd=1.5), _yaml=deploy)
    assert [one[:3] for one in told] == [
        ("SRC103", ".yaml:2", "left_knee_pitch"),
        ("SRC103", ".yaml:2", "right_knee_pitch"),
    ]
    assert told[0][3].endswith(
        "1.5 N*m/rad and 2 N*m*s/rad here, 2 N*m/rad and 1.5 N*m*s/rad in r/strutter.py"
    )


POSE = 'init_state=ArticulationCfg.InitialStateCfg(joint_pos={".*_hip_pitch": 0.4, ".*_knee_pitch": -0.8}),'


@pytest.mark.parametrize(
    ("angles", "codes"),
    [
        ("0.4, -0.8, 0.4, -0.8", []),
        # The hips first, then the knees: as Isaac Lab has them. Two of the four stand elsewhere.
        ("0.4, 0.4, -0.8, -0.8", ["ORD102", "ORD102"]),
        # No order of the robot: each joint is told by itself.
        ("-0.8, 0.4, -0.8, 0.4", ["SRC106", "SRC106", "SRC106", "SRC106"]),
        ("0.4, 0.4, -0.8, -0.9", ["SRC106", "SRC106", "SRC106"]),
    ],
)
def test_a_pose_in_another_order_is_told_as_that(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, angles: str, codes: list[str]
) -> None:
    deploy = _deploy(more=f"default_angles: [{angles}]\n")
    told = _told(tmp_path, monkeypatch, _urdf=_urdf(), _py=_config(pose=POSE), _yaml=deploy)
    assert [one[0] for one in told] == codes
    if codes[:1] == ["ORD102"]:
        assert [one[2] for one in told] == ["left_knee_pitch", "right_hip_pitch"]
        assert told[0][3] == (
            "default position: these are the figures of strutter.py in another order than the joint names here: they "
            "are in the order of Isaac Lab (breadth-first over strutter.urdf)"
        )


def test_a_misspelt_key_of_a_pose_is_told_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Not as a difference from the deploy file, nor as a position that the range of -2 to 1 rad has."""
    pose = POSE.replace("_knee_", "_kene_")
    deploy = _deploy(more="default_angles: [0.4, -0.8, 0.4, -0.8]\n")
    told = _told(tmp_path, monkeypatch, _urdf=_urdf(), _py=_config(pose=pose), _yaml=deploy)
    assert [one[:3] for one in told] == [
        ("ORD104", ".py:6", "left_knee_pitch"),
        ("ORD104", ".py:6", "right_knee_pitch"),
    ]
    assert {one[3] for one in told} == {
        "the key '.*_kene_pitch' of joint_pos matches no joint of strutter.urdf, and none is for this one: the cfg "
        "raises a ValueError"
    }


def _mjcf(*motors: str) -> str:
    leg = (
        '<body><joint name="{0}_thigh_joint"/><geom size="0.1"/><body pos="0 0 -1"><joint name="{0}_calf_joint"/>'
        '<geom size="0.1"/></body></body>'
    )
    lines = "\n".join(
        f'<motor name="{name}" joint="{joint}" forcerange="-{limit} {limit}"/>'
        for name, joint, limit in (motor.split() for motor in motors)
    )
    body = leg.format("FR") + leg.format("FL")
    return f'<mujoco model="b"><worldbody>{body}</worldbody><actuator>\n{lines}\n</actuator></mujoco>'


RIGHT = ("FR_thigh FR_thigh_joint 200", "FR_calf FR_calf_joint 300")


ON_THIGH = "FL_calf FL_thigh_joint 300"
LEFT = "FL_thigh FL_thigh_joint 200"


@pytest.mark.parametrize(
    ("motors", "told"),
    [
        ((*RIGHT, "FL_thigh FL_thigh_joint 200", "FL_calf FL_calf_joint 300"), []),
        ((*RIGHT, LEFT, ON_THIGH), [("ORD103", ".xml:5", "FL_thigh_joint")]),
        # By its name the first of the two is the other joint's.
        ((*RIGHT, ON_THIGH, LEFT), [("ORD103", ".xml:4", "FL_thigh_joint")]),
        # A knee that nothing drives, and thighs with two motors each.
        ((*RIGHT, "FL_thigh FL_thigh_joint 200"), []),
        (("a FR_thigh_joint 100", "b FR_thigh_joint 100", "c FL_thigh_joint 100", "d FL_thigh_joint 100"), []),
    ],
)  # fmt: skip
def test_two_motors_on_one_joint_and_none_on_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, motors: tuple[str, ...], told: list[tuple[str, str, str]]
) -> None:
    found = _told(tmp_path, monkeypatch, _xml=_mjcf(*motors))
    assert [one[:3] for one in found] == told
    if told:
        assert found[0][3] == (
            "a second motor drives this joint, and none drives FL_calf_joint, while FR_calf_joint has one"
        )


def test_in_a_folder_all_of_it_is_a_note(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    motors = (*RIGHT, "FL_thigh FL_thigh_joint 200", "FL_calf FL_thigh_joint 300")
    assert _told(tmp_path, monkeypatch, named=False, _xml=_mjcf(*motors)) == []
