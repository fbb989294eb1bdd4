"""How late a torque was logged behind the motion that it makes, or ahead of it: rollouts know it to parts of a row.

Position and speed tell when a command acts, and a drive's torque is of the error and speed of its own moment. One of
another moment goes into kd, friction and inertia, with intervals as narrow as ever: two rows of 2 ms made kd 15 % and
viscous friction ten times wrong. So how late it is, is one more figure of every log. It is found to first order and
taken out, whole rows of the column and the rest of the model, and the joint is fitted again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector
from actspec.sysid.descent import block_rows, seen, simulated
from actspec.sysid.recording import Recording, with_torque_of
from actspec.sysid.system import System
from actspec.sysid.torques import OWN_ROW, OWN_ROW_HELP, rows_of
from actspec.sysid.work import FitOptions, JointInWork, ended, piecewise
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

TIMES = 6
"""Most times that it is told anew. Chosen: two to four are enough."""
SURE, SMALL = 2.0, 0.05
"""Standard deviations, and rows, of a change from which on it is tried."""
BESIDE = 2
"""Most whole rows beside the likeliest that are tried where these standard deviations do not exclude them. A fit that
takes the torques for those of another row's command knows of the change its sign alone: 0.22 +- 0.16 for one row."""
CLEARLY = 50.0
"""Fall of the cost that a change must make. Measured: one row of 2 ms makes 1,300 in 10 s of a chirp."""
NO_WORSE = 1.02
"""By how much the noise of no channel may rise then."""
DIFFERENCE = 0.1
"""Rows, for differences."""
LATE = 0.5
"""Rows from which on it is a warning. Chosen: a row's torque may be older than its position by a part of a row."""


def align(
    joint: JointInWork, options: FitOptions, descend: Callable[[JointInWork, FitOptions, Collector], None]
) -> bool:
    """Take each torque as of the moment at which it makes the joint's motion, and return whether any is moved.

    Args:
        joint: After its fit; where a torque is moved it gets that and the fit of it.
        options: What the user asks.
        descend: Fits a joint.
    """
    moved = False
    for _ in range(TIMES if joint.torque else 0):
        best = joint
        for recordings in _worth_trying(joint):
            trial = replace(joint, recordings=recordings)
            descend(trial, options, Collector())
            if better(best, trial):
                best = trial
        if best is joint:
            break
        moved = True
        joint.recordings, joint.fit, joint.fitted_to = best.recordings, best.fit, best.fitted_to
    return moved


def judge_lateness(joint: JointInWork, out: Collector) -> None:
    """Say which logs' torques were moved, and keep how well it is known by how much.

    Args:
        joint: After its fit.
        out: Takes it.
    """
    assert joint.fit is not None
    if joint.fit.reading is not None and joint.fit.reading < 0.0:
        place = joint.recordings[0].place()
        out.info("SYS012", OWN_ROW, where=joint.actuator.joint, span=place, help=OWN_ROW_HELP)
    if not any(one.late or one.ago for one in joint.recordings):
        return
    joint.unsure = [
        std * one.step if one.late or one.ago else 0.0
        for one, (_, std) in zip(joint.recordings, lateness(joint), strict=True)
    ]
    for one in joint.recordings:
        rows = _rows(one)
        if not rows:
            continue
        way, other = ("behind", "earlier") if rows > 0.0 else ("ahead of", "later")
        shown = f"{rows_of(abs(rows))} ({format_number(1e3 * abs(rows) * one.step, 3)} ms)"
        message = (
            f"the torque is {shown} {way} the motion that it makes: it is fitted as that of so much {other}"
        )
        help = "log what the drive reads in one message, or take the lag out of the column"
        (out.warning if abs(rows) >= LATE else out.info)(
            "SYS012", message, where=one.joint, span=one.place(), help=help
        )


def later_torques(joint: JointInWork) -> list[Array | None]:
    """Of each entry of `piecewise`, what its torques change by where they are read later [N*m/s or N/s].

    Shape (rows, n_piece), of the model at the fit's figures; None where no torque was logged.
    """
    fit = joint.fit
    assert fit is not None
    found: list[Array | None] = []
    for log, states, source in zip(piecewise(joint), fit.states, joint.sources, strict=True):
        if "torque" not in log.measured:
            found.append(None)
            continue
        change = DIFFERENCE * source.step
        later, now = (
            seen(one, fit.values, simulated(one, fit.values, joint.bounds, states, fit.reading))["torque"]
            for one in (replace(log, ago=log.ago + change), log)
        )
        found.append((later - now) / change)
    return found


def lateness(joint: JointInWork) -> list[tuple[float, float]]:
    """Of each recording, rows by which its torque is later than it is taken, to first order, and standard deviation."""
    import numpy as np

    fit, system, rates = joint.fit, ended(joint), later_torques(joint)
    assert fit is not None
    told = [i for i, rate in enumerate(rates) if rate is not None]
    logs: list[dict[str, tuple[Array, Array, Array]]] = []
    for i, log in enumerate(system.logs):
        logs.append({})
        for channel, (r, jac, local) in log.items():
            change = np.zeros((*r.shape, len(told)))
            rate = rates[i]
            if channel == "torque" and rate is not None:
                change[:, :, told.index(i)] = np.where(np.isfinite(r), rate * joint.recordings[i].step, 0.0)
            logs[-1][channel] = (r, np.concatenate([jac, change], axis=2), local)
    wider = System(logs, system.count + len(told))
    solved = wider.solve(fit.noise)
    step = solved.step(0.0)
    covariance = solved.sandwich(*wider.blocks(fit.noise, solved, block_rows(piecewise(joint))))
    found = [(0.0, 0.0)] * len(joint.recordings)
    for k, i in enumerate(told, system.count):
        found[i] = (float(step[k]), math.sqrt(max(float(covariance[k, k]), 0.0)))
    return found


def _rows(recording: Recording) -> float:
    """By how many its torque was late."""
    return recording.late + recording.ago / recording.step


def _worth_trying(joint: JointInWork) -> Iterator[list[Recording]]:
    """The recordings with torques of other moments: first by whole rows, the likeliest first, then by parts of one."""
    found = lateness(joint)
    for i, (one, (change, std)) in enumerate(zip(joint.recordings, found, strict=True)):
        total = _rows(one) + change
        near = range(round(total) - BESIDE, round(total) + BESIDE + 1)
        for n in sorted(near, key=lambda n: abs(n - total)):
            if n != _rows(one) and std > 0.0 and abs(n - total) < 0.5 + SURE * std:
                yield [*joint.recordings[:i], _taken(one, float(n)), *joint.recordings[i + 1 :]]
    exactly = [
        _taken(one, _rows(one) + change) if abs(change) > max(SURE * std, SMALL) else one
        for one, (change, std) in zip(joint.recordings, found, strict=True)
    ]
    if any(now is not one for now, one in zip(exactly, joint.recordings, strict=True)):
        yield exactly


def _taken(recording: Recording, rows: float) -> Recording:
    """The recording with its torque that many rows earlier than it was logged."""
    whole = round(rows)
    return replace(with_torque_of(recording, whole - recording.late), ago=(rows - whole) * recording.step)


def at_rows(joint: JointInWork) -> JointInWork:
    """The joint with its torques moved by whole rows alone; it needs a fit."""
    return replace(joint, recordings=[replace(one, ago=0.0) for one in joint.recordings], fitted_to=None)


def better(joint: JointInWork, trial: JointInWork) -> bool:
    """Whether all readings fit better in a trial with other torques, each for itself."""
    assert joint.fit is not None and trial.fit is not None
    worse = any(trial.fit.noise[name] > NO_WORSE * noise for name, noise in joint.fit.noise.items())
    return not worse and trial.fit.cost < joint.fit.cost * _readings(trial) / _readings(joint) - CLEARLY


def _readings(joint: JointInWork) -> int:
    """How many count."""
    import numpy as np

    return sum(int(np.isfinite(log.cut(name)).sum()) for log in piecewise(joint) for name in log.measured)
