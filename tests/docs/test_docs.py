"""What README and docs show is run: specs are compiled, Python is executed, commands give the printed output.

How a block is read:
- `yaml` with the key `actspec`: a whole spec. Any other is a fragment, laid over the example spec of
  docs/spec-language.md at the path of its first line (`# in actuators.legs`), or at the top. A first line that
  names a file (`# motors/drive.yaml`) makes it that file, for the blocks below it.
- `# gives CODE` in a spec: compiling it must give these diagnostics (information aside) and no other.
- `text` right after a spec: exactly those diagnostics, without their place.
- `xml` with `<mujoco`: leg.xml for the rest of its section. Else, after a spec: lines of the written model.
- `python`: executed; what each `print` line prints stands behind it as a comment.
- `console`: run by bash, in order; a line `...` stands for any lines.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import stat
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
import yaml

from actspec import api
from actspec.cli.main import parser
from actspec.diagnostics import ActspecError, Diagnostic, Severity
from actspec.spec.document import load_document
from actspec.spec.results import validate_results

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md")), ROOT / "benchmarks" / "README.md"]
LANGUAGE = ROOT / "docs" / "spec-language.md"


@dataclass(frozen=True)
class Block:
    """A fenced block of a page."""

    page: Path
    line: int
    section: int
    language: str
    text: str

    @property
    def id(self) -> str:
        """Where it stands."""
        return f"{self.page.name}:{self.line}"

    @property
    def file(self) -> str | None:
        """The file that it is, if its first line names one."""
        found = re.match(r"# ([\w./-]+\.(?:yaml|json))\n", self.text)
        return found[1] if found else None


def _blocks(page: Path) -> list[Block]:
    found: list[Block] = []
    section = 0
    fence: tuple[int, str] | None = None
    body: list[str] = []
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        if fence is None and line.startswith("#"):
            section += 1
        if not line.startswith("```"):
            body.append(line)
        elif fence is None:
            fence, body = (number, line[3:].strip()), []
        else:
            found.append(Block(page, fence[0], section, fence[1], "\n".join(body) + "\n"))
            fence = None
    assert fence is None, f"{page.name}: a fence is not closed"
    return found


BLOCKS = [block for page in PAGES for block in _blocks(page)]


def _of(*languages: str) -> list[Block]:
    return [block for block in BLOCKS if block.language in languages]


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


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working folder with the example robot and spec, and this repository's robots and schemas."""
    for name in ("robots", "schemas"):
        shutil.copytree(ROOT / name, tmp_path / name)
    (tmp_path / "leg.xml").write_text(_example("xml", "<mujoco").text)
    (tmp_path / "leg.yaml").write_text(_example("yaml", "actspec: 1").text)
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
    if following.language == "text":
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


@pytest.mark.parametrize("block", _of("python"), ids=lambda b: b.id)
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


@pytest.mark.parametrize("command", COMMANDS)
def test_commands_are_understood(command: str) -> None:
    """Every actspec command on a page is one that the real parser takes."""
    arguments = shlex.split(command, comments=True)[1:]
    if arguments in (["--version"], ["--help"]):
        return
    assert parser().parse_args(arguments).command


@pytest.mark.slow
@pytest.mark.parametrize(
    "page", [p for p in PAGES if any(b.page == p for b in _of("console"))], ids=lambda p: p.name
)
def test_consoles_show_real_output(page: Path, folder: Path) -> None:
    """The console blocks of a page, run in their order in a shell, print what the page shows."""
    bin_ = folder / "bin"
    bin_.mkdir()
    shim = bin_ / "actspec"
    shim.write_text(f'#!/bin/sh\nexec {shlex.quote(sys.executable)} -m actspec.cli.main "$@"\n')
    shim.chmod(shim.stat().st_mode | stat.S_IXUSR)
    env = {**_environment(), "PATH": f"{bin_}{os.pathsep}{os.environ['PATH']}"}
    for block in (b for b in _of("console") if b.page == page):
        shown: list[tuple[str, list[str]]] = []
        for line in block.text.splitlines():
            if line.startswith("$ "):
                shown.append((line[2:], []))
            else:
                shown[-1][1].append(line)
        for command, lines in shown:
            done = subprocess.run(
                ["bash", "-c", command],
                cwd=folder,
                env=env,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                check=False,
            )
            pattern = "".join(".*" if line.strip() == "..." else re.escape(line + "\n") for line in lines)
            assert re.fullmatch(pattern, done.stdout, re.DOTALL), f"{block.id}: $ {command}\n{done.stdout}"


@pytest.mark.parametrize("family", ["CLI", "DMP", "FRC", "MJC", "OUT", "RTP", "STB"])
def test_every_check_has_its_line(family: str) -> None:
    """docs/checks.md names exactly the codes of the checks that the source gives."""
    sources = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "actspec").rglob("*.py"))
    given = set(re.findall(rf'"({family}\d{{3}})"', sources))
    page = (ROOT / "docs" / "checks.md").read_text(encoding="utf-8")
    assert set(re.findall(rf"\b{family}\d{{3}}\b", page)) == given


@pytest.mark.parametrize("page", PAGES, ids=lambda p: str(p.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    """Every relative link and picture of a page is a file of the repository, every anchor a heading."""
    text = page.read_text(encoding="utf-8")
    links = re.findall(r"\]\(([^)\s]+)\)", text) + re.findall(r'(?:src|href)="([^"]+)"', text)
    for link in links:
        if re.match(r"[a-z]+:", link):
            continue
        path, _, anchor = link.partition("#")
        target = (page.parent / path).resolve() if path else page
        assert target.exists(), link
        if anchor:
            titles = re.findall(r"^#+ (.*)$", target.read_text(encoding="utf-8"), re.MULTILINE)
            slugs = [re.sub(r"[^\w\- ]", "", title.lower()).replace(" ", "-") for title in titles]
            assert anchor in slugs, link
