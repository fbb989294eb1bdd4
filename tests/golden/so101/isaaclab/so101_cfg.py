# Written by actspec 0.1.0 for Isaac Lab 2.3 on Isaac Sim 5.1 (PhysX). Do not edit: change the spec and compile again.
# spec sha256 8dd0463e5b925b2eb911a65ff1a2a231c074e7b801fcfa1de0e6f45eaca15874
# model so101.xml
# physics_dt 0.005 s
#
# Sources:
#   lerobot_so101: LeRobot, SO101Follower, https://github.com/huggingface/lerobot,
#     src/lerobot/robots/so101_follower/so101_follower.py, commit 0c83b9ab164c30775dd34032c0a12253f56f5d6b
#   bam_sts3215: BAM (Better Actuator Models), STS3215 at 7.4 V, model m1, https://github.com/Rhoban/bam,
#     bam/params/feetech_sts3215_7_4V/m1.json, bam/feetech/actuator.py, commit 1b5a1cee2e6dcd2ab8c12b013f1e05482b16cb96
#   dfrobot_st3215: DFRobot SER0069 (ST3215), data of a reseller,
#     https://littlebirdelectronics.com.au/products/st3215-serial-bus-servo-19-5kg-7-4v-360-magnetic-encoder

"""Configuration for the actuators of SO101_CFG, for Isaac Lab 2.3.

Example:

    from so101_cfg import SO101_ACTUATORS

    SO101_CFG = ArticulationCfg(
        spawn=sim_utils.UsdFileCfg(usd_path="..."),
        init_state=ArticulationCfg.InitialStateCfg(joint_pos={...}),
        soft_joint_pos_limit_factor=0.9,
        actuators=SO101_ACTUATORS,
    )

Made for ``SimulationCfg(dt=0.005)`` and ``decimation=4``.
"""

from isaaclab.actuators import DCMotorCfg

##
# Configuration - Actuators.
##

SO101_ACTUATORS = {
    "arm": DCMotorCfg(
        joint_names_expr=["shoulder_.*", "elbow_flex", "wrist_.*", "gripper"],
        effort_limit=1.9123,  # N*m; derived, dfrobot_st3215; peak_torque of the motor
        saturation_effort=3.24986,  # N*m at standstill; authored, bam_sts3215
        velocity_limit=5.9242,  # rad/s at no torque; authored, bam_sts3215
        stiffness=8.89858,  # N*m/rad; authored, lerobot_so101
        damping=0.548574,  # N*m*s/rad; authored, bam_sts3215
        armature=0.0284034,  # kg*m^2; derived, bam_sts3215; reflected inertia of the motor
        friction=0.052393,  # static, N*m; authored, bam_sts3215
        dynamic_friction=0.052393,  # sliding, N*m; authored, bam_sts3215
        viscous_friction=0.0590852,  # N*m*s/rad; authored, bam_sts3215
    ),
}
"""Configuration of the actuators of SO101_CFG, by group of joints."""
