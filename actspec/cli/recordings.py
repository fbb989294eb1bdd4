"""What commands that learn from logs share: their arguments, reading all of them, and the exit code."""

from __future__ import annotations

import argparse
from typing import Any

from actspec import api
from actspec.diagnostics import EXIT_CLEAN, EXIT_FINDINGS, Collector, Severity, Span
from actspec.units import Kind, UnitError, parse_quantity


def add_logs(command: argparse.ArgumentParser) -> None:
    """Add spec and logs."""
    command.add_argument("spec", metavar="SPEC", help="actuator spec (YAML)")
    command.add_argument(
        "log", nargs="+", metavar="LOG", help="CSV, NPZ or Parquet; its sidecar lies beside it"
    )


def read_all(arguments: argparse.Namespace) -> tuple[list[Any], Any, Any]:
    """Logs, spec and robot; all faults of the logs at once."""
    from actspec.logs import LogError, load_log

    logs, out = [], Collector()
    for path in (*arguments.log, *getattr(arguments, "policy", ())):
        try:
            logs.append(load_log(path))
        except LogError as err:
            for item in err.diagnostics:
                out.add(item)
    seen: dict[str, str] = {}
    for log in logs[: len(arguments.log)]:
        if (other := seen.setdefault(log.sha256, log.path)) != log.path or [x.path for x in logs].count(
            log.path
        ) > 1:
            out.error("LRN014", f"the same bytes as {other}", span=Span(log.path), help="name each log once")
    out.raise_if_failed(LogError)
    spec = api.load(arguments.spec)
    robot = api.load_robot(spec)
    return logs, api.resolve(spec, robot), robot


def warned(out: Collector) -> int:
    """Exit code: 1 with a warning."""
    warned = any(item.severity is Severity.WARNING for item in out)
    return EXIT_FINDINGS if warned else EXIT_CLEAN


def seconds_of(text: str | None, option: str) -> float | None:
    """An option's time [s]."""
    from actspec.logs import LogError

    if text is None:
        return None
    try:
        value = parse_quantity(text, Kind.TIME).value
    except UnitError as err:
        raise LogError.of("LRN015", err.message, where=option, help=err.help) from err
    if not value > 0:
        raise LogError.of("LRN015", f"must be above 0, got {text}", where=option)
    return value
