"""Joints of a robot file for which a spec has no words, with the reason."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from actspec.diagnostics import one_line
from actspec.lift.lifted import LeftAlone
from actspec.lift.robot_loops import coupled_joints, loop_joints
from actspec.resolution.model_values import actuators_of
from actspec.robot.view import ActuatorView, JointView, RobotView
from actspec.robot.xml_tree import XmlDocument

TOLERANCE = 1e-9
"""Relative. Chosen: a gain and its bias are two numbers of the file."""


@dataclass(frozen=True, slots=True)
class Held:
    """What moves or holds joints of an MJCF beside their own actuators.

    Attributes:
        pulled: Joint to the tendon with an actuator.
        coupled: Joint to the one that it follows by an equality; "" for a fixed position.
        loops: Joint to the closed loop that it is in.
    """

    pulled: Mapping[str, str]
    coupled: Mapping[str, str]
    loops: Mapping[str, str]


def held_joints(robot: RobotView, document: XmlDocument | None) -> Held:
    """What moves or holds the joints of a robot.

    Args:
        robot: The robot.
        document: Its MJCF, parsed; None for another format.
    """
    return Held(_pulled(robot, document), coupled_joints(document), loop_joints(document))


def _pulled(robot: RobotView, document: XmlDocument | None) -> dict[str, str]:
    """Joint to the tendon with an actuator that pulls it; a tendon through sites names no joints."""
    pulled = {a.target for a in robot.actuators if a.transmission == "tendon"}
    if not pulled or document is None:
        return {}
    found = {}
    for section in document.sections("tendon"):
        for tendon in section.children:
            name = tendon.get("name")
            if tendon.tag == "fixed" and name in pulled:
                found.update({part.get("joint") or "": name or "" for part in tendon.children})
    return found


def unsaid(robot: RobotView, joint: JointView, held: Held) -> LeftAlone | None:
    """Why a spec cannot say what acts on a joint; None when it can.

    Args:
        robot: The robot.
        joint: A hinge or slide of it.
        held: What else moves or holds its joints.
    """
    own = actuators_of(robot, joint.name)
    name, span = joint.name, joint.span
    if joint.mimic is not None:
        return LeftAlone(
            name, f"follows '{one_line(joint.mimic)}' (mimic)", span, kind="follow other joints (mimic)"
        )
    for field in ("damping", "armature", "frictionloss"):
        value = getattr(joint, field)
        if field not in joint.unknown and not 0.0 <= value < math.inf:
            return LeftAlone(name, f"its {field} is {value:g}", joint.places.get(field, span))
    if own:
        why = _unsaid_together(own)
        return None if why is None else LeftAlone(name, why, own[0].span)
    if name in held.pulled:
        return LeftAlone(name, f"driven through the tendon '{one_line(held.pulled[name])}'", span)
    if name in held.coupled:
        leader = held.coupled[name]
        why = f"follows '{one_line(leader)}' (equality)" if leader else "held by an equality"
        return LeftAlone(
            name, why, span, undriven=True, kind="follow other joints (equality)" if leader else ""
        )
    if name in held.loops:
        lacking = "no actuator, in" if robot.actuators else "in"
        return LeftAlone(name, f"{lacking} {held.loops[name]}", span, undriven=True)
    return LeftAlone(name, "no actuator", span, undriven=True) if robot.actuators else None


def _unsaid_together(own: tuple[ActuatorView, ...]) -> str | None:
    kinds = sorted(a.control for a in own)
    if any(a.disabled for a in own):
        return "an actuator that the file switches off"
    if any("gear" in a.unknown for a in own):
        return "an actuator whose gear the text alone does not tell"
    if any(a.gear == 0.0 for a in own):
        return "an actuator with gear 0"
    if any(a.damping[0] < 0.0 or a.armature < 0.0 for a in own):
        return "an actuator with negative damping or armature"
    if len(own) > 1:
        if kinds != ["position", "velocity"]:
            return f"{len(own)} actuators ({', '.join(kinds)})"
        if any(a.force_range is not None or a.time_constant or a.delay for a in own):
            return "2 actuators, each with its own clamp, filter or delay"
    return next((why for why in map(_unsaid_of, own) if why is not None), None)


def _unsaid_of(actuator: ActuatorView) -> str | None:
    kind = actuator.control
    if kind == "dcmotor":
        if actuator.line is None:
            return "a dcmotor that is more than a PD within its voltage, or is commanded in volts"
    elif kind == "position":
        if {"kp", "gain"} & actuator.unknown:
            return "a position servo whose stiffness the text alone does not tell"
        before_gear = actuator.kp / actuator.gear**2
        if actuator.kp <= 0.0 or abs(actuator.gain - before_gear) > TOLERANCE * abs(before_gear):
            return f"a position servo with gain {actuator.gain:g} and stiffness {before_gear:g}"
    elif kind == "motor":
        if actuator.kd != 0.0 or actuator.offset != 0.0 or {"kd", "gain"} & actuator.unknown:
            return "a motor with a velocity term or a constant force"
        if actuator.gain == 0.0:
            return "a motor with gain 0"
    elif kind != "velocity" or actuator.offset != 0.0:
        return f"an actuator of another kind ({actuator.tag or kind})"
    if actuator.kd < 0.0:
        return f"a servo with kd {actuator.kd:g}"
    if not all(map(math.isfinite, (actuator.kp, actuator.kd, actuator.gear, actuator.gain))):
        return "an actuator with an infinite gain"
    return None
