"""Which artifacts describe the same robot.

Joint names alone do not tell: every quadruped of one vendor has the same, and so have most humanoids. What must be
shared beside them is the robot's name, or its folder, or a reference to the file; and figures may speak against it,
because every pendulum is called so: a Go1 and a Go2 are never compared by accident.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Collection, Iterable, Sequence
from functools import cache, lru_cache

from actspec.files import in_common
from actspec.patterns import PatternError, match_names
from actspec.readings.artifact import Artifact, FileKind, Framework, Robot, RobotConfig
from actspec.readings.body import BODY, SHARE, Figures, are_alike, figures_of, share_a_body
from actspec.readings.pair_lone import with_deploy_files, with_mappings, with_runs

VARIANT = 0.5
"""Patterns that must match where the names say that it is the same robot. Chosen: a cfg for a robot with hands
belongs to the model without them."""

_FOLDERS = 3
"""Folders above a file whose names tell robots of one family apart. Chosen: `anymal_b_description/urdf/anymal.urdf`."""

# fmt: off
_GENERIC = frozenset((
    "dof",
    "robot", "robots", "scene", "model", "mujoco", "mjcf", "urdf", "usd", "xml", "xmls", "cfg",
    "config", "configs", "description", "rev", "flat", "rough", "terrain", "env", "task", "train",
    "play", "deploy", "actuator", "actuators", "articulation", "articulations", "constants",
    "joint", "joints", "minimal", "main", "base", "hand", "hands", "handless", "with", "custom",
    "copy", "new", "old", "test", "mjx", "feetonly", "position", "torque", "motor", "velocity",
    "unitree", "asset", "assets", "source", "the", "and", "of", "my", "models", "resources", "data", "src",
))

_KINDS = frozenset((
    "humanoid", "humanoids", "biped", "bipedal", "quadruped", "quadrupeds", "quadrupedal", "hexapod", "legged",
    "wheeled", "wheel", "leg", "legs", "dog", "arm", "arms", "gripper", "manipulator", "mobile", "procedural",
    "generated", "walker", "pendulum", "cartpole",
))
# fmt: on
"""Words that say nothing about which robot it is (the first), and what kind of robot it is. Chosen: from the names in
the surveyed repositories."""

_NUMBERED = re.compile(r"(?!(?:v|ver|rev|run|exp|seed|scene|task|copy|test)\d)([a-z]+)\d")
"""Letters before the first digit of a word, which are a family's; not of versions and runs."""

_LIKE_A_ROBOT = re.compile(r"(?!v\d)[a-z]{1,2}\d")
"""How many robots are called: `a1`, `go2`, `h1`, `x30`; what a policy does is no such word. Chosen: longer words with a
number, `walk2`, may be any."""

_WORD = re.compile(r"[A-Z]+(?=[A-Z][a-z])|[A-Z]?[a-z]+[0-9]*|[A-Z]+[0-9]*|[0-9]+[a-z]*")


def pair(
    artifacts: Sequence[Artifact],
    spec: str | None = None,
    by_hand: Collection[int] = (),
    records: Collection[int] = (),
) -> tuple[Robot, ...]:
    """Put the artifacts of one robot together.

    Artifacts that name their joints (models, specs, deploy files) come together when they share joints and the
    robot's name; a file that is called nothing belongs to those of its folder, or to the only one with its joints. A
    configuration joins the robot whose file it names, or that of its name where at least half of its patterns match a
    joint, else the one whose joints all of its patterns match and that nothing tells from it, such as another name that
    it shares with its own file; where several do, none: nothing is guessed; without a robot,
    the deploy file that has its keys. A file without a name beside several robots is of the one whose joints are most
    nearly its own; a deploy file beside what a run recorded is called as that is. What a run recorded joins the one
    configuration that was named with its patterns and its model, and a deploy file that somebody named what was named
    with it and has the same joints, where nothing else has them. Ranges of randomisation without actuators join the
    robot that their file's name tells, or the only one. Models that somebody named are one robot where they
    have one body, and one name inside or the same joints: else a wrong figure in `arm2.xml` is never compared with
    `arm1.xml`, nor one in `my_arm.xml`.

    Args:
        artifacts: All robots of all files.
        spec: File of the spec that the user holds the others to: what names its joints is its robot, whatever it
            is called, and so is the one configuration of a file. None: there is none.
        by_hand: Indices of those whose files were named, and not met in a folder.
        records: Indices of those that a training wrote of itself.

    Returns: Every artifact in exactly one robot, in the order of the files.
    """
    names = [joint_names(artifact) for artifact in artifacts]
    sets = [frozenset(own or ()) for own in names]
    calls = _called_as_their_runs([_names_of(artifact) for artifact in artifacts], artifacts, records)
    words = [own or folder for own, folder in calls]
    figures = cache(lambda index: figures_of(artifacts[index].robot))

    def agree(one: int, other: int) -> bool:
        # A file without a name of its own goes by its folder, which says nothing against the file beside it.
        unnamed = not calls[one][0] or not calls[other][0]
        named = _agree(words[one], words[other]) or (unnamed and bool(calls[one][1] & calls[other][1]))
        if one in by_hand and other in by_hand and not named:
            alike = _is_called_alike(artifacts[one], artifacts[other])
            named = (alike or sets[one] == sets[other]) and share_a_body(
                figures(one), figures(other), names=alike
            )
        if _says_nothing(words[one], words[other]):
            # Called nothing, or after its kind only: a humanoid of another folder is another one.
            named = named or _home(artifacts[one].path) == _home(artifacts[other].path)
        return named and not _told_apart(
            artifacts[one].path, artifacts[other].path, words[one] & words[other]
        )

    def overlap(one: int, other: int) -> bool:
        mine, its = sets[one], sets[other]
        called = (words[one] <= words[other] or words[other] <= words[one]) and bool(
            words[one] & words[other]
        )
        named = called and {one, other} <= set(by_hand)
        return _overlap(mine, its) or (named and (_is_but_one(mine, its) or _are_renamed(mine, its)))

    held = next((names[i] for i, a in enumerate(artifacts) if a.spec is not None and a.path == spec), None)
    bound = {
        i for i, own in enumerate(names) if held and own is not None and _overlap(sets[i], frozenset(held))
    }
    groups: list[list[int]] = []
    # What is called nothing fits too many, and is put to those that are called something.
    for index in sorted(range(len(names)), key=lambda i: not calls[i][0]):
        if names[index] is None:
            continue
        fitting_groups = (
            group
            for group in groups
            if all((overlap(index, i) and agree(index, i)) or {index, i} <= bound for i in group)
            and any(
                {index, i} <= bound
                or _may_be_one(artifacts, figures, index, i, 3 if words[index] == words[i] else 2)
                for i in group
            )
        )
        home = (
            next(fitting_groups, None)
            if calls[index][0]
            else _nearest(sets, calls, index, list(fitting_groups))
        )
        if home is None:
            groups.append([index])
        else:
            home.append(index)
    groups = _with_nameless(groups, words, sets)
    named = [tuple(group) for group in groups]
    unnamed = [i for i, own in enumerate(names) if own is None]
    configs = [i for i in unnamed if not _is_events(artifacts[i])]
    joints_of = [[n for i in group for n in names[i] or ()] for group in named]
    for index in configs:
        only = sum(artifacts[i].path == artifacts[index].path for i in configs) == 1
        if bound and only and fits(artifacts[index].config, held or ()):
            next(group for group in groups if min(bound) in group).append(index)
            continue
        fitting = [g for g, joints in enumerate(joints_of) if fits(artifacts[index].config, joints)]
        alike = _that_is_named(artifacts, index, named) or [
            g
            for g, joints in enumerate(joints_of)
            if any(_shared(words[index], words[i]) for i in named[g])
            and fits(artifacts[index].config, joints, VARIANT)
        ]
        others = [
            artifacts[i].config
            for i in configs
            if artifacts[i].path == artifacts[index].path and not _agree(words[i], words[index])
        ]
        silent = [
            g
            for g in fitting
            if any(agree(index, i) for i in named[g])
            and not _is_outdone(artifacts[index].config, others, joints_of[g])
        ]
        sole = len(named) == 1 and (only or not calls[index][0]) and says_something(artifacts[index].config)
        alone = [
            g
            for g in fitting
            if sole
            and not _is_of_another(artifacts[index], [calls[i] for i in named[g]])
            and not any(
                artifacts[i].kind is FileKind.DEPLOY and _are_two(calls[index], calls[i]) for i in named[g]
            )
        ]
        choice = next((found for found in (alike, silent, alone) if len(found) == 1), None)
        if choice is None or (not alike and len(fitting) > 1):
            groups.append([index])
        else:
            groups[choice[0]].append(index)
    groups = with_mappings(groups, artifacts, _overlap, agree)
    groups = with_runs(groups, artifacts, records, by_hand, agree)
    groups = with_deploy_files(
        groups,
        artifacts,
        by_hand,
        lambda one, other: has_joints(artifacts[one], sets[other]),
        lambda one, other: _are_two(calls[one], calls[other]),
    )
    for index in unnamed:
        if _is_events(artifacts[index]):
            called = words[index] | telling(_stem(artifacts[index].path))
            named_so = [group for group in groups if any(called & words[i] for i in group)]
            homes = named_so if len(named_so) == 1 else groups if not named_so and len(groups) == 1 else []
            if homes:
                homes[0].append(index)
            else:
                groups.append([index])
    robots = [
        Robot(_name(artifacts, words, sorted(group)), tuple(sorted(group))) for group in groups if group
    ]
    return tuple(sorted(robots, key=lambda robot: robot.artifacts))


def _called_as_their_runs(
    calls: Sequence[tuple[frozenset[str], frozenset[str]]],
    artifacts: Sequence[Artifact],
    records: Collection[int],
) -> list[tuple[frozenset[str], frozenset[str]]]:
    """What artifacts are called, a deploy file as what the run that exported it recorded beside it."""
    found = list(calls)
    for index in range(len(artifacts)):
        runs = {calls[i] for i in runs_of(artifacts, index, records)}
        own = runs.pop() if len(runs) == 1 else calls[index]
        found[index] = own if own[0] else calls[index]
    return found


def runs_of(artifacts: Sequence[Artifact], index: int, records: Iterable[int]) -> tuple[int, ...]:
    """What the run recorded that a deploy file is of: both stand in one folder, `params`; none for any other file.

    Args:
        artifacts: All of them.
        index: The deploy file.
        records: Indices of what trainings wrote of themselves.
    """
    folder = os.path.dirname(artifacts[index].path)
    if artifacts[index].kind is not FileKind.DEPLOY:
        return ()
    return tuple(i for i in records if os.path.dirname(artifacts[i].path) == folder)


def _nearest(
    sets: Sequence[frozenset[str]],
    calls: Sequence[tuple[frozenset[str], frozenset[str]]],
    index: int,
    groups: Sequence[list[int]],
) -> list[int] | None:
    """The first group with most of a file's joints and fewest others; None where another one is of another robot."""
    nearness = [
        max(len(sets[index] & sets[i]) / len(sets[index] | sets[i]) for i in group) for group in groups
    ]
    tied = [group for group, near in zip(groups, nearness, strict=True) if near == max(nearness)]
    members = [i for group in tied for i in group]
    apart = any(_are_two(calls[one], calls[other]) for one in members for other in members)
    return None if apart or not tied else tied[0]


def _is_outdone(
    config: RobotConfig | None, others: Iterable[RobotConfig | None], joints: Sequence[str]
) -> bool:
    """Whether one of other configurations, all of whose patterns match a joint too, has more of the joints."""
    own = len(_selected(config, joints))
    return any(fits(other, joints) and len(_selected(other, joints)) > own for other in others)


def _selected(config: RobotConfig | None, joints: Sequence[str]) -> set[str]:
    """The joints that a configuration's patterns match."""
    patterns = [key for group in config.groups for key in group.joints or ()] if config is not None else []
    return (
        {joint for key in patterns for joint in matching(config.framework, key, joints)} if config else set()
    )


def _with_nameless(
    groups: Sequence[list[int]], words: Sequence[frozenset[str]], sets: Sequence[frozenset[str]]
) -> list[list[int]]:
    """Groups, a file that is called nothing in the only one that has all of its joints."""
    found = list(groups)
    for group in groups:
        others = [other for other in found if other is not group and sets[group[0]] <= sets[other[0]]]
        if len(group) == 1 and sets[group[0]] and not words[group[0]] and len(others) == 1:
            others[0].extend(group)
            found.remove(group)
    return found


def _that_is_named(artifacts: Sequence[Artifact], index: int, groups: Sequence[Sequence[int]]) -> list[int]:
    """The groups with the model whose file a configuration names; none where it is called as any may be."""
    config = artifacts[index].config
    named = (config.model if config is not None else None) or ""
    found = {i: agreement(named, one.path) for i, one in enumerate(artifacts) if one.robot is not None}
    most = max(found.values(), default=0)
    # `robot.urdf` may be any; `PF_TRON1A/urdf/robot.urdf` is one.
    told = "-".join(os.path.splitext(named.replace("\\", "/"))[0].split("/")[-most:]) if most else ""
    if not telling(told) - _KINDS:
        return []
    return [
        g
        for g, group in enumerate(groups)
        if any(found.get(i) == most for i in group)
        and fits(config, [n for i in group for n in joint_names(artifacts[i]) or ()], VARIANT)
    ]


def _is_of_another(artifact: Artifact, robot: Iterable[tuple[frozenset[str], frozenset[str]]]) -> bool:
    """Whether a configuration has the name of the model that it loads, and a robot's files and folders have others.

    `TROTTER_CFG` of `trotter.usd` is not `strider.urdf`'s; one name alone may be a task's, or a copy's.
    """
    model = ((artifact.config.model if artifact.config is not None else None) or "").replace("\\", "/")
    files, folders = (frozenset().union(*each) for each in zip(*robot, strict=True))
    if not (telling(artifact.name) & telling(_stem(model))) - _KINDS or not files - _KINDS:
        return False
    theirs = files | folders
    return not any(a in b or b in a for a in telling(artifact.name) | telling(model) for b in theirs)


def agreement(named: str, path: str) -> int:
    """How many names of two paths agree from the end on: of `d1/urdf/robot.urdf` and `d2/urdf/robot.usd` two."""
    here, there = (os.path.splitext(each.replace("\\", "/"))[0].split("/")[::-1] for each in (named, path))
    return in_common(here, there)


def _stem(path: str) -> str:
    return os.path.splitext(os.path.basename(path))[0]


def _is_events(artifact: Artifact) -> bool:
    """Whether a configuration has ranges and no actuators: what it randomises is in other files of its robot."""
    config = artifact.config
    return config is not None and not config.groups and bool(config.randomize)


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


_COUNTED = re.compile(r"(.*?)(\d{1,3})(\D*)", re.DOTALL)


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


def distinctive(artifact: Artifact) -> frozenset[str]:
    """What the artifact is called, in words that tell robots apart: `go2`, `h1_2`, `anymal_c`."""
    own, folder = _names_of(artifact)
    return own or folder


def _names_of(artifact: Artifact) -> tuple[frozenset[str], frozenset[str]]:
    """Telling words of the artifact's own name, and of its folder."""
    stem = _stem(artifact.path)
    folder = os.path.basename(os.path.dirname(os.path.abspath(artifact.path)))
    own = telling(artifact.name)
    if artifact.config is None or artifact.config.framework is Framework.DEPLOY:
        own |= telling(stem)
    own = own or telling(stem) or _included(artifact)
    inside = _of_its_joints(artifact)
    # The more exact name counts: a scene called `h1` with `h1_2.xml` is an H1-2.
    own = frozenset(word for word in own if not any(i != word and i.startswith(word) for i in inside))
    return own | inside, telling(folder)


def _included(artifact: Artifact) -> frozenset[str]:
    """Telling words of the files that a model includes: a scene is of the robot in it."""
    files = () if artifact.robot is None else artifact.robot.files[1:]
    return frozenset(word for file in files for word in telling(_stem(file.path)))


def _of_its_joints(artifact: Artifact) -> frozenset[str]:
    """Telling words of the included file that all joints of a model are in: `stairs.xml` with `go2.xml` is a Go2.

    An arm with a gripper of another file is none.
    """
    paths = {joint.span.path for joint in artifact.robot.joints} if artifact.robot is not None else set()
    return telling(_stem(paths.pop())) if len(paths) == 1 and artifact.path not in paths else frozenset()


@lru_cache(maxsize=1024)  # a folder's files share most of it
def telling(text: str) -> frozenset[str]:
    """Words of a name that tell robots apart."""
    return frozenset(_words(text))


def _words(text: str) -> Iterable[str]:
    joined: list[str] = []
    for found in _WORD.findall(text.replace("MuJoCo", "mujoco")):
        word = found.lower()
        # `h1_2` and `anymal_c`: one letter or digit belongs to the word before it.
        if len(word) == 1 and joined and joined[-1] not in _GENERIC:
            joined[-1] += f"_{word}"
        else:
            joined.append(word)
    return [
        word
        for word in joined
        if word not in _GENERIC and len(word) > 1 and not re.fullmatch(r"[0-9]+(?:dof|kg|hz)?(?:_\d)?", word)
    ]


def _shared(one: frozenset[str], other: frozenset[str]) -> frozenset[str]:
    """The words by which two names are of one robot: of its kind where neither has any other."""
    common = one & other
    return common - _KINDS or (common if one <= _KINDS and other <= _KINDS else frozenset())


def _says_nothing(one: frozenset[str], other: frozenset[str]) -> bool:
    """Whether names tell neither that it is one robot nor that it is two."""
    return not _shared(one, other) and (not one or not other or bool(one & other))


def _home(path: str) -> str:
    """The folder of a file, without those that only say what kind of files are in them."""
    parts = os.path.dirname(os.path.abspath(path)).split(os.sep)
    while len(parts) > 1 and not telling(parts[-1]):
        parts.pop()
    return os.sep.join(parts)


def _agree(one: frozenset[str], other: frozenset[str]) -> bool:
    """Whether names may be of one robot: they share a word, and no sign tells models of one family apart.

    Signs are a letter or digit of its own (`anymal_b`, `anymal_c`) and a number in a word (`gr1t1`, `gr2t2`, `kr16`,
    `kr120`), unless one begins as the other does (`gr2t2`, `gr2t2d`) or it is a version's (`v2`).
    """
    return bool(_shared(one, other)) and not _has_signs(one, other)


def _has_signs(one: frozenset[str], other: frozenset[str]) -> bool:
    """Whether signs tell models of one family apart."""
    apart = one - other, other - one
    signs = [{word.rpartition("_")[0] for word in mine if "_" in word} for mine in apart]
    numbered = any(_is_another_number(mine, its) for mine in apart[0] for its in apart[1])
    return bool(signs[0] & signs[1]) or numbered


def _are_two(one: Sequence[frozenset[str]], other: Sequence[frozenset[str]]) -> bool:
    """Whether names of two artifacts, or else of their folders, are of one family's robots, or like `a1` and `go2`."""
    mine, its = (
        next(filter(None, (frozenset(filter(_LIKE_A_ROBOT.match, words)) for words in each)), frozenset())
        for each in (one, other)
    )
    alike = any(a.startswith(b) or b.startswith(a) for a in mine for b in its)
    return _has_signs(one[0], other[0]) or (bool(mine and its) and not alike)


def _is_another_number(one: str, other: str) -> bool:
    """Whether two words are one family's with different numbers."""
    stems = [_NUMBERED.match(word) for word in (one, other)]
    same = stems[0] is not None and stems[1] is not None and stems[0][1] == stems[1][1]
    return same and not one.startswith(other) and not other.startswith(one)


def _told_apart(one: str, other: str, shared: frozenset[str]) -> bool:
    """Whether folders tell apart what the files call alike: `anymal_b_description`, `anymal_c_description`."""
    signs = [
        {
            word
            for name in os.path.dirname(os.path.abspath(path)).split(os.sep)[-_FOLDERS:]
            for word in telling(name)
            if word.rpartition("_")[0] in shared
        }
        for path in (one, other)
    ]
    return bool(signs[0] and signs[1]) and not signs[0] & signs[1]


def _may_be_one(
    artifacts: Sequence[Artifact], figures: Callable[[int], Figures], one: int, other: int, kinds: int
) -> bool:
    """Whether figures do not speak against one robot.

    An MJCF and a URDF of one name (three kinds are asked for) are compared, whatever they say; of another name, where
    the joints turn as far or the links weigh as much.
    """
    mine, its = figures(one), figures(other)
    if artifacts[one].kind is artifacts[other].kind:
        return are_alike(mine, its, kinds)
    body = [{kind: of[kind] for kind in BODY & of.keys()} for of in (mine, its)]
    return kinds > 2 or are_alike(body[0], body[1], kinds)


def _is_called_alike(one: Artifact, other: Artifact) -> bool:
    """Whether two models have one name inside, whatever their files are called: a kind's (`arm`) in one folder only."""
    names = telling(one.name)
    if one.robot is None or other.robot is None or not names or names != telling(other.name):
        return False
    return not names <= _KINDS or _home(one.path) == _home(other.path)


def _overlap(one: frozenset[str], other: frozenset[str]) -> bool:
    least = min(len(one), len(other))
    return least > 0 and len(one & other) >= SHARE * least


def _is_but_one(one: frozenset[str], other: frozenset[str]) -> bool:
    """Whether all joints but one of the smaller artifact are the other's: a name that is wrong in one of the two parts
    no files of a robot with few joints. Of two joints one says nothing.
    """
    least = min(len(one), len(other))
    return least > 2 and len(one & other) >= least - 1


def _are_renamed(one: frozenset[str], other: frozenset[str]) -> bool:
    """Whether one word for another makes the joints of one artifact those of the other, of which half are called alike:
    `l_knee` and `r_knee` are `l_calf` and `r_calf`, as macros and search-and-replace have it.
    """
    mine, its = one - other, other - one
    if not mine or len(mine) != len(its) or len(one & other) < len(mine):
        return False
    first = _PART.findall(min(mine))
    for name in its:
        apart = [pair for pair in zip(first, _PART.findall(name), strict=False) if pair[0] != pair[1]]
        if len(apart) == 1:
            word, instead = apart[0]
            if {
                "".join(instead if part == word else part for part in _PART.findall(each)) for each in mine
            } == its:
                return True
    return False


_PART = re.compile(r"[^\W\d_]+|[\W\d_]+")
"""Words of a joint's name, and what is between them."""


def fits(config: RobotConfig | None, joints: Sequence[str], share: float = 1.0) -> bool:
    """Whether that share of a configuration's joint patterns, or more, match a joint; of a list without names, all."""
    if config is None or not config.groups:
        return False
    count = config.settings.get("joint_count")
    if count is not None and count.value != len(set(joints)):
        return False
    patterns = [pattern for group in config.groups for pattern in group.joints or ()]
    met = sum(bool(matching(config.framework, pattern, joints)) for pattern in patterns)
    return bool(patterns) and met >= share * len(patterns)


def has_joints(artifact: Artifact, joints: Collection[str]) -> bool:
    """Whether an artifact names just these joints, or all of its patterns, which say something, match one of them."""
    own = joint_names(artifact)
    if own is not None:
        return bool(own) and set(own) == set(joints)
    return bool(joints) and says_something(artifact.config) and fits(artifact.config, sorted(joints))


def says_something(config: RobotConfig | None) -> bool:
    """Whether a pattern has a word in it: `.*` fits every robot."""
    patterns = [pattern for group in config.groups for pattern in group.joints or ()] if config else []
    return any(re.search("[A-Za-z]{2}", pattern) for pattern in patterns)


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


def _name(artifacts: Sequence[Artifact], words: Sequence[frozenset[str]], group: Sequence[int]) -> str:
    shared = [word for i in group for word in sorted(words[i])]
    if shared:
        return max(shared, key=lambda word: (shared.count(word), -shared.index(word)))
    return artifacts[group[0]].name
