"""The overlays in Newton itself: torques, joints' numbers and delays equal what the spec asks for."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

from actspec.ir import Level
from tests.frameworks.asking import RTOL, Array, Run, expected_line, joints, points
from tests.frameworks.newton_asking import PROBE, Job, probed
from tests.frameworks.newton_specs import (
    GRID,
    GROUPS,
    JOBS,
    NETWORK,
    PD,
    RICH,
    SEEDED,
    SEEDED_DELAY,
    SEEDED_PUSH,
    job,
)
from tests.frameworks.prepare import NEWTON, Frameworks


@pytest.fixture(scope="module")
def ran(frameworks: Frameworks) -> Run[Job]:
    """Every overlay of this file, in one process."""
    mistaken = {name: one.job for name, one in SEEDED.items()}
    return probed(frameworks, {**JOBS, **mistaken, "seeded_delay": SEEDED_DELAY, "seeded_push": SEEDED_PUSH})


@pytest.mark.parametrize(
    "name", [name for name, one in JOBS.items() if one.grid is not None and name != "curve"]
)
def test_torque_and_joint_numbers(name: str, ran: Run[Job]) -> None:
    """Over a grid of torque asked for and speed, Newton's torque is the law's; the joints' numbers are the spec's."""
    assert ran.faults(name) == []
    assert ran.arrays(name)["force"].shape == (13 * 23, len(joints(JOBS[name])))


@pytest.mark.parametrize(
    ("name", "joint", "steps"),
    [("delayed", "hip", 2), ("delayed_dc", "hip", 2), ("two_delays", "hip", 2), ("two_delays", "calf", 5)],
)
def test_delay(name: str, joint: str, steps: int, ran: Run[Job]) -> None:
    """A delay is steps of the actuator, each joint's its own, in a second episode too; the line starts full."""
    one = JOBS[name]
    expected = expected_line(one, joint, steps)
    if (joint, steps) == ("hip", 2):
        # kp x (0.01, 0.01, 0.01, 0.02, 0.03, ...): the line is full of the first command.
        assert expected[:5] == pytest.approx([0.25, 0.25, 0.25, 0.5, 0.75])
    lagged = ran.arrays(name)["lagged"][..., joints(one).index(joint)]
    assert lagged.shape == (2, len(one.sequence))
    np.testing.assert_allclose(lagged, np.broadcast_to(expected, lagged.shape), rtol=RTOL)


def test_a_solver_moves_by_the_actuator_alone(ran: Run[Job]) -> None:
    """Of a joint whose stage has a drive of its own, the acceleration is the actuator's torque over its inertia."""
    # 25 N*m/rad x 0.1 rad over 1 kg*m^2; this solver takes no armature.
    assert ran.arrays("pushed")["accelerated"] == pytest.approx([2.5], rel=1e-3)
    # The stage's 3 N*m/deg are 172 N*m/rad, which its limit of 0.25 N*m does not stop here.
    assert ran.arrays("seeded_push")["accelerated"] > 10.0


def test_curve_is_as_far_off_as_recorded(ran: Run[Job]) -> None:
    """The line in place of an asymmetric curve differs by no more than its approximation says, and by nearly that."""
    one = JOBS["curve"]
    grid = points(one)
    asked = one.law("hip").torque(*(grid[name][:, 0] for name in ("command", "q", "qd")))
    error = float(np.abs(ran.arrays("curve")["force"][:, 0] - asked).max())
    said = one.written.lost("torque_speed_curve").max_torque_error
    assert said is not None
    assert 0.9 * said <= error <= said * (1 + RTOL)


def test_dc_motor_anchors(ran: Run[Job]) -> None:
    """The golden table of DESIGN 5: 23.5, 11.75, 0, -11.75, -23.5, -23.5 N*m at 0, 15, 30, 45, 60, 70 rad/s."""
    found = ran.arrays("anchors")["lagged"][0, :, 0]
    assert found == pytest.approx([23.5, 11.75, 0.0, -11.75, -23.5, -23.5], abs=1e-5)


@pytest.mark.parametrize("release", NEWTON)
def test_older_releases(release: str, frameworks: Frameworks) -> None:
    """What is written for an older Newton gives the law's torques and delays there, and the joint numbers it reads."""
    version = ".".join(release.split(".")[:2])
    jobs = {
        "rich": job(GROUPS, RICH, robot="", version=version, grid=GRID),
        "delayed": job(f"  leg: {{joints: [hip], {PD}, level: ideal_pd, delay: 10 ms}}", version=version,
                       sequence=JOBS["delayed"].sequence),
    }  # fmt: skip
    run = probed(frameworks, jobs, [str(frameworks.newton(release))])
    assert run.answer.said["version"].startswith(version)
    unread = ("joint_damping", "joint_velocity_limit") if version < "1.4" else ()
    assert [fault for fault in run.faults("rich") if not any(name in fault for name in unread)] == []
    if unread:
        # Neither the overlay's nor the stage's is read: the loss is recorded.
        assert run.arrays("rich")["joint_damping"].tolist() == [0.0] * len(joints(jobs["rich"]))
        assert {"friction.viscous", "velocity_limit"} <= {
            x.field for x in jobs["rich"].written.emission.approximations
        }
    expected = expected_line(jobs["delayed"], "hip", 2)
    np.testing.assert_allclose(run.arrays("delayed")["lagged"][:, :, 0], np.stack([expected] * 2), rtol=RTOL)


def manifest(**more: Any) -> str:
    """A network's conventions, none of them those that Newton assumes."""
    return json.dumps({
        "format": "actspec-network/1", "kind": "mlp", "inputs": "velocity_position", "taps": [0, 1, 2],
        "tap_period": "5 ms", "position_scale": -2.0, "velocity_scale": 3.0, "torque_scale": 4.0,
        "initial_history": "zero", **more,
    })  # fmt: skip


NETS: dict[str, dict[str, Any]] = {
    "order": {"kind": "mlp", "weight": [0.001, 0.0, 0.0, 1.0, 10.0, 100.0], "bias": 0.5},
    "stride": {"kind": "mlp", "weight": [0.0, 0.0, 1.0, 10.0], "bias": 0.0},
    # The cell's gate alone sees the error; i, o and f are sigmoid(0) = 1/2.
    "lstm": {
        "kind": "lstm",
        "weight": [0, 0, 0, 0, 0, 0, 1, 0],
        "metadata": {
            "metadata": json.dumps({
                "input_name": "x", "hidden_in_name": "h0", "cell_in_name": "c0",
                "output_name": "y", "hidden_out_name": "h1", "cell_out_name": "c1",
            })
        },
    },
}  # fmt: skip
"""What the probe makes: networks that say nothing of order, taps and scales."""


@pytest.fixture(scope="module")
def learned(frameworks: Frameworks, tmp_path_factory: pytest.TempPathFactory) -> Run[Job]:
    """Each network of `NETS` in a spec of one joint, run."""
    made = frameworks.run_probe(
        PROBE, {"path": [], "jobs": {name: {"network": net} for name, net in NETS.items()}}
    )
    conventions = {
        "order": manifest(),
        "stride": manifest(taps=[0, 1], tap_period="10 ms", position_scale=100.0),
        "lstm": manifest(
            kind="lstm", inputs="position_velocity", taps=[0], hidden_size=1, num_layers=1, position_scale=2.0
        ),
    }
    more: dict[str, dict[str, Any]] = {
        "order": {"sequence": (0.001, 0.002, 0.004, 0.008, 0.016, 0.1), "motion": ((0.0,) * 6, (1.0,) * 6)},
        "stride": {"sequence": (0.001, 0.002, 0.003, 0.004, 0.005)},
        "lstm": {"sequence": (0.1, 0.3, 0.2)},
    }
    jobs = {}
    for name, text in conventions.items():
        folder = tmp_path_factory.mktemp(name)
        (folder / "net.onnx").write_bytes(made.arrays[f"{name}.file"].tobytes())
        (folder / "net.json").write_text(text, encoding="utf-8")
        jobs[name] = job(NETWORK, path=str(folder / "spec.yaml"), **more[name])
        assert jobs[name].written.actuators.joints[0].level is Level.ACTUATOR_NET
    return probed(frameworks, jobs)


def test_network(learned: Run[Job]) -> None:
    """Order, sign, scales and taps of a manifest reach an ONNX file that says nothing of them."""
    # tau = 4 (0.5 + 0.001 x 3 qd_k - 2 (e_k + 10 e_k-1 + 100 e_k-2)), the history 0:
    # 2.012 - 8 x 0.001; - 8 (0.002 + 0.01); - 8 (0.004 + 0.02 + 0.1); - 8 (0.008 + 0.04 + 0.2);
    # - 8 (0.016 + 0.08 + 0.4); - 8 (0.1 + 0.16 + 0.8).
    expected = np.array([[2.004, 1.916, 1.02, 0.028, -1.956, -6.468]] * 2)
    assert learned.arrays("order")["lagged"][:, :, 0] == pytest.approx(expected, abs=1e-5)


def test_network_stride_and_limit(learned: Run[Job]) -> None:
    """Taps of 10 ms are every second step of 5 ms; the torque stops at effort_limit."""
    # 400 (e_k + 10 e_k-2): 0.4, 0.8, 400 x 0.013, 400 x 0.024, 400 x 0.035 = 14 above 12.
    assert learned.arrays("stride")["lagged"][0, :, 0] == pytest.approx([0.4, 0.8, 5.2, 9.6, 12.0], abs=1e-5)


def test_lstm(learned: Run[Job]) -> None:
    """An lstm keeps its state from step to step, with the manifest's scales and the names of its own metadata."""
    cell, expected = 0.0, []
    for error in learned.jobs["lstm"].sequence:
        cell = 0.5 * cell + 0.5 * np.tanh(2.0 * error)
        expected.append(4.0 * 0.5 * np.tanh(cell))
    assert learned.arrays("lstm")["lagged"][0, :, 0] == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize("name", SEEDED)
def test_seeded_mistakes_are_found(name: str, ran: Run[Job]) -> None:
    """An overlay with one mistake in it does not pass the checks above, which say what it is."""
    assert any(SEEDED[name].fault in fault for fault in ran.faults(name)), ran.faults(name)


def test_seeded_delay_is_found(ran: Run[Job]) -> None:
    """A delay that is one step off does not give the expected sequence."""
    lagged: Array = ran.arrays("seeded_delay")["lagged"][..., 0]
    assert not np.allclose(lagged, expected_line(SEEDED_DELAY, "hip", 2), rtol=RTOL)
