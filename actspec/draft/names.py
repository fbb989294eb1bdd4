"""Names in a draft: patterns that select exactly some joints, and names for groups of them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from types import MappingProxyType

from actspec.patterns import PatternError, covering_pattern, match_names

MAX_WRITTEN = 200
"""Longest pattern that is written [characters]: what the spec language takes as one entry of `joints`."""

_MOST_CUTS = 6
_LONGEST_CUT = 80
"""Chosen: names above this have no structure that a reader would see; they are listed."""


def _words(text: str) -> frozenset[str]:
    return frozenset(text.split())


_METACHARACTER = re.compile(r"[\\.^$*+?{}\[\]|()]")
_BEFORE = re.compile(r"(?<=[^_\-./ :])(?=[_\-./ :])|(?<=[a-z0-9])(?=[A-Z])")
_AFTER = re.compile(r"(?<=[_\-./ :])(?=[^_\-./ :])|(?<=[a-z0-9])(?=[A-Z])")

_SIDES = _words(
    "l r fl fr rl rr bl br hl hr lf rf lh rh lb rb ll lr la ra left right front rear hind back fore upper lower"
)
_SHORT = {
    "haa": "hip_abduction", "hfe": "hip_flexion", "hr": "hip_rotation", "hx": "hip_x", "hy": "hip_y", "kfe": "knee",
    "kn": "knee", "ffe": "ankle_flexion", "faa": "ankle_abduction",
}  # fmt: skip
"""Letters that joints are called by to the words of the robot. Source: ANYmal, Solo, Spot, Berkeley Humanoid."""
_PLURALS = {
    **{word: word + "s" for word in _words(
        "hip thigh knee ankle toe leg arm hand shank shin shoulder elbow wrist forearm finger thumb wheel gripper neck"
    )},
    "calf": "calves",
    "foot": "feet",
}  # fmt: skip
_GENERIC = _words("joint jnt j joints link motor act actuator")
_AXES = _words("roll pitch yaw x y z link")
"""What names no part of a robot where it stands alone."""
_LEAST_OF_AN_ARM, _FINGERS = 4, 5
"""Joints of a chain, and branches of a base, that tell what a robot without words is. Chosen: a leg on a stand has
three joints, and four branches are a quadruped's."""
_BODY_PARTS = (
    ("legs", _words("hip thigh calf knee ankle leg foot shank shin toe abduction")),
    ("arms", _words("shoulder elbow wrist arm forearm")),
    ("hands", _words("thumb index middle ring pinky little finger fingers hand palm")),
    ("torso", _words("waist torso spine head neck")),
)
_NO_WORD = re.compile(r"^actuators?_(?=[a-z])|(?<=.)_?(?:actuators?)?_?(?:cfg)?$", re.IGNORECASE)
_KEY = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
_RESERVED = _words("y n yes no on off true false null none unknown")


def escaped(name: str) -> str:
    """A name as the pattern that matches only it; unlike `re.escape`, `-`, `#` and space stay readable."""
    return _METACHARACTER.sub(lambda found: "\\" + found[0], name)


def joint_patterns(wanted: Sequence[str], names: Sequence[str]) -> tuple[str, ...]:
    """Few and short patterns that together match `wanted` and nothing else of `names`.

    `.*` for all; then, by the number of joints that each covers, common endings, beginnings, middles
    and classes of one character; what is left, by name.

    Args:
        wanted: At least one name, all of them in `names`.
        names: All joints that the patterns will be matched against.

    Raises:
        PatternError: a name is too long for any pattern.
    """
    asked = set(wanted)
    if len(asked) > 1 and asked == set(names) and covering_pattern([".*"], asked, names):
        return (".*",)
    chosen = _cover(asked, names) if len(asked) > 1 else {}
    covered = {name for found in chosen.values() for name in found}
    chosen.update({escaped(name): frozenset((name,)) for name in wanted if name not in covered})
    place = {name: index for index, name in enumerate(names)}
    ordered = sorted(chosen, key=lambda pattern: min(place[name] for name in chosen[pattern]))
    for pattern in ordered:
        if len(pattern) > MAX_WRITTEN:
            raise PatternError(
                f"a joint's name needs a pattern of {len(pattern)} characters, at most {MAX_WRITTEN}"
            )
    assert covering_pattern(ordered, asked, names)
    return tuple(ordered)


def one_pattern(wanted: Sequence[str], names: Sequence[str]) -> tuple[str, ...]:
    """As `joint_patterns`, those that differ in a word as one: `.*_wrist_(pitch|yaw)_joint`.

    Args:
        wanted: As in `joint_patterns`.
        names: Likewise.

    Raises:
        PatternError: a name is too long for any pattern.
    """
    patterns = joint_patterns(wanted, names)
    if len(patterns) < 2:
        return patterns
    split = [re.split(r"(?<=[_\-. ])|(?=[_\-. ])", pattern) for pattern in patterns]
    start, end = _shared(split), _shared([words[::-1] for words in split])[::-1]
    middles = [words[len(start) : len(words) - len(end)] for words in split]
    # One word between others that say what is meant: `.*_(yaw|elbow)_joint` is shorter, and a riddle.
    if not any(map(str.isalnum, start)) or not all(len(m) == 1 and m[0].isalnum() for m in middles):
        return patterns
    whole = "".join([*start, "(", "|".join(m[0] for m in middles), ")", *end])
    found = match_names(whole, names) if len(whole) <= MAX_WRITTEN else ()
    return (whole,) if set(found) == set(wanted) else patterns


def _cover(asked: set[str], names: Sequence[str]) -> dict[str, frozenset[str]]:
    """Patterns for two or more joints each, chosen greedily, with what they match."""
    candidates = dict(_candidates(asked, names))
    left = set(asked)
    chosen: dict[str, frozenset[str]] = {}
    while len(left) > 1:
        gains = {pattern: len(left & found) for pattern, (_, found) in candidates.items()}
        candidates = {pattern: entry for pattern, entry in candidates.items() if gains[pattern] > 1}
        if not candidates:
            break
        best = min(candidates, key=lambda p: (-gains[p], candidates[p][0], len(p), p))
        candidates.pop(best)
        # Cuts inside words may match more than they were made from: the matcher has the last word.
        try:
            found = frozenset(match_names(best, names))
        except PatternError:
            continue
        if len(best) <= MAX_WRITTEN and found <= asked and found & left:
            chosen[best] = found
            left -= found
    for pattern in list(chosen):
        others = {name for other, found in chosen.items() if other != pattern for name in found}
        if chosen[pattern] <= others:
            del chosen[pattern]
    return chosen


def _candidates(asked: set[str], names: Sequence[str]) -> Iterator[tuple[str, tuple[int, frozenset[str]]]]:
    """(pattern, (rank, names it was made from)) for patterns that no other joint makes; rank 0 reads best."""
    made: dict[str, tuple[int, set[str]]] = {}
    slots: dict[tuple[str, str], dict[str, str]] = {}
    for name in asked:
        if len(name) > _LONGEST_CUT or not name.isprintable():
            continue
        for rank, pattern in _cuts(name):
            made.setdefault(pattern, (rank, set()))[1].add(name)
        for at, character in enumerate(name):
            if character.isascii() and character.isalnum():
                slots.setdefault((name[:at], name[at + 1 :]), {})[character] = name
    for name in names:
        if name not in asked and len(name) <= _LONGEST_CUT:
            for _, pattern in _cuts(name):
                made.pop(pattern, None)
    for pattern, (rank, found) in made.items():
        yield pattern, (rank, frozenset(found))
    for (before, after), characters in slots.items():
        for same in (str.isdigit, str.islower, str.isupper):
            few = {character: name for character, name in characters.items() if same(character)}
            if len(few) > 1:
                yield f"{escaped(before)}[{_class(few)}]{escaped(after)}", (4, frozenset(few.values()))


def _cuts(name: str) -> Iterator[tuple[int, str]]:
    """Patterns that keep the end, the beginning, both, or the middle of a name."""
    ends = [found.start() for found in _BEFORE.finditer(name)][-_MOST_CUTS:]
    begins = [found.start() for found in _AFTER.finditer(name)][:_MOST_CUTS]
    for end in ends:
        yield 0, f".*{escaped(name[end:])}"
    for begin in begins:
        yield 1, f"{escaped(name[:begin])}.*"
        for end in ends:
            if begin <= end:
                yield 2, f"{escaped(name[:begin])}.*{escaped(name[end:])}"
            else:
                yield 3, f".*{escaped(name[end:begin])}.*"


def _class(characters: Iterable[str]) -> str:
    """Inside of a character class: `1-4`, `LR`, `1-37`."""
    text = ""
    run: list[str] = []
    for character in [*sorted(characters), ""]:
        if character and run and ord(character) == ord(run[-1]) + 1:
            run.append(character)
            continue
        text += f"{run[0]}-{run[-1]}" if len(run) > 2 else "".join(run)
        run = [character]
    return text


def body_part(joints: Sequence[str]) -> str | None:
    """`legs`, `arms`, `hands` or `torso` where all names are of one; None where they are not."""
    heads = {parts[0] for parts in map(_parts, joints) if parts}
    return next((name for name, known in _BODY_PARTS if heads and known.issuperset(heads)), None)


def given_name(joints: Sequence[str], given: Mapping[str, str], robot: str) -> str:
    """The name that a configuration has for exactly these joints, as a key; "" without one.

    Args:
        joints: Names, at least one.
        given: Joint to the name of its group; "" for none.
        robot: The robot's name; a word of it at the beginning goes (`GO1_HIP_ACTUATOR_CFG` is hip).
    """
    names = {given[name] for name in joints}
    if len(names) != 1 or any(given[name] in names for name in given.keys() - set(joints)):
        return ""
    name = names.pop()
    name = _NO_WORD.sub("", name.lower() if name.isupper() else name)
    first, _, rest = name.partition("_")
    if rest[:1].isalpha() and first in re.split(r"[^a-z0-9]+", robot.lower()):
        name = rest
    return name if _KEY.fullmatch(name) and name.lower() not in _RESERVED else ""


def group_name(
    joints: Sequence[str],
    taken: Iterable[str],
    above: Mapping[str, frozenset[str]] = MappingProxyType({}),
) -> str:
    """A key for a group of joints: what their names have in common, without sides and numbers: `knees`, `hip_pitch`.

    Args:
        joints: Names, at least one.
        taken: Keys that are used already.
        above: Every joint of the robot to those between it and the base, where a file says so: it tells an arm and
            fingers whose joints are called `joint1` or `Roll_21L`.
    """
    used = set(taken)
    parts = [_parts(name) for name in joints]
    choices = [_PLURALS.get(c, c) if len(joints) > 1 else c for c in _common(parts)]
    choices.append("joints")
    if _AXES.issuperset(part for words in parts for part in words):
        choices = [*_limb(joints, above)] or choices
        if len(joints) == 1 < len(above) and _KEY.fullmatch(joints[0]) and joints[0].lower() not in _RESERVED:
            choices.insert(0, joints[0])
    for choice in choices:
        if choice not in used:
            return choice
    number = 2
    while f"{choices[0]}_{number}" in used:
        number += 1
    return f"{choices[0]}_{number}"


def _limb(joints: Sequence[str], above: Mapping[str, frozenset[str]]) -> Iterator[str]:
    """What joints are whose robot is one chain, or as many branches of a base as a hand has."""
    roots = {
        name: min(chain, key=lambda other: len(above[other]), default=name) for name, chain in above.items()
    }
    branches = set(roots.values())
    if len(branches) == 1 and len(above) >= _LEAST_OF_AN_ARM:
        if sorted(map(len, above.values())) == list(range(len(above))):
            yield "arm"
    elif len(branches) == _FINGERS and len(above) > _FINGERS:
        yield "finger" if len({roots.get(name) for name in joints}) == 1 else "fingers"


def _parts(name: str) -> list[str]:
    """`left_hip_pitch_joint` to [hip, pitch]."""
    words = re.findall(r"[a-z]+", re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name).lower())
    known = [word for word in words if word not in _SIDES and word not in _GENERIC]
    # `hr` is hind right before a part, and a rotation of the hip behind a side.
    known = known or [word for word in words if word in _SHORT]
    return [part for word in known for part in _SHORT.get(word, word).split("_")]


def _common(parts: Sequence[list[str]]) -> Iterator[str]:
    """Names for the group, the best first."""
    start = _shared(parts)
    end = _shared([part[::-1] for part in parts])[::-1]
    heads = list(dict.fromkeys(p[0] for p in parts if p))
    yield from _keys(start)
    for name, known in _BODY_PARTS:
        if len(heads) > 1 and known.issuperset(heads):
            yield name
    yield from _keys(end)
    if len(heads) <= 3:
        yield from _keys(heads)


def _shared(parts: Sequence[list[str]]) -> list[str]:
    """What all lists begin with."""
    shared = []
    for words in zip(*parts, strict=False):
        if len(set(words)) > 1:
            break
        shared.append(words[0])
    return shared


def _keys(words: Sequence[str]) -> Iterator[str]:
    key = "_".join(words)
    # Several letters are somebody's sides or numbers: `ll_lr` tells nobody what it is.
    if (len(words) == 1 or any(len(word) > 2 for word in words)) and key not in _RESERVED and len(key) <= 40:
        yield key
