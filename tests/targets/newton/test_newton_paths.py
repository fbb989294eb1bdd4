"""Where the overlay looks for the joints' prims."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.api import compile as compile_spec
from actspec.diagnostics import EmitError
from actspec.robot.read_urdf import read_urdf
from actspec.robot.view import ModelFile
from tests.targets.leg import LEG, group
from tests.targets.newton.emitting import emitted, refused, written

ONE = group(effort_limit="24 N*m")
TWO = "  leg: {joints: [hip, calf], level: ideal_pd, kp: 25 N*m/rad, kd: 0.5 N*m*s/rad, effort_limit: 9 N*m}"
LEGS = 'unmanaged: ["rod"]'


def targets(**options: object) -> list[str]:
    """Targets of the actuators of hip and calf."""
    found = written(TWO, robot=LEGS, **options)  # type: ignore[arg-type]
    return [
        prim["newton:targets"].strip("<>")
        for prim in found.prims.values()
        if prim["is"] == "def NewtonActuator"
    ]


def test_of_an_mjcf() -> None:
    """Joints are nested in their bodies, as mujoco-usd-converter writes them, and each has its prim."""
    at = "/leg/Geometry/trunk/thigh"
    assert targets() == [f"{at}/hip", f"{at}/shank/calf"]
    prims = written(TWO, robot=LEGS).prims
    assert [path for path, prim in prims.items() if prim["apis"][:1] == ["NewtonJointAPI"]] == [
        f"{at}/hip",
        f"{at}/shank/calf",
    ]


def test_of_a_urdf() -> None:
    """Joints are in one scope, as urdf-usd-converter writes them."""
    urdf = (
        b'<robot name="cart"><link name="base"/><link name="arm"/><joint name="turn" type="revolute">'
        b'<parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>'
        b'<limit effort="5" velocity="9" lower="-1" upper="1"/></joint></robot>'
    )
    view = read_urdf((ModelFile("/models/cart.urdf", "", urdf),))
    spec = ONE.replace("[hip]", "[turn]")
    one = written(spec, LEG.replace('"hip"', '"turn"'))
    found = emitted(one.actuators, view)
    assert found.prims["/cart/Physics/turn"]["apis"][0] == "NewtonJointAPI"
    assert found.attributes("/cart/NewtonActuators/turn")["newton:targets"] == "</cart/Physics/turn>"


def test_root() -> None:
    """A stated root stands for the robot's name, and the actuators are below it."""
    at = "/World/Robot/Geometry/trunk/thigh"
    assert targets(root="/World/Robot") == [f"{at}/hip", f"{at}/shank/calf"]
    assert "/World/Robot/NewtonActuators" in written(ONE, root="/World/Robot").prims


def test_stated_paths() -> None:
    """Below the root or absolute, by pattern; a joint that none matches keeps its converter's path."""
    assert targets(joint_paths=((".*", "joints/{joint}"),)) == ["/leg/joints/hip", "/leg/joints/calf"]
    assert targets(joint_paths=(("hip", "/elsewhere/{joint}_joint"),)) == [
        "/elsewhere/hip_joint",
        "/leg/Geometry/trunk/thigh/shank/calf",
    ]
    assert targets(joint_paths=(("hip", "a/{joint}/{joint}"), ("calf", "b"))) == ["/leg/a/hip/hip", "/leg/b"]


@pytest.mark.parametrize(
    "root",
    [
        "World",
        "/",
        "",
        "/a b",
        "/a/",
        "//a",
        '/a"',
        "/a>",
        "/a{v=x}",
        "/a.b",
        "/1",
        "/a\n",
        "/" + "a/" * 600 + "a",
    ],
)
def test_bad_root(root: str) -> None:
    """What is not a valid USD prim path is refused before anything of it is written."""
    (said,) = refused(ONE, root=root)
    assert said.startswith("NWT008 targets.newton.root: '")
    assert said.endswith("' is not a valid USD prim path")


@pytest.mark.parametrize(
    "template",
    ["joints/{joint}/", "{joint} x", "../{joint}", "a>{joint}", "{joint:x}", "/", "", "{joint.__class__}"],
)
def test_bad_path(template: str) -> None:
    """The same of a joint's; nothing but {joint} is replaced."""
    (said,) = refused(ONE, joint_paths=(("hip", template),))
    assert said.startswith("NWT008 targets.newton.joint_paths.hip: '")
    assert said.endswith("is not a valid USD prim path (joint hip)")


@pytest.mark.parametrize(
    ("joint_paths", "expected"),
    [
        ((("knee", "{joint}"),), "NWT011 targets.newton.joint_paths.knee: pattern 'knee' matches no joint"),
        ((("(a+)+", "{joint}"),), "NWT011 targets.newton.joint_paths.(a+)+: '(a+)+' has a repeat"),
        (
            (("h.*", "a/{joint}"), (".*", "b/{joint}")),
            "NWT011 targets.newton.joint_paths..*: hip: matched by 'h.*' too",
        ),
        (((".*", "joint"),), "NWT010 targets.newton.joint_paths: hip, calf have one path, /leg/joint"),
    ],
    ids=["no-match", "refused", "twice", "one-path"],
)
def test_paths_refused(joint_paths: tuple[tuple[str, str], ...], expected: str) -> None:
    """Patterns are those of joints everywhere; a joint has one path, and a path one joint."""
    (said,) = refused(TWO, robot=LEGS, joint_paths=joint_paths)
    assert said.startswith(expected)


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ('<joint name="hip"', '<joint name="hip-joint"', "hip-joint"),
        ('<body name="thigh">', "<body>", "hip"),
        ('<body name="trunk">', '<body name="2nd">', "hip"),
        # The geom of the same body is converted first, and has the name.
        (
            '<geom size="0.1"/>\n        <body name="shank">',
            '<geom name="hip" size="0.1"/><body name="shank">',
            "hip",
        ),
    ],
    ids=["joint", "unnamed-body", "body", "geom"],
)
def test_name_that_a_converter_changes(old: str, new: str, what: str) -> None:
    """What the converter makes of a name that no prim can have, or that is taken, is not guessed."""
    assert old in LEG
    spec = ONE.replace("[hip]", f"[{what}]")
    assert refused(spec, LEG.replace(old, new)) == [
        f"NWT009 targets.newton.joint_paths: {what}: the converter's path is unknown, because a name on it is not a "
        "valid USD prim name or not unique in its body"
    ]
    found = written(spec, LEG.replace(old, new), joint_paths=((".*", "joints/j"),))
    assert "/leg/joints/j" in found.prims


def test_name_of_a_robot_that_a_converter_changes() -> None:
    """A robot's name that is no prim's needs a root."""
    model = LEG.replace('model="leg"', 'model="my leg"')
    assert refused(ONE, model) == [
        "NWT009 targets.newton.root: the robot's name 'my leg' is not a valid USD prim name, so the path of its "
        "prim is unknown"
    ]
    assert "/leg/Geometry/trunk/thigh/hip" in written(ONE, model, root="/leg").prims


def test_without_a_model() -> None:
    """A robot that is a list of joints has no stage that could be known."""
    robot = "model: none, joints: [{name: hip}]"
    assert refused(ONE, None, robot=robot) == [
        "NWT009 targets.newton.joint_paths: the spec names no model, so it is unknown where the joints are in the stage"
    ]
    found = written(ONE, None, robot=robot, joint_paths=((".*", "joints/{joint}"),))
    assert "/probe/joints/hip" in found.prims


def test_joints_that_share_a_body() -> None:
    """Newton merges them into one, which takes no actuator: refused, whatever the paths."""
    model = LEG.replace('<joint name="calf"', '<joint name="twist" axis="1 0 0"/><joint name="calf"')
    spec = TWO.replace("hip, calf", "hip, calf")
    with pytest.raises(EmitError) as caught:
        written(spec, model, robot='unmanaged: ["rod", "twist"]')
    (said,) = caught.value.diagnostics
    assert said.code == "NWT012"
    assert said.message.startswith("calf: not alone on its body")


def test_bodies_without_a_name_are_not_one(tmp_path: Path) -> None:
    """Two joints on two bodies that nobody named share none."""
    (tmp_path / "m.xml").write_text(
        '<mujoco model="m"><worldbody><body><joint name="hip"/><geom size="0.1"/></body>'
        '<body pos="1 0 0"><joint name="calf"/><geom size="0.1"/></body></worldbody></mujoco>'
    )
    (tmp_path / "s.yaml").write_text(
        "actspec: 1\nrobot: {name: m, model: m.xml}\ntiming: {physics_dt: 2 ms}\nactuators:\n"
        "  leg: {joints: [hip, calf], level: ideal_pd, kp: 9 N*m/rad, kd: 1 N*m*s/rad, effort_limit: 9 N*m}\n"
        'targets: {newton: {version: "1.8", joint_paths: {".*": "joints/{joint}"}}}\n'
    )
    made = compile_spec(str(tmp_path / "s.yaml"), output=str(tmp_path / "out"))
    assert {item.code for item in made.diagnostics} & {"NWT012"} == set()


def test_errors_of_paths_and_drives_come_together() -> None:
    """A path that cannot be told does not hide a law that lacks a number."""
    robot = "model: none, joints: [{name: hip}]"
    found = refused(group(kp="unknown", effort_limit="24 N*m"), None, robot=robot)
    assert [text[:6] for text in sorted(found)] == ["NWT001", "NWT009"]
