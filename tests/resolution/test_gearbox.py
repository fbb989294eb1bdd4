"""Stages of gearboxes and transmissions, against arithmetic done by hand."""

from __future__ import annotations

import math

import pytest

from actspec.ir import JointActuator, Origin
from tests.fitting import fit, joint, refused, spec_of

SLIDE = "name: lift, model: none, joints: [{name: lift, kind: slide}]"
HINGE = "name: leg, model: none, joints: [hip]"


def one(motor: str, group: str = "", *, robot: str = HINGE) -> JointActuator:
    """The one joint of a robot behind a motor `m`."""
    gains = "kp: 1 N/m, kd: 1 N*s/m" if robot == SLIDE else "kp: 1, kd: 1"
    name = "lift" if robot == SLIDE else "hip"
    text = spec_of(
        f"all: {{joints: [{name}], motor: m, level: dc_motor, {gains}{group}}}",
        robot=robot,
        motors=f"{{m: {{{motor}}}}}",
    )
    return joint(text, name)


# The three sizes differ, and so do both ratios: a stage taken at the wrong shaft gives another sum.
G1 = (
    "rotor_inertia: 0.139e-4 kg*m^2, gearbox: [{planetary: {sun: 18, ring: 46}, inertia: 0.017e-4 kg*m^2}, "
    "{planetary: {sun: 16, ring: 56}, inertia: 0.169e-4 kg*m^2}]"
)
LINE = "stall_torque: 2 N*m, no_load_speed: 320 rad/s"


def test_two_planetary_stages() -> None:
    """(1 + 46/18)(1 + 56/16) = 16; 0.139e-4 x 16^2 + 0.017e-4 x 4.5^2 + 0.169e-4 = 0.003609725."""
    found = one(f"side: motor, {LINE}, {G1}")
    assert found.armature.value == pytest.approx(0.003609725, rel=1e-12)
    assert found.stall_torque is not None and found.no_load_speed is not None
    assert found.stall_torque.value == pytest.approx(32.0)
    assert found.no_load_speed.value == pytest.approx(20.0)
    assert found.armature.formula == (
        "1.39e-05 kg*m^2 x 256 (gearbox^2) + 1.7e-06 kg*m^2 x 20.25 (gearbox stage 2^2) + 1.69e-05 kg*m^2, "
        "gearbox = (1 + 46/18) x (1 + 56/16)"
    )
    assert found.stall_torque.formula == (
        "2 N*m x 16 (gearbox) x 1 (efficiency, default), gearbox = (1 + 46/18) x (1 + 56/16)"
    )


def test_figures_at_the_output_take_no_gear() -> None:
    """`side: joint`: torque and speed are behind the gearbox, the rotor's inertia is not."""
    found = one(f"side: joint, {LINE}, {G1}")
    assert found.stall_torque is not None and found.no_load_speed is not None
    assert (found.stall_torque.value, found.stall_torque.origin) == (2.0, Origin.AUTHORED)
    assert found.no_load_speed.value == 320.0
    assert found.armature.value == pytest.approx(0.003609725, rel=1e-12)


def test_reduction_and_motors_behind_a_gearbox() -> None:
    """Every inertia takes them: 0.003609725 x 1.5^2 x 2 = 0.0162437625."""
    found = one(f"side: joint, {LINE}, {G1}", ", reduction: 1.5, motors_per_joint: 2")
    assert found.armature.value == pytest.approx(0.0162437625, rel=1e-12)
    assert found.armature.formula == (
        "(1.39e-05 kg*m^2 x 256 (gearbox^2) + 1.7e-06 kg*m^2 x 20.25 (gearbox stage 2^2) + 1.69e-05 kg*m^2) "
        "x 2.25 (reduction^2) x 2 (motors_per_joint), gearbox = (1 + 46/18) x (1 + 56/16)"
    )


def test_a_stated_ratio_may_be_rounded() -> None:
    """gear_ratio 14.3 for 4.5 x (1 + 48/22) = 14.318: the stages are what counts."""
    found = one(
        f"side: motor, {LINE}, gear_ratio: 14.3, gearbox: [{{ratio: 4.5}}, {{planetary: {{sun: 22, ring: 48}}}}]"
    )
    assert found.stall_torque is not None
    assert found.stall_torque.value == pytest.approx(2 * 4.5 * 70 / 22)


def test_efficiency_is_the_product() -> None:
    """2 x (60/20 x 5) x (0.95 x 0.8) = 22.8; a stage that states none counts as 1, and the formula says so."""
    found = one(
        f"side: motor, {LINE}, gearbox: [{{teeth: {{driving: 20, driven: 60}}, efficiency: 95 %}}, "
        "{ratio: 5, efficiency: 0.8}, {ratio: 1}]"
    )
    assert found.stall_torque is not None and found.no_load_speed is not None
    assert found.stall_torque.value == pytest.approx(22.8)
    assert found.no_load_speed.value == pytest.approx(320 / 15)  # no efficiency on speed
    assert found.stall_torque.formula == (
        "2 N*m x 15 (gearbox) x 0.76 (efficiency), gearbox = 60/20 x 5 x 1, "
        "efficiency = 0.95 x 0.8 x 1 (stage 3, default)"
    )


def test_one_efficiency_for_the_gearbox() -> None:
    """The motor's `efficiency` is that of all stages."""
    found = one(f"side: motor, {LINE}, efficiency: 0.9, gearbox: [{{ratio: 3}}, {{ratio: 5}}]")
    assert found.stall_torque is not None and found.stall_torque.value == pytest.approx(27.0)


def test_a_stage_without_inertia_is_named() -> None:
    """It counts as nothing, and the number says what it leaves out."""
    found = one(
        f"side: joint, {LINE}, rotor_inertia: 1e-5, gearbox: [{{ratio: 3}}, {{ratio: 5, inertia: 2e-5}}]"
    )
    assert found.armature.value == pytest.approx(1e-5 * 225 + 2e-5)
    assert found.armature.note == "without gearbox stage 1, whose inertia is not stated"


@pytest.mark.parametrize(
    "stages",
    ["[{ratio: 3, inertia: unknown}, {ratio: 5}]", "[{ratio: 15, inertia: unknown}]"],
    ids=["first", "only"],
)
def test_an_unknown_inertia_makes_the_sum_unknown(stages: str) -> None:
    """`unknown` is not 0."""
    found = one(f"side: joint, {LINE}, rotor_inertia: 1e-5, gearbox: {stages}")
    assert found.reflected_inertia.value is None


def test_std_of_a_sum() -> None:
    """0.3e-5 x 10^2 and 0.4e-3 add in quadrature: 5e-4."""
    found = one(
        f"side: joint, {LINE}, rotor_inertia: {{value: 1e-5, std: 0.3e-5}}, "
        "gearbox: [{ratio: 10, inertia: {value: 1e-3, std: 0.4e-3}}]"
    )
    assert found.armature.std == pytest.approx(5e-4)


def test_ball_screw() -> None:
    """5 mm a turn is 2 pi / 0.005 = 1256.637 rad/m: 2 N*m x 0.9 is 2261.95 N, 320 rad/s is 0.254648 m/s."""
    n = 2 * math.pi / 0.005
    found = one(
        f"side: motor, {LINE}, rotor_inertia: 1e-5 kg*m^2, gearbox: [{{lead: 5 mm/rev, efficiency: 0.9, "
        "inertia: 0.5 kg}]",
        robot=SLIDE,
    )
    assert found.stall_torque is not None and found.no_load_speed is not None
    assert (found.stall_torque.value, found.stall_torque.unit) == (pytest.approx(1.8 * n), "N")
    assert (found.no_load_speed.value, found.no_load_speed.unit) == (pytest.approx(320 / n), "m/s")
    # 1e-5 x 1256.637^2 = 15.7914 kg, and the nut's 0.5 kg as it is
    assert (found.armature.value, found.armature.unit) == (pytest.approx(16.2914, rel=1e-5), "kg")
    assert found.stall_torque.formula == (
        "2 N*m x 1256.64 (gearbox) x 0.9 (efficiency), gearbox = 1/(5 mm/rev)"
    )


def test_rack_outside_the_motor() -> None:
    """A module with 20 N*m and 10 rad/s at its output on a pinion of 25 mm: 800 N, 0.25 m/s, 0.01 / r^2 = 16 kg."""
    found = one(
        "side: joint, stall_torque: 20 N*m, no_load_speed: 10 rad/s, reflected_inertia: 0.01 kg*m^2",
        ", transmission: [{radius: 25 mm}]",
        robot=SLIDE,
    )
    assert found.stall_torque is not None and found.no_load_speed is not None
    assert (found.stall_torque.value, found.stall_torque.unit) == (pytest.approx(800.0), "N")
    assert (found.no_load_speed.value, found.no_load_speed.unit) == (pytest.approx(0.25), "m/s")
    assert (found.armature.value, found.armature.unit) == (pytest.approx(16.0), "kg")
    assert found.stall_torque.formula == (
        "20 N*m x 40 (transmission) x 1 (efficiency of the transmission, default), transmission = 1/(25 mm)"
    )


def test_two_motors_on_a_screw_each() -> None:
    """Stages and screw come with every motor: 2 x (0.01 x 40^2 + 0.3) = 32.6 kg, 2 x 20 x 40 x 0.8 = 1280 N."""
    found = one(
        "side: joint, stall_torque: 20 N*m, no_load_speed: 10 rad/s, reflected_inertia: 0.01 kg*m^2",
        ", transmission: [{radius: 25 mm, efficiency: 0.8, inertia: 0.3 kg}], motors_per_joint: 2",
        robot=SLIDE,
    )
    assert found.armature.value == pytest.approx(32.6)
    assert found.armature.formula == (
        "0.01 kg*m^2 x 1600 (transmission^2) x 2 (motors_per_joint) + 0.3 kg x 2 (motors_per_joint), "
        "transmission = 1/(25 mm)"
    )
    assert found.stall_torque is not None and found.stall_torque.value == pytest.approx(1280.0)


def test_screw_and_lever_to_a_hinge() -> None:
    """Torque x 1256.637 rad/m x 0.045 m = 56.5487: turns to travel to turns."""
    n = 2 * math.pi / 0.005 * 0.045
    found = one(
        f"side: motor, {LINE}, rotor_inertia: 1e-5 kg*m^2, gearbox: [{{lead: 5 mm/rev}}]",
        ", transmission: [{lever_arm: 45 mm}]",
    )
    assert found.stall_torque is not None and found.no_load_speed is not None
    assert (found.stall_torque.value, found.stall_torque.unit) == (pytest.approx(2 * n), "N*m")
    assert (found.no_load_speed.value, found.no_load_speed.unit) == (pytest.approx(320 / n), "rad/s")
    assert (found.armature.value, found.armature.unit) == (pytest.approx(1e-5 * n * n), "kg*m^2")


def test_linear_motor_by_its_datasheet() -> None:
    """400 N and 0.5 m/s at the rod, an arm of 50 mm: 20 N*m, 10 rad/s, 2 kg x 0.05^2 = 0.005 kg*m^2."""
    found = one(
        "side: joint, stall_torque: 400 N, no_load_speed: 0.5 m/s, reflected_inertia: 2 kg",
        ", transmission: [{lever_arm: 50 mm}]",
    )
    assert found.stall_torque is not None and found.no_load_speed is not None
    assert (found.stall_torque.value, found.no_load_speed.value) == (pytest.approx(20), pytest.approx(10))
    assert found.armature.value == pytest.approx(0.005)


def test_radius_from_travel_to_turns() -> None:
    """A rope from a linear motor round a pulley of 50 mm: 400 N are 20 N*m at every angle."""
    text = spec_of(
        "all: {joints: [hip], motor: m, level: ideal_pd, kp: 1, kd: 1, transmission: [{radius: 50 mm}]}",
        robot=HINGE,
        motors="{m: {side: joint, peak_torque: 400 N}}",
    )
    assert joint(text).effort_limit.value == pytest.approx(20)
    assert fit(text).approximations == ()


def test_a_lever_is_an_approximation() -> None:
    """One arm at every angle is named with the key that `accept` takes."""
    text = spec_of(
        "all: {joints: [hip], motor: m, level: ideal_pd, kp: 1, kd: 1, transmission: [{lever_arm: 50 mm}]}",
        robot=HINGE,
        motors="{m: {side: joint, peak_torque: 400 N}}",
    )
    (loss,) = fit(text).approximations
    assert (loss.key, loss.joint, loss.emitted) == ("spec.lever_arm", "hip", "50 mm at every angle")
    assert loss.max_torque_error is None


def test_currents_through_a_screw() -> None:
    """0.1 N*m/A x 20 A x 1256.637 rad/m x 0.9 = 2261.95 N: the torque constant is at the rotor."""
    found = one(
        f"side: motor, {LINE}, torque_constant: 0.1 N*m/A, peak_current: 20 A, "
        "gearbox: [{lead: 5 mm/rev, efficiency: 0.9}]",
        robot=SLIDE,
    )
    assert (found.peak_torque.value, found.peak_torque.unit) == (pytest.approx(2261.947, rel=1e-6), "N")
    assert found.peak_torque.formula == (
        "0.1 N*m/A (torque_constant) x 20 A (peak_current) x 1256.64 (gearbox) x 0.9 (efficiency), "
        "gearbox = 1/(5 mm/rev)"
    )


def test_a_curve_through_a_rack() -> None:
    """Each figure of an asymmetric curve is brought over: 20 and 30 N*m, 5 and 10 rad/s on 25 mm."""
    found = one(
        "side: joint, curve: {drive_torque: 20 N*m, brake_torque: 30 N*m, knee_speed: 5 rad/s, "
        "no_load_speed: 10 rad/s}",
        ", transmission: [{radius: 25 mm}]",
        robot=SLIDE,
    )
    assert found.curve is not None
    figures = (found.curve.drive_torque, found.curve.brake_torque, found.curve.knee_speed)
    assert [(figure.value, figure.unit) for figure in figures] == [
        (pytest.approx(800), "N"),
        (pytest.approx(1200), "N"),
        (pytest.approx(0.125), "m/s"),
    ]


def test_the_shaft_of_every_figure_is_followed() -> None:
    """In front of the screw the motor turns, behind it it travels: one message, at the screw that makes it so."""
    text = spec_of(
        "all: {joints: [lift], motor: m, level: ideal_pd, kp: 1 N/m, kd: 1 N*s/m, transmission: [{lead: 5 mm/rev, "
        "inertia: 1 kg*m^2}]}",
        robot=SLIDE,
        motors="{m: {side: motor, peak_torque: 2 N, rotor_inertia: 1 kg, gear_ratio: 3}}",
    )
    assert refused(text) == [
        "RES001 actuators.all.transmission[0].lead: a lead turns rotation into travel, on the way to 'lift', a slide "
        "joint: with it the motor turns, and its figures are of one that travels (peak_torque 2 N, and 1 more figure)",
        "RES001 actuators.all.transmission[0].inertia: the inertia is 1 kg*m^2, but the stage's output travels, on "
        "the way to 'lift', a slide joint",
    ]


SERVO = "peak_torque: 0.96 N*m, no_load_speed: 100 rad/s, rotor_inertia: 25 g*cm^2"
TURNING = SLIDE.replace("slide", "hinge")


@pytest.mark.parametrize(
    ("motor", "group", "robot", "expected"),
    [
        pytest.param(
            f"side: motor, gearbox: [{{ratio: 3}}, {{ratio: 2}}], {SERVO}",
            "",
            SLIDE,
            "motors.m.gearbox[1]: the motor turns (no_load_speed 100 rad/s, and 2 more figures) and the part that it "
            "drives travels, on the way to 'lift', a slide joint, without a stage that makes one of the other",
            id="a screw is missing",
        ),
        pytest.param(
            f"side: motor, gear_ratio: 3, {SERVO}",
            "",
            SLIDE,
            "motors.m.gear_ratio: the motor turns (no_load_speed 100 rad/s, and 2 more figures)",
            id="behind a ratio",
        ),
        pytest.param(
            f"side: joint, {SERVO}, gear_ratio: 3",
            ", reduction: 2",
            SLIDE,
            "actuators.all.reduction: the motor turns (no_load_speed 100 rad/s, and 2 more figures)",
            id="behind a reduction",
        ),
        pytest.param(
            "side: joint, peak_torque: 20 N, no_load_speed: 1 m/s",
            "",
            TURNING,
            "motors.m: the motor travels (no_load_speed 1 m/s, and 1 more figure) and the part that it drives turns, ",
            id="a lever is missing",
        ),
        pytest.param(
            f"side: motor, gearbox: [{{ratio: 3}}, {{radius: 165 mm}}], {SERVO}",
            "",
            TURNING,
            "motors.m.gearbox[1].radius: a radius turns travel into rotation, on the way to 'lift', a hinge joint: "
            "with it the motor travels, and its figures are of one that turns (no_load_speed 100 rad/s, and 2 more "
            "figures)",
            id="a wheel's radius",
        ),
        pytest.param(
            f"side: joint, gearbox: [{{lead: 5 mm/rev}}], {SERVO}",
            "",
            SLIDE,
            "motors.m.side: by `side: joint` the figures are of the output of the gearbox, which travels, on the way "
            "to 'lift', a slide joint, and they are of what turns (no_load_speed 100 rad/s, and 1 more figure)",
            id="the other side",
        ),
        pytest.param(
            f"side: motor, gearbox: [{{lead: 5 mm/rev}}], {SERVO.replace('0.96 N*m', '0.96 N')}",
            "",
            SLIDE,
            "motors.m.peak_torque: peak_torque is 0.96 N, but its shaft turns, on the way to 'lift', a slide joint",
            id="one figure of three",
        ),
    ],
)
def test_what_makes_all_figures_misfit_is_told_once(
    motor: str, group: str, robot: str, expected: str
) -> None:
    """Where no figure fits its shaft the stages are wrong, or the side; where the others do, the figure is."""
    text = spec_of(
        f"all: {{joints: [lift], motor: m, level: ideal_pd, kp: 1, kd: 1{group}}}",
        robot=robot,
        motors=f"{{m: {{{motor}}}}}",
    )
    (line,) = refused(text)
    assert line.startswith(f"RES001 {expected}")


@pytest.mark.parametrize(
    "stages", [", ".join(["{ratio: 1e-45}"] * 8), ", ".join(["{ratio: 1e45}"] * 8)], ids=["under", "over"]
)
def test_ratios_beyond_the_floats(stages: str) -> None:
    """A product of ratios that is 0 or infinite as a float is out of range, not a traceback."""
    text = spec_of(
        "all: {joints: [hip], motor: m, level: dc_motor, kp: 1, kd: 1}",
        robot=HINGE,
        motors=f"{{m: {{side: motor, {LINE}, gearbox: [{stages}]}}}}",
    )
    assert {fault.split()[0] for fault in refused(text)} == {"RES011"}


def test_a_motor_of_other_joints() -> None:
    """A screw's motor at a hinge, where it drives a slide rightly, is told at the group; alone, at the screw."""
    robot = "name: leg, model: none, joints: [{name: beak, kind: slide}, pan]"
    motors = (
        "{m: {side: motor, peak_torque: 0.03 N*m, rotor_inertia: 1.1 g*cm^2, gearbox: [{lead: 2 mm/rev}]}}"
    )
    beak = "beak: {joints: [beak], motor: m, level: ideal_pd, kp: 9000 N/m, kd: 60 N*s/m}"
    neck = "neck: {joints: [pan], motor: m, level: ideal_pd, kp: 16, kd: 0.25}"
    fault = "the part that a lead drives turns, on the way to 'pan', a hinge joint"
    (told,) = refused(spec_of(f"{beak}, {neck}", robot=robot, motors=motors))
    assert told.startswith(f"RES013 actuators.neck.motor: {fault} (motors.m.gearbox[0].lead, ")
    (alone,) = refused(spec_of(neck, robot=robot.replace("{name: beak, kind: slide}, ", ""), motors=motors))
    assert alone == f"RES013 motors.m.gearbox[0].lead: {fault}"
