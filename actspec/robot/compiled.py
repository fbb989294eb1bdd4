"""What a compiled MuJoCo model says: its actuators, whatever shortcut they were written with; the joints that they
move; and how it differs from another.

For an actuator F = gain * x + bias, with x the control or the activation. Enum values differ between versions
of MuJoCo, so they are always compared by name.

Source: MuJoCo 3.7, 3.11, 3.12 and 4.0, measured on 23 forms of actuator.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import mujoco

    from actspec.robot.xml_tree import XmlDocument


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


_ADDRESSES = {
    "mjOBJ_ACTUATOR": "name_actuatoradr",
    "mjOBJ_BODY": "name_bodyadr",
    "mjOBJ_JOINT": "name_jntadr",
    "mjOBJ_KEY": "name_keyadr",
    "mjOBJ_SITE": "name_siteadr",
    "mjOBJ_TENDON": "name_tendonadr",
}
"""Kind of an object to the array that says where its names begin."""


class ModelLists:
    """A model's arrays by name, each turned into a list when it is first asked for.

    One element of an array costs as much as the whole list, and a reader looks at most of them.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        """Keep the model.

        Args:
            model: Compiled; not to be changed afterwards.
        """
        self.model = model
        self._names: dict[int, str] = {}
        start = 0
        for name in model.names.split(b"\0"):
            self._names[start] = name.decode()
            start += len(name) + 1

    def __getattr__(self, name: str) -> Any:
        """The array as a list, of lists where it has several columns."""
        found = getattr(self.model, name).tolist()
        setattr(self, name, found)
        return found

    def name(self, kind: str, index: int) -> str:
        """Name of an object; "" when it has none.

        Args:
            kind: One of `_ADDRESSES`.
            index: Of the object.
        """
        found: str = self._names[getattr(self, _ADDRESSES[kind])[index]]
        return found


def named_parents(model: ModelLists, names: Sequence[str]) -> list[str]:
    """For each joint the nearest named one before it on the way to the world; "" where there is none."""
    first, count = model.body_jntadr, model.body_jntnum
    found = [""] * len(names)
    # The nearest named joint at or above each body; a body comes after its parent.
    last = [""] * len(first)
    for body, parent in enumerate(model.body_parentid):
        above = last[parent]
        for joint in range(first[body], first[body] + count[body]):
            found[joint] = above
            above = names[joint] or above
        last[body] = above
    return found


_INDIRECT = frozenset({"tendon", "site", "slidercrank"})


def reached_joints(model: ModelLists, index: int, transmission: str) -> list[int]:
    """Joints that feel an actuator's force over a tendon, a site or a crank, in the model's order.

    A fixed tendon reaches its joints. A spatial one, a site and a crank reach what lies between the two bodies that
    they pull at, for a site without `refsite` what lies between its body and the world.

    Args:
        model: Compiled.
        index: Of the actuator.
        transmission: As `ActuatorView.transmission`.
    """
    if transmission not in _INDIRECT:
        return []
    first, second = model.actuator_trnid[index]
    if transmission == "tendon":
        joints = _of_tendon(model, first)
    else:
        bodies = model.site_bodyid
        joints = _between(model, bodies[first], bodies[second] if second >= 0 else 0)
    return sorted(joints)


def moved_joints(model: ModelLists, index: int, transmission: str) -> list[int] | None:
    """Joints that an actuator drives, directly or not; None: it may be any. Arguments as in `reached_joints`."""
    if transmission in _INDIRECT:
        return reached_joints(model, index, transmission)
    return [model.actuator_trnid[index][0]] if transmission in ("joint", "jointinparent") else None


def _of_tendon(model: ModelLists, tendon: int) -> set[int]:
    import mujoco

    wrap = mujoco.mjtWrap
    start = model.tendon_adr[tendon]
    found: set[int] = set()
    body: int | None = None
    for at in range(start, start + model.tendon_num[tendon]):
        kind, target = model.wrap_type[at], model.wrap_objid[at]
        if kind == int(wrap.mjWRAP_JOINT):
            found.add(target)
        elif kind == int(wrap.mjWRAP_PULLEY):
            # The branches of a pulley begin anew.
            body = None
        else:
            bodies = model.site_bodyid if kind == int(wrap.mjWRAP_SITE) else model.geom_bodyid
            if body is not None:
                found |= _between(model, body, bodies[target])
            body = bodies[target]
    return found


def _between(model: ModelLists, one: int, other: int) -> set[int]:
    """Joints that move two bodies against each other."""
    apart = _above(model, one) ^ _above(model, other)
    first, count = model.body_jntadr, model.body_jntnum
    return {joint for body in apart for joint in range(first[body], first[body] + count[body])}


def _above(model: ModelLists, body: int) -> set[int]:
    """A body and those that it hangs on, without the world."""
    found = set()
    while body:
        found.add(body)
        body = model.body_parentid[body]
    return found


def reached_by_text(document: XmlDocument, transmission: str, target: str) -> tuple[str, ...] | None:
    """The same from the text alone.

    Args:
        document: Of the model.
        transmission: As `ActuatorView.transmission`.
        target: Likewise.

    Returns: Names of joints; None where it may be any.
    """
    if transmission not in _INDIRECT:
        return ()
    if transmission == "tendon":
        for section in document.sections("tendon"):
            for tendon in section.children:
                if tendon.tag == "fixed" and tendon.get("name") == target:
                    names = (child.get("joint") for child in tendon.children if child.tag == "joint")
                    return tuple(name for name in names if name)
    return None


NOT_COMPARED = frozenset({"signature", "paths", "npaths", "nbuffer", "narena"})
"""Not physics: buffer sizes, file paths (assets are re-pointed) and the spec's own signature."""

DERIVED = frozenset(
    {
        "actuator_acc0",
        "actuator_length0",
        "actuator_lengthrange",
        "body_invweight0",
        "dof_M0",
        "dof_invweight0",
        "tendon_invweight0",
        "flexedge_invweight0",
        "stat.meaninertia",
        "stat.meanmass",
        "stat.meansize",
        "stat.extent",
        "stat.center",
        "tree_sleep_policy",
    }
)
"""What MuJoCo computes from masses, armature and whether a tree has actuators."""


def differences(first: mujoco.MjModel, second: mujoco.MjModel) -> list[str]:
    """Fields in which two models differ, with the first differing entry; empty: none do."""
    found = []
    theirs = dict(model_fields(second))
    for name, value in model_fields(first):
        other = theirs.pop(name, None)
        text = unequal(value, other)
        if text is not None:
            found.append(f"{name}: {text}")
    found += [f"{name}: only in one" for name in theirs]
    return found


def model_fields(model: Any) -> Iterator[tuple[str, Any]]:
    """Every number and array of a model, its options and statistics included."""
    import numpy as np

    for prefix, owner in (("", model), ("opt.", model.opt), ("stat.", model.stat)):
        for name in dir(owner):
            if name.startswith("_") or name in NOT_COMPARED or name.endswith("pathadr"):
                continue
            value = getattr(owner, name)
            if isinstance(value, (int, float, bytes, np.ndarray, np.generic)):
                yield prefix + name, value


def unequal(first: Any, second: Any) -> str | None:
    """What differs between two values of a field, or None."""
    import numpy as np

    if second is None:
        return "only in one"
    if isinstance(first, bytes) or isinstance(second, bytes):
        return None if first == second else "differs"
    a, b = np.asarray(first), np.asarray(second)
    if a.shape != b.shape:
        return f"shape {a.shape} against {b.shape}"
    bad = a != b
    if a.dtype.kind == "f":
        bad &= ~(np.isnan(a) & np.isnan(b))
    if not bad.any():
        return None
    where = tuple(int(i) for i in np.argwhere(bad)[0]) if a.ndim else ()
    return f"{a[where].item()!r} against {b[where].item()!r} at {list(where)}"
