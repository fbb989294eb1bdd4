from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Sequence
from os.path import basename
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.configs import is_as_written, is_whole_robot, names_model, posed
from actspec.audit.rules.joints import has_no_room, names_undriven
from actspec.audit.rules.misnamed import is_misspelt, misnamed
from actspec.audit.rules.ord101 import stated_order
from actspec.audit.rules.sided import other_side
from actspec.diagnostics import Span, listed
from actspec.readings.artifact import FileKind, Framework, RobotConfig
from actspec.readings.dict_keys import selects_nothing
from actspec.readings.joint_names import joint_names, selected
from actspec.robot.view import JointView, ModelFormat, RobotView

_Subject = tuple[int, RobotConfig, Sequence[tuple[int, RobotView]]]
"""A configuration, and the models of its robot that it is held to."""

_Place = tuple[str, tuple[Span, ...]]
"""A file that has a joint or drives it, and where that and the joint are written."""

_MOVES = ("add_equality", "add_tendon", "add_actuator")
"""Methods of `MjSpec` that give a joint something that moves it."""


class JointNotCovered(RuleOver[_Subject]):
    code = "CFG102"
    name = "joint-not-covered"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    written_over = frozenset({"actuators", "joints", "drives"})
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
            models = tuple(_models(case, index, config))
            if models:
                yield index, config, models

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Find joints that are in no group; a joint of several models of the robot once."""
        index, config, models = subject
        own = config.framework is Framework.MJLAB
        uncovered: dict[tuple[str, str | None], list[_Place]] = {}
        slowed: set[str] = set()
        for other, robot in models:
            called = {} if case.is_met_at(config.span) else _called(case, index, other)
            yield from (self._otherwise(config, *found) for found in called.values())
            covered, driven = _moved(case, index, other, robot)
            wanted = _loose(robot) - driven.keys() if own else driven.keys()
            missing = wanted - covered - called.keys()
            if not missing or len(wanted & covered) < self.option(case, "share") * len(wanted):
                continue
            meant = {} if own or case.is_met_at(config.span) else _meant(case, index, other, missing, covered)
            for joint in robot.joints:
                if joint.name not in missing:
                    continue
                if joint.damping or joint.frictionloss:
                    slowed.add(joint.name)
                near = None if own or case.is_met_at(joint.span) else _misspelt(case, other, joint.name)
                if near is not None:
                    yield self._otherwise(config, joint, *near)
                    continue
                by = driven.get(joint.name, other)
                spans = (joint.span,) if by == other else (case.joints[by, joint.name][0].span, joint.span)
                place = basename(case.artifacts[by].path), spans
                uncovered.setdefault((joint.name, meant.get(joint.name)), []).append(place)
        for (name, why), places in uncovered.items():
            yield self._uncovered(config, name, why, places, "" if name in slowed else ": it swings freely")

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
        self, config: RobotConfig, joint: str, why: str | None, places: Sequence[_Place], swings: str
    ) -> Finding:
        """A joint that no group selects, where models have it, and what tells that it is meant to be driven."""
        first: dict[Span, str] = {}
        for file, spans in places:
            # A scene has the joint of the model that it includes.
            first.setdefault(spans[-1], file)
        files = list(dict.fromkeys(first.values()))
        drive = "drive" if files[1:] else "drives"
        own = config.framework is Framework.MJLAB
        return Finding(
            self.code,
            f"this joint of {listed(files, 2)} is in no actuator group, and nothing else in the model moves it{swings}"
            if own
            else f"{listed(files, 2)} {drive} this joint, {why}, and no actuator group selects it: it swings freely"
            if why
            else f"{listed(files, 2)} {drive} this joint, and no actuator group selects it: where the USD has it, it "
            "swings freely",
            config.span,
            joint,
            help="add it to a group",
            related=tuple(dict.fromkeys(span for _, spans in places for span in spans)),
            severity=None if own or why else Severity.INFO,
            noted_in_folders=own and names_undriven(joint),
        )


def _models(case: Case, index: int, config: RobotConfig) -> Iterator[tuple[int, RobotView]]:
    """The models of a configuration's robot that say which of its joints are driven."""
    for other in case.robot_of(index).artifacts:
        model = case.artifacts[other]
        if model.robot is None:
            continue
        if model.kind is FileKind.URDF and not _driven_by_deploy(case, index, model.robot):
            continue
        if config.framework is Framework.MJLAB and (
            model.kind is not FileKind.MJCF or not names_model(case, config, model)
        ):
            continue
        yield other, model.robot


def _moved(case: Case, index: int, other: int, robot: RobotView) -> tuple[set[str], dict[str, int]]:
    """Joints that a configuration drives, and those that something beside it does, each with the artifact that does."""
    config = case.artifacts[index].config
    # By this model's names: those of the configuration's rows may be another variant's.
    covered = selected(config, joint_names(case.artifacts[other]) or ())
    if robot.format is not ModelFormat.URDF or (config is not None and config.framework is Framework.MJLAB):
        return covered, {
            row.joint: other for row in case.rows_of(other) if row.joint and row.control != "none"
        }
    # A base for the legs, and a configuration that adds what the deploy file drives beside them.
    others = (one for one in case.robot_of(index).artifacts if one != index)
    covered |= {
        row.joint for one in others if case.artifacts[one].kind is FileKind.CFG for row in case.rows_of(one)
    }
    return covered, _driven_by_deploy(case, index, robot)


def _meant(
    case: Case, index: int, other: int, missing: Collection[str], covered: Collection[str]
) -> dict[str, str]:
    """Of a model's joints that are in no group those that the configuration's own robot has, with what tells that.

    None where a pattern is lost: ORD104 tells of the one that was meant for them. Not of files in a stranger's folder:
    another robot's USD, and a model of another variant, are of whoever has put them together.
    """
    config = case.artifacts[index].config
    names = joint_names(case.artifacts[other]) or ()
    assert config is not None
    patterns = [pattern for group in config.groups for pattern in group.joints or ()]
    if any(selects_nothing(config.framework, pattern, names) for pattern in patterns):
        return {}
    sides = {name: other_side(name, covered) for name in missing}
    found = {name: f"{side} is in a group" for name, side in sides.items() if side is not None}
    order = stated_order(case.artifacts[index])
    if order is not None:
        found |= dict.fromkeys(order[0], "joint_sdk_names has it")
    return found | dict.fromkeys(posed(config, names), "this configuration sets its position")


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


def _misspelt(case: Case, index: int, joint: str) -> tuple[str, str] | None:
    """How another file of the robot calls a joint of a model, where it is misspelt in one of the two; and that file."""
    names = joint_names(case.artifacts[index]) or ()
    for other in case.robot_of(index).artifacts:
        theirs = joint_names(case.artifacts[other]) or ()
        if joint in theirs:
            continue
        near = next((name for name in theirs if name not in names and is_misspelt(joint, name)), None)
        if near is not None:
            return near, case.artifacts[other].path
    return None


def _loose(robot: RobotView) -> set[str]:
    """Joints that no spring, equality or tendon of an MJCF holds, that are in no closed loop and are no bearings.

    None where a tendon goes from site to site: it moves the joints between them. Nor is a joint loose whose range
    leaves it no room.
    """
    if any(b"<spatial" in file.data for file in robot.files):
        return set()
    held = {
        found.decode("utf-8", "replace")
        for file in robot.files
        for found in re.findall(rb"""(?:joint[12]|<joint\s+joint)\s*=\s*["']([^"']+)""", file.data)
    }
    held |= _in_loops(robot) | _bearings(robot)
    held |= {
        joint.name for joint in robot.scalar_joints if joint.stiffness or has_no_room(joint.kind, joint.range)
    }
    return {joint.name for joint in robot.scalar_joints if joint.name not in held}


def _bearings(robot: RobotView) -> set[str]:
    """Joints whose own element says that nothing resists them, where others' do not: wheels that are to roll."""
    joints = robot.scalar_joints
    found = {
        joint.name
        for joint in joints
        if {"damping", "armature", "frictionloss"} <= joint.stated - joint.places.keys()
        and not (joint.damping or joint.armature or joint.frictionloss)
    }
    return found if len(found) < len(joints) else set()


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
