"""Actuators of unitree_a1_stiff for mjlab 1.6."""

# Written by actspec 0.1.0. Do not edit: change the spec and compile again.
# spec sha256 f15b40fabbb70811892572ac64bc7bae9593951b87cc57d1966644d022b81467
# model a1.xml
#
# Use:
#   EntityCfg(
#     spec_fn=lambda: prepare_spec(mujoco.MjSpec.from_file(...)),
#     articulation=UNITREE_A1_STIFF_ARTICULATION,
#   )
# with SimulationCfg(mujoco=MujocoCfg(timestep=0.002)), decimation=10.
# soft_joint_pos_limit_factor is left to the task.
#
# Sources:
# - a1_urdf: Unitree's URDF of the A1 (unitree_ros, BSD-3-Clause),
#   https://github.com/unitreerobotics/unitree_ros, robots/a1_description/urdf/a1.urdf,
#   commit d6f13aad60320ce1d60a07b82a76b5a553f2a0a9
# - isaaclab_a1: Isaac Lab 2.3.2, UNITREE_A1_CFG, https://github.com/isaac-sim/IsaacLab,
#   source/isaaclab_assets/isaaclab_assets/robots/unitree.py
# - legged_gym: legged_gym, A1RoughCfg and its base class,
#   https://github.com/leggedrobotics/legged_gym, legged_gym/envs/a1/a1_config.py,
#   legged_gym/envs/base/legged_robot_config.py, commit
#   054812147280e14bf0b99aac610e104472f45060
# - menagerie_a1: MuJoCo Menagerie, unitree_a1,
#   https://github.com/google-deepmind/mujoco_menagerie, unitree_a1/a1.xml, commit
#   1b428b08bb26ca6024e7b21e8ff21a59f847eb87
# - actspec_choice: Chosen for this file; no publication, SOURCES.md, "The stiffer
#   gains"

import mujoco

from mjlab.actuator import DcMotorActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg

##
# Actuator config.
##

# legs: dc_motor, position command.
UNITREE_A1_STIFF_LEGS_ACTUATOR = DcMotorActuatorCfg(
  target_names_expr=(".*_hip_joint", ".*_thigh_joint", ".*_calf_joint"),
  stiffness=100.0,  # N*m/rad, authored, menagerie_a1
  damping=4.0,  # N*m*s/rad, authored, actspec_choice
  effort_limit=33.5,  # N*m, authored, isaaclab_a1
  saturation_effort=33.5,  # N*m, at standstill, authored, isaaclab_a1
  velocity_limit=21.0,  # rad/s, no-load speed, authored, isaaclab_a1
  armature=0.01,  # kg*m^2, authored, menagerie_a1
  frictionloss=0.2,  # N*m, authored, a1_urdf
  viscous_damping=0.01,  # N*m*s/rad, authored, a1_urdf
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

UNITREE_A1_STIFF_ARTICULATION = EntityArticulationInfoCfg(
  actuators=(UNITREE_A1_STIFF_LEGS_ACTUATOR,),
)

# Command per unit of action.
UNITREE_A1_STIFF_ACTION_SCALE: dict[str, float] = {
  ".*_hip_joint": 0.25,
  ".*_thigh_joint": 0.25,
  ".*_calf_joint": 0.25,
}

# Pose at zero action; joints that are not named are at 0.
UNITREE_A1_STIFF_JOINT_POS: dict[str, float] = {
  ".*R_hip_joint": -0.1,
  "F[LR]_thigh_joint": 0.8,
  ".*_calf_joint": -1.5,
  ".*L_hip_joint": 0.1,
  "R[LR]_thigh_joint": 1.0,
}
