"""Several files of one robot: which says what, which joints are left alone, and every disagreement told."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from actspec import api
from actspec.cli.main import main
from actspec.diagnostics import ActspecError, AuditError
from actspec.draft.reading import read_robot_files
from actspec.readings.versions import Versions
from actspec.spec.models import NetworkFile
from actspec.spec.validate import load_spec
from tests.importing import CURVED, Imported, bare, imported, mjcf, write

MOTORS = mjcf(
    '<joint name="hip" damping="0.3" armature="0.02" frictionloss="0.1"/>\n<joint name="knee" damping="0.3"/>',
    '<motor joint="hip" forcerange="-30 30"/><motor joint="knee" forcerange="-30 30"/>',
    '<option timestep="0.002"/>',
)
"""Torque motors."""

LINK = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
URDF = f"""<robot name="leg">
<link name="base"/><link name="one">{LINK}</link><link name="two">{LINK}</link>
<joint name="hip" type="revolute"><parent link="base"/><child link="one"/>
<limit lower="-1" upper="1" effort="25" velocity="20"/><dynamics damping="0.05" friction="0.2"/></joint>
<joint name="knee" type="revolute"><parent link="one"/><child link="two"/>
<limit lower="-1" upper="1" effort="50" velocity="10"/><dynamics damping="0.05" friction="0.2"/></joint>
</robot>"""

ISAACLAB = """from isaaclab.actuators import IdealPDActuatorCfg
from isaaclab.assets import ArticulationCfg

LEG_CFG = ArticulationCfg(
    actuators={
        "all": IdealPDActuatorCfg(
            joint_names_expr=[".*"],
            effort_limit=24.0,
            stiffness=40.0,
            damping=1.0,
        ),
    },
)
"""

MJLAB = """from mjlab.actuator import BuiltinPositionActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg

LEG = EntityArticulationInfoCfg(
    actuators=(
        BuiltinPositionActuatorCfg(
            target_names_expr=(".*",), stiffness=60.0, damping=2.0, effort_limit=24.0, armature=0.01
        ),
    )
)
"""

NO_STEP = MOTORS.replace('<option timestep="0.002"/>', "")

DEPLOY = """joint_names: [knee, hip]
kp: [45, 45]
kd: [1, 1.5]
default_joint_pos: [-1.5, 0.8]
control_dt: 0.02
"""


def joint(found: Imported, name: str) -> dict[str, Any]:
    """A joint's group with its override laid over."""
    groups = bare(found.data["actuators"])
    (group,) = (g for g in groups.values() if name in g["joints"] or g["joints"] == [".*"])
    over = group.get("overrides", {}).get(name, {})
    return {**group, **over, "friction": {**group["friction"], **over.get("friction", {})}}


def told(found: Imported) -> list[tuple[str, tuple[str, ...], float | None, float | None]]:
    """Disagreements: field, joints, what is taken, what is not."""
    return [(d.field, d.joints, d.taken.value, d.lost.value) for d in found.combined.disagreements]


def test_motor_with_gains_of_a_configuration(tmp_path: Path) -> None:
    """A torque motor becomes a position drive where a configuration has gains for it; passive values stay."""
    found = imported(write(tmp_path, leg_xml=MOTORS, leg_py=ISAACLAB), tmp_path)
    hip = joint(found, "hip")
    assert (hip["command"], hip["kp"], hip["kd"]) == ("position", "40 N*m/rad", "1 N*m*s/rad")
    assert hip["effort_limit"] == "24 N*m"
    assert hip["armature"] == "0.02 kg*m^2"
    assert hip["friction"] == {"coulomb": "0.1 N*m", "viscous": "0.3 N*m*s/rad"}
    assert found.data["robot"]["model"] == "leg.xml"
    assert told(found) == [("effort_limit", ("hip", "knee"), 24.0, 30.0)]
    # Both motors are on one line.
    line = MOTORS[: MOTORS.index("<motor")].count("\n") + 1
    assert f"leg.xml:{line} has 30 N*m" in found.draft.text
    # 0.3 is more than a tenth of 1: the two may be one.
    assert (
        "1.3 N*m*s/rad together with the kd of another file; put 0 if that kd includes it" in found.draft.text
    )


def test_motor_without_gains(tmp_path: Path) -> None:
    """A torque motor that no other file drives stays one."""
    found = imported(write(tmp_path, leg_xml=MOTORS, leg_urdf=URDF), tmp_path)
    hip = joint(found, "hip")
    assert hip["command"] == "effort"
    assert "kp" not in hip


def test_gains_of_a_deploy_file_leave_the_motor(tmp_path: Path) -> None:
    """A deploy file has gains for the robot; the torque-speed line is the next drive's, a torque motor has none."""
    dcmotor = mjcf(
        '<joint name="hip"/>\n<joint name="knee"/>',
        "".join(
            f'<dcmotor joint="{name}" nominal="24 20 10" saturation="24 0 0" input="pos" controller="30 0 2 0 0 24"/>'
            for name in ("hip", "knee")
        ),
    )
    found = imported(write(tmp_path, leg_xml=dcmotor, deploy_yaml=DEPLOY), tmp_path)
    hip = joint(found, "hip")
    assert (hip["level"], hip["kp"], hip["kd"]) == ("dc_motor", "45 N*m/rad", "1.5 N*m*s/rad")
    (motor,) = bare(found.data["motors"]).values()
    assert motor["no_load_speed"] == "10 rad/s"
    plain = imported(write(tmp_path, leg_xml=MOTORS, deploy_yaml=DEPLOY), tmp_path)
    assert joint(plain, "hip")["level"] == "ideal_pd"


LEGGED = """class LegCfg(LeggedRobotCfg):
    class control(LeggedRobotCfg.control):
        control_type = "P"
        stiffness = {"hip": 40.0, "knee": 40.0}
        damping = {"hip": 1.0, "knee": 1.0}
        decimation = 4
"""
STEPPED = f"{LEGGED}    class sim(LeggedRobotCfg.sim):\n        dt = 0.005\n"


@pytest.mark.parametrize(
    ("config", "model", "deploy", "timing", "differ"),
    [
        # Of steps that the class inherits from a file that is not here; 4 of the model's 2 ms are not meant.
        (LEGGED, NO_STEP, "", None, []),
        (LEGGED, MOTORS, "", {"physics_dt": "2 ms"}, []),
        (STEPPED, MOTORS, "", {"physics_dt": "5 ms", "decimation": 4}, []),
        # The deploy file's 20 ms are 10 steps of the model's 2 ms.
        (LEGGED, NO_STEP, DEPLOY, {"control_dt": "20 ms"}, []),
        (LEGGED, MOTORS, DEPLOY, {"physics_dt": "2 ms", "decimation": 10}, []),
        (STEPPED, MOTORS, DEPLOY, {"physics_dt": "5 ms", "decimation": 4}, []),
        # 12.5 of the model's 2 ms: SPEC126, had the spec both.
        (LEGGED, MOTORS, DEPLOY.replace("0.02", "0.025"), {"control_dt": "25 ms"}, []),
        (
            STEPPED,
            MOTORS,
            DEPLOY.replace("0.02", "0.03"),
            {"physics_dt": "5 ms", "decimation": 4},
            [("control_dt", (), 0.02, 0.03)],
        ),
    ],
)
def test_control_period(
    tmp_path: Path,
    config: str,
    model: str,
    deploy: str,
    timing: dict[str, Any] | None,
    differ: list[tuple[str, tuple[str, ...], float, float]],
) -> None:
    """A decimation counts the steps of its own file, and what a deploy file has is the period itself."""
    files = {"leg_xml": model, "leg_config_py": config, **({"deploy_yaml": deploy} if deploy else {})}
    found = imported(write(tmp_path, **files), tmp_path)
    assert bare(found.data.get("timing")) == timing
    assert [item for item in told(found) if item[0] == "control_dt"] == differ
    left_out = any("decimation 4 counts physics steps" in note for note in found.combined.notes.get("", ()))
    assert left_out is (config is LEGGED)


def test_nominal_delay_of_another_file(tmp_path: Path) -> None:
    """A range of delays gets its nominal from another file that has one within it; one outside stays away."""
    cfg = ISAACLAB.replace("IdealPD", "DelayedPD").replace(
        "damping", "min_delay=0, max_delay=4, damping"
    ) + "\n".join(
        [
            "from isaaclab.envs import ManagerBasedRLEnvCfg",
            "class SceneCfg:",
            "    robot = LEG_CFG",
            "class LegEnvCfg(ManagerBasedRLEnvCfg):",
            "    scene = SceneCfg()",
            "    def __post_init__(self):",
            "        self.sim.dt = 0.002",
            "",
        ]
    )
    for delay, nominal in (("0.006", "6 ms"), ("0.02", "unknown")):
        servos = "".join(
            f'<position joint="{n}" kp="1" delay="{delay}" nsample="20"/>' for n in ("hip", "knee")
        )
        model = mjcf('<joint name="hip"/>\n<joint name="knee"/>', servos, '<option timestep="0.002"/>')
        found = imported(write(tmp_path, leg_xml=model, leg_py=cfg), tmp_path, robot="LegEnvCfg")
        assert joint(found, "hip")["delay"] == {
            "nominal": nominal,
            "range": ["0 ms", "8 ms"],
            "sampling": "episode",
        }


@pytest.mark.parametrize("number", ["1e999", "-1e999", 'float("nan")'], ids=["inf", "-inf", "nan"])
def test_numbers_that_are_none(tmp_path: Path, number: str) -> None:
    """What is not finite is unknown, wherever it stands, and says so."""
    cfg = ISAACLAB.replace(
        "actuators=", f'init_state=ArticulationCfg.InitialStateCfg(joint_pos={{".*": {number}}}), actuators='
    )
    for word, value in (("stiffness", 40.0), ("damping", 1.0), ("effort_limit", 24.0)):
        cfg = cfg.replace(f"{word}={value}", f"{word}={number}")
    found = imported(write(tmp_path, leg_xml=mjcf('<joint name="hip"/>'), leg_py=cfg), tmp_path)
    hip = joint(found, "hip")
    assert (hip["kp"], hip["kd"], hip["effort_limit"]) == ("unknown",) * 3
    assert "default_pose" not in found.data["robot"]
    assert ("# no limit" if number == "1e999" else "# the file has") in found.draft.text


def test_a_friction_that_holds_the_joint(tmp_path: Path) -> None:
    """30 N*m are above the hip's limit of 25, which would never move, and below the knee's 50."""
    urdf = URDF.replace('friction="0.2"', 'friction="30"')
    found = imported(write(tmp_path, leg_urdf=urdf), tmp_path)
    assert joint(found, "hip")["friction"]["coulomb"] == "unknown"
    assert joint(found, "knee")["friction"]["coulomb"] == "30 N*m"
    assert "# the file has 30 N*m, which the effort limit cannot overcome" in found.draft.text


def test_equality_that_a_configuration_drives(tmp_path: Path) -> None:
    """Of two fingers that an equality holds together, the one that a configuration drives is the spec's."""
    fingers = mjcf(
        '<joint name="hip" type="slide"/>\n<joint name="knee" type="slide"/>',
        tail='<equality><joint joint1="hip" joint2="knee"/></equality>',
    )
    paths = write(tmp_path, leg_xml=fingers, leg_py=ISAACLAB.replace('".*"', '"hip"'))
    found = imported(paths, tmp_path)
    assert [actuator.joint for actuator in found.combined.actuators.joints] == ["hip"]
    assert [(item.joint, item.why) for item in found.combined.left_alone] == [
        ("knee", "no group of the configuration selects it")
    ]
    alone = imported(paths[:1], tmp_path)
    assert [(item.joint, item.why) for item in alone.combined.left_alone] == [
        ("hip", "follows 'knee' (equality)")
    ]


@pytest.mark.parametrize(
    "config, effort, viscous",
    [({}, 30.0, 0.3), ({"leg_py": ISAACLAB}, 24.0, 0.05), ({"leg_py": MJLAB}, 24.0, 0.3)],
    ids=["robot files alone", "Isaac Lab reads the URDF", "mjlab reads the MJCF"],
)
def test_order_of_robot_files(tmp_path: Path, config: dict[str, str], effort: float, viscous: float) -> None:
    """The robot file that the training reads counts before the other one; without a training the MJCF does."""
    found = imported(write(tmp_path, leg_urdf=URDF, leg_xml=MOTORS, **config), tmp_path)
    hip = joint(found, "hip")
    assert hip["effort_limit"] == f"{effort:g} N*m"
    assert hip["friction"]["viscous"] == f"{viscous:g} N*m*s/rad"
    # Only the URDF has one.
    assert hip["velocity_limit"] == "20 rad/s"
    assert found.data["robot"]["model"] == "leg.xml"


def test_disagreements_are_kept(tmp_path: Path) -> None:
    """Every other value stands beside the one that was taken, and in the list, joint by joint."""
    found = imported(write(tmp_path, leg_py=ISAACLAB, leg_urdf=URDF, deploy_yaml=DEPLOY), tmp_path)
    assert told(found) == [
        ("kp", ("hip", "knee"), 40.0, 45.0),
        ("kd", ("hip",), 1.0, 1.5),
        ("effort_limit", ("hip",), 24.0, 25.0),
        ("effort_limit", ("knee",), 24.0, 50.0),
    ]
    text = found.draft.text
    # Lines 4 and 6 are the two <limit>.
    assert (
        "effort_limit: {value: 24 N*m, source: leg_cfg}    # leg.urdf:4 has 25 N*m; leg.urdf:6 has 50 N*m"
        in text
    )
    assert "kd: {value: 1 N*m*s/rad, source: leg_cfg}    # deploy.yaml:3 has 1.5 N*m*s/rad" in text


def test_deploy_file(tmp_path: Path) -> None:
    """A deploy file gives gains, pose and the robot's own joint order."""
    found = imported(write(tmp_path, leg_xml=MOTORS, deploy_yaml=DEPLOY), tmp_path)
    assert joint(found, "hip")["kd"] == "1.5 N*m*s/rad"
    assert joint(found, "knee")["kd"] == "1 N*m*s/rad"
    assert bare(found.data["robot"]["default_pose"]) == {"hip": "0.8 rad", "knee": "-1.5 rad"}
    assert found.data["targets"]["deploy"] == {"joint_order": ["knee", "hip"]}


@pytest.mark.parametrize(
    ("sdk", "expected"),
    [("[knee, null, hip]", {"joint_order": ["knee", None, "hip"]}), ("null", {})],
    ids=["gap", "not-stated"],
)
def test_deploy_file_of_our_own(tmp_path: Path, sdk: str, expected: dict[str, object]) -> None:
    """A file that actspec wrote has the SDK's order beside that of its lists, gaps and all."""
    own = f'format: "actspec-deploy/1"\norder: {{robot: [hip, knee], sdk: {sdk}}}\nkp: [45, 45]\nkd: [1, 1]\n'
    found = imported(write(tmp_path, leg_xml=MOTORS, deploy_yaml=own), tmp_path)
    assert found.data["targets"]["deploy"] == expected


def test_targets_are_those_of_the_files(tmp_path: Path) -> None:
    """Each kind of file gives its target, at the version that is named or the default."""
    paths = write(tmp_path, leg_py=ISAACLAB, leg_xml=MOTORS)
    versions = Versions(isaaclab="2.2", isaac_sim="5.0")
    assert imported(paths, tmp_path, versions=versions).data["targets"] == {
        "mujoco": {"version": "3.12"},
        "isaaclab": {"version": "2.2", "isaac_sim": "5.0"},
    }
    (urdf,) = write(tmp_path, leg_urdf=URDF)
    assert imported([urdf], tmp_path).data["targets"] == {"urdf": {}}
    found = imported([urdf, paths[0]], tmp_path).data["targets"]
    # With gains a URDF can become an MJCF.
    assert list(found) == ["mujoco", "urdf", "isaaclab"]


def test_implicit_drives_stay_implicit(tmp_path: Path) -> None:
    """Where all drives are the solver's the target says so; where some are, of their joints."""
    implicit = ISAACLAB.replace("IdealPDActuatorCfg", "ImplicitActuatorCfg")
    paths = write(tmp_path, leg_py=implicit, leg_xml=MOTORS)
    assert imported(paths, tmp_path).data["targets"]["isaaclab"] == {"version": "2.3", "class": "implicit"}
    first = implicit.index('        "all"')
    both = implicit.replace('[".*"]', '["hip"]')
    both = (
        both[:first]
        + ISAACLAB[ISAACLAB.index('        "all"') : ISAACLAB.index("    },\n)")]
        .replace('"all"', '"knees"')
        .replace('[".*"]', '["knee"]')
        + both[first:]
    )
    both = both.replace("import ImplicitActuatorCfg", "import IdealPDActuatorCfg, ImplicitActuatorCfg")
    found = imported(write(tmp_path, leg_py=both, leg_xml=MOTORS), tmp_path)
    assert found.data["targets"]["isaaclab"] == {"version": "2.3", "class": {"hip": "implicit"}}
    # Of two groups that have the knee the last one is its drive.
    over = both.replace('["hip"]', '[".*"]')
    assert over.index('"knees"') < over.index('"all"')
    found = imported(write(tmp_path, leg_py=over, leg_xml=MOTORS), tmp_path)
    assert found.data["targets"]["isaaclab"]["class"] == "implicit"
    swapped = over.replace("ImplicitActuatorCfg(", "X(").replace(
        "IdealPDActuatorCfg(", "ImplicitActuatorCfg("
    )
    swapped = swapped.replace("X(", "IdealPDActuatorCfg(")
    found = imported(write(tmp_path, leg_py=swapped, leg_xml=MOTORS), tmp_path)
    assert found.data["targets"]["isaaclab"] == {"version": "2.3"}


@pytest.mark.parametrize(("version", "option"), [("2.3", {"class": {"knee": "custom"}}), ("3.0", {})])
def test_a_curve_needs_a_class_of_its_own(tmp_path: Path, version: str, option: dict[str, object]) -> None:
    """No stock class has unitree_rl_lab's asymmetric curve; 3.0 takes no class beside its own."""
    (tmp_path / "motors.py").write_text(CURVED, encoding="utf-8")
    text = ISAACLAB.replace("from isaaclab.assets", "import motors\nfrom isaaclab.assets")
    text = text.replace('[".*"]', '["hip"]').replace(
        "    },\n)",
        """        "knees": motors.UnitreeActuatorCfg(
            joint_names_expr=["knee"], stiffness=25.0, damping=0.5, X1=13.5, X2=30, Y1=20.2, Y2=23.4),
    },
)""",
    )
    found = imported(
        write(tmp_path, leg_py=text, leg_xml=MOTORS), tmp_path, versions=Versions(isaaclab=version)
    )
    assert found.data["targets"]["isaaclab"] == {"version": version, **option}


def test_joint_that_no_file_drives(tmp_path: Path) -> None:
    """A joint without a drive is left alone where others have one; a configuration's drive for it takes that away."""
    text = MOTORS.replace('<motor joint="knee" forcerange="-30 30"/>', "")
    found = imported(write(tmp_path, leg_xml=text), tmp_path)
    assert [(item.joint, item.why) for item in found.combined.left_alone] == [("knee", "no actuator")]
    found = imported(write(tmp_path, leg_xml=text, leg_py=ISAACLAB), tmp_path)
    assert found.combined.left_alone == ()
    assert joint(found, "knee")["kp"] == "40 N*m/rad"
    hips = ISAACLAB.replace('[".*"]', '["hip"]')
    found = imported(write(tmp_path, leg_urdf=URDF, leg_py=hips), tmp_path)
    assert [item.joint for item in found.combined.left_alone] == ["knee"]


def test_what_the_model_cannot_say_stays(tmp_path: Path) -> None:
    """A joint that the MJCF drives in a way that no spec can say is left alone, whatever a configuration says."""
    text = MOTORS.replace(
        '<motor joint="knee" forcerange="-30 30"/>', '<motor joint="knee"/><motor name="b" joint="knee"/>'
    )
    found = imported(write(tmp_path, leg_xml=text, leg_py=ISAACLAB), tmp_path)
    assert [(item.joint, item.why) for item in found.combined.left_alone] == [
        ("knee", "2 actuators (motor, motor)")
    ]


def test_a_pose_that_cannot_be_read_is_not_taken_for_none(tmp_path: Path) -> None:
    """The URDF, which has no pose, does not make it one of 0 that nobody has stated."""
    pose = (
        'init_state=ArticulationCfg.InitialStateCfg(joint_pos={"hip": 0.0, "knee": KNEE}),\n    actuators={'
    )
    config = "import math\nfrom other import radians\n" + ISAACLAB.replace("actuators={", pose)
    texts = []
    for knee in ("radians(90.0)", "math.radians(90.0)"):
        files = write(tmp_path, leg_urdf=URDF, leg_py=config.replace("KNEE", knee))
        texts.append(imported(files, tmp_path).draft.text)
    assert "pose at zero action, by pattern; knee: calls radians(): radians comes from other" in texts[0]
    # pi/2.
    assert '"knee": {value: 1.5707963' in texts[1]


def test_configuration_alone(tmp_path: Path) -> None:
    """A configuration that names its joints needs no robot file; one with patterns does."""
    named = ISAACLAB.replace('[".*"]', '["hip", "knee"]')
    found = imported(write(tmp_path, leg_py=named), tmp_path)
    assert found.data["robot"] == {"name": "leg", "model": "none", "joints": ["hip", "knee"]}
    assert "no robot file states the kinds of the joints" in found.draft.text
    with pytest.raises(AuditError) as caught:
        imported(write(tmp_path, leg_py=ISAACLAB), tmp_path)
    (item,) = caught.value.diagnostics
    assert item.code == "DRF009"
    assert item.message == "LEG_CFG selects its joints by patterns (.*), and no file names them"
    assert item.help is not None
    assert item.help.startswith("name the robot's MJCF or URDF too, or its joints: --joints FILE")


@pytest.mark.parametrize("at", ["usd/leg.urdf", "urdf/leg.urdf", "urdf/arm.urdf"])
def test_urdf_of_a_usd(at: str, tmp_path: Path) -> None:
    """Joints that stand in a USD may stand in the URDF of its name too; the USD's path is told without detours."""
    spawn = "spawn=sim_utils.UsdFileCfg(usd_path=os.path.join(os.path.dirname(__file__), '../usd/leg.usd')),"
    text = f"import os\nimport isaaclab.sim as sim_utils\n{ISAACLAB.replace('actuators={', spawn + 'actuators={')}"
    for name, content in (("cfg/leg.py", text), (at, URDF)):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(content)
    (tmp_path / "usd").mkdir(exist_ok=True)
    with pytest.raises(AuditError) as caught:
        imported([tmp_path / "cfg" / "leg.py"], tmp_path)
    (item,) = caught.value.diagnostics
    assert item.code == "DRF009" and item.message.endswith(f"they stand in {tmp_path / 'usd' / 'leg.usd'}")
    other = "name the robot's MJCF or URDF too, or"
    named = other if "arm" in at else f"name {tmp_path / at} too, of which its USD may be made, or"
    assert str(item.help).startswith(named)


SEVERAL = ISAACLAB + ISAACLAB[ISAACLAB.index("LEG_CFG") :].replace("LEG_CFG", "ARM_CFG").replace(
    "40.0", "70.0"
)


def test_robot_of_several(tmp_path: Path) -> None:
    """Of a file with several robots one is named; without a name the choices are listed."""
    paths = write(tmp_path, leg_xml=MOTORS, robots_py=SEVERAL)
    assert joint(imported(paths, tmp_path, "ARM_CFG"), "hip")["kp"] == "70 N*m/rad"
    assert joint(imported(paths, tmp_path, "LEG_CFG"), "hip")["kp"] == "40 N*m/rad"
    for robot in (None, "ARMCFG"):
        with pytest.raises(AuditError) as caught:
            imported(paths[1:] if robot is None else paths, tmp_path, robot)
        (item,) = caught.value.diagnostics
        assert item.code == "DRF007"
        assert "LEG_CFG" in str(item.help) and "ARM_CFG" in str(item.help)


COPIED = {
    "changed": "LEG_CFG.copy()\nLEG2_CFG.actuators['all'].stiffness = 70.0",
    "deepcopied": "copy.deepcopy(LEG_CFG)\nLEG2_CFG.actuators['all'].stiffness = 70.0",
    "replaced": "LEG_CFG.replace(init_state=None)\nLEG2_CFG.actuators['all'].stiffness = HARD",
    "of another file": "LEG_CFG.copy()\nLEG2_CFG.spawn.usd_path = '/arm.usd'",
    "as it is": "LEG_CFG.replace(prim_path='/World/Robot')",
    "to the same": "LEG_CFG.copy()\nLEG2_CFG.actuators['all'].stiffness = 40.0",
}


@pytest.mark.parametrize("how", COPIED)
def test_a_changed_copy_is_a_robot(how: str, tmp_path: Path) -> None:
    """A robot that is copied and changed is asked for as one that is written out; an unchanged copy is not."""
    spawn = "spawn=sim_utils.UsdFileCfg(usd_path='/leg.usd'), actuators={"
    text = "import copy\nimport isaaclab.sim as sim_utils\n" + ISAACLAB.replace("actuators={", spawn)
    text += f"LEG2_CFG = {COPIED[how]}\n"
    asks = how not in ("as it is", "to the same")
    for base, asked in (("LEG_CFG", asks), ("_LEG_CFG", False)):
        paths = write(tmp_path, leg_xml=MOTORS, robots_py=text.replace("LEG_CFG", base))
        if not asked:
            kp = "70 N*m/rad" if how in ("changed", "deepcopied") else "40 N*m/rad"
            found = joint(imported(paths, tmp_path), "hip")["kp"]
            assert found == ("unknown" if how == "replaced" else kp)
            continue
        with pytest.raises(AuditError) as caught:
            imported(paths[1:], tmp_path)
        (item,) = caught.value.diagnostics
        assert (item.code, item.message) == ("DRF007", "describes 2 robots")
        assert item.help == "name one with --robot: LEG_CFG, LEG2_CFG"
        assert joint(imported(paths, tmp_path, "LEG_CFG"), "hip")["kp"] == "40 N*m/rad"


MAKER = """
def make(kp=40.0):
    return ArticulationCfg(actuators={"all": IdealPDActuatorCfg(
        joint_names_expr=[".*"], effort_limit=20.0, stiffness=kp, damping=1.0)})
"""


def test_a_function_that_makes_the_robot_is_no_second_one(tmp_path: Path) -> None:
    """Its figures without arguments are nobody's; who names it gets them. Two robots of one function are two."""
    head = ISAACLAB[: ISAACLAB.index("LEG_CFG")] + MAKER
    paths = write(tmp_path, leg_xml=MOTORS, robots_py=head + "LEG_CFG = make(30.0)\n")
    assert joint(imported(paths, tmp_path), "hip")["kp"] == "30 N*m/rad"
    assert joint(imported(paths, tmp_path, "make"), "hip")["kp"] == "40 N*m/rad"
    two = write(tmp_path, robots_py=head + "LEG_CFG = make(30.0)\nARM_CFG = make(70.0)\n")
    with pytest.raises(AuditError) as caught:
        imported(two, tmp_path)
    (item,) = caught.value.diagnostics
    assert (item.code, item.message) == ("DRF007", "describes 2 robots")
    assert item.help == "name one with --robot: LEG_CFG, ARM_CFG"
    # A function that changes the robot makes another one, whose figures somebody wrote.
    stiff = "\ndef stiff():\n    found = LEG_CFG.copy()\n"
    stiff += "    found.actuators['all'].stiffness = 70.0\n    return found\n"
    with pytest.raises(AuditError) as caught:
        imported(write(tmp_path, robots_py=ISAACLAB + stiff), tmp_path)
    assert caught.value.diagnostics[0].code == "DRF007"


def test_a_base_without_an_asset_is_no_robot(tmp_path: Path) -> None:
    """Its only copy that has one is the robot; of two such copies one is named, and the base not offered."""
    copies = "".join(
        f"{name} = LEG_CFG.copy()\n{name}.spawn = sim_utils.UsdFileCfg(usd_path='/{name}.usd')\n"
        for name in ("A_CFG", "B_CFG")
    )
    text = f"import isaaclab.sim as sim_utils\n{ISAACLAB}{copies}"
    paths = write(tmp_path, leg_xml=MOTORS, robots_py=text[: text.index("B_CFG")])
    (_, only), _ = read_robot_files([str(path) for path in paths], None, Versions())
    assert only.artifact.name == "A_CFG"
    with pytest.raises(AuditError) as caught:
        imported(write(tmp_path, robots_py=text), tmp_path)
    assert [item.help for item in caught.value.diagnostics] == ["name one with --robot: A_CFG, B_CFG"]


@pytest.mark.parametrize(
    "changed",
    [
        'A_CFG.actuators["feet"] = A_CFG.actuators["all"].replace(joint_names_expr=["knee"])',
        'A_CFG.actuators.pop("legs")',
        'A_CFG.actuators = {"hip": A_CFG.actuators["all"].replace(joint_names_expr=["hip"])}',
    ],
)
def test_a_private_base_of_a_copy_with_other_entries(tmp_path: Path, changed: str) -> None:
    """It is none, though the copy has an entry more or less; with another's name it is a robot of its own."""
    spawn = "spawn=sim_utils.UsdFileCfg(usd_path='/leg.usd'), actuators={"
    more = '"legs": IdealPDActuatorCfg(joint_names_expr=["knee"], effort_limit=24.0, stiffness=1.0, damping=1.0),'
    text = ISAACLAB.replace("actuators={", spawn).replace("    },\n)", f"    {more}}},\n)")
    text = f"import isaaclab.sim as sim_utils\n{text}A_CFG = LEG_CFG.copy()\n{changed}\n"
    for base, names in (("_LEG_CFG", ["A_CFG"]), ("LEG_CFG", ["LEG_CFG", "A_CFG"])):
        paths = write(tmp_path, robots_py=text.replace("LEG_CFG", base), leg_xml=MOTORS)
        try:
            (one, _), _ = read_robot_files([str(path) for path in paths], None, Versions())
            assert [one.artifact.name] == names
        except AuditError as err:
            (item,) = err.diagnostics
            assert item.help == f"name one with --robot: {', '.join(names)}"


@pytest.mark.parametrize("beside", ["mjcf", "--joints"])
def test_a_class_whose_file_is_not_there(tmp_path: Path, beside: str) -> None:
    """The configuration selects hip and knee: it is no other robot's, and the file of its class is what is missing."""
    text = ISAACLAB.replace("IdealPDActuatorCfg", "OwnActuatorCfg")
    text = text.replace("isaaclab.actuators", "pack.motors.own")
    paths = write(tmp_path, leg_cfg_py=text, leg_xml=MOTORS)
    files = [str(path) for path in paths]
    with pytest.raises(AuditError) as caught:
        if beside == "mjcf":
            imported(paths, tmp_path)
        else:
            read_robot_files(files[:1], None, Versions(), "hip,knee")
    (item,) = caught.value.diagnostics
    assert (item.code, item.message) == (
        "DRF002",
        "none of the joints of LEG_CFG can go into a group: OwnActuatorCfg is a class of pack.motors.own, whose file, "
        "pack/motors/own.py, is not there",
    )
    assert str(item.help).startswith("put pack/motors/own.py below ")
    own = "from isaaclab.actuators import IdealPDActuatorCfg\nclass OwnActuatorCfg(IdealPDActuatorCfg):\n    pass\n"
    (tmp_path / "pack" / "motors").mkdir(parents=True)
    (tmp_path / "pack" / "motors" / "own.py").write_text(own, encoding="utf-8")
    assert joint(imported(paths, tmp_path), "hip")["kp"] == "40 N*m/rad"


def test_several_classes_of_one_file_that_is_not_there(tmp_path: Path) -> None:
    """One file is missing, and is named once; a class of another file is told for itself."""
    group = '"{0}": {1}(joint_names_expr=["{0}"], stiffness=1.0, damping=1.0)'
    text = f"""from isaaclab.assets.articulation import ArticulationCfg
from pack.motors.own import OneActuatorCfg, TwoActuatorCfg
from pack.other import OddActuatorCfg
LEG_CFG = ArticulationCfg(actuators={{{group.format("hip", "OneActuatorCfg")}, {group.format("knee", "TwoActuatorCfg")},
    {group.format("ankle", "OddActuatorCfg")}}})
"""
    (path,) = write(tmp_path, leg_cfg_py=text)
    with pytest.raises(AuditError) as caught:
        read_robot_files([str(path)], None, Versions(), "hip,knee,ankle")
    (item,) = caught.value.diagnostics
    assert item.message == (
        "none of the joints of LEG_CFG can go into a group: OneActuatorCfg, TwoActuatorCfg are classes of "
        "pack.motors.own, whose file, pack/motors/own.py, is not there, OddActuatorCfg is a class of pack.other, whose "
        "file, pack/other.py, is not there"
    )


def test_a_configuration_that_leaves_all_to_the_model(tmp_path: Path) -> None:
    """mjlab's XmlMotorActuatorCfg: the model's torque motors have 30 N*m."""
    text = MJLAB.replace("BuiltinPosition", "XmlMotor").replace(
        ", stiffness=60.0, damping=2.0, effort_limit=24.0, armature=0.01", ""
    )
    found = imported(write(tmp_path, leg_cfg_py=text, leg_xml=MOTORS), tmp_path)
    assert joint(found, "hip")["effort_limit"] == "30 N*m"


def test_other_robot(tmp_path: Path) -> None:
    """Files that share no joint are not put together."""
    other = URDF.replace("hip", "elbow").replace("knee", "wrist")
    with pytest.raises(AuditError) as caught:
        imported(write(tmp_path, leg_xml=MOTORS, arm_urdf=other), tmp_path)
    assert "DRF008" in {item.code for item in caught.value.diagnostics}
    assert "here: hip, knee" in str(caught.value)


def test_names_that_differ_by_the_ending(tmp_path: Path) -> None:
    """A configuration for a USD without `_joint` in its names, beside an MJCF with it."""
    ended = MOTORS.replace('"hip"', '"hip_joint"').replace('"knee"', '"knee_joint"')
    with pytest.raises(AuditError) as caught:
        named = ISAACLAB.replace('[".*"]', '["hip", "knee"]')
        imported(write(tmp_path, leg_xml=ended, leg_cfg_py=named), tmp_path)
    (item,) = caught.value.diagnostics
    assert item.code == "DRF008"
    assert "they differ by their ending alone" in str(item.help)


def test_combined_spec_compiles(tmp_path: Path) -> None:
    """What comes out of three files compiles to every target that it names."""
    found = imported(write(tmp_path, leg_xml=MOTORS, leg_py=ISAACLAB, deploy_yaml=DEPLOY), tmp_path)
    (tmp_path / "spec.yaml").write_text(found.draft.text, encoding="utf-8")
    done = api.compile(tmp_path / "spec.yaml", output=str(tmp_path / "out"))
    assert [target.name for target in done.targets] == ["mujoco", "isaaclab", "deploy"]
    assert [float(a.kp.value or 0) for a in done.actuators.joints if a.kp is not None] == [40.0, 40.0]


def test_kinds_that_no_file_states_are_told_once(tmp_path: Path) -> None:
    """A configuration and a deploy file both say so: once, in lines that are still read."""
    named = ISAACLAB.replace('[".*"]', '["hip", "knee"]')
    lines = imported(write(tmp_path, leg_py=named, deploy_yaml=DEPLOY), tmp_path).draft.text.splitlines()
    assert sum("no robot file states the kinds" in line for line in lines) == 1
    assert max(map(len, lines)) <= 120


def test_networks(tmp_path: Path, capsys: Any) -> None:
    """A network keeps its level, and its file is named from the spec's folder, below which it must lie."""
    text = ISAACLAB.replace("IdealPDActuatorCfg", "ActuatorNetMLPCfg").replace(
        "            stiffness=40.0,\n            damping=1.0,\n",
        '            network_file="net.pt", pos_scale=-1.0, vel_scale=1.0, torque_scale=1.0, input_order="pos_vel",\n'
        "            input_idx=[0, 1, 2], saturation_effort=30.0, velocity_limit=20.0,\n",
    )
    found = imported(write(tmp_path, leg_xml=MOTORS, leg_py=text), tmp_path)
    group = next(iter(bare(found.data["actuators"]).values()))
    assert group["level"] == "actuator_net"
    assert group["network"] == {"file": "net.pt"}
    (tmp_path / "net.pt").write_text("")
    for folder, named in ((tmp_path, "net.pt"), (tmp_path / "specs", "net.pt")):
        spec = folder / "leg.yaml"
        files = [str(tmp_path / name) for name in ("leg.xml", "leg.py")]
        assert main(["import", *files, "-o", str(spec)]) == 0
        assert load_spec(str(spec)).model.actuators["all"].network == NetworkFile(file=named)
        told = "copy ../net.pt to net.pt there" in capsys.readouterr().out
        assert told == ("copy ../net.pt to net.pt" in spec.read_text()) == (folder != tmp_path)


def test_network_of_legged_gym(tmp_path: Path) -> None:
    """As ANYmal C of legged_gym: the network drives, its gains are nobody's, and what stands beside them is kept.

    The network lies below the folder that `LEGGED_GYM_ROOT_DIR` stands for, above the configuration.
    """
    own = """    class control(LeggedRobotCfg.control):
        stiffness = {"hip": 80.0, "knee": 80.0}
        damping = {"hip": 2.0, "knee": 2.0}
        action_scale = 0.5
        decimation = 4
        use_actuator_network = True
        actuator_net_file = "{LEGGED_GYM_ROOT_DIR}/nets/sea.pt"
"""
    text = f"class LegCfg(LeggedRobotCfg):\n{own}    class sim(LeggedRobotCfg.sim):\n        dt = 0.005\n"
    (tmp_path / "envs" / "leg").mkdir(parents=True)
    (tmp_path / "nets").mkdir()
    (tmp_path / "nets" / "sea.pt").write_text("")
    (tmp_path / "envs" / "leg" / "leg_cfg.py").write_text(text)
    (model,) = write(tmp_path, leg_xml=MOTORS)
    spec = tmp_path / "leg.yaml"
    assert main(["import", str(tmp_path / "envs" / "leg" / "leg_cfg.py"), str(model), "-o", str(spec)]) == 0
    loaded = load_spec(str(spec)).model
    (group,) = loaded.actuators.values()
    assert (group.level, group.network) == ("actuator_net", NetworkFile(file="nets/sea.pt"))
    written = spec.read_text()
    assert "action_scale: {value: 0.5, source: leg_cfg}" in written and "decimation: 4" in written
    assert "kp:" not in written and "kd:" not in written
    words = " ".join(written.replace("\n    # ", " ").split())
    assert "stiffness and damping are left out, which training does not use" in words


def test_errors_are_ours(tmp_path: Path) -> None:
    """A file that is not there, beside one that is, is one error with its place."""
    paths = write(tmp_path, leg_xml=MOTORS)
    with pytest.raises(ActspecError) as caught:
        imported([*paths, tmp_path / "no.urdf"], tmp_path)
    assert "no.urdf" in str(caught.value)
