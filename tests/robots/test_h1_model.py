"""The H1's model: published masses and limits, and soles on the floor."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.robots.published import ROBOTS, Link, Published, check_ranges_mirror, tensor

mujoco = pytest.importorskip("mujoco")

SIDES = ("left", "right")
LEG = ("hip_yaw", "hip_roll", "hip_pitch", "knee", "ankle")
ARM = ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow")
JOINTS = [
    *(f"{side}_{part}_joint" for side in SIDES for part in LEG),
    "torso_joint",
    *(f"{side}_{part}_joint" for side in SIDES for part in ARM),
]

# Name: mass, com, and ixx, iyy, izz, ixy, ixz, iyz of the left side, as the URDF publishes them; its legs are
# given in 1e-6 kg*m^2.
MICRO = 1e-6
LEFT: dict[str, tuple[float, tuple[float, float, float], tuple[float, ...], float]] = {
    "hip_yaw": (
        2.965,
        (-0.061433, 0.000017, 0.007627),
        (5321.009, 5017.692, 4100.851, 2.253, -876.895, 1.134),
        MICRO,
    ),
    "hip_roll": (
        2.715,
        (-0.005276, -0.013573, 4e-6),
        (3080.049, 4367.226, 3475.582, 168.940, -2.442, 0.432),
        MICRO,
    ),
    "hip_pitch": (
        4.953,
        (0.007636, -0.029298, -0.082670),
        (96268.791, 95311.563, 8309.394, -853.307, 4520.830, 10678.487),
        MICRO,
    ),
    "knee": (
        2.824,
        (0.003406, -0.005279, -0.143702),
        (23792.186, 24505.066, 3235.744, -201.965, 1348.223, 342.730),
        MICRO,
    ),
    "ankle": (0.725, (0.042537, 0.0, -0.041674), (236.702, 3296.133, 3145.554, 0.0, 197.223, 0.0), MICRO),
    "shoulder_pitch": (
        1.142,
        (0.005045, 0.053657, -0.015715),
        (0.0012985, 0.00087279, 0.00097338, -1.7333e-5, 8.683e-6, 3.9656e-5),
        1.0,
    ),
    "shoulder_roll": (
        0.852,
        (0.000679, 0.00115, -0.094076),
        (0.0015742, 0.0016973, 0.0010183, 2.298e-6, -7.2265e-5, -6.3691e-5),
        1.0,
    ),
    "shoulder_yaw": (
        0.862,
        (0.01365, 0.002767, -0.16266),
        (0.003664, 0.0040789, 0.00066383, -1.0671e-5, 0.00034733, 7.0213e-5),
        1.0,
    ),
    "elbow": (
        0.745,
        (0.164862, 0.000118, -0.015734),
        (0.00042388, 0.0060062, 0.0060023, -3.6086e-5, 0.00029293, 4.664e-6),
        1.0,
    ),
}


def _links() -> list[Link]:
    """Each link; the right side is mirrored here by rule: y -> -y flips com y, ixy and iyz."""
    pelvis = tensor(49168.411, 9025.844, 53155.891, -19.869, -48.460, 3.431) * MICRO
    torso = tensor(0.4873, 0.40963, 0.12785, -0.00053763, 0.0020276, -0.00074582)
    links: list[Link] = [
        ("pelvis", 5.983, (-0.0004, 3.7e-5, -0.046864), pelvis),
        ("torso_link", 17.789, (0.000489, 0.002797, 0.20484), torso),
    ]
    for side in SIDES:
        y = 1.0 if side == "left" else -1.0
        for part, (mass, (cx, cy, cz), (xx, yy, zz, xy, xz, yz), unit) in LEFT.items():
            matrix = tensor(xx, yy, zz, xy * y, xz, yz * y) * unit
            links.append((f"{side}_{part}_link", mass, (cx, cy * y, cz), matrix))
    return links


# pelvis 5.983 + torso 17.789 + 2 legs x (2.965 + 2.715 + 4.953 + 2.824 + 0.725 = 14.182)
# + 2 arms x (1.142 + 0.852 + 0.862 + 0.745 = 3.601)
MODEL = Published(
    "h1", "unitree_ros/robots/h1_description/urdf/h1.urdf", "pelvis", JOINTS, _links(), 59.338,
    [*[200.0, 200.0, 200.0, 300.0, 40.0] * 2, 200.0, *[40.0, 40.0, 18.0, 18.0] * 2],
)  # fmt: skip
"""Order of the URDF, left leg first."""


@pytest.fixture(scope="module")
def model() -> Any:
    """The robot alone, as written."""
    return MODEL.ours


def test_ranges_mirror(model: Any) -> None:
    """The right side's ranges are the left's, mirrored where the axis is x or z."""
    check_ranges_mirror(model, (*LEG, *ARM))
    assert model.joint("left_shoulder_roll_joint").range == pytest.approx([-0.34, 3.11])
    assert model.joint("left_knee_joint").range == pytest.approx([-0.26, 2.05])


def test_places_mirror(model: Any) -> None:
    """The right side stands where the left's mirror image does; a shoulder's tilt is undone by the next link."""
    for part in (*LEG, *ARM):
        left, right = (model.body(f"{side}_{part}_link") for side in SIDES)
        assert right.pos == pytest.approx(left.pos * [1, -1, 1]), part
        assert right.quat == pytest.approx(left.quat * [1, -1, 1, -1]), part
    tilt = np.cos(0.43633 / 2), np.sin(0.43633 / 2), 0.0, 0.0
    assert model.body("left_shoulder_pitch_link").quat == pytest.approx(tilt)
    assert model.body("right_shoulder_roll_link").quat == pytest.approx(tilt)


def test_home_has_flat_soles_on_the_floor() -> None:
    """At `home` both soles lie flat, less than 1 mm above the floor."""
    model = mujoco.MjModel.from_xml_path(str(ROBOTS / "h1" / "scene.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    for side in SIDES:
        # 0.1742 + 0.4 cos 0.1 + 0.4 cos 0.2 + 0.062 = 1.02623 m below the pelvis; -0.1 + 0.3 - 0.2 = 0
        assert data.site(f"{side}_foot").xpos[2] == pytest.approx(1.0263 - 1.02623, abs=1e-5)
        assert data.site(f"{side}_foot").xmat.reshape(3, 3) == pytest.approx(np.eye(3), abs=1e-12)
    assert data.ncon == 0
