# Written by actspec 0.1.0 for mjlab 1.6. Do not edit: change the spec and compile
#   again.
# spec sha256 f15b40fabbb70811892572ac64bc7bae9593951b87cc57d1966644d022b81467
#
# What it cannot do:
# - strength: scale 0.9 to 1.1 -> each joint on its own (the stack draws no number for a
#   whole robot; each joint's range is kept)
# - strength: scale 0.9 to 1.1 -> a factor each on kp, kd and the limit, which is not
#   raised above the nominal, at most 20.335 N*m (dr.pd_gains and dr.effort_limits draw
#   apart; MuJoCo cuts an explicit actuator at the nominal, and the torque-speed line
#   has no event)

from mjlab.envs.mdp import dr
from mjlab.managers.event_manager import EventTermCfg
from mjlab.managers.scene_entity_config import SceneEntityCfg

UNITREE_A1_STIFF_EVENTS: dict[str, EventTermCfg] = {
  "legs_gains": EventTermCfg(
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
  "legs_effort_limits": EventTermCfg(
    func=dr.effort_limits,
    mode="reset",
    params={
      "asset_cfg": SceneEntityCfg("robot"),
      "effort_limit_range": (0.9, 1.1),
      "distribution": "uniform",
      "operation": "scale",
    },
  ),
  "legs_encoder_bias": EventTermCfg(
    func=dr.encoder_bias,
    mode="reset",
    params={
      "asset_cfg": SceneEntityCfg("robot", joint_names=(".*",)),
      "bias_range": (-0.02, 0.02),
    },
  ),
}
