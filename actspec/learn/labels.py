"""Torques that no sensor read: what the compiled model needs for the logged motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, listed
from actspec.learn.windows import Dataset, with_rows
from actspec.logs import Log, LogError
from actspec.robot.view import RobotView
from actspec.sysid.links import bench_model, links_along

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SLIDES = 0.05
"""Speed at which dry friction is 3/4 of what it is when it slides [rad/s or m/s]. Chosen: near what sensors resolve;
below it friction may be anything between both signs, and an even course between them adds no jump."""


def inferred(
    data: Dataset, robot: RobotView, logs: Sequence[Log], base: str | None, out: Collector
) -> Dataset:
    """The logs with the torques that the model with the spec's armature and friction needs.

    tau = M(q) q'' + armature q'' + load(q, q') + viscous q' + coulomb sign(q'), in all logged joints at once; joints
    that are not logged and the base are held.

    Args:
        data: Without torques.
        robot: The model.
        logs: Their recordings.
        base: `fixed`: a base that is free in the model was held.
        out: Takes what is assumed.

    Raises:
        LogError: the base is free.
        RobotError: the model does not tell the links' inertia.
    """
    import numpy as np

    _check_base(robot, logs, base)
    unknown = [a.joint for a in data.actuators if a.armature.value is None]
    if unknown:
        message = f"armature is unknown, and counts as 0: {listed(unknown)}"
        out.warning("LRN023", message, help="a network learned with it makes up for it in this model alone")
    by_name = {actuator.joint: actuator for actuator in data.actuators}
    labels: dict[tuple[str, str], tuple[Array, Array]] = {}
    for path in dict.fromkeys(track.log.path for track in data.tracks):
        parts = [r for found in data.recordings.values() for r in found if r.log.path == path]
        names = [part.joint for part in parts]
        time = max((part.time for part in parts), key=len)
        columns = {}
        for name in ("position", "velocity", "acceleration"):
            columns[name] = np.stack([np.interp(time, p.time, getattr(p, name)) for p in parts], axis=1)
        bias = np.array([by_name[name].encoder_bias.value or 0.0 for name in names])
        held = parts[0].log.sidecar.base
        if held is None:
            message = "the sidecar does not say how the base was held: as in the model's reference pose"
            out.info(
                "LRN024",
                message,
                span=Span(path),
                help="write `base: {orientation: [1, 0, 0, 0]}` beside the log",
            )
        q, qd, qdd = columns["position"] - bias, columns["velocity"], columns["acceleration"]
        links = links_along(robot, names, q, qd, None if held is None else held.orientation)
        torque = np.einsum("nij,nj->ni", links.inertia, qdd) + links.load
        for j, name in enumerate(names):
            actuator = by_name[name]
            dry = np.tanh(qd[:, j] / SLIDES) * (actuator.friction_coulomb.value or 0.0)
            own = (actuator.armature.value or 0.0) * qdd[:, j] + (
                actuator.friction_viscous.value or 0.0
            ) * qd[:, j]
            labels[path, name] = (time, torque[:, j] + own + dry)
    tracks = []
    for track in data.tracks:
        time, torque = labels[track.log.path, track.joint]
        tracks.append(with_rows(track, np.interp(track.time, time, torque)))
    return replace(data, tracks=tuple(tracks))


def _check_base(robot: RobotView, logs: Sequence[Log], base: str | None) -> None:
    """A free base must have been held: what carries it is no joint's torque."""
    import mujoco

    names = {
        log.path: [*log.joints, *(name for name in log.ignored if name.startswith("base."))] for log in logs
    }
    moving = [
        log.path
        for log in logs
        if log.base is not None or any(n == "base" or n.startswith("base.") for n in names[log.path])
    ]
    if moving:
        message = "the log has base columns, and torques are inferred on a base that is held"
        raise LogError.of(
            "LRN024", message, Span(moving[0], 1), help="log the robot hung up, with --base fixed"
        )
    model, _ = bench_model(robot, [], None)
    free = bool((model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE)).any())
    if free and base is None and any(log.sidecar.base is None for log in logs):
        message = "the model's base is free, and nothing says that it was held"
        help = "a robot that was hung up: --base fixed, or `base: {orientation: [1, 0, 0, 0]}` beside the log"
        raise LogError.of("LRN024", message, Span(logs[0].path), help=help)
