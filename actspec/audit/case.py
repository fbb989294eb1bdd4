"""Everything that the rules judge: the artifacts, the ledger, and which artifacts are one robot."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TypeVar, cast

from actspec.audit.drawn import drawn_anew, set_otherwise
from actspec.diagnostics import Span
from actspec.readings.artifact import Artifact, FileKind, FileReading, Framework, Robot
from actspec.readings.ledger import LedgerRow
from actspec.readings.versions import Versions, meant_for

_T = TypeVar("_T")


MODELS = frozenset({FileKind.MJCF, FileKind.URDF})
"""Files of a robot itself, to which the others give drives."""

_WRITTEN: dict[FileKind | None, frozenset[str]] = {
    FileKind.URDF: frozenset(
        {"urdf_effort", "urdf_limit", "urdf_dynamics", "dynamics", "damping", "friction"}
    ),
    FileKind.MJCF: frozenset(
        {"angle", "integrator", "compiled", "dynamics", "damping", "friction", "step", "gains", "range"}
    ),
    FileKind.CFG: frozenset(
        {"actuators", "joints", "gains", "efforts", "speeds", "armatures", "lags", "positions", "drives"}
        | {"classes", "draws", "damping", "friction"}
    ),
}
"""What of a kind of file a program can write over."""


@dataclass(frozen=True, slots=True)
class Case:
    """What the rules get; they change nothing.

    Attributes:
        files: Every file that was named, read or not.
        artifacts: All robots of all files.
        rows: The ledger, by artifact; those of one in its joint order.
        robots: Artifacts put together; each artifact is in exactly one.
        versions: What the files are meant for.
        options: Rule code to its options (thresholds) from the configuration.
        passed_over: Files of the folders that were looked at and have nothing to audit.
        explicit: While specs are compiled: what to, in words, to the joints whose drive is integrated explicitly there.
        joints: Rows of each joint of each artifact, in their order; rows without a joint are left out.
        joints_by_artifact: The same, by artifact and then by joint.
        robot_by_artifact: Artifact to its robot.
        kinds_by_artifact: Artifact to the kinds of file that describe its robot, its own too.
    """

    files: tuple[FileReading, ...]
    artifacts: tuple[Artifact, ...]
    rows: tuple[LedgerRow, ...]
    robots: tuple[Robot, ...]
    versions: Versions = field(default_factory=Versions)
    options: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    passed_over: tuple[str, ...] = ()
    explicit: Mapping[str, Collection[str]] = field(default_factory=dict)
    joints: Mapping[tuple[int, str], Sequence[LedgerRow]] = field(init=False, repr=False, compare=False)
    joints_by_artifact: Mapping[int, Mapping[str, Sequence[LedgerRow]]] = field(
        init=False, repr=False, compare=False
    )
    robot_by_artifact: Mapping[int, Robot] = field(init=False, repr=False, compare=False)
    kinds_by_artifact: Mapping[int, frozenset[FileKind]] = field(init=False, repr=False, compare=False)
    _rows: Mapping[int, tuple[LedgerRow, ...]] = field(init=False, repr=False, compare=False)
    _made: dict[object, object] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        """Index rows and robots: every rule looks for both."""
        rows: dict[int, list[LedgerRow]] = {}
        joints: dict[tuple[int, str], list[LedgerRow]] = {}
        by_artifact: dict[int, dict[str, list[LedgerRow]]] = {}
        for row in self.rows:
            rows.setdefault(row.artifact, []).append(row)
            if row.joint:
                own = joints.setdefault((row.artifact, row.joint), [])
                own.append(row)
                by_artifact.setdefault(row.artifact, {})[row.joint] = own
        robots, kinds = {}, {}
        for robot in self.robots:
            beside = frozenset(self.artifacts[index].kind for index in robot.artifacts)
            for index in robot.artifacts:
                robots[index], kinds[index] = robot, beside
        object.__setattr__(self, "_rows", {index: tuple(own) for index, own in rows.items()})
        object.__setattr__(self, "joints", joints)
        object.__setattr__(self, "joints_by_artifact", by_artifact)
        object.__setattr__(self, "robot_by_artifact", robots)
        object.__setattr__(self, "kinds_by_artifact", kinds)

    def rows_of(self, artifact: int) -> tuple[LedgerRow, ...]:
        """The rows of one artifact."""
        return self._rows.get(artifact, ())

    def of_kind(self, *kinds: FileKind) -> Iterator[tuple[int, Artifact]]:
        """Artifacts of these kinds, with their indices."""
        for index, artifact in enumerate(self.artifacts):
            if artifact.kind in kinds:
                yield index, artifact

    def is_met(self, artifact: int) -> bool:
        """Whether an artifact's file was found in a folder that was named."""
        return self.is_met_at(Span(self.artifacts[artifact].path))

    def is_met_at(self, place: Span) -> bool:
        """Whether a place is in a file that was found in a folder that was named, or in a part of such files alone."""
        return self.once(_met).get(place.path, False)

    def is_run(self, place: Span) -> bool:
        """Whether a place is in a model that a program of its folder names, or in a part of one."""
        return place.path in self.once(_run)

    def is_idle(self, place: Span) -> bool:
        """Whether a place is in a file, or in a configuration of one, that nobody runs.

        It calls itself a copy or old; or nothing in its folder names it, where programs there name others.
        """
        parts = self.once(_idle_parts).get(place.path)
        if parts is None:
            return False
        before = [idle for line, idle in parts if line <= (place.line or 0)]
        return bool(before) and before[-1]

    def whose(self, place: Span) -> frozenset[int]:
        """Artifacts of which the ledger has a figure that is written at a place; none: nobody knows."""
        return self.once(_whose).get(place, frozenset())

    def has_angle_of_another(self, artifact: int) -> bool:
        """Whether an MJCF does not state its angle and another file of the case, read or not, includes it."""
        found = self.artifacts[artifact]
        file = self._file(found.path)
        included = file is not None and file.included and found.kind is FileKind.MJCF
        return included and not found.states(b"angle=")

    def runs_of(self, artifact: int) -> tuple[int, ...]:
        """What the run recorded that a deploy file is of, as artifacts; none where no record is beside it."""
        from actspec.readings.pair import runs_of

        return runs_of(self.artifacts, artifact, self.once(_records))

    def written(self, place: Span, joint: str) -> frozenset[str]:
        """What is written over of the model or configuration at a place that is about a joint.

        By programs of its folder, by events that draw it, and of a URDF by configurations of its robot that state the
        joint's limits.
        """
        found = self.once(_written).get(place.path, frozenset())
        if not self.is_met_at(place):
            return found
        found |= self.once(_limited_elsewhere).get((place.path, joint), frozenset())
        if place in self.once(set_otherwise):
            found |= {"draws"}
        return found | self.once(drawn_anew).get((place.path, joint), frozenset())

    def _file(self, path: str) -> FileReading | None:
        return self.once(_files).get(path)

    def versions_of(self, artifact: int) -> Versions:
        """What an artifact is meant for."""
        return meant_for(self.versions, self.artifacts[artifact])

    def robot_of(self, artifact: int) -> Robot:
        """The robot that an artifact belongs to."""
        return self.robot_by_artifact[artifact]

    def once(self, make: Callable[[Case], _T]) -> _T:
        """What a function makes of this case, made once for all rules that ask for it.

        Args:
            make: Pure; a function of a module, by which it is known again.
        """
        if make not in self._made:
            self._made[make] = make(self)
        return cast(_T, self._made[make])

    def once_of(self, make: Callable[[Artifact], _T], artifact: int) -> _T:
        """What a function makes of an artifact, made once, when a rule first asks for it.

        Args:
            make: Pure; a function or class of a module, by which it is known again.
            artifact: Its index.
        """
        if (make, artifact) not in self._made:
            self._made[make, artifact] = make(self.artifacts[artifact])
        return cast(_T, self._made[make, artifact])

    def option(self, code: str, name: str, default: float) -> float:
        """A rule's option, or its default."""
        return self.options.get(code, {}).get(name, default)


def runs(case: Case) -> frozenset[str]:
    """Paths of what trainings wrote of themselves."""
    return frozenset(file.path for file in case.files if file.record)


def _records(case: Case) -> tuple[int, ...]:
    """The artifacts of these."""
    return tuple(index for index, artifact in enumerate(case.artifacts) if artifact.path in case.once(runs))


def _whose(case: Case) -> dict[Span, frozenset[int]]:
    """Places of the ledger's figures, with the artifacts that take them from there."""
    found: dict[Span, set[int]] = {}
    for row in case.rows:
        for place in (row.span, *row.places.values()):
            found.setdefault(place, set()).add(row.artifact)
    return {place: frozenset(artifacts) for place, artifacts in found.items()}


def _files(case: Case) -> dict[str, FileReading]:
    """The files by their paths."""
    return {file.path: file for file in case.files}


def _written(case: Case) -> dict[str, frozenset[str]]:
    """Files and parts of models, with what programs write over of each; of a part, in every model that includes it."""
    found: dict[str, frozenset[str]] = {}
    for file in case.files:
        own = file.written & _WRITTEN.get(file.kind, frozenset())
        for path in {file.path, *(part.path for part in file.files)}:
            found[path] = found.get(path, own) & own
    return found


def _met(case: Case) -> dict[str, bool]:
    """Files and what they include, and whether nobody named them or what includes them; a spec is its writer's own."""
    found: dict[str, bool] = {}
    for file in case.files:
        for path in (file.path, *(part.path for part in file.files)):
            found[path] = found.get(path, True) and file.in_folder and file.kind is not FileKind.SPEC
    return found


def _run(case: Case) -> frozenset[str]:
    """Models that programs of their folders name, with what they include."""
    run = (file for file in case.files if file.in_folder and file.is_named)
    return frozenset(path for file in run for path in (file.path, *(part.path for part in file.files)))


def _limited_elsewhere(case: Case) -> dict[tuple[str, str], frozenset[str]]:
    """URDFs, each with a joint, and which of its limits every configuration that is run and drives it writes over.

    Source: Isaac Lab 2.3, Articulation writes effort_limit_sim of an implicit drive, and 1e9 for an explicit one, which
    clips at its effort_limit; and an implicit one's velocity_limit_sim. legged_gym clips at the URDF's, and mjlab loads
    none.
    """
    found: dict[tuple[str, str], frozenset[str]] = {}
    for index, urdf in case.of_kind(FileKind.URDF):
        configs = [
            other
            for other in case.robot_of(index).artifacts
            if (config := case.artifacts[other].config) is not None
            and config.framework in (Framework.ISAACLAB, Framework.LEGGED_GYM)
            and not case.is_idle(config.span)
        ]
        for joint in case.joints_by_artifact.get(index, {}):
            drives = [row for other in configs for row in case.joints.get((other, joint), ())]
            found[urdf.path, joint] = frozenset(
                name
                for field, name in (
                    ("effort_limit", "urdf_effort"),
                    # By the drive itself, which a program that clips is not.
                    ("effort_limit", "urdf_drive"),
                    ("velocity_limit", "urdf_velocity"),
                )
                if drives
                and all(
                    field in row.stated and (row.control == "implicit" or field == "effort_limit")
                    for row in drives
                )
            )
    return found


def _idle_parts(case: Case) -> dict[str, list[tuple[int, bool]]]:
    """Files with something that nobody runs: where their parts begin, in order, and whether each is idle."""
    found: dict[str, list[tuple[int, bool]]] = {}
    aside = {file.path for file in case.files if file.put_aside or file.unnamed}
    run = {
        os.path.realpath(part.path)
        for file in case.files
        if aside and file.path not in aside
        for part in file.files
    }
    for file in case.files:
        if file.path in aside:
            # Nobody runs what it includes either, but for parts of a model that somebody runs.
            parts = (part.path for part in file.files if os.path.realpath(part.path) not in run)
            found.update((path, [(0, True)]) for path in (file.path, *parts))
        elif file.idle:
            configs = (artifact.config for artifact in file.artifacts)
            found[file.path] = sorted(
                (config.span.line or 0, config.name in file.idle) for config in configs if config is not None
            )
    return found
