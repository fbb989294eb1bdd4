"""Which artifacts describe the same robot.

Joint names alone do not tell: every quadruped of one vendor has the same, and so have most humanoids. What must be
shared beside them is the robot's name, or its folder, or a reference to the file; and figures may speak against it,
because every pendulum is called so: a Go1 and a Go2 are never compared by accident.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Sequence
from functools import cache

from actspec.files import in_common
from actspec.readings.artifact import Artifact, FileKind, Robot, RobotConfig
from actspec.readings.body import BODY, Figures, are_alike, figures_of, share_a_body
from actspec.readings.called import (
    KINDS,
    agreement,
    are_two,
    home_of,
    names_agree,
    names_of,
    say_nothing,
    shared_words,
    stem_of,
    telling,
    told_apart,
)
from actspec.readings.joint_names import (
    differ_by_one,
    fits,
    has_joints,
    joint_names,
    renaming,
    says_something,
    selected,
    share_joints,
)
from actspec.readings.pair_lone import with_deploy_files, with_environments, with_mappings, with_runs

VARIANT = 0.5
"""Patterns that must match where the names say that it is the same robot. Chosen: a cfg for a robot with hands
belongs to the model without them."""


def pair(
    artifacts: Sequence[Artifact],
    spec: str | None = None,
    by_hand: Collection[int] = (),
    records: Collection[int] = (),
) -> tuple[Robot, ...]:
    """Put the artifacts of one robot together.

    Artifacts that name their joints (models, specs, deploy files) come together when they share joints and the
    robot's name, models of one kind also figures; of several such robots a file is of the one with its joints, then
    of the nearest folder's. A file that is called nothing belongs to those of its folder, or to the only one with its
    joints. A configuration joins the robot whose file it names, or that of its name where at least half of its
    patterns match a joint, else the one whose joints all of its patterns match and that nothing tells from it, such
    as another name that it shares with its own file; where several do, none: nothing is guessed; without a robot, the
    deploy file that has its keys; an environment follows the constant that it imports. A file without a name beside
    several robots is of the one whose joints are most nearly its own; a deploy file beside what a run recorded is
    called as that is. What a run recorded joins the one configuration that was named with its patterns and its model,
    and a deploy file that somebody named what was named with it and has the same joints, where nothing else has them.
    Ranges of randomisation without actuators join the robot that their file's name tells, or the only one. Models that
    somebody named are one robot where they have one body, and one name inside or the same joints: else a wrong figure
    in `arm2.xml` is never compared with `arm1.xml`, nor one in `my_arm.xml`.

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
    calls = _called_as_others([names_of(artifact) for artifact in artifacts], artifacts, records)
    words = [own or folder for own, folder in calls]
    figures = cache(lambda index: figures_of(artifacts[index].robot))

    def agree(one: int, other: int) -> bool:
        # A file without a name of its own goes by its folder, which says nothing against the file beside it.
        unnamed = not calls[one][0] or not calls[other][0]
        named = names_agree(words[one], words[other]) or (unnamed and bool(calls[one][1] & calls[other][1]))
        if one in by_hand and other in by_hand and not named:
            alike = _is_called_alike(artifacts[one], artifacts[other])
            named = (alike or sets[one] == sets[other]) and share_a_body(
                figures(one), figures(other), names=alike
            )
        if say_nothing(words[one], words[other]):
            # Called nothing, or after its kind only: a humanoid of another folder is another one.
            named = named or home_of(artifacts[one].path) == home_of(artifacts[other].path)
        return named and not told_apart(artifacts[one].path, artifacts[other].path, words[one] & words[other])

    def overlap(one: int, other: int) -> bool:
        mine, its = sets[one], sets[other]
        called = (words[one] <= words[other] or words[other] <= words[one]) and bool(
            words[one] & words[other]
        )
        named = called and {one, other} <= set(by_hand)
        return share_joints(mine, its) or (named and (differ_by_one(mine, its) or bool(renaming(mine, its))))

    held = next((names[i] for i, a in enumerate(artifacts) if a.spec is not None and a.path == spec), None)
    bound = {
        i
        for i, own in enumerate(names)
        if held and own is not None and share_joints(sets[i], frozenset(held))
    }
    groups: list[list[int]] = []
    # What is called nothing fits too many, and is put to those that are called something; a list has no figures.
    for index in sorted(range(len(names)), key=lambda i: (not calls[i][0], artifacts[i].robot is None)):
        if names[index] is None:
            continue
        fitting_groups = (
            group
            for group in groups
            if all((overlap(index, i) and agree(index, i)) or {index, i} <= bound for i in group)
            and any(
                {index, i} <= bound
                or _may_be_one(artifacts, figures, index, i, 3 if words[index] == words[i] else 2)
                for i in _of_its_kind(artifacts, index, group)
            )
        )
        home = _nearest(artifacts, sets, calls, index, list(fitting_groups))
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
            if any(shared_words(words[index], words[i]) for i in named[g])
            and fits(artifacts[index].config, joints, VARIANT)
        ]
        others = [
            artifacts[i].config
            for i in configs
            if artifacts[i].path == artifacts[index].path and not names_agree(words[i], words[index])
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
                artifacts[i].kind is FileKind.DEPLOY and are_two(calls[index], calls[i]) for i in named[g]
            )
        ]
        choice = next((found for found in (alike, silent, alone) if len(found) == 1), None)
        if choice is None or (not alike and len(fitting) > 1):
            groups.append([index])
        else:
            groups[choice[0]].append(index)
    groups = with_environments(groups, artifacts, {i for i, own in enumerate(names) if own is not None})
    groups = with_mappings(groups, artifacts, share_joints, agree)
    groups = with_runs(groups, artifacts, records, by_hand, agree)
    groups = with_deploy_files(
        groups,
        artifacts,
        by_hand,
        lambda one, other: has_joints(artifacts[one], sets[other]),
        lambda one, other: are_two(calls[one], calls[other]),
    )
    for index in unnamed:
        if _is_events(artifacts[index]):
            called = words[index] | telling(stem_of(artifacts[index].path))
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


def _called_as_others(
    calls: Sequence[tuple[frozenset[str], frozenset[str]]],
    artifacts: Sequence[Artifact],
    records: Collection[int],
) -> list[tuple[frozenset[str], frozenset[str]]]:
    """What artifacts are called, a scene as the model that all of its joints are in, and a deploy file as what the run
    that exported it recorded beside it.
    """
    found = list(calls)
    models = {artifact.path: index for index, artifact in enumerate(artifacts) if artifact.robot is not None}
    for index, artifact in enumerate(artifacts):
        joints = artifact.robot.joints if artifact.robot is not None else ()
        inside = {joint.span.path for joint in joints}
        others = {calls[i] for i in runs_of(artifacts, index, records)}
        if len(inside) == 1:
            others = {calls[models[path]] for path in inside & models.keys()}
        own = others.pop() if len(others) == 1 else calls[index]
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


def _of_its_kind(artifacts: Sequence[Artifact], index: int, group: Sequence[int]) -> Sequence[int]:
    """The models of a group that are of a model's kind, which speak for the others; all where there are none.

    What every MJCF and URDF of one name is compared by brings no second MJCF of another robot to the first.
    """
    artifact = artifacts[index]
    own = [i for i in group if artifacts[i].kind is artifact.kind] if artifact.robot is not None else []
    return own or group


def _nearest(
    artifacts: Sequence[Artifact],
    sets: Sequence[frozenset[str]],
    calls: Sequence[tuple[frozenset[str], frozenset[str]]],
    index: int,
    groups: Sequence[list[int]],
) -> list[int] | None:
    """The group with most of a file's joints and fewest others, of several the nearest folder's, the first.

    None for a file without a name where another one is of another robot.
    """
    nearness = [
        max(len(sets[index] & sets[i]) / len(sets[index] | sets[i]) for i in group) for group in groups
    ]
    tied = [group for group, near in zip(groups, nearness, strict=True) if near == max(nearness)]
    members = [i for group in tied for i in group]
    unnamed = not calls[index][0]
    apart = unnamed and any(are_two(calls[one], calls[other]) for one in members for other in members)
    if apart or not tied:
        return None
    folders = [os.path.dirname(os.path.abspath(artifact.path)).split(os.sep) for artifact in artifacts]
    return max(tied, key=lambda group: max(in_common(folders[index], folders[i]) for i in group))


def _is_outdone(
    config: RobotConfig | None, others: Iterable[RobotConfig | None], joints: Sequence[str]
) -> bool:
    """Whether one of other configurations, all of whose patterns match a joint too, has more of the joints."""
    own = len(selected(config, joints))
    return any(fits(other, joints) and len(selected(other, joints)) > own for other in others)


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
    if not telling(told) - KINDS:
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
    if not (telling(artifact.name) & telling(stem_of(model))) - KINDS or not files - KINDS:
        return False
    theirs = files | folders
    return not any(a in b or b in a for a in telling(artifact.name) | telling(model) for b in theirs)


def _is_events(artifact: Artifact) -> bool:
    """Whether a configuration has ranges and no actuators: what it randomises is in other files of its robot."""
    config = artifact.config
    return config is not None and not config.groups and bool(config.randomize)


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
    return not names <= KINDS or home_of(one.path) == home_of(other.path)


def _name(artifacts: Sequence[Artifact], words: Sequence[frozenset[str]], group: Sequence[int]) -> str:
    shared = [word for i in group for word in sorted(words[i])]
    if shared:
        return max(shared, key=lambda word: (shared.count(word), -shared.index(word)))
    return artifacts[group[0]].name
