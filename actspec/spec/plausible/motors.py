"""What the figures of one motor imply of each other."""

from __future__ import annotations

import math
from collections.abc import Iterator

from actspec.diagnostics import Path
from actspec.spec.models import Motor
from actspec.spec.plausible.currents import ROUNDING, constant_relations, is_fed, is_reached
from actspec.spec.plausible.drive import (
    GEARED,
    Drive,
    Output,
    efficiency_of,
    figure_at,
    gear_of,
    is_geared,
    number,
    output_of,
)
from actspec.spec.plausible.driven import (
    AGREES,
    FASTEST_OUTPUT,
    FASTEST_SLIDE,
    NEVER_GEARED_UP,
    WINDING,
    is_round,
    limit_relations,
    rub_relations,
    stage_relations,
    train_relations,
    witness_relations,
)
from actspec.spec.plausible.relations import RPM, Relation
from actspec.spec.rules.motors import stage_ratio
from actspec.spec.values import SpecValue
from actspec.units import format_quantity

FAR_ABOVE_STALL = 3.0
LARGEST_TORQUE = 100e3
"""[N*m] at the output. Chosen: the strongest arms hold 2300 kg at 3.7 m, 84 kN*m; axes of a KR 210 have 11 kN*m."""
MOST_TURNS = 1000.0
"""From it on a gear ratio goes with `LARGEST_OF_SLOW`. Published: large arms have gears to 350."""
LARGEST_OF_SLOW = 1000.0
"""[N*m] behind more turns than that. Published: 9 N*m behind 1462 (HEBI X8-9)."""
LARGEST_POWER = 200e3
"""Peak torque times no-load speed [W]. Chosen: axes of a KR 210 have 24 kW."""
BATTERY = 100.0
"""A motor with less is no industrial arm's, which have 200 V and more [V]."""
LARGEST_OF_BATTERY = 20e3
"""The most of it [W]. Published: 7.2 kW (H2)."""
HOPELESS_TORQUE = 1e6
"""An error from it on [N*m]. Chosen: slewing and hub drives of large machines have 500 kN*m."""
HOPELESS_POWER = 1e6
"""Likewise [W]. Chosen: the largest motors of vehicles have 700 kW."""
MOST_OF_WINDING = 20.0
"""Stall over peak torque from which on it is the gear's if it is just the gear. Published: 20 (AK80-64, behind 64)."""
JUST_GEAR = 5e-3
"""Two torques are the gear apart by this part."""
ROUNDED_GEAR = 0.02
"""The same where they contradict each other."""
LARGE = 1000.0
"""Such a torque [N*m]. Published of legged and humanoid robots: to 494 (Apollo's hip, playground)."""
SLOWEST_ROTOR = 60.0
"""[rad/s], behind a gear."""
SLOWEST_GEARED = 12.0
"""[rad/s] at the output, from which on a rotor may be slower. Chosen: a gimbal's motor behind a belt of 3 has 15.9."""
FASTEST_ROTOR = 8000.0
"""[rad/s]."""
FASTEST_MICRO = 15708.0
"""Of a micro motor [rad/s], 150000 rpm. Chosen: such of 2 to 6 mm are sold with 100000 and 120000 rpm."""
FASTEST_BY_TORQUE = 1000.0
"""No-load speed times the root of the torque, at the output [rad/s (N*m)^0.5]."""
FASTEST_DIRECT = 3000.0
"""The same without a gear, of a wheel, or where voltage and constant, or current, make it. Chosen: hobby motors have
1081 (mj5208) and 1185 (D6374), and ten times those are a wrong unit."""
SLOWEST_BY_OUTPUT = 40.0
"""Of a rotor by the speed of its output [rad/s], which is often what the drive allows. Chosen: 100 x 0.5 rad/s."""
ROTOR_ACCELERATION = (1500.0, 5e6)
"""Torque over inertia at the rotor [rad/s^2]."""
CONTINUOUS_ACCELERATION = 500.0
"""The least by a continuous torque that stands alone. Published: 1451 (maxon EC 90 flat, 11 times that at stall)."""
MICRO_ACCELERATION = 5e7
"""The most of a micro motor. Chosen: torque over inertia grows as the size falls."""
SMALL = 0.01
"""A rotor of less is a small one [N*m]."""
USUAL_SLOW = (2e4, 1e4)
"""The least that a rotor usually has, and one behind a gear [rad/s^2]. Published: 29400 (legs); strain wave gears have
5000 and more."""
THERMAL = 0.1
"""Part of that by a continuous torque that stands alone. Published: 0.1 to 1 of the peak torque."""
USUAL_SMALL = 1e6
"""The most that such a one usually has. Chosen: motors of 8 mm have 7e5."""
STRONG = 1.0
"""A rotor of so much is no small one [N*m]."""
STRONG_ACCELERATION = 1e6
"""The most of such a one. Published: 125000 (7520)."""
PROMPT = 0.1
"""A direct drive that reaches its speed in this time is not too heavy, however slow [s]. Chosen: hub motors of wheels
take 0.03."""
PEAK_ACCELERATION = 2500.0
"""The least by a peak torque, behind a gear. Published: 29400; chosen: large strain wave gears have 5000."""
SPIN_UP = (0.5, 1.0)
"""Time to its own speed without load by its peak or stall torque, and by a continuous torque that stands alone [s].
Published: 0.005 (Go2) to 0.052 (STS3215)."""
SPINDLE = 1000.0
"""What turns as fast without a gear is no joint's, but a spindle or a flywheel [rad/s]."""
SPINDLE_UP = 5.0
"""The same of that, with its tool [s]. Chosen: spindles of 24000 rpm take 1 to 3."""
STAGE_OF_ROTOR = 2.0
"""Inertia behind a stage, seen at the rotor, over the rotor's. Published: 0.003 to 0.011 (motors of the G1)."""
OUTPUT_ACCELERATION = (1.0, 1e6)
"""Torque over inertia at the output [rad/s^2]."""
HOPELESS = 100.0
"""An acceleration outside of its bounds by this factor is an error."""
LEAST_CONTINUOUS = 0.02
"""Continuous over peak torque. Published: 0.1 to 1; of mN*m read as N*m it is a thousandth."""
LEAST_OF_STALL = {"peak_torque": 0.015, "continuous_torque": 0.004}
"""Over the stall torque. Windings have a continuous torque of 0.02 of it (EC-i) and more, and a peak of 0.05
(AK80-64); of mN*m read as N*m it is a thousandth."""
BRAKES = 3.0
"""Brake over drive torque, either way. Published: 1.16 (Unitree Go2HV) to 1.79 (W4010-25); both are of one winding,
and friction and losses help to brake."""
LEAST_EFFICIENCY = 0.1
"""Of a gearbox. Chosen: lead screws and worm gears have 0.2 to 0.4."""


GEAR_INVERSE = "did you mean {}? gear_ratio is rotor turns in one output turn"


def relations(drive: Drive) -> Iterator[Relation]:
    """Everything that the figures of a drive imply, sound or not, but for a size that the author is sure of."""
    for relation in _relations(drive):
        if relation.code != "SPEC183" or not (drive.large or relation.path in drive.sure):
            yield relation


def _relations(drive: Drive) -> Iterator[Relation]:
    motor = drive.motor
    output = output_of(drive.name, motor)
    witnesses = list(witness_relations(drive, output))
    yield from _torques(drive.name, motor)
    yield from constant_relations(drive.name, motor)
    said = any(is_said(relation) for relation in witnesses)
    yield from _gear(drive.name, motor, said)
    yield from _efficient(drive)
    yield from _beyond(drive, output, said)
    yield from _speed(drive, output)
    yield from _rotor(drive.name, motor, output)
    yield from _stage_inertias(drive.name, motor)
    yield from train_relations(drive, output, said)
    yield from limit_relations(drive, output)
    yield from rub_relations(drive, output)
    yield from witnesses


def is_said(relation: Relation) -> bool:
    """Whether the robot's file has about the torque that the motor gives."""
    return (
        relation.code == "SPEC187" and relation.path[0] == "motors" and 1.0 / AGREES < relation.value < AGREES
    )


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
            (LEAST_OF_STALL[field], ROUNDING),
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

    yield from _of_other_side(name, motor)
    curve = motor.curve
    if curve is not None and curve.brake_torque.value and curve.drive_torque.value:
        ratio = curve.brake_torque.value / curve.drive_torque.value
        yield Relation(
            "SPEC180",
            ratio,
            (1.0 / BRAKES, BRAKES),
            (0.9, 2.0),
            f"brake_torque {curve.brake_torque.written} is {format_quantity(max(ratio, 1 / ratio), '', 3)} times "
            f"{'above' if ratio > 1.0 else 'below'} drive_torque {curve.drive_torque.written}",
            (*path, "curve", "brake_torque"),
            "both are of one motor: look for a wrong unit, or the figure of another one",
            ((*path, "curve", "drive_torque"),),
        )


def is_gear_apart(motor: Motor, path: Path, other: Path, part: float = ROUNDED_GEAR) -> float | None:
    """What the gear passes on where a torque is another one at the other side of it: 1, or its efficiency; else None.

    `path` is that of the torque that would stand at the wrong side, `part` how far they may be off.
    """
    gear, one, two = gear_of(motor), number(figure_at(motor, path)), number(figure_at(motor, other))
    if gear is None or gear < GEARED or not one or not two or motor.side is None:
        return None
    ratio = one / two if motor.side == "motor" else two / one
    passed = (1.0, efficiency_of(motor))
    return next((share for share in passed if math.isclose(ratio, gear * share, rel_tol=part)), None)


def _of_other_side(name: str, motor: Motor) -> Iterator[Relation]:
    """A stall torque and a peak torque that are just the gear apart: one of them is the other side's.

    A gear as small as what a winding has over its drive tells it where the figure is as odd as a gear makes it.
    """
    wrong, right = (
        ("stall_torque", "peak_torque") if motor.side == "motor" else ("peak_torque", "stall_torque")
    )
    one = figure_at(motor, (wrong,))
    if motor.stall_torque is None or motor.peak_torque is None:
        return
    if one is None or is_gear_apart(motor, (wrong,), (right,), JUST_GEAR) is None:
        return
    ratio = (motor.stall_torque.value or 0.0) / (motor.peak_torque.value or 1.0)
    if ratio <= MOST_OF_WINDING and is_round(one.value or 0.0):
        return
    yield Relation(
        "SPEC180",
        ratio,
        (0.0, GEARED),
        (0.0, GEARED),
        f"stall_torque {motor.stall_torque.written} is {format_quantity(ratio, '', 4)} times peak_torque "
        f"{motor.peak_torque.written}, which is just the gear",
        ("motors", name, wrong),
        None,
        (("motors", name, right), ("motors", name, "gear_ratio")),
        about="gear",
    )


def _far(field: str, value: SpecValue, other: str, most: SpecValue) -> str:
    """A torque above another, or far below it."""
    ratio = (most.value or 0.0) / (value.value or 1.0)
    how = "above" if ratio < 1.0 else f"{format_quantity(ratio, '', 3)} times below"
    return f"{field} {value.written} is {how} {other} {most.written}"


def _gear(name: str, motor: Motor, said: bool) -> Iterator[Relation]:
    if motor.gearbox is not None:
        path = ("motors", name, "gearbox")
        yield from stage_relations(motor.gearbox, path, "rotor turns in one output turn", said)
        return
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


def _efficient(drive: Drive) -> Iterator[Relation]:
    """What gearbox and transmissions pass on."""
    motor = drive.motor
    path: Path = ("motors", drive.name)
    written: list[tuple[SpecValue | None, Path]] = [(motor.efficiency, (*path, "efficiency"))]
    staged = {(*path, "gearbox", index): stage for index, stage in enumerate(motor.gearbox or ())}
    for train in drive.trains.values():
        staged |= {(*train.root, train.first + index): stage for index, stage in enumerate(train.stages)}
    written += [(stage.efficiency, (*place, "efficiency")) for place, stage in staged.items()]
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
                f"did you mean {share * 10 ** math.ceil(math.log10(LEAST_EFFICIENCY / share)):.4g}?",
                about=f"{place}",
            )


def _speed(drive: Drive, output: Output) -> Iterator[Relation]:
    name, motor = drive.name, drive.motor
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
        slowest = min(SLOWEST_ROTOR if at_rotor else SLOWEST_BY_OUTPUT, SLOWEST_GEARED * (gear or 1.0))
        slow = behind and rotor < slowest
        where = (
            f"{value.written} at the rotor is {format_quantity(output.speed, 'rad/s', 3)} behind a gear of "
            if at_rotor
            else f"{value.written} at the output is {format_quantity(rotor, 'rad/s', 3)} at the rotor of a gear of "
        )
        yield Relation(
            "SPEC184",
            rotor,
            (slowest if behind else 0.0, FASTEST_MICRO if output.micro else FASTEST_ROTOR),
            (150.0 if behind else 5.0, 2500.0),
            f"{where}{format_quantity(gear, '', 4)}: a rotor turns with {slowest:g} rad/s or more"
            if slow
            else f"the rotor would turn with {format_quantity(rotor, 'rad/s', 4)} ({rotor / RPM:.0f} rpm)",
            output.speed_path,
            help,
            others,
            beyond=(0.0, 10.0 * FASTEST_ROTOR),
            about="rotor",
        )
    if not output.speed:
        return
    # Where a screw is turned the rotor's speed is no joint's.
    turns, torque = min(drive.hinges, default=(1.0, 1.0), key=lambda way: way[0] / math.sqrt(way[1]))
    joint = output.speed / turns
    then = "" if turns == 1.0 else f", {format_quantity(joint, 'rad/s', 4)} at the joint"
    yield Relation(
        "SPEC184",
        joint,
        (0.0, FASTEST_OUTPUT if behind and not at_rotor and drive.hinges else math.inf),
        (1.0, 50.0 if behind and drive.hinges else 1000.0),
        f"{value.written} at the output of a gear of {format_quantity(gear, '', 4)}{then}: the fastest joints that are "
        "published, grippers aside, have 110 rad/s",
        output.speed_path,
        help,
        others,
        about="output",
    )
    if output.torque and drive.hinges:
        fed = motor.torque_constant is None and is_fed(motor, output.torque * output.speed)
        direct = not behind and (drive.wheels or is_reached(motor) or fed)
        yield Relation(
            "SPEC184",
            joint * math.sqrt(output.torque * torque),
            (0.0, FASTEST_DIRECT if direct else FASTEST_BY_TORQUE),
            (1.0, 500.0),
            f"{format_quantity(output.speed, 'rad/s', 4)} at the output{then}, of a motor of "
            f"{format_quantity(output.torque, 'N*m', 3)}: no joint of such a torque is nearly as fast",
            output.speed_path,
            help,
            others,
        )


def _beyond(drive: Drive, output: Output, said: bool) -> Iterator[Relation]:
    """Torque and power of no robot's motor; `said`: the robot's file has about that torque."""
    torque, speed = output.torque, output.speed
    root: Path = ("motors", drive.name)
    yield from _linear(drive.motor, root)
    if not torque:
        return
    others = (output.speed_path, (*root, "gear_ratio"), (*root, "side"))
    help = "look for a wrong unit: mN*m as N*m, rpm as rad/s"
    given = (
        "torque_constant x peak_current"
        if output.torque_path[-1] == "peak_current"
        else output.torque_path[-1]
    )
    this = f"{'this' if given == output.torque_path[-1] else given} is {format_quantity(torque, 'N*m', 3)}"
    slow = (output.gear or 0.0) > MOST_TURNS
    largest = LARGEST_OF_SLOW if slow else LARGEST_TORQUE
    behind = f" of {format_quantity(output.gear, '', 4)} turns" if slow else ""
    yield Relation(
        "SPEC183",
        torque,
        (0.0, HOPELESS_TORQUE if said else largest),
        (0.1, 500.0),
        f"{this} at the gearbox output{behind}, and robots have {format_quantity(largest, 'N*m')} there at most",
        output.torque_path,
        help,
        others,
        beyond=(0.0, HOPELESS_TORQUE),
    )
    if speed:
        volts = number(drive.motor.nominal_voltage) or math.inf
        most = LARGEST_OF_BATTERY if volts < BATTERY else LARGEST_POWER
        at_most = f"robots have {format_quantity(most / 1000, 'kW')}"
        if drive.motor.nominal_voltage is not None and volts < BATTERY:
            at_most += f" at {drive.motor.nominal_voltage.written}"
        yield Relation(
            "SPEC183",
            torque * speed,
            (0.0, most),
            (0.5, 8e3),
            f"{this} x {format_quantity(speed, 'rad/s', 3)}, {format_quantity(torque * speed / 1000, 'kW', 3)} at the "
            f"gearbox output, and {at_most} at most",
            output.torque_path,
            help,
            others,
            beyond=(0.0, HOPELESS_POWER),
            about="power",
        )
    if output.winding:
        most = WINDING * max(torque, LARGE)
        yield Relation(
            "SPEC183",
            output.winding,
            (0.0, most),
            (0.1, WINDING * 500.0),
            f"{output.winding_path[-1]} is {format_quantity(output.winding, 'N*m', 3)} at the gearbox output, and "
            f"{given} {format_quantity(torque, 'N*m', 3)}",
            output.winding_path,
            help,
            others,
            beyond=(0.0, WINDING * HOPELESS_TORQUE),
            about="winding",
        )


def _linear(motor: Motor, root: Path) -> Iterator[Relation]:
    """Speed and power of a motor that travels."""
    value = motor.no_load_speed
    if value is None or not value.linear or not value.value:
        return
    place = (*root, "no_load_speed")
    meant = f"is it in mm/s? Then it is {format_quantity(value.value / 1000.0, 'm/s', 4)}"
    yield Relation(
        "SPEC184",
        value.value,
        (0.0, FASTEST_SLIDE),
        (1e-3, 10.0),
        f"{value.written}: linear motors have {format_quantity(FASTEST_SLIDE, 'm/s')} at most",
        place,
        meant,
        about="linear",
    )
    forces = [force.value or 0.0 for force in (motor.peak_torque, motor.stall_torque) if force is not None]
    if forces and forces[0] * value.value:
        watts = forces[0] * value.value
        volts = number(motor.nominal_voltage) or math.inf
        most = LARGEST_OF_BATTERY if volts < BATTERY else LARGEST_POWER
        yield Relation(
            "SPEC184",
            watts,
            (0.0, most),
            (0.0, 2e4),
            f"{value.written} beside {format_quantity(forces[0], 'N', 4)} are "
            f"{format_quantity(watts / 1000.0, 'kW', 3)}: such motors have {format_quantity(most / 1000.0, 'kW')} at "
            "most",
            place,
            meant,
            (*((*root, field) for field in ("peak_torque", "stall_torque")),),
            about="linear power",
        )


def _rotor(name: str, motor: Motor, output: Output) -> Iterator[Relation]:
    torque, gear = output.torque, output.gear
    part = THERMAL if output.thermal else 1.0
    if motor.rotor_inertia is not None and motor.reflected_inertia is not None:
        # Which of the two is meant, nobody knows: that is told (SPEC132).
        return
    for field in ("rotor_inertia", "reflected_inertia"):
        value: SpecValue | None = getattr(motor, field)
        inertia = number(value)
        at_rotor = field == "rotor_inertia"
        if value is None or not inertia or not torque or (at_rotor and not gear):
            continue
        # What is at the output is judged at the rotor, too, where the gear is known.
        turns = gear or 1.0
        own = torque if not at_rotor else torque / turns / output.efficiency
        rate = own / inertia if at_rotor or not gear else own * turns / output.efficiency / inertia
        low, high = _accelerations(output, at_rotor or gear is not None, bool(number(motor.peak_torque)))
        # A bare number has its unit here.
        given = value.written if " " in value.written else format_quantity(inertia, value.unit)
        what, shown = "a rotor", rate
        if not at_rotor:
            what, shown = "an inertia at the output", own / inertia
        geared = f" there, {format_quantity(rate, 'rad/s^2', 3)} at the rotor" if shown != rate else ""
        yield Relation(
            "SPEC185",
            rate,
            (low, high),
            (
                part * USUAL_SLOW[is_geared(output)],
                USUAL_SMALL if own < SMALL * (1.0 if at_rotor else turns) else 2e5,
            )
            if at_rotor or gear
            else (50.0, 2e4),
            f"{what} of {given} would be turned by the motor's own {format_quantity(own, 'N*m', 3)} with only "
            f"{format_quantity(shown, 'rad/s^2', 3)}{geared}"
            if rate < low
            else f"the motor's {format_quantity(own, 'N*m', 3)} would turn {what} of {given} with "
            f"{format_quantity(shown, 'rad/s^2', 3)}{geared}",
            ("motors", name, field),
            "look for a wrong unit: g*cm^2 or kg*cm^2 as kg*m^2"
            if rate < low
            else "look for a wrong unit: g*cm^2 for kg*cm^2",
            (output.torque_path, ("motors", name, "gear_ratio")),
            beyond=(low / HOPELESS, high * HOPELESS),
        )
        if not output.speed:
            continue
        fast = output.speed * turns
        most = SPIN_UP[output.thermal] if is_geared(output) or output.speed < SPINDLE else SPINDLE_UP
        yield Relation(
            "SPEC185",
            fast / rate,
            (0.0, most),
            (2e-4, 0.1 / part),
            f"{what} of {given} would be turned by the motor's own {format_quantity(own, 'N*m', 3)} to its "
            f"{format_quantity(fast if at_rotor else output.speed, 'rad/s', 4)} in "
            f"{format_quantity(fast / rate, 's', 3)}",
            ("motors", name, field),
            "look for a wrong unit: g*cm^2 or kg*cm^2 as kg*m^2",
            (output.torque_path, output.speed_path, ("motors", name, "gear_ratio")),
            beyond=(0.0, HOPELESS * most),
            about="spin up",
        )


def _stage_inertias(name: str, motor: Motor) -> Iterator[Relation]:
    """What turns with the outputs of the gearbox's stages, by the rotor that turns it."""
    rotor, turns = number(motor.rotor_inertia), 1.0
    if not rotor or motor.rotor_inertia is None:
        return
    for index, stage in enumerate(motor.gearbox or ()):
        ratio, inertia = stage_ratio(stage), number(stage.inertia)
        if ratio is None:
            return
        turns *= ratio
        if not inertia or stage.inertia is None or not 0.0 < turns < math.inf:
            continue
        there = inertia / turns / turns
        yield Relation(
            "SPEC185",
            there / rotor,
            (0.0, STAGE_OF_ROTOR),
            (1e-3, 0.1),
            f"an inertia of {stage.inertia.written} at the output of this stage is "
            f"{format_quantity(there / rotor, '', 3)} times the rotor's {motor.rotor_inertia.written}, "
            f"seen through {format_quantity(turns, '', 4)} turns",
            ("motors", name, "gearbox", index, "inertia"),
            "look for a wrong unit: g*cm^2 or kg*cm^2 as kg*m^2",
            (("motors", name, "rotor_inertia"),),
            beyond=(0.0, HOPELESS * HOPELESS * STAGE_OF_ROTOR),
            about=f"stage {index}",
        )


def _accelerations(output: Output, at_rotor: bool, peak: bool) -> tuple[float, float]:
    """Bounds of torque over inertia, at the rotor where its gear is known, else at the output."""
    if not at_rotor:
        return OUTPUT_ACCELERATION
    low, high = ROTOR_ACCELERATION
    if output.thermal:
        low = CONTINUOUS_ACCELERATION
    elif peak and is_geared(output):
        low = PEAK_ACCELERATION
    if output.speed and not is_geared(output):
        low = min(low, output.speed * (output.gear or 1.0) / PROMPT)
    if output.micro:
        return low, MICRO_ACCELERATION
    own = (output.torque or 0.0) / (output.gear or 1.0)
    return low, STRONG_ACCELERATION if peak and own >= STRONG else high
