"""Orders of the joints, and the index maps between them."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence

from actspec.diagnostics import Collector, listed, nearest, shortened
from actspec.ir import JointKind
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


def check_sdk_order(asked: Sequence[str], managed: Sequence[str], where: str, collector: Collector) -> bool:
    """Whether an SDK's order names exactly the managed joints, each once.

    Args:
        asked: The order.
        managed: The joints that the spec manages.
        where: Its place in the spec.
        collector: Takes what is wrong.
    """
    before = len(collector.items)
    seen = set()
    for index, name in enumerate(asked):
        if name in seen:
            collector.error("DEP002", f"'{shortened(name)}' is named twice", where=f"{where}[{index}]")
        elif name not in managed:
            guess = nearest(name, managed)
            collector.error(
                "DEP001",
                f"'{shortened(name)}' is no joint that the spec manages",
                where=f"{where}[{index}]",
                help=f"did you mean '{guess}'?" if guess else f"the joints are: {listed(managed)}",
            )
        seen.add(name)
    missing = [name for name in managed if name not in seen]
    if missing:
        collector.error(
            "DEP003",
            f"{len(missing)} of {len(managed)} managed joints missing: {listed(missing)}",
            where=where,
            help="name every joint that the spec manages once",
        )
    return len(collector.items) == before


def index_map(source: Sequence[str], result: Sequence[str]) -> tuple[int, ...]:
    """Where each entry of one order stands in another: `result[i] = source[index_map(source, result)[i]]`."""
    place = {name: index for index, name in enumerate(source)}
    return tuple(place[name] for name in result)
