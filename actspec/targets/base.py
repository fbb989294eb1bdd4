"""What every target is: a pure function from an ActuatorSet and a robot to files and approximations."""

from __future__ import annotations

import hashlib
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from actspec.diagnostics import Collector, Diagnostic, Place, Span, one_line
from actspec.ir import Approximation
from actspec.robot.xml_edit import escape_attribute

__all__ = ["Approximation", "Emission", "EmittedFile", "TargetOptions", "relative_path"]

if TYPE_CHECKING:
    from actspec.spec.models import AnyTarget

T = TypeVar("T", bound="AnyTarget")


@dataclass(frozen=True, slots=True)
class TargetOptions:
    """How one target is to be compiled.

    Attributes:
        name: The target's name in the spec, also the name of its folder.
        kind: Kind of target, e.g. `mujoco`.
        version: Version of the simulator as text, e.g. `3.12`.
        spans: Where each option is written, by its name in the spec: `version`, `joint_order[3]`,
            `joint_paths[hip]`. What was chosen on the command line is not in it; None: nothing is written.
        folder: Folder that the files will be written to, for relative paths inside them.
        canonical: Write the simulator's own form of the model instead of the author's text (MuJoCo).
        given: What the spec states for this kind of target; None: nothing.
        siblings: MuJoCo and Isaac Lab targets of the same spec, for randomization.
    """

    name: str
    kind: str
    version: str
    spans: Mapping[str, Span] | None
    folder: str
    canonical: bool = False
    given: AnyTarget | None = None
    siblings: tuple[TargetOptions, ...] = ()

    @property
    def title(self) -> str:
        """What people call it: `mujoco 3.12`, or `bench (mujoco 3.12)` where it has a name of its own."""
        version = f"{self.kind} {self.version}".rstrip()
        return version if self.name == self.kind else f"{self.name} ({version})"

    def of(self, kind: type[T]) -> T:
        """The options of a kind of target, as its class in `spec.models` has them.

        Raises: TypeError: the target is of another kind.
        """
        found = kind() if self.given is None else self.given
        if not isinstance(found, kind):
            raise TypeError(f"{self.kind} has no options of {kind.__name__}")
        return found

    def where(self, option: str) -> str:
        """An option's place in the spec, for messages: `targets.isaaclab.version`."""
        return f"targets.{self.name}.{option}"

    def span(self, option: str) -> Span | None:
        """Where an option is written; None: nowhere."""
        return None if self.spans is None else self.spans.get(option)

    def at(self, option: str, collector: Collector) -> Place:
        """An option, and who collects what is reported of it."""
        return collector.at(self.where(option), self.span(option))


def relative_path(path: str, folder: str) -> str:
    """A path as one from a folder, with forward slashes, so that the file is the same on every system."""
    return os.path.relpath(os.path.abspath(path), os.path.abspath(folder)).replace(os.sep, "/")


class PathError(ValueError):
    """A file beside the model cannot be named in what is written; the text says why."""

    HELP = "rename the folder, or write below the model's own folder with -o"


def named_path(source: str, path: str, folder: str) -> str:
    """A path of a robot's file as one from the output folder.

    Args:
        source: Folder of the file.
        path: From there, as the file names it.
        folder: Of the output.

    Raises: PathError: it leads through a folder whose name XML cannot hold, or MuJoCo takes for several.
    """
    found = relative_path(os.path.join(source, path), folder)
    if "\\" in relative_path(os.path.join(source, path.replace("\\", "/")), folder):
        raise PathError(f"'{one_line(found)}' is no path to MuJoCo, which takes a backslash for a slash")
    try:
        escape_attribute(found)
    except ValueError:
        raise PathError(f"XML cannot hold the path '{one_line(found)}'") from None
    return found


@dataclass(frozen=True, slots=True)
class EmittedFile:
    """A file to write, by its path below the target's folder."""

    path: str
    data: bytes

    @property
    def sha256(self) -> str:
        """Hash of the bytes."""
        return hashlib.sha256(self.data).hexdigest()


NO_LIMIT = "SPEC166"
"""A drive is written without any limit of its torque, because nobody states one. `--strict` refuses it."""

NOT_LOADED = "MJC034"
"""A model is written that its simulator does not load, whatever is put beside it: the exit code says so, too."""


@dataclass(frozen=True, slots=True)
class Emission:
    """What a target made.

    Attributes:
        files: Files, the main one first.
        approximations: What was lost, joint by joint.
        diagnostics: Warnings and notes.
        explicit: Joints whose drive the simulator integrates explicitly.
        unlimited: Joints whose drive is written without any limit of its torque, because nobody states one.
    """

    files: tuple[EmittedFile, ...]
    approximations: tuple[Approximation, ...]
    diagnostics: tuple[Diagnostic, ...] = ()
    explicit: frozenset[str] = frozenset()
    unlimited: frozenset[str] = frozenset()
