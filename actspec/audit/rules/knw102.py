from __future__ import annotations

from collections.abc import Iterable, Iterator

from actspec.audit.known import Likeness, all_likenesses, same
from actspec.audit.rule import Case, Confidence, Finding, RuleOver, Severity
from actspec.audit.rules.joints import shown
from actspec.diagnostics import listed
from actspec.readings.ledger import LedgerRow

_PUBLISHED = {"effort_limit": "effort", "armature": "armature"}
"""Figures of a row that tell revisions apart, to those of a known joint."""


class RevisionOfTheRobot(RuleOver[Likeness]):
    code = "KNW102"
    name = "revision-of-a-known-robot"
    severity = Severity.INFO
    confidence = Confidence.MEDIUM
    needs = "no robot among the files that has several published revisions"

    def subjects(self, case: Case) -> Iterable[Likeness]:
        """Artifacts that are known robots of several revisions; beside a spec those of another than the spec's."""
        return [
            found
            for found in case.once(all_likenesses)
            if len(found.robot.variants) > 1 and not _is_of_spec(case, found)
        ]

    def judge(self, case: Case, subject: Likeness) -> Iterator[Finding]:
        """Say which revision it is, and by what."""
        if not subject.told:
            yield from self._of_none(subject)
            return
        variants = subject.robot.variants
        here = variants[subject.variants[0]]

        def tells(field: str) -> list[tuple[LedgerRow, str]]:
            name = _PUBLISHED[field]
            return [
                (row, names[0])
                for row, names in subject.read(field)
                if getattr(row, field)
                and len({getattr(joints[names[0]], name) for joints in variants.values()}) > 1
            ]

        # Limits first: armatures tell where there are none.
        field = next((field for field in _PUBLISHED if tells(field)), None)
        if field is None:
            return
        told = tells(field)
        noun = "limits" if field == "effort_limit" else "armatures"
        seen: dict[str, str] = {}
        for row, name in told:
            figure = getattr(here[name], _PUBLISHED[field])
            seen.setdefault(_part(name), shown(row, field, figure, 6 if field == "effort_limit" else 3))
        yield Finding(
            self.code,
            f"the {noun} are those of {subject.robot.name} {_either(subject.variants)}: "
            + ", ".join(f"{part} {figure}" for part, figure in seen.items()),
            told[0][0].place(field),
            about=" ".join(seen.values()),
        )

    def _of_none(self, subject: Likeness) -> Iterator[Finding]:
        """Limits each of which a revision has at its joint, and none has all: exchanged, or of two revisions."""
        variants = subject.robot.variants.values()
        told = [
            (row, name)
            for row, names in subject.read("effort_limit")
            for name in names
            if row.effort_limit and len({joints[name].effort for joints in variants}) > 1
        ]
        fits = [[same(row.effort_limit, joints[name].effort) for row, name in told] for joints in variants]
        if any(map(all, fits)) or not all(map(any, zip(*fits, strict=True))):
            return
        seen = {f"{_part(name)} {shown(row, 'effort_limit', row.effort_limit, 6)}": row for row, name in told}
        yield Finding(
            self.code,
            f"no published revision of {subject.robot.name} has these limits together: {', '.join(seen)}",
            told[0][0].place("effort_limit"),
            about=" ".join(seen),
        )


def _is_of_spec(case: Case, found: Likeness) -> bool:
    """Whether a spec of the robot is read as a variant that the file may be."""
    specs = (case.artifacts[index].spec for index in case.robot_of(found.index).artifacts)
    return any(spec is not None and (not found.told or spec.variant in found.variants) for spec in specs)


def _part(name: str) -> str:
    return name.removeprefix("left_").removeprefix("right_").removesuffix("_joint")


def _either(variants: Iterable[str]) -> str:
    """Names of which one holds: `mode_5 or mode_13`."""
    *others, last = sorted(variants, key=lambda name: (len(name), name))
    return f"{listed(others)} or {last}" if others else last
