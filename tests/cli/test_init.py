"""`actspec init` on the command line: what it writes, where, what it says, and what it refuses."""

from __future__ import annotations

import os
from importlib import metadata
from pathlib import Path

import pytest

from actspec.cli.main import main
from actspec.robot.load import load_robot
from actspec.spec.validate import load_spec

ROBOT = """<mujoco model="pendulum">
  <option timestep="0.004"/>
  <worldbody>
    <body><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="swing" damping="0.1"/>
      <body><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="free_end"/></body>
    </body>
  </worldbody>
  <actuator><position name="a" joint="swing" kp="20" kv="1" forcerange="-5 5"/></actuator>
</mujoco>
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty folder to work in."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_start(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without arguments it writes actspec.yaml, in which only the robot's file is to be named, and says so."""
    assert main(["init"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("wrote actspec.yaml: ")
    assert "  actspec validate actspec.yaml\n" in out
    assert os.listdir(folder) == ["actspec.yaml"]
    assert main(["validate", "actspec.yaml"]) == 2
    (line,) = [line for line in capsys.readouterr().err.splitlines() if "help:" not in line]
    assert line.endswith("ROBOT101 robot.model: there is no model 'my_robot.xml'")


def test_start_compiles_once_the_model_is_named(folder: Path) -> None:
    """The example fits a quadruped with hip, thigh and calf joints as soon as its model is there."""
    assert main(["init"]) == 0
    leg = "".join(
        f'<body><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="FL_{part}_joint" range="-90 90"/>'
        for part in ("hip", "thigh", "calf")
    )
    grip = '<body><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="gripper_1"/></body>'
    (folder / "my_robot.xml").write_text(
        f"<mujoco><worldbody>{leg}</body></body></body>{grip}</worldbody></mujoco>", encoding="utf-8"
    )
    assert main(["compile", "actspec.yaml", "-o", "out"]) == 0


@pytest.mark.parametrize("source", [None, "robot.xml"], ids=["start", "draft"])
def test_never_overwrites(folder: Path, source: str | None, capsys: pytest.CaptureFixture[str]) -> None:
    """A file that is there stays as it is, with help; --force replaces it."""
    (folder / "robot.xml").write_text(ROBOT, encoding="utf-8")
    (folder / "spec.yaml").write_text("mine\n", encoding="utf-8")
    arguments = ["init", "spec.yaml", *(["--from", source] if source else [])]
    assert main(arguments) == 2
    assert capsys.readouterr().err == (
        "spec.yaml: OUT003: exists already, and would be lost\n"
        "  help: name another file, or replace it with --force\n"
        "1 error; nothing was written\n"
    )
    assert (folder / "spec.yaml").read_text(encoding="utf-8") == "mine\n"
    assert main([*arguments, "--force"]) == 0
    assert load_spec("spec.yaml").model.actspec == 1
    assert sorted(os.listdir(folder)) == ["robot.xml", "spec.yaml"]


def test_draft(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """--from imports the file: its model is found from the spec's own folder, and it compiles."""
    (folder / "models").mkdir()
    (folder / "models" / "robot.xml").write_text(ROBOT, encoding="utf-8")
    assert main(["init", "specs/new/spec.yaml", "--from", "models/robot.xml"]) == 0
    said = capsys.readouterr().out
    assert said == (
        "wrote specs/new/spec.yaml: 1 joint in 1 group (swing), from models/robot.xml\n"
        "  unmanaged, no actuator: free_end\n"
        "  no file states armature: swing\n"
        "  no file states friction.coulomb: swing\n"
        "next: check it, then\n"
        "  actspec show specs/new/spec.yaml\n"
        "  actspec compile specs/new/spec.yaml\n"
    )
    spec = load_spec("specs/new/spec.yaml")
    assert spec.model.robot.model == "../../models/robot.xml"
    assert main(["compile", "specs/new/spec.yaml", "-o", "out"]) == 0
    capsys.readouterr()
    assert load_robot("out/mujoco/robot.xml").timestep == 0.004


def test_draft_of_bare_model(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Where the file has no gains, what to state before a compile is said."""
    bare = ROBOT[: ROBOT.index("<actuator>")] + "</mujoco>"
    (folder / "robot.xml").write_text(bare, encoding="utf-8")
    assert main(["init", "--from", "robot.xml"]) == 0
    assert "next: check it, state kp and kd, then\n" in capsys.readouterr().out
    assert main(["compile", "actspec.yaml", "-o", "out"]) == 2
    assert "kp is unknown, and MuJoCo needs a number" in capsys.readouterr().err


def test_package(folder: Path) -> None:
    """A model of an installed distribution is named by it, as it was given."""
    try:
        metadata.distribution("mjlab")
    except metadata.PackageNotFoundError:
        pytest.skip("mjlab is not installed")
    model = "package://mjlab/mjlab/asset_zoo/robots/unitree_go1/xmls/go1.xml"
    assert main(["init", "--from", model]) == 0
    assert load_spec("actspec.yaml").model.robot.model == model


def test_reader_is_heard(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What the reader of the robot file has to say goes to stderr."""
    text = ROBOT.replace('<joint name="free_end"/>', "<joint/>")
    (folder / "robot.xml").write_text(text, encoding="utf-8")
    assert main(["init", "--from", "robot.xml"]) == 0
    assert "ROBOT113 [info]: 1 joint without a name left out" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments, code, words",
    [
        (["--from", "robot.xnl"], "DRF004", "did you mean 'robot.xml'?"),
        (["--from", "no/robot.xml"], "DRF004", "its folder does not exist"),
        (["--from", "broken.xml"], "ROBOT004", "broken.xml:2"),
        (["--from", "package://no-such-distribution-here/a.xml"], "ROBOT102", "is not installed"),
        (["folder"], "OUT001", "is a folder"),
        (["folder/"], "OUT001", "is a folder"),
        (["new/"], "OUT001", "is a folder"),
        (["robot.xml/spec.yaml"], "OUT002", "cannot be written"),
        (["robot.xml", "--from", "robot.xml", "--force"], "OUT003", "is read by this command"),
        (["link.xml", "--from", "robot.xml", "--force"], "OUT003", "is read by this command"),
    ],
    ids=["near name", "no folder", "not XML", "not installed", "folder", "folder/", "new/", "below a file",
         "itself", "itself by a link"],
)  # fmt: skip
def test_refused(
    folder: Path, arguments: list[str], code: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """What cannot be done is said without a traceback; exit 2, and nothing is written or replaced."""
    (folder / "robot.xml").write_text(ROBOT, encoding="utf-8")
    (folder / "broken.xml").write_text("<mujoco>\n<a></b></mujoco>", encoding="utf-8")
    (folder / "folder").mkdir()
    os.symlink("robot.xml", folder / "link.xml")
    before = sorted(os.listdir(folder))
    assert main(["init", *arguments]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert code in said.err and words in said.err
    assert sorted(os.listdir(folder)) == before
    assert (folder / "robot.xml").read_text(encoding="utf-8") == ROBOT


def test_name_with_a_space_is_quoted(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The commands that are shown can be pasted."""
    assert main(["init", "my spec.yaml"]) == 0
    assert "  actspec validate 'my spec.yaml'\n" in capsys.readouterr().out


def test_model_called_none(folder: Path) -> None:
    """A file called `none` is not read as `model: none`."""
    (folder / "none").write_text(ROBOT, encoding="utf-8")
    assert main(["init", "--from", "none"]) == 0
    assert main(["compile", "actspec.yaml", "-o", "out"]) == 0
