from __future__ import annotations

from collections.abc import Iterator, Sequence
from os.path import basename

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.ord101 import (
    differing_places,
    first_drives,
    kept_names,
    scalar_joints,
    stated_order,
)
from actspec.diagnostics import Span
from actspec.readings.artifact import Artifact, FileKind, Setting
from actspec.robot.view import isaac_order

_SHARED = 0.8
"""Share of an order's names that a model must have to be compared. Chosen: as for pairing files."""


_Subject = tuple[Artifact, list[tuple[str, tuple[str, ...]]], tuple[str, ...], Setting]


class DeployOrder(RuleOver[_Subject]):
    code = "ORD102"
    name = "deploy-order-against-model"
    noted_in_folders = True
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    needs = "no joint order and model of one robot among the files"

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
