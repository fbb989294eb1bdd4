"""Limits and friction of Isaac Lab's actuators, by class and release: which setting each figure of a joint is.

Source: Isaac Lab 2.2.0 and 2.3.2, measured; 3.0, docs/source/concepts/actuators.rst.
"""

from __future__ import annotations

from collections.abc import Callable

from actspec.readings.artifact import ActuatorGroup, Framework
from actspec.readings.dict_keys import Found
from actspec.readings.versions import Versions, friction_unit_of, has_dynamic, limited_by_solver
from actspec.simulators.isaaclab import NEW_NAMES, OLD_NAMES, FrictionUnit
from actspec.units import format_quantity

CURVED = "UnitreeActuatorCfg"
"""Name of unitree_rl_lab's class."""

CURVE = ("X1", "X2", "Y1", "Y2")
"""Fields of unitree_rl_lab's class that are its whole limit: knee and end of the speed, torque driving and braking."""

FRICTIONS = {"frictionloss": "Fs", "joint_damping": "Fd"}
"""Its friction, by figure."""

BESIDE = "{}_beside"
"""Name of a figure that is not known and adds to another one: what the joint has beside a friction of its class."""


def take_limits(control: str, curved: bool, take: Callable[..., None], versions: Versions) -> None:
    """The limits by class, in the names of 2.x and 3.0.

    An implicit drive is clamped by the solver's limit, and its `velocity_limit` is ignored; an explicit
    one clamps in the model, without a limit of its own at the solver's in some releases, and one with a curve by that
    alone. `velocity_limit` of a DC motor is the no-load speed.
    """
    if control == "implicit":
        take("effort_limit", "effort_limit_sim", "joint_effort_limit", "effort_limit")
        take("velocity_limit", "velocity_limit_sim", "joint_velocity_limit")
        return
    solvers = ("effort_limit_sim",) if limited_by_solver(versions) else ()
    take("effort_limit", "effort_limit", "actuator_effort_limit", *solvers)
    take("velocity_limit", "velocity_limit_sim", "joint_velocity_limit")
    take("solver_effort_limit", "effort_limit_sim", "joint_effort_limit")
    if curved:
        return
    curve = control in ("dc_motor", "network")
    take("no_load_speed" if curve else "velocity_limit", "velocity_limit", "actuator_velocity_limit")


def settle_friction(values: dict[str, Found], versions: Versions) -> None:
    """Put the friction at the joint to what is written for it: `friction` is static where there is a sliding one."""
    first, second = values.get("friction_setting"), values.get("dynamic_friction_setting")
    written, unit = first or second, friction_unit_of(versions)
    viscous = values.get("joint_damping")
    if (
        viscous is not None
        and (viscous.value is not None or viscous.keys)
        and unit is not None
        and not unit.viscous
    ):
        unwritten = "this Isaac Lab never writes viscous_friction to the solver"
        values["joint_damping"] = Found(None, viscous.span, False, unwritten)
    if written is None:
        return
    why: str | None = None
    if unit is FrictionUnit.DEAD:
        why = "this Isaac Lab never writes friction to the solver"
    elif written.value == 0.0 and (second is None or second.value == 0.0):
        # Nothing in any unit.
        second = written
    elif unit is None or not unit.torque:
        factor = unit is not None and unit.coefficient
        means = "a factor on the joint's load" if factor else "its unit is not known"
        why = f"friction {written.value} is no torque: {means}"
    elif not has_dynamic(versions):
        second, first = first, None
    elif second is None:
        why = "the USD's own sliding friction"
    if why is not None:
        values["frictionloss"] = Found(None, written.span, False, why)
    elif second is not None:
        values["frictionloss"] = second
    if first is not None and unit is not None and unit.torque:
        values["friction_static"] = first


def has_curve(group: ActuatorGroup) -> bool:
    """Whether a class is unitree_rl_lab's `UnitreeActuator`, or made of it."""
    return CURVED in (group.cls, *group.bases) and "Y1" in group.settings


def take_curve(values: dict[str, Found], take: Callable[..., None]) -> None:
    """The figures of a class with an asymmetric torque-speed curve and a friction of its own.

    It clips by the curve alone, whatever `effort_limit` is, and takes its friction, Fs tanh(w / Va) + Fd w, off the
    result, beside the joint's own; the solver clips what is left. From X1 on it divides by X2 - X1: a knee above the
    end lets the torque rise.

    Source: unitree_rl_lab, assets/robots/unitree_actuators.py, `_clip_effort` and `compute`; twelve of thirteen copies
    of strangers are the same.
    """
    take("curve.drive_torque", "Y1")
    take("curve.brake_torque", "Y2", "Y1")
    take("curve.knee_speed", "X1")
    take("no_load_speed", "X2")
    values.pop("effort_limit", None)
    knee, end = (
        values[one].value if one in values else None for one in ("curve.knee_speed", "no_load_speed")
    )
    if knee is not None and end is not None and knee > end:
        at, last = (format_quantity(speed, "rad/s") for speed in (knee, end))
        why = f"X1, {at}, is not below X2, {last}: its class has its full torque at every speed"
        values["no_load_speed"] = Found(None, values["no_load_speed"].span, why=why)
    frictions = [*FRICTIONS.items()]
    if "friction_static" in values:
        frictions.append(("friction_static", FRICTIONS["frictionloss"]))
    for field, name in frictions:
        joints = values.pop(field, None)
        take(field, name)
        own = values.pop(field, None)
        if own is None or own.value == 0.0:
            total = joints
        elif own.value is None or joints is None:
            total = own
        elif joints.value is not None:
            total = Found(own.value + joints.value, own.span)
        else:
            # The solver's part is on top of it, as the USD's is where nothing is written.
            total, values[BESIDE.format(field)] = own, joints
        if total is not None:
            values[field] = total


def idle_speeds(framework: Framework, control: str) -> tuple[str, ...]:
    """Settings that act nowhere: the speed of an explicit Isaac Lab drive that has no torque-speed line.

    It only goes into `soft_joint_vel_limits`, which rewards read; the solver keeps its own. Source: Isaac Lab 2.2.0 and
    2.3.2, actuator_base.py (velocity_limit has velocity_limit_sim as default, not the other way round), actuator_pd.py
    (IdealPD clips by effort alone), articulation.py (writes velocity_limit_sim); 3.0,
    docs/source/concepts/actuators.rst: renamed alone.
    """
    explicit = framework is Framework.ISAACLAB and control not in ("implicit", "dc_motor", "network")
    return (OLD_NAMES.velocity, NEW_NAMES.velocity) if explicit else ()
