"""Meshes that a URDF names by `package://`: found in the package around it, or reported."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from actspec import api, output
from actspec.cli.main import main
from actspec.diagnostics import RobotError
from actspec.output import Compilation
from actspec.spec.validate import load_spec
from actspec.targets.mujoco.paths import package_file

URDF = """<robot name="r"><link name="a"/>
  <link name="b"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><mesh filename="package://my_desc/meshes/x.obj"/></geometry></collision></link>
  <joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="10" velocity="5"/></joint></robot>
"""
SPEC = """actspec: 1
robot: {name: r, model: urdf/r.urdf}
actuators:
  j: {joints: [j], level: ideal_pd, kp: 4 N*m/rad, kd: 1 N*m*s/rad, effort_limit: 10 N*m, armature: 0 kg*m^2,
      friction: {coulomb: 0 N*m, viscous: 0 N*m*s/rad}}
"""
TETRAHEDRON = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def package(folder: Path, name: str) -> Path:
    """A folder of a ROS package with one mesh."""
    for part in ("urdf", "meshes"):
        (folder / name / part).mkdir(parents=True)
    (folder / name / "urdf" / "r.urdf").write_text(URDF, encoding="utf-8")
    (folder / name / "meshes" / "x.obj").write_text(TETRAHEDRON, encoding="utf-8")
    (folder / name / "s.yaml").write_text(SPEC, encoding="utf-8")
    return folder / name


def compiled(own: Path) -> Compilation:
    """The spec of the package, compiled and written."""
    done = api.compile(own / "s.yaml", targets=["mujoco"], output=str(own / "out"))
    output.write(output.outputs(done))
    return done


@pytest.mark.parametrize("by", ["folder", "package.xml"])
def test_the_package_around_the_file(tmp_path: Path, by: str) -> None:
    """What is written loads in MuJoCo from where it lies."""
    import mujoco

    own = package(tmp_path, "my_desc" if by == "folder" else "clone")
    if by == "package.xml":
        (own / "package.xml").write_text("<package><name>my_desc</name></package>", encoding="utf-8")
    done = compiled(own)
    assert "MJC029" not in [item.code for item in done.diagnostics]
    written = own / "out" / "mujoco" / "r.xml"
    assert 'file="../meshes/x.obj"' in written.read_text(encoding="utf-8")
    assert mujoco.MjModel.from_xml_path(str(written)).nmesh == 1


def test_a_package_of_the_spec(tmp_path: Path) -> None:
    """`robot.packages` names the folder from the spec's; one that is not there is an error at its line."""
    import mujoco

    own = package(tmp_path, "clone")
    package(tmp_path, "elsewhere")
    (own / "meshes" / "x.obj").unlink()
    spec = SPEC.replace("urdf/r.urdf}", "urdf/r.urdf, packages: {my_desc: ../elsewhere}}")
    (own / "s.yaml").write_text(spec, encoding="utf-8")
    done = compiled(own)
    assert "MJC029" not in [item.code for item in done.diagnostics]
    written = own / "out" / "mujoco" / "r.xml"
    assert 'file="../../elsewhere/meshes/x.obj"' in written.read_text(encoding="utf-8")
    assert mujoco.MjModel.from_xml_path(str(written)).nmesh == 1
    (own / "s.yaml").write_text(spec.replace("elsewhere", "nowhere"), encoding="utf-8")
    with pytest.raises(RobotError) as caught:
        compiled(own)
    (item,) = caught.value.diagnostics
    assert (item.code, item.span and item.span.line) == ("ROBOT101", 2)
    assert "there is no folder '../nowhere' of the package 'my_desc'" in item.message


@pytest.mark.parametrize("kept", [False, True], ids=["left out", "kept"])
def test_visuals(tmp_path: Path, kept: bool) -> None:
    """MuJoCo leaves out what is only seen, and the message says so; with the option it is there, and is not named."""
    own = package(tmp_path, "my_desc")
    seen = '<visual><geometry><sphere radius="0.1"/></geometry></visual>'
    text = URDF.replace("<collision>", f"{seen}{seen}<collision>")
    if kept:
        text = text.replace(
            '<link name="a"/>', '<mujoco><compiler discardvisual="false"/></mujoco><link name="a"/>'
        )
    (own / "urdf" / "r.urdf").write_text(text, encoding="utf-8")
    done = compiled(own)
    (item,) = [item for item in done.diagnostics if item.code == "MJC015"]
    assert ("2 visuals are left out" in item.message) is not kept
    assert (item.help is None) is kept
    written = (own / "out" / "mujoco" / "r.xml").read_text(encoding="utf-8")
    assert written.count('<geom size="0.1"') == 2 * kept


def test_another_package(tmp_path: Path) -> None:
    """A package that is not around the file is reported with its meshes, not written as if it were found."""
    done = compiled(package(tmp_path, "clone"))
    (item,) = [item for item in done.diagnostics if item.code == "MJC029"]
    assert item.message.startswith(
        "MuJoCo cannot open 1 mesh file of a package in whose folder the model does not lie: "
    )
    assert "package://my_desc/meshes/x.obj" in item.message
    assert item.span is not None and item.span.path.endswith("r.urdf")


def reported(done: Compilation) -> tuple[str, str | None]:
    """Message and help of the one report of lacking meshes."""
    (item,) = [item for item in done.diagnostics if item.code == "MJC029"]
    return item.message, item.help


def test_a_mesh_that_its_package_does_not_have(tmp_path: Path) -> None:
    """The package is there: the file is named, with the nearest that there is, or where it was looked for."""
    own = package(tmp_path, "my_desc")
    (own / "urdf" / "r.urdf").write_text(URDF.replace("meshes/x.obj", "meshes/turet.obj"), encoding="utf-8")
    said = "1 mesh file is not in the folder of its package, and MuJoCo cannot open: package://my_desc/meshes/turet.obj"
    assert reported(compiled(own)) == (said, f"looked in {own / 'meshes'}")
    (own / "meshes" / "turret.obj").write_text(TETRAHEDRON, encoding="utf-8")
    assert reported(compiled(own)) == (said, "did you mean 'turret.obj' for 'turet.obj'?")


def test_a_mesh_of_a_path(tmp_path: Path) -> None:
    """Named by a path and not there: the loss is told with the attribute that sets the root; MuJoCo loads it then."""
    import mujoco

    own = package(tmp_path, "clone")
    text = URDF.replace("package://my_desc/meshes/x.obj", "meshes/x.obj")
    (own / "urdf" / "r.urdf").write_text(text, encoding="utf-8")
    message, help = reported(compiled(own))
    assert message == "MuJoCo cannot open 1 mesh file, which is not there: meshes/x.obj"
    said = '`<mujoco><compiler meshdir="FOLDER"/></mujoco>`'
    assert help == (
        f"looked in {own / 'urdf' / 'meshes'}; put them there, or name the folder that meshes/x.obj is below in the "
        f"URDF: {said}"
    )
    with pytest.raises(ValueError, match=r"x\.obj"):
        mujoco.MjModel.from_xml_path(str(own / "out" / "mujoco" / "r.xml"))
    element = said.strip("`").replace("FOLDER", "..")
    (own / "urdf" / "r.urdf").write_text(text.replace("<link", f"{element}<link", 1), encoding="utf-8")
    assert "MJC029" not in [item.code for item in compiled(own).diagnostics]
    assert mujoco.MjModel.from_xml_path(str(own / "out" / "mujoco" / "r.xml")).nmesh == 1


def test_nothing_outside_of_a_package_is_offered(tmp_path: Path) -> None:
    """A path that leaves the package is looked for in the package alone."""
    own = package(tmp_path, "my_desc")
    (own / "urdf" / "r.urdf").write_text(URDF.replace("meshes/x.obj", "../secret.obj"), encoding="utf-8")
    (tmp_path / "secrets.obj").write_text(TETRAHEDRON, encoding="utf-8")
    assert reported(compiled(own))[1] == f"looked in {own}"


def test_a_misspelt_package_of_the_spec(tmp_path: Path) -> None:
    """The URDF is in no package, and the spec has one of nearly the name."""
    own = package(tmp_path, "clone")
    spec = SPEC.replace("r.urdf}", "r.urdf, packages: {my_dsc: .}}")
    (own / "s.yaml").write_text(spec, encoding="utf-8")
    message, help = reported(compiled(own))
    assert message.startswith(
        "MuJoCo cannot open 1 mesh file of a package in whose folder the model does not lie: "
    )
    assert help == "did you mean `my_desc` for `my_dsc` in `robot.packages` or --package?"


@pytest.mark.parametrize(
    "name, found",
    [
        ("package://my_desc/meshes/x.obj", True),
        ("package://my_desc/meshes/y.obj", False),
        ("package://my_desc/../secret.obj", False),
        ("package://my_desc/link.obj", False),
        ("package:///my_desc/meshes/x.obj", True),
        ("package:////my_desc/meshes/x.obj", True),
        ("package:///my_desc//../secret.obj", False),
        ("package:///meshes/x.obj", False),
        ("meshes/x.obj", False),
    ],
)
def test_only_below_the_package(tmp_path: Path, name: str, found: bool) -> None:
    """Neither `..` nor a link leads out of the package."""
    own = package(tmp_path, "my_desc")
    (tmp_path / "secret.obj").write_text(TETRAHEDRON, encoding="utf-8")
    os.symlink(tmp_path / "secret.obj", own / "link.obj")
    assert (package_file(name, str(own / "urdf"), {}) is not None) is found
    assert (package_file(name, str(tmp_path), {"my_desc": str(own)}) is not None) is found


def test_a_package_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`--package` goes before the spec's folder, in validate and compile, and import writes it into the spec."""
    import mujoco

    own = package(tmp_path, "clone")
    package(tmp_path, "elsewhere")
    (own / "meshes" / "x.obj").unlink()
    spec = SPEC.replace("urdf/r.urdf}", "urdf/r.urdf, packages: {my_desc: ../nowhere}}")
    (own / "s.yaml").write_text(spec, encoding="utf-8")
    assert main(["validate", str(own / "s.yaml")]) == 2
    assert "--package my_desc=FOLDER" in capsys.readouterr().err
    there = f"my_desc={tmp_path / 'elsewhere'}"
    assert main(["validate", str(own / "s.yaml"), "--package", there]) == 0
    out = own / "out"
    assert main(["compile", str(own / "s.yaml"), "-t", "mujoco", "-o", str(out), "--package", there]) == 0
    assert mujoco.MjModel.from_xml_path(str(out / "mujoco" / "r.xml")).nmesh == 1
    drafted = tmp_path / "specs" / "r.yaml"
    drafted.parent.mkdir()
    assert main(["import", str(own / "urdf" / "r.urdf"), "-o", str(drafted), "--package", there]) == 0
    assert load_spec(str(drafted)).model.robot.packages == {"my_desc": "../elsewhere"}
    capsys.readouterr()


@pytest.mark.parametrize(
    ("text", "said"), [("my_desc", "is not NAME=FOLDER"), ("my_desc=nowhere", "there is no folder 'nowhere'")]
)
def test_a_package_that_is_none(text: str, said: str, capsys: pytest.CaptureFixture[str]) -> None:
    """It is wrong usage, whatever the spec says."""
    with pytest.raises(SystemExit) as caught:
        main(["validate", "s.yaml", "--package", text])
    assert caught.value.code == 2
    assert said in capsys.readouterr().err


def with_dae(tmp_path: Path, kind: str = "collision", head: str = "") -> Path:
    """The package with a COLLADA in the place of its OBJ."""
    own = package(tmp_path, "my_desc")
    text = (
        URDF.replace("x.obj", "x.dae").replace("collision>", f"{kind}>").replace("<link", f"{head}<link", 1)
    )
    (own / "urdf" / "r.urdf").write_text(text, encoding="utf-8")
    (own / "meshes" / "x.obj").rename(own / "meshes" / "x.dae")
    return own


NOT_LOADED = (
    "MuJoCo reads .obj, .stl and .msh, and no .dae (COLLADA): it does not load what is written, for 1 mesh file: "
    "package://my_desc/meshes/x.dae"
)
KEPT = '<mujoco><compiler discardvisual="false"/></mujoco>'


@pytest.mark.parametrize(("kind", "head"), [("collision", ""), ("collision", KEPT), ("visual", KEPT)])
def test_a_mesh_that_mujoco_does_not_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], kind: str, head: str
) -> None:
    """It is written by its true name, and MuJoCo does not load it: exit code 1 says so, and what is there instead."""
    import mujoco

    own = with_dae(tmp_path, kind, head)
    command = ["compile", str(own / "s.yaml"), "-t", "mujoco", "-o", str(own / "out")]
    assert main(command) == 1
    said = capsys.readouterr().err
    at = own / "urdf" / "r.urdf"
    assert f"{at}:3:{URDF.splitlines()[2].index('<mesh') + 1 + len(kind) - 9}: MJC034 [warning] " in said
    assert NOT_LOADED in said and "MJC029" not in said
    assert f"  help: convert it to .obj or .stl beside it, and name that in {at}\n" in said
    assert said.endswith("MuJoCo does not load what was written (MJC034)\n")
    written = own / "out" / "mujoco" / "r.xml"
    assert 'file="../meshes/x.dae"' in written.read_text(encoding="utf-8")
    with pytest.raises(ValueError, match=r"no decoder found for mesh file .*x\.dae'"):
        mujoco.MjModel.from_xml_path(str(written))
    # As the help says; then there is nothing to say.
    (own / "meshes" / "x.obj").write_text(TETRAHEDRON, encoding="utf-8")
    assert main(command) == 1
    assert f"  help: name x.obj, which is there, in {at}\n" in capsys.readouterr().err
    at.write_text(at.read_text(encoding="utf-8").replace("x.dae", "x.obj"), encoding="utf-8")
    assert main(command) == 0
    assert mujoco.MjModel.from_xml_path(str(written)).nmesh == 1


def test_strict_does_not_write_what_mujoco_does_not_load(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`--check` is about files that are there alone: it finds none stale, and says it all the same."""
    own = with_dae(tmp_path)
    accepted = SPEC + 'accept: {mujoco.velocity_limit: "none"}\n'
    (own / "s.yaml").write_text(accepted, encoding="utf-8")
    command = ["compile", str(own / "s.yaml"), "-t", "mujoco", "-o", str(own / "out")]
    assert main([*command, "--strict"]) == 1
    assert "--strict: nothing was written: MuJoCo could not load it (MJC034)\n" in capsys.readouterr().err
    assert not (own / "out").exists()
    assert main(command) == 1
    capsys.readouterr()
    assert main([*command, "--check"]) == 0
    assert NOT_LOADED in capsys.readouterr().err


def test_verify_says_what_compile_does(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It runs the model without its meshes; that nobody can load what is written is a finding all the same."""
    own = with_dae(tmp_path)
    assert main(["verify", str(own / "s.yaml"), "-t", "mujoco"]) == 1
    out, err = capsys.readouterr()
    assert "1 target agrees" in out
    assert NOT_LOADED in err and err.endswith("MuJoCo does not load what is written (MJC034)\n")
    (own / "meshes" / "x.dae").rename(own / "meshes" / "x.obj")
    at = own / "urdf" / "r.urdf"
    at.write_text(at.read_text(encoding="utf-8").replace("x.dae", "x.obj"), encoding="utf-8")
    assert main(["verify", str(own / "s.yaml"), "-t", "mujoco"]) == 0
    assert "MJC" not in capsys.readouterr().err


@pytest.mark.parametrize("canonical", [False, True])
def test_a_mesh_of_an_mjcf_that_is_not_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], canonical: bool
) -> None:
    """A note: the model's own path is kept, and is right where the meshes are."""
    import mujoco

    own = package(tmp_path, "my_desc")
    (own / "r.xml").write_text(
        '<mujoco><compiler meshdir="meshes"/><asset><mesh name="x" file="x.obj"/><mesh file="y.stl"/></asset>\n'
        '<worldbody><body><joint name="j"/><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>'
        '<geom type="mesh" mesh="x"/></body></worldbody></mujoco>',
        encoding="utf-8",
    )
    (own / "s.yaml").write_text(SPEC.replace("urdf/r.urdf", "r.xml"), encoding="utf-8")
    command = ["compile", str(own / "s.yaml"), "-t", "mujoco", "-o", str(own / "out")]
    command += ["--canonical"] * canonical
    assert main([*command, "--strict"]) == 0
    assert (
        "MJC029 [info] robot.model: MuJoCo cannot open 1 mesh file, which is not there: y.stl; without it it loads "
        f"neither the model nor what is written\n  help: looked in {own / 'meshes'}\n"
    ) in capsys.readouterr().err
    written = str(own / "out" / "mujoco" / "r.xml")
    for path in (str(own / "r.xml"), written):
        with pytest.raises(ValueError, match=r"y\.stl"):
            mujoco.MjModel.from_xml_path(path)
    (own / "meshes" / "x.obj").rename(own / "meshes" / "y.obj")
    assert main(command) == 0
    assert "MuJoCo cannot open 2 mesh files, which are not there: x.obj, y.stl;" in capsys.readouterr().err
    (own / "meshes" / "x.obj").write_text(TETRAHEDRON, encoding="utf-8")
    (own / "r.xml").write_text((own / "r.xml").read_text().replace("y.stl", "y.obj"), encoding="utf-8")
    assert main(command) == 0
    assert "MJC029" not in capsys.readouterr().err
    assert mujoco.MjModel.from_xml_path(written).nmesh == 2


def test_a_mesh_that_is_only_seen(tmp_path: Path) -> None:
    """MuJoCo leaves it out: it loads what is written, and nothing is said of the mesh."""
    import mujoco

    own = with_dae(tmp_path, "visual")
    assert {"MJC029", "MJC034"}.isdisjoint(item.code for item in compiled(own).diagnostics)
    assert mujoco.MjModel.from_xml_path(str(own / "out" / "mujoco" / "r.xml")).nmesh == 0


@pytest.mark.parametrize("canonical", [False, True])
def test_a_mesh_of_an_mjcf_that_mujoco_does_not_read(tmp_path: Path, canonical: bool) -> None:
    """The MJCF keeps its name, in MuJoCo's own form too, and of two such endings both are told."""
    own = package(tmp_path, "my_desc")
    (own / "r.xml").write_text(
        '<mujoco><asset><mesh file="meshes/x.dae"/><mesh name="y" file="y.Stl"/></asset>\n'
        '<worldbody><body><joint name="j"/><inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>'
        '<geom type="mesh" mesh="y"/></body></worldbody></mujoco>',
        encoding="utf-8",
    )
    (own / "s.yaml").write_text(SPEC.replace("urdf/r.urdf", "r.xml"), encoding="utf-8")
    done = api.compile(own / "s.yaml", targets=["mujoco"], output=str(own / "out"), canonical=canonical)
    (item,) = [item for item in done.diagnostics if item.code == "MJC034"]
    assert item.message == (
        "MuJoCo reads .obj, .stl and .msh, and no .dae (COLLADA), .Stl: it does not load what is written, for 2 mesh "
        "files: meshes/x.dae, y.Stl"
    )
    assert str(item.span).endswith("r.xml:1:16")
    assert item.help == (
        f"name x.obj, which is there, in {own / 'r.xml'}; convert the others to .obj or .stl"
    )
    (text,) = [file.data.decode() for file in output.outputs(done) if file.path.endswith(".xml")]
    assert 'file="meshes/x.dae"' in text and 'file="y.Stl"' in text


def test_the_line_of_a_mesh_that_is_seen_too(tmp_path: Path) -> None:
    """A visual of the same file goes before it: the collision is told, which MuJoCo keeps."""
    own = with_dae(tmp_path)
    path = own / "urdf" / "r.urdf"
    text = path.read_text(encoding="utf-8")
    seen = '<visual><geometry><mesh filename="package://my_desc/meshes/x.dae"/></geometry></visual>'
    path.write_text(text.replace('<link name="a"/>', f'<link name="a">{seen}</link>'), encoding="utf-8")
    (item,) = [item for item in compiled(own).diagnostics if item.code == "MJC034"]
    assert item.span is not None and item.span.line == 3


def test_shapes_of_one_name(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """MuJoCo leaves all but the first without a name; the note on the URDF says so, and nobody else prints."""
    own = package(tmp_path, "my_desc")
    shape = '<collision name="foot"><geometry><sphere radius="0.1"/></geometry></collision>\n'
    text = (own / "urdf" / "r.urdf").read_text(encoding="utf-8")
    (own / "urdf" / "r.urdf").write_text(
        text.replace("    <collision>", f"{shape * 3}<collision>"), encoding="utf-8"
    )
    (item,) = [item for item in compiled(own).diagnostics if item.code == "MJC015"]
    assert item.message.endswith("; 2 shapes called as one before, in line 4 'foot', have no name there")
    assert capfd.readouterr() == ("", "")
    written = (own / "out" / "mujoco" / "r.xml").read_text(encoding="utf-8")
    assert written.count('<geom name="foot" size="0.1"') == 1 and written.count('<geom size="0.1"') == 2


def test_a_package_behind_three_slashes(tmp_path: Path) -> None:
    """It is the one of the name behind them, around the file or of the spec; where it is strange it is asked for."""
    import mujoco

    own = package(tmp_path, "my_desc")
    text = (own / "urdf" / "r.urdf").read_text(encoding="utf-8").replace("package://", "package:///")
    (own / "urdf" / "r.urdf").write_text(text, encoding="utf-8")
    assert "MJC029" not in [item.code for item in compiled(own).diagnostics]
    assert mujoco.MjModel.from_xml_path(str(own / "out" / "mujoco" / "r.xml")).nmesh == 1
    strange = package(tmp_path, "clone")
    (strange / "urdf" / "r.urdf").write_text(text, encoding="utf-8")
    spec = SPEC.replace("r.urdf}", "r.urdf, packages: {my_dsc: ../my_desc}}")
    (strange / "s.yaml").write_text(spec, encoding="utf-8")
    done = compiled(strange)
    assert reported(done)[1] == "did you mean `my_desc` for `my_dsc` in `robot.packages` or --package?"
    assert "MJC035" not in [item.code for item in done.diagnostics]
    (strange / "s.yaml").write_text(spec.replace("my_dsc", "my_desc"), encoding="utf-8")
    compiled(strange)
    assert mujoco.MjModel.from_xml_path(str(strange / "out" / "mujoco" / "r.xml")).nmesh == 1


@pytest.mark.parametrize(
    ("name", "severity", "help"),
    [
        ("my_dsc", "warning", "did you mean 'my_desc'?"),
        ("other", "info", None),
        ("my_desc", "", None),
        ("seen", "", None),
    ],
)
def test_a_package_that_the_model_does_not_name(
    tmp_path: Path, name: str, severity: str, help: str | None
) -> None:
    """The meshes are found around the file without it: it is told, as a warning where it is nearly the right name."""
    own = package(tmp_path, "my_desc")
    seen = '<visual><geometry><mesh filename="package://seen/y.obj"/></geometry></visual><collision>'
    text = (own / "urdf" / "r.urdf").read_text(encoding="utf-8").replace("<collision>", seen)
    (own / "urdf" / "r.urdf").write_text(text, encoding="utf-8")
    (own / "s.yaml").write_text(
        SPEC.replace("r.urdf}", f"r.urdf, packages: {{{name}: .}}}}"), encoding="utf-8"
    )
    found = [item for item in compiled(own).diagnostics if item.code in ("MJC029", "MJC035")]
    assert [(item.code, item.severity.value, item.help) for item in found] == [
        ("MJC035", severity, help)
    ] * bool(severity)
    if found:
        said = f"the model names no file by the package '{name}', which `robot.packages` or --package has"
        assert found[0].message == said
