"""Linkages: motors that move joints together, brought to each joint by the linkage's Jacobian.

With motor speeds w = J q' the joint torques are t = J^T m, and m = J^-T t. Simulators limit every joint by
itself, so the set of torques that the motors can give, skewed by J, becomes a box.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from actspec.diagnostics import listed
from actspec.ir import AsymmetricCurve, JointKind, Origin, Quantity
from actspec.resolution.motor import JointMotor
from actspec.resolution.quantities import tidy, unit_of, unknown
from actspec.units import Kind, format_quantity

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
        unit = {quantity: unit_of(quantity, kind) for quantity in (Kind.TORQUE, Kind.SPEED, Kind.INERTIA)}

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
        formula = f"{format_quantity(weakest.value, weakest.unit)} ({name}) / {entry:g}"
        if self.together:
            formula += f" x {share:g} (share that all joints can have at once)"
        return Quantity(
            tidy(weakest.require() / entry * share),
            weakest.unit,
            Origin.DERIVED,
            weakest.source,
            weakest.span,
            note=weakest.note,
            formula=f"{formula}, {self.text}",
        )

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
        return Quantity(
            tidy(total),
            first.unit,
            Origin.DERIVED,
            first.source,
            first.span,
            note=first.note,
            formula=f"{formula} {sign} {self.factor:g}, {self.text}",
        )

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
            return unknown(first.unit)
        terms = [
            f"{format_quantity(inertia.value, inertia.unit)} ({name}) x {square:g}"
            for inertia, name, square in parts
        ]
        return Quantity(
            tidy(sum(inertia.require() * square for inertia, _, square in parts)),
            first.unit,
            Origin.DERIVED,
            first.source,
            first.span,
            note=first.note,
            formula=f"{' + '.join(terms)}, {self.text}",
        )
