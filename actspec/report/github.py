"""Workflow commands of GitHub Actions: annotations on the lines of a pull request.

Equal findings of many joints are one annotation, and the worst come first: a step shows ten of a kind at most.
"""

from __future__ import annotations

from actspec.audit.baseline import relative_path
from actspec.audit.outcome import Report
from actspec.diagnostics import Severity, Span, one_line
from actspec.report import ReportOptions
from actspec.report.findings import grouped, in_files
from actspec.report.text import remarks, worst_first

LEVELS = {Severity.ERROR: "error", Severity.WARNING: "warning", Severity.INFO: "notice"}


def render(report: Report, options: ReportOptions) -> str:
    """One workflow command a finding, and one for each thing that readers and rules have to say."""
    lines = []
    for group in worst_first(in_files(grouped(report.at_or_above(options.least)))):
        item = group.first
        text = one_line(group.headline(most=8))
        if item.finding.help:
            text += f"\nhelp: {one_line(item.finding.help)}"
        lines.append(command(item.severity, f"{item.finding.code} {item.name}", item.finding.span, text))
    for problem in remarks(report, options.least):
        text = one_line(f"{problem.where}: {problem.message}" if problem.where else problem.message)
        lines.append(command(problem.severity, problem.code, problem.span, text))
    return "".join(f"{line}\n" for line in lines)


def command(severity: Severity, title: str, span: Span | None, text: str) -> str:
    """One workflow command.

    Args:
        severity: What the annotation is shown as.
        title: Its heading.
        span: The line that it is on; None: no line.
        text: What it says.
    """
    properties = [f"title={_property(title)}"]
    if span is not None:
        properties.append(f"file={_property(relative_path(span.path, '.'))}")
        if span.line:
            properties.append(f"line={span.line}")
            if span.column:
                properties.append(f"col={span.column}")
    return f"::{LEVELS[severity]} {','.join(properties)}::{_data(text)}"


def _data(text: str) -> str:
    """Text for a command's message. Source: the runner's toolkit, `escapeData`."""
    return text.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(text: str) -> str:
    """Text for a command's property. Source: the runner's toolkit, `escapeProperty`."""
    # Of control characters only line breaks have an escape there; a path may have others.
    return one_line(_data(text)).replace(":", "%3A").replace(",", "%2C")
