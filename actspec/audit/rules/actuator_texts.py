"""Actuators of an MJCF with the text that they come from: compiled numbers alone do not tell what was meant."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass
from functools import cache

from actspec.audit.case import Case
from actspec.diagnostics import Span
from actspec.ir import JointKind
from actspec.readings.artifact import Artifact, FileKind
from actspec.readings.ledger import LedgerRow
from actspec.robot.mjcf_actuator_text import ActuatorText, actuator_text, class_text, numbers
from actspec.robot.mjcf_elements import read_elements
from actspec.robot.view import ActuatorView, JointView, RobotView
from actspec.robot.xml import parse_document
from actspec.robot.xml_tree import Element, XmlDocument
from actspec.units import format_quantity

NO_DELAY = "no MJCF with a delay among the files"

NO_ACTUATORS = "no MJCF with actuators among the files"


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
        return self.view.target if self.view.is_direct else ""

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

    A file is parsed anew for it, which takes longer than a rule: only files with such an actuator are, once.

    Args:
        case: The case.
        attribute: Name; files in which it does not stand are not parsed.
        two_of: Nor are files with less than two of these, where some are given.
        which: Compiled actuators that are wanted.
    """
    for index, artifact in case.of_kind(FileKind.MJCF):
        robot = artifact.robot
        wanted = [] if robot is None else [view for view in robot.actuators if which(robot, view)]
        if robot is None or not wanted or not any(attribute in file.data for file in robot.files):
            continue
        if two_of and sum(any(one in file.data for file in robot.files) for one in two_of) < 2:
            continue
        text = case.once_of(_Text, index)
        for view in wanted:
            found = text.actuator(view)
            if found is not None:
                yield found


class _Text:
    """An MJCF as text, and its actuators as far as a rule has asked for them."""

    def __init__(self, artifact: Artifact) -> None:
        assert artifact.robot is not None
        self._artifact = artifact
        self.document = parse_document(artifact.robot.files)
        self._written = read_elements(self.document)
        self._elements = {self.document.span(element): element for element in self._written.actuators}
        self._class_text = cache(class_text)
        self._actuators: dict[int, WrittenActuator | None] = {}

    def actuator(self, view: ActuatorView) -> WrittenActuator | None:
        """An actuator; None for a copy by `replicate` or `attach`, and for one whose class is in another file."""
        if view.index not in self._actuators:
            self._actuators[view.index] = self._actuator(view)
        return self._actuators[view.index]

    def joint(self, name: str) -> dict[str, str]:
        """The attributes of a joint's clamp, its classes' too, without `actuatorfrc` before them; 2.3 has the words."""
        found = self._written.joint(name)
        owners = {} if found is None else found[0].owners
        return {
            attribute.removeprefix(word): owners[attribute].get(attribute) or ""
            for word in ("actuatorforce", "actuatorfrc")
            for attribute in (f"{word}range", f"{word}limited")
            if attribute in owners
        }

    def _actuator(self, view: ActuatorView) -> WrittenActuator | None:
        element = self._elements.get(view.span)
        if element is None or not self._written.knows_class(element):
            # Of a part of a model whose classes are elsewhere, the element alone does not tell what it is.
            return None
        classes = self._written.defaults_of(element).actuators
        text = actuator_text(self._class_text(classes), element)
        return WrittenActuator(view, text, element, self.document, self._artifact, classes)


def drives_in_mjcf(case: Case) -> bool:
    """Whether an MJCF with an actuator is among the files."""
    return any(
        artifact.robot is not None and artifact.robot.actuators for _, artifact in case.of_kind(FileKind.MJCF)
    )


def delayed(case: Case) -> Iterator[tuple[WrittenActuator, float]]:
    """Actuators with a delay, and their step [s]."""
    for found in written_actuators(case, b"delay"):
        step = found.artifact.robot.timestep if found.artifact.robot is not None else None
        # The text alone does not know a delay without nsample, which MuJoCo refuses.
        if step is not None and step > 0.0 and found.view.delay > 0.0 and "delay" not in found.view.unknown:
            yield found, step


def stored_samples(found: WrittenActuator) -> int | None:
    owner = found.owner("nsample")
    value = numbers(owner.get("nsample"), 1) if owner is not None else ()
    return int(value[0]) if value and math.isfinite(value[0]) else None


def is_interpolated(found: WrittenActuator) -> bool:
    owner = found.owner("interp")
    return owner is not None and owner.get("interp") != "zoh"


def milliseconds(seconds: float) -> str:
    return format_quantity(1000.0 * seconds, "ms", 3)


def place_of(found: WrittenActuator, *names: str) -> Span:
    """Where the first of the attributes stands: a default class's place, or the actuator's."""
    own = [name for name in names if name in found.element.attributes]
    if own:
        return found.view.span
    return next((found.view.places[name] for name in names if name in found.view.places), found.view.span)


def drives_kind(found: WrittenActuator, kind: JointKind) -> bool:
    robot = found.artifact.robot
    joint: JointView | None = robot.joint(found.view.target) if robot is not None else None
    return joint is not None and joint.kind is kind


def ranges_not_in_force(case: Case, name: str) -> dict[Span, tuple[float, float]]:
    """Ranges that are written at actuators which have none, by the actuators' places.

    Args:
        case: The case.
        name: What they are ranges of: `force`, `ctrl` or `act`.
    """
    written, limited = f"{name}range", f"{name}limited"

    def is_free(_: object, view: ActuatorView) -> bool:
        ends = {"force": view.force_range, "ctrl": view.control_range, "act": view.input_range}[name]
        return ends is None and written in view.stated

    ranges = {}
    for found in written_actuators(case, written.encode(), which=is_free):
        owner = found.owner(written)
        ends = numbers(owner.get(written), 2) if owner is not None else ()
        off = _last(found, limited) == "false" or (name == "force" and ends[:1] == ends[1:])
        if len(ends) == 2 and off and all(map(math.isfinite, ends)):
            ranges[found.view.span] = (ends[0], ends[1])
    return ranges


def clamps_not_in_force(case: Case) -> dict[tuple[int, str], tuple[float, float]]:
    """Ranges of joints for what their actuators give that are switched off, by the MJCF's artifact and the joint.

    Args:
        case: The case.

    Returns: low and high end [N*m or N].
    """
    ranges = {}
    for index, artifact in case.of_kind(FileKind.MJCF):
        robot = artifact.robot
        if robot is None or not any(b"actuatorf" in file.data for file in robot.files):
            continue
        for joint in robot.joints:
            if joint.effort_range is None and "effort" in joint.stated:
                found = case.once_of(_Text, index).joint(joint.name)
                ends = numbers(found.get("range"), 2)
                if found.get("limited") == "false" and len(ends) == 2 and all(map(math.isfinite, ends)):
                    ranges[index, joint.name] = (ends[0], ends[1])
    return ranges


def compiler_of(case: Case, artifact: int) -> tuple[Span, str]:
    """Where an MJCF states how it is read, and the angle that it states there, "" for none.

    Args:
        case: The case.
        artifact: An MJCF.

    Returns: the place of the `compiler` of its own file, else of another one, else of its root.
    """
    document = case.once_of(_Text, artifact).document
    found = sorted(document.sections("compiler"), key=lambda element: element.file > 0)
    stated = (angle for element in reversed(found) if (angle := element.get("angle")))
    return document.span(found[0] if found else document.root), next(stated, "")


_ANGLES = {"euler": slice(0, 3), "axisangle": slice(3, 4)}
"""Attributes with numbers that `<compiler angle>` makes degrees or radians of, beside those of joints.

Source: MuJoCo 4.0.0, measured: `angle="radian"` makes of euler="90 0 0" and axisangle="1 0 0 90" 90 rad each.
"""


def written_in_degrees(case: Case, artifact: int) -> str | None:
    """Where a pose in an MJCF has an angle of more than a turn, were it in radians, and which; None: none has."""
    document = case.once_of(_Text, artifact).document
    for element in document.walk():
        for name, part in _ANGLES.items():
            text = element.get(name) or ""
            if any(2.0 * math.pi < abs(angle) < math.inf for angle in numbers(text, 4)[part]):
                place = document.span(element)
                own = place.path == case.artifacts[artifact].path
                return f'{name}="{text}"' + ("" if own else f" in {place.path}:{place.line}")
    return None


def is_turned(case: Case, row: LedgerRow, view: ActuatorView | None) -> bool:
    """Whether a range that was meant to limit an actuator begins above its end, which AUD022 has."""
    robot = case.artifacts[row.artifact].robot
    joint = None if robot is None else robot.joint(row.joint)
    places = {joint.places.get("effort", joint.span)} if joint and "effort" in joint.stated else set()
    stated = (
        () if view is None else ((view, name) for name in ("forcerange", "ctrlrange") if name in view.stated)
    )
    places.update(one.places.get(name, one.span) for one, name in stated)
    return bool(places & case.once(_turned))


def _turned(case: Case) -> frozenset[Span | None]:
    """Where such ranges are written."""
    return frozenset(
        item.span
        for file in case.files
        for item in file.diagnostics
        if item.code == "ROBOT123" and file.kind is FileKind.MJCF
    )


def _last(found: WrittenActuator, name: str) -> str | None:
    owner = found.owner(name)
    return owner.get(name) if owner is not None else None
