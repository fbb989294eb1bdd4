"""An overlay of a stage with NewtonActuators as an ActuatorSet.

What the stage below it says is not at hand: of it nothing is taken for stated.
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterator, Mapping, Sequence

from actspec.diagnostics import Span
from actspec.ir import ActuatorSet, JointActuator, Quantity
from actspec.lift.lifted import LeftAlone, Lifted
from actspec.lift.newton_joint import NewtonDrive, unsaid
from actspec.lift.newton_prims import newton_joints
from actspec.readings.quantities import stated, tidy, unknown
from actspec.robot.usda import UsdaLayer
from actspec.robot.view import JointView

_OURS = "Written by actspec "
_STEP = re.compile(r"Every physics step of (\d+(?:\.\d+)?(?:e[-+]?\d+)?) ms:")


def lift_newton(
    layer: UsdaLayer,
    joints: Sequence[JointView | str] | None = None,
    *,
    prims: Mapping[str, str] | None = None,
    physics_dt: float | None = None,
) -> Lifted:
    """What an overlay says of a robot's actuators.

    The command of a drive without stiffness is a speed, of one without gains a torque.

    Args:
        layer: The overlay.
        joints: The robot's joints, in its order, names alone where no robot file has them; None: those that the
            overlay names itself.
        prims: Joint to the path of its prim; None: a joint is called as its prim is.
        physics_dt: The simulation's step [s], of which delays are multiples; None: what the head says, to its six
            digits, where actspec wrote it.
    """
    found, remarks = newton_joints(layer, joints, prims)
    head = _head_step(layer)
    step = head.value if physics_dt is None else physics_dt
    actuators: list[JointActuator] = []
    alone: list[LeftAlone] = []
    notes: dict[str, tuple[str, ...]] = {}
    for joint in found:
        why = unsaid(joint)
        if why is not None:
            prim = joint.actuators[0] if joint.actuators else joint.prim
            alone.append(LeftAlone(joint.name, why, None if prim is None else prim.span))
            continue
        drive = NewtonDrive(joint, os.path.dirname(layer.path), step)
        actuators.append(drive.actuator())
        if drive.notes:
            notes[joint.name] = tuple(dict.fromkeys(drive.notes))
    whole = (*remarks, *_unfollowed(layer))
    if whole:
        notes[""] = whole
    return Lifted(
        ActuatorSet(
            robot=next((path.split("/")[1] for path in layer.prims), ""),
            joints=tuple(actuators),
            unmanaged=tuple(item.joint for item in alone),
            physics_dt=head,
            decimation=None,
            delta_action=None,
            accept=(),
            sources=(),
            spec_sha256="",
        ),
        tuple(alone),
        notes,
    )


def _unfollowed(layer: UsdaLayer) -> Iterator[str]:
    for word in layer.unfollowed:
        yield f"{word} are not followed: what they bring in is not here"


def _head_step(layer: UsdaLayer) -> Quantity:
    """The step that our own head names."""
    if any(line.startswith(_OURS) for line in layer.head):
        for line in layer.head:
            match = _STEP.match(line)
            if match:
                return stated(tidy(float(match[1]) / 1e3), "s", Span(layer.path, 1))
    return unknown("s", "the format has no time step")
