"""Runs and deploy files that somebody named together with what they are of, whatever they are called."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Sequence

from actspec.readings.artifact import Artifact, FileKind


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
    found = [list(group) for group in groups]
    named = [index for group in groups for index in group if index in by_hand]
    for index in (group[0] for group in groups if len(group) == 1 and group[0] in records):
        homes = [
            one
            for one in named
            if one not in records and _is_trained_from(artifacts[index], artifacts[one], agree(index, one))
        ]
        if index in by_hand and len(homes) == 1:
            found.remove([index])
            next(group for group in found if homes[0] in group).append(index)
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


def _are_one(groups: Sequence[Sequence[int]], artifacts: Sequence[Artifact]) -> bool:
    """Whether groups are one robot: an environment's robot is the constant of its file, whose groups stand there."""
    places = {
        frozenset(group.span for group in config.groups)
        for each in groups
        for config in (artifacts[i].config for i in each)
        if config is not None
    }
    return len(groups) == 1 or (len(places) == 1 and all(places))
