"""Files that the runtime needs beside a MuJoCo model: the networks as ONNX, and what each joint gives and takes.

`networks.json` holds what no MJCF can: each network's manifest, with the hash of its file here, and joint by joint
which actuator it drives and the clamp of its torque, in SI.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from actspec.diagnostics import Collector
from actspec.ir import ActuatorSet, JointActuator, Level, Network
from actspec.targets.base import EmittedFile
from actspec.targets.kit.network import (
    NetworkWithManifest,
    network_clip,
    network_files,
    onnx_of,
    read_network,
)
from actspec.targets.mujoco.drive import Drive

NAME = "networks.json"
FORMAT = "actspec-runtime/1"


def runtime_files(
    actuators: ActuatorSet, drives: Sequence[Drive], model: str, step: float, collector: Collector
) -> list[EmittedFile]:
    """What the runtime needs; nothing where no joint has a network with an ONNX file.

    Args:
        actuators: The spec's.
        drives: As they are written, for the actuators' names.
        model: Name of the main file.
        step: Physics step h [s].
        collector: Takes errors of networks.
    """
    names = {drive.joint: drive.name for drive in drives}
    groups: dict[Network, list[JointActuator]] = {}
    for actuator in actuators.joints:
        if actuator.level is Level.ACTUATOR_NET and actuator.network is not None:
            groups.setdefault(actuator.network, []).append(actuator)
    entries, files = [], []
    for members in groups.values():
        known = onnx_of(members[0])
        found = None if known is None else read_network(known, "onnx", collector)
        found = None if found is None else replace(found, assumed_step=actuators.assumed_step)
        if found is None or found.stride(step) is None:
            continue
        found.check_command(members[0].group, members[0].command, "MJC030", "a network takes position errors")
        entries.append(_entry(found, members, names))
        files += [(member, (found.name, found.data)) for member in members]
    if not entries or collector.failed:
        return []
    text = json.dumps({"format": FORMAT, "model": model, "physics_dt": step, "networks": entries}, indent=1)
    return [
        EmittedFile(NAME, (text + "\n").encode()),
        *network_files(files, "MJC031", "differ in their weights", collector),
    ]


def _entry(
    found: NetworkWithManifest, members: Sequence[JointActuator], names: dict[str, str]
) -> dict[str, Any]:
    file = {"path": found.name, "sha256": hashlib.sha256(found.data).hexdigest()}
    return {
        "manifest": found.manifest.entries() | {"files": {"onnx": file}},
        "joints": [
            {
                "joint": actuator.joint,
                "actuator": names[actuator.joint],
                "effort_limit": actuator.effort_limit.value,
                "stall_torque": None if actuator.stall_torque is None else actuator.stall_torque.value,
                "no_load_speed": None if actuator.no_load_speed is None else actuator.no_load_speed.value,
                "curve": _curve(actuator),
                "encoder_bias": actuator.encoder_bias.value or 0.0,
            }
            for actuator in members
        ],
    }


def _curve(actuator: JointActuator) -> list[float] | None:
    """drive_torque, brake_torque, knee_speed and no_load_speed; None without a curve."""
    from actspec.laws import law_of

    if actuator.curve is None:
        return None
    curve = law_of(network_clip(actuator)).curve
    return None if curve is None else list(curve)
