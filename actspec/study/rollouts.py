"""Which level's law moves as a log does that has no torque: rollouts of the robot on its stand, from logged states."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, RobotError, Span
from actspec.ir import ActuatorSet, Command, JointActuator
from actspec.laws import TorqueLaw
from actspec.learn.closed_loop import HORIZON, Bench, RollImpossible, network_drive
from actspec.learn.windows import Dataset
from actspec.learn.windows import Track as Sampling
from actspec.logs import Log
from actspec.simulate.reference import reaching_commands
from actspec.study.learned import WARM, Sampled
from actspec.study.measures import Track, held, laws_by_level
from actspec.sysid.stand import Stand

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from actspec.robot.view import RobotView

    Array = NDArray[np.float64]

MOST = 10
"""Most rollouts of a log, spread over it. Chosen: the error of their mean is then a third."""
FASTEST = 0.25
"""Largest part of a drive's own time constant J / kd in a step. Chosen: the torque is held over it."""


def position_errors(
    robot: RobotView,
    actuators: ActuatorSet,
    logs: Sequence[Log],
    tracks: Mapping[str, Sequence[Track]],
    learned: Mapping[str, Sampled],
    out: Collector,
) -> dict[str, dict[str, float]]:
    """RMSE of the position in rollouts of `HORIZON` under each level's law, joint by joint [rad or m].

    Joints that are not logged are held; all that are move each other. Delays and filters act. A joint that lacks a
    level goes by the spec there.

    Args:
        robot: Its model.
        actuators: The spec, resolved.
        logs: Of a robot whose base was held.
        tracks: By joint, of those without a torque.
        learned: Networks by joint.
        out: Takes why there are none.

    Returns: Joint to level to error; nothing of joints that cannot be rolled out.
    """
    import numpy as np

    squares: dict[str, dict[str, list[Array]]] = {}
    stand = Stand(robot, actuators)
    for log in logs:
        mine = [
            (actuator, track)
            for actuator in actuators.joints
            for track in tracks.get(actuator.joint, ())
            if track.path == log.path and track.command is not None and actuator.command is Command.POSITION
        ]
        laws = [laws_by_level(actuator, learned.get(actuator.joint)) for actuator, _ in mine]
        mine = [pair for pair, found in zip(mine, laws, strict=True) if "spec" in found]
        laws = [found for found in laws if "spec" in found]
        if not mine:
            continue
        try:
            networks = [law for own in laws for law in own.values() if isinstance(law, Sampled)]
            past = max((max(one.drive.network.taps) * one.step for one in networks), default=0.0)
            recurrent = any(one.drive.network.layers.recurrent for one in networks)
            bench = _bench(stand, log, mine, past=past, recurrent=recurrent)
            stand.tell({actuator.joint: [(log, track.position)] for actuator, track in mine}, out)
            starts = bench.starts()
            starts = starts[starts >= max(past / bench.step, bench.tracks[0].taps[-1] * recurrent)]
        except (RobotError, RollImpossible) as err:
            said = err.diagnostics[0].message if isinstance(err, RobotError) else str(err)
            out.info("DGN014", f"positions are not held to rollouts: {said}", span=Span(log.path))
            continue
        if not len(starts):
            message = f"no stretch of {HORIZON:g} s has every joint: positions are not held to rollouts"
            out.info("DGN014", message, span=Span(log.path))
            continue
        starts = starts[np.unique(np.linspace(0, len(starts) - 1, MOST).astype(int))]
        for level, left in _by_level(bench, laws, starts).items():
            for j, (actuator, _) in enumerate(mine):
                if level in laws[j]:
                    squares.setdefault(actuator.joint, {}).setdefault(level, []).append(left[:, :, j] ** 2)
    return {
        joint: {
            level: math.sqrt(float(np.mean(np.concatenate(parts, axis=None))))
            for level, parts in mine.items()
        }
        for joint, mine in squares.items()
    }


def _bench(
    stand: Stand,
    log: Log,
    mine: Sequence[tuple[JointActuator, Track]],
    *,
    past: float,
    recurrent: bool,
) -> Bench:
    """The robot on its stand, in steps that carry its drives.

    Args:
        stand: The model, the spec, and where joints are that are not logged.
        log: Of the tracks.
        mine: Joints and their tracks.
        past: How long networks look back [s].
        recurrent: Whether a network has a state.

    Raises:
        RollImpossible: the base is not said to have been held.
        RobotError: there is no model.
    """
    import mujoco
    import numpy as np

    step = stand.actuators.physics_dt.require()
    rates = [
        (a.kd.value or 0.0) / a.inertia_held.reference
        for a, _ in mine
        if a.kd is not None and a.inertia_held is not None
    ]
    parts = 1 if recurrent else max(math.ceil(step * max(rates, default=0.0) / FASTEST), 1)
    none = np.empty(0, dtype=np.intp)
    reach = math.ceil(max(past, WARM * step * recurrent) / log.step)
    sampled = []
    for actuator, track in mine:
        assert track.command is not None
        command, torque = held(track.command), np.full(len(track.time), np.nan)
        taps = 0, reach
        sampled.append(
            Sampling(
                log,
                actuator.joint,
                track.time,
                command,
                track.position,
                track.velocity,
                torque,
                1,
                none,
                taps,
            )
        )
    data = Dataset("", tuple(a for a, _ in mine), tuple(sampled), (0,), step, "inferred", {})
    bench = Bench(stand, data, sampled, step / parts)
    free = bool((bench.model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE)).any())
    if free and (log.sidecar.base is None or log.base is not None):
        raise RollImpossible(
            "the sidecar does not say that the base was held, `base: {orientation: [1, 0, 0, 0]}`"
        )
    return bench


def _by_level(
    bench: Bench, laws: Sequence[Mapping[str, TorqueLaw | Sampled]], starts: NDArray[np.intp]
) -> dict[str, Array]:
    """Errors of the position under each level that a joint has, shape (n_step, n_start, n_joint)."""
    found: dict[str, Array] = {}
    done: list[tuple[list[TorqueLaw | Sampled], Array]] = []
    for level in dict.fromkeys(name for own in laws for name in own):
        chosen = [own.get(level, own["spec"]) for own in laws]
        # Levels that differ in no joint are rolled out once.
        same = next((left for before, left in done if before == chosen), None)
        found[level] = bench.rolled(starts, _drive(bench, chosen), None) if same is None else same
        done.append((chosen, found[level]))
    return found


def _drive(bench: Bench, laws: Sequence[TorqueLaw | Sampled]) -> Callable[..., Array]:
    """Each joint under its own law, behind its own delay and filter."""
    import numpy as np

    clips = [law.drive.clip if isinstance(law, Sampled) else law for law in laws]
    reaching = reaching_commands(clips, bench.command, bench.step)
    learned: dict[int, tuple[Callable[..., Array], list[int]]] = {}
    for j, law in enumerate(laws):
        if isinstance(law, Sampled):
            key = id(law.drive.network)
            if key not in learned:
                # Its taps are physics steps.
                network = replace(law.drive.network, tap_period=law.step)
                learned[key] = network_drive(bench, network), []
            learned[key][1].append(j)

    def drive(starts: NDArray[np.intp], step: int, command: Array, q: Array, qd: Array) -> Array:
        asked = reaching[starts + step]
        torque = np.empty_like(q)
        for whole, columns in learned.values():
            torque[:, columns] = whole(starts, step, asked, q, qd)[:, columns]
        for j, law in enumerate(laws):
            if isinstance(law, Sampled):
                torque[:, j] = clips[j].torque(torque[:, j], q[:, j], qd[:, j])
            else:
                torque[:, j] = law.torque(asked[:, j], q[:, j] - bench.bias[j], qd[:, j])
        return torque

    return drive
