"""Newton: the written overlay on a stage with the joints' prims, read and stepped by the real package."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from actspec.diagnostics import Collector, shortened
from actspec.ir import JointKind
from actspec.simulate.excitation import HeldMotions
from actspec.simulate.experiment import Experiment
from actspec.simulators import text_of
from actspec.simulators.newton import RELEASES, NewtonDialect, newton_dialect
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
from actspec.verify.environments import NEWTON

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


def ask(question: Question, motions: HeldMotions) -> EngineAnswer:
    """Torques of the written actuators.

    Raises:
        EngineMissing: no release of this version is in the environment, or there is none.
        EngineRefused: the package does not take the file.
    """
    dialect, said, torques = _probed(question, *question.job(motions))
    figures = dict(zip(question.joints, said["figures"], strict=True))
    if not dialect.joint_damping:
        # Such a release leaves them where they were.
        kept = ("armature", "frictionloss")
        figures = {joint: {name: found[name] for name in kept} for joint, found in figures.items()}
    return EngineAnswer(f"newton {said['version']}", True, torques, figures)


def respond(question: Question, experiment: Experiment, friction: BodyFriction) -> EngineResponse:
    """Responses of bodies that the written actuators' torques move; none of Newton's solvers does here.

    Raises: as `ask`.
    """
    arrays = experiment.arrays() | {"coulomb": friction[0], "viscous": friction[1]}
    _, said, out = _probed(question, experiment.job(), arrays)
    return EngineResponse.of(f"newton {said['version']}", said, out, single=True)


def _probed(
    question: Question, job: Mapping[str, Any], arrays: Mapping[str, Any]
) -> tuple[NewtonDialect, Any, dict[str, Any]]:
    """The version, and what its probe says to a job about joints."""
    dialect = newton_dialect(question.options.version)
    if not dialect.run:
        *others, last = (text_of(version) for version, package in RELEASES.items() if package)
        raise EngineMissing(
            f"Newton {dialect.text} is not run here: the environment has {', '.join(others)} and {last}"
        )
    frameworks = prepared(f"Newton {dialect.text}")
    package = RELEASES[dialect.version]
    beside = package if package in NEWTON else None
    paths = _paths(question)
    more = {
        "path": [] if beside is None else [str(frameworks.newton(beside))],
        "overlay": str(Path(question.main).resolve()),
        "stage": stage(question, paths),
        "joints": ["/" + "/".join(paths[joint]) for joint in job["columns"]],
        "step": question.step,
    }
    said, out = probed(frameworks, "probe_newton.py", {**job, **more}, arrays)
    return dialect, said, out


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
