"""Which robots of two files are one."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from actspec.audit.case import Case
from actspec.diagnostics import AuditError, Span, listed, one_line, shortened
from actspec.readings.artifact import FileReading, RobotConfig


def one_robot(case: Case, spec: int, other: int, robot: str | None) -> tuple[int, int]:
    """Which robot of a spec and of a file, both at the beginning of a case, are one.

    Args:
        case: The spec, the file, and what else describes the robot.
        spec: How many artifacts the spec has.
        other: How many the file has.
        robot: As in `compare_files`, which the readings are taken of by `of_robot`.

    Raises: AuditError: it is not known which.
    """
    ours, theirs = list(range(spec)), list(range(spec, spec + other))
    texts = (case.artifacts[ours[0]].path, case.artifacts[theirs[0]].path)
    return pairs_of(case, ours, theirs, robot, texts, "robot='NAME'")[0]


def of_robot(readings: Sequence[FileReading], robot: str | None) -> tuple[FileReading, ...]:
    """Readings, without the other robots of files that have one of this name.

    Which model's joints a pattern means is known for the only configuration of a file.
    """
    own = [tuple(one for one in reading.artifacts if one.name == robot) for reading in readings]
    return tuple(
        replace(reading, artifacts=found or reading.artifacts)
        for reading, found in zip(readings, own, strict=True)
    )


def pairs_of(
    case: Case, old: list[int], new: list[int], robot: str | None, texts: tuple[str, ...], how: str
) -> list[tuple[int, int]]:
    """Which robots of two files are one: by name, or because there is one only; `how` a user says which."""
    has = "; ".join(
        f"{one_line(text)} has {listed(shortened(case.artifacts[i].name) for i in indices)}"
        for indices, text in zip((old, new), texts, strict=True)
    )
    if robot is not None:
        old, new = (_named(case, found, robot, text) for found, text in zip((old, new), texts, strict=True))
        if all(case.artifacts[i].name != robot for i in (*old, *new)):
            raise AuditError.of("DIF003", f"no robot is called {robot!r}: {has}")
    if len(old) == len(new) == 1:
        return [(old[0], new[0])]
    ours, theirs = (
        dict(zip(called(case.artifacts[i].name for i in side), side, strict=True)) for side in (old, new)
    )
    pairs = [(i, theirs[name]) for name, i in ours.items() if name in theirs]
    if pairs:
        return pairs
    old, new = _as_one(case, old), _as_one(case, new)
    if len(old) == len(new) == 1:
        return [(old[0], new[0])]
    # One robot beside several: the one that its joints and its name belong to.
    for few, many in ((old, new), (new, old)):
        if len(few) == 1:
            fitting = _as_one(case, [i for i in many if i in case.robot_of(few[0]).artifacts])
            if len(fitting) == 1:
                return [(few[0], fitting[0]) if few is old else (fitting[0], few[0])]
    raise AuditError.of(
        "DIF003", f"it is not known which robots are the same: {has}", help=f"name one with {how}"
    )


def _as_one(case: Case, side: list[int]) -> list[int]:
    """The fullest of a file's configurations where all say the same, as far as they speak; else all.

    A task of Isaac Lab has its robot in its scene, and is the robot with steps, scale of the action and ranges.
    """
    configs = {index: config for index in side if (config := case.artifacts[index].config) is not None}
    if len(configs) < max(2, len(side)):
        return side
    fullest = max(configs, key=lambda index: len(_said(configs[index])))
    if all(_is_within(configs[index], configs[fullest]) for index in side):
        return [fullest]
    return side


def _is_within(part: RobotConfig, whole: RobotConfig) -> bool:
    """Whether a configuration has the groups of another one, and either all of the task's words or none."""
    ours, theirs = _said(part), _said(whole)
    if part.framework is not whole.framework or _groups(part) != _groups(whole):
        return False
    same = all(theirs.get(name, told) == told for name, told in ours.items())
    return same and (ours.keys() == theirs.keys() or not any(map(_is_of_a_task, ours)))


def _is_of_a_task(name: str) -> bool:
    return name.startswith(("range ", "actions.")) or name in ("physics_dt", "decimation", "action_scale")


def _said(config: RobotConfig) -> dict[str, object]:
    """What a configuration says beside its groups, without places."""
    settings = (*config.settings.items(), *config.entries.items(), *config.others.items())
    found: dict[str, object] = {name: (one.value, one.unknown) for name, one in settings}
    found.update((f"actions.{term.name}", term.said) for term in config.actions)
    for drawn in config.randomize:
        bounds = (drawn.operation, drawn.low, drawn.high, drawn.distribution, drawn.when, drawn.every)
        found[f"range {drawn.field} {drawn.joints} {drawn.actuators}"] = bounds
    return found


def _groups(config: RobotConfig) -> list[object]:
    """Its groups, without places; those of one origin have one place."""
    return [
        (one.name, one.cls, one.joints, {key: (its.value, its.unknown) for key, its in one.settings.items()})
        for one in config.groups
    ]


def called(names: Iterable[str]) -> list[str]:
    """Names of the robots of one file, of which two may be alike: the second one gets a number."""
    found: list[str] = []
    for name in names:
        count, told = 2, name
        while told in found:
            told, count = f"{name} {count}", count + 1
        found.append(told)
    return found


def _named(case: Case, indices: list[int], robot: str, text: str) -> list[int]:
    """The robot of that name; the only one of a file has any."""
    found = [i for i in indices if case.artifacts[i].name == robot]
    if found or len(indices) == 1:
        return found or indices
    names = listed(shortened(case.artifacts[i].name) for i in indices)
    raise AuditError.of("DIF003", f"has no robot {robot!r}", Span(text), help=f"it has {names}")
