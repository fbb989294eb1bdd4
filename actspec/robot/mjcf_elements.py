"""Where an MJCF's joints and actuators are written, and what their default classes state.

The numbers come from MuJoCo; this only says which of them the author wrote, and where.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, RobotError, Span
from actspec.robot.attached import key_of
from actspec.robot.xml_tree import NUMBER

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

MOST_GEAR = 1e100
"""Chosen: the squares of gears beyond 1e154 are no floats."""


@dataclass(frozen=True, slots=True)
class JointElement:
    """One joint as it is written.

    Attributes:
        element: The `joint` or `freejoint`.
        owners: Each of its attributes and of those of its default classes, with the element that states it.
        span: Its line; for a copy by `replicate` the line of the outermost `replicate`.
        body: Name of its body.
        parent: The named joint that it hangs on; "" for a joint of the base, which a free joint moves.
        copied: Whether it is inside a `replicate`, whose copies have names that begin with its own.
    """

    element: Element
    owners: Mapping[str, Element]
    span: Span
    body: str
    parent: str
    copied: bool

    @property
    def name(self) -> str:
        """Its name; "" without one."""
        return self.element.get("name") or ""

    @property
    def type(self) -> str:
        """Its type: `hinge` where nothing says."""
        if self.element.tag == "freejoint":
            return "free"
        return (self.owners["type"].get("type") if "type" in self.owners else None) or "hinge"


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


NO_CLASS = DefaultClass({}, (), {})


@dataclass(frozen=True, slots=True)
class Attachment:
    """One `attach`.

    Attributes:
        prefix: Before each name that it brings.
        suffix: After it.
        span: Its line.
        model: The model that it takes them from; None where that was not read.
    """

    prefix: str
    suffix: str
    span: Span
    model: Written | None

    def name_in_model(self, name: str) -> str | None:
        """What a compiled name is there; None where it is none that this brings."""
        ends = len(self.prefix) + len(self.suffix)
        if len(name) <= ends or not (name.startswith(self.prefix) and name.endswith(self.suffix)):
            return None
        return name[len(self.prefix) : len(name) - len(self.suffix)]


@dataclass(frozen=True, slots=True)
class Written:
    """Joints, actuators and attachments of an MJCF as they are written.

    Attributes:
        document: What they are in.
        joints: In MuJoCo's order: those of a body, then those of the bodies in it.
        named: Those that have a name and are no copies, by it.
        attached: Each `attach`.
        actuators: Elements of all `actuator` sections, in order.
        defaults: Default classes by name.
    """

    document: XmlDocument
    joints: tuple[JointElement, ...]
    named: Mapping[str, JointElement]
    attached: tuple[Attachment, ...]
    actuators: tuple[Element, ...]
    defaults: Mapping[str, DefaultClass]

    def joint(self, name: str) -> tuple[JointElement, XmlDocument] | None:
        """The joint of a compiled name, an attached one's too, or what it is a copy of; and the text that it is in."""
        if name in self.named:
            return self.named[name], self.document
        for model, own in self._in_attached(name):
            found = model.joint(own)
            if found is not None:
                return found
        copies = [one for one in self.joints if one.copied and one.name and name.startswith(one.name)]
        return (max(copies, key=lambda one: len(one.name)), self.document) if copies else None

    def actuator(self, name: str) -> tuple[Element, Written] | None:
        """The actuator of a compiled name, and the model that it is written in, this or an attached one."""
        found = next((one for one in self.actuators if name and one.get("name") == name), None)
        if found is not None:
            return found, self
        inner = (model.actuator(own) for model, own in self._in_attached(name))
        return next((one for one in inner if one is not None), None)

    def _in_attached(self, name: str) -> Iterator[tuple[Written, str]]:
        """Attached models that a compiled name may come from, with what it is there."""
        for one in self.attached:
            own = one.name_in_model(name)
            if own is not None and one.model is not None:
                yield one.model, own

    def defaults_of(self, actuator: Element) -> DefaultClass:
        """The default class of an actuator."""
        return self.defaults.get(actuator.get("class") or _MAIN, NO_CLASS)

    def knows_class(self, actuator: Element) -> bool:
        """Whether the default class that an actuator names is here; in a part of a model it may be its includer's."""
        name = actuator.get("class")
        return name is None or name in self.defaults

    def attachment(self, name: str) -> Span | None:
        """The `attach` that a compiled name comes from; one that changes no name may bring any."""
        named = (one for one in self.attached if one.prefix or one.suffix)
        return next((one.span for one in named if one.name_in_model(name) is not None), None)


def read_elements(document: XmlDocument, models: Mapping[str, XmlDocument] | None = None) -> Written:
    """Walk an MJCF's bodies and actuators.

    Args:
        document: Parsed, with its includes in place.
        models: The models that it attaches and they attach, by the file names that `key_of` makes; None: not looked at.

    Raises: RobotError: ROBOT127, a gear of which no float holds the square.
    """
    return _read(document, models or {}, {})


def _read(document: XmlDocument, models: Mapping[str, XmlDocument], known: dict[str, Written]) -> Written:
    """`read_elements`; `known` are the models that have been read, by their key."""
    files = _files_of_models(document, models)
    defaults = _defaults(document)
    joints: list[JointElement] = []
    attached: list[Attachment] = []
    # An explicit stack: (body, inherited class, outermost replicate, joint that it hangs on).
    stack: list[tuple[Element, str, Element | None, str]] = [
        (section, _MAIN, None, "") for section in reversed(document.sections("worldbody"))
    ]
    while stack:
        body, inherited, outer, parent = stack.pop()
        below: list[tuple[Element, str, Element | None]] = []
        # Frames and replicas are no bodies, and keep the document's order.
        parts = [(body, inherited, outer)]
        while parts:
            element, inherited, copied = parts.pop()
            if element.tag in ("joint", "freejoint"):
                own = defaults.get(element.get("class") or inherited, NO_CLASS)
                base = {} if element.tag == "freejoint" else own.joint
                owners = {**base, **dict.fromkeys(element.values, element)}
                span = document.span(element if copied is None else copied)
                name = body.get("name") or ""
                joints.append(JointElement(element, owners, span, name, parent, copied is not None))
                parent = parent if joints[-1].type == "free" else joints[-1].name or parent
            elif element.tag == "attach":
                prefix, suffix = element.get("prefix") or "", element.get("suffix") or ""
                key = files.get(element.get("model") or "")
                if key is not None and key not in known:
                    known[key] = _read(models[key], models, known)
                model = None if key is None else known[key]
                attached.append(Attachment(prefix, suffix, document.span(element), model))
            elif element.tag == "body" and element is not body:
                below.append((element, inherited, copied))
            elif element is body or element.tag in ("frame", "replicate"):
                inherited = element.get("childclass") or inherited
                copied = element if element.tag == "replicate" and copied is None else copied
                parts += [(child, inherited, copied) for child in reversed(element.children)]
        stack += [(*child, parent) for child in reversed(below)]
    actuators = [child for section in document.sections("actuator") for child in section.children]
    _check_gears(document, actuators, defaults)
    named = {one.name: one for one in reversed(joints) if one.name and not one.copied}
    return Written(document, tuple(joints), named, tuple(attached), tuple(actuators), defaults)


def _files_of_models(document: XmlDocument, models: Mapping[str, XmlDocument]) -> dict[str, str]:
    """The models that an MJCF may attach, as an `attach` calls them, to their keys; one without a name has its own."""
    found = document.walk("model") if models else ()
    keys = ((element, key_of(element.get("file") or "")) for element in found)
    return {
        element.get("name") or models[key].root.get("model") or "": key
        for element, key in keys
        if key in models
    }


def _check_gears(
    document: XmlDocument, actuators: Sequence[Element], defaults: Mapping[str, DefaultClass]
) -> None:
    classes = (one.attributes.get("gear") for one in defaults.values())
    out = Collector()
    for element in dict.fromkeys((*actuators, *(one for one in classes if one is not None))):
        first = next(iter((element.get("gear") or "").split()), "")
        if NUMBER.fullmatch(first) and abs(float(first)) > MOST_GEAR:
            message = f"a gear of {first[:24]} is none of a robot: gains are multiplied by its square"
            out.error("ROBOT127", message, span=document.span(element))
    out.raise_if_failed(RobotError)


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
