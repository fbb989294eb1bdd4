"""What is told of files that somebody named, and at most as a note of those of a folder."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.settings import Settings
from actspec.cli.main import main

URDF = """<robot name="leg"><link name="base"/><link name="thigh"/><link name="shank"/>
<joint name="hip" type="revolute"><parent link="base"/><child link="thigh"/>
<limit lower="-1" upper="1" effort="24" velocity="30"/></joint>
<joint name="knee" type="revolute"><parent link="thigh"/><child link="shank"/>
<limit lower="-2.7" upper="-0.8" effort="36" velocity="20"/></joint></robot>"""

MJCF = """<mujoco model="leg"><compiler angle="radian"/><worldbody><body>
<joint name="hip" range="-1 1"/><geom size="0.1"/><body>
<joint name="knee" range="-2.7 -0.8"/><geom size="0.1"/></body></body></worldbody><actuator>
<position joint="hip" kp="30" kv="0.8" forcerange="-24 24"/>
<position joint="knee" kp="30" kv="0.8"{range}/></actuator></mujoco>"""

HIP = (
    'DCMotorCfg(joint_names_expr=["{hip}"], effort_limit=24.0, saturation_effort=24.0, velocity_limit=30.0, '
)
KNEE = (
    'DCMotorCfg(joint_names_expr=["{knee}"], effort_limit=36.0, saturation_effort=36.0, velocity_limit=20.0, '
)
GAINS = "stiffness=30.0, damping={damping}, armature={armature})"

DEPLOY = "joint_names: [hip, knee]\nkp: [30, 30]\nkd: [0.8, 0.8]\ndefault_angles: [0.0, {pose}]\n"


def _config(*groups: str, pose: float = -1.5) -> str:
    body = ", ".join(f'"g{place}": {group}' for place, group in enumerate(groups))
    return (
        "from isaaclab.actuators import DCMotorCfg\nfrom isaaclab.assets import ArticulationCfg\n"
        "LEG_CFG = ArticulationCfg(init_state=ArticulationCfg.InitialStateCfg(\n"
        f'    joint_pos={{"hip": 0.0, "knee": {pose}}}), actuators={{{body}}})\n'
    )


def _group(text: str, damping: float = 0.8, armature: float | None = 0.01, **names: str) -> str:
    return (text + GAINS).format(damping=damping, armature=armature, **names)


AGREE = (_group(HIP, hip="hip"), _group(KNEE, knee="knee"))


def _write(folder: Path, *, config: str, forces: str = ' forcerange="-36 36"', pose: float = -1.5) -> None:
    (folder / "r").mkdir(exist_ok=True)
    (folder / "r/leg.urdf").write_text(URDF)
    (folder / "r/leg.xml").write_text(MJCF.format(range=forces))
    (folder / "r/leg_cfg.py").write_text(config)
    (folder / "r/leg_deploy.yaml").write_text(DEPLOY.format(pose=pose))


def _told(*, named: bool) -> set[tuple[str, str, str, str]]:
    """Code, file, joint and severity of warnings and errors."""
    return {
        (one.finding.code, Path(one.finding.span.path).name, one.finding.joint, one.severity.value)
        for one in audit(["r"], Settings(as_named=named)).findings
        if one.severity.value != "info"
    }


@pytest.mark.parametrize(
    ("config", "forces", "pose", "told"),
    [
        (_config(*AGREE), ' forcerange="-36 36"', -1.5, set()),
        # The hip has a limit in the model, and the knee none.
        (_config(*AGREE), "", -1.5, {("LIM101", "leg.xml", "knee", "warning")}),
        # Ten times the damping of the deploy file and the MJCF.
        (
            _config(AGREE[0], _group(KNEE, damping=8.0, knee="knee")),
            ' forcerange="-36 36"',
            -1.5,
            {("SRC103", "leg_cfg.py", "knee", "warning")},
        ),
        # The sign of the pose, told at the file that has it wrong.
        (
            _config(*AGREE, pose=1.5),
            ' forcerange="-36 36"',
            -1.5,
            {("LIM111", "leg_cfg.py", "knee", "warning")},
        ),
        (_config(*AGREE), ' forcerange="-36 36"', 1.5, {("LIM111", "leg_deploy.yaml", "knee", "warning")}),
        # The knee's own group replaces that of all.
        (
            _config(_group(HIP, hip=".*"), AGREE[1]),
            ' forcerange="-36 36"',
            -1.5,
            {("ORD103", "leg_cfg.py", "knee", "warning")},
        ),
    ],
)
def test_a_folder_is_told_no_more(
    config: str,
    forces: str,
    pose: float,
    told: set[tuple[str, str, str, str]],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each fault is told once of files that are named, and of a folder as a note or not at all."""
    monkeypatch.chdir(tmp_path)
    _write(tmp_path, config=config, forces=forces, pose=pose)
    assert _told(named=True) == told
    assert _told(named=False) == set()


def test_a_group_that_takes_all_explains_what_the_joint_loses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The knee has 24 N*m of the last group, where the first gives it the 36 N*m of the URDF."""
    monkeypatch.chdir(tmp_path)
    _write(tmp_path, config=_config(AGREE[1], _group(HIP, hip=".*", armature=0.02)))
    assert _told(named=True) == {("ORD103", "leg_cfg.py", "knee", "error")}
    causes = {
        one.finding.code: one.cause.code
        for one in audit(["r"], Settings(as_named=True)).findings
        if one.cause is not None
    }
    assert causes["GEA101"] == "ORD103"


def test_the_last_group_has_the_joint_for_all(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """No kp of two groups together, 60, and what the last does not state is the first one's: armature 0.01."""
    monkeypatch.chdir(tmp_path)
    knee = KNEE + "stiffness=40.0, damping=None)"
    _write(tmp_path, config=_config(*AGREE))
    assert main(["lock", "r/leg_cfg.py", "r/leg.urdf"]) == 0
    _write(tmp_path, config=_config(_group(HIP, hip=".*"), knee.format(knee="knee")))
    capsys.readouterr()
    assert main(["lock", "--check"]) == 1
    said = capsys.readouterr().out
    assert "knee:\n    stiffness kp 30 -> 40 N*m/rad" in said
    assert "kd" not in said and "armature" not in said and "effort" not in said
    (row,) = (
        row
        for row in audit(["r"], Settings()).case.rows
        if row.joint == "knee" and row.file == "r/leg_cfg.py"
    )
    assert (row.kp, row.kd, row.armature, row.effort_limit) == (40.0, 0.8, 0.01, 36.0)
    assert [(one.actuator, one.kp) for one in row.overruled] == [("g0", 30.0)]
