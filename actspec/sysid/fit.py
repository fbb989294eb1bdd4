"""Figures of all joints of one or several logs, by rollouts: what is free, what is held, and what cannot be told.

What a log can tell follows from what was logged (docs/sysid.md has the table); within that the data decide: a figure
whose standard deviation is no smaller than what one would guess is not identified.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Diagnostic, Span, listed, nearest
from actspec.fields import PLACEHOLDER
from actspec.ir import ActuatorSet, Command, JointActuator
from actspec.logs import Log, LogError
from actspec.patterns import match_names
from actspec.robot.view import RobotView
from actspec.sysid.begin import begin
from actspec.sysid.checks import check
from actspec.sysid.descent import DIFFERENCE, Fit, Piecewise, Search, descend, simulated
from actspec.sysid.identified import FIELDS, FIGURE, Combination, Identification, JointFit, Parameter, State
from actspec.sysid.links import Links, links_along
from actspec.sysid.motion import Bounds, Course, Figures
from actspec.sysid.recording import Recording, record
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

DEFAULT = ("kp", "kd", "armature", "coulomb", "viscous", "delay", "bias")
"""Figures that are free unless something holds them."""
VAGUE = 0.3
"""Standard deviation over the size of a figure from which on it is not identified. Chosen: the interval then is wider
than what one would guess."""
COUPLED = 0.02
"""Share of a joint's load torque that the others' motion must make for a second pass."""
WIDE = 1.96
"""Half the 95 % interval in standard deviations."""
LATE = 5e-3
"""Standard deviation of a delay from which on it is not identified [s]. Chosen."""
ASKEW = 0.02
"""Likewise of an encoder's bias [rad or m]. Chosen: a degree."""
STIFF = 1e6
"""Greatest slope of gravity's torque over kp below which the bias does not show, as its reciprocal."""


@dataclass(frozen=True, slots=True)
class FitOptions:
    """What a user asks of a fit.

    Attributes:
        free: Fields that are free beside the usual ones.
        hold: Fields that are held at the spec's.
        validate: Logs to hold the result to, which the fit does not see.
    """

    free: frozenset[str] = frozenset()
    hold: frozenset[str] = frozenset()
    validate: tuple[Log, ...] = ()


@dataclass(frozen=True, slots=True)
class _Gains:
    """kp and kd, and who states them; None: they are free."""

    kp: float
    kd: float
    where: str


@dataclass(slots=True)
class _Joint:
    """A joint in work."""

    actuator: JointActuator
    bounds: Bounds
    recordings: list[Recording]
    courses: list[Course]
    held: _Gains | None
    torque: bool
    fit: Fit | None = None
    scale: Mapping[str, float] | None = None


def fit_logs(
    actuators: ActuatorSet, robot: RobotView, logs: Sequence[Log], options: FitOptions
) -> Identification:
    """Identify every joint that is in the logs.

    Args:
        actuators: The spec, resolved.
        robot: Its model.
        logs: At least one.
        options: What the user asks.

    Raises:
        LogError: nothing can be fitted, with every reason.
        RobotError: the model does not tell the links' inertia.
    """
    begun = clock.perf_counter()
    out = Collector()
    _check_fields(options, out)
    names = _joints(actuators, logs, out)
    out.raise_if_failed(LogError)
    joints = _prepared(actuators, robot, logs, names, options, out)
    out.raise_if_failed(LogError)
    for joint in joints.values():
        _descend(joint, options, out)
    if _coupled(joints):
        # The others' accelerations were those of a filter; the fit knows them better.
        links = _links(actuators, robot, logs, joints)
        _couple(joints, links, predicted=True)
        for joint in joints.values():
            _descend(joint, options, out)
    found = tuple(_judged(joint, options) for joint in joints.values())
    out.raise_if_failed(LogError)
    _judge(found, out)
    return Identification(actuators.robot, "rollout", found, out.sorted(), clock.perf_counter() - begun)


def _check_fields(options: FitOptions, out: Collector) -> None:
    for option, fields in (("--free", options.free), ("--hold", options.hold)):
        for field in sorted(fields - set(FIGURE)):
            help = nearest(field, tuple(FIGURE))
            help = f"did you mean '{help}'?" if help else f"fields: {listed(list(FIGURE))}"
            out.error("SYS020", f"'{field}' is no field that a fit knows", where=option, help=help)
    for field in sorted(options.free & options.hold):
        out.error("SYS020", f"{field} is both free and held", where="--free, --hold")


def _joints(actuators: ActuatorSet, logs: Sequence[Log], out: Collector) -> list[str]:
    """Joints of the logs that the spec has, in the robot's order."""
    logged = {name for log in logs for name in log.joints}
    known = [joint.joint for joint in actuators.joints]
    for log in logs:
        for name in log.joints:
            if name not in known and name != "base":
                guess = nearest(name, known)
                help = f"did you mean '{guess}'?" if guess else f"joints: {listed(known)}"
                message = "the spec has no such joint"
                out.error("SYS021", message, where=name, span=Span(log.path, 1), help=help)
        robot = log.sidecar.robot
        if robot is not None and robot != actuators.robot:
            message = f"the log is of the robot '{robot}', the spec of '{actuators.robot}'"
            out.error("SYS021", message, span=Span(log.path))
    return [name for name in known if name in logged]


def _prepared(
    actuators: ActuatorSet,
    robot: RobotView,
    logs: Sequence[Log],
    names: Sequence[str],
    options: FitOptions,
    out: Collector,
) -> dict[str, _Joint]:
    """Recordings of every joint, with the links along them."""
    joints: dict[str, _Joint] = {}
    recorded = {
        name: [
            found
            for log in logs
            if name in log.joints and (found := record(log, log.joints[name], out)) is not None
        ]
        for name in names
    }
    known = {joint.joint: _bounds(joint) for joint in actuators.joints}
    checked = check(recorded, known, out)
    for name in names:
        actuator = actuators.joint(name)
        assert actuator is not None
        recordings = checked[name]
        if actuator.command is not Command.POSITION:
            message = f"its command is {actuator.command.value}, a rollout follows position commands"
            out.error("SYS022", message, where=name)
            continue
        if not recordings:
            continue
        torque = all("torque" in recording.measured for recording in recordings)
        if not torque and any("torque" in recording.measured for recording in recordings):
            message = "some logs have a torque and others do not: it is left out"
            out.info("SYS013", message, where=name)
        held = _held_gains(actuator, recordings, torque, options, out)
        joints[name] = _Joint(actuator, known[name], recordings, [], held, torque)
    if not out.failed:
        _couple(joints, _links(actuators, robot, logs, joints), predicted=False)
    return joints


def _bounds(actuator: JointActuator) -> Bounds:
    def known(value: float | None) -> float:
        return math.inf if value is None or value >= PLACEHOLDER else value

    limit = known(actuator.effort_limit.value)
    stall, speed = actuator.stall_torque, actuator.no_load_speed
    if stall is None or speed is None or stall.value is None or speed.value is None:
        return Bounds(limit)
    return Bounds(limit, stall.value, speed.value)


def _held_gains(
    actuator: JointActuator,
    recordings: Sequence[Recording],
    torque: bool,
    options: FitOptions,
    out: Collector,
) -> _Gains | None:
    """Gains that are not fitted, and who states them."""
    name = actuator.joint
    wanted = {"kp", "kd"} & options.free
    if (torque and not {"kp", "kd"} & options.hold) or len(wanted) == 2:
        return None
    stated = []
    for recording in recordings:
        sidecar = recording.log.sidecar
        for pattern, gains in sidecar.gains.items():
            if pattern == name or match_names(pattern, [name]):
                assert gains.kp.value is not None and gains.kd.value is not None
                stated.append((gains.kp.value, gains.kd.value, recording.log.path))
                break
    if stated and len({(kp, kd) for kp, kd, _ in stated}) == 1:
        sent = stated[0]
        return _Gains(sent[0], sent[1], f"as sent to the drive, by the sidecar of {sent[2]}")
    if stated:
        shown = [f"kp {kp:g}, kd {kd:g} in {path}" for kp, kd, path in stated]
        message = f"the logs were made with different gains: {listed(shown)}"
        out.error("SYS023", message, where=name, help="fit logs of one pair of gains at a time")
        return None
    kp, kd = actuator.kp, actuator.kd
    if kp is None or kd is None or kp.value is None or kd.value is None:
        message = "no torque was logged, and neither the sidecar nor the spec states kp and kd"
        help = f"write `gains: {{{name}: {{kp: ..., kd: ...}}}}` beside the log, or give --free kp,kd"
        out.error("SYS023", message, where=name, help=help)
        return None
    out.info(
        "SYS024",
        f"kp and kd are held at the spec's {format_number(kp.value)} {kp.unit} and "
        f"{format_number(kd.value)} {kd.unit}: the log has no torque, and its sidecar states no gains",
        where=name,
    )
    return _Gains(kp.value, kd.value, "held at the spec's")


def _links(
    actuators: ActuatorSet, robot: RobotView, logs: Sequence[Log], joints: Mapping[str, _Joint]
) -> list[tuple[list[str], Links]]:
    """The links along every log, for the joints in it."""
    import numpy as np

    found = []
    for log in logs:
        names, columns = [], []
        for name, joint in joints.items():
            mine = [recording for recording in joint.recordings if recording.log is log]
            if mine:
                names.append(name)
                columns.append(mine[0])
        bias = [_bias(joints[name]) for name in names]
        q = np.stack([c.position - b for c, b in zip(columns, bias, strict=True)], axis=1)
        qd = np.stack([c.velocity for c in columns], axis=1)
        base = log.sidecar.base
        found.append((names, links_along(robot, names, q, qd, None if base is None else base.orientation)))
    del actuators
    return found


def _bias(joint: _Joint) -> float:
    if joint.fit is not None:
        return joint.fit.values["bias"]
    return joint.actuator.encoder_bias.value or 0.0


def _couple(
    joints: Mapping[str, _Joint], along: Sequence[tuple[list[str], Links]], *, predicted: bool
) -> None:
    """Give every joint its course: its own inertia, and a load in which the others' accelerations are."""
    for joint in joints.values():
        joint.courses = []
    accelerations = {
        name: [
            _predicted(joint, i) if predicted else recording.acceleration
            for i, recording in enumerate(joint.recordings)
        ]
        for name, joint in joints.items()
    }
    used = dict.fromkeys(joints, 0)
    for names, links in along:
        here = {name: accelerations[name][used[name]] for name in names}
        for j, name in enumerate(names):
            joint = joints[name]
            recording = joint.recordings[used[name]]
            others = sum(
                (links.inertia[:, j, k] * here[other] for k, other in enumerate(names) if k != j),
                0.0 * recording.time,
            )
            joint.courses.append(
                Course(
                    recording.time,
                    recording.command,
                    recording.speed_command,
                    links.inertia[:, j, j].copy(),
                    links.load[:, j] + others,
                    links.slope[:, j].copy(),
                    recording.position - _bias(joint),
                )
            )
        for name in names:
            used[name] += 1


def _coupled(joints: Mapping[str, _Joint]) -> bool:
    """Whether what joints do to each other is worth a second pass."""
    import numpy as np

    if len(joints) < 2:
        return False
    return any(
        recording.log is other.log and not np.array_equal(recording.position, other.position)
        for joint in joints.values()
        for one in joints.values()
        if one is not joint
        for recording in joint.recordings
        for other in one.recordings
    )


def _predicted(joint: _Joint, index: int) -> Array:
    """Acceleration along a log as the fit has it; outside of its pieces as the filter."""
    import numpy as np

    recording, fit = joint.recordings[index], joint.fit
    assert fit is not None
    piecewise = _piecewise(joint)[index]
    moved = simulated(piecewise, fit.values, joint.bounds, fit.states[index])
    found = recording.acceleration.copy()
    for piece, start in enumerate(piecewise.starts):
        rows = slice(start, start + piecewise.rows)
        found[rows] = np.gradient(moved.qd[:, piece, 0], recording.time[rows])
    return found


def _piecewise(joint: _Joint) -> list[Piecewise]:
    found = []
    for recording, course in zip(joint.recordings, joint.courses, strict=True):
        measured = {
            name: signal for name, signal in recording.measured.items() if name != "torque" or joint.torque
        }
        behind = recording.log.sidecar.torque == "joint"
        found.append(Piecewise(course, measured, recording.starts, recording.rows, behind))
    return found


def _free(joint: _Joint, options: FitOptions) -> tuple[str, ...]:
    """Figures that are free."""
    import numpy as np

    free = [name for name in DEFAULT if FIELDS[name][0] not in options.hold]
    if joint.held is not None:
        free = [name for name in free if name not in ("kp", "kd") or name in options.free]
    free += [FIGURE[field] for field in sorted(options.free) if FIGURE[field] not in free]
    slope = max(float(np.abs(course.slope).max()) for course in joint.courses)
    if "bias" in free and slope * STIFF < 1.0:
        free.remove("bias")
    if not joint.torque and joint.held is None and "kd" in free and "viscous" in free:
        # Only their sum shows: it is found as viscous friction beside the kd that is held.
        free.remove("kd")
        if not _scaled(joint):
            free.remove("armature")
            free.remove("bias") if "bias" in free else None
    return tuple(free)


def _scaled(joint: _Joint) -> bool:
    """Whether gravity or other joints give a torque that is known without the drive."""
    import numpy as np

    inertial = np.concatenate(
        [c.inertia * r.acceleration for c, r in zip(joint.courses, joint.recordings, strict=True)]
    )
    load = np.concatenate([course.load for course in joint.courses])
    return float(np.std(load)) > COUPLED * float(np.std(inertial))


def _descend(joint: _Joint, options: FitOptions, out: Collector) -> None:
    """Fit a joint, from its last fit or from a regression on."""
    pieces = _piecewise(joint)
    free = _free(joint, options)
    spec = _spec_values(joint)
    if joint.fit is not None:
        values = dict(joint.fit.values)
        assert joint.scale is not None
        scale = joint.scale
    else:
        gains = (joint.held.kp, joint.held.kd) if joint.held is not None else None
        if gains is None and not joint.torque:
            gains = (spec["kp"] or 1.0, spec["kd"] or 0.1)
        first = begin(joint.recordings, joint.courses, joint.bounds, gains)
        if gains is None and first.against:
            out.error(
                "SYS014",
                "the torque pulls away from the command",
                where=joint.actuator.joint,
                span=Span(joint.recordings[0].log.path),
                help="turn the sign of the torque's column",
            )
            raise LogError(out.sorted())
        values = {**spec, **{k: v for k, v in first.values.items() if k in free or k in ("kp", "kd")}}
        values["bias"] = spec["bias"]
        if joint.held is not None:
            values |= {"kp": joint.held.kp, "kd": joint.held.kd}
        scale = joint.scale = _scales(joint, values)
    low = {name: (-math.inf if name == "bias" else 0.0) for name in Figures.names()}
    joint.fit = _searched(joint, pieces, free, scale, low, values)
    if not joint.fit.arrived:
        out.warning(
            "SYS030", "the fit did not come to rest: its figures are uncertain", where=joint.actuator.joint
        )


def _searched(
    joint: _Joint,
    pieces: Sequence[Piecewise],
    free: tuple[str, ...],
    scale: Mapping[str, float],
    low: Mapping[str, float],
    values: Mapping[str, float],
) -> Fit:
    """The best fit; where a torque tells which command acts, over the rows that it may tell."""
    step = joint.recordings[0].step
    search = Search(pieces, joint.bounds, free, scale, low, values["delay"] if joint.torque else None)
    best = descend(search, values, joint.fit)
    if not joint.torque or "delay" not in free:
        return best
    tried = {math.floor(values["delay"] / step)}
    for _ in range(4):
        row = math.floor(best.values["delay"] / step)
        near = best.values["delay"] / step - row
        options = [row]
        if near < 0.25 and row > 0:
            options.append(row - 1)
        if near > 0.75:
            options.append(row + 1)
        fresh = [option for option in options if option not in tried]
        if not fresh:
            break
        for option in fresh:
            tried.add(option)
            other = descend(replace(search, reading=(option + 0.5) * step), best.values, best)
            if other.cost < best.cost:
                best = other
    return best


def _spec_values(joint: _Joint) -> dict[str, float]:
    actuator = joint.actuator

    def of(quantity: object) -> float:
        value = getattr(quantity, "value", None)
        return float(value) if value is not None else 0.0

    cutoff = of(actuator.filter_cutoff)
    return {
        "kp": of(actuator.kp),
        "kd": of(actuator.kd),
        "armature": of(actuator.armature),
        "coulomb": of(actuator.friction_coulomb),
        "viscous": of(actuator.friction_viscous),
        "static": of(actuator.friction_static),
        "stribeck_velocity": of(actuator.stribeck_velocity),
        "delay": of(actuator.delay.nominal) if actuator.delay is not None else 0.0,
        "bias": of(actuator.encoder_bias),
        "lag": 1.0 / (2.0 * math.pi * cutoff) if cutoff > 0 else 0.0,
    }


def _scales(joint: _Joint, values: Mapping[str, float]) -> dict[str, float]:
    """Sizes of the figures, for differences and to judge what is vague."""
    import numpy as np

    inertia = float(np.mean([course.inertia.mean() for course in joint.courses])) + values["armature"]
    torque = max(
        float(np.std(values["kp"] * (c.command - r.position)))
        for c, r in zip(joint.courses, joint.recordings, strict=True)
    )
    speed = max(float(np.abs(recording.velocity).max()) for recording in joint.recordings)
    damping = max(values["kd"] + values["viscous"], 0.02 * math.sqrt(values["kp"] * inertia))
    return {
        "kp": max(values["kp"], 1e-3),
        "kd": damping,
        "armature": inertia,
        "coulomb": max(0.1 * torque, 1e-4),
        "viscous": damping,
        "static": max(0.1 * torque, 1e-4),
        "stribeck_velocity": 0.1 * speed,
        "delay": joint.recordings[0].step,
        "bias": 0.01,
        "lag": joint.recordings[0].step,
    }


def _judged(joint: _Joint, options: FitOptions) -> JointFit:
    """What a fit says of a joint."""
    import numpy as np

    fit, scale, actuator = joint.fit, joint.scale, joint.actuator
    assert fit is not None and scale is not None
    linear = next((r.log.joints[r.joint].linear for r in joint.recordings), False)
    unscaled = not joint.torque and joint.held is None and "armature" not in fit.free
    parameters, combinations = [], []
    for name, (field, kind) in FIELDS.items():
        unit = kind.linear_unit if linear else kind.rotary_unit
        parameter = _parameter(joint, fit, scale, name, field, unit, options, unscaled=unscaled)
        if parameter is not None:
            parameters.append(parameter)
    summed = not joint.torque and joint.held is None and "viscous" in fit.free and "kd" not in fit.free
    if summed:
        combinations = _combinations(joint, fit, unscaled=unscaled)
    correlation = _correlation(fit)
    position = fit.noise["position"]
    return JointFit(
        actuator.joint,
        actuator.kind,
        tuple(parameters),
        tuple(combinations),
        correlation,
        position,
        _held_out(joint, options),
        position / _reading_noise(joint),
        float(np.linalg.cond(_scaled_normal(fit))) if fit.free else 1.0,
    )


def _scaled_normal(fit: Fit) -> Array:
    import numpy as np

    root = np.sqrt(np.maximum(np.diag(fit.normal), 1e-300))
    found: Array = fit.normal / np.outer(root, root)
    return found


def _parameter(
    joint: _Joint,
    fit: Fit,
    scale: Mapping[str, float],
    name: str,
    field: str,
    unit: str,
    options: FitOptions,
    *,
    unscaled: bool,
) -> Parameter | None:
    def untold(state: State, why: str) -> Parameter:
        return Parameter(field, state, None, None, None, None, unit, why)

    value = fit.values[name]
    if name not in fit.free:
        if name in ("static", "stribeck_velocity", "lag"):
            return None
        if name in ("kp", "kd") and joint.held is not None:
            return Parameter(field, State.HELD, value, None, None, None, unit, joint.held.where)
        if field in options.hold:
            return Parameter(field, State.HELD, value, None, None, None, unit, "held at the spec's, --hold")
        if name == "kd":
            return untold(State.UNIDENTIFIABLE, "without torque only kd + friction.viscous shows")
        if name == "armature":
            return untold(
                State.UNIDENTIFIABLE,
                "without torque, gravity and other joints only ratios to the inertia show",
            )
        return untold(State.UNIDENTIFIABLE, "without gravity on the joint it shows in nothing")
    if unscaled and name in ("kp", "coulomb", "viscous"):
        return untold(
            State.UNIDENTIFIABLE, "without torque, gravity and other joints only ratios to the inertia show"
        )
    if name == "viscous" and not joint.torque and joint.held is None:
        return untold(State.UNIDENTIFIABLE, "without torque only kd + friction.viscous shows")
    std = fit.std(name)
    vague = {"delay": LATE, "bias": ASKEW}.get(name, VAGUE * scale[name])
    if name == "kp":
        vague = VAGUE * abs(value)
    if not math.isfinite(std) or std > vague or std == 0.0:
        partner = _partner(fit, name)
        why = f"its standard deviation would be {format_number(std, 2)} {unit}"
        if partner is not None:
            why += f", because {FIELDS[partner][0]} does nearly the same in this log"
        return untold(State.UNIDENTIFIABLE, why)
    if value <= 0.0 and name != "bias":
        return untold(
            State.AT_BOUND,
            f"the best value is below 0; one of {format_number(WIDE * std, 2)} {unit} fits too",
        )
    if name == "lag":
        cutoff = 1.0 / (2.0 * math.pi * value)
        std = cutoff * std / value
        return Parameter(field, State.IDENTIFIED, cutoff, std, cutoff - WIDE * std, cutoff + WIDE * std, unit)
    low = value - WIDE * std
    return Parameter(
        field,
        State.IDENTIFIED,
        value,
        std,
        low if name == "bias" else max(low, 0.0),
        value + WIDE * std,
        unit,
    )


def _partner(fit: Fit, name: str) -> str | None:
    """The figure with which another is most confounded."""
    import numpy as np

    i = fit.free.index(name)
    root = np.sqrt(np.maximum(np.diag(fit.covariance), 1e-300))
    row = np.abs(fit.covariance[i] / (root * root[i]))
    row[i] = 0.0
    best = int(np.argmax(row))
    return fit.free[best] if len(row) > 1 and row[best] > 0.9 else None


def _correlation(fit: Fit) -> tuple[tuple[str, str, float], ...]:
    import numpy as np

    root = np.sqrt(np.maximum(np.diag(fit.covariance), 1e-300))
    matrix = fit.covariance / np.outer(root, root)
    return tuple(
        (FIELDS[a][0], FIELDS[b][0], float(np.clip(matrix[i, j], -1.0, 1.0)))
        for i, a in enumerate(fit.free)
        for j, b in enumerate(fit.free)
        if i < j and abs(matrix[i, j]) > 0.5
    )


def _combinations(joint: _Joint, fit: Fit, *, unscaled: bool) -> list[Combination]:
    """Sums and ratios that show where single figures do not."""
    import numpy as np

    linear = next((r.log.joints[r.joint].linear for r in joint.recordings), False)
    damping = fit.values["viscous"] + fit.values["kd"]
    if not unscaled:
        unit = "N*s/m" if linear else "N*m*s/rad"
        return [Combination("kd+friction.viscous", damping, fit.std("viscous"), unit)]
    inertia = float(np.mean([course.inertia.mean() for course in joint.courses])) + fit.values["armature"]
    acceleration = "m/s^2" if linear else "rad/s^2"
    found = []
    if "kp" in fit.free:
        found.append(Combination("kp/inertia", fit.values["kp"] / inertia, fit.std("kp") / inertia, "1/s^2"))
    found.append(
        Combination("(kd+friction.viscous)/inertia", damping / inertia, fit.std("viscous") / inertia, "1/s")
    )
    if "coulomb" in fit.free:
        found.append(
            Combination(
                "friction.coulomb/inertia",
                fit.values["coulomb"] / inertia,
                fit.std("coulomb") / inertia,
                acceleration,
            )
        )
    return found


def _reading_noise(joint: _Joint) -> float:
    """Noise of the position's readings, from what a local cubic leaves of them [rad or m]."""
    import numpy as np

    left = []
    for recording in joint.recordings:
        q = recording.measured["position"]
        third = q[3:] - 3 * q[2:-1] + 3 * q[1:-2] - q[:-3]
        left.append(third[np.isfinite(third)])
    # 1, 3, 3, 1 of white noise: the sum of the squares is 20.
    return max(1.4826 * float(np.median(np.abs(np.concatenate(left)))) / math.sqrt(20.0), 1e-9)


def _held_out(joint: _Joint, options: FitOptions) -> float | None:
    """Position error on every fifth piece, with figures from the others [rad or m]."""
    import numpy as np

    fit, scale = joint.fit, joint.scale
    assert fit is not None and scale is not None
    pieces = _piecewise(joint)
    if sum(len(p.starts) for p in pieces) < 5 or options.validate:
        return None
    seen, unseen, states, others = [], [], [], []
    for part, (q, qd) in zip(pieces, fit.states, strict=True):
        out = np.arange(len(part.starts)) % 5 == 2
        seen.append(replace(part, starts=part.starts[~out]))
        unseen.append(replace(part, starts=part.starts[out]))
        states.append((q[~out], qd[~out]))
        others.append((q[out], qd[out]))
    low = {name: (-math.inf if name == "bias" else 0.0) for name in Figures.names()}
    reading = fit.values["delay"] if joint.torque else None
    seen = [part for part in seen if len(part.starts)]
    search = Search(seen, joint.bounds, fit.free, scale, low, reading)
    refit = descend(search, fit.values, replace(fit, states=tuple(s for s in states if len(s[0]))))
    kept = [(part, state) for part, state in zip(unseen, others, strict=True) if len(part.starts)]
    if not kept:
        return None
    blind = Search([part for part, _ in kept], joint.bounds, (), scale, low, reading)
    tested = descend(blind, refit.values, replace(refit, states=tuple(state for _, state in kept)))
    return tested.noise["position"]


def _judge(joints: Sequence[JointFit], out: Collector) -> None:
    """What is to be said of the whole fit."""
    for joint in joints:
        if joint.misfit > 3.0:
            out.warning(
                "SYS031",
                f"the position is off by {joint.misfit:.2g} times the noise of its readings: something that the model "
                "does not have moves the joint, such as play, Stribeck friction or a wrong link inertia",
                where=joint.joint,
                help="try --free friction.static,friction.stribeck_velocity or --free bandwidth",
            )
        untold = [p.field for p in joint.parameters if p.state in (State.UNIDENTIFIABLE, State.AT_BOUND)]
        if untold:
            out.info("SYS032", f"the logs do not tell {listed(untold)}", where=joint.joint)


__all__ = ["DIFFERENCE", "Diagnostic", "FitOptions", "fit_logs"]
