"""What is alone after models and configurations are paired, and belongs to one group by what it has.

An environment beside the constant that its robot is; a configuration whose joints stand in a deploy file's mappings
alone; a run beside the configuration that it was trained
from; a deploy file that somebody named together with what it is of, whatever it is called.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Sequence
from collections.abc import Set as AbstractSet

from actspec.diagnostics import Span
from actspec.readings.artifact import Artifact, FileKind


def _each_with_its_only(
    groups: Sequence[list[int]], alone: Iterable[int], homes: Callable[[int], Sequence[int]]
) -> list[list[int]]:
    """Groups, each of some artifacts in the group of the only one that it is at home with."""
    found = [list(group) for group in groups]
    for index in alone:
        its = homes(index)
        if len(its) == 1:
            found.remove([index])
            next(group for group in found if its[0] in group).append(index)
    return found


def with_environments(
    groups: Sequence[list[int]], artifacts: Sequence[Artifact], known: AbstractSet[int]
) -> list[list[int]]:
    """Groups, a configuration in that of the one robot a configuration of which has its actuators and its model.

    An environment has the actuators of the constant that it imports, at the places where these are written.

    Args:
        groups: Of artifacts that are one robot each.
        artifacts: All of them.
        known: Those that name their joints.
    """
    homes = [group for group in groups if not known.isdisjoint(group)]
    return _each_with_its_only(
        groups,
        [group[0] for group in groups if len(group) == 1 and group[0] not in known],
        lambda index: [
            home[0] for home in homes if any(_is_robot_of(artifacts[index], artifacts[i]) for i in home)
        ],
    )


def with_mappings(
    groups: Sequence[list[int]],
    artifacts: Sequence[Artifact],
    overlap: Callable[[frozenset[str], frozenset[str]], bool],
    agree: Callable[[int, int], bool],
) -> list[list[int]]:
    """Groups, a configuration in that of the one deploy file whose mappings have its keys, letter by letter.

    No model or list of names is at hand for either. Equal texts are of the same joints, whole names or parts of them;
    what a pattern would select among a mapping's keys is not asked.

    Args:
        groups: Of artifacts that are one robot each.
        artifacts: All of them.
        overlap: Whether keys of two artifacts may be of one robot.
        agree: Whether nothing tells two artifacts apart.
    """
    keys: dict[int, frozenset[str]] = {}
    for group in groups:
        config = artifacts[group[0]].config
        if len(group) == 1 and config is not None and "joint_order" not in config.settings:
            keys[group[0]] = frozenset(
                key for one in config.groups for key in one.joints or () if key != ".*"
            )
    mapped = [index for index in keys if artifacts[index].kind is FileKind.DEPLOY and keys[index]]
    # Where nothing else is there, names need not be alike: `go2_cfg.py`, `walk.yaml`.
    sole = len(groups) == 2
    return _each_with_its_only(
        groups,
        [index for index in keys if artifacts[index].kind is not FileKind.DEPLOY],
        lambda index: [
            one for one in mapped if overlap(keys[index], keys[one]) and (sole or agree(index, one))
        ],
    )


def with_runs(
    groups: Sequence[list[int]],
    artifacts: Sequence[Artifact],
    records: Collection[int],
    by_hand: Collection[int],
    agree: Callable[[int, int], bool],
) -> list[list[int]]:
    """Groups, what a run recorded in that of the one configuration that it was trained from.

    A run has its configuration's patterns, letter by letter, and the model that it loads.

    Args:
        groups: Of artifacts that are one robot each.
        artifacts: All of them.
        records: Those that a training wrote of itself.
        by_hand: Those whose files were named: of a folder's configurations many have the same patterns.
        agree: Whether nothing tells two artifacts apart.
    """
    named = [index for group in groups for index in group if index in by_hand and index not in records]
    return _each_with_its_only(
        groups,
        [group[0] for group in groups if len(group) == 1 and group[0] in records and group[0] in by_hand],
        lambda run: [
            one for one in named if _is_trained_from(artifacts[run], artifacts[one], agree(run, one))
        ],
    )


def with_deploy_files(
    groups: Sequence[list[int]],
    artifacts: Sequence[Artifact],
    by_hand: Collection[int],
    same: Callable[[int, int], bool],
    apart: Callable[[int, int], bool],
) -> list[list[int]]:
    """Groups, a deploy file in the only one that has its joints, where no other deploy file asks for that one.

    A deploy file is as often called after what it does as after its robot: `walk.yaml`, `policy.yaml`, `gains.yaml`.

    Args:
        groups: Of artifacts that are one robot each.
        artifacts: All of them.
        by_hand: Indices of those that somebody named: in a folder nobody says that two files are of one robot.
        same: Whether an artifact has the joints of a deploy file.
        apart: Whether the names of two artifacts are of two robots.
    """
    asking = [
        group for group in groups if all(i in by_hand and artifacts[i].kind is FileKind.DEPLOY for i in group)
    ]
    homes = [group for group in groups if not any(artifacts[i].kind is FileKind.DEPLOY for i in group)]
    fitting = {
        id(group): [
            home
            for home in homes
            if any(one in by_hand and same(one, group[0]) for one in home)
            and not any(apart(one, other) for one in home for other in group)
        ]
        for group in asking
    }
    found = list(groups)
    for group in asking:
        own = fitting[id(group)]
        asked = [other for other in asking if any(home in fitting[id(other)] for home in own)]
        if own and len(asked) == 1 and _are_one(own, artifacts):
            own[0].extend((*group, *(i for home in own[1:] for i in home)))
            found = [one for one in found if not any(one is other for other in (group, *own[1:]))]
    return found


def _is_trained_from(run: Artifact, other: Artifact, agree: bool) -> bool:
    """Whether a run has the patterns of a configuration, and its model where both say which they load."""
    if run.config is None or other.config is None or run.config.framework is not other.config.framework:
        return False
    models = [
        os.path.splitext(os.path.basename(config.model.replace("\\", "/")))[0]
        for config in (run.config, other.config)
        if config.model
    ]
    patterns, its = (
        frozenset(key for group in config.groups for key in group.joints or ())
        for config in (run.config, other.config)
    )
    if not patterns or patterns != its:
        return False
    return models[0] == models[1] if len(models) == 2 else agree and patterns != {".*"}


def _is_robot_of(one: Artifact, other: Artifact) -> bool:
    """Whether two configurations have one model, and actuators that are written at the same places."""
    if one.config is None or other.config is None or one.config.model is None:
        return False
    places = _places(one)
    return bool(places) and places == _places(other) and one.config.model == other.config.model


def _places(artifact: Artifact) -> frozenset[Span]:
    """Where the actuators of a configuration are written."""
    return frozenset(group.span for group in (artifact.config.groups if artifact.config else ()))


def _are_one(groups: Sequence[Sequence[int]], artifacts: Sequence[Artifact]) -> bool:
    """Whether groups are one robot: an environment's robot is the constant of its file, whose groups stand there."""
    places = {_places(artifacts[i]) for each in groups for i in each if artifacts[i].config is not None}
    return len(groups) == 1 or (len(places) == 1 and all(places))
