"""Compile a spec's text against a model's text, all in memory; what many tests begin with."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from actspec.ir import ActuatorSet
from actspec.resolution import resolve
from actspec.robot.read_mjcf import read_mjcf
from actspec.robot.view import ModelFile, RobotView
from actspec.spec.document import document_from_text
from actspec.spec.models import KINDS
from actspec.spec.validate import validate
from actspec.targets.base import Emission, TargetOptions
from actspec.targets.mujoco.emit import emit

if TYPE_CHECKING:
    import mujoco

FOLDER = os.path.abspath(os.path.join(os.sep, "models"))
"""Where the model pretends to lie; nothing is there."""

MOTORS = """
  line: {side: joint, stall_torque: 45 N*m, no_load_speed: 30 rad/s, peak_torque: 24 N*m, bandwidth: 30 Hz}
  line_s: {side: joint, stall_torque: 300 N, no_load_speed: 2 m/s, peak_torque: 150 N}
  curve:
    side: joint
    curve: {drive_torque: 20 N*m, brake_torque: 25 N*m, knee_speed: 14 rad/s, no_load_speed: 30 rad/s}
"""
"""A hinge's motor, a slide's motor and one with an asymmetric curve, L below the stall torque."""


@dataclass(frozen=True, slots=True)
class Compiled:
    """A spec compiled to MuJoCo.

    Attributes:
        robot: The model, read.
        actuators: What the spec means on it.
        emission: What was written.
    """

    robot: RobotView
    actuators: ActuatorSet
    emission: Emission

    @property
    def text(self) -> str:
        """The main file."""
        return self.emission.files[0].data.decode("utf-8")

    @property
    def files(self) -> dict[str, str]:
        """Every file that was written, by name."""
        return {file.path: file.data.decode("utf-8") for file in self.emission.files}

    @property
    def codes(self) -> list[str]:
        """Codes of the warnings and notes."""
        return [item.code for item in self.emission.diagnostics]

    @property
    def model(self) -> mujoco.MjModel:
        """The main file, compiled by the installed MuJoCo."""
        import mujoco

        return mujoco.MjModel.from_xml_string(self.text)

    def element(self, name: str) -> str:
        """The written tag of an actuator, from `<` to `>`."""
        at = self.text.index(f' name="{name}"', self.text.index("<actuator"))
        return self.text[self.text.rindex("<", 0, at) : self.text.index(">", at) + 1]


def spec_text(actuators: str, *, robot: str = "", motors: str = MOTORS, timing: str = "{}") -> str:
    """A spec around the lines of its `actuators`, each indented by two."""
    return f"""actspec: 1
robot: {{name: probe, model: robot.xml, {robot}}}
timing: {timing}
motors:{motors}
actuators:
{actuators}
"""


def view_of(model: str | bytes, *, includes: dict[str, str] | None = None, folder: str = FOLDER) -> RobotView:
    """An MJCF's text as a robot.

    Args:
        model: The main file.
        includes: Includes in document order, by the text that names them.
        folder: Where the files pretend to lie.
    """
    data = model.encode("utf-8") if isinstance(model, str) else model
    files = [ModelFile(os.path.join(folder, "robot.xml"), "", data)]
    files += [ModelFile(os.path.join(folder, n), n, t.encode("utf-8")) for n, t in (includes or {}).items()]
    return read_mjcf(tuple(files))


def installed() -> str:
    """Version of the installed MuJoCo, e.g. `3.12`."""
    import mujoco

    return ".".join(mujoco.__version__.split(".")[:2])


def options(version: str, *, folder: str | None = None, canonical: bool = False) -> TargetOptions:
    """The MuJoCo target at a version, beside the model unless a folder is named."""
    return TargetOptions("mujoco", "mujoco", version, None, folder or os.path.join(FOLDER, "out"), canonical)


@lru_cache(maxsize=64)
def _resolved(
    text: str, model: str | bytes, includes: tuple[tuple[str, str], ...]
) -> tuple[RobotView, ActuatorSet]:
    """A spec's robot and what it means there, the same for every version that it is compiled for."""
    view = view_of(model, includes=dict(includes))
    return view, resolve(validate(document_from_text(text)), view)


def compile_text(
    actuators: str,
    model: str | bytes,
    version: str | None = None,
    *,
    robot: str = "",
    motors: str = MOTORS,
    timing: str = "{}",
    includes: dict[str, str] | None = None,
    canonical: bool = False,
) -> Compiled:
    """Compile the `actuators` of a spec against a model, for the installed MuJoCo unless a version is named.

    Raises: ActspecError: the stage that fails, with its diagnostics.
    """
    text = spec_text(actuators, robot=robot, motors=motors, timing=timing)
    view, resolved = _resolved(text, model, tuple((includes or {}).items()))
    return Compiled(
        view, resolved, emit(resolved, view, options(version or installed(), canonical=canonical))
    )


def target_options(
    kind: str,
    version: str = "",
    *,
    name: str = "",
    folder: str = "out",
    siblings: tuple[TargetOptions, ...] = (),
    **given: Any,
) -> TargetOptions:
    """A target with options of its kind, by the names of their class's fields; unchecked, as a caller may give them."""
    options = KINDS[kind].model_construct(**given)
    return TargetOptions(name or kind, kind, version, None, folder, given=options, siblings=siblings)
