"""What `actspec.mjlab` and `actspec.isaaclab` share: which release is installed, and the emitted module, run."""

from __future__ import annotations

import os
import sys
from importlib import metadata
from importlib.machinery import ModuleSpec
from importlib.util import find_spec
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from actspec.output import Compilation
    from actspec.targets.base import EmittedFile


def find_package(name: str, remedy: str) -> ModuleSpec:
    """Where a framework's package is, without importing it.

    Args:
        name: The package, which is also the kind of target that is made for it.
        remedy: How to install it.

    Raises:
        ModuleNotFoundError: it is not installed.
    """
    found = find_spec(name)
    if found is None:
        raise ModuleNotFoundError(
            f"{name} is not installed here: {remedy}, or write the module with"
            f" `actspec compile --target {name}`",
            name=name,
        )
    return found


def distribution_version(name: str) -> str | None:
    """The version that an installed distribution's metadata states; None without any."""
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None


def run_module(
    file: EmittedFile, spec: str | os.PathLike[str], package: str, remedy: str = ""
) -> dict[str, Any]:
    """Execute an emitted module in memory.

    It stays among `sys.modules`, where dataclasses and frameworks look up the classes that it defines, under a
    name of its text alone: the same spec gives the same name in every process.

    Args:
        file: The module.
        spec: The spec that it was made of; the module takes its place for its own.
        package: What it imports.
        remedy: What to do where that fails.

    Returns: value by name.

    Raises:
        ModuleNotFoundError: the package, or what it needs itself, cannot be imported.
    """
    title = f"<{file.path} of {os.path.basename(os.fspath(spec))}>"
    name = f"_actspec_{file.path.removesuffix('.py')}_{file.sha256[:12]}"
    module = ModuleType(name)
    module.__file__ = os.path.abspath(spec)
    sys.modules[name] = module
    try:
        exec(compile(file.data, title, "exec"), vars(module))
    except BaseException as err:
        del sys.modules[name]
        if isinstance(err, ImportError):
            message = f"{package} is installed here, but cannot be imported: {err}"
            raise ModuleNotFoundError("; ".join(filter(None, (message, remedy)))) from err
        raise
    return dict(vars(module))


def network_files(compiled: Compilation) -> dict[str, str]:
    """Absolute paths of the spec's networks, by the names that they have beside the emitted module.

    Args:
        compiled: One target, compiled.
    """
    from actspec.readings.networks import network_paths

    paths = {
        os.path.abspath(path)
        for actuator in compiled.actuators.joints
        if actuator.network is not None
        for path in network_paths(actuator.network).values()
    }
    own = {}
    for path in sorted(paths):
        with open(path, "rb") as file:
            own[file.read()] = path
    return {file.path: own[file.data] for file in compiled.emissions[0].files[1:]}
