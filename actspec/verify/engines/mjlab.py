"""mjlab: the written articulation on a robot with the model's joints, stepped by the real package."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from actspec.simulators import release_of
from actspec.simulators.mjlab import INSTALLED, mjlab_dialect
from actspec.verify.engines.asking import prepared, probed
from actspec.verify.engines.question import EngineAnswer, EngineMissing, Motions, Question
from actspec.verify.engines.skeleton import skeleton
from actspec.verify.motion import as_arrays
from actspec.verify.probing import PROBES
from actspec.verify.response import Friction, Plan, Responded, responded

PROBE = PROBES / "probe_mjlab.py"


def ask(question: Question, motions: Motions) -> EngineAnswer:
    """Torques of the written articulation.

    Raises:
        EngineMissing: the release is not prepared, or is not the one that the environment has.
        EngineRefused: the package does not take the file.
    """
    job = {
        "model": skeleton(question.robot, question.actuators),
        "columns": question.joints,
        "commands": [a.command.value for a in question.actuators.joints],
        "motions": list(motions),
    }
    said, torques = _probed(question, job, as_arrays(motions))
    return EngineAnswer(f"mjlab {INSTALLED}", True, torques, said["figures"])


def respond(question: Question, plan: Plan, friction: Friction) -> Responded:
    """Responses of the written articulation, each joint on a body of its own.

    Raises: as `ask`.
    """
    inertia = dict(zip(plan.names, plan.body.tolist(), strict=True))
    job = plan.job() | {"model": skeleton(question.robot, question.actuators, inertia)}
    said, out = _probed(question, job, plan.arrays())
    return responded(f"mjlab {INSTALLED}", said, out, single=True)


def _probed(
    question: Question, job: Mapping[str, Any], arrays: Mapping[str, Any]
) -> tuple[Any, dict[str, Any]]:
    """What the release's probe says to a job."""
    dialect = mjlab_dialect(question.options.version)
    if dialect.version != release_of(INSTALLED):
        raise EngineMissing(
            f"mjlab {dialect.text} is not run here: the environment has {INSTALLED}, "
            "and each release needs a MuJoCo of its own"
        )
    frameworks = prepared(f"mjlab {INSTALLED}")
    more = {"module": str(Path(question.main).resolve()), "step": question.step}
    return probed(frameworks, PROBE, {**job, **more}, arrays)
