"""Libraries that cannot be imported: which one it is, and how it is installed."""

from __future__ import annotations

import os
import re
import traceback
from contextlib import suppress
from types import TracebackType

_PACKAGE = os.path.dirname(os.path.abspath(__file__)) + os.sep
_DISTRIBUTIONS = {"yaml": "pyyaml", "pxr": "usd-core", "google": "protobuf"}
"""Package to the name that it is installed by, where they differ."""


def missing_package(fault: ImportError) -> str:
    """The package that could not be imported, also where the exception does not name it."""
    return (fault.name or _imported(fault.__traceback__)).split(".")[0]


def install_line(package: str) -> str:
    """What to type to have it: the extra of actspec that brings it, or it alone."""
    from importlib.metadata import PackageNotFoundError, requires

    name = _DISTRIBUTIONS.get(package, package)
    with suppress(PackageNotFoundError):
        for line in requires("actspec") or ():
            extra = re.search(r"extra == ['\"](\w+)", line)
            if extra and re.match(rf"{re.escape(name)}(?![\w.-])", line):
                return f"python -m pip install 'actspec[{extra[1]}]'"
    return f"python -m pip install --force-reinstall {name}"


def extra_line(extra: str) -> str:
    """What to type to have an extra of actspec, such as `sysid`; its name alone is found only where it is installed."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        version("actspec")
    except PackageNotFoundError:
        return f"pip install '.[{extra}]' in the clone of actspec"
    return f"pip install 'actspec[{extra}]'"


def is_ours(file: str) -> bool:
    """Whether a source file is one of actspec's."""
    return os.path.abspath(file).startswith(_PACKAGE)


def _imported(trace: TracebackType | None) -> str:
    """The package that our own code was importing."""
    ours = False
    for frame, _ in traceback.walk_tb(trace):
        file = frame.f_code.co_filename
        if file.startswith("<frozen"):
            continue
        if ours and not is_ours(file):
            return str(frame.f_globals.get("__name__", "a library"))
        ours = is_ours(file)
    return "a library"
