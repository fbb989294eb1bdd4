"""Configurations and deploy files that name joints by keys alone, where no model or list of names is at hand."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from actspec.readings.artifact import Artifact, FileKind


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
    mapped = [index for index in keys if artifacts[index].kind is FileKind.DEPLOY and keys[index]]
    for index in (index for index in keys if artifacts[index].kind is not FileKind.DEPLOY):
        # Where nothing else is there, names need not be alike: `go2_cfg.py`, `walk.yaml`.
        sole = len(groups) == 2
        homes = [one for one in mapped if overlap(keys[index], keys[one]) and (sole or agree(index, one))]
        if len(homes) == 1:
            found.remove([index])
            next(group for group in found if homes[0] in group).append(index)
    return found
