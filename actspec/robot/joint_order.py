"""The order in which Isaac Lab has a robot's joints."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from actspec.joints import JointKind
from actspec.robot.view import ModelFormat, RobotView


def isaac_order(robot: RobotView, wanted: Sequence[str]) -> tuple[str, ...] | None:
    """Joints as Isaac Lab has them: breadth-first over the tree; None where no model tells the tree.

    Joints of one parent go by name. Fixed joints count for nothing, as after the importer's
    `merge_fixed_joints`.

    Args:
        robot: The robot.
        wanted: Joints to give.

    Source:
        Breadth-first: isaac-sim/IsaacLab#37 ("parsing of joints in Isaac Sim is done in a breadth-first
        order"). By name: the URDF importer reads with urdfdom, which keeps joints in a map by name; so Isaac
        Lab's A1 and Go2 begin with FL, FR, RL, RR and its ANYmal with LF, LH, RF, RH, where their URDFs
        begin with FR, FL and with LF, RF. A USD from another importer may differ.
    """
    if robot.format is ModelFormat.NONE:
        return None
    below: dict[str, list[str]] = {}
    for joint in robot.joints:
        below.setdefault(joint.parent, []).append(joint.name)
    free = {joint.name for joint in robot.joints if joint.kind is JointKind.FREE}
    found = []
    queue = deque([""])
    while queue:
        for name in sorted(below.pop(queue.popleft(), ())):
            queue.append(name)
            if name not in free:
                found.append(name)
    kept = set(wanted)
    order = tuple(name for name in found if name in kept)
    return order if len(order) == len(kept) else None
