"""Files for the audit: as `readings` has them, specs loaded and fitted to the robots that they name."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

from actspec import files
from actspec.diagnostics import ActspecError
from actspec.ir import ActuatorSet
from actspec.readings import named, read
from actspec.readings.artifact import Artifact, FileKind, FileReading
from actspec.readings.networks import networks_of
from actspec.robot.view import ModelFile, RobotView


def resolved(path: str, robot: RobotView | None = None) -> ActuatorSet:
    """What a spec means on its robot.

    Args:
        path: Of the spec.
        robot: Another robot than the one that it names.

    Raises: SpecError, RobotError, ResolveError: with every error of the stage.
    """
    from actspec.resolution import resolve
    from actspec.robot.load import robot_of
    from actspec.spec.validate import load_spec

    spec = load_spec(path)
    return resolve(spec, robot_of(spec) if robot is None else robot)


def artifact_of(path: str, actuators: ActuatorSet) -> Artifact:
    """A resolved spec as the audit has it, with what is known of its networks.

    Args:
        path: Of the spec.
        actuators: What it means.
    """
    return Artifact(path, FileKind.SPEC, actuators.robot, spec=actuators, networks=networks_of(actuators))


def read_file(path: str, keep_matrices: bool = False, refusal: str | None = None) -> FileReading:
    """Read one file, here and now; see `readings.read.read_file`. A spec is resolved on its robot."""
    reading = read.read_file(path, keep_matrices, refusal)
    if reading.kind is not FileKind.SPEC:
        return reading
    reading = replace(reading, files=(*reading.files, *_included(path, reading.files)))
    try:
        actuators = resolved(path)
    except ActspecError as err:
        return replace(read.unreadable(path, reading.kind, err.diagnostics), files=reading.files)
    return replace(reading, artifacts=(artifact_of(path, actuators),), diagnostics=actuators.diagnostics)


def _included(path: str, own: Sequence[ModelFile]) -> Iterator[ModelFile]:
    """What a spec includes; nothing of one that cannot be read, which is told where it is resolved."""
    if not any(b"include" in file.data for file in own):
        return
    from actspec.spec.document import load_document
    from actspec.spec.yaml_text import MAX_BYTES

    try:
        for name in load_document(path).includes:
            part = os.path.normpath(os.path.join(os.path.dirname(path), name))
            yield ModelFile(part, name, files.read_regular(part, MAX_BYTES))
    except (ActspecError, *files.FAULTS):
        return


def read_file_changed(
    changed: Mapping[str, bytes], path: str, keep_matrices: bool = False, refusal: str | None = None
) -> FileReading:
    """`read_file` as it would be after changes; see `files.changed`."""
    with files.changed(changed):
        return read_file(path, keep_matrices, refusal)


def pending_files(
    paths: Sequence[str],
    *,
    changed: Mapping[str, bytes] | None = None,
    keep_matrices: bool | None = None,
    skip_other: bool = False,
    jobs: int | None = None,
    exclude: Callable[[str, bool], bool] | None = None,
) -> named.PendingFiles:
    """Begin to read files; see `readings.named.PendingFiles`. Specs are resolved.

    `changed` are files as they would be, by real path.
    """
    reader = partial(read_file_changed, changed) if changed else read_file
    return named.PendingFiles(
        paths, keep_matrices=keep_matrices, skip_other=skip_other, jobs=jobs, read=reader, exclude=exclude
    )


def read_files(
    paths: Sequence[str],
    *,
    keep_matrices: bool | None = None,
    jobs: int | None = None,
    skip_other: bool = False,
    exclude: Callable[[str, bool], bool] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[FileReading, ...]:
    """Read files and wait for them; the arguments are those of `PendingFiles` and its `finish`."""
    with pending_files(
        paths, keep_matrices=keep_matrices, jobs=jobs, skip_other=skip_other, exclude=exclude
    ) as pending:
        return pending.finish(progress)
