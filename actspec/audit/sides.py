"""From two files to what is different between the robots in them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from actspec.audit.build import case_of
from actspec.audit.case import Case
from actspec.audit.difference import Difference, difference
from actspec.audit.dynamics import dynamics_of
from actspec.audit.read import read_files
from actspec.diagnostics import AuditError, Collector, Diagnostic, Severity, Span, listed, one_line
from actspec.readings.artifact import FileReading
from actspec.readings.versions import Versions


def differences(
    old: str,
    new: str,
    versions: Versions,
    robot: str | None = None,
    texts: Mapping[str, str] | None = None,
) -> tuple[Difference, ...]:
    """What is different between two files, robot by robot.

    Args:
        old: The file before.
        new: The file after.
        versions: What the files are meant for.
        robot: Only the robot of this name, where a file has several; None: all.
        texts: Path to what the user called it, for messages.

    Raises: AuditError: a file cannot be read, or nobody can tell which robots of two files are one.
    """
    readings = read(tuple(dict.fromkeys((old, new))), texts or {})
    case = case_of(readings, versions, {})
    sides = tuple([i for i, a in enumerate(case.artifacts) if a.path == path] for path in (old, new))
    pairs = _pairs(
        case, sides[0], sides[1], robot, tuple((texts or {}).get(path, path) for path in (old, new))
    )
    return tuple(difference(dynamics_of(case, one), dynamics_of(case, other)) for one, other in pairs)


def read(paths: Sequence[str], texts: Mapping[str, str]) -> tuple[FileReading, ...]:
    """Read files of which each must be readable.

    Args:
        paths: Files.
        texts: Path to what the user called it.

    Raises: AuditError: one of them is not.
    """
    import os

    out = Collector()
    for path in paths:
        if os.path.isdir(path):
            out.error("DIF001", "is a folder: name the files", span=Span(texts.get(path, path)))
    out.raise_if_failed(AuditError)
    readings = read_files(paths)
    for reading in readings:
        shown = texts.get(reading.path, reading.path)
        if not reading.readable:
            reason = reading.reason or ""
            for path, text in texts.items():
                reason = reason.replace(path, text)
            out.error("DIF001", f"cannot be read: {one_line(reason)}", span=Span(shown))
        elif not reading.artifacts:
            out.error("DIF001", "describes no robot", span=Span(shown))
    out.raise_if_failed(AuditError)
    return readings


def _pairs(
    case: Case, old: list[int], new: list[int], robot: str | None, texts: tuple[str, ...]
) -> list[tuple[int, int]]:
    """Which robots of two files are one: by name, or because there is one only."""
    if robot is not None:
        old, new = (_named(case, side, robot, text) for side, text in zip((old, new), texts, strict=True))
    if len(old) == len(new) == 1:
        return [(old[0], new[0])]
    names = {case.artifacts[i].name: i for i in new}
    pairs = [(i, names[case.artifacts[i].name]) for i in old if case.artifacts[i].name in names]
    if pairs:
        return pairs
    # One robot beside several: the one that its joints and its name belong to.
    for few, many in ((old, new), (new, old)):
        if len(few) == 1:
            fitting = [i for i in many if i in case.robot_of(few[0]).artifacts]
            if len(fitting) == 1:
                return [(few[0], fitting[0]) if few is old else (fitting[0], few[0])]
    found = "; ".join(
        f"{one_line(text)} has {listed(one_line(case.artifacts[i].name) for i in side)}"
        for side, text in zip((old, new), texts, strict=True)
    )
    message = f"nobody can tell which robots are one: {found}"
    raise AuditError([Diagnostic("DIF003", Severity.ERROR, message, "", None, "name one with --robot NAME")])


def _named(case: Case, side: list[int], robot: str, text: str) -> list[int]:
    """The robot of that name; the only one of a file has any."""
    found = [i for i in side if case.artifacts[i].name == robot]
    if found or len(side) == 1:
        return found or side
    names = listed(one_line(case.artifacts[i].name) for i in side)
    message = f"has no robot {robot!r}"
    raise AuditError([Diagnostic("DIF003", Severity.ERROR, message, "", Span(text), f"it has {names}")])
