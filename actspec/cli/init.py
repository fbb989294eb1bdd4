"""`actspec init`: a first spec, as a commented example; `--from` imports one."""

from __future__ import annotations

import argparse

from actspec.cli.spec_file import check_free, commands, write_spec
from actspec.diagnostics import EXIT_CLEAN


def run(arguments: argparse.Namespace) -> int:
    """Write the spec and say what to do next."""
    path = str(arguments.path)
    if arguments.source is not None:
        from actspec.cli.import_ import import_files
        from actspec.readings.versions import Versions

        return import_files([str(arguments.source)], path, None, Versions(), bool(arguments.force))
    from actspec.draft import starting_spec

    check_free(path, (), bool(arguments.force))
    write_spec(path, starting_spec())
    print(f"wrote {path}: an example with every part of the language explained")
    print("next: name your robot's file in `robot.model`, put its numbers in, then")
    for line in commands(path, "validate", "compile"):
        print(line)
    print("or begin with what files say: actspec import robot.xml [robot_cfg.py ...] -o NEW.yaml")
    return EXIT_CLEAN
