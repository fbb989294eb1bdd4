from __future__ import annotations

from collections.abc import Iterator, Sequence
from os.path import basename

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.readings.artifact import Artifact, FileKind, Setting
from actspec.robot.view import ActuatorView, RobotView


def first_drives(robot: RobotView) -> tuple[ActuatorView, ...]:
    """The first actuator of each joint that has one, in the actuators' order."""
    scalar = set(scalar_joints(robot))
    found: dict[str, ActuatorView] = {}
    for actuator in robot.actuators:
        if actuator.is_direct and actuator.target in scalar:
            found.setdefault(actuator.target, actuator)
    return tuple(found.values())


def scalar_joints(robot: RobotView) -> tuple[str, ...]:
    return tuple(joint.name for joint in robot.scalar_joints)


def stated_order(artifact: Artifact) -> tuple[tuple[str, ...], Setting] | None:
    """An order of joints that a file states, and where."""
    setting = artifact.config.settings.get("joint_order") if artifact.config is not None else None
    if setting is None or not isinstance(setting.value, tuple) or len(setting.value) < 2:
        return None
    return tuple(str(name) for name in setting.value), setting


def binding_order(artifact: Artifact) -> tuple[tuple[str, ...], Setting] | None:
    """An order of joints that a file states, and that what runs it goes by."""
    by_name = artifact.config is not None and artifact.config.by_name
    return None if by_name else stated_order(artifact)


def kept_names(order: Sequence[str], names: Sequence[str]) -> tuple[str, ...]:
    """The names of one order that another has too, each once."""
    kept = set(names)
    return tuple(name for name in dict.fromkeys(order) if name in kept)


def differing_places(one: Sequence[str], other: Sequence[str]) -> list[int]:
    """Places at which two orders of the same names differ."""
    return [place for place, (a, b) in enumerate(zip(one, other, strict=True)) if a != b]


_Subject = tuple[int, RobotView, tuple[ActuatorView, ...]]


class ActuatorsNotInJointOrder(RuleOver[_Subject]):
    code = "ORD101"
    name = "actuator-order-is-not-joint-order"
    noted_in_folders = True
    severity = Severity.INFO
    confidence = Confidence.HIGH
    needs = "no MJCF with several actuators on joints among the files"

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for index, artifact in case.of_kind(FileKind.MJCF):
            robot = artifact.robot
            drives = first_drives(robot) if robot is not None else ()
            if robot is None or len(drives) < 2:
                continue
            yield index, robot, drives

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Compare both orders of each MJCF."""
        index, robot, drives = subject
        driven = tuple(drive.target for drive in drives)
        joints = kept_names(scalar_joints(robot), driven)
        places = differing_places(driven, joints)
        if not places:
            return
        other = _other_order(case, index, driven)
        text = (
            f"actuator and joint order differ for {len(places)} of {len(driven)} actuators: "
            f"ctrl[{robot.actuators.index(drives[places[0]])}] is {driven[places[0]]}, "
            f"{_place(robot, joints[places[0]], places[0])} is {joints[places[0]]}"
        )
        if other is not None:
            text += f"; the joint order of {basename(other[0])} is not that of ctrl"
        yield Finding(
            self.code,
            text,
            drives[places[0]].span,
            joints=tuple(driven[place] for place in places),
            help="map by name between ctrl and qpos; a policy's order is that of the simulator that it was "
            "trained in",
            related=(other[1].span,) if other is not None else (),
            severity=self.severity if other is None else Severity.WARNING,
            about=f"{driven[places[0]]} {joints[places[0]]}",
        )


def _place(robot: RobotView, joint: str, place: int) -> str:
    """Where a joint stands: among the velocities, or in text that MuJoCo does not take among the joints with drives."""
    view = robot.joint(joint)
    return f"joint {place}" if view is None or view.dof < 0 else f"qvel[{view.dof}]"


def _other_order(case: Case, index: int, driven: Sequence[str]) -> tuple[str, Setting] | None:
    """A file of the robot with a joint order that is not the actuators', which nothing brings into it."""
    for other in case.robot_of(index).artifacts:
        config = case.artifacts[other].config
        if config is not None and config.mapped:
            continue
        order = binding_order(case.artifacts[other])
        if order is not None and differing_places(kept_names(order[0], driven), kept_names(driven, order[0])):
            return case.artifacts[other].path, order[1]
    return None
