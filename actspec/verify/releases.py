"""Single releases, fetched by pip and unpacked: MuJoCo of a version beside the installed one.

    folder = prepare("mujoco", "3.11.0")      # to put on PYTHONPATH

What is unpacked is kept in one folder, and appears there whole or not at all.
"""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache
from pathlib import Path

TIMEOUT = 300
"""Seconds for one download."""


class EngineUnavailableError(Exception):
    """A release cannot be had here; the message says why."""


class EngineError(Exception):
    """A release refused the model or the job; the message is its own."""


def cache_folder() -> Path:
    """Where engines are kept: ACTSPEC_ENGINES, else `~/.cache/actspec/engines`."""
    return Path(os.environ.get("ACTSPEC_ENGINES") or Path.home() / ".cache" / "actspec" / "engines")


def release_folder(project: str, version: str, folder: Path | None = None) -> Path:
    """Where a release lies once it is prepared, for this Python and platform.

    Args:
        project: Name of the distribution.
        version: Its version.
        folder: Where releases are kept; default `cache_folder()`.
    """
    name = f"{project}-{version}-{sysconfig.get_platform()}-{sys.implementation.cache_tag}"
    return (folder or cache_folder()) / name


def quiet(text: str) -> None:
    """Nobody is told what is done."""


def prepare(
    project: str, version: str, folder: Path | None = None, say: Callable[[str], None] = quiet
) -> Path:
    """Fetch and unpack a release, without what it depends on, unless it is there already.

    Args:
        project: Name of the distribution.
        version: Its version.
        folder: Where to keep it; default `cache_folder()`.
        say: Told what is done next.

    Returns: The folder to put on PYTHONPATH.
    Raises: EngineUnavailableError: no wheel for this Python and platform, or no registry.
    """
    got = _attempt(project, version, folder or cache_folder(), say)
    if isinstance(got, str):
        raise EngineUnavailableError(got)
    return got


@cache
def _attempt(project: str, version: str, folder: Path, say: Callable[[str], None]) -> Path | str:
    """The unpacked release, or why there is none: a registry that said no is not asked again."""

    def make(made: Path) -> None:
        say(f"{project} {version}")
        _unpack(project, version, made)

    return whole(release_folder(project, version, folder), make, say)


def whole(made: Path, make: Callable[[Path], None], say: Callable[[str], None]) -> Path | str:
    """A folder that appears whole or not at all, whoever else wants it at the same time; or why it cannot be had.

    Args:
        made: The folder.
        make: Makes it, at another place.
        say: Told what is done next.
    """
    if made.is_dir():
        return made
    try:
        made.parent.mkdir(parents=True, exist_ok=True)
        with _locked(made.parent / f"{made.name}.lock", say):
            if not made.is_dir():
                if os.name == "posix":
                    # What a killed run has left: who holds the lock is alone.
                    for left in made.parent.glob(f".{made.name}-*"):
                        shutil.rmtree(left, ignore_errors=True)
                work = Path(tempfile.mkdtemp(prefix=f".{made.name}-", dir=made.parent))
                try:
                    make(work / "made")
                    # The rename is the sign that it is whole: a killed run leaves only the work folder.
                    (work / "made").rename(made)
                finally:
                    shutil.rmtree(work, ignore_errors=True)
    except EngineUnavailableError as err:
        return str(err)
    except OSError as err:
        return f"{made.parent}: {err.strerror or err}"
    return made


@contextmanager
def _locked(path: Path, say: Callable[[str], None]) -> Iterator[None]:
    """Hold a file's lock; the system lets go of it when the process dies."""
    with open(path, "w", encoding="utf-8") as file:
        if os.name == "posix":
            import fcntl

            try:
                fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                say("waiting for another actspec, which installs the same")
                fcntl.flock(file, fcntl.LOCK_EX)
        yield


def pip(python: str | Path) -> list[str]:
    """The command of an interpreter's pip, which asks nothing and says only what went wrong."""
    return [str(python), "-m", "pip", "--quiet", "--disable-pip-version-check", "--no-input"]


def run(command: Sequence[str], what: str, timeout: float) -> None:
    """Run a command of an installation.

    Args:
        command: Program and arguments.
        what: What is installed, for messages.
        timeout: [s].

    Raises: EngineUnavailableError: it failed, with the last error that it told.
    """
    try:
        done = subprocess.run(
            command,
            check=False,
            capture_output=True,
            text=True,
            timeout=timeout,
            stdin=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": ""},
        )
    except subprocess.TimeoutExpired as err:
        raise EngineUnavailableError(f"{what}: not done after {timeout:g} s") from err
    if done.returncode:
        last = ([line for line in done.stderr.splitlines() if line.startswith("ERROR")] or [done.stderr])[-1]
        raise EngineUnavailableError(f"{what}: {last.strip()[:300]}")


def _unpack(project: str, version: str, made: Path) -> None:
    wheels = made.parent / project
    command = [*pip(sys.executable), "download", "--no-deps", "--only-binary=:all:", "--dest", str(wheels)]
    run([*command, f"{project}=={version}"], f"{project} {version}", TIMEOUT)
    found = sorted(wheels.glob("*.whl"))
    if not found:
        raise EngineUnavailableError(f"{project} {version}: pip left no wheel")
    with zipfile.ZipFile(found[0]) as wheel:
        wheel.extractall(made)
        metadata = next(n for n in wheel.namelist() if n.endswith(".dist-info/METADATA"))
        header = wheel.read(metadata).decode("utf-8").split("\n\n", 1)[0]
    # From 4.0 the `mujoco` wheel is a shell: the engine is in mujoco-core.
    for core in re.findall(r"^Requires-Dist: mujoco-core==([\d.]+)", header, re.MULTILINE):
        _unpack("mujoco-core", core, made)
