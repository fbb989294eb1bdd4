"""`actspec schema`: print a JSON Schema."""

from __future__ import annotations

import argparse
import sys

from actspec.diagnostics import EXIT_CLEAN
from actspec.resources import data_path


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
