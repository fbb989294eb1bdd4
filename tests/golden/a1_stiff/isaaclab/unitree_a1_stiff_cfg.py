# Written by actspec 0.1.0 for Isaac Lab 2.3 on Isaac Sim 5.1 (PhysX). Do not edit: change the spec and compile again.
# spec sha256 f15b40fabbb70811892572ac64bc7bae9593951b87cc57d1966644d022b81467
# model a1.xml
# physics_dt 0.002 s
#
# Sources:
#   a1_urdf: Unitree's URDF of the A1 (unitree_ros, BSD-3-Clause), https://github.com/unitreerobotics/unitree_ros,
#     robots/a1_description/urdf/a1.urdf, commit d6f13aad60320ce1d60a07b82a76b5a553f2a0a9
#   isaaclab_a1: Isaac Lab 2.3.2, UNITREE_A1_CFG, https://github.com/isaac-sim/IsaacLab,
#     source/isaaclab_assets/isaaclab_assets/robots/unitree.py
#   legged_gym: legged_gym, A1RoughCfg and its base class, https://github.com/leggedrobotics/legged_gym,
#     legged_gym/envs/a1/a1_config.py, legged_gym/envs/base/legged_robot_config.py, commit
#     054812147280e14bf0b99aac610e104472f45060
#   menagerie_a1: MuJoCo Menagerie, unitree_a1, https://github.com/google-deepmind/mujoco_menagerie, unitree_a1/a1.xml,
#     commit 1b428b08bb26ca6024e7b21e8ff21a59f847eb87
#   actspec_choice: Chosen for this file; no publication, SOURCES.md, "The stiffer gains"

"""Configuration for the actuators of UNITREE_A1_STIFF_CFG, for Isaac Lab 2.3.

Example:

    from unitree_a1_stiff_cfg import UNITREE_A1_STIFF_ACTUATORS

    UNITREE_A1_STIFF_CFG = ArticulationCfg(
        spawn=sim_utils.UsdFileCfg(usd_path="..."),
        init_state=ArticulationCfg.InitialStateCfg(joint_pos={...}),
        soft_joint_pos_limit_factor=0.9,
        actuators=UNITREE_A1_STIFF_ACTUATORS,
    )

Made for ``SimulationCfg(dt=0.002)`` and ``decimation=10``.
"""

from isaaclab.actuators import DCMotorCfg

##
# Configuration - Actuators.
##

UNITREE_A1_STIFF_ACTUATORS = {
    "legs": DCMotorCfg(
        joint_names_expr=[".*_hip_joint", ".*_thigh_joint", ".*_calf_joint"],
        effort_limit=33.5,  # N*m; authored, isaaclab_a1
        saturation_effort=33.5,  # N*m at standstill; authored, isaaclab_a1
        velocity_limit=21.0,  # rad/s at no torque; authored, isaaclab_a1
        stiffness=100.0,  # N*m/rad; authored, menagerie_a1
        damping=4.0,  # N*m*s/rad; authored, actspec_choice
        armature=0.01,  # kg*m^2; authored, menagerie_a1
        friction=0.2,  # static, N*m; authored, a1_urdf
        dynamic_friction=0.2,  # sliding, N*m; authored, a1_urdf
        viscous_friction=0.01,  # N*m*s/rad; authored, a1_urdf
    ),
}
"""Configuration of the actuators of UNITREE_A1_STIFF_CFG, by group of joints."""
