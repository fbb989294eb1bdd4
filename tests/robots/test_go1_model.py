"""The Go1's model: published masses and limits, and a stance on its feet."""

from __future__ import annotations

from typing import Any

import pytest

from tests.robots.published import ROBOTS, Link, Published, tensor

mujoco = pytest.importorskip("mujoco")

LEGS = ("FR", "FL", "RR", "RL")
JOINTS = [f"{leg}_{part}_joint" for leg in LEGS for part in ("hip", "thigh", "calf")]
SENSORS = (
    *(f"camera_{place}" for place in ("face", "chin", "left", "right", "rearDown")),
    *(f"ultraSound_{place}" for place in ("left", "right", "face")),
)


def _links() -> list[Link]:
    """Each link, as the URDF publishes those of the front left leg, mirrored here by rule: y -> -y flips com y,
    ixy, iyz; x -> -x (hips only) flips com x, ixy, ixz. The calf is the same part on both sides."""
    micro = tensor(1e-6, 1e-6, 1e-6, 0, 0, 0)
    foot = tensor(9.6e-6, 9.6e-6, 9.6e-6, 0, 0, 0)
    # The rotor's axis is the joint's: x at the hip, y at thigh and calf.
    rotor_x = tensor(1.11842e-4, 5.9647e-5, 5.9647e-5, 0, 0, 0)
    rotor_y = tensor(5.9647e-5, 1.11842e-4, 5.9647e-5, 0, 0, 0)
    trunk = tensor(0.0168128557, 0.063009565, 0.0716547275, -0.0002296769, -0.0002945293, -4.18731e-5)
    calf = tensor(0.001088793059, 0.001100428748, 2.4787446e-5, -2.55679e-7, 7.117814e-6, 2.077264e-6)
    none = (0.0, 0.0, 0.0)
    links: list[Link] = [
        ("trunk", 5.204, (0.0223, 0.002, -0.0005), trunk),
        ("imu_link", 0.001, none, 100 * micro),
        *((name, 1e-5, none, micro) for name in SENSORS),
    ]
    for leg in LEGS:
        y = 1.0 if leg[1] == "L" else -1.0
        x = 1.0 if leg[0] == "F" else -1.0
        hip = tensor(
            0.000334008405,
            0.000619101213,
            0.00040057614,
            -1.0826066e-5 * x * y,
            1.290732e-6 * x,
            1.643194e-6 * y,
        )
        thigh = tensor(
            0.004431760472,
            0.004485671726,
            0.000740309489,
            5.7496807e-5 * y,
            -0.000218457134,
            0.000572001265 * y,
        )
        links += [
            (f"{leg}_hip", 0.591, (-0.005657 * x, -0.008752 * y, -0.000102), hip),
            (f"{leg}_thigh", 0.92, (-0.003342, -0.018054 * y, -0.033451), thigh),
            (f"{leg}_calf", 0.135862, (0.006197, 0.001408, -0.116695), calf),
            (f"{leg}_foot", 0.06, none, foot),
            (f"{leg}_hip_rotor", 0.089, none, rotor_x),
            (f"{leg}_thigh_rotor", 0.089, none, rotor_y),
            (f"{leg}_calf_rotor", 0.089, none, rotor_y),
        ]
    return links


# trunk 5.204 + imu 0.001 + 8 sensors x 1e-5
# + 4 legs x (0.591 + 0.92 + 0.135862 + 0.06 + 3 rotors x 0.089 = 1.973862)
MODEL = Published(
    "go1", "unitree_ros/robots/go1_description/urdf/go1.urdf", "base", JOINTS, _links(), 13.100528,
    [23.7, 23.7, 35.55] * 4,
)  # fmt: skip
"""Order FR, FL, RR, RL and hip, thigh, calf; the knee's motors stronger."""


@pytest.fixture(scope="module")
def model() -> Any:
    """The robot alone, as written."""
    return MODEL.ours


@pytest.mark.parametrize("leg", LEGS)
def test_link_places(model: Any, leg: str) -> None:
    """Hip, thigh, calf, foot and rotors stand at their published offsets from their parents."""
    x, y = (1.0 if leg[0] == "F" else -1.0), (1.0 if leg[1] == "L" else -1.0)
    expected = {
        "hip": (0.1881 * x, 0.04675 * y, 0.0),
        "thigh": (0.0, 0.08 * y, 0.0),
        "calf": (0.0, 0.0, -0.213),
        "foot": (0.0, 0.0, -0.213),
        "hip_rotor": (0.11215 * x, 0.04675 * y, 0.0),
        "thigh_rotor": (0.0, -0.00015 * y, 0.0),
        "calf_rotor": (0.0, -0.03235 * y, 0.0),
    }
    for part, offset in expected.items():
        assert model.body(f"{leg}_{part}").pos == pytest.approx(offset, abs=1e-12), part


def test_home_stands_on_its_feet() -> None:
    """At `home` the feet touch the floor to within 0.1 mm, and nothing else does."""
    model = mujoco.MjModel.from_xml_path(str(ROBOTS / "go1" / "scene.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    gaps = [data.site(f"{leg}_foot").xpos[2] - 0.02 for leg in LEGS]
    assert max(abs(gap) for gap in gaps) < 1e-4
    assert data.ncon == 0
