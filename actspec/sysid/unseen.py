"""How far the position is off where the fit did not look: pieces of its own logs, or logs that it is validated on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from actspec.diagnostics import Collector, Span, listed
from actspec.sysid.course import Course
from actspec.sysid.descent import Fit, Search, descend
from actspec.sysid.gains import GainSets
from actspec.sysid.identified import JointFit
from actspec.sysid.recording import Recording
from actspec.sysid.system import System
from actspec.sysid.work import JointInWork, piecewise
from actspec.units import format_number

WORSE = 3.0
"""Position error on a log of its own over that of the fit, from which on the figures do not carry over. Chosen: as for
the misfit, so that a little more friction on another day is none."""


def held_out(joint: JointInWork, system: System) -> float | None:
    """Position error on every fifth piece, with figures from the others [rad or m]; arguments as of `unseen`."""
    return unseen(joint, system).get("position")


def unseen(joint: JointInWork, system: System) -> dict[str, float]:
    """Errors of position and torque on every fifth piece, with figures from the others; none of too few pieces.

    Args:
        joint: After its fit.
        system: Residuals where the fit ended, and their derivatives.
    """
    import numpy as np

    counts = [log["position"][0].shape[1] for log in system.logs]
    which = [np.arange(count) % 5 == 2 for count in counts]
    if sum(counts) < 5 or not any(some.any() for some in which):
        return {}
    assert joint.fit is not None
    errors = system.left_out(joint.fit.noise, which).noise()
    return {channel: errors[channel] for channel in ("position", "torque") if channel in errors}


def tested(joint: JointInWork) -> Fit:
    """A joint's figures on the logs of `joint`, which no fit has seen: only where each piece begins is found."""
    fit, scale = joint.fit, joint.scale
    assert fit is not None and scale is not None
    return descend(Search(piecewise(joint), joint.bounds, (), scale, joint.low, fit.reading), fit.values)


def told_apart(joint: JointInWork, possible: Sequence[Sequence[int]], out: Collector) -> GainSets:
    """The gains of logs of `joint`, which no fit has seen: of those that each may have, the ones that it moves by.

    Args:
        joint: With its courses.
        possible: For each log, sets of gains, the likeliest first.
        out: Takes which ones were taken where another than the likeliest.
    """
    used = []
    for recording, course, some in zip(joint.recordings, joint.courses, possible, strict=True):

        def off(at: int, recording: Recording = recording, course: Course = course) -> float:
            gains = replace(joint.gains, used=(at,))
            return tested(replace(joint, recordings=[recording], courses=[course], gains=gains)).noise[
                "position"
            ]

        best = some[0] if len(some) == 1 else min(some, key=off)
        used.append(best)
        if best != some[0]:
            message = f"it moves by {joint.gains.sets[best]}, not by {joint.gains.sets[some[0]]}"
            help = f"state its gains: write `gains: {{{joint.actuator.joint}: {{kp: ..., kd: ...}}}}` beside the log"
            out.info("SYS033", message, where=joint.actuator.joint, span=Span(recording.log.path), help=help)
    return replace(joint.gains, used=tuple(used))


def judge_validation(
    found: Mapping[str, JointFit], logs: Mapping[str, tuple[str, ...]], out: Collector
) -> None:
    """What is to be said of validation.

    Args:
        found: Joints that were fitted.
        logs: Joint to the logs that it was validated on; a joint that is in none of them is left out.
        out: Takes it.
    """
    missing = [name for name in found if name not in logs]
    if missing:
        message = (
            f"no log of --validate has {listed(missing)}: nothing is known of how far these figures carry"
        )
        out.info("SYS028", message)
    for name, paths in logs.items():
        joint = found[name]
        assert joint.position_rmse is not None
        if joint.held_out_rmse is None or joint.held_out_rmse <= WORSE * joint.position_rmse:
            continue
        unit = next(p.unit for p in joint.parameters if p.field == "encoder_bias")
        message = (
            f"the position is off by {format_number(joint.held_out_rmse, 3)} {unit} in {listed(paths, 3)}, and by "
            f"{format_number(joint.position_rmse, 3)} {unit} in the logs of the fit: the figures do not carry over"
        )
        help = (
            "is it the same robot, pose of the base, gains and temperature? Fit logs of both kinds of motion"
        )
        out.warning("SYS029", message, where=name, span=Span(paths[0]), help=help)
