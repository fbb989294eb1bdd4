"""Reading what the user names: kinds, folders, bad input, crashes, order."""

from __future__ import annotations

import faulthandler
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from actspec.audit.read import pending_files, read_file, read_files
from actspec.cli.main import main
from actspec.readings.artifact import FileKind, FileReading
from actspec.readings.named import expand

GOOD = """<mujoco><worldbody><body><joint name="j"/><geom size="1"/></body></worldbody>
<actuator><motor joint="j" gear="2"/></actuator></mujoco>"""
URDF = """<robot name="r"><link name="a"/><link name="b"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/>
<limit lower="-1" upper="1" effort="5" velocity="3"/></joint></robot>"""

posix = pytest.mark.skipif(sys.platform == "win32", reason="needs POSIX")
forks = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="elsewhere processes are not forked")


@pytest.fixture(autouse=True)
def _in_tmp_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def reason_of(path: str) -> str | None:
    """Why a file cannot be read."""
    return read_file(path).reason


def test_results_are_in_the_order_of_the_paths() -> None:
    """Whichever worker is done first; a bad file among them loses itself only."""
    names = []
    for index in range(12):
        name = f"m{index}.xml"
        Path(name).write_text("no XML" if index == 5 else GOOD.replace('"j"', f'"j{index}"'))
        names.append(name)
    seen: list[tuple[int, int]] = []
    readings = read_files(names[::-1], jobs=3, progress=lambda done, of: seen.append((done, of)))
    assert [r.path for r in readings] == names[::-1]
    joints = [
        r.artifacts[0].robot.joints[0].name if r.artifacts and r.artifacts[0].robot else None
        for r in readings
    ]
    assert joints == [None if i == 5 else f"j{i}" for i in range(11, -1, -1)]
    assert seen == [(done, 12) for done in range(1, 13)]


def test_kind_is_by_content() -> None:
    """The root element decides, not the ending; the name of a robot comes along."""
    Path("model.txt").write_text(GOOD)
    Path("robot.xml").write_text(URDF)
    found = read_files(["model.txt", "robot.xml"])
    assert [(r.kind, r.artifacts[0].name) for r in found] == [
        (FileKind.MJCF, "MuJoCo Model"),
        (FileKind.URDF, "r"),
    ]
    assert [file.data for file in found[0].files] == [GOOD.encode()]


def test_a_spec_is_resolved() -> None:
    """YAML with the key `actspec` is a spec; its faults are those of the spec."""
    Path("m.xml").write_text(GOOD)
    Path("s.yaml").write_text(
        "actspec: 1\nrobot: {name: r, model: m.xml}\ntiming: {physics_dt: 2 ms, decimation: 1}\n"
        "actuators: {legs: {joints: [j], level: ideal_pd, command: position, kp: 3 N*m/rad, kd: 1 N*m*s/rad,"
        " effort_limit: 4 N*m}}\ntargets: {mujoco: {version: '3.12'}}\n"
    )
    (found,) = read_files(["s.yaml"])
    assert (found.kind, found.reason) == (FileKind.SPEC, None)
    assert found.artifacts[0].spec is not None
    assert found.artifacts[0].spec.joints[0].joint == "j"
    Path("bad.yaml").write_text("actspec: 1\nrobot: {name: r, model: none}\n")
    (found,) = read_files(["bad.yaml"])
    assert found.kind is FileKind.SPEC
    assert found.reason is not None
    assert found.diagnostics


def test_what_mujoco_refuses_is_read_from_its_text() -> None:
    """The reason names the line; the figures are there all the same."""
    Path("m.xml").write_text(GOOD.replace('<geom size="1"/>', '\n<geom size="1" colour="red"/>'))
    (found,) = read_files(["m.xml"])
    (artifact,) = found.artifacts
    assert found.reason is None
    assert artifact.text_only is not None
    assert artifact.text_only.startswith("MuJoCo refuses the model: ")
    assert "colour" in artifact.text_only
    assert artifact.robot is not None
    assert str(artifact.robot.refused_at) == "m.xml:2"
    assert artifact.robot.actuators[0].gear == 2.0


def test_a_robot_that_is_included_twice_is_not_read() -> None:
    """By way of its scene and by itself: MuJoCo refuses it, and its figures would count twice."""
    named = GOOD.replace("<geom", '<geom name="g"')
    Path("m.xml").write_text(named)
    Path("scene.xml").write_text('<mujoco><include file="m.xml"/></mujoco>')
    Path("full.xml").write_text(
        '<mujoco>\n  <include file="scene.xml"/>\n  <include file="m.xml"/>\n</mujoco>'
    )
    scene, full = read_files(["scene.xml", "full.xml"])
    assert scene.artifacts[0].text_only is None
    assert not full.artifacts
    assert (full.reason or "").startswith("'m.xml' is included a second time; MuJoCo refuses the model: ")
    assert str(full.refused) == "full.xml:3:3"


def test_a_refused_urdf_says_so_too() -> None:
    """MuJoCo refuses a link without mass; limits are read, and the artifact says where they come from."""
    Path("r.urdf").write_text(URDF.replace('<mass value="1"/>', '<mass value="0"/>'))
    (found,) = read_files(["r.urdf"])
    (artifact,) = found.artifacts
    assert artifact.text_only is not None and "mjMINVAL" in artifact.text_only
    assert artifact.robot is not None
    assert artifact.robot.joints[0].velocity_limit == 3.0


def test_a_reading_comes_back_as_it_was() -> None:
    """What another process read is equal to what this one reads: spans, rows' inputs, diagnostics, bytes."""
    Path("m.xml").write_text(GOOD.replace('"j"', '"j" range="-1 1" frictionloss="2" springdamper="1 1"', 1))
    Path("r.urdf").write_text(URDF.replace("5", "0"))
    assert read_files(["m.xml", "r.urdf"]) == tuple(map(read_file, ("m.xml", "r.urdf")))


@pytest.mark.usefixtures("processes")
def test_reading_can_be_given_up() -> None:
    """Whoever leaves before the files are read leaves no process behind."""
    from multiprocessing import active_children

    Path("m.xml").write_text(GOOD)
    with pending_files(["m.xml"]):
        assert active_children()
    assert not active_children()


@pytest.mark.slow
def test_the_audit_itself_imports_no_simulator() -> None:
    """Only the readers' processes load MuJoCo and numpy, and nothing here needs pydantic: start-up counts."""
    Path("m.xml").write_text(GOOD)
    code = (
        "import sys\nfrom actspec.cli.main import main\nmain(['audit', '--exit-zero', 'm.xml'])\n"
        "print([name for name in ('mujoco', 'numpy', 'pydantic', 'yaml', 'lxml') if name in sys.modules])"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment
    )
    assert done.stdout.splitlines()[-1] == "[]"


BOMB = '<!DOCTYPE x [<!ENTITY a "aa"><!ENTITY b "&a;&a;">]>'
EXTERNAL = '<!DOCTYPE x [<!ENTITY a SYSTEM "file:///etc/passwd">]>'
BAD = [
    ("not-xml", "hello", "this is not XML"),
    ("truncated", GOOD[:60], ""),
    ("empty", "", "the file has no XML element"),
    ("entity-bomb", f"{BOMB}<mujoco>&b;</mujoco>", "the file has a DOCTYPE"),
    ("external-entity", f"{EXTERNAL}<mujoco>&a;</mujoco>", "the file has a DOCTYPE"),
    ("cycle", '<mujoco><include file="bad.xml"/></mujoco>', "the includes go in a circle"),
    ("missing-include", '<mujoco>\n<include file="none.xml"/></mujoco>', "the include cannot be followed"),
    ("other-root", "<sdf/>", "the root element is <sdf>: neither an MJCF (<mujoco>) nor a URDF (<robot>)"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "reason"), [b[1:] for b in BAD], ids=[b[0] for b in BAD])
def test_bad_input_is_told_and_the_others_are_read(text: str, reason: str) -> None:
    """Each gives its reason; a good file beside it is read."""
    Path("bad.xml").write_text(text)
    Path("good.xml").write_text(GOOD)
    bad, good = read_files(["bad.xml", "good.xml"], jobs=1)
    assert bad.reason is not None
    assert reason in bad.reason
    assert bad.place.line == (0 if "root element" in reason else 1 + ("\n" in text))
    assert good.reason is None


def test_an_include_that_is_no_mjcf_is_never_shown() -> None:
    """Neither the reason nor what is kept of the file has a word of it."""
    Path("secret").write_text("root:x:0:0\n")
    Path("m.xml").write_text('<mujoco><include file="secret"/></mujoco>')
    found = read_file("m.xml")
    assert found.reason == "the included file 'secret' is not an MJCF file"
    assert b"root" not in b"".join(file.data for file in found.files)
    assert not any("root:x" in str(item) for item in found.diagnostics)


@posix
def test_files_that_are_no_files() -> None:
    """A pipe is not waited for, a missing file and one without permission say so, bytes are told as bytes."""
    os.mkfifo("pipe.xml")
    assert reason_of("pipe.xml") == "'pipe.xml' is not a regular file"
    os.mkfifo("pipe.yaml")
    assert reason_of("pipe.yaml") == "it is not a regular file"
    assert reason_of("none.xml") == "there is no file 'none.xml'"
    Path("latin.xml").write_bytes(b'<mujoco model="\xe9"/>')
    found = reason_of("latin.xml")
    assert found is not None and "UTF-8" in found
    Path("locked.xml").write_text(GOOD)
    Path("locked.xml").chmod(0)
    if os.geteuid():
        assert reason_of("locked.xml") == "'locked.xml' cannot be read: Permission denied"


def audited_without_rights(*args: str) -> tuple[int, list[str]]:
    """Exit code and lines of an audit by somebody who is not root, for whom nothing is shut."""
    as_user = []
    if os.geteuid() == 0:
        rights = "-dac_override,-dac_read_search"
        as_user = ["setpriv", "--bounding-set", rights, "--inh-caps", rights]
        if shutil.which("setpriv") is None:
            pytest.skip("root reads everything")
    command = [*as_user, sys.executable, "-m", "actspec", "audit", *args, "--output-format", "concise"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.returncode, done.stdout.splitlines()


@pytest.mark.slow
@posix
def test_a_folder_that_cannot_be_listed_is_an_error() -> None:
    """Nobody knows what it has, wherever it lies."""
    Path("robots/shut").mkdir(parents=True)
    Path("robots/leg.xml").write_text(GOOD)
    Path("robots/shut").chmod(0)
    try:
        for folder, of in (("robots", "2 files, 1 of which"), ("robots/shut", "1 file, which")):
            code, said = audited_without_rights(folder)
            why = "the file cannot be read: it is a folder that cannot be listed (permission denied)"
            assert (code, said[0], said[-1]) == (
                1,
                f"robots/shut: AUD008 [error] {why}",
                f"1 error in {of} could not be read",
            )
    finally:
        Path("robots/shut").chmod(0o700)


@pytest.mark.slow
@posix
@pytest.mark.parametrize("name", ["leg.xml", "leg.urdf", "leg_cfg.py", "leg.yaml"])
def test_a_file_that_may_not_be_opened_is_told_in_a_folder(name: str) -> None:
    """It may be a robot's for all that anybody knows; a text beside it has another ending."""
    Path("robots").mkdir()
    Path("robots/good.xml").write_text(GOOD)
    for shut in (name, "notes.txt"):
        Path("robots", shut).touch(0)
    code, said = audited_without_rights("robots", "--notes", "--select", "AUD008")
    assert code == 0
    assert said[0].startswith(f"robots/{name}: AUD008 [info] the file cannot be read: ")
    assert "permission denied" in said[0].lower()
    assert said[1:] == ["1 note in 2 files, 1 of which could not be read"]


def test_a_file_that_is_too_large_is_not_read() -> None:
    """64 MiB of XML and 8 MiB of YAML are the most."""
    with open("large.xml", "wb") as stream:
        stream.truncate((64 << 20) + 1)
    assert reason_of("large.xml") == "'large.xml' is larger than 64 MiB"
    with open("large.yaml", "wb") as stream:
        stream.truncate((8 << 20) + 1)
    assert reason_of("large.yaml") == "it is larger than 8 MiB"


@pytest.mark.slow
def test_a_large_file_of_nothing_is_read() -> None:
    """50 MB of comment are no reason to fail."""
    Path("large.xml").write_text(f"<mujoco><!--{'x' * 50_000_000}--></mujoco>")
    assert reason_of("large.xml") is None


def test_a_folder_stands_for_the_files_in_it() -> None:
    """By name, folders below too; hidden ones, other endings and XML of others are passed over."""
    for name in ("d/b.xml", "d/a.urdf", "d/e/c.mjcf", "d/.hidden/x.xml", "d/.y.xml", "d/notes.txt"):
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        Path(name).write_text(URDF if name.endswith("urdf") else GOOD)
    Path("d/package.xml").write_text("<package/>")
    Path("d/broken.xml").write_text("<mujoco><worldbody>")
    Path("d/other.xml").write_text("<svg><a>")
    assert [file.path for file in expand(["d"])] == [
        os.path.join("d", *name.split("/"))
        for name in ("a.urdf", "b.xml", "broken.xml", "other.xml", "package.xml", "e/c.mjcf")
    ]
    found = read_files(["d"], jobs=2)
    assert [(os.path.basename(r.path), r.reason is None) for r in found] == [
        ("a.urdf", True),
        ("b.xml", True),
        ("broken.xml", False),
        ("c.mjcf", True),
    ]
    # A file that is named is an error in its own right, and is there once.
    found = read_files(["d/package.xml", "d", "d/b.xml"])
    assert [os.path.basename(r.path) for r in found].count("b.xml") == 1
    assert found[0].reason is not None


def test_a_folder_without_anything_says_so() -> None:
    """Nothing to audit is not the same as nothing wrong."""
    Path("d").mkdir()
    Path("d/package.xml").write_text("<package/>")
    (found,) = read_files(["d"])
    endings = ".xml, .urdf, .mjcf, .py, .yaml, .yml"
    reason = f"of its 1 file that ends in {endings} none is a robot file, configuration, deploy file or spec"
    assert (found.path, found.reason) == ("d", reason)
    assert [str(item) for item in found.diagnostics] == [
        f"d: AUD014: nothing to audit in this folder: {reason}\n"
        "  help: links to folders are not followed and hidden folders are passed over; name those"
    ]
    Path("d/package.xml").rename("d/notes.txt")
    (found,) = read_files(["d"])
    assert found.reason == f"it has no file that ends in {endings}"


XACRO = (
    '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:property name="l" value="1"/></robot>'
)
EXPAND = "  help: xacro ROBOT.urdf.xacro -o ROBOT.urdf, and name that"


def test_a_xacro_is_to_be_expanded_first(capsys: pytest.CaptureFixture[str]) -> None:
    """It is no URDF that MuJoCo refuses. What xacro made of one is, whatever it is called."""
    Path("r.urdf.xacro").write_text(XACRO)
    assert main(["audit", "r.urdf.xacro"]) == 2
    told = f"AUD014: nothing to audit: this is a xacro, which has to be expanded first\n{EXPAND}\n"
    assert capsys.readouterr().err == f"r.urdf.xacro: {told}"
    Path("cfg.py").write_text(
        "from isaaclab.actuators import ImplicitActuatorCfg\n"
        'CFG = {"a": ImplicitActuatorCfg(joint_names_expr=["a"], stiffness=9.0, damping=1.0)}\n'
    )
    told = f"cannot be read: this is a xacro, which has to be expanded first\n{EXPAND}\n"
    for arguments, code in (
        (["import", "r.urdf.xacro"], "DRF004"),
        (["import", "cfg.py", "--joints", "r.urdf.xacro"], "DRF011 --joints"),
        (["diff", "r.urdf.xacro", "cfg.py"], "DIF001"),
        (["lock", "r.urdf.xacro"], "DIF001"),
    ):
        assert main(arguments) == 2
        assert f"r.urdf.xacro: {code}: {told}" in capsys.readouterr().err
    Path("r.xacro").write_text(URDF)
    assert read_file("r.xacro").readable


def test_a_xacro_under_the_name_of_a_urdf(capsys: pytest.CaptureFixture[str]) -> None:
    """It is told once, as what it is, where it is named, and counted in a folder; it had an error for each figure."""
    Path("d").mkdir()
    text = (
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="a"/><link name="b"/>'
        '<joint name="j" type="revolute"><parent link="a"/><child link="b"/>'
        '<limit lower="-${pi}" upper="${pi}" effort="9" velocity="5"/></joint></robot>'
    )
    Path("d/r.urdf").write_text(text)
    assert main(["audit", "d/r.urdf"]) == 2
    told = "AUD014: nothing to audit: this is a xacro, which has to be expanded first"
    help = "  help: xacro r.urdf -o EXPANDED.urdf, and name that"
    assert capsys.readouterr().err == f"d/r.urdf: {told}\n{help}\n"
    Path("d/s.urdf").write_text(URDF)
    main(["audit", "d"])
    out, err = capsys.readouterr()
    assert out.splitlines()[-1].endswith(" in 1 file; 1 xacro file not read")
    assert not err
    # The namespace alone, and an include of colours, leave the joints as they are.
    idle = text.replace("-${pi}", "-3").replace("${pi}", "3")
    idle = idle.replace("<link", '<xacro:include filename="colours.xacro"/><xacro:arg name="n"/><link', 1)
    Path("d/r.urdf").write_text(idle)
    assert read_file("d/r.urdf").readable
    Path("d/r.urdf").write_text(idle.replace("</robot>", '<xacro:wheel side="left"/></robot>'))
    assert read_file("d/r.urdf").names_nothing
    # xacro computes without the namespace, too.
    bare = text.replace(' xmlns:xacro="http://www.ros.org/wiki/xacro"', "")
    Path("d/r.urdf").write_text(bare)
    assert read_file("d/r.urdf").names_nothing
    # In a name it may be what a URDF is called by: all its figures are there.
    named = bare.replace("-${pi}", "-3").replace("${pi}", "3").replace('"b"', '"${prefix}b"')
    Path("d/r.urdf").write_text(named)
    assert read_file("d/r.urdf").readable
    # A figure that is none, and none of xacro's, is what is wrong.
    Path("d/r.urdf").write_text(bare.replace("-${pi}", "-pi").replace("${pi}", "pi"))
    assert "must be a number" in (read_file("d/r.urdf").reason or "")


def test_files_of_a_robot_that_are_not_read_are_counted(capsys: pytest.CaptureFixture[str]) -> None:
    """In the last line, each once however often its folder is named, and none that is excluded."""
    Path("d/old").mkdir(parents=True)
    for name in ("a.urdf.xacro", "b.xacro", "m.sdf", "r.usd", "r.usda", "S.USDZ", "old/o.xacro"):
        Path("d", name).touch()
    assert main(["audit", "d"]) == 2
    out, err = capsys.readouterr()
    counts = "3 xacro files, 1 SDF file, 3 USD files not read"
    assert out == f"no findings in 0 files; nothing to audit at 1 path; {counts}\n"
    reason = f"it has no file that ends in .xml, .urdf, .mjcf, .py, .yaml, .yml; {counts}"
    assert err == f"d: AUD014: nothing to audit in this folder: {reason}\n{EXPAND}\n"
    Path("d/r.urdf").write_text(URDF)
    assert main(["audit", "d", "d/old", "--exclude", "d/m.sdf,d/*.usda"]) == 2
    told = "2 files left out by exclude; 3 xacro files, 2 USD files not read"
    assert (
        capsys.readouterr().out.splitlines()[-1].endswith(f" in 1 file; nothing to audit at 1 path; {told}")
    )


def dies(path: str, keep_matrices: bool = False, refusal: str | None = None) -> FileReading:
    """A reader that ends as its file's name says, unless it is told why not to."""
    faulthandler.disable()  # pytest's would tell of every death that is meant
    what = Path(path).stem
    if what == "always" or (what == "crash" and refusal is None):
        os.kill(os.getpid(), signal.SIGSEGV)
    if what == "fault":
        raise KeyError("x")
    return FileReading(path, None, refusal or "read")


@forks
@pytest.mark.usefixtures("processes")
@pytest.mark.parametrize("jobs", [1, 2], ids=["one-job", "two-jobs"])
def test_a_crash_loses_only_its_file(jobs: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is read once more with the reason, a file of which that is the end too is lost; a fault is not tried again."""
    monkeypatch.setattr("actspec.readings.read.read_file", dies)
    paths = ["a.xml", "crash.xml", "b.xml", "always.xml", "fault.xml", "c.xml"]
    for path in paths:
        Path(path).touch()
    seen: list[int] = []
    found = read_files(paths, jobs=jobs, progress=lambda done, of: seen.append(done))
    assert [(reading.path, reading.reason) for reading in found] == [
        ("a.xml", "read"),
        ("crash.xml", "MuJoCo crashed on it (signal 11)"),
        ("b.xml", "read"),
        ("always.xml", "MuJoCo crashed on it (signal 11)"),
        ("fault.xml", "a fault of actspec, not of the file; please report it: KeyError: 'x'"),
        ("c.xml", "read"),
    ]
    assert [[item.code for item in reading.diagnostics] for reading in found] == [
        [], [], [], ["AUD008"], ["AUD008"], []
    ]  # fmt: skip
    assert seen == [1, 2, 3, 4, 5, 6]


def breaks(*_: object) -> FileReading:
    """A reader with a fault in it."""
    raise KeyError("x")


@posix
@pytest.mark.parametrize("skip_other", [False, True], ids=["folder", "skip-other"])
def test_a_fault_is_never_passed_over(skip_other: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """A file that was lost to a fault is told, where files without anything to audit would not be."""
    monkeypatch.setattr("actspec.readings.read.read_file", breaks)
    Path("d").mkdir()
    Path("d/leg.xml").write_text(GOOD)
    (found,) = read_files(["d/leg.xml" if skip_other else "d"], skip_other=skip_other)
    assert found.path == "d/leg.xml"
    assert str(found.diagnostics[0]) == f"d/leg.xml: AUD008: the file cannot be read: {found.reason}"


def test_the_text_is_read_after_a_crash() -> None:
    """With a refusal MuJoCo does not see the file, and the artifact says why."""
    Path("m.xml").write_text(GOOD)
    found = read_file("m.xml", refusal="MuJoCo crashed on it (signal 11)")
    assert found.artifacts[0].text_only == "MuJoCo crashed on it (signal 11)"
    assert found.artifacts[0].robot is not None
    assert found.artifacts[0].robot.joint_inertia is None
    Path("r.urdf").write_text(URDF)
    found = read_file("r.urdf", refusal="MuJoCo crashed on it (signal 11)")
    assert found.artifacts[0].text_only == "MuJoCo crashed on it (signal 11)"
    assert found.artifacts[0].robot is not None
    assert found.artifacts[0].robot.joints[0].effort_range == (-5.0, 5.0)
    assert found.artifacts[0].robot.joint_inertia is None
    again = read_file("r.urdf").artifacts[0]
    assert again.text_only is None
    assert again.robot is not None
    assert again.robot.joint_inertia is not None
