"""Joints of an MJCF that have an actuator more than they should, and those that have none in their place."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from actspec.audit.case import Case
from actspec.audit.rules.sided import other_side
from actspec.joints import begin_alike
from actspec.readings.artifact import FileKind
from actspec.robot.view import ActuatorView, RobotView


@dataclass(frozen=True, slots=True)
class Crowded:
    """One joint.

    Attributes:
        artifact: Index of the model.
        joint: Has an actuator more than its other side, or than its name says.
        lone: Has none.
        side: The other side of that joint, which has one; "" where the actuator's name tells.
        actuator: The one that is meant for it.
        first: Another one of the joint.
    """

    artifact: int
    joint: str
    lone: str
    side: str
    actuator: ActuatorView
    first: ActuatorView


def crowded(case: Case) -> tuple[Crowded, ...]:
    """Joints with two actuators of one kind, where one of the two is another joint's that has none.

    A joint without a drive is none by itself: what tells is its other side, which has one, while the joint with two has
    more than its own other side; or the name of the actuator, which is the other joint's.
    """
    found = []
    for index, artifact in case.of_kind(FileKind.MJCF):
        if artifact.robot is not None:
            found += list(_of_model(index, artifact.robot))
    return tuple(found)


def _of_model(index: int, robot: RobotView) -> Iterator[Crowded]:
    by_joint: dict[str, list[ActuatorView]] = {joint.name: [] for joint in robot.scalar_joints}
    for actuator in robot.actuators:
        if actuator.is_direct:
            by_joint.setdefault(actuator.target, []).append(actuator)
        elif actuator.moves is None:
            # It may move any joint.
            return
    driven = {name for name, own in by_joint.items() if own}
    pulled = {name for actuator in robot.actuators for name in actuator.moves or ()}
    lone = [name for name in by_joint if name not in driven | pulled | robot.coupled]
    for joint in driven:
        own = by_joint[joint]
        if len(own) < 2 or len({actuator.control for actuator in own}) > 1:
            # A position and a velocity actuator are one drive.
            continue
        twin = other_side(joint, by_joint)
        more = twin is not None and len(own) > len(by_joint[twin]) > 0
        sides = (
            {name: other for name in lone if (other := other_side(name, driven)) is not None} if more else {}
        )
        named = [
            (actuator, name) for actuator in own for name in lone if _is_named(actuator.name, name, joint)
        ]
        if len(named) == 1 and (more or twin is None):
            actuator, name = named[0]
        elif len(sides) == 1:
            actuator, name = own[-1], next(iter(sides))
        else:
            continue
        first = next(one for one in own if one is not actuator)
        yield Crowded(index, joint, name, sides.get(name, ""), actuator, first)


def _is_named(actuator: str, joint: str, other: str) -> bool:
    """Whether an actuator is called after one joint, and not after another."""
    return begin_alike(actuator, joint) and not begin_alike(actuator, other)
