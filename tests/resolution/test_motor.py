"""Datasheet figures at the joint, against arithmetic done by hand."""

from __future__ import annotations

import pytest

from actspec.ir import Origin
from tests.fitting import joint, refused, spec_of

# One motor whose factors are all different: gear 9, efficiency 0.8, reduction 1.5, two in parallel.
GROUP = "legs: {joints: [hip], motor: m, level: dc_motor, kp: 25, kd: 0.5%s}, rest: {joints: [calf, slide], "
GROUP += "level: ideal_pd, kp: 1, kd: 1}"
FIGURES = (
    "stall_torque: 2 N*m, no_load_speed: 180 rad/s, peak_torque: 1.5 N*m, continuous_torque: 0.5 N*m, "
    "gear_ratio: 9, efficiency: 0.8, rotor_inertia: 1e-4 kg*m^2"
)


def motor(side: str, figures: str = FIGURES, extra: str = ", reduction: 1.5, motors_per_joint: 2") -> str:
    """A spec with one motor on one joint."""
    return spec_of(GROUP % extra, motors=f"{{m: {{side: {side}, {figures}}}}}")


def test_motor_side() -> None:
    """Torque x N x efficiency x r x motors, speed / N / r, rotor inertia x N^2 x r^2 x motors."""
    found = joint(motor("motor"))
    assert found.stall_torque is not None and found.no_load_speed is not None
    assert found.stall_torque.value == pytest.approx(43.2)  # 2 x 9 x 0.8 x 1.5 x 2
    assert found.no_load_speed.value == pytest.approx(180 / 13.5)  # 180 / 9 / 1.5; the motors do not add up
    assert found.peak_torque.value == pytest.approx(32.4)  # 1.5 x 21.6
    assert found.continuous_torque.value == pytest.approx(10.8)  # 0.5 x 21.6
    assert found.reflected_inertia.value == pytest.approx(0.03645)  # 1e-4 x 81 x 2.25 x 2, no efficiency
    assert found.armature.value == pytest.approx(0.03645)
    assert found.armature.origin is Origin.DERIVED
    assert found.armature.formula == (
        "0.0001 kg*m^2 x 81 (gear_ratio^2) x 2.25 (reduction^2) x 2 (motors_per_joint)"
    )
    assert found.stall_torque.formula == (
        "2 N*m x 9 (gear_ratio) x 0.8 (efficiency) x 1.5 (reduction) x 2 (motors_per_joint)"
    )
    assert found.no_load_speed.formula == "180 rad/s / 9 (gear_ratio) / 1.5 (reduction)"


def test_joint_side() -> None:
    """Figures at the output take reduction and motors alone; the rotor inertia is at the rotor still."""
    found = joint(motor("joint"))
    assert found.stall_torque is not None and found.no_load_speed is not None
    assert found.stall_torque.value == pytest.approx(6.0)  # 2 x 1.5 x 2
    assert found.no_load_speed.value == pytest.approx(120.0)  # 180 / 1.5
    assert found.peak_torque.value == pytest.approx(4.5)
    assert found.reflected_inertia.value == pytest.approx(0.03645)


def test_without_reduction_a_joint_side_figure_stays_authored() -> None:
    """What is used as written keeps its origin, and has no formula."""
    found = joint(motor("joint", extra=""))
    assert found.stall_torque is not None
    assert (found.stall_torque.value, found.stall_torque.origin, found.stall_torque.formula) == (
        2.0,
        Origin.AUTHORED,
        None,
    )


def test_reflected_inertia_is_at_the_output() -> None:
    """It takes r^2 and the motors, not the gear."""
    found = joint(
        motor("joint", "stall_torque: 2, no_load_speed: 9 rad/s, gear_ratio: 9, reflected_inertia: 0.01")
    )
    assert found.armature.value == pytest.approx(0.045)  # 0.01 x 2.25 x 2


def test_default_efficiency_is_said() -> None:
    """An efficiency that nobody states is 1, and the formula says who chose it."""
    found = joint(motor("motor", "stall_torque: 2, no_load_speed: 180 rad/s, gear_ratio: 9", ""))
    assert found.stall_torque is not None
    assert found.stall_torque.value == 18.0
    assert found.stall_torque.formula == "2 N*m x 9 (gear_ratio) x 1 (efficiency, default)"


@pytest.mark.parametrize(
    ("side", "torque"),
    [pytest.param("joint", 6.0, id="output"), pytest.param("motor", 43.2, id="rotor")],
)
def test_torque_from_currents(side: str, torque: float) -> None:
    """Torque constant x current, on the motor's side: 0.1 x 20 = 2, then x 3 or x 21.6."""
    figures = (
        "stall_torque: 9 N*m, no_load_speed: 180 rad/s, torque_constant: 0.1 N*m/A, nominal_current: 20 A, "
        "peak_current: 50 A, gear_ratio: 9, efficiency: 0.8"
    )
    found = joint(motor(side, figures))
    assert found.continuous_torque.value == pytest.approx(torque)
    assert found.peak_torque.value == pytest.approx(2.5 * torque)
    assert found.continuous_torque.formula is not None
    assert found.continuous_torque.formula.startswith(
        "0.1 N*m/A (torque_constant) x 20 A (nominal_current) x "
    )
    assert found.effort_limit.value == pytest.approx(torque)


def test_unknown_torque_is_not_replaced_by_currents() -> None:
    """`unknown` says that nobody knows it, also where constants would give a number."""
    figures = (
        "stall_torque: 9 N*m, no_load_speed: 180 rad/s, continuous_torque: unknown, torque_constant: 0.1, "
        "nominal_current: 20"
    )
    assert joint(motor("joint", figures)).continuous_torque.value is None


def test_curve() -> None:
    """An asymmetric curve is brought to the joint figure by figure."""
    curve = (
        "curve: {drive_torque: 2 N*m, brake_torque: 3 N*m, knee_speed: 90 rad/s, no_load_speed: 180 rad/s}"
    )
    found = joint(motor("motor", f"{curve}, gear_ratio: 9, efficiency: 0.8"))
    assert found.curve is not None
    assert found.curve.drive_torque.value == pytest.approx(43.2)
    assert found.curve.brake_torque.value == pytest.approx(64.8)
    assert found.curve.knee_speed.value == pytest.approx(90 / 13.5)
    assert found.curve.no_load_speed.value == pytest.approx(180 / 13.5)
    assert found.stall_torque is None
    # Nothing else is stated, so the drive's torque is the limit.
    assert found.effort_limit.value == pytest.approx(43.2)


LIMITS = "side: joint, peak_torque: {value: 30 N*m, note: short}, continuous_torque: %s, stall_torque: 50 N*m"


@pytest.mark.parametrize(
    ("continuous", "extra", "value", "note"),
    [
        pytest.param(
            "12 N*m",
            "",
            12.0,
            "continuous 12 N*m, peak 30 N*m",
            id="continuous",
        ),
        pytest.param("unknown", "", 30.0, "continuous unknown, peak 30 N*m; short", id="peak"),
        pytest.param("12 N*m", ", effort_limit: peak", 30.0, "short", id="peak asked for"),
        pytest.param("12 N*m", ", effort_limit: continuous", 12.0, None, id="continuous asked for"),
        pytest.param("12 N*m", ", effort_limit: 20 N*m", 20.0, None, id="authored"),
        pytest.param("12 N*m", ", effort_limit: unknown", None, None, id="unknown"),
    ],
)
def test_effort_limit(continuous: str, extra: str, value: float | None, note: str | None) -> None:
    """Default: continuous if known, else peak, with a note that names both figures."""
    text = spec_of(
        f'legs: {{joints: [".*"], motor: m, level: ideal_pd, kp: 1, kd: 1{extra}}}',
        robot="name: leg, model: none, joints: [hip]",
        motors=f"{{m: {{{LIMITS % continuous}}}}}",
    )
    found = joint(text).effort_limit
    assert (found.value, found.note) == (value, note)


def test_a_rotary_motor_on_a_slide_is_refused() -> None:
    """Every figure that is in the other unit is told, each at its place."""
    text = spec_of(
        "legs: {joints: [slide], motor: m, level: ideal_pd, kp: 1, kd: 1}",
        robot="name: leg, model: none, joints: [{name: slide, kind: slide}]",
        motors="{m: {side: joint, peak_torque: 20 N*m, no_load_speed: 2 m/s, stall_torque: 30 N*m}}",
    )
    assert [line.split(":")[0] for line in refused(text)] == [
        "RES001 motors.m.peak_torque",
        "RES001 motors.m.stall_torque",
    ]


def test_a_linear_motor_on_a_slide() -> None:
    """A slide takes N, m/s and kg, and its quantities say so."""
    text = spec_of(
        "legs: {joints: [slide], motor: m, level: dc_motor, kp: 1000 N/m, kd: 10 N*s/m, reduction: 2}",
        robot="name: leg, model: none, joints: [{name: slide, kind: slide}]",
        motors="{m: {side: joint, stall_torque: 200 N, no_load_speed: 2 m/s, reflected_inertia: 0.5 kg}}",
    )
    found = joint(text, "slide")
    assert found.stall_torque is not None and found.no_load_speed is not None
    assert (found.stall_torque.value, found.stall_torque.unit) == (400.0, "N")
    assert (found.no_load_speed.value, found.no_load_speed.unit) == (1.0, "m/s")
    assert (found.armature.value, found.armature.unit) == (2.0, "kg")
    assert found.kp is not None and found.kp.unit == "N/m"


def test_a_force_constant_of_a_slide() -> None:
    """40 N/A x 12 A = 480 N, 40 N/A x 2.75 A = 110 N; with a number alone likewise."""
    for constant in ("40 N/A", "40"):
        figures = f"side: joint, torque_constant: {constant}, peak_current: 12 A, nominal_current: 2.75 A"
        found = joint(
            spec_of(
                "legs: {joints: [slide], motor: m, level: ideal_pd, kp: 1, kd: 1}",
                robot="name: leg, model: none, joints: [{name: slide, kind: slide}]",
                motors=f"{{m: {{{figures}}}}}",
            ),
            "slide",
        )
        assert (found.peak_torque.value, found.peak_torque.unit) == (480.0, "N")
        assert found.peak_torque.formula == "40 N/A (torque_constant) x 12 A (peak_current)"
        assert found.continuous_torque.value == 110.0


def test_a_force_constant_of_a_hinge_is_refused() -> None:
    """N/A of what turns needs a radius, too."""
    text = motor("motor", f"{FIGURES}, torque_constant: 40 N/A")
    assert [line.split(":")[0] for line in refused(text)] == ["RES001 motors.m.torque_constant"]


def test_a_torque_constant_on_a_slide_is_refused() -> None:
    """Torque per current gives no force: N*m/A needs the radius that nobody states."""
    text = spec_of(
        "legs: {joints: [slide], motor: m, level: ideal_pd, kp: 1, kd: 1}",
        robot="name: leg, model: none, joints: [{name: slide, kind: slide}]",
        motors="{m: {side: joint, torque_constant: 0.1 N*m/A, nominal_current: 20 A}}",
    )
    assert [line.split(":")[0] for line in refused(text)] == ["RES001 motors.m.torque_constant"]
