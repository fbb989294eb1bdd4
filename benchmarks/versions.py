"""The wheel, not the checkout, on pairs of Python and MuJoCo, and with the lowest versions of pyproject.toml.

Each pair has an environment of its own, into which the wheel is installed. There the A1 is compiled for the MuJoCo
that is there, which the spec does not name; that MuJoCo loads what was written; it is audited and verified; and all
targets of the spec as it is are compiled. Prints a table in Markdown. Exit code 1: a step of a pair failed.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import tomllib

ROOT = Path(__file__).resolve().parents[1]
MUJOCO = ("3.7.0", "3.11.0", "3.17.0", "4.0.0")

LOADS = (
    "import mujoco; m = mujoco.MjModel.from_xml_path('{}/mujoco/a1.xml'); assert m.nu == 12 and m.njnt == 13"
)
"""The A1: 12 drives, and a base that moves."""

SAYS = "MJC032"
"""What a compile says where the version that nobody stated is newer than what is installed."""


def steps(release: str) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """What a pair has to do, each with exit code 0.

    Args:
        release: Of the MuJoCo that is installed, as `3.17`.
    """
    return (
        ("compiles", ("actspec", "compile", "robots/own.yaml", "-t", "mujoco", "-o", "out")),
        ("loads", ("python", "-c", LOADS.format("out"))),
        (
            "compiles, stated",
            ("actspec", "compile", "robots/own.yaml", "-t", f"mujoco=={release}", "-o", "at"),
        ),
        ("loads, stated", ("python", "-c", LOADS.format("at"))),
        ("audits", ("actspec", "audit", "at/mujoco/a1.xml", "--fail-on", "error")),
        ("verifies", ("actspec", "verify", "robots/own.yaml", "-t", f"mujoco=={release}")),
        ("all targets", ("actspec", "compile", "robots/a1.yaml", "-o", "all")),
        ("is stale", ("actspec", "compile", "robots/a1.yaml", "-o", "all", "--check")),
    )


def lowest() -> tuple[str, ...]:
    """The least versions of what actspec depends on."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    bounds = (re.match(r"([\w-]+)>=([\d.]+)", line) for line in project["dependencies"])
    return tuple(f"{bound[1]}=={bound[2]}" for bound in bounds if bound and bound[1] != "tomli")


def tried(python: str, pins: Sequence[str], wheel: Path, work: Path) -> tuple[str, str, list[str]]:
    """One pair.

    Args:
        python: The interpreter.
        pins: Requirements beside the wheel.
        work: An empty folder.

    Returns: The steps that failed, in words; what the compile told; and the lines that tell why.
    """
    env = {name: text for name, text in os.environ.items() if not name.startswith("PYTHON")}
    scripts = work / "venv" / "bin"
    env["PATH"] = f"{scripts}{os.pathsep}{env['PATH']}"
    shutil.copytree(ROOT / "robots", work / "robots")
    spec = (work / "robots" / "a1.yaml").read_text("utf-8")
    own, found = re.subn(r'mujoco: \{version: "[\d.]+"\}', "mujoco: {}", spec)
    assert found == 1
    (work / "robots" / "own.yaml").write_text(own, "utf-8")

    def call(command: Sequence[str]) -> tuple[int, str]:
        done = subprocess.run(command, cwd=work, env=env, capture_output=True, text=True, timeout=900)
        return done.returncode, done.stdout + done.stderr

    pip = (str(scripts / "python"), "-m", "pip", "install", "--quiet", "--only-binary", ":all:")
    for name, command in (
        ("no environment", (python, "-m", "venv", "venv")),
        ("not installed", (*pip, str(wheel), *pins)),
    ):
        code, said = call(command)
        if code:
            needs = re.search(r"Requires-Python (\S+)", said)
            none = re.search(r"No matching distribution found for (\S+)", said)
            if none:
                return "", f"no such pair: {f'Python {needs[1]}' if needs else f'no wheel of {none[1]}'}", []
            return name, "", said.strip().splitlines()[-1:]
    _, said = call((str(scripts / "python"), "-c", _VERSIONS))
    failed, why, told = [], [said.strip()], ""
    release = ".".join(said.split()[1].split(".")[:2])
    for name, command in steps(release):
        code, said = call((str(scripts / command[0]), *command[1:]))
        if name == "compiles" and SAYS in said:
            told = SAYS
        elif code and not (name == "loads" and told):
            failed.append(name)
            why += [f"{name}: {line}" for line in said.strip().splitlines()[-3:]]
    return ", ".join(failed), told, why


_VERSIONS = """
from importlib.metadata import version
print(", ".join(f"{n} {version(n)}" for n in "mujoco numpy pydantic lxml pyyaml jinja2".split()))
"""


def main() -> int:
    """Measure, and print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--python", action="append", required=True, help="an interpreter; may be repeated")
    parser.add_argument("--mujoco", action="append", help=f"default: {', '.join(MUJOCO)}")
    parser.add_argument("--no-lowest", action="store_true", help="leave out the lowest versions")
    arguments = parser.parse_args()
    columns: dict[str, tuple[str, ...]] = {
        version: (f"mujoco=={version}",) for version in arguments.mujoco or MUJOCO
    }
    if not arguments.no_lowest:
        columns["lowest"] = lowest()
    print(f"| Python | {' | '.join(columns)} |\n|---|{'---|' * len(columns)}", flush=True)
    bad = False
    with tempfile.TemporaryDirectory() as folder:
        pip = [sys.executable, "-m", "pip", "wheel", "--quiet", "--no-deps", "-w", folder, str(ROOT)]
        subprocess.run(pip, check=True, stdout=sys.stderr)
        (wheel,) = Path(folder).glob("actspec-*.whl")
        for python in arguments.python:
            code = "import platform; print(platform.python_version())"
            release = subprocess.run([python, "-c", code], capture_output=True, text=True, check=True).stdout
            cells = []
            for pins in columns.values():
                work = Path(tempfile.mkdtemp(dir=folder))
                failed, told, why = tried(python, pins, wheel, work)
                cells.append(failed or (told if told.startswith("no") else f"yes, {told}".removesuffix(", ")))
                bad |= bool(failed)
                print(f"{release.strip()} {' '.join(pins)}: {'; '.join(why)}", file=sys.stderr, flush=True)
                shutil.rmtree(work)
            print(f"| {release.strip()} | {' | '.join(cells)} |", flush=True)
    return bad


if __name__ == "__main__":
    sys.exit(main())
