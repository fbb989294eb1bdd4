"""The simulators' own packages: fetched by pip, kept in one folder, run in processes of their own.

    folder = prepare_release("mujoco", "3.11.0")      # to put on PYTHONPATH
    frameworks = prepare_frameworks()
    said, arrays = frameworks.run_probe(Path("probe.py"), {"text": text}, {"q": q})

A release is one distribution, unpacked, without what it depends on: MuJoCo of a version beside the installed one. The
frameworks are one environment, named after what is in it: mjlab and Newton with what they need, and wheels unpacked
beside them: Isaac Lab's, whose package cannot be imported from where it is installed, because its first line looks for
a simulator that needs a GPU, and older Newtons. Either appears whole or not at all.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from actspec.simulators import isaaclab, newton

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

HERE = Path(__file__).parent
SIMULATE = HERE.parent / "simulate"
SHARED = (SIMULATE / "standalone.py", SIMULATE / "rollout.py")
"""What is sent along with every script, which imports it by its bare name."""

DOWNLOAD_TIME, INSTALL_TIME = 300, 1800
"""Most seconds for one download, and for one step of an installation."""

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
    """What is done next is not reported."""


def prepare_release(
    project: str, version: str, folder: Path | None = None, say: Callable[[str], None] = quiet
) -> Path:
    """Fetch and unpack a release, without what it depends on, unless it is there already.

    Args:
        project: Name of the distribution.
        version: Its version.
        folder: Where to keep it; default `cache_folder()`.
        say: Called with what is done next.

    Returns: The folder to put on PYTHONPATH.
    Raises: EngineUnavailableError: no wheel for this Python and platform, or no registry.
    """

    def make(made: Path) -> None:
        say(f"{project} {version}")
        _unpack(project, version, made)

    return whole(release_folder(project, version, folder), make, say)


_REFUSED: dict[Path, str] = {}
"""Folders that could not be had, and why: a registry that said no is not asked again."""


def whole(made: Path, make: Callable[[Path], None], say: Callable[[str], None]) -> Path:
    """A folder that appears whole or not at all, whoever else wants it at the same time.

    Args:
        made: The folder.
        make: Makes it, at another place.
        say: Called with what is done next.

    Raises: EngineUnavailableError: it cannot be had.
    """
    if made.is_dir():
        return made
    if made not in _REFUSED:
        try:
            made.parent.mkdir(parents=True, exist_ok=True)
            with _locked(made.parent / f"{made.name}.lock", say):
                if not made.is_dir():
                    _make(made, make)
            return made
        except EngineUnavailableError as err:
            _REFUSED[made] = str(err)
        except OSError as err:
            _REFUSED[made] = f"{made.parent}: {err.strerror or err}"
    raise EngineUnavailableError(_REFUSED[made])


def _make(made: Path, make: Callable[[Path], None]) -> None:
    """Make a folder whose lock is held."""
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

    Raises: EngineUnavailableError: it failed, with its last error.
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
    run([*command, f"{project}=={version}"], f"{project} {version}", DOWNLOAD_TIME)
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


class ProbeAnswer(NamedTuple):
    """What a probe wrote.

    Attributes:
        said: Its JSON.
        arrays: Its arrays by name.
    """

    said: Any
    arrays: dict[str, NDArray[np.float64]]


def run_probe(
    python: Path | str,
    script: Path,
    job: Any,
    arrays: Mapping[str, Any] | None = None,
    *,
    environment: Mapping[str, str],
    timeout: float,
) -> ProbeAnswer:
    """Run a script: `python SCRIPT in.json in.npz out.json out.npz`, in a new folder.

    The script must write both outputs; it can import `standalone` and `rollout` of `actspec.simulate`.

    Args:
        python: The interpreter.
        script: The probe.
        job: Anything that JSON can hold.
        arrays: Input arrays by name.
        environment: Variables beside those of this process.
        timeout: [s].

    Raises: EngineError: the script failed; the end of what it wrote to stderr is in the message.
    """
    import numpy as np

    # MuJoCo and warp leave files where they run: here, and they go with the folder.
    with tempfile.TemporaryDirectory(prefix="actspec-probe-") as name:
        work = Path(name)
        for shared in SHARED:
            shutil.copy(shared, work)
        before = environment.get("PYTHONPATH", os.environ.get("PYTHONPATH"))
        (work / "in.json").write_text(json.dumps(job), encoding="utf-8")
        np.savez(work / "in.npz", **{key: np.asarray(value) for key, value in (arrays or {}).items()})  # type: ignore[arg-type]
        variables = {
            **os.environ,
            # Nothing is drawn: without this an import looks for a display library.
            "MUJOCO_GL": "disabled",
            "PYTHONNOUSERSITE": "1",
            **environment,
            "PYTHONPATH": os.pathsep.join(filter(None, [str(work), before])),
        }
        try:
            done = subprocess.run(
                [str(python), str(script.resolve()), "in.json", "in.npz", "out.json", "out.npz"],
                check=False,
                cwd=work,
                env=variables,
                capture_output=True,
                text=True,
                errors="replace",
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
        """Run a script in the environment; see `run_probe`.

        Raises: EngineError: the script failed.
        """
        # Compiled kernels are kept: twenty seconds the first time.
        environment = {"PYTHONPATH": "", "WARP_CACHE_PATH": str(self.folder / "warp")}
        return run_probe(self.python(), script, job, arrays, environment=environment, timeout=timeout)


def requirements() -> list[str]:
    """What is installed with its dependencies."""
    return _lines(REQUIREMENTS)


def find_frameworks(folder: Path | None = None) -> Frameworks | None:
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


def prepare_frameworks(
    folder: Path | None = None, extra: Sequence[str] = (), say: Callable[[str], None] = quiet
) -> Frameworks:
    """Make the environment unless it is there already; minutes, the first time.

    Args:
        folder: Where to keep it; default `cache_folder()`.
        extra: Requirements beyond those of actspec's own.
        say: Called with what is done next.

    Raises: EngineUnavailableError: a package cannot be had for this Python and platform.
    """
    why = unusable()
    if why is not None:
        raise EngineUnavailableError(why)
    return Frameworks(
        whole(_made(folder or cache_folder(), extra), lambda made: _install(made, extra, say), say)
    )


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


def _install(made: Path, extra: Sequence[str], say: Callable[[str], None]) -> None:
    made.mkdir()
    say("a virtual environment")
    run([sys.executable, "-m", "venv", str(made / "venv")], "a virtual environment", INSTALL_TIME)
    # By its path, because the commands of an environment that moves stay behind; `python -m` does not.
    command = pip(Frameworks(made).python())
    # What is imported is compiled then, and that is a small part of it.
    install = [*command, "install", "--no-compile"]
    say("torch, MuJoCo, Newton: most of it")
    run([*install, "-r", str(REQUIREMENTS), *extra], "torch, mujoco, warp", INSTALL_TIME)
    say("mjlab")
    run([*install, "--no-deps", "-r", str(BARE)], "mjlab", INSTALL_TIME)
    for name, versions, options in UNPACKED:
        for version in versions:
            wheels = made / "wheels"
            say(f"{name} {version}")
            fetch = [*command, "download", "--no-deps", *options, "--dest", str(wheels)]
            run([*fetch, f"{name}=={version}"], f"{name} {version}", INSTALL_TIME)
            (wheel,) = wheels.glob("*.whl")
            with zipfile.ZipFile(wheel) as archive:
                archive.extractall(made / f"{name}-{version}")
            shutil.rmtree(wheels)
    (made / CONTENTS).write_text("\n".join(_contents(extra)) + "\n", encoding="utf-8")
