# Written by actspec 0.1.0 for Isaac Lab 2.3 on Isaac Sim 5.1 (PhysX). Do not edit: change the spec and compile again.
# spec sha256 85e4dcc8f4898d74fc42c597ead9931c86610afc6af6b9942264b6191f094e0f
# model h1.xml
# physics_dt 0.005 s
#
# Sources:
#   rl_gym_h1: unitree_rl_gym, H1RoughCfg and its base class, https://github.com/unitreerobotics/unitree_rl_gym,
#     legged_gym/envs/h1/h1_config.py, legged_gym/envs/base/legged_robot_config.py, commit
#     276801e46c5d433564f24658bac64f254b7d2d4b
#   rl_gym_robot: unitree_rl_gym, deployment on the H1, https://github.com/unitreerobotics/unitree_rl_gym,
#     deploy/deploy_real/configs/h1.yaml, commit 276801e46c5d433564f24658bac64f254b7d2d4b
#   rl_lab_h1: unitree_rl_lab, UNITREE_H1_CFG, as a public copy has it, https://github.com/openreachtech/unitree_rl_lab,
#     source/unitree_rl_lab/unitree_rl_lab/assets/robots/unitree.py, commit 08332d5df4573e5233480e762ecc74c989eb3c9f
#   h1_urdf: Unitree's URDF of the H1 (unitree_ros, BSD-3-Clause), https://github.com/unitreerobotics/unitree_ros,
#     robots/h1_description/urdf/h1.urdf, commit d6f13aad60320ce1d60a07b82a76b5a553f2a0a9
#   rl_lab_motors: unitree_rl_lab, actuator constants, as a public copy has them,
#     https://github.com/openreachtech/unitree_rl_lab,
#     source/unitree_rl_lab/unitree_rl_lab/assets/robots/unitree_actuators.py, commit
#     5bba858614789916fc77fae58daf69db04758850

"""Configuration for the actuators of UNITREE_H1_CFG, for Isaac Lab 2.3.

Example:

    from unitree_h1_cfg import UNITREE_H1_ACTUATORS

    UNITREE_H1_CFG = ArticulationCfg(
        spawn=sim_utils.UsdFileCfg(usd_path="..."),
        init_state=ArticulationCfg.InitialStateCfg(joint_pos={...}),
        soft_joint_pos_limit_factor=0.9,
        actuators=UNITREE_H1_ACTUATORS,
    )

Made for ``SimulationCfg(dt=0.005)`` and ``decimation=4``.
"""

from isaaclab.actuators import IdealPDActuatorCfg

##
# Configuration - Actuators.
##

# Nobody states friction, viscous friction: the USD's own.
UNITREE_H1_ACTUATORS = {
    "hips": IdealPDActuatorCfg(
        joint_names_expr=[".*_hip_yaw_joint", ".*_hip_roll_joint", ".*_hip_pitch_joint"],
        effort_limit=200.0,  # N*m; authored, h1_urdf
        velocity_limit_sim=23.0,  # rad/s; authored, h1_urdf
        stiffness=150.0,  # N*m/rad; authored, rl_gym_robot
        damping=2.0,  # N*m*s/rad; authored, rl_gym_robot
        armature=0.063259741,  # kg*m^2; derived, rl_lab_motors; reflected inertia of the motor
    ),
    "knees": IdealPDActuatorCfg(
        joint_names_expr=[".*_knee_joint"],
        effort_limit=300.0,  # N*m; authored, h1_urdf
        velocity_limit_sim=14.0,  # rad/s; authored, h1_urdf
        stiffness=200.0,  # N*m/rad; authored, rl_gym_robot
        damping=4.0,  # N*m*s/rad; authored, rl_gym_robot
        armature=0.160478022,  # kg*m^2; derived, rl_lab_motors; reflected inertia of the motor
    ),
    "ankles": IdealPDActuatorCfg(
        joint_names_expr=[".*_ankle_joint"],
        effort_limit=40.0,  # N*m; authored, h1_urdf
        velocity_limit_sim=9.0,  # rad/s; authored, h1_urdf
        stiffness=40.0,  # N*m/rad; authored, rl_gym_robot
        damping=2.0,  # N*m*s/rad; authored, rl_gym_robot
        armature=0.0493827150617,  # kg*m^2; derived, rl_lab_h1; 0.01 kg*m^2 x 4.93827 (reduction^2)
    ),
    "torso": IdealPDActuatorCfg(
        joint_names_expr=["torso_joint"],
        effort_limit=200.0,  # N*m; authored, h1_urdf
        velocity_limit_sim=23.0,  # rad/s; authored, h1_urdf
        stiffness=300.0,  # N*m/rad; authored, rl_gym_robot
        damping=3.0,  # N*m*s/rad; authored, rl_gym_robot
        armature=0.063259741,  # kg*m^2; derived, rl_lab_motors; reflected inertia of the motor
    ),
    "shoulders": IdealPDActuatorCfg(
        joint_names_expr=[".*_shoulder_pitch_joint", ".*_shoulder_roll_joint"],
        effort_limit=40.0,  # N*m; authored, h1_urdf
        velocity_limit_sim=9.0,  # rad/s; authored, h1_urdf
        stiffness=100.0,  # N*m/rad; authored, rl_gym_robot
        damping=2.0,  # N*m*s/rad; authored, rl_gym_robot
        armature=0.0493827150617,  # kg*m^2; derived, rl_lab_h1; 0.01 kg*m^2 x 4.93827 (reduction^2)
    ),
    "arms": IdealPDActuatorCfg(
        joint_names_expr=[".*_shoulder_yaw_joint", ".*_elbow_joint"],
        effort_limit=18.0,  # N*m; authored, h1_urdf
        velocity_limit_sim=20.0,  # rad/s; authored, h1_urdf
        stiffness=50.0,  # N*m/rad; authored, rl_gym_robot
        damping=2.0,  # N*m*s/rad; authored, rl_gym_robot
        armature=0.01,  # kg*m^2; derived, rl_lab_h1; reflected inertia of the motor
    ),
}
"""Configuration of the actuators of UNITREE_H1_CFG, by group of joints."""
