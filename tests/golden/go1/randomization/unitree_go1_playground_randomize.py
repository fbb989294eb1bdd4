# Written by actspec 0.1.0 for MuJoCo Playground, MuJoCo 3.11. Do not edit: change the spec and compile again.
# spec sha256 6a61770f58f65ce3198ba58ebeab41c2aea58298034041700d464cdd9d7a7ee7
# For the model that actspec's mujoco target writes; pass it as `randomization_fn`.
#
# What it cannot do:
# - encoder_bias: add -0.015 rad to 0.015 rad -> the drive's torque is shifted, the observation is not (a model holds no
#   encoder: add the bias to the observed joint positions too)
# - strength: scale 0.9 to 1.1, drawn at reset -> drawn at startup (Playground randomizes a model once)

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

JOINTS = (
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
        keys = jax.random.split(key, 2)
        kp = model.actuator_gainprm[act, 0]
        kd = -model.actuator_biasprm[act, 2]
        limit = model.actuator_forcerange[act, 1]
        bias = jnp.zeros(len(JOINTS))
        strength = jnp.ones(len(JOINTS))
        bias = bias + jax.random.uniform(keys[0], (12,), minval=-0.015, maxval=0.015)
        strength = strength * jax.random.uniform(keys[1], (), minval=0.9, maxval=1.1)
        actuator_gainprm = model.actuator_gainprm
        kp = kp * strength
        kd = kd * strength
        actuator_biasprm = model.actuator_biasprm
        actuator_gainprm = actuator_gainprm.at[act, 0].set(kp)
        actuator_biasprm = actuator_biasprm.at[act, 1].set(-kp)
        actuator_biasprm = actuator_biasprm.at[act, 0].set(-kp * bias)
        actuator_biasprm = actuator_biasprm.at[act, 2].set(-kd)
        limit = limit * strength
        actuator_forcerange = model.actuator_forcerange.at[act].set(jnp.stack([-limit, limit], axis=-1))
        return {
            "actuator_gainprm": actuator_gainprm,
            "actuator_biasprm": actuator_biasprm,
            "actuator_forcerange": actuator_forcerange,
        }

    drawn = draw(rng)
    in_axes = jax.tree_util.tree_map(lambda _: None, model)
    in_axes = in_axes.tree_replace(dict.fromkeys(drawn, 0))
    return model.tree_replace(drawn), in_axes
