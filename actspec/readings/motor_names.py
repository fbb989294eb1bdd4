"""Names for the motors of a deploy file that gives them numbers alone: what its run, or a configuration, calls them."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from actspec.diagnostics import Diagnostic, Severity, Span, listed
from actspec.patterns import PatternError, match_names
from actspec.readings.artifact import FileReading, Framework, Motors, RobotConfig, Setting
from actspec.readings.called import distinctive, names_agree

NAMELESS = "DEPLOY002"
"""Code of a list whose joints nobody names."""

ELSEWHERE = "DEPLOY010"
"""Code of an action whose numbers are those of other joints than its names, of none, or of one more than once."""


def called(
    config: RobotConfig, names: Sequence[str], places: Mapping[str, Span] | None = None
) -> RobotConfig:
    """A configuration whose motors have names: what its lists say is then of joints.

    Args:
        config: With motors.
        names: As many as the motors; an empty one is a gap.
        places: Where the names stand, if they are in the file.
    """
    motors = config.motors
    if motors is None or len(names) != motors.count:
        return config
    own = {str(number): name for number, name in enumerate(names) if name}

    def joints(keys: Sequence[str] | None) -> tuple[str, ...]:
        return tuple(own[key] for key in keys or () if key in own)

    def renamed(one: Setting | None) -> Setting | None:
        if one is None or not isinstance(one.value, Mapping):
            return one
        value = {own[key]: number for key, number in one.value.items() if key in own}
        return replace(
            one, value=value, places={own[key]: at for key, at in one.places.items() if key in own}
        )

    groups = [
        replace(group, name=own[group.name], joints=joints(group.joints))
        for group in motors.groups
        if group.name in own
    ]
    actions = [
        replace(term, joints=joints(term.joints), scale=renamed(term.scale), zero=renamed(term.zero))
        for term in motors.actions
    ]
    settings = {name: one for name, one in config.settings.items() if name != "joint_count"}
    taken = {one.span for group in groups for one in group.settings.values()}
    for term in actions:
        for one in filter(None, (term.scale, term.zero)):
            taken.update(one.places.values())
    settings["joint_order"] = Setting(tuple(names), motors.span, places=places or {})
    return replace(
        config,
        groups=tuple(groups),
        actions=tuple(actions),
        settings=settings,
        notes=(*(note for note in config.notes if note.code != NAMELESS), *_elsewhere(motors, own)),
        nameless={},
        nameless_lists={},
        motors=None,
        by_motor=True,
        entries={where: one for where, one in config.entries.items() if one.span not in taken},
    )


def _elsewhere(motors: Motors, own: Mapping[str, str]) -> Iterator[Diagnostic]:
    """What is said of actions whose `joint_ids` are of joints that their `joint_names` do not select.

    Args:
        motors: Of the file.
        own: The name of each motor.
    """
    # A joint's number is its place in the policy's order.
    order = [own.get(motor or "", "") for motor in motors.order]
    for term in motors.actions:
        patterns = motors.selected.get(term.name)
        if patterns is None or not isinstance(patterns.value, tuple):
            continue
        try:
            meant = {joint for text in patterns.value for joint in match_names(str(text), order) if joint}
        except PatternError:
            continue
        strange = [own[motor] for motor in term.joints or () if motor in own and own[motor] not in meant]
        if meant and strange:
            numbers = listed(str(number) for number, joint in enumerate(order) if joint in meant)
            yield Diagnostic(
                ELSEWHERE,
                Severity.WARNING,
                f"these are the numbers of {listed(strange)}, which its joint_names do not select: the action goes "
                "there",
                f"{term.name}.joint_ids",
                patterns.span,
                f"the numbers of what joint_names select are {numbers}",
            )


def names_wanted(motors: Motors | None, count: int | None = None) -> str:
    """What a deploy file without names of joints is to be given.

    Args:
        motors: What its lists say of each motor, if they go by numbers.
        count: Entries of its lists; None: left out.
    """
    if motors is not None:
        own = f"joint_sdk_names: [...] with {motors.count} names in the order of its kp and kd"
        return f"{own}; the others are read by joint_ids_map"
    return f"joint_names: [...]{'' if count is None else f' with {count} names'} in the order of its lists"


def with_names(readings: Sequence[FileReading]) -> list[FileReading]:
    """Readings, motors of deploy files called as the run or configuration has them that is beside it, or named with it.

    In a folder the names are those of the configuration that is called as the deploy file's robot. Nobody else's are
    taken, and none where two orders may be meant.
    """
    orders = [
        (reading, artifact, tuple(map(str, order.value)))
        for reading in readings
        for artifact in reading.artifacts
        if artifact.config is not None
        and artifact.config.framework is not Framework.DEPLOY
        and (order := artifact.config.settings.get("joint_order")) is not None
        and isinstance(order.value, tuple)
    ]
    found = []
    for reading in readings:
        artifacts = []
        for artifact in reading.artifacts:
            config = artifact.config
            if config is not None and config.motors is not None:
                folder, count = os.path.dirname(reading.path), config.motors.count
                fitting = [each for each in orders if len(each[2]) == count]
                beside = {names for one, _, names in fitting if os.path.dirname(one.path) == folder}
                named = {names for one, _, names in fitting if not one.in_folder and not reading.in_folder}
                own = distinctive(artifact)
                alike = {
                    names
                    for one, other, names in fitting
                    if not one.record and names_agree(own, distinctive(other))
                }
                chosen = beside or named or alike
                if len(chosen) == 1:
                    artifact = replace(artifact, config=called(config, next(iter(chosen))))
            artifacts.append(artifact)
        left = dict.fromkeys(note for one in artifacts if one.config is not None for note in one.config.notes)
        said = tuple(item for item in reading.diagnostics if item.code != NAMELESS or item in left)
        said += tuple(note for note in left if note.code == ELSEWHERE and note not in said)
        found.append(replace(reading, artifacts=tuple(artifacts), diagnostics=said))
    return found
