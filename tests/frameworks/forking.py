"""Probes without their imports: a process that has imported a simulator's packages forks for each probe.

    with forking():          # in the tests; `run_probe` is as before, seconds faster each time
        frameworks.run_probe(...)

Importing torch, warp, mjlab or Newton takes two to six seconds of a processor, most of what a probe takes, and a
test session starts some hundred probes. What a probe does still happens in a process of its own. Packages that a
probe chooses among, such as an older release beside the installed one, are not imported before it.
"""

from __future__ import annotations

import importlib
import json
import os
import runpy
import signal
import socket
import subprocess
import sys
import tempfile
import traceback
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

ISAACLAB = ("torch", "warp", "trimesh", "pxr.Usd", "pxr.UsdGeom")
"""What Isaac Lab's own package imports, of which there are several releases."""
MJLAB = ("torch", "mujoco", "mujoco_warp", "mjlab.actuator", "mjlab.entity", "mjlab.sim.sim")
MUJOCO = ("numpy", "mujoco")
"""A process for each release, which PYTHONPATH names."""
NEWTON = ("numpy", "warp", "newton")
"""Without torch: a probe of Newton runs as if there were none."""
PACKAGES: dict[str, tuple[str, ...]] = {
    "isaaclab_probe.py": ISAACLAB,
    "isaaclab_recorder_probe.py": ISAACLAB,
    "mjlab_delta_probe.py": MJLAB,
    "mjlab_probe.py": MJLAB,
    "mjlab_versions_probe.py": ("torch", "mujoco", "mujoco_warp", "mediapy", "trimesh", "viser"),
    "newton_probe.py": NEWTON,
    "overlap_probe.py": ISAACLAB,
    "probe_isaaclab.py": ISAACLAB,
    "probe_mjlab.py": MJLAB,
    "probe_newton.py": NEWTON,
    "randomization_isaaclab_probe.py": ISAACLAB,
    "randomization_mjlab_probe.py": MJLAB,
    "rollout_probe.py": MUJOCO,
    "training_probe.py": MJLAB,
}
"""Probe to what is imported before it, any other runs as it always does."""


def _packages(script: str, folder: str) -> tuple[str, ...]:
    packages = PACKAGES.get(os.path.basename(script), ())
    if packages == NEWTON and json.loads(Path(folder, "in.json").read_text(encoding="utf-8")).get("path"):
        return NEWTON[:-1]
    return packages


class Forker:
    """A process that has imported packages.

    Args:
        python: Its interpreter.
        packages: What it imports.
        environment: Its variables.
    """

    def __init__(self, python: str, packages: Sequence[str], environment: Mapping[str, str]) -> None:
        self.environment = dict(environment)
        here, there = socket.socketpair()
        with there:
            self._process = subprocess.Popen(
                [python, __file__, str(there.fileno()), *packages],
                env=self.environment,
                pass_fds=[there.fileno()],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                start_new_session=True,
            )
        self._socket = here
        self._lines = here.makefile("r", encoding="utf-8")

    def run(
        self, command: Sequence[str], folder: str, environment: Mapping[str, str], timeout: float
    ) -> subprocess.CompletedProcess[str]:
        """Run a script of the interpreter in a fork.

        Raises: TimeoutExpired: it takes longer; this process is of no more use.
        """
        with tempfile.TemporaryDirectory() as work:
            told = [os.path.join(work, name) for name in ("stdout", "stderr")]
            job = {"command": command[1:], "folder": folder, "environment": dict(environment), "told": told}
            self._socket.settimeout(timeout)
            try:
                self._socket.sendall(json.dumps(job).encode("utf-8") + b"\n")
                line = self._lines.readline()
            except TimeoutError as err:
                self.end()
                raise subprocess.TimeoutExpired(command, timeout) from err
            assert line, f"the process with {self._process.args} has ended: {self._process.wait()}"
            texts = [Path(path).read_text(encoding="utf-8", errors="replace") for path in told]
        return subprocess.CompletedProcess(command, int(line), *texts)

    def end(self) -> None:
        """End it, and a probe that still runs."""
        self._socket.close()
        os.killpg(self._process.pid, signal.SIGKILL)
        self._process.wait()


class _Subprocess:
    """In place of the module `subprocess` where probes are run."""

    DEVNULL = subprocess.DEVNULL
    TimeoutExpired = subprocess.TimeoutExpired

    def __init__(self) -> None:
        self.forkers: dict[tuple[str, tuple[str, ...], str], Forker] = {}

    def run(self, command: Sequence[str], **more: Any) -> subprocess.CompletedProcess[str]:
        """As `subprocess.run` with these arguments."""
        packages = _packages(command[1], str(more.get("cwd")))
        if not packages:
            return subprocess.run(command, **more)
        # Its first folder is that of one probe; behind it is what the probes of a release share.
        path = more["env"]["PYTHONPATH"].partition(os.pathsep)[2]
        key = command[0], packages, path
        try:
            if key not in self.forkers:
                self.forkers[key] = Forker(command[0], packages, {**more["env"], "PYTHONPATH": path})
            return self.forkers[key].run(command, str(more["cwd"]), more["env"], more["timeout"])
        except subprocess.TimeoutExpired:
            del self.forkers[key]
            raise


@contextmanager
def forking() -> Iterator[None]:
    """Have probes run in forks, where the system can; elsewhere nothing changes."""
    from actspec.verify import environments

    if not sys.platform.startswith("linux"):
        yield
        return
    stand_in = _Subprocess()
    environments.subprocess = stand_in  # type: ignore[assignment]
    try:
        yield
    finally:
        environments.subprocess = subprocess
        for forker in stand_in.forkers.values():
            forker.end()


def _fork(job: dict[str, Any]) -> int:
    """Exit status of a job's script, as `subprocess` gives it."""
    pid = os.fork()
    if pid:
        return os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    status = 1
    try:
        os.chdir(job["folder"])
        for number, path in enumerate(job["told"], 1):
            os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT), number)
        os.environ.clear()
        os.environ.update(job["environment"])
        script, *sys.argv[1:] = job["command"]
        sys.argv[0] = script
        # As Python begins, which read the variable of the process that forks.
        more = filter(None, job["environment"].get("PYTHONPATH", "").split(os.pathsep))
        sys.path[:1] = [os.path.dirname(script), *more]
        runpy.run_path(script, run_name="__main__")
        status = 0
    except SystemExit as err:
        status = err.code if isinstance(err.code, int) else int(err.code is not None)
        if isinstance(err.code, str):
            print(err.code, file=sys.stderr)
    except BaseException:
        traceback.print_exc()
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(status)


def _serve(descriptor: int, packages: Sequence[str]) -> None:
    """Import packages and run the jobs that come, one line of JSON each, until the other side has gone."""
    for package in packages:
        importlib.import_module(package)
    if "warp" in sys.modules:
        # Kernels run for milliseconds, and take seconds to compile.
        warp: Any = sys.modules["warp"]
        warp.config.optimization_level = 0
        # Three of them for the headers: the first fork that compiles anything leaves them to the others.
        warp.init()
        warp._src.context.runtime.get_clang_pch_dir()
    with socket.socket(fileno=descriptor) as connection:
        for line in connection.makefile("r", encoding="utf-8"):
            connection.sendall(f"{_fork(json.loads(line))}\n".encode())


if __name__ == "__main__":
    _serve(int(sys.argv[1]), sys.argv[2:])
