"""Actuators of unitree_go2 for mjlab 1.6."""

# Written by actspec 0.1.0. Do not edit: change the spec and compile again.
# spec sha256 05baffab0465755e22c7e54b03acff005c0554e11a70f463eda822e06295dbfb
# model go2.xml
#
# Use:
#   EntityCfg(
#     spec_fn=lambda: prepare_spec(mujoco.MjSpec.from_file(...)),
#     articulation=UNITREE_GO2_ARTICULATION,
#   )
# with SimulationCfg(mujoco=MujocoCfg(timestep=0.005)), decimation=4.
# soft_joint_pos_limit_factor is left to the task.
#
# Sources:
# - go2_urdf: Unitree's URDF of the Go2 (unitree_ros, BSD-3-Clause),
#   https://github.com/unitreerobotics/unitree_ros,
#   robots/go2_description/urdf/go2_description.urdf, commit
#   d6f13aad60320ce1d60a07b82a76b5a553f2a0a9
# - rl_lab_go2: unitree_rl_lab, UNITREE_GO2_CFG,
#   https://github.com/unitreerobotics/unitree_rl_lab,
#   source/unitree_rl_lab/unitree_rl_lab/assets/robots/unitree.py, commit
#   e72a072c4db68b79a816b3b89bf3b6a0525d113e
# - rl_lab_task: unitree_rl_lab, velocity task of the Go2,
#   https://github.com/unitreerobotics/unitree_rl_lab,
#   source/unitree_rl_lab/unitree_rl_lab/tasks/locomotion/robots/go2/velocity_env_cfg.py,
#   commit e72a072c4db68b79a816b3b89bf3b6a0525d113e
# - unitree_mujoco_go2: unitree_mujoco, Go2 model,
#   https://github.com/unitreerobotics/unitree_mujoco, unitree_robots/go2/go2.xml,
#   commit c598f10
# - go1_urdf: Unitree's URDF of the Go1 (unitree_ros, BSD-3-Clause),
#   https://github.com/unitreerobotics/unitree_ros,
#   robots/go1_description/urdf/go1.urdf, commit
#   d6f13aad60320ce1d60a07b82a76b5a553f2a0a9
# - isaaclab_go: Isaac Lab, limits of the DC motor of Go1 and Go2, as corrected,
#   https://github.com/isaac-sim/IsaacLab, pull request 7564, merged in September 2026

import mujoco

from mjlab.actuator import DcMotorActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg

##
# Actuator config.
##

# hip_thigh: dc_motor, position command.
UNITREE_GO2_HIP_THIGH_ACTUATOR = DcMotorActuatorCfg(
  target_names_expr=(".*_hip_joint", ".*_thigh_joint"),
  stiffness=25.0,  # N*m/rad, authored, rl_lab_go2
  damping=0.5,  # N*m*s/rad, authored, rl_lab_go2
  effort_limit=23.7,  # N*m, authored, go2_urdf
  saturation_effort=23.7,  # N*m, at standstill, authored, isaaclab_go
  velocity_limit=30.1,  # rad/s, no-load speed, authored, isaaclab_go
  armature=0.004026312,  # kg*m^2, derived, go1_urdf
  frictionloss=0.2,  # N*m, authored, unitree_mujoco_go2
  viscous_damping=0.1,  # N*m*s/rad, authored, unitree_mujoco_go2
)
# knee: dc_motor, position command.
UNITREE_GO2_KNEE_ACTUATOR = DcMotorActuatorCfg(
  target_names_expr=(".*_calf_joint",),
  stiffness=25.0,  # N*m/rad, authored, rl_lab_go2
  damping=0.5,  # N*m*s/rad, authored, rl_lab_go2
  effort_limit=45.43,  # N*m, authored, go2_urdf
  saturation_effort=45.43053,  # N*m, at standstill, derived, isaaclab_go
  velocity_limit=15.7024362252,  # rad/s, no-load speed, derived, isaaclab_go
  armature=0.0147947060316,  # kg*m^2, derived, go1_urdf
  frictionloss=0.2,  # N*m, authored, unitree_mujoco_go2
  viscous_damping=0.1,  # N*m*s/rad, authored, unitree_mujoco_go2
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

UNITREE_GO2_ARTICULATION = EntityArticulationInfoCfg(
  actuators=(
    UNITREE_GO2_HIP_THIGH_ACTUATOR,
    UNITREE_GO2_KNEE_ACTUATOR,
  ),
)

# Command per unit of action.
UNITREE_GO2_ACTION_SCALE: dict[str, float] = {
  ".*_hip_joint": 0.25,
  ".*_thigh_joint": 0.25,
  ".*_calf_joint": 0.25,
}

# Pose at zero action; joints that are not named are at 0.
UNITREE_GO2_JOINT_POS: dict[str, float] = {
  ".*R_hip_joint": -0.1,
  "F[LR]_thigh_joint": 0.8,
  ".*_calf_joint": -1.5,
  ".*L_hip_joint": 0.1,
  "R[LR]_thigh_joint": 1.0,
}
