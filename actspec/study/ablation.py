"""Specs of one robot that differ in one part of the actuators' model each, to train beside each other.

The first is PD and limit; each other one adds a single thing to it. A group takes a part where all of its joints have
what it needs, because a level holds for a group; joints that lack it stay as in the first, and are named.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass, fields, is_dataclass
from enum import Enum
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from actspec.files import name_in_file, path_of_name
from actspec.ir import Delay, Quantity, Randomization
from actspec.robot.xml_edit import exact_number
from actspec.study.variants import Assumed, Missing, variants_of
from actspec.targets.base import relative_path
from actspec.units import format_number, format_quantity

if TYPE_CHECKING:
    from actspec.ir import ActuatorSet, JointActuator
    from actspec.spec.validate import Spec

FIRST = "A_ideal_pd"
"""What the others are held against."""
NAMES: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        FIRST: ("ideal_pd", "PD and effort limit: no filter, no delay, nothing randomised"),
        "B_dc_motor": ("dc_motor", "that, and the motor's torque-speed line"),
        "C_bandwidth": ("filter", "that of A, and a low-pass on the command"),
        "D_ideal_pd_dr": ("ideal_pd", "that of A, and the spec's randomisation"),
        "network": ("network", "that of A, with the spec's network in place of PD"),
    }
)
"""Name to the variant of `variants_of` that a joint needs, and what it is."""

Plain = dict[str, Any]
"""A spec, or a part of it, as plain data."""


@dataclass(frozen=True, slots=True)
class Change:
    """A figure that is another one in a variant.

    Attributes:
        field: Of the resolved actuator.
        was: In words.
        becomes: Likewise.
        joints: Whose, in the robot's order.
    """

    field: str
    was: str
    becomes: str
    joints: tuple[str, ...]


def variant_specs(
    spec: Spec, actuators: ActuatorSet, given: Assumed
) -> tuple[dict[str, Plain], tuple[Missing, ...]]:
    """Every variant that a spec has as plain data, by name, and what others lack.

    Args:
        spec: The spec.
        actuators: It, resolved.
        given: Figures that it may lack.

    Returns: Paths in them are as in the spec.
    """
    members: dict[str, list[JointActuator]] = {}
    for actuator in actuators.joints:
        members.setdefault(actuator.group, []).append(actuator)
    missing: list[Missing] = []
    first = _shared(spec.document.data)
    found: dict[str, Plain] = {}
    for variant in NAMES:
        data, made = deepcopy(first), False
        for name, joints in members.items():
            own = spec.document.data["actuators"][name]
            if not _lacking(variant, joints, own, given, missing):
                data["actuators"][name] = _ADD[variant](data["actuators"][name], own, joints, given)
                made = True
        if variant == FIRST:
            first = data
        if made:
            found[variant] = data
    return found, tuple(missing)


def _shared(spec: Plain) -> Plain:
    """What holds for every variant."""
    return {
        key: deepcopy(value)
        for key, value in spec.items()
        if key not in ("include", "variant", "variants", "delta_action")
    }


def _lacking(
    variant: str, joints: Sequence[JointActuator], own: Plain, given: Assumed, missing: list[Missing]
) -> bool:
    """Whether a group has not what a variant needs, which is then said of each joint."""
    needed = NAMES[variant][0]
    lacks = (why for a in joints for why in variants_of(a, given)[1] if why.variant == needed)
    reasons = {why.joint: why.reason for why in lacks}
    if variant == "D_ideal_pd_dr" and "randomize" not in own:
        reasons = {a.joint: "the spec states no randomize" for a in joints}
    for actuator in joints if reasons else ():
        first = next(iter(reasons))
        reason = reasons.get(actuator.joint) or f"{first}, of the same group: {reasons[first]}"
        missing.append(Missing(actuator.joint, variant, reason))
    return bool(reasons)


def _bare(group: Plain, own: Plain, joints: Sequence[JointActuator], given: Assumed) -> Plain:
    """PD and limit alone; what is taken away is denied in so many words, so that no other file gives it."""
    group = {key: value for key, value in group.items() if key not in (*_PARTS, "network", "randomize")}
    group["level"] = "ideal_pd"
    if any(actuator.filter_cutoff is not None for actuator in joints):
        group["command_filter"] = "none"
    if any(actuator.delay is not None for actuator in joints):
        group["delay"] = "0 ms"
    overrides: Plain = {}
    for pattern, part in group.pop("overrides", {}).items():
        _override(overrides, pattern, {key: value for key, value in part.items() if key not in _PARTS})
    return _overriding(group, overrides)


_PARTS = ("command_filter", "delay")
"""Fields of a group, or of an override, that the first variant has not."""


def _override(overrides: Plain, pattern: str, part: Plain) -> None:
    if part:
        overrides[pattern] = {**overrides.get(pattern, {}), **deepcopy(part)}


def _overriding(group: Plain, overrides: Plain) -> Plain:
    return {**group, "overrides": overrides} if overrides else group


def _lined(group: Plain, own: Plain, joints: Sequence[JointActuator], given: Assumed) -> Plain:
    return {**group, "level": "dc_motor"}


def _filtered(group: Plain, own: Plain, joints: Sequence[JointActuator], given: Assumed) -> Plain:
    """The spec's own filter, and that of the option for joints without one."""
    without = [a for a in joints if a.filter_cutoff is None or not a.filter_cutoff.known]
    group = dict(group)
    overrides = group.pop("overrides", {})
    group.pop("command_filter", None)
    asked: Plain = {}
    if given.cutoff is not None:
        asked = {
            "command_filter": {"cutoff": {"value": f"{exact_number(given.cutoff)} Hz", "note": "--filter"}}
        }
    if len(without) == len(joints):
        return _overriding({**group, **asked}, overrides)
    stated: Plain = {"": own, **own.get("overrides", {})}
    for pattern, part in stated.items():
        kept = {key: value for key, value in part.items() if key == "command_filter" and value != "none"}
        if pattern:
            _override(overrides, pattern, kept)
        else:
            group.update(deepcopy(kept))
    for actuator in without:
        _override(overrides, re.escape(actuator.joint), asked)
    return _overriding(group, overrides)


def _drawn(group: Plain, own: Plain, joints: Sequence[JointActuator], given: Assumed) -> Plain:
    return {**group, "randomize": deepcopy(own["randomize"])}


def _learned(group: Plain, own: Plain, joints: Sequence[JointActuator], given: Assumed) -> Plain:
    return {**group, "level": "actuator_net", "network": deepcopy(own["network"])}


_ADD: Mapping[str, Callable[[Plain, Plain, Sequence[JointActuator], Assumed], Plain]] = {
    FIRST: _bare,
    "B_dc_motor": _lined,
    "C_bandwidth": _filtered,
    "D_ideal_pd_dr": _drawn,
    "network": _learned,
}
"""A group of a variant, from that of the first one and from the spec's own."""


def moved(spec: Plain, base: str, folder: str) -> Plain:
    """A spec whose model and packages lead from another folder; results and networks lie in it by the same names.

    Args:
        spec: As plain data.
        base: Folder of the spec.
        folder: Where it will lie.
    """
    spec = deepcopy(spec)

    def there(path: str) -> str:
        if "://" in path or os.path.isabs(path):
            return path
        return name_in_file(relative_path(os.path.join(base, path_of_name(path)), folder))

    robot = spec["robot"]
    if robot["model"] != "none":
        robot["model"] = there(robot["model"])
    if "packages" in robot:
        robot["packages"] = {name: there(path) for name, path in robot["packages"].items()}
    return spec


def changes(before: ActuatorSet, after: ActuatorSet) -> tuple[Change, ...]:
    """What is another figure in a variant, joint by joint; equal changes of several joints are one."""
    found: dict[tuple[str, str, str], list[str]] = {}
    for old, new in zip(before.joints, after.joints, strict=True):
        for field in (one for one in fields(old) if one.name not in _PLACES):
            values = getattr(old, field.name), getattr(new, field.name)
            if figure(values[0]) != figure(values[1]):
                was, becomes = (words(value) for value in values)
                found.setdefault((field.name, was, becomes), []).append(old.joint)
    listed = [Change(*key, tuple(joints)) for key, joints in found.items()]
    if figure(before.delta_action) != figure(after.delta_action):
        was, becomes = words(before.delta_action), words(after.delta_action)
        listed.append(Change("delta_action", was, becomes, tuple(a.joint for a in after.joints)))
    return tuple(listed)


def figure(value: Any) -> Any:
    """A part of a resolved actuator without the places where it is written and the words about it."""
    if isinstance(value, Quantity):
        return value.value, value.unit, value.std
    if isinstance(value, (tuple, list)):
        return tuple(figure(item) for item in value)
    if is_dataclass(value) and not isinstance(value, type):
        parts = (f.name for f in fields(value) if f.name not in _PLACES)
        return type(value).__name__, *(figure(getattr(value, name)) for name in parts)
    return value


_PLACES = ("span", "stated", "lacking")
"""Where a figure is written, and what import says of a network's manifest."""


def words(value: Any) -> str:
    """The same for people."""
    if isinstance(value, Quantity):
        return format_quantity(value.value, value.unit)
    if isinstance(value, Delay):
        ends = f", {value.low:g} to {value.high:g} s" if value.low != value.high else ""
        return f"{words(value.nominal)}{ends}"
    if isinstance(value, Randomization):
        return f"{value.field} {value.operation} {format_number(value.low)} to {format_number(value.high)}"
    if isinstance(value, tuple):
        return "; ".join(words(item) for item in value) or "none"
    if isinstance(value, Enum):
        return str(value.value)
    if is_dataclass(value) and not isinstance(value, type):
        return ", ".join(_worded(value))
    return "none" if value is None else str(value)


def _worded(value: Any) -> Iterator[str]:
    for field in fields(value):
        part = getattr(value, field.name)
        if field.name not in _PLACES and part is not None:
            yield f"{field.name} {words(part)}"
