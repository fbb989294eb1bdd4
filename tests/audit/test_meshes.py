"""What depends on meshes that are not there is unknown to every rule."""

from __future__ import annotations

import struct
from itertools import product
from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.read import pending_files
from actspec.audit.settings import Settings
from actspec.readings.artifact import FileKind

MODEL = """<mujoco model="arm">
  <compiler angle="radian"/>
  <option integrator="Euler" timestep="0.01"/>
  <asset><mesh name="shell" file="shell.stl"/></asset>
  <worldbody>
    <body>
      <joint name="shoulder" axis="0 1 0" range="-2 2" damping="3"/>
      %s
      <body pos="0 0 -0.3">
        <joint name="elbow" axis="0 1 0" range="-2 2"/>
        <geom size="0.05" mass="0.1" pos="0 0 -0.2"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position joint="shoulder" kp="4000" kv="60" ctrlrange="-2 2"/>
    <position joint="elbow" kp="4000" dampratio="1" ctrlrange="-2 2"/>
  </actuator>
</mujoco>
"""
GEOMS = {
    "mesh": '<geom type="mesh" mesh="shell"/>',
    "fitted": '<geom type="box" mesh="shell"/>',
    "mass given": '<geom type="mesh" mesh="shell" mass="0.5"/>',
}
BY_INERTIA = {"STB101", "VER101", "GEA104", "DMP101"}
"""Rules whose messages have a number that comes from the inertia here."""


def cube(path: Path) -> None:
    """A binary STL of a cube with edges of 0.1 m."""
    corners = [struct.pack("<3f", *corner) for corner in product((-0.05, 0.05), repeat=3)]
    quads = ("0132", "4675", "0451", "2376", "0264", "1573")
    faces = [face for a, b, c, d in quads for face in ((a, b, c), (a, c, d))]
    body = b"".join(bytes(12) + b"".join(corners[int(i)] for i in face) + bytes(2) for face in faces)
    path.write_bytes(bytes(80) + struct.pack("<I", len(faces)) + body)


def messages() -> set[tuple[str, str, str]]:
    """Code, joint and message of every finding on `arm.xml`."""
    with pending_files(["arm.xml"]) as pending:
        report = audit(pending, Settings())
    (artifact,) = report.case.artifacts
    assert artifact.kind is FileKind.MJCF
    assert artifact.text_only is None
    return {(item.finding.code, item.finding.joint, item.finding.message) for item in report.findings}


@pytest.mark.parametrize("geom", GEOMS.values(), ids=list(GEOMS))
def test_no_number_comes_from_what_is_left(
    geom: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without the mesh no rule gives a stiffness, a frequency or a damping that the rest of the masses would have."""
    monkeypatch.chdir(tmp_path)
    Path("arm.xml").write_text(MODEL % geom)
    cube(Path("shell.stl"))
    whole = messages()
    Path("shell.stl").unlink()
    bare = messages()
    assert {code for code, _, _ in whole} >= {"STB101", "VER101"}
    assert {code for code, _, _ in bare}.isdisjoint({"STB101"})
    assert all(item in whole for item in bare if item[0] not in BY_INERTIA)
    for code, _, message in bare - whole:
        assert code in BY_INERTIA
        assert "damping ratio" not in message
        assert "Hz" not in message
        assert code != "VER101" or "cannot be computed here" in message


def test_a_pointer_of_git_lfs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is a mesh that is not there; a file of another text is one that MuJoCo refuses."""
    monkeypatch.chdir(tmp_path)
    Path("arm.xml").write_text(MODEL % GEOMS["mesh"])
    bare = messages()
    oid = "oid sha256:4d7a214614ab2935c943f9e0ff69d22eadbb8f32b1258daaa5e2ca24d17e2393\n"
    Path("shell.stl").write_text(f"version https://git-lfs.github.com/spec/v1\n{oid}size 12345\n")
    assert messages() == bare
    (artifact,) = audit(["arm.xml"], Settings()).case.artifacts
    assert artifact.robot is not None
    assert (
        artifact.robot.inertia_reason is not None and "pointers of Git LFS" in artifact.robot.inertia_reason
    )
    Path("shell.stl").write_text(f"no version of Git LFS\n{oid}size 12345\n")
    (artifact,) = audit(["arm.xml"], Settings()).case.artifacts
    assert artifact.text_only is not None
