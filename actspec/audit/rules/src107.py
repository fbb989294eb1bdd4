from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.readings.artifact import FileKind
from actspec.readings.compare import times
from actspec.readings.dynamics import setting_place, settings_of
from actspec.units import format_quantity


class Timing(RuleInParts):
    code = "SRC107"
    name = "timing-disagrees"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    noted_in_folders = True
    paired = True
    needs = "no deploy file and configuration of one robot state a control period"
    options: ClassVar[dict[str, float]] = {"tolerance": 0.01}

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        """Compare the periods of each robot's deploy files."""
        tolerance = self.option(case, "tolerance")
        for robot in case.robots:
            trained = [i for i in robot.artifacts if case.artifacts[i].kind is FileKind.CFG]
            for index in robot.artifacts:
                if case.artifacts[index].kind is not FileKind.DEPLOY:
                    continue
                own = [i for i in case.runs_of(index) if i in trained]
                for name in ("control_dt", "physics_dt"):
                    mine = self._period(case, index, name)
                    theirs = [
                        (i, found)
                        for i in own or trained
                        if (found := self._period(case, i, name)) is not None
                    ]
                    if mine is None or not theirs:
                        continue
                    yield ()
                    alike = {
                        case.artifacts[i].path for i, other in theirs if abs(mine / other - 1.0) <= tolerance
                    }
                    if alike:
                        # One that agrees, maybe the last that was not changed, does not speak for another that was
                        # named. A physics step is a framework's own, at one control period.
                        theirs = [
                            (i, other)
                            for i, other in theirs
                            if name == "control_dt"
                            and case.artifacts[i].path not in alike
                            and not case.is_met(index)
                            and not case.is_met(i)
                        ]
                    if theirs:
                        yield (self._departing(case, index, name, mine, *theirs[0]),)
                        break

    def _period(self, case: Case, index: int, name: str) -> float | None:
        # A `dt` says of what it is to whoever named the file.
        value = settings_of(case.artifacts[index], bare_dt=not case.is_met(index)).get(name)
        return value if isinstance(value, float) and value > 0.0 else None

    def _departing(
        self, case: Case, index: int, name: str, mine: float, other: int, theirs: float
    ) -> Finding:
        file = case.artifacts[other].path
        if name == "control_dt":
            what = (
                f"the policy runs every {format_quantity(mine * 1e3, 'ms', 3)} here and every "
                f"{format_quantity(theirs * 1e3, 'ms', 3)} in {file}"
                f"{times(mine, theirs)}: one step is not the time that it was trained with"
            )
        else:
            what = (
                f"the physics step is {format_quantity(mine * 1e3, 'ms', 3)} here and "
                f"{format_quantity(theirs * 1e3, 'ms', 3)} in {file}"
                f"{times(mine, theirs)}, at the same control period: explicit drives and contacts act otherwise"
            )
        rare = name == "physics_dt"
        return Finding(
            self.code,
            what,
            setting_place(case.artifacts[index], name),
            value=mine,
            unit="s",
            expected=theirs,
            help="run the policy at the rate that it was trained with",
            related=(setting_place(case.artifacts[other], name),),
            severity=Severity.INFO if rare else None,
            confidence=Confidence.LOW if rare else None,
        )
