"""Files of strangers at every door to a network: refused with a reason, nothing written, nothing run."""

from __future__ import annotations

import hashlib
import io
import json
import pickle
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from actspec.cli.main import main
from actspec.learn.files import write_network
from actspec.runtime import RuntimeFault, networks
from tests.learn import netted, pendulums
from tests.learn.test_files import MANIFEST, perceptron

pytest.importorskip("torch")

SPEC = pendulums.SPEC.replace(
    "level: ideal_pd, kp: 20 N*m/rad, kd: 0.5 N*m*s/rad", "level: actuator_net, network: {manifest: net.json}"
)
TARGETS = 'targets: {mujoco: {version: "3.11"}, isaaclab: {version: "2.3"}}\n'


class Trap:
    """Leaves a mark where it is unpickled."""

    def __reduce__(self) -> tuple[object, tuple[str, str]]:
        return open, ("marked", "w")


def archive(**parts: bytes) -> bytes:
    """A zip with these files in a folder."""
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as made:
        for name, data in parts.items():
            made.writestr("net/" + name.replace("_", "."), data)
    return out.getvalue()


FILES = {
    "pickle": pickle.dumps(Trap()),
    "npz": archive(w_npy=pickle.dumps(Trap())),
    "checkpoint": archive(data_pkl=pickle.dumps(Trap()), version=b"3"),
    "empty": b"",
    "text": b"weights\n",
}


@pytest.fixture(scope="module")
def good(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with specs, a log and a network that all commands take."""
    folder = tmp_path_factory.mktemp("good")
    write_network(str(folder / "net"), perceptron(), MANIFEST)
    (folder / "robot.xml").write_text(pendulums.MODEL)
    (folder / "spec.yaml").write_text(SPEC + TARGETS)
    (folder / "log_spec.yaml").write_text(pendulums.SPEC)
    pendulums.log(folder / "log.npz", 1, 300)
    return folder


def refused(folder: Path, capsys: pytest.CaptureFixture[str], *argv: str) -> str:
    """What a command says that must end with 2, write nothing and run nothing."""
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    assert main(list(argv)) == 2
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before
    shown = capsys.readouterr()
    assert "Traceback" not in shown.err + shown.out
    return shown.err + shown.out


COMMANDS = {
    "compile": ["compile", "spec.yaml", "-o", "out"],
    "evaluate": ["net", "evaluate", "log_spec.yaml", "log.npz", "--network", "net.json"],
    "inspect": ["net", "inspect", "net.onnx", "--trust"],
    "convert": ["net", "convert", "net.onnx", "--trust", "--manifest", "net.json", "-o", "out/net"],
}


@pytest.mark.slow
@pytest.mark.parametrize("file", FILES)
@pytest.mark.parametrize("form", ["onnx", "torchscript"])
def test_what_is_no_network(
    file: str,
    form: str,
    good: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """With its own sha256 in the manifest, so that only its kind speaks against it."""
    folder = Path(shutil.copytree(good, tmp_path / "case"))
    monkeypatch.chdir(folder)
    manifest = json.loads(Path("net.json").read_text())
    entry = manifest["files"][form]
    Path(entry["path"]).write_bytes(FILES[file])
    entry["sha256"] = hashlib.sha256(FILES[file]).hexdigest()
    Path("net.json").write_text(json.dumps(manifest))
    assert "net." in refused(folder, capsys, *COMMANDS["compile"])
    for name in ("evaluate", "inspect", "convert") if form == "onnx" else ():
        assert "net.onnx" in refused(folder, capsys, *COMMANDS[name])
    if form == "torchscript":
        assert "net.pt" in refused(folder, capsys, "net", "inspect", "net.pt", "--trust")


@pytest.mark.parametrize(
    "change, message",
    [
        ({"tap_period": "unknown"}, "tap_period"),
        ({"tap_period": "1e300 s"}, "tap_period"),
        ({"taps": [0, 10**9]}, "taps"),
        ({"files": {"onnx": {"path": "../net.onnx", "sha256": "0" * 64}}}, "path"),
        ({"files": {"onnx": {"path": "net.onnx", "sha256": "0" * 64}}}, "sha256"),
        ({"model": "0" * 64, "dynamics": {"mass": 1e400, "gravity": 9.81, "joints": {}}}, "mass"),
    ],
    ids=["unknown period", "years", "history", "path", "sha256", "infinity"],
)
@pytest.mark.parametrize("name", ["compile", "convert"])
def test_manifest_that_cannot_be(
    change: dict[str, Any],
    message: str,
    name: str,
    good: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The key is named; a network is not converted by another one's manifest."""
    folder = Path(shutil.copytree(good, tmp_path / "case"))
    monkeypatch.chdir(folder)
    Path("net.json").write_text(json.dumps({**json.loads(Path("net.json").read_text()), **change}))
    assert message in refused(folder, capsys, *COMMANDS[name])


Change = Callable[[dict[str, Any]], object]


@pytest.mark.parametrize(
    "change, message",
    [
        (lambda found: found.update(physics_dt=0), "physics step"),
        (lambda found: found.update(physics_dt=0.0031), "do not fall on steps"),
        (lambda found: found.update(networks=[]), "no network"),
        (lambda found: found.update(networks=3), "not what compile wrote"),
        (lambda found: found["networks"][0]["manifest"].update(taps=[0, 10**9]), "taps"),
        (lambda found: found["networks"][0]["manifest"].update(position_scale=float("nan")), "not finite"),
        (lambda found: found["networks"][0]["manifest"]["files"]["onnx"].update(path="../net.onnx"), "path"),
        (
            lambda found: found["networks"][0]["manifest"]["files"]["onnx"].update(sha256="0" * 64),
            "another file",
        ),
        (lambda found: found["networks"][0]["joints"][0].update(no_load_speed=0), "torque-speed line"),
        (lambda found: found["networks"][0]["joints"][0].update(effort_limit=float("inf")), "effort_limit"),
        (lambda found: found["networks"][0]["joints"][0].update(curve=[1]), "not what compile wrote"),
        (lambda found: found["networks"][0]["joints"][0].update(joint=3), "no name"),
    ],
)
def test_folder_of_the_runtime(change: Change, message: str, compiled: Path, tmp_path: Path) -> None:
    """Whatever networks.json says, the runtime has an answer in one line."""
    folder = Path(shutil.copytree(compiled, tmp_path / "mujoco"))
    found = json.loads((folder / "networks.json").read_text())
    change(found)
    (folder / "networks.json").write_text(json.dumps(found))
    with pytest.raises(RuntimeFault, match="LRN040") as caught:
        networks(folder)
    assert message in str(caught.value) and len(caught.value.diagnostics) == 1
    assert "\n" not in caught.value.diagnostics[0].message


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What `compile` writes for MuJoCo."""
    return netted.build(tmp_path_factory.mktemp("compiled"))
