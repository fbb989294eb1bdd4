"""What commands that learn from logs share: their arguments, reading all of them, and the exit code."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from actspec import api
from actspec.cli.options import quantity_needed
from actspec.diagnostics import EXIT_CLEAN, EXIT_FINDINGS, Collector, Diagnostic, Severity, Span
from actspec.units import Kind

if TYPE_CHECKING:
    from actspec.logs import Log


def add_logs(command: argparse.ArgumentParser) -> None:
    """Add spec and logs."""
    command.add_argument("spec", metavar="SPEC", help="actuator spec (YAML)")
    command.add_argument(
        "log", nargs="+", metavar="LOG", help="CSV, NPZ or Parquet; its sidecar lies beside it"
    )


def read_logs(paths: Sequence[str], code: str, more: Sequence[str] = ()) -> list[Log]:
    """Logs, all their faults at once.

    Args:
        paths: Each a recording of its own.
        code: Of what is said where two of them are the same.
        more: Logs that may be among the others.

    Returns: Those of `paths`, then those of `more`; none of either twice.

    Raises: LogError: one cannot be read, or is there twice.
    """
    from actspec.logs import LogError, load_log

    logs, out = [], Collector()
    for group in (paths, more):
        seen: dict[str, str] = {}
        for path in group:
            try:
                log = load_log(path)
            except LogError as err:
                for item in err.diagnostics:
                    out.add(item)
                continue
            logs.append(log)
            if group.count(path) > 1:
                out.error(code, "is named twice", span=Span(path), help="name each log once")
            elif (other := seen.setdefault(log.sha256, path)) != path:
                out.error(code, f"the same bytes as {other}", span=Span(path), help="name each log once")
    out.raise_if_failed(LogError)
    return logs


def read_all(arguments: argparse.Namespace) -> tuple[list[Any], Any, Any]:
    """Logs, spec and robot; all faults of the logs at once."""
    logs = read_logs(arguments.log, "LRN014", getattr(arguments, "policy", ()))
    spec = api.load(arguments.spec)
    robot = api.load_robot(spec)
    return logs, api.resolve(spec, robot), robot


def warned(findings: Iterable[Diagnostic]) -> int:
    """Exit code: 1 with a warning."""
    warned = any(item.severity is Severity.WARNING for item in findings)
    return EXIT_FINDINGS if warned else EXIT_CLEAN


def seconds_of(text: str | None, option: str) -> float | None:
    """An option's time [s]."""
    return None if text is None else quantity_needed(text, Kind.TIME, option, "LRN015")
