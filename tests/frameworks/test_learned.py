"""One network, written once: the real classes of Isaac Lab, mjlab and Newton, and MuJoCo's runtime, give its torque."""

from __future__ import annotations

import shlex
import shutil
from pathlib import Path
from typing import Any

import pytest
import torch

from actspec import api
from actspec.cli.main import main
from actspec.laws.network import Layers
from actspec.learn.files import write_network
from actspec.simulate.excitation import COURSES
from actspec.verify.agreement import Agreement
from tests.frameworks.prepare import Frameworks
from tests.learn.test_files import lstm, perceptron
from tests.verify.making import Built, build, replaced

pytestmark = [pytest.mark.engine, pytest.mark.slow]

MODEL = """<mujoco model="netted">
  <option timestep="0.005" integrator="implicitfast"/>
  <worldbody>
    <body name="a"><joint name="hip" axis="0 1 0"/><geom size=".05" pos="0 0 -.1" mass="1"/></body>
    <body name="b" pos="1 0 0"><joint name="knee" axis="0 1 0"/><geom size=".05" pos="0 0 -.1" mass="1"/></body>
    <body name="c" pos="2 0 0"><joint name="arm" axis="0 1 0"/><geom size=".05" pos="0 0 -.1" mass="1"/></body>
  </worldbody>
</mujoco>
"""
SPEC = """actspec: 1
robot: {name: netted, model: netted.xml}
timing: {physics_dt: 5 ms}
motors: {m: {side: joint, stall_torque: 4 N*m, no_load_speed: 10 rad/s, peak_torque: 3 N*m}}
actuators:
  hip: {joints: [hip], level: actuator_net, motor: m, armature: 0.01 kg*m^2, network: {manifest: mlp.json}}
  knee: {joints: [knee], level: actuator_net, motor: m, armature: 0.01 kg*m^2, network: {manifest: %s.json},
    delay: 10 ms, encoder_bias: 0.05 rad}
  arm: {joints: [arm], level: ideal_pd, kp: 20 N*m/rad, kd: 1 N*m*s/rad, effort_limit: 5 N*m, armature: 0.01 kg*m^2}
targets: {%s}
"""
TARGETS = {
    "mujoco": 'mujoco: {version: "3.11"}',
    "isaaclab": 'isaaclab: {version: "2.3"}',
    "newton": 'newton: {version: "1.8"}',
    "mjlab": 'mjlab: {version: "1.6"}',
}
CONVENTIONS: dict[str, Any] = {
    "inputs": "position_velocity",
    "tap_period": "5 ms",
    "position_scale": 1.0,
    "velocity_scale": 1.0,
    "torque_scale": 1.0,
    "initial_history": "zero",
}


def write(path: Path, layers: Layers) -> None:
    """A network's three files."""
    taps = [0] if layers.recurrent else [0, 1]
    write_network(str(path), layers, {**CONVENTIONS, "taps": taps})


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """A perceptron, an LSTM behind a delay with a biased encoder, and a law, for the three that take an LSTM."""
    folder = tmp_path_factory.mktemp("learned")
    write(folder / "mlp", perceptron())
    write(folder / "lstm", lstm(1))
    chosen = ", ".join(TARGETS[name] for name in ("mujoco", "isaaclab", "newton"))
    return build(folder, SPEC % ("lstm", chosen), MODEL, "netted.xml")


def judged(agreement: Agreement) -> dict[str, tuple[bool, tuple[str, ...]]]:
    """Group to whether its torque agrees within 1e-5 of the limit of 3 N*m, and what was known to be lost of it."""
    found = {}
    for row in agreement.rows:
        if row.quantity == COURSES:
            assert row.tolerance == pytest.approx(3e-5, rel=0.2) and row.max_error is not None
            assert row.ok is (row.max_error <= 3e-5)
            found[row.group] = (row.ok, row.approximations)
    return found


@pytest.mark.parametrize(
    "name, lost",
    [
        ("mujoco", ("mujoco.delay",)),
        # The LSTM's class clips as if the joint stood still.
        ("isaaclab", ("isaaclab.torque_speed_curve", "isaaclab.delay", "isaaclab.encoder_bias")),
        ("newton", ("newton.encoder_bias",)),
    ],
)
def test_perceptron_and_lstm(name: str, lost: tuple[str, ...], built: Built, frameworks: Frameworks) -> None:
    """Each holds both networks along courses, clamp and line included, but for what it is known to lose."""
    agreement = built.verified(name, engines=True)
    assert [row.message for row in agreement.faults] == []
    assert judged(agreement) == {"hip": (True, ()), "knee": (True, lost)}
    assert {row.group for row in agreement.rows if row.quantity == "torque"} == {"arm"}


def test_mjlab(tmp_path: Path, frameworks: Frameworks) -> None:
    """mjlab has the delay, begins a history with its first sample, and runs another's program by consent alone."""
    write(tmp_path / "mlp", perceptron())
    made = build(tmp_path, SPEC % ("mlp", TARGETS["mjlab"]), MODEL, "netted.xml")
    agreement = made.verified("mjlab", engines=True)
    assert [row.message for row in agreement.faults] == []
    first = "mjlab.network.initial_history"
    assert judged(agreement) == {"hip": (True, (first,)), "knee": (True, (first, "mjlab.encoder_bias"))}


def test_taps_in_another_order_are_found(built: Built, frameworks: Frameworks) -> None:
    """What only a history shows: Isaac Lab gets the older sample first."""
    agreement = built.verified("isaaclab", replaced("input_idx=[0, 1]", "input_idx=[1, 0]"), engines=True)
    assert judged(agreement)["hip"] == (False, ())
    assert [row.code for row in agreement.faults if row.quantity == COURSES] == ["VFY100"]


def test_a_strangers_program_by_consent(tmp_path: Path, frameworks: Frameworks) -> None:
    """A TorchScript of the same numbers by another program runs with `trust` alone, and agrees then."""
    write(tmp_path / "mlp", perceptron())
    whole = torch.jit.load(str(tmp_path / "mlp.pt"))

    class Other(torch.nn.Module):
        def __init__(self) -> None:
            super().__init__()
            self.net = whole

        def forward(self, x: torch.Tensor) -> torch.Tensor:
            return self.net(x) + 0.0

    torch.jit.save(torch.jit.script(Other()), str(tmp_path / "other.pt"))
    (tmp_path / "netted.xml").write_text(MODEL)
    spec = SPEC % ("mlp", TARGETS["isaaclab"])
    (tmp_path / "spec.yaml").write_text(spec.replace("network: {", "network: {file: other.pt, "))
    _, kept = api.verify(tmp_path / "spec.yaml")
    assert kept.ok and judged(kept) == {}
    assert {skip.group for skip in kept.skipped if skip.help and "--trust" in skip.help} == {"hip", "knee"}
    _, run = api.verify(tmp_path / "spec.yaml", trust=True)
    assert {group: ok for group, (ok, _) in judged(run).items()} == {"hip": True, "knee": True}


@pytest.fixture(scope="module")
def logged(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """docs/networks.md: the A1's spec, and log.csv of 12 joints of a virtual robot."""
    folder = tmp_path_factory.mktemp("trained")
    shutil.copytree(Path(__file__).resolve().parents[2] / "robots", folder / "robots")
    ran(
        f'sysid design {folder}/robots/a1.yaml -o {folder}/c.csv --experiment random --together --duration "4 s" '
        '--rate "200 Hz"',
        f"sysid simulate {folder}/robots/a1.yaml --command {folder}/c.csv -o {folder}/log.csv --seed 1",
    )
    return folder


def ran(*commands: str) -> None:
    """Commands of actspec that succeed."""
    for command in commands:
        assert main(shlex.split(command)) in (0, 1), command


@pytest.mark.parametrize(
    "options, targets",
    [
        ("--hidden 16", ["mujoco", "isaaclab", "mjlab", "newton"]),
        # mjlab has no class for one.
        ("--kind lstm --hidden 16", ["mujoco", "isaaclab", "newton"]),
    ],
)
def test_a_trained_network_everywhere(
    options: str, targets: list[str], logged: Path, tmp_path: Path, frameworks: Frameworks
) -> None:
    """From a virtual robot's log by the documented commands to one torque in every simulator."""
    shutil.copytree(logged / "robots", tmp_path / "robots")
    spec = tmp_path / "robots" / "a1.yaml"
    nets = tmp_path / "robots" / "nets" / "legs"
    ran(f"net train {spec} {logged}/log.csv -o {nets} --torque-of drive {options} --epochs 2")
    network = "{legs: {level: actuator_net, network: {manifest: nets/legs.json}}}"
    spec.write_text(f"{spec.read_text()}variant: law\nvariants:\n  net: {{actuators: {network}}}\n")
    _, agreement = api.verify(f"{spec}#net", targets=targets)
    assert [row.message for row in agreement.faults] == []
    found = {row.target: row for row in agreement.rows if row.quantity == COURSES}
    assert set(found) == set(targets)
    for row in found.values():
        assert row.joints == 12 and row.max_error is not None and row.max_error < 33.5e-5
