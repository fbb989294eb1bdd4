# Written by actspec 0.1.0 for mjlab 1.6. Do not edit: change the spec and compile
#   again.
# spec sha256 087defe91d196249ca6abb0a277cc6e932c93dcf2fcb2567a23f24528eae95db
# variant mode_5

from mjlab.envs.mdp import dr
from mjlab.managers.event_manager import EventTermCfg
from mjlab.managers.scene_entity_config import SceneEntityCfg

UNITREE_G1_EVENTS: dict[str, EventTermCfg] = {
  "gains": EventTermCfg(
    func=dr.pd_gains,
    mode="reset",
    params={
      "asset_cfg": SceneEntityCfg("robot"),
      "kp_range": (0.75, 1.25),
      "kd_range": (0.75, 1.25),
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
