"""The network of a level `actuator_net` and its manifest, read and held against each other."""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Place, SpecError
from actspec.files import NotRegular, TooLarge, read_regular
from actspec.ir import Command, JointActuator, Level
from actspec.targets.base import EmittedFile

if TYPE_CHECKING:
    from actspec.spec.results import NetworkManifest

MAX_NETWORK = 64 * 1024 * 1024
"""Largest network file [bytes]. Chosen: actuator networks have some tens of kilobytes."""


@dataclass(frozen=True, slots=True)
class NetworkWithManifest:
    """A network with its conventions.

    Attributes:
        name: Base name of its file.
        data: The file's bytes; never loaded here.
        manifest: Inputs, order, scales, period.
        place: Where the spec names it.
    """

    name: str
    data: bytes
    manifest: NetworkManifest
    place: Place

    @property
    def input_order(self) -> str:
        """Which input is first, in the words of the simulators: `pos_vel` or `vel_pos`."""
        return "pos_vel" if self.manifest.inputs == "position_velocity" else "vel_pos"

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
        # The period T at which the network was trained.
        period = self.manifest.tap_period.value
        if period is None:
            self.place.error(
                "NET007",
                "tap_period is unknown, so the time between two taps is unknown",
                "write the time between two samples of the training log",
            )
            return None
        stride = round(period / step)
        if stride < 1 or abs(stride * step - period) > 1e-6 * period:
            near = max(1, stride) * step
            self.place.error(
                "NET007",
                f"tap_period {period * 1e3:g} ms is not a whole number of physics steps of {step * 1e3:g} ms",
                f"train at {near * 1e3:g} ms, or set timing.physics_dt to {period * 1e3:g} ms or a whole part of it",
            )
            return None
        return stride


def read_network(actuator: JointActuator, collector: Collector) -> NetworkWithManifest | None:
    """Read a joint's network and its manifest; None after an error.

    Args:
        actuator: Of level actuator_net; that it names no network is an error too.
        collector: Takes the errors.
    """
    network, place = actuator.network, collector.at(f"actuators.{actuator.group}", actuator.span)
    if network is None:
        help = "write network: {file: ..., manifest: ...}"
        place.error("NET001", "level actuator_net has no network", help)
        return None
    place = replace(place, where=f"{place.where}.network", span=network.span or place.span)
    if network.manifest is None:
        place.error(
            "NET002",
            "the network has no manifest, and its file alone does not state order, scales and period of its inputs",
            "write network: {file: ..., manifest: ...}; `actspec schema network` has the manifest's keys",
        )
        return None
    data, manifest = _bytes(network.file, place), _manifest(network.manifest, place)
    if data is None or manifest is None:
        return None
    found = hashlib.sha256(data).hexdigest()
    if manifest.sha256 is not None and manifest.sha256 != found:
        place.error(
            "NET005",
            f"the network is not the one that its manifest describes: sha256 {found[:12]}..., "
            f"the manifest has {manifest.sha256[:12]}...",
            "name the manifest that was written with this network",
        )
        return None
    return NetworkWithManifest(os.path.basename(network.file), data, manifest, place)


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
    help = "network.file names the network itself (TorchScript), relative to the spec's folder"
    place.error("NET003", message, help)
    return None


def _manifest(path: str, place: Place) -> NetworkManifest | None:
    """JSON is YAML: read as strictly as a spec, with places."""
    from actspec.spec.document import load_document
    from actspec.spec.results import NetworkManifest
    from actspec.spec.validate import checked

    try:
        document = load_document(path)
    except SpecError as err:
        for item in err.diagnostics:
            placed = item.span is not None and item.span.line
            # Of the file as a whole the reader speaks as of a spec.
            help = item.help if placed else "`actspec schema network` has the manifest's keys"
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
    return None if wrong else manifest


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
