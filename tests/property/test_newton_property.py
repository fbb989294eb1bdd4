"""The Newton target: every number of any spec is in the overlay in its prim's own unit, or a loss names it."""

from __future__ import annotations

import math
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.property.targets_oracle import (
    Drive,
    Oracle,
    compiled,
    dc,
    off,
    one_line,
    path_losses,
    robots,
    sizes_of,
    steps,
    stuck,
)
from tests.property.test_targets_property import agree, held
from tests.targets.newton.emitting import parsed


def joint_numbers(drive: Drive, old: bool) -> dict[str, float | None]:
    """What a joint's own prim has, a hinge's per degree and in degrees."""
    degree = 1.0 if drive.slide else math.pi / 180.0
    axis = "linear" if drive.slide else "angular"
    viscous, fastest = drive.viscous, drive.velocity_limit
    return {
        f"drive:{axis}:physics:stiffness": 0.0,
        f"drive:{axis}:physics:damping": 0.0,
        f"drive:{axis}:physics:maxForce": drive.limit,
        "newton:armature": drive.armature,
        "newton:friction": drive.coulomb,
        "newton:damping": None if viscous is None or old else viscous * degree,
        "newton:velocityLimit": None if fastest is None or old else fastest / degree,
    }


def actuator_numbers(drive: Drive) -> dict[str, float | None]:
    """What a NewtonActuator has, in radians."""
    line = one_line(drive) if drive.line or drive.curve else None
    nominal = None
    if drive.delay is not None:
        nominal, low, high, _ = drive.delay
        nominal = high if low == high else nominal
    bias = drive.bias if drive.command == "position" else None
    return {
        "newton:kp": drive.kp if drive.command == "position" else 0.0,
        "newton:kd": 0.0 if drive.command == "effort" else drive.kd,
        "newton:constEffort": -drive.kp * bias if bias else None,
        "newton:maxEffort": drive.limit if line is None else None,
        "newton:saturationEffort": line and line[0],
        "newton:velocityLimit": line and line[1],
        "newton:maxMotorEffort": line and line[2],
        "newton:delaySteps": (steps(nominal) or None) if nominal else None,
    }


def losses(drive: Drive, old: bool) -> dict[str, float | None]:
    """What the overlay loses, and how much that is."""
    o = Oracle(drive)
    want = path_losses(drive, o, whole=False)
    # A constant torque stands for it.
    want.pop("encoder_bias", None)
    if drive.curve:
        want["torque_speed_curve"] = o.against(dc(o.tau, o.w, *one_line(drive)))
    if stuck(drive):
        want["friction.static"] = (drive.static or 0.0) - (drive.coulomb or 0.0)
        if drive.stribeck is not None:
            want["friction.stribeck_velocity"] = want["friction.static"]
    if drive.velocity_limit is not None:
        want["velocity_limit"] = None
    if old and drive.viscous is not None:
        want["friction.viscous"] = None if o.wide is None else drive.viscous * o.wide
    if drive.delay is not None and drive.delay[2] > 0:
        nominal, low, high, _ = drive.delay
        if low != high:
            want["delay.range"] = o.half
        nominal = high if low == high else nominal
        if nominal is not None and off(nominal) > 1e-9:
            want["delay"] = o.half
    return want


@pytest.mark.slow
@given(groups=robots(), version=st.sampled_from(["1.2", "1.3", "1.4", "1.8"]))
@settings(deadline=None, max_examples=60)
def test_newton_says_or_names_every_number(groups: list[Drive], version: str) -> None:
    """Each field of each joint is on its prim or its actuator, or lost at the size that it has."""
    names = [name for drive in groups for name in drive.joints]
    paths = {name: f"joints/j{k}" for k, name in enumerate(names)}
    emission = compiled(
        groups,
        kind="newton",
        version=version,
        root="/World/bot",
        joint_paths={re.escape(name): path for name, path in paths.items()},
    )
    prims = parsed(emission.files[0].data.decode())
    actuators = {
        p["newton:targets"].strip("<>"): p for p in prims.values() if p["is"] == "def NewtonActuator"
    }
    assert len(actuators) == len(names)
    lost = sizes_of(emission.approximations)
    old = version < "1.4"
    for drive in groups:
        for joint in drive.joints:
            path = f"/World/bot/{paths[joint]}"
            held(prims[path], joint_numbers(drive, old), (joint, drive))
            held(actuators[path], actuator_numbers(drive), (joint, drive))
            agree(joint, lost.get(joint, {}), losses(drive, old), drive)
