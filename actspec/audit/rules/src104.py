from __future__ import annotations

from collections import Counter
from typing import ClassVar

from actspec.audit.case import Case
from actspec.audit.finding import Confidence
from actspec.audit.rules.joints import effort_noun, limiting_row, undriven_joints
from actspec.audit.rules.reductions import same
from actspec.audit.rules.source_blame import Disagreement
from actspec.audit.rules.source_rule import SourceRule, shown
from actspec.diagnostics import Severity
from actspec.readings.artifact import Framework
from actspec.readings.ledger import LedgerRow

_FAR = 10.0
"""From here a figure that stands for unlike motors is no estimate of one. Chosen: rotors behind the gears of one robot
are up to ten times apart."""

_GUESS = 0.1
"""What Unitree's MJCFs give every joint of an H1, from 18 to 300 N*m, of a B2 and of an H1-2 [kg*m^2]: guessed, as
robots/limits/legged.yaml has it, and no evidence against another figure."""

_NEARLY_ALL = 0.8
"""Share of a file's joints with one armature from which it stands for unlike motors. Chosen: as for pairing files."""

_SEVERAL = 4
"""Joints from which one armature for all tells that nobody multiplied it out. Chosen: as for one limit, in SRC101."""


class Armature(SourceRule):
    code = "SRC104"
    name = "armature-disagrees"
    noted_in_folders = True
    options: ClassVar[dict[str, float]] = {"tolerance": 0.05}
    groups = (("armature",),)
    needs = "an armature of one joint"

    def is_none(self, case: Case, found: Disagreement, tolerance: float) -> bool:
        """Whether one is of a joint without a drive, which another joint's turns.

        No format has an armature in degrees or rpm, and ten times is near the 9.55 of rpm.
        """
        firsts = (rows[0] for rows in (found.rows, found.others))
        return any(row.joint in case.once(undriven_joints).get(row.artifact, ()) for row in firsts)

    def severity_of(self, case: Case, found: Disagreement) -> tuple[Severity, Confidence]:
        """A note where a figure is nobody's: a framework's 0, or one for unlike motors that another replaces."""
        if any(_is_default(case, rows[0]) for rows in (found.rows, found.others)):
            return Severity.INFO, self.confidence
        mine = found.rows[0].artifact in case.once(_of_one_armature)
        other = found.others[0]
        theirs = other.artifact in case.once(_of_one_armature) or (
            other.armature is not None and case.once(_for_unlike_motors).get(other.artifact) == other.armature
        )
        near = found.ratio is not None and 1.0 / _FAR < found.ratio < _FAR
        guessed = theirs and (found.theirs.value == _GUESS or (near and not mine))
        return (Severity.INFO if guessed else self.severity), self.confidence

    def consequence(self, case: Case, found: Disagreement) -> str:
        """How much inertia."""
        assert found.mine.value is not None and found.theirs.value is not None
        change = shown(abs(found.mine.value - found.theirs.value), found.mine.unit)
        more = "more" if found.mine.value > found.theirs.value else "less"
        noun = effort_noun(found.rows[0])
        return f"every {noun} has {change} {more} to {'turn' if noun == 'torque' else 'move'}"


def _is_default(case: Case, row: LedgerRow) -> bool:
    """Whether it is the framework's 0: from a class in another file, or repeated, as legged_gym's copies do."""
    config = case.artifacts[row.artifact].config
    repeated = config is not None and config.framework is Framework.LEGGED_GYM
    return row.armature == 0.0 and (repeated or row.place("armature").path != row.file)


def _of_one_armature(case: Case) -> frozenset[int]:
    """Files with one armature for several joints, all that state any."""
    return frozenset(
        index
        for index, counts in case.once(_armatures).items()
        if len(counts) == 1 and counts.total() >= _SEVERAL
    )


def _for_unlike_motors(case: Case) -> dict[int, float]:
    """The armature that nearly all joints of a file have, by artifact, where their limits are those of unlike motors.

    What one joint has instead says nothing of where the others have theirs from.
    """
    found = {}
    for index, counts in case.once(_armatures).items():
        ((armature, count),) = counts.most_common(1)
        if count < max(_SEVERAL, _NEARLY_ALL * counts.total()):
            continue
        held = (limiting_row(case, row) for row in case.rows_of(index) if row.armature == armature)
        limits = [row.effort_limit for row in held if row is not None]
        if limits and not all(same(limits[0], limit) for limit in limits):
            found[index] = armature
    return found


def _armatures(case: Case) -> dict[int, Counter[float]]:
    """How many joints of each artifact state each armature."""
    found: dict[int, Counter[float]] = {}
    for row in case.rows:
        if row.joint and "armature" in row.stated and row.armature:
            found.setdefault(row.artifact, Counter())[row.armature] += 1
    return found
