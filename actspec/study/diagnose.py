"""From logs and answers to what is wrong with a simulated actuator, and what to do about it."""

from __future__ import annotations

from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Diagnostic, Severity, Span, listed
from actspec.ir import ActuatorSet, JointActuator, Level
from actspec.libraries import extra_line
from actspec.logs import Log, LogError
from actspec.study.advice import Advice, advise
from actspec.study.findings import enough, findings
from actspec.study.learned import Sampled
from actspec.study.level import LADDER, Answers, LevelChoice, choose_level
from actspec.study.measures import Gap, JointMeasures, Track, gap_between, measured, track_of
from actspec.study.rollouts import position_errors
from actspec.sysid.fit import recorded
from actspec.sysid.torques import OWN_ROW, OWN_ROW_HELP
from actspec.verify.joint_laws import laws_of

if TYPE_CHECKING:
    from actspec.robot.view import RobotView


CONTRADICTIONS = frozenset({"SYS014", "SYS015", "SYS047"})
"""Signs and units, exchanged joints and columns, angles that are not the model's: what a fit is told of a log too."""


@dataclass(frozen=True, slots=True)
class Skipped:
    """A joint that could not be judged.

    Attributes:
        joint: Its name.
        reason: Why.
    """

    joint: str
    reason: str


@dataclass(frozen=True, slots=True)
class Diagnosis:
    """What was found.

    Attributes:
        joints: Those that the logs tell of, in the spec's order.
        skipped: The others, of spec and logs.
        findings: What is wrong; what is wrong with the logs' columns first.
        notes: What the logs were taken for.
        advice: The cheapest first.
        level: What is recommended.
        enough: Whether the model is good enough by these logs; None: between good and bad, no log, or one whose columns
            contradict each other.
        tracks: What the logs have of each joint that was judged, for pictures.
    """

    joints: tuple[JointMeasures, ...]
    skipped: tuple[Skipped, ...]
    findings: tuple[Diagnostic, ...]
    notes: tuple[Diagnostic, ...]
    advice: tuple[Advice, ...]
    level: LevelChoice
    enough: bool | None
    tracks: Mapping[str, tuple[Track, ...]]

    @property
    def contradicted(self) -> bool:
        """Whether what is wrong with the logs' columns leaves nothing to be said of the model."""
        return any(item.code in CONTRADICTIONS for item in self.findings)


def diagnose(
    actuators: ActuatorSet,
    robot: RobotView,
    spec: str,
    logs: Sequence[Log],
    against: Log | None,
    answers: Answers,
) -> Diagnosis:
    """Judge a spec by logs of a rollout or a robot.

    Args:
        actuators: The spec, resolved.
        robot: Its model, for rollouts where no torque was logged.
        spec: Its path, for commands.
        logs: May be empty: then spec and answers alone count.
        against: Another log of the same commands, such as a robot's beside a simulation's.
        answers: Of the user.

    Raises:
        LogError: no joint of a log is one of the spec.
    """
    out = Collector()
    known = {actuator.joint: actuator for actuator in actuators.joints}
    everything = [*logs, *([against] if against is not None else [])]
    for log in everything:
        if not known.keys() & log.joints.keys():
            out.error(
                "DGN010",
                f"no joint of the log is one of the spec: {listed(list(log.joints), 4)}",
                span=Span(log.path),
                help=f"joints of the spec: {listed(list(known), 4)}; `columns` in the sidecar gives theirs other names",
            )
    out.raise_if_failed(LogError)
    signals = _signals(actuators, everything, out)
    refused = {item.where: item.code for item in signals if item.severity is Severity.ERROR}
    learned = _networks(actuators, out) if logs else {}
    found: list[JointMeasures] = []
    kept: dict[str, tuple[Track, ...]] = {}
    skipped = [Skipped(name, "the spec does not have it") for name in _foreign(everything, known)]
    for actuator in actuators.joints if logs else ():
        if actuator.joint in refused:
            why = f"its columns contradict each other ({refused[actuator.joint]})"
            skipped.append(Skipped(actuator.joint, why))
            continue
        tracks, reasons = _tracks(actuator.joint, logs, actuators, out)
        if not tracks:
            skipped.append(Skipped(actuator.joint, reasons[0] if reasons else "no log has it"))
            continue
        gap: Gap | None = None
        if against is not None:
            others, _ = _tracks(actuator.joint, [against], actuators, out)
            gap = gap_between(tracks[0], others[0]) if others else None
        result = measured(actuator, tracks, gap, learned.get(actuator.joint))
        if isinstance(result, str):
            skipped.append(Skipped(actuator.joint, result))
        else:
            found.append(result)
            kept[actuator.joint] = tuple(tracks)
    blind = {one.joint: kept[one.joint] for one in found if one.torque_from == "law"}
    if blind:
        moved = position_errors(robot, actuators, logs, blind, learned, out)
        found = [replace(one, position_error=moved.get(one.joint, {})) for one in found]
    early = [one.joint for one in found if one.torque_late == 0]
    if early:
        message = f"{OWN_ROW}: {listed(early, 4)}"
        out.info("DGN012", message, span=Span(logs[0].path), help=OWN_ROW_HELP)
    wrong = (*signals, *findings(found, known))
    codes: dict[str, list[str]] = {}
    for item in wrong:
        codes.setdefault(item.code, []).append(item.where)
    current = max((a.level.value for a in actuators.joints), key=LADDER.index, default="ideal_pd")
    if actuators.delta_action is not None:
        current = "delta_action"
    level = choose_level(current, answers, codes)
    good: bool | None = None
    if found and not signals:
        good = False if wrong else True if all(enough(one) for one in found) else None
    steps = advise(spec, [log.path for log in logs], actuators.joints, found, codes, level, answers)
    notes = tuple(item for item in out.sorted())
    return Diagnosis(tuple(found), tuple(skipped), wrong, notes, steps, level, good, kept)


def _signals(actuators: ActuatorSet, logs: Sequence[Log], out: Collector) -> tuple[Diagnostic, ...]:
    """What a fit would be told of signs, units, exchanged columns and angles."""
    try:
        import scipy.signal  # noqa: F401
    except ImportError:
        message = (
            "signs and units of the logs' columns are not checked: that needs scipy, which is not installed"
        )
        out.info("DGN016", message, help=extra_line("sysid"))
        return ()
    seen = Collector()
    kinds = {actuator.joint: actuator.kind for actuator in actuators.joints}
    names = [
        name
        for name, kind in kinds.items()
        if all(log.joints[name].unlike(kind) is None for log in logs if name in log.joints)
    ]
    for log in logs:
        recorded(actuators, [log], [name for name in names if name in log.joints], seen)
    return tuple(
        item
        for item in seen.sorted()
        if item.code in CONTRADICTIONS
        and (item.severity is Severity.ERROR or _mostly_outside(actuators.joint(item.where), logs))
    )


def _mostly_outside(actuator: JointActuator | None, logs: Sequence[Log]) -> bool:
    """Whether a joint is beyond its range for most of a log: one that has no stops passes them for a moment."""
    import numpy as np

    if actuator is None or actuator.position_range is None:
        return False
    low, high = actuator.position_range
    columns = (log.joints[actuator.joint].position for log in logs if actuator.joint in log.joints)
    read = (column[np.isfinite(column)] for column in columns if column is not None)
    return any(len(rows) > 0 and not low <= float(np.median(rows)) <= high for rows in read)


def _networks(actuators: ActuatorSet, out: Collector) -> dict[str, Sampled]:
    """The networks of the joints that have one, by joint; a note says which are not known."""
    step = actuators.physics_dt.value
    mine = tuple(actuator for actuator in actuators.joints if actuator.level is Level.ACTUATOR_NET)
    if step is None or not mine:
        return {}
    laws = laws_of(replace(actuators, joints=mine))
    for group, (reason, help) in laws.skipped.items():
        out.info("DGN013", f"the network is not judged: {reason}", where=group, help=help)
    return {joint: Sampled(drive, step) for joint, drive in laws.networks.items()}


def _foreign(logs: Sequence[Log], known: Container[str]) -> list[str]:
    """Joints of logs that the spec does not have."""
    return [name for name in dict.fromkeys(name for log in logs for name in log.joints) if name not in known]


def _tracks(
    joint: str, logs: Sequence[Log], actuators: ActuatorSet, out: Collector
) -> tuple[list[Track], list[str]]:
    """A joint's part of each log that has it, and why others say nothing."""
    tracks, reasons = [], []
    actuator = actuators.joint(joint)
    assert actuator is not None
    for log in logs:
        if joint in log.joints:
            found = track_of(log, log.joints[joint], actuator, out)
            if isinstance(found, str):
                reasons.append(found)
            else:
                tracks.append(found)
    return tracks, reasons
