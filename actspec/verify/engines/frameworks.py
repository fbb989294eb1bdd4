"""The frameworks' own packages: what is written for Isaac Lab, mjlab and Newton, run by their probes.

Isaac Lab builds the written cfgs with the real classes of a release, mjlab the written articulation on a robot with the
model's joints, Newton the written overlay on a stage with the joints' prims.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

from actspec.diagnostics import Collector, shortened
from actspec.ir import ActuatorSet, JointKind
from actspec.robot.view import JointView, RobotView
from actspec.simulate.excitation import COURSES, HeldMotions
from actspec.simulate.experiment import Experiment
from actspec.simulators import release_of, text_of
from actspec.simulators.mjlab import INSTALLED, mjlab_dialect
from actspec.simulators.newton import RELEASES, newton_dialect
from actspec.targets.isaaclab import dialect_for
from actspec.targets.isaaclab.classes import classes_of
from actspec.targets.newton.paths import lay_out
from actspec.targets.newton.usda import path_text
from actspec.verify.engines.asking import (
    BodyFriction,
    EngineAnswer,
    EngineMissing,
    EngineRefused,
    EngineResponse,
    Question,
    prepared,
    probed,
)
from actspec.verify.environments import NEWTON, Frameworks


def ask(question: Question, motions: HeldMotions) -> EngineAnswer:
    """Torques of what is written.

    Raises:
        EngineMissing: no release of this version can be had, or it is not prepared, or its drive is the solver's.
        EngineRefused: the package does not take the file.
    """
    engine, said, torques = _probed(question, *question.job(motions))
    return EngineAnswer(engine, True, torques, _figures(question, said))


def respond(question: Question, experiment: Experiment, friction: BodyFriction) -> EngineResponse:
    """Responses of bodies that the written drives move: mjlab by its own, on bodies with the joints' inertia.

    The torques of Isaac Lab and Newton move bodies of ours: PhysX is in no package, and of Newton's solvers none runs
    here.

    Raises: as `ask`.
    """
    arrays = experiment.arrays() | {"coulomb": friction[0], "viscous": friction[1]}
    engine, said, out = _probed(question, experiment.job(), arrays)
    return EngineResponse.of(engine, said, out, single=True)


def _probed(
    question: Question, job: Mapping[str, Any], arrays: Mapping[str, Any]
) -> tuple[str, Any, dict[str, Any]]:
    """Name and release of the engine, what its probe says to a job about joints, and its arrays."""
    kind = question.options.kind
    engine, frameworks, more = _PREPARE[kind](question, job, arrays)
    said, out = probed(frameworks, f"probe_{kind}.py", {**job, "step": question.step, **more}, arrays)
    return f"newton {said['version']}" if kind == "newton" else engine, said, out


def _figures(question: Question, said: Any) -> dict[str, dict[str, float]]:
    """Joint to fields that the engine itself reports."""
    if question.options.kind == "isaaclab":
        # The others depend on class and version, and are read back.
        return {joint: {"armature": found["armature"]} for joint, found in said["joints"].items()}
    if question.options.kind == "mjlab":
        return dict(said["figures"])
    figures = dict(zip(question.joints, said["figures"], strict=True))
    if newton_dialect(question.options.version).joint_damping:
        return figures
    # Such a release leaves the others where they were.
    return {
        joint: {name: found[name] for name in ("armature", "frictionloss")}
        for joint, found in figures.items()
    }


Prepared = tuple[str, Frameworks, dict[str, Any]]
"""Name of the engine, the environment, and what the probe gets beside the job."""


def _isaaclab(question: Question, job: Mapping[str, Any], arrays: Mapping[str, Any]) -> Prepared:
    dialect = dialect_for(question.options)
    release = dialect.row.wheel
    if release is None:
        raise EngineMissing(f"the registry has no package of Isaac Lab {dialect.text}")
    if "implicit" in classes_of(question.actuators, question.options, Collector()).values():
        raise EngineMissing("the drive of an implicit actuator is in PhysX, which is in no package")
    frameworks = prepared(f"Isaac Lab {release}")
    # A floating base is no joint of an articulation.
    joints = [joint.name for joint in question.robot.joints if joint.kind is not JointKind.FREE]
    root, module = str(frameworks.isaaclab(release)), str(Path(question.main).resolve())
    return f"isaaclab {release}", frameworks, {"root": root, "module": module, "joints": joints}


def _mjlab(question: Question, job: Mapping[str, Any], arrays: Mapping[str, Any]) -> Prepared:
    dialect = mjlab_dialect(question.options.version)
    if dialect.version != release_of(INSTALLED):
        raise EngineMissing(
            f"mjlab {dialect.text} is not run here: the environment has {INSTALLED}, "
            "and each release needs a MuJoCo of its own"
        )
    frameworks = prepared(f"mjlab {INSTALLED}")
    # Joints that are held need no inertia of their own.
    inertia = (
        dict(zip(job["columns"], arrays["inertia"].tolist(), strict=True)) if "inertia" in arrays else {}
    )
    model = skeleton(question.robot, question.actuators, inertia)
    module = str(Path(question.main).resolve())
    return f"mjlab {INSTALLED}", frameworks, {"model": model, "module": module}


def _newton(question: Question, job: Mapping[str, Any], arrays: Mapping[str, Any]) -> Prepared:
    dialect = newton_dialect(question.options.version)
    if not dialect.run:
        *others, last = (text_of(version) for version, package in RELEASES.items() if package)
        raise EngineMissing(
            f"Newton {dialect.text} is not run here: the environment has {', '.join(others)} and {last}"
        )
    frameworks = prepared(f"Newton {dialect.text}")
    package = RELEASES[dialect.version]
    paths = _paths(question)
    more = {
        # An older release stands beside the one that is installed.
        "path": [str(frameworks.newton(package))] if package in NEWTON else [],
        "overlay": str(Path(question.main).resolve()),
        "stage": stage(question, paths),
        "joints": [path_text(paths[joint]) for joint in job["columns"]],
        "networks": COURSES in job.get("motions", ()),
    }
    return f"newton {package}", frameworks, more


_PREPARE = {"isaaclab": _isaaclab, "mjlab": _mjlab, "newton": _newton}


def skeleton(robot: RobotView, actuators: ActuatorSet, inertia: Mapping[str, float]) -> str:
    """MJCF text of the robot's hinges and slides, each on a body of its own, with what the file has of them.

    It needs no meshes, and every release reads it. All stand in one place: mjlab computes in single precision, about
    the centre of mass of all of them, so that a body d from there has 6e-8 of its mass times d^2 too much inertia.

    Args:
        robot: The robot; where nobody names a model, it lists the joints.
        actuators: What the spec asks for; a joint of it has a motor, as in the author's model.
        inertia: Of the bodies, where it matters [kg*m^2 or kg]: a ball at the joint.
    """
    driven = {a.target for a in robot.actuators} & {a.joint for a in actuators.joints}
    lines = ["<mujoco>", '  <compiler angle="radian"/>', "  <worldbody>"]
    for joint in robot.scalar_joints:
        lines += ["    <body>", f"      <joint {_attributes(joint)}/>"]
        if joint.name in inertia:
            lines.append(f"      {_ball(inertia[joint.name])}")
        lines += ['      <geom size="0.1" contype="0" conaffinity="0"/>', "    </body>"]
    lines += ["  </worldbody>", "  <actuator>"]
    for joint in robot.scalar_joints:
        if joint.name in driven:
            lines.append(f"    <motor joint={quoteattr(joint.name)}/>")
    return "\n".join([*lines, "  </actuator>", "</mujoco>"])


def _ball(inertia: float) -> str:
    # In kg and in kg*m^2: slides move the centre of mass, and what that adds must be little of a hinge's inertia too.
    return f'<inertial pos="0 0 0" mass="{inertia!r}" diaginertia="{inertia!r} {inertia!r} {inertia!r}"/>'


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


_HEAD = """#usda 1.0
(
    kilogramsPerUnit = 1
    metersPerUnit = 1
    upAxis = "Z"
)
def PhysicsScene "PhysicsScene" {
}
"""

_BODY = """def Xform "{name}" (
    prepend apiSchemas = ["PhysicsRigidBodyAPI", "PhysicsMassAPI", "PhysicsArticulationRootAPI"]
) {{
    float physics:mass = 1
    float3 physics:diagonalInertia = (1, 1, 1)
}}
"""

_JOINT = """def {kind} "{name}" (prepend apiSchemas = ["PhysicsDriveAPI:{axis}", "NewtonJointAPI"]) {{
    rel physics:body1 = <{body}>
    uniform token physics:axis = "Y"
}}
"""


def _paths(question: Question) -> dict[str, tuple[str, ...]]:
    """Where the overlay looks for each joint."""
    said = Collector()
    found = lay_out(question.actuators, question.robot, question.options, said)
    if said.failed:
        raise EngineRefused(shortened(said.sorted()[0].message, 300))
    return found.joints


def stage(question: Question, paths: dict[str, tuple[str, ...]]) -> str:
    """A stage with the joints where the overlay looks for them, each between the world and a body of its own.

    It has no numbers: those that the overlay does not set show as Newton's defaults.
    """
    tree: dict[str, object] = {}
    bodies = []
    for index, actuator in enumerate(question.actuators.joints):
        *above, name = paths[actuator.joint]
        node = tree
        for part in above:
            inner = node.setdefault(part, {})
            if not isinstance(inner, dict):
                raise EngineRefused(f"the prim of {actuator.joint} is below another joint's")
            node = inner
        hinge = actuator.kind is JointKind.HINGE
        node[name] = _JOINT.format(
            kind="PhysicsRevoluteJoint" if hinge else "PhysicsPrismaticJoint",
            axis="angular" if hinge else "linear",
            name=name,
            body=path_text(("ActspecBodies", f"body{index}")),
        )
        bodies.append(_BODY.format(name=f"body{index}"))
    return _HEAD + 'def Scope "ActspecBodies" {\n' + "".join(bodies) + "}\n" + _text(tree)


def _text(tree: dict[str, object]) -> str:
    parts = []
    for name, node in tree.items():
        parts.append(f'def Xform "{name}" {{\n{_text(node)}}}\n' if isinstance(node, dict) else str(node))
    return "".join(parts)
