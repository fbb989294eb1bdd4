# Written by actspec 0.1.0 for Isaac Lab 2.3 on Isaac Sim 5.1. Do not edit: change the spec and compile again.
# spec sha256 6a61770f58f65ce3198ba58ebeab41c2aea58298034041700d464cdd9d7a7ee7
#
# What it cannot do:
# - strength: scale 0.9 to 1.1 -> each joint on its own (the stack draws no number for a whole robot; each joint's range
#   is kept)
# - encoder_bias: add -0.015 rad to 0.015 rad -> none: stays 0 rad, at most 0.238429 N*m (Isaac Lab has no term for
#   encoder biases): FR_hip_joint, FR_thigh_joint, FL_hip_joint, FL_thigh_joint, RR_hip_joint, RR_thigh_joint,
#   RL_hip_joint, RL_thigh_joint
# - encoder_bias: add -0.015 rad to 0.015 rad -> none: stays 0 rad, at most 0.536464 N*m (Isaac Lab has no term for
#   encoder biases): FR_calf_joint, FL_calf_joint, RR_calf_joint, RL_calf_joint
# - strength: scale 0.9 to 1.1 -> a factor each on kp and kd, none on the limit, at most 10.5333 N*m
#   (randomize_actuator_gains draws kp and kd apart, and Isaac Lab has no term for effort limits): FR_hip_joint,
#   FR_thigh_joint, FL_hip_joint, FL_thigh_joint, RR_hip_joint, RR_thigh_joint, RL_hip_joint, RL_thigh_joint
# - strength: scale 0.9 to 1.1 -> a factor each on kp and kd, none on the limit, at most 15.8 N*m
#   (randomize_actuator_gains draws kp and kd apart, and Isaac Lab has no term for effort limits): FR_calf_joint,
#   FL_calf_joint, RR_calf_joint, RL_calf_joint

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
            "stiffness_distribution_params": (0.9, 1.1),
            "damping_distribution_params": (0.9, 1.1),
            "operation": "scale",
            "distribution": "uniform",
        },
    )
