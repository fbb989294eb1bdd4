"""Which module may import which, and what starting actspec must not load."""

from __future__ import annotations

import ast
import subprocess
import sys
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "actspec"

LAYERS = (
    {
        "units",
        "diagnostics",
        "guest",
        "resources",
        "files",
        "libraries",
        "owned",
        "patterns",
        "placing",
        "processes",
    },
    {"joints"},
    {"fields"},
    {"poses"},
    {"ir", "simulators"},
    {"laws"},
    {"simulate"},
    {"spec", "robot"},
    {"readings", "logs"},
    {"resolution", "lift"},
    {"targets", "audit", "sysid", "learn", "sampling"},
    {"draft", "verify", "output", "study"},
    {"report"},
    {"api", "recorder", "runtime"},
    {"live"},
    {"mjlab", "isaaclab", "testing"},
    {"cli", "__main__", ""},
)
"""Lowest first. A part imports lower layers, and its own as long as the parts form no circle. "" is `actspec`
itself, whose names are loaded on demand."""

RANK = {part: rank for rank, layer in enumerate(LAYERS) for part in layer}

HEAVY = {"mujoco", "torch", "scipy", "yourdfpy", "pxr", "matplotlib"}

FORBIDDEN = {"ir": HEAVY, "laws": HEAVY, "audit.rules": HEAVY}
"""What a part imports nowhere, functions included: these take what they are given."""


def modules() -> dict[str, Path]:
    """File of every module of the package by its name below `actspec`; "" is the package itself."""
    found = {}
    for path in sorted(PACKAGE.rglob("*.py")):
        parts = path.relative_to(PACKAGE).with_suffix("").parts
        # Probes are no modules: they run in the simulators' environments.
        if parts[0] != "_data" and parts[:2] != ("verify", "probes"):
            name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
            found[name] = path
    return found


MODULES = modules()


@cache
def imports(name: str) -> list[tuple[int, str]]:
    """Line and full name of everything a module imports anywhere, relative imports made absolute."""
    is_package = name == "" or any(other.startswith(name + ".") for other in MODULES)
    here = ["actspec", *name.split(".")] if name else ["actspec"]
    package = here if is_package else here[:-1]
    found = []
    path = MODULES[name]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"), str(path))):
        if isinstance(node, ast.Import):
            found += [(node.lineno, alias.name) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            source = ".".join([*base, *([node.module] if node.module else [])])
            for alias in node.names:
                inner = f"{source}.{alias.name}"
                # `from actspec import ir` names a module, `from actspec.ir import Quantity` does not.
                own_module = inner.removeprefix("actspec.") in MODULES
                found.append((node.lineno, inner if own_module else source))
    return found


def part(name: str) -> str:
    """The layer entry that a module belongs to: the first component below `actspec`."""
    return name.split(".")[0]


def own(name: str) -> str | None:
    """A module of ours by its name below `actspec`; None for anybody else's."""
    if name == "actspec":
        return ""
    return name.removeprefix("actspec.") if name.startswith("actspec.") else None


@pytest.mark.slow
@pytest.mark.parametrize("name", MODULES, ids=lambda name: name or "actspec")
def test_imports_point_down(name: str) -> None:
    """A module imports only its own layer and lower ones, wherever in the file the import stands."""
    assert part(name) in RANK, f"actspec/{part(name)} is in no layer: give it one in LAYERS"
    wrong = []
    for line, target in imports(name):
        mine = own(target)
        # The version is all that lower layers may take from the package itself.
        if mine and RANK.get(part(mine), len(LAYERS)) > RANK[part(name)]:
            wrong.append(f"line {line}: {target}")
    assert not wrong


@pytest.mark.slow
def test_parts_form_no_circle() -> None:
    """Parts of one layer may use each other in one direction only."""
    graph: dict[str, set[str]] = {}
    for name in MODULES:
        targets = (own(target) for _, target in imports(name))
        graph.setdefault(part(name), set()).update(part(t) for t in targets if t and part(t) != part(name))
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as err:
        pytest.fail(" → ".join(err.args[1]))


@pytest.mark.parametrize("where", FORBIDDEN)
def test_pure_parts_import_no_engine(where: str) -> None:
    """`ir`, `laws` and the audit's rules never import an engine, not even inside a function."""
    mine = [name for name in MODULES if name == where or name.startswith(where + ".")]
    if not mine:
        pytest.skip(f"no actspec.{where} yet")
    wrong = [
        f"{name}:{line}: {target}"
        for name in mine
        for line, target in imports(name)
        if target.split(".")[0] in FORBIDDEN[where]
    ]
    assert not wrong


@pytest.mark.slow
@pytest.mark.parametrize(
    ("library", "home"), [("torch", "learn"), ("pxr", "robot.usda"), ("yourdfpy", "verify.engines.yourdfpy")]
)
def test_a_library_stays_in_one_place(library: str, home: str) -> None:
    """Everybody else takes the arrays or views that they are given."""
    wrong = [
        f"{name}:{line}"
        for name in MODULES
        if name != home and not name.startswith(home + ".")
        for line, target in imports(name)
        if target.split(".")[0] == library
    ]
    assert not wrong


STARTS = {
    "actspec": ("", "import actspec"),
    "cli": ("cli.main", "import actspec.cli.main"),
    "ir": ("ir", "import actspec.ir"),
    "laws": ("laws", "import actspec.laws"),
    "validate": (
        "cli.main",
        "import sys\nfrom actspec.cli.main import main\ntry:\n    code = main(['validate', SPEC])\n"
        "except SystemExit as stop:\n    code = stop.code\nassert not code, code",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("needs, code", STARTS.values(), ids=STARTS)
def test_start_is_light(needs: str, code: str, tmp_path: Path) -> None:
    """Starting actspec and validating a spec load no engine and no plotting, fitting or learning library."""
    if needs not in MODULES:
        pytest.skip(f"no actspec.{needs} yet")
    spec = next(iter(sorted((ROOT / "robots").glob("*.yaml"))), None)
    if "SPEC" in code and spec is None:
        pytest.skip("no spec in robots/ yet")
    script = code.replace("SPEC", repr(str(spec)))
    script += f"\nimport sys\nprint('loaded', *sorted({HEAVY!r} & set(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", script],
        check=False,
        cwd=tmp_path,
        env={"PYTHONPATH": str(ROOT), "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr + done.stdout
    assert done.stdout.splitlines()[-1].split() == ["loaded"]
