"""Actuators of spot for mjlab 1.6."""

# Written by actspec 0.1.0. Do not edit: change the spec and compile again.
# spec sha256 9137f37f1dff7dd89693092fbc3188b90d2af1f76e9dd8a2f303f49d7a1b56f0
# model spot.xml
#
# Use:
#   EntityCfg(
#     spec_fn=lambda: prepare_spec(mujoco.MjSpec.from_file(...)),
#     articulation=SPOT_ARTICULATION,
#   )
# with SimulationCfg(mujoco=MujocoCfg(timestep=0.002)), decimation=10: lags are steps of
# 2 ms.
# soft_joint_pos_limit_factor is left to the task.
#
# Approximations (what mjlab cannot hold):
# - velocity_limit: 17.647 rad/s -> none (mjlab has no speed limit of a joint; its
#   velocity_limit is the no-load speed): fl_hx, fl_hy, fr_hx, fr_hy, hl_hx, hl_hy,
#   hr_hx, hr_hy
# - velocity_limit: 12 rad/s -> none (mjlab has no speed limit of a joint; its
#   velocity_limit is the no-load speed): fl_kn, fr_kn, hl_kn, hr_kn
# - armature: unknown -> 0 kg*m^2, MuJoCo's default (mjlab has to take a number): fl_hx,
#   fl_hy, fl_kn, fr_hx, fr_hy, fr_kn, hl_hx, hl_hy, hl_kn, hr_hx, hr_hy, hr_kn
#
# Sources:
# - bd_data: Boston Dynamics, joint control, supplemental data,
#   https://dev.bostondynamics.com/docs/concepts/joint_control/supplemental_data.html,
#   Joint Transmission Details
# - spot_urdf: RAI Institute, spot_description,
#   https://github.com/bdaiinstitute/spot_description,
#   spot_description/urdf/spot_macro.xacro, commit
#   079c78d857d878539ce485d8912aa338f63cbed2
# - isaaclab_spot: Isaac Lab, SPOT_CFG, https://github.com/isaac-sim/IsaacLab,
#   source/isaaclab_assets/isaaclab_assets/robots/spot.py, commit
#   931679641ee84e1b4175c15b48f9286d44ba9b04
# - isaaclab_task: Isaac Lab, velocity task of Spot,
#   https://github.com/isaac-sim/IsaacLab,
#   source/isaaclab_tasks/isaaclab_tasks/manager_based/locomotion/velocity/config/spot/flat_env_cfg.py,
#   commit 887342aec819df225a5660c0e2bd268d2c1a7d70

import mujoco

from mjlab.actuator import BuiltinPositionActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg

##
# Actuator config.
##

# hips: ideal_pd, position command.
SPOT_HIPS_ACTUATOR = BuiltinPositionActuatorCfg(
  target_names_expr=(".*_h[xy]",),
  stiffness=60.0,  # N*m/rad, authored, isaaclab_spot
  damping=1.5,  # N*m*s/rad, authored, isaaclab_spot
  effort_limit=45.0,  # N*m, authored, spot_urdf
  # steps of 2 ms: 0 to 8 ms, drawn each episode, authored, isaaclab_spot
  delay_min_lag=0,
  delay_max_lag=4,
  delay_update_period=10**9,  # drawn at a reset, then held
  delay_per_env_phase=False,
)
# knees: ideal_pd, position command.
SPOT_KNEES_ACTUATOR = BuiltinPositionActuatorCfg(
  target_names_expr=(".*_kn",),
  stiffness=60.0,  # N*m/rad, authored, isaaclab_spot
  damping=1.5,  # N*m*s/rad, authored, isaaclab_spot
  effort_limit=112.812984,  # N*m, derived, bd_data
  # steps of 2 ms: 0 to 8 ms, drawn each episode, authored, isaaclab_spot
  delay_min_lag=0,
  delay_max_lag=4,
  delay_update_period=10**9,  # drawn at a reset, then held
  delay_per_env_phase=False,
)

##
# Model.
##

DRIVEN_JOINTS = (
  "fl_hx",
  "fl_hy",
  "fl_kn",
  "fr_hx",
  "fr_hy",
  "fr_kn",
  "hl_hx",
  "hl_hy",
  "hl_kn",
  "hr_hx",
  "hr_hy",
  "hr_kn",
)


def prepare_spec(spec: mujoco.MjSpec) -> mujoco.MjSpec:
  """Make room for the actuators above, in `spec_fn`.

  The model's own actuators on these joints go, with their sensors: they would act
  beside those above. Its keyframes lose their controls, whose number changes.
  """
  joint = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
  own = [a for a in spec.actuators if a.trntype in joint and a.target in DRIVEN_JOINTS]
  names = {a.name for a in own}
  for sensor in list(spec.sensors):
    if sensor.objtype == mujoco.mjtObj.mjOBJ_ACTUATOR and sensor.objname in names:
      spec.delete(sensor)
  for actuator in own:
    spec.delete(actuator)
  for key in spec.keys:
    key.ctrl = []
    key.act = []
  return spec


##
# Final config.
##

SPOT_ARTICULATION = EntityArticulationInfoCfg(
  actuators=(
    SPOT_HIPS_ACTUATOR,
    SPOT_KNEES_ACTUATOR,
  ),
)

# Command per unit of action.
SPOT_ACTION_SCALE: dict[str, float] = {
  ".*_h[xy]": 0.2,
  ".*_kn": 0.2,
}

# Pose at zero action; joints that are not named are at 0.
SPOT_JOINT_POS: dict[str, float] = {
  ".l_hx": 0.1,
  "f._hy": 0.9,
  ".*_kn": -1.5,
  ".r_hx": -0.1,
  "h._hy": 1.1,
}
