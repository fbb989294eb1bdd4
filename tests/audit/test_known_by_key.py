"""Known robots in configurations whose dicts have narrower keys than the patterns of their groups."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.settings import Settings
from actspec.diagnostics import Severity

_KNW = Settings(select=("KNW101", "KNW102", "KNW103"))

_G1 = {
    ".*_hip_pitch_joint": 88.0,
    ".*_hip_roll_joint": 139.0,
    ".*_hip_yaw_joint": 88.0,
    ".*_knee_joint": 139.0,
    ".*_ankle_.*": 50.0,
    "waist_yaw_joint": 88.0,
    "waist_(roll|pitch)_joint": 50.0,
    ".*_shoulder_.*": 25.0,
    ".*_elbow_joint": 25.0,
    ".*_wrist_roll_joint": 25.0,
    ".*_wrist_pitch_joint": 5.0,
    ".*_wrist_yaw_joint": 5.0,
}
"""Published limits of the G1's machine type 5 [N*m]. Source: robots/known.json."""


def _config(robot: str, patterns: list[str], settings: Mapping[str, object], before: str = "") -> str:
    """A configuration of one group, each key on a line of its own, and what stands before that group."""
    lines = [
        "from isaaclab.actuators import ImplicitActuatorCfg",
        "from isaaclab.assets import ArticulationCfg",
        f"{robot}_CFG = ArticulationCfg(actuators={{ {before}",
        f"'all': ImplicitActuatorCfg(joint_names_expr={patterns}, stiffness=100.0, damping=5.0,",
    ]
    for name, value in settings.items():
        if isinstance(value, Mapping):
            lines += [f"{name}={{", *(f"{key!r}: {each}," for key, each in value.items()), "},"]
        else:
            lines.append(f"{name}={value},")
    return "\n".join([*lines, ")})", ""])


def _line(text: str, part: str) -> int:
    """The line of a text, counted from one."""
    return next(at for at, line in enumerate(text.splitlines(), 1) if part in line)


@pytest.mark.parametrize(
    "patterns", [[".*"], [".*_hip_.*", ".*_(knee|ankle|shoulder|elbow|wrist)_.*", "waist_.*"]]
)
def test_the_figure_of_a_key_below_a_broader_pattern(
    patterns: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At the key's own line; 300 / 139 is 2.158, 139 the largest of the hip pitch's 88 and 139 by machine type.

    Nothing is said of the revision, as no revision has 300 at the hip.
    """
    monkeypatch.chdir(tmp_path)
    text = _config("UNITREE_G1", patterns, {"effort_limit_sim": {**_G1, ".*_hip_pitch_joint": 300.0}})
    Path("g1.py").write_text(text)
    found = [item.finding for item in audit(["g1.py"], _KNW).findings]
    assert {(f.code, f.joint, f.span.line) for f in found} == {
        ("KNW101", f"{side}_hip_pitch_joint", _line(text, "hip_pitch_joint': 300.0"))
        for side in ("left", "right")
    }
    (message,) = {f.message for f in found}
    assert message == "the limit of 300 N*m is 2.16 times what is published for unitree_g1: 139 N*m"


def test_keys_tell_the_revision(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Types 5 and 13 differ in the wrists alone, 5 and 13.4 N*m; the pattern of the group does not hide them."""
    monkeypatch.chdir(tmp_path)
    Path("g1.py").write_text(_config("UNITREE_G1", [".*"], {"effort_limit_sim": _G1}))
    (found,) = [item.finding for item in audit(["g1.py"], _KNW).findings]
    assert found.message == (
        "the limits are those of unitree_g1 mode_5: hip_pitch 88 N*m, hip_roll 139 N*m, wrist_pitch 5 N*m, "
        "wrist_yaw 5 N*m"
    )


@pytest.mark.parametrize("as_named", [False, True])
def test_a_folder_is_no_excuse(as_named: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """900 / 320 is 2.8125 at the B2's calf."""
    monkeypatch.chdir(tmp_path)
    limits = {".*_hip_joint": 200.0, ".*_thigh_joint": 200.0, ".*_calf_joint": 900.0}
    Path("b2.py").write_text(_config("UNITREE_B2", [".*"], {"effort_limit_sim": limits}))
    found = audit(["b2.py" if as_named else "."], _KNW).findings
    assert {(item.finding.code, item.severity, item.finding.value) for item in found} == {
        ("KNW101", Severity.WARNING, 900.0)
    }
    assert {item.finding.joint for item in found} == {f"{leg}_calf_joint" for leg in ("FL", "FR", "RL", "RR")}


@pytest.mark.parametrize(
    ("limits", "before"),
    [
        pytest.param({".*_hip_.*": 300.0, **_G1}, "", id="two keys are for the hip, which Isaac Lab refuses"),
        pytest.param({".*_knee_joint": 139.0}, "", id="no key is for the others"),
        pytest.param(
            {**_G1, ".*_hip_pitch_joint": 300.0},
            "'hip': ImplicitActuatorCfg(joint_names_expr=['.*_hip_pitch_.*'], stiffness=1.0, damping=1.0),",
            id="another group has the joint too",
        ),
    ],
)
def test_what_nobody_can_tell(
    limits: Mapping[str, float], before: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A joint that several keys or none are for, or that another group's pattern selects, has no limit to judge."""
    monkeypatch.chdir(tmp_path)
    Path("g1.py").write_text(_config("UNITREE_G1", [".*"], {"effort_limit_sim": limits}, before))
    assert not audit(["g1.py"], Settings(select=("KNW101",))).findings


def test_one_limit_beside_keys_of_armatures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The limit is judged as the pattern's, in a folder too, whatever keys the armatures have.

    300 / 139 is 2.158 at the hips; 2.5 is 25 times 0.1, the largest armature that is published of a G1.
    """
    monkeypatch.chdir(tmp_path)
    armatures = {".*_hip_pitch_joint": 2.5, ".*_hip_roll_joint": 0.025, ".*_hip_yaw_joint": 0.01}
    others = (
        "'o': ImplicitActuatorCfg(joint_names_expr=['.*_(knee|ankle|shoulder|elbow|wrist)_.*', 'waist_.*'], "
        "stiffness=100.0, damping=5.0),"
    )
    hips = {"effort_limit_sim": 300.0, "armature": armatures}
    Path("g1.py").write_text(text := _config("UNITREE_G1", [".*_hip_.*"], hips, others))
    found = [(item.severity, item.finding) for item in audit(["."], _KNW).findings]
    assert [(severity, f.joint) for severity, f in found if f.code == "KNW101"] == [
        (Severity.WARNING, ".*_hip_.*")
    ]
    assert {(severity, f.joint, f.span.line) for severity, f in found if f.code == "KNW103"} == {
        (Severity.WARNING, f"{side}_hip_pitch_joint", _line(text, ": 2.5,")) for side in ("left", "right")
    }


def test_a_limit_of_zero_at_a_key(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two of 29 joints have none, and most have one."""
    monkeypatch.chdir(tmp_path)
    Path("g1.py").write_text(
        _config("UNITREE_G1", [".*"], {"effort_limit_sim": {**_G1, ".*_elbow_joint": 0.0}})
    )
    for path, severity in (("g1.py", Severity.WARNING), (".", Severity.INFO)):
        found = audit([path], Settings(select=("KNW101",))).findings
        assert {(item.finding.joint, item.finding.value, item.severity) for item in found} == {
            (f"{side}_elbow_joint", 0.0, severity) for side in ("left", "right")
        }
