"""`actspec validate`: check specs without a simulator; the robot is not opened."""

from __future__ import annotations

import argparse
import os

from actspec.cli.report import print_diagnostics, print_json, record
from actspec.diagnostics import EXIT_CLEAN, EXIT_FAILED, ActspecError, Diagnostic


def run(arguments: argparse.Namespace) -> int:
    """Check every spec; all of them, whatever is wrong with the first."""
    from actspec.spec.load import load_spec

    failed = False
    records = []
    for path in arguments.spec:
        diagnostics: tuple[Diagnostic, ...] = ()
        summary = ""
        try:
            spec = load_spec(path)
            diagnostics = spec.diagnostics
            model = spec.model
            groups = len(model.actuators)
            summary = f"{path}: valid: {model.robot.name}, {groups} group{'s' * (groups != 1)}"
            summary += _skipped(model.robot.model, os.path.dirname(path))
        except ActspecError as err:
            failed = True
            diagnostics = err.diagnostics
        if arguments.output_format == "json":
            records.append(
                {"path": path, "valid": bool(summary), "diagnostics": [record(d) for d in diagnostics]}
            )
            continue
        print_diagnostics(diagnostics)
        if summary:
            print(summary)
    if arguments.output_format == "json":
        print_json({"format": "actspec-validate/1", "files": records})
    return EXIT_FAILED if failed else EXIT_CLEAN


def _skipped(model: str, folder: str) -> str:
    """What was not checked: patterns need the robot's joints, which validate does not read."""
    if model == "none":
        return ""
    if model.startswith("package://"):
        return " (patterns not checked against the robot: `actspec compile --check` does)"
    if not os.path.isfile(os.path.join(folder, model)):
        return f" (its model {model!r} is not there: patterns not checked)"
    return ""
