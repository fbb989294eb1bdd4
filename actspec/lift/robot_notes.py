"""What of a joint in a robot file a spec cannot hold, or says otherwise."""

from __future__ import annotations

from collections.abc import Iterator

from actspec.ir import Command
from actspec.lift.quantities import Units
from actspec.lift.robot_limits import is_symmetric
from actspec.robot.view import ActuatorView, JointView


def notes_of(joint: JointView, own: tuple[ActuatorView, ...], command: Command) -> tuple[str, ...]:
    """Remarks on one joint that is lifted."""
    return tuple(_notes(joint, own, command))


def _notes(joint: JointView, own: tuple[ActuatorView, ...], command: Command) -> Iterator[str]:
    units = Units(joint.kind)
    if len(own) > 1:
        yield f"{len(own)} actuators in the file ({', '.join(a.control for a in own)}) become one"
    factor = own[0].gear * (own[0].gain if own[0].control == "motor" else 1.0) if own else 1.0
    if factor != 1.0:
        effort = command is Command.EFFORT
        where = f"in {units.torque} at the joint" if effort else "in joint units"
        what = "gear and gain" if effort else "gear"
        yield f"the file's {what} of {factor:g} go: after a compile the control is {where}"
    spans = [a.force_range for a in own]
    for span in (*spans, joint.effort_range):
        if span is not None and not is_symmetric(span):
            yield f"the file's limit is not symmetric ({span[0]:g} to {span[1]:g}), a spec has one number: the larger"
            break
    if any(joint.damping_polynomial) or any(any(a.damping[1:]) for a in own):
        yield "the file's polynomial damping stays in the model, a spec has no word for it"
    if joint.springdamper:
        yield "the file's springdamper is in force: a compile writes the stiffness and damping that it stands for"
    elif joint.stiffness and "stiffness" not in joint.unknown:
        value = f"{joint.stiffness:g} {units.stiffness}"
        yield f"the joint's own spring ({value}) stays in the model, a spec has no word for it"
    if any("dampratio" in a.stated for a in own):
        yield "the file's dampratio becomes the kd that MuJoCo makes of it"
