# Written by actspec 0.1.0 for Isaac Lab 2.3 on Isaac Sim 5.1. Do not edit: change the spec and compile again.
# spec sha256 f15b40fabbb70811892572ac64bc7bae9593951b87cc57d1966644d022b81467
#
# What it cannot do:
# - strength: scale 0.9 to 1.1 -> each joint on its own (the stack draws no number for a whole robot; each joint's range
#   is kept)
# - encoder_bias: add -0.02 rad to 0.02 rad -> none: stays 0 rad, at most 2 N*m (Isaac Lab has no term for encoder
#   biases)
# - strength: scale 0.9 to 1.1 -> a factor each on kp and kd, none on the limit, at most 20.335 N*m
#   (randomize_actuator_gains draws kp and kd apart, and Isaac Lab has no term for effort limits)

import isaaclab.envs.mdp as mdp
from isaaclab.managers import EventTermCfg as EventTerm
from isaaclab.managers import SceneEntityCfg
from isaaclab.utils import configclass


@configclass
class EventCfg:
    """Domain randomization of the actuators."""

    legs_gains = EventTerm(
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
