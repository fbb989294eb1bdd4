# Written by actspec 0.1.0 for MuJoCo Playground, MuJoCo 3.11. Do not edit: change the spec and compile again.
# spec sha256 087defe91d196249ca6abb0a277cc6e932c93dcf2fcb2567a23f24528eae95db
# variant mode_5
# For the model that actspec's mujoco target writes; pass it as `randomization_fn`.
#
# What it cannot do:
# - kp: scale 0.75 to 1.25, drawn at reset -> drawn at startup (Playground randomizes a model once)
# - kd: scale 0.75 to 1.25, drawn at reset -> drawn at startup (Playground randomizes a model once)
# - encoder_bias: add -0.015 rad to 0.015 rad -> the drive's torque is shifted, the observation is not (a model holds no
#   encoder: add the bias to the observed joint positions too)

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

JOINTS = (
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


def _addresses(model: mjx.Model) -> np.ndarray:
    """Actuator of each joint of JOINTS, by name."""
    names = [model.names[at : model.names.index(b"\0", at)].decode() for at in np.asarray(model.name_jntadr)]
    joints = [names.index(joint) for joint in JOINTS]
    onto_joint = np.asarray(model.actuator_trntype) == int(mujoco.mjtTrn.mjTRN_JOINT)
    target = np.where(onto_joint, np.asarray(model.actuator_trnid)[:, 0], -1).tolist()
    return np.array([target.index(joint) for joint in joints])


def domain_randomize(model: mjx.Model, rng: jax.Array) -> tuple[mjx.Model, mjx.Model]:
    """Draw one model per key of `rng`; returns the batched model and its in_axes."""
    act = _addresses(model)

    @jax.vmap
    def draw(key):
        keys = jax.random.split(key, 3)
        kp = model.actuator_gainprm[act, 0]
        kd = -model.actuator_biasprm[act, 2]
        bias = jnp.zeros(len(JOINTS))
        kp = kp * jax.random.uniform(keys[0], (29,), minval=0.75, maxval=1.25)
        kd = kd * jax.random.uniform(keys[1], (29,), minval=0.75, maxval=1.25)
        bias = bias + jax.random.uniform(keys[2], (29,), minval=-0.015, maxval=0.015)
        actuator_gainprm = model.actuator_gainprm
        actuator_biasprm = model.actuator_biasprm
        actuator_gainprm = actuator_gainprm.at[act, 0].set(kp)
        actuator_biasprm = actuator_biasprm.at[act, 1].set(-kp)
        actuator_biasprm = actuator_biasprm.at[act, 0].set(-kp * bias)
        actuator_biasprm = actuator_biasprm.at[act, 2].set(-kd)
        return {
            "actuator_gainprm": actuator_gainprm,
            "actuator_biasprm": actuator_biasprm,
        }

    drawn = draw(rng)
    in_axes = jax.tree_util.tree_map(lambda _: None, model)
    in_axes = in_axes.tree_replace(dict.fromkeys(drawn, 0))
    return model.tree_replace(drawn), in_axes
