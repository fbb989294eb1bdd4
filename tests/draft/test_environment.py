"""A robot's configuration and the environments of its file: whose steps count, and what the robot is called."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.cli.main import main

ROBOT = """from isaaclab.actuators import DelayedPDActuatorCfg
from isaaclab.assets import ArticulationCfg
from isaaclab.envs import ManagerBasedRLEnvCfg
from isaaclab.utils import configclass

DOGO_CFG = ArticulationCfg(actuators={"legs": DelayedPDActuatorCfg(
    joint_names_expr=["hip", "knee"], stiffness=25.0, damping=0.5, effort_limit=20.0, min_delay=1, max_delay=3)})
"""
ENV = """
@configclass
class {name}(ManagerBasedRLEnvCfg):
    def __post_init__(self):
        self.decimation = 4
        self.sim.dt = {dt}
        self.scene.robot = DOGO_CFG.replace(prim_path="{{ENV_REGEX_NS}}/Robot")
"""
ONE = ENV.format(name="DogoEnvCfg", dt=0.005)
TWO = ONE + ENV.format(name="DogoPlayEnvCfg", dt=0.005)


def imported(
    folder: Path, text: str, capsys: pytest.CaptureFixture[str], *more: str, file: str = "dogo_cfg.py"
) -> tuple[str, str]:
    """The spec of a file with this text, and what is said."""
    (folder / file).write_text(text, encoding="utf-8")
    assert main(["import", str(folder / file), *more]) == 0
    said = capsys.readouterr()
    return said.out, said.err


@pytest.mark.parametrize("more", [(), ("--robot", "DOGO_CFG"), ("--robot", "DogoEnvCfg")])
@pytest.mark.parametrize("envs, named", [(ONE, "DogoEnvCfg"), (TWO, "DogoEnvCfg, DogoPlayEnvCfg")])
def test_the_environment_of_a_robot(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], more: tuple[str, ...], envs: str, named: str
) -> None:
    """Its steps are the robot's, whichever of the two is named, and the robot keeps its own name."""
    text, said = imported(tmp_path, ROBOT + envs, capsys, *more)
    assert "\n  name: dogo\n" in text
    assert "\n  physics_dt: {value: 5 ms, source: dogo_cfg}    # dogo_cfg.py:13\n  decimation: 4\n" in text
    # 1 and 3 steps of 5 ms.
    assert "    delay: {nominal: unknown, range: [5 ms, 15 ms], sampling: episode}" in text
    remark = f"  time step, decimation from {named} in its file, dogo_cfg.py:12, 13\n"
    assert (remark in said) is ("DogoEnvCfg" not in more)
    assert "no file states delay" not in said and "length no file states" not in said


def test_environments_that_differ(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of steps of 5 and 2 ms none is taken: they are told, and --robot takes one."""
    both = ROBOT + ONE + ENV.format(name="DogoFineEnvCfg", dt=0.002)
    text, said = imported(tmp_path, both, capsys)
    assert "\n  name: dogo\n" in text and "physics_dt: {value" not in text
    told = "DogoEnvCfg, DogoFineEnvCfg in its file differ in time step: --robot NAME takes those of one"
    assert f"  {told}\n" in said
    text, said = imported(tmp_path, both, capsys, "--robot", "DogoFineEnvCfg")
    assert "range: [2 ms, 6 ms]" in text and "differ in" not in said


def test_an_environment_alone(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A robot that only its environment's file names is not called an environment."""
    (tmp_path / "dogo_cfg.py").write_text(ROBOT, encoding="utf-8")
    head = ROBOT[: ROBOT.index("DOGO_CFG")] + "from dogo_cfg import DOGO_CFG\n"
    env = head + ENV.format(name="DogoRoughEnvCfg", dt=0.005)
    text, _ = imported(tmp_path, env, capsys, file="env_cfg.py")
    assert "\n  name: Dogo\n" in text
    # Beside the robot's own file, that names it, in either order.
    text, _ = imported(tmp_path, env, capsys, str(tmp_path / "dogo_cfg.py"), file="env_cfg.py")
    assert "\n  name: dogo\n" in text and "range: [5 ms, 15 ms]" in text


@pytest.mark.parametrize("order", [("dogo_cfg.py", "env_cfg.py"), ("env_cfg.py", "dogo_cfg.py")])
def test_remarks_of_a_robot_and_its_environment(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], order: tuple[str, str]
) -> None:
    """What an environment imports with its robot is told once, by the file in which it is written."""
    speed = ROBOT.replace("effort_limit=20.0", "effort_limit=20.0, velocity_limit=14.0")
    robot = speed.replace('["hip", "knee"]', '["hip", "kne.*", "ankel"]')
    (tmp_path / "dogo_cfg.py").write_text(robot, encoding="utf-8")
    head = ROBOT[: ROBOT.index("DOGO_CFG")] + "from dogo_cfg import DOGO_CFG\n"
    (tmp_path / "env_cfg.py").write_text(head + ENV.format(name="DogoEnvCfg", dt=0.005), encoding="utf-8")
    files = [str(tmp_path / name) for name in order]
    assert main(["import", *files, "--joints", "hip,knee,ankle"]) == 0
    said = capsys.readouterr().err
    told = [line for line in said.splitlines() if "velocity_limit 14 is left out" in line]
    assert len(told) == 1 and told[0].startswith("  hip, knee: dogo_cfg.py: ")
    # `DOGO_CFG = ` 11, `ArticulationCfg(` 16, `actuators={` 11, `"legs": ` 8: the group begins behind 46 characters.
    assert said.count("DRF012") == 1 and "dogo_cfg.py:6:47: DRF012" in said


def test_remarks_of_two_robot_files(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The same remark on two files that each write it is told of both: both are to be looked at."""
    files = [tmp_path / name for name in ("one_cfg.py", "two_cfg.py")]
    for file in files:
        speed = ROBOT.replace("effort_limit=20.0", "effort_limit=20.0, velocity_limit=14.0")
        file.write_text(speed, encoding="utf-8")
    assert main(["import", *map(str, files)]) == 0
    assert capsys.readouterr().err.count("velocity_limit 14 is left out") == 2
