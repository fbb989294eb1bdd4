"""What the figures of one motor, and the limits of the joints that it drives, imply of each other."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from actspec.diagnostics import Path
from actspec.spec.models import Motor
from actspec.spec.plausible.relations import RPM, Relation
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
SLOWEST_GEARED = 12.0
"""[rad/s] at the output, from which on a rotor may be slower. Chosen: a gimbal's motor behind a belt of 3 has 15.9."""
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
LIMIT_ABOVE = 3.0
"""Effort limit over the largest of the motor's torques at the joint."""
LIMIT_FAR_ABOVE = 30.0
LIMIT_BELOW = 0.125
"""Effort limit over the least of peak and continuous torque. Chosen: published are 0.59 and more, a slip of ten 0.1."""
LIMIT_BELOW_STALL = 0.02
"""Effort limit over a stall torque that stands alone: of a winding it is many times what the drive gives."""
LEAST_CONTINUOUS = 0.02
"""Continuous over peak torque. Published: 0.1 to 1; of mN*m read as N*m it is a thousandth."""
LEAST_OF_STALL = 0.004
"""Peak or continuous over stall torque. Windings have 0.02 (EC-i) and more; of mN*m read as N*m it is a thousandth."""
LEAST_EFFICIENCY = 0.1
"""Of a gearbox. Chosen: lead screws and worm gears have 0.2 to 0.4."""
WITNESS = 5.0
"""A figure over what the robot's file says of it. Chosen: limits of files are up to 3 times other than the motor's."""
AGREES = 1.25
"""The same of a corrected figure."""
SPEED_LIMIT = 3.0
"""Velocity limit over the motor's speed without load, at the joint. Published: to 1 (Go1, STS3215)."""


def number(value: SpecValue | None) -> float | None:
    """The number of a field of something that turns; None where there is none, or it is of a slide."""
    return None if value is None or value.linear else value.value


CURRENTS = (0.1, 200.0)
VOLTAGES = (3.0, 120.0)
"""Of drives of robots [A, V]. Chosen: from hobby servos to humanoids."""
GEAR_INVERSE = "did you mean {}? gear_ratio is rotor turns in one output turn"


@dataclass(frozen=True, slots=True)
class Limit:
    """An effort or velocity limit of joints that a motor drives.

    Attributes:
        value: As stated.
        path: Where it stands; its last part tells which of the two it is.
        reduction: From the motor's output to the joint.
        motors: How many drive one joint.
    """

    value: SpecValue
    path: Path
    reduction: float
    motors: int


@dataclass(frozen=True, slots=True)
class Witness:
    """A limit that the robot's file states of a joint that a motor drives.

    Attributes:
        joint: Name of the joint.
        value: The limit [N*m or rad/s].
        speed: It is one of speed.
        factor: What a figure at the motor's output is times at the joint; None: unknown.
        limit: Where the spec states the same limit; None: it does not.
    """

    joint: str
    value: float
    speed: bool
    factor: float | None
    limit: Path | None


@dataclass(frozen=True, slots=True)
class Drive:
    """A motor, by its name in `motors`, and what is said of its joints.

    Attributes:
        name: Its name.
        motor: The motor.
        limits: Limits that the spec states.
        witnesses: Limits that the robot's file states.
    """

    name: str
    motor: Motor
    limits: tuple[Limit, ...] = ()
    witnesses: tuple[Witness, ...] = ()


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


def is_geared(output: Output) -> bool:
    """Whether rotor and output cannot be taken for each other."""
    return output.gear is not None and output.gear >= GEARED


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


def relations(drive: Drive) -> Iterator[Relation]:
    """Everything that the figures of a drive imply, sound or not."""
    motor = drive.motor
    output = output_of(drive.name, motor)
    yield from _torques(drive.name, motor)
    yield from _constant(drive.name, motor)
    yield from _gear(drive.name, motor)
    yield from _efficient(drive.name, motor)
    yield from _beyond(drive.name, output)
    yield from _speed(drive.name, motor, output)
    yield from _rotor(drive.name, motor, output)
    yield from _limits(drive, output)
    yield from _witnessed(drive, output)


def _torques(name: str, motor: Motor) -> Iterator[Relation]:
    """Stall, peak and continuous torque, largest first."""
    path: Path = ("motors", name)
    end, at_end = motor.stall_torque, (*path, "stall_torque")
    if motor.curve is not None:
        end, at_end = motor.curve.drive_torque, (*path, "curve", "drive_torque")
    peak, continuous = motor.peak_torque, motor.continuous_torque
    if continuous is not None and continuous.value and peak is not None and peak.value:
        yield Relation(
            "SPEC135",
            continuous.value / peak.value,
            (LEAST_CONTINUOUS, 1.0),
            (0.05, 1.0),
            _far("continuous_torque", continuous, "peak_torque", peak),
            (*path, "continuous_torque"),
            "the thermal limit is the lower one; are the two swapped?"
            if continuous.value > peak.value
            else "look for a wrong unit: mN*m",
            ((*path, "peak_torque"),),
            beyond=(0.0, 1.0),
        )
    for field, beyond in (("peak_torque", FAR_ABOVE_STALL), ("continuous_torque", ROUNDING)):
        value: SpecValue | None = getattr(motor, field)
        if value is None or end is None or not value.value or not end.value:
            continue
        yield Relation(
            "SPEC180",
            value.value / end.value,
            (LEAST_OF_STALL, ROUNDING),
            (0.5 if motor.side == "joint" and field == "peak_torque" else 0.01, ROUNDING),
            f"{_far(field, value, str(at_end[-1]), end)}: the torque-speed line has no more at rest, and less at any "
            "speed"
            if value.value > end.value
            else _far(field, value, str(at_end[-1]), end),
            (*path, field),
            f"are the two swapped? {at_end[-1]} is the end of the line, {field} the "
            f"{'drive' if field == 'peak_torque' else 'thermal'} limit below it"
            if value.value > end.value
            else "look for a wrong unit: mN*m",
            (at_end,),
            beyond=(0.0, beyond),
        )


def _far(field: str, value: SpecValue, other: str, most: SpecValue) -> str:
    """A torque above another, or far below it."""
    ratio = (most.value or 0.0) / (value.value or 1.0)
    how = "above" if ratio < 1.0 else f"{format_quantity(ratio, '', 3)} times below"
    return f"{field} {value.written} is {how} {other} {most.written}"


def _constant(name: str, motor: Motor) -> Iterator[Relation]:
    """Torque constant times current is a torque, times speed a voltage."""
    path: Path = ("motors", name)
    constant = number(motor.torque_constant)
    # Of a winding the stall torque is many times what the drive's current gives.
    most = (0.0, CURRENT_RATIO[1]), (0.02, 2.0)
    for field, product, key, bounds, usual, unit in (
        ("peak_current", "gives", "peak_torque", CURRENT_RATIO, (0.5, 2.0), "N*m"),
        ("nominal_current", "gives", "continuous_torque", CURRENT_RATIO, (0.5, 2.0), "N*m"),
        ("peak_current", "gives", "stall_torque", *most, "N*m"),
        ("nominal_current", "gives", "stall_torque", *most, "N*m"),
        ("no_load_speed", "needs", "nominal_voltage", VOLTAGE_RATIO, (0.3, 2.0), "V"),
    ):
        factor: SpecValue | None = getattr(motor, field)
        other: SpecValue | None = getattr(motor, key)
        first, second = number(factor), number(other)
        if not constant or motor.torque_constant is None:
            continue
        if factor is None or other is None or not first or not second:
            continue
        yield Relation(
            "SPEC181",
            constant * first / second,
            bounds,
            usual,
            f"a torque constant of {motor.torque_constant.written} {product} "
            f"{format_quantity(constant * first, unit, 3)} at {field} {factor.written}, and {key} is {other.written}",
            (*path, "torque_constant"),
            "torque = torque constant x current, voltage = torque constant x speed",
            ((*path, field), (*path, key)),
        )
    # No bounds: which of two factors is the wrong one is told by its own size.
    for field, sizes in (
        ("peak_current", CURRENTS),
        ("nominal_current", CURRENTS),
        ("nominal_voltage", VOLTAGES),
    ):
        value = number(getattr(motor, field))
        if value:
            yield Relation("SPEC181", value, (0.0, math.inf), sizes, "", (*path, field), None)


def _gear(name: str, motor: Motor) -> Iterator[Relation]:
    ratio = number(motor.gear_ratio)
    if not ratio or motor.gear_ratio is None:
        return
    yield Relation(
        "SPEC182",
        ratio,
        (1.0, math.inf),
        (1.0, 350.0),
        f"{motor.gear_ratio.written} rotor turns in one output turn: the output turns "
        f"{format_quantity(1 / ratio, '', 3)} times as fast as the rotor",
        ("motors", name, "gear_ratio"),
        GEAR_INVERSE.format(format_quantity(1 / ratio, "", 3)),
        beyond=(NEVER_GEARED_UP, math.inf),
    )


def _efficient(name: str, motor: Motor) -> Iterator[Relation]:
    """What a gearbox passes on."""
    path: Path = ("motors", name)
    written = [(motor.efficiency, (*path, "efficiency"))]
    written += [
        (stage.efficiency, (*path, "gearbox", index, "efficiency"))
        for index, stage in enumerate(motor.gearbox or ())
    ]
    for value, place in written:
        share = number(value)
        if share and value is not None:
            yield Relation(
                "SPEC189",
                share,
                (LEAST_EFFICIENCY, 1.0),
                (0.4, 1.0),
                f"an efficiency of {value.written}: the gearbox would lose {100 * (1 - share):.3g} % of the torque",
                place,
                f"did you mean {10 * share:g}?",
                about=f"{place}",
            )


def _speed(name: str, motor: Motor, output: Output) -> Iterator[Relation]:
    value = motor.no_load_speed if motor.curve is None else motor.curve.no_load_speed
    fast = number(value)
    if not fast or value is None:
        return
    gear, behind = output.gear, is_geared(output)
    at_rotor = motor.side == "motor"
    rotor = fast if at_rotor else None if gear is None else fast * gear
    others = (("motors", name, "gear_ratio"), ("motors", name, "side"), output.torque_path)
    help = "look for a wrong unit, gear_ratio or side"
    if rotor:
        slowest = min(SLOWEST_ROTOR, SLOWEST_GEARED * (gear or 1.0))
        slow = at_rotor and behind and rotor < slowest
        yield Relation(
            "SPEC184",
            rotor,
            (slowest if at_rotor and behind else 0.0, FASTEST_ROTOR),
            (150.0 if behind else 5.0, 2500.0),
            f"{value.written} at the rotor is {format_quantity(output.speed, 'rad/s', 3)} behind a gear of "
            f"{format_quantity(gear, '', 4)}: a rotor turns with {slowest:g} rad/s or more"
            if slow
            else f"the rotor would turn with {format_quantity(rotor, 'rad/s', 4)} ({rotor / RPM:.0f} rpm)",
            output.speed_path,
            help,
            others,
            beyond=(0.0, 10.0 * FASTEST_ROTOR),
            about="rotor",
        )
    if output.speed:
        yield Relation(
            "SPEC184",
            output.speed,
            (0.0, FASTEST_OUTPUT if behind and not at_rotor else math.inf),
            (1.0, 50.0 if behind else 1000.0),
            f"{value.written} at the output of a gear of {format_quantity(gear, '', 4)}: joints turn with less than "
            f"{FASTEST_OUTPUT:g} rad/s",
            output.speed_path,
            help,
            others,
            about="output",
        )
    if output.speed and output.torque:
        yield Relation(
            "SPEC184",
            output.speed * math.sqrt(output.torque),
            (0.0, FASTEST_BY_TORQUE),
            (1.0, 500.0),
            f"{format_quantity(output.speed, 'rad/s', 4)} at the output, of a motor of "
            f"{format_quantity(output.torque, 'N*m', 3)}: no joint of such a torque is nearly as fast",
            output.speed_path,
            help,
            others,
        )


def _beyond(name: str, output: Output) -> Iterator[Relation]:
    torque, speed = output.torque, output.speed
    if not torque:
        return
    others = (output.speed_path, ("motors", name, "gear_ratio"), ("motors", name, "side"))
    said = "more than any motor of a legged or humanoid robot has"
    help = "look for a wrong unit: mN*m as N*m, rpm as rad/s"
    yield Relation(
        "SPEC183",
        torque,
        (0.0, LARGEST_TORQUE),
        (0.1, 500.0),
        f"this is {format_quantity(torque, 'N*m', 3)} at the gearbox output, {said} (494 N*m is the most that is "
        "published)",
        output.torque_path,
        help,
        others,
        beyond=(0.0, BEYOND * LARGEST_TORQUE),
    )
    if speed:
        yield Relation(
            "SPEC183",
            torque * speed,
            (0.0, LARGEST_POWER),
            (0.5, 8e3),
            f"this is {format_quantity(torque, 'N*m', 3)} x {format_quantity(speed, 'rad/s', 3)}, "
            f"{format_quantity(torque * speed / 1000, 'kW', 3)} at the gearbox output, {said} (360 N*m x 20 rad/s, "
            "7.2 kW is the most that is published)",
            output.torque_path,
            help,
            others,
            beyond=(0.0, BEYOND * LARGEST_POWER),
            about="power",
        )


def _rotor(name: str, motor: Motor, output: Output) -> Iterator[Relation]:
    torque, gear = output.torque, output.gear
    for field in ("rotor_inertia", "reflected_inertia"):
        value: SpecValue | None = getattr(motor, field)
        inertia = number(value)
        at_rotor = field == "rotor_inertia"
        if value is None or not inertia or not torque or (at_rotor and not gear):
            continue
        own = torque / (gear or 1.0) / output.efficiency if at_rotor else torque
        low, high = bounds = ROTOR_ACCELERATION if at_rotor else OUTPUT_ACCELERATION
        rate = own / inertia
        yield Relation(
            "SPEC185",
            rate,
            bounds,
            (2e4, 2e5) if at_rotor else (50.0, 2e4),
            f"a rotor of {value.written} would be turned by the motor's own {format_quantity(own, 'N*m', 3)} with only "
            f"{format_quantity(rate, 'rad/s^2', 3)}"
            if rate < low
            else f"the motor's {format_quantity(own, 'N*m', 3)} would turn a rotor of {value.written} with "
            f"{format_quantity(rate, 'rad/s^2', 3)}",
            ("motors", name, field),
            "look for a wrong unit: g*cm^2 or kg*cm^2 as kg*m^2"
            if rate < low
            else "look for a wrong unit: g*cm^2 for kg*cm^2",
            (output.torque_path, ("motors", name, "gear_ratio")),
            beyond=(low / HOPELESS, high * HOPELESS),
        )


def _limits(drive: Drive, output: Output) -> Iterator[Relation]:
    """Limits of joints against what the motor gives there."""
    motor = drive.motor
    gear = (output.gear or 0.0) * output.efficiency if motor.side == "motor" else 1.0
    own = [number(motor.peak_torque), number(motor.continuous_torque)]
    least = min((torque for torque in own if torque), default=None)
    below = LIMIT_BELOW
    if least is None:
        least, below = output.torque, LIMIT_BELOW_STALL
    else:
        least *= gear
    for limit in drive.limits:
        stated = number(limit.value)
        others = (output.torque_path, ("motors", drive.name, "gear_ratio"), ("motors", drive.name, "side"))
        if limit.path[-1] == "velocity_limit":
            fastest = None if output.speed is None else output.speed / limit.reduction
            if stated and fastest and fastest < math.inf:
                yield Relation(
                    "SPEC184",
                    stated / fastest,
                    (0.0, SPEED_LIMIT),
                    (0.0, 1.5),
                    f"a velocity limit of {limit.value.written} is {format_quantity(stated / fastest, '', 3)} times "
                    f"the {format_quantity(fastest, 'rad/s', 4)} at which the motor '{drive.name}' ends",
                    limit.path,
                    "look for a wrong unit, gear_ratio or side",
                    (output.speed_path, *others[1:]),
                    about=f"{limit.path}",
                )
            continue
        for about, most, bounds, usual, beyond in (
            ("above", output.torque, (0.0, LIMIT_ABOVE), (0.0, 1.1), LIMIT_FAR_ABOVE),
            ("below", least, (below, math.inf), (0.5, math.inf), math.inf),
        ):
            if not stated or not most:
                continue
            most *= limit.reduction * limit.motors
            ratio = stated / most if most else math.inf
            if not 0.0 < ratio < math.inf:
                continue
            far = f"{format_quantity(max(ratio, 1 / ratio), '', 3)} times {'above' if ratio > 1 else 'below'}"
            yield Relation(
                "SPEC187",
                ratio,
                bounds,
                usual,
                f"an effort limit of {limit.value.written} is {far} the {format_quantity(most, 'N*m', 4)} that the "
                f"motor '{drive.name}' gives",
                limit.path,
                "look for a wrong unit, gear_ratio or side",
                others,
                beyond=(0.0, beyond),
                about=f"{about} {limit.path}",
            )


def _witnessed(drive: Drive, output: Output) -> Iterator[Relation]:
    """Figures of a motor, and the limits that the spec states, against the limits of the robot's file."""
    motor, root = drive.motor, ("motors", drive.name)
    to_output = 1.0
    if motor.side == "motor":
        to_output = (output.gear or 0.0) * output.efficiency
    # A winding's stall torque is many times what its drive gives.
    fields = ("peak_torque", "stall_torque") if motor.side == "joint" else ("peak_torque",)
    for witness in drive.witnesses:
        stated = next((limit for limit in drive.limits if limit.path == witness.limit), None)
        given: list[tuple[str, SpecValue, float, Path]] = []
        if stated is not None and (size := number(stated.value)):
            given.append((str(stated.path[-1]), stated.value, size, stated.path))
        if witness.speed:
            speed = motor.no_load_speed if motor.curve is None else motor.curve.no_load_speed
            if speed is not None and output.speed and witness.factor:
                place = output.speed_path
                given.append((str(place[-1]), speed, output.speed * witness.factor, place))
        elif witness.factor:
            for field in fields:
                torque: SpecValue | None = getattr(motor, field)
                if torque is not None and (size := number(torque)):
                    given.append((field, torque, size * to_output * witness.factor, (*root, field)))
        unit, what = ("rad/s", "a velocity limit") if witness.speed else ("N*m", "an effort limit")
        for field, value, size, place in given:
            ratio = size / witness.value
            if not 0.0 < ratio < math.inf:
                continue
            far = f"{format_quantity(max(ratio, 1 / ratio), '', 3)} times {'below' if ratio > 1 else 'above'}"
            own = (stated is not None and place == stated.path) or (
                motor.side == "joint" and witness.factor == 1.0
            )
            there = "" if own else f", {format_quantity(size, unit, 4)} there"
            yield Relation(
                "SPEC184" if witness.speed else "SPEC187",
                ratio,
                (1.0 / WITNESS, WITNESS),
                (1.0 / AGREES, AGREES),
                f"the robot's file gives the joint '{witness.joint}' {what} of "
                f"{format_quantity(witness.value, unit, 4)}, {far} {field} {value.written}{there}",
                place,
                None,
                ((*root, "gear_ratio"), (*root, "side")),
                about=f"witness {witness.joint} {field}",
                witnessed=True,
            )
