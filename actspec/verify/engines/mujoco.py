"""MuJoCo: the written model in the installed release, or in the very release that it is for."""

from __future__ import annotations

import re
import sys
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from actspec.diagnostics import RobotError, shortened
from actspec.files import NotRegular, TooLarge, read_regular
from actspec.robot.view import ModelFormat
from actspec.robot.xml import read_model_files
from actspec.simulators import UnknownVersion
from actspec.simulators.mujoco import RELEASES, MujocoDialect, mujoco_dialect
from actspec.verify.engines.mujoco_release import TIMEOUT, Engine, Job, grid, time
from actspec.verify.engines.question import (
    SETUP,
    EngineAnswer,
    EngineMissing,
    EngineRefused,
    Motions,
    Question,
)
from actspec.verify.motion import Motion
from actspec.verify.probing import PROBES, run_probe
from actspec.verify.releases import EngineError, release_folder
from actspec.verify.response import Friction, Plan, Responded, responded

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MOST_BYTES = 64 << 20
"""Chosen: the largest model seen has 1 MB."""

RESPONSES = PROBES / "probe_mujoco_response.py"

_NO_FILE = re.compile(r"Error opening file|resource not found|could not open", re.IGNORECASE)
_REMARK = re.compile(rb"<!--.*?-->", re.DOTALL)


def ask(question: Question, motions: Motions) -> EngineAnswer:
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


def respond(question: Question, plan: Plan, friction: Friction) -> Responded:
    """Responses of the written model's joints, each with its actuators in a model of its own.

    Raises: as `ask`.
    """
    engine = _engine(question)
    with _model(question, engine) as model:
        environment = {} if engine.folder is None else {"PYTHONPATH": str(engine.folder)}
        job = plan.job() | {"path": str(model.resolve()), "joints": plan.names}
        try:
            said, out = run_probe(
                sys.executable, RESPONSES, job, plan.arrays(), environment=environment, timeout=TIMEOUT
            )
        except EngineError as err:
            raise EngineRefused(shortened(str(err), 300)) from err
    if "error" in said:
        raise EngineRefused(shortened(said["error"], 300))
    return responded(f"mujoco {said['version']}", said, out, single=False)


def _jobs(model: Path, joints: Sequence[str], motion: Motion) -> Iterator[Job]:
    """One job for a grid, one for each environment of a history."""
    if len(motion.command) == 1:
        yield grid(model, joints=joints, q=motion.q[0], qd=motion.qd[0], ctrl=motion.command[0])
        return
    for env in range(motion.command.shape[1]):
        command, q, qd = (part[:, env] for part in (motion.command, motion.q, motion.qd))
        yield time(model, joints=joints, ctrl=command, q=q, qd=qd, start=command[0])


def _torques(motions: Motions, found: Mapping[str, Sequence[Array]]) -> dict[str, Array]:
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
