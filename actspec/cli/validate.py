"""`actspec validate`: check specs without a simulator; of the robot's file the text is read, for its joints."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from actspec.cli.options import add_format, add_packages, add_specs, add_variant, describe
from actspec.diagnostics import (
    EXIT_CLEAN,
    EXIT_FAILED,
    EXIT_FINDINGS,
    ActspecError,
    Collector,
    Diagnostic,
    ResolveError,
    RobotError,
    Severity,
    listed,
    many,
    one_line,
)
from actspec.files import NotRegular, TooLarge, read_regular
from actspec.report.doubts import doubts, refusal
from actspec.report.terminal import diagnostic_record, print_diagnostics, print_json, print_lines
from actspec.spec.variants import named, split
from actspec.spec.yaml_text import MAX_BYTES, is_spec

if TYPE_CHECKING:
    from actspec.spec.validate import Spec


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments and what its help says."""
    describe(
        command,
        "Check specs without a simulator: keys, units, sources, references, versions of targets, and the joints that "
        "the text of the robot names; every variant, unless one is named.",
        "actspec validate robots/a1.yaml",
        "0 all are valid; 1 with --strict: numbers that can hardly be right, or a model that is not installed; "
        "2 one is not valid",
    )
    add_specs(command)
    add_variant(command)
    add_packages(command)
    command.add_argument(
        "--skip-other", action="store_true", help="skip files without the key `actspec`: for hooks"
    )
    command.add_argument(
        "--strict",
        action="store_true",
        help="exit 1 on a number that can hardly be right, unless the spec says that it is, and on a model that is not "
        "installed",
    )
    add_format(command)


def run(arguments: argparse.Namespace) -> int:
    """Check every spec; all of them, whatever is wrong with the first."""
    from actspec.robot.load import check_packages
    from actspec.spec.validate import load_spec, validate_variants

    failed = False
    doubtful: list[Diagnostic] = []
    not_installed: list[Diagnostic] = []
    records = []
    for path in arguments.spec:
        if arguments.skip_other and _is_other(path):
            continue
        diagnostics: tuple[Diagnostic, ...] = ()
        summary = ""
        try:
            path = named(path, arguments.variant)
            spec = load_spec(path).with_packages(
                {name: os.path.abspath(at) for name, at in arguments.package}
            )
            check_packages(spec)
            diagnostics = (*spec.diagnostics, *validate_variants(spec))
            unchecked, lacking, found = _resolved(spec)
            not_installed += lacking
            model = spec.model
            groups = len(model.actuators)
            summary = f"{one_line(path)}: valid: {model.robot.name}, {many(groups, 'group')}"
            if model.variants and arguments.variant is None:
                summary += f", variants {listed(sorted({*model.variants, *filter(None, [model.variant])}))}"
            summary += unchecked
            diagnostics = (*diagnostics, *found)
        except ActspecError as err:
            failed, summary = True, ""
            diagnostics += err.diagnostics
        if arguments.strict:
            doubtful += doubts(diagnostics)
        if arguments.output_format == "json":
            records.append(
                {
                    "path": path,
                    "valid": bool(summary),
                    "diagnostics": [diagnostic_record(d) for d in diagnostics],
                }
            )
            continue
        print_diagnostics(diagnostics)
        if summary:
            print_lines([summary])
    if arguments.output_format == "json":
        print_json({"format": "actspec-validate/1", "files": records})
    else:
        print_lines(refusal(doubtful), sys.stderr)
        print_lines(_not_checked(not_installed if arguments.strict else ()), sys.stderr)
    if failed:
        return EXIT_FAILED
    return EXIT_FINDINGS if arguments.strict and (doubtful or not_installed) else EXIT_CLEAN


def _not_checked(lacking: Sequence[Diagnostic]) -> Iterator[str]:
    """What `--strict` prints where a model is not installed."""
    for item in dict.fromkeys(lacking):
        yield f"--strict: not checked against the joints of a model: {one_line(item.message)}"
        if item.help:
            yield f"  help: {one_line(item.help)}"


def _is_other(path: str) -> bool:
    """Whether a file is there and is no spec; what cannot be read is told about by who loads it."""
    try:
        return not is_spec(read_regular(split(path)[0], MAX_BYTES))
    except TooLarge:
        return True
    except (NotRegular, OSError, ValueError):
        return False


def _resolved(spec: Spec) -> tuple[str, tuple[Diagnostic, ...], tuple[Diagnostic, ...]]:
    """Resolve a spec against the text of its model; what only a compilation tells, inertia above all, is unknown there.

    Of its targets versions are checked, and joints that they name.

    Returns: What could not be checked, for behind the summary, "" where the joints could be read; why the model is not
        installed, if that is why; and warnings.

    Raises:
        ResolveError: as for `compile`; the model's file is not there, or cannot be read.
    """
    from actspec.resolution import resolve
    from actspec.robot.load import (
        JointsNotNamed,
        RobotNotInstalled,
        find_model,
        joints_of_text,
        listed_robot,
        placed,
    )
    from actspec.targets.check import check_options
    from actspec.targets.choose import choose_targets

    collector = Collector()
    targets = choose_targets(spec, (), None, False, collector)
    model = spec.model.robot.model
    unread = ""
    lacking: tuple[Diagnostic, ...] = ()
    robot = None
    try:
        if model == "none":
            robot = listed_robot(spec)
        else:
            robot = joints_of_text(find_model(model, os.path.dirname(spec.document.path)))
    except (JointsNotNamed, RobotNotInstalled) as err:
        unread = (
            f" (not checked against the joints of {one_line(model)}: {one_line(err.diagnostics[0].message)})"
        )
        lacking = err.diagnostics if isinstance(err, RobotNotInstalled) else ()
    except RobotError as err:
        for item in placed(spec, err):
            collector.add(item)
    managed = None
    if robot is not None:
        try:
            actuators = resolve(spec, robot)
            managed = [actuator.joint for actuator in actuators.joints]
            found = actuators.diagnostics
        except ResolveError as err:
            found = err.diagnostics
        before = {*spec.diagnostics, *robot.diagnostics}
        for item in found:
            if item not in before and item.severity is not Severity.INFO:
                collector.add(item)
    check_options(targets, managed, collector)
    collector.raise_if_failed(ResolveError)
    return unread, lacking, collector.sorted()
