"""A robot without a model file: the joints that its spec lists."""

from __future__ import annotations

from typing import TYPE_CHECKING

from actspec.diagnostics import Diagnostic, ResolveError, Severity
from actspec.joints import JointKind
from actspec.robot.view import JointView, ModelFormat, RobotView

if TYPE_CHECKING:
    from actspec.spec.validate import Spec


def listed_robot(spec: Spec) -> RobotView:
    """The view of a robot with `model: none`: names, kinds and ranges, nothing else.

    Raises:
        ResolveError: a range has the unit of the other kind of joint.
    """
    joints = []
    faults = []
    for index, entry in enumerate(spec.model.robot.joints):
        span = spec.span("robot", "joints", index)
        name = entry if isinstance(entry, str) else entry.name
        kind = JointKind.HINGE if isinstance(entry, str) else JointKind(entry.kind)
        limits = None
        if not isinstance(entry, str) and entry.range is not None:
            low, high = entry.range
            limits = (float(low.value), float(high.value))
            if any(
                end.linear is not None and end.linear is not (kind is JointKind.SLIDE) for end in (low, high)
            ):
                faults.append(
                    Diagnostic(
                        "RES001",
                        Severity.ERROR,
                        f"'{name}' is a {kind.value} joint, but its range is [{low.written}, {high.written}]",
                        f"robot.joints[{index}].range",
                        span,
                        "a hinge is in rad, a slide in m",
                    )
                )
        joints.append(
            JointView(
                name=name,
                kind=kind,
                span=span,
                body="",
                dof=-1,
                range=limits,
                damping=0.0,
                damping_polynomial=(0.0, 0.0),
                stiffness=0.0,
                armature=0.0,
                frictionloss=0.0,
                effort_range=None,
                velocity_limit=None,
                stated=frozenset(),
                springdamper=False,
                mimic=None,
                reference_position=0.0,
            )
        )
    if faults:
        raise ResolveError(faults)
    return RobotView(
        name=spec.model.robot.name,
        path=spec.document.path,
        format=ModelFormat.NONE,
        joints=tuple(joints),
        actuators=(),
        timestep=None,
        integrator="",
        keyframes=(),
        inertia=None,
        inertia_reason="the spec names no model",
        files=(),
    )
