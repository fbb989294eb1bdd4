# Written by actspec 0.1.0 for Isaac Lab 2.3 on Isaac Sim 5.1. Do not edit: change the spec and compile again.
# spec sha256 087defe91d196249ca6abb0a277cc6e932c93dcf2fcb2567a23f24528eae95db
# variant mode_5
#
# What it cannot do:
# - encoder_bias: add -0.015 rad to 0.015 rad -> none: stays 0 rad, at most 0.602689 N*m (Isaac Lab has no term for
#   encoder biases): left_hip_pitch_joint, left_hip_yaw_joint, right_hip_pitch_joint, right_hip_yaw_joint,
#   waist_yaw_joint
# - encoder_bias: add -0.015 rad to 0.015 rad -> none: stays 0 rad, at most 1.48648 N*m (Isaac Lab has no term for
#   encoder biases): left_hip_roll_joint, left_knee_joint, right_hip_roll_joint, right_knee_joint
# - encoder_bias: add -0.015 rad to 0.015 rad -> none: stays 0 rad, at most 0.427519 N*m (Isaac Lab has no term for
#   encoder biases): left_ankle_pitch_joint, left_ankle_roll_joint, right_ankle_pitch_joint, right_ankle_roll_joint,
#   waist_roll_joint, waist_pitch_joint
# - encoder_bias: add -0.015 rad to 0.015 rad -> none: stays 0 rad, at most 0.213759 N*m (Isaac Lab has no term for
#   encoder biases): left_shoulder_pitch_joint, left_shoulder_roll_joint, left_shoulder_yaw_joint, left_elbow_joint,
#   left_wrist_roll_joint, right_shoulder_pitch_joint, right_shoulder_roll_joint, right_shoulder_yaw_joint,
#   right_elbow_joint, right_wrist_roll_joint
# - encoder_bias: add -0.015 rad to 0.015 rad -> none: stays 0 rad, at most 0.251675 N*m (Isaac Lab has no term for
#   encoder biases): left_wrist_pitch_joint, left_wrist_yaw_joint, right_wrist_pitch_joint, right_wrist_yaw_joint

import isaaclab.envs.mdp as mdp
from isaaclab.managers import EventTermCfg as EventTerm
from isaaclab.managers import SceneEntityCfg
from isaaclab.utils import configclass


@configclass
class EventCfg:
    """Domain randomization of the actuators."""

    gains = EventTerm(
        func=mdp.randomize_actuator_gains,
        mode="reset",
        params={
            "asset_cfg": SceneEntityCfg("robot", joint_names=[".*"]),
            "stiffness_distribution_params": (0.75, 1.25),
            "damping_distribution_params": (0.75, 1.25),
            "operation": "scale",
            "distribution": "uniform",
        },
    )
