"""Figures that a fit takes in unasked: Stribeck friction and a low-pass of the command, where the logs call for them.

Left out where it is, Stribeck friction makes Coulomb friction 8 to 15 % too large, and a low-pass goes into delay and
kd. Taken in where it is not, a figure explains something else. So they are tried only where the position is off by more
than its readings' noise, or where a low-pass promises a better fit, and stay only where the error falls clearly on
pieces that the fit has not seen, or the whole cost does.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Collector, listed
from actspec.fields import units_of
from actspec.sysid.descent import Piecewise, block_rows, seen, simulated
from actspec.sysid.identified import FIELDS
from actspec.sysid.recording import reading_noise
from actspec.sysid.system import System
from actspec.sysid.unseen import unseen
from actspec.sysid.work import FitOptions, JointInWork, ended, piecewise
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

LAGS = (0.3, 1.0, 2.0)
"""Low-passes with which a search begins, in rows."""
LEFT = 1.1
"""Position error over the noise of the readings from which on figures are tried. Measured: 0.97 to 1.01 where nothing
is left out; at 1.12 a low-pass of 80 Hz made kp 2 % and viscous friction 24 % wrong."""
PROMISED = 15.0
"""Size of the score of three low-passes over its spread from block to block, squared, from which on one is tried.
Measured in 6 s of slow motion: 25 to 34 with one of 40 to 500 Hz, which left out makes kp 0.5 to 3 % wrong at a
position error of 0.98 to 1.1 times the noise; 4 without one. Of three Gaussian ones by chance 4 times in 10,000."""
SURE, LARGE = 25.0, 5.0
"""Fall of the fit's cost, and size of the low-pass in its standard deviations, at which one that is tried for that
stays, if no error on unseen pieces rises. Measured there: it falls by 100 and more, and without one by 1."""
CLEAR = 0.9
"""Error on unseen pieces, of position or torque, over that without the figures, at which they stay. Chosen: a figure
that fits noise alone changes it by thousandths, of either sign."""
NO_WORSE = 1.02
"""Likewise of the other of the two."""
SEEN = 3.0
"""Least size of such a figure, in its standard deviations."""
PAIRS: tuple[tuple[str, ...], ...] = (("static", "stribeck_velocity"), ("lag",))
"""What is tried, together."""


def enlarged(
    joint: JointInWork,
    options: FitOptions,
    descend: Callable[[JointInWork, FitOptions, Collector], None],
    out: Collector,
) -> tuple[JointInWork, System]:
    """The joint, with more figures where that pays, and its residuals.

    Args:
        joint: After its fit.
        options: What the user asks; a field that is held is not tried.
        descend: Fits a joint.
        out: Takes what was added.
    """
    system = ended(joint)
    for _ in PAIRS:
        before = unseen(joint, system)
        best: tuple[Mapping[str, float], JointInWork, System, tuple[str, ...]] | None = None
        for names in _called_for(joint, system, options) if before else ():
            trial = replace(joint, added=joint.added | set(names))
            descend(trial, options, Collector())
            ending = ended(trial)
            errors = unseen(trial, ending)
            falls = _falls(best[0] if best else before, errors) and _shows(trial, names, SEEN)
            if names == ("lag",) and _left(trial):
                # What is left has another cause, of which a low-pass takes some: of masses that are wrong, say.
                continue
            if falls or (best is None and _surely(joint, trial, names, before, errors)):
                best = (errors, trial, ending, names)
        if best is None:
            break
        after, joint, system, names = best
        channel = min(after, key=lambda c: after[c] / before[c])
        message = (
            f"{listed(FIELDS[name][0] for name in names)} fitted too: the {channel} error on pieces that the fit has "
            f"not seen falls from {format_number(before[channel], 3)} to {format_number(after[channel], 3)} "
            f"{getattr(units_of(joint.kind), channel)}"
        )
        help = "`--hold` leaves a field out"
        if names == ("lag",) and joint.torque:
            help += "; a torque that is read behind a low-pass of its own looks alike, and makes all figures wrong"
        out.info("SYS026", message, where=joint.actuator.joint, help=help)
    return joint, system


def _called_for(joint: JointInWork, system: System, options: FitOptions) -> list[tuple[str, ...]]:
    """What is worth a trial."""
    fit = joint.fit
    assert fit is not None
    if not fit.arrived:
        return []
    left = [
        names
        for names in PAIRS
        if not any(name in fit.free or FIELDS[name][0] in options.hold for name in names)
    ]
    if _left(joint):
        return left
    return [names for names in left if names == ("lag",) and _promise(joint, system) > PROMISED]


def _left(joint: JointInWork) -> bool:
    """Whether the position is off by more than its readings' noise."""
    assert joint.fit is not None
    return joint.fit.noise["position"] > LEFT * reading_noise(joint.recordings)


def _promise(joint: JointInWork, system: System) -> float:
    """How clearly the cost falls, to first order, where low-passes stand for so much of the delay."""
    import numpy as np

    fit = joint.fit
    assert fit is not None and joint.scale is not None
    logs: list[dict[str, tuple[Array, Array, Array]]] = []
    for log, states, now in zip(piecewise(joint), fit.states, system.logs, strict=True):

        def model(
            values: Mapping[str, float], log: Piecewise = log, states: Any = states
        ) -> dict[str, Array]:
            return seen(log, values, simulated(log, values, joint.bounds, states, fit.reading))

        lags = [rows * joint.scale["lag"] for rows in LAGS]
        others = [
            model({**fit.values, "lag": lag, "delay": max(fit.values["delay"] - lag, 0.0)}) for lag in lags
        ]
        plain = model(fit.values)
        logs.append({})
        for channel, (r, jac, local) in now.items():
            change = np.stack([other[channel] - plain[channel] for other in others], axis=2)
            change[~np.isfinite(r)] = 0.0
            logs[-1][channel] = (r, np.concatenate([jac, change], axis=2), local)
    n, wider = system.count, System(logs, system.count + len(LAGS))
    solved = wider.solve(fit.noise)
    # What the other figures and states leave of it, block by block: one moment at which a joint comes to a stand, or
    # turns otherwise, promises as much as a low-pass that shows everywhere.
    scores, _ = wider.blocks(fit.noise, solved, block_rows(piecewise(joint)))
    taken = system.solve(fit.noise).inverse() @ solved.normal[:n, n:]
    own = scores[:, n:] - scores[:, :n] @ taken
    own = own / np.maximum(np.sqrt((own**2).sum(axis=0)), 1e-300)
    total = own.sum(axis=0)
    return float(total @ np.linalg.pinv(own.T @ own, rcond=1e-9, hermitian=True) @ total)


def _falls(before: Mapping[str, float], after: Mapping[str, float]) -> bool:
    """Whether position or torque is off by clearly less, and the other by no more."""
    ratios = [after[channel] / before[channel] for channel in after]
    return bool(ratios) and min(ratios) < CLEAR and max(ratios) < NO_WORSE


def _surely(
    joint: JointInWork,
    trial: JointInWork,
    names: tuple[str, ...],
    before: Mapping[str, float],
    after: Mapping[str, float],
) -> bool:
    """Whether a low-pass is there though it moves the joint little: by the cost, in which the torque counts."""
    assert joint.fit is not None and trial.fit is not None
    worse = _left(joint) or any(after[channel] > before[channel] for channel in after)
    fall = joint.fit.cost - trial.fit.cost
    return names == ("lag",) and not worse and fall > SURE and _shows(trial, names, LARGE)


def _shows(joint: JointInWork, names: tuple[str, ...], times: float) -> bool:
    """Whether what was added is there at all: more break-away than Coulomb friction, a lag above 0."""
    fit = joint.fit
    assert fit is not None
    if not all(name in fit.free for name in names):
        return False
    over = fit.values["coulomb"] if names[0] == "static" else 0.0
    return fit.values[names[0]] - over > times * fit.std(names[0])
