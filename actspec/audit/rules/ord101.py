from __future__ import annotations

from collections.abc import Iterator, Sequence
from os.path import basename

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding
from actspec.audit.rule import RuleOver
from actspec.audit.rules.joint_order import (
    differing_places,
    first_drives,
    kept_names,
    scalar_joints,
    stated_order,
)
from actspec.diagnostics import Severity
from actspec.readings.artifact import FileKind, Setting
from actspec.robot.view import ActuatorView, RobotView

_Subject = tuple[int, RobotView, tuple[ActuatorView, ...]]


class ActuatorsNotInJointOrder(RuleOver[_Subject]):
    code = "ORD101"
    name = "actuator-order-is-not-joint-order"
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
            f"{len(places)} of {len(driven)} actuators do not stand where their joints do: place {places[0]} is "
            f"{driven[places[0]]} in ctrl and {joints[places[0]]} in qpos"
        )
        if other is not None:
            text += f"; the joint order of {basename(other[0])} is not that of ctrl"
        yield Finding(
            self.code,
            text,
            drives[places[0]].span,
            help="map by name between ctrl and qpos; a policy's order is that of the simulator that it was "
            "trained in",
            related=(other[1].span,) if other is not None else (),
            severity=self.severity if other is None else Severity.WARNING,
        )


def _other_order(case: Case, index: int, driven: Sequence[str]) -> tuple[str, Setting] | None:
    """A file of the robot with a joint order that is not the actuators'."""
    for other in case.robot_of(index).artifacts:
        order = stated_order(case.artifacts[other])
        if order is not None and differing_places(kept_names(order[0], driven), kept_names(driven, order[0])):
            return case.artifacts[other].path, order[1]
    return None
