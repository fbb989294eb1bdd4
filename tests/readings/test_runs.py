"""What a training wrote of itself, `params/env.yaml`: read as a configuration, where somebody names it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.read import pending_files
from actspec.audit.settings import Settings
from actspec.cli.main import main
from actspec.readings.artifact import FileKind, Framework, RobotConfig
from actspec.readings.deploy import read_deploy

ISAACLAB = """\
sim: {{dt: 0.005, physics_material: {{func: isaaclab.sim:spawn_rigid_body_material}}}}
decimation: 4
scene:
  num_envs: 4096
  robot:
    class_type: isaaclab.assets.articulation.articulation:Articulation
    spawn: {{usd_path: /somewhere/leggy.usd}}
    init_state:
      joint_pos: &pose
        hip: 0.25
        knee: -0.5
    actuators:
      legs:
        class_type: isaaclab.actuators.actuator_pd:{cls}
        joint_names_expr: !!python/tuple
        - hip
        - knee
        effort_limit: 23.5
        stiffness: {{hip: 40.0, knee: 60.0}}
        damping: 1.5
        armature: null
        friction: 0.0
  light:
    class_type: null
actions:
  joint_pos:
    class_type: isaaclab.envs.mdp.actions.joint_actions:JointPositionAction
    asset_name: robot
    clip: null
    joint_names: [.*]
    scale: {{hip: 0.25, knee: 0.5}}
    offset: 0.0
    use_default_offset: true
events:
  gains:
    func: isaaclab.envs.mdp.events:randomize_actuator_gains
    params:
      asset_cfg:
        name: robot
        joint_names: [hip]
        joint_ids: !!python/object/apply:builtins.slice [null, null, null]
      stiffness_distribution_params: !!python/tuple [0.75, 1.25]
      damping_distribution_params: null
      operation: scale
      distribution: log_uniform
    mode: startup
"""

MJLAB = """\
decimation: 4
sim: {{mujoco: {{timestep: 0.002}}}}
scene:
  terrain: {{articulation: null}}
  entities:
    robot:
      init_state: {{joint_pos: {{hip: 0.25, knee: -0.5}}}}
      spec_fn: !!python/name:somebody.get_spec ''
      articulation:
        soft_joint_pos_limit_factor: 0.9
        actuators: !!python/tuple
        - target_names_expr: !!python/tuple [hip, knee]
          transmission_type: !!python/object/apply:mjlab.actuator.actuator.TransmissionType [joint]
          armature: 0.01
          {fields}
actions:
  joint_pos: {{entity_name: robot, actuator_names: [.*], scale: 0.5, offset: 0.0, use_default_offset: true}}
events:
  friction:
    func: !!python/name:mjlab.envs.mdp.dr.joint_friction ''
    params: {{ranges: !!python/tuple [0.1, 0.3], asset_cfg: {{name: robot, joint_names: [knee]}}}}
    mode: reset
"""


def read(text: str) -> RobotConfig:
    reading = read_deploy("env.yaml", text.encode())
    (artifact,) = reading.artifacts
    assert reading.record and artifact.kind is FileKind.CFG and artifact.config is not None
    return artifact.config


def test_isaaclab() -> None:
    """Classes, figures by joint, pose, steps, actions and ranges, of a text in the writer's own forms."""
    config = read(ISAACLAB.format(cls="DCMotor"))
    assert (config.framework, config.name, config.model) == (
        Framework.ISAACLAB,
        "leggy",
        "/somewhere/leggy.usd",
    )
    assert config.physics_dt == 0.005 and config.settings["decimation"].number == 4.0
    assert config.settings["default_position"].value == {"hip": 0.25, "knee": -0.5}
    (legs,) = config.groups
    assert (legs.name, legs.cls, legs.joints) == ("legs", "DCMotorCfg", ("hip", "knee"))
    assert legs.settings["stiffness"].value == {"hip": 40.0, "knee": 60.0}
    assert legs.settings["damping"].value == 1.5 and legs.settings["friction"].value == 0.0
    # null: nobody states it.
    assert legs.settings["armature"].value is None and legs.settings["armature"].unknown is None
    assert str(legs.settings["damping"].span) == "env.yaml:20:18"
    (term,) = config.actions
    assert (term.cls, term.command, term.joints) == ("JointPositionActionCfg", "position", (".*",))
    assert term.scale is not None and term.scale.value == {"hip": 0.25, "knee": 0.5} and term.clip is None
    (drawn,) = config.randomize
    assert (drawn.field, drawn.operation, drawn.low, drawn.high) == ("kp", "scale", 0.75, 1.25)
    assert (drawn.joints, drawn.distribution, drawn.when) == (("hip",), "log_uniform", "startup")
    assert not config.notes


@pytest.mark.parametrize(
    ("fields", "cls"),
    [
        (
            "stiffness: 40.0\n          damping: 1.5\n          effort_limit: 23.5",
            "BuiltinPositionActuatorCfg",
        ),
        (
            "stiffness: 40.0\n          damping: 1.5\n          effort_limit: 23.5\n"
            "          saturation_effort: 30.0\n          velocity_limit: 21.0",
            "DcMotorActuatorCfg",
        ),
        ("damping: 1.5\n          effort_limit: 23.5", "BuiltinVelocityActuatorCfg"),
        ("effort_limit: 23.5\n          gear: 1.0", "BuiltinMotorActuatorCfg"),
        ("frictionloss: 0.1", "ActuatorCfg"),
    ],
)
def test_mjlab(fields: str, cls: str) -> None:
    """mjlab leaves classes out: the fields tell, and of the three that share them it is said."""
    config = read(MJLAB.format(fields=fields))
    assert config.framework is Framework.MJLAB and config.physics_dt == 0.002
    (group,) = config.groups
    assert (group.cls, group.joints) == (cls, ("hip", "knee"))
    assert group.settings["armature"].value == 0.01
    assert group.settings["transmission_type"].value == "JOINT"
    (term,) = config.actions
    assert term.command == "position" and term.scale is not None and term.scale.number == 0.5
    (drawn,) = config.randomize
    assert (drawn.field, drawn.low, drawn.high, drawn.joints) == ("friction", 0.1, 0.3, ("knee",))
    said = [note.message for note in config.notes if "not their class" in note.message]
    assert len(said) == (cls == "BuiltinPositionActuatorCfg")


def test_a_class_of_somebodys_own_in_a_run_of_mjlab(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Fields that no class of mjlab has were told as misspelt ones of the class that the other fields have (CFG103)."""
    monkeypatch.chdir(tmp_path)
    own = ("stiffness: 70.0", "damping: 2.0", "effort_limit: 1000000000.0", "X1: 22.63", "Y1: 71.0")
    text = MJLAB.format(fields="\n          ".join(own))
    (group,) = read(text).groups
    assert (group.cls, group.own) == ("BuiltinPositionActuatorCfg", ("X1", "Y1"))
    Path("env.yaml").write_text(text, encoding="utf-8")
    assert told("env.yaml") == []
    assert main(["import", "env.yaml", "-o", "leg.yaml"]) == 0
    remark = (
        "its class is read as BuiltinPositionActuatorCfg: what else it does with X1, Y1 is not known here"
    )
    assert f"  hip, knee: {remark}\n" in capsys.readouterr().out


_ARM = """
  {name}:
    class_type: isaaclab.assets.articulation.articulation:Articulation
    spawn: {{usd_path: /somewhere/arm.usd}}
    init_state: {{joint_pos: {{lift: {pose}}}}}
    actuators:
      all:
        class_type: isaaclab.actuators.actuator_pd:IdealPDActuator
        joint_names_expr: [lift]
        effort_limit: {limit}
        stiffness: 400.0
        damping: 80.0"""

_MJLAB_ARM = """
    {name}:
      init_state: {{joint_pos: {{lift: {pose}}}}}
      articulation:
        actuators: [{{target_names_expr: [lift], stiffness: 400.0, damping: 80.0, effort_limit: {limit}}}]"""

_TERM = (
    "  {name}: {{class_type: isaaclab.envs.mdp.actions.joint_actions:JointPositionAction, asset_name: {name},\n"
    + ("    joint_names: [.*], scale: {scale}, offset: 0.0, use_default_offset: true}}\n")
)


@pytest.mark.parametrize(
    ("head", "arm", "term"),
    [
        ("sim: {dt: 0.01}\ndecimation: 2\nscene:", _ARM, _TERM),
        (
            "sim: {mujoco: {timestep: 0.01}}\ndecimation: 2\nscene:\n  entities:",
            _MJLAB_ARM,
            "  {name}: {{entity_name: {name}, actuator_names: [.*], scale: {scale}, offset: 0.0}}\n",
        ),
    ],
    ids=["isaaclab", "mjlab"],
)
@pytest.mark.parametrize(
    ("keys", "names"),
    [
        (("left_arm", "right_arm"), ("left_arm", "right_arm")),
        (("robot", "second"), ("", "second")),
        (("first", "robot"), ("first", "")),
    ],
)
def test_two_robots_of_a_scene(
    head: str, arm: str, term: str, keys: tuple[str, str], names: tuple[str, str], tmp_path: Path
) -> None:
    """Each with its own pose, figures and actions; the one that both frameworks call `robot` keeps its model's name."""
    text = (
        head
        + arm.format(name=keys[0], pose=0.5, limit=87.0)
        + arm.format(name=keys[1], pose=-0.5, limit=-8.7)
    )
    text += "\nactions:\n" + term.format(name=keys[0], scale=0.25) + term.format(name=keys[1], scale=0.75)
    file = tmp_path / "env.yaml"
    file.write_text(text, encoding="utf-8")
    found = {artifact.name: artifact.config for artifact in read_deploy(str(file), text.encode()).artifacts}
    model = "arm" if head.startswith("sim: {dt") else ""
    called = [".".join(filter(None, (model, name))) or "robot" for name in names]
    assert set(found) == set(called)
    for name, key, pose, limit, scale in zip(
        called, keys, (0.5, -0.5), (87.0, -8.7), (0.25, 0.75), strict=True
    ):
        config = found[name]
        assert config is not None and config.physics_dt == 0.01
        assert config.settings["default_position"].value == {"lift": pose}
        assert [group.settings["effort_limit"].value for group in config.groups] == [limit]
        assert [(one.name, one.scale and one.scale.value) for one in config.actions] == [(key, scale)]
        assert not any("left out" in note.message for note in config.notes)
    (one,) = audit([str(file)], Settings(select=("SGN101",))).findings
    assert (one.finding.code, one.finding.value) == ("SGN101", -8.7)


def test_nothing_is_executed(tmp_path: Path) -> None:
    """A tag that names a function is a name; one that would call it is no value, and says so where it stands."""
    made = tmp_path / "made"
    call = f"!!python/object/apply:os.mkdir ['{made}']"
    text = ISAACLAB.format(cls="DCMotor").replace("effort_limit: 23.5", f"effort_limit: {call}")
    (legs,) = read(text).groups
    assert legs.settings["effort_limit"].unknown is not None
    assert not made.exists()
    config = read(text.replace("DCMotor", "DCMotor'); import os; os.system('x"))
    # No name of Python's: no class is made of it.
    assert [group.cls for group in config.groups] != ["DCMotor'); import os; os.system('xCfg"]


def test_aliases_may_form_a_circle() -> None:
    """What refers to itself ends."""
    text = ISAACLAB.format(cls="DCMotor").replace("  light:\n    class_type: null", "  self: &a {self: *a}")
    assert [group.name for group in read(text).groups] == ["legs"]
    text = ISAACLAB.format(cls="DCMotor").replace("stiffness: {", "stiffness: &b {more: *b, ")
    (legs,) = read(text).groups
    assert legs.settings["stiffness"].unknown is not None


@pytest.fixture
def workspace(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A configuration's folder with two runs in it, and what is deployed."""
    monkeypatch.chdir(tmp_path)
    for name in ("one", "two"):
        run = tmp_path / "logs" / name / "params"
        run.mkdir(parents=True)
        (run / "env.yaml").write_text(ISAACLAB.format(cls="IdealPDActuator"), encoding="utf-8")
    (tmp_path / "deploy.yaml").write_text(
        "joint_names: [hip, knee]\nkps: [40, 120]\nkds: [1.5, 1.5]\n", encoding="utf-8"
    )
    return tmp_path


def told(*paths: str) -> list[str]:
    report = audit(list(paths), Settings())
    return [f"{one.finding.code} {one.finding.span}" for one in report.findings]


def test_a_run_that_is_named_is_compared(workspace: Path) -> None:
    """kp 120 is deployed where 60 was trained with."""
    (one,) = audit(["logs/one/params/env.yaml", "deploy.yaml"], Settings(select=("SRC103",))).findings
    assert (str(one.finding.span), one.finding.value, one.finding.expected) == (
        "deploy.yaml:2:11",
        120.0,
        60.0,
    )
    run = "logs/one/params/env.yaml is what was trained with"
    assert one.finding.help == f"{run}: write its figure here, or train again with this one"


def test_a_run_that_departs_from_the_model(workspace: Path) -> None:
    """23.5 N*m were trained with, and the URDF has 12: nobody edits what was."""
    joint = '<joint name="{0}" type="revolute"><parent link="{1}"/><child link="{0}"/><axis xyz="0 1 0"/>{2}</joint>'
    limit = '<limit lower="-1" upper="1" effort="12" velocity="9"/>'
    joints = joint.format("hip", "base", limit) + joint.format("knee", "hip", limit)
    links = "".join(f'<link name="{name}"/>' for name in ("base", "hip", "knee"))
    Path("leggy.urdf").write_text(f'<robot name="leggy">{links}{joints}</robot>', encoding="utf-8")
    found = audit(["logs/one/params/env.yaml", "leggy.urdf"], Settings(select=("SRC101",))).findings
    assert {(one.finding.joint, one.finding.value, one.finding.expected) for one in found} == {
        ("hip", 23.5, 12.0),
        ("knee", 23.5, 12.0),
    }
    assert {one.finding.help for one in found} == {
        "this is what was trained with: write it into leggy.urdf, or train again with that one's figure"
    }


CONFIG = """\
from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets import ArticulationCfg
from isaaclab.sim import UsdFileCfg

LEGGY_CFG = ArticulationCfg(
    spawn=UsdFileCfg(usd_path="leggy.usd"),
    init_state=ArticulationCfg.InitialStateCfg(joint_pos={"hip": 0.25, "knee": -0.5}),
    actuators={
        "legs": IdealPDActuatorCfg(
            joint_names_expr=["hip", "knee"],
            effort_limit=23.5,
            stiffness={"hip": 40.0, "knee": 60.0},
            damping=1.5,
        )
    },
)
"""


@pytest.mark.parametrize(
    ("written", "instead", "code", "severity"),
    [
        pytest.param("60.0", "600.0", "SRC103", "warning", id="a digit more"),
        pytest.param("60.0", "6000.0", "SRC103", "warning", id="two digits more"),
        pytest.param("60.0", "6.0", "SRC103", "warning", id="a digit less"),
        pytest.param("60.0", "480.0", "SRC103", "info", id="8 times, as somebody may train next"),
        pytest.param('"knee": -0.5', '"knee": 0.5', "SRC106", "warning", id="bent the other way"),
        pytest.param('"knee": -0.5', '"knee": -1.0', "SRC106", "info", id="another pose"),
        pytest.param("damping=1.5", "damping=0.15", "SRC103", "warning", id="all of one gain"),
        pytest.param(
            '40.0, "knee": 60.0},\n            damping=1.5',
            '400.0, "knee": 600.0},\n            damping=15.0',
            "SRC103",
            "warning",
            id="all gains",
        ),
        pytest.param(
            'effort_limit=23.5,\n            stiffness={"hip": 40.0',
            'effort_limit=23.0,\n            stiffness={"hip": 400.0',
            "SRC103",
            "info",
            id="half of the figures, of another training",
        ),
        pytest.param(
            '40.0, "knee": 60.0},\n            damping=1.5',
            '40.0, "knee": 1.5},\n            damping={"hip": 1.5, "knee": 60.0}',
            "SRC103",
            "warning",
            id="exchanged",
        ),
        pytest.param("effort_limit=23.5", "effort_limit=235.0", "SRC101", "error", id="a limit"),
    ],
)
def test_a_configuration_beside_its_run(
    workspace: Path, written: str, instead: str, code: str, severity: str
) -> None:
    """60 N*m/rad, 1.5 N*m*s/rad and -0.5 rad at the knee were trained with: told at the configuration, in any order."""
    assert written in CONFIG
    Path("leggy_cfg.py").write_text(CONFIG.replace(written, instead), encoding="utf-8")
    run = "logs/one/params/env.yaml"
    for names in ((run, "leggy_cfg.py"), ("leggy_cfg.py", run)):
        found = audit(list(names), Settings(select=(code, "SRC103", "SRC106"))).findings
        assert {(one.finding.code, one.severity.value, one.finding.span.path) for one in found} == {
            (code, severity, "leggy_cfg.py")
        }
        assert {one.finding.help for one in found} <= {
            f"{run} is what was trained with: write its figure here, or train again with this one",
            "write 60 N*m/rad and 1.5 N*m*s/rad",
        }


@pytest.mark.parametrize(
    ("model", "expected"),
    [
        pytest.param("other", {"LEGGY_CFG"}, id="the one with the run's model"),
        pytest.param("leggy", set(), id="two with its model, and nothing is guessed"),
    ],
)
def test_a_run_among_several_configurations(workspace: Path, model: str, expected: set[str]) -> None:
    """Isaac Lab's `unitree.py` has robots with the same patterns: the model that a run loads tells its own."""
    second = (
        CONFIG[CONFIG.index("LEGGY_CFG") :]
        .replace("LEGGY_CFG", "OTHER_CFG")
        .replace("leggy.usd", f"{model}.usd")
    )
    Path("legs_cfg.py").write_text(CONFIG.replace("60.0", "600.0") + second, encoding="utf-8")
    report = audit(["legs_cfg.py", "logs/one/params/env.yaml"], Settings(select=("SRC103",)))
    owners = {i for one in report.findings for i in report.case.whose(one.finding.span)}
    assert {report.case.artifacts[i].name for i in owners} == expected


def test_a_configuration_with_other_patterns_is_another_robots(workspace: Path) -> None:
    """A foot more: the run was trained from another configuration, whatever the model is called."""
    other = CONFIG.replace('["hip", "knee"]', '["hip", "knee", "foot"]').replace("60.0", "600.0")
    Path("leggy_cfg.py").write_text(other, encoding="utf-8")
    assert not audit(["leggy_cfg.py", "logs/one/params/env.yaml"], Settings(select=("SRC103",))).findings


def test_a_configuration_that_another_run_was_trained_with(workspace: Path) -> None:
    """The first run had a tenth of the knee's kp, the second has what the configuration has: the slip was mended."""
    Path("leggy_cfg.py").write_text(CONFIG, encoding="utf-8")
    first = Path("logs/one/params/env.yaml")
    first.write_text(first.read_text(encoding="utf-8").replace("knee: 60.0", "knee: 6.0"), encoding="utf-8")
    alone = audit(["leggy_cfg.py", str(first)], Settings(select=("SRC103",))).findings
    both = audit(
        ["leggy_cfg.py", str(first), "logs/two/params/env.yaml"], Settings(select=("SRC103",))
    ).findings
    assert [one.severity.value for one in alone] == ["warning"]
    assert {one.severity.value for one in both} == {"info"}


@pytest.mark.parametrize("folder", ["logs/one", "logs/one/params"])
def test_the_folder_of_a_run_has_it(workspace: Path, folder: str) -> None:
    """Whoever names the run means it."""
    assert "SRC103 deploy.yaml:2:11" in told(folder, "deploy.yaml")


@pytest.mark.parametrize("names", [[".", "logs/one"], ["logs/one", "."], [".", "logs", "logs/one/params/"]])
def test_a_run_in_a_folder_that_is_named_too(workspace: Path, names: list[str]) -> None:
    """The order of the names means nothing, and a folder in another has the files that it has."""
    report = audit(names, Settings(as_named=True))
    assert report.complete and report.not_read == ("past run",)
    assert "logs/one/params/env.yaml" in {file.path for file in report.case.files}
    assert "SRC103 deploy.yaml:2:11" in {f"{one.finding.code} {one.finding.span}" for one in report.findings}
    assert main(["lock", *names]) == 0
    assert "logs/one/params/env.yaml" in json.loads(Path("actspec.lock").read_text("utf-8"))["files"]


@pytest.mark.parametrize("folder", [".", "logs"])
def test_runs_of_the_past_are_counted_alone(workspace: Path, folder: str) -> None:
    """A folder of them says what was, once: it is no mistake that a gain has changed since."""
    report = audit([folder, "deploy.yaml"], Settings())
    assert report.not_read == ("past run", "past run")
    assert [file.path for file in report.case.files if file.readable] == ["deploy.yaml"]
    refused = [file for file in report.case.files if not file.readable]
    # Of a folder without anything else that is no green check.
    assert [file.path for file in refused] == ["logs"] * (folder == "logs")
    assert all("2 past runs not read" in (file.reason or "") for file in refused)


def test_a_hook_passes_over_runs(workspace: Path) -> None:
    """A commit of logs is no change of a robot: pre-commit names every file of it."""
    with pending_files(["logs/one/params/env.yaml", "deploy.yaml"], skip_other=True) as pending:
        report = audit(pending, Settings())
    assert report.not_read == ("past run",) and not report.findings


def test_a_key_twice(tmp_path: Path) -> None:
    """The last one is what training would read again; that there are two is told, and `assert_agrees` fails on it."""
    text = ISAACLAB.format(cls="IdealPDActuator").replace(
        "        damping: 1.5\n", "        damping: 1.5\n        damping: 15.0\n"
    )
    path = tmp_path / "env.yaml"
    path.write_text(text, encoding="utf-8")
    reading = read_deploy(str(path), path.read_bytes())
    (item,) = reading.diagnostics
    assert item.code == "DEPLOY004" and item.span is not None
    assert item.span.line == 1 + text[: text.index("damping: 15.0")].count("\n")
    assert reading.not_taken == (item,)


def test_an_action_of_a_class_of_its_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A policy that drives the robot by one action that names no joints: nothing is known of its scale, told once."""
    monkeypatch.chdir(tmp_path)
    text = ISAACLAB.format(cls="IdealPDActuator")
    start, end = text.index("  joint_pos:\n    class_type"), text.index("events:")
    own = "  bow:\n    class_type: somebody.actions:BowAction\n    asset_name: robot\n    clip: null\n"
    Path("env.yaml").write_text(text[:start] + own + text[end:], encoding="utf-8")
    with pending_files(["env.yaml"]) as pending:
        (found,) = pending.finish()
    config = found.artifacts[0].config
    assert config is not None
    assert [item.message for item in config.notes if item.where == "actions.bow"] == [
        "not known without running it: BowActionCfg makes the command in a way of its own, and names no joints"
    ]
