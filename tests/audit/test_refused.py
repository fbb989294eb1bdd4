"""A model that MuJoCo refuses is a finding where somebody named it: a check that is green says that it compiles."""

from __future__ import annotations

from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.rules import all_rules
from actspec.audit.settings import Settings, load_settings
from actspec.cli.main import main
from actspec.diagnostics import AuditError
from actspec.readings.versions import Versions

MODEL = """<mujoco>
  <compiler angle="radian"/>
  <worldbody>
    <body><joint name="knee"/><geom size="0.1"/></body>
  </worldbody>
  <actuator>
    <motor joint="nkee" ctrllimited="true" ctrlrange="-20 20"/>
  </actuator>
</mujoco>
"""
URDF = """<robot name="leg"><link name="a"/><link name="b"><inertial><mass value="0"/>
<inertia ixx="0" iyy="0" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="knee" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="20" velocity="10"/></joint></robot>
"""


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("robots").mkdir()
    Path("robots/leg.xml").write_text(MODEL)


def run(*arguments: str) -> int:
    """The exit code."""
    return main(["audit", *arguments])


@pytest.mark.parametrize(
    "arguments, code",
    [
        (["robots/leg.xml"], 0),
        (["robots/leg.xml", "--fail-on", "warning"], 1),
        (["robots", "--as-named", "--fail-on", "warning"], 1),
        (["robots", "--as-named", "--fail-on", "warning", "--select", "LIM101"], 1),
        (["robots", "--as-named", "--fail-on", "warning", "--ignore", "AUD020"], 0),
        (["robots", "--fail-on", "info"], 0),
    ],
)
def test_it_counts_where_it_was_named(arguments: list[str], code: int) -> None:
    """As a warning; in a folder of somebody else it is said and counts for nothing."""
    assert run(*arguments) == code


def test_it_is_told_once() -> None:
    """As a finding or as a warning about the file, never as both."""
    named = audit(["robots"], Settings(as_named=True))
    assert [(item.finding.code, str(item.finding.span)) for item in named.findings] == [
        ("AUD020", "robots/leg.xml:7")
    ]
    assert named.diagnostics() == ()
    met = audit(["robots"], Settings())
    assert met.findings == ()
    assert [item.code for item in met.diagnostics()] == ["AUD013"]


def test_settings_and_baseline() -> None:
    """Its severity can be set, and a baseline holds it; a remark about a file has none to set."""
    Path("actspec.toml").write_text('[audit.severity]\nAUD020 = "error"\n')
    assert run("robots/leg.xml") == 1
    assert run("robots/leg.xml", "--write-baseline", "known.json") == 0
    assert run("robots/leg.xml", "--baseline", "known.json") == 0
    Path("actspec.toml").write_text('[audit.severity]\nAUD013 = "error"\n')
    with pytest.raises(AuditError) as caught:
        load_settings(all_rules())
    (told,) = caught.value.diagnostics
    assert (told.code, told.span and told.span.line) == ("AUD004", 2)
    assert told.help == "a model that you name and MuJoCo refuses is AUD020"


def test_what_is_no_model_of_its_own() -> None:
    """A URDF is for other programs too, and a part has its joints in the file that includes it."""
    Path("leg.urdf").write_text(URDF)
    Path("part.xml").write_text(MODEL.replace('  <compiler angle="radian"/>\n', ""))
    report = audit(["leg.urdf", "part.xml"], Settings())
    assert "AUD020" not in {item.finding.code for item in report.findings}
    assert {item.code: item.severity.value for item in report.diagnostics() if item.code == "AUD013"} == {
        "AUD013": "info"
    }
    Path("part.xml").write_text('<mujoco><actuator><motor joint="knee" gaer="2"/></actuator></mujoco>')
    (found,) = audit(["part.xml"], Settings()).findings
    assert (found.finding.code, found.severity.value) == ("AUD020", "warning")


def test_a_part_with_a_compiler_is_judged_in_what_includes_it() -> None:
    """Where the scene compiles nothing is wrong; where it does not, that is told once, at the place in the part."""
    Path("scene.xml").write_text(
        '<mujoco><include file="robots/leg.xml"/><worldbody><body pos="1 0 0"><joint name="nkee"/>'
        '<geom size="0.1"/></body></worldbody></mujoco>'
    )
    report = audit(["robots/leg.xml", "scene.xml"], Settings())
    assert "AUD020" not in {item.finding.code for item in report.findings}
    Path("scene.xml").write_text('<mujoco><include file="robots/leg.xml"/></mujoco>')
    report = audit(["robots/leg.xml", "scene.xml"], Settings())
    assert [str(item.finding.span) for item in report.findings if item.finding.code == "AUD020"] == [
        "robots/leg.xml:7"
    ]
    assert report.for_people() == ()


PART = """<mujoco><compiler angle="radian"/>
<worldbody><body><joint name="knee"/><geom name="foot" size="0.1"/></body></worldbody>
<contact><pair geom1="foot" geom2="floor"/></contact></mujoco>
"""
SCENE = '<mujoco><include file="{}"/><worldbody><geom name="floor" type="plane" size="1 1 1"/></worldbody></mujoco>'


@pytest.mark.parametrize(
    ("scene", "named"),
    [
        ("robots/scene.xml", "leg.xml"),
        ("robots/scenes/scene.xml", "../leg.xml"),
        ("robots/scenes/flat/scene.xml", "../../leg.xml"),
        ("scenes/scene.xml", "../robots/leg.xml"),
        ("scenes/flat/scene.xml", "../../robots/leg.xml"),
    ],
)
def test_a_model_that_compiles_in_its_scene_alone(
    scene: str, named: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is information, and a lock says nothing of it; where the scene does not compile either, the warning stays."""
    Path("robots/leg.xml").write_text(PART)
    Path(scene).parent.mkdir(parents=True, exist_ok=True)
    Path(scene).write_text(SCENE.format(named))
    report = audit(["robots/leg.xml"], Settings())
    (found,) = [item for item in report.findings if item.finding.code == "AUD020"]
    assert (found.severity.value, str(found.finding.span)) == ("info", "robots/leg.xml:3")
    assert found.finding.message == (
        f"the model compiles only in {scene}, which includes it, and is judged from its text alone: MuJoCo refuses the "
        "model: geom 'floor' not found in collision 0"
    )
    assert found.finding.help == f"audit {scene} in its place"
    assert report.for_people() == ()
    assert main(["lock", "robots/leg.xml", "-o", "lock.json"]) == 0
    assert "LCK004" not in capsys.readouterr().err
    Path("robots/leg.xml").write_text(PART.replace('"foot" geom2', '"fot" geom2'))
    (found,) = [i for i in audit(["robots/leg.xml"], Settings()).findings if i.finding.code == "AUD020"]
    assert found.severity.value == "warning"


def test_of_several_scenes_the_first_that_compiles() -> None:
    """By its path, whichever is read first."""
    Path("robots/leg.xml").write_text(PART)
    Path("robots/a.xml").write_text('<mujoco><include file="leg.xml"/></mujoco>')
    for name in ("c", "b"):
        Path(f"robots/{name}.xml").write_text(SCENE.format("leg.xml"))
    (found,) = [i for i in audit(["robots/leg.xml"], Settings()).findings if i.finding.code == "AUD020"]
    assert found.finding.help == "audit robots/b.xml in its place"


INSTALLED = version("mujoco")


@pytest.fixture
def _old_model() -> None:
    """`sensornoise` went with MuJoCo 3.1.4 (its changelog)."""
    Path(".git").mkdir()
    Path("robots/leg.xml").write_text(
        '<mujoco><compiler angle="radian"/><option><flag sensornoise="enable"/></option><worldbody/></mujoco>'
    )


def refused(settings: Settings) -> tuple[str, str]:
    """Severity and message of the one finding."""
    (found,) = audit(["robots"], replace(settings, as_named=True)).findings
    assert (found.finding.code, found.finding.span.line) == ("AUD020", 1)
    return found.severity.value, found.finding.message


@pytest.mark.usefixtures("_old_model")
def test_a_project_that_asks_for_an_older_mujoco() -> None:
    """A note that names both; a check of the repository stays green."""
    reason = (
        "and is judged from its text alone: MuJoCo refuses the model: Schema violation: unrecognized attribute: "
        "'sensornoise'"
    )
    told = ("warning", f"the model does not compile in the installed MuJoCo, {reason}")
    assert refused(Settings()) == told
    Path("requirements.txt").write_text("numpy\nmujoco==2.3.6\n")
    assert refused(Settings()) == (
        "info",
        f"the model does not compile in the installed MuJoCo {INSTALLED} (requirements.txt:2 asks for mujoco==2.3.6, "
        f"which may take it), {reason}",
    )
    assert run("robots", "--as-named", "--fail-on", "warning") == 0
    Path("requirements.txt").write_text(f"mujoco=={INSTALLED}\n")
    assert refused(Settings()) == told
    Path("requirements.txt").unlink()
    Path("robots/view.py").write_text("import mujoco_py\n")
    assert refused(Settings()) == (
        "info",
        f"the model does not compile in the installed MuJoCo {INSTALLED} (robots/view.py:1 imports mujoco_py, whose "
        f"MuJoCo, 2.1 or older, may take it), {reason}",
    )


@pytest.mark.usefixtures("_old_model")
@pytest.mark.parametrize(
    ("attribute", "level"),
    # What is no slip of any attribute may be another release's.
    [("ctrlimited", "warning"), ("forcerang", "warning"), ("actuatorspeed", "info")],
)
def test_a_slip_that_no_release_takes(attribute: str, level: str) -> None:
    """An older MuJoCo is no excuse for `ctrlimited`."""
    Path("requirements.txt").write_text("mujoco==2.3.7\n")
    Path("robots/leg.xml").write_text(
        '<mujoco><worldbody><body><joint name="j"/><geom size="0.1"/></body></worldbody>'
        '<actuator><motor joint="j" ATTRIBUTE="true"/></actuator></mujoco>'.replace("ATTRIBUTE", attribute)
    )
    assert refused(Settings(select=("AUD020",)))[0] == level


@pytest.mark.usefixtures("_old_model")
@pytest.mark.parametrize(
    ("body", "level"),
    [
        # MuJoCo 2.2.0 reads all but the last, measured with its library.
        ('<body pos="0,0,0"><joint name="j"/><geom size="0.1"/></body>', "info"),
        ('<body quat="1 0 0 0" euler="0 0 1"><joint name="j"/><geom size="0.1"/></body>', "info"),
        ('<body quat="0 0 0 0"><joint name="j"/><geom size="0.1"/></body>', "info"),
        ('<body><joint name="j" class="leg"/><geom size="0.1"/></body>', "warning"),
    ],
)
def test_what_an_older_release_reads(body: str, level: str) -> None:
    """Beside a class that is not there, which no release takes."""
    Path("requirements.txt").write_text("mujoco_py\n")
    Path("robots/leg.xml").write_text(
        f"<mujoco><compiler angle='radian'/><worldbody>{body}</worldbody>"
        "<actuator><motor joint='j' ctrlrange='-20 20'/></actuator></mujoco>"
    )
    assert refused(Settings(select=("AUD020",)))[0] == level


@pytest.mark.usefixtures("_old_model")
def test_a_default_at_the_top() -> None:
    """A second one of another name than main: MuJoCo 3.1.6 takes it, measured with its library."""
    Path("requirements.txt").write_text("mujoco==3.1.6\n")
    Path("robots/leg.xml").write_text(
        "<mujoco><compiler angle='radian'/><default class='leg'/><default class='arm'/><worldbody><body>"
        "<joint name='j'/><geom size='0.1'/></body></worldbody></mujoco>"
    )
    level, message = refused(Settings(select=("AUD020",)))
    assert (level, "top-level default class 'main' cannot be renamed" in message) == ("info", True)


@pytest.mark.usefixtures("_old_model")
@pytest.mark.parametrize(
    ("plugin", "level"), [("mujoco.elasticity.cable", "info"), ("mujoco.elastic.cable", "warning")]
)
def test_a_plugin_that_an_older_release_has(plugin: str, level: str) -> None:
    """MuJoCo 4.0 comes without the plugins of elasticity; what no release has is a slip."""
    Path("requirements.txt").write_text("mujoco==3.2.0\n")
    Path("robots/leg.xml").write_text(
        f'<mujoco><compiler angle="radian"/><extension><plugin plugin="{plugin}"/></extension>'
        '<worldbody><body><joint name="j"/><geom size="0.1"/></body></worldbody>'
        '<actuator><motor joint="j" ctrlrange="-20 20"/></actuator></mujoco>'
    )
    told, message = refused(Settings(select=("AUD020",)))
    assert (told, f"plugin {plugin} not found" in message) == (level, True)


@pytest.mark.usefixtures("_old_model")
def test_a_plugin_of_the_project_s_own() -> None:
    """Its program loads the library, which nobody has here."""
    Path("robots/leg.xml").write_text(
        '<mujoco><compiler angle="radian"/><extension><plugin plugin="my.company.servo"/></extension>'
        '<worldbody><body><joint name="j"/><geom size="0.1"/></body></worldbody></mujoco>'
    )
    level, message = refused(Settings(select=("AUD020",)))
    assert (level, message.startswith("the model compiles only with the library of its plugin,")) == (
        "info",
        True,
    )


@pytest.mark.usefixtures("_old_model")
@pytest.mark.parametrize(
    ("flex", "level"),
    [
        # A stand-in has 4 vertices, and a cloth that is pinned at its vertex 30 has more.
        ('<flexcomp name="f" type="mesh" file="cloth.obj" dim="2"><pin id="30"/></flexcomp>', "info"),
        ('<flexcomp name="f" type="mesh" file="cloth.obj" dim="2"><pin range="20 35"/></flexcomp>', "info"),
        ('<flexcomp name="f" type="gmsh" file="cloth.msh" dim="3"/>', "info"),
        # One without a file has the vertices that it says: 3 * 3 * 1.
        (
            '<flexcomp name="f" type="grid" count="3 3 1" spacing="1 1 1" dim="2"><pin id="30"/></flexcomp>',
            "warning",
        ),
        ('<flexcomp name="f" type="mesh" file="cloth.obj" dim="2"/><geom class="leg"/>', "warning"),
    ],
)
def test_a_flexcomp_with_a_file(flex: str, level: str) -> None:
    """The file is not read, so that nobody knows its vertices."""
    Path("robots/leg.xml").write_text(
        '<mujoco><compiler angle="radian"/><worldbody><body><joint name="j"/><geom size="0.1"/></body>'
        f'<body name="c">{flex}</body></worldbody></mujoco>'
    )
    told, message = refused(Settings(select=("AUD020",)))
    only = message.startswith("the model compiles only with the file of its flexcomp, which is not read")
    assert (told, only) == (level, level == "info")


@pytest.mark.usefixtures("_old_model")
def test_the_version_that_was_said_goes_before() -> None:
    """`-t mujoco==2.3.7` is as good as a pin, and one for the installed release sets a pin aside."""
    level, message = refused(Settings(versions=Versions(mujoco="2.3.7")))
    assert level == "info"
    assert message.startswith(
        f"the model does not compile in the installed MuJoCo {INSTALLED} (it is meant for MuJoCo 2.3.7, which may take"
    )
    Path("requirements.txt").write_text("mujoco==2.3.6\n")
    assert refused(Settings(versions=Versions(mujoco=INSTALLED)))[0] == "warning"
    assert refused(Settings(versions=Versions(mujoco=INSTALLED.split(".")[0] + ".99")))[0] == "warning"


def test_what_is_whole_by_itself_is_not_at_fault() -> None:
    """A scene with a model among its bodies is refused in that model, which compiles; its own fault stays its own."""
    whole = MODEL.replace("nkee", "knee")
    Path("robots/leg.xml").write_text(whole)
    Path("robots/scene.xml").write_text(
        '<mujoco>\n<worldbody>\n  <include file="leg.xml"/>\n</worldbody>\n</mujoco>\n'
    )

    def told() -> list[tuple[str, list[str]]]:
        found = audit(["robots"], Settings(as_named=True, select=("AUD020",))).findings
        return [(str(one.finding.span), list(map(str, one.finding.related))) for one in found]

    assert told() == [("robots/scene.xml:3:3", ["robots/leg.xml:2"])]
    Path("robots/leg.xml").write_text(whole.replace("<compiler", '<compiler angel="radian"'))
    assert all(place.startswith("robots/leg.xml:2") and not related for place, related in told())
    assert told()
