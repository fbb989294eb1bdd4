"""Actuators of unitree_go1 for mjlab 1.6."""

# Written by actspec 0.1.0. Do not edit: change the spec and compile again.
# spec sha256 6a61770f58f65ce3198ba58ebeab41c2aea58298034041700d464cdd9d7a7ee7
# model go1.xml
#
# Use:
#   EntityCfg(
#     spec_fn=lambda: prepare_spec(mujoco.MjSpec.from_file(...)),
#     articulation=UNITREE_GO1_ARTICULATION,
#   )
# with SimulationCfg(mujoco=MujocoCfg(timestep=0.005)), decimation=4.
# soft_joint_pos_limit_factor is left to the task.
#
# Approximations (what mjlab cannot hold):
# - velocity_limit: 30.1 rad/s -> none (mjlab has no speed limit of a joint; its
#   velocity_limit is the no-load speed): FR_hip_joint, FR_thigh_joint, FL_hip_joint,
#   FL_thigh_joint, RR_hip_joint, RR_thigh_joint, RL_hip_joint, RL_thigh_joint
# - velocity_limit: 20.06 rad/s -> none (mjlab has no speed limit of a joint; its
#   velocity_limit is the no-load speed): FR_calf_joint, FL_calf_joint, RR_calf_joint,
#   RL_calf_joint
#
# Sources:
# - go1_urdf: Unitree's URDF of the Go1 (unitree_ros, BSD-3-Clause),
#   https://github.com/unitreerobotics/unitree_ros,
#   robots/go1_description/urdf/go1.urdf, commit
#   d6f13aad60320ce1d60a07b82a76b5a553f2a0a9
# - mjlab_go1: mjlab 1.6.0, Unitree Go1 constants, https://github.com/mujocolab/mjlab,
#   mjlab/asset_zoo/robots/unitree_go1/go1_constants.py

import mujoco

from mjlab.actuator import BuiltinPositionActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg

##
# Actuator config.
##

# hip_thigh: ideal_pd, position command.
UNITREE_GO1_HIP_THIGH_ACTUATOR = BuiltinPositionActuatorCfg(
  target_names_expr=(".*_hip_joint", ".*_thigh_joint"),
  stiffness=15.8952426541,  # N*m/rad, derived
  damping=1.01192257602,  # N*m*s/rad, derived
  effort_limit=23.7,  # N*m, derived, go1_urdf
  armature=0.004026312,  # kg*m^2, derived, go1_urdf
)
# knee: ideal_pd, position command.
UNITREE_GO1_KNEE_ACTUATOR = BuiltinPositionActuatorCfg(
  target_names_expr=(".*_calf_joint",),
  stiffness=35.7642959718,  # N*m/rad, derived
  damping=2.27682579605,  # N*m*s/rad, derived
  effort_limit=35.55,  # N*m, derived, go1_urdf
  armature=0.009059202,  # kg*m^2, derived, go1_urdf
)

##
# Model.
##

DRIVEN_JOINTS = (
  "FR_hip_joint",
  "FR_thigh_joint",
  "FR_calf_joint",
  "FL_hip_joint",
  "FL_thigh_joint",
  "FL_calf_joint",
  "RR_hip_joint",
  "RR_thigh_joint",
  "RR_calf_joint",
  "RL_hip_joint",
  "RL_thigh_joint",
  "RL_calf_joint",
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

UNITREE_GO1_ARTICULATION = EntityArticulationInfoCfg(
  actuators=(
    UNITREE_GO1_HIP_THIGH_ACTUATOR,
    UNITREE_GO1_KNEE_ACTUATOR,
  ),
)

# Command per unit of action.
UNITREE_GO1_ACTION_SCALE: dict[str, float] = {
  ".*_hip_joint": 0.37275303869,
  ".*_thigh_joint": 0.37275303869,
  ".*_calf_joint": 0.24850202579,
}

# Pose at zero action; joints that are not named are at 0.
UNITREE_GO1_JOINT_POS: dict[str, float] = {
  ".*R_hip_joint": 0.1,
  ".*_thigh_joint": 0.9,
  ".*_calf_joint": -1.8,
  ".*L_hip_joint": -0.1,
}
