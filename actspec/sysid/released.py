"""Stretches with the drive off, in which the joint swings free: they tell friction and inertia apart from the drive.

Without torque kd and viscous friction do the same to a driven joint; a released one has viscous friction alone. Not all
that a joint does with its drive off is a free swing: it lies at an end stop, a brake holds it, or a hand does.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span
from actspec.sysid.descent import Fit, Search, descend
from actspec.sysid.recording import LEAST_PIECE, LEAST_TIME, PIECE, Recording, cut, stretches
from actspec.sysid.work import JointInWork, Swings, swung
from actspec.units import format_number

if TYPE_CHECKING:
    pass

STOP = 0.02
"""Distance to an end of the joint's range within which it may lie at a stop, as a share of the range. Chosen."""
MOVES = 10.0
"""Least movement within a piece, in the noise of its position. One that stands tells no more than that."""
FREE = 2.0
"""Largest position error of a free swing with friction of its own, in the noise of the fit. Chosen: a stop costs 10."""
OWN = ("armature", "coulomb", "viscous")
"""Figures of its own that a piece is tried with."""


def release(joint: JointInWork, out: Collector) -> bool:
    """Take the free swings of a joint into its fit, which goes on from there; whether there are any.

    Args:
        joint: After a fit of what its drive does.
        out: Takes what is used, and what is not.
    """
    import numpy as np

    before = joint.fit
    assert before is not None
    found, states, viscous = [], list(before.states), []
    used = left = 0.0
    for index, recording in enumerate(joint.recordings):
        swings, kept = _possible(joint, recording), []
        for start in swings.starts.tolist():
            one = _alone(joint, index, Swings(np.array([start], dtype=np.intp), swings.rows), before)
            if one is not None:
                kept.append((start, one))
        seconds = swings.rows * recording.step
        used += len(kept) * seconds
        left += float(recording.off.sum()) * recording.step - len(kept) * seconds
        found.append(Swings(np.array([start for start, _ in kept], dtype=np.intp), swings.rows))
        if kept:
            parts = [one.states[0] for _, one in kept]
            states.append((np.concatenate([q for q, _ in parts]), np.concatenate([qd for _, qd in parts])))
            viscous += [one.values["viscous"] for _, one in kept]
    if used + left == 0.0:
        return False
    _tell(joint, used, left, out)
    if not viscous:
        return False
    values = dict(before.values)
    if "viscous" not in before.free and not joint.parted:
        # What the fit had as the drive's alone.
        values["viscous"] = max(min(float(np.median(viscous)), values["kd"]), 0.0)
        values["kd"] -= values["viscous"]
    joint.swings = found
    joint.fit = replace(before, values=values, states=tuple(states))
    return True


def _tell(joint: JointInWork, used: float, left: float, out: Collector) -> None:
    place = Span(next(recording.log.path for recording in joint.recordings if recording.off.any()))
    message = f"{format_number(used, 3)} s of free swing with the drive off are fitted too"
    if not used:
        message = (
            f"{format_number(left, 3)} s with the drive off are left out: the joint does not swing free there"
        )
    elif left > 0.5 * used:
        message += f", {format_number(left, 3)} s are not"
    help = None
    if left > 0.5 * used:
        help = "the joint stands, is at an end of its range, or something else moves it, such as a brake or a hand"
    out.info("SYS034", message, where=joint.actuator.joint, span=place, help=help)


def _possible(joint: JointInWork, recording: Recording) -> Swings:
    """Pieces with the drive off and away from the ends of the joint's range, of the length that leaves out least."""
    import numpy as np

    away = recording.off
    limits = joint.actuator.position_range
    if limits is not None:
        margin = STOP * (limits[1] - limits[0])
        q = recording.position
        away = away & (q > limits[0] + margin) & (q < limits[1] - margin)
    parts = stretches(recording.time, away)
    longest = max(round(PIECE / recording.step), LEAST_PIECE)
    least = max(math.ceil(LEAST_TIME / recording.step), LEAST_PIECE)
    lengths = sorted({min(last - first, longest) for first, last in parts if last - first >= least})
    if not lengths:
        return Swings(np.empty(0, dtype=np.intp), least)
    rows = max(lengths, key=lambda rows: sum((last - first) // rows * rows for first, last in parts))
    return Swings(cut(parts, rows, recording.released["position"]), rows)


def _alone(joint: JointInWork, index: int, swings: Swings, fit: Fit) -> Fit | None:
    """A piece by itself, with friction and inertia of its own; None where it does not swing free."""
    import numpy as np

    assert joint.scale is not None
    part = swung(joint, index, swings)
    noise = fit.noise["position"]
    if float(np.nanmax(part.cut("position")) - np.nanmin(part.cut("position"))) < MOVES * noise:
        return None
    low = {**joint.low, "viscous": 0.0}
    search = Search([part], joint.bounds, OWN, joint.scale, low)
    found = descend(search, {**fit.values, "viscous": max(fit.values["viscous"], 0.0)})
    return found if found.noise["position"] < FREE * noise else None
