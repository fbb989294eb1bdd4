"""What a robot weighs, without what stands beside it."""

from __future__ import annotations

import pytest

from actspec.robot.read_mjcf import read_mjcf
from actspec.robot.read_mjcf_text import read_mjcf_text
from actspec.robot.read_urdf import read_urdf
from actspec.robot.view import ModelFile
from actspec.robot.xml import parse_document

# An arm of 2 + 1 kg, a cup of 0.5 kg, a door of 20 kg and a table of 30 kg.
SCENE = """<mujoco><worldbody>
<body name="table"><inertial mass="30" pos="0 0 0" diaginertia="1 1 1"/></body>
<body name="base"><inertial mass="2" pos="0 0 0" diaginertia="1 1 1"/><site name="s"/>
  <body name="arm"><joint name="elbow"/><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/></body></body>
{cup}{door}</worldbody>{tail}</mujoco>"""
CUP = '<body name="cup"><freejoint/><inertial mass="0.5" pos="0 0 0" diaginertia="1 1 1"/></body>'
DOOR = '<body name="door"><joint name="hinge"/><inertial mass="20" pos="0 0 0" diaginertia="1 1 1"/></body>'
MOTOR = '<actuator><motor joint="elbow"/></actuator>'
WELD = '<equality><weld body1="arm" body2="cup"{}/></equality>'
SUCTION = '<actuator><motor joint="elbow"/><adhesion body="arm" ctrlrange="0 1"/></actuator>'


@pytest.mark.parametrize(
    ("cup", "door", "tail", "mass", "by_text"),
    [
        ("", "", MOTOR, 3.0, 3.0),
        ("", "", "", 3.0, 3.0),
        (CUP, DOOR, MOTOR, 3.0, None),
        (CUP, "", "", 3.0, None),  # nothing else has a hinge
        ("", DOOR, "", None, None),
        (CUP, "", MOTOR + WELD.format(""), 3.5, None),  # a part in a closed loop
        (CUP, "", MOTOR + WELD.format(' active="false"'), 3.0, None),  # to be grasped
        ("", "", SUCTION, 3.0, 3.0),
        (CUP, "", SUCTION, None, None),
    ],
    ids=[
        "arm",
        "bare",
        "objects",
        "bare object",
        "bare door",
        "tied",
        "untied",
        "suction",
        "suction and cup",
    ],
)
def test_of_the_bodies_that_actuators_move(
    cup: str, door: str, tail: str, mass: float | None, by_text: float | None
) -> None:
    files = (ModelFile("m.xml", "", SCENE.format(cup=cup, door=door, tail=tail).encode()),)
    document = parse_document(files)
    assert read_mjcf(files, document).mass == mass
    assert read_mjcf_text(document, "refused").mass == by_text


BOX = '<visual><geometry><box size="1 1 1"/></geometry></visual>'
KG = '<inertial><mass value="{}"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'


@pytest.mark.parametrize(
    ("base", "trunk", "wheel", "mass"),
    [
        ("", BOX + KG.format(8), BOX + KG.format(1), 9.0),
        (BOX, KG.format(8), KG.format(1), 9.0),  # a shape of a base that is weighed by the trunk
        (BOX, "", KG.format(1), None),
        (KG.format(8), "", BOX, None),
        (KG.format(8), "", "", 8.0),  # a frame
        (KG.format(8), "", KG.format("x"), None),
    ],
    ids=["all", "by the trunk", "no base", "no wheel", "frame", "no number"],
)
def test_of_a_urdf_whose_parts_state_it(base: str, trunk: str, wheel: str, mass: float | None) -> None:
    text = f"""<robot name="cart"><link name="wheel">{wheel}</link><link name="trunk">{trunk}</link>
    <link name="base">{base}</link>
    <joint name="on" type="fixed"><parent link="base"/><child link="trunk"/></joint>
    <joint name="turns" type="continuous"><parent link="trunk"/><child link="wheel"/></joint></robot>"""
    files = (ModelFile("m.urdf", "", text.encode()),)
    assert read_urdf(files, parse_document(files)).mass == mass
