"""mjlab: the written articulation on a robot with the model's joints, stepped by the real package."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

from actspec.ir import ActuatorSet, JointKind
from actspec.robot.view import JointView, RobotView
from actspec.simulate.excitation import HeldMotions
from actspec.simulate.experiment import Experiment
from actspec.simulators import release_of
from actspec.simulators.mjlab import INSTALLED, mjlab_dialect
from actspec.verify.engines.asking import (
    BodyFriction,
    EngineAnswer,
    EngineMissing,
    EngineResponse,
    Question,
    prepared,
    probed,
)


def ask(question: Question, motions: HeldMotions) -> EngineAnswer:
    """Torques of the written articulation.

    Raises:
        EngineMissing: the release is not prepared, or is not the one that the environment has.
        EngineRefused: the package does not take the file.
    """
    job, arrays = question.job(motions)
    said, torques = _probed(question, job, arrays, {})
    return EngineAnswer(f"mjlab {INSTALLED}", True, torques, said["figures"])


def respond(question: Question, experiment: Experiment, friction: BodyFriction) -> EngineResponse:
    """Responses of the written articulation, each joint on a body of its own.

    Raises: as `ask`.
    """
    inertia = dict(zip(experiment.names, experiment.body.tolist(), strict=True))
    said, out = _probed(question, experiment.job(), experiment.arrays(), inertia)
    return EngineResponse.of(f"mjlab {INSTALLED}", said, out, single=True)


def _probed(
    question: Question, job: Mapping[str, Any], arrays: Mapping[str, Any], inertia: Mapping[str, float]
) -> tuple[Any, dict[str, Any]]:
    """What the release's probe answers to a job on the joints alone."""
    dialect = mjlab_dialect(question.options.version)
    if dialect.version != release_of(INSTALLED):
        raise EngineMissing(
            f"mjlab {dialect.text} is not run here: the environment has {INSTALLED}, "
            "and each release needs a MuJoCo of its own"
        )
    frameworks = prepared(f"mjlab {INSTALLED}")
    model = skeleton(question.robot, question.actuators, inertia)
    more = {"model": model, "module": str(Path(question.main).resolve()), "step": question.step}
    return probed(frameworks, "probe_mjlab.py", {**job, **more}, arrays)


def skeleton(robot: RobotView, actuators: ActuatorSet, inertia: Mapping[str, float]) -> str:
    """MJCF text of the robot's hinges and slides, each on a body of its own, with what the file has of them.

    It needs no meshes, and every release reads it.

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
        if joint.name in inertia:
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
