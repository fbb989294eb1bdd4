"""A delta action as three files, written and read: ONNX, TorchScript and the manifest that names both."""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import ActspecError, Collector, Span, SpecError, listed, shortened
from actspec.files import NotRegular, TooLarge, json_of, read_regular
from actspec.ir import ActuatorSet
from actspec.laws import law_of
from actspec.learn.delta.network import DeltaLayers, onnx_of, torchscript_of
from actspec.learn.dynamics import dynamics_entries
from actspec.learn.files import SAME, file_entries, network_paths_of, write_files
from actspec.learn.torchscript import loaded
from actspec.libraries import extra_line
from actspec.logs import BASE, Log
from actspec.readings.onnx_graph import Graph
from actspec.readings.onnx_network import NetworkFileError, OnnxMissing
from actspec.robot.view import RobotView
from actspec.spec.delta import DeltaManifest
from actspec.spec.document import load_document
from actspec.spec.validate import checked
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from actspec.learn.delta.samples import Samples
    from actspec.learn.delta.train import Parts
    from actspec.learn.delta.validate import Judged

    Array = NDArray[np.float64]

MAX_BYTES = 256 * 1024 * 1024
"""Largest file [bytes]. Chosen: delta actions have some tens of kilobytes, those of a whole humanoid some megabytes."""
SIGNALS = ("position", "velocity", "last_command", "command")
"""Of a joint, in columns."""


class DeltaFault(ActspecError):
    """A manifest or its network is no delta action, or does not fit the arrays or the environment."""


@dataclass(frozen=True, slots=True, eq=False)
class DeltaNetwork:
    """A delta action, read.

    Attributes:
        path: Of the manifest.
        manifest: What it takes and gives.
        graph: Columns to corrections, of numpy or torch, before the limit is held.
    """

    path: str
    manifest: DeltaManifest
    graph: Graph

    def __call__(self, columns: Any) -> Any:
        """Corrections [rad], shape (n, n_output), of the manifest's inputs, shape (n, n_input), within the limit."""
        most = self.manifest.max_delta
        return self.graph(columns).clip(-most, most)


def model_hash(actuators: ActuatorSet, robot: RobotView) -> str:
    """Hash of what a delta action corrects: links, friction, the drives' laws, and the rates."""
    digest = hashlib.sha256(dynamics_entries(robot, actuators.joints)["model"].encode())
    for joint in actuators.joints:
        digest.update(repr((joint.joint, law_of(joint))).encode())
    digest.update(repr((actuators.physics_dt.value, actuators.decimation)).encode())
    return digest.hexdigest()


def write_delta(
    path: str, layers: DeltaLayers, manifest: Mapping[str, Any], *, force: bool = False
) -> dict[str, str]:
    """Write a delta action's files.

    Args:
        path: `DIR/NAME`.
        layers: The network.
        manifest: Keys of `actspec-delta/1`; format, inputs, outputs, limit and files are filled in.
        force: Whether other files that are there are replaced.

    Returns: The paths, as `network_paths_of`.

    Raises:
        NetworkFileError: a file read back gives other corrections than the network.
        LogError: a file cannot be written; those from before are whole.
    """
    paths = network_paths_of(path)
    data = {"onnx": onnx_of(layers), "torchscript": torchscript_of(layers)}
    _check(layers, data)
    entries = dict(manifest)
    entries |= {
        "format": "actspec-delta/1",
        "inputs": list(layers.columns),
        "outputs": list(layers.columns[-layers.outputs :]),
        "max_delta": layers.max_delta,
        "files": file_entries(paths, data),
    }
    DeltaManifest.model_validate(entries)
    kept = {name: entries[name] for name in DeltaManifest.model_fields if entries.get(name) is not None}
    write_files(path, data, json_of(kept) + "\n", force=force)
    return paths


def _check(layers: DeltaLayers, data: Mapping[str, bytes]) -> None:
    """Whether both files give the same corrections."""
    import numpy as np
    import torch

    x = np.random.default_rng(0).standard_normal((64, len(layers.columns)))
    one = Graph(data["onnx"])(x)
    with torch.inference_mode():
        other = loaded(data["torchscript"])(torch.tensor(x, dtype=torch.float32))
    if not np.abs(one - other.numpy()).max() <= 10.0 * SAME * layers.max_delta:
        raise NetworkFileError("its ONNX and TorchScript files give different corrections")


def read_delta(path: str | os.PathLike[str]) -> DeltaNetwork:
    """Read a delta action: its manifest, and the ONNX file that this names, in its own folder.

    Raises:
        DeltaFault: either cannot be read, or they do not fit each other, with the reason.
    """
    path = os.fspath(path)
    manifest = _manifest(path)
    entry = manifest.files.onnx
    if entry is None:
        message = "the manifest names no ONNX file, and none else is read: TorchScript is a program"
        raise DeltaFault.of("LRN059", message, Span(path), help="`actspec delta train` writes both")
    data = _bytes(os.path.join(os.path.dirname(path), entry.path), path)
    found = hashlib.sha256(data).hexdigest()
    if found != entry.sha256:
        message = (
            f"'{shortened(entry.path)}' is not the file that the manifest describes: sha256 {found[:12]}..., the "
            f"manifest has {entry.sha256[:12]}..."
        )
        raise DeltaFault.of("LRN059", message, Span(path), help="name the manifest that was written with it")
    try:
        graph = Graph(data)
        _check_graph(graph, manifest)
    except OnnxMissing as err:
        help = extra_line("learn")
        raise DeltaFault.of("LRN012", "a delta action needs onnx, which is not installed", help=help) from err
    except NetworkFileError as err:
        pickled = data[:2] == b"\x80\x02" or data[:1] == b"\x80" or data[:2] == b"PK"
        why = "a pickle or TorchScript, which are programs and are not run" if pickled else str(err)
        message = f"'{shortened(entry.path)}' is no delta action: {why}"
        raise DeltaFault.of("LRN059", message, Span(path)) from err
    return DeltaNetwork(path, manifest, graph)


def _manifest(path: str) -> DeltaManifest:
    help = "`actspec schema delta` has the manifest's keys"
    if not os.path.isfile(path):
        raise DeltaFault.of("LRN059", "there is no such file", Span(path), help="name NAME.json")
    with open(path, "rb") as file:
        if file.read(1) in (b"\x80", b"P"):
            raise DeltaFault.of(
                "LRN059", "the file is no manifest but a program or an archive", Span(path), help=help
            )
    collector = Collector()
    try:
        manifest = checked(DeltaManifest, load_document(path), collector)
    except SpecError as err:
        raise DeltaFault.of(
            "LRN059", f"the manifest cannot be read: {err.diagnostics[0].message}", Span(path), help=help
        ) from err
    if other := tuple(item for item in collector if item.where == "format"):
        # Of a manifest of something else, every key is wrong.
        raise DeltaFault(other)
    collector.raise_if_failed(DeltaFault)
    assert manifest is not None
    wrong = _contradictions(manifest)
    for message in wrong:
        collector.error("LRN059", message, span=Span(path), help=help)
    collector.raise_if_failed(DeltaFault)
    return manifest


def _contradictions(manifest: DeltaManifest) -> list[str]:
    """What the columns of a manifest cannot be."""
    wrong = []
    outputs, inputs = manifest.outputs, manifest.inputs
    if bad := [name for name in outputs if not name.endswith(".command") or name == ".command"]:
        wrong.append(f"outputs are columns JOINT.command, got {listed(bad)}")
    if inputs[-len(outputs) :] != outputs or len(inputs) <= len(outputs):
        wrong.append("the last inputs are not the outputs, in their order")
    if len(set(inputs)) < len(inputs):
        wrong.append("two inputs are the same column")
    base = {f"base.{signal}.{component}" for signal, (parts, _) in BASE.items() for component in parts}
    joints = set(manifest.joints)
    strange = [
        name
        for name in manifest.state
        if name not in base
        and (name.rpartition(".")[2] not in SIGNALS[:3] or name.rpartition(".")[0] not in joints)
    ]
    if strange:
        wrong.append(f"unknown columns: {listed(strange)}")
    for key in ("action_scale", "default_position"):
        if others := [name for name in getattr(manifest, key) if name not in joints]:
            wrong.append(f"{key} has joints that are not corrected: {listed(others)}")
    if not all(math.isfinite(value) for value in (manifest.max_delta, manifest.period)):
        wrong.append("max_delta and period must be finite")
    return wrong


def _bytes(path: str, manifest: str) -> bytes:
    try:
        return read_regular(path, MAX_BYTES)
    except (NotRegular, TooLarge, OSError, ValueError) as err:
        why = "is not there" if isinstance(err, FileNotFoundError) else f"cannot be read: {err}"
        message = f"'{shortened(os.path.basename(path))}' {why}"
        raise DeltaFault.of("LRN059", message, Span(manifest), help="it stands beside its manifest") from err


def _check_graph(graph: Graph, manifest: DeltaManifest) -> None:
    """Sizes, and that corrections of any columns are within the limit."""
    import numpy as np

    count = len(manifest.inputs)
    x = np.random.default_rng(0).standard_normal((64, count)) * np.logspace(-1, 3, 64)[:, None]
    y = graph(x)
    if y.shape != (64, len(manifest.outputs)):
        shape = "x".join(str(n) for n in y.shape)
        raise NetworkFileError(
            f"64 rows of {count} columns give {shape} numbers, not 64x{len(manifest.outputs)}"
        )
    if not np.abs(y).max() <= manifest.max_delta * (1.0 + 1e-5):
        raise NetworkFileError(
            f"it gives corrections above max_delta {format_number(manifest.max_delta, 3)}: "
            f"{format_number(float(np.abs(y).max()), 4)}"
        )


def manifest_entries(
    actuators: ActuatorSet,
    robot: RobotView,
    samples: Samples,
    logs: Sequence[Log],
    per: str,
    errors: Judged,
    parts: Parts,
) -> dict[str, Any]:
    """What a trained delta action's manifest holds beside its columns and files."""

    def figures(name: str) -> dict[str, float]:
        found = ((joint.joint, getattr(joint, name)) for joint in actuators.joints)
        return {joint: figure.value for joint, figure in found if figure is not None and figure.known}

    return {
        "period": float(f"{samples.plants[0][0].step:.9g}"),
        "per": per,
        "action_scale": figures("action_scale"),
        "default_position": figures("default_position"),
        "model": model_hash(actuators, robot),
        "logs": [{"path": log.path, "sha256": log.sha256} for log in logs],
        "validation": {
            "position": float(f"{errors.improvement.position:.6g}"),
            "velocity": float(f"{errors.improvement.velocity:.6g}"),
            "rows": len(parts.unseen),
            "logs": list(parts.logs),
        },
    }


def check_fit(
    network: DeltaNetwork, actuators: ActuatorSet, robot: RobotView, samples: Samples, out: Collector
) -> Callable[[Array], Array]:
    """Hold a delta action to a spec and the columns of logs.

    Args:
        network: The delta action.
        actuators: The spec, resolved.
        robot: Its model.
        samples: Of the logs.
        out: Takes the differences: joints and columns are errors, another model a warning.

    Returns: Corrections in the samples' order of joints, of their columns.
    """
    manifest = network.manifest
    check_model(manifest, network.path, actuators, robot, out)
    lacking = [name for name in manifest.inputs if name not in samples.columns]
    if lacking and not out.failed:
        message = f"the network takes columns that the logs do not give: {listed(lacking)}"
        help = "was the base free in its logs, and is it held here?"
        out.error("LRN059", message, span=Span(network.path), help=help)
    picked = [samples.columns.index(name) for name in manifest.inputs if name not in lacking]
    order = [manifest.joints.index(name) for name in samples.joints if name in manifest.joints]

    def corrections(columns: Array) -> Array:
        found: Array = network(columns[:, picked])[:, order]
        return found

    return corrections


def check_model(
    manifest: DeltaManifest, path: str, actuators: ActuatorSet, robot: RobotView, out: Collector
) -> None:
    """Hold a manifest to the spec that names it: its joints and period are errors, another model a warning."""
    place = Span(path)
    names = {joint.joint for joint in actuators.joints}
    if names != set(manifest.joints):
        message = f"it corrects {listed(manifest.joints)}, the spec has {listed(sorted(names))}"
        if other := sorted(names - set(manifest.joints)):
            message = f"it does not correct {listed(other)}, which the spec has"
        if strange := sorted(set(manifest.joints) - names):
            message = f"it corrects {listed(strange)}, which the spec has not"
        out.error("LRN059", message, where="delta_action", span=place, help="train it on this spec")
    period = actuators.control_period
    if period is not None and abs(manifest.period / period - 1.0) > 0.01:
        message = (
            f"its period is {format_number(manifest.period * 1e3, 4)} ms, the spec's control period "
            f"{format_number(period * 1e3, 4)} ms"
        )
        out.error("LRN059", message, where="delta_action", span=place, help="train it at the policy's rate")
    if out.failed or manifest.model is None:
        return
    try:
        own = model_hash(actuators, robot)
    except (ActspecError, ValueError):
        # The model does not tell its dynamics here, as without its meshes.
        return
    if manifest.model != own:
        message = "it corrects another model: links, friction, drives or rates of the spec have changed since"
        out.warning("LRN060", message, where="delta_action", span=place, help="`actspec delta train` again")


def check_named(actuators: ActuatorSet, robot: RobotView, out: Collector) -> None:
    """Hold the delta action that a spec names to it: a file that is missing or damaged is an error."""
    named = actuators.delta_action
    if named is None:
        return
    try:
        network = read_delta(named.manifest)
    except DeltaFault as err:
        for item in err.diagnostics:
            # Without onnx its file is checked where it is run.
            if item.code != "LRN012":
                # A line of the manifest is the place; of the file as a whole it is where the spec names it.
                lined = item.span is not None and item.span.line
                where, span = (item.where, item.span) if lined else ("delta_action", named.span)
                out.error(item.code, item.message, where=where, span=span, help=item.help)
        return
    check_model(network.manifest, named.manifest, actuators, robot, out)
