"""The written URDF: numbers, untouched bytes, what it cannot hold, what is refused, and other readers."""

from __future__ import annotations

import difflib
import re
from pathlib import Path
from typing import Any

import pytest

from actspec import api, output
from actspec.cli.main import main
from actspec.diagnostics import EmitError
from actspec.resolution import resolve
from actspec.robot.load import load_robot
from actspec.robot.read_urdf import read_urdf
from actspec.robot.view import ModelFile, RobotView
from actspec.robot.xml import parse_document
from actspec.spec.document import document_from_text
from actspec.spec.validate import validate
from actspec.targets.base import Emission, TargetOptions
from actspec.targets.urdf.emit import emit
from actspec.targets.urdf.plan import UrdfJointEdit, deviations
from tests.compiling import FOLDER, spec_text, view_of

HERE = Path(__file__).parent
LEG = HERE / "leg.urdf"

LIMIT = '<limit effort="24" velocity="20" lower="-1" upper="1"/>'

GROUP = """  all:
    joints: [{joints}]
    level: ideal_pd
    kp: 40 N*m/rad
    kd: 1.5 N*m*s/rad
    {rest}
"""


def view(text: str | bytes) -> RobotView:
    """A URDF's text as a robot that MuJoCo does not see."""
    data = text.encode() if isinstance(text, str) else text
    return read_urdf((ModelFile(f"{FOLDER}/robot.urdf", "", data),), refusal="a test")


def urdf(*joints: str) -> str:
    """A robot with links for these joints."""
    links = "".join(f'<link name="l{i}"/>\n' for i in range(len(joints) + 1))
    return f'<robot name="r">\n{links}{"".join(f"{joint}{chr(10)}" for joint in joints)}</robot>\n'


def joint(inside: str = "", kind: str = "revolute", name: str = "j", index: int = 0) -> str:
    """A joint on one line."""
    parent, child = f'<parent link="l{index}"/>', f'<child link="l{index + 1}"/>'
    return f'<joint name="{name}" type="{kind}">{parent}{child}{inside}</joint>'


def compiled(model: RobotView, actuators: str, folder: str = f"{FOLDER}/out", robot: str = "") -> Emission:
    """The URDF target of a spec with these `actuators`."""
    spec = validate(document_from_text(spec_text(actuators, robot=robot)))
    return emit(resolve(spec, model), model, TargetOptions("out", "urdf", "", None, folder))


def group(rest: str, joints: str = "j") -> str:
    """A group of an ideal PD with these further fields."""
    return GROUP.format(joints=joints, rest=rest)


HEAD = re.compile(rb"<!--\r?\n  Written by actspec.*?-->\r?\n", re.DOTALL)


def changes(before: bytes, after: bytes) -> list[str]:
    """Lines that differ, but for the head."""
    old, new = (data.decode().splitlines() for data in (before, HEAD.sub(b"", after)))
    return [line for line in difflib.ndiff(old, new) if line[0] in "+-"]


@pytest.fixture(scope="module")
def leg(tmp_path_factory: pytest.TempPathFactory) -> api.Compilation:
    """leg.yaml, compiled."""
    return api.compile(HERE / "leg.yaml", output=str(tmp_path_factory.mktemp("out")))


def test_golden(request: pytest.FixtureRequest) -> None:
    """The leg is written byte for byte as golden.urdf; `--regen` writes that anew."""
    done = api.compile(HERE / "leg.yaml", output=str(HERE / "out"))
    ((file,),) = (emission.files for emission in done.emissions)
    golden = HERE / "golden.urdf"
    if request.config.getoption("--regen"):
        golden.write_bytes(file.data)
    assert file.path == "leg.urdf"
    assert file.data == golden.read_bytes()
    assert not (HERE / "out").exists()


def test_only_planned_bytes_change(leg: api.Compilation) -> None:
    """Outside of the head four joints' numbers and one mesh path are all that differs, each in its place."""
    after = leg.emissions[0].files[0].data
    lines = changes(LEG.read_bytes(), after)
    told = [line.split("<!--")[0].strip() for line in lines if "filename" not in line]
    # peak_torque 30 N*m is the limit; its speed limit is the file's 20 rad/s, but the knee's is overridden.
    assert sorted(told) == sorted(
        [
            """-     <limit velocity='20' upper="1" effort="24.0" lower="-1"/>""",
            """+     <limit velocity='20' upper="1" effort="30" lower="-1"/>""",
            """+     <dynamics damping="0.05" friction="0.4"/>""",
            """-     <dynamics friction="0.3\"""",
            """-               damping="0.9"/>""",
            """-     <limit effort="24" velocity="20" lower="-2" upper="0"/>""",
            """+     <dynamics friction="0.4\"""",
            """+               damping="0.05"/>""",
            """+     <limit effort="30" velocity="17.5" lower="-2" upper="0"/>""",
            """+     <limit effort="3" velocity="50"/>""",
        ]
    )
    assert sum("/thigh.stl" in line for line in lines) == 2
    assert b"page 3 -->" in after and b"package://leg/meshes/thigh.stl" in after


def test_read_by_another_reader(leg: api.Compilation) -> None:
    """yourdfpy reads the planned numbers in the written file, and the original's everywhere else."""
    yourdfpy = pytest.importorskip("yourdfpy")
    folder = Path(leg.targets[0].folder)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "leg.urdf").write_bytes(leg.emissions[0].files[0].data)

    def joints(path: Path) -> dict[str, Any]:
        flags = dict.fromkeys(
            ("load_meshes", "build_scene_graph", "load_collision_meshes", "build_collision_scene_graph"),
            False,
        )
        return {joint.name: joint for joint in yourdfpy.URDF.load(str(path), **flags).robot.joints}

    old, new = joints(LEG), joints(folder / "leg.urdf")
    assert list(old) == list(new)
    hip, knee, wheel = new["hip"], new["knee"], new["wheel"]
    assert (hip.limit.effort, hip.limit.velocity, hip.limit.lower, hip.limit.upper) == (30, 20, -1, 1)
    assert (hip.dynamics.damping, hip.dynamics.friction) == ("0.05", "0.4")
    assert (knee.limit.effort, knee.limit.velocity, knee.limit.lower, knee.limit.upper) == (30, 17.5, -2, 0)
    assert (knee.dynamics.damping, knee.dynamics.friction) == ("0.05", "0.4")
    assert (wheel.limit.effort, wheel.limit.velocity) == (3, 50)
    assert wheel.dynamics is None
    for name in ("toe", "mount"):
        assert vars(new[name].limit) == vars(old[name].limit)
    for name in old:
        assert (new[name].type, new[name].parent, new[name].child) == (
            old[name].type,
            old[name].parent,
            old[name].child,
        )
        if old[name].axis is not None:
            assert list(new[name].axis) == list(old[name].axis)
    assert new["toe"].mimic.joint == "knee" and new["toe"].mimic.multiplier == 0.5


def test_losses(leg: api.Compilation) -> None:
    """Each field that a URDF has no place for is said, and sized where the file says something else for it."""
    lost = {(loss.joint, loss.field): loss for loss in leg.approximations}
    drive = ("kp", "kd", "torque_speed_curve", "armature", "friction.static")
    assert [key for key in lost if key[0] != "wheel"] == [(j, f) for j in ("hip", "knee") for f in drive]
    assert [field for joint, field in lost if joint == "wheel"] == ["kd", "delay"]
    assert lost["hip", "kd"].asked == "1.5 N*m*s/rad" and lost["hip", "kd"].emitted == "none"
    assert {lost["hip", field].max_torque_error for field in ("kp", "kd", "armature")} == {None}
    # 0.7 - 0.4 N*m.
    assert lost["knee", "friction.static"].max_torque_error == pytest.approx(0.3)
    # 45 - 45/30 w at w = 30 rad/s is 0, and the clip 30. At 60 rad/s, twice that, the line forces -30: 60 apart.
    line = lost["hip", "torque_speed_curve"]
    assert (line.max_torque_error, line.beyond) == (pytest.approx(30.0), pytest.approx(60.0))
    assert line.at == "driving at 30 rad/s, none braking"
    assert lost["wheel", "delay"].asked == "4 ms, range 2 to 6 ms"
    assert {loss.field for loss in leg.unaccepted} == {loss.field for loss in leg.approximations} - {"kp"}


@pytest.mark.parametrize(
    "fields, lost",
    [
        ("command_range: [-1 rad, 2 rad]", [("command_range", "-1 rad to 2 rad", "none", None)]),
        ("command_filter: {cutoff: 30 Hz}", [("command_filter", "30 Hz", "none", None)]),
        ("encoder_bias: 0.01 rad", [("encoder_bias", "0.01 rad", "none", None)]),
        ("delay: {nominal: 4 ms}", [("delay", "4 ms", "none", None)]),
        # Equal to sliding friction: nothing is lost.
        ("friction: {coulomb: 0.4 N*m, static: 0.4 N*m, stribeck_velocity: 1 rad/s}", []),
        (
            "friction: {coulomb: 0.4 N*m, static: 0.5 N*m, stribeck_velocity: 2 rad/s}",
            [
                ("friction.static", "0.5 N*m", "0.4 N*m", pytest.approx(0.1)),
                ("friction.stribeck_velocity", "2 rad/s", "none", pytest.approx(0.1)),
            ],
        ),
    ],
    ids=["range", "filter", "bias", "fixed delay", "no break-away", "Stribeck"],
)
def test_other_losses(fields: str, lost: list[Any]) -> None:
    """Beside the gains each of these is lost under its own name, and nothing more."""
    done = compiled(view(urdf(joint(LIMIT))), group(fields))
    found = [(a.field, a.asked, a.emitted, a.max_torque_error) for a in done.approximations]
    assert found[2:] == lost and [field for field, *_ in found[:2]] == ["kp", "kd"]


@pytest.mark.parametrize("kp, sized", [("40 N*m/rad", True), ("unknown", False)], ids=["known", "no law"])
def test_curve(kp: str, sized: bool) -> None:
    """A curve is lost for its effort limit: above 30 rad/s it has nothing left where the clip gives 20 N*m."""
    legs = f"""  legs: {{joints: [j], level: dc_motor, motor: curve, kp: {kp}, kd: 1 N*m*s/rad,
    effort_limit: 20 N*m}}
"""
    done = compiled(view(urdf(joint(LIMIT))), legs)
    (lost,) = (a for a in done.approximations if a.field == "torque_speed_curve")
    assert (lost.asked, lost.emitted) == ("curve from 20 N*m to 30 rad/s", "effort 20 N*m")
    assert (lost.max_torque_error is not None and lost.max_torque_error >= 20.0) is sized
    assert sized or lost.max_torque_error is None


def test_networks_are_named() -> None:
    """A network and a robot-wide correction are lost by the names of their files."""
    legs = """  legs: {joints: [j], level: actuator_net, network: {file: nets/j.pt}, effort_limit: 9 N*m}
delta_action: {manifest: nets/delta.json}
"""
    done = compiled(view(urdf(joint(LIMIT))), legs)
    found = [(a.joint, a.field, a.asked) for a in done.approximations]
    assert found == [("j", "network", "j.pt"), ("", "delta_action", "delta.json")]
    assert (
        b"  delta_action: delta.json -> none (a URDF describes joints, not their drives)\n"
        in done.files[0].data
    )


def test_head(leg: api.Compilation) -> None:
    """The head has each number's origin and source, groups in the place of their joints, and ends its comment."""
    text = leg.emissions[0].files[0].data.decode()
    head = text[text.index("<!--\n") : text.index("<robot")]
    assert text.startswith(
        '<?xml version="1.0"?>\n<!-- a leg on a cart, drawn by hand -->\n<!--\n  Written by'
    )
    for line in (
        "  Not managed by the spec: toe",
        "  legs: hip",
        "    damping 0.05 N*m*s/rad (authored; bench)",
        "    velocity 17.5 rad/s (authored)",
        "    kd: 1.5 N*m*s/rad -> none (a URDF describes joints, not their drives): legs",
        "    bench: Friction of the leg, 4",
        "    friction 0 N*m (default; not written)",
    ):
        assert f"{line}\n" in head
    assert head.count("-->") == 1 and head.endswith("-->\n")


def test_audit_is_clean(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    """`audit --spec` of what was written finds nothing; of the author's file it does."""
    for name in ("leg.urdf", "leg.yaml"):
        (tmp_path / name).write_bytes((HERE / name).read_bytes())
    monkeypatch.chdir(tmp_path)
    done = api.compile("leg.yaml", output="out")
    output.write(output.outputs(done))
    arguments = ["--spec", "leg.yaml", "--fail-on", "warning", "--ignore", "PRV101"]
    assert main(["audit", "out/urdf/leg.urdf", *arguments]) == 0, capsys.readouterr().out
    assert main(["audit", "leg.urdf", *arguments]) == 1


CRLF = (
    '\ufeff<?xml version="1.0"?>\r\n<r:robot/>\r\n'
).replace("<r:robot/>", urdf(
    joint('<limit effort="24" velocity="20" lower="-1" upper="1"/>', name="it's"),
    "<joint type='revolute' name='say \"up\" &amp; &lt;go>'>\r\n\t<parent link='l1'/><child link='l2'/>\r\n"
    "\t<limit effort='24' velocity='20' lower='-1' upper='1'/>\r\n</joint>",
).replace("\n", "\r\n").replace("\r\r", "\r").replace(
    '<robot name="r">', '<robot name="r" xmlns:gazebo="http://g" xmlns="http://u">\r\n<gazebo:limit effort="1"/>'
))  # fmt: skip


def test_byte_order_mark_crlf_namespaces_and_quotes() -> None:
    """Line endings, quotes, prefixes and names with quotes stay; what is added has the file's line ending."""
    before = CRLF.encode()
    done = compiled(view(before), group("effort_limit: 30 N*m\n    friction: {coulomb: 0.5 N*m}", '".*"'))
    after = done.files[0].data
    assert after.startswith(b'\xef\xbb\xbf<?xml version="1.0"?>\r\n<!--\r\n  Written by')
    assert b"\n" not in after.replace(b"\r\n", b"")
    added = b'<dynamics friction="0.5"/>'
    one = '<limit effort="24" velocity="20" lower="-1" upper="1"/>'
    two = "<limit effort='24' velocity='20' lower='-1' upper='1'/>\r\n"
    expected = before.replace(one.encode(), one.replace("24", "30").encode() + added)
    expected = expected.replace(two.encode(), two.replace("24", "30").encode() + b"\t" + added + b"\r\n")
    assert HEAD.sub(b"", after) == expected
    names = [j.name for j in read_urdf((ModelFile("r.urdf", "", after),), refusal="a test").joints]
    assert names == ["it's", 'say "up" & <go>']


def test_names_cannot_end_the_comment() -> None:
    """A joint named `a-->b` is shown in the head without ending it."""
    text = urdf(joint('<limit effort="1" velocity="2" lower="-1" upper="1"/>', name="a--&gt;b"))
    data = compiled(view(text), group("effort_limit: 30 N*m", '".*"')).files[0].data
    assert data.count(b"-->") == 1
    assert parse_document((ModelFile("r.urdf", "", data),)).root.tag == "robot"


@pytest.mark.parametrize(
    "before, kind, rest, after",
    [
        (LIMIT, "revolute", "velocity_limit: 10 rad/s", LIMIT.replace("20", "10")),
        ('<limit effort="24.00" velocity="2e1"/>', "continuous", "effort_limit: 24 N*m", None),
        ('<limit effort="24"/>', "continuous", "velocity_limit: 9 rad/s", '<limit effort="24" velocity="9"/>'),
        ("<limit/>", "continuous", "effort_limit: 9 N*m", '<limit effort="9"/>'),
        (LIMIT, "revolute", "effort_limit: unknown", None),
        (LIMIT, "revolute", "friction: {viscous: 0 N*m*s/rad}", LIMIT + '<dynamics damping="0"/>'),
        (LIMIT + "<dynamics/>", "revolute", "friction: {coulomb: 0.1 N*m}", LIMIT + '<dynamics friction="0.1"/>'),
        (LIMIT + '<dynamics damping="0.5"/>', "revolute", "friction: {viscous: unknown}", None),
        (LIMIT + '<limit effort="1" velocity="1"/>', "revolute", "effort_limit: 30 N*m",
         LIMIT.replace("24", "30") + '<limit effort="1" velocity="1"/>'),
        (LIMIT + "<xx:limit effort='1'/>", "revolute", "effort_limit: 1e3 N*m",
         LIMIT.replace("24", "1000") + "<xx:limit effort='1'/>"),
    ],
    ids=["one of two", "equal numbers stay as written", "absent speed", "empty limit", "unknown effort",
         "an authored zero is written", "empty dynamics", "unknown viscous", "second limit", "prefixed limit"],
)  # fmt: skip
def test_one_joint(before: str, kind: str, rest: str, after: str | None) -> None:
    """What becomes of one joint's elements; kd of 1.5 is nowhere in them."""
    text = urdf(joint(before, kind)).replace("<robot ", '<robot xmlns:xx="http://x" ')
    written = compiled(view(text), group(rest)).files[0].data.decode()
    assert written[written.index("-->") + 4 :] == text.replace(before, after or before)


SLIDE = """  lift: {joints: [j], level: ideal_pd, kp: 900 N/m, kd: 20 N*s/m, effort_limit: 60 N,
    velocity_limit: 30 cm/s, friction: {viscous: 2 N*s/m, coulomb: 4 N}}
"""


def test_slide() -> None:
    """A prismatic joint is in N and m/s: 30 cm/s is 0.3 m/s."""
    text = urdf(joint('<dynamics friction="3"/><limit effort="1" velocity="1" upper="1"/>', "prismatic"))
    written = compiled(view(text), SLIDE).files[0].data.decode()
    assert '<dynamics friction="4" damping="2"/><limit effort="60" velocity="0.3" upper="1"/>' in written


@pytest.mark.parametrize(
    "kind, rest, why",
    [
        ("revolute", "effort_limit: 30 N*m\n    velocity_limit: 9 rad/s", "would lock it"),
        ("continuous", "effort_limit: 30 N*m\n    velocity_limit: unknown", "one of them is unknown"),
    ],
    ids=["revolute", "half a limit"],
)
def test_limit_without_a_place(kind: str, rest: str, why: str) -> None:
    """A limit that the file has no element for, and that cannot be added, is lost with its reason."""
    text = urdf(joint("", kind))
    done = compiled(view(text), group(rest))
    assert HEAD.sub(b"", done.files[0].data).decode() == text
    lost = [loss for loss in done.approximations if loss.field.endswith("_limit")]
    assert (lost[0].field, lost[0].asked, lost[0].emitted) == ("effort_limit", "30 N*m", "none")
    assert len(lost) == rest.count("_limit") - rest.count("unknown")
    assert all(why in loss.why for loss in lost)


def test_unknown_is_said() -> None:
    """A number that nobody says is named, with what the file has; never 0."""
    two = urdf(joint(LIMIT), joint('<limit effort="3"/>', "continuous", "k", 1))
    done = compiled(view(two), group("velocity_limit: unknown", "j, k"))
    told = [str(item).partition("URD004 ")[2] for item in done.diagnostics]
    assert told == [
        "[info] actuators.all.velocity_limit: velocity_limit is unknown, and velocity stays as the file has it: j",
        "[info] actuators.all.velocity_limit: velocity_limit is unknown, and velocity is not in the file either: k",
    ]
    assert b'velocity="0' not in done.files[0].data


def test_mimic_stays() -> None:
    """A joint that follows another one is left as it is, with a warning where the spec manages it."""
    text = urdf(joint(LIMIT), joint(f'{LIMIT}<mimic joint="j"/>', name="k", index=1))
    done = compiled(view(text), group("effort_limit: 30 N*m", "j, k"))
    written = done.files[0].data.decode()
    assert written.count('effort="30"') == 1 and f'{LIMIT}<mimic joint="j"/>' in written
    (item,) = done.diagnostics
    assert (item.code, item.where) == ("URD003", "k")
    assert "\n  all: j\n" in written


@pytest.mark.parametrize(
    "path, expected",
    [
        ("m/a.stl", "../m/a.stl"),
        ("../m/a.stl", "../../m/a.stl"),
        ("package://d/a.stl", "package://d/a.stl"),
        ("file:///a.stl", "file:///a.stl"),
        ("/m/a.stl", "/m/a.stl"),
        ("C:\\m\\a.stl", "C:\\m\\a.stl"),
        ("$(find d)/a.stl", "$(find d)/a.stl"),
    ],
)
def test_mesh_paths(path: str, expected: str) -> None:
    """A path from the file's folder is written from the output's; the others are left."""
    text = urdf(joint(LIMIT)).replace(
        '<link name="l0"/>', f'<link name="l0"><mesh filename="{path}"/></link>'
    )
    written = compiled(view(text), group("")).files[0].data.decode()
    assert f'<mesh filename="{expected}"/>' in written


@pytest.mark.parametrize("strip, name", [("", "../m/a.stl"), (' strippath="false"', "m/a.stl")])
def test_mesh_folder_of_mujoco(strip: str, name: str) -> None:
    """MuJoCo's `meshdir` is written from the output's folder; joined with the names, these stay."""
    inside = (
        f'<mujoco><compiler meshdir="m"{strip}/></mujoco><link name="l0"><mesh filename="m/a.stl"/></link>'
    )
    text = urdf(joint(LIMIT)).replace('<link name="l0"/>', inside)
    written = compiled(view(text), group("")).files[0].data.decode()
    assert f'meshdir="../m"{strip}/>' in written and f'<mesh filename="{name}"/>' in written


MJCF = '<mujoco><worldbody><body><joint name="j"/><geom size="1"/></body></worldbody></mujoco>'


def test_an_mjcf_is_refused() -> None:
    """The URDF target of a robot that is an MJCF names it, and says what to do."""
    with pytest.raises(EmitError) as caught:
        compiled(view_of(MJCF), group("effort_limit: 30 N*m"))
    assert str(caught.value) == (
        "URD001 robot.model: the URDF target edits a URDF, and the spec's model is an MJCF\n"
        "  help: name the robot's URDF, or leave the target out"
    )


@pytest.mark.parametrize("prefix, uri", [("xacro", "x"), ("x", "http://www.ros.org/wiki/xacro")])
def test_a_xacro_is_refused(prefix: str, uri: str) -> None:
    """An element of xacro, by its prefix or its namespace, is named with its line; a namespace alone is not."""
    text = urdf(joint(LIMIT)).replace("<robot ", f'<robot xmlns:{prefix}="{uri}" ')
    assert compiled(view(text), group("")).files
    with pytest.raises(EmitError) as caught:
        compiled(view(text.replace("</robot>", f"<{prefix}:leg side='l'/></robot>")), group(""))
    (item,) = caught.value.diagnostics
    assert item.code == "URD002" and f"<{prefix}:leg>" in item.message
    assert item.span is not None and item.span.line == 5


@pytest.mark.parametrize(
    "old, new, named",
    [
        ("", "", []),
        ('effort="30"', 'effort="31"', ["hip"]),
        ('effort="30"', 'effort="30" lower="-2"', ["attribute 'lower' appears twice"]),
        ('value="2"', 'value="2.5"', ["<mass>"]),
        ('multiplier="0.5"', 'multiplier="0.6"', ["<mimic>"]),
        ('lower="-1"', 'lower="-1.5"', ["hip", "<limit>"]),
        (
            '<limit effort="3" velocity="50"/>',
            '<limit effort="3" velocity="50" lower="1"/>',
            ["wheel", "<limit>"],
        ),
        ('name="thigh"', 'name="thig"', ["<link>"]),
        ('<link name="roller"/>', "", ["<link>"]),
        ("<transmission", "<transmissio", []),
    ],
    ids=["the plan", "number", "attribute twice", "mass", "mimic", "range", "added", "link", "gone", "torn"],
)
def test_check_sees(old: str, new: str, named: list[str]) -> None:
    """What strays from plan or original by one byte or element is found."""
    # Behind the head, where the same numbers stand in words.
    head, start, body = (HERE / "golden.urdf").read_text().partition("<robot")
    data = head + start + (body.replace(old, new, 1) if old else body)
    document = parse_document((ModelFile(str(LEG), "", LEG.read_bytes()),))
    edits = [
        UrdfJointEdit("hip", {"limit": {"effort": 30.0}, "dynamics": {"damping": 0.05, "friction": 0.4}},
                  frozenset({"dynamics"})),
        UrdfJointEdit("knee", {"limit": {"effort": 30.0, "velocity": 17.5},
                           "dynamics": {"damping": 0.05, "friction": 0.4}}, frozenset()),
        UrdfJointEdit("wheel", {"limit": {"effort": 3.0, "velocity": 50.0}}, frozenset({"limit"})),
    ]  # fmt: skip
    found = deviations(
        document, (ModelFile(str(HERE / "out" / "urdf" / "leg.urdf"), "", data.encode()),), edits
    )
    assert found[: len(named)] == named if named else bool(found) == bool(old)


def test_command_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Any) -> None:
    """`compile -t urdf` writes the file and its manifest, again without a change; `--strict` refuses."""
    for name in ("leg.urdf", "leg.yaml"):
        (tmp_path / name).write_bytes((HERE / name).read_bytes())
    monkeypatch.chdir(tmp_path)
    assert main(["compile", "leg.yaml", "-t", "urdf"]) == 0
    assert main(["compile", "leg.yaml", "-t", "urdf", "--check"]) == 0
    assert main(["compile", "leg.yaml", "-t", "urdf", "--strict"]) == 1
    assert "urdf.kd (3 joints)" in capsys.readouterr().err
    assert load_robot("build/leg/urdf/leg.urdf").joint("knee").velocity_limit == 17.5  # type: ignore[union-attr]


def test_compiled_again(leg: api.Compilation, tmp_path: Path) -> None:
    """The spec against its own output changes nothing but the head."""
    (tmp_path / "leg.urdf").write_bytes(leg.emissions[0].files[0].data)
    (tmp_path / "leg.yaml").write_bytes((HERE / "leg.yaml").read_bytes())
    again = api.compile(tmp_path / "leg.yaml", output=str(tmp_path / "out"))
    first, second = (done.emissions[0].files[0].data for done in (leg, again))
    told = changes(HEAD.sub(b"", first), second)
    assert [line[0] for line in told] == ["-", "+"] and all("thigh.stl" in line for line in told)
