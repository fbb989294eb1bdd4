"""Damping that a file keeps in the joint of a drive without kd: friction, or meant as kd? One answer for all joints."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from actspec.diagnostics import listed, one_line
from actspec.draft.combine import Combined
from actspec.ir import Command, JointActuator, Level, Origin, Quantity

AS_KD = "as-kd"
AS_FRICTION = "as-friction"

LEAST_DAMPING = 1e-3
"""Damping over kp from which joint damping may be meant as the drive's kd [s]. Chosen: a twentieth of kd/kp
in the published gains of legged robots (0.02 s to 0.04 s)."""


def may_be_kd(joint: JointActuator) -> bool:
    """Whether a drive lacks a kd and its joint has damping, however little."""
    viscous, kd = joint.friction_viscous.value, joint.kd
    if joint.command is Command.EFFORT or joint.level is Level.ACTUATOR_NET or kd is None:
        return False
    return bool(viscous and viscous > 0.0 and (kd.origin is Origin.DEFAULT or kd.value in (None, 0.0)))


def is_asked(joint: JointActuator) -> bool:
    """Whether joint damping is large enough to be suspected to be the kd that a drive lacks."""
    kp = joint.kp.value if joint.kp is not None else None
    return may_be_kd(joint) and joint.friction_viscous.require() >= LEAST_DAMPING * (kp or 0.0)


def settled(combined: Combined, answer: str) -> tuple[Combined, str]:
    """The robot with the damping of all drives without kd as what it is said to be; and what was done.

    As kd 0 is left of it in the joint; as friction the kd that MuJoCo takes to be 0 is 0.

    Args:
        combined: What the files say.
        answer: `as-kd` or `as-friction`.
    """
    every = combined.actuators.joints
    asked = [one_line(joint.joint) for joint in every if may_be_kd(joint)]
    if not asked:
        return combined, f"no drive without kd has joint damping (--damping {answer})"
    done = _as_kd if answer == AS_KD else _as_friction
    joints = tuple(done(joint) if may_be_kd(joint) else joint for joint in every)
    said = f"{listed(asked, 4)}: joint damping is {answer.removeprefix('as-')}"
    if answer == AS_FRICTION:
        zero = [one_line(new.joint) for old, new in zip(every, joints, strict=True) if new is not old]
        some = f" at {listed(zero, 4)}" if zero != asked else ""
        said += f", and kd is 0{some}" if zero else ""
    found = replace(combined, actuators=replace(combined.actuators, joints=joints))
    return found, f"{said} (--damping {answer})"


def _as_kd(joint: JointActuator) -> JointActuator:
    note = f"the file's joint damping is kd (--damping {AS_KD})"
    return replace(joint, kd=joint.friction_viscous, friction_viscous=_nothing(joint.friction_viscous, note))


def _as_friction(joint: JointActuator) -> JointActuator:
    """Of a kd that MuJoCo does not take to be 0, such as the one of a URDF's controller, the answer says nothing."""
    if joint.kd is None or joint.kd.origin is not Origin.DEFAULT:
        return joint
    note = f"the file's drive has none, and its joint damping is friction (--damping {AS_FRICTION})"
    return replace(joint, kd=_nothing(joint.kd, note))


def _nothing(quantity: Quantity, note: str) -> Quantity:
    return Quantity(0.0, quantity.unit, Origin.AUTHORED, note=note)


def question(joints: Sequence[JointActuator]) -> str:
    """What to ask of those whose damping may be kd; "" where there is none."""
    asked = [one_line(joint.joint) for joint in joints if is_asked(joint)]
    if not asked:
        return ""
    return (
        f"joint damping, or the drive's kd? {listed(asked, 4)}: no kd, and joint damping, which is friction.viscous "
        f"here: no torque limit clamps it. `import --damping {AS_KD}` makes it kd, `--damping {AS_FRICTION}` leaves it"
    )
