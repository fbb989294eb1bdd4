"""Every finding of the audit in published robot files, each error and warning judged by hand: docs/survey.md.

    python benchmarks/survey.py            # write it
    python benchmarks/survey.py --check    # exit 1 where it is not what the audit finds

The files are real and stay where they are: `shared/corpus` beside the repository (or ACTSPEC_CORPUS), and the wheels
of isaaclab and mjlab in the environment that tests/frameworks makes. What is missing is said; without all three
nothing is written. survey.yaml says which files are audited together and why each finding is right. Exit code 1 also
where a finding has no reason there, or a reason no finding.
"""

from __future__ import annotations

import argparse
import os
import re
import sys
import tempfile
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from fnmatch import fnmatchcase
from pathlib import Path
from statistics import median
from typing import Any

import yaml

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from actspec.audit.engine import audit  # noqa: E402
from actspec.audit.outcome import Report  # noqa: E402
from actspec.audit.settings import Settings  # noqa: E402
from actspec.diagnostics import SEVERITIES, Severity, listed  # noqa: E402
from actspec.report import ReportOptions, render  # noqa: E402
from actspec.report.findings import grouped  # noqa: E402
from actspec.verify.environments import ISAACLAB, find_frameworks  # noqa: E402

SURVEY = ROOT / "docs" / "survey.md"
VERDICTS = Path(__file__).with_suffix(".yaml")

JUDGED = (Severity.ERROR, Severity.WARNING)
"""What needs a reason; remarks are counted."""

MOST_PLACES = 6
"""Files of one verdict that are named."""


@dataclass(frozen=True, slots=True)
class Collection:
    """Robot files that were published together.

    Attributes:
        name: First part of its files' paths in the survey.
        source: Where it comes from.
        version: Release or commit.
        folder: Where it lies here.
        files: Its files that describe robots, relative to `folder`.
    """

    name: str
    source: str
    version: str
    folder: Path
    files: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Verdict:
    """Why findings are right.

    Attributes:
        rule: Their code.
        files: Globs of the files that they are in.
        text: Part of their message; "" for any.
        why: The reason, in a line.
    """

    rule: str
    files: tuple[str, ...]
    text: str
    why: str

    def judges(self, found: Found) -> bool:
        """Whether a finding is one of these."""
        fits = any(fnmatchcase(found.file, glob) for glob in self.files)
        return self.rule == found.code and fits and self.text in found.message


@dataclass(slots=True)
class Found:
    """Equal findings of one file, from all the runs that have them.

    Attributes:
        file: The file.
        line: The first one's.
        code: The rule's.
        name: The rule's.
        severity: As reported.
        message: As reported.
        joints: All joints, in order.
        runs: Runs that have it.
    """

    file: str
    line: int
    code: str
    name: str
    severity: Severity
    message: str
    joints: tuple[str, ...]
    runs: list[str] = field(default_factory=list)


@dataclass(frozen=True, slots=True)
class Run:
    """One call of the audit.

    Attributes:
        name: The file's path, or the name in survey.yaml.
        report: What was found.
        lines: Lines of the default output.
    """

    name: str
    report: Report
    lines: int


def collections() -> tuple[list[Collection], list[str]]:
    """The collections that are here, and what is missing."""
    corpus = Path(os.environ.get("ACTSPEC_CORPUS", ROOT.parent / "shared" / "corpus"))
    prepared = find_frameworks()
    wheels = Path(os.devnull) if prepared is None else prepared.folder
    found, missing = [], []
    if (corpus / "README.md").is_file():
        text = (corpus / "README.md").read_text(encoding="utf-8")
        for line in re.findall(r"^\| *(\w+) *\| *(\S+) *\| *([^|]+?) *\|", text, re.MULTILINE):
            if line[0] != "folder":
                folder = corpus / line[0]
                found.append(
                    Collection(
                        line[0], f"github.com/{line[1]}", line[2], folder, _files(folder, ("*.xml", "*.urdf"))
                    )
                )
    else:
        missing.append("the corpus (shared/corpus beside the repository, or ACTSPEC_CORPUS)")
    version = ISAACLAB[-1]
    robots = (
        wheels
        / f"isaaclab-{version}"
        / "isaaclab"
        / "source"
        / "isaaclab_assets"
        / "isaaclab_assets"
        / "robots"
    )
    if robots.is_dir():
        found.append(
            Collection("isaaclab_assets", "wheel isaaclab", version, robots, _files(robots, ("*.py",)))
        )
    else:
        missing.append(f"the wheel isaaclab {version} (`actspec verify --setup` prepares it)")
    zoo = next(wheels.glob("venv/lib/python*/site-packages/mjlab/asset_zoo/robots"), None)
    if zoo is not None:
        release = next(zoo.parents[2].glob("mjlab-*.dist-info")).name.split("-")[1].removesuffix(".dist")
        found.append(
            Collection("mjlab", "wheel mjlab", release, zoo, _files(zoo, ("*.xml", "*_constants.py")))
        )
    else:
        missing.append("the wheel mjlab (`actspec verify --setup` prepares it)")
    return found, missing


def survey(found: Sequence[Collection]) -> tuple[str, list[str]]:
    """The text of docs/survey.md, and what is wrong with the verdicts."""
    told = yaml.safe_load(VERDICTS.read_text(encoding="utf-8"))
    with tempfile.TemporaryDirectory(prefix="actspec-survey-") as name:
        for collection in found:
            (Path(name) / collection.name).symlink_to(collection.folder, target_is_directory=True)
        before = Path.cwd()
        # Reports name files as they were named: relative to one folder, so that no path of this machine is in them.
        os.chdir(name)
        try:
            runs = [_run(file, [file]) for file in _all(found)]
            runs += [_run(name, files) for name, files in _together(told["together"], _all(found))]
        finally:
            os.chdir(before)
    verdicts = [_verdict(entry) for entry in told["verdicts"]]
    everything = _merged(runs)
    reasons, wrong = _judged(everything, verdicts)
    return _text(found, runs, everything, reasons, told), wrong


def _files(folder: Path, globs: Iterable[str]) -> tuple[str, ...]:
    paths = (path for glob in globs for path in folder.rglob(glob) if path.name != "__init__.py")
    return tuple(sorted(path.relative_to(folder).as_posix() for path in paths))


def _all(found: Iterable[Collection]) -> list[str]:
    return [f"{collection.name}/{file}" for collection in found for file in collection.files]


def _together(entries: dict[str, list[str]], files: Sequence[str]) -> Iterator[tuple[str, list[str]]]:
    for name, globs in entries.items():
        taken = [file for glob in globs for file in files if fnmatchcase(file, glob)]
        if len(taken) < 2:
            raise SystemExit(f"survey.yaml: together: {name}: {len(taken)} files")
        yield name, list(dict.fromkeys(taken))


def _verdict(entry: dict[str, Any]) -> Verdict:
    return Verdict(
        entry["rule"], tuple(entry["files"]), entry.get("text", ""), " ".join(entry["why"].split())
    )


def _run(name: str, files: Sequence[str]) -> Run:
    # Files that cannot be read are listed by themselves.
    report = audit(files, Settings(ignore=("AUD008",)))
    broken = [problem.message for problem in report.problems if problem.severity is Severity.ERROR]
    faults = [file.path for file in report.case.files if "a fault of actspec" in (file.reason or "")]
    if broken or faults:
        raise SystemExit(f"{name}: {'; '.join(broken + faults)}")
    return Run(name, report, render(report, "full", ReportOptions()).count("\n"))


def _merged(runs: Iterable[Run]) -> list[Found]:
    """Each finding once, however many runs have it."""
    found: dict[tuple[object, ...], Found] = {}
    for run in runs:
        for group in grouped(run.report.findings):
            item, finding = group.first, group.first.finding
            key = (finding.span.path, finding.code, item.severity, finding.message, finding.help)
            known = found.setdefault(
                key,
                Found(
                    finding.span.path,
                    finding.span.line,
                    finding.code,
                    item.name,
                    item.severity,
                    finding.message,
                    (),
                ),
            )
            known.joints = tuple(dict.fromkeys((*known.joints, *group.joints)))
            known.runs.append(run.name)
    return sorted(found.values(), key=lambda one: (one.code, one.file, one.line, one.message))


def _judged(found: Iterable[Found], verdicts: Sequence[Verdict]) -> tuple[dict[int, Verdict], list[str]]:
    """The first verdict on each finding, by the finding's identity; and what lacks its other half."""
    reasons: dict[int, Verdict] = {}
    wrong = []
    for one in found:
        if one.severity not in JUDGED:
            continue
        verdict = next((verdict for verdict in verdicts if verdict.judges(one)), None)
        if verdict is None:
            wrong.append(f"no reason: {one.file}:{one.line}: {one.code} [{one.severity.value}] {one.message}")
        else:
            reasons[id(one)] = verdict
    used = set(reasons.values())
    wrong += [
        f"no finding: {v.rule} in {', '.join(v.files)} {v.text}".rstrip() for v in verdicts if v not in used
    ]
    return reasons, wrong


def _text(
    collected: Sequence[Collection],
    runs: Sequence[Run],
    found: Sequence[Found],
    reasons: dict[int, Verdict],
    told: dict[str, Any],
) -> str:
    files = {file.path: file for run in runs for file in run.report.case.files}
    unread = [file for file in files.values() if not file.readable]
    errors = [one for one in found if one.severity is Severity.ERROR]
    lines = [
        "# What the audit finds in published files",
        "",
        "`actspec audit` over real robot descriptions of vendors and frameworks: each file alone, and the files of one",
        "robot together, as a user would name them. Every error and every warning was looked at in the files by hand;",
        "its reason stands here. An error that an expert would call false is a fault of actspec: please report it.",
        "",
        "Written by `python benchmarks/survey.py`; the reasons and the combinations are in benchmarks/survey.yaml. A",
        "test holds this page to the audit where the files are at hand.",
        "",
        "| collection | from | version | files |",
        "|---|---|---|---:|",
        *(f"| {c.name} | {c.source} | {c.version} | {len(c.files)} |" for c in collected),
        "",
        f"{len(runs)} runs: {sum(run.name in files for run in runs)} files alone, "
        f"{sum(run.name not in files for run in runs)} combinations. "
        + (
            f"Not readable: {listed([f'`{file.path}` ({file.reason})' for file in unread])}."
            if unread
            else "All files are read."
        ),
        "",
        "## How much there is to read",
        "",
        "Lines of the default output of one run; what is equal for several joints is one finding there, and one here.",
        "",
        "| | runs | median | nine of ten | most |",
        "|---|---:|---:|---:|---:|",
        _length("one file", [run for run in runs if run.name in files]),
        _length("files of one robot", [run for run in runs if run.name not in files]),
        "",
        "## By rule",
        "",
        "| rule | | errors | warnings | notes | files |",
        "|---|---|---:|---:|---:|---:|",
        *_by_rule(found),
        "",
        "## Errors",
        "",
    ]
    if errors:
        lines += ["| file | joints | rule | finding | why |", "|---|---|---|---|---|"]
        for one in errors:
            joints, message = _cell(listed(one.joints, 2)), _cell(one.message)
            why = _cell(reasons[id(one)].why) if id(one) in reasons else ""
            lines.append(f"| {one.file}:{one.line} | {joints} | {one.code} | {message} | {why} |")
    else:
        lines.append(
            "None: no file contradicts itself, its simulator or its neighbours so that nobody could mean it."
        )
    lines += [
        "",
        "## Warnings",
        "",
        "By reason; of findings that differ in figures or files alone, one is quoted.",
        "",
    ]
    by_reason: dict[Verdict, list[Found]] = {}
    for one in found:
        if one.severity is Severity.WARNING and id(one) in reasons:
            by_reason.setdefault(reasons[id(one)], []).append(one)
    for verdict, members in by_reason.items():
        lines += _warning(verdict, members)
    lines += [*_untouched(told["untouched"]), *_blind(told["blind"])]
    return "\n".join(lines).rstrip() + "\n"


def _untouched(told: Sequence[dict[str, Any]]) -> Iterator[str]:
    """Files on which nothing was tuned, with what a reader thought of their errors and warnings."""
    yield from (
        "## Files that were not used while working",
        "",
        "Errors and warnings as a reader sees them, judged by hand: worth acting on, true but nobody would act, false.",
        "What is false, or of no use, leads to a change of rules: the first table of a date is where nothing was",
        "changed, the second what was seen at first where something was.",
    )
    for block in told:
        _, useful, true, false = _sums(block["wheels"])
        count = useful + true + false
        yield from (
            "",
            f"### {block['date']}",
            "",
            f"{block['read']}, audited for the first time, a folder each: {useful} of {count} findings are worth "
            f"acting on ({100 * useful / count:.0f} %), {true} are true, {false} false.",
            *([" ".join(block["note"].split())] if "note" in block else []),
            "",
            *_wheels(block["wheels"], "found"),
            "",
            "Those for which something was changed, as they were on first sight:",
            "",
            *_wheels(block["changed"], "changed"),
        )


def _blind(told: Sequence[dict[str, Any]]) -> Iterator[str]:
    """Samples that were drawn before they were read, each with all that was found in it."""
    yield from (
        "",
        "## Blind samples",
        "",
        "Repositories that were chosen before a file of them was read, audited once, with every finding counted as it",
        "was on first sight. What is said twice counts once as worth acting on, and once as true. Repositories without",
        "a file to audit are not listed; three that had been read for other purposes are left out.",
        "",
        "| sample | repositories | files | worth acting on | true | false | |",
        "|---|---:|---:|---:|---:|---:|---:|",
    )
    for block in told:
        files, *worth = _sums(block["sources"])
        share = _share(worth[0], sum(worth))
        yield f"| {' | '.join(map(str, (block['name'], len(block['sources']), files, *worth, share)))} |"
    for block in told:
        files, useful, true, false = _sums(block["sources"])
        count = useful + true + false
        yield from (
            "",
            f"### {block['name']}, on the rules of {block['rules']}",
            "",
            f"{useful} of {count} findings in {files} files are worth acting on{_share(useful, count, ' ({})')}, "
            f"{true} are true, {false} false. {' '.join(block['note'].split())}",
            "",
            f"Changed after it: {' '.join(block['after'].split())}",
            "",
            *_wheels(block["sources"], "found"),
        )


def _share(useful: int, count: int, form: str = "{}") -> str:
    """How many of all are worth acting on; "" of none."""
    return form.format(f"{100 * useful / count:.0f} %") if count else ""


def _sums(sources: dict[str, Any]) -> list[int]:
    """Files, and findings worth acting on, true and false."""
    return [sum(row[i] for row in sources.values()) for i in range(4)]


def _wheels(sources: dict[str, Any], last: str) -> Iterator[str]:
    """A table of the sources of which something was found, with the sum of all, and below it the others' names."""
    rows = [(name, *row) for name, row in sources.items() if any(row[1:4])]
    silent = [f"{_cell(name)} ({row[0]})" for name, row in sources.items() if not any(row[1:4])]
    yield f"| name | files | worth acting on | true | false | {last} |"
    yield "|---|---:|---:|---:|---:|---|"
    yield from (f"| {' | '.join(_cell(str(cell)) for cell in row)} |" for row in rows)
    yield f"| all {len(sources)} | {' | '.join(map(str, _sums(sources)))} | |"
    if silent:
        yield from ("", f"Nothing was found in (files): {', '.join(silent)}.")


def _warning(verdict: Verdict, members: Sequence[Found]) -> Iterator[str]:
    first = members[0]
    yield f"### {first.code} {first.name}"
    yield ""
    yield verdict.why
    yield ""
    named = f"{listed(first.joints, 2)}: " if first.joints else ""
    yield f"> {_cell(named + first.message)}"
    yield ""
    places: dict[str, dict[str, None]] = {}
    for one in members:
        places.setdefault(one.file, {}).update(dict.fromkeys(one.joints))
    for file, joints in list(places.items())[:MOST_PLACES]:
        yield f"- `{file}`" + (f": {_cell(listed(tuple(joints), 4))}" if joints else "")
    if len(places) > MOST_PLACES:
        yield f"- and {len(places) - MOST_PLACES} more files"
    yield ""


def _length(what: str, runs: Sequence[Run]) -> str:
    lengths = sorted(run.lines for run in runs)
    longest = max(runs, key=lambda run: run.lines)
    most = lengths[int(0.9 * (len(lengths) - 1))]
    return f"| {what} | {len(runs)} | {median(lengths):g} | {most} | {longest.lines} (`{longest.name}`) |"


def _by_rule(found: Sequence[Found]) -> Iterator[str]:
    counts = Counter((one.code, one.severity) for one in found)
    for code, name in dict.fromkeys((one.code, one.name) for one in found):
        numbers = " | ".join(str(counts[code, severity] or "") for severity in reversed(SEVERITIES))
        page = f"../actspec/audit/rules/{code.lower()}.md"
        yield f"| [{code}]({page}) | {name} | {numbers} | {len({o.file for o in found if o.code == code})} |"
    totals = " | ".join(
        str(sum(one.severity is severity for one in found)) for severity in reversed(SEVERITIES)
    )
    yield f"| | all | {totals} | {len({one.file for one in found})} |"


def _cell(text: str) -> str:
    return re.sub(r"([|*_<>`\\])", r"\\\1", " ".join(text.split()))


def main() -> int:
    """Write or check."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument(
        "--check", action="store_true", help="write nothing; exit 1 where the page would change"
    )
    arguments = parser.parse_args()
    found, missing = collections()
    for what in missing:
        print(f"skipped: {what} is not here")
    if missing:
        return 0
    text, wrong = survey(found)
    for line in wrong:
        print(line)
    if arguments.check:
        if SURVEY.read_text(encoding="utf-8") != text:
            print("docs/survey.md is not what the audit finds: python benchmarks/survey.py")
            return 1
    else:
        SURVEY.write_text(text, encoding="utf-8")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
