"""Files that have a model's joints and are not compared with it."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.read import pending_files
from actspec.audit.settings import Settings

MODEL = """<mujoco model="biped">
  <worldbody><body><joint name="hip"/><joint name="knee" axis="1 0 0"/><geom size="0.1"/></body></worldbody>
</mujoco>"""
DEPLOY = "joint_names: [{}]\nkp: [4, 5]\nkd: [1, 1]\n"


@pytest.mark.parametrize(
    ("name", "joints", "reported"),
    [
        ("walk.yaml", "hip, knee", True),
        ("biped_walk.yaml", "hip, knee", False),
        ("deploy.yaml", "hip, knee", False),
        # One of two joints is less than 0.8.
        ("walk.yaml", "hip, elbow", False),
    ],
    ids=["another-name", "its-name", "no-name", "other-joints"],
)
def test_another_name(
    name: str, joints: str, reported: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A deploy file that is called otherwise than the model with its joints is reported as not compared."""
    monkeypatch.chdir(tmp_path)
    Path("biped.xml").write_text(MODEL)
    Path(name).write_text(DEPLOY.format(joints))
    with pending_files(("biped.xml", name)) as pending:
        report = audit(pending, Settings(select=("SRC103",)))
    found = [str(item).partition("\n")[0] for item in report.for_people()]
    message = (
        "this has the joints of biped.xml, and is not compared with it: "
        "no name shows that it is the same robot"
    )
    assert found == ([f"{name}: AUD015 [info]: {message}"] if reported else [])
