"""The rest of the language: overrides, commands, delay, filter, slides, randomisation, timing."""

from __future__ import annotations

import math

import pytest

from actspec.diagnostics import Severity, SpecError
from actspec.ir import Command, Level, Origin
from tests.fitting import faults_of, fit, joint, model_of, refused, spec_of

HIP = "name: leg, model: none, joints: [{name: hip, range: [-1 rad, 2 rad]}]"
MOTORS = "{m: {side: joint, peak_torque: 40 N*m, bandwidth: 30 Hz}, n: {side: joint, peak_torque: 20 N*m}}"
MODEL = """<mujoco><option timestep="0.001"/><worldbody><body><joint name="hip" axis="0 1 0" frictionloss="0.3"/>
<geom size="0.1" mass="1"/></body></worldbody></mujoco>"""


def hip(fields: str, gains: str = "kp: 25, kd: 0.5") -> str:
    """A spec of one joint."""
    return spec_of(f"legs: {{joints: [hip], level: ideal_pd, {gains}{fields}}}", robot=HIP, motors=MOTORS)


def test_overrides_lay_over_the_group_field_by_field() -> None:
    """An override changes what it states and nothing else, inside `friction` too."""
    text = spec_of(
        "legs: {joints: [hip, calf], level: ideal_pd, kp: 25, kd: 0.5, motor: m, "
        "friction: {coulomb: 0.2, viscous: 0.01}, "
        "overrides: {hip: {kp: 30, friction: {coulomb: 0.4}}, calf: {motor: n}}}",
        robot="name: leg, model: none, joints: [hip, calf]",
        motors=MOTORS,
    )
    first, second = fit(text).joints
    assert first.kp is not None and second.kp is not None and first.kd is not None
    assert (first.kp.value, first.kd.value, second.kp.value) == (30.0, 0.5, 25.0)
    assert (first.friction_coulomb.value, first.friction_viscous.value) == (0.4, 0.01)
    assert (second.friction_coulomb.value, second.friction_viscous.value) == (0.2, 0.01)
    assert (first.effort_limit.value, second.effort_limit.value) == (40.0, 20.0)


def test_overrides_of_different_fields_may_meet() -> None:
    """Two overrides match one joint as long as no field is stated twice."""
    found = joint(hip(', overrides: {"h.*": {kp: 30}, ".*p": {kd: 1, friction: {viscous: 0.1}}}'))
    assert found.kp is not None and found.kd is not None
    assert (found.kp.value, found.kd.value, found.friction_viscous.value) == (30.0, 1.0, 0.1)


def test_two_overrides_of_one_field() -> None:
    """At most one override states a field of a joint; friction counts part by part."""
    overrides = (
        ', overrides: {"h.*": {friction: {coulomb: 0.1}}, ".*p": {friction: {coulomb: 0.2, viscous: 1}}}'
    )
    assert [line.split(": ")[0] for line in refused(hip(overrides))] == [
        "BIND006 actuators.legs.overrides..*p.friction.coulomb"
    ]


def test_static_friction_against_the_files_coulomb() -> None:
    """What is authored must fit what is kept from the file."""
    text = spec_of(
        "legs: {joints: [hip], level: ideal_pd, kp: 1, kd: 1, friction: {static: 0.2}}",
        robot="name: leg, model: robot.xml",
    )
    assert refused(text, MODEL) == [
        "RES009 actuators.legs.friction.static: hip: static friction 0.2 N*m (authored) is below coulomb friction "
        "0.3 N*m (model)"
    ]


@pytest.mark.parametrize(
    ("fields", "command", "kp", "kd"),
    [
        pytest.param("kp: 25, kd: 0.5", Command.POSITION, 25.0, 0.5, id="position"),
        pytest.param("command: velocity, kd: 0.5", Command.VELOCITY, None, 0.5, id="velocity"),
        pytest.param("command: effort", Command.EFFORT, None, None, id="effort"),
    ],
)
def test_commands(fields: str, command: Command, kp: float | None, kd: float | None) -> None:
    """velocity has kd only, effort has no gain at all."""
    found = joint(hip("", fields))
    assert (found.command, found.level) == (command, Level.IDEAL_PD)
    assert (found.kp.value if found.kp else None, found.kd.value if found.kd else None) == (kp, kd)


@pytest.mark.parametrize(
    ("command", "limits", "ends", "unit"),
    [
        pytest.param("position", "[-90 deg, 1 rad]", (-math.pi / 2, 1.0), "rad", id="position"),
        pytest.param("velocity", "[-60 rpm, 60 rpm]", (-2 * math.pi, 2 * math.pi), "rad/s", id="velocity"),
        pytest.param("effort", "[-5, 7 N*m]", (-5.0, 7.0), "N*m", id="effort"),
        pytest.param("position", "joint", (-1.0, 2.0), "rad", id="the joint's own"),
    ],
)
def test_command_range(command: str, limits: str, ends: tuple[float, float], unit: str) -> None:
    """A range is in the unit of the command."""
    gains = {"position": ", kp: 1, kd: 1", "velocity": ", kd: 1", "effort": ""}[command]
    found = joint(hip("", f"command: {command}, command_range: {limits}{gains}")).command_range
    assert found is not None
    assert tuple(end.value for end in found) == pytest.approx(ends)
    assert {end.unit for end in found} == {unit}


def test_no_command_range_is_the_default() -> None:
    """A clamp of the command is never silent."""
    assert joint(hip("")).command_range is None
    assert joint(hip(", command_range: none")).command_range is None


@pytest.mark.parametrize(
    ("written", "nominal", "low", "high", "sampling"),
    [
        pytest.param("5 ms", 0.005, 0.005, 0.005, "episode", id="plain"),
        pytest.param("{value: 5 ms, std: 1 ms}", 0.005, 0.005, 0.005, "episode", id="value"),
        pytest.param("{nominal: 5 ms}", 0.005, 0.005, 0.005, "episode", id="no range"),
        pytest.param(
            "{nominal: 5 ms, range: [0, 20 ms], sampling: step}", 0.005, 0.0, 0.02, "step", id="full"
        ),
        pytest.param("0", 0.0, 0.0, 0.0, "episode", id="zero needs no unit"),
        pytest.param("{nominal: unknown, range: [1 ms, 2 ms]}", None, 0.001, 0.002, "episode", id="unknown"),
    ],
)
def test_delay(written: str, nominal: float | None, low: float, high: float, sampling: str) -> None:
    """A plain time is nominal without a range."""
    found = joint(hip(f", delay: {written}")).delay
    assert found is not None
    assert (found.nominal.value, found.low, found.high, found.sampling) == (nominal, low, high, sampling)


def test_no_delay_is_no_delay() -> None:
    """What nobody states is not there."""
    assert joint(hip("")).delay is None


def test_filter() -> None:
    """A cutoff stays in Hz (188.5 would be rad/s); `from_motor` takes the motor's bandwidth."""
    stated = joint(hip(", command_filter: {cutoff: 20 Hz}")).filter_cutoff
    taken = joint(hip(", motor: m, command_filter: from_motor")).filter_cutoff
    assert stated is not None and taken is not None
    assert (stated.value, stated.origin) == (20.0, Origin.AUTHORED)
    assert (taken.value, taken.origin) == (30.0, Origin.DERIVED)
    # A bandwidth is information until somebody asks for it.
    assert joint(hip(", motor: m")).filter_cutoff is None


def test_encoder_bias_and_action_scale() -> None:
    """Bias defaults to 0, and says so; a scale is there only when stated."""
    found = joint(hip(", encoder_bias: 1 deg, action_scale: 25 %"))
    assert found.encoder_bias.value == pytest.approx(math.pi / 180)
    assert found.action_scale is not None and found.action_scale.value == 0.25
    plain = joint(hip(""))
    assert (plain.encoder_bias.value, plain.encoder_bias.origin, plain.action_scale) == (
        0.0,
        Origin.DEFAULT,
        None,
    )


def test_slide() -> None:
    """A slide's quantities are in N, m and kg."""
    text = spec_of(
        "legs: {joints: [s], level: ideal_pd, kp: 1 kN/m, kd: 10 N*s/m, effort_limit: 200 N, velocity_limit: 50 cm/s, "
        "armature: 500 g, friction: {coulomb: 3 N, viscous: 2}, encoder_bias: 1 mm}",
        robot="name: leg, model: none, joints: [{name: s, kind: slide, range: [0 m, 10 cm]}], "
        "default_pose: {s: 5 cm}",
    )
    found = joint(text, "s")
    assert found.kp is not None and found.kd is not None
    figures = (
        found.kp,
        found.kd,
        found.effort_limit,
        found.velocity_limit,
        found.armature,
        found.friction_coulomb,
        found.friction_viscous,
        found.encoder_bias,
        found.default_position,
    )
    assert [(q.value, q.unit) for q in figures] == [
        (1000.0, "N/m"),
        (10.0, "N*s/m"),
        (200.0, "N"),
        (0.5, "m/s"),
        (0.5, "kg"),
        (3.0, "N"),
        (2.0, "N*s/m"),
        (0.001, "m"),
        (0.05, "m"),
    ]
    assert found.position_range == (0.0, 0.1)


@pytest.mark.parametrize(
    ("field", "entry", "expected"),
    [
        pytest.param(
            "kp", "{scale: [0.75, 1.5]}", ("scale", 0.75, 1.5, "uniform", "reset", None, "joint"), id="scale"
        ),
        pytest.param(
            "encoder_bias",
            "{add: [-1 deg, 1 deg], when: startup, per: env}",
            ("add", -math.pi / 180, math.pi / 180, "uniform", "startup", None, "env"),
            id="add",
        ),
        pytest.param(
            "delay",
            "{abs: [0, 10 ms], when: interval, every: [1 s, 2 s]}",
            ("abs", 0.0, 0.01, "uniform", "interval", (1.0, 2.0), "joint"),
            id="abs",
        ),
        pytest.param(
            "strength",
            "{scale: [1.0, 0.1], distribution: gaussian}",
            ("scale", 1.0, 0.1, "gaussian", "reset", None, "joint"),
            id="gaussian is mean and std",
        ),
        pytest.param(
            "kp",
            "{from: identified, sigma: 2}",
            ("abs", 26.0, 34.0, "uniform", "reset", None, "joint"),
            id="2 sigma",
        ),
        pytest.param(
            "kp",
            "{from: identified, sigma: 2, distribution: gaussian}",
            ("abs", 30.0, 4.0, "gaussian", "reset", None, "joint"),
            id="gaussian of the fit",
        ),
        pytest.param(
            "kd",
            "{from: identified}",
            ("abs", 0.0, 0.5, "uniform", "reset", None, "joint"),
            id="never below 0",
        ),
        pytest.param(
            "encoder_bias",
            "{from: identified}",
            ("abs", -0.02, 0.04, "uniform", "reset", None, "joint"),
            id="a bias may be",
        ),
    ],
)
def test_randomize(field: str, entry: str, expected: tuple[object, ...]) -> None:
    """Ranges in SI, a gaussian's pair as (mean, std), from the fit as fitted -+ sigma std."""
    text = hip(f", identified: r.yaml, randomize: {{{field}: {entry}}}")
    results = "{hip: {kp: {value: 30, std: 2}, kd: {value: 0.2, std: 0.3}, encoder_bias: {value: 0.01 rad, "
    results += "std: 0.03 rad}}}"
    (found,) = joint(text, results=results).randomize
    drawn = (found.operation, found.low, found.high, found.distribution, found.when, found.every, found.per)
    assert found.field == field
    assert drawn[0] == expected[0]
    assert drawn[1:3] == pytest.approx(expected[1:3])
    assert drawn[3:] == expected[3:]


def test_randomized_in_the_other_joints_unit() -> None:
    """An offset in N/m at a hinge is refused, once for both ends."""
    assert refused(hip(", randomize: {kp: {add: [0, 1 N/m]}}")) == [
        "RES001 actuators.legs.randomize.kp.add: hip: the range of kp has 1 N/m, which does not fit a hinge joint"
    ]


def test_one_number_in_the_wrong_unit_is_told_once() -> None:
    """With all joints that have it: a gain, a position, a range; and a motor's figure once for all groups."""
    text = spec_of(
        "legs: {joints: [hip, calf], level: ideal_pd, kp: 25 N/m, kd: 0.5, command_range: [0 m, 1 m], motor: m}, "
        "arm: {joints: [elbow], level: ideal_pd, kp: 25, kd: 0.5, motor: m}",
        robot="name: leg, model: none, joints: [hip, calf, elbow]",
        motors="{m: {side: joint, peak_torque: 40 N}}",
    )
    assert refused(text) == [
        "RES001 motors.m.peak_torque: peak_torque is 40 N, but its shaft turns, on the way to 'hip', a hinge joint",
        "RES001 actuators.legs.kp: hip, calf: kp is given as 25 N/m, which does not fit a hinge joint",
        "RES001 actuators.legs.command_range: hip, calf: command_range is given as 0 m, which does not fit a hinge "
        "joint",
    ]
    posed = hip("").replace(HIP, f"{HIP}, default_pose: {{hip: 1 m}}")
    assert refused(posed) == [
        "RES001 robot.default_pose.hip: hip: the default position is 1 m, which does not fit a hinge joint"
    ]


def test_network_and_delta_action() -> None:
    """Files are relative to the spec's folder; the delta action concerns the whole robot."""
    text = spec_of(
        "legs: {joints: [hip], level: actuator_net, network: {file: nets/a.pt, manifest: nets/a.json}}",
        robot=HIP,
        more="delta_action: {manifest: nets/d.json}",
    )
    found = fit(text)
    network = found.joints[0].network
    assert network is not None and found.delta_action is not None
    assert (network.file, network.manifest) == ("nets/a.pt", "nets/a.json")
    assert found.delta_action.manifest == "nets/d.json"
    assert (found.joints[0].kp, found.joints[0].kd) == (None, None)


def test_gains_beside_a_network_are_derived_too() -> None:
    """What the network is compared with: 0.5 x 20 N*m / 0.1 rad = 100; 2 x 0.5 x sqrt(100 x 0.01) = 1."""
    gains = (
        "effort_limit: 20 N*m, armature: 0.01 kg*m^2, "
        "kp: {derive: torque_at_error, fraction: 50 %, error: 0.1 rad}, "
        "kd: {derive: damping_ratio, ratio: 0.5, inertia: reflected}"
    )
    text = spec_of(
        f"legs: {{joints: [hip], level: actuator_net, network: {{file: a.pt, manifest: a.json}}, {gains}}}",
        robot=HIP,
    )
    hip = fit(text).joints[0]
    assert hip.kp is not None and hip.kp.value == pytest.approx(100.0)
    assert hip.kd is not None and hip.kd.value == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("timing", "value", "origin", "lost"),
    [
        pytest.param(
            "timing: {physics_dt: 5 ms, decimation: 4}", 0.005, Origin.AUTHORED, [0.001], id="authored"
        ),
        pytest.param("", 0.001, Origin.MODEL, [], id="the file's"),
        pytest.param("timing: {physics_dt: unknown}", 0.001, Origin.MODEL, [], id="unknown keeps the file's"),
    ],
)
def test_physics_dt(timing: str, value: float, origin: Origin, lost: list[float]) -> None:
    """The step is authored, else the file's."""
    text = spec_of(
        "legs: {joints: [hip], level: ideal_pd, kp: 1, kd: 1}",
        robot="name: leg, model: robot.xml",
        more=timing,
    )
    found = fit(text, MODEL).physics_dt
    assert (found.value, found.origin, [loser.value for loser in found.lost]) == (value, origin, lost)


def test_physics_dt_without_a_file() -> None:
    """Without spec or file it is MuJoCo's 2 ms, of origin default."""
    found = fit(hip("")).physics_dt
    assert (found.value, found.origin) == (0.002, Origin.DEFAULT)


@pytest.mark.parametrize(
    ("timing", "decimation", "period"),
    [
        ("", None, None),
        # 4 x 5 ms.
        ("{physics_dt: 5 ms, decimation: 4}", 4, 0.02),
        # Steps of MuJoCo's 2 ms, which nobody stated, would be 8 ms.
        ("{decimation: 4}", 4, None),
        ("{control_dt: 20 ms}", 10, 0.02),
        ("{physics_dt: 5 ms, control_dt: 20 ms}", 4, 0.02),
        # 33.3 / 16.7 and 16.7 / 8.33 are two, written with three digits, and 20 / 3.33 six.
        ("{physics_dt: 16.7 ms, control_dt: 33.3 ms}", 2, 33.3 * 1e-3),
        ("{physics_dt: 8.33 ms, control_dt: 16.7 ms}", 2, 0.0167),
        ("{physics_dt: 3.33 ms, control_dt: 20 ms}", 6, 0.02),
        # 25 / 2 steps of the default are no whole number, and nobody stated them.
        ("{control_dt: 25 ms}", None, 0.025),
        ("{physics_dt: 5 ms, control_dt: unknown}", None, None),
    ],
)
def test_control_period(timing: str, decimation: int | None, period: float | None) -> None:
    """It is stated, or so many steps of a length that somebody states."""
    found = fit(hip("") + (f"timing: {timing}\n" if timing else ""))
    assert (found.decimation, found.control_period) == (decimation, period)


def test_the_control_period_is_said_once() -> None:
    """Decimation and control_dt are one number."""
    timing = "timing: {physics_dt: 5 ms, decimation: 4, control_dt: 20 ms}\n"
    assert faults_of(hip("") + timing) == [
        "SPEC125 timing.control_dt: decimation and control_dt are both given"
    ]


@pytest.mark.parametrize(
    ("timing", "said"),
    [
        (
            "{physics_dt: 0.5 ms, control_dt: 1.2 ms}",
            (
                "1.2 ms is 2.4 physics steps of 0.5 ms: simulators take whole ones",
                "write 1 ms (2 steps) or 1.5 ms (3 steps), or a physics_dt that divides it",
            ),
        ),
        (
            "{physics_dt: 3 ms, control_dt: 20 ms}",
            (
                "20 ms is 6.667 physics steps of 3 ms: simulators take whole ones",
                "write 18 ms (6 steps) or 21 ms (7 steps), or a physics_dt that divides it",
            ),
        ),
        (
            "{physics_dt: 0.5 ms, control_dt: 0.1 ms}",
            (
                "0.1 ms is less than one physics step of 0.5 ms",
                "are the two exchanged? Else write 0.5 ms or a multiple of it",
            ),
        ),
        (
            "{physics_dt: 2 ms, control_dt: 1.5 ms}",
            ("1.5 ms is less than one physics step of 2 ms", "write 2 ms or a multiple of it"),
        ),
        ("{physics_dt: 2 ms, control_dt: 2 ms}", None),
        # A step of 5 s, and a period of 0.7 s, are told themselves (SPEC186).
        ("{physics_dt: {value: 5 s, sure: true}, control_dt: 20 ms}", None),
        ("{physics_dt: 5 ms, control_dt: {value: 0.701 s, sure: true}}", None),
        # A thousand steps and a half.
        (
            "{physics_dt: 0.1 ms, control_dt: 100.05 ms}",
            (
                "100.05 ms is 1000.5 physics steps of 0.1 ms: simulators take whole ones",
                "write 100 ms (1000 steps) or 100.1 ms (1001 steps), or a physics_dt that divides it",
            ),
        ),
    ],
)
def test_a_control_period_is_a_whole_number_of_steps(timing: str, said: tuple[str, str] | None) -> None:
    """SPEC126 at `control_dt`, with the nearest that are."""
    text = hip("") + f"timing: {timing}\n"
    if said is None:
        fit(text)
        return
    with pytest.raises(SpecError) as caught:
        fit(text)
    (item,) = caught.value.diagnostics
    assert (item.code, item.where, item.message, item.help) == ("SPEC126", "timing.control_dt", *said)
    assert item.span is not None and item.span.line == text.count("\n")


@pytest.mark.parametrize(
    ("control", "said"),
    [
        # A tenth of the model's own 1 ms; 2.5 of them are not the spec's, and a simulator of the policy has its own.
        ("0.1 ms", ["SPEC126 timing.control_dt: 0.1 ms is less than one physics step of the model, 1 ms"]),
        ("2.5 ms", []),
        ("1 ms", []),
    ],
)
def test_a_control_period_within_a_step_of_the_model(control: str, said: list[str]) -> None:
    """A warning: the model's own step need not be that of the training."""
    text = spec_of(
        "legs: {joints: [hip], level: ideal_pd, kp: 1, kd: 1}",
        robot="name: leg, model: robot.xml",
        more=f"timing: {{control_dt: {control}}}\n",
    )
    found = [item for item in fit(text, MODEL).diagnostics if item.code == "SPEC126"]
    assert [f"{item.code} {item.where}: {item.message}" for item in found] == said
    assert {item.severity for item in found} <= {Severity.WARNING}


def test_values_keep_source_std_and_place() -> None:
    """Provenance travels with each number."""
    found = joint(
        hip("", "kp: {value: 25, source: s, std: 2, note: measured}, kd: 0") + "sources: {s: {title: T}}"
    ).kp
    assert found is not None and found.span is not None
    assert (found.source, found.std, found.note) == ("s", 2.0, "measured")
    assert (found.span.path, found.span.line) == ("s.yaml", 4)


def test_sources_and_accept_reach_the_ir() -> None:
    """What numbers and approximations refer to is in the IR."""
    text = hip("") + "sources: {s: {title: T, page: 3}}\naccept: {mujoco.delay: short enough}"
    found = fit(text)
    assert [(s.key, s.title, s.page) for s in found.sources] == [("s", "T", "3")]
    assert found.accept == (("mujoco.delay", "short enough"),)
    assert model_of(text).accept == {"mujoco.delay": "short enough"}
