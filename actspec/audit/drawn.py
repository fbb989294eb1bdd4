"""What events of an environment draw of a robot: figures that nobody runs with, and ranges that a program changes."""

from __future__ import annotations

from typing import TYPE_CHECKING

from actspec.diagnostics import Span
from actspec.readings.artifact import FileKind, Framework, RandomizedRange, RobotConfig
from actspec.readings.joint_names import matching
from actspec.readings.ledger import LedgerRow

if TYPE_CHECKING:
    from collections.abc import Iterator

    from actspec.audit.case import Case

_WRITTEN = {
    "kp": "gains",
    "kd": "gains",
    "armature": "armatures",
    "effort_limit": "efforts",
    "friction": "friction",
    "joint_damping": "damping",
}
"""Field of a range to what it writes over (`readings/written_over.py`)."""

_OF_THE_MODEL = frozenset({"armatures", "friction", "damping"})
"""Those that a joint of a model has, too."""

_AT_FIRST = ("", "prestartup", "startup", "reset")
"""Modes of events that draw before the first step."""


def set_otherwise(case: Case) -> frozenset[Span]:
    """Places of ranges whose event a program of the folder takes away, or gives other figures."""
    written = {file.path: file.written for file in case.files}
    return frozenset(
        one.span for _, one in _ranges(case) if f"events.{one.event}" in written.get(one.span.path, ())
    )


def drawn_anew(case: Case) -> dict[tuple[str, str], frozenset[str]]:
    """Files and joints, with what an event draws anew of them, whatever the file says (operation `abs`)."""
    found: dict[tuple[str, str], frozenset[str]] = {}
    left_out = case.once(set_otherwise)
    for index, one in _ranges(case):
        name = _WRITTEN.get(one.field)
        if one.operation != "abs" or name is None or one.when not in _AT_FIRST or one.span in left_out:
            continue
        for joint in {row.joint for row in rows_in(case, index, one)}:
            for other in case.robot_of(index).artifacts:
                if name in _OF_THE_MODEL or case.artifacts[other].kind is FileKind.CFG:
                    for row in case.joints.get((other, joint), ()):
                        for path in {row.file, *(place.path for place in row.places.values())}:
                            found[path, joint] = found.get((path, joint), frozenset()) | {name}
    return found


def _ranges(case: Case) -> Iterator[tuple[int, RandomizedRange]]:
    """Ranges of all configurations."""
    for index, artifact in case.of_kind(FileKind.CFG):
        for one in artifact.config.randomize if artifact.config is not None else ():
            yield index, one


def rows_in(case: Case, artifact: int, one: RandomizedRange) -> list[LedgerRow]:
    """Rows of the configuration whose joints a range takes.

    Where it has no actuators, those of the robot's configuration for the same framework, of its spec, or, for mjlab,
    whose ranges act on it, of its MJCF. Without a model a row stands for a pattern, which is in the range when the
    range's pattern matches its text.
    """
    config = case.artifacts[artifact].config
    assert config is not None
    rows = _rows(case, artifact, config)
    if one.joints is None:
        return list(rows)
    names = [row.joint for row in rows]
    inside = {name for pattern in one.joints for name in matching(config.framework, pattern, names)}
    return [row for row in rows if row.joint in inside or row.joint in one.joints]


def _rows(case: Case, artifact: int, config: RobotConfig) -> tuple[LedgerRow, ...]:
    if config.groups:
        return case.rows_of(artifact)
    others = case.robot_of(artifact).artifacts
    for kind in (FileKind.CFG, FileKind.SPEC, FileKind.MJCF):
        for other in others:
            found = case.artifacts[other]
            same = found.config is None or found.config.framework is config.framework
            acts = kind is not FileKind.MJCF or config.framework is Framework.MJLAB
            if found.kind is kind and same and acts and case.rows_of(other):
                return case.rows_of(other)
    return ()
