"""`actspec schema`: print a JSON Schema."""

from __future__ import annotations

import argparse
import sys

from actspec.diagnostics import EXIT_CLEAN


def run(arguments: argparse.Namespace) -> int:
    """Print the schema of a spec, a results file or a network manifest."""
    from actspec.spec.schema import schema_text

    sys.stdout.write(schema_text(arguments.name))
    return EXIT_CLEAN
