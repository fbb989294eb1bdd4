"""The comment at the top of a written model: what every number is and where it comes from."""

from __future__ import annotations

from collections.abc import Iterator

from actspec.ir import ActuatorSet, JointActuator, Quantity
from actspec.simulators.mujoco import MujocoDialect
from actspec.targets.base import Approximation
from actspec.targets.kit.provenance import sections, with_origin, written_by, xml_head
from actspec.targets.kit.python_text import grouped

LEFT_OUT = ("peak_torque", "continuous_torque", "reflected_inertia", "action_scale", "default_position")
"""Numbers that MuJoCo's drive and joint are not made of."""


def header(
    actuators: ActuatorSet, approximations: tuple[Approximation, ...], dialect: MujocoDialect, source: str
) -> str:
    """The comment's text, one XML comment.

    Args:
        actuators: What was compiled.
        approximations: What the target lost.
        dialect: MuJoCo version that is written.
        source: File name of the robot's model.
    """
    head = [
        written_by(f" for MuJoCo {dialect.text}"),
        *actuators.spec_lines,
        f"model {source}",
        f"physics_dt {with_origin(actuators.physics_dt)}",
    ]
    joints = [
        (
            f"{group} ({members[0].level.value}, {members[0].command.value}): {', '.join(m.joint for m in members)}",
            lines,
        )
        for (group, *lines), members in grouped(actuators.joints, lambda a: (a.group, *_entries(a)))
    ]
    shown = [actuators.physics_dt, *(q for a in actuators.joints for _, q in _shown(a))]
    said = sections(actuators, approximations, "Approximations (what this target cannot hold):", shown)
    return xml_head(head, [*joints, *said])


def _shown(actuator: JointActuator) -> Iterator[tuple[str, Quantity]]:
    return ((name, quantity) for name, quantity in actuator.quantities() if name not in LEFT_OUT)


def _entries(actuator: JointActuator) -> Iterator[str]:
    delay = actuator.delay
    for name, quantity in _shown(actuator):
        reach = ""
        if name == "delay" and delay is not None and delay.low != delay.high:
            reach = f", range {delay.low * 1e3:g} to {delay.high * 1e3:g} ms"
        if not name.startswith("command_range"):
            yield f"{name} {with_origin(quantity)}{reach}"
    if actuator.command_range is not None:
        low, high = actuator.command_range
        yield f"command_range {with_origin(low)} to {with_origin(high)}"
