"""`actspec diff` as a user meets it: files, revisions of a real git repository, exit codes, JSON."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import pytest

from actspec.cli.main import main
from tests.audit.robots import CFG, LEG, SPEC
from tests.schemas import fits

KNEE = LEG.replace(
    'name="knee" range="-1 1" limited="true" damping="1"',
    'name="knee" range="-1 1" limited="true" damping="19"',
)
TOLD = "  knee:\n    joint damping 1 -> 19 N*m*s/rad (x19)\n    total damping 4 -> 22 N*m*s/rad (x5.5)\n"


def git(*arguments: str) -> None:
    """A git command in the working folder."""
    identity = ["-c", "user.name=t", "-c", "user.email=t@localhost", "-c", "commit.gpgsign=false"]
    subprocess.run(["git", *identity, *arguments], check=True, capture_output=True)


def commit(**files: str) -> None:
    """A commit of files; `__` is `/` and `_dot_` is `.` in their names."""
    for name, text in files.items():
        path = Path(name.replace("__", "/").replace("_dot_", "."))
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        git("add", "--", str(path))
    git("commit", "-q", "-m", "x")


@pytest.fixture
def repository(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A repository whose last commit raised the knee's damping from 1 to 19, with the model below an include."""
    if shutil.which("git") is None:
        pytest.skip("no git")
    folder = tmp_path / "repository"
    folder.mkdir()
    monkeypatch.chdir(folder)
    git("init", "-q")
    scene = '<mujoco model="leg"><include file="parts/leg.xml"/></mujoco>\n'
    commit(robots__scene_dot_xml=scene, robots__parts__leg_dot_xml=LEG, robots__leg_dot_yaml=SPEC)
    commit(robots__parts__leg_dot_xml=KNEE, robots__leg_dot_xml=LEG)
    return folder


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The working folder, in no repository."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("GIT_CEILING_DIRECTORIES", str(tmp_path.parent))
    return tmp_path


def test_two_files(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A change is told with exit code 1; none is told with 0."""
    (folder / "a.xml").write_text(LEG)
    (folder / "b.xml").write_text(KNEE)
    assert main(["diff", "a.xml", "b.xml"]) == 1
    out = capsys.readouterr()
    assert out.out.startswith("a.xml -> b.xml (leg)\n" + TOLD)
    assert "damping ratio" in out.out
    assert out.err == ""
    assert main(["diff", "a.xml", "a.xml"]) == 0
    assert capsys.readouterr().out == "no change in effective dynamics\n"


def test_json(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The JSON has the form of its schema, with figures, lines, and no limit as a text."""
    (folder / "a.xml").write_text(LEG)
    (folder / "b.xml").write_text(KNEE.replace('forcerange="-30 30" forcelimited="true"', ""))
    assert main(["diff", "a.xml", "b.xml", "--output-format", "json"]) == 1
    record = json.loads(capsys.readouterr().out)
    fits("diff", record)
    (robot,) = record["robots"]
    assert robot["old"] == {"file": "a.xml", "kind": "mjcf", "robot": "leg"}
    found = {(change["joint"], change["field"]): change for change in robot["changes"]}
    limit = found["knee", "effort_limit"]
    assert (limit["old"], limit["new"], limit["ratio"], limit["unit"]) == (30.0, "Infinity", None, "N*m")
    damping = found["knee", "joint_damping"]
    assert (damping["old"], damping["new"], damping["ratio"]) == (1.0, 19.0, 19.0)
    assert (damping["old_line"], damping["new_line"]) == (8, 8)


@pytest.mark.parametrize(
    "old, new",
    [
        ("HEAD~1:robots/scene.xml", "robots/scene.xml"),
        ("HEAD~1:./robots/scene.xml", "HEAD:robots/scene.xml"),
        ("HEAD~1:robots/parts/leg.xml", "robots/parts/leg.xml"),
    ],
    ids=["working tree", "two revisions", "the include"],
)
def test_revisions(old: str, new: str, repository: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A revision's file is read with the includes of that revision, and is called what the user calls it."""
    assert main(["diff", old, new]) == 1
    out = capsys.readouterr().out
    assert out.startswith(f"{old} -> {new} (leg)\n{TOLD}")


def test_revision_of_a_spec(repository: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A spec's model is that of the revision: in the first commit there was none."""
    assert main(["diff", "HEAD:robots/leg.yaml", "robots/leg.yaml"]) == 0
    capsys.readouterr()
    assert main(["diff", "HEAD~1:robots/leg.yaml", "robots/leg.yaml"]) == 2
    err = capsys.readouterr().err
    assert err.startswith("HEAD~1:robots/leg.yaml:2:27: DIF001: cannot be read:")
    assert "tmp" not in err
    with Path("robots/leg.yaml").open("a") as file:
        file.write("variants: {stiff: {}}\n")
    line = Path("robots/leg.yaml").read_text().count("\n")
    git("commit", "-q", "-a", "-m", "x")
    assert main(["diff", "robots/leg.yaml", "HEAD:robots/leg.yaml#stif"]) == 2
    err = capsys.readouterr().err
    said = f"HEAD:robots/leg.yaml:{line}:1: DIF001: cannot be read: the spec has no variant 'stif'\n"
    assert err.startswith(f"{said}  help: did you mean 'stiff'?\n")


def test_below_the_root(
    repository: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """In a folder of the repository a path may be from the root, as git has it, or from the folder."""
    monkeypatch.chdir(repository / "robots")
    for path in ("robots/scene.xml", "./scene.xml", "scene.xml", "../robots/scene.xml"):
        assert main(["diff", f"HEAD~1:{path}", "scene.xml"]) == 1, path
    assert TOLD in capsys.readouterr().out


@pytest.mark.parametrize("name", ["-leg.xml", "HEAD:leg.xml", "a b;c.xml", "--output=x.xml"])
def test_odd_file_names(name: str, repository: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A leading dash, a colon and blanks are names; a file that is there goes before a revision."""
    Path(name).write_text(LEG)
    git("add", "--", f"./{name}")
    git("commit", "-q", "-m", "x")
    Path(name).write_text(KNEE)
    assert main(["diff", "--", f"HEAD:./{name}", name]) == 1
    assert capsys.readouterr().out.startswith(f"HEAD:./{name} -> {name} (leg)\n{TOLD}")


@pytest.mark.parametrize("command", ["diff", "import"])
@pytest.mark.parametrize(
    ("folder", "file"), [("run", "run/params/env.yaml"), ("run/params", "run/params/env.yaml")]
)
def test_the_folder_of_a_run(
    command: str,
    folder: str,
    file: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """`audit` takes it for its run; where a file is asked for, the help names that."""
    monkeypatch.chdir(tmp_path)
    Path("run/params").mkdir(parents=True)
    Path("run/params/env.yaml").touch()
    Path("robots").mkdir()
    assert main([command, folder, "robots"]) == 2
    said = capsys.readouterr().err
    assert said.count("help:") == 1 and f"help: it is the folder of a run: name {file}\n" in said


@pytest.mark.slow
@pytest.mark.parametrize(
    "side, message",
    [
        ("HEAD~9:robots/scene.xml", "DIF002: git knows no revision 'HEAD~9'"),
        ("--output=x:robots/scene.xml", "DIF002: names no revision: '--output=x'"),
        ("HEAD:scene2.xml", "DIF002: the revision has no such file"),
        ("HEAD:parts/leg.xml", "DIF002: the revision has no such file"),
        ("HEAD:", "DIF002: names no file of the revision"),
        (":robots/scene.xml", "DIF002: names no revision: ''"),
        ("HEAD:link.xml", "DIF002: is a link or a submodule there, not a file"),
        ("nothing.xml", "DIF001: cannot be read:"),
        ("robots", "DIF001: is a folder: name the files"),
    ],
    ids=["revision", "option", "file", "near", "no file", "no revision", "link", "no such file", "folder"],
)
def test_what_cannot_be_compared(
    side: str, message: str, repository: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It says why, with exit code 2 and without a traceback; an option of git is never passed on."""
    os.symlink("robots/scene.xml", "link.xml")
    git("add", "link.xml")
    git("commit", "-q", "-m", "x")
    Path("link.xml").unlink()
    before = sorted(os.listdir())
    assert main(["diff", "--", side, "robots/scene.xml"]) == 2
    err = capsys.readouterr().err
    assert err.startswith(f"{side}: {message}")
    assert sorted(os.listdir()) == before
    if "parts" in side:
        assert "did you mean HEAD:robots/parts/leg.xml?" in err


def test_nothing_of_the_repository_runs(repository: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Text conversion and filters that a repository asks for are not run."""
    trap = repository / "ran"
    Path(".gitattributes").write_text("*.xml diff=evil filter=evil\n")
    git("config", "diff.evil.textconv", f"touch {trap};cat")
    git("config", "filter.evil.smudge", f"touch {trap};cat")
    git("config", "core.fsmonitor", f"touch {trap}")
    assert main(["diff", "HEAD~1:robots/scene.xml", "robots/scene.xml"]) == 1
    assert not trap.exists()


def test_without_a_repository(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Outside a repository a revision is neither a file nor a revision."""
    (folder / "a.xml").write_text(LEG)
    assert main(["diff", "HEAD:a.xml", "a.xml", "--output-format", "json"]) == 2
    record = json.loads(capsys.readouterr().out)
    assert record["format"] == "actspec-diff/1"
    (item,) = record["diagnostics"]
    assert item["message"] == "is neither a file nor a revision: this folder is in no git repository"


def test_version_decides_on_friction(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With versions Isaac Lab's friction has a unit; `dynamic_friction` is the sliding one, which is compared."""
    both = CFG.replace("friction=0.2", "friction=0.2, dynamic_friction=0.2")
    (folder / "a.py").write_text(both)
    (folder / "b.py").write_text(both.replace("=0.2", "=0.3"))
    assert main(["diff", "a.py", "b.py", "-t", "isaaclab==2.3", "-t", "isaac_sim==5.1"]) == 1
    assert "dry friction 0.2 -> 0.3 N*m (+50 %)" in capsys.readouterr().out


@pytest.mark.parametrize("change", [('kp="100"', 'kp="40"'), ('name="knee"', 'name="shin"'), ("", "")])
def test_long_names(change: tuple[str, str], folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A name of a stranger's file never fills the terminal: of joints that changed, came or went, and of robots."""
    long = "k" * 100_000
    text = LEG.replace("knee", long).replace('model="leg"', f'model="{long}"')
    (folder / "old.xml").write_text(text)
    old, new = (part.replace("knee", long) for part in change)
    assert old in text
    (folder / "new.xml").write_text(text.replace(old, new) if old else text)
    main(["diff", "old.xml", "new.xml"])
    main(["lock", "old.xml", "-o", "x.lock"])
    (folder / "old.xml").write_text(text.replace(old, new) if old else text)
    main(["lock", "--check", "-o", "x.lock"])
    said = capsys.readouterr()
    assert max(map(len, (said.out + said.err).splitlines())) < 200
    if old:
        assert "k" * 57 + "..." in said.out


def test_joints_that_are_named(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """From a file or a list: what is stated by pattern is then the joints'; a file that names them needs no names."""
    text = CFG.replace('["hip", "knee"]', '[".*hip", ".*knee"]').replace(
        "=100.0", '={"l_.*": 100.0, "r_.*": 120.0}'
    )
    (folder / "a.py").write_text(text)
    (folder / "b.py").write_text(text.replace("120.0", "150.0"))
    assert main(["diff", "a.py", "b.py"]) == 1
    told = "stiffness kp 120 -> 150 N*m/rad (+25 %)\n"
    assert capsys.readouterr().out == f"a.py -> b.py (LEG_CFG)\n  r_.*:\n    {told}"
    (folder / "names.txt").write_text("l_hip\nr_hip\nl_knee\nr_knee\n")
    for names in ("names.txt", "l_hip,r_hip,l_knee,r_knee"):
        assert main(["diff", "a.py", "b.py", "--joints", names]) == 1
        assert capsys.readouterr().out == f"a.py -> b.py (LEG_CFG)\n  r_hip, r_knee:\n    {told}"
    assert main(["diff", "a.py", "b.py", "--joints", "ankle"]) == 2
    said = "DRF011 --joints: none of its joints is selected by .*hip, .*knee\n  help: its joints: ankle\n"
    assert said in capsys.readouterr().err
    (folder / "leg.xml").write_text(LEG)
    (folder / "leg.yaml").write_text(SPEC)
    assert main(["diff", "leg.xml", "leg.xml", "--joints", "hip"]) == 2
    assert (
        "leg.xml: DRF011 --joints: not needed: the robot file names the joints\n" in capsys.readouterr().err
    )
    assert main(["diff", "leg.yaml", "leg.yaml", "--joints", "hip"]) == 2
    assert "leg.yaml: DRF011 --joints: not needed: the spec names the joints\n" in capsys.readouterr().err
