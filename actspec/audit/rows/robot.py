"""Rows of the ledger from robot files, as the engine of the file reads them.

A joint is one row for each actuator that drives it directly, a bare one is one row of control `none`.
What drives a tendon, a site, a body, a ball or a joint without a name has a row without a joint, without
figures at a joint, after all others. How much of it reaches a joint depends on the pose: limit, total damping and
what follows from them are unknown at a joint that it moves.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from actspec.audit.ledger import LedgerRow
from actspec.audit.rows.spec import rows_of_spec
from actspec.audit.rows.stated import said_of_actuator, said_of_joint
from actspec.diagnostics import Span
from actspec.readings.artifact import Artifact
from actspec.readings.joint import SCALAR, armature_of, inertias_of
from actspec.robot.view import ActuatorView, JointInertia, JointView, ModelFormat, RobotView

__all__ = ["rows_of_robot", "rows_of_spec"]

_CONTROLS = {name: name for name in ("position", "velocity", "motor", "dcmotor", "pid")}


_IMPLICIT = ("implicit", "implicitfast", "discrete")
"""Integrators that take the derivative of a drive's velocity gain. Source: MuJoCo 3.13 and 4.0, measured."""


def rows_of_robot(artifact: Artifact, index: int) -> tuple[LedgerRow, ...]:
    """Rows of an MJCF or URDF.

    A limit is the least of three clamps: the sum over the joint's actuators of |gear| * forcerange, or of
    |gear| * (gain * control range + offset) where the torque is the control's alone, and the joint's own
    `actuatorfrcrange` or effort; of a range whose ends differ the larger magnitude counts. A dcmotor's
    voltage is not among them: it is `stall_torque` and `no_load_speed`.

    A URDF has no actuator and no armature; an effort or velocity of 0 stays 0. Damping and friction that
    a URDF does not state are 0, as in every importer.

    An actuator that the file switches off has a row of control `other` without gains; only its damping and
    armature are in the totals.

    `default_position` is the first keyframe's. The command range of a servo is in joint position or speed,
    that of a motor in torque at the joint.

    Args:
        artifact: Of kind MJCF or URDF, with its robot.
        index: Its place in `Case.artifacts`.
    """
    robot = artifact.robot
    assert robot is not None
    driving: dict[str, list[ActuatorView]] = {}
    loose = []
    scalar = {joint.name for joint in robot.joints if joint.kind in SCALAR}
    for actuator in robot.actuators:
        if actuator.transmission in ("joint", "jointinparent") and actuator.target in scalar:
            driving.setdefault(actuator.target, []).append(actuator)
        else:
            loose.append(actuator)
    inertias = inertias_of(robot, driving)
    found: list[LedgerRow] = []
    for joint in robot.joints:
        if joint.kind in SCALAR:
            drives = driving.get(joint.name, [])
            acting = [actuator for actuator in drives if not actuator.disabled]
            moving = [
                actuator for actuator in loose if actuator.moves is None or joint.name in actuator.moves
            ]
            inertia = inertias.get(joint.name)
            found += _Joint(artifact.path, index, robot, joint, drives, acting, moving, inertia).rows()
    found.extend(_loose(artifact.path, index, actuator) for actuator in loose)
    return tuple(found)


@dataclass(frozen=True, slots=True)
class _Joint:
    """One joint with everything that its rows are made from."""

    file: str
    index: int
    robot: RobotView
    joint: JointView
    drives: list[ActuatorView]
    acting: list[ActuatorView]
    """The drives that give a force."""
    moving: list[ActuatorView]
    """What else gives it a force, nobody knows how much."""
    inertia: JointInertia | None

    def rows(self) -> list[LedgerRow]:
        """One for each actuator, or the bare joint's."""
        mjcf = self.robot.format is ModelFormat.MJCF
        joint = self.joint
        unknown = joint.unknown
        damping = None if "damping" in unknown else joint.damping
        moving = [actuator for actuator in self.moving if not actuator.disabled]
        # Of what else moves the joint only zeros are known.
        passive = _sum(
            [
                damping,
                *(self._actuator_damping(a) for a in self.drives),
                *(_zero(a, "damping") for a in self.moving),
            ]
        )
        total = _sum([passive, *(_known(a, "kd") for a in self.acting), *(_zero(a, "kd") for a in moving)])
        kp = _sum([*(_known(a, "kp") for a in self.acting), *(_zero(a, "kp") for a in moving)])
        armature = None
        if mjcf and "armature" not in unknown and not any("armature" in a.unknown for a in self.drives):
            armature = _sum([armature_of(joint, self.drives), *(_zero(a, "armature") for a in self.moving)])
        inertia = self.inertia
        reference = inertia.held.reference if inertia is not None else None
        resonant = kp is not None and kp > 0.0 and reference is not None and reference > 0.0
        frequency = ratio = None
        if resonant:
            assert kp is not None and reference is not None
            frequency = math.sqrt(kp / reference)
            ratio = None if total is None else total / (2.0 * math.sqrt(kp * reference))
        said = said_of_joint(joint.stated)
        places = {field: joint.places.get(name, joint.span) for field, name in said}
        stated = frozenset(places)
        implicit = self._passive_implicit()
        shared: dict[str, Any] = {
            "file": self.file,
            "artifact": self.index,
            "span": joint.span,
            "joint": joint.name,
            "actuator": "",
            "control": "none",
            "kind": joint.kind,
            "joint_damping": damping,
            "joint_damping_clamped": False if mjcf else None,
            "joint_damping_implicit": implicit,
            "actuator_damping": 0.0 if mjcf else None,
            "actuator_damping_clamped": False if mjcf else None,
            "actuator_damping_implicit": implicit,
            "total_damping": total,
            "frictionloss": None if "frictionloss" in unknown else joint.frictionloss,
            "effort_limit": self._effort_limit(),
            "velocity_limit": joint.velocity_limit,
            "armature": armature,
            "inertia_min": inertia.held.low if inertia is not None else None,
            "inertia_max": inertia.held.high if inertia is not None else None,
            "inertia_free_min": inertia.free.low if inertia is not None else None,
            "natural_frequency": frequency,
            "damping_ratio": ratio,
            "stability": self._stability(passive, total),
            "position_range": None if "range" in unknown else joint.range,
            "default_position": joint.reference_position
            if self.robot.keyframes and "reference_position" not in unknown
            else None,
            "places": {},
            "stated": stated,
        }
        if not self.drives:
            return [LedgerRow(**{**shared, "places": _apart(places, joint.span)})]
        return [LedgerRow(**{**shared, **self._of_actuator(a, places)}) for a in self.drives]

    def _of_actuator(self, actuator: ActuatorView, places: Mapping[str, Span]) -> dict[str, Any]:
        """The fields in which the row of an actuator differs from that of the bare joint."""
        places = {**places}
        stated = set(places)
        for field, said in said_of_actuator(actuator.stated, self._is_torque(actuator)):
            # The joint's own attribute keeps its place: two places state such a field.
            if field not in stated:
                places[field] = actuator.places.get(said, actuator.span)
            stated.add(field)
        same = {
            "span": actuator.span,
            "actuator": actuator.name,
            "actuator_damping": self._actuator_damping(actuator),
            "places": _apart(places, actuator.span),
            "stated": frozenset(stated),
        }
        if actuator.disabled:
            return {**same, "control": "other", "kp": 0.0, "kd": 0.0, "back_emf": 0.0}
        limit = actuator.force_range is not None or self.joint.effort_range is not None
        line = actuator.line or (None, None)
        integrator = self.robot.integrator
        unknown = actuator.unknown
        return {
            **same,
            "control": _CONTROLS.get(actuator.control, "other"),
            "kp": _known(actuator, "kp"),
            "kd": _known(actuator, "kd"),
            "kd_clamped": None if "force_range" in unknown or "effort_range" in self.joint.unknown else limit,
            "kd_implicit": integrator in _IMPLICIT if integrator else None,
            "back_emf": _known(actuator, "back_emf"),
            "stall_torque": line[0],
            "no_load_speed": line[1],
            "delay": _known(actuator, "delay"),
            "command_range": None if "control_range" in unknown else _command_range(actuator),
        }

    def _actuator_damping(self, actuator: ActuatorView) -> float | None:
        if actuator.unknown and {"damping", "gear"} & actuator.unknown:
            return None
        return actuator.gear**2 * actuator.damping[0]

    def _is_torque(self, actuator: ActuatorView) -> bool:
        """Whether the control alone decides on the torque."""
        return actuator.control == "motor" and actuator.kd == 0.0 and not {"kd", "gain"} & actuator.unknown

    def _effort_limit(self) -> float | None:
        joint = self.joint
        if self.robot.format is ModelFormat.URDF:
            if "effort" not in joint.stated:
                return None
            return math.inf if joint.effort_range is None else joint.effort_range[1]
        if "effort_range" in joint.unknown:
            return None
        limits = [] if joint.effort_range is None else [_largest(joint.effort_range)]
        if any(not actuator.disabled for actuator in self.moving):
            return min(limits, default=None)
        if self.acting:
            bounds = [self._bound(actuator) for actuator in self.acting]
            total = _sum(bounds)
            if total is None:
                return None
            limits.append(total)
        return min(limits, default=math.inf)

    def _bound(self, actuator: ActuatorView) -> float | None:
        """Largest torque that one actuator can apply to the joint; inf: any."""
        if actuator.unknown and {"force_range", "gear"} & actuator.unknown:
            return None
        gear = abs(actuator.gear)
        if (
            actuator.force_range is None
            and actuator.control in ("plugin", "other")
            and "kp" in actuator.unknown
        ):
            # A plugin or a muscle has bounds of its own.
            return None
        bounds = [] if actuator.force_range is None else [gear * _largest(actuator.force_range)]
        if self._is_torque(actuator):
            if "control_range" in actuator.unknown:
                return None
            if actuator.control_range is not None:
                ends = (actuator.gain * end + actuator.offset for end in actuator.control_range)
                bounds.append(gear * max(abs(end) for end in ends))
        return min(bounds, default=math.inf)

    def _passive_implicit(self) -> bool | None:
        """Whether the engine integrates passive damping implicitly; None where no integrator is known.

        Source: MuJoCo 3.2 to 4.0, one step, measured: Euler does with eulerdamp, RK4 does not.
        """
        integrator = self.robot.integrator
        if not integrator:
            return None
        return integrator in _IMPLICIT or (integrator == "Euler" and self.robot.eulerdamp)

    def _stability(self, passive: float | None, total: float | None) -> float | None:
        """h * Kd / least free inertia, over the damping that the integrator takes explicitly."""
        step, integrator = self.robot.timestep, self.robot.integrator
        if step is None or not integrator or self.inertia is None or self.inertia.free.low <= 0.0:
            return None
        explicit = total
        if integrator in _IMPLICIT:
            explicit = 0.0
        elif integrator == "Euler" and self.robot.eulerdamp:
            explicit = None if total is None or passive is None else total - passive
            # The difference of two sums need not be 0 to the last digit.
            if explicit is not None:
                explicit = _sum([_known(a, "kd") for a in self.acting])
        return None if explicit is None else step * explicit / self.inertia.free.low


def _apart(places: Mapping[str, Span], row: Span) -> dict[str, Span]:
    """Places that are not the row's own."""
    # Most are on the line of the row, which is then the same object, or on another line.
    return {
        name: place
        for name, place in places.items()
        if place is not row and (place.line != row.line or place != row)
    }


def _loose(file: str, index: int, actuator: ActuatorView) -> LedgerRow:
    """The row of an actuator whose joint has no name, or that drives something else."""
    return LedgerRow(
        file=file,
        artifact=index,
        span=actuator.span,
        joint="",
        actuator=actuator.name,
        control=_CONTROLS.get(actuator.control, "other"),
        drives=f"{actuator.transmission} {actuator.target}".rstrip(),
        delay=_known(actuator, "delay"),
    )


def _known(actuator: ActuatorView, name: str) -> float | None:
    """A field of an actuator; None where the text does not tell."""
    value: float = getattr(actuator, name)
    return None if name in actuator.unknown else value


def _zero(actuator: ActuatorView, name: str) -> float | None:
    """0 where a field of an actuator is known to be 0, None otherwise."""
    value = getattr(actuator, name)
    none = not (any(value) if isinstance(value, tuple) else value)
    return 0.0 if none and name not in actuator.unknown else None


def _sum(values: list[float | None]) -> float | None:
    """The sum; None if a part is unknown."""
    total = 0.0
    for value in values:
        if value is None:
            return None
        total += value
    return total


def _largest(ends: tuple[float, float]) -> float:
    return max(abs(end) for end in ends)


def _command_range(actuator: ActuatorView) -> tuple[float, float] | None:
    """Clamp of the command at the joint."""
    if actuator.control_range is None or not actuator.gear or "gear" in actuator.unknown:
        return None
    if actuator.control == "motor":
        if "gain" in actuator.unknown:
            return None
        factor = actuator.gear * actuator.gain
    else:
        factor = 1.0 / actuator.gear
    low, high = sorted(factor * end for end in actuator.control_range)
    return low, high
