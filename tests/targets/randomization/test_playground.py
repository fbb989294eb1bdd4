"""The Playground function, run with the real MJX on models that the MuJoCo target wrote; needs jax."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from actspec.laws import law_of
from actspec.targets.base import TargetOptions
from actspec.targets.randomization.emit import emit
from actspec.targets.randomization.sizes import strengthened
from tests.compiling import compile_text, installed

jax = pytest.importorskip("jax")
mjx = pytest.importorskip("mujoco.mjx")

ENVS = 400

MODEL = """<mujoco model="leg">
  <worldbody>
    <body>
      <inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>
      <joint name="hip" axis="0 1 0" armature="0.01" frictionloss="0.2" damping="0.05"/>
      <body pos="0 0 -0.2">
        <inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>
        <joint name="it's &quot;odd&quot;" axis="0 1 0" armature="0.01" frictionloss="0.2" damping="0.05"/>
        <body pos="0 0 -0.2">
          <inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>
          <joint name="knee" axis="0 1 0" armature="0.02" frictionloss="0.4" damping="0.1"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""

GROUPS = """  hips:
    joints: [hip, "it's.*"]
    level: ideal_pd
    kp: 20 N*m/rad
    kd: 0.5 N*m*s/rad
    effort_limit: 30 N*m
    armature: 0.01 kg*m^2
    friction: {{coulomb: 0.2 N*m, viscous: 0.05 N*m*s/rad}}
    randomize: {{{hips}}}
  knees:
    joints: [knee]
    level: ideal_pd
    command: velocity
    kd: 1 N*m*s/rad
    effort_limit: 25 N*m
    armature: 0.02 kg*m^2
    friction: {{coulomb: 0.4 N*m, viscous: 0.1 N*m*s/rad}}
    randomize: {{{knees}}}
"""


def drawn(hips: str, knees: str = "") -> tuple[dict[str, NDArray[Any]], Any, Any]:
    """Run the function; returns the drawn fields, the nominal model and the in_axes."""
    made = compile_text(GROUPS.format(hips=hips, knees=knees), MODEL)
    options = TargetOptions("dr", "randomization", installed(), None, "out", stacks=("playground",))
    text = emit(made.actuators, made.robot, options).files[0].data.decode("utf-8")
    module: dict[str, Any] = {}
    exec(compile(text, "randomize.py", "exec"), module)
    model = mjx.put_model(made.model)
    batch, axes = module["domain_randomize"](model, jax.random.split(jax.random.PRNGKey(0), ENVS))
    names = [name for name in ("actuator_gainprm", "actuator_biasprm", "actuator_forcerange", "dof_armature",
                               "dof_frictionloss", "dof_damping") if getattr(axes, name) == 0]  # fmt: skip
    return {name: np.asarray(getattr(batch, name)) for name in names}, made.model, axes


def filled(array: NDArray[Any], low: float, high: float) -> None:
    """A uniform range is filled; P(no one of 400 in the outer 3 %) = 5e-6."""
    width = high - low
    assert low - 1e-5 * width <= array.min() < low + 0.03 * width
    assert high - 0.03 * width < array.max() <= high + 1e-5 * width
    assert abs(array.mean() - (low + high) / 2) < 5 * width / math.sqrt(12 * array.size)


def test_fields() -> None:
    """Each field is drawn in its range at its joints, and only what is drawn is batched."""
    found, _, axes = drawn(
        "kp: {scale: [0.5, 1.5]}, armature: {abs: [0.005, 0.02]}, encoder_bias: {add: [-0.02 rad, 0.04 rad]}",
        "kd: {add: [-0.5, 1]}, friction.viscous: {scale: [0, 2]}, effort_limit: {abs: [10, 25]}",
    )
    gain, bias, limit = found["actuator_gainprm"], found["actuator_biasprm"], found["actuator_forcerange"]
    for hip in (0, 1):
        filled(gain[:, hip, 0], 10.0, 30.0)
        np.testing.assert_array_equal(bias[:, hip, 1], -gain[:, hip, 0])
        np.testing.assert_allclose(bias[:, hip, 2], -0.5, rtol=1e-6)
        filled(-bias[:, hip, 0] / gain[:, hip, 0], -0.02, 0.04)
        filled(found["dof_armature"][:, hip], 0.005, 0.02)
        np.testing.assert_allclose(limit[:, hip], np.tile([-30.0, 30.0], (ENVS, 1)), rtol=1e-6)
    filled(gain[:, 2, 0], 0.5, 2.0)
    np.testing.assert_array_equal(bias[:, 2, 2], -gain[:, 2, 0])
    np.testing.assert_array_equal(limit[:, 2, 0], -limit[:, 2, 1])
    filled(limit[:, 2, 1], 10.0, 25.0)
    filled(found["dof_damping"][:, 2], 0.0, 0.2)
    np.testing.assert_allclose(found["dof_damping"][:, :2], 0.05, rtol=1e-6)
    assert not np.any(gain[:, 0, 0] == gain[:, 1, 0])
    assert axes.dof_frictionloss is None and axes.body_mass is None


def test_factors_and_sharing() -> None:
    """`gains` is one factor on kp and kd, `strength` one number a robot for all groups, on limits too."""
    strength = "strength: {scale: [0.5, 1], per: env}"
    found, _, _ = drawn(f"gains: {{scale: [0.8, 1.2], per: group}}, {strength}", strength)
    gain, bias, limit = (
        found["actuator_gainprm"],
        found["actuator_biasprm"],
        found["actuator_forcerange"][..., 1],
    )
    np.testing.assert_allclose(gain[:, 0, 0] / -bias[:, 0, 2], 40.0, rtol=1e-5)
    np.testing.assert_allclose(gain[:, 0, 0], gain[:, 1, 0], rtol=1e-6)
    np.testing.assert_allclose(limit[:, 0] / 30, limit[:, 2] / 25, rtol=1e-5)
    np.testing.assert_allclose(gain[:, 2, 0], limit[:, 2] / 25, rtol=1e-5)
    filled(limit[:, 0], 15.0, 30.0)
    filled(gain[:, 0, 0] / limit[:, 0] * 30, 16.0, 24.0)


@jax.tree_util.register_pytree_node_class
class Fields:
    """The fields of an MjModel that the function uses, as an MJX model has them: MJX itself holds no dcmotor."""

    NAMES = ("actuator_gainprm", "actuator_biasprm", "actuator_forcerange")

    def __init__(self, model: Any, values: dict[str, Any]) -> None:
        self.model, self.values = model, values

    def __getattr__(self, name: str) -> Any:
        return self.values[name] if name in self.values else getattr(self.model, name)

    def tree_replace(self, values: dict[str, Any]) -> Fields:
        """A copy with other values, as `mjx.Model` has it."""
        return Fields(self.model, {**self.values, **values})

    def tree_flatten(self) -> tuple[tuple[Any, ...], Any]:
        """Values and the rest."""
        return tuple(self.values[name] for name in self.NAMES), self.model

    @classmethod
    def tree_unflatten(cls, rest: Any, values: tuple[Any, ...]) -> Fields:
        """The inverse."""
        return cls(rest, dict(zip(cls.NAMES, values, strict=True)))


def test_dcmotor_is_the_law_of_the_drawn_numbers() -> None:
    """A drawn dcmotor gives s · clip(f_p kp e − f_d kd w) with the line and the limit at s times theirs, in MuJoCo.

    In the voltage dialect kd = 0.5 is a negative controller gain, -0.785 V s/rad: a factor on it would be wrong.
    """
    import mujoco

    actuators = """  legs:
    joints: [hip, "it's.*", knee]
    motor: line
    level: dc_motor
    kp: 25 N*m/rad
    kd: 0.5 N*m*s/rad
    effort_limit: 20 N*m
    randomize:
      kp: {scale: [0.5, 2]}
      kd: {scale: [0.2, 3]}
      strength: {scale: [0.5, 1.5], per: env}
"""
    made = compile_text(actuators, MODEL)
    options = TargetOptions("dr", "randomization", installed(), None, "out", stacks=("playground",))
    text = emit(made.actuators, made.robot, options).files[0].data.decode("utf-8")
    module: dict[str, Any] = {}
    exec(compile(text, "randomize.py", "exec"), module)
    model = made.model
    fields = Fields(model, {name: jax.numpy.asarray(getattr(model, name)) for name in Fields.NAMES})
    batch, axes = module["domain_randomize"](fields, jax.random.split(jax.random.PRNGKey(1), 40))
    assert axes.actuator_gainprm == 0 and axes.actuator_forcerange == 0

    law = law_of(made.actuators.joints[0])
    data = mujoco.MjData(model)
    nominal = model.actuator_gainprm.copy()
    voltage = tuple(map(int, installed().split("."))) < (3, 12)
    for env in range(40):
        gain = np.asarray(batch.actuator_gainprm[env], dtype=float)
        limit = np.asarray(batch.actuator_forcerange[env], dtype=float)
        model.actuator_gainprm[:], model.actuator_forcerange[:] = gain, limit
        strength = limit[0, 1] / 20.0
        np.testing.assert_allclose(limit, [[-20.0 * strength, 20.0 * strength]] * 3, rtol=1e-6)
        for joint in range(3):
            if voltage:
                ratio = nominal[joint, 0] / nominal[joint, 1]
                kp, kd = gain[joint, 4] / ratio, (gain[joint, 6] + nominal[joint, 1]) / ratio
            else:
                kp, kd = gain[joint, 4] / strength, gain[joint, 6] / strength
            assert 12.49 <= kp <= 50.01 and 0.099 <= kd <= 1.501
            asked = strengthened(replace(law, kp=kp, kd=kd), strength)
            for speed in (0.0, 8.0, -20.0, 40.0):
                data.qvel[:], data.ctrl[:] = 0.0, 0.0
                data.qvel[joint], data.ctrl[joint] = speed, 0.7
                mujoco.mj_forward(model, data)
                np.testing.assert_allclose(
                    data.actuator_force[joint], float(asked.torque(0.7, 0.0, speed)), rtol=2e-5, atol=2e-5
                )
