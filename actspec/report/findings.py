"""Findings that say the same of many joints, put together."""

from __future__ import annotations

import math
import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from actspec.audit.outcome import Reported
from actspec.diagnostics import SEVERITIES, Severity, Span, listed
from actspec.fields import LIMITS, is_placeholder
from actspec.readings.read import FAULT

MOST_ALIKE = 3
"""Groups about no joint that differ in figures only and are still shown one by one. Chosen: more say nothing new."""

_FIGURE = re.compile(r"(?<![\w./-])[-+]?(?:x?\d+(?:\.\d+)?(?:e[-+]?\d+)?|inf)(?![\w/]|[.]\w)|'[^']*'")
"""Figures and quoted texts in a message; not digits in a joint's or file's name."""

_MORE = re.compile(r"# % (?:more|less|faster|slower)|# times(?: the| as fast)?|\b(?:more|less)\b| \(#\)")
"""Which of two figures is the larger, in the words of the rules."""

_FIRST = re.compile("[,;] ")
"""Behind which a message goes on with what else there is to say."""


@dataclass(frozen=True, slots=True)
class FindingGroup:
    """Findings with the same rule, file, message, help and severity.

    Attributes:
        members: In the report's order, at least one.
        alike: Others that say the same of the same file with other figures; the members are the worst.
        copies: Where other files have the same, which is not repeated there.
        how: How far it is the same, in words: `the same for other joints`.
    """

    members: tuple[Reported, ...]
    alike: tuple[Reported, ...] = ()
    copies: tuple[Span, ...] = ()
    how: str = "the same"

    @property
    def first(self) -> Reported:
        """The one whose place stands for all."""
        return self.members[0]

    @property
    def joints(self) -> tuple[str, ...]:
        """Their joints, each once."""
        return tuple(dict.fromkeys(item.finding.joint for item in self.members if item.finding.joint))

    @property
    def concerned(self) -> frozenset[str]:
        """Their joints, and those of the others."""
        return frozenset(item.finding.joint for item in (*self.members, *self.alike))

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
        text = f"{joints}: {message}" if joints else message
        return text + self.besides(most)

    def besides(self, most: int) -> str:
        """What else belongs to the message: whom it concerns too, where else it is so, what explains it.

        Args:
            most: Joints and files that are named.
        """
        return self.others(most) + self.elsewhere(most) + self.because()

    def others(self, most: int) -> str:
        """Whom else it concerns with other figures, in brackets; "" where nobody.

        Args:
            most: Joints that are named.
        """
        joints = dict.fromkeys(item.finding.joint for item in self.alike if item.finding.joint)
        # One place that several robots share has the same joints.
        others = tuple(joint for joint in joints if joint not in self.joints)
        names = listed(others, most) if others else f"{len(self.alike)} more"
        return f" (similar: {names})" if self.alike else ""

    def because(self) -> str:
        """Which finding tells the fault, in brackets; "" where this one does."""
        cause = self.first.cause
        return "" if cause is None else f" (explained by {cause.code} at {cause.span})"

    def elsewhere(self, most: int) -> str:
        """Which other files have the same, in brackets; "" where none.

        Args:
            most: Files that are named.
        """
        own = {span.path for span in self.spans}
        paths = [path for path in dict.fromkeys(span.path for span in self.copies) if path not in own]
        return f" ({self.how} in {listed(paths, most)})" if paths else ""


class Counts(NamedTuple):
    """How much a report shows: the one count of every format.

    Attributes:
        errors, warnings, notes: Groups of the severity.
        joints: That they are about, each once.
        patterns: Of joints that nobody names, in a configuration.
    """

    errors: int
    warnings: int
    notes: int
    joints: int
    patterns: int


_OF_PATTERNS = re.compile(r"[*+?\[({|\\^$]")
"""What no joint's name has, and a pattern in its place does."""


def counts(groups: Iterable[FindingGroup]) -> Counts:
    """How much is shown.

    Args:
        groups: Of `for_people`: what is equal for many joints or files counts once.
    """
    severities: Counter[Severity] = Counter()
    joints: set[str] = set()
    for group in groups:
        severities[group.first.severity] += 1
        for item in (*group.members, *group.alike):
            joints.update(item.finding.joints or filter(None, (item.finding.joint,)))
    patterns = sum(bool(_OF_PATTERNS.search(joint)) for joint in joints)
    errors, warnings, notes = (severities[severity] for severity in reversed(SEVERITIES))
    return Counts(errors, warnings, notes, len(joints) - patterns, patterns)


def for_people(found: Iterable[Reported]) -> tuple[FindingGroup, ...]:
    """What people read, in the order of the findings.

    What a rule says of one figure of a file's joints is reported once, where it is worst, and the other joints are
    named. So is what several files have alike, copies and variants of a robot: each of them has to be mended, and is
    named. Nothing may be looked up in the result.

    Args:
        found: Findings in the report's order.
    """
    groups = grouped(found)
    place = {id(group.first): index for index, group in enumerate(groups)}
    shown = _unread_together(_over_files(in_files(groups)))
    return tuple(sorted(shown, key=lambda group: place[id(group.first)]))


def _unread_together(groups: Sequence[FindingGroup]) -> Iterator[FindingGroup]:
    """Groups, those of files of a folder that cannot be read at the first of them."""
    alike: dict[object, list[FindingGroup]] = {}
    for group in groups:
        unread = group.first.finding.code == FAULT and group.first.severity is not Severity.ERROR
        alike.setdefault(_plain(group.first.finding.message) if unread else id(group), []).append(group)
    for same in alike.values():
        if len(same) > MOST_ALIKE:
            yield replace(_with_copies(same[0], same[1:]), how="the same kind")
        else:
            yield from same


def _over_files(groups: Sequence[FindingGroup]) -> list[FindingGroup]:
    """Groups, those of several files that say the same at the one that concerns most joints."""
    copies: dict[int, list[FindingGroup]] = {}
    mains: dict[tuple[object, ...], FindingGroup] = {}
    for group in sorted(groups, key=lambda group: -len(group.concerned)):
        main = next(filter(None, (mains.get(mark) for item in group.members for mark in _marks(item))), group)
        copies.setdefault(id(main), []).append(group)
        # Of what is to be mended each joint counts by itself: who mends the one that is shown has not mended another.
        is_note = group.first.severity is Severity.INFO
        for item in (*group.members, *(group.alike if is_note else ())) if main is group else ():
            for mark in _marks(item):
                mains.setdefault(mark, group)
    return [_with_copies(same[0], same[1:]) for same in copies.values()]


def _marks(item: Reported) -> Iterator[tuple[object, ...]]:
    """What a finding has in common with that of another file: its words, or what they say of the same joint."""
    finding = item.finding
    about = (finding.code, item.severity is Severity.INFO, finding.fields[:1])
    held = [span for span in finding.related if span.path != finding.span.path]
    texts = [_wherever(text, held) for text in (finding.message, finding.help or "")]
    if not finding.joint or item.severity is Severity.INFO:
        yield (*about, *texts)
    # A warning or error of other joints is another one: each file has its line. A limit that nobody filled in, or that
    # has no effect where it is written, is one thing, whatever the joints.
    if finding.fields == ("velocity_limit",) and finding.value is None and not held:
        yield (*about, texts[0])
    value = finding.value if LIMITS.intersection(finding.fields[:1]) else None
    if value is not None and (value == 0.0 or is_placeholder(value)):
        yield (*about, _plain(texts[0]))
    if not finding.joint:
        return
    if finding.expected is None or not held:
        yield (*about, finding.joint, _plain(texts[0]))
    else:
        # Files that depart alike from one place are one thing to settle; and so is one figure that departs from two.
        yield (*about, finding.joint, held[0], _plain(texts[0]))
        yield (*about, finding.joint, finding.value, finding.expected)


def _with_copies(main: FindingGroup, others: Sequence[FindingGroup]) -> FindingGroup:
    """A group with where the others are."""
    if not others:
        return main
    how = "the same" if all(_text(other) == _text(main) for other in others) else "similar"
    extent = ""
    if any(not other.concerned <= main.concerned for other in others):
        extent = " for other joints"
    elif any(other.concerned != main.concerned for other in others):
        extent = " for some of these joints"
    places = (span for other in others for span in (other.first.finding.span, *other.copies))
    return replace(
        main,
        copies=(*main.copies, *dict.fromkeys(places)),
        how=how + extent,
    )


def _text(group: FindingGroup) -> str:
    """What a group says, whatever files it is held to."""
    finding = group.first.finding
    return _wherever(finding.message, finding.related)


def _wherever(text: str, held: Iterable[Span]) -> str:
    """A text without which copy of a file it is held to, and which of the robot's files has a figure."""
    for span in held:
        text = text.replace(f" ({os.path.basename(span.path)})", "").replace(span.path, "#")
    return text


def grouped(found: Iterable[Reported], *, by_place: bool = False) -> tuple[FindingGroup, ...]:
    """Groups in the order of their first findings.

    Args:
        found: Findings in the report's order.
        by_place: Put only those of one place together.
    """
    groups: dict[tuple[object, ...], list[Reported]] = {}
    for item in found:
        finding = item.finding
        place = finding.span if by_place else finding.span.path
        cause = None if item.cause is None else item.cause.code
        key = (finding.code, place, finding.message, finding.help, item.severity, item.confidence, cause)
        groups.setdefault(key, []).append(item)
    return tuple(FindingGroup(tuple(members)) for members in groups.values())


def in_files(groups: Sequence[FindingGroup]) -> list[FindingGroup]:
    """Groups, of those that say the same of one file the worst with the joints of the others."""
    alike: dict[tuple[object, ...], list[FindingGroup]] = {}
    for group in groups:
        item, finding = group.first, group.first.finding
        # What two files say otherwise is one thing to settle, however many joints have it.
        held_to = {span.path for span in finding.related} - {finding.span.path}
        other = next(iter(held_to)) if len(held_to) == 1 and finding.expected is not None else None
        # Of one figure what the rest of the sentence says of it is no other fault.
        texts = (
            (_FIRST.split(finding.message)[0],) if finding.fields else (finding.message, finding.help or "")
        )
        about = (*finding.fields[:1], *map(_plain, texts))
        is_note = item.severity is Severity.INFO
        key = (finding.code, finding.span.path, other, *about, is_note, item.cause and item.cause.code)
        alike.setdefault(key, []).append(group)
    found: list[FindingGroup] = []
    for same in alike.values():
        if len(same) <= (1 if same[0].first.finding.joint else MOST_ALIKE):
            found += same
        else:
            found.append(_worst_of(same))
    # One figure of several robots, held to what is published for each, is one place to mend.
    places: dict[object, list[FindingGroup]] = {}
    for group in found:
        finding = group.first.finding
        known = finding.expected is not None and not finding.related and bool(finding.joint)
        place = (finding.code, finding.span, finding.fields[:1], group.first.severity)
        places.setdefault(place if known else id(group), []).append(group)
    return [_worst_of(same) for same in places.values()]


def _worst_of(groups: Sequence[FindingGroup]) -> FindingGroup:
    """The worst group, which has the others' findings beside its own."""
    if len(groups) == 1:
        return groups[0]
    worst = max(groups, key=_badness)
    rest = (item for group in groups if group is not worst for item in (*group.members, *group.alike))
    return replace(worst, alike=(*worst.alike, *rest))


def _plain(text: str) -> str:
    """A text without its figures, and without which of two is more."""
    return _MORE.sub("#", _FIGURE.sub("#", text))


def _badness(group: FindingGroup) -> tuple[int, float]:
    """How bad it is, then how far the figure is off: by ratio where it is known what it should be, else its size.

    Of limits that somebody chose the least is the worst then.
    """
    severity = SEVERITIES.index(group.first.severity)
    finding = group.first.finding
    value, expected = finding.value, finding.expected
    if value is None or math.isnan(value):
        return severity, 0.0
    if expected and value / expected > 0.0 and math.isfinite(value / expected):
        return severity, abs(math.log(value / expected))
    least = LIMITS.intersection(finding.fields[:1]) and not is_placeholder(value)
    return severity, -abs(value) if least else abs(value)
