"""The network of a level `actuator_net` and its manifest, read and held against each other."""

from __future__ import annotations

import hashlib
import io
import math
import os
import zipfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

from actspec.diagnostics import Collector, Place, SpecError, listed, one_line, shortened
from actspec.files import NotRegular, TooLarge, is_imported, read_regular
from actspec.ir import ActuatorSet, Command, JointActuator, Level, Network
from actspec.libraries import extra_line
from actspec.readings.onnx_file import NotOnnx, check_onnx
from actspec.targets.base import EmittedFile

if TYPE_CHECKING:
    from actspec.laws.network import Layers, NetworkLaw
    from actspec.spec.document import SourceMap
    from actspec.spec.network import NetworkManifest
    from actspec.spec.validate import Spec

MAX_NETWORK = 64 * 1024 * 1024
"""Largest network file [bytes]. Chosen: actuator networks have some tens of kilobytes."""


NetworkForm = Literal["onnx", "torchscript"]
_FORMS: Mapping[NetworkForm, str] = {"onnx": "ONNX", "torchscript": "TorchScript"}


@dataclass(frozen=True, slots=True)
class NetworkWithManifest:
    """A network with its conventions.

    Attributes:
        name: Base name of its file.
        data: The file's bytes; never loaded here.
        manifest: Inputs, order, scales, period.
        place: Where the spec names it.
        assumed_step: As of `ActuatorSet`.
    """

    name: str
    data: bytes
    manifest: NetworkManifest
    place: Place
    assumed_step: str = ""

    @property
    def input_order(self) -> str:
        """Which input is first, in the words of the simulators: `pos_vel` or `vel_pos`."""
        return "pos_vel" if self.manifest.inputs == "position_velocity" else "vel_pos"

    def layers(self) -> Layers | None:
        """Layers of an ONNX file; None where they are not known, which reading it has said."""
        from actspec.readings.onnx_network import NetworkFileError, OnnxMissing, read_onnx

        try:
            return read_onnx(self.data)
        except (OnnxMissing, NetworkFileError):
            return None

    def law(self, step: float) -> NetworkLaw | None:
        """Its law, taps in physics steps; None after an error, or without layers that are known.

        Args:
            step: Physics step h [s].
        """
        stride, layers = self.stride(step), self.layers()
        return None if stride is None or layers is None else self.manifest.law(layers, stride)

    def check_command(self, group: str, command: Command, code: str, takes: str) -> None:
        """Refuse a command that is no position.

        Args:
            group: The network's group.
            command: What is commanded.
            code: Of the error.
            takes: Who takes positions: `Newton's network takes position errors`.
        """
        if command is not Command.POSITION:
            replace(self.place, where=f"actuators.{group}.command").error(
                code,
                f"{takes}, got command {command.value}",
                "write command: position, or leave this target out",
            )

    def stride(self, step: float) -> int | None:
        """Physics steps between two taps; None after an error.

        Args:
            step: Physics step h [s].
        """
        return _stride(self.manifest, step, self.place, self.assumed_step)


def _stride(manifest: NetworkManifest, step: float, place: Place, assumed: str) -> int | None:
    """Physics steps of `step` seconds between two taps; None after an error. `assumed`: whose, where nobody's."""
    from actspec.spec.network import MOST_STEPS

    # The period T at which the network was trained.
    period = manifest.tap_period.value
    if period is None:
        place.error(
            "NET007",
            "tap_period is unknown, so the time between two taps is unknown",
            "write the time between two samples of the training log",
        )
        return None
    stride = manifest.stride(step)
    if stride is None:
        near = max(1, round(min(period / step, MOST_STEPS))) * step
        whose = f", {assumed}" if assumed else ""
        help = f"set timing.physics_dt to {period * 1e3:g} ms or a whole part of it"
        place.error(
            "NET007",
            f"tap_period {period * 1e3:g} ms is not a whole number of physics steps of {step * 1e3:g} ms{whose}",
            help if assumed else f"train at {near * 1e3:g} ms, or {help}",
        )
    return stride


def check_manifests(actuators: ActuatorSet, spec: Spec, collector: Collector) -> None:
    """Report manifests that cannot be read, tell of doubts, or have numbers that the spec contradicts.

    Such are taps that are no whole physics steps apart. Networks' own files are not opened: of those the targets tell
    that read them.

    Args:
        actuators: The resolved spec.
        spec: The spec, which may accept doubts.
        collector: Takes what is found.
    """
    from actspec.spec.plausible.networks import manifest_doubts
    from actspec.spec.plausible.table import kept_of, tell

    members = members_of(actuators.joints)
    for actuator in _first_of(actuators.joints).values():
        network, step = actuator.network, actuators.physics_dt.value
        if network is None or network.manifest is None:
            continue
        place = _place(actuator, network, collector)
        read = manifest_with_places(network.manifest, place)
        if read is None:
            continue
        manifest, spans = read
        # A network of several groups is judged by all of them, and told once.
        mine = members.pop(network.manifest, None)
        steps = step is None or _stride(manifest, step, place, actuators.assumed_step) is not None
        if steps and mine is not None:
            tell(manifest_doubts(manifest, spans, mine), kept_of(spec.document, spec.model.accept), collector)
        for doubt in manifest.doubts:
            place.warning(
                "NET016",
                f"the network was converted against its weights: {one_line(doubt)}",
                "correct the manifest that it was converted with, and `actspec net convert` again",
            )


def read_networks(
    actuators: ActuatorSet, form: NetworkForm, collector: Collector
) -> dict[Network | None, NetworkWithManifest]:
    """The networks of all joints of level actuator_net, each read once; without those that have an error.

    Args: of a joint, as of `read_network`.
    """
    read = {
        network: read_network(actuator, form, collector)
        for network, actuator in _first_of(actuators.joints).items()
    }
    return {
        network: replace(found, assumed_step=actuators.assumed_step)
        for network, found in read.items()
        if found is not None
    }


def _first_of(actuators: Iterable[JointActuator]) -> dict[Network | None, JointActuator]:
    """Each network of level actuator_net with the first joint that it drives."""
    found: dict[Network | None, JointActuator] = {}
    for actuator in actuators:
        if actuator.level is Level.ACTUATOR_NET:
            found.setdefault(actuator.network, actuator)
    return found


def members_of(actuators: Iterable[JointActuator]) -> dict[str, list[JointActuator]]:
    """The joints of level actuator_net by the manifest of their network."""
    found: dict[str, list[JointActuator]] = {}
    for actuator in actuators:
        manifest = None if actuator.network is None else actuator.network.manifest
        if actuator.level is Level.ACTUATOR_NET and manifest is not None:
            found.setdefault(manifest, []).append(actuator)
    return found


def onnx_of(actuator: JointActuator) -> JointActuator | None:
    """The joint with the ONNX file of its network, whatever format the spec itself names; None: there is none."""
    from actspec.readings.networks import network_paths

    network = actuator.network
    if network is None or network.manifest is None or (network.file or "").endswith(".onnx"):
        return actuator if network is not None and network.manifest is not None else None
    own = replace(network, file=None)
    return replace(actuator, network=own) if "onnx" in network_paths(own) else None


def read_network(
    actuator: JointActuator, form: NetworkForm, collector: Collector, place: Place | None = None
) -> NetworkWithManifest | None:
    """Read a joint's network and its manifest; None after an error.

    Args:
        actuator: Of level actuator_net; that it names no network is an error too.
        form: Which of the manifest's files; a spec's own `file` goes before.
        collector: Takes the errors.
        place: Of what names it; None: the spec's.
    """
    network = actuator.network
    if network is None:
        group = collector.at(f"actuators.{actuator.group}", actuator.span)
        group.error("NET001", "level actuator_net has no network", "write network: {manifest: ...}")
        return None
    place = place or _place(actuator, network, collector)
    if network.manifest is None:
        place.error(
            "NET002",
            "the network has no manifest, and its file alone does not state order, scales and period of its inputs",
            "write network: {file: ..., manifest: ...}; `actspec schema network` has the manifest's keys",
        )
        return None
    path = network.file
    data = None if path is None else _bytes(path, place)
    manifest = read_manifest(network.manifest, place)
    if manifest is None:
        return None
    sha256 = manifest.sha256
    if path is None:
        entry = None if manifest.files is None else getattr(manifest.files, form)
        if entry is None:
            place.error(
                "NET009",
                f"the manifest names no {_FORMS[form]} file, which this target needs",
                "`actspec net train` and `actspec net convert` write all files of a network",
            )
            return None
        path, sha256 = os.path.join(os.path.dirname(network.manifest), entry.path), entry.sha256
        data = _bytes(path, place)
    if data is None:
        return None
    found = hashlib.sha256(data).hexdigest()
    if sha256 is not None and sha256 != found:
        place.error(
            "NET005",
            f"the network is not the one that its manifest describes: sha256 {found[:12]}..., "
            f"the manifest has {sha256[:12]}...",
            "name the manifest that was written with this network",
        )
        return None
    if data.startswith(b"PK") != (form == "torchscript") and _known(path, data, place):
        place.error(
            "NET009",
            f"'{shortened(os.path.basename(path))}' is no {_FORMS[form]} file, and this target runs no other",
            "write network: {manifest: ...} with a manifest that names both files: `actspec net convert` writes them",
        )
        return None
    if not _known(path, data, place) or not _fits(network, path, data, manifest, place):
        return None
    return NetworkWithManifest(os.path.basename(path), data, manifest, place)


def _place(actuator: JointActuator, network: Network, collector: Collector) -> Place:
    """Where a spec names a network."""
    return collector.at(f"actuators.{actuator.group}.network", network.span or actuator.span)


def _known(path: str, data: bytes, place: Place) -> bool:
    """Whether a file is TorchScript or ONNX, by its outermost parts; a pickle is neither, and is a program."""
    shown = f"'{shortened(os.path.basename(path))}'"
    if is_imported(path):
        place.error(
            "NET011", f"{shown} has a name that Python imports", "name it by its format: .pt or .onnx"
        )
        return False
    help = "`actspec net convert` makes ONNX and TorchScript of a network"
    if data[:2] == b"\x80\x02" or (data[:1] == b"\x80" and data[1:2] in b"\x03\x04\x05"):
        place.error("NET011", f"{shown} is a pickle, which is no network and may run anything", help)
        return False
    if not data:
        place.error("NET011", f"{shown} is empty", "put the network's own file there")
        return False
    if not data.startswith(b"PK"):
        try:
            check_onnx(data)
        except NotOnnx:
            form = "no ONNX" if path.endswith(".onnx") else "neither a TorchScript nor an ONNX"
            place.error("NET011", f"{shown} cannot be read: it is {form} file, or it is cut off")
            return False
        return True
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            names = [name.partition("/")[2] for name in archive.namelist()]
    except (zipfile.BadZipFile, ValueError, NotImplementedError):
        place.error("NET011", f"{shown} is an archive that is cut off or damaged")
        return False
    if "constants.pkl" in names and any(name.startswith("code/") for name in names):
        return True
    place.error(
        "NET011", f"{shown} holds weights or a pickle, and no network: torch.jit.save writes one", help
    )
    return False


def _fits(network: Network, path: str, data: bytes, manifest: NetworkManifest, place: Place) -> bool:
    """Whether the shape that an ONNX file states is that of the manifest's inputs."""
    from actspec.readings.onnx_network import NetworkFileError, NetworkUnknown, OnnxMissing, read_onnx

    if data.startswith(b"PK"):
        # TorchScript states no shape that could be read without running it; the ONNX file beside it does.
        entry = manifest.files.onnx if manifest.files is not None else None
        if entry is None or network.manifest is None:
            return True
        beside = os.path.join(os.path.dirname(network.manifest), entry.path)
        found = _bytes(beside, place)
        if found is None:
            return False
        path, data = beside, found
    try:
        layers = read_onnx(data)
    except (OnnxMissing, NetworkUnknown) as err:
        help = extra_line("learn") if isinstance(err, OnnxMissing) else None
        place.info("NET012", f"whether the network fits its manifest is not checked: {err}", help)
        return True
    except NetworkFileError as err:
        place.error("NET011", f"'{shortened(os.path.basename(path))}' cannot be read: {err}")
        return False
    wrong = misfits(layers, manifest)
    if wrong:
        message = (
            f"'{shortened(os.path.basename(path))}' is not what its manifest describes: {'; '.join(wrong)}"
        )
        place.error("NET010", message, "name the manifest that was written with this network")
    return not wrong


def misfits(layers: Layers, manifest: NetworkManifest) -> list[str]:
    """What a manifest says otherwise of a network's kind and sizes."""
    kind = "lstm" if layers.recurrent else "mlp"
    wrong = []
    if kind != manifest.kind:
        wrong.append(f"it is of kind {kind}, the manifest says {manifest.kind}")
    if layers.inputs != 2 * len(manifest.taps):
        wrong.append(
            f"it has {layers.inputs} inputs, and position errors and velocities at {len(manifest.taps)} taps "
            f"are {2 * len(manifest.taps)}"
        )
    if layers.outputs != 1:
        wrong.append(f"it has {layers.outputs} outputs, and a joint has one torque")
    sizes = (
        (layers.hidden, manifest.hidden_size, "hidden_size"),
        (len(layers.recurrent), manifest.num_layers, "num_layers"),
    )
    wrong += [
        f"its {name} is {own}, the manifest says {said}"
        for own, said, name in sizes
        if layers.recurrent and said not in (None, own)
    ]
    return wrong


def check_joints(manifest: NetworkManifest, joints: Sequence[str], place: Place) -> None:
    """Warn of joints that the network was not trained on."""
    strange = [joint for joint in joints if manifest.joints and joint not in manifest.joints]
    if strange:
        place.warning(
            "NET008",
            f"the network was not trained on {listed(strange)}",
            f"its manifest names {listed(manifest.joints)}",
        )


def _bytes(path: str, place: Place) -> bytes | None:
    shown = f"'{os.path.basename(path)}'"
    try:
        return read_regular(path, MAX_NETWORK)
    except NotRegular as err:
        message = f"{shown} is {err}"
    except TooLarge as err:
        message = f"{shown} is too large, got {err.size} bytes, at most {MAX_NETWORK} bytes are read"
    except (FileNotFoundError, NotADirectoryError):
        message = f"there is no file {shown}"
    except (OSError, ValueError) as err:
        message = f"{shown} cannot be read: {getattr(err, 'strerror', None) or 'bad path'}"
    help = "a network is a file beside its manifest, or network.file relative to the spec's folder"
    place.error("NET003", message, help)
    return None


def read_manifest(path: str, place: Place) -> NetworkManifest | None:
    """A manifest; None after an error."""
    read = manifest_with_places(path, place)
    return None if read is None else read[0]


def manifest_with_places(path: str, place: Place) -> tuple[NetworkManifest, SourceMap] | None:
    """A manifest and where its values are written; None after an error. JSON is YAML: read as strictly as a spec."""
    from actspec.spec.document import load_document
    from actspec.spec.network import NetworkManifest
    from actspec.spec.validate import checked

    try:
        document = load_document(path)
    except SpecError as err:
        for item in err.diagnostics:
            placed = item.span is not None and item.span.line
            # Of the file as a whole the reader speaks as of a spec.
            help = item.help
            if not placed or item.code == "SPEC005":
                help = "a manifest is the JSON beside a network; `actspec schema network` has its keys"
            at = replace(place, where=item.where or place.where, span=item.span if placed else place.span)
            at.error("NET004", f"the manifest cannot be read: {item.message}", help)
        return None
    manifest = checked(NetworkManifest, document, place.collector)
    if manifest is None:
        return None
    scales = {name: getattr(manifest, name) for name in ("position_scale", "velocity_scale", "torque_scale")}
    wrong = [name for name, value in scales.items() if not math.isfinite(value)]
    for name in wrong:
        at = replace(place, where=name, span=document.spans.value((name,)))
        at.error("NET006", f"must be finite, got {scales[name]}")
    return None if wrong else (manifest, document.spans)


def network_clip(actuator: JointActuator) -> JointActuator:
    """The clip of a network's torque, as a drive whose command is the torque."""
    line = (actuator.stall_torque, actuator.no_load_speed)
    known = all(part is not None and part.known for part in line)
    level = Level.DC_MOTOR if known or actuator.curve is not None else Level.IDEAL_PD
    return replace(actuator, level=level, command=Command.EFFORT, kp=None, kd=None)


def network_files(
    networks: Iterable[tuple[JointActuator, tuple[str, bytes] | None]],
    code: str,
    differ: str,
    collector: Collector,
) -> list[EmittedFile]:
    """The networks' files, each once.

    Args:
        networks: A joint and the name and bytes of its network; None: it has none.
        code: Of the error for two different networks of one name.
        differ: What such two do: `differ`, and in what.
        collector: Takes that error.
    """
    found: dict[str, bytes] = {}
    for actuator, network in networks:
        if network is None:
            continue
        name, data = network
        if found.setdefault(name, data) != data:
            collector.at(f"actuators.{actuator.group}.network", actuator.span).error(
                code,
                f"two networks are called '{name}' and {differ}",
                "rename one: both are written into one folder",
            )
    return [EmittedFile(name, data) for name, data in found.items()]
