"""One joint's fit, the links along its logs given: what is free, where the search begins, what torques tell."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector
from actspec.sysid.begin import begin
from actspec.sysid.course import told
from actspec.sysid.descent import ROUNDS, Fit, Piecewise, Search, descend, descend_each
from actspec.sysid.figures import figures_of
from actspec.sysid.gains import GAINS
from actspec.sysid.identified import FIELDS, FIGURE
from actspec.sysid.more import LAGS
from actspec.sysid.recording import unevenness
from actspec.sysid.system import WIDE
from actspec.sysid.work import FitOptions, JointInWork, piecewise

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

DEFAULT = ("kp", "kd", "armature", "coulomb", "viscous", "delay", "bias")
"""Figures that are free unless something holds them."""
STRIBECK = {"static", "stribeck_velocity"}
COUPLED = 0.02
"""Share of a joint's load torque that the others' motion must make for a second pass."""
OWN = -1
"""Row of a delay with which a torque tells the command of its own row, as simulations log it."""
SMEARED = 0.05
"""Unevenness of a clock from which on a delay shows in which commands the rows' torques tell, so that no whole row need
be searched. Chosen: a first fit has the delay to less."""
ROUGHLY = 5
"""Most steps of that first fit, which knows some of these commands wrongly: measured, it else takes up to 16."""
NEARLY = 0.1
"""Error that its delay may have, in rows. Measured: 0.02."""
FOLLOWED = 5
"""Most times that these commands are told anew. Measured: a jitter of 15 % takes two to four."""
SAME = 1e-3
"""Share of rows with another command that is nothing any more. Measured: 20 % made kp 0.3 % wrong."""
CLIPS = 0.02
"""Share of the rows with the drive at its limit from which on kd, which the limit clips, shows apart from viscous
friction, which it does not. Measured: of 3 % both are right, with intervals of 0.6 and 8 %."""
STIFF = 1e6
"""Greatest slope of gravity's torque over kp below which the bias does not show, as its reciprocal."""


def _free(joint: JointInWork, options: FitOptions) -> tuple[str, ...]:
    """Values that are free."""
    import numpy as np

    asked = {FIGURE[field] for field in options.free} | joint.added
    spec = figures_of(joint.actuator)
    if asked & STRIBECK:
        # One of the two without the other does nothing.
        asked |= {name for name in STRIBECK if spec[name] == 0.0}
    wanted = [*DEFAULT, *sorted(asked - set(DEFAULT))]
    free = [name for name in wanted if FIELDS[name][0] not in options.hold and name not in joint.gains.held]
    slope = max(float(np.abs(course.slope).max()) for course in joint.courses)
    if "bias" in free and slope * STIFF < 1.0:
        free.remove("bias")
    if not joint.parted and {"kd", "viscous"} <= set(free):
        # Only their sum shows: it is found as the drive's, which the limit clips.
        free.remove("viscous")
    if "armature" in free and not joint.told and not _scaled(joint):
        free = [name for name in free if name not in ("armature", "bias")]
    return tuple(key for name in free for key in (joint.gains.keys(name) if name in GAINS else (name,)))


def _scaled(joint: JointInWork) -> bool:
    """Whether gravity or other joints give a torque that is known without the drive."""
    import numpy as np

    inertial = np.concatenate(
        [c.inertia * r.acceleration for c, r in zip(joint.courses, joint.recordings, strict=True)]
    )
    load = np.concatenate([course.load for course in joint.courses])
    return float(np.std(load)) > COUPLED * float(np.std(inertial))


def fit_joint(joint: JointInWork, options: FitOptions, out: Collector) -> None:
    """Fit a joint, from its last fit or from a regression on.

    Args:
        joint: With its courses; it gets the fit.
        options: What the user asks.
        out: Takes a search that did not come to rest.
    """
    pieces = piecewise(joint)
    free = _free(joint, options)
    if joint.fit is not None:
        values = dict(joint.fit.values)
        assert joint.scale is not None
        scale = joint.scale
    else:
        values = _begun(joint, free)
        scale = joint.scale = _scales(joint, values)
    late = "lag" in free and values["lag"] <= 0.0
    # Where only ratios show, a gain that is held says nothing of friction, which may then be anything.
    unscaled = not joint.told and "armature" not in free
    joint.low = {
        name: -math.inf if name == "bias" or (unscaled and name == "viscous") else 0.0 for name in values
    }
    if late:
        # A low-pass does nearly what a delay does, and a search that begins with one need not find the other.
        rest = tuple(name for name in free if name != "lag")
        if not (
            joint.fit and joint.fit.arrived and joint.fit.free == rest and joint.fitted_to is joint.courses
        ):
            joint.fit = _searched(joint, pieces, rest, scale, joint.low, values)
        without = joint.fit
        starts = [dict(without.values) for _ in LAGS]
        for values, rows in zip(starts, LAGS, strict=True):
            _set_out(joint, values, free, rows)
        # Nothing is given up early: far from a slow low-pass the cost does not promise how far it falls.
        search = Search(pieces, joint.bounds, free, scale, joint.low)
        found = [
            replace(one, reading=values["delay"] if joint.torque else None)
            for one, values in zip(descend_each(search, starts, without), starts, strict=True)
        ]
        best = min([without, *found], key=lambda fit: fit.cost)
        if best is not without:
            # Along the valley of low-pass and delay a descent stops early.
            joint.fit = best
            best = _searched(joint, pieces, free, scale, joint.low, best.values)
        joint.fit = best if best.cost < without.cost - WIDE**2 else without
    else:
        _set_out(joint, values, free)
        joint.fit = _searched(joint, pieces, free, scale, joint.low, values)
    joint.fitted_to = joint.courses
    if not joint.parted and "kd" in free and FIELDS["viscous"][0] not in options.hold and _is_clipped(joint):
        joint.clipped = True
        joint.fit = _halved(joint, joint.fit)
        fit_joint(joint, options, out)
        return
    if not joint.fit.arrived:
        out.warning(
            "SYS030", "the fit did not come to rest: its figures are uncertain", where=joint.actuator.joint
        )


def _is_clipped(joint: JointInWork) -> bool:
    """Whether the drive is at its limit in `CLIPS` of the rows, by the last fit."""
    import numpy as np

    assert joint.fit is not None
    values, at_limit = joint.fit.values, []
    for index, (recording, course) in enumerate(zip(joint.recordings, joint.courses, strict=True)):
        own = joint.gains.own(index)
        kp, kd = (own[name][1] * values[own[name][0]] for name in GAINS)
        rows = np.maximum(np.arange(len(course.time)) - round(values["delay"] / recording.step), 0)
        torque = kp * (course.command[rows] - recording.position) - kd * recording.velocity
        at_limit.append(np.abs(torque) > np.abs(joint.bounds.clip(torque, recording.velocity)) * (1.0 + 1e-9))
    return float(np.concatenate(at_limit).mean()) >= CLIPS


def _halved(joint: JointInWork, fit: Fit) -> Fit:
    """A fit that has viscous friction in kd, with a part of it as friction: the spec's, at most half."""
    keys = joint.gains.keys("kd")
    least = min(fit.values[key] for key in keys)
    part = min(figures_of(joint.actuator)["viscous"] or 0.1 * least, 0.5 * least)
    values = {name: value - part if name in keys else value for name, value in fit.values.items()}
    return replace(fit, values={**values, "viscous": part})


def _set_out(joint: JointInWork, values: dict[str, float], free: tuple[str, ...], rows: float = 0.0) -> None:
    """Where figures begin that do nothing at 0, and so tell no direction there."""
    assert joint.scale is not None
    if "static" in free and values["static"] <= values["coulomb"]:
        values["static"] = 1.5 * max(values["coulomb"], 0.1 * joint.scale["coulomb"])
    if "stribeck_velocity" in free and values["stribeck_velocity"] <= 0.0:
        values["stribeck_velocity"] = 0.5 * joint.scale["stribeck_velocity"]
    if "lag" in free and values["lag"] <= 0.0:
        values["lag"] = rows * joint.scale["lag"]
        if "delay" in free:
            values["delay"] = max(values["delay"] - values["lag"], 0.25 * joint.scale["delay"])


def _begun(joint: JointInWork, free: tuple[str, ...]) -> dict[str, float]:
    """Every value, where a descent begins."""
    spec = figures_of(joint.actuator)
    sets, held = joint.gains.sets, joint.gains.held
    sent = [
        (one.kp or spec["kp"] or 1.0, one.kd if one.kd is not None else spec["kd"] or 0.1) for one in sets
    ]
    # Where a log of several has a torque, those that have one tell where to begin.
    telling = [i for i, one in enumerate(joint.recordings) if not joint.torque or "torque" in one.measured]
    sets_told = sorted({joint.gains.used[i] for i in telling})
    first = begin(
        [joint.recordings[i] for i in telling],
        [joint.courses[i] for i in telling],
        joint.bounds,
        [sets_told.index(joint.gains.used[i]) for i in telling],
        None if joint.torque else sent,
    )
    told_gains = dict(zip(sets_told, first.gains, strict=True))
    values = {**spec, **{name: value for name, value in first.values.items() if name in free}}
    for index, given in enumerate(sent):
        for name, regressed, stated in zip(GAINS, told_gains.get(index, given), given, strict=True):
            key, factor = joint.gains.key(name, index)
            if factor == 1.0:
                values[key] = stated if name in held else regressed
    if "kd" in free and "viscous" not in free and not joint.parted:
        values["kd"] += first.values["viscous"]
        values["viscous"] = 0.0
    return values


def _searched(
    joint: JointInWork,
    pieces: Sequence[Piecewise],
    free: tuple[str, ...],
    scale: Mapping[str, float],
    low: Mapping[str, float],
    values: Mapping[str, float],
) -> Fit:
    """The best fit; where a torque tells which command acts, over the rows that it may tell.

    Behind a low-pass it does not jump with the command, and the row is no question.
    """
    step = joint.recordings[0].step
    search = Search(pieces, joint.bounds, free, scale, low, values["delay"] if joint.torque else None)
    clocks = [recording.time for recording in joint.recordings]
    telling = joint.torque and "delay" in free and "lag" not in free and values["lag"] <= 0.0
    smeared = telling and max(unevenness(time) for time in clocks) > SMEARED
    best = descend(search, values, joint.fit, rounds=ROUGHLY if smeared else ROUNDS)
    if not telling:
        return best
    tried = {math.floor(values["delay"] / step)}
    for _ in range(0 if smeared else 4):
        row = math.floor(best.values["delay"] / step)
        fresh = [option for option in (row, row - 1, row + 1) if option >= OWN and option not in tried]
        if not fresh:
            break
        for option in fresh:
            tried.add(option)
            other = descend(replace(search, reading=(option + 0.5) * step), best.values, best, best.cost)
            if other.cost < best.cost:
                search, best = replace(search, reading=(option + 0.5) * step), other
    if smeared:
        # Of what is told by a delay that is nearly right, only what its error does not change.
        reading = best.values["delay"]
        sure = replace(
            search, logs=[_sure(piece, reading, NEARLY * step) for piece in pieces], reading=reading
        )
        best = replace(descend(sure, best.values, best), cost=math.inf)
    # Between uneven rows a delay ends now in one, now in the next: what each torque tells follows from it exactly.
    for turn in range(FOLLOWED):
        reading = best.values["delay"]
        if (turn or not smeared) and _retold(clocks, search.reading, reading) <= SAME:
            break
        search = replace(search, reading=reading)
        other = descend(search, best.values, best, best.cost)
        if other.cost > best.cost:
            break
        best = other
    return best


def _sure(piece: Piecewise, delay: float, error: float) -> Piecewise:
    """The log without those torques that tell another command where the delay is off by so much."""
    import numpy as np

    if "torque" not in piece.measured:
        return piece
    time = piece.course.time
    same = told(time, max(delay - error, 0.0)) == told(time, delay + error)
    torque = np.where(same, piece.measured["torque"], np.nan)
    return replace(piece, measured={**piece.measured, "torque": torque})


def _retold(clocks: Sequence[Array], one: float | None, other: float) -> float:
    """Share of the rows whose torque tells another command with another delay."""
    import numpy as np

    assert one is not None
    return max(float(np.mean(told(time, one) != told(time, other))) for time in clocks)


def _scales(joint: JointInWork, values: Mapping[str, float]) -> dict[str, float]:
    """Sizes of the figures, for differences and to judge what is vague."""
    import numpy as np

    inertia = float(np.mean([course.inertia.mean() for course in joint.courses])) + values["armature"]
    torque = max(
        float(np.std(values["kp"] * (c.command - r.position)))
        for c, r in zip(joint.courses, joint.recordings, strict=True)
    )
    speed = max(float(np.abs(recording.velocity).max()) for recording in joint.recordings)
    damping = max(values["kd"] + values["viscous"], 0.02 * math.sqrt(values["kp"] * inertia))
    gains = {key: max(values[key], 1e-3) for key in joint.gains.keys("kp")}
    gains |= {key: max(values[key], damping) for key in joint.gains.keys("kd")}
    return {
        **gains,
        "armature": inertia,
        "coulomb": max(0.1 * torque, 1e-4),
        "viscous": damping,
        "static": max(0.1 * torque, 1e-4),
        "stribeck_velocity": 0.1 * speed,
        "delay": joint.recordings[0].step,
        "bias": 0.01,
        "lag": joint.recordings[0].step,
    }
