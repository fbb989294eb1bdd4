"""Linkages: motors that move joints together, brought to each joint by the linkage's Jacobian.

With motor speeds w = J q' the joint torques are t = J^T m, and m = J^-T t. Simulators limit every joint by
itself, so the set of torques that the motors can give, skewed by J, becomes a box.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from actspec.diagnostics import Path, listed
from actspec.fields import unit_of_kind
from actspec.ir import AsymmetricCurve, JointKind, Origin, Quantity, tidy, unknown
from actspec.resolution.binding import Bindings
from actspec.resolution.gearbox import Train, gear_train, unfit
from actspec.resolution.motor import Drivetrain, JointMotor, check_motor, joint_motor
from actspec.resolution.stated import Stated
from actspec.spec.document import Breaches
from actspec.spec.gears import Linkage
from actspec.spec.rules.motors import number
from actspec.spec.validate import Spec
from actspec.spec.values import SpecValue
from actspec.units import Kind, format_number, format_quantity

Matrix = tuple[tuple[float, ...], ...]


@dataclass(frozen=True, slots=True)
class Geometry:
    """A linkage's Jacobian at one pose.

    Attributes:
        speeds: J: speed of motor k per speed of joint i is `speeds[k][i]`.
        torques: J^-T: torque of motor k per torque of joint i, with none at the other joints.
        at: Positions of the joints [rad or m]; None: not stated, or at every pose.
    """

    speeds: Matrix
    torques: Matrix
    at: tuple[float, ...] | None


@dataclass(frozen=True, slots=True)
class LinkedMotors:
    """The motors of a linkage and what they are to each of its joints.

    Attributes:
        name: Name of the linkage.
        joints: Its joints.
        motors: Its motors, each at its own output.
        used: The Jacobian that is used; None for a plain factor.
        table: The Jacobian at the poses of a table, the one that is used among them; empty without a table.
        everywhere: Whether the Jacobian is the same at every pose.
        factor: The plain factor; None with a Jacobian.
        together: Whether the limits are those that all joints can use at once.
        text: What formulas call it: its name, pose and source.
    """

    name: str
    joints: tuple[str, ...]
    motors: tuple[JointMotor, ...]
    used: Geometry | None
    table: tuple[Geometry, ...]
    everywhere: bool
    factor: float | None
    together: bool
    text: str

    def at_joint(self, index: int, kind: JointKind, geometry: Geometry | None = None) -> JointMotor:
        """What the motors are to one joint, at a pose of the table or else at that which is used."""
        geometry = geometry or self.used
        unit = {
            quantity: unit_of_kind(quantity, kind) for quantity in (Kind.TORQUE, Kind.SPEED, Kind.INERTIA)
        }

        def bound(quantity: Kind, figures: Sequence[Quantity | None]) -> Quantity | None:
            known = [figure for figure in figures if figure is not None]
            if len(known) < len(figures):
                return None
            found = (
                self._plain(known, quantity)
                if geometry is None
                else self._bound(
                    known, geometry.torques if quantity is Kind.TORQUE else geometry.speeds, index
                )
            )
            return replace(found, unit=unit[quantity])

        def figure(name: str, quantity: Kind) -> Quantity | None:
            return bound(quantity, [getattr(motor, name) for motor in self.motors])

        curves = [motor.curve for motor in self.motors if motor.curve is not None]
        curve = None
        if len(curves) == len(self.motors):
            parts = {
                name: bound(quantity, [getattr(one, name) for one in curves])
                for name, quantity in (
                    ("drive_torque", Kind.TORQUE),
                    ("brake_torque", Kind.TORQUE),
                    ("knee_speed", Kind.SPEED),
                    ("no_load_speed", Kind.SPEED),
                )
            }
            curve = AsymmetricCurve(**{name: part for name, part in parts.items() if part is not None})
        bandwidths = [motor.bandwidth for motor in self.motors]
        known = [one for one in bandwidths if one is not None and one.known]
        return JointMotor(
            name=f"{listed(dict.fromkeys(motor.name for motor in self.motors))} by the linkage {self.name}",
            stall_torque=figure("stall_torque", Kind.TORQUE),
            no_load_speed=figure("no_load_speed", Kind.SPEED),
            curve=curve,
            peak_torque=figure("peak_torque", Kind.TORQUE) or unknown(unit[Kind.TORQUE]),
            continuous_torque=figure("continuous_torque", Kind.TORQUE) or unknown(unit[Kind.TORQUE]),
            reflected_inertia=replace(self._inertia(index, geometry), unit=unit[Kind.INERTIA]),
            arms=tuple(dict.fromkeys(arm for motor in self.motors for arm in motor.arms)),
            # The slowest motor is the last to follow.
            bandwidth=min(known, key=lambda one: one.require()) if len(known) == len(bandwidths) else None,
        )

    def alone(self, limits: Sequence[float], rows: Matrix, index: int) -> float:
        """Largest figure of one joint with 0 at the others, under limits of the motors."""
        return min(
            limit / abs(row[index]) for limit, row in zip(limits, rows, strict=True) if row[index] != 0.0
        )

    def share(self, limits: Sequence[float], rows: Matrix) -> float:
        """Share of `alone` that all joints can have at once."""
        alone = [self.alone(limits, rows, index) for index in range(len(self.joints))]
        needed = (sum(abs(entry) * one for entry, one in zip(row, alone, strict=True)) for row in rows)
        # A need of 0 is one beyond the smallest float.
        return min(limit / need if need else 1.0 for limit, need in zip(limits, needed, strict=True))

    def coupling(self, one: int, other: int) -> float | None:
        """Inertia between two joints, J^T diag(I) J off its diagonal; None where it is unknown or not computed."""
        if self.used is None or not all(motor.reflected_inertia.known for motor in self.motors):
            return None
        return sum(
            motor.reflected_inertia.require() * row[one] * row[other]
            for motor, row in zip(self.motors, self.used.speeds, strict=True)
        )

    def _bound(self, figures: Sequence[Quantity], rows: Matrix, index: int) -> Quantity:
        """The figure of one joint that its weakest motor allows."""
        needed = [
            (figure, motor.name, abs(row[index]))
            for figure, motor, row in zip(figures, self.motors, rows, strict=True)
            if self.together or row[index] != 0.0
        ]
        if not all(figure.known for figure, _, _ in needed):
            return unknown(figures[0].unit)
        weakest, name, entry = min(
            (part for part in needed if part[2]), key=lambda part: part[0].require() / part[2]
        )
        share = self.share([figure.require() for figure in figures], rows) if self.together else 1.0
        formula = f"{format_quantity(weakest.value, weakest.unit)} ({name}) / {format_number(entry)}"
        if self.together:
            formula += f" x {format_number(share)} (share that all joints can have at once)"
        return self._derived(weakest, weakest.require() / entry * share, formula)

    def _plain(self, figures: Sequence[Quantity], quantity: Kind) -> Quantity:
        """The figure of any joint by the plain factor: torques add up, the slowest motor limits the speed."""
        assert self.factor is not None
        if not all(figure.known for figure in figures):
            return unknown(figures[0].unit)
        first = figures[0]
        if quantity is Kind.TORQUE:
            total, sign = sum(figure.require() for figure in figures) * self.factor, "x"
        else:
            total, sign = min(figure.require() for figure in figures) / self.factor, "/"
        parts = [
            f"{format_quantity(figure.value, figure.unit)} ({motor.name})"
            for figure, motor in zip(figures, self.motors, strict=True)
        ]
        formula = f"({' + '.join(parts)})" if quantity is Kind.TORQUE else f"least of {', '.join(parts)}"
        return self._derived(first, total, f"{formula} {sign} {format_number(self.factor)}")

    def _inertia(self, index: int, geometry: Geometry | None) -> Quantity:
        """Diagonal of J^T diag(I) J; with a plain factor all motors times its square."""
        entries = (
            [self.factor or 0.0] * len(self.motors)
            if geometry is None
            else [row[index] for row in geometry.speeds]
        )
        parts = [
            (motor.reflected_inertia, motor.name, entry * entry)
            for motor, entry in zip(self.motors, entries, strict=True)
            if entry != 0.0
        ]
        first = parts[0][0]
        if not all(inertia.known for inertia, _, _ in parts):
            return next(inertia for inertia, _, _ in parts if not inertia.known)
        terms = [
            f"{format_quantity(inertia.value, inertia.unit)} ({name}) x {format_number(square)}"
            for inertia, name, square in parts
        ]
        total = sum(inertia.require() * square for inertia, _, square in parts)
        return self._derived(first, total, " + ".join(terms))

    def _derived(self, figure: Quantity, value: float, formula: str) -> Quantity:
        """What a figure of a motor becomes at a joint."""
        formula = f"{formula}, {self.text}"
        return replace(figure, value=tidy(value), origin=Origin.DERIVED, std=None, formula=formula, lost=())


ZERO = 1e-9
"""Entries of an inverse below this share of the largest are rounding of 0. Chosen."""
SINGULAR = 1e-6
"""Least ratio of smallest to largest singular value of a Jacobian, its joints' units apart.

Chosen: a linkage beyond a million to one is at a dead point, or a row is written twice.
"""
OUTSIDE = ("motor", "motors_per_joint", "reduction", "transmission")
"""Fields of a joint that its linkage states in their place."""


def linked_motors(
    spec: Spec, stated: Sequence[Stated], bindings: Bindings, breaches: Breaches
) -> tuple[LinkedMotors, ...]:
    """Every linkage of a spec that is sound; what is wrong with the others is reported.

    Args:
        spec: The spec.
        stated: What it states of each managed joint.
        bindings: Its joints.
        breaches: Takes what is wrong.
    """
    by_joint = {item.binding.joint.name: item for item in stated}
    found = (
        _linked(name, linkage, spec, by_joint, bindings, breaches)
        for name, linkage in spec.model.linkages.items()
    )
    return tuple(item for item in found if item is not None)


def _linked(
    name: str,
    linkage: Linkage,
    spec: Spec,
    by_joint: Mapping[str, Stated],
    bindings: Bindings,
    breaches: Breaches,
) -> LinkedMotors | None:
    path: Path = ("linkages", name)
    members = _members(path, linkage, by_joint, bindings, breaches)
    if members is None:
        return None
    kind = members[0].kind
    pose = _default_pose(linkage, spec, bindings)
    geometries = _geometries(path, linkage, breaches)
    if geometries is None:
        return None
    used = min(geometries, key=lambda one: 0.0 if one.at is None else math.dist(one.at, pose), default=None)
    motors = []
    for index, key in enumerate(linkage.motors):
        output = _output_kind(path, linkage, index, kind, breaches)
        motor = spec.model.motors[key]
        drivetrain = Drivetrain(gear_train(motor, key, output), Train("", (), output, None), 1, output)
        check_motor(motor, key, drivetrain, f"the linkage '{name}'", breaches)
        motors.append(joint_motor(motor, key, drivetrain, spec))
    return LinkedMotors(
        name=name,
        joints=linkage.joints,
        motors=tuple(motors),
        used=used,
        table=geometries if linkage.table is not None else (),
        everywhere=linkage.at == "any",
        factor=None if linkage.factor is None else number(linkage.factor),
        together=linkage.limits == "together",
        text=_text(name, linkage, used, pose, kind),
    )


def _members(
    path: Path,
    linkage: Linkage,
    by_joint: Mapping[str, Stated],
    bindings: Bindings,
    breaches: Breaches,
) -> list[Stated] | None:
    """The linkage's joints; None where one is missing, of another kind, or has a motor of its own."""
    members = []
    for index, joint in enumerate(linkage.joints):
        place = (*path, "joints", index)
        stated = by_joint.get(joint)
        if stated is None and joint in bindings.unmanaged and bindings.failed:
            # By a pattern that is wrong, which is told.
            continue
        if stated is None:
            breaches.error(
                "RES014",
                f"the joint '{joint}' of the linkage is in no group"
                if joint in bindings.unmanaged
                else f"the robot has no hinge or slide joint '{joint}' for the linkage",
                place,
                "put it into a group of `actuators`"
                if joint in bindings.unmanaged
                else f"joints: {listed(by_joint)}",
            )
            continue
        members.append(stated)
        for field in OUTSIDE:
            if stated.get(field) is not None:
                at = stated.path(field)
                breaches.error(
                    "RES015",
                    f"'{joint}' is driven by the linkage '{path[-1]}', and its group states {field}",
                    at,
                    "remove it here: the linkage names the motors and how they drive; for other joints of the "
                    "group, give these a group of their own",
                )
    kinds = {stated.kind for stated in members}
    if len(kinds) > 1:
        breaches.error(
            "RES014",
            "the linkage has hinge and slide joints",
            (*path, "joints"),
            "its joints are of one kind",
        )
    if len(members) < len(linkage.joints) or len(kinds) > 1:
        return None
    _check_poses(path, linkage, members[0].kind, breaches)
    return members


def _check_poses(path: Path, linkage: Linkage, kind: JointKind, breaches: Breaches) -> None:
    """Poses are in the unit of the joints."""
    poses: list[tuple[Path, tuple[SpecValue, ...] | str | None]] = [((*path, "at"), linkage.at)]
    poses += [((*path, "table", index, "at"), pose.at) for index, pose in enumerate(linkage.table or ())]
    for place, pose in poses:
        for value in pose if isinstance(pose, tuple) else ():
            if unfit(value, kind):
                breaches.error(
                    "RES001",
                    f"the joints of the linkage are {kind.value} joints, but a position is given as {value.written}",
                    place,
                    "a hinge is in rad, a slide in m",
                )
                return


def _jacobians(
    path: Path, linkage: Linkage
) -> list[tuple[Path, tuple[SpecValue, ...] | None, tuple[tuple[SpecValue, ...], ...]]]:
    """Every Jacobian that is written: where, at which pose, and its rows."""
    at = linkage.at if isinstance(linkage.at, tuple) else None
    found = [] if linkage.jacobian is None else [((*path, "jacobian"), at, linkage.jacobian)]
    table = enumerate(linkage.table or ())
    return [*found, *(((*path, "table", i, "jacobian"), pose.at, pose.jacobian) for i, pose in table)]


def _output_kind(
    path: Path, linkage: Linkage, index: int, joints: JointKind, breaches: Breaches
) -> JointKind:
    """What a motor's output does: as the joints, or travel where its row is in m/rad."""
    travels: set[bool] = set()
    for place, _, matrix in _jacobians(path, linkage):
        travels |= {entry.linear is True for entry in matrix[index] if entry.value != 0.0}
        if len(travels) > 1 or (True in travels and joints is JointKind.SLIDE):
            breaches.error(
                "RES001",
                "a motor's row is in m/rad where the motor travels and the joints turn, and without a unit otherwise",
                (*place, index),
                "write the whole row in one unit, in every pose",
            )
            break
    return JointKind.SLIDE if True in travels else joints


def _geometries(path: Path, linkage: Linkage, breaches: Breaches) -> tuple[Geometry, ...] | None:
    """The Jacobian at each pose; none for a plain factor, None where one cannot be inverted."""
    import numpy as np

    found = []
    sound = True
    for place, pose, jacobian in _jacobians(path, linkage):
        matrix = np.array([[number(entry) for entry in row] for row in jacobian])
        # Columns of joints with short arms are as good as others: each is scaled by its largest entry.
        scale = np.abs(matrix).max(axis=0)
        with np.errstate(all="ignore"):
            scaled = matrix / np.where(scale > 0.0, scale, 1.0)
            values = np.linalg.svd(scaled, compute_uv=False)
            invertible = values[-1] > SINGULAR * values[0]
            torques = np.linalg.inv(scaled).T / scale if invertible else matrix
        if not invertible or not np.isfinite(torques).all():
            sound = False
            breaches.error(
                "RES016",
                "the Jacobian has no inverse: some movement of the joints moves no motor, or two rows are the same",
                place,
                "signs tell a parallel linkage apart: `[[1, 0.6], [1, -0.6]]`; a linkage at its dead point "
                "has no limits",
            )
            continue
        torques[np.abs(torques) < ZERO * np.abs(torques).max(axis=0)] = 0.0
        positions = None if pose is None else tuple(number(value) for value in pose)
        found.append(Geometry(_tuples(matrix.tolist()), _tuples(torques.tolist()), positions))
    return tuple(found) if sound else None


def _tuples(rows: Sequence[Sequence[float]]) -> Matrix:
    return tuple(tuple(row) for row in rows)


def _default_pose(linkage: Linkage, spec: Spec, bindings: Bindings) -> tuple[float, ...]:
    patterns = (bindings.default_pose.get(joint) for joint in linkage.joints)
    poses = spec.model.robot.default_pose
    return tuple(0.0 if pattern is None else poses[pattern].value or 0.0 for pattern in patterns)


def _text(name: str, linkage: Linkage, used: Geometry | None, pose: Sequence[float], kind: JointKind) -> str:
    """The linkage in formulas: name, pose of its Jacobian, source."""
    unit = unit_of_kind(Kind.POSITION, kind)
    text = f"linkage {name}"
    if used is not None and used.at is not None:
        at, wanted = (
            f"[{', '.join(f'{format_number(value)}' for value in positions)}] {unit}"
            for positions in (used.at, pose)
        )
        text += f" at {at}"
        if linkage.table is not None and at != wanted:
            text += f", of {len(linkage.table)} poses the nearest to {wanted}"
    if linkage.source is not None:
        text += f" ({linkage.source})"
    return text
