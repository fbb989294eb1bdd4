"""A robot's configuration and the environments that train it, of its file or of one beside it."""

from __future__ import annotations

import os
from collections.abc import Container, Mapping, Sequence
from dataclasses import replace

from actspec.diagnostics import Span, listed, one_line
from actspec.draft.sources import places
from actspec.readings.artifact import Artifact, Framework, RandomizedRange, RobotConfig, Setting

_OF_A_ROBOT = ("model", "default_position", "soft_joint_pos_limit_factor")
"""Settings of a robot itself, not of what it is trained in."""

_OF_TRAINING = {
    "physics_dt": "time step",
    "decimation": "decimation",
    "control_dt": "control period",
    "action_scale": "action scale",
    "ranges": "ranges",
}
"""What an environment says, in words: its settings, and its ranges."""


def in_environments(
    parts: Sequence[Artifact], every: Sequence[Artifact], named: str | None
) -> tuple[list[Artifact], list[str]]:
    """Robots with what the environments say that train them, under the robots' own names.

    Args:
        parts: What the files have of the robot.
        every: All that the files have.
        named: What the user named; None: nothing.

    Returns: The parts, an environment of another file among them where it is the one whose word is taken, and what is
        to be remarked on each; "" for nothing.
    """
    meant = [part for part in parts if part.name == named and part.config and is_environment(part.config)]
    parts = [_without_robot(part, parts) for part in parts if not any(_is_beside(part, one) for one in meant)]
    every = [_without_robot(one, parts) for one in every]
    found = [_in_environment(part, every, named) for part in parts]
    robots = [part for part in parts if part.config is not None and part.config.groups]
    used = {(env.path, env.name): env for _, _, env in found if env is not None and _is_alone(env)}
    alone = [
        one for one in every if _is_alone(one) and any(_may_train(one, robot, every) for robot in robots)
    ]
    idle = {(one.path, one.name) for one in alone} - used.keys()
    kept = [
        (used.get((part.path, part.name), part), remark)
        for part, remark, _ in found
        if (part.path, part.name) not in idle
    ]
    here = {(part.path, part.name) for part, _ in kept}
    kept += [(env, "") for at, env in used.items() if at not in here]
    return [part for part, _ in kept], [remark for _, remark in kept]


def _is_beside(part: Artifact, meant: Artifact) -> bool:
    """Whether a part is another environment of the robot of the one that the user names."""
    if part.config is None or part.name == meant.name or not is_environment(part.config):
        return False
    return are_one(part, meant)


def _without_robot(env: Artifact, parts: Sequence[Artifact]) -> Artifact:
    """An environment whose robot is a part of another file, as if that import were not followed: else as it is."""
    config = env.config
    robot = next((one for one in parts if _is_robot_of(one, env)), None)
    if config is None or robot is None or not is_environment(config):
        return env
    settings = {name: one for name, one in config.settings.items() if name in _OF_TRAINING}
    elsewhere = {**config.elsewhere, "robot": robot.name}
    return replace(env, config=replace(config, groups=(), settings=settings, elsewhere=elsewhere))


def _in_environment(
    part: Artifact, every: Sequence[Artifact], named: str | None
) -> tuple[Artifact, str, Artifact | None]:
    """A robot's configuration with what the environments of it say: those of its file, else those of the others.

    Without what differs among them: the user says which of them is meant.

    Returns: It, the remark, and the environment whose word is taken.
    """
    config = part.config
    if config is None or not config.groups:
        return part, "", None
    family = {one.name: one for one in every if one.path == part.path and one.config and are_one(part, one)}
    trained = {name: one for name, one in family.items() if one.config and is_environment(one.config)}
    own, where = is_environment(config), "in its file"
    if own:
        name = next((name for name in family if name not in trained), part.name)
        config = replace(config, name=name)
        part = replace(part, name=name, config=config)
    elif not trained:
        others = [one for one in every if one.path != part.path and _may_train(one, part, every)]
        names_of = [one.name for one in others]
        trained = {
            one.name if names_of.count(one.name) == 1 else f"{one.name} of {os.path.basename(one.path)}": one
            for one in others
        }
        where = f"in {listed(dict.fromkeys(one_line(os.path.basename(one.path)) for one in others), 4)}"
    if not trained:
        return part, "", None
    if named in trained:
        trained = {named: trained[named]}
    # A base leaves something to what is derived from it, and one for playing has no ranges.
    training = {name: _training(one) for name, one in trained.items()}
    derived = [training[name].keys() for name, one in trained.items() if not _leaves_robot(one)]
    # One that a named environment of the robot is derived from is none beside it: that one says all of it.
    for name in [name for name, one in trained.items() if _leaves_robot(one)]:
        if any(training[name].keys() <= said for said in derived):
            del trained[name], training[name]
    names = listed(map(one_line, trained), 4)
    first = max(training, key=lambda name: len(training[name]))
    told, fullest = training[first], trained[first]
    unlike = [
        name
        for name in _OF_TRAINING
        if any(name in one and one[name] != told.get(name) for one in training.values())
    ]
    if own and not unlike:
        return part, "", None
    assert fullest.config is not None
    # It counts time steps, which may be another file's then.
    left = {*unlike, "decimation"} if "physics_dt" in unlike else set(unlike)
    env = _without(fullest.config, left)
    taken = {name: setting for name, setting in env.settings.items() if name in _OF_TRAINING}
    robot = _without(config, _OF_TRAINING)
    config = replace(
        robot, settings={**robot.settings, **taken}, randomize=env.randomize, actions=env.actions
    )
    part, fullest = replace(part, config=config), replace(fullest, config=env)
    if own and any(_is_robot_of(one, part) for one in every):
        # Of the robot it is said, with all of it.
        return part, "", None
    acting = [term for term in env.actions if term.command is not None]
    if env.actions and not acting:
        # Of a law that is not known nothing is taken, which is told of the joints.
        left.add("action_scale")
    spans = [
        *(setting.span for setting in taken.values()),
        *(term.place for term in acting),
        *(item.span for item in env.randomize),
    ]
    said = listed([word for name, word in _OF_TRAINING.items() if name in told and name not in left], 9)
    of_file = f" {where}" if unlike or fullest.path == part.path else ""
    remark = f"{said} from {names}{of_file}, {places(spans)}" if said else ""
    if unlike:
        who = f"{remark}; they" if said else f"{names} {where}"
        # Where the robot is named already, that would take no other one.
        beside = named is not None and where != "in its file"
        advice = "none is taken" if beside else "--robot NAME takes those of one"
        remark = f"{who} differ in {listed([_OF_TRAINING[name] for name in unlike], 9)}: {advice}"
    return part, remark, fullest if said else None


def _leaves_robot(part: Artifact) -> bool:
    """Whether an environment leaves its robot to those that are derived from it."""
    return part.config is not None and part.config.robot_missing is not None


def _without(config: RobotConfig, names: Container[str]) -> RobotConfig:
    """A configuration without some of what an environment says, by the names of `_OF_TRAINING`."""
    return replace(
        config,
        settings={name: one for name, one in config.settings.items() if name not in names},
        actions=() if "action_scale" in names else config.actions,
        randomize=() if "ranges" in names else config.randomize,
    )


def _is_robot_of(one: Artifact, env: Artifact) -> bool:
    """Whether a part of another file is the robot that an environment imports."""
    if one.path == env.path or one.config is None or is_environment(one.config):
        return False
    return bool(one.config.groups) and are_one(one, env)


def _may_train(env: Artifact, part: Artifact, every: Sequence[Artifact]) -> bool:
    """Whether an environment of another file is for a robot: it has the robot, or takes it from where nobody looked."""
    mine, its = part.config, env.config
    if mine is None or its is None or its.framework is not mine.framework:
        return False
    if not _is_alone(env):
        return is_environment(its) and are_one(part, env)
    of = set(its.elsewhere.values()) & {one.name for one in every}
    return not of or part.name in of


def _is_alone(part: Artifact) -> bool:
    """Whether a part is an environment of Isaac Lab or mjlab whose robot is not known."""
    config = part.config
    if config is None or config.groups or config.framework not in (Framework.ISAACLAB, Framework.MJLAB):
        return False
    return is_environment(config)


def _training(part: Artifact) -> dict[str, object]:
    """What an environment says, wherever it is written, by the names of `_OF_TRAINING`."""
    config = part.config
    assert config is not None
    said: dict[str, object] = {
        name: one for name, one in _said(config.settings).items() if name in _OF_TRAINING
    }
    if config.actions:
        said["action_scale"] = [(term.name, term.said) for term in config.actions]
    if config.randomize:
        said["ranges"] = _ranges(config)
    return said


def is_environment(config: RobotConfig) -> bool:
    """Whether a configuration says how its robot is trained."""
    return bool(config.randomize or config.actions) or any(name in config.settings for name in _OF_TRAINING)


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
