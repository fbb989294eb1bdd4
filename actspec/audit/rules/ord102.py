from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from os.path import basename

from actspec.audit.finding import Skipped
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.ord101 import (
    binding_order,
    differing_places,
    first_drives,
    kept_names,
    scalar_joints,
    stated_order,
)
from actspec.audit.rules.source_blame import POSE, SAME
from actspec.diagnostics import Span
from actspec.fields import FIELDS
from actspec.readings.artifact import Artifact, FileKind
from actspec.readings.dict_keys import PLAIN
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


class _Kind(Enum):
    """What an order of joints is, in words with a place for what it is of."""

    ACTUATORS = "the actuators of {}"
    JOINTS = "the joints of {}"
    ISAAC = "Isaac Lab (breadth-first over {})"
    PARTED = "joints with a range and then the others, each as {}"
    ACTIONS = "the actions of {}"
    NAMES = "the joint names of {}"


@dataclass(frozen=True, slots=True)
class _Order:
    """An order of joints that a robot has, or that its policy was trained in.

    Attributes:
        kind: What it is.
        of: Of which file, or as which order.
        names: Its joints.
        span: Where a configuration says that its policy's actions are in it; None: it is a model's.
    """

    kind: _Kind
    of: str
    names: tuple[str, ...]
    span: Span | None = None

    @property
    def text(self) -> str:
        """What it is, in words."""
        return self.kind.value.format(self.of)

    def is_of(self, names: Sequence[str]) -> bool:
        """Whether joints stand in it, those apart that only one of the two has."""
        return kept_names(names, self.names) == kept_names(self.names, names)


@dataclass(frozen=True, slots=True)
class _Subject:
    """An order that a file states.

    Attributes:
        artifact: The file.
        names: Its joints.
        span: Where.
        known: The orders of its robot's models.
        trained: Those of the policies that its robot is trained with.
        alone: Whether these are of all of its trainings, and the file is of a policy in its own order.
    """

    artifact: Artifact
    names: tuple[str, ...]
    span: Span
    known: tuple[_Order, ...]
    trained: tuple[_Order, ...]
    alone: bool


class DeployOrder(RuleOver[_Subject]):
    code = "ORD102"
    name = "deploy-order-against-model"
    noted_in_folders = True
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    needs = "no joint order and model, or order of a policy's actions, of one robot among the files"

    def check(self, case: Case) -> Iterator[Finding | Skipped]:
        """The order of the names, and that of the lists beside them."""
        yield from super().check(case)
        for index, _ in case.of_kind(FileKind.DEPLOY):
            yield from self._lists(case, index)

    def _lists(self, case: Case, index: int) -> Iterator[Finding]:
        """Lists that are a configuration's in another order than the names beside them."""
        order = stated_order(case.artifacts[index])
        members = [other for other in case.robot_of(index).artifacts if other != index]
        names = order[0] if order else ()
        known = [
            item
            for other in members
            for item in (
                *_known_orders(case.artifacts[other], names),
                *_listed_order(case.artifacts[other]),
                *_trained_order(case.artifacts[other], names),
            )
        ]
        for other in members if order is not None else ():
            if case.artifacts[other].kind is not FileKind.CFG:
                continue
            apart: dict[str, list[str]] = {}
            differing: dict[str, None] = {}
            for field in _FIGURES:
                found = _moved(case, index, other, names, field, known)
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
            order = binding_order(artifact)
            if order is None or artifact.config is None:
                continue
            names, setting = order
            members = [case.artifacts[other] for other in case.robot_of(index).artifacts]
            # Of a policy's order what runs it makes the robot's.
            models = () if artifact.config.mapped else members
            known = tuple(item for member in models for item in _known_orders(member, names))
            tasks = [member for member in members if member.kind is FileKind.CFG and _acts(member)]
            if artifact.kind is not FileKind.DEPLOY or artifact.config.by_motor:
                # The robot's numbering, which the policy's order is no part of.
                tasks = []
            trained = [tuple(_trained_order(task, names)) for task in tasks]
            # actspec's own goes by name, and rl_sar's base.yaml is of no policy.
            of_policy = "sdk_order" not in artifact.config.settings and not artifact.config.stands_up
            if known or any(trained):
                yield _Subject(
                    artifact,
                    names,
                    setting.span,
                    known,
                    tuple(item for items in trained for item in items),
                    of_policy and all(trained),
                )

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Find out which order each is."""
        config = subject.artifact.config
        # A program with both orders in its file maps one to the other.
        if config is not None and config.reordered:
            return
        if any(order.is_of(subject.names) for order in subject.trained):
            return
        if subject.trained and subject.alone:
            yield self._finding(subject, subject.trained[0])
            return
        commands = [order for order in subject.known if order.kind is _Kind.ACTUATORS]
        silent = commands or [order for order in subject.known if order.kind is _Kind.JOINTS]
        if silent and not silent[0].is_of(subject.names):
            own = next((order for order in subject.known if order.is_of(subject.names)), None)
            if own is None or own not in commands:
                yield self._finding(subject, silent[0])

    def _finding(self, subject: _Subject, first: _Order) -> Finding:
        """What is said of an order that is not the first one."""
        ours, theirs = kept_names(subject.names, first.names), kept_names(first.names, subject.names)
        places = differing_places(ours, theirs)
        same = next((order for order in subject.known if order.is_of(subject.names)), None)
        text = (
            f"{len(places)} of {len(ours)} joints stand elsewhere than in the order of {first.text}, place {places[0]} "
            f"is {ours[places[0]]} and not {theirs[places[0]]}"
        )
        if subject.known:
            which = "order is none of the robot's" if same is None else f"is the order of {same.text}"
            text = f"this {which}: {text}"
        others = "; ".join(order.text for order in subject.known)
        help = f"compared: {others}; if it is the SDK's, say so, and map by name where the orders meet"
        severity, confidence = self.severity, self.confidence
        if first.span is not None:
            help = "the policy's actions are in that order: write the names and their lists in it, or map by name"
            # What commands a simulator has the order of its actuators, and a program between it and the policy.
            if same is not None and same.kind is _Kind.ACTUATORS:
                severity = Severity.INFO
        elif same is not None:
            help = "map by name where the orders meet"
            severity, confidence = Severity.INFO, Confidence.HIGH
        elif subject.artifact.kind is FileKind.CFG:
            severity, confidence = Severity.INFO, Confidence.LOW
        return Finding(
            self.code,
            text,
            subject.span,
            help=help,
            related=() if first.span is None else (first.span,),
            severity=severity,
            confidence=confidence,
            about=f"{ours[places[0]]} {theirs[places[0]]}",
        )


def _known_orders(artifact: Artifact, names: Sequence[str]) -> Iterator[_Order]:
    """Orders of a model that has enough of the names, each with what it is."""
    robot = artifact.robot
    if robot is None:
        return
    joints = scalar_joints(robot)
    shared = kept_names(joints, names)
    if not _are_enough(shared, names):
        return
    file = basename(artifact.path)
    driven = tuple(drive.target for drive in first_drives(robot))
    orders = [_Order(_Kind.JOINTS, file, joints)]
    if len(kept_names(driven, names)) == len(shared):
        orders.insert(0, _Order(_Kind.ACTUATORS, file, driven))
    isaac = isaac_order(robot, shared)
    if isaac is not None:
        orders.append(_Order(_Kind.ISAAC, file, isaac))
    yield from orders
    # Wheels are another action of the policy, and one comes after the other.
    ends = {joint.name for joint in robot.scalar_joints if joint.range is not None}
    for order in orders if 0 < len(ends & set(shared)) < len(shared) else ():
        parted = tuple(sorted(order.names, key=lambda name: name not in ends))
        if parted != order.names:
            yield _Order(_Kind.PARTED, order.text, parted)


def _are_enough(shared: Sequence[str], names: Sequence[str]) -> bool:
    """Whether so many names of an order tell that it is of this robot."""
    return len(shared) >= max(2.0, _SHARED * len(names))


def _acts(artifact: Artifact) -> bool:
    """Whether a configuration says which joints the policy commands."""
    return artifact.config is not None and bool(artifact.config.actions)


def _trained_order(artifact: Artifact, names: Sequence[str]) -> Iterator[_Order]:
    """The order of a policy's actions where its configuration writes it out, with enough of the names.

    Source: Isaac Lab 2.3.2, isaaclab/envs/mdp/actions/joint_actions.py, and mjlab 1.6.0, mjlab/envs/mdp/actions: of
    preserve_order, find_joints; action_manager.py: one term's actions after the other's.
    """
    terms = artifact.config.actions if artifact.kind is FileKind.CFG and artifact.config is not None else ()
    joints = tuple(joint for term in terms for joint in term.joints or ())
    if not all(term.ordered and term.joints for term in terms) or len(set(joints)) < len(joints):
        return
    if all(map(PLAIN.fullmatch, joints)) and _are_enough(kept_names(joints, names), names):
        yield _Order(_Kind.ACTIONS, basename(artifact.path), joints, terms[0].span)


def _listed_order(artifact: Artifact) -> Iterator[_Order]:
    """The order of joints that a configuration states."""
    order = stated_order(artifact)
    if order is not None:
        yield _Order(_Kind.NAMES, basename(artifact.path), tuple(name for name in order[0] if name))


def _moved(
    case: Case,
    index: int,
    other: int,
    names: Sequence[str],
    field: str,
    known: Sequence[_Order],
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
    for order in known:
        kept = kept_names(order.names, names)
        its = dict(zip(names, theirs, strict=True))
        if len(kept) == len(names) and _are_equal(mine, [its[name] for name in kept]):
            return f": they are in the order of {order.text}", differing
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
