"""The Go2's model: published masses and limits, and a stance on its feet."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.robots.published import ROBOTS, Link, Published, tensor

mujoco = pytest.importorskip("mujoco")

LEGS = ("FR", "FL", "RR", "RL")
JOINTS = [f"{leg}_{part}_joint" for leg in LEGS for part in ("hip", "thigh", "calf")]


def _links() -> list[Link]:
    """Each link, as the URDF publishes those of the front left leg, mirrored here by rule: y -> -y flips com y,
    ixy, iyz; x -> -x (hips only) flips com x, ixy, ixz."""
    small = tensor(9.6e-6, 9.6e-6, 9.6e-6, 0, 0, 0)
    # The rotor's axis is the joint's: x at the hip, y at thigh and calf.
    rotor_x = tensor(1.11842e-4, 5.9647e-5, 5.9647e-5, 0, 0, 0)
    rotor_y = tensor(5.9647e-5, 1.11842e-4, 5.9647e-5, 0, 0, 0)
    base = tensor(0.02448, 0.098077, 0.107, 0.00012166, 0.0014849, -3.12e-5)
    links: list[Link] = [
        ("base", 6.921, (0.021112, 0.0, -0.005366), base),
        ("Head_upper", 0.001, (0.0, 0.0, 0.0), small),
        ("Head_lower", 0.001, (0.0, 0.0, 0.0), small),
    ]
    for leg in LEGS:
        y = 1.0 if leg[1] == "L" else -1.0
        x = 1.0 if leg[0] == "F" else -1.0
        hip = tensor(0.00048, 0.000884, 0.000596, -3.01e-6 * x * y, 1.11e-6 * x, -1.42e-6 * y)
        thigh = tensor(0.00584, 0.0058, 0.00103, 8.72e-5 * y, -0.000289, 0.000808 * y)
        calf = tensor(0.00108, 0.0011, 3.29e-5, 3.4e-7 * y, 1.72e-5, 8.28e-6 * y)
        links += [
            (f"{leg}_hip", 0.678, (-0.0054 * x, 0.00194 * y, -0.000105), hip),
            (f"{leg}_thigh", 1.152, (-0.00374, -0.0223 * y, -0.0327), thigh),
            (f"{leg}_calf", 0.154, (0.00548, -0.000975 * y, -0.115), calf),
            (f"{leg}_foot", 0.04, (0.0, 0.0, 0.0), small),
            (f"{leg}_hip_rotor", 0.089, (0.0, 0.0, 0.0), rotor_x),
            (f"{leg}_thigh_rotor", 0.089, (0.0, 0.0, 0.0), rotor_y),
            (f"{leg}_calf_rotor", 0.089, (0.0, 0.0, 0.0), rotor_y),
        ]
    return links


# base 6.921 + head 0.002 + 4 legs x (0.678 + 1.152 + 0.154 + 0.04 + 3 rotors x 0.089 = 2.291)
MODEL = Published(
    "go2", "unitree_ros/robots/go2_description/urdf/go2_description.urdf", "base", JOINTS, _links(), 16.087,
    [23.7, 23.7, 45.43] * 4,
)  # fmt: skip
"""Order FR, FL, RR, RL and hip, thigh, calf; the knee's motors stronger."""


@pytest.fixture(scope="module")
def model() -> Any:
    """The robot alone, as written."""
    return MODEL.ours


@pytest.mark.parametrize(
    ("joint", "low", "high"),
    [
        ("FL_hip_joint", -60.0, 60.0),
        ("FR_thigh_joint", -90.0, 200.0),
        ("RR_thigh_joint", -30.0, 260.0),
        ("RL_calf_joint", -156.0, -48.0),
    ],
    ids=["hip", "front thigh", "rear thigh", "calf"],
)
def test_ranges(model: Any, joint: str, low: float, high: float) -> None:
    """Joint ranges are whole degrees, which the URDF rounds to 0.1 mrad."""
    assert np.degrees(model.joint(joint).range) == pytest.approx([low, high], abs=6e-3)


@pytest.mark.parametrize("leg", LEGS)
def test_link_places(model: Any, leg: str) -> None:
    """Hip, thigh, calf, foot and rotors stand at their published offsets from their parents."""
    x, y = (1.0 if leg[0] == "F" else -1.0), (1.0 if leg[1] == "L" else -1.0)
    expected = {
        "hip": (0.1934 * x, 0.0465 * y, 0.0),
        "thigh": (0.0, 0.0955 * y, 0.0),
        "calf": (0.0, 0.0, -0.213),
        "foot": (0.0, 0.0, -0.213),
        "hip_rotor": (0.11215 * x, 0.04675 * y, 0.0),
        "thigh_rotor": (0.0, -0.00015 * y, 0.0),
        "calf_rotor": (0.0, -0.03235 * y, 0.0),
    }
    for part, offset in expected.items():
        assert model.body(f"{leg}_{part}").pos == pytest.approx(offset, abs=1e-12), part


def test_home_stands_on_its_feet() -> None:
    """At `home` the lowest feet touch the floor to within 2 mm, and nothing else does."""
    model = mujoco.MjModel.from_xml_path(str(ROBOTS / "go2" / "scene.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    gaps = [data.site(f"{leg}_foot").xpos[2] - 0.022 for leg in LEGS]
    assert abs(min(gaps)) < 2e-3
    assert data.ncon == 0
