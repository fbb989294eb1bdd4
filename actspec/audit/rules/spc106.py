from __future__ import annotations

import re
from collections.abc import Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.diagnostics import Span
from actspec.readings.artifact import FileKind
from actspec.readings.compare import times
from actspec.readings.dynamics import setting_place, settings_of
from actspec.units import format_quantity

_NAMES = {"control_dt": "control period", "physics_dt": "physics step"}
"""What is compared, with its words; the one that says more first."""

_TIMESTEP = re.compile(rb"<option\b[^>]*?\b(timestep)\s*=")


_Subject = tuple[dict[str, tuple[float, Span]], int, dict[str, tuple[float, Span]], list[str]]


class SpecTiming(RuleOver[_Subject]):
    code = "SPC106"
    name = "timing-departs-from-spec"
    severity = Severity.ERROR
    confidence = Confidence.HIGH
    paired = True
    needs = "no spec with timing beside a file of its robot that has one"
    options: ClassVar[dict[str, float]] = {"tolerance": 0.01}

    def subjects(self, case: Case) -> Iterator[_Subject]:
        for robot in case.robots:
            spec = next((i for i in robot.artifacts if case.artifacts[i].spec is not None), None)
            wanted = {} if spec is None else stated_periods(case, spec)
            for index in robot.artifacts if spec is not None else ():
                found = stated_periods(case, index)
                shared = [name for name in _NAMES if name in found and name in wanted]
                # Another spec of the robot, with other gains say, has a step of its own.
                if case.artifacts[index].kind is FileKind.SPEC or not shared:
                    continue
                yield wanted, index, found, shared

    def judge(self, case: Case, subject: _Subject) -> Iterator[Finding]:
        """Compare the periods of every file with those of its robot's spec."""
        wanted, index, found, shared = subject
        tolerance = self.option(case, "tolerance")
        departing = (name for name in shared if abs(found[name][0] / wanted[name][0] - 1.0) > tolerance)
        name = next(departing, None)
        if name is not None:
            yield self._finding(case, index, name, found[name], wanted[name])

    def _finding(
        self, case: Case, index: int, name: str, mine: tuple[float, Span], wanted: tuple[float, Span]
    ) -> Finding:
        kind = case.artifacts[index].kind
        help = "set it to the spec's, or correct the spec"
        if kind is FileKind.MJCF:
            help = "the mujoco target writes the spec's; check that what loads this file sets it"
        return Finding(
            self.code,
            f"the {_NAMES[name]} is {_shown(mine[0])}, and the spec says {_shown(wanted[0])}"
            f"{times(mine[0], wanted[0])}",
            mine[1],
            value=mine[0],
            unit="s",
            expected=wanted[0],
            help=help,
            related=(wanted[1],),
            severity=Severity.INFO if kind is FileKind.MJCF else None,
            confidence=Confidence.LOW if kind is FileKind.MJCF else None,
        )


def _shown(period: float) -> str:
    return format_quantity(period * 1e3, "ms", 3)


def stated_periods(case: Case, index: int) -> dict[str, tuple[float, Span]]:
    """What an artifact states of `control_dt` and `physics_dt` [s], with its place."""
    artifact = case.artifacts[index]
    settings = settings_of(artifact)
    found: dict[str, tuple[float, Span]] = {}
    for name in _NAMES:
        value = settings.get(name)
        place = _place(case, index, name)
        if isinstance(value, float) and value > 0.0 and place is not None:
            found[name] = (value, place)
    return found


def _place(case: Case, index: int, name: str) -> Span | None:
    """Where a period is written, or what it is computed from; None where an MJCF leaves it to the engine."""
    artifact = case.artifacts[index]
    if artifact.robot is not None:
        return _written_step(case, artifact.path)
    return setting_place(artifact, name)


def _written_step(case: Case, path: str) -> Span | None:
    """The last timestep among a model's files, which is the one that counts."""
    files = next((reading.files for reading in case.files if reading.path == path), ())
    for file in reversed(files):
        for found in reversed(list(_TIMESTEP.finditer(file.data))):
            before = file.data[: found.start(1)]
            return Span(file.path, before.count(b"\n") + 1, len(before) - before.rfind(b"\n"))
    return None
