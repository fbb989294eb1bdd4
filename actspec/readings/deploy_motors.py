"""Deploy files of unitree_rl_lab: gains by the robot's numbering of its motors, pose and actions by the policy's order.

`joint_ids_map` has the motor of each joint of the policy. The names of the motors are the run's, `joint_sdk_names` of
its robot, which the file leaves out.

Source: unitree_rl_lab, utils/export_deploy_cfg.py; deploy/robots/*/src/State_RLBase.cpp and State_Mimic.cpp:
motor_cmd()[i].kp() = joint_stiffness[i], motor_cmd()[joint_ids_map[i]].q() = action[i]; its
include/isaaclab/envs/mdp/actions/joint_actions.h: action[i] = raw[i] * scale[i] + offset[i].
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence

import yaml

from actspec.diagnostics import Collector, Span, listed, many
from actspec.readings.artifact import (
    ActionTerm,
    ActuatorGroup,
    Motors,
    Setting,
)
from actspec.readings.deploy_numbers import no_number
from actspec.readings.deploy_steps import nearest
from actspec.readings.motor_names import ELSEWHERE
from actspec.readings.yaml_nodes import node_span, setting_of

LENGTH = "DEPLOY001"
"""Code of a list with more or fewer values than there are joints."""

TWO_POSES = "DEPLOY007"
"""Code of a joint whose default position is two numbers."""

NO_MOTOR = "DEPLOY008"
"""Code of a joint of the policy that has another one's motor, or none."""

SDK_NAMES = ("joint_sdk_names", "joint_names_sdk_order")
"""Keys of the motors' names, in the order of their numbers. The second is legged_lab's."""

_BY_POLICY = ("default_position",)
"""Fields whose lists are in the policy's order."""

_TERMS = {"JointPositionAction": "position", "JointVelocityAction": "velocity"}
"""Actions that Unitree's controller knows, and what they command."""


def motors_of(
    scopes: Sequence[Mapping[str, yaml.Node]],
    keys: Mapping[str, Sequence[str]],
    mapping: Callable[[yaml.MappingNode], Mapping[str, yaml.Node]],
    out: Collector,
) -> Motors | None:
    """What the lists of a file say of each motor; None where it has no `joint_ids_map` that fits them.

    Joints that have no motor of their own there by a slip lose what is by the policy's order.

    Args:
        scopes: Mappings in which they may stand, the nearest first.
        keys: Field to its keys.
        mapping: A mapping's own and merged keys.
        out: Is told of a joint without a motor of its own, and where an action does not begin at the default pose, by
            a slip.
    """
    ids = nearest(scopes, ("joint_ids_map",))
    gains = [nearest(scopes, keys[field]) for field in ("kp", "kd")]
    lists = [
        found[1].value for found in gains if found is not None and isinstance(found[1], yaml.SequenceNode)
    ]
    written = _numbers(None if ids is None else ids[1])
    if ids is None or len(lists) < 2 or not written:
        return None
    count = max(map(len, lists))
    odd = _without_a_motor(written, count)
    if odd is None:
        return None
    for joint, message in odd.items():
        if message:
            help = "write the number of each motor once"
            out.warning(NO_MOTOR, message, where=ids[0], span=node_span(ids[1].value[joint]), help=help)
    numbers = [None if joint in odd else number for joint, number in enumerate(written)]

    figures: dict[str, dict[str, Setting]] = {}
    for field, own in keys.items():
        found = nearest(scopes, own)
        if found is None or not isinstance(found[1], yaml.SequenceNode):
            continue
        items = found[1].value
        motors: Sequence[int | None] = numbers if field in _BY_POLICY else range(count)
        if len(items) != len(motors):
            message = f"it has {many(len(items), 'value')} for {many(len(motors), 'joint')}"
            out.warning(LENGTH, message, where=found[0], span=node_span(found[1]))
            continue
        no_number(found[0], [(f"entry {i}", item) for i, item in enumerate(items, 1)], out)
        figures[field] = _by_motor(found[1], motors)
    actions = nearest(scopes, ("actions",))
    terms = []
    selected: dict[str, Setting] = {}
    if actions is not None and isinstance(actions[1], yaml.MappingNode):
        for name, node in mapping(actions[1]).items():
            if name in _TERMS and isinstance(node, yaml.MappingNode):
                pose = figures.get("default_position", {}) if _TERMS[name] == "position" else {}
                term = mapping(node)
                terms.append(_term(name, term, node_span(node), numbers, pose, out))
                patterns = _texts(term.get("joint_names"))
                if patterns and _numbers(term.get("joint_ids")):
                    selected[name] = Setting(patterns, node_span(term["joint_ids"]))
    groups = []
    # The gains are by motor, whichever joint has it.
    for motor in map(str, range(count) if odd else sorted(written)):
        own_figures = {field: values[motor] for field, values in figures.items() if motor in values}
        if own_figures:
            at = next(iter(own_figures.values())).span
            groups.append(ActuatorGroup(motor, "deploy", at, (motor,), own_figures))
    order = tuple(None if number is None else str(number) for number in numbers)
    return Motors(count, tuple(groups), tuple(terms), node_span(ids[1]), order, selected)


def _without_a_motor(numbers: Sequence[int], count: int) -> dict[int, str] | None:
    """Places in a `joint_ids_map` whose number is twice there, or no motor's: each with what to say of it, or "" where
    another place says it.

    None where the numbers are of another order than the gains: Unitree's own files of a G1 with 23 joints have 23 gains
    and ascending numbers up to 26 (unitree_rl_mjlab, deploy/robots/g1_23dof).
    """
    beyond = [joint for joint, number in enumerate(numbers) if not 0 <= number < count]
    if len(beyond) > 1 or (beyond and list(numbers) == sorted(numbers)):
        return None
    missing = [str(motor) for motor in range(count) if motor not in numbers]
    # A policy of fewer joints leaves motors out.
    left = f"; none has motor {missing[0]}" if len(missing) == 1 else ""
    found = {}
    for joint, number in enumerate(numbers):
        same = [other for other, its in enumerate(numbers) if its == number]
        if len(same) > 1:
            which = " and ".join(str(other + 1) for other in same)
            found[joint] = (
                f"joints {which} of the policy have motor {number}{left}" if joint == same[1] else ""
            )
    for joint in beyond:
        found[joint] = (
            f"joint {joint + 1} of the policy has motor {numbers[joint]}, and the gains are of motors 0 to "
            f"{count - 1}{left}"
        )
    return found


def _term(
    name: str,
    term: Mapping[str, yaml.Node],
    place: Span,
    numbers: Sequence[int | None],
    pose: dict[str, Setting],
    out: Collector,
) -> ActionTerm:
    """An action of the policy; of a joint whose default position is two numbers by a slip the pose loses it."""
    chosen = _numbers(term.get("joint_ids"))
    known = range(len(numbers))
    strange = [each for each, one in enumerate(chosen) if one not in known]
    if strange:
        whose = "is no joint's number" if len(strange) == 1 else "are no joints' numbers"
        message = f"{listed(str(chosen[each]) for each in strange)} {whose}: those of the policy are 0 to {known[-1]}"
        at = node_span(term["joint_ids"].value[strange[0]])
        out.warning(ELSEWHERE, message, where=f"{name}.joint_ids", span=at)
    twice = [number for number, count in Counter(chosen).items() if count > 1]
    if twice:
        stand = "stands" if len(twice) == 1 else "stand"
        message = (
            f"{listed(map(str, twice))} {stand} more than once, and each number is of a joint of its own"
        )
        at = node_span(term["joint_ids"].value[chosen.index(twice[0], chosen.index(twice[0]) + 1)])
        help = "write the number of each joint once"
        out.warning(ELSEWHERE, message, where=f"{name}.joint_ids", span=at, help=help)
    motors = [numbers[one] if one in known else None for one in chosen] or numbers
    scale, offset = (_by_motor(term.get(key), motors) for key in ("scale", "offset"))
    shared = {motor: one for motor, one in offset.items() if motor in pose}
    others = {motor: one for motor, one in shared.items() if one.value != pose[motor].value}
    # The action begins at the default pose, as both lists of the file say of other joints.
    added = any(one.value and motor not in others for motor, one in shared.items())
    # A left and a right joint that have the same two numbers are one slip.
    slips: dict[tuple[object, object], list[str]] = {}
    for motor, one in others.items() if added else ():
        slips.setdefault((pose.pop(motor).value, one.value), []).append(motor)
    for (posed, begun), same in slips.items():
        joints = [str(numbers.index(int(motor)) + 1) for motor in same]
        which = " and ".join(joints) if len(joints) < 3 else listed(joints, 4)
        whose = (
            f"joint {which} of the policy has" if len(joints) == 1 else f"joints {which} of the policy have"
        )
        message = (
            f"{whose} {posed:g} rad here, and an offset of {begun:g} rad in {name}, which has the default positions of "
            "the others"
        )
        help = "write the same number in both"
        out.warning(TWO_POSES, message, where="default_joint_pos", span=others[same[0]].span, help=help)
    return ActionTerm(
        name,
        name,
        tuple(dict.fromkeys(str(motor) for motor in motors if motor is not None)),
        _TERMS[name],
        "",
        _of_all(scale, motors, term.get("scale")),
        None if added or (pose and not others) else _of_all(offset, motors, term.get("offset")),
        None,
        place,
    )


def _by_motor(node: yaml.Node | None, motors: Sequence[int | None]) -> dict[str, Setting]:
    """The numbers of a list by motor; none of a list of another length."""
    items = node.value if isinstance(node, yaml.SequenceNode) else []
    if len(items) != len(motors):
        return {}
    pairs = zip(motors, map(setting_of, items), strict=True)
    return {str(motor): one for motor, one in pairs if one is not None and motor is not None}


def _numbers(node: yaml.Node | None) -> list[int]:
    """Whole numbers of a list; none of anything else."""
    items = node.value if isinstance(node, yaml.SequenceNode) else []
    found = [one.number for one in map(setting_of, items) if one is not None and one.number is not None]
    return (
        [int(one) for one in found] if len(found) == len(items) and all(map(float.is_integer, found)) else []
    )


def _of_all(
    values: Mapping[str, Setting],
    motors: Sequence[int | None],
    node: yaml.Node | None,
) -> Setting | None:
    """A list as values by motor; unknown where it is none of so many numbers."""
    if node is None:
        return None
    if len(values) < len(motors) - motors.count(None):
        return Setting(None, node_span(node), "it is no list of a number for each joint")
    places = {motor: one.span for motor, one in values.items()}
    return Setting({motor: one.value for motor, one in values.items()}, node_span(node), places=places)


def sdk_names(scopes: Sequence[Mapping[str, yaml.Node]]) -> tuple[str, ...]:
    """The names of the motors where the file has them, empty ones for gaps; () where it has none."""
    found = nearest(scopes, SDK_NAMES)
    return () if found is None else _texts(found[1])


def _texts(node: yaml.Node | None) -> tuple[str, ...]:
    """The texts of a list, empty ones for gaps; none of anything else."""
    items = node.value if isinstance(node, yaml.SequenceNode) else []
    if not all(isinstance(item, yaml.ScalarNode) for item in items):
        return ()
    return tuple("" if item.tag.endswith(":null") else str(item.value) for item in items)
