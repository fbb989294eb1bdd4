from __future__ import annotations

from collections.abc import Iterable, Iterator

from actspec.audit.known import Likeness, likenesses
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import shown
from actspec.diagnostics import listed


class RevisionOfTheRobot(RuleOver[Likeness]):
    code = "KNW102"
    name = "revision-of-a-known-robot"
    severity = Severity.INFO
    confidence = Confidence.MEDIUM
    needs = "no robot among the files that has several published revisions"

    def subjects(self, case: Case) -> Iterable[Likeness]:
        """Artifacts that are known robots of several revisions."""
        return [found for found in case.once(likenesses) if len(found.robot.variants) > 1]

    def judge(self, case: Case, subject: Likeness) -> Iterator[Finding]:
        """Say which revision it is, and by what."""
        if not subject.told:
            return
        variants = subject.robot.variants
        here = variants[subject.variants[0]]
        told = [
            (row, names[0])
            for row, names in subject.joints
            if row.effort_limit is not None
            and len({joints[names[0]].effort for joints in variants.values()}) > 1
        ]
        seen: dict[str, str] = {}
        for row, name in told:
            part = name.removeprefix("left_").removeprefix("right_").removesuffix("_joint")
            seen.setdefault(part, shown(row, "effort_limit", here[name].effort, 6))
        yield Finding(
            self.code,
            f"the limits are those of {subject.robot.name} {_either(subject.variants)}: "
            + ", ".join(f"{part} {figure}" for part, figure in seen.items()),
            told[0][0].place("effort_limit"),
            about=" ".join(seen.values()),
        )


def _either(variants: Iterable[str]) -> str:
    """Names of which one holds: `mode_5 or mode_13`."""
    *others, last = sorted(variants, key=lambda name: (len(name), name))
    return f"{listed(others)} or {last}" if others else last
