"""LIM101: limits of a URDF that nothing in a folder takes are notes."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.settings import Settings
from actspec.diagnostics import Severity

URDF = """<robot name="arm">
  <link name="base"/>
  <link name="upper"/>
  <link name="lower"/>
  <joint name="shoulder" type="revolute">
    <parent link="base"/><child link="upper"/><limit lower="-1" upper="1" effort="{0}" velocity="{0}"/>
  </joint>
  <joint name="elbow" type="revolute">
    <parent link="upper"/><child link="lower"/><limit lower="-1" upper="1" effort="{0}" velocity="{0}"/>
  </joint>
</robot>
"""
DEPLOY = "joint_names: [shoulder, elbow]\nkp: [20, 20]\nkd: [0.5, 0.5]\n"


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("arm").mkdir()


def severities(name: str) -> set[Severity]:
    """Of what LIM101 says of a folder or file."""
    return {item.severity for item in audit([name], Settings()).findings if item.finding.code == "LIM101"}


@pytest.mark.parametrize("limit", ["0", "1e6"])
def test_limits_of_a_urdf_in_a_folder(limit: str) -> None:
    """A warning where the file is named, or where something in the folder drives the robot; else a note."""
    Path("arm/arm.urdf").write_text(URDF.format(limit))
    assert severities("arm") == {Severity.INFO}
    assert severities("arm/arm.urdf") == {Severity.WARNING}
    Path("arm/deploy.yaml").write_text(DEPLOY)
    assert severities("arm") == {Severity.WARNING}
