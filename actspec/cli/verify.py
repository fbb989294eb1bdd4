"""`actspec verify`: show by numbers that every target makes what the spec says."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from typing import Any

from actspec import api
from actspec.cli.options import (
    add_canonical,
    add_format,
    add_packages,
    add_specs,
    add_targets,
    add_variant,
    describe,
)
from actspec.diagnostics import EXIT_CLEAN, EXIT_FAILED, EXIT_FINDINGS, Collector, Diagnostic, SpecError
from actspec.output import loss_record
from actspec.report.doubts import doubts, refused_losses
from actspec.report.terminal import Progress, diagnostic_record, print_diagnostics, print_json, print_lines
from actspec.report.verify import github, markdown, text
from actspec.spec.variants import named
from actspec.targets.base import NOT_LOADED
from actspec.verify.agreement import FORMAT, Agreement, row_record, skip_record

Done = list[tuple[api.Compilation, Agreement]]


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments and what its help says."""
    describe(
        command,
        "Compile a spec, read every file back, run the simulators' own code over a grid of error, velocity and "
        "history, and compare with the law.",
        "actspec verify robots/a1.yaml -t mujoco",
        "0 all agree, known approximations marked; 1 something does not; 2 could not run",
    )
    add_specs(command, "*")
    command.add_argument("--built", metavar="DIR", help="verify the compiled files below DIR, edited or not")
    add_variant(command)
    add_targets(command)
    add_packages(command)
    add_canonical(command)
    command.add_argument(
        "--fields-only", action="store_true", help="read the files, run no simulator and no Python file"
    )
    command.add_argument(
        "--run-edited",
        action="store_true",
        help="with --built: let simulators execute Python files that are not what the spec compiles to",
    )
    command.add_argument(
        "--trust",
        action="store_true",
        help="let simulators execute TorchScript of networks that actspec did not write",
    )
    command.add_argument(
        "--require-engines", action="store_true", help="exit 2 when an engine is not prepared"
    )
    command.add_argument(
        "--strict", action="store_true", help="exit 1 on an approximation that the spec does not accept, too"
    )
    command.add_argument(
        "--setup", action="store_true", help="install the simulators' packages in a folder of their own"
    )
    command.add_argument("--yes", action="store_true", help="with --setup: do not ask")
    add_format(command, "markdown", "github")


def run(arguments: argparse.Namespace) -> int:
    """Verify each spec, or prepare the engines."""
    if arguments.setup:
        from actspec.cli.verify_setup import set_up

        return set_up(arguments)
    _check(arguments)
    done = [_verified(path, arguments) for path in arguments.spec]
    if arguments.output_format == "json":
        print_json(_record(done))
    else:
        for compilation, agreement in done:
            print_diagnostics(
                (*doubts(compilation.diagnostics), *_unloaded(compilation), *_failed(compilation))
            )
            print_lines(_lines(compilation, agreement, arguments))
            print_diagnostics(_asked_for(agreement, arguments))
            if _unloaded(compilation):
                print(f"MuJoCo does not load what is written ({NOT_LOADED})", file=sys.stderr)
        refused = [loss for compilation, _ in done for loss in compilation.unaccepted]
        print_lines(refused_losses(refused if arguments.strict else ()), sys.stderr)
    return max(_code(compilation, agreement, arguments) for compilation, agreement in done)


def _check(arguments: argparse.Namespace) -> None:
    collector = Collector()
    if not arguments.spec:
        collector.error("CLI001", "no spec is named", where="verify", help="actspec verify SPEC, or --setup")
    if arguments.built is not None and len(arguments.spec) > 1:
        collector.error("CLI001", "one folder of files is of one spec", where="--built", help="name one spec")
    if arguments.require_engines and arguments.fields_only:
        collector.error("CLI001", "no engine is run with --fields-only", where="--require-engines")
    if arguments.run_edited and (arguments.built is None or arguments.fields_only):
        collector.error(
            "CLI001",
            "no edited file is run without --built"
            if arguments.built is None
            else "nothing is run with --fields-only",
            where="--run-edited",
        )
    collector.raise_if_failed(SpecError)


def _verified(path: str, arguments: argparse.Namespace) -> tuple[api.Compilation, Agreement]:
    with Progress("verifying") as progress, progress.ticking():
        return api.verify(
            api.load(named(path, arguments.variant), packages=dict(arguments.package)),
            targets=arguments.target,
            built=arguments.built,
            canonical=arguments.canonical,
            engines=not arguments.fields_only,
            run_edited=arguments.run_edited,
            trust=arguments.trust,
            progress=progress.step,
            partial=True,
        )


def _lines(
    compilation: api.Compilation, agreement: Agreement, arguments: argparse.Namespace
) -> Iterator[str]:
    if arguments.output_format == "github":
        built = arguments.built is not None
        return github(compilation, agreement, built=built, strict=arguments.strict)
    return (markdown if arguments.output_format == "markdown" else text)(compilation, agreement)


def _asked_for(agreement: Agreement, arguments: argparse.Namespace) -> Collector:
    """What `--require-engines` says of engines that are not here."""
    said = Collector()
    for skip in agreement.skipped if arguments.require_engines else ():
        if skip.setup:
            said.error("VFY002", skip.reason, where=f"targets.{skip.target}", help=skip.help)
    return said


def _failed(compilation: api.Compilation) -> Iterator[Diagnostic]:
    """Why some targets could not be compiled."""
    return (item for _, item in compilation.failures)


def _unloaded(compilation: api.Compilation) -> tuple[Diagnostic, ...]:
    """Why the simulator does not load what is written: what ran here was the model without its meshes."""
    return tuple(item for item in compilation.diagnostics if item.code == NOT_LOADED)


def _code(compilation: api.Compilation, agreement: Agreement, arguments: argparse.Namespace) -> int:
    if compilation.failures or _asked_for(agreement, arguments).failed:
        return EXIT_FAILED
    refused = (arguments.strict and compilation.unaccepted) or _unloaded(compilation)
    return EXIT_FINDINGS if refused or not agreement.ok else EXIT_CLEAN


def _record(done: Done) -> dict[str, Any]:
    return {
        "format": FORMAT,
        "rows": [row_record(row) for _, agreement in done for row in agreement.rows],
        "skipped": [skip_record(skip) for _, agreement in done for skip in agreement.skipped],
        "approximations": [loss_record(loss) for c, _ in done for loss in c.approximations],
        "diagnostics": [diagnostic_record(item) for c, _ in done for item in (*c.diagnostics, *_failed(c))],
    }
