"""Gears make and lose nothing: power and kinetic energy are the same on both sides, for any stages and linkages."""

from __future__ import annotations

import json
import math
from itertools import product

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from actspec.ir import JointActuator
from tests.fitting import drawn_numbers, fit, spec_of

ROUNDING = 1e-9
NUMBER = st.floats(min_value=0.05, max_value=20.0).map(lambda x: float(f"{x:.6g}"))


@st.composite
def trains(draw: st.DrawFn) -> tuple[list[str], list[float], bool]:
    """Stages from a turning shaft, their own input speed per output speed, and whether the end turns."""
    texts, ratios, turns = [], [], True
    for _ in range(draw(st.integers(1, 4))):
        a, b = draw(NUMBER), draw(NUMBER)
        kind = draw(st.sampled_from(["ratio", "planetary", "teeth", "convert"]))
        if kind == "ratio":
            texts.append(f"{{ratio: {a!r}}}")
            ratios.append(a)
        elif kind == "planetary":
            texts.append(f"{{planetary: {{sun: {a!r}, ring: {a + b!r}}}}}")
            ratios.append(1 + (a + b) / a)
        elif kind == "teeth":
            texts.append(f"{{teeth: {{driving: {a!r}, driven: {b!r}}}}}")
            ratios.append(b / a)
        elif turns:
            lead = draw(st.booleans())
            texts.append(f"{{lead: {a!r} mm/rev}}" if lead else f"{{radius: {a!r} mm}}")
            ratios.append(2 * math.pi / (a / 1000) if lead else 1 / (a / 1000))
            turns = False
        else:
            texts.append(f"{{{draw(st.sampled_from(['radius', 'lever_arm']))}: {a!r} mm}}")
            ratios.append(a / 1000)
            turns = True
    return texts, ratios, turns


@pytest.mark.slow
@settings(max_examples=30, deadline=None)
@given(
    train=trains(),
    split=st.integers(0, 4),
    torque=NUMBER,
    speed=NUMBER,
    inertias=st.lists(NUMBER, min_size=5),
)
def test_stages(
    train: tuple[list[str], list[float], bool], split: int, torque: float, speed: float, inertias: list[float]
) -> None:
    """Stall torque x no-load speed is that of the rotor, and so is the energy of rotor and stages, wherever the
    stages are stated: in the gearbox or in the transmission behind it."""
    texts, ratios, turns = train
    turning = [True]
    for text in texts:
        turning.append(turning[-1] is not any(word in text for word in ("lead", "radius", "lever_arm")))
    stages = [
        f"{text[:-1]}, inertia: {inertia!r} {'kg*m^2' if rotary else 'kg'}}}"
        for text, inertia, rotary in zip(texts, inertias[1:], turning[1:], strict=False)
    ]
    split = min(split, len(stages))
    gearbox = f"gearbox: [{', '.join(stages[:split])}]" if split else "gear_ratio: 1"
    transmission = f", transmission: [{', '.join(stages[split:])}]" if split < len(stages) else ""
    kind, rad = ("hinge", "N*m/rad") if turns else ("slide", "N/m")
    found = fit(
        spec_of(
            f"all: {{joints: [x], motor: m, level: dc_motor, kp: 1 {rad}, kd: 0{transmission}}}",
            robot=f"name: r, model: none, joints: [{{name: x, kind: {kind}}}]",
            motors=f"{{m: {{side: motor, stall_torque: {torque!r} N*m, no_load_speed: {speed!r} rad/s, "
            f"rotor_inertia: {inertias[0]!r} kg*m^2, {gearbox}}}}}",
            more=f"accept: {json.dumps(drawn_numbers())}",
        )
    ).joints[0]
    assert found.stall_torque is not None and found.no_load_speed is not None
    out = found.no_load_speed.require()
    assert found.stall_torque.require() * out == pytest.approx(torque * speed, rel=ROUNDING)
    # Speeds of all shafts, from the rotor on; each inertia moves with its own.
    speeds = [speed]
    for ratio in ratios:
        speeds.append(speeds[-1] / ratio)
    assert out == pytest.approx(speeds[-1], rel=ROUNDING)
    energy = sum(inertia * one * one for inertia, one in zip(inertias, speeds, strict=False))
    assert found.armature.require() * out * out == pytest.approx(energy, rel=ROUNDING)


ENTRY = st.floats(min_value=-2.0, max_value=2.0).map(lambda x: round(x, 3))


def linked(
    jacobian: list[list[float]], limits: list[float], inertias: list[float], mode: str
) -> list[JointActuator]:
    """The joints of a linkage with as many motors."""
    size = len(jacobian)
    names = [f"j{i}" for i in range(size)]
    motors = ", ".join(
        f"m{k}: {{side: joint, stall_torque: {limit!r}, no_load_speed: {limit!r} rad/s, "
        f"reflected_inertia: {inertia!r}}}"
        for k, (limit, inertia) in enumerate(zip(limits, inertias, strict=False))
    )
    text = spec_of(
        f"all: {{joints: [{', '.join(names)}], level: dc_motor, kp: 1, kd: 1}}",
        robot=f"name: r, model: none, joints: [{', '.join(names)}]",
        motors=f"{{{motors}}}",
        more=f"linkages: {{l: {{joints: [{', '.join(names)}], motors: [{', '.join(f'm{k}' for k in range(size))}], "
        f"jacobian: {jacobian!r}, limits: {mode}}}}}\naccept: {json.dumps(drawn_numbers())}",
    )
    return list(fit(text).joints)


@pytest.mark.slow
@settings(max_examples=30, deadline=None)
@given(
    data=st.data(),
    size=st.integers(1, 3),
    limits=st.lists(NUMBER, min_size=3, max_size=3),
    inertias=st.lists(NUMBER, min_size=3, max_size=3),
)
def test_linkages(data: st.DataObject, size: int, limits: list[float], inertias: list[float]) -> None:
    """Limits are on the edge of what the motors can give, alone and together; inertia has the motors' energy."""
    jacobian = [[data.draw(ENTRY) for _ in range(size)] for _ in range(size)]
    matrix = np.array(jacobian)
    assume(np.linalg.cond(matrix) < 1e3)
    motors = np.array(limits[:size])
    for mode in ("alone", "together"):
        joints = linked(jacobian, limits, inertias, mode)
        torques = np.array(
            [joint.stall_torque.require() for joint in joints if joint.stall_torque is not None]
        )
        speeds = np.array(
            [joint.no_load_speed.require() for joint in joints if joint.no_load_speed is not None]
        )
        corners = np.array(list(product((-1.0, 1.0), repeat=size) if mode == "together" else np.eye(size)))
        # Power J^T t_m . q' = t_m . J q' holds for any pair: solved here, not inverted.
        needed = [np.abs(np.linalg.solve(matrix.T, corner * torques)) / motors for corner in corners]
        turned = [np.abs(matrix @ (corner * speeds)) / motors for corner in corners]
        for used in (needed, turned):
            worst = np.max(used, axis=1)
            assert worst.max() == pytest.approx(1.0, rel=1e-6)
            if mode == "alone":
                assert worst == pytest.approx(np.ones(size), rel=1e-6)
    move = np.eye(size)
    energy = [np.sum(np.array(inertias[:size]) * (matrix @ one) ** 2) for one in move]
    assert [joint.armature.require() for joint in joints] == pytest.approx(energy, rel=ROUNDING)
