"""An MJCF or URDF as an ActuatorSet.

A joint is only taken if a compile of it leaves its dynamics as they are: what the law has no word for
(muscles, integrators, several clamps on one joint) is left alone with the reason.
"""

from __future__ import annotations

import math
import os
import re

from actspec.diagnostics import Span
from actspec.ir import (
    ActuatorSet,
    Command,
    Delay,
    InertiaRange,
    JointActuator,
    JointKind,
    Level,
    Quantity,
)
from actspec.lift.lifted import LeftAlone, Lifted
from actspec.lift.quantities import Units, assumed, stated, unknown
from actspec.lift.robot_limits import command_range, effort_limit
from actspec.lift.robot_notes import notes_of
from actspec.lift.robot_unsaid import held_joints, unsaid
from actspec.resolution.model_values import actuators_of
from actspec.resolution.quantities import tidy
from actspec.robot.view import JointView, ModelFormat, RobotView
from actspec.robot.xml_tree import XmlDocument

_KD_STATED = frozenset({"kv", "dampratio", "biasprm", "controller"})
"""Attributes of an actuator that state a velocity gain."""

_TEXT = "the text alone does not tell"


def lift_robot(view: RobotView) -> Lifted:
    """What a robot file says of its actuators.

    Of a joint without actuators in a file that has none, the gains are unknown and the command is a position:
    they are the controller's. A torque motor is a drive whose command is the effort.

    Args:
        view: The robot, read; of a file that MuJoCo refuses, from its text.
    """
    document = _document(view)
    held = held_joints(view, document)
    actuators: list[JointActuator] = []
    alone: list[LeftAlone] = []
    notes: dict[str, tuple[str, ...]] = {}
    pose = _first_key(document)
    for joint in view.joints:
        if joint.kind not in (JointKind.HINGE, JointKind.SLIDE):
            continue
        left = unsaid(view, joint, held)
        if left is not None:
            alone.append(left)
            continue
        found = _Joint(view, joint, pose).actuator()
        actuators.append(found)
        said = notes_of(joint, actuators_of(view, joint.name), found.command)
        if said:
            notes[joint.name] = said
    if view.refusal is not None:
        notes[""] = (f"read from the text alone: {view.refusal}",)
    return Lifted(
        ActuatorSet(
            robot=view.name or os.path.splitext(os.path.basename(view.path))[0],
            joints=tuple(actuators),
            unmanaged=tuple(item.joint for item in alone),
            physics_dt=_physics_dt(view, document),
            decimation=None,
            delta_action=None,
            accept=(),
            sources=(),
            spec_sha256="",
            diagnostics=view.diagnostics,
        ),
        tuple(alone),
        notes,
    )


def _document(view: RobotView) -> XmlDocument | None:
    """The MJCF, parsed; None for another format."""
    if view.format is not ModelFormat.MJCF or not view.files:
        return None
    from actspec.robot.xml import parse_document

    return parse_document(view.files)


def _first_key(document: XmlDocument | None) -> Span | None:
    """Where the pose of the first keyframe is written; None without one."""
    for section in () if document is None else document.sections("keyframe"):
        for key in section.children:
            if key.tag == "key":
                return None if document is None else document.span(key)
    return None


def _physics_dt(view: RobotView, document: XmlDocument | None) -> Quantity:
    if view.timestep is None:
        return unknown("s", "the format has no time step")
    options = () if document is None else document.sections("option")
    stating = [option for option in options if option.get("timestep") is not None]
    if document is None or not stating:
        return assumed(view.timestep, "s", "MuJoCo's default, the file does not say")
    return stated(view.timestep, "s", document.span(stating[-1]))


class _Joint:
    """One joint of a robot file that a spec can describe."""

    def __init__(self, view: RobotView, joint: JointView, pose: Span | None) -> None:
        self.view = view
        self.joint = joint
        self.own = actuators_of(view, joint.name)
        self.first = self.own[0] if self.own else None
        self.mjcf = view.format is ModelFormat.MJCF
        self.pose = pose
        self.units = Units(joint.kind)

    def actuator(self) -> JointActuator:
        joint, units, first = self.joint, self.units, self.first
        command = self._command()
        inertia = (self.view.joint_inertia or {}).get(joint.name)
        held, free = (None, None) if inertia is None else (inertia.held, inertia.free)
        if inertia is None:
            held, free = self._inertia()
        line = None if first is None else first.line
        return JointActuator(
            joint=joint.name,
            kind=joint.kind,
            group="" if first is None else first.name,
            pattern=re.escape(joint.name),
            motor=None,
            level=Level.IDEAL_PD if line is None else Level.DC_MOTOR,
            command=command,
            kp=self._stiffness() if command is Command.POSITION else None,
            kd=None if command is Command.EFFORT else self._velocity_gain(),
            effort_limit=effort_limit(joint, self.own, units.torque),
            velocity_limit=self._velocity_limit(),
            stall_torque=None if line is None else self._of_line(line[0], units.torque),
            no_load_speed=None if line is None else self._of_line(line[1], units.speed),
            curve=None,
            peak_torque=unknown(units.torque),
            continuous_torque=unknown(units.torque),
            armature=self._armature(),
            reflected_inertia=unknown(units.inertia),
            friction_coulomb=self._passive("frictionloss", joint.frictionloss, units.torque),
            friction_static=None,
            friction_viscous=self._viscous(),
            stribeck_velocity=None,
            filter_cutoff=self._filter(),
            command_range=command_range(joint, self.own, command, units),
            delay=self._delay(),
            encoder_bias=self._bias(command),
            action_scale=None,
            default_position=self._default_position(),
            position_range=None if "range" in joint.unknown else joint.range,
            network=None,
            randomize=(),
            inertia_held=held,
            inertia_free=free,
            span=joint.span if first is None else first.span,
        )

    def _command(self) -> Command:
        """A dcmotor without any gain is driven by a torque, as its input says."""
        if not self.own or any(a.kp or "kp" in a.unknown for a in self.own):
            return Command.POSITION
        if all(a.control == "motor" or (a.control == "dcmotor" and not a.kd) for a in self.own):
            return Command.EFFORT
        return Command.VELOCITY

    def _inertia(self) -> tuple[InertiaRange | None, InertiaRange | None]:
        joint, matrices = self.joint, self.view.inertia
        if matrices is None or joint.dof < 0:
            return None, None
        armature = {joint.dof: joint.armature + self._at_actuators("armature")}
        return matrices.held(armature)[joint.dof], matrices.free(armature)[joint.dof]

    def _at_actuators(self, name: str) -> float:
        """Actuator-level armature or linear damping, at the joint."""
        values = (a.armature if name == "armature" else a.damping[0] for a in self.own)
        return sum(a.gear**2 * value for a, value in zip(self.own, values, strict=True))

    def _exact(self) -> bool:
        """Whether the file's gains are those at the joint."""
        return len(self.own) == 1 and self.own[0].gear == 1.0 and self.own[0].line is None

    def _gain(self, name: str, attributes: frozenset[str], unit: str) -> Quantity:
        """The sum of a gain over the actuators."""
        stating = next((a for a in self.own if a.stated & attributes), self.own[0])
        attribute = next(iter(sorted(stating.stated & attributes)), "")
        span = stating.places.get(attribute, stating.span)
        if any(name in a.unknown for a in self.own):
            return unknown(unit, _TEXT, span)
        value = sum(getattr(a, name) for a in self.own)
        if self._exact():
            return stated(value, unit, span)
        formula = " + ".join(
            f"{getattr(a, name) / a.gear**2:g} x {a.gear:g}^2 (gear)" for a in self.own if getattr(a, name)
        )
        return stated(tidy(value), unit, span, formula=formula or None)

    def _stiffness(self) -> Quantity:
        if not self.own:
            return unknown(self.units.stiffness, "the file has no actuators: gains are the controller's")
        return self._gain("kp", frozenset({"kp", "biasprm", "controller"}), self.units.stiffness)

    def _velocity_gain(self) -> Quantity:
        unit = self.units.velocity_gain
        if not self.own:
            return unknown(unit, "the file has no actuators: gains are the controller's")
        found = self._gain("kd", _KD_STATED, unit)
        if found.value == 0.0 and not any(a.stated & _KD_STATED for a in self.own):
            return assumed(0.0, unit, "the file's servo has no kv: MuJoCo takes 0")
        return found

    def _velocity_limit(self) -> Quantity:
        value, unit = self.joint.velocity_limit, self.units.speed
        if value is None:
            return unknown(unit)
        span = self.joint.places.get("velocity", self.joint.span)
        if value == 0.0:
            return unknown(unit, f"the file says 0 {unit}: nobody's number", span)
        return stated(value, unit, span)

    def _of_line(self, value: float, unit: str) -> Quantity:
        assert self.first is not None
        span = self.first.places.get("nominal", self.first.span)
        return stated(tidy(value), unit, span, formula="from resistance, constant and voltage of the dcmotor")

    def _passive(self, field: str, value: float, unit: str, at_actuators: float = 0.0) -> Quantity:
        """What acts at the joint itself, with the actuators' share."""
        joint = self.joint
        span = joint.places.get(field, joint.span)
        if field in joint.unknown or any(field in a.unknown for a in self.own):
            return unknown(unit, _TEXT, span)
        if at_actuators:
            assert self.first is not None
            formula = f"{value:g} (joint) + {at_actuators:g} (actuator)"
            return stated(tidy(value + at_actuators), unit, self.first.span, formula=formula)
        if value or field in joint.stated:
            return stated(value, unit, span)
        return assumed(0.0, unit, f"default of {self.view.format.value.upper()}, the file does not say")

    def _armature(self) -> Quantity:
        if not self.mjcf:
            return unknown(self.units.inertia, "a URDF cannot say it")
        return self._passive(
            "armature", self.joint.armature, self.units.inertia, self._at_actuators("armature")
        )

    def _viscous(self) -> Quantity:
        at_actuators = self._at_actuators("damping")
        return self._passive("damping", self.joint.damping, self.units.velocity_gain, at_actuators)

    def _filter(self) -> Quantity | None:
        first = self.first
        if first is None or (first.time_constant <= 0.0 and "time_constant" not in first.unknown):
            return None
        span = first.places.get("timeconst", first.places.get("dynprm", first.span))
        if "time_constant" in first.unknown:
            return unknown("Hz", _TEXT, span)
        cutoff = tidy(1.0 / (2.0 * math.pi * first.time_constant))
        return stated(cutoff, "Hz", span, formula=f"1 / (2 pi {first.time_constant:g} s)")

    def _delay(self) -> Delay | None:
        first = self.first
        if first is None or (first.delay <= 0.0 and "delay" not in first.unknown):
            return None
        span = first.places.get("delay", first.span)
        if "delay" in first.unknown:
            return Delay(unknown("s", _TEXT, span), 0.0, 0.0, "episode")
        return Delay(stated(first.delay, "s", span), first.delay, first.delay, "episode")

    def _bias(self, command: Command) -> Quantity:
        first, unit = self.first, self.units.position
        if first is None or command is not Command.POSITION or not first.offset:
            return assumed(0.0, unit, "no bias is stated")
        span = first.places.get("biasprm", first.span)
        if {"offset", "kp"} & first.unknown:
            return unknown(unit, _TEXT, span)
        kp = first.kp / first.gear
        return stated(tidy(-first.offset / kp), unit, span, formula=f"{-first.offset:g} / {kp:g} (stiffness)")

    def _default_position(self) -> Quantity:
        joint, unit = self.joint, self.units.position
        if "reference_position" in joint.unknown:
            return unknown(unit, _TEXT, self.pose)
        if self.view.keyframes and self.pose is not None:
            return stated(joint.reference_position, unit, self.pose, note="the first keyframe")
        return assumed(joint.reference_position, unit, "the file has no pose: its zero")
