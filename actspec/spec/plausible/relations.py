"""Where figures contradict each other: the one number whose correction makes all of them agree.

Each correction is a slip that people make: a wrong unit, a wrong power of ten, two lines exchanged, a figure of the
other side of the gear. A correction explains a doubt if with it all relations hold. Of several, the one is blamed that
leaves the figures nearest to those of published robots.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Path, alternatives
from actspec.spec.plausible.table import Doubt, at

if TYPE_CHECKING:
    from actspec.spec.document import SourceMap

DEGREE = math.pi / 180.0
"""[rad]"""
RPM = math.pi / 30.0
"""[rad/s]"""
KGF_CM = 0.0980665
"""[N*m]."""
RARE = 0.3
"""What a power of ten costs beside a slip that has a reason, as a distance from usual figures in powers of ten."""
NEAR = 1.0
"""A correction explains a doubt if no relation gets further from what is usual [powers of ten]."""
FAR = 3.0
"""The same where it explains too large a friction as well: that tells large machines from robots."""
ALIKE = 0.1
"""Two readings of one number are both told if they differ by no more than this [powers of ten]."""
TIE = 0.02
"""Corrections of two numbers are both told if they differ by no more than this [powers of ten]."""
TIE_OF_UNITS = 0.05
"""The same of two that have a reason: what is usual hardly parts two units."""
TIE_OF_INERTIA = 0.2
"""The same of the points of an inertia: rotors of one torque differ by two powers of ten."""
TIE_OF_PRODUCT = 0.2
"""The same of the points of two of which hardly more than the ratio is known, such as a torque and the effort limit."""
_RATIOS = (
    frozenset(("no_load_speed", "nominal_voltage")),
    *(frozenset(("effort_limit", f"{word}_torque")) for word in ("stall", "peak", "continuous")),
)

FAR_ABOVE_FILE = 30.0
"""A limit, or what a motor gives, over the limit of the robot's file: it is doubted whatever the file meant."""
ABOUT = 0.2
"""What is that far above may agree less well when it is corrected, by a factor of 2 [powers of ten]."""

MET = 1.1
"""Where the robot's file contradicts a number, a figure in its place is offered if they agree by this factor."""

TO_THE_DIGIT = 1.005
"""It is just the file's figure if it is that by this factor."""
EXACTLY = 0.35
"""What that is worth before others, as `RARE`: a little more than that."""

OTHER_MOTOR = "the robot's file has about the same: is another motor meant, or has this one a wrong unit?"
"""Of a limit that contradicts its motor."""
POINT = "is the point in the wrong place?"
KEEP = "`sure: true` beside it keeps a number that is right"


@dataclass(frozen=True, slots=True)
class Relation:
    """One thing that figures of a drive imply of each other.

    Attributes:
        code: Of its check.
        value: What is judged: one figure over what others say of it.
        bounds: Outside of them no robot is known.
        usual: What published robots have; between two explanations of a doubt these decide.
        message: What is implied.
        path: The figure that is blamed where no other correction explains it.
        help: What may be meant there.
        others: Where the other figures are written.
        beyond: Outside of these bounds nothing could be right.
        about: Tells it from others of the same figures.
        witnessed: It holds a figure against the robot's file, and is only told with a correction that agrees.
        aside: It is told elsewhere, of the joints; of a motor it only refuses corrections that break it.
    """

    code: str
    value: float
    bounds: tuple[float, float]
    usual: tuple[float, float]
    message: str
    path: Path
    help: str | None
    others: tuple[Path, ...] = ()
    beyond: tuple[float, float] = (0.0, math.inf)
    about: str = ""
    witnessed: bool = False
    aside: bool = False

    @property
    def broken(self) -> bool:
        """Whether no robot is known that has it, and it is told here."""
        return not self.aside and not self.bounds[0] <= self.value <= self.bounds[1]

    @property
    def spoiled(self) -> bool:
        """Whether no robot is known that has it, and it is told elsewhere."""
        return self.aside and not self.bounds[0] <= self.value <= self.bounds[1]

    @property
    def error(self) -> bool:
        """Whether nothing could be right."""
        return not self.beyond[0] <= self.value <= self.beyond[1]

    @property
    def excess(self) -> float:
        """How far it is outside of what is usual, in powers of ten."""
        low, high = self.usual
        if not 0.0 < self.value < math.inf:
            # It left the range of floats.
            return math.inf
        below = math.log10(low / self.value) if low and self.value < low else 0.0
        return max(below, math.log10(self.value / high) if self.value > high else 0.0)


@dataclass(frozen=True, slots=True)
class Repair:
    """A correction.

    Attributes:
        after: The relations with it.
        paths: What is corrected.
        help: What was probably meant.
        rare: What it costs before others.
        fitted: Its figure is made from the file's, so that it agrees whatever was meant.
    """

    after: Sequence[Relation]
    paths: tuple[Path, ...]
    help: str | None
    rare: float = 0.0
    fitted: bool = False

    @property
    def is_point(self) -> bool:
        """Whether it moves the point of one number."""
        return self.rare == RARE and (self.help or "").startswith("did you mean")


def explained(before: Sequence[Relation], repairs: Iterable[Repair]) -> list[Repair]:
    """The best correction, with another of the same number that is as good; none where nothing explains all.

    Behind them stands the best of each other number of which one is as good: which is wrong is not known then.
    """
    refuted = {
        _about(relation): relation.value for relation in before if relation.witnessed and relation.broken
    }
    was = {_about(relation): 0.0 if relation.broken else relation.excess for relation in before}
    spoiled = {_about(relation) for relation in before if relation.spoiled}
    found: list[tuple[float, Repair]] = []
    for repair in repairs:
        if any(relation.broken for relation in repair.after):
            continue
        if any(relation.spoiled and _about(relation) not in spoiled for relation in repair.after):
            continue
        if refuted and all(
            relation.excess > (ABOUT if refuted[_about(relation)] > FAR_ABOVE_FILE else 0.0)
            for relation in repair.after
            if _about(relation) in refuted
        ):
            # The robot's file does not say this, either.
            continue
        after = _each_once(repair.after)
        further = sum(max(0.0, relation.excess - was.get(_about(relation), 0.0)) for relation in after)
        freed = bool(spoiled) and not any(relation.spoiled for relation in repair.after)
        if further <= (FAR if freed else NEAR):
            cost = sum(relation.excess for relation in after) + repair.rare
            # A slip that makes it the figure of the file, to the digit, is no accident.
            just = [relation.value for relation in repair.after if _about(relation) in refuted]
            exact = bool(just) and all(1.0 / TO_THE_DIGIT < value < TO_THE_DIGIT for value in just)
            found.append((cost - EXACTLY * (exact and not repair.fitted), repair))
    # What explains too large a friction as well is likelier than two mistakes.
    found = [item for item in found if not any(one.spoiled for one in item[1].after)] or found
    if not found:
        return []
    seen = {relation.path for relation in before if relation.broken and not relation.witnessed}
    # Of equally good ones the one at the figure that the relation is about.
    least, best = min(found, key=lambda item: (round(item[0], 6), seen.isdisjoint(item[1].paths)))
    alike = [
        repair
        for cost, repair in found
        if repair is not best
        and repair.paths == best.paths
        and repair.rare <= ALIKE
        and cost <= least + ALIKE
    ]
    best = _told(best, least, found, refuted)
    rivals: dict[tuple[Path, ...], Repair] = {}
    for cost, repair in sorted(found, key=lambda item: item[0]):
        tie = TIE_OF_UNITS if max(best.rare, repair.rare) < RARE else TIE
        if best.is_point and repair.is_point and {best.paths[0][-1], repair.paths[0][-1]} in _RATIOS:
            tie = TIE_OF_PRODUCT
        if cost <= least + tie and repair.help is not None and set(repair.paths).isdisjoint(best.paths):
            rivals.setdefault(repair.paths, _told(repair, cost, found, refuted))
    return [best, *alike[:1], *rivals.values()]


def _told(
    repair: Repair,
    cost: float,
    found: Sequence[tuple[float, Repair]],
    refuted: Collection[tuple[object, ...]],
) -> Repair:
    """A correction, without its figure where another power of ten is as good, or the robot's file is not met."""
    tie = TIE_OF_INERTIA if str(repair.paths[0][-1]).endswith("inertia") else TIE
    others = (
        other
        for other_cost, other in found
        if other is not repair and other.paths == repair.paths and abs(other_cost - cost) <= tie
    )
    vague = any(other.is_point for other in others) or (
        bool(refuted)
        and not any(
            1.0 / MET <= relation.value <= MET for relation in repair.after if _about(relation) in refuted
        )
    )
    return replace(repair, help=POINT) if repair.is_point and vague else repair


def _each_once(relations: Sequence[Relation]) -> list[Relation]:
    """Without what the robot's file says of one figure again at other joints: twelve legs are no twelve reasons."""
    plain = [relation for relation in relations if not relation.witnessed]
    told = {(item.code, item.path, f"{item.value:.6g}"): item for item in relations if item.witnessed}
    return [*plain, *told.values()]


def _about(relation: Relation) -> tuple[object, ...]:
    """What a relation is about, whatever its figures are."""
    return relation.code, relation.path[-1], relation.others[-1:], relation.about


def explanation(best: Sequence[Repair], broken: Sequence[Relation], spans: SourceMap) -> Doubt:
    """A doubt about what the best correction changes, in the words of the relation that it is most about."""
    blamed = {relation.path for relation in broken}.intersection(best[0].paths) or best[0].paths
    where = min(blamed, key=lambda path: (spans.value(path).line or 0, spans.value(path).column or 0))
    told = min(broken, key=lambda relation: (relation.path != where, where not in relation.others))
    readings = dict.fromkeys(repair.help for repair in best if repair.paths == best[0].paths and repair.help)
    judged = [path for relation in broken for path in (relation.path, *relation.others)]
    error = any(relation.error for relation in broken)
    help = alternatives(readings) or None
    rivals = [repair for repair in best if repair.paths != best[0].paths]
    judged += [path for repair in rivals for path in repair.paths]
    if rivals and help is not None:
        others = [
            f"{repair.paths[0][-1]} ({spans.value(repair.paths[0])}): {repair.help}" for repair in rivals
        ]
        # `side` is no number.
        told_of = "values" if any(repair.paths[0][-1] == "side" for repair in best) else "numbers"
        help = ". Or ".join([f"one of {len(rivals) + 1} {told_of} is wrong. {where[-1]}: {help}", *others])
        help = help.replace("?. Or", "? Or")
    if told.code == "SPEC183":
        # There are larger machines than robots.
        help = f"{help or 'look for a wrong unit'}{'' if (help or '').endswith('?') else ';'} {KEEP}"
    doubt = at(spans, told.code, told.message, where, help, *judged, error=error)
    return replace(doubt, blamed=tuple(spans.value(path) for path in best[0].paths if path != where))
