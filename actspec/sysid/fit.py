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
from actspec.sysid.checks import check
from actspec.sysid.coupling import Path, course_of, dense, fitted, links_of, read
from actspec.sysid.course import Course
from actspec.sysid.descent import simulated
from actspec.sysid.doubts import doubted, judge_torques
from actspec.sysid.figures import Bounds
from actspec.sysid.gains import extended, gains_of, joined
from actspec.sysid.identified import FIGURE, Identification, State
from actspec.sysid.judge import UNLIKE, judge_fit, judged
from actspec.sysid.late import align, at_rows, better, judge_lateness
from actspec.sysid.links import links_at
from actspec.sysid.more import enlarged
from actspec.sysid.recording import SMOOTH, Recording, driven, reading_noise, record, smooth
from actspec.sysid.released import release
from actspec.sysid.single import COUPLED, fit_joint
from actspec.sysid.sparse import judge_rows
from actspec.sysid.stand import Stand, by_log, idle
from actspec.sysid.system import System
from actspec.sysid.torques import prompt
from actspec.sysid.unseen import held_out, judge_validation, tested, told_apart
from actspec.sysid.work import FitOptions, JointInWork, ended, piecewise
from actspec.sysid.zeros import judge_biases, judge_zeros

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

ASKEW = 2e-3
"""Error of a position from which on the links along it are taken again [rad or m]. Gravity's slope is right to the
first order alone: 20 mrad made kp 0.02 % wrong."""
PASSES = 8
"""Most times that the links along the path are taken again. Measured: a leg takes three to five."""
SETTLED = 0.2
"""Change of a bias from one time to the next that is nothing any more, in its standard deviations."""
SLOWLY, LOOKS = 0.05, 25
"""Width of the filter with which accelerations are compared for whether joints move each other [s], and rows of a log
at which their inertia is. Chosen: it is asked for a size alone."""
WIDER, LEAST_CUBIC = 2.0, 5
"""The filter of joints that move as read, over the usual one, and rows that this has at least: what the two make of a
figure is how little is known of it. Chosen: of 5 and 9 rows, the wider one lets a fifth of the noise through."""
NUDGE = 0.1
"""Change of the load that is nothing any more, as the position that it makes over the bias's standard deviation."""


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
    askew = frozenset() if out.failed else judge_zeros(stand, joints, out)
    felt = [joint for name, joint in joints.items() if joint.torque and joint.courses and name not in askew]
    judge_torques(felt, out)
    out.raise_if_failed(LogError)
    beside = carried(stand, joints, options) if options.joints else {}
    fitted_too = roll(stand, logs, joints, options, out, beside)
    tell_left_out(stand, {name: joint.recordings for name, joint in joints.items()}, out, fitted_too)
    systems = {}
    for name, joint in joints.items():
        joints[name], systems[name] = _enlarged(joint, options, out)
        judge_rows(joints[name], options, fit_joint, out)
    errors: Mapping[str, float | None]
    if validation:
        errors = _validated(stand, validation, joints, unseen, out)
    else:
        errors = {name: held_out(joint, systems[name]) for name, joint in joints.items()}
    found = tuple(
        doubted(
            joint, judged(joint, options, systems[name], errors.get(name)), systems[name], out, name in askew
        )
        for name, joint in joints.items()
    )
    if validation:
        made = {name: tuple(one.log.path for one in recordings) for name, recordings in unseen.items()}
        judge_validation({joint.joint: joint for joint in found}, made, out)
    if out.failed:  # there are no figures then that could be uncertain
        out.forget(("SYS030",))
    out.raise_if_failed(LogError)
    judge_fit([joint for joint in found if joint.joint not in askew], out)
    judge_biases(found, askew, out)
    return Identification(actuators.robot, "rollout", found, out.sorted(), clock.perf_counter() - begun)


def roll(
    stand: Stand,
    logs: Sequence[Log],
    joints: Mapping[str, JointInWork],
    options: FitOptions,
    out: Collector,
    beside: Mapping[str, JointInWork] | None = None,
) -> frozenset[str]:
    """Fit joints that are prepared; again with their free swings, and where the links along their path are others.

    Args:
        stand: The model, and where its other joints are.
        logs: That the joints' recordings are of.
        joints: They get their fits.
        options: What the user asks.
        out: Takes what is to be said of `joints`.
        beside: Joints that move these, of which nothing is said; see `carried`.

    Returns: Those of `beside` whose own fits say how they moved; the others moved as read.
    """
    every = {**joints, **(beside or {})}
    heard = {name: out if name in joints else Collector() for name in every}
    if beside:
        _couple(stand, logs, every, fits=False)
    read = _biases(every)
    for name, joint in every.items():
        fit_joint(joint, options, heard[name])
        if release(joint, heard[name]):
            fit_joint(joint, options, heard[name])
        align(joint, options, fit_joint)
    # A model that moves otherwise than such a joint did knows less of it than its readings.
    every = {name: joint for name, joint in every.items() if name in joints or not _unlike(joint)}
    # How the others moved was by a filter of their readings: the fit knows it better.
    coupled = again = _coupled(every)
    for _ in range(PASSES):
        if not again and not any(abs(now - read[name]) > ASKEW for name, now in _biases(every).items()):
            break
        read = _biases(every)
        before = {name: joint.courses for name, joint in every.items()}
        _couple(stand, logs, every, fits=coupled)
        for name, joint in every.items():
            if _pushed(joint, before[name]):
                fit_joint(joint, options, heard[name])
        # What is found of a joint's bias moves gravity at the others.
        again = coupled and any(_moved(joint, read[name]) for name, joint in every.items())
    if any(stand.beside(log, list(every))[1] for log in logs):
        for name, courses in _courses(stand, logs, every, fits=coupled, wider=True).items():
            every[name].otherwise = courses
    return frozenset(every.keys() - joints.keys())


def _enlarged(joint: JointInWork, options: FitOptions, out: Collector) -> tuple[JointInWork, System]:
    """The joint with more figures, and its residuals; of a torque that is late by part of a row the likelier cause."""
    heard = Collector()
    found, system = _wider(joint, options, heard)
    if any(one.ago for one in joint.recordings):
        # A slow drive that the model does not have looks like a torque that is late, and is tried without that.
        prompt, unheard = at_rows(joint), Collector()
        fit_joint(prompt, options, unheard)
        other, residuals = _wider(prompt, options, unheard)
        if better(found, other):
            found, system, heard = other, residuals, unheard
    judge_lateness(found, heard)
    for item in heard:
        out.add(item)
    return found, system


def _wider(joint: JointInWork, options: FitOptions, out: Collector) -> tuple[JointInWork, System]:
    """The joint with more figures; with a low-pass only where it is told then: else the delay is short of it."""
    heard = Collector()
    found, system = enlarged(joint, options, fit_joint, heard)
    if "lag" in found.added:
        told = judged(replace(found), options, system, None).parameter("bandwidth")
        if told.state is not State.IDENTIFIED:
            heard = Collector()
            without = replace(options, hold=options.hold | {"bandwidth"})
            found, system = enlarged(joint, without, fit_joint, heard)
    if found.added and align(found, options, fit_joint):
        system = ended(found)
    for item in heard:
        out.add(item)
    return found, system


def _unlike(joint: JointInWork) -> bool:
    """Whether a fit's position is off by so much more than the readings' noise that it is no guide to the motion."""
    assert joint.fit is not None
    return joint.fit.noise["position"] > UNLIKE * reading_noise(joint.recordings)


def carried(stand: Stand, joints: Mapping[str, JointInWork], options: FitOptions) -> dict[str, JointInWork]:
    """Joints that nobody asked for and that move those which are fitted, ready for a fit of their own.

    By its readings one knows too little of such a joint: two differences of 0.4 mrad of noise at 200 Hz are an
    acceleration of 9 rad/s^2. Measured on a leg with it in the load: a delay of 4.5 +- 0.8 ms for 7 ms.

    Args:
        stand: The model, and where its other joints are.
        joints: That are asked for.
        options: What the user asks.
    """
    import numpy as np

    found: dict[str, JointInWork] = {}
    logs = {id(r.log): r for joint in joints.values() for r in joint.recordings}
    pulling = {key: _pulling(stand, recording, joints) for key, recording in logs.items()}
    for name in dict.fromkeys(name for names in pulling.values() for name in names):
        mine = [recording.log for key, recording in logs.items() if name in pulling[key]]
        # What is wrong with it is no matter of the joints that are asked for: then it moves as read.
        unheard = Collector()
        joint = prepared(stand, mine, [name], options, unheard).get(name)
        if unheard.failed or joint is None:
            continue
        if all(np.array_equal(one.time, logs[id(one.log)].time) for one in joint.recordings):
            found[name] = joint
    return found


def _pulling(stand: Stand, recording: Recording, joints: Mapping[str, JointInWork]) -> list[str]:
    """Other joints that a log's commands move and whose accelerations pull at a joint that is fitted there."""
    import numpy as np

    log = recording.log
    others = [
        actuator.joint
        for actuator in stand.actuators.joints
        if actuator.joint not in joints
        and (columns := log.joints.get(actuator.joint)) is not None
        and columns.position is not None
        and np.isfinite(columns.position).mean() > 0.5
        and not idle(columns)
    ]
    mine = [name for name, joint in joints.items() if any(one.log is log for one in joint.recordings)]
    if not others:
        return []
    names = [*mine, *others]
    paths, pushes = [], []
    for name in names:
        position = log.joints[name].position
        assert position is not None
        paths.append(smooth(log.time, position, SLOWLY))
        pushes.append(float(np.std(smooth(log.time, position, SLOWLY, 2))))
    base = log.sidecar.base
    at = links_at(stand.beside(log, names)[0], names, None if base is None else base.orientation)
    rows = np.linspace(0, len(log.time) - 1, LOOKS).astype(int)
    inertia = np.abs([at(q, 0.0 * q)[0] for q in np.stack(paths, axis=1)[rows]]).mean(axis=0)
    pulls = inertia[: len(mine)] * np.array(pushes)
    own = np.diagonal(pulls)[:, None]
    return [
        name
        for name, share in zip(others, (pulls[:, len(mine) :] / own).max(axis=0), strict=True)
        if share > COUPLED
    ]


def tell_left_out(
    stand: Stand,
    recordings: Mapping[str, Sequence[Recording]],
    out: Collector,
    fitted: frozenset[str] = frozenset(),
) -> None:
    """Say which joints of each log have no figures, and where they are.

    Args:
        stand: The model, and where its other joints are.
        recordings: Of the joints with figures.
        out: Takes it.
        fitted: Others whose fit says how they moved.
    """
    for log, here in by_log({name: [(one.log, one) for one in mine] for name, mine in recordings.items()}):
        stand.tell_left_out(log, here, out, fitted)


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
        stand.tell(
            {name: [(r.log, r.position) for r in joint.recordings] for name, joint in joints.items()}, out
        )
        _couple(stand, logs, joints, fits=False)
        for joint in joints.values():
            pairs = zip(joint.recordings, joint.courses, strict=True)
            joint.recordings = [prompt(recording, course) for recording, course in pairs]
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
    """Give every joint its courses; see `_courses`."""
    for name, courses in _courses(stand, logs, joints, fits=fits).items():
        joints[name].courses = courses


def _courses(
    stand: Stand,
    logs: Sequence[Log],
    joints: Mapping[str, JointInWork],
    *,
    fits: bool,
    wider: bool = False,
) -> dict[str, list[Course]]:
    """Courses of every joint: the links along each log, and in the load what the others' motion does.

    Args:
        stand: The model, and where its other joints are.
        logs: That the joints' recordings are of.
        joints: Of which the courses are made.
        fits: Whether the joints move as their fits say; else as the readings do.
        wider: Whether the readings of other joints go through a wider filter.
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
        width = WIDER * max(SMOOTH, LEAST_CUBIC * recordings[0].step) if wider else SMOOTH
        links, paths = links_of(stand, recordings, paths, list(here), width)
        for j, (name, recording) in enumerate(zip(here, recordings, strict=True)):
            made[name].append(course_of(recording, links, paths, j))
    return made


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
