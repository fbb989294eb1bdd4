"""Live mjlab objects from a spec, where mjlab is installed.

from actspec.mjlab import articulation
EntityCfg(spec_fn=get_spec, articulation=articulation("robots/a1.yaml"))
"""

from __future__ import annotations

import os
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from actspec.targets.base import EmittedFile

__all__ = ["articulation", "module"]


def articulation(path: str | os.PathLike[str]) -> Any:
    """A spec's actuators as mjlab's `EntityArticulationInfoCfg`.

    The module that `actspec compile` writes is made for the installed mjlab and run in memory; no file is
    written, and nothing but that text is executed. A model with actuators of its own also needs its
    `prepare_spec`: see `module`.

    Args:
        path: The spec.

    Raises:
        ModuleNotFoundError: mjlab is not installed, or lacks what it needs itself.
        ActspecError: the spec does not compile, or actspec does not know the installed mjlab.
    """
    names = module(path)
    return next(value for name, value in names.items() if name.endswith("_ARTICULATION"))


def module(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Everything that the emitted module defines: the articulation, `prepare_spec`, action scales.

    Args:
        path: The spec.

    Returns: value by name.

    Raises: as `articulation`.
    """
    from actspec.api import compile as compile_spec

    compiled = compile_spec(path, targets=[f"mjlab=={installed_version()}"])
    names = _run(compiled.emissions[0].files[0], os.fspath(path))
    # The text looks for networks beside itself, and it is nowhere: the spec's own files are the same.
    files = {
        os.path.basename(actuator.network.file): os.path.abspath(actuator.network.file)
        for actuator in compiled.actuators.joints
        if actuator.network is not None
    }
    for value in names.values():
        cfg = getattr(value, "base_cfg", value)
        if hasattr(cfg, "network_file"):
            cfg.network_file = files[os.path.basename(cfg.network_file)]
    return names


def installed_version() -> str:
    """The installed mjlab, as a version to compile for; one that is newer than the table counts as its last.

    Raises:
        ModuleNotFoundError: there is none.
    """
    from importlib.metadata import version

    from actspec.targets.mjlab.versions import MJLAB_RELEASES

    if find_spec("mjlab") is None:
        raise ModuleNotFoundError(
            "mjlab is not installed here: pip install mjlab, or write the module with"
            " `actspec compile --target mjlab`",
            name="mjlab",
        )
    text = ".".join(version("mjlab").split(".")[:2])
    numbers = tuple(int(part) for part in text.split(".") if part.isdigit())
    return "{}.{}".format(*MJLAB_RELEASES[-1]) if numbers > MJLAB_RELEASES[-1] else text


def _run(file: EmittedFile, spec: str) -> dict[str, Any]:
    title = f"<{file.path} of {os.path.basename(spec)}>"
    names: dict[str, Any] = {"__name__": file.path.removesuffix(".py"), "__file__": os.path.abspath(spec)}
    try:
        exec(compile(file.data, title, "exec"), names)
    except ImportError as err:
        raise ModuleNotFoundError(f"mjlab is installed here, but cannot be imported: {err}") from err
    return names
