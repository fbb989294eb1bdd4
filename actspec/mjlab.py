"""Live mjlab objects from a spec, where mjlab is installed.

from actspec.mjlab import articulation
EntityCfg(spec_fn=get_spec, articulation=articulation("robots/a1.yaml"))
"""

from __future__ import annotations

import os
from typing import Any

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
    from actspec.live import network_files, run_module

    compiled = compile_spec(path, targets=[f"mjlab=={_installed_release()}"])
    names = run_module(compiled.emissions[0].files[0], path, "mjlab")
    # The text looks for networks beside itself, and it is nowhere: the spec's own files are the same.
    files = network_files(compiled)
    for value in names.values():
        cfg = getattr(value, "base_cfg", value)
        if hasattr(cfg, "network_file"):
            cfg.network_file = files[os.path.basename(cfg.network_file)]
    return names


def _installed_release() -> str:
    """The installed mjlab, as a version to compile for."""
    from actspec.live import distribution_version, find_package
    from actspec.simulators import newest_known
    from actspec.simulators.mjlab import RELEASES

    find_package("mjlab", "pip install mjlab")
    version = distribution_version("mjlab")
    if version is None:
        raise ModuleNotFoundError("the version of mjlab is unknown: install it with pip", name="mjlab")
    return newest_known(version, tuple(RELEASES))
