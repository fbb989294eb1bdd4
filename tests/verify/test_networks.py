"""Networks in `actspec verify`: their law along courses, MuJoCo's runtime, and whose program may run."""

from __future__ import annotations

import io
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from actspec import api
from actspec.laws.network import Layers
from actspec.simulate.excitation import COURSES, network_courses
from actspec.simulate.reference import held_network_torque
from actspec.verify.agreement import Agreement, TargetFiles
from actspec.verify.execution import runnable
from actspec.verify.joint_laws import JointLaws, laws_of, motions_of
from actspec.verify.run import lay_out
from tests.learn import netted
from tests.learn.test_files import lstm, perceptron
from tests.verify.making import Built, replaced

torch = pytest.importorskip("torch")


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """Two legs by a network and an arm by a law, compiled."""
    folder = tmp_path_factory.mktemp("net")
    netted.build(folder)
    done = api.compile(folder / "spec.yaml", output=str(folder / "out"))
    found = lay_out(list(zip(done.targets, done.emissions, strict=True)), None)
    return Built(done, {target.name: target for target in found}, folder)


@pytest.fixture(scope="module")
def laws(built: Built) -> JointLaws:
    """Of its joints."""
    return laws_of(built.compilation.actuators)


def rows(agreement: Agreement) -> dict[tuple[str, str], object]:
    """Group and quantity to whether it agrees."""
    return {(r.group, r.quantity): r.ok for r in agreement.rows if r.quantity.startswith("torque")}


@pytest.mark.slow
def test_runtime_agrees(built: Built) -> None:
    """MuJoCo with the runtime has the network's torque within 1e-5 of the limit, beside a drive with a law."""
    agreement = built.verified("mujoco", engines=True)
    assert [row.message for row in agreement.faults] == []
    (row,) = (row for row in agreement.rows if row.quantity == COURSES)
    assert (row.group, row.joints, row.approximations) == ("legs", 2, ())
    assert (
        row.tolerance == pytest.approx(6e-5, rel=0.2) and row.max_error is not None and row.max_error < 2e-5
    )
    assert rows(agreement)["arm", "torque"]


@pytest.mark.slow
@pytest.mark.parametrize(
    "old, new, most",
    [
        # 9 N*m (1 - w/w0) is 6 N*m at w0/3, where 8 N*m give 5.33
        ('"stall_torque": 8.0', '"stall_torque": 9.0', 2.0 / 3.0),
        ('"effort_limit": 6.0', '"effort_limit": 5.0', 1.0),
    ],
)
def test_another_clamp_is_found(old: str, new: str, most: float, built: Built) -> None:
    """A line or limit in networks.json that is not the spec's shows in the torque of that joint."""
    agreement = built.verified("mujoco", replaced(old, new), file="networks.json", engines=True)
    faults = [row for row in agreement.faults if row.quantity == COURSES]
    assert [(row.code, row.joint, row.joints) for row in faults] == [("VFY100", "hip", 1)]
    error = faults[0].max_error
    assert error is not None and 0.5 * most < error <= most + 1e-5
    assert rows(agreement)["arm", "torque"]


@pytest.mark.slow
def test_terms_that_cancel_are_no_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """50000 N*m less 50000 N*m is off by 1e-3 N*m in single precision, 20 times 1e-5 of the limit."""
    weights = np.array([netted.WEIGHTS[0] / 50.0, netted.WEIGHTS[0] / 50.0 * 1.0001])
    monkeypatch.setattr(netted, "layers", lambda: [(weights, [0.0, 0.0], "Tanh"), ([[-5e4, 5e4]], [0.0], "")])
    netted.build(tmp_path)
    _, agreement = api.verify(tmp_path / "spec.yaml", targets=["mujoco"])
    assert [row.message for row in agreement.faults] == []
    (row,) = (row for row in agreement.rows if row.quantity == COURSES)
    assert row.max_error is not None and row.max_error > 3 * 6e-5


def test_law_of_a_course(built: Built) -> None:
    """The law is that of the formula, its command clamped, late by two steps and its position biased."""
    actuators = built.compilation.actuators
    drive = laws_of(actuators).networks["knee"]
    rng = np.random.default_rng(0)
    command, q, qd = (rng.normal(scale=s, size=(9, 4)) for s in (1.0, 0.3, 6.0))
    clip = replace(drive.clip, command_range=(-0.5, 0.8), encoder_bias=0.1)
    given = np.clip(command, -0.5, 0.8)
    late = np.concatenate([given[:1], given[:1], given[:-2]])
    expected = netted.torques(late - q - 0.1, qd)
    found = held_network_torque(replace(drive, clip=clip), command, q, qd, 0.005, 2)
    assert found == pytest.approx(expected, abs=1e-4)
    assert np.ptp(expected) > 10.0


def test_courses_go_to_every_corner(laws: JointLaws) -> None:
    """Errors to twice the training data's and speeds to twice the line's end, in both signs together."""
    motion = network_courses([laws.networks["hip"]], 0.005)
    error, qd = (motion.command - motion.q)[..., 0], motion.qd[..., 0]
    # the manifest has 1 rad, the line 10 rad/s; the oldest sample is 2 steps back
    assert len(error) == 2 + 24
    assert [error.min(), error.max()] == pytest.approx([-2.0, 2.0], abs=0.01)
    assert [qd.min(), qd.max()] == pytest.approx([-20.0, 20.0], abs=0.01)
    for e, w in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        assert ((e * error > 0.5) & (w * qd > 10.0)).any()


def test_columns_are_the_robots(laws: JointLaws, built: Built) -> None:
    """A joint that is not asked in a motion is held at 0; the others are where they are asked."""
    moves = motions_of(laws, 0.005)
    at = laws.columns
    assert list(at) == ["hip", "knee", "arm"]
    assert not moves[COURSES].command[..., at["arm"]].any() and moves[COURSES].command[..., at["knee"]].any()
    assert not moves["torque"].command[..., at["hip"]].any() and moves["torque"].command[..., at["arm"]].any()


def test_without_onnx_there_is_no_law(built: Built) -> None:
    """A network whose file is a program alone is passed over, with what would change that."""
    actuators = built.compilation.actuators
    (built.folder / "other.json").write_text(
        (built.folder / "net.json").read_text().replace('"onnx"', '"torchscript"')
    )
    joints = tuple(
        replace(a, network=replace(a.network, manifest=str(built.folder / "other.json"))) if a.network else a
        for a in actuators.joints
    )
    found = laws_of(replace(actuators, joints=joints))
    assert set(found.laws) == {"arm"} and not found.networks
    reason, help = found.skipped["legs"]
    assert "no ONNX file" in reason and help is not None and "net convert" in help


@pytest.mark.slow
def test_own_program() -> None:
    """A program is actspec's own whatever its weights and torch's numbering; another's is not."""
    from actspec.learn.files import torchscript_bytes
    from actspec.learn.torchscript import same_program

    def is_own(data: bytes, layers: Layers) -> bool:
        return same_program(data, torchscript_bytes(layers))

    for layers in (perceptron(), lstm(1), lstm(2)):
        torchscript_bytes(perceptron("tanh"))
        assert is_own(torchscript_bytes(layers), layers)
    assert is_own(torchscript_bytes(perceptron(seed=1)), perceptron())
    assert not is_own(torchscript_bytes(perceptron("tanh")), perceptron())
    stream = io.BytesIO()
    torch.jit.save(torch.jit.trace(torch.nn.Sequential(torch.nn.Linear(4, 3)), torch.zeros(1, 4)), stream)
    assert not is_own(stream.getvalue(), perceptron())
    assert not is_own(b"PK\x03\x04", perceptron()) and not is_own(b"", perceptron())


@pytest.mark.slow
def test_a_strangers_program_needs_trust(built: Built, laws: JointLaws, tmp_path: Path) -> None:
    """Without --trust its joints are passed over, and the others are asked."""
    from actspec.learn.files import torchscript_bytes

    options = replace(built.targets["mujoco"].options, kind="isaaclab")
    target = TargetFiles(options, str(tmp_path), str(tmp_path), ("cfg.py", "net.pt"), ())
    module = torch.jit.trace(torch.nn.Sequential(torch.nn.Linear(4, 2), torch.nn.Tanh()), torch.zeros(1, 4))
    torch.jit.save(module, tmp_path / "net.pt")
    found = runnable(target, laws, run_edited=False, trust=False)
    assert [a.joint for a in found.joints] == ["arm"] and set(motions_of(found, 0.005)) == {
        *("torque", "torque.step", "torque.ramp")
    }
    reason, help = found.skipped["legs"]
    assert "net.pt is TorchScript" in reason and help is not None and "--trust" in help
    assert runnable(target, laws, run_edited=False, trust=True) is laws
    (tmp_path / "net.pt").write_bytes(torchscript_bytes(laws.networks["hip"].network.layers))
    assert runnable(target, laws, run_edited=False, trust=False) is laws
