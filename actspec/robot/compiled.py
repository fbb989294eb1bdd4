"""What a compiled MuJoCo model says: its actuators, whatever shortcut they were written with; the joints that they
move; and how it differs from another.

For an actuator F = gain * x + bias, with x the control or the activation. Enum values differ between versions
of MuJoCo, so they are always compared by name.

Source: MuJoCo 3.7, 3.11, 3.12 and 4.0, measured on 23 forms of actuator.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import mujoco

    from actspec.robot.xml_tree import XmlDocument


NAN = math.nan

_Range = tuple[float, float] | None

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
        kp: [N*m/rad before the gear]; negative where the file has the wrong sign, nan where it is not known: where
            the control or a plugin decides on it, as in a muscle.
        kd: [N*m*s/rad before the gear]; nan likewise, as in a damper.
        gain: gainprm[0] as compiled.
        time_constant: Of the activation's filter [s]; 0 without one.
        offset: Constant force beside gain and feedback [N*m or N].
        line: As `ActuatorView.line`, before the gear.
        back_emf: As `ActuatorView.back_emf`, before the gear.
        dynamics: How the activation follows the control: `ActuatorLaw.dynamics_type`.
    """

    kind: str
    kp: float
    kd: float
    gain: float
    time_constant: float
    offset: float = 0.0
    line: tuple[float, float] | None = None
    back_emf: float = 0.0
    dynamics: str = "none"

    def at_joint(self, gear: float, control: _Range, activation: _Range) -> dict[str, Any]:
        """The fields of an `ActuatorView` that it tells, at the joint where they are there.

        Args:
            gear: First gear number.
            control: `ctrlrange` in force.
            activation: `actrange` in force.
        """
        line = None if self.line is None or not gear else (abs(gear) * self.line[0], self.line[1] / abs(gear))
        return {
            "control": self.kind,
            "gear": gear,
            "kp": gear**2 * self.kp,
            "kd": gear**2 * self.kd,
            "gain": self.gain,
            "time_constant": self.time_constant,
            "offset": self.offset,
            "line": line,
            "back_emf": gear**2 * self.back_emf,
            "control_range": control,
            "input_range": self._input_range(control, activation),
        }

    def _input_range(self, control: _Range, activation: _Range) -> _Range:
        """Range of what the gain multiplies. Source: MuJoCo 4.0, measured."""
        if self.dynamics in ("integrator", "user"):
            return activation
        if self.dynamics not in _FOLLOWING or control is None or activation is None:
            return activation if control is None and self.dynamics in _FOLLOWING else control
        return max(control[0], activation[0]), min(control[1], activation[1])


_FOLLOWING = frozenset({"filter", "filterexact", "muscle"})
"""Dynamics whose activation does not leave the range of the control."""

_CLOSED = frozenset({"pos", "vel", "ff"})


def _no_gain() -> list[float]:
    return [1.0] + [0.0] * 9


@dataclass(slots=True)
class ActuatorLaw:
    """Parameters of an actuator, compiled or as the text makes them.

    Attributes:
        gain, bias, dynamics: Parameters, as many as are used here.
        gain_type, bias_type, dynamics_type: Keywords of the file format.
        inputs: Controls of a `pid`, a `dcmotor` or a `general`.
        mode: Input mode of a dcmotor in the dialect of 3.7 to 3.11; None in the later one.
        states: Whether a dcmotor has states (current, slew, integral, heat, bristles).
    """

    gain: list[float] = field(default_factory=_no_gain)
    bias: list[float] = field(default_factory=lambda: [0.0] * 10)
    dynamics: list[float] = field(default_factory=_no_gain)
    gain_type: str = "fixed"
    bias_type: str = "none"
    dynamics_type: str = "none"
    inputs: frozenset[str] = frozenset()
    mode: str | None = None
    states: bool = False

    def control(self, tag: str) -> Control:
        """Classify the actuator.

        Args:
            tag: Its XML tag; only `cylinder`, `adhesion` and `plugin` are not known by their numbers.
        """
        gain, bias = self.gain, self.bias
        tau = self.dynamics[0] if self.dynamics_type in ("filter", "filterexact") else 0.0
        offset = bias[0] if self.bias_type == "affine" else 0.0

        def is_(kind: str, kp: float = 0.0, kd: float = 0.0) -> Control:
            # `+ 0.0` turns the -0.0 of a negated zero into 0.0.
            return Control(kind, kp + 0.0, kd + 0.0, gain[0], tau, offset, dynamics=self.dynamics_type)

        if tag == "plugin":
            return is_("plugin", NAN, NAN)
        if self.gain_type == "dcmotor":
            return self._motor_control(tau, offset)
        if self.gain_type == "pid":
            return is_("pid", -bias[1], -bias[2])
        told = self.gain_type == "fixed" and self.bias_type in ("none", "affine")
        feedback = (-bias[1], -bias[2]) if self.bias_type == "affine" else (0.0, 0.0)
        other = is_("other", *(feedback if told else (NAN, NAN)))
        if tag == "adhesion" or self.dynamics_type in ("muscle", "user"):
            return other
        if tag == "cylinder":
            # Its bias is a spring and a damper in it, and no servo's.
            return other if feedback[0] else is_("motor", 0.0, feedback[1])
        integrated = self.dynamics_type == "integrator"
        # A class may leave numbers in biasprm that no biastype uses.
        if self.bias_type == "none":
            if self.gain_type == "fixed" and not integrated:
                return is_("motor")
            if self.gain_type == "affine" and gain[0] == gain[1] == 0.0:
                return is_("damper", 0.0, NAN)
        elif self.bias_type == "affine" and self.gain_type == "fixed":
            kp, kd = feedback
            if integrated:
                return is_("intvelocity" if gain[0] == kp else "other", kp, kd)
            if kp == 0.0:
                velocity = kd != 0.0 and gain[0] == kd
                return is_("velocity" if velocity else "motor", 0.0, kd)
            # A gain that is not kp is a position servo with the wrong equilibrium: `gain` tells.
            return is_("position", kp, kd)
        return other

    def _motor_control(self, tau: float, offset: float) -> Control:
        """A dcmotor in the linear region, gains in torque.

        Its line, stall torque K V/R and no-load speed V/K, is there where it is a PD within its voltage: with one
        input, a position, a velocity without any stiffness left, or a torque without any gain.
        """
        resistance, constant, kp, integral, kd, voltage = (self.gain[i] for i in (0, 1, 4, 5, 6, 7))
        ratio = constant / resistance if resistance else NAN
        own = constant * ratio
        back_emf = 0.0
        # From 3.12 on controller gains are torques, and there is no mode any more.
        if self.mode == "position":
            kp, kd = kp * ratio, kd * ratio + own
        elif self.mode == "velocity":
            kp, kd = 0.0, kp * ratio + own
        elif not self.inputs & _CLOSED:
            kp, kd, back_emf = 0.0, own, own
        line = None
        pd = self.mode == "position" or self.inputs == {"pos"} or (self.inputs == {"vel"} and kp == 0.0)
        pd = pd or (self.inputs == {"ff"} and kp == kd == 0.0)
        more = integral or self.states or any(self.bias)
        if pd and min(resistance, constant, voltage) > 0.0 and not more:
            line = (constant * voltage / resistance, voltage / constant)
        return Control("dcmotor", kp, kd, resistance, tau, offset, line, back_emf)


def control(model: ModelLists, index: int, tag: str) -> Control:
    """Classify one compiled actuator.

    Args:
        model: Compiled.
        index: Of the actuator.
        tag: Its XML tag; "" when unknown.
    """
    import mujoco

    law = ActuatorLaw(
        model.actuator_gainprm[index],
        model.actuator_biasprm[index],
        model.actuator_dynprm[index],
        _name(mujoco.mjtGain, model.actuator_gaintype[index]).removeprefix("mjGAIN_").lower(),
        _name(mujoco.mjtBias, model.actuator_biastype[index]).removeprefix("mjBIAS_").lower(),
        _name(mujoco.mjtDyn, model.actuator_dyntype[index]).removeprefix("mjDYN_").lower(),
    )
    if law.gain_type == "dcmotor":
        law.states = bool(model.actuator_actnum[index])
        if hasattr(mujoco.mjtGain, "mjGAIN_PID"):
            bits, inputs = model.actuator_ctrlspec[index], mujoco.mjtCtrlInput
            law.inputs = frozenset(
                name.removeprefix("mjINPUT_").lower()
                for name, bit in inputs.__members__.items()
                if bits & int(bit)
            )
        else:
            law.mode = {1.0: "position", 2.0: "velocity"}.get(law.gain[8])
    return law.control("plugin" if model.actuator_plugin[index] >= 0 else tag)


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
    """For each joint the nearest named one before it on the way to the world, but for free ones; "" where there is
    none.
    """
    import mujoco

    free = int(mujoco.mjtJoint.mjJNT_FREE)
    first, count, kinds = model.body_jntadr, model.body_jntnum, model.jnt_type
    found = [""] * len(names)
    # The nearest named joint at or above each body; a body comes after its parent.
    last = [""] * len(first)
    for body, parent in enumerate(model.body_parentid):
        above = last[parent]
        for joint in range(first[body], first[body] + count[body]):
            found[joint] = above
            above = above if kinds[joint] == free else names[joint] or above
        last[body] = above
    return found


def joint_axes(
    model: mujoco.MjModel, *, in_world: bool = False
) -> list[dict[str, tuple[float, float, float]]]:
    """`axis` and `point` of each hinge and slide in the frame of the body at the root of its tree, at `qpos0`.

    Where that body stands does not matter: a scene may turn the robot.

    Args:
        model: Compiled.
        in_world: In the world's frame, which is that of a URDF's base as MuJoCo imports it.

    Returns: Fields of a `JointView`; none for balls and free joints, and where a number is not finite.
    """
    import mujoco
    import numpy as np

    turned, moved = np.tile([1.0, 0.0, 0.0, 0.0], (model.nbody, 1)), np.zeros((model.nbody, 3))
    for body, parent in enumerate(model.body_parentid.tolist()):
        if parent or in_world:
            mujoco.mju_mulQuat(turned[body], turned[parent], model.body_quat[body])
            mujoco.mju_rotVecQuat(moved[body], model.body_pos[body], turned[parent])
            moved[body] += moved[parent]
    found: list[dict[str, tuple[float, float, float]]] = []
    for joint, kind in enumerate(model.jnt_type.tolist()):
        body = model.jnt_bodyid[joint]
        axis, point = np.zeros(3), np.zeros(3)
        mujoco.mju_rotVecQuat(axis, model.jnt_axis[joint], turned[body])
        mujoco.mju_rotVecQuat(point, model.jnt_pos[joint], turned[body])
        scalar = _name(mujoco.mjtJoint, kind) in ("mjJNT_HINGE", "mjJNT_SLIDE")
        (x, y, z), (a, b, c) = axis.tolist(), (moved[body] + point).tolist()
        known = scalar and np.isfinite([x, y, z, a, b, c]).all()
        found.append({"axis": (x, y, z), "point": (a, b, c)} if known else {})
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


def coupled_joints(model: ModelLists) -> frozenset[str]:
    """Joints of active `<joint>` equalities, and those between the bodies that a `<connect>` or `<weld>` ties.

    Args:
        model: Compiled.
    """
    return frozenset(model.name("mjOBJ_JOINT", joint) for tied in _tied(model) for joint in tied)


def _tied(model: ModelLists) -> list[set[int]]:
    """The joints of each active equality; see `coupled_joints`."""
    import mujoco

    found = []
    for index, kind in enumerate(model.eq_type):
        one, other = model.eq_obj1id[index], model.eq_obj2id[index]
        if not model.eq_active0[index]:
            continue
        if _name(mujoco.mjtEq, kind) == "mjEQ_JOINT":
            found.append({end for end in (one, other) if end >= 0})
        elif _name(mujoco.mjtEq, kind) in ("mjEQ_CONNECT", "mjEQ_WELD"):
            if _name(mujoco.mjtObj, model.eq_objtype[index]) == "mjOBJ_SITE":
                one, other = model.site_bodyid[one], model.site_bodyid[other]
            found.append(_between(model, one, other))
    return found


def robot_mass(model: ModelLists) -> float | None:
    """Mass of the trees with a joint that an actuator moves, and of those that an equality ties to them [kg].

    Other trees are objects and furniture. Without actuators the only tree with a hinge or slide is the robot.

    Args:
        model: Compiled.

    Returns: None where nobody can tell which trees are the robot's.
    """
    import mujoco

    def trees(joints: Iterable[int]) -> set[int]:
        return {model.body_rootid[model.jnt_bodyid[joint]] for joint in joints}

    count = len(model.actuator_trntype)
    moved = [moved_joints(model, index, transmission(model, index)[0]) for index in range(count)]
    scalar = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
    if moved and None not in moved:
        robot = trees(joint for joints in moved for joint in joints or ())
    else:
        robot = trees(joint for joint, kind in enumerate(model.jnt_type) if moved or kind in scalar)
        if len(robot) > 1:
            return None
    tied = [trees(joints) for joints in _tied(model)]
    for _ in tied:
        robot.update(*(ends for ends in tied if ends & robot))
    return sum(mass for body, mass in enumerate(model.body_mass) if model.body_rootid[body] in robot) or None


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
        for name in _compared(type(owner)):  # type: ignore[arg-type]
            value = getattr(owner, name)
            if isinstance(value, (int, float, bytes, np.ndarray, np.generic)):
                yield prefix + name, value


@cache
def _compared(owner: type) -> tuple[str, ...]:
    """Attributes of a class of MuJoCo's that are compared; its methods are none."""
    return tuple(
        name
        for name in dir(owner)
        if not (name.startswith("_") or name in NOT_COMPARED or name.endswith("pathadr"))
        and not callable(getattr(owner, name))
    )


def unequal(first: Any, second: Any) -> str | None:
    """What differs between two values of a field, or None."""
    import numpy as np

    if second is None:
        return "only in one"
    if isinstance(first, bytes) or isinstance(second, bytes):
        return None if first == second else "differs"
    if np.array_equal(first, second):
        return None
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
