"""Files of any kind, lifted: each robot as each file has it."""

from __future__ import annotations

from collections.abc import Sequence

from actspec.lift.config import lift_config
from actspec.lift.lifted import Lifted, LiftedFiles, LiftedRobot
from actspec.lift.robot import lift_robot
from actspec.readings.artifact import Artifact
from actspec.readings.versions import Versions
from actspec.robot.view import JointView


def lift(
    artifact: Artifact,
    joints: Sequence[JointView | str] | None = None,
    *,
    versions: Versions | None = None,
    physics_dt: float | None = None,
) -> Lifted:
    """What one robot's description in one file says of its actuators.

    Args:
        artifact: As a reader of the audit gives it.
        joints: As in `lift_config`, and so are the others.
        versions: Likewise.
        physics_dt: Likewise.
    """
    if artifact.robot is not None:
        found = lift_robot(artifact.robot)
        return Lifted(found.actuators, found.left_alone, found.notes, artifact)
    return lift_config(artifact, joints, versions=versions, physics_dt=physics_dt)


def lift_files(paths: Sequence[str], *, versions: Versions | None = None) -> LiftedFiles:
    """Read files, put together what is of one robot, and lift each part.

    A configuration gets its joints from the robot file that it fits best, and the physics step from another
    configuration of its framework.

    Args:
        paths: Files and folders, as the user names them.
        versions: What configurations are written for; None: nobody says.
    """
    from actspec.readings.pair import pair
    from actspec.readings.read import PendingFiles

    with PendingFiles(paths, keep_matrices=False) as pending:
        readings = pending.finish()
    artifacts = tuple(artifact for reading in readings for artifact in reading.artifacts)
    robots = tuple(
        LiftedRobot(robot.name, _parts([artifacts[index] for index in robot.artifacts], versions))
        for robot in pair(artifacts)
    )
    return LiftedFiles(readings, robots)


def _parts(artifacts: Sequence[Artifact], versions: Versions | None) -> tuple[Lifted, ...]:
    parts = []
    for artifact in artifacts:
        partners = [other for other in artifacts if other is not artifact]
        if artifact.config is None:
            parts.append(lift(artifact))
        else:
            joints = _joints_for(artifact, partners)
            parts.append(lift(artifact, joints, versions=versions, physics_dt=_step_for(artifact, partners)))
    return tuple(parts)


def _joints_for(artifact: Artifact, partners: Sequence[Artifact]) -> Sequence[JointView | str] | None:
    """The joints of the best robot file, else those that another file names; None: no file does."""
    from actspec.readings.config_figures import models_of
    from actspec.readings.pair import joint_names

    config = artifact.config
    assert config is not None
    for model in models_of(config, partners):
        if model.robot is not None and model.robot.joints:
            return model.robot.joints
    return next((names for names in map(joint_names, partners) if names), None)


def _step_for(artifact: Artifact, partners: Sequence[Artifact]) -> float | None:
    """The physics step that another configuration of the same framework states [s]."""
    assert artifact.config is not None
    steps = [
        other.config.physics_dt
        for other in partners
        if other.config is not None and other.config.framework is artifact.config.framework
    ]
    return next((step for step in steps if step is not None), None)
