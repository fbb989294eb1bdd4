# Written by actspec 0.1.0 for mjlab 1.6. Do not edit: change the spec and compile
#   again.
# spec sha256 85e4dcc8f4898d74fc42c597ead9931c86610afc6af6b9942264b6191f094e0f

from mjlab.envs.mdp import dr
from mjlab.managers.event_manager import EventTermCfg
from mjlab.managers.scene_entity_config import SceneEntityCfg

UNITREE_H1_EVENTS: dict[str, EventTermCfg] = {
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
}
