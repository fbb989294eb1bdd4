"""Figures of all joints of one or several logs, by rollouts: what is free, what is held, and what cannot be told.

What a log can tell follows from what was logged (docs/sysid.md has the table); within that the data decide: a figure
whose standard deviation is no smaller than what one would guess is not identified.
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, listed, nearest
from actspec.ir import ActuatorSet, Command
from actspec.logs import Log, LogError
from actspec.robot.view import RobotView
from actspec.sysid.begin import begin
from actspec.sysid.checks import check
from actspec.sysid.coupling import Path, course_of, dense, fitted, links_of, read
from actspec.sysid.course import Course, told
from actspec.sysid.descent import ROUNDS, WIDE, Fit, Piecewise, Search, descend, simulated
from actspec.sysid.doubts import doubted, judge_torques
from actspec.sysid.figures import Bounds, figures_of
from actspec.sysid.gains import GAINS, extended, gains_of, joined
from actspec.sysid.identified import FIELDS, FIGURE, Identification
from actspec.sysid.judge import judge_fit, judged
from actspec.sysid.more import LAGS, enlarged
from actspec.sysid.recording import Recording, driven, record, unevenness
from actspec.sysid.released import release
from actspec.sysid.sparse import judge_rows
from actspec.sysid.stand import Stand, by_log, idle
from actspec.sysid.torques import prompt
from actspec.sysid.unseen import held_out, judge_validation, tested, told_apart
from actspec.sysid.work import FitOptions, JointInWork, piecewise

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

DEFAULT = ("kp", "kd", "armature", "coulomb", "viscous", "delay", "bias")
"""Figures that are free unless something holds them."""
STRIBECK = {"static", "stribeck_velocity"}
COUPLED = 0.02
"""Share of a joint's load torque that the others' motion must make for a second pass."""
ASKEW = 2e-3
"""Error of a position from which on the links along it are taken again [rad or m]. Gravity's slope is right to the
first order alone: 20 mrad made kp 0.02 % wrong."""
PASSES = 8
"""Most times that the links along the path are taken again. Measured: a leg takes three to five."""
SETTLED = 0.2
"""Change of a bias from one time to the next that is nothing any more, in its standard deviations."""
NUDGE = 0.1
"""Change of the load that is nothing any more, as the position that it makes over the bias's standard deviation."""
SMEARED = 0.05
"""Unevenness of a clock from which on a delay shows in which commands the rows' torques tell, so that no whole row need
be searched. Chosen: a first fit has the delay to less."""
ROUGHLY = 5
"""Most steps of that first fit, which knows some of these commands wrongly: measured, it else takes up to 16."""
NEARLY = 0.1
"""Error that its delay may have, in rows. Measured: 0.02."""
FOLLOWED = 5
"""Most times that these commands are told anew. Measured: a jitter of 15 % takes two to four."""
SAME = 1e-3
"""Share of rows with another command that is nothing any more. Measured: 20 % made kp 0.3 % wrong."""
STIFF = 1e6
"""Greatest slope of gravity's torque over kp below which the bias does not show, as its reciprocal."""


def fit_logs(
    actuators: ActuatorSet,
    robot: RobotView,
    logs: Sequence[Log],
    options: FitOptions,
    validation: Sequence[Log] = (),
) -> Identification:
    """Identify every joint that is in the logs.

    Args:
        actuators: The spec, resolved.
        robot: Its model.
        logs: At least one.
        options: What the user asks.
        validation: Logs that the fit does not see: the position error on them is the held-out one.

    Raises:
        LogError: nothing can be fitted, with every reason.
        RobotError: the model does not tell the links' inertia.
    """
    begun = clock.perf_counter()
    out = Collector()
    stand = Stand(robot, actuators)
    _check_fields(options, out)
    names = joints_of(actuators, logs, out, options.joints)
    _check_validation(logs, validation, names, out)
    tests = joints_of(actuators, validation, out)
    stand.check([*logs, *validation], out)
    out.raise_if_failed(LogError)
    joints = prepared(stand, logs, names, options, out)
    unseen = recorded(actuators, validation, [name for name in tests if name in joints], out)
    judge_torques([joint for joint in joints.values() if joint.torque and joint.courses], out)
    out.raise_if_failed(LogError)
    roll(stand, logs, joints, options, out)
    systems = {}
    for name, joint in joints.items():
        joints[name], systems[name] = enlarged(joint, options, _descend, out)
        judge_rows(joints[name], options, _descend, out)
    errors: Mapping[str, float | None]
    if validation:
        errors = _validated(stand, validation, joints, unseen, out)
    else:
        errors = {name: held_out(joint, systems[name]) for name, joint in joints.items()}
    found = tuple(
        doubted(joint, judged(joint, options, systems[name], errors.get(name)), systems[name], out)
        for name, joint in joints.items()
    )
    if validation:
        made = {name: tuple(one.log.path for one in recordings) for name, recordings in unseen.items()}
        judge_validation({joint.joint: joint for joint in found}, made, out)
    out.raise_if_failed(LogError)
    judge_fit(found, out)
    return Identification(actuators.robot, "rollout", found, out.sorted(), clock.perf_counter() - begun)


def roll(
    stand: Stand,
    logs: Sequence[Log],
    joints: Mapping[str, JointInWork],
    options: FitOptions,
    out: Collector,
) -> None:
    """Fit joints that are prepared; again with their free swings, and where the links along their path are others."""
    read = _biases(joints)
    for joint in joints.values():
        _descend(joint, options, out)
        if release(joint, out):
            _descend(joint, options, out)
    # How the others moved was by a filter of their readings: the fit knows it better.
    coupled = again = _coupled(joints)
    for _ in range(PASSES):
        if not again and not any(abs(now - read[name]) > ASKEW for name, now in _biases(joints).items()):
            break
        read = _biases(joints)
        before = {name: joint.courses for name, joint in joints.items()}
        _couple(stand, logs, joints, fits=coupled)
        for name, joint in joints.items():
            if _pushed(joint, before[name]):
                _descend(joint, options, out)
        # What is found of a joint's bias moves gravity at the others.
        again = coupled and any(_moved(joint, read[name]) for name, joint in joints.items())


def _biases(joints: Mapping[str, JointInWork]) -> dict[str, float]:
    return {name: _bias(joint) for name, joint in joints.items()}


def _moved(joint: JointInWork, before: float) -> bool:
    """Whether a bias is another than before by more than its interval allows for."""
    fit = joint.fit
    assert fit is not None
    return "bias" in fit.free and abs(fit.values["bias"] - before) > SETTLED * fit.std("bias")


def _pushed(joint: JointInWork, before: Sequence[Course]) -> bool:
    """Whether the links pull at a joint otherwise than before, by more than its bias could tell."""
    import numpy as np

    fit = joint.fit
    assert fit is not None
    if "bias" not in fit.free:
        return True
    off = [
        now.load - (old.load + old.slope * (now.path - old.path))
        for now, old in zip(joint.courses, before, strict=True)
    ]
    pulls = math.sqrt(float(np.mean(np.concatenate(off) ** 2)))
    return pulls > NUDGE * fit.std("bias") * fit.values["kp"]


def _check_fields(options: FitOptions, out: Collector) -> None:
    for option, fields in (("--free", options.free), ("--hold", options.hold)):
        for field in sorted(fields - set(FIGURE)):
            help = nearest(field, tuple(FIGURE))
            help = f"did you mean '{help}'?" if help else f"fields: {listed(list(FIGURE))}"
            out.error("SYS020", f"'{field}' is no field that a fit knows", where=option, help=help)
    for field in sorted(options.free & options.hold):
        out.error("SYS020", f"{field} is both free and held", where="--free, --hold")


def joints_of(
    actuators: ActuatorSet, logs: Sequence[Log], out: Collector, wanted: frozenset[str] = frozenset()
) -> list[str]:
    """Joints of the logs that the spec has in the robot's order: those that are wanted, or all."""
    logged = {name for log in logs for name in log.joints}
    known = [joint.joint for joint in actuators.joints]
    for log in logs:
        for name, columns in log.joints.items():
            actuator = actuators.joint(name)
            unlike = None if actuator is None else columns.unlike(actuator.kind)
            if unlike is not None:
                out.error(
                    "SYS021", unlike, where=name, span=Span(log.path, 1), help="correct the columns' units"
                )
            if actuator is None and name != "base":
                guess = nearest(name, known)
                help = f"did you mean '{guess}'?" if guess else f"joints: {listed(known)}"
                message = "the spec has no such joint"
                out.error("SYS021", message, where=name, span=Span(log.path, 1), help=help)
        robot = log.sidecar.robot
        if robot is not None and robot != actuators.robot:
            message = f"the log is of the robot '{robot}', the spec of '{actuators.robot}'"
            out.error("SYS021", message, span=Span(log.path))
    found = [name for name in known if name in logged and name in (wanted or known)]
    if logs and logged and not found and not out.failed:
        help = f"joints of the logs: {listed(sorted(logged))}"
        out.error("SYS021", "no log has such a joint", where="--joint", span=Span(logs[0].path), help=help)
    return found


def prepared(
    stand: Stand,
    logs: Sequence[Log],
    names: Sequence[str],
    options: FitOptions,
    out: Collector,
) -> dict[str, JointInWork]:
    """Recordings of every joint, with the links along them."""
    actuators = stand.actuators
    joints: dict[str, JointInWork] = {}
    known = {joint.joint: Bounds.of(joint) for joint in actuators.joints}
    checked = recorded(actuators, logs, names, out)
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
        torque = any("torque" in recording.measured for recording in recordings)
        made = [recording.log for recording in recordings]
        gains = gains_of(actuator, made, torque=torque, free=options.free, hold=options.hold, out=out)
        joints[name] = JointInWork(actuator, known[name], recordings, [], gains, torque)
    if not out.failed:
        moved = {name: [(r.log, r.position) for r in joint.recordings] for name, joint in joints.items()}
        for log, here in by_log(moved):
            stand.tell_left_out(log, here, out)
        stand.tell(moved, out)
        _couple(stand, logs, joints, fits=False)
        for joint in joints.values():
            pairs = zip(joint.recordings, joint.courses, strict=True)
            joint.recordings = [prompt(recording, course, out) for recording, course in pairs]
    return joints


def recorded(
    actuators: ActuatorSet, logs: Sequence[Log], names: Sequence[str], out: Collector
) -> dict[str, list[Recording]]:
    """The joints' parts of every log, without what is spoilt and what no command moves.

    Of a log in which nothing is moved all joints are asked, which say so.
    """
    drives = {actuator.joint: actuator for actuator in actuators.joints}
    moved = [[name for name in names if name in log.joints and not idle(log.joints[name])] for log in logs]
    parts = {
        name: [
            found
            for log, here in zip(logs, moved, strict=True)
            if name in (here or log.joints)
            and (found := record(log, driven(log, log.joints[name], drives[name], out), out)) is not None
        ]
        for name in names
    }
    limits = {name: drives[name].position_range for name in names}
    return check(parts, {name: Bounds.of(drives[name]) for name in names}, limits, out)


def _check_validation(
    logs: Sequence[Log], validation: Sequence[Log], names: Sequence[str], out: Collector
) -> None:
    seen = {log.sha256: log.path for log in logs}
    fitted = set(names)
    for log in validation:
        if log.sha256 in seen:
            message = f"the same as {seen[log.sha256]}, which is fitted: a log cannot be both"
            out.error("SYS027", message, where="--validate", span=Span(log.path))
    if validation and not any(fitted & set(log.joints) for log in validation):
        help = f"joints of the fit: {listed(sorted(fitted))}"
        out.error("SYS028", "no log has a joint that is fitted", where="--validate", help=help)


def _validated(
    stand: Stand,
    logs: Sequence[Log],
    joints: Mapping[str, JointInWork],
    recorded: Mapping[str, list[Recording]],
    out: Collector,
) -> dict[str, float]:
    """Joint to its position error on logs that the fit has not seen [rad or m]."""
    blind: dict[str, JointInWork] = {}
    possible: dict[str, list[list[int]]] = {}
    for name, recordings in recorded.items():
        joint = joints[name]
        if not recordings:
            continue
        assert joint.fit is not None
        gains, possible[name] = joined(joint.gains, joint.actuator, [one.log for one in recordings], out)
        fit = replace(joint.fit, values=extended(gains, joint.fit.values))
        blind[name] = replace(joint, recordings=list(recordings), courses=[], gains=gains, fit=fit, swings=())
    out.raise_if_failed(LogError)
    if not blind:
        return {}
    for again in (False, True) if _coupled(blind) else (False,):
        _couple(stand, logs, blind, fits=again)
        for name, joint in blind.items():
            if not again:
                joint.gains = told_apart(joint, possible[name], out)
            joint.fit = tested(joint)
    return {name: joint.fit.noise["position"] for name, joint in blind.items() if joint.fit is not None}


def _bias(joint: JointInWork) -> float:
    if joint.fit is not None:
        return joint.fit.values["bias"]
    return joint.actuator.encoder_bias.value or 0.0


def _couple(stand: Stand, logs: Sequence[Log], joints: Mapping[str, JointInWork], *, fits: bool) -> None:
    """Give every joint its courses: the links along each log, and in the load what the others' motion does.

    Args:
        stand: The model, and where its other joints are.
        logs: That the joints' recordings are of.
        joints: Of which the courses are made.
        fits: Whether the joints move as their fits say; else as the readings do.
    """
    made: dict[str, list[Course]] = {name: [] for name in joints}
    for log in logs:
        here = {
            name: (i, recording)
            for name, joint in joints.items()
            for i, recording in enumerate(joint.recordings)
            if recording.log is log
        }
        if not here:
            continue
        paths = [
            _path(joints[name], i) if fits else read(r, _bias(joints[name])) for name, (i, r) in here.items()
        ]
        recordings = [recording for _, recording in here.values()]
        links, paths = links_of(stand, recordings, paths, list(here))
        for j, (name, recording) in enumerate(zip(here, recordings, strict=True)):
            made[name].append(course_of(recording, links, paths, j))
    for name, joint in joints.items():
        joint.courses = made[name]


def _path(joint: JointInWork, index: int) -> Path:
    """How a joint moved along a log, as its fit has it."""
    fit, recording = joint.fit, joint.recordings[index]
    assert fit is not None
    runs = []
    for pieces, states, source in zip(piecewise(joint), fit.states, joint.sources, strict=True):
        if source is recording:
            finely = dense(pieces, recording)
            runs.append((finely, simulated(finely, fit.values, joint.bounds, states)))
    return fitted(recording, fit.values["bias"], runs)


def _coupled(joints: Mapping[str, JointInWork]) -> bool:
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


def _free(joint: JointInWork, options: FitOptions) -> tuple[str, ...]:
    """Values that are free."""
    import numpy as np

    asked = {FIGURE[field] for field in options.free} | joint.added
    spec = figures_of(joint.actuator)
    if asked & STRIBECK:
        # One of the two without the other does nothing.
        asked |= {name for name in STRIBECK if spec[name] == 0.0}
    wanted = [*DEFAULT, *sorted(asked - set(DEFAULT))]
    free = [name for name in wanted if FIELDS[name][0] not in options.hold and name not in joint.gains.held]
    slope = max(float(np.abs(course.slope).max()) for course in joint.courses)
    if "bias" in free and slope * STIFF < 1.0:
        free.remove("bias")
    if not joint.parted and {"kd", "viscous"} <= set(free):
        # Only their sum shows: it is found as the drive's, which the limit clips.
        free.remove("viscous")
    if "armature" in free and not joint.told and not _scaled(joint):
        free = [name for name in free if name not in ("armature", "bias")]
    return tuple(key for name in free for key in (joint.gains.keys(name) if name in GAINS else (name,)))


def _scaled(joint: JointInWork) -> bool:
    """Whether gravity or other joints give a torque that is known without the drive."""
    import numpy as np

    inertial = np.concatenate(
        [c.inertia * r.acceleration for c, r in zip(joint.courses, joint.recordings, strict=True)]
    )
    load = np.concatenate([course.load for course in joint.courses])
    return float(np.std(load)) > COUPLED * float(np.std(inertial))


def _descend(joint: JointInWork, options: FitOptions, out: Collector) -> None:
    """Fit a joint, from its last fit or from a regression on."""
    pieces = piecewise(joint)
    free = _free(joint, options)
    if joint.fit is not None:
        values = dict(joint.fit.values)
        assert joint.scale is not None
        scale = joint.scale
    else:
        values = _begun(joint, free)
        scale = joint.scale = _scales(joint, values)
    late = "lag" in free and values["lag"] <= 0.0
    # Where only ratios show, a gain that is held says nothing of friction, which may then be anything.
    unscaled = not joint.told and "armature" not in free
    joint.low = {
        name: -math.inf if name == "bias" or (unscaled and name == "viscous") else 0.0 for name in values
    }
    if late:
        # A low-pass does nearly what a delay does, and a search that begins with one need not find the other.
        rest = tuple(name for name in free if name != "lag")
        joint.fit = without = _searched(joint, pieces, rest, scale, joint.low, values)
        best = without
        for rows in LAGS:
            values = dict(without.values)
            _set_out(joint, values, free, rows)
            # Nothing is given up early: far from a slow low-pass the cost does not promise how far it falls.
            found = _searched(joint, pieces, free, scale, joint.low, values)
            best = min(best, found, key=lambda fit: fit.cost)
        if best is not without:
            # Along the valley of low-pass and delay a descent stops early.
            joint.fit = best
            best = _searched(joint, pieces, free, scale, joint.low, best.values)
        joint.fit = best if best.cost < without.cost - WIDE**2 else without
    else:
        _set_out(joint, values, free)
        joint.fit = _searched(joint, pieces, free, scale, joint.low, values)
    if not joint.fit.arrived:
        out.warning(
            "SYS030", "the fit did not come to rest: its figures are uncertain", where=joint.actuator.joint
        )


def _set_out(joint: JointInWork, values: dict[str, float], free: tuple[str, ...], rows: float = 0.0) -> None:
    """Where figures begin that do nothing at 0, and so tell no direction there."""
    assert joint.scale is not None
    if "static" in free and values["static"] <= values["coulomb"]:
        values["static"] = 1.5 * max(values["coulomb"], 0.1 * joint.scale["coulomb"])
    if "stribeck_velocity" in free and values["stribeck_velocity"] <= 0.0:
        values["stribeck_velocity"] = 0.5 * joint.scale["stribeck_velocity"]
    if "lag" in free and values["lag"] <= 0.0:
        values["lag"] = rows * joint.scale["lag"]
        if "delay" in free:
            values["delay"] = max(values["delay"] - values["lag"], 0.25 * joint.scale["delay"])


def _begun(joint: JointInWork, free: tuple[str, ...]) -> dict[str, float]:
    """Every value, where a descent begins."""
    spec = figures_of(joint.actuator)
    sets, held = joint.gains.sets, joint.gains.held
    sent = [
        (one.kp or spec["kp"] or 1.0, one.kd if one.kd is not None else spec["kd"] or 0.1) for one in sets
    ]
    # Where a log of several has a torque, those that have one tell where to begin.
    telling = [i for i, one in enumerate(joint.recordings) if not joint.torque or "torque" in one.measured]
    sets_told = sorted({joint.gains.used[i] for i in telling})
    first = begin(
        [joint.recordings[i] for i in telling],
        [joint.courses[i] for i in telling],
        joint.bounds,
        [sets_told.index(joint.gains.used[i]) for i in telling],
        None if joint.torque else sent,
    )
    told_gains = dict(zip(sets_told, first.gains, strict=True))
    values = {**spec, **{name: value for name, value in first.values.items() if name in free}}
    for index, given in enumerate(sent):
        for name, regressed, stated in zip(GAINS, told_gains.get(index, given), given, strict=True):
            key, factor = joint.gains.key(name, index)
            if factor == 1.0:
                values[key] = stated if name in held else regressed
    if "kd" in free and "viscous" not in free and not joint.parted:
        values["kd"] += first.values["viscous"]
        values["viscous"] = 0.0
    return values


def _searched(
    joint: JointInWork,
    pieces: Sequence[Piecewise],
    free: tuple[str, ...],
    scale: Mapping[str, float],
    low: Mapping[str, float],
    values: Mapping[str, float],
) -> Fit:
    """The best fit; where a torque tells which command acts, over the rows that it may tell.

    Behind a low-pass it does not jump with the command, and the row is no question.
    """
    step = joint.recordings[0].step
    search = Search(pieces, joint.bounds, free, scale, low, values["delay"] if joint.torque else None)
    clocks = [recording.time for recording in joint.recordings]
    telling = joint.torque and "delay" in free and "lag" not in free and values["lag"] <= 0.0
    smeared = telling and max(unevenness(time) for time in clocks) > SMEARED
    best = descend(search, values, joint.fit, rounds=ROUGHLY if smeared else ROUNDS)
    if not telling:
        return best
    tried = {math.floor(values["delay"] / step)}
    for _ in range(0 if smeared else 4):
        row = math.floor(best.values["delay"] / step)
        fresh = [option for option in (row, row - 1, row + 1) if option >= 0 and option not in tried]
        if not fresh:
            break
        for option in fresh:
            tried.add(option)
            other = descend(replace(search, reading=(option + 0.5) * step), best.values, best, best.cost)
            if other.cost < best.cost:
                search, best = replace(search, reading=(option + 0.5) * step), other
    if smeared:
        # Of what is told by a delay that is nearly right, only what its error does not change.
        reading = best.values["delay"]
        sure = replace(
            search, logs=[_sure(piece, reading, NEARLY * step) for piece in pieces], reading=reading
        )
        best = replace(descend(sure, best.values, best), cost=math.inf)
    # Between uneven rows a delay ends now in one, now in the next: what each torque tells follows from it exactly.
    for turn in range(FOLLOWED):
        reading = best.values["delay"]
        if (turn or not smeared) and _retold(clocks, search.reading, reading) <= SAME:
            break
        search = replace(search, reading=reading)
        other = descend(search, best.values, best, best.cost)
        if other.cost > best.cost:
            break
        best = other
    return best


def _sure(piece: Piecewise, delay: float, error: float) -> Piecewise:
    """The log without those torques that tell another command where the delay is off by so much."""
    import numpy as np

    if "torque" not in piece.measured:
        return piece
    time = piece.course.time
    same = told(time, max(delay - error, 0.0)) == told(time, delay + error)
    torque = np.where(same, piece.measured["torque"], np.nan)
    return replace(piece, measured={**piece.measured, "torque": torque})


def _retold(clocks: Sequence[Array], one: float | None, other: float) -> float:
    """Share of the rows whose torque tells another command with another delay."""
    import numpy as np

    assert one is not None
    return max(float(np.mean(told(time, one) != told(time, other))) for time in clocks)


def _scales(joint: JointInWork, values: Mapping[str, float]) -> dict[str, float]:
    """Sizes of the figures, for differences and to judge what is vague."""
    import numpy as np

    inertia = float(np.mean([course.inertia.mean() for course in joint.courses])) + values["armature"]
    torque = max(
        float(np.std(values["kp"] * (c.command - r.position)))
        for c, r in zip(joint.courses, joint.recordings, strict=True)
    )
    speed = max(float(np.abs(recording.velocity).max()) for recording in joint.recordings)
    damping = max(values["kd"] + values["viscous"], 0.02 * math.sqrt(values["kp"] * inertia))
    gains = {key: max(values[key], 1e-3) for key in joint.gains.keys("kp")}
    gains |= {key: max(values[key], damping) for key in joint.gains.keys("kd")}
    return {
        **gains,
        "armature": inertia,
        "coulomb": max(0.1 * torque, 1e-4),
        "viscous": damping,
        "static": max(0.1 * torque, 1e-4),
        "stribeck_velocity": 0.1 * speed,
        "delay": joint.recordings[0].step,
        "bias": 0.01,
        "lag": joint.recordings[0].step,
    }
