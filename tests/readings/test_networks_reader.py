"""Networks that a configuration names: what is found of them without opening them."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from actspec.diagnostics import Span
from actspec.readings import networks
from actspec.readings.artifact import ActuatorGroup, Framework, RobotConfig, Setting
from actspec.readings.named_network import NetworkReading
from actspec.readings.networks import with_networks

MANIFEST = {
    "format": "actspec-network/1",
    "kind": "mlp",
    "inputs": "velocity_position",
    "taps": [0, 2],
    "tap_period": "20 ms",
    "position_scale": -1.0,
    "velocity_scale": 0.1,
    "torque_scale": 20.0,
    "initial_history": "zero",
}


def read(cfg: Path, file: str, name: str = "network_file") -> NetworkReading | None:
    """What is known of a network that a configuration at `cfg` names."""
    place = Span(str(cfg), 3, 5)
    group = ActuatorGroup("legs", "ActuatorNetMLPCfg", place, (".*",), {name: Setting(file, place)})
    config = RobotConfig(Framework.ISAACLAB, "DOG_CFG", place, (group,), {})
    return with_networks(config).groups[0].network


@pytest.mark.parametrize("file", ["{NUCLEUS}/leg.pt", "omniverse://host/leg.pt", "", "a\0b.pt"])
def test_what_is_not_local_is_not_looked_for(tmp_path: Path, file: str) -> None:
    """A path with an unknown part, of a server, without text or with NUL is nobody's local file."""
    found = read(tmp_path / "cfg.py", file)
    assert found is not None
    assert (found.local, found.path, found.manifest, found.problem) == (False, None, None, None)


def test_network_in_a_folder_above(tmp_path: Path) -> None:
    """A relative path is taken from the configuration's folder first, then from each folder above it."""
    (tmp_path / "source" / "robots").mkdir(parents=True)
    (tmp_path / "nets").mkdir()
    (tmp_path / "nets" / "leg.pt").write_bytes(b"")
    found = read(tmp_path / "source" / "robots" / "cfg.py", "nets/leg.pt")
    assert found is not None and found.path == str(tmp_path / "nets" / "leg.pt")
    (tmp_path / "source" / "robots" / "nets").mkdir()
    (tmp_path / "source" / "robots" / "nets" / "leg.pt").write_bytes(b"")
    found = read(tmp_path / "source" / "robots" / "cfg.py", "nets/leg.pt", "actuator_net_file")
    assert found is not None and found.path == str(tmp_path / "source" / "robots" / "nets" / "leg.pt")


def test_manifest_without_its_network(tmp_path: Path) -> None:
    """The manifest is read where the network would lie, in SI units: 20 ms are 0.02 s."""
    (tmp_path / "leg.json").write_text(json.dumps(MANIFEST), encoding="utf-8")
    found = read(tmp_path / "cfg.py", "leg.pt")
    assert found is not None and found.manifest is not None
    assert (found.local, found.path, found.problem) == (True, None, None)
    manifest = found.manifest
    assert (manifest.kind, manifest.velocity_first, manifest.taps) == ("mlp", True, (0, 2))
    assert manifest.tap_period == pytest.approx(0.02)
    scales = (manifest.position_scale, manifest.velocity_scale, manifest.torque_scale)
    assert scales == (-1.0, 0.1, 20.0)
    assert manifest.path == str(tmp_path / "leg.json")


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("{}", None),
        ('{"note": "actspec-network/1"', "this mapping lacks a `,` or its `}`"),
        (json.dumps({**MANIFEST, "taps": []}), "taps: must have at least 1 entry, got 0"),
        ('{"format": "actspec-network/1", "a": ' + "[" * 5000, None),
        ('{"format": "actspec-network/1"}' + " " * networks.MAX_MANIFEST, None),
    ],
    ids=["no-manifest", "not-closed", "no-taps", "deep", "large"],
)
def test_manifests_that_are_none(tmp_path: Path, text: str, problem: str | None) -> None:
    """A JSON of somebody else's is none, a broken manifest says why, and neither breaks anything."""
    (tmp_path / "leg.json").write_text(text, encoding="utf-8")
    found = read(tmp_path / "cfg.py", "leg.pt")
    assert found is not None and found.manifest is None
    if problem is not None:
        assert found.problem == problem


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes here")
def test_pipes_are_not_opened(tmp_path: Path) -> None:
    """A pipe in the place of network and manifest is not waited on."""
    os.mkfifo(tmp_path / "leg.json")
    os.mkfifo(tmp_path / "leg.pt")
    found = read(tmp_path / "cfg.py", "leg.pt")
    assert found is not None and (found.path, found.manifest) == (None, None)
