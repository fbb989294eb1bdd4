"""One fault that several rules see is told by the rule that is nearest to its cause; what the others say is a note.

Rules look at nothing but the files. What two of them say of one figure is brought together here and nowhere else.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from actspec.audit.finding import Finding
from actspec.audit.outcome import Reported
from actspec.diagnostics import SEVERITIES, Severity, Span
from actspec.fields import LIMITS

ORDER = (
    "SPC107",
    *("SGN101", "SGN102", "ORD103", "ORD102", "UNT103", "UNT104", "UNT105", "UNT107"),
    *("GEA101", "GEA105", "STB101", "SYM101", "LIM101", "LIM106"),
    *("UNT106", "SRC101", "SRC102", "KNW101", "KNW103"),
    *("LIM107", "GEA102"),
    *("VER106", "DMP105", "DMP101", "DMP103"),
    *("FRC101", "SRC105"),
    *("ORD104", "LIM111", "SRC103", "SRC104", "SRC106"),
    *("SPC101", "LIM108"),
)
"""Rules about a figure, the nearest to its cause first: a file of another variant departs from the spec wherever
variants differ; a wrong sign is wrong whatever others have; of two groups
that have a joint one gives it the wrong figures, and a list in another order gives many; degrees in the place of
radians, or another unit, are why a joint diverges, is out of its range, or differs; a gear says by what a limit or a
gain is off, a file that contradicts itself which side is wrong, a limit that nobody stated, or is stated twice, why
files differ, two files that differ why one is not the published one, which tells why a torque-speed line begins below
its limit; a servo that lost its gains, or damping that is counted twice, in two files or in one, why a joint is slow;
friction that no motor overcomes why another file has less; a key that is misspelt why a joint starts at 0, and a
position that the joint cannot take why two files differ. Chosen: from the findings of docs/survey.md that were true and
told a second time."""

_ALONE_BY = {
    **dict.fromkeys(("SGN102", "ORD104", "LIM106"), frozenset[str]()),
    "SYM101": frozenset(ORDER[1 : ORDER.index("SYM101")]) - {"GEA101"},
    "SPC101": frozenset({"SPC107"}),
    "LIM108": frozenset({"SPC107"}),
    "SRC103": frozenset({"SGN101", "SGN102", "ORD102", "ORD103", "UNT103", "UNT107", "SYM101"}),
    "SRC104": frozenset({"SGN101", "ORD103", "UNT105", "SYM101", "KNW103", "GEA102"}),
    "SRC106": frozenset({"ORD102", "ORD103", "UNT103", "SYM101", "ORD104", "LIM111"}),
}
"""What alone explains that gains, armatures or poses differ, or that a file departs from the spec: others that have the
figure say nothing of the other file, nor of what the simulator makes of a sign, a key or two limits."""

_GEAR, _SIDES, _FRICTION, _LOST_GAINS, _PUBLISHED = "GEA101", "SYM101", "FRC101", "VER106", "KNW101"
_DEGREES, _UNIT, _GAINS, _NO_JOINT, _TWO_LIMITS = "UNT103", "UNT105", "SRC103", "UNT107", "LIM106"

_WITH_THE_RIGHT_ONE = {"GEA102": frozenset({"SRC104"}), "LIM106": frozenset({"SRC101", "SRC102"})}
"""Rules that name the figure which should stand there, and what they explain if another file has that one."""

_SAME = 0.05
"""Relative difference up to which two of these figures are one. Chosen: SRC104's `tolerance`."""

_OF_ONE_FILE = frozenset({_GEAR, _SIDES, _DEGREES, "UNT104", _UNIT, "UNT106", "LIM101"})
"""Rules whose finding is in the file that is wrong, and which explain nothing of a file beside it alone."""

PUBLISHED = 1.2
"""How many times the published figure another one is that still is that figure. Chosen: KNW101's `times`."""


def by_cause(
    found: Sequence[Reported],
    *,
    counts: Callable[[Reported], bool],
    fixed: Callable[[str], bool],
    whose: Callable[[Span], frozenset[int]] = lambda place: frozenset(),
) -> tuple[Reported, ...]:
    """Findings, those that another one explains as notes that name it. None is left out.

    One explains another where its rule stands before the other's in `ORDER`, and both are about the same figure of a
    joint of one robot in the file that departs from the others. It takes the worst severity of what it explains. Of
    findings that say the same of a file, the rest is explained where most are.

    Args:
        found: Findings of all rules.
        counts: Whether a finding is reported at all: what is not, explains nothing.
        fixed: Whether the settings state the severity of a rule, by its code: it stays as it is.
        whose: Artifacts that a place states something of, as a file has configurations of several robots; none: nobody
            knows.
    """
    able = _Findings(found, whose)
    causes = able.causes(counts)
    causes |= _rest(found, causes, whose)
    causes = {at: cause for at, cause in causes.items() if not fixed(found[at].finding.code)}
    worst = {
        cause: found[cause].severity for cause in causes.values() if not fixed(found[cause].finding.code)
    }
    for at, cause in causes.items():
        if cause in worst:
            worst[cause] = max(worst[cause], found[at].severity, key=SEVERITIES.index)
    return tuple(
        replace(item, severity=Severity.INFO, cause=found[causes[at]].finding)
        if at in causes
        else replace(item, severity=worst.get(at, item.severity))
        for at, item in enumerate(found)
    )


_Key = tuple[str, str] | Span


class _Findings:
    """Findings about figures, by what they are about.

    Args:
        found: All findings.
        whose: As in `by_cause`.
    """

    def __init__(self, found: Sequence[Reported], whose: Callable[[Span], frozenset[int]]) -> None:
        self._found = found
        self._whose = whose
        self._ranks = {code: rank for rank, code in enumerate(ORDER)}
        self._near: dict[_Key, list[int]] = {}
        # What stands at a place and no rule before `_SIDES` tells.
        self._standing: dict[Span, list[Finding]] = {}
        for at, item in enumerate(found):
            one = item.finding
            if one.code in self._ranks and one.fields and item.severity is not Severity.INFO:
                for key in _keys(one):
                    self._near.setdefault(key, []).append(at)

    def causes(self, counts: Callable[[Reported], bool]) -> dict[int, int]:
        """Index of each finding that is explained to that of what explains it, which nothing explains."""
        ranked = sorted({at for group in self._near.values() for at in group}, key=self._rank)
        for at in ranked:
            if not self._able(at, counts, {}, self._ranks[_SIDES]):
                one = self._found[at].finding
                for span in (one.span, *one.related):
                    self._standing.setdefault(span, []).append(one)
        causes: dict[int, int] = {}
        for at in ranked:
            able = self._able(at, counts, causes, self._rank(at))
            if able:
                first = min(able, key=lambda other: (self._rank(other), other))
                causes[at] = causes.get(first, first)
        return causes

    def _able(
        self, at: int, counts: Callable[[Reported], bool], causes: Mapping[int, int], before: float
    ) -> list[int]:
        """What explains a finding, of the rules before a rank and its own."""
        one = self._found[at].finding
        return [
            other
            for other in {other for key in _keys(one) for other in self._near[key]}
            if self._rank(other) < min(before, self._rank(at))
            and counts(self._found[other])
            and self._explains(self._found[other].finding, one)
            and _is_of_its_figure(self._found[causes.get(other, other)].finding, one)
        ]

    def _rank(self, at: int) -> float:
        one = self._found[at].finding
        if one.code == _UNIT and one.expected is None:
            # What looks like another unit by itself says less than who knows the right figure.
            return len(ORDER)
        if one.code == _GAINS and len(one.fields) > 1:
            # Of gains that are exchanged in one of two files it has the right ones too.
            return self._ranks[_NO_JOINT] - 0.5
        return self._ranks[one.code]

    def _apart(self, one: Finding, other: Finding) -> bool:
        """Whether all that two findings have in common are files, in each of which they are of other robots."""
        shared = _files(one) & _files(other)
        return bool(shared) and all(
            bool(its := self._of(one, path)) and bool(theirs := self._of(other, path)) and not its & theirs
            for path in shared
        )

    def _of(self, finding: Finding, path: str) -> frozenset[int]:
        """Artifacts of a file that a finding is about; none: nobody knows."""
        places = [self._whose(span) for span in (finding.span, *finding.related) if span.path == path]
        return frozenset().union(*places) if all(places) else frozenset()

    def _explains(self, one: Finding, other: Finding) -> bool:
        """Whether what one finding says is why the other, at one of its places, is there."""
        if self._apart(one, other) or _leaves_unpublished(one, other) or _leads_away(one, other):
            return False
        if one.code not in _ALONE_BY.get(other.code, {one.code}):
            return False
        if one.code == _LOST_GAINS:
            # The damping is too much for the gain that is left.
            return one.joint == other.joint and other.code == "DMP101"
        if other.code in _WITH_THE_RIGHT_ONE.get(one.code, ()) or one.code == _TWO_LIMITS:
            right = one.expected, other.expected
            return (
                other.code in _WITH_THE_RIGHT_ONE[one.code]
                and (one.joint, one.span) == (other.joint, other.span)
                and None not in right
                and math.isclose(*(figure or 0.0 for figure in right), rel_tol=_SAME)
            )
        if one.code == _DEGREES and one.span not in (other.span, *other.related):
            # The figure in the other file is the right one.
            return False
        figures = set(one.fields)
        if "effort_limit" in figures and one.code != _SIDES:
            # A motor's torque and speed come from one line of a datasheet.
            figures |= LIMITS
        if not figures.issuperset(other.fields):
            return False
        if one.code == _FRICTION:
            # Beside the friction stands the limit, which may be another file's.
            return one.joint == other.joint and one.span.path in _files(other)
        if one.code == _SIDES:
            # Where both sides differ from another file, that is another fault.
            both = (one.span, *one.related)
            if len(set(both)) == 1:
                # One setting states both sides: what is said at its place may be of either.
                return one.joint == other.joint
            if {other.span, *other.related} <= set(both):
                # Two files are the sides, whose joints have one name.
                return one.joint == other.joint
            # The odd side speaks for itself where another file than that one contradicts the right one.
            odd = one.joint == other.joint
            beside = _files(other) - {span.path for span in both} if odd else frozenset()
            return not all(
                any(
                    its.code == other.code and (not beside or beside & _files(its))
                    for its in self._standing.get(span, ())
                )
                for span in both
            )
        if one.code.startswith("SRC") and other.code.startswith("SRC"):
            # Two files that differ from each other say nothing of a third; one that differs from two, of either.
            mine, its = _files(one), _files(other)
            return one.joint == other.joint and (mine <= its or its <= mine)
        # Of two sides that differ the one whose figure is wrong may be either.
        return one.joint == other.joint or (other.code == _SIDES and one.span in other.related)


def _leaves_unpublished(one: Finding, other: Finding) -> bool:
    """Whether to follow a finding would leave what the other one says of the published figure as it is.

    Of a limit that is too large any smaller one may be that of another variant.
    """
    told = [figure for figure in (one.value, one.expected) if figure is not None]
    wrong, published = other.value, other.expected
    if (
        other.code != _PUBLISHED
        or wrong is None
        or published is None
        or len(told) < 2
        or one.unit != other.unit
    ):
        return False
    least = 0.0 if wrong > published else published / PUBLISHED
    return not any(least <= figure <= PUBLISHED * published for figure in told)


def _leads_away(one: Finding, other: Finding) -> bool:
    """Whether a file with the gear that it left out is farther from the figure of a third one than without: of 23.5 N*m
    for 45.43 the 3.555 of another file is another fault.
    """
    wrong, right, figures = one.value, one.expected, (other.value, other.expected)
    if (
        one.code != _GEAR
        or not other.code.startswith("SRC")
        or one.unit != other.unit
        or wrong not in figures
    ):
        return False
    third = figures[1 - figures.index(wrong)]
    return None not in (wrong, right, third) and (third or 0.0) < (wrong or 0.0) < (right or 0.0)


def _keys(finding: Finding) -> set[_Key]:
    """What findings of one fault have in common: joint and file, or a place of which nobody knows if it is the wrong
    side.
    """
    places = (finding.span, *finding.related)
    return {*((finding.joint, span.path) for span in places), *places}


def _is_of_its_figure(one: Finding, other: Finding) -> bool:
    """Whether the joint and the file that depart by one finding are among those that the other is about.

    Of two files, or sides, that differ nobody knows which departs, unless a third finding tells. A gear, or the other
    side, is taken from a file that is right, and another unit, or a placeholder, is one whatever the other file has.
    """
    its_joint = one.joint == other.joint or _SIDES in (one.code, other.code)
    return its_joint and (one.code not in _OF_ONE_FILE or one.span.path in _files(other))


def _files(finding: Finding) -> frozenset[str]:
    return frozenset(span.path for span in (finding.span, *finding.related))


def _rest(
    found: Sequence[Reported], causes: Mapping[int, int], whose: Callable[[Span], frozenset[int]]
) -> dict[int, int]:
    """What says the same of the same robots of a file as findings most of which are explained."""
    alike: dict[tuple[str, str, str, frozenset[int]], list[int]] = {}
    for at, item in enumerate(found):
        if item.severity is not Severity.INFO and item.finding.code in ORDER:
            one = item.finding
            alike.setdefault((one.code, one.span.path, one.message, whose(one.span)), []).append(at)
    rest: dict[int, int] = {}
    for group in alike.values():
        known = [at for at in group if at in causes]
        if 2 * len(known) > len(group):
            rest |= {at: causes[known[0]] for at in group if at not in causes and at not in causes.values()}
    return rest
