"""Where what is published tells which file is wrong, every rule blames that one, in whatever order files are named."""

from __future__ import annotations

import json
from itertools import permutations
from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.settings import Settings
from actspec.diagnostics import Severity

KNOWN = Path(__file__).parents[2] / "robots" / "known.json"
LEGS = ("FL", "FR", "RL", "RR")


def _urdf(calf: str = 'effort="45.43" velocity="15.7"') -> str:
    """A Go2's joints; of the maker's figures those of the calves may be others."""
    text = '<robot name="go2_description"><link name="base"/>'
    for leg in LEGS:
        above = "base"
        for part in ("hip", "thigh", "calf"):
            limit = calf if part == "calf" else 'effort="23.7" velocity="30.1"'
            text += (
                f'<link name="{leg}_{part}"/><joint name="{leg}_{part}_joint" type="revolute">'
                f'<parent link="{above}"/><child link="{leg}_{part}"/><axis xyz="0 1 0"/>'
                f'<limit lower="-2.7" upper="2.7" {limit}/></joint>\n'
            )
            above = f"{leg}_{part}"
    return f"{text}</robot>"


_CFG = """
from isaaclab.actuators import DCMotorCfg
from isaaclab.assets import ArticulationCfg

GO2_CFG = ArticulationCfg(
    actuators={
        "hips": DCMotorCfg(
            joint_names_expr=[".*_hip_joint", ".*_thigh_joint"],
            effort_limit=23.7, saturation_effort=23.7, velocity_limit=30.1, stiffness=25.0, damping=0.5, friction=0.0,
        ),
        "knees": DCMotorCfg(
            joint_names_expr=[".*_calf_joint"],
            effort_limit=45.43, saturation_effort=45.43, velocity_limit=15.7, stiffness=25.0, damping=0.5, friction=0.0,
        ),
    },
)
"""


def _told(
    files: dict[str, str], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> set[frozenset[tuple[str, str, str]]]:
    """Code, severity and file of what is told above notes, for every order of the files."""
    monkeypatch.chdir(folder)
    for name, text in files.items():
        Path(name).write_text(text, encoding="utf-8")
    return {
        frozenset(
            (one.finding.code, one.severity.value, one.finding.span.path)
            for one in audit(order, Settings()).findings
            if one.severity is not Severity.INFO
        )
        for order in permutations(files)
    }


def test_speed_beside_a_torque_speed_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """15.7 rad/s is published, which the configuration has as its motors' no-load speed; 32 is 2.04 times that."""
    files = {"go2.urdf": _urdf('effort="45.43" velocity="32"'), "go2_cfg.py": _CFG}
    assert _told(files, tmp_path, monkeypatch) == {frozenset({("SRC102", "error", "go2.urdf")})}


def test_lower_speed_may_be_chosen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The largest speed that any source gives is no evidence against a lower one: which file departs is as before."""
    files = {"go2.urdf": _urdf('effort="45.43" velocity="7"'), "go2_cfg.py": _CFG}
    assert _told(files, tmp_path, monkeypatch) == {frozenset({("SRC102", "error", "go2_cfg.py")})}


def test_reduction_that_is_published(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """45.43 N*m is the maker's for the calf; 35.55, with the gear of 1.5, the maker states elsewhere."""
    files = {"a_go2.urdf": _urdf('effort="35.55" velocity="20.067"'), "b_go2.urdf": _urdf()}
    assert _told(files, tmp_path, monkeypatch) == {frozenset({("GEA101", "warning", "a_go2.urdf")})}


def test_limit_of_one_of_three(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A model of motors, whose controls reach the published torque, takes nothing from what the others show."""
    files = {
        "go2.urdf": _urdf('effort="454.3" velocity="15.7"'),
        "go2_cfg.py": _CFG,
        "go2.xml": _model(45.43),
    }
    assert _told(files, tmp_path, monkeypatch) == {frozenset({("SRC101", "error", "go2.urdf")})}


def _model(calf_limit: float, armature: float = 0.0) -> str:
    """A Go2's MJCF with motors."""
    body = "".join(
        f'<body><joint name="{leg}_hip_joint" range="-2.7 2.7"/><geom size="0.1"/>'
        f'<body><joint name="{leg}_thigh_joint" range="-2.7 2.7"/><geom size="0.1"/>'
        f'<body><joint name="{leg}_calf_joint" range="-2.7 2.7"/><geom size="0.1"/></body></body></body>'
        for leg in LEGS
    )
    motors = "".join(
        f'<motor joint="{leg}_{part}_joint" ctrlrange="-{limit} {limit}" ctrllimited="true"/>'
        for leg in LEGS
        for part, limit in (("hip", 23.7), ("thigh", 23.7), ("calf", calf_limit))
    )
    return (
        f'<mujoco model="go2"><compiler angle="radian"/><default><joint armature="{armature}"/></default><worldbody>'
        f'<body><geom size="0.1"/>{body}</body></worldbody><actuator>{motors}</actuator></mujoco>'
    )


def test_armature_that_is_published(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Unitree's MJCFs have 0.01 kg*m^2, which the configuration has; 0.03 nobody has."""
    config = _CFG.replace("friction=0.0", "friction=0.0, armature=0.01")
    files = {"go2.xml": _model(45.43, 0.03), "go2_cfg.py": config}
    assert _told(files, tmp_path, monkeypatch) == {frozenset({("SRC104", "warning", "go2.xml")})}


def test_armature_that_is_published_of_one_variant(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A 4010 at a G1's wrist has 0.00425 kg*m^2, a 5010 another; 0.003 is of neither, so the model departs."""
    motors = next(iter(json.loads(KNOWN.read_text())["unitree_g1"]["variants"].values()))
    joints = [joint for motor in motors for joint in motor["joints"]]
    wrists = ("_wrist_pitch_joint", "_wrist_yaw_joint")
    body = "".join(
        f'<body><joint name="{joint}" armature="{0.003 if joint.endswith(wrists) else 0.01}"/><geom size="0.1"/></body>'
        for joint in joints
    )
    model = f'<mujoco model="g1"><worldbody><body><geom size="0.1"/>{body}</body></worldbody></mujoco>'
    config = """
from isaaclab.actuators import ImplicitActuatorCfg
from isaaclab.assets import ArticulationCfg

G1_CFG = ArticulationCfg(
    actuators={
        "wrists": ImplicitActuatorCfg(
            joint_names_expr=[".*_wrist_pitch_joint", ".*_wrist_yaw_joint"],
            effort_limit_sim=5.0, stiffness=16.8, damping=1.07, armature=0.00425,
        ),
        "rest": ImplicitActuatorCfg(
            joint_names_expr=["(?!.*_wrist_(pitch|yaw)_joint).*"],
            effort_limit_sim=25.0, stiffness=40.0, damping=2.0, armature=0.01,
        ),
    },
)
"""
    told = _told({"g1.xml": model, "g1_cfg.py": config}, tmp_path, monkeypatch)
    assert {
        file for found in told for code, severity, file in found if (code, severity) == ("SRC104", "warning")
    } == {"g1.xml"}


def test_published_limit_lacks_no_gear(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All motors of an A1 have 33.5 N*m at 21 rad/s; the URDF's 64.2 at 10.96 are of no other gear."""
    urdf = _urdf('effort="64.2" velocity="10.96"').replace("go2_description", "a1")
    urdf = urdf.replace('effort="23.7" velocity="30.1"', 'effort="33.5" velocity="21"')
    config = _CFG.replace("GO2_CFG", "A1_CFG")
    for go2, a1 in (("23.7", "33.5"), ("45.43", "33.5"), ("30.1", "21.0"), ("15.7", "21.0")):
        config = config.replace(go2, a1)
    told = _told({"a1.urdf": urdf, "a1_cfg.py": config}, tmp_path, monkeypatch)
    assert told == {frozenset({("SRC101", "warning", "a1.urdf")})}


def _as_spot(text: str) -> str:
    """A Go2's file with joints and limits of a Spot, which others than its maker publish."""
    for leg, its in zip(LEGS, ("fl", "fr", "hl", "hr"), strict=True):
        for part, its_part in (("hip", "hx"), ("thigh", "hy"), ("calf", "kn")):
            text = text.replace(f"{leg}_{part}_joint", f"{its}_{its_part}")
    for part, its_part in (("hip", "hx"), ("thigh", "hy"), ("calf", "kn")):
        text = text.replace(f"_{part}_joint", f"_{its_part}")
    for go2, spot in (("go2_description", "spot"), ("GO2", "SPOT"), ("23.7", "45"), ("45.43", "112.8")):
        text = text.replace(go2, spot)
    return text.replace("30.1", "17.6").replace("15.7", "12.0")


def test_limit_that_nobody_publishes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Spot's maker publishes no limits of its hips, others 45 N*m, which the configuration has: 1000 is wrong."""
    files = {
        "spot.urdf": _as_spot(_urdf('effort="112.8" velocity="15.7"')).replace(
            'effort="45"', 'effort="1000"'
        ),
        "spot_cfg.py": _as_spot(_CFG),
    }
    assert _told(files, tmp_path, monkeypatch) == {frozenset({("SRC101", "error", "spot.urdf")})}


def test_limit_above_all_that_is_published(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """45.43 N*m is published for the calf: 30 may be chosen, 1000 is what KNW101 tells, and the 30 is not wrong too."""
    config = _CFG.replace("45.43", "30.0")
    files = {"go2.urdf": _urdf('effort="1000" velocity="15.7"'), "go2_cfg.py": config}
    assert _told(files, tmp_path, monkeypatch) == {frozenset({("SRC101", "error", "go2.urdf")})}


def test_lower_limit_that_others_publish(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What others than the maker publish tells nobody that a lower limit is wrong: which file departs is as before."""
    files = {
        "spot.urdf": _as_spot(_urdf('effort="112.8" velocity="15.7"')).replace('effort="45"', 'effort="20"'),
        "spot_cfg.py": _as_spot(_CFG),
    }
    assert _told(files, tmp_path, monkeypatch) == {frozenset({("SRC101", "error", "spot_cfg.py")})}
