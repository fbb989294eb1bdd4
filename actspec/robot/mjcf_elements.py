"""Where an MJCF's joints and actuators are written, and what their default classes state.

The numbers come from MuJoCo; this only says which of them the author wrote, and where.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import Span

if TYPE_CHECKING:
    from actspec.robot.xml import Element, XmlDocument

_MAIN = "main"


@dataclass(frozen=True, slots=True)
class JointElement:
    """One joint as it is written.

    Attributes:
        element: The `joint` or `freejoint`.
        stated: Names of its attributes and of those of its default classes.
        span: Its line; for a copy by `replicate` the line of the outermost `replicate`.
    """

    element: Element
    stated: frozenset[str]
    span: Span


@dataclass(frozen=True, slots=True)
class Written:
    """Joints, actuators and attachments of an MJCF as they are written.

    Attributes:
        joints: By name.
        replicated: Joints inside a `replicate`, whose copies have names that begin with theirs.
        attached: Prefix, suffix and place of each `attach`.
        actuators: Elements of all `actuator` sections, in order.
    """

    joints: Mapping[str, JointElement]
    replicated: tuple[tuple[str, JointElement], ...]
    attached: tuple[tuple[str, str, Span], ...]
    actuators: tuple[Element, ...]

    def joint(self, name: str) -> JointElement | None:
        """The joint of a compiled name: itself, or the one that it is a copy of."""
        found = self.joints.get(name)
        if found is not None:
            return found
        copies = [item for item in self.replicated if name.startswith(item[0])]
        return max(copies, key=lambda item: len(item[0]))[1] if copies else None

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
                base = frozenset() if element.tag == "freejoint" else defaults.get(own, frozenset())
                span = document.span(element if copied is None else copied)
                written = JointElement(element, base.union(element.attributes), span)
                if copied is None:
                    joints.setdefault(name, written)
                else:
                    replicated.append((name, written))
            continue
        if element.tag == "attach":
            prefix, suffix = element.get("prefix") or "", element.get("suffix") or ""
            attached.append((prefix, suffix, document.span(element)))
            continue
        if element.tag not in ("worldbody", "body", "frame", "replicate"):
            continue
        inherited = element.get("childclass") or inherited
        if element.tag == "replicate" and copied is None:
            copied = element
        stack.extend((child, inherited, copied) for child in reversed(element.children))
    actuators = [child for section in document.sections("actuator") for child in section.children]
    return Written(joints, tuple(replicated), tuple(attached), tuple(actuators))


def _defaults(document: XmlDocument) -> dict[str, frozenset[str]]:
    """Names of the joint attributes of each default class, those of the classes above it included."""
    found: dict[str, frozenset[str]] = {}
    stack: list[tuple[Element, str, frozenset[str]]] = [
        (section, _MAIN, frozenset()) for section in reversed(document.sections("default"))
    ]
    while stack:
        element, name, above = stack.pop()
        # Several top-level sections add to one main class.
        names = above | found.get(name, frozenset())
        for child in element.children:
            if child.tag == "joint":
                names = names.union(child.attributes)
        found[name] = names
        if name == _MAIN and element.get("class"):
            # The author may name the main class otherwise.
            found[element.get("class") or _MAIN] = names
        stack.extend(
            (child, child.get("class") or "", names)
            for child in reversed(element.children)
            if child.tag == "default"
        )
    return found
