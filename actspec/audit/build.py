"""From files to the case that the rules judge: readings, ledger rows, and which artifacts are one robot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from actspec.audit.case import Case
from actspec.readings.artifact import Artifact, FileKind, FileReading, Robot
from actspec.readings.ledger import LedgerRow
from actspec.readings.versions import Versions, meant_for


def case_of(
    readings: Sequence[FileReading],
    versions: Versions,
    options: Mapping[str, Mapping[str, float]],
    spec: str | None = None,
) -> Case:
    """Put together what the rules judge.

    Args:
        readings: Every file that was named.
        versions: What the files are meant for.
        options: Rule code to its options.
        spec: The spec that the other files are held to. Where its own model is not at hand, it is fitted to the
            first robot among the files that it fits.
    """
    from actspec.readings.pair import pair

    readings = tuple(_fitted(reading, readings) if reading.path == spec else reading for reading in readings)
    artifacts = tuple(artifact for reading in readings for artifact in reading.artifacts)
    robots = pair(artifacts, spec)
    rows = _rows(artifacts, robots, versions)
    return Case(tuple(readings), artifacts, rows, robots, versions, options)


def _fitted(reading: FileReading, readings: Sequence[FileReading]) -> FileReading:
    """A spec whose own robot could not be read, on another one."""
    if reading.kind is not FileKind.SPEC or reading.artifacts:
        return reading
    from actspec.audit.read import artifact_of, resolved
    from actspec.diagnostics import ActspecError

    for robot in (artifact.robot for other in readings for artifact in other.artifacts):
        if robot is None:
            continue
        try:
            actuators = resolved(reading.path, robot)
        except ActspecError:
            continue
        artifact = artifact_of(reading.path, actuators)
        return FileReading(
            reading.path, FileKind.SPEC, None, (artifact,), reading.files, actuators.diagnostics
        )
    return reading


def _rows(
    artifacts: Sequence[Artifact], robots: Sequence[Robot], versions: Versions
) -> tuple[LedgerRow, ...]:
    from actspec.readings.config import rows_of_config
    from actspec.readings.ledger import rows_of_robot, rows_of_spec

    rows: list[LedgerRow] = []
    for index, artifact in enumerate(artifacts):
        if artifact.robot is not None:
            rows += rows_of_robot(artifact, index)
        elif artifact.spec is not None:
            rows += rows_of_spec(artifact, index)
        else:
            members = next((robot.artifacts for robot in robots if index in robot.artifacts), ())
            partners = tuple(artifacts[other] for other in members if other != index)
            rows += rows_of_config(artifact, index, partners, meant_for(versions, artifact))
    return tuple(rows)
