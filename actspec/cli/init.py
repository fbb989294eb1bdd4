"""`actspec init`: a first spec, as a commented example or drafted from a robot file."""

from __future__ import annotations

import argparse
import os
import shlex
from collections.abc import Iterator
from typing import TYPE_CHECKING

from actspec.diagnostics import EXIT_CLEAN, Diagnostic, EmitError, Severity, Span, listed

if TYPE_CHECKING:
    from actspec.draft import Draft

_SCHEME = "package://"


def run(arguments: argparse.Namespace) -> int:
    """Write the spec and say what to do next."""
    from actspec.files import replace_file

    path, source = str(arguments.path), arguments.source
    _check_free(path, source, bool(arguments.force))
    text, told = _start(path) if source is None else _draft(path, str(source))
    try:
        os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
        replace_file(path, text.encode("utf-8"))
    except OSError as err:
        raise _error("OUT002", f"cannot be written: {err.strerror}", path) from err
    for line in told:
        print(line)
    return EXIT_CLEAN


def _check_free(path: str, source: str | None, force: bool) -> None:
    if os.path.isdir(path) or not os.path.basename(path):
        raise _error("OUT001", "is a folder", path, "name the file to write, e.g. robots/my_robot.yaml")
    if not os.path.lexists(path):
        return
    if source is not None and os.path.exists(source) and os.path.samefile(path, source):
        raise _error("OUT003", "is the robot file itself", path, "name another file for the spec")
    if not os.path.isfile(path):
        raise _error("OUT001", "is there and is no regular file", path)
    if not force:
        raise _error("OUT003", "is there already", path, "name another file, or replace it with --force")


def _start(path: str) -> tuple[str, list[str]]:
    from actspec.draft import starting_spec

    shown = shlex.quote(path)
    return starting_spec(), [
        f"wrote {path}: an example with every part of the language explained",
        "next: name your robot's file in `robot.model`, put its numbers in, then",
        f"  actspec validate {shown}",
        f"  actspec compile {shown}",
        "or begin with what a robot file says: actspec init --from robot.xml NEW.yaml",
    ]


def _draft(path: str, source: str) -> tuple[str, list[str]]:
    from actspec.cli.report import print_diagnostics
    from actspec.draft import draft_spec
    from actspec.robot.load import find_model, load_robot
    from actspec.spec.document import document_from_text
    from actspec.spec.validate import validate

    robot = load_robot(find_model(source, ""))
    print_diagnostics(robot.diagnostics)
    draft = draft_spec(robot, _reference(source, path))
    # Whatever the file was, what is written is a valid spec.
    validate(document_from_text(draft.text, path))
    return draft.text, list(_told(draft, path, source))


def _reference(source: str, path: str) -> str:
    """What the spec at `path` names the robot file by."""
    if source.startswith(_SCHEME):
        return source
    folder = os.path.dirname(os.path.abspath(path))
    try:
        found = os.path.relpath(os.path.abspath(source), folder).replace(os.sep, "/")
    except ValueError:
        # Another drive of Windows: no relative path leads there.
        return os.path.abspath(source)
    return f"./{found}" if found == "none" else found


def _told(draft: Draft, path: str, source: str) -> Iterator[str]:
    groups = draft.groups
    joints = sum(groups.values())
    yield (
        f"wrote {path}: {joints} joint{'s' * (joints != 1)} in {len(groups)} group{'s' * (len(groups) != 1)} "
        f"({listed(groups)}), from {source}"
    )
    if draft.left_alone:
        reasons: dict[str, list[str]] = {}
        for item in draft.left_alone:
            reasons.setdefault(item.why, []).append(item.joint)
        for why, names in reasons.items():
            yield f"  left as they are, {why}: {listed(names)}"
    for field, lacking in draft.unknown.items():
        yield f"  the file does not say {field}: {listed(lacking)}"
    shown = shlex.quote(path)
    needed = [field for field in ("kp",) if field in draft.unknown]
    yield f"next: check it{', state ' + ' and '.join([*needed, 'kd']) if needed else ''}, then"
    yield f"  actspec show {shown}"
    yield f"  actspec compile {shown}"


def _error(code: str, message: str, path: str, help: str | None = None) -> EmitError:
    return EmitError([Diagnostic(code, Severity.ERROR, message, "", Span(path), help)])
