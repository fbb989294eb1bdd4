"""What `compile` says of networks: a model that is no longer the one of their training, and what is counted twice.

A network holds what the logged drive did. Its delay and filter are in it; behind joint friction, friction and armature
are too. What the spec states of these comes on top.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from actspec.diagnostics import Collector, Diagnostic, Place, RobotError, listed
from actspec.ir import ActuatorSet, JointActuator, Level, Network
from actspec.robot.view import RobotView
from actspec.spec.network import NetworkManifest
from actspec.targets.kit.network import onnx_of, read_manifest, read_network
from actspec.units import format_quantity

STOPS = 4
"""Most figures that are named. Chosen: a line that is still read."""


def network_notes(actuators: ActuatorSet, robot: RobotView) -> tuple[Diagnostic, ...]:
    """Warnings about the networks of a spec whose manifests can be read; `check_manifests` reports the others.

    Args:
        actuators: What the spec asks for.
        robot: Its robot.
    """
    out = Collector()
    groups: dict[Network, list[JointActuator]] = {}
    for actuator in actuators.joints:
        if actuator.level is Level.ACTUATOR_NET and actuator.network is not None:
            groups.setdefault(actuator.network, []).append(actuator)
    for network, members in groups.items():
        if network.manifest is None:
            continue
        place = out.at(f"actuators.{members[0].group}.network", network.span or members[0].span)
        manifest = read_manifest(network.manifest, Collector().at())
        if manifest is None:
            continue
        if manifest.model is not None:
            _changed(manifest, actuators.joints, robot, place)
        if manifest.torque == "joint":
            _behind_friction(manifest, members, place)
        _late(manifest, members, place)
    return out.sorted()


def _changed(
    manifest: NetworkManifest, joints: Sequence[JointActuator], robot: RobotView, place: Place
) -> None:
    """Whether the dynamics with which torques were inferred are those of today."""
    from actspec.learn.dynamics import changes, dynamics_entries
    from actspec.spec.network import TrainedModel

    by_name = {actuator.joint: actuator for actuator in joints}
    mine = [by_name[name] for name in manifest.joints if name in by_name]
    try:
        now = dynamics_entries(robot, mine)
    except RobotError:
        message = "whether the model is the one that the network's torques were inferred with is not known"
        place.warning("NET013", message, "name a model that has the links' masses")
        return
    if now["model"] == manifest.model:
        return
    was, today = manifest.dynamics, TrainedModel.model_validate(now["dynamics"])
    found = [] if was is None else list(changes(was, today, mine))
    if not found and len(mine) < len(manifest.joints):
        # Joints that are not here are in the hash too.
        return
    what = "; ".join(found[:STOPS]) or "in its links, axes or springs"
    more = f"; and {len(found) - STOPS} more" if len(found) > STOPS else ""
    place.warning(
        "NET013",
        f"the model has changed since the network's torques were inferred with it: {what}{more}",
        "the network makes up for the faults of the model that it was trained with: train it again",
    )


def _behind_friction(manifest: NetworkManifest, members: Sequence[JointActuator], place: Place) -> None:
    """Friction and armature that the network's torque holds already."""
    lines = []
    for actuator, speed in ((actuator, _speed(manifest, actuator)) for actuator in members):
        unit = actuator.effort_limit.unit
        dry, viscous = actuator.friction_coulomb.value or 0.0, actuator.friction_viscous.value or 0.0
        parts = []
        if dry or viscous:
            at = format_quantity(speed, actuator.velocity_limit.unit, 3)
            parts.append(f"friction {format_quantity(dry + viscous * speed, unit, 3)} at {at}")
        armature, held, limit = actuator.armature.value, actuator.inertia_held, actuator.effort_limit.value
        if armature:
            text = f"armature {format_quantity(armature, actuator.armature.unit, 3)}"
            if held is not None and limit is not None and held.reference > 0.0:
                share = limit * min(armature / held.reference, 1.0)
                text += f", {format_quantity(share, unit, 3)} of {format_quantity(limit, unit, 3)}"
            parts.append(text)
        if parts:
            lines.append((actuator.joint, "; ".join(parts)))
    if lines:
        place.warning(
            "NET014",
            "the network gives the torque behind joint friction (torque: joint), and the spec adds again: "
            + " | ".join(_together(lines)),
            "state friction and armature of 0 for these joints, or train with the drive's torque",
        )


def _late(manifest: NetworkManifest, members: Sequence[JointActuator], place: Place) -> None:
    """Delay and filter that the network holds already."""
    lines = []
    stiffness: float | None = math.nan
    for actuator in members:
        delay = actuator.delay.nominal.value if actuator.delay is not None else None
        cutoff = None if actuator.filter_cutoff is None else actuator.filter_cutoff.value
        named = [("delay", format_quantity(delay * 1e3, "ms"), delay)] if delay else []
        if cutoff:
            named.append(("command_filter", format_quantity(cutoff, "Hz"), 1.0 / (2.0 * math.pi * cutoff)))
        if not named:
            continue
        if stiffness is not None and math.isnan(stiffness):
            stiffness = _stiffness(members[0])
        speed = _speed(manifest, actuator)
        for name, value, time in named:
            text = f"{name} {value}"
            if stiffness is not None:
                # A command that moves at this speed is so much further by then.
                torque = min(stiffness * speed * time, 2.0 * (actuator.effort_limit.value or math.inf))
                at = format_quantity(speed, actuator.velocity_limit.unit, 3)
                text += f", {format_quantity(torque, actuator.effort_limit.unit, 3)} at {at}"
            lines.append((actuator.joint, text))
    if lines:
        place.warning(
            "NET015",
            "the network holds the logged drive's delay and filter; the spec's come on top where a target has them: "
            + " | ".join(_together(lines)),
            "leave them out of the group, or train on logs of the drive alone",
        )


def _speed(manifest: NetworkManifest, actuator: JointActuator) -> float:
    """A speed of the training data that is seldom exceeded, else the drive's or the joint's, else 1 [rad/s or m/s]."""
    if manifest.range is not None:
        ends = manifest.range.velocity
        return max(abs(ends.low), abs(ends.high))
    for figure in (actuator.no_load_speed, actuator.velocity_limit):
        if figure is not None and figure.value is not None:
            return figure.value
    return 1.0


def _stiffness(actuator: JointActuator) -> float | None:
    """Torque by error of a joint's network at rest [N*m/rad or N/m]; None: its layers are not known."""
    from actspec.learn.inspect import inspect
    from actspec.logs import LogError

    named = onnx_of(actuator)
    found = None if named is None else read_network(named, "onnx", Collector())
    layers = None if found is None else found.layers()
    if found is None or layers is None:
        return None
    try:
        return inspect(layers, found.manifest).stiffness
    except LogError:
        return None


def _together(lines: Sequence[tuple[str, str]]) -> Iterator[str]:
    """Joints that have the same said of them, together."""
    said: dict[str, list[str]] = {}
    for joint, text in lines:
        said.setdefault(text, []).append(joint)
    for text, joints in said.items():
        yield f"{listed(dict.fromkeys(joints), most=4)}: {text}"
