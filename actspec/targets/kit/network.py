"""The network of a level `actuator_net` and its manifest, read and held against each other."""

from __future__ import annotations

import hashlib
import math
import os
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, SpecError
from actspec.files import NotRegular, TooLarge, read_regular
from actspec.ir import Command, JointActuator, Level, Network
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
    """

    name: str
    data: bytes
    manifest: NetworkManifest


def read_network(
    network: Network | None, where: str, span: Span | None, collector: Collector
) -> NetworkWithManifest | None:
    """Read a network and its manifest; None after an error.

    Args:
        network: The two files; None is an error too.
        where: Path of the group in the spec.
        span: Where the group is written.
        collector: Takes the errors.
    """
    if network is None:
        collector.error(
            "NET001",
            "level actuator_net has no network",
            where=where,
            span=span,
            help="write network: {file: ..., manifest: ...}",
        )
        return None
    where, span = f"{where}.network", network.span or span
    if network.manifest is None:
        collector.error(
            "NET002",
            "the network has no manifest, and its file alone does not state order, scales and period of its inputs",
            where=where,
            span=span,
            help="write network: {file: ..., manifest: ...}; `actspec schema network` has the manifest's keys",
        )
        return None
    data = _bytes(network.file, where, span, collector)
    manifest = _manifest(network.manifest, where, span, collector)
    if data is None or manifest is None:
        return None
    found = hashlib.sha256(data).hexdigest()
    if manifest.sha256 is not None and manifest.sha256 != found:
        collector.error(
            "NET005",
            f"the network is not the one that its manifest describes: sha256 {found[:12]}..., "
            f"the manifest has {manifest.sha256[:12]}...",
            where=where,
            span=span,
            help="name the manifest that was written with this network",
        )
        return None
    return NetworkWithManifest(os.path.basename(network.file), data, manifest)


def _bytes(path: str, where: str, span: Span | None, collector: Collector) -> bytes | None:
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
    collector.error(
        "NET003",
        message,
        where=where,
        span=span,
        help="network.file names the network itself (TorchScript), relative to the spec's folder",
    )
    return None


def _manifest(path: str, where: str, span: Span | None, collector: Collector) -> NetworkManifest | None:
    """JSON is YAML: read as strictly as a spec, with places."""
    from actspec.spec.document import load_document
    from actspec.spec.results import NetworkManifest
    from actspec.spec.validate import checked

    try:
        document = load_document(path)
    except SpecError as err:
        for item in err.diagnostics:
            placed = item.span is not None and item.span.line
            collector.error(
                "NET004",
                f"the manifest cannot be read: {item.message}",
                where=item.where or where,
                span=item.span if placed else span,
                # Of the file as a whole the reader speaks as of a spec.
                help=item.help if placed else "`actspec schema network` has the manifest's keys",
            )
        return None
    manifest = checked(NetworkManifest, document, collector)
    if manifest is None:
        return None
    scales = {name: getattr(manifest, name) for name in ("position_scale", "velocity_scale", "torque_scale")}
    wrong = [name for name, value in scales.items() if not math.isfinite(value)]
    for name in wrong:
        collector.error(
            "NET006",
            f"must be finite, got {scales[name]}",
            where=name,
            span=document.spans.value((name,)),
        )
    return None if wrong else manifest


def tap_stride(
    manifest: NetworkManifest, step: float, where: str, span: Span | None, collector: Collector
) -> int | None:
    """Physics steps between two taps; None after an error.

    Args:
        manifest: With the period T at which the network was trained.
        step: Physics step h [s].
        where: Path of the network in the spec.
        span: Where it is written.
        collector: Takes the error.
    """
    period = manifest.tap_period.value
    if period is None:
        collector.error(
            "NET007",
            "tap_period is unknown, so the time between two taps is unknown",
            where=where,
            span=span,
            help="write the time between two samples of the training log",
        )
        return None
    stride = round(period / step)
    if stride < 1 or abs(stride * step - period) > 1e-6 * period:
        near = max(1, stride) * step
        collector.error(
            "NET007",
            f"tap_period {period * 1e3:g} ms is not a whole number of physics steps of {step * 1e3:g} ms",
            where=where,
            span=span,
            help=f"train at {near * 1e3:g} ms, or set timing.physics_dt to {period * 1e3:g} ms or a whole part of it",
        )
        return None
    return stride


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
            collector.error(
                code,
                f"two networks are called '{name}' and {differ}",
                where=f"actuators.{actuator.group}.network",
                span=actuator.span,
                help="rename one: both are written into one folder",
            )
    return [EmittedFile(name, data) for name, data in found.items()]
