"""What the real simulators execute for `actspec verify`: what actspec wrote, and nothing that lies beside it."""

from __future__ import annotations

import json
import pickle
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from actspec.verify.agreement import Agreement
from actspec.verify.run import verify
from tests.frameworks.prepare import Frameworks
from tests.network_files import torchscript
from tests.verify.making import SPEC, Built, build

pytestmark = pytest.mark.slow

MANIFEST: dict[str, Any] = {
    "format": "actspec-network/1",
    "kind": "mlp",
    "inputs": "position_velocity",
    "taps": [0],
    "tap_period": "5 ms",
    "position_scale": 1.0,
    "velocity_scale": 1.0,
    "torque_scale": 1.0,
    "initial_history": "zero",
}

HEAD = SPEC[: SPEC.index("actuators:")]
MIXED = """actuators:
  hips:
    joints: [".*_hip"]
    level: ideal_pd
    kp: 40
    kd: 1.5
    effort_limit: 22.5 N*m
  knees:
    joints: [".*_knee"]
    motor: drive
    reduction: 1.5
    level: actuator_net
    effort_limit: 33 N*m
    network: {file: %s, manifest: net.json}
  lift: {joints: [lift], level: ideal_pd, command: velocity, kd: 300, effort_limit: 150 N}
targets:
  %s
"""
"""A spec with a network for the knees."""

NEWTON = 'newton: {version: "%s", joint_paths: {".*": "joints/{joint}"}}'


class Trap:
    """Leaves a mark when it is unpickled."""

    def __init__(self, marker: Path) -> None:
        self.marker = marker

    def __reduce__(self) -> tuple[object, tuple[str, str]]:
        return open, (str(self.marker), "w")


def mixed(folder: Path, network: str, targets: str) -> Built:
    """The spec with a file for a network that is none."""
    (folder / "net.json").write_text(json.dumps(MANIFEST), "utf-8")
    (folder / network).write_bytes(torchscript())
    return build(folder, HEAD + MIXED % (network, targets))


def asked(agreement: Agreement) -> set[str]:
    """Groups whose torque an engine computed and that agree."""
    return {row.group for row in agreement.rows if row.quantity == "torque" and row.ok}


@pytest.mark.parametrize(
    "targets, name",
    [('isaaclab: {version: "2.3"}', "isaaclab"), ('mjlab: {version: "1.6"}', "mjlab")],
    ids=["isaaclab", "mjlab"],
)
def test_network_is_not_loaded(targets: str, name: str, tmp_path: Path, frameworks: Frameworks) -> None:
    """Beside a network, which would be a program, the other groups are asked; it is not loaded, for it is none."""
    agreement = mixed(tmp_path, "net.pt", targets).verified(name, engines=True)
    assert [row.message for row in agreement.faults] == []
    assert asked(agreement) == {"hips", "lift"}
    assert ("knees", "torque") in {(skip.group, skip.what) for skip in agreement.skipped}


def test_overlay_that_names_a_checkpoint(tmp_path: Path, frameworks: Frameworks) -> None:
    """Older Newtons unpickle what an overlay names; here torch cannot be imported, and the file is refused."""
    built = build(tmp_path, SPEC[: SPEC.index("targets:")] + f"targets: {{{NEWTON % '1.6'}}}\n")
    marker = tmp_path / "unpickled"
    checkpoint = tmp_path / "evil.pt"
    checkpoint.write_bytes(pickle.dumps(Trap(marker)))

    def edit(text: str) -> str:
        assert "newton:kp = 40.0" in text
        text = text.replace('"NewtonPDControlAPI"', '"NewtonNeuralControlAPI"')
        return text.replace("newton:kp = 40.0", f"newton:none = 1\n asset newton:modelPath = @{checkpoint}@")

    agreement = built.verified("newton", edit, engines=True)
    assert not marker.exists()
    assert not agreement.ok


@pytest.mark.parametrize("run_edited", [False, True], ids=["as compiled", "with consent"])
def test_compiled_code_beside_a_file(run_edited: bool, tmp_path: Path, frameworks: Frameworks) -> None:
    """What lies in `__pycache__` is not what the file says, and is not executed in its place."""
    built = build(tmp_path)
    target = built.targets["isaaclab"]
    copy = Path(shutil.copytree(target.folder, tmp_path / "theirs"))
    marker, path = tmp_path / "executed", copy / target.files[0]
    text = path.read_bytes()
    path.write_bytes(text + f"\nopen({str(marker)!r}, 'w').close()\n".encode())
    compiling = "import py_compile, sys; py_compile.compile(sys.argv[1], invalidation_mode=py_compile.%s)"
    mode = "PycInvalidationMode.UNCHECKED_HASH"
    subprocess.run([frameworks.python(), "-c", compiling % mode, path], check=True)
    path.write_bytes(text)
    assert list(copy.glob("__pycache__/rich_cfg.*.pyc"))
    done = built.compilation
    theirs = replace(target, folder=str(copy))
    agreement = verify(
        done.actuators, done.robot, [theirs], spec="spec.yaml", engines=True, run_edited=run_edited
    )
    assert not marker.exists()
    assert agreement.ok and asked(agreement) == {"hips", "knees", "lift"}
