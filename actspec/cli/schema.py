"""`actspec schema`: print a JSON Schema."""

from __future__ import annotations

import argparse
import sys

from actspec.cli.options import describe
from actspec.diagnostics import EXIT_CLEAN
from actspec.resources import data_path

WRITTEN = (
    "compile",
    "actuators",
    "validate",
    "manifest",
    "randomization",
    "report",
    "baseline",
    "rules",
    "diff",
    "lock",
    "verify",
    "compare",
    "diagnosis",
    "ablation",
    "overview",
    "sysid",
    "net-data",
    "net-train",
    "net-evaluate",
    "net-inspect",
    "net-convert",
    "delta-train",
    "delta-validate",
)
"""Machine output with a schema: `schemas/actspec-NAME-v1.schema.json`."""


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments and what its help says."""
    describe(
        command,
        "Print a JSON Schema: of files that people write (spec, results, network, delta, log for its sidecar), or of "
        "what actspec writes: the JSON of compile, show (actuators), validate, verify, compare, diagnose (diagnosis), "
        "ablate (ablation), report (overview), sysid, net, delta, audit (report), rule (rules) and diff, and files.",
        "actspec schema > actspec.schema.json",
        "0 printed; 2 there is no such schema",
    )
    command.add_argument(
        "name",
        nargs="?",
        default="spec",
        choices=("spec", "results", "network", "delta", "log", *WRITTEN),
        help="default: spec",
    )


def run(arguments: argparse.Namespace) -> int:
    """Print the schema of a file that people write, or of one that actspec does."""
    from actspec.spec.schema import FILES, schema_text

    name: str = arguments.name
    if name in FILES:
        text = schema_text(name)
    else:
        text = data_path("schemas", f"actspec-{name}-v1.schema.json").read_text(encoding="utf-8")
    sys.stdout.write(text)
    return EXIT_CLEAN
