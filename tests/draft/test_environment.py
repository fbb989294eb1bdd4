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


EVENTS = """
import isaaclab.envs.mdp as mdp
from isaaclab.managers import EventTermCfg as EventTerm, SceneEntityCfg

@configclass
class EventCfg:
{terms}

@configclass
class DogoEnvCfg(ManagerBasedRLEnvCfg):
    events: EventCfg = EventCfg()
    def __post_init__(self):
        self.scene.robot = DOGO_CFG.replace(prim_path="{{ENV_REGEX_NS}}/Robot")
"""
START = """    start = EventTerm(func=mdp.randomize_actuator_gains, mode="startup", params={
        "asset_cfg": SceneEntityCfg("robot", joint_names=".*"), "operation": "abs",
        "stiffness_distribution_params": (20.0, 30.0)})"""
RESET = """    gains = EventTerm(func=mdp.randomize_actuator_gains, mode="reset", params={
        "asset_cfg": SceneEntityCfg("robot", joint_names=[".*"]), "operation": "scale",
        "distribution": "log_uniform", "stiffness_distribution_params": (0.5, 2.0)})"""


@pytest.mark.parametrize("order", [(START, RESET), (RESET, START)])
def test_gains_drawn_at_the_start_and_at_every_reset(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], order: tuple[str, str]
) -> None:
    """The reset's range counts wherever it stands: Isaac Lab draws it last, from the configuration's figure.

    Source: Isaac Lab 2.3.2, envs/mdp/events.py, `stiffness[...] = default_joint_stiffness[...]`.
    """
    text, said = imported(tmp_path, ROBOT + EVENTS.format(terms="\n".join(order)), capsys)
    assert (
        "\n    randomize:\n      kp: {scale: [0.5, 2], distribution: log_uniform, when: reset, per: joint}\n"
        in text
    )
    lines = (tmp_path / "dogo_cfg.py").read_text(encoding="utf-8").splitlines()
    startup, reset = (
        next(n for n, line in enumerate(lines, 1) if ends in line) for ends in ("(20.0, 30.0)", "(0.5, 2.0)")
    )
    told = (
        "hip, knee: randomize.kp {abs: [20 N*m/rad, 30 N*m/rad], when: startup, per: joint} of "
        f"dogo_cfg.py:{startup} is left out: dogo_cfg.py:{reset} is drawn last, at reset"
    )
    assert told in said


def test_two_ranges_of_one_moment(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The later term replaces what the earlier has drawn; one that says the same is not told."""
    other = RESET.replace("gains =", "more =").replace("(0.5, 2.0)", "(0.9, 1.1)")
    text, said = imported(tmp_path, ROBOT + EVENTS.format(terms=f"{RESET}\n{other}"), capsys)
    assert "kp: {scale: [0.9, 1.1], distribution: log_uniform, when: reset, per: joint}" in text
    assert said.count("randomize.kp {scale: [0.5, 2]") == 1
    again = RESET.replace("gains =", "more =")
    _, said = imported(tmp_path, ROBOT + EVENTS.format(terms=f"{RESET}\n{again}"), capsys)
    assert "randomize." not in said


def test_environments_whose_ranges_are_drawn_at_other_times(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Ranges with the same ends are others if one is drawn once and one at every reset."""
    one = EVENTS.format(terms=RESET)
    two = (
        one.replace("EventCfg", "PlayEventCfg").replace("DogoEnv", "DogoPlayEnv").replace("reset", "startup")
    )
    text, said = imported(tmp_path, ROBOT + one + two, capsys)
    assert "randomize:" not in text
    assert "DogoEnvCfg, DogoPlayEnvCfg in its file differ in ranges" in said


WHEELS = ROBOT.replace(
    "max_delay=3)})",
    """max_delay=3),
    "wheels": DelayedPDActuatorCfg(joint_names_expr=["wheel"], stiffness=0.0, damping=0.5, effort_limit=20.0)})""",
)


def test_no_range_of_a_gain_that_a_joint_has_not(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Wheels that are driven by speed have no kp: a factor on it is none, and compile draws the others' ranges."""
    text, said = imported(tmp_path, WHEELS + EVENTS.format(terms=RESET), capsys)
    legs, wheels = text[text.index("\n  legs:") :].split("\n  wheels:")
    kept = "kp: {scale: [0.5, 2], distribution: log_uniform, when: reset, per: joint}"
    assert kept in legs and "randomize" not in wheels.split("joints:")[1]
    assert f"wheel: randomize.{kept.replace(':', '', 1)} of dogo_cfg.py:" in said
    assert "is left out: a drive of level ideal_pd and command velocity has no kp" in said
    spec = tmp_path / "spec.yaml"
    spec.write_text(text, encoding="utf-8")
    assert main(["compile", str(spec), "-t", "randomization", "-o", str(tmp_path / "out")]) == 0
    (events,) = tmp_path.glob("out/randomization/*_isaaclab_events.py")
    assert '"stiffness_distribution_params": (0.5, 2.0)' in events.read_text(encoding="utf-8")


def test_no_factor_on_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """0 times a factor stays 0 in Isaac Lab: such a range of the text is none, an offset is."""
    undamped = ROBOT.replace("damping=0.5", "damping=0.0")
    factor = RESET.replace("stiffness_", "damping_")
    text, said = imported(tmp_path, undamped + EVENTS.format(terms=factor), capsys)
    assert "randomize:" not in text
    assert "is left out: kd is 0 N*m*s/rad, and 0 times a factor stays 0" in said
    offset = factor.replace('"scale"', '"add"').replace('"log_uniform"', '"uniform"')
    text, said = imported(tmp_path, undamped + EVENTS.format(terms=offset), capsys)
    assert (
        "kd: {add: [0.5 N*m*s/rad, 2 N*m*s/rad], when: reset, per: joint}" in text
        and "left out: kd" not in said
    )


TASK = """from dogo_assets import DOGO_CFG
from isaaclab.envs import ManagerBasedRLEnvCfg, mdp
from isaaclab.managers import EventTermCfg, SceneEntityCfg
from isaaclab.utils import configclass

@configclass
class ActionsCfg:
    joint_pos = mdp.JointPositionActionCfg(asset_name="robot", joint_names=["hip"], scale=0.25)

@configclass
class EventCfg:
    gains = EventTermCfg(func=mdp.randomize_actuator_gains, mode="reset", params={
        "asset_cfg": SceneEntityCfg("robot", joint_names="knee"),
        "stiffness_distribution_params": (0.5, 2.0), "operation": "scale"})

@configclass
class DogoBaseEnvCfg(ManagerBasedRLEnvCfg):
    def __post_init__(self):
        self.decimation = 4
        self.sim.dt = 0.005
        self.scene.robot = DOGO_CFG.replace(prim_path="{ENV_REGEX_NS}/Robot")

@configclass
class DogoEnvCfg(DogoBaseEnvCfg):
    actions = ActionsCfg()
    events = EventCfg()
"""


@pytest.mark.parametrize("more", [(), ("--robot", "DOGO_CFG"), ("--robot", "DogoEnvCfg")])
@pytest.mark.parametrize("first", [True, False])
def test_an_environment_of_another_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], first: bool, more: tuple[str, ...]
) -> None:
    """Its robot is in a package that is not beside it: what it says is of the robot that is named with it."""
    (tmp_path / "dogo_cfg.py").write_text(ROBOT, encoding="utf-8")
    (tmp_path / "env_cfg.py").write_text(TASK, encoding="utf-8")
    files = [str(tmp_path / name) for name in ("env_cfg.py", "dogo_cfg.py")]
    assert main(["import", *(files if first else files[::-1]), *more]) == 0
    text, said = capsys.readouterr()
    names = "DogoEnvCfg" if "DogoEnvCfg" in more else "DogoBaseEnvCfg, DogoEnvCfg"
    at = "env_cfg.py:8, 14, 19, 20"
    assert f"time step, decimation, action scale, ranges from {names}, {at}\n" in said
    assert "\n  physics_dt: {value: 5 ms, source: env_cfg}    # env_cfg.py:20\n  decimation: 4\n" in text
    # 1 and 3 steps of 5 ms; the term is for the hip, the range for the knee.
    assert "range: [5 ms, 15 ms]" in text
    assert text.count("action_scale: {value: 0.25, source: env_cfg}") == 1
    assert text.count("kp: {scale: [0.5, 2], when: reset, per: joint}") == 1
    assert "\n  name: dogo\n" in text


def test_environments_of_another_file_that_differ(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What they differ in is left out, with the steps that count it, and told; --robot takes those of one."""
    (tmp_path / "dogo_cfg.py").write_text(ROBOT, encoding="utf-8")
    task = (
        TASK + "    def __post_init__(self):\n        super().__post_init__()\n        self.sim.dt = 0.002\n"
    )
    (tmp_path / "env_cfg.py").write_text(task, encoding="utf-8")
    files = [str(tmp_path / name) for name in ("env_cfg.py", "dogo_cfg.py")]
    assert main(["import", *files]) == 0
    text, said = capsys.readouterr()
    names = "DogoBaseEnvCfg, DogoEnvCfg in env_cfg.py"
    told = f"action scale, ranges from {names}, env_cfg.py:8, 14; they differ in time step"
    assert f"{told}: --robot NAME takes those of one\n" in said
    assert text.count("action_scale: {value: 0.25, source: env_cfg}") == 1
    assert "physics_dt: {value" not in text and "\n  decimation" not in text
    assert main(["import", *files, "--robot", "DOGO_CFG"]) == 0
    assert f"{told}: none is taken\n" in capsys.readouterr().err
    assert main(["import", *files, "--robot", "DogoEnvCfg"]) == 0
    text, said = capsys.readouterr()
    assert "physics_dt: {value: 2 ms, source: env_cfg}" in text and "differ" not in said


ROUGH = """
@configclass
class DogoRoughEnvCfg(DogoBaseEnvCfg):
    actions = ActionsCfg()
    def __post_init__(self):
        super().__post_init__()
        self.decimation = 10
        self.actions.joint_pos.scale = 0.5
"""


_BOTH = ("env_cfg.py", "dogo_cfg.py")


@pytest.mark.parametrize(
    ("files", "imports"),
    [(_BOTH[:1], True), (_BOTH, True), (_BOTH[::-1], True), (_BOTH, False), (_BOTH[::-1], False)],
)
def test_environments_that_differ_beside_their_robot(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], files: tuple[str, ...], imports: bool
) -> None:
    """Of scales of 0.25 and 0.5 and of 4 and 10 steps neither is taken, whether the robot is found by the environments'
    import or named: it is told once, and --robot takes one."""
    (tmp_path / "dogo_cfg.py").write_text(ROBOT, encoding="utf-8")
    task = (TASK.replace("dogo_assets", "dogo_cfg") if imports else TASK) + ROUGH
    (tmp_path / "env_cfg.py").write_text(task, encoding="utf-8")
    paths = [str(tmp_path / file) for file in files]
    assert main(["import", *paths]) == 0
    text, said = capsys.readouterr()
    assert "action_scale" not in text and "\n  decimation" not in text
    assert "\n  physics_dt: {value: 5 ms, source: env_cfg}    # env_cfg.py:20\n" in text
    where = "its file" if len(files) == 1 else "env_cfg.py"
    names = f"DogoBaseEnvCfg, DogoEnvCfg, DogoRoughEnvCfg in {where}"
    told = f"time step, ranges from {names}, env_cfg.py:14, 20; they differ in decimation, action scale"
    assert said.count(f"{told}: --robot NAME takes those of one\n") == 1 == said.count("differ in")
    assert main(["import", *paths, "--robot", "DogoRoughEnvCfg"]) == 0
    text, said = capsys.readouterr()
    assert "\n  decimation: 10\n" in text and "action_scale: {value: 0.5, source: env_cfg}" in text
    assert "differ in" not in said


BASE = """from dataclasses import MISSING
from isaaclab.assets import ArticulationCfg
from isaaclab.envs import ManagerBasedRLEnvCfg, mdp
from isaaclab.scene import InteractiveSceneCfg
from isaaclab.utils import configclass

@configclass
class SceneCfg(InteractiveSceneCfg):
    robot: ArticulationCfg = MISSING

@configclass
class ActionsCfg:
    joint_pos = mdp.JointPositionActionCfg(asset_name="robot", joint_names=[".*"], scale=0.5)

@configclass
class BaseEnvCfg(ManagerBasedRLEnvCfg):
    scene: SceneCfg = SceneCfg(num_envs=4096, env_spacing=2.5)
    actions: ActionsCfg = ActionsCfg()
    def __post_init__(self):
        self.decimation = 4
        self.sim.dt = 0.005
"""
DERIVED = """from isaaclab.utils import configclass

from {tasks}base_env_cfg import BaseEnvCfg
from {assets}dogo_cfg import DOGO_CFG

@configclass
class DogoEnvCfg(BaseEnvCfg):
    def __post_init__(self):
        super().__post_init__()
        self.scene.robot = DOGO_CFG.replace(prim_path="{{ENV_REGEX_NS}}/Robot")
        self.actions.joint_pos.scale = 0.25
"""


def _family(folder: Path, tasks: str, assets: str) -> list[str]:
    """A robot, its environment and that one's base, each in a folder of its own but for relative imports."""
    apart = tasks != "."
    files = {"dogo_cfg.py": ROBOT, "base_env_cfg.py": BASE}
    files["env_cfg.py"] = DERIVED.format(tasks=tasks, assets=assets)
    paths = [folder / (name.removesuffix(".py") if apart else "") / name for name in files]
    for path, text in zip(paths, files.values(), strict=True):
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return list(map(str, paths))


@pytest.mark.parametrize("more", [(), ("--robot", "DOGO_CFG"), ("--robot", "DogoEnvCfg")])
@pytest.mark.parametrize(("tasks", "assets"), [(".", "."), ("my_tasks.locomotion.", "my_assets.robots.")])
@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0)])
def test_the_base_of_an_environment_beside_it(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    order: tuple[int, ...],
    tasks: str,
    assets: str,
    more: tuple[str, ...],
) -> None:
    """A base that leaves its robot `MISSING` is no other environment: its scale of 0.5 is 0.25 in the derived one."""
    paths = _family(tmp_path, tasks, assets)
    assert main(["import", *(paths[i] for i in order), *more]) == 0
    text, said = capsys.readouterr()
    assert "\n  physics_dt: {value: 5 ms, source: env_cfg}    # base_env_cfg.py:21\n  decimation: 4\n" in text
    assert text.count("action_scale: {value: 0.25, source: env_cfg}") == 1 and "value: 0.5," not in text
    assert "differ" not in said and "\n  name: dogo\n" in text


def test_a_name_that_two_named_files_define(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Which of them a package's import means is not known: the base with the steps is that of neither."""
    robot, base, env = _family(tmp_path, "my_tasks.", "my_assets.")
    other = tmp_path / "other_base.py"
    other.write_text(BASE.replace("0.005", "0.002"), encoding="utf-8")
    assert main(["import", robot, env, base, str(other)]) == 0
    text, said = capsys.readouterr()
    assert "physics_dt: {value" not in text and "action_scale" not in text
    names = "DogoEnvCfg, BaseEnvCfg of base_env_cfg.py, BaseEnvCfg of other_base.py"
    assert f"{names} in env_cfg.py, base_env_cfg.py, other_base.py differ in time step, action scale" in said


@pytest.mark.parametrize(
    ("named", "scale"), [(None, None), ("DOGO_CFG", None), ("DogoFlatEnvCfg", "0.4"), ("DogoEnvCfg", "0.25")]
)
@pytest.mark.parametrize("robot_file", [True, False])
def test_two_environments_of_files_of_their_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], robot_file: bool, named: str | None, scale: str | None
) -> None:
    """Their robot is imported: what they differ in is none's, and --robot takes that of the one it names."""
    robot, base, env = _family(tmp_path, "my_tasks.", "my_assets.")
    flat = tmp_path / "flat_cfg.py"
    text = Path(env).read_text("utf-8").replace("DogoEnvCfg", "DogoFlatEnvCfg").replace("0.25", "0.4")
    flat.write_text(text, encoding="utf-8")
    if not robot_file:
        # Of a file with a second robot the one is the environments'.
        Path(robot).write_text(
            ROBOT + ROBOT[ROBOT.index("DOGO_CFG") :].replace("DOGO_CFG", "CATO_CFG"), "utf-8"
        )
    more = ("--robot", named) if named else ()
    assert main(["import", robot, env, str(flat), base, *more]) == 0
    text, said = capsys.readouterr()
    assert "physics_dt: {value: 5 ms," in text and "DRF010" not in said
    assert text.count("action_scale: {value") == (0 if scale is None else 1)
    if scale is not None:
        assert f"action_scale: {{value: {scale}, source:" in text


def test_a_frameworks_own_class_is_no_named_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`ArticulationCfg` of Isaac Lab is not the class of that name in another named file, with another drive."""
    own = "class DelayedPDActuatorCfg:\n    stiffness = 99.0\n"
    (tmp_path / "own.py").write_text(own + ROBOT.replace("DOGO_CFG", "CATO_CFG"), encoding="utf-8")
    (tmp_path / "dogo_cfg.py").write_text(ROBOT, encoding="utf-8")
    files = [str(tmp_path / name) for name in ("dogo_cfg.py", "own.py")]
    main(["import", *files, "--robot", "DOGO_CFG"])
    assert "kp: {value: 25 N*m/rad" in capsys.readouterr().out


def test_the_environment_of_another_robot(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It says which robot it takes, and that is another one of the same file."""
    (tmp_path / "dogo_cfg.py").write_text(
        ROBOT + ROBOT[ROBOT.index("DOGO_CFG") :].replace("DOGO_CFG", "CATO_CFG"), encoding="utf-8"
    )
    (tmp_path / "env_cfg.py").write_text(TASK, encoding="utf-8")
    files = [str(tmp_path / name) for name in ("env_cfg.py", "dogo_cfg.py")]
    assert main(["import", *files, "--robot", "CATO_CFG"]) == 0
    assert "action_scale" not in capsys.readouterr().out
    assert main(["import", *files, "--robot", "DOGO_CFG"]) == 0
    assert "action_scale" in capsys.readouterr().out
