"""Corrections of a motor's figures and of the limits of its joints: what people mistype, and what it would be."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

from actspec.diagnostics import Path, listed
from actspec.spec.document import SourceMap
from actspec.spec.models import Motor
from actspec.spec.plausible.currents import (
    NO_LIKELIER,
    REFUTED,
    SPEEDS,
    by_peer,
    constant_slips,
    contradicted,
    gives_stall,
    is_proved_by,
    is_refuted,
    is_tenfold,
    off_by,
    proof,
    speed_slips,
    stalled,
)
from actspec.spec.plausible.drive import (
    GEARED,
    Drive,
    Limit,
    any_number,
    efficiency_of,
    figure_at,
    gear_of,
    number,
    with_figure,
)
from actspec.spec.plausible.driven import AGREES, JUST, SLOWED
from actspec.spec.plausible.gearing import (
    counts_repaired,
    gear_forgotten,
    reductions_repaired,
    stages_repaired,
)
from actspec.spec.plausible.motors import GEAR_INVERSE, is_gear_apart, relations
from actspec.spec.plausible.relations import (
    ALIKE,
    KGF_CM,
    MET,
    OTHER_MOTOR,
    POINT,
    RARE,
    Relation,
    Repair,
    explained,
    explanation,
)
from actspec.spec.plausible.slips import (
    amount_of,
    in_unit,
    inertias,
    kgf_cm,
    milli,
    multiplied,
    slips_of,
    tens,
    thousandth,
    transposed,
)
from actspec.spec.plausible.table import Doubt
from actspec.spec.plausible.together import EXACT, is_exact, together
from actspec.spec.plausible.unexplained import unexplained
from actspec.spec.values import SpecValue
from actspec.units import format_quantity

LARGEST_GEAR = 350.0
"""Of published gears, about."""
POINT_BELOW = 2.0
"""A stall torque that is so many times below another torque may have its point in the wrong place."""
SMALLEST_RADIUS = 3e-3
"""Of a pinion or pulley [m]. Chosen: twelve teeth of module 0.5 have it."""
SWAPPED = 0.2
"""What an exchange of two torques costs beside a wrong unit, as `RARE`."""
SIDED = 0.15
"""What it costs that all torques are those of the other side, and the speed is not, as `RARE`."""
ONE_SIDED = 0.25
"""What it costs that one of several torques is."""
THROUGH = 0.2
"""What it is worth that a torque of the other side is another one of this side, through the gear, as `RARE`."""
ONCE = 1.02
"""A limit at the rotor is told if at the joint it is motor's or file's by this factor: else less may be meant."""
PROVED_COST = 1.0
"""What an exchange of such a torque costs, and a correction to one that its current refutes, as `RARE`."""
PROVED_NOW = 1.05
"""A torque that comes in the place of another by an exchange is what its current gives if they agree by this factor."""
AGREED = 0.4
"""What it costs that a no-load speed is wrong which a velocity limit has, too, to the digit, as `RARE`."""
ODD = 0.4
"""What it costs that a limit is the odd one beside motor and file, where no slip makes it theirs, as `RARE`."""
BY_CURRENT = 0.25
"""What it costs that a torque is what its current gives, where no slip makes it so, as `RARE`."""

TORQUES: tuple[Path, ...] = (
    ("stall_torque",),
    ("peak_torque",),
    ("continuous_torque",),
    ("curve", "drive_torque"),
    ("curve", "brake_torque"),
)


def motor_doubts(drive: Drive, spans: SourceMap) -> Iterator[Doubt]:
    """Everything that can hardly be right about one motor and the limits of its joints.

    Limits of the robot's file, where they are known, tell which of several numbers it is. Of a motor whose figures
    agree with each other they tell only what is in another unit: a limit of a tenth may be meant.
    """
    before = list(relations(drive))
    broken = [relation for relation in before if relation.broken]
    if not broken:
        return
    repairs = list(repairs_of(drive))
    witnessed = all(relation.witnessed for relation in broken)
    if witnessed:
        limits = {limit.path for limit in drive.limits}
        repairs = [item for item in repairs if not item.rare or limits.isdisjoint(item.paths)]
    if all(relation.code == "SPEC183" and not relation.error for relation in broken):
        # It is a large machine's, or a figure with which it is a robot's of a usual size.
        repairs = [one for one in repairs if not any(at.code == "SPEC183" and at.excess for at in one.after)]
    best = explained(before, repairs)
    kept = False
    if best and not drive.sure.isdisjoint(best[0].paths):
        if drive.sure.issuperset(best[0].paths):
            # Of several that may be the wrong one those are left of which nobody is sure; else it is kept.
            best = [repair for repair in best if drive.sure.isdisjoint(repair.paths)] or best
        else:
            best = explained(before, (item for item in repairs if drive.sure.isdisjoint(item.paths)))
            # A speed that is odd beside a number that is right, and by no slip, is as right.
            kept = not best and all(item.code == "SPEC184" and not item.error for item in broken)
    if best:
        rivals = (repair for repair in best[1:] if drive.sure.isdisjoint(repair.paths))
        yield explanation([best[0], *rivals], broken, spans)
    elif not witnessed and drive.witnesses:
        # A limit that meets the robot's file with no figure is offered none.
        known = {spans.value(witness.limit) for witness in drive.witnesses if witness.limit is not None}
        ours = (item for item in before if item.witnessed and item.path[0] == "actuators")
        agreed = {spans.value(item.path) for item in ours if 1.0 / AGREES <= item.value <= AGREES}
        refuted = {spans.value(relation.path): relation.message for relation in broken if relation.witnessed}
        instead = refuted | dict.fromkeys(known, POINT)
        for doubt in motor_doubts(replace(drive, witnesses=()), spans):
            vague = doubt.span is not None and (doubt.help or "").startswith("did you mean")
            if doubt.span in agreed:
                doubt = replace(doubt, help=OTHER_MOTOR)
            elif vague and doubt.span in instead:
                doubt = replace(doubt, help=instead[doubt.span])
            yield doubt
    elif not witnessed and not kept:
        yield from unexplained(drive, broken, spans)


class Misread(NamedTuple):
    """A no-load speed, or a length that makes a speed of it, in another unit.

    Attributes:
        path: Where it is written.
        factor: From the speed that stands, or that the length makes, to what is meant.
        help: The same in words.
        likelier: Whether the motor's figures are more usual with it.
    """

    path: Path
    factor: float
    help: str
    likelier: bool


def misread_speeds(drive: Drive) -> Iterator[Misread]:
    """Readings of a motor's no-load speed in another unit, with which its figures are as usual as they stand.

    Args:
        drive: The motor, with the limits of its joints.
    """
    now = sum(relation.excess for relation in relations(drive))
    for path in SPEEDS:
        speed = figure_at(drive.motor, path)
        if speed is None or not number(speed):
            continue
        for factor, help, rare in slips_of(speed, speed=True):
            after = list(
                relations(replace(drive, motor=with_figure(drive.motor, path, multiplied(speed, factor))))
            )
            excess = sum(relation.excess for relation in after)
            if rare < RARE and excess <= now and not any(relation.broken for relation in after):
                yield Misread(("motors", drive.name, *path), factor, help, excess < now)


def misread_lengths(drive: Drive) -> Iterator[Misread]:
    """Readings of a screw's lead or a pulley's radius in another unit, as `misread_speeds`.

    Args:
        drive: The motor, with the trains to its joints.
    """
    before = list(relations(drive))
    speeds = _train_speeds(before)
    radii = {
        train.place(index): number(stage.radius)
        for train in drive.trains.values()
        for index, stage in enumerate(train.stages)
    }
    now = sum(relation.excess for relation in before)
    for repair in stages_repaired(drive):
        (place,) = repair.paths[:1]
        own = speeds.get(place)
        excess = sum(relation.excess for relation in repair.after)
        if own is None or excess > now or any(relation.broken for relation in repair.after):
            continue
        fast = _train_speeds(repair.after).get(place, own)
        if (radii.get(place) or math.inf) * fast / own < SMALLEST_RADIUS:
            continue
        yield Misread(place, fast / own, repair.help or "", excess < now)


def _train_speeds(found: Iterable[Relation]) -> dict[Path, float]:
    """Speeds behind the stages of a drive's trains, by where such a stage is written [m/s or rad/s]."""
    return {
        item.path: item.value for item in found if item.about.startswith("train (") and item.code == "SPEC184"
    }


def repairs_of(drive: Drive) -> Iterator[Repair]:
    """Every correction of a drive, those before that are preferred where two are equally good."""
    motor, root = drive.motor, ("motors", drive.name)
    gear, broken = gear_of(motor), [relation for relation in relations(drive) if relation.broken]
    yield from _limits(drive)

    def changed(result: Motor, paths: Sequence[Path], help: str, rare: float = 0.0) -> Repair:
        rare += PROVED_COST * any(is_refuted(result, path) for path in paths)
        after = tuple(relations(replace(drive, motor=result)))
        return Repair(after, tuple((*root, *path) for path in paths), help, rare)

    def moved(paths: Sequence[Path], factor: float, help: str, rare: float = 0.0) -> Repair:
        result = motor
        for path in paths:
            result = with_figure(result, path, multiplied(figure_at(motor, path), factor))
        return changed(result, paths, help, rare)

    torques = [path for path in TORQUES if any_number(figure_at(motor, path))]
    # Through a gearbox of which no efficiency is stated a torque is only about so large.
    passed, about = efficiency_of(motor), "" if _is_efficient(motor) else "about "
    there, here = ("gearbox output", "rotor") if motor.side == "motor" else ("rotor", "gearbox output")
    # What a torque that is quoted at the other side is at this one; speeds go the other way.
    across = None
    travels = any(train.root[0] == "motors" for train in drive.trains.values())
    if gear is not None and gear >= GEARED and motor.side is not None and not travels:
        across = 1.0 / gear if motor.side == "motor" else gear
        other = "joint" if motor.side == "motor" else "motor"
        help = f"are the figures those of the {there}? Then write `side: {other}`"
        yield changed(motor.model_copy(update={"side": other}), [("side",)], help)
        constant = motor.torque_constant
        if number(constant):
            # Of a sheet of the other side the constant is often the rotor's, as the current is.
            moves = 1.0 / across * (passed if across < 1.0 else 1.0 / passed)
            there_too = multiplied(constant, moves)
            swapped = motor.model_copy(update={"side": other, "torque_constant": there_too})
            help += f", and torque_constant for that side, {about}{in_unit(there_too)}"
            # With a speed that the voltage does not make there, it is no better explained.
            rare = SIDED + RARE * any(is_refuted(swapped, path) for path in SPEEDS)
            yield changed(swapped, [("side",)], help, rare)

    def sided(path: Path, factor: float, lossy: bool, rare: float = 0.0) -> Repair:
        through = [is_gear_apart(motor, path, other) for other in torques if other != path]
        if any(through):
            # The same number through the gear is no accident.
            rare, lossy = -THROUGH, lossy and 1.0 not in through
        factor *= (passed if factor > 1.0 else 1.0 / passed) if lossy else 1.0
        meant = in_unit(multiplied(figure_at(motor, path), factor))
        help = f"is it quoted at the {there}? At the {here} it is {about if lossy else ''}{meant}"
        return moved([path], factor, help, rare)

    yield from gear_forgotten(drive, moved)
    if number(motor.gear_ratio) and motor.gear_ratio is not None:
        ratio, turned = motor.gear_ratio.value or 1.0, False
        if ratio < 1.0:
            help = GEAR_INVERSE.format(format_quantity(1 / ratio, "", 3))
            inverse = moved([("gear_ratio",)], 1.0 / ratio / ratio, help)
            yield inverse
            turned = not any(relation.broken for relation in inverse.after)
        numbers = re.findall(r"\d+(?:\.\d+)?", drive.name)
        if f"{ratio:g}" in numbers:
            # AK80-9: the size of the motor stands before its gear.
            for other in {size for size in numbers if float(size) not in (0.0, ratio)}:
                help = f"did you mean {other}, the other number of '{drive.name}'?"
                yield moved([("gear_ratio",)], float(other) / ratio, help)
        if ratio != 1.0 and not turned:
            # A direct drive, or what is sound the other way round, is no gear with its point in the wrong place.
            yield from (moved([("gear_ratio",)], *slip) for slip in tens(motor.gear_ratio))
    if number(motor.efficiency) and motor.efficiency is not None:
        yield from (moved([("efficiency",)], *slip) for slip in tens(motor.efficiency))
    for path in SPEEDS:
        speed = figure_at(motor, path)
        if speed is not None and speed.value:
            agreed, fast = AGREED * _limits_speed(drive), list(speed_slips(motor, speed))
            yield from (moved([path], factor, help, rare + agreed) for factor, help, rare in fast)
            if across is not None:
                # What constant and voltage make of ten times as much is no matter of the side.
                tenfold = any(factor == 10.0 and rare == 0.0 for factor, _, rare in fast)
                yield sided(path, 1.0 / across, lossy=False, rare=ALIKE * tenfold)
    yield from stages_repaired(drive)
    yield from counts_repaired(drive)
    yield from reductions_repaired(drive)
    if number(motor.nominal_current) and number(motor.peak_current):
        update = {"nominal_current": motor.peak_current, "peak_current": motor.nominal_current}
        help = "are nominal_current and peak_current swapped? The thermal limit is the lower one"
        yield changed(motor.model_copy(update=update), [("nominal_current",), ("peak_current",)], help)
        both: list[Path] = [("nominal_current",), ("peak_current",)]
        for factor, help, rare in slips_of(_given(motor, ("peak_current",))):
            named = help.replace("is it in", "are nominal_current and peak_current in")
            if rare and help.startswith("did you mean "):
                named = f"are nominal_current and peak_current {_too(factor)}? Then peak_current is "
                named += help.removeprefix("did you mean ").removesuffix("?")
            if named != help:
                # Of two explanations the one of a single number is likelier.
                yield moved(both, factor, named, rare + ALIKE)
    yield from stalled(motor, moved)
    for field in ("torque_constant", "peak_current", "nominal_current", "nominal_voltage"):
        value: SpecValue | None = getattr(motor, field)
        if value is not None and any_number(value):
            slips = [by_peer(motor, field, slip) for slip in slips_of(value)]
            if field == "torque_constant":
                slips = list(constant_slips(motor, value, None if across is None else gear))
            yield from _apart((slip[0], moved([(field,)], *slip)) for slip in slips)
            if field == "torque_constant" and across is not None:
                # What the current proves is no matter of the side.
                factor = across * (passed if across > 1.0 else 1.0 / passed)
                ours = not any(is_proved_by(motor, slip[0]) for slip in slips) or is_proved_by(motor, factor)
                rare = 0.0 if ours else RARE + SIDED
                if gives_stall(motor):
                    rare = max(rare, RARE + NO_LIKELIER)
                costs = off_by(motor, factor), off_by(motor, across)
                lossy = costs[0] <= costs[1]
                # What is just that through a gear which is no power of ten is no accident.
                just = 0.0 < min(costs) < math.log10(MET) and not is_tenfold(across)
                rare += contradicted(motor, factor if lossy else across) - THROUGH * just
                yield sided((field,), across, lossy, rare)
    plain = [path for path in torques if len(path) == 1]
    for one, two in itertools.combinations(plain, 2):
        result = with_figure(with_figure(motor, one, figure_at(motor, two)), two, figure_at(motor, one))
        shares = [(proof(motor, str(path[0])), proof(result, str(path[0]))) for path in (one, two)]
        # By its own current it was the right one, or the other is not.
        against = any(
            was and now and abs(math.log(now)) >= min(abs(math.log(was)), math.log(PROVED_NOW))
            for was, now in shares
        )
        cost = SWAPPED + PROVED_COST * against
        help = f"are {one[-1]} and {two[-1]} swapped?"
        below = (_given(motor, two).value or 0.0) / (_given(motor, one).value or math.inf)
        if one == ("stall_torque",) and below > POINT_BELOW:
            # The line's own end may be the one with its point in the wrong place.
            tenth = moved([one], 10.0, "")
            meant = in_unit(multiplied(_given(motor, one), 10.0))
            help += (
                "" if any(item.broken for item in tenth.after) else f" Or stall_torque: did you mean {meant}?"
            )
        yield changed(result, [one, two], help, cost)
    stall, free = motor.stall_torque, motor.no_load_speed
    if number(stall) and number(free) and stall is not None and free is not None:
        force, speed_of = replace(stall, value=free.value), replace(free, value=stall.value)
        if stall.written.endswith(_bare(stall)) and free.written.endswith(_bare(free)):
            update = {"stall_torque": force, "no_load_speed": speed_of}
            help = f"are the two exchanged? Then stall_torque is {in_unit(force)}, no_load_speed {in_unit(speed_of)}"
            yield changed(
                motor.model_copy(update=update), [("stall_torque",), ("no_load_speed",)], help, SWAPPED
            )
    for path in torques:
        given = _given(motor, path)
        for digits in transposed(given):
            # Of many pairs of digits one may fit by accident, but hardly to the digit.
            repair = moved([path], digits / (given.value or 1.0), "")
            if any(
                item.witnessed and item.path == (*root, *path) and 1.0 / EXACT < item.value < EXACT
                for item in repair.after
            ):
                meant = in_unit(replace(given, value=digits))
                help = f"are two digits exchanged? With {meant} it is what the robot's file has"
                yield replace(repair, help=help)
        if given.unit == "N*m" and "kgf" not in given.written:
            # A point in the wrong place is so near that only what agrees exactly tells.
            servo = moved([path], KGF_CM, kgf_cm(given), SWAPPED)
            if is_exact(servo):
                yield servo
        slips = list(slips_of(given))
        yield from _apart((slip[0], moved([path], *slip)) for slip in slips)
        share = proof(motor, str(path[-1]))
        # Else it may as well be constant or current.
        told = any(item.code != "SPEC181" and item.path == (*root, *path) for item in broken)
        factors = [across or 1.0, *(slip[0] for slip in slips)]
        if share and told and not any(1.0 / REFUTED <= share / factor <= REFUTED for factor in factors):
            current = "peak_current" if path[-1] == "peak_torque" else "nominal_current"
            help = f"torque_constant and {current} give {in_unit(multiplied(given, share))}"
            yield moved([path], share, help, BY_CURRENT)
        if across is not None and len(plain) > 1 and path in plain:
            yield sided(path, across, lossy=True, rare=ONE_SIDED)
    if (
        torques
        and any_number(motor.torque_constant)
        and any(item.code in ("SPEC181", "SPEC183") for item in broken)
    ):
        every = listed([str(path[-1]) for path in (*torques, ("torque_constant",))], 6)
        help = (
            f"are {every} in {thousandth(_given(motor, torques[0]).unit)}? {milli(_given(motor, torques[0]))}"
        )
        yield moved([*torques, ("torque_constant",)], 1e-3, help)
    if torques:
        if across is not None:
            factor = across * (passed if across > 1.0 else 1.0 / passed)
            # Without a speed all figures of the side are torques: `side` is no likelier.
            alone = not any(number(figure_at(motor, path)) for path in SPEEDS)
            sides = [(torques, 0.0 if alone else SIDED)]
            # An actuator's sheet has what it gives, and that of its winding the line.
            driven: list[Path] = [path for path in plain if path[-1] != "stall_torque"]
            sides += [(driven, ONE_SIDED)] if 1 < len(driven) < len(torques) else []
            for paths, rare in sides:
                which = f" ({listed([str(path[-1]) for path in paths], 5)})" if len(torques) > 1 else ""
                shown = _given(motor, paths[0])
                meant = f"{in_unit(shown)} is {about}{in_unit(multiplied(shown, factor))}"
                help = f"is it quoted at the {there}{which}? At the {here} {meant}"
                yield moved(paths, factor, help, rare)
        yield from together([_given(motor, path) for path in torques], torques, motor, moved)
    for field in ("rotor_inertia", "reflected_inertia"):
        inertia: SpecValue | None = getattr(motor, field)
        if inertia is None or not number(inertia):
            continue
        in_other = amount_of(inertia)[1] not in ("", inertia.unit)
        made = [moved([(field,)], *slip) for slip in inertias(inertia)]
        fits = [
            repair for repair in made if not repair.rare and not any(item.broken for item in repair.after)
        ]
        if in_other and fits:
            # Whoever writes a unit has the point where the sheet has it.
            made = fits
        if field == "rotor_inertia" and across is not None:
            # No slip of an inertia is more usual; behind a gear of 100 it is just what kg*cm^2 are.
            help = "is it the inertia at the output? Then write `reflected_inertia`"
            rare = RARE + SIDED if in_other and fits else 0.0
            update = {field: None, "reflected_inertia": inertia}
            yield changed(motor.model_copy(update=update), [(field,)], help, rare)
        yield from made
        if field == "reflected_inertia" and gear is not None and gear >= GEARED and not travels:
            help = "is it the rotor's own, before the gear? Then write `rotor_inertia`"
            yield changed(motor.model_copy(update={field: None, "rotor_inertia": inertia}), [(field,)], help)
        elif field == "reflected_inertia" and gear is None:
            yield from _unknown_gear(drive, moved)


def _limits_speed(drive: Drive) -> bool:
    """Whether a velocity limit of the joints is just the motor's speed."""
    limits = {f"{limit.path}" for limit in drive.limits if limit.path[-1] == "velocity_limit"}
    return any(
        item.about in limits and math.isclose(item.value, 1.0, rel_tol=JUST) for item in relations(drive)
    )


def _bare(value: SpecValue) -> str:
    """The end of a number that is written without a unit, or in SI."""
    return f" {value.unit}" if " " in value.written else value.written


def _is_efficient(motor: Motor) -> bool:
    """Whether an efficiency of the gearbox is stated."""
    stages = [stage.efficiency for stage in motor.gearbox or ()]
    return any(number(value) is not None for value in (motor.efficiency, *stages))


def _unknown_gear(drive: Drive, moved: Callable[..., Repair]) -> Iterator[Repair]:
    """An inertia at the output that is the rotor's, if a gear of a usual size makes it a usual one."""
    for relation in relations(drive):
        if relation.code == "SPEC185" and relation.path[-1] == "reflected_inertia" and not relation.about:
            turned = relation.value / math.sqrt(math.prod(relation.usual))
            if GEARED**2 <= turned <= LARGEST_GEAR**2:
                help = "is it the rotor's own, on the other side of the gear? At the output it is that times the "
                help += "gear ratio squared; or look for a wrong unit"
                yield moved([("reflected_inertia",)], turned, help, SIDED)


def _too(factor: float) -> str:
    """Ten times too large, or a hundred times too small."""
    return f"{max(factor, 1.0 / factor):g} times too {'large' if factor < 1.0 else 'small'}"


def _apart(made: Iterable[tuple[float, Repair]]) -> Iterator[Repair]:
    """Corrections of one number by their factors; none in kgf*cm where a tenth, which is 2 % apart, agrees exactly."""
    made = list(made)
    tenth = any(factor == 0.1 and is_exact(repair) for factor, repair in made)
    yield from (repair for factor, repair in made if not tenth or factor != KGF_CM)


def _limits(drive: Drive) -> Iterator[Repair]:
    """Corrections of the limits of the joints.

    Where the robot's file has what the motor gives, a limit that has neither is the odd one of three.
    """
    told = {
        item.about for item in relations(drive) if item.witnessed and 1.0 / AGREES <= item.value <= AGREES
    }
    for index, limit in enumerate(drive.limits):

        def changed(
            value: SpecValue, help: str, rare: float, index: int = index, limit: Limit = limit
        ) -> Repair:
            limits = (*drive.limits[:index], replace(limit, value=value), *drive.limits[index + 1 :])
            return Repair(tuple(relations(replace(drive, limits=limits))), (limit.path,), help, rare)

        fast = limit.path[-1] == "velocity_limit"
        fields = ("no_load_speed",) if fast else ("peak_torque", "stall_torque")
        agreed = {
            witness.value
            for witness in drive.witnesses
            if witness.limit == limit.path
            and not told.isdisjoint(f"witness {witness.joint} {field}" for field in fields)
        }
        turns = (gear_of(drive.motor) or 0.0) * limit.reduction
        if turns >= GEARED and limit.train is None:
            value = multiplied(limit.value, 1.0 / turns if fast else turns * efficiency_of(drive.motor))
            help = f"is it quoted at the rotor? At the joint it is {in_unit(value)}"
            if 1.0 / EXACT < turns / 10.0 ** round(math.log10(turns)) < EXACT:
                help += f"; or {POINT}"
            repair = changed(value, help, SIDED)
            if any(item.path == limit.path and 1.0 / ONCE < item.value < ONCE for item in repair.after):
                yield repair
                continue
            if not fast:
                once = multiplied(limit.value, 1.0 / turns)
                repair = changed(once, f"is the gear counted twice? Once it is {in_unit(once)}", SIDED)
                if any(item.path == limit.path and 1.0 / ONCE < item.value < ONCE for item in repair.after):
                    yield repair
                    continue
        made = []
        for factor, help, rare in slips_of(limit.value, fast):
            value = multiplied(limit.value, factor)
            # A speed is often limited below the motor's.
            least = SLOWED if fast and rare < RARE else 1.0 / AGREES
            if not agreed or any(least <= (value.value or 0.0) / size <= AGREES for size in agreed):
                made.append((factor, changed(value, help, rare)))
        yield from _apart(made)
        for size in sorted(agreed):
            meant = replace(limit.value, value=size)
            help = f"did you mean {in_unit(meant)}? The motor and the robot's file agree on that"
            yield replace(changed(meant, help, ODD), fitted=True)


def _given(motor: Motor, path: Path) -> SpecValue:
    """A figure that is stated."""
    value = figure_at(motor, path)
    assert value is not None
    return value
