"""Names in a draft: patterns that select exactly some joints, and names for groups of them."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from types import MappingProxyType

from actspec.files import in_common
from actspec.joints import ARM_WORDS, END_WORDS, LEG_WORDS, SIDE_WORDS
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

_SIDES = SIDE_WORDS | END_WORDS | _words("ll lr la ra upper lower")
_HANDS = {"l": "left", "left": "left", "r": "right", "right": "right"}
_ENDS = {
    "f": "front",
    "fore": "front",
    "front": "front",
    **dict.fromkeys(_words("b h back hind rear"), "rear"),
}
_PLACES = {
    **{word: (end, "") for word, end in _ENDS.items() if len(word) > 1},
    **{word: ("", hand) for word, hand in _HANDS.items()},
    **{e + h: (_ENDS[e], _HANDS[h]) for e in "fbh" for h in "lr"},
    **{h + e: (_ENDS[e], _HANDS[h]) for e in "fbh" for h in "lr"},
    **dict.fromkeys(("rl", "lr"), ("rear", "left")),
    "rr": ("rear", "right"),
    **dict.fromkeys(("lm", "ml"), ("middle", "left")),
    **dict.fromkeys(("rm", "mr"), ("middle", "right")),
}
"""Word of a joint's name to the end and the side of the robot that it may say; `B_wheel` says the end with a letter."""
_END = re.compile(r"([bf])_([a-z]+)")
_SHORT = {
    "haa": "hip_abduction", "hfe": "hip_flexion", "hr": "hip_rotation", "hx": "hip_x", "hy": "hip_y", "kfe": "knee",
    "kn": "knee", "ffe": "ankle_flexion", "faa": "ankle_abduction", "akp": "ankle_pitch", "akr": "ankle_roll",
    "wrj": "wrist", "thj": "thumb", "ffj": "finger", "mfj": "finger", "rfj": "finger", "lfj": "finger",
    "grip": "gripper",
}  # fmt: skip
"""Letters that joints are called by to the words of the robot. Source: ANYmal, Solo, Spot, Berkeley Humanoid, Shadow
Hand; chosen: akp and akr, of an ankle alone."""
_FINGER = re.compile(r"(?<![a-z])([lr]_(?:th|[fmrl]f))_(?=j[0-9])")
"""A finger's letters between a hand's side and a joint's number: `R_rf_j1`, as `rh_RFJ1` of the Shadow Hand."""
_OF_ARMS = {"sh": "shoulder", "el": "elbow", "fa": "forearm"}
_TURNS = {"fle": "flexion", "rot": "rotation"}
"""What stands before these: `SH_ROT`, `EL_FLE` of ANYbotics' DynaArm. Elsewhere `el` may be an elevation."""
_PLURALS = {
    **{word: word + "s" for word in _words(
        "hip thigh knee ankle toe leg arm hand shank shin shoulder elbow wrist forearm finger thumb wheel gripper"
    )},
    "calf": "calves",
    "foot": "feet",
}  # fmt: skip
_GENERIC = _words(
    "joint jnt j joints link motor act actuator robot armature rx ry rz zero one two three four five six seven"
)
_AXES = _words("roll pitch yaw x y z link")
"""What names no part of a robot where it stands alone."""
_LEAST_OF_AN_ARM, _FINGERS = 4, 5
"""Joints of a chain, and branches of a base, that tell what a robot without words is. Chosen: a leg on a stand has
three joints, and four branches are a quadruped's."""
_JOINTS_OF_ARMS = 7
"""Joints of each of two equal chains that are arms. Chosen: legs have at most six."""
_LONGEST_CODE = 3
"""Letters of a word that nobody reads as one. Chosen: `hip` and `toe` are words of a robot; `sh`, `akp` are codes."""
_LEAST_OF_A_ROW = 6
"""Joints that differ in a number alone and are taken for an arm where no file says how they hang together. Chosen: arms
have six or seven."""
_BODY_PARTS = (
    ("legs", LEG_WORDS),
    ("arms", ARM_WORDS),
    ("hands", _words("thumb index middle ring pinky little finger fingers hand palm")),
    (
        "torso",
        _words(
            "waist torso trunk chest spine head neck pelvis lowerback upperback abdomen thorax lumbar thoracic cervical"
        ),
    ),
)
_HEAD = _words("head neck")
_OTHER_PARTS = {"wheel": "wheels", "gripper": "hands"}
_PART_OF = {**{word: name for name, known in _BODY_PARTS for word in known}, **_OTHER_PARTS}
"""Word of a robot to the part of its body."""
_OF_A_PRODUCT = re.compile(r"[a-z]{3,}(arm|hand)")
"""A product's name that says what it is, where nothing else does: `openarm_left_joint1`, `orcahand`."""
_ONE_OR_MORE = _words("arm finger thumb wheel")
"""Parts that may have several joints: a chain of them is one."""
_AMBIGUOUS = _words("middle index ring little")
"""Fingers, beside words of a hand."""
_JOINED = re.compile(
    f"(?P<side>left|right|lower|upper|[lrbfu])?({'|'.join(sorted(_PART_OF, key=len, reverse=True))})(?:r?([xyz]))?"
)
"""A side, a part and an axis without anything between them: `lhumerusrx`."""
_SIDE_AT_END = re.compile(r"(?<=[a-z]{3})(?:left|right)$")
_MODEL = re.compile(r"[a-z]+[0-9]+[a-z][a-z0-9]*|[a-z][0-9]{2,}")
"""The number of a model or of a camera: `j2s6s200`, `d435`."""
_NO_GROUP = _words("all default dummy base main body")
"""What a configuration calls a group without saying what is in it."""
_NO_WORD = re.compile(r"^actuators?_(?=[a-z])|(?<=.)_?(?:actuators?)?_?(?:cfg)?$", re.IGNORECASE)
_UNUSED = re.compile(r"not_?used?")
_KEY = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
_LONGEST_KEY = 40 - len("front_right_")
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
    """`legs`, `arms`, `hands`, `torso` or `wheels` where all names are of one; None where they are not."""
    found = {_PART_OF.get(parts[0]) for parts in map(_parts, joints) if parts}
    return found.pop() if len(found) == 1 else None


def parts_of_body(joints: Iterable[str]) -> dict[str, str | None]:
    """The part of the body of each of a robot's joints, as `body_part` has it.

    A joint whose words say nothing is of the leg whose end and side it has: `FL_collar` beside `FL_hip` and `FL_knee`.
    """
    known = {name: body_part([name]) for name in joints}
    corners = {name: place for name in known if all(place := _place(name))}
    legs = {corners[name] for name in corners if known[name] == "legs"}
    others = {corners[name] for name in corners if known[name] not in ("legs", "wheels", None)}
    bare = {name for name, place in corners.items() if place in legs - others and not _has_part(name)}
    return {name: "legs" if name in bare else part for name, part in known.items()}


def given_name(joints: Sequence[str], given: Mapping[str, str], robot: str, *, whole: bool = True) -> str:
    """The name that a configuration has for exactly these joints, as a key; "" without one.

    In small letters, as all names of groups: `N7520_14p3` beside `m107_15`, `leftKnee` as left_knee.

    Args:
        joints: Names, at least one.
        given: Joint to the name of its group; "" for none.
        robot: The robot's name; a word of it at the beginning goes (`GO1_HIP_ACTUATOR_CFG` is hip).
        whole: Whether the name may not be one of other joints too.
    """
    names = {given[name] for name in joints}
    if len(names) != 1 or (whole and any(given[name] in names for name in given.keys() - set(joints))):
        return ""
    name = names.pop()
    name = _NO_WORD.sub("", re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower())
    first, _, rest = name.partition("_")
    if rest[:1].isalpha() and first in _of_robot(robot):
        name = rest
    return name if _is_key(name) else ""


def _of_robot(robot: str) -> list[str]:
    """Words of a robot's name."""
    return re.split(r"[^a-z0-9]+", robot.lower())


def _is_key(name: str) -> bool:
    return _KEY.fullmatch(name) is not None and name.lower() not in _RESERVED


def group_name(
    joints: Sequence[str],
    taken: Iterable[str],
    above: Mapping[str, frozenset[str]] = MappingProxyType({}),
    given: Mapping[str, str] = MappingProxyType({}),
    robot: str = "",
) -> str:
    """A key for a group of joints: what their names have in common, without sides and numbers: `knees`, `hip_pitch`.

    Args:
        joints: Names, at least one.
        taken: Keys that are used already.
        above: Every joint of the robot to those between it and the base, where a file says so: it tells an arm and
            fingers whose joints are called `joint1` or `Roll_21L`.
        given: Every joint to what a configuration calls its group: that of joints without words.
        robot: The robot's name, which is no word for several of its joints.
    """
    used = set(taken)
    parts = [_parts(name) for name in joints]
    side = _own_side(joints, parts, given)
    if len(joints) > 1:
        # Words of joints have no numbers: `b` of `b2_FL_hip_joint`.
        model = {re.sub(r"[0-9]+", "", word) for word in _of_robot(robot)}
        own = [word for word in _shared(parts) if word in model and word not in _PART_OF]
        parts = [[word for word in words if word not in own] for words in parts]
    called = given_name(joints, given, robot, whole=False) if given else ""
    called = "" if called.lower() in {*_NO_GROUP, *_of_robot(robot)} else called
    choices = []
    if all(parts):
        one = called == "arm" or _is_one_arm(joints, above)
        alone = _ONE_OR_MORE if above and one else ()
        of_legs = [name for name, part in parts_of_body(given or joints).items() if part == "legs"]
        legs = all(name in of_legs for name in joints)
        choices = [
            _PLURALS.get(c, c) if len(joints) > 1 and c not in alone else c for c in _common(parts, legs=legs)
        ]
        choices = ["arm" if c == "arms" and one else c for c in (*choices, *_mixed(parts))]
    if choices and len(choices[0]) == 1 < len(joints):
        # `a` of `L_A0`, `R_A1` tells nobody what it is.
        choices = []
    elif choices and _is_code(choices[0], called) and _is_key(whole := f"{called}_{choices[0]}"):
        choices = [whole, *choices]
    choices = [side + choice for choice in choices]
    known = any(word in _PART_OF for words in parts for word in words)
    row = len(joints) > 1 and len({re.sub(r"[0-9]+", "0", name) for name in joints}) == 1
    if not choices or _AXES.issuperset(word for words in parts for word in words) or (row and not known):
        named = [called] if called else []
        single = [joints[0]] if len(joints) == 1 < len(above) and _is_key(joints[0]) else []
        guess = ["arm"] if row and not above and len(joints) >= _LEAST_OF_A_ROW else []
        told = [limb for word, limb in (("hand", "fingers"), ("arm", "arm")) if word in _of_robot(robot)]
        told += _numbered(joints) if len(joints) < len(given) else []
        limbs = [side + limb for limb in _limb(joints, above)]
        choices = [*limbs, *named, *guess, *single] or choices or [side + word for word in (*told, "joints")]
    for choice in choices:
        if choice not in used:
            return choice
    numbers = _numbers(joints)
    if numbers and (numbered := f"{choices[0]}_{numbers[1]}") not in used and _is_key(numbered):
        return numbered
    number = 2
    while f"{choices[0]}_{number}" in used:
        number += 1
    return f"{choices[0]}_{number}"


def _is_code(key: str, called: str) -> bool:
    """Whether a key is letters alone that no word of a robot is among, nor one of what the group is called."""
    known = called.split("_")
    return bool(called) and all(
        len(word) <= _LONGEST_CODE and word not in _PART_OF and word not in known for word in key.split("_")
    )


def _numbered(joints: Sequence[str]) -> list[str]:
    """What joints are of which only a number behind a letter tells: `j3`, `j4_j5`, `j0_to_j2`; nothing of others."""
    told = _numbers(joints)
    key = re.sub(r"[0-9]+", lambda found: f"{told[0]}{found[0]}", told[1]) if told else ""
    return [key] if key and len(key) <= _LONGEST_KEY else []


def _numbers(joints: Sequence[str]) -> tuple[str, str] | None:
    """What stands before the numbers of joints that nothing else tells apart, and those: `4_5`, `0_to_2`."""
    split = [re.fullmatch(r"(.*?[a-z]+)_?([0-9]{1,3})", "_".join(_bare(name))) for name in joints]
    found = [(each[1], int(each[2])) for each in split if each is not None]
    numbers = sorted({number for _, number in found})
    if len(found) < len(joints) or len({stem for stem, _ in found}) > 1:
        return None
    if len(numbers) > 2 and numbers[-1] - numbers[0] >= len(numbers):
        return None
    ends = dict.fromkeys((str(numbers[0]), str(numbers[-1])))
    return found[0][0], ("_to_" if len(numbers) > 2 else "_").join(ends)


def _bare(name: str) -> list[str]:
    """The words and numbers of a name without its sides: [j3] of `L_J3`, [arm, 4] of `arm_left_4_joint`."""
    words = [word for word in re.findall(r"[a-z0-9]+", name.lower()) if word not in _SIDES]
    return words[:-1] if words[1:] and words[-1] in _GENERIC else words


def _is_one_arm(joints: Sequence[str], above: Mapping[str, frozenset[str]]) -> bool:
    """Whether joints are one chain; where no file says so, whether nothing in their names counts or takes sides."""
    if above:
        chain = sorted(joints, key=lambda name: len(above.get(name, ())))
        return all(before in above.get(name, ()) for before, name in pairwise(chain))
    names = [re.sub(r"[0-9]+", "", name) for name in joints]
    words = [word for name in names for word in _tokens(name)]
    return len({*names}) == len(names) and all(w not in _SIDES and _sideless(w) == [w] for w in words)


def _own_side(joints: Sequence[str], parts: Sequence[list[str]], every: Iterable[str]) -> str:
    """End and side of joints that have both in common and whose counterparts are in other groups; "" else.

    `right_` of a right hip alone, `rear_left_` of one of four.
    """
    places = {_place(name) for name in joints}
    own = [one.pop() if len(one) == 1 else "" for one in ({place[at] for place in places} for at in (0, 1))]
    others = [name for name in every if name not in joints and _place(name) not in (("", ""), *places)]
    if not all(words in map(_parts, others) for words in parts):
        return ""
    alike = [_place(name) for name in others if _parts(name) in parts]
    return "".join(f"{word}_" for at, word in enumerate(own) if word and any(o[at] != word for o in alike))


def _place(name: str) -> tuple[str, str]:
    """`front` or `rear` and `left` or `right`, where words of a joint's name may say so; "" where none does."""
    sides = [word for word in _tokens(name) if word in _SIDES]
    # Behind another side, `hr` is a hip's rotation.
    words = [_PLACES[word] for word in sides if word in _PLACES and (word not in _SHORT or len(sides) == 1)]
    joined = [_JOINED.fullmatch(word) for word in _tokens(name) if word not in _PART_OF]
    letters = [match["side"] for match in joined if match]
    letter = _END.match(name.lower())
    if letter and letter[2] in _PART_OF:
        letters.append(letter[1])
    words += [(_ENDS.get(each, ""), _HANDS.get(each, "")) for each in letters]
    found = [{place[at] for place in words if place[at]} for at in (0, 1)]
    end, hand = (one.pop() if len(one) == 1 else "" for one in found)
    return end, hand


def _limb(joints: Sequence[str], above: Mapping[str, frozenset[str]]) -> Iterator[str]:
    """What joints without words are: of the one chain that has none, or of as many branches as a hand has."""
    branches: dict[str, list[str]] = {}
    roots = {
        name: min(chain, key=lambda other: len(above[other]), default=name) for name, chain in above.items()
    }
    for name, root in roots.items():
        branches.setdefault(root, []).append(name)
    own = {roots.get(name, "") for name in joints}
    chains = {root: _chain(names, above) for root, names in branches.items()}
    arms = [root for root, chain in chains.items() if len(chain) >= _LEAST_OF_AN_ARM]
    if len(own) == 1 and own == set(arms):
        if own_chain := [name for name in joints if name in chains[arms[0]]]:
            single = f"arm_{joints[0]}"
            yield single if joints == own_chain and len(joints) == 1 and _is_key(single) else "arm"
    elif own <= set(arms) and len(arms) == 2 and len({len(chains[root]) for root in arms}) == 1:
        held = [any(body_part([name]) == "hands" for name in branches[root]) for root in arms]
        if all(held) or len(chains[arms[0]]) == _JOINTS_OF_ARMS:
            yield "arms"
    elif len(branches) == _FINGERS and len(above) > _FINGERS and not any(map(_has_part, above)):
        yield "finger" if len(own) == 1 else "fingers"


def _chain(names: Sequence[str], above: Mapping[str, frozenset[str]]) -> list[str]:
    """Joints without words of a branch that all others of it are above or below of: an arm before its hand."""
    below = Counter(other for name in names for other in above[name])
    return [n for n in names if below[n] + len(above[n]) + 1 == len(names) and not _has_part(n)]


def _has_part(name: str) -> bool:
    """Whether a joint's name has a word for a part of the body."""
    return any(word in _PART_OF for word in _parts(name))


def _mixed(parts: Sequence[list[str]]) -> Iterator[str]:
    """What joints of several parts of the body are: `legs_wheels`, `upper_body`, `body`."""
    found = {_PART_OF[words[0]]: None for words in parts if words[0] in _PART_OF}
    all_known = all(words[0] in _PART_OF for words in parts)
    if {"torso"} < found.keys() <= {"torso", "arms", "hands"}:
        yield "upper_body"
    elif found.keys() == {"arms", "hands"}:
        yield "arms"
    elif len(found) > 2 or (len(found) == 2 and not all_known):
        yield "body"
    elif len(found) == 2:
        yield "_".join(sorted(found))


def _parts(name: str) -> list[str]:
    """`left_hip_pitch_joint` and `LHipPitch` to [hip, pitch]; `not_use_joint` to [unused]."""
    words = [part for word in _tokens(name) for part in _sideless(word)]
    known = [word for word in words if word not in _SIDES and word not in _GENERIC]
    if known[1:] and known[0] in ("b", "f") and known[1] in _PART_OF:
        known = known[1:]
    product = None if not known or known[0] in _PART_OF else _OF_A_PRODUCT.fullmatch(known[0])
    if product:
        # What is mounted on an arm has a word of its own.
        other = any(word in _PART_OF or len(word) > _LONGEST_CODE for word in known[1:] if word not in _AXES)
        known = known[1:] if other and product[1] == "arm" else [product[1], *known[1:]]
    if "to" in known[1:-1] and known[-1] in _PART_OF:
        # `torso_to_thigh`: what it moves.
        known = known[len(known) - known[::-1].index("to") :]
    if len(known) > 1 and known[0] == "middle" and _PART_OF.get(known[1], "hands") != "hands":
        known = known[1:]
    if known[1:] and known[-1] in _TURNS:
        known = [*(_OF_ARMS.get(word, word) for word in known[:-1]), _TURNS[known[-1]]]
    # `hr` is hind right before a part, and a rotation of the hip behind a side.
    known = known or [word for word in words if word in _SHORT]
    return [part for word in known for part in _SHORT.get(word, word).split("_")]


def _tokens(name: str) -> list[str]:
    """The words of a name, in small letters, without numbers of models."""
    text = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z]{2})", "_", name).lower()
    text = _FINGER.sub(r"\1", text)
    tokens = [token for token in re.split(r"[^a-z0-9]+", text) if not _MODEL.fullmatch(token)]
    return re.findall(r"[a-z]+", _UNUSED.sub("unused", "_".join(tokens)))


def _sideless(word: str) -> list[str]:
    """`rleg`, `finright` and `lshoulderrx` without the side, the axis apart."""
    joined = None if word in _PART_OF else _JOINED.fullmatch(word)
    return [_SIDE_AT_END.sub("", word)] if joined is None else [part for part in joined.groups()[1:] if part]


def _common(parts: Sequence[list[str]], *, legs: bool) -> Iterator[str]:
    """Names for the group, the best first; `legs`: whether all are joints of legs, whatever their words say."""
    start = _shared(parts)
    end = _shared([part[::-1] for part in parts])[::-1]
    heads = list(dict.fromkeys(p[0] for p in parts))
    yield from _keys(start)
    for name, known in _BODY_PARTS:
        # A head and its neck are no torso.
        whole = known.issuperset(heads) or (legs and name == "legs" and not known.isdisjoint(heads))
        if len(heads) > 1 and whole and not _HEAD.issuperset(heads):
            yield name
    if not _AXES.issuperset(end):
        yield from _keys(end)
    # Of a waist and what is mounted on it, the waist.
    told = [word for word in heads if word in _PART_OF.keys() - _AMBIGUOUS] or heads
    # Of a head, hips, knees and what else (`sho`, `ank`) they are not all.
    some = len(told) < len(heads) and len({_PART_OF.get(word) for word in told}) > 1
    if len(told) <= 3 and not some:
        yield from _keys(told)


def _shared(parts: Sequence[list[str]]) -> list[str]:
    """What all lists begin with."""
    first, last = min(parts), max(parts)
    return first[: in_common(first, last)]


def _keys(words: Sequence[str]) -> Iterator[str]:
    key = "_".join(words)
    # Several letters are somebody's sides or numbers: `ll_lr` tells nobody what it is.
    if (
        (len(words) == 1 or any(len(word) > 2 for word in words))
        and key not in _RESERVED
        and len(key) <= _LONGEST_KEY
    ):
        yield key
