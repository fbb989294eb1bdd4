"""The ways to fit a log beside rollouts: its spectra, its steps, its stretches of constant speed."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping, Sequence
from dataclasses import replace

from actspec.diagnostics import Collector, Severity, Span, listed
from actspec.ir import ActuatorSet
from actspec.logs import Log, LogError
from actspec.robot.view import RobotView
from actspec.sysid import frequency, friction, step
from actspec.sysid.figures import Bounds
from actspec.sysid.fit import fit_logs, joints_of, prepared, recorded, roll, tell_left_out
from actspec.sysid.gains import gains_of
from actspec.sysid.identified import Identification, JointFit
from actspec.sysid.late import judge_lateness
from actspec.sysid.recording import Recording
from actspec.sysid.stand import Stand
from actspec.sysid.work import FitOptions

NOTHING = ("SYS051", "SYS055", "SYS059")
"""Why a joint's log tells nothing."""


def fit_by(
    method: str,
    actuators: ActuatorSet,
    robot: RobotView,
    logs: Sequence[Log],
    options: FitOptions,
    validation: Sequence[Log] = (),
) -> Identification:
    """Identify every joint that is in the logs, in one of several ways.

    Args:
        method: One of `METHODS`.
        actuators: The spec, resolved.
        robot: Its model.
        logs: At least one.
        options: What the user asks; only rollouts free and hold fields.
        validation: Logs that the fit does not see, likewise.

    Raises:
        LogError: nothing can be fitted, with every reason.
        RobotError: the model does not tell the links' inertia, where that is asked for.
    """
    if method == "rollout":
        return fit_logs(actuators, robot, logs, options, validation)
    begun = clock.perf_counter()
    out = Collector()
    _check_options(method, options, validation, out)
    stand = Stand(robot, actuators)
    names = joints_of(actuators, logs, out, options.joints)
    stand.check(logs, out)
    out.raise_if_failed(LogError)
    found = (
        _friction(stand, logs, names, out)
        if method == "friction"
        else _closed_loop(method, stand, recorded(actuators, logs, names, out), out)
    )
    out.raise_if_failed(LogError)
    if not found:
        # What was a warning, because another joint might have told something, is why nothing is written.
        worst = [
            replace(one, severity=Severity.ERROR) if one.code in NOTHING else one for one in out.sorted()
        ]
        raise LogError(tuple(worst))
    return Identification(actuators.robot, method, tuple(found), out.sorted(), clock.perf_counter() - begun)


def _check_options(method: str, options: FitOptions, validation: Sequence[Log], out: Collector) -> None:
    """Fields are freed, held and tried on another log by rollouts."""
    for option, given in (("--free", options.free), ("--hold", options.hold)):
        if given:
            message = f"{listed(sorted(given))}: with --method {method} no field is free or held"
            help = f"leave {option} out, or use --method rollout"
            out.error("SYS050", message, where=option, help=help)
    if validation:
        message = f"{listed([log.path for log in validation])}: --method {method} predicts no motion to hold to a log"
        out.error("SYS050", message, where="--validate", help="leave --validate out, or use --method rollout")


def _closed_loop(
    method: str, stand: Stand, recordings: Mapping[str, Sequence[Recording]], out: Collector
) -> list[JointFit]:
    """What the position says of the command alone."""
    tell_left_out(stand, recordings, out)
    found = []
    for name, mine in recordings.items():
        if not mine:
            continue
        actuator = stand.actuators.joint(name)
        assert actuator is not None
        logs = [recording.log for recording in mine]
        # Nothing is held here, so gains may be unknown.
        gains = gains_of(actuator, logs, torque=True, free=frozenset(), hold=frozenset(), out=Collector())
        place = Span(logs[0].path)
        if len(gains.sets) > 1:
            message = "the logs have gains of their own: each has a closed loop of its own"
            out.error(
                "SYS050", message, where=name, span=place, help="fit logs of one pair of gains at a time"
            )
        elif any(recording.speed_command.any() for recording in mine):
            message = (
                "a velocity command was sent too: the position is no answer to the position command alone"
            )
            out.error("SYS050", message, where=name, span=place, help="use --method rollout, which has both")
        elif method == "frequency":
            found.append(frequency.judged(actuator, mine, out))
        else:
            kp, kd = gains.sets[0].kp, gains.sets[0].kd
            known = None if kp is None or kd is None else (kp, kd)
            found.append(step.judged(actuator, mine, Bounds.of(actuator), known, out))
    return [one for one in found if one is not None]


def _friction(stand: Stand, logs: Sequence[Log], names: Sequence[str], out: Collector) -> list[JointFit]:
    """What the torque at constant speeds says."""
    joints = prepared(stand, logs, names, FitOptions(), out)
    tell_left_out(stand, {name: joint.recordings for name, joint in joints.items()}, out)
    for name, joint in joints.items():
        for recording in joint.recordings:
            place = Span(recording.log.path)
            if recording.log.sidecar.torque == "joint":
                message = "the torque was read behind friction: friction is not in it"
                help = "log the drive's torque or current, or use --method rollout with stated gains"
                out.error("SYS058", message, where=name, span=place, help=help)
            elif "torque" not in recording.measured:
                message = "no torque was logged: how much of it is friction does not show"
                help = f"log it as {name}.torque [N*m], or use --method rollout with `gains:` in the sidecar"
                out.error("SYS058", message, where=name, span=place, help=help)
    out.raise_if_failed(LogError)
    roll(stand, logs, joints, FitOptions(), out)
    for joint in joints.values():
        judge_lateness(joint, out)
    return [one for joint in joints.values() if (one := friction.judged(joint, out)) is not None]
