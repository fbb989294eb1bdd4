"""Resolve: what must hold for every spec and robot."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from itertools import combinations
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from actspec.ir import JointActuator, Origin, Quantity
from tests.fitting import drawn_numbers, fit, joint, spec_of

NAMES = ("hip_left", "hip_right", "calf_left", "calf_right", "toe")
POSITIVE = st.floats(min_value=1e-3, max_value=1e3)
FACTOR = st.floats(min_value=0.1, max_value=50.0)

# Products are rounded to 12 digits, and the two sides multiply in different orders.
ROUNDING = 1e-11


def plain(value: Any) -> Any:
    """An actuator as plain data, without places in the file, which move with the order of its lines."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items() if key != "span"}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    return value


@st.composite
def partitions(draw: st.DrawFn) -> list[list[str]]:
    """The joints in groups, both in any order."""
    names = draw(st.permutations(NAMES))
    cuts = sorted(draw(st.sets(st.integers(1, len(NAMES) - 1), max_size=3)))
    return [names[a:b] for a, b in zip([0, *cuts], [*cuts, len(NAMES)], strict=True)]


@st.composite
def shuffled(draw: st.DrawFn, groups: list[list[str]]) -> list[list[str]]:
    """The same groups and members in another order."""
    return [draw(st.permutations(group)) for group in draw(st.permutations(groups))]


def text_of(groups: list[list[str]], robot: list[str] | tuple[str, ...] = NAMES) -> str:
    """A spec whose groups differ by their first joint in the alphabet, and name joints one by one."""
    entries = []
    for group in groups:
        number = NAMES.index(min(group)) + 1
        entries.append(
            f"g{number}: {{joints: [{', '.join(group)}], level: dc_motor, motor: m, reduction: {number}, "
            f"kp: {{derive: natural_frequency, frequency: {number} Hz, inertia: reflected}}, kd: 0.{number}, "
            f"overrides: {{{min(group)}: {{armature: 0.0{number}}}}}, randomize: {{kp: {{scale: [0.5, {number}]}}}}}}"
        )
    return spec_of(
        ", ".join(entries),
        robot=f"name: leg, model: none, joints: [{', '.join(robot)}], default_pose: {{'.*_left': 1 rad}}",
        motors="{m: {side: motor, gear_ratio: 9, efficiency: 0.9, stall_torque: 2, no_load_speed: 90 rad/s, "
        "rotor_inertia: 1e-4}}",
    )


@pytest.mark.slow
@given(data=st.data(), groups=partitions())
@settings(deadline=None, max_examples=40)
def test_the_order_of_the_spec_does_not_matter(data: st.DataObject, groups: list[list[str]]) -> None:
    """Groups and joints in another order give the same actuators, in the robot's order."""
    first = fit(text_of(groups))
    second = fit(text_of(data.draw(shuffled(groups))))
    assert [actuator.joint for actuator in first.joints] == list(NAMES)
    assert [plain(asdict(a)) for a in first.joints] == [
        plain(asdict(replace(b, pattern=a.pattern))) for a, b in zip(first.joints, second.joints, strict=True)
    ]


@pytest.mark.slow
@given(robot=st.permutations(NAMES), groups=partitions())
@settings(deadline=None, max_examples=20)
def test_the_order_of_the_robot_orders_the_actuators(robot: list[str], groups: list[list[str]]) -> None:
    """Joints in another order in the robot give the same actuators in that order."""
    first, second = fit(text_of(groups)), fit(text_of(groups, robot))
    assert [actuator.joint for actuator in second.joints] == robot
    for actuator in first.joints:
        other = second.joint(actuator.joint)
        assert other is not None
        assert plain(asdict(actuator)) == plain(asdict(other))


MODEL = """<mujoco><worldbody><body><joint name="hip" axis="0 1 0" %s/><geom size="0.1" mass="1"/></body>
</worldbody></mujoco>"""
RANKS = (Origin.AUTHORED, Origin.IDENTIFIED, Origin.DERIVED, Origin.MODEL)


NUMBERS = dict(zip(RANKS, (0.02, 0.7, 3.0, 0.5), strict=True))
"""In no order, so that none wins by its size."""
CASES = [
    (set(some), unknown)
    for count in range(len(RANKS) + 1)
    for some in combinations(RANKS, count)
    for unknown in sorted({False, Origin.AUTHORED in some})
]


@pytest.mark.parametrize(("present", "unknown"), CASES)
def test_precedence(present: set[Origin], unknown: bool) -> None:
    """Of every set of sources of an armature the strongest wins, the others are kept in order; `unknown` stops it."""
    number = NUMBERS
    fields = ""
    derived = f"reflected_inertia: {number[Origin.DERIVED]!r}" if Origin.DERIVED in present else ""
    motors = f"{{m: {{{derived}}}}}"
    if Origin.AUTHORED in present:
        fields = f", armature: {'unknown' if unknown else repr(number[Origin.AUTHORED])}"
    identified = Origin.IDENTIFIED in present
    text = spec_of(
        f"legs: {{joints: [hip], motor: m, level: ideal_pd, kp: 1, kd: 1{fields}"
        f"{', identified: r.yaml' if identified else ''}}}",
        robot="name: leg, model: robot.xml",
        motors=motors,
    )
    found = joint(
        text,
        model=MODEL % (f'armature="{number[Origin.MODEL]!r}"' if Origin.MODEL in present else ""),
        results=f"{{hip: {{armature: {number[Origin.IDENTIFIED]!r}}}}}" if identified else None,
    ).armature
    told = [(origin, number[origin]) for origin in RANKS if origin in present]
    if Origin.MODEL not in present:
        told.append((Origin.DEFAULT, 0.0))
    if unknown:
        told[0] = (Origin.UNKNOWN, None)  # type: ignore[assignment]
    assert [(q.origin, q.value) for q in (found, *found.lost)] == [
        (origin, value if value is None else pytest.approx(value, rel=1e-5)) for origin, value in told
    ]


def figures(actuator: JointActuator) -> dict[str, float | None]:
    """The motor's part of an actuator."""
    quantities: dict[str, Quantity | None] = {
        "stall_torque": actuator.stall_torque,
        "no_load_speed": actuator.no_load_speed,
        "peak_torque": actuator.peak_torque,
        "continuous_torque": actuator.continuous_torque,
        "effort_limit": actuator.effort_limit,
        "reflected_inertia": actuator.reflected_inertia,
        "armature": actuator.armature,
    }
    return {name: None if q is None else q.value for name, q in quantities.items()}


@pytest.mark.slow
@given(
    gear=FACTOR,
    efficiency=st.floats(min_value=0.1, max_value=1.0),
    reduction=st.floats(min_value=0.2, max_value=5.0),
    motors=st.integers(1, 4),
    stall=POSITIVE,
    speed=POSITIVE,
    constant=POSITIVE,
    current=POSITIVE,
    inertia=POSITIVE,
)
@settings(deadline=None, max_examples=16)
def test_sides(
    gear: float,
    efficiency: float,
    reduction: float,
    motors: int,
    stall: float,
    speed: float,
    constant: float,
    current: float,
    inertia: float,
) -> None:
    """Figures moved by hand from the rotor to the output give the same actuator."""

    def of(motor: str) -> dict[str, float | None]:
        return figures(
            joint(
                spec_of(
                    f"legs: {{joints: [hip], motor: m, level: dc_motor, kp: 1, kd: 1, reduction: {reduction!r}, "
                    f"motors_per_joint: {motors}}}",
                    robot="name: leg, model: none, joints: [hip]",
                    motors=f"{{m: {{{motor}}}}}",
                    more=f"accept: {json.dumps(drawn_numbers())}",
                )
            )
        )

    up = gear * efficiency
    at_rotor = of(
        f"side: motor, gear_ratio: {gear!r}, efficiency: {efficiency!r}, stall_torque: {stall!r}, "
        f"no_load_speed: {speed!r} rad/s, torque_constant: {constant!r}, nominal_current: {current!r}, "
        f"peak_current: {3 * current!r}, rotor_inertia: {inertia!r}"
    )
    at_output = of(
        f"side: joint, stall_torque: {stall * up!r}, no_load_speed: {speed / gear!r} rad/s, "
        f"torque_constant: {constant * up!r}, nominal_current: {current!r}, peak_current: {3 * current!r}, "
        f"reflected_inertia: {inertia * gear * gear!r}"
    )
    assert at_rotor == pytest.approx(at_output, rel=ROUNDING)
    # The joint itself: torque x r x motors, speed / r, inertia x r^2 x motors.
    assert at_rotor["stall_torque"] == pytest.approx(stall * up * reduction * motors, rel=ROUNDING)
    assert at_rotor["no_load_speed"] == pytest.approx(speed / gear / reduction, rel=ROUNDING)
    assert at_rotor["armature"] == pytest.approx(inertia * gear**2 * reduction**2 * motors, rel=ROUNDING)
    assert at_rotor["effort_limit"] == pytest.approx(
        constant * current * up * reduction * motors, rel=ROUNDING
    )
