"""The courses of joints that are let go, by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from actspec.simulate.experiment import Experiment, design
from actspec.verify.joint_laws import laws_of
from tests.verify.making import SPEC, Built, build

HIP_KP = 40.0
STEP, SATURATED, CHIRP, COAST = range(4)


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """The rich spec."""
    return build(tmp_path_factory.mktemp("experiment"), SPEC.split("targets:")[0] + "targets: {deploy: {}}\n")


@pytest.fixture(scope="module")
def experiment(built: Built) -> Experiment:
    """Of its joints."""
    actuators = built.compilation.actuators
    return design(actuators, laws_of(actuators).laws)


def test_a_body_beside_the_armature_has_the_rest_of_the_inertia(built: Built, experiment: Experiment) -> None:
    """J has the armature once: 0.0081 of the hips', 0.018225 of the knees', 0.3 kg of the lift's is not the body's."""
    held = {a.joint: a.inertia_held for a in built.compilation.actuators.joints}
    assert experiment.inertia.tolist() == [held[name].reference for name in experiment.names]  # type: ignore[union-attr]
    assert np.allclose(
        experiment.inertia - experiment.body, [0.0081, 0.018225, 0.0081, 0.018225, 0.3], rtol=0, atol=1e-12
    )


def test_a_step_is_worth_half_the_limit_and_one_saturates(experiment: Experiment) -> None:
    """0.5 x 22.5 / 40 = 0.28125 rad after two steps, and four times that; the joint rests at 0."""
    hip = experiment.command[:, :, 0]
    assert hip[:2, :2].tolist() == [[0.0, 0.0], [0.0, 0.0]]
    assert np.allclose(hip[2:, STEP], 0.28125)
    assert np.allclose(hip[2:, SATURATED], 1.125)
    assert (experiment.q[:, 0] == 0.0).all()
    # 0.5 x 150 N / 300 N*s/m = 0.25 m/s
    assert np.allclose(experiment.command[2:, STEP, 4], 0.25)


def test_a_clamped_joint_rests_in_the_middle_and_its_encoder_reads_more(experiment: Experiment) -> None:
    """-1.9 to 0 rad: at -0.95, which the encoder with its bias of 0.02 reads as -0.93."""
    assert (experiment.q[:, 1] == -0.95).all()
    assert np.allclose(experiment.command[0, :, 1], -0.93)


def test_a_chirp_sweeps_to_twice_the_closed_loop(experiment: Experiment) -> None:
    """0.1 x 20^(t / T) of sqrt(40 / J), integrated by fine rectangles; 0.25 x 22.5 / 40 rad high."""
    rate = math.sqrt(HIP_KP / experiment.inertia[0])
    steps, fine = len(experiment.command), 1000
    share = (np.arange(steps * fine) + 0.5) / (steps * fine)
    phase = np.cumsum(0.1 * rate * 20.0**share) * experiment.step / fine
    expected_phase = np.r_[0.0, phase[fine - 1 :: fine]][:steps]
    assert np.abs(experiment.command[:, CHIRP, 0] - 0.140625 * np.sin(expected_phase)).max() < 1e-6


def test_a_coast_down_begins_with_a_speed_at_no_error(experiment: Experiment) -> None:
    """0.28125 rad x sqrt(40 / J), at most half the no-load speed of 30; 0.25 m/s of the velocity drive."""
    rate = math.sqrt(HIP_KP / experiment.inertia[0])
    assert experiment.qd[:, 0].tolist() == [0.0, 0.0, 0.0, pytest.approx(min(0.28125 * rate, 15.0))]
    assert (experiment.command[:, COAST, 0] == experiment.command[0, COAST, 0]).all()
    assert experiment.qd[COAST, 4] == pytest.approx(0.25)
