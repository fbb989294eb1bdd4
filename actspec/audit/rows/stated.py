"""Which fields of a row a robot file states itself, and with what."""

from __future__ import annotations

from functools import lru_cache

_STATED_BY = {
    "kp": ("kp", "biasprm", "controller"),
    "kd": ("kv", "dampratio", "biasprm", "controller"),
    "actuator_damping": ("damping",),
    "armature": ("armature",),
    "delay": ("delay",),
    "command_range": ("ctrlrange", "inheritrange", "posrange"),
    "effort_limit": ("forcerange", "forcelimited", "saturation"),
}
"""Field of a row to the attributes of an actuator that state it."""

_OF_JOINT = {
    "joint_damping": "damping",
    "armature": "armature",
    "frictionloss": "frictionloss",
    "effort_limit": "effort",
    "velocity_limit": "velocity",
    "position_range": "range",
}
"""Field of a row to the name in `JointView.stated`."""


@lru_cache(maxsize=256)
def said_of_joint(stated: frozenset[str]) -> tuple[tuple[str, str], ...]:
    """Fields of a row that a joint states, each with its name in `JointView.stated`."""
    return tuple((field, name) for field, name in _OF_JOINT.items() if name in stated)


@lru_cache(maxsize=256)
def said_of_actuator(stated: frozenset[str], torque: bool) -> tuple[tuple[str, str], ...]:
    """Fields of a row that an actuator states, each with the attribute that does.

    Args:
        stated: Its attributes.
        torque: Whether its control range is one of the torque.
    """
    found = []
    for field, names in _STATED_BY.items():
        last = ("ctrlrange",) if field == "effort_limit" and torque else ()
        said = next((name for name in (*names, *last) if name in stated), None)
        if said is not None:
            found.append((field, said))
    return tuple(found)
