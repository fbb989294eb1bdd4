"""URDF to view: what the text states, what MuJoCo adds, what is refused."""

from __future__ import annotations

import math
import os
import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np
import pytest

from actspec.diagnostics import RobotError, Severity
from actspec.ir import JointKind
from actspec.robot.load import load_robot
from actspec.robot.mjspec import compiled_model, open_urdf
from actspec.robot.view import JointView, ModelFile, ModelFormat, RobotView
from actspec.robot.xml import parse_document

CORPUS = Path(os.environ.get("ACTSPEC_CORPUS", Path(__file__).parents[3] / "shared" / "corpus"))
REAL = sorted(CORPUS.rglob("*.urdf")) if CORPUS.is_dir() else []

INERTIAL = """<inertial><origin xyz="{x} 0 0"/><mass value="{m}"/>
<inertia ixx="{i}" iyy="{i}" izz="{i}" ixy="0" ixz="0" iyz="0"/></inertial>"""


@pytest.fixture(autouse=True)
def _in_tmp_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def read(text: str) -> RobotView:
    """A view of a URDF text."""
    Path("r.urdf").write_text(text)
    return load_robot("r.urdf")


def robot(joints: str, links: str = "") -> str:
    """A robot with the links base, a, b and these joints."""
    a, b = INERTIAL.format(x=0.5, m=2, i=0.1), INERTIAL.format(x=0.4, m=3, i=0.2)
    return f"""<robot name="r">
<link name="base"/><link name="a">{a}</link><link name="b">{b}</link>{links}
{joints}</robot>"""


def joint(
    inner: str = "", kind: str = "revolute", name: str = "j", parent: str = "base", child: str = "a"
) -> str:
    """A joint about z, on one line of its own."""
    return (
        f'\n<joint name="{name}" type="{kind}"><axis xyz="0 0 1"/><parent link="{parent}"/>'
        f'<child link="{child}"/>{inner}</joint>'
    )


def only(inner: str, kind: str = "revolute") -> JointView:
    """The view of joint `j`; joint `k` hangs on it."""
    view = read(robot(joint(inner, kind) + joint("", "fixed", "k", "a", "b")))
    (found,) = view.joints
    return found


def messages(text: str) -> list[str]:
    """Warnings of a text that reads."""
    return [str(d).split("\n")[0] for d in read(text).diagnostics]


def test_values_are_the_text() -> None:
    """Limits and dynamics of a revolute joint, with its child link and place."""
    found = only(
        '<limit lower="-1" upper="2" effort="33.5" velocity="21"/><dynamics damping="0.4" friction="0.3"/>'
    )
    assert (found.kind, found.range, found.effort_range) == (JointKind.HINGE, (-1.0, 2.0), (-33.5, 33.5))
    assert (found.velocity_limit, found.damping, found.frictionloss) == (21.0, 0.4, 0.3)
    assert (found.body, found.dof, found.armature, found.mimic) == ("a", 0, 0.0, None)
    assert found.stated == {"range", "effort", "velocity", "damping", "frictionloss"}
    assert (found.span.path, found.span.line, found.span.column) == ("r.urdf", 6, 1)


@pytest.mark.parametrize(
    ("inner", "stated", "range", "effort", "velocity"),
    [
        ("", set(), None, None, None),
        ('<limit effort="5"/>', {"effort"}, None, (-5.0, 5.0), None),
        ('<limit velocity="3"/>', {"velocity"}, None, None, 3.0),
        # An absent end is 0 in URDF.
        ('<limit upper="1"/>', {"range"}, (0.0, 1.0), None, None),
        ('<limit lower="0" upper="0"/>', {"range"}, None, None, None),
        ('<limit lower="-inf" upper="inf" effort="inf"/>', {"range", "effort"}, None, None, None),
        ('<limit effort=" 1e1 " velocity=".5"/>', {"effort", "velocity"}, None, (-10.0, 10.0), 0.5),
    ],
    ids=["nothing", "effort", "velocity", "upper", "equal", "infinite", "spelling"],
)
def test_absent_is_not_stated(
    inner: str,
    stated: set[str],
    range: tuple[float, float] | None,
    effort: tuple[float, float] | None,
    velocity: float | None,
) -> None:
    """Each attribute by itself: what is absent is neither stated nor 0."""
    found = only(inner)
    assert (found.stated, found.range, found.effort_range, found.velocity_limit) == (
        stated,
        range,
        effort,
        velocity,
    )


@pytest.mark.parametrize(
    ("kind", "expected", "range"),
    [
        ("revolute", JointKind.HINGE, (-1.0, 2.0)),
        ("continuous", JointKind.HINGE, None),
        ("prismatic", JointKind.SLIDE, (-1.0, 2.0)),
        ("floating", JointKind.FREE, None),
    ],
)
def test_types(kind: str, expected: JointKind, range: tuple[float, float] | None) -> None:
    """A continuous joint has no range, whatever its limit says."""
    found = only('<limit lower="-1" upper="2" effort="5" velocity="1"/>', kind)
    assert (found.kind, found.range) == (expected, range)


def test_fixed_and_planar_are_left_out() -> None:
    """A fixed joint is no joint; a planar one is named in a note."""
    text = robot(joint("", "fixed") + joint("", "planar", "p", "a", "b"))
    view = read(text)
    assert view.joints == ()
    assert [str(d) for d in view.diagnostics] == ["r.urdf:1:1: ROBOT113 [info]: planar joints left out: p"]


def test_a_spherical_joint_is_a_ball() -> None:
    """No type of URDF, but of Bullet's, RaiSim's and MuJoCo's: a note, and the hinge behind it is dof 3."""
    inside = (
        '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    )
    links = "".join(f'<link name="{name}">{inside}</link>' for name in "abc")
    text = (
        f'<robot name="r">{links}<joint name="s" type="spherical"><parent link="a"/><child link="b"/></joint>'
        '<joint name="h" type="continuous"><parent link="b"/><child link="c"/><axis xyz="0 0 1"/></joint></robot>'
    )
    view = read(text)
    assert [(j.name, j.kind, j.dof) for j in view.joints] == [
        ("s", JointKind.BALL, 0),
        ("h", JointKind.HINGE, 3),
    ]
    assert [str(d) for d in view.diagnostics] == [
        "r.urdf:1:1: ROBOT113 [info]: spherical joints, which not every reader of URDF knows: s"
    ]


def test_mimic() -> None:
    """A mimic joint names the one that it follows, and an unknown one is a warning."""
    follow = joint('<mimic joint="j"/>', name="k", parent="a", child="b")
    assert [j.mimic for j in read(robot(joint() + follow)).joints] == [None, "j"]
    assert messages(robot(joint('<mimic joint="no"/>'))) == [
        "r.urdf:6:1: ROBOT124 [warning] j: mimics 'no', which is not a joint"
    ]


def test_nothing_hangs_on_a_floating_joint() -> None:
    """The floating base of a URDF is a base."""
    free = joint(name="root", kind="floating")
    chain = joint(name="hip", parent="a", child="b") + joint(name="knee", parent="b", child="c")
    view = read(robot(free + chain, '<link name="c"/>'))
    assert {one.name: one.parent for one in view.joints} == {"root": "", "hip": "", "knee": "hip"}


def test_zero_limits_are_stated_and_warned_of() -> None:
    """effort 0 is a stated 0, which MuJoCo reads as no limit and others as a dead joint."""
    text = robot(joint('<limit effort="0" velocity="0"/>'))
    (found,) = read(text).joints
    assert (found.effort_range, found.velocity_limit) == ((0.0, 0.0), 0.0)
    assert str(found.effort_range) == "(0.0, 0.0)"
    assert found.stated == {"effort", "velocity"}
    # Column: 32 (joint tag) + 19 (axis) + 21 (parent) + 17 (child) + 1
    assert messages(text) == [
        "r.urdf:6:90: ROBOT125 [warning] j: limit effort is 0 N*m: MuJoCo reads it as no limit, other "
        "importers as a dead joint",
        "r.urdf:6:90: ROBOT125 [warning] j: limit velocity is 0 rad/s: importers disagree whether that is no "
        "limit or a locked joint",
    ]


def test_zero_limits_of_many_joints_are_one_warning() -> None:
    """Five joints with effort 0, four of them hinges: one warning a unit, at the first of them, with the count."""
    limit = '<limit effort="0" velocity="3"/>'
    chain = "".join(joint(limit, name=f"k{i}", parent=f"l{i}", child=f"l{i + 1}") for i in range(3))
    rail = joint(limit, name="rail", parent="l3", child="l4").replace("revolute", "prismatic")
    links = "".join(f'<link name="l{i}"/>' for i in range(5))
    text = robot(joint(limit, child="l0") + chain + rail, links)
    said = [line.partition("] ")[2].partition(": MuJoCo")[0] for line in messages(text) if "ROBOT125" in line]
    assert said == [
        "j, k0, k1 and 1 more: limit effort is 0 N*m at 4 joints",
        "rail: limit effort is 0 N",
    ]


def test_nonsense_limits_are_no_limits() -> None:
    """Negative limits and a lower above the upper are warned of, in the joint's own units."""
    text = robot(joint('<limit lower="2" upper="1" effort="-5" velocity="-3"/>', "prismatic"))
    (found,) = read(text).joints
    assert (found.range, found.effort_range, found.velocity_limit) == (None, None, None)
    assert [m.split(": ", 2)[2] for m in messages(text)] == [
        "limit effort must be >= 0 N, got -5; judged as no limit",
        "limit velocity must be >= 0 m/s, got -3; judged as no limit",
        "limit lower 2 is above upper 1; MuJoCo and Bullet take it as no limit",
    ]


def test_a_limit_that_sdf_takes_for_none() -> None:
    """-1 is how SDF says that nothing limits it, and a remark; -1.5 is nonsense."""
    for effort, severity in (("-1", "info"), ("-1.5", "warning")):
        text = robot(joint(f'<limit lower="1" upper="2" effort="{effort}" velocity="3"/>', "revolute"))
        (said,) = [one for one in read(text).diagnostics if one.code == "ROBOT123"]
        assert said.severity.value == severity


@pytest.mark.parametrize(
    ("ends", "severity", "told"),
    [
        (
            ("1", "-1.0"),
            Severity.INFO,
            "1 is above upper -1, as Bullet's files free a joint; MuJoCo and Bullet take it as no limit",
        ),
        (("2", "-2"), Severity.WARNING, "2 is above upper -2; MuJoCo and Bullet take it as no limit"),
        (("0", "-1"), Severity.WARNING, "0 is above upper -1; MuJoCo and Bullet take it as no limit"),
    ],
)
def test_a_joint_that_bullet_leaves_free(ends: tuple[str, str], severity: Severity, told: str) -> None:
    """Exactly 1 and -1 is how Bullet's own files write it, and no slip."""
    limit = f'<limit lower="{ends[0]}" upper="{ends[1]}" effort="5" velocity="3"/>'
    view = read(robot(joint(limit)))
    assert view.joints[0].range is None
    said = [item for item in view.diagnostics if item.code == "ROBOT123"]
    assert [(item.severity, item.message) for item in said] == [(severity, f"limit lower {told}")]


def test_all_errors_at_once() -> None:
    """Malformed numbers, types and names are all reported, each at its element."""
    text = robot(
        joint('<limit lower="1,5" effort="nan" velocity="1_0"/>')
        + joint('<dynamics damping="" friction="٣"/>', name="k", parent="a", child="b")
        + joint("", "revolut", "m")
        + joint("", "fixed", "j")
    )
    with pytest.raises(RobotError) as caught:
        read(text)
    assert [str(d) for d in caught.value.diagnostics] == [
        "r.urdf:6:90: ROBOT120 j: <limit lower> must be a number, got '1,5'",
        "r.urdf:6:90: ROBOT120 j: <limit effort> must be a number, got 'nan'",
        "r.urdf:6:90: ROBOT120 j: <limit velocity> must be a number, got '1_0'",
        "r.urdf:7:87: ROBOT120 k: <dynamics damping> must be a number, got ''",
        "r.urdf:7:87: ROBOT120 k: <dynamics friction> must be a number, got '٣'",
        "r.urdf:8:1: ROBOT122 m: type 'revolut' is not a URDF joint type\n  help: did you mean revolute?",
        "r.urdf:9:1: ROBOT121 j: a second joint has this name; the first is in line 6",
    ]


def test_a_value_that_xacro_computes() -> None:
    """It is no slip of a number: the file is to be expanded first."""
    with pytest.raises(RobotError) as caught:
        read(robot(joint('<limit effort="${e}" velocity="3"/>')))
    assert [str(d) for d in caught.value.diagnostics] == [
        "r.urdf:6:90: ROBOT120 j: <limit effort> must be a number, got '${e}'\n"
        "  help: this is a xacro, which is not expanded here: xacro ROBOT.urdf.xacro -o ROBOT.urdf, and name that"
    ]


def test_joints_of_transmissions_are_not_joints() -> None:
    """Only joints right below the root count; one without a name is noted."""
    extra = '<transmission name="t"><joint name="x" type="revolute"/></transmission>'
    nameless = '<joint type="fixed"><parent link="a"/><child link="b"/></joint>'
    view = read(robot(joint() + nameless + extra))
    assert [j.name for j in view.joints] == ["j"]
    assert [d.message for d in view.diagnostics] == ["1 joint without a name left out"]


def test_order_and_inertia_are_of_the_tree() -> None:
    """Joints come in tree order, not text order, and the matrix is the two-link arm's.

    I1 + m1 c1^2 + I2 + m2 (l1 + c2)^2 = 0.1 + 0.5 + 0.2 + 3*1.96 = 6.68 at the joint near the base,
    with the second joint 1 m out; M22 = 0.2 + 3*0.16 = 0.68; M12 = 0.68 + 3*0.4 = 1.88.
    """
    far = joint('<origin xyz="1 0 0"/>', "continuous", "far", "a", "b")
    view = read(robot(far + joint("", "continuous", "near")))
    assert [(j.name, j.dof, j.span.line) for j in view.joints] == [("near", 0, 7), ("far", 1, 6)]
    assert view.inertia is not None
    np.testing.assert_allclose(view.inertia.matrices[0], [[6.68, 1.88], [1.88, 0.68]], rtol=1e-12)
    np.testing.assert_allclose(view.inertia.armature, [0, 0])
    assert (view.timestep, view.integrator, view.actuators, view.name) == (None, "", (), "r")


def test_refused_by_mujoco_is_still_read() -> None:
    """MuJoCo refuses a link without mass: the joints are read, and the inertia has a reason."""
    text = robot(joint('<limit effort="5"/>', child="c"), '<link name="c"/>')
    view = read(text)
    assert [(j.name, j.dof, j.effort_range) for j in view.joints] == [("j", -1, (-5.0, 5.0))]
    assert view.inertia is None
    assert view.inertia_reason == (
        "MuJoCo refuses the model: mass and inertia of moving bodies must be larger than mjMINVAL"
    )
    assert view.refusal == view.inertia_reason


def test_all_links_without_an_inertia_are_told_at_once() -> None:
    """One as CAD writes it for a frame, and one whose ixy is above its ixx: 1 - 2 is below 0. A sound one is not."""
    flat = (
        '<link name="{}"><inertial><mass value="1e-9"/>\n'
        '<inertia ixx="{}" ixy="{}" ixz="0" iyy="{}" iyz="0" izz="1"/></inertial></link>\n'
    )
    links = "".join(
        flat.format(*of) for of in (("f", "1e-27", 0, "1e-27"), ("g", "1", "2", "1"), ("h", "1", "0.5", "1"))
    )
    fixed = "".join(joint("", "fixed", f"k_{name}", "a", name) for name in "fgh")
    text = robot(joint() + joint("", "fixed", "k", "a", "b") + fixed, "\n" + links)
    lines = {name: text[: text.index(f'name="{name}"')].count("\n") + 2 for name in "fg"}
    document = parse_document((ModelFile("r.urdf", "", text.encode()),))
    with pytest.raises(RobotError) as caught:
        compiled_model(document, ModelFormat.URDF, shapes=False)
    (item,) = caught.value.diagnostics
    assert (item.code, item.where) == ("ROBOT111", "f")
    assert item.span is not None and item.span.line == lines["f"] - 1
    assert item.help is not None and item.help.startswith(
        f"links with one below 1e-14 kg*m^2: f (line {lines['f']}), g (line {lines['g']}); leave `<inertial>` out"
    )


def test_figures_have_the_place_of_their_element() -> None:
    """A limit is at `limit`, friction at `dynamics`; what is not stated has no place."""
    view = read(robot(joint('\n<limit effort="5" upper="1"/>\n<dynamics friction="1"/>')))
    (found,) = view.joints
    line = found.span.line
    assert view.refusal is None
    assert {field: place.line - line for field, place in found.places.items()} == {
        "effort": 1,
        "range": 1,
        "frictionloss": 2,
    }


def test_meshes_are_not_needed() -> None:
    """Visual and collision meshes of any kind are stand-ins, two colours of one visual no obstacle."""
    mesh = '<geometry><mesh filename="package://p/{}"/></geometry>'
    colour = '<material name="{}"><color rgba="1 0 0 1"/></material>'
    link = (
        f'<link name="c">{INERTIAL.format(x=0, m=1, i=0.3)}<visual>{mesh.format("m/v.dae")}\n'
        f"{colour.format('x')}{colour.format('y')}</visual>"
        f"<collision>{mesh.format('n/v.STL')}</collision></link>"
    )
    view = read(robot(joint("", "continuous", child="c"), link))
    assert view.inertia is not None
    assert view.inertia.matrices[0, 0, 0] == pytest.approx(0.3)
    # The author's bytes are what the view carries.
    assert b"material" in view.files[0].data


def test_first_colour_stays() -> None:
    """Of several colours in one visual MuJoCo gets the first; lines stay, and other visuals keep theirs."""
    colour = '<material name="{0}"><color rgba="{0} 0 0 1"/></material>'
    shape = "<geometry><sphere radius='1'/></geometry>"
    link = (
        f'<link name="c">{INERTIAL.format(x=0, m=1, i=0.3)}<visual>{shape}{colour.format(0.25)}\n'
        f"{colour.format(0.5)}\n{colour.format(0.75)}</visual><visual>{shape}{colour.format(0.125)}</visual></link>"
    )
    keep = '<mujoco><compiler discardvisual="false"/></mujoco>'
    text = robot(joint("", "continuous", child="c"), link + keep)
    spec, files = open_urdf((ModelFile("r.urdf", "", text.encode()),))
    assert sorted(float(row[0]) for row in spec.compile().geom_rgba) == [0.125, 0.25]
    assert files[0].data.count(b"\n") == text.count("\n")


def shape(tag: str, name: str | None, radius: float) -> str:
    """A sphere that is seen or solid."""
    called = "" if name is None else f' name="{name}"'
    return f'<{tag}{called}><geometry><sphere radius="{radius}"/></geometry></{tag}>'


KEEP = '<mujoco><compiler discardvisual="false"/></mujoco>'


@pytest.mark.parametrize(
    ("links", "names", "head"),
    [
        ([shape("collision", "f", 1) + shape("collision", "f", 2)], {1: "f", 2: ""}, ""),
        ([shape("collision", "f", 1) + shape("collision", None, 2)], {1: "f", 2: ""}, ""),
        ([shape("collision", "f", 1) + shape("collision", None, 2)], {1: "f", 2: ""}, KEEP),
        ([shape("collision", "f", 1), shape("collision", "f", 2)], {1: "f", 2: ""}, ""),
        ([shape("visual", "f", 1) + shape("collision", "f", 2)], {2: "f"}, ""),
        ([shape("visual", "f", 1) + shape("collision", "f", 2)], {1: "f", 2: ""}, KEEP),
        ([shape("collision", "f", 1) + shape("visual", "f", 2)], {1: "f", 2: ""}, KEEP),
        ([shape("collision", "f", 1) + shape("collision", "g", 2)], {1: "f", 2: "g"}, ""),
    ],
)
def test_mujoco_prints_nothing_of_shapes_with_one_name(
    links: list[str], names: dict[float, str], head: str, capfd: pytest.CaptureFixture[str]
) -> None:
    """The names are those that MuJoCo gives, which it would print to standard error itself; the file's bytes stay."""
    # `d` hangs on `c` and stands before it: the order of the text counts.
    parts = [f'<link name="{n}">{inner}</link>' for n, inner in zip("dc", [*links, ""], strict=False)]
    text = robot(joint(name="k", child="c") + joint(parent="c", child="d"), "".join(parts) + head)
    spec, files = open_urdf((ModelFile("r.urdf", "", text.encode()),))
    assert capfd.readouterr() == ("", "")
    assert {float(geom.size[0]): geom.name for geom in spec.geoms} == names
    assert files[0].data == text.encode()
    theirs = mujoco.MjSpec.from_string(text)
    assert {float(geom.size[0]): geom.name for geom in theirs.geoms} == names


def test_mass_from_absent_mesh_is_unknown() -> None:
    """A link whose mass would come from its mesh has no inertia without the file."""
    link = '<link name="c"><collision><geometry><mesh filename="v.stl"/></geometry></collision></link>'
    view = read(robot(joint("", "continuous", child="c"), link))
    assert view.inertia is None
    assert view.inertia_reason == "the mass of body 'c' comes from mesh files that are not there"
    assert view.joints[0].dof == 0


@pytest.mark.slow
@pytest.mark.skipif(not REAL, reason="no corpus of real robot files")
@pytest.mark.parametrize("path", REAL, ids=lambda p: str(p.relative_to(CORPUS)))
def test_real_file_equals_its_text(path: Path) -> None:
    """Every real URDF: the numbers are those that another XML parser finds, joint by joint."""
    view = load_robot(str(path))
    root = ET.parse(path).getroot()
    moving = {
        e.attrib["name"]: e for e in root.findall("joint") if e.attrib["type"] not in ("fixed", "planar")
    }
    assert {j.name for j in view.joints} == set(moving)
    for found in view.joints:
        element = moving[found.name]
        limit, dynamics = element.find("limit"), element.find("dynamics")
        effort = float(limit.get("effort", "inf")) if limit is not None else math.inf
        assert found.effort_range == (None if math.isinf(effort) else (-effort, effort))
        if limit is not None and "velocity" in limit.attrib:
            assert found.velocity_limit == float(limit.attrib["velocity"])
        if element.attrib["type"] != "continuous" and limit is not None and "lower" in limit.attrib:
            ends = (float(limit.attrib["lower"]), float(limit.attrib["upper"]))
            assert found.range == (ends if ends[0] < ends[1] else None)
        damping = float(dynamics.get("damping", "0")) if dynamics is not None else 0.0
        assert found.damping == damping
        child = element.find("child")
        assert child is not None
        assert found.body == child.attrib["link"]
    if view.inertia is not None:
        # Only the joints move, and the order of dof is that of the joints.
        assert [j.dof for j in view.joints] == list(range(view.inertia.matrices.shape[1]))
        assert np.linalg.eigvalsh(view.inertia.matrices).min() > 0


def test_axes_are_in_the_frame_of_the_base() -> None:
    """MuJoCo takes the base for the world: half a turn about x turns z to -z, and a quarter more turns it to y.

    A quarter about x is y to z and z to -y: half and a quarter are z to y. The second joint is 0.5 m along y from
    the first, which half a turn makes -y: (1, 2 - 0.5, 3).
    """
    half = joint('<origin xyz="1 2 3" rpy="3.14159265358979 0 0"/>', "continuous", "j", "base", "a")
    quarter = joint('<origin xyz="0 0.5 0" rpy="1.5707963267949 0 0"/>', "continuous", "k", "a", "b")
    first, second = read(robot(half + quarter)).joints
    assert first.axis == pytest.approx((0.0, 0.0, -1.0), abs=1e-9)
    assert second.axis == pytest.approx((0.0, 1.0, 0.0), abs=1e-9)
    assert first.point == pytest.approx((1.0, 2.0, 3.0), abs=1e-9)
    assert second.point == pytest.approx((1.0, 1.5, 3.0), abs=1e-9)
