# Written by actspec 0.1.0 for Isaac Lab 2.3 on Isaac Sim 5.1 (PhysX). Do not edit: change the spec and compile again.
# spec sha256 9e96b3a697b94b3483b0c7f027e3b8818a91b5c2be51a41736dd74f84d0ddfa5
# model anymal_d.xml
# physics_dt 0.0025 s
#
# Approximations (what these classes cannot hold):
#   delay: 12.5 ms -> none; at most 44.5 N*m (DCMotor has no delay; the torque-speed line is kept instead): LF_HAA,
#     LF_HFE, LF_KFE, RF_HAA, RF_HFE, RF_KFE, LH_HAA, LH_HFE, LH_KFE, RH_HAA, RH_HFE, RH_KFE
#
# Sources:
#   pace_data: PACE, data_collection.py, parameters close to those of the real ANYmal D,
#     https://github.com/leggedrobotics/pace-sim2real, scripts/pace/data_collection.py, docs/examples/anymal.md, commit
#     f8ec8b85015140633870463dd27d498ac9f96b53
#   isaaclab_velocity: Isaac Lab, velocity task, which the ANYmal's inherits, https://github.com/isaac-sim/IsaacLab,
#     source/isaaclab_tasks/isaaclab_tasks/manager_based/locomotion/velocity/velocity_env_cfg.py, commit
#     d02d3b8a59400d2a7ea2d7ce717128c673d293d3
#   isaaclab_anymal: Isaac Lab, ANYDRIVE_3_SIMPLE_ACTUATOR_CFG, https://github.com/isaac-sim/IsaacLab,
#     source/isaaclab_assets/isaaclab_assets/robots/anymal.py, commit 931679641ee84e1b4175c15b48f9286d44ba9b04
#   pace_anymal: PACE, ANYDRIVE_PACE_ACTUATOR_CFG, for the ANYmal D, https://github.com/leggedrobotics/pace-sim2real,
#     source/pace_sim2real/pace_sim2real/tasks/manager_based/pace/anymal_pace_env_cfg.py, commit
#     f8ec8b85015140633870463dd27d498ac9f96b53

"""Configuration for the actuators of ANYMAL_D_CFG, for Isaac Lab 2.3.

Example:

    from anymal_d_cfg import ANYMAL_D_ACTUATORS

    ANYMAL_D_CFG = ArticulationCfg(
        spawn=sim_utils.UsdFileCfg(usd_path="..."),
        init_state=ArticulationCfg.InitialStateCfg(joint_pos={...}),
        soft_joint_pos_limit_factor=0.9,
        actuators=ANYMAL_D_ACTUATORS,
    )

Made for ``SimulationCfg(dt=0.0025)`` and ``decimation=8``.
"""

from isaaclab.actuators import DCMotorCfg

##
# Configuration - Actuators.
##

ANYMAL_D_ACTUATORS = {
    "legs": DCMotorCfg(
        joint_names_expr=[".*_HAA", ".*_HFE", ".*_KFE"],
        effort_limit=89.0,  # N*m; authored, pace_anymal
        saturation_effort=140.0,  # N*m at standstill; authored, pace_anymal
        velocity_limit=8.5,  # rad/s at no torque; authored, pace_anymal
        stiffness=85.0,  # N*m/rad; authored, pace_anymal
        damping=0.6,  # N*m*s/rad; authored, pace_anymal
        armature=0.1,  # kg*m^2; authored, pace_data
        friction=0.05,  # static, N*m; authored, pace_data
        dynamic_friction=0.05,  # sliding, N*m; authored, pace_data
        viscous_friction=4.5,  # N*m*s/rad; authored, pace_data
    ),
}
"""Configuration of the actuators of ANYMAL_D_CFG, by group of joints."""
