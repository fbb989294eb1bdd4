"""Configurations and deploy files that name joints by keys alone, where no model or list of names is at hand."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Sequence

from actspec.readings.artifact import Artifact, Framework


def with_mappings(
    groups: Sequence[list[int]],
    artifacts: Sequence[Artifact],
    overlap: Callable[[frozenset[str], frozenset[str]], bool],
    agree: Callable[[int, int], bool],
) -> list[list[int]]:
    """Groups, a configuration in that of the one deploy file whose mappings have its keys, letter by letter.

    Equal texts are of the same joints, whole names or parts of them; what a pattern would select among a mapping's
    keys is not asked.

    Args:
        groups: Of artifacts that are one robot each.
        artifacts: All of them.
        overlap: Whether keys of two artifacts may be of one robot.
        agree: Whether nothing tells two artifacts apart.
    """
    found = list(groups)
    keys: dict[int, frozenset[str]] = {}
    for group in groups:
        config = artifacts[group[0]].config
        if len(group) == 1 and config is not None and "joint_order" not in config.settings:
            keys[group[0]] = frozenset(
                key for one in config.groups for key in one.joints or () if key != ".*"
            )
    mapped = [index for index in keys if _is_deploy(artifacts[index]) and keys[index]]
    for index in (index for index in keys if not _is_deploy(artifacts[index])):
        # Where nothing else is there, names need not be alike: `go2_cfg.py`, `walk.yaml`.
        sole = len(groups) == 2
        homes = [one for one in mapped if overlap(keys[index], keys[one]) and (sole or agree(index, one))]
        if len(homes) == 1:
            found.remove([index])
            next(group for group in found if homes[0] in group).append(index)
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


def _is_deploy(artifact: Artifact) -> bool:
    return artifact.config is not None and artifact.config.framework is Framework.DEPLOY
