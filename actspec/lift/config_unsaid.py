"""Joints of a configuration that a spec cannot describe, with the reason."""

from __future__ import annotations

from collections.abc import Sequence

from actspec.diagnostics import one_line
from actspec.readings.artifact import ActuatorGroup, Framework, RobotConfig
from actspec.readings.config_figures import control_of_group
from actspec.robot.view import JointView

DRIVES = ("implicit", "ideal_pd", "dc_motor", "network", "position", "velocity", "motor", "pid")
"""Controls of the ledger for which the law has words."""


def unsaid(
    config: RobotConfig, chosen: Sequence[tuple[ActuatorGroup, str]], view: JointView | None
) -> str | None:
    """Why a joint cannot be described; None when it can.

    Args:
        config: The configuration.
        chosen: Its groups that select the joint, each with the pattern.
        view: The joint in the robot's file; None: not at hand.
    """
    if view is not None and view.mimic is not None:
        return f"follows '{one_line(view.mimic)}' (mimic)"
    if not chosen:
        return "no group of the configuration selects it"
    if len(chosen) > 1 and config.framework is not Framework.ISAACLAB:
        return f"{len(chosen)} groups select it: {', '.join(one_line(group.name) for group, _ in chosen)}"
    group = chosen[-1][0]
    cls = one_line(group.cls)
    control = control_of(config.framework, group)
    if config.framework is Framework.LEGGED_GYM and control == "velocity":
        return "control_type V: its gains act on speeds and accelerations"
    if config.framework is Framework.MJLAB and "xml" in group.cls.lower():
        return f"{cls} leaves it to the model's own actuator"
    if control == "dcmotor":
        return f"the gains of {cls} are in volts"
    if control not in DRIVES:
        return f"an actuator of another kind ({cls})"
    return None


def control_of(framework: Framework, group: ActuatorGroup) -> str:
    """What a group's class is in the ledger's words; legged_gym's default is a position drive."""
    if framework is Framework.LEGGED_GYM and not group.cls:
        return "ideal_pd"
    return control_of_group(framework, group)
