"""`actspec.runtime.reset`: filters and delay lines start where the joints are, so nothing jumps."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from actspec.learn.reset import reset
from tests.compiling import compile_text

mujoco = pytest.importorskip("mujoco")

ROBOT = """<mujoco>
  <option timestep="0.002" gravity="0 0 0"/>
  <worldbody>
    <body><joint name="hip"/><geom size=".1"/></body>
    <body pos="1 0 0"><joint name="knee"/><geom size=".1"/></body>
    <body pos="2 0 0"><joint name="wheel"/><geom size=".1"/></body>
  </worldbody>
  <keyframe><key name="low" qpos="0.1 0.2 0"/><key name="up" qpos="0.5 -0.7 0.3"/></keyframe>
</mujoco>
"""
SPEC = """
  hip:
    joints: [hip]
    level: ideal_pd
    kp: 40
    kd: 2
    effort_limit: 90
    command_filter: {cutoff: 5 Hz}
    delay: 10 ms
  knee:
    joints: [knee]
    level: dc_motor
    motor: line
    kp: 60
    kd: 2
    delay: 6 ms
  wheel:
    joints: [wheel]
    level: ideal_pd
    command: velocity
    kd: 2
    effort_limit: 9
    command_filter: {cutoff: 5 Hz}
"""


@pytest.fixture
def model() -> Any:
    version = ".".join(mujoco.__version__.split(".")[:2])
    return compile_text(SPEC, ROBOT, version).model


def first_torques(model: Any, data: Any, steps: int = 10) -> np.ndarray:
    """Torques with the joints held at their pose, shape (steps, 3)."""
    pose, found = data.qpos.copy(), []
    for _ in range(steps):
        mujoco.mj_forward(model, data)
        found.append(data.qfrc_actuator.copy())
        mujoco.mj_step(model, data)
        data.qpos[:], data.qvel[:] = pose, 0.0
    return np.array(found)


@pytest.mark.parametrize("keyframe", ["up", 1], ids=["name", "index"])
def test_reset_starts_without_a_jump(model: Any, keyframe: str | int) -> None:
    """No torque in the first steps: neither from the filter nor from the delay line."""
    data = mujoco.MjData(model)
    reset(model, data, keyframe)
    assert data.qpos.tolist() == [0.5, -0.7, 0.3]
    assert data.ctrl.tolist() == [0.5, -0.7, 0.0]
    assert np.abs(first_torques(model, data)).max() < 1e-12


def test_bare_reset_jumps(model: Any) -> None:
    """The delay line of a bare reset holds zeros: the knee is pulled with 60 x 0.7 = 42, clipped at 24."""
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 1)
    torques = first_torques(model, data)
    assert torques[0, 1] == pytest.approx(24.0)
    # after its three steps the line holds the keyframe's control
    assert torques[3:, 1] == pytest.approx(0.0, abs=1e-12)


def test_default_is_the_first_keyframe(model: Any) -> None:
    """Without a keyframe the first is taken; without any, qpos0."""
    data = mujoco.MjData(model)
    reset(model, data)
    assert data.qpos.tolist() == [0.1, 0.2, 0.0]
    bare = compile_text(SPEC, ROBOT[: ROBOT.index("  <keyframe>")] + "</mujoco>").model
    data = mujoco.MjData(bare)
    data.qpos[:] = 3
    reset(bare, data)
    assert data.qpos.tolist() == [0, 0, 0]


def test_given_commands_fill_filter_and_delay(model: Any) -> None:
    """A command by name is the one that filter and line start at, for velocity too."""
    data = mujoco.MjData(model)
    reset(model, data, "up", command={"hip": 0.6, "wheel": 1.5, "knee": -0.6})
    torques = first_torques(model, data)
    # 40 (0.6 - 0.5), 60 (-0.6 + 0.7), 2 x 1.5, from the first step on
    np.testing.assert_allclose(torques, [[4.0, 6.0, 3.0]] * 10, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("given", "says"),
    [({"keyframe": "nope"}, "nope"), ({"keyframe": 7}, "7"), ({"command": {"nope": 1.0}}, "nope")],
    ids=["keyframe", "index", "actuator"],
)
def test_unknown_names(model: Any, given: dict[str, Any], says: str) -> None:
    """A keyframe or actuator that is not there is a KeyError that names it."""
    with pytest.raises(KeyError, match=says):
        reset(model, mujoco.MjData(model), **given)
