from __future__ import annotations

from collections.abc import Iterator, Mapping
from difflib import SequenceMatcher
from os.path import basename
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.configs import FRAMEWORKS
from actspec.diagnostics import shortened
from actspec.patterns import PatternError, compile_pattern, suggest_pattern
from actspec.readings.artifact import ActuatorGroup, Artifact, FileKind, Framework, RobotConfig
from actspec.readings.pair import joint_names, matching

_SURE = (Severity.ERROR, Confidence.HIGH)

_NEAR = (Severity.WARNING, Confidence.MEDIUM)

_UNSURE = (Severity.INFO, Confidence.LOW)

_ALIKE = 0.9
"""How alike a pattern and the nearest one that matches are, where it is misspelt and not that of another joint.
Chosen: `wrist_pitch_joint` and `wrist_roll_joint` are 0.77, one letter more or less is above 0.9."""


_Subject = tuple[int, RobotConfig, Artifact]


class PatternMatchesNothing(RuleOver[_Subject]):
    code = "ORD104"
    name = "pattern-matches-nothing"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True
    needs = "no configuration with a model of its robot among the files"
    options: ClassVar[dict[str, float]] = {"share": 0.5}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for index, artifact in case.of_kind(FileKind.CFG):
            config = artifact.config
            if config is None or config.framework not in FRAMEWORKS:
                continue
            model = _model(case, index)
            if model is not None:
                yield index, config, model

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Match every pattern that has joints to be held against."""
        index, config, model = subject
        for group in config.groups:
            yield from self._keys(case, index, config.framework, group, model)
        yield from self._patterns(case, index, config.framework, model)

    def _keys(
        self, case: Case, index: int, framework: Framework, group: ActuatorGroup, model: Artifact
    ) -> Iterator[Finding]:
        joints = [row.joint for row in case.rows_of(index) if row.span == group.span]
        everywhere = joint_names(model) or ()
        for name, setting in group.settings.items():
            if not joints or not isinstance(setting.value, Mapping):
                continue
            keys = [key for key, value in setting.value.items() if isinstance(value, int | float)]
            missing = [key for key in keys if _selects_nothing(framework, key, joints)]
            fitting = len(keys) - len(missing) >= self.option(case, "share") * len(keys)
            for key in missing:
                outside = not _selects_nothing(framework, key, everywhere)
                # A group of `.*` fits any model: if few of its keys do, the model is another robot's.
                if not (fitting or outside):
                    continue
                near = _misspelt(key, joints)
                severity, confidence = _SURE if outside else _NEAR if near else _UNSURE
                yield Finding(
                    self.code,
                    f"the key '{shortened(key)}' of {name} matches no joint of group {group.name} in "
                    f"{basename(model.path)}: the cfg raises a ValueError",
                    setting.span,
                    help=f"did you mean '{near}'?"
                    if near
                    else "leave it out, or add its joints to the group",
                    severity=severity,
                    confidence=confidence,
                )

    def _patterns(self, case: Case, index: int, framework: Framework, model: Artifact) -> Iterator[Finding]:
        config = case.artifacts[index].config
        members = (case.artifacts[other] for other in case.robot_of(index).artifacts)
        # A pattern that one variant of the robot has a joint for is right.
        names = tuple(dict.fromkeys(name for member in members for name in joint_names(member) or ()))
        groups = config.groups if config is not None else ()
        every = [(group, pattern) for group in groups for pattern in group.joints or ()]
        missing = [item for item in every if _selects_nothing(framework, item[1], names)]
        if not every or len(every) - len(missing) < self.option(case, "share") * len(every):
            return
        for group, pattern in missing:
            near = _misspelt(pattern, names)
            severity, confidence = _NEAR if near else _UNSURE
            yield Finding(
                self.code,
                f"the pattern '{shortened(pattern)}' matches no joint of {basename(model.path)}: with these joint "
                f"names {FRAMEWORKS[framework]} raises a ValueError",
                group.span,
                help=f"did you mean '{near}'?" if near else "is it a model of another variant of the robot?",
                severity=severity,
                confidence=confidence,
            )


def _model(case: Case, index: int) -> Artifact | None:
    """The model of the configuration's robot."""
    members = (case.artifacts[other] for other in case.robot_of(index).artifacts)
    return next((member for member in members if member.robot is not None), None)


def _misspelt(pattern: str, names: list[str] | tuple[str, ...]) -> str | None:
    """The pattern that was meant; None where none is near enough to say so."""
    near = suggest_pattern(pattern, names)
    return near if near and SequenceMatcher(None, pattern, near).ratio() >= _ALIKE else None


def _selects_nothing(framework: Framework, pattern: str, names: list[str] | tuple[str, ...]) -> bool:
    """Whether a pattern that can be judged selects no joint."""
    try:
        compile_pattern(pattern)
    except PatternError:
        return False
    return not matching(framework, pattern, names)
