"""`actspec validate`: check specs without a simulator; of the robot's file the text is read, for its joints."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
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
    TooManyErrors,
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
    from actspec.ir import ActuatorSet
    from actspec.robot.view import RobotView
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
    failed = False
    doubtful: list[Diagnostic] = []
    not_installed: list[Diagnostic] = []
    records = []
    for path in arguments.spec:
        if arguments.skip_other and _is_other(path):
            continue
        path = named(path, arguments.variant)
        checked = _with_variants(path, {name: os.path.abspath(at) for name, at in arguments.package})
        diagnostics = _told_once(checked)
        valid = not any(item.severity is Severity.ERROR for item in diagnostics)
        refused = False
        failed |= not valid
        if arguments.strict:
            doubts_here = doubts(diagnostics)
            lacking = [item for check in checked.values() for item in check.lacking]
            refused = bool(doubts_here or lacking)
            doubtful += doubts_here
            not_installed += lacking
        if arguments.output_format == "json":
            records.append(
                {"path": path, "valid": valid, "diagnostics": [diagnostic_record(d) for d in diagnostics]}
            )
            continue
        print_diagnostics(diagnostics)
        if valid:
            print_lines([_summary(path, checked, refused)])
    if arguments.output_format == "json":
        print_json({"format": "actspec-validate/1", "files": records})
    else:
        print_lines(refusal(doubtful), sys.stderr)
        print_lines(_not_checked(not_installed), sys.stderr)
    if failed:
        return EXIT_FAILED
    return EXIT_FINDINGS if doubtful or not_installed else EXIT_CLEAN


@dataclass(frozen=True, slots=True)
class _Checked:
    """A spec, or a variant of one, that was checked.

    Attributes:
        spec: The spec; None: it could not be loaded.
        found: What is to be said of it.
        unread: Why it was not held to the joints of its model; "" where it was.
        lacking: Why its model is not installed, if that is why.
    """

    spec: Spec | None
    found: tuple[Diagnostic, ...]
    unread: str = ""
    lacking: tuple[Diagnostic, ...] = ()


def _with_variants(path: str, packages: Mapping[str, str]) -> dict[str, _Checked]:
    """A spec, under the name "", and each of its variants under its own; of `FILE#VARIANT` that one alone."""
    views: dict[str, RobotView] = {}
    checked = {"": _check(path, packages, views)}
    spec = checked[""].spec
    if spec is not None and split(path)[1] is None:
        for name in spec.model.variants:
            checked[name] = _check(named(spec.document.path, name), packages, views)
    return checked


def _check(path: str, packages: Mapping[str, str], views: dict[str, RobotView]) -> _Checked:
    """Check a spec; `views` has the models that are read already, by their paths, and takes this one.

    What is resolved has what the spec alone implies too, judged beside its robot.
    """
    from actspec.robot.load import check_packages
    from actspec.spec.validate import load_spec

    spec = None
    found: tuple[Diagnostic, ...] = ()
    try:
        spec = load_spec(path).with_packages(packages)
        found = spec.diagnostics
        check_packages(spec)
        found = ()
        unread, lacking, found = _resolved(spec, views)
    except ActspecError as err:
        return _Checked(spec, (*found, *err.diagnostics))
    return _Checked(spec, found, unread, lacking)


def _told_once(checked: Mapping[str, _Checked]) -> tuple[Diagnostic, ...]:
    """What is to be said of a spec and its variants: what holds for the spec itself, and what for variants alone."""
    variants: dict[Diagnostic, list[str]] = {}
    for name, check in checked.items():
        for item in check.found:
            variants.setdefault(item, []).append(name)
    collector = Collector()
    try:
        for item, names in variants.items():
            if "" not in names:
                item = replace(item, where=f"{item.where} ({_variants(names)})".lstrip())
            collector.add(item)
    except TooManyErrors as err:
        return err.diagnostics
    return collector.sorted()


def _variants(names: Sequence[str]) -> str:
    return f"variant{'s' * (len(names) > 1)} {listed(names)}"


def _summary(path: str, checked: Mapping[str, _Checked], refused: bool) -> str:
    """The line of a valid spec."""
    spec = checked[""].spec
    assert spec is not None
    model = spec.model
    text = f"{one_line(path)}: valid{', but not to --strict' * refused}: {model.robot.name}, "
    text += many(len(model.actuators), "group")
    if len(checked) > 1:
        text += f", variants {listed(sorted({*filter(None, checked), *filter(None, [model.variant])}))}"
    reasons: dict[str, list[str]] = {}
    for name, check in checked.items():
        if check.unread:
            reasons.setdefault(check.unread, []).append(name)
    for reason, names in reasons.items():
        of = "" if "" in names else f"{_variants(names)}: "
        text += f" ({of}{reason})"
    return text


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


def _check_ranges(actuators: ActuatorSet, uncompiled: bool, collector: Collector) -> None:
    """Report what the target of randomisation would; a nominal value that is unknown may only need a compilation."""
    from actspec.sampling import check_ranges

    every = Collector()
    check_ranges(actuators, every)
    for item in every:
        if item.code != "RND001" or not uncompiled:
            collector.add(item)


def _resolved(
    spec: Spec, views: dict[str, RobotView]
) -> tuple[str, tuple[Diagnostic, ...], tuple[Diagnostic, ...]]:
    """Resolve a spec against the text of its model; what only a compilation tells, inertia above all, is unknown there.

    Of its targets versions are checked, and joints that they name.

    Args:
        spec: The spec.
        views: The models that are read already, by their paths; takes its own.

    Returns: Why it was not held to its model's joints, "" where it was; why the model is not installed, if that is why;
        and what is to be said of the spec.

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
    from actspec.targets.choose import check_accepted, choose_targets
    from actspec.targets.kit.network import check_manifests

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
            path = find_model(model, os.path.dirname(spec.document.path))
            if path not in views:
                views[path] = joints_of_text(path)
            robot = views[path]
    except (JointsNotNamed, RobotNotInstalled) as err:
        unread = (
            f"not checked against the joints of {one_line(model)}: {one_line(err.diagnostics[0].message)}"
        )
        lacking = err.diagnostics if isinstance(err, RobotNotInstalled) else ()
    except RobotError as err:
        for item in placed(spec, err):
            collector.add(item)
    managed = None
    found = spec.diagnostics
    if robot is not None:
        try:
            actuators = resolve(spec, robot)
            managed = [actuator.joint for actuator in actuators.joints]
            check_manifests(actuators, spec, collector)
            found = actuators.diagnostics
            if any(options.kind == "randomization" for options in targets):
                _check_ranges(actuators, robot.uncompiled, collector)
            if not spec.model.variants:
                # Another variant may lose what this one does not.
                check_accepted(spec, actuators, (), (), collector)
        except ResolveError as err:
            found = err.diagnostics
        of_robot = {*robot.diagnostics} - {*spec.diagnostics}
        found = tuple(
            item
            for item in found
            if item not in of_robot and (item.severity is not Severity.INFO or item in spec.diagnostics)
        )
    for item in found:
        collector.add(item)
    check_options(targets, managed, collector)
    collector.raise_if_failed(ResolveError)
    return unread, lacking, collector.sorted()
