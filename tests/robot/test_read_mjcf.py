"""MJCF to view: compiled numbers, where they are stated, actuators by kind, stand-ins, real files."""

from __future__ import annotations

import math
import os
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from actspec.audit.read import read_files
from actspec.diagnostics import RobotError, Severity
from actspec.ir import JointKind
from actspec.robot.assets import decodes, mesh_dependence, stand_in
from actspec.robot.load import load_robot
from actspec.robot.mjspec import compile_spec, open_spec, quiet, splice
from actspec.robot.read_mjcf import read_mjcf
from actspec.robot.view import ActuatorView, ModelFile, ModelFormat, RobotView
from actspec.robot.xml import parse_document
from actspec.sysid.links import bench_model

CORPUS = Path(os.environ.get("ACTSPEC_CORPUS", Path(__file__).parents[3] / "shared" / "corpus"))
REAL = sorted(CORPUS.rglob("*.xml")) if CORPUS.is_dir() else []
TORQUE_SPACE = hasattr(mujoco.mjtGain, "mjGAIN_PID")
"""MuJoCo 3.12 and later: dcmotor gains are torques, and `pid` is there."""


@pytest.fixture(autouse=True)
def _in_tmp_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def read(text: str, **others: str) -> RobotView:
    """A view of a model and the files beside it (`leg_xml` is leg.xml)."""
    for name, content in others.items():
        Path(name.replace("__", "/").replace("_xml", ".xml")).parent.mkdir(exist_ok=True)
        Path(name.replace("__", "/").replace("_xml", ".xml")).write_text(content)
    Path("m.xml").write_text(text)
    return load_robot("m.xml")


def errors(text: str, **others: str) -> list[str]:
    """The errors of a model that is refused."""
    with pytest.raises(RobotError) as caught:
        read(text, **others)
    return [str(d) for d in caught.value.diagnostics if d.severity is Severity.ERROR]


def one_joint(joint: str, head: str = "", tail: str = "") -> str:
    """A model of one body: inertia 1 kg*m^2 about its only joint."""
    return f"""<mujoco>{head}<worldbody><body name="b">{joint}
<inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/><site name="s"/></body></worldbody>{tail}</mujoco>"""


def driven(actuator: str, joint: str = '<joint name="j"/>', head: str = "") -> ActuatorView:
    """The view of one actuator on `one_joint`."""
    (found,) = read(one_joint(joint, head, f"<actuator>{actuator}</actuator>")).actuators
    return found


def test_joint_values_are_compiled_ones() -> None:
    """Degrees become radians, automatic limits count, and nothing else changes."""
    joint = """
<joint name="j" range="-90 45" damping="0.5" armature="0.02" frictionloss="0.3" stiffness="7"
  actuatorfrcrange="-4 5"/>"""
    (found,) = read(one_joint(joint)).joints
    assert found.range == pytest.approx((-math.pi / 2, math.pi / 4))
    assert (found.damping, found.armature, found.frictionloss, found.stiffness) == (0.5, 0.02, 0.3, 7.0)
    assert (found.effort_range, found.velocity_limit, found.mimic) == ((-4.0, 5.0), None, None)
    assert (found.body, found.dof, found.kind) == ("b", 0, JointKind.HINGE)
    assert found.stated == {"range", "damping", "armature", "frictionloss", "effort"}
    assert (found.span.path, found.span.line, found.span.column) == ("m.xml", 2, 1)


def test_defaults_are_not_stated() -> None:
    """A bare joint has the engine's defaults, and states none of them."""
    (found,) = read(one_joint('<joint name="j"/>')).joints
    assert (found.stated, found.damping, found.range, found.effort_range) == (frozenset(), 0.0, None, None)


def test_stated_zero_is_stated() -> None:
    """An authored 0 is a statement, unlike an absent one."""
    (found,) = read(one_joint('<joint name="j" damping="0" limited="false"/>')).joints
    assert found.stated == {"damping", "range"}


def test_polynomial_damping_is_split() -> None:
    """The linear coefficient is `damping`; the others have their own field."""
    (found,) = read(one_joint('<joint name="j" damping="1 2 3"/>')).joints
    assert (found.damping, found.damping_polynomial) == (1.0, (2.0, 3.0))


def test_springdamper_overwrites() -> None:
    """tc = 0.1 s and zeta = 1 with I = 1 give damping 2/tc = 20 and stiffness 1/tc^2 = 100."""
    joint = '<joint name="j" springdamper="0.1 1" damping="0.3" stiffness="7"/>'
    (found,) = read(one_joint(joint)).joints
    assert found.springdamper
    assert (found.damping, found.stiffness) == pytest.approx((20.0, 100.0))
    (alone,) = read(one_joint('<joint name="j" springdamper="0.1 1"/>')).joints
    assert (alone.stated, alone.damping) == ({"damping"}, pytest.approx(20.0))
    (out_of_force,) = read(one_joint('<joint name="j" springdamper="0 0" damping="0.3"/>')).joints
    assert (out_of_force.springdamper, out_of_force.damping) == (False, 0.3)


CLASSES = """<mujoco><default><joint armature="0.01"/>
  <default class="leg"><joint damping="2"/><default class="knee">
   <joint frictionloss="0.4"/></default></default>
  <default class="arm"><joint actuatorfrcrange="-9 9"/></default></default>
<worldbody>
<body name="a" childclass="leg"><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>
 <joint name="inherits"/>
 <joint name="own" class="arm" axis="1 0 0"/>
 <frame childclass="knee"><joint name="framed" axis="0 1 0"/></frame>
 <body name="c" childclass="arm"><joint name="nearer"/><geom size="0.1"/></body>
 <body name="d"><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/><joint name="through"/></body>
</body>
<body name="e"><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/><joint name="plain"/></body>
</worldbody></mujoco>"""


@pytest.mark.parametrize(
    ("name", "stated", "line"),
    [
        ("inherits", {"armature", "damping"}, 7),
        ("own", {"armature", "axis", "effort"}, 8),
        ("framed", {"armature", "axis", "damping", "frictionloss"}, 9),
        ("nearer", {"armature", "effort"}, 10),
        ("through", {"armature", "damping"}, 11),
        ("plain", {"armature"}, 13),
    ],
)
def test_classes_state(name: str, stated: set[str], line: int) -> None:
    """class=, childclass of body and frame, nested classes and the main one, as MuJoCo resolves them."""
    joint = read(CLASSES).joint(name)
    assert joint is not None
    assert (joint.stated, joint.span.line) == (stated, line)
    # The second implementation is MuJoCo's own: what is stated has a value, and nothing else has.
    has = {f for f in ("armature", "damping", "frictionloss") if getattr(joint, f)}
    assert has | ({"effort"} if joint.effort_range else set()) == stated - {"axis"}


def test_includes_have_their_own_lines() -> None:
    """Joints and actuators of included files are in those files; equal base names do not collide."""
    text = """<mujoco>
<include file="a/leg.xml"/>
<include file="b/leg.xml"/>
</mujoco>"""
    leg = """<mujoco><worldbody>

<body><joint name="{0}" damping="{1}"/><geom size="0.1"/></body></worldbody>
<actuator><motor joint="{0}"/></actuator></mujoco>"""
    view = read(text, a__leg_xml=leg.format("j", 1), b__leg_xml="\n" + leg.format("k", 2))
    assert [(j.name, j.span.path, j.span.line, j.damping) for j in view.joints] == [
        ("j", "a/leg.xml", 3, 1.0),
        ("k", "b/leg.xml", 4, 2.0),
    ]
    assert [(a.target, a.span.path, a.span.line) for a in view.actuators] == [
        ("j", "a/leg.xml", 4),
        ("k", "b/leg.xml", 5),
    ]
    assert [file.path for file in view.files] == ["m.xml", "a/leg.xml", "b/leg.xml"]


@pytest.mark.parametrize("broken", ['class="none"', 'range="1 0" limited="true"', 'damping="x"'])
def test_engine_error_has_the_author_line(broken: str) -> None:
    """What MuJoCo refuses in an included file is placed there, where MuJoCo itself says line 0."""
    text = '<mujoco>\n\n<include\n file="leg.xml"/><worldbody/>\n</mujoco>'
    leg = (
        f'<mujoco>\n<worldbody><body>\n<joint name="j" {broken}/><geom size="1"/></body></worldbody></mujoco>'
    )
    (error,) = errors(text, leg_xml=leg)
    assert error.startswith("leg.xml:3: ROBOT111")


def test_engine_error_after_an_include() -> None:
    """Lines after an include are the author's again."""
    text = (
        '<mujoco>\n<include file="leg.xml"/>\n\n<actuator>\n<motor name="m" joint="no"/></actuator></mujoco>'
    )
    leg = "<mujoco>\n\n\n\n\n\n<worldbody/></mujoco>"
    (error,) = errors(text, leg_xml=leg)
    assert error == (
        "m.xml:5: ROBOT111 m: MuJoCo refuses the model: unknown transmission target 'no' for actuator id = 0"
    )


def test_splice_keeps_quoted_brackets_and_comments() -> None:
    """A `>` in a value does not end an include, and an include in a comment is none."""
    main = (
        b'<mujoco model="a>b"><!-- <include file="x"/> --><include file="a>b.xml"></include><size/></mujoco>'
    )
    part = b'<mujoco a=">">\n<option/></mujoco>'
    text = splice(parse_document([ModelFile("m.xml", "", main), ModelFile("a.xml", "a>b.xml", part)]))
    assert text.data == (b'<mujoco model="a>b"><!-- <include file="x"/> -->\n\n<option/>\n<size/></mujoco>\n')
    # Lines of the whole: 1 main, 2-3 the part's 1-2, 4 the main's line 1 again.
    assert [(s.path, s.line) for s in map(text.span, (1, 2, 3, 4))] == [
        ("m.xml", 1),
        ("a.xml", 1),
        ("a.xml", 2),
        ("m.xml", 1),
    ]


def test_reference_is_the_first_keyframe() -> None:
    """The first keyframe's position, else qpos0, which `ref` shifts."""
    slide = '<joint name="j" type="slide" ref="0.2"/>'
    assert read(one_joint(slide)).joints[0].reference_position == 0.2
    keys = '<keyframe><key name="home" qpos="0.7"/><key qpos="0.9"/></keyframe>'
    view = read(one_joint(slide, tail=keys))
    assert (view.joints[0].reference_position, view.keyframes) == (0.7, ("home", ""))
    assert view.joints[0].kind is JointKind.SLIDE


def test_unnamed_joints_are_left_out() -> None:
    """A joint without a name is counted, not shown, but for the free base; dof indices still count both."""
    text = """<mujoco><worldbody><body name="t"><freejoint/><geom size="0.1"/>
      <body><joint name="ball" type="ball" range="0 60"/><geom size="0.1"/>
      <body><joint name="h"/><geom size="0.1" pos="1 0 0"/>
      <body><joint/><geom size="0.1" pos="1 0 0"/></body></body></body></body></worldbody></mujoco>"""
    view = read(text)
    assert [(j.name, j.kind, j.dof) for j in view.joints] == [
        ("ball", JointKind.BALL, 6),
        ("h", JointKind.HINGE, 9),
    ]
    assert [str(d) for d in view.diagnostics] == ["m.xml: ROBOT113 [info]: 1 joint without a name left out"]


def test_names_in_any_script() -> None:
    """Of joints, bodies, actuators and all that these drive; none is an empty text, also as the last of all."""
    text = """<mujoco><worldbody><body name="körper"><joint name="膝"/><geom size="0.1"/><site name="ψ"/>
<body name="b"><joint name="é"/><geom size="0.1"/></body></body></worldbody>
<tendon><fixed name="сухожилие"><joint joint="é" coef="1"/></fixed></tendon>
<actuator><motor name="Мотор" joint="膝"/><motor tendon="сухожилие"/><motor name="a" site="ψ"/></actuator>
<keyframe><key name="стоя"/><key/></keyframe></mujoco>"""
    view = read(text)
    assert [(joint.name, joint.body, joint.parent) for joint in view.joints] == [
        ("膝", "körper", ""),
        ("é", "b", "膝"),
    ]
    assert [(one.name, one.target) for one in view.actuators] == [
        ("Мотор", "膝"),
        ("", "сухожилие"),
        ("a", "ψ"),
    ]
    assert view.keyframes == ("стоя", "")


def test_a_childclass_in_an_included_file() -> None:
    """The main file need not have the word."""
    view = read(
        """<mujoco><default><default class="leg"><joint armature="0.1"/></default></default>
<worldbody><include file="leg.xml"/></worldbody></mujoco>""",
        leg_xml='<mujocoinclude><body childclass="leg"><joint name="j"/><geom size="0.1"/></body></mujocoinclude>',
    )
    (joint,) = view.joints
    assert (joint.armature, joint.stated) == (0.1, frozenset({"armature"}))


def test_replicated_joints_point_at_the_replicate() -> None:
    """Copies have the template's statements and the line of the `replicate`."""
    text = """<mujoco><worldbody>
<replicate count="2" euler="0 0 90">
<body pos="1 0 0"><joint name="j" armature="0.1"/><geom size="0.1"/></body>
</replicate></worldbody>
<actuator><position name="a" joint="j" kp="3"/></actuator></mujoco>"""
    view = read(text)
    assert [(j.name, j.span.line, j.stated) for j in view.joints] == [
        ("j0", 2, {"armature"}),
        ("j1", 2, {"armature"}),
    ]
    assert [(a.target, a.tag, a.span.line) for a in view.actuators] == [
        ("j0", "position", 5),
        ("j1", "position", 5),
    ]


def test_attached_joints_point_at_their_own_text() -> None:
    """A joint of an attached model has its line there, and its class' there; what is not default is not all stated."""
    text = """<mujoco><asset><model name="arm" file="arm.xml"/></asset><worldbody>

<attach model="arm" body="b" prefix="left_"/></worldbody></mujoco>"""
    arm = one_joint('\n<joint name="j" damping="0.4" armature="0" class="soft"/>').replace(
        "<worldbody>",
        '<default>\n<default class="soft"><joint frictionloss="0.2"/></default></default><worldbody>',
    )
    (joint,) = read(text, arm_xml=arm).joints
    assert (joint.name, joint.frictionloss) == ("left_j", 0.2)
    assert (os.path.basename(joint.span.path), joint.span.line) == ("arm.xml", 3)
    assert joint.stated == {"damping", "armature", "frictionloss"}
    assert {name: place.line for name, place in joint.places.items()} == {"frictionloss": 2}


def test_attached_actuators_point_at_their_own_text() -> None:
    """One without a name, which the text does not tell from others, has the line of the `attach`."""
    text = """<mujoco><asset><model name="arm" file="arm.xml"/></asset><worldbody>

<attach model="arm" body="b" prefix="left_"/></worldbody></mujoco>"""
    drives = '<actuator><motor joint="j"/>\n\n\n<motor name="m" joint="j"/></actuator></mujoco>'
    arm = one_joint('<joint name="j"/>').replace("</mujoco>", drives)
    unnamed, named = read(text, arm_xml=arm).actuators
    assert (unnamed.span.line, unnamed.tag) == (3, "")
    assert (os.path.basename(named.span.path), named.span.line, named.tag) == ("arm.xml", 5, "motor")


def test_what_an_attach_without_a_prefix_brings(tmp_path: Path) -> None:
    """By its name, through two models, of which one is called as its root is, once for each side."""
    files = {
        "scene.xml": '<mujoco><asset><model file="arms.xml"/></asset><worldbody><attach model="arms" prefix=""/>'
        "</worldbody></mujoco>",
        "arms.xml": '<mujoco model="arms"><asset><model name="hand" file="hand.xml"/></asset><worldbody>'
        '<body><joint name="arm"/><geom size=".1"/><attach model="hand" body="b" prefix="left_"/></body>\n'
        '<body><attach model="hand" body="b" prefix="right_"/></body></worldbody></mujoco>',
        "hand.xml": one_joint('\n\n<joint name="finger" actuatorfrcrange="-7 7"/>'),
    }
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    joints = load_robot(str(tmp_path / "scene.xml")).joints
    assert [(joint.name, os.path.basename(joint.span.path), joint.span.line) for joint in joints] == [
        ("arm", "arms.xml", 1),
        ("left_finger", "hand.xml", 3),
        ("right_finger", "hand.xml", 3),
    ]
    assert [joint.stated for joint in joints] == [set(), {"effort"}, {"effort"}]


def attaching(*files: str) -> str:
    """A model with a body that attaches the body `b` of each file."""
    models = "".join(f'<model name="m{k}" file="{name}"/>' for k, name in enumerate(files))
    bodies = "".join(f'<attach model="m{k}" body="b" prefix="{k}_"/>' for k in range(len(files)))
    own = f'<body name="b"><joint name="j"/><geom size=".1"/>{bodies}</body>'
    return f"<mujoco><asset>{models}</asset><worldbody>{own}</worldbody></mujoco>"


def test_an_attached_model_attaches_others(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each looks for its own from its folder, never in the working directory."""
    for name, text in {
        "m.xml": attaching("s/arm.xml"),
        "s/arm.xml": attaching("hand.xml"),
        "s/hand.xml": one_joint('<joint name="finger"/>'),
        "w/hand.xml": one_joint('<joint name="wrong"/>'),
    }.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.chdir(tmp_path / "w")
    assert [joint.name for joint in load_robot("../m.xml").joints] == ["j", "0_j", "0_0_finger"]


@pytest.mark.parametrize(
    ("files", "expected"),
    [
        (
            {"m.xml": attaching("arm.xml")},
            "m.xml:1:16: ROBOT006: the attached model cannot be followed: there is no file 'arm.xml'",
        ),
        (
            {"m.xml": attaching("")},
            'm.xml:1:16: ROBOT006: an attached model without a file\n  help: write file="..."',
        ),
        (
            {"m.xml": attaching("../s")},
            "m.xml:1:16: ROBOT006: the attached model cannot be followed: '../s' is a folder",
        ),
        (
            {"m.xml": attaching("notes.txt"), "notes.txt": "the secret"},
            "m.xml:1:16: ROBOT008: the attached model 'notes.txt' is not an MJCF or URDF file",
        ),
        (
            {"m.xml": attaching("part.xml"), "part.xml": "<mujocoinclude><secret/></mujocoinclude>"},
            "m.xml:1:16: ROBOT008: the attached model 'part.xml' is not an MJCF or URDF file",
        ),
        (
            {"m.xml": attaching("m.xml")},
            "m.xml:1:16: ROBOT007: the attached models go in a circle: m.xml -> m.xml",
        ),
        (
            {"m.xml": attaching("a.xml"), "a.xml": attaching("b.xml"), "b.xml": attaching("a.xml")},
            "b.xml:1:16: ROBOT007: the attached models go in a circle: a.xml -> b.xml -> a.xml",
        ),
        (
            {
                "m.xml": attaching("a/leg.xml", "leg.xml"),
                "a/leg.xml": one_joint(""),
                "leg.xml": one_joint(""),
            },
            "m.xml:1:51: ROBOT006: another attached model is called 'leg.xml' too: MuJoCo would take one for the other",
        ),
    ],
    ids=["missing", "empty", "folder", "text", "include", "itself", "circle", "name"],
)
def test_attached_models_that_are_refused(
    files: dict[str, str], expected: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the words of an include, where they are attached, and nothing of a file that is no model is shown."""
    (tmp_path / "s").mkdir()
    (tmp_path / "w").mkdir()
    monkeypatch.chdir(tmp_path / "w")
    for name, text in files.items():
        Path(name).parent.mkdir(exist_ok=True)
        Path(name).write_text(text)
    with pytest.raises(RobotError) as caught:
        load_robot("m.xml")
    assert str(caught.value).startswith(expected) and "secret" not in str(caught.value)
    (reading,) = read_files(["m.xml"], jobs=1)
    assert not reading.readable


def test_too_many_copies_are_refused() -> None:
    """Nested replicates multiply: 1000 * 1000 is refused before MuJoCo makes them."""
    inner = '<replicate count="1000" euler="0 0 1"><body><geom size="1"/></body></replicate>'
    text = (
        f'<mujoco><worldbody>\n<replicate count="1000" euler="0 0 1">{inner}</replicate></worldbody></mujoco>'
    )
    assert errors(text) == [
        'm.xml:2:39: ROBOT110: <replicate count="1000"> makes more than 5000 copies, the most that are read'
    ]


def test_option_is_read() -> None:
    """Time step and the integrator's name in MJCF spelling."""
    text = one_joint('<joint name="j"/>', '<option timestep="0.004" integrator="{}"/>')
    names = ("Euler", "RK4", "implicit", "implicitfast")
    assert [read(text.format(n)).integrator for n in names] == list(names)
    assert read(text.format("Euler")).timestep == 0.004


@pytest.mark.parametrize(
    ("actuator", "control", "kp", "kd", "gain"),
    [
        # gear 3 multiplies kp and kd by 9.
        ('<position {} kp="10" kv="2"/>', "position", 90, 18, 10),
        ('<position {} kp="10" kv="2" timeconst="0.05"/>', "position", 90, 18, 10),
        ('<velocity {} kv="2"/>', "velocity", 0, 18, 2),
        ("<motor {}/>", "motor", 0, 0, 1),
        ('<intvelocity {} kp="10" kv="2" actrange="-1 1"/>', "intvelocity", 90, 18, 10),
        ('<damper {} kv="2" ctrlrange="0 1"/>', "damper", 0, 0, 0),
        ('<cylinder {} area="2"/>', "motor", 0, 0, 2),
        ('<cylinder {} area="2" bias="0 0 -5"/>', "motor", 0, 45, 2),
        ('<cylinder {} area="2" bias="0 -3 -5"/>', "other", 27, 45, 2),
        ('<general {} gainprm="5"/>', "motor", 0, 0, 5),
        ('<general {} gainprm="10" biastype="affine" biasprm="0 -10 -2"/>', "position", 90, 18, 10),
        # Feedback without a biastype is not there.
        ('<general {} gainprm="10" biasprm="0 -10 -2"/>', "motor", 0, 0, 10),
        # The sign bug is kept as it is.
        ('<general {} gainprm="50" biastype="affine" biasprm="0 50 -2"/>', "position", -450, 18, 50),
        ('<general {} gainprm="40" biastype="affine" biasprm="0 -50 -2"/>', "position", 450, 18, 40),
        ('<general {} gainprm="1" biastype="affine" biasprm="0 0 -2"/>', "motor", 0, 18, 1),
        ('<general {} dyntype="integrator" gainprm="1"/>', "other", 0, 0, 1),
        ('<general {} gaintype="affine" gainprm="1 2 3"/>', "other", 0, 0, 1),
        ('<general {} gaintype="affine" gainprm="0 2 3"/>', "other", 0, 0, 0),
    ],
)
def test_actuator_kinds(actuator: str, control: str, kp: float, kd: float, gain: float) -> None:
    """Each shortcut and its `general` form, with gains at the joint."""
    found = driven(actuator.format('name="m" joint="j" gear="3"'))
    assert (found.control, found.kp, found.kd, found.gain) == (control, kp, kd, gain)
    assert (found.tag, found.name, found.index, found.gear) == (actuator[1:].split()[0], "m", 0, 3.0)
    assert (found.transmission, found.target) == ("joint", "j")


@pytest.mark.skipif(not TORQUE_SPACE, reason="`pid` arrives in MuJoCo 3.12")
def test_pid() -> None:
    """A pid has two controls here; its integral gain is its gain."""
    found = driven('<pid joint="j" gear="3" kp="10" kv="2" ki="5" imax="1"/>')
    assert (found.control, found.kp, found.kd, found.gain) == ("pid", 90, 18, 5)


def test_class_residue_is_no_feedback() -> None:
    """A motor in a class of position servos stays a motor, whatever biasprm it inherits."""
    head = '<default><default class="leg"><position kp="20" kv="1"/></default></default>'
    found = driven('<motor class="leg" joint="j"/>', head=head)
    assert (found.control, found.kp, found.kd) == ("motor", 0, 0)


def dcmotor(kp: float, kd: float) -> str:
    """Controller attributes for torque gains, in the installed dialect; V=24, stall 45, no-load 30."""
    if TORQUE_SPACE:
        return f'input="pos" controller="{kp} 0 {kd} 0 0 24"'
    # K = 24/30 = 0.8, R = 0.8*24/45 = 0.426667: kp R/K, kd R/K - K
    ratio = 0.426666666666667 / 0.8
    return f'input="position" controller="{kp * ratio} 0 {kd * ratio - 0.8} 0 0 24"'


def test_dcmotor_position() -> None:
    """Gains of a dcmotor are torques in every dialect, and hold its back-EMF."""
    text = f'<dcmotor joint="j" gear="2" nominal="24 45 30" saturation="24 0 0" {dcmotor(80, 0.5)}/>'
    found = driven(text)
    assert (found.control, found.kp, found.kd) == ("dcmotor", pytest.approx(320), pytest.approx(2.0))
    assert found.force_range == (-24.0, 24.0)


def test_dcmotor_voltage_has_back_emf_only() -> None:
    """Voltage control: kd = K^2/R = 0.64/0.426667 = 1.5 before the gear, kp none."""
    found = driven('<dcmotor joint="j" gear="2" nominal="24 45 30"/>')
    assert (found.control, found.kp, found.kd) == ("dcmotor", 0.0, pytest.approx(6.0))


def test_actuator_side_numbers_stay() -> None:
    """Limits, damping and armature of an actuator are not multiplied by its gear, nor added to the joint."""
    view = read(
        one_joint(
            '<joint name="j" damping="0.5" armature="0.1"/>',
            tail="""<actuator><position name="m" joint="j" gear="3" kp="1" damping="0.7 0.2 0.1"
              armature="0.05" forcerange="-2 3" ctrlrange="-1 1" group="2" delay="0.03" nsample="15"
              timeconst="0.05"/></actuator>""",
        )
    )
    (found,) = view.actuators
    assert (found.damping, found.armature) == ((0.7, 0.2, 0.1), 0.05)
    assert (found.force_range, found.control_range, found.group) == ((-2.0, 3.0), (-1.0, 1.0), 2)
    assert (found.delay, found.time_constant) == (0.03, 0.05)
    assert (view.joints[0].damping, view.joints[0].armature) == (0.5, 0.1)
    assert view.inertia is not None
    # Joint 0.1 + 9 * 0.05 = 0.55; the matrix is the body's 1.
    assert view.inertia.armature[0] == pytest.approx(0.55)
    assert view.inertia.matrices[0, 0, 0] == pytest.approx(1.0)


def test_no_limits() -> None:
    """An actuator without ranges is unlimited, and `forcelimited` false switches a range off."""
    found = driven('<motor joint="j" forcerange="-2 2" forcelimited="false"/>')
    assert (found.force_range, found.control_range) == (None, None)


def test_transmissions() -> None:
    """Joint, jointinparent, tendon, site and body are told apart and named."""
    tail = """<tendon><fixed name="t"><joint joint="j" coef="2"/></fixed></tendon>
<actuator><motor joint="j"/><motor jointinparent="j"/><motor tendon="t"/><motor site="s"/>
<adhesion body="b" ctrlrange="0 1"/></actuator>"""
    view = read(one_joint('<joint name="j"/>', tail=tail))
    assert [(a.transmission, a.target, a.control) for a in view.actuators] == [
        ("joint", "j", "motor"),
        ("jointinparent", "j", "motor"),
        ("tendon", "t", "motor"),
        ("site", "s", "motor"),
        ("body", "b", "other"),
    ]


@pytest.mark.skipif(not TORQUE_SPACE, reason="`pid` arrives in MuJoCo 3.12")
def test_control_range_after_two_controls() -> None:
    """Behind an actuator with two controls the range is still the actuator's own."""
    tail = '<actuator><pid joint="j" kp="1"/><motor joint="j" ctrlrange="-7 7"/></actuator>'
    view = read(one_joint('<joint name="j"/>', tail=tail))
    assert [a.control_range for a in view.actuators] == [None, (-7.0, 7.0)]


def test_nan_is_refused() -> None:
    """MuJoCo takes `nan`; the view does not, and says where."""
    assert errors(one_joint('\n<joint name="j" actuatorfrcrange="-1 nan" actuatorfrclimited="true"/>')) == [
        "m.xml:2:1: ROBOT115 j: effort range must be a number, got nan"
    ]


ASSETS = """<mujoco><compiler meshdir="meshes"/><asset>
<mesh name="o" file="x/same.obj"/><mesh file="y/b.STL"/><mesh file="d.dae"/>
<mesh file="c.msh" scale="0.001 0.001 0.001"/>
<texture name="t" type="2d" file="t.png"/><texture name="u" type="2d" file="u.jpg"/>
<texture name="sky" type="skybox" file="g.png" gridsize="3 4" gridlayout=".U..LFRB.D.."/>
<texture name="six" type="cube" fileright="r.png" fileleft="l.png"/>
<hfield name="h" file="h.png" size="1 1 1 1"/><hfield name="k" file="k.bin" size="1 1 1 1"/>
<skin file="s.skn"/></asset>
<worldbody><geom type="hfield" hfield="h"/><body name="b"><joint name="j"/>{}
<geom type="mesh" mesh="o"/><geom type="mesh" mesh="b"/><geom type="mesh" mesh="c"/>
<geom type="mesh" mesh="d"/></body></worldbody></mujoco>"""


def test_no_asset_file_is_needed() -> None:
    """Every kind of asset has a stand-in; with an explicit inertia nothing is lost by it."""
    view = read(ASSETS.format('<inertial mass="2" pos="0 0 0" diaginertia="0.5 0.5 0.5"/>'))
    assert view.inertia is not None
    assert view.inertia.matrices[0, 0, 0] == pytest.approx(0.5)


def test_inertia_from_absent_meshes_is_unknown() -> None:
    """Without an explicit inertia the stand-ins would be weighed: the inertia is unknown instead."""
    view = read(ASSETS.format(""))
    assert view.inertia is None
    assert view.inertia_reason == (
        "the mass of body 'b' comes from mesh files that are not there or that MuJoCo cannot read (.dae)"
    )
    assert [j.name for j in view.joints] == ["j"]


def test_what_needs_the_inertia_stops_where_a_mesh_is_absent() -> None:
    with pytest.raises(RobotError) as caught:
        bench_model(read(ASSETS.format("")), ["j"], None)
    (told,) = caught.value.diagnostics
    assert (told.code, told.where) == ("SYS001", "robot.model")
    assert told.message.startswith("link inertia is unknown: the mass of body 'b' comes from mesh files")
    assert told.help is not None and told.help.startswith("state masses and inertias in the model")


@pytest.mark.parametrize(
    ("bodies", "called"),
    [
        ('<body name="arm"><joint name="j"/>{}</body>', "body 'arm'"),
        ('<body><joint/><joint name="j" axis="1 0 0"/>{}</body>', "the body of joint 'j'"),
        ('<body><joint name="j"/><geom size="0.1"/><body>{}</body></body>', "a body without a name"),
    ],
)
def test_what_a_body_of_meshes_is_called(tmp_path: Path, bodies: str, called: str) -> None:
    """By its name, else by a joint of its own."""
    geom = '<geom type="mesh" mesh="m"/>'
    text = '<mujoco><asset><mesh name="m" file="m.stl"/></asset><worldbody>{}</worldbody></mujoco>'
    (tmp_path / "r.xml").write_text(text.format(bodies.format(geom)))
    reason = load_robot(str(tmp_path / "r.xml")).inertia_reason
    assert reason == f"the mass of {called} comes from mesh files that are not there"


@pytest.mark.parametrize(
    "name",
    [
        "m.obj",
        "m.OBJ",
        "m.Obj",
        "m.stl",
        "m.STL",
        "m.Stl",
        "m.msh",
        "m.MSH",
        "m.mSh",
        "m.dae",
        "m.ply",
        "m.glb",
        "m",
    ],
)
def test_meshes_that_mujoco_reads(tmp_path: Path, name: str) -> None:
    """As MuJoCo itself has it: with the file there it loads the model, or has no decoder."""
    text = f'<mujoco><asset><mesh name="m" file="{name}"/></asset><worldbody><body><joint name="j"/><geom type="mesh"'
    text += ' mesh="m"/></body></worldbody></mujoco>'
    (tmp_path / "r.xml").write_text(text)
    (tmp_path / name).write_bytes(stand_in("mesh", name))
    try:
        mujoco.MjModel.from_xml_path(str(tmp_path / "r.xml"))
    except ValueError as err:
        assert "no decoder found for mesh file" in str(err)
        assert not decodes(name)
        # What it weighs nobody knows, though the file is there.
        reason = load_robot(str(tmp_path / "r.xml")).inertia_reason
        ending = os.path.splitext(name)[1] or "no ending"
        assert (
            reason
            == f"the mass of the body of joint 'j' comes from mesh files that MuJoCo cannot read ({ending})"
        )
    else:
        assert decodes(name)
        assert load_robot(str(tmp_path / "r.xml")).inertia is not None


def test_a_mesh_that_is_read_beside_one_that_is_not(tmp_path: Path) -> None:
    """The COLLADA weighs nothing: masses come from the other, which is there."""
    (tmp_path / "r.xml").write_text(
        '<mujoco><asset><mesh file="a.obj"/><mesh file="b.dae"/></asset><worldbody><body><joint name="j" axis="0 0 1"/>'
        '<geom type="mesh" mesh="a"/><geom type="mesh" mesh="b" mass="0"/></body></worldbody></mujoco>'
    )
    for name in ("a.obj", "b.dae"):
        (tmp_path / name).write_bytes(stand_in("mesh", "a.obj"))
    assert load_robot(str(tmp_path / "r.xml")).inertia is not None


@pytest.mark.parametrize(
    ("head", "geom", "inertial", "unknown"),
    [
        ("", "", False, True),
        ("", 'mass="0"', False, False),
        ("", 'density="0"', False, False),
        ("", 'mass="3"', False, True),
        ("", "", True, False),
        ('<compiler inertiafromgeom="true"/>', "", True, True),
        ('<compiler inertiagrouprange="0 1"/>', 'group="2"', False, False),
    ],
    ids=["density", "no mass", "no density", "mass", "inertial", "forced", "other group"],
)
def test_what_depends_on_meshes(head: str, geom: str, inertial: bool, unknown: bool) -> None:
    """Only a moving body whose mass MuJoCo takes from a mesh makes the inertia unknown."""
    text = f"""<mujoco>{head}<asset><mesh name="m" file="m.stl"/></asset><worldbody>
      <body name="fixed"><geom type="mesh" mesh="m"/></body>
      <body name="b"><joint name="j"/><geom size="0.1"/></body>
      <body name="c" pos="1 0 0">{'<inertial mass="2" pos="0 0 0" diaginertia="1 1 1"/>' * inertial}
      <joint name="k"/><geom size="0.1"/><geom type="mesh" mesh="m" {geom}/></body></worldbody></mujoco>"""
    view = read(text)
    assert (view.inertia is None) == unknown
    assert ("'c'" in view.inertia_reason) == unknown


MESH = '%s<geom type="mesh" mesh="m" mass="1"/>'


@pytest.mark.parametrize(
    ("head", "joint", "geom", "inner", "known"),
    [
        ("", '<joint name="j" type="slide"/>', 'mass="3"', "", True),
        ("", '<joint name="j" type="slide"/>', "", "", False),
        ("", '<joint name="j" type="slide"/><joint axis="1 0 0"/>', 'mass="3"', "", False),
        ("", '<joint name="j" type="slide"/>', 'mass="3"', '<joint axis="1 0 0"/>', True),
        ("", '<joint name="j" type="slide"/>', 'mass="3"', MESH % '<joint axis="1 0 0"/>', False),
        ("", '<joint name="j" axis="1 0 0"/>', 'mass="3"', '<joint type="slide"/>', False),
        ('<compiler settotalmass="9"/>', '<joint name="j" type="slide"/>', 'mass="3"', "", False),
        ("", "<freejoint/>", 'mass="3"', "", True),
        ("", "<freejoint/>", 'mass="3"', '<joint name="j" axis="1 0 0"/>', False),
    ],
    ids=[
        "slide",
        "density",
        "turns too",
        "behind it",
        "turned mesh",
        "on a hinge",
        "total",
        "loose",
        "floating base",
    ],
)
def test_a_mass_that_is_stated_is_all_that_a_slide_needs(
    head: str, joint: str, geom: str, inner: str, known: bool
) -> None:
    """Behind a hinge, beneath a free joint with others and where masses are scaled, the shape counts: 3 + 2 = 5 kg."""
    view = read(
        f"""<mujoco>{head}<asset><mesh name="m" file="m.stl"/></asset><worldbody><body name="b">{joint}
        <geom type="mesh" mesh="m" {geom}/><body pos="0 0 1">{inner}<geom size="0.1" mass="2"/></body></body>
        </worldbody></mujoco>"""
    )
    assert (view.inertia is not None) == known
    if view.inertia is not None and view.joints:
        assert view.inertia.matrices[0, 0, 0] == pytest.approx(5.0)


WEIGHTLESS = """<mujoco>{head}<asset><mesh name="leg" file="leg.stl"/></asset><worldbody>
  <body name="a"><joint name="hip" axis="0 1 0" springdamper="0.1 1"/><geom type="mesh" mesh="leg"/>
   <body name="b" pos="0 0 -1"><joint name="knee" axis="0 1 0" springdamper="0.1 1"/>
    <inertial pos="0 0 0" mass="1" diaginertia="0.02 0.02 0.02"/></body></body>
  <body name="c"><joint name="lone" axis="0 1 0" springdamper="0.1 1"/>
   <inertial pos="0 0 0" mass="1" diaginertia="0.02 0.02 0.02"/></body></worldbody>
 <tendon>{tendon}</tendon>
 <actuator><position name="h" joint="hip" kp="50" dampratio="1"/><position name="k" joint="knee" kp="50" kv="3"/>
  <position name="l" joint="lone" kp="50" dampratio="1"/></actuator></mujoco>"""


def test_what_follows_the_mass_of_an_absent_mesh_is_unknown() -> None:
    """hip and knee are in one tree with the mesh. The other tree is known: with I = 0.02, k = I/tc^2 = 2 and
    b = 2 I/tc = 0.4; kv = 2 zeta sqrt(kp I) = 2 sqrt(50 * 0.02) = 2.
    """
    view = read(WEIGHTLESS.format(head="", tendon=""))
    hip, knee, lone = view.joints
    assert hip.unknown == knee.unknown == {"stiffness", "damping"}
    assert (hip.stiffness, hip.damping, knee.stiffness, knee.damping) == (0.0, 0.0, 0.0, 0.0)
    assert (lone.unknown, lone.stiffness, lone.damping) == (set(), pytest.approx(2.0), pytest.approx(0.4))
    assert [(a.name, a.kd, set(a.unknown)) for a in view.actuators] == [
        ("h", 0.0, {"kd"}),
        ("k", pytest.approx(3.0), set()),
        ("l", pytest.approx(2.0), set()),
    ]
    reason = "the mass of body 'a' comes from mesh files that are not there"
    assert [d.message for d in view.diagnostics] == [
        f"stiffness and damping from springdamper are unknown (hip, knee): {reason}",
        f"velocity gains from dampratio are unknown (h): {reason}",
    ]
    nameless = read(WEIGHTLESS.format(head="", tendon="").replace('name="h" joint', "joint"))
    assert (
        nameless.diagnostics[1].message
        == f"velocity gains from dampratio are unknown (that of hip): {reason}"
    )


@pytest.mark.parametrize(
    ("head", "tendon"),
    [
        ('<compiler settotalmass="3"/>', ""),
        (
            "",
            '<fixed name="t" armature="0.1"><joint joint="lone" coef="1"/><joint joint="knee" coef="1"/></fixed>',
        ),
    ],
    ids=["total mass", "coupled by a tendon"],
)
def test_a_mesh_may_change_the_inertia_of_other_trees(head: str, tendon: str) -> None:
    """All masses are scaled to the total, and the armature of a tendon couples what it is tied to."""
    view = read(WEIGHTLESS.format(head=head, tendon=tendon))
    assert all(joint.unknown == {"stiffness", "damping"} for joint in view.joints)
    assert [set(a.unknown) for a in view.actuators] == [{"kd"}, set(), {"kd"}]


def test_meshes_that_are_there_are_weighed() -> None:
    """A cube of 0.2 m: 8 kg, I = m a^2/6 = 8*0.04/6 = 0.05333 about its middle."""
    corners = [(x, y, z) for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.1, 0.1)]
    faces = ["1 2 4 3", "5 7 8 6", "1 5 6 2", "3 4 8 7", "1 3 7 5", "2 6 8 4"]
    Path("meshes").mkdir()
    lines = [*(f"v {x} {y} {z}" for x, y, z in corners), *(f"f {face}" for face in faces)]
    Path("meshes/cube.obj").write_text("\n".join(lines) + "\n")
    text = """<mujoco><compiler meshdir="meshes"/><asset><mesh file="cube.obj"/>
      <texture type="2d" file="no.png"/></asset><worldbody><body name="b"><joint name="j"/>
      <geom type="mesh" mesh="cube"/></body></worldbody></mujoco>"""
    view = read(text)
    assert view.inertia is not None
    assert view.inertia.matrices[0, 0, 0] == pytest.approx(8 * 0.04 / 6, rel=1e-3)


def test_engine_is_quiet(capfd: pytest.CaptureFixture[str]) -> None:
    """A warning of the engine is a diagnostic; nothing is printed, and no log is left."""
    body = '<body><joint name="a"/><joint name="b"/><geom size="0.1"/></body>'
    text = f"<mujoco><worldbody>{body}</worldbody></mujoco>"
    try:
        view = read(text)
    except RobotError:
        pass  # MuJoCo 3.7 refuses what later versions warn of.
    else:
        assert {d.code for d in view.diagnostics} <= {"ROBOT112"}
    assert capfd.readouterr() == ("", "")
    assert os.listdir() == ["m.xml"]


def test_what_the_engine_says_in_lines_is_one() -> None:
    """MuJoCo tells each setting on which an attached model differs in a line of its own."""
    body = '<body name="b"><joint name="j"/><geom size="0.1"/></body>'
    Path("part.xml").write_text(
        f'<mujoco><size njmax="500" nconmax="500"/><worldbody>{body}</worldbody></mujoco>'
    )
    view = read(
        '<mujoco><asset><model name="p" file="part.xml"/></asset><worldbody><frame>'
        '<attach model="p" body="b" prefix="p_"/></frame></worldbody></mujoco>'
    )
    said = [d.message for d in view.diagnostics if d.code == "ROBOT112"]
    assert not any("\n" in text for text in said)
    assert not said or "; nconmax: " in said[0]


def test_quiet_collects_what_the_engine_would_log() -> None:
    """A warning of a step goes to the list, not to MUJOCO_LOG.TXT; the user's handler is put back."""
    model = mujoco.MjModel.from_xml_string(one_joint('<joint name="j"/>'))
    data = mujoco.MjData(model)
    before = mujoco.get_mju_user_warning()
    with quiet() as said:
        data.qpos[0] = math.nan
        mujoco.mj_step(model, data)
    assert len(said) == 1
    assert "QPOS" in said[0]
    assert os.listdir() == []
    assert mujoco.get_mju_user_warning() is before


def independent(path: Path) -> Any:
    """MuJoCo's own reading of a real file, meshes stripped by another XML parser."""

    def load(file: Path) -> ET.Element:
        # One file has a closing tag behind its root, which MuJoCo does not mind and this parser does.
        root = ET.fromstring(file.read_bytes().partition(b"</mujoco>")[0] + b"</mujoco>")
        for parent in list(root.iter()):
            for child in list(parent):
                if child.tag == "include":
                    parent.extend(load(path.parent / child.attrib["file"]))
                    parent.remove(child)
        return root

    root = load(path)
    for parent in list(root.iter()):
        for child in list(parent):
            mesh = child.tag == "geom" and ("mesh" in child.attrib or child.get("type") in ("mesh", "hfield"))
            file = child.tag in ("mesh", "hfield", "texture", "skin") and parent.tag == "asset"
            if mesh or file or child.tag in ("material", "sensor", "visual", "contact"):
                parent.remove(child)
        if parent.tag == "geom":
            parent.attrib.pop("material", None)
    return mujoco.MjModel.from_xml_string(ET.tostring(root, "unicode"))


@pytest.mark.slow
@pytest.mark.skipif(not REAL, reason="no corpus of real robot files")
@pytest.mark.parametrize("path", REAL, ids=lambda p: str(p.relative_to(CORPUS)))
def test_real_file_equals_independent_compile(path: Path) -> None:
    """Every real MJCF: names, order and numbers are those of MuJoCo on the file without its meshes."""
    view = load_robot(str(path))
    model = independent(path)
    named = [i for i in range(model.njnt) if model.joint(i).name]
    assert [j.name for j in view.joints] == [model.joint(i).name for i in named]
    for joint, i in zip(view.joints, named, strict=True):
        dof = model.jnt_dofadr[i]
        assert joint.dof == dof
        assert (joint.damping, joint.armature, joint.frictionloss, joint.stiffness) == (
            model.dof_damping[dof],
            model.dof_armature[dof],
            model.dof_frictionloss[dof],
            model.jnt_stiffness[i],
        )
        assert joint.range == (tuple(model.jnt_range[i]) if model.jnt_limited[i] else None)
        assert joint.effort_range == (tuple(model.jnt_actfrcrange[i]) if model.jnt_actfrclimited[i] else None)
    assert [a.name for a in view.actuators] == [model.actuator(i).name for i in range(model.nu)]
    assert [a.target for a in view.actuators] == [model.joint(i).name for i in model.actuator_trnid[:, 0]]
    assert [a.control_range for a in view.actuators] == [
        tuple(r) if limited else None
        for r, limited in zip(model.actuator_ctrlrange, model.actuator_ctrllimited, strict=True)
    ]
    assert view.inertia is not None
    data = mujoco.MjData(model)
    if model.nkey:
        mujoco.mj_resetDataKeyframe(model, data, 0)
    else:  # a calf of -2.7 to -0.8 rad is never at the zero of a model without a keyframe
        for joint in view.joints:
            if joint.range is not None and joint.kind.is_scalar:
                address = model.joint(joint.name).qposadr[0]
                data.qpos[address] = np.clip(data.qpos[address], *joint.range)
    mujoco.mj_forward(model, data)
    columns = np.zeros((model.nv, model.nv))
    for column, unit in zip(columns, np.eye(model.nv), strict=True):
        mujoco.mj_mulM(model, data, column, unit)
    np.testing.assert_allclose(
        view.inertia.matrices[0] + np.diag(view.inertia.armature), columns, rtol=1e-9, atol=1e-12
    )


def test_open_spec_is_public_for_edits() -> None:
    """A spec can be edited and compiled again, and an error names the line of its element."""
    files = (ModelFile("m.xml", "", one_joint('\n<joint name="j"/>').encode()),)
    spec = open_spec(files, format=ModelFormat.MJCF)
    assert mesh_dependence(spec) is None
    spec.joint("j").armature = 0.25
    assert compile_spec(spec, files).dof_armature[0] == 0.25
    spec.joint("j").range = [1, 0]
    spec.joint("j").limited = 1
    with pytest.raises(RobotError) as caught:
        compile_spec(spec, files)
    assert (caught.value.diagnostics[0].span, caught.value.diagnostics[0].where) == (
        splice(parse_document(files)).span(2),
        "j",
    )


def test_what_follows_an_include_on_its_line_is_kept() -> None:
    """An element right behind `<include/>` is not swallowed with it."""
    main = ModelFile("m.xml", "", b'<mujoco><include file="c.xml"/><worldbody><body><joint name="j"/>'
                     b'<geom size="1"/></body></worldbody></mujoco>')  # fmt: skip
    other = ModelFile("c.xml", "c.xml", b"<mujoco><option timestep='0.004'/></mujoco>")
    view = read_mjcf((main, other))
    assert [joint.name for joint in view.joints] == ["j"]
    assert view.timestep == 0.004
