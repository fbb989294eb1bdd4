"""ORD: orders of joints, in which commands and measurements are laid out."""

from __future__ import annotations

from collections.abc import Sequence

from actspec.ir import JointKind
from actspec.readings.artifact import Artifact, Setting
from actspec.robot.view import ActuatorView, RobotView

SCALAR = (JointKind.HINGE, JointKind.SLIDE)


def first_drives(robot: RobotView) -> tuple[ActuatorView, ...]:
    """The first actuator of each joint that has one, in the actuators' order."""
    scalar = {joint.name for joint in robot.joints if joint.kind in SCALAR}
    found: dict[str, ActuatorView] = {}
    for actuator in robot.actuators:
        if actuator.transmission in ("joint", "jointinparent") and actuator.target in scalar:
            found.setdefault(actuator.target, actuator)
    return tuple(found.values())


def scalar_joints(robot: RobotView) -> tuple[str, ...]:
    return tuple(joint.name for joint in robot.joints if joint.kind in SCALAR)


def stated_order(artifact: Artifact) -> tuple[tuple[str, ...], Setting] | None:
    """An order of joints that a file states, and where."""
    setting = artifact.config.settings.get("joint_order") if artifact.config is not None else None
    if setting is None or not isinstance(setting.value, tuple) or len(setting.value) < 2:
        return None
    return tuple(str(name) for name in setting.value), setting


def kept_names(order: Sequence[str], names: Sequence[str]) -> tuple[str, ...]:
    """The names of one order that another has too."""
    kept = set(names)
    return tuple(name for name in order if name in kept)


def differing_places(one: Sequence[str], other: Sequence[str]) -> list[int]:
    """Places at which two orders of the same names differ."""
    return [place for place, (a, b) in enumerate(zip(one, other, strict=True)) if a != b]
