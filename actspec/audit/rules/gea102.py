from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import ClassVar

from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.joints import by_joint, partner_rows, shown, unit
from actspec.audit.rules.reductions import figures, limbs_of, reductions, same, states_speed
from actspec.readings.artifact import FileKind
from actspec.units import format_number, format_quantity


class NotGearSquared(RuleInParts):
    code = "GEA102"
    name = "armature-is-not-gear-squared"
    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    noted_in_folders = True
    paired = True
    needs = "no armature beside a rotor's inertia, or limits that show a reduction"
    options: ClassVar[dict[str, float]] = {"ratio": 1.5}

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        yield from self._against_spec(case)
        yield from self._against_limits(case)

    def _off(self, case: Case, armature: float, expected: float) -> bool:
        ratio = self.option(case, "ratio")
        return armature >= ratio * expected or armature * ratio <= expected

    def _against_spec(self, case: Case) -> Iterator[Iterable[Finding]]:
        for index, artifact in case.of_kind(FileKind.SPEC):
            assert artifact.spec is not None
            actuators = {actuator.joint: actuator for actuator in artifact.spec.joints}
            for spec in case.rows_of(index):
                reflected = actuators[spec.joint].reflected_inertia
                if reflected.value is None or reflected.value <= 0.0:
                    continue
                for row in (spec, *partner_rows(case, spec)):
                    armature = row.armature
                    if armature is None or armature <= 0.0 or "armature" not in row.stated:
                        continue
                    if not self._off(case, armature, reflected.value):
                        yield ()
                        continue
                    finding = Finding(
                        self.code,
                        f"an armature of {shown(row, 'armature', armature)} is "
                        f"{format_number(armature / reflected.value, 3)} times "
                        f"the {shown(row, 'armature', reflected.value)} that the spec's rotor inertia has behind its "
                        "gear",
                        row.place("armature"),
                        row.joint,
                        armature,
                        unit(row, "armature"),
                        reflected.value,
                        "rotor inertia times the square of the whole reduction",
                        (reflected.span or spec.span,) if row is not spec else (),
                        confidence=Confidence.HIGH,
                    )
                    yield (finding,)

    def _against_limits(self, case: Case) -> Iterator[Iterable[Finding]]:
        known = case.once(figures)
        rows = {key: found[0] for key, found in by_joint(case).items()}
        for robot in case.robots:
            if not states_speed(known, robot):
                continue
            above = limbs_of(case, robot)
            for reference in robot.artifacts:
                found = list(reductions(known.get(reference, {}), above))
                for other in robot.artifacts:
                    there = known.get(other, {})
                    seen = set()
                    for one in found:
                        name, base = one.joint.row.joint, one.base.row.joint
                        row, less = rows.get((other, name)), rows.get((other, base))
                        if (
                            name in seen
                            or row is None
                            or less is None
                            or not row.armature
                            or not less.armature
                        ):
                            continue
                        pairs = ((there.get(name), one.joint), (there.get(base), one.base))
                        # A file with other limits is GEA101's.
                        if not all(mine is None or same(mine.effort, its.effort) for mine, its in pairs):
                            yield ()
                            continue
                        seen.add(name)
                        expected = less.armature * one.ratio**2
                        if not self._off(case, row.armature, expected):
                            yield ()
                            continue
                        finding = Finding(
                            self.code,
                            f"an armature of {shown(row, 'armature', row.armature)} does not fit the gear: a joint "
                            f"of the same power (effort times speed) and {one.ratio:.4g} times less reduction has "
                            f"{shown(row, 'armature', less.armature)}, which is {format_quantity(expected, '', 3)} "
                            f"here (times {one.ratio**2:.3g})",
                            row.place("armature"),
                            name,
                            row.armature,
                            unit(row, "armature"),
                            expected,
                            "rotor inertia times the square of the whole reduction, for each joint",
                            (one.joint.place, one.base.place),
                            fields=("armature",),
                            # One figure for all was never multiplied out, which GEA103 tells.
                            severity=Severity.INFO if same(row.armature, less.armature) else None,
                        )
                        yield (finding,)
