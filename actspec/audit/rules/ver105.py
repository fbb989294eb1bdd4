from __future__ import annotations

from collections.abc import Iterator

from actspec.audit.case import Case
from actspec.audit.finding import Confidence, Finding
from actspec.audit.rule import RuleOver
from actspec.audit.rules.mujoco_features import WORDS, Feature, used_features
from actspec.diagnostics import Severity, Span
from actspec.readings.artifact import FileKind
from actspec.readings.versions import Meant, mujoco_of
from actspec.robot.view import RobotView
from actspec.robot.xml import parse_document
from actspec.simulators import Release


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
        words = {word for feature, word in WORDS if _may_be_told(feature, meant)}
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
            yield Finding(self.code, f"{feature.what}{_count(places)} {text}", places[0], help=help)

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
                )


def _may_be_told(feature: Feature, meant: Meant | None) -> bool:
    """Whether there is something to say about it."""
    if meant is None:
        return feature.until is not None
    gone = feature.until is not None and meant.release[:2] > feature.until
    return gone or meant.before(feature.since)


def _text(release: Release) -> str:
    return ".".join(map(str, release))


def _count(places: list[Span]) -> str:
    return f" (in {len(places)} places)" if len(places) > 1 else ""
