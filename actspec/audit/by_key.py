"""What two configurations state by pattern, where nobody knows which joints the patterns select: key by key.

Isaac Lab refuses two keys that match one joint, so that their order says nothing. Of mjlab's poses the first such key
counts, of legged_gym's gains the last (`readings.dict_keys`).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from typing import TypeAlias

from actspec.fields import FIELDS
from actspec.readings.artifact import Framework
from actspec.readings.compare import Deviation, Figure, same
from actspec.readings.dict_keys import POSE, meets, order_counts
from actspec.readings.dynamics import RobotDynamics

_Keys: TypeAlias = "Sequence[tuple[str, Figure]]"


def stated_by_key(
    old: RobotDynamics, new: RobotDynamics, tolerance: float
) -> tuple[int, list[tuple[str, str, Deviation, str]]]:
    """How many figures by pattern are compared, and those that changed.

    What is a figure of the groups' own patterns is told of these.

    Args:
        old: Before.
        new: After.
        tolerance: Largest relative difference of equal figures.

    Returns: The count; and of each change its key, or "" of the order of two, what it is in words, both figures, and
        what a missing one is.
    """
    if old.kind is not new.kind or old.by_key is None or new.by_key is None:
        return 0, []
    framework = new.framework or old.framework
    compared = 0
    found: list[tuple[str, str, Deviation, str]] = []
    for name, field in FIELDS.items():
        ours, theirs = old.by_key.get(name, ()), new.by_key.get(name, ())
        absent = "none" if all(_says(side, name) for side in (old, new)) else "unknown"
        keys = dict.fromkeys(key for key, _ in (*ours, *theirs))
        told = {key for key in keys if _is_told(old, new, name, key)}
        for key in keys:
            if key in told:
                continue
            before, after = ([one for other, one in side if other == key] for side in (ours, theirs))
            compared += max(len(before), len(after))
            gone, come = _without(before, after, tolerance), _without(after, before, tolerance)
            for was, now in itertools.zip_longest(gone, come):
                alone, rest = (now, ours) if was is None else (was, theirs)
                if (was and now) or not _is_zero_anyway(framework, name, key, alone, rest):
                    found.append((key, field.noun, Deviation(name, now, was), absent))
        if framework is not None and order_counts(framework, name):
            for pair, was, now in _reordered(framework, name, ours, theirs):
                both = ".*" in pair and told.issuperset(pair)
                if not both and not same(was.value, now.value, tolerance):
                    noun = f"{field.noun} where '{pair[0]}' and '{pair[1]}' both match"
                    found.append(("", noun, Deviation(name, now, was), ""))
    return compared, found


def _says(robot: RobotDynamics, name: str) -> bool:
    """Whether a field is known of anything of a robot."""
    figures = (joint.figures.get(name) for joint in robot.joints.values())
    by_key = robot.by_key or {}
    return bool(by_key.get(name)) or any(one is not None and one.value is not None for one in figures)


def _is_told(old: RobotDynamics, new: RobotDynamics, name: str, key: str) -> bool:
    """Whether what a key has of a field is a figure of a pattern of the groups that both have."""
    figures = [
        side.joints[pattern].figures.get(name)
        for pattern in old.joints
        if pattern in new.joints and key in (pattern, ".*")
        for side in (old, new)
    ]
    return any(figure is not None and figure.value is not None for figure in figures)


def _without(own: Sequence[Figure], other: Sequence[Figure], tolerance: float) -> list[Figure]:
    """Figures that the other side has not."""
    return [one for one in own if not any(same(one.value, its.value, tolerance) for its in other)]


def _is_zero_anyway(framework: Framework | None, name: str, key: str, figure: Figure, rest: _Keys) -> bool:
    """Whether a key of a pose says 0, where the pose without it leaves the joints at 0."""
    if name != POSE or figure.value != 0.0 or framework is None:
        return False
    return not any(meets(framework, name, other, key) for other, _ in rest)


def _reordered(
    framework: Framework, name: str, old: _Keys, new: _Keys
) -> Iterator[tuple[tuple[str, str], Figure, Figure]]:
    """Two keys in another order of which one is for what the other is for.

    Returns: The keys; and the figure that counted where both are for a joint, and the one that counts.
    """
    places = {key: place for place, (key, _) in enumerate(old)}
    kept = [pair for pair in new if pair[0] in places]
    for (one, first), (other, last) in itertools.combinations(kept, 2):
        if places[one] > places[other] and (
            meets(framework, name, one, other) or meets(framework, name, other, one)
        ):
            if framework is Framework.LEGGED_GYM:
                yield (one, other), old[places[one]][1], last
            else:
                yield (one, other), old[places[other]][1], first
