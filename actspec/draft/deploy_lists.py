"""Lists of a deploy file without the names of joints, beside a robot whose joints are known."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from actspec.diagnostics import Collector, listed, one_line
from actspec.draft.sources import places, stated
from actspec.ir import JointActuator, Quantity, unknown
from actspec.readings.artifact import Artifact, NamelessList, RobotConfig
from actspec.readings.deploy_numbers import LEAST_JOINTS
from actspec.readings.motor_names import names_wanted
from actspec.robot.view import JointView, RobotView


def lists_of(config: RobotConfig | None) -> dict[str, NamelessList]:
    """Field to its list without names; none of few entries, which may be the ends of a range."""
    lists = {} if config is None else config.nameless_lists
    return {field: one for field, one in lists.items() if one.entries >= LEAST_JOINTS}


def of_this_robot(
    artifacts: Sequence[Artifact], named: Sequence[JointView | str], out: Collector
) -> Iterator[Artifact]:
    """The parts without deploy files whose lists have more entries than the robot has joints: they are another's.

    Fewer tell nothing: a policy may drive the legs of a humanoid alone. A list of equal entries, which would be taken
    for every joint, is only taken where they are as many as the joints.

    Args:
        artifacts: The parts of one robot.
        named: Its joints where no part is a robot file.
        out: Gets a warning on each that is left out.
    """
    robot = next((part.robot for part in artifacts if part.robot is not None), None)
    robot_file = "--joints" if robot is None else one_line(robot.path)
    for part in artifacts:
        lists = lists_of(part.config)
        counts = _counts(named if robot is None else robot.joints, robot)
        if not counts or not lists or part.config is None:
            yield part
            continue
        longest = max(lists.values(), key=lambda one: one.entries)
        if longest.entries > max(counts):
            out.warning(
                "DRF008",
                f"{longest.key} has {longest.entries} entries, and {robot_file} {max(counts)} joints: the "
                "file is taken for another robot's, and nothing of it is used",
                span=longest.span,
                help="leave it out, or name the robot file that has the joints of these lists",
            )
            continue
        odd = {field for field, one in lists.items() if one.entries not in counts}
        groups = [
            replace(group, settings={name: one for name, one in group.settings.items() if name not in odd})
            for group in part.config.groups
        ]
        groups = [group for group in groups if group.settings]
        yield replace(part, config=replace(part.config, groups=tuple(groups)))


def _counts(joints: Sequence[JointView | str], robot: RobotView | None) -> set[int]:
    """How many joints a list for all of a robot may be for: all, those that follow none, or those with an actuator."""
    moving = [joint for joint in joints if isinstance(joint, str) or joint.kind.is_scalar]
    free = [joint for joint in moving if isinstance(joint, str) or joint.mimic is None]
    own = {joint if isinstance(joint, str) else joint.name for joint in moving}
    driven = own & {actuator.target for actuator in (robot.actuators if robot is not None else ())}
    return {len(each) for each in (moving, free, driven) if each}


def remark_of(part: Artifact) -> str:
    """What is to be said of the lists of a deploy file that are passed over; "" for nothing."""
    taken = {name for group in part.config.groups for name in group.settings} if part.config else set()
    left = [one for field, one in lists_of(part.config).items() if field not in taken]
    if not left:
        return ""
    counts = {one.entries for one in left}
    if len(counts) == 1:
        each = " each" if len(left) > 1 else ""
        said = f"{listed((one_line(one.key) for one in left), 9)} ({counts.pop()} entries{each})"
    else:
        said = listed((f"{one_line(one.key)} ({one.entries} entries)" for one in left), 9)
    motors = part.config.motors if part.config is not None else None
    return f"no joint is named for {said}, so they are left out: add to the file {names_wanted(motors)}"


def with_reasons(joint: JointActuator, lists: Mapping[str, NamelessList]) -> JointActuator:
    """A joint of which nobody states gains or pose, with the list that was passed over as the reason.

    Args:
        joint: Of all files together.
        lists: Field to the list of a deploy file.
    """

    def why(name: str) -> str:
        return f"{places([lists[name].span])} has {lists[name].entries} without joint names"

    gains: dict[str, Quantity | None] = {"kp": joint.kp, "kd": joint.kd}
    for name, found in gains.items():
        if found is not None and not found.known and found.span is None and name in lists:
            gains[name] = unknown(found.unit, why(name), lists[name].span)
    pose = joint.default_position
    if "default_position" in lists and not stated(pose):
        pose = unknown(pose.unit, why("default_position"), lists["default_position"].span)
    return replace(joint, kp=gains["kp"], kd=gains["kd"], default_position=pose)
