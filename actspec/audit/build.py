"""From files to the case that the rules judge: readings, ledger rows, and which artifacts are one robot."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace

from actspec.audit.case import Case
from actspec.audit.other_variants import with_other_variants
from actspec.readings.artifact import Artifact, FileKind, FileReading, Robot
from actspec.readings.ledger import LedgerRow
from actspec.readings.versions import Versions, meant_for
from actspec.spec.variants import named, split


def case_of(
    readings: Sequence[FileReading],
    versions: Versions,
    options: Mapping[str, Mapping[str, float]],
    spec: str | None = None,
    *,
    whole: bool = False,
    joints: Sequence[str] = (),
) -> Case:
    """Put together what the rules judge.

    Args:
        readings: Every file that was named.
        versions: What the files are meant for.
        options: Rule code to its options.
        spec: The spec that the other files are held to. Where its own model is not at hand, it is fitted to the
            first robot among the files that it fits.
        whole: As in `rows_of_config`.
        joints: Likewise.
    """
    from actspec.readings.pair import pair

    readings = tuple(_fitted(reading, readings) if reading.path == spec else reading for reading in readings)
    models = frozenset().union(*(_models_of(one) for reading in readings for one in reading.artifacts))
    readings = tuple(_with_variants(reading, models) for reading in readings)
    artifacts = tuple(artifact for reading in readings for artifact in reading.artifacts)
    in_folder = [reading.in_folder for reading in readings for _ in reading.artifacts]
    by_hand = frozenset(index for index, met in enumerate(in_folder) if not met)
    recorded = [reading.record for reading in readings for _ in reading.artifacts]
    records = frozenset(index for index, record in enumerate(recorded) if record)
    paired = (
        part for robot in pair(artifacts, spec, by_hand, records) for part in _by_variant(robot, artifacts)
    )
    robots = tuple(sorted(paired, key=lambda robot: robot.artifacts))
    rows = _rows(artifacts, robots, versions, whole, joints)
    artifacts = with_other_variants(artifacts, robots, rows)
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


def _with_variants(reading: FileReading, models: Collection[str]) -> FileReading:
    """A spec with those of its variants that are of another model, where that is among the files: the first of each."""
    own = next((artifact.spec for artifact in reading.artifacts if artifact.spec is not None), None)
    told = any(b"variants" in file.data for file in reading.files)
    if own is None or not told or split(reading.path)[1] is not None:
        return reading
    from actspec.audit.read import artifact_of, resolved
    from actspec.diagnostics import ActspecError
    from actspec.robot.load import find_model
    from actspec.spec.validate import load_spec

    seen: set[str] = set()
    found = []
    try:
        names = (None, *load_spec(reading.path).model.variants)
    except ActspecError:
        # It was changed since it was read.
        return reading
    for name in names:
        path = named(reading.path, name)
        try:
            model = find_model(load_spec(path).model.robot.model, os.path.dirname(path))
            if os.path.realpath(model) in seen:
                continue
            seen.add(os.path.realpath(model))
            if name is not None and os.path.realpath(model) in models:
                found.append(replace(artifact_of(path, resolved(path)), model=model))
        except ActspecError:
            # Nothing is held to a variant that is wrong, which `validate` tells.
            continue
    return replace(reading, artifacts=(*reading.artifacts, *found))


def _by_variant(robot: Robot, artifacts: Sequence[Artifact]) -> Iterator[Robot]:
    """A robot, what is of another variant's model apart: it is held to that one."""
    rest = robot.artifacts
    for index in robot.artifacts:
        variant = artifacts[index]
        if variant.model is None:
            continue
        own = os.path.realpath(variant.model)
        apart = tuple(one for one in rest if one == index or own in _models_of(artifacts[one]))
        rest = tuple(one for one in rest if one not in apart)
        yield Robot(variant.spec.title if variant.spec is not None else robot.name, apart)
    if rest:
        yield replace(robot, artifacts=rest)


def _models_of(artifact: Artifact) -> frozenset[str]:
    files = () if artifact.robot is None else artifact.robot.files
    return frozenset(os.path.realpath(file.path) for file in files)


def _rows(
    artifacts: Sequence[Artifact],
    robots: Sequence[Robot],
    versions: Versions,
    whole: bool,
    joints: Sequence[str],
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
            target = meant_for(versions, artifact)
            rows += rows_of_config(artifact, index, partners, target, whole=whole, joints=joints)
    return tuple(rows)
