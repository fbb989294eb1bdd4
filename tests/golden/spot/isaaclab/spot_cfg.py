# Written by actspec 0.1.0 for Isaac Lab 2.3 on Isaac Sim 5.1 (PhysX). Do not edit: change the spec and compile again.
# spec sha256 9137f37f1dff7dd89693092fbc3188b90d2af1f76e9dd8a2f303f49d7a1b56f0
# model spot.xml
# physics_dt 0.002 s
#
# Approximations (what these classes cannot hold):
#   armature: unknown -> the USD's own (Isaac Lab has to take a number): fl_hx, fl_hy, fl_kn, fr_hx, fr_hy, fr_kn,
#     hl_hx, hl_hy, hl_kn, hr_hx, hr_hy, hr_kn
#
# Sources:
#   bd_data: Boston Dynamics, joint control, supplemental data,
#     https://dev.bostondynamics.com/docs/concepts/joint_control/supplemental_data.html, Joint Transmission Details
#   spot_urdf: RAI Institute, spot_description, https://github.com/bdaiinstitute/spot_description,
#     spot_description/urdf/spot_macro.xacro, commit 079c78d857d878539ce485d8912aa338f63cbed2
#   isaaclab_spot: Isaac Lab, SPOT_CFG, https://github.com/isaac-sim/IsaacLab,
#     source/isaaclab_assets/isaaclab_assets/robots/spot.py, commit 931679641ee84e1b4175c15b48f9286d44ba9b04
#   isaaclab_task: Isaac Lab, velocity task of Spot, https://github.com/isaac-sim/IsaacLab,
#     source/isaaclab_tasks/isaaclab_tasks/manager_based/locomotion/velocity/config/spot/flat_env_cfg.py, commit
#     887342aec819df225a5660c0e2bd268d2c1a7d70

"""Configuration for the actuators of SPOT_CFG, for Isaac Lab 2.3.

Example:

    from spot_cfg import SPOT_ACTUATORS

    SPOT_CFG = ArticulationCfg(
        spawn=sim_utils.UsdFileCfg(usd_path="..."),
        init_state=ArticulationCfg.InitialStateCfg(joint_pos={...}),
        soft_joint_pos_limit_factor=0.9,
        actuators=SPOT_ACTUATORS,
    )

Made for ``SimulationCfg(dt=0.002)`` and ``decimation=10``: delays, filters and networks count physics steps.
"""

from isaaclab.actuators import DelayedPDActuatorCfg

##
# Configuration - Actuators.
##

# Nobody states armature, friction, viscous friction: the USD's own.
SPOT_ACTUATORS = {
    "hips": DelayedPDActuatorCfg(
        joint_names_expr=[".*_h[xy]"],
        effort_limit=45.0,  # N*m; authored, spot_urdf
        velocity_limit_sim=17.647,  # rad/s; authored, spot_urdf
        stiffness=60.0,  # N*m/rad; authored, isaaclab_spot
        damping=1.5,  # N*m*s/rad; authored, isaaclab_spot
        min_delay=0,  # physics steps of 2 ms; authored, isaaclab_spot
        max_delay=4,  # 8 ms
    ),
    "knees": DelayedPDActuatorCfg(
        joint_names_expr=[".*_kn"],
        effort_limit=112.812984,  # N*m; derived, bd_data
        velocity_limit_sim=12.0,  # rad/s; authored, spot_urdf
        stiffness=60.0,  # N*m/rad; authored, isaaclab_spot
        damping=1.5,  # N*m*s/rad; authored, isaaclab_spot
        min_delay=0,  # physics steps of 2 ms; authored, isaaclab_spot
        max_delay=4,  # 8 ms
    ),
}
"""Configuration of the actuators of SPOT_CFG, by group of joints."""
