"""A virtual leg for sysid.py: three joints that pull at each other, nothing of actspec, exact stick-slip.

Mass matrix and bias forces are MuJoCo's, at the middle of every step; drives, friction and time are of this file.
"""

from __future__ import annotations

from typing import Any

import numpy as np

Array = np.ndarray[Any, Any]

LEG_JOINTS = ("abduction", "thigh", "calf")


def leg_model(masses: Array) -> str:
    """A leg on a stand as MJCF; masses of its three links [kg]."""
    parts = []
    for name, axis, place, mass, centre, size in zip(
        LEG_JOINTS,
        ("1 0 0", "0 1 0", "0 1 0"),
        ("0 0 0", "0 0.08 0", "0 0 -0.21"),
        masses,
        ("0 0.01 0", "0 0.01 -0.04", "0 0 -0.11"),
        (0.0008, 0.0045, 0.0025),
        strict=True,
    ):
        own = float(size * mass)
        parts.append(
            f'<body name="{name}_link" pos="{place}"><joint name="{name}" axis="{axis}" range="-1 1"/>'
            f'<inertial pos="{centre}" mass="{float(mass)!r}" diaginertia="{own!r} {own!r} {own!r}"/>'
        )
    return (
        '<mujoco model="bench"><compiler angle="radian"/><worldbody>'
        + "".join(parts)
        + "</body>" * len(parts)
        + "</worldbody></mujoco>\n"
    )


def leg_truth(
    model: str, figures: dict[str, Array], command: Array, period: float, step: float = 1e-4
) -> tuple[Array, ...]:
    """(M(q) + A) q'' = clip(kp (a - q - bias) - kd q') - b q' - tc sign(q') - c(q, q'), from rest at 0.

    Args:
        model: MJCF.
        figures: kp, kd, armature, tc, b, delay, limit, bias, an array each, shape (n_joint,).
        command: At every row, shape (n_row, n_joint).
        period: Between rows [s].
        step: Of the integration [s].

    Returns: What encoder, speed and torque sensor read at the rows, shape (n_row, n_joint) each.
    """
    import mujoco

    compiled = mujoco.MjModel.from_xml_string(model)
    data = mujoco.MjData(compiled)
    n_row, n = command.shape
    kp, kd, armature, tc, b, delay, limit, bias = (
        figures[k] for k in ("kp", "kd", "armature", "tc", "b", "delay", "limit", "bias")
    )
    joints, dense = np.arange(n), np.zeros((n, n))
    q, v, rate = np.zeros(n), np.zeros(n), np.zeros(n)
    read = [np.empty((n_row, n)) for _ in range(3)]
    time = np.arange(n_row) * period

    def drive(a: Array, q: Array, v: Array) -> Array:
        return np.clip(kp * (a - q - bias) - kd * v, -limit, limit)

    def sent(at: Array, side: Any) -> Array:
        return np.clip(np.searchsorted(time, at, side=side) - 1, 0, n_row - 1)

    def links(q: Array, v: Array) -> tuple[Array, Array]:
        data.qpos[:], data.qvel[:] = q, v
        mujoco.mj_fwdPosition(compiled, data)
        mujoco.mj_fwdVelocity(compiled, data)
        mujoco.mj_fullM(compiled, data, dense)
        return np.linalg.inv(dense + np.diag(armature)), data.qfrc_bias.copy()

    def move(q: Array, v: Array, rate: Array, a: Array, h: float) -> tuple[Array, Array, Array]:
        """A step by the midpoint rule; joints that come to a stand within it do so at that moment.

        The middle's speed, for the velocity terms, is by the acceleration of the step before, `rate`.
        """
        for _ in range(4 * n):
            inverse, c = links(q + 0.5 * h * v, v + 0.5 * h * rate)
            pull = drive(a, q, v) - b * v - c
            first = _accelerations(inverse, pull, v, tc)
            middle = v + 0.5 * h * first
            middle[(v != 0.0) & (middle * v <= 0.0)] = 0.0
            pull = drive(a, q + 0.5 * h * v, middle) - b * middle - c
            change = _accelerations(inverse, pull, v, tc)
            after, rate = v + h * change, change
            turned = (v != 0.0) & (v * after < 0.0)
            if not turned.any():
                return q + h * 0.5 * (v + after), after, change
            until = h * float((v[turned] / (v - after)[turned]).min())
            first_to = int(np.argmin(np.where(turned, v / np.where(turned, v - after, 1.0), np.inf)))
            q, v = q + until * (v + 0.5 * until * change), v + until * change
            v[first_to] = 0.0
            h -= until
        return q, v, rate

    for row in range(n_row):
        now = time[row]
        read[0][row], read[1][row] = q + bias, v
        read[2][row] = drive(command[sent(now - delay - 1e-9, "left"), joints], q, v)
        parts = round(period / step)
        at = now + step * np.arange(parts)[:, None]
        first, last = sent(at - delay + 1e-9, "right"), sent(at + step - delay - 1e-9, "right")
        share = np.where(last > first, (time[last] + delay - at) / step, 1.0)
        for a in command[first, joints] * share + command[last, joints] * (1.0 - share):
            q, v, rate = move(q, v, rate, a, step)
    return read[0], read[1], read[2]


def _accelerations(inverse: Array, pull: Array, v: Array, tc: Array) -> Array:
    """With dry friction against the motion, and as much as holds, at most `tc`, where there is none."""
    friction = np.sign(v) * tc
    still = np.flatnonzero(v == 0.0)
    for _ in range(50 if len(still) else 0):
        before = friction.copy()
        for j in still:
            free = float(inverse[j] @ (pull - friction)) + inverse[j, j] * friction[j]
            friction[j] = min(max(free / inverse[j, j], -tc[j]), tc[j])
        if np.abs(friction - before).max() < 1e-12:
            break
    found: Array = inverse @ (pull - friction)
    found[still] = np.where(np.abs(friction[still]) < tc[still] * (1 - 1e-12), 0.0, found[still])
    return found
