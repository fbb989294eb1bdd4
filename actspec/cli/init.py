"""`actspec init`: a first spec, as a commented example; `--from` imports one."""

from __future__ import annotations

import argparse

from actspec.cli.import_ import commands, import_files
from actspec.cli.options import add_force, describe
from actspec.diagnostics import EXIT_CLEAN, one_line
from actspec.output import write_text
from actspec.owned import check_free
from actspec.report.terminal import print_lines


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments and what its help says."""
    describe(
        command,
        "Write a spec to begin with: a commented example with every part of the language, or with --from what a robot "
        "file says.",
        "actspec init robots/my_robot.yaml",
        "0 written; 2 could not",
    )
    command.add_argument("path", nargs="?", default="actspec.yaml", metavar="SPEC", help="file to write")
    command.add_argument("--from", dest="source", metavar="FILE", help="as `import FILE -o SPEC`")
    add_force(command)


def run(arguments: argparse.Namespace) -> int:
    """Write the spec and say what to do next."""
    path = str(arguments.path)
    if arguments.source is not None:
        from actspec.readings.versions import Versions

        return import_files([str(arguments.source)], path, None, Versions(), bool(arguments.force))
    from actspec.draft import starting_spec

    check_free(path, (), bool(arguments.force), again=True)
    write_text(path, starting_spec(), force=arguments.force)
    print(f"wrote {one_line(path)}: an example with every part of the language explained")
    print("next: name your robot's file in `robot.model`, put its numbers in, then")
    print_lines(commands(path, "validate", "compile"))
    print("or begin with what files say: actspec import robot.xml [robot_cfg.py ...] -o NEW.yaml")
    return EXIT_CLEAN
