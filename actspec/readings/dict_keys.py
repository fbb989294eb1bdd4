"""Keys of values by joint: whether one may match a joint, what one that matches none was meant for, and which of two
for one joint counts.

Source of the last: Isaac Lab 2.2.0 and 2.3.2, mjlab 1.6.0, `resolve_matching_names_values` (ValueError "Multiple
matches"), by which Isaac Lab reads gains, limits, scales and poses, mjlab scales; mjlab 1.6.0, `resolve_expr`, for its
poses: the first whose pattern begins the name (`re.match`). legged_gym, legged_robot.py, `_init_buffers`: no `break`,
so the last key of `stiffness` that is part of the name, for both gains; a pose by the whole name.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import SequenceMatcher

from actspec.diagnostics import Span, shortened
from actspec.patterns import (
    NoExpression,
    PatternError,
    compile_pattern,
    match_names,
    recased,
    suggest_pattern,
)
from actspec.readings.artifact import Framework, Setting
from actspec.readings.joint_names import matching

_ALIKE = 0.9
"""How alike a pattern and the nearest one that matches are, where it is misspelt and not that of another joint.
Chosen: `wrist_pitch_joint` and `wrist_roll_joint` are 0.77, one letter more or less is above 0.9."""

_ALIKE_FREE = 0.8
"""The same of a joint without a key of its own. Chosen: `writs_.*` and `wrist_.*` are 0.88."""

PLAIN = re.compile(r"[A-Za-z0-9_/:-]*")
"""A text that is no pattern."""


_NAME = re.compile(r"(?:[^\\.^$*+?{}\[\]|()]|\\[^A-Za-z0-9])+", re.DOTALL)
"""A pattern that means one name: characters without a meaning of their own, or escaped ones."""


@dataclass(frozen=True, slots=True)
class Found:
    """A setting's value for one joint.

    Attributes:
        value: None is one that could not be folded, or that is no number of the joint.
        span: Where it is written.
        stated: Whether somebody wrote it; else it is what a mapping gives a joint that it misses, or unknown.
        why: Why it is None.
        keys: Of a pattern whose joints are not known, the numbers by key, in the author's order, where other keys than
            the one that is `value` may be for some of them; where each stands.
    """

    value: float | None
    span: Span
    stated: bool = True
    why: str | None = None
    keys: Mapping[str, tuple[float, Span]] = field(default_factory=dict)


def plain_name(framework: Framework, pattern: str) -> str | None:
    """The one name that a pattern means; None where it means more, or a part of names."""
    if framework is Framework.LEGGED_GYM or (framework is Framework.DEPLOY and pattern == ".*"):
        return None
    if framework is Framework.DEPLOY:
        return pattern
    return re.sub(r"\\(.)", r"\1", pattern, flags=re.DOTALL) if _NAME.fullmatch(pattern) else None


def value_of(
    framework: Framework, setting: Setting, joint: str, pattern: str, named: Sequence[str] | None
) -> Found | None:
    """A setting's value for a joint.

    A mapping that misses a joint gives 0 in Isaac Lab (2.x, measured) and in legged_gym; elsewhere nothing.
    Without a model only a key that is written like the group's pattern is known to cover it, unless that is a name.
    """
    if setting.unknown is not None:
        return Found(None, setting.span, why=setting.unknown)
    value = setting.value
    if isinstance(value, bool):
        return None
    if isinstance(value, int | float):
        return Found(float(value), setting.span)
    if not isinstance(value, Mapping):
        return None
    numbers = {key: float(number) for key, number in value.items() if isinstance(number, int | float)}
    if named is None and plain_name(framework, pattern) is None:
        own = next((key for key in numbers if key in (pattern, ".*")), None)
        keys = {key: (number, setting.place(key)) for key, number in numbers.items()}
        rest = {} if list(keys) == [own] else keys
        if own is None:
            return Found(None, setting.span, keys=rest)
        return Found(numbers[own], setting.place(own), keys=rest)
    chosen = next((key for key in numbers if matching(framework, key, (joint,))), None)
    if chosen is not None:
        return Found(numbers[chosen], setting.place(chosen))
    if framework in (Framework.ISAACLAB, Framework.LEGGED_GYM) and len(numbers) == len(value):
        return Found(0.0, setting.span, stated=False)
    return None


def is_no_expression(key: str) -> bool:
    """Whether Isaac Lab and mjlab raise at a key, whatever the joints: a glob, a bracket that is left open."""
    try:
        compile_pattern(key)
    except NoExpression:
        return True
    except PatternError:
        return False
    return False


def dead_keys(framework: Framework, keys: Sequence[str], joints: Sequence[str]) -> list[str]:
    """Keys that can be judged and match none of the joints, which may be patterns where no file names them."""
    return [
        key
        for key in keys
        if selects_nothing(framework, key, joints)
        and not any(may_match(framework, key, joint) for joint in joints)
    ]


def selects_nothing(framework: Framework, pattern: str, names: Sequence[str]) -> bool:
    """Whether a pattern that can be judged selects no joint."""
    try:
        compile_pattern(pattern)
    except PatternError:
        return False
    return not matching(framework, pattern, names)


def meant_for(pattern: str, names: Sequence[str], free: Sequence[str] = ()) -> str | None:
    """The pattern that was meant by one that matches none of the names; None where none is near enough to say so.

    Args:
        pattern: As written.
        names: Of joints.
        free: Those without a key of their own, one of which was meant rather.
    """
    for few, least in ((free, _ALIKE_FREE), (names, _ALIKE)):
        cased = recased(pattern, few)
        if cased is not None:
            return cased
        near = suggest_pattern(pattern, few)
        if near and SequenceMatcher(None, pattern, near).ratio() >= least:
            return near
    return None


POSE = "default_position"

_NAMES = {Framework.ISAACLAB: "Isaac Lab", Framework.MJLAB: "mjlab"}


def refuses_two(framework: Framework, name: str) -> bool:
    """Whether a framework raises an error where two keys of a setting match one joint."""
    return framework is Framework.ISAACLAB or (framework is Framework.MJLAB and name == "action_scale")


def order_counts(framework: Framework | None, field: str) -> bool:
    """Whether one of two keys of a field that match one joint counts by its place: mjlab's first, legged_gym's last."""
    return (framework, field) in ((Framework.MJLAB, POSE), (Framework.LEGGED_GYM, "kp"))


def meets(framework: Framework, name: str, key: str, joint: str) -> bool:
    """Whether a key of a setting is for a joint by the framework's own rule for that setting."""
    if name == POSE and framework is Framework.LEGGED_GYM:
        return key == joint
    if name == POSE and framework is Framework.MJLAB:
        try:
            return bool(match_names(f"(?:{key}).*", (joint,)))
        except PatternError:
            pass
    return bool(matching(framework, key, (joint,)))


def again(
    framework: Framework, name: str, setting: Setting, joints: Sequence[str]
) -> Iterator[tuple[str, dict[str, list[str]]]]:
    """Keys that are for joints which an earlier key is for already: the key, and each such key to those joints."""
    first: dict[str, str] = {}
    for key in setting.keys or ():
        taken: dict[str, list[str]] = {}
        for joint in joints:
            if meets(framework, name, key, joint) and first.setdefault(joint, key) != key:
                taken.setdefault(first[joint], []).append(joint)
        if taken:
            yield key, taken


def settled(
    framework: Framework, name: str, setting: Setting, joint: str, keys: Sequence[str] = ()
) -> Setting:
    """A setting with the value that the framework gives a joint, where that is not the first key's that matches it.

    Args:
        framework: Whose.
        name: Of the setting.
        setting: Values by joint; any other is given back.
        joint: The joint.
        keys: In whose order the keys count; empty: the setting's own.
    """
    value = setting.value
    if not isinstance(value, Mapping) or framework is Framework.DEPLOY:
        return setting
    own = [key for key in keys or value if key in value and meets(framework, name, key, joint)]
    if refuses_two(framework, name) and len(own) > 1:
        why = f"the keys {_quoted(own)} both match the joint, which {_NAMES[framework]} refuses"
        return Setting(None, setting.place(own[1]), why)
    if not own or framework is Framework.ISAACLAB:
        return setting
    key = own[-1] if framework is Framework.LEGGED_GYM else own[0]
    return replace(setting, value=value[key], span=setting.place(key), places={})  # type: ignore[arg-type]


def of_one_key(framework: Framework, name: str, setting: Setting, joint: str) -> Setting:
    """A setting as the only key that is for a joint has it, at the key's place; unknown where none is, or several are.

    Args:
        framework: Whose.
        name: Of the setting.
        setting: Values by joint; any other is given back.
        joint: The joint.
    """
    value = setting.value
    if not isinstance(value, Mapping):
        return setting
    keys = [key for key in value if meets(framework, name, key, joint)]
    if len(keys) != 1:
        return Setting(None, setting.span, f"{len(keys)} keys are for the joint")
    return replace(setting, value=value[keys[0]], span=setting.place(keys[0]), places={})  # type: ignore[arg-type]


def _quoted(keys: Sequence[str]) -> str:
    return " and ".join(f"'{shortened(key, 40)}'" for key in keys[:2])


def may_match(framework: Framework, key: str, joint: str) -> bool:
    """Whether a key matches a joint, or may match one that the pattern in its place stands for."""
    if key == joint or matching(framework, key, (joint,)):
        return True
    return PLAIN.fullmatch(joint) is None and overlap(key, joint)


def overlap(one: str, other: str) -> bool:
    """Whether a name could match both patterns; True where a pattern has more than plain text and `.*`."""
    tokens = [_tokens(one), _tokens(other)]
    first, second = tokens
    if first is None or second is None:
        return True
    # Row by row from the ends: whether what is left of both can be the same text.
    below = [all(token is None for token in second[j:]) for j in range(len(second) + 1)]
    for token in reversed(first):
        row = [False] * (len(second) + 1)
        row[-1] = token is None and below[-1]
        for j in range(len(second) - 1, -1, -1):
            if token is None or second[j] is None:
                row[j] = below[j] or row[j + 1]
            else:
                row[j] = token == second[j] and below[j + 1]
        below = row
    return below[0]


def _tokens(pattern: str) -> list[str | None] | None:
    """Characters, None for `.*`; None where there is more than that."""
    parts = pattern.split(".*")
    if not all(map(PLAIN.fullmatch, parts)):
        return None
    found: list[str | None] = list(parts[0])
    for part in parts[1:]:
        found += [None, *part]
    return found
