"""The emitted Isaac Lab text, executed in the real package: its own actuator classes against the laws."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from actspec import api
from actspec.laws import filter_gain, initial_command_state, law_of, step_command
from actspec.targets.isaaclab.emit import emit
from actspec.verify.environments import EngineError
from tests.frameworks.isaaclab_asking import (
    PROBE,
    Emitted,
    Motion,
    ask,
    command,
    compiled,
    expected,
    grid,
    number_faults,
    options,
    still,
    torque_faults,
)
from tests.frameworks.isaaclab_specs import RANGED, RICH, WHOLE
from tests.frameworks.prepare import Frameworks

pytestmark = pytest.mark.slow

ROOT = Path(__file__).resolve().parents[2]


def a1(version: str = "2.3") -> Emitted:
    """robots/a1.yaml for a version."""
    spec = api.load(ROOT / "robots" / "a1.yaml")
    robot = api.load_robot(spec)
    actuators = api.resolve(spec, robot)
    return Emitted(actuators, robot, emit(actuators, robot, options(version)))


A1_NUMBERS: dict[str, float | None] = {
    "effort_limit": 33.5,
    "velocity_limit": 21.0,
    "stiffness": 25.0,
    "damping": 0.5,
    "armature": 0.01,
    "friction": 0.2,
    "dynamic_friction": 0.2,
    "viscous_friction": 0.01,
    "velocity_limit_sim": None,
}
"""As robots/a1.yaml states them; nobody states a limit of the solver's."""

RICH_NUMBERS: dict[str, dict[str, float | None]] = {
    "effort_limit": {
        "left_hip": 25.0,
        "right_hip": 30.0,
        "left_knee": 20.0,
        "right_knee": 20.0,
        "toe": 9.0,
        "wheel": 15.0,
        "grip": 5.0,
        "lift": 200.0,
    },
    # The line's no-load speed where there is one.
    "velocity_limit": {"left_knee": 30.0, "right_knee": 25.0, "wheel": 30.0},
    "velocity_limit_sim": {"left_hip": 11.0, "right_hip": 11.0, "left_knee": None, "toe": None},
    "stiffness": {
        "left_hip": 90.0,
        "right_hip": 100.0,
        "left_knee": 80.0,
        "right_knee": 80.0,
        "toe": 20.0,
        "wheel": 0.0,
        "grip": 0.0,
        "lift": 900.0,
    },
    "damping": {
        "left_hip": 4.0,
        "right_hip": 4.0,
        "left_knee": 2.0,
        "right_knee": 2.0,
        "toe": 0.7,
        "wheel": 3.0,
        "grip": 0.0,
        "lift": 30.0,
    },
    "armature": {"left_hip": 0.03, "right_hip": 0.02, "left_knee": 0.01, "toe": None, "lift": 1.0},
    "friction": {"left_hip": 0.5, "right_hip": 0.5, "left_knee": 0.2, "toe": None},
    "dynamic_friction": {"left_hip": 0.3, "right_hip": 0.3, "left_knee": 0.2, "toe": None},
    "viscous_friction": {"left_hip": 0.05, "right_hip": 0.05, "right_knee": 0.04, "toe": None},
}
"""RICH by hand, for Isaac Lab 2.3 on Isaac Sim 5: kd and passive viscous friction apart."""


def with_one_field(numbers: dict[str, dict[str, float | None]]) -> dict[str, dict[str, float | None]]:
    """The same where a joint's friction has no field: kd + viscous in the damping, no friction."""
    summed = {"left_hip": 4.05, "right_hip": 4.05, "left_knee": 2.04, "right_knee": 2.04}
    none: dict[str, float | None] = dict.fromkeys(("left_hip", "right_hip", "left_knee", "toe"), None)
    return {
        **numbers,
        "damping": {**numbers["damping"], **summed},
        "friction": none,
        "dynamic_friction": none,
        "viscous_friction": none,
    }


@pytest.mark.parametrize("version", ["2.2", "2.3"])
def test_a1_is_its_law(frameworks: Frameworks, version: str) -> None:
    """The A1's cfg makes twelve DCMotor joints with the spec's numbers, whose torque is the law's."""
    emitted = a1(version)
    motion = grid(emitted)
    answer = ask(frameworks, emitted, motion, version=version)
    numbers = dict(A1_NUMBERS)
    if version == "2.2":
        # No friction is ever written there: 0.5 + 0.01 in the damping.
        numbers |= {"damping": 0.51, "friction": None, "dynamic_friction": None, "viscous_friction": None}
    assert {entry["class"] for entry in answer.joints.values()} == {"DCMotor"}
    assert len(answer.joints) == 12
    values = {name: dict.fromkeys(answer.joints, value) for name, value in numbers.items()}
    assert number_faults(emitted, answer, values) == []
    if version == "2.3":
        assert torque_faults(emitted, answer, motion) == []
        assert emitted.emission.approximations == ()


def test_levels_and_commands_are_their_laws(frameworks: Frameworks) -> None:
    """Every level and command of the stock classes has the law's torque and the spec's numbers."""
    emitted = compiled(RICH)
    motion = grid(emitted)
    answer = ask(frameworks, emitted, motion)
    assert torque_faults(emitted, answer, motion) == []
    assert number_faults(emitted, answer, RICH_NUMBERS) == []
    assert {name: entry["class"] for name, entry in answer.joints.items()} == {
        "left_hip": "DelayedPDActuator",
        "right_hip": "DelayedPDActuator",
        "left_knee": "DCMotor",
        "right_knee": "DCMotor",
        "toe": "IdealPDActuator",
        "wheel": "DCMotor",
        "grip": "IdealPDActuator",
        "lift": "IdealPDActuator",
    }
    assert answer.joints["left_hip"]["lags"] == [2, 2]
    # One stall torque a group in 2.x.
    assert answer.joints["left_knee"]["group"] != answer.joints["right_knee"]["group"]
    assert emitted.emission.approximations == ()


def test_one_damping_field_takes_the_sum(frameworks: Frameworks) -> None:
    """Isaac Lab 2.2 has no working viscous friction: damping is kd + viscous, and the loss has its true size."""
    emitted = compiled(RICH, "2.2")
    motion = grid(emitted, side=81, asked=2.0, speed=2.0)
    answer = ask(frameworks, emitted, motion, version="2.2")
    assert number_faults(emitted, answer, with_one_field(RICH_NUMBERS)) == []
    losses = {
        a.joint: a.max_torque_error for a in emitted.emission.approximations if a.field == "friction.viscous"
    }
    assert set(losses) == {"left_hip", "right_hip", "left_knee", "right_knee"}
    for joint, viscous in (("left_knee", 0.04), ("right_knee", 0.04)):
        column = emitted.joints.index(joint)
        # What the joint feels: the class's torque against the law's with the friction beside it.
        want = expected(emitted, joint, motion) - viscous * motion.qd[0, :, column]
        worst = np.abs(answer.torque[0, :, column] - want).max()
        assert worst == pytest.approx(losses[joint], rel=1e-4)


@pytest.mark.parametrize("version", ["2.2", "2.3"])
def test_anchor_of_the_dc_motor(frameworks: Frameworks, version: str) -> None:
    """kp 25, kd 0.5, L = stall = 23.5, no-load 30: the table that every engine gives."""
    spec = """actspec: 1
robot: {name: anchor, model: none, joints: [j]}
timing: {physics_dt: 5 ms}
motors: {m: {side: joint, stall_torque: 23.5 N*m, no_load_speed: 30 rad/s, peak_torque: 23.5 N*m}}
actuators:
  j: {joints: [j], motor: m, level: dc_motor, kp: 25 N*m/rad, kd: 0.5 N*m*s/rad, effort_limit: 23.5 N*m}
"""
    emitted = compiled(spec, version)
    motion = still(emitted, 1, 6)
    motion.positions[:] = 10.0
    motion.qd[0, :, 0] = [0.0, 15.0, 30.0, 45.0, 60.0, 70.0]
    torque = ask(frameworks, emitted, motion, version=version).torque[0, :, 0]
    np.testing.assert_allclose(torque, [23.5, 11.75, 0.0, -11.75, -23.5, -23.5], atol=1e-5)


@pytest.mark.parametrize("version", ["2.2", "2.3"])
def test_own_class_is_the_whole_law(frameworks: Frameworks, version: str) -> None:
    """`class: custom` has curve, line, bias and clamp of the command, exactly."""
    emitted = compiled(WHOLE, version, "custom")
    motion = grid(emitted)
    # Beyond both ends of c's command range too.
    motion.positions[:, ::5, 2] *= 3.0
    motion.commands[:, ::5, 2] *= 3.0
    answer = ask(frameworks, emitted, motion, version=version)
    # In 2.2 damping is kd + viscous where friction is stated: a and b differ there by as much.
    faults = [f for f in torque_faults(emitted, answer, motion) if version == "2.3" or f[0] not in "ab"]
    assert faults == []
    assert {entry["class"] for entry in answer.joints.values()} == {"WholeActuator"}
    lost = {loss.field for loss in emitted.emission.approximations}
    assert lost == (set() if version == "2.3" else {"friction.viscous", "friction.coulomb"})
    friction = {"a": 0.2, "b": 0.2} if version == "2.3" else {"a": None, "b": None}
    assert number_faults(emitted, answer, {"friction": friction, "armature": {"a": 0.01, "c": None}}) == []


def path_of(emitted: Emitted, joint: str, motion: Motion, env: int, steps: int) -> np.ndarray:
    """Torque over time by the law's own command path, one environment."""
    actuator = emitted.actuators.joint(joint)
    assert actuator is not None
    law, column = law_of(actuator), emitted.joints.index(joint)
    low, high = law.command_range or (-np.inf, np.inf)
    commands = np.clip(motion.commands[:, env, column].astype(np.float32).astype(float), low, high)
    alpha = None
    if law.filter_cutoff is not None:
        alpha = filter_gain(law.filter_cutoff, emitted.actuators.physics_dt.require())
    state = initial_command_state(commands[0], steps)
    out = []
    for k, value in enumerate(commands):
        effective, state = step_command(state, value, steps=steps, alpha=alpha)
        q, qd = motion.q[k, env, column], motion.qd[k, env, column]
        out.append(float(law.torque(effective, q, qd)))
    return np.array(out)


def random_commands(emitted: Emitted, n_step: int, n_env: int) -> Motion:
    """Commands that jump at every step, inside of the limits, the joints held."""
    motion = still(emitted, n_step, n_env)
    rng = np.random.default_rng(11)
    for column, name in enumerate(emitted.joints):
        actuator = emitted.actuators.joint(name)
        assert actuator is not None
        law = law_of(actuator)
        gain = law.kp or law.kd or 1.0
        values = 0.8 * rng.uniform(-1.0, 1.0, (n_step, n_env)) * law.effort_limit / gain
        command(motion, actuator, column, values)
    return motion


@pytest.mark.parametrize(
    "spec, cls, steps",
    [
        (RICH, "auto", {"left_hip": 2, "right_hip": 2, "left_knee": 0, "wheel": 0, "grip": 0}),
        (WHOLE, "custom", {"a": 2, "b": 2, "w": 0, "e": 1, "p": 0}),
    ],
    ids=["stock", "custom"],
)
def test_command_path_over_time(frameworks: Frameworks, spec: str, cls: str, steps: dict[str, int]) -> None:
    """Delay in physics steps, then the filter, from the first command on, as in the law."""
    emitted = compiled(spec, cls=cls)
    motion = random_commands(emitted, 30, 2)
    answer = ask(frameworks, emitted, motion)
    for joint, lag in steps.items():
        got = answer.torque[:, 1, emitted.joints.index(joint)]
        np.testing.assert_allclose(
            got, path_of(emitted, joint, motion, 1, lag), rtol=1e-5, atol=2e-5, err_msg=joint
        )
        whole = slice(None), slice(None), emitted.joints.index(joint)
        # A reset starts its own environment anew; the other still has the last commands on their way.
        np.testing.assert_array_equal(answer.again[whole][:, 0], answer.torque[whole][:, 0])
        if lag:
            assert answer.again[whole][0, 1] != answer.torque[whole][0, 1]
        if cls == "custom":
            # Our own class has its lag before the first reset too.
            np.testing.assert_array_equal(answer.fresh[whole], answer.torque[whole])


@pytest.mark.parametrize("spec, cls", [(RANGED, "auto"), (WHOLE, "custom")], ids=["stock", "custom"])
def test_range_of_delay_is_drawn_by_environment(frameworks: Frameworks, spec: str, cls: str) -> None:
    """Each environment holds one lag of 1 to 4 steps through the episode, and all four occur."""
    emitted = compiled(spec, cls=cls)
    motion = random_commands(emitted, 12, 64)
    answer = ask(frameworks, emitted, motion)
    column = emitted.joints.index("c")
    seen = set()
    for env in range(64):
        fits = [
            lag
            for lag in range(7)
            if np.allclose(
                answer.torque[:, env, column], path_of(emitted, "c", motion, env, lag), rtol=1e-5, atol=2e-5
            )
        ]
        assert len(fits) == 1, f"environment {env}: lags {fits}"
        seen.update(fits)
    assert seen == {1, 2, 3, 4}


def test_implicit_groups_hold_the_solver_s_numbers(frameworks: Frameworks) -> None:
    """`class: implicit` gives every number to the solver, none to the model."""
    emitted = compiled(RICH, cls="implicit")
    answer = ask(frameworks, emitted, still(emitted, 1, 1))
    assert all(entry["implicit"] for entry in answer.joints.values())
    numbers = {key: value for key, value in RICH_NUMBERS.items() if key != "velocity_limit"}
    numbers["effort_limit_sim"] = numbers["effort_limit"]
    assert number_faults(emitted, answer, numbers) == []


@pytest.mark.parametrize("joint, field", [("c", "torque_speed_curve"), ("a", "encoder_bias")])
def test_size_of_a_static_loss_is_what_the_class_does(frameworks: Frameworks, joint: str, field: str) -> None:
    """The worst torque of the real class on the grid of DESIGN 6 is the error that is reported."""
    text = WHOLE.replace("    command_range: [-0.4 rad, 0.5 rad]\n", "")
    emitted = compiled(text)
    motion = grid(emitted, side=81, asked=2.0, speed=2.0)
    answer = ask(frameworks, emitted, motion)
    (loss,) = [a for a in emitted.emission.approximations if (a.joint, a.field) == (joint, field)]
    got = answer.torque[0, :, emitted.joints.index(joint)]
    assert np.abs(got - expected(emitted, joint, motion)).max() == pytest.approx(
        loss.max_torque_error, rel=1e-4
    )


# -- networks --------------------------------------------------------------------------------------

WEIGHTS = [3.0, -7.0, 11.0, 0.5, -0.25, 0.125]
"""Of error now, one and two taps ago, then of the velocity; no two alike, so that order and sign show."""


def network_spec(folder: Path, manifest: dict[str, object], data: bytes) -> str:
    """A spec with a network of two joints, its files written to a folder."""
    (folder / "net.pt").write_bytes(data)
    (folder / "net.json").write_text(json.dumps(manifest), encoding="utf-8")
    return """actspec: 1
robot: {name: netted, model: none, joints: [a, b]}
timing: {physics_dt: 5 ms}
motors: {m: {side: joint, stall_torque: 40 N*m, no_load_speed: 10 rad/s, peak_torque: 30 N*m}}
actuators:
  legs:
    joints: [a, b]
    motor: m
    level: actuator_net
    effort_limit: 30 N*m
    armature: 0.01 kg*m^2
    network: {file: net.pt, manifest: net.json}
"""


def made(frameworks: Frameworks, description: dict[str, object]) -> bytes:
    """A TorchScript file."""
    return frameworks.run_probe(PROBE, {"make": {"net": description}}).arrays["net"].tobytes()


MANIFEST: dict[str, object] = {
    "format": "actspec-network/1",
    "kind": "mlp",
    "inputs": "position_velocity",
    "taps": [0, 1, 2],
    "tap_period": "10 ms",
    "position_scale": -2.0,
    "velocity_scale": 0.5,
    "torque_scale": 4.0,
    "initial_history": "zero",
}


@pytest.mark.parametrize("order", ["position_velocity", "velocity_position"])
def test_mlp_by_file_and_manifest(frameworks: Frameworks, tmp_path: Path, order: str) -> None:
    """Taps two physics steps apart, scales, order and sign of the manifest, cut by the torque-speed line."""
    data = made(frameworks, {"kind": "mlp", "weights": WEIGHTS})
    spec = network_spec(tmp_path, {**MANIFEST, "inputs": order}, data)
    emitted = compiled(spec, path=str(tmp_path / "s.yaml"))
    motion = still(emitted, 14, 1)
    rng = np.random.default_rng(3)
    motion.positions[:] = rng.uniform(-0.4, 0.4, motion.positions.shape)
    motion.q[:] = rng.uniform(-0.4, 0.4, motion.q.shape)
    motion.qd[:] = rng.uniform(-12.0, 12.0, motion.qd.shape)
    answer = ask(frameworks, emitted, motion)
    assert {entry["class"] for entry in answer.joints.values()} == {"ActuatorNetMLP"}
    error, speed = motion.positions - motion.q, motion.qd

    def past(x: np.ndarray, k: int, steps: int) -> np.ndarray:
        return x[k - steps, 0] if k >= steps else np.zeros(2)

    for k in range(14):
        position = [-2.0 * past(error, k, steps) for steps in (0, 2, 4)]
        velocity = [0.5 * past(speed, k, steps) for steps in (0, 2, 4)]
        inputs = position + velocity if order == "position_velocity" else velocity + position
        tau = 4.0 * sum(w * x for w, x in zip(WEIGHTS, inputs, strict=True))
        w = np.clip(speed[k, 0], -17.5, 17.5)  # 10 (1 + 30/40)
        high, low = np.minimum(30.0, 40.0 * (1 - w / 10.0)), np.maximum(-30.0, 40.0 * (-1 - w / 10.0))
        np.testing.assert_allclose(answer.torque[k, 0], np.clip(tau, low, high), rtol=2e-5, atol=2e-5)
    assert emitted.emission.approximations == ()


def test_lstm_loses_its_torque_speed_line(frameworks: Frameworks, tmp_path: Path) -> None:
    """The real class clips as at standstill, which is why the line is reported as lost, with its size."""
    data = made(frameworks, {"kind": "lstm", "seed": 0, "bias": 1e3})
    manifest = {
        **MANIFEST,
        "kind": "lstm",
        "taps": [0],
        "tap_period": "5 ms",
        "position_scale": 1.0,
        "velocity_scale": 1.0,
        "torque_scale": 1.0,
    }
    emitted = compiled(network_spec(tmp_path, manifest, data), path=str(tmp_path / "s.yaml"))
    motion = still(emitted, 3, 1)
    motion.qd[:] = 20.0
    answer = ask(frameworks, emitted, motion)
    assert {entry["class"] for entry in answer.joints.values()} == {"ActuatorNetLSTM"}
    # At twice the no-load speed the line leaves -30 N*m alone; the class gives what the network asks for.
    np.testing.assert_allclose(answer.torque, 30.0)
    # Up to no-load speed 30 N*m are lost, where the line has none; above it 30 against -30.
    losses = {(a.joint, a.field): (a.max_torque_error, a.beyond) for a in emitted.emission.approximations}
    assert losses == {
        ("a", "torque_speed_curve"): (pytest.approx(30.0), pytest.approx(60.0)),
        ("b", "torque_speed_curve"): (pytest.approx(30.0), pytest.approx(60.0)),
    }


# -- seeded mistakes -------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "old, new, fault",
    [
        ("damping=2.0,", "damping=2.0,", ""),
        ("damping=2.0,", "damping=2.04,", "left_knee damping"),
        ("max_delay=2,", "max_delay=3,", "left_hip lag"),
        ("min_delay=2,  # physics steps of 5 ms; authored\n        max_delay=2,", "", "left_hip lag"),
        ("effort_limit=20.0,", "effort_limit=45.0,", "left_knee torque"),
        ('            "left_hip": 90.0,\n', "", "left_hip stiffness"),
        ('            "left_hip": 25.0,\n', "", "left_hip torque"),
        ("velocity_limit=25.0,", "velocity_limit=30.0,", "right_knee torque"),
        ("dynamic_friction=0.3,", "dynamic_friction=0.5,", "left_hip dynamic_friction"),
        ("viscous_friction=0.05,", "", "left_hip viscous_friction"),
    ],
    ids=[
        "none",
        "viscous-in-kd",
        "lag-one-off",
        "lag-lost",
        "saturation-for-limit",
        "gains-miss-a-joint",
        "limits-miss-a-joint",
        "another-motor-s-speed",
        "static-for-dynamic",
        "viscous-lost",
    ],
)
def test_a_seeded_mistake_is_found(frameworks: Frameworks, old: str, new: str, fault: str) -> None:
    """The comparisons above turn red when the emitted text is wrong in one place."""
    emitted = compiled(RICH)
    assert old in emitted.text
    text = emitted.text.replace(old, new)
    # The grid first, then commands that jump, so that a lag shows.
    first, then = grid(emitted), random_commands(emitted, 6, 625)
    motion = still(emitted, 7, 625)
    for name in ("positions", "velocities", "efforts", "commands"):
        getattr(motion, name)[:1] = getattr(first, name)
        getattr(motion, name)[1:] = getattr(then, name)
    motion.q[:], motion.qd[:] = first.q, first.qd
    answer = ask(frameworks, emitted, motion, text=text)
    found = torque_faults(emitted, answer, motion) + number_faults(emitted, answer, RICH_NUMBERS)
    # Where the joint is slow the limits leave the commands to be seen; a lag may be drawn by environment.
    slowest = np.argsort(np.abs(motion.qd[0, :, 0]))[:8]
    for joint in ("left_hip", "right_hip"):
        got = answer.torque[:, :, emitted.joints.index(joint)]
        for env in slowest:
            if not np.allclose(got[:, env], path_of(emitted, joint, motion, env, 2), rtol=1e-5, atol=2e-5):
                found.append(f"{joint} lag")
    if not fault:
        assert found == []
        return
    assert any(item.startswith(fault) for item in found), found


@pytest.mark.parametrize("version", ["2.2", "2.3"])
def test_a_delay_in_seconds_is_refused_at_a_reset(frameworks: Frameworks, version: str) -> None:
    """What DLY101 says of a `max_delay` that is no whole number: 0.02 is neither 4 steps nor none."""
    emitted = compiled(RICH, version)
    assert "max_delay=2," in emitted.text
    text = emitted.text.replace("max_delay=2,", "max_delay=0.02,")
    with pytest.raises(EngineError, match=r"(?s)in reset.*randint.*TypeError: randint\(\)"):
        ask(frameworks, emitted, still(emitted, 2, 1), version=version, text=text)
