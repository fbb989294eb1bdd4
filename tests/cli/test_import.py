"""`actspec import` on the command line: where the spec goes, what is said, and what is refused."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib import metadata
from pathlib import Path

import mujoco
import pytest

from actspec.cli.main import main
from actspec.spec.validate import load_spec

ROOT = Path(__file__).resolve().parents[2]

ROBOT = """<mujoco model="pendulum">
  <option timestep="0.004"/>
  <worldbody>
    <body><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="swing" damping="0.1"/>
      <body><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="free_end"/></body>
    </body>
  </worldbody>
  <actuator><position name="a" joint="swing" kp="20" kv="1" forcerange="-5 5"/></actuator>
</mujoco>
"""

DEPLOY = "joint_names: [swing]\nkp: [25]\nkd: [1]\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder to work in, with an MJCF and a deploy file that disagree."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot.xml").write_text(ROBOT, encoding="utf-8")
    (tmp_path / "deploy.yaml").write_text(DEPLOY, encoding="utf-8")
    return tmp_path


def test_to_a_file(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """With -o the spec is written, and what became of what is said; it compiles."""
    assert main(["import", "robot.xml", "deploy.yaml", "-o", "specs/robot.yaml"]) == 0
    said = capsys.readouterr()
    assert said.out == (
        "wrote specs/robot.yaml: 1 joint in 1 group (swing), from robot.xml, deploy.yaml\n"
        "  unmanaged, no actuator: free_end\n"
        "  no file states armature: swing\n"
        "  no file states friction.coulomb: swing\n"
        "next: check it, then\n"
        "  actspec show specs/robot.yaml\n"
        "  actspec compile specs/robot.yaml\n"
    )
    assert said.err == (
        "deploy.yaml:2:6: DRF010 [warning]: swing: kp is 25 N*m/rad here, which is used, and 20 N*m/rad in "
        "robot.xml:8:13\n"
    )
    assert load_spec("specs/robot.yaml").model.robot.model == "../robot.xml"
    assert main(["compile", "specs/robot.yaml", "-o", "out"]) == 0


def test_to_standard_output(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without -o the spec is all that goes to standard output, so that it can be piped."""
    assert main(["import", "robot.xml"]) == 0
    said = capsys.readouterr()
    assert said.out.startswith("# yaml-language-server: ")
    assert "pendulum: 1 joint in 1 group (swing), from robot.xml\n" in said.err
    assert sorted(os.listdir(folder)) == ["deploy.yaml", "robot.xml"]
    (folder / "piped.yaml").write_text(said.out, encoding="utf-8")
    assert main(["validate", "piped.yaml"]) == 0


def test_init_from_is_the_same(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`init SPEC --from FILE` writes what `import FILE -o SPEC` does, and says it."""
    said = []
    for arguments in (
        ["import", "robot.xml", "-o", "spec.yaml"],
        ["init", "spec.yaml", "--from", "robot.xml"],
    ):
        assert main([*arguments, "--force"]) == 0
        said.append((capsys.readouterr(), (folder / "spec.yaml").read_text(encoding="utf-8")))
    assert said[0] == said[1]


def test_never_overwrites(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file that is there stays as it is, with help; --force replaces it, but never a file that is imported."""
    (folder / "spec.yaml").write_text("mine\n", encoding="utf-8")
    assert main(["import", "robot.xml", "-o", "spec.yaml"]) == 2
    assert capsys.readouterr().err == (
        "spec.yaml: OUT003: exists already, and would be lost\n"
        "  help: name another file, or replace it with --force\n"
        "1 error; nothing was written\n"
    )
    assert (folder / "spec.yaml").read_text(encoding="utf-8") == "mine\n"
    assert main(["import", "robot.xml", "-o", "spec.yaml", "--force"]) == 0
    assert load_spec("spec.yaml").model.actspec == 1
    assert main(["import", "robot.xml", "deploy.yaml", "-o", "deploy.yaml", "--force"]) == 2
    assert (folder / "deploy.yaml").read_text(encoding="utf-8") == DEPLOY


def test_several_robots(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of a file with several robots one must be named, and can be."""
    text = (ROOT / "docs" / "example" / "biped_cfg.py").read_text(encoding="utf-8")
    second = text[text.index("BIPED_CFG") :].replace("BIPED_CFG", "HOPPER_CFG").replace("24.0", "30.0")
    (folder / "robots.py").write_text(
        text.replace('".*_hip", ".*_knee"', '"hip", "knee"')
        + second.replace('".*_hip", ".*_knee"', '"hip", "knee"'),
        encoding="utf-8",
    )
    assert main(["import", "robots.py"]) == 2
    assert "help: name one with --robot: BIPED_CFG, HOPPER_CFG" in capsys.readouterr().err
    assert main(["import", "robots.py", "--robot", "HOPPER_CFG"]) == 0
    assert "effort_limit: {value: 30 N*m, source: robots_cfg}" in capsys.readouterr().out


def test_package(folder: Path) -> None:
    """A model of an installed distribution is named by it, as it was given."""
    try:
        metadata.distribution("mjlab")
    except metadata.PackageNotFoundError:
        pytest.skip("mjlab is not installed")
    model = "package://mjlab/mjlab/asset_zoo/robots/unitree_go1/xmls/go1.xml"
    assert main(["import", model, "-o", "go1.yaml"]) == 0
    assert load_spec("go1.yaml").model.robot.model == model


INERTIAL = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'


def mjcf(joints: str) -> str:
    """A body with these joints."""
    return f"<mujoco><worldbody><body>{INERTIAL}{joints}</body></worldbody></mujoco>"


@pytest.mark.parametrize(
    "files, code, words",
    [
        ({"a.xml": mjcf('<joint name="b" type="ball"/>')}, "DRF001", "nothing"),
        ({"a.xml": mjcf("<joint/>")}, "DRF001", "names"),
        ({"a.xml": mjcf('<freejoint name="f"/>')}, "DRF001", "nothing"),
        ({"a.xml": "<mujoco><worldbody>"}, "ROBOT004", "a.xml:1"),
        ({"a.xml": "<mujoco><nonsense/></mujoco>"}, "DRF006", "MuJoCo refuses the file"),
        (
            {"a.xml": '<mujoco><extension><plugin plugin="acme.pid"/></extension></mujoco>'},
            "DRF006",
            "without that plugin",
        ),
        ({"a.xml": "<svg/>"}, "DRF004", "neither an MJCF"),
        ({"a.xml": ""}, "ROBOT004", "no XML element"),
        (
            {"a.xml": mjcf('<joint name="j"/>' * 2)},
            "DRF006",
            "repeated name",
        ),
        ({"a.urdf": "<robot name='r'><link name='l'/></robot>"}, "DRF001", "nothing"),
        ({"a.py": "import os\nos.system('touch ran')\n"}, "DRF004", "no actuators"),
        ({"a.py": "CFG = (\n"}, "DRF004", "cannot be read"),
        ({"a.yaml": "actspec: 1\n"}, "DRF005", "is a spec already"),
        ({"a.yaml": "a: 1\n"}, "DRF004", "cannot be read"),
        ({"a.txt": "\x00\x01"}, "ROBOT003", "a.txt:1"),
        ({}, "DRF004", "there is no such file"),
    ],
    ids=[
        "ball", "no names", "free", "not XML", "not MJCF", "plugin", "another XML", "empty", "names twice",
        "URDF without joints", "other Python", "broken Python", "broken spec", "other YAML", "binary", "not there",
    ],
)  # fmt: skip
def test_nothing_to_import(
    folder: Path, files: dict[str, str], code: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """What cannot be imported is said with the file's name, without a traceback; nothing is run or written."""
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    before = sorted(os.listdir(folder))
    assert main(["import", *(files or {"missing.xml": ""}), "-o", "spec.yaml"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert code in said.err and words in said.err, said.err
    assert "nothing was written" in said.err
    assert sorted(os.listdir(folder)) == before


def test_spec_is_no_source(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A spec is refused with the command that is meant."""
    assert main(["import", "robot.xml", "-o", "spec.yaml"]) == 0
    capsys.readouterr()
    assert main(["import", "spec.yaml"]) == 2
    assert "spec.yaml: DRF005: is a spec already\n  help: `actspec compile` writes" in capsys.readouterr().err


@pytest.mark.parametrize(
    "arguments, code",
    [
        (["robot.xml", "-o", "folder"], "OUT001"),
        (["robot.xml", "-o", "new/"], "OUT001"),
        (["robot.xml", "-o", "robot.xml/spec.yaml"], "OUT002"),
        (["robot.xml", "-o", "robot.xml", "--force"], "OUT003"),
        (["folder"], "DRF004"),
        (["robot.xml", "-t", "mujoco"], "AUD010"),
        (["robot.xml", "--robot", "nobody"], "DRF007"),
        (["package://no-such-distribution-here/a.xml"], "ROBOT102"),
    ],
    ids=[
        "folder",
        "new/",
        "below a file",
        "itself",
        "a folder to read",
        "no version",
        "no robot",
        "not installed",
    ],
)
def test_refused(folder: Path, arguments: list[str], code: str, capsys: pytest.CaptureFixture[str]) -> None:
    """What cannot be done is said without a traceback, with exit code 2."""
    (folder / "folder").mkdir()
    assert main(["import", *arguments]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert code in said.err
    assert (folder / "robot.xml").read_text(encoding="utf-8") == ROBOT


def test_an_arm_on_a_body_with_a_named_free_joint(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """That joint is the base: four joints without words in one chain are an arm beside a leg, as without it."""
    leg = f'<body>{INERTIAL}<joint name="knee"/></body>'
    chain = "".join(f'<body>{INERTIAL}<joint name="j{at}" axis="0 0 1"/>' for at in range(4)) + "</body>" * 4
    servos = "".join(f'<position joint="j{at}" kp="{20 + 9 * (at % 2)}" kv="1"/>' for at in range(4))
    for free in ('<freejoint name="floating_base"/>', ""):
        tree = f"<worldbody><body>{INERTIAL}{free}{leg}{chain}</body></worldbody>"
        text = f"<mujoco>{tree}<actuator>{servos}</actuator></mujoco>"
        (folder / "thing.xml").write_text(text, encoding="utf-8")
        assert main(["import", "thing.xml", "-o", "thing.yaml", "--force"]) == 0
        assert "4 joints in 1 group (arm)" in capsys.readouterr().out


TANGLE = """<mujoco model="tangle">
  <worldbody>
    <body name="root"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
      BODIES
    </body>
  </worldbody>
  <tendon><fixed name="cable"><joint joint="pulled" coef="1"/></fixed></tendon>
  <equality>
    <joint joint1="follower" joint2="plain"/>
    <connect body1="two_body" body2="looped_body" anchor="0 0 0"/>
  </equality>
  <actuator>
    <position name="p" joint="plain" kp="20" kv="1"/>
    <motor name="two_a" joint="two"/>
    <motor name="two_b" joint="two"/>
    <position name="t" tendon="cable" kp="5"/>
    <muscle name="m" joint="muscle" lengthrange="0 1"/>
  </actuator>
</mujoco>
"""


def test_what_no_spec_can_say(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Tendons, followers, loops, muscles and joints with two motors are left alone by name; the rest compiles."""
    names = ("plain", "two", "pulled", "follower", "looped", "muscle")
    bodies = "".join(f'<body name="{name}_body"><joint name="{name}"/>{INERTIAL}</body>' for name in names)
    socket = f'<body name="s"><joint name="ball" type="ball"/>{INERTIAL}</body>'
    (folder / "tangle.xml").write_text(TANGLE.replace("BODIES", bodies + socket), encoding="utf-8")
    assert main(["import", "tangle.xml", "-o", "spec.yaml"]) == 0
    out = capsys.readouterr().out
    for line in (
        "wrote spec.yaml: 1 joint in 1 group (plain), from tangle.xml",
        "unmanaged, 2 actuators (motor, motor): two",
        "unmanaged, driven through the tendon 'cable': pulled",
        "unmanaged, follows 'plain' (equality): follower",
        "unmanaged, no actuator, in the closed loop of two_body and looped_body (connect): looped",
        "unmanaged, an actuator of another kind (muscle): muscle",
    ):
        assert line in out
    assert main(["compile", "spec.yaml", "-o", "out"]) == 0


def test_names_of_a_stranger(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Escape sequences in a file's names never reach the terminal."""
    text = ROBOT.replace('"free_end"', '"free&#10;end \u202e"').replace('"pendulum"', '"pen&#9;dulum\u202e"')
    (folder / "robot.xml").write_text(text, encoding="utf-8")
    assert main(["import", "robot.xml"]) == 0
    said = capsys.readouterr()
    assert "\u202e" not in said.out + said.err
    assert "free\\nend \\u202e" in said.err


FOLLOWERS = "".join(
    f'<link name="{side}{n}"/><joint name="{side}_finger{n}" type="revolute"><parent link="{parent}"/>'
    f'<child link="{side}{n}"/><limit lower="-1" upper="1" effort="1" velocity="2"/>{mimic}</joint>'
    for side in ("L", "R")
    for n, parent, mimic in (
        (1, "base", ""),
        (2, f"{side}1", f'<mimic joint="{side}_finger1"/>'),
    )
)


def test_followers_are_one_line(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Joints that each follow another one have one reason, and the spec one pattern."""
    (folder / "hand.urdf").write_text(
        f'<robot name="hand"><link name="base"/>{FOLLOWERS}</robot>', encoding="utf-8"
    )
    assert main(["import", "hand.urdf", "-o", "spec.yaml"]) == 0
    assert "unmanaged, follow other joints (mimic): L_finger2, R_finger2\n" in capsys.readouterr().out
    assert '    - ".*_finger2"    # follow other joints (mimic)\n' in Path("spec.yaml").read_text(
        encoding="utf-8"
    )


def test_poses_are_one_warning(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of two files with other poses, one joint stands for all; the spec has each."""
    names = ("hip", "knee", "ankle")
    joints = "".join(f'<body>{INERTIAL}<joint name="{name}"/>' for name in names)
    servos = "".join(f'<position joint="{name}" kp="20" kv="1"/>' for name in names)
    (folder / "leg.xml").write_text(
        f"<mujoco><worldbody>{joints}{'</body>' * 3}</worldbody><actuator>{servos}</actuator>"
        '<keyframe><key qpos="0.1 0.2 0.3"/></keyframe></mujoco>',
        encoding="utf-8",
    )
    (folder / "leg.yaml").write_text(
        "joint_names: [hip, knee, ankle]\nkp: [20, 20, 20]\nkd: [1, 1, 1]\ndefault_joint_pos: [0.1, 0.5, 0.6]\n",
        encoding="utf-8",
    )
    assert main(["import", "leg.xml", "leg.yaml", "-o", "spec.yaml"]) == 0
    assert capsys.readouterr().err == (
        "leg.yaml:4:26: DRF010 [warning]: knee: default_pose is 0.5 rad here, which is used, and 0.2 rad in "
        "leg.xml:1:435; the poses of 1 other joints differ too\n"
    )
    assert '    "ankle": {value: 0.6 rad, source: leg_deploy}    # leg.xml:1 has 0.3 rad\n' in (
        Path("spec.yaml").read_text(encoding="utf-8")
    )


CFG = """from isaaclab.actuators import ImplicitActuatorCfg
from isaaclab.assets import ArticulationCfg
"""


def test_gains_that_cannot_be_read(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A drive whose gains cannot be folded stays a position drive beside a torque motor, and what failed is said."""
    (folder / "robot.xml").write_text(
        ROBOT.replace('<position name="a" joint="swing" kp="20" kv="1"', '<motor joint="swing"'),
        encoding="utf-8",
    )
    (folder / "cfg.py").write_text(
        CFG + 'A_CFG = ArticulationCfg(actuators={"all": ImplicitActuatorCfg(\n'
        '    joint_names_expr=["swing", "(a+)+$"], stiffness=elsewhere(), damping=elsewhere())})\n',
        encoding="utf-8",
    )
    assert main(["import", "robot.xml", "cfg.py", "-o", "spec.yaml"]) == 0
    said = capsys.readouterr()
    assert "cfg.py:4:53: CFG001 [info] all.stiffness: not known without running it:" in said.err
    assert "cfg.py: group all: '(a+)+$' has a repeat" in said.out and "so it selects no joint" in said.out
    group = load_spec("spec.yaml").model.actuators["all"]
    assert group.command == "position" and group.kp is not None and group.kp.written == "unknown"


def test_robot_file_that_a_configuration_reads(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A configuration alone names the file to name too, where it reads one that is there."""
    text = """import mujoco
from mjlab.actuator import BuiltinPositionActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg, EntityCfg

def get_spec():
    return mujoco.MjSpec.from_file("robot.xml")

A = EntityArticulationInfoCfg(
    actuators=(BuiltinPositionActuatorCfg(target_names_expr=("PATTERN",), stiffness=1.0, damping=1.0),)
)
def get_cfg():
    return EntityCfg(spec_fn=get_spec, articulation=A)
"""
    (folder / "cfg.py").write_text(text.replace("PATTERN", "sw.*"), encoding="utf-8")
    assert main(["import", "cfg.py"]) == 2
    assert "help: name robot.xml too, which it reads" in capsys.readouterr().err
    (folder / "cfg.py").write_text(text.replace("PATTERN", "swing"), encoding="utf-8")
    assert main(["import", "cfg.py"]) == 0
    err = capsys.readouterr().err
    assert "all are taken as hinges; a joint that slides is" in err
    assert "the configuration reads robot.xml: name it too" in err


def test_a_target_that_cannot_be_served(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What the spec cannot be compiled to is a comment with the reason; the others compile."""
    cfg = CFG.replace("ImplicitActuatorCfg", "IdealPDActuatorCfg") + (
        'A_CFG = ArticulationCfg(actuators={"all": IdealPDActuatorCfg(\n'
        '    joint_names_expr=["swing"], stiffness=20.0, damping=1.0)})\n'
    )
    (folder / "robot.xml").write_text(ROBOT.replace(' forcerange="-5 5"', ""), encoding="utf-8")
    (folder / "cfg.py").write_text(cfg, encoding="utf-8")
    assert main(["import", "robot.xml", "cfg.py", "-o", "spec.yaml"]) == 0
    out = capsys.readouterr().out
    assert "  target isaaclab is left out: ISL010: swing: effort_limit is unknown" in out
    text = (folder / "spec.yaml").read_text(encoding="utf-8")
    assert (
        '\ntargets:\n  mujoco: {version: "3.12"}\n  # isaaclab: {version: "2.3"}\n  #   left out: ISL010: swing'
        in text
    )
    assert list(load_spec("spec.yaml").model.targets) == ["mujoco"]
    assert main(["compile", "spec.yaml", "-o", "out"]) == 0
    capsys.readouterr()
    # Where nothing else is left, a fragment for MuJoCo takes its place.
    assert main(["import", "cfg.py", "-o", "alone.yaml"]) == 0
    assert "isaaclab is left out" in capsys.readouterr().out
    assert list(load_spec("alone.yaml").model.targets) == ["mujoco"]
    assert main(["compile", "alone.yaml", "-o", "alone"]) == 0


def test_a_model_that_attaches(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Joints of an attached model have no text to edit: what import says to go on with compiles."""
    finger = ROBOT[ROBOT.index("<body>") : ROBOT.index("</worldbody>")].replace(
        "<body>", '<body name="palm">', 1
    )
    (folder / "gripper.xml").write_text(f"<mujoco><worldbody>{finger}</worldbody></mujoco>", encoding="utf-8")
    (folder / "arm.xml").write_text(
        '<mujoco><asset><model name="g" file="gripper.xml"/></asset><worldbody><frame>'
        '<attach model="g" body="palm" prefix="g_"/></frame></worldbody>'
        '<actuator><position joint="g_swing" kp="20"/></actuator></mujoco>',
        encoding="utf-8",
    )
    # As kd, the 0.1 N*m*s/rad of the joint go: that is an edit of the attached file.
    assert main(["import", "--damping", "as-kd", "arm.xml", "-o", "arm.yaml"]) == 0
    out = capsys.readouterr().out
    assert (
        "  target mujoco: compile with --canonical: MJC004: 'g_swing' comes from <replicate> or <attach>"
        in out
    )
    assert out.endswith("  actspec compile --canonical arm.yaml\n")
    assert "# compile with --canonical: MJC004" in (folder / "arm.yaml").read_text(encoding="utf-8")
    assert main(["compile", "arm.yaml", "-o", "out"]) == 2
    assert main(["compile", "--canonical", "arm.yaml", "-o", "out"]) == 0
    # What compiles with it is verified with it, written or not.
    assert main(["verify", "arm.yaml", "-t", "mujoco"]) == 2
    assert main(["verify", "--canonical", "arm.yaml", "-t", "mujoco", "--built", "out"]) == 0
    assert main(["verify", "--canonical", "arm.yaml", "-t", "mujoco"]) == 0


PARTS = {
    "scene.xml": '<mujoco><default><default class="j"><joint damping="1"/></default></default>'
    '<include file="./arm.xml"/><actuator><include file="act.xml"/></actuator></mujoco>',
    "arm.xml": mjcf('<joint class="j" name="elbow"/>'),
    "act.xml": '<mujocoinclude><position joint="elbow" kp="10"/></mujocoinclude>',
    "ball.xml": mjcf('<joint name="b" type="ball"/>'),
    "other.xml": '<mujoco><!-- not arm.xml --><include file="ball.xml"/></mujoco>',
}


@pytest.mark.parametrize(
    "part, whole",
    [("arm.xml", "scene.xml"), ("act.xml", "scene.xml"), ("ball.xml", "other.xml"), ("other.xml", "")],
)
def test_a_part_names_its_whole(
    folder: Path, part: str, whole: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file that is no robot alone names the one beside it that includes it."""
    (folder / "sub").mkdir()
    for name, text in PARTS.items():
        (folder / "sub" / name).write_text(text, encoding="utf-8")
    assert main(["import", f"sub/{part}"]) == 2
    said = capsys.readouterr().err
    assert ("it is a part of" in said) is bool(whole)
    assert not whole or f"help: it is a part of sub/{whole}: import the whole model\n" in said
    assert main(["import", "sub/scene.xml"]) == 0


ANGLE = '<mujoco><compiler angle="radian"/><include file="{file}"/><actuator><motor joint="hip"/></actuator></mujoco>'
LEG = f'<mujocoinclude><worldbody><body name="b">{INERTIAL}<joint name="hip"/></body></worldbody></mujocoinclude>'


@pytest.mark.parametrize(
    "part, whole, files",
    [
        ("parts/legs.xml", "main.mjcf", {"main.mjcf": "parts/legs.xml"}),
        ("a/b/legs.xml", "main.xml", {"main.xml": "a/b/legs.xml"}),
        ("a/b/legs.xml", "a/main.xml", {"a/main.xml": "b/legs.xml", "a/b/other.xml": "b/legs.xml"}),
        ("a/b/c/legs.xml", "", {"main.xml": "a/b/c/legs.xml"}),
        ("parts/legs.xml", "", {"main.xml": "legs.xml"}),
        ("parts/legs.xml", "one.xml, two.xml", {"one.xml": "parts/legs.xml", "two.xml": "./parts/legs.xml"}),
        ("a/legs.xml", "a/scenes/s.xml", {"a/scenes/s.xml": "../legs.xml", "a/scenes/t.xml": "legs.xml"}),
        ("a/legs.xml", "a/tasks/flat/s.xml", {"a/tasks/flat/s.xml": "../../legs.xml"}),
        ("a/legs.xml", "", {"a/b/c/d/s.xml": "../../../legs.xml"}),
        ("a/legs.xml", "scenes/s.xml", {"scenes/s.xml": "../a/legs.xml", "a/.old/s.xml": "../legs.xml"}),
        ("a/legs.xml", "scenes/flat/s.xml", {"scenes/flat/s.xml": "../../a/legs.xml"}),
        ("a/legs.xml", "a/s.xml", {"a/s.xml": "legs.xml", "a/scenes/s.xml": "../legs.xml"}),
    ],
    ids=[
        *("above", "two above", "beside is another", "three above", "another legs.xml", "two of them"),
        *("below", "two below", "three below", "beside", "two beside", "near before below"),
    ],
)
def test_a_part_and_its_whole(
    folder: Path, part: str, whole: str, files: dict[str, str], capsys: pytest.CaptureFixture[str]
) -> None:
    """The model is looked for up to two folders above, below and beside; where none is, a part is still told as one."""
    (folder / part).parent.mkdir(parents=True)
    (folder / part).write_text(LEG, encoding="utf-8")
    for name, file in files.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(ANGLE.format(file=file), encoding="utf-8")
    assert main(["import", part]) == 2
    said = capsys.readouterr().err
    told = (
        f"it is a part of {whole}: import the whole model"
        if whole
        else "it is a part of a model: import the file that includes"
    )
    assert f"  help: {told}" in said
    assert "and so would a compile: Unrecognized XML model type" in said


@pytest.mark.parametrize(
    ("mark", "found"), [("", False), ("project/.git", True), ("project/package.xml", True), (".git", True)]
)
def test_a_part_far_from_its_whole(
    folder: Path, mark: str, found: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    """A model in a folder beside one above its parts is found in a project alone; hidden folders are not read."""
    for name in ("project/shared/parts/legs/legs.xml", "project/robot/main.xml", "project/.old/main.xml"):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
    (folder / "project/shared/parts/legs/legs.xml").write_text(LEG, encoding="utf-8")
    for name in ("project/robot/main.xml", "project/.old/main.xml"):
        (folder / name).write_text(ANGLE.format(file="../shared/parts/legs/legs.xml"), encoding="utf-8")
    if mark:
        (folder / mark).write_text("", encoding="utf-8")
    assert main(["import", "project/shared/parts/legs/legs.xml"]) == 2
    said = capsys.readouterr().err
    assert ("  help: it is a part of project/robot/main.xml: import the whole model\n" in said) is found
    assert ("it is a part of a model: import the file that includes it" in said) is not found
    # One that is near counts alone.
    (folder / "project/shared/near.xml").write_text(
        ANGLE.format(file="parts/legs/legs.xml"), encoding="utf-8"
    )
    assert main(["import", "project/shared/parts/legs/legs.xml"]) == 2
    assert "it is a part of project/shared/near.xml: import the whole" in capsys.readouterr().err


def test_a_part_of_a_part(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A part that a part includes names the model of both; a link is not followed."""
    (folder / "legs.xml").write_text(LEG, encoding="utf-8")
    (folder / "body.xml").write_text(
        '<mujocoinclude><include file="legs.xml"/></mujocoinclude>', encoding="utf-8"
    )
    (folder / "main.xml").write_text(ANGLE.format(file="body.xml"), encoding="utf-8")
    (folder / "link.xml").symlink_to(folder / "main.xml")
    assert main(["import", "legs.xml"]) == 2
    assert "  help: it is a part of main.xml: import the whole model\n" in capsys.readouterr().err


@pytest.mark.parametrize(
    "head, whole", [("", ANGLE), ("<compiler/>", ANGLE), ("", ""), ("", "<mujoco/>")], ids=str
)
def test_a_part_that_is_a_model_too(
    folder: Path, head: str, whole: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A file without a compiler that MuJoCo takes is imported, and told to be a part of the one with the angle."""
    text = mjcf('<joint name="hip" range="-1 1"/>').replace("<mujoco>", f"<mujoco>{head}")
    (folder / "legs.xml").write_text(text, encoding="utf-8")
    (folder / "main.xml").write_text(whole.format(file="legs.xml"), encoding="utf-8")
    assert main(["import", "legs.xml"]) == 0
    told = "legs.xml: DRF013 [warning]: has no <compiler>, and is a part of main.xml"
    said = capsys.readouterr().err
    assert (told in said) is (whole == ANGLE and not head)
    assert ("help: import the whole model instead" in said) is (whole == ANGLE and not head)


ATTACHES = (
    '<mujoco><compiler angle="radian"/><asset><model name="l" file="legs.xml"/></asset><worldbody><frame>'
    '<attach model="l" body="b" prefix="l_"/></frame></worldbody></mujoco>'
)


def test_a_part_that_another_attaches(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What is attached keeps its own angles: 90 degrees are the 1.5708 rad of the model that attaches it in radians."""
    text = mjcf('<joint name="hip" range="-90 0"/>').replace("<body>", '<body name="b">')
    (folder / "legs.xml").write_text(text, encoding="utf-8")
    (folder / "main.xml").write_text(ATTACHES, encoding="utf-8")
    model = mujoco.MjModel.from_xml_path("main.xml")
    # 90 pi / 180 = 1.5708
    assert model.joint("l_hip").range.tolist() == pytest.approx([-1.570796, 0.0], abs=1e-6)
    assert main(["import", "legs.xml"]) == 0
    said = capsys.readouterr().err
    assert (
        "legs.xml: DRF013 [info]: main.xml attaches it: angles, classes and limits are those of this file"
        in said
    )
    assert "not read" not in said and "DRF013 [warning]" not in said
    # Where a third model includes it, that lends it its angles.
    (folder / "third.xml").write_text(ANGLE.format(file="legs.xml"), encoding="utf-8")
    assert main(["import", "legs.xml"]) == 0
    said = capsys.readouterr().err
    assert "is a part of third.xml: angles" in said and "main.xml" not in said


def test_bodies_outside_of_the_world(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A part whose bodies stand below <mujoco> is told by their joints and line; a joint that is elsewhere is none."""
    body = f'<mujoco><worldbody/>\n<body>{INERTIAL}<joint name="hip"/></body></mujoco>'
    (folder / "part.xml").write_text(body, encoding="utf-8")
    assert main(["import", "part.xml"]) == 2
    said = capsys.readouterr().err
    # `<body>` 6, the inertia: the joint begins behind them on line 2.
    place = f"part.xml:2:{6 + len(INERTIAL) + 1}: DRF001"
    assert (
        f"{place}: MuJoCo reads no body outside of <worldbody>, where this file has the joint hip\n" in said
    )
    assert "  help: put the bodies into <worldbody>" in said and "no hinge" not in said
    (folder / "main.xml").write_text(
        '<mujoco><worldbody><include file="part.xml"/></worldbody></mujoco>', encoding="utf-8"
    )
    assert main(["import", "part.xml"]) == 2
    assert "  help: it is a part of main.xml: import the whole model\n" in capsys.readouterr().err


def test_two_hundred_robots(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of very many robots some are listed, and the one that is meant is found; nothing of the file is run."""
    robots = "".join(
        f'R{i}_CFG = ArticulationCfg(actuators={{"legs": ImplicitActuatorCfg(joint_names_expr=["a{i}"], '
        f"stiffness={i}.0, damping=1.0)}})\n"
        for i in range(200)
    )
    (folder / "many.py").write_text('open("ran", "w").write("x")\n' + CFG + robots, encoding="utf-8")
    assert main(["import", "many.py"]) == 2
    assert "R19_CFG and 180 more\n" in capsys.readouterr().err
    assert main(["import", "many.py", "--robot", "R7_CFG"]) == 0
    assert "kp: {value: 7 N*m/rad, source: many_cfg}" in capsys.readouterr().out
    assert not (folder / "ran").exists()


def test_where_nothing_can_be_written(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Links that lead nowhere, in a circle or to an imported file, and impossible names, are refused."""
    os.symlink("nowhere/spec.yaml", "dangling.yaml")
    os.symlink("circle", "circle")
    os.symlink("robot.xml", "link.yaml")
    (folder / "part.xml").write_text("<mujoco><worldbody/></mujoco>", encoding="utf-8")
    (folder / "whole.xml").write_text(
        ROBOT.replace("<option", '<include file="part.xml"/><option'), encoding="utf-8"
    )
    before = {name: os.lstat(name).st_mtime_ns for name in os.listdir(folder)}
    for source, output, code in (
        ("robot.xml", "dangling.yaml", "OUT001"),
        ("robot.xml", "circle", "OUT001"),
        ("robot.xml", "link.yaml", "OUT003"),
        ("whole.xml", "part.xml", "OUT003"),
        ("robot.xml", "a\0b", "OUT002"),
        ("circle", "spec.yaml", "DRF004"),
    ):
        assert main(["import", source, "-o", output, "--force"]) == 2
        assert code in capsys.readouterr().err, output
    assert {name: os.lstat(name).st_mtime_ns for name in os.listdir(folder)} == before


def test_file_names_of_a_stranger(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file may be called anything: the spec is valid, names it, and the terminal gets one line."""
    name = "{{ 7*7 }} #'\"\n\u202e.xml"
    (folder / name).write_text(ROBOT, encoding="utf-8")
    assert main(["import", name, "-o", "spec.yaml"]) == 0
    said = capsys.readouterr()
    assert "\u202e" not in said.out + said.err and "from {{ 7*7 }} #'\"\\n\\u202e.xml\n" in said.out
    assert load_spec("spec.yaml").model.robot.model == name
    assert main(["compile", "spec.yaml", "-o", "out"]) == 0


def test_import_stays_light() -> None:
    """Importing the command's module loads no reader."""
    code = (
        "import actspec.cli.import_, sys; print([m for m in ('mujoco', 'numpy', 'yaml') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


UNSOUND = """<robot name="r">
  <link name="a"/>
  <link name="b">
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="5" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><sphere radius="0.1"/></geometry></collision>
    <collision><geometry><sphere radius="0.0"/></geometry></collision>
  </link>
  <joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="10" velocity="5"/></joint>
</robot>
"""


def test_a_urdf_that_mujoco_refuses(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Import says at once why there is no target for MuJoCo, at its line; what mends it goes where the message says.

    A sphere of radius 0 is no shape, and 1 + 1 < 5 no inertia of a body.
    """

    def left_out(text: str) -> str:
        (folder / "r.urdf").write_text(text, encoding="utf-8")
        assert main(["import", "r.urdf"]) == 0
        lines = capsys.readouterr().err.splitlines()
        return next(line for line in lines if "mujoco is left out: " in line).partition("out: ")[2]

    assert left_out(UNSOUND) == "r.urdf:6: MuJoCo refuses the model: size 0 must be positive in geom"
    text = UNSOUND.replace('radius="0.0"', 'radius="0.2"')
    said = left_out(text)
    assert said.startswith("r.urdf:4: MuJoCo refuses the model: inertia must satisfy")
    element = said.split("`")[3]
    assert element == '<mujoco><compiler balanceinertia="true"/></mujoco>'
    text = text.replace('<link name="a"/>', f'{element}<link name="a"/>')
    assert left_out(text) == "its servos need kp and kd, which are unknown"


def test_a_friction_that_no_drive_overcomes(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One line a number that is left out, with where it stands: 5 and 5 of two joints at one place, 8 of a third."""

    def link(name: str, own: str, inner: str) -> str:
        inertial = '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
        return f'<body>{inertial}<joint name="{name}"{own}/>\n{inner}</body>'

    chain = link("hip", "", link("thigh", "", link("knee", ' frictionloss="8"', "")))
    drives = "".join(
        f'<position joint="{name}" kp="20" kv="1" forcerange="-{limit} {limit}"/>'
        # Not above friction of 5, 5 and 8: 3, 4 and 8.
        for name, limit in (("hip", 3), ("thigh", 4), ("knee", 8))
    )
    (folder / "leg.xml").write_text(
        f'<mujoco model="leg">\n<default><joint frictionloss="5"/></default>\n<worldbody>{chain}</worldbody>'
        f"<actuator>{drives}</actuator></mujoco>",
        encoding="utf-8",
    )
    assert main(["import", "leg.xml", "-o", "leg.yaml"]) == 0
    out = capsys.readouterr().out
    why = "which the effort limit cannot overcome"
    told = [line for line in out.splitlines() if "coulomb" in line]
    assert told == [
        f"  friction.coulomb is left out, leg.xml:2 has 5 N*m, {why}: legs (hip, thigh)",
        f"  friction.coulomb is left out, leg.xml:5 has 8 N*m, {why}: legs (knee)",
    ]
    assert f"coulomb: unknown    # the file has 5 N*m, {why}\n" in (folder / "leg.yaml").read_text("utf-8")
