"""A robot without a model: what its author's MJCF is to include.

The fragment has one default class for each distinct set of a joint's numbers, to be put on the author's
joints, and one actuator for each joint that the spec manages. What the including model's main default
class holds is not known here, so every number that it could pass on is written out. Beside the fragment
stands a bench: a model with the listed joints, each on a body of its own, that includes it. It is what
the fragment is checked with, and an example of the including.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from actspec.diagnostics import Collector, EmitError, listed
from actspec.ir import ActuatorSet, Origin
from actspec.robot.view import JointView, ModelFile, RobotView
from actspec.robot.xml_edit import escape_attribute, exact_number
from actspec.simulators.mujoco import MujocoDialect
from actspec.targets.base import Approximation
from actspec.targets.kit.provenance import written_by, xml_comment
from actspec.targets.kit.python_text import free_name, grouped, identifier
from actspec.targets.mujoco.actuator_xml import actuator_xml
from actspec.targets.mujoco.apply_text import header, joint_attributes
from actspec.targets.mujoco.drive import Form
from actspec.targets.mujoco.plan import JointEdit, Plan

PREFIX = "actspec_"
"""Before the robot's name in the names of classes: two robots' fragments fit into one scene."""

OWN = ("armature", "damping", "frictionloss", "actuatorfrcrange", "springdamper")
"""Attributes with which a joint itself would override its class."""

RADIUS = 0.1
"""Of the bench's spheres [m], which stand 1 m apart. Chosen: any; only joints and actuators are compared."""


@dataclass(frozen=True, slots=True)
class DefaultClass:
    """A default class and the joints that it is for."""

    name: str
    edit: JointEdit
    joints: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Fragment:
    """What is written for a robot without a model.

    Attributes:
        plan: Every number, for joints whose own are not known.
        classes: Joints with the same numbers, in the robot's order.
        actuators: What the spec asks for.
        approximations: What the target loses of it.
    """

    plan: Plan
    classes: tuple[DefaultClass, ...]
    actuators: ActuatorSet
    approximations: tuple[Approximation, ...]

    @property
    def main_name(self) -> str:
        """Name of the fragment's file."""
        return f"{identifier(self.actuators.robot).lower()}_actuators.xml"


def fragment_of(
    plan: Plan, approximations: tuple[Approximation, ...], actuators: ActuatorSet, collector: Collector
) -> Fragment:
    """Make a fragment of the plan for a robot without a model.

    Args:
        plan: Of `plan_model`; of its drives.
        approximations: What it loses.
        actuators: What the spec asks for.
        collector: Takes what a fragment cannot hold.

    Raises: EmitError: a drive depends on the including model.
    """
    unlimited = [d.joint for d in plan.drives if d.form is Form.DCMOTOR and d.effort_limit is None]
    if unlimited:
        collector.at("robot.model").error(
            "MJC019",
            "a dcmotor without effort_limit takes the force range of the including model's main default class, "
            f"which is not known here: {listed(unlimited)}",
            "state effort_limit, or name the model",
        )
    collector.raise_if_failed(EmitError)
    edits = tuple(
        JointEdit(
            joint=actuator.joint,
            damping=None if (viscous := actuator.friction_viscous.value) is None else (viscous, 0.0, 0.0),
            armature=actuator.armature.value,
            frictionloss=actuator.friction_coulomb.value,
            effort=actuator.effort_limit.value,
        )
        for actuator in actuators.joints
    )
    stated = actuators.physics_dt.origin is not Origin.DEFAULT
    plan = replace(
        plan,
        joints=tuple(edit for edit in edits if not edit.empty),
        timestep=actuators.physics_dt.require() if stated else None,
    )
    return Fragment(plan, _classes(plan, actuators), actuators, approximations)


def _classes(plan: Plan, actuators: ActuatorSet) -> tuple[DefaultClass, ...]:
    """One class for each distinct set of numbers, named after the group that has it first.

    24 N*m at a hinge and 24 N at a slide are two sets.
    """
    by_name = {actuator.joint: actuator for actuator in actuators.joints}
    found: dict[str, DefaultClass] = {}
    for (edit, _), members in grouped(
        plan.joints, lambda edit: (replace(edit, joint=""), by_name[edit.joint].kind)
    ):
        joints = tuple(member.joint for member in members)
        group = identifier(by_name[joints[0]].group, fallback="group")
        name = free_name(f"{PREFIX}{identifier(actuators.robot)}_{group}", found)
        found[name] = DefaultClass(name, edit, joints)
    return tuple(found.values())


def fragment_files(
    fragment: Fragment, robot: RobotView, dialect: MujocoDialect, folder: str
) -> tuple[ModelFile, ...]:
    """The bench and the fragment that it includes, in the words of a version.

    Args:
        fragment: What to write.
        robot: The listed joints.
        dialect: MuJoCo version.
        folder: Output folder.

    Raises: ValueError: XML cannot hold a joint's name.
    """
    name = fragment.main_name
    classes = {joint: item.name for item in fragment.classes for joint in item.joints}
    remark = xml_comment(
        [
            written_by(f" for MuJoCo {dialect.text}"),
            f"Not the robot: each joint of {fragment.actuators.robot} on a sphere of its own, to try the drives of",
            f"{name}, and to show how it is included.",
        ]
    )
    bench = f"{remark}\n{bench_xml(robot, classes, include=name)}"
    text = _fragment_xml(fragment, dialect)
    return (
        ModelFile(os.path.join(folder, name.replace("_actuators.xml", "_bench.xml")), "", bench.encode()),
        ModelFile(os.path.join(folder, name), name, text.encode()),
    )


def bench_xml(robot: RobotView, classes: Mapping[str, str], *, include: str | None = None) -> str:
    """A model with the listed joints and nothing else, without gravity.

    Args:
        robot: The listed joints.
        classes: Joint to its default class.
        include: File to include, last.

    Raises: ValueError: XML cannot hold a joint's name.
    """
    lines = ["<mujoco>", '  <compiler angle="radian"/>', '  <option gravity="0 0 0"/>', "  <worldbody>"]
    for index, joint in enumerate(robot.joints):
        lines += [
            f'    <body pos="{index} 0 0">',
            f"      {_bench_joint(joint, classes.get(joint.name))}",
            f'      <geom size="{exact_number(RADIUS)}" contype="0" conaffinity="0"/>',
            "    </body>",
        ]
    lines.append("  </worldbody>")
    if include is not None:
        lines.append(f"  {_tag('include', [('file', include)])}")
    return "\n".join([*lines, "</mujoco>", ""])


def _bench_joint(joint: JointView, name: str | None) -> str:
    attributes = [("name", joint.name), ("type", joint.kind.value)]
    if name is not None:
        attributes.append(("class", name))
    if joint.range is not None:
        attributes.append(("range", " ".join(map(exact_number, joint.range))))
    return _tag("joint", attributes)


def _tag(name: str, attributes: Sequence[tuple[str, str]]) -> str:
    return f"<{name}" + "".join(f' {key}="{escape_attribute(value)}"' for key, value in attributes) + "/>"


def _fragment_xml(fragment: Fragment, dialect: MujocoDialect) -> str:
    source = "none (the spec lists the joints)"
    lines = [
        header(fragment.actuators, fragment.approximations, dialect, source),
        xml_comment(_instructions(fragment)),
        "<mujoco>",
    ]
    if fragment.plan.timestep is not None:
        lines.append(f"  {_tag('option', [('timestep', exact_number(fragment.plan.timestep))])}")
    # Coefficients that are not written would come from the including model's main class.
    damping = 3 if dialect.polynomials else 1
    if fragment.classes:
        lines.append("  <default>")
        for item in fragment.classes:
            lines += [
                f'    <default class="{item.name}">',
                f"      {_tag('joint', list(joint_attributes(item.edit, damping)))}",
                "    </default>",
            ]
        lines.append("  </default>")
    lines.append("  <actuator>")
    lines += [f"    {actuator_xml(drive, dialect, explicit=True)}" for drive in fragment.plan.drives]
    return "\n".join([*lines, "  </actuator>", "</mujoco>", ""])


def _instructions(fragment: Fragment) -> Iterator[str]:
    """What to do to the including model, step by step."""
    plan, dt = fragment.plan, fragment.actuators.physics_dt.require()
    yield "How to use it:"
    yield f'1. Write <include file="{fragment.main_name}"/> as the last element of the model\'s <mujoco>.'
    if fragment.classes:
        yield "2. Give each joint its class:"
        for item in fragment.classes:
            yield f'     class="{item.name}": {", ".join(item.joints)}'
        yield f"   and remove {', '.join(OWN)} from the joint's own element, where they"
        yield "   would win. Write there what a class or childclass gave the joint before (axis, range, ...)."
    yield "3. Remove other actuators of these joints: the actuators here are named like their joints."
    if plan.timestep is not None:
        yield f"4. This file sets option/timestep to {dt:g} s (timing.physics_dt); only an <option> behind the"
        yield "   include would override it."
    else:
        yield f"4. The spec states no timing.physics_dt: option/timestep stays the model's, taken for {dt:g} s here."
    if any(drive.delay_steps for drive in plan.drives):
        yield f"   Delays are whole steps of {dt:g} s: at another timestep they are not what is stated here."
    clamped = [d.joint for d in plan.drives if d.control_limited and d.form is not Form.DCMOTOR]
    if clamped:
        yield "   The main default class of the model must not hold inheritrange, which would override the"
        yield f"   control range of: {', '.join(clamped)}"
    yield from _reset_recipe(fragment)


def _reset_recipe(fragment: Fragment) -> Iterator[str]:
    filtered = [drive for drive in fragment.plan.drives if drive.time_constant]
    delayed = [drive for drive in fragment.plan.drives if drive.delay_steps]
    if not filtered and not delayed:
        return
    yield "5. A bare reset starts filters and delay lines at 0, and the robot jumps. Reset with"
    yield "     actspec.runtime.reset(model, data, keyframe)"
    yield "   or by hand, with i the actuator's index and u the position of its joint (0 for a velocity or a torque):"
    yield "     data.ctrl[i] = u"
    if filtered:
        yield f"     data.act[model.actuator_actadr[i]] = u    at {', '.join(d.joint for d in filtered)}"
    for steps, members in grouped(delayed, lambda drive: drive.delay_steps):
        joints = [drive.joint for drive in members]
        yield f"     mujoco.mj_initCtrlHistory(model, data, i, None, numpy.full({steps}, u))    at {', '.join(joints)}"
