"""What torque constant, currents and voltage of a motor imply of each other, and what is meant where they do not."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

from actspec.diagnostics import Path, listed
from actspec.spec.models import Motor
from actspec.spec.plausible.drive import LEAST_DRIVEN, figure_at, number, output_of
from actspec.spec.plausible.driven import CURRENT_RATIO
from actspec.spec.plausible.relations import DEGREE, MET, RARE, RPM, Relation, Repair
from actspec.spec.plausible.slips import SERVO, amount_of, in_unit, multiplied, servo_time, slips_of
from actspec.spec.values import SpecValue
from actspec.units import format_quantity

ROUNDING = 1.02
"""Two figures of a datasheet may differ by this much and be the same."""
VOLTAGE_RATIO = (0.2, 3.0)
"""Torque constant times no-load speed, over the voltage."""
KV_OFF = 1.6
"""A constant that is so many times off, either way, may be a speed constant: the
inverse of its number, which agrees then, tells that from phases and amplitudes, which make up to 1.73."""
ONE_FACTOR = 1.15
"""Currents and voltage say the same of it by this factor, and it is what the inverse of the number makes."""
PAIRS = 3
"""Pairs of figures that make a constant: of two currents and of the voltage."""
OF_PHASE = 1.06
"""By this factor all three make the root of three. Chosen: of an EC 90 flat they make 1.67 to 1.74 then."""
PROVED = 1.25
"""A torque is what its current gives if they agree by this factor; then it was not exchanged for another."""
REFUTED = 2.0
"""A torque is not what its current gives beyond this factor: amplitudes, phases and saturation make so much."""
OF_KV = 1.01
"""A no-load speed is Kv times the voltage by this factor: both are rounded to three digits. From mN*m/A, which near 98
is the same, nothing else tells it."""
REACHED = (0.4, 1.35)
"""A no-load speed, corrected, over what voltage and constant give: nearly all of it is reached, and hardly more.
Published: 1.29 (AK70-10: 0.123 N*m/A, 4800 rpm, 48 V; its KV of 100 gives 0.0955)."""
AGAINST = 8.0
"""What it costs that currents or voltage are farther than that from a constant, as `RARE`, a power of ten."""
SECOND = 0.05
"""What the second of two readings of a speed costs of which nothing tells which it is, as `RARE`."""
STALLED = 1.05
"""A current gives the stall torque by this factor."""
NO_LIKELIER = 0.01
"""What it costs, beyond a wrong point, that a constant is wrong which with its current gives the stall torque: the
voltage stands first then, and a winding's stall torque may be any."""
NEARLY_TEN = 1.2
"""A gear is about ten by this factor: nothing tells it from a wrong point."""
SPEEDS: tuple[Path, ...] = (("no_load_speed",), ("curve", "no_load_speed"))
"""Where a no-load speed is written in a motor."""
CURRENTS = (0.1, 200.0)
VOLTAGES = (3.0, 120.0)
"""Of drives of robots [A, V]. Chosen: from hobby servos to humanoids."""
FED = 100.0
"""Power without losses over the voltage that drives of robots' direct motors have [A]. Published: 60 (U15 II)."""
ANY_CURRENT = (5e-3, 2000.0)
ANY_VOLTAGE = (1.0, 1000.0)
"""Of any motor [A, V]. Chosen: from micro motors to those of vehicles."""


def constant_relations(name: str, motor: Motor) -> Iterator[Relation]:
    """Torque constant times current is a torque, times speed a voltage."""
    path: Path = ("motors", name)
    constant = motor.torque_constant
    travels = constant is not None and bool(constant.linear)
    # Of a winding the stall torque is many times what the drive's current gives.
    high, usual_of_winding = CURRENT_RATIO[1], (0.02, 2.0)
    for field, product, key, bounds, usual in (
        ("peak_current", "gives", "peak_torque", CURRENT_RATIO, (0.5, 2.0)),
        ("nominal_current", "gives", "continuous_torque", CURRENT_RATIO, (0.5, 2.0)),
        ("peak_current", "gives", "stall_torque", (LEAST_DRIVEN, high), usual_of_winding),
        ("nominal_current", "gives", "stall_torque", (0.0, high), usual_of_winding),
        ("no_load_speed", "needs", "nominal_voltage", VOLTAGE_RATIO, (0.3, 2.0)),
    ):
        factor: SpecValue | None = getattr(motor, field)
        other: SpecValue | None = getattr(motor, key)
        share = _share(constant, factor, other)
        if constant is None or factor is None or other is None or share is None:
            continue
        kind = "force" if travels else "torque"
        made = format_quantity(share * (other.value or 0.0), other.unit, 3)
        yield Relation(
            "SPEC181",
            share,
            bounds,
            usual,
            f"a {kind} constant of {constant.written} {product} {made} at {field} {factor.written}, and {key} is "
            f"{other.written}",
            (*path, "torque_constant"),
            f"{kind} = {kind} constant x current, voltage = {kind} constant x speed",
            ((*path, field), (*path, key)),
        )
    yield from _inverse(path, motor)
    nominal, peak = number(motor.nominal_current), number(motor.peak_current)
    if nominal and peak and motor.nominal_current is not None and motor.peak_current is not None:
        yield Relation(
            "SPEC181",
            nominal / peak,
            (0.0, ROUNDING),
            (0.0, ROUNDING),
            f"nominal_current {motor.nominal_current.written} is above peak_current {motor.peak_current.written}",
            (*path, "nominal_current"),
            "are the two swapped? The thermal limit is the lower one",
            ((*path, "peak_current"),),
            about="currents",
        )
    # Which of two factors is the wrong one is told by its own size.
    for field, sizes, (low, high), unit in (
        ("peak_current", CURRENTS, ANY_CURRENT, "A"),
        ("nominal_current", CURRENTS, ANY_CURRENT, "A"),
        ("nominal_voltage", VOLTAGES, ANY_VOLTAGE, "V"),
    ):
        given: SpecValue | None = getattr(motor, field)
        value = number(given)
        if value and given is not None:
            yield Relation(
                "SPEC181",
                value,
                (low, high),
                sizes,
                f"{field} {given.written}: motors of robots have {low:g} to {format_quantity(high, unit)}",
                (*path, field),
                None,
            )


def _share(constant: SpecValue | None, factor: SpecValue | None, other: SpecValue | None) -> float | None:
    """A constant times one figure over another; None: one is unknown, or one turns and another travels."""
    if constant is None or factor is None or other is None:
        return None
    if len({constant.linear, factor.linear, other.linear} - {None}) > 1:
        return None
    if not constant.value or not factor.value or not other.value:
        return None
    return constant.value * factor.value / other.value


def by_kv(motor: Motor) -> float | None:
    """The constant of a speed constant that stands in its place, in rpm/V: the number as it is written [N*m/A]."""
    constant = motor.torque_constant
    amount = 0.0 if constant is None or not number(constant) else amount_of(constant)[0]
    return 1.0 / RPM / amount if amount > 0.0 else None


def told_of(motor: Motor) -> list[tuple[float, str, str]]:
    """What currents and voltage say of a torque constant: it over what they make, and of which two figures."""
    found = []
    for field, key in (
        ("nominal_current", "continuous_torque"),
        ("peak_current", "peak_torque"),
        ("no_load_speed", "nominal_voltage"),
    ):
        share = _share(motor.torque_constant, getattr(motor, field), getattr(motor, key))
        if share is not None:
            found.append((share, field, key))
    return found


def off_by(motor: Motor, factor: float = 1.0) -> float:
    """How far a torque constant, so many times as large, is at most from what currents and voltage make [powers of
    ten]; 0 where they make none."""
    return max((abs(math.log10(share * factor)) for share, _, _ in told_of(motor)), default=0.0)


def contradicted(motor: Motor, factor: float) -> float:
    """What a torque constant that is so many times as large costs, by what currents and voltage say, as `RARE`."""
    return AGAINST * max(0.0, off_by(motor, factor) - math.log10(REACHED[1]))


def is_at_rotor(motor: Motor) -> bool:
    """Whether the motor's figures are those of its rotor."""
    return motor.side == "motor" or (motor.gearbox is None and number(motor.gear_ratio) == 1.0)


def _inverse(path: Path, motor: Motor) -> Iterator[Relation]:
    """A torque constant that is off by one factor for currents and voltage: the inverse of its number is not, or it is
    that of a phase."""
    meant, constant = by_kv(motor) if is_at_rotor(motor) else None, number(motor.torque_constant)
    told, off = told_of(motor), phase_factor(motor)
    if not constant or motor.torque_constant is None or len(told) < 2 or told[-1][1] != "no_load_speed":
        return
    if meant and not 1.0 / KV_OFF < (own := constant / meant) < KV_OFF:
        off = own if all(1.0 / ONE_FACTOR < share / own < ONE_FACTOR for share, _, _ in told) else off
    if off is not None:
        pairs = listed([f"{field} and {key}" for _, field, key in told], 3)
        yield Relation(
            "SPEC181",
            off,
            (1.0 / KV_OFF, KV_OFF),
            (1.0 / KV_OFF, KV_OFF),
            f"a torque constant of {motor.torque_constant.written} is {format_quantity(max(off, 1.0 / off), '', 3)} "
            f"times too {'large' if off > 1.0 else 'small'} for each of {pairs}",
            (*path, "torque_constant"),
            None,
            about="kv",
        )


def phase_factor(motor: Motor) -> float | None:
    """The root of three, or its inverse, if both currents and the voltage say that the constant is that of another
    number of phases; None: they do not."""
    told = told_of(motor)
    for off in (math.sqrt(3.0), 1.0 / math.sqrt(3.0)) if len(told) == PAIRS else ():
        if all(1.0 / OF_PHASE < share / off < OF_PHASE for share, _, _ in told):
            return off
    return None


def proof(motor: Motor, field: str) -> float | None:
    """What the motor's constant gives of the current that belongs to a torque, over the torque."""
    current = {"peak_torque": motor.peak_current, "continuous_torque": motor.nominal_current}.get(field)
    return None if current is None else _share(motor.torque_constant, current, figure_at(motor, (field,)))


def _is_proved(motor: Motor, field: str) -> bool:
    """Whether a torque is what the motor's constant gives of the current that belongs to it."""
    share = proof(motor, field)
    return share is not None and 1.0 / PROVED <= share <= PROVED


def _share_reached(motor: Motor, path: Path) -> float | None:
    """A no-load speed over what voltage and constant give; None: one of them is unknown."""
    return _share(motor.torque_constant, figure_at(motor, path), motor.nominal_voltage)


def is_reached(motor: Motor) -> bool:
    """Whether the motor's no-load speed is what its voltage and constant give."""
    shares = [_share_reached(motor, path) for path in SPEEDS]
    return any(share is not None and REACHED[0] <= share <= REACHED[1] for share in shares)


def is_fed(motor: Motor, watts: float) -> bool:
    """Whether a drive of the motor's voltage has the current for a power [W]."""
    volts = number(motor.nominal_voltage)
    return volts is not None and watts <= FED * volts


def is_refuted(motor: Motor, path: Path) -> bool:
    """Whether a figure is not what the motor's constant gives of its current, or of the voltage."""
    if path in SPEEDS:
        made = _share_reached(motor, path)
        return made is not None and not REACHED[0] <= made <= REACHED[1]
    share = proof(motor, str(path[-1]))
    return share is not None and not 1.0 / REFUTED <= share <= REFUTED


def is_proved_by(motor: Motor, factor: float) -> bool:
    """Whether a torque is what the motor's constant, so many times as large, gives of its current."""
    constant = multiplied(motor.torque_constant, factor)
    other = motor.model_copy(update={"torque_constant": constant})
    return any(_is_proved(other, field) for field in ("peak_torque", "continuous_torque"))


def gives_stall(motor: Motor) -> bool:
    """Whether the motor's constant gives about the stall torque of its peak current."""
    share = _share(motor.torque_constant, motor.peak_current, motor.stall_torque)
    return share is not None and CURRENT_RATIO[0] <= share <= CURRENT_RATIO[1]


def stalled(motor: Motor, moved: Callable[..., Repair]) -> Iterator[Repair]:
    """A peak current that gives the stall torque of the winding, where the drive's peak is another."""
    ampere, share = motor.peak_current, proof(motor, "peak_torque")
    end = _share(motor.torque_constant, ampere, motor.stall_torque)
    if share and end and 1.0 / STALLED < end < STALLED and share > CURRENT_RATIO[1]:
        meant = in_unit(multiplied(ampere, 1.0 / share))
        help = f"is it the stall current? It gives stall_torque by torque_constant, and peak_torque is that of {meant}"
        yield moved([("peak_current",)], 1.0 / share, help)


def by_peer(motor: Motor, field: str, slip: tuple[float, str, float]) -> tuple[float, str, float]:
    """A current with its point moved, not alone where the other current of the sheet, or else its torque, is exact."""
    torques = {"peak_current": "peak_torque", "nominal_current": "continuous_torque"}
    factor, help, rare = slip
    if field not in torques or rare < RARE or not help.startswith("did you mean"):
        return slip
    own = proof(motor, torques[field])
    (other,) = (proof(motor, torque) for current, torque in torques.items() if current != field)
    exact = PROVED if other is None else MET
    if not own or 1.0 / exact <= own * factor / (other or 1.0) <= exact:
        return slip
    meant = in_unit(multiplied(getattr(motor, field), 1.0 / own))
    told = f"torque_constant and {torques[field]} give {meant}"
    if field == "nominal_current" and factor > 1.0:
        told += ": is it the current without load?"
    # Without another current the constant may be one of phases or amplitudes, and the point alone be wrong.
    return factor, told if other is not None else f"{told}{'' if told.endswith('?') else ';'} Or {help}", rare


def speed_slips(motor: Motor, speed: SpecValue) -> Iterator[tuple[float, str, float]]:
    """Slips in a no-load speed, and a Kv in its place; what constant and voltage tell decides between those alike.

    In rad/s a speed in rpm is 9.55 times as much, with its point moved ten times.
    """
    (amount, unit), constant, volts = (
        amount_of(speed),
        number(motor.torque_constant),
        number(motor.nominal_voltage),
    )
    size = speed.value or 0.0
    share = constant * size / volts if constant and volts else None
    tenfold = (
        share is not None
        and 10.0 * share <= ROUNDING
        and abs(math.log(10.0 * share)) < abs(math.log(share / RPM))
    )
    by_volts = 0.0 if share is None or volts is None else share * volts
    just = (
        1.0 / ROUNDING < by_volts < ROUNDING and not 1.0 / NEARLY_TEN <= (volts or 0.0) / 10.0 <= NEARLY_TEN
    )
    if (
        is_at_rotor(motor)
        and 1.0 / REACHED[1] < by_volts < REACHED[1]
        and unit
        and volts
        and motor.nominal_voltage is not None
    ):
        help = f"is it Kv? {amount:g} {unit}/V x {motor.nominal_voltage.written} is {_in_own(speed, volts)}"
        yield volts, help, 0.0 if just else SECOND
    timed = servo_time(size) if unit in ("", "rad/s") else None
    if timed is not None and not is_at_rotor(motor) and 0.0 < (output_of("", motor).torque or 0.0) < SERVO:
        yield timed[0] / size, timed[1], 0.0
    for factor, help, rare in slips_of(speed, speed=True):
        if factor == DEGREE and is_at_rotor(motor):
            # No sheet has a rotor's speed in degrees.
            continue
        if unit == "rpm" and rare == RARE and factor == 10.0:
            help, rare = f"did you mean {_in_own(speed, factor)}?", 0.0 if tenfold else SECOND
        elif unit == "rpm" and rare == 0.0:
            rare = SECOND * tenfold
        # Of what is Kv to the digit nothing else is as likely.
        yield factor, help, rare + RARE * just


def _in_own(speed: SpecValue, factor: float) -> str:
    """A speed as it would be with another factor, in the unit that it is written in."""
    amount, unit = amount_of(speed)
    meant = in_unit(multiplied(speed, factor))
    return meant if unit in ("", speed.unit) else f"{format_quantity(amount * factor, unit, 4)} ({meant})"


def is_tenfold(factor: float) -> bool:
    """Whether nothing tells a factor from a point in the wrong place."""
    return 1.0 / NEARLY_TEN < factor / 10.0 ** round(math.log10(factor)) < NEARLY_TEN


def or_twice(value: SpecValue, gear: float, slip: tuple[float, str, float]) -> tuple[float, str, float]:
    """A constant with its point moved, where the gear, counted twice, is about as much."""
    factor, help, rare = slip
    if not rare or not 1.0 / NEARLY_TEN < factor * gear < NEARLY_TEN:
        return slip
    return (
        factor,
        f"{help}; or is the gear in it twice? Then it is {in_unit(multiplied(value, 1.0 / gear))}",
        rare,
    )


def constant_slips(motor: Motor, value: SpecValue, gear: float | None) -> Iterator[tuple[float, str, float]]:
    """Slips in a motor's torque constant, and a Kv in its place.

    Args:
        motor: The motor.
        value: Its constant.
        gear: The gear that may be in it; None: it has none, or none is known.
    """
    off = phase_factor(motor)
    from_kv = of_kv(motor) if off is None and is_at_rotor(motor) else None
    own, by_volt = value.value or 1.0, 1.0 / (amount_of(value)[0] or math.inf)
    if from_kv:
        help = "is it Kv, in rpm/V? Then the constant is 60 / (2 pi Kv), "
        yield from_kv / own, help + format_quantity(from_kv, value.unit, 3), 0.0
    elif is_at_rotor(motor) and 0.0 < off_by(motor, by_volt / own) < math.log10(PROVED):
        help = f"is it Kv, in rad/s/V? Then the constant is 1 / Kv, {format_quantity(by_volt, value.unit, 3)}"
        yield by_volt / own, help, SECOND
    if off is not None:
        meant = format_quantity(own / off, value.unit, 3)
        help = (
            "is it that of a phase, and the currents and voltage of two terminals, or the other way round? "
        )
        yield 1.0 / off, f"{help}With those it is {meant}", 0.0
    for slip in slips_of(value):
        factor, help, rare = slip if gear is None else or_twice(value, gear, slip)
        if from_kv and factor == 1e-3:
            continue
        rare = max(rare, RARE + NO_LIKELIER) if gives_stall(motor) else rare
        yield factor, help, rare + contradicted(motor, factor)


def of_kv(motor: Motor) -> float | None:
    """The constant [N*m/A] of a Kv in its place, if by it the currents give the torques.

    Less so in mN*m/A, unless Kv times the voltage is the no-load speed.
    """
    own, meant = number(motor.torque_constant), by_kv(motor)
    shares = [share for field in ("peak_torque", "continuous_torque") if (share := proof(motor, field))]
    if not own or not meant or not shares:
        return None
    off = [max(abs(math.log(share * factor)) for share in shares) for factor in (meant / own, 1e-3)]
    speed, voltage = number(motor.no_load_speed), number(motor.nominal_voltage)
    # No-load speed of a sheet is just Kv times voltage.
    just = speed and voltage and 1.0 / OF_KV < meant * speed / voltage < OF_KV
    return meant if off[0] < math.log(PROVED) and (just or off[0] < off[1]) else None
