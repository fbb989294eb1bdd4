"""Joints that several groups of an Isaac Lab configuration have: the last group has the joint.

Source: Isaac Lab 2.2.0 and 2.3.2, articulation.py, `_process_actuators_cfg`: each group in its order makes an actuator,
writes gains, limits and passive figures of its joints to the solver, and keeps them as the defaults, which the next
group takes for what it does not state. `_apply_actuator_model` goes through them in the same order, so that the last
one's torque stays. 3.0 raises an error, and so does mjlab (1.6.0, measured): there no group has the joint.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from actspec.readings.artifact import Framework
from actspec.readings.ledger import LedgerRow
from actspec.readings.versions import Versions, is_native

_T = TypeVar("_T")

_DEFAULTS = frozenset(
    {
        "kp",
        "kd",
        "armature",
        "joint_damping",
        "frictionloss",
        "friction_static",
        "friction_setting",
        "dynamic_friction_setting",
    }
)
"""Figures of a group that are the next one's defaults."""

_OF_SOLVER = frozenset({"effort_limit", "velocity_limit"})
"""Likewise where the group is implicit, whose limits are the solver's: an explicit one writes 1e9 there."""


def has_last(framework: Framework, versions: Versions) -> bool:
    """Whether the last of several groups has a joint, and no error is raised."""
    return framework is Framework.ISAACLAB and not is_native(versions)


def laid_over(members: Sequence[tuple[str, str, Mapping[str, _T]]]) -> list[dict[str, _T]]:
    """What each group states of a joint, over what earlier groups left as its defaults.

    Args:
        members: Control of the group, joint, and field to figure, in the groups' order.
    """
    defaults: dict[str, dict[str, _T]] = {}
    found = []
    for control, joint, figures in members:
        whole = defaults.get(joint, {}) | dict(figures)
        stays = _DEFAULTS | (_OF_SOLVER if control == "implicit" else frozenset())
        defaults[joint] = {name: figure for name, figure in whole.items() if name in stays}
        found.append(whole)
    return found


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
