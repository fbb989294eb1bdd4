"""What of an actuator each target's files hold, and how two actuators are compared field by field."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

from actspec.ir import ActuatorSet, Command, Delay, JointActuator, Origin, Quantity
from actspec.targets.base import Approximation

EXACT = 1e-9
"""Relative."""
SINGLE = 1e-6
"""Relative: of numbers that a file keeps in single precision, and of what is made of a few."""

CANONICAL = 1e-5
"""Relative: MjSpec writes six digits."""


@dataclass(frozen=True)
class Held:
    """The files hold the field, unless an approximation of one of these fields says otherwise."""

    unless: tuple[str, ...] = ()


@dataclass(frozen=True)
class Lost:
    """The format has no place: an approximation of the field says so wherever a number is asked for."""

    told: str


@dataclass(frozen=True)
class Left:
    """The field is no business of the format, and nothing is said."""

    why: str


Entry = Held | Lost | Left

LINE = "torque_speed_curve"
VISCOUS = "friction.viscous"
POLICY = Left("the policy's, not an actuator's: the task's cfg and the deploy file have it")
TASK = Left("the task's cfg has it")
RANDOMIZED = Left("the randomization target writes it")
OF_THE_ROBOT = Left("the robot file's own; the target does not touch it")
REAL_MOTOR = Left("on the robot it is the motor itself that has it (see targets/deploy)")

HOLDS: dict[str, dict[str, Entry]] = {
    "mujoco": {
        "kind": Held(),
        "level": Held((LINE,)),
        "command": Held(),
        "kp": Held(),
        "kd": Held(),
        "effort_limit": Held((LINE,)),
        "velocity_limit": Lost("velocity_limit"),
        "stall_torque": Held((LINE,)),
        "no_load_speed": Held((LINE,)),
        "curve": Lost(LINE),
        "armature": Held(),
        "friction_coulomb": Held(),
        "friction_static": Lost("friction.static"),
        "friction_viscous": Held(),
        "stribeck_velocity": Lost("friction.stribeck_velocity"),
        "filter_cutoff": Held(("command_filter",)),
        "command_range": Held((LINE,)),
        "delay": Held(("delay",)),
        "delay_range": Lost("delay.range"),
        "delay_sampling": Lost("delay.range"),
        "encoder_bias": Held(("encoder_bias",)),
        "action_scale": POLICY,
        "default_position": POLICY,
        "position_range": OF_THE_ROBOT,
        "network": Lost("network"),
        "randomize": RANDOMIZED,
        "physics_dt": Held(),
        "decimation": TASK,
    },
    "urdf": {
        "kind": Held(),
        "level": Lost(LINE),
        "command": Left("kp and kd tell that there is no drive"),
        "kp": Lost("kp"),
        "kd": Lost("kd"),
        "effort_limit": Held(("effort_limit",)),
        "velocity_limit": Held(("velocity_limit",)),
        "stall_torque": Lost(LINE),
        "no_load_speed": Lost(LINE),
        "curve": Lost(LINE),
        "armature": Lost("armature"),
        "friction_coulomb": Held(),
        "friction_static": Lost("friction.static"),
        "friction_viscous": Held(),
        "stribeck_velocity": Lost("friction.stribeck_velocity"),
        "filter_cutoff": Lost("command_filter"),
        "command_range": Lost("command_range"),
        "delay": Lost("delay"),
        "delay_range": Lost("delay"),
        "delay_sampling": Lost("delay"),
        "encoder_bias": Lost("encoder_bias"),
        "action_scale": POLICY,
        "default_position": POLICY,
        "position_range": OF_THE_ROBOT,
        "network": Lost("network"),
        "randomize": RANDOMIZED,
        "physics_dt": Left("the format has no time step"),
        "decimation": TASK,
    },
    "isaaclab": {
        "kind": OF_THE_ROBOT,
        "level": Held((LINE,)),
        # A viscous friction that is summed into damping gives a torque drive a gain.
        "command": Held((VISCOUS,)),
        "kp": Held(),
        "kd": Held((VISCOUS,)),
        "effort_limit": Held((LINE,)),
        "velocity_limit": Held(),
        "stall_torque": Held((LINE,)),
        "no_load_speed": Held((LINE,)),
        "curve": Held((LINE,)),
        "armature": Held(),
        "friction_coulomb": Held(("friction.coulomb",)),
        "friction_static": Held(("friction.static", "friction.coulomb")),
        "friction_viscous": Held((VISCOUS,)),
        "stribeck_velocity": Lost("friction.stribeck_velocity"),
        "filter_cutoff": Held(("command_filter",)),
        "command_range": Held(("command_range",)),
        "delay": Held(("delay", "delay.range")),
        "delay_range": Held(("delay", "delay.range")),
        "delay_sampling": Held(("delay", "delay.sampling", "delay.range")),
        "encoder_bias": Held(("encoder_bias",)),
        "action_scale": POLICY,
        "default_position": POLICY,
        "position_range": OF_THE_ROBOT,
        "network": Held(),
        "randomize": RANDOMIZED,
        "physics_dt": TASK,
        "decimation": TASK,
    },
    "mjlab": {
        "kind": OF_THE_ROBOT,
        "level": Held(),
        "command": Held(),
        "kp": Held(),
        "kd": Held(),
        "effort_limit": Held((LINE,)),
        "velocity_limit": Lost("velocity_limit"),
        "stall_torque": Held((LINE,)),
        "no_load_speed": Held((LINE,)),
        "curve": Lost(LINE),
        "armature": Held(),
        "friction_coulomb": Held(),
        "friction_static": Lost("friction.static"),
        "friction_viscous": Held((VISCOUS,)),
        "stribeck_velocity": Lost("friction.stribeck_velocity"),
        "filter_cutoff": Lost("command_filter"),
        "command_range": Lost("command_range"),
        "delay": Held(("delay", "delay.range")),
        "delay_range": Held(("delay.range",)),
        "delay_sampling": Held(("delay.range",)),
        "encoder_bias": Lost("encoder_bias"),
        "action_scale": Held(),
        "default_position": Held(),
        "position_range": OF_THE_ROBOT,
        "network": Held(),
        "randomize": RANDOMIZED,
        "physics_dt": TASK,
        "decimation": TASK,
    },
    "deploy": {
        "kind": Left("units stand in comments"),
        "level": REAL_MOTOR,
        "command": Held(),
        "kp": Held(),
        "kd": Held(),
        "effort_limit": Held(),
        "velocity_limit": Held(),
        "stall_torque": REAL_MOTOR,
        "no_load_speed": REAL_MOTOR,
        "curve": REAL_MOTOR,
        "armature": REAL_MOTOR,
        "friction_coulomb": REAL_MOTOR,
        "friction_static": REAL_MOTOR,
        "friction_viscous": REAL_MOTOR,
        "stribeck_velocity": REAL_MOTOR,
        "filter_cutoff": REAL_MOTOR,
        "command_range": Held(),
        "delay": Held(),
        "delay_range": Held(),
        "delay_sampling": Left("the robot has the delay that it has"),
        "encoder_bias": Left("calibration of one robot (see targets/deploy)"),
        "action_scale": Held(),
        "default_position": Held(),
        "position_range": Held(),
        "network": REAL_MOTOR,
        "randomize": RANDOMIZED,
        "physics_dt": Held(),
        "decimation": Held(),
    },
    "newton": {
        "kind": Held(),
        "level": Held(),
        "command": Held(),
        "kp": Held(),
        "kd": Held(),
        "effort_limit": Held((LINE,)),
        "velocity_limit": Held(("velocity_limit",)),
        "stall_torque": Held((LINE,)),
        "no_load_speed": Held((LINE,)),
        "curve": Lost(LINE),
        "armature": Held(),
        "friction_coulomb": Held(),
        "friction_static": Lost("friction.static"),
        "friction_viscous": Held((VISCOUS,)),
        "stribeck_velocity": Lost("friction.stribeck_velocity"),
        "filter_cutoff": Lost("command_filter"),
        "command_range": Lost("command_range"),
        "delay": Held(("delay",)),
        "delay_range": Lost("delay.range"),
        "delay_sampling": Lost("delay.range"),
        "encoder_bias": Held(),
        "action_scale": POLICY,
        "default_position": POLICY,
        "position_range": OF_THE_ROBOT,
        "network": Held(),
        "randomize": RANDOMIZED,
        "physics_dt": TASK,
        "decimation": TASK,
    },
}
"""Target to field to whether its files hold it. A field that goes missing without an approximation fails."""

UNREAD = {
    "randomization": "ranges alone; tests/property/test_targets_property.py reads them",
}
"""Kinds of target that are not lifted, and why."""

NO_FIELDS = frozenset(
    {
        "joint", "group", "pattern", "motor", "span",
        # Information about the motor and the robot, which no target writes.
        "peak_torque", "continuous_torque", "reflected_inertia", "torque_constant", "inertia_held", "inertia_free",
        "motor_line", "gear",
    }
)  # fmt: skip
"""Fields of an actuator that a file is not asked for."""

OF_THE_SET = ("physics_dt", "decimation")


ZEROS = ("friction_coulomb", "friction_viscous")
"""Fields of which a 0 may be left out of a cfg that has no place for it: there is nothing to write."""


def values(actuators: ActuatorSet, actuator: JointActuator) -> dict[str, Any]:
    """Every field of `HOLDS` as a number, a text or a tuple; None where nobody says anything, or it does nothing."""
    delay = actuator.delay if actuator.delay is not None and _lasts(actuator) else None
    static = _number(actuator.friction_static)
    sticks = static is not None and static > (_number(actuator.friction_coulomb) or 0.0)
    ends = actuator.command_range
    curve = actuator.curve
    bias = _number(actuator.encoder_bias) if actuator.command is Command.POSITION else None
    line = curve is None
    return {
        "kind": actuator.kind.value,
        "level": actuator.level.value,
        "command": actuator.command.value,
        "kp": _number(actuator.kp),
        "kd": _number(actuator.kd),
        "effort_limit": _number(actuator.effort_limit),
        "velocity_limit": _number(actuator.velocity_limit),
        "stall_torque": _number(actuator.stall_torque) if line else None,
        "no_load_speed": _number(actuator.no_load_speed) if line else None,
        "curve": None
        if curve is None
        else tuple(
            q.value for q in (curve.drive_torque, curve.brake_torque, curve.knee_speed, curve.no_load_speed)
        ),
        "armature": _number(actuator.armature),
        "friction_coulomb": _number(actuator.friction_coulomb),
        "friction_static": static if sticks else None,
        "friction_viscous": _number(actuator.friction_viscous),
        "stribeck_velocity": _number(actuator.stribeck_velocity) if sticks else None,
        "filter_cutoff": _number(actuator.filter_cutoff),
        "command_range": None if ends is None or _is_idle(actuator) else (ends[0].value, ends[1].value),
        # A range that is drawn from has no nominal in a simulator.
        "delay": None if delay is None else _nominal(delay) or None,
        "delay_range": (delay.low, delay.high) if delay is not None and delay.low != delay.high else None,
        "delay_sampling": delay.sampling if delay is not None and delay.low != delay.high else None,
        "encoder_bias": bias or None,
        "action_scale": _number(actuator.action_scale),
        "default_position": _number(actuator.default_position),
        "position_range": actuator.position_range,
        "network": None if actuator.network is None else actuator.network.file,
        "randomize": actuator.randomize or None,
        "physics_dt": _number(actuators.physics_dt),
        "decimation": actuators.decimation,
    }


def _is_idle(actuator: JointActuator) -> bool:
    """Whether a clamp of a torque command only clamps what the effort limit clamps anyway."""
    ends, limit = actuator.command_range, actuator.effort_limit.value
    if ends is None or limit is None or actuator.command is not Command.EFFORT:
        return False
    return ends[0].require() <= -limit and ends[1].require() >= limit


def _lasts(actuator: JointActuator) -> bool:
    delay = actuator.delay
    return delay is not None and (delay.high > 0.0 or not delay.nominal.known)


def _nominal(delay: Delay) -> float | None:
    """The delay that is meant; ends that are one say what an unknown nominal does not."""
    known = delay.nominal.known or delay.low != delay.high
    return delay.nominal.value if known else delay.high


def _number(quantity: Quantity | None) -> float | None:
    return None if quantity is None else quantity.value


def _assumed(actuator: JointActuator) -> set[str]:
    """Fields whose number is a default that nobody wrote: a target need not write it either."""
    return {name for name, quantity in actuator.quantities() if quantity.origin is Origin.DEFAULT}


def close(one: Any, other: Any, tolerance: float) -> bool:
    """Whether two values are the same, numbers within a relative tolerance."""
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(close(a, b, tolerance) for a, b in zip(one, other, strict=True))
    if isinstance(one, (int, float)) and isinstance(other, (int, float)):
        return math.isclose(one, other, rel_tol=tolerance, abs_tol=1e-12)
    return bool(one == other)


def reduced(field: str, asked: Mapping[str, Any], told: set[str], step: float) -> list[Any]:
    """What a file may have in place of a field that the approximations `told` of a joint name."""
    curve, viscous = asked["curve"], asked["friction_viscous"] or 0.0
    found: list[Any] = [None]
    if field == "level":
        return ["ideal_pd"]
    if field == "command":
        return ["velocity"] if asked["command"] == "effort" and viscous else []
    if field == "kd":
        return [(asked["kd"] or 0.0) + viscous]
    if curve is not None and field in ("stall_torque", "no_load_speed", "effort_limit"):
        drive, _, knee, speed = curve
        line = {"stall_torque": drive / (1 - knee / speed), "no_load_speed": speed}
        found.append(line.get(field, min(drive, asked["effort_limit"])))
    if field == "command_range" and field not in told:
        # The drive's side of a curve may be a smaller limit than the clamp.
        low, high = asked["command_range"]
        least = None if curve is None else min(curve[0], asked["effort_limit"])
        return [None] if least is not None and low <= -least and high >= least else []
    if field in ("delay", "delay_range"):
        # To a whole step, by half of one at most; a range may become its rounded nominal, or nothing.
        found.append(("within", 0.5 * step + 1e-9))
    if field == "delay_sampling":
        found.append("episode")
    if field == "friction_coulomb":
        found.append(0.0)
    return found


def _clamped_limit(asked: Mapping[str, Any], got: Mapping[str, Any]) -> float | None:
    """What a torque command that is clamped further leaves of the effort limit, where the file has that clamp."""
    ends, limit = asked["command_range"], asked["effort_limit"]
    if asked["command"] != "effort" or ends is None or got["command_range"] != ends:
        return limit  # type: ignore[no-any-return]
    most = max(abs(end) for end in ends)
    return most if limit is None else min(limit, most)


def check(
    target: str,
    asked_of: ActuatorSet,
    lifted: ActuatorSet,
    losses: Iterable[Approximation],
    tolerance: float = EXACT,
) -> None:
    """Every field of every joint is in the files, or said to be lost and is what is left of it.

    Args:
        target: Of `HOLDS`.
        asked_of: What was compiled.
        lifted: What the files say.
        losses: The approximations of the emission.
        tolerance: Relative.
    """
    table = HOLDS[target]
    step = asked_of.physics_dt.require()
    lost: dict[str, set[str]] = {}
    for loss in losses:
        lost.setdefault(loss.joint, set()).add(loss.field)
    assert [a.joint for a in lifted.joints] == [a.joint for a in asked_of.joints]
    for actuator, found in zip(asked_of.joints, lifted.joints, strict=True):
        asked, got = values(asked_of, actuator), values(lifted, found)
        for field, entry in table.items():
            where = (
                target,
                actuator.joint,
                field,
                asked[field],
                got[field],
                sorted(lost.get(actuator.joint, ())),
            )
            want, have = asked[field], got[field]
            if isinstance(entry, Left):
                continue
            if field in _assumed(actuator) and not close(want, have, tolerance):
                assert have is None, where
                continue
            if field in ZEROS and want == 0.0 and have is None and target == "isaaclab":
                continue
            if field in ("delay",) and asked["delay_range"] is not None and target in ("isaaclab", "mjlab"):
                # Drawn from the range: the nominal says nothing; without the range it is held to it.
                want = None if have is None else want
            told = lost.get(actuator.joint, set())
            if field == "effort_limit" and close(_clamped_limit(asked, got), have, tolerance):
                continue
            if want is None:
                assert have is None or _follows(field, asked, have, told, step, tolerance), where
            elif isinstance(entry, Lost):
                assert entry.told in told or (field == "level" and want == "ideal_pd"), where
                assert have is None or field == "level", where
            elif not close(want, have, tolerance):
                assert told & set(entry.unless), where
                assert any(_is(one, want, have, tolerance) for one in reduced(field, asked, told, step)), (
                    where
                )


def _follows(
    field: str, asked: Mapping[str, Any], have: Any, told: set[str], step: float, tolerance: float
) -> bool:
    """Whether a number that nobody asked for is what is left of another field."""
    if field in ("stall_torque", "no_load_speed") and asked["curve"] is not None and LINE in told:
        return any(
            _is(one, None, have, tolerance) for one in reduced(field, asked, told, step) if one is not None
        )
    if field == "kd" and VISCOUS in told:
        return close(have, asked["friction_viscous"], tolerance)
    if field == "delay" and "delay.range" in told:
        return bool(have > 0.0)
    return False


def _is(allowed: Any, want: Any, have: Any, tolerance: float) -> bool:
    if isinstance(allowed, tuple) and allowed and allowed[0] == "within":
        pairs = zip(want, have, strict=True) if isinstance(want, tuple) and have else [(want, have)]
        return all(b is not None and abs(a - b) <= allowed[1] for a, b in pairs)
    return close(allowed, have, tolerance)
