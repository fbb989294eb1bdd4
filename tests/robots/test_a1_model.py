"""The A1's model and spec: published masses and limits, and a stance that holds with the spec's numbers."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.robots.published import (
    NUMBER_TOLERANCE,
    ROBOTS,
    Link,
    check_bare_motors,
    check_limits,
    check_links,
    check_mass_matrix,
    check_no_self_collision,
    number,
    pose,
    poses,
    spec_of,
    tensor,
    vendor_model,
)

mujoco = pytest.importorskip("mujoco")

MODEL = ROBOTS / "a1" / "a1.xml"
SCENE = ROBOTS / "a1" / "scene.xml"

LEGS = ("FR", "FL", "RR", "RL")
JOINTS = [f"{leg}_{part}_joint" for leg in LEGS for part in ("hip", "thigh", "calf")]
MUJOCO_VERSION = tuple(int(part) for part in mujoco.__version__.split(".")[:2])


def _legs(name: str) -> dict[str, Any]:
    """Group `legs` of a spec."""
    legs: dict[str, Any] = spec_of(name)["actuators"]["legs"]
    return legs


def _links() -> list[Link]:
    """Name, mass, centre of mass and inertia of each link, as the URDF publishes them for the front left
    leg, mirrored here by rule: y -> -y flips com y, ixy, iyz; x -> -x (hips only) flips com x, ixy, ixz."""
    foot = tensor(9.6e-6, 9.6e-6, 9.6e-6, 0, 0, 0)
    links = [
        (
            "trunk",
            6.0,
            (0.0, 0.0041, -0.0005),
            tensor(0.0158533, 0.0377999, 0.0456542, -3.66e-5, -6.11e-5, -2.75e-5),
        ),
        ("imu_link", 0.001, (0.0, 0.0, 0.0), tensor(1e-4, 1e-4, 1e-4, 0, 0, 0)),
    ]
    for leg in LEGS:
        y = 1.0 if leg[1] == "L" else -1.0
        x = 1.0 if leg[0] == "F" else -1.0
        links += [
            (
                f"{leg}_hip",
                0.696,
                (-0.003311 * x, 0.000635 * y, 3.1e-5),
                tensor(0.000469246, 0.00080749, 0.000552929, -9.409e-6 * x * y, -3.42e-7 * x, -4.66e-7 * y),
            ),
            (
                f"{leg}_thigh",
                1.013,
                (-0.003237, -0.022327 * y, -0.027326),
                tensor(0.005529065, 0.005139339, 0.001367788, 4.825e-6 * y, 0.000343869, 2.2448e-5 * y),
            ),
            (
                f"{leg}_calf",
                0.166,
                (0.006435, 0.0, -0.107388),
                tensor(0.002997972, 0.003014022, 3.2426e-5, 0, -0.000141163, 0),
            ),
            (f"{leg}_foot", 0.06, (0.0, 0.0, 0.0), foot),
        ]
    return links


@pytest.fixture(scope="module")
def model() -> Any:
    """The robot alone, as written."""
    return mujoco.MjModel.from_xml_path(str(MODEL))


@pytest.fixture(scope="module")
def urdf_model() -> Any:
    """Unitree's URDF with a free base."""
    return vendor_model("unitree_ros/robots/a1_description/urdf/a1.urdf", "base")


def test_motors_and_sensors(model: Any) -> None:
    """Order FR, FL, RR, RL and hip, thigh, calf; ideal torque motors of 33.5 N*m; nothing passive at the joints."""
    check_bare_motors(model, JOINTS, ["imu_quat", "imu_gyro", "imu_acc"])
    assert model.actuator_ctrlrange.tolist() == [[-33.5, 33.5]] * 12


@pytest.mark.parametrize(
    ("part", "low", "high"),
    # 46, -60 .. 240, -154.5 .. -52.5 degrees
    [("hip", -46.0, 46.0), ("thigh", -60.0, 240.0), ("calf", -154.5, -52.5)],
    ids=["hip", "thigh", "calf"],
)
def test_ranges(model: Any, part: str, low: float, high: float) -> None:
    """Joint ranges are the published degrees."""
    for leg in LEGS:
        assert np.degrees(model.joint(f"{leg}_{part}_joint").range) == pytest.approx([low, high], abs=1e-6)


def test_total_mass(model: Any) -> None:
    """The robot weighs 13.741 kg."""
    # trunk 6 + imu 0.001 + 4 legs x (0.696 + 1.013 + 0.166 + 0.06 = 1.935) = 6.001 + 7.740
    assert model.body_mass.sum() == pytest.approx(13.741, abs=NUMBER_TOLERANCE)


def test_links(model: Any) -> None:
    """Each link has its published mass, centre of mass and full inertia, and there is no other."""
    check_links(model, _links())


@pytest.mark.parametrize("leg", LEGS)
def test_link_lengths(model: Any, leg: str) -> None:
    """Hip, thigh, calf and foot stand at their published offsets from their parents."""
    x, y = (0.1805 if leg[0] == "F" else -0.1805), (1.0 if leg[1] == "L" else -1.0)
    expected = {
        "hip": (x, 0.047 * y, 0.0),
        "thigh": (0.0, 0.0838 * y, 0.0),
        "calf": (0.0, 0.0, -0.2),
        "foot": (0.0, 0.0, -0.2),
    }
    for part, offset in expected.items():
        assert model.body(f"{leg}_{part}").pos == pytest.approx(offset, abs=NUMBER_TOLERANCE)


@pytest.mark.parametrize("seed", [None, 1, 2, 3, 4], ids=["home", "pose1", "pose2", "pose3", "pose4"])
def test_mass_matrix_matches_the_urdf(model: Any, urdf_model: Any, seed: int | None) -> None:
    """The vendor's URDF, compiled by MuJoCo, has the same mass matrix."""
    check_mass_matrix(model, urdf_model, JOINTS, poses(model, JOINTS, seed))


def test_limits_match_the_urdf(model: Any, urdf_model: Any) -> None:
    """The vendor's URDF has the same joint ranges and torque limits."""
    check_limits(model, urdf_model, JOINTS)


def test_spec_friction_matches_the_urdf(urdf_model: Any) -> None:
    """The spec's passive friction is what the vendor's URDF states."""
    friction = _legs("a1")["friction"]
    dofs = [int(urdf_model.joint(name).dofadr[0]) for name in JOINTS]
    assert urdf_model.dof_frictionloss[dofs] == pytest.approx([number(friction["coulomb"])] * 12)
    assert np.ravel(urdf_model.dof_damping[dofs])[:12] == pytest.approx([number(friction["viscous"])] * 12)


def test_home_keyframe_is_the_spec_default_pose(model: Any) -> None:
    """The model's first keyframe and the spec's default pose say the same."""
    assert model.key(0).name == "home"
    assert model.key(0).qpos[7:] == pytest.approx(pose(spec_of("a1"), JOINTS))


@pytest.mark.parametrize("key", ["home", "crouch"])
def test_keyframe_stands_on_its_feet(key: str) -> None:
    """At a keyframe the lowest feet touch the floor to within 2 mm, and nothing else does."""
    model = mujoco.MjModel.from_xml_path(str(SCENE))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key(key).id)
    mujoco.mj_forward(model, data)
    gaps = [data.site(f"{leg}_foot").xpos[2] - 0.02 for leg in LEGS]
    assert abs(min(gaps)) < 2e-3
    assert data.ncon == 0


def test_links_never_collide_with_each_other(model: Any) -> None:
    """No pose makes two links of the robot touch."""
    check_no_self_collision(model)


def _standing_model(name: str, law: str) -> Any:
    """The scene with the spec's passive values at the joints and its gains and limits as actuators."""
    legs, spec = _legs(name), spec_of(name)
    motor = spec["motors"][legs["motor"]]
    kp, kd, limit = (number(legs[field]) for field in ("kp", "kd", "effort_limit"))
    scene = mujoco.MjSpec.from_file(str(SCENE))
    for joint in scene.joints:
        if joint.type == mujoco.mjtJoint.mjJNT_HINGE:
            joint.armature = number(legs["armature"])
            joint.frictionloss = number(legs["friction"]["coulomb"])
            viscous = number(legs["friction"]["viscous"])
            joint.damping = viscous if MUJOCO_VERSION < (3, 7) else [viscous, 0, 0]
    for actuator in scene.actuators:
        actuator.ctrllimited = mujoco.mjtLimited.mjLIMITED_FALSE
        actuator.ctrlrange = [0, 0]
        if law == "position":
            actuator.gainprm[0] = kp
            actuator.biastype = mujoco.mjtBias.mjBIAS_AFFINE
            actuator.biasprm[1], actuator.biasprm[2] = -kp, -kd
            actuator.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
            actuator.forcerange = [-limit, limit]
        else:
            line = [24, number(motor["stall_torque"]), number(motor["no_load_speed"])]
            actuator.set_to_dcmotor(
                motorconst=[0, 0],
                resistance=0,
                nominal=line,
                saturation=[limit, 0, 0],
                controller=[kp, 0, kd, 0, 0, 24],
                ctrlspec=int(mujoco.mjtCtrlInput.mjINPUT_POS),
            )
    scene.option.timestep = number(spec["timing"]["physics_dt"])
    return scene.compile()


@pytest.mark.slow
@pytest.mark.parametrize("law", ["position", "dcmotor"])
@pytest.mark.parametrize("name", ["a1", "a1_stiff"])
def test_stands(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, law: str) -> None:
    """With the spec's numbers the robot stands for 10 s: up, level, on its feet and without vibration."""
    if law == "dcmotor" and MUJOCO_VERSION < (3, 12):
        pytest.skip("torque-space dcmotor needs MuJoCo 3.12")
    monkeypatch.chdir(tmp_path)  # MuJoCo writes its log where it runs
    model = _standing_model(name, law)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, model.key("home").id)
    data.ctrl[:] = data.qpos[7:]
    steps = round(10.0 / model.opt.timestep)
    last = round(2.0 / model.opt.timestep)
    heights, tilts, speeds = [], [], []
    for _ in range(steps):
        mujoco.mj_step(model, data)
        heights.append(float(data.qpos[2]))
        tilts.append(float(np.degrees(np.arccos(np.clip(data.body("trunk").xmat[8], -1.0, 1.0)))))
        speeds.append(data.qvel[6:].copy())
    assert np.isfinite(data.qpos).all() and np.isfinite(data.qvel).all()
    assert not any(int(warning.number) for warning in data.warning)
    settled = heights[-1]
    assert min(heights) > 0.2
    assert max(abs(height - settled) for height in heights) < 0.05
    assert max(tilts) < 10.0
    assert np.sqrt(np.mean(np.square(speeds[-last:]), axis=0)).max() < 0.1
    touching = {model.geom(int(geom)).name for contact in data.contact for geom in contact.geom}
    assert touching == {"floor", *(f"{leg}_foot_collision" for leg in LEGS)}
