"""Writing a first spec: never over what is there, and never half."""

from __future__ import annotations

import os
import shlex
from collections.abc import Sequence

from actspec.diagnostics import Diagnostic, EmitError, Severity, Span


def check_free(path: str, sources: Sequence[str], force: bool) -> None:
    """Refuse a path that cannot be written, or holds something.

    Args:
        path: The spec to be.
        sources: Files that it is imported from, which stay as they are.
        force: Whether another file may be replaced.

    Raises: EmitError: it cannot be written.
    """
    if os.path.isdir(path) or not os.path.basename(path):
        raise _error("OUT001", "is a folder", path, "name the file to write, e.g. robots/my_robot.yaml")
    if not os.path.lexists(path):
        return
    if os.path.exists(path) and any(
        os.path.exists(source) and os.path.samefile(path, source) for source in sources
    ):
        raise _error("OUT003", "is the file to import itself", path, "name another file for the spec")
    if not os.path.isfile(path):
        raise _error("OUT001", "is there and is no regular file", path)
    if not force:
        raise _error("OUT003", "is there already", path, "name another file, or replace it with --force")


def write_spec(path: str, text: str) -> None:
    """Write a spec in one step, with its folders.

    Raises: EmitError: it cannot be written.
    """
    from actspec.files import replace_file

    try:
        os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
        replace_file(path, text.encode("utf-8"))
    except OSError as err:
        raise _error("OUT002", f"cannot be written: {err.strerror}", path) from err
    except ValueError as err:
        # A name with a NUL in it.
        raise _error("OUT002", f"cannot be written: {err}", path) from err


def commands(path: str, *names: str) -> list[str]:
    """Commands to go on with, ready to paste."""
    return [f"  actspec {name} {shlex.quote(path)}" for name in names]


def _error(code: str, message: str, path: str, help: str | None = None) -> EmitError:
    return EmitError([Diagnostic(code, Severity.ERROR, message, "", Span(path), help)])
