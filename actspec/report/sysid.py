"""A fit as text and as JSON."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from actspec.diagnostics import many, one_line
from actspec.fields import units_of
from actspec.report.tables import table
from actspec.report.terminal import json_number
from actspec.sysid.identified import Identification, JointFit, Parameter, State
from actspec.units import format_number

FORMAT = "actspec-sysid/1"
_WORDS = {State.HELD: "held", State.UNIDENTIFIABLE: "not told by the logs", State.AT_BOUND: "at its bound"}


def sysid_lines(found: Identification) -> Iterator[str]:
    """A table a joint: what was identified, what was held, and what the logs do not tell."""
    for joint in found.joints:
        unit = units_of(joint.kind).position
        held_out = (
            "" if joint.held_out_rmse is None else f", {format_number(joint.held_out_rmse, 3)} held out"
        )
        if joint.position_rmse is None or joint.misfit is None:
            yield f"{one_line(joint.joint)}: by {found.method}"
        else:
            yield (
                f"{one_line(joint.joint)}: position error {format_number(joint.position_rmse, 3)} {unit}{held_out}; "
                f"{format_number(joint.misfit, 3)} times the noise of the readings"
            )
        rows = [["field", "value", "std", "95 %", "unit", ""]]
        rows += [_row(parameter) for parameter in joint.parameters]
        rows += [
            [c.name, format_number(c.value, 5), format_number(c.std, 2), "", c.unit, "combination"]
            for c in joint.combinations
        ]
        rows += [
            [
                d.name,
                "-" if d.value is None else format_number(d.value, 5),
                "-" if d.std is None else format_number(d.std, 2),
                "",
                d.unit,
                d.why or "diagnostic",
            ]
            for d in joint.diagnostics
        ]
        yield from table(rows)
    fields = sum(p.state is State.IDENTIFIED for joint in found.joints for p in joint.parameters)
    yield f"{many(fields, 'figure')} of {many(len(found.joints), 'joint')}, {found.seconds:.1f} s"


def _row(parameter: Parameter) -> list[str]:
    interval = ""
    if parameter.low is not None and parameter.high is not None:
        interval = f"{format_number(parameter.low, 5)} to {format_number(parameter.high, 5)}"
    if parameter.state is State.IDENTIFIED:
        assert parameter.value is not None and parameter.std is not None
        return [
            parameter.field,
            format_number(parameter.value, 5),
            format_number(parameter.std, 2),
            interval,
            parameter.unit,
            parameter.why,
        ]
    value = "-" if parameter.value is None else format_number(parameter.value)
    why = f"{_WORDS[parameter.state]}: {parameter.why}" if parameter.why else _WORDS[parameter.state]
    return [parameter.field, value, "-", interval, parameter.unit, why]


def sysid_record(found: Identification, results: str | None) -> dict[str, Any]:
    """The fit as JSON; SI units, null is unknown.

    Args:
        found: The fit.
        results: Path of the results file; None: none was written.
    """
    units = {units_of(joint.kind).position for joint in found.joints}
    # Radians and metres have no largest.
    alike = found.joints if len(units) == 1 else ()
    return {
        "format": FORMAT,
        "results": results,
        "joints": [_joint(joint) for joint in found.joints],
        "findings": [
            {
                "code": item.code,
                "severity": item.severity.value,
                "joint": item.where or None,
                "message": item.message,
                "help": item.help,
            }
            for item in found.findings
        ],
        "fit": {
            "position_rmse": json_number(_most(joint.position_rmse for joint in alike)),
            "held_out_rmse": json_number(_most(joint.held_out_rmse for joint in alike)),
            "unit": units.pop() if len(units) == 1 else None,
            "misfit": json_number(_most(joint.misfit for joint in found.joints)),
            "condition": json_number(_most(joint.condition for joint in found.joints)),
            "seconds": found.seconds,
        },
    }


def _most(values: Iterable[float | None]) -> float | None:
    return max((value for value in values if value is not None), default=None)


def _joint(joint: JointFit) -> dict[str, Any]:
    return {
        "joint": joint.joint,
        "position_rmse": json_number(joint.position_rmse),
        "held_out_rmse": json_number(joint.held_out_rmse),
        "unit": units_of(joint.kind).position,
        "parameters": [
            {
                "field": p.field,
                "state": p.state.value,
                "value": json_number(p.value),
                "std": json_number(p.std),
                "low": json_number(p.low),
                "high": json_number(p.high),
                "unit": p.unit,
                "why": p.why or None,
            }
            for p in joint.parameters
        ],
        "combinations": [
            {"name": c.name, "value": json_number(c.value), "std": json_number(c.std), "unit": c.unit}
            for c in joint.combinations
        ],
        "diagnostics": [
            {"name": d.name, "value": json_number(d.value), "std": json_number(d.std), "unit": d.unit}
            for d in joint.diagnostics
        ],
    }
