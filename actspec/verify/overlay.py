"""What a written Newton overlay says of each joint, read back with `usd-core`."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from actspec.diagnostics import ActspecError, Collector
from actspec.files import NotRegular, TooLarge, read_regular
from actspec.ir import ActuatorSet, JointActuator
from actspec.lift import lift_newton
from actspec.lift.newton_joint import READ
from actspec.lift.newton_prims import TARGETS, NewtonJoint, newton_joints
from actspec.readings.compare import Figure
from actspec.robot.usda import MAX_BYTES, MISSING, Asset, UsdaAttribute, UsdaLayer, read_usda
from actspec.robot.view import RobotView
from actspec.targets.base import TargetOptions
from actspec.targets.newton.paths import Layout, converted_actuators, lay_out
from actspec.targets.newton.usda import path_text
from actspec.verify.readback import Reading, spec_figures

FIELDS = (
    *("kp", "kd", "effort_limit", "stall_torque", "no_load_speed", "delay_low", "delay_high"),
    *("joint_damping", "frictionloss", "armature", "encoder_bias", "velocity_limit"),
)
"""What an overlay can hold, in the words of `actspec.verify.readback`."""

_OF_PRIM = ("newton:armature", "newton:friction", "newton:damping", "newton:velocityLimit")


def read_overlay(path: str, options: TargetOptions, actuators: ActuatorSet, robot: RobotView) -> Reading:
    """Read an overlay.

    Args:
        path: The file.
        options: Where its joints are in the stage.
        actuators: What the spec asks for; its step is that of the delays.
        robot: The robot.

    Raises: RobotError: `usd-core` is not installed.
    """
    said = Collector()
    layout = lay_out(actuators, robot, options, said)
    if said.failed:
        return Reading(path, said.sorted()[0].message)
    try:
        layer = read_usda(read_regular(path, MAX_BYTES), path)
    except ActspecError as err:
        if err.diagnostics[0].code == MISSING:
            raise
        return Reading(path, str(err.diagnostics[0]).removeprefix(f"{path}:"))
    except (NotRegular, TooLarge, OSError, ValueError) as err:
        return Reading(path, str(err))
    prims = {name: path_text(parts) for name, parts in layout.joints.items()}
    views = [view for actuator in actuators.joints if (view := robot.joint(actuator.joint)) is not None]
    whole = lift_newton(layer, views, prims=prims, physics_dt=actuators.physics_dt.require())
    lifted = whole.actuators
    figures: dict[str, dict[str, Figure]] = {
        name: {field: figure for field, figure in found.items() if field in FIELDS}
        for name, found in spec_figures(lifted, path).items()
    }
    joints, _ = newton_joints(layer, views, prims)
    raw = {joint.name: dict(_raw(joint)) for joint in joints}
    for name, prim, active in _own_actuators(layer, robot, layout):
        raw.setdefault(name, {})[f"active of {prim}"] = active
    for joint in joints:
        own = lifted.joint(joint.name)
        if own is not None:
            figures[joint.name].update(_placed(joint, own, figures[joint.name]))
    controls = {actuator.joint: actuator.level.value for actuator in lifted.joints}
    for alone in whole.left_alone:
        # There, with no drive, several, or one that Newton refuses.
        if alone.span is not None:
            figures[alone.joint], controls[alone.joint] = {}, "none"
    return Reading(
        path=path,
        figures=figures,
        controls=controls,
        raw=raw,
    )


def _placed(
    joint: NewtonJoint, actuator: JointActuator, figures: dict[str, Figure]
) -> Iterator[tuple[str, Figure]]:
    """Figures at the place of their attribute, and the force limit of the joint's own prim."""
    delay = actuator.delay
    if delay is not None and delay.nominal.span is not None:
        for name in ("delay_low", "delay_high"):
            yield name, replace(figures[name], place=delay.nominal.span)
    if actuator.encoder_bias.span is not None:
        yield "encoder_bias", replace(figures["encoder_bias"], place=actuator.encoder_bias.span)
    for name, attribute in _of_prim(joint).items():
        if name.endswith(":maxForce") and isinstance(attribute.value, float):
            unit = actuator.effort_limit.unit
            yield "solver_effort_limit", Figure(attribute.value, unit, attribute.span, True)


def _of_prim(joint: NewtonJoint) -> dict[str, UsdaAttribute]:
    return {} if joint.prim is None else dict(joint.prim.attributes)


def _raw(joint: NewtonJoint) -> Iterator[tuple[str, object]]:
    """Schemas, and attributes that are in no figure."""
    if joint.prim is not None:
        yield "schemas of the joint", joint.prim.apis
    for name, attribute in _of_prim(joint).items():
        if name not in _OF_PRIM and not name.endswith(":maxForce"):
            yield name, attribute.value
    for prim in joint.actuators:
        yield "schemas of the actuator", prim.apis
        for name, attribute in prim.attributes.items():
            if isinstance(attribute.value, Asset):
                yield name, attribute.value.path
            elif name not in (TARGETS, *READ):
                yield name, attribute.value


def _own_actuators(layer: UsdaLayer, robot: RobotView, layout: Layout) -> Iterator[tuple[str, str, bool]]:
    """Whether the prims of the model's own actuators, which would act beside, are left on: joint, prim, answer."""
    targets = {actuator.name: actuator.target for actuator in robot.actuators}
    for parts in converted_actuators(robot, layout):
        prim = layer.prims.get(path_text(parts))
        yield targets[parts[-1]], path_text(parts), prim is None or prim.active
