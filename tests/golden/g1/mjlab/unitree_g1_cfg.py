"""Actuators of unitree_g1 for mjlab 1.6."""

# Written by actspec 0.1.0. Do not edit: change the spec and compile again.
# spec sha256 087defe91d196249ca6abb0a277cc6e932c93dcf2fcb2567a23f24528eae95db
# variant mode_5
# model g1.xml
#
# Use:
#   EntityCfg(
#     spec_fn=lambda: prepare_spec(mujoco.MjSpec.from_file(...)),
#     articulation=UNITREE_G1_ARTICULATION,
#   )
# with SimulationCfg(mujoco=MujocoCfg(timestep=0.005)), decimation=4.
# soft_joint_pos_limit_factor is left to the task.
#
# Approximations (what mjlab cannot hold):
# - velocity_limit: 32 rad/s -> none (mjlab has no speed limit of a joint; its
#   velocity_limit is the no-load speed): left_hip_pitch_joint, left_hip_yaw_joint,
#   right_hip_pitch_joint, right_hip_yaw_joint, waist_yaw_joint
# - velocity_limit: 20 rad/s -> none (mjlab has no speed limit of a joint; its
#   velocity_limit is the no-load speed): left_hip_roll_joint, left_knee_joint,
#   right_hip_roll_joint, right_knee_joint
# - velocity_limit: 37 rad/s -> none (mjlab has no speed limit of a joint; its
#   velocity_limit is the no-load speed): left_ankle_pitch_joint, left_ankle_roll_joint,
#   right_ankle_pitch_joint, right_ankle_roll_joint, waist_roll_joint,
#   waist_pitch_joint, left_shoulder_pitch_joint, left_shoulder_roll_joint,
#   left_shoulder_yaw_joint, left_elbow_joint, left_wrist_roll_joint,
#   right_shoulder_pitch_joint, right_shoulder_roll_joint, right_shoulder_yaw_joint,
#   right_elbow_joint, right_wrist_roll_joint
# - velocity_limit: 22 rad/s -> none (mjlab has no speed limit of a joint; its
#   velocity_limit is the no-load speed): left_wrist_pitch_joint, left_wrist_yaw_joint,
#   right_wrist_pitch_joint, right_wrist_yaw_joint
#
# Sources:
# - mjlab_g1: mjlab 1.6.0, Unitree G1 constants, https://github.com/mujocolab/mjlab,
#   mjlab/asset_zoo/robots/unitree_g1/g1_constants.py

import mujoco

from mjlab.actuator import BuiltinPositionActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg

##
# Actuator config.
##

# hip_pitch_yaw: ideal_pd, position command.
UNITREE_G1_HIP_PITCH_YAW_ACTUATOR = BuiltinPositionActuatorCfg(
  target_names_expr=(".*_hip_pitch_joint", ".*_hip_yaw_joint", "waist_yaw_joint"),
  stiffness=40.1792386367,  # N*m/rad, derived
  damping=2.55788977548,  # N*m*s/rad, derived
  effort_limit=88.0,  # N*m, derived, mjlab_g1
  armature=0.0101775200413,  # kg*m^2, derived, mjlab_g1
)
# hip_roll_knee: ideal_pd, position command.
UNITREE_G1_HIP_ROLL_KNEE_ACTUATOR = BuiltinPositionActuatorCfg(
  target_names_expr=(".*_hip_roll_joint", ".*_knee_joint"),
  stiffness=99.0984277823,  # N*m/rad, derived
  damping=6.30880185368,  # N*m*s/rad, derived
  effort_limit=139.0,  # N*m, derived, mjlab_g1
  armature=0.025101925,  # kg*m^2, derived, mjlab_g1
)
# ankles: ideal_pd, position command.
UNITREE_G1_ANKLES_ACTUATOR = BuiltinPositionActuatorCfg(
  target_names_expr=(".*_ankle_pitch_joint", ".*_ankle_roll_joint"),
  stiffness=28.5012461974,  # N*m/rad, derived
  damping=1.81444568664,  # N*m*s/rad, derived
  effort_limit=50.0,  # N*m, derived, mjlab_g1
  armature=0.00721945,  # kg*m^2, derived, mjlab_g1
)
# waist: ideal_pd, position command.
UNITREE_G1_WAIST_ACTUATOR = BuiltinPositionActuatorCfg(
  target_names_expr=("waist_roll_joint", "waist_pitch_joint"),
  stiffness=28.5012461974,  # N*m/rad, derived
  damping=1.81444568664,  # N*m*s/rad, derived
  effort_limit=50.0,  # N*m, derived, mjlab_g1
  armature=0.00721945,  # kg*m^2, derived, mjlab_g1
)
# arms: ideal_pd, position command.
UNITREE_G1_ARMS_ACTUATOR = BuiltinPositionActuatorCfg(
  target_names_expr=(
    ".*_shoulder_pitch_joint",
    ".*_shoulder_roll_joint",
    ".*_shoulder_yaw_joint",
    ".*_elbow_joint",
    ".*_wrist_roll_joint",
  ),
  stiffness=14.2506230987,  # N*m/rad, derived
  damping=0.907222843319,  # N*m*s/rad, derived
  effort_limit=25.0,  # N*m, derived, mjlab_g1
  armature=0.003609725,  # kg*m^2, derived, mjlab_g1
)
# wrists: ideal_pd, position command.
UNITREE_G1_WRISTS_ACTUATOR = BuiltinPositionActuatorCfg(
  target_names_expr=(".*_wrist_pitch_joint", ".*_wrist_yaw_joint"),
  stiffness=16.7783274819,  # N*m/rad, derived
  damping=1.06814150222,  # N*m*s/rad, derived
  effort_limit=5.0,  # N*m, derived, mjlab_g1
  armature=0.00425,  # kg*m^2, derived, mjlab_g1
)

##
# Model.
##

DRIVEN_JOINTS = (
  "left_hip_pitch_joint",
  "left_hip_roll_joint",
  "left_hip_yaw_joint",
  "left_knee_joint",
  "left_ankle_pitch_joint",
  "left_ankle_roll_joint",
  "right_hip_pitch_joint",
  "right_hip_roll_joint",
  "right_hip_yaw_joint",
  "right_knee_joint",
  "right_ankle_pitch_joint",
  "right_ankle_roll_joint",
  "waist_yaw_joint",
  "waist_roll_joint",
  "waist_pitch_joint",
  "left_shoulder_pitch_joint",
  "left_shoulder_roll_joint",
  "left_shoulder_yaw_joint",
  "left_elbow_joint",
  "left_wrist_roll_joint",
  "left_wrist_pitch_joint",
  "left_wrist_yaw_joint",
  "right_shoulder_pitch_joint",
  "right_shoulder_roll_joint",
  "right_shoulder_yaw_joint",
  "right_elbow_joint",
  "right_wrist_roll_joint",
  "right_wrist_pitch_joint",
  "right_wrist_yaw_joint",
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

UNITREE_G1_ARTICULATION = EntityArticulationInfoCfg(
  actuators=(
    UNITREE_G1_HIP_PITCH_YAW_ACTUATOR,
    UNITREE_G1_HIP_ROLL_KNEE_ACTUATOR,
    UNITREE_G1_ANKLES_ACTUATOR,
    UNITREE_G1_WAIST_ACTUATOR,
    UNITREE_G1_ARMS_ACTUATOR,
    UNITREE_G1_WRISTS_ACTUATOR,
  ),
)

# Command per unit of action.
UNITREE_G1_ACTION_SCALE: dict[str, float] = {
  ".*_hip_pitch_joint": 0.54754646296,
  ".*_hip_yaw_joint": 0.54754646296,
  "waist_yaw_joint": 0.54754646296,
  ".*_hip_roll_joint": 0.35066146636,
  ".*_knee_joint": 0.35066146636,
  ".*_ankle_pitch_joint": 0.4385773139,
  ".*_ankle_roll_joint": 0.4385773139,
  "waist_roll_joint": 0.4385773139,
  "waist_pitch_joint": 0.4385773139,
  ".*_shoulder_pitch_joint": 0.4385773139,
  ".*_shoulder_roll_joint": 0.4385773139,
  ".*_shoulder_yaw_joint": 0.4385773139,
  ".*_elbow_joint": 0.4385773139,
  ".*_wrist_roll_joint": 0.4385773139,
  ".*_wrist_pitch_joint": 0.074500870325,
  ".*_wrist_yaw_joint": 0.074500870325,
}

# Pose at zero action; joints that are not named are at 0.
UNITREE_G1_JOINT_POS: dict[str, float] = {
  ".*_hip_pitch_joint": -0.312,
  ".*_knee_joint": 0.669,
  ".*_ankle_pitch_joint": -0.363,
  ".*_shoulder_pitch_joint": 0.2,
  "left_shoulder_roll_joint": 0.2,
  ".*_elbow_joint": 0.6,
  "right_shoulder_roll_joint": -0.2,
}
