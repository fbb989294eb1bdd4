"""Modules that stand where Isaac Sim's would, for probes: every name of theirs is there, and does nothing."""

from __future__ import annotations

import importlib.abc
import importlib.machinery
import sys
import types
from typing import Any, ClassVar

STAND_INS = (
    "omni",
    "isaacsim",
    "carb",
    "usdrt",
    "pxr",
    "hid",
    "toml",
    "gymnasium",
    "trimesh",
    "h5py",
    "flatdict",
)


class Name(type):
    """A name of a stand-in: a class, whose every name is one too."""

    def __getattr__(cls, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        return Name(name, (), {"__init__": lambda self, *a, **k: None, "__getattr__": Name.nothing})

    @staticmethod
    def nothing(instance: object, name: str) -> Any:
        """What an instance answers to a method: an empty text."""
        if name.startswith("__"):
            raise AttributeError(name)
        return lambda *arguments, **named: ""


class Anything(types.ModuleType):
    """A module that has every name."""

    __path__: ClassVar[list[str]] = []

    def __getattr__(self, name: str) -> Any:
        return getattr(Name(self.__name__, (), {}), name)


class Finder(importlib.abc.MetaPathFinder, importlib.abc.Loader):
    """Stand-ins for what is not installed; asked last."""

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> Any:
        if name.partition(".")[0] in STAND_INS:
            return importlib.machinery.ModuleSpec(name, self, is_package=True)
        return None

    def create_module(self, spec: Any) -> types.ModuleType:
        return Anything(spec.name)

    def exec_module(self, module: types.ModuleType) -> None:
        pass


def package(name: str, path: str) -> types.ModuleType:
    """A package whose own `__init__`, which starts the simulator's extensions, is passed over."""
    module = types.ModuleType(name)
    module.__path__ = [path]
    sys.modules[name] = module
    return module
