"""Joints of a robot file that a spec does not support, with the reason; what else holds them in the file."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from actspec.diagnostics import one_line
from actspec.lift.lifted import LeftAlone
from actspec.readings.compare import EXACT
from actspec.readings.joint import JointReading
from actspec.robot.view import ActuatorView, RobotView
from actspec.robot.xml_tree import Element, XmlDocument

_SERVO = "a position servo with gain"


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
    pulled = {
        joint: actuator.target
        for actuator in robot.actuators
        if actuator.transmission == "tendon"
        for joint in actuator.moves or ()
    }
    return Held(pulled, coupled_joints(document), loop_joints(document))


def unsupported(robot: RobotView, reading: JointReading, held: Held) -> LeftAlone | None:
    """Why a spec cannot say what acts on a joint; None when it can.

    Args:
        robot: The robot.
        reading: What its file says of a hinge or slide of it.
        held: What else moves or holds its joints.
    """
    joint = reading.joint
    name, span = joint.name, joint.span
    if joint.mimic is not None:
        return LeftAlone(
            name, f"follows '{one_line(joint.mimic)}' (mimic)", span, kind="follow other joints (mimic)"
        )
    for figure in ("damping", "armature", "frictionloss"):
        value = getattr(joint, figure)
        if figure not in joint.unknown and not 0.0 <= value < math.inf:
            return LeftAlone(name, f"its {figure} is {value:g}", joint.places.get(figure, span))
    if reading.drives:
        why = _unsupported_drives(reading)
        kind = "position servos whose gain is not their stiffness" if why and why.startswith(_SERVO) else ""
        return None if why is None else LeftAlone(name, why, reading.drives[0].view.span, kind=kind)
    if name in held.pulled:
        why = f"driven through the tendon '{one_line(held.pulled[name])}'"
        return LeftAlone(name, why, span, kind="driven through tendons")
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


def _unsupported_drives(reading: JointReading) -> str | None:
    every = [drive.view for drive in reading.drives]
    own = [drive.view for drive in reading.acting]
    if not own:
        return "an actuator that the file switches off"
    kinds = sorted(a.control for a in own)
    if any("gear" in a.unknown for a in every):
        return "an actuator whose gear is not known from the text alone"
    if any(a.gear == 0.0 for a in own):
        return "an actuator with gear 0"
    if any(a.damping[0] < 0.0 or a.armature < 0.0 for a in every):
        return "an actuator with negative damping or armature"
    if len(own) > 1:
        if kinds != ["position", "velocity"]:
            return f"{len(own)} actuators ({', '.join(kinds)})"
        if any(a.force_range is not None or a.time_constant or a.delay for a in own):
            return "2 actuators, each with its own clamp, filter or delay"
    return next((why for why in map(_unsupported_drive, own) if why is not None), None)


def _unsupported_drive(actuator: ActuatorView) -> str | None:
    kind = actuator.control
    if kind == "dcmotor":
        if actuator.line is None:
            return "a dcmotor that is more than a PD within its voltage, or is commanded in volts"
    elif kind == "position":
        if {"kp", "gain"} & actuator.unknown:
            return "a position servo whose stiffness is not known from the text alone"
        before_gear = actuator.kp / actuator.gear**2
        if actuator.kp <= 0.0 or abs(actuator.gain - before_gear) > EXACT * abs(before_gear):
            return f"{_SERVO} {actuator.gain:g} and stiffness {before_gear:g}"
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


@dataclass(slots=True)
class _Body:
    """A body: its parent, its joints, and whether it floats (free or mocap)."""

    parent: _Body | None
    joints: list[str] = field(default_factory=list)
    loose: bool = False


def coupled_joints(document: XmlDocument | None) -> dict[str, str]:
    """Joint to the one that an MJCF's `<equality><joint>` makes it follow; "" for a fixed position."""
    return {
        element.get("joint1") or "": element.get("joint2") or ""
        for element in _equalities(document)
        if element.tag == "joint"
    }


def loop_joints(document: XmlDocument | None) -> dict[str, str]:
    """Joint to the closed loop that it is in, in words: `the closed loop 'ankle' (connect)`.

    A loop is a `<connect>` or `<weld>` of two bodies of the robot with the joints between them. What holds a body
    to the world, to a mocap body or to something that floats freely closes none.
    """
    if document is None:
        return {}
    bodies: dict[str, _Body] = {}
    sites: dict[str, _Body] = {}
    world = _Body(None)
    for section in document.sections("worldbody"):
        _read(section, world, bodies, sites)
    found: dict[str, str] = {}
    for element in _equalities(document):
        if element.tag not in ("connect", "weld"):
            continue
        ends = [
            bodies.get(element.get(f"body{one}") or "") or sites.get(element.get(f"site{one}") or "")
            for one in "12"
        ]
        names = [element.get(f"body{one}") or element.get(f"site{one}") or "" for one in "12"]
        called = element.get("name")
        words = f"'{one_line(called)}'" if called else f"of {one_line(names[0])} and {one_line(names[1])}"
        for joint in _between(*ends):
            found.setdefault(joint, f"the closed loop {words} ({element.tag})")
    return found


def _equalities(document: XmlDocument | None) -> Iterator[Element]:
    for section in () if document is None else document.sections("equality"):
        yield from (element for element in section.children if element.get("active") != "false")


def _read(element: Element, body: _Body, bodies: dict[str, _Body], sites: dict[str, _Body]) -> None:
    """The bodies below an element; frames and replicas are no bodies."""
    pending = [(element, body)]
    while pending:
        parent, home = pending.pop()
        for child in parent.children:
            if child.tag == "body":
                own = _Body(home, loose=child.get("mocap") == "true")
                bodies.setdefault(child.get("name") or "", own)
                pending.append((child, own))
            elif child.tag in ("joint", "freejoint"):
                home.loose = home.loose or child.tag == "freejoint" or child.get("type") == "free"
                home.joints.append(child.get("name") or "")
            elif child.tag == "site":
                sites.setdefault(child.get("name") or "", home)
            else:
                pending.append((child, home))


def _between(one: _Body | None, other: _Body | None) -> Iterator[str]:
    """Joints on the way from one body to the other; none where a floating body is on it."""
    if one is None or other is None:
        return
    ways = [list(_up(one)), list(_up(other))]
    shared = {id(body) for body in ways[0]} & {id(body) for body in ways[1]}
    way = [body for body in (*ways[0], *ways[1]) if id(body) not in shared]
    if not any(body.loose for body in way):
        yield from (joint for body in way for joint in body.joints)


def _up(body: _Body) -> Iterator[_Body]:
    while body.parent is not None:
        yield body
        body = body.parent
