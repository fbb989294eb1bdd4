# Written by actspec 0.1.0 for Isaac Lab 2.3 on Isaac Sim 5.1 (PhysX). Do not edit: change the spec and compile again.
# spec sha256 6a61770f58f65ce3198ba58ebeab41c2aea58298034041700d464cdd9d7a7ee7
# model go1.xml
# physics_dt 0.005 s
#
# Sources:
#   go1_urdf: Unitree's URDF of the Go1 (unitree_ros, BSD-3-Clause), https://github.com/unitreerobotics/unitree_ros,
#     robots/go1_description/urdf/go1.urdf, commit d6f13aad60320ce1d60a07b82a76b5a553f2a0a9
#   mjlab_go1: mjlab 1.6.0, Unitree Go1 constants, https://github.com/mujocolab/mjlab,
#     mjlab/asset_zoo/robots/unitree_go1/go1_constants.py

"""Configuration for the actuators of UNITREE_GO1_CFG, for Isaac Lab 2.3.

Example:

    from unitree_go1_cfg import UNITREE_GO1_ACTUATORS

    UNITREE_GO1_CFG = ArticulationCfg(
        spawn=sim_utils.UsdFileCfg(usd_path="..."),
        init_state=ArticulationCfg.InitialStateCfg(joint_pos={...}),
        soft_joint_pos_limit_factor=0.9,
        actuators=UNITREE_GO1_ACTUATORS,
    )

Made for ``SimulationCfg(dt=0.005)`` and ``decimation=4``.
"""

from isaaclab.actuators import IdealPDActuatorCfg

##
# Configuration - Actuators.
##

# Nobody states friction, viscous friction: the USD's own.
UNITREE_GO1_ACTUATORS = {
    "hip_thigh": IdealPDActuatorCfg(
        joint_names_expr=[".*_hip_joint", ".*_thigh_joint"],
        effort_limit=23.7,  # N*m; derived, go1_urdf; peak_torque of the motor
        velocity_limit_sim=30.1,  # rad/s; authored, go1_urdf
        stiffness=15.8952426541,  # N*m/rad; derived; 0.00402631 kg*m^2 (reflected inertia) x (2 pi 10 Hz)^2
        damping=1.01192257602,  # N*m*s/rad; derived
        armature=0.004026312,  # kg*m^2; derived, go1_urdf; 0.000111842 kg*m^2 x 36 (gear_ratio^2)
    ),
    "knee": IdealPDActuatorCfg(
        joint_names_expr=[".*_calf_joint"],
        effort_limit=35.55,  # N*m; derived, go1_urdf; 23.7 N*m x 1.5 (reduction)
        velocity_limit_sim=20.06,  # rad/s; authored, go1_urdf
        stiffness=35.7642959718,  # N*m/rad; derived; 0.0090592 kg*m^2 (reflected inertia) x (2 pi 10 Hz)^2
        damping=2.27682579605,  # N*m*s/rad; derived
        armature=0.009059202,  # kg*m^2; derived, go1_urdf; 0.000111842 kg*m^2 x 36 (gear_ratio^2) x 2.25 (reduction^2)
    ),
}
"""Configuration of the actuators of UNITREE_GO1_CFG, by group of joints."""
