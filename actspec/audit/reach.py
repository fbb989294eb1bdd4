"""What of a baseline a run can tell anything about: not what lies in files that it did not look at, or needs them."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from actspec.audit.baseline import Baseline, Entry, relative_path
from actspec.audit.case import MODELS, Case
from actspec.audit.exclude import Exclude
from actspec.audit.rule import Rule
from actspec.audit.selection import NOT_JUDGED, is_diagnostic
from actspec.files import name_in_file, path_of_name
from actspec.readings.artifact import FileKind, FileReading


@dataclass(frozen=True, slots=True)
class Reach:
    """The entries of a baseline with their counts, each in one of these.

    Attributes:
        within: Of files and rules that were looked at: what is not found has gone.
        other_files: Of files that are there and were not audited.
        other_rules: Of audited files that could not be read, or by rules that did not run, or that compare with files
            that were not audited.
        gone: Of files that are not there, or in which nothing is left to audit.
        hollow: Those that are there; also of models of which the baseline has the drives alone.
    """

    within: Counter[Entry]
    other_files: Counter[Entry]
    other_rules: Counter[Entry]
    gone: Counter[Entry]
    hollow: frozenset[str]

    @property
    def kept(self) -> Counter[Entry]:
        """Those of which the run knows nothing."""
        return self.other_files + self.other_rules


def reach_of(
    baseline: Baseline,
    case: Case,
    rules: Mapping[str, type[Rule]],
    ran: Collection[str],
    folder: str,
    exclude: Exclude,
) -> Reach:
    """Divide the entries of a baseline.

    Args:
        baseline: Of which all entries are divided.
        case: What was read.
        rules: All rules by code.
        ran: Codes of those that ran and had input.
        folder: The baseline's.
        exclude: What no run looks at: a run without it is of the whole.
    """
    audited: dict[str, FileReading] = {}
    for reading in case.files:
        for path in (reading.path, *(part.path for part in reading.files)):
            audited.setdefault(name_in_file(relative_path(path, folder)), reading)
    entries = baseline.entries
    paths = {file: os.path.join(folder, path_of_name(file)) for file in {entry.file for entry in entries}}
    hollow = _hollow(baseline, case, audited)
    passed_over = {name_in_file(relative_path(path, folder)) for path in case.passed_over} - audited.keys()
    others = {file for file, path in paths.items() if file not in audited and os.path.exists(path)}
    partial = any(not exclude(paths[file], True) for file in others - passed_over)
    if not partial:
        # What is passed over may have been a part of a file that is not in this run.
        hollow |= passed_over & _judged(baseline)
        others -= hollow
    reach = Reach(Counter(), Counter(), Counter(), Counter(), hollow)
    for entry, count in entries.items():
        home = None if entry.file in hollow else audited.get(entry.file)
        if home is None:
            (reach.other_files if entry.file in others else reach.gone)[entry] = count
            continue
        rule = rules.get(entry.code)
        looked = entry.code in ran and (home.readable or entry.code.startswith(NOT_JUDGED))
        # What is said of a configuration, and of some of a model, is said beside other files of the robot.
        compared = partial and (home.kind not in MODELS or (rule is not None and rule.paired))
        known = rule is None or (looked and not compared)
        (reach.within if known else reach.other_rules)[entry] = count
    return reach


def _hollow(baseline: Baseline, case: Case, audited: Mapping[str, FileReading]) -> frozenset[str]:
    """Models that were read and have no joint any more; those of other files may come from one outside of the run."""
    moving = {entry.file for entry in baseline.entries if entry.joint}
    having = {case.artifacts[row.artifact].path for row in case.rows}
    return frozenset(
        file
        for file, home in audited.items()
        if home.readable
        and home.path not in having
        # A part of an MJCF has none where it is read alone.
        and (file in baseline.driven or (home.kind is FileKind.URDF and file in moving))
    )


def _judged(baseline: Baseline) -> frozenset[str]:
    """Files of which a baseline has more than that they cannot be read: that is told where somebody names them."""
    return frozenset(
        entry.file
        for entry in baseline.entries
        if not (entry.code.startswith(NOT_JUDGED) or is_diagnostic(entry.code))
    ).union(baseline.driven)
