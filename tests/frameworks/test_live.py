"""`actspec.mjlab` and `actspec.isaaclab` where the frameworks are: their own objects, with the spec's numbers."""

from __future__ import annotations

import json
import sysconfig
from pathlib import Path
from typing import Any

import pytest

from tests.frameworks import isaaclab_asking, mjlab_asking
from tests.frameworks.isaaclab_asking import USD, WHEELS
from tests.frameworks.isaaclab_specs import WHOLE
from tests.frameworks.prepare import Frameworks

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
A1 = ROOT / "robots" / "a1.yaml"
PATHS = [str(ROOT), sysconfig.get_paths()["purelib"]]
"""What actspec is imported from there, behind the frameworks' own packages."""

NETS = """actspec: 1
robot: {name: bot, model: none, joints: [a, b, c]}
timing: {physics_dt: 5 ms}
actuators:
  one: {joints: [a], level: actuator_net, effort_limit: 9 N*m, network: {file: x/net.pt, manifest: x/net.json}}
  two: {joints: [b], level: actuator_net, effort_limit: 8 N*m, network: {file: y/net.pt, manifest: x/net.json}}
  pd: {joints: [c], level: ideal_pd, kp: 20 N*m/rad, kd: 0.7 N*m*s/rad, effort_limit: 7 N*m}
"""

MANIFEST = {
    "format": "actspec-network/1",
    "kind": "mlp",
    "inputs": "position_velocity",
    "taps": [0, 1],
    "tap_period": "5 ms",
    "position_scale": 1.0,
    "velocity_scale": 1.0,
    "torque_scale": 1.0,
    "initial_history": "first_sample",
}


def isaaclab(
    frameworks: Frameworks, spec: Path, joints: list[str], version: str = "2.3"
) -> dict[str, dict[str, Any]]:
    """Each group of `actspec.isaaclab.actuators`: its cfg, and the numbers of the actuator that it makes."""
    job = {
        "root": str(frameworks.isaaclab(WHEELS[version])),
        "live": str(spec),
        "paths": [*PATHS, str(frameworks.folder / f"isaaclab-{WHEELS[version]}")],
        "joints": joints,
        "usd": USD,
    }
    return frameworks.run_probe(isaaclab_asking.PROBE, job).said


def mjlab(frameworks: Frameworks, spec: Path) -> dict[str, Any]:
    """The articulation's class, and class and fields of each actuator cfg."""
    job = {"live": {"live": str(spec), "paths": PATHS}}
    found: dict[str, Any] = frameworks.run_probe(mjlab_asking.PROBE, job).said["live"]
    return found


def networks(frameworks: Frameworks, folder: Path) -> None:
    """Two networks of one name, x/net.pt and y/net.pt, with other weights."""
    described = {name: {"kind": "mlp", "weights": [w, 0.0, 0.0, 0.0]} for name, w in (("x", 1.0), ("y", 2.0))}
    made = frameworks.run_probe(isaaclab_asking.PROBE, {"make": described}).arrays
    for name, data in made.items():
        (folder / name).mkdir()
        (folder / name / "net.pt").write_bytes(data.tobytes())
    (folder / "x" / "net.json").write_text(json.dumps(MANIFEST), encoding="utf-8")


LEGS = [f"{leg}_{part}_joint" for leg in ("FR", "FL", "RR", "RL") for part in ("hip", "thigh", "calf")]


@pytest.mark.parametrize("version", ["2.2", "2.3"])
def test_isaaclab_a1(frameworks: Frameworks, version: str) -> None:
    """The A1's actuators are Isaac Lab's own cfgs, for the version whose metadata is there."""
    ((name, legs),) = isaaclab(frameworks, A1, LEGS, version).items()
    assert (name, legs["cfg"], legs["joints"]) == ("legs", "DCMotorCfg", LEGS)
    expected = {
        "stiffness": 25.0,
        # Isaac Lab 2.2 has no viscous friction that works: 0.5 + 0.01.
        "damping": 0.5 if version == "2.3" else 0.51,
        "effort_limit": 33.5,
        "velocity_limit": 21.0,
        "armature": 0.01,
        "viscous_friction": 0.01 if version == "2.3" else USD,
    }
    assert {key: legs[key] for key in expected} == {
        key: pytest.approx([value] * 12) for key, value in expected.items()
    }
    # kp, kd, limit, line (2), armature, and viscous friction where the class has it; no version says what friction is.
    count, wrong = legs["compared"]
    assert count == 12 * (7 if version == "2.3" else 6)
    assert len(wrong) == (0 if version == "2.3" else 1)
    assert all(
        "the drive gain kd is 0.51 N*m*s/rad (actuators['legs'].damping), 0.5 " in line for line in wrong
    )


def test_isaaclab_class_of_the_robot(frameworks: Frameworks, tmp_path: Path) -> None:
    """`class: custom` gives the robot's own class, which builds, copies, and is found again by its name."""
    spec = tmp_path / "whole.yaml"
    spec.write_text(f"{WHOLE}targets: {{isaaclab: {{class: custom}}}}\n", encoding="utf-8")
    found = isaaclab(frameworks, spec, ["a", "b", "c", "w", "e", "p"])
    assert {group["cfg"] for group in found.values()} == {"WholeActuatorCfg"}
    assert all(group["by_name"] for group in found.values())
    assert found["line"]["effort_limit"] == pytest.approx([20.0, 18.0])


def test_isaaclab_networks(frameworks: Frameworks, tmp_path: Path) -> None:
    """Networks are the spec's own files, each its group's though they share a name, and load."""
    networks(frameworks, tmp_path)
    spec = tmp_path / "nets.yaml"
    spec.write_text(NETS, encoding="utf-8")
    found = isaaclab(frameworks, spec, ["a", "b", "c"])
    assert {name: (group["cfg"], group["network_file"]) for name, group in found.items()} == {
        "one": ("ActuatorNetMLPCfg", str(tmp_path / "x" / "net.pt")),
        "two": ("ActuatorNetMLPCfg", str(tmp_path / "y" / "net.pt")),
        "pd": ("IdealPDActuatorCfg", None),
    }


def test_mjlab_a1(frameworks: Frameworks) -> None:
    """`actspec.mjlab.articulation` is mjlab's own object with the spec's numbers."""
    found = mjlab(frameworks, A1)
    assert found["class"] == "EntityArticulationInfoCfg"
    ((kind, fields),) = found["actuators"]
    assert kind == "DcMotorActuatorCfg"
    expected = {
        "stiffness": 25.0,
        "damping": 0.5,
        "effort_limit": 33.5,
        "velocity_limit": 21.0,
        "armature": 0.01,
    }
    assert fields | expected == fields
    # kp, kd, limit, line (2), armature, dry friction, viscous friction.
    assert found["compared"] == [12 * 8, []]


def test_mjlab_network(frameworks: Frameworks, tmp_path: Path) -> None:
    """A network is the spec's own file."""
    networks(frameworks, tmp_path)
    spec = tmp_path / "nets.yaml"
    two = next(line for line in NETS.splitlines() if line.startswith("  two:"))
    text = NETS.replace(f"{two}\n", "").replace("[a, b, c]", "[a, c]")
    spec.write_text(text, encoding="utf-8")
    files = {kind: fields.get("network_file") for kind, fields in mjlab(frameworks, spec)["actuators"]}
    assert files == {
        "LearnedMlpActuatorCfg": str(tmp_path / "x" / "net.pt"),
        "BuiltinPositionActuatorCfg": None,
    }
