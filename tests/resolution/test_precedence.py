"""Who wins: authored, identified, derived, the file, the default; and what `unknown` does."""

from __future__ import annotations

from typing import Any

import pytest

from actspec.ir import JointActuator, Origin, Quantity
from tests.fitting import fit, joint, refused, spec_of

MODEL = """<mujoco><worldbody><body><joint name="hip" axis="0 1 0" damping="0.7" frictionloss="0.3"
armature="0.04"/><geom size="0.1" mass="1"/><body><joint name="calf" axis="0 1 0"/><geom size="0.1" mass="1"/>
</body></body></worldbody><actuator><position joint="hip" kp="60" kv="2" forcerange="-15 15"/>
<motor joint="calf"/></actuator></mujoco>"""
MOTOR = "{m: {side: joint, peak_torque: 40 N*m, gear_ratio: 10, rotor_inertia: 2e-4 kg*m^2}}"
RESULTS = "{hip: {kp: {value: 30, std: 1}, kd: {value: 0.6, std: 0.1}, armature: {value: 0.025, std: 0.002}, "
RESULTS += "friction: {coulomb: {value: 0.2, std: 0.01}}, delay: {value: 7 ms, std: 1 ms}, bandwidth: 25 Hz, "
RESULTS += "encoder_bias: {value: 0.02 rad, std: 0.01 rad}}}"


def legs(fields: str = "", *, identified: bool = False) -> str:
    """A spec for MODEL: the hip as told, the calf with gains of its own."""
    named = ", identified: r.yaml" if identified else ""
    return spec_of(
        f"legs: {{joints: [hip], level: ideal_pd{named}{fields}}}, rest: {{joints: [calf], level: ideal_pd, "
        "kp: 1, kd: 1}",
        robot="name: leg, model: robot.xml",
        motors=MOTOR,
    )


def get(actuator: JointActuator, field: str) -> Quantity:
    """A quantity by the IR's name."""
    found: Any = getattr(actuator, field)
    assert isinstance(found, Quantity)
    return found


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("kp", 60.0),
        ("kd", 2.0),
        ("armature", 0.04),
        ("friction_viscous", 0.7),
        ("friction_coulomb", 0.3),
        ("effort_limit", 15.0),
    ],
)
def test_what_nobody_states_is_kept_from_the_file(field: str, value: float) -> None:
    """A field that the spec does not mention is the file's own, never 0."""
    found = get(joint(legs(), model=MODEL), field)
    assert (found.value, found.origin) == (value, Origin.MODEL)


@pytest.mark.parametrize(
    ("field", "written", "value", "lost"),
    [
        pytest.param("kp", ", kp: 31", 31.0, [30.0, 60.0], id="kp"),
        pytest.param("kd", ", kd: 0.5", 0.5, [0.6, 2.0], id="kd"),
        pytest.param("armature", ", motor: m, armature: 0.024", 0.024, [0.025, 0.02, 0.04], id="armature"),
        pytest.param("friction_coulomb", ", friction: {coulomb: 0.19}", 0.19, [0.2, 0.3], id="coulomb"),
    ],
)
def test_authored_wins_over_all(field: str, written: str, value: float, lost: list[float]) -> None:
    """The winner keeps the losers, strongest first."""
    found = get(joint(legs(written, identified=True), model=MODEL, results=RESULTS), field)
    assert (found.value, found.origin) == (value, Origin.AUTHORED)
    assert [loser.value for loser in found.lost] == lost


def test_identified_wins_over_derived_and_file() -> None:
    """The fitted armature passes over the motor's and the file's; its std and its source stay with it."""
    found = joint(legs(", motor: m", identified=True), model=MODEL, results=RESULTS).armature
    assert (found.value, found.origin, found.std, found.source) == (0.025, Origin.IDENTIFIED, 0.002, "r.yaml")
    assert [(loser.value, loser.origin) for loser in found.lost] == [
        (0.02, Origin.DERIVED),
        (0.04, Origin.MODEL),
    ]


def test_identified_wins_over_a_derived_gain() -> None:
    """`{derive: ...}` has origin derived, whoever wrote it, and stands below what was measured."""
    derive = ", motor: m, kp: {derive: torque_at_error, fraction: 0.5, error: 0.1 rad}"
    found = get(joint(legs(derive, identified=True), model=MODEL, results=RESULTS), "kp")
    assert (found.value, found.origin) == (30.0, Origin.IDENTIFIED)
    # 0.5 x 40 / 0.1, then the file's servo.
    assert [(loser.value, loser.origin) for loser in found.lost] == [
        (200.0, Origin.DERIVED),
        (60.0, Origin.MODEL),
    ]


def test_derived_wins_over_the_file() -> None:
    """The motor's reflected inertia passes over the file's armature."""
    found = joint(legs(", motor: m"), model=MODEL).armature
    assert (found.value, found.origin, [loser.value for loser in found.lost]) == (
        0.02,
        Origin.DERIVED,
        [0.04],
    )


def test_the_engines_default_comes_last() -> None:
    """What neither spec nor file states is the engine's 0, and says that nobody measured it."""
    found = joint(legs(), "calf", MODEL)
    assert (found.friction_coulomb.value, found.friction_coulomb.origin) == (0.0, Origin.DEFAULT)


@pytest.mark.parametrize(
    ("field", "written"),
    [
        ("kp", ", kp: unknown"),
        ("armature", ", motor: m, armature: unknown"),
        ("friction_coulomb", ", friction: {coulomb: unknown}"),
        ("effort_limit", ", motor: m, effort_limit: unknown"),
    ],
)
def test_unknown_stops_the_fall_through(field: str, written: str) -> None:
    """`unknown` is an answer: nothing weaker is taken, but it is shown what there would have been."""
    found = get(joint(legs(written), model=MODEL), field)
    assert (found.value, found.origin) == (None, Origin.UNKNOWN)
    assert found.lost
    assert found.span is not None


def test_asking_for_the_identified_value() -> None:
    """`identified` takes the fitted number, with its std."""
    found = get(joint(legs(", kp: identified", identified=True), model=MODEL, results=RESULTS), "kp")
    assert (found.value, found.std, found.origin) == (30.0, 1.0, Origin.IDENTIFIED)


def test_asking_for_an_identified_value_that_is_not_there() -> None:
    """Asked for and missing is an error, never a silent fall to the file's value."""
    assert refused(legs(", kp: identified", identified=True), MODEL, results="{hip: {kd: 0.5}}") == [
        "RES002 actuators.legs.kp: hip: kp is to be the identified value, but r.yaml has no kp of it"
    ]


@pytest.mark.parametrize(
    ("fields", "said"),
    [
        pytest.param(", kp: 33", [], id="exactly 3 std"),
        pytest.param(
            ", kp: 33.5",
            ["kp: authored 33.5 N*m/rad and identified 30 N*m/rad are 3.5 std apart (std 1 N*m/rad)"],
            id="above",
        ),
        pytest.param(
            ", kp: 26",
            ["kp: authored 26 N*m/rad and identified 30 N*m/rad are 4.0 std apart (std 1 N*m/rad)"],
            id="below",
        ),
        pytest.param(", kp: {value: 26, std: 2}", [], id="the larger std counts"),
        pytest.param(
            ", delay: 3 ms",
            ["delay: authored 0.003 s and identified 0.007 s are 4.0 std apart (std 0.001 s)"],
            id="delay",
        ),
        pytest.param(
            ", friction: {coulomb: 0.3}",
            ["friction.coulomb: authored 0.3 N*m and identified 0.2 N*m are 10.0 std apart (std 0.01 N*m)"],
            id="friction",
        ),
    ],
)
def test_authored_and_identified_apart(fields: str, said: list[str]) -> None:
    """More than 3 std between what is written and what was measured is a warning with both."""
    found = fit(legs(fields, identified=True), MODEL, results=RESULTS)
    warnings = [d.message for d in found.diagnostics if d.code == "RES010"]
    assert warnings == [f"hip: {text}" for text in said]


def test_identified_delay_filter_and_bias() -> None:
    """What the results state and the spec does not is taken from the results."""
    found = joint(legs("", identified=True), model=MODEL, results=RESULTS)
    assert found.delay is not None and found.filter_cutoff is not None
    assert (found.delay.nominal.value, found.delay.low, found.delay.high) == (0.007, 0.007, 0.007)
    assert (found.filter_cutoff.value, found.filter_cutoff.unit) == (25.0, "Hz")
    assert (found.encoder_bias.value, found.encoder_bias.origin) == (0.02, Origin.IDENTIFIED)


@pytest.mark.parametrize(
    "delay, count",
    [("unknown", 1), ("{nominal: unknown, range: [5 ms, 20 ms]}", 0), ("0 ms", 0), ("7 ms", 0)],
)
def test_an_unknown_delay_is_said(delay: str, count: int) -> None:
    """Nothing is written for it, which is not what nobody knows; a range is written."""
    found = fit(legs(f", delay: {delay}", identified=False), MODEL)
    said = [item for item in found.diagnostics if item.code == "RES017"]
    assert [item.message for item in said] == [
        "the delay of hip is unknown: every target is written without one"
    ] * count


def test_a_filter_that_is_written_off_stays_off() -> None:
    """`command_filter: none` is authored, and stronger than the results."""
    assert (
        joint(legs(", command_filter: none", identified=True), model=MODEL, results=RESULTS).filter_cutoff
        is None
    )


def test_closed_loop_bandwidth_is_never_the_filter() -> None:
    """-3 dB of q over q* has the PD in it; as a filter it would count the PD twice."""
    assert (
        joint(
            legs("", identified=True), model=MODEL, results="{hip: {closed_loop_bandwidth: 5 Hz}}"
        ).filter_cutoff
        is None
    )


def test_the_files_delay_is_recorded_as_lost() -> None:
    """An authored delay shows what the file's own actuator had."""
    model = MODEL.replace('kv="2"', 'kv="2" delay="0.004" nsample="5"')
    found = joint(legs(", delay: 6 ms"), model=model).delay
    assert found is not None
    assert (found.nominal.value, [loser.value for loser in found.nominal.lost]) == (0.006, [0.004])


def test_results_in_the_other_joints_unit() -> None:
    """A fitted mass at a hinge is refused, like a written one."""
    assert refused(legs("", identified=True), MODEL, results="{hip: {armature: 0.02 kg}}") == [
        "RES001 joints.hip.armature: 'hip' is a hinge joint, but its armature is 0.02 kg"
    ]
