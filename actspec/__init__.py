"""actspec: a declarative config compiler for robot actuators."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from actspec.api import Compilation, compile, load, resolve, sample
    from actspec.recorder import Recorder

__version__ = "0.1.0"

__all__ = ["Compilation", "Recorder", "__version__", "compile", "load", "resolve", "sample"]


def __getattr__(name: str) -> Any:
    # On first use: `import actspec` stays light, and imports neither mujoco nor pydantic.
    if name in __all__:
        from importlib import import_module

        return getattr(import_module("actspec.recorder" if name == "Recorder" else "actspec.api"), name)
    raise AttributeError(f"module 'actspec' has no attribute {name!r}")
