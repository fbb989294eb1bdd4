"""What an edited model has beside its figures: arrays of its joints and actuators, options, keyframes."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.verify.making import Built, Edit, build, matched, replaced

MODEL = """<mujoco model="arm">
  <compiler angle="radian"/>
  <option timestep="0.005" integrator="implicitfast" impratio="2"/>
  <worldbody>
    <body name="a"><joint name="hip" axis="0 1 0" range="-1 1"/><geom size="0.1"/>
      <body name="b" pos="0.3 0 0"><joint name="knee" axis="0 1 0" range="-2 0"/><geom size="0.1"/></body>
    </body>
  </worldbody>
  <actuator><motor name="hip" joint="hip"/><motor name="knee" joint="knee"/></actuator>
  <keyframe><key name="home" qpos="0.2 -0.7" ctrl="0 0"/><key name="flat" qpos="0 0"/></keyframe>
</mujoco>
"""

SPEC = """actspec: 1
robot: {name: arm, model: arm.xml}
timing: {physics_dt: 5 ms}
actuators:
  leg:
    joints: [hip, knee]
    level: ideal_pd
    kp: 40
    kd: 1.5
    effort_limit: 20
    armature: 0.01
    delay: 10 ms
    friction: {coulomb: 0.3, viscous: 0.05}
targets: {mujoco: {version: "3.12"}}
"""


@pytest.fixture(scope="module")
def arm(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """Two joints with keyframes, compiled."""
    return build(tmp_path_factory.mktemp("arm"), SPEC, MODEL, "arm.xml")


CHANGED: dict[str, tuple[Edit, str, str, str]] = {
    "gear": (
        replaced('gear="1"', 'gear="-1"'),
        "VFY106",
        "actuator_gear",
        "MuJoCo's actuator_gear[0] is -1, and should be 1: the sign is wrong",
    ),
    "one side of a limit": (
        replaced('forcerange="-20 20"', 'forcerange="-20 15"'),
        "VFY110",
        "actuator_forcerange",
        "MuJoCo's actuator_forcerange[1] is 15, and should be 20, as actspec writes it",
    ),
    "axis": (replaced('axis="0 1 0"', 'axis="0 -1 0"'), "VFY106", "jnt_axis", "jnt_axis[1] is -1"),
    "stiffness of friction": (
        replaced('name="hip" ', 'name="hip" solreffriction="0.5 1" '),
        "VFY110",
        "dof_solref",
        "dof_solref[0] is 0.5, and should be 0.02",
    ),
    "reference of the joint": (
        replaced('name="knee" axis', 'name="knee" ref="0.5" axis'),
        "VFY110",
        "qpos0",
        "qpos0 is 0.5, and should be 0",
    ),
    "integrator": (
        replaced('integrator="implicitfast"', 'integrator="Euler"'),
        "VFY110",
        "integrator",
        "the option integrator is EULER, and should be IMPLICITFAST",
    ),
    "no friction": (
        replaced("<worldbody>", '<option><flag frictionloss="disable"/></option><worldbody>'),
        "VFY110",
        "disableflags",
        "the option disableflags is frictionloss, and should be none",
    ),
    # kp times the position, which the compiler writes there, is what holds the robot up
    "control of a keyframe": (
        matched(r'ctrl="0.2 -0.7"', 'ctrl="0.2 0"'),
        "VFY110",
        "keyframe home",
        "the ctrl of keyframe home at knee is 0, and should be -0.7",
    ),
    "position of a keyframe": (
        replaced('qpos="0.2 -0.7"', 'qpos="0.3 -0.7"'),
        "VFY110",
        "keyframe home",
        "the qpos of keyframe home at hip is 0.3, and should be 0.2",
    ),
    "keyframe": (
        matched(r'<key name="flat"[^>]*/>', ""),
        "VFY110",
        "keyframe flat",
        "the keyframe flat is missing",
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CHANGED)
def test_change_is_found(name: str, arm: Built) -> None:
    """A number that no figure tells is reported by MuJoCo's own name, with what actspec writes."""
    edit, code, quantity, message = CHANGED[name]
    rows = arm.verified("mujoco", edit).faults
    assert [row.code for row in rows if row.quantity == quantity and message in row.message] == [code]


@pytest.mark.parametrize(
    "edit",
    [
        matched(r'ctrlrange="[^"]*"', 'ctrlrange="-9 9"'),
        replaced('impratio="2"', 'impratio="10"'),
        replaced('<geom size="0.1"/>', '<geom size="0.2"/>', 0),
        lambda text: text.replace("<mujoco", "<!-- mine --><mujoco", 1),
    ],
    ids=["range of a viewer", "contacts", "inertia", "remark"],
)
def test_what_is_not_compared(edit: Edit, arm: Built) -> None:
    """What no drive reads, contacts and inertia are not held to what actspec writes."""
    assert arm.verified("mujoco", edit).faults == ()


def test_places(arm: Built) -> None:
    """A changed row is reported at its actuator's line, and a joint whose figure is wrong is reported once."""
    (row,) = arm.verified("mujoco", replaced('gear="1"', 'gear="-1"')).faults
    assert row.place is not None
    assert "gear" in Path(row.place.path).read_text("utf-8").splitlines()[row.place.line - 1]
    (row,) = arm.verified("mujoco", replaced('armature="0.01"', 'armature="0.02"')).faults
    assert row.quantity == "armature"
