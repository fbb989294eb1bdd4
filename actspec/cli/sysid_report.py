"""`actspec sysid report`: a results file beside its logs, as one page."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec import api
from actspec.cli.options import add_force, describe
from actspec.diagnostics import (
    EXIT_CLEAN,
    EXIT_FINDINGS,
    Collector,
    RobotError,
    Severity,
    Span,
    listed,
    one_line,
)
from actspec.files import leads_into
from actspec.logs import Log, LogError, load_log
from actspec.report.terminal import Progress, print_diagnostics
from actspec.spec.results import FitFile, Results
from actspec.sysid.identified import METHODS

if TYPE_CHECKING:
    from actspec.spec.document import Document
    from actspec.spec.validate import Spec


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the options and what the help says."""
    describe(
        command,
        "Write one page about a results file: every figure with its interval, the logs beside what the fitted joints "
        "do, what the logs do not tell and which experiment would. Logs and spec are those that the file names, below "
        "the current folder or the file's own; others are named by options.",
        "actspec sysid report results/hip.yaml -o hip.html",
        "0 written; 1 written, and a log or the spec is missing; 2 nothing was written",
    )
    command.add_argument("results", metavar="RESULTS", help="results file (YAML) of `sysid fit`")
    command.add_argument("-o", "--output", required=True, metavar="HTML", help="page to write")
    command.add_argument("--spec", metavar="SPEC", help="actuator spec; default: the one that the file names")
    command.add_argument(
        "--log",
        action="append",
        default=[],
        metavar="LOG",
        help="a log of the fit, where it lies now; may be repeated",
    )
    add_force(command)


def run(arguments: argparse.Namespace) -> int:
    """Write the page."""
    from actspec.output import write_text
    from actspec.owned import check_free
    from actspec.report.sysid_page import Identified, render
    from actspec.spec.document import load_document
    from actspec.spec.results import validate_results
    from actspec.sysid.replay import replay

    check_free(arguments.output, [arguments.results, *arguments.log], arguments.force)
    document = load_document(arguments.results)
    results = validate_results(document)
    out = Collector()
    logs = _logs(results, document, arguments.log, out)
    out.raise_if_failed(LogError)
    spec = _spec(results, document, arguments.spec, out)
    actuators, replays = None, {}
    if spec is not None:
        try:
            robot = api.load_robot(spec)
            actuators = api.resolve(spec, robot)
            lacking = [name for name in results.joints if actuators.joint(name) is None]
            if lacking:
                message = f"the spec has no joint {listed(lacking)}"
                out.warning("SYS064", message, span=Span(spec.document.path))
            with Progress("simulating") as progress:
                replays = replay(actuators, robot, logs, results, out, progress.step)
        except RobotError as err:
            # Figures and intervals need no model.
            for item in err.diagnostics:
                out.warning(item.code, item.message, where=item.where, span=item.span, help=item.help)
    shown = Identified(
        document.path, results, document.text_sha256, spec, actuators, replays, tuple(logs), out.sorted()
    )
    write_text(arguments.output, render(shown), force=arguments.force)
    print_diagnostics(shown.findings)
    print(f"wrote {one_line(arguments.output)}")
    missing = any(item.severity is not Severity.INFO for item in shown.findings)
    return EXIT_FINDINGS if missing else EXIT_CLEAN


@dataclass(frozen=True, slots=True)
class _Found:
    """Where a file that the results name may lie.

    Attributes:
        paths: Files that are there, inside of the folders that may be looked at.
        outside: Whether it is named outside of these.
    """

    paths: tuple[str, ...]
    outside: bool


def _found(named: str, results: str) -> _Found:
    """A file as the results name it: from the current folder, or from theirs, and inside of one of the two.

    Somebody else's results shall not choose which of one's own files are read.
    """
    roots = [os.path.realpath(os.curdir), os.path.realpath(os.path.dirname(results) or os.curdir)]
    paths, outside = [], True
    for base in (os.curdir, os.path.dirname(results) or os.curdir):
        path = os.path.normpath(os.path.join(base, named))
        inside = leads_into(path, roots)
        outside = outside and not inside
        if inside and os.path.lexists(path) and path not in paths:
            paths.append(path)
    return _Found(tuple(paths), outside)


def _logs(results: Results, document: Document, given: Sequence[str], out: Collector) -> list[Log]:
    """The logs of the results that are there, in their order; a warning for each that is not."""
    loaded = [load_log(path) for path in given]
    if results.method not in METHODS:
        return loaded  # another tool's figures may be held against any log
    found: list[Log] = []
    unused = list(loaded)
    missing: list[tuple[int, FitFile]] = []
    for index, entry in enumerate(results.data):
        mine = next((log for log in loaded if log.sha256 == entry.sha256), None)
        if mine is None:
            missing.append((index, entry))
            continue
        found.append(mine)
        unused = [log for log in unused if log is not mine]
    for log in unused:
        expected = "; ".join(f"{entry.sha256} ({one_line(entry.path)})" for _, entry in missing[:8])
        message = f"is no log of these results: its sha256 is {log.sha256}, " + (
            f"theirs {'is' if len(missing) == 1 else 'are'} {expected}"
            if missing
            else "and all of theirs are there"
            if results.data
            else "they name none"
        )
        out.error("SYS061", message, span=Span(log.path), help="give the log that was fitted, unchanged")
    for index, entry in missing:
        there = _named_log(entry, index, document, out)
        if there is not None:
            found.append(there)
    order = {entry.sha256: place for place, entry in reversed(list(enumerate(results.data)))}
    return sorted(found, key=lambda log: order[log.sha256])


def _named_log(entry: FitFile, index: int, document: Document, out: Collector) -> Log | None:
    place = document.spans.value(("data", index))
    where = _found(entry.path, document.path)
    tried = []
    for path in where.paths:
        log = load_log(path)
        if log.sha256 == entry.sha256:
            return log
        tried.append(log)
    if tried:
        message = (
            f"has changed since the fit: its sha256 is {tried[0].sha256}, that of the fit {entry.sha256}"
        )
        help = "give the log that was fitted by --log, or fit again"
        out.error("SYS061", message, span=Span(tried[0].path), help=help)
        return None
    name = one_line(entry.path)
    reason = "lies outside of this folder and the results file's" if where.outside else "is not there"
    out.warning(
        "SYS060",
        f"the log '{name}' {reason}: the report does without it",
        span=place,
        help="give it by --log",
    )
    return None


def _spec(results: Results, document: Document, given: str | None, out: Collector) -> Spec | None:
    """The spec, if there is one."""
    from actspec.spec.variants import named, split

    path = given
    if path is None and results.spec is not None:
        file, variant = split(results.spec.path)
        where = _found(file, document.path)
        if where.paths:
            path = named(where.paths[0], variant)
        else:
            reason = "lies outside of this folder and the results file's" if where.outside else "is not there"
            message = f"the spec '{one_line(results.spec.path)}' {reason}: no joint is simulated"
            place = document.spans.value(("spec",))
            out.warning("SYS062", message, span=place, help="give it by --spec")
    elif path is None:
        message = "the file names no spec: no joint is simulated"
        say = out.warning if results.method in METHODS else out.info
        say("SYS062", message, span=Span(document.path), help="give it by --spec")
    if path is None:
        return None
    spec = api.load(path)
    if spec.model.robot.name != results.robot:
        message = f"the spec is of the robot '{spec.model.robot.name}', the results are of '{results.robot}'"
        raise LogError.of("SYS021", message, Span(spec.document.path))
    if results.spec is not None and spec.document.text_sha256 != results.spec.sha256:
        message = "the spec has changed since the fit: figures that the fit held may be others"
        out.info("SYS063", message, span=Span(spec.document.path))
    return spec
