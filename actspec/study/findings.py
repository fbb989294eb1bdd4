"""What a diagnosis finds wrong, with its bounds: one table, which messages and pages ask."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from actspec.diagnostics import Diagnostic, Severity
from actspec.ir import JointActuator, Level
from actspec.spec.plausible import Check
from actspec.study.measures import JointMeasures, knows_bandwidth

MOST = {"saturated": 0.10, "beyond": 0.01, "continuous_ratio": 1.0, "high_frequency": 0.20}
"""From which on each is a finding. Chosen: twice and more of what is good enough."""
MISSED = 0.10
"""Root mean square of what the spec's law misses of a logged torque, as a share of the effort limit, from which on that
is a finding. Chosen: a fitted law leaves a few hundredths."""
UNTOLD = 0.5
"""Standard deviation of what the spec's law misses over that of the logged torque, noise taken off both, from which on
that is a finding too. Chosen: it then tells less than three quarters of the variance; gains 20 % off leave a quarter
of the standard deviation, a fitted law a few hundredths."""
FINE = {"saturated": 0.05, "beyond": 0.01, "continuous_ratio": 1.0, "high_frequency": 0.10}
"""Up to which each is good enough. Chosen: what a margin for another day and another robot leaves."""

CHECKS = (
    Check(
        "DGN001",
        "torque-at-its-limit",
        "A drive that works with at least 0.9 of its effort limit in more than 10 % of the log.",
        "What the policy asks for beyond the limit has no effect, so that it steers by where the limit is: one that is "
        "a little lower on the robot changes every step. Below 5 % is good enough. Smaller action scales, a penalty "
        "on torque, or a limit that is the motor's.",
    ),
    Check(
        "DGN002",
        "torque-beyond-the-motor",
        "More than 1 % of the log needs over 0.05 of the effort limit more than the motor's torque-speed line has.",
        "The motor cannot give that torque at that speed: in simulation the joint is stronger than on the robot. Level "
        "`dc_motor` holds the line in each simulator; `actspec compare` shows what it changes.",
    ),
    Check(
        "DGN003",
        "above-the-continuous-torque",
        "A root mean square of the torque above the motor's continuous torque.",
        "The motor gets hot: its driver takes torque away after seconds to minutes, and its resistance grows. The log "
        "may be shorter than that. A penalty on torque, or a gait that rests.",
    ),
    Check(
        "DGN004",
        "torque-faster-than-the-motor",
        "More than 20 % of the torque's variance above the motor's bandwidth, else the filter's cutoff, else 30 Hz.",
        "Such torque does not reach the joint, or shakes it: in simulation it is free. Below 10 % is good enough. A "
        "filter on the command, a penalty on the action's rate, less kd, or a velocity that is noisy in the log.",
    ),
    Check(
        "DGN005",
        "command-faster-than-the-motor",
        "95 % of the command's variance reach beyond the bandwidth that the spec states.",
        "The drive cannot follow what it is asked for. `command_filter: from_motor` tells the policy so.",
    ),
    Check(
        "DGN006",
        "torque-of-another-drive",
        "A root mean square of what the spec's law misses of the logged torque above 10 % of the effort limit; or a "
        "standard deviation of it above half of the logged torque's own, where that is 2 % of the limit and twice its "
        "noise at least.",
        "The joint is driven by another law than the spec's: other gains, a friction, a delay or a line that the spec "
        "lacks, or a torque in another unit or of another sign. A fitted law leaves a few hundredths. `actspec sysid "
        "fit` finds the figures; where they leave as much, `actspec net train`.",
    ),
)
"""In the order of their codes."""

COMPARED = (
    Check(
        "CMP001",
        "step-does-not-carry-the-drive",
        "MuJoCo, at the spec's step and with the spec's integrator, does not come to rest where the law does.",
        "The torque swings between its limits for ever, and no NaN tells it. `h kd / J` is the part of the speed that "
        "an explicit step takes away; from 2 on it diverges. A shorter step, `implicitfast`, or less kd.",
    ),
)
"""What `compare` finds."""


def findings(
    measures: Sequence[JointMeasures], actuators: Mapping[str, JointActuator]
) -> tuple[Diagnostic, ...]:
    """What is wrong with joints, as warnings in the order of the codes, of each code the worst joint first."""
    found = [pair for one in measures for pair in _findings(one, actuators[one.joint])]
    found.sort(key=lambda pair: (pair[1].code, -pair[0]))
    return tuple(item for _, item in found)


def _findings(measures: JointMeasures, actuator: JointActuator) -> Iterator[tuple[float, Diagnostic]]:
    """What is wrong with one joint: how many times the bound, and the words."""
    unit = actuator.effort_limit.unit
    m = measures
    bandwidth = m.command_band if knows_bandwidth(actuator) else None
    missed, limit = m.torque_error.get("spec"), actuator.effort_limit.value
    share = None if missed is None or not limit else missed / limit
    told: dict[str, tuple[float | None, float, str, str]] = {
        "DGN001": (
            m.saturated,
            MOST["saturated"],
            f"the torque is at its limit in {m.saturated or 0.0:.0%} of the rows",
            "smaller action scale, a penalty on torque, or the motor's own limit",
        ),
        "DGN002": (
            m.beyond,
            MOST["beyond"],
            f"the torque is beyond what the motor has at its speed in {m.beyond or 0.0:.1%} of the rows",
            "level: dc_motor"
            if actuator.level is Level.IDEAL_PD
            else "the spec has the line, and the log was made without it: run what `actspec compile` writes",
        ),
        "DGN003": (
            m.continuous_ratio,
            MOST["continuous_ratio"],
            f"the RMS torque, {m.rms_torque:.3g} {unit}, is {m.continuous_ratio or 0.0:.3g} times the continuous one",
            "a penalty on torque, or a gait that rests",
        ),
        "DGN004": (
            m.high_frequency,
            MOST["high_frequency"],
            f"{m.high_frequency or 0.0:.0%} of the torque's variance is above {m.fast:g} Hz",
            "a filter on the command, a penalty on the action's rate, less kd",
        ),
        "DGN005": (
            bandwidth,
            m.fast,
            f"the command reaches up to {bandwidth or 0.0:.3g} Hz, the drive to {m.fast:g} Hz",
            "command_filter: from_motor, or a penalty on the action's rate",
        ),
        "DGN006": (
            share,
            MISSED,
            f"the spec's law misses the torque by {missed or 0.0:.3g} {unit} RMS, {share or 0.0:.0%} of the limit",
            "the gains and the unit of the log, then `actspec sysid fit`",
        ),
    }
    for code, (value, most, words, help) in told.items():
        if value is not None and value > most:
            yield value / most, Diagnostic(code, Severity.WARNING, words, m.joint, actuator.span, help)
        elif code == "DGN006" and m.torque_untold is not None and m.torque_untold > UNTOLD:
            words = (
                f"the spec's law misses the torque by {missed or 0.0:.3g} {unit} RMS, which is {m.rms_torque:.3g}: "
                f"what it misses varies by {m.torque_untold:.0%} of what the torque does"
            )
            yield (
                m.torque_untold / UNTOLD,
                Diagnostic(code, Severity.WARNING, words, m.joint, actuator.span, help),
            )


def enough(measures: JointMeasures) -> bool:
    """Whether nothing of a joint is above what is good enough; what is not known does not count."""
    return all(
        value is None or (value <= most if name == "continuous_ratio" else value < most)
        for name, most in FINE.items()
        for value in [getattr(measures, name)]
    )
