"""Real MuJoCo releases to agree with: fetched once, each stepped in a process of its own.

    engine = Engine(prepare("3.12.0"))
    engine.grid(xml, joints=["knee"], q=[[0.1]], qd=[[2.0]], ctrl=[[0.5]]).torque

A call costs about 0.3 s, most of it the interpreter's start: give it many samples, or many jobs (`run`).
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
import zipfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

VERSIONS = ("3.2.7", "3.3.7", "3.5.0", "3.7.0", "3.11.0", "3.12.0", "3.17.0", "4.0.0")
"""One release on each side of every change that actspec's capability table names."""

PROBE = Path(__file__).with_name("probe.py")
DOWNLOAD_TIMEOUT = 300
PROBE_TIMEOUT = 300

Array = NDArray[np.float64]


class EngineUnavailableError(Exception):
    """A release cannot be had here; the message says why."""


class EngineError(Exception):
    """A release refused the model or the job; the message is its own."""


def parse(version: str) -> tuple[int, ...]:
    """`"3.12.0"` → `(3, 12, 0)`, to compare releases by."""
    return tuple(int(part) for part in version.split("."))


def cache_folder() -> Path:
    """Where unpacked releases are kept."""
    return Path(os.environ.get("ACTSPEC_ENGINES") or Path.home() / ".cache" / "actspec" / "engines")


def prepare(version: str, folder: Path | None = None) -> Path:
    """Fetch and unpack a release unless it is there already.

    Args:
        version: MuJoCo's version.
        folder: Where to keep it; default `cache_folder()`.

    Returns: The folder to put on PYTHONPATH.
    Raises: EngineUnavailableError: no wheel for this Python and platform, or no registry.
    """
    return prepare_project("mujoco", version, folder)


def prepare_project(project: str, version: str, folder: Path | None = None) -> Path:
    """Fetch and unpack a project's wheel, without what it depends on; see `prepare`."""
    got = _attempt(project, version, folder or cache_folder())
    if isinstance(got, str):
        raise EngineUnavailableError(got)
    return got


@cache
def _attempt(project: str, version: str, folder: Path) -> Path | str:
    """The unpacked release, or why there is none: a registry that said no is not asked again."""
    name = f"{project}-{version}-{sysconfig.get_platform()}-{sys.implementation.cache_tag}"
    if (folder / name).is_dir():
        return folder / name
    folder.mkdir(parents=True, exist_ok=True)
    with locked(folder / f"{name}.lock"):
        if not (folder / name).is_dir():
            work = Path(tempfile.mkdtemp(prefix=f".{name}-", dir=folder))
            try:
                _unpack(project, version, work)
                # The rename is the sign that it is whole: a killed run leaves only the work folder.
                (work / "unpacked").rename(folder / name)
            except EngineUnavailableError as err:
                return str(err)
            finally:
                shutil.rmtree(work, ignore_errors=True)
    return folder / name


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold a file's lock; the system lets go of it when the process dies."""
    with open(path, "w", encoding="utf-8") as file:
        if os.name == "posix":
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _unpack(project: str, version: str, work: Path) -> None:
    wheels = work / project
    command = [
        sys.executable,
        "-m",
        "pip",
        "--quiet",
        "--disable-pip-version-check",
        "--no-input",
        "download",
    ]
    command += ["--no-deps", "--only-binary=:all:", "--dest", str(wheels), f"{project}=={version}"]
    try:
        done = subprocess.run(
            command,
            check=False,
            capture_output=True,
            text=True,
            timeout=DOWNLOAD_TIMEOUT,
            stdin=subprocess.DEVNULL,
        )
    except subprocess.TimeoutExpired as err:
        raise EngineUnavailableError(f"{project} {version}: no answer in {DOWNLOAD_TIMEOUT} s") from err
    found = sorted(wheels.glob("*.whl"))
    if done.returncode or not found:
        last = ([line for line in done.stderr.splitlines() if line.startswith("ERROR")] or [done.stderr])[-1]
        raise EngineUnavailableError(f"{project} {version}: {last.strip()[:300]}")
    with zipfile.ZipFile(found[0]) as wheel:
        wheel.extractall(work / "unpacked")
        metadata = next(n for n in wheel.namelist() if n.endswith(".dist-info/METADATA"))
        header = wheel.read(metadata).decode("utf-8").split("\n\n", 1)[0]
    # From 4.0 the `mujoco` wheel is a shell: the engine is in mujoco-core.
    for core in re.findall(r"^Requires-Dist: mujoco-core==([\d.]+)", header, re.MULTILINE):
        _unpack("mujoco-core", core, work)


@dataclass(frozen=True, slots=True)
class Job:
    """One thing to ask of an engine; `load`, `grid` and `time` below make them.

    Attributes:
        kind: load, grid or time.
        model: XML text, or the path of a file.
        joints: Hinge and slide joints, the columns of `q` and `qd`.
        actuators: The columns of `ctrl`; None means the one actuator of each joint.
        inputs: Arrays q, qd, ctrl and, for time, start.
        fields: More MjModel arrays to report.
    """

    kind: str
    model: str | Path
    joints: tuple[str, ...] = ()
    actuators: tuple[str, ...] | None = None
    inputs: dict[str, Array] = field(default_factory=dict)
    fields: tuple[str, ...] = ()


def load(model: str | Path, *, fields: Sequence[str] = ()) -> Job:
    """Ask whether a model compiles, and what it is."""
    return Job("load", model, fields=tuple(fields))


def grid(
    model: str | Path,
    *,
    joints: Sequence[str],
    q: ArrayLike,
    qd: ArrayLike,
    ctrl: ArrayLike,
    actuators: Sequence[str] | None = None,
) -> Job:
    """Ask for the torques at states, each evaluated alone with filters and delays settled.

    Args:
        model: XML text or file.
        joints: The columns of q and qd; every other joint stays at its reset state.
        q: Positions [rad or m], shape (n_sample, n_joint); or what broadcasts to it.
        qd: Velocities [rad/s or m/s], likewise.
        ctrl: First control of each actuator, shape (n_sample, n_actuator), likewise.
        actuators: The columns of ctrl; None means the one actuator of each joint.
    """
    width = len(joints if actuators is None else actuators)
    inputs = _rows({"q": (q, len(joints)), "qd": (qd, len(joints)), "ctrl": (ctrl, width)})
    return Job("grid", model, tuple(joints), None if actuators is None else tuple(actuators), inputs)


def time(
    model: str | Path,
    *,
    joints: Sequence[str],
    ctrl: ArrayLike,
    q: ArrayLike = 0.0,
    qd: ArrayLike = 0.0,
    start: ArrayLike | None = None,
    actuators: Sequence[str] | None = None,
) -> Job:
    """Ask for the torques over a control sequence, the joints put back to (q, qd) before every step.

    Args:
        model: XML text or file.
        joints: As in `grid`.
        ctrl: First control of each actuator at each step, shape (n_step, n_actuator).
        q: Positions held, shape (n_joint,) or (n_step, n_joint).
        qd: Velocities held, likewise.
        start: Reset recipe: filters and delay lines begin at these controls, shape (n_actuator,). None is the
            engine's bare reset, which begins them at 0.
        actuators: As in `grid`.
    """
    width = len(joints if actuators is None else actuators)
    inputs = _rows({"ctrl": (ctrl, width), "q": (q, len(joints)), "qd": (qd, len(joints))})
    if start is not None:
        inputs["start"] = np.broadcast_to(np.asarray(start, dtype=float), (width,))
    return Job("time", model, tuple(joints), None if actuators is None else tuple(actuators), inputs)


def _rows(given: dict[str, tuple[ArrayLike, int]]) -> dict[str, Array]:
    """Broadcast to one row a sample."""
    arrays = {name: np.asarray(value, dtype=float) for name, (value, _) in given.items()}
    n_sample = max(a.shape[0] if a.ndim == 2 else 1 for a in arrays.values())
    return {name: np.broadcast_to(a, (n_sample, given[name][1])) for name, a in arrays.items()}


@dataclass(frozen=True, slots=True)
class Answer:
    """What an engine said to one job.

    Attributes:
        error: Why it refused; None if it did not.
        info: sizes, timestep [s], integrator, joints, actuators, gaintypes, biastypes, dyntypes.
        fields: MjModel arrays by name, those that the release has.
        forces: torque, passive and constraint, shape (n_sample, n_joint), in the job's joint order;
            qfrc_actuator, qfrc_passive and qacc over all degrees of freedom; actuator_force and act.
    """

    error: str | None
    info: dict[str, Any]
    fields: dict[str, NDArray[Any]]
    forces: dict[str, Array]

    @property
    def ok(self) -> bool:
        """Whether the model compiled and the job ran."""
        return self.error is None

    @property
    def torque(self) -> Array:
        """Actuator torque at the joint, gears and joint clamp applied [N*m or N], shape (n_sample, n_joint).

        Raises: EngineError: the engine refused the job.
        """
        if self.error is not None:
            raise EngineError(self.error)
        return self.forces["torque"]

    def joint(self, name: str, of: str) -> NDArray[Any]:
        """The entry of a `jnt_*` or `dof_*` field of a hinge or slide joint."""
        index = self.info["joints"].index(name)
        return self.fields[of][self.fields["jnt_dofadr"][index] if of.startswith("dof_") else index]  # type: ignore[no-any-return]

    def actuator(self, name: str, of: str) -> NDArray[Any]:
        """The entry of an `actuator_*` field that has one row an actuator."""
        return self.fields[of][self.info["actuators"].index(name)]  # type: ignore[no-any-return]


@dataclass(frozen=True, slots=True)
class Engine:
    """One MuJoCo release.

    Attributes:
        version: Its version.
        folder: Where it is unpacked, from `prepare`.
    """

    version: str
    folder: Path

    @classmethod
    def of(cls, version: str) -> Engine:
        """Prepare a release. Raises EngineUnavailableError."""
        return cls(version, prepare(version))

    @property
    def number(self) -> tuple[int, ...]:
        """The version to compare by."""
        return parse(self.version)

    def load(self, model: str | Path, *, fields: Sequence[str] = ()) -> Answer:
        """Compile a model; `answer.error` says what the engine says where it does not."""
        return self.run([load(model, fields=fields)])[0]

    def grid(self, model: str | Path, **inputs: Any) -> Answer:
        """Torques at states; see the function `grid`. Raises EngineError."""
        return self._checked(grid(model, **inputs))

    def time(self, model: str | Path, **inputs: Any) -> Answer:
        """Torques over time; see the function `time`. Raises EngineError."""
        return self._checked(time(model, **inputs))

    def _checked(self, job: Job) -> Answer:
        answer = self.run([job])[0]
        if answer.error is not None:
            raise EngineError(f"mujoco {self.version}: {answer.error}")
        return answer

    def run(self, jobs: Sequence[Job]) -> list[Answer]:
        """Answer jobs in one process.

        A job that the engine refuses is an answer with its error. Raises EngineError: the process died.
        """
        asked = [
            {
                "kind": job.kind,
                "xml": None if isinstance(job.model, Path) else job.model,
                "path": str(job.model.resolve()) if isinstance(job.model, Path) else None,
                "joints": job.joints,
                "actuators": job.actuators,
                "fields": job.fields,
            }
            for job in jobs
        ]
        arrays = {f"{i}.{key}": value for i, job in enumerate(jobs) for key, value in job.inputs.items()}
        # MuJoCo writes MUJOCO_LOG.TXT where it runs: here, and it goes with the folder.
        with tempfile.TemporaryDirectory(prefix="actspec-engine-") as name:
            work = Path(name)
            (work / "in.json").write_text(json.dumps(asked), encoding="utf-8")
            np.savez(work / "in.npz", **arrays)  # type: ignore[arg-type]  # numpy's stub takes them for allow_pickle
            self._probe(work)
            said = json.loads((work / "out.json").read_text(encoding="utf-8"))
            if said["version"] != self.version or not Path(said["module"]).is_relative_to(self.folder):
                raise EngineError(f"asked mujoco {self.version}, {said['module']} {said['version']} answered")
            with np.load(work / "out.npz") as found:
                return [_answer(i, raw, found) for i, raw in enumerate(said["answers"])]

    def _probe(self, work: Path) -> None:
        environment = {
            # Nothing is drawn: without this the import looks for a display library.
            **os.environ,
            "MUJOCO_GL": "disabled",
            "PYTHONPATH": str(self.folder),
            "PYTHONNOUSERSITE": "1",
            "PYTHONDONTWRITEBYTECODE": "1",
        }
        done = subprocess.run(
            [sys.executable, str(PROBE), "in.json", "in.npz", "out.json", "out.npz"],
            check=False,
            cwd=work,
            env=environment,
            capture_output=True,
            text=True,
            timeout=PROBE_TIMEOUT,
            stdin=subprocess.DEVNULL,
        )
        if done.returncode:
            raise EngineError(f"mujoco {self.version}: exit {done.returncode}: {done.stderr[-2000:]}")


def _answer(index: int, raw: dict[str, Any], found: Any) -> Answer:
    mine = {k.split(".", 1)[1]: found[k] for k in found.files if k.startswith(f"{index}.")}
    fields = {k.removeprefix("field."): v for k, v in mine.items() if k.startswith("field.")}
    forces = {k: v for k, v in mine.items() if not k.startswith("field.")}
    return Answer(raw.pop("error", None), raw, fields, forces)
