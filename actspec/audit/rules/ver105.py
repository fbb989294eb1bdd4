from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.diagnostics import Span
from actspec.readings.artifact import FileKind
from actspec.readings.versions import Meant, mujoco_of
from actspec.robot.mjcf_elements import ACTUATORS
from actspec.robot.view import RobotView
from actspec.robot.xml import parse_document
from actspec.robot.xml_tree import Element, XmlDocument
from actspec.simulators import Release
from actspec.simulators.mujoco import DCMOTOR, GENERAL_INPUT, NATIVE_DELAY, POLYNOMIALS


@dataclass(frozen=True, slots=True)
class Feature:
    """Something in an MJCF with the releases that read it.

    Attributes:
        what: For a message.
        since: First release.
        until: Last release; None: all later ones.
    """

    what: str
    since: Release
    until: Release | None = None


_LIMIT = Feature("a joint's actuatorfrcrange", (3, 0))
_OF_JOINT = {
    "actuatorfrcrange": _LIMIT,
    "actuatorfrclimited": _LIMIT,
    "actuatorforcerange": Feature("actuatorforcerange", (2, 3), (2, 3)),
    "springyield": Feature("a joint's springyield", (4, 0)),
}
_OF_TENDON = {
    "actuatorfrcrange": Feature("a tendon's actuatorfrcrange", (3, 3, 1)),
    "armature": Feature("a tendon's armature", (3, 3, 1)),
}
_OF_ACTUATOR = {
    "actearly": Feature("actearly", (3, 0)),
    "inheritrange": Feature("inheritrange", (3, 1, 3)),
    "dampratio": Feature("dampratio", (3, 1, 6)),
    "delay": Feature("an actuator's delay", NATIVE_DELAY),
    "nsample": Feature("an actuator's nsample", NATIVE_DELAY),
    "damping": Feature("an actuator's damping", POLYNOMIALS),
    "armature": Feature("an actuator's armature", POLYNOMIALS),
}
_OF_TAG = {"dcmotor": Feature("dcmotor", DCMOTOR), "pid": Feature("pid", (3, 12))}
_KV = Feature("kv of a position servo", (3, 1))
_TIME_CONSTANT = Feature("timeconst of a position servo", (3, 1, 6))
_INPUT = Feature("input of a servo", GENERAL_INPUT)
_POLYNOMIALS = ("damping", "stiffness")
_POLYNOMIAL = Feature("a polynomial of damping or stiffness", POLYNOMIALS)
_VALUES = {
    ("option", "integrator", "implicitfast"): Feature("implicitfast", (3, 0)),
    ("option", "integrator", "discrete"): Feature("the integrator discrete", (3, 13)),
    ("general", "dyntype", "filterexact"): Feature("filterexact", (3, 0)),
}

WORDS = (
    *(
        (feature, name.encode())
        for table in (_OF_JOINT, _OF_TENDON, _OF_ACTUATOR, _OF_TAG)
        for name, feature in table.items()
    ),
    *((feature, name.encode()) for (_, name, _), feature in _VALUES.items()),
    *((_POLYNOMIAL, name.encode()) for name in _POLYNOMIALS),
    (_KV, b"kv"),
    (_TIME_CONSTANT, b"timeconst"),
    (_INPUT, b"input"),
)
"""Features with the tags and attributes without which a file has none of them; a value may be written otherwise."""


def used_features(document: XmlDocument) -> dict[Feature, list[Span]]:
    """What a file has of the features, with its places."""
    found: dict[Feature, list[Span]] = {}
    stack = [(document.root, "")]
    while stack:
        element, section = stack.pop()
        for feature in _features(element, section):
            found.setdefault(feature, []).append(document.span(element))
        inner = element.tag if section in ("", "mujoco") else section
        stack.extend((child, inner) for child in reversed(element.children))
    return found


_TENDONS = ("spatial", "fixed")
_TAGS = frozenset((*(owner for owner, _, _ in _VALUES), "joint", *_TENDONS, *ACTUATORS))


def _features(element: Element, section: str) -> Iterator[Feature]:
    """What one element has.

    Args:
        element: Of the file.
        section: Child of the root that it is in.
    """
    tag = element.tag
    if tag not in _TAGS:
        return
    attributes = element.values
    for (owner, name, value), feature in _VALUES.items():
        if tag == owner and attributes.get(name) == value:
            yield feature
    if tag == "joint" and section in ("worldbody", "default"):
        yield from dict.fromkeys(feature for name, feature in _OF_JOINT.items() if name in attributes)
        if any(len(attributes.get(name, "").split()) > 1 for name in _POLYNOMIALS):
            yield _POLYNOMIAL
    elif tag in _TENDONS and section == "tendon":
        yield from (feature for name, feature in _OF_TENDON.items() if name in attributes)
    elif tag in ACTUATORS and section in ("actuator", "default"):
        yield from _of_actuator(element)


def _of_actuator(element: Element) -> Iterator[Feature]:
    tag, attributes = element.tag, element.values
    if tag in _OF_TAG:
        # Everything else in it is as old or older.
        yield _OF_TAG[tag]
        return
    yield from (feature for name, feature in _OF_ACTUATOR.items() if name in attributes)
    if tag == "position" and "kv" in attributes:
        yield _KV
    if tag == "position" and "timeconst" in attributes:
        yield _TIME_CONSTANT
    if tag in ("position", "velocity", "intvelocity", "general", "motor") and "input" in attributes:
        yield _INPUT


class NeedsAnotherMujoco(RuleOver[RobotView]):
    code = "VER105"
    name = "needs-another-mujoco"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    needs = "no MJCF among the files"

    def subjects(self, case: Case) -> Iterator[RobotView]:
        for _, artifact in case.of_kind(FileKind.MJCF):
            if artifact.robot is not None:
                yield artifact.robot

    def judge(self, case: Case, robot: RobotView) -> Iterator[Finding]:
        """Compare each file with the release."""
        meant = mujoco_of(case.versions)
        words = {word for feature, word in WORDS if _may_apply(feature, meant)}
        if not any(word in file.data for file in robot.files for word in words):
            return
        document = parse_document(robot.files)
        used = used_features(document)
        if meant is not None:
            yield from self._against(used, meant)
        else:
            yield from self._together(used)

    def _against(self, used: dict[Feature, list[Span]], meant: Meant) -> Iterator[Finding]:
        for feature, places in used.items():
            if meant.before(feature.since):
                text = f"came with MuJoCo {_text(feature.since)}: {meant.text} refuses the file"
                help = f"use MuJoCo {_text(feature.since)} or later, or leave it out"
            elif feature.until is not None and meant.release[:2] > feature.until:
                text = f"went after MuJoCo {_text(feature.until)}: {meant.text} refuses the file"
                help = "write actuatorfrcrange"
            else:
                continue
            yield Finding(
                self.code,
                f"{feature.what}{_count(places)} {text}",
                places[0],
                help=help,
                about=feature.what,
            )

    def _together(self, used: dict[Feature, list[Span]]) -> Iterator[Finding]:
        newest = max(used, key=lambda feature: feature.since, default=None)
        for feature, places in used.items():
            if newest is not None and feature.until is not None and newest.since > feature.until:
                yield Finding(
                    self.code,
                    f"{feature.what}{_count(places)} went after MuJoCo {_text(feature.until)}, and {newest.what} came "
                    f"with {_text(newest.since)}: no release reads this file",
                    places[0],
                    help="write actuatorfrcrange",
                    related=(used[newest][0],),
                    about=feature.what,
                )


def _may_apply(feature: Feature, meant: Meant | None) -> bool:
    """Whether there is something to say about it."""
    if meant is None:
        return feature.until is not None
    gone = feature.until is not None and meant.release[:2] > feature.until
    return gone or meant.before(feature.since)


def _text(release: Release) -> str:
    return ".".join(map(str, release))


def _count(places: list[Span]) -> str:
    return f" (in {len(places)} places)" if len(places) > 1 else ""
