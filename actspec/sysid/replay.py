"""A results file beside its logs: the joints of the file, let loose on what the logs command.

Each piece of a log begins at the state at which it agrees best with its readings, as in the fit. Figures that the file
does not tell are those that do best here; with them the joint moves as in the fit, although none of them is known.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector
from actspec.ir import ActuatorSet, Command
from actspec.logs import Log
from actspec.robot.view import RobotView
from actspec.spec.results import JointResult, Results, value_of
from actspec.sysid.begin import begin
from actspec.sysid.checks import check
from actspec.sysid.coupling import course_of, dense, fitted, links_of, read
from actspec.sysid.course import Course
from actspec.sysid.descent import Piecewise, Search, descend, seen
from actspec.sysid.figures import Bounds, Figures, figures_of, time_constant
from actspec.sysid.gains import GAINS, gains_of
from actspec.sysid.identified import FIELDS
from actspec.sysid.motion import Moved
from actspec.sysid.recording import Recording, driven, record
from actspec.sysid.settle import Going, moved_each, settled
from actspec.sysid.stand import Stand, idle

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

FIT, SPEC = "fit", "spec"
"""What a simulated joint is called: its motion was fitted, or it is the spec's with a figure of another method."""
BESIDE = 0.1
"""Distance of a delay from the end of a row, in rows, within which both rows are tried for what torques tell. Chosen:
a fit knows it to less."""
SHOWS = 1e-6
"""Least slope of gravity's torque over kp at which an encoder's bias shows."""


@dataclass(frozen=True, slots=True)
class Replay:
    """One joint in one log.

    Attributes:
        joint: Its name.
        recording: What was read.
        course: Commands, and the links along the path.
        bounds: Of the drive.
        figures: By the names of `Figures`; what the results do not tell is what does best here.
        told: Names of those that are the results'.
        spread: What the sensors would read of the fitted joint, `position`, `velocity` and `torque`, and its
            `friction`; NaN outside of the pieces, shape (n,).
        starts: First rows of the pieces.
        rows: Length of each.
        name: `FIT` or `SPEC`.
    """

    joint: str
    recording: Recording
    course: Course
    bounds: Bounds
    figures: Mapping[str, float]
    told: frozenset[str]
    spread: Mapping[str, Array]
    starts: NDArray[np.intp]
    rows: int
    name: str = FIT

    @property
    def model(self) -> Mapping[str, Array]:
        """Channels that were read, of the fitted joint; NaN outside of the pieces, shape (n,)."""
        return {name: self.spread[name] for name in self.recording.measured}

    def residual(self, channel: str) -> Array:
        """Read less simulated; NaN where one of them is not there, shape (n,)."""
        found: Array = self.recording.measured[channel] - self.model[channel]
        return found

    @property
    def simulated(self) -> Recording:
        """The log that the fitted joint would have given, without noise."""
        import numpy as np

        def whole(name: str, otherwise: Array) -> Array:
            found: Array = np.where(np.isfinite(self.spread[name]), self.spread[name], otherwise)
            return found

        position = whole("position", self.recording.position)
        velocity = whole("velocity", self.recording.velocity)
        return replace(self.recording, measured=dict(self.model), position=position, velocity=velocity)

    def ranked(self, channel: str = "position") -> list[int]:
        """The pieces by their root-mean-square residual, least first."""
        import numpy as np

        left = self.residual(channel)
        sizes = [float(np.nanmean(left[s : s + self.rows] ** 2)) for s in self.starts]
        return [int(i) for i in np.argsort(sizes, kind="stable")]


def replay(
    actuators: ActuatorSet,
    robot: RobotView,
    logs: Sequence[Log],
    results: Results,
    out: Collector,
    tell: Callable[[int, int], None] = lambda done, total: None,
) -> dict[str, list[Replay]]:
    """Every joint of the results in every log that has it.

    Args:
        actuators: The spec, resolved.
        robot: Its model.
        logs: Those that are there.
        results: The file.
        out: Takes what is wrong with the logs.
        tell: Takes how many joints are done, and of how many.

    Raises:
        RobotError: the model does not tell the links' inertia.
    """
    known = {joint.joint: Bounds.of(joint) for joint in actuators.joints}
    limits = {joint.joint: joint.position_range for joint in actuators.joints}
    stand = Stand(robot, actuators)
    found: dict[str, list[Replay]] = {}
    total, done = sum(name in results.joints for log in logs for name in log.joints), 0
    for log in logs:
        recorded = {}
        for name in known:
            actuator = actuators.joint(name)
            if name not in results.joints or name not in log.joints or actuator is None:
                continue
            if actuator.command is Command.POSITION and not idle(log.joints[name]):
                recording = record(log, driven(log, log.joints[name], actuator, out), out)
                recorded[name] = [] if recording is None else [recording]
        checked = check(recorded, known, limits, out)
        usable = {name: mine[0] for name, mine in checked.items() if mine}
        if usable:
            first = {name: _figures(actuators, name, results.joints[name], log, logs) for name in usable}

            def tell_more(count: int, before: int = done) -> None:
                tell(before + count, total)

            for one in _replayed(stand, log, usable, known, first, results, tell_more):
                found.setdefault(one.joint, []).append(one)
        done += len(recorded)
    return found


def _replayed(
    stand: Stand,
    log: Log,
    recordings: Mapping[str, Recording],
    known: Mapping[str, Bounds],
    values: Mapping[str, Mapping[str, float]],
    results: Results,
    tell: Callable[[int], None],
) -> list[Replay]:
    names, every = list(recordings), list(recordings.values())
    figures = dict(values)
    states: list[tuple[Array, Array]] | None = None
    paths = [read(recordings[name], values[name]["bias"]) for name in names]
    # Joints of one log move each other: the second time as they are fitted in place of a filter's.
    for again in (False, True) if len(names) > 1 else (False,):
        links, beside = links_of(stand, every, paths, names)
        logs = [_pieces(r, course_of(r, links, beside, j)) for j, r in enumerate(every)]
        if not again:
            for name, log_of in zip(names, logs, strict=True):
                told = results.joints[name]
                figures[name] = (
                    _moving(told, recordings[name], log_of, known[name], values[name])
                    if results.method == "friction" and "torque" in log_of.measured
                    else _completed(told, log_of, known[name], values[name])
                )
        going = [_read(Going(pieces, figures[n], known[n])) for pieces, n in zip(logs, names, strict=True)]
        found = settled(going, states, 1 if again else 2)
        states = [at for at, _ in found]
        tell(len(names) // (1 if again or len(names) == 1 else 2))
        if len(names) > 1 and not again:
            finely = [dense(pieces, r) for pieces, r in zip(logs, every, strict=True)]
            finer = [replace(one, log=pieces) for one, pieces in zip(going, finely, strict=True)]
            paths = [
                fitted(r, figures[name]["bias"], [(pieces, moved)])
                for r, name, pieces, moved in zip(
                    every, names, finely, moved_each(finer, states), strict=True
                )
            ]
    return [
        _replay(recordings[name], one, moved, results)
        for name, one, (_, moved) in zip(names, going, found, strict=True)
    ]


def _read(going: Going) -> Going:
    """With the delay by which its torques are read: at the end of a row the best delay may be in the next one."""
    import numpy as np

    course, delay = going.log.course, going.values["delay"]
    step = float(np.median(np.diff(course.time)))
    row = round(delay / step)
    if "torque" not in going.log.measured or not row or abs(delay / step - row) > BESIDE:
        return going

    def off(one: Going) -> float:
        ((_, moved),) = settled([one], steps=1)
        model = seen(one.log, one.values, moved)["torque"]
        return float(np.nanmean((one.log.cut("torque") - model) ** 2))

    return min((going, *(replace(going, reading=(row + side) * step) for side in (-0.5, 0.5))), key=off)


def _completed(
    result: JointResult, log: Piecewise, bounds: Bounds, values: Mapping[str, float]
) -> Mapping[str, float]:
    """The figures, those that the results do not tell as they do best here."""
    free = _free(result, log.course, values)
    if not free:
        return values
    return descend(Search([log], bounds, free, _scales(values, log.course), _lowest()), values).values


def _moving(
    result: JointResult, recording: Recording, log: Piecewise, bounds: Bounds, values: Mapping[str, float]
) -> Mapping[str, float]:
    """All figures that constant speeds do not tell, as they do best here: the rollout that the method begins with."""
    first = begin([recording], [log.course], bounds, [0], None)
    kp, kd = first.gains[0]
    free = ["kp", "kd", "armature", "viscous", "delay"]
    free = [name for name in free if _value(result, FIELDS[name][0]) is None]
    begun = {**values, **{name: first.values.get(name, values[name]) for name in free}, "kp": kp, "kd": kd}
    reading = (first.lag - 0.5) * recording.step if first.lag else begun["delay"]
    search = Search([log], bounds, tuple(free), _scales(begun, log.course), _lowest(), reading)
    return descend(search, begun).values


def _pieces(recording: Recording, course: Course) -> Piecewise:
    behind = recording.log.sidecar.torque == "joint"
    return Piecewise(course, recording.measured, recording.starts, recording.rows, behind)


def _value(result: JointResult, field: str) -> float | None:
    """What a results file says of a field [SI]; None: it has no value."""
    stated = value_of(result, field)
    return None if stated is None or stated.value is None else float(stated.value)


def _figures(
    actuators: ActuatorSet, name: str, result: JointResult, log: Log, logs: Sequence[Log]
) -> dict[str, float]:
    """All figures of a joint in a log: the results' before gains as sent before the spec's."""
    actuator = actuators.joint(name)
    assert actuator is not None
    found = figures_of(actuator)
    mine = [other for other in logs if name in other.joints]
    none: frozenset[str] = frozenset()
    gains = gains_of(actuator, mine, torque=True, free=none, hold=none, out=Collector())
    place = next(gains.used[i] for i, other in enumerate(mine) if other is log)
    for figure, (field, _) in FIELDS.items():
        value = _value(result, field)
        if value is not None:
            found[figure] = time_constant(value) if figure == "lag" else value
        elif field in result.bounds_hit:
            found[figure] = 0.0
    for gain in GAINS:
        first, sent = gains.sets[0].sent(gain), gains.sets[place].sent(gain)
        held = None if result.gains is None or place else getattr(result.gains, gain).value
        if _value(result, gain) is None:
            found[gain] = next((value for value in (held, sent) if value is not None), found[gain])
        elif place and first and sent is not None:
            # Results have the gains of the first set; those of another log are off by the same share.
            found[gain] *= sent / first
    # A search that begins at nothing has no way to go.
    found["kp"] = found["kp"] or 1.0
    return found


def _free(result: JointResult, course: Course, values: Mapping[str, float]) -> tuple[str, ...]:
    """Figures that the results do not tell, of which not all can be free."""
    import numpy as np

    listed = (*result.unidentifiable, *result.bounds_hit)
    untold = {figure for figure, (field, _) in FIELDS.items() if field in listed}
    if {"kd", "viscous"} <= untold:
        untold.discard("viscous")  # only their sum shows
    if {"kp", "armature"} <= untold:
        untold -= {"armature", "bias"}  # ratios to the inertia alone
    if float(np.abs(course.slope).max()) < SHOWS * values["kp"]:
        untold.discard("bias")
    return tuple(name for name in Figures.names() if name in untold)


def _scales(values: Mapping[str, float], course: Course) -> dict[str, float]:
    """Sizes of the figures, for differences."""
    import numpy as np

    inertia = float(course.inertia.mean()) + values["armature"]
    damping = max(values["kd"] + values["viscous"], 0.02 * (values["kp"] * inertia) ** 0.5)
    torque = max(0.1 * values["kp"] * float(np.std(course.command - course.path)), 1e-4)
    step = float(np.median(np.diff(course.time)))
    speed = 0.1 * float(np.ptp(course.path)) / max(float(np.ptp(course.time)), step)
    return {
        "kp": values["kp"], "kd": damping, "armature": inertia, "coulomb": torque, "viscous": damping,
        "static": torque, "stribeck_velocity": max(speed, 1e-3), "delay": step, "bias": 0.01, "lag": step,
    }  # fmt: skip


def _lowest() -> dict[str, float]:
    return {name: (-float("inf") if name == "bias" else 0.0) for name in Figures.names()}


def _replay(recording: Recording, one: Going, moved: Moved, results: Results) -> Replay:
    import numpy as np

    log = one.log
    spread: dict[str, Array] = {}
    behind = moved.friction if log.joint_torque else 0.0
    for name, pieces in (
        ("position", moved.q + one.values["bias"]),
        ("velocity", moved.qd),
        ("torque", moved.torque - behind),
        ("friction", moved.friction),
    ):
        whole = np.full(len(recording.time), np.nan)
        for piece, start in enumerate(log.starts):
            whole[start : start + log.rows] = pieces[:, piece, 0]
        spread[name] = whole
    told = {
        name
        for name, (field, _) in FIELDS.items()
        if _value(results.joints[recording.joint], field) is not None
    }
    return Replay(
        recording.joint,
        recording,
        log.course,
        one.bounds,
        one.values,
        frozenset(told),
        spread,
        log.starts,
        log.rows,
        SPEC if results.method in ("frequency", "step") else FIT,
    )
