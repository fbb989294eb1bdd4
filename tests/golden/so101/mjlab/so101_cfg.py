"""Actuators of so101 for mjlab 1.6."""

# Written by actspec 0.1.0. Do not edit: change the spec and compile again.
# spec sha256 8dd0463e5b925b2eb911a65ff1a2a231c074e7b801fcfa1de0e6f45eaca15874
# model so101.xml
#
# Use:
#   EntityCfg(
#     spec_fn=lambda: prepare_spec(mujoco.MjSpec.from_file(...)),
#     articulation=SO101_ARTICULATION,
#   )
# with SimulationCfg(mujoco=MujocoCfg(timestep=0.005)), decimation=4.
# soft_joint_pos_limit_factor is left to the task.
#
# Sources:
# - lerobot_so101: LeRobot, SO101Follower, https://github.com/huggingface/lerobot,
#   src/lerobot/robots/so101_follower/so101_follower.py, commit
#   0c83b9ab164c30775dd34032c0a12253f56f5d6b
# - bam_sts3215: BAM (Better Actuator Models), STS3215 at 7.4 V, model m1,
#   https://github.com/Rhoban/bam, bam/params/feetech_sts3215_7_4V/m1.json,
#   bam/feetech/actuator.py, commit 1b5a1cee2e6dcd2ab8c12b013f1e05482b16cb96
# - dfrobot_st3215: DFRobot SER0069 (ST3215), data of a reseller,
#   https://littlebirdelectronics.com.au/products/st3215-serial-bus-servo-19-5kg-7-4v-360-magnetic-encoder

import mujoco

from mjlab.actuator import DcMotorActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg

##
# Actuator config.
##

# arm: dc_motor, position command.
SO101_ARM_ACTUATOR = DcMotorActuatorCfg(
  target_names_expr=("shoulder_.*", "elbow_flex", "wrist_.*", "gripper"),
  stiffness=8.89858,  # N*m/rad, authored, lerobot_so101
  damping=0.548574,  # N*m*s/rad, authored, bam_sts3215
  effort_limit=1.9123,  # N*m, derived, dfrobot_st3215
  saturation_effort=3.24986,  # N*m, at standstill, authored, bam_sts3215
  velocity_limit=5.9242,  # rad/s, no-load speed, authored, bam_sts3215
  armature=0.0284034,  # kg*m^2, derived, bam_sts3215
  frictionloss=0.052393,  # N*m, authored, bam_sts3215
  viscous_damping=0.0590852,  # N*m*s/rad, authored, bam_sts3215
)

##
# Model.
##

DRIVEN_JOINTS = (
  "shoulder_pan",
  "shoulder_lift",
  "elbow_flex",
  "wrist_flex",
  "wrist_roll",
  "gripper",
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

SO101_ARTICULATION = EntityArticulationInfoCfg(
  actuators=(SO101_ARM_ACTUATOR,),
)
