"""The manifest of an actuator network beside the joints that it drives: what its numbers alone contradict.

No network is read here. What the weights say beside these numbers is `actspec.learn.probes`' matter.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from actspec.diagnostics import Path, dotted
from actspec.fields import is_power_of_ten
from actspec.ir import JointActuator, JointKind, Origin
from actspec.spec.document import SourceMap
from actspec.spec.fields import CONTROL_PERIOD
from actspec.spec.network import InputRange, NetworkManifest
from actspec.spec.plausible.clamps import TURN, WIDE
from actspec.spec.plausible.relations import DEGREE
from actspec.spec.plausible.slips import amount_of
from actspec.spec.plausible.table import Doubt
from actspec.units import format_number, format_quantity

FAR = 3.0
"""Position error of a hinge in the training data over the widest range of the joints; below a full turn nothing is far.

Chosen: a target that is two whole ranges beyond an end is nobody's, and degrees are 57 times.
"""
FAST = 10.0
"""Velocity in the training data over the fastest that the joints turn. Chosen: what lands is pushed, and limits may be
chosen low; degrees are 57 times, rpm 9.5."""
STRONG = 10.0
"""Torque of a network, or of its training data, over the largest that the joints give.

Chosen: a network learns torques that there were, and a limit may be chosen low; mN*m are 1000 times, degrees 57.
"""


def manifest_doubts(
    manifest: NetworkManifest, spans: SourceMap, members: Sequence[JointActuator]
) -> Iterator[Doubt]:
    """Numbers of a manifest that can hardly be right, each at its line there.

    Args:
        manifest: The manifest.
        spans: Where it says what it says.
        members: The joints that the network drives, one at least.
    """
    where = network_place(members)
    for path, message, help in (
        *_period(manifest),
        *_scales(manifest),
        *_range(manifest, members),
        *_validation(manifest, members),
    ):
        yield Doubt("NET017", f"{dotted(path)}: {message}", where, spans.value(path), help)


_Item = tuple[Path, str, str | None]


def network_place(members: Sequence[JointActuator]) -> str:
    """Path of the group that names a network."""
    return f"actuators.{members[0].group}.network"


def strongest(members: Sequence[JointActuator]) -> float | None:
    """The largest torque that one of the joints can give, by any of its figures [N*m or N]; None: one has none."""
    found = []
    for joint in members:
        curve = (joint.curve.drive_torque, joint.curve.brake_torque) if joint.curve is not None else ()
        figures = (joint.effort_limit, joint.stall_torque, joint.peak_torque, *curve)
        known = [one.value for one in figures if one is not None and one.value]
        if not known:
            return None
        found.append(max(known))
    return max(found, default=None)


def weakest(members: Sequence[JointActuator]) -> float | None:
    """The least of their effort limits [N*m or N]; None: one has none, or a placeholder of the robot's file."""
    limits = [joint.effort_limit for joint in members]
    known = [
        limit.value
        for limit in limits
        if limit.value and not (limit.origin is Origin.MODEL and is_power_of_ten(limit.value))
    ]
    return min(known) if len(known) == len(limits) else None


def trained_reach(manifest: NetworkManifest, members: Sequence[JointActuator]) -> tuple[float, float] | None:
    """Error and velocity that are seldom exceeded in the training data [rad, rad/s or m, m/s].

    None: they are not stated, or can hardly be right.
    """
    if manifest.range is None or any(_range(manifest, members)):
        return None
    return _reach(manifest.range.error), _reach(manifest.range.velocity)


def _reach(ends: InputRange) -> float:
    return max(abs(ends.low), abs(ends.high))


def _period(manifest: NetworkManifest) -> Iterator[_Item]:
    """Samples that are further apart than any robot's control steps."""
    period, most = manifest.tap_period, CONTROL_PERIOD[1]
    if period.value is None or period.value <= most:
        return
    amount, unit = amount_of(period)
    message = f"samples {period.written} apart, and control steps of robots are {most:g} s at most"
    help = f"did you mean {amount:g} ms?" if unit == "s" else "write the time between two samples in training"
    yield ("tap_period",), message, help


def _scales(manifest: NetworkManifest) -> Iterator[_Item]:
    """Scales that switch the network off; one of the velocity may be meant."""
    if manifest.position_scale == 0.0:
        yield ("position_scale",), "by 0 the network does not see how far a joint is from its target", None
    if manifest.torque_scale == 0.0:
        yield ("torque_scale",), "by 0 the network gives no torque", None


def _range(manifest: NetworkManifest, members: Sequence[JointActuator]) -> Iterator[_Item]:
    """Errors and velocities of the training data that the joints never have."""
    kinds = {joint.kind for joint in members}
    if manifest.range is None or len(kinds) > 1:
        return
    hinge = kinds == {JointKind.HINGE}
    unit, words, small = ("rad", "deg", DEGREE) if hinge else ("m", "mm", 1e-3)
    width, speed = widest(members), _fastest(members)
    if width is not None:
        most = max(FAR * width, TURN) if hinge else WIDE * width
        beside = f"the widest range of its joints is {format_quantity(width, unit, 3)}"
        yield from _beyond("error", manifest.range.error, most, beside, (unit, words, small))
    if speed is not None:
        beside = f"the fastest of its joints has {format_quantity(speed, f'{unit}/s', 3)}"
        units = f"{unit}/s", f"{words}/s", small
        yield from _beyond("velocity", manifest.range.velocity, FAST * speed, beside, units)


def _beyond(
    name: str, ends: InputRange, most: float, beside: str, units: tuple[str, str, float]
) -> Iterator[_Item]:
    """A range of the training data beyond `most`; its unit, one that it may be in, and how large that is."""
    reach, (unit, other, small) = _reach(ends), units
    if reach > most:
        end = "high" if abs(ends.high) == reach else "low"
        message = f"training data of {format_quantity(reach, unit, 4)}, and {beside}"
        help = f"is it in {other}? Then write {format_number(getattr(ends, end) * small, 4)}, in {unit}"
        yield ("range", name, end), message, help


def widest(members: Sequence[JointActuator]) -> float | None:
    """Of the joints' ranges [rad or m]; None: one has none."""
    ranges = [joint.position_range for joint in members if joint.position_range is not None]
    widths = [high - low for low, high in ranges]
    known = len(widths) == len(members) and all(0.0 < width < math.inf for width in widths)
    return max(widths) if known else None


def _fastest(members: Sequence[JointActuator]) -> float | None:
    """Of the joints' speeds [rad/s or m/s]; None: one has none, or a placeholder, which is a power of ten."""
    found = []
    for joint in members:
        figures = (joint.no_load_speed, joint.velocity_limit)
        known = [one.value for one in figures if one is not None and one.value]
        if not known or is_power_of_ten(max(known)):
            return None
        found.append(max(known))
    return max(found)


def _validation(manifest: NetworkManifest, members: Sequence[JointActuator]) -> Iterator[_Item]:
    """Torques of the validation that the joints never give."""
    most = strongest(members)
    if manifest.validation is None or most is None:
        return
    unit = members[0].effort_limit.unit
    rmse, share = manifest.validation.rmse, manifest.validation.relative_error
    # Its own definition: the error over the root mean square of the torque.
    torque = max(rmse, rmse / share if share > 0.0 else 0.0)
    if torque > STRONG * most:
        message = (
            f"the torques of the validation have a root mean square of {format_quantity(torque, unit, 3)}, and the "
            f"strongest of its joints gives {format_quantity(most, unit, 3)}"
        )
        yield ("validation", "rmse"), message, f"look for a wrong unit: rmse is in {unit}"
