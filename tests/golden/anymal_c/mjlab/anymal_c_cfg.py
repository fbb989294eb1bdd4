"""Actuators of anymal_c for mjlab 1.6."""

# Written by actspec 0.1.0. Do not edit: change the spec and compile again.
# spec sha256 f6b1aa5d5034b01acf60931884faea14a07b416bca910fee08fd25753286bd38
# model anymal_c.xml
#
# Use:
#   EntityCfg(
#     spec_fn=lambda: prepare_spec(mujoco.MjSpec.from_file(...)),
#     articulation=ANYMAL_C_ARTICULATION,
#   )
# with SimulationCfg(mujoco=MujocoCfg(timestep=0.005)), decimation=4.
# soft_joint_pos_limit_factor is left to the task.
#
# Sources:
# - isaaclab_velocity: Isaac Lab, velocity task, which the ANYmal's inherits,
#   https://github.com/isaac-sim/IsaacLab,
#   source/isaaclab_tasks/isaaclab_tasks/manager_based/locomotion/velocity/velocity_env_cfg.py,
#   commit d02d3b8a59400d2a7ea2d7ce717128c673d293d3
# - pace_data: PACE, data_collection.py, parameters close to those of the real ANYmal D,
#   https://github.com/leggedrobotics/pace-sim2real, scripts/pace/data_collection.py,
#   docs/examples/anymal.md, commit f8ec8b85015140633870463dd27d498ac9f96b53
# - isaaclab_anymal: Isaac Lab, ANYDRIVE_3_SIMPLE_ACTUATOR_CFG,
#   https://github.com/isaac-sim/IsaacLab,
#   source/isaaclab_assets/isaaclab_assets/robots/anymal.py, commit
#   931679641ee84e1b4175c15b48f9286d44ba9b04

import mujoco

from mjlab.actuator import DcMotorActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg

##
# Actuator config.
##

# legs: dc_motor, position command.
ANYMAL_C_LEGS_ACTUATOR = DcMotorActuatorCfg(
  target_names_expr=(".*_HAA", ".*_HFE", ".*_KFE"),
  stiffness=40.0,  # N*m/rad, authored, isaaclab_anymal
  damping=5.0,  # N*m*s/rad, authored, isaaclab_anymal
  effort_limit=80.0,  # N*m, authored, isaaclab_anymal
  saturation_effort=120.0,  # N*m, at standstill, authored, isaaclab_anymal
  velocity_limit=7.5,  # rad/s, no-load speed, authored, isaaclab_anymal
  armature=0.1,  # kg*m^2, authored, pace_data
)

##
# Model.
##

DRIVEN_JOINTS = (
  "LF_HAA",
  "LF_HFE",
  "LF_KFE",
  "RF_HAA",
  "RF_HFE",
  "RF_KFE",
  "LH_HAA",
  "LH_HFE",
  "LH_KFE",
  "RH_HAA",
  "RH_HFE",
  "RH_KFE",
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

ANYMAL_C_ARTICULATION = EntityArticulationInfoCfg(
  actuators=(ANYMAL_C_LEGS_ACTUATOR,),
)

# Command per unit of action.
ANYMAL_C_ACTION_SCALE: dict[str, float] = {
  ".*_HAA": 0.5,
  ".*_HFE": 0.5,
  ".*_KFE": 0.5,
}

# Pose at zero action; joints that are not named are at 0.
ANYMAL_C_JOINT_POS: dict[str, float] = {
  ".F_HFE": 0.4,
  ".F_KFE": -0.8,
  ".H_HFE": -0.4,
  ".H_KFE": 0.8,
}
