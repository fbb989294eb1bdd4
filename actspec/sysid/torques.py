"""A torque against what a drive answers to, and what it moves: its limit, its sign, its lag, and whose it is.

A position drive gives kp (command - position) - kd velocity, whatever its gains are, as far as its limit goes: a
regression on the two says how much of a torque that explains, of this joint or of another, now or some rows ago.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector
from actspec.fields import units_of
from actspec.sysid.begin import CLIPPED, LONGEST, MOVES, regress
from actspec.sysid.course import Course
from actspec.sysid.figures import Bounds
from actspec.sysid.recording import LEAST_ROWS, Recording, with_torque_of
from actspec.sysid.spoilt import texture
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

AT_LIMIT = 0.03
"""Share of rows at the largest torque or command, from which on it is a limit. Chosen."""
AT_MOST = 0.002
"""Within this share of the largest torque a row is at it."""
AROUND = 11
"""Rows around one by which it is told whether the drive is asked for another torque."""
FLAT = 0.6
"""Share of the rows within ten times that of the largest torque that are at it, from which on it is clipped. Chosen:
0.3 for a sine, and near 1 for a limit."""
ABOVE = 1.2
"""Times the spec's limit above which a logged torque contradicts it. Chosen: sensors are better."""
OFTEN = 0.01
"""Share of the rows that must be above it, or at an end stop."""
EXCEEDS = 1.2
"""Times a level of the torque that the drive's own gains must ask for where its torque stays there, to call it a limit.
Chosen: what a low-pass or a delay makes of gains is less, and goes on changing."""
STAYS = 0.9
"""Share of these rows in which it must stay there. Chosen: a drive comes to its limit within a row or two."""
EVEN = 1.5
"""Standard deviation of a torque at its limit over its noise, up to which it stays there. Measured: 0.96 to 1.07 of
clipped ones; 2.7 and 2.8 of the peaks of two virtual logs with 50 rows a second, whose drive has no limit."""
STANDS = 6.0
"""Noise or counts of an encoder within which readings are of one place."""
LATEST = 0.1
"""Longest lag of a torque behind the motion that is looked for [s]. Chosen: a bus, or a filter, is faster."""
BETTER = 0.85
"""Share of what is left unexplained without a lag, below which what is left with one must be. Measured: without a lag
0.95 at least in twenty virtual logs; one of 3 rows at 500 Hz leaves 0.7, of one row at 200 Hz 0.2 to 0.8."""
EXPLAINED, STRANGE = 0.1, 0.5
"""Share of a torque's variance below which what is left is noise, and above which the torque is of something else.
Chosen: sound logs leave less than 0.02."""
NEAR = 2
"""Rows by which the command's delay is another from one lag of the torque to the next."""
OWN_ROW = "the torque is taken as that of the row's own command, which fits better"
OWN_ROW_HELP = "by the form of logs a row holds what was read before its command was sent"
MOST_ROWS = 4000
"""Rows by which that is told."""


@dataclass(frozen=True, slots=True)
class Answer:
    """How a torque answers to the error and the motion of a joint.

    Attributes:
        left: Share of its variance that they do not explain.
        late: Rows by which it is behind the motion.
        kp: By the regression [N*m/rad or N/m].
        kd: Likewise [N*m*s/rad or N*s/m].
    """

    left: float
    late: int
    kp: float
    kd: float


def check_torques(
    recordings: Mapping[str, list[Recording]], bounds: Mapping[str, Bounds], out: Collector
) -> None:
    """Judge the torques of all joints; what cannot be theirs is an error.

    Args:
        recordings: Joint to its part of every log; takes how late each torque is.
        bounds: Of the drives, by the spec.
        out: Takes what is found.
    """
    import numpy as np

    for name, mine in recordings.items():
        for i, recording in enumerate(mine):
            read = recording.measured.get("torque")
            if read is None or int(np.isfinite(read).sum()) < LEAST_ROWS:
                continue
            _limited(recording, bounds[name], out)
            others = [
                other
                for joint, theirs in recordings.items()
                for other in theirs
                if joint != name and other.log is recording.log
            ]
            mine[i] = replace(recording, late=_answering(recording, others, bounds[name], out))


def answer(torque: Array, cause: Recording, limit: float) -> Answer | None:
    """The regression of a torque on a joint's error and speed, at the lag at which it explains the most.

    Args:
        torque: At the rows of `cause`; NaN where it was not read.
        cause: The joint.
        limit: Of the drive [N*m or N]: what is near it does not count.
    """
    import numpy as np

    step, n = cause.step, len(torque)
    # As read: what a filter takes from fast motion looks like a lag.
    position, velocity = cause.measured["position"], cause.measured.get("velocity", cause.velocity)
    known = np.isfinite(position) & np.isfinite(velocity)
    free = np.isfinite(torque) & (np.abs(torque) < CLIPPED * limit)
    rows = np.flatnonzero(free)
    rows = rows[:: max(1, math.ceil(len(rows) / MOST_ROWS))]

    def tried(late: int, lag: int) -> Answer | None:
        """With a torque so many rows behind the motion, and so many behind the command."""
        used = rows[rows >= max(late, lag)]
        used = used[known[used - late]]
        at = used - late
        error = cause.command[used - lag] - position[at]
        speed = cause.speed_command[used - lag] - velocity[at]
        terms = np.stack([error, speed, np.sign(cause.velocity[at]), np.ones_like(error)], axis=1)
        told = regress([(terms, torque[used])])
        return None if told is None else Answer(told[1], late, told[0][0], told[0][1])

    latest = min(round(LATEST / step), n // 4)
    slowest = max(2, math.ceil(LONGEST / step))
    begun = [(one, lag) for lag in range(slowest + 1) if (one := tried(0, lag)) is not None]
    if not begun:
        return None
    prompt, lag = min(begun, key=lambda pair: pair[0].left)
    best = prompt
    for late in range(1, latest + 1):
        # What the motion is behind by comes off the command's own delay, more or less.
        near = [
            (one, at)
            for at in range(max(late, lag - NEAR), min(lag + NEAR, late + slowest) + 1)
            if (one := tried(late, at)) is not None
        ]
        if not near:
            break
        found, lag = min(near, key=lambda pair: pair[0].left)
        best = min(best, found, key=lambda one: one.left)
    return best if best.left < min(BETTER * prompt.left, EXPLAINED) else prompt


def rows_of(number: float) -> str:
    """So many rows, in words."""
    return "1 row" if number == 1 else f"{format_number(number, 3)} rows"


def _answering(recording: Recording, others: Sequence[Recording], bounds: Bounds, out: Collector) -> int:
    """The torque against its joint's error and motion, and against those of others; rows by which it is late."""
    torque, name, place = recording.measured["torque"], recording.joint, recording.place()
    own = answer(torque, recording, bounds.limit)
    if own is None:
        return 0
    if own.left > STRANGE:
        for other in others:
            theirs = answer(torque, other, bounds.limit) if len(other.time) == len(torque) else None
            if theirs is not None and theirs.left < EXPLAINED and theirs.kp > 0.0:
                message = f"the torque answers to the error of {other.joint}, not to its own"
                out.error("SYS015", message, where=name, span=place, help="columns are exchanged")
                break
    elif own.kp < 0.0 < own.kd:
        message = "the torque pulls from the command to the position, and brakes"
        out.error("SYS015", message, where=name, span=place, help="command and position are exchanged")
    elif own.kp < 0.0:
        help = "turn the sign of the torque's column"
        out.error("SYS014", "the torque pulls away from the command", where=name, span=place, help=help)
    return own.late


def prompt(recording: Recording, course: Course) -> Recording:
    """The recording with its torque earlier, where that seems to have been logged many rows late; see `late`.

    A torque that is late against error and speed may come from a slow drive. Where the joint's acceleration agrees
    better with what was read some rows later, it is the log that is late.

    Args:
        recording: As it was checked.
        course: Links along it.
    """
    late, recording = recording.late, replace(recording, late=0)
    if not late:
        return recording
    torque = recording.measured["torque"]
    if _moved(torque, recording, course, late) > BETTER * _moved(torque, recording, course, 0):
        return recording
    return with_torque_of(recording, late)


def _moved(torque: Array, recording: Recording, course: Course, late: int) -> float:
    """Variance that is left of a torque when links, inertia and friction are taken out of what it is rows later."""
    import numpy as np

    n, qd, acceleration = len(torque) - late, recording.velocity, recording.acceleration
    needed = course.inertia * acceleration + course.load
    rest = torque[late:] - needed[:n]
    used = np.isfinite(rest) & (np.abs(qd[:n]) > MOVES * np.abs(qd).max())
    terms = np.stack([acceleration, qd, np.sign(qd), np.ones_like(qd)], axis=1)[:n]
    told = regress([(terms[used], rest[used])])
    return math.inf if told is None else told[1] * float(np.var(rest[used]))


def _asked(recording: Recording) -> NDArray[np.bool_]:
    """Rows around which the position error changes, so that a drive without a limit gives another torque in each."""
    import numpy as np
    from scipy.ndimage import maximum_filter1d, minimum_filter1d

    position = recording.measured["position"]
    error = recording.command - np.where(np.isfinite(position), position, recording.position)
    seen = texture(position)
    changed = maximum_filter1d(error, AROUND) - minimum_filter1d(error, AROUND)
    return np.asarray(changed > max(STANDS * seen.noise, 2.0 * seen.count, 1e-6), dtype=bool)


def _limited(recording: Recording, bounds: Bounds, out: Collector) -> None:
    """A torque that is clipped where the spec has no limit, or is above the limit that it has."""
    import numpy as np

    read = recording.measured["torque"]
    size = np.abs(read[np.isfinite(read)])
    most = float(size.max())
    # What a drive gives where it holds a joint still is as even as a limit.
    asked = np.abs(read[np.isfinite(read) & _asked(recording)])
    at, near = (
        float(np.sum(asked > (1.0 - share) * most)) / len(size) for share in (AT_MOST, 10.0 * AT_MOST)
    )
    level = (most, at) if at > AT_LIMIT and at > FLAT * near else _level(recording)
    unit = units_of(recording.kind).torque
    limit = "none" if math.isinf(bounds.limit) else f"{format_number(bounds.limit)} {unit}"
    if level is not None and level[0] < 0.97 * bounds.limit:
        row = int(np.flatnonzero(np.abs(read) > (1.0 - AT_MOST) * level[0])[0])
        shown = f"the torque is clipped at {format_number(level[0], 4)} {unit} in {level[1]:.0%} of the rows"
        message = f"{shown}, the spec's limit is {limit}"
        help = "state the drive's effort_limit in the spec, or log a smaller experiment"
        out.error("SYS016", message, where=recording.joint, span=recording.place(row), help=help)
    above = np.abs(read) > ABOVE * bounds.limit
    if recording.log.sidecar.torque != "joint" and above.sum() > OFTEN * len(size):
        shown = f"the torque is above the spec's limit of {limit} in {int(above.sum())} rows, up to "
        message = f"{shown}{format_number(most, 4)} {unit}"
        help = (
            "state the drive's effort_limit in the spec"
            if most < 10.0 * bounds.limit
            else f"is it in m{unit}?"
        )
        place = recording.place(int(np.flatnonzero(above)[0]))
        out.error("SYS016", message, where=recording.joint, span=place, help=help)


def _level(recording: Recording) -> tuple[float, float] | None:
    """The level at which a torque with noise is clipped [N*m or N], and the share of rows; None: at none.

    The drive's gains by the torques below it ask for more than it there, and the torque stays.
    """
    import numpy as np

    read = recording.measured["torque"]
    noise = texture(read).noise
    size = np.abs(read)
    if not noise > 0.0:
        return None
    reach = STANDS * noise
    # The largest reading is some deviations above what it is a reading of.
    top = float(np.nanmedian(size[size > np.nanmax(size) - reach]))
    own = answer(read, recording, (top - 2.0 * reach) / CLIPPED)
    if own is None or own.kp <= 0.0 or own.left > EXPLAINED:
        return None
    error = recording.command - recording.measured["position"]
    speed = recording.speed_command - recording.measured.get("velocity", recording.velocity)
    asked = np.abs(own.kp * error + own.kd * speed) > EXCEEDS * top
    told = asked & np.isfinite(read)
    stays = told & (size > top - reach)
    if told.sum() < AT_LIMIT * len(read) or stays.sum() < STAYS * told.sum():
        return None
    if float(np.std(size[stays])) > EVEN * noise:
        # They differ by more than noise: peaks of a log of few rows a swing, which gains exceed there.
        return None
    return top, float(stays.sum()) / len(read)
