"""`actspec compile` as a user meets it: files, exit codes, what it refuses to overwrite."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from actspec.cli.main import main

ROOT = Path(__file__).resolve().parents[2]
MODEL = """<mujoco model="arm">
  <!-- the author's comment -->
  <worldbody>
    <body><joint name="knee" range="-60 60"/><geom size=".1"/></body>
  </worldbody>
</mujoco>
"""
SPEC = """actspec: 1
robot: {name: arm, model: arm.xml}
actuators:
  legs:
    joints: [knee]
    level: ideal_pd
    kp: 20 N*m/rad
    kd: 1 N*m*s/rad
    effort_limit: 10 N*m
    armature: 0.01 kg*m^2
    delay: 5 ms
targets:
  mujoco: {version: "4.0"}
"""
OUT = Path("build/arm/mujoco/arm.xml")


@pytest.fixture
def spec(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A small robot with its spec in the working folder."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.xml").write_text(MODEL)
    path = tmp_path / "arm.yaml"
    path.write_text(SPEC)
    return path


def test_writes_below_build_and_nothing_else(spec: Path) -> None:
    """Files go to build/ROBOT/TARGET; the model and the spec stay as they are."""
    assert main(["compile", "arm.yaml"]) == 0
    assert sorted(p.as_posix() for p in Path(".").rglob("*") if p.is_file()) == [
        "arm.xml",
        "arm.yaml",
        "build/arm/mujoco/arm.xml",
        "build/arm/mujoco/manifest.json",
    ]
    assert Path("arm.xml").read_text() == MODEL
    assert "<!-- the author's comment -->" in OUT.read_text()


def test_output_folder_and_two_targets(spec: Path) -> None:
    """-o DIR puts one folder a target below DIR; two versions stand side by side."""
    text = SPEC.replace("targets:\n", "targets:\n  old: {target: mujoco, version: '3.3'}\n")
    spec.write_text(text)
    assert main(["compile", "arm.yaml", "-o", "out"]) == 0
    assert sorted(p.as_posix() for p in Path("out").rglob("*.xml")) == [
        "out/mujoco/arm.xml",
        "out/old/arm.xml",
    ]
    assert 'delay="0.006"' in Path("out/mujoco/arm.xml").read_text()  # 5 ms is 2.5 steps of 2 ms: 3 steps
    assert "delay=" not in Path("out/old/arm.xml").read_text()


def test_unchanged_files_are_not_touched(spec: Path, capsys: Any) -> None:
    """A second compile writes nothing: the modification times stay."""
    assert main(["compile", "arm.yaml"]) == 0
    os.utime(OUT, ns=(1, 1))
    assert main(["compile", "arm.yaml"]) == 0
    assert OUT.stat().st_mtime_ns == 1
    assert "build/arm/mujoco/arm.xml        unchanged" in capsys.readouterr().out


def test_check_and_diff_tell_stale_files(spec: Path, capsys: Any) -> None:
    """--check and --diff write nothing, exit 1 while something would change and 0 afterwards."""
    assert main(["compile", "arm.yaml", "--check"]) == 1
    assert "build/arm/mujoco/arm.xml: missing" in capsys.readouterr().out
    assert not Path("build").exists()
    assert main(["compile", "arm.yaml"]) == 0
    assert main(["compile", "arm.yaml", "--check"]) == 0
    spec.write_text(SPEC.replace("kp: 20", "kp: 21"))
    before = OUT.read_bytes()
    capsys.readouterr()
    assert main(["compile", "arm.yaml", "--diff"]) == 1
    out = capsys.readouterr().out
    assert [line for line in out.splitlines() if line.startswith("+ ") and 'kp="21"' in line]
    assert OUT.read_bytes() == before


def test_strict_refuses_and_accept_takes(spec: Path, capsys: Any) -> None:
    """--strict exits 1 on an approximation, writes nothing, and passes once the spec accepts it."""
    assert main(["compile", "arm.yaml", "--strict"]) == 1
    assert "mujoco.delay (1 joint)" in capsys.readouterr().err
    assert not Path("build").exists()
    spec.write_text(SPEC + 'accept: {mujoco.delay: "half a step is below our jitter"}\n')
    assert main(["compile", "arm.yaml", "--strict"]) == 0
    assert OUT.exists()


def test_strict_refuses_a_drive_without_limit(spec: Path, capsys: Any) -> None:
    """It is a warning; with --strict nothing is written until it is stated, or accepted."""
    text = SPEC.replace("effort_limit: 10 N*m", "effort_limit: unknown").replace("    delay: 5 ms\n", "")
    spec.write_text(text)
    assert main(["compile", "arm.yaml", "--strict"]) == 1
    err = capsys.readouterr().err
    assert "arm.yaml:9:19: SPEC166 [warning] actuators.legs.effort_limit: knee: " in err
    assert err.endswith("--strict: drives without an effort limit, which nobody states (SPEC166)\n")
    assert not Path("build").exists()
    spec.write_text(text + 'accept: {mujoco.effort_limit: "a bench without a motor"}\n')
    assert main(["compile", "arm.yaml", "--strict"]) == 0
    assert "SPEC" not in capsys.readouterr().err
    spec.write_text(text)
    assert main(["compile", "arm.yaml", "--force"]) == 0
    assert capsys.readouterr().out.endswith("no approximation; 1 warning\n")


def test_a_file_of_somebody_else_is_not_replaced(spec: Path, capsys: Any) -> None:
    """A file that actspec did not write stays as it is, exit code 2; --force replaces it."""
    OUT.parent.mkdir(parents=True)
    OUT.write_text("mine")
    assert main(["compile", "arm.yaml"]) == 2
    assert OUT.read_text() == "mine"
    assert "OUT003" in capsys.readouterr().err
    assert main(["compile", "arm.yaml", "--force"]) == 0
    assert OUT.read_text() != "mine"


def test_an_edited_output_is_not_replaced(spec: Path) -> None:
    """A generated file that a person changed since is theirs: it stays, exit code 2."""
    assert main(["compile", "arm.yaml"]) == 0
    OUT.write_text(OUT.read_text() + "<!-- tuned by hand -->\n")
    spec.write_text(SPEC.replace("kp: 20", "kp: 21"))
    assert main(["compile", "arm.yaml"]) == 2
    assert OUT.read_text().endswith("<!-- tuned by hand -->\n")


@pytest.fixture
def stiff(spec: Path) -> str:
    """A second spec of the same model with another kp, and a file of the first in the folder `out`."""
    Path("stiff.yaml").write_text(SPEC.replace("kp: 20", "kp: 40").replace("name: arm", "name: stiff"))
    assert main(["compile", "arm.yaml", "-o", "out"]) == 0
    return "out/mujoco/arm.xml"


def test_a_file_of_another_spec_is_not_replaced(stiff: str, capsys: Any) -> None:
    """Both specs are named, whichever comes second; with --force the file has changed hands, and the folder says so."""
    before = {path: path.read_bytes() for path in Path("out/mujoco").iterdir()}
    capsys.readouterr()
    said = "out/mujoco/arm.xml: OUT003: was written from {}, and this run writes {}\n"
    assert main(["compile", "stiff.yaml", "-o", "out"]) == 2
    err = capsys.readouterr().err
    assert said.format("arm.yaml", "stiff.yaml") in err and "another folder with -o" in err
    assert {path: path.read_bytes() for path in Path("out/mujoco").iterdir()} == before
    assert main(["compile", "stiff.yaml", "-o", "out", "--force"]) == 0
    assert main(["compile", "stiff.yaml", "-o", "out", "--check"]) == 0
    capsys.readouterr()
    assert main(["compile", "arm.yaml", "-o", "out"]) == 2
    assert said.format("stiff.yaml", "arm.yaml") in capsys.readouterr().err
    assert [record["spec"] for record in manifest()] == ["stiff.yaml"]


def test_several_files_of_another_spec_are_one_error(spec: Path, capsys: Any) -> None:
    """Each of two targets has one: both paths are named."""
    text = SPEC.replace("targets:", "targets:\n  old: {target: mujoco, version: '3.3'}")
    spec.write_text(text)
    Path("stiff.yaml").write_text(text.replace("kp: 20", "kp: 40").replace("name: arm", "name: stiff"))
    assert main(["compile", "arm.yaml", "-o", "out"]) == 0
    capsys.readouterr()
    assert main(["compile", "stiff.yaml", "-o", "out"]) == 2
    err = capsys.readouterr().err
    assert (
        "out/old/arm.xml: OUT003: was written from arm.yaml, and this run writes stiff.yaml; so was " in err
    )
    assert "; so was 1 more: out/mujoco/arm.xml\n" in err and err.count("OUT003") == 1


def test_check_and_diff_name_the_other_spec(stiff: str, capsys: Any) -> None:
    """What would be replaced is another spec's: said beside its name, where a diff has the time."""
    capsys.readouterr()
    assert main(["compile", "stiff.yaml", "-o", "out", "--check"]) == 1
    assert f"{stiff}: stale, written from arm.yaml\n" in capsys.readouterr().out
    assert main(["compile", "stiff.yaml", "-o", "out", "--diff"]) == 1
    assert f"--- {stiff}\twritten from arm.yaml\n+++ {stiff}\n" in capsys.readouterr().out


def test_specs_side_by_side(stiff: str) -> None:
    """Two specs whose files have other names share a folder: each stays fresh, and can be edited and compiled again."""
    Path("leg.xml").write_text(MODEL)
    Path("leg.yaml").write_text(SPEC.replace("arm.xml", "leg.xml").replace("name: arm", "name: leg"))
    alone = Path("out/mujoco/manifest.json").read_bytes()
    assert main(["compile", "leg.yaml", "-o", "out"]) == 0
    both = Path("out/mujoco/manifest.json").read_bytes()
    assert [(r["spec"], r["robot"], [f["path"] for f in r["files"]]) for r in manifest()] == [
        ("arm.yaml", "arm", ["arm.xml"]),
        ("leg.yaml", "leg", ["leg.xml"]),
    ]
    assert json.loads(alone).items() <= json.loads(both).items()
    assert main(["compile", "arm.yaml", "-o", "out", "--check"]) == 0
    assert main(["compile", "leg.yaml", "-o", "out", "--check"]) == 0
    for name in ("arm", "leg"):
        path = Path(f"{name}.yaml")
        path.write_text(path.read_text().replace("kp: 20", "kp: 21"))
        assert main(["compile", path.name, "-o", "out"]) == 0
        assert 'kp="21"' in Path(f"out/mujoco/{name}.xml").read_text()
    Path("out/mujoco/leg.xml").write_text("tuned by hand")
    Path("leg.yaml").write_text(SPEC.replace("arm.xml", "leg.xml").replace("name: arm", "name: leg"))
    assert main(["compile", "leg.yaml", "-o", "out"]) == 2


def test_a_variant_and_a_spec_of_one_name_are_others(stiff: str, capsys: Any) -> None:
    """A file that two variants write is refused by their names; specs of one file name are told apart by the robot."""
    variants = "variants:\n  soft: {}\n  hard: {actuators: {legs: {kp: 80 N*m/rad}}}\n"
    Path("arm.yaml").write_text(SPEC + variants)
    assert main(["compile", "arm.yaml#soft", "-o", "two"]) == 0
    capsys.readouterr()
    assert main(["compile", "arm.yaml#hard", "-o", "two"]) == 2
    assert "was written from arm.yaml#soft, and this run writes arm.yaml#hard" in capsys.readouterr().err
    Path("b").mkdir()
    Path("b/arm.xml").write_text(MODEL)
    Path("b/arm.yaml").write_text(Path("stiff.yaml").read_text())
    assert main(["compile", "b/arm.yaml", "-o", "out"]) == 2
    assert (
        "was written from arm.yaml of robot 'arm', and this run writes arm.yaml of robot 'stiff'"
        in capsys.readouterr().err
    )


def test_a_manifest_of_before(stiff: str, spec: Path, capsys: Any) -> None:
    """A manifest without robot and others, as actspec wrote it before: its files are those of the spec it names."""
    path = Path("out/mujoco/manifest.json")
    record = json.loads(path.read_text())
    del record["robot"]
    path.write_text(json.dumps(record))
    assert main(["compile", "stiff.yaml", "-o", "out"]) == 2
    assert "was written from arm.yaml, and" in capsys.readouterr().err
    spec.write_text(SPEC.replace("kp: 20", "kp: 21"))
    assert main(["compile", "arm.yaml", "-o", "out"]) == 0
    assert [record["robot"] for record in manifest()] == ["arm"]


@pytest.mark.parametrize(
    "text, said",
    [
        ("mine", "arm.xml: OUT003: exists already, and was edited since actspec wrote it"),
        (None, "arm.xml: OUT003: exists already, and no manifest.json beside it says that actspec wrote it"),
        ("{}", "manifest.json: OUT003: exists already, and is no manifest of actspec"),
    ],
)
def test_why_a_file_stays(text: str | None, said: str, stiff: str, spec: Path, capsys: Any) -> None:
    """An edited file, one that no manifest names, and a manifest of another program, each with its reason."""
    spec.write_text(SPEC.replace("kp: 20", "kp: 21"))
    if text is None:
        Path("out/mujoco/manifest.json").unlink()
    else:
        Path("out/mujoco/manifest.json" if text == "{}" else stiff).write_text(text)
    assert main(["compile", "arm.yaml", "-o", "out"]) == 2
    assert f"out/mujoco/{said}\n" in capsys.readouterr().err


def manifest() -> list[dict[str, Any]]:
    """What the manifest of `out/mujoco` says of each spec; it is as its schema has it."""
    record = json.loads(Path("out/mujoco/manifest.json").read_text())
    jsonschema.validate(record, json.loads((ROOT / "schemas/actspec-manifest-v1.schema.json").read_text()))
    return [record, *record.pop("others", [])]


def test_the_model_itself_is_never_replaced(spec: Path) -> None:
    """An output folder that is the model's own folder does not cost the user the model."""
    Path("mujoco").mkdir()
    Path("mujoco/arm.xml").write_text(MODEL)
    spec.write_text(SPEC.replace("model: arm.xml", "model: mujoco/arm.xml"))
    assert main(["compile", "arm.yaml", "-o", "."]) == 2
    assert Path("mujoco/arm.xml").read_text() == MODEL


@pytest.mark.skipif(not hasattr(os, "fork"), reason="no forks there")
@pytest.mark.parametrize("back", [False, True])
def test_after_a_kill(back: bool, spec: Path, capsys: Any) -> None:
    """Killed when one of two files has been replaced: the next run goes on, or back, without --force."""
    old = spec.read_text()
    assert main(["compile", "arm.yaml"]) == 0
    before = OUT.read_bytes()
    spec.write_text(old.replace("kp: 20", "kp: 30"))
    child = os.fork()
    if child == 0:
        real, calls = os.replace, iter(range(9))
        os.replace = lambda *a: real(*a) if next(calls) == 0 else os.kill(os.getpid(), 9)
        main(["compile", "arm.yaml"])
        os._exit(0)
    assert os.WTERMSIG(os.waitpid(child, 0)[1]) == 9
    # The main file is new, the manifest of the old spec lies beside it.
    assert OUT.read_bytes() != before
    if back:
        spec.write_text(old)
    assert main(["compile", "arm.yaml"]) == 0
    assert (OUT.read_bytes() == before) is back
    assert sorted(os.listdir(OUT.parent)) == ["arm.xml", "manifest.json"]


def test_two_targets_of_one_file(spec: Path, capsys: Any) -> None:
    """Two versions of one target write the same paths: neither is written."""
    assert main(["compile", "arm.yaml", "-t", "mujoco==4.0", "-t", "mujoco==3.7"]) == 2
    assert (
        "build/arm/mujoco/arm.xml: OUT004: this run writes it twice, for 'mujoco'" in capsys.readouterr().err
    )
    assert not Path("build").exists()


def test_target_on_the_command_line(spec: Path) -> None:
    """--target mujoco==3.11 compiles for that version whatever the spec says."""
    assert main(["compile", "arm.yaml", "-t", "mujoco==3.11"]) == 0
    assert "for MuJoCo 3.11." in OUT.read_text()


@pytest.mark.parametrize(
    "target, said",
    [
        ("mujoco==3.99", "MJC007"),
        ("mujoco==", "MJC007"),
        ("mujco", "did you mean 'mujoco'?"),
        ("newton==1.1", "NWT007"),
    ],
    ids=["no such version", "no version", "misspelt", "another kind's"],
)
def test_wrong_targets(target: str, said: str, spec: Path, capsys: Any) -> None:
    """A target that cannot be compiled is an error with help, exit code 2, nothing written."""
    assert main(["compile", "arm.yaml", "-t", target]) == 2
    assert said in capsys.readouterr().err
    assert not Path("build").exists()


def test_all_errors_of_both_targets_at_once(spec: Path, capsys: Any) -> None:
    """Two targets that fail are both reported in one run."""
    spec.write_text(
        SPEC.replace('version: "4.0"', 'version: "9.9"') + '  two: {target: mujoco, version: "8.8"}\n'
    )
    assert main(["compile", "arm.yaml"]) == 2
    err = capsys.readouterr().err
    assert "targets.mujoco.version" in err and "targets.two.version" in err


def test_nothing_is_written_when_one_of_two_specs_fails(spec: Path) -> None:
    """Several specs are compiled before the first file is written."""
    Path("bad.yaml").write_text(SPEC.replace("[knee]", "[nee]"))
    assert main(["compile", "arm.yaml", "bad.yaml"]) == 2
    assert not Path("build").exists()


@pytest.mark.slow
def test_plain_output_in_a_pipe(spec: Path) -> None:
    """In a pipe there is no colour, and a closed pipe is no traceback."""
    command = [sys.executable, "-m", "actspec", "compile", "arm.yaml"]
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    assert "\x1b" not in done.stdout + done.stderr


def test_version(capsys: Any) -> None:
    """--version names the tool and its version."""
    import actspec

    with pytest.raises(SystemExit) as stop:
        main(["--version"])
    assert stop.value.code == 0
    assert capsys.readouterr().out == f"actspec {actspec.__version__}\n"
