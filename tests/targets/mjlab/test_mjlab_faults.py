"""What the mjlab target refuses, and how it says so."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any

import pytest

from actspec.diagnostics import EmitError
from tests.network_files import torchscript
from tests.targets.leg import LEG, group
from tests.targets.mjlab.emitting import refused, written

LIMIT = {"effort_limit": "24 N*m"}

MANIFEST: dict[str, Any] = {
    "format": "actspec-network/1",
    "kind": "mlp",
    "inputs": "velocity_position",
    "taps": [0, 1, 2],
    "tap_period": "5 ms",
    "position_scale": -1.0,
    "velocity_scale": 0.5,
    "torque_scale": 2.0,
    "initial_history": "first_sample",
}


def network(folder: Path, *, file: bool = True, **changed: Any) -> str:
    """A group with a network whose manifest differs so, its files in the folder."""
    (folder / "net.json").write_text(json.dumps({**MANIFEST, **changed}), encoding="utf-8")
    if file:
        (folder / "net.pt").write_bytes(torchscript())
    return group(level="actuator_net", kp="", kd="", **LIMIT, network="{file: net.pt, manifest: net.json}")


def test_network(tmp_path: Path) -> None:
    """Order, scales and taps come from the manifest, the file stands beside the module, and no line is made up."""
    found = written(network(tmp_path), path=str(tmp_path / "spec.yaml"))
    kind, fields = found.cfg
    assert kind == "LearnedMlpActuatorCfg"
    expected = {
        "network_file": "str(FOLDER / 'net.pt')",
        "input_order": "vel_pos",
        "pos_scale": -1.0,
        "vel_scale": 0.5,
        "torque_scale": 2.0,
        "history_length": 3,
        "effort_limit": 24.0,
        # Far above any joint's: what is left is effort_limit.
        "saturation_effort": 1e9,
        "velocity_limit": 1e9,
    }
    assert fields | expected == fields
    assert "stiffness" not in fields
    assert {file.path: file.data for file in found.emission.files[1:]} == {"net.pt": torchscript()}
    assert found.emission.approximations == ()


def test_network_that_starts_at_zero(tmp_path: Path) -> None:
    """mjlab fills the history with the first sample; a network that was trained otherwise is an approximation."""
    found = written(network(tmp_path, initial_history="zero"), path=str(tmp_path / "spec.yaml"))
    # From -24 to 24 at most.
    assert found.lost("network.initial_history").max_torque_error == 48.0


def test_step_into_a_network_is_sized_by_its_limit(tmp_path: Path) -> None:
    """What a network answers to a late or unfiltered step is not known: at most 24 to -24, not a drive's 12."""
    text = network(tmp_path).replace("network:", "delay: 7 ms, command_filter: {cutoff: 9 Hz}, network:")
    found = written(text, path=str(tmp_path / "spec.yaml"))
    sizes = {loss.field: loss.max_torque_error for loss in found.emission.approximations}
    assert sizes == {"delay": 48.0, "command_filter": 48.0}


@pytest.mark.parametrize(
    "changed, expected",
    [
        (
            {"kind": "lstm"},
            "MJL004 actuators.leg.network: mjlab has no actuator class for a network of kind lstm",
        ),
        (
            {"taps": [2, 1, 0]},
            "MJL005 actuators.leg.network: mjlab gives a network the samples 0 to n - 1 in this order, "
            "got taps [2, 1, 0]",
        ),
        (
            {"taps": [0, 2]},
            "MJL005 actuators.leg.network: mjlab gives a network the samples 0 to n - 1 in this order, "
            "got taps [0, 2]",
        ),
        (
            {"tap_period": "20 ms"},
            "MJL006 actuators.leg.network: mjlab samples a network's history at every physics step, 5 ms, "
            "and its taps are 20 ms apart",
        ),
        (
            {"tap_period": "8 ms"},
            "NET007 actuators.leg.network: tap_period 8 ms is not a whole number of physics steps of 5 ms",
        ),
        (
            {"sha256": hashlib.sha256(b"others").hexdigest()},
            "NET005 actuators.leg.network: the network is not the one that its manifest describes: "
            f"sha256 {hashlib.sha256(torchscript()).hexdigest()[:12]}..., the manifest has "
            f"{hashlib.sha256(b'others').hexdigest()[:12]}...",
        ),
        ({"file": False}, "NET003 actuators.leg.network: there is no file 'net.pt'"),
    ],
    ids=["lstm", "reversed", "gap", "period", "no-multiple", "other-file", "no-file"],
)
def test_network_refused(changed: dict[str, Any], expected: str, tmp_path: Path) -> None:
    """A network that mjlab would run with other inputs than it was trained on is refused."""
    assert refused(network(tmp_path, **changed), path=str(tmp_path / "spec.yaml")) == [expected]


def test_network_without_manifest(tmp_path: Path) -> None:
    """A network file alone is refused."""
    (tmp_path / "net.pt").write_bytes(torchscript())
    spec = group(level="actuator_net", kp="", kd="", **LIMIT, network="{file: net.pt}")
    assert refused(spec, path=str(tmp_path / "spec.yaml")) == [
        "NET002 actuators.leg.network: the network has no manifest, and its file alone does not state order, "
        "scales and period of its inputs"
    ]


def test_one_tap_needs_no_period(tmp_path: Path) -> None:
    """Without a second tap it does not matter how far it would be, as long as it is on the step's grid."""
    spec = network(tmp_path, taps=[0], tap_period="20 ms")
    assert written(spec, path=str(tmp_path / "spec.yaml")).cfg[1]["history_length"] == 1


@pytest.mark.parametrize(
    "fields, expected",
    [
        (
            {"kp": "unknown", **LIMIT},
            "MJL001 actuators.leg.kp: hip: kp is unknown, level ideal_pd with command position needs it",
        ),
        (
            {"level": "dc_motor", "motor": "line", "effort_limit": "unknown"},
            "MJL002 actuators.leg.effort_limit: hip: effort_limit is unknown, and the class that mjlab has for it "
            "needs a number",
        ),
        (
            {"command": "effort", "kp": "", "kd": "", "effort_limit": "unknown"},
            "MJL002 actuators.leg.effort_limit: hip: effort_limit is unknown, and the class that mjlab has for it "
            "needs a number",
        ),
    ],
    ids=["kp", "dc", "motor"],
)
def test_unknown_numbers(fields: dict[str, str], expected: str) -> None:
    """Where mjlab must have a number, an unknown one is an error."""
    assert refused(group(**fields)) == [expected]


@pytest.mark.parametrize(
    "fields, expected",
    [
        (
            {"kp": "unknown", **LIMIT},
            "MJL001 actuators.leg.kp: hip, calf: kp is unknown, level ideal_pd with command position needs it",
        ),
        (
            {"command": "effort", "kp": "", "kd": "", "effort_limit": "unknown"},
            "MJL002 actuators.leg.effort_limit: hip, calf: effort_limit is unknown, and the class that mjlab has "
            "for it needs a number",
        ),
    ],
    ids=["kp", "limit"],
)
def test_a_groups_error_is_told_once(fields: dict[str, str], expected: str) -> None:
    """One joint's error does not hide another's, and the same one names both."""
    assert refused(group(joints="[hip, calf]", **fields), robot='unmanaged: ["rod"]') == [expected]


def test_a_networks_command_is_told_once(tmp_path: Path) -> None:
    """A group's network with another command than position is one error, with the joints and a way out."""
    spec = network(tmp_path).replace("[hip]", "[hip, calf]").replace("level:", "command: effort, level:")
    with pytest.raises(EmitError) as caught:
        written(spec, path=str(tmp_path / "spec.yaml"), robot='unmanaged: ["rod"]')
    (fault,) = caught.value.diagnostics
    assert fault.message == "hip, calf: mjlab's network takes position errors, got command effort"
    assert fault.help == "write command: position, or leave this target out"


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("stall_torque: 45 N*m, no_load_speed: 30 rad/s", (45.0, 30.0)),
        ("stall_torque: unknown, no_load_speed: 30 rad/s", (1e9, 1e9)),
        ("stall_torque: 45 N*m, no_load_speed: unknown", (1e9, 1e9)),
    ],
    ids=["line", "no-stall", "no-speed"],
)
def test_network_of_a_motor_without_a_line(line: str, expected: tuple[float, float], tmp_path: Path) -> None:
    """A network's torque is cut at the line where there is one; an unknown part of it leaves the limit alone."""
    spec = network(tmp_path).replace("level:", "motor: m, level:")
    motors = f"\n  m: {{side: joint, {line}}}"
    fields = written(spec, path=str(tmp_path / "spec.yaml"), motors=motors).cfg[1]
    assert (fields["saturation_effort"], fields["velocity_limit"]) == expected


def test_network_files_that_are_not_there(tmp_path: Path) -> None:
    """The helps speak of the network and of its manifest, not of a spec."""
    spec = network(tmp_path, file=False)
    (tmp_path / "net.json").unlink()
    with pytest.raises(EmitError) as caught:
        written(spec, path=str(tmp_path / "spec.yaml"))
    assert [(fault.code, fault.help) for fault in caught.value.diagnostics] == [
        ("NET003", "a network is a file beside its manifest, or network.file relative to the spec's folder"),
        ("NET004", "a manifest is the JSON beside a network; `actspec schema network` has its keys"),
    ]


@pytest.mark.parametrize("version", ["1.7", "2.0", "1", "1.6.0.1", "one.six", "1.٦", "0.9", ""])
def test_unknown_version(version: str) -> None:
    """A version that does not exist is named with the range of those that do."""
    with pytest.raises(EmitError) as caught:
        written(group(**LIMIT), version=version)
    (item,) = caught.value.diagnostics
    assert (item.code, item.where) == ("MJL007", "targets.mjlab.version")
    assert item.message == f"actspec does not know mjlab {version!r}"
    assert item.help is not None and item.help.startswith("known: 1.0 to 1.6")


def test_joints_that_mjlab_cannot_tell_apart() -> None:
    """mjlab matches what stands behind the last `/`."""
    model = LEG.replace('name="hip"', 'name="l/hip"').replace('name="calf"', 'name="r/hip"')
    assert refused(group(**LIMIT, joints="['l/hip']"), model, robot='unmanaged: ["r/hip", "rod"]') == [
        "MJL008 l/hip: mjlab identifies a joint by what is behind the last '/', which is the same for l/hip, r/hip"
    ]


def test_springdamper() -> None:
    """A springdamper in force would overwrite the friction that is written."""
    model = LEG.replace('<joint name="hip"', '<joint name="hip" springdamper="0.1 1"')
    assert refused(group(**LIMIT, friction="{viscous: 0.3 N*m*s/rad}"), model) == [
        "MJL009 hip: the joint has a springdamper in force, which overwrites viscous_damping and follows the "
        "armature"
    ]
    assert written(group(**LIMIT), model).cfg[0] == "BuiltinPositionActuatorCfg"


def test_robot_without_a_model() -> None:
    """A spec that lists its joints is enough: patterns match among those."""
    fields = group(**LIMIT, joints="['h.*']")
    found = written(fields, None, robot="model: none, joints: [hip, calf], unmanaged: [calf]")
    ((_, cfg),) = found.cfgs.values()
    assert cfg == {"target_names_expr": ("h.*",), "stiffness": 25.0, "damping": 0.5, "effort_limit": 24.0}
    assert "# model" not in found.text
