"""The bytes of a spec's files, and what to say where there are none."""

from __future__ import annotations

import os
import re

from actspec.diagnostics import Collector, Span, listed, nearest
from actspec.files import NotRegular, TooLarge, read_regular
from actspec.spec.yaml_text import cut

MAX_BYTES = 1024 * 1024
"""Largest file [bytes]. Chosen: a hand-written spec has a few kilobytes."""

_SPEC_KEY = re.compile(
    rb"""^(?:\xef\xbb\xbf)?(?:\{[ \t]*)?(?:actspec|"actspec"|'actspec')[ \t]*:""", re.MULTILINE
)


def is_spec(data: bytes) -> bool:
    """Whether a YAML text says that it is a spec: its own key `actspec` stands at the beginning of a line."""
    return _SPEC_KEY.search(data) is not None


def read_file(
    path: str, span: Span, collector: Collector, *, real: str | None = None, where: str = ""
) -> bytes | None:
    """The bytes of a file (`real`, called `path` in messages); None after an error at `span`."""
    shown = f"'{cut(path)}'"
    code = "SPEC001"
    help: str | None = None
    try:
        return read_regular(real or path, MAX_BYTES)
    except NotRegular as err:
        message = f"{shown} is {err}"
        help = "name the YAML file in it" if err.folder else None
    except TooLarge as err:
        message, help, code = too_large(shown, err.size)
    except (FileNotFoundError, NotADirectoryError):
        message, help = f"there is no file {shown}", _nearby(path)
    except PermissionError:
        message, help = f"{shown} may not be read", "check its permissions"
    except (OSError, ValueError) as err:
        message = f"{shown} cannot be read: {getattr(err, 'strerror', None) or 'bad path'}"
    collector.error(code, message, where=where, span=span, help=help)
    return None


def too_large(name: str, size: int) -> tuple[str, str, str]:
    """Message, help and code for a text beyond `MAX_BYTES`; `name` as the message has it."""
    return (
        f"{name} is too large, got {size} bytes, at most {MAX_BYTES} bytes are read",
        "a spec is written by hand; keep logs, tables and networks in files that it names",
        "SPEC002",
    )


def _nearby(path: str) -> str | None:
    """What there is in the folder of a missing file."""
    folder, name = os.path.split(path)
    try:
        with os.scandir(folder or os.curdir) as entries:
            found = sorted(e.name for e in entries if e.name.endswith((".yaml", ".yml")))
    except (OSError, ValueError):
        return f"there is no folder '{cut(folder)}' either" if folder else None
    guess = nearest(name, found)
    if guess is not None:
        return f"did you mean '{os.path.join(folder, guess)}'?"
    if found:
        return f"the folder has {listed(found)}"
    return "the folder has no .yaml file; `actspec init` writes one"
