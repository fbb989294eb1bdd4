"""The G1's models, with either motor at the wrists: published masses and limits, and soles on the floor."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from tests.robots.published import ROBOTS, Link, Published, check_ranges_mirror, tensor

mujoco = pytest.importorskip("mujoco")

SIDES = ("left", "right")
LEG = ("hip_pitch", "hip_roll", "hip_yaw", "knee", "ankle_pitch", "ankle_roll")
ARM = ("shoulder_pitch", "shoulder_roll", "shoulder_yaw", "elbow", "wrist_roll", "wrist_pitch", "wrist_yaw")
JOINTS = [
    *(f"{side}_{part}_joint" for side in SIDES for part in LEG),
    *(f"waist_{axis}_joint" for axis in ("yaw", "roll", "pitch")),
    *(f"{side}_{part}_joint" for side in SIDES for part in ARM),
]

Figures = tuple[float, tuple[float, float, float], tuple[float, float, float, float, float, float]]
"""Mass, centre of mass, and ixx, iyy, izz, ixy, ixz, iyz."""

TRUNK: dict[str, Figures] = {
    "pelvis": (3.813, (0, 0, -0.07605), (0.010549, 0.0093089, 0.0079184, 0, 2.1e-6, 0)),
    "pelvis_contour_link": (0.001, (0, 0, 0), (1e-7, 1e-7, 1e-7, 0, 0, 0)),
    "waist_yaw_link": (
        0.214,
        (0.003494, 0.000233, 0.018034),
        (0.00010673, 0.00010422, 0.0001625, 2.703e-6, -7.631e-6, -2.01e-7),
    ),
    "waist_roll_link": (0.086, (0, 2.3e-5, 0), (7.079e-6, 6.339e-6, 8.245e-6, 0, 0, 0)),
    "torso_link": (
        6.78,
        (0.000931, 0.000346, 0.15082),
        (0.05905, 0.047014, 0.025652, 3.3302e-5, -0.0017715, -2.2399e-5),
    ),
    "logo_link": (0.001, (0, 0, 0), (1e-7, 1e-7, 1e-7, 0, 0, 0)),
    "head_link": (
        1.036,
        (0.005267, 0.000299, 0.449869),
        (0.004085051, 0.004185212, 0.001807911, -2.543e-6, -6.9455e-5, -3.726e-6),
    ),
}
LEFT: dict[str, Figures] = {
    "hip_pitch_link": (
        1.35,
        (0.002741, 0.047791, -0.02606),
        (0.001811, 0.0014193, 0.0012812, 3.68e-5, -3.44e-5, 0.000171),
    ),
    "hip_roll_link": (
        1.52,
        (0.029812, -0.001045, -0.087934),
        (0.0023773, 0.0024123, 0.0016595, -3.8e-6, -0.0003908, 1.84e-5),
    ),
    "hip_yaw_link": (
        1.702,
        (-0.057709, -0.010981, -0.15078),
        (0.0057774, 0.0076124, 0.003149, -0.0005411, -0.0023948, -0.0007072),
    ),
    "knee_link": (
        1.932,
        (0.005457, 0.003964, -0.12074),
        (0.011329, 0.011277, 0.0015168, 4.82e-5, -4.49e-5, -0.0007146),
    ),
    "ankle_pitch_link": (0.074, (-0.007269, 0, 0.011137), (8.4e-6, 1.89e-5, 1.26e-5, 0, -2.9e-6, 0)),
    "ankle_roll_link": (
        0.608,
        (0.026505, 0, -0.016425),
        (0.0002231, 0.0016161, 0.0016667, 2e-7, 8.91e-5, -1e-7),
    ),
    "shoulder_pitch_link": (
        0.718,
        (0, 0.035892, -0.011628),
        (0.0004291, 0.000453, 0.000423, -9.2e-6, 6.4e-6, 2.26e-5),
    ),
    "shoulder_roll_link": (
        0.643,
        (-0.000227, 0.00727, -0.063243),
        (0.0006177, 0.0006912, 0.0003894, -1e-6, 8.7e-6, -5.3e-6),
    ),
    "shoulder_yaw_link": (
        0.734,
        (0.010773, -0.002949, -0.072009),
        (0.0009988, 0.0010605, 0.0004354, 7.9e-6, 0.0001412, -2.86e-5),
    ),
    "elbow_link": (
        0.6,
        (0.064956, 0.004454, -0.010062),
        (0.0002891, 0.0004152, 0.0004197, 6.53e-5, 1.72e-5, -5.6e-6),
    ),
    "wrist_roll_link": (
        0.08544498,
        (0.01713944778, 0.00053759094, 4.8864e-7),
        (4.821544023e-5, 3.722899093e-5, 5.482106541e-5, -4.24511021e-6, 5.10599e-9, -1.23525e-9),
    ),
    "wrist_pitch_link": (
        0.48404956,
        (0.02299989837, -0.00111685314, -0.00111658096),
        (0.00016579646273, 0.0004295405741, 0.00042953697654, -1.231206746e-5, 1.231699194e-5, 8.1417712e-7),
    ),
    "wrist_yaw_link": (
        0.08457647,
        (0.02200381568, 0.00049485096, 0.00053861123),
        (4.929128828e-5, 5.973338134e-5, 3.928083826e-5, -4.5735494e-7, 4.45867591e-6, 4.3217198e-7),
    ),
    "rubber_hand": (
        0.17,
        (0.05361310808, -0.0029590524, 0.00215413091),
        (
            *(0.00010099485234748, 0.00028135871571621, 0.00021894770413514),
            *(3.618590790516e-5, -7.4301518642e-7, 3.30189743286e-6),
        ),
    ),
}
WRIST_5010: dict[str, Figures] = {
    "left": (
        0.684,
        (0.02549150483, -0.00054042511, -0.00054143853),
        (0.00025599000747, 0.00071633247299, 0.00071591991283, -8.61777083e-6, -8.57523406e-6, -1.399472e-7),
    ),
    # Other than at every other link, iyz is not mirrored.
    "right": (
        0.684,
        (0.02549150483, 0.00054042511, -0.00054143853),
        (0.00025599000747, 0.00071633247299, 0.00071591991283, 8.61777083e-6, 8.57523406e-6, -1.399472e-7),
    ),
}
"""The wrist pitch links of machine types 13 and 15, whose motors are larger."""


def _links(name: str) -> list[Link]:
    """Each link; the right side is mirrored here by rule: y -> -y flips com y, ixy and iyz."""
    published = dict(TRUNK)
    for side in SIDES:
        y = 1.0 if side == "left" else -1.0
        for part, (mass, (cx, cy, cz), (xx, yy, zz, xy, xz, yz)) in LEFT.items():
            # The URDF's right knee has the left's ixz with the other sign; kept as published.
            mirrored = -xz if (side, part) == ("right", "knee_link") else xz
            published[f"{side}_{part}"] = (mass, (cx, cy * y, cz), (xx, yy, zz, xy * y, mirrored, yz * y))
        if name == "g1_5010":
            published[f"{side}_wrist_pitch_link"] = WRIST_5010[side]
    return [(link, mass, centre, tensor(*moments)) for link, (mass, centre, moments) in published.items()]


LINKAGES = dict.fromkeys(
    ("waist_roll_joint", "waist_pitch_joint", "ankle_pitch_joint", "ankle_roll_joint"), (50.0, 35.0)
)
"""Two motors of 25 N*m by mjlab, as in the spec; 35 N*m in the URDF."""


def _published(name: str, revision: str, wrist: float, mass: float) -> Published:
    """A model: its URDF, torque limit at wrist pitch and yaw, and what it weighs."""
    urdf = f"unitree_ros/robots/g1_description/g1_29dof_{revision}.urdf"
    leg, arm = [88.0, 139.0, 88.0, 139.0, 50.0, 50.0], [25.0, 25.0, 25.0, 25.0, 25.0, wrist, wrist]
    limits = [*leg, *leg, 88.0, 50.0, 50.0, *arm, *arm]
    return Published("g1", urdf, "pelvis", JOINTS, _links(name), mass, limits, name, LINKAGES)


MODELS = (
    _published("g1", "rev_1_0", 5.0, 33.34114202),
    _published("g1_5010", "mode_13", 13.4, 33.74104290),
)
"""Order of the URDF and of the SDK, left leg first.

7 links of the trunk: 3.813 + 0.001 + 0.214 + 0.086 + 6.78 + 0.001 + 1.036 = 11.931; 2 legs x (1.35 + 1.52 + 1.702 +
1.932 + 0.074 + 0.608 = 7.186); 2 arms x (0.718 + 0.643 + 0.734 + 0.6 + 0.08544498 + 0.48404956 + 0.08457647 + 0.17 =
3.51907101); the larger wrists: 2 x (0.684 - 0.48404956) = 0.39990088 more.
"""


@pytest.fixture(scope="module", params=MODELS, ids=str)
def model(request: pytest.FixtureRequest) -> Any:
    """Each of the two robots alone, as written."""
    return request.param.ours


def test_wrists_are_all_that_differs() -> None:
    """The larger wrist motors change their link and what hangs 5 mm further out, and no other body."""
    small, large = (published.ours for published in MODELS)
    names = [small.body(index).name for index in range(small.nbody)]
    assert names == [large.body(index).name for index in range(large.nbody)]
    moved = [name for name in names if not np.array_equal(small.body(name).pos, large.body(name).pos)]
    heavier = [name for name in names if small.body(name).mass != large.body(name).mass]
    assert moved == [f"{side}_wrist_yaw_link" for side in SIDES]
    assert heavier == [f"{side}_wrist_pitch_link" for side in SIDES]
    assert large.body("left_wrist_yaw_link").pos == pytest.approx([0.051, 0, 0])


def test_ranges_mirror(model: Any) -> None:
    """The right side's ranges are the left's, mirrored where the axis is x or z."""
    check_ranges_mirror(model, (*LEG, *ARM))
    assert model.joint("left_hip_roll_joint").range == pytest.approx([-0.5236, 2.9671])


def test_places_mirror(model: Any) -> None:
    """The right side stands where the left's mirror image does, to the 10 um that the URDF leaves."""
    for part in (*LEG, *ARM):
        left, right = (model.body(f"{side}_{part}_link") for side in SIDES)
        assert right.pos == pytest.approx(left.pos * [1, -1, 1], abs=1.01e-5), part
        assert right.quat == pytest.approx(left.quat * [1, -1, 1, -1], abs=1e-12), part
    # The hip's tilt is undone by the knee.
    tilt = np.cos(0.1749 / 2), 0.0, np.sin(0.1749 / 2), 0.0
    assert model.body("left_knee_link").quat == pytest.approx(tilt)
    assert model.body("left_hip_roll_link").quat == pytest.approx(np.array(tilt) * [1, 1, -1, 1])


def test_home_has_its_soles_on_the_floor() -> None:
    """At `home` both soles lie flat to the 6 mrad of the published pose, and touch the floor to within 0.1 mm."""
    model = mujoco.MjModel.from_xml_path(str(ROBOTS / "g1" / "scene.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    for side in SIDES:
        sole = data.site(f"{side}_foot")
        assert abs(sole.xpos[2]) < 1e-4
        # -0.312 + 0.669 - 0.363 = -0.006 about y
        assert sole.xmat[2] == pytest.approx(np.sin(-0.006), abs=1e-6)
