"""Entry point: arguments to a command, a command to an exit code."""

from __future__ import annotations

import argparse
import gc
import os
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from itertools import takewhile
from keyword import iskeyword
from typing import Any

import actspec
from actspec.cli.options import Command, Lines
from actspec.cli.streams import StreamError, printing
from actspec.diagnostics import EXIT_CLEAN, EXIT_FAILED

COMMANDS = {
    "compile": "compile a spec to its targets",
    "validate": "check specs, without a simulator",
    "show": "show every value with unit, origin, source and formula",
    "verify": "show by numbers that every target agrees",
    "compare": "show what each part of an actuator's model changes",
    "diagnose": "judge a spec by logs, and say what to do",
    "ablate": "write variants of a spec, to train beside each other",
    "audit": "audit robot files, with or without a spec",
    "report": "write one page: verdict, pictures, what to do",
    "rule": "explain a rule of the audit",
    "diff": "show what changed in effective dynamics",
    "sysid": "identify actuators from logs",
    "net": "train actuator networks on logs",
    "delta": "train corrections of a policy's actions on logs",
    "lock": "record effective dynamics, and show what changes",
    "import": "write a spec from files that you have",
    "init": "write a starting spec",
    "schema": "print a JSON Schema, for editors and for machine output",
}
"""Command to what it does. The module of its name adds its arguments (`add_arguments`) and runs it (`run`)."""


def parser(only: str | None = None) -> argparse.ArgumentParser:
    """The command line's grammar.

    Args:
        only: The command whose options are needed, so that the modules of the others are not loaded; None: all.
    """
    top = Command(
        prog="actspec",
        formatter_class=Lines,
        description="Compile one reviewed actuator spec to every robot simulator, and audit the files you have.",
        epilog="example: actspec audit robot.xml robot_cfg.py\n"
        "exit codes: 0 clean; 1 findings, stale files, or approximations under --strict; 2 could not run\n"
        "`actspec COMMAND --help` explains a command.",
    )
    top.add_argument("--version", action="version", version=f"actspec {actspec.__version__}")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", required=True, parser_class=Command)
    for name, words in COMMANDS.items():
        command = commands.add_parser(name, help=words, formatter_class=Lines)
        if only in (None, name):
            _module(name).add_arguments(command)
    return top


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command.

    Args:
        argv: Arguments; default: those of the process.

    Returns: 0 clean, 1 findings, 2 could not run.

    Raises: SystemExit: of the parser, after help or for wrong usage.
    """
    with printing():
        return _main(_parsed(sys.argv[1:] if argv is None else argv))


_KEPT: list[argparse.Namespace] = []
"""What a command leaves in its arguments, which is not taken apart before the process ends."""


def run_process() -> int:
    """Run the process's command; for `actspec.__main__`, which ends the process.

    Returns: The exit code.
    """
    with printing():
        try:
            try:
                arguments = _parsed(sys.argv[1:])
                _KEPT.append(arguments)
                code = _main(arguments)
            except SystemExit as stop:
                code = stop.code if isinstance(stop.code, int) else EXIT_CLEAN
            sys.stdout.flush()
            sys.stderr.flush()
        except StreamError as err:
            return _unprinted(err)
        return code


def run_lost(reason: str) -> int:
    """Say that the command's process was ended; for `actspec.__main__`.

    Returns: The exit code.
    """
    from actspec.diagnostics import Diagnostic, Severity
    from actspec.report.terminal import print_failure

    with printing(), suppress(StreamError):
        arguments = _parsed(sys.argv[1:])
        help = "actspec audit reads what it can of such a model from its text"
        said = Diagnostic("ENV005", Severity.ERROR, reason, help=help)
        print_failure((said,), getattr(arguments, "output_format", "text"), _said_by(arguments))
        sys.stdout.flush()
        sys.stderr.flush()
    return EXIT_FAILED


def _parsed(argv: Sequence[str]) -> argparse.Namespace:
    if not argv:
        # Not 0: a script whose command is an empty variable must not look as if it had passed.
        parser("").print_help(sys.stderr)
        raise SystemExit(EXIT_FAILED)
    grammar = parser(next((text for text in argv if text in COMMANDS), ""))
    for text in takewhile("--".__ne__, argv):
        # argparse before Python 3.13 takes `--output=--` for an option with a list of no values.
        if text.startswith("-") and (text.endswith("=--") or text[2:] == "--"):
            grammar.error(f"argument {text[:-2].rstrip('=')}: expected one argument")
    return grammar.parse_args(argv)


def _module(command: str) -> Any:
    """The module of a command: each imports what it needs, and nothing that another one needs."""
    return import_module(f"actspec.cli.{command}_" if iskeyword(command) else f"actspec.cli.{command}")


def _main(arguments: argparse.Namespace) -> int:
    # Nothing is drawn here: without this MuJoCo loads a windowing library, which may even fail to start.
    os.environ["MUJOCO_GL"] = "disable"
    # A run makes hundreds of classes and drops none: to look for garbage among them takes time.
    collecting = gc.isenabled()
    gc.disable()
    try:
        code = _run(arguments)
        sys.stdout.flush()
        return code
    except StreamError as err:
        return _unprinted(err)
    except KeyboardInterrupt:
        return 130
    finally:
        if collecting:
            gc.enable()


def _unprinted(err: StreamError) -> int:
    print(f"actspec: {err}", file=sys.stderr)
    return EXIT_FAILED


def _said_by(arguments: argparse.Namespace) -> str:
    """The command by the name of its machine output; each part of these two has its own."""
    command: str = arguments.command
    return f"{command}-{arguments.part}" if command in ("net", "delta") else command


def _run(arguments: argparse.Namespace) -> int:
    from actspec.diagnostics import ActspecError
    from actspec.files import noting

    command: str = arguments.command
    try:
        with noting():
            code: int = _module(command).run(arguments)
        return code
    except ActspecError as err:
        said = err.diagnostics
    except StreamError:
        raise
    except Exception as err:
        from actspec.cli.faults import diagnostic

        said = (diagnostic(err),)
    from actspec.report.terminal import print_failure

    print_failure(said, getattr(arguments, "output_format", "text"), _said_by(arguments))
    return EXIT_FAILED
