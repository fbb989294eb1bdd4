"""A fit as a results file, which a spec names under `identified`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from actspec.logs import Log
from actspec.owned import head_of
from actspec.spec.document import Document
from actspec.spec.results import FORMAT
from actspec.spec.variants import named
from actspec.sysid.identified import Identification, Indicator, JointFit, Parameter, State

HEAD = f"{head_of('sysid fit')} A spec takes it by `identified: THIS FILE` in a group.\n"
DIGITS = 6
"""Significant digits. Chosen: an interval is never known to a thousandth of itself."""


def results_text(found: Identification, logs: Sequence[Log], spec: Document | None = None) -> str:
    """The results file's YAML.

    Args:
        found: The fit.
        logs: That it used.
        spec: That it began with.
    """
    import yaml

    sidecars = [log.sidecar for log in logs]
    data: dict[str, Any] = {"format": FORMAT, "robot": found.robot, "method": found.method}
    for key in ("date", "temperature"):
        stated = {getattr(sidecar, key) for sidecar in sidecars}
        if len(stated) == 1 and None not in stated:
            data[key] = stated.pop()
    if spec is not None:
        data["spec"] = {"path": named(spec.path, spec.variant), "sha256": spec.text_sha256}
    data["data"] = [{"path": log.path, "sha256": log.sha256} for log in logs]
    held_out = [joint.held_out_rmse for joint in found.joints if joint.held_out_rmse is not None]
    if held_out and len({joint.kind for joint in found.joints}) == 1:
        unit = next(p.unit for p in found.joints[0].parameters if p.field == "encoder_bias")
        data["held_out_rmse"] = {"value": _short(max(held_out)), "unit": unit}
    conditions = [joint.condition for joint in found.joints if joint.condition is not None]
    if conditions:
        data["condition"] = _short(max(conditions))
    data["joints"] = {joint.joint: _joint(joint) for joint in found.joints}
    text: str = yaml.safe_dump(data, sort_keys=False, default_flow_style=None, width=110, allow_unicode=True)
    return HEAD + text


def _joint(joint: JointFit) -> dict[str, Any]:
    data: dict[str, Any] = {}
    for parameter in joint.parameters:
        if parameter.state is State.IDENTIFIED:
            section, _, key = parameter.field.rpartition(".")
            (data.setdefault(section, {}) if section else data)[key] = _number(parameter)
    ends = {
        p.field: [_short(p.low), _short(p.high)]
        for p in joint.parameters
        if p.state is State.IDENTIFIED and p.low is not None and p.high is not None
    }
    if ends:
        data["intervals"] = ends
    held = {p.field: p for p in joint.parameters if p.state is State.HELD and p.field in ("kp", "kd")}
    if len(held) == 2:
        data["gains"] = {name: {"value": p.value, "unit": p.unit} for name, p in held.items()}
    for key, state in (("bounds_hit", State.AT_BOUND), ("unidentifiable", State.UNIDENTIFIABLE)):
        fields = [parameter.field for parameter in joint.parameters if parameter.state is state]
        if fields:
            data[key] = fields
    untold = (State.AT_BOUND, State.UNIDENTIFIABLE)
    reasons = {p.field: p.why for p in joint.parameters if p.state in untold and p.why}
    if reasons:
        data["reasons"] = reasons
    if joint.combinations:
        data["combinations"] = {
            c.name: {"value": _short(c.value), "std": _short(c.std), "unit": c.unit}
            for c in joint.combinations
        }
    if joint.diagnostics:
        told = {item.name: _indicator(item) for item in joint.diagnostics if item.value is not None}
        data |= {"diagnostics": told} if told else {}
    if joint.correlation:
        data["correlation"] = [[a, b, round(r, 3)] for a, b, r in joint.correlation]
    return data


def _indicator(item: Indicator) -> dict[str, Any]:
    assert item.value is not None
    std = {} if item.std is None else {"std": _short(item.std)}
    return {"value": _short(item.value), **std, "unit": item.unit}


def _number(parameter: Parameter) -> dict[str, Any]:
    assert parameter.value is not None and parameter.std is not None
    return {"value": _short(parameter.value), "unit": parameter.unit, "std": _short(parameter.std)}


def _short(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
