"""What a shell completes: `shtab` makes its script of this grammar, once, and a command does not start slower."""

from __future__ import annotations

import argparse
from collections.abc import Iterator

from actspec.cli import main

_FOLDERS = frozenset({"DIR"})
_FILES = frozenset(
    (
        *("DIR/NAME", "FILE", "FILE|LIST", "FILE|NAMES", "HTML", "JSON", "LOCK", "LOG", "MANIFEST"),
        *("NAME.json", "NEW", "OLD", "PAGE", "RESULTS", "SPEC"),
    )
)
"""What help calls an argument that is a path."""


def parser() -> argparse.ArgumentParser:
    """The grammar of all commands, in which shtab is told what is a path.

    Raises: ImportError: shtab is not installed.
    """
    from shtab import DIRECTORY, FILE

    top = main.parser()
    for action in _actions(top):
        if action.metavar in _FILES or action.metavar in _FOLDERS:
            action.complete = FILE if action.metavar in _FILES else DIRECTORY  # type: ignore[attr-defined]
    return top


def _actions(parser: argparse.ArgumentParser) -> Iterator[argparse.Action]:
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _actions(command)
        else:
            yield action
