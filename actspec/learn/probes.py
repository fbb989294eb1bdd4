"""What the weights of a network contradict of its manifest and of the joints that it drives."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from actspec.diagnostics import Collector
from actspec.fields import units_of
from actspec.ir import ActuatorSet, JointActuator
from actspec.laws.network import Layers, NetworkLaw
from actspec.learn.inspect import REACH, Contradiction, Inspection, inspect, settled
from actspec.logs import LogError
from actspec.spec.network import NetworkManifest
from actspec.spec.plausible.networks import (
    STRONG,
    network_place,
    strongest,
    trained_reach,
    weakest,
    widest,
)
from actspec.spec.plausible.relations import DEGREE
from actspec.spec.plausible.table import Doubt, kept_of, tell
from actspec.spec.validate import Spec
from actspec.targets.kit.network import manifest_with_places, members_of, onnx_of, read_network
from actspec.units import format_number, format_quantity

FARTHEST = 1000.0
"""Torque of an error up to `REACH`, over the largest that the joints give, where no training range is stated.

Chosen: what no sample has seen goes on as a straight line, and a stiff drive reaches its limit within milliradians.
"""
WEAK = 0.01
"""The largest torque of a network over the least effort limit of its joints. Chosen: dry friction alone takes that."""


def network_doubts(actuators: ActuatorSet, spec: Spec, collector: Collector) -> None:
    """Report networks whose weights contradict their manifest or their joints; unreadable ones others report.

    Args:
        actuators: The resolved spec.
        spec: The spec, which may accept doubts.
        collector: Takes warnings, at the manifest's lines.
    """
    for path, members in members_of(actuators.joints).items():
        named, read = onnx_of(members[0]), manifest_with_places(path, Collector().at())
        network = None if named is None else read_network(named, "onnx", Collector())
        layers = None if network is None else network.layers()
        if layers is None or read is None:
            continue
        manifest, spans = read
        try:
            found = inspect(layers, manifest)
        except LogError:
            continue
        # What it was converted against is told already.
        told = () if manifest.doubts else found.contradictions
        doubts = (
            Doubt("NET018", item.text, network_place(members), spans.value((item.key,)), item.help)
            for item in (*told, *against_joints(layers, manifest, found, members))
        )
        tell(doubts, kept_of(spec.document, spec.model.accept), collector)


def against_joints(
    layers: Layers, manifest: NetworkManifest, found: Inspection, members: Sequence[JointActuator]
) -> Iterator[Contradiction]:
    """Torques that the joints never give, or hardly any, and the scale that they hang on.

    Args:
        layers: The network; its sizes are those of the manifest.
        manifest: Its conventions.
        found: What it does at rest.
        members: The joints that it drives, one at least.
    """
    if 0.0 in (manifest.position_scale, manifest.torque_scale):
        return
    if any(item.key in ("kind", "inputs") for item in found.contradictions):
        # What it gives in that order says nothing of the scales.
        return
    most, least = strongest(members), weakest(members)
    own, unit = _own(members), members[0].effort_limit.unit
    too_large = None if most is None else _too_large(layers, manifest, members, most)
    if too_large is not None and most is not None:
        key, what, torque = too_large
        text = (
            f"{what} gives {format_quantity(torque, unit, 4)}, and the strongest of its joints "
            f"{format_quantity(most, unit, 4)}"
        )
        yield Contradiction(key, text, _scale(manifest, key, unit if key == "torque_scale" else own))
    elif least is not None and found.saturation < WEAK * least:
        gives = format_quantity(found.saturation, unit, 4)
        text = (
            f"no error up to {format_quantity(REACH, own)} gives more than {gives}, "
            f"and the least effort limit of its joints is {format_quantity(least, unit, 4)}"
        )
        yield Contradiction("torque_scale", text, _scale(manifest, "torque_scale", unit))


def _too_large(
    layers: Layers, manifest: NetworkManifest, members: Sequence[JointActuator], most: float
) -> tuple[str, str, float] | None:
    """The scale of a torque that is too large, what gives it, and the torque [N*m or N]."""
    law, own = manifest.law(layers), _own(members)
    reach = trained_reach(manifest, members)
    if reach is None:
        error = min(REACH, widest(members) or REACH)
        torque = _largest(law, error, 0.0)
        if torque <= FARTHEST * most:
            return None
        return "torque_scale", f"an error of {format_quantity(error, own, 3)}", torque
    by_error, by_velocity = _largest(law, reach[0], 0.0), _largest(law, 0.0, reach[1])
    too_large = by_error > STRONG * most, by_velocity > STRONG * most
    if too_large[0]:
        key = "torque_scale" if too_large[1] else "position_scale"
        return key, f"an error of {format_quantity(reach[0], own, 3)}, as in training,", by_error
    if too_large[1]:
        what = f"a velocity of {format_quantity(reach[1], f'{own}/s', 3)}, as in training,"
        return "velocity_scale", what, by_velocity
    return None


def _largest(law: NetworkLaw, error: float, velocity: float) -> float:
    """The larger torque of an error and a velocity that stay, either way [N*m or N]."""
    signs = np.array([1.0, -1.0])
    return float(abs(settled(law, error * signs, velocity * signs)).max())


def _own(members: Sequence[JointActuator]) -> str:
    return units_of(members[0].kind).position


def _scale(manifest: NetworkManifest, key: str, unit: str) -> str:
    """What to look at."""
    value = getattr(manifest, key)
    if key == "torque_scale":
        return (
            f"is torque_scale {format_number(value, 4)} right? It is the torque of an output of 1, in {unit}"
        )
    factor = f"{unit}/s" if key == "velocity_scale" else unit
    if unit == "rad" and math.isclose(abs(value) * DEGREE, 1.0, rel_tol=1e-3):
        # The commonest slip: degrees of a network that takes radians.
        return f"{key} {format_number(value, 4)} makes degrees of {factor}: did you mean {math.copysign(1.0, value):g}?"
    return f"is {key} {format_number(value, 4)} right? It is what makes inputs of {factor}"
