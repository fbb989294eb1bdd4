"""`unknown` in any field of a spec whose motor has a doubtful figure: told or not, it is no fault of actspec."""

from __future__ import annotations

import contextlib
import copy
import json
from collections.abc import Iterator
from typing import Any

import pytest

from actspec.diagnostics import ActspecError
from tests.fitting import fit
from tests.spec.plausible.test_bounds import said

LEG = (
    '<mujoco><worldbody><body><joint name="hip" axis="0 1 0" range="-1 1" actuatorfrcrange="-30 30"/>'
    '<geom type="sphere" size=".1" mass="1"/><body><joint name="calf" axis="0 1 0" actuatorfrcrange="-17 17"/>'
    '<geom size=".1" mass="1"/></body></body></worldbody></mujoco>'
)
LIFT = (
    '<mujoco><worldbody><body><joint name="lift" type="slide"/><geom size=".1"/></body></worldbody></mujoco>'
)
SHEET: dict[str, Any] = {
    "side": "joint",
    "gear_ratio": 6,
    "efficiency": 0.9,
    "stall_torque": "20 N*m",
    "peak_torque": "17 N*m",
    "continuous_torque": "6.9 N*m",
    "no_load_speed": "40 rad/s",
    "torque_constant": "0.6 N*m/A",
    "nominal_voltage": "24 V",
    "nominal_current": "11 A",
    "peak_current": "29 A",
    "rotor_inertia": "7.2e-5 kg*m^2",
    "bandwidth": "100 Hz",
}
CURVE = {
    "drive_torque": "20 N*m",
    "brake_torque": "23 N*m",
    "knee_speed": "12 rad/s",
    "no_load_speed": "40 rad/s",
}
STAGES = [{"ratio": 3, "efficiency": 0.9, "inertia": "1e-5 kg*m^2"}, {"teeth": {"driving": 20, "driven": 40}}]
GROUP: dict[str, Any] = {
    "joints": ["hip", "calf"],
    "motor": "m",
    "level": "ideal_pd",
    "kp": "40 N*m/rad",
    "kd": "1 N*m*s/rad",
    "effort_limit": "17 N*m",
    "velocity_limit": "40 rad/s",
    "armature": "0.0026 kg*m^2",
    "friction": {"coulomb": "0.1 N*m", "viscous": "0.01 N*m*s/rad", "static": "0.12 N*m"},
    "command_filter": {"cutoff": "30 Hz"},
    "delay": "4 ms",
    "encoder_bias": "0.01 rad",
    "action_scale": 0.25,
    "overrides": {
        "calf": {"reduction": 1.5, "kp": "60 N*m/rad", "effort_limit": "25 N*m", "velocity_limit": "26 rad/s"}
    },
    "randomize": {"kp": {"scale": [0.9, 1.1]}, "friction.coulomb": {"abs": ["0.05 N*m", "0.2 N*m"]}},
}


def _spec(motor: dict[str, Any], group: dict[str, Any], model: str | None) -> dict[str, Any]:
    joints = ["lift"] if "lift" in group["joints"] else ["hip", "calf"]
    kind = "slide" if joints == ["lift"] else "hinge"
    listed = {"model": "none", "joints": [{"name": name, "kind": kind} for name in joints]}
    return {
        "actspec": 1,
        "robot": {"name": "leg", **(listed if model is None else {"model": "leg.xml"})},
        "timing": {"physics_dt": "2 ms", "control_dt": "20 ms"},
        "motors": {"m": motor},
        "actuators": {"legs": group},
    }


def _without(figures: dict[str, Any], *fields: str, **other: Any) -> dict[str, Any]:
    return {key: value for key, value in figures.items() if key not in fields} | other


ROTOR = _without(
    SHEET,
    *("stall_torque", "peak_torque", "continuous_torque", "no_load_speed", "torque_constant"),
    side="motor",
    stall_torque="3.7 N*m",
    peak_torque="3.1 N*m",
    continuous_torque="1.3 N*m",
    no_load_speed="240 rad/s",
    torque_constant="0.1 N*m/A",
)
BELT = _without(GROUP, "overrides", transmission=[{"ratio": 1.5, "efficiency": 0.95}])
SCREW = {
    "joints": ["lift"],
    "motor": "m",
    "level": "ideal_pd",
    "transmission": [{"ratio": 2}, {"lead": "5 mm/rev", "efficiency": 0.8}],
    "kp": "50000 N/m",
    "kd": "900 N*s/m",
    "effort_limit": "20 kN",
    "velocity_limit": "15 mm/s",
    "armature": "16000 kg",
    "friction": {"coulomb": "50 N", "viscous": "100 N*s/m"},
}
DRIVES = {
    "line": (SHEET, GROUP, LEG),
    "curve": (_without(SHEET, "stall_torque", "no_load_speed", curve=CURVE), GROUP, LEG),
    "rotor": (ROTOR, GROUP, LEG),
    "stages": (_without(ROTOR, "gear_ratio", "efficiency", gearbox=STAGES), GROUP, LEG),
    "output": (_without(SHEET, "rotor_inertia", reflected_inertia="0.0026 kg*m^2"), GROUP, LEG),
    "belt": (SHEET, BELT, LEG),
    "pair": (SHEET, {**GROUP, "motors_per_joint": 2, "armature": "0.0052 kg*m^2"}, LEG),
    "screw": (ROTOR, SCREW, LIFT),
}
SLIPS = {
    "gear_ratio": 0.166,
    "stall_torque": "2 N*m",
    "peak_torque": "17000 N*m",
    "continuous_torque": "6900 N*m",
    "no_load_speed": "4000 rad/s",
    "torque_constant": "600 N*m/A",
    "nominal_voltage": "24000 V",
    "peak_current": "29000 A",
    "rotor_inertia": "720 kg*m^2",
    "reflected_inertia": "2600 kg*m^2",
    "side": "motor",
}
"""A doubtful figure of each kind."""


def _leaves(node: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Where numbers stand."""
    children = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else None
    if children is None:
        yield path
    else:
        for key, value in children:
            yield from _leaves(value, (*path, key))


def _with(spec: dict[str, Any], path: tuple[Any, ...], value: Any) -> dict[str, Any]:
    changed: Any = copy.deepcopy(spec)
    node = changed
    for key in path[:-1]:
        node = node[key]
    node[path[-1]] = value
    return changed


def _wrong(motor: dict[str, Any]) -> list[dict[str, Any]]:
    """The motor with each of its figures in doubt, one in each."""
    return [{**motor, slip: value} for slip, value in SLIPS.items() if slip in motor]


@pytest.mark.parametrize("drive", DRIVES)
def test_unknown_in_each_field(drive: str) -> None:
    motor, group, own = DRIVES[drive]
    slips = _wrong(motor)
    spec = _spec(motor, group, own)
    for index, path in enumerate(_leaves({"motors": spec["motors"], "actuators": spec["actuators"]})):
        # Every slip is beside several fields.
        unknown = _with(_spec(slips[index % len(slips)], group, own), path, "unknown")
        # What may not be unknown is told by others.
        with contextlib.suppress(ActspecError):
            fit(json.dumps(unknown), own)


@pytest.mark.parametrize("field", ["effort_limit", "velocity_limit"])
def test_a_doubt_beside_an_unknown_limit(field: str) -> None:
    """It is told as it is beside a limit that is known: 17000 mN*m are 17 N*m."""
    spec = _spec({**SHEET, "peak_torque": "17000 N*m"}, GROUP, None)
    for path in (("actuators", "legs", field), ("actuators", "legs", "overrides", "calf", field)):
        spec = _with(spec, path, "unknown")
    (found,) = said(json.dumps(spec))
    assert found.where == "motors.m.peak_torque"
    assert "17000 mN*m is 17 N*m" in (found.help or "")


@pytest.mark.parametrize("drive", DRIVES)
def test_the_sheets_are_sound(drive: str) -> None:
    motor, group, own = DRIVES[drive]
    assert said(json.dumps(_spec(motor, group, own)), own) == []
