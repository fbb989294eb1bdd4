"""Files for the audit: as `readings` has them, specs loaded and fitted to the robots that they name."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import replace

from actspec.diagnostics import ActspecError
from actspec.ir import ActuatorSet
from actspec.readings import read
from actspec.readings.artifact import Artifact, FileKind, FileReading
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


def read_file(path: str, keep_matrices: bool = False, refusal: str | None = None) -> FileReading:
    """Read one file, here and now; see `readings.read.read_file`. A spec is resolved on its robot."""
    reading = read.read_file(path, keep_matrices, refusal)
    if reading.kind is not FileKind.SPEC:
        return reading
    try:
        actuators = resolved(path)
    except ActspecError as err:
        return replace(reading, reason=read.reason_of(err.diagnostics, path), diagnostics=err.diagnostics)
    return replace(reading, artifacts=(artifact_of(path, actuators),), diagnostics=actuators.diagnostics)


def pending_files(
    paths: Sequence[str],
    *,
    keep_matrices: bool | None = None,
    skip_other: bool = False,
    jobs: int | None = None,
    exclude: Callable[[str, bool], bool] | None = None,
) -> read.PendingFiles:
    """Begin to read files; see `readings.read.PendingFiles`. Specs are resolved."""
    return read.PendingFiles(
        paths, keep_matrices=keep_matrices, skip_other=skip_other, jobs=jobs, read=read_file, exclude=exclude
    )


def read_files(
    paths: Sequence[str],
    *,
    keep_matrices: bool | None = None,
    jobs: int | None = None,
    skip_other: bool = False,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[FileReading, ...]:
    """Read files and wait for them; the arguments are those of `PendingFiles` and its `finish`."""
    with pending_files(paths, keep_matrices=keep_matrices, jobs=jobs, skip_other=skip_other) as pending:
        return pending.finish(progress)
