"""What `compile` wrote beside a MuJoCo model for the runtime, read: `networks.json` and the networks that it names."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import ActspecError, Span
from actspec.files import NotRegular, TooLarge, read_regular
from actspec.laws.network import NetworkLaw
from actspec.readings.onnx_network import NetworkFileError, OnnxMissing, read_onnx

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

NAME, FORMAT = "networks.json", "actspec-runtime/1"
MAX_BYTES = 64 * 1024 * 1024
"""Largest file [bytes]. Chosen: actuator networks have some tens of kilobytes."""


class RuntimeFault(ActspecError):
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
        groups = tuple(_group(folder, entry) for entry in found["networks"])
        return Bundle(folder, float(found["physics_dt"]), groups)
    except FileNotFoundError as err:
        help = (
            "`actspec compile SPEC -t mujoco` writes it where a group of level actuator_net names a manifest"
        )
        raise RuntimeFault.of("LRN040", f"there is no {NAME} in the folder", Span(folder), help=help) from err
    except OnnxMissing as err:
        help = "pip install 'actspec[learn]'"
        raise RuntimeFault.of("LRN041", "a network needs onnx, which is not installed", help=help) from err
    except (NetworkFileError, NotRegular, TooLarge, OSError) as err:
        raise RuntimeFault.of("LRN040", f"a network cannot be read: {err}", Span(path)) from err
    except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as err:
        help = "compile the spec again"
        raise RuntimeFault.of(
            "LRN040", f"the file is not what compile wrote: {err}", Span(path), help=help
        ) from err


def _bytes(path: str) -> bytes:
    return read_regular(path, MAX_BYTES)


def _group(folder: str, entry: Mapping[str, Any]) -> DrivenGroup:
    name = entry["file"]
    if os.path.basename(name) != name or name in ("", ".", ".."):
        raise ValueError(f"'{name}' is no file of the folder")
    law = NetworkLaw(
        read_onnx(_bytes(os.path.join(folder, name))),
        tuple(int(tap) for tap in entry["taps"]),
        float(entry["sample_steps"]),
        entry["inputs"] == "velocity_position",
        float(entry["position_scale"]),
        float(entry["velocity_scale"]),
        float(entry["torque_scale"]),
        entry["initial_history"] == "first_sample",
    )
    if law.inputs != law.layers.inputs or not law.taps or min(law.taps) < 0:
        raise ValueError(f"'{name}' has {law.layers.inputs} inputs, its taps give {law.inputs}")
    stated = entry["range"]
    ends = None
    if stated is not None:
        ends = tuple(
            (float(stated[key]["least"]), float(stated[key]["most"])) for key in ("error", "velocity")
        )
    return DrivenGroup(name, law, tuple(_joint(joint) for joint in entry["joints"]), ends)  # type: ignore[arg-type]


def _joint(entry: Mapping[str, Any]) -> DrivenJoint:
    limit, stall, no_load = (entry[key] for key in ("effort_limit", "stall_torque", "no_load_speed"))
    curve = entry["curve"]
    return DrivenJoint(
        str(entry["joint"]),
        str(entry["actuator"]),
        math.inf if limit is None else float(limit),
        None if stall is None or no_load is None else (float(stall), float(no_load)),
        None if curve is None else (float(curve[0]), float(curve[1]), float(curve[2]), float(curve[3])),
        float(entry["encoder_bias"]),
    )
