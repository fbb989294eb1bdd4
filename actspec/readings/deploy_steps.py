"""Steps and periods of a deploy file, and of what a step is that does not say it."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence

import yaml

from actspec.diagnostics import Collector
from actspec.readings.artifact import STEP_OF_WHAT, Setting
from actspec.readings.yaml_nodes import setting_of

TIMES = {
    "physics_dt": ("physics_dt", "simulation_dt", "sim_dt"),
    "control_dt": ("policy_dt", "control_dt", "step_dt"),
    "decimation": ("decimation", "control_decimation"),
}
"""Robot-wide setting to its keys, the first counts: beside `policy_dt` a `control_dt` is the loop of the drive."""

LEAST_PERIOD = 0.01
"""Least `dt` [s] that is the policy's where it is a file's only step. Chosen: policies run at up to 100 Hz, and loops
of drives at 200 Hz (rl_sar), 500 Hz (Unitree's SDKs) and more."""

_OF_TIME = re.compile(
    r"(?:^|_)(?:dt|decimation|period|rate|hz|freq(?:uency)?|time_?step)(?:_|$)", re.IGNORECASE
)
"""Keys beside which a `dt` is not the only step of a file."""


def nearest(scopes: Iterable[Mapping[str, yaml.Node]], keys: Sequence[str]) -> tuple[str, yaml.Node] | None:
    """The nearest of several keys, with its value; of one mapping the key that comes first among them."""
    return next(((key, scope[key]) for scope in scopes for key in keys if key in scope), None)


def steps_of(scopes: Sequence[Mapping[str, yaml.Node]], out: Collector) -> dict[str, Setting]:
    """The settings of `TIMES`; and `dt` with `dt_of`, which of them it is, where the keys beside it tell.

    Beside a decimation and no other step `dt` is the one that is counted: rl_sar, rl_sim.cpp and rl_real_a1.cpp, runs
    its policy every `dt * decimation`. Beside a shorter physics step and no other it is the policy's, and so it is
    alone, from `LEAST_PERIOD` on.

    Args:
        scopes: Mappings in which they may stand, the nearest first.
        out: Is told of a `dt` that may be any step.
    """
    found: dict[str, Setting] = {}
    for name, keys in TIMES.items():
        key = nearest(scopes, keys)
        setting = None if key is None else setting_of(key[1])
        if setting is not None:
            found[name] = setting
    key = nearest(scopes, ("dt",))
    dt = None if key is None else setting_of(key[1])
    if dt is None or dt.number is None:
        return found
    physics = found["physics_dt"].number if "physics_dt" in found else None
    others = {key for scope in scopes for key in scope if key != "dt" and _OF_TIME.search(key)}
    longer = physics is not None and others <= set(TIMES["physics_dt"]) and dt.number > physics
    of = None
    if "decimation" in found and others <= set(TIMES["decimation"]):
        of = "physics_dt"
    elif longer or (not others and dt.number >= LEAST_PERIOD):
        of = "control_dt"
    if of is not None:
        return {**found, "dt": dt, "dt_of": Setting(of, dt.span)}
    out.info(
        STEP_OF_WHAT,
        f"{dt.number:g} s is a step of the policy, of the physics or of the drives: the file does not say of which, "
        "so it is compared with no other file",
        where="dt",
        span=dt.span,
        help="call it control_dt where it is the time from one action to the next, or physics_dt",
    )
    return found
