"""Actuators of unitree_h1 for mjlab 1.6."""

# Written by actspec 0.1.0. Do not edit: change the spec and compile again.
# spec sha256 85e4dcc8f4898d74fc42c597ead9931c86610afc6af6b9942264b6191f094e0f
# model h1.xml
#
# Use:
#   EntityCfg(
#     spec_fn=lambda: prepare_spec(mujoco.MjSpec.from_file(...)),
#     articulation=UNITREE_H1_ARTICULATION,
#   )
# with SimulationCfg(mujoco=MujocoCfg(timestep=0.005)), decimation=4.
# soft_joint_pos_limit_factor is left to the task.
#
# Approximations (what mjlab cannot hold):
# - velocity_limit: 23 rad/s -> none (mjlab has no speed limit of a joint; its
#   velocity_limit is the no-load speed): left_hip_yaw_joint, left_hip_roll_joint,
#   left_hip_pitch_joint, right_hip_yaw_joint, right_hip_roll_joint,
#   right_hip_pitch_joint, torso_joint
# - velocity_limit: 14 rad/s -> none (mjlab has no speed limit of a joint; its
#   velocity_limit is the no-load speed): left_knee_joint, right_knee_joint
# - velocity_limit: 9 rad/s -> none (mjlab has no speed limit of a joint; its
#   velocity_limit is the no-load speed): left_ankle_joint, right_ankle_joint,
#   left_shoulder_pitch_joint, left_shoulder_roll_joint, right_shoulder_pitch_joint,
#   right_shoulder_roll_joint
# - velocity_limit: 20 rad/s -> none (mjlab has no speed limit of a joint; its
#   velocity_limit is the no-load speed): left_shoulder_yaw_joint, left_elbow_joint,
#   right_shoulder_yaw_joint, right_elbow_joint
#
# Sources:
# - rl_gym_h1: unitree_rl_gym, H1RoughCfg and its base class,
#   https://github.com/unitreerobotics/unitree_rl_gym, legged_gym/envs/h1/h1_config.py,
#   legged_gym/envs/base/legged_robot_config.py, commit
#   276801e46c5d433564f24658bac64f254b7d2d4b
# - rl_gym_robot: unitree_rl_gym, deployment on the H1,
#   https://github.com/unitreerobotics/unitree_rl_gym,
#   deploy/deploy_real/configs/h1.yaml, commit 276801e46c5d433564f24658bac64f254b7d2d4b
# - rl_lab_h1: unitree_rl_lab, UNITREE_H1_CFG, as a public copy has it,
#   https://github.com/openreachtech/unitree_rl_lab,
#   source/unitree_rl_lab/unitree_rl_lab/assets/robots/unitree.py, commit
#   08332d5df4573e5233480e762ecc74c989eb3c9f
# - h1_urdf: Unitree's URDF of the H1 (unitree_ros, BSD-3-Clause),
#   https://github.com/unitreerobotics/unitree_ros, robots/h1_description/urdf/h1.urdf,
#   commit d6f13aad60320ce1d60a07b82a76b5a553f2a0a9
# - rl_lab_motors: unitree_rl_lab, actuator constants, as a public copy has them,
#   https://github.com/openreachtech/unitree_rl_lab,
#   source/unitree_rl_lab/unitree_rl_lab/assets/robots/unitree_actuators.py, commit
#   5bba858614789916fc77fae58daf69db04758850

import mujoco

from mjlab.actuator import BuiltinPositionActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg

##
# Actuator config.
##

# hips: ideal_pd, position command.
UNITREE_H1_HIPS_ACTUATOR = BuiltinPositionActuatorCfg(
  target_names_expr=(".*_hip_yaw_joint", ".*_hip_roll_joint", ".*_hip_pitch_joint"),
  stiffness=150.0,  # N*m/rad, authored, rl_gym_robot
  damping=2.0,  # N*m*s/rad, authored, rl_gym_robot
  effort_limit=200.0,  # N*m, authored, h1_urdf
  armature=0.063259741,  # kg*m^2, derived, rl_lab_motors
)
# knees: ideal_pd, position command.
UNITREE_H1_KNEES_ACTUATOR = BuiltinPositionActuatorCfg(
  target_names_expr=(".*_knee_joint",),
  stiffness=200.0,  # N*m/rad, authored, rl_gym_robot
  damping=4.0,  # N*m*s/rad, authored, rl_gym_robot
  effort_limit=300.0,  # N*m, authored, h1_urdf
  armature=0.160478022,  # kg*m^2, derived, rl_lab_motors
)
# ankles: ideal_pd, position command.
UNITREE_H1_ANKLES_ACTUATOR = BuiltinPositionActuatorCfg(
  target_names_expr=(".*_ankle_joint",),
  stiffness=40.0,  # N*m/rad, authored, rl_gym_robot
  damping=2.0,  # N*m*s/rad, authored, rl_gym_robot
  effort_limit=40.0,  # N*m, authored, h1_urdf
  armature=0.0493827150617,  # kg*m^2, derived, rl_lab_h1
)
# torso: ideal_pd, position command.
UNITREE_H1_TORSO_ACTUATOR = BuiltinPositionActuatorCfg(
  target_names_expr=("torso_joint",),
  stiffness=300.0,  # N*m/rad, authored, rl_gym_robot
  damping=3.0,  # N*m*s/rad, authored, rl_gym_robot
  effort_limit=200.0,  # N*m, authored, h1_urdf
  armature=0.063259741,  # kg*m^2, derived, rl_lab_motors
)
# shoulders: ideal_pd, position command.
UNITREE_H1_SHOULDERS_ACTUATOR = BuiltinPositionActuatorCfg(
  target_names_expr=(".*_shoulder_pitch_joint", ".*_shoulder_roll_joint"),
  stiffness=100.0,  # N*m/rad, authored, rl_gym_robot
  damping=2.0,  # N*m*s/rad, authored, rl_gym_robot
  effort_limit=40.0,  # N*m, authored, h1_urdf
  armature=0.0493827150617,  # kg*m^2, derived, rl_lab_h1
)
# arms: ideal_pd, position command.
UNITREE_H1_ARMS_ACTUATOR = BuiltinPositionActuatorCfg(
  target_names_expr=(".*_shoulder_yaw_joint", ".*_elbow_joint"),
  stiffness=50.0,  # N*m/rad, authored, rl_gym_robot
  damping=2.0,  # N*m*s/rad, authored, rl_gym_robot
  effort_limit=18.0,  # N*m, authored, h1_urdf
  armature=0.01,  # kg*m^2, derived, rl_lab_h1
)

##
# Model.
##

DRIVEN_JOINTS = (
  "left_hip_yaw_joint",
  "left_hip_roll_joint",
  "left_hip_pitch_joint",
  "left_knee_joint",
  "left_ankle_joint",
  "right_hip_yaw_joint",
  "right_hip_roll_joint",
  "right_hip_pitch_joint",
  "right_knee_joint",
  "right_ankle_joint",
  "torso_joint",
  "left_shoulder_pitch_joint",
  "left_shoulder_roll_joint",
  "left_shoulder_yaw_joint",
  "left_elbow_joint",
  "right_shoulder_pitch_joint",
  "right_shoulder_roll_joint",
  "right_shoulder_yaw_joint",
  "right_elbow_joint",
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

UNITREE_H1_ARTICULATION = EntityArticulationInfoCfg(
  actuators=(
    UNITREE_H1_HIPS_ACTUATOR,
    UNITREE_H1_KNEES_ACTUATOR,
    UNITREE_H1_ANKLES_ACTUATOR,
    UNITREE_H1_TORSO_ACTUATOR,
    UNITREE_H1_SHOULDERS_ACTUATOR,
    UNITREE_H1_ARMS_ACTUATOR,
  ),
)

# Command per unit of action.
UNITREE_H1_ACTION_SCALE: dict[str, float] = {
  ".*_hip_yaw_joint": 0.25,
  ".*_hip_roll_joint": 0.25,
  ".*_hip_pitch_joint": 0.25,
  ".*_knee_joint": 0.25,
  ".*_ankle_joint": 0.25,
  "torso_joint": 0.25,
  ".*_shoulder_pitch_joint": 0.25,
  ".*_shoulder_roll_joint": 0.25,
  ".*_shoulder_yaw_joint": 0.25,
  ".*_elbow_joint": 0.25,
}

# Pose at zero action; joints that are not named are at 0.
UNITREE_H1_JOINT_POS: dict[str, float] = {
  ".*_hip_pitch_joint": -0.1,
  ".*_knee_joint": 0.3,
  ".*_ankle_joint": -0.2,
}
