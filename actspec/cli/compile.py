"""`actspec compile`: specs to files, with a summary worth reading."""

from __future__ import annotations

import argparse
import os
import sys
from typing import Any

from actspec import api, output
from actspec.cli.options import (
    add_canonical,
    add_force,
    add_format,
    add_packages,
    add_specs,
    add_targets,
    add_variant,
    describe,
)
from actspec.diagnostics import EXIT_CLEAN, EXIT_FINDINGS, one_line
from actspec.placing import finish
from actspec.report.compile import summary
from actspec.report.doubts import doubts, refusal, refused_losses
from actspec.report.terminal import diagnostic_record, print_diagnostics, print_json, print_lines
from actspec.spec.variants import named, split
from actspec.targets.base import NO_LIMIT, NOT_LOADED


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments and what its help says."""
    describe(
        command,
        "Compile specs to the configuration of each target. Files go to build/ROBOT/TARGET/ and are replaced only "
        "when they differ.",
        "actspec compile robots/a1.yaml -t mujoco -o out",
        "0 compiled; 1 stale files with --check or --diff, what --strict refuses, or written files that MuJoCo cannot "
        "load; 2 could not compile",
    )
    add_specs(command)
    command.add_argument("-o", "--output", metavar="DIR", help="write below DIR (default: build/ROBOT)")
    add_variant(command)
    add_targets(command)
    add_packages(command)
    command.add_argument("--check", action="store_true", help="write nothing; exit 1 if a file is stale")
    command.add_argument(
        "--diff", action="store_true", help="write nothing; show what would change, exit 1 if so"
    )
    command.add_argument(
        "--strict",
        action="store_true",
        help="write nothing and exit 1 on an approximation that the spec does not accept, a number that can hardly "
        "be right, a drive without an effort limit, or a model that MuJoCo cannot load",
    )
    add_canonical(command)
    add_force(command, "replace files that actspec did not write, or wrote from another spec")
    add_format(command)


def run(arguments: argparse.Namespace) -> int:
    """Compile each spec; nothing is written before all of them compile."""
    done = [
        api.compile(
            api.load(named(path, arguments.variant), packages=dict(arguments.package)),
            targets=arguments.target,
            output=_folder(arguments, index),
            canonical=arguments.canonical,
        )
        for index, path in enumerate(arguments.spec)
    ]
    dry = arguments.check or arguments.diff
    if not dry:
        folders = (options.folder for compilation in done for options in compilation.targets)
        finish(os.path.join(folder, output.MANIFEST) for folder in folders)
    files = [output.outputs(compilation) for compilation in done]
    stale = any(file.changed for group in files for file in group)
    refused = [loss for compilation in done for loss in compilation.unaccepted] if arguments.strict else []
    doubtful = (
        [item for compilation in done for item in doubts(compilation.diagnostics)] if arguments.strict else []
    )
    codes = {item.code for compilation in done for item in compilation.diagnostics}
    unlimited = arguments.strict and NO_LIMIT in codes
    unloaded = NOT_LOADED in codes and not dry
    stopped = bool(refused or doubtful or unlimited or (arguments.strict and NOT_LOADED in codes))
    if not dry and not stopped:
        output.write([file for group in files for file in group], force=arguments.force)
    if arguments.output_format == "json":
        print_json(_record(done, files))
    else:
        for compilation, group in zip(done, files, strict=True):
            print_diagnostics(compilation.diagnostics)
            if arguments.diff:
                sys.stdout.writelines(output.diff(group))
            elif arguments.check:
                for file in group:
                    if file.changed:
                        print(one_line(f"{file.path}: {_state(file)}"))
            else:
                print_lines(summary(compilation, group, written=not stopped))
        print_lines((*refused_losses(refused, "; nothing was written"), *refusal(doubtful)), sys.stderr)
        if unlimited:
            print(
                f"--strict: drives without an effort limit, which nobody states ({NO_LIMIT})", file=sys.stderr
            )
        if unloaded:
            said = (
                "nothing was written: MuJoCo could not load it"
                if stopped
                else "MuJoCo does not load what was written"
            )
            print(f"{'--strict: ' * stopped}{said} ({NOT_LOADED})", file=sys.stderr)
    if stopped or unloaded or (dry and stale):
        return EXIT_FINDINGS
    return EXIT_CLEAN


def _state(file: output.Output) -> str:
    """What is wrong with a file that would change."""
    if file.old is None:
        return "missing"
    other = output.other_spec(file)
    return "stale" if other is None else f"stale, written from {other.spec}"


def _folder(arguments: argparse.Namespace, index: int) -> str | None:
    """With -o and several specs, each robot gets a folder of its own below it."""
    if arguments.output is None or len(arguments.spec) == 1:
        return None if arguments.output is None else str(arguments.output)
    file, variant = split(arguments.spec[index])
    name = os.path.splitext(os.path.basename(file))[0]
    if variant is not None:
        name = f"{name}-{variant}"
    return os.path.join(str(arguments.output), name)


def _record(done: list[output.Compilation], files: list[tuple[output.Output, ...]]) -> dict[str, Any]:
    return {
        "format": "actspec-compile/1",
        "files": [
            {"target": file.target, "path": file.path, "sha256": file.sha256, "changed": file.changed}
            for group in files
            for file in group
        ],
        "approximations": [output.loss_record(loss) for c in done for loss in c.approximations],
        "diagnostics": [diagnostic_record(item) for c in done for item in c.diagnostics],
    }
