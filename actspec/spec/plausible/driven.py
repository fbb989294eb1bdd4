"""What a motor implies of its joints: their limits, the transmissions on the way, the limits of the robot's file."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace

from actspec.diagnostics import Path
from actspec.fields import FRICTION_SHARE
from actspec.ir import JointActuator, Level, Origin, Quantity
from actspec.spec.document import SourceMap
from actspec.spec.gears import Stage
from actspec.spec.models import Motor
from actspec.spec.plausible.drive import GEARED, Drive, Limit, Output, number, scaled, stage_path
from actspec.spec.plausible.relations import KGF_CM, Relation
from actspec.spec.plausible.slips import lengths
from actspec.spec.plausible.table import Doubt, Found, at, found_at, shown
from actspec.spec.rules.motors import stage_ratio
from actspec.spec.values import SpecValue
from actspec.units import format_quantity

FASTEST_OUTPUT = 120.0
"""[rad/s], behind a gear. Published: 100.7 (ankle of the H2) and 110 (shoulder of the Qinglong)."""
FASTEST_SLIDE = 30.0
"""[m/s]. Chosen: belts and linear motors reach 10."""
FASTEST_SCREW = 5.0
"""The same behind a lead. Chosen: fast ball screws reach 2.5."""
STRONGEST_SLIDE = 300e3
"""[N]. Chosen: roller screws of robots have 10 to 100 kN."""
STRONGEST_HINGE = 3000.0
"""[N*m], behind a transmission."""
LEADS = (1e-3, 0.02)
"""Of usual screws [m/rev]."""
LEAST_STAGE = 0.8
"""Ratio of one stage of several that reduce. Chosen: bevel wheels and idlers are about 1."""
LIMIT_ABOVE = 3.0
"""Effort limit over the largest of the motor's torques at the joint."""
LIMIT_FAR_ABOVE = 30.0
LIMIT_BELOW = 0.125
"""Effort limit over the least of peak and continuous torque. Chosen: published are 0.59 and more, a slip of ten 0.1."""
NOT_BELOW = 0.5
"""The same of a limit that is one of the motor's torques at the rotor, to the digit: through the gear it is that."""
ROUND_DIGITS = 2
"""Digits of a limit that may be anybody's choice: 5 N*m is an eighth of 40 N*m, 4.44 N*m is what a gear of 9 leaves."""
NEARLY = 3e-3
"""A torque that is divided by its gear, in three digits, is that by this part."""
LIMIT_BELOW_STALL = 0.02
"""Effort limit over a stall torque that stands alone: of a winding it is many times what the drive gives."""
WITNESS = 5.0
"""A figure over what the robot's file says of it. Chosen: limits of files are up to 3 times other than the motor's."""
AGREES = 1.25
"""The same of a corrected figure."""
JUST = 1e-3
"""Two numbers are one by this part."""
NEVER_GIVEN = 2.0
"""The same where it does not act. Chosen: nothing gives more at standstill, but a line through a rated point may end
below what the drive gives."""
NEVER_REACHED = 1.25
"""Effort limit over the end of a torque-speed line that acts. Chosen: a gear of 0.8 in one of the two makes so much."""
SLOWED = 0.5
"""A velocity limit in another unit is explained from so much of motor and file on: it is often below them."""
SPEED_LIMIT = 3.0
"""Velocity limit over the motor's speed without load, at the joint. Published: to 1 (Go1, STS3215)."""
NEVER_GEARED_UP = 0.05
ROUNDED = 1.01
"""Two figures of a sheet that are one torque in two units differ by no more than this."""
UNREACHED = 3.0
"""Viscous friction at the motor's no-load speed over the effort limit, where no torque-speed line acts: a belt takes
1.24 at a speed that it never comes near."""
WINDING = 10.0
"""A stall torque may be this many times a large peak torque beside it: voltage over resistance, never reached."""
CURRENT_RATIO = (0.4, 2.5)
"""Torque constant times current, over the torque."""


_WORDS = ("continuous", "peak")
MOST_PLANETARY = 15.0
"""Ratio of a planetary stage. Three planets touch each other where planet / sun is sin 60 deg / (1 - sin 60 deg), 6.46:
from 1 + ring / sun = 2 + 2 x 6.46 = 14.9 on. Catalogues have 3 to 10; published: 4.5 (motors of the G1)."""
FEWEST_TEETH = 10.0
"""Wheels of gears have more, mostly. Chosen: pinions have 12 and more, of micro gearboxes 8."""
LONGEST_ARM = 3.0
"""Lever arm of a transmission [m]. Chosen: cylinders of large excavators have 1."""


def gear_doubts(stages: Sequence[Stage], path: Path, spans: SourceMap) -> Iterator[Doubt]:
    """Gears that nobody can make: teeth that are no whole number, planets that would touch; levers of many metres."""
    for index, stage in enumerate(stages):
        arm = stage.lever_arm
        if arm is not None and (arm.value or 0.0) > LONGEST_ARM:
            slips = [slip for slip in lengths(arm) if (arm.value or 0.0) * slip[0] < 1.0]
            message = f"a lever arm of {arm.written}: robots have {LONGEST_ARM:g} m at most"
            help = slips[0][1] if slips else "look for a wrong unit"
            yield at(spans, "SPEC184", message, (*path, index, "lever_arm"), help)
        wheels = stage.planetary or stage.teeth
        if wheels is None:
            continue
        kind = "planetary" if stage.planetary is not None else "teeth"
        broken = False
        for key in type(wheels).model_fields:
            teeth: SpecValue = getattr(wheels, key)
            size = teeth.value or 0.0
            if _is_whole(size):
                continue
            broken = True
            # Ten times of what is a usual number already is no likelier.
            tens = [
                size * power for power in (10.0, 100.0) if _is_whole(size * power) and size < FEWEST_TEETH
            ]
            help = f"did you mean {tens[0]:.6g}?" if tens else "write `ratio` where the teeth are not known"
            message = f"{key} has {teeth.written} teeth: wheels have whole numbers of them"
            yield at(spans, "SPEC182", message, (*path, index, kind, key), help)
        ratio = stage_ratio(stage)
        if not broken and stage.planetary is not None and ratio is not None and ratio > MOST_PLANETARY:
            sun, ring = stage.planetary.sun, stage.planetary.ring
            message = (
                f"a planetary stage of {sun.written} and {ring.written} teeth has a ratio of "
                f"{format_quantity(ratio, '', 3)}: from 14.9 on three planets would touch each other"
            )
            help = "look for a wrong number of teeth, or write `ratio` for another kind of gear"
            place: Path = (*path, index, "planetary", "sun")
            yield at(spans, "SPEC182", message, place, help, (*path, index, "planetary", "ring"))


def _is_whole(teeth: float) -> bool:
    return math.isclose(teeth, round(teeth), rel_tol=1e-6)


def stage_relations(stages: Sequence[Stage], path: Path, what: str, said: bool) -> Iterator[Relation]:
    """Stages that make what is driven turn faster, at the one that does most of it; one among others that do not.

    `said`: the robot's file has about such a torque.
    """
    ratios = [stage_ratio(stage) for stage in stages]
    if not ratios:
        return
    for index, ratio in enumerate(ratios):
        others = math.prod(other for other in (*ratios[:index], *ratios[index + 1 :]) if other is not None)
        if said or ratio is None or not ratio * others > 1.0:
            continue
        wheels = stages[index].teeth
        what_stage = (
            f"a ratio of {format_quantity(ratio, '', 4)}"
            if wheels is None
            else f"{wheels.driving.written} driving and {wheels.driven.written} driven teeth"
        )
        yield Relation(
            "SPEC182",
            ratio,
            (LEAST_STAGE, math.inf),
            (LEAST_STAGE, math.inf),
            f"{what_stage}: this stage turns {format_quantity(1 / ratio, '', 3)} times as fast, and the others reduce "
            f"by {format_quantity(others, '', 4)}",
            stage_path(stages[index], (*path, index)),
            "are driving and driven swapped? Driving is the wheel on the motor's side"
            if wheels is not None
            else "a stage has turns at its input in one turn at its output",
            about=f"stage {index} {path}",
        )
    plain = [(ratio, index) for index, ratio in enumerate(ratios) if ratio is not None]
    if len(plain) < len(ratios):
        return
    product = math.prod(ratio for ratio, _ in plain)
    if not 0.0 < product < math.inf:
        return
    least, index = min(plain)
    yield Relation(
        "SPEC182",
        product,
        (1.0, math.inf),
        (1.0, 350.0),
        f"{format_quantity(product, '', 3)} {what}: it turns {format_quantity(1 / product, '', 3)} times as fast",
        stage_path(stages[index], (*path, index)),
        "are driving and driven swapped? Driving is the wheel on the motor's side"
        if stages[index].teeth is not None
        else f"did you mean {format_quantity(1 / least, '', 3)}? A stage has turns at its input in one turn at its "
        "output",
        beyond=(NEVER_GEARED_UP, math.inf),
        about=f"{path}",
    )


def train_relations(drive: Drive, output: Output, said: bool) -> Iterator[Relation]:
    """Speed and force of the joints behind a transmission; `said` as in `stage_relations`."""
    for path, train in drive.trains.items():
        yield from stage_relations(
            train.stages, train.root, "turns of the motor's output in one turn of the joint", said
        )
        for index, stage in enumerate(train.stages):
            if stage.lead is not None and stage.lead.value:
                # Any may be; of two corrections it tells which.
                yield Relation(
                    "SPEC184",
                    stage.lead.value * 2.0 * math.pi,
                    (0.0, math.inf),
                    LEADS,
                    "",
                    train.place(index),
                    None,
                    about=f"lead {path} {index}",
                )
        speed, torque = train.speed, train.torque
        if not 0.0 < speed < math.inf or not 0.0 < torque < math.inf:
            continue
        travels = [index for index, stage in enumerate(train.stages) if stage_ratio(stage) is None]
        index = travels[-1] if travels else 0
        place = train.place(index)
        given = getattr(train.stages[index], str(place[-1]))
        written = f"a {place[-1]} of {given.written}" if travels else "the transmission"
        slide = train.slide
        fast, unit = (FASTEST_SLIDE, "m/s") if slide else (FASTEST_OUTPUT, "rad/s")
        fast = FASTEST_SCREW if slide and place[-1] == "lead" else fast
        kind = "hinge" if not slide else "screw" if place[-1] == "lead" else "slide"
        help = "look for a wrong unit: mm as m"
        if output.speed and travels:
            yield Relation(
                "SPEC184",
                output.speed / speed,
                (0.0, fast),
                (0.005, 5.0) if slide else (0.2, 30.0),
                f"behind {written} the {format_quantity(output.speed, 'rad/s', 3)} of the motor '{drive.name}' are "
                f"{format_quantity(output.speed / speed, unit, 3)}: a {kind} has {format_quantity(fast, unit)} at most",
                place,
                help,
                (output.speed_path,),
                about=f"train {path}",
            )
        if output.torque:
            strong, unit = (STRONGEST_SLIDE, "N") if slide else (STRONGEST_HINGE, "N*m")
            yield Relation(
                "SPEC183",
                output.torque * torque,
                (0.0, strong),
                (1.0, 2e4) if slide else (0.1, 500.0),
                f"behind {written} the {format_quantity(output.torque, 'N*m', 3)} of the motor '{drive.name}' are "
                f"{format_quantity(output.torque * torque, unit, 3)}: a {kind} of a robot has "
                f"{format_quantity(strong, unit)} at most",
                place,
                help,
                (output.torque_path,),
                about=f"train {path}",
            )


def limit_relations(drive: Drive, output: Output) -> Iterator[Relation]:
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
        train = None if limit.train is None else drive.trains[limit.train]
        stated = number(limit.value) if train is None else limit.value.value
        slowed = limit.reduction if train is None else train.speed
        passed = limit.reduction * limit.motors if train is None else train.torque
        if not 0.0 < slowed < math.inf:
            continue
        others = (output.torque_path, ("motors", drive.name, "gear_ratio"), ("motors", drive.name, "side"))
        if limit.path[-1] == "velocity_limit":
            fastest = None if output.speed is None else output.speed / slowed
            if stated and fastest and fastest < math.inf:
                yield Relation(
                    "SPEC184",
                    stated / fastest,
                    (0.0, SPEED_LIMIT),
                    (0.05, 1.5),
                    f"a velocity limit of {limit.value.written} is {format_quantity(stated / fastest, '', 3)} times "
                    f"the {format_quantity(fastest, limit.value.unit, 4)} at which the motor '{drive.name}' ends",
                    limit.path,
                    "look for a wrong unit, gear_ratio or side",
                    (output.speed_path, *others[1:]),
                    about=f"{limit.path}",
                )
            continue
        given = (number(motor.torque_constant) or 0.0) * (number(motor.peak_current) or 0.0)
        stall = motor.stall_torque
        if (
            given
            and stall is not None
            and motor.peak_torque is None
            and 1.0 / ROUNDED < given * gear * passed / (stated or math.inf) < ROUNDED
            and 1.0 / ROUNDED < (number(stall) or 0.0) * KGF_CM / given < ROUNDED
        ):
            # Of a winding it may be many times as much, but hardly just that.
            yield Relation(
                "SPEC181",
                given / (number(stall) or math.inf),
                CURRENT_RATIO,
                (0.5, 2.0),
                f"torque_constant and peak_current give {format_quantity(given, 'N*m', 3)}, on which the effort limit "
                f"of {limit.value.written} agrees; and stall_torque is {stall.written}",
                ("motors", drive.name, "stall_torque"),
                None,
                (
                    ("motors", drive.name, "torque_constant"),
                    ("motors", drive.name, "peak_current"),
                    limit.path,
                ),
                about=f"servo {limit.path}",
            )
        # A gripper may be held far below what its drive gives.
        low = LIMIT_BELOW_STALL if train else below
        at_rotor = None if train else _of_rotor(limit, motor, output)
        for about, most, bounds, usual, beyond in (
            ("above", output.torque, (0.0, LIMIT_ABOVE), (0.0, 1.1), LIMIT_FAR_ABOVE),
            (
                "below",
                at_rotor or least,
                (NOT_BELOW if at_rotor else low, math.inf),
                (0.5, math.inf),
                math.inf,
            ),
        ):
            if not stated or not most:
                continue
            most *= passed
            ratio = stated / most if most else math.inf
            if not 0.0 < ratio < math.inf:
                continue
            far = f"{format_quantity(max(ratio, 1 / ratio), '', 3)} times {'above' if ratio > 1 else 'below'}"
            yield Relation(
                "SPEC187",
                ratio,
                bounds,
                usual,
                f"an effort limit of {limit.value.written} is {far} the {format_quantity(most, limit.value.unit, 4)} "
                f"that the motor '{drive.name}' gives",
                limit.path,
                "look for a wrong unit, gear_ratio or side",
                others,
                beyond=(0.0, beyond),
                about=f"{about} {limit.path}",
            )


def rub_relations(drive: Drive, output: Output) -> Iterator[Relation]:
    """Friction of the joints over what the motor gives there; it is told of the joints (FRC101, FRC106)."""
    to_output = (output.gear or 0.0) * output.efficiency if drive.motor.side == "motor" else 1.0
    for rub in drive.rubs:
        train = None if rub.train is None else drive.trains[rub.train]
        slowed = rub.reduction if train is None else train.speed
        passed = rub.reduction * rub.motors if train is None else train.torque
        dry, size = rub.path[-1] == "coulomb", rub.value.value or 0.0
        fast = 1.0 if dry else (output.speed or 0.0) / slowed if slowed else 0.0
        # As the effort limit follows from the motor.
        own = [number(getattr(drive.motor, f"{word}_torque")) for word in _WORDS if rub.limit in (None, word)]
        torque = next((size * to_output for size in own if size), output.torque or 0.0)
        most = torque * passed
        if 0.0 < most < math.inf and 0.0 < size * fast < math.inf:
            code, bound = ("FRC101", FRICTION_SHARE) if dry else ("FRC106", UNREACHED)
            share = size * fast / most
            about, any_share = f"{rub.path}", (0.0, math.inf)
            yield Relation(code, share, (0.0, bound), any_share, "", rub.path, None, about=about, aside=True)


def _of_rotor(limit: Limit, motor: Motor, output: Output) -> float | None:
    """The torque at the gearbox output that an effort limit has as the rotor's, to the digit; None: it has none.

    A figure of the rotor's own sheet is that in any case; one of the output has to be as odd as what a gear makes.
    """
    stated, gear = number(limit.value), output.gear or 1.0
    if not stated or gear < GEARED or motor.side is None:
        return None
    figures = [motor.peak_torque, motor.continuous_torque]
    if motor.peak_torque is None:
        figures += [motor.stall_torque, None if motor.curve is None else motor.curve.drive_torque]
    sheet = motor.side == "motor"
    if not sheet and is_round(stated):
        return None
    ways = (
        ((1.0, gear * output.efficiency),)
        if sheet
        else ((1.0 / gear, 1.0), (1.0 / gear / output.efficiency, 1.0))
    )
    for figure in figures:
        torque = number(figure)
        for to_rotor, to_output in ways if torque else ():
            if math.isclose(stated, (torque or 0.0) * to_rotor, rel_tol=JUST if sheet else NEARLY):
                return (torque or 0.0) * to_output
    return None


def is_round(size: float) -> bool:
    """Whether a figure has no more digits than anybody would choose."""
    return math.isclose(size, float(f"{size:.{ROUND_DIGITS}g}"), rel_tol=1e-6)


def given_at(joint: JointActuator) -> Quantity:
    """The larger of a joint's effort limit and its drive's peak torque: to that a lower limit is a choice.

    Where no peak torque is known that is the stall torque, unless it is so large that it may be a winding's.
    """
    known = (joint.effort_limit, joint.peak_torque, joint.continuous_torque)
    most, line = max(known, key=lambda torque: torque.value or 0.0), joint.motor_line
    end = None if line is None else line.stall_torque if line.curve is None else line.curve.drive_torque
    if end is None or not end.value or joint.peak_torque.value:
        return most
    return end if (most.value or 0.0) < end.value < WINDING * (most.value or math.inf) else most


def unreached_limit(joint: JointActuator) -> Iterator[Found]:
    """An effort limit above all that the joint's torque-speed line gives, as rule LIM107 of the audit where it acts."""
    limit, line = joint.effort_limit, joint.motor_line
    acts = joint.level is Level.DC_MOTOR
    end, curve = (None, None) if line is None else (line.stall_torque, line.curve)
    if curve is not None:
        end = max(curve.drive_torque, curve.brake_torque, key=lambda torque: torque.value or 0.0)
    if limit.origin is not Origin.AUTHORED or end is None or not end.value:
        return
    ratio, free = limit.require() / end.value, joint.no_load_speed
    if ratio > (NEVER_REACHED if acts else NEVER_GIVEN):
        if free is not None and free.value and math.isclose(free.value, limit.require(), rel_tol=JUST):
            # The limit says of which number the line begins.
            yield _exchanged(joint, end, free, limit)
            return
        message = f"an effort limit of {shown(limit)} is never reached: the torque-speed line begins at "
        message += f"{shown(end)}, at standstill"
        help = "are the two swapped, or is the line another motor's? Its end is the larger figure, the limit the one "
        help += "below it"
        if not acts:
            message = f"an effort limit of {shown(limit)} is {format_quantity(ratio, '', 3)} times the {shown(end)} "
            message += "that the motor gives at standstill, where it gives the most"
            help = "look for a wrong unit or power of ten here or in the motor's stall torque"
        where = f"actuators.{joint.group}.effort_limit"
        found = found_at(joint, "SPEC187", where, ratio, message, help, limit, end)
        # What is doubted of the motor itself is told there.
        yield replace(found, derived=True)


def _exchanged(joint: JointActuator, end: Quantity, free: Quantity, limit: Quantity) -> Found:
    """A torque-speed line whose two ends stand in each other's place: the effort limit is the number of the speed."""
    message = (
        f"an effort limit of {shown(limit)} is never reached: the torque-speed line begins at {shown(end)}, at "
        f"standstill, and ends at {shown(free)}"
    )
    torque, speed = format_quantity(free.value, end.unit, 4), format_quantity(end.value, free.unit, 4)
    help = f"are stall_torque and no_load_speed ({free.span}) exchanged? Then they are {torque} and {speed}"
    where = f"motors.{joint.motor}.stall_torque"
    return replace(found_at(joint, "SPEC187", where, 1.0, message, help, end, limit, free), derived=True)


def witness_relations(drive: Drive, output: Output) -> Iterator[Relation]:
    """Figures of a motor, and the limits that the spec states, against the limits of the robot's file."""
    motor, root = drive.motor, ("motors", drive.name)
    to_output = 1.0
    if motor.side == "motor":
        to_output = (output.gear or 0.0) * output.efficiency
    # A winding's stall torque is many times what its drive gives.
    fields = ("peak_torque", "stall_torque") if motor.side == "joint" else ("peak_torque",)
    for witness in drive.witnesses:
        times = (witness.factor or 0.0) * scaled(witness, drive.trains)
        stated = next((limit for limit in drive.limits if limit.path == witness.limit), None)
        given: list[tuple[str, SpecValue, float, Path]] = []
        if stated is not None and (size := stated.value.value):
            given.append((str(stated.path[-1]), stated.value, size, stated.path))
        if witness.speed:
            speed = motor.no_load_speed if motor.curve is None else motor.curve.no_load_speed
            if speed is not None and output.speed and witness.factor:
                place = output.speed_path
                given.append((str(place[-1]), speed, output.speed * times, place))
        elif witness.factor:
            for field in fields:
                torque: SpecValue | None = getattr(motor, field)
                if torque is not None and (size := number(torque)):
                    given.append((field, torque, size * to_output * times, (*root, field)))
        unit, what = witness.unit, "a velocity limit" if witness.speed else "an effort limit"
        for field, value, size, place in given:
            ratio = size / witness.value
            if not 0.0 < ratio < math.inf:
                continue
            far = f"{format_quantity(max(ratio, 1 / ratio), '', 3)} times {'below' if ratio > 1 else 'above'}"
            own = (stated is not None and place == stated.path) or (motor.side == "joint" and times == 1.0)
            there = "" if own else f", {format_quantity(size, unit, 4)} there"
            yield Relation(
                "SPEC184" if witness.speed else "SPEC187",
                ratio,
                (1.0 / WITNESS, WITNESS),
                (SLOWED if witness.speed and place[0] == "actuators" else 1.0 / AGREES, AGREES),
                f"the robot's file gives the joint '{witness.joint}' {what} of "
                f"{format_quantity(witness.value, unit, 4)}, {far} {field} {value.written}{there}",
                place,
                None,
                ((*root, "gear_ratio"), (*root, "side")),
                about=f"witness {witness.joint} {field}",
                witnessed=True,
            )
