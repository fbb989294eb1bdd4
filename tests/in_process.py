"""Stand-ins for the processes of the audit: what is called in them is called in this one.

A fork of a test process takes longer than what it is made for. Answers are pickled, as those of other processes
are; a test of processes, or of what ends one, asks for the fixture `processes`.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from typing import Any

import pytest

from actspec.processes import FaultError


class Call:
    """In place of `IsolatedCall`."""

    def __init__(self, function: Callable[..., Any], *_: object) -> None:
        self._function = function

    def __enter__(self) -> Call:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def __call__(self, *arguments: object) -> Any:
        """The function's answer."""
        try:
            return pickle.loads(pickle.dumps(self._function(*arguments)))
        except Exception as err:
            fault = f"a fault of actspec, not of the file; please report it: {type(err).__name__}: {err}"
            raise FaultError(fault) from err


class Calls(Call):
    """In place of `Pool`."""

    def __init__(
        self, function: Callable[..., Any], tasks: Sequence[tuple[object, ...]], jobs: int | None = None
    ) -> None:
        super().__init__(function)
        # Now, as processes begin now: what is set round this counts for them.
        self._answers = [self._answer(task) for task in tasks]

    def add(self, *arguments: object) -> int:
        """One more call."""
        self._answers.append(self._answer(arguments))
        return len(self._answers) - 1

    def results(self) -> Iterator[tuple[int, Any]]:
        """Index and answer of each."""
        yield from enumerate(self._answers)

    def _answer(self, arguments: tuple[object, ...]) -> Any:
        try:
            return self(*arguments)
        except FaultError as err:
            return err


@contextmanager
def in_process() -> Iterator[None]:
    """Read files, and check fixes of them, in this process."""
    from actspec.robot.usda import layer_of

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("actspec.readings.named.Pool", Calls)
        patch.setattr("actspec.audit.fix.IsolatedCall", Call)
        if find_spec("pxr") is not None:
            patch.setattr("actspec.verify.readback.read_usda", layer_of)
        yield
