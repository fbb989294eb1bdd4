"""What a simulator has to draw for each number of a joint, with the factors multiplied in.

Simulators draw kp, kd, limits and friction; they know no `gains` and no `strength`. Where a number has
more than one range (its own and a factor's), its draw is one range from the least to the largest product.
And what a stack loses of them, with the reasons that several stacks share.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product

from actspec.ir import JointActuator, Level, Randomization
from actspec.laws import TorqueLaw, law_of
from actspec.sampling import FACTORS, FIELDS, drawn_ends, nominal_of, own_ranges, quantity_of, unit_of
from actspec.targets.base import Approximation
from actspec.targets.kit.sizes import held_step_error, static_error, viscous_error
from actspec.units import format_quantity

WHEN = ("interval", "reset", "startup")
"""Times of drawing, the most frequent first: a number with two ranges is drawn at the first."""


@dataclass(frozen=True, slots=True)
class Draw:
    """One number of one joint, drawn.

    Attributes:
        actuator: The joint's actuator.
        field: One of `actspec.sampling.FIELDS`.
        operation: `scale`, `add` or `abs`.
        low: Lower end, or the mean of a gaussian.
        high: Upper end, or the standard deviation of a gaussian.
        distribution: `uniform`, `log_uniform` or `gaussian`.
        when: `startup`, `reset` or `interval`.
        every: Interval [s].
        per: `joint`, `group` or `env`.
        parts: The spec's ranges that are in it.
        nominal: The nominal value; None: unknown.
    """

    actuator: JointActuator
    field: str
    operation: str
    low: float
    high: float
    distribution: str
    when: str
    every: tuple[float, float] | None
    per: str
    parts: tuple[Randomization, ...]
    nominal: float | None

    @property
    def unit(self) -> str:
        """Unit of the field."""
        return unit_of(self.actuator, self.field)

    @property
    def ends(self) -> tuple[float, float]:
        """Least and largest value, a gaussian's at 3 std; all but a bias cut at 0."""
        found = as_abs(self)
        low, high = found.low, found.high
        if found.distribution == "gaussian":
            low, high = found.low - 3.0 * found.high, found.low + 3.0 * found.high
        return (low, high) if self.field == "encoder_bias" else (max(0.0, low), max(0.0, high))

    @property
    def numbers(self) -> tuple[str, float, float, str, str, tuple[float, float] | None]:
        """What an event term takes of it; joints with the same can share one."""
        return (self.operation, self.low, self.high, self.distribution, self.when, self.every)


def draws_of(actuator: JointActuator) -> dict[str, Draw]:
    """The numbers of a joint that are drawn, in the order of `FIELDS`; see `check_ranges` for what must hold."""
    ranges = own_ranges(actuator)
    found = {}
    for field in FIELDS:
        if quantity_of(actuator, field) is None and field != "delay":
            continue
        if actuator.level is Level.ACTUATOR_NET and field in ("kp", "kd"):
            continue
        parts = [ranges[field]] if field in ranges else []
        parts += [ranges[factor] for factor, of in FACTORS.items() if field in of and factor in ranges]
        # The limit of nobody is infinite, and stays so under a factor.
        if parts and not (
            field == "effort_limit" and field not in ranges and nominal_of(actuator, field) is None
        ):
            found[field] = _combined(actuator, field, parts)
    return found


def _combined(actuator: JointActuator, field: str, parts: list[Randomization]) -> Draw:
    nominal = nominal_of(actuator, field)
    first = parts[0]
    when = min((part.when for part in parts), key=WHEN.index)
    every = next((part.every for part in parts if part.when == when), None)
    per = first.per if all(part.per == first.per for part in parts) else "joint"
    draw = Draw(
        actuator, field, first.operation, first.low, first.high, first.distribution, when, every, per,
        tuple(parts), nominal,
    )  # fmt: skip
    if len(parts) == 1:
        return draw
    if draw.operation == "add":
        draw = as_abs(draw)
    kinds = {part.distribution for part in parts}
    if kinds == {"gaussian"}:
        mean = math.prod([draw.low, *(part.low for part in parts[1:])])
        square = math.prod(low**2 + std**2 for low, std in _moments(draw, parts))
        return replace(draw, low=mean, high=math.sqrt(max(0.0, square - mean**2)))
    ends = [as_uniform(draw)] + [as_uniform(replace(draw, low=p.low, high=p.high, distribution=p.distribution))
                                 for p in parts[1:]]  # fmt: skip
    return replace(
        draw,
        low=math.prod(end.low for end in ends),
        high=math.prod(end.high for end in ends),
        distribution="log_uniform" if kinds == {"log_uniform"} else "uniform",
    )


def _moments(draw: Draw, parts: list[Randomization]) -> list[tuple[float, float]]:
    return [(draw.low, draw.high), *((part.low, part.high) for part in parts[1:])]


def as_uniform(draw: Draw) -> Draw:
    """A gaussian as the uniform range of the same mean and standard deviation, mean ∓ √3 std."""
    if draw.distribution != "gaussian":
        return draw
    half = math.sqrt(3.0) * draw.high
    low, high = draw.low - half, draw.low + half
    if draw.field != "encoder_bias":
        floor = -math.inf if draw.operation == "add" else 0.0
        if draw.operation == "add" and draw.nominal is not None:
            floor = -draw.nominal
        low, high = max(floor, low), max(floor, high)
    return replace(draw, low=low, high=high, distribution="uniform")


def as_abs(draw: Draw) -> Draw:
    """The same draw as values; exact for every distribution but log_uniform under `add`, which becomes uniform.

    Raises: ValueError: the nominal is unknown.
    """
    if draw.operation == "abs":
        return draw
    if draw.nominal is None:
        raise ValueError(f"{draw.field}: the nominal is unknown")
    nominal = draw.nominal
    if draw.operation == "scale":
        # A standard deviation scales, as the mean does.
        return replace(draw, operation="abs", low=draw.low * nominal, high=draw.high * nominal)
    if draw.distribution == "gaussian":
        return replace(draw, operation="abs", low=draw.low + nominal)
    return replace(
        draw, operation="abs", low=draw.low + nominal, high=draw.high + nominal, distribution="uniform"
    )


def as_scale(draw: Draw) -> Draw:
    """The same draw as factors on the nominal.

    Raises: ValueError: the nominal is unknown or 0.
    """
    if draw.operation == "scale":
        return draw
    found = as_abs(draw)
    if not found.nominal:
        raise ValueError(f"{draw.field}: the nominal is 0")
    return replace(found, operation="scale", low=found.low / found.nominal, high=found.high / found.nominal)


def stated_range(entry: Randomization, unit: str) -> str:
    """A range as the spec states it: `scale 0.9 to 1.1`, `add gaussian(0 rad, 0.01 rad)`."""
    unit = "1" if entry.operation == "scale" else unit
    low, high = format_quantity(entry.low, unit), format_quantity(entry.high, unit)
    if entry.distribution == "gaussian":
        return f"{entry.operation} gaussian({low}, {high})"
    kind = "" if entry.distribution == "uniform" else f" {entry.distribution}"
    return f"{entry.operation} {low} to {high}{kind}"


# --- what a stack loses ------------------------------------------------------------------------------------


class Losses:
    """Collects the approximations of one stack.

    Attributes:
        target: Name of the target in the spec.
        stack: `isaaclab`, `mjlab` or `playground`; it is the first part of every field.
        items: What was lost so far.
    """

    def __init__(self, target: str, stack: str) -> None:
        self.target, self.stack = target, stack
        self.items: list[Approximation] = []

    def add(
        self, actuator: JointActuator, name: str, asked: str, emitted: str, why: str, error: float | None
    ) -> None:
        """Add one, unless the very same is there."""
        item = Approximation(
            self.target,
            actuator.joint,
            f"{self.stack}.{name}",
            asked,
            emitted,
            why,
            error,
            actuator.effort_limit.unit,
        )
        if item not in self.items:
            self.items.append(item)

    def entry(
        self,
        actuator: JointActuator,
        entry: Randomization,
        emitted: str,
        why: str,
        error: float | None = None,
        more: str = "",
    ) -> None:
        """Add the loss of one of the spec's ranges; `more` is said behind the range."""
        asked = stated_range(entry, unit_of(actuator, entry.field)) + more
        self.add(actuator, entry.field, asked, emitted, why, error)

    def of(self, draw: Draw, emitted: str, why: str, error: float | None = None) -> None:
        """Add the loss of a draw, under the first of its ranges."""
        self.entry(draw.actuator, draw.parts[0], emitted, why, error)

    def dropped(self, draw: Draw, why: str) -> None:
        """A draw that the stack cannot hold: each of its ranges, once."""
        nominal = format_quantity(draw.nominal, draw.unit)
        for entry in draw.parts:
            if entry.field == draw.field:
                self.entry(draw.actuator, entry, f"none: stays {nominal}", why, lost(draw))

    def shared(self, draws: Sequence[Draw]) -> None:
        """Draws that joints should share, in a stack that draws joint by joint."""
        for draw in draws:
            for entry in draw.parts:
                if entry.per != "joint" and (entry.per == "env" or _members(draws, draw) > 1):
                    whole = _WHOLE[entry.per]
                    why = f"the stack draws no number for a whole {whole}; each joint's range is kept"
                    self.entry(draw.actuator, entry, "each joint on its own", why)

    def product(self, draw: Draw) -> None:
        """A draw of more than one range."""
        if len(draw.parts) > 1:
            names = " and ".join(part.field for part in draw.parts)
            self.add(
                draw.actuator,
                draw.field,
                f"the product of {names}",
                f"one {draw.distribution} draw from its least to its largest value",
                "a term draws from one range",
                None,
            )
        if len({part.when for part in draw.parts}) > 1:
            for part in draw.parts:
                if part.when != draw.when:
                    self.entry(draw.actuator, part, f"drawn at {draw.when}", "a number is drawn at one time")


_WHOLE = {"group": "group", "env": "robot"}


def _members(draws: Sequence[Draw], draw: Draw) -> int:
    return sum(other.actuator.group == draw.actuator.group and other.field == draw.field for other in draws)


def law_or_none(actuator: JointActuator) -> TorqueLaw | None:
    """The drive's law; None where it is a network's, or a number of it is unknown."""
    try:
        return law_of(actuator)
    except ValueError:
        return None


def strengthened(law: TorqueLaw, factor: float) -> TorqueLaw:
    """The law with its torque times a factor: gains, limit and torque-speed curve together."""
    curve = law.curve
    return replace(
        law,
        kp=law.kp * factor,
        kd=law.kd * factor,
        effort_limit=law.effort_limit * factor,
        stall_torque=None if law.stall_torque is None else law.stall_torque * factor,
        curve=None if curve is None else (curve[0] * factor, curve[1] * factor, curve[2], curve[3]),
    )


def lost(draw: Draw) -> float | None:
    """Largest difference in torque between the nominal robot and the ends of a draw that a stack leaves out."""
    low, high = draw.ends
    return max((e for e in (_at(draw, low), _at(draw, high)) if e is not None), default=None)


def _at(draw: Draw, value: float) -> float | None:
    actuator, field = draw.actuator, draw.field
    law = law_or_none(actuator)
    if law is None or draw.nominal is None:
        return None
    if field in ("kp", "kd", "effort_limit", "encoder_bias"):
        names = {field: value}
        return _static(law, replace(law, **names))  # type: ignore[arg-type]
    if field in ("friction.coulomb", "friction.static"):
        return abs(value - draw.nominal)
    if field == "friction.viscous":
        return viscous_change(actuator, value - draw.nominal)
    if field == "delay":
        late = abs(value - draw.nominal)
        return held_step_error(law, filtered=law.filter_cutoff is not None, late=late) if late else 0.0
    if field == "friction.stribeck_velocity":
        # Whatever the speed, the friction stays between the kinetic and the static one.
        static = actuator.friction_static
        coulomb = actuator.friction_coulomb.value
        return None if static is None or static.value is None or coulomb is None else static.value - coulomb
    return None


def viscous_change(actuator: JointActuator, change: float) -> float | None:
    """Largest torque of a change of the viscous friction."""
    law = law_or_none(actuator)
    return None if law is None else viscous_error(law, change, actuator.velocity_limit.value)


def factor_error(
    actuator: JointActuator, entry: Randomization, *, limit: bool, capped: bool = False
) -> float | None:
    """Largest torque between what a factor asks for and separate draws of kp, kd and the limit.

    For all ends that kp, kd and the limit may take, the nearest of the laws with one factor throughout, among
    those of the ends. The torque-speed line is not scaled.

    Args:
        actuator: The joint.
        entry: `gains` or `strength`.
        limit: Whether the limit is drawn too.
        capped: Whether the limit never rises above the nominal.
    """
    law = law_or_none(actuator)
    if law is None:
        return None
    low, high = (max(0.0, end) for end in drawn_ends(entry))
    return _factor_error(law, entry.field, low, high, limit, capped)


@lru_cache(maxsize=256)
def _factor_error(law: TorqueLaw, field: str, low: float, high: float, limit: bool, capped: bool) -> float:
    # Joints of a group mostly have one law: each is computed once.
    asked = {f: _with_factor(law, field, f) for f in (low, high)}
    worst = 0.0
    for p, d, cap in product((low, high), (low, high), (low, high) if limit else (1.0,)):
        scale = min(cap, 1.0) if capped else cap
        made = replace(law, kp=law.kp * p, kd=law.kd * d, effort_limit=law.effort_limit * scale)
        worst = max(worst, min(_static(asked[f], made) for f in {p, d, cap} & {low, high}))
    return worst


def _with_factor(law: TorqueLaw, field: str, factor: float) -> TorqueLaw:
    if field == "strength":
        return strengthened(law, factor)
    return replace(law, kp=law.kp * factor, kd=law.kd * factor)


def factor_lost(actuator: JointActuator, entry: Randomization) -> float | None:
    """Largest torque that a factor makes, where a stack leaves it out."""
    law = law_or_none(actuator)
    if law is None:
        return None
    return max(_static(_with_factor(law, entry.field, max(0.0, end)), law) for end in drawn_ends(entry))


@lru_cache(maxsize=256)
def _static(one: TorqueLaw, other: TorqueLaw) -> float:
    """Largest difference of two laws, over the torques that either can have."""
    return max(static_error(one, other.torque), static_error(other, one.torque))


def capped_error(draw: Draw) -> float | None:
    """Largest torque that a limit drawn above the nominal loses where the simulator cuts at the nominal."""
    return None if draw.nominal is None or draw.ends[1] <= draw.nominal else _at(draw, draw.ends[1])
