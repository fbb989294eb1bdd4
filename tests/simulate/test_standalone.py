"""What is sent along with scripts: a body that is moved by another's torque, against closed forms."""

from __future__ import annotations

import numpy as np

from actspec.simulate.standalone import Body, Driven, follow


def body(coulomb: float, viscous: float, step: float, qd: float, parts: int = 1) -> Body:
    """One joint of 0.5 kg*m^2 in one course."""
    return Body(
        np.array([0.5]),
        np.array([coulomb]),
        np.array([viscous]),
        step / parts,
        np.zeros((1, 1)),
        np.array([[qd]]),
    )


def test_torque_accelerates() -> None:
    """2 N*m on 0.5 kg*m^2 for 3 steps of 0.1 s: 0.4, 0.8, 1.2 rad/s; 0.04 + 0.08 + 0.12 rad, semi-implicit."""
    one = body(0.0, 0.0, 0.1, 0.0)
    q, torque = follow(Driven(lambda u, q, qd: u, one), np.full((3, 1, 1), 2.0), 1)
    assert np.allclose(q[:, 0, 0], [0.0, 0.04, 0.12, 0.24])
    assert np.allclose(one.qd, 1.2)
    assert (torque == 2.0).all()


def test_friction_takes_no_more_speed_than_there_is() -> None:
    """1 N*m of friction takes 0.2 rad/s a step of 0.1 s: 0.3, 0.1, 0 rad/s, and it stays against 0.9 N*m."""
    one = body(1.0, 0.0, 0.1, 0.3)
    speeds = []
    for torque in (0.0, 0.0, 0.9):
        one.move(np.array([[torque]]))
        speeds.append(float(one.qd[0, 0]))
    assert np.allclose(speeds, [0.1, 0.0, 0.0])


def test_viscous_friction_is_implicit() -> None:
    """Each step divides by 1 + h b / J = 1 + 0.1 x 5 / 0.5 = 2."""
    one = body(0.0, 5.0, 0.1, 0.8)
    one.move(np.zeros((1, 1)))
    assert np.allclose(one.qd, 0.4)


def test_parts_ask_the_drive_again() -> None:
    """A drive of -qd in two parts of 0.05 s: 1, then 0.9, then 0.81 rad/s; the torque is that of the first part."""
    one = body(0.0, 0.0, 0.1, 1.0, parts=2)
    q, torque = follow(Driven(lambda u, q, qd: -qd, one), np.zeros((1, 1, 1)), 2)
    assert np.allclose(one.qd, 0.81)
    assert np.allclose(q[:, 0, 0], [0.0, 0.05 * (0.9 + 0.81)])
    assert np.allclose(torque, -1.0)
