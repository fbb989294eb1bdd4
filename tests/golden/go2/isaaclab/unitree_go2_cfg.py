# Written by actspec 0.1.0 for Isaac Lab 2.3 on Isaac Sim 5.1 (PhysX). Do not edit: change the spec and compile again.
# spec sha256 05baffab0465755e22c7e54b03acff005c0554e11a70f463eda822e06295dbfb
# model go2.xml
# physics_dt 0.005 s
#
# Sources:
#   go2_urdf: Unitree's URDF of the Go2 (unitree_ros, BSD-3-Clause), https://github.com/unitreerobotics/unitree_ros,
#     robots/go2_description/urdf/go2_description.urdf, commit d6f13aad60320ce1d60a07b82a76b5a553f2a0a9
#   rl_lab_go2: unitree_rl_lab, UNITREE_GO2_CFG, https://github.com/unitreerobotics/unitree_rl_lab,
#     source/unitree_rl_lab/unitree_rl_lab/assets/robots/unitree.py, commit e72a072c4db68b79a816b3b89bf3b6a0525d113e
#   rl_lab_task: unitree_rl_lab, velocity task of the Go2, https://github.com/unitreerobotics/unitree_rl_lab,
#     source/unitree_rl_lab/unitree_rl_lab/tasks/locomotion/robots/go2/velocity_env_cfg.py, commit
#     e72a072c4db68b79a816b3b89bf3b6a0525d113e
#   unitree_mujoco_go2: unitree_mujoco, Go2 model, https://github.com/unitreerobotics/unitree_mujoco,
#     unitree_robots/go2/go2.xml, commit c598f10
#   go1_urdf: Unitree's URDF of the Go1 (unitree_ros, BSD-3-Clause), https://github.com/unitreerobotics/unitree_ros,
#     robots/go1_description/urdf/go1.urdf, commit d6f13aad60320ce1d60a07b82a76b5a553f2a0a9
#   isaaclab_go: Isaac Lab, limits of the DC motor of Go1 and Go2, as corrected, https://github.com/isaac-sim/IsaacLab,
#     pull request 7564, merged in September 2026

"""Configuration for the actuators of UNITREE_GO2_CFG, for Isaac Lab 2.3.

Example:

    from unitree_go2_cfg import UNITREE_GO2_ACTUATORS

    UNITREE_GO2_CFG = ArticulationCfg(
        spawn=sim_utils.UsdFileCfg(usd_path="..."),
        init_state=ArticulationCfg.InitialStateCfg(joint_pos={...}),
        soft_joint_pos_limit_factor=0.9,
        actuators=UNITREE_GO2_ACTUATORS,
    )

Made for ``SimulationCfg(dt=0.005)`` and ``decimation=4``.
"""

from isaaclab.actuators import DCMotorCfg

##
# Configuration - Actuators.
##

UNITREE_GO2_ACTUATORS = {
    "hip_thigh": DCMotorCfg(
        joint_names_expr=[".*_hip_joint", ".*_thigh_joint"],
        effort_limit=23.7,  # N*m; authored, go2_urdf
        saturation_effort=23.7,  # N*m at standstill; authored, isaaclab_go
        velocity_limit=30.1,  # rad/s at no torque; authored, isaaclab_go
        stiffness=25.0,  # N*m/rad; authored, rl_lab_go2
        damping=0.5,  # N*m*s/rad; authored, rl_lab_go2
        armature=0.004026312,  # kg*m^2; derived, go1_urdf; 0.000111842 kg*m^2 x 36 (gear_ratio^2)
        friction=0.2,  # static, N*m; authored, unitree_mujoco_go2
        dynamic_friction=0.2,  # sliding, N*m; authored, unitree_mujoco_go2
        viscous_friction=0.1,  # N*m*s/rad; authored, unitree_mujoco_go2
    ),
    "knee": DCMotorCfg(
        joint_names_expr=[".*_calf_joint"],
        effort_limit=45.43,  # N*m; authored, go2_urdf
        saturation_effort=45.43053,  # N*m at standstill; derived, isaaclab_go
        velocity_limit=15.7024362252,  # rad/s at no torque; derived, isaaclab_go
        stiffness=25.0,  # N*m/rad; authored, rl_lab_go2
        damping=0.5,  # N*m*s/rad; authored, rl_lab_go2
        armature=0.0147947060316,  # kg*m^2; derived, go1_urdf
        friction=0.2,  # static, N*m; authored, unitree_mujoco_go2
        dynamic_friction=0.2,  # sliding, N*m; authored, unitree_mujoco_go2
        viscous_friction=0.1,  # N*m*s/rad; authored, unitree_mujoco_go2
    ),
}
"""Configuration of the actuators of UNITREE_GO2_CFG, by group of joints."""
