"""Whether the libraries of the extra `learn` are there."""

from __future__ import annotations

from importlib.util import find_spec

from actspec.diagnostics import listed
from actspec.libraries import extra_line
from actspec.logs import LogError


def require(*names: str) -> None:
    """Refuse to begin without libraries.

    Args:
        names: As they are imported.

    Raises:
        LogError: at least one is not installed.
    """
    lacking = [name for name in names if find_spec(name) is None]
    if lacking:
        message = f"{listed(lacking)} {'is' if len(lacking) == 1 else 'are'} not installed"
        raise LogError.of("LRN012", message, help=extra_line("learn"))
