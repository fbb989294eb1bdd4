"""What logs hold for a network: how long, how fast, how far, and what a policy does beyond them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, listed
from actspec.learn.train import input_ranges
from actspec.learn.windows import Dataset, Track
from actspec.sysid.figures import Bounds
from actspec.sysid.recording import GAP

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SHORT = 20.0
"""Time of a joint below which a network is reported to have seen little [s]. Chosen."""
AT_LIMIT = 0.98
"""Share of the effort limit from which a torque counts as saturated."""
OFTEN = 0.2
"""Share of saturated rows from which on they are a finding: such a row tells the limit and nothing else."""
BEYOND = 0.01
"""Share of a policy's rows outside of the logs' range that is a finding."""
MOST_POWER = 0.95
"""Share of the velocity's power below the band's end."""


@dataclass(frozen=True, slots=True)
class JointData:
    """Of a joint.

    Attributes:
        joint: Its name.
        minutes: Of rows with a whole history.
        rate: Of the rows [Hz].
        gaps: Stretches without rows.
        saturation: Share of rows at the effort limit; None: no torque, or no limit.
        band: Frequency below which 95 % of the velocity's power is [Hz].
        ranges: Of `error` [rad or m] and `velocity` [rad/s or m/s], as a manifest has them.
        torque_rms: [N*m or N]; None: no torque.
        outside: Share of a policy's rows outside of them: `error`, `velocity`; None: no policy.
    """

    joint: str
    minutes: float
    rate: float
    gaps: int
    saturation: float | None
    band: float
    ranges: dict[str, dict[str, float]]
    torque_rms: float | None
    outside: dict[str, float] | None


def survey(data: Dataset, policy: Dataset | None, out: Collector) -> tuple[JointData, ...]:
    """What the logs hold of each joint.

    Args:
        data: The logs.
        policy: A policy's logs, or None.
        out: Takes findings, as warnings.
    """
    import numpy as np

    found = []
    short: dict[str, float] = {}
    for actuator in data.actuators:
        tracks = [t for t in data.tracks if t.joint == actuator.joint and len(t.rows)]
        if not tracks:
            continue
        steps = [float(np.median(np.diff(t.time))) for t in tracks]
        seconds = sum(len(t.rows) * step for t, step in zip(tracks, steps, strict=True))
        limit = Bounds.of(actuator).limit
        torque = np.concatenate([t.torque[t.rows] for t in tracks])
        told = bool(np.isfinite(torque).all())
        saturation = (
            float(np.mean(np.abs(torque) > AT_LIMIT * limit)) if told and math.isfinite(limit) else None
        )
        here = Dataset(data.group, (actuator,), tuple(tracks), data.taps, data.period, data.kind, {})
        ranges = input_ranges(here, [t.rows for t in tracks])
        place = Span(tracks[0].log.path)
        if seconds < SHORT:
            short[actuator.joint] = seconds
        if saturation is not None and saturation > OFTEN:
            message = f"the torque is at its limit in {saturation:.0%} of the rows"
            help = "such a row tells the limit alone: log smaller commands"
            out.warning("LRN021", message, where=actuator.joint, span=place, help=help)
        beyond = None
        if policy is not None:
            mine = [t for t in policy.tracks if t.joint == actuator.joint]
            if mine:
                beyond = {name: _beyond(mine, name, ends) for name, ends in ranges.items()}
                _judge(actuator.joint, mine, ranges, beyond, out)
        found.append(
            JointData(
                actuator.joint,
                seconds / 60.0,
                1.0 / float(np.median(steps)),
                sum(int((np.diff(t.time) > GAP * step).sum()) for t, step in zip(tracks, steps, strict=True)),
                saturation,
                max(_band(t) for t in tracks),
                ranges,
                float(np.sqrt(np.mean(torque**2))) if told else None,
                beyond,
            )
        )
    _judge_length(short, len(found), data, out)
    return tuple(found)


def _judge_length(short: Mapping[str, float], joints: int, data: Dataset, out: Collector) -> None:
    """Report joints with too few rows at once: they are in the same logs.

    Args:
        short: Such joints, with the time of their rows [s].
        joints: How many there are.
        data: The logs.
        out: Takes the finding.
    """
    if not short:
        return
    first = next(track for track in data.tracks if track.joint in short)
    low, high = (f"{end(short.values()):.3g}" for end in (min, max))
    each = f"{low if low == high else f'{low} to {high}'} s"
    message = f"{each} of rows with a whole history, {SHORT:g} s at least make a network"
    if len(short) > 1:
        message = (
            f"{'all ' if len(short) == joints else ''}{len(short)} joints have {message}: {listed(short)}"
        )
    where = next(iter(short)) if len(short) == 1 else data.group
    out.warning("LRN020", message, where=where, span=Span(first.log.path), help="log longer")


def _beyond(tracks: list[Track], name: str, ends: dict[str, float]) -> float:
    import numpy as np

    values = np.concatenate([getattr(track, name)[track.rows] for track in tracks])
    return float(np.mean((values < ends["low"]) | (values > ends["high"]))) if len(values) else 0.0


def _judge(
    joint: str,
    tracks: list[Track],
    ranges: dict[str, dict[str, float]],
    beyond: dict[str, float],
    out: Collector,
) -> None:
    import numpy as np

    for name, share in beyond.items():
        if share > BEYOND:
            values = np.concatenate([getattr(track, name)[track.rows] for track in tracks])
            ends = ranges[name]
            message = (
                f"the {name} is outside of the logs' range in {share:.1%} of the policy's rows: {ends['low']:.3g} to "
                f"{ends['high']:.3g} there, {values.min():.3g} to {values.max():.3g} here"
            )
            help = "log what the policy does, or larger commands"
            out.warning("LRN022", message, where=joint, span=Span(tracks[0].log.path), help=help)


def _band(track: Track) -> float:
    """Frequency below which most of the velocity's power is [Hz]."""
    import numpy as np

    good = np.isfinite(track.velocity)
    if good.sum() < 8:
        return 0.0
    even = np.interp(track.time, track.time[good], track.velocity[good])
    power = np.abs(np.fft.rfft((even - even.mean()) * np.hanning(len(even)))) ** 2
    share = np.cumsum(power) / max(float(power.sum()), 1e-300)
    at = np.fft.rfftfreq(len(even), float(np.median(np.diff(track.time))))
    return float(at[int(np.searchsorted(share, MOST_POWER))])
