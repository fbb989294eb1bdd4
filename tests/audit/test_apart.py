"""A function in another process: its answers, its faults, its death."""

from __future__ import annotations

import faulthandler
import os
import time

import pytest

from actspec.audit.apart import Apart, LostError

pytestmark = pytest.mark.skipif(os.name == "nt", reason="signals")


def act(what: str) -> tuple[int, str]:
    """Answer with the process, or end as the word says."""
    faulthandler.disable()  # pytest's would tell of every death that is meant
    if what.startswith("signal"):
        os.kill(os.getpid(), int(what.removeprefix("signal")))
    if what == "exit":
        os._exit(3)
    if what == "sleep":
        time.sleep(60)
    if what == "fault":
        raise KeyError("x")
    if what == "memory":
        raise MemoryError
    return os.getpid(), what


@pytest.mark.parametrize(
    "what, reason",
    [
        ("signal11", "MuJoCo crashed on it (signal 11)"),
        ("signal9", "the process that read it was killed (signal 9), perhaps for its use of memory"),
        ("exit", "MuJoCo ended the process that read it"),
        ("sleep", "MuJoCo took longer than 0.5 s for it"),
        ("fault", "a fault of actspec; please report it: KeyError: 'x'"),
        ("memory", "there is not enough memory for it"),
    ],
    ids=["crash", "kill", "exit", "hang", "exception", "memory"],
)
def test_a_call_that_does_not_return(what: str, reason: str) -> None:
    """It says how it ended, and the next call has an answer."""
    with Apart(act, limit=0.5) as apart:
        with pytest.raises(LostError, match="^" + reason.replace("(", r"\(").replace(")", r"\)") + "$"):
            apart(what)
        assert apart("a")[1] == "a"


def test_calls_share_a_process_that_is_not_ours() -> None:
    """One process answers all calls, and ends with the block."""
    with Apart(act) as apart:
        process, _ = apart("a")
        assert apart("b") == (process, "b")
        assert process != os.getpid()
    deadline = time.monotonic() + 10.0
    while time.monotonic() < deadline:
        try:
            os.kill(process, 0)
        except ProcessLookupError:
            return
    pytest.fail("the process is still there")
