# Written by actspec 0.1.0 for Isaac Lab 2.3 on Isaac Sim 5.1 (PhysX). Do not edit: change the spec and compile again.
# spec sha256 087defe91d196249ca6abb0a277cc6e932c93dcf2fcb2567a23f24528eae95db
# variant mode_5
# model g1.xml
# physics_dt 0.005 s
#
# Sources:
#   mjlab_g1: mjlab 1.6.0, Unitree G1 constants, https://github.com/mujocolab/mjlab,
#     mjlab/asset_zoo/robots/unitree_g1/g1_constants.py

"""Configuration for the actuators of UNITREE_G1_CFG, for Isaac Lab 2.3.

Example:

    from unitree_g1_cfg import UNITREE_G1_ACTUATORS

    UNITREE_G1_CFG = ArticulationCfg(
        spawn=sim_utils.UsdFileCfg(usd_path="..."),
        init_state=ArticulationCfg.InitialStateCfg(joint_pos={...}),
        soft_joint_pos_limit_factor=0.9,
        actuators=UNITREE_G1_ACTUATORS,
    )

Made for ``SimulationCfg(dt=0.005)`` and ``decimation=4``.
"""

from isaaclab.actuators import IdealPDActuatorCfg

##
# Configuration - Actuators.
##

# Nobody states friction, viscous friction: the USD's own.
UNITREE_G1_ACTUATORS = {
    "hip_pitch_yaw": IdealPDActuatorCfg(
        joint_names_expr=[".*_hip_pitch_joint", ".*_hip_yaw_joint", "waist_yaw_joint"],
        effort_limit=88.0,  # N*m; derived, mjlab_g1; peak_torque of the motor
        velocity_limit_sim=32.0,  # rad/s; authored, mjlab_g1
        stiffness=40.1792386367,  # N*m/rad; derived; 0.0101775 kg*m^2 (reflected inertia) x (2 pi 10 Hz)^2
        damping=2.55788977548,  # N*m*s/rad; derived
        armature=0.0101775200413,  # kg*m^2; derived, mjlab_g1
    ),
    "hip_roll_knee": IdealPDActuatorCfg(
        joint_names_expr=[".*_hip_roll_joint", ".*_knee_joint"],
        effort_limit=139.0,  # N*m; derived, mjlab_g1; peak_torque of the motor
        velocity_limit_sim=20.0,  # rad/s; authored, mjlab_g1
        stiffness=99.0984277823,  # N*m/rad; derived; 0.0251019 kg*m^2 (reflected inertia) x (2 pi 10 Hz)^2
        damping=6.30880185368,  # N*m*s/rad; derived
        armature=0.025101925,  # kg*m^2; derived, mjlab_g1
    ),
    "ankles": IdealPDActuatorCfg(
        joint_names_expr=[".*_ankle_pitch_joint", ".*_ankle_roll_joint"],
        effort_limit=50.0,  # N*m; derived, mjlab_g1
        velocity_limit_sim=37.0,  # rad/s; authored, mjlab_g1
        stiffness=28.5012461974,  # N*m/rad; derived; 0.00721945 kg*m^2 (reflected inertia) x (2 pi 10 Hz)^2
        damping=1.81444568664,  # N*m*s/rad; derived
        armature=0.00721945,  # kg*m^2; derived, mjlab_g1
    ),
    "waist": IdealPDActuatorCfg(
        joint_names_expr=["waist_roll_joint", "waist_pitch_joint"],
        effort_limit=50.0,  # N*m; derived, mjlab_g1; (25 N*m (n5020) + 25 N*m (n5020)) x 1, linkage waist (mjlab_g1)
        velocity_limit_sim=37.0,  # rad/s; authored, mjlab_g1
        stiffness=28.5012461974,  # N*m/rad; derived; 0.00721945 kg*m^2 (reflected inertia) x (2 pi 10 Hz)^2
        damping=1.81444568664,  # N*m*s/rad; derived
        armature=0.00721945,  # kg*m^2; derived, mjlab_g1
    ),
    "arms": IdealPDActuatorCfg(
        joint_names_expr=[
            ".*_shoulder_pitch_joint",
            ".*_shoulder_roll_joint",
            ".*_shoulder_yaw_joint",
            ".*_elbow_joint",
            ".*_wrist_roll_joint",
        ],
        effort_limit=25.0,  # N*m; derived, mjlab_g1; peak_torque of the motor
        velocity_limit_sim=37.0,  # rad/s; authored, mjlab_g1
        stiffness=14.2506230987,  # N*m/rad; derived; 0.00360972 kg*m^2 (reflected inertia) x (2 pi 10 Hz)^2
        damping=0.907222843319,  # N*m*s/rad; derived
        armature=0.003609725,  # kg*m^2; derived, mjlab_g1
    ),
    "wrists": IdealPDActuatorCfg(
        joint_names_expr=[".*_wrist_pitch_joint", ".*_wrist_yaw_joint"],
        effort_limit=5.0,  # N*m; derived, mjlab_g1; peak_torque of the motor
        velocity_limit_sim=22.0,  # rad/s; authored, mjlab_g1
        stiffness=16.7783274819,  # N*m/rad; derived; 0.00425 kg*m^2 (reflected inertia) x (2 pi 10 Hz)^2
        damping=1.06814150222,  # N*m*s/rad; derived
        armature=0.00425,  # kg*m^2; derived, mjlab_g1
    ),
}
"""Configuration of the actuators of UNITREE_G1_CFG, by group of joints."""
