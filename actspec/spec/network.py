"""The manifest of an actuator network, which a spec names.

JSON or YAML, read as strictly as a spec. They hold the conventions that a network file alone does not tell, where
it comes from and how far it may be trusted.
"""

from __future__ import annotations

import os
import posixpath
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field

from actspec.diagnostics import Collector, Path, SpecError
from actspec.files import FAULTS, read_regular
from actspec.laws.network import Layers, NetworkLaw
from actspec.spec.document import load_document, path_inside
from actspec.spec.results import FitFile
from actspec.spec.values import Number, SpecValue, Strict
from actspec.spec.yaml_text import MAX_BYTES
from actspec.units import Kind

if TYPE_CHECKING:
    from actspec.spec.models import SpecModel
    from actspec.spec.validate import Spec

MOST_STEPS = 1000
"""Most physics steps between two samples, so that a stranger's history cannot fill the memory. Chosen."""
MOST_TAPS = 1000
"""Most samples of a history, and the oldest of them. Chosen: actuator networks have some ten."""

LONGEST = 10.0
"""Longest time between two samples [s]. Chosen: a thousand times that of known networks."""

Finite = Annotated[float, Field(allow_inf_nan=False)]
Sha256 = Annotated[str, Field(pattern="^[0-9a-f]{64}$")]


class NetworkFileEntry(Strict):
    """A network file."""

    path: Annotated[str, Field(pattern=r"^[^/\\\x00-\x1f:]+$", max_length=200)]
    """Its name, in the manifest's own folder."""
    sha256: Sha256
    """Hash of its bytes."""


class NetworkFiles(Strict):
    """One network in several formats."""

    onnx: NetworkFileEntry | None = None
    """ONNX: data, which actspec, MuJoCo's runtime and Newton read."""
    torchscript: NetworkFileEntry | None = None
    """TorchScript: a program, which Isaac Lab and mjlab run."""


class InputRange(Strict):
    """How far an input goes in the training data."""

    low: Finite
    """Quantile 0.001 [rad or m, rad/s or m/s]."""
    high: Finite
    """Quantile 0.999."""
    least: Finite
    """Smallest value that there was."""
    most: Finite
    """Largest value that there was."""

    @property
    def largest(self) -> float:
        """Size of the value that is furthest from 0."""
        return max(abs(self.least), abs(self.most))


class InputRanges(Strict):
    """How far the inputs go, before scales."""

    error: InputRange
    """Of target - measured [rad or m]."""
    velocity: InputRange
    """Of the velocity [rad/s or m/s]."""


class NetworkValidation(Strict):
    """Errors on recordings that the network was not trained on."""

    rmse: Annotated[float, Field(ge=0.0)]
    """Of the torque [N*m or N]."""
    relative_error: Annotated[float, Field(ge=0.0)]
    """RMSE over the root mean square of the torque [-]."""
    r2: Annotated[float, Field(le=1.0)]
    """Share of the torque's variance that it explains [-]."""
    rows: Annotated[int, Field(ge=1)]
    """Rows of all joints."""
    logs: tuple[str, ...] = ()
    """Recordings, by path."""


class TrainedJoint(Strict):
    """What the model with which torques were inferred had of a joint; null: unknown, which counts as 0."""

    armature: Finite | None = None
    """[kg*m^2 or kg]."""
    coulomb: Finite | None = None
    """[N*m or N]."""
    viscous: Finite | None = None
    """[N*m*s/rad or N*s/m]."""
    inertia: Finite | None = None
    """With the other joints held in the reference pose, armature included [kg*m^2 or kg]."""


class TrainedModel(Strict):
    """Figures of that model."""

    mass: Finite
    """Of the whole robot [kg]."""
    gravity: Finite
    """[m/s^2]."""
    joints: dict[str, TrainedJoint]
    """By name."""


class NetworkManifest(Strict):
    """Inputs, scales, order and period of an actuator network.

    The law is tau = torque_scale * net([position_scale * e(t - k T) ..., velocity_scale * qd(t - k T) ...])
    with e = target - measured and T = tap_period.
    """

    format: Literal["actspec-network/1"]
    """Format of this file."""
    kind: Literal["mlp", "lstm", "gru"]
    """Kind of network."""
    inputs: Literal["position_velocity", "velocity_position"]
    """Which block of inputs comes first."""
    error: Literal["target_minus_measured"] = "target_minus_measured"
    """Sign of the position error; scales carry a minus where the network was trained the other way."""
    taps: Annotated[
        tuple[Annotated[int, Field(ge=0, le=MOST_TAPS)], ...], Field(min_length=1, max_length=MOST_TAPS)
    ]
    """Which past samples, in order; 0 is now."""
    tap_period: Annotated[SpecValue, Number(Kind.TIME, above=0.0, at_most=LONGEST)]
    """Time between samples, T [s]."""
    position_scale: float
    """Factor on the position error [1/rad or 1/m]."""
    velocity_scale: float
    """Factor on the velocity [s/rad or s/m]."""
    torque_scale: float
    """Factor on the output [N*m or N]."""
    initial_history: Literal["zero", "first_sample"]
    """What stands in the history at a reset."""
    hidden_size: Annotated[int, Field(ge=1)] | None = None
    """Of an lstm or gru."""
    num_layers: Annotated[int, Field(ge=1)] | None = None
    """Of an lstm or gru."""
    joints: tuple[str, ...] = ()
    """Joints that the network was trained on; empty: not recorded."""
    sha256: Sha256 | None = None
    """Hash of the network file that a spec names as `file`."""
    files: NetworkFiles | None = None
    """The network in the formats that simulators read, beside the manifest."""
    torque: Literal["drive", "joint", "inferred"] | None = None
    """What the network gives: the drive's torque, what is left of it behind joint friction, or the torque that
    the compiled model needs for the logged motion."""
    logs: tuple[FitFile, ...] = ()
    """Recordings that it was trained on."""
    model: Sha256 | None = None
    """Hash of the compiled dynamics with which its torques were inferred."""
    dynamics: TrainedModel | None = None
    """Figures of them, which tell what has changed since."""
    range: InputRanges | None = None
    """What the training data held."""
    validation: NetworkValidation | None = None
    """How well it does on recordings that it was not trained on."""
    doubts: tuple[str, ...] = ()
    """What the weights contradicted of the conventions with which the network was converted."""
    note: str | None = None
    """Remark."""

    @property
    def hashes(self) -> tuple[str, ...]:
        """Of the network files that it describes, as far as it says."""
        files = () if self.files is None else (self.files.onnx, self.files.torchscript)
        named = (self.sha256, *(None if file is None else file.sha256 for file in files))
        return tuple(value for value in named if value is not None)

    def entries(self) -> dict[str, Any]:
        """What a file of it holds, as JSON has it; the period is known."""
        assert self.tap_period.value is not None
        found = self.model_dump(mode="json", exclude_none=True)
        return found | {"tap_period": f"{self.tap_period.value * 1e3:.12g} ms"}

    def stride(self, step: float) -> int | None:
        """Physics steps between two samples; None: no whole number, or the period is unknown.

        Args:
            step: Physics step h > 0 [s].
        """
        period = self.tap_period.value
        if period is None or not 0.5 <= period / step <= MOST_STEPS:
            return None
        count = round(period / step)
        return None if abs(count * step - period) > 1e-6 * period else count

    def law(self, layers: Layers, stride: int = 1) -> NetworkLaw:
        """A network by these conventions.

        Args:
            layers: The network.
            stride: Steps between two samples; taps are counted in them.
        """
        return NetworkLaw(
            layers,
            tuple(tap * stride for tap in self.taps),
            self.tap_period.value or 0.0,
            self.inputs == "velocity_position",
            self.position_scale,
            self.velocity_scale,
            self.torque_scale,
            self.initial_history == "first_sample",
        )


NAMED = "a network is a relative path inside the folder of the spec, such as nets/legs.json"


def check_named(spec: Spec, collector: Collector) -> None:
    """Refuse networks that do not lie below the spec's folder, and manifests whose files do not."""
    folder = os.path.dirname(os.path.abspath(spec.document.path))
    inside: dict[str, bool] = {}

    def is_inside(name: str, place: Path) -> bool:
        if name not in inside:
            at = collector.at(".".join(map(str, place)), spec.span(*place))
            inside[name] = path_inside(name, folder, at, NAMED) is not None
        return inside[name]

    for place, name in named_files(spec.model):
        if is_inside(name, place):
            for other in files_beside(name, folder):
                is_inside(other, place)


def named_files(model: SpecModel) -> Iterator[tuple[Path, str]]:
    """Files that a spec names for its networks and its delta action, and where."""
    for group, actuator in model.actuators.items():
        for key in ("file", "manifest") if actuator.network is not None else ():
            name = getattr(actuator.network, key)
            if name is not None:
                yield ("actuators", group, "network", key), name
    if model.delta_action is not None:
        yield ("delta_action", "manifest"), model.delta_action.manifest


def files_beside(name: str, folder: str) -> Iterator[str]:
    """Files that are read with one of `named_files`: those that it names as a manifest, and a network's manifest.

    Args:
        name: As the spec has it.
        folder: Of the spec, from which the names lead.
    """
    yield f"{posixpath.splitext(name)[0]}.json"
    for other in _files_of(os.path.join(folder, name)):
        yield posixpath.join(posixpath.dirname(name), other)


def _files_of(manifest: str) -> Iterator[str]:
    """Files that a manifest names; none where it is no manifest, which those say who need it."""
    try:
        if b"actspec-" not in read_regular(manifest, MAX_BYTES):
            return
        files = load_document(manifest).data.get("files")
    except (SpecError, *FAULTS):
        return
    for entry in files.values() if isinstance(files, dict) else ():
        if isinstance(entry, dict) and isinstance(entry.get("path"), str):
            yield entry["path"]
