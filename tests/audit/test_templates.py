"""Robot files that are not read in a folder, and counted: templates and empty files."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.read import read_file
from actspec.audit.settings import Settings
from actspec.cli.main import main


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("d").mkdir()


LEG = """<mujoco model="leg"><compiler angle="radian"/>
<worldbody><body pos="0 0 1">
<joint name="knee" damping="1" armature="0.01"/><geom size="0.1" fromto="0 0 0 0 0 1" type="capsule"/>
</body></worldbody>
<actuator><motor joint="knee" ctrllimited="true" ctrlrange="-20 20"/></actuator></mujoco>
"""
JOINT = """<robot name="r"><link name="a"/><link name="b"/>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/>
<limit lower="-1" upper="1" effort="9" velocity="5"/></joint></robot>
"""


@pytest.mark.parametrize(
    ("name", "text", "what", "line"),
    [
        ("a.xml", LEG.replace('"0 0 0 0 0 1"', '"0 0 0 {l1} 0 0"'), 'fromto="0 0 0 {l1} 0 0"', 3),
        ("a.xml", LEG.replace('"0 0 1"', '"__INIT_POS__"'), 'pos="__INIT_POS__"', 2),
        ("a.xml", LEG.replace('"1"', '"@DAMPING@"'), 'damping="@DAMPING@"', 3),
        ("a.xml", LEG.replace('"true"', '"%(limited)s"'), "'%(limited)s'", 5),
        (
            "a.xml",
            LEG.replace("<worldbody>", '<include file="{{ robot }}.xml"/><worldbody>'),
            "'{{ robot }}.xml'",
            2,
        ),
        ("a.xml", LEG.replace('"1"', '"{{ mp["d"] }}"'), "'{{ mp[\"d\"] }}'", 3),
        ("a.xml", LEG.replace("</body>", "{% if a < b %}</body>"), "'{% if a < b %}'", 4),
        ("a.xml", LEG.replace('"1"', '"$DAMPING"'), 'damping="$DAMPING"', 3),
        ("a.xml", LEG.replace('"1"', '"${DAMPING}"'), 'damping="${DAMPING}"', 3),
        ("a.xml", LEG.replace('"1"', '"$(arg damping)"'), 'damping="$(arg damping)"', 3),
        ("a.xml", LEG.replace('"1"', '"%s"'), 'damping="%s"', 3),
        # EmPy
        ("a.em.xml", LEG.replace('"0 0 1"', '"@x @y 1"'), 'pos="@x @y 1"', 2),
        ("a.em.xml", LEG.replace('"1"', '"@(2 * d)"'), 'damping="@(2 * d)"', 3),
        ("a.xml", LEG.replace("</body>", "@[for i in range(9)]@\n</body> <"), "'@[for i in range(9)]@'", 4),
        ("a.xml", "<!-- leg -->\n@{\nd = 1\n}@\n" + LEG, "'@{'", 2),
        ("a.xml", LEG.replace('"1"', '"#DAMPING#"'), 'damping="#DAMPING#"', 3),
        ("a.xml", LEG.replace('"1"', '"&lt;DAMPING&gt;"'), 'damping="<DAMPING>"', 3),
        ("a.urdf", JOINT.replace('"9"', '"$EFFORT"'), "'$EFFORT'", 3),
        ("a.urdf", JOINT.replace('"9"', '"{effort}"'), "'{effort}'", 3),
        ("a.xml", LEG.replace('"1"', '"%DAMPING%"'), 'damping="%DAMPING%"', 3),
        ("a.urdf", JOINT.replace("revolute", "{kind}"), "'{kind}'", 2),
        ("a.urdf", JOINT.replace("revolute", "/* joint_type */"), "'/* joint_type */'", 2),
    ],
)
def test_a_template_is_to_be_filled_in_first(
    name: str, text: str, what: str, line: int, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is told once, as what it is, where it is named, and counted in a folder, one's own too."""
    Path("d", name).write_text(text)
    Path("d/good.xml").write_text(LEG)
    assert main(["audit", f"d/{name}"]) == 2
    (told,) = read_file(f"d/{name}").diagnostics
    assert (told.code, told.span and told.span.line) == ("AUD014", line)
    assert told.message == f"nothing to audit: this is a template, which has to be filled in first: {what}"
    capsys.readouterr()
    for option in ([], ["--as-named"]):
        main(["audit", "d", *option])
        out, err = capsys.readouterr()
        assert out.splitlines()[-1].startswith("no findings in 1 file; 1 template file not read")
        assert "a.xml" not in out + err


@pytest.mark.parametrize(
    ("name", "text", "code"),
    [
        # A placeholder that MuJoCo takes, beside what it refuses; the refused value is none.
        ("a.xml", LEG.replace('model="leg"', 'model="{leg}"').replace('"1"', '"1,5"'), "AUD020"),
        ("a.xml", LEG.replace('"1"', '"l_{1"'), "AUD020"),
        ("a.xml", LEG.replace('"1"', '"1 %"'), "AUD020"),
        ("a.xml", LEG.replace('"1"', '"$1"'), "AUD020"),
        ("a.xml", LEG.replace('"1"', '"#1"'), "AUD020"),
        ("a.xml", LEG.replace('"leg"', '"$LEG"').replace('"1"', '"1,5"'), "AUD020"),
        ("a.xml", LEG.replace("</body>", "</body></body>").replace("leg", "{leg}"), "AUD008"),
        ("a.xml", LEG.replace("</body>", "<!-- {% if a %} --></body></body>"), "AUD008"),
        ("a.xml", LEG.replace("<worldbody>", '<include file="ur5__leg__2.xml"/><worldbody>'), "AUD008"),
        ("a.urdf", JOINT.replace('"9"', '"3O0"').replace('"r"', '"{r}"'), "AUD008"),
        ("a.urdf", JOINT.replace("revolute", "/* a hinge, I think */"), "AUD008"),
    ],
)
def test_what_is_no_template(name: str, text: str, code: str) -> None:
    """A placeholder elsewhere in the file, or in a comment, takes nothing away of a fault."""
    Path("d", name).write_text(text)
    report = audit(["d"], Settings(as_named=True))
    assert [item.finding.code for item in report.findings] == [code]


def test_a_page_that_is_a_template_is_no_robot(capsys: pytest.CaptureFixture[str]) -> None:
    """It is passed over in a folder, as other XML is."""
    Path("d/view.xml").write_text("<view>{% for a in b %}<a{{ a }}>{% endfor %}</view>")
    Path("d/good.xml").write_text(LEG)
    main(["audit", "d"])
    assert "not read" not in capsys.readouterr().out


def test_an_empty_file(capsys: pytest.CaptureFixture[str]) -> None:
    """It is counted in a folder, by an ending that only robots have, and an error where it is named."""
    Path("d/leg.urdf").touch()
    Path("d/arm.mjcf").write_text(" \n\t\n")
    Path("d/other.xml").touch()
    Path("d/good.xml").write_text(LEG)
    for option in ([], ["--as-named"]):
        assert main(["audit", "d", *option]) == 0
        out, err = capsys.readouterr()
        assert out.splitlines()[-1].startswith("no findings in 1 file; 2 empty files not read")
        assert "AUD008" not in out + err
    assert main(["audit", "d/leg.urdf"]) == 1
    assert "d/leg.urdf:1:1: AUD008 [error]" in capsys.readouterr().out
    # A comment alone is a file that somebody wrote something in.
    Path("d/leg.urdf").write_text("<!-- to do -->")
    report = audit(["d"], Settings(as_named=True))
    assert [item.finding.code for item in report.findings] == ["AUD008"]
