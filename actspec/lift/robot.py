"""An MJCF or URDF as an ActuatorSet.

A joint is only taken if a compile of it leaves its dynamics as they are: what the law has no word for
(muscles, integrators, several clamps on one joint) is left alone with the reason.
"""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterator
from dataclasses import replace

from actspec.diagnostics import listed
from actspec.ir import (
    ActuatorSet,
    Command,
    Delay,
    InertiaRange,
    JointActuator,
    Level,
    Quantity,
    assumed,
    stated,
    tidy,
    unknown,
)
from actspec.lift.figures import real_limit
from actspec.lift.lifted import LeftAlone, Lifted
from actspec.lift.unsupported import held_joints, unsupported
from actspec.readings.compare import EXACT
from actspec.readings.drive import NOT_IN_FILE, DriveReading, largest
from actspec.readings.joint import JointReading, read_joints
from actspec.robot.view import ModelFormat, RobotView
from actspec.robot.xml_tree import XmlDocument


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
    for reading in read_joints(view).values():
        left = unsupported(view, reading, held)
        if left is not None:
            alone.append(left)
            continue
        found = _Joint(view, reading).actuator()
        actuators.append(found)
        said = tuple(_notes(reading, found.command))
        if said:
            notes[found.joint] = said
    if view.refusal is not None:
        notes[""] = (f"read from the text alone: {view.refusal}",)
    return Lifted(
        ActuatorSet(
            robot=view.name or os.path.splitext(os.path.basename(view.path))[0],
            joints=tuple(actuators),
            unmanaged=tuple(item.joint for item in alone),
            physics_dt=_physics_dt(view, document),
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

    def __init__(self, view: RobotView, reading: JointReading) -> None:
        self.view = view
        self.reading = reading
        self.joint = reading.joint
        self.units = reading.units
        self.own = reading.acting
        self.first = self.own[0] if self.own else None

    def actuator(self) -> JointActuator:
        joint, units, reading = self.joint, self.units, self.reading
        first = None if self.first is None else self.first.view
        command = self._command()
        held, free = self._inertia()
        line = None if first is None else first.line
        return JointActuator(
            joint=joint.name,
            kind=joint.kind,
            group="" if first is None else first.name,
            pattern=re.escape(joint.name),
            level=Level.IDEAL_PD if line is None else Level.DC_MOTOR,
            command=command,
            kp=self._gain("kp", units.stiffness) if command is Command.POSITION else None,
            kd=None if command is Command.EFFORT else self._gain("kd", units.velocity_gain),
            effort_limit=self._effort_limit(),
            velocity_limit=_number(reading.velocity_limit),
            stall_torque=None if line is None else self._of_line(line[0], units.torque),
            no_load_speed=None if line is None else self._of_line(line[1], units.speed),
            peak_torque=unknown(units.torque),
            continuous_torque=unknown(units.torque),
            armature=reading.armature,
            reflected_inertia=unknown(units.inertia),
            friction_coulomb=reading.frictionloss,
            friction_viscous=reading.friction_viscous,
            filter_cutoff=self._filter(),
            command_range=self._command_range(command),
            delay=self._delay(),
            encoder_bias=self._bias(command),
            default_position=self._default_position(),
            position_range=None if "range" in joint.unknown else joint.range,
            inertia_held=held,
            inertia_free=free,
            span=joint.span if first is None else first.span,
        )

    def _command(self) -> Command:
        """A dcmotor without any gain is driven by a torque, as its input says."""
        views = [drive.view for drive in self.own]
        if not views or any(a.kp or "kp" in a.unknown for a in views):
            return Command.POSITION
        if all(a.control == "motor" or (a.control == "dcmotor" and not a.kd) for a in views):
            return Command.EFFORT
        return Command.VELOCITY

    def _inertia(self) -> tuple[InertiaRange | None, InertiaRange | None]:
        joint, matrices, known = self.joint, self.view.inertia, self.reading.inertia
        if known is not None:
            return known.held, known.free
        if matrices is None or joint.dof < 0:
            return None, None
        armature = {joint.dof: self.reading.armature.value or 0.0}
        return matrices.held(armature)[joint.dof], matrices.free(armature)[joint.dof]

    def _gain(self, name: str, unit: str) -> Quantity:
        """The sum of a gain over the drives."""
        if not self.own:
            return unknown(unit, "the file has no actuators: gains are the controller's")
        found: Quantity = getattr(self.reading, name)
        # A dcmotor's gain is made of its other numbers.
        computed = found.value is not None and any(drive.view.line is not None for drive in self.own)
        return replace(found, value=tidy(found.require())) if computed else found

    def _effort_limit(self) -> Quantity:
        """Unknown where nothing limits it."""
        found, unit = self.reading.drive_limit, self.units.torque
        if found.value is None:
            return found
        if not math.isfinite(found.value):
            return unknown(unit, "the file has no limit", found.span)
        return _number(found)

    def _command_range(self, command: Command) -> tuple[Quantity, Quantity] | None:
        """Clamp of the command in joint units; None without one.

        A torque motor's is only one where it is inside the limits of force and not symmetric; else it says nothing,
        or is the effort limit.
        """
        lead = next((drive for drive in self.own if drive.view.control != "velocity"), self.first)
        if lead is None:
            return None
        units = self.units
        unit = {
            Command.POSITION: units.position,
            Command.VELOCITY: units.speed,
            Command.EFFORT: units.torque,
        }[command]
        span = lead.place("ctrlrange", "posrange", "inheritrange", "ctrllimited")
        if "control_range" in lead.view.unknown:
            hidden = unknown(unit, NOT_IN_FILE, span)
            return hidden, hidden
        ends, exact = lead.command_range, lead.view.gear == 1.0
        if command is Command.EFFORT:
            # The input of a dcmotor without gains is a torque too.
            ends, exact = lead.control_torques, exact and lead.view.gain == 1.0
            bound = self.reading.force_bound.value
            if ends is None or (bound is not None and ends[0] <= -bound and ends[1] >= bound):
                return None
            if lead.view.control == "motor" and is_symmetric(ends):
                return None
        if ends is None:
            return None
        low, high = (end if exact else tidy(end) for end in ends)
        return stated(low, unit, span), stated(high, unit, span)

    def _of_line(self, value: float, unit: str) -> Quantity:
        assert self.first is not None
        span = self.first.place("nominal")
        return stated(tidy(value), unit, span, formula="from resistance, constant and voltage of the dcmotor")

    def _filter(self) -> Quantity | None:
        found = None if self.first is None else self.first.filter_cutoff
        if found is None or found.value is None:
            return found
        return replace(found, value=tidy(found.value))

    def _delay(self) -> Delay | None:
        found = None if self.first is None else self.first.delay
        return None if found is None else Delay(found, found.value or 0.0, found.value or 0.0, "episode")

    def _bias(self, command: Command) -> Quantity:
        first, unit = self.first, self.units.position
        if first is None or command is not Command.POSITION or not first.view.offset:
            return assumed(0.0, unit, "no bias is stated")
        span, offset = first.place("biasprm"), first.view.offset
        if {"offset", "kp"} & first.view.unknown:
            return unknown(unit, NOT_IN_FILE, span)
        kp = first.view.kp / first.view.gear
        return stated(tidy(-offset / kp), unit, span, formula=f"{-offset:g} / {kp:g} (stiffness)")

    def _default_position(self) -> Quantity:
        joint, unit = self.joint, self.units.position
        if "reference_position" in joint.unknown:
            return unknown(unit, NOT_IN_FILE, self.view.pose_at)
        if self.view.pose_at is not None:
            return stated(joint.reference_position, unit, self.view.pose_at, note="the first keyframe")
        return assumed(joint.reference_position, unit, "the file has no pose: its zero")


def is_symmetric(ends: tuple[float, float]) -> bool:
    """Whether a range is the same in both directions."""
    return abs(ends[0] + ends[1]) <= EXACT * largest(ends)


def _number(limit: Quantity) -> Quantity:
    """A limit; 0 is nobody's number, and some are no limit."""
    if limit.value != 0.0:
        return real_limit(limit)
    return unknown(limit.unit, f"the file says 0 {limit.unit}, which is a placeholder", limit.span)


def _notes(reading: JointReading, command: Command) -> Iterator[str]:
    """What of a joint that is lifted a spec cannot hold, or says otherwise."""
    joint, units, acting = reading.joint, reading.units, reading.acting
    off = [drive.view.name or str(drive.view.index) for drive in reading.drives if not drive.is_on]
    if off:
        yield f"the file switches {listed(off)} off: a compile leaves only the damping and armature of it"
    if len(acting) > 1:
        yield f"{len(acting)} actuators in the file ({', '.join(d.view.control for d in acting)}) become one"
    factor = _control_factor(acting[0]) if acting else 1.0
    if factor != 1.0:
        effort = command is Command.EFFORT
        where = f"in {units.torque} at the joint" if effort else "in joint units"
        what = "gear and gain" if effort else "gear"
        yield f"the file's {what} of {factor:g} go: after a compile the control is {where}"
    ranges = [drive.view.force_range for drive in acting]
    for span in (*ranges, joint.effort_range):
        if span is not None and not is_symmetric(span):
            yield f"the file's limit is not symmetric ({span[0]:g} to {span[1]:g}), a spec has one number: the larger"
            break
    if any(joint.damping_polynomial) or any(any(drive.view.damping[1:]) for drive in reading.drives):
        yield "the file's polynomial damping stays in the model: a spec cannot express it"
    if joint.springdamper and "stiffness" in joint.unknown:
        yield "the file's springdamper is in force: what it stands for follows a mass that is unknown"
    elif joint.springdamper:
        yield "the file's springdamper is in force: a compile writes the stiffness and damping that it stands for"
    elif joint.spring:
        value = f"{joint.spring:g} {units.stiffness}"
        yield f"the joint's own spring ({value}) stays in the model: a spec cannot express it"
    # A class of `<position>` may be that of a `<motor>`, which makes nothing of its dampratio.
    views = [drive.view for drive in acting]
    ratios = [view for view in views if "dampratio" in view.stated and view.tag in ("position", "general")]
    if any("kd" in view.unknown for view in ratios):
        yield "the file's dampratio is no number: the kd that MuJoCo makes of it follows a mass that is unknown"
    elif any(view.kd for view in ratios):
        yield "the file's dampratio becomes the kd that MuJoCo makes of it"


def _control_factor(drive: DriveReading) -> float:
    """What the control is multiplied with on the way to the joint."""
    return drive.view.gear * (drive.view.gain if drive.view.control == "motor" else 1.0)
