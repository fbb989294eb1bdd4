"""What `compile` wrote beside a MuJoCo model for the runtime, read: `networks.json` and the networks that it names."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import ActspecError, Span, shortened
from actspec.files import NotRegular, TooLarge, read_regular
from actspec.laws.network import NetworkLaw
from actspec.libraries import extra_line
from actspec.readings.onnx_network import NetworkFileError, OnnxMissing, read_onnx
from actspec.spec.network import NetworkManifest
from actspec.targets.mujoco.networks import FORMAT, NAME

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MAX_BYTES = 64 * 1024 * 1024
"""Largest file [bytes]. Chosen: actuator networks have some tens of kilobytes."""


class RuntimeFault(ActspecError, ValueError):
    """A folder is not what `compile` writes for MuJoCo, or does not fit the model or the arrays."""


@dataclass(frozen=True, slots=True)
class DrivenJoint:
    """A joint whose torque a network gives.

    Attributes:
        joint: Name.
        actuator: Name of its actuator in the model.
        effort_limit: Clamp of the torque [N*m or N]; infinity: none.
        line: stall_torque and no_load_speed of the torque-speed line [N*m, rad/s or N, m/s]; None: none.
        curve: drive_torque, brake_torque, knee_speed, no_load_speed; None: none.
        encoder_bias: q_measured = q + bias [rad or m].
    """

    joint: str
    actuator: str
    effort_limit: float
    line: tuple[float, float] | None
    curve: tuple[float, float, float, float] | None
    encoder_bias: float


@dataclass(frozen=True, slots=True, eq=False)
class DrivenGroup:
    """Joints of one network.

    Attributes:
        name: Of the network's file.
        law: The network with its conventions; taps in physics steps.
        joints: In the order of the spec's robot.
        range: Low and high end of position error [rad or m] and velocity [rad/s or m/s] in training; None: unknown.
    """

    name: str
    law: NetworkLaw
    joints: tuple[DrivenJoint, ...]
    range: tuple[tuple[float, float], tuple[float, float]] | None

    @property
    def reach(self) -> int:
        """Physics steps to the oldest sample."""
        return max(self.law.taps)


@dataclass(frozen=True, slots=True, eq=False)
class Bundle:
    """All of a folder.

    Attributes:
        folder: As the caller named it.
        physics_dt: Physics step [s].
        groups: One a network.
    """

    folder: str
    physics_dt: float
    groups: tuple[DrivenGroup, ...]


def read_bundle(folder: str | os.PathLike[str]) -> Bundle:
    """Read the folder that `actspec compile` wrote for MuJoCo.

    Raises:
        RuntimeFault: it has no networks, or a file of it cannot be read, with the reason.
    """
    folder = os.fspath(folder)
    path = os.path.join(folder, NAME)
    try:
        found = json.loads(_bytes(path))
        if not isinstance(found, dict) or found.get("format") != FORMAT:
            raise ValueError(f"its format is not {FORMAT}")
        physics_dt = float(found["physics_dt"])
        if not (math.isfinite(physics_dt) and physics_dt > 0.0):
            raise ValueError(f"a physics step of {physics_dt:g} s")
        groups = tuple(_group(folder, physics_dt, entry) for entry in found["networks"])
        if not groups:
            raise ValueError("it names no network")
        return Bundle(folder, physics_dt, groups)
    except FileNotFoundError as err:
        help = (
            "`actspec compile SPEC -t mujoco` writes it where a group of level actuator_net names a manifest"
        )
        raise RuntimeFault.of("LRN040", f"there is no {NAME} in the folder", Span(folder), help=help) from err
    except OnnxMissing as err:
        help = extra_line("learn")
        raise RuntimeFault.of("LRN041", "a network needs onnx, which is not installed", help=help) from err
    except (NetworkFileError, NotRegular, TooLarge, OSError) as err:
        raise RuntimeFault.of("LRN040", f"a network cannot be read: {err}", Span(path)) from err
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as err:
        help = "compile the spec again"
        said = shortened(" ".join(str(err).split()), 300)
        message = f"the file is not what compile wrote: {said}"
        raise RuntimeFault.of("LRN040", message, Span(path), help=help) from err


def _bytes(path: str) -> bytes:
    return read_regular(path, MAX_BYTES)


def _group(folder: str, physics_dt: float, entry: Mapping[str, Any]) -> DrivenGroup:
    manifest = NetworkManifest.model_validate(entry["manifest"])
    if manifest.files is None or manifest.files.onnx is None:
        raise ValueError("a network has no ONNX file")
    name = manifest.files.onnx.path
    data = _bytes(os.path.join(folder, name))
    if hashlib.sha256(data).hexdigest() != manifest.files.onnx.sha256:
        raise ValueError(f"'{name}' is another file than compile wrote")
    scales = (manifest.position_scale, manifest.velocity_scale, manifest.torque_scale)
    if not all(map(math.isfinite, scales)):
        raise ValueError(f"a scale of '{name}' is not finite")
    stride = manifest.stride(physics_dt)
    if stride is None:
        raise ValueError(f"the samples of '{name}' do not fall on steps of {physics_dt:g} s")
    law = manifest.law(read_onnx(data), stride)
    kind = "lstm" if law.layers.recurrent else "mlp"
    if (law.inputs, 1, kind) != (law.layers.inputs, law.layers.outputs, manifest.kind):
        raise ValueError(f"'{name}' has {law.layers.inputs} inputs, its taps give {law.inputs}")
    ends = None
    if manifest.range is not None:
        ends = tuple((part.least, part.most) for part in (manifest.range.error, manifest.range.velocity))
    return DrivenGroup(name, law, tuple(_joint(joint) for joint in entry["joints"]), ends)  # type: ignore[arg-type]


def _joint(entry: Mapping[str, Any]) -> DrivenJoint:
    joint, actuator = entry["joint"], entry["actuator"]
    if not (isinstance(joint, str) and isinstance(actuator, str)):
        raise ValueError("a joint or actuator is no name")
    limit, stall, no_load = (_number(entry, key) for key in ("effort_limit", "stall_torque", "no_load_speed"))
    if (limit or 0.0) < 0.0 or any(part is not None and part <= 0.0 for part in (stall, no_load)):
        raise ValueError(f"limit or torque-speed line of '{joint}' is negative")
    curve = None
    if entry["curve"] is not None:
        drive, brake, knee, most = (float(part) for part in entry["curve"])
        if not (min(drive, brake) >= 0.0 and 0.0 <= knee <= most < math.inf):
            raise ValueError(f"the curve of '{joint}' is none")
        curve = drive, brake, knee, most
    return DrivenJoint(
        joint,
        actuator,
        math.inf if limit is None else limit,
        None if stall is None or no_load is None else (stall, no_load),
        curve,
        _number(entry, "encoder_bias") or 0.0,
    )


def _number(entry: Mapping[str, Any], key: str) -> float | None:
    value = None if entry[key] is None else float(entry[key])
    if value is not None and not math.isfinite(value):
        raise ValueError(f"{key} is {value}")
    return value
