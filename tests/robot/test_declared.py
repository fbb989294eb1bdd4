"""A file that declares another encoding than UTF-8 is read where all readers read it alike, and its bytes stay."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.settings import Settings
from actspec.cli.main import main
from actspec.readings.read import read_file
from actspec.robot.xml import open_document

HEAD = '<?xml version="1.0" encoding="{}"?>\n<!-- Gr\xf6\xdfe \xa9 \xe9\xe9 -->'
MODEL = """<mujoco model="leg"><compiler angle="radian"/><!-- \xb0 --><worldbody><body>
<joint name="knee" range="-90 10" armature="0.01"/><geom size="0.1"/></body></worldbody>
<actuator><position name="knee" joint="knee" kp="40" kv="1" ctrlrange="-90 10" forcerange="-20 20"/></actuator></mujoco>
"""
URDF = """<robot name="leg"><link name="a"/><link name="b"/><!-- \xe9 --><joint name="knee" type="revolute">
<parent link="a"/><child link="b"/><limit lower="-1" upper="1" effort="20" velocity="-10"/></joint></robot>
"""


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("encoding", ["ISO-8859-1", "windows-1252", "iso-8859-15"])
def test_a_model_is_read(encoding: str) -> None:
    """By MuJoCo itself; places count characters."""
    Path("leg.xml").write_bytes((HEAD.format(encoding) + MODEL).encode("latin-1"))
    document = open_document("leg.xml")
    # `<!-- Groesse (c) ee -->` with 5 + 5 + 1 + 1 + 1 + 2 + 4 = 19 characters.
    assert (document.span(document.root).line, document.span(document.root).column) == (2, 20)
    (artifact,) = read_file("leg.xml").artifacts
    assert artifact.text_only is None and artifact.robot is not None
    assert [(joint.name, joint.range) for joint in artifact.robot.joints] == [("knee", (-90.0, 10.0))]


def test_beside_a_file_of_utf8() -> None:
    """An include has an encoding of its own; a name of the main file keeps its letters."""
    Path("part.xml").write_bytes(
        '<?xml version="1.0" encoding="ISO-8859-1"?><mujoco><!-- \xe9 --><option timestep="0.004"/></mujoco>'.encode(
            "latin-1"
        )
    )
    Path("leg.xml").write_text(
        MODEL.replace('"knee" range', '"kn\xe9" range')
        .replace('joint="knee"', 'joint="kn\xe9"')
        .replace("<worldbody>", '<include file="part.xml"/><worldbody>'),
        encoding="utf-8",
    )
    (artifact,) = read_file("leg.xml").artifacts
    assert artifact.robot is not None and artifact.robot.timestep == 0.004
    assert [joint.name for joint in artifact.robot.joints] == ["kn\xe9"]


def test_a_urdf_is_read() -> None:
    """And judged, at its place."""
    Path("leg.urdf").write_bytes((HEAD.format("ISO-8859-1") + URDF).encode("latin-1"))
    report = audit(["leg.urdf"], Settings(select=("LIM104",)))
    assert [str(item.finding.span) for item in report.findings] == ["leg.urdf:3:36"]


def test_a_fix_leaves_all_other_bytes() -> None:
    """The range in degrees becomes one in radians; each byte beside it, and the declaration, is as it was."""
    # MJCF has joint ranges in degrees where it does not say otherwise, and ranges of controls in radians always.
    model = MODEL.replace('<compiler angle="radian"/>', "")
    old = (HEAD.format("windows-1252") + model).encode("latin-1")
    Path("leg.xml").write_bytes(old)
    assert main(["audit", "leg.xml", "--unsafe-fixes"]) in (0, 1)
    new = Path("leg.xml").read_bytes()
    begin, end = b'ctrlrange="', b'" forcerange'
    assert (
        new != old and new.split(begin)[0] == old.split(begin)[0] and new.split(end)[1] == old.split(end)[1]
    )


def test_a_compiled_model_leaves_them_too() -> None:
    """What compile does not write is in the file as it was."""
    text = HEAD.format("ISO-8859-1") + MODEL.replace("-90 10", "-1 1")
    Path("leg.xml").write_bytes(text.encode("latin-1"))
    Path("leg.yaml").write_text(
        "actspec: 1\nrobot: {name: leg, model: leg.xml}\nactuators:\n"
        "  all: {joints: [knee], level: ideal_pd, kp: 30 N*m/rad, kd: 2 N*m*s/rad, effort_limit: 12 N*m}\n"
        "targets:\n  mujoco: {version: '3.8'}\n"
    )
    assert main(["compile", "leg.yaml", "-o", "out"]) == 0
    (written,) = Path("out").rglob("*.xml")
    assert "<!-- Gr\xf6\xdfe \xa9 \xe9\xe9 -->".encode("latin-1") in written.read_bytes()
    assert b'encoding="ISO-8859-1"' in written.read_bytes()
    assert main(["audit", str(written), "--fail-on", "error"]) == 0
