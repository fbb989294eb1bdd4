"""Draws: the effective values of n randomised robots."""

from __future__ import annotations

import hashlib
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Collector, ResolveError
from actspec.ir import ActuatorSet, JointActuator, Level, Randomization
from actspec.sampling.ranges import (
    FACTORS,
    FIELDS,
    applied,
    check_ranges,
    nominal_of,
    own_ranges,
    quantity_of,
)

if TYPE_CHECKING:
    from actspec.sampling.ranges import Numbers


def sample(actuators: ActuatorSet, n: int, *, seed: int, xp: Any = None) -> dict[str, Any]:
    """Draw the effective values of every joint in n environments.

    A draw depends on the seed, the field and what shares it (the joint's name, the group's or nothing), never
    on which other joints or fields are drawn: adding a joint leaves the others' numbers. `per: env` is
    shared by all groups: with ranges of their own they take the same quantile (gaussians the same normal number).

    Args:
        actuators: What is drawn.
        n: Number of environments, >= 1.
        seed: >= 0; the same seed gives the same numbers with every `xp`.
        xp: `numpy` (default, float64) or `torch` (its default float type, on the CPU).

    Returns:
        Field to array of shape (n, joints), joints in `actuators.joints`' order, joint side, SI: `kp`, `kd`,
        `effort_limit` (infinite where unknown), `armature`, `friction.coulomb`, `friction.static`,
        `friction.viscous`, `encoder_bias` (added to q), `delay` [s] and `strength`, and
        `friction.stribeck_velocity` where a joint has one. `strength` is the factor on the torque: it is in kp,
        kd and effort_limit already, and is given for the stall torque of a torque-speed line and for a
        network's torque, which it multiplies too. A gain that the command leaves out is 0; what is unknown is
        NaN. Where static friction is not stated it is the kinetic one. A delay with a range of its own and
        `sampling: episode` is uniform in it, one draw a group.

    Raises:
        ValueError: n or seed is out of range.
        ResolveError: a range cannot be drawn from; see `check_ranges`.
    """
    import numpy as np

    if isinstance(n, bool) or not isinstance(n, int) or n < 1:
        raise ValueError(f"n must be a whole number >= 1, got {n!r}")
    if isinstance(seed, bool) or not isinstance(seed, int) or seed < 0:
        raise ValueError(f"seed must be a whole number >= 0, got {seed!r}")
    collector = Collector()
    check_ranges(actuators, collector)
    collector.raise_if_failed(ResolveError)

    columns = [_joint_values(actuator, n, seed) for actuator in actuators.joints]
    keys = [*FIELDS, "strength"]
    if not any("friction.stribeck_velocity" in column for column in columns):
        keys.remove("friction.stribeck_velocity")
    nothing = np.full(n, np.nan)
    arrays = {
        key: np.stack([column.get(key, nothing) for column in columns], axis=1)
        if columns
        else np.zeros((n, 0))
        for key in keys
    }
    if xp is None or xp.__name__ == "numpy":
        return arrays
    kind = {"dtype": xp.get_default_dtype()} if xp.__name__ == "torch" else {}
    return {key: xp.asarray(array, **kind) for key, array in arrays.items()}


def _joint_values(actuator: JointActuator, n: int, seed: int) -> dict[str, Numbers]:
    import numpy as np

    ranges = own_ranges(actuator)
    values: dict[str, Numbers] = {}
    for field in FIELDS:
        if field == "friction.stribeck_velocity" and actuator.stribeck_velocity is None:
            continue
        nominal = _effective_nominal(actuator, field)
        entry = ranges.get(field)
        if entry is not None and not (actuator.level is Level.ACTUATOR_NET and field in ("kp", "kd")):
            values[field] = applied(entry, _draw(entry, actuator, n, seed), nominal_of(actuator, field))
        else:
            values[field] = np.full(n, nominal)
    delay = actuator.delay
    if (
        "delay" not in ranges
        and delay is not None
        and delay.sampling == "episode"
        and delay.low != delay.high
    ):
        own = Randomization(
            "delay", "abs", delay.low, delay.high, "uniform", "reset", None, "group", actuator.span
        )
        values["delay"] = _draw(own, actuator, n, seed)
    if "friction.static" not in ranges and actuator.friction_static is None:
        values["friction.static"] = values["friction.coulomb"]
    values["strength"] = np.ones(n)
    for factor, parts in FACTORS.items():
        entry = ranges.get(factor)
        if entry is None:
            continue
        number = np.maximum(_draw(entry, actuator, n, seed), 0.0)
        for part in parts:
            values[part] = values[part] * number
        if factor == "strength":
            values[factor] = number
    for field in FIELDS:
        if field in values and field != "encoder_bias":
            values[field] = np.maximum(values[field], 0.0)
    # fmin: an unknown static friction bounds nothing.
    cut = np.fmin(values["friction.coulomb"], values["friction.static"])
    values["friction.coulomb"] = np.where(np.isnan(values["friction.coulomb"]), np.nan, cut)
    return values


def _effective_nominal(actuator: JointActuator, field: str) -> float:
    """A field's number without any draw: 0 for a gain that the command leaves out, NaN for what is unknown."""
    nominal = nominal_of(actuator, field)
    if nominal is not None:
        return nominal
    if (
        field in ("kp", "kd")
        and quantity_of(actuator, field) is None
        and actuator.level is not Level.ACTUATOR_NET
    ):
        return 0.0
    return float("inf") if field == "effort_limit" else float("nan")


def _draw(entry: Randomization, actuator: JointActuator, n: int, seed: int) -> Numbers:
    """n numbers of one range: factors, offsets or values."""
    import numpy as np

    scope = {"joint": actuator.joint, "group": actuator.group, "env": ""}[entry.per]
    digest = hashlib.sha256("\0".join((entry.field, entry.per, scope)).encode("utf-8")).digest()
    words = [int.from_bytes(digest[at : at + 4], "little") for at in range(0, 16, 4)]
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence([seed, *words])))
    if entry.distribution == "gaussian":
        return entry.low + entry.high * rng.standard_normal(n)
    quantile = rng.random(n)
    if entry.distribution == "log_uniform":
        low, high = np.log(entry.low), np.log(entry.high)
        return np.asarray(np.exp(low + (high - low) * quantile))
    return entry.low + (entry.high - entry.low) * quantile
