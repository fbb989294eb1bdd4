"""The variants of a spec beside that as which it is read: a file that departs from it may be of one of them."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from actspec.ir import ActuatorSet
from actspec.readings.artifact import Artifact, Robot
from actspec.readings.ledger import LedgerRow
from actspec.spec.variants import named, split

TELLING = ("effort_limit", "armature", "velocity_limit", "kp", "kd")
"""Figures by which variants are told: those of the motors first, of which the gains are made."""

SAME = 0.01
"""Chosen: figures that agree so far are one, as SPC101's `tolerance`."""


def is_same(one: float | None, other: float | None) -> bool:
    """Whether two figures are one; what is not stated is none."""
    return one is not None and other is not None and math.isclose(one, other, rel_tol=SAME)


def with_other_variants(
    artifacts: Sequence[Artifact], robots: Sequence[Robot], rows: Sequence[LedgerRow]
) -> tuple[Artifact, ...]:
    """The artifacts, a spec with its other variants where a file of its robot departs in what may tell one.

    Each takes as long to resolve as the spec did: a file that agrees asks for none.

    Args:
        artifacts: Of a case.
        robots: Which of them are one robot.
        rows: Of all of them.
    """
    return tuple(
        replace(artifact, variants=tuple(_others(artifact.path, artifact.spec)))
        if artifact.spec is not None and _is_departed_from(index, artifacts, robots, rows)
        else artifact
        for index, artifact in enumerate(artifacts)
    )


def _is_departed_from(
    index: int, artifacts: Sequence[Artifact], robots: Sequence[Robot], rows: Sequence[LedgerRow]
) -> bool:
    beside = next(robot.artifacts for robot in robots if index in robot.artifacts)
    files = {other for other in beside if artifacts[other].spec is None}
    own = {row.joint: row for row in rows if row.artifact == index} if files else {}
    return any(
        field in row.stated & own[row.joint].stated
        and not is_same(getattr(row, field), getattr(own[row.joint], field))
        for row in rows
        if row.artifact in files and row.joint in own
        for field in TELLING
    )


def _others(path: str, spec: ActuatorSet) -> Iterator[tuple[str, ActuatorSet]]:
    from actspec.audit.read import resolved
    from actspec.diagnostics import ActspecError
    from actspec.spec.validate import load_spec

    file = split(path)[0]
    try:
        model = load_spec(file).model
    except ActspecError:
        # It was changed since it was read.
        return
    joints = {actuator.joint for actuator in spec.joints}
    for name in (model.variant, *model.variants):
        if name == spec.variant:
            continue
        try:
            found = resolved(named(file, name))
        except ActspecError:
            # No file is told to be of a variant that is wrong, which `validate` tells.
            continue
        if {actuator.joint for actuator in found.joints} == joints:
            yield name or "", found
