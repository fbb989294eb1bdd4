"""What a compiled MuJoCo actuator is, whatever shortcut it was written with.

F = gain * x + bias, with x the control or the activation. Enum values differ between versions
of MuJoCo, so they are always compared by name.

Source: MuJoCo 3.7, 3.11, 3.12 and 4.0, measured on 23 forms of actuator.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from actspec.robot.model_lists import ModelLists

NAN = math.nan

_TRANSMISSIONS = {
    "mjTRN_JOINT": "joint",
    "mjTRN_JOINTINPARENT": "jointinparent",
    "mjTRN_SLIDERCRANK": "slidercrank",
    "mjTRN_TENDON": "tendon",
    "mjTRN_SITE": "site",
    "mjTRN_BODY": "body",
    "mjTRN_SO3": "joint",
}

_TARGETS = {
    "joint": "mjOBJ_JOINT",
    "jointinparent": "mjOBJ_JOINT",
    "tendon": "mjOBJ_TENDON",
    "body": "mjOBJ_BODY",
}


@dataclass(frozen=True, slots=True)
class Control:
    """Kind of an actuator and its gains, actuator side.

    Attributes:
        kind: As `ActuatorView.control`.
        kp: [N*m/rad before the gear]; negative where the file has the wrong sign, nan where the control or a
            plugin decides on it, as in a muscle.
        kd: [N*m*s/rad before the gear]; nan likewise, as in a damper.
        gain: gainprm[0] as compiled.
        time_constant: Of the activation's filter [s]; 0 without one.
        offset: Constant force beside gain and feedback [N*m or N].
        line: As `ActuatorView.line`, before the gear.
        back_emf: As `ActuatorView.back_emf`, before the gear.
    """

    kind: str
    kp: float
    kd: float
    gain: float
    time_constant: float
    offset: float = 0.0
    line: tuple[float, float] | None = None
    back_emf: float = 0.0


def control(model: ModelLists, index: int, tag: str) -> Control:
    """Classify one actuator.

    Args:
        model: Compiled.
        index: Of the actuator.
        tag: Its XML tag; only `cylinder` and `adhesion` are not known by their numbers.
    """
    import mujoco

    gain_type = _name(mujoco.mjtGain, model.actuator_gaintype[index])
    bias_type = _name(mujoco.mjtBias, model.actuator_biastype[index])
    dynamics = _name(mujoco.mjtDyn, model.actuator_dyntype[index])
    gain: list[float] = model.actuator_gainprm[index]
    bias: list[float] = model.actuator_biasprm[index]
    filtered = dynamics in ("mjDYN_FILTER", "mjDYN_FILTEREXACT")
    tau = model.actuator_dynprm[index][0] if filtered else 0.0

    offset = bias[0] if bias_type == "mjBIAS_AFFINE" else 0.0

    def is_(kind: str, kp: float = 0.0, kd: float = 0.0) -> Control:
        # `+ 0.0` turns the -0.0 of a negated zero into 0.0.
        return Control(kind, kp + 0.0, kd + 0.0, gain[0], tau, offset)

    if model.actuator_plugin[index] >= 0:
        return is_("plugin", NAN, NAN)
    if gain_type == "mjGAIN_DCMOTOR":
        kp, kd, back_emf = _dcmotor_gains(model, index, gain)
        line = _dcmotor_line(model, index, gain, bias)
        return replace(is_("dcmotor", kp, kd), line=line, back_emf=back_emf)
    if gain_type == "mjGAIN_PID":
        return is_("pid", -bias[1], -bias[2])
    told = gain_type == "mjGAIN_FIXED" and bias_type in ("mjBIAS_NONE", "mjBIAS_AFFINE")
    feedback = (-bias[1], -bias[2]) if bias_type == "mjBIAS_AFFINE" else (0.0, 0.0)
    other = ("other", *(feedback if told else (NAN, NAN)))
    if tag in ("cylinder", "adhesion") or dynamics in ("mjDYN_MUSCLE", "mjDYN_USER"):
        return is_(*other)
    integrated = dynamics == "mjDYN_INTEGRATOR"
    # A class may leave numbers in biasprm that no biastype uses.
    if bias_type == "mjBIAS_NONE":
        if gain_type == "mjGAIN_FIXED" and not integrated:
            return is_("motor")
        if gain_type == "mjGAIN_AFFINE" and gain[0] == gain[1] == 0.0:
            return is_("damper", 0.0, NAN)
    elif bias_type == "mjBIAS_AFFINE" and gain_type == "mjGAIN_FIXED":
        kp, kd = feedback
        if integrated:
            return is_("intvelocity" if gain[0] == kp else "other", kp, kd)
        if kp == 0.0:
            velocity = kd != 0.0 and gain[0] == kd
            return is_("velocity" if velocity else "motor", 0.0, kd)
        # A gain that is not kp is a position servo with the wrong equilibrium: `gain` tells.
        return is_("position", kp, kd)
    return is_(*other)


def _dcmotor_gains(model: ModelLists, index: int, gain: list[float]) -> tuple[float, float, float]:
    """kp and kd in torque of a dcmotor in the linear region, and how much of kd is back-EMF without a controller."""
    import mujoco

    resistance, constant = gain[0], gain[1]
    ratio = constant / resistance if resistance else 0.0
    back_emf = constant * ratio
    # From 3.12 on controller gains are torques, and gainprm[8] is no mode any more.
    if hasattr(mujoco.mjtGain, "mjGAIN_PID"):
        inputs = mujoco.mjtCtrlInput
        closed = int(inputs.mjINPUT_POS) | int(inputs.mjINPUT_VEL) | int(inputs.mjINPUT_FF)
        if model.actuator_ctrlspec[index] & closed:
            return gain[4], gain[6], 0.0
        return 0.0, back_emf, back_emf
    if gain[8] == 1.0:
        return gain[4] * ratio, gain[6] * ratio + back_emf, 0.0
    if gain[8] == 2.0:
        return 0.0, gain[4] * ratio + back_emf, 0.0
    return 0.0, back_emf, back_emf


def _dcmotor_line(
    model: ModelLists, index: int, gain: list[float], bias: list[float]
) -> tuple[float, float] | None:
    """Stall torque K V/R and no-load speed V/K of a dcmotor that is a PD within its voltage, nothing else."""
    import mujoco

    resistance, constant, integral, voltage = gain[0], gain[1], gain[5], gain[7]
    if min(resistance, constant, voltage) <= 0.0 or integral or any(bias) or model.actuator_actnum[index]:
        return None
    if hasattr(mujoco.mjtGain, "mjGAIN_PID"):
        # One input: a position, a velocity without any stiffness left, or a torque without any gain.
        inputs = model.actuator_ctrlspec[index]
        speed = inputs == int(mujoco.mjtCtrlInput.mjINPUT_VEL) and gain[4] == 0.0
        torque = inputs == int(mujoco.mjtCtrlInput.mjINPUT_FF) and gain[4] == gain[6] == 0.0
        if inputs != int(mujoco.mjtCtrlInput.mjINPUT_POS) and not speed and not torque:
            return None
    elif gain[8] != 1.0:
        return None
    return constant * voltage / resistance, voltage / constant


def transmission(model: ModelLists, index: int) -> tuple[str, str]:
    """Kind of an actuator's transmission and the name of its target.

    Args:
        model: Compiled.
        index: Of the actuator.
    """
    import mujoco

    kind = _TRANSMISSIONS.get(_name(mujoco.mjtTrn, model.actuator_trntype[index]), "other")
    target = model.actuator_trnid[index][0]
    return kind, model.name(_TARGETS.get(kind, "mjOBJ_SITE"), target) if target >= 0 else ""


@lru_cache(maxsize=256)
def _name(enum: Any, value: int) -> str:
    try:
        return str(enum(value).name)
    except (ValueError, TypeError):
        return ""
