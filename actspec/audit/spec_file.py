"""A spec for the audit: loaded, and fitted to the robot that it names."""

from __future__ import annotations

import os
from dataclasses import replace

from actspec.ir import ActuatorSet
from actspec.readings.artifact import Artifact, FileKind
from actspec.readings.networks import networks_of
from actspec.robot.view import RobotView


def resolved(path: str) -> ActuatorSet:
    """What a spec means on its robot.

    Args:
        path: Of the spec.

    Raises: SpecError, RobotError, ResolveError: with every error of the stage.
    """
    from actspec.diagnostics import RobotError
    from actspec.resolution import resolve
    from actspec.robot.load import find_model, listed_robot, load_robot
    from actspec.spec.validate import load_spec

    spec = load_spec(path)
    model = spec.model.robot.model
    if model == "none":
        return resolve(spec, listed_robot(spec))
    try:
        robot = load_robot(find_model(model, os.path.dirname(path)))
    except RobotError as err:
        place = spec.span("robot", "model")
        raise RobotError(
            item if item.span is not None else replace(item, span=place) for item in err.diagnostics
        ) from err
    return resolve(spec, robot)


def artifact_of(path: str, actuators: ActuatorSet) -> Artifact:
    """A resolved spec as the audit has it, with what is known of its networks.

    Args:
        path: Of the spec.
        actuators: What it means.
    """
    return Artifact(path, FileKind.SPEC, actuators.robot, spec=actuators, networks=networks_of(actuators))


def resolved_on(path: str, robot: RobotView) -> ActuatorSet:
    """What a spec means on another robot than the one that it names.

    Args:
        path: Of the spec.
        robot: That robot.

    Raises: SpecError, ResolveError: the spec is wrong, or does not fit.
    """
    from actspec.resolution import resolve
    from actspec.spec.validate import load_spec

    return resolve(load_spec(path), robot)
