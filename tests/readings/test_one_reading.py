"""One file, read by `show`, `import`, the ledger and MuJoCo itself: gain, damping and limit are the same numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np
import pytest

from actspec.diagnostics import EmitError
from actspec.ir import JointActuator
from actspec.lift import lift_robot
from actspec.readings.artifact import Artifact, FileKind
from actspec.readings.joint import read_joint
from actspec.readings.ledger import rows_of_robot
from tests.compiling import Compiled, compile_text, view_of
from tests.importing import imported

MODEL = """<mujoco model="probe">
  <option timestep="0.001" {option}><flag {flag}/></option>
  <worldbody>
    <body>
      <joint name="j" axis="0 1 0" range="-2 2" damping="0.1" {joint}/>
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
    </body>
  </worldbody>
  <actuator>
    {actuators}
  </actuator>
</mujoco>
"""

OFF = 'actuatorgroupdisable="1"'
TWO = (
    '<position name="old" joint="j" kp="50" kv="3" forcerange="-30 30" group="1" damping="0.2" armature="0.01"/>\n'
    '    <position name="new" joint="j" kp="10" kv="1" forcerange="-5 5"/>'
)


@dataclass(frozen=True)
class Case:
    """A file, and what acts on its joint, by hand.

    Attributes:
        actuators: Of the file.
        kp: Stiffness [N*m/rad].
        kd: Drive gain [N*m*s/rad].
        limit: Largest torque [N*m].
        passive: Viscous friction, the actuators' too [N*m*s/rad].
        option: Attributes of the file's `option`.
        joint: Attributes of its joint.
        command: Of the spec that is resolved against it.
        imported: Whether a spec has words for it.
    """

    actuators: str
    kp: float
    kd: float
    limit: float
    passive: float = 0.1
    option: str = ""
    joint: str = ""
    command: str = "position"
    imported: bool = True

    @property
    def model(self) -> str:
        return MODEL.format(actuators=self.actuators, option=self.option, joint=self.joint, flag="")


CASES = {
    # The group of the first is off: 10 and 1 act, within 5; its damping of 0.2 acts all the same.
    "one-of-two-off": Case(TWO, 10.0, 1.0, 5.0, passive=0.3, option=OFF),
    # Both act: 50 + 10, 3 + 1, 30 + 5; a spec has no word for two clamps.
    "two-on": Case(TWO, 60.0, 4.0, 35.0, passive=0.3, imported=False),
    # 10 u + 5 for u in [-1, 1] reaches 15.
    "affine-motor": Case(
        '<general name="m" joint="j" gaintype="fixed" gainprm="10" biastype="affine" biasprm="5" ctrlrange="-1 1"/>',
        *(0.0, 0.0, 15.0),
        command="effort",
        imported=False,
    ),
    # [-10, 20] within 100: 20 is reached, one way.
    "one-sided-motor": Case(
        '<motor name="m" joint="j" ctrlrange="-10 20" forcerange="-100 100"/>',
        0.0,
        0.0,
        20.0,
        command="effort",
    ),
    # Gear 3: 4 x 9, 0.5 x 9, 2 x 3; the joint's own 5 is less.
    "geared": Case(
        '<position name="s" joint="j" kp="4" kv="0.5" gear="3" forcerange="-2 2"/>',
        *(36.0, 4.5, 5.0),
        joint='actuatorfrcrange="-5 5"',
    ),
}


def torques(model: mujoco.MjModel, controls: np.ndarray, q: float, v: float) -> np.ndarray:
    """Torque of all actuators on the joint, their damping left out, for controls of the last actuator."""
    data = mujoco.MjData(model)
    found = []
    for control in controls:
        data.qpos[0], data.qvel[0] = q, v
        data.ctrl[-1] = control
        # The others ask for the joint's own position.
        data.ctrl[:-1] = q / model.actuator_gear[:-1, 0]
        mujoco.mj_forward(model, data)
        found.append(float(data.qfrc_actuator[0]))
    return np.array(found)


def resolved(case: Case) -> JointActuator:
    """The joint as a spec that states no number of its drive has it."""
    stated = f"    command: {case.command}\n"
    return compile_text(
        f"  legs:\n    joints: [j]\n    level: ideal_pd\n{stated}", case.model
    ).actuators.joints[0]


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_mujoco_agrees_with_the_numbers_by_hand(case: Case) -> None:
    """The engine's own torque has the gain, the damping and the limit that stand in the case."""
    model = mujoco.MjModel.from_xml_string(case.model)
    wide = torques(model, np.linspace(-200.0, 200.0, 4001), 0.0, 0.0)
    # The others hold still: only the last one's share of a sum is seen here.
    share = 5.0 if case.actuators is TWO else case.limit
    assert max(abs(wide)) == pytest.approx(share, rel=1e-9)
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    at_rest = float(data.qfrc_actuator[0])
    data.qpos[0] = -1e-3
    mujoco.mj_forward(model, data)
    assert (float(data.qfrc_actuator[0]) - at_rest) / 1e-3 == pytest.approx(case.kp, abs=1e-9)
    data.qpos[0], data.qvel[0] = 0.0, -1e-3
    mujoco.mj_forward(model, data)
    slope = (float(data.qfrc_actuator[0]) - at_rest + float(data.qfrc_passive[0])) / 1e-3
    assert slope == pytest.approx(case.kd + case.passive, abs=1e-9)


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_everybody_reads_the_same(case: Case) -> None:
    """Reading, ledger, `show` and `import` have the numbers that MuJoCo's torque has."""
    view = view_of(case.model)
    reading = read_joint(view, "j")
    assert (reading.kp.value, reading.kd.value, reading.effort_limit.value) == (case.kp, case.kd, case.limit)
    rows = rows_of_robot(Artifact("robot.xml", FileKind.MJCF, "probe", robot=view), 0)
    assert sum(row.kp or 0.0 for row in rows) == case.kp
    assert {row.effort_limit for row in rows} == {case.limit}
    assert {row.total_damping for row in rows} == {case.kd + case.passive}
    shown = resolved(case)
    assert shown.effort_limit.value == case.limit
    assert shown.friction_viscous.value == case.passive
    if case.command == "position":
        assert shown.kp is not None and shown.kd is not None
        assert (shown.kp.value, shown.kd.value) == (case.kp, case.kd)
    lifted = lift_robot(view)
    assert bool(lifted.actuators.joints) is case.imported
    for joint in lifted.actuators.joints:
        assert joint.effort_limit.value == case.limit
        assert joint.friction_viscous.value == case.passive
        gains = [0.0 if gain is None else gain.value for gain in (joint.kp, joint.kd)]
        assert gains == [case.kp, case.kd]


def test_a_drive_that_is_off_is_compiled_to_one_that_is_on(tmp_path: Path) -> None:
    """Import and compile of a robot whose first servo is off: the torque of the original, 10 x 0.1 = 1 N*m."""
    case = CASES["one-of-two-off"]
    text = "  legs:\n    joints: [j]\n    level: ideal_pd\n    command: position\n"
    compiled = compile_text(text, case.model)
    before = mujoco.MjModel.from_xml_string(case.model)
    controls = np.linspace(-1.0, 1.0, 21)
    assert torques(before, np.array([0.1]), 0.0, 0.0) == pytest.approx([1.0])
    for q, v in ((0.0, 0.0), (0.3, -2.0), (-0.4, 1.0)):
        expected = torques(before, controls, q, v)
        found = torques(compiled.model, controls, q, v)
        assert found == pytest.approx(expected, abs=1e-12)
    assert _names(compiled) == ["new"]
    assert compiled.codes.count("MJC011") == 1
    # So it is with the spec that `import` writes.
    (tmp_path / "robot.xml").write_text(case.model, encoding="utf-8")
    group = imported([tmp_path / "robot.xml"], tmp_path).data["actuators"]
    assert len(group) == 1


def _names(compiled: Compiled) -> list[str]:
    model = compiled.model
    return [model.actuator(index).name for index in range(model.nu)]


@pytest.mark.parametrize(
    "actuators", ["", '<position name="s" joint="j" kp="4" group="0"/>'], ids=["new", "replaced"]
)
def test_a_drive_is_put_where_the_file_leaves_it_on(actuators: str) -> None:
    """Group 0 and 1 are off: the drive gets group 2, says so, and gives 7 x 0.5 = 3.5 N*m."""
    model = MODEL.format(actuators=actuators, option='actuatorgroupdisable="0 1"', joint="", flag="")
    text = "  legs: {joints: [j], level: ideal_pd, kp: 7 N*m/rad, kd: 0.5 N*m*s/rad, effort_limit: 9 N*m}\n"
    compiled = compile_text(text, model)
    assert compiled.model.actuator_group.tolist() == [2]
    assert "MJC027" in compiled.codes
    assert torques(compiled.model, np.array([0.5, 9.0]), 0.0, 0.0) == pytest.approx([3.5, 9.0])


def test_a_file_that_switches_actuation_off_is_refused() -> None:
    """No drive would give a force."""
    model = MODEL.format(actuators="", option="", joint="", flag='actuation="disable"')
    text = "  legs: {joints: [j], level: ideal_pd, kp: 7 N*m/rad, kd: 0.5 N*m*s/rad, effort_limit: 9 N*m}\n"
    with pytest.raises(EmitError, match="MJC026"):
        compile_text(text, model)


def test_unlimited_is_infinite_and_unknown_is_none() -> None:
    """A servo without a limit has none; one beside a tendon of unknown effect has an unknown total."""
    reading = read_joint(
        view_of(MODEL.format(actuators='<motor joint="j"/>', option="", joint="", flag="")), "j"
    )
    assert reading.effort_limit.value == math.inf
    assert reading.velocity_limit.value is None


WEIGHTLESS = """<mujoco model="probe">
  <asset><mesh name="leg" file="leg.stl"/></asset>
  <worldbody>
    <body>
      <joint name="j" axis="0 1 0" springdamper="0.1 1"/>
      {inertia}<geom type="mesh" mesh="leg"/>
    </body>
  </worldbody>
  <actuator><position name="a" joint="j" kp="50" dampratio="1" forcerange="-9 9"/></actuator>
</mujoco>
"""


def test_what_follows_the_mass_of_a_missing_mesh_is_unknown_everywhere(tmp_path: Path) -> None:
    """Nobody has a number for kd and the friction, and a compile that needs kd stops."""
    text = WEIGHTLESS.format(inertia="")
    view = view_of(text)
    reading = read_joint(view, "j")
    assert (reading.kp.value, reading.kd.value, reading.friction_viscous.value) == (50.0, None, None)
    (row,) = rows_of_robot(Artifact("robot.xml", FileKind.MJCF, "probe", robot=view), 0)
    assert (row.kp, row.kd, row.joint_damping, row.total_damping, row.effort_limit) == (
        50.0,
        None,
        None,
        None,
        9.0,
    )
    (tmp_path / "robot.xml").write_text(text)
    (group,) = imported([tmp_path / "robot.xml"], tmp_path).data["actuators"].values()
    assert (group["kd"], group["friction"]["viscous"]) == ("unknown", "unknown")
    spec = "  legs:\n    joints: [j]\n    level: ideal_pd\n"
    with pytest.raises(EmitError, match=r"MJC001 .*kd is unknown") as caught:
        compile_text(spec, text)
    assert "MJC025" not in str(caught.value)
    # The author's kd is enough: the springdamper stays in force.
    compiled = compile_text(spec + "    kd: 3\n", text)
    assert 'springdamper="0.1 1"' in compiled.text
    with pytest.raises(EmitError, match="MJC025"):
        compile_text(spec + "    kd: 3\n    friction: {viscous: 0.1}\n", text)


def test_an_inertia_that_is_stated_needs_no_mesh() -> None:
    """I = 0.02: k = I/tc^2, b = 2 I/tc = 0.4, and kv = 2 sqrt(50 * 0.02) = 2."""
    inertial = '<inertial pos="0 0 0" mass="1" diaginertia="0.02 0.02 0.02"/>'
    text = WEIGHTLESS.format(inertia=inertial)
    reading = read_joint(view_of(text), "j")
    assert (reading.kd.value, reading.friction_viscous.value) == (pytest.approx(2.0), pytest.approx(0.4))
    compiled = compile_text("  legs:\n    joints: [j]\n    level: ideal_pd\n", text)
    assert compiled.actuators.joints[0].kd is not None
    assert compiled.actuators.joints[0].kd.value == pytest.approx(2.0)
    (joint,) = view_of(compiled.text).joints
    assert (joint.springdamper, joint.stiffness, joint.damping) == (
        False,
        pytest.approx(2.0),
        pytest.approx(0.4),
    )
