"""Work on all cores."""

from __future__ import annotations

import os
import select
import sys
import threading
from pathlib import Path

import pytest

from actspec.audit import engine
from actspec.audit.build import case_of
from actspec.audit.engine import judge
from actspec.audit.read import read_files
from actspec.audit.settings import Settings
from actspec.audit.spread import spread

forks = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="no process is forked here")

ROBOT = """<mujoco>
  <worldbody><body><joint name="left_knee" damping="{damping}"/><geom size="0.1"/></body></worldbody>
  <actuator><position joint="left_knee" kp="{kp}" forcerange="0 0"/></actuator>
</mujoco>"""


@pytest.mark.parametrize("jobs", [0, 1, 2, 3, 9])
def test_results_are_in_order(jobs: int) -> None:
    """Whatever process has done it."""
    assert spread(lambda number: number**2, 7, jobs) == [0, 1, 4, 9, 16, 25, 36]


def test_nothing_to_do() -> None:
    """No process is started for nothing."""
    assert spread(lambda number: number, 0, 4) == []


@forks
def test_a_process_takes_what_another_has_not() -> None:
    """Whoever has taken the first number waits until all others are done, which another process must do."""
    done, doing = os.pipe()

    def work(number: int) -> int:
        if number == 0:
            for _ in range(3):
                ready, _, _ = select.select([done], [], [], 60.0)
                assert ready, "nobody else takes numbers"
                os.read(done, 1)
        else:
            os.write(doing, b".")
        return os.getpid()

    first, *others = spread(work, 4, 2)
    assert first not in others
    assert len(set(others)) == 1
    assert os.getpid() in (first, *others)
    os.close(done)
    os.close(doing)


@forks
def test_more_numbers_than_a_pipe_holds() -> None:
    """They are done here, and nothing waits for ever."""
    assert spread(lambda number: number, 70_000, 2) == list(range(70_000))


@forks
@pytest.mark.parametrize("count", [2, 300, 2048])
def test_each_number_is_done_once(count: int) -> None:
    """By one process or the other; 300 is more than a byte holds."""
    assert spread(lambda number: number, count, 3) == list(range(count))


@forks
def test_nothing_is_left_open() -> None:
    """Neither pipes nor processes."""
    spread(lambda number: number, 9, 3)
    before = set(os.listdir("/proc/self/fd"))
    spread(lambda number: number, 9, 3)
    assert set(os.listdir("/proc/self/fd")) == before


@forks
def test_the_share_of_a_process_that_dies_is_done_here() -> None:
    """Its end is no end of the others."""
    here = os.getpid()

    def work(number: int) -> int:
        if number == 1 and os.getpid() != here:
            os._exit(3)
        return 10 * number

    assert spread(work, 5, 2) == [0, 10, 20, 30, 40]


@forks
def test_an_exception_is_that_of_the_work() -> None:
    """A process that an exception ended is done again here, where it is seen."""

    def work(number: int) -> int:
        return 1 // (1 - number)

    with pytest.raises(ZeroDivisionError):
        spread(work, 2, 2)


@forks
def test_beside_other_threads_everything_is_done_here() -> None:
    """A fork would copy the locks that they hold."""
    stop = threading.Event()
    thread = threading.Thread(target=stop.wait)
    thread.start()
    try:
        assert set(spread(lambda _: os.getpid(), 4, 2)) == {os.getpid()}
    finally:
        stop.set()
        thread.join()


@forks
def test_all_cores_find_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Findings, skipped rules and their order do not depend on the number of processes."""
    names = []
    for index, (kp, damping) in enumerate(((20, 1), (20, 0.5), (1146, 0.5))):
        path = tmp_path / f"robot_{index}.xml"
        path.write_text(ROBOT.format(kp=kp, damping=damping))
        names.append(str(path))
    settings = Settings()
    case = case_of(read_files(names), settings.versions, settings.options)
    reports = []
    for rows, cores in ((4, 4), (3, 1), (3, 2), (3, 4)):
        monkeypatch.setattr(engine, "ROWS_TO_SPREAD", rows)
        monkeypatch.setattr(engine, "cores", lambda cores=cores: cores)
        reports.append(judge(case, settings))
    # An effort limit of 0 in each file, and a kp that is 57.3 times another.
    assert {"LIM103", "UNT103"} <= {item.finding.code for item in reports[0].findings}
    assert all(report == reports[0] for report in reports[1:])
