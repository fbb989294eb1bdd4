"""MuJoCo: the written model in the installed release, or in the very release that it is for.

Either is stepped in a process of its own, by `actspec/simulate/rollout.py`.
"""

from __future__ import annotations

import re
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import RobotError, shortened
from actspec.files import FAULTS, read_regular
from actspec.robot.view import ModelFormat
from actspec.robot.xml import open_document
from actspec.simulate.excitation import COURSES, HeldMotions
from actspec.simulate.experiment import Experiment
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
    release_folder,
    run_probe,
)

if TYPE_CHECKING:
    from actspec.laws.arrays import Floats as Array

ROLLOUT = SIMULATE / "rollout.py"
ATTACHED = Path(__file__).parents[1] / "attached.py"
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
    engine, _, torques = _rolled(question, *question.job(motions))
    return EngineAnswer(engine, False, torques)


def respond(question: Question, experiment: Experiment, friction: BodyFriction) -> EngineResponse:
    """Responses of the written model's joints, each with its actuators in a model of its own.

    Raises: as `ask`.
    """
    engine, said, out = _rolled(question, experiment.job(), experiment.arrays())
    return EngineResponse.of(engine, said, out, single=False)


def _rolled(
    question: Question, job: dict[str, Any], arrays: Mapping[str, Any]
) -> tuple[str, Any, dict[str, Array]]:
    """Name and version of the engine, what it answers to a job, and the arrays."""
    version, folder = _release(question)
    environment = {} if folder is None else {"PYTHONPATH": str(folder)}
    # The runtime is actspec's own, and asked as its users ask it.
    networks = COURSES in job.get("motions", ())
    with _model(question, folder) as model:
        try:
            said, out = run_probe(
                sys.executable,
                ATTACHED if networks else ROLLOUT,
                {**job, "path": str(model.resolve()), "networks": str(Path(question.folder).resolve())},
                arrays,
                environment=environment,
                timeout=TIMEOUT,
            )
        except EngineError as err:
            raise EngineRefused(shortened(str(err), 300)) from err
    if said["version"] != version or not (folder is None or Path(said["module"]).is_relative_to(folder)):
        raise EngineRefused(f"asked mujoco {version}, {said['module']} {said['version']} answered")
    if "error" in said:
        text = shortened(said["error"], 300)
        if _NO_FILE.search(text):
            raise EngineMissing(f"a file that the model names is not here: {text}")
        raise EngineRefused(text)
    return f"mujoco {version}", said, out


def release_for(version: str) -> str | None:
    """The release that a target's version needs beside the installed one; None: it needs none."""
    import mujoco

    try:
        dialect = mujoco_dialect(version)
    except UnknownVersion:
        return None
    own = mujoco_dialect(".".join(mujoco.__version__.split(".")[:2]))
    return None if own.version == dialect.version or _reads(own, dialect, True) else RELEASES[dialect.version]


def _release(question: Question) -> tuple[str, Path | None]:
    """Version of the release that reads the file, and where it is unpacked; None: the installed one."""
    import mujoco

    dialect = mujoco_dialect(question.options.version)
    own = mujoco_dialect(".".join(mujoco.__version__.split(".")[:2]))
    if own.version == dialect.version or _reads(own, dialect, _has_dcmotor(question)):
        return mujoco.__version__, None
    version = RELEASES[dialect.version]
    folder = release_folder("mujoco", version)
    if not folder.is_dir():
        raise EngineMissing(
            f"MuJoCo {mujoco.__version__} is installed, which reads the file otherwise, and "
            f"{version} is not prepared",
            SETUP,
            setup=True,
        )
    return version, folder


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
        except FAULTS:
            continue
        if b"<dcmotor" in _REMARK.sub(b"", data):
            return True
    return False


@contextmanager
def _model(question: Question, folder: Path | None) -> Iterator[Path]:
    """The model as the engine is to load it.

    For the installed release it is compiled here, with stand-ins for meshes, which need not be there.
    """
    if folder is not None:
        yield Path(question.main)
        return
    if question.refusal is not None:
        raise EngineRefused(shortened(question.refusal, 300))
    import mujoco

    from actspec.robot.mjspec import compile_spec, open_spec

    try:
        spec = open_spec(open_document(question.main).files, format=ModelFormat.MJCF)
        model = compile_spec(spec)
    except RobotError as err:
        raise EngineRefused(shortened(err.diagnostics[0].message, 300)) from err
    with tempfile.TemporaryDirectory(prefix="actspec-model-") as made:
        path = Path(made, "model.mjb")
        mujoco.mj_saveModel(model, str(path), None)
        yield path
