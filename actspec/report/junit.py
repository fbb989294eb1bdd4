"""JUnit XML: one suite a file, one test case a finding.

A finding below `--fail-on` passes, with its text as output; a file without findings is one case that passes; a name
that stands for no file is an error; a rule that was selected and has no input is skipped.
"""

from __future__ import annotations

from xml.etree import ElementTree as tree

from actspec.audit.outcome import Report
from actspec.diagnostics import SEVERITIES, Diagnostic, Severity, Span, one_line
from actspec.report import ReportOptions
from actspec.report.findings import FindingGroup, grouped


def render(report: Report, options: ReportOptions) -> str:
    """The report as JUnit XML."""
    root = tree.Element("testsuites", name="actspec audit")
    groups = grouped(report.at_or_above(options.least))
    paths = [file.path for file in report.case.files]
    # Findings may stand in included files, which nobody named.
    paths += [group.first.finding.span.path for group in groups]
    problems = [item for item in report.diagnostics() if item.severity is Severity.ERROR]
    for path in dict.fromkeys(paths):
        own = [group for group in groups if group.first.finding.span.path == path]
        faults = [item for item in problems if item.span is not None and item.span.path == path]
        suite = tree.SubElement(root, "testsuite", name=one_line(path))
        for group in own:
            _finding(suite, group, options.fail_on)
        for item in faults:
            _fault(suite, item)
        if not own and not faults:
            tree.SubElement(suite, "testcase", classname=one_line(path), name="no findings")
    named = set(paths)
    rest = [item for item in problems if item.span is None or item.span.path not in named]
    # Who did not ask for a rule need not read of it in every run.
    lacking = report.skipped if options.chosen else ()
    if lacking or rest:
        suite = tree.SubElement(root, "testsuite", name="rules")
        for item in rest:
            _fault(suite, item)
        for skipped in lacking:
            case = tree.SubElement(suite, "testcase", classname="rules", name=skipped.code)
            tree.SubElement(case, "skipped", message=one_line(skipped.reason))
    for suite in root:
        _count(suite)
    _count(root)
    tree.indent(root)
    return '<?xml version="1.0" encoding="utf-8"?>\n' + tree.tostring(root, encoding="unicode") + "\n"


def _finding(suite: tree.Element, group: FindingGroup, fail_on: Severity | None) -> None:
    item, finding = group.first, group.first.finding
    text = group.headline(most=8)
    name = (
        f"{finding.code} {item.name}: {group.headline(most=1).partition(': ')[0] if group.joints else 'file'}"
    )
    case = _case(suite, finding.span, name)
    body = f"{finding.span}: {one_line(text)}" + (f"\nhelp: {one_line(finding.help)}" if finding.help else "")
    if fail_on is not None and SEVERITIES.index(item.severity) >= SEVERITIES.index(fail_on):
        failure = tree.SubElement(case, "failure", type=finding.code, message=one_line(text))
        failure.text = body
    else:
        tree.SubElement(case, "system-out").text = f"{item.severity.value}: {body}"


def _fault(suite: tree.Element, item: Diagnostic) -> None:
    case = _case(suite, item.span, f"{item.code} {item.where}".strip())
    error = tree.SubElement(case, "error", type=item.code, message=one_line(item.message))
    error.text = str(item)


def _case(suite: tree.Element, span: Span | None, name: str) -> tree.Element:
    case = tree.SubElement(suite, "testcase", classname=suite.get("name", ""), name=one_line(name))
    if span is not None:
        case.set("file", one_line(span.path))
        if span.line:
            case.set("line", str(span.line))
    return case


def _count(element: tree.Element) -> None:
    for key, tag in (
        ("tests", "testcase"),
        ("failures", "failure"),
        ("errors", "error"),
        ("skipped", "skipped"),
    ):
        element.set(key, str(sum(1 for _ in element.iter(tag))))
