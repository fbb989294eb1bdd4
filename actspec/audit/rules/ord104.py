from __future__ import annotations

import os
from collections.abc import Collection, Iterator, Mapping, Sequence
from os.path import basename
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.configs import FRAMEWORKS, is_as_written, posed
from actspec.audit.rules.misnamed import (
    beside_patterns,
    drivers_beside,
    is_misspelt,
    is_swapped,
    misnamed,
)
from actspec.diagnostics import Span, listed, nearest, shortened
from actspec.joints import LETTERS, respelt
from actspec.patterns import match_names, recased
from actspec.readings.artifact import ActuatorGroup, Artifact, FileKind, Framework, RobotConfig, Setting
from actspec.readings.config import IN_FIGURES, models_of
from actspec.readings.dict_keys import PLAIN, POSE, dead_keys, may_match, meant_for, meets, selects_nothing
from actspec.readings.joint_names import joint_names, matching

_SURE = (Severity.ERROR, Confidence.HIGH)

_NEAR = (Severity.WARNING, Confidence.MEDIUM)

_UNSURE = (Severity.INFO, Confidence.LOW)


_Subject = tuple[int, RobotConfig, Artifact | None]


class PatternMatchesNothing(RuleOver[_Subject]):
    code = "ORD104"
    name = "pattern-matches-nothing"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True
    needs = (
        "no configuration with values by joint, or with a model or deploy file of its robot, among the files"
    )
    options: ClassVar[dict[str, float]] = {"share": 0.5}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for index, artifact in case.of_kind(FileKind.CFG, FileKind.DEPLOY):
            config = artifact.config
            if config is None:
                continue
            model = _model(case, index)
            if config.framework not in FRAMEWORKS:
                if model is not None or drivers_beside(case, index):
                    yield index, config, model
            elif model is not None or any(_keys(s) for g in config.groups for s in g.settings.values()):
                yield index, config, model

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Match every pattern that has joints to be held against, and every key that has patterns."""
        index, config, model = subject
        yield from self._names(case, index)
        members = (case.artifacts[other] for other in case.robot_of(index).artifacts)
        # A pattern that one variant of the robot has a joint for is right.
        names = tuple(dict.fromkeys(name for member in members for name in joint_names(member) or ()))
        if model is not None and config.framework in _STARTS and is_as_written(config):
            yield from self._pose(case, config, model, names)
        if config.framework not in FRAMEWORKS:
            return
        meant = {group.span: _meant(config, group, names) for group in config.groups} if model else {}
        for group in config.groups:
            told = meant.get(group.span, {}).values()
            yield from self._keys(case, index, config.framework, group, model, told)
        if model is not None:
            yield from self._patterns(case, config, model, names, meant)

    def _names(self, case: Case, index: int) -> Iterator[Finding]:
        """Names of a list that no file of the robot has; where it is a model that departs, CFG102 tells of it."""
        for found in case.once(misnamed):
            if found.list != index or found.patterns is not None:
                continue
            file = basename(case.artifacts[found.model].path)
            yield Finding(
                self.code,
                f"no file of the robot has a joint '{shortened(found.name)}': {file} "
                f"has '{shortened(found.joint.name)}', which this list leaves out",
                found.place,
                found.name,
                help=f"did you mean '{shortened(found.joint.name)}'?",
                related=(found.joint.span,),
                severity=Severity.WARNING,
                confidence=Confidence.MEDIUM,
                noted_in_folders=True,
                about=f"{found.name} {found.joint.name}",
            )
        for name, place, meant, config in beside_patterns(case, index):
            yield Finding(
                self.code,
                f"no file of the robot has a joint '{shortened(name)}': {basename(config.path)} has a group for "
                f"'{shortened(meant)}', which this file leaves out",
                place,
                name,
                help=f"did you mean '{shortened(meant)}'?",
                severity=Severity.WARNING,
                confidence=Confidence.MEDIUM,
                noted_in_folders=True,
                about=f"{name} {meant}",
            )

    def _keys(
        self,
        case: Case,
        index: int,
        framework: Framework,
        group: ActuatorGroup,
        model: Artifact | None,
        told: Collection[str],
    ) -> Iterator[Finding]:
        """Keys that match no joint of their group, but for those that are told with one of its patterns."""
        joints = [row.joint for row in case.rows_of(index) if row.span == group.span]
        everywhere = (joint_names(model) if model is not None else None) or ()
        met = case.is_met(index)
        for name, setting in group.settings.items() if joints else ():
            keys = _keys(setting)
            missing = dead_keys(framework, keys, joints)
            # What a class of somebody's own has beside makes what it likes of its keys.
            if not missing or name not in IN_FIGURES:
                continue
            fitting = len(keys) - len(missing) >= self.option(case, "share") * len(keys)
            free = [joint for joint in joints if not any(may_match(framework, key, joint) for key in keys)]
            where = f" in {basename(model.path)}" if model is not None else f" ({listed(joints, 4)})"
            cased = {key: right for key in missing if key not in told and (right := recased(key, joints))}
            if cased:
                yield self._cased(
                    cased, f" of {name}", "key", f"group {group.name}{where}", [setting.span], "the cfg"
                )
            for key in missing:
                if key in told or key in cased:
                    continue
                outside = any(matching(framework, key, (joint,)) for joint in everywhere)
                # Whatever joints the robot has: the patterns that select the group's have none in common with it.
                alone = key in dead_keys(framework, [key], group.joints or ())
                # A group of `.*` fits any model: if few of its keys do, the model is another robot's.
                if not (fitting or outside or alone):
                    continue
                near = meant_for(key, joints, () if met else free)
                guess = near and (model is not None or not met)
                severity, confidence = (
                    _SURE if outside or (alone and not met) else _NEAR if guess else _UNSURE
                )
                yield Finding(
                    self.code,
                    f"the key '{shortened(key)}' of {name} matches no joint of group {group.name}{where}: the cfg "
                    "raises a ValueError",
                    setting.span,
                    help=_help(near, model is None and near in free),
                    severity=severity,
                    confidence=confidence,
                    about=f"{key} {name} {group.name}",
                )

    def _pose(
        self, case: Case, config: RobotConfig, model: Artifact, names: Sequence[str]
    ) -> Iterator[Finding]:
        """Keys of a default position that are for no joint, beside joints that no key is for and that they mean.

        Any other key may be of a part that the model lacks. Where most are for no joint it may be another robot's pose,
        unless all of them mean joints: `{"thigh": 0.3, "calf": -1.0}`.
        """
        setting = config.settings.get(POSE)
        keys = _keys(setting) if setting is not None and setting.unknown is None else []
        missing = [key for key in keys if not any(meets(config.framework, POSE, key, name) for name in names)]
        if setting is None:
            return
        free = [name for name in names if not any(meets(config.framework, POSE, key, name) for key in keys)]
        every = {key: found for key in missing if (found := _key_meant(config.framework, key, names, free))}
        fitting = len(keys) - len(missing) >= self.option(case, "share") * len(keys)
        # In forks of legged_gym keys are parts of names, too.
        if not fitting and (len(every) < len(missing) or config.framework is Framework.LEGGED_GYM):
            return
        noun, then = _STARTS[config.framework]
        for key, (meant, joints) in every.items():
            for joint in joints:
                yield Finding(
                    self.code,
                    f"the key '{shortened(key)}' of {noun} matches no joint of {basename(model.path)}, and none is "
                    f"for this one: {then}",
                    setting.place(key),
                    joint,
                    help=f"did you mean '{shortened(meant)}'?",
                    severity=Severity.WARNING,
                    confidence=Confidence.MEDIUM,
                    noted_in_folders=True,
                    fields=(POSE,),
                    about=f"{key} {noun}",
                )

    def _cased(
        self, cased: Mapping[str, str], of: str, noun: str, where: str, spans: Sequence[Span], who: str
    ) -> Finding:
        """Of keys or patterns that are joints' but for capital and small letters, once.

        Args:
            cased: Each with the one that matches.
            of: What keys are of.
            noun: What they are.
            where: What they match no joint of.
            spans: Where they stand.
            who: What raises the error.
        """
        written = listed((f"'{shortened(one)}'" for one in cased), 4)
        many = "s" * (len(cased) > 1)
        return Finding(
            self.code,
            f"the {noun}{many} {written}{of} {'match' if many else 'matches'} no joint of {where}, whose names have "
            f"other capital letters: {who} raises a ValueError",
            spans[0],
            help=f"write {listed(f'{right!r}' for right in dict.fromkeys(cased.values()))}",
            related=tuple(spans[1:]),
            severity=Severity.WARNING,
            confidence=Confidence.MEDIUM,
            noted_in_folders=True,
            about=" ".join((*cased, of.removeprefix(" of "))),
        )

    def _patterns(
        self,
        case: Case,
        config: RobotConfig,
        model: Artifact,
        names: Sequence[str],
        meant: Mapping[Span, Mapping[str, str]],
    ) -> Iterator[Finding]:
        """Patterns of groups that match no joint of any variant of the robot."""
        every = [(group, pattern) for group in config.groups for pattern in group.joints or ()]
        missing = [item for item in every if selects_nothing(config.framework, item[1], names)]
        # Else it is the model of another robot.
        fitting = len(every) - len(missing) >= self.option(case, "share") * len(every)
        lost = _lost(config, joint_names(model) or ()) if fitting and missing else ()
        # Of files in a stranger's folder the model may be another variant's.
        lost = () if case.is_met_at(config.span) else lost
        cased = {(group.span, one): right for group, one in missing if (right := recased(one, names))}
        if cased and is_as_written(config):
            yield self._cased(
                {pattern: right for (_, pattern), right in cased.items()},
                "",
                "pattern",
                basename(model.path),
                list(dict.fromkeys(span for span, _ in cased)),
                f"with these joint names {FRAMEWORKS[config.framework]}",
            )
        for group, pattern in missing:
            if (group.span, pattern) in cased:
                continue
            key = meant[group.span].get(pattern)
            if not (fitting or key):
                continue
            near = key or _joint_meant(pattern, names)
            # Several names that are nearly those of a model that nobody named with the file are another robot's.
            other = near and len(missing) > 1 and case.is_met_at(group.span)
            instead = () if near else _in_its_place(config, pattern, names, lost)
            likely = is_as_written(config) and (
                (near and not other) or instead or _is_loaded(case, config, model)
            )
            severity, confidence = _SURE if key else _NEAR if likely else _UNSURE
            yield Finding(
                self.code,
                f"the pattern '{shortened(pattern)}' matches no joint of {basename(model.path)}: with these joint "
                f"names {FRAMEWORKS[config.framework]} raises a ValueError",
                group.span,
                help=f"did you mean '{near}'?{' Keys of the group are called so' if key else ''}"
                if near
                else f"no group selects {listed(instead, 4)}, whose position this configuration sets"
                if instead
                else "is it a model of another variant of the robot?",
                severity=severity,
                confidence=confidence,
                about=f"{pattern} {group.name}",
            )


_STARTS = {
    Framework.ISAACLAB: ("joint_pos", "the cfg raises a ValueError"),
    Framework.MJLAB: ("joint_pos", "mjlab starts it at 0"),
    Framework.LEGGED_GYM: ("default_joint_angles", "legged_gym raises a KeyError"),
}
"""What a framework calls default positions, and what it does with a joint that no key is for, or with such a key."""


def _keys_meant(framework: Framework, key: str, names: Sequence[str]) -> Iterator[str]:
    """What a key may have been: with one word of the joints in the place of one that is nearly it, with other capital
    letters, or, where keys are patterns, with a dot that was left out, or with what may stand before and after it.
    """
    words = dict.fromkeys(word for name in names for word in LETTERS.findall(name))

    def near(own: str) -> Iterator[str]:
        known = words if own not in words else ()
        return (word for word in known if is_swapped(own, word) or is_misspelt(own, word))

    yield from respelt(key, near)
    if (cased := recased(key, names)) is not None:
        yield cased
    if framework is not Framework.LEGGED_GYM:
        for at in range(1, len(key)):
            if key[at - 1].isalnum():
                yield f"{key[:at]}.{key[at:]}"
        yield f".*{key}"


def _key_meant(
    framework: Framework, key: str, names: Sequence[str], free: Collection[str]
) -> tuple[str, tuple[str, ...]] | None:
    """What a key of a pose may have been, with its joints; None: nothing, several things, or joints of other keys."""
    found: dict[tuple[str, ...], str] = {}
    for meant in _keys_meant(framework, key, names):
        joints = tuple(name for name in names if meets(framework, POSE, meant, name))
        if joints and set(joints) <= set(free):
            found.setdefault(joints, meant)
    ((joints, meant),) = found.items() if len(found) == 1 else (((), ""),)
    return (meant, joints) if joints else None


def _joint_meant(pattern: str, names: Sequence[str]) -> str | None:
    """`meant_for`, and by the joint's own name what is no pattern."""
    near = meant_for(pattern, names)
    found = match_names(near, names) if near is not None and PLAIN.fullmatch(pattern) else ()
    return found[0] if len(found) == 1 else near


def _in_its_place(
    config: RobotConfig, pattern: str, names: Sequence[str], lost: Collection[str]
) -> tuple[str, ...]:
    """The lost joints that a pattern selects with one of their words in the place of its own.

    The configuration's robot has those joints, and so no others in their place; a part that moves one from afar, as a
    pulley or rod, is no other name of it.
    """
    words = dict.fromkeys(word for name in lost for word in LETTERS.findall(name))
    found = (matching(config.framework, meant, names) for meant in respelt(pattern, lambda _: words))
    return next((joints for joints in found if joints and set(joints) <= set(lost)), ())


def _model(case: Case, index: int) -> Artifact | None:
    """The model of the configuration's robot."""
    artifact = case.artifacts[index]
    members = [case.artifacts[other] for other in case.robot_of(index).artifacts]
    assert artifact.config is not None
    return next(iter(models_of(artifact.config, members)), None)


def _is_loaded(case: Case, config: RobotConfig, model: Artifact) -> bool:
    """Whether a configuration names this very file with its folder, or lies beside it, and both were named."""
    if config.model is None or case.is_met_at(config.span) or case.is_met_at(Span(model.path)):
        return False
    written, there = (
        path.replace("\\", "/").split("/") for path in (config.model, os.path.abspath(model.path))
    )
    beside = os.path.dirname(os.path.abspath(config.span.path)) == os.path.dirname(
        os.path.abspath(model.path)
    )
    parts = 1 if beside else 2
    return len(written) >= parts and written[-parts:] == there[-parts:]


def _lost(config: RobotConfig, names: Sequence[str]) -> tuple[str, ...]:
    """Joints whose position a configuration sets and that no group of it selects; none where a group is not known."""
    if any(group.joints is None for group in config.groups):
        return ()
    patterns = [pattern for group in config.groups for pattern in group.joints or ()]
    return tuple(
        name
        for name in posed(config, names)
        if not any(matching(config.framework, pattern, (name,)) for pattern in patterns)
    )


def _help(near: str | None, either: bool) -> str:
    """What to do with a key that matches nothing, with the pattern that it is like; `either` may be misspelt."""
    if near is None:
        return "leave it out, or add its joints to the group"
    return f"'{near}' has no key: one of the two is misspelt" if either else f"did you mean '{near}'?"


def _keys(setting: Setting) -> list[str]:
    """Keys of a dict that have a number."""
    values = setting.value if isinstance(setting.value, Mapping) else {}
    return [key for key, value in values.items() if isinstance(value, int | float)]


def _meant(config: RobotConfig, group: ActuatorGroup, names: Sequence[str]) -> dict[str, str]:
    """Patterns of a group that match no joint, each to the key of its dicts that is like it and matches joints that no
    group has: it is the pattern that is misspelt.
    """
    patterns = [pattern for each in config.groups for pattern in each.joints or ()]
    taken = {name for pattern in patterns for name in matching(config.framework, pattern, names)}
    free = [name for name in names if name not in taken]
    keys = [key for setting in group.settings.values() for key in _keys(setting)]
    able = [key for key in dict.fromkeys(keys) if matching(config.framework, key, free)]
    lost = [pattern for pattern in group.joints or () if selects_nothing(config.framework, pattern, names)]
    return {pattern: key for pattern in lost if (key := nearest(pattern, able))}
