"""Whose angle a range of an MJCF is in: the file's own, or that of what includes it."""

from __future__ import annotations

import os
from dataclasses import replace

from actspec.audit.rule import Case, Confidence, Finding, Severity
from actspec.audit.rules.actuator_texts import compiler_of
from actspec.diagnostics import Span
from actspec.readings.artifact import Artifact, FileKind, without_comments


def unless(is_part: bool) -> str:
    """What includes, mounts or loads a part has the angle."""
    return ", unless what includes or loads it has the angle" if is_part else ""


def of_a_part(found: Finding) -> Finding:
    """The same of a part, whose joints are in degrees or radians as its includer has it: a note without a fix."""
    return replace(found, severity=Severity.INFO, confidence=Confidence.LOW, fix=None)


def graded(case: Case, found: Finding, artifact: Artifact) -> Finding:
    """By what the file is: to a whole robot without `<compiler>` a program may add one, as safety-gymnasium does."""
    if is_of_a_part(case, artifact, found.span):
        return of_a_part(found)
    may_be = artifact.may_be_part and _is_own(artifact, found.span)
    return replace(found, confidence=Confidence.MEDIUM) if may_be else found


def is_of_a_part(case: Case, artifact: Artifact, place: Span) -> bool:
    """Whether what includes or loads a model may have the angle of a range that is written at a place."""
    elsewhere = os.path.dirname(artifact.path) in case.once(_folders_of_parts)
    elsewhere = elsewhere or "angle" in case.written(Span(artifact.path), "")
    is_part = artifact.is_part or (elsewhere and not artifact.states(b"angle="))
    return is_part and _is_own(artifact, place)


def _folders_of_parts(case: Case) -> frozenset[str]:
    """Folders of files without an angle that models of other folders include, and read in radians."""
    return frozenset(
        os.path.dirname(part.path)
        for _, artifact in case.of_kind(FileKind.MJCF)
        if artifact.robot is not None and artifact.states(b"radian")
        for part in artifact.robot.files
        if os.path.dirname(part.path) != os.path.dirname(artifact.path)
        if b"angle=" not in without_comments(part.data)
    )


def _is_own(artifact: Artifact, place: Span) -> bool:
    """Whether a place is in a model itself, and not in one that it attaches, which has its own angle.

    Measured with MuJoCo 4.0.0: in degrees where it states none, whatever attaches it or includes what does.
    """
    return artifact.robot is None or any(file.path == place.path for file in artifact.robot.files)


def lacks_angle(case: Case, index: int, part: str) -> tuple[Span, str]:
    """Where a model lacks the angle of a part that it includes, and that in words, with a model that has it."""
    place, angle = compiler_of(case, index)
    what = f'the angle is "{angle}"' if angle else "no angle is stated"
    others = (other for at, other in case.of_kind(FileKind.MJCF) if at != index)
    right = (one.path for one in others if one.states(b"radian") and data_of(one, part) is not None)
    beside = next((f", as {path} reads them" for path in right), "")
    return place, f"{what}, so MuJoCo takes the ranges of {part} for degrees: they are radians{beside}"


def data_of(artifact: Artifact, path: str) -> bytes | None:
    """The text of a file that a model includes, or of its own; None: it does not."""
    files = () if artifact.robot is None else artifact.robot.files
    return next((file.data for file in files if file.path == path), None)
