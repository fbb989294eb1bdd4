"""Mistakes that people make in compiled files, one at a time: each is found, with its own code."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.verify.making import URDF, URDF_SPEC, Built, Edit, both, build, matched, replaced, swapped


@dataclass(frozen=True)
class Fault:
    """One mistake.

    Attributes:
        target: In whose file.
        edit: What is done to it.
        code: What must be said.
        quantity: Of what.
        file: End of the file's name; "": the main one.
    """

    target: str
    edit: Edit
    code: str
    quantity: str
    file: str = ""


LEFT_HIP = r'name="left_hip" range="-60 60" damping="0.05"'
ISAAC = ("isaaclab", "custom", "implicit", "il3")
"""Targets whose friction is a torque, with a viscous field of its own."""

FAULTS: dict[str, Fault] = {
    # --- damping counted twice: 1.5 is the drive's gain, 0.05 the joint's friction
    "mujoco kd as joint damping": Fault(
        "mujoco", replaced('damping="0.05"', 'damping="1.5"', 0), "VFY101", "joint_damping"
    ),
    "mujoco kd and joint damping summed": Fault(
        "mujoco", replaced('damping="0.05"', 'damping="1.55"', 0), "VFY101", "joint_damping"
    ),
    "mujoco kd at the actuator too": Fault(
        "mujoco", replaced("<dcmotor ", '<dcmotor damping="1.5" ', 0), "VFY101", "joint_damping"
    ),
    "mujoco viscous in the gain": Fault("mujoco", replaced("40 0 1.5 ", "40 0 1.55 ", 0), "VFY101", "kd"),
    **{
        f"{name} kd as viscous friction": Fault(
            name, replaced("viscous_friction=0.05", "viscous_friction=1.5"), "VFY101", "joint_damping"
        )
        for name in ISAAC
    },
    **{
        f"{name} viscous in damping too": Fault(
            name, replaced("damping=1.5,", "damping=1.55,"), "VFY101", "kd"
        )
        for name in ISAAC
    },
    # There 1.5 + 0.05 stand in `damping`, because the joint has no field for its own.
    "il45 viscous in damping twice": Fault("il45", replaced("damping=1.55,", "damping=1.6,"), "VFY101", "kd"),
    "mjlab kd as viscous damping": Fault(
        "mjlab", replaced("viscous_damping=0.05", "viscous_damping=1.5"), "VFY101", "joint_damping"
    ),
    "deploy viscous in kd": Fault("deploy", replaced("kd: [1.5,", "kd: [1.55,"), "VFY101", "kd"),
    # --- friction in another unit or field: 0.3 N*m dry, 0.05 N*m*s/rad viscous
    "mujoco dry friction as damping": Fault(
        "mujoco", replaced('damping="0.05"', 'damping="0.3"', 0), "VFY102", "joint_damping"
    ),
    "mujoco viscous as dry friction": Fault(
        "mujoco", replaced('frictionloss="0.3"', 'frictionloss="0.05"', 0), "VFY102", "frictionloss"
    ),
    # 0.3 N*m / 22.5 N*m
    "mujoco friction without unit": Fault(
        "mujoco", replaced('frictionloss="0.3"', 'frictionloss="0.013333333"', 0), "VFY102", "frictionloss"
    ),
    "mujoco friction in mN*m": Fault(
        "mujoco", replaced('frictionloss="0.3"', 'frictionloss="300"', 0), "VFY102", "frictionloss"
    ),
    **{
        f"{name} friction is a coefficient": Fault(
            name, replaced("dynamic_friction=0.3", "dynamic_friction=0.012"), "VFY102", "frictionloss"
        )
        for name in ISAAC
    },
    "il45 friction is a torque": Fault(
        "il45",
        replaced("damping=1.55,", "damping=1.55,\n        friction=0.3,"),
        "VFY102",
        "friction_setting",
    ),
    "mjlab friction in mN*m": Fault(
        "mjlab", replaced("frictionloss=0.3,", "frictionloss=300.0,"), "VFY102", "frictionloss"
    ),
    # --- gears: 9, and 1.5 more at the knees
    "mujoco gear counted again": Fault("mujoco", replaced('gear="1"', 'gear="9"'), "VFY103", "effort_limit"),
    "mujoco limit at the motor": Fault(
        "mujoco", replaced('saturation="22.5', 'saturation="2.5', 0), "VFY103", "effort_limit"
    ),
    "mujoco armature times n": Fault(
        "mujoco", replaced('armature="0.0081"', 'armature="0.0009"', 0), "VFY103", "armature"
    ),
    "mujoco armature at the rotor": Fault(
        "mujoco", replaced('armature="0.0081"', 'armature="0.0001"', 0), "VFY103", "armature"
    ),
    "mujoco reduction left out": Fault(
        "mujoco", replaced("-33.75 33.75", "-22.5 22.5", 0), "VFY103", "effort_limit"
    ),
    "isaaclab speed at the motor": Fault(
        "isaaclab", replaced("velocity_limit=30.0", "velocity_limit=270.0"), "VFY103", "no_load_speed"
    ),
    "mjlab armature times n": Fault(
        "mjlab", replaced("armature=0.018225", "armature=0.00135", 0), "VFY103", "armature"
    ),
    # --- limits lost
    "mujoco limit off": Fault(
        "mujoco", replaced('forcelimited="true"', 'forcelimited="false"', 0), "VFY104", "effort_limit"
    ),
    "isaaclab limit 1e9": Fault(
        "isaaclab", replaced("effort_limit=22.5", "effort_limit=1e9"), "VFY104", "effort_limit"
    ),
    "isaaclab limit 0": Fault(
        "isaaclab", replaced("effort_limit=22.5", "effort_limit=0.0"), "VFY104", "effort_limit"
    ),
    "mjlab limit left out": Fault(
        "mjlab", matched(r"  effort_limit=33.75,[^\n]*\n", ""), "VFY104", "effort_limit"
    ),
    "deploy limit 0": Fault(
        "deploy", replaced("effort_limit: [22.5,", "effort_limit: [0.0,"), "VFY104", "effort_limit"
    ),
    "implicit speed limit 1e9": Fault(
        "implicit", replaced("velocity_limit_sim=25.0", "velocity_limit_sim=1e9"), "VFY104", "velocity_limit"
    ),
    # --- units: 30 rad/s = 286.479 rpm, 60 N*m/rad = 1.04720 N*m/deg, 20 Hz = 125.664 rad/s
    "mujoco no-load speed in rpm": Fault(
        "mujoco", replaced('nominal="24 36 30"', 'nominal="24 36 286.478898"', 0), "VFY105", "no_load_speed"
    ),
    "mujoco gains per degree": Fault(
        "mujoco",
        both(
            replaced('gainprm="60 ', 'gainprm="1.04719755 '),
            replaced('biasprm="-1.2 -60', 'biasprm="-0.0209439510 -1.04719755'),
        ),
        "VFY105",
        "kp",
    ),
    "isaaclab speed limit in rpm": Fault(
        "isaaclab",
        replaced("velocity_limit_sim=25.0", "velocity_limit_sim=238.732415"),
        "VFY105",
        "velocity_limit",
    ),
    "isaaclab stiffness per degree": Fault(
        "isaaclab", replaced("stiffness=40.0", "stiffness=0.698131701"), "VFY105", "kp"
    ),
    "custom cutoff in rad/s": Fault(
        "custom", replaced("filter_cutoff=20.0", "filter_cutoff=125.663706"), "VFY105", "filter_cutoff"
    ),
    "mjlab viscous per degree": Fault(
        "mjlab", replaced("viscous_damping=0.05", "viscous_damping=2.86478898"), "VFY105", "joint_damping"
    ),
    "deploy pose in degrees": Fault(
        "deploy",
        matched(
            r"default_position: \[0\.1, -0\.8, -0\.1, -0\.8,",
            "default_position: [5.7295780, -45.836624, -5.7295780, -45.836624,",
        ),
        "VFY105",
        "default_position",
    ),
    # --- signs
    "mujoco bias turned": Fault("mujoco", replaced("-1.2 -60 -2", "1.2 -60 -2"), "VFY106", "encoder_bias"),
    "isaaclab stiffness turned": Fault(
        "isaaclab", replaced("stiffness=40.0", "stiffness=-40.0"), "VFY106", "kp"
    ),
    "custom bias turned": Fault(
        "custom", replaced("encoder_bias=0.02", "encoder_bias=-0.02"), "VFY106", "encoder_bias"
    ),
    "mjlab pose turned": Fault(
        "mjlab", replaced('".*_knee": -0.8', '".*_knee": 0.8'), "VFY106", "default_position"
    ),
    "deploy pose turned": Fault(
        "deploy", replaced("[0.1, -0.8, -0.1", "[0.1, 0.8, -0.1"), "VFY106", "default_position"
    ),
    # --- armature
    "mujoco another armature": Fault(
        "mujoco", replaced('armature="0.0081"', 'armature="0.02"', 0), "VFY107", "armature"
    ),
    "isaaclab armature 0": Fault(
        "isaaclab", replaced("armature=0.0081", "armature=0.0"), "VFY107", "armature"
    ),
    # --- delays: 10 ms are 2 steps of 5 ms
    "mujoco delay off by one": Fault(
        "mujoco", replaced('delay="0.01" nsample="2"', 'delay="0.005" nsample="1"', 0), "VFY108", "delay_low"
    ),
    "isaaclab delay off by one": Fault(
        "isaaclab", replaced("max_delay=3", "max_delay=4"), "VFY108", "delay_high"
    ),
    # 10 ms in steps of 2 ms
    "mjlab delay in steps of the model": Fault(
        "mjlab",
        both(
            replaced("delay_min_lag=2", "delay_min_lag=5"),
            replaced("delay_max_lag=2", "delay_max_lag=5"),
        ),
        "VFY108",
        "delay_high",
    ),
    "custom delay lost": Fault(
        "custom",
        both(replaced("min_delay=2", "min_delay=0"), replaced("max_delay=2", "max_delay=0")),
        "VFY108",
        "delay_low",
    ),
    "deploy delay in ms": Fault(
        "deploy", replaced("low: [0.01, 0.005,", "low: [10, 5,"), "VFY108", "delay_low"
    ),
    # --- joints
    "mujoco left and right swapped": Fault(
        "mujoco", swapped('joint="left_knee"', 'joint="right_knee"'), "VFY109", "kp"
    ),
    "mujoco actuator left out": Fault(
        "mujoco", matched(r'<velocity name="lift"[^>]*/>', ""), "VFY109", "joint"
    ),
    "mujoco order of the actuators": Fault(
        "mujoco",
        matched(r"(<dcmotor name=\"right_hip\"[^>]*/>)(.*?)(<velocity [^>]*/>)", r"\3\2\1"),
        "VFY109",
        "order",
    ),
    "isaaclab joint left out of a mapping": Fault(
        "isaaclab", matched(r' *"right_knee": 61.0,\n', ""), "VFY109", "kp"
    ),
    "isaaclab left and right swapped": Fault(
        "isaaclab", swapped('"left_knee"', '"right_knee"'), "VFY109", "kp"
    ),
    "isaaclab joint left out of its group": Fault(
        "isaaclab",
        replaced('joint_names_expr=[".*_hip"]', 'joint_names_expr=["left_hip"]'),
        "VFY109",
        "joint",
    ),
    "mjlab joint left out": Fault(
        "mjlab",
        replaced('target_names_expr=(".*_hip",)', 'target_names_expr=("left_hip",)'),
        "VFY109",
        "joint",
    ),
    "mjlab poses swapped": Fault(
        "mjlab",
        both(
            replaced('"left_hip": 0.1', '"left_hip": -0.1'), replaced('"right_hip": -0.1', '"right_hip": 0.1')
        ),
        "VFY109",
        "default_position",
    ),
    "deploy order swapped": Fault(
        "deploy",
        replaced(
            "robot: [left_hip, left_knee, right_hip, right_knee",
            "robot: [left_hip, left_knee, right_knee, right_hip",
        ),
        "VFY109",
        "order.robot",
    ),
    "deploy map swapped": Fault(
        "deploy",
        matched(r"robot_to_isaac: \[(\d), (\d)", r"robot_to_isaac: [\2, \1"),
        "VFY109",
        "index.robot_to_isaac",
    ),
    "deploy list in another order": Fault(
        "deploy", replaced("kp: [40.0, 60.0, 40.0, 61.0,", "kp: [40.0, 61.0, 40.0, 60.0,"), "VFY109", "kp"
    ),
    # --- anything else
    "mujoco another step": Fault(
        "mujoco", replaced('timestep="0.005"', 'timestep="0.002"'), "VFY110", "physics_dt"
    ),
    "mujoco clamp of the command lost": Fault(
        "mujoco", replaced('ctrllimited="true"', 'ctrllimited="false"', 0), "VFY110", "command_low"
    ),
    "isaaclab kp and kd swapped": Fault(
        "isaaclab",
        both(replaced("stiffness=40.0", "stiffness=1.5"), replaced("damping=1.5,", "damping=40.0,")),
        "VFY110",
        "kp",
    ),
    "isaaclab another class": Fault(
        "isaaclab", replaced('"hips": DCMotorCfg(', '"hips": IdealPDActuatorCfg('), "VFY110", "class"
    ),
    "custom another cutoff": Fault(
        "custom", replaced("filter_cutoff=20.0", "filter_cutoff=25.0"), "VFY110", "filter_cutoff"
    ),
    "mjlab another scale": Fault(
        "mjlab", replaced('".*_hip": 0.3,', '".*_hip": 0.25,'), "VFY110", "action_scale"
    ),
    "deploy another scale": Fault(
        "deploy", replaced("action_scale: [0.3,", "action_scale: [0.25,"), "VFY110", "action_scale"
    ),
    "json another range": Fault(
        "randomization", replaced('"high": 1.2', '"high": 12'), "VFY110", "randomize.kp", ".json"
    ),
    "json viscous in kd": Fault(
        "randomization", replaced('"kd": {"value": 1.5,', '"kd": {"value": 1.55,'), "VFY101", "kd", ".json"
    ),
    "json kd as viscous friction": Fault(
        "randomization",
        replaced('"friction.viscous": {"value": 0.05,', '"friction.viscous": {"value": 1.5,'),
        "VFY101",
        "friction.viscous",
        ".json",
    ),
    # 0.3 N*m of 22.5 N*m
    "json friction without unit": Fault(
        "randomization",
        replaced('"friction.coulomb": {"value": 0.3,', '"friction.coulomb": {"value": 0.013333333,'),
        "VFY102",
        "friction.coulomb",
        ".json",
    ),
    "json another unit": Fault(
        "randomization",
        replaced('"unit": "N*m*s/rad"', '"unit": "N*m*s/deg"'),
        "VFY110",
        "randomize",
        ".json",
    ),
    "deploy nominal delay": Fault(
        "deploy", replaced("nominal: [0.01, 0.01,", "nominal: [0.01, 0.015,"), "VFY108", "delay_nominal"
    ),
    "isaaclab events, another range": Fault(
        "randomization",
        replaced("(0.8, 1.2)", "(0.8, 2.2)"),
        "VFY110",
        "randomize (rich_isaaclab_events.py)",
        "isaaclab_events.py",
    ),
    "mjlab events, another range": Fault(
        "randomization",
        replaced("(0.9, 1.1)", "(0.9, 11.0)"),
        "VFY110",
        "randomize (rich_mjlab_events.py)",
        "mjlab_events.py",
    ),
    # --- no file at all
    "mujoco refused": Fault("mujoco", replaced("<dcmotor ", "<dcmotr ", 0), "VFY111", "file"),
    "isaaclab no Python": Fault(
        "isaaclab", replaced("RICH_ACTUATORS = {", "RICH_ACTUATORS = {{"), "VFY111", "file"
    ),
    "deploy no YAML": Fault("deploy", replaced("kp: [", "kp: [["), "VFY111", "file"),
}

URDF_FAULTS: dict[str, Fault] = {
    "kd as damping": Fault("urdf", replaced('damping="0.05"', 'damping="1.5"', 0), "VFY101", "joint_damping"),
    "friction without unit": Fault(
        "urdf", replaced('friction="0.3"', 'friction="0.013333333"', 0), "VFY102", "frictionloss"
    ),
    "friction and damping swapped": Fault(
        "urdf",
        both(
            replaced('damping="0.05"', 'damping="0.3"', 0), replaced('friction="0.3"', 'friction="0.05"', 0)
        ),
        "VFY102",
        "frictionloss",
    ),
    "effort at the motor": Fault(
        "urdf", replaced('effort="22.5"', 'effort="2.5"', 0), "VFY103", "effort_limit"
    ),
    "effort 0": Fault("urdf", replaced('effort="22.5"', 'effort="0"', 0), "VFY104", "effort_limit"),
    "speed in rpm": Fault(
        "urdf", replaced('velocity="25"', 'velocity="238.732415"', 0), "VFY105", "velocity_limit"
    ),
    "speed in degrees": Fault(
        "urdf", replaced('velocity="25"', 'velocity="1432.39449"', 0), "VFY105", "velocity_limit"
    ),
}


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """The rich spec, compiled."""
    return build(tmp_path_factory.mktemp("rich"))


@pytest.fixture(scope="module")
def leg(tmp_path_factory: pytest.TempPathFactory) -> Built:
    """A URDF's spec, compiled."""
    return build(tmp_path_factory.mktemp("leg"), URDF_SPEC, URDF, "leg.urdf")


def found(built: Built, fault: Fault) -> set[tuple[str, str]]:
    """Codes and quantities of what is said after the mistake."""
    agreement = built.verified(fault.target, fault.edit, file=fault.file)
    return {(row.code or "", row.quantity) for row in agreement.faults}


@pytest.mark.slow
@pytest.mark.parametrize("name", FAULTS)
def test_fault_is_found(name: str, built: Built) -> None:
    """The mistake is found in the file, by its own code."""
    fault = FAULTS[name]
    assert (fault.code, fault.quantity) in found(built, fault)


@pytest.mark.parametrize("name", URDF_FAULTS)
def test_fault_in_a_urdf_is_found(name: str, leg: Built) -> None:
    """Likewise in a URDF."""
    fault = URDF_FAULTS[name]
    assert (fault.code, fault.quantity) in found(leg, fault)


@pytest.mark.parametrize("name", ["mujoco", *ISAAC, "il45", "mjlab", "deploy", "randomization"])
def test_what_is_compiled_agrees(name: str, built: Built) -> None:
    """Without a mistake nothing is said."""
    agreement = built.verified(name)
    assert agreement.rows
    assert [row.message for row in agreement.faults] == []


def test_compiled_urdf_agrees(leg: Built) -> None:
    """Likewise in a URDF."""
    assert leg.verified("urdf").faults == ()


def test_kinds_and_targets() -> None:
    """Every code but that of the torque is seeded, over every kind of target that is read back."""
    faults = [*FAULTS.values(), *URDF_FAULTS.values()]
    assert {fault.code for fault in faults} == {f"VFY{number}" for number in range(101, 112)}
    assert {fault.target for fault in faults} >= {
        "mujoco",
        "isaaclab",
        "mjlab",
        "deploy",
        "urdf",
        "randomization",
    }


def test_place_and_words(built: Built, tmp_path: Path) -> None:
    """A row says where the figure stands, what it is, what it should be and why it is wrong."""
    fault = FAULTS["mujoco armature times n"]
    (row,) = built.verified("mujoco", fault.edit).faults
    assert (row.group, row.joint, row.joints) == ("hips", "left_hip", 2)
    assert row.expected == 0.0081 and row.got == pytest.approx(0.0009)
    assert row.place is not None
    line = Path(row.place.path).read_text("utf-8").splitlines()[row.place.line - 1]
    assert 'name="left_hip"' in line and 'armature="0.0009"' in line
    assert row.message == (
        "the armature is 0.0009 kg*m^2, and should be 0.0081 kg*m^2: "
        "the gear of 9 is taken to the first power, and it goes with its square"
    )
