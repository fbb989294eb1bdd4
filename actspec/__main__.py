"""The process `actspec`, and `python -m actspec`: an interrupt ends it with 130 from its first import on."""

from __future__ import annotations

import os
import sys
from typing import NoReturn

_ALONE = frozenset({"validate", "rule", "schema", "init", "net", "--help", "-h", "--version"})
"""First arguments of runs that show no model to MuJoCo."""


def entry() -> NoReturn:
    """Run the process's command and end the process.

    It ends without taking every module apart, which would be a tenth of a compile's time: all files are
    closed by then, and no other process is left.
    """
    code = 130
    try:
        # Else pydantic looks through every installed package for plugins that see what is validated.
        os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
        if len(sys.argv) < 2 or sys.argv[1] in _ALONE:
            code = _run()
        else:
            from actspec.guest import watch

            code = watch(_run, _lost)
    except KeyboardInterrupt:
        pass
    os._exit(code)


def _run() -> int:
    from actspec.cli.main import run_process

    return run_process()


def _lost(reason: str) -> int:
    from actspec.cli.main import run_lost

    return run_lost(reason)


if __name__ == "__main__":
    entry()
