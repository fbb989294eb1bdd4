"""Compile a spec's text for mjlab, and read the module back without running it."""

from __future__ import annotations

import ast
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
from actspec.targets.base import Approximation, Emission, TargetOptions
from actspec.targets.mjlab.emit import emit
from tests.compiling import MOTORS, spec_text, view_of

LEG = """<mujoco>
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


@dataclass(frozen=True)
class Written:
    """A spec compiled for mjlab.

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
        """The module."""
        return self.emission.files[0].data.decode("utf-8")

    @property
    def constants(self) -> dict[str, Any]:
        """Every constant: a call as (class, fields), a dict or tuple as it is."""
        found = {}
        for node in ast.parse(self.text).body:
            if isinstance(node, ast.AnnAssign | ast.Assign) and node.value is not None:
                target = node.target if isinstance(node, ast.AnnAssign) else node.targets[0]
                assert isinstance(target, ast.Name)
                found[target.id] = _value(node.value)
        return found

    @property
    def cfgs(self) -> dict[str, tuple[str, dict[str, Any]]]:
        """Every actuator cfg, by its constant."""
        return {name: value for name, value in self.constants.items() if "_ACTUATOR" in name}

    @property
    def cfg(self) -> tuple[str, dict[str, Any]]:
        """The one actuator cfg: class and fields without names of joints."""
        ((kind, fields),) = self.cfgs.values()
        return kind, {name: value for name, value in fields.items() if name != "target_names_expr"}

    def lost(self, field: str) -> Approximation:
        """The one approximation of a field."""
        (found,) = [loss for loss in self.emission.approximations if loss.field == field]
        return found


def _value(node: ast.expr) -> Any:
    if isinstance(node, ast.Call):
        if isinstance(node.func, ast.Name) and node.keywords:
            return node.func.id, {str(k.arg): _value(k.value) for k in node.keywords}
        return ast.unparse(node)
    try:
        return ast.literal_eval(node)
    except ValueError:
        return ast.unparse(node)


def written(
    actuators: str,
    model: str | None = LEG,
    version: str = "1.6",
    *,
    robot: str = REST,
    motors: str = MOTORS,
    timing: str = TIMING,
    path: str = "spec.yaml",
) -> Written:
    """Compile the `actuators` of a spec.

    Args:
        actuators: Lines, each indented by two.
        model: An MJCF; None: `robot` says `model: none` itself.
        version: Of mjlab.
        robot: More keys of `robot`.
        motors: The spec's motors.
        timing: The spec's rates.
        path: Where the spec pretends to lie.

    Raises: EmitError: with what is wrong.
    """
    text = spec_text(actuators, robot=robot, motors=motors, timing=timing)
    if model is None:
        text = text.replace("model: robot.xml, ", "")
    spec = validate(document_from_text(text, path))
    view = listed_robot(spec) if model is None else view_of(model)
    resolved = resolve(spec, view)
    return Written(
        resolved, view, emit(resolved, view, TargetOptions("mjlab", "mjlab", version, None, "out"))
    )


def refused(actuators: str, model: str | None = LEG, version: str = "1.6", **rest: Any) -> list[str]:
    """What the target says against a spec: `CODE where: message`."""
    with pytest.raises(EmitError) as caught:
        written(actuators, model, version, **rest)
    return [f"{d.code} {d.where}: {d.message}" for d in caught.value.diagnostics]


def group(**fields: str) -> str:
    """One group `leg` of the hip with these fields, over `level: ideal_pd` and gains."""
    entries = {"joints": "[hip]", "level": "ideal_pd", "kp": "25 N*m/rad", "kd": "0.5 N*m*s/rad", **fields}
    return "  leg: {" + ", ".join(f"{key}: {value}" for key, value in entries.items() if value) + "}"
