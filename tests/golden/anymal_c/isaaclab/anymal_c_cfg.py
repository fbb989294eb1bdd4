# Written by actspec 0.1.0 for Isaac Lab 2.3 on Isaac Sim 5.1 (PhysX). Do not edit: change the spec and compile again.
# spec sha256 f6b1aa5d5034b01acf60931884faea14a07b416bca910fee08fd25753286bd38
# model anymal_c.xml
# physics_dt 0.005 s
#
# Sources:
#   isaaclab_velocity: Isaac Lab, velocity task, which the ANYmal's inherits, https://github.com/isaac-sim/IsaacLab,
#     source/isaaclab_tasks/isaaclab_tasks/manager_based/locomotion/velocity/velocity_env_cfg.py, commit
#     d02d3b8a59400d2a7ea2d7ce717128c673d293d3
#   pace_data: PACE, data_collection.py, parameters close to those of the real ANYmal D,
#     https://github.com/leggedrobotics/pace-sim2real, scripts/pace/data_collection.py, docs/examples/anymal.md, commit
#     f8ec8b85015140633870463dd27d498ac9f96b53
#   isaaclab_anymal: Isaac Lab, ANYDRIVE_3_SIMPLE_ACTUATOR_CFG, https://github.com/isaac-sim/IsaacLab,
#     source/isaaclab_assets/isaaclab_assets/robots/anymal.py, commit 931679641ee84e1b4175c15b48f9286d44ba9b04

"""Configuration for the actuators of ANYMAL_C_CFG, for Isaac Lab 2.3.

Example:

    from anymal_c_cfg import ANYMAL_C_ACTUATORS

    ANYMAL_C_CFG = ArticulationCfg(
        spawn=sim_utils.UsdFileCfg(usd_path="..."),
        init_state=ArticulationCfg.InitialStateCfg(joint_pos={...}),
        soft_joint_pos_limit_factor=0.9,
        actuators=ANYMAL_C_ACTUATORS,
    )

Made for ``SimulationCfg(dt=0.005)`` and ``decimation=4``.
"""

from isaaclab.actuators import DCMotorCfg

##
# Configuration - Actuators.
##

ANYMAL_C_ACTUATORS = {
    "legs": DCMotorCfg(
        # Nobody states friction, viscous friction: the USD's own.
        joint_names_expr=[".*_HAA", ".*_HFE", ".*_KFE"],
        effort_limit=80.0,  # N*m; authored, isaaclab_anymal
        saturation_effort=120.0,  # N*m at standstill; authored, isaaclab_anymal
        velocity_limit=7.5,  # rad/s at no torque; authored, isaaclab_anymal
        stiffness=40.0,  # N*m/rad; authored, isaaclab_anymal
        damping=5.0,  # N*m*s/rad; authored, isaaclab_anymal
        armature=0.1,  # kg*m^2; authored, pace_data
    ),
}
"""Configuration of the actuators of ANYMAL_C_CFG, by group of joints."""
