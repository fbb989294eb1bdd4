"""`actspec import --joints`: a configuration whose joints stand in a USD becomes a spec that compiles."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import pytest

from actspec.cli.main import main
from actspec.spec.validate import load_spec

CFG = """from isaaclab.actuators import ImplicitActuatorCfg
from isaaclab.assets import ArticulationCfg
import isaaclab.sim as sim_utils

LEG_CFG = ArticulationCfg(
    spawn=sim_utils.UsdFileCfg(usd_path="/far/away/leg.usd"),
    actuators={
        "legs": ImplicitActuatorCfg(
            joint_names_expr=[".*_hip", ".*_knee"], effort_limit=24.0, stiffness={".*_hip": 40.0, ".*_knee": 50.0},
            damping=1.5,
        )
    },
)
"""
NAMES = ["left_hip", "right_hip", "left_knee", "right_knee"]

IO_DESCRIPTORS = f"""actions:
  joint_pos: {{joint_names: [left_hip, left_knee], scale: 0.5, mdp_type: Action}}
articulations:
  box:
    joint_names: [lid]
  robot:
    default_joint_pos: [0.0, 0.0, 0.0, 0.0, 0.0]
    joint_names: {json.dumps([*NAMES, "head"])}
scene: {{decimation: 4, dt: 0.02, physics_dt: 0.005}}
"""
URDF = (
    "<robot name='leg'><link name='base'/>"
    + "".join(
        f"<link name='{name}_link'/><joint name='{name}' type='{kind}'><parent link='base'/>"
        f"<child link='{name}_link'/><axis xyz='0 1 0'/><limit lower='-0.5' upper='1' effort='9' velocity='9'/></joint>"
        for name, kind in zip(NAMES, ["revolute", "revolute", "prismatic", "prismatic"], strict=True)
    )
    + "</robot>"
)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with the configuration."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "leg_cfg.py").write_text(CFG, encoding="utf-8")
    return tmp_path


def test_names_are_missing(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Patterns that select none of the names, of groups and of gains, are told once; what needs a model is left out."""
    assert main(["import", "leg_cfg.py", "--joints", "left_hip,right_hip", "-o", "leg.yaml"]) == 0
    out, err = capsys.readouterr()
    assert (
        "leg_cfg.py:8:17: DRF012 [warning]: `.*_knee` of LEG_CFG selects none of the 2 joints of --joints\n"
        in err
    )
    why = "it is written into the robot's URDF, and none is named"
    assert f"  target urdf is left out: {why}\n" in out
    fragment = "no MJCF or URDF is named; `compile -t mujoco` writes a fragment to include in one"
    assert f"  target mujoco is left out: {fragment}\n" in out
    text = (folder / "leg.yaml").read_text("utf-8")
    assert f"  # urdf: {{}}    # left out: {why}\n" in text
    assert list(load_spec("leg.yaml").model.targets) == ["isaaclab"]
    assert main(["compile", "leg.yaml", "-t", "mujoco", "-o", "out"]) == 0
    assert (folder / "out" / "mujoco" / "leg_actuators.xml").is_file()
    capsys.readouterr()
    assert main(["import", "leg_cfg.py", "--joints", ",".join(NAMES)]) == 0
    assert "DRF012" not in capsys.readouterr().err


@pytest.mark.parametrize("robot", [("leg.urdf",), ()])
def test_a_misspelt_key(folder: Path, robot: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    """The gain that it was meant for is not known: 0, as where nothing is refused, would be a joint that hangs."""
    (folder / "leg.urdf").write_text(URDF, encoding="utf-8")
    cfg = CFG.replace(".*_hip", "left_hip").replace(".*_knee", "left_knee")
    (folder / "leg_cfg.py").write_text(cfg.replace('"left_knee": 50', '"left_kneee": 50'), encoding="utf-8")
    assert main(["import", "leg_cfg.py", *robot, "-o", "leg.yaml"]) == 0
    out, err = capsys.readouterr()
    assert (
        "leg_cfg.py:9:86: DRF012 [warning]: `left_kneee` of stiffness selects no joint of group legs\n" in err
    )
    assert "help: did you mean `left_knee`?" in err
    why = "no key of stiffness is for the joint, and 'left_kneee' for none, which Isaac Lab refuses"
    assert f"kp is left out, {why}: " in out and "no file states kp" not in out and "command is" not in out
    assert f"kp: unknown    # {why}\n" in (folder / "leg.yaml").read_text("utf-8")


def test_a_misspelt_joint_that_others_of_its_pattern_hide(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """`.*_knee` selects one of the two. What is another joint of the list with one word changed is no slip."""
    assert main(["import", "leg_cfg.py", "--joints", "left_hip,right_hip,left_knee,right_knie"]) == 0
    err = capsys.readouterr().err
    assert "leg_cfg.py:8:17: DRF012 [warning]: no group of LEG_CFG selects `right_knie` of --joints\n" in err
    assert "help: did you mean `right_knee`? The joint is left alone as it is\n" in err
    cfg = CFG.replace('".*_hip", ".*_knee"]', '"front_a_hip", "front_a_knee"]').replace(".*_", "front_a_")
    (folder / "leg_cfg.py").write_text(cfg, encoding="utf-8")
    names = "front_a_hip,front_a_knee,fronts_a_hip,fronts_a_knee,head"
    assert main(["import", "leg_cfg.py", "--joints", names]) == 0
    assert "DRF012" not in capsys.readouterr().err


def test_a_misspelt_joint_of_the_list(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A list that somebody typed has the slip as likely as the configuration, and each is told beside its own key."""
    cfg = CFG.replace(".*_hip", "left_hip").replace(".*_knee", "left_knee")
    (folder / "leg_cfg.py").write_text(cfg, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", "left_hip,left_kne"]) == 0
    err = capsys.readouterr().err
    assert "is `left_kne` misspelt in --joints? If not, LEG_CFG is refused for it" in err
    assert "did you mean" not in err
    (folder / "leg_cfg.py").write_text(CFG, encoding="utf-8")
    (folder / "typo.txt").write_text("\n".join([*NAMES[:3], "right_kneee"]), encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", "typo.txt"]) == 0
    err = capsys.readouterr().err
    assert "DRF012 [warning]: no group of LEG_CFG selects `right_kneee` of --joints\n" in err
    assert "did you mean `right_knee`? The joint is left alone as it is" in err
    (folder / "leg_cfg.py").write_text(cfg, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", "left_hip,wheel"]) == 0
    assert "is a joint misspelt in --joints, or missing? If not, LEG_CFG is" in capsys.readouterr().err
    (folder / "leg.urdf").write_text(URDF, encoding="utf-8")
    pose = cfg.replace('"left_hip": 40.0', '"left_hipp": 40.0').replace('"left_knee": 50', '"left_kneee": 50')
    (folder / "leg_cfg.py").write_text(pose, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", "leg.urdf"]) == 0
    assert "did you mean `left_hip` for `left_hipp`, `left_knee` for `left_kneee`?" in capsys.readouterr().err


def test_a_joint_without_room_in_a_deploy_file(folder: Path) -> None:
    """A range with equal ends is left out of a listed joint, where it were SPEC110."""
    lists = "position_lower: [-1, 0.5]\nposition_upper: [1, 0.5]\n"
    text = f"format: actspec-deploy/1\njoint_names: [hip, knee]\nkp: [20, 20]\nkd: [1, 1]\n{lists}"
    (folder / "leg.yaml").write_text(text, encoding="utf-8")
    assert main(["import", "leg.yaml", "-o", "spec.yaml"]) == 0
    hip, knee = load_spec("spec.yaml").model.robot.joints
    assert not isinstance(hip, str) and [end.value for end in hip.range] == [-1.0, 1.0]
    assert knee == "knee"


def test_a_joint_that_follows_in_the_urdf(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As the Panda's second finger: what only names the joints does not take one from the configuration."""
    urdf = URDF.replace(
        "name='right_knee' type='prismatic'>", "name='right_knee' type='prismatic'><mimic joint='left_knee'/>"
    )
    (folder / "leg.urdf").write_text(urdf, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", "leg.urdf", "-o", "leg.yaml"]) == 0
    out = capsys.readouterr().out
    assert (
        "  right_knee: follows 'left_knee' in leg.urdf (mimic), and the configuration drives it too\n" in out
    )
    assert "unmanaged" not in out and load_spec("leg.yaml").model.actuators["knees"].joints == (".*_knee",)
    assert main(["import", "leg_cfg.py", "leg.urdf"]) == 0
    assert "  unmanaged, follows 'left_knee' (mimic): right_knee\n" in capsys.readouterr().err


def test_friction_that_is_left_out(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A file states it; what it means depends on versions that nobody states."""
    (folder / "leg_cfg.py").write_text(
        CFG.replace("damping=1.5", "damping=1.5, friction=0.05"), encoding="utf-8"
    )
    assert main(["import", "leg_cfg.py", "--joints", ",".join(NAMES), "-o", "leg.yaml"]) == 0
    out = capsys.readouterr().out
    assert "friction.coulomb is left out, friction 0.05 is no torque: its unit is not known: legs\n" in out
    assert "no file states friction.coulomb" not in out and "no file states friction.viscous: legs\n" in out


def test_a_misspelt_pattern(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its keys are right, and told with it."""
    (folder / "leg.urdf").write_text(URDF, encoding="utf-8")
    (folder / "leg_cfg.py").write_text(CFG.replace('_expr=[".*_hip"', '_expr=[".*_hpi"'), encoding="utf-8")
    assert main(["import", "leg_cfg.py", "leg.urdf"]) == 0
    err = capsys.readouterr().err
    assert (
        "`.*_hpi` of LEG_CFG selects none of the 4 joints of leg.urdf\n" in err and err.count("DRF012") == 1
    )


WITHOUT_KNEES = CFG.replace("effort_limit=24.0", 'effort_limit={".*_hip": 24.0}').replace(
    "Implicit", "IdealPD"
)
NETWORK = CFG.replace("ImplicitActuatorCfg", "ActuatorNetLSTMCfg").replace(
    'stiffness={".*_hip": 40.0, ".*_knee": 50.0},\n            damping=1.5',
    'network_file="/far/away/drive.pt"',
)


@pytest.mark.parametrize(
    "text, code, todo",
    [
        (WITHOUT_KNEES, "ISL010: left_knee, right_knee: effort_limit is unknown", "(state effort_limit)"),
        (NETWORK, "NET002: the network has no manifest", "(write network: {file: ..., manifest: ...};"),
    ],
    ids=["a limit", "a network"],
)
def test_isaac_lab_cannot_have_it(
    folder: Path, text: str, code: str, todo: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """What Isaac Lab must have and no file states leaves it out, with what to do; a fragment for MuJoCo compiles."""
    (folder / "leg_cfg.py").write_text(text, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", ",".join(NAMES), "-o", "leg.yaml"]) == 0
    told = next(line for line in capsys.readouterr().out.splitlines() if "target isaaclab" in line)
    assert told.startswith(f"  target isaaclab is left out: {code}") and todo in told
    spec = (folder / "leg.yaml").read_text("utf-8")
    assert " ".join(spec.split()).count("# isaaclab: ") == 1 and todo in " ".join(spec.split()).replace(
        " #", ""
    )
    assert list(load_spec("leg.yaml").model.targets) == ["mujoco"]
    assert main(["compile", "leg.yaml", "-o", "out"]) == 0


DELAYED = CFG.replace("ImplicitActuatorCfg", "DelayedPDActuatorCfg").replace(
    "damping=1.5", "damping=1.5, max_delay=3"
)


@pytest.mark.parametrize("own", ["", "0.004"])
def test_steps_of_the_descriptors(folder: Path, own: str, capsys: pytest.CaptureFixture[str]) -> None:
    """IO_descriptors.yaml, named for the joints, states the step too: 3 of 5 ms are 15 ms, of an own 4 ms 12 ms."""
    env = f"\nclass E:\n    def __post_init__(self):\n        self.sim.dt = {own}\n        self.scene.robot = LEG_CFG\n"
    text = DELAYED + (
        f"from isaaclab.envs import ManagerBasedRLEnvCfg\n{env.replace('E:', 'E(ManagerBasedRLEnvCfg):')}"
    )
    (folder / "leg_cfg.py").write_text(text if own else DELAYED, encoding="utf-8")
    (folder / "io.yaml").write_text(IO_DESCRIPTORS, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", "io.yaml", "-o", "leg.yaml"]) == 0
    out, err = capsys.readouterr()
    assert "whose length no file states" not in out
    assert "from leg_cfg.py, io.yaml\n" in out
    spec = (folder / "leg.yaml").read_text("utf-8")
    assert ("range: [0 ms, 15 ms]" in spec, "range: [0 ms, 12 ms]" in spec) == (not own, bool(own))
    taken = (
        "physics_dt: {value: 4 ms, source: leg_cfg}" if own else "physics_dt: {value: 5 ms, source: io_cfg}"
    )
    # The control period of 20 ms stays: 4 x 5 ms, 5 x 4 ms.
    assert taken in spec and f"decimation: {5 if own else 4}\n" in spec
    assert ("physics_dt is 0.004 s here, which is used, and 0.005 s in io.yaml:" in err) == bool(own)
    assert main(["compile", "leg.yaml", "-t", "isaaclab", "-o", "out"]) == 0
    written = (folder / "out" / "isaaclab" / "leg_cfg.py").read_text("utf-8")
    assert "max_delay=3," in written and "DelayedPDActuatorCfg(" in written


@pytest.mark.parametrize(
    "steps", ["{decimation: 4}", "{physics_dt: fast}", "{physics_dt: 0}", "[0.005]", "{physics_dt: .inf}"]
)
def test_descriptors_without_a_step(folder: Path, steps: str, capsys: pytest.CaptureFixture[str]) -> None:
    """What is no step leaves the delay unknown."""
    (folder / "leg_cfg.py").write_text(DELAYED, encoding="utf-8")
    text = f"{IO_DESCRIPTORS.partition('scene:')[0]}scene: {steps}\n"
    (folder / "io.yaml").write_text(text, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", "io.yaml", "-o", "leg.yaml"]) == 0
    assert "0 to 3 physics steps, whose length no file states" in capsys.readouterr().out


def test_a_network_elsewhere(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A network that is not here is told with its name, in the spec and at import."""
    (folder / "leg_cfg.py").write_text(NETWORK, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", ",".join(NAMES), "-o", "leg.yaml"]) == 0
    told = "its network is not here: put /far/away/drive.pt at drive.pt, from the spec's folder"
    assert told in capsys.readouterr().out
    assert f"# {told}" in (folder / "leg.yaml").read_text("utf-8")


MLP = NETWORK.replace("LSTM", "MLP").replace(
    '"/far/away/drive.pt"',
    '"nets/drive.pt", pos_scale=-1.0, vel_scale=0.5, torque_scale=2.0, input_order="vel_pos", input_idx=[0, 2, 4],\n'
    "            saturation_effort=30.0, velocity_limit=9.0",
)
"""Numbers that differ from each other, and from those of no scale."""


def test_what_a_configuration_states_of_its_network(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The lines of a manifest are told; saved under that name they serve Isaac Lab, and the spec says so anew."""
    (folder / "leg_cfg.py").write_text(MLP, encoding="utf-8")
    (folder / "io.yaml").write_text(
        f"joint_names: [{', '.join(NAMES)}]\nscene: {{physics_dt: 0.005}}\n", "utf-8"
    )
    command = ["import", "leg_cfg.py", "--joints", "io.yaml", "-o", "leg.yaml", "--force"]
    assert main(command) == 0
    out = capsys.readouterr().out
    start = "its manifest: save as nets/drive.json, and name it as network.manifest, what the configuration states, "
    (told,) = [line.partition(start)[2] for line in out.splitlines() if start in line]
    stated, end = json.JSONDecoder().raw_decode(told)
    assert told[end:] == ""
    # vel_pos; error and velocity times -1 and 0.5, the output times 2; samples of now, 2 and 4 steps of 5 ms ago.
    assert stated == {
        "format": "actspec-network/1",
        "kind": "mlp",
        "inputs": "velocity_position",
        "taps": [0, 2, 4],
        "tap_period": "5 ms",
        "position_scale": -1,
        "velocity_scale": 0.5,
        "torque_scale": 2,
        "initial_history": "zero",
    }
    (folder / "nets").mkdir()
    (folder / "nets" / "drive.json").write_text(told, encoding="utf-8")
    with zipfile.ZipFile(folder / "nets" / "drive.pt", "w") as archive:
        archive.writestr("drive/constants.pkl", "")
        archive.writestr("drive/code/net.py", "")
    assert main(command) == 0
    network = load_spec("leg.yaml").model.actuators["legs"].network
    assert network is not None and (network.file, network.manifest) == ("nets/drive.pt", "nets/drive.json")
    assert main(["compile", "leg.yaml", "-t", "isaaclab", "-o", "out"]) == 0
    written = (folder / "out" / "isaaclab" / "leg_cfg.py").read_text("utf-8")
    for field in (
        "pos_scale=-1.0",
        "vel_scale=0.5",
        "torque_scale=2.0",
        'input_order="vel_pos"',
        "[0, 2, 4]",
    ):
        assert field in written


def test_what_it_does_not_state(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A scale that is not known and a step that no file states are named, and nothing is put in their place."""
    (folder / "leg_cfg.py").write_text(
        MLP.replace("vel_scale=0.5", "vel_scale=elsewhere()"), encoding="utf-8"
    )
    assert main(["import", "leg_cfg.py", "--joints", ",".join(NAMES), "-o", "leg.yaml"]) == 0
    out = capsys.readouterr().out
    assert '"tap_period": "unknown"' in out and '"velocity_scale"' not in out
    assert (
        "and what it does not: velocity_scale; tap_period is the physics step of its training, which" in out
    )


def test_an_lstm_states_its_inputs(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Isaac Lab's class feeds it error and velocity of now, unscaled; where its file lies is not known here."""
    text = NETWORK.replace('"/far/away/drive.pt"', "elsewhere()")
    (folder / "leg_cfg.py").write_text(text, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", ",".join(NAMES), "-o", "leg.yaml"]) == 0
    out = capsys.readouterr().out
    assert '"kind": "lstm", "inputs": "position_velocity", "taps": [0]' in out
    assert '"position_scale": 1, "velocity_scale": 1, "torque_scale": 1' in out
    assert "where its network lies could not be read: write its path as network.file" in out


def test_what_stops_every_target(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Without a gain for MuJoCo and a limit for Isaac Lab a compile stops: import says so, and what to state."""
    (folder / "leg_cfg.py").write_text(
        WITHOUT_KNEES.replace("damping=1.5", "damping=elsewhere()"), encoding="utf-8"
    )
    assert main(["import", "leg_cfg.py", "--joints", ",".join(NAMES), "-o", "leg.yaml"]) == 0
    out = capsys.readouterr().out
    assert "\n  compile stops until that is mended: ISL010: " in out and "(state effort_limit)" in out
    assert main(["compile", "leg.yaml", "-o", "out"]) == 2
    assert "ISL010" in capsys.readouterr().err


def test_a_lag_without_a_step_is_said_once(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """It is stated, in steps: the spec has `unknown`, and nothing says that no file states it."""
    text = CFG.replace("ImplicitActuatorCfg", "DelayedPDActuatorCfg").replace(
        "damping=1.5", "damping=1.5, max_delay=4"
    )
    (folder / "leg_cfg.py").write_text(text, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", ",".join(NAMES), "-o", "leg.yaml"]) == 0
    out = capsys.readouterr().out
    assert (
        "delay: 0 to 4 physics steps, whose length no file states" in out
        and "no file states delay" not in out
    )
    assert "    delay: unknown    # 0 to 4 physics steps" in (folder / "leg.yaml").read_text("utf-8")


def test_without_it_the_message_names_it(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Where the joints are, and how to name them."""
    assert main(["import", "leg_cfg.py"]) == 2
    said = capsys.readouterr().err
    assert "DRF009: LEG_CFG selects its joints by patterns (.*_hip, .*_knee)" in said
    assert "they stand in /far/away/leg.usd\n" in said and "--joints a,b,c" in said


def test_the_file_that_a_legged_gym_configuration_reads(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is named where it lies in the tree, with the path to type; else as the configuration has it."""
    text = """
class LegCfg(LeggedRobotCfg):
    class asset(LeggedRobotCfg.asset):
        file = '{LEGGED_GYM_ROOT_DIR}/resources/leg/leg.urdf'
    class control(LeggedRobotCfg.control):
        stiffness = {'hip': 40., 'knee': 60.}
        damping = {'hip': 1., 'knee': 2.}
"""
    (folder / "legged_gym/envs/leg").mkdir(parents=True)
    (folder / "legged_gym/envs/leg/leg_config.py").write_text(text, encoding="utf-8")
    assert main(["import", "legged_gym/envs/leg/leg_config.py"]) == 2
    said = capsys.readouterr().err
    assert "no file names them: they stand in {LEGGED_GYM_ROOT_DIR}/resources/leg/leg.urdf\n" in said
    assert "--joints FILE (a URDF, any file that names them)" in said
    (folder / "resources/leg").mkdir(parents=True)
    (folder / "resources/leg/leg.urdf").write_text(URDF, encoding="utf-8")
    assert main(["import", "legged_gym/envs/leg/leg_config.py"]) == 2
    assert "  help: name resources/leg/leg.urdf too, which it reads\n" in capsys.readouterr().err
    assert main(["import", "legged_gym/envs/leg/leg_config.py", "resources/leg/leg.urdf"]) == 0


@pytest.mark.parametrize(
    "name, text, said, joints",
    [
        ("", ",".join(NAMES), "the names of the 4 joints are from the list (--joints)", NAMES),
        ("j.txt", "# of the robot\nleft_hip, right_hip\nleft_knee\nright_knee\n", "from j.txt", NAMES),
        ("n.txt", "0: left_hip\n1: right_hip\n- left_knee\n 3. right_knee\n", "from n.txt", NAMES),
        ("io.yaml", IO_DESCRIPTORS, "the names of the 5 joints are from io.yaml", [*NAMES, "head"]),
        ("io.json", json.dumps({"joint_names": NAMES}), "from io.json", NAMES),
        ("j.yaml", json.dumps(NAMES), "from j.yaml", NAMES),
        ("d.yaml", f"joint_names: {json.dumps(NAMES)}\nkp: [1, 1, 1, 1]\nkd: [1, 1, 1, 1]\n", "d.yaml", NAMES),
        ("num.yaml", "joints: " + json.dumps(dict(enumerate(NAMES))), "from num.yaml", NAMES),
        ("m.json", json.dumps({"num": 4, "joints": [{"id": "a", "name": n} for n in NAMES]}), "from m.json", NAMES),
        ("t.csv", "joint index,name,limit\n" + "".join(f"{i},{n},1\n" for i, n in enumerate(NAMES)), "t.csv", NAMES),
        ("u.csv", '\ufeff"Joint";"Side"\r\n' + "".join(f'"{n}";"l"\r\n' for n in NAMES), "from u.csv", NAMES),
        ("g.csv", "Gelenk;Moment [Nm];Untersetzung\n" + "".join(f"{n};24,5;6,33\n" for n in NAMES), "g.csv", NAMES),
        ("o.csv", "".join(f"{n};24,5;6,33\n" for n in NAMES), "from o.csv", NAMES),
        ("o.tsv", "".join(f"{n}\t24,5\t6,33\n" for n in NAMES), "from o.tsv", NAMES),
        ("t.md", "# Leg\n\n| # | **Joint** | Torque [Nm] |\n|---|:---|---:|\n"
            + "".join(f"| {i} | `{n}` | 24.5 |\n" for i, n in enumerate(NAMES)), "from t.md", NAMES),
        ("i.csv", "id,label\n" + "".join(f"{i},{n}\n" for i, n in enumerate(NAMES)), "4 joints are from i.csv", NAMES),
        ("b.txt", "".join(f"{i} {n}\n" for i, n in enumerate(NAMES)), "the 4 joints are from b.txt", NAMES),
        ("s.csv", "".join(f"{n},{n[0]},{i}.5\n" for i, n in enumerate(NAMES)), "4 joints are from s.csv", NAMES),
        ("h.csv", "DOF name\n" + "\n".join(NAMES), "the 4 joints are from h.csv", NAMES),
        ("two.txt", "left_hip, right_hip\nleft_knee, right_knee\n", "the 4 joints are from two.txt", NAMES),
        ("d.txt", "\n".join([*NAMES, "1"]), "the names of the 5 joints are from d.txt", [*NAMES, "1"]),
        ("names.lst", "\n".join(NAMES), "the names of the 4 joints are from names.lst", NAMES),
        ("names", f"{NAMES}\n", "the names of the 4 joints are from names", NAMES),
        ("p.txt", f"Joint names: {NAMES}\n", "from p.txt", NAMES),
        ("i.txt", f"[INFO]: Joint names: {NAMES}\n", "from i.txt", NAMES),
        ("q.txt", "".join(f'"{n}",\n' for n in NAMES), "from q.txt", NAMES),
        ("pos.csv", "t," + ",".join(f"{n}_{s}" for n in NAMES for s in ("pos", "vel")) + "\n" + ",".join("0" * 9),
            "from pos.csv", NAMES),
        ("log.csv", "time [s]," + ",".join(f"{n}.{s} [x]" for n in NAMES for s in ("position", "torque"))
            + ",base.position.x [m]\n" + ",".join("0" * 10) + "\n", "from log.csv", NAMES),
        ("head.csv", ",".join(NAMES) + "\n0,0,0,0\n0.5,0,0,-1e-3\n", "from head.csv", NAMES),
        ("k.yaml", "rate: {hz: 50}\njoints:\n" + "".join(f"  {n}: {{lower: -1}}\n" for n in NAMES), "k.yaml", NAMES),
        ("c.py", f"LEG_JOINT_NAMES = {NAMES}\nOTHER = ['left_hip']\n", "from c.py", NAMES),
        ("d.py", f"class Cfg:\n    joint_names: list[str] = {NAMES}\n", "from d.py", NAMES),
        ("j.toml", f"[robot]\njoint_names = {NAMES}\n", "from j.toml", NAMES),
        ("n.ipynb", json.dumps({"cells": [{"source": [], "outputs": [{"text": [str(NAMES)]}]}]}), "n.ipynb", NAMES),
        ("q.csv", ",".join(f"q_{n}" for n in NAMES) + "\n0,0,0,0\n",
            "the 4 joints are from q.csv (--joints), without the beginning q_", NAMES),
        ("prim.txt", "".join(f"/World/dog/joints/{n}\n" for n in NAMES),
            "the 4 joints are from prim.txt (--joints), without the path /World/dog/joints/", NAMES),
        ("p.yaml", json.dumps({"joint_names": [f"dog/{n}" for n in NAMES]}),
            "the 4 joints are from p.yaml (--joints), without the path dog/", NAMES),
        ("", ",".join(f"/World/{n}" for n in NAMES), "from the list (--joints), without the path /World/", NAMES),
        (
            "leg.urdf",
            URDF,
            "the names, kinds and ranges of the 4 joints are from leg.urdf",
            NAMES,
        ),
    ],
    ids=[
        *("list", "text", "numbered", "IO_descriptors", "JSON", "bare list", "deploy file", "by number", "mappings"),
        *("CSV", "semicolons", "commas in numbers", "no heads", "tabs", "Markdown"),
        *("numbers", "blanks", "sides", "one column", "two lines", "a number a line"),
        "any ending",
        *("printed", "printed behind words", "in a log", "quoted", "columns of signals"),
        *("recording", "heads", "keys", "constant", "constant of a class", "TOML", "notebook"),
        *("a signal", "prims", "an entity", "typed prims", "URDF"),
    ],
)  # fmt: skip
def test_a_spec_that_compiles(
    folder: Path,
    name: str,
    text: str,
    said: str,
    joints: list[str],
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Any file with the names will do; of several lists in it that on which the patterns match most."""
    if name:
        (folder / name).write_text(text, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", name or text, "-o", "leg.yaml"]) == 0
    assert said in capsys.readouterr().out
    model = load_spec("leg.yaml").model
    assert said in (folder / "leg.yaml").read_text(encoding="utf-8")
    assert model.robot.model == "none"
    found = []
    for joint in model.robot.joints or ():
        found.append(joint if isinstance(joint, str) else joint.name)
        if name == "leg.urdf":
            assert not isinstance(joint, str) and joint.range is not None
            assert joint.kind == ("slide" if "knee" in joint.name else "hinge")
    assert found == joints
    assert main(["compile", "leg.yaml", "-o", "out"]) == 0
    # Of the knees the URDF says that they slide; its limit of 9 does not count: it is asked for joints alone.
    written = (folder / "out" / "isaaclab" / "leg_cfg.py").read_text(encoding="utf-8")
    assert "40.0" in written and "50.0" in written and "24.0" in written and "9.0" not in written


@pytest.mark.parametrize(
    "argument, text, message",
    [
        ("a,b", "", "none of its joints is selected by .*_hip, .*_knee"),
        (".*_hip,.*_knee", "", ".*_hip is a pattern, and names are needed"),
        ("left_hip,left_hip", "", "left_hip stands there twice\n  help: a URDF, an MJCF, "),
        (" ,", "", "no name of a joint is in it"),
        ("missing.urdf", "", "there is no such file"),
        ("missing.yaml", "", "there is no such file"),
        ("leg.usd", "PXR", "USD is not read for names of joints"),
        ("other.yaml", "a: 1\nb: [1, 2]\n", "no list of joint names is in it"),
        (
            "two.json",
            '{"joints": [{"name": "left_hip"}, {"id": "left_knee"}]}',
            "no list of joint names is in it",
        ),
        ("head.csv", "index,name\n", "no name of a joint is in it"),
        (
            "two.csv",
            "id,a,b\n0,left_hip,x\n1,left_knee,y\n",
            "which of its columns has the names is not told",
        ),
        (
            "act.md",
            "# Leg\n\n| Drive | Nm |\n|---|---|\n| left_hip | 24 |\n",
            "act.md:3: DRF011 --joints: it has a table, and",
        ),
        (
            "lr.md",
            "| Joint | Nm |\n|---|---|\n| hip (l/r) | 24 |\n",
            "no column headed `name` or `joint` with names alone",
        ),
        ("id.txt", "id dof label\n0 left_hip\n", "id.txt:2: DRF011 --joints: 0 is a number beside names"),
        ("log.txt", "\n[INFO] hi\n", "log.txt:2: DRF011 --joints: [INFO] is no name of a joint"),
        (
            "none.py",
            "x = 1\n",
            "none.py: DRF011 --joints: no list of joint names is in it\n  help: let one list be",
        ),
        ("gone.toml", "", "gone.toml': there is no such file"),
        (
            "big.txt",
            "".join(f"j{i}_hip\n" for i in range(2001)),
            "has 2001 names of joints, at most 2000 are read",
        ),
        ("loop.yaml", "a: &a [*a]\n", "no list of joint names is in it"),
        (
            "many.log",
            "".join(f"joints: ['l{i}_hip', 'r{i}_hip']\n" for i in range(10_001)),
            "has 20002 names of joints in all of its lists, at most 20000 are read",
        ),
        ("broken.yaml", "a: [", "it is not YAML"),
        ("leg_cfg.py", "", "no list of joint names is in it"),
        (
            "two.py",
            "A_JOINT_NAMES = ['left_hip']\nB_JOINT_NAMES = ['left_knee']\n",
            "which of its lists has the joints is not told: A_JOINT_NAMES, B_JOINT_NAMES\n  help: let one list be",
        ),
        ("folder", "", "cannot be read: it has no file that ends in .xml, "),
        ("leg.stl", "solid\0\1", "is no text"),
        ("leg", "<robot", "cannot be read: "),
        ("a,b", "", "help: its joints: a, b\n"),
        ("left_hip_joint,head", "", "the ending _joint alone, which a USD may lack"),
        ("LEFT_HIP,head", "", "they differ from the configuration's by capital letters alone"),
    ],
)
def test_what_names_none(
    folder: Path, argument: str, text: str, message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """What is wrong is said of the option, and nothing is written."""
    (folder / "folder").mkdir()
    if text:
        (folder / argument).write_text(text, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", argument, "-o", "leg.yaml"]) == 2
    said = capsys.readouterr()
    assert "DRF011" in said.err and "--joints" in said.err and message in said.err
    assert said.out == "" and not (folder / "leg.yaml").exists()


def test_a_long_list_is_refused(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """200,000 lines took more than five minutes: every name was counted in all others."""
    (folder / "log.txt").write_text("".join(f"j{i}_hip\n" for i in range(200_000)), encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", "log.txt"]) == 2
    assert "has 200000 names of joints, at most 2000 are read" in capsys.readouterr().err


@pytest.mark.parametrize(
    "text",
    [
        # A key whose text has 10^8 entries.
        "".join(f"a{i}: &a{i} [{', '.join([f'*a{i - 1}' if i else 'x'] * 10)}]\n" for i in range(9))
        + "? *a8\n: 1\n",
        # 20,000 values, 5000 times.
        f"n: &n [{'x, ' * 20_000}]\n" + "".join(f"b{i}: {{c: *n}}\n" for i in range(5000)),
    ],
    ids=["a key", "aliases"],
)
def test_aliases_of_aliases(folder: Path, text: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Each of them took minutes, or all memory."""
    (folder / "laughs.yaml").write_text(text, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", "laughs.yaml"]) == 2
    assert "no list of joint names is in it" in capsys.readouterr().err


def test_a_beginning_that_the_patterns_have_stays(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Joints that are called `q_hip` are so called where the configuration says it."""
    cfg = CFG.replace('[".*_hip", ".*_knee"]', '["q_.*_hip", "q_.*_knee"]').replace(".*_", "q_.*_")
    (folder / "leg_cfg.py").write_text(cfg.replace("q_q_", "q_"), encoding="utf-8")
    assert (
        main(["import", "leg_cfg.py", "--joints", ",".join(f"q_{n}" for n in NAMES), "-o", "leg.yaml"]) == 0
    )
    assert "without" not in capsys.readouterr().out
    assert load_spec("leg.yaml").model.robot.joints == tuple(f"q_{n}" for n in NAMES)


def test_a_folder(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Of its files that one counts on whose joints most patterns match, and it is named."""
    (folder / "robots" / "a").mkdir(parents=True)
    (folder / "robots" / "a" / "leg.urdf").write_text(URDF, encoding="utf-8")
    (folder / "robots" / "arm.urdf").write_text(URDF.replace("_knee", "_elbow"), encoding="utf-8")
    said = f"the names, kinds and ranges of the 4 joints are from {Path('robots/a/leg.urdf')} (--joints)"
    for named in ("robots", "robots/", "./robots"):
        assert main(["import", "leg_cfg.py", "--joints", named, "-o", "leg.yaml", "--force"]) == 0
        assert said in capsys.readouterr().out
        assert said in (folder / "leg.yaml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("pose", "gain", "file"),
    [
        pytest.param("", "40.0", "long.yaml", id="the longest, where nothing tells"),
        pytest.param('".*_knee": 0.1', "40.0", "short.yaml", id="one list has a knee"),
        pytest.param('".*_elbow": 0.1', "40.0", "long.yaml", id="one has elbows, and a waist"),
        pytest.param("", '{".*_hip": 40.0, ".*_knee": 50.0}', "short.yaml", id="gains of a knee"),
        pytest.param('"left_.*": 0.1', "40.0", "long.yaml", id="of both, and neither all"),
        pytest.param('"left_.*|right_.*": 0.1', "40.0", "short.yaml", id="a waist has no key"),
    ],
)
def test_a_folder_of_robots_that_one_pattern_fits(
    folder: Path, pose: str, gain: str, file: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """`.*` fits both; what keys of pose and gains are for tells which list is the robot's."""
    cfg = CFG.replace('".*_hip", ".*_knee"]', '".*"]').replace('{".*_hip": 40.0, ".*_knee": 50.0}', gain)
    cfg = cfg.replace(
        "    actuators",
        f"    init_state=ArticulationCfg.InitialStateCfg(joint_pos={{{pose}}}),\n    actuators",
    )
    (folder / "leg_cfg.py").write_text(cfg, encoding="utf-8")
    (folder / "lists").mkdir()
    for name, joints in {
        "short": NAMES,
        "long": ["left_hip", "right_hip", "left_elbow", "right_elbow", "waist"],
    }.items():
        gains = [1.0] * len(joints)
        text = f"joint_names: {json.dumps(joints)}\nkp: {gains}\nkd: {gains}\n"
        (folder / "lists" / f"{name}.yaml").write_text(text, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", "lists", "-o", "leg.yaml"]) == 0
    assert f"joints are from {Path('lists') / file} (--joints)" in capsys.readouterr().out


@pytest.mark.parametrize(("count", "file"), [(2, "whole.yaml"), (3, "part.yaml")])
def test_a_folder_with_a_part_of_the_robot(
    folder: Path, count: int, file: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of six joints two are a part of the robot, though the pose has a key for each of them; three may be a robot."""
    part = NAMES[:count]
    pose = json.dumps(dict.fromkeys(part, 0.1))
    cfg = CFG.replace('".*_hip", ".*_knee"]', '".*"]').replace('{".*_hip": 40.0, ".*_knee": 50.0}', "40.0")
    cfg = cfg.replace(
        "    actuators", f"    init_state=ArticulationCfg.InitialStateCfg(joint_pos={pose}),\n    actuators"
    )
    (folder / "leg_cfg.py").write_text(cfg, encoding="utf-8")
    (folder / "lists").mkdir()
    for name, joints in {"part": part, "whole": [*NAMES, "grip", "tail"]}.items():
        text = f"joint_names: {json.dumps(joints)}\nkp: {[1.0] * len(joints)}\nkd: {[1.0] * len(joints)}\n"
        (folder / "lists" / f"{name}.yaml").write_text(text, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", "lists", "-o", "leg.yaml"]) == 0
    assert f"joints are from {Path('lists') / file} (--joints)" in capsys.readouterr().out


_LONGER = URDF.replace("upper='1'", "upper='1.5'")


def _robots(folder: Path, files: dict[str, str]) -> None:
    for name, text in files.items():
        (folder / "robots" / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / "robots" / name).write_text(text, encoding="utf-8")


@pytest.mark.parametrize(
    ("called", "asset", "files", "file"),
    [
        pytest.param("GO2_CFG", "far/x.usd", ("a1/a1.urdf", "go2/go2.urdf"), "go2/go2.urdf", id="its name"),
        pytest.param(
            "LEG_CFG", "Go2/go2.usd", ("a1/a1.urdf", "go2/go2.urdf"), "go2/go2.urdf", id="its asset"
        ),
        pytest.param("LEG_CFG", "Go2/r.usd", ("a1/a1.urdf", "go2/b.urdf"), "go2/b.urdf", id="folders"),
        pytest.param(
            "GO2_CFG", "r.usd", ("a1/urdf/r.urdf", "go2/urdf/r.urdf"), "go2/urdf/r.urdf", id="far folder"
        ),
        pytest.param(
            "SPOT_CFG", "x.usd", ("alma.urdf", "spot.urdf"), "spot.urdf", id="words without numbers"
        ),
        pytest.param("GO2_CFG", "x.usd", ("a1.urdf", "leg.urdf"), "leg.urdf", id="no other robot's"),
        pytest.param(
            "G1_5DOF_CFG", "x.usd", ("g1_4dof.urdf", "g1_5dof.urdf"), "g1_5dof.urdf", id="its number"
        ),
        pytest.param(
            "G1_CFG", "g1_rev2.usd", ("g1.urdf", "g1_rev2.urdf"), "g1_rev2.urdf", id="the asset's file"
        ),
    ],
)
def test_a_folder_of_robots_with_the_same_joints(
    folder: Path,
    called: str,
    asset: str,
    files: tuple[str, str],
    file: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The one that is called as the robot or its asset has its ranges; it was the first of the alphabet."""
    cfg = CFG.replace("LEG_CFG", called).replace("/far/away/leg.usd", asset)
    (folder / "cfg.py").write_text(cfg, encoding="utf-8")
    _robots(folder, dict(zip(files, (URDF, _LONGER), strict=True)))
    assert main(["import", "cfg.py", "--joints", "robots", "-o", "leg.yaml"]) == 0
    assert f"joints are from {Path('robots') / file} (--joints)" in capsys.readouterr().out
    # The ranges are that file's: up to 1.5 in the second one, which is every one here.
    assert "1.5 rad" in (folder / "leg.yaml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("called", "files", "why"),
    [
        pytest.param(
            "LEG_CFG",
            ("a1.urdf", "go2.urdf"),
            "which of its files is the robot's is not told, and their joints differ: robots/a1.urdf, robots/go2.urdf",
            id="nothing tells",
        ),
        pytest.param(
            "G1_CFG",
            ("g1_4dof.urdf", "g1_5dof.urdf"),
            "which of its files is the robot's is not told, and their joints differ: robots/g1_4dof.urdf, "
            "robots/g1_5dof.urdf",
            id="two of the robot",
        ),
        pytest.param(
            "GO1_CFG",
            ("a1.urdf", "go2.urdf"),
            "all of its files with these joints are called as other robots: robots/a1.urdf, robots/go2.urdf",
            id="other robots",
        ),
    ],
)
def test_nothing_tells_which_of_a_folders_files(
    folder: Path, called: str, files: tuple[str, str], why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """Ranges of another robot are never taken: the user names the file, which is taken whatever it is called."""
    (folder / "cfg.py").write_text(CFG.replace("LEG_CFG", called), encoding="utf-8")
    _robots(folder, dict(zip(files, (URDF, _LONGER), strict=True)))
    assert main(["import", "cfg.py", "--joints", "robots", "-o", "leg.yaml"]) == 2
    said = capsys.readouterr().err.replace("\\", "/")
    assert f"robots: DRF011 --joints: {why}\n  help: name the file of the robot: --joints FILE\n" in said
    assert not (folder / "leg.yaml").exists()
    assert main(["import", "cfg.py", "--joints", f"robots/{files[0]}", "-o", "leg.yaml"]) == 0
    assert f"joints are from {files[0]} (--joints)" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("files", "why"),
    [
        pytest.param(
            ["spot.urdf"],
            ", the only file there with joints, which is not called as the configuration\n",
            id="another name",
        ),
        pytest.param(["go2.urdf"], "\n", id="its name"),
        pytest.param(["spot.urdf", "robot.urdf"], "\n", id="two with the same joints"),
    ],
)
def test_the_only_file_of_a_folder(
    folder: Path, files: list[str], why: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """It is taken whatever it is called, and that its name does not say whose it is is told."""
    (folder / "cfg.py").write_text(CFG.replace("LEG_CFG", "GO2_CFG"), encoding="utf-8")
    _robots(folder, dict.fromkeys(files, URDF))
    assert main(["import", "cfg.py", "--joints", "robots", "-o", "leg.yaml"]) == 0
    assert f" (--joints){why}" in capsys.readouterr().out
    # Named itself it is the robot's.
    assert main(["import", "cfg.py", "--joints", f"robots/{files[0]}", "-o", "leg.yaml", "--force"]) == 0
    assert " (--joints)\n" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("file", "text"),
    [
        ("a.csv", "left_hip;24,5\nright_hip;\nleft_knee;24,5\nright_knee;24,5\n;\n"),
        ("a.yaml", "joints:\n" + "".join(f"  {at}: {{name: {name}}}\n" for at, name in enumerate(NAMES))),
    ],
    ids=["empty figure", "names in mappings by number"],
)
def test_names_beside_what_is_left_out(
    folder: Path, file: str, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """All four names are read."""
    (folder / file).write_text(text, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", file]) == 0
    assert f"  the names of the 4 joints are from {file} (--joints)" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("file", "text", "said"),
    [
        (
            "a.csv",
            "left_hip;24,5\n;24,5\nleft_knee;24,5\n",
            "a.csv: DRF011 --joints: a row of its table has no name",
        ),
        (
            "a.yaml",
            "base: &b {0: left_hip}\njoints:\n  <<: *b\n  1: left_knee\n",
            "a.yaml:3:3: DRF011 --joints: its names by number are not from 0 or 1 on, each once and written out",
        ),
        (
            "b.yaml",
            "joints: {0: {name: left_hip}, 2: {name: left_knee}}\n",
            "b.yaml:1:9: DRF011 --joints: its names by number are not from 0 or 1 on, each once and written out",
        ),
    ],
    ids=["no name", "merge", "gap"],
)
def test_a_name_that_is_missing(
    folder: Path, file: str, text: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A list without one of the robot's joints is none, and the fault is named."""
    (folder / file).write_text(text, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", file]) == 2
    assert said in capsys.readouterr().err


def test_a_robot_that_is_called_as_its_kind(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """`leg` is a name, too, whatever the project's folder is called."""
    (folder / "hopper").mkdir()
    (folder / "hopper" / "leg_cfg.py").write_text(CFG, encoding="utf-8")
    (folder / "hopper" / "leg").mkdir()
    (folder / "hopper" / "leg" / "leg.urdf").write_text(URDF, encoding="utf-8")
    assert main(["import", "hopper/leg_cfg.py", "--joints", "hopper/leg"]) == 0
    assert f" are from {Path('leg') / 'leg.urdf'} (--joints)\n" in capsys.readouterr().out


def test_files_of_a_submodule_that_is_not_checked_out(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The command that gets them is said, as the audit says it."""
    (folder / ".gitmodules").write_text('[submodule "m"]\n\tpath = robots\n', encoding="utf-8")
    (folder / "robots").mkdir()
    why = "'robots' is a git submodule that is not checked out"
    for named, said in (
        (["robots/leg.urdf"], f"robots/leg.urdf: DRF004: there is no such file: {why}"),
        (["robots"], f"robots: DRF004: {why}"),
        (["leg_cfg.py", "--joints", "robots/leg.urdf"], f"'robots/leg.urdf': there is no such file: {why}"),
    ):
        assert main(["import", *named]) == 2
        assert f"{said}\n  help: git submodule update --init robots\n" in capsys.readouterr().err
    (folder / "robots" / "a.urdf").write_text(URDF, encoding="utf-8")
    assert main(["import", "robots/leg.urdf"]) == 2
    assert "submodule" not in capsys.readouterr().err


def test_files_with_the_same_joints_are_one_robots(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Copies, and ranges in fewer digits (1.57 of 1.5708), are no reason to refuse a folder."""
    (folder / "cfg.py").write_text(CFG, encoding="utf-8")
    quarter, rounded = (URDF.replace("upper='1'", f"upper='{end}'") for end in ("1.5708", "1.57"))
    _robots(folder, {"one.urdf": quarter, "two.urdf": rounded})
    assert main(["import", "cfg.py", "--joints", "robots", "-o", "leg.yaml"]) == 0
    assert f"joints are from {Path('robots') / 'one.urdf'} (--joints)" in capsys.readouterr().out


WITH_ENDING = URDF.replace("_hip'", "_hip_joint'").replace("_knee'", "_knee_joint'")


@pytest.mark.parametrize(
    "cfg, urdf, how, ending",
    [
        (CFG, WITH_ENDING, "without", ""),
        (CFG.replace("_hip", "_hip_joint").replace("_knee", "_knee_joint"), URDF, "with", "_joint"),
    ],
)
def test_a_urdf_of_other_endings(
    folder: Path, cfg: str, urdf: str, how: str, ending: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """As Isaac Lab's H1 and its URDF: the joints are called as the patterns have them, and import says so."""
    (folder / "leg_cfg.py").write_text(cfg, encoding="utf-8")
    (folder / "leg.urdf").write_text(urdf, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "leg.urdf"]) == 2
    assert "by --joints leg.urdf, which takes them as" in capsys.readouterr().err
    assert main(["import", "leg_cfg.py", "--joints", "leg.urdf", "-o", "leg.yaml"]) == 0
    out, err = capsys.readouterr()
    said = f"joints are from leg.urdf (--joints), {how} the ending _joint, as the configuration's patterns"
    written = " ".join((folder / "leg.yaml").read_text("utf-8").replace("\n  # ", " ").split())
    assert said in out and said in written and "DRF012" not in err
    joints = load_spec("leg.yaml").model.robot.joints or ()
    assert [joint if isinstance(joint, str) else joint.name for joint in joints] == [
        n + ending for n in NAMES
    ]
    assert main(["compile", "leg.yaml", "-o", "out"]) == 0


def test_endings_stay_where_patterns_have_them(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """One pattern that selects joints as they are called decides, where the others would select none otherwise."""
    urdf = WITH_ENDING.replace("_hip_joint'", "_hip'").replace("left_knee_joint'", "other_joint'")
    (folder / "leg_cfg.py").write_text(CFG.replace("_knee", "_knee_x"), encoding="utf-8")
    (folder / "leg.urdf").write_text(urdf, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", "leg.urdf", "-o", "leg.yaml"]) == 0
    out, err = capsys.readouterr()
    assert "the ending" not in out and "DRF012" in err
    assert "right_knee_joint" in (folder / "leg.yaml").read_text("utf-8")


def test_beside_a_robot_file(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A robot file names the joints itself: the option is refused, so that nobody thinks that it counts."""
    (folder / "leg.urdf").write_text(URDF, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "leg.urdf", "--joints", "left_hip"]) == 2
    assert "leg.urdf: DRF011 --joints: not needed: the robot file names the joints" in capsys.readouterr().err


def test_what_the_configuration_states_in_vain(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A limit that an implicit drive ignores is told, and a pose that cannot be read is none that nobody states."""
    cfg = CFG.replace("damping=1.5", "damping=1.5, velocity_limit=10.0").replace(
        "    actuators={", "    init_state=ArticulationCfg.InitialStateCfg(joint_pos=HOME),\n    actuators={"
    )
    (folder / "leg_cfg.py").write_text(f"from my_lab import HOME\n{cfg}", encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", ",".join(NAMES)]) == 0
    text, said = capsys.readouterr()
    assert "velocity_limit 10 is left out: an implicit drive ignores it" in said
    assert (
        "    # pose at zero action, by pattern; HOME comes from my_lab, which is not beside this file\n"
        in text
    )
    enforced = cfg.replace("velocity_limit=", "velocity_limit_sim=").replace("=HOME", '={".*": 0.0}')
    (folder / "leg_cfg.py").write_text(enforced, encoding="utf-8")
    assert main(["import", "leg_cfg.py", "--joints", ",".join(NAMES)]) == 0
    text, said = capsys.readouterr()
    assert "is left out: an implicit" not in said and "velocity_limit: {value: 10 rad/s" in text
    assert "    # pose at zero action, by pattern; stated as 0\n" in text


DEPLOY = "joint_names: [left_hip, left_knee]\nkp: [25, 20]\nkd: [1, 2]\n"


@pytest.mark.parametrize(
    "joints, said",
    [
        ("left_hip,left_knee", "wrote leg.yaml: 2 joints in 1 group (legs), from deploy.yaml\n"),
        ("deploy.yaml", "  the names of the 2 joints are from deploy.yaml (--joints)\n"),
        ("left_hip,left_knee,head", "  unmanaged, no group of the configuration selects it: head\n"),
        (
            "left_hip",
            "deploy.yaml:2:10: DRF012 [warning]: `left_knee` of deploy is not among --joints\n"
            "  help: its numbers are left out\n",
        ),
    ],
    ids=["list", "itself", "one more", "one less"],
)
def test_of_a_deploy_file(folder: Path, capsys: pytest.CaptureFixture[str], joints: str, said: str) -> None:
    """Alone it selects its joints by their names, as a configuration does by patterns."""
    (folder / "deploy.yaml").write_text(DEPLOY, encoding="utf-8")
    assert main(["import", "deploy.yaml", "--joints", joints, "-o", "leg.yaml"]) == 0
    assert said in "".join(capsys.readouterr())
    text = (folder / "leg.yaml").read_text("utf-8")
    assert "{value: 25 N*m/rad, source: deploy}" in text
    assert ("20 N*m/rad" in text) is (joints != "left_hip")


def test_of_a_deploy_file_without_names(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """--joints gives no order: lists of unlike entries need names; of equal ones there are as many as joints."""
    deploy = folder / "deploy.yaml"
    deploy.write_text("kp: [25, 20, 30, 30]\nkd: [1, 2, 1, 1]\n", encoding="utf-8")
    assert main(["import", "deploy.yaml", "--joints", ",".join(NAMES)]) == 2
    err = capsys.readouterr().err
    assert "DRF011 --joints: no file selects joints: the lists of the deploy file have no names\n" in err
    assert "  help: add to it joint_names: [...] in the order of its lists\n" in err
    deploy.write_text("kp: [25, 25, 25, 25]\nkd: [1, 1, 1, 1]\n", encoding="utf-8")
    assert main(["import", "deploy.yaml", "--joints", ",".join(NAMES)]) == 0
    assert "kp: {value: 25 N*m/rad, source: deploy}" in capsys.readouterr().out


def test_one_cause_is_told_once(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """What cannot be read at one place is one line, whichever figures it is in."""
    groups = "".join(
        f'"{n}": ImplicitActuatorCfg(joint_names_expr=["{n}"], effort_limit=24.0, stiffness=KP[0], damping=1.0),'
        for n in NAMES
    )
    head = CFG[: CFG.index("LEG_CFG")]
    text = f"import numpy as np\n{head}KP = np.array([40.0])\nLEG_CFG = ArticulationCfg(actuators={{{groups}}})\n"
    (folder / "leg_cfg.py").write_text(text, encoding="utf-8")
    assert main(["import", "leg_cfg.py"]) == 0
    lines = [line for line in capsys.readouterr().err.splitlines() if "CFG001" in line]
    assert len(lines) == 1
    figures = ", ".join(f"{name}.stiffness" for name in NAMES)
    assert f"CFG001 [info] {figures}: not known without running it: calls array(): " in lines[0]


RUN = """sim: {dt: 0.005}
decimation: 4
scene:
  robot:
    class_type: isaaclab.assets.articulation.articulation:Articulation
    spawn: {usd_path: /far/away/leg.usd}
    SDK
    actuators:
      legs:
        class_type: isaaclab.actuators.actuator_pd:IdealPDActuator
        joint_names_expr: [.*_hip, .*_knee]
        effort_limit: 24.0
        stiffness: {.*_hip: 40.0, .*_knee: 50.0}
        damping: 1.5
rewards:
  deviation: {params: {asset_cfg: {joint_names: [.*_hip, .*_ankle]}}}
"""
SDK = "joint_sdk_names: [right_hip, right_knee, '', '', left_hip, left_knee]"


@pytest.mark.parametrize("joints", [[], ["--joints", "env.yaml"]])
def test_a_run_that_names_its_motors(
    joints: list[str], folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """unitree_rl_lab's has them for the robot's own order, with gaps: nothing else needs to name the joints."""
    Path("env.yaml").write_text(RUN.replace("SDK", SDK), encoding="utf-8")
    assert main(["import", "env.yaml", *joints, "-o", "leg.yaml"]) == 0
    of = "env.yaml (--joints)" if joints else "its joint_sdk_names"
    said = capsys.readouterr()
    assert f"  the names of the 4 joints are from {of}\n" in said.out and "DRF012" not in said.err
    robot = load_spec("leg.yaml").model.robot
    assert [str(one if isinstance(one, str) else one.name) for one in robot.joints or ()] == [
        "right_hip",
        "right_knee",
        "left_hip",
        "left_knee",
    ]


def test_a_run_with_unitrees_class(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its file has every field of the class, and the law is known by its name; of another class only its own file says.

    Hand: the solver clips the 23.4 N*m of braking at 22.
    """
    cls = "unitree_rl_lab.assets.robots.unitree_actuators:UnitreeActuator"
    own = "\n        ".join(("X1: 13.5", "X2: 30", "Y1: 20.2", "Y2: 23.4", "Fs: 0.2", "Fd: 0.0", "Va: 0.01"))
    text = RUN.replace("SDK", SDK).replace("isaaclab.actuators.actuator_pd:IdealPDActuator", cls)
    text = text.replace(
        "effort_limit: 24.0", f"effort_limit: null\n        effort_limit_sim: 22.0\n        {own}"
    )
    Path("env.yaml").write_text(text, encoding="utf-8")
    assert main(["import", "env.yaml", "-o", "leg.yaml"]) == 0
    motor = next(iter(load_spec("leg.yaml").model.motors.values()))
    curve = motor.curve
    assert curve is not None
    parts = (curve.drive_torque, curve.brake_torque, curve.knee_speed, curve.no_load_speed)
    assert [part.value for part in parts] == [20.2, 23.4, 13.5, 30.0]
    text = Path("leg.yaml").read_text(encoding="utf-8")
    assert "effort_limit: {value: 22 N*m" in text and "coulomb: {value: 0.2 N*m" in text
    assert main(["compile", "leg.yaml", "-o", "out"]) == 0
    capsys.readouterr()
    assert main(["audit", "env.yaml", "--notes"]) == 0
    assert "LIM106 [info]" in capsys.readouterr().out

    Path("env.yaml").write_text(
        Path("env.yaml").read_text(encoding="utf-8").replace(":UnitreeActuator", ":NoisyActuator"),
        encoding="utf-8",
    )
    assert main(["import", "env.yaml", "-o", "no.yaml"]) == 2
    assert (
        "DRF002: none of the joints of leg can go into a group: NoisyActuatorCfg is a class of "
        "unitree_rl_lab.assets.robots.unitree_actuators, and a run's file says nothing of what a class does\n"
        "  help: import the configuration that it was trained with (.py) in its place, where "
        "unitree_rl_lab/assets/robots/unitree_actuators.py is\n"
    ) in capsys.readouterr().err


def test_patterns_of_a_reward_are_no_joints(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """They select joints: a spec of two joints that are called `.*_hip` and `.*_ankle` was written of them."""
    Path("env.yaml").write_text(RUN.replace("SDK", "init_state: null"), encoding="utf-8")
    assert main(["import", "env.yaml", "-o", "leg.yaml"]) == 2
    assert "DRF009" in capsys.readouterr().err
    assert main(["import", "env.yaml", "--joints", "env.yaml", "-o", "leg.yaml"]) == 2
    assert "DRF011 --joints: no list of joint names is in it" in capsys.readouterr().err
    assert not Path("leg.yaml").exists()


def test_a_gap_of_the_motors_is_one_in_the_spec(folder: Path) -> None:
    """The robot's numbering is kept: the knee of a deploy file is motor 3."""
    Path("leg_deploy.yaml").write_text(
        "joint_ids_map: [0, 3]\njoint_sdk_names: [left_hip, '', '', left_knee]\n"
        "stiffness: [40, 0, 0, 50]\ndamping: [1, 0, 0, 2]\ndefault_joint_pos: [0.1, 0.2]\n",
        encoding="utf-8",
    )
    assert main(["import", "leg_deploy.yaml", "-o", "leg.yaml"]) == 0
    text = Path("leg.yaml").read_text(encoding="utf-8")
    assert "joint_order: [left_hip, null, null, left_knee]" in text
    assert "left_knee" in text and "0.2 rad" in text and "50 N*m/rad" in text
