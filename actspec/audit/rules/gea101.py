from __future__ import annotations

import math
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from actspec.audit.known import likenesses
from actspec.audit.known import same as is_published
from actspec.audit.rule import Case, Confidence, Finding, RuleInParts, Severity
from actspec.audit.rules.joints import shown, unit
from actspec.audit.rules.reductions import (
    SAME,
    Figures,
    Reduction,
    figures,
    limbs_of,
    reductions,
    same,
    states_speed,
)
from actspec.audit.rules.sym101 import unlike_sides
from actspec.diagnostics import Span
from actspec.readings.artifact import FileKind
from actspec.units import format_quantity

_MODELS = (FileKind.MJCF, FileKind.URDF, FileKind.SPEC)


@dataclass(frozen=True, slots=True)
class _Told:
    """What is said of one joint of a file beside one other file.

    Attributes:
        finding: It.
        joint: The figures that depart.
        right: Those of the other file.
    """

    finding: Finding
    joint: Figures
    right: Figures


class HiddenGear(RuleInParts):
    code = "GEA101"
    name = "hidden-gear"
    severity = Severity.WARNING
    confidence = Confidence.HIGH
    noted_in_folders = True
    paired = True
    needs = "no file with effort and speed limits beside another file of the same robot"

    def subjects(self, case: Case) -> Iterator[Iterable[Finding]]:
        """Compare the files of each robot with the reductions that one of them has."""
        known = case.once(figures)
        for robot in case.robots:
            if not states_speed(known, robot):
                continue
            above = limbs_of(case, robot)
            # Several files may have the same reduction: one of them is enough.
            seen: set[tuple[str, str, float]] = set()
            told: dict[tuple[Span, str], list[_Told]] = {}
            for reference in robot.artifacts:
                found = list(reductions(known.get(reference, {}), above))
                has_speed = any(joint.speed is not None for joint in known.get(reference, {}).values())
                for other in robot.artifacts:
                    if other == reference or other not in known:
                        continue
                    if has_speed:
                        yield ()
                    for reduction in found:
                        one = self._compare(case, known, reduction, other)
                        if one is None:
                            continue
                        place = one.finding.span
                        key = (place.path, one.finding.joint, round(reduction.ratio, 1))
                        if key not in seen:
                            seen.add(key)
                            told.setdefault((place, one.finding.joint), []).append(one)
            for figure in told.values():
                yield (_told_once(case, figure),)

    def _compare(
        self, case: Case, known: Mapping[int, Mapping[str, Figures]], reduction: Reduction, other: int
    ) -> _Told | None:
        there = known[other]
        joint, base = there.get(reduction.joint.row.joint), there.get(reduction.base.row.joint)
        if joint is None or base is None or (other, joint.row.joint) in case.once(unlike_sides):
            return None
        agree = same(base.effort, reduction.base.effort) and same(base.speed, reduction.base.speed)
        if not agree or same(joint.effort, reduction.joint.effort):
            return None
        if _is_equal(joint, base):
            urdf = case.artifacts[reduction.joint.row.artifact].kind is FileKind.URDF
            twins = urdf and case.artifacts[other].kind is FileKind.URDF
            if twins or _confirmed(case, known, joint) or _is_published_alone(case, joint, reduction.joint):
                return None
            return _Told(self._left_out(case, joint, reduction), joint, reduction.joint)
        powers = [one.effort * one.speed for one in (joint, base) if one.speed is not None]
        consistent = len(powers) == 2 and math.isclose(*powers, rel_tol=SAME)
        # Told once, whatever the files' order: at the later path, unless what is published tells.
        if not consistent or _order(case, joint) < _order(case, reduction.joint):
            return None
        sides = (joint, base), (reduction.joint, reduction.base)
        if _is_published_alone(case, joint, reduction.joint, also=False):
            sides = sides[::-1]
        return _Told(self._different(*sides), sides[0][0], sides[1][0])

    def _left_out(self, case: Case, joint: Figures, reduction: Reduction) -> Finding:
        right, ratio = reduction.joint, reduction.ratio
        share = format_quantity(joint.effort / right.effort, "", 2)
        gets = f"it gets {share} of its torque"
        if joint.speed is not None and right.speed is not None:
            gets += f" and {format_quantity(joint.speed / right.speed, '', 3)} times its speed"
        robot, published = _published(case, joint)
        is_variant = any(is_published(joint.effort, one) for one in published)
        variant = f"; {shown(joint.row, 'effort_limit', joint.effort)} is published for a variant of {robot}"
        return Finding(
            self.code,
            f"a reduction of {ratio:.4g} is left out: this joint has the limits of joints with less gear "
            f"({_limits(joint)}), and {right.place.path} gives it {_limits(right)} against their "
            f"{_limits(reduction.base)}, the same power behind {ratio:.4g} times the reduction: {gets}, and its "
            f"armature must be {ratio**2:.3g} times theirs{variant if is_variant else ''}",
            joint.place,
            joint.row.joint,
            joint.effort,
            unit(joint.row, "effort_limit"),
            right.effort,
            f"give this joint a group of its own with {_limits(right)}, if the reduction is there on the robot",
            (right.place, reduction.base.place),
            fields=("effort_limit",),
        )

    def _different(self, wrong: tuple[Figures, Figures], right: tuple[Figures, Figures]) -> Finding:
        """Of a joint and one with the same motor, in the file that departs and in the other."""
        joint, other = wrong[0], right[0]
        ratios = [one.effort / base.effort for one, base in (wrong, right)]
        return Finding(
            self.code,
            f"the reduction is {ratios[0]:.4g} times that of joints with the same motor here ({_limits(joint)}), and "
            f"{ratios[1]:.4g} times in {other.place.path} ({_limits(other)}): one of the "
            "files is of another robot or revision",
            joint.place,
            joint.row.joint,
            joint.effort,
            unit(joint.row, "effort_limit"),
            other.effort,
            "find out which reduction the robot has",
            (other.place,),
            confidence=Confidence.MEDIUM,
            fields=("effort_limit",),
        )


def _told_once(case: Case, found: Sequence[_Told]) -> Finding:
    """Of one figure: by the file whose figure is published, else by the first path; another file has another gear."""
    efforts = _published(case, found[0].joint, also=False)[1]

    def rank(one: _Told) -> tuple[bool, tuple[str, int]]:
        known = any(is_published(one.right.effort, effort) for effort in efforts)
        return not known, _order(case, one.right)

    first, *rest = sorted(found, key=rank)
    others = [one.right for one in rest if not same(one.right.effort, first.right.effort)]
    if not others:
        return first.finding
    other = others[0]
    return replace(
        first.finding,
        message=f"{first.finding.message}; {other.place.path} gives it {_limits(other)}: one of the two is of another "
        "robot or revision",
        related=(*first.finding.related, *(one.place for one in others)),
    )


def _is_equal(joint: Figures, base: Figures) -> bool:
    """Whether a file gives both joints the same figures."""
    speeds = joint.speed is None or base.speed is None or math.isclose(joint.speed, base.speed, rel_tol=0.01)
    return math.isclose(joint.effort, base.effort, rel_tol=0.01) and speeds


def _confirmed(case: Case, known: Mapping[int, Mapping[str, Figures]], joint: Figures) -> bool:
    """Whether another model of the robot, not a copy of the same lines, has the joint's figure too."""
    place = joint.place
    for other in case.robot_of(joint.row.artifact).artifacts:
        there = known.get(other, {}).get(joint.row.joint)
        if there is None or case.artifacts[other].kind not in _MODELS or other == joint.row.artifact:
            continue
        if there.place != place and same(there.effort, joint.effort):
            return True
    return False


def _order(case: Case, joint: Figures) -> tuple[str, int]:
    """Of a file among those of its robot: by its path, as in a folder, in whatever order they were named."""
    return os.path.abspath(case.artifacts[joint.row.artifact].path), joint.row.artifact


def _published(case: Case, joint: Figures, *, also: bool = True) -> tuple[str, frozenset[float]]:
    """The known robot that a file is of, and the torques that are published for its joint, of any variant; or none.

    With what the maker states elsewhere (`also`), or without.
    """
    for found in case.once(likenesses):
        for row, names in found.joints if found.index == joint.row.artifact else ():
            if row.joint == joint.row.joint:
                efforts = (
                    found.robot.efforts(name)
                    if also
                    else {variant[name].effort for variant in found.robot.variants.values()}
                    for name in names
                )
                return found.robot.name, frozenset.intersection(*map(frozenset, efforts))
    return "", frozenset()


def _is_published_alone(case: Case, joint: Figures, other: Figures, *, also: bool = True) -> bool:
    """Whether a limit is published for its joint, of any variant, and the other file's is not; `also` as above."""
    efforts = frozenset().union(*(_published(case, one, also=also)[1] for one in (joint, other)))
    mine, its = (any(is_published(one.effort, figure) for figure in efforts) for one in (joint, other))
    return mine and not its


def _limits(joint: Figures) -> str:
    text = shown(joint.row, "effort_limit", joint.effort)
    return text if joint.speed is None else f"{text} at {shown(joint.row, 'velocity_limit', joint.speed)}"
