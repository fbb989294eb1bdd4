"""What ANYbotics' URDFs of ANYmal C and D fix together, part by part, as published for the left front leg."""

from __future__ import annotations

from typing import Any

import numpy as np

from tests.robots.published import tensor

LEGS = ("LF", "RF", "LH", "RH")
BALL = tensor(1e-6, 1e-6, 1e-6, 0, 0, 0)

Part = tuple[float, Any, np.ndarray]
"""Mass [kg], centre of mass [m] and inertia about it [kg*m^2], axes of the base."""


def _placed(
    mass: float, centre: Any, inertia: np.ndarray, at: Any = (0, 0, 0), axis: str = "z", angle: float = 0.0
) -> Part:
    """A part whose own frame stands at a place, turned about one axis of its parent [rad]."""
    cos, sin = np.cos(angle), np.sin(angle)
    turn = np.array(
        {
            "x": [[1, 0, 0], [0, cos, -sin], [0, sin, cos]],
            "y": [[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]],
            "z": [[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]],
        }[axis]
    )
    return mass, np.array(at) + turn @ np.array(centre), turn @ inertia @ turn.T


def _mirrored(mass: float, centre: Any, inertia: tuple[float, ...], x: float, y: float) -> Part:
    """A part of the left front leg on another leg; inertia as ixx, iyy, izz, ixy, ixz, iyz."""
    xx, yy, zz, xy, xz, yz = inertia
    place = np.array([centre[0] * x, centre[1] * y, centre[2]])
    return mass, place, tensor(xx, yy, zz, xy * x * y, xz * x, yz * y)


def anymal_c() -> dict[str, list[Part]]:
    """Parts of each body of the ANYmal C, in the frame of the body."""
    drive = (
        2.04,
        (-0.063, 7e-05, 0.00046),
        tensor(0.001053013, 0.001805509, 0.001765827, 4.527e-05, 8.855e-05, 9.909e-05),
    )
    depth = (
        0.16043,
        (-0.021, -0.002, 0.025),
        tensor(0.000637051, 0.000929402, 0.000484569, 0.000484569, 0.000424211, 5.138e-06),
    )
    face = [
        _placed(
            0.73,
            (0.042, -0.001, 0.004),
            tensor(0.005238611, 0.002643098, 0.004325938, 1.7609e-05, 7.2167e-05, 1.9548e-05),
        ),
        _placed(*depth, (0.04715, 0, -0.0292), "y", np.radians(30)),
        _placed(
            0.287,
            (-0.053, -0.001, 0.025),
            tensor(0.000559232, 0.000946504, 0.000493052, 1.6875e-05, 0.000423761, 1.3234e-07),
            (0.0985, 0, 0.01497),
        ),
    ]
    tilted = _placed(*depth, angle=np.radians(30), axis="y")
    base = [
        (
            6.222,
            (-0.018, -0.002, 0.024),
            tensor(0.017938806, 0.370887745, 0.372497653, 0.00387963, 0.001500772, 6.8963e-05),
        ),
        (
            0.534,
            (-0.00777, -0.00013, 0.06523),
            tensor(0.00664789486, 0.02587392411, 0.03152303792, 1.247923e-05, 0.00053990097, 3.7614e-07),
        ),
        (
            1.15,
            (-0.00333, 1e-05, -0.07705),
            tensor(0.00927353677, 0.06134388239, 0.06853531465, 5.41222e-06, 9.039821e-05, 2.3042e-07),
        ),
        (
            0.3262,
            (-0.171, 0.002, 0.096),
            tensor(0.000528486, 0.001165035, 0.00124026, 4.547e-05, 1.10327e-05, 7.4e-07),
        ),
        (0.314, (0.37801, 0, 0.1372), tensor(0.001525739, 0.00071584, 0.001164779, 0, 6.272e-05, 1e-09)),
        (
            5.53425,
            (-0.00067, -0.00023, -0.03362),
            tensor(0.00749474794, 0.0722338913, 0.07482717535, 0.00016686282, 7.82763e-05, 1.42902e-06),
        ),
        (0.065, (0.34, 0, -0.065), tensor(0.00063283, 0.00110971, 0.00171883, 0, 3.45e-07, 0)),
        # The IMU's frame is turned by a quarter about z.
        _placed(
            0.01,
            (0, 0, 0),
            np.diag([5.63333333333e-07, 9.6e-07, 5.63333333333e-07]),
            (0.2488, 0.00835, 0.04628),
            angle=np.pi / 2,
        ),
        (0.545, (-0.362, 0, 0.1725), tensor(0.003156254, 0.002357216, 0.001326455, 0, 1.0992e-05, 0)),
        _placed(
            0.695,
            (-0.012, 0.001, -0.008),
            tensor(0.000846765, 0.001367583, 0.001363673, 6.9565e-05, 0.00027111, 5.8984e-05),
            (-0.364, 0, 0.1422),
            angle=-np.pi / 2,
        ),
        # Published with 0.001 in all six places.
        (0.142, (0.116, 0, 0.0758), np.full((3, 3), 0.001)),
        *(_placed(*part, (0.4145, 0, 0)) for part in face),
        *(_placed(*part, (-0.4145, 0, 0), angle=np.pi) for part in face),
        _placed(*tilted, (0, 0.07646, 0.02905), angle=np.pi / 2),
        _placed(*tilted, (0, -0.07646, 0.02905), angle=-np.pi / 2),
    ]
    found: dict[str, list[Part]] = {"base": [(m, np.array(c), i) for m, c, i in base]}
    for leg in LEGS:
        y = 1.0 if leg[0] == "L" else -1.0
        x = 1.0 if leg[1] == "F" else -1.0
        # Rolled by 150 degrees; behind, turned about z first.
        rolled = _placed(*drive, axis="x", angle=np.radians(150) * x * y)
        found["base"].append(_placed(*rolled, (0.2999 * x, 0.104 * y, 0), angle=0 if x > 0 else -np.pi))
        across = {"axis": "z", "angle": np.pi / 2 * y}
        found[f"{leg}_HIP"] = [
            (0.001, np.zeros(3), BALL),
            _mirrored(
                0.74,
                (0.048, 0.008, -0.003),
                (0.001393106, 0.003798579, 0.003897509, 8.4012e-05, 2.3378e-05, 7.1319e-05),
                x,
                y,
            ),
            _placed(*drive, (0.0599 * x, 0.08381 * y, 0), **across),
        ]
        found[f"{leg}_THIGH"] = [
            (0.001, np.zeros(3), BALL),
            _mirrored(
                1.03,
                (0, 0.018, -0.169),
                (0.018644469, 0.019312599, 0.002838361, 5.2e-08, 1.0157e-05, 0.002520077),
                x,
                y,
            ),
            _placed(*drive, (0, 0.1003 * y, -0.285), **across),
        ]
        foot = (0.08795 + 0.00948, 0.01305 - 0.00948, -0.33797 + 0.1468)
        found[f"{leg}_SHANK"] = [
            (0.001, np.zeros(3), BALL),
            _mirrored(
                0.33742,
                (0.03463, 0.00688, 0.00098),
                (0.00032748005, 0.00110974122, 0.00089388521, 2.142561e-05, 1.33942e-05, 7.601e-08),
                x,
                y,
            ),
            _mirrored(
                0.25,
                foot,
                (0.00317174097, 0.00317174092, 8.319196e-05, 2.63048e-06, 6.815581e-05, 6.815583e-05),
                x,
                y,
            ),
        ]
    return found


def anymal_d() -> dict[str, list[Part]]:
    """Parts of each body of the ANYmal D, in the frame of the body."""
    drive = (
        2.01511,
        (-0.05783, -0.00014, 0.00036),
        tensor(0.0033251482, 0.00318377804, 0.00355095312, 2.567315e-05, 2.599963e-05, 9.462185e-05),
    )
    depth = (
        0.06355,
        (-0.00362, -0.01787, -0.00011),
        tensor(6.841545e-05, 5.2817e-06, 6.669787e-05, 1.46667e-06, 4.115e-08, 8.039e-08),
    )
    face = [
        _placed(
            0.48634,
            (-0.0362, 0.00223, -0.02808),
            tensor(0.00077413444, 0.00076586537, 0.00055588292, 1.55433e-06, 6.243539e-05, 4.61106e-06),
        ),
        _placed(*depth, (-0.04028, -0.025, -0.08051), "y", np.radians(60)),
        _placed(*depth, (-0.00993, -0.025, -0.04096), "y", np.radians(15)),
        _placed(
            0.1369,
            (0.01446, 4e-05, -0.01698),
            tensor(0.00102140404, 0.00051576362, 0.00057208503, 9.54e-09, 4.343039e-05, 2.7592e-07),
        ),
    ]
    side = _placed(
        0.11196,
        (-0.01352, -0.02667, -0.00198),
        tensor(0.00011356938, 2.382311e-05, 0.00012178739, 3.5285e-06, 4.9332e-07, 3.3737e-07),
        axis="y",
        angle=np.radians(42),
    )
    base = [
        (
            8.27629,
            (-0.02148, 0.00173, -0.04417),
            tensor(0.06185585085, 0.46467853407, 0.47162119244, 0.00052357046, -0.02204886469, 0.00058724812),
        ),
        (
            0.32381,
            (-0.0226, -0.00027, 0.07263),
            tensor(0.00391191516, 0.01761096758, 0.02086102766, -1.078994e-05, -0.00048832706, 4.45768e-06),
        ),
        (
            0.73783,
            (9e-05, 0, -0.0705),
            tensor(0.00724251946, 0.03457730959, 0.04075819312, 8.94306e-06, 7.96806e-05, 4.87e-09),
        ),
        (
            5.51206,
            (-0.00067, 0.00023, -0.02212),
            tensor(0.00745533705, 0.07199300212, 0.07459357231, -0.00016412238, 7.454512e-05, -1.31605e-06),
        ),
        (
            0.21905,
            (0.26738, 0, -0.04302),
            tensor(0.00010664534, 0.00015585103, 0.00021982177, 5.383e-08, 4.91832e-06, 1.7942e-07),
        ),
        (
            0.60727,
            (-0.04494, -0.00075, 0.13257),
            tensor(0.00172041475, 0.00100683572, 0.00217149159, 2.466045e-05, 1.95244e-06, 3.598867e-05),
        ),
        # The lidar stands half a turn about z, a quarter by its mount and one by itself.
        _placed(
            0.9017,
            (-0.00371, -0.00326, -0.00485),
            tensor(0.00111563406, 0.00114682455, 0.00132807373, 0.00012074344, 0.00011445184, 0.00010431906),
            (-0.31, 0, 0.1585),
            angle=np.pi,
        ),
        # The payload: mount at (0.14253, 0, 0.092), pan 0.023 m above it, tilt at (0.03, 0, 0.152) of the pan.
        (
            0.2158,
            (0.14543, 0, 0.1025),
            tensor(0.0002346126, 0.00020272719, 0.00040505639, 4.86e-09, 3.55757e-06, 9.36e-09),
        ),
        (
            3.18886,
            (0.14321, -0.00349, 0.19078),
            tensor(0.02661619524, 0.01515399107, 0.02200752038, 0.00040736245, 0.00195095864, 0.00077034252),
        ),
        (
            2.084,
            (0.17787, -0.00379, 0.26609),
            tensor(0.00743579757, 0.00619264016, 0.00593296152, 6.988521e-05, 3.254125e-05, 2.659381e-05),
        ),
        *(_placed(*part, (0.4087, 0, 0.0205)) for part in face),
        *(_placed(*part, (-0.4087, 0, 0.0205), angle=np.pi) for part in face),
        _placed(*side, (-0.025, 0.0923, 0.0123), angle=np.pi / 2),
        _placed(*side, (0.025, -0.0923, 0.0123), angle=-np.pi / 2),
    ]
    found: dict[str, list[Part]] = {"base": [(m, np.array(c), i) for m, c, i in base]}
    for leg in LEGS:
        y = 1.0 if leg[0] == "L" else -1.0
        x = 1.0 if leg[1] == "F" else -1.0
        found["base"].append(
            _placed(*drive, (0.304 * x, 0.109 * y, 0), angle=0 if x > 0 else -np.pi),
        )
        found[f"{leg}_HIP"] = [
            (0.001, np.zeros(3), BALL),
            _mirrored(
                0.36386,
                (0.03505, -0.00125, 0),
                (0.00023646957, 0.00055386457, 0.00043888609, 3.45771e-06, 1.268e-08, 1.811e-08),
                x,
                y,
            ),
            (0.001, np.array([0.069 * x, 0.006 * y, 0]), BALL),
        ]
        found[f"{leg}_THIGH"] = [
            (0.001, np.zeros(3), BALL),
            _placed(*drive, angle=-np.pi / 2 * y),
            _mirrored(
                1.10098,
                (-0.00041, 0.09155, -0.13317),
                (0.01541669135, 0.01630081575, 0.00258410631, 0.00021116021, 0.00031942961, 0.00143783119),
                x,
                y,
            ),
            _placed(*drive, (0, 0.1805 * y, -0.285), angle=np.pi / 2 * y),
        ]
        foot = (0.1, 0.02225 - 0.01559, -0.39246 + 0.15004)
        found[f"{leg}_SHANK"] = [
            (0.001, np.zeros(3), BALL),
            _mirrored(
                0.49854,
                (0.02186, 0.00895, 0.00042),
                (0.00054939614, 0.00166971314, 0.00127258622, 2.147115e-05, 1.687902e-05, 1.71584e-06),
                x,
                y,
            ),
            _mirrored(
                0.29644,
                foot,
                (0.00514263169, 0.0051315957, 0.00011890148, 1.46e-09, 6.85e-09, 0.00016323086),
                x,
                y,
            ),
        ]
    return found
