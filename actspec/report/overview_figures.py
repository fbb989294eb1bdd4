"""The pictures of an overview, as data: what each shows, of which joints."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import listed
from actspec.fields import units_of
from actspec.ir import ActuatorSet, JointActuator, JointKind
from actspec.report.axes import Axis, speed_and_torque
from actspec.report.compare import by_actuator, by_variant, step_chart
from actspec.report.plot import COMMAND, FIT, READ, Chart, Line, Points
from actspec.report.row_pictures import Stacks
from actspec.report.tables import percent
from actspec.study.compare import Comparison
from actspec.study.measures import BEYOND, Track, bounds_at, has_line

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SHOWN = 3.0
"""Time of a log that a picture of its tracking shows [s]. Chosen: a few steps of a gait."""
MOST_POINTS = 4000
"""Of a cloud; more are thinned evenly. Chosen: a picture of them is 30 kB."""
SPEEDS = 200
"""At which a bound is drawn."""
WIDER = 1.15
"""Of the fastest speed, what an envelope shows."""


@dataclass(frozen=True, slots=True)
class Figure:
    """One picture.

    Attributes:
        kind: `envelope`, `step`, `damping` or `tracking`.
        joints: That it shows.
        chart: What is drawn.
        caption: What it shows, in words.
        words: What else there is to say below it.
    """

    kind: str
    joints: tuple[str, ...]
    chart: Chart | Stacks
    caption: str
    words: str = ""


def envelopes(
    actuators: ActuatorSet, groups: Sequence[Sequence[JointActuator]], tracks: Mapping[str, Sequence[Track]]
) -> Iterator[Figure]:
    """Torque against speed of each distinct actuator, with what its motor can in four quadrants."""
    for group in groups:
        joints = tuple(actuator.joint for actuator in group)
        chart, beyond, count = _envelope(group[0], [t for name in joints for t in tracks.get(name, ())])
        what = (
            "the motor's torque-speed line and limit" if has_line(group[0]) else "the limit; no line is known"
        )
        words = f"{listed(list(joints), 4)}: {what}"
        if count and (beyond or has_line(group[0])):
            words += f"; {percent(beyond / count)} of the log's points are beyond"
        yield Figure("envelope", joints, chart, words)


def _envelope(actuator: JointActuator, tracks: Sequence[Track]) -> tuple[Chart, int, int]:
    """The picture, points beyond the bounds, and all points."""
    import numpy as np

    logged = [t for t in tracks if t.torque is not None]
    torque = np.concatenate([t.torque for t in logged if t.torque is not None]) if logged else np.empty(0)
    speed = np.concatenate([t.velocity for t in logged]) if logged else np.empty(0)
    good = np.isfinite(torque) & np.isfinite(speed)
    torque, speed = torque[good], speed[good]
    line = actuator.motor_line
    no_load = None if line is None or line.no_load_speed is None else line.no_load_speed.value
    if line is not None and line.curve is not None:
        no_load = line.curve.no_load_speed.value
    known = [float(np.abs(speed).max())] if len(speed) else []
    known += [no_load] if no_load else []
    known += [actuator.velocity_limit.value] if not known and actuator.velocity_limit.value else []
    fastest = WIDER * max(known, default=10.0)
    speeds = np.linspace(-fastest, fastest, SPEEDS)
    limit = actuator.effort_limit.value
    marks: list[Any] = []
    beyond = np.zeros(len(torque), dtype=bool)
    if limit:
        low, high = bounds_at(actuator, speeds)
        named = "motor" if has_line(actuator) else "limit"
        marks += [Line(speeds, high, named, COMMAND), Line(speeds, low, "", COMMAND)]
        least, most = bounds_at(actuator, speed)
        beyond = np.maximum(torque - most, least - torque) > BEYOND * limit
    for rows, label, colour in ((~beyond, "log", READ), (beyond, "beyond", FIT)):
        at = np.flatnonzero(rows)
        at = at[:: max(1, -(-len(at) // MOST_POINTS))]
        if len(at):
            marks.append(Points(speed[at], torque[at], label, colour))
    chart = Chart(
        f"{actuator.joint}: torque against speed",
        *speed_and_torque(actuator.kind, fastest),
        marks,
        width=420,
        height=230,
    )
    return chart, int(beyond.sum()), len(torque)


def steps(comparison: Comparison) -> Iterator[Figure]:
    """The step of each distinct actuator."""
    for rows in by_actuator(comparison):
        chart = step_chart(by_variant(rows))
        words = (
            f"{listed(list(rows[0].joints), 4)}: a step worth half of the effort limit, by law and in MuJoCo"
        )
        yield Figure("step", rows[0].joints, chart, words)


def dampings(actuators: ActuatorSet) -> Iterator[Figure]:
    """What brakes each distinct actuator in proportion to its speed, by who does."""
    groups: dict[tuple[float, float, JointKind], list[str]] = {}
    for actuator in actuators.joints:
        kd = 0.0 if actuator.kd is None else actuator.kd.value or 0.0
        key = (kd, actuator.friction_viscous.value or 0.0, actuator.kind)
        groups.setdefault(key, []).append(actuator.joint)
    for kind, unit in ((JointKind.HINGE, "N*m*s/rad"), (JointKind.SLIDE, "N*s/m")):
        mine = {key: joints for key, joints in groups.items() if key[2] is kind}
        if not mine:
            continue
        rows = [
            (joints[0] + (f" +{len(joints) - 1}" if len(joints) > 1 else ""), key[:2])
            for key, joints in mine.items()
        ]
        chart = Stacks(
            "damping by origin", Axis("damping", unit), rows, ("kd of the drive", "viscous friction")
        )
        words = "what the drive takes, inside of its limit, and what the joint takes, outside of it"
        if any(len(joints) > 1 for joints in mine.values()):
            words += "; +3: and of three joints more"
        names = tuple(joint for joints in mine.values() for joint in joints)
        yield Figure("damping", names, chart, "Damping by origin", words)


def trackings(tracks: Mapping[str, Sequence[Track]], actuators: ActuatorSet) -> Iterator[Figure]:
    """Command and position of each joint over the first seconds of its first log."""
    for joint, mine in tracks.items():
        track = mine[0]
        actuator = actuators.joint(joint)
        units = units_of(JointKind.HINGE if actuator is None else actuator.kind)
        rows = track.time <= track.time[0] + SHOWN
        time = track.time[rows]
        marks: list[Any] = []
        if track.command is not None:
            marks.append(Line(time, track.command[rows], "command", COMMAND, "dashed", stairs=True))
        marks.append(Line(time, track.position[rows], "position", READ))
        chart = Chart(
            f"{joint}: command and position",
            Axis("time", "s"),
            Axis("position", units.position),
            marks,
            width=420,
            height=160,
        )
        yield Figure("tracking", (joint,), chart, f"{joint}: the first {SHOWN:g} s of the log")
