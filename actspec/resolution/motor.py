"""A motor's datasheet figures at the joint: gear, efficiency, reduction, parallel motors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from actspec.diagnostics import Span
from actspec.ir import AsymmetricCurve, JointKind, Origin, Quantity
from actspec.resolution.quantities import scaled, tidy, unit_of, unknown, written
from actspec.spec.models import Motor
from actspec.spec.values import SpecValue
from actspec.units import Kind, format_quantity

SpanOf = Callable[..., Span]


@dataclass(frozen=True, slots=True)
class JointMotor:
    """A motor's figures at the joint; see `ir.JointActuator` for each."""

    stall_torque: Quantity | None
    no_load_speed: Quantity | None
    curve: AsymmetricCurve | None
    peak_torque: Quantity
    continuous_torque: Quantity
    reflected_inertia: Quantity
    bandwidth: Quantity | None


@dataclass(frozen=True, slots=True)
class Transmission:
    """Between the gearbox output of one motor and the joint.

    Attributes:
        reduction: Extra reduction [-].
        motors: Motors in parallel [-].
    """

    reduction: float
    motors: int


def joint_motor(
    motor: Motor, name: str, transmission: Transmission, kind: JointKind, span_of: SpanOf
) -> JointMotor:
    """Bring a motor's figures to the joint.

    Torque times gear ratio, efficiency (motor side only), reduction and number of motors; speed
    divided by gear ratio (motor side only) and reduction; inertia times their squares and the
    number of motors. `rotor_inertia` is always at the rotor.

    Args:
        motor: The motor as the spec has it.
        name: Its key in `motors`.
        transmission: What stands between the gearbox and the joint.
        kind: hinge or slide; decides the units.
        span_of: Path in the spec to its place.
    """
    at_rotor = motor.side == "motor"
    gear = (
        motor.gear_ratio.value if motor.gear_ratio is not None and motor.gear_ratio.value is not None else 1.0
    )
    efficiency = (
        motor.efficiency.value if motor.efficiency is not None and motor.efficiency.value is not None else 1.0
    )
    reduction, motors = transmission.reduction, float(transmission.motors)
    to_torque = [(reduction, "reduction"), (motors, "motors_per_joint")]
    to_speed = [(reduction, "reduction")]
    if at_rotor:
        to_torque = [(gear, "gear_ratio"), (efficiency, "efficiency"), *to_torque]
        to_speed = [(gear, "gear_ratio"), *to_speed]
    to_inertia = [(reduction * reduction, "reduction^2"), (motors, "motors_per_joint")]

    def figure(value: SpecValue | None, quantity: Kind, *path: str) -> Quantity | None:
        if value is None:
            return None
        return written(value, unit_of(quantity, kind), span_of("motors", name, *path))

    def torque(value: SpecValue | None, *path: str) -> Quantity | None:
        found = figure(value, Kind.TORQUE, *path)
        return None if found is None else efficient(scaled(found, to_torque))

    def speed(value: SpecValue | None, *path: str) -> Quantity | None:
        found = figure(value, Kind.SPEED, *path)
        return None if found is None else scaled(found, to_speed, divide=True)

    def efficient(found: Quantity) -> Quantity:
        """Say where an efficiency that nobody states was taken as 1."""
        if not at_rotor or motor.efficiency is not None or found.formula is None:
            return found
        return replace(found, formula=f"{found.formula} x 1 (efficiency, default)")

    def by_current(current: SpecValue | None, field: str) -> Quantity | None:
        """Torque constant times current, where the torque itself is not stated."""
        constant = motor.torque_constant
        if constant is None or constant.value is None or current is None or current.value is None:
            return None
        product = Quantity(
            tidy(constant.value * current.value),
            unit_of(Kind.TORQUE, kind),
            Origin.DERIVED,
            source=constant.source or current.source,
            span=span_of("motors", name, field),
            formula=f"{format_quantity(constant.value, 'N*m/A')} (torque_constant) x "
            f"{format_quantity(current.value, 'A')} ({field})",
        )
        at_joint = scaled(product, to_torque)
        if at_joint is product:
            return efficient(product)
        formula = f"{product.formula}" + (at_joint.formula or "").removeprefix(
            format_quantity(product.value, product.unit)
        )
        return efficient(replace(at_joint, formula=formula))

    torque_unit = unit_of(Kind.TORQUE, kind)
    curve = None
    if motor.curve is not None:
        parts = motor.curve
        curve = AsymmetricCurve(
            torque(parts.drive_torque, "curve", "drive_torque") or unknown(torque_unit),
            torque(parts.brake_torque, "curve", "brake_torque") or unknown(torque_unit),
            speed(parts.knee_speed, "curve", "knee_speed") or unknown(unit_of(Kind.SPEED, kind)),
            speed(parts.no_load_speed, "curve", "no_load_speed") or unknown(unit_of(Kind.SPEED, kind)),
        )
    if motor.rotor_inertia is not None:
        rotor = figure(motor.rotor_inertia, Kind.INERTIA, "rotor_inertia")
        assert rotor is not None
        reflected = scaled(rotor, [(gear * gear, "gear_ratio^2"), *to_inertia])
    else:
        output = figure(motor.reflected_inertia, Kind.INERTIA, "reflected_inertia")
        reflected = unknown(unit_of(Kind.INERTIA, kind)) if output is None else scaled(output, to_inertia)
    return JointMotor(
        stall_torque=torque(motor.stall_torque, "stall_torque"),
        no_load_speed=speed(motor.no_load_speed, "no_load_speed"),
        curve=curve,
        peak_torque=torque(motor.peak_torque, "peak_torque")
        or by_current(motor.peak_current, "peak_current")
        or unknown(torque_unit),
        continuous_torque=torque(motor.continuous_torque, "continuous_torque")
        or by_current(motor.nominal_current, "nominal_current")
        or unknown(torque_unit),
        reflected_inertia=reflected,
        bandwidth=figure(motor.bandwidth, Kind.FREQUENCY, "bandwidth"),
    )


def linear_faults(motor: Motor, kind: JointKind) -> list[str]:
    """Fields of a motor whose unit does not fit the joint: rotary figures on a slide or the reverse."""
    wrong = kind is JointKind.HINGE
    names = []
    for field in (
        "stall_torque",
        "no_load_speed",
        "peak_torque",
        "continuous_torque",
        "rotor_inertia",
        "reflected_inertia",
    ):
        value = getattr(motor, field)
        if value is not None and value.value is not None and value.linear is wrong:
            names.append(field)
    if motor.torque_constant is not None and (motor.nominal_current or motor.peak_current) and not wrong:
        names.append("torque_constant")
    if motor.curve is not None:
        for field in ("drive_torque", "brake_torque", "knee_speed", "no_load_speed"):
            value = getattr(motor.curve, field)
            if value.value is not None and value.linear is wrong:
                names.append(f"curve.{field}")
    return names
