"""Findings that say the same of many joints, put together."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from actspec.audit.outcome import Reported
from actspec.diagnostics import Severity, Span, listed
from actspec.readings.read import FAULT

MOST_ALIKE = 3
"""Groups that differ in figures only and are still shown one by one. Chosen: more of them say nothing new."""

_FIGURE = re.compile(r"(?<![\w./-])[-+]?(?:x?\d+(?:\.\d+)?(?:e[-+]?\d+)?|inf)(?![\w/]|[.]\w)|'[^']*'")
"""Figures and quoted texts in a message; not digits in a joint's or file's name."""

_MORE = re.compile(r"# % (?:more|less|faster|slower)|# times(?: the| as fast)?|\b(?:more|less)\b| \(#\)")
"""Which of two figures is the larger, in the words of the rules."""


@dataclass(frozen=True, slots=True)
class FindingGroup:
    """Findings with the same rule, file, message, help and severity.

    Attributes:
        members: In the report's order, at least one.
        alike: Others that say the same of the same file with other figures; these are the worst.
        copies: Where other files have the same, which is not repeated there.
        of_others: Whether some of those are of other joints, in words.
        copy_of: Where the same of another file is reported in full; None: nowhere.
    """

    members: tuple[Reported, ...]
    alike: tuple[Reported, ...] = ()
    copies: tuple[Span, ...] = ()
    of_others: str = ""
    copy_of: Span | None = None

    @property
    def first(self) -> Reported:
        """The one whose place stands for all."""
        return self.members[0]

    @property
    def joints(self) -> tuple[str, ...]:
        """Their joints, each once."""
        return tuple(dict.fromkeys(item.finding.joint for item in self.members if item.finding.joint))

    @property
    def concerned(self) -> tuple[object, ...]:
        """Their joints, and those of the others with what is said of them."""
        return (*self.joints, *((item.finding.joint, item.finding.message) for item in self.alike))

    @property
    def spans(self) -> tuple[Span, ...]:
        """Their places, each once; the first stands for all."""
        return tuple(dict.fromkeys(item.finding.span for item in self.members))

    def also_on(self, most: int) -> str:
        """The other lines that the findings are on, in words; "" when there is none.

        Args:
            most: Lines that are named.
        """
        lines = dict.fromkeys(span.line for span in self.spans if span.line != self.spans[0].line)
        return (
            f"also on line{'s' * (len(lines) > 1)} {listed([str(n) for n in lines], most)}" if lines else ""
        )

    def related(self) -> tuple[Span, ...]:
        """Other places that the findings are about, each once."""
        places = (span for item in self.members for span in item.finding.related)
        return tuple(span for span in dict.fromkeys(places) if span not in self.spans)

    def headline(self, most: int = 2) -> str:
        """Joints and message, in one sentence.

        Args:
            most: Joints that are named.
        """
        joints = listed(self.joints, most)
        message = self.first.finding.message
        return (f"{joints}: {message}" if joints else message) + self.others(most) + self.elsewhere(most)

    def others(self, most: int) -> str:
        """Whom else it concerns with other figures, in brackets; "" where nobody.

        Args:
            most: Joints that are named.
        """
        joints = tuple(dict.fromkeys(item.finding.joint for item in self.alike if item.finding.joint))
        names = listed(joints, most) if joints else f"{len(self.alike)} more"
        return f" (similar: {names})" if self.alike else ""

    def elsewhere(self, most: int) -> str:
        """Which other files have the same, in brackets; "" where none.

        Args:
            most: Files that are named.
        """
        return (
            f" (the same{self.of_others} in {listed([span.path for span in self.copies], most)})"
            if self.copies
            else ""
        )


def for_people(found: Iterable[Reported]) -> tuple[FindingGroup, ...]:
    """What people read, in the order of the findings.

    Of groups that differ in figures only one stands for all. What the files of one robot have alike, copies and
    variants of it, is reported once, and so is a note that more than `MOST_ALIKE` files have alike, whatever their
    joints; a warning or error of the same joints in files of several robots is still there for each file, which
    somebody has to mend. Nothing may be looked up in the result.

    Args:
        found: Findings in the report's order.
    """
    groups = _unread_together(_without_copies(grouped(found, fold=True)))
    alike: dict[tuple[object, ...], list[FindingGroup]] = {}
    for group in groups:
        whose = () if group.first.severity is Severity.INFO and not group.alike else group.concerned
        alike.setdefault((*_said(group), *whose), []).append(group)
    changed: dict[int, FindingGroup | None] = {}
    for first, *others in (same for same in alike.values() if len(same) > MOST_ALIKE):
        if first.first.severity is Severity.INFO:
            changed[id(first)] = _with_copies(first, others)
            changed.update((id(other), None) for other in others)
        else:
            changed.update((id(other), replace(other, copy_of=first.first.finding.span)) for other in others)
    each = (changed.get(id(group), group) for group in groups)
    return tuple(group for group in each if group is not None)


def _unread_together(groups: Sequence[FindingGroup]) -> tuple[FindingGroup, ...]:
    """Groups, those of files of a folder that cannot be read at the first of them."""
    alike: dict[str, list[FindingGroup]] = {}
    for group in groups:
        if group.first.finding.code == FAULT and group.first.severity is not Severity.ERROR:
            alike.setdefault(_FIGURE.sub("#", group.first.finding.message), []).append(group)
    changed: dict[int, FindingGroup | None] = {}
    for first, *others in (same for same in alike.values() if len(same) > MOST_ALIKE):
        changed[id(first)] = replace(_with_copies(first, others), of_others=" kind")
        changed.update((id(other), None) for other in others)
    each = (changed.get(id(group), group) for group in groups)
    return tuple(group for group in each if group is not None)


def _said(group: FindingGroup) -> tuple[object, ...]:
    """What a group says, but for its place and joints, and for which copy of a file it is held to."""
    item, finding = group.first, group.first.finding
    texts = [finding.message, finding.help or ""]
    for path in {span.path for span in finding.related if span.path != finding.span.path}:
        texts = [text.replace(path, "#") for text in texts]
    return (finding.code, *texts, item.severity, item.confidence)


def _without_copies(groups: Sequence[FindingGroup]) -> tuple[FindingGroup, ...]:
    """Groups, those of one robot's files that say the same of a joint at the one that concerns most joints."""
    copies: dict[tuple[object, ...], list[FindingGroup]] = {}
    for group in groups:
        robot = group.first.robot
        copies.setdefault((*_said(group), id(group) if robot is None else robot), []).append(group)
    kept: dict[int, FindingGroup] = {}
    for left in copies.values():
        while left:
            main = max(left, key=lambda group: len(group.concerned))
            # A variant with other hands is one too, but what is said of other joints alone is not the same.
            others = [group for group in left if group is not main and _is_copy(group, main)]
            kept[id(main)] = _with_copies(main, others)
            left = [group for group in left if group is not main and group not in others]
    return tuple(kept[id(group)] for group in groups if id(group) in kept)


def _is_copy(group: FindingGroup, main: FindingGroup) -> bool:
    """Whether a group says the same of one of the joints of another, or neither has any."""
    own, theirs = set(group.concerned), set(main.concerned)
    return own <= theirs or not own.isdisjoint(theirs)


def _with_copies(main: FindingGroup, others: Sequence[FindingGroup]) -> FindingGroup:
    """A group with where the others are."""
    if not others:
        return main
    strange = not {joint for other in others for joint in other.joints} <= set(main.joints)
    places = (span for other in others for span in (other.first.finding.span, *other.copies))
    return replace(
        main,
        copies=(*main.copies, *dict.fromkeys(places)),
        of_others=" for other joints" if strange else main.of_others,
    )


def grouped(
    found: Iterable[Reported], *, by_place: bool = False, fold: bool = False
) -> tuple[FindingGroup, ...]:
    """Groups in the order of their first findings.

    Args:
        found: Findings in the report's order.
        by_place: Put only those of one place together.
        fold: Of more than `MOST_ALIKE` groups that differ in figures only, keep the worst, and name the joints of
            the others. For people: nothing may be looked up in the result.
    """
    groups: dict[tuple[object, ...], list[Reported]] = {}
    for item in found:
        finding = item.finding
        place = finding.span if by_place else finding.span.path
        key = (finding.code, place, finding.message, finding.help, item.severity, item.confidence)
        groups.setdefault(key, []).append(item)
    each = tuple(FindingGroup(tuple(members)) for members in groups.values())
    return _folded(each) if fold else each


def _folded(groups: Sequence[FindingGroup]) -> tuple[FindingGroup, ...]:
    candidates: dict[tuple[object, ...], list[FindingGroup]] = {}
    for group in groups:
        item, finding = group.first, group.first.finding
        # What two files say otherwise is one thing to settle, however many joints have it.
        held_to = {span.path for span in finding.related} - {finding.span.path}
        other = next(iter(held_to)) if len(held_to) == 1 and finding.expected is not None else None
        whose = (other, finding.code, finding.span.path, item.severity, item.confidence)
        candidates.setdefault(whose, []).append(group)
    alike: dict[tuple[object, ...], list[FindingGroup]] = {}
    for key, some in candidates.items():
        if len(some) <= _most(key):
            alike[key] = some
            continue
        for group in some:
            finding = group.first.finding
            texts = (_plain(text or "") for text in (finding.message, finding.help))
            alike.setdefault((*key, *texts), []).append(group)
    found: list[FindingGroup] = []
    for key, same in alike.items():
        if len(same) <= _most(key):
            found += same
            continue
        worst = max(same, key=_badness)
        found.append(
            FindingGroup(
                worst.members, tuple(item for group in same if group is not worst for item in group.members)
            )
        )
    place = {id(group.first): index for index, group in enumerate(groups)}
    return tuple(sorted(found, key=lambda group: place[id(group.first)]))


def _most(key: tuple[object, ...]) -> int:
    """Groups that are shown one by one: one, where they hold a file to one other."""
    return MOST_ALIKE if key[0] is None else 1


def _plain(text: str) -> str:
    """A text without its figures, and without which of two is more."""
    return _MORE.sub("#", _FIGURE.sub("#", text))


def _badness(group: FindingGroup) -> float:
    """How far the figure is off, by ratio where it is known what it should be; else its size."""
    value, expected = group.first.finding.value, group.first.finding.expected
    if value is None or math.isnan(value):
        return 0.0
    if expected and value / expected > 0.0 and math.isfinite(value / expected):
        return abs(math.log(value / expected))
    return abs(value)
