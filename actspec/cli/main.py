"""Entry point: arguments to a command, a command to an exit code."""

from __future__ import annotations

import argparse
import gc
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from keyword import iskeyword
from typing import Any, NoReturn

import actspec
from actspec.cli.options import Lines
from actspec.diagnostics import EXIT_FAILED

COMMANDS = {
    "compile": "compile a spec to its targets",
    "validate": "check specs, without a simulator",
    "show": "show every value with unit, origin, source and formula",
    "verify": "show by numbers that every target agrees",
    "compare": "show what each part of an actuator's model changes",
    "diagnose": "judge a spec by logs, and say what to do",
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
    top = argparse.ArgumentParser(
        prog="actspec",
        formatter_class=Lines,
        description="Compile one reviewed actuator spec to every robot simulator, and audit the files you have.",
        epilog="example: actspec audit robot.xml robot_cfg.py\n"
        "exit codes: 0 clean; 1 findings, stale files, or approximations under --strict; 2 could not run\n"
        "`actspec COMMAND --help` explains a command.",
    )
    top.add_argument("--version", action="version", version=f"actspec {actspec.__version__}")
    commands = top.add_subparsers(dest="command", metavar="COMMAND", required=True)
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
    """
    return _main(_parsed(sys.argv[1:] if argv is None else argv))


def entry() -> NoReturn:
    """Run the process's command and end the process.

    It ends without taking every module apart, which would be a tenth of a compile's time: all files are
    closed by then, and no other process is left.
    """
    # Else pydantic looks through every installed package for plugins that see what is validated.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    # What a command leaves in here is not taken apart either.
    arguments = _parsed(sys.argv[1:])
    code = _main(arguments)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def _parsed(argv: Sequence[str]) -> argparse.Namespace:
    if not argv:
        # Not 0: a script whose command is an empty variable must not look as if it had passed.
        parser("").print_help(sys.stderr)
        raise SystemExit(EXIT_FAILED)
    return parser(next((text for text in argv if text in COMMANDS), "")).parse_args(argv)


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
    from actspec.diagnostics import ActspecError

    command: str = arguments.command
    try:
        code: int = _module(command).run(arguments)
        return code
    except ActspecError as err:
        from actspec.report.terminal import print_failure

        print_failure(err.diagnostics, getattr(arguments, "output_format", "text"), command)
        return EXIT_FAILED


if __name__ == "__main__":
    entry()
