"""Asking a simulator in the prepared environment: its probe, in a process of its own."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from actspec.diagnostics import shortened
from actspec.verify.engines.question import EngineMissing, EngineRefused, not_prepared
from actspec.verify.frameworks import Frameworks, find, unusable
from actspec.verify.releases import EngineError


def prepared(engine: str) -> Frameworks:
    """The environment with the simulators.

    Args:
        engine: Name and release of the one that is asked for.

    Raises: EngineMissing: it is not prepared, or no release is for this machine.
    """
    why = unusable()
    if why is not None:
        raise EngineMissing(why)
    frameworks = find()
    if frameworks is None:
        raise not_prepared(engine)
    return frameworks


def probed(
    frameworks: Frameworks, probe: Path, job: Mapping[str, Any], arrays: Mapping[str, Any]
) -> tuple[Any, dict[str, Any]]:
    """What a probe says to a job, and its arrays.

    Raises: EngineRefused: the package does not take the file, or the probe died.
    """
    try:
        said, out = frameworks.run_probe(probe, job, arrays)
    except EngineError as err:
        raise EngineRefused(shortened(str(err), 300)) from err
    if "error" in said:
        raise EngineRefused(shortened(said["error"], 300))
    return said, out
