"""Joints that an actuator moves without driving them."""

from __future__ import annotations

import pytest

from actspec.robot.read_mjcf import read_mjcf
from actspec.robot.read_mjcf_text import read_mjcf_text
from actspec.robot.view import ModelFile, RobotView
from actspec.robot.xml import parse_document

# world - trunk (free) - hip - knee (two joints) - ankle, and an arm with a wrist beside the leg.
TREE = """<mujoco><worldbody><site name="w"/>
<body name="trunk"><freejoint/><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/><site name="t"/>
  <geom name="ball" size="0.1"/>
  <body name="thigh" pos="0 0 -1"><joint name="hip"/><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>
    <site name="h" pos="0.1 0 0"/>
    <body name="shank" pos="0 0 -1"><joint name="knee"/><joint name="twist" axis="1 0 0"/>
      <inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/><site name="k" pos="0.1 0.2 0"/>
      <body name="foot" pos="0 0 -1"><joint name="ankle"/>
        <inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/><site name="f" pos="0.1 0 0"/></body></body></body>
  <body name="arm" pos="0 1 0"><joint name="wrist"/><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>
    <site name="a" pos="0.1 0 0"/></body>
</body></worldbody>
<tendon>
  <fixed name="coupled"><joint joint="ankle" coef="1"/><joint joint="hip" coef="-1"/></fixed>
  <spatial name="calf"><site site="h"/><site site="f"/></spatial>
  <spatial name="over"><site site="a"/><geom geom="ball"/><site site="h"/></spatial>
  <spatial name="branched"><site site="h"/><site site="k"/>
    <pulley divisor="2"/><site site="a"/><site site="t"/></spatial>
</tendon>
<actuator>{actuator}</actuator></mujoco>"""


def read(actuator: str) -> tuple[RobotView, RobotView]:
    """The robot as MuJoCo compiles it, and from its text."""
    files = (ModelFile("m.xml", "", TREE.format(actuator=actuator).encode()),)
    document = parse_document(files)
    return read_mjcf(files, document, inertia=False), read_mjcf_text(document, "refused")


@pytest.mark.parametrize(
    ("actuator", "compiled", "text"),
    [
        ('<motor joint="knee"/>', (), ()),
        ('<motor jointinparent="knee"/>', (), ()),
        # In the model's order, whatever the tendon's.
        ('<motor tendon="coupled"/>', ("hip", "ankle"), ("ankle", "hip")),
        ('<motor tendon="calf"/>', ("knee", "twist", "ankle"), None),
        # From the arm to the trunk, and from the trunk to the thigh.
        ('<motor tendon="over"/>', ("hip", "wrist"), None),
        # After a pulley nothing pulls the shank and the arm together.
        ('<motor tendon="branched"/>', ("knee", "twist", "wrist"), None),
        # Against the world: all on the way, the free joint has no name.
        ('<motor site="k" gear="1 0 0 0 0 0"/>', ("hip", "knee", "twist"), None),
        ('<motor site="f" refsite="h" gear="1 0 0 0 0 0"/>', ("knee", "twist", "ankle"), None),
        ('<motor site="f" refsite="w" gear="1 0 0 0 0 0"/>', ("hip", "knee", "twist", "ankle"), None),
        ('<motor cranksite="a" slidersite="h" cranklength="9"/>', ("hip", "wrist"), None),
        ('<adhesion body="foot" ctrlrange="0 1"/>', (), ()),
    ],
    ids=["joint", "parent", "fixed", "spatial", "over-geom", "pulley", "site", "refsite", "world", "crank", "body"],
)  # fmt: skip
def test_joints_that_feel_a_force(
    actuator: str, compiled: tuple[str, ...], text: tuple[str, ...] | None
) -> None:
    """What lies between the bodies that it pulls at."""
    view, by_text = read(actuator)
    assert view.actuators[0].moves == compiled
    assert by_text.actuators[0].moves == text


def test_nothing_else_feels_it() -> None:
    """MuJoCo's own moment arms are zero at all other joints, and at none of these, in a pose off the axes."""
    import mujoco

    for tendon in ("coupled", "calf", "over", "branched"):
        text = TREE.format(actuator=f'<motor tendon="{tendon}"/>')
        model = mujoco.MjModel.from_xml_string(text)
        data = mujoco.MjData(model)
        data.qpos[7:] = (0.3, -0.5, 0.4, 0.7, 0.6)
        data.ctrl[:] = 1.0
        mujoco.mj_forward(model, data)
        felt = {
            model.joint(joint).name
            for joint in range(1, model.njnt)
            if abs(data.qfrc_actuator[model.jnt_dofadr[joint]]) > 1e-9
        }
        view, _ = read(f'<motor tendon="{tendon}"/>')
        assert set(view.actuators[0].moves or ()) == felt, tendon


@pytest.mark.parametrize(
    ("equality", "coupled"),
    [
        ("", set()),
        ('<connect body1="foot" body2="arm" anchor="0 0 0"/>', {"hip", "knee", "twist", "ankle", "wrist"}),
        ('<connect body1="foot" body2="thigh" anchor="0 0 0"/>', {"knee", "twist", "ankle"}),
        ('<connect site1="f" site2="a"/>', {"hip", "knee", "twist", "ankle", "wrist"}),
        ('<weld body1="arm" body2="trunk"/>', {"wrist"}),
        ('<weld body1="arm" body2="trunk" active="false"/>', set()),
        ('<joint joint1="hip" joint2="wrist"/>', {"hip", "wrist"}),
        ('<joint joint1="hip"/>', {"hip"}),
        ('<tendon tendon1="coupled"/>', set()),
    ],
)
def test_joints_that_an_equality_couples(equality: str, coupled: set[str]) -> None:
    """What a constraint ties does not move alone; one that is off ties nothing."""
    text = TREE.format(actuator="").replace("<actuator>", f"<equality>{equality}</equality><actuator>")
    files = (ModelFile("m.xml", "", text.encode()),)
    found = read_mjcf(files, parse_document(files), inertia=False).coupled
    assert found == coupled
