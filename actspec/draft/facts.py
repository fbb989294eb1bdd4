"""What a robot file says of each joint, in the words of a spec; and what no spec can say.

A joint is only taken into a group if a compile of the draft leaves its dynamics as they are: what
the law has no word for (muscles, integrators, several clamps on one joint) is left alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from actspec.diagnostics import one_line
from actspec.ir import JointKind
from actspec.resolution.model_values import actuators_of, effort_bound
from actspec.resolution.quantities import tidy, unit_of
from actspec.robot.view import ActuatorView, JointView, ModelFormat, RobotView
from actspec.robot.xml_edit import format_number
from actspec.units import Kind

LEAST_DAMPING = 1e-3
"""Damping over kp from which joint damping may be meant as the drive's kd [s]. Chosen: a twentieth of kd/kp
in the published gains of legged robots (0.02 s to 0.04 s)."""

TOLERANCE = 1e-9
"""Relative; a gain and its bias are two numbers of the file."""


@dataclass(frozen=True, slots=True)
class Facts:
    """One joint that goes into a group. All but `joint`, `actuators` and `clamp` decide the group.

    Attributes:
        joint: The joint.
        actuators: The file's actuators on it.
        level: `ideal_pd` or `dc_motor`.
        command: `position`, `velocity` or `effort`.
        values: Field to its text with unit, None for unknown; in the order of the spec.
        line: Stall torque and no-load speed as text; None unless dc_motor.
        clamp: Clamp of the command: `joint`, (low, high) as text, or None.
        notes: Remarks for the group's head.
        hints: Field to the remark beside it.
    """

    joint: JointView
    actuators: tuple[ActuatorView, ...]
    level: str
    command: str
    values: tuple[tuple[str, str | None], ...]
    line: tuple[str, str] | None
    clamp: str | tuple[str, str] | None
    notes: tuple[str, ...]
    hints: tuple[tuple[str, str], ...]

    @property
    def key(self) -> tuple[object, ...]:
        """Joints with the same key go into one group."""
        return self.joint.kind, self.level, self.command, self.values, self.line, self.notes, self.hints


@dataclass(frozen=True, slots=True)
class LeftAlone:
    """A joint that the draft leaves as it is.

    Attributes:
        joint: Its name.
        why: The reason.
    """

    joint: str
    why: str


def read_facts(robot: RobotView) -> tuple[tuple[Facts, ...], tuple[LeftAlone, ...]]:
    """Sort the hinges and slides of a robot into those for a group and those left alone."""
    tendons = _tendon_joints(robot)
    facts: list[Facts] = []
    alone: list[LeftAlone] = []
    for joint in robot.joints:
        if joint.kind not in (JointKind.HINGE, JointKind.SLIDE):
            continue
        own = actuators_of(robot, joint.name)
        why = _unsaid(joint, own)
        if why is None and joint.name in tendons and not own:
            why = f"driven through the tendon '{one_line(tendons[joint.name])}'"
        elif why is None and robot.actuators and not own:
            why = "no actuator"
        if why is None:
            facts.append(_facts(joint, own, robot.format))
        else:
            alone.append(LeftAlone(joint.name, why))
    return tuple(facts), tuple(alone)


def _tendon_joints(robot: RobotView) -> dict[str, str]:
    """Joint to the tendon with an actuator that pulls it; a tendon through sites names no joints."""
    pulled = {a.target for a in robot.actuators if a.transmission == "tendon"}
    if not pulled:
        return {}
    from actspec.robot.xml import parse_document

    found = {}
    for section in parse_document(robot.files).sections("tendon"):
        for tendon in section.children:
            name = tendon.get("name")
            if tendon.tag == "fixed" and name in pulled:
                found.update({part.get("joint") or "": name or "" for part in tendon.children})
    return found


def _unsaid(joint: JointView, own: tuple[ActuatorView, ...]) -> str | None:
    """Why a spec cannot say what acts on a joint; None when it can."""
    if joint.mimic is not None:
        return "follows another joint"
    for name in ("damping", "armature", "frictionloss"):
        value = getattr(joint, name)
        if not 0.0 <= value < math.inf:
            return f"its {name} is {value:g}"
    if not own:
        return None
    kinds = sorted(a.control for a in own)
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
        before_gear = actuator.kp / actuator.gear**2
        if actuator.kp <= 0.0 or abs(actuator.gain - before_gear) > TOLERANCE * abs(before_gear):
            return f"a position servo with gain {actuator.gain:g} and stiffness {before_gear:g}"
    elif kind == "motor":
        if actuator.kd != 0.0 or actuator.offset != 0.0:
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


def _facts(joint: JointView, own: tuple[ActuatorView, ...], form: ModelFormat) -> Facts:
    first = own[0] if own else None
    command = "position"
    if own and all(a.control == "motor" for a in own):
        command = "effort"
    elif own and not any(a.kp for a in own):
        command = "velocity"
    kp, kd = sum(a.kp for a in own), sum(a.kd for a in own)
    as_is = not own or (len(own) == 1 and own[0].gear == 1.0)
    slide = joint.kind is JointKind.SLIDE

    def text(value: float, kind: Kind, exact: bool = True) -> str:
        return figure(value, unit_of(kind, joint.kind), exact)

    values: dict[str, str | None] = {}
    if command == "position":
        values["kp"] = text(kp, Kind.STIFFNESS, as_is) if own else None
    if command != "effort":
        values["kd"] = text(kd, Kind.VELOCITY_GAIN, as_is) if kd else None
    bound = effort_bound(joint, own)
    values["effort_limit"] = None if bound is None else text(bound, Kind.TORQUE, as_is)
    if form is ModelFormat.URDF:
        speed = joint.velocity_limit
        values["velocity_limit"] = text(speed, Kind.SPEED) if speed else None
    armature = sum(a.gear**2 * a.armature for a in own)
    values["armature"] = _stated(joint, "armature", joint.armature, armature, text, Kind.INERTIA)
    damping = sum(a.gear**2 * a.damping[0] for a in own)
    values["friction.coulomb"] = _stated(joint, "frictionloss", joint.frictionloss, 0.0, text, Kind.TORQUE)
    values["friction.viscous"] = _stated(joint, "damping", joint.damping, damping, text, Kind.VELOCITY_GAIN)
    if first is not None and first.time_constant > 0.0:
        values["command_filter"] = figure(1.0 / (2.0 * math.pi * first.time_constant), "Hz", False)
    if first is not None and first.delay > 0.0:
        values["delay"] = figure(first.delay, "s", True)
    if first is not None and first.control == "position" and first.offset:
        bias = -first.offset * first.gear / kp
        values["encoder_bias"] = text(bias, Kind.POSITION, False)
    line = None
    if first is not None and first.line is not None:
        line = (text(first.line[0], Kind.TORQUE, False), text(first.line[1], Kind.SPEED, False))
    return Facts(
        joint=joint,
        actuators=own,
        level="dc_motor" if line is not None else "ideal_pd",
        command=command,
        values=tuple(values.items()),
        line=line,
        clamp=None if first is None else _clamp(joint, own, command),
        notes=tuple(_notes(joint, own, command, "N" if slide else "N*m")),
        hints=tuple(_hints(joint, own, command, kp, kd, damping, form).items()),
    )


def _stated(
    joint: JointView, field: str, at_joint: float, at_actuator: float, text: Callable[..., str], kind: Kind
) -> str | None:
    """The joint's own number with the actuator's on top; None where the file states neither."""
    if not at_joint and not at_actuator and field not in joint.stated:
        return None
    return text(at_joint + at_actuator, kind, at_actuator == 0.0)


def _clamp(joint: JointView, own: tuple[ActuatorView, ...], command: str) -> str | tuple[str, str] | None:
    """Clamp of the command in joint units; a motor's is part of its effort limit."""
    if command == "effort":
        return None
    lead = next((a for a in own if a.control != "velocity"), own[0])
    if lead.control_range is None:
        return None
    low, high = sorted(end / lead.gear for end in lead.control_range)
    if command == "position" and joint.range is not None:
        size = max(abs(end) for end in (*joint.range, 1e-9))
        if all(abs(a - b) <= TOLERANCE * size for a, b in zip((low, high), joint.range, strict=True)):
            return "joint"
    unit = unit_of(Kind.POSITION if command == "position" else Kind.SPEED, joint.kind)
    exact = lead.gear == 1.0
    return figure(low, unit, exact), figure(high, unit, exact)


def _notes(joint: JointView, own: tuple[ActuatorView, ...], command: str, unit: str) -> list[str]:
    notes = []
    if len(own) > 1:
        notes.append(f"{len(own)} actuators in the file ({', '.join(a.control for a in own)}) become one")
    factor = own[0].gear * (own[0].gain if command == "effort" else 1.0) if own else 1.0
    if factor != 1.0:
        where = f"in {unit} at the joint" if command == "effort" else "in joint units"
        what = "gear and gain" if command == "effort" else "gear"
        notes.append(f"the file's {what} of {factor:g} go: after a compile the control is {where}")
    spans = [a.force_range for a in own]
    spans += [a.control_range for a in own if a.control == "motor"]
    for span in (*spans, joint.effort_range):
        if span is not None and abs(span[0] + span[1]) > TOLERANCE * max(abs(span[0]), abs(span[1])):
            notes.append(
                f"the file's limit is not symmetric ({span[0]:g} to {span[1]:g}), a spec has one number: the larger"
            )
            break
    if any(joint.damping_polynomial) or any(any(a.damping[1:]) for a in own):
        notes.append("the file's polynomial damping stays in the model, a spec has no word for it")
    return notes


def _hints(
    joint: JointView,
    own: tuple[ActuatorView, ...],
    command: str,
    kp: float,
    kd: float,
    at_actuator: float,
    form: ModelFormat,
) -> dict[str, str]:
    hints: dict[str, str] = {}
    viscous = joint.damping + at_actuator
    if command == "position" and not own:
        hints["kp"] = "the file has no actuators: gains are the controller's"
        if viscous > 0.0:
            hints["friction.viscous"] = (
                "the bearing's, or the drive's kd in disguise? Then move it to kd, and put 0"
            )
    elif command == "position" and kd == 0.0:
        hints["kd"] = "the file's servo has no kv: MuJoCo takes 0"
        if viscous >= LEAST_DAMPING * kp:
            hints["kd"] += "; perhaps its joint damping is meant for it"
            hints["friction.viscous"] = "perhaps the drive's kd: then move it there, and put 0 here"
    if form is ModelFormat.URDF:
        hints["armature"] = "a URDF cannot say it: rotor inertia times gear ratio squared"
    return hints


def figure(value: float, unit: str, exact: bool) -> str:
    """A number as a spec writes it: all digits of the file's own, 12 of a computed one."""
    return f"{format_number((value if exact else tidy(value)) + 0.0)} {unit}"
