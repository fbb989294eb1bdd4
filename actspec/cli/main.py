"""Entry point: arguments to a command, a command to an exit code."""

from __future__ import annotations

import argparse
import gc
import os
import sys
from collections.abc import Callable, Sequence
from importlib import import_module
from keyword import iskeyword
from typing import NoReturn

import actspec
from actspec.cli.audit_options import add_audit_options
from actspec.diagnostics import EXIT_FAILED

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
)
"""Machine output with a schema: `schemas/actspec-NAME-v1.schema.json`."""


def parser() -> argparse.ArgumentParser:
    """The command line's grammar."""
    top = argparse.ArgumentParser(
        prog="actspec",
        description="Compile one reviewed actuator spec to every robot simulator, and audit the files you have.",
        epilog="Exit codes: 0 clean; 1 findings, stale files, or approximations under --strict; 2 could not run.",
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
    validate.add_argument(
        "--skip-other",
        action="store_true",
        help="pass over files without the key `actspec`: for hooks",
    )
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
        "(actuators), validate, verify, audit (report) and rule (rules), and files that are written",
    )

    audit = commands.add_parser("audit", help="audit robot files, with or without a spec", description=_AUDIT)
    add_audit_options(audit)

    diff = commands.add_parser("diff", help="what changed in effective dynamics", description=_DIFF)
    diff.add_argument(
        "old", metavar="OLD", help="MJCF, URDF, cfg .py, deploy YAML or spec, or REVISION:FILE of git"
    )
    diff.add_argument("new", metavar="NEW", help="likewise")
    diff.add_argument("--robot", metavar="NAME", help="only this robot of files that have several")
    _versions(diff)
    _format(diff)

    lock = commands.add_parser(
        "lock", help="record effective dynamics, and see what changes", description=_LOCK
    )
    lock.add_argument("file", nargs="*", metavar="FILE", help="files to record (default: those of the lock)")
    lock.add_argument(
        "-o", "--output", default="actspec.lock", metavar="LOCK", help="the lock (default: actspec.lock)"
    )
    lock.add_argument("--check", action="store_true", help="write nothing; say what changed, exit 1 if so")
    _versions(lock)
    _format(lock)

    rule = commands.add_parser("rule", help="explain a rule of the audit")
    rule.add_argument("rule", nargs="*", metavar="CODE", help="code, family or name")
    rule.add_argument("--all", action="store_true", help="every rule")
    rule.add_argument("--docs", metavar="DIR", help="write the pages of all rules to DIR")
    _format(rule)

    verify = commands.add_parser(
        "verify", help="show by numbers that every target agrees", description=_VERIFY
    )
    verify.add_argument("spec", nargs="*", metavar="SPEC", help="actuator spec (YAML)")
    verify.add_argument("--built", metavar="DIR", help="verify the compiled files below DIR, edited or not")
    verify.add_argument(
        "-t",
        "--target",
        action="append",
        default=[],
        metavar="TARGET",
        help="only this target of the spec, or KIND==VERSION; may be repeated",
    )
    verify.add_argument(
        "--fields-only", action="store_true", help="read the files, run no simulator and no Python file"
    )
    verify.add_argument(
        "--run-edited",
        action="store_true",
        help="with --built: let simulators execute Python files that are not what the spec compiles to",
    )
    verify.add_argument(
        "--require-engines", action="store_true", help="exit 2 when an engine is not prepared"
    )
    verify.add_argument(
        "--strict",
        action="store_true",
        help="exit 1 on an approximation that the spec does not accept, too",
    )
    verify.add_argument(
        "--setup", action="store_true", help="install the simulators' packages in a folder of their own"
    )
    verify.add_argument("--yes", action="store_true", help="with --setup: do not ask")
    verify.add_argument(
        "--output-format",
        choices=("text", "json", "markdown", "github"),
        default="text",
        help="default: text",
    )

    import_ = commands.add_parser("import", help="write a spec from files that you have", description=_IMPORT)
    import_.add_argument(
        "file", nargs="+", metavar="FILE", help="MJCF, URDF, cfg .py or deploy YAML of one robot"
    )
    import_.add_argument("-o", "--output", metavar="SPEC", help="file to write (default: standard output)")
    import_.add_argument("--robot", metavar="NAME", help="this robot of a file that has several")
    import_.add_argument("--force", action="store_true", help="replace a file that is there")
    _versions(import_)

    init = commands.add_parser("init", help="write a starting spec")
    init.add_argument("path", nargs="?", default="actspec.yaml", metavar="SPEC", help="file to write")
    init.add_argument("--from", dest="source", metavar="FILE", help="as `import FILE -o SPEC`")
    init.add_argument("--force", action="store_true", help="replace a file that is there")
    return top


def _versions(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "-t",
        "--target",
        action="append",
        default=[],
        metavar="NAME==VERSION",
        help="what the files are meant for, as in audit; may be repeated",
    )


def _format(command: argparse.ArgumentParser) -> None:
    command.add_argument("--output-format", choices=("text", "json"), default="text", help="default: text")


_COMPILE = (
    "Compile specs to the configuration of each target. Files go to build/ROBOT/TARGET/ and are replaced only "
    "when they differ."
)
_DIFF = (
    "Compare two robot files, or a file with an earlier revision of it, joint by joint, in what acts on the joints: "
    "gains, damping, friction, limits, armature, delays, steps. Exit codes: 0 no change; 1 changes; 2 could not "
    "compare."
)
_LOCK = (
    "Write what acts on each joint to a file for version control, and with --check say what has changed since: "
    "policies that were trained before need re-evaluation. Exit codes: 0 written, or no change; 1 changes; 2 could "
    "not run."
)
_VERIFY = (
    "Compile a spec, read every file back, run the simulators' own code over a grid of error, velocity and history, "
    "and compare with the law. Exit codes: 0 all agree, known approximations marked; 1 something does not; 2 could "
    "not run."
)
_IMPORT = (
    "Write the spec of one robot from what its files say, each number with its file; where they disagree, the "
    "training configuration counts before the deploy file, and that before the robot files. Runs none of them. Exit "
    "codes: 0 written; 2 could not."
)
_AUDIT = (
    "Read MJCF, URDF, Isaac Lab, mjlab and legged_gym configurations, deploy YAML and specs, running none of them, "
    "and say where they disagree with each other and with physics. Exit codes: 0 nothing at or above --fail-on; "
    "1 findings; 2 a file could not be read, or actspec could not run. With sarif 0 in place of 1."
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run a command.

    Args:
        argv: Arguments; default: those of the process.

    Returns: 0 clean, 1 findings, 2 could not run.
    """
    return _main(parser().parse_args(argv))


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


def entry() -> NoReturn:
    """Run the process's command and end the process.

    It ends without taking every module apart, which would be a tenth of a compile's time: all files are
    closed by then, and no other process is left.
    """
    # What a command leaves in here is not taken apart either.
    arguments = parser().parse_args()
    code = _main(arguments)
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def _run(arguments: argparse.Namespace) -> int:
    from actspec.diagnostics import ActspecError
    from actspec.report import terminal as report

    command: str = arguments.command
    try:
        # Each command imports what it needs, and nothing that another one needs.
        module = f"{command}_" if iskeyword(command) else command
        run: Callable[[argparse.Namespace], int] = import_module(f"actspec.cli.{module}").run
        return run(arguments)
    except ActspecError as err:
        report.print_failure(err.diagnostics, getattr(arguments, "output_format", "text"), command)
        return EXIT_FAILED


if __name__ == "__main__":
    entry()
