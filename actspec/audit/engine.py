"""The audit: files to findings.

A rule that breaks off is a fault of actspec and is reported as one; the others still run.
"""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache

from actspec.audit.baseline import Baseline, Entry, apply_baseline, entry_about, read_baseline, relative_path
from actspec.audit.build import case_of
from actspec.audit.case import Case
from actspec.audit.causes import by_cause
from actspec.audit.drives import Lost, lost_drives, vanished
from actspec.audit.exclude import Exclude, glob_matches, unfit
from actspec.audit.finding import Confidence, Finding, Skipped
from actspec.audit.fix import without_doubtful
from actspec.audit.ignores import (
    REMARKS,
    Looked,
    certainly_unused,
    ignores_of,
    set_aside,
    unknown,
    unused,
    without_reason,
)
from actspec.audit.outcome import CONFIDENCES, LOST_FILE, Means, Report, Reported, Suppressed, codes_run
from actspec.audit.reach import Reach, reach_of
from actspec.audit.read import pending_files
from actspec.audit.rule import Rule
from actspec.audit.rules import all_rules
from actspec.audit.selection import ALL, DIAGNOSTICS, NOT_JUDGED, is_diagnostic, is_selected, strength
from actspec.audit.settings import Settings, beyond_known, not_read
from actspec.diagnostics import AuditError, Diagnostic, Severity, Span, listed
from actspec.readings.artifact import FileReading
from actspec.readings.including import without_fragments
from actspec.readings.named import PendingFiles


def audit(
    files: Sequence[str] | PendingFiles,
    settings: Settings,
    *,
    spec: str | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Report:
    """Read files and run the rules over them. Nothing that is read is executed.

    Args:
        files: As the user names them, or already being read.
        settings: Which rules, and what becomes of their findings.
        spec: The spec that all files with its joints are held to, whatever they call the robot; one of `files`.
        progress: Called with how many files are read, of how many.

    Raises: AuditError: the baseline cannot be read.
    """
    if not isinstance(files, PendingFiles):
        exclude = Exclude(
            tuple((glob, settings.folder) for glob in settings.exclude), settings.force_exclude, spec
        )
        with pending_files(files, exclude=exclude) as pending:
            return audit(pending, settings, spec=spec, progress=progress)
    readings = without_fragments(files.finish(progress))
    if settings.as_named:
        readings = tuple(reading.as_named() for reading in readings)
    case = case_of(readings, settings.versions, settings.options, spec)
    case = replace(case, passed_over=files.passed_over)
    globs = files.exclude.globs if isinstance(files.exclude, Exclude) else ()
    ignored = [(glob, settings.folder) for glob, _ in settings.per_file_ignores]
    said = (
        *unfit(globs, files.named, files.met, settings.exclude_at),
        *unfit(ignored, files.named, files.met, settings.ignores_at, "per-file-ignores", _fits_file),
        *beyond_known(settings.versions),
        *not_read(settings),
    )
    report = judge(case, settings, spec=spec, whole=files.in_folders, said=said)
    return replace(report, excluded=files.excluded, not_read=files.not_read)


def judge(
    case: Case,
    settings: Settings,
    rules: Sequence[type[Rule]] | None = None,
    *,
    spec: str | None = None,
    whole: Collection[str] = (),
    said: Iterable[Diagnostic] = (),
) -> Report:
    """Run the rules over what was read.

    Args:
        case: What was read.
        settings: Which rules, and what becomes of their findings.
        rules: All rules; default: those of the registry.
        spec: As in `audit`.
        whole: Files that were found in a folder, so that the others of their robot are in the case.
        said: What is wrong with the settings beside these files.

    Raises: AuditError: the baseline cannot be read.
    """
    everything = all_rules() if rules is None else tuple(rules)
    asked = tuple(rule for rule in everything if _is_asked_for(rule, settings))
    former = {old: rule.code for rule in everything for old in rule.aliases}
    baseline, missing = _baseline(settings, former)
    found, skipped, problems = _run(asked, case)
    problems += missing
    real_path = cache(os.path.realpath)  # it asks the system for each folder on the way
    by_code = {rule.code: rule for rule in everything}
    said_of = cache(lambda code: _severity_said(by_code[code], settings))
    resolved = by_cause(
        _resolve(found, by_code, said_of, real_path, case),
        counts=lambda item: not _unsure(item.confidence, settings),
        fixed=lambda code: said_of(code) is not None,
        whose=case.whose,
    )
    ignores = ignores_of(case.files, real_path)
    remarks = [ignore for group in ignores.values() for ignore in group]
    called = {rule.code: (rule.code, *rule.names()) for rule in everything}
    after = set_aside(resolved, ignores, real_path, called)
    ran = codes_run(asked, skipped, problems)
    names = {name: rule for rule in everything if rule.code in ran for name in called[rule.code]}
    useless = certainly_unused(after.unused, names, case, whole, _looking(case, spec))
    about = (*without_reason(remarks), *unused(useless), *unknown(remarks, everything))
    problems += dict.fromkeys((*said, *about))
    kept, suppressed = _in_order(without_doubtful(after.kept)), list(after.suppressed)
    # Those of rules that are not asked for explain none of the others.
    ignored, _, _ = _run(_ignored(everything, settings), case)
    suppressed += (
        Suppressed(item, Means.IGNORE) for item in _resolve(ignored, by_code, said_of, real_path, case)
    )
    kept = _split(kept, suppressed, Means.IGNORE, lambda item: _is_of_ignored(item.finding.names, settings))
    kept = _split(
        kept,
        suppressed,
        Means.SETTING,
        lambda item: _ignored_by_setting(
            item.finding.span.path, (*called[item.finding.code], *item.finding.names), settings
        ),
    )
    if baseline is not None:
        folder = os.path.dirname(settings.baseline or "")
        kept, known, stale = apply_baseline(kept, baseline.entries, folder)
        suppressed += known
        lost = tuple(lost_drives(case, baseline.driven, folder))
        problems += dict.fromkeys(one.told(settings.baseline or "") for one in lost)
        problems += _stale(
            stale,
            reach_of(baseline, case, by_code, ran, folder, own_exclude(settings)),
            settings.baseline or "",
            lost,
            vanished(case, baseline.driven, folder),
        )
    kept = _split(kept, suppressed, Means.CONFIDENCE, lambda item: _unsure(item.confidence, settings))
    report = Report(case, asked, kept, tuple(suppressed), skipped, tuple(problems))
    quiet = frozenset(item for item in report.diagnostics() if not _is_wanted(item, settings))
    if baseline is not None:
        folder = os.path.dirname(settings.baseline or "")
        quiet |= {item for item in report.diagnostics() if entry_about(item, folder) in baseline.entries}
    return replace(report, problems=tuple(item for item in problems if item not in quiet), quiet=quiet)


def own_exclude(settings: Settings) -> Exclude:
    """What the settings leave out of every run."""
    return Exclude(tuple((glob, settings.folder) for glob in settings.exclude), True)


def _is_asked_for(rule: type[Rule], settings: Settings) -> bool:
    """Whether a rule is to run. Files that rules cannot look at are reported to whoever asks for any rule."""
    select = (*settings.select, ALL) if rule.code.startswith(NOT_JUDGED) else settings.select
    return is_selected(rule.code, rule.names(), select, settings.ignore)


def _ignored(rules: Iterable[type[Rule]], settings: Settings) -> Iterator[type[Rule]]:
    """Rules that `ignore` alone keeps from running: how much it sets aside is counted, as of the other means."""
    all_of = replace(settings, ignore=())
    yield from (
        rule
        for rule in rules
        if settings.ignore and _is_asked_for(rule, all_of) and not _is_asked_for(rule, settings)
    )


def _is_of_ignored(names: Sequence[str], settings: Settings) -> bool:
    """Whether a finding reports a reader's remark that is ignored by its own code."""
    return bool(names) and not is_selected(names[0], names[1:], (ALL,), settings.ignore)


def _baseline(
    settings: Settings, former: Mapping[str, str]
) -> tuple[Baseline | None, tuple[Diagnostic, ...]]:
    """The baseline; one that is not there hides nothing, and the run fails after what it finds is told.

    Raises: AuditError: it cannot be read.
    """
    if settings.baseline is None:
        return None, ()
    try:
        return read_baseline(settings.baseline, former), ()
    except AuditError as err:
        if os.path.lexists(settings.baseline):
            raise
        return None, err.diagnostics


def _run(
    rules: Iterable[type[Rule]], case: Case
) -> tuple[list[Finding], tuple[Skipped, ...], list[Diagnostic]]:
    """Findings of all rules, those that had no input, and faults of rules."""
    found: list[Finding] = []
    skipped: dict[Skipped, None] = {}
    problems: list[Diagnostic] = []
    for rule in rules:
        items, fault = _check(rule, case)
        for item in items:
            if isinstance(item, Finding):
                found.append(item)
            else:
                skipped[item] = None
        if fault is not None:
            problems.append(fault)
    return found, tuple(skipped), problems


def _check(rule: type[Rule], case: Case) -> tuple[list[Finding | Skipped], Diagnostic | None]:
    """What one rule says, and what became of it if it broke off."""
    found: list[Finding | Skipped] = []
    try:
        for item in rule().check(case):
            if item.code != rule.code:
                raise ValueError(f"speaks for {item.code}")
            found.append(item)
    except Exception as err:
        return found, _fault(rule, err)
    return found, None


def _looking(case: Case, spec: str | None) -> Looked:
    """Lets a rule look at some of the files of a case."""
    cases = {frozenset(reading.path for reading in case.files): case}

    def look(
        rule: type[Rule], selection: Sequence[FileReading]
    ) -> tuple[Sequence[Finding], Sequence[Skipped]] | None:
        paths = frozenset(reading.path for reading in selection)
        if paths not in cases:
            held = spec if spec in paths else None
            cases[paths] = case_of(selection, case.versions, case.options, held)
        found, skipped, problems = _run((rule,), cases[paths])
        return None if problems else (found, skipped)

    return look


def _fault(rule: type[Rule], err: Exception) -> Diagnostic:
    """A rule broke off: what somebody who mends it needs, in one line."""
    frame = err.__traceback__
    while frame is not None and frame.tb_next is not None:
        frame = frame.tb_next
    place = ""
    if frame is not None:
        place = f" ({os.path.basename(frame.tb_frame.f_code.co_filename)}, line {frame.tb_lineno})"
    text = f"{type(err).__name__}: {err}" if str(err) else type(err).__name__
    return Diagnostic(
        "AUD009",
        Severity.ERROR,
        f"the rule broke off, which is a fault of actspec: {text}{place}; the other rules have run",
        rule.code,
        None,
        f"please report it with the file; until then `--ignore {rule.code}`",
    )


def _resolve(
    found: Iterable[Finding],
    by_code: Mapping[str, type[Rule]],
    said: Callable[[str], Severity | None],
    real_path: Callable[[str], str],
    case: Case,
) -> tuple[Reported, ...]:
    """Findings with name, severity and confidence; the same one of two files that share a part counts once.

    What nobody runs, and what a rule is too seldom right of, is a note in a folder.
    """
    unique: dict[tuple[object, ...], Reported] = {}
    for finding in found:
        rule = by_code[finding.code]
        severity = said(finding.code) or finding.severity or rule.severity
        span = finding.span
        noted = (
            severity is not Severity.INFO
            and said(finding.code) is None
            and _is_noted(case, rule, finding, severity)
        )
        if noted:
            severity = Severity.INFO
        key = (
            finding.code,
            real_path(span.path),
            span.line,
            span.column,
            finding.joint,
            finding.message,
        )
        confidence = finding.confidence or rule.confidence
        unique.setdefault(key, Reported(finding, rule.name, severity, confidence, of_folder=noted))
    return _in_order(unique.values())


def _is_noted(case: Case, rule: type[Rule], finding: Finding, severity: Severity) -> bool:
    """Whether a finding in a folder is a note: by itself, its rule, or of what nobody runs, or against that alone.

    An error that a file has by itself stays one: of its rule's findings it is the sure one.
    """
    others = [span for span in finding.related if span.path != finding.span.path]
    by_rule = rule.noted_in_folders and (severity is not Severity.ERROR or bool(others))
    by_rule = by_rule and not (rule.counts_where_run and case.is_run(finding.span))
    if (by_rule or finding.noted_in_folders) and case.is_met_at(finding.span):
        return True
    if rule.written_over & case.written(finding.span, finding.joint):
        return True
    return case.is_idle(finding.span) or (bool(others) and all(map(case.is_idle, others)))


def _severity_said(rule: type[Rule], settings: Settings) -> Severity | None:
    """What the settings say of a rule, by the closest selector."""
    closest = max(
        ((strength(selector, rule.code, *rule.names()), selector) for selector in settings.severity),
        default=(0, ""),
    )
    return settings.severity[closest[1]] if closest[0] else None


def _in_order(found: Iterable[Reported]) -> tuple[Reported, ...]:
    def key(item: Reported) -> tuple[str, int, int, str, str]:
        # Not the span itself, which makes two tuples for each comparison.
        finding, span = item.finding, item.finding.span
        return span.path, span.line, span.column, finding.code, finding.joint

    return tuple(sorted(found, key=key))


def _split(
    found: Iterable[Reported], suppressed: list[Suppressed], means: Means, aside: Callable[[Reported], bool]
) -> tuple[Reported, ...]:
    """Findings that stay; the others are added to `suppressed`."""
    kept = []
    for item in found:
        if aside(item):
            suppressed.append(Suppressed(item, means))
        else:
            kept.append(item)
    return tuple(kept)


def _is_wanted(item: Diagnostic, settings: Settings) -> bool:
    """Whether the settings ask for a diagnostic. Of those about files, none is left out by what is selected."""
    if item.severity is Severity.ERROR:
        return True
    names = (item.code, REMARKS.get(item.code) or DIAGNOSTICS.get(item.code, item.code))
    select = settings.select if item.code in REMARKS else (ALL,)
    asked = is_selected(item.code, names[1:], select, settings.ignore)
    return asked and not (item.span and _ignored_by_setting(item.span.path, names, settings))


def _ignored_by_setting(file: str, names: Sequence[str], settings: Settings) -> bool:
    if not settings.per_file_ignores:
        return False
    path = relative_path(file, settings.folder)
    return any(
        strength(selector, *names)
        for glob, selectors in settings.per_file_ignores
        if glob_matches(glob, path)
        for selector in selectors
    )


def _fits_file(glob: str, folder: str, path: str) -> bool:
    return os.path.isfile(path) and glob_matches(glob, relative_path(path, folder))


def _unsure(confidence: Confidence, settings: Settings) -> bool:
    return CONFIDENCES.index(confidence) < CONFIDENCES.index(settings.min_confidence)


def _stale(
    stale: Counter[Entry], reach: Reach, path: str, lost: Sequence[Lost], away: Collection[tuple[str, str]]
) -> Iterator[Diagnostic]:
    """Entries of the baseline no longer found, of files and rules that were looked at, or of deleted and emptied files.

    What is no longer found of a joint that has lost its actuator is not mended; of one that is not there it is said.
    """
    undriven = {(one.file, joint) for one in lost for joint in one.joints}
    help = f"write the baseline again with --write-baseline {path}"
    for file in sorted({*reach.hollow, *(entry.file for entry in reach.gone)}):
        codes = sorted({entry.code for entry in reach.gone if entry.file == file})
        has = f"findings of {file}" if codes else f"the drives of {file}"
        state = "in which nothing is left to audit" if file in reach.hollow else "which is not there"
        message = f"the baseline has {has}, {state}" + (f": {listed(codes)}" if codes else "")
        back = "put back what it had; if it is meant, " if file in reach.hollow else ""
        yield Diagnostic(LOST_FILE, Severity.WARNING, message, "", Span(path), back + help)
    gone = [
        entry
        for entry in stale
        if entry in reach.within
        and not is_diagnostic(entry.code)
        and (entry.file, entry.joint) not in undriven
    ]
    for code, file in sorted({(entry.code, entry.file) for entry in gone}):
        joints = sorted(item.joint for item in gone if (item.code, item.file) == (code, file) and item.joint)
        where = f" ({listed(joints)})" if joints else ""
        absent = [joint for joint in dict.fromkeys(joints) if (file, joint) in away]
        if absent:
            where += f": {listed(absent)} {'are no joints' if absent[1:] else 'is no joint'} of it any more"
        yield Diagnostic(
            "AUD007",
            Severity.WARNING,
            f"{code} is in the baseline and is no longer found in {file}{where}",
            "",
            Span(path),
            help,
        )
