"""The real frameworks that actspec writes for, in one environment of their own.

    frameworks = prepare()
    said, arrays = frameworks.run_probe(Path("probe.py"), {"text": text}, {"q": q})

The environment (2.4 GB, most of it torch, warp and jaxlib) is made once, in a folder named after its pins, and
holds mjlab with what it needs, MJX, and Isaac Lab's wheels unpacked beside it: their package cannot be imported
from where it is installed, because its first line looks for a simulator that needs a GPU.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tests.agree.engines import EngineError, EngineUnavailableError, cache_folder, locked

HERE = Path(__file__).parent
CONSTRAINTS = HERE.parents[1] / "constraints.txt"
REQUIREMENTS = HERE / "requirements.txt"
BARE = HERE / "requirements-bare.txt"

ISAACLAB = ("2.2.0", "2.3.2.post1")
"""Isaac Lab's releases, oldest first: the least and the newest that the registry has, but for 2.3.0 and 2.3.1."""
ISAACLAB_WHEEL = ("--python-version", "3.11", "--platform", "manylinux_2_35_x86_64", "--only-binary=:all:")
"""The one wheel there is; it holds Python text alone, and runs elsewhere too."""

PYTHONS = ((3, 11), (3, 13))
"""Oldest and newest Python that all of them run on."""

INSTALL_TIMEOUT = 1800
PROBE_TIMEOUT = 600


class ProbeAnswer(NamedTuple):
    """What a probe wrote.

    Attributes:
        said: Its JSON.
        arrays: Its arrays by name.
    """

    said: dict[str, Any]
    arrays: dict[str, NDArray[Any]]


@dataclass(frozen=True, slots=True)
class Frameworks:
    """The prepared environment.

    Attributes:
        folder: Where it lies.
    """

    folder: Path

    def python(self) -> Path:
        """Its interpreter, in which torch, mujoco 3.11 with MJX, mujoco-warp and mjlab can be imported."""
        scripts = "Scripts" if os.name == "nt" else "bin"
        return self.folder / "venv" / scripts / "python"

    def isaaclab(self, version: str) -> Path:
        """The folder whose `isaaclab` is the real package of a release, for sys.path."""
        return self.folder / f"isaaclab-{version}" / "isaaclab" / "source" / "isaaclab"

    def run_probe(
        self,
        script: Path,
        job: Mapping[str, Any],
        arrays: Mapping[str, ArrayLike] | None = None,
        *,
        timeout: float = PROBE_TIMEOUT,
    ) -> ProbeAnswer:
        """Run a script in the environment: `python SCRIPT in.json in.npz out.json out.npz`, in a new folder.

        The script must write both outputs. It cannot import actspec or the tests.

        Args:
            script: The probe.
            job: Anything that JSON can hold.
            arrays: Input arrays by name.
            timeout: [s].

        Raises: EngineError: the script failed; the end of what it wrote to stderr is in the message.
        """
        # MuJoCo and warp leave files where they run: here, and they go with the folder.
        with tempfile.TemporaryDirectory(prefix="actspec-frameworks-") as name:
            work = Path(name)
            (work / "in.json").write_text(json.dumps(dict(job)), encoding="utf-8")
            np.savez(work / "in.npz", **{key: np.asarray(value) for key, value in (arrays or {}).items()})  # type: ignore[arg-type]
            environment = {
                **os.environ,
                "MUJOCO_GL": "disabled",
                "PYTHONPATH": "",
                "PYTHONNOUSERSITE": "1",
                "PYTHONDONTWRITEBYTECODE": "1",
                # Compiled kernels: twenty seconds the first time.
                "WARP_CACHE_PATH": str(self.folder / "warp"),
            }
            try:
                done = subprocess.run(
                    [str(self.python()), str(script.resolve()), "in.json", "in.npz", "out.json", "out.npz"],
                    check=False,
                    cwd=work,
                    env=environment,
                    capture_output=True,
                    text=True,
                    timeout=timeout,
                    stdin=subprocess.DEVNULL,
                )
            except subprocess.TimeoutExpired as err:
                raise EngineError(f"{script.name}: not done after {timeout:g} s") from err
            if done.returncode:
                raise EngineError(f"{script.name}: exit {done.returncode}: {done.stderr[-4000:]}")
            with np.load(work / "out.npz") as found:
                out = {key: found[key] for key in found.files}
            return ProbeAnswer(json.loads((work / "out.json").read_text(encoding="utf-8")), out)


def prepare(folder: Path | None = None) -> Frameworks:
    """Make the environment unless it is there already; minutes, the first time.

    Args:
        folder: Where to keep it; default that of the MuJoCo releases (`cache_folder`).

    Raises: EngineUnavailableError: a package cannot be had for this Python and platform.
    """
    got = _attempt(folder or cache_folder())
    if isinstance(got, str):
        raise EngineUnavailableError(got)
    return Frameworks(got)


def pins() -> str:
    """What decides the environment's contents, as a short hash."""
    torch = [
        line for line in CONSTRAINTS.read_text(encoding="utf-8").splitlines() if line.startswith("torch")
    ]
    parts = [*torch, REQUIREMENTS.read_text(encoding="utf-8"), BARE.read_text(encoding="utf-8"), *ISAACLAB]
    parts += [sysconfig.get_platform(), str(sys.implementation.cache_tag)]
    return hashlib.sha256("\n".join(parts).encode("utf-8")).hexdigest()[:12]


@cache
def _attempt(folder: Path) -> Path | str:
    """The environment's folder, or why there is none: a registry that said no is not asked again."""
    if not PYTHONS[0] <= sys.version_info[:2] <= PYTHONS[1]:
        least, most = (".".join(map(str, version)) for version in PYTHONS)
        return f"the frameworks run on Python {least} to {most}"
    made = folder / f"frameworks-{pins()}"
    if made.is_dir():
        return made
    folder.mkdir(parents=True, exist_ok=True)
    with locked(folder / f"{made.name}.lock"):
        if not made.is_dir():
            work = Path(tempfile.mkdtemp(prefix=f".{made.name}-", dir=folder))
            try:
                _install(work / "made")
                # The rename is the sign that it is whole: a killed run leaves only the work folder.
                (work / "made").rename(made)
            except EngineUnavailableError as err:
                return str(err)
            finally:
                shutil.rmtree(work, ignore_errors=True)
    return made


def _install(made: Path) -> None:
    made.mkdir()
    _run([sys.executable, "-m", "venv", str(made / "venv")])
    # By its path, because the commands of an environment that moves stay behind; `python -m` does not.
    pip = [
        str(Frameworks(made).python()),
        "-m",
        "pip",
        "--quiet",
        "--disable-pip-version-check",
        "--no-input",
    ]
    _run([*pip, "install", "-r", str(REQUIREMENTS)])
    _run([*pip, "install", "--no-deps", "-r", str(BARE)])
    for version in ISAACLAB:
        wheels = made / "wheels"
        _run(
            [
                *(*pip, "download", "--no-deps", *ISAACLAB_WHEEL, "--dest", str(wheels)),
                f"isaaclab=={version}",
            ]
        )
        (wheel,) = wheels.glob("*.whl")
        with zipfile.ZipFile(wheel) as archive:
            archive.extractall(made / f"isaaclab-{version}")
        shutil.rmtree(wheels)


def _run(command: Sequence[str]) -> None:
    try:
        done = subprocess.run(
            command,
            check=False,
            capture_output=True,
            text=True,
            timeout=INSTALL_TIMEOUT,
            stdin=subprocess.DEVNULL,
            env={**os.environ, "PYTHONPATH": ""},
        )
    except subprocess.TimeoutExpired as err:
        raise EngineUnavailableError(f"{command[-1]}: not installed after {INSTALL_TIMEOUT} s") from err
    if done.returncode:
        last = ([line for line in done.stderr.splitlines() if line.startswith("ERROR")] or [done.stderr])[-1]
        raise EngineUnavailableError(f"{command[-1]}: {last.strip()[:300]}")


if __name__ == "__main__":
    print(prepare().folder)
