"""The command `actspec` of a shell without its imports: a process that has imported them forks for each call.

    with shell(folder, environment) as path:    # a script that does what `actspec` does, with its arguments
        subprocess.run(["bash", "-c", f"{path} validate spec.yaml"])

The pages show a hundred commands; numpy, SciPy, MuJoCo and PyTorch take up to three seconds of a processor to import.
What a command does still happens in a process of its own, with the caller's folder, variables, input and output.
"""

from __future__ import annotations

import importlib
import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import NoReturn

PACKAGES = ("numpy", "mujoco", "scipy.optimize", "scipy.signal", "torch", "actspec.api", "actspec.cli.main")

CLIENT = """\
#!%s -IS
import json, os, socket, sys

told = json.dumps([sys.argv[1:], os.getcwd(), dict(os.environ)]).encode()
with socket.socket(socket.AF_UNIX) as there:
    there.connect(%r)
    socket.send_fds(there, [b"-"], [0, 1, 2])
    there.sendall(told + b"\\n")
    code = there.makefile().readline()
sys.exit(int(code))
"""


@contextmanager
def shell(folder: Path, environment: Mapping[str, str]) -> Iterator[Path]:
    """A script `actspec`, while the context is open.

    Args:
        folder: Where it is put.
        environment: Of the process that forks.
    """
    at, script = folder / "socket", folder / "actspec"
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(str(at))
        listening.listen()
        process = subprocess.Popen(
            [sys.executable, __file__, str(listening.fileno())],
            env=dict(environment),
            pass_fds=[listening.fileno()],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            start_new_session=True,
        )
    script.write_text(CLIENT % (sys.executable, str(at)), encoding="utf-8")
    script.chmod(0o755)
    try:
        yield script
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()


def _answer(caller: socket.socket) -> None:
    """Run one command in a process of its own, and say how it ended."""
    _, descriptors, _, _ = socket.recv_fds(caller, 1, 3)
    arguments, folder, environment = json.loads(caller.makefile().readline())
    child = os.fork()
    if not child:
        caller.close()
        _become(descriptors, arguments, folder, environment)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    caller.sendall(f"{status if status >= 0 else 128 - status}\n".encode())


def _become(
    descriptors: list[int], arguments: list[str], folder: str, environment: dict[str, str]
) -> NoReturn:
    """This process is `python -m actspec` from here on."""
    for number, descriptor in enumerate(descriptors):
        os.dup2(descriptor, number)
        os.close(descriptor)
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    from actspec import __main__ as program

    sys.argv = [str(program.__file__), *arguments]
    program.entry()


def _serve(descriptor: int) -> None:
    """Take calls, one process for each."""
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    for package in PACKAGES:
        importlib.import_module(package)
    with socket.socket(fileno=descriptor) as listening:
        answering: set[int] = set()
        while True:
            caller, _ = listening.accept()
            answering -= {one for one in answering if os.waitpid(one, os.WNOHANG)[0]}
            child = os.fork()
            if not child:
                listening.close()
                _answer(caller)
                os._exit(0)
            answering.add(child)
            caller.close()


if __name__ == "__main__":
    _serve(int(sys.argv[1]))
