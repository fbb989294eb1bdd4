"""The comment at the top of a written model: what every number is and where it comes from."""

from __future__ import annotations

from collections.abc import Iterator

from actspec.ir import ActuatorSet, JointActuator, Quantity
from actspec.targets.base import Approximation
from actspec.targets.kit.provenance import loss_lines, source_lines, with_origin, xml_comment

LEFT_OUT = ("peak_torque", "continuous_torque", "reflected_inertia", "action_scale", "default_position")
"""Numbers that MuJoCo's drive and joint are not made of."""


def header(
    actuators: ActuatorSet, approximations: tuple[Approximation, ...], target: str, source: str, tool: str
) -> str:
    """The comment's text, one XML comment.

    Args:
        actuators: What was compiled.
        approximations: What the target lost.
        target: e.g. `MuJoCo 3.12`.
        source: File name of the robot's model.
        tool: e.g. `actspec 0.1.0`.
    """
    lines = [
        f"Written by {tool} for {target}. Do not edit: change the spec and compile again.",
        f"spec sha256 {actuators.spec_sha256}",
        f"model {source}",
        f"physics_dt {with_origin(actuators.physics_dt)}",
    ]
    for names, entries in _groups(actuators):
        lines += ["", names, *(f"  {entry}" for entry in entries)]
    if approximations:
        lines += ["", "Approximations (what this target cannot hold):"]
        lines += [f"  {line}" for line in loss_lines(approximations)]
    shown = [actuators.physics_dt, *(q for a in actuators.joints for _, q in _shown(a))]
    cited = list(source_lines(actuators, shown))
    if cited:
        lines += ["", "Sources:", *(f"  {line}" for line in cited)]
    return xml_comment(lines)


def _groups(actuators: ActuatorSet) -> Iterator[tuple[str, list[str]]]:
    """Joints with the same numbers together: (title, one line a number)."""
    merged: dict[tuple[str, ...], list[JointActuator]] = {}
    for actuator in actuators.joints:
        merged.setdefault((actuator.group, *_entries(actuator)), []).append(actuator)
    for key, members in merged.items():
        group, lines = key[0], list(key[1:])
        first = members[0]
        title = f"{group} ({first.level.value}, {first.command.value}): {', '.join(m.joint for m in members)}"
        yield title, lines


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
