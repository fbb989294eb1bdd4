"""Where an MJCF's joints and actuators are written, and what their default classes state.

The numbers come from MuJoCo; this only says which of them the author wrote, and where.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import Span

if TYPE_CHECKING:
    from actspec.robot.xml_tree import Element, XmlDocument

_MAIN = "main"

ACTUATORS = frozenset(
    {
        "general", "motor", "position", "velocity", "intvelocity", "damper", "cylinder", "muscle",
        "adhesion", "dcmotor", "orientation", "pid", "plugin",
    }
)  # fmt: skip
"""Tags of actuators. Source: MuJoCo 4.0, mjcf.schema."""


@dataclass(frozen=True, slots=True)
class JointElement:
    """One joint as it is written.

    Attributes:
        element: The `joint` or `freejoint`.
        owners: Each of its attributes and of those of its default classes, with the element that states it.
        span: Its line; for a copy by `replicate` the line of the outermost `replicate`.
    """

    element: Element
    owners: Mapping[str, Element]
    span: Span


@dataclass(frozen=True, slots=True)
class DefaultClass:
    """What a default class and those above it say of joints and actuators.

    Attributes:
        joint: Attribute to the `joint` element in a `default` that states it last.
        actuators: Elements of actuators of each class on the way to it, the outermost first, in the
            order in which they act: MuJoCo keeps one actuator for a class, and each element changes it.
        attributes: Attribute to the one of those elements that states it last.
    """

    joint: Mapping[str, Element]
    actuators: tuple[tuple[Element, ...], ...]
    attributes: Mapping[str, Element]


_WALKED = frozenset({"joint", "freejoint", "attach", "body", "frame", "replicate"})
"""What is looked at inside the world; a `worldbody` is its root only."""

NO_CLASS = DefaultClass({}, (), {})


@dataclass(frozen=True, slots=True)
class Written:
    """Joints, actuators and attachments of an MJCF as they are written.

    Attributes:
        joints: By name.
        replicated: Joints inside a `replicate`, whose copies have names that begin with theirs.
        attached: Prefix, suffix and place of each `attach`.
        actuators: Elements of all `actuator` sections, in order.
        defaults: Default classes by name.
    """

    joints: Mapping[str, JointElement]
    replicated: tuple[tuple[str, JointElement], ...]
    attached: tuple[tuple[str, str, Span], ...]
    actuators: tuple[Element, ...]
    defaults: Mapping[str, DefaultClass]

    def joint(self, name: str) -> JointElement | None:
        """The joint of a compiled name: itself, or the one that it is a copy of."""
        found = self.joints.get(name)
        if found is not None:
            return found
        copies = [item for item in self.replicated if name.startswith(item[0])]
        return max(copies, key=lambda item: len(item[0]))[1] if copies else None

    def defaults_of(self, actuator: Element) -> DefaultClass:
        """The default class of an actuator."""
        return self.defaults.get(actuator.get("class") or _MAIN, NO_CLASS)

    def attachment(self, name: str) -> Span | None:
        """The `attach` that a compiled name comes from."""
        for prefix, suffix, span in self.attached:
            if (prefix or suffix) and name.startswith(prefix) and name.endswith(suffix):
                return span
        return None


def read_elements(document: XmlDocument) -> Written:
    """Walk an MJCF's bodies and actuators.

    Args:
        document: Parsed, with its includes in place.
    """
    defaults = _defaults(document)
    joints: dict[str, JointElement] = {}
    replicated: list[tuple[str, JointElement]] = []
    attached: list[tuple[str, str, Span]] = []
    # Many models have none, and hundreds of bodies need not be looked into.
    handed_on = any(b"childclass" in file.data for file in document.files)
    # An explicit stack, in document order: (element, inherited class, outermost replicate).
    stack: list[tuple[Element, str, Element | None]] = [
        (section, _MAIN, None) for section in reversed(document.sections("worldbody"))
    ]
    while stack:
        element, inherited, copied = stack.pop()
        if element.tag in ("joint", "freejoint"):
            name = element.get("name")
            if name is not None:
                own = element.get("class") or inherited
                base = {} if element.tag == "freejoint" else defaults.get(own, NO_CLASS).joint
                span = document.span(element if copied is None else copied)
                owners = {**base, **dict.fromkeys(element.values, element)}
                written = JointElement(element, owners, span)
                if copied is None:
                    joints.setdefault(name, written)
                else:
                    replicated.append((name, written))
            continue
        if element.tag == "attach":
            prefix, suffix = element.get("prefix") or "", element.get("suffix") or ""
            attached.append((prefix, suffix, document.span(element)))
            continue
        if handed_on:
            inherited = element.get("childclass") or inherited
        if element.tag == "replicate" and copied is None:
            copied = element
        stack += [(child, inherited, copied) for child in reversed(element.children) if child.tag in _WALKED]
    actuators = [child for section in document.sections("actuator") for child in section.children]
    return Written(joints, tuple(replicated), tuple(attached), tuple(actuators), defaults)


def _defaults(document: XmlDocument) -> dict[str, DefaultClass]:
    """Each default class with what the classes above it say."""
    found: dict[str, DefaultClass] = {}
    stack: list[tuple[Element, str, DefaultClass]] = [
        (section, _MAIN, NO_CLASS) for section in reversed(document.sections("default"))
    ]
    while stack:
        element, name, above = stack.pop()
        # Several top-level sections add to one main class.
        before = found.get(name)
        joint = dict((before or above).joint)
        actuators = list(before.actuators[-1]) if before is not None else []
        for child in element.children:
            if child.tag == "joint":
                joint.update(dict.fromkeys(child.values, child))
            elif child.tag in ACTUATORS:
                actuators.append(child)
        attributes = {**above.attributes, **{key: one for one in actuators for key in one.values}}
        made = found[name] = DefaultClass(joint, (*above.actuators, tuple(actuators)), attributes)
        if name == _MAIN and element.get("class"):
            # The author may name the main class otherwise.
            found[element.get("class") or _MAIN] = made
        stack.extend(
            (child, child.get("class") or "", made)
            for child in reversed(element.children)
            if child.tag == "default"
        )
    return found
