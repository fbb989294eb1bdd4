"""`actspec lock`: record the effective dynamics of robot files, and say what has changed since."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Mapping
from typing import Any

from actspec.audit.build import case_of
from actspec.audit.case import Case
from actspec.audit.difference import read_all
from actspec.audit.exclude import Exclude
from actspec.audit.lock import (
    changes,
    load_lock,
    locked,
    names_in_lock,
    old_form,
    recorded_files,
    remarks,
    text_of,
    versions_of,
)
from actspec.audit.settings_file import excluded
from actspec.cli.options import add_force, add_format, add_versions, configured_versions, describe, overridden
from actspec.diagnostics import (
    EXIT_CLEAN,
    EXIT_FINDINGS,
    AuditError,
    Collector,
    Span,
    listed,
    many,
    one_line,
    shortened,
)
from actspec.files import FAULTS, why
from actspec.owned import put_file
from actspec.readings.dynamics import dynamics_of
from actspec.readings.versions import Versions
from actspec.report.difference import counted, lines, record
from actspec.report.terminal import print_diagnostics, print_json, print_lines


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments and what its help says."""
    describe(
        command,
        "Write what acts on each joint to a file for version control, and with --check show what has changed since: "
        "policies that were trained before need re-evaluation.",
        "actspec lock robots/a1.yaml robots/a1/a1.xml",
        "0 written, or no change; 1 changes; 2 could not run",
    )
    command.add_argument(
        "file",
        nargs="*",
        metavar="FILE",
        help="files to record, or folders for the robot files in them, without those that the settings exclude "
        "(default: those of the lock)",
    )
    command.add_argument(
        "-o", "--output", default="actspec.lock", metavar="LOCK", help="the lock (default: actspec.lock)"
    )
    command.add_argument(
        "--check", action="store_true", help="write nothing; show what changed, exit 1 if anything did"
    )
    add_force(command)
    add_versions(command)
    add_format(command)


def run(arguments: argparse.Namespace) -> int:
    """Write the lock, or check files against it."""
    path: str = arguments.output
    anew = arguments.force and arguments.file and not arguments.check
    old = (
        None
        if anew
        else load_lock(path, needed=arguments.check or not arguments.file, figures=arguments.check)
    )
    versions = configured_versions(arguments.target)
    if arguments.check:
        assert old is not None
        return _check(arguments, path, old, overridden(versions_of(old), versions))
    if old is not None and not arguments.file:
        versions = overridden(versions_of(old), versions)
    recorded = {} if old is None else recorded_files(old, path)
    if arguments.file:
        globs, folder, _ = excluded(None)
        exclude = Exclude(tuple((glob, folder) for glob in globs))
        readings = read_all(arguments.file, {}, folders=True, exclude=exclude)
        names = names_in_lock([reading.path for reading in readings], path)
        case = case_of([reading for reading in readings if reading.path in names], versions, {}, whole=True)
    else:
        names, case = recorded, _case(recorded, versions, path, whole=True)
    lock = locked(case, names)
    data = text_of(lock)
    try:
        put_file(path, data, force=arguments.force)
    except FAULTS as err:
        raise AuditError.of("LCK001", f"cannot be written: {why(err)}", Span(path)) from err
    print_diagnostics(remarks(case, lock, names))
    if arguments.output_format == "json":
        print_json(lock)
    else:
        _tell(path, case, len(names))
    return EXIT_CLEAN


def _tell(path: str, case: Case, files: int) -> None:
    """How much is recorded, and what is not."""
    robots = [dynamics_of(artifact, case.rows_of(index)) for index, artifact in enumerate(case.artifacts)]
    joints = [name for robot in robots for name in robot.joints]
    patterns = frozenset().union(*(robot.patterns for robot in robots))
    entries = sum(len(robot.entries or ()) for robot in robots)
    beside = f", {many(entries, 'number')} that no joint is named for" if entries else ""
    print(f"{one_line(path)}: {counted(joints, patterns)}{beside} of {many(files, 'file')}", file=sys.stderr)
    for robot in robots:
        for what, why_not in robot.unread.items():
            file, name = one_line(robot.file), one_line(robot.name)
            # Of the class itself it is what is not written there.
            told = (
                f"{name} of {file} is recorded but for a part"
                if what == robot.name
                else f"not in it: {one_line(what)} of {file} ({name})"
            )
            print(f"  {told}, {one_line(why_not)}", file=sys.stderr)
    others: dict[tuple[str, ...], list[str]] = {}
    for robot in robots:
        if robot.others:
            others.setdefault(tuple(robot.others), []).append(
                f"{one_line(robot.file)} ({one_line(robot.name)})"
            )
    for values, having in others.items():
        print(
            f"  not in it, as part of no joint's figures: {listed(map(one_line, values), 4)} of {listed(having, 2)}",
            file=sys.stderr,
        )


def _check(arguments: argparse.Namespace, path: str, old: Mapping[str, Any], versions: Versions) -> int:
    """What has changed, in words."""
    recorded = recorded_files(old, path)
    files = [name for file in arguments.file for name in _below(file, recorded)]
    asked = names_in_lock(files, path) if arguments.file else recorded
    out = Collector()
    for file, name in asked.items():
        if name not in recorded.values():
            there = os.path.exists(file)
            help = f"add it with `actspec lock -o {path}`" if there else None
            message = "is not in the lock" if there else "is not in the lock, and there is no such file"
            out.error("LCK003", message, span=Span(file), help=help)
    out.raise_if_failed(AuditError)
    print_diagnostics(old_form(old, path))
    # All are read, because a configuration's joints come from the model beside it.
    wanted = set(asked.values())
    # An older actspec recorded no joints without gains.
    case = _case(recorded, versions, path, whole="hash" in old)
    found = [item for item in changes(old, case, recorded) if item[0] in wanted]
    changed = [(name, item) for name, item in found if item.changed]
    if arguments.output_format == "json":
        print_json({"format": "actspec-diff/1", "robots": [record(item, path, name) for name, item in found]})
    else:
        for name, item in changed:
            print(f"{one_line(name)} ({shortened(item.new.name)}) since {one_line(path)}:")
            print_lines(lines(item))
        if changed:
            print("policies trained before need re-evaluation; `actspec lock` records the new dynamics")
        else:
            print(f"{one_line(path)}: no change in what it records")
    return EXIT_FINDINGS if changed else EXIT_CLEAN


def _below(file: str, recorded: Mapping[str, str]) -> list[str]:
    """The files of the lock in a folder; what is none, or has none of them, stands for itself."""
    folder = os.path.join(os.path.realpath(file), "")
    inside = [path for path in recorded if os.path.realpath(path).startswith(folder)]
    return inside if os.path.isdir(file) and inside else [file]


def _case(names: Mapping[str, str], versions: Versions, lock: str, *, whole: bool) -> Case:
    """The files of a lock, read; they keep their names when a file gets another one."""
    gone = (
        f"{one_line(lock)} has this file; if it was renamed or deleted, record all files by their present names "
        f"with `actspec lock -o {one_line(lock)} FILE...`"
    )
    return case_of(read_all(tuple(names), {}, gone), versions, {}, whole=whole)
