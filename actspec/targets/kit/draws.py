"""What a simulator has to draw for each number of a joint, with the factors multiplied in.

Simulators draw kp, kd, limits and friction; they know no `gains` and no `strength`. Where a number has
more than one range (its own and a factor's), its draw is one range from the least to the largest product.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from actspec.ir import JointActuator, Level, Randomization
from actspec.sampling import FACTORS, FIELDS, nominal_of, own_ranges, quantity_of, unit_of
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


Draws = dict[str, dict[str, Draw]]
"""Joint to field to its draw."""


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
