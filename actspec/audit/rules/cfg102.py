from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from os.path import basename
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.configs import is_as_written, is_whole_robot, names_model, posed
from actspec.audit.rules.misnamed import is_misspelt, misnamed
from actspec.audit.rules.sided import other_side
from actspec.readings.artifact import FileKind, Framework, RobotConfig
from actspec.readings.dict_keys import selects_nothing
from actspec.readings.pair import joint_names
from actspec.robot.view import JointView, ModelFormat, RobotView

_Subject = tuple[int, RobotConfig, int, RobotView]

_MOVES = ("add_equality", "add_tendon", "add_actuator")
"""Methods of `MjSpec` that give a joint something that moves it."""


class JointNotCovered(RuleOver[_Subject]):
    code = "CFG102"
    name = "joint-not-covered"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    needs = "no whole configuration of Isaac Lab or mjlab beside an MJCF of its robot, or a URDF and a deploy file"
    options: ClassVar[dict[str, float]] = {"share": 0.6}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for index, artifact in case.of_kind(FileKind.CFG):
            config = artifact.config
            if config is None or config.framework not in (Framework.MJLAB, Framework.ISAACLAB):
                continue
            if not is_whole_robot(config) or not is_as_written(config, *_MOVES):
                continue
            for other in case.robot_of(index).artifacts:
                model = case.artifacts[other]
                if model.robot is None:
                    continue
                own = config.framework is Framework.MJLAB
                if model.kind is FileKind.URDF and not _driven_by_deploy(case, index, model.robot):
                    continue
                if own and (model.kind is not FileKind.MJCF or not names_model(case, config, model)):
                    continue
                yield index, config, other, model.robot

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Find joints that are in no group."""
        index, config, other, robot = subject
        covered = {row.joint for row in case.rows_of(index)}
        called = {} if case.is_met_at(config.span) else _called(case, index, other)
        yield from (self._otherwise(config, *found) for found in called.values())
        own = config.framework is Framework.MJLAB
        driven = {row.joint: other for row in case.rows_of(other) if row.joint and row.control != "none"}
        if not own and robot.format is ModelFormat.URDF:
            driven = _driven_by_deploy(case, index, robot)
            # A base for the legs, and a configuration that adds what the deploy file drives beside them.
            others = (one for one in case.robot_of(index).artifacts if one != index)
            covered |= {
                row.joint
                for one in others
                if case.artifacts[one].kind is FileKind.CFG
                for row in case.rows_of(one)
            }
        wanted = _loose(robot) - driven.keys() if own else driven.keys()
        if len(wanted & covered) >= self.option(case, "share") * len(wanted):
            missing = {joint: driven.get(joint, other) for joint in wanted - covered - called.keys()}
            yield from self._uncovered(case, config, other, missing, covered)

    def _otherwise(self, config: RobotConfig, joint: JointView, name: str, path: str) -> Finding:
        """A joint that the model calls otherwise than the groups and another file of the robot do."""
        return Finding(
            self.code,
            f"this joint is called {name} in {basename(path)}, and no actuator group selects it by the "
            "name that it has here",
            joint.span,
            joint.name,
            help=f"did you mean '{name}'?",
            related=(config.span,),
        )

    def _uncovered(
        self, case: Case, config: RobotConfig, other: int, joints: Mapping[str, int], covered: Collection[str]
    ) -> Iterator[Finding]:
        """Joints that no group selects, each with the artifact that drives it."""
        robot = case.artifacts[other].robot
        assert robot is not None
        own = config.framework is Framework.MJLAB
        names = joint_names(case.artifacts[other]) or ()
        # Another robot's USD, and a model of another variant, are of whoever has put them into one folder.
        stated = () if own or case.is_met_at(config.span) else posed(config, names)
        lost = any(
            selects_nothing(config.framework, pattern, names)
            for group in config.groups
            for pattern in group.joints or ()
        )
        for joint in robot.joints:
            if joint.name not in joints:
                continue
            by = joints[joint.name]
            near = None if own or case.is_met_at(joint.span) else _misspelt(case, other, joint.name, names)
            if near is not None:
                yield self._otherwise(config, joint, *near)
                continue
            file = basename(case.artifacts[by].path)
            # ORD104 tells of the pattern that was meant for it.
            side = None if own or case.is_met_at(config.span) else other_side(joint.name, covered)
            sure = own or ((joint.name in stated or side is not None) and not lost)
            placed = joint.name in stated
            why = "this configuration sets its position" if placed else f"{side} is in a group"
            yield Finding(
                self.code,
                f"this joint of {file} is in no actuator group, and nothing else moves it: it swings freely"
                if own
                else f"{file} drives this joint, {why}, and no actuator group selects it: it swings freely"
                if sure
                else f"{file} drives this joint, and no actuator group selects it: where the USD has it, it swings "
                "freely",
                config.span,
                joint.name,
                help="add it to a group",
                related=(joint.span,) if by == other else (case.joints[by, joint.name][0].span, joint.span),
                severity=None if sure else Severity.INFO,
            )


def _driven_by_deploy(case: Case, index: int, robot: RobotView) -> dict[str, int]:
    """Joints of a URDF that a deploy file beside a configuration has a gain for, each with that file.

    What an MJCF of the robot drives is told with that; a joint that follows another one has no drive.
    """
    members = case.robot_of(index).artifacts
    if any(case.artifacts[other].kind is FileKind.MJCF for other in members):
        return {}
    alone = {joint.name for joint in robot.joints if joint.mimic is None}
    return {
        row.joint: other
        for other in members
        if case.artifacts[other].kind is FileKind.DEPLOY
        for row in case.rows_of(other)
        if row.joint in alone and (row.kp or row.kd)
    }


def _called(case: Case, index: int, model: int) -> dict[str, tuple[JointView, str, str]]:
    """Joints of a model that lists of joints and a configuration's groups call otherwise: each with that name, and the
    file with the list.
    """
    return {
        one.joint.name: (one.joint, one.name, case.artifacts[one.list].path)
        for one in case.once(misnamed)
        if one.model == model and one.patterns is case.artifacts[index]
    }


def _misspelt(case: Case, index: int, joint: str, names: Sequence[str]) -> tuple[str, str] | None:
    """How another file of the robot calls a joint of a model, where it is misspelt in one of the two; and that file."""
    for other in case.robot_of(index).artifacts:
        theirs = joint_names(case.artifacts[other]) or ()
        if joint in theirs:
            continue
        near = next((name for name in theirs if name not in names and is_misspelt(joint, name)), None)
        if near is not None:
            return near, case.artifacts[other].path
    return None


def _loose(robot: RobotView) -> set[str]:
    """Joints that no spring, equality or tendon of an MJCF holds, and that are in no closed loop."""
    held = {
        found.decode("utf-8", "replace")
        for file in robot.files
        for found in re.findall(rb"""(?:joint[12]|<joint\s+joint)\s*=\s*["']([^"']+)""", file.data)
    }
    held |= _in_loops(robot)
    return {joint.name for joint in robot.scalar_joints if joint.name not in held and joint.stiffness == 0.0}


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
