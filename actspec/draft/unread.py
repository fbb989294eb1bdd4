"""Configurations whose drives stand in a file that is not read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

from actspec.diagnostics import Collector, Diagnostic, Severity, one_line
from actspec.draft.environment import is_environment, written_once
from actspec.lift import lift
from actspec.readings.artifact import Artifact, Framework, RobotConfig

_DRIVES = "actuators"
_ROBOTS = ("robot", "robot_cfg", "scene")
"""Fields of an environment that have its robot."""


def with_drives(parts: Sequence[Artifact]) -> list[Artifact]:
    """A robot whose actuators are not known gets those of the one other file that has drives and no robot.

    Of a file whose drives a robot imports that is the robot's part alone.

    Args:
        parts: What the files have of one robot.
    """
    parts = [part for part in parts if not any(_imports(other, part) for other in parts)]
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


def _imports(robot: Artifact, drives: Artifact) -> bool:
    """Whether a configuration is a robot whose drives are all of those of another file, which has nothing else."""
    mine, theirs = robot.config, drives.config
    if mine is None or theirs is None or theirs.settings or robot.path == drives.path:
        return False
    if not mine.settings or is_environment(mine):
        return False
    return written_once(mine, theirs)


def check_drives(parts: Sequence[Artifact], out: Collector) -> None:
    """Without its drives a configuration makes no spec: what is left would be motors whose gains are the caller's.

    Args:
        parts: What the files have of one robot.
        out: Gets an error for each configuration.
    """
    configs = [(part.name, part.config) for part in parts if part.config is not None]
    if not configs or any(config.groups for _, config in configs):
        return
    fields = (_DRIVES,) if any(map(_has_gains, parts)) else (_DRIVES, *_ROBOTS)
    alone = ", or leave this file out" if len(parts) > 1 else ""
    for name, config in configs:
        for note in list(_unread(config, fields))[:1]:
            drives = note.where.startswith(_DRIVES)
            missing = "the file that has them" if drives else "the robot's configuration"
            is_elsewhere = note.where in config.elsewhere
            help = f"name {missing} too" if is_elsewhere else f"write {note.where} out"
            message = f"{one_line(name)}: its {note.where} {'are' if drives else 'is'} {note.message}"
            out.error("DRF002", message, span=note.span, help=help + alone)
    trained = [one for one in configs if one[1].framework in (Framework.ISAACLAB, Framework.MJLAB)]
    if len(trained) == len(parts) and not any(item.severity is Severity.ERROR for item in out):
        _without_robot(trained, out)


def _without_robot(configs: Sequence[tuple[str, RobotConfig]], out: Collector) -> None:
    """Environments whose robot stands nowhere; of several the one that says who sets it."""
    name, config = next((one for one in configs if one[1].robot_missing is not None), configs[0])
    if config.robot_missing is not None:
        message = "its robot is MISSING: an environment that is derived from it sets it"
        help = "name the file of that environment, or the robot's configuration too"
    else:
        message = "it has no robot, and so no joints"
        help = "name the robot's configuration too, or the environment that has it"
    out.error("DRF002", f"{one_line(name)}: {message}", span=config.robot_missing or config.span, help=help)


def _has_gains(part: Artifact) -> bool:
    """Whether a robot file has servos: their gains are a drive."""
    if part.robot is None:
        return False
    return any(joint.kp is not None and joint.kp.known for joint in lift(part).actuators.joints)


def _unread(config: RobotConfig, fields: tuple[str, ...]) -> Iterator[Diagnostic]:
    """The notes that some of its fields are not known, of a configuration without drives."""
    if not config.groups:
        yield from (note for note in config.notes if (note.where or "").split(".")[0] in fields)
