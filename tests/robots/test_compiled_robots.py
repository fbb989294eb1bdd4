"""The robots that ship, compiled and stepped: the A1 stands, Go1 and G1 are what mjlab trains."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from actspec import api, output
from actspec.runtime import mujoco as runtime

mujoco = pytest.importorskip("mujoco")

ROOT = Path(__file__).parents[2]
ROBOTS = ROOT / "robots"
INSTALLED = ".".join(mujoco.__version__.split(".")[:2])

FIGURES = 1e-5
"""Relative: mjlab's constants are worked out below to six digits."""


def compiled(name: str, folder: Path) -> Path:
    """Compile a robot for the installed MuJoCo and write it; the main file."""
    result = api.compile(ROBOTS / f"{name}.yaml", targets=[f"mujoco=={INSTALLED}"], output=str(folder))
    output.write(output.outputs(result))
    return folder / "mujoco" / Path(result.robot.path).name


@pytest.mark.parametrize("name", ["a1", "a1_stiff"])
def test_a1_stands_where_it_is_put(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    """Reset by the runtime, the compiled A1 stands for 10 s at its pose: up, level, still, where it was."""
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its log where it runs
    robot = compiled(name, tmp_path / "build")
    scene, count = re.subn('file="a1.xml"', f'file="{robot}"', (ROBOTS / "a1" / "scene.xml").read_text())
    assert count == 1
    (tmp_path / "scene.xml").write_text(scene)
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))
    data = mujoco.MjData(model)
    runtime.reset(model, data, "home")

    spec = api.load(ROBOTS / f"{name}.yaml")
    pose = {joint.joint: joint.default_position.require() for joint in api.resolve(spec).joints}
    for index in range(model.nu):
        joint = model.joint(model.actuator_trnid[index, 0]).name
        assert data.ctrl[index] == pytest.approx(pose[joint], abs=1e-9)
    start = data.qpos.copy()
    assert model.opt.timestep == 0.005

    poses, speeds = [], []
    for _ in range(2000):
        mujoco.mj_step(model, data)
        poses.append(data.qpos.copy())
        speeds.append(data.qvel.copy())
    assert not any(int(warning.number) for warning in data.warning)
    path, late = np.array(poses), np.array(speeds[-400:])
    # The soft gains let it sink and swing forward once before it rests.
    assert path[:, 2].min() > start[2] - 0.05
    # Rotation by at most 0.05 rad: |sin(angle / 2)| of the trunk's quaternion.
    assert np.linalg.norm(path[:, 4:7], axis=1).max() < np.sin(0.05)
    assert np.abs(path[:, :2] - start[:2]).max() < 0.06
    # The last 2 s: neither creep nor vibration.
    assert np.abs(late[:, :6]).max() < 0.02
    assert np.sqrt(np.mean(np.square(late[:, 6:]), axis=0)).max() < 0.05
    assert np.abs(path[-1] - path[-400])[:3].max() < 0.002


# kp, kd, effort limit, armature. With I below: kp = I (20 pi)^2 = I x 3947.8418, kd = 4 I x 20 pi = I x 251.32741
MJLAB = {
    # ROTOR_INERTIA 1.11842e-4 x HIP_GEAR_RATIO^2 = 36
    "go1": {
        r".*_(hip|thigh)_joint": (15.895243, 1.0119226, 23.7, 4.026312e-3),
        # x 1.5^2
        r".*_calf_joint": (35.764296, 2.2768258, 35.55, 9.059202e-3),
    },
    "g1": {
        # 5020: 0.139e-4 x 16^2 + 0.017e-4 x 4.5^2 + 0.169e-4
        r".*_(shoulder_\w+|elbow|wrist_roll)_joint": (14.250623, 0.90722284, 25.0, 3.609725e-3),
        # 7520_14: 0.489e-4 x 14.318182^2 + 0.098e-4 x 3.1818182^2 + 0.533e-4
        r"(.*_hip_(pitch|yaw)|waist_yaw)_joint": (40.179238, 2.5578897, 88.0, 1.0177520e-2),
        # 7520_22: 0.489e-4 x 22.5^2 + 0.109e-4 x 5^2 + 0.738e-4
        r".*_(hip_roll|knee)_joint": (99.098427, 6.3088018, 139.0, 2.5101925e-2),
        # 4010: 0.068e-4 x 25^2
        r".*_wrist_(pitch|yaw)_joint": (16.778328, 1.0681415, 5.0, 4.25e-3),
        # two 5020 each
        r"(waist_(pitch|roll)|.*_ankle_(pitch|roll))_joint": (28.501246, 1.8144457, 50.0, 7.21945e-3),
    },
}
JOINTS = {"go1": 12, "g1": 29}


@pytest.mark.parametrize("name", MJLAB)
def test_compiled_robot_is_mjlabs(name: str, tmp_path: Path, mjlab_installed: Path) -> None:
    """With its real meshes the file loads, and every joint has the gains, limit and armature of mjlab."""
    model = mujoco.MjModel.from_xml_path(str(compiled(name, tmp_path)))
    assert model.nmesh >= 5
    assert model.nu == JOINTS[name]
    seen = 0
    for index in range(model.nu):
        joint = model.joint(model.actuator_trnid[index, 0])
        (row,) = [row for pattern, row in MJLAB[name].items() if re.fullmatch(pattern, joint.name)]
        kp, kd, effort, armature = row
        found: Any = model.actuator_biasprm[index]
        assert model.actuator_gainprm[index, 0] == pytest.approx(kp, rel=FIGURES)
        assert -found[1] == pytest.approx(kp, rel=FIGURES)
        assert -found[2] == pytest.approx(kd, rel=FIGURES)
        assert model.actuator_forcerange[index] == pytest.approx([-effort, effort], rel=1e-12)
        assert model.dof_armature[joint.dofadr[0]] == pytest.approx(armature, rel=1e-6)
        assert model.actuator_gear[index].tolist() == [1.0, 0, 0, 0, 0, 0]
        seen += 1
    assert seen == JOINTS[name]


@pytest.mark.parametrize("name", MJLAB)
def test_only_drives_differ_from_mjlabs_model(name: str, tmp_path: Path, mjlab_installed: Path) -> None:
    """Bodies, masses, meshes and contacts are those of the file that mjlab ships."""
    result = api.compile(ROBOTS / f"{name}.yaml", targets=[f"mujoco=={INSTALLED}"], output=str(tmp_path))
    before = mujoco.MjModel.from_xml_path(result.robot.path)
    after = mujoco.MjModel.from_xml_path(str(compiled(name, tmp_path)))
    for field in (
        "body_mass",
        "body_inertia",
        "body_pos",
        "jnt_range",
        "geom_type",
        "geom_size",
        "mesh_vert",
    ):
        np.testing.assert_array_equal(getattr(before, field), getattr(after, field), err_msg=field)
