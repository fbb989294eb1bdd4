"""Logs with fewer rows than the drive got commands.

A fit takes each command as held until the next row. Where others were sent between, what acts on the joint is half a
row earlier than that: a delay makes up for it as far as it goes, and behind that kp does.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span
from actspec.fields import units_of
from actspec.sysid.course import Course
from actspec.sysid.recording import Recording
from actspec.sysid.system import WIDE
from actspec.sysid.work import FitOptions, JointInWork
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

DENSE = 40.0
"""Rows in a period of the drive's oscillation from which on nothing is tried. Measured on a chirp of 500
commands a second: with 26 rows kp is 0.3 % off, with 13 it is 20 %, with 5 58 %."""
NO_DELAY = 0.1
"""Delay up to which there is none, in rows. Chosen: beside what half a row does it is nothing."""
FINE = 5e-3
"""Longest time between the commands that are tried [s]. Chosen: as a drive's usual 200 Hz."""
EXPLAINS = 0.5
"""Position error with commands between the rows, over that without, below which they are the cause. Chosen: what else a
model lacks moves a joint as much with them as without."""


def judge_rows(
    joint: JointInWork,
    options: FitOptions,
    descend: Callable[[JointInWork, FitOptions, Collector], None],
    out: Collector,
) -> None:
    """Refuse a fit that is far better where commands are taken to go straight from row to row.

    Args:
        joint: After its fit.
        options: What the user asks.
        descend: Fits a joint.
        out: Takes the error.
    """
    fit = joint.fit
    assert fit is not None
    error = fit.noise["position"]
    step = max(recording.step for recording in joint.recordings)
    inertia = max(float(course.inertia.mean()) for course in joint.courses) + fit.values["armature"]
    period = 2.0 * math.pi * math.sqrt(inertia / max(fit.values["kp"], 1e-9))
    spread = WIDE * fit.std("delay") if "delay" in fit.free else 0.0
    # Where a delay is left it has made up for all of it. The readings' noise is no guide: motion between few rows is as
    # uneven.
    if period > DENSE * step or fit.values["delay"] > max(spread, NO_DELAY * step):
        return
    parts = [max(1, math.ceil(recording.step / FINE)) for recording in joint.recordings]
    dense = [_dense(r, c, n) for r, c, n in zip(joint.recordings, joint.courses, parts, strict=True)]
    trial = replace(
        joint,
        recordings=[recording for recording, _ in dense],
        courses=[course for _, course in dense],
        fit=None,
        scale=None,
        added=frozenset(),
        swings=(),
    )
    descend(trial, options, Collector())
    assert trial.fit is not None
    better = trial.fit.noise["position"]
    if better > EXPLAINS * error:
        return
    unit = units_of(joint.actuator.kind).position
    message = (
        f"a row comes every {format_number(1e3 * step, 3)} ms, {format_number(period / step, 2)} in a period of the "
        f"drive, and it got other commands between them: with commands that go straight from row to row the position "
        f"error falls from {format_number(error, 2)} to {format_number(better, 2)} {unit}, and kp from "
        f"{format_number(fit.values['kp'], 3)} to {format_number(trial.fit.values['kp'], 3)}"
    )
    help = (
        "log a row for each command that is sent, 40 in a period of the drive, "
        f"{format_number(1e3 * period / DENSE, 2)} ms apart, or hold each command from row to row"
    )
    place = Span(joint.recordings[0].log.path)
    out.error("SYS039", message, where=joint.actuator.joint, span=place, help=help)


def _dense(recording: Recording, course: Course, parts: int) -> tuple[Recording, Course]:
    """A recording and its course with rows between its own, without readings, the command on the line between them."""
    import numpy as np

    n = len(recording.time)
    rows, every = np.arange(n) * parts, np.arange((n - 1) * parts + 1)

    def line(signal: Array) -> Array:
        found: Array = np.interp(every, rows, signal)
        return found

    def sparse(signal: Array) -> Array:
        found = np.full(len(every), np.nan)
        found[rows] = signal
        return found

    command, speed_command = line(recording.command), line(recording.speed_command)
    finer = replace(
        recording,
        time=line(recording.time),
        command=command,
        speed_command=speed_command,
        measured={name: sparse(signal) for name, signal in recording.measured.items()},
        off=np.append(np.repeat(recording.off[:-1], parts), recording.off[-1]),
        released={name: sparse(signal) for name, signal in recording.released.items()},
        position=line(recording.position),
        velocity=line(recording.velocity),
        acceleration=line(recording.acceleration),
        starts=recording.starts * parts,
        rows=(recording.rows - 1) * parts + 1,
        late=recording.late * parts,
    )
    return finer, replace(course.divided(parts), command=command, speed_command=speed_command)
