"""The author's text after an edit: what is not edited stays byte for byte, paths still lead where they led."""

from __future__ import annotations

import difflib
import os
from pathlib import Path

import pytest

from actspec import api, output
from actspec.diagnostics import EmitError
from tests.compiling import MOTORS, compile_text

mujoco = pytest.importorskip("mujoco")

GROUP = "  g:\n    joints: [{}]\n    level: ideal_pd\n    kp: 40\n    kd: 2\n    effort_limit: 9\n"
HIP = GROUP.format("hip")
FRICTION = "    friction: {viscous: 0.25}\n"

ROBOT = """<?xml version="1.0" encoding="utf-8"?>
<!-- A robot.   Its author's  spacing. -->
<mujoco   model='x'  >
\t<worldbody>
\t\t<body name="b">  <!-- first -->
\t\t\t<joint name="hip"
\t\t\t       axis='0 1 0'   damping = "0.1"  />
\t\t\t<geom size=".1"/>
\t\t</body>
\t</worldbody>
\t<actuator>
\t\t<!-- the drive -->
\t\t<motor
\t\t\tname="drive" joint="hip"/> <!-- behind it -->
\t</actuator>
</mujoco>
<!-- the end -->
"""


def changed(before: str, after: str) -> list[str]:
    """Lines of `after` that `before` has not, without the header."""
    added = [line[2:] for line in difflib.ndiff(before.splitlines(), after.splitlines()) if line[:2] == "+ "]
    body = after[after.index("-->", after.index("Written by")) :].splitlines()
    return [line for line in added if line in body and line != "-->"]


def test_untouched_lines_stay() -> None:
    """Only the joint's number and the actuator's element change; tabs, comments and quotes stay."""
    compiled = compile_text(HIP + FRICTION, ROBOT)
    assert changed(ROBOT, compiled.text) == [
        "\t\t\t       axis='0 1 0'   damping = \"0.25\"  />",
        next(line for line in compiled.text.splitlines() if 'name="drive"' in line),
    ]
    assert compiled.text.startswith('<?xml version="1.0" encoding="utf-8"?>\n')
    assert compiled.text.endswith("<!-- the end -->\n")
    assert "<!-- behind it -->" in compiled.text


def test_crlf_stays_crlf() -> None:
    """A file with CRLF has no bare LF afterwards, outside of the header or in it."""
    compiled = compile_text(HIP + FRICTION + GROUP.format("knee").replace("g:", "k:"), crlf())
    data = compiled.emission.files[0].data
    assert data.count(b"\n") == data.count(b"\r\n")
    assert compiled.model.nu == 2


def crlf() -> bytes:
    knee = '<body><joint name="knee"/><geom size=".1"/></body>'
    return ROBOT.replace("</worldbody>", f"{knee}\n\t</worldbody>").replace("\n", "\r\n").encode()


def test_one_line_file() -> None:
    """A file of a single line is edited in place."""
    text = "<mujoco><worldbody><body><joint name='hip'/><geom size='1'/></body></worldbody></mujoco>"
    compiled = compile_text(HIP + FRICTION, text)
    assert "<joint name='hip' damping='0.25'/><geom size='1'/></body></worldbody><actuator>" in compiled.text
    assert compiled.model.nu == 1


NAMES = {
    "quotes": ("a&quot;b'c", "a\"b'c"),
    "unicode": ("хип-ø-关节", "хип-ø-关节"),
    "markup": ("a&lt;b&gt;&amp;c", "a<b>&c"),
    "spaces": ("left  hip ", "left  hip "),
    "newline": ("a&#10;b", "a\nb"),
    "comment": ("a--b-->", "a--b-->"),
}


@pytest.mark.parametrize(("written", "name"), NAMES.values(), ids=NAMES.keys())
def test_odd_names(written: str, name: str) -> None:
    """Names with quotes, markup, newlines or other letters come through, in the text and in the header."""
    text = ROBOT.replace('"hip"', f'"{written}"').replace('"drive"', f'"{written}"')
    quoted = '"' + name.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'
    compiled = compile_text(GROUP.format(r"'[\s\S]*'") + f"    note: {quoted}\n", text)
    model = compiled.model
    assert mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_ACTUATOR, 0) == name
    assert mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, 0) == name
    assert model.actuator_trnid[0, 0] == 0


# -- includes ----------------------------------------------------------------------------------

MAIN = """<mujoco>
  <include file="parts/joints.xml"/>
  <include file="extras.xml"/>
  <include file="parts/drives.xml"/>
</mujoco>
"""
FILES = {
    "parts/joints.xml": "<mujoco><worldbody><body><joint name='hip'/><geom size='.1'/></body></worldbody></mujoco>\n",
    "extras.xml": "<mujoco><visual><map znear='.1'/></visual></mujoco>\n",
    "parts/drives.xml": "<mujoco>\n  <actuator>\n    <motor name='m' joint='hip'/>\n  </actuator>\n</mujoco>\n",
}


def build(tmp_path: Path, files: dict[str, str], group: str = HIP, *, canonical: bool = False) -> Path:
    """Compile a model on disk; the main file that was written."""
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text, encoding="utf-8")
    main = next(iter(files))
    spec = tmp_path / "spec.yaml"
    spec.write_text(
        f"actspec: 1\nrobot: {{name: r, model: {main}}}\nmotors:{MOTORS}\nactuators:\n{group}",
        encoding="utf-8",
    )
    version = ".".join(mujoco.__version__.split(".")[:2])
    result = api.compile(
        spec, targets=[f"mujoco=={version}"], output=str(tmp_path / "out"), canonical=canonical
    )
    output.write(output.outputs(result))
    return tmp_path / "out" / "mujoco" / f"{Path(main).stem}.xml"


def test_edited_include_is_written_beside(tmp_path: Path) -> None:
    """Only the include with the actuator is written; the others stay where they are; all load together."""
    main = build(tmp_path, {"robot.xml": MAIN, **FILES})
    assert sorted(p.name for p in main.parent.iterdir()) == ["drives.xml", "manifest.json", "robot.xml"]
    text = main.read_text()
    assert '<include file="../../parts/joints.xml"/>' in text
    assert '<include file="../../extras.xml"/>' in text
    assert '<include file="drives.xml"/>' in text
    assert mujoco.MjModel.from_xml_path(str(main)).actuator_biasprm[0, 1] == -40


def test_nested_includes(tmp_path: Path) -> None:
    """A file that includes another is written too, so that all names are seen from one folder."""
    nested = FILES | {
        "parts/joints.xml": "<mujoco><include file='deep/legs.xml'/></mujoco>\n",
        "deep/legs.xml": FILES["parts/joints.xml"],
    }
    main = build(tmp_path, {"robot.xml": MAIN, **nested}, HIP + FRICTION)
    model = mujoco.MjModel.from_xml_path(str(main))
    assert model.dof_damping[0] == 0.25
    assert {p.name for p in main.parent.iterdir()} >= {"joints.xml", "legs.xml", "drives.xml", "robot.xml"}


def test_two_includes_of_one_name(tmp_path: Path) -> None:
    """Files of one base name in two folders get two names."""
    files = {
        "robot.xml": MAIN.replace("parts/joints.xml", "a/part.xml").replace("parts/drives.xml", "b/part.xml"),
        "a/part.xml": FILES["parts/joints.xml"],
        "extras.xml": FILES["extras.xml"],
        "b/part.xml": FILES["parts/drives.xml"],
    }
    main = build(tmp_path, files, HIP + FRICTION)
    assert {p.name for p in main.parent.iterdir()} >= {"part.xml", "part_2.xml"}
    assert mujoco.MjModel.from_xml_path(str(main)).dof_damping[0] == 0.25


# -- assets ------------------------------------------------------------------------------------

TETRA = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
BODY = """<worldbody><body><joint name="hip"/><geom type="mesh" mesh="m"/></body></worldbody>
  <asset><mesh name="m" file="{}"/></asset>"""
COMPILERS = {
    "none": ("", "tetra.obj", "tetra.obj"),
    "meshdir": ('<compiler meshdir="meshes/"/>', "tetra.obj", "meshes/tetra.obj"),
    "assetdir": ('<compiler assetdir="assets"/>', "tetra.obj", "assets/tetra.obj"),
    "both": ('<compiler assetdir="assets" meshdir="meshes"/>', "sub/tetra.obj", "meshes/sub/tetra.obj"),
    "texturedir": ('<compiler texturedir="textures"/>', "tetra.obj", "tetra.obj"),
    "strippath": (
        '<compiler meshdir="meshes" strippath="true"/>',
        "gone/away/tetra.obj",
        "meshes/tetra.obj",
    ),
    "twice": ('<compiler meshdir="old"/><compiler meshdir="meshes"/>', "tetra.obj", "meshes/tetra.obj"),
    "include": ('<include file="c.xml"/>\n', "tetra.obj", "meshes/tetra.obj"),
}


@pytest.mark.parametrize(("compiler", "written", "place"), COMPILERS.values(), ids=COMPILERS.keys())
def test_meshes_are_found_from_the_output(tmp_path: Path, compiler: str, written: str, place: str) -> None:
    """Whatever names the folder, the written file loads with the meshes where they are."""
    mesh = tmp_path / place
    mesh.parent.mkdir(parents=True, exist_ok=True)
    mesh.write_text(TETRA)
    files = {"robot.xml": f"<mujoco>{compiler}{BODY.format(written)}</mujoco>"}
    if "include" in compiler:
        files["c.xml"] = '<mujoco><compiler meshdir="meshes"/></mujoco>'
    model = mujoco.MjModel.from_xml_path(str(build(tmp_path, files)))
    assert model.nmeshvert == 4
    assert model.nu == 1


def test_absolute_folder_stays(tmp_path: Path) -> None:
    """An absolute meshdir is right from everywhere."""
    (tmp_path / "tetra.obj").write_text(TETRA)
    compiler = f'<compiler meshdir="{tmp_path}"/>'
    main = build(tmp_path, {"robot.xml": f"<mujoco>{compiler}{BODY.format('tetra.obj')}</mujoco>"})
    assert compiler in main.read_text()
    assert mujoco.MjModel.from_xml_path(str(main)).nmeshvert == 4


# -- what has no text of its own ---------------------------------------------------------------

REPLICATED = """<mujoco><worldbody><replicate count="2" euler="0 0 90" sep="_">
  <body pos="1 0 0"><joint name="hip"/><geom size=".1"/></body></replicate></worldbody></mujoco>"""


def test_replicated_joint_is_declined() -> None:
    """Its two copies share one text: an error with the reason, and --canonical as the way out."""
    with pytest.raises(EmitError, match=r"MJC004 hip_0: .*<replicate>") as caught:
        compile_text(GROUP.format("hip_.*") + FRICTION, REPLICATED)
    assert all("--canonical" in (item.help or "") for item in caught.value.diagnostics)


def test_replicated_joint_in_canonical_form(tmp_path: Path) -> None:
    """MuJoCo's own form has one element a joint, which can be edited."""
    text = GROUP.format("hip_.*") + FRICTION
    main = build(tmp_path, {"robot.xml": REPLICATED}, text, canonical=True)
    model = mujoco.MjModel.from_xml_path(str(main))
    assert model.nu == 2
    assert model.dof_damping.tolist() == [0.25, 0.25]


ATTACHING = """<mujoco><asset><model name="arm" file="arm.xml"/></asset>
<worldbody><body><joint name="hip"/><geom size=".1"/>
<attach model="arm" body="link" prefix="arm_"/></body></worldbody></mujoco>"""
ARM = (
    "<mujoco><worldbody><body name='link'><joint name='elbow'/><geom size='.1'/></body></worldbody></mujoco>"
)


def test_attached_joint_is_declined(tmp_path: Path) -> None:
    """The text of an attached model is not part of the document: an error with the reason."""
    (tmp_path / "arm.xml").write_text(ARM)
    both = GROUP.format("hip, arm_elbow") + FRICTION
    with pytest.raises(EmitError, match=r"MJC004 arm_elbow: "):
        build(tmp_path, {"robot.xml": ATTACHING}, both)


URDF = """<robot name="two"><link name="base"/><link name="leg"><inertial><mass value="2"/>
<inertia ixx=".1" iyy=".1" izz=".1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="hip" type="revolute"><parent link="base"/><child link="leg"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="7" velocity="3"/><dynamics damping="0.3" friction="0.2"/></joint></robot>"""


def test_urdf_becomes_an_mjcf(tmp_path: Path) -> None:
    """A URDF is written as an MJCF with the drives; what the spec does not state is the URDF's."""
    main = build(tmp_path, {"two.urdf": URDF})
    model = mujoco.MjModel.from_xml_path(str(main))
    assert model.actuator_biasprm[0, :3].tolist() == [0.0, -40.0, -2.0]
    assert model.actuator_forcerange[0].tolist() == [-9.0, 9.0]
    assert model.jnt_range[0].tolist() == [-1.0, 1.0]
    assert (model.dof_damping[0], model.dof_frictionloss[0]) == (0.3, 0.2)
    # 7 N*m of the URDF would cut the 9 N*m of the spec
    assert not model.jnt_actfrclimited[0] or model.jnt_actfrcrange[0, 1] == 9.0


def test_nothing_is_written_outside_of_the_folder(tmp_path: Path) -> None:
    """Every file of a compilation is in the target's folder."""
    build(tmp_path, {"robot.xml": MAIN, **FILES}, HIP + FRICTION)
    before = {"robot.xml", "spec.yaml", "extras.xml", "parts/joints.xml", "parts/drives.xml"}
    found = {p.relative_to(tmp_path).as_posix() for p in tmp_path.rglob("*") if p.is_file()}
    assert {name for name in found - before if not name.startswith(f"out{os.sep}mujoco{os.sep}")} == set()
