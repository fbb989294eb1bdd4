"""What a spec must fulfil beyond the type of each field; the messages themselves are in tests/errors."""

from __future__ import annotations

import re

import pytest

from actspec.diagnostics import SpecError
from tests.fitting import NONE, faults_of, model_of, spec_of

LEGS = "legs: {joints: [hip], level: %s, kp: 1, kd: 1%s}"


def said(
    level: str = "ideal_pd", extra: str = "", motors: str = "{}", more: str = "", robot: str = NONE
) -> list[str]:
    """Code and place of every breach; nothing for a valid spec."""
    text = spec_of(LEGS % (level, extra), motors=motors, more=more, robot=robot)
    try:
        model_of(text)
    except SpecError:
        return [fault.split(":")[0] for fault in faults_of(text)]
    return []


@pytest.mark.parametrize(
    ("motor", "expected"),
    [
        pytest.param("{side: joint, peak_torque: 1}", [], id="joint side needs no gear"),
        pytest.param("{side: motor, gear_ratio: 9, peak_torque: 1}", [], id="motor side with gear"),
        pytest.param("{side: motor, peak_torque: 1}", ["SPEC131 motors.m.side"], id="motor side without"),
        pytest.param("{side: motor, note: nothing sided}", [], id="nothing to convert"),
        pytest.param("{gear_ratio: 9, rotor_inertia: 1e-4}", [], id="inertia needs no side"),
        pytest.param("{rotor_inertia: 1e-4}", ["SPEC131 motors.m.rotor_inertia"], id="inertia without gear"),
        pytest.param(
            "{gear_ratio: unknown, rotor_inertia: 1e-4}",
            ["SPEC131 motors.m.rotor_inertia"],
            id="gear unknown",
        ),
        pytest.param("{gear_ratio: unknown, rotor_inertia: unknown}", [], id="both unknown"),
        pytest.param("{reflected_inertia: 0.01}", [], id="output inertia"),
        pytest.param("{peak_torque: 1}", ["SPEC130 motors.m"], id="no side"),
        pytest.param("{side: joint, peak_torque: 1, continuous_torque: 1}", [], id="equal limits"),
        pytest.param("{side: joint, peak_torque: unknown, continuous_torque: 1}", [], id="peak unknown"),
        pytest.param(
            "{side: motor, gear_ratio: 9, efficiency: unknown, peak_torque: 1}",
            ["SPEC131 motors.m.efficiency"],
            id="efficiency unknown",
        ),
        pytest.param(
            "{side: motor, gear_ratio: 9, efficiency: unknown, no_load_speed: 1 rad/s}",
            [],
            id="no torque to scale",
        ),
    ],
)
def test_motor(motor: str, expected: list[str]) -> None:
    """Sides need gears, gears need to be known, and limits stand in order."""
    assert said(motors=f"{{m: {motor}}}") == expected


LINE = "side: joint, stall_torque: %s, no_load_speed: %s"


@pytest.mark.parametrize(
    ("motor", "expected"),
    [
        pytest.param(LINE % ("20", "10 rad/s"), [], id="line"),
        pytest.param(LINE % ("unknown", "10 rad/s"), ["SPEC147 motors.m.stall_torque"], id="stall unknown"),
        pytest.param("side: joint, stall_torque: 20", ["SPEC147 actuators.legs"], id="no speed"),
        pytest.param(
            "side: joint, curve: {drive_torque: 1, brake_torque: 1, knee_speed: 0, no_load_speed: 9 rad/s}",
            [],
            id="curve",
        ),
        pytest.param(
            "side: joint, curve: {drive_torque: 1, brake_torque: unknown, knee_speed: 0, no_load_speed: 9 rad/s}",
            ["SPEC147 motors.m.curve.brake_torque"],
            id="curve with a gap",
        ),
    ],
)
def test_dc_motor(motor: str, expected: list[str]) -> None:
    """A DC motor needs its whole line or curve."""
    assert said("dc_motor", ", motor: m", f"{{m: {{{motor}}}}}") == expected


def test_dc_motor_by_override() -> None:
    """The motor that an override names needs its line too."""
    motors = "{m: {%s}, n: {side: joint, peak_torque: 1}}" % (LINE % ("20", "10 rad/s"))
    assert said("dc_motor", ", motor: m, overrides: {hip: {motor: n}}", motors) == [
        "SPEC147 actuators.legs.overrides.hip",
        "SPEC147 actuators.legs.overrides.hip",
    ]


def test_dc_motor_without_its_motor() -> None:
    """One line is missing, and one message says so, whatever else is to be the motor's."""
    fields = ", effort_limit: peak, command_filter: from_motor, overrides: {hip: {effort_limit: peak}}"
    assert said("dc_motor", fields, "{}") == ["SPEC147 actuators.legs"]


@pytest.mark.parametrize(
    ("motor", "word", "expected"),
    [
        pytest.param("peak_torque: 1", "peak", [], id="peak"),
        pytest.param(
            "peak_torque: 1", "continuous", ["SPEC144 actuators.legs.effort_limit"], id="no continuous"
        ),
        pytest.param("torque_constant: 1, nominal_current: 1", "continuous", [], id="by current"),
        pytest.param(
            "torque_constant: unknown, nominal_current: 1",
            "continuous",
            ["SPEC144 actuators.legs.effort_limit"],
            id="constant unknown",
        ),
        pytest.param(
            "continuous_torque: unknown, torque_constant: 1, nominal_current: 1",
            "continuous",
            ["SPEC144 actuators.legs.effort_limit"],
            id="unknown is an answer",
        ),
    ],
)
def test_effort_words(motor: str, word: str, expected: list[str]) -> None:
    """`peak` and `continuous` need the motor's figure."""
    assert (
        said(extra=f", motor: m, effort_limit: {word}", motors=f"{{m: {{side: joint, {motor}}}}}") == expected
    )


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        pytest.param("accept: {mujoco.delay: why}", [], id="the default target"),
        pytest.param("targets: {isaaclab: {}}\naccept: {isaaclab.delay: why}", [], id="a named one"),
        pytest.param(
            "targets: {isaaclab: {}}\naccept: {mujoco.delay: why}",
            ["SPEC162 accept.mujoco.delay"],
            id="another",
        ),
        pytest.param("targets: {mine: {target: mjlab}}\naccept: {mine.delay: why}", [], id="a free name"),
        pytest.param("accept: {spec.SPEC999: why}", ["SPEC162 accept.spec.SPEC999"], id="no such check"),
        pytest.param(
            "accept: {spec.spec183: why}", ["SPEC162 accept.spec.spec183"], id="a check in small letters"
        ),
        pytest.param("accept: {spec.STB102: why}", ["SPEC162 accept.spec.STB102"], id="a rule of the audit"),
        pytest.param("accept: {spec.SPEC183: why}", [], id="a check"),
        pytest.param("accept: {SPEC183: why}", ["SPEC162 accept.SPEC183"], id="a check without `spec.`"),
        pytest.param("accept: {mujoco: why}", ["SPEC162 accept.mujoco"], id="no field"),
        pytest.param("accept: {mujoco.delay: ' '}", ["SPEC162 accept.mujoco.delay"], id="no reason"),
        pytest.param("targets: {'': {target: mujoco}}", ["SPEC161 targets."], id="empty name"),
        pytest.param("targets: {..: {target: mujoco}}", ["SPEC161 targets..."], id="dots"),
        pytest.param(
            "targets: {mjlab: {class: custom}}", ["SPEC163 targets.mjlab.class"], id="another's class"
        ),
        pytest.param(
            "targets: {a: {target: mujoco, for: [json]}}", ["SPEC163 targets.a.for"], id="another's for"
        ),
        pytest.param(
            'targets: {deploy: {version: "1"}}', ["SPEC163 targets.deploy.version"], id="no version"
        ),
        pytest.param(
            'targets: {isaaclab: {joint_order: [hip]}, mjlab: {isaac_sim: "5.1", backend: newton}}',
            [
                "SPEC163 targets.isaaclab.joint_order",
                "SPEC163 targets.mjlab.isaac_sim",
                "SPEC163 targets.mjlab.backend",
            ],
            id="three",
        ),
        pytest.param(
            'targets: {isaaclab: {version: "3.0", isaac_sim: "6.0", backend: newton, class: auto}, '
            'randomization: {for: [isaaclab], version: "3.0", isaac_sim: "6.0", backend: newton}, '
            'deploy: {joint_order: [hip]}, mujoco: {version: "3.12"}, mjlab: {version: "1.6"}}',
            [],
            id="one's own",
        ),
    ],
)
def test_targets(more: str, expected: list[str]) -> None:
    """`accept` names a target of the spec; a target's name is a folder's name, and its options are its kind's."""
    assert said(more=more) == expected


@pytest.mark.parametrize(
    ("entry", "expected"),
    [
        pytest.param("kp: {scale: [0, 2]}", [], id="from 0"),
        pytest.param("kp: {add: [-1, 1]}", [], id="an offset may be negative"),
        pytest.param("kp: {abs: [-1, 1]}", ["SPEC153 actuators.legs.randomize.kp.abs[0]"], id="a gain may not"),
        pytest.param("encoder_bias: {abs: [-1 rad, 1 rad]}", [], id="a bias may"),
        pytest.param("kp: {scale: [1, 0.1], distribution: gaussian}", [], id="mean and std"),
        pytest.param(
            "kp: {scale: [-1, 0.1], distribution: gaussian}",
            ["SPEC153 actuators.legs.randomize.kp.scale[0]"],
            id="negative mean",
        ),
        pytest.param("kp: {scale: [1, 0.1]}", ["SPEC153 actuators.legs.randomize.kp.scale"], id="inverted"),
        pytest.param("strength: {from: identified}", ["SPEC146 actuators.legs.randomize.strength",
                     "SPEC152 actuators.legs.randomize.strength.from"], id="not fitted"),
    ],
)  # fmt: skip
def test_randomize(entry: str, expected: list[str]) -> None:
    """One range, in order, of the sign that the field can have."""
    assert sorted(said(extra=f", randomize: {{{entry}}}")) == expected


def test_a_factor_around_0() -> None:
    """0.1 around 0 is meant around 1."""
    text = spec_of(LEGS % ("ideal_pd", ", randomize: {kp: {scale: [-0.1, 0.1]}}"))
    with pytest.raises(SpecError) as caught:
        model_of(text)
    (found,) = caught.value.diagnostics
    assert found.help == "a factor is one of the nominal value: did you mean [0.9, 1.1]?"


@pytest.mark.parametrize(
    "legs, motor, help",
    [
        ("", "kt: 0.1", "a motor's torque per ampere is `torque_constant`"),
        ("", "backlash: 0.001", "nothing is made of it: keep it in `note`, or leave it out"),
        (", motor: AK80-9", "peak_torque: 18", "did you mean 'ak80_9'?"),
    ],
)
def test_names_of_datasheets(legs: str, motor: str, help: str) -> None:
    """Their own spelling has its answer, not the list of all keys."""
    text = spec_of(LEGS % ("ideal_pd", legs), motors=f"{{ak80_9: {{side: joint, {motor}}}}}")
    with pytest.raises(SpecError) as caught:
        model_of(text)
    assert [found.help for found in caught.value.diagnostics] == [help]


def test_a_word_with_a_comment_of_another_language() -> None:
    """What stands behind the word is told to be a comment."""
    with pytest.raises(SpecError) as caught:
        model_of(spec_of(LEGS % ("ideal_pd // as built", "")))
    (found,) = caught.value.diagnostics
    assert found.help == "a comment begins with a space and `#`: write `ideal_pd # as built`"


def test_rules_are_checked_beside_faults_of_shape() -> None:
    """A misspelt key in one group hides no breach in another, nor does a wrong section."""
    text = spec_of(
        f"{LEGS % ('ideal_pd', ', motor: none')}, arms: {{joints: [calf], level: ideal_pd, kpp: 1}}",
        motors="{m: {side: motor, peak_torque: 1}}",
        more="timing: 5",
    )
    assert [fault.split(":")[0] for fault in faults_of(text)] == [
        "SPEC131 motors.m.side",
        "SPEC141 actuators.legs.motor",
        "SPEC101 actuators.arms.kpp",
        "SPEC106 timing",
    ]


def test_faults_of_shape_have_no_false_consequences() -> None:
    """What refers to a faulty part is not blamed for it."""
    text = spec_of(
        "legs: {joints: [hip], level: dc_motor, motor: m, effort_limit: peak, kp: {value: 1, source: s}}",
        motors="{m: {side: joint, stall_torqe: 1, peak_torque:}}".replace("peak_torque:}", "peak_torque: }"),
        more="sources: {s: {}}\ntargets: {mine: 3}\naccept: {mine.delay: why}",
    )
    assert [fault.split(":")[0] for fault in faults_of(text)] == [
        "SPEC101 motors.m.stall_torqe",
        "SPEC103 motors.m.peak_torque",
        "SPEC104 sources.s",
        "SPEC106 targets.mine",
    ]


@pytest.mark.parametrize(
    ("motor", "limit", "help"),
    [
        (
            "peak_torque: 18 N*m, no_load_speed: 60 rad/s",
            "",
            "`stall_torque: 18 N*m`, its peak torque, gives no more",
        ),
        (
            "continuous_torque: 9 N*m, no_load_speed: 60 rad/s",
            "",
            "state it (or `curve`), or use level ideal_pd",
        ),
        (
            "stall_torque: 22 N*m, no_load_speed: 60 rad/s",
            "peak",
            "its stall_torque, 22 N*m, where the drive has the cur",
        ),
    ],
    ids=["no stall torque", "neither", "no peak torque"],
)
def test_a_datasheet_without_one_of_the_torques(motor: str, limit: str, help: str) -> None:
    """The other torque of the sheet is offered, and what it assumes."""
    extra = ", motor: m" + (f", effort_limit: {limit}" if limit else "")
    text = spec_of(LEGS % ("dc_motor", extra), motors=f"{{m: {{side: joint, {motor}}}}}", robot=NONE)
    with pytest.raises(SpecError) as caught:
        model_of(text)
    (found,) = caught.value.diagnostics
    assert found.code == ("SPEC144" if limit else "SPEC147")
    assert help in str(found.help)


@pytest.mark.parametrize(
    ("field", "ends", "meant"),
    [
        ("kp", "[32, 48]", "abs: [32, 48]"),
        ("kp", "[0.9, 1.1]", "scale: [0.9, 1.1]"),
        ("kp", "[{value: 32}, {value: 48}]", "abs: [{value: 32}, {value: 48}]"),
        # A gain is never below 0.
        ("kp", "[-5 N*m/rad, 5 N*m/rad]", "add: ['-5 N*m/rad', '5 N*m/rad']"),
        ("kp", "{scale: [-5 N*m/rad, 5 N*m/rad]}", "add: ['-5 N*m/rad', '5 N*m/rad']"),
        ("delay", "[-1 ms, 1 ms]", "add: ['-1 ms', '1 ms']"),
        ("encoder_bias", "[-0.5 deg, 0.5 deg]", "abs: ['-0.5 deg', '0.5 deg']"),
        # A position has a unit, and 0 times 1.1 stays 0.
        ("encoder_bias", "[-0.02, 0.02]", None),
        ("encoder_bias", "[0.9, 1.1]", None),
        ("kp", "[]", None),
        ("gains", "[]", None),
        ("kp", "[32, 40, 48]", None),
        ("kp", "[80 %, 48]", None),
        ("kp", "{scale: [80 %, 48 N*m/rad]}", None),
        ("kp", "[48, 32]", None),
        ("gains", "[-0.1, 0.1]", None),
        ("strength", "[20 N*m, 30 N*m]", None),
    ],
)
def test_a_range_without_its_operation_is_offered_one_that_takes_it(
    field: str, ends: str, meant: str | None
) -> None:
    """Where no operation takes the numbers, none is offered."""
    legs = "legs: {joints: [hip], level: ideal_pd, kp: 40, kd: 1, delay: 2 ms, randomize: {%s: %s}}"
    with pytest.raises(SpecError) as caught:
        model_of(spec_of(legs % (field, ends)))
    (fault,) = caught.value.diagnostics
    offered = re.search(r"write `\{?((?:scale|abs|add): .*\])\}?`", fault.help or "")
    assert (offered and offered[1]) == meant
    if meant is not None:
        model_of(spec_of(legs % (field, f"{{{meant}}}")))
