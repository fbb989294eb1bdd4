"""mjlab: the written articulation on a robot with the model's joints, stepped by the real package."""

from __future__ import annotations

from pathlib import Path

from actspec.diagnostics import shortened
from actspec.targets.mjlab.versions import mjlab_dialect
from actspec.verify.engines.question import (
    EngineAnswer,
    EngineMissing,
    EngineRefused,
    Motions,
    Question,
    not_prepared,
)
from actspec.verify.engines.skeleton import skeleton
from actspec.verify.frameworks import find, unusable
from actspec.verify.motion import as_arrays
from actspec.verify.probing import PROBES
from actspec.verify.releases import EngineError

PROBE = PROBES / "probe_mjlab.py"

RELEASE = "1.6.0"
"""The release in the environment."""


def ask(question: Question, motions: Motions) -> EngineAnswer:
    """Torques of the written articulation.

    Raises:
        EngineMissing: the release is not prepared, or is not the one that the environment has.
        EngineRefused: the package does not take the file.
    """
    dialect = mjlab_dialect(question.options.version)
    if dialect.version != (1, 6):
        raise EngineMissing(
            f"mjlab {dialect.text} is not run here: the environment has {RELEASE}, "
            "and each release needs a MuJoCo of its own"
        )
    why = unusable()
    if why is not None:
        raise EngineMissing(why)
    frameworks = find()
    if frameworks is None:
        raise not_prepared(f"mjlab {RELEASE}")
    try:
        said, torques = frameworks.run_probe(
            PROBE,
            {
                "module": str(Path(question.main).resolve()),
                "model": skeleton(question.robot, question.actuators),
                "step": question.step,
                "columns": question.joints,
                "commands": [a.command.value for a in question.actuators.joints],
                "motions": list(motions),
            },
            as_arrays(motions),
        )
    except EngineError as err:
        raise EngineRefused(shortened(str(err), 300)) from err
    if "error" in said:
        raise EngineRefused(shortened(said["error"], 300))
    return EngineAnswer(f"mjlab {RELEASE}", True, torques, said["figures"])
