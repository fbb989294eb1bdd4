"""What a run has read it never replaces, `--force` or not: the files named, and what those name."""

from __future__ import annotations

import os
import shutil
import struct
from pathlib import Path

import pytest

from actspec import files
from actspec.cli.main import main
from actspec.files import note, noting, read_regular, was_read
from actspec.processes import IsolatedCall

EXAMPLE = Path(__file__).resolve().parents[2] / "docs" / "example"
SPEC = """actspec: 1
robot: {name: biped, model: out/mujoco/biped.xml}
actuators:
  legs: {joints: [".*"], level: ideal_pd, kp: 40 N*m/rad, kd: 1 N*m*s/rad, effort_limit: 20 N*m}
targets: {mujoco: {}}
"""
PART = '<mujoco model="both"><include file="out/mujoco/biped.xml"/></mujoco>\n'
MESHED = """<mujoco model="box">
  <asset><mesh name="m" file="m.stl"/></asset>
  <worldbody><body><joint name="j"/><geom type="mesh" mesh="m"/></body></worldbody>
</mujoco>
"""
SETTINGS = '[audit]\nmin-confidence = "low"\n'
TETRAHEDRON = ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1))


def stl() -> bytes:
    """A tetrahedron."""
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    data = b"\0" * 80 + struct.pack("<I", len(faces))
    for face in faces:
        corners = [x for corner in face for x in TETRAHEDRON[corner]]
        data += struct.pack("<12fH", 0, 0, 0, *corners, 0)
    return data


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder: a spec, its model where a compile would write it, and what else commands read."""
    monkeypatch.chdir(tmp_path)
    os.makedirs("out/mujoco")
    shutil.copy(EXAMPLE / "biped.xml", "out/mujoco/biped.xml")
    shutil.copy(EXAMPLE / "biped_cfg.py", "biped_cfg.py")
    for link in ("link.xml", "model.svg", "model.csv"):
        os.symlink("out/mujoco/biped.xml", link)
    os.link("out/mujoco/biped.xml", "hard.xml")
    Path("spec.yaml").write_text(SPEC)
    Path("scene.xml").write_text(PART)
    Path("meshed.xml").write_text(MESHED)
    Path("m.stl").write_bytes(stl())
    Path("s.toml").write_text(SETTINGS)
    Path("r.yaml").write_text("format: actspec-results/1\n")
    Path("c.csv").write_text("time [s],left_hip.command [rad]\n0,0\n0.01,0.1\n")
    Path("net.json").write_text('{"format": "actspec-network/1"}')
    return tmp_path


def contents() -> dict[str, bytes]:
    """Path to bytes of all files."""
    return {str(path): path.read_bytes() for path in sorted(Path(".").rglob("*")) if path.is_file()}


MODEL = "out/mujoco/biped.xml"


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        f"lock {MODEL} -o {MODEL}",
        f"lock {MODEL} -o link.xml",
        f"lock {MODEL} -o hard.xml",
        f"lock scene.xml -o {MODEL}",
        f"lock {MODEL} biped_cfg.py -o biped_cfg.py",
        "lock meshed.xml -o m.stl",
        f"audit {MODEL} -o {MODEL}",
        f"audit scene.xml -o {MODEL}",
        f"audit {MODEL} --write-baseline {MODEL}",
        f"audit {MODEL} --config s.toml -o s.toml",
        f"audit {MODEL} --config s.toml --write-baseline s.toml",
        f"audit {MODEL} --spec spec.yaml -o spec.yaml",
        f"audit biped_cfg.py --spec spec.yaml -o {MODEL}",
        f"report spec.yaml -o {MODEL}",
        "compile spec.yaml -o out",
        "compare spec.yaml --plot model.svg",
        f"import {MODEL} -o {MODEL}",
        "sysid design spec.yaml --experiment chirp --duration 2s -o model.csv",
        "sysid simulate spec.yaml --command c.csv --seed 1 -o c.csv",
        "sysid fit spec.yaml c.csv -o c.csv",
        "sysid report r.yaml -o r.yaml",
        "net convert net.onnx --manifest net.json -o net",
    ],
)
def test_what_is_read_stays(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Every command that writes refuses, and leaves all files as they were."""
    if command.startswith("compare"):
        pytest.importorskip("scipy")
    if command.startswith("net"):
        pytest.importorskip("torch")
        pytest.importorskip("onnx")
    before = contents()
    assert main([*command.split(), "--force"]) == 2
    said = capsys.readouterr().err
    assert "OUT003" in said and "is read by this command" in said
    assert "--force" not in said
    assert contents() == before


def test_compile_does_not_recommend_force(capsys: pytest.CaptureFixture[str]) -> None:
    """Where the model lies in the target's folder, `--force` is no way out."""
    assert main(["compile", "spec.yaml", "-o", "out"]) == 2
    said = capsys.readouterr().err
    assert "is read by this command" in said and "--force" not in said


@pytest.mark.slow
def test_what_actspec_wrote_is_written_again(capsys: pytest.CaptureFixture[str]) -> None:
    """A lock, a baseline, a report in an audited folder and what lies in no run's way: all are replaced."""
    for _ in range(2):
        assert main(["lock", MODEL]) == 0
        assert main(["audit", ".", "--write-baseline", "b.json"]) == 0
        main(["audit", ".", "--output-format", "junit", "-o", "report.xml"])
        main(["audit", ".", "--output-format", "full", "-o", "found.yaml"])
        assert main(["compile", "spec.yaml", "-o", "build"]) == 0
        Path("build/mujoco/biped.xml").write_text("mine")
        assert main(["compile", "spec.yaml", "-o", "build", "--force"]) == 0
        text = Path(MODEL).read_text().replace('damping="', 'damping="1')
        os.unlink("hard.xml")
        os.link(MODEL, "hard.xml")
        Path(MODEL).write_text(text)
    Path("b.json").write_text("no baseline")
    assert main(["audit", MODEL, "--write-baseline", "b.json", "--force"]) == 0
    assert "OUT003" not in capsys.readouterr().err


def _read(path: str) -> int:
    return len(read_regular(path, 10**6))


def test_noting(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reads of other processes count, those within another noting do not, and without one there are none."""
    read_regular("spec.yaml", 10**6)
    assert not was_read("spec.yaml")
    with noting() as read:
        with noting():
            read_regular("spec.yaml", 10**6)
        assert not was_read("spec.yaml")
        with IsolatedCall(_read) as call:
            assert call("spec.yaml") == len(SPEC)
        note(["gone.xml"])
        assert was_read("spec.yaml") and not was_read("gone.xml") and not was_read("scene.xml")
        assert read == {os.path.abspath("spec.yaml"), os.path.abspath("gone.xml")}
    assert files._READ == []
