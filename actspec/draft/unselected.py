"""What of a configuration selects no joint of its robot, and keys that are for a joint which another is for already."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from difflib import get_close_matches

from actspec.diagnostics import Diagnostic, Severity, Span, listed, many, one_line
from actspec.joints import LETTERS, respelt
from actspec.lift.config import asset_of
from actspec.readings.artifact import ActionTerm, ActuatorGroup, Framework, RobotConfig, Setting
from actspec.readings.config import lost_keys, selected
from actspec.readings.dict_keys import POSE, again, may_match, meant_for, meets, plain_name, refuses_two
from actspec.readings.joint_lists import patterns_of
from actspec.readings.joint_names import matching

_SCALE = "action_scale"

_ALIKE = 0.75
"""How alike a word and one of another name are, where it is misspelt. `knie` and `knee` are 0.75."""


def robot_file_of(config: RobotConfig) -> str:
    """The robot's file, for a help that says what to name beside a configuration: `leg.xml too, which it reads`."""
    asset = asset_of(config)
    return f"{one_line(asset)} too, which it reads" if asset else "the robot's MJCF or URDF too"


def unselected(
    config: RobotConfig, joints: Sequence[str], of: str | None, typed: bool
) -> Iterator[Diagnostic]:
    """Patterns and keys that select no joint, for which the framework refuses the configuration: each once.

    Where nothing names the robot's joints, one that no group drives is as likely a passive joint: a single note.

    Args:
        config: The configuration.
        joints: The robot's.
        of: What names them, in words; None: nothing does, and they are those of the groups and of a deploy file.
        typed: Whether the user did, who may have misspelt one.
    """
    framework = config.framework
    if framework not in (Framework.ISAACLAB, Framework.MJLAB):
        return
    taken = {name for pattern in patterns_of(config) for name in matching(framework, pattern, joints)}
    free = [name for name in joints if name not in taken]
    none = f"none of the {many(len(joints), 'joint')} of {of}"
    lost: list[tuple[Span, str, str, list[str]]] = []
    undriven: list[tuple[Setting, str, list[str]]] = []
    for group in config.groups:
        named = joints if of is not None else _one_by_one(framework, group)
        if named is None:
            continue
        patterns = [pattern for pattern in group.joints or () if not matching(framework, pattern, named)]
        lost.append((group.span, f"of {one_line(config.name)}", none, patterns))
        for name, setting in group.settings.items():
            keys = lost_keys(config, group, setting, named)
            # Where a pattern is misspelt, its keys are right.
            keys = [key for key in keys if not (patterns and matching(framework, key, free))]
            lost.append((setting.span, f"of {name}", f"no joint of group {one_line(group.name)}", keys))
    for name, setting in config.settings.items():
        keys = [
            key for key in setting.keys or () if not any(meets(framework, name, key, one) for one in joints)
        ]
        if of is not None:
            lost.append((setting.span, f"of {name}", none, keys))
            continue
        keys = [key for key in keys if not any(may_match(framework, one, key) for one in patterns_of(config))]
        if framework is Framework.MJLAB and name == _SCALE:
            # mjlab scales the commands of actuators alone, whatever joints the robot has.
            lost.append((setting.span, f"of {name}", "no joint of a group", keys))
        else:
            undriven.append((setting, name, keys))
    for term in config.actions if of is not None else ():
        mine = _of_term(framework, term, joints)
        lost.append(
            (
                term.span,
                f"of {_called(term)}",
                none,
                [one for one in term.joints or () if not matching(framework, one, joints)],
            )
        )
        if term.scale is not None and mine:
            keys = [
                key
                for key in term.scale.keys or ()
                if not any(meets(framework, _SCALE, key, one) for one in mine)
            ]
            lost.append((term.scale.span, f"of {_SCALE}", f"no joint of {_called(term)}", keys))
    told = set[str]()
    for span, owner, instead, keys in lost:
        new = [key for key in dict.fromkeys(keys) if key not in told]
        told.update(new)
        if new:
            near = {key: guess for key in new if (guess := meant_for(key, joints, free))}
            guess = f"did you mean {_meant(near, new)}?" if near else "is it misspelt, or are joints missing?"
            message = f"{_quoted(new)} {owner} select{'s' * (len(new) == 1)} {instead}"
            refused = f"{one_line(config.name)} is refused for it when the robot is made"
            if framework is Framework.MJLAB and owner == f"of {POSE}":
                refused = "mjlab passes over it"
            help = f"{guess} {refused}"
            if typed:
                slips = {name: None for each in near.values() for name in matching(framework, each, joints)}
                guess = f"{'are' if len(slips) > 1 else 'is'} {_quoted(slips)} misspelt in --joints"
                help = (
                    f"{guess if slips else 'is a joint misspelt in --joints, or missing'}? If not, {refused}"
                )
            yield Diagnostic("DRF012", Severity.WARNING, message, "", span, help)
    if config.groups and all(group.joints is not None for group in config.groups):
        yield from _undriven(config, joints, [item for item in undriven if item[2]])


def _of_term(framework: Framework, term: ActionTerm, joints: Sequence[str]) -> list[str]:
    """The joints of an action term; all where it is not known which."""
    patterns = (".*",) if term.joints is None else term.joints
    return [name for name in joints if any(matching(framework, one, (name,)) for one in patterns)]


def _called(term: ActionTerm) -> str:
    return f"actions.{one_line(term.name)}"


def _undriven(
    config: RobotConfig, joints: Sequence[str], found: Sequence[tuple[Setting, str, list[str]]]
) -> Iterator[Diagnostic]:
    """One note on keys that no group drives, of a robot whose joints nothing names."""
    if not found:
        return
    near: dict[str, str] = {}
    for setting, name, keys in found:
        # What has a key of its own was not meant by another.
        without = [
            one
            for one in joints
            if not any(meets(config.framework, name, key, one) for key in setting.keys or ())
        ]
        near |= {key: guess for key in keys if (guess := meant_for(key, without))}
    every = list(dict.fromkeys(key for _, _, keys in found for key in keys))
    message = f"no group of {one_line(config.name)} drives {_quoted(every)} of {found[0][1]}"
    guess = f"did you mean {_meant(near, every)}" if near else "passive, or misspelt"
    help = f"{guess}? Name {robot_file_of(config)}"
    yield Diagnostic("DRF012", Severity.INFO, message, "", found[0][0].place(found[0][2][0]), help)


def _one_by_one(framework: Framework, group: ActuatorGroup) -> list[str] | None:
    """The joints of a group that names each; None: a pattern may select others than any file has."""
    names = [plain_name(framework, pattern) for pattern in group.joints or ()]
    known = [name for name in names if name is not None]
    return known if len(known) == len(names) and group.joints is not None else None


def _quoted(names: Sequence[str] | Mapping[str, object]) -> str:
    return listed(f"`{one_line(name)}`" for name in names)


def _meant(near: Mapping[str, str], new: Sequence[str]) -> str:
    """What was meant, each with the key that it was meant by where there are several."""
    return listed(
        f"`{one_line(guess)}`" + f" for `{one_line(key)}`" * (len(new) > 1) for key, guess in near.items()
    )


_CALLED = {POSE: "the pose", _SCALE: "the action scale"}


def selected_twice(config: RobotConfig, joints: Sequence[str]) -> Iterator[Diagnostic]:
    """Keys of values by joint that are for a joint which another key is for: each once, and which of them counts."""
    config = config.unrolled
    framework, robot = config.framework, one_line(config.name)
    every = [(name, setting, joints) for name, setting in config.settings.items()]
    for group in config.groups:
        own = [joint for joint, _ in selected(config, group, joints)]
        every += [(name, setting, own) for name, setting in group.settings.items()]
    scaled = [(term, term.scale) for term in config.actions if term.scale is not None]
    every += [(_SCALE, scale, _of_term(framework, term, joints)) for term, scale in scaled]
    for name, setting, mine in every if framework is not Framework.DEPLOY else ():
        # mjlab's classes take one number, and no dict; legged_gym looks damping up by the keys of stiffness.
        if framework is Framework.MJLAB and name not in _CALLED:
            continue
        if framework is Framework.LEGGED_GYM and name == "damping":
            continue
        for key, taken in again(framework, name, setting, mine):
            owner = _CALLED.get(name, name)
            known = listed((joint for some in taken.values() for joint in some), 4)
            others = listed(f"`{one_line(other)}`" for other in taken)
            are = "are" if len(taken) > 1 else "is"
            message = f"`{one_line(key)}` of {owner} is for {known}, which {others} {are} for already"
            severity = Severity.WARNING
            if refuses_two(framework, name):
                help = f"let one key match each joint: {robot} is refused for it when the robot is made"
            elif framework is Framework.MJLAB:
                help = f"mjlab takes the first that matches: put `{one_line(key)}` before {others}"
            else:
                severity, help = Severity.INFO, "legged_gym takes the last that is part of the name"
            yield Diagnostic("DRF014", severity, message, "", setting.place(key), help)


def misspelt(config: RobotConfig, typed: Sequence[str]) -> Iterator[Diagnostic]:
    """Typed names that no group selects, and one would with a word as other names have it.

    What would be another joint of the list then is a joint of its own: `FL_hip` beside `FR_hip`.
    """
    patterns = [pattern for group in config.groups for pattern in group.joints or ()]
    taken = {name for pattern in patterns for name in matching(config.framework, pattern, typed)}
    words = sorted({word for name in taken for word in LETTERS.findall(name)})
    for name in typed:
        if name in taken:
            continue
        for guess in respelt(name, lambda own: get_close_matches(own, words, n=1, cutoff=_ALIKE)):
            if guess not in typed and any(matching(config.framework, each, (guess,)) for each in patterns):
                message = f"no group of {one_line(config.name)} selects `{one_line(name)}` of --joints"
                help = f"did you mean `{one_line(guess)}`? The joint is left alone as it is"
                yield Diagnostic("DRF012", Severity.WARNING, message, "", config.groups[0].span, help)
                break


def not_listed(config: RobotConfig, joints: Sequence[str]) -> Iterator[Diagnostic]:
    """Joints of a deploy file that the list of all joints has not."""
    lost = [group for group in config.groups if not matching(config.framework, group.name, joints)]
    if lost:
        names = listed((f"`{one_line(group.name)}`" for group in lost), 4)
        message = f"{names} of {one_line(config.name)} {'are' if len(lost) > 1 else 'is'} not among --joints"
        help = "its numbers are left out" if len(lost) == 1 else "their numbers are left out"
        yield Diagnostic("DRF012", Severity.WARNING, message, "", lost[0].span, help)
