"""What the SRC rules say of figures in which files of a robot differ, and how grave it is."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import ClassVar

from actspec.audit.case import Case, runs
from actspec.audit.finding import Confidence, Finding
from actspec.audit.known import same
from actspec.audit.rule import RuleInParts
from actspec.audit.rules.joints import is_called_undriven, is_exporters, top_speed
from actspec.audit.rules.source_blame import GRAVE, SAME, Disagreement, is_met
from actspec.audit.rules.source_pairs import compared, disagreements
from actspec.diagnostics import SEVERITIES, Severity
from actspec.fields import FIELDS, LIMITS, is_placeholder
from actspec.readings.artifact import FileKind, Framework
from actspec.readings.called import distinctive
from actspec.readings.compare import Figure, angle_slip
from actspec.readings.dynamics import figure
from actspec.readings.joint import read_joint
from actspec.readings.ledger import LedgerRow
from actspec.units import format_quantity

TIMES = 3.0
"""From here a ratio is given as a factor. Chosen: 200 % more is read as a factor of 2 as often as of 3."""

SMALL = 0.07
"""Up to here a limit that differs is a note. Chosen: published limits of one motor are so far apart (23.5 and 23.7 N*m,
200.43 and 200), and of a B2's calf (300 and 320), where two readers would not have acted."""

_REVISION = re.compile(
    r"(?:(?<![A-Za-z])(?i:v|rev|version|mode|mark|mk)|(?<=[a-z])V)[_-]?\d+(?:[._]\d+)*|(?i:limit|stronger|weaker)"
)
"""A hardware's version in a name, as of `atlas_v4`, `naoV33`, `mini_mark2` and `g1_29dof_mode_13`, or limits that are
others on purpose, as of `t1_softlimit` and `robot_stronger_ankle`."""

_COUNTED = re.compile(r"(?:v|ver|rev|version)[_-]?\d")
"""A version that others follow. Modes, marks and limits that are others on purpose have other motors."""

_DIGIT = 10.0
"""From this ratio on a limit has a digit more or less. Chosen: versions stay below (4, knees of Atlas 3 and 4)."""

_ROUNDED = 1e-3
"""Chosen: up to here two masses of a robot are one. Its links are written with four digits or more."""

_FOLDERS = 4
"""Last parts of a path that may tell which revision a file is of. Chosen: of the robot, of the kind of file."""


def is_no_limit(found: Disagreement) -> bool:
    """Whether one of two limits is a placeholder, an exporter's or 0, which the LIM rules report."""
    # Where both files have the effort, somebody stated it.
    efforts = {rows[0].effort_limit for rows in (found.rows, found.others)}
    if len(efforts) > 1 and any(is_exporters(rows[0]) for rows in (found.rows, found.others)):
        return True
    values = [found.mine.value or 0.0, found.theirs.value or 0.0]
    return min(values) <= 0.0 or is_placeholder(max(values))


def is_of_run(case: Case, found: Disagreement) -> bool:
    """Whether a run's own record and a configuration differ, and somebody named both."""
    files = [case.artifacts[rows[0].artifact] for rows in (found.rows, found.others)]
    records = sum(file.path in case.once(runs) for file in files)
    return records == 1 and all(file.kind is FileKind.CFG for file in files) and not is_met(case, found)


def at_what_is_edited(case: Case, found: Disagreement) -> Disagreement:
    """Turned where a run's record departs from a configuration: it says what was, and nobody edits it."""
    turns = not found.published and is_of_run(case, found) and found.rows[0].file in case.once(runs)
    return found.turned if turns else found


_TRAINED = (*LIMITS, "kp", "kd", "armature", "action_scale", "default_position")
"""Figures of which a digit more is no training's choice; friction is."""


def is_slip_of_run(case: Case, found: Disagreement) -> bool:
    """Whether a run and the configuration that it was trained from differ as no two trainings would on purpose.

    Who trains again changes gains, but not by a digit, not their sign, nor the side to which an elbow is bent. Most
    figures of the two agree: else the configuration is another training's. Of several runs that were named another one
    may have been trained with what the configuration has now.
    """
    ratio = found.ratio
    if found.field not in _TRAINED or ratio is None or not is_of_run(case, found):
        return False
    if found.field == "default_position":
        is_odd = math.isclose(ratio, -1.0, rel_tol=SAME)
    else:
        is_odd = ratio < 0.0 or max(ratio, 1.0 / ratio) >= _DIGIT - 1e-9 or are_exchanged(found)
    if not is_odd:
        return False
    side = found if found.rows[0].file in case.once(runs) else found.turned
    run, config = side.rows[0], side.others[0]
    for index in case.robot_of(run.artifact).artifacts:
        path, rows = case.artifacts[index].path, case.joints.get((index, run.joint), ())
        is_other = path in case.once(runs) and path != run.file and bool(rows)
        if is_other and same(figure(rows, found.field).value, side.theirs.value or 0.0):
            return False
    return _is_of_its_run(case, run.artifact, config.artifact)


_OF_A_RUN = ("kp", "kd", "effort_limit", "velocity_limit", "armature")
"""Figures by which a configuration shows that a run is its own."""


def _is_of_its_run(case: Case, run: int, config: int) -> bool:
    """Whether a configuration has most figures of a run, or all of its gains with a digit more or less."""
    one, other = (case.joints_by_artifact.get(index, {}) for index in (run, config))
    figures = {name: _both(one, other, name) for name in _OF_A_RUN}
    pairs = [pair for each in figures.values() for pair in each]
    gains = [figures["kp"], figures["kd"]]
    if all(gains) and _are_a_digit_off(gains):
        return True
    return 2 * sum(math.isclose(*pair, rel_tol=SAME) for pair in pairs) > len(pairs)


def is_of_one_training(case: Case, found: Disagreement) -> bool:
    """Whether a deploy file runs what a configuration trains, as it does what its own run recorded.

    Policies of a robot with several sets of gains have a training each, and which of them belongs to the configuration
    at hand, no file tells. Nor is it the file's own where no gain of any joint agrees: a project beside another one
    (of rl_sar's deploy files beside robot_lab's configurations 14 are so). But no training has the gains of another one
    exchanged, or all of them with a digit more.
    """
    sides = found.rows[0].artifact, found.others[0].artifact
    if sides[1] in case.runs_of(sides[0]) or sides[0] in case.runs_of(sides[1]):
        return True
    one, other = (case.joints_by_artifact.get(index, {}) for index in sides)
    pairs = [_both(one, other, name) for name in ("kp", "kd")]
    if are_exchanged(found) or (all(pairs) and _are_a_digit_off(pairs)):
        return True
    if all(pairs) and not any(math.isclose(*pair, rel_tol=SAME) for gains in pairs for pair in gains):
        return False
    members = case.robot_of(found.rows[0].artifact).artifacts
    gains = set()
    for index in members:
        if case.artifacts[index].kind is FileKind.DEPLOY:
            joints = case.joints_by_artifact.get(index, {})
            own = frozenset((joint, rows[0].kp, rows[0].kd) for joint, rows in joints.items() if rows[0].kp)
            gains |= {own} if own else set()
    return len(gains) < 2


def are_exchanged(found: Disagreement) -> bool:
    """Whether each gain of a joint is the other one of the other file; one of them may be 0, as a wheel's kp is."""
    kp, kd, its_kp, its_kd = (
        figure(rows, name).value for rows in (found.rows, found.others) for name in ("kp", "kd")
    )
    crossed = (kp, its_kd), (kd, its_kp)
    return bool(kp or kd) and all(
        a is not None and b is not None and a >= 0.0 and math.isclose(a, b, rel_tol=SAME) for a, b in crossed
    )


def _are_a_digit_off(pairs: Sequence[Sequence[tuple[float, float]]]) -> bool:
    """Whether all gains of two files differ by one power of ten."""
    ratios = [mine / its if its else 0.0 for gains in pairs for mine, its in gains]
    power = round(math.log10(ratios[0])) if ratios[0] > 0.0 else 0
    return power != 0 and all(math.isclose(ratio, 10.0**power, rel_tol=SAME) for ratio in ratios)


def is_small(found: Disagreement) -> bool:
    """Whether two figures are so near that both are one motor's."""
    return found.ratio is not None and abs(found.ratio - 1.0) <= SMALL


def _both(
    one: Mapping[str, Sequence[LedgerRow]], other: Mapping[str, Sequence[LedgerRow]], name: str
) -> list[tuple[float, float]]:
    """What two files state of one figure, at each joint of which both do."""
    pairs = ((rows[0], other[joint][0]) for joint, rows in one.items() if joint in other)
    stated = (
        (getattr(mine, name), getattr(its, name)) for mine, its in pairs if name in mine.stated & its.stated
    )
    return [(mine, its) for mine, its in stated if mine is not None and its is not None]


def is_times_off(case: Case, found: Disagreement) -> bool:
    """Whether a limit of one robot is `GRAVE` times the other.

    Variants that are called otherwise are held to each other where most of their joints agree: where most do not,
    they have other motors. So they have where files of another kind have each figure under the same name.
    """
    if not is_times(found.ratio):
        return False
    one, other = found.rows[0].artifact, found.others[0].artifact
    if found.variant and _is_another_motor(case, found):
        return False
    if found.variant and (apart := revision(case, one) ^ revision(case, other)):
        return all(map(_COUNTED.match, apart)) and _is_slip(case, found)
    if not found.variant or distinctive(case.artifacts[one]) == distinctive(case.artifacts[other]):
        return True
    if case.artifacts[one].name == case.artifacts[other].name:
        # Whoever names both says that they are of one robot, and so do they.
        return True
    return _is_of_few(case, found)


def _is_another_motor(case: Case, found: Disagreement) -> bool:
    """Whether a joint has a motor in each of two models that the other has elsewhere, and the models weigh otherwise.

    Who builds in another motor changes torque and speed together, and the links that hold it; a slip changes one.
    """
    rows = found.rows[0], found.others[0]
    robots = [case.artifacts[row.artifact].robot for row in rows]
    masses = [None if robot is None else robot.mass for robot in robots]
    mine, its = ((row.effort_limit, row.velocity_limit) for row in rows)
    if masses[0] is None or masses[1] is None or None in (*mine, *its) or mine[1] == its[1]:
        return False
    if math.isclose(masses[0], masses[1], rel_tol=_ROUNDED):
        return False
    here, there = (
        {(other.effort_limit, other.velocity_limit) for other in case.rows_of(row.artifact)} for row in rows
    )
    return its in here and mine in there


def _is_of_few(case: Case, found: Disagreement) -> bool:
    """Whether two files have one figure at most of their joints, and none of another kind goes along with each."""
    if _is_confirmed(case, found) and _is_confirmed(case, found.turned):
        return False
    one, other = (case.joints_by_artifact.get(rows[0].artifact, {}) for rows in (found.rows, found.others))
    differ = []
    for joint, rows in one.items():
        its = other.get(joint)
        a, b = figure(rows, found.field).value, figure(its, found.other_field).value if its else None
        if a and b:
            differ.append(not math.isclose(a, b, rel_tol=SAME))
    return 2 * sum(differ) < len(differ)


def _is_slip(case: Case, found: Disagreement) -> bool:
    """Whether versions of a robot differ in a joint's effort limit as no version of its motor would.

    At few joints, while the motor turns as fast in both: one of half the torque is faster, or lighter. One speed for
    all joints was looked up for none (Atlas 3 and 4: 12 rad/s, knees of 220 and 890 N*m): then a digit is the slip.
    """
    if found.field != "effort_limit" or not _is_of_few(case, found):
        return False
    rows = found.rows[0], found.others[0]
    speeds = [top_speed(row) if "velocity_limit" in row.stated else None for row in rows]
    if speeds[0] is None or speeds[1] is None or not same(speeds[0], speeds[1]):
        return False
    all_speeds = [{row.velocity_limit for row in case.rows_of(one.artifact)} - {None} for one in rows]
    ratio = found.ratio or 1.0
    return max(ratio, 1.0 / ratio) >= _DIGIT - 1e-9 or min(map(len, all_speeds)) > 1


def _is_confirmed(case: Case, found: Disagreement) -> bool:
    """Whether a file of another kind, called as the one that departs is, has the same figure of the joint."""
    mine, own = found.rows[0], case.artifacts[found.rows[0].artifact]
    for index in case.robot_of(mine.artifact).artifacts:
        beside, rows = case.artifacts[index], case.joints.get((index, mine.joint), ())
        if rows and beside.kind is not own.kind and distinctive(beside) == distinctive(own):
            value = figure(rows, found.field).value
            if value and found.mine.value and math.isclose(value, found.mine.value, rel_tol=SAME):
                return True
    return False


def _are_versions(case: Case, found: Disagreement) -> bool:
    """Whether two files' names tell other versions."""
    return revision(case, found.rows[0].artifact) != revision(case, found.others[0].artifact)


def revision(case: Case, artifact: int) -> frozenset[str]:
    """The versions in the names of a file and its folders: `atlas_v3/model.urdf` and `atlas_v4/model.urdf` differ."""
    parts = os.path.abspath(case.artifacts[artifact].path).split(os.sep)
    return frozenset(found.lower() for found in _REVISION.findall("/".join(parts[-_FOLDERS:])))


def are_alternatives(case: Case, found: Disagreement) -> bool:
    """Whether both files are URDFs, or both MJCF, and no maker's figure tells who is right: one of them is used."""
    one, other = (case.artifacts[rows[0].artifact].kind for rows in (found.rows, found.others))
    return one is other and one in (FileKind.URDF, FileKind.MJCF) and not found.published


def is_times(ratio: float | None) -> bool:
    """Whether one figure is `GRAVE` times the other or more."""
    return ratio is not None and ratio > 0.0 and max(ratio, 1.0 / ratio) >= GRAVE - 1e-9


def is_a_digit_off(ratio: float | None) -> bool:
    """Whether one figure has a digit more than the other, or several."""
    return ratio is not None and ratio > 0.0 and max(ratio, 1.0 / ratio) >= _DIGIT - 1e-9


def is_beyond_the_joint(case: Case, found: Disagreement) -> bool:
    """Whether an mjlab configuration states more than its MJCF gives the joint, which goes on to clamp what it gives.

    Source: mjlab 1.6.0, BuiltinPositionActuatorCfg sets forcerange and leaves actuatorfrcrange.
    """
    config = case.artifacts[found.rows[0].artifact].config
    other = case.artifacts[found.others[0].artifact]
    if config is None or config.framework is not Framework.MJLAB or other.kind is not FileKind.MJCF:
        return False
    joint = None if other.robot is None else other.robot.joint(found.rows[0].joint)
    return joint is not None and joint.effort_range is not None and (found.ratio or 0.0) > 1.0


def is_of_control(case: Case, rows: Sequence[LedgerRow]) -> bool:
    """Whether the control range of an MJCF's motors limits a joint, which is a matter of its task."""
    robot, limit = case.artifacts[rows[0].artifact].robot, rows[0].effort_limit
    if robot is None or limit is None:
        return False
    bound = read_joint(robot, rows[0].joint).force_bound.value
    return bound is not None and bound > limit * (1.0 + 1e-9)


def shown(value: float | None, unit: str) -> str:
    """A figure for a message, three digits."""
    return format_quantity(value, unit, 3)


def stated(figure: Figure) -> str:
    """A file's figure for a message, with what a gear makes it of."""
    text = shown(figure.value, figure.unit)
    return f"{text} ({figure.made})" if figure.made else text


class SourceRule(RuleInParts):
    """What the rules of this family have in common."""

    severity = Severity.WARNING
    confidence = Confidence.MEDIUM
    paired = True
    options: ClassVar[dict[str, float]] = {"tolerance": 0.01}
    groups: ClassVar[tuple[tuple[str, ...], ...]]
    """Fields that are compared; of those in one tuple the first that a file states."""

    def lacks(self, case: Case) -> str:
        """What no two files state."""
        return f"no two files of one robot state {self.needs}"

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        """Compare the files of each robot."""
        tolerance = self.option(case, "tolerance")
        found = [
            at_what_is_edited(case, self._gravest(case, item, tolerance))
            for fields in self.groups
            for item in disagreements(case, fields, tolerance)
            if not self.is_none(case, item, tolerance)
        ]
        # A note says once what holds of copies too; what is to be mended names each of them.
        findings = self.findings(
            case,
            [one for one in found if not one.copy or self.finding(case, one).severity is not Severity.INFO],
        )
        if findings or any(compared(case, fields) for fields in self.groups):
            yield findings

    def _gravest(self, case: Case, found: Disagreement, tolerance: float) -> Disagreement:
        """Beside the file that makes it worst: another one that is right takes nothing from what two of them show.

        Not where models tell versions apart: the others are of the other version.
        """
        every = (found, *found.also)
        if any(one.variant and _are_versions(case, one) for one in every):
            return found
        every = (found, *(one for one in found.also if not self.is_none(case, one, tolerance)))
        worst = max(
            every, key=lambda one: SEVERITIES.index(self.finding(case, one).severity or self.severity)
        )
        # A gear that explains why the first differs explains the others.
        return found if worst is found else replace(worst, more=(found.theirs.place,))

    def findings(self, case: Case, disagreements: Sequence[Disagreement]) -> list[Finding]:
        """What is said of them: one each."""
        return [self.finding(case, found) for found in disagreements]

    def is_none(self, case: Case, found: Disagreement, tolerance: float) -> bool:
        """Whether one of the figures is none that anybody stated, or both are one in two units."""
        return angle_slip(found.ratio, tolerance)

    def consequence(self, case: Case, found: Disagreement) -> str:
        """What it does to the robot, with a number."""
        raise NotImplementedError

    def grave(self, case: Case, found: Disagreement) -> Severity | None:
        """What it is where no variant explains it: two files of one robot cannot both be right. None: one may."""
        return None

    def severity_of(self, case: Case, found: Disagreement) -> tuple[Severity, Confidence]:
        """By what the files are."""
        return self.severity, self.confidence

    def finding(self, case: Case, found: Disagreement) -> Finding:
        """The finding of one joint, at the file that departs."""
        mine, theirs = found.mine, found.theirs
        severity, confidence = self.severity_of(case, found)
        idle = found.field in LIMITS and is_called_undriven(found.rows[0])
        if is_slip_of_run(case, found) and not idle:
            severity, confidence = Severity.WARNING, Confidence.MEDIUM
        elif found.variant or not found.one_machine or idle or (found.field in LIMITS and is_small(found)):
            severity, confidence = Severity.INFO, Confidence.LOW
        # Beside a spec, which tells who is wrong, SPC101 has the error.
        beside = case.kinds_by_artifact[found.rows[0].artifact]
        if found.both_published:
            severity, confidence = Severity.INFO, Confidence.LOW
        elif not idle and found.one_machine and FileKind.SPEC not in beside:
            grave = self.grave(case, found)
            if grave is not None:
                severity, confidence = grave, Confidence.MEDIUM
        file, trained = found.others[0].file, case.once(runs)
        if found.published:
            advice = f"{shown(theirs.value, theirs.unit)} is published for {found.published}: write it here, or set "
            advice += "this aside with the reason"
        elif file in trained:
            advice = f"{file} is what was trained with: write its figure here, or train again with this one"
        elif found.rows[0].file in trained:
            advice = (
                f"this is what was trained with: write it into {file}, or train again with that one's figure"
            )
        else:
            advice = "find out which is right, and write it in both, or set this aside with the reason: "
            advice += f"{file} may be of another variant"
        return Finding(
            self.code,
            f"the {FIELDS[found.field].noun} is {stated(mine)} here and {stated(theirs)} in "
            f"{file}{found.times}: {self.consequence(case, found)}",
            mine.place,
            found.rows[0].joint,
            mine.value,
            mine.unit or None,
            expected=theirs.value,
            help=advice,
            related=(theirs.place, *found.more),
            severity=severity,
            confidence=confidence,
            fields=(found.field,),
        )
