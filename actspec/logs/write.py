"""A log as CSV or NPZ, for experiments that are designed or simulated."""

from __future__ import annotations

import io
import os
from typing import TYPE_CHECKING

from actspec.diagnostics import Span, one_line
from actspec.fields import unit_of_kind
from actspec.files import FAULTS, why
from actspec.logs.log import BASE, SIGNALS, JointLog, Log, LogError
from actspec.owned import put

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

DIGITS = 10
"""Significant digits of a number. Chosen: finer than any encoder."""


WRITTEN = (".csv", ".txt", ".npz")
"""Endings of logs that are written; the first two are CSV."""


def check_log_path(path: str) -> None:
    """Refuse a path whose ending is of no log that is written.

    Raises: LogError: it is.
    """
    if os.path.splitext(path)[1].lower() not in WRITTEN:
        message = f"a log is written as {', '.join(WRITTEN[:-1])} or {WRITTEN[-1]}, by the ending of its name"
        raise LogError.of("LOG001", message, Span(path))


def write_log(log: Log, *, force: bool = False) -> None:
    """Write the rows of a log to its path, in one step, with its folders; the sidecar is not written.

    Args:
        log: The log.
        force: Whether another file that is there is replaced; the same rows need it not.

    Raises:
        EmitError: another file is there.
        LogError: it cannot be written; what was there is untouched.
    """
    import numpy as np

    check_log_path(log.path)
    names = ["time [s]"]
    columns: list[Array] = [log.time]
    for joint in log.joints.values():
        for signal, values in joint.signals.items():
            names.append(f"{joint.name}.{signal}{_unit(joint, signal)}")
            columns.append(values)
    for signal, (components, unit) in BASE.items():
        moved = None if log.base is None else getattr(log.base, signal)
        for component, values in zip(components, () if moved is None else moved.T, strict=False):
            names.append(f"base.{signal}.{component}" + f" [{unit}]" * bool(unit))
            columns.append(values)
    if os.path.splitext(log.path)[1].lower() == ".npz":
        packed = io.BytesIO()
        np.savez(packed, **dict(zip(names, columns, strict=True)))  # type: ignore[arg-type]  # for allow_pickle
        data = packed.getvalue()
    else:
        odd = next((name for name in names if not name.isprintable()), None)
        if odd is not None:
            message = f"a line of text cannot hold the name of a column, '{one_line(odd)}'"
            raise LogError.of("LOG001", message, Span(log.path), help="write a .npz")
        text = io.StringIO()
        text.write(",".join(map(_heading, names)) + "\n")
        np.savetxt(text, np.column_stack(columns), fmt=f"%.{DIGITS}g", delimiter=",")
        data = text.getvalue().encode()
    try:
        put([(log.path, data)], force=force)
    except FAULTS as err:
        raise LogError.of("LOG001", f"the log cannot be written: {why(err)}", Span(log.path)) from err


def _heading(name: str) -> str:
    """The head of a column, in quotes where it would be taken for two."""
    doubled = name.replace('"', '""')
    return f'"{doubled}"' if any(mark in name for mark in ',;"') else name


def _unit(joint: JointLog, signal: str) -> str:
    kind = SIGNALS[signal]
    if kind is None:
        return ""
    return f" [{unit_of_kind(kind, joint.kind)}]"
