"""Joints that several groups of an Isaac Lab configuration have: the last group has the joint.

Source: Isaac Lab 2.2.0 and 2.3.2, articulation.py, `_process_actuators_cfg`, run by tests/frameworks: each group in
its order makes an actuator, writes gains, limits and passive figures of its joints to the solver, and keeps them as the
defaults, which the next group takes for what it does not state. `_apply_actuator_model` goes through them in the same
order, so that the last one's torque stays. 3.0 raises an error, and so does mjlab (1.6.0, measured): there no group has
the joint.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from actspec.diagnostics import Span, one_line
from actspec.readings.artifact import Framework
from actspec.readings.dict_keys import Found
from actspec.readings.ledger import LedgerRow
from actspec.readings.versions import Versions, is_native, limited_by_solver
from actspec.simulators.isaaclab import CLIPPING_AT_SOLVERS

_DEFAULTS = (
    "kp",
    "kd",
    "armature",
    "joint_damping",
    "friction_setting",
    "dynamic_friction_setting",
    "velocity_limit",
)
"""Figures of a group that are the next one's defaults, whatever their classes; friction as it is written."""


def has_last(framework: Framework, versions: Versions) -> bool:
    """Whether the last of several groups has a joint, and no error is raised."""
    return framework is Framework.ISAACLAB and not is_native(versions)


def left_by(name: str, span: Span, control: str, figures: Mapping[str, Found]) -> dict[str, Found]:
    """What a group leaves behind it of a joint: the defaults, and the solver's own limits.

    Args:
        name: Of the group.
        span: Where it is.
        control: What its class is.
        figures: Its own of the joint, with what it took itself; `velocity_limit` is the solver's.
    """
    left = {one: figures[one] for one in _DEFAULTS if one in figures}
    effort = figures.get("effort_limit" if control == "implicit" else "solver_effort_limit")
    if effort is not None:
        left["effort_limit"] = replace(effort, why=effort.why and f"{effort.why} (group {one_line(name)})")
    elif control != "implicit":
        # An explicit one clips for itself, and puts the solver's limit out of the way.
        why = f"no limit: group {one_line(name)} before it, which is explicit, leaves the solver 1e9"
        left["effort_limit"] = Found(None, span, False, why)
    return left


def taken_by(control: str, left: Mapping[str, Found], versions: Versions) -> dict[str, Found]:
    """What a group takes of that where it states nothing.

    Args:
        control: What its class is.
        left: By the group before it.
        versions: Whether an explicit class takes the solver's limit for its own.
    """
    taken = {one: found for one, found in left.items() if one != "effort_limit"}
    effort, at_solvers = left.get("effort_limit"), control != "implicit" and limited_by_solver(versions)
    if effort is None or at_solvers:
        return taken
    if at_solvers is None and effort.value is not None:
        why = f"{CLIPPING_AT_SOLVERS} do not clip then, others at the limit of the group before"
        effort = Found(None, effort.span, False, why)
    return {**taken, "effort_limit": effort}


def last_of_each(rows: Sequence[LedgerRow]) -> list[LedgerRow]:
    """The last row of each joint, which has the others as `overruled`; rows without a joint stay as they are.

    Args:
        rows: Of one configuration, in its groups' order.
    """
    joints: dict[tuple[str, object], list[LedgerRow]] = {}
    for place, row in enumerate(rows):
        joints.setdefault((row.joint, None if row.joint else place), []).append(row)
    return [
        replace(last, overruled=tuple(earlier)) if earlier else last for *earlier, last in joints.values()
    ]
