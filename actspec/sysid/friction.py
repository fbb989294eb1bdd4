"""Friction over speed, from stretches of constant speed: what the drive gives there, less gravity.

A torque that is read once a row is not the mean of the row's torque. On a ramp the command is ahead of the joint by
kp v T when it comes and is caught up with until the next one comes, so what is read depends on when, between two
commands, it is read: by up to kp v T / 2, which looks like viscous friction. Which command a reading has in it shows in
the reading; how long it has been there follows from the delay, to a fraction of a row. Both come from a rollout of the
same log, and the mean of the row is what counts here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Collector, Span
from actspec.fields import unit_of_kind
from actspec.sysid.course import Course
from actspec.sysid.identified import FIELDS, Indicator, JointFit, Parameter, State, bounded
from actspec.sysid.judge import VAGUE
from actspec.sysid.recording import Recording, longest_step
from actspec.sysid.system import WIDE
from actspec.sysid.work import JointInWork
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

EVEN = 1e-3
"""Change of a command's speed from row to row, as a share of it, below which it is constant."""
DIGITS = 2e-7
"""Of a command, as a share of its greatest: single precision and what a log is written with."""
FADED = math.log(100.0)
"""How far what a ramp began with has faded before its stretch counts, as the logarithm of the share."""
BLOCK = 0.1
"""Time over which torque and speed are averaged [s]. Chosen: noise of a row is gone, and a slow swing is not."""
LEAST_ROWS = 8
"""Fewest rows of a block."""
SLOW = 1e-3
"""Least constant speed [rad/s or m/s]."""
OUTLIER = 1.5
"""Residual from which on a point counts less, in standard deviations of the points."""
APART = 1.5
"""Least ratio of the fastest to the slowest speed for friction to be told by speed."""
SMALL = 0.1
"""Standard deviation of viscous friction from which on it is not told, as a share of dry friction at full speed."""
STRIBECK = 4.0
"""Standard deviations by which friction must rise towards low speeds for that to count."""


@dataclass(frozen=True, slots=True)
class Cloud:
    """Friction over speed; shape (n,) each, a point a tenth of a second.

    Attributes:
        speed: Signed [rad/s or m/s].
        torque: Of friction, in the direction of the drive: positive where the speed is [N*m or N].
        stretch: Number of the stretch of constant speed that a point is of.
        lead: Means of what a torque that is read once a row has in it less, over kp v [s].
    """

    speed: Array
    torque: Array
    stretch: NDArray[np.intp]
    lead: Array

    @property
    def direction(self) -> Array:
        """Sign of the speed."""
        import numpy as np

        found: Array = np.sign(self.speed)
        return found


def cloud(recording: Recording, course: Course, values: Mapping[str, float]) -> Cloud:
    """Friction over speed of a joint in a log with a torque at the drive.

    Args:
        recording: The joint's part of the log.
        course: The links along it.
        values: `kp`, `kd`, `viscous`, `armature`, `inertia` with the links', `delay` and `bias`, from a rollout: see
            `values_of`. How long a transient lasts and when a torque is read follow from them.
    """
    import numpy as np

    torque, step = recording.measured["torque"], recording.step
    rows_back = _rows_back(recording, values)
    lead = rows_back * step - values["delay"] - 0.5 * step
    position = recording.position - values["bias"]
    load = course.load + course.slope * (position - course.path)
    needed = load + (course.inertia + values["armature"]) * recording.acceleration
    points: list[tuple[float, float, int]] = []
    for number, (rows, speed) in enumerate(_stretches(recording, values)):
        pulls = torque[rows] + values["kp"] * speed[rows] * lead - needed[rows]
        count = max(1, (rows.stop - rows.start) // max(LEAST_ROWS, round(BLOCK / step)))
        for part in np.array_split(np.arange(rows.stop - rows.start), count):
            good = part[np.isfinite(pulls[part])]
            if len(good) >= LEAST_ROWS:
                points.append((float(speed[rows][good].mean()), float(pulls[good].mean()), number))
    speeds, torques, stretch = np.array(points).reshape(-1, 3).T
    return Cloud(speeds, torques, stretch.astype(np.intp), np.full(len(speeds), lead))


def _rows_back(recording: Recording, values: Mapping[str, float]) -> int:
    """The command of how many rows before a torque has in it: of those that the delay allows, what fits best."""
    import numpy as np

    near = values["delay"] / recording.step
    torque = recording.measured["torque"]
    rest = (
        torque
        + values["kp"] * recording.position
        - values["kd"] * (recording.speed_command - recording.velocity)
    )
    best, least = 1, math.inf
    for back in sorted({max(round(near), 1), math.floor(near) + 1}):
        sent = recording.command[np.maximum(np.arange(len(torque)) - back, 0)]
        # The bias is a constant: it is not asked for.
        left = float(np.nanvar(rest - values["kp"] * sent))
        if left < least:
            best, least = back, left
    return best


def _stretches(recording: Recording, values: Mapping[str, float]) -> list[tuple[slice, Array]]:
    """Rows of constant speed, what began it faded, and the command's speed at every row."""
    import numpy as np

    command, step = recording.command, recording.step
    change = np.diff(command)
    speed = np.append(change, change[-1]) / step
    bend = np.abs(np.diff(change))
    tolerance = EVEN * np.abs(change[1:]) + DIGITS * float(np.abs(command).max())
    gaps = np.diff(recording.time) > longest_step(recording.time)
    even = (bend <= tolerance) & (np.abs(change[1:]) > SLOW * step) & ~gaps[1:] & ~gaps[:-1]
    # The torque of a stretch that is spoilt is not known, and its rows are left out by themselves.
    edges = np.flatnonzero(np.diff(np.concatenate([[False], even, [False]]).astype(int)))
    wait = _fading(values, recording) + values["delay"]
    found = []
    for start, end in zip(edges[::2], edges[1::2], strict=True):
        first, last = int(start) + 1 + math.ceil(wait / step), int(end) + 1
        if last - first >= LEAST_ROWS:
            found.append((slice(first, last), speed))
    return found


def _fading(values: Mapping[str, float], recording: Recording) -> float:
    """How long what a ramp began with lasts [s]."""
    inertia = max(values["inertia"], 1e-12)
    damping = (values["kd"] + values["viscous"]) / inertia
    inner = damping**2 / 4.0 - values["kp"] / inertia
    rate = 0.5 * damping - (math.sqrt(inner) if inner > 0 else 0.0)
    return FADED / max(rate, 1e-6)


@dataclass(frozen=True, slots=True)
class Curve:
    """Friction as a function of speed.

    Attributes:
        values: `coulomb` [N*m or N], `viscous` [N*m*s/rad or N*s/m], `offset` [N*m or N]: what pulls one way at any
            speed; and `rise` [N*m or N] and `stribeck_velocity` [rad/s or m/s] where slow speeds show more friction.
        std: Likewise.
        left: Standard deviation of what is left [N*m or N].
    """

    values: Mapping[str, float]
    std: Mapping[str, float]
    left: float

    def at(self, speed: Array) -> Array:
        """Torque of friction, the offset included [N*m or N], shape (n,)."""
        import numpy as np

        return _curve(np.array([self.values[name] for name in self.values]), np.asarray(speed))


def fitted(found: Cloud, *, offset: bool = True, slipping: bool = True) -> Curve:
    """Coulomb and viscous friction by a robust fit, and Stribeck's where it shows.

    Args:
        found: Points.
        offset: Whether what pulls one way is told apart; it takes both directions.
        slipping: Whether to look for Stribeck's.
    """
    import numpy as np

    names = ["coulomb", "viscous", "offset"]
    straight, covariance = _robust(found, np.zeros(3), offset=offset)
    size = float(np.abs(found.torque).max())
    best = None
    speeds = np.unique(np.abs(found.speed).round(9))
    if slipping and len(speeds) >= 4:
        for share in (0.05, 0.15, 0.4):
            begin = np.array([*straight.x[:3], 0.1 * size, share * speeds[-1]])
            tried = _robust(found, begin, offset=offset)
            if best is None or tried[0].cost < best[0].cost:
                best = tried
    if best is not None:
        rise, speed = best[0].x[3], best[0].x[4]
        std = np.sqrt(np.maximum(np.diag(best[1]), 0.0))
        shown = rise > STRIBECK * std[3] and speed > STRIBECK * std[4]
        if shown and speeds[0] < speed < 0.5 * speeds[-1]:
            names += ["rise", "stribeck_velocity"]
            straight, covariance = best
    left = found.torque - _curve(straight.x, found.speed)
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return Curve(
        dict(zip(names, map(float, straight.x), strict=True)),
        dict(zip(names, map(float, std), strict=True)),
        1.4826 * float(np.median(np.abs(left))),
    )


def _curve(x: Array, speed: Array) -> Array:
    import numpy as np

    dry = np.full(len(speed), x[0])
    if len(x) > 3:
        dry = dry + x[3] * np.exp(-((speed / x[4]) ** 2))
    found: Array = np.sign(speed) * dry + x[1] * speed + x[2]
    return found


def _robust(found: Cloud, begin: Array, *, offset: bool) -> tuple[Any, Array]:
    """Robust least squares, and the covariance by what is left in each stretch."""
    import numpy as np
    from scipy.optimize import least_squares

    fastest = float(np.abs(found.speed).max())
    size = max(float(np.abs(found.torque).max()), 1e-9)
    scale = np.array([size, size / fastest, size, size, fastest])[: len(begin)]
    low = np.array([-math.inf, -math.inf, -math.inf, 0.0, 1e-3 * fastest])[: len(begin)]
    free = np.array([True, True, offset, True, True])[: len(begin)]
    spread, solved = 0.1 * size, None

    def full(x: Array) -> Array:
        out = np.zeros(len(begin))
        out[free] = x
        return out

    x = begin[free]
    for _ in range(3):
        solved = least_squares(
            lambda x, spread: (_curve(full(x), found.speed) - found.torque) / spread,
            x,
            x_scale=scale[free],
            bounds=(low[free], np.full(free.sum(), math.inf)),
            loss="soft_l1",
            f_scale=OUTLIER,
            args=(spread,),
        )
        x = solved.x
        left = np.abs(_curve(full(x), found.speed) - found.torque)
        spread = max(1.4826 * float(np.median(left)), 1e-9 * size)
    assert solved is not None
    # Points of a stretch go together: it is one reading. `jac` and `fun` have the robust weight in them.
    groups = np.unique(found.stretch)
    residual = (_curve(full(x), found.speed) - found.torque) / spread
    weight = 1.0 / np.sqrt(1.0 + (residual / OUTLIER) ** 2)
    slopes = _slopes(full(x), found.speed)[:, free] / spread
    normal = (slopes * weight[:, None]).T @ slopes
    scores = np.stack(
        [(slopes * (weight * residual)[:, None])[found.stretch == g].sum(axis=0) for g in groups]
    )
    inverse = np.linalg.pinv(normal, hermitian=True)
    middle = scores.T @ scores * len(groups) / max(len(groups) - len(x), 1)
    covariance = np.zeros((len(begin), len(begin)))
    # Few stretches may agree by chance: never less than what independent points would give.
    sandwich = inverse @ middle @ inverse
    plain = np.diag(inverse) * max(float(np.mean(weight * residual**2)), 1e-12)
    grow = np.sqrt(np.maximum(plain / np.maximum(np.diag(sandwich), 1e-300), 1.0))
    covariance[np.ix_(free, free)] = sandwich * np.outer(grow, grow)
    solved.x = full(x)
    return solved, covariance


def _slopes(x: Array, speed: Array) -> Array:
    """Derivatives of the curve, shape (n, n_x)."""
    import numpy as np

    way = np.sign(speed)
    columns = [way, speed, np.ones_like(speed)]
    if len(x) > 3:
        near = np.exp(-((speed / x[4]) ** 2))
        columns += [way * near, way * x[3] * near * 2.0 * speed**2 / x[4] ** 3]
    found: Array = np.stack(columns, axis=1)
    return found


def joined(clouds: Sequence[Cloud]) -> Cloud:
    """The clouds of several logs as one."""
    import numpy as np

    counts = np.cumsum([0, *(int(one.stretch.max(initial=-1)) + 1 for one in clouds)])
    return Cloud(
        np.concatenate([one.speed for one in clouds]),
        np.concatenate([one.torque for one in clouds]),
        np.concatenate([one.stretch + first for one, first in zip(clouds, counts, strict=False)]),
        np.concatenate([one.lead for one in clouds]),
    )


def of_direction(found: Cloud, way: float) -> Cloud:
    """The points in which the joint moves one way."""
    mine = found.direction == way
    return Cloud(found.speed[mine], found.torque[mine], found.stretch[mine], found.lead[mine])


def judged(joint: JointInWork, out: Collector) -> JointFit | None:
    """What a joint's stretches of constant speed say of its friction; None where there are none, with the reason.

    Args:
        joint: With the rollout of its logs.
        out: Takes what the logs do not tell.
    """
    import numpy as np

    fit, name = joint.fit, joint.actuator.joint
    assert fit is not None
    place = Span(joint.recordings[0].log.path)
    clouds = [
        cloud(recording, course, values_of(joint, index))
        for index, (recording, course) in enumerate(zip(joint.recordings, joint.courses, strict=True))
    ]
    found = joined(clouds)
    speeds = np.abs(found.speed)
    if not len(speeds):
        message = "the command has no stretch of constant speed that is long enough for the joint to come to that speed"
        help = "`actspec sysid design --experiment friction`, slower or longer; or --method rollout"
        out.warning("SYS059", message, where=name, span=place, help=help)
        return None
    units = {field: unit_of_kind(kind, joint.actuator.kind) for field, kind in FIELDS.values()}
    both = len(np.unique(found.direction)) == 2
    curve = fitted(found, offset=both)
    # The phase of reading makes kp times itself of viscous friction; so does its error.
    late = max(values_of(joint, index)["kp"] for index in range(len(clouds))) * (
        fit.std("delay") if "delay" in fit.free else 0.0
    )
    scale = [recording.log.sidecar.accuracy.torque for recording in joint.recordings]
    accuracy = max(stated.value or 0.0 if stated is not None else 0.0 for stated in scale)
    why = {}
    if not both:
        why["friction.coulomb"] = (
            "the joint moves one way alone: an offset of the torque or of gravity looks the same"
        )
    if speeds.max() < APART * speeds.min():
        unit = units["friction.stribeck_velocity"]
        why |= dict.fromkeys(
            ("friction.coulomb", "friction.viscous"),
            f"the only speed is {format_number(speeds.max(), 3)} {unit}",
        )
    if not fit.arrived:
        why.setdefault(
            "friction.viscous", "the rollout that tells when a torque is read did not come to rest"
        )
        late = math.inf
    pairs = {
        "friction.coulomb": (curve.values["coulomb"], curve.std["coulomb"]),
        "friction.viscous": (curve.values["viscous"], math.hypot(curve.std["viscous"], late)),
    }
    if "rise" in curve.values:
        std = math.hypot(curve.std["coulomb"], curve.std["rise"])
        pairs["friction.static"] = (curve.values["coulomb"] + curve.values["rise"], std)
        pairs["friction.stribeck_velocity"] = (
            curve.values["stribeck_velocity"],
            curve.std["stribeck_velocity"],
        )
    # A small viscous friction may be known well although its interval has 0 in it: by its torque at full speed.
    dry = max(abs(curve.values["coulomb"]), 2.0 * curve.left)
    vague = {"friction.coulomb": VAGUE * dry, "friction.viscous": SMALL * dry / float(speeds.max())}
    parameters = tuple(
        _parameter(
            field,
            value,
            math.hypot(std, accuracy * value),
            vague.get(field, 0.0),
            units[field],
            why.get(field, ""),
        )
        for field, (value, std) in pairs.items()
    )
    for parameter in parameters:
        if parameter.why:
            message = f"the logs do not tell {parameter.field}: {parameter.why}"
            help = "`actspec sysid design --experiment friction` moves both ways at six speeds"
            out.info("SYS059", message, where=name, span=place, help=help)
    sided = [
        Indicator(
            f"{parameter.field}{sign}",
            parameter.value,
            parameter.std,
            parameter.unit,
            parameter.why,
        )
        for sign, way in (("+", 1.0), ("-", -1.0))
        if both
        for parameter in _one_way(of_direction(found, way), "rise" in curve.values, late, vague, units)
    ]
    return JointFit(name, joint.actuator.kind, parameters, (), (), None, None, None, None, tuple(sided))


def _one_way(
    found: Cloud, slipping: bool, late: float, vague: Mapping[str, float], units: Mapping[str, str]
) -> Iterator[Parameter]:
    """Friction in one direction, what pulls one way counted to it."""
    import numpy as np

    speeds = np.abs(found.speed)
    if speeds.max() < APART * speeds.min():
        return
    curve = fitted(found, offset=False, slipping=slipping)
    for name, more in (("coulomb", 0.0), ("viscous", late)):
        field = f"friction.{name}"
        std = math.hypot(curve.std[name], more)
        found_std = _parameter(field, curve.values[name], std, vague[field], units[field], "")
        # No bound here: what pulls one way may be more than friction.
        known = found_std.state is not State.UNIDENTIFIABLE
        yield replace(found_std, value=curve.values[name], std=std, why="") if known else found_std


def _parameter(field: str, value: float, std: float, vague: float, unit: str, why: str) -> Parameter:
    if why or std > max(vague, VAGUE * abs(value)):
        why = why or f"its standard deviation would be {format_number(std, 2)} {unit}"
        return Parameter(field, State.UNIDENTIFIABLE, None, None, None, None, unit, why)
    return bounded(field, value, std, value - WIDE * std, max(value, 0.0) + WIDE * std, unit)


def values_of(joint: JointInWork, index: int) -> dict[str, float]:
    """What `cloud` asks of a rollout, in one of a joint's logs."""
    assert joint.fit is not None
    values = dict(joint.fit.values)
    for name, (key, factor) in joint.gains.own(index).items():
        values[name] = factor * joint.fit.values[key]
    inertia = float(joint.courses[index].inertia.mean()) + values["armature"]
    return {**values, "inertia": inertia}
