"""Reset a compiled MuJoCo model without a jump.

A bare `mj_resetData` sets controls, filter states and delay lines to 0, so a robot whose drives
have a filter or a delay is first pulled to zero. This sets all three to where the joints are.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import mujoco


def reset(
    model: mujoco.MjModel,
    data: mujoco.MjData,
    keyframe: str | int | None = None,
    *,
    command: Mapping[str, float] | None = None,
) -> None:
    """Reset a simulation to a keyframe, drives at rest.

    The command of every position drive becomes its joint's position (times the gear), that of the
    other drives 0; filters and delay lines are filled with it, so that the first torque is that of
    the pose and not of a jump. `mj_forward` is called last.

    Args:
        model: Compiled.
        data: Its data; overwritten.
        keyframe: Name or index; default: the first one if there is any, else qpos0.
        command: Actuator to command [rad or m, rad/s or m/s, N*m or N], over those of the pose.

    Raises:
        KeyError: no keyframe or actuator has that name.
    """
    import mujoco
    import numpy as np

    index = _keyframe(model, keyframe)
    if index is None:
        mujoco.mj_resetData(model, data)
    else:
        mujoco.mj_resetDataKeyframe(model, data, index)
    given = {_actuator(model, name): value for name, value in (command or {}).items()}
    for actuator in range(_count(model)):
        first, count = _controls(model, actuator)
        if count != 1:
            continue
        value = given.get(actuator)
        if value is None:
            value = _resting(model, data, actuator)
        if value is None:
            value = float(data.ctrl[first])
        data.ctrl[first] = value
        start, states = int(model.actuator_actadr[actuator]), int(model.actuator_actnum[actuator])
        if states and _is_filter(model, actuator):
            data.act[start + states - 1] = value
        history = getattr(model, "actuator_history", None)
        if history is not None and int(history[actuator][0]) > 0:
            samples = int(history[actuator][0])
            mujoco.mj_initCtrlHistory(model, data, actuator, None, np.full(samples, value))
    mujoco.mj_forward(model, data)


def _keyframe(model: Any, keyframe: str | int | None) -> int | None:
    import mujoco

    if keyframe is None:
        return 0 if model.nkey else None
    if isinstance(keyframe, int):
        if not 0 <= keyframe < model.nkey:
            raise KeyError(f"there is no keyframe {keyframe}; the model has {model.nkey}")
        return keyframe
    index = int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, keyframe))
    if index < 0:
        names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_KEY, k) for k in range(model.nkey)]
        raise KeyError(f"there is no keyframe {keyframe!r}; the model has {names}")
    return index


def _actuator(model: Any, name: str) -> int:
    import mujoco

    index = int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_ACTUATOR, name))
    if index < 0:
        raise KeyError(f"there is no actuator {name!r}")
    return index


def _count(model: Any) -> int:
    """Number of actuators; from 3.11 on it may differ from the number of controls."""
    return int(getattr(model, "nactuator", model.nu))


def _controls(model: Any, actuator: int) -> tuple[int, int]:
    address = getattr(model, "actuator_ctrladr", None)
    if address is None:
        return actuator, 1
    return int(address[actuator]), int(model.actuator_ctrlnum[actuator])


def _resting(model: Any, data: Any, actuator: int) -> float | None:
    """Command at which a drive rests: the joint's position for a position drive, 0 for others.

    None for an actuator that actspec did not write (other transmissions, muscles, plugins).
    """
    import mujoco

    joint_transmission = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    if model.actuator_trntype[actuator] not in [int(kind) for kind in joint_transmission]:
        return None
    joint = int(model.actuator_trnid[actuator][0])
    if model.jnt_type[joint] not in (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)):
        return None
    position = float(data.qpos[model.jnt_qposadr[joint]]) * float(model.actuator_gear[actuator][0])
    gain = model.actuator_gaintype[actuator]
    if gain == int(mujoco.mjtGain.mjGAIN_FIXED):
        affine = model.actuator_biastype[actuator] == int(mujoco.mjtBias.mjBIAS_AFFINE)
        return position if affine and model.actuator_biasprm[actuator][1] != 0.0 else 0.0
    if gain == int(mujoco.mjtGain.mjGAIN_DCMOTOR):
        return position if _dcmotor_takes_position(model, actuator) else 0.0
    return None


def _dcmotor_takes_position(model: Any, actuator: int) -> bool:
    import mujoco

    inputs = getattr(mujoco, "mjtCtrlInput", None)
    spec = getattr(model, "actuator_ctrlspec", None)
    if inputs is not None and spec is not None and hasattr(inputs, "mjINPUT_POS"):
        return bool(int(spec[actuator]) & int(inputs.mjINPUT_POS))
    # Before 3.12 the mode stands in the gain: 0 voltage, 1 position, 2 velocity.
    return int(model.actuator_gainprm[actuator][8]) == 1


def _is_filter(model: Any, actuator: int) -> bool:
    import mujoco

    filters = (mujoco.mjtDyn.mjDYN_FILTER, mujoco.mjtDyn.mjDYN_FILTEREXACT)
    return int(model.actuator_dyntype[actuator]) in [int(kind) for kind in filters]
