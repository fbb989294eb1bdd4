"""Configurations whose drives stand in a file that is not read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from actspec.diagnostics import Collector, Diagnostic, one_line
from actspec.readings.artifact import Artifact, RobotConfig

_DRIVES = "actuators"
_ROBOTS = ("robot", "robot_cfg", "scene")
"""Fields of an environment that have its robot."""


def with_drives(parts: Sequence[Artifact]) -> list[Artifact]:
    """A robot whose actuators are not known gets those of the one other file that has drives and no robot.

    Args:
        parts: What the files have of one robot.
    """
    lacking = [part for part in parts if part.config is not None and any(_unread(part.config, (_DRIVES,)))]
    having = [part for part in parts if part.config is not None and part.config.groups]
    if len(lacking) != 1 or len(having) != 1:
        return list(parts)
    (robot,), (drives,) = lacking, having
    mine, theirs = robot.config, drives.config
    assert mine is not None and theirs is not None
    if theirs.framework is not mine.framework or theirs.settings:
        return list(parts)
    notes = tuple(note for note in mine.notes if note not in _unread(mine, (_DRIVES,)))
    whole = replace(robot, config=replace(mine, groups=theirs.groups, notes=(*notes, *theirs.notes)))
    return [whole if part is robot else part for part in parts if part is not drives]


def check_drives(parts: Sequence[Artifact], driven: bool, out: Collector) -> None:
    """Without its drives a configuration makes no spec: what is left would be motors whose gains are the caller's.

    Args:
        parts: What the files have of one robot.
        driven: Whether a robot file among them has gains of its own.
        out: Gets an error for each configuration.
    """
    if any(part.config is not None and part.config.groups for part in parts):
        return
    for part in parts:
        fields = (_DRIVES,) if driven else (_DRIVES, *_ROBOTS)
        notes = [] if part.config is None else list(_unread(part.config, fields))
        for note in notes[:1]:
            are = "are" if note.where.startswith(_DRIVES) else "is"
            it = "the file that has them" if are == "are" else "the robot's configuration"
            help = f"name {it} too" if _is_elsewhere(note) else f"write {note.where} out"
            alone = ", or leave this file out" if len(parts) > 1 else ""
            message = f"{one_line(part.name)}: its {note.where} {are} {note.message}"
            out.error("DRF002", message, span=note.span, help=help + alone)


def _is_elsewhere(note: Diagnostic) -> bool:
    return " comes from " in note.message


def _unread(config: RobotConfig, fields: tuple[str, ...]) -> Iterator[Diagnostic]:
    """The notes that some of its fields are not known, of a configuration without drives."""
    if not config.groups:
        yield from (note for note in config.notes if (note.where or "").split(".")[0] in fields)
