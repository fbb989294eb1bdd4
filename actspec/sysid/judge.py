"""What a fit says of a joint: which figures it tells, within which interval, and why not the others."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, listed
from actspec.fields import unit_of_kind, units_of
from actspec.sysid.descent import Fit, Piecewise, seen, simulated
from actspec.sysid.figures import time_constant
from actspec.sysid.gains import GAINS
from actspec.sysid.identified import FIELDS, Combination, Indicator, JointFit, Parameter, State, bounded
from actspec.sysid.late import later_torques
from actspec.sysid.profile import Values, profiled, weak
from actspec.sysid.recording import reading_noise
from actspec.sysid.system import WIDE, System
from actspec.sysid.work import FitOptions, JointInWork, piecewise
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

VAGUE = 0.3
"""Standard deviation over the size of a figure from which on it is not identified. Chosen: the interval then is wider
than what one would guess."""
SUM = ("kd", "friction.viscous")
"""What shows in a sum alone where nothing tells the drive's torque."""
BESIDE = 1e-3
"""Standard deviation of what the links need where other joints of the log move, as a share. Measured on virtual legs of
10 s at 200 Hz: without it kp was up to 0.17 % off and its interval 0.05 %."""
LATE = 5e-3
"""Standard deviation of a delay from which on it is not identified [s]. Chosen."""
ASKEW = 0.02
"""Likewise of an encoder's bias [rad or m]. Chosen: a degree."""

GAINS_SENT = "state the gains that were sent, `gains:` in the sidecar, or try --free kp,kd"
"""What to do where gains that were held may be the cause."""
DOUBTED, UNLIKE = 1.5, 3.0
"""Position error over the readings' noise from which on it is reported, and is a warning. Measured: a play of
0.3 degrees gives 2.9, and kd is 1 %, a viscous friction of 0.01 is 75 % off, both outside of their intervals."""


def judged(joint: JointInWork, options: FitOptions, system: System, unseen: float | None) -> JointFit:
    """What a fit says of a joint.

    Args:
        joint: After its fit.
        options: What the user asks.
        system: Residuals where the fit ended, and their derivatives.
        unseen: Position error on data that the fit did not see [rad or m].
    """
    import numpy as np

    scale, actuator = joint.scale, joint.actuator
    assert joint.fit is not None and scale is not None
    unscaled = not joint.told and not {"armature"} & (set(joint.fit.free) | options.hold)
    told = joint.fit
    fit = joint.fit = _with_givens(joint, system, unscaled=unscaled)
    summed = (
        not joint.parted and "kd" in fit.free and "viscous" not in fit.free and SUM[1] not in options.hold
    )
    parameters: list[Parameter] = []
    ends: dict[str, tuple[Values, Values]] = {}
    combinations: list[Combination] = []
    for name, (_, kind) in FIELDS.items():
        unit = unit_of_kind(kind, joint.kind)
        parameter = _parameter(
            joint, name, unit, options, told, system, ends, unscaled=unscaled, summed=summed
        )
        if parameter is not None:
            parameters.append(parameter)
    if summed or unscaled or all(_untold(parameters, field) for field in SUM):
        combinations = _combinations(joint, fit, unscaled=unscaled)
    correlation = _correlation(fit)
    position = fit.noise["position"]
    return JointFit(
        actuator.joint,
        actuator.kind,
        tuple(parameters),
        tuple(combinations),
        correlation,
        position,
        unseen,
        position / reading_noise(joint.recordings),
        float(np.linalg.cond(_scaled_normal(fit))) if fit.free else 1.0,
        () if unscaled or summed else tuple(_own_gains(joint)),
    )


def _untold(parameters: Sequence[Parameter], field: str) -> bool:
    """Whether a figure is asked for and not told."""
    return any(p.field == field and p.state is State.UNIDENTIFIABLE for p in parameters)


def _own_gains(joint: JointInWork) -> Iterator[Indicator]:
    """kp and kd of every set of logs, where they are not the same."""
    fit, gains = joint.fit, joint.gains
    assert fit is not None
    for name in GAINS:
        if not gains.differ(name):
            continue
        kind = FIELDS[name][1]
        for index, one in enumerate(gains.sets):
            key, factor = gains.key(name, index)
            std = factor * fit.std(key) if key in fit.free else None
            unit = unit_of_kind(kind, joint.kind)
            yield Indicator(f"{name} of {listed(one.logs, 3)}", factor * fit.values[key], std, unit)


def _with_givens(joint: JointInWork, system: System, *, unscaled: bool) -> Fit:
    """The fit, with what it takes as given in its covariance: the steps of the integration, torque scale, masses.

    Each cause moves the best figures by d, to first order, when the readings change by what a halved step, one
    standard deviation of the sidecar's `accuracy`, or another filter of joints that move as read, does to the motion:
    d d' is added.
    """
    import numpy as np

    fit = joint.fit
    assert fit is not None
    if not fit.free:
        return fit
    logs = list(zip(piecewise(joint), fit.states, joint.sources, strict=True))

    def change(log: Piecewise, other: Piecewise, states: tuple[Array, Array], finer: int) -> dict[str, Array]:
        models = [
            seen(one, fit.values, simulated(one, fit.values, joint.bounds, states, fit.reading, times))
            for one, times in ((log, 1), (other, finer))
        ]
        return {channel: models[0][channel] - models[1][channel] for channel in models[0]}

    causes: list[list[dict[str, Array]]] = [[change(log, log, states, 2) for log, states, _ in logs]]
    accuracies = [recording.log.sidecar.accuracy for recording in joint.sources]
    torques = [a.torque.value if a.torque is not None and a.torque.value else 0.0 for a in accuracies]
    masses = [a.masses.value if a.masses is not None and a.masses.value else 0.0 for a in accuracies]
    if any(course.between is not None for course in joint.courses):
        # What other joints do to this one is known by their fits, and between rows by straight lines.
        masses = [math.hypot(off, BESIDE) for off in masses]
    if joint.torque and any(torques):
        causes.append(
            [
                {"torque": off * log.cut("torque")} if "torque" in log.measured else {}
                for (log, _, _), off in zip(logs, torques, strict=True)
            ]
        )
    if any(masses) and not unscaled:
        causes.append(
            [
                change(log, _heavier(log, off), states, 1)
                for (log, states, _), off in zip(logs, masses, strict=True)
            ]
        )
    if joint.otherwise:
        # Of joints that move as read, the figures have the noise of two differences.
        others = [*joint.otherwise, *(None for _ in logs[len(joint.otherwise) :])]
        causes.append(
            [
                {} if other is None else change(log, replace(log, course=other), states, 1)
                for (log, states, _), other in zip(logs, others, strict=True)
            ]
        )
    if any(joint.unsure):
        off = zip(later_torques(joint), [*joint.unsure, *(0.0 for _ in joint.swings)], strict=False)
        causes.append([{} if rate is None else {"torque": std * rate} for rate, std in off])
    moved = system.shifts(fit.noise, causes)
    return replace(fit, covariance=fit.covariance + np.einsum("ci,cj->ij", moved, moved))


def _heavier(log: Piecewise, off: float) -> Piecewise:
    """The log with links whose masses and inertias are larger by a share."""
    course = log.course
    scaled = {name: (1.0 + off) * getattr(course, name) for name in ("inertia", "load", "slope")}
    between = course.between
    if between is not None:
        between = replace(between, inertia=(1.0 + off) * between.inertia, load=(1.0 + off) * between.load)
    return replace(log, course=replace(course, **scaled, between=between))


def _scaled_normal(fit: Fit) -> Array:
    import numpy as np

    root = np.sqrt(np.maximum(np.diag(fit.normal), 1e-300))
    found: Array = fit.normal / np.outer(root, root)
    return found


def _parameter(
    joint: JointInWork,
    name: str,
    unit: str,
    options: FitOptions,
    told: Fit,
    system: System,
    ends: dict[str, tuple[Values, Values]],
    *,
    unscaled: bool,
    summed: bool,
) -> Parameter | None:
    """What is said of one figure; None: nothing, as nobody asked for it."""
    fit, scale, (field, _) = joint.fit, joint.scale, FIELDS[name]
    assert fit is not None and scale is not None

    def untold(state: State, why: str) -> Parameter:
        return Parameter(field, state, None, None, None, None, unit, why)

    value = fit.values[name]
    if name in GAINS and (why := joint.gains.nameless(name)) is not None:
        return untold(State.UNIDENTIFIABLE, why)
    if name not in fit.free:
        if name == "lag" and field in options.free:
            return untold(State.AT_BOUND, "a low-pass makes the fit no better than none does")
        if name in ("static", "stribeck_velocity", "lag"):
            return None
        if name in joint.gains.held:
            where = joint.gains.where(name, options.hold)
            return Parameter(field, State.HELD, value, None, None, None, unit, where)
        if field in options.hold:
            return Parameter(field, State.HELD, value, None, None, None, unit, "held at the spec's, --hold")
        if name == "bias":
            return untold(State.UNIDENTIFIABLE, "without gravity on the joint it shows in nothing")
    if unscaled and name in ("kp", "kd", "armature", "coulomb", "viscous", "static"):
        return untold(
            State.UNIDENTIFIABLE, "without torque, gravity and other joints only ratios to the inertia show"
        )
    if summed and name in ("kd", "viscous"):
        return untold(State.UNIDENTIFIABLE, f"without torque only {' + '.join(SUM)} shows")
    std = fit.std(name)
    vague = {"delay": LATE, "bias": ASKEW}.get(name, VAGUE * scale[name])
    if name in ("kp", "lag"):
        vague = VAGUE * abs(value)
    if not math.isfinite(std) or std == 0.0:
        return untold(State.UNIDENTIFIABLE, "nothing in this log depends on it")
    if name == "lag" and std > vague:
        slowest = format_number(time_constant(max(value, 0.0) + WIDE * std), 2)
        fastest = value - WIDE * std
        until = (
            "none at all" if fastest <= 0.0 else f"one of {format_number(time_constant(fastest), 2)} {unit}"
        )
        why = f"anything from a low-pass of {slowest} {unit} to {until} does nearly the same in this log"
        return untold(State.UNIDENTIFIABLE, why)
    if std > vague:
        partner = _partner(fit, name)
        why = f"its standard deviation would be {format_number(std, 2)} {unit}"
        if partner is not None:
            why += f", because {FIELDS[partner][0]} does nearly the same in this log"
        return untold(State.UNIDENTIFIABLE, why)
    low, high = value - WIDE * std, value + WIDE * std
    if weak(joint, told, name):
        # What is taken as given moves a figure by as much either way; the cost knows of it nothing.
        given = WIDE * math.sqrt(max(std**2 - told.std(name) ** 2, 0.0))
        below, above = profiled(joint, told, system, name, ends)
        low, high = value - math.hypot(value - below, given), value + math.hypot(above - value, given)
        std = max(high - value, value - low) / WIDE
    if name == "bias":
        return Parameter(field, State.IDENTIFIED, value, std, low, high, unit)
    if name == "lag":
        least = time_constant(high)
        if low <= 0.0:
            why = f"one of {format_number(least, 2)} {unit} or above, or none at all, fits"
            return untold(State.AT_BOUND, why)
        low, high = least, time_constant(low)
        value, std = time_constant(value), time_constant(value) * std / value
    return bounded(field, value, std, low, high, unit)


def _partner(fit: Fit, name: str) -> str | None:
    """The figure with which another is most confounded."""
    import numpy as np

    i = fit.free.index(name)
    root = np.sqrt(np.maximum(np.diag(fit.covariance), 1e-300))
    row = np.abs(fit.covariance[i] / (root * root[i]))
    # Of a gain in another set of logs nobody has heard.
    row[[key not in FIELDS or key == name for key in fit.free]] = 0.0
    best = int(np.argmax(row))
    return fit.free[best] if len(row) > 1 and row[best] > 0.9 else None


def _correlation(fit: Fit) -> tuple[tuple[str, str, float], ...]:
    import numpy as np

    root = np.sqrt(np.maximum(np.diag(fit.covariance), 1e-300))
    matrix = fit.covariance / np.outer(root, root)
    return tuple(
        (FIELDS[a][0], FIELDS[b][0], float(np.clip(matrix[i, j], -1.0, 1.0)))
        for i, a in enumerate(fit.free)
        for j, b in enumerate(fit.free)
        if i < j and abs(matrix[i, j]) > 0.5 and {a, b} <= set(FIELDS)
    )


def _combinations(joint: JointInWork, fit: Fit, *, unscaled: bool) -> list[Combination]:
    """Sums and ratios that show where single figures do not; of the logs with the first gains."""
    import numpy as np

    units = units_of(joint.kind)
    damping = fit.values["viscous"] + fit.values["kd"]
    shown = [fit.free.index(name) for name in ("kd", "viscous") if name in fit.free]
    std = math.sqrt(max(float(fit.covariance[np.ix_(shown, shown)].sum()), 0.0))
    if not unscaled:
        whole = Combination("+".join(SUM), damping, std, units.velocity_gain)
        return [whole] if std < VAGUE * abs(damping) else []
    inertia = float(np.mean([course.inertia.mean() for course in joint.courses])) + fit.values["armature"]
    acceleration = f"{units.position}/s^2"
    found = []
    if "kp" in fit.free:
        found.append(Combination("kp/inertia", fit.values["kp"] / inertia, fit.std("kp") / inertia, "1/s^2"))
    found.append(Combination(f"({'+'.join(SUM)})/inertia", damping / inertia, std / inertia, "1/s"))
    if "coulomb" in fit.free:
        found.append(
            Combination(
                "friction.coulomb/inertia",
                fit.values["coulomb"] / inertia,
                fit.std("coulomb") / inertia,
                acceleration,
            )
        )
    return [one for one in found if one.std < VAGUE * abs(one.value)]


def held_gains(joint: JointFit) -> str:
    """The gains that a fit without torque took as given, in words; "" where it took none."""
    held = [p for p in joint.parameters if p.field in GAINS and p.state is State.HELD and p.value is not None]
    return listed([f"{p.field} {format_number(p.value, 4)} {p.unit}" for p in held if p.value is not None])


def judge_fit(joints: Sequence[JointFit], out: Collector) -> None:
    """What is to be said of the whole fit."""
    for joint in joints:
        if joint.misfit is not None and joint.misfit > DOUBTED:
            unlike = joint.misfit > UNLIKE
            held = held_gains(joint) if unlike else ""
            other = f"the drive had other gains than {held}, which were held, or " if held else ""
            help = "try --free friction.static,friction.stribeck_velocity or --free bandwidth"
            (out.warning if unlike else out.info)(
                "SYS031",
                f"the position is off by {joint.misfit:.2g} times the noise of its readings: {other}something that the "
                "model does not have moves the joint, such as play, Stribeck friction, friction that grows with the "
                "load, a clamp of the command after the log, "
                "an end stop, a base that is held otherwise than in the model, or other masses; figures may be off by "
                "more than their intervals",
                where=joint.joint,
                help=f"{GAINS_SENT}; else {help}" if held else help,
            )
        bound = {"bandwidth": " from none"}
        untold = [
            p.field + (bound.get(p.field, " from 0") if p.state is State.AT_BOUND else "")
            for p in joint.parameters
            if p.state in (State.UNIDENTIFIABLE, State.AT_BOUND)
        ]
        if untold:
            out.info("SYS032", f"the logs do not tell {listed(untold)}", where=joint.joint)
