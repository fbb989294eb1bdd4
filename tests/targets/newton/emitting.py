"""Compile a spec's text for Newton, and read the overlay back without USD."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import pytest

from actspec.diagnostics import EmitError
from actspec.ir import ActuatorSet
from actspec.resolution import resolve
from actspec.robot.load import listed_robot
from actspec.robot.view import RobotView
from actspec.spec.document import document_from_text
from actspec.spec.validate import validate
from actspec.targets.base import Approximation, Emission
from actspec.targets.newton.emit import emit
from tests.compiling import MOTORS, spec_text, target_options, view_of

LEG = """<mujoco model="leg">
  <compiler angle="radian"/>
  <worldbody>
    <body name="trunk">
      <freejoint name="base"/>
      <geom size="0.1"/>
      <body name="thigh">
        <joint name="hip" axis="0 1 0" range="-1 1" armature="0.003" frictionloss="0.04" damping="0.1"/>
        <geom size="0.1"/>
        <body name="shank">
          <joint name="calf" axis="0 1 0" range="-2 -0.5"/>
          <geom size="0.1"/>
          <body name="foot">
            <joint name="rod" type="slide" axis="0 0 1" range="-0.1 0.2"/>
            <geom size="0.1"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>"""
"""A leg with two hinges and a slide, and no actuators."""

TIMING = "{physics_dt: 5 ms, decimation: 4}"
REST = 'unmanaged: ["calf", "rod"]'
"""A spec of the hip alone."""

ROOT = "/leg"
THIGH = "/leg/Geometry/trunk/thigh"


@dataclass(frozen=True)
class Written:
    """A spec compiled for Newton.

    Attributes:
        actuators: What it means.
        robot: Its robot.
        emission: What was written.
    """

    actuators: ActuatorSet
    robot: RobotView
    emission: Emission

    @property
    def text(self) -> str:
        """The overlay."""
        return self.emission.files[0].data.decode("utf-8")

    @property
    def prims(self) -> dict[str, dict[str, Any]]:
        """Every prim by its path: `is` its first words, `apis`, and each attribute's text."""
        return parsed(self.text)

    def attributes(self, path: str) -> dict[str, Any]:
        """A prim's numbers by their names, and other attributes as text."""
        return {k: v for k, v in self.prims[path].items() if k not in ("is", "apis", "active")}

    def lost(self, field: str) -> Approximation:
        """The one approximation of a field."""
        (found,) = [loss for loss in self.emission.approximations if loss.field == field]
        return found


def parsed(text: str) -> dict[str, dict[str, Any]]:
    """The prims of an overlay as actspec lays it out: one thing a line."""
    found: dict[str, dict[str, Any]] = {}
    path: list[str] = []
    for line in text.splitlines():
        bare = line.strip()
        prim = re.fullmatch(r'(over|def \w+) "((?:[^"\\]|\\.)*)"( \()?', bare)
        attribute = re.fullmatch(r"(\w+) ([\w:]+) = (.*?)(?:  # .*)?", bare)
        if prim:
            path.append(prim[2])
            found["/" + "/".join(path)] = {"is": prim[1], "apis": []}
        elif bare == "}" and path:
            path.pop()
        elif bare.startswith("prepend apiSchemas"):
            found["/" + "/".join(path)]["apis"] = re.findall(r'"([^"]*)"', bare)
        elif bare == "active = false":
            found["/" + "/".join(path)]["active"] = False
        elif attribute and path:
            number = attribute[1] in ("float", "int")
            found["/" + "/".join(path)][attribute[2]] = float(attribute[3]) if number else attribute[3]
    assert not path
    return found


def written(
    actuators: str,
    model: str | None = LEG,
    version: str = "1.8",
    *,
    robot: str = REST,
    motors: str = MOTORS,
    timing: str = TIMING,
    path: str = "spec.yaml",
    **options: Any,
) -> Written:
    """Compile the `actuators` of a spec.

    Args:
        actuators: Lines, each indented by two.
        model: An MJCF; None: `robot` says `model: none` itself.
        version: Of Newton.
        robot: More keys of `robot`.
        motors: The spec's motors.
        timing: The spec's rates.
        path: Where the spec pretends to lie.
        options: More of the target's options.

    Raises: EmitError: with what is wrong.
    """
    text = spec_text(actuators, robot=robot, motors=motors, timing=timing)
    if model is None:
        text = text.replace("model: robot.xml, ", "")
    spec = validate(document_from_text(text, path))
    view = listed_robot(spec) if model is None else view_of(model)
    return emitted(resolve(spec, view), view, version, **options)


def emitted(actuators: ActuatorSet, view: RobotView, version: str = "1.8", **options: Any) -> Written:
    """Actuators, compiled."""
    options |= {"joint_paths": dict(options.get("joint_paths", ()))}
    target = target_options("newton", version, **options)
    return Written(actuators, view, emit(actuators, view, target))


def refused(actuators: str, model: str | None = LEG, version: str = "1.8", **rest: Any) -> list[str]:
    """What the target says against a spec: `CODE where: message`."""
    with pytest.raises(EmitError) as caught:
        written(actuators, model, version, **rest)
    return [f"{d.code} {d.where}: {d.message}" for d in caught.value.diagnostics]


def group(**fields: str) -> str:
    """One group `leg` of the hip with these fields, over `level: ideal_pd` and gains."""
    entries = {"joints": "[hip]", "level": "ideal_pd", "kp": "25 N*m/rad", "kd": "0.5 N*m*s/rad", **fields}
    return "  leg: {" + ", ".join(f"{key}: {value}" for key, value in entries.items() if value) + "}"
