"""The Newton target: a `.usda` overlay of a robot's stage with its actuators and the numbers of its joints."""

from __future__ import annotations

import os
from collections import Counter

from actspec.diagnostics import Collector, EmitError, listed
from actspec.ir import ActuatorSet, JointActuator, JointKind
from actspec.robot.view import ModelFormat, RobotView
from actspec.simulators.newton import newton_dialect
from actspec.targets.base import Emission, EmittedFile, TargetOptions
from actspec.targets.kit.joint import delta_action_loss, dialect_of, joint_by_joint
from actspec.targets.kit.network import network_files
from actspec.targets.newton.joint_prims import JointPrims, prims_of
from actspec.targets.newton.paths import lay_out
from actspec.targets.newton.text import overlay_name, overlay_text


def emit(actuators: ActuatorSet, robot: RobotView, options: TargetOptions) -> Emission:
    """Write a robot's actuators as an overlay of its USD stage; see `choose.Emit`."""
    collector = Collector()
    dialect = dialect_of(lambda: newton_dialect(options.version), "NWT007", options, collector)
    step = actuators.physics_dt.require()

    def prims(actuator: JointActuator, own: Collector) -> JointPrims | None:
        return prims_of(actuator, dialect, step, options.name, own)

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
    lost += delta_action_loss(actuators, options.name, why)
    model = "" if robot.format is ModelFormat.NONE else os.path.basename(robot.path)
    text = overlay_text(actuators, robot, joints, layout, lost, dialect, model)
    overlay = EmittedFile(overlay_name(actuators.robot), text.encode("utf-8"))
    explicit = frozenset(actuator.joint for actuator in actuators.joints)
    return Emission((overlay, *files), tuple(lost), collector.sorted(), explicit)


def _check_bodies(actuators: ActuatorSet, robot: RobotView, collector: Collector) -> None:
    """Refuse joints that share a body: Newton makes one joint of them, which takes no actuator."""
    if robot.format is not ModelFormat.MJCF:
        return
    moving = [joint for joint in robot.joints if joint.kind is not JointKind.FREE]
    counts = Counter(joint.body for joint in moving)
    managed = {actuator.joint for actuator in actuators.joints}
    shared = [joint for joint in moving if counts[joint.body] > 1 and joint.name in managed]
    if shared:
        collector.at(shared[0].name, shared[0].span).error(
            "NWT012",
            f"{listed(joint.name for joint in shared)}: not alone on its body, and Newton makes one joint of all "
            "joints between two bodies, which takes no actuator",
            "give each joint a body of its own in the model, or leave this target out",
        )
