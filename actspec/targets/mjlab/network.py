"""The fields of a network's class, and its file."""

from __future__ import annotations

import math

from actspec.ir import Command
from actspec.targets.mjlab.context import Field, Joint
from actspec.targets.network_file import read_network, tap_stride
from actspec.targets.python_text import py


def network_fields(joint: Joint) -> tuple[list[Field], tuple[str, bytes]] | None:
    """Fields of the network and its file; None after an error."""
    actuator = joint.actuator
    where = f"{joint.where}.network"
    found = read_network(actuator.network, joint.where, actuator.span, joint.collector)
    if found is None or actuator.network is None:
        return None
    manifest, span = found.manifest, actuator.network.span
    if actuator.command is not Command.POSITION:
        joint.collector.error(
            "MJL003",
            f"mjlab's network takes position errors, got command {actuator.command.value}",
            where=f"{joint.where}.command",
            span=span,
            help="write command: position, or leave this target out",
        )
    if manifest.kind != "mlp":
        joint.collector.error(
            "MJL004",
            f"mjlab has no actuator class for a network of kind {manifest.kind}",
            where=where,
            span=span,
            help="its LearnedMlpActuatorCfg takes an mlp; Isaac Lab has a class for an lstm",
        )
    taps = manifest.taps
    if taps != tuple(range(len(taps))):
        joint.collector.error(
            "MJL005",
            f"mjlab gives a network the samples 0 to n - 1 in this order, got taps {list(taps)}",
            where=where,
            span=span,
            help=f"train on taps {list(range(len(taps)))}",
        )
    stride = tap_stride(manifest, joint.step, where, span, joint.collector)
    if stride is not None and stride != 1 and len(taps) > 1:
        joint.collector.error(
            "MJL006",
            f"mjlab samples a network's history at every physics step, {joint.step * 1e3:g} ms, and its taps are "
            f"{stride * joint.step * 1e3:g} ms apart",
            where=where,
            span=span,
            help=f"train at {joint.step * 1e3:g} ms, or set timing.physics_dt to {stride * joint.step * 1e3:g} ms",
        )
    if manifest.initial_history != "first_sample" and len(taps) > 1:
        joint.approximate(
            "network.initial_history",
            manifest.initial_history,
            "first_sample",
            "mjlab fills a network's history with its first sample after a reset",
            2.0 * joint.law.effort_limit if math.isfinite(joint.law.effort_limit) else None,
        )
    order = "pos_vel" if manifest.inputs == "position_velocity" else "vel_pos"
    return [
        Field("network_file", f"str(FOLDER / {py(found.name)})"),
        Field("pos_scale", py(manifest.position_scale), "of target - measured"),
        Field("vel_scale", py(manifest.velocity_scale)),
        Field("torque_scale", py(manifest.torque_scale)),
        Field("input_order", py(order)),
        Field("history_length", py(len(taps)), f"every {joint.step * 1e3:g} ms"),
    ], (found.name, found.data)
