"""The MuJoCo releases that are agreed with, each stepped in a process of its own.

    engine = Engine.of("3.12.0")
    engine.grid(xml, joints=["knee"], q=[[0.1]], qd=[[2.0]], ctrl=[[0.5]]).torque

A call costs about 0.3 s, most of it the interpreter's start: give it many samples, or many jobs (`run`).
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from actspec.verify.environments import EngineError, prepare_release, run_probe

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    Array = NDArray[np.float64]

VERSIONS = ("3.2.7", "3.3.7", "3.5.0", "3.7.0", "3.11.0", "3.12.0", "3.17.0", "4.0.0")
"""One release on each side of every change that actspec's capability table names."""

PROBE = Path(__file__).with_name("rollout_probe.py")
TIMEOUT = 300
"""Seconds for the jobs of one process."""


def parse(version: str) -> tuple[int, ...]:
    """`"3.12.0"` → `(3, 12, 0)`, to compare releases by."""
    return tuple(int(part) for part in version.split("."))


@dataclass(frozen=True, slots=True)
class Job:
    """One thing to ask of an engine; `load`, `grid` and `time` below make them.

    Attributes:
        kind: load, grid or time.
        model: XML text, or the path of an XML or MJB.
        joints: Hinge and slide joints, the columns of `q` and `qd`.
        actuators: The columns of `ctrl`; None means the one actuator of each joint.
        inputs: Arrays q, qd, ctrl and, for time, start.
        fields: More MjModel arrays to report.
        contacts: Whether contacts and limits act.
    """

    kind: str
    model: str | Path
    joints: tuple[str, ...] = ()
    actuators: tuple[str, ...] | None = None
    inputs: dict[str, Array] = field(default_factory=dict)
    fields: tuple[str, ...] = ()
    contacts: bool = True


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
        import numpy as np

        inputs["start"] = np.broadcast_to(np.asarray(start, dtype=float), (width,))
    return Job("time", model, tuple(joints), None if actuators is None else tuple(actuators), inputs)


def _rows(given: dict[str, tuple[ArrayLike, int]]) -> dict[str, Array]:
    """Broadcast to one row a sample."""
    import numpy as np

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
        folder: Where it is unpacked, from `prepare_release`; None: the installed one.
    """

    version: str
    folder: Path | None

    @classmethod
    def of(cls, version: str) -> Engine:
        """Prepare a release. Raises EngineUnavailableError."""
        return cls(version, prepare_release("mujoco", version))

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
                "contacts": job.contacts,
            }
            for job in jobs
        ]
        arrays = {f"{i}.{key}": value for i, job in enumerate(jobs) for key, value in job.inputs.items()}
        environment = {} if self.folder is None else {"PYTHONPATH": str(self.folder)}
        said, found = run_probe(
            sys.executable, PROBE, asked, arrays, environment=environment, timeout=TIMEOUT
        )
        other = self.folder is not None and not Path(said["module"]).is_relative_to(self.folder)
        if said["version"] != self.version or other:
            raise EngineError(f"asked mujoco {self.version}, {said['module']} {said['version']} answered")
        return [_answer(i, raw, found) for i, raw in enumerate(said["answers"])]


def _answer(index: int, raw: dict[str, Any], found: dict[str, NDArray[Any]]) -> Answer:
    mine = {k.split(".", 1)[1]: v for k, v in found.items() if k.startswith(f"{index}.")}
    fields = {k.removeprefix("field."): v for k, v in mine.items() if k.startswith("field.")}
    forces = {k: v for k, v in mine.items() if not k.startswith("field.")}
    return Answer(raw.pop("error", None), raw, fields, forces)
