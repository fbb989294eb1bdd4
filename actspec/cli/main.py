"""Entry point: arguments to a command, a command to an exit code."""

from __future__ import annotations

import argparse
import atexit
import gc
import os
import sys
from collections.abc import Callable, Sequence
from importlib import import_module

import actspec
from actspec.diagnostics import EXIT_FAILED

WRITTEN = ("compile", "actuators", "validate", "manifest", "randomization")
"""Machine output with a schema: `schemas/actspec-NAME-v1.schema.json`."""


def parser() -> argparse.ArgumentParser:
    """The command line's grammar."""
    top = argparse.ArgumentParser(
        prog="actspec",
        description="Compile one reviewed actuator spec to every robot simulator.",
        epilog="Exit codes: 0 clean; 1 stale files, or approximations under --strict; 2 could not run.",
    )
    top.add_argument("--version", action="version", version=f"actspec {actspec.__version__}")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", required=True)

    compile_ = commands.add_parser("compile", help="compile a spec to its targets", description=_COMPILE)
    compile_.add_argument("spec", nargs="+", metavar="SPEC", help="actuator spec (YAML)")
    compile_.add_argument("-o", "--output", metavar="DIR", help="write below DIR (default: build/ROBOT)")
    compile_.add_argument(
        "-t",
        "--target",
        action="append",
        default=[],
        metavar="TARGET",
        help="only this target of the spec, or KIND==VERSION such as mujoco==3.11; may be repeated",
    )
    compile_.add_argument("--check", action="store_true", help="write nothing; exit 1 if a file is stale")
    compile_.add_argument(
        "--diff", action="store_true", help="write nothing; show what would change, exit 1 if so"
    )
    compile_.add_argument(
        "--strict",
        action="store_true",
        help="write nothing and exit 1 on an approximation that the spec does not accept",
    )
    compile_.add_argument(
        "--canonical", action="store_true", help="write MuJoCo's own form, not the author's text"
    )
    compile_.add_argument("--force", action="store_true", help="replace files that actspec did not write")
    _format(compile_)

    validate = commands.add_parser("validate", help="check specs, without a simulator")
    validate.add_argument("spec", nargs="+", metavar="SPEC", help="actuator spec (YAML)")
    _format(validate)

    show = commands.add_parser("show", help="show every value with unit, origin, source and formula")
    show.add_argument("spec", metavar="SPEC", help="actuator spec (YAML)")
    show.add_argument(
        "joint", nargs="?", metavar="JOINT", help="joint or pattern; without it, one line a joint"
    )
    _format(show)

    schema = commands.add_parser("schema", help="print a JSON Schema, for editors and for machine output")
    schema.add_argument(
        "name",
        nargs="?",
        default="spec",
        choices=("spec", "results", "network", *WRITTEN),
        help="of a file that people write (spec, results, network), or that actspec does: the JSON of compile, show "
        "(actuators) and validate, and files beside compiled ones",
    )

    init = commands.add_parser("init", help="write a starting spec")
    init.add_argument("path", nargs="?", default="actspec.yaml", metavar="SPEC", help="file to write")
    init.add_argument("--from", dest="source", metavar="FILE", help="draft it from an MJCF or URDF")
    init.add_argument("--force", action="store_true", help="replace a file that is there")
    return top


def _format(command: argparse.ArgumentParser) -> None:
    command.add_argument("--output-format", choices=("text", "json"), default="text", help="default: text")


_COMPILE = (
    "Compile specs to the configuration of each target. Files go to build/ROBOT/TARGET/ and are replaced only "
    "when they differ."
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command.

    Args:
        argv: Arguments; default: those of the process.

    Returns: 0 clean, 1 findings, 2 could not run.
    """
    arguments = parser().parse_args(argv)
    # Nothing is drawn here: without this MuJoCo loads a windowing library, which may even fail to start.
    os.environ["MUJOCO_GL"] = "disable"
    # A run makes hundreds of classes and drops none: to look for garbage among them, and once more when
    # the process ends, would take a seventh of the time.
    collecting = gc.isenabled()
    gc.disable()
    atexit.register(gc.freeze)
    try:
        code = _run(arguments)
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        # The reader has gone (`| head`): nothing to say, and nobody to say it to.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return EXIT_FAILED
    except KeyboardInterrupt:
        return 130
    finally:
        if collecting:
            gc.enable()


def _run(arguments: argparse.Namespace) -> int:
    from actspec.cli import report
    from actspec.diagnostics import ActspecError

    command: str = arguments.command
    try:
        # Each command imports what it needs, and nothing that another one needs.
        run: Callable[[argparse.Namespace], int] = import_module(f"actspec.cli.{command}").run
        return run(arguments)
    except ActspecError as err:
        report.print_failure(err.diagnostics, getattr(arguments, "output_format", "text"), command)
        return EXIT_FAILED


if __name__ == "__main__":
    raise SystemExit(main())
