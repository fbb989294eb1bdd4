"""Flaws of a log, named before they become figures: signs, units, exchanged joints, lag, clipping, frozen columns.

What the readings contradict among themselves needs no model: a velocity is the position's derivative, a joint follows
its own command, a drive pulls towards it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector
from actspec.fields import units_of
from actspec.sysid.figures import Bounds
from actspec.sysid.recording import LEAST_ROWS, Recording
from actspec.sysid.speeds import SURE, check_speeds, correlated, unit_of
from actspec.sysid.spoilt import EXCITED, texture
from actspec.sysid.torques import AT_LIMIT, OFTEN, STANDS, check_torques
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SMALL = 5.0
"""Movement of a joint, as a standard deviation, in the noise or counts of its encoder below which it is too small."""
LIVELY = 3
"""Pieces in which it moves the most, of which the last counts."""
LEAST_PIECES = 10
"""Fewest pieces of which that is asked; of fewer the whole log counts."""
STILL = 3.0
"""Likewise below which no fit is tried: what is left of a joint in stiction is noise. Chosen."""
AGAIN = 3
"""Times that a joint, or a command, must come to an end at the same place. Chosen: twice may be chance."""
APART = 0.1
"""Least difference of the commands there, as a share of the command's range."""
ABSURD = 20.0
"""Ranges of a joint that its position goes over, from which it is no angle. Chosen: no zero explains it."""
BEYOND = 3.0
"""Likewise from which it may be one in degrees. Chosen: a twentieth of the range is that much in degrees, and a joint
without stops at its resonance goes over twice its range."""
OUTSIDE = 0.2
"""Share of the joint's range by which a position may be outside of it. Chosen: stops give way, and zeros are off."""


def check(
    recordings: Mapping[str, Sequence[Recording]],
    bounds: Mapping[str, Bounds],
    ranges: Mapping[str, tuple[float, float] | None],
    out: Collector,
) -> dict[str, list[Recording]]:
    """Judge the recordings of all joints; what is spoilt is left out and reported, or refused.

    Args:
        recordings: Joint to its part of every log.
        bounds: Of the drives, by the spec.
        ranges: Of the joints, by the model [rad or m]; None: unlimited.
        out: Takes what is found.

    Returns: The recordings, without what is spoilt.
    """
    found: dict[str, list[Recording]] = {}
    for name, mine in recordings.items():
        found[name] = []
        for recording in mine:
            if not _moves(recording, out) or not _large(recording, out):
                continue
            if len(recording.time) >= LEAST_ROWS:
                _follows(recording, recordings, out)
                _clipped(recording, out)
            _within(recording, recordings, ranges, out)
            found[name].append(recording)
    check_speeds(found, recordings, out)
    check_torques(found, bounds, out)
    return found


def _moves(recording: Recording, out: Collector) -> bool:
    import numpy as np

    if float(np.ptp(recording.position)) > EXCITED:
        return True
    message = f"the joint moves by {np.ptp(recording.position):.2g} in the whole log"
    help = "is the drive on, and the column that of this joint?"
    out.error("SYS011", message, where=recording.joint, span=recording.place(), help=help)
    return False


def _shifted(recording: Recording, command: Array) -> tuple[float, float]:
    """Slope and correlation of the position over a command, at the lag at which they agree best."""
    import numpy as np

    best = (0.0, 0.0)
    rows = max(1, round(0.2 / recording.step))
    known = np.isfinite(recording.measured["position"])
    for lag in np.unique(np.linspace(0, rows, 12).astype(int)):
        n = len(command) - lag
        tried = correlated(recording.position[lag:][known[lag:]], command[:n][known[lag:]])
        if abs(tried[1]) > abs(best[1]):
            best = tried
    return best


def _follows(recording: Recording, recordings: Mapping[str, Sequence[Recording]], out: Collector) -> None:
    """A joint follows its own command, in its own unit."""
    slope, sure = _shifted(recording, recording.command)
    place, name = recording.place(), recording.joint
    if sure < -SURE:
        message = f"the position goes against the command (correlation {sure:.2f})"
        out.error("SYS014", message, where=name, span=place, help="one of the two columns has the wrong sign")
    elif sure > SURE and (unit := unit_of(slope)) is not None and unit != "turns":
        message = f"the position moves {slope:.3g} times as far as the command: it is in {unit}"
        out.error("SYS014", message, where=name, span=place, help=f"write [{_written(unit)}] in its header")
    elif sure > SURE and (unit := unit_of(1.0 / slope)) is not None and unit != "turns":
        message = f"the command moves {1.0 / slope:.3g} times as far as the position: it is in {unit}"
        out.error("SYS014", message, where=name, span=place, help=f"write [{_written(unit)}] in its header")
    elif abs(sure) < 0.5:
        for other, theirs in recordings.items():
            for second in theirs:
                if other == name or second.log is not recording.log:
                    continue
                if (
                    len(second.command) == len(recording.position)
                    and _shifted(recording, second.command)[1] > SURE
                ):
                    message = f"the position follows the command of {other}, not its own"
                    out.error("SYS015", message, where=name, span=place, help="columns are exchanged")
                    return


def _clipped(recording: Recording, out: Collector) -> None:
    """A joint that stops at one place however far its command goes, and a command that is cut off itself."""
    import numpy as np

    position, command = recording.measured["position"], recording.command
    unit = units_of(recording.kind).position
    seen = texture(position)
    near = max(STANDS * max(seen.noise, seen.count), 1e-9)
    wide = float(np.ptp(command))
    for way in (1.0, -1.0):
        top = float(np.nanmax(way * position))
        # How far the command went while the joint was there; what came there by its own speed goes back at once.
        tops = [
            (first, last, float((way * command)[first:last].max()))
            for first, last in _runs(way * position > top - near)
        ]
        ends = [(first, last) for first, last, peak in tops if peak > top + near]
        peaks = [peak for *_, peak in tops if peak > top + near]
        often = sum(last - first for first, last in ends) > OFTEN * len(command)
        if len(peaks) >= AGAIN and often and max(peaks) - min(peaks) > max(APART * wide, 2.0 * near):
            row = ends[0][0]
            message = (
                f"the joint stops at {way * top:.4g} {unit} {len(ends)} times, while its command goes on to "
                f"{way * min(peaks):.4g} to {way * max(peaks):.4g} {unit}"
            )
            help = "a clamp behind the log, or an end stop: log what the drive gets, or command a smaller movement"
            out.warning("SYS046", message, where=recording.joint, span=recording.place(row), help=help)
        speed = np.abs(np.diff(command, prepend=command[0]))
        usual = float(np.quantile(speed, 0.9))
        edge = float((way * command).max())
        # A step comes there by a jump, and a slow sine by less and less.
        flat = [
            (first, last)
            for first, last in _runs(way * command > edge - 1e-9 * wide)
            if first > 1 and 0.3 * usual < speed[first - 1] < 3.0 * usual
        ]
        if len(flat) >= AGAIN and sum(last - first for first, last in flat) > AT_LIMIT * len(command):
            row = flat[0][0]
            message = f"the command is cut off at {way * edge:.4g} {unit} {len(flat)} times: it is fitted as it stands"
            out.info("SYS046", message, where=recording.joint, span=recording.place(row))


def _runs(wanted: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """First rows, and those after the last, of stretches of three rows at least."""
    import numpy as np

    edges = np.flatnonzero(np.diff(np.concatenate([[False], wanted, [False]]).astype(int))).tolist()
    return [(first, last) for first, last in zip(edges[::2], edges[1::2], strict=True) if last - first >= 3]


def _reach(recording: Recording) -> tuple[float, float]:
    """Where a joint's position is, but for a hundredth at either end [rad or m]."""
    import numpy as np

    low, high = np.nanquantile(recording.measured["position"], [0.01, 0.99])
    return float(low), float(high)


def _exchanged_with(
    recording: Recording,
    recordings: Mapping[str, Sequence[Recording]],
    ranges: Mapping[str, tuple[float, float] | None],
) -> str | None:
    """The joint in whose range this one is, and which is in its own, where that lies wholly elsewhere; None: none."""

    def inside(one: Recording, limits: tuple[float, float]) -> bool:
        low, high = _reach(one)
        return limits[0] <= low and high <= limits[1]

    limits, (low, high) = ranges[recording.joint], _reach(recording)
    if limits is None or (low <= limits[1] and high >= limits[0]):
        return None
    for other, theirs in recordings.items():
        there = ranges[other]
        if there is not None and inside(recording, there):
            for one in theirs:
                if one.log is recording.log and inside(one, limits):
                    return other
    return None


def _within(
    recording: Recording,
    recordings: Mapping[str, Sequence[Recording]],
    ranges: Mapping[str, tuple[float, float] | None],
    out: Collector,
) -> None:
    """Positions within the joint's range: where all columns are in degrees, none contradicts another."""
    import numpy as np

    limits = ranges[recording.joint]
    if limits is None:
        return
    read = recording.measured["position"]
    low, high = _reach(recording)
    margin = OUTSIDE * (limits[1] - limits[0])
    if low > limits[0] - margin and high < limits[1] + margin:
        return
    other = _exchanged_with(recording, recordings, ranges)
    if other is not None:
        message = f"the position lies within the range of {other}, and that of {other} within its own"
        help = "columns of the two joints are exchanged"
        out.error("SYS015", message, where=recording.joint, span=recording.place(), help=help)
        return
    unit = units_of(recording.kind).position
    row = int(np.nanargmax(np.maximum(read - limits[1], limits[0] - read)))
    shown = f"the position goes from {low:.4g} to {high:.4g} {unit}, the joint's range is "
    message = f"{shown}{format_number(limits[0], 4)} to {format_number(limits[1], 4)} {unit}"
    place, factor = recording.place(row), 180.0 / math.pi if unit == "rad" else 1e3
    if (
        high - low > BEYOND * (limits[1] - limits[0])
        and low / factor > limits[0]
        and high / factor < limits[1]
    ):
        shown = "[deg], and the speeds [deg/s]," if unit == "rad" else "[mm], and the speeds [mm/s],"
        help = f"write {shown} in the header, of the command too, if that is what they are"
        out.error("SYS047", message, where=recording.joint, span=place, help=help)
        return
    if high - low > ABSURD * (limits[1] - limits[0]):
        help = "write the unit that it has in the header, or the joint's own angle in place of counts"
        out.error("SYS047", message, where=recording.joint, span=place, help=help)
        return
    help = "is it the joint's own angle, with the model's sign and zero?"
    out.warning("SYS047", message, where=recording.joint, span=place, help=help)


def _written(unit: str) -> str:
    return {"degrees": "deg", "thousandths": "mrad"}.get(unit, unit)


def _large(recording: Recording, out: Collector) -> bool:
    """Whether a joint moves more than its encoder's noise or count; little more is reported."""
    import numpy as np

    read = recording.measured["position"]
    seen = texture(read)
    spread = float(np.nanstd(read))
    if len(recording.starts) >= LEAST_PIECES:
        # One piece may have a jump to where the log begins, and a joint that waits for its turn moves in few of them.
        rows = recording.starts[:, None] + np.arange(recording.rows)
        spread = float(np.sort(np.nanstd(read[rows], axis=1))[-LIVELY])
    grain = max(seen.noise, seen.count / math.sqrt(12.0))
    if spread >= SMALL * grain:
        return True
    unit = units_of(recording.kind).position
    message = f"the joint moves by {spread:.2g} {unit} (standard deviation), its encoder's noise is {grain:.2g} {unit}"
    help = "command a larger movement: `actspec sysid design` takes what range, speed and torque allow"
    if spread < STILL * grain:
        message += ": nothing can be fitted"
        out.error("SYS011", message, where=recording.joint, span=recording.place(), help=help)
        return False
    out.warning("SYS043", message, where=recording.joint, span=recording.place(), help=help)
    return True
