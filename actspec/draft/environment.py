"""A robot's configuration and the environments of its file that train it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from actspec.diagnostics import Span, listed, one_line
from actspec.draft.sources import places
from actspec.readings.artifact import Artifact, RandomizedRange, RobotConfig, Setting

_OF_A_ROBOT = ("model", "default_position", "soft_joint_pos_limit_factor")
"""Settings of a robot itself, not of what it is trained in."""

_OF_TRAINING = {
    "physics_dt": "time step",
    "decimation": "decimation",
    "control_dt": "control period",
    "action_scale": "action scale",
}
"""Settings of an environment, in words."""


def in_environment(part: Artifact, every: Sequence[Artifact]) -> tuple[Artifact, str]:
    """A robot's configuration with what the environments of it in its file say, under the robot's own name.

    Nothing of them where they differ.

    Args:
        part: The one that is meant: the robot's own, or an environment with the robot in it.
        every: All that the files have.

    Returns: It, and what is to be remarked; "" for nothing.
    """
    config = part.config
    if config is None or not config.groups:
        return part, ""
    family = {
        one.name: one.config
        for one in every
        if one.path == part.path and one.config is not None and are_one(part, one)
    }
    trained = {name: one for name, one in family.items() if _is_environment(one)}
    if _is_environment(config):
        name = next((name for name in family if name not in trained), part.name)
        return replace(part, name=name, config=replace(config, name=name)), ""
    if not trained:
        return part, ""
    names = listed(map(one_line, trained), 4)
    first, *others = ({**_said(one.settings), "ranges": _ranges(one)} for one in trained.values())
    words = {**_OF_TRAINING, "ranges": "ranges"}
    unlike = [words[name] for name in words if any(one.get(name) != first.get(name) for one in others)]
    if unlike:
        return part, f"{names} in its file differ in {listed(unlike, 9)}: --robot NAME takes those of one"
    env = next(iter(trained.values()))
    taken = {name: setting for name, setting in env.settings.items() if name in _OF_TRAINING}
    spans = [*(setting.span for setting in taken.values()), *(item.span for item in env.randomize)]
    told = [words[name] for name in (*taken, *(["ranges"] if env.randomize else []))]
    config = replace(config, settings={**config.settings, **taken}, randomize=env.randomize)
    return replace(part, config=config), f"{listed(told, 9)} from {names} in its file, {places(spans)}"


def _is_environment(config: RobotConfig) -> bool:
    """Whether a configuration says how its robot is trained."""
    return bool(config.randomize) or any(name in config.settings for name in _OF_TRAINING)


def _ranges(config: RobotConfig) -> list[RandomizedRange]:
    """What its ranges are, wherever they are written."""
    return [replace(one, span=Span("")) for one in config.randomize]


def written_once(one: RobotConfig, two: RobotConfig) -> bool:
    """Whether the groups of two configurations were written in one place."""
    places = [[(g.name, g.cls, g.span) for g in config.groups] for config in (one, two)]
    return places[0] == places[1] != []


def are_one(part: Artifact, other: Artifact) -> bool:
    """Whether two robots of one file are one: by their names, or configurations with the same groups.

    A copy that was changed afterwards is another robot.
    """
    one, two = part.config, other.config
    if one is None or two is None:
        return part.name == other.name
    if not written_once(one, two):
        return False
    if any(_said(a.settings) != _said(b.settings) for a, b in zip(one.groups, two.groups, strict=True)):
        return False
    # What one of them leaves open tells nothing of the whole robot.
    mine, theirs = (
        {name: config.settings[name] for name in _OF_A_ROBOT if name in config.settings}
        for config in (one, two)
    )
    known = [name for name in mine if name in theirs and not (mine[name].unknown or theirs[name].unknown)]
    return all(mine[name].value == theirs[name].value for name in known)


def _said(settings: Mapping[str, Setting]) -> dict[str, object]:
    """What settings say, wherever it is written."""
    return {name: setting.unknown or setting.value for name, setting in settings.items()}
