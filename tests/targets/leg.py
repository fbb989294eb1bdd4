"""A leg whose spec many targets' tests compile: two hinges and a slide, and no actuators."""

from __future__ import annotations

from actspec.ir import ActuatorSet
from actspec.resolution import resolve
from actspec.robot.load import listed_robot
from actspec.robot.view import RobotView
from actspec.spec.document import document_from_text
from actspec.spec.validate import validate
from actspec.targets.base import Approximation, Emission
from tests.compiling import MOTORS, spec_text, view_of

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

TIMING = "{physics_dt: 5 ms, decimation: 4}"
REST = 'unmanaged: ["calf", "rod"]'
"""A spec of the hip alone."""


def resolved(
    actuators: str,
    model: str | None = LEG,
    *,
    robot: str = REST,
    motors: str = MOTORS,
    timing: str = TIMING,
    path: str = "spec.yaml",
) -> tuple[ActuatorSet, RobotView]:
    """What the `actuators` of a spec mean on a robot, and the robot.

    Args:
        actuators: Lines, each indented by two.
        model: An MJCF; None: `robot` says `model: none` itself.
        robot: More keys of `robot`.
        motors: The spec's motors.
        timing: The spec's rates.
        path: Where the spec pretends to lie.
    """
    text = spec_text(actuators, robot=robot, motors=motors, timing=timing)
    if model is None:
        text = text.replace("model: robot.xml, ", "")
    spec = validate(document_from_text(text, path))
    view = listed_robot(spec) if model is None else view_of(model)
    return resolve(spec, view), view


def lost(emission: Emission, field: str) -> Approximation:
    """The one approximation of a field."""
    (found,) = [loss for loss in emission.approximations if loss.field == field]
    return found


def group(**fields: str) -> str:
    """One group `leg` of the hip with these fields, over `level: ideal_pd` and gains."""
    entries = {"joints": "[hip]", "level": "ideal_pd", "kp": "25 N*m/rad", "kd": "0.5 N*m*s/rad", **fields}
    return "  leg: {" + ", ".join(f"{key}: {value}" for key, value in entries.items() if value) + "}"
