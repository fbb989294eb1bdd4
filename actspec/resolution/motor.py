"""A motor's datasheet figures at the joint: gear, efficiency, reduction, parallel motors."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from actspec.diagnostics import Collector, Diagnostic, Path
from actspec.fields import unit_of_kind
from actspec.ir import AsymmetricCurve, JointKind, Origin, Quantity, tidy, unknown
from actspec.resolution.gearbox import (
    OTHER,
    Train,
    carried,
    check_train,
    gear_train,
    inertia_at_joint,
    joint_train,
    unfit,
)
from actspec.resolution.quantities import Factor, scaled, written
from actspec.resolution.stated import Stated
from actspec.spec.document import Breaches
from actspec.spec.models import Motor
from actspec.spec.validate import Spec
from actspec.spec.values import SpecValue
from actspec.units import Kind, format_quantity

DOES = {JointKind.HINGE: "turns", JointKind.SLIDE: "travels"}
UNITS = {JointKind.HINGE: "N*m and rad/s", JointKind.SLIDE: "N and m/s"}
CONVERTING = ("lead", "radius", "lever_arm")
"""Stages of which one side turns and the other travels."""
SCREW = "`{lead: 5 mm/rev}`"
INERTIAS = ("rotor_inertia", "reflected_inertia")
"""Figures that are of one shaft whatever `side` says."""


@dataclass(frozen=True, slots=True)
class ShaftFigure:
    """A figure of a motor, what is written, and what the shaft does that it is of."""

    field: str
    value: SpecValue
    shaft: JointKind


@dataclass(frozen=True, slots=True)
class JointMotor:
    """A motor's figures at the joint; see `ir.JointActuator` for each.

    `name` is what messages call it, `arms` the lever arms on its way, as written.
    """

    name: str
    stall_torque: Quantity | None
    no_load_speed: Quantity | None
    curve: AsymmetricCurve | None
    peak_torque: Quantity
    continuous_torque: Quantity
    reflected_inertia: Quantity
    bandwidth: Quantity | None
    arms: tuple[str, ...]
    torque_constant: Quantity | None = None
    gear: float | None = None


@dataclass(frozen=True, slots=True)
class Drivetrain:
    """From the rotor of one motor to the joint.

    Attributes:
        gearbox: From the rotor to the motor's output.
        transmission: From there to the joint.
        motors: Motors in parallel [-].
        kind: Kind of the joint.
    """

    gearbox: Train
    transmission: Train
    motors: int
    kind: JointKind


def own_motors(spec: Spec, stated: Sequence[Stated], breaches: Breaches) -> dict[str, JointMotor]:
    """The motor of every joint whose group names one, at the joint; what does not fit is reported."""
    found = {}
    checked: dict[tuple[str, JointKind, Path | None, JointKind], tuple[Stated, list[Diagnostic]]] = {}
    for item in stated:
        if item.motor is None:
            continue
        name, joint = str(item.get("motor")), item.binding.joint.name
        drivetrain = drivetrain_of(item.motor, name, item)
        # The same misfit of other joints with the same drive is not told again.
        transmission = item.path("transmission") if "transmission" in item.fields else None
        key = (name, item.kind, transmission, drivetrain.gearbox.input)
        if key not in checked:
            own = replace(breaches, collector=Collector())
            check_motor(item.motor, name, drivetrain, _end(item), own)
            checked[key] = item, [*own.collector]
        found[joint] = joint_motor(item.motor, name, drivetrain, spec)
    for (name, *_), (item, faults) in checked.items():
        fitting = (other for key, (other, wrong) in checked.items() if key[0] == name and not wrong)
        sound = next(fitting, None)
        for fault in faults:
            if sound is None or not fault.where.startswith(f"motors.{name}"):
                breaches.collector.add(fault)
                continue
            help = f"is another motor meant here? This one fits {_end(sound)}; else write what stands between as "
            help += "`transmission`"
            message = f"{fault.message} ({fault.where}, {fault.span})"
            breaches.error(fault.code, message, item.path("motor"), help)
            break
    return found


def _end(item: Stated) -> str:
    """What a motor drives, for messages."""
    return f"'{item.binding.joint.name}', a {item.kind.value} joint"


def drivetrain_of(motor: Motor, name: str, stated: Stated) -> Drivetrain:
    """What the spec states between a joint and its motor."""
    reduction = stated.get("reduction")
    transmission = joint_train(
        stated.get("transmission"),
        None if reduction is None else reduction.value,
        stated.path("transmission" if reduction is None else "reduction"),
        stated.kind,
    )
    gearbox = gear_train(motor, name, transmission.input)
    return Drivetrain(gearbox, transmission, stated.get("motors_per_joint") or 1, stated.kind)


def check_motor(motor: Motor, name: str, drivetrain: Drivetrain, end: str, breaches: Breaches) -> None:
    """Refuse what cannot drive the joint: gears of the wrong sort, figures in the unit of the other sort of shaft.

    Args:
        motor: The motor.
        name: Its key in `motors`.
        drivetrain: What stands between it and what it drives.
        end: What it drives, for messages: "'hip', a hinge joint".
        breaches: Takes what is wrong.
    """
    trains = (drivetrain.gearbox, drivetrain.transmission)
    fits = [check_train(train, end, breaches) for train in trains]
    # Units of shafts mean nothing where it is wrong which of them turn.
    if not all(fits):
        return
    figures = _shaft_figures(motor, drivetrain)
    faults = [figure for figure in figures if unfit(figure.value, figure.shaft)]
    if len(faults) > 1 and _is_of_side(figures, faults, drivetrain):
        _report_side(motor, name, faults, end, breaches)
        return
    if len(faults) > 1 and len(faults) == len(figures):
        _report_gears(faults, name, drivetrain, end, breaches)
        return
    for fault in faults:
        path: Path = ("motors", name, *fault.field.split("."))
        help = "what turns has figures in rad and N*m, what travels in m and N"
        if fault.shaft is JointKind.SLIDE and fault.shaft is drivetrain.kind:
            help += f"; a screw between the two is a stage {SCREW} of gearbox or transmission"
        does = DOES[fault.shaft]
        message = f"{fault.field} is {fault.value.written}, but its shaft {does}, on the way to {end}"
        breaches.error("RES001", message, path, help)


def _is_of_side(
    figures: Sequence[ShaftFigure], faults: Sequence[ShaftFigure], drivetrain: Drivetrain
) -> bool:
    """Whether all that `side` says of a motor with a screw fits its other side."""
    sided = [figure for figure in figures if figure.field not in INERTIAS]
    return drivetrain.gearbox.input is not drivetrain.transmission.input and list(faults) == sided


def _report_side(
    motor: Motor, name: str, faults: Sequence[ShaftFigure], end: str, breaches: Breaches
) -> None:
    """Say once that the figures are quoted at the other side of the gearbox."""
    at_rotor = motor.side == "motor"
    here, there = ("rotor", "joint") if at_rotor else ("output of the gearbox", "motor")
    shaft = faults[0].shaft
    breaches.error(
        "RES001",
        f"by `side: {motor.side}` the figures are of the {here}, which {DOES[shaft]}, on the way to {end}, and they "
        f"are of what {DOES[OTHER[shaft]]} ({_listed(faults)})",
        ("motors", name, "side"),
        f"write `side: {there}`, or figures of the {here} in {UNITS[shaft]}",
    )


def _report_gears(
    faults: Sequence[ShaftFigure], name: str, drivetrain: Drivetrain, end: str, breaches: Breaches
) -> None:
    """Say once, at the stage, that all figures of what turns are of what travels, or the reverse."""
    shaft = faults[0].shaft
    own = OTHER[shaft]
    steps = (*drivetrain.gearbox.steps, *drivetrain.transmission.steps)
    converting = [step for step in steps if step.key in CONVERTING]
    if converting:
        step = converting[-1]
        path: Path = (*step.path, step.key)
        into = "travel into rotation" if step.output is JointKind.HINGE else "rotation into travel"
        message = f"a {step.key} turns {into}, on the way to {end}: with it the motor {DOES[shaft]}, and its figures "
        message += f"are of one that {DOES[own]} ({_listed(faults)})"
        help = "remove this stage"
        if step.key == "radius" and own is JointKind.HINGE:
            help += ", as a wheel's radius is no gear: its joint turns"
        if own is JointKind.HINGE:
            help += f"; or add the screw in front of it, {SCREW}"
        else:
            help += f", or write figures in {UNITS[shaft]}"
    else:
        path = steps[-1].path if steps else ("motors", name)
        message = f"the motor {DOES[own]} ({_listed(faults)}) and the part that it drives {DOES[shaft]}, on the way to "
        message += f"{end}, without a stage that makes one of the other"
        if own is JointKind.HINGE:
            help = f"add the screw, {SCREW}, or the rack, belt or rope, `{{radius: 20 mm}}`, as the last stage of "
            help += f"`gearbox` or as `transmission`; a linear motor has figures in {UNITS[shaft]}"
        else:
            help = "add the lever, `{lever_arm: 50 mm}`, or the rack, belt or rope, `{radius: 20 mm}`, as "
            help += f"`transmission`; what turns has figures in {UNITS[shaft]}"
    breaches.error("RES001", message, path, help)


def _listed(faults: Sequence[ShaftFigure]) -> str:
    """The first figure as it is written, and how many more there are."""
    more = len(faults) - 1
    return f"{faults[0].field} {faults[0].value.written}, and {more} more figure{'s' * (more > 1)}"


def joint_motor(motor: Motor, name: str, drivetrain: Drivetrain, spec: Spec) -> JointMotor:
    """Bring a motor's figures to the joint.

    Torque times gear ratio, efficiency (motor side only), reduction and number of motors; speed
    divided by gear ratio (motor side only) and reduction; inertia times their squares and the
    number of motors. `rotor_inertia` is always at the rotor.

    Args:
        motor: The motor as the spec has it.
        name: Its key in `motors`.
        drivetrain: What stands between rotor and joint.
        spec: The spec.
    """
    at_rotor = motor.side == "motor"
    passed = [drivetrain.gearbox] * at_rotor + [drivetrain.transmission]
    kind, quoted = drivetrain.kind, passed[0].input
    motors = (float(drivetrain.motors), "motors_per_joint")
    to_torque = [*(factor for train in passed for factor in train.torque), motors]
    to_speed = [factor for train in passed for factor in train.speed]
    ratios = [factor for train in (drivetrain.gearbox, drivetrain.transmission) for factor in train.speed]

    def figure(value: SpecValue | None, quantity: Kind, *path: str) -> Quantity | None:
        if value is None:
            return None
        return written(value, unit_of_kind(quantity, quoted), spec.span("motors", name, *path))

    def torque(value: SpecValue | None, *path: str) -> Quantity | None:
        found = figure(value, Kind.TORQUE, *path)
        return None if found is None else at_joint(scaled(found, to_torque), Kind.TORQUE)

    def speed(value: SpecValue | None, *path: str) -> Quantity | None:
        found = figure(value, Kind.SPEED, *path)
        return None if found is None else at_joint(scaled(found, to_speed, divide=True), Kind.SPEED)

    def at_joint(found: Quantity, quantity: Kind) -> Quantity:
        """In the joint's unit; its formula tells what gears are made of, and an efficiency that was taken as 1."""
        formula = found.formula
        if formula is not None:
            torque = quantity is Kind.TORQUE
            for train in passed:
                if torque and train.efficiency is None and train.steps:
                    own = " of the transmission" if train is drivetrain.transmission else ""
                    formula += f" x 1 (efficiency{own}, default)"
            formula += "".join(train.legend + train.efficiencies * torque for train in passed)
        return replace(found, unit=unit_of_kind(quantity, kind), formula=formula)

    def by_current(current: SpecValue | None, field: str) -> Quantity | None:
        """Torque constant times current, where the torque itself is not stated."""
        constant = motor.torque_constant
        if constant is None or constant.value is None or current is None or current.value is None:
            return None
        unit = unit_of_kind(Kind.TORQUE_CONSTANT, quoted)
        product = Quantity(
            tidy(constant.value * current.value),
            unit_of_kind(Kind.TORQUE, quoted),
            Origin.DERIVED,
            source=constant.source or current.source,
            span=spec.span("motors", name, field),
            formula=f"{format_quantity(constant.value, unit)} (torque_constant) x "
            f"{format_quantity(current.value, 'A')} ({field})",
        )
        found = scaled(product, to_torque)
        if found is not product:
            factors = (found.formula or "").removeprefix(format_quantity(product.value, product.unit))
            found = replace(found, formula=f"{product.formula}{factors}")
        return at_joint(found, Kind.TORQUE)

    torque_unit = unit_of_kind(Kind.TORQUE, kind)
    constant = figure(motor.torque_constant, Kind.TORQUE_CONSTANT, "torque_constant")
    curve = None
    if motor.curve is not None:
        parts = motor.curve
        curve = AsymmetricCurve(
            torque(parts.drive_torque, "curve", "drive_torque") or unknown(torque_unit),
            torque(parts.brake_torque, "curve", "brake_torque") or unknown(torque_unit),
            speed(parts.knee_speed, "curve", "knee_speed") or unknown(unit_of_kind(Kind.SPEED, kind)),
            speed(parts.no_load_speed, "curve", "no_load_speed") or unknown(unit_of_kind(Kind.SPEED, kind)),
        )
    return JointMotor(
        name=name,
        stall_torque=torque(motor.stall_torque, "stall_torque"),
        no_load_speed=speed(motor.no_load_speed, "no_load_speed"),
        curve=curve,
        peak_torque=torque(motor.peak_torque, "peak_torque")
        or by_current(motor.peak_current, "peak_current")
        or unknown(torque_unit),
        continuous_torque=torque(motor.continuous_torque, "continuous_torque")
        or by_current(motor.nominal_current, "nominal_current")
        or unknown(torque_unit),
        reflected_inertia=_reflected(motor, name, drivetrain, spec),
        bandwidth=figure(motor.bandwidth, Kind.FREQUENCY, "bandwidth"),
        torque_constant=None if constant is None else scaled(constant, to_torque),
        gear=math.prod(ratio for ratio, _ in ratios) if ratios else None,
        arms=tuple(
            step.text
            for train in (drivetrain.gearbox, drivetrain.transmission)
            for step in train.steps
            if step.key == "lever_arm"
        ),
    )


def _reflected(motor: Motor, name: str, drivetrain: Drivetrain, spec: Spec) -> Quantity:
    """Inertia of rotor and stages at the joint: each times the square of the ratio that is behind it."""
    gearbox, transmission = drivetrain.gearbox, drivetrain.transmission
    outside: list[Factor] = [
        *transmission.behind(0, power=2),
        (float(drivetrain.motors), "motors_per_joint"),
    ]
    unit = unit_of_kind(Kind.INERTIA, drivetrain.kind)
    if motor.rotor_inertia is not None:
        own, kind, field = motor.rotor_inertia, gearbox.input, "rotor_inertia"
        factors, passed = [*gearbox.behind(0, power=2), *outside], [gearbox, transmission]
    elif motor.reflected_inertia is not None:
        own, kind, field = motor.reflected_inertia, transmission.input, "reflected_inertia"
        factors, passed = outside, [transmission]
    else:
        return unknown(unit)
    first = written(own, unit_of_kind(Kind.INERTIA, kind), spec.span("motors", name, field))
    own_terms = [scaled(first, factors)]
    if gearbox in passed:
        own_terms += carried(gearbox, outside, spec)
    found = inertia_at_joint(
        own_terms,
        outside,
        carried(transmission, outside[-1:], spec),
        [part for train in passed for part in train.massless],
        unit,
    )
    if found.formula is None:
        return found
    return replace(found, formula=found.formula + "".join(train.legend for train in passed))


def _shaft_figures(motor: Motor, drivetrain: Drivetrain) -> list[ShaftFigure]:
    """The figures of a motor whose unit tells what their shaft does."""
    rotor, output = drivetrain.gearbox.input, drivetrain.transmission.input
    quoted = rotor if motor.side == "motor" else output
    named: list[tuple[str, SpecValue | None, JointKind]] = [
        *(
            (field, getattr(motor, field), quoted)
            for field in ("stall_torque", "no_load_speed", "peak_torque", "continuous_torque")
        ),
        ("rotor_inertia", motor.rotor_inertia, rotor),
        ("reflected_inertia", motor.reflected_inertia, output),
    ]
    if motor.curve is not None:
        named += [
            (f"curve.{field}", getattr(motor.curve, field), quoted)
            for field in ("drive_torque", "brake_torque", "knee_speed", "no_load_speed")
        ]
    # Nothing is made of a torque constant at what travels without a current.
    if motor.nominal_current or motor.peak_current or quoted is JointKind.HINGE:
        named.append(("torque_constant", motor.torque_constant, quoted))
    return [
        ShaftFigure(field, value, shaft)
        for field, value, shaft in named
        if value is not None and value.linear is not None
    ]
