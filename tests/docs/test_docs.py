"""What README and docs show is run: specs are compiled, Python is executed, commands give the printed output.

How a block is read:
- `yaml` with the key `actspec`: a whole spec. Any other is a fragment, laid over the example spec of
  docs/spec-language.md at the path of its first line (`# in actuators.legs`), or at the top. A first line that
  names a file (`# motors/drive.yaml`) makes it that file, for the blocks below it.
- `# gives CODE` in a spec: compiling it must give these diagnostics (information aside) and no other.
- `text` right after a spec: exactly those diagnostics, without their place.
- `xml` with `<mujoco`: leg.xml for the rest of its section. Else, after a spec: lines of the written model.
- `python`: executed, unless its first line names a file; what each `print` line prints stands behind it as a comment.
- `console`: run by bash, in order; a line `...` stands for any lines. In ```` ```console { data-within="0.02" } ````
  so much of a number with a point may differ, as the last digits of a fit do on another processor.
- A fence with a title, ```` ```python title="leg_cfg.py" ````: lines of that file as the spec above compiles to it;
  a line `...` stands for any lines. Attributes name another spec and one target:
  ```` ```python { title="unitree_a1_cfg.py" data-spec="robots/a1.yaml" data-target="isaaclab==2.3" } ````.
- With the title of a file of a user's project: ```` ```toml title="actspec.toml" ```` must be settings that the
  audit takes, ```` ```yaml title=".pre-commit-config.yaml" ```` hooks that there are,
  ```` ```yaml title=".github/workflows/audit.yml" ```` commands that the parser takes.
- ```` ```python { data-needs="mjlab" data-spec="robots/a1.yaml" } ````: for a machine with that framework, beside the
  module that the spec compiles to for it (or for `data-target`): what it takes from the module is there; with
  mjlab it is executed in the real package.

The site reads the same fences: `title` is printed above the block, and the rest of what stands behind a language is
for the tests.
"""

from __future__ import annotations

import ast
import os
import re
import shlex
import shutil
import stat
import subprocess
import sys
import sysconfig
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import pytest
import yaml

from actspec import api
from actspec.audit.rules import all_rules
from actspec.audit.settings import Settings, load_settings
from actspec.cli.main import parser
from actspec.diagnostics import ActspecError, Diagnostic, Severity
from actspec.simulators.isaaclab import RELEASES as ISAACLAB_RELEASES
from actspec.simulators.isaaclab import FrictionUnit, isaaclab_dialect
from actspec.simulators.mjlab import RELEASES as MJLAB_RELEASES
from actspec.simulators.mjlab import mjlab_dialect
from actspec.simulators.newton import RELEASES as NEWTON_RELEASES
from actspec.simulators.newton import newton_dialect
from actspec.spec.document import load_document
from actspec.spec.results import validate_results
from actspec.verify.environments import EngineUnavailableError
from tests.docs.forked import client, server
from tests.frameworks.forking import MJLAB, Forker
from tests.frameworks.prepare import prepare

ROOT = Path(__file__).parents[2]
PAGES = [
    ROOT / "README.md",
    ROOT / "actspec" / "SKILL.md",
    *sorted((ROOT / "docs").rglob("*.md")),
    ROOT / "benchmarks" / "README.md",
]
LANGUAGE = ROOT / "docs" / "spec-language.md"


@dataclass(frozen=True)
class Block:
    """A fenced block of a page."""

    page: Path
    line: int
    section: int
    language: str
    attributes: dict[str, str]
    text: str

    @property
    def id(self) -> str:
        """Where it stands."""
        return f"{self.page.name}:{self.line}"

    @property
    def plain(self) -> bool:
        """Whether nothing but the page's own text says what it is."""
        return not self.attributes or self.language == "console"

    @property
    def needs(self) -> bool:
        """Whether it is for a machine with a framework."""
        return "data-needs" in self.attributes

    @property
    def project(self) -> bool:
        """Whether it is a file of a user's project."""
        return self.language == "toml" or self.title.startswith(".")

    @property
    def title(self) -> str:
        """The file that it shows, "" for none."""
        return self.attributes.get("title", "")

    @property
    def file(self) -> str | None:
        """The file that it is, if its first line names one."""
        found = re.match(r"# ([\w./-]+\.(?:yaml|json|py))\n", self.text)
        return found[1] if found else None


FENCE = re.compile(r'```(\w*)(?: title="[^"]+"| \{(?: [a-z-]+="[^"]+")+ \})?')
"""What both the tests and the site understand."""


def _blocks(page: Path) -> list[Block]:
    found: list[Block] = []
    section = 0
    fence: tuple[int, str, dict[str, str]] | None = None
    body: list[str] = []
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        if fence is None and line.startswith("#"):
            section += 1
        if not line.startswith("```"):
            body.append(line)
        elif fence is None:
            opened = FENCE.fullmatch(line)
            assert opened, f'{page.name}:{number}: not ```python title="FILE"'
            fence, body = (number, opened[1], dict(re.findall(r'([a-z-]+)="([^"]+)"', line))), []
        else:
            found.append(Block(page, fence[0], section, *fence[1:], "\n".join(body) + "\n"))
            fence = None
    assert fence is None, f"{page.name}: a fence is not closed"
    return found


BLOCKS = [block for page in PAGES for block in _blocks(page)]


def _of(*languages: str) -> list[Block]:
    return [block for block in BLOCKS if block.language in languages and block.plain]


SHOWN = [block for block in BLOCKS if not block.plain and not block.needs and not block.project]
PROJECT = [block for block in BLOCKS if block.project]
NEEDING = [block for block in BLOCKS if block.needs]


def _before(block: Block) -> list[Block]:
    return [other for other in BLOCKS if other.page == block.page and other.line < block.line]


def _after(block: Block) -> Block | None:
    return next((other for other in BLOCKS if other.page == block.page and other.line > block.line), None)


def _is_model(block: Block) -> bool:
    return block.language == "xml" and "<mujoco" in block.text


def _example(language: str, key: str) -> Block:
    return next(b for b in _blocks(LANGUAGE) if b.language == language and key in b.text)


def _lay(under: Any, over: Any) -> Any:
    if not isinstance(under, dict) or not isinstance(over, dict):
        return over
    return {**under, **{key: _lay(under.get(key), value) for key, value in over.items()}}


def _spec_data(block: Block) -> Any:
    data = yaml.safe_load(block.text)
    if "actspec" in data:
        return data
    where = re.match(r"# in ([\w.]+)", block.text)
    for key in reversed(where[1].split(".") if where else []):
        data = {key: data}
    return _lay(yaml.safe_load(_example("yaml", "actspec: 1").text), data)


FOOT = """{"format": "actspec-network/1", "kind": "mlp", "inputs": "position_velocity", "taps": [0],
"tap_period": "2 ms", "position_scale": 1, "velocity_scale": 1, "torque_scale": 1, "initial_history": "zero"}"""
"""The manifest that a fragment names."""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with the example robot and spec, and this repository's robots, schemas and docs/example."""
    for name in ("robots", "schemas", "docs/example"):
        shutil.copytree(ROOT / name, tmp_path / name)
    (tmp_path / "leg.xml").write_text(_example("xml", "<mujoco").text)
    (tmp_path / "leg.yaml").write_text(_example("yaml", "actspec: 1").text)
    (tmp_path / "nets").mkdir()
    (tmp_path / "nets" / "foot.json").write_text(FOOT)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def _prepare(block: Block, folder: Path) -> None:
    """Write what the blocks above it define: files, and the model of its section."""
    for other in [*_before(block), block]:
        if other.file is not None:
            path = folder / other.file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(other.text)
        if _is_model(other) and other.section == block.section:
            (folder / "leg.xml").write_text(other.text)


@pytest.mark.slow
@pytest.mark.parametrize(
    "block", [b for b in _of("yaml") if not (b.file and "actspec: 1" not in b.text)], ids=lambda b: b.id
)
def test_specs_compile_as_the_page_says(block: Block, folder: Path) -> None:
    """Every spec and fragment gives exactly the diagnostics and the lines of the model that the page shows."""
    _prepare(block, folder)
    spec = block.file or "spec.yaml"
    if block.file is None:
        (folder / spec).write_text(yaml.safe_dump(_spec_data(block), sort_keys=False))
    told: list[Diagnostic] = []
    written = ""
    try:
        done = api.compile(spec, output="out")
        told = list(done.diagnostics)
        written = "".join(e.files[0].data.decode() for e in done.emissions)
    except ActspecError as err:
        told = list(err.diagnostics)
    told = [d for d in told if d.severity is not Severity.INFO]
    asked = re.findall(r"\b[A-Z]{3,}\d{3}\b", " ".join(re.findall(r"# gives (.*)", block.text)))
    assert sorted({d.code for d in told}) == sorted(set(asked)), "\n".join(map(str, told))
    following = _after(block)
    if following is None or following.section != block.section:
        return
    if following.language == "text" and not following.attributes:
        lines = "".join(f"{replace(d, span=None)}\n" for d in told)
        assert lines == following.text
    if following.language == "xml" and not _is_model(following):
        have = [line.strip() for line in written.splitlines()]
        for line in following.text.splitlines():
            if line.strip() != "...":
                assert line.strip() in have


@pytest.mark.parametrize("block", [b for b in _of("yaml") if b.file], ids=lambda b: b.id)
def test_files_that_specs_name_are_valid(block: Block, folder: Path) -> None:
    """A results file or an include that a page shows is read without an error."""
    _prepare(block, folder)
    assert block.file is not None
    if "actspec-results" in block.text:
        assert validate_results(load_document(block.file)).joints
    elif "actspec: 1" not in block.text:
        spec = {**yaml.safe_load((folder / "leg.yaml").read_text()), "include": [block.file]}
        (folder / "spec.yaml").write_text(yaml.safe_dump(spec))
        assert api.load("spec.yaml").document.includes == (block.file,)


@pytest.mark.slow
@pytest.mark.parametrize("block", [b for b in _of("python") if b.file is None], ids=lambda b: b.id)
def test_python_prints_what_stands_behind_it(block: Block, folder: Path) -> None:
    """Python of the pages runs, and each print line's comment is its output."""
    _prepare(block, folder)
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", block.text],
        env=_environment(),
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stderr == ""
    asked = [
        line.partition("  # ")[2] for line in block.text.splitlines() if line.lstrip().startswith("print(")
    ]
    assert done.stdout.splitlines() == asked


def _environment() -> dict[str, str]:
    """Of a process that finds this actspec, whatever folder it runs in."""
    paths = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    return {**os.environ, "PYTHONPATH": paths, "PYTHONUNBUFFERED": "1", "NO_COLOR": "1"}


def _commands(text: str) -> list[str]:
    """Lines that call actspec, without prompt, continuation and what follows the command."""
    joined = text.replace("\\\n", " ")
    lines = [line.strip().removeprefix("$ ") for line in joined.splitlines()]
    parts = [part.strip() for line in lines for part in re.split(r"&&|[;|>]", line)]
    return [p for p in (part.removeprefix(".venv/bin/") for part in parts) if p.startswith("actspec ")]


COMMANDS = [
    pytest.param(command, id=f"{b.id}-{command}")
    for b in _of("sh", "console")
    for command in dict.fromkeys(_commands(b.text))
]


@pytest.mark.slow
@pytest.mark.parametrize("command", COMMANDS)
def test_commands_are_understood(command: str) -> None:
    """Every actspec command on a page is one that the real parser takes."""
    arguments = shlex.split(command, comments=True)[1:]
    if arguments in (["--version"], ["--help"]):
        return
    assert parser(arguments[0]).parse_args(arguments).command


@pytest.fixture(scope="module")
def served() -> Iterator[str]:
    """An `actspec` for PATH."""
    if not sys.platform.startswith("linux"):
        yield f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m actspec "$@"\n'
        return
    with server(_environment()) as address:
        yield client(address)


@pytest.fixture
def shims(folder: Path, served: str) -> dict[str, str]:
    """An environment in which `actspec` and `pytest` are these."""
    bin_ = folder / "bin"
    bin_.mkdir()
    tested = f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m pytest "$@"\n'
    for command, text in (("actspec", served), ("pytest", tested)):
        shim = bin_ / command
        shim.write_text(text)
        shim.chmod(shim.stat().st_mode | stat.S_IXUSR)
    return {**_environment(), "PATH": f"{bin_}{os.pathsep}{os.environ['PATH']}"}


@pytest.mark.slow
@pytest.mark.parametrize(
    "page", [p for p in PAGES if any(b.page == p for b in _of("console"))], ids=lambda p: p.name
)
def test_consoles_show_real_output(page: Path, folder: Path, shims: dict[str, str]) -> None:
    """The console blocks of a page, run in their order in a shell, print what the page shows."""
    for block in (b for b in _of("console") if b.page == page):
        shown: list[tuple[str, list[str]]] = []
        for line in block.text.splitlines():
            if line.startswith("$ "):
                shown.append((line[2:], []))
            else:
                shown[-1][1].append(line)
        _prepare(block, folder)
        for command, lines in shown:
            done = subprocess.run(
                ["bash", "-c", command],
                cwd=folder,
                env=shims,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                check=False,
            )
            within = float(block.attributes.get("data-within", "0"))
            assert _prints(lines, done.stdout, within), f"{block.id}: $ {command}\n{done.stdout}"


DECIMAL = re.compile(r"(?<![\w.])-?\d+\.\d+(?:e-?\d+)?")


def _prints(lines: list[str], output: str, within: float) -> bool:
    """Whether an output is these lines, `...` being any; decimal numbers may be off by a share of them."""
    told: list[float] = []
    if within:
        told = [float(number) for line in lines for number in DECIMAL.findall(line)]
        # Columns are as wide as their numbers.
        lines = [re.sub(r"(?<=\S) +", " ", DECIMAL.sub("\0", line)) for line in lines]
        output = re.sub(r"(?<=\S) +", " ", output)
    number = f"({DECIMAL.pattern})"
    parts = [
        ".*" if line.strip() == "..." else number.join(map(re.escape, f"{line}\n".split("\0")))
        for line in lines
    ]
    found = re.fullmatch("".join(parts), output, re.DOTALL)
    return found is not None and all(
        abs(float(had) - asked) <= within * abs(asked)
        for had, asked in zip(found.groups(), told, strict=True)
    )


def _compiled(block: Block, folder: Path, otherwise: str = "") -> dict[str, str]:
    """The files that a block's spec compiles to, by path: the spec that it names, else the one above it."""
    spec = block.attributes.get("data-spec", "spec.yaml")
    if spec == "spec.yaml":
        above = [b for b in _before(block) if b.language == "yaml" and not b.attributes]
        source = next(b for b in reversed(above) if not b.file or "actspec: 1" in b.text)
        _prepare(source, folder)
        (folder / spec).write_text(yaml.safe_dump(_spec_data(source), sort_keys=False))
    target = block.attributes.get("data-target", otherwise)
    done = api.compile(spec, output="out", targets=[target] if target else [])
    found: dict[str, str] = {}
    for file in (file for emission in done.emissions for file in emission.files):
        assert file.path not in found, f"{block.id}: two targets write {file.path}: name one as data-target"
        found[file.path] = file.data.decode("utf-8")
    return found


@pytest.mark.slow
@pytest.mark.parametrize("block", SHOWN, ids=lambda b: b.id)
def test_shown_files_are_what_is_compiled(block: Block, folder: Path) -> None:
    """Lines of a compiled file stand in it as the page shows them, without a gap that is not marked."""
    text = _compiled(block, folder)[block.title]
    lines = block.text.splitlines()
    pattern = "".join("(?s:.*?)" if line.strip() == "..." else re.escape(line + "\n") for line in lines)
    assert re.search(f"(?m)^{pattern}", text), text


LAYOUT = {"isaaclab": ("line-length=120",), "mjlab": ("line-length=88", "indent-width=2")}
"""How each framework formats its own code."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "block",
    [b for b in SHOWN if b.language == "python" and b.page.stem == "generated-text"],
    ids=lambda b: b.id,
)
def test_generated_python_is_formatted_as_its_framework_s(block: Block, folder: Path) -> None:
    """The formatter of a framework's own code has nothing to change in what is written for it."""
    ruff = shutil.which("ruff", path=os.path.dirname(sys.executable))
    if ruff is None:
        pytest.skip("ruff is not installed")
    kind = block.attributes["data-target"].partition("==")[0]
    (folder / "shown.py").write_text(_compiled(block, folder)[block.title])
    options = [part for option in LAYOUT[kind] for part in ("--config", option)]
    command = [ruff, "format", "--isolated", *options, "--diff", "shown.py"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


def _beside(block: Block, folder: Path) -> None:
    """Write the module that a block needs into the folder that it runs in."""
    for name, text in _compiled(block, folder, block.attributes["data-needs"]).items():
        (folder / name).write_text(text)


@pytest.mark.parametrize("block", NEEDING, ids=lambda b: b.id)
def test_snippets_for_a_framework_fit_the_module(block: Block, folder: Path) -> None:
    """What a snippet takes from the compiled module, or from actspec, is there."""
    _beside(block, folder)
    for node in ast.walk(ast.parse(block.text)):
        if not isinstance(node, ast.ImportFrom) or node.module is None:
            continue
        source = folder / f"{node.module}.py"
        if node.module.partition(".")[0] == "actspec":
            source = ROOT / f"{node.module.replace('.', '/')}.py"
        elif not source.is_file():
            continue
        names = _top_level(source.read_text(encoding="utf-8"))
        assert {alias.name for alias in node.names} <= names, node.module


def _top_level(text: str) -> set[str]:
    found: set[str] = set()
    for node in ast.parse(text).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            found.add(node.name)
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        found |= {target.id for target in targets if isinstance(target, ast.Name)}
    return found


@pytest.fixture(scope="module")
def mjlab() -> Iterator[Forker]:
    """A process that has imported the real package."""
    try:
        frameworks = prepare()
    except EngineUnavailableError as err:
        (pytest.fail if os.environ.get("CI") else pytest.skip)(f"no frameworks: {err}")
    more = {"PYTHONPATH": "", "MUJOCO_GL": "disabled"}
    more["WARP_CACHE_PATH"] = str(frameworks.folder / "warp")
    # Elsewhere a process that has PyTorch may not fork: it imports what it needs.
    packages = MJLAB if sys.platform.startswith("linux") else ()
    forker = Forker(str(frameworks.python()), packages, {**os.environ, **more})
    yield forker
    forker.end()


@pytest.mark.slow
@pytest.mark.engine
@pytest.mark.parametrize(
    "block", [b for b in NEEDING if b.attributes["data-needs"] == "mjlab"], ids=lambda b: b.id
)
def test_snippets_for_mjlab_run_in_it(block: Block, folder: Path, mjlab: Forker) -> None:
    """A snippet for mjlab prints in the real package what the page says."""
    _beside(block, folder)
    # Behind the framework's own packages, which have another MuJoCo.
    paths = [str(ROOT), sysconfig.get_paths()["purelib"]]
    (folder / "snippet.py").write_text(f"import sys\nsys.path += {paths!r}\n{block.text}")
    done = mjlab.run(["python", str(folder / "snippet.py")], str(folder), mjlab.environment, 600.0)
    assert done.returncode == 0, done.stderr
    asked = [line.partition("  # ")[2] for line in block.text.splitlines() if line.startswith("print(")]
    assert done.stdout.splitlines()[-len(asked) :] == asked


@pytest.mark.parametrize("block", [b for b in PROJECT if b.language == "toml"], ids=lambda b: b.id)
def test_settings_are_taken(block: Block, folder: Path) -> None:
    """Settings of a page are without an error, and say something."""
    (folder / block.title).write_text(block.text)
    assert load_settings(all_rules(), block.title) != Settings()


@pytest.mark.parametrize(
    "block", [b for b in PROJECT if b.title == ".pre-commit-config.yaml"], ids=lambda b: b.id
)
def test_hooks_of_a_page_are_there(block: Block, folder: Path) -> None:
    """pre-commit takes a page's configuration, and actspec what its hooks are called with."""
    (folder / block.title).write_text(block.text)
    clientlib = pytest.importorskip("pre_commit.clientlib")
    assert clientlib.load_config(block.title)
    # pre-commit warns of a branch; and who pastes a commit finds it in the clone.
    (rev,) = (repo["rev"] for repo in yaml.safe_load(block.text)["repos"])
    assert re.fullmatch("[0-9a-f]{40}", rev)
    history = subprocess.run(
        ["git", "rev-list", "HEAD"], cwd=ROOT, capture_output=True, text=True, check=False
    )
    shallow = (ROOT / ".git" / "shallow").exists()
    assert history.returncode or shallow or rev in history.stdout.split()
    known = {hook["id"]: hook for hook in yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text())}
    for hook in (hook for repo in yaml.safe_load(block.text)["repos"] for hook in repo["hooks"]):
        called = {**known[hook["id"]], **hook}
        names = ["-x.xml"] if called.get("pass_filenames", True) else []
        assert (
            parser().parse_args([*shlex.split(called["entry"])[1:], *called.get("args", []), *names]).command
        )


WORKFLOWS = [b for b in PROJECT if b.title.startswith((".github/workflows/", ".gitlab-ci"))]


@pytest.mark.slow
@pytest.mark.parametrize("block", WORKFLOWS, ids=lambda b: b.id)
def test_workflows_run(block: Block, folder: Path, shims: dict[str, str]) -> None:
    """The steps that call actspec, run in a shell on the example, find what is wrong with it and write their files."""
    shutil.copytree(ROOT / "docs" / "example", folder / "example")
    (job,) = yaml.safe_load(block.text).get("jobs", {0: yaml.safe_load(block.text).get("audit")}).values()
    lines = job["script"] if "script" in job else [step.get("run", "") for step in job["steps"]]
    env = {**shims, "GITHUB_STEP_SUMMARY": "summary.md"}
    codes = {
        line: subprocess.run(
            ["bash", "-c", line.replace("audit robots", "audit example")],
            cwd=folder,
            env=env,
            capture_output=True,
            check=False,
        ).returncode
        for line in lines
        if _commands(line)
    }
    # Two of them leave the verdict to somebody else.
    assert codes == {line: int("--fail-on" in line) for line in codes} and codes
    for line in codes:
        for name in re.findall(r"(?<= -o )\S+", line) + ["summary.md"] * ("SUMMARY" in line):
            assert b"biped" in (folder / name).read_bytes()


CHECKS = ["CLI", "DEP", "DMP", "FRC", "ISL", "MJC", "MJL", "NET", "NWT", "OUT", "RND", "RTP", "STB", "URD"]
"""Families of docs/checks.md."""
AUDIT = ["ACT", "AUD", "CFG", "DEPLOY"]
"""Families of docs/audit.md."""
SYSID = ["LOG", "SYS"]
LEARN = ("LRN",)
COMPARE, DIAGNOSE, ABLATE = ("CMP",), ("DGN", "RPT"), ("ABL",)
"""Families of docs/sysid.md, networks.md, compare.md, diagnose.md and ablate.md."""
RULES = {rule.code for rule in all_rules()}
FORMER = {code for rule in all_rules() for code in rule.aliases} - RULES


@cache
def _sources() -> str:
    return "".join(path.read_text(encoding="utf-8") for path in (ROOT / "actspec").rglob("*.py"))


@pytest.mark.slow
@pytest.mark.parametrize("family", [*CHECKS, *AUDIT, *SYSID, *LEARN, *COMPARE, *DIAGNOSE, *ABLATE])
def test_every_check_has_its_line(family: str) -> None:
    """docs/checks.md, for the audit docs/audit.md, names exactly the codes that the source gives and no rule has."""
    given = set(re.findall(rf'"({family}\d{{3}})"', _sources())) - RULES - FORMER
    pages = ((AUDIT, "audit.md"), (SYSID, "sysid.md"), (LEARN, "networks.md"), (LEARN, "delta-action.md"))
    pages += ((COMPARE, "compare.md"), (DIAGNOSE, "diagnose.md"), (ABLATE, "ablate.md"))
    names = [page for families, page in pages if family in families] or ["checks.md"]
    page = "\n".join((ROOT / "docs" / name).read_text(encoding="utf-8") for name in names)
    # As an entry, a heading or the first cell of a row: a code that a sentence mentions is not explained by it.
    entries = re.findall(rf"^(?:## |\| )({family}\d{{3}})\b", page, re.MULTILINE)
    assert sorted(entries) == sorted(given)


def test_every_rule_has_its_page() -> None:
    """Codes of the audit's rules are explained beside the rules, and there alone."""
    pages = (ROOT / "actspec" / "audit" / "rules").glob("*[0-9].md")
    assert {path.stem.upper() for path in pages} == RULES


def _rows(page: str, start: str) -> list[list[str]]:
    """Cells of the rows of a page whose first cell begins so."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if re.match(rf"\| {start}", line)]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def test_isaaclab_versions_are_the_capability_rows() -> None:
    """The table of docs/isaaclab-target.md is what the versions' rows say, for every combination."""
    friction = {
        FrictionUnit.EFFORT: "N·m",
        FrictionUnit.EFFORT_ONE: "N·m, one number",
        FrictionUnit.COEFFICIENT: "coefficient: left out",
        FrictionUnit.COEFFICIENT_VISCOUS: "coefficient: left out",
        FrictionUnit.DEAD: "not written by it: left out",
    }
    rows = []
    for release, row in ISAACLAB_RELEASES.items():
        for sim in row.sims:
            for backend in ("PhysX", "Newton", "OVPhysX") if row.native else ("PhysX",):
                d = isaaclab_dialect(f"{release[0]}.{release[1]}", f"{sim[0]}.{sim[1]}", backend.lower())
                cells = [
                    d.text,
                    d.sim_text,
                    d.backend_text,
                    ", ".join(f"`{name}`" for name in (d.limits.effort, d.limits.solver_effort)),
                    friction[d.friction],
                    "`viscous_friction`" if d.viscous else "in `damping`",
                    "four quadrants" if d.four_quadrants else "two: approximation",
                    "dict" if d.dict_saturation else "one a group",
                    "drawn at reset" if d.lag_range else "fixed",
                    "yes" if d.custom else "no",
                    "yes" if d.executed else "no",
                ]
                rows.append(cells)
    merged: list[list[str]] = []
    for row in sorted(rows, key=lambda r: (r[0], r[2] != "PhysX", r[2], r[1])):
        if merged and merged[-1][:1] + merged[-1][2:] == row[:1] + row[2:]:
            merged[-1][1] += f", {row[1]}"
        else:
            merged.append(row)
    assert _rows("isaaclab-target.md", r"\d\.\d \|") == merged


def test_mjlab_versions_are_the_capability_rows() -> None:
    """The table of docs/mjlab-target.md is what the versions' rows say."""
    rows = []
    for release in MJLAB_RELEASES:
        d = mjlab_dialect(f"{release[0]}.{release[1]}")
        rows.append(
            [
                d.text,
                d.mujoco,
                "`delay_*` of each cfg" if d.delay_fields else "`DelayedActuatorCfg` round a cfg",
                "the model's" if d.keeps_model else "written out",
                "`viscous_damping`" if d.viscous_damping else "the model's: approximation",
                "yes" if d.run else "no",
            ]
        )
    assert _rows("mjlab-target.md", r"\d\.\d \|") == rows


def test_newton_versions_are_the_capability_rows() -> None:
    """The table of docs/newton-target.md is what the versions' rows say."""
    rows = []
    for release in NEWTON_RELEASES:
        d = newton_dialect(f"{release[0]}.{release[1]}")
        joint = "read" if d.joint_damping else "not read: approximations"
        rows.append([d.text, "read", joint, "ONNX" if d.networks else "none", "yes" if d.run else "no"])
    page = _rows("newton-target.md", r"\d\.\d \|")
    # Of a version without networks the first row says why.
    assert [[*row[:3], row[3].partition(":")[0], row[4]] for row in page] == rows
