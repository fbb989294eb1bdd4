"""A diagnosis as text and as JSON."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

from actspec.diagnostics import Diagnostic, listed, many, one_line
from actspec.report.tables import percent, table
from actspec.report.terminal import diagnostic_record
from actspec.study.advice import Advice
from actspec.study.diagnose import Diagnosis
from actspec.study.measures import JointMeasures
from actspec.units import format_number

FORMAT = "actspec-diagnosis/1"


def record(found: Diagnosis) -> dict[str, Any]:
    """As JSON; SI units, null is unknown."""
    return {
        "format": FORMAT,
        "joints": [_joint(one) for one in found.joints],
        "skipped": [asdict(one) for one in found.skipped],
        "findings": [diagnostic_record(item) for item in found.findings],
        "advice": [_advice(one) for one in found.advice],
        "level": {
            "current": found.level.current,
            "recommended": found.level.recommended,
            "why": list(found.level.why),
        },
        "enough": found.enough,
        "notes": [diagnostic_record(item) for item in found.notes],
    }


def _joint(one: JointMeasures) -> dict[str, Any]:
    values = asdict(one)
    for key in ("torque_error", "position_error"):
        values[key] = {name: {"rmse": value} for name, value in values[key].items()}
    return values


def _advice(one: Advice) -> dict[str, Any]:
    return {
        "action": one.action,
        "joints": list(one.joints),
        "why": one.why,
        "origin": one.origin,
        "days": list(one.days),
        "expected": {
            "low": one.low,
            "high": one.high,
            "origin": "measured" if one.measured else "reported",
            "source": one.source,
        },
        "commands": list(one.commands),
    }


def lines(found: Diagnosis) -> Iterator[str]:
    """The verdict, a row a joint, what to do."""
    yield verdict(found)
    if found.joints:
        yield ""
        yield from table([_HEAD, *(_row(one) for one in found.joints)])
        for words, errors in (
            ("torque of each level's law", {one.joint: one.torque_error for one in found.joints}),
            (
                "position under each level's law, 1 s from a logged state",
                {one.joint: one.position_error for one in found.joints},
            ),
        ):
            laws = dict.fromkeys(name for of in errors.values() for name in of)
            if laws:
                yield ""
                yield f"{words} against the logged one, RMSE:"
                rows = [["joint", *laws]]
                rows += [
                    [one_line(joint), *(_number(of.get(law)) for law in laws)] for joint, of in errors.items()
                ]
                yield from table(rows)
        if any(one.gap is not None for one in found.joints):
            yield ""
            yield "to the other log:"
            yield from table([["joint", "position", "velocity", "torque", "lag"], *_gaps(found)])
    if found.advice:
        yield ""
        yield "what to do, the cheapest first:"
        for number, one in enumerate(found.advice, 1):
            yield f"  {number}. {one.action}: {one_line(one.why)} ({listed(list(one.joints), 3)})"
            yield f"     {days_of(one)}; {gain_of(one)}"
            yield from (f"     {one_line(command)}" for command in one.commands)
    yield ""
    current = (
        "" if found.level.recommended == found.level.current else f" (the spec has {found.level.current})"
    )
    yield f"level: {found.level.recommended}{current}"
    yield from (f"  {one_line(reason)}" for reason in found.level.why)
    if found.skipped:
        reasons: dict[str, list[str]] = {}
        for item in found.skipped:
            reasons.setdefault(item.reason, []).append(item.joint)
        yield ""
        yield from (f"not judged: {listed(joints, 4)}: {one_line(why)}" for why, joints in reasons.items())


_HEAD = [
    *("joint", "torque", "saturated", "at edge", "beyond", "RMS", "peak", "speed", "of continuous", "fast"),
    *("command band", "tracking"),
]


def verdict(found: Diagnosis, others: Sequence[Diagnostic] = ()) -> str:
    """Whether the model is good enough, in a sentence.

    Args:
        found: What the logs say.
        others: Findings of spec and simulation, which a page shows with those of the logs.
    """
    if found.contradicted:
        wrong = _counted((*found.findings, *others))
        return f"no verdict, as the logs' columns contradict each other or the model: {wrong}"
    if found.enough is False:
        return f"not good enough: {_counted((*found.findings, *others))}"
    besides = f"; {_counted(others)}" if others else ""
    return f"{_by_logs(found)}{besides}"


def _counted(findings: Sequence[Diagnostic]) -> str:
    """How many findings, and on what."""
    where = list(dict.fromkeys(item.where for item in findings if item.where))
    return many(len(findings), "finding") + (f" on {listed(where, 4)}" if where else "")


def _by_logs(found: Diagnosis) -> str:
    if not found.joints:
        return "no log was judged: what follows is from the spec and the options"
    count = many(len(found.joints), "joint")
    if found.enough:
        unknown = sorted(
            {
                name
                for one in found.joints
                for name in ("saturated", "beyond", "continuous_ratio")
                if getattr(one, name) is None
            }
        )
        rest = f" (not known: {listed(unknown)})" if unknown else ""
        return f"good enough on {count}: no drive is near its bounds, and none is asked for more than it follows{rest}"
    return f"in between on {count}: no finding, and not below all bounds of good enough"


def _row(one: JointMeasures) -> list[str]:
    return [
        one_line(one.joint),
        f"{one.torque_from}",
        percent(one.saturated),
        percent(one.at_edge),
        percent(one.beyond),
        _number(one.rms_torque),
        _number(one.peak_torque),
        _number(one.peak_speed),
        _number(one.continuous_ratio),
        percent(one.high_frequency),
        "-" if one.command_band is None else f"{one.command_band:.3g} Hz",
        _number(one.tracking_rmse),
    ]


def _gaps(found: Diagnosis) -> Iterator[list[str]]:
    for one in found.joints:
        if one.gap is not None:
            lag = "-" if one.gap.lag is None else f"{one.gap.lag * 1e3:.3g} ms"
            figures = (one.gap.position_rmse, one.gap.velocity_rmse, one.gap.torque_rmse)
            yield [one_line(one.joint), *map(_number, figures), lag]


def days_of(one: Advice) -> str:
    """How much work a step is."""
    low, high = one.days
    if high == 0.0:
        return "at once"
    return f"{low:g} to {high:g} days" if low != high else f"{low:g} day{'s' * (low > 1)}"


def gain_of(one: Advice) -> str:
    """What a step is likely to gain, and who says so."""
    if one.low is None or one.high is None:
        return "nobody reports what it gains"
    shown = f"{one.low:.0%}" if one.low == one.high else f"{one.low:.0%} to {one.high:.0%}"
    if one.measured:
        return f"takes {shown} of the law's error away on these logs"
    return f"{shown} of the gap ({one.source})"


def _number(value: float | None) -> str:
    return "-" if value is None else format_number(value, 3)
