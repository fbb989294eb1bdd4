"""The A1's model and spec: published masses and limits, and a stance that holds with the spec's numbers."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

mujoco = pytest.importorskip("mujoco")

ROOT = Path(__file__).parents[2]
ROBOTS = ROOT / "robots"
MODEL = ROBOTS / "a1" / "a1.xml"
SCENE = ROBOTS / "a1" / "scene.xml"

LEGS = ("FR", "FL", "RR", "RL")
JOINTS = [f"{leg}_{part}_joint" for leg in LEGS for part in ("hip", "thigh", "calf")]

NUMBER_TOLERANCE = 1e-9  # a transcription error is larger; MuJoCo's diagonalisation of an inertia is not
MASS_MATRIX_TOLERANCE = 1e-6  # relative to the largest entry of a block of the same unit
MUJOCO_VERSION = tuple(int(part) for part in mujoco.__version__.split(".")[:2])


def _corpus() -> Path | None:
    """Folder with vendor files, from ACTSPEC_CORPUS or `shared/corpus` beside or in the checkout."""
    given = os.environ.get("ACTSPEC_CORPUS")
    places = [Path(given)] if given else [ROOT / "shared" / "corpus", ROOT.parent / "shared" / "corpus"]
    return next((place for place in places if place.is_dir()), None)


def _number(given: Any) -> float:
    """The figure of a spec value that is written in SI."""
    text = given["value"] if isinstance(given, dict) else given
    factor = 1e-3 if str(text).endswith(" ms") else 1.0
    return float(str(text).split()[0]) * factor


def _legs(name: str) -> dict[str, Any]:
    """Group `legs` of a spec."""
    legs: dict[str, Any] = _spec(name)["actuators"]["legs"]
    return legs


def _spec(name: str) -> dict[str, Any]:
    spec: dict[str, Any] = yaml.safe_load((ROBOTS / f"{name}.yaml").read_text(encoding="utf-8"))
    return spec


def _inertia(model: Any, body: int) -> np.ndarray:
    """3 x 3 inertia of a body about its centre of mass, axes of the body [kg*m^2]."""
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.body_iquat[body])
    matrix = rotation.reshape(3, 3)
    return matrix @ np.diag(model.body_inertia[body]) @ matrix.T


def _tensor(xx: float, yy: float, zz: float, xy: float, xz: float, yz: float) -> np.ndarray:
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def _links() -> list[tuple[str, float, tuple[float, float, float], np.ndarray]]:
    """Name, mass, centre of mass and inertia of each link, as the URDF publishes them for the front left
    leg, mirrored here by rule: y -> -y flips com y, ixy, iyz; x -> -x (hips only) flips com x, ixy, ixz."""
    foot = _tensor(9.6e-6, 9.6e-6, 9.6e-6, 0, 0, 0)
    links = [
        (
            "trunk",
            6.0,
            (0.0, 0.0041, -0.0005),
            _tensor(0.0158533, 0.0377999, 0.0456542, -3.66e-5, -6.11e-5, -2.75e-5),
        ),
        ("imu_link", 0.001, (0.0, 0.0, 0.0), _tensor(1e-4, 1e-4, 1e-4, 0, 0, 0)),
    ]
    for leg in LEGS:
        y = 1.0 if leg[1] == "L" else -1.0
        x = 1.0 if leg[0] == "F" else -1.0
        links += [
            (
                f"{leg}_hip",
                0.696,
                (-0.003311 * x, 0.000635 * y, 3.1e-5),
                _tensor(0.000469246, 0.00080749, 0.000552929, -9.409e-6 * x * y, -3.42e-7 * x, -4.66e-7 * y),
            ),
            (
                f"{leg}_thigh",
                1.013,
                (-0.003237, -0.022327 * y, -0.027326),
                _tensor(0.005529065, 0.005139339, 0.001367788, 4.825e-6 * y, 0.000343869, 2.2448e-5 * y),
            ),
            (
                f"{leg}_calf",
                0.166,
                (0.006435, 0.0, -0.107388),
                _tensor(0.002997972, 0.003014022, 3.2426e-5, 0, -0.000141163, 0),
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
    """Unitree's URDF with a free base, read by MuJoCo from stated inertias only."""
    corpus = _corpus()
    path = corpus / "unitree_ros/robots/a1_description/urdf/a1.urdf" if corpus else None
    if path is None or not path.is_file():
        pytest.skip("no vendor files: set ACTSPEC_CORPUS")
    text = path.read_text(encoding="utf-8")
    # Meshes are not there; and from the shapes MuJoCo would give the massless shoulder links 0.169 kg each.
    text = re.sub(r"<(visual|collision)>.*?</\1>", "", text, flags=re.DOTALL)
    text, count = re.subn(r'(<joint name="floating_base" type=)"fixed"', r'\1"floating"', text)
    assert count == 1
    return mujoco.MjModel.from_xml_string(text)


def _mass_matrix(model: Any, angles: np.ndarray) -> np.ndarray:
    """Mass matrix with the base at the origin, rows ordered base, then `JOINTS`."""
    data = mujoco.MjData(model)
    data.qpos[:] = 0.0
    data.qpos[3] = 1.0
    for name, angle in zip(JOINTS, angles, strict=True):
        data.qpos[model.joint(name).qposadr[0]] = angle
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    for column, unit in enumerate(np.eye(model.nv)):
        mujoco.mj_mulM(model, data, full[column], unit)
    order = [*range(6), *(int(model.joint(name).dofadr[0]) for name in JOINTS)]
    return full[np.ix_(order, order)]


def test_joints_actuators_and_sensors_keep_the_sdk_order(model: Any) -> None:
    """Joints, motors and joint sensors are ordered FR, FL, RR, RL and hip, thigh, calf."""
    assert [model.joint(i).name for i in range(model.njnt)] == ["root", *JOINTS]
    stems = [name.removesuffix("_joint") for name in JOINTS]
    assert [model.actuator(i).name for i in range(model.nu)] == stems
    assert model.actuator_trnid[:, 0].tolist() == [model.joint(name).id for name in JOINTS]
    sensors = [model.sensor(i).name for i in range(model.nsensor)]
    assert sensors == [
        *(f"{stem}_pos" for stem in stems),
        *(f"{stem}_vel" for stem in stems),
        *("imu_quat", "imu_gyro", "imu_acc"),
    ]


def test_motors_give_torque_within_the_published_limit(model: Any) -> None:
    """Each motor passes its control on as torque, limited to 33.5 N*m."""
    assert (model.actuator_gaintype == mujoco.mjtGain.mjGAIN_FIXED).all()
    assert (model.actuator_biastype == mujoco.mjtBias.mjBIAS_NONE).all()
    assert (model.actuator_gainprm[:, 0] == 1.0).all()
    assert (model.actuator_gear[:, 0] == 1.0).all()
    assert model.actuator_ctrllimited.all()
    assert model.actuator_ctrlrange.tolist() == [[-33.5, 33.5]] * 12


def test_model_has_no_passive_joint_values(model: Any) -> None:
    """Joint damping, friction, stiffness and armature are the spec's matter and 0 in the model."""
    for values in (model.dof_damping, model.dof_frictionloss, model.dof_armature, model.jnt_stiffness):
        assert not np.any(values)


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


@pytest.mark.parametrize(("name", "mass", "com", "inertia"), _links(), ids=[link[0] for link in _links()])
def test_link(model: Any, name: str, mass: float, com: tuple[float, ...], inertia: np.ndarray) -> None:
    """A link has its published mass, centre of mass and full inertia."""
    body = model.body(name).id
    assert model.body_mass[body] == pytest.approx(mass, abs=NUMBER_TOLERANCE)
    assert model.body_ipos[body] == pytest.approx(com, abs=NUMBER_TOLERANCE)
    np.testing.assert_allclose(_inertia(model, body), inertia, atol=NUMBER_TOLERANCE, rtol=0)


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
    if seed is None:
        angles = model.key("home").qpos[7:]
    else:
        limits = np.array([model.joint(name).range for name in JOINTS])
        angles = np.random.default_rng(seed).uniform(limits[:, 0], limits[:, 1])
    ours, theirs = _mass_matrix(model, angles), _mass_matrix(urdf_model, angles)
    for rows in (slice(0, 3), slice(3, 18)):
        for columns in (slice(0, 3), slice(3, 18)):
            scale = np.abs(theirs[rows, columns]).max()
            np.testing.assert_allclose(
                ours[rows, columns], theirs[rows, columns], atol=MASS_MATRIX_TOLERANCE * scale, rtol=0
            )


def test_limits_match_the_urdf(model: Any, urdf_model: Any) -> None:
    """The vendor's URDF has the same joint ranges and torque limits."""
    for index, name in enumerate(JOINTS):
        ours, theirs = model.joint(name), urdf_model.joint(name)
        assert ours.range == pytest.approx(theirs.range, abs=NUMBER_TOLERANCE)
        assert ours.axis == pytest.approx(theirs.axis)
        assert model.actuator_ctrlrange[index] == pytest.approx(urdf_model.jnt_actfrcrange[theirs.id])


def test_spec_friction_matches_the_urdf(urdf_model: Any) -> None:
    """The spec's passive friction is what the vendor's URDF states."""
    friction = _legs("a1")["friction"]
    dofs = [int(urdf_model.joint(name).dofadr[0]) for name in JOINTS]
    assert urdf_model.dof_frictionloss[dofs] == pytest.approx([_number(friction["coulomb"])] * 12)
    assert np.ravel(urdf_model.dof_damping[dofs])[:12] == pytest.approx([_number(friction["viscous"])] * 12)


def test_home_keyframe_is_the_spec_default_pose(model: Any) -> None:
    """The model's first keyframe and the spec's default pose say the same."""
    pose = {pattern: _number(value) for pattern, value in _spec("a1")["robot"]["default_pose"].items()}
    expected = []
    for name in JOINTS:
        matches = [value for pattern, value in pose.items() if re.fullmatch(pattern, name)]
        assert len(matches) == 1, name
        expected += matches
    assert model.key(0).name == "home"
    assert model.key(0).qpos[7:] == pytest.approx(expected)


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
    """No pose makes two links of the robot touch, so neighbours cannot push each other apart."""
    data = mujoco.MjData(model)
    limits = np.array([model.joint(name).range for name in JOINTS])
    for angles in np.random.default_rng(7).uniform(limits[:, 0], limits[:, 1], size=(50, 12)):
        data.qpos[7:] = angles
        mujoco.mj_forward(model, data)
        assert data.ncon == 0


def _standing_model(name: str, law: str) -> Any:
    """The scene with the spec's passive values at the joints and its gains and limits as actuators."""
    legs, spec = _legs(name), _spec(name)
    motor = spec["motors"][legs["motor"]]
    kp, kd, limit = (_number(legs[field]) for field in ("kp", "kd", "effort_limit"))
    scene = mujoco.MjSpec.from_file(str(SCENE))
    for joint in scene.joints:
        if joint.type == mujoco.mjtJoint.mjJNT_HINGE:
            joint.armature = _number(legs["armature"])
            joint.frictionloss = _number(legs["friction"]["coulomb"])
            viscous = _number(legs["friction"]["viscous"])
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
            line = [24, _number(motor["stall_torque"]), _number(motor["no_load_speed"])]
            actuator.set_to_dcmotor(
                motorconst=[0, 0],
                resistance=0,
                nominal=line,
                saturation=[limit, 0, 0],
                controller=[kp, 0, kd, 0, 0, 24],
                ctrlspec=int(mujoco.mjtCtrlInput.mjINPUT_POS),
            )
    scene.option.timestep = _number(spec["timing"]["physics_dt"])
    return scene.compile()


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


@pytest.mark.parametrize("name", ["a1", "a1_stiff", "go1", "g1"])
def test_every_figure_of_a_spec_names_a_listed_source(name: str) -> None:
    """Sources that figures name are listed, and all listed ones are named."""
    spec = _spec(name)
    named: set[str] = set()

    def visit(node: Any) -> None:
        if isinstance(node, dict):
            if "value" in node and node["value"] != "unknown":
                assert "source" in node, node
                named.add(node["source"])
            for value in node.values():
                visit(value)
        elif isinstance(node, list):
            for value in node:
                visit(value)

    visit({key: value for key, value in spec.items() if key != "sources"})
    assert named == set(spec["sources"])


@pytest.mark.parametrize(
    ("name", "group", "inertia", "effort", "kp", "kd"),
    [
        # I = 1.11842e-4 kg*m^2 x 6^2 = 4.026312e-3; kp = I (20 pi)^2 = I x 3947.8418;
        # kd = 2 x 2 x I x 20 pi = I x 251.32741
        ("go1", "hip_thigh", 4.026312e-3, 23.7, 15.8952, 1.01192),
        # x 1.5^2 = 9.059202e-3; 23.7 N*m x 1.5
        ("go1", "knee", 9.059202e-3, 35.55, 35.7643, 2.27683),
        # 0.139e-4 x 16^2 + 0.017e-4 x 4.5^2 + 0.169e-4 = 3.5584e-3 + 0.034425e-3 + 0.0169e-3
        ("g1", "arms", 3.609725e-3, 25.0, 14.2506, 0.907223),
        # 0.489e-4 x 14.31818^2 + 0.098e-4 x 3.181818^2 + 0.533e-4
        ("g1", "hip_pitch_yaw", 1.0177520e-2, 88.0, 40.1792, 2.55789),
        # 0.489e-4 x 22.5^2 + 0.109e-4 x 5^2 + 0.738e-4 = 24.755625e-3 + 0.2725e-3 + 0.0738e-3
        ("g1", "hip_roll_knee", 2.5101925e-2, 139.0, 99.0984, 6.30880),
        # 0.068e-4 x 25^2
        ("g1", "wrists", 4.25e-3, 5.0, 16.7783, 1.06814),
        # two motors n5020
        ("g1", "ankles", 7.21945e-3, 50.0, 28.5012, 1.81445),
        ("g1", "waist", 7.21945e-3, 50.0, 28.5012, 1.81445),
    ],
    ids=["go1-hip", "go1-knee", "g1-5020", "g1-7520-14", "g1-7520-22", "g1-4010", "g1-ankle", "g1-waist"],
)
def test_derived_gains(name: str, group: str, inertia: float, effort: float, kp: float, kd: float) -> None:
    """The Go1's and G1's figures lead to the gains and the action scale that mjlab trains with."""
    actuators = _spec(name)["actuators"][group]
    motor = _spec(name)["motors"][actuators["motor"]]
    reduction = _number(actuators.get("reduction", 1))
    motors = _number(actuators.get("motors_per_joint", 1))
    if "rotor_inertia" in motor:
        at_output = _number(motor["rotor_inertia"]) * _number(motor["gear_ratio"]) ** 2
    else:
        at_output = _number(motor["reflected_inertia"])
    omega = 2 * np.pi * _number(actuators["kp"]["frequency"])
    found = at_output * reduction**2 * motors
    assert found == pytest.approx(inertia, rel=1e-6)
    assert found * omega**2 == pytest.approx(kp, rel=1e-5)
    assert 2 * _number(actuators["kd"]["ratio"]) * found * omega == pytest.approx(kd, rel=1e-5)
    assert _number(motor["peak_torque"]) * reduction * motors == pytest.approx(effort)
    assert _number(actuators["action_scale"]) == pytest.approx(0.25 * effort / (found * omega**2), rel=1e-6)
