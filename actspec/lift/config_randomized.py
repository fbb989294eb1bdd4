"""The ranges of a configuration, joint by joint."""

from __future__ import annotations

from actspec.ir import Randomization
from actspec.readings.artifact import Framework, RandomizedRange, RobotConfig
from actspec.readings.pair import matching

FIELDS = {
    "kp": "kp",
    "kd": "kd",
    "armature": "armature",
    "friction": "friction.coulomb",
    "joint_damping": "friction.viscous",
    "effort_limit": "effort_limit",
    "strength": "strength",
    "encoder_bias": "encoder_bias",
}
"""Field of a range as the audit names it to the spec's name; others a spec does not have."""

WHEN = {"prestartup": "startup", "startup": "startup", "reset": "reset", "interval": "interval"}
"""Mode of an event to the spec's word; any other, and none, is a reset. Chosen: what most ranges are drawn at."""


def randomizations(config: RobotConfig, joint: str, named: tuple[str, ...]) -> tuple[Randomization, ...]:
    """The ranges of a joint that a spec has words for, in the author's order.

    Args:
        config: The configuration.
        joint: The joint.
        named: All joints of the robot.
    """
    return tuple(
        Randomization(
            FIELDS[one.field],
            one.operation,
            one.low,
            one.high,
            one.distribution,
            WHEN.get(one.when, "reset"),
            one.every,
            "joint",
            one.span,
        )
        for one in config.randomize
        if one.field in FIELDS and _concerns(config.framework, one, joint, named)
    )


def _concerns(framework: Framework, one: RandomizedRange, joint: str, named: tuple[str, ...]) -> bool:
    """Whether a range is for a joint; one by names of actuators is where mjlab gives them the joints' names."""
    patterns = one.joints if one.joints is not None else one.actuators
    if patterns is None:
        return True
    # mjlab and Isaac Lab match ranges as they match groups; legged_gym has no patterns here.
    style = Framework.MJLAB if framework is Framework.LEGGED_GYM else framework
    return joint in named and any(matching(style, pattern, (joint,)) for pattern in patterns)
