"""USD stages to lay an overlay on, written as mujoco-usd-converter writes them, with numbers that are all wrong.

Each joint has a drive of its own, and armature, friction, damping and speed limit that no spec has; each of the
model's actuators is an `MjcActuator`. What the overlay does not set shows.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import mujoco

WRONG = {"stiffness": 3.0, "gain": 0.7, "max_force": 0.25, "armature": 0.77, "friction": 0.66, "damping": 0.55,
         "velocity_limit": 44.0}  # fmt: skip
"""What each joint has in the stage; of a hinge per degree, or in degrees, where USD has it so."""

JOINT = """float drive:{axis}:physics:stiffness = {stiffness}
float drive:{axis}:physics:damping = {gain}
float drive:{axis}:physics:maxForce = {max_force}
float newton:armature = {armature}
float newton:friction = {friction}
float newton:damping = {damping}
float newton:velocityLimit = {velocity_limit}"""

HEAD = """#usda 1.0
(
    defaultPrim = "{root}"
    kilogramsPerUnit = 1
    metersPerUnit = 1
    upAxis = "Z"
)
def PhysicsScene "PhysicsScene" {{}}
"""

SOLID = """float physics:mass = 1
float3 physics:diagonalInertia = (1, 1, 1)"""


def stage_of(model: mujoco.MjModel, root: str) -> str:
    """The stage of a compiled MuJoCo model whose bodies all have names.

    Args:
        model: The model.
        root: Name of the robot's prim.
    """
    scope = [f'def MjcActuator "{model.actuator(i).name}" {{}}' for i in range(model.nu)]
    children: dict[int, list[int]] = {}
    for body in range(1, model.nbody):
        children.setdefault(int(model.body_parentid[body]), []).append(body)
    top = children.get(0, [])
    bodies = [_body(model, body, f"/{root}/Geometry", "", children) for body in top]
    inner = [
        f'def Scope "Geometry" {{\n{chr(10).join(bodies)}\n}}',
        f'def Scope "Physics" {{\n{chr(10).join(scope)}\n}}',
    ]
    return HEAD.format(root=root) + f'def Xform "{root}" {{\n{chr(10).join(inner)}\n}}\n'


def _body(model: mujoco.MjModel, body: int, above: str, parent: str, children: dict[int, list[int]]) -> str:
    """A body's prim, its joints in it and its children below it."""
    name = model.body(body).name
    path = f"{above}/{name}"
    apis = ["PhysicsRigidBodyAPI", "PhysicsMassAPI", *([] if parent else ["PhysicsArticulationRootAPI"])]
    lines = [SOLID]
    start, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
    for joint in range(start, start + count):
        if int(model.jnt_type[joint]) == 0:
            continue
        hinge = int(model.jnt_type[joint]) == 3
        lines.append(_joint(model.joint(joint).name, hinge, path, parent))
    if count == 0 and parent:
        lines.append(_ends("PhysicsFixedJoint", "weld", path, parent, "", ""))
    lines += [_body(model, child, path, path, children) for child in children.get(body, [])]
    listed = ", ".join(f'"{api}"' for api in apis)
    return f'def Xform "{name}" (prepend apiSchemas = [{listed}]) {{\n{chr(10).join(lines)}\n}}'


def _joint(name: str, hinge: bool, path: str, parent: str) -> str:
    axis = "angular" if hinge else "linear"
    kind = "PhysicsRevoluteJoint" if hinge else "PhysicsPrismaticJoint"
    apis = f'(prepend apiSchemas = ["PhysicsDriveAPI:{axis}", "NewtonJointAPI"])'
    return _ends(
        kind,
        name,
        path,
        parent,
        apis,
        f'uniform token physics:axis = "Y"\n{JOINT.format(axis=axis, **WRONG)}',
    )


def _ends(kind: str, name: str, path: str, parent: str, apis: str, more: str) -> str:
    first = f"rel physics:body0 = <{parent}>\n" if parent else ""
    return f'def {kind} "{name}" {apis} {{\n{first}rel physics:body1 = <{path}>\n{more}\n}}'
