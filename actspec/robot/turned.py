"""Ranges of an MJCF whose lower end is above its upper: MuJoCo reads them as none, without a word."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from actspec.diagnostics import Collector, Span, listed
from actspec.robot.mjcf_actuator_text import numbers
from actspec.robot.mjcf_elements import Written
from actspec.robot.xml_tree import Element

_OF_JOINT = (
    ("range", ("limited",), "the joint has no end"),
    # 2.3 has the words in full.
    (
        "actuatorfrcrange",
        ("actuatorfrclimited", "actuatorforcelimited"),
        "the joint does not limit its actuators",
    ),
    (
        "actuatorforcerange",
        ("actuatorfrclimited", "actuatorforcelimited"),
        "the joint does not limit its actuators",
    ),
)
_OF_ACTUATOR = (
    ("ctrlrange", ("ctrllimited",), "the control is not clamped"),
    ("forcerange", ("forcelimited",), "the force is not clamped"),
    ("actrange", ("actlimited",), "the activation is not clamped"),
)
"""Attributes of a range, those that switch it on or off, and what MuJoCo makes of one that is none.

Source: MuJoCo 3.2.7, 3.12.0 and 4.0.0, measured: without the switch it is off, with it the model is refused.
"""
_OWN_CONTROL = frozenset(("adhesion", "damper", "muscle"))
"""Actuators that refuse such a range of their control, or clamp it themselves; measured with MuJoCo 4.0.0."""


def report_turned(written: Written, out: Collector) -> None:
    """Remark each range that is switched on by itself and is none, once where it is written.

    Args:
        written: An MJCF that MuJoCo takes; what it attaches is looked at where that is read itself.
        out: Takes ROBOT123.
    """
    found: dict[tuple[Span, str], tuple[list[str], str, str, str]] = {}
    for name, owners in _owners(written):
        for attribute, switches, effect in (*_OF_JOINT, *_OF_ACTUATOR):
            owner = owners.get(attribute)
            if owner is None or any(
                one in owners and owners[one].get(one) in ("true", "false") for one in switches
            ):
                continue
            text = owner.get(attribute) or ""
            ends = numbers(text, 2)
            if len(ends) == 2 and ends[0] > ends[1]:
                low, high = text.split()
                at = written.document.span(owner), attribute
                found.setdefault(at, ([], f"{low} {high}", f"{high} {low}", effect))[0].append(name)
    for (span, attribute), (names, text, turned, effect) in found.items():
        out.warning(
            "ROBOT123",
            f'{attribute}="{text}" begins above its end, and MuJoCo takes it as none: {effect}',
            where=listed(dict.fromkeys(filter(None, names)), 3),
            span=span,
            help=f'did you mean {attribute}="{turned}"?',
        )


def _owners(written: Written) -> Iterator[tuple[str, Mapping[str, Element]]]:
    """Joints and actuators: name, and each attribute with the element that states it."""
    for joint in written.joints:
        if joint.type != "free":
            yield joint.name, joint.owners
    for actuator in written.actuators:
        owners = dict(written.defaults_of(actuator).attributes)
        owners.update(dict.fromkeys(actuator.values, actuator))
        dynamics = owners["dyntype"].get("dyntype") if "dyntype" in owners else None
        if _OWN_CONTROL.intersection((actuator.tag, dynamics)):
            owners.pop("ctrlrange", None)
        # A range of the joint's own takes the place of this one.
        if "inheritrange" not in owners:
            yield actuator.get("name") or actuator.get("joint") or "", owners
