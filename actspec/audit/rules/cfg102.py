from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from os.path import basename
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.configs import names_model, posed
from actspec.ir import JointKind
from actspec.patterns import is_slip
from actspec.readings.artifact import FileKind, Framework, RobotConfig
from actspec.readings.dict_keys import selects_nothing
from actspec.readings.pair import joint_names
from actspec.robot.view import RobotView

_Subject = tuple[RobotConfig, set[str], int, RobotView, bool]


class JointNotCovered(RuleOver[_Subject]):
    code = "CFG102"
    name = "joint-not-covered"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    needs = "no whole configuration of Isaac Lab or mjlab beside an MJCF of its robot"
    options: ClassVar[dict[str, float]] = {"share": 0.6}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for index, artifact in case.of_kind(FileKind.CFG):
            config = artifact.config
            if config is None or config.framework not in (Framework.MJLAB, Framework.ISAACLAB):
                continue
            if not _whole(config):
                continue
            covered = {row.joint for row in case.rows_of(index)}
            for other in case.robot_of(index).artifacts:
                model = case.artifacts[other]
                if model.kind is not FileKind.MJCF or model.robot is None:
                    continue
                own = config.framework is Framework.MJLAB
                if own and not names_model(case, config, model):
                    continue
                yield config, covered, other, model.robot, own

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Find joints that are in no group."""
        config, covered, other, robot, own = subject
        driven = {row.joint for row in case.rows_of(other) if row.joint and row.control != "none"}
        loose = _loose(robot) - driven if own else driven
        if len(loose & covered) >= self.option(case, "share") * len(loose):
            yield from self._uncovered(case, config, other, loose - covered, own)

    def _uncovered(
        self, case: Case, config: RobotConfig, other: int, joints: set[str], own: bool
    ) -> Iterator[Finding]:
        robot = case.artifacts[other].robot
        assert robot is not None
        file = basename(robot.path)
        loose = [joint for joint in robot.joints if joint.name in joints]
        names = joint_names(case.artifacts[other]) or ()
        # Another robot's USD, and a model of another variant, are of whoever has put them into one folder.
        stated = () if own or case.is_met_at(config.span) else posed(config, names)
        lost = any(
            selects_nothing(config.framework, pattern, names)
            for group in config.groups
            for pattern in group.joints or ()
        )
        for joint in loose:
            near = None if own or case.is_met_at(joint.span) else _called(case, other, joint.name, names)
            if near is not None:
                yield Finding(
                    self.code,
                    f"this joint is called {near[0]} in {basename(near[1])}, and no actuator group selects it by the "
                    "name that it has here",
                    joint.span,
                    joint.name,
                    help=f"did you mean '{near[0]}'?",
                    related=(config.span,),
                )
                continue
            # ORD104 tells of the pattern that was meant for it.
            sure = own or (joint.name in stated and not lost)
            yield Finding(
                self.code,
                f"this joint of {file} is in no actuator group, and nothing else moves it: it swings freely"
                if own
                else f"{file} drives this joint, this configuration sets its position, and no actuator group selects "
                "it: it swings freely"
                if sure
                else f"{file} drives this joint, and no actuator group selects it: where the USD has it, it swings "
                "freely",
                config.span,
                joint.name,
                help="add it to a group",
                related=(joint.span,),
                severity=None if sure else Severity.INFO,
            )


def _called(case: Case, index: int, joint: str, names: Sequence[str]) -> tuple[str, str] | None:
    """How another file of the robot calls a joint of a model, where it is misspelt in one of the two; and that file."""
    for other in case.robot_of(index).artifacts:
        theirs = joint_names(case.artifacts[other]) or ()
        if joint in theirs:
            continue
        near = next((name for name in theirs if name not in names and _is_misspelt(joint, name)), None)
        if near is not None:
            return near, case.artifacts[other].path
    return None


def _is_misspelt(one: str, other: str) -> bool:
    """Whether two names differ by a letter inside a word. Sides, axes and numbers tell joints from each other, and are
    shorter than the four letters of a word here, or differ in the first one.
    """
    words = re.findall(r"[^\W\d_]+|\d+", one), re.findall(r"[^\W\d_]+|\d+", other)
    if len(words[0]) != len(words[1]):
        return False
    differing = [pair for pair in zip(*words, strict=True) if pair[0] != pair[1]]
    if len(differing) != 1 or not is_slip(one, [other]):
        return False
    mine, its = differing[0]
    return max(len(mine), len(its)) >= 4 and mine[0] == its[0]


def _whole(config: RobotConfig) -> bool:
    """Whether the groups are a robot's, and all of them are known."""
    if not config.groups or any(group.joints is None for group in config.groups):
        return False
    if any(note.where.startswith("actuators") for note in config.notes):
        return False
    return len(config.groups) > 1 or config.groups[0].name != config.name


def _loose(robot: RobotView) -> set[str]:
    """Joints that no spring, equality or tendon of an MJCF holds, and that are in no closed loop."""
    held = {
        found.decode("utf-8", "replace")
        for file in robot.files
        for found in re.findall(rb"""(?:joint[12]|<joint\s+joint)\s*=\s*["']([^"']+)""", file.data)
    }
    held |= _in_loops(robot)
    return {
        joint.name
        for joint in robot.joints
        if joint.kind in (JointKind.HINGE, JointKind.SLIDE)
        and joint.name not in held
        and joint.stiffness == 0.0
    }


def _in_loops(robot: RobotView) -> set[str]:
    """Joints between the base and a body that a connect or weld ties to another: a linkage moves them."""
    tied = {
        found.decode("utf-8", "replace")
        for file in robot.files
        for element in re.findall(rb"<(?:connect|weld)\b[^>]*>", file.data)
        for found in re.findall(rb"""\bbody[12]\s*=\s*["']([^"']+)""", element)
    }
    parents = {joint.name: joint.parent for joint in robot.joints}
    found = set()
    for joint in robot.joints if tied else ():
        name = joint.name if joint.body in tied else ""
        while name and name not in found:
            found.add(name)
            name = parents.get(name, "")
    return found
