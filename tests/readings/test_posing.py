"""Programs that ask a model where its links are, and run nothing."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.rules.sym101 import LeftRightDiffer
from actspec.audit.settings import Settings
from actspec.readings.written_over import poses_alone

POSES = b"model = mujoco.MjModel.from_xml_path('two.xml')\nmujoco.mj_forward(model, data)\n"


@pytest.mark.parametrize(
    ("program", "alone"),
    [
        (b"import pinocchio\nrobot = build('two.urdf')\n", True),
        (b"import pinocchio\nrobot = build('two.urdf')\ntau = rnea(robot)\n", False),
        (b"import pinocchio\nrobot = build('two.urdf')\nlimits = robot.model.effortLimit\n", False),
        (b"import pinocchio\nimport pybullet\n", False),
        (b"from forwardkinematics.urdfFks.generic_urdf_fk import GenericURDFFk\n", True),
        (POSES, True),
        (POSES + b"mujoco.mj_step(model, data)\n", False),
        (POSES + b"class Env(MujocoEnv):\n", False),
        (b"env.step(action)\nnaming = 'two.xml'\n", False),
        (b"from curobo.types.robot import RobotConfig\nload('two.urdf')\n", True),
        (b"robot_cfg:\n\n  kinematics:\n    isaac_usd_path: two.usd\n    urdf_path: two.urdf\n", True),
        (b"robot_cfg:\n  urdf_path: two.urdf\n  isaac_usd_path: two.usd\n", False),
    ],
)
def test_a_program_by_what_it_calls(program: bytes, alone: bool) -> None:
    """Torques are asked of a model's drives or inertia; a pose is not."""
    assert poses_alone({"a.py": program}) == ({"a.py"} if alone else set())


def test_what_one_program_loads_another_may_step() -> None:
    """Inverse kinematics load a model of their own."""
    steps = {"sim.py": b"for _ in range(n):\n    mujoco.mj_step(world.model, world.data)\n"}
    assert poses_alone({"load.py": POSES, **steps}) == set()
    assert poses_alone({"ik.py": b"import ikpy\nchain = read('two.urdf')\n", **steps}) == {"ik.py"}


@pytest.mark.parametrize(
    ("programs", "idle"),
    [
        ({}, set()),
        ({"ik.py": "import ikpy\nread('two.urdf')\n"}, {"one", "two"}),
        (
            {"ik.py": "import ikpy\nread('two.urdf')\n", "go.py": "import isaacgym\nload('one.urdf')\n"},
            {"two"},
        ),
        (
            {"ik.py": "import ikpy\nread('two.urdf')\n", "go.py": "import isaacgym\nload('two.urdf')\n"},
            {"one"},
        ),
    ],
)
def test_a_model_of_kinematics_alone(
    programs: dict[str, str], idle: set[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is wrong with its drives is a note: left and right have 20 and 30 N*m in both."""
    monkeypatch.chdir(tmp_path)
    # Which rules speak of a folder is tested elsewhere.
    monkeypatch.setattr(LeftRightDiffer, "noted_in_folders", False)
    joints = "".join(
        f'<link name="{side}"/><joint name="{side}_knee" type="revolute"><parent link="base"/><child link="{side}"/>'
        f'<limit lower="-1" upper="1" effort="{effort}" velocity="9"/></joint>'
        for side, effort in (("left", 20), ("right", 30))
    )
    for name in ("one", "two"):
        Path(f"{name}.urdf").write_text(f'<robot name="{name}"><link name="base"/>{joints}</robot>')
    for program, text in programs.items():
        Path(program).write_text(text)
    found = audit(["."], Settings(select=("SYM101",))).findings
    assert {Path(item.finding.span.path).stem for item in found} == {"one", "two"}
    assert {Path(item.finding.span.path).stem for item in found if item.severity.value == "info"} == idle
