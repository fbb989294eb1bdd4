"""What of a baseline a run can tell anything about: not what lies in files that it did not look at, or needs them."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass

from actspec.audit.baseline import Entry, relative_path
from actspec.audit.case import MODELS, Case
from actspec.audit.exclude import Exclude
from actspec.audit.rule import Rule
from actspec.audit.selection import NOT_JUDGED
from actspec.files import name_in_file, path_of_name
from actspec.readings.artifact import FileReading


@dataclass(frozen=True, slots=True)
class Reach:
    """The entries of a baseline with their counts, each in one of these.

    Attributes:
        within: Of files and rules that were looked at: what is not found has gone.
        other_files: Of files that are there and were not audited.
        other_rules: Of audited files that could not be read, or by rules that did not run, or that compare with files
            that were not audited.
        gone: Of files that are not there.
    """

    within: Counter[Entry]
    other_files: Counter[Entry]
    other_rules: Counter[Entry]
    gone: Counter[Entry]

    @property
    def kept(self) -> Counter[Entry]:
        """Those of which the run knows nothing."""
        return self.other_files + self.other_rules


def reach_of(
    entries: Counter[Entry],
    case: Case,
    rules: Mapping[str, type[Rule]],
    ran: Collection[str],
    folder: str,
    exclude: Exclude,
) -> Reach:
    """Divide the entries of a baseline.

    Args:
        entries: All of them, with their counts.
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
    paths = {file: os.path.join(folder, path_of_name(file)) for file in {entry.file for entry in entries}}
    others = {file for file, path in paths.items() if file not in audited and os.path.lexists(path)}
    partial = any(not exclude(paths[file], True) for file in others)
    reach = Reach(Counter(), Counter(), Counter(), Counter())
    for entry, count in entries.items():
        home = audited.get(entry.file)
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
