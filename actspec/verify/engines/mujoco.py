"""MuJoCo: the written model in the installed release, or in the very release that it is for.

    engine = Engine.of("3.12.0")
    engine.grid(xml, joints=["knee"], q=[[0.1]], qd=[[2.0]], ctrl=[[0.5]]).torque

A release is stepped in a process of its own, by `actspec/simulate/rollout.py`. A call costs about 0.3 s, most of it the
interpreter's start: give it many samples, or many jobs (`run`).
"""

from __future__ import annotations

import re
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import RobotError, shortened
from actspec.files import NotRegular, TooLarge, read_regular
from actspec.robot.view import ModelFormat
from actspec.robot.xml import read_model_files
from actspec.simulate.excitation import HeldMotion, HeldMotions
from actspec.simulate.experiment import PARTS, Experiment
from actspec.simulators import UnknownVersion
from actspec.simulators.mujoco import RELEASES, MujocoDialect, mujoco_dialect
from actspec.verify.engines.asking import (
    SETUP,
    BodyFriction,
    EngineAnswer,
    EngineMissing,
    EngineRefused,
    EngineResponse,
    Question,
)
from actspec.verify.environments import (
    SIMULATE,
    EngineError,
    prepare_release,
    release_folder,
    run_probe,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    Array = NDArray[np.float64]

ROLLOUT = SIMULATE / "rollout.py"
TIMEOUT = 300
"""Seconds for the jobs of one process."""

MOST_BYTES = 64 << 20
"""Chosen: the largest model seen has 1 MB."""

_NO_FILE = re.compile(r"Error opening file|resource not found|could not open", re.IGNORECASE)
_REMARK = re.compile(rb"<!--.*?-->", re.DOTALL)


def ask(question: Question, motions: HeldMotions) -> EngineAnswer:
    """Torques of the written model.

    Raises:
        EngineMissing: no release here can read it.
        EngineRefused: the release that it is for does not take it.
    """
    engine = _engine(question)
    with _model(question, engine) as model:
        jobs = [
            (name, replace(job, contacts=False))
            for name, motion in motions.items()
            for job in _jobs(model, question.joints, motion)
        ]
        try:
            answers = engine.run([job for _, job in jobs])
        except EngineError as err:
            raise EngineRefused(shortened(str(err), 300)) from err
    found: dict[str, list[Array]] = {name: [] for name in motions}
    for (name, _), answer in zip(jobs, answers, strict=True):
        if answer.error is not None:
            text = shortened(answer.error, 300)
            if _NO_FILE.search(text):
                raise EngineMissing(f"a file that the model names is not here: {text}")
            raise EngineRefused(text)
        found[name].append(answer.torque)
    return EngineAnswer(f"mujoco {engine.version}", False, _torques(motions, found))


def respond(question: Question, experiment: Experiment, friction: BodyFriction) -> EngineResponse:
    """Responses of the written model's joints, each with its actuators in a model of its own.

    Raises: as `ask`.
    """
    engine = _engine(question)
    with _model(question, engine) as model:
        job = Job("responses", model, tuple(experiment.names), inputs=experiment.arrays(), parts=PARTS)
        try:
            (answer,) = engine.run([job])
        except EngineError as err:
            raise EngineRefused(shortened(str(err), 300)) from err
    if answer.error is not None:
        raise EngineRefused(shortened(answer.error, 300))
    return EngineResponse.of(f"mujoco {engine.version}", answer.info, answer.forces, single=False)


def _jobs(model: Path, joints: Sequence[str], motion: HeldMotion) -> Iterator[Job]:
    """One job for a grid, one for each environment of a history."""
    if len(motion.command) == 1:
        yield grid(model, joints=joints, q=motion.q[0], qd=motion.qd[0], ctrl=motion.command[0])
        return
    for env in range(motion.command.shape[1]):
        command, q, qd = (part[:, env] for part in (motion.command, motion.q, motion.qd))
        yield time(model, joints=joints, ctrl=command, q=q, qd=qd, start=command[0])


def _torques(motions: HeldMotions, found: Mapping[str, Sequence[Array]]) -> dict[str, Array]:
    """Rows of jobs as (step, environment, joint): a grid has a row for each environment, a history for each step."""
    import numpy as np

    return {
        name: parts[0][None] if len(motions[name].command) == 1 else np.stack(parts, axis=1)
        for name, parts in found.items()
    }


def release_for(version: str) -> str | None:
    """The release that a target's version needs beside the installed one; None: it needs none."""
    import mujoco

    try:
        dialect = mujoco_dialect(version)
    except UnknownVersion:
        return None
    own = mujoco_dialect(".".join(mujoco.__version__.split(".")[:2]))
    return None if own.version == dialect.version or _reads(own, dialect, True) else RELEASES[dialect.version]


def _engine(question: Question) -> Engine:
    import mujoco

    dialect = mujoco_dialect(question.options.version)
    own = mujoco_dialect(".".join(mujoco.__version__.split(".")[:2]))
    if own.version == dialect.version or _reads(own, dialect, _has_dcmotor(question)):
        return Engine(mujoco.__version__, None)
    version = RELEASES[dialect.version]
    folder = release_folder("mujoco", version)
    if not folder.is_dir():
        raise EngineMissing(
            f"MuJoCo {mujoco.__version__} is installed, which reads the file otherwise, and "
            f"{version} is not prepared",
            SETUP,
            setup=True,
        )
    return Engine(version, folder)


def _reads(own: MujocoDialect, dialect: MujocoDialect, dcmotor: bool) -> bool:
    """Whether one release reads what is written for another one as that does."""
    if dcmotor and own.dcmotor is not dialect.dcmotor:
        return False
    # What an older release reads a newer one reads too: tests/agree steps them.
    return own.version >= dialect.version or (own.native_delay, own.polynomials, own.general_input) == (
        dialect.native_delay,
        dialect.polynomials,
        dialect.general_input,
    )


def _has_dcmotor(question: Question) -> bool:
    """Whether any of the written files has one, remarks aside."""
    for name in question.files:
        try:
            data = read_regular(str(Path(question.folder, name)), MOST_BYTES)
        except (OSError, ValueError, NotRegular, TooLarge):
            continue
        if b"<dcmotor" in _REMARK.sub(b"", data):
            return True
    return False


@contextmanager
def _model(question: Question, engine: Engine) -> Iterator[Path]:
    """The model as the engine is to load it.

    For the installed release it is compiled here, with stand-ins for meshes, which need not be there.
    """
    if engine.folder is not None:
        yield Path(question.main)
        return
    if question.refusal is not None:
        raise EngineRefused(shortened(question.refusal, 300))
    import mujoco

    from actspec.robot.mjspec import compile_spec, open_spec

    try:
        spec = open_spec(read_model_files(question.main), format=ModelFormat.MJCF)
        model = compile_spec(spec)
    except RobotError as err:
        raise EngineRefused(shortened(err.diagnostics[0].message, 300)) from err
    with tempfile.TemporaryDirectory(prefix="actspec-model-") as folder:
        path = Path(folder, "model.mjb")
        mujoco.mj_saveModel(model, str(path), None)
        yield path


def parse(version: str) -> tuple[int, ...]:
    """`"3.12.0"` → `(3, 12, 0)`, to compare releases by."""
    return tuple(int(part) for part in version.split("."))


@dataclass(frozen=True, slots=True)
class Job:
    """One thing to ask of an engine; `load`, `grid` and `time` below make them.

    Attributes:
        kind: load, grid, time or responses.
        model: XML text, or the path of an XML or MJB.
        joints: Hinge and slide joints, the columns of `q` and `qd`.
        actuators: The columns of `ctrl`; None means the one actuator of each joint.
        inputs: Arrays q, qd, ctrl and, for time, start; for responses those of an experiment.
        fields: More MjModel arrays to report.
        contacts: Whether contacts and limits act.
        parts: For responses: into how many steps each step is divided, for each run.
    """

    kind: str
    model: str | Path
    joints: tuple[str, ...] = ()
    actuators: tuple[str, ...] | None = None
    inputs: dict[str, Array] = field(default_factory=dict)
    fields: tuple[str, ...] = ()
    contacts: bool = True
    parts: tuple[int, ...] = ()


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
                "parts": job.parts,
            }
            for job in jobs
        ]
        arrays = {f"{i}.{key}": value for i, job in enumerate(jobs) for key, value in job.inputs.items()}
        environment = {} if self.folder is None else {"PYTHONPATH": str(self.folder)}
        said, found = run_probe(
            sys.executable, ROLLOUT, asked, arrays, environment=environment, timeout=TIMEOUT
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
