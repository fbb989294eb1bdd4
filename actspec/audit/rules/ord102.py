from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from os.path import basename

from actspec.audit.finding import Skipped
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.ord101 import (
    differing_places,
    first_drives,
    kept_names,
    scalar_joints,
    stated_order,
)
from actspec.audit.rules.source_blame import POSE, SAME
from actspec.diagnostics import Span
from actspec.fields import FIELDS
from actspec.readings.artifact import Artifact, FileKind, Setting
from actspec.robot.view import isaac_order

_SHARED = 0.8
"""Share of an order's names that a model must have to be compared. Chosen: as for pairing files."""


_FIGURES = ("default_position", "kp", "kd", "action_scale")
"""Lists of a deploy file that a configuration states too."""

_TELLS = 3
"""Different values, and places at which two lists have others, from which the same values by chance are none.
Chosen: two exchanged joints are two, and a leg's hip and knee have two gains."""


_LEAST = 4
"""Joints of a list from which on an order is told from its figures. Chosen: two hips and two knees."""

_Subject = tuple[Artifact, list[tuple[str, tuple[str, ...]]], tuple[str, ...], Setting]


class DeployOrder(RuleOver[_Subject]):
    code = "ORD102"
    name = "deploy-order-against-model"
    noted_in_folders = True
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    needs = "no joint order and model of one robot among the files"

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """The order of the names, and that of the lists beside them."""
        yield from super().check(case)
        for index, _ in case.of_kind(FileKind.DEPLOY):
            yield from self._lists(case, index)

    def _lists(self, case: Case, index: int) -> Iterator[Finding]:
        """Lists that are a configuration's in another order than the names beside them."""
        order = stated_order(case.artifacts[index])
        members = [other for other in case.robot_of(index).artifacts if other != index]
        known = [
            item
            for other in members
            for item in (
                *_known_orders(case.artifacts[other], order[0] if order else ()),
                *_listed_order(case.artifacts[other]),
            )
        ]
        for other in members if order is not None else ():
            if case.artifacts[other].kind is not FileKind.CFG:
                continue
            apart: dict[str, list[str]] = {}
            differing: dict[str, None] = {}
            for field in _FIGURES:
                found = _moved(case, index, other, order[0] if order else (), field, known)
                if found is not None:
                    apart.setdefault(found[0], []).append(field)
                    differing |= dict.fromkeys(found[1])
            for text, fields in apart.items():
                for joint in differing:
                    row, its = case.joints[index, joint][0], case.joints[other, joint][0]
                    yield Finding(
                        self.code,
                        f"{_and(FIELDS[field].noun for field in fields)}: these are the figures of "
                        f"{basename(case.artifacts[other].path)} in another order than the joint names here{text}",
                        row.place(fields[0]),
                        joint,
                        help="write them in the order of the names, or the names in theirs",
                        related=(its.place(fields[0]),),
                        severity=self.severity,
                        confidence=Confidence.HIGH if text else self.confidence,
                        fields=tuple(fields),
                        about=" ".join(fields),
                    )

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for index, artifact in enumerate(case.artifacts):
            order = stated_order(artifact)
            if order is None:
                continue
            names, setting = order
            models = [
                case.artifacts[other]
                for other in case.robot_of(index).artifacts
                if case.artifacts[other].robot is not None
            ]
            known = [item for model in models for item in _known_orders(model, names)]
            if not known:
                continue
            yield artifact, known, names, setting

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Find out which order each is."""
        artifact, known, names, setting = subject
        commands = [item for item in known if item[0].startswith("the actuators")]
        silent = commands or [item for item in known if item[0].startswith("the joints")]
        if not any(differing_places(kept_names(names, own), kept_names(own, names)) for _, own in silent[:1]):
            return
        finding = self._finding(artifact, names, setting.span, known, silent[0])
        if finding is not None:
            yield finding

    def _finding(
        self,
        artifact: Artifact,
        names: Sequence[str],
        span: Span,
        known: Sequence[tuple[str, tuple[str, ...]]],
        first: tuple[str, tuple[str, ...]],
    ) -> Finding | None:
        ours, theirs = kept_names(names, first[1]), kept_names(first[1], names)
        places = differing_places(ours, theirs)
        same = next(
            (
                text
                for text, own in known
                if not differing_places(kept_names(names, own), kept_names(own, names))
            ),
            None,
        )
        differ = f"{len(places)} of {len(ours)} joints stand elsewhere than in the order of {first[0]}"
        if same is not None and same.startswith("the actuators"):
            return None
        text = (
            f"this is the order of {same}: {differ}"
            if same
            else f"this order is none of the robot's: {differ}"
        )
        others = "; ".join(text for text, _ in known)
        stated = artifact.kind is FileKind.CFG
        return Finding(
            self.code,
            f"{text}, place {places[0]} is {ours[places[0]]} and not {theirs[places[0]]}",
            span,
            help="map by name where the orders meet"
            if same
            else f"compared: {others}; if it is the SDK's, say so, and map by name where the orders meet",
            severity=Severity.INFO if same or stated else self.severity,
            confidence=Confidence.HIGH if same else Confidence.LOW if stated else self.confidence,
            about=f"{ours[places[0]]} {theirs[places[0]]}",
        )


def _known_orders(artifact: Artifact, names: Sequence[str]) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Orders of a model that has enough of the names, each with what it is."""
    robot = artifact.robot
    if robot is None:
        return
    joints = scalar_joints(robot)
    shared = kept_names(joints, names)
    if len(shared) < max(2.0, _SHARED * len(names)):
        return
    file = basename(artifact.path)
    driven = tuple(drive.target for drive in first_drives(robot))
    if len(kept_names(driven, names)) == len(shared):
        yield f"the actuators of {file}", driven
    yield f"the joints of {file}", joints
    isaac = isaac_order(robot, shared)
    if isaac is not None:
        yield f"Isaac Lab (breadth-first over {file})", isaac


def _listed_order(artifact: Artifact) -> Iterator[tuple[str, tuple[str, ...]]]:
    """The order of joints that a configuration states."""
    order = stated_order(artifact)
    if order is not None:
        yield f"the joint names of {basename(artifact.path)}", tuple(name for name in order[0] if name)


def _moved(
    case: Case,
    index: int,
    other: int,
    names: Sequence[str],
    field: str,
    known: Sequence[tuple[str, tuple[str, ...]]],
) -> tuple[str, list[str]] | None:
    """The order that a deploy file's list is in, as words or "", and the joints at which it is not a configuration's.

    None where it is not the configuration's in another order.
    """
    mine, theirs = (_list(case, one, names, field) for one in (index, other))
    if len(names) < _LEAST or not mine or not theirs or not _are_equal(sorted(mine), sorted(theirs)):
        return None
    differing = [name for name, a, b in zip(names, mine, theirs, strict=True) if not _are_equal([a], [b])]
    if not differing:
        return None
    for text, order in known:
        kept = kept_names(order, names)
        its = dict(zip(names, theirs, strict=True))
        if len(kept) == len(names) and _are_equal(mine, [its[name] for name in kept]):
            return f": they are in the order of {text}", differing
    return ("", differing) if min(len(differing), len(set(mine))) >= _TELLS else None


def _list(case: Case, artifact: int, names: Sequence[str], field: str) -> list[float]:
    """What an artifact states of each of the joints; empty where it does not of one."""
    rows = [case.joints.get((artifact, name), ())[:1] for name in names]
    stated = [getattr(row, field) for own in rows for row in own if field in row.stated]
    return stated if len(stated) == len(names) and None not in stated else []


def _are_equal(one: Sequence[float], other: Sequence[float]) -> bool:
    """Whether two lists have the same figures, as the rules that compare two files have it."""
    return all(math.isclose(a, b, rel_tol=SAME, abs_tol=POSE) for a, b in zip(one, other, strict=True))


def _and(words: Iterable[str]) -> str:
    *others, last = words
    return f"{', '.join(others)} and {last}" if others else last
