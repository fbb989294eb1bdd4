"""Torques that no sensor read: what the compiled model needs for the logged motion."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import count
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, listed
from actspec.learn.floating import floating
from actspec.learn.spline import spline, stiffness
from actspec.learn.steps import Course, sharpened
from actspec.learn.windows import Dataset, with_rows
from actspec.logs import Log, LogError
from actspec.robot.view import RobotView
from actspec.sysid.links import bench_model, links_along
from actspec.sysid.recording import Recording
from actspec.sysid.stand import Stand

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SLIDES = 0.05
"""Speed from which a joint slides [rad/s or m/s]. Chosen: near what sensors resolve."""
MOST_TOUCHING = 0.5
"""Share of rows in contact from which on it is said what else they may be. Chosen: half."""


def inferred(
    data: Dataset,
    stand: Stand,
    logs: Sequence[Log],
    base: str | None,
    out: Collector,
    progress: Callable[[int, int], None] | None = None,
) -> Dataset:
    """The logs with the torques that the model with the spec's armature and friction needs.

    tau = M(q) q'' + armature q'' + load(q, q') + viscous q' + coulomb sign(q'), in all logged joints at once, those of
    other groups as read; joints that are not logged and the base are held. A base whose motion is in the log flew free,
    and rows in contact have no torque. Of a joint that stands, dry friction is anything between both signs: the torque
    is told within that, see `Track.slack`.

    Args:
        data: Without torques.
        stand: The model, and where its other joints are.
        logs: Their recordings.
        base: `fixed`: a base that is free in the model was held, whatever columns tell of it.
        out: Takes what is assumed.
        progress: Called with parts done, of how many.

    Raises:
        LogError: the base is free, or no row tells a torque.
        RobotError: the model does not tell the links' inertia.
    """
    import numpy as np

    _check_base(stand.robot, logs, base)
    stand.check(logs, out)
    out.raise_if_failed(LogError)
    stand.tell(data.moved, out)
    unknown = [a.joint for a in data.actuators if a.armature.value is None]
    if unknown:
        message = f"armature is unknown, and counts as 0: {listed(unknown)}"
        out.warning("LRN023", message, help="a network learned with it makes up for it in this model alone")
    by_name = {actuator.joint: actuator for actuator in data.actuators}
    labels: dict[tuple[str, str], tuple[Array, Array]] = {}
    in_contact = 0
    courses: dict[str, dict[str, Course]] = {}
    paths = list(dict.fromkeys(track.log.path for track in data.tracks))
    # A joint's motion is a part, the links along a log another, and the last one the steps of all commands.
    tell, done, total = progress or (lambda done, total: None), count(1), len(data.tracks) + len(paths) + 1
    for path in paths:
        parts = [r for found in data.recordings.values() for r in found if r.log.path == path]
        names = [part.joint for part in parts]
        time = max((part.time for part in parts), key=len)
        moved = []
        for part in parts:
            moved.append(_motion(part))
            tell(next(done), total)
        columns = [[np.interp(time, p.time, x) for x in m[:3]] for p, m in zip(parts, moved, strict=True)]
        bias = np.array([by_name[name].encoder_bias.value or 0.0 for name in names])
        log = parts[0].log
        held, moves = log.sidecar.base, log.base is not None and base is None
        if held is None and not moves:
            message = "the sidecar does not say how the base was held: as in the model's reference pose"
            out.info(
                "LRN024",
                message,
                span=Span(path),
                help="write `base: {orientation: [1, 0, 0, 0]}` beside the log",
            )
        q, qd, qdd = (np.stack(column, axis=1) for column in zip(*columns, strict=True))
        q = q - bias
        robot, others = stand.beside(log, names)
        pairs = zip((q, qd, qdd), motion_of_others(log, others, time), strict=True)
        every, motion = [*names, *others], [np.hstack(pair) for pair in pairs]
        if moves:
            torque, touching = floating(robot, every, log, time, *motion)
            torque[touching] = np.nan
            in_contact += int(touching.sum())
            message = f"{int(touching.sum())} of {len(time)} rows are in contact: they are left out"
            # Whatever carries a robot is told by its base; what hangs it up is no floor.
            help = "by the columns base.*: where the robot was hung up, --base fixed leaves those out"
            out.info(
                "LRN026", message, span=Span(path), help=help if touching.mean() > MOST_TOUCHING else None
            )
        else:
            turned = None if held is None else held.orientation
            # Nothing here asks for the load's slope.
            links = links_along(robot, every, motion[0], motion[1], turned, every=len(q))
            torque = np.einsum("nij,nj->ni", links.inertia, motion[2]) + links.load
        tell(next(done), total)
        for j, name in enumerate(names):
            actuator = by_name[name]
            slides = np.abs(qd[:, j]) > SLIDES
            coulomb = actuator.friction_coulomb.value or 0.0
            static = 0.0 if actuator.friction_static is None else actuator.friction_static.value or 0.0
            own = (actuator.armature.value or 0.0) * qdd[:, j] + (
                actuator.friction_viscous.value or 0.0
            ) * qd[:, j]
            told = torque[:, j] + own + np.where(slides, coulomb * np.sign(qd[:, j]), 0.0)
            labels[path, name] = (time, np.where(slides, 0.0, max(static, coulomb)))
            part, (*_, stiff, order) = parts[j], moved[j]
            courses.setdefault(name, {})[path] = Course(
                part.time, part.command, time, q[:, j], qd[:, j], told, slides, stiff, order
            )
    limits = [by_name[name].effort_limit.value or np.inf for name in courses]
    torques = dict(
        zip(courses, sharpened([[*mine.values()] for mine in courses.values()], limits), strict=True)
    )
    tell(next(done), total)
    told_at = {
        (path, name): torque
        for name, mine in courses.items()
        for path, torque in zip(mine, torques[name], strict=True)
    }
    tracks = []
    for track in data.tracks:
        time, slack = labels[track.log.path, track.joint]
        track = with_rows(track, np.interp(track.time, time, told_at[track.log.path, track.joint]))
        tracks.append(replace(track, slack=np.interp(track.time, time, slack)))
    if not any(len(track.rows) for track in tracks):
        message = "no row is left whose motion tells a torque, with a whole history behind it"
        help = "log longer, or take fewer --taps"
        if in_contact:
            message += f": {in_contact} rows are in contact, as the columns base.* tell"
            help = "of a robot that was hung up: --base fixed; one that walks has such rows in flight alone"
        out.error("LRN005", message, span=Span(tracks[0].log.path), help=help)
        out.raise_if_failed(LogError)
    return replace(data, tracks=tuple(tracks))


def _motion(part: Recording) -> tuple[Array, Array, Array, float, int]:
    """Position, speed and acceleration of a joint, by a spline through the velocities, or else the positions.

    With its stiffness, and the derivative of it that is the acceleration.
    """
    import numpy as np

    if "velocity" in part.measured:
        stiff = stiffness(part.time, part.measured["velocity"])
        speed = spline(part.time, part.measured["velocity"], stiff)
        return part.position, speed(part.time), speed.derivative()(part.time), stiff, 1
    stiff = stiffness(part.time, part.measured["position"])
    course = spline(part.time, part.measured["position"], stiff)
    q, qd, qdd = (np.asarray(course(part.time, k)) for k in range(3))
    return q, qd, qdd, stiff, 2


def motion_of_others(log: Log, others: Mapping[str, Array], time: Array) -> tuple[Array, Array, Array]:
    """Position, speed and acceleration of joints by their readings.

    Args:
        log: Theirs.
        others: Joint to position at the log's rows [rad or m]; what is not a number is bridged.
        time: At which the motion is asked for [s], shape (n,).

    Returns: Each of shape (n, n_joint).
    """
    import numpy as np

    found = np.empty((3, len(time), len(others)))
    for j, read in enumerate(others.values()):
        known = np.isfinite(read)
        signal = np.interp(time, log.time[known], read[known])
        course = spline(time, signal, stiffness(time, signal))
        found[..., j] = [course(time, derivative) for derivative in range(3)]
    return found[0], found[1], found[2]


def _check_base(robot: RobotView, logs: Sequence[Log], base: str | None) -> None:
    """A free base must have been held, or the log must tell how it moved: what carries it is no joint's torque."""
    import mujoco

    if base is not None:
        return
    for log in logs:
        odd = [n for n in (*log.joints, *log.ignored) if n == "base" or n.startswith("base.")]
        if odd and log.base is None:
            message = f"the log has {listed(odd)}, which do not tell how the base moved"
            help = "see docs/sysid.md for the columns; of a robot that was hung up: --base fixed"
            raise LogError.of("LRN024", message, Span(log.path, 1), help=help)
    still = [log for log in logs if log.base is None and log.sidecar.base is None]
    model, _ = bench_model(robot, [], None)
    if still and (model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE)).any():
        message = "the model's base is free, and nothing says that it was held"
        help = "a robot that was hung up: --base fixed, or `base: {orientation: [1, 0, 0, 0]}` beside the log"
        raise LogError.of("LRN024", message, Span(still[0].path), help=help)
