"""`actspec audit` once its files are being read: settings, rules, report, fixes."""

from __future__ import annotations

import argparse
import os
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from actspec.audit.engine import audit, own_exclude
from actspec.audit.finding import Confidence
from actspec.audit.outcome import Report, Reported
from actspec.audit.rules import all_rules
from actspec.audit.selection import ALL
from actspec.audit.settings import NEVER, Settings, check_selectors, load_settings, named_versions
from actspec.cli.options import overridden
from actspec.diagnostics import (
    EXIT_CLEAN,
    EXIT_FAILED,
    EXIT_FINDINGS,
    AuditError,
    Collector,
    Diagnostic,
    Severity,
    Span,
    many,
    one_line,
)
from actspec.files import FAULTS, name_in_file, noting, path_of_name, why
from actspec.owned import check_kept, head_of, put_file
from actspec.placing import is_stream
from actspec.readings.artifact import FileKind
from actspec.readings.named import PendingFiles
from actspec.report import ReportOptions, least_shown, render, renderer
from actspec.report.findings import for_people
from actspec.report.terminal import Progress, print_diagnostics, style_of
from actspec.report.text import counted, remarks

if TYPE_CHECKING:
    from actspec.audit.baseline import Entry
    from actspec.audit.fix import FixedFile

TEXT = ("full", "concise")
"""Formats for people in front of a terminal."""
UNMARKED = (*TEXT, "github")
"""Formats that do not tell who wrote them: a file of them begins with a line that does."""
WITH_LEDGER = (*TEXT, "json", "markdown", "html")
"""Formats that can show the ledger."""


def report_on(
    arguments: argparse.Namespace, pending: PendingFiles, again: Callable[[Mapping[str, bytes]], PendingFiles]
) -> int:
    """Audit files and print the report.

    Args:
        arguments: Of the command.
        pending: Its files, which are being read.
        again: Begins to read them once more, as they would be with other bytes by real path.

    Returns: The exit code.
    """
    output_format: str = arguments.output_format
    settings = _settings(arguments)
    renderer(output_format)
    report = _audited(arguments, settings, pending)
    # Not taken apart at the end, which takes long for thousands of findings; see `actspec.cli.main._KEPT`.
    arguments.report = report
    _check_spec(report, arguments.spec)
    fixed: tuple[FixedFile, ...] = ()
    if arguments.fix or arguments.unsafe_fixes or arguments.diff:
        afterwards, fixed = _fixed(report, arguments, settings, again)
        if arguments.diff:
            return _show_fixes(report, fixed, settings)
        arguments.report = report = afterwards
    if arguments.write_baseline is not None:
        return _write_baseline(report, arguments.write_baseline, settings, arguments.force)
    options = ReportOptions(
        colour=arguments.output is None and style_of(sys.stdout).colour,
        ledger=arguments.ledger,
        statistics=arguments.statistics,
        chosen=ALL not in settings.select,
        fail_on=settings.fail_on,
        least=least_shown(output_format, settings.min_severity, settings.fail_on),
    )
    text = render(report, output_format, options)
    if arguments.output is not None and output_format in UNMARKED and not is_stream(arguments.output):
        text = f"{head_of('audit')}\n{text}"
    _write(fixed, arguments.output, text, arguments.force)
    if output_format not in ("json", "sarif"):
        print_diagnostics(remarks(report, options.least))
    if arguments.output is None:
        sys.stdout.write(text)
    if _failed(report, settings) or _is_unread(report, arguments.spec):
        return EXIT_FAILED
    # Whoever uploads SARIF has its findings judged there.
    return EXIT_FINDINGS if output_format != "sarif" and report.fails(settings.fail_on) else EXIT_CLEAN


def _audited(arguments: argparse.Namespace, settings: Settings, pending: PendingFiles) -> Report:
    with Progress("reading") as progress:
        return audit(pending, settings, spec=arguments.spec, progress=progress.step)


def _fixed(
    report: Report,
    arguments: argparse.Namespace,
    settings: Settings,
    again: Callable[[Mapping[str, bytes]], PendingFiles],
) -> tuple[Report, tuple[FixedFile, ...]]:
    """Fix until nothing more can be of what the report showed; nothing is written.

    Returns: The report afterwards and the files; none where that report is not whole, and then the one before.
    """
    from actspec.audit.fix import MOST_PASSES, FixedFile, apply_fixes

    if _failed(report, settings):
        print(f"nothing is fixed: {_UNREAD}", file=sys.stderr)
        return report, ()
    first = report
    # What comes to light by a fix is reported afterwards, and nobody has agreed to it yet.
    shown = {_about(item) for item in first.findings if item.finding.fix is not None}
    made: dict[str, FixedFile] = {}
    before: set[tuple[str, bytes]] = set()
    for _ in range(MOST_PASSES):
        known = [item for item in report.findings if _about(item) in shown]
        fixes = apply_fixes(known, report.case.files, arguments.unsafe_fixes)
        print_diagnostics(fixes.refused)
        if not fixes.files:
            if not made:
                print(_nothing_to_fix(report, arguments.unsafe_fixes), file=sys.stderr)
            break
        back = next((file for file in fixes.files if (file.path, file.new) in before), None)
        if back is not None:
            message = "its fixes undo each other: none is applied, and the file is as it was"
            print_diagnostics([Diagnostic("AUD011", Severity.WARNING, message, "", Span(back.path))])
            made.pop(back.path, None)
        else:
            before.update((file.path, file.old) for file in fixes.files)
            for file in fixes.files:
                old = made.get(file.path, replace(file, titles=()))
                titles = tuple(dict.fromkeys((*old.titles, *file.titles)))
                made[file.path] = FixedFile(file.path, old.old, file.new, titles)
        with again({os.path.realpath(file.path): file.new for file in made.values()}) as pending:
            report = _audited(arguments, settings, pending)
        if back is not None:
            break
    if _failed(report, settings):
        print(f"nothing is fixed: afterwards {_UNREAD}", file=sys.stderr)
        return first, ()
    return report, tuple(made.values())


_UNREAD = "a name stands for no file, or a rule broke off"


def _failed(report: Report, settings: Settings) -> bool:
    """Whether a run with this report ends with exit code 2."""
    return bool(report.misnamed) or not (report.complete or settings.fail_on is None)


def _about(item: Reported) -> tuple[str, str, str]:
    """What a finding and that of the next pass, where its place and its figures are others, have in common."""
    return item.finding.code, item.finding.span.path, item.finding.joint


def _show_fixes(report: Report, fixed: Sequence[FixedFile], settings: Settings) -> int:
    """What would be written, as a unified diff."""
    from actspec.output import diff_lines

    print_diagnostics(remarks(report, Severity.WARNING))
    for file in fixed:
        for line in diff_lines(file.old, file.new, file.path, file.path):
            sys.stdout.write(line)
    if _failed(report, settings):
        return EXIT_FAILED
    return EXIT_FINDINGS if fixed else EXIT_CLEAN


def _nothing_to_fix(report: Report, unsafe: bool) -> str:
    """That nothing was fixed, and how much `--unsafe-fixes` would."""
    more = 0 if unsafe else sum(item.finding.fix is not None for item in report.findings)
    return "nothing to fix" + (f" without --unsafe-fixes, {many(more, 'finding')} with it" if more else "")


def _settings(arguments: argparse.Namespace) -> Settings:
    """Settings of the file, with the options of the command line over them."""
    rules = all_rules()
    out = Collector()
    text_only = [("--statistics", arguments.statistics, TEXT), ("--ledger", arguments.ledger, WITH_LEDGER)]
    for option, given, formats in text_only:
        if given and arguments.output_format not in formats:
            out.error("AUD010", f"needs --output-format {' or '.join(formats)}", where=option)
    if arguments.write_baseline is not None and (arguments.fix or arguments.unsafe_fixes or arguments.diff):
        out.error("AUD010", "fix first, then write what is left", where="--write-baseline")
    if arguments.write_baseline is not None and arguments.output is not None:
        out.error("AUD010", "and --output exclude each other", where="--write-baseline")
    if arguments.no_baseline and arguments.baseline is not None:
        out.error("AUD010", "and --baseline exclude each other", where="--no-baseline")
    select = tuple(code for group in arguments.select or () for code in group)
    ignore = tuple(code for group in arguments.ignore or () for code in group)
    for option, given, codes in (
        ("--select", arguments.select, select),
        ("--ignore", arguments.ignore, ignore),
    ):
        check_selectors(codes, rules, option, None, out)
        if given and not codes:
            out.error("AUD010", "names no rule", where=option)
    versions = named_versions(arguments.target, out)
    try:
        settings = load_settings(rules, arguments.config)
    except AuditError as err:
        for item in err.diagnostics:
            out.add(item)
        settings = Settings()
    out.raise_if_failed(AuditError)
    # What is selected on the command line is selected in place of the file's choice, what is ignored beside it.
    if select:
        settings = replace(settings, select=select)
    settings = replace(
        settings, ignore=(*settings.ignore, *ignore), versions=overridden(settings.versions, versions)
    )
    if arguments.min_confidence is not None:
        settings = replace(settings, min_confidence=Confidence(arguments.min_confidence))
    if arguments.as_named:
        settings = replace(settings, as_named=True)
    if arguments.min_severity is not None:
        settings = replace(settings, min_severity=Severity(arguments.min_severity))
    fail_on = NEVER if arguments.exit_zero else arguments.fail_on
    if fail_on is not None:
        settings = replace(settings, fail_on=None if fail_on == NEVER else Severity(fail_on))
    if arguments.no_baseline or arguments.write_baseline is not None:
        settings = replace(settings, baseline=None)
    elif arguments.baseline is not None:
        settings = replace(settings, baseline=arguments.baseline)
    return settings


def _check_spec(report: Report, spec: str | None) -> None:
    if spec is None:
        return
    file = next((file for file in report.case.files if file.path == spec), None)
    # None: --skip-other has passed over it.
    if file is None or (file.readable and file.kind is not FileKind.SPEC):
        kind = file.kind.value if file is not None and file.kind is not None else "something else"
        message = f"this is not an actspec spec but {kind}"
        raise AuditError.of("AUD010", message, Span(spec), where="--spec")


def _is_unread(report: Report, spec: str | None) -> bool:
    """Whether nothing was held to the spec, as it cannot be read: a finding like any file's, but not all was done."""
    return spec is not None and any(file.path == spec and not file.readable for file in report.case.files)


def _write_baseline(report: Report, path: str, settings: Settings, force: bool) -> int:
    from actspec.audit.baseline import entry_about, write_baseline
    from actspec.audit.drives import driven

    print_diagnostics(remarks(report, Severity.WARNING))
    if not report.complete:
        print(f"{one_line(path)}: not written: {_UNREAD}", file=sys.stderr)
        return EXIT_FAILED
    said = report.diagnostics()
    kept, drives, told = _before(report, path, settings)
    drives = {**drives, **driven(report.case, os.path.dirname(path))}
    write_baseline(report.findings, path, said, kept=kept, driven=drives, force=force)
    about = sum(entry_about(item, "") is not None for item in said)
    more = f" and {many(about, 'warning')} about files" if about else ""
    groups = for_people(report.findings)
    shown = f": shown as {counted(groups)}" if len(groups) < len(report.findings) else ""
    print(f"{one_line(path)}: {many(len(report.findings), 'finding')}{more} written{shown}", file=sys.stderr)
    for line in told:
        print(f"{one_line(path)}: {line}", file=sys.stderr)
    return EXIT_CLEAN


def _before(
    report: Report, path: str, settings: Settings
) -> tuple[Mapping[Entry, int], Mapping[str, frozenset[str]], list[str]]:
    """What stays of a baseline that is written again, and what becomes of the rest, in lines for people."""
    from actspec.audit.baseline import apply_baseline, read_baseline, relative_path
    from actspec.audit.reach import reach_of

    rules = {rule.code: rule for rule in all_rules()}
    try:
        with noting():  # what it says is written again
            before = read_baseline(path, {old: rule.code for rule in rules.values() for old in rule.aliases})
    except AuditError:
        # None yet, or none that anybody can read.
        return {}, {}, []
    folder = os.path.dirname(path)
    reach = reach_of(before, report.case, rules, report.ran, folder, own_exclude(settings))
    left, _, stale = apply_baseline(report.findings, reach.other_rules, folder)
    # Of those that are found again, the new entry stands for the old one.
    _, _, gone = apply_baseline(left, reach.within, folder)
    gone = Counter({entry: count for entry, count in gone.items() if entry.code in rules})
    told = []
    for what, entries, which in (
        ("kept", reach.other_files, " outside of this run"),
        ("kept", stale, ", by rules that did not run or that compare with files outside of this run"),
        ("left out", gone, ", no longer found"),
        ("left out", reach.gone, ", no longer there"),
    ):
        if entries:
            files = many(len({entry.file for entry in entries}), "file")
            told.append(f"{what}: {many(sum(entries.values()), 'finding')} of {files}{which}")
    audited = {name_in_file(relative_path(file.path, folder)) for file in report.case.files}
    there = {
        file: joints
        for file, joints in before.driven.items()
        if file not in audited | reach.hollow and os.path.exists(os.path.join(folder, path_of_name(file)))
    }
    return reach.other_files + stale, there, told


def _write(fixed: Sequence[FixedFile], path: str | None, text: str, force: bool) -> None:
    """Write fixed files and the report, all or none, and say what was fixed.

    Raises: ActspecError: a file cannot be written, or would be lost.
    """
    data = text.encode("utf-8", "backslashreplace")
    if fixed:
        from actspec.audit.fix import write_fixes

        report = None if path is None else (path, data)
        if report is not None:
            check_kept([report], force=force)
        write_fixes(fixed, report)
        for file in fixed:
            print(one_line(f"{file.path}: {'; '.join(file.titles)}"), file=sys.stderr)
    elif path is not None:
        try:
            put_file(path, data, force=force)
        except FAULTS as err:
            raise AuditError.of("AUD006", f"the report cannot be written: {why(err)}", Span(path)) from err
