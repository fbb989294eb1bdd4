"""The harness itself, on models whose torques are worked out by hand."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from actspec.verify.environments import EngineError, EngineUnavailableError, prepare_release
from tests.agree.engines import VERSIONS, Engine, grid, load, time

ENDS = pytest.mark.parametrize(
    "engine", (VERSIONS[0], VERSIONS[-1]), ids=lambda v: f"mujoco-{v}", indirect=True
)
"""The oldest and the newest, for what the harness does itself; what it says of a release is asked in each."""

FLOAT64 = 1e-12
"""A handful of float64 operations on numbers below 1000."""


def robot(actuators: str, *, knee: str = "", hip: str = "", timestep: str = "0.01", extra: str = "") -> str:
    """Two hinges of unlike inertia: `hip`, then `knee`."""
    return f"""
    <mujoco>
      <option timestep="{timestep}"/>
      <worldbody>
        <body>
          <joint name="hip" axis="0 1 0" {hip}/>
          <geom type="capsule" fromto="0 0 0 0 0 -.3" size=".02"/>
          <body pos="0 0 -.3">
            <joint name="knee" axis="0 1 0" {knee}/>
            <geom type="capsule" fromto="0 0 0 0 0 -.2" size=".02"/>
          </body>
        </body>
      </worldbody>
      <actuator>{actuators}</actuator>
      {extra}
    </mujoco>"""


SERVOS = robot(
    '<position name="a_knee" joint="knee" kp="20" kv="1.5" forcerange="-8 8"/>'
    '<position name="a_hip" joint="hip" kp="10" kv="1" forcerange="-4 4" gear="2"/>',
    knee='damping=".4" frictionloss=".3" armature=".05" actuatorfrcrange="-7 7"',
)


def test_position_servo_grid_is_the_clip_by_hand(engine: Engine) -> None:
    """Every release gives gear · clip(kp (u − gear q) − kv gear q̇), then the joint's own clamp."""
    q = [[0.1, 0.2], [0.1, 0.2], [0.1, -0.3]]
    qd = [[2.0, 0.5], [-2.0, 0.5], [2.0, 0.5]]
    ctrl = [[0.5, 0.6], [0.5, 0.9], [-0.5, 0.6]]
    answer = engine.grid(SERVOS, joints=["knee", "hip"], q=q, qd=qd, ctrl=ctrl)
    expected = [
        # knee 20 (.5-.1) - 1.5·2 = 5;     hip 10 (.6-.4) - 1·1 = 1, times gear 2
        [5.0, 2.0],
        # knee 8 + 3 = 11, clip 8, joint 7; hip 10 (.9-.4) - 1 = 4, at its clip, times 2
        [7.0, 8.0],
        # knee 20 (-.6) - 3 = -15, clip;    hip 10 (.6+.6) - 1 = 11, clip 4, times 2
        [-7.0, 8.0],
    ]
    np.testing.assert_allclose(answer.torque, expected, atol=FLOAT64)
    # passive: knee joint damping .4 only, outside every clamp; the hip has none
    np.testing.assert_allclose(answer.forces["passive"], [[-0.8, 0.0], [0.8, 0.0], [-0.8, 0.0]], atol=FLOAT64)
    # before the joint's clamp the actuators themselves give up to their own limits, in actuator order
    np.testing.assert_allclose(answer.forces["actuator_force"], [[5, 1], [8, 4], [-8, 4]], atol=FLOAT64)


def test_model_is_reported(engine: Engine) -> None:
    """Joint and actuator parameters come back by name, from every release."""
    answer = engine.load(SERVOS, fields=["body_mass"])
    assert answer.ok, answer.error
    assert answer.info["joints"] == ["hip", "knee"]
    assert answer.info["actuators"] == ["a_knee", "a_hip"]
    assert answer.info["timestep"] == 0.01
    assert answer.info["biastypes"] == ["mjBIAS_AFFINE", "mjBIAS_AFFINE"]
    assert answer.joint("knee", "dof_damping") == 0.4
    assert answer.joint("knee", "dof_frictionloss") == 0.3
    assert answer.joint("knee", "dof_armature") == 0.05
    assert answer.joint("hip", "dof_armature") == 0.0
    assert answer.joint("knee", "jnt_actfrcrange").tolist() == [-7.0, 7.0]
    assert answer.actuator("a_knee", "actuator_gainprm")[0] == 20.0
    assert answer.actuator("a_knee", "actuator_biasprm")[:3].tolist() == [0.0, -20.0, -1.5]
    assert answer.actuator("a_hip", "actuator_forcerange").tolist() == [-4.0, 4.0]
    assert answer.actuator("a_hip", "actuator_gear")[0] == 2.0
    assert ("actuator_armature" in answer.fields) == (engine.number >= (3, 7))
    assert ("actuator_history" in answer.fields) == (engine.number >= (3, 5))
    assert len(answer.fields["body_mass"]) == 3


@ENDS
def test_controls_are_taken_by_name(engine: Engine) -> None:
    """`actuators` names the columns of ctrl, whatever order the model has them in."""
    motors = robot('<motor name="m0" joint="hip"/><motor name="m1" joint="knee" gear="3"/>')
    answer = engine.grid(motors, joints=["hip"], actuators=["m1", "m0"], q=[0.0], qd=[0.0], ctrl=[[5.0, 7.0]])
    assert answer.forces["qfrc_actuator"].tolist() == [[7.0, 15.0]]


# 1 − e^(−k·0.01/0.05) for k = 0 … 3
RISE = [0.0, 0.18126924692201818, 0.3296799539643607, 0.4511883639059736]

FILTERS = {
    "timeconst": '<position name="a" joint="knee" kp="10" kv="2" timeconst=".05"/>',
    "general": '<general name="a" joint="knee" dyntype="filterexact" dynprm=".05" gainprm="10"'
    ' biastype="affine" biasprm="0 -10 -2"/>',
}


@ENDS
@pytest.mark.parametrize("actuator", FILTERS.values(), ids=FILTERS.keys())
def test_filter_from_a_bare_reset(engine: Engine, actuator: str) -> None:
    """The command rises from 0 as 1 − e^(−k h/τ), the feedback is not filtered."""
    answer = engine.time(robot(actuator), joints=["knee"], ctrl=[[1.0]] * 4, q=[0.05], qd=[0.3])
    # 10 a − 10·0.05 − 2·0.3 = 10 a − 1.1
    np.testing.assert_allclose(answer.torque[:, 0], 10 * np.array(RISE) - 1.1, atol=FLOAT64)


@ENDS
def test_filter_from_the_reset_recipe(engine: Engine) -> None:
    """Started at the first command, the filter has no transient and then follows a step from there."""
    xml = robot(FILTERS["timeconst"])
    answer = engine.time(xml, joints=["knee"], ctrl=[[0.4], [0.4], [1.4], [1.4], [1.4]], start=[0.4])
    # 10·0.4 while the command stays; a step of 1 at k = 2 is first felt at k = 3
    expected = [4.0, 4.0, 4.0, 4 + 10 * RISE[1], 4 + 10 * RISE[2]]
    np.testing.assert_allclose(answer.torque[:, 0], expected, atol=FLOAT64)


@ENDS
def test_joints_stay_where_they_are_put(engine: Engine) -> None:
    """Before every step all joints are put back: those of the job, and the others at their reset state."""
    pushed = robot('<motor name="m" joint="knee"/>', hip='damping="2"', knee='damping="3"')
    answer = engine.time(pushed, joints=["knee"], ctrl=[[50.0]] * 3, qd=[0.5])
    # hip at rest, knee −3·0.5: had the 50 N·m moved them, the second step would show other speeds
    np.testing.assert_allclose(answer.forces["qfrc_passive"], [[0.0, -1.5]] * 3, atol=FLOAT64)


@ENDS
def test_grid_settles_filters(engine: Engine) -> None:
    """A grid sample sees the filter's output at its clamped command, not the empty filter."""
    xml = robot(
        '<position name="a" joint="knee" kp="10" timeconst=".05" ctrlrange="-1 1" ctrllimited="true"/>'
    )
    answer = engine.grid(xml, joints=["knee"], q=[0.0], qd=[0.0], ctrl=[[0.5], [3.0]])
    # 10·0.5, then 10·1 because the control is clamped to 1
    np.testing.assert_allclose(answer.torque[:, 0], [5.0, 10.0], atol=FLOAT64)


DELAYED = '<position name="a" joint="knee" kp="10" delay=".03" nsample="3"/>'
DELAYED_FILTERED = '<position name="a" joint="knee" kp="10" delay=".03" nsample="3" timeconst=".05"/>'


def test_delay(engine: Engine) -> None:
    """Where a release has delay it is exactly three steps, from 0 or from the recipe's start."""
    if engine.number < (3, 5):
        answer = engine.load(robot(DELAYED))
        assert answer.error is not None and "delay" in answer.error
        return
    xml, ctrl = robot(DELAYED), [[0.5], [1.0], [1.0], [1.0], [1.0], [1.0]]
    bare, recipe = engine.run(
        [time(xml, joints=["knee"], ctrl=ctrl), time(xml, joints=["knee"], ctrl=ctrl, start=[0.2])]
    )
    np.testing.assert_allclose(bare.torque[:, 0], [0, 0, 0, 5, 10, 10], atol=FLOAT64)
    np.testing.assert_allclose(recipe.torque[:, 0], [2, 2, 2, 5, 10, 10], atol=FLOAT64)


def test_delay_then_filter(engine: Engine) -> None:
    """The delayed command goes through the filter: nothing for three steps, then the rise."""
    if engine.number < (3, 5):
        pytest.skip("no delay before 3.5")
    xml, ctrl = robot(DELAYED_FILTERED), [[1.0]] * 6
    bare, recipe, held = engine.run(
        [
            time(xml, joints=["knee"], ctrl=ctrl),
            time(xml, joints=["knee"], ctrl=ctrl, start=[0.4]),
            grid(xml, joints=["knee"], q=[0.1], qd=[0.0], ctrl=[[0.7]]),
        ]
    )
    np.testing.assert_allclose(bare.torque[:, 0], 10 * np.array([0, 0, 0, *RISE[:3]]), atol=FLOAT64)
    # from 0.4 towards 1: 4 + 0.6·10·rise
    np.testing.assert_allclose(recipe.torque[:, 0], 4 + 6 * np.array([0, 0, 0, *RISE[:3]]), atol=FLOAT64)
    # settled at 0.7: 10 (0.7 − 0.1)
    np.testing.assert_allclose(held.torque, [[6.0]], atol=FLOAT64)


# kp 25, kd 0.5, stall 23.5, no-load 30, V = 24: K = 24/30 = 0.8, R = K·24/23.5, R/K = 24/23.5.
# Torque-space releases take kp, kd; voltage-space ones kp R/K = 600/23.5 and kd R/K − K = 12/23.5 − 0.8.
TORQUE_SPACE = 'input="pos" controller="25 0 .5 0 0 24"'
VOLTAGE_SPACE = f'input="position" controller="{600 / 23.5!r} 0 {12 / 23.5 - 0.8!r} 0 0 24"'
MOTOR = '<dcmotor name="a" joint="knee" nominal="24 23.5 30" saturation="23.5 0 0" {}/>'


def test_dcmotor_is_the_four_quadrant_line(engine: Engine) -> None:
    """Both dialects of `<dcmotor>` give the anchors of the dc_motor law, braking quadrant included."""
    dialect = TORQUE_SPACE if engine.number >= (3, 12) else VOLTAGE_SPACE
    speeds = [[0.0], [15.0], [30.0], [45.0], [60.0], [70.0], [-15.0]]
    job = grid(robot(MOTOR.format(dialect)), joints=["knee"], q=[0.0], qd=speeds, ctrl=[10.0])
    # inside the envelope the PD shows: 25 (0.3 − 0.1) − 0.5·2 = 4
    inside = grid(robot(MOTOR.format(dialect)), joints=["knee"], q=[0.1], qd=[2.0], ctrl=[0.3])
    line, point = engine.run([job, inside])
    if engine.number < (3, 7):
        assert line.error is not None and "dcmotor" in line.error
        return
    # 25·10 saturates: 23.5 (1 − ω/30), never under −23.5, never over 23.5
    expected = [23.5, 11.75, 0.0, -11.75, -23.5, -23.5, 23.5]
    np.testing.assert_allclose(line.torque[:, 0], expected, atol=FLOAT64)
    np.testing.assert_allclose(point.torque, [[4.0]], atol=FLOAT64)


def test_dcmotor_dialects_do_not_cross_load(engine: Engine) -> None:
    """Each release refuses the other's dialect, in its own words."""
    if engine.number < (3, 7):
        pytest.skip("no dcmotor before 3.7")
    foreign = VOLTAGE_SPACE if engine.number >= (3, 12) else TORQUE_SPACE
    answer = engine.load(robot(MOTOR.format(foreign)))
    assert answer.error is not None and "keyword" in answer.error


@ENDS
def test_a_refused_job_does_not_stop_the_others(engine: Engine) -> None:
    """In one process each job has its own answer, and a file is read from its path."""
    answers = engine.run([load("<mujoco><nonsense/></mujoco>"), load(SERVOS)])
    assert [answer.ok for answer in answers] == [False, True]
    assert "nonsense" in (answers[0].error or "")
    with pytest.raises(EngineError, match=rf"mujoco {engine.version}: no joint 'elbow' in the model"):
        engine.grid(SERVOS, joints=["elbow"], q=[0], qd=[0], ctrl=[0])
    two = robot('<motor joint="knee"/><motor joint="knee"/>')
    with pytest.raises(EngineError, match="joint 'knee' has 2 actuators"):
        engine.grid(two, joints=["knee"], q=[0], qd=[0], ctrl=[0])


def test_a_file_is_read_where_it_lies(
    engine_of: Callable[[str], Engine], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Includes are found beside the file, and the engine's log stays out of the working folder."""
    (tmp_path / "run").mkdir()
    monkeypatch.chdir(tmp_path / "run")
    (tmp_path / "servo.xml").write_text('<mujocoinclude><motor name="m" joint="knee"/></mujocoinclude>')
    (tmp_path / "robot.xml").write_text(robot('<include file="servo.xml"/>'))
    answer = engine_of("3.7.0").load(Path("..", "robot.xml"))
    assert answer.ok, answer.error
    assert answer.info["actuators"] == ["m"]
    # 1e200 rad/s diverges at once: MuJoCo warns in its log and resets
    with pytest.raises(EngineError, match="diverged"):
        engine_of("3.7.0").time(tmp_path / "robot.xml", joints=["knee"], ctrl=[[1e300]] * 3, qd=[1e200])
    assert sorted(path.name for path in tmp_path.rglob("*")) == ["robot.xml", "run", "servo.xml"]


def test_another_release_in_the_folder_is_noticed(engine_of: Callable[[str], Engine]) -> None:
    """A folder that holds another version than asked is an error, not a wrong agreement."""
    folder = engine_of("3.7.0").folder
    with pytest.raises(EngineError, match=r"asked mujoco 3\.5\.0"):
        Engine("3.5.0", folder).load(SERVOS)


@pytest.mark.engine
def test_a_release_that_does_not_exist_says_so(tmp_path: Path) -> None:
    """The reason is pip's own, and nothing but the lock is left behind."""
    with pytest.raises(EngineUnavailableError, match=r"^mujoco 0\.0\.0: "):
        prepare_release("mujoco", "0.0.0", tmp_path)
    assert [path.suffix for path in tmp_path.iterdir()] == [".lock"]


@pytest.mark.slow
def test_preparing_twice_at_once_is_safe(engine_of: Callable[[str], Engine], tmp_path: Path) -> None:
    """Two callers that start together get one whole folder, and no work folder is left."""
    engine_of("3.3.7")  # a skip where there is no registry
    with ThreadPoolExecutor(2) as pool:
        first, second = pool.map(lambda _: prepare_release("mujoco", "3.3.7", tmp_path), range(2))
    assert first == second
    assert Engine("3.3.7", first).load(SERVOS).ok
    assert len(list(tmp_path.iterdir())) == 2, "one folder and its lock"
