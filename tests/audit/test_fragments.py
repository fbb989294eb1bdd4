"""Files that are parts of another audited one."""

from __future__ import annotations

from pathlib import Path

import mujoco
import pytest

from actspec.audit.engine import audit
from actspec.audit.outcome import Report
from actspec.audit.read import pending_files
from actspec.audit.settings import Settings
from actspec.cli.main import main

MAIN = """<mujoco>
  <worldbody><body><joint name="knee" armature="0.01"/><geom size="0.1"/></body></worldbody>
  <include file="leg_actuators.xml"/>
</mujoco>"""
FRAGMENT = '<mujoco><actuator><motor name="knee" joint="knee"/></actuator></mujoco>'
MODEL = """<mujoco>
  <compiler angle="radian"/>
  <worldbody><body><joint name="knee"/><geom size="0.1"/></body></worldbody>
  <actuator><motor name="knee" joint="knee" ctrlrange="-1 1"/></actuator>
</mujoco>"""


@pytest.fixture(autouse=True)
def _in_tmp_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def audited(*paths: str, rule: str = "LIM101") -> Report:
    """The report on files."""
    with pending_files(paths) as pending:
        return audit(pending, Settings(select=(rule,)))


@pytest.mark.parametrize("paths", [(".",), ("leg_actuators.xml", "./leg.xml")], ids=["folder", "named"])
def test_a_fragment_is_judged_in_its_model(paths: tuple[str, ...]) -> None:
    """An include that is no model alone is neither a file that MuJoCo refuses nor a second robot."""
    Path("leg.xml").write_text(MAIN)
    Path("leg_actuators.xml").write_text(FRAGMENT)
    report = audited(*paths)
    assert [Path(file.path).name for file in report.case.files] == ["leg.xml"]
    assert report.diagnostics() == ()
    (found,) = report.findings
    assert (Path(found.finding.span.path).name, found.finding.joint) == ("leg_actuators.xml", "knee")


NESTED = {
    "scene.xml": '<mujoco><worldbody><include file="parts/arm.xml"/></worldbody>'
    '<actuator><motor joint="wrist"/></actuator></mujoco>',
    "parts/arm.xml": '<mujoco><body>\n<include file="parts/hand.xml"/><geom size="1"/></body></mujoco>',
    "parts/hand.xml": '<mujoco><body><joint name="wrist"/><geom size="1"/></body></mujoco>',
}
"""What a part includes lies where its includer looks, as MuJoCo has it."""


@pytest.mark.parametrize("as_named", [False, True], ids=["folder", "as named"])
@pytest.mark.parametrize(
    ("changed", "told"),
    [
        ({}, []),
        # Nobody includes the part: its own folder is where it looks.
        ({"scene.xml": MODEL}, ["parts/arm.xml:2:1"]),
        # Its includer cannot follow it either.
        ({"parts/hand.xml": None}, ["parts/arm.xml:2:1"]),
        # The includer is no XML: whether it would find the hand, nobody knows.
        ({"scene.xml": NESTED["scene.xml"] + "<"}, ["parts/arm.xml:2:1", "scene.xml:1:115"]),
    ],
    ids=["followed", "alone", "not there", "no includer"],
)
def test_an_include_of_a_part_is_followed_from_its_includer(
    changed: dict[str, str | None], told: list[str], as_named: bool
) -> None:
    """A part that cannot be put together alone is judged in the model that can."""
    Path("parts").mkdir()
    for name, text in (NESTED | changed).items():
        if text is not None:
            Path(name).write_text(text)
    if not changed:
        assert mujoco.MjModel.from_xml_path("scene.xml").njnt == 1
    report = audit(["."], Settings(select=("AUD008",), as_named=as_named))
    assert sorted({str(item.finding.span) for item in report.findings}) == told
    if not changed:
        assert [file.path for file in report.case.files] == ["scene.xml"]


@pytest.mark.parametrize(
    ("changed", "whole"),
    # What MuJoCo refuses is read from its text.
    [
        ({}, True),
        ({"scene.xml": NESTED["scene.xml"].replace("motor", "mtor")}, True),
        ({"parts/hand.xml": ""}, False),
    ],
    ids=["compiles", "refused", "empty"],
)
def test_a_part_that_is_named_alone(
    changed: dict[str, str], whole: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    """The model beside it that can be read in its place is named; where none can, the file is what is wrong."""
    Path("parts").mkdir()
    for name, text in (NESTED | changed).items():
        Path(name).write_text(text)
    assert main(["audit", "parts/arm.xml", "--notes"]) == (0 if whole else 1)
    reason = "the include cannot be followed: there is no folder 'parts' (ROBOT006)"
    note = f"[info] the file can be read only in scene.xml, which includes it: {reason}"
    out = capsys.readouterr().out
    told = note if whole else f"[error] the file cannot be read: {reason}"
    assert f"parts/arm.xml:2:1: AUD008 {told}\n" in out
    assert ("help: audit scene.xml in its place" in out) == whole


def test_what_stays() -> None:
    """A fragment that nobody includes is judged from its text, and a model that another file includes is one."""
    Path("alone.xml").write_text(FRAGMENT)
    Path("model.xml").write_text(MODEL)
    Path("scene.xml").write_text('<mujoco><include file="model.xml"/></mujoco>')
    report = audited("alone.xml", "model.xml", "scene.xml")
    assert [file.path for file in report.case.files] == ["alone.xml", "model.xml", "scene.xml"]
    assert [item.code for item in report.diagnostics()] == ["AUD013"]


def test_a_scene_has_the_step_of_its_model() -> None:
    """A model that a scene runs with its options is judged in the scene, with options of its own too: both are one."""
    robot = """<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body><joint name="knee"/><inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/></body>
  </worldbody>
  <actuator><position joint="knee" kp="1000" kv="100"/></actuator>
</mujoco>"""
    scene = """<mujoco>
  <option integrator="implicitfast"/>
  <include file="leg.xml"/>
</mujoco>"""
    Path("leg.xml").write_text(robot)
    assert [item.severity.value for item in audited("leg.xml", rule="STB101").findings] == ["error"]
    Path("scene.xml").write_text(scene)
    both = ["scene.xml", "leg.xml"]
    alone = Settings(select=("STB101",))
    options = '<option cone="elliptic"/><worldbody>'
    for text in (robot, robot.replace("<worldbody>", options)):
        Path("leg.xml").write_text(text)
        Path("scene.xml").write_text(scene)
        assert [item.severity.value for item in audit(both, alone).findings] == []
        assert [item.severity.value for item in audit(["leg.xml"], alone).findings] == ["error"]
        Path("scene.xml").write_text(scene.replace('<option integrator="implicitfast"/>', ""))
        found = audit(both, alone).findings
        assert [(item.finding.span.path, item.severity.value) for item in found] == [("leg.xml", "error")]


def test_a_broken_model_keeps_its_word() -> None:
    """Where the including file is refused too, that is said once, at the line that MuJoCo refuses."""
    Path("leg.xml").write_text(MAIN.replace('name="knee"', 'name="ankle"'))
    Path("leg_actuators.xml").write_text(FRAGMENT)
    report = audited(".")
    assert [(item.code, str(item.span)) for item in report.diagnostics()] == [
        ("AUD013", "leg_actuators.xml:1")
    ]


def test_a_part_that_compiles_alone_is_judged_in_its_model() -> None:
    """Its compiler and its classes are the includer's: the force range of the class is not missing there."""
    Path("hand.xml").write_text(
        MODEL.replace('  <compiler angle="radian"/>\n', "").replace(' ctrlrange="-1 1"', "")
    )
    Path("scene.xml").write_text(
        '<mujoco><compiler angle="radian"/><default><motor forcerange="-1 1"/></default>'
        '<include file="hand.xml"/></mujoco>'
    )
    assert [item.finding.joint for item in audited("hand.xml").findings] == ["knee"]
    together = audited("hand.xml", "scene.xml")
    assert [file.path for file in together.case.files] == ["scene.xml"]
    assert together.findings == ()


def test_a_part_is_left_to_a_model_that_cannot_be_read() -> None:
    """It is that model's of which something is wrong; the part alone has neither its angle nor its classes."""
    Path("leg.xml").write_text(MAIN.replace("</mujoco>", '<include file="not_here.xml"/></mujoco>'))
    Path("leg_actuators.xml").write_text(FRAGMENT)
    report = audited(".")
    assert [(Path(file.path).name, file.readable) for file in report.case.files] == [("leg.xml", False)]
    Path("leg.xml").unlink()
    assert [Path(file.path).name for file in audited(".").case.files] == ["leg_actuators.xml"]


HINGE = '<body pos="0 0 0.2"><joint name="{0}" range="-1.57 1.57"/><geom size="0.05"/>'
ARM = (
    "<worldbody>"
    + "".join(map(HINGE.format, "abc"))
    + "</body>" * 3
    + "</worldbody><actuator>"
    + "".join(f'<position joint="{n}" kp="5" ctrlrange="-1.57 1.57"/>' for n in "abc")
    + "</actuator>"
)
"""Three hinges in radians, read as degrees: 1.57 degrees are 0.0274 rad."""
FLOOR = '<worldbody><geom type="plane" size="1 1 1"/></worldbody>'


@pytest.mark.parametrize(
    ("files", "severity"),
    [
        ({"arm.xml": ARM}, "info"),
        ({"arm.xml": FLOOR + ARM}, "warning"),
        ({"arm.xml": "<option timestep='0.001'/>" + ARM}, "warning"),
        ({"arm.xml": '<worldbody><light pos="0 0 2"/></worldbody>' + ARM}, "info"),
        ({"arm.xml": ARM + '<keyframe><key name="home"/></keyframe>'}, "warning"),
        ({"arm.xml": "<!-- <option/> -->" + ARM}, "info"),
        ({"arm.xml": ARM, "scene.xml": '<include file="arm.xml"/>'}, "warning"),
        ({"arm.xml": ARM, "scene.xml": FLOOR + '<include file="arm.xml"/>'}, "warning"),
        ({"arm.xml": ARM, "scene.xml": '<compiler angle="radian"/><include file="arm.xml"/>'}, None),
        ({"arm.xml": FLOOR + ARM, "scene.xml": '<compiler angle="radian"/><include file="arm.xml"/>'}, None),
    ],
    ids=[
        "alone",
        "floor",
        "option",
        "light",
        "keyframe",
        "in a comment",
        "included",
        "in a scene",
        "angle",
        "floor, and angle",
    ],
)
def test_a_robot_without_a_compiler_is_judged_as_whole(files: dict[str, str], severity: str | None) -> None:
    """Where it has drives and what no part has, or what includes it has no angle either.

    Alone it may be one that a program puts into a world that has the angle, as robosuite does with its robots, and
    dm_control with its walkers, which bring a light.
    """
    for name, text in files.items():
        Path(name).write_text(f"<mujoco>{text}</mujoco>")
    report = audited(*files, rule="UNT101")
    assert [file.path for file in report.case.files] == list(files)[-1:]
    found = [item for item in report.findings if item.finding.joint == ""]
    assert [item.severity.value for item in found] == ([severity] if severity else [])
    # To a whole one a program may add it.
    assert [item.confidence.value for item in found] == [
        {"info": "low"}.get(item.severity.value, "medium") for item in found
    ]


@pytest.mark.parametrize(("world", "severity"), [("", "info"), (FLOOR, "warning")], ids=["alone", "floor"])
def test_control_ranges_tell_of_two_hinges_too(world: str, severity: str) -> None:
    """Two are too few to be told by their ranges alone: the servos' are 57.3 times as wide."""
    arm = ARM.replace(HINGE.format("c"), "").replace("</body>" * 3, "</body>" * 2)
    arm = arm.replace('<position joint="c" kp="5" ctrlrange="-1.57 1.57"/>', "")
    Path("arm.xml").write_text(f"<mujoco>{world}{arm}</mujoco>")
    found = audited("arm.xml", rule="UNT101").findings
    assert [(item.finding.joint, item.severity.value) for item in found] == [("a", severity), ("b", severity)]
    unless = ", unless what includes or loads it has the angle"
    assert all(item.finding.message.endswith(unless) == (severity == "info") for item in found)


def test_the_step_of_a_whole_robot_is_its_own() -> None:
    """kd of 100 at 0.01 kg*m^2 with 2 ms: h kd/I = 20, beyond 2; of a part it is its includer's."""
    arm = MODEL.replace('  <compiler angle="radian"/>\n', "").replace(
        '<motor name="knee" joint="knee" ctrlrange="-1 1"/>', '<position joint="knee" kp="1" kv="100"/>'
    )
    Path("arm.xml").write_text(
        arm.replace("<joint", '<inertial pos="0 0 0" mass="1" diaginertia=".01 .01 .01"/><joint')
    )
    assert [item.severity.value for item in audited("arm.xml", rule="STB101").findings] == ["info"]
    Path("arm.xml").write_text(Path("arm.xml").read_text().replace("<worldbody>", FLOOR + "<worldbody>"))
    assert [item.severity.value for item in audited("arm.xml", rule="STB101").findings] == ["error"]


@pytest.mark.parametrize("named", [["."], ["scene.xml"], ["scene.xml", "other.xml", "hands.xml"]])
def test_what_several_scenes_attach(
    named: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A figure of an attached model is found once, where it is written: the left finger has 10 N*m, the right one 7."""
    monkeypatch.chdir(tmp_path)
    fingers = "".join(
        f'\n<body><joint name="{side}_finger" actuatorfrcrange="-{n} {n}"/><geom size=".1"/></body>'
        for side, n in (("left", 10), ("right", 7), ("left_inner", 7), ("right_inner", 7))
    )
    drives = "".join(
        f'<position joint="{side}_finger" kp="9"/>' for side in ("left", "right", "left_inner", "right_inner")
    )
    Path("hands.xml").write_text(
        f'<mujoco model="hands"><worldbody>{fingers}</worldbody><actuator>{drives}</actuator></mujoco>'
    )
    for name in ("scene", "other"):
        Path(f"{name}.xml").write_text(
            '<mujoco><asset><model name="hands" file="hands.xml"/></asset><worldbody>'
            '<attach model="hands" prefix=""/></worldbody></mujoco>'
        )
    found = audit(named, Settings(select=("SYM101",))).findings
    assert [(item.finding.span.path, item.finding.span.line, item.finding.joint) for item in found] == [
        ("hands.xml", 2, "left_finger")
    ]


@pytest.mark.parametrize("angle", ["", '<compiler angle="radian"/>'], ids=["none", "radians"])
@pytest.mark.parametrize("outer", [False, True], ids=["main", "included"])
def test_an_attached_model_has_its_own_angle(angle: str, outer: bool) -> None:
    """In MuJoCo, 0.8 without a compiler are degrees, whatever the model has that attaches it: 0.01396 rad."""
    import mujoco

    Path("grip.xml").write_text(
        '<mujoco model="grip"><worldbody><body name="palm"><geom size=".1"/><body>\n'
        '<joint name="finger" range="0 0.8"/><geom size=".1"/></body></body></worldbody>'
        '<actuator><position joint="finger" kp="5" ctrlrange="0 0.8"/></actuator></mujoco>'
    )
    Path("main.xml").write_text(
        f'<mujoco>{"" if outer else angle}<asset><model name="g" file="grip.xml"/></asset><worldbody><body>'
        '<joint name="arm"/><geom size=".1"/><frame><attach model="g" body="palm" prefix="left_"/></frame></body>'
        '</worldbody><actuator><motor joint="arm"/></actuator></mujoco>'
    )
    Path("outer.xml").write_text(f'<mujoco>{angle}<include file="main.xml"/></mujoco>')
    name = "outer.xml" if outer else "main.xml"
    model = mujoco.MjModel.from_xml_path(name)
    assert model.joint("left_finger").range[1] == pytest.approx(0.8 * 3.14159265 / 180.0)
    (found,) = audited(name, rule="UNT101").findings
    assert (found.finding.span.path, found.finding.span.line) == ("grip.xml", 2)
    assert (found.finding.joint, found.severity.value) == ("left_finger", "warning")
    assert "unless" not in found.finding.message
