"""Which remarks no selection of the files has a use for.

A hook sees the files of a commit, a run over the folder all of them: another file of the robot may silence
a rule on a line, or make it speak. A remark that one of the two needs must not be called unused by the other.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence

from actspec.audit.case import Case
from actspec.audit.finding import Finding, Skipped
from actspec.audit.ignores import Ignore
from actspec.audit.rule import Rule
from actspec.readings.artifact import FileKind, FileReading

Looked = Callable[[type[Rule], Sequence[FileReading]], tuple[Sequence[Finding], Sequence[Skipped]] | None]
"""Lets one rule look at a selection of the files: what it found and what it lacked; None when it broke off."""

_MODELS = (FileKind.MJCF, FileKind.URDF)
"""Files whose ledger rows need no other file; those of a configuration have its model's joints and inertia."""


def certainly_unused(
    unused: Iterable[tuple[Ignore, str]],
    rules: Mapping[str, type[Rule]],
    case: Case,
    whole: Collection[str],
    looked: Looked,
) -> Iterator[tuple[Ignore, str]]:
    """Of remarks that set nothing aside in this run, those that would in none with fewer or more of the files.

    What a rule that judges a file by itself finds there is found without the other files at most. Of a rule that also
    compares files nobody knows which others there are unless a folder was named: then the file by itself, with each
    other one of its robot, with all, and with all but one are looked at.

    Args:
        unused: Remarks with those of their codes or names that set nothing aside.
        rules: Code and name to the rule, for rules that ran and had input.
        case: The whole case.
        whole: Files that were found in a folder, so that the others of their robot are among the files.
        looked: How one rule looks at a selection.
    """
    for ignore, code in unused:
        rule = rules.get(code)
        if rule is None:
            continue
        # What speaks about no line is of no use to anybody.
        if not ignore.placed or _useless(ignore, rule, case, whole, looked):
            yield ignore, code


def _useless(ignore: Ignore, rule: type[Rule], case: Case, whole: Collection[str], looked: Looked) -> bool:
    own = os.path.realpath(ignore.span.path)
    homes = [reading for reading in case.files if any(os.path.realpath(f.path) == own for f in reading.files)]
    for home in homes:
        if not rule.paired and home.kind in _MODELS:
            selections = _selections(case, home, ())
        elif home.path not in whole:
            return False
        else:
            selections = _selections(case, home, _partners(case, home))
        for number, selection in enumerate(selections):
            seen = looked(rule, selection)
            if seen is None:
                return False
            found, skipped = seen
            # The last one has the most: a rule that lacks its input there says nothing about the remark.
            if number == len(selections) - 1 and skipped:
                return False
            if any(ignore.covers(f.span.line) and os.path.realpath(f.span.path) == own for f in found):
                return False
    return True


def _partners(case: Case, home: FileReading) -> list[FileReading]:
    """The other files that describe the robots of one."""
    mine = {index for index, artifact in enumerate(case.artifacts) if artifact.path == home.path}
    paths = {
        case.artifacts[other].path
        for robot in case.robots
        if mine & set(robot.artifacts)
        for other in robot.artifacts
    }
    return [reading for reading in case.files if reading.path in paths and reading is not home]


def _selections(
    case: Case, home: FileReading, others: Sequence[FileReading]
) -> list[tuple[FileReading, ...]]:
    """A file by itself, with each other file, with all but one, with all; each in the order of the case."""
    chosen = [(), *((one,) for one in others)]
    if len(others) > 2:
        chosen += [tuple(other for other in others if other is not one) for one in others]
    if len(others) > 1:
        chosen.append(tuple(others))
    return [tuple(reading for reading in case.files if reading is home or reading in some) for some in chosen]
