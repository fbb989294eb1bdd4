"""The Newton target: a `.usda` overlay of a robot's stage with its actuators and the numbers of its joints."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Sequence

import actspec
from actspec.diagnostics import Collector, EmitError, listed
from actspec.ir import ActuatorSet, JointActuator, JointKind
from actspec.robot.view import ModelFormat, RobotView
from actspec.simulators.newton import NewtonDialect
from actspec.targets.base import Approximation, Emission, EmittedFile, TargetOptions
from actspec.targets.check import newton_row
from actspec.targets.kit.joint import delta_action_loss, joint_by_joint, unknown_passive, unlimited_joints
from actspec.targets.kit.network import network_files, read_networks
from actspec.targets.kit.provenance import sections, written_by
from actspec.targets.kit.python_text import comment_lines, free_name, identifier, section_lines
from actspec.targets.newton.joint_prims import JointPrims, prims_of
from actspec.targets.newton.paths import StagePaths, converted_actuators, lay_out
from actspec.targets.newton.usda import Prim, UsdAttribute, path_text, prim_lines, string

WIDTH = 110
"""Columns of the header."""

SCOPE = "NewtonActuators"
"""Prim below the robot's that holds the actuators."""


def overlay_name(robot: str) -> str:
    """Name of the file: `unitree_a1_newton.usda`."""
    return f"{identifier(robot).lower()}_newton.usda"


def emit(actuators: ActuatorSet, robot: RobotView, options: TargetOptions) -> Emission:
    """Write a robot's actuators as an overlay of its USD stage; see `choose.Emit`."""
    collector = Collector()
    dialect = newton_row(options, collector)
    step = actuators.physics_dt.require()

    read = read_networks(actuators, "onnx", collector)

    def prims(actuator: JointActuator, own: Collector) -> JointPrims | None:
        return prims_of(actuator, dialect, step, options.name, own, read.get(actuator.network))

    joints = joint_by_joint(actuators, prims, ("NWT001",), collector)
    _check_bodies(actuators, robot, collector)
    networks = ((joint.actuator, joint.network) for joint in joints)
    files = network_files(networks, "NWT005", "differ, in themselves or in their manifests", collector)
    # The joints' paths are an affair of their own: said beside the rest.
    own = Collector()
    layout = lay_out(actuators, robot, options, own)
    for item in own:
        collector.add(item)
    collector.raise_if_failed(EmitError)

    lost = [loss for joint in joints for loss in joint.lost]
    why = "an actuator holds no residual policy: wrap the environment with the runtime"
    lost += unknown_passive(actuators, options.name, "Newton", lambda *_: "the stage's own")
    lost += delta_action_loss(actuators, options.name, why)
    model = "" if robot.format is ModelFormat.NONE else os.path.basename(robot.path)
    text = overlay_text(actuators, robot, joints, layout, lost, dialect, model)
    overlay = EmittedFile(overlay_name(actuators.robot), text.encode("utf-8"))
    explicit = frozenset(actuator.joint for actuator in actuators.joints)
    return Emission(
        (overlay, *files), tuple(lost), collector.sorted(), explicit, unlimited_joints(actuators, robot)
    )


def _check_bodies(actuators: ActuatorSet, robot: RobotView, collector: Collector) -> None:
    """Refuse joints that share a body: Newton makes one joint of them, which takes no actuator."""
    if robot.format is not ModelFormat.MJCF:
        return
    moving = [joint for joint in robot.joints if joint.kind is not JointKind.FREE]
    # Bodies without a name cannot be told apart.
    counts = Counter(joint.body for joint in moving if joint.body)
    managed = {actuator.joint for actuator in actuators.joints}
    shared = [joint for joint in moving if counts[joint.body] > 1 and joint.name in managed]
    if shared:
        collector.at(shared[0].name, shared[0].span).error(
            "NWT012",
            f"{listed(joint.name for joint in shared)}: not alone on its body, and Newton makes one joint of all "
            "joints between two bodies, which takes no actuator",
            "give each joint a body of its own in the model, or leave this target out",
        )


# --- the text --------------------------------------------------------------------------------------------


def overlay_text(
    actuators: ActuatorSet,
    robot: RobotView,
    joints: Sequence[JointPrims],
    layout: StagePaths,
    approximations: Sequence[Approximation],
    dialect: NewtonDialect,
    model: str,
) -> str:
    """The whole file.

    Args:
        actuators: What was compiled.
        robot: The robot.
        joints: What each joint becomes, in the robot's order.
        layout: Where the prims are.
        approximations: What was lost.
        dialect: Version that is written.
        model: File name of the robot's model; "" without one.
    """
    lines = ["#usda 1.0"]
    lines += _header(actuators, layout, approximations, dialect, model)
    lines += [
        "(",
        "    customLayerData = {",
        f"        string creator = {string(f'actspec {actspec.__version__}')}",
        f"        string specSha256 = {string(actuators.spec_sha256)}",
        "    }",
        ")",
        *prim_lines(_prims(robot, joints, layout)),
    ]
    return "\n".join([*lines, ""])


def _prims(robot: RobotView, joints: Sequence[JointPrims], layout: StagePaths) -> Iterator[Prim]:
    own = converted_actuators(robot, layout)
    for joint in joints:
        apis, attributes = joint.joint
        yield Prim(layout.joints[joint.actuator.joint], apis=apis, attributes=attributes)
    for index, path in enumerate(own):
        said = (
            ("The model's own actuators on these joints would act beside those below.",) if index == 0 else ()
        )
        yield Prim(path, active=False, comments=said)
    yield Prim((*layout.root, SCOPE), specifier="def Scope")
    taken: set[str] = set()
    said_group = ""
    for joint in joints:
        actuator, (apis, attributes) = joint.actuator, joint.drive
        target = UsdAttribute("rel", "newton:targets", f"<{path_text(layout.joints[actuator.joint])}>")
        about = f"{actuator.group}: {actuator.level.value}, {actuator.command.value} command."
        name = free_name(identifier(actuator.joint, fallback="joint"), taken)
        taken.add(name)
        yield Prim(
            (*layout.root, SCOPE, name),
            specifier="def NewtonActuator",
            apis=apis,
            attributes=(target, *attributes),
            # Once for the joints of a group that follow each other.
            comments=() if about == said_group else (about,),
        )
        said_group = about


def _header(
    actuators: ActuatorSet,
    layout: StagePaths,
    approximations: Sequence[Approximation],
    dialect: NewtonDialect,
    model: str,
) -> Iterator[str]:
    step = actuators.physics_dt.require()
    yield from _said(written_by(f" for Newton {dialect.text}"))
    for line in actuators.spec_lines:
        yield from _said(line)
    if model:
        yield from _said(f"model {model}")
    if not dialect.run:
        yield from _said(
            f"Text-checked against the schemas that Newton {dialect.text} reads, not run with it."
        )
    yield "#"
    yield from _said(
        "An overlay of the robot's stage: its strongest layer, which leaves units and axes to the stage."
    )
    yield "#   stage = Usd.Stage.Open(...)"
    yield f"#   stage.GetSessionLayer().subLayerPaths.append({string(overlay_name(actuators.robot))})"
    yield "#   newton.ModelBuilder().add_usd(stage)"
    yield from _said(
        f"Every physics step of {step * 1e3:g} ms: control.joint_f.zero_(), then actuator.step(...) for each of "
        "model.actuators" + (", which a delay counts." if _delayed(actuators) else ".")
    )
    yield from _said("Isaac Sim 6 and Isaac Lab 3 read the same prims: not run there.")
    yield from _said(
        "The stage has metersPerUnit 1 and kilogramsPerUnit 1. Actuators count in radians, the joints' prims in "
        "degrees."
    )
    if layout.converted:
        yield from _said(
            "Paths are those of mujoco-usd-converter or urdf-usd-converter: `root` and `joint_paths` of the spec's "
            "target state others."
        )
    below = sections(actuators, approximations, "Approximations (what the overlay cannot hold):")
    yield from section_lines(below, bullet="- ", hang="  ", width=WIDTH)


def _delayed(actuators: ActuatorSet) -> bool:
    return any(actuator.delay is not None for actuator in actuators.joints)


def _said(text: str) -> list[str]:
    return comment_lines(text, width=WIDTH)
