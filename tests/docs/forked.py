"""`actspec` of the pages' consoles without its imports: a process that has them forks for each command.

    with server(environment) as address:
        client(address)    # the text of an `actspec` for PATH

Imports take a second of a processor, more than most commands do. A command is still a process of its own, with the
folder, variables, streams and exit status of the one that stands for it in the shell.
"""

from __future__ import annotations

import importlib
import json
import os
import pkgutil
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress

CLIENT = """#!{python} -IS
import json, os, socket, sys
with socket.socket(socket.AF_UNIX) as link:
    link.connect({address!r})
    job = {{"arguments": sys.argv[1:], "folder": os.getcwd(), "environment": dict(os.environ)}}
    told = json.dumps(job).encode() + b"\\n"
    sent = socket.send_fds(link, [told], [0, 1, 2])
    link.sendall(told[sent:])
    sys.exit(int(link.makefile().readline()))
"""


def client(address: str) -> str:
    """A program that has a command run."""
    return CLIENT.format(python=sys.executable, address=address)


@contextmanager
def server(environment: Mapping[str, str]) -> Iterator[str]:
    """A process that runs commands: where it is reached.

    Args:
        environment: Its variables, by which it finds actspec.
    """
    with tempfile.TemporaryDirectory(prefix="actspec-docs-") as folder, socket.socket(socket.AF_UNIX) as link:
        address = os.path.join(folder, "commands")
        link.bind(address)
        link.listen()
        process = subprocess.Popen(
            [sys.executable, __file__, str(link.fileno())],
            env=dict(environment),
            pass_fds=[link.fileno()],
            stdin=subprocess.DEVNULL,
        )
        # Its own: should the process end, nobody waits for it.
        link.close()
        try:
            yield address
        finally:
            process.terminate()
            process.wait()


def _serve(descriptor: int) -> None:
    import actspec

    for module in pkgutil.walk_packages(actspec.__path__, "actspec."):
        # Probes run elsewhere, beside what is not here.
        if ".probes" not in module.name and not module.name.endswith("__main__"):
            with suppress(ImportError):
                importlib.import_module(module.name)
    for package in ("mujoco", "scipy.signal"):
        with suppress(ImportError):
            importlib.import_module(package)
    with socket.socket(fileno=descriptor) as link:
        while True:
            connection, _ = link.accept()
            if os.fork() == 0:
                link.close()
                _handle(connection)
            connection.close()
            # Those that have ended.
            with suppress(ChildProcessError):
                while os.waitpid(-1, os.WNOHANG)[0]:
                    pass


def _handle(connection: socket.socket) -> None:
    """Run a command in one more process, and tell how it ended."""
    told, streams, *_ = socket.recv_fds(connection, 1 << 20, 3)
    while not told.endswith(b"\n"):
        told += connection.recv(1 << 20)
    job = json.loads(told)
    pid = os.fork()
    if pid == 0:
        connection.close()
        for number, stream in enumerate(streams):
            os.dup2(stream, number)
            os.close(stream)
        os.chdir(job["folder"])
        os.environ.clear()
        os.environ.update(job["environment"])
        sys.argv = ["actspec", *job["arguments"]]
        from actspec.__main__ import entry

        entry()
    for stream in streams:
        os.close(stream)
    status = os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1])
    # As a shell has it.
    connection.sendall(f"{status if status >= 0 else 128 - status}\n".encode())
    os._exit(0)


if __name__ == "__main__":
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    # This folder is of tests, whose names are not to be imported.
    del sys.path[0]
    _serve(int(sys.argv[1]))
