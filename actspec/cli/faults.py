"""What a command cannot answer for: a library that cannot be imported, memory that ran out, a fault of its own."""

from __future__ import annotations

import os
import traceback
from types import TracebackType

from actspec.diagnostics import Diagnostic, Severity
from actspec.libraries import install_line, is_ours, missing_package

TRACEBACK = "ACTSPEC_TRACEBACK"
"""Set in the environment, a fault of actspec shows where it came from."""


def diagnostic(fault: Exception) -> Diagnostic:
    """What is said of an exception that no stage has turned into words."""
    if isinstance(fault, ImportError):
        package = missing_package(fault)
        help = f"install it into the environment that actspec runs in: {install_line(package)}"
        return Diagnostic("ENV001", Severity.ERROR, f"{package} cannot be imported: {fault}", help=help)
    if isinstance(fault, MemoryError):
        return Diagnostic("ENV002", Severity.ERROR, "there is not enough memory for it")
    if os.environ.get(TRACEBACK):
        traceback.print_exception(fault)
    place = _innermost(fault.__traceback__)
    message = f"a fault of actspec, not of your files: {type(fault).__name__}: {fault} ({place})"
    help = f"please report it, with what it prints where {TRACEBACK}=1 is set in the environment"
    return Diagnostic("ENV003", Severity.ERROR, message, help=help)


def _innermost(trace: TracebackType | None) -> str:
    """Our own line that was being run."""
    place = "?"
    for frame, line in traceback.walk_tb(trace):
        if is_ours(frame.f_code.co_filename):
            place = f"{frame.f_code.co_filename.rpartition('actspec' + os.sep)[2]}:{line}"
    return place
