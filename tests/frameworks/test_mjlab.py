"""The emitted mjlab text in mjlab itself: torque, passive numbers and lags equal what the spec asks for."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from actspec.ir import Level
from actspec.verify.environments import EngineError
from tests.frameworks.asking import RTOL, Array, Run, expected_line, joints, points
from tests.frameworks.mjlab_asking import ENVS, PROBE, Job, probed
from tests.frameworks.mjlab_specs import JOBS, PD, RAMP, SEEDED, job
from tests.frameworks.prepare import Frameworks


@pytest.fixture(scope="module")
def ran(frameworks: Frameworks) -> Run[Job]:
    """Every module of this file, in one process."""
    return probed(frameworks, {**JOBS, **SEEDED})


@pytest.mark.parametrize("name", ["a1", "rich"])
def test_torque_and_passive_numbers(name: str, ran: Run[Job]) -> None:
    """Over a grid of torque asked for and speed, mjlab's torque is the law's; the joint's numbers are the spec's."""
    assert ran.faults(name) == []
    assert ran.arrays(name)["force"].shape == (13 * 23, len(joints(JOBS[name])))


def test_the_models_own_actuators_go(ran: Run[Job]) -> None:
    """The model's servo and filter on driven joints are gone, the tendon's motor stays, and no limit is narrower."""
    assert sorted(ran.said("rich")["actuators"]) == sorted([*joints(JOBS["rich"]), "kept"])
    narrow = joints(JOBS["rich"]).index("narrow")
    assert ran.arrays("rich")["actfrcrange"][narrow].tolist() == [-11.0, 11.0]


def expected(name: str, steps: int) -> Array:
    """Torque of one module's joint at each step, behind a delay of `steps`."""
    return expected_line(JOBS[name], "hip", steps)


@pytest.mark.parametrize("name", ["fixed", "fixed_dc"])
def test_fixed_delay(name: str, ran: Run[Job]) -> None:
    """10 ms are two steps of 5 ms, in every environment and in a second episode too."""
    lagged = ran.arrays(name)["lagged"][..., 0]
    assert lagged.shape == (2, len(RAMP), ENVS)
    # kp x (0.01, 0.01, 0.01, 0.02, 0.03, ...): the line is full of the first command.
    assert expected(name, 2)[:5] == pytest.approx([0.25, 0.25, 0.25, 0.5, 0.75])
    np.testing.assert_allclose(lagged, np.broadcast_to(expected(name, 2)[:, None], lagged.shape), rtol=RTOL)


@pytest.mark.parametrize("name", ["episode", "episode_dc"])
def test_delay_of_an_episode(name: str, ran: Run[Job]) -> None:
    """Each environment draws 0, 1 or 2 steps at a reset and keeps them; every lag occurs, and a reset draws anew."""
    lagged = ran.arrays(name)["lagged"][..., 0]
    table = np.stack([expected(name, steps) for steps in range(3)])
    lags = np.full((2, ENVS), -1)
    for episode in range(2):
        for env in range(ENVS):
            same = [k for k in range(3) if np.allclose(lagged[episode, :, env], table[k], rtol=RTOL)]
            assert len(same) == 1, lagged[episode, :, env]
            lags[episode, env] = same[0]
    assert set(lags.ravel().tolist()) == {0, 1, 2}
    assert (lags[0] != lags[1]).any()


def test_delay_of_each_step(ran: Run[Job]) -> None:
    """Drawn at every step: a torque is that of the last three commands, and an environment does not keep one lag."""
    lagged = ran.arrays("each")["lagged"][..., 0]
    table = np.stack([expected("each", steps) for steps in range(3)])
    near = np.isclose(lagged[None], table[:, None, :, None], rtol=RTOL)
    assert near.any(axis=0).all()
    # After the line has filled, each row fits one lag only.
    drawn = near[:, :, 3:].argmax(axis=0)
    assert (drawn.max(axis=1) > drawn.min(axis=1)).all()


def test_curve_is_as_far_off_as_recorded(ran: Run[Job]) -> None:
    """The line in place of an asymmetric curve differs by no more than its approximation says, and by nearly that."""
    one = JOBS["curve"]
    grid = points(one)
    asked = one.law("hip").torque(*(grid[name][:, 0] for name in ("command", "q", "qd")))
    error = float(np.abs(ran.arrays("curve")["force"][:, 0] - asked).max())
    said = one.written.lost("torque_speed_curve").max_torque_error
    assert said is not None
    assert 0.9 * said <= error <= said * (1 + RTOL)


def test_dc_motor_anchors(frameworks: Frameworks) -> None:
    """The golden table of DESIGN 5: 23.5, 11.75, 0, -11.75, -23.5, -23.5 N*m at 0, 15, 30, 45, 60, 70 rad/s."""
    spec = f"  leg: {{joints: [hip], level: dc_motor, motor: anchor, {PD}, effort_limit: 23.5 N*m}}"
    one = job(spec)
    speeds = np.array([[0.0], [15.0], [30.0], [45.0], [60.0], [70.0]])
    still = np.zeros_like(speeds)
    arrays = {"anchor.q": still, "anchor.qd": speeds, "anchor.command": still + 10.0}
    found = frameworks.run_probe(PROBE, {"anchor": one.request()}, arrays).arrays["anchor.force"][:, 0]
    assert found == pytest.approx([23.5, 11.75, 0.0, -11.75, -23.5, -23.5], abs=1e-5)


def test_network(frameworks: Frameworks, tmp_path: Path) -> None:
    """Order, sign, scales and taps of a network arrive, and its torque is clipped at effort_limit."""
    weight = [1.0, 10.0, 100.0, 0.0, 0.0, 0.0]
    made = frameworks.run_probe(PROBE, {"net": {"weights": {"weight": weight, "bias": 0.5}}})
    (tmp_path / "net.pt").write_bytes(made.arrays["net.network"].tobytes())
    manifest = {
        "format": "actspec-network/1",
        "kind": "mlp",
        "inputs": "position_velocity",
        "taps": [0, 1, 2],
        "tap_period": "5 ms",
        "position_scale": -2.0,
        "velocity_scale": 3.0,
        "torque_scale": 4.0,
        "initial_history": "first_sample",
    }
    (tmp_path / "net.json").write_text(json.dumps(manifest), encoding="utf-8")
    spec = (
        "  leg: {joints: [hip], level: actuator_net, effort_limit: 12 N*m,"
        " network: {file: net.pt, manifest: net.json}}"
    )
    one = job(spec, path=str(tmp_path / "spec.yaml"), sequence=(0.001, 0.002, 0.004, 0.008, 0.016))
    assert one.written.actuators.joints[0].level is Level.ACTUATOR_NET
    lagged = probed(frameworks, {"net": one}).arrays("net")["lagged"]
    # tau = 4 (0.5 - 2 (e_k + 10 e_k-1 + 100 e_k-2)), e the commands with the joint at 0, clipped at 12:
    # 2 - 8 x 0.111 = 1.112; 2 - 8 x 0.112; 2 - 8 (0.004 + 0.02 + 0.1); 2 - 8 x 0.248; 2 - 8 x 0.496.
    assert lagged[0, :, 0, 0] == pytest.approx([1.112, 1.104, 1.008, 0.016, -1.968], abs=1e-5)


@pytest.mark.parametrize("name", [name for name in SEEDED if name != "lag-one-off"])
def test_seeded_mistakes_are_found(name: str, ran: Run[Job]) -> None:
    """A module with one mistake in it does not pass the checks above."""
    assert ran.faults(name)


def test_seeded_lag_is_found(ran: Run[Job]) -> None:
    """A lag that is one step off does not give the expected sequence."""
    one = SEEDED["lag-one-off"]
    lagged = ran.arrays("lag-one-off")["lagged"][..., 0]
    assert not np.allclose(lagged, expected_line(one, "hip", 2)[:, None], rtol=RTOL)


def test_a_delay_in_seconds_is_refused_at_a_step(frameworks: Frameworks) -> None:
    """What DLY101 says of a lag that is no whole number: the cfg is made, and its first command raises an error."""
    one = replace(SEEDED["lag-one-off"], mutation=("_lag=2,", "_lag=0.02,"))
    with pytest.raises(EngineError, match=r"(?s)in append.*TypeError: empty\(\)"):
        probed(frameworks, {"seconds": one})
