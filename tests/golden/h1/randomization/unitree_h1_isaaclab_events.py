# Written by actspec 0.1.0 for Isaac Lab 2.3 on Isaac Sim 5.1. Do not edit: change the spec and compile again.
# spec sha256 85e4dcc8f4898d74fc42c597ead9931c86610afc6af6b9942264b6191f094e0f

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
