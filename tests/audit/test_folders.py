"""What rules say of files that were met in a folder, and of those that somebody named."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.engine import audit
from actspec.audit.rules import all_rules
from actspec.audit.settings import Settings
from actspec.cli.main import main
from actspec.diagnostics import Severity

SIDES = ("left", "right")


@pytest.mark.parametrize(
    ("code", "file", "other", "severity"),
    [
        ("SRC104", "dog.py", "dog.xml", "warning"),
        ("SRC101", "dog.py", "dog.urdf", "error"),
        ("GEA101", "dog.py", "dog.urdf", "warning"),
        ("SYM101", "dog.xml", "dog.py", "warning"),
        ("DMP101", "dog.xml", "dog.py", "warning"),
    ],
)
def test_a_rule_that_speaks_in_notes_of_a_folder(
    code: str, file: str, other: str, severity: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever names the file that departs wants to know, and whoever sets the rule's severity.

    Of the configuration the armature is not the model's, and the knees have the hips' limits: 47.4 N*m is 2.02 times
    23.5, and 47.4 * 15.05 = 23.7 * 30.1. Of the model the knees differ, and its damping repeats the kv.
    """
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    joint = """<link name="{child}"/><joint name="{child}_joint" type="revolute"><parent link="{parent}"/>
        <child link="{child}"/><limit lower="-1" upper="1" effort="{effort}" velocity="{speed}"/></joint>"""
    joints = "".join(
        joint.format(parent="base", child=f"{side}_hip", effort=23.7, speed=30.1)
        + joint.format(parent=f"{side}_hip", child=f"{side}_knee", effort=47.4, speed=15.05)
        for side in SIDES
    )
    Path("r/dog.urdf").write_text(f'<robot name="dog"><link name="base"/>{joints}</robot>')
    bodies = "".join(
        f'<body><joint name="{side}_hip_joint" armature="0.1" damping="2"/><geom size="0.1"/>'
        f'<body><joint name="{side}_knee_joint" armature="{knee}" damping="2"/><geom size="0.1"/></body></body>'
        for side, knee in zip(SIDES, (0.1, 0.2), strict=True)
    )
    drives = "".join(
        f'<position joint="{side}_{part}_joint" kp="20" kv="2"/>'
        for side in SIDES
        for part in ("hip", "knee")
    )
    Path("r/dog.xml").write_text(
        f'<mujoco model="dog"><worldbody>{bodies}</worldbody><actuator>{drives}</actuator></mujoco>'
    )
    Path("r/dog.py").write_text(
        "from isaaclab.actuators import DCMotorCfg\nfrom isaaclab.assets import ArticulationCfg\n"
        'LEGS = DCMotorCfg(joint_names_expr=[".*_joint"], effort_limit=23.5, saturation_effort=23.5,\n'
        "    velocity_limit=30.0, stiffness=25.0, damping=0.5, armature=0.009)\n"
        'DOG_CFG = ArticulationCfg(actuators={"legs": LEGS})\n'
    )
    alone = Settings(select=(code,))
    for named, settings, expected in (
        (["r"], alone, "info"),
        ([f"r/{other}", "r"], alone, "info"),
        ([f"r/{file}", "r"], alone, severity),
        (["r/dog.urdf", "r/dog.xml", "r/dog.py"], alone, severity),
        (["r"], Settings(select=(code,), as_named=True), severity),
        (["r"], Settings(select=(code,), severity={code: Severity.ERROR}), "error"),
    ):
        found = audit(named, settings).findings
        assert {(Path(item.finding.span.path).name, item.severity.value) for item in found} == {
            (file, expected)
        }


def test_a_spec_in_a_folder_is_its_writers_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No program has to name it: sides that differ are a warning in it."""
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    limits = "".join(
        f"  {side}: {{joints: [{side}_knee], level: ideal_pd, kp: 20, kd: 2, effort_limit: {limit}}}\n"
        for side, limit in zip(SIDES, (20, 30), strict=True)
    )
    Path("r/dog.yaml").write_text(
        f"actspec: 1\nrobot: {{name: dog, model: none, joints: [left_knee, right_knee]}}\nactuators:\n{limits}"
    )
    found = audit(["r"], Settings(select=("SYM101",))).findings
    assert [(item.finding.span.path, item.severity) for item in found] == [("r/dog.yaml", Severity.WARNING)]


@pytest.mark.parametrize(
    ("names", "named", "severity"),
    [
        (("knee_1", "J24_HEAD_YAW"), ["r"], Severity.WARNING),
        (("J12_TORSO_YAW", "J24_HEAD_YAW"), ["r"], Severity.INFO),
        (("J12_TORSO_YAW", "J24_HEAD_YAW"), ["r/dog.py", "r/dog.xml"], Severity.WARNING),
    ],
)
def test_names_that_are_nearly_a_models(
    names: tuple[str, ...],
    named: list[str],
    severity: Severity,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """One is misspelt; several that are numbered otherwise are of another robot (shivam-sood00/Gurukul)."""
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    joints = ("hip_1", "hip_2", "knee_1", "J11_TORSO_YAW", "J23_HEAD_YAW")
    bodies = "".join(f'<body><joint name="{name}"/><geom size="0.1"/></body>' for name in joints)
    Path("r/dog.xml").write_text(f'<mujoco model="dog"><worldbody>{bodies}</worldbody></mujoco>')
    Path("r/dog.py").write_text(
        "from isaaclab.actuators import ImplicitActuatorCfg\nfrom isaaclab.assets import ArticulationCfg\n"
        'LEGS = ImplicitActuatorCfg(joint_names_expr=["hip_1", "hip_2", "knee_1"], stiffness=9.0, damping=1.0)\n'
        f"REST = ImplicitActuatorCfg(joint_names_expr={list(names)}, stiffness=9.0, damping=1.0)\n"
        'DOG_CFG = ArticulationCfg(actuators={"legs": LEGS, "rest": REST})\n'
    )
    found = audit(named, Settings(select=("ORD104",))).findings
    assert {item.finding.message.split("'")[1]: item.severity for item in found} == dict.fromkeys(
        [name for name in names if name not in joints], severity
    )


@pytest.mark.parametrize(("pattern", "code"), [("heel_.*", "CFG102"), ("toe_.*", "ORD104")])
def test_joints_that_lose_their_drive(
    pattern: str, code: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The model has a hip, a knee and a heel, whose positions the configuration sets; the ankle that it drives is in no
    group, or the pattern in its place is of no joint. Certain enough for a warning of one's own files.
    """
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    joints = ("hip_joint", "knee_joint", "heel_joint", "ankle_joint")
    bodies = "".join(f'<body><joint name="{joint}"/><geom size="0.1"/>' for joint in joints) + "</body>" * 4
    drives = "".join(f'<motor joint="{joint}"/>' for joint in joints)
    Path("r/walker.xml").write_text(
        f'<mujoco model="walker"><worldbody>{bodies}</worldbody><actuator>{drives}</actuator></mujoco>'
    )
    Path("r/walker.py").write_text(
        "from isaaclab.actuators import IdealPDActuatorCfg\nfrom isaaclab.assets import ArticulationCfg\n"
        "WALKER_CFG = ArticulationCfg(actuators={'legs': IdealPDActuatorCfg(\n"
        f"    joint_names_expr=['hip_.*', 'knee_.*', 'heel_.*', '{pattern}'], stiffness=20.0, damping=0.5)}},\n"
        "    init_state=ArticulationCfg.InitialStateCfg(joint_pos={'ankle_.*': 0.1}))\n"
    )
    for settings, severity in (
        (Settings(select=(code,)), Severity.INFO),
        (Settings(select=(code,), as_named=True), Severity.WARNING),
    ):
        (item,) = audit(["r"], settings).findings
        assert (item.finding.code, item.severity) == (code, severity)
    both = audit(["r"], Settings(select=("CFG102", "ORD104"), as_named=True))
    assert len(both.at_or_above(Severity.WARNING)) == 1


def test_a_finding_may_be_a_note_of_a_folder_alone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A tenth of 23.7 N*m at a Go2's hip is one; what is 3 times the published 45.43 N*m at its knee is a warning.

    Of an MJCF, which a program drives as it likes, both are notes.
    """
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    limits = {
        "FR_hip": 2.37,
        "F[RL]_thigh": 23.7,
        "FL_hip": 23.7,
        "R[RL]_(?:hip|thigh)": 23.7,
        "FR_calf": 136.3,
    }
    groups = "".join(
        f'"{n}": ImplicitActuatorCfg(joint_names_expr=["{joint}_joint"], effort_limit_sim={limit}, '
        "stiffness=20.0, damping=1.0), "
        for n, (joint, limit) in enumerate(limits.items())
    )
    Path("r/go2.py").write_text(
        "from isaaclab.actuators import ImplicitActuatorCfg\nfrom isaaclab.assets import ArticulationCfg\n"
        f"GO2_CFG = ArticulationCfg(actuators={{{groups}}})\n"
    )
    legs = "".join(
        f'<body><joint name="{leg}_hip_joint"/><geom size=".1"/>'
        f'<body><joint name="{leg}_thigh_joint"/><geom size=".1"/>'
        f'<body><joint name="{leg}_calf_joint"/><geom size=".1"/></body></body></body>'
        for leg in ("FR", "FL", "RR", "RL")
    )
    drives = "".join(
        f'<position joint="{joint}_joint" kp="20" forcerange="-{limit} {limit}"/>'
        for joint, limit in (("FR_hip", 2.37), ("FR_thigh", 23.7), ("FL_hip", 23.7), ("FR_calf", 136.3))
    )
    Path("r/go2.xml").write_text(
        f'<mujoco model="go2"><worldbody>{legs}</worldbody><actuator>{drives}</actuator></mujoco>'
    )
    for given, of_config, of_model in (
        ({}, ("info", "warning"), ("info", "info")),
        ({"as_named": True}, ("warning", "warning"), ("warning", "warning")),
        ({"severity": {"KNW101": Severity.ERROR}}, ("error", "error"), ("error", "error")),
    ):
        found = audit(["r"], Settings(select=("KNW101",), **given)).findings  # type: ignore[arg-type]
        for ending, expected in ((".py", of_config), (".xml", of_model)):
            severities = {
                item.finding.joint: item.severity.value
                for item in found
                if item.finding.span.path.endswith(ending)
            }
            assert severities == dict(zip(("FR_hip_joint", "FR_calf_joint"), expected, strict=True))
    named = audit(["r/go2.xml"], Settings(select=("KNW101",))).findings
    assert {item.severity for item in named} == {Severity.WARNING}
    main(["audit", "r", "--select", "KNW101"])
    assert (
        "1 note (KNW101): --notes shows it; --as-named judges a folder of your own, where those of KNW101 can be errors"
        in (capsys.readouterr().out)
    )


@pytest.mark.parametrize(
    ("joint", "severity"),
    [
        ("damping='1.3771' frictionloss='0.3392'", Severity.INFO),
        ("damping='1.38' frictionloss='0.3392'", Severity.WARNING),
        ("damping='1.3771'", Severity.WARNING),
        # 2.1234 + 2 = 4.1234 beside 2 sqrt(20 * 0.01) = 0.89: overdamped.
        ("damping='2.1234' frictionloss='0.3392'", Severity.ERROR),
    ],
)
def test_friction_that_was_identified(
    joint: str, severity: Severity, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Damping and friction of four digits and more stay beside the drive on purpose: DMP105."""
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    Path("r/leg.xml").write_text(
        f"<mujoco model='leg'><worldbody><body><joint name='knee' {joint}/>"
        "<inertial pos='0 0 0' mass='1' diaginertia='0.01 0.01 0.01'/></body></worldbody></mujoco>"
    )
    Path("r/leg_constants.py").write_text(
        "from mjlab.actuator import BuiltinPositionActuatorCfg\n"
        "from mjlab.entity import EntityArticulationInfoCfg\n"
        "LEG_ARTICULATION = EntityArticulationInfoCfg(actuators=(BuiltinPositionActuatorCfg(\n"
        "    target_names_expr=('knee',), stiffness=20.0, damping=2.0, effort_limit=30.0),))\n"
    )
    (item,) = audit(["r"], Settings(select=("DMP105",))).findings
    assert item.severity == severity
    (item,) = audit(["r"], Settings(select=("DMP105",), as_named=True)).findings
    assert item.severity == (severity if severity is Severity.ERROR else Severity.WARNING)


@pytest.mark.parametrize(("named", "severity"), [("r", Severity.INFO), ("r/cfg.py", Severity.WARNING)])
def test_ranges_of_a_network_s_gains(
    named: str, severity: Severity, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What they are meant for is seldom to be seen in a stranger's folder: NET105, and so ORD101 and DMP104."""
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    Path("r/cfg.py").write_text(
        "class DogCfg(LeggedRobotCfg):\n    class control(LeggedRobotCfg.control):\n"
        '        control_type = "actuator_net"\n        stiffness = {"joint": 20.0}\n'
        '        damping = {"joint": 0.5}\n'
        "    class domain_rand(LeggedRobotCfg.domain_rand):\n        randomize_gains = True\n"
        "        stiffness_multiplier_range = [0.9, 1.1]\n"
    )
    found = audit([named], Settings(select=("NET105",))).findings
    assert {item.severity for item in found} == {severity}
    noted = {rule.code for rule in all_rules() if rule.noted_in_folders}
    assert {"NET105", "ORD101", "DMP104"} <= noted


_SIDES = "".join(
    f'<link name="{side}"/><joint name="{side}_knee" type="revolute"><parent link="a"/><child link="{side}"/>'
    '<limit lower="-1" upper="1" effort="{' + side + '}" velocity="{speed}"/></joint>'
    for side in SIDES
)
_LEGS = f'<robot name="legs"><link name="a"/>{_SIDES}</robot>'
_DAMPED = _LEGS.format(left=3, right=3, speed=9).replace("</joint>", '<dynamics damping="0.5"/></joint>', 1)
_LIMB = """<robot name="arm"><link name="a"/><link name="b"/><joint name="elbow" type="revolute"><parent link="a"/>
<child link="b"/><limit lower="{lower}" upper="1" effort="2" velocity="3"/><dynamics damping="4"/></joint></robot>"""
_LOADED = "import mujoco\ns = mujoco.MjSpec.from_file(FILE)\n"
_MODEL = """<mujoco model="arm"><compiler autolimits="true"/><worldbody>
<body><geom size="0.1"/><joint name="elbow" range="-1.5 1.5" frictionloss="9"/><body><geom size="0.1"/>
<joint name="wrist" range="-1.2 1.2"/><body><geom size="0.1"/><joint name="hand" range="-1.2 1.2"/></body></body></body>
</worldbody><actuator><motor joint="{joint}" ctrlrange="-9 9"/></actuator></mujoco>"""


@pytest.mark.parametrize(
    ("file", "text", "program", "code", "elsewhere"),
    [
        # 2 N*m brake 4 N*m*s/rad at 0.5 rad/s, and the joint shall have 3.
        ("arm.urdf", _LIMB.format(lower=-1), "import mujoco\n", "DMP103", "info"),
        ("arm.urdf", _LIMB.format(lower=2), "", "AUD022", None),
        ("arm.urdf", _LIMB.format(lower=-1)[:-9], "", "AUD008", "info"),
        ("arm.xml", _MODEL.format(joint="elbow"), "import mujoco\n", "FRC101", "info"),
        ("legs.urdf", _LEGS.format(left=3, right=5, speed=9), "", "SYM101", "info"),
        ("arm.xml", _MODEL.format(joint="elbow"), "", "UNT101", "info"),
        ("arm.xml", _MODEL.format(joint="ebow"), "import mujoco\n", "AUD020", None),
        ("arm.xml", _MODEL.format(joint="ebow"), "import pybullet\n", "AUD020", None),
        ("arm.xml", _MODEL.format(joint="ebow"), "import mujoco_py\n", "AUD020", None),
        ("arm.xml", _MODEL.format(joint="ebow"), "from gym.envs.mujoco import mujoco_env\n", "AUD020", None),
        (
            "arm.xml",
            _MODEL.format(joint="ebow"),
            "from gymnasium.envs.mujoco import mujoco_env\n",
            "AUD020",
            None,
        ),
        (
            "arm.xml",
            _MODEL.format(joint="ebow"),
            "import mujoco_py\nmujoco_py.functions.mj_step()\n",
            "AUD020",
            None,
        ),
        # Robosuite takes the defaults out of the parts.
        (
            "arm.xml",
            _MODEL.format(joint="ebow"),
            "import robosuite\nxml_path_completion('a')\n",
            "AUD020",
            None,
        ),
        # A joint of the robot that it is attached to.
        ("arm.xml", _MODEL.format(joint="ebow"), f"{_LOADED}s.attach(robot)\n", "AUD020", None),
        ("arm.xml", _MODEL.format(joint="ebow"), _LOADED, "AUD020", None),
    ],
)
def test_a_model_that_a_program_of_the_folder_names(
    file: str,
    text: str,
    program: str,
    code: str,
    elsewhere: str | None,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It is in use: what is wrong in it counts; not in one that another program names, nor where Bullet alone reads it.

    Of a model that no program names it is a note, or said on stderr.
    """
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    Path("r", file).write_text(text)

    def severity() -> str | None:
        found = [item for item in audit(["r"], Settings()).findings if item.finding.code == code]
        return found[0].severity.value if found else None

    assert severity() == elsewhere
    Path("r/train.py").write_text(f"{program}FILE = 'other/leg.xml'\n")
    assert severity() == elsewhere
    Path("r/train.py").write_text(f"{program}FILE = 'r/{file}'\n")
    others = any(word in program for word in ("bullet", "mujoco_py", "gym.envs", "attach", "xml_path"))
    assert severity() == ("info" if others else "warning")
    Path("old").mkdir()
    Path("r").rename("old/r")
    Path("r").mkdir()
    Path("old").rename("r/old")
    assert severity() == elsewhere


@pytest.mark.parametrize(("library", "severity"), [("mujoco", "warning"), ("mujoco_py", "info")])
def test_a_part_that_mujoco_refuses(
    library: str, severity: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Programs speak of the scene that they name, and so of what it includes."""
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    Path("r/part.xml").write_text(
        '<mujoco><worldbody><body><joint name="j"/><geom size="0.1, 0.1"/></body></worldbody></mujoco>'
    )
    Path("r/scene.xml").write_text(
        '<mujoco><include file="part.xml"/><actuator><motor joint="j"/></actuator></mujoco>'
    )
    Path("r/run.py").write_text(f"import {library}\nFILE = 'scene.xml'\n")
    found = [item for item in audit(["r"], Settings()).findings if item.finding.code == "AUD020"]
    assert [(item.finding.span.path, item.severity.value) for item in found] == [("r/part.xml", severity)]


@pytest.mark.parametrize(
    ("other", "severity"),
    [(_LEGS.format(left=3, right=5, speed=9), "warning"), (_DAMPED, "info")],
    ids=["limit", "damping"],
)
def test_sides_of_a_model_that_a_program_names(
    other: str, severity: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another damping is there by intent more often than a motor of another kind."""
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    Path("r/legs.urdf").write_text(other)
    Path("r/run.py").write_text("FILE = 'legs.urdf'\n")
    found = [item for item in audit(["r"], Settings()).findings if item.finding.code == "SYM101"]
    assert [item.severity.value for item in found] == [severity]


@pytest.mark.parametrize(
    ("limits", "program", "severity"),
    [
        ((3, 5), "", "warning"),
        ((3, 0), "", "error"),
        # The effort of a URDF is no drive's limit, of any joint.
        ((3, 5), "tau = np.clip(tau, -9.0, 9.0)\n", "info"),
        ((3, 5), "props['effort'].fill(9.0)\n", "info"),
        # A dead joint is a slip, whoever has not felt it.
        ((3, 0), "props['effort'].fill(9.0)\n", "error"),
    ],
)
def test_efforts_of_two_sides_that_a_program_has_not(
    limits: tuple[int, int],
    program: str,
    severity: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What is the same for all of them is what runs; whoever judges his own folder wants to know."""
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    Path("r/legs.urdf").write_text(_LEGS.format(left=limits[0], right=limits[1], speed=9))
    Path("r/run.py").write_text(f"FILE = 'legs.urdf'\n{program}")
    for as_named, expected in ((False, severity), (True, "error" if 0 in limits else "warning")):
        (found,) = audit(["r"], Settings(select=("SYM101",), as_named=as_named)).findings
        assert found.severity.value == expected


@pytest.mark.parametrize(
    ("gains", "limit", "program", "severity"),
    [
        (40, 50, "m.actuator_gainprm[:, 0] = 80\n", "info"),
        (40, 50, "kp = m.actuator_gainprm[0, 0]\n", "warning"),
        # The limits stay.
        (40, 30, "m.actuator_gainprm[:, 0] = 80\n", "warning"),
    ],
)
def test_gains_of_two_sides_that_a_program_has_not(
    gains: int, limit: int, program: str, severity: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It writes the same for all of them."""
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    bodies = "".join(f'<body><geom size="0.1"/><joint name="{side}_knee"/></body>' for side in SIDES)
    drives = (
        '<position joint="left_knee" kp="100" forcerange="-50 50"/>'
        f'<position joint="right_knee" kp="{gains}" forcerange="-{limit} {limit}"/>'
    )
    Path("r/legs.xml").write_text(
        f"<mujoco><worldbody>{bodies}</worldbody><actuator>{drives}</actuator></mujoco>"
    )
    Path("r/run.py").write_text(f"import mujoco\nFILE = 'legs.xml'\n{program}")
    (found,) = audit(["r"], Settings(select=("SYM101",))).findings
    assert found.severity.value == severity


@pytest.mark.parametrize(
    ("program", "severity"),
    [
        ("import mujoco\nFILE = 'arm.urdf'\n", "warning"),
        # Its text may be another one when a simulator has it.
        ("import mujoco\nload(open('arm.urdf').read().replace('MASS', '1'))\n", "info"),
        (
            "import mujoco\nwith open(os.path.join(HERE, 'arm.urdf')) as file:\n    load(file.read())\n",
            "info",
        ),
        ("import mujoco\nopen('log.txt', 'w')\nFILE = 'arm.urdf'\n", "warning"),
        ("tree = ET.parse('arm.urdf')\n", "info"),
        # A tool that takes it apart, and one that simulates it.
        ("import argparse\nADD('--model', default='arm.urdf')\n", "info"),
        ("import argparse, mujoco\nADD('--model', default='arm.urdf')\n", "warning"),
        ("FILE = 'arm.urdf.xacro'\n", "info"),
    ],
)
def test_a_model_that_a_program_takes_apart(
    program: str, severity: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is simulated is what it makes of it."""
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    Path("r/arm.urdf").write_text(_LIMB.format(lower=-1))
    Path("r/run.py").write_text(program)
    (found,) = [item for item in audit(["r"], Settings()).findings if item.finding.code == "DMP103"]
    assert found.severity.value == severity


_ISAAC = "from isaacgym import gymapi\ngym.load_asset(sim, '.', '{file}')\n"
_GENESIS = "import genesis as gs\ngs.morphs.URDF(file='{file}')\n"
_RVIZ = '<launch><param textfile="$(find r)/{file}"/><node pkg="rviz" type="rviz"/></launch>'
_OF_MUJOCO = "import numpy, mujoco\nm = mujoco.MjModel.from_xml_path('{file}')\nmujoco.mj_step(m, d)\n"


@pytest.mark.parametrize(
    ("program", "damped", "rubbing"),
    [
        (_OF_MUJOCO, "warning", "warning"),
        ('<launch><node pkg="gazebo_ros" args="-file $(find r)/{file}"/></launch>', "warning", "warning"),
        # Damping is the drive's there, Bullet's effort the caller's, and the rest moves nothing.
        (_ISAAC, "info", "info"),
        # It writes and reads MJCFs, and has no MuJoCo.
        (f"{_ISAAC}root = ET.Element('mujoco')\n", "info", "info"),
        ("import isaaclab\nUrdfFileCfg(asset_path='{file}')\n", "info", "info"),
        ("import pybullet as p\np.loadURDF('{file}')\np.stepSimulation()\n", "info", "info"),
        (_GENESIS, "info", "info"),
        ("import pinocchio\nr = BuildFromURDF('{file}')\ntau = r.nle(q, v)\n", "info", "info"),
        (_RVIZ, "info", "info"),
        # What it writes over; a draw about what was there is no other figure.
        (f"{_OF_MUJOCO}m.dof_damping[:] = 0.5\n", "info", "warning"),
        (f"{_OF_MUJOCO}m.dof_frictionloss[m.joint('elbow').dofadr[0]] = 0.1\n", "warning", "info"),
        (f"{_OF_MUJOCO}for j in spec.joints:\n    j.damping = 0.5\n", "info", "warning"),
        (f"{_OF_MUJOCO}joint.set('frictionloss', '0')\n", "warning", "info"),
        (f"{_OF_MUJOCO}{_ISAAC}props['damping'].fill(1.0)\n", "info", "warning"),
        (f"{_OF_MUJOCO}m.dof_damping[:] = base * draw()\nm.dof_frictionloss[:] *= 2\n", "warning", "warning"),
        (
            f"{_OF_MUJOCO}assert m.dof_damping[0] == 4\nprint(m.dof_frictionloss, end='')\n",
            "warning",
            "warning",
        ),
    ],
)
@pytest.mark.parametrize("file", ["arm.urdf", "arm.xml"])
def test_damping_and_friction_by_what_simulates_them(
    file: str, program: str, damped: str, rubbing: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whoever takes the file as it stands has 2 N*m that brake 30 N*m*s/rad at 0.067 rad/s, and 9 N*m of friction."""
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    if file == "arm.xml" and program in (_GENESIS, _RVIZ):
        # Genesis has MuJoCo compile an MJCF, and RViz reads none.
        damped = rubbing = "warning"
    urdf = _LIMB.format(lower=-1).replace('damping="4"', 'damping="30" friction="9"')
    bodies = (
        '<body><geom size="0.1"/><joint name="elbow" range="-60 60" {}/><body><geom size="0.1"/>'
        '<joint name="wrist" range="-60 60" {}/></body></body>'
    ).format('damping="30"', 'frictionloss="9"')
    drives = "".join(f'<motor joint="{name}" forcerange="-2 2"/>' for name in ("elbow", "wrist"))
    mjcf = f"<mujoco><worldbody>{bodies}</worldbody><actuator>{drives}</actuator></mujoco>"
    Path("r", file).write_text(urdf if file == "arm.urdf" else mjcf)
    Path("r", "run.launch" if program.startswith("<") else "run.py").write_text(
        program.replace("{file}", file)
    )
    found = audit(["r"], Settings(select=("DMP103", "FRC101"))).findings
    assert {item.finding.code: item.severity.value for item in found} == {"DMP103": damped, "FRC101": rubbing}
    found = audit(["r"], Settings(select=("DMP103", "FRC101"), as_named=True)).findings
    assert {item.severity.value for item in found} == {"warning"}


@pytest.mark.parametrize(("speed", "cited"), [(3, "3 rad/s the"), (2.5, "2.5 rad/s (arm_b.urdf) the")])
def test_a_speed_that_is_a_file_s_own(
    speed: float, cited: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of files with one speed its own is told, and not the first's."""
    monkeypatch.chdir(tmp_path)
    own = _LIMB.format(lower=-1)
    Path("arm_b.urdf").write_text(own.replace('velocity="3"', f'velocity="{speed}"').replace('"4"', '"0.1"'))
    Path("arm_c.urdf").write_text(own)
    (found,) = audit(["arm_b.urdf", "arm_c.urdf"], Settings(select=("DMP103",))).findings
    assert found.finding.message.startswith(f"at the joint's {cited} damping of 4 ")


def test_a_model_that_lacks_a_submodule_stays_a_note(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is wrong with it, whoever names it."""
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    Path("r/scene.xml").write_text('<mujoco><include file="mujoco_menagerie/a/a.xml"/></mujoco>')
    Path("r/train.py").write_text("import mujoco\nFILE = 'scene.xml'\n")
    found = audit(["r"], Settings()).findings
    assert [(item.finding.code, item.severity.value) for item in found] == [("AUD008", "info")]


def test_a_stand_in_for_no_limit_stays_a_note(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Too many are meant so; whoever names the file is warned."""
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    Path("r/legs.urdf").write_text(_LEGS.format(left=1e6, right=1e6, speed=1e6))
    Path("r/train.py").write_text("FILE = 'legs.urdf'\n")
    own = [audit(["r"], Settings(select=("LIM101",), as_named=named)).findings for named in (False, True)]
    assert [{item.severity.value for item in found} for found in own] == [{"info"}, {"warning"}]


@pytest.mark.parametrize(
    ("program", "severity"),
    [
        ("FILE = 'models/legs.urdf'\n", "warning"),
        ("FILE = f'models/{name}.urdf'\nNAMES = ['legs']\n", "info"),
        ("FILE = 'models/legs.xacro'\n", "info"),
        ("FILE = 'models/legs.usd'\n", "info"),
        ("open('models/legs.urdf', 'w').write(text)\n", "info"),
        ("open('models/legs.urdf', 'w').write(text)\nload('models/legs.urdf')\n", "warning"),
        ("FILE = 'other/legs.urdf'\n", "info"),
        ("FILE = 'legs.urdf'\n", "warning"),
        ("# FILE = 'models/legs.urdf'\nFILE = 'models/arm.urdf'\n", "info"),
    ],
)
@pytest.mark.parametrize("copies", [1, 2])
def test_a_name_that_a_program_writes_out(
    program: str, severity: str, copies: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One that it makes up may be of any model, and one of two models of that name of the other."""
    monkeypatch.chdir(tmp_path)
    for at in range(copies):
        Path(f"r/models{at}").mkdir(parents=True)
        Path(f"r/models{at}/legs.urdf").write_text(_LEGS.format(left=3, right=5, speed=9))
        Path(f"r/models{at}/legs.xacro").write_text("<robot/>")
    Path("r/train.py").write_text(program)
    found = audit(["r"], Settings(select=("SYM101",))).findings
    assert {item.severity.value for item in found} == {severity if copies == 1 else "info"}


_POINT = "is the point in the wrong place?"
_LINKS = "that inertia is the links' alone: has the motor an armature?"


@pytest.mark.parametrize(
    ("gains", "severity", "help"),
    [
        ("stiffness=1e7, damping=1e4", "info", None),
        ("stiffness=4e6, damping=1e4", "warning", _POINT),
        ("stiffness=400.0, damping=80.0", "info", _LINKS),
        # 1.5 times 57.3; and of an armature that is stated.
        (
            "stiffness=400.0, damping=85.94",
            "warning",
            "is kd multiplied by 57.3? Without that it is 1.5 N*m*s/rad",
        ),
        (
            "armature=5e-5, stiffness=400.0, damping=80.0",
            "warning",
            "is kd multiplied by 57.3? Without that it is 1.396 N*m*s/rad",
        ),
        # Per degree they are, whatever power of ten that is.
        (
            "stiffness=1e-4, damping=1e-6",
            "warning",
            "is it per degree? Per radian it is 0.00573 N*m/rad, and kd 57.3 times as well",
        ),
    ],
)
def test_gains_of_arms_in_isaac_lab(
    gains: str, severity: str, help: str | None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A joint is rigid by a power of ten, and 400 and 80 hold arms whose rotor nobody states.

    80 / (2 sqrt(400 * 0.001)) is 63.2, above 60, and with 5e-5 kg*m^2 more 61.7; 85.94 make 67.9. sqrt(4e6 / 0.001) is
    63246 rad/s, above 3000, and sqrt(1e-4 / 0.001) 0.32.
    """
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    Path("r/arm.urdf").write_text(
        '<robot name="arm"><link name="base"/><link name="hand"><inertial><mass value="0.5"/>'
        '<inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<joint name="wrist" type="revolute"><parent link="base"/><child link="hand"/><axis xyz="0 0 1"/>'
        '<limit lower="-2" upper="2" effort="20" velocity="3"/></joint></robot>'
    )
    Path("r/arm.py").write_text(
        "from isaaclab.actuators import ImplicitActuatorCfg\nfrom isaaclab.assets import ArticulationCfg\n"
        "import isaaclab.sim as sim_utils\n"
        "ARM_CFG = ArticulationCfg(spawn=sim_utils.UrdfFileCfg(asset_path='arm.urdf'), actuators={'arm': "
        f"ImplicitActuatorCfg(joint_names_expr=['wrist'], effort_limit_sim=20.0, {gains})}})\n"
    )
    for as_named in (False, True):
        (item,) = audit(["r"], Settings(select=("UNT107",), as_named=as_named)).findings
        assert item.finding.help == help
        assert item.severity.value == ("warning" if as_named else severity)


_LEG = (
    "from isaaclab.actuators import ImplicitActuatorCfg\nfrom isaaclab.assets import ArticulationCfg\n"
    "LEG_CFG = ArticulationCfg(actuators={'leg': ImplicitActuatorCfg(joint_names_expr=['left_j'], stiffness=1.0, "
    "damping=100.0, effort_limit_sim=20.0)})\n"
)
_HAND = (
    "from mjlab.actuator import IdealPdActuatorCfg\nfrom mjlab.entity import EntityArticulationInfoCfg\n"
    "HAND = EntityArticulationInfoCfg(actuators=(IdealPdActuatorCfg(target_names_expr=('.*',), stiffness=60.0, "
    "damping=1.5, effort_limit=45.0, delay_min_lag=1, delay_max_lag=3, delay_hold_prob=1.0),))\n"
)


@pytest.mark.parametrize(
    ("code", "config", "task", "told"),
    [
        ("UNT107", _LEG, "robot.set_joint_position_target(target)\n", True),
        ("UNT107", _LEG, "robot.set_joint_velocity_target(target)\n", False),
        ("UNT107", _LEG, "go = robot.set_joint_velocity_target\n", False),
        ("UNT107", _LEG, "wheels = mdp.JointVelocityActionCfg(asset_name='robot')\n", False),
        ("DLY103", _HAND, "run(HAND)\n", True),
        ("DLY103", _HAND, "event = EventTermCfg(func=mdp.sync_actuator_delays, mode='reset')\n", False),
        ("DLY103", _HAND, "drive.set_lags(lags, env_ids)\n", False),
    ],
)
def test_what_a_task_commands(
    code: str, config: str, task: str, told: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Speeds, for which kp is small on purpose, and lags: these are held also where somebody names the folder."""
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    Path("r/robot.py").write_text(config)
    Path("r/task.py").write_text(f"from robot import LEG_CFG, HAND\n{task}use(LEG_CFG, HAND)\n")
    for as_named in (False, True):
        (item,) = audit(["r"], Settings(select=(code,), as_named=as_named)).findings
        assert item.finding.code == code
        warned = told or (as_named and code == "UNT107")
        assert item.severity.value == ("warning" if warned else "info")


@pytest.mark.parametrize(("joint", "severity"), [("left_caster", "info"), ("ankle", "warning")])
def test_a_joint_of_mjlab_that_its_name_says_has_no_drive(
    joint: str, severity: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three of four joints have a group."""
    monkeypatch.chdir(tmp_path)
    Path("r").mkdir()
    Path("r/dog.xml").write_text(
        '<mujoco model="dog"><worldbody>'
        + "".join(f'<body><joint name="{n}"/><geom size=".1"/>' for n in ("hip", "thigh", "knee", joint))
        + "</body></body></body></body></worldbody></mujoco>"
    )
    Path("r/dog_constants.py").write_text(
        "import mujoco\nfrom mjlab.actuator import BuiltinPositionActuatorCfg\n"
        "from mjlab.entity import EntityArticulationInfoCfg, EntityCfg\n"
        "def get_spec():\n    return mujoco.MjSpec.from_file('dog.xml')\n"
        "LEGS = BuiltinPositionActuatorCfg(target_names_expr=('hip', 'thigh', 'knee'), stiffness=20.0, damping=1.0)\n"
        "DOG = EntityArticulationInfoCfg(actuators=(LEGS,))\n"
        "def get_dog_cfg():\n    return EntityCfg(spec_fn=get_spec, articulation=DOG)\n"
    )
    for as_named in (False, True):
        (item,) = audit(["r"], Settings(select=("CFG102",), as_named=as_named)).findings
        assert item.finding.joint == joint
        assert item.severity.value == ("warning" if as_named else severity)
