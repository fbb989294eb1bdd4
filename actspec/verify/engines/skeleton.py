"""A model with a robot's joints and nothing else, for an engine whose actuators ask for no more.

It needs no meshes, and every release reads it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from xml.sax.saxutils import quoteattr

from actspec.ir import ActuatorSet, JointKind
from actspec.robot.view import JointView, RobotView


def skeleton(robot: RobotView, actuators: ActuatorSet, inertia: Mapping[str, float] | None = None) -> str:
    """MJCF text of the robot's hinges and slides, each on a body of its own, with what the file has of them.

    Args:
        robot: The robot; where nobody names a model, it lists the joints.
        actuators: What the spec asks for; a joint of it has a motor, as in the author's model.
        inertia: Of the bodies, where it matters [kg*m^2 or kg]: a ball at the joint.
    """
    joints = [joint for joint in robot.joints if joint.kind in (JointKind.HINGE, JointKind.SLIDE)]
    driven = {a.target for a in robot.actuators} & {a.joint for a in actuators.joints}
    lines = ["<mujoco>", '  <compiler angle="radian"/>', "  <worldbody>"]
    for index, joint in enumerate(joints):
        lines += [f'    <body pos="{3 * index} 0 0">', f"      <joint {_attributes(joint)}/>"]
        if inertia is not None and joint.name in inertia:
            lines.append(f"      {_ball(joint, inertia[joint.name])}")
        lines += ['      <geom size="0.1" contype="0" conaffinity="0"/>', "    </body>"]
    lines += ["  </worldbody>", "  <actuator>"]
    for joint in joints:
        if joint.name in driven:
            lines.append(f"    <motor joint={quoteattr(joint.name)}/>")
    return "\n".join([*lines, "  </actuator>", "</mujoco>"])


def _ball(joint: JointView, inertia: float) -> str:
    mass, about = (1.0, inertia) if joint.kind is JointKind.HINGE else (inertia, 1.0)
    return f'<inertial pos="0 0 0" mass="{mass!r}" diaginertia="{about!r} {about!r} {about!r}"/>'


def _attributes(joint: JointView) -> str:
    return " ".join(f"{name}={value}" for name, value in _pairs(joint))


def _pairs(joint: JointView) -> Iterator[tuple[str, str]]:
    yield "name", quoteattr(joint.name)
    yield "type", f'"{joint.kind.value}"'
    for name, value in (
        ("damping", joint.damping),
        ("armature", joint.armature),
        ("frictionloss", joint.frictionloss),
    ):
        yield name, f'"{value!r}"'
    if joint.range is not None:
        yield "range", f'"{joint.range[0]!r} {joint.range[1]!r}"'
    if joint.effort_range is not None:
        yield "actuatorfrcrange", f'"{joint.effort_range[0]!r} {joint.effort_range[1]!r}"'
