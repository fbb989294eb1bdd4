"""The joints that an artifact names, and those that a configuration's patterns select."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Sequence
from itertools import product

from actspec.joints import other_word
from actspec.patterns import PatternError, match_names
from actspec.patterns import written_out as names_in
from actspec.readings.artifact import Artifact, Framework, RobotConfig
from actspec.readings.body import SHARE

_COUNTED = re.compile(r"(.*?)(\d{1,3})(\D*)", re.DOTALL)


def joint_names(artifact: Artifact) -> tuple[str, ...] | None:
    """The joints that an artifact names; None for a configuration that has patterns."""
    if artifact.robot is not None:
        return tuple(joint.name for joint in artifact.robot.scalar_joints)
    if artifact.spec is not None:
        return tuple(joint.joint for joint in artifact.spec.joints)
    config = artifact.config
    if config is not None and "joint_order" in config.settings:
        order = config.settings["joint_order"].value
        if isinstance(order, tuple):
            # A gap in the numbering of the motors has no name.
            return tuple(str(name) for name in order if name)
    return None


def series(name: str) -> tuple[str, str] | None:
    """Text before and after the last number of a joint's name, a short one, which counts; None: it has none."""
    parts = _COUNTED.fullmatch(name.rpartition("/")[2])
    return None if parts is None else (parts[1], parts[3])


def last_numbers(names: Iterable[str]) -> dict[tuple[str, str], int]:
    """Each series of numbered names to its largest number."""
    found: dict[tuple[str, str], int] = {}
    for name in names:
        parts = _COUNTED.fullmatch(name.rpartition("/")[2])
        if parts is not None:
            key = parts[1], parts[3]
            found[key] = max(found.get(key, 0), int(parts[2]))
    return found


def share_joints(one: frozenset[str], other: frozenset[str]) -> bool:
    least = min(len(one), len(other))
    return least > 0 and len(one & other) >= SHARE * least


def differ_by_one(one: frozenset[str], other: frozenset[str]) -> bool:
    """Whether all joints but one of the smaller artifact are the other's: a name that is wrong in one of the two parts
    no files of a robot with few joints. Of two joints one says nothing.
    """
    least = min(len(one), len(other))
    return least > 2 and len(one & other) >= least - 1


def renaming(one: frozenset[str], other: frozenset[str]) -> dict[str, str]:
    """Joints of one artifact to those of the other where one word for another makes them these, and half are called
    alike: `l_knee` and `r_knee` are `l_calf` and `r_calf`, as macros and search-and-replace have it. Empty: none does.
    """
    mine, its = one - other, other - one
    if not mine or len(mine) != len(its) or len(one & other) < len(mine):
        return {}
    found: dict[tuple[str, str], dict[str, str]] = {}
    for name, called in product(sorted(mine), sorted(its)):
        if word := other_word(name, called):
            found.setdefault(word, {})[name] = called
    return next((each for each in found.values() if each.keys() == mine and {*each.values()} == its), {})


def fits(config: RobotConfig | None, joints: Sequence[str], share: float = 1.0) -> bool:
    """Whether that share of a configuration's joint patterns, or more, match a joint; of a list without names, all.

    The same share of its joints must be there, as far as patterns write out those that are not: a gripper is not the
    robot of an arm, `arm_joint[1-7]`, that has it.
    """
    if config is None or not config.groups:
        return False
    count = config.settings.get("joint_count")
    if count is not None and count.value != len(set(joints)):
        return False
    patterns = _patterns(config)
    lost = [pattern for pattern in patterns if not matching(config.framework, pattern, joints)]
    met = len(patterns) - len(lost)
    if not patterns or met < share * len(patterns):
        return False
    own = len(selected(config, joints)) if lost else 0
    left_out = sum(len(written_out(config.framework, pattern)) or 1 for pattern in lost)
    return own >= share * (own + left_out)


def has_joints(artifact: Artifact, joints: Collection[str]) -> bool:
    """Whether an artifact names just these joints, or all of its patterns, which say something, match one of them."""
    own = joint_names(artifact)
    if own is not None:
        return bool(own) and set(own) == set(joints)
    return bool(joints) and says_something(artifact.config) and fits(artifact.config, sorted(joints))


def says_something(config: RobotConfig | None) -> bool:
    """Whether a pattern has a word in it: `.*` fits every robot."""
    return config is not None and any(re.search("[A-Za-z]{2}", pattern) for pattern in _patterns(config))


def selected(config: RobotConfig | None, joints: Sequence[str]) -> set[str]:
    """The joints that a configuration's patterns match."""
    if config is None:
        return set()
    return {joint for pattern in _patterns(config) for joint in matching(config.framework, pattern, joints)}


def _patterns(config: RobotConfig) -> list[str]:
    return [pattern for group in config.groups for pattern in group.joints or ()]


def matching(framework: Framework, pattern: str, joints: Sequence[str]) -> tuple[str, ...]:
    """The joints that a configuration's key selects, by its framework's rule.

    Isaac Lab and mjlab match a regular expression in full, legged_gym takes a part of the name, and
    a deploy file names the joint (`.*` for all). A pattern that is refused selects nothing.
    """
    if framework is Framework.LEGGED_GYM:
        return tuple(joint for joint in joints if pattern in joint)
    if framework is Framework.DEPLOY:
        return tuple(joint for joint in joints if pattern in (joint, ".*"))
    try:
        return match_names(pattern, joints)
    except PatternError:
        return ()


def written_out(framework: Framework, pattern: str) -> tuple[str, ...]:
    """The joints that a configuration's key writes out by its framework's rule; none where it selects any number."""
    if framework is Framework.LEGGED_GYM:
        return ()
    if framework is Framework.DEPLOY:
        return () if pattern == ".*" else (pattern,)
    try:
        return names_in(pattern)
    except PatternError:
        return ()
