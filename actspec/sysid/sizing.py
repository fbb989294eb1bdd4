"""How large an experiment may be: half-amplitudes at which the spec's joints keep within range, speed and torque.

Joints that move together are coupled through the links, as the virtual robot moves them. Of joints that move one after
the other, each is moved while the others stand, by several amplitudes at once.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import listed
from actspec.fields import PLACEHOLDER
from actspec.ir import JointActuator
from actspec.logs import LogError
from actspec.robot.view import RobotView
from actspec.sysid.course import Course
from actspec.sysid.figures import Bounds, Figures, figures_of
from actspec.sysid.links import links_along
from actspec.sysid.motion import move
from actspec.sysid.virtual import expected

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

ROOM = 0.8
"""Most of the speed and torque that the experiment may take. Chosen: the robot is not quite the spec."""
TRIES = 25
SHRINK = (0.3, 0.95)
"""Least and greatest factor on an amplitude that takes too much, on the way to what is allowed."""
AMPLITUDES = 8
"""Of one joint that are tried at once."""
LEAST = 0.03
"""Smallest of them, as a share of the largest; where it takes too much, as much smaller ones are tried once more."""
POSES = 65
"""Of a joint along its way at which the links are asked; between them they are straight lines. Chosen: they are smooth,
and the error is a part in thousands."""
SETTLES = 1.0
"""Time after a joint's turn in which it comes to rest [s]."""


@dataclass(frozen=True, slots=True)
class Wanted:
    """An experiment without its size.

    Attributes:
        robot: Its model.
        actuators: Of the joints to move.
        time: Of the commands [s], shape (n,).
        shapes: Courses between -1 and 1 by joint: as long as `time` together, else its part of it.
        middles: Where each command swings about [rad or m].
        most: Largest half-amplitudes [rad or m].
        orientation: Of the base, w, x, y, z; None: as in the file.
    """

    robot: RobotView
    actuators: Sequence[JointActuator]
    time: Array
    shapes: Mapping[str, Array]
    middles: Mapping[str, float]
    most: Mapping[str, float]
    orientation: Sequence[float] | None


@dataclass(frozen=True, slots=True)
class Sized:
    """One joint's part of an experiment, and what the spec makes of it; shape (n,) each.

    Attributes:
        amplitude: Half of it [rad or m].
        limited_by: `range`, `speed` or `torque`.
        command: [rad or m].
        q: Position, without the encoder's bias [rad or m].
        qd: [rad/s or m/s].
        torque: Of the drive [N*m or N].
    """

    amplitude: float
    limited_by: str
    command: Array
    q: Array
    qd: Array
    torque: Array


def sized_together(wanted: Wanted) -> dict[str, Sized]:
    """All joints at once.

    Raises:
        LogError: no amplitude is small enough.
        RobotError: the model does not tell the links' inertia.
    """
    import numpy as np

    names = [actuator.joint for actuator in wanted.actuators]
    sizes, limited = dict(wanted.most), dict.fromkeys(names, "range")
    over: list[str] = []
    # Of each joint that took too much: the size, and how much of what is allowed.
    before: dict[str, tuple[float, float]] = {}
    for _ in range(TRIES):
        given = np.stack([wanted.middles[n] + sizes[n] * wanted.shapes[n] for n in names], axis=1)
        moved = expected(wanted.robot, wanted.actuators, wanted.time, given, wanted.orientation)
        over = []
        for actuator, *parts in zip(wanted.actuators, *(part.T for part in moved), strict=True):
            why, share = _taken(actuator, wanted.middles[actuator.joint], *parts)
            if share > 1.0:
                over.append(actuator.joint)
                size = sizes[actuator.joint]
                factor = _factor(size, share, before.get(actuator.joint))
                before[actuator.joint] = size, share
                sizes[actuator.joint] = factor * size
                limited[actuator.joint] = why
        if not over:
            columns = zip(given.T, *(part.T for part in moved), strict=True)
            return {n: Sized(sizes[n], limited[n], *found) for n, found in zip(names, columns, strict=True)}
    raise _too_large(over)


def _factor(size: float, share: float, before: tuple[float, float] | None) -> float:
    """By what an amplitude is made smaller that takes `share` of what is allowed.

    Gravity, friction and the other joints take what does not shrink with it: the line through the last two tries tells.
    """
    wanted = 1.0 / share
    if before is not None and before[1] > share:
        steepness = (before[1] - share) / (before[0] - size)
        wanted = min(wanted, 1.0 - (share - 1.0) / (steepness * size))
    return min(max(wanted, SHRINK[0]), SHRINK[1])


def sized_alone(wanted: Wanted) -> dict[str, Sized]:
    """One joint after the other; those with the same drive are moved in one go.

    Raises: as `sized_together`.
    """
    alike: dict[tuple[object, ...], list[int]] = {}
    for j, actuator in enumerate(wanted.actuators):
        alike.setdefault((*figures_of(actuator).values(), Bounds.of(actuator)), []).append(j)
    found: dict[str, Sized] = {}
    for group in alike.values():
        found |= _sized_group(wanted, group)
    return {actuator.joint: found[actuator.joint] for actuator in wanted.actuators}


def _sized_group(wanted: Wanted, group: Sequence[int]) -> dict[str, Sized]:
    import numpy as np

    links = {j: _alone(wanted, j) for j in group}
    # Of each joint, an amplitude that is too large, and why; None: the range's own is not.
    above: dict[int, tuple[float, str] | None] = dict.fromkeys(group)
    top = {j: wanted.most[wanted.actuators[j].joint] for j in group}
    tried = {j: np.geomspace(top[j], LEAST * top[j], AMPLITUDES) for j in group}
    best: dict[int, Sized] = {}
    for _ in range(2):
        found = _moved_alone(wanted, links, tried)
        for j, sizes in tried.items():
            for size, sized in zip(sizes, found[j], strict=True):
                why, share = _taken(wanted.actuators[j], wanted.middles[wanted.actuators[j].joint], *sized)
                if share <= 1.0:
                    limit = above[j]
                    best[j] = _whole(wanted, j, float(size), "range" if limit is None else limit[1], sized)
                    break
                above[j] = (float(size), why)
        tried = {j: LEAST * sizes for j, sizes in tried.items() if j not in best}
        if not tried:
            break
    if lacking := [wanted.actuators[j].joint for j in group if j not in best]:
        raise _too_large(lacking)
    # Between the largest that is allowed and the one above it.
    tried = {
        j: np.linspace(limit[0], best[j].amplitude, AMPLITUDES + 1)[1:-1]
        for j, limit in above.items()
        if limit is not None
    }
    found = _moved_alone(wanted, links, tried) if tried else {}
    for j, sizes in tried.items():
        for size, sized in zip(sizes, found[j], strict=True):
            why, share = _taken(wanted.actuators[j], wanted.middles[wanted.actuators[j].joint], *sized)
            if share <= 1.0:
                best[j] = _whole(wanted, j, float(size), best[j].limited_by, sized)
                break
    return {wanted.actuators[j].joint: best[j] for j in group}


def _too_large(joints: Iterable[str]) -> LogError:
    return LogError.of(
        "SYS041",
        f"no amplitude keeps speed and torque within {ROOM:.0%} of what the spec allows, and the joint "
        f"within its range: {listed(joints)}",
        help="gravity alone may take the torque: choose another pose by default_pose, or a slower experiment",
    )


def _taken(actuator: JointActuator, middle: float, q: Array, qd: Array, torque: Array) -> tuple[str, float]:
    """What an experiment takes most of, `range`, `speed` or `torque`, and how much of what is allowed.

    The joint may go as far as its range does, however far its command goes: near a resonance it goes further.
    """
    import numpy as np

    speeds = [actuator.velocity_limit.value, getattr(actuator.no_load_speed, "value", None)]
    fastest = min((s for s in speeds if s is not None and s < PLACEHOLDER), default=math.inf)
    limit = actuator.effort_limit.value
    taken = {
        "range": 0.0,
        "speed": float(np.abs(qd).max()) / (ROOM * fastest),
        "torque": 0.0 if limit is None else float(np.abs(torque).max()) / (ROOM * limit),
    }
    if actuator.position_range is not None:
        low, high = actuator.position_range
        taken["range"] = max(
            float(q.max() - middle) / (high - middle), float(middle - q.min()) / (middle - low)
        )
    why = max(taken, key=lambda name: taken[name])
    return why, taken[why]


def _alone(wanted: Wanted, joint: int) -> tuple[Array, Array, Array, Array]:
    """Poses of a joint, the others at their middles; links' inertia, load and its slope there."""
    import numpy as np

    name = wanted.actuators[joint].joint
    # What is reached beyond the command counts at the last pose, with its slope.
    poses = wanted.middles[name] + 1.5 * wanted.most[name] * np.linspace(-1.0, 1.0, POSES)
    path = np.tile([wanted.middles[a.joint] for a in wanted.actuators], (POSES, 1))
    path[:, joint] = poses
    names = [a.joint for a in wanted.actuators]
    links = links_along(wanted.robot, names, path, 0.0 * path, wanted.orientation)
    return poses, links.inertia[:, joint, joint], links.load[:, joint], links.slope[:, joint]


def _moved_alone(
    wanted: Wanted, links: Mapping[int, tuple[Array, Array, Array, Array]], tried: Mapping[int, Array]
) -> dict[int, list[Array]]:
    """How joints with the same drive move, each by each amplitude: position, speed and torque, shape (3, n_row).

    Each begins at rest under its load, moves, and has some time to come to rest.
    """
    import numpy as np

    first = wanted.actuators[next(iter(tried))]
    values = figures_of(first)
    step = float(wanted.time[1] - wanted.time[0])
    slot = len(wanted.time) // len(wanted.actuators)
    # Until the first command of a piece has gone through delay and filter, that of the piece before it would act.
    wait = math.ceil((values["delay"] + 8.0 * values["lag"]) / step) + 2
    rows = slot + round(SETTLES / step)
    commands, columns, rests = [], [], []
    for j, sizes in tried.items():
        name, (poses, inertia, load, slope) = wanted.actuators[j].joint, links[j]
        middle = wanted.middles[name]
        there, steep = (float(np.interp(middle, poses, part)) for part in (load, slope))
        rest = middle - (there + values["kp"] * values["bias"]) / (values["kp"] + steep)
        for size in sizes:
            command = np.concatenate(
                [np.full(wait, middle), middle + size * wanted.shapes[name], np.full(rows - slot, middle)]
            )
            commands.append(command)
            columns.append([np.interp(command, poses, part) for part in (inertia, load, slope)])
            rests.append(rest)
    command = np.concatenate(commands)
    inertias, loads, slopes = (np.concatenate(parts) for parts in zip(*columns, strict=True))
    time = step * np.arange(len(command), dtype=float)
    course = Course(time, command, 0.0 * time, inertias, loads, slopes, command)
    figures = Figures(**{name: np.array([value]) for name, value in values.items()})
    starts = wait + (wait + rows) * np.arange(len(commands))
    q = np.array(rests)[:, None]
    moved = move(course, figures, Bounds.of(first), starts, rows, q, 0.0 * q)
    parts = np.stack([moved.q, moved.qd, moved.torque])[..., 0]
    each = iter(range(len(commands)))
    return {j: [parts[:, :, next(each)] for _ in sizes] for j, sizes in tried.items()}


def _whole(wanted: Wanted, joint: int, size: float, limited_by: str, moved: Array) -> Sized:
    """A joint's part between the times in which it stands."""
    import numpy as np

    name, n = wanted.actuators[joint].joint, len(wanted.time)
    slot = n // len(wanted.actuators)
    first = joint * slot
    command = np.full(n, wanted.middles[name])
    command[first : first + slot] += size * wanted.shapes[name]
    found = []
    for part, at_rest in zip(moved, (True, False, True), strict=True):
        course = np.full(n, part[0] if at_rest else 0.0)
        there = part[: n - first]
        course[first : first + len(there)] = there
        course[first + len(there) :] = part[-1] if at_rest else 0.0
        found.append(course)
    return Sized(size, limited_by, command, *found)
