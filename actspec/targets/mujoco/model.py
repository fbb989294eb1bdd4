"""The model that the MuJoCo target writes, compiled in memory for the installed MuJoCo, with its meshes."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, EmitError, RobotError
from actspec.ir import ActuatorSet
from actspec.robot.assets import need_meshes
from actspec.robot.mjspec import compile_spec, open_spec
from actspec.robot.view import ModelFormat, RobotView
from actspec.robot.xml import parse_document
from actspec.simulators.mujoco import installed_dialect
from actspec.targets.mujoco.apply_spec import apply_to_spec
from actspec.targets.mujoco.emit import canonical_files
from actspec.targets.mujoco.plan import integrator_for, plan_model, unchanged_controls, with_keys

if TYPE_CHECKING:
    import mujoco


def model_of(actuators: ActuatorSet, robot: RobotView) -> mujoco.MjModel:
    """The robot's model with the spec's actuators.

    Args:
        actuators: The spec, resolved.
        robot: Read from its file.

    Raises:
        RobotError: there is no model, it does not compile, or its masses are in meshes that are not there.
        EmitError: the target does not take the spec.
    """
    collector = Collector()
    if robot.format is ModelFormat.NONE:
        message = "the spec names no model, and a robot's motion needs one"
        raise RobotError.of("SYS001", message, where="robot.model", help="name the robot's MJCF or URDF")
    if robot.format is ModelFormat.URDF:
        robot = canonical_files(robot, collector)
    document = parse_document(robot.files)
    plan, _ = plan_model(actuators, robot, installed_dialect(), "mujoco", collector)
    collector.raise_if_failed(EmitError)
    plan = replace(plan, integrator=integrator_for(actuators, robot, document, collector))
    bare = compile_spec(open_spec(robot.files, format=ModelFormat.MJCF), robot.files)
    plan = with_keys(plan, robot, bare, unchanged_controls(plan, robot))
    spec = open_spec(robot.files, format=ModelFormat.MJCF, real_assets=True, document=document)
    need_meshes(spec)
    apply_to_spec(spec, plan, installed_dialect(), f"actspec {actuators.robot}", explicit=True)
    return compile_spec(spec, robot.files)
