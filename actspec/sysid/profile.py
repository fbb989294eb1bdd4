"""Intervals of figures that a log tells weakly: by the cost itself, where its curvature is no guide that far away.

A curvature makes every interval symmetric, below 0 too, and takes the cost for a parabola. Here the figure is held away
from its best value, all others are fitted anew, and the end of the interval is where the cost has risen by as much as
1.96 standard deviations of the curvature's interval would be worth, so that correlated residuals count here too.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from actspec.sysid.descent import Fit, Search, descend, linearised
from actspec.sysid.system import WIDE, System
from actspec.sysid.work import JointInWork, piecewise

Values = Mapping[str, float]
WEAK = 0.05
"""Half of a curvature's interval over the figure from which on it is not taken at its word. Chosen: within that a cost
bends too little to matter."""
ROW = 0.5
"""Likewise of a delay, in rows."""
TOGETHER = 0.98
"""Correlation of two figures from which on the ends of one are those of the other. Chosen: the scale of all torques,
where a log tells it weakly, makes four intervals of one."""
TRIES = 2
"""Most fits for one end."""
ROUNDS = 3
"""Most steps of such a fit, which begins where the curvature says that it ends. Chosen: it takes one or two."""
NEAR = 0.03
"""How near to the end, as a share of the interval's half, is near enough."""
FARTHEST = 4.0
"""Most that an end is looked for, in halves of the curvature's interval."""


def weak(joint: JointInWork, fit: Fit, name: str) -> bool:
    """Whether the curvature's interval is too wide to be taken at its word."""
    half = WIDE * fit.std(name)
    if not fit.arrived or not math.isfinite(half) or half <= 0.0 or name == "bias":
        # The bias shows in gravity, which is a straight line over an encoder's error.
        return False
    if name == "delay":
        return half > ROW * joint.recordings[0].step
    return half > WEAK * abs(fit.values[name])


def profiled(
    joint: JointInWork, fit: Fit, system: System, name: str, ends: dict[str, tuple[Values, Values]]
) -> tuple[float, float]:
    """Both ends of a figure's 95 % interval, by the cost.

    Args:
        joint: After its fit.
        fit: Its covariance by the residuals alone, without what it takes as given.
        system: Residuals where the fit ended.
        name: Of a free figure.
        ends: All figures at the ends of those that were looked for before; takes this one's. What goes with one of
            these, as all torques do with their scale, has its ends there.
    """
    value, low = fit.values[name], joint.low[name]
    for other, both in ends.items():
        together = abs(_together(fit, name, other))
        if together > TOGETHER:
            away = [(found[name] - value) / together for found in both]
            return max(value + min(*away, 0.0), low), value + max(*away, 0.0)
    half = WIDE * fit.std(name)
    plain = _variances(fit)[name]
    # What 1.96 standard deviations cost, were the residuals as white as the cost takes them for.
    wanted = WIDE**2 * fit.std(name) ** 2 / plain if plain > 0 else math.inf
    least = system.cost(fit.noise)
    below, above = (_end(joint, fit, name, way * half, low, least, wanted) for way in (-1.0, 1.0))
    ends[name] = below, above
    return below[name], above[name]


def _together(fit: Fit, name: str, other: str) -> float:
    """Correlation of two figures."""
    i, j = fit.free.index(name), fit.free.index(other)
    both = fit.std(name) * fit.std(other)
    return float(fit.covariance[i, j]) / both if both > 0.0 else 0.0


def _end(
    joint: JointInWork, fit: Fit, name: str, away: float, low: float, least: float, wanted: float
) -> Values:
    """All figures where the cost has risen by so much, on one side."""
    value, farthest = fit.values[name], FARTHEST * abs(away)
    states, at = fit, value
    for _ in range(TRIES):
        at = max(value + away, low)
        if at == value:
            return fit.values
        found = states = _held(joint, states, name, {**fit.values, **_along(joint, fit, name, at)})
        rise = _cost(joint, found, fit.noise) - least
        if at == low and rise < wanted:
            return found.values
        share = math.sqrt(wanted / max(rise, 1e-3 * wanted))
        if abs(share - 1.0) < NEAR:
            break
        away = math.copysign(min(abs(at - value) * share, farthest), away)
    further = (max(value + away, low) - value) / (at - value)
    return {
        other: ended if other == name else fit.values[other] + further * (ended - fit.values[other])
        for other, ended in {**states.values, name: max(value + away, low)}.items()
    }


def _along(joint: JointInWork, fit: Fit, name: str, at: float) -> Mapping[str, float]:
    """Where the others are, to first order, when a figure is held."""
    inverse = _inverse(fit)
    i = fit.free.index(name)
    moved = {
        other: max(
            fit.values[other] + inverse[j][i] / inverse[i][i] * (at - fit.values[name]),
            joint.low.get(other, -math.inf),
        )
        for j, other in enumerate(fit.free)
    }
    return {**moved, name: at}


def _inverse(fit: Fit) -> list[list[float]]:
    """Covariance of white residuals."""
    import numpy as np

    root = np.sqrt(np.maximum(np.diag(fit.normal), 1e-300))
    scale = np.outer(root, root)
    found: list[list[float]] = (
        np.linalg.pinv(fit.normal / scale, rcond=1e-12, hermitian=True) / scale
    ).tolist()
    return found


def _variances(fit: Fit) -> dict[str, float]:
    inverse = _inverse(fit)
    return {name: inverse[i][i] for i, name in enumerate(fit.free)}


def _search(joint: JointInWork, fit: Fit, free: tuple[str, ...]) -> Search:
    assert joint.scale is not None
    return Search(piecewise(joint), joint.bounds, free, joint.scale, joint.low, fit.reading)


def _held(joint: JointInWork, fit: Fit, name: str, values: Mapping[str, float]) -> Fit:
    """The best fit with a figure held."""
    assert joint.fit is not None
    search = _search(joint, joint.fit, tuple(other for other in joint.fit.free if other != name))
    return descend(search, values, fit, rounds=ROUNDS)


def _cost(joint: JointInWork, fit: Fit, noise: Mapping[str, float]) -> float:
    """Squared residuals of a fit in those of the noise."""
    assert joint.fit is not None
    return linearised(_search(joint, joint.fit, ()), fit.values, fit.states).cost(noise)
