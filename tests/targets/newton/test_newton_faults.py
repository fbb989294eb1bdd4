"""What the Newton target refuses, and what it makes of a network's file."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from actspec.api import load
from actspec.diagnostics import Collector, EmitError, SpecError
from actspec.readings.onnx_file import NotOnnx, read_metadata, with_metadata
from actspec.spec.models import NewtonTarget
from actspec.targets.choose import choose_targets
from tests.network_files import onnx_mlp, onnx_operation, torchscript
from tests.targets.leg import group
from tests.targets.newton.emitting import refused, written

LIMIT = {"effort_limit": "24 N*m"}

GRAPH = bytes([7 << 3 | 2, 3]) + b"abc"
"""A model whose graph is three bytes."""
ONNX = bytes([1 << 3, 8]) + GRAPH
"""With its version."""
NET = onnx_mlp([(np.ones((1, 6)), [0.0], "")])
"""A network of three taps."""

MANIFEST: dict[str, Any] = {
    "format": "actspec-network/1",
    "kind": "mlp",
    "inputs": "velocity_position",
    "taps": [0, 1, 2],
    "tap_period": "10 ms",
    "position_scale": -1.0,
    "velocity_scale": 0.5,
    "torque_scale": 2.0,
    "initial_history": "zero",
}


def network(folder: Path, data: bytes = NET, *, name: str = "net.onnx", **changed: Any) -> str:
    """A group with a network whose manifest differs so, its files in the folder."""
    (folder / "net.json").write_text(json.dumps({**MANIFEST, **changed}), encoding="utf-8")
    (folder / name).write_bytes(data)
    return group(level="actuator_net", kp="", kd="", **LIMIT, network=f"{{file: {name}, manifest: net.json}}")


def prop(key: str, value: str) -> bytes:
    """A record of ModelProto's metadata_props."""
    parts = bytes([1 << 3 | 2, len(key)]) + key.encode() + bytes([2 << 3 | 2, len(value)]) + value.encode()
    return bytes([14 << 3 | 2, len(parts)]) + parts


def test_network(tmp_path: Path) -> None:
    """The file goes beside the overlay with the manifest's conventions in it, taps in physics steps of 5 ms."""
    found = written(network(tmp_path), path=str(tmp_path / "spec.yaml"))
    drive = "/leg/NewtonActuators/hip"
    assert found.prims[drive]["apis"] == ["NewtonNeuralControlAPI", "NewtonMaxEffortClampingAPI"]
    assert found.attributes(drive)["newton:modelPath"] == "@./net.onnx@"
    assert "newton:kp" not in found.attributes(drive)
    assert found.emission.approximations == ()
    (file,) = found.emission.files[1:]
    assert file.path == "net.onnx"
    assert file.data.startswith(NET)
    assert read_metadata(file.data) == {
        "model_type": "mlp",
        "input_order": "vel_pos",
        "input_idx": [0, 2, 4],
        "pos_scale": -1.0,
        "vel_scale": 0.5,
        "effort_scale": 2.0,
    }


def test_networks_name(tmp_path: Path) -> None:
    """Newton takes a file for torch's by its name: an ONNX file gets its own; an @ in it ends no path."""
    found = written(network(tmp_path, name="a@b.pt"), path=str(tmp_path / "spec.yaml"))
    assert found.emission.files[1].path == "a@b.onnx"
    assert found.attributes("/leg/NewtonActuators/hip")["newton:modelPath"] == "@@@./a@b.onnx@@@"


def test_network_losses(tmp_path: Path) -> None:
    """What a network answers to another history, a late command or a bias is not known: from -24 to 24 N*m."""
    text = network(tmp_path, initial_history="first_sample", tap_period="5 ms")
    more = "delay: 7 ms, command_filter: {cutoff: 9 Hz}, encoder_bias: 0.1 rad, network:"
    found = written(text.replace("network:", more), path=str(tmp_path / "spec.yaml"))
    sizes = {loss.field: loss.max_torque_error for loss in found.emission.approximations}
    assert sizes == {
        "network.initial_history": 48.0, "delay": 48.0, "command_filter": 48.0, "encoder_bias": 48.0,
    }  # fmt: skip


def test_old_metadata_give_way() -> None:
    """A property `metadata` is replaced, others and the network stay byte for byte."""
    data = with_metadata(ONNX + prop("metadata", '{"a": 1}') + prop("author", "me"), {"b": 2})
    assert data == ONNX + prop("author", "me") + prop("metadata", '{"b": 2}')
    assert read_metadata(data) == {"b": 2}
    assert read_metadata(ONNX + prop("pos_scale", "2.5") + prop("author", "me")) == {
        "pos_scale": 2.5,
        "author": "me",
    }


def test_long_metadata() -> None:
    """Lengths of more than seven bits are written as protobuf has them."""
    value = {"names": ["x" * 100] * 200}
    assert read_metadata(with_metadata(ONNX, value)) == value


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"PK\x03\x04torch",
        b"\x80\x02}q",
        ONNX[:-1],
        bytes([1 << 3, 8]),
        bytes([7 << 3 | 2]) + b"\xff" * 12,
        bytes([7 << 3 | 2, 0xFF, 0xFF, 0xFF, 0xFF, 0x0F]),
        b"\x00" * 8,
        GRAPH + prop("metadata", "[1]"),
        GRAPH + prop("metadata", "{"),
        GRAPH + bytes([14 << 3 | 2, 2, 0xFF, 0xFF]),
    ],
)
def test_not_onnx(data: bytes) -> None:
    """Bytes of another kind, cut off, or whose metadata are no JSON object."""
    with pytest.raises(NotOnnx):
        read_metadata(data)


@given(st.binary(max_size=40) | st.binary(max_size=30).map(lambda tail: ONNX + bytes([14 << 3 | 2]) + tail))
def test_any_bytes(data: bytes) -> None:
    """Whatever a stranger's file holds, it is read, or refused as no ONNX."""
    try:
        found = read_metadata(data)
    except NotOnnx:
        return
    assert read_metadata(with_metadata(data, {"a": found})) == {"a": found}


def test_file_of_empty_records() -> None:
    """A file that is all records is given up early."""
    with pytest.raises(NotOnnx, match="more than 10000 records"):
        read_metadata(bytes([1 << 3, 0]) * 1_000_000)


def test_network_with_a_motor(tmp_path: Path) -> None:
    """A network's torque is clipped by the motor's line where one is known."""
    text = network(tmp_path).replace("network:", "motor: line, network:")
    found = written(text, path=str(tmp_path / "spec.yaml"))
    drive = "/leg/NewtonActuators/hip"
    assert found.prims[drive]["apis"] == ["NewtonNeuralControlAPI", "NewtonDCMotorClampingAPI"]
    numbers = {
        name: found.attributes(drive)[f"newton:{name}"] for name in ("saturationEffort", "velocityLimit")
    }
    assert numbers == {"saturationEffort": 45.0, "velocityLimit": 30.0}


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        (
            {"data": torchscript()},
            "NET009 actuators.leg.network: 'net.onnx' is no ONNX file, and this target runs no other",
        ),
        (
            {"data": b"weights"},
            "NET011 actuators.leg.network: 'net.onnx' cannot be read: it is no ONNX file, or it is cut off",
        ),
        (
            {"kind": "gru", "data": onnx_operation("GRU")},
            "NWT003 actuators.leg.network: actspec does not write a gru for Newton, which names its inputs in "
            "another way",
        ),
        (
            {"position_scale": 0.0},
            "NWT006 actuators.leg.network: Newton does not accept a pos_scale of 0",
        ),
        (
            {"data": NET + prop("metadata", '{"pos_scale": 1.0}')},
            "NWT006 actuators.leg.network: the network's own metadata have pos_scale 1.0, its manifest has -1.0",
        ),
        (
            {"data": NET + prop("torque_scale", "3")},
            "NWT006 actuators.leg.network: the network's own metadata have effort_scale 3, its manifest has 2.0",
        ),
        (
            {"tap_period": "8 ms"},
            "NET007 actuators.leg.network: tap_period 8 ms is not a whole number of physics steps of 5 ms",
        ),
    ],
    ids=["torch", "other", "gru", "scale", "metadata", "torque-scale", "period"],
)
def test_network_refused(changed: dict[str, Any], expected: str, tmp_path: Path) -> None:
    """A network that Newton would not run, or would run with other inputs than it was trained on."""
    data = changed.pop("data", NET)
    found = refused(network(tmp_path, data, **changed), path=str(tmp_path / "spec.yaml"))
    # The shape of a gru is not read, which is reported too.
    assert [text for text in found if not text.startswith("NET012")] == [expected]


@pytest.mark.parametrize("data", [b"weights", b"import os\n", NET[:-1], NET + b"#", bytes([8, 1])])
def test_bytes_that_are_no_network(data: bytes, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing else is copied under a network's name, also where onnx is not there to read it."""
    monkeypatch.setitem(sys.modules, "onnx", None)
    (found,) = refused(network(tmp_path, data), path=str(tmp_path / "spec.yaml"))
    assert "NET011 actuators.leg.network: 'net.onnx' cannot be read: it is no ONNX file" in found


def test_a_network_is_no_module(tmp_path: Path) -> None:
    """A network whose name Python would import is not copied, whatever is in it."""
    text = network(tmp_path).replace("net.onnx", "Torch.PY")
    (tmp_path / "net.onnx").rename(tmp_path / "Torch.PY")
    expected = ["NET011 actuators.leg.network: 'Torch.PY' has a name that Python imports"]
    assert refused(text, path=str(tmp_path / "spec.yaml")) == expected


def test_lstm_refused(tmp_path: Path) -> None:
    """Newton feeds an lstm each step in its own order, and finds its tensors by names that only the file knows."""
    text = network(tmp_path, onnx_operation("LSTM"), kind="lstm", taps=[0], tap_period="5 ms", hidden_size=8)
    first, *others = refused(text, path=str(tmp_path / "spec.yaml"))
    assert first.startswith("NET012")
    assert others == [
        "NWT003 actuators.leg.network: Newton gives an lstm position error and velocity of each physics step, in this "
        "order, got velocity_position, taps [0] every 5 ms",
        "NWT006 actuators.leg.network: neither the lstm's own metadata nor its manifest have input_name, "
        "hidden_in_name, cell_in_name, output_name, hidden_out_name, cell_out_name, num_layers",
    ]


def test_lstm_of_two_layers(tmp_path: Path) -> None:
    """Newton keeps the states of all layers in one array, which its ONNX runtime cannot part."""
    text = network(
        tmp_path,
        onnx_operation("LSTM"),
        kind="lstm",
        taps=[0],
        tap_period="5 ms",
        hidden_size=8,
        num_layers=2,
    )
    assert refused(text, path=str(tmp_path / "spec.yaml"))[1:] == [
        "NWT003 actuators.leg.network: Newton runs an lstm of one layer, got 2: its ONNX runtime cannot take a layer's "
        "state from one array of all"
    ]


def test_network_of_another_command(tmp_path: Path) -> None:
    """A network takes position errors."""
    text = network(tmp_path).replace("level:", "command: velocity, level:")
    assert refused(text, path=str(tmp_path / "spec.yaml")) == [
        "NWT002 actuators.leg.command: Newton's network takes position errors, got command velocity"
    ]


def test_network_of_an_old_version(tmp_path: Path) -> None:
    """Before 1.4 there is no ONNX, and the velocity's sign is another."""
    assert refused(network(tmp_path), version="1.3", path=str(tmp_path / "spec.yaml")) == [
        "NWT003 actuators.leg.network: Newton 1.3 reads no ONNX, and gives a network the velocity's error for the "
        "velocity"
    ]


def test_two_networks_of_one_name(tmp_path: Path) -> None:
    """Two groups with one file name and other conventions cannot lie in one folder."""
    one = network(tmp_path)
    (tmp_path / "b.json").write_text(json.dumps({**MANIFEST, "torque_scale": 3.0}), encoding="utf-8")
    two = one.replace("  leg:", "  calf:").replace("[hip]", "[calf]").replace("net.json", "b.json")
    found = refused(f"{one}\n{two}", robot='unmanaged: ["rod"]', path=str(tmp_path / "spec.yaml"))
    assert found == [
        "NWT005 actuators.calf.network: two networks are called 'net.onnx' and differ, in themselves or in their "
        "manifests"
    ]


@pytest.mark.parametrize(
    ("version", "message", "help"),
    [
        ("1.1", "Newton 1.1 reads no actuators from USD", "known: 1.2 to 1.8"),
        ("0.2", "Newton 0.2 reads no actuators from USD", "known: 1.2 to 1.8"),
        ("1.9", "actspec does not know Newton '1.9'", "known: 1.2 to 1.8; did you mean '1.8'?"),
        ("x", "actspec does not know Newton 'x'", "known: 1.2 to 1.8"),
        ("1", "actspec does not know Newton '1'", "known: 1.2 to 1.8"),
    ],
)
def test_unknown_version(version: str, message: str, help: str) -> None:
    """Releases that read no actuators, and others, are refused with those that are known."""
    with pytest.raises(EmitError) as caught:
        written(group(**LIMIT), version=version)
    (said,) = caught.value.diagnostics
    assert (said.code, said.where, said.message) == ("NWT007", "targets.newton.version", message)
    assert said.help is not None and said.help.startswith(help)


def test_law_that_lacks_a_number() -> None:
    """Told once for the joints of a group."""
    spec = "  leg: {joints: [hip, calf], level: ideal_pd, kp: unknown, kd: 0.5 N*m*s/rad}"
    assert refused(spec, robot='unmanaged: ["rod"]') == [
        "NWT001 actuators.leg.kp: hip, calf: kp is unknown, level ideal_pd with command position needs it"
    ]


SPEC = """actspec: 1
robot: {name: leg, model: none, joints: [{name: hip}]}
actuators:
  leg: {joints: [hip], level: ideal_pd, kp: 25 N*m/rad, kd: 0.5 N*m*s/rad}
targets:
"""


def test_options_of_the_spec(tmp_path: Path) -> None:
    """`root` and `joint_paths` come with their places."""
    path = tmp_path / "spec.yaml"
    path.write_text(
        SPEC + '  newton:\n    root: /World/leg\n    joint_paths:\n      ".*": joints/{joint}\n',
        encoding="utf-8",
    )
    (options,) = choose_targets(load(path), (), "out", False, Collector())
    given = options.of(NewtonTarget)
    assert (given.root, given.joint_paths) == ("/World/leg", {".*": "joints/{joint}"})
    assert options.version == "1.8"
    span = options.span("joint_paths[.*]")
    assert span is not None and (span.line, span.column) == (9, 13)


def test_options_of_another_target(tmp_path: Path) -> None:
    """Another kind of target has no place for them."""
    path = tmp_path / "spec.yaml"
    path.write_text(SPEC + "  mjlab: {root: /World}\n", encoding="utf-8")
    with pytest.raises(SpecError, match="a target of kind mjlab has no option `root`"):
        load(path)
