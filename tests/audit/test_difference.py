"""What changed in effective dynamics between two files, in figures and in words."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.difference import Difference, compare_files
from actspec.diagnostics import AuditError
from actspec.readings.versions import Versions
from actspec.report.difference import lines, record, report_lines
from tests.audit.robots import CFG, LEG, SPEC

STEP = "# Written by actspec 0.1.0 for Isaac Lab 2.3 on Isaac Sim 5.1 (PhysX). \n# physics_dt 0.005 s\n"
"""The step that a written configuration is made for."""
EFFECTS = ("natural frequency", "damping ratio")


def compare(
    tmp_path: Path, old: tuple[str, str], new: tuple[str, str], robot: str | None = None
) -> tuple[Difference, ...]:
    """Two files, each in a folder of its own."""
    paths = []
    for folder, (name, text) in zip(("old", "new"), (old, new), strict=True):
        path = tmp_path / folder / name
        path.parent.mkdir()
        path.write_text(text)
        if name.endswith(".yaml"):
            (path.parent / "leg.xml").write_text(LEG)
        paths.append(str(path))
    return compare_files(paths[0], paths[1], Versions(), robot)


def told(found: Difference) -> list[str]:
    """Its lines, without those whose figures an engine computes."""
    return [line for line in lines(found, "") if not line.strip().startswith(EFFECTS)]


TASK = f"""{CFG}
from isaaclab.envs import ManagerBasedRLEnvCfg
from isaaclab.scene import InteractiveSceneCfg
import isaaclab.envs.mdp as mdp


class LegSceneCfg(InteractiveSceneCfg):
    robot = LEG_CFG.replace(prim_path="Robot")


class ActionsCfg:
    joint_pos = mdp.JointPositionActionCfg(asset_name="robot", joint_names=[".*"], scale=0.25)


class LegEnvCfg(ManagerBasedRLEnvCfg):
    scene = LegSceneCfg()
    actions = ActionsCfg()

    def __post_init__(self):
        self.decimation = 10
        self.sim.dt = 0.002


class LegEnvCfg_PLAY(LegEnvCfg):
    def __post_init__(self):
        super().__post_init__()
        self.scene.num_envs = 50
"""
"""A robot alone, in a scene, in a task, and in the task that plays it."""


@pytest.mark.parametrize("other", [("leg.xml", LEG), ("leg.yaml", SPEC)])
def test_a_robot_its_scene_and_its_task_are_one(other: tuple[str, str], tmp_path: Path) -> None:
    """The one that says the most is compared; the spec's period is that of the task, 10 x 2 ms."""
    (found,) = compare(tmp_path, other, ("task_cfg.py", TASK))
    assert found.new.name == "LegEnvCfg"
    assert found.new.settings["control_dt"] == 0.02
    assert found.same


@pytest.mark.parametrize(
    "old, new",
    [
        ("self.scene.num_envs = 50", "self.decimation = 5"),
        ("self.scene.num_envs = 50", 'self.scene.robot.actuators["legs"].stiffness = 50.0'),
        ("super().__post_init__()", "self.decimation = 5"),
    ],
    ids=["decimation", "gain", "step not stated"],
)
def test_tasks_that_contradict_are_several(old: str, new: str, tmp_path: Path) -> None:
    """Nobody guesses which is meant."""
    assert old in TASK
    with pytest.raises(AuditError, match="DIF003"):
        compare(tmp_path, ("leg.yaml", SPEC), ("task_cfg.py", TASK.replace(old, new)))


KNEE = '    <position name="knee" joint="knee" kp="100" kv="3" forcerange="-30 30" forcelimited="true"/>\n'
MJLAB = """from mjlab.actuator import BuiltinPositionActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg

LEG_CFG = EntityArticulationInfoCfg(
    actuators=(BuiltinPositionActuatorCfg(target_names_expr=("hip", "knee"), stiffness=100.0, damping=3.0),)
)
"""
DEPLOY = "robot: leg\njoint_names: [hip, knee]\nkp: [100, 100]\nkd: [3, 3]\n"


@pytest.mark.parametrize(
    "name, text, drive",
    [
        ("leg.yaml", SPEC, "ideal_pd"),
        ("leg_cfg.py", CFG, "ideal_pd"),
        ("leg_deploy.yaml", DEPLOY, "ideal_pd"),
        ("leg_deploy.yaml", DEPLOY.replace("[100, 100]", "[100, 0]").replace("[3, 3]", "[3, 0]"), None),
        ("leg_cfg.py", MJLAB, None),
    ],
    ids=["spec", "Isaac Lab", "deploy", "deploy of 0", "mjlab"],
)
def test_a_drive_that_a_model_lacks(name: str, text: str, drive: str | None, tmp_path: Path) -> None:
    """Of another kind of file that has it, it is a change; mjlab adds its actuators to the model's, and 0 is none."""
    other, bare = (name, text), ("leg.xml", LEG.replace(KNEE, ""))
    for old, new, words in ((other, bare, "{} -> none"), (bare, other, "none -> {}")):
        folder = tmp_path / words.replace(" ", "")
        folder.mkdir()
        (found,) = compare(folder, old, new)
        expected = [] if drive is None else ["knee:", f"  drive {words.format(drive)}"]
        assert [line for line in told(found) if "knee" in line or "drive " in line] == expected
        assert found.same is (drive is None)


@pytest.mark.parametrize(
    "old, new, expected",
    [
        # 3 + 1 = 4 and 3 + 19 = 22; 22 / 4 = 5.5
        (
            'name="knee" range="-1 1" limited="true" damping="1"',
            'name="knee" range="-1 1" limited="true" damping="19"',
            ["knee:", "  joint damping 1 -> 19 N*m*s/rad (x19)", "  total damping 4 -> 22 N*m*s/rad (x5.5)"],
        ),
        # Both joints change alike, and stand together; 3.72 + 1 = 4.72 = 4 + 18 %
        (
            'kv="3"',
            'kv="3.72"',
            [
                "hip, knee:",
                "  drive gain kd 3 -> 3.72 N*m*s/rad (+24 %)",
                "  total damping 4 -> 4.72 N*m*s/rad (+18 %)",
            ],
        ),
        (
            'forcerange="-30 30" forcelimited="true"',
            "",
            ["hip, knee:", "  effort limit 30 N*m -> none"],
        ),
        (
            'timestep="0.002" integrator="implicitfast"',
            'timestep="0.004" integrator="Euler"',
            ["physics step 0.002 -> 0.004 s (+100 %)", "integrator implicitfast -> Euler"],
        ),
        (
            '<position name="knee" joint="knee" kp="100" kv="3"',
            '<velocity name="knee" joint="knee" kv="3"',
            ["knee:", "  drive position -> velocity", "  stiffness kp 100 -> 0 N*m/rad"],
        ),
        (
            'name="knee" range="-1 1"',
            'name="shin" range="-1 1"',
            ["joints added: shin", "joints removed: knee"],
        ),
        (
            '<position name="hip"',
            '<position timeconst="0.01" name="hip"',
            # 1 / (2 pi 0.01) = 15.9155
            ["hip:", "  cutoff of the command filter none -> 15.9155 Hz"],
        ),
        # 150 u = 100 q at rest
        (
            '<position name="knee" joint="knee" kp="100" kv="3"',
            '<general name="knee" joint="knee" gainprm="150" biastype="affine" biasprm="0 -100 -3"',
            ["knee:", "  command gain over kp 1 -> 1.5 (+50 %)"],
        ),
        # 5 - 100 q = 100 (0 - (q - 0.05)): the encoder reads 0.05 rad less than there is
        (
            '<position name="knee" joint="knee" kp="100" kv="3"',
            '<general name="knee" joint="knee" gainprm="100" biastype="affine" biasprm="5 -100 -3"',
            ["knee:", "  encoder bias 0 -> -0.05 rad"],
        ),
    ],
    ids=[
        *("one joint", "alike", "limit", "steps", "drive", "renamed", "filter"),
        *("command gain", "constant force"),
    ],
)
def test_changes_in_words(old: str, new: str, expected: list[str], tmp_path: Path) -> None:
    """Each change is told with its figures, ratio or percent, and the joints that share it."""
    assert old in LEG
    text = LEG.replace(old, new)
    if "shin" in new:
        text = text.replace('joint="knee"', 'joint="shin"')
    (found,) = compare(tmp_path, ("leg.xml", LEG), ("leg.xml", text))
    assert told(found) == expected


MOTOR = LEG.replace(
    '<position name="knee" joint="knee" kp="100" kv="3"', '<motor name="knee" joint="knee" gear="2"'
)
"""The leg, its knee with a motor."""

OTHER_WAY = ": a positive control drives the joint the other way"
TURNED = ": its positive positions, speeds and torques are the other way"


@pytest.mark.parametrize(
    "text, old, new, expected",
    [
        # Its ctrl is a torque of 2 N*m, then of -2 N*m.
        (
            MOTOR,
            'gear="2"',
            'gear="-2"',
            [f"torque per control (gear x gain) 2 -> -2 N*m{OTHER_WAY}"],
        ),
        # The limit, 30 N*m in front of the gear, was 60 N*m behind it.
        (
            MOTOR,
            'gear="2" forcerange="-30 30"',
            'gear="4" forcerange="-15 15"',
            ["torque per control (gear x gain) 2 -> 4 N*m (+100 %)"],
        ),
        # kp and kd go by the square of the gear, and are what they were.
        (
            LEG,
            'name="knee" joint="knee"',
            'gear="-1" name="knee" joint="knee"',
            [f"command gain over kp 1 -> -1{OTHER_WAY}"],
        ),
        (LEG, 'name="knee" range', 'axis="0 0 -1" name="knee" range', [f"axis {{}} 0 0 1 -> 0 0 -1{TURNED}"]),
        (LEG, 'name="knee" range', 'axis="0 2 0" name="knee" range', ["axis {} 0 0 1 -> 0 1 0"]),
        # 180 deg about x turn z to -z: the joint is as it was drawn, in another frame.
        (
            LEG,
            '<body pos="0 0 -0.2">\n        <joint name="knee"',
            '<body pos="0 0 -0.2" quat="0 1 0 0">\n        <joint axis="0 0 -1" name="knee"',
            [],
        ),
        # And without the axis' own turn it is the other way.
        (
            LEG,
            '<body pos="0 0 -0.2">',
            '<body pos="0 0 -0.2" quat="0 1 0 0">',
            [f"axis {{}} 0 0 1 -> 0 0 -1{TURNED}"],
        ),
        # 6e-4 rad are no other axis.
        (LEG, 'name="knee" range', 'axis="0 0.0006 1" name="knee" range', []),
        # A scene turns the whole robot.
        (LEG, "<body>", '<body euler="90 0 0">', []),
    ],
    ids=[
        *("motor", "torque per control", "servo", "axis", "other axis", "frame and axis", "frame", "nearly"),
        "whole robot",
    ],
)
def test_directions(text: str, old: str, new: str, expected: list[str], tmp_path: Path) -> None:
    """Which way a control drives a joint, and which way a joint is positive, is part of what a policy meets."""
    assert old in text
    (found,) = compare(tmp_path, ("leg.xml", text), ("leg.xml", text.replace(old, new)))
    indented = [f"  {line.format(IN_BASE)}" for line in expected]
    # Links on another axis have another inertia about it.
    lines = [line for line in told(found) if "inertia of the links" not in line]
    assert lines == (["knee:", *indented] if expected else [])


IN_BASE = "in the base's frame"


def test_an_axis_of_a_urdf(tmp_path: Path) -> None:
    """The knee, 90 deg about x away from the hip, turns about y of the base, and the other way."""
    mass = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
    urdf = f"""<robot name="leg"><link name="base"/><link name="thigh">{mass}</link><link name="shank">{mass}</link>
<joint name="hip" type="continuous"><parent link="base"/><child link="thigh"/><axis xyz="1 0 0"/></joint>
<joint name="knee" type="continuous"><parent link="thigh"/><child link="shank"/>
<origin rpy="1.5707963267948966 0 0"/><axis xyz="0 0 -1"/></joint></robot>"""
    (found,) = compare(tmp_path, ("leg.urdf", urdf), ("leg.urdf", urdf.replace("0 0 -1", "0 0 1")))
    # z turned by 90 deg about x is -y.
    assert told(found) == ["knee:", f"  axis {IN_BASE} 0 1 0 -> 0 -1 0{TURNED}"]


def test_an_axis_that_is_not_known(tmp_path: Path) -> None:
    """Of a file that MuJoCo refuses only the text is read."""
    broken = LEG.replace("<geom size", '<geom mesh="gone" size')
    (found,) = compare(tmp_path, ("leg.xml", LEG), ("leg.xml", broken))
    assert "  not compared: axis in the base's frame at 2 joints, unknown" in list(
        report_lines([found], "old", "new")
    )


def test_two_motors_of_one_joint(tmp_path: Path) -> None:
    """An antagonist is no torque per control of both."""
    both = MOTOR.replace("</actuator>", '<motor name="back" joint="knee" gear="-2"/></actuator>')
    (found,) = compare(tmp_path, ("leg.xml", both), ("leg.xml", both))
    assert found.same
    assert "torque_per_control" not in found.new.joints["knee"].figures


def test_a_motor_has_no_command_gain(tmp_path: Path) -> None:
    """Before it became a servo with a gain of its own there was none, and not 1."""
    servo = '<position name="knee" joint="knee" kp="100" kv="3"'
    motor = LEG.replace(servo, '<motor name="knee" joint="knee"')
    general = '<general name="knee" joint="knee" gainprm="150" biastype="affine" biasprm="0 -100 -3"'
    (found,) = compare(tmp_path, ("leg.xml", motor), ("leg.xml", LEG.replace(servo, general)))
    assert "  command gain over kp none -> 1.5" in told(found)


def test_damping_ratio_follows(tmp_path: Path) -> None:
    """Total damping of 5.5 times gives 5.5 times the damping ratio, and the natural frequency stays."""
    text = LEG.replace('damping="1"', 'damping="19"')
    (found,) = compare(tmp_path, ("leg.xml", LEG), ("leg.xml", text))
    assert {change.field for change in found.effects} == {"damping_ratio"}
    for change in found.effects:
        assert change.ratio == pytest.approx(5.5, rel=1e-9)


def test_links_are_seen(tmp_path: Path) -> None:
    """A heavier shank is another robot under the same actuators."""
    text = LEG.replace(
        '<geom size="0.1"/>\n      </body>', '<geom size="0.1" density="2000"/>\n      </body>'
    )
    assert text != LEG
    (found,) = compare(tmp_path, ("leg.xml", LEG), ("leg.xml", text))
    assert {change.field for change in found.changes} == {"inertia_min", "inertia_max"}
    assert {change.joint for change in found.changes if change.ratio == pytest.approx(2.0)} == {"knee"}


def test_text_is_no_change(tmp_path: Path) -> None:
    """Comments, order of attributes and ways to write a number are not dynamics; neither is a sum's last digit."""
    text = LEG.replace("<worldbody>", "<!-- a leg --><worldbody>").replace('kv="3"', 'kv="3.0000000000001"')
    (found,) = compare(tmp_path, ("leg.xml", LEG), ("leg.xml", text.replace("-30 30", "-3e1 30.0")))
    assert found.same


@pytest.mark.parametrize(
    "other, expected",
    [
        (("leg.yaml", SPEC), []),
        (("leg_cfg.py", CFG), []),
        (
            ("leg_cfg.py", CFG.replace("stiffness=100.0", "stiffness=150.0")),
            ["hip, knee:", "  stiffness kp 100 -> 150 N*m/rad (+50 %)"],
        ),
        (
            ("leg.yaml", SPEC.replace("kd: 3", "kd: 6")),
            [
                "hip, knee:",
                "  drive gain kd 3 -> 6 N*m*s/rad (+100 %)",
                "  total damping 4 -> 7 N*m*s/rad (+75 %)",
            ],
        ),
    ],
    ids=["spec", "cfg", "cfg kp", "spec kd"],
)
def test_kinds_compare(other: tuple[str, str], expected: list[str], tmp_path: Path) -> None:
    """An MJCF compares with a spec and a cfg in what both say; what one of them lacks is no change."""
    (found,) = compare(tmp_path, ("leg.xml", LEG), other)
    assert told(found) == expected


URDF = """<robot name="leg">
  <link name="base"/><link name="thigh"/><link name="shank"/>
  <joint name="hip" type="revolute">
    <parent link="base"/><child link="thigh"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="45" velocity="20"/>
  </joint>
  <joint name="knee" type="revolute">
    <parent link="thigh"/><child link="shank"/><axis xyz="0 0 1"/>
    <limit lower="-1" upper="1" effort="30" velocity="20"/>
  </joint>
</robot>
"""


def test_what_a_kind_leaves_to_others_is_no_change(tmp_path: Path) -> None:
    """A URDF without friction and a motor without gains say nothing about friction and gains."""
    text = LEG.replace("-1 1", "-57.295779513082323 57.295779513082323")
    (found,) = compare(tmp_path, ("leg.urdf", URDF), ("leg.xml", text))
    # 30 / 45 = 1 - 33.3 %
    assert told(found) == ["hip:", "  effort limit 45 -> 30 N*m (-33.3 %)"]


def test_what_one_side_alone_states_is_told(tmp_path: Path) -> None:
    """It is counted and shown with its figures, and nobody calls two kinds of file equal beside it."""
    text = LEG.replace("-1 1", "-57.295779513082323 57.295779513082323")
    (found,) = compare(tmp_path, ("leg.urdf", URDF.replace('"45"', '"30"')), ("leg.xml", text))
    assert found.same
    # Per joint: effort limit and the two ends of its range.
    assert found.compared == 2 * 3
    # Of the URDF 2 speeds; of the MJCF step and integrator, and kp, kd, joint damping, armature at 2 joints.
    told = list(report_lines([found], "leg.urdf", "leg.xml"))
    assert told == [
        "leg.urdf -> leg.xml (leg)",
        "  no change in 6 figures that both state",
        "  only leg.urdf states 2 figures, which are not compared:",
        "    velocity limit 20 rad/s (2 joints)",
        "  only leg.xml states 10 figures, which are not compared:",
        "    physics step 0.002 s",
        "    integrator implicitfast",
        "    stiffness kp 100 N*m/rad (2 joints)",
        "    drive gain kd 3 N*m*s/rad (2 joints)",
        "    joint damping 1 N*m*s/rad (2 joints)",
        "    armature 0.01 kg*m^2 (2 joints)",
        "  not compared: largest inertia of the links at 2 joints, unknown",
    ]
    entry = record(found, "leg.urdf", "leg.xml")
    assert (entry["changes"], entry["compared"], len(entry["not_compared"])) == ([], 6, 2 + 10 + 2)
    words = {one["words"] for one in entry["not_compared"] if one["joint"] == "hip"}
    assert "stiffness kp not stated -> 100 N*m/rad" in words
    assert "velocity limit 20 rad/s -> not stated" in words


def test_nothing_in_common_is_no_agreement(tmp_path: Path) -> None:
    """A URDF and a deploy file of gains share joints and no figure: that is not `no change`."""
    deploy = "joint_names: [hip, knee]\nkp: [100, 100]\nkd: [3, 3]\n"
    (found,) = compare(tmp_path, ("leg.urdf", URDF), ("leg_deploy.yaml", deploy))
    assert (found.compared, found.changes, found.same) == (0, (), False)
    assert "  nothing was compared: no figure is stated by both" in report_lines([found], "a", "b")


@pytest.mark.parametrize(
    "old, new, expected",
    [
        ("brake_torque: 32", "brake_torque: 40", ["  brake torque of the curve 32 -> 40 N*m (+25 %)"]),
        ("no_load_speed: 24", "no_load_speed: 20", ["  no-load speed of the curve 24 -> 20 rad/s (-16.7 %)"]),
        (
            "[0.9, 1.1]",
            "[0.5, 1.1]",
            [
                "  randomization of armature scale 0.9 to 1.1 (uniform, at startup, per joint) -> "
                "scale 0.5 to 1.1 (uniform, at startup, per joint)"
            ],
        ),
        (
            "    randomize: {armature: {scale: [0.9, 1.1], when: startup, per: joint}}\n",
            "",
            ["  randomization of armature scale 0.9 to 1.1 (uniform, at startup, per joint) -> none"],
        ),
    ],
    ids=["curve", "its end", "range", "no range"],
)
def test_what_a_spec_has_beside_its_figures(old: str, new: str, expected: list[str], tmp_path: Path) -> None:
    """A curve of the motor and ranges of randomisation are no row of the ledger, and change what a policy learns."""
    curve = (
        "curve: {drive_torque: 25 N*m, brake_torque: 32 N*m, knee_speed: 12 rad/s, no_load_speed: 24 rad/s}"
    )
    text = SPEC.replace("ideal_pd", "dc_motor\n    motor: m").replace(
        "actuators:", f"motors:\n  m: {{side: joint, {curve}}}\nactuators:"
    )
    text += "    randomize: {armature: {scale: [0.9, 1.1], when: startup, per: joint}}\n"
    assert old in text
    (found,) = compare(tmp_path, ("leg.yaml", text), ("leg.yaml", text.replace(old, new)))
    assert told(found) == ["hip, knee:", *expected]


def test_unknown_is_not_none(tmp_path: Path) -> None:
    """A gain that the spec calls unknown is not a drive without one."""
    (found,) = compare(tmp_path, ("leg.yaml", SPEC), ("leg.yaml", SPEC.replace("100 N*m/rad", "unknown")))
    assert told(found) == ["hip, knee:", "  stiffness kp 100 N*m/rad -> unknown"]


def test_what_both_compute_is_not_called_equal(tmp_path: Path) -> None:
    """A gain that neither configuration states as a number may be another one."""
    one, other = (CFG.replace("stiffness=100.0", f"stiffness=gain({n})") for n in (1, 2))
    (found,) = compare(tmp_path, ("leg_cfg.py", one), ("leg_cfg.py", other))
    assert found.same
    # Of 2 joints: kd, limit and the friction as it is written; and the back-EMF of 0 that such a drive has.
    assert list(report_lines([found], "a.py", "b.py")) == [
        "a.py -> b.py (LEG_CFG)",
        "  no change in 8 figures",
        "  not compared: stiffness kp at 2 joints, unknown",
    ]


def test_a_motor_is_no_drive_without_gains(tmp_path: Path) -> None:
    """What drives a motor is in the configuration, so its gain of 0 is not compared with the configuration's."""
    text = LEG
    for name in ("hip", "knee"):
        text = text.replace(
            f'<position name="{name}" joint="{name}" kp="100" kv="3"', f'<motor name="{name}" joint="{name}"'
        )
    assert "<position" not in text
    (found,) = compare(tmp_path, ("leg.xml", text), ("leg_cfg.py", CFG))
    assert told(found) == []


def test_friction_of_unknown_unit_is_seen(tmp_path: Path) -> None:
    """Without a version nobody knows the unit of Isaac Lab's friction, and a change of it is one all the same."""
    text = CFG.replace("friction=0.2", "friction=0.3")
    (found,) = compare(tmp_path, ("leg_cfg.py", CFG), ("leg_cfg.py", text))
    assert told(found) == ["hip, knee:", "  friction as written 0.2 -> 0.3 (+50 %)"]


@pytest.mark.parametrize(
    "head, old, new, expected",
    [
        # Without a step nobody knows the seconds: the steps are compared.
        ("", "max_delay=4", "max_delay=6", ["largest delay 4 -> 6 physics steps (+50 %)"]),
        ("", "min_delay=1", "min_delay=2", ["least delay 1 -> 2 physics steps (+100 %)"]),
        # 4 and 6 steps of 5 ms
        (STEP, "max_delay=4", "max_delay=6", ["largest delay 0.02 -> 0.03 s (+50 %)"]),
        # A fixed delay is one figure.
        (STEP, "min_delay=1, max_delay=4", "min_delay=4, max_delay=4", [
            "delay none -> 0.02 s", "least delay 0.005 s -> none", "largest delay 0.02 s -> none"
        ]),
    ],
    ids=["largest", "least", "in seconds", "fixed"],
)  # fmt: skip
def test_delays_of_configurations(head: str, old: str, new: str, expected: list[str], tmp_path: Path) -> None:
    """A lag is compared in seconds, or in steps where nobody states their length."""
    group = "min_delay=1, max_delay=4, stiffness"
    text = head + CFG.replace("IdealPDActuatorCfg", "DelayedPDActuatorCfg").replace("stiffness", group)
    (found,) = compare(tmp_path, ("leg_cfg.py", text), ("leg_cfg.py", text.replace(old, new)))
    assert told(found) == ["hip, knee:", *(f"  {line}" for line in expected)]


def test_robots_of_one_file_by_name(tmp_path: Path) -> None:
    """Robots are matched by name; of several that match nothing, one can be named, and else they are listed."""
    head, _, body = CFG.partition("LEG_CFG")
    two = f"{head}FIRST_CFG{body}\nLEG_CFG{body.replace('stiffness=100.0', 'stiffness=150.0')}"
    found, new = compare(tmp_path, ("leg_cfg.py", CFG), ("leg_cfg.py", two))
    assert [change.field for change in found.changes] == ["kp", "kp"]
    # The other one is all new: nobody says `no change` beside it.
    assert (new.new.name, new.added, new.removed, new.changes) == ("FIRST_CFG", ("hip", "knee"), (), ())

    other = two.replace("LEG_CFG", "SECOND_CFG")
    (tmp_path / "third").mkdir()
    (tmp_path / "third" / "leg_cfg.py").write_text(other)
    paths = (str(tmp_path / "old" / "leg_cfg.py"), str(tmp_path / "third" / "leg_cfg.py"))
    with pytest.raises(AuditError) as caught:
        compare_files(*paths, Versions(), None, {paths[0]: "a.py", paths[1]: "b.py"})
    (item,) = caught.value.diagnostics
    assert (item.code, item.message, item.help) == (
        "DIF003",
        "it is not known which robots are the same: a.py has LEG_CFG; b.py has FIRST_CFG, SECOND_CFG",
        "name one with --robot NAME",
    )
    (found,) = compare_files(*paths, Versions(), "FIRST_CFG")
    assert found.same
    with pytest.raises(AuditError) as caught:
        compare_files(paths[0], paths[0], Versions(), "NOSUCH_CFG", {paths[0]: "a.py"})
    (item,) = caught.value.diagnostics
    assert item.message == "no robot is called 'NOSUCH_CFG': a.py has LEG_CFG; a.py has LEG_CFG"


@pytest.mark.parametrize("robot, changed", [("FIRST_CFG", []), ("SECOND_CFG", ["kp", "kp"])])
def test_patterns_of_the_robot_that_is_named(robot: str, changed: list[str], tmp_path: Path) -> None:
    """The patterns of the one that is named are joints of the spec, which of two robots nobody could say."""
    head, _, body = CFG.replace('"hip", "knee"', '"hi.*", "kn.*"').partition("LEG_CFG")
    two = f"{head}FIRST_CFG{body}\nSECOND_CFG{body.replace('stiffness=100.0', 'stiffness=150.0')}"
    (found,) = compare(tmp_path, ("leg.yaml", SPEC), ("two_cfg.py", two), robot)
    assert (found.added, found.removed) == ((), ())
    assert [change.field for change in found.changes] == changed


def test_tendons_are_seen(tmp_path: Path) -> None:
    """What drives a tendon is compared by its name."""
    text = LEG.replace(
        "<actuator>",
        '<tendon><fixed name="t"><joint joint="hip" coef="1"/></fixed></tendon>\n'
        '<actuator><position name="pull" tendon="t" kp="7"/>',
    )
    (found,) = compare(tmp_path, ("leg.xml", text), ("leg.xml", text.replace('kp="7"', 'kp="14"')))
    assert told(found) == ["actuator pull:", "  stiffness kp 7 -> 14 (+100 %)"]


def test_a_step_that_a_spec_leaves_to_the_engine(tmp_path: Path) -> None:
    """MuJoCo's 2 ms are nobody's number, beside another one: not stated. A model's own are what changes."""
    text = SPEC.replace("timing: {physics_dt: 2 ms", "timing: {physics_dt: 5 ms")
    left = "".join(line for line in text.splitlines(keepends=True) if not line.startswith("timing:"))
    old, new = tmp_path / "old.yaml", tmp_path / "new.yaml"
    (tmp_path / "leg.xml").write_text(LEG)

    def first(*paths: Path) -> str:
        (found,) = compare_files(*map(str, paths), Versions(), None)
        return told(found)[0]

    old.write_text(text)
    new.write_text(left)
    assert first(old, new) == "physics step 0.005 -> 0.002 s (x0.4)"
    for path, without in ((old, text), (new, left)):
        path.write_text(without.replace("model: leg.xml", "model: none, joints: [hip, knee]"))
    assert first(old, new) == "physics step 0.005 s -> not stated"
    assert first(new, old) == "physics step not stated -> 0.005 s"
