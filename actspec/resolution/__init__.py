"""Resolve: a spec and a robot become an ActuatorSet, all units, patterns and defaults gone."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, ResolveError, listed
from actspec.ir import (
    ActuatorSet,
    DeltaAction,
    JointActuator,
    JointKind,
    Origin,
    Quantity,
    Source,
    whole_steps,
)
from actspec.readings.joint import read_joints
from actspec.resolution.binding import bind
from actspec.resolution.identified import check_gains, drawn_apart, results_sources
from actspec.resolution.joint import actuator_of, armature_of
from actspec.resolution.motor import own_motors
from actspec.resolution.quantities import Reports, model_values, written
from actspec.resolution.simplified import simplifications
from actspec.resolution.stated import joint_inputs, stated_of
from actspec.robot.view import RobotView
from actspec.spec.document import Breaches
from actspec.spec.fields import CONTROL_PERIOD
from actspec.spec.plausible.joints import check_joints, forget_unfit
from actspec.spec.validate import Spec
from actspec.spec.values import SpecValue
from actspec.units import format_quantity

if TYPE_CHECKING:
    from actspec.resolution.linkage import LinkedMotors

DEFAULT_TIMESTEP = 0.002
"""Step where neither spec nor model states one [s]. Source: MuJoCo's default of option/timestep."""


def resolve(spec: Spec, robot: RobotView) -> ActuatorSet:
    """Fit a spec to a robot.

    Raises:
        ResolveError: with every error of the stage.
    """
    collector = Collector()
    for item in (*spec.diagnostics, *robot.diagnostics):
        collector.add(item)
    breaches = Breaches(spec.document.spans, collector)
    bindings = bind(spec, robot, breaches)
    reports = Reports()
    kinds: dict[str, set[JointKind]] = {}
    for binding in bindings.managed:
        kinds.setdefault(binding.group, set()).add(binding.joint.kind)
    stated = [
        stated_of(spec, binding, len(kinds[binding.group]) > 1, breaches, reports)
        for binding in bindings.managed
    ]
    linkages: tuple[LinkedMotors, ...] = ()
    if spec.model.linkages:
        from actspec.resolution.linkage import linked_motors

        linkages = linked_motors(spec, stated, bindings, breaches)
    motors = {
        joint: linkage.at_joint(index, item.kind)
        for item in stated
        for linkage in linkages
        for index, joint in enumerate(linkage.joints)
        if joint == item.binding.joint.name
    }
    motors |= own_motors(spec, stated, breaches)
    readings = read_joints(robot)
    said = [
        joint_inputs(
            item,
            model_values(readings[item.binding.joint.name]),
            motors.get(item.binding.joint.name),
            breaches,
            reports,
            robot.uncompiled,
        )
        for item in stated
    ]
    reports.tell(collector)
    forget_unfit(spec.model, collector)
    collector.raise_if_failed(ResolveError)

    armatures = [armature_of(inputs) for inputs in said]
    dofs = {
        inputs.joint.dof: armature.value
        if armature.value is not None
        else (inputs.model.armature.value or 0.0 if inputs.model.armature is not None else 0.0)
        for inputs, armature in zip(said, armatures, strict=True)
        if inputs.joint.dof >= 0
    }
    held = robot.inertia.held(dofs) if robot.inertia is not None and dofs else {}
    free = robot.inertia.free(dofs) if robot.inertia is not None and dofs else {}
    folder = os.path.dirname(spec.document.path)
    joints = tuple(
        actuator_of(
            inputs,
            armature,
            held.get(inputs.joint.dof),
            free.get(inputs.joint.dof),
            bindings.default_pose.get(inputs.joint.name),
            lambda file: os.path.normpath(os.path.join(folder, file)),
        )
        for inputs, armature in zip(said, armatures, strict=True)
    )
    reports.tell(collector)
    for actuator in joints:
        _check_finite(actuator, collector)
    _check_delays(joints, collector)
    check_gains(zip(joints, stated, strict=True), collector)
    positions = ((joint.name, robot.keyframe_position(joint)) for joint in robot.scalar_joints)
    keyframe = {name: position for name, position in positions if position is not None}
    check_joints(joints, spec.model, spec.document, collector, robot.mass, keyframe)
    collector.raise_if_failed(ResolveError)
    model = spec.model
    delta = model.delta_action
    step, control = _physics_dt(spec, robot), model.timing.control_dt
    _check_control(control, step, spec, collector)
    return ActuatorSet(
        robot=model.robot.name,
        joints=joints,
        unmanaged=bindings.unmanaged,
        physics_dt=step,
        decimation=model.timing.decimation
        or whole_steps(None if control is None else control.value, step.value),
        control_dt=None if control is None else written(control, "s", spec.span("timing", "control_dt")),
        delta_action=None
        if delta is None
        else DeltaAction(os.path.join(folder, delta.manifest), spec.span("delta_action")),
        accept=tuple(model.accept.items()),
        sources=tuple(
            Source(key, s.title, s.url, None if s.page is None else str(s.page), s.commit, s.accessed, s.note)
            for key, s in model.sources.items()
        )
        + tuple(results_sources(spec)),
        spec_sha256=spec.document.text_sha256,
        diagnostics=collector.sorted(),
        default_pose=tuple(model.robot.default_pose),
        approximations=(
            *simplifications(joints, motors, linkages),
            *(loss for inputs in said for loss in drawn_apart(inputs)),
        ),
        variant=model.variant,
    )


def _check_finite(actuator: JointActuator, collector: Collector) -> None:
    """Refuse numbers that left the range of floats on their way to the joint."""
    for name, quantity in actuator.quantities():
        if quantity.value is not None and not math.isfinite(quantity.value):
            collector.at(f"actuators.{actuator.group}", quantity.span or actuator.span).error(
                "RES011",
                f"{actuator.joint}: {name} is out of the range of numbers: {quantity.formula}",
                "look for a figure with a wrong exponent or unit",
            )


def _check_delays(joints: Sequence[JointActuator], collector: Collector) -> None:
    """Warn where nothing is known of a delay: what is written then has none."""
    open_: dict[str, list[JointActuator]] = {}
    for actuator in joints:
        delay = actuator.delay
        if delay is not None and delay.nominal.value is None and delay.low == delay.high:
            open_.setdefault(actuator.group, []).append(actuator)
    for group, members in open_.items():
        assert members[0].delay is not None
        collector.at(f"actuators.{group}.delay", members[0].delay.nominal.span or members[0].span).warning(
            "RES017",
            f"the delay of {listed([a.joint for a in members])} is unknown: every target is written without one",
            "state it, or `delay: 0 ms` where there is none",
        )


def _check_control(control: SpecValue | None, step: Quantity, spec: Spec, collector: Collector) -> None:
    """No action is taken within a step of the model's own; one that the spec states is held to it there."""
    if control is None or control.value is None or step.origin is not Origin.MODEL:
        return
    if CONTROL_PERIOD[0] <= control.value < step.require() and whole_steps(control.value, step.value) is None:
        own = format_quantity(1e3 * step.require(), "ms", 4)
        collector.at("timing.control_dt", spec.span("timing", "control_dt")).warning(
            "SPEC126",
            f"{control.written} is less than one physics step of the model, {own}",
            f"write {own} or a multiple of it, or state physics_dt",
        )


def _physics_dt(spec: Spec, robot: RobotView) -> Quantity:
    stated = spec.model.timing.physics_dt
    file = None
    if robot.timestep is not None:
        file = Quantity(robot.timestep, "s", Origin.MODEL, source=robot.path)
    if stated is not None and stated.value is not None:
        authored = written(stated, "s", spec.span("timing", "physics_dt"))
        return authored if file is None else authored.losing(file)
    return file or Quantity(DEFAULT_TIMESTEP, "s", Origin.DEFAULT, note="MuJoCo's default step")
