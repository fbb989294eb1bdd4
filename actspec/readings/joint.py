"""What a robot file says of each joint: its passive part, its drives, what clamps each, and which are on.

The one reading of a joint: the ledger's rows, the numbers of origin `model` that a spec falls back on, and what
`import` makes of a file are views of it. Figures are at the joint, gear included. A number that the file does not
tell is unknown; a limit that it does not have is infinite.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

from actspec.diagnostics import Span
from actspec.fields import Units, unit_of, units_of
from actspec.ir import Quantity, assumed, stated, tidy, unknown
from actspec.readings.drive import NOT_IN_FILE, DriveReading, largest, least
from actspec.robot.view import ActuatorView, JointInertia, JointView, ModelFormat, RobotView

SERVOS = ("position", "velocity", "dcmotor", "pid")
"""Controls whose kp and kd are a drive's gains."""

IMPLICIT = ("implicit", "implicitfast", "discrete")
"""Integrators that take the derivative of a drive's velocity gain. Source: MuJoCo 3.13 and 4.0, measured."""

_OF_JOINT = {
    "joint_damping": "damping",
    "armature": "armature",
    "frictionloss": "frictionloss",
    "effort_limit": "effort",
    "velocity_limit": "velocity",
    "position_range": "range",
}
"""Figure to the name in `JointView.stated`."""


@dataclass(frozen=True, slots=True)
class JointReading:
    """One hinge or slide of a robot file.

    Attributes:
        joint: The joint, as the file has it.
        format: Of the file.
        units: Of the joint.
        drives: The actuators that drive it directly, in the file's order.
        acting: Those that give a force.
        movers: What else gives it a force, over a tendon, a site or a crank: nobody knows how much.
        inertia: Over the poses, armature included; None: unknown.
        integrator: MuJoCo's name; "" when the format has none.
        eulerdamp: Whether the Euler integrator takes passive damping implicitly.
        timestep: The file's step [s]; None when the format has none.
    """

    joint: JointView
    format: ModelFormat
    units: Units
    drives: tuple[DriveReading, ...]
    acting: tuple[DriveReading, ...]
    movers: tuple[ActuatorView, ...]
    inertia: JointInertia | None
    integrator: str
    eulerdamp: bool
    timestep: float | None

    @property
    def servos(self) -> tuple[DriveReading, ...]:
        """The acting drives whose gains close a loop in the file."""
        return tuple(drive for drive in self.acting if drive.view.control in SERVOS)

    @property
    def is_moved(self) -> bool:
        """Whether something beside its drives gives it a force."""
        return any(not mover.disabled for mover in self.movers)

    # The passive part

    @property
    def joint_damping(self) -> Quantity:
        """Viscous friction at the joint itself."""
        return self._passive("damping", self.joint.damping, self.units.velocity_gain)

    @property
    def frictionloss(self) -> Quantity:
        """Dry friction."""
        return self._passive("frictionloss", self.joint.frictionloss, self.units.torque)

    @property
    def velocity_limit(self) -> Quantity:
        """The joint's speed limit (URDF); unknown with a place where the file states that there is none."""
        value, unit = self.joint.velocity_limit, self.units.speed
        if value is None:
            # As the effort's: a stand-in for none is told with its line.
            written = "velocity" in self.joint.stated
            return (
                unknown(unit, "the file has no limit", self.place("velocity")) if written else unknown(unit)
            )
        return stated(value, unit, self.place("velocity"))

    @property
    def joint_bound(self) -> Quantity:
        """Largest torque that the joint itself lets its actuators apply; infinite without a limit."""
        joint, unit, place = self.joint, self.units.torque, self.place("effort")
        if "effort_range" in joint.unknown:
            return unknown(unit, NOT_IN_FILE, place)
        if joint.effort_range is None:
            return assumed(math.inf, unit, "the file has no limit")
        return stated(largest(joint.effort_range), unit, place)

    def _passive(self, name: str, value: float, unit: str) -> Quantity:
        place = self.place(name)
        if name in self.joint.unknown:
            return unknown(unit, NOT_IN_FILE, place)
        if value or name in self.joint.stated:
            return stated(value, unit, place)
        return assumed(0.0, unit, f"{self.format.value.upper()} default, the file does not say")

    # With all drives

    @property
    def kp(self) -> Quantity:
        """Stiffness of all acting drives together."""
        return self._together("kp", self.units.stiffness, self.acting)

    @property
    def kd(self) -> Quantity:
        """Velocity gain of all acting drives together."""
        return self._together("kd", self.units.velocity_gain, self.acting)

    def servo_gain(self, name: str) -> Quantity:
        """`kp` or `kd` of the servos alone."""
        return self._together(name, unit_of(name, self.joint.kind), self.servos)

    def _together(self, name: str, unit: str, drives: Sequence[DriveReading]) -> Quantity:
        """A figure of several drives; unknown where one is, and without end where one has none."""
        parts: list[Quantity] = [getattr(drive, name) for drive in drives]
        if len(parts) == 1:
            return parts[0]
        lead = next((p for end in (None, math.inf) for p in parts if p.value == end), None)
        if lead is not None:
            return lead
        said = [part for part in parts if part.span is not None]
        if len(said) <= 1:
            return (*said, *parts, assumed(0.0, unit, "the file has no drive"))[0]
        known = [part for part in said if part.value]
        formula = " + ".join(part.formula or f"{part.value:g}" for part in known) if len(known) > 1 else None
        first = known[0] if known else said[0]
        assert first.span is not None
        return stated(
            tidy(sum(part.require() for part in parts)), unit, first.span, formula=formula or first.formula
        )

    @property
    def actuator_damping(self) -> float | None:
        """Linear damping of the actuators, also of those that are off; None: unknown."""
        return total([drive.damping for drive in self.drives])

    @property
    def friction_viscous(self) -> Quantity:
        """Passive viscous friction: the joint's and its actuators'."""
        return self._with_actuators(self.joint_damping, self.actuator_damping, "damping")

    @property
    def armature(self) -> Quantity:
        """Armature: the joint's and its actuators'. A URDF cannot say it."""
        unit = self.units.inertia
        if self.format is not ModelFormat.MJCF:
            return unknown(unit, f"a {self.format.value.upper()} cannot say it")
        own = self._passive("armature", self.joint.armature, unit)
        return self._with_actuators(own, total([drive.armature for drive in self.drives]), "armature")

    def _with_actuators(self, own: Quantity, at_actuators: float | None, attribute: str) -> Quantity:
        if own.value is None or at_actuators == 0.0:
            return own
        place = next((d.place(attribute) for d in self.drives if attribute in d.view.stated), None)
        place = place or (self.drives[0].view.span if self.drives else self.joint.span)
        if at_actuators is None:
            return unknown(own.unit, NOT_IN_FILE, place)
        formula = f"{own.value:g} (joint) + {at_actuators:g} (actuator)"
        return stated(tidy(own.value + at_actuators), own.unit, place, formula=formula)

    @property
    def effort_limit(self) -> Quantity:
        """Largest torque that acts on the joint; infinite without a limit.

        Unknown also where something beside its drives moves it, unless the joint itself limits that too.
        """
        own = self.joint_bound
        if not self.is_moved or own.value is None:
            return self.drive_limit
        return own if math.isfinite(own.value) else unknown(own.unit, "something else moves the joint")

    @property
    def drive_limit(self) -> Quantity:
        """Largest torque of its drives: the least of the joint's own limit and of all acting drives together.

        Of a range whose ends differ the larger magnitude counts. Infinite: there is no limit. A URDF's effort is as
        it is written.
        """
        joint, unit = self.joint, self.units.torque
        if self.format is ModelFormat.URDF:
            if "effort" not in joint.stated:
                return unknown(unit, "the file has no limit")
            end = math.inf if joint.effort_range is None else joint.effort_range[1]
            return stated(end, unit, self.place("effort"))
        return self._with_drives("bound")

    @property
    def force_bound(self) -> Quantity:
        """Largest torque that force ranges allow, the joint's and the drives', clamps of controls left out."""
        return self._with_drives("force_bound")

    def _with_drives(self, name: str) -> Quantity:
        """The least of the joint's own limit and of a bound of all acting drives together."""
        own = self.joint_bound
        if not self.acting or own.value is None:
            return own
        return least((own, self._together(name, own.unit, self.acting)))

    @property
    def line(self) -> tuple[float | None, float | None]:
        """Torque at standstill, and speed without torque, of all acting drives together; None: one has no line."""
        lines = [drive.view.line for drive in self.acting]
        known = [line for line in lines if line is not None]
        if not known or len(known) < len(lines):
            return None, None
        # Torques add up at each speed, so the sum of lines is a line.
        stall = sum(torque for torque, _ in known)
        slope = sum(torque / speed if speed else math.inf for torque, speed in known)
        return known[0] if len(known) == 1 else (stall, stall / slope if slope else math.inf)

    @property
    def total_damping(self) -> float | None:
        """Gains and passive damping together; None: unknown."""
        moving = [mover for mover in self.movers if not mover.disabled]
        return total([self.passive_damping, self.kd.value, *(_zero(mover, "kd") for mover in moving)])

    @property
    def passive_damping(self) -> float | None:
        """Damping of the joint, its actuators and what else moves it; None: unknown."""
        others = (_zero(mover, "damping") for mover in self.movers)
        return total([self.joint_damping.value, self.actuator_damping, *others])

    @property
    def total_stiffness(self) -> float | None:
        """Stiffness of everything that drives the joint, and of its own spring; None: unknown."""
        moving = [mover for mover in self.movers if not mover.disabled]
        return total([self.kp.value, self.joint.spring, *(_zero(mover, "kp") for mover in moving)])

    @property
    def total_armature(self) -> float | None:
        """Armature with that of what else moves the joint; None: unknown."""
        return total([self.armature.value, *(_zero(mover, "armature") for mover in self.movers)])

    # Dynamics

    @property
    def is_passive_implicit(self) -> bool | None:
        """Whether the engine integrates passive damping implicitly; None where no integrator is known.

        Source: MuJoCo 3.2 to 4.0, one step, measured: Euler does with eulerdamp, RK4 does not.
        """
        if not self.integrator:
            return None
        return self.integrator in IMPLICIT or (self.integrator == "Euler" and self.eulerdamp)

    def explicit_damping(self, damping: float | None) -> float | None:
        """The part of `total_damping` that the integrator takes explicitly; None: unknown, or no integrator."""
        if not self.integrator:
            return None
        if self.integrator in IMPLICIT:
            return 0.0
        return self.kd.value if damping is not None and self.is_passive_implicit else damping

    # Places

    @property
    def places(self) -> dict[str, Span]:
        """Figure that the joint itself states to where."""
        said = _said_of_joint(self.joint.stated)
        return {figure: self.joint.places.get(name, self.joint.span) for figure, name in said}

    def place(self, name: str) -> Span:
        """Where the joint states something, by its name in `JointView.stated`; else the joint."""
        return self.joint.places.get(name, self.joint.span)


def read_joints(
    robot: RobotView, inertias: Mapping[str, JointInertia] | None = None
) -> dict[str, JointReading]:
    """The reading of every named hinge and slide of a robot, in its order.

    Args:
        robot: The robot.
        inertias: Of `RobotView.inertias`, which takes long; None: as far as the robot carries them.
    """
    driving: dict[str, list[ActuatorView]] = {}
    for actuator in robot.actuators:
        if actuator.is_direct:
            driving.setdefault(actuator.target, []).append(actuator)
    loose = robot.loose_actuators
    inertias = inertias or robot.joint_inertia or {}
    return {
        joint.name: _reading(robot, joint, driving.get(joint.name, []), loose, inertias.get(joint.name))
        for joint in robot.scalar_joints
    }


def read_joint(robot: RobotView, name: str) -> JointReading:
    """The reading of one named hinge or slide.

    Raises: KeyError: the robot has no such joint.
    """
    joint = robot.joint(name)
    if joint is None:
        raise KeyError(name)
    own = [a for a in robot.actuators if a.is_direct and a.target == name]
    return _reading(robot, joint, own, robot.loose_actuators, (robot.joint_inertia or {}).get(name))


def _reading(
    robot: RobotView,
    joint: JointView,
    own: Iterable[ActuatorView],
    loose: Iterable[ActuatorView],
    inertia: JointInertia | None,
) -> JointReading:
    units = units_of(joint.kind)
    drives = tuple(DriveReading(actuator, joint, units) for actuator in own)
    return JointReading(
        joint,
        robot.format,
        units,
        drives,
        tuple(drive for drive in drives if drive.is_on),
        tuple(a for a in loose if a.moves is None or joint.name in a.moves),
        inertia,
        robot.integrator,
        robot.eulerdamp,
        robot.timestep,
    )


def total(values: Sequence[float | None]) -> float | None:
    """The sum; None if a part is unknown."""
    known = [value for value in values if value is not None]
    return sum(known) if len(known) == len(values) else None


def _zero(actuator: ActuatorView, name: str) -> float | None:
    """0 where a field of an actuator is known to be 0, None otherwise."""
    value = getattr(actuator, name)
    none = not (any(value) if isinstance(value, tuple) else value)
    return 0.0 if none and name not in actuator.unknown else None


@lru_cache(maxsize=256)
def _said_of_joint(stated: frozenset[str]) -> tuple[tuple[str, str], ...]:
    return tuple((figure, name) for figure, name in _OF_JOINT.items() if name in stated)
