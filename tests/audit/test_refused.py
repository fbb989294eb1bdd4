"""A model that MuJoCo refuses is a finding where somebody named it: a check that is green says that it compiles."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.rules import all_rules
from actspec.audit.settings import Settings, load_settings
from actspec.cli.main import main
from actspec.diagnostics import AuditError

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
