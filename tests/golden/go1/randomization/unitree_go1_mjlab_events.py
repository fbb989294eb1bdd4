# Written by actspec 0.1.0 for mjlab 1.6. Do not edit: change the spec and compile
#   again.
# spec sha256 6a61770f58f65ce3198ba58ebeab41c2aea58298034041700d464cdd9d7a7ee7
#
# What it cannot do:
# - strength: scale 0.9 to 1.1 -> each joint on its own (the stack draws no number for a
#   whole robot; each joint's range is kept)
# - strength: scale 0.9 to 1.1 -> a factor each on kp, kd and the limit, at most 11.5867
#   N*m (dr.pd_gains and dr.effort_limits draw apart): FR_hip_joint, FR_thigh_joint,
#   FL_hip_joint, FL_thigh_joint, RR_hip_joint, RR_thigh_joint, RL_hip_joint,
#   RL_thigh_joint
# - strength: scale 0.9 to 1.1 -> a factor each on kp, kd and the limit, at most 17.38
#   N*m (dr.pd_gains and dr.effort_limits draw apart): FR_calf_joint, FL_calf_joint,
#   RR_calf_joint, RL_calf_joint

from mjlab.envs.mdp import dr
from mjlab.managers.event_manager import EventTermCfg
from mjlab.managers.scene_entity_config import SceneEntityCfg

UNITREE_GO1_EVENTS: dict[str, EventTermCfg] = {
  "gains": EventTermCfg(
    func=dr.pd_gains,
    mode="reset",
    params={
      "asset_cfg": SceneEntityCfg("robot"),
      "kp_range": (0.9, 1.1),
      "kd_range": (0.9, 1.1),
      "distribution": "uniform",
      "operation": "scale",
    },
  ),
  "effort_limits": EventTermCfg(
    func=dr.effort_limits,
    mode="reset",
    params={
      "asset_cfg": SceneEntityCfg("robot"),
      "effort_limit_range": (0.9, 1.1),
      "distribution": "uniform",
      "operation": "scale",
    },
  ),
  "encoder_bias": EventTermCfg(
    func=dr.encoder_bias,
    mode="startup",
    params={
      "asset_cfg": SceneEntityCfg("robot", joint_names=(".*",)),
      "bias_range": (-0.015, 0.015),
    },
  ),
}
