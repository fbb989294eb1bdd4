from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from actspec.audit.case import MODELS, Case
from actspec.audit.finding import Confidence, Finding
from actspec.audit.rules.joints import effort_noun
from actspec.audit.rules.source_blame import Disagreement, is_met
from actspec.audit.rules.source_rule import SourceRule, are_exchanged, is_of_one_training, shown
from actspec.diagnostics import Severity
from actspec.joints import JointKind, plain_words
from actspec.readings.artifact import FileKind
from actspec.readings.called import stem_of
from actspec.readings.dynamics import figure
from actspec.units import format_number

_CREEPS = 2.0
"""kd over kp, the time in which a joint that is damped so follows its command [s], from which on the two are exchanged.
Chosen: the other way round it is half a second, and 0.2 s is the most in Isaac Lab's robots (Franka: 400 and 80)."""

_OF_DRIVES = frozenset(("position", "pos", "velocity", "vel", "speed", "torque", "effort", "motor"))
"""Words for what a drive follows, in names of files."""


class Gain(SourceRule):
    code = "SRC103"
    name = "gain-disagrees"
    groups = (("kp",), ("kd",))
    # As the others of two files: which of a stranger's deploy files runs the policy is not seen.
    noted_in_folders = True
    needs = "a gain of one joint"

    def findings(self, case: Case, disagreements: Sequence[Disagreement]) -> list[Finding]:
        """One for both gains of a joint that one file has in each other's place."""
        found = []
        gains = {_pair(one): one for one in disagreements}
        for one in disagreements:
            other = gains.get((*_pair(one)[:2], "kd" if one.field == "kp" else "kp"))
            if other is None or not are_exchanged(one):
                found.append(self.finding(case, one))
            elif one.field == "kp":
                if one.rows[0].artifact == other.rows[0].artifact:
                    pair = one, other
                elif one.ratio is None:
                    # A kp of 0 is a wheel's: the file whose kd departs has the odd gains.
                    pair = one.turned, other
                else:
                    pair = one, other.turned
                found.append(self._exchanged(case, *pair))
        return found

    def _exchanged(self, case: Case, kp: Disagreement, kd: Disagreement) -> Finding:
        """The finding at the file with the odd gains, where they tell which it is."""
        times = [
            gain.value / by.value if gain.value and by.value else 0.0
            for gain, by in ((kd.mine, kp.mine), (kd.theirs, kp.theirs))
        ]
        if times[1] >= _CREEPS:
            kp, kd, times = kp.turned, kd.turned, times[::-1]
        here, there = (
            f"{shown(stiffness.value, stiffness.unit)} and {shown(damping.value, damping.unit)}"
            for stiffness, damping in ((kp.mine, kd.mine), (kp.theirs, kd.theirs))
        )
        found = self.finding(case, kp)
        odd = times[0] >= _CREEPS
        then = f": with these a joint takes {times[0]:.3g} s to follow its command" if odd else ""
        return replace(
            found,
            message=f"kp and kd are exchanged: {here} here, {there} in {kp.others[0].file}{then}",
            help=f"write {there}" if odd else found.help,
            related=(kd.mine.place, kp.theirs.place, kd.theirs.place),
            fields=("kp", "kd"),
            about="exchanged",
        )

    def consequence(self, case: Case, found: Disagreement) -> str:
        """What the joint does then."""
        ratio = found.ratio
        if _is_wheel_held(case, found):
            return "one of them holds the joint at an angle, the other turns it at a speed"
        if ratio is None or ratio < 0.0:
            return "one of them has no such gain"
        if found.field == "kp":
            times, noun = format_number(ratio, 3), effort_noun(found.rows[0])
            return (
                f"the same command error gives {times} times the {noun}, and the joint swings "
                f"{math.sqrt(ratio):.3g} times as fast"
            )
        return f"the drive brakes {format_number(ratio, 3)} times as hard at the same speed"

    def grave(self, case: Case, found: Disagreement) -> Severity | None:
        """Whether a wheel is turned to an angle or at a speed is no matter of tuning, whatever the files are."""
        grave = _is_wheel_held(case, found) and not is_met(case, found) and not _are_named_so(case, found)
        return self.severity if grave else None

    def severity_of(self, case: Case, found: Disagreement) -> tuple[Severity, Confidence]:
        """What the policy trained with and what runs it should be one; an MJCF is often only where it is tried."""
        kinds = {case.artifacts[rows[0].artifact].kind for rows in (found.rows, found.others)}
        if kinds == {FileKind.CFG, FileKind.DEPLOY} and is_of_one_training(case, found):
            return Severity.WARNING, Confidence.HIGH
        return Severity.INFO, Confidence.MEDIUM


def _is_wheel_held(case: Case, found: Disagreement) -> bool:
    """Whether of two drives of a joint that turns without end one follows a position, the other a speed alone."""
    if found.field != "kp":
        return False
    free, held = sorted((found, found.turned), key=lambda one: one.mine.value or 0.0)
    if free.mine.value != 0.0 or not held.mine.value or not figure(free.rows, "kd").value:
        return False
    joint = found.rows[0].joint
    members = case.robot_of(found.rows[0].artifact).artifacts
    models = [index for index in members if case.artifacts[index].kind in MODELS]
    return any(
        row.kind is JointKind.HINGE and row.position_range is None
        for index in models
        for row in case.joints.get((index, joint), ())
    )


def _are_named_so(case: Case, found: Disagreement) -> bool:
    """Whether the names of both files tell their drives, each another: `arm_position.xml` and `arm_velocity.xml`."""
    paths = (case.artifacts[rows[0].artifact].path for rows in (found.rows, found.others))
    here, there = (_OF_DRIVES.intersection(plain_words(stem_of(path))) for path in paths)
    return bool(here) and bool(there) and here != there


def _pair(found: Disagreement) -> tuple[frozenset[int], str, str]:
    """Which two files differ in a gain, at which joint, and the gain."""
    return frozenset({found.rows[0].artifact, found.others[0].artifact}), found.rows[0].joint, found.field
