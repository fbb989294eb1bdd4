"""Isaac Lab: the written module's cfgs, built and stepped by the real classes of a release."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from actspec.ir import JointKind
from actspec.simulate.excitation import HeldMotions
from actspec.simulate.experiment import Experiment
from actspec.spec.models import IsaacLabTarget
from actspec.targets.isaaclab import dialect_for
from actspec.verify.engines.asking import (
    BodyFriction,
    EngineAnswer,
    EngineMissing,
    EngineResponse,
    Question,
    prepared,
    probed,
)


def ask(question: Question, motions: HeldMotions) -> EngineAnswer:
    """Torques of the written cfgs.

    Raises:
        EngineMissing: no release of this version can be had, or it is not prepared, or its drive is the solver's.
        EngineRefused: the package does not take the file.
    """
    release, said, torques = _probed(question, *question.job(motions))
    # The others depend on class and version, and are read back.
    figures = {joint: {"armature": found["armature"]} for joint, found in said["joints"].items()}
    return EngineAnswer(f"isaaclab {release}", True, torques, figures)


def respond(question: Question, experiment: Experiment, friction: BodyFriction) -> EngineResponse:
    """Responses of bodies that the written cfgs' torques move; PhysX, which moves them there, is in no package.

    Raises: as `ask`.
    """
    arrays = experiment.arrays() | {"coulomb": friction[0], "viscous": friction[1]}
    release, said, out = _probed(question, experiment.job() | {"step": experiment.step}, arrays)
    return EngineResponse.of(f"isaaclab {release}", said, out, single=True)


def _probed(
    question: Question, job: Mapping[str, Any], arrays: Mapping[str, Any]
) -> tuple[str, Any, dict[str, Any]]:
    """The release, and what its probe says to a job."""
    options = question.options
    dialect = dialect_for(options)
    release = dialect.row.wheel
    if release is None:
        raise EngineMissing(f"the registry has no package of Isaac Lab {dialect.text}")
    if options.of(IsaacLabTarget).actuator_class == "implicit":
        raise EngineMissing("the drive of an implicit actuator is in PhysX, which is in no package")
    frameworks = prepared(f"Isaac Lab {release}")
    # A floating base is no joint of an articulation.
    joints = [joint.name for joint in question.robot.joints if joint.kind is not JointKind.FREE]
    module = str(Path(question.main).resolve())
    more = {"root": str(frameworks.isaaclab(release)), "module": module, "joints": joints}
    said, out = probed(frameworks, "probe_isaaclab.py", {**job, **more}, arrays)
    return release, said, out
