"""Rules of `randomize`."""

from __future__ import annotations

from collections.abc import Mapping

from actspec.spec.models import Randomize
from actspec.spec.paths import Path
from actspec.spec.rules.breaches import Breaches
from actspec.spec.values import Fault, Pair, SpecValue, pair_or_fault
from actspec.units import Kind

RANDOMIZED_KINDS: Mapping[str, Kind] = {
    "kp": Kind.STIFFNESS,
    "kd": Kind.VELOCITY_GAIN,
    "gains": Kind.RATIO,
    "strength": Kind.RATIO,
    "effort_limit": Kind.TORQUE,
    "armature": Kind.INERTIA,
    "friction.coulomb": Kind.TORQUE,
    "friction.viscous": Kind.VELOCITY_GAIN,
    "friction.static": Kind.TORQUE,
    "friction.stribeck_velocity": Kind.SPEED,
    "encoder_bias": Kind.POSITION,
    "delay": Kind.TIME,
}
"""Quantity kind of `add` and `abs` of each field."""
UNFITTED = ("gains", "strength", "effort_limit")
"""Fields of which no identification gives a range."""


def check_randomize(path: Path, field: str, entry: Randomize, breaches: Breaches) -> None:
    """One range, with what belongs to it, of numbers that the field can have."""
    given = [key for key in ("scale", "add", "abs") if getattr(entry, key) is not None]
    if entry.from_ is not None:
        given.append("from")
    if len(given) != 1:
        breaches.error(
            "SPEC150",
            "states no range" if not given else f"states {' and '.join(given)} at once",
            path,
            "write exactly one of scale, add, abs: [low, high], or from: identified",
        )
        return
    operation = given[0]
    if operation != "from" and entry.sigma is not None:
        breaches.error("SPEC150", "`sigma` goes with `from: identified`", (*path, "sigma"), "remove it")
    if (entry.when == "interval") != (entry.every is not None):
        breaches.error(
            "SPEC151",
            "`when: interval` needs `every`" if entry.every is None else "`every` needs `when: interval`",
            path,
            "write `when: interval, every: [5 s, 10 s]`, or neither",
        )
    if operation == "from":
        if field in UNFITTED:
            help = "write `scale: [0.9, 1.1]`"
            breaches.error("SPEC152", f"no identification gives a range of {field}", (*path, "from"), help)
        return
    if field in ("gains", "strength") and operation != "scale":
        help = f"write `{field}: {{scale: [0.9, 1.1]}}`"
        breaches.error("SPEC152", f"`{field}` is a factor: only `scale` fits", (*path, operation), help)
        return
    pair = range_of(entry, field)
    if isinstance(pair, Fault):
        breaches.error("SPEC110", pair.message, (*path, operation, *pair.at), pair.help)
        return
    _check_ends(pair, (*path, operation), field, entry.distribution, breaches)


def _check_ends(
    pair: tuple[SpecValue, SpecValue], path: Path, field: str, distribution: str, breaches: Breaches
) -> None:
    """The ends' signs and order; for a gaussian they are mean and standard deviation."""
    low, high = pair[0].value, pair[1].value
    if low is None or high is None:
        return
    positive = path[-1] in ("scale", "abs") and field != "encoder_bias"
    mean_std = distribution == "gaussian"
    if positive and low < 0:
        what = "mean is" if mean_std else "range goes"
        breaches.error("SPEC153", f"the {what} below 0: {pair[0].written}", (*path, 0))
    if distribution == "log_uniform" and low <= 0:
        breaches.error("SPEC153", f"log_uniform needs a range above 0, got {pair[0].written}", (*path, 0))
    if not mean_std and low > high:
        breaches.error(
            "SPEC153",
            f"the range is the wrong way round: {pair[0].written} is above {pair[1].written}",
            path,
            f"write [{pair[1].written}, {pair[0].written}]",
        )
    if mean_std and high < 0:
        breaches.error("SPEC153", f"a standard deviation is >= 0, got {pair[1].written}", (*path, 1))


def range_of(entry: Randomize, field: str) -> tuple[SpecValue, SpecValue] | Fault:
    """The range of a randomisation in SI units; a gaussian's pair is (mean, std) and need not be ordered."""
    if entry.scale is not None:
        return entry.scale  # type: ignore[no-any-return]
    given = entry.add if entry.add is not None else entry.abs
    return pair_or_fault(given, Pair(RANDOMIZED_KINDS[field], ordered=False))
