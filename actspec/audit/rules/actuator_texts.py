"""Actuators of an MJCF with the text that they come from: compiled numbers alone do not tell what was meant."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from functools import cache

from actspec.audit.artifact import Artifact, FileKind
from actspec.audit.case import Case
from actspec.robot.mjcf_actuator_text import ActuatorText, actuator_text, class_text
from actspec.robot.mjcf_elements import read_elements
from actspec.robot.view import ActuatorView, RobotView
from actspec.robot.xml import parse_document
from actspec.robot.xml_tree import Element, XmlDocument


@dataclass(frozen=True, slots=True)
class WrittenActuator:
    """One actuator as compiled and as written.

    Attributes:
        view: As compiled.
        text: As its element and default classes have it; nan where they do not tell.
        element: Its own element.
        document: What it is in.
        artifact: Of which robot.
        classes: Elements of actuators of each class on the way to its own, the outermost first.
    """

    view: ActuatorView
    text: ActuatorText
    element: Element
    document: XmlDocument
    artifact: Artifact
    classes: tuple[tuple[Element, ...], ...]

    @property
    def joint(self) -> str:
        """The joint that it drives; "" for a tendon, a site or a joint without a name."""
        return self.view.target if self.view.transmission in ("joint", "jointinparent") else ""

    def owner(self, name: str) -> Element | None:
        """The element that states an attribute last: its own, or one of its default classes."""
        chain = (*(one for elements in self.classes for one in elements), self.element)
        return next((one for one in reversed(chain) if name in one.attributes), None)


def _any(_: RobotView, __: ActuatorView) -> bool:
    return True


def written_actuators(
    case: Case,
    attribute: bytes = b"",
    two_of: Collection[bytes] = (),
    which: Callable[[RobotView, ActuatorView], bool] = _any,
) -> Iterator[WrittenActuator]:
    """Actuators of all MJCF that have an attribute somewhere; copies by `replicate` or `attach` are left out.

    A file is parsed anew for it, which takes longer than a rule: only files with such an actuator are.

    Args:
        case: The case.
        attribute: Name; files in which it does not stand are not parsed.
        two_of: Nor are files with less than two of these, where some are given.
        which: Compiled actuators that are wanted.
    """
    for _, artifact in case.of_kind(FileKind.MJCF):
        robot = artifact.robot
        wanted = [] if robot is None else [view for view in robot.actuators if which(robot, view)]
        if robot is None or not wanted or not any(attribute in file.data for file in robot.files):
            continue
        if two_of and sum(any(one in file.data for file in robot.files) for one in two_of) < 2:
            continue
        document = parse_document(robot.files)
        written = read_elements(document)
        folded = cache(class_text)
        elements = {document.span(element): element for element in written.actuators}
        for view in wanted:
            element = elements.get(view.span)
            if element is not None:
                classes = written.defaults_of(element).actuators
                text = actuator_text(folded(classes), element)
                yield WrittenActuator(view, text, element, document, artifact, classes)


def drives_in_mjcf(case: Case) -> bool:
    """Whether an MJCF with an actuator is among the files."""
    return any(
        artifact.robot is not None and artifact.robot.actuators for _, artifact in case.of_kind(FileKind.MJCF)
    )
