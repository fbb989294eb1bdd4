"""Checks of motors: what a datasheet's figures imply at the rotor and at the gearbox output."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from actspec.diagnostics import Path
from actspec.spec.document import SourceMap
from actspec.spec.models import Motor
from actspec.spec.plausible.table import Doubt, at
from actspec.spec.rules.motors import stage_ratio
from actspec.spec.values import SpecValue
from actspec.units import format_quantity

ROUNDING = 1.02
"""Two figures of a datasheet may differ by this much and be the same."""
FAR_ABOVE_STALL = 3.0
CURRENT_RATIO = (0.4, 2.5)
"""Torque constant times current, over the torque."""
VOLTAGE_RATIO = (0.2, 3.0)
"""Torque constant times no-load speed, over the voltage."""
NEVER_GEARED_UP = 0.05
LARGEST_TORQUE = 1000.0
"""[N*m] at the output."""
LARGEST_POWER = 20e3
"""Stall torque times no-load speed [W]."""
BEYOND = 3.0
"""An error from this many times the largest on."""
GEARED = 3.0
"""A gear ratio from which on rotor and output cannot be taken for each other."""
SLOWEST_ROTOR = 60.0
"""[rad/s], behind a gear."""
FASTEST_ROTOR = 8000.0
"""[rad/s]."""
FASTEST_OUTPUT = 100.0
"""[rad/s], behind a gear."""
FASTEST_BY_TORQUE = 1000.0
"""No-load speed times the root of the torque, at the output [rad/s (N*m)^0.5]."""
ROTOR_ACCELERATION = (1500.0, 5e6)
"""Torque over inertia at the rotor [rad/s^2]."""
OUTPUT_ACCELERATION = (1.0, 1e6)
"""Torque over inertia at the output [rad/s^2]."""
HOPELESS = 100.0
"""An acceleration outside of its bounds by this factor is an error."""
RPM = math.pi / 30.0


def number(value: SpecValue | None) -> float | None:
    """The number of a field of something that turns; None where there is none, or it is of a slide."""
    return None if value is None or value.linear else value.value


@dataclass(frozen=True, slots=True)
class Output:
    """A motor's figures at its gearbox output; None is unknown.

    Attributes:
        gear: Rotor turns in one output turn.
        efficiency: Of the gearbox.
        torque: The largest of peak, stall, drive and continuous torque [N*m].
        speed: Without load [rad/s].
        torque_path: Where the torque is written.
        speed_path: Where the speed is written.
    """

    gear: float | None
    efficiency: float
    torque: float | None
    speed: float | None
    torque_path: Path
    speed_path: Path


def output_of(name: str, motor: Motor) -> Output:
    """The figures of a motor that turns at its gearbox output."""
    path: Path = ("motors", name)
    gear, efficiency = gear_of(motor), _efficiency(motor)
    written: list[tuple[SpecValue | None, Path]] = [
        (getattr(motor, field), (*path, field))
        for field in ("stall_torque", "peak_torque", "continuous_torque")
    ]
    speed, speed_path = motor.no_load_speed, (*path, "no_load_speed")
    if motor.curve is not None:
        written.append((motor.curve.drive_torque, (*path, "curve", "drive_torque")))
        speed, speed_path = motor.curve.no_load_speed, (*path, "curve", "no_load_speed")
    known = [(value, place) for given, place in written if (value := number(given)) is not None]
    torque, torque_path = max(known, key=lambda item: item[0], default=(None, path))
    fast = number(speed)
    if motor.side == "motor":
        torque = None if torque is None or gear is None else torque * gear * efficiency
        fast = None if fast is None or gear is None else fast / gear
    return Output(gear, efficiency, torque, fast, torque_path, speed_path)


def gear_of(motor: Motor) -> float | None:
    """Rotor turns in one output turn; None where it is unknown, no number, or one of the two travels."""
    if motor.gearbox is None:
        return number(motor.gear_ratio)
    ratios = [stage_ratio(stage) for stage in motor.gearbox]
    product = math.prod(ratio for ratio in ratios if ratio is not None)
    # A product that leaves the range of floats is RES011's.
    return product if None not in ratios and 0.0 < product < math.inf else None


def _efficiency(motor: Motor) -> float:
    stages = [number(stage.efficiency) for stage in motor.gearbox or ()]
    return (number(motor.efficiency) or 1.0) * math.prod(part or 1.0 for part in stages)


def motor_doubts(name: str, motor: Motor, spans: SourceMap) -> Iterator[Doubt]:
    """Everything that can hardly be right about one motor."""
    yield from _above_stall(name, motor, spans)
    yield from _constant(name, motor, spans)
    output = output_of(name, motor)
    for doubts in (
        _gear(name, motor, spans),
        _speed(motor, output, spans),
        _beyond(motor, output, spans),
        _rotor(name, motor, output, spans),
    ):
        found = list(doubts)
        yield from found
        if found:
            # The others see the same mistake: each takes gear, side and torque.
            return


def _above_stall(name: str, motor: Motor, spans: SourceMap) -> Iterator[Doubt]:
    path: Path = ("motors", name)
    end, at_end = motor.stall_torque, (*path, "stall_torque")
    if motor.curve is not None:
        end, at_end = motor.curve.drive_torque, (*path, "curve", "drive_torque")
    stall = None if end is None else end.value
    if end is None or not stall:
        return
    for field, bound in (("peak_torque", FAR_ABOVE_STALL), ("continuous_torque", ROUNDING)):
        value: SpecValue | None = getattr(motor, field)
        if value is None or value.value is None or value.value <= ROUNDING * stall:
            continue
        if field == "continuous_torque" and value.value > (number(motor.peak_torque) or math.inf):
            # SPEC135 has it.
            continue
        yield at(
            spans,
            "SPEC180",
            f"{field} {value.written} is above {at_end[-1]} {end.written}: the torque-speed line has no more at rest, "
            "and less at any speed",
            (*path, field),
            f"are the two swapped? {at_end[-1]} is the end of the line, {field} the "
            f"{'drive' if field == 'peak_torque' else 'thermal'} limit below it",
            at_end,
            error=value.value > bound * stall,
        )


def _constant(name: str, motor: Motor, spans: SourceMap) -> Iterator[Doubt]:
    constant = number(motor.torque_constant)
    if constant is None or motor.torque_constant is None:
        return
    path: Path = ("motors", name)
    place = (*path, "torque_constant")
    gear = gear_of(motor)
    for field, product, key, bounds, unit in (
        ("peak_current", "gives", "peak_torque", CURRENT_RATIO, "N*m"),
        ("nominal_current", "gives", "continuous_torque", CURRENT_RATIO, "N*m"),
        ("no_load_speed", "needs", "nominal_voltage", VOLTAGE_RATIO, "V"),
    ):
        factor: SpecValue | None = getattr(motor, field)
        other: SpecValue | None = getattr(motor, key)
        first, second = number(factor), number(other)
        if factor is None or other is None or first is None or not second:
            continue
        ratio = constant * first / second
        if bounds[0] <= ratio <= bounds[1]:
            continue
        yield at(
            spans,
            "SPEC181",
            f"a torque constant of {motor.torque_constant.written} {product} "
            f"{format_quantity(constant * first, unit, 3)} at {field} {factor.written}, and {key} is {other.written}",
            place,
            _constant_help(constant, ratio, gear, bounds),
            (*path, field),
            (*path, key),
        )
        return


def _constant_help(constant: float, ratio: float, gear: float | None, bounds: tuple[float, float]) -> str:
    """What the torque constant may be: of another unit, or of the other side."""
    for factor, unit in ((1e3, "mN*m/A"), (1e-3, "kN*m/A")):
        if bounds[0] <= ratio / factor <= bounds[1]:
            return f"is it in {unit}? That is {format_quantity(constant / factor, 'N*m/A', 3)}"
    for factor, side in ((gear or 0.0, "the other side of the gear"), (1.0 / (gear or 1.0), "the rotor")):
        if gear is not None and factor and bounds[0] <= ratio / factor <= bounds[1]:
            return f"is it quoted at {side}? It belongs to the `side` of the torques"
    return "torque = torque constant x current, voltage = torque constant x speed"


def _gear(name: str, motor: Motor, spans: SourceMap) -> Iterator[Doubt]:
    ratio = number(motor.gear_ratio)
    if ratio is None or ratio >= 1.0 or motor.gear_ratio is None:
        return
    yield at(
        spans,
        "SPEC182",
        f"{motor.gear_ratio.written} rotor turns in one output turn: the output turns "
        f"{format_quantity(1 / ratio, '', 3)} times as fast as the rotor",
        ("motors", name, "gear_ratio"),
        f"did you mean {format_quantity(1 / ratio, '', 3)}? gear_ratio is rotor turns in one output turn",
        error=ratio < NEVER_GEARED_UP,
    )


def _beyond(motor: Motor, output: Output, spans: SourceMap) -> Iterator[Doubt]:
    torque = output.torque or 0.0
    power = torque * (output.speed or 0.0)
    if torque < LARGEST_TORQUE and power < LARGEST_POWER:
        return
    of_torque = torque >= LARGEST_TORQUE
    shown = format_quantity(torque, "N*m", 3)
    if not of_torque:
        shown += f" x {format_quantity(output.speed, 'rad/s', 3)}, {format_quantity(power / 1000, 'kW', 3)}"
    geared = motor.side == "motor" and output.gear is not None and output.gear >= GEARED
    yield at(
        spans,
        "SPEC183",
        f"this is {shown} at the gearbox output, more than any motor of a legged or humanoid robot has "
        f"({'494 N*m' if of_torque else '360 N*m x 20 rad/s, 7.2 kW'} is the most that is published)",
        output.torque_path,
        f"are the figures those of the gearbox output? Then write `side: joint`: they are multiplied by the gear of "
        f"{format_quantity(output.gear, '', 4)}"
        if geared
        else "look for a wrong unit: mN*m as N*m, rpm as rad/s",
        output.speed_path,
        error=torque >= BEYOND * LARGEST_TORQUE or power >= BEYOND * LARGEST_POWER,
    )


def _speed(motor: Motor, output: Output, spans: SourceMap) -> Iterator[Doubt]:
    value = motor.no_load_speed if motor.curve is None else motor.curve.no_load_speed
    fast = number(value)
    if fast is None or value is None:
        return
    gear = output.gear
    rotor = fast if motor.side == "motor" else None if gear is None else fast * gear
    behind = gear is not None and gear >= GEARED
    rpm = f"is it in rpm? {fast:g} rpm is {format_quantity(fast * RPM, 'rad/s', 3)}"
    message = help = None
    if rotor is not None and rotor > FASTEST_ROTOR:
        message = f"the rotor would turn with {format_quantity(rotor, 'rad/s', 4)} ({rotor / RPM:.0f} rpm)"
        help = (
            rpm
            if motor.side == "motor" or rotor * RPM < FASTEST_ROTOR
            else "look for a wrong unit or gear_ratio"
        )
        if motor.side == "joint" and fast <= FASTEST_ROTOR and fast > FASTEST_OUTPUT:
            help = f"{rpm}; or is it the rotor's own (`side: motor`)?"
    elif motor.side == "joint" and behind and fast > FASTEST_OUTPUT:
        message = (
            f"{value.written} at the output of a gear of {format_quantity(gear, '', 4)}: joints turn with less than "
            f"{FASTEST_OUTPUT:g} rad/s"
        )
        help = f"is it the rotor's speed? Then figures at the rotor need `side: motor`; or {rpm}"
    elif motor.side == "motor" and behind and fast < SLOWEST_ROTOR:
        message = (
            f"{value.written} at the rotor is {format_quantity(output.speed, 'rad/s', 3)} behind a gear of "
            f"{format_quantity(gear, '', 4)}: a rotor turns with {SLOWEST_ROTOR:g} rad/s or more"
        )
        help = "is it the speed of the gearbox output? Then write `side: joint`"
    elif (output.speed or 0.0) * math.sqrt(output.torque or 0.0) > FASTEST_BY_TORQUE:
        message = (
            f"{format_quantity(output.speed, 'rad/s', 4)} at the output, of a motor of "
            f"{format_quantity(output.torque, 'N*m', 3)}: no joint of such a torque is nearly as fast"
        )
        help = rpm
    if message is not None:
        others = (("motors", *output.speed_path[1:2], "gear_ratio"), output.torque_path)
        error = rotor is not None and rotor > 10.0 * FASTEST_ROTOR
        yield at(spans, "SPEC184", message, output.speed_path, help, *others, error=error)


def _rotor(name: str, motor: Motor, output: Output, spans: SourceMap) -> Iterator[Doubt]:
    torque, gear = output.torque, output.gear
    if torque is None:
        return
    for field in ("rotor_inertia", "reflected_inertia"):
        value: SpecValue | None = getattr(motor, field)
        inertia = number(value)
        if value is None or not inertia or (field == "rotor_inertia" and not gear):
            continue
        own = torque if field == "reflected_inertia" else torque / (gear or 1.0) / output.efficiency
        low, high = OUTPUT_ACCELERATION if field == "reflected_inertia" else ROTOR_ACCELERATION
        rate = own / inertia
        if low <= rate <= high:
            continue
        yield at(
            spans,
            "SPEC185",
            f"a rotor of {value.written} would be turned by the motor's own {format_quantity(own, 'N*m', 3)} with only "
            f"{format_quantity(rate, 'rad/s^2', 3)}"
            if rate < low
            else f"the motor's {format_quantity(own, 'N*m', 3)} would turn a rotor of {value.written} with "
            f"{format_quantity(rate, 'rad/s^2', 3)}",
            ("motors", name, field),
            _rotor_help(field, inertia, rate, gear),
            output.torque_path,
            ("motors", name, "gear_ratio"),
            error=not low / HOPELESS <= rate <= high * HOPELESS,
        )


def _rotor_help(field: str, inertia: float, rate: float, gear: float | None) -> str:
    """What an inertia may be: of another unit, or on the other side of the gear."""
    usual = (2e4, 2e5) if field == "rotor_inertia" else (50.0, 2e4)
    for factor, unit in ((1e-7, "g*cm^2"), (1e-4, "kg*cm^2"), (1e-6, "kg*mm^2"), (1e-3, "g*m^2")):
        if usual[0] <= rate / factor <= usual[1]:
            return f"is it in {unit}? {inertia:g} {unit} is {format_quantity(inertia * factor, 'kg*m^2', 4)}"
    geared = field == "rotor_inertia" and gear is not None and gear >= GEARED
    if (
        geared
        and gear is not None
        and rate < ROTOR_ACCELERATION[0]
        and rate * gear**2 <= ROTOR_ACCELERATION[1]
    ):
        return "is it the inertia at the output? Then write `reflected_inertia`; or a wrong unit, g*cm^2"
    return "look for a wrong unit: g*cm^2 or kg*cm^2 as kg*m^2"
