"""The Isaac Lab target: `<robot>_cfg.py` with the robot's actuators, and its networks beside it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace

from actspec.diagnostics import Collector, EmitError, listed
from actspec.ir import ActuatorSet, JointActuator, JointKind, Level
from actspec.robot.view import ModelFormat, RobotView
from actspec.simulators.isaaclab import CLIPPING_AT_SOLVERS, IsaacLabDialect
from actspec.targets.base import Emission, EmittedFile, TargetOptions
from actspec.targets.check import isaaclab_row
from actspec.targets.isaaclab.classes import check_classes, classes_of
from actspec.targets.isaaclab.joint_cfg import IMPLICIT, JointCfg, cfg_of
from actspec.targets.isaaclab.text import groups_of, module_text
from actspec.targets.kit.joint import (
    delta_action_loss,
    joint_by_joint,
    unknown_passive,
    warn_unknown,
    warn_unknown_armature,
)
from actspec.targets.kit.network import NetworkWithManifest, check_joints, read_networks
from actspec.targets.kit.python_text import grouped, identifier, module_name


def emit(actuators: ActuatorSet, robot: RobotView, options: TargetOptions) -> Emission:
    """Compile a robot's actuators into an Isaac Lab module, for which its joints' names are used; see `choose.Emit`."""
    collector = Collector()
    dialect = isaaclab_row(options, collector)
    classes = classes_of(actuators, options, collector)
    check_classes(actuators, classes, dialect, options, collector)
    # The solver's own drive clips a joint at the USD's limit where the cfg has none.
    unlimited = [
        a
        for a in actuators.joints
        if not (a.effort_limit.known or (classes[a.joint] == "implicit" and a.level is Level.IDEAL_PD))
    ]
    _check_limits(unlimited, collector)
    networks = _networks(actuators, collector)
    step = actuators.physics_dt.require()

    def cfg(actuator: JointActuator, own: Collector) -> JointCfg | None:
        network = networks.get(actuator.group)
        if actuator in unlimited or (actuator.level is Level.ACTUATOR_NET and network is None):
            return None
        return cfg_of(actuator, dialect, classes[actuator.joint], step, options.name, own, network)

    cfgs = joint_by_joint(actuators, cfg, ("ISL011",), collector)
    collector.raise_if_failed(EmitError)
    _warn(actuators, options.name, robot, dialect, cfgs, collector)

    approximations = [loss for cfg in cfgs for loss in cfg.approximations]
    why = "no actuator class sees the whole robot: wrap the environment with the runtime"
    approximations += unknown_passive(actuators, options.name, "Isaac Lab", lambda *_: "the USD's own")
    approximations += delta_action_loss(actuators, options.name, why)
    # A floating base is no joint of an articulation.
    names = [joint.name for joint in robot.joints if joint.kind is not JointKind.FREE]
    groups = groups_of(cfgs, names)
    model = "" if robot.format is ModelFormat.NONE else os.path.basename(robot.path)
    text = module_text(actuators, groups, approximations, dialect, model)
    files = [EmittedFile(f"{module_name(actuators.robot)}.py", text.encode("utf-8"))]
    written = {file.name: file.data for file, _ in networks.values()}
    files += [EmittedFile(name, data) for name, data in sorted(written.items())]
    explicit = frozenset(cfg.actuator.joint for cfg in cfgs if cfg.cls != IMPLICIT)
    return Emission(tuple(files), tuple(approximations), collector.sorted(), explicit)


def _check_limits(unlimited: Sequence[JointActuator], collector: Collector) -> None:
    """No joint is without an effort limit."""
    for (group, span), members in grouped(unlimited, lambda a: (a.group, a.effort_limit.span or a.span)):
        collector.at(f"actuators.{group}.effort_limit", span).error(
            "ISL010",
            f"{listed(member.joint for member in members)}: effort_limit is unknown, and Isaac Lab must have a "
            f"number: without one, {CLIPPING_AT_SOLVERS} do not clip at all, and others clip at the USD's",
            "state effort_limit",
        )


def _networks(actuators: ActuatorSet, collector: Collector) -> dict[str, tuple[NetworkWithManifest, int]]:
    """The network of each group, with the physics steps between its taps."""
    found: dict[str, tuple[NetworkWithManifest, int]] = {}
    # Files that the target writes itself.
    names: dict[str, bytes] = {"manifest.json": b"", f"{module_name(actuators.robot)}.py": b""}
    learned = (actuator for actuator in actuators.joints if actuator.level is Level.ACTUATOR_NET)
    read = read_networks(actuators, "torchscript", collector)
    for group, members in grouped(learned, lambda actuator: actuator.group):
        file = read.get(members[0].network)
        if file is None:
            continue
        stride = file.stride(actuators.physics_dt.require())
        _check_network(file, stride, members)
        if names.setdefault(file.name, file.data) != file.data:
            file = replace(file, name=f"{identifier(group)}_{file.name}")
            names[file.name] = file.data
        if stride is not None:
            found[group] = (file, stride)
    return found


def _check_network(file: NetworkWithManifest, stride: int | None, members: Sequence[JointActuator]) -> None:
    """What Isaac Lab's classes take for granted of a group's network; `stride`: physics steps between its taps."""
    manifest = file.manifest
    takes = "the network's classes take the error of a position"
    for command in {actuator.command for actuator in members}:
        file.check_command(members[0].group, command, "ISL022", takes)
    if manifest.kind == "gru":
        file.place.error(
            "ISL020",
            "Isaac Lab has classes for mlp and lstm, the network is a gru",
            "train an lstm, or leave this target out",
        )
    if manifest.kind == "lstm":
        scales = (manifest.position_scale, manifest.velocity_scale, manifest.torque_scale)
        wrong = []
        if scales != (1.0, 1.0, 1.0):
            wrong.append("scales {:g}, {:g}, {:g}".format(*scales))
        if manifest.inputs != "position_velocity":
            wrong.append(f"inputs {manifest.inputs}")
        if manifest.taps != (0,):
            wrong.append(f"taps {list(manifest.taps)}")
        if stride not in (None, 1):
            whose = f" ({file.assumed_step})" if file.assumed_step else ""
            wrong.append(f"a tap_period of {stride} physics steps{whose}")
        if wrong:
            file.place.error(
                "ISL021",
                "ActuatorNetLSTM takes the error and the velocity of each physics step unscaled; the manifest has "
                f"{listed(wrong)}",
                "put the scales into the network, and train at the physics step"
                + (", which is timing.physics_dt" if file.assumed_step else ""),
            )
    check_joints(manifest, [a.joint for a in members], file.place)


def _warn(
    actuators: ActuatorSet,
    target: str,
    robot: RobotView,
    dialect: IsaacLabDialect,
    cfgs: list[JointCfg],
    collector: Collector,
) -> None:
    usd = "Isaac Lab takes the USD's"
    warn_unknown_armature(actuators, target, "ISL030", usd, collector)
    for lacking, members in grouped(cfgs, _open_gains):
        if lacking:
            warn_unknown([cfg.actuator for cfg in members], lacking, "ISL031", usd, collector)
    if open_limits := [a for a in actuators.joints if not a.effort_limit.known]:
        warn_unknown(open_limits, ("effort_limit",), "ISL034", usd, collector)
    renamed = [a.joint for a in actuators.joints if identifier(a.joint) != a.joint]
    if renamed:
        collector.at(
            renamed[0], next((joint.span for joint in robot.joints if joint.name == renamed[0]), None)
        ).warning(
            "ISL032",
            f"USD importers rename joints whose names are not valid USD prim names, and the cfg has the model's names: "
            f"{listed(renamed)}",
            "rename them in the model, or check the names in the USD",
        )
    networks = [a.joint for a in actuators.joints if a.level is Level.ACTUATOR_NET]
    if networks and dialect.row.native:
        collector.warning(
            "ISL033",
            f"Isaac Lab {dialect.text} may take other network files than TorchScript: not tested",
            help="its native actuators read ONNX with metadata; or set use_newton_actuators=False",
        )


def _open_gains(cfg: JointCfg) -> tuple[str, ...]:
    """The gains of a joint that its cfg leaves to the USD, by their names in `JointActuator`."""
    names = {"stiffness": "kp", "damping": "kd"}
    return tuple(names[field.name] for field in cfg.fields if field.value is None and field.name in names)
