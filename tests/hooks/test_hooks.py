"""The hooks of .pre-commit-hooks.yaml under the real pre-commit, in real git repositories.

pre-commit makes the hooks' environment and installs this checkout into it, as it does for users. Only what actspec
depends on is not installed once more: it comes from the environment of the tests, over PYTHONPATH.
"""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
import sysconfig
from dataclasses import dataclass
from pathlib import Path

import pytest
import yaml

from actspec.cli.main import main
from actspec.spec.yaml_text import is_spec

ROOT = Path(__file__).resolve().parents[2]
SHIPPED = ("actspec", "robots", "schemas", "templates", "pyproject.toml", "LICENSE", "README.md")
IGNORED = shutil.ignore_patterns("__pycache__", "*.pyc", "MUJOCO_LOG.TXT")

SPEC = """actspec: 1
robot: {name: leg, model: none, joints: [knee]}
actuators:
  legs: {joints: [knee], level: ideal_pd, kp: 40 N*m/rad, kd: KD N*m*s/rad, effort_limit: 12 N*m, armature: unknown}
"""
GOOD, BAD = SPEC.replace("KD", "1"), SPEC.replace("KD", "-1")
"""A spec, and one whose kd is negative."""

MODEL = """<mujoco model="leg">
  <worldbody><body><joint name="knee" armature="0.01" LIMIT/>TOE<geom size="0.1"/></body></worldbody>
  <actuator><motor joint="knee"/><motor joint="kneecap"/></actuator>
</mujoco>
""".replace("TOE", '<joint name="kneecap" axis="0 1 0" armature="0.01" actuatorfrcrange="-1 1"/>')
LIMITED, BARE = MODEL.replace("LIMIT", 'actuatorfrcrange="-9 9"'), MODEL.replace("LIMIT", "")
"""A robot, and one of whose motors one has no limit of any kind (LIM101)."""

STEMS = [
    "with space",
    "it's",
    'quo"te',
    "-v",
    "--output=made",
    "--",
    "line\nfeed",
    "größe 日本",
    "$(touch made)",
    "`touch made`;touch made",
    "*",
    "back\\slash",
    "%s{0}",
]
"""File names that a shell, a parser of options or a format string could take for something else."""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(shutil.which("git") is None, reason="needs git"),
    pytest.mark.skipif(os.name == "nt", reason="file names that Windows does not have"),
]


def _environment(home: Path) -> dict[str, str]:
    """Nothing of the user's own git and pre-commit."""
    kept = {key: value for key, value in os.environ.items() if not key.startswith(("GIT_", "PRE_COMMIT"))}
    return {
        **kept,
        "PRE_COMMIT_HOME": str(home / "pre-commit"),
        "GIT_CONFIG_GLOBAL": os.devnull,
        "GIT_CONFIG_SYSTEM": os.devnull,
        "GIT_AUTHOR_NAME": "a",
        "GIT_AUTHOR_EMAIL": "a@b",
        "GIT_COMMITTER_NAME": "a",
        "GIT_COMMITTER_EMAIL": "a@b",
        "PYTHONPATH": os.pathsep.join(dict.fromkeys(sysconfig.get_path(k) for k in ("purelib", "platlib"))),
        "PYTHONDONTWRITEBYTECODE": "1",
        # Off: the build backend is there, over PYTHONPATH. pip reads this variable the other way round.
        "PIP_NO_BUILD_ISOLATION": "0",
        "PIP_NO_DEPS": "1",
    }


def _call(*command: str, cwd: Path, env: dict[str, str]) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        command,
        cwd=cwd,
        env=env,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        encoding="utf-8",
        check=False,
    )


def _git(folder: Path, env: dict[str, str], *arguments: str) -> str:
    done = _call("git", *arguments, cwd=folder, env=env)
    assert done.returncode == 0, done.stdout
    return done.stdout.strip()


@dataclass(frozen=True)
class Hooks:
    """This checkout as a repository of hooks.

    Attributes:
        path: Where.
        revision: Its commit.
        env: Environment variables for git and pre-commit.
    """

    path: Path
    revision: str
    env: dict[str, str]


@pytest.fixture(scope="module")
def hooks(tmp_path_factory: pytest.TempPathFactory) -> Hooks:
    """The repository of the hooks; pre-commit keeps the environment that it makes for all tests here."""
    pytest.importorskip("pre_commit")
    pytest.importorskip("hatchling")
    home = tmp_path_factory.mktemp("hooks")
    env = _environment(home)
    folder = home / "actspec"
    folder.mkdir()
    for name in (*SHIPPED, ".pre-commit-hooks.yaml"):
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, folder / name, ignore=IGNORED)
        else:
            shutil.copy(source, folder / name)
    for arguments in (("init", "--quiet"), ("add", "--all"), ("commit", "--quiet", "--message", "all")):
        _git(folder, env, *arguments)
    return Hooks(folder, _git(folder, env, "rev-parse", "HEAD"), env)


class Project:
    """A user's repository."""

    def __init__(self, folder: Path, hooks: Hooks) -> None:
        self.folder = folder
        self.hooks = hooks
        _git(folder, hooks.env, "init", "--quiet")

    def use(self, hook: str, **settings: object) -> None:
        """Write the configuration: one hook, with settings of the user's own."""
        repo = {
            "repo": str(self.hooks.path),
            "rev": self.hooks.revision,
            "hooks": [{"id": hook, **settings}],
        }
        self.write(".pre-commit-config.yaml", yaml.safe_dump({"repos": [repo]}))

    def write(self, name: str, text: str) -> None:
        """Write a file, its folders too."""
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def commit(self) -> subprocess.CompletedProcess[str]:
        """Stage everything and run the hooks over what is staged, as `git commit` would."""
        _git(self.folder, self.hooks.env, "add", "--all")
        before = self.files()
        done = _call(sys.executable, "-m", "pre_commit", "run", cwd=self.folder, env=self.hooks.env)
        assert self.files() == before, "a hook wrote something"
        return done

    def files(self) -> dict[str, bytes]:
        """All files but git's own."""
        return {
            str(path.relative_to(self.folder)): path.read_bytes()
            for path in self.folder.rglob("*")
            if path.is_file() and path.relative_to(self.folder).parts[0] != ".git"
        }


@pytest.fixture
def project(tmp_path: Path, hooks: Hooks) -> Project:
    """A user's repository, still empty."""
    folder = tmp_path / "project"
    folder.mkdir()
    return Project(folder, hooks)


def _shown(name: str) -> str:
    """A name as a message has it: control characters escaped."""
    return name.replace("\n", "\\n")


def test_the_installed_copy_is_what_runs(project: Project) -> None:
    """The hooks' environment has an actspec of its own: not that of the tests, nor the working tree."""
    project.use("actspec-validate")
    project.write("leg.yaml", GOOD)
    assert project.commit().returncode == 0
    (python,) = Path(project.hooks.env["PRE_COMMIT_HOME"]).glob("repo*/py_env-*/bin/python")
    ask = "import actspec; print(actspec.__file__)"
    done = _call(str(python), "-c", ask, cwd=project.folder, env=project.hooks.env)
    assert Path(done.stdout.strip()).is_relative_to(python.parents[1]), done.stdout


SPECS = [
    GOOD,
    "\ufeff" + GOOD,
    "# a comment\n" + GOOD,
    GOOD.replace("actspec: 1", '"actspec" : 1'),
    "{ actspec: 1, robot: {name: leg, model: none, joints: [knee]}, actuators: {}}\n",
    GOOD.replace("\n", "\r\n"),
]


@pytest.mark.parametrize(
    "text", SPECS, ids=["plain", "byte order mark", "comment", "quoted", "flow", "carriage returns"]
)
def test_specs_are_known(text: str) -> None:
    """A spec is known as one, however its first key is written."""
    assert is_spec(text.encode())


@pytest.mark.parametrize(
    "hook, ending, good, bad, code",
    [
        ("actspec-validate", ".yaml", GOOD, BAD, "SPEC"),
        ("actspec-audit", ".xml", LIMITED, BARE, "LIM101"),
    ],
    ids=["validate", "audit"],
)
def test_names_are_only_names(
    hook: str, ending: str, good: str, bad: str, code: str, project: Project
) -> None:
    """Whatever a file is called, it is read under its name, its fault is shown, and nothing else happens."""
    project.use(hook)
    project.write("actspec.toml", '[audit]\nfail-on = "warning"\n')
    for stem in STEMS:
        project.write(f"{stem}{ending}", good)
    clean = project.commit()
    assert clean.returncode == 0, clean.stdout
    assert "Passed" in clean.stdout
    for index, stem in enumerate(STEMS):
        # Robots of their own: copies of one would be one finding with a list.
        project.write(
            f"{stem}{ending}", bad.replace("knee", f"knee{'_' * index}").replace("leg", f"leg_{index}")
        )
    failed = project.commit()
    assert failed.returncode == 1
    lines = failed.stdout.splitlines()
    for stem in STEMS:
        start = _shown(f"{stem}{ending}:")
        assert any(line.startswith(start) and code in line for line in lines), (stem, failed.stdout)


OTHER = {
    "ci.yaml": "on: push\njobs: {}\n",
    "broken.yaml": "a: [1\n",
    "note.yaml": "tool:\n  actspec: 1\n",
    "results.yaml": "actspec-results: 1\n",
    "empty.yaml": "",
    "large.yaml": "a: 1\n" * 300_000,
    "robot.launch.xml": "<launch><arg name='a'/></launch>\n",
    "broken.xml": "<a><b></a>\n",
    "setup.py": "print('never')\n",
    "broken.py": "def (\n",
}
"""Files with the endings of specs and robots, and something else in them."""


@pytest.mark.parametrize("name", OTHER)
def test_other_files_are_passed_over(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file that is no spec and no robot's is nothing to a hook, and an error to who names it by hand."""
    monkeypatch.chdir(tmp_path)
    Path(name).write_text(OTHER[name])
    commands = ["audit", "validate"] if name.endswith(".yaml") else ["audit"]
    for command in commands:
        assert main([command, "--skip-other", "--", name]) == 0
        assert name not in "".join(capsys.readouterr())
        assert main([command, "--", name]) == (1 if command == "audit" else 2)
        capsys.readouterr()


def _pasted(hook: str) -> dict[str, object]:
    """Settings of a hook in the example of docs/audit.md."""
    text = (ROOT / "docs" / "audit.md").read_text(encoding="utf-8")
    block = text.split('title=".pre-commit-config.yaml"\n')[1].split("```")[0]
    hooks: list[dict[str, object]] = yaml.safe_load(block)["repos"][0]["hooks"]
    (found,) = (each for each in hooks if each["id"] == hook)
    return {key: value for key, value in found.items() if key != "id"}


def test_a_commit_that_only_deletes(project: Project) -> None:
    """pre-commit gives a hook no deleted files: as pasted it is skipped, with `always_run` what was lost is told."""
    pasted = _pasted("actspec-audit")
    for stem in ("leg", "arm"):
        project.write(f"robots/{stem}.xml", BARE.replace("leg", stem))
    project.write("actspec.toml", '[audit]\nbaseline = "known.json"\n')
    argument = ["audit", "robots", "--as-named", "--write-baseline", "known.json"]
    done = _call(sys.executable, "-m", "actspec", *argument, cwd=project.folder, env=project.hooks.env)
    assert done.returncode == 0, done.stdout
    project.use("actspec-audit", **pasted)
    assert project.commit().returncode == 0
    _git(project.folder, project.hooks.env, "commit", "--quiet", "--message", "all")
    (project.folder / "robots" / "arm.xml").unlink()
    skipped = project.commit()
    assert skipped.returncode == 0 and "(no files to check)" in skipped.stdout
    project.use("actspec-audit", **pasted, always_run=True)
    failed = project.commit()
    assert failed.returncode == 1 and "AUD021" in failed.stdout, failed.stdout


def test_a_broken_spec_is_told_once(project: Project) -> None:
    """As pasted, the first hook tells it, and the audit, which would call it unreadable, is not run."""
    project.use("actspec-validate", **_pasted("actspec-validate"))
    config = yaml.safe_load((project.folder / ".pre-commit-config.yaml").read_text())
    config["repos"][0]["hooks"].append({"id": "actspec-audit", **_pasted("actspec-audit")})
    project.write(".pre-commit-config.yaml", yaml.safe_dump(config))
    project.write("robots/leg.yaml", BAD)
    done = project.commit()
    assert done.returncode == 1 and "SPEC" in done.stdout
    assert "AUD008" not in done.stdout, done.stdout


def test_the_audit_hook_is_calm(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One line a warning, notes counted; what the settings exclude is passed over though pre-commit names it."""
    monkeypatch.chdir(tmp_path)
    (hook,) = [
        h for h in yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text()) if h["id"] == "actspec-audit"
    ]
    Path("vendor").mkdir()
    for name in ("leg.xml", "vendor/leg.xml"):
        # Without armature: GEA104, a note.
        Path(name).write_text(BARE.replace('armature="0.01"', ""))
    Path("vendor/broken.xml").write_text("<mujoco>")
    Path("actspec.toml").write_text('[audit]\nexclude = ["vendor"]\nselect = ["LIM101", "GEA104"]\n')
    command, *entry = shlex.split(hook["entry"])
    assert command == "actspec"
    assert main([*entry, *hook["args"], "leg.xml", "vendor/broken.xml", "vendor/leg.xml"]) == 0
    first, *rest = capsys.readouterr().out.splitlines()
    assert first.startswith("leg.xml:3:13: LIM101 [warning] knee: ")
    left = "1 warning affecting 1 joint in 1 file; 2 files left out by exclude"
    assert rest == ["1 note (GEA104): --notes shows it", left]


def test_the_hook_of_the_readme_fails_on_a_warning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """5 N*m in the URDF and a control of 300 in the MJCF is a warning, which pre-commit hides where the hook passes."""
    hooks = {hook["id"]: hook for hook in yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())}
    _, *entry = shlex.split(hooks["actspec-audit"]["entry"])
    monkeypatch.chdir(tmp_path)
    Path("robots").mkdir()
    urdf = """<robot name="leg"><link name="base"/><link name="shank"/>
  <joint name="knee" type="revolute"><parent link="base"/><child link="shank"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="5" velocity="20"/></joint></robot>
"""
    model = """<mujoco model="leg">
  <worldbody><body><joint name="knee" range="-57.29578 57.29578" armature="0.01"/><geom size="0.1"/></body></worldbody>
  <actuator><motor joint="knee" ctrlrange="-300 300"/></actuator>
</mujoco>
"""
    Path("robots/leg.xml").write_text(model)
    Path("robots/leg.urdf").write_text(urdf)
    for page in ("README.md", "docs/audit.md"):
        text = (ROOT / page).read_text(encoding="utf-8")
        block = text.split('title=".pre-commit-config.yaml"\n')[1].split("```")[0]
        used = {hook["id"]: hook for hook in yaml.safe_load(block)["repos"][0]["hooks"]}["actspec-audit"]
        assert main([*entry, *used["args"]]) == 1, page
        out = capsys.readouterr().out
        assert (
            "SRC101 [warning] knee: the effort limit is 300 N*m here and 5 N*m in robots/leg.urdf (x60)"
            in out
        )


def test_what_is_not_there_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    """A wrong name is no other file: --skip-other does not hide it."""
    for command, name in (("audit", "gone.xml"), ("audit", "gone.txt"), ("validate", "gone.yaml")):
        assert main([command, "--skip-other", name]) == 2
        assert name in "".join(capsys.readouterr())


def test_a_spec_that_is_none_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """`audit --spec` is a promise that --skip-other does not take back."""
    monkeypatch.chdir(tmp_path)
    Path("ci.yaml").write_text("on: push\n")
    assert main(["audit", "--skip-other", "--spec", "ci.yaml", "ci.yaml"]) == 2
    assert "this is not an actspec spec but something else" in capsys.readouterr().err


def test_other_files_beside_specs_in_a_commit(project: Project) -> None:
    """YAML, XML and Python of every kind pass both hooks, a documentation page with a model in it too."""
    for hook in ("actspec-validate", "actspec-audit"):
        project.use(hook, types_or=["text"], types=["text"])
        project.write("ci.yaml", "on: push\n")
        project.write("broken.xml", "<a><b></a>\n")
        project.write("page.md", "```xml\n<mujoco><worldbody>\n```\n")
        project.write("setup.py", "print('never')\n")
        done = project.commit()
        assert done.returncode == 0, done.stdout
        assert "Passed" in done.stdout


def test_many_specs_in_several_processes(project: Project) -> None:
    """Of a hundred specs the two wrong ones are named, however pre-commit divides them among processes."""
    project.use("actspec-validate")
    for number in range(100):
        project.write(f"specs/{number}.yaml", BAD if number in (17, 83) else GOOD)
    done = project.commit()
    assert done.returncode == 1
    errors = [line for line in done.stdout.splitlines() if "SPEC" in line]
    assert sorted(line.partition(":")[0] for line in errors) == ["specs/17.yaml", "specs/83.yaml"]


URDF = """<robot name="leg">
  <link name="a"/><link name="b"/>
  <joint name="knee" type="revolute">
    <parent link="a"/><child link="b"/><limit lower="-1" upper="1" effort="18" velocity="20"/>
  </joint>
</robot>
"""
"""The robot of LIMITED with twice its effort limit (SRC101)."""


def test_files_of_a_robot_are_audited_together(project: Project) -> None:
    """Among a hundred files those of a robot meet, far as they are apart: one process gets them all."""
    project.use("actspec-audit", args=["--select=SRC101", "--fail-on=info", "--"])
    for number in range(100):
        project.write(f"between/{number}.yaml", "on: push\n")
    robots = range(8)
    for number in robots:
        project.write(f"a/{number}.xml", _numbered(LIMITED, number))
    assert project.commit().returncode == 0
    for number in robots:
        project.write(f"z/{number}.urdf", _numbered(URDF, number))
    done = project.commit()
    assert done.returncode == 1
    found = [line for line in done.stdout.splitlines() if "SRC101" in line and "9 N*m" in line]
    assert len(found) == len(robots), done.stdout


def _numbered(text: str, number: int) -> str:
    """A robot with a name and a joint of its own."""
    return text.replace('"leg"', f'"leg{number}"').replace('"knee"', f'"knee{number}"')


def test_several_processes_at_once(project: Project) -> None:
    """Where a user lets pre-commit run several audits at a time, each file is still judged, once."""
    project.use("actspec-audit", require_serial=False, args=["--fail-on=warning", "--"])
    names = [f"{number}.xml" for number in range(40)]
    for index, name in enumerate(names):
        project.write(name, BARE.replace("knee", f"knee_{index}").replace("leg", f"leg_{index}"))
    done = project.commit()
    assert done.returncode == 1
    found = [line for line in done.stdout.splitlines() if "LIM101 [warning]" in line]
    assert sorted(line.partition(":")[0] for line in found) == sorted(names)


def test_generated_files(project: Project, monkeypatch: pytest.MonkeyPatch) -> None:
    """Compiled files pass; one that was edited by hand fails, and so does a spec that was not compiled again."""
    spec = f"{GOOD}targets: {{deploy: {{}}}}\n"
    project.use("actspec-check-generated", args=["specs/leg.yaml", "-o", "generated"])
    project.write("specs/leg.yaml", spec)
    missing = project.commit()
    assert missing.returncode == 1
    assert "generated/deploy/leg_deploy.yaml: missing\n" in missing.stdout
    monkeypatch.chdir(project.folder)
    assert main(["compile", "specs/leg.yaml", "-o", "generated"]) == 0
    done = project.commit()
    assert done.returncode == 0, done.stdout
    _git(project.folder, project.hooks.env, "commit", "--quiet", "--message", "all")
    generated = project.folder / "generated" / "deploy" / "leg_deploy.yaml"
    text = generated.read_text()
    edited = text.replace("40", "45")
    assert edited != text
    generated.write_text(edited)
    # Only the generated file is staged: the spec is checked all the same.
    stale = project.commit()
    assert stale.returncode == 1
    assert "generated/deploy/leg_deploy.yaml: stale\n" in stale.stdout
    generated.write_text(text)
    project.write("specs/leg.yaml", spec.replace("kp: 40", "kp: 41"))
    assert "generated/deploy/leg_deploy.yaml: stale\n" in project.commit().stdout
