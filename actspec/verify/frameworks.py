"""The real frameworks that actspec writes for, in one environment of their own.

    frameworks = prepare()
    said, arrays = frameworks.run_probe(Path("probe.py"), {"text": text}, {"q": q})

The environment is made once, in a folder named after what is in it, and holds mjlab and Newton with what
they need, and wheels unpacked beside them: Isaac Lab's, whose package cannot be imported from where it is installed,
because its first line looks for a simulator that needs a GPU, and older Newtons.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
import sysconfig
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from actspec.simulators import isaaclab, newton
from actspec.verify.probing import ProbeAnswer, run_probe
from actspec.verify.releases import EngineUnavailableError, cache_folder, pip, quiet, run, whole

HERE = Path(__file__).parent
REQUIREMENTS = HERE / "requirements.txt"
BARE = HERE / "requirements-bare.txt"
CONTENTS = "contents.txt"
"""File of an environment that lists what was asked for."""

ISAACLAB = tuple(row.wheel for row in isaaclab.RELEASES.values() if row.wheel)
"""Isaac Lab's releases, oldest first: the least and the newest that the registry has, but for 2.3.0 and 2.3.1."""
ISAACLAB_WHEEL = ("--python-version", "3.11", "--platform", "manylinux_2_35_x86_64", "--only-binary=:all:")
"""The one wheel there is; it holds Python text alone, and runs elsewhere too."""

NEWTON = tuple(package for package in newton.RELEASES.values() if package)[:-1]
"""Older releases of Newton, beside the one that is installed."""

UNPACKED = (("isaaclab", ISAACLAB, ISAACLAB_WHEEL), ("newton", NEWTON, ()))
"""Releases that lie beside the environment: distribution, versions, options of pip."""

PYTHONS = ((3, 11), (3, 13))
"""Oldest and newest Python that all of them run on."""

SIZE = "2.4 GB"
"""On the disk. Source: measured on Linux with the torch that computes on the processor alone."""
TIME = "three to ten minutes"
"""To install. Source: measured on two cores: three to four, with other work on the machine up to ten."""

TIMEOUT = 1800
"""Seconds for one step of the installation."""


@dataclass(frozen=True, slots=True)
class Frameworks:
    """A prepared environment.

    Attributes:
        folder: Where it lies.
    """

    folder: Path

    def python(self) -> Path:
        """Its interpreter, in which torch, mujoco 3.11, mujoco-warp, mjlab and newton can be imported."""
        scripts = "Scripts" if os.name == "nt" else "bin"
        return self.folder / "venv" / scripts / "python"

    def isaaclab(self, version: str) -> Path:
        """The folder whose `isaaclab` is the real package of a release, for sys.path."""
        return self.folder / f"isaaclab-{version}" / "isaaclab" / "source" / "isaaclab"

    def newton(self, version: str) -> Path:
        """The folder whose `newton` is that of an older release, for sys.path."""
        return self.folder / f"newton-{version}"

    def run_probe(
        self,
        script: Path,
        job: Mapping[str, Any],
        arrays: Mapping[str, Any] | None = None,
        *,
        timeout: float = 600,
    ) -> ProbeAnswer:
        """Run a script in the environment; see `actspec.verify.probing.run_probe`.

        Raises: EngineError: the script failed.
        """
        # Compiled kernels are kept: twenty seconds the first time.
        environment = {"PYTHONPATH": "", "WARP_CACHE_PATH": str(self.folder / "warp")}
        return run_probe(self.python(), script, job, arrays, environment=environment, timeout=timeout)


def requirements() -> list[str]:
    """What is installed with its dependencies."""
    return _lines(REQUIREMENTS)


def find(folder: Path | None = None) -> Frameworks | None:
    """An environment that is there and has everything, more perhaps; None: there is none.

    Args:
        folder: Where engines are kept; default `cache_folder()`.
    """
    own = _made(folder or cache_folder(), ())
    if own.is_dir():
        return Frameworks(own)
    asked = set(_contents(()))
    for other in sorted(own.parent.glob("frameworks-*/" + CONTENTS)):
        if asked <= set(_lines(other)):
            return Frameworks(other.parent)
    return None


def prepare(
    folder: Path | None = None, extra: Sequence[str] = (), say: Callable[[str], None] = quiet
) -> Frameworks:
    """Make the environment unless it is there already; minutes, the first time.

    Args:
        folder: Where to keep it; default `cache_folder()`.
        extra: Requirements beyond those of actspec's own.
        say: Told what is done next.

    Raises: EngineUnavailableError: a package cannot be had for this Python and platform.
    """
    got = _attempt(folder or cache_folder(), tuple(extra), say)
    if isinstance(got, str):
        raise EngineUnavailableError(got)
    return Frameworks(got)


def unusable() -> str | None:
    """Why this Python cannot run the frameworks; None: it can."""
    if PYTHONS[0] <= sys.version_info[:2] <= PYTHONS[1]:
        return None
    least, most = (".".join(map(str, version)) for version in PYTHONS)
    return (
        f"the frameworks run on Python {least} to {most}, this is {sys.version_info[0]}.{sys.version_info[1]}"
    )


def _lines(path: Path) -> list[str]:
    """Lines of a requirements file without remarks."""
    lines = (line.partition(" #")[0].strip() for line in path.read_text(encoding="utf-8").splitlines())
    return [line for line in lines if line and not line.startswith("#")]


def _contents(extra: Sequence[str]) -> list[str]:
    """What decides what an environment is."""
    platform = [sysconfig.get_platform(), str(sys.implementation.cache_tag)]
    unpacked = [f"{name}=={version}" for name, versions, _ in UNPACKED for version in versions]
    return [*requirements(), *extra, *_lines(BARE), *unpacked, *platform]


def _made(folder: Path, extra: Sequence[str]) -> Path:
    digest = hashlib.sha256("\n".join(_contents(extra)).encode("utf-8")).hexdigest()
    return folder / f"frameworks-{digest[:12]}"


@cache
def _attempt(folder: Path, extra: tuple[str, ...], say: Callable[[str], None]) -> Path | str:
    """The environment's folder, or why there is none: a registry that said no is not asked again."""
    why = unusable()
    if why is not None:
        return why
    return whole(_made(folder, extra), lambda made: _install(made, extra, say), say)


def _install(made: Path, extra: Sequence[str], say: Callable[[str], None]) -> None:
    made.mkdir()
    say("a virtual environment")
    run([sys.executable, "-m", "venv", str(made / "venv")], "a virtual environment", TIMEOUT)
    # By its path, because the commands of an environment that moves stay behind; `python -m` does not.
    command = pip(Frameworks(made).python())
    say("torch, MuJoCo, Newton: most of it")
    run([*command, "install", "-r", str(REQUIREMENTS), *extra], "torch, mujoco, warp", TIMEOUT)
    say("mjlab")
    run([*command, "install", "--no-deps", "-r", str(BARE)], "mjlab", TIMEOUT)
    for name, versions, options in UNPACKED:
        for version in versions:
            wheels = made / "wheels"
            say(f"{name} {version}")
            fetch = [*command, "download", "--no-deps", *options, "--dest", str(wheels)]
            run([*fetch, f"{name}=={version}"], f"{name} {version}", TIMEOUT)
            (wheel,) = wheels.glob("*.whl")
            with zipfile.ZipFile(wheel) as archive:
                archive.extractall(made / f"{name}-{version}")
            shutil.rmtree(wheels)
    (made / CONTENTS).write_text("\n".join(_contents(extra)) + "\n", encoding="utf-8")
