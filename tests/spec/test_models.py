"""The language as a whole: the design's example, defaults, unions, and the models' own rules."""

from __future__ import annotations

import copy
from dataclasses import replace
from typing import Any

import pytest
from pydantic import BaseModel, ValidationError

from actspec.diagnostics import SpecError
from actspec.spec.document import document_from_text
from actspec.spec.fields import DerivedGain
from actspec.spec.gears import Linkage
from actspec.spec.models import CommandFilter, ListedJoint, SpecModel, Target
from actspec.spec.schema import descriptions
from actspec.spec.validate import validate
from actspec.spec.values import SpecValue, Strict
from tests.fitting import faults_of, model_of, spec_of

EVERYTHING = """
actspec: 1
robot:
  name: unitree_a1
  model: a1/a1.xml
  unmanaged: ["gripper_.*"]
  default_pose: {".*_calf_joint": -1.8 rad}
timing: {physics_dt: 5 ms, decimation: 4}
sources: {a1_manual: {title: A1 manual, url: https://example.org, page: 3, commit: "0012", accessed: 2026-11-21}}
motors:
  a1_joint:
    side: motor
    stall_torque: {value: 33.5 N*m, source: a1_manual}
    no_load_speed: 21 rad/s
    peak_torque: 33.5 N*m
    continuous_torque: unknown
    gear_ratio: 9.1
    efficiency: 90 %
    torque_constant: 0.1 N*m/A
    nominal_voltage: 24 V
    nominal_current: 10 A
    peak_current: 40 A
    rotor_inertia: 100 g*cm^2
    bandwidth: 30 Hz
  curved:
    side: joint
    curve: {drive_torque: 20 N*m, brake_torque: 25 N*m, knee_speed: 10 rad/s, no_load_speed: 20 rad/s}
    reflected_inertia: 0.01 kg*m^2
  screw:
    side: motor
    peak_torque: 1 N*m
    rotor_inertia: 100 g*cm^2
    gearbox:
      - {planetary: {sun: 18, ring: 46}, efficiency: 0.95, inertia: 3 g*cm^2}
      - {teeth: {driving: 20, driven: 60}}
      - {lead: 5 mm/rev}
linkages:
  ankle:
    joints: [pitch, roll]
    motors: [screw, screw]
    jacobian: [[40 mm/rad, 20 mm/rad], [40 mm/rad, -20 mm/rad]]
    at: [0.1 rad, 0]
    limits: together
    source: a1_manual
  waist:
    joints: [yaw]
    motors: [screw]
    table: [{at: [0], jacobian: [[35 mm/rad]]}, {at: [20 deg], jacobian: [[30 mm/rad]]}]
  neck: {joints: [nod], motors: [curved], factor: 1}
actuators:
  legs:
    joints: [".*_hip_joint", ".*_thigh_joint", ".*_calf_joint"]
    motor: a1_joint
    reduction: 1
    motors_per_joint: 1
    level: dc_motor
    command: position
    kp: identified
    kd: {derive: damping_ratio, ratio: 2, inertia: reflected}
    effort_limit: continuous
    velocity_limit: 200 rpm
    armature: 0.01 kg*m^2
    friction: {coulomb: 0.2 N*m, viscous: 0.01 N*m*s/rad, static: 0.25 N*m, stribeck_velocity: 0.1 rad/s}
    command_filter: from_motor
    command_range: joint
    delay: {nominal: 5 ms, range: [0 ms, 10 ms], sampling: episode}
    encoder_bias: 0 rad
    action_scale: 0.25
    identified: results/a1_legs.yaml
    overrides: {".*_calf_joint": {effort_limit: 35.55 N*m}}
    randomize:
      kp: {scale: [0.75, 1.5]}
      gains: {scale: [0.9, 1.1]}
      strength: {scale: [1.0, 0.05], distribution: gaussian}
      kd: {from: identified, sigma: 2}
      friction.stribeck_velocity: {abs: [0.1 rad/s, 0.2 rad/s]}
      delay: {add: [0, 5 ms], when: interval, every: [5 s, 10 s], per: env}
  feet:
    joints: [pitch, roll]
    level: ideal_pd
  lift:
    joints: [lift]
    motor: a1_joint
    transmission: [{ratio: 2}, {radius: 20 mm}]
    level: ideal_pd
  knee:
    joints: [knee]
    motor: screw
    transmission: [{lever_arm: 45 mm}]
    level: ideal_pd
  arms:
    joints: [".*_arm"]
    level: actuator_net
    network: {file: nets/a1.pt, manifest: nets/a1.json}
delta_action: {manifest: nets/a1_delta.json}
targets:
  mujoco: {version: "3.12"}
  old: {target: mujoco, version: "3.3"}
  isaaclab: {version: "2.3", isaac_sim: "5.1", class: auto}
  mjlab: {version: "1.6"}
  randomization: {for: [isaaclab, mjlab, json]}
accept: {isaaclab.command_filter: "the policy runs far below it"}
"""


def continuous_known(text: str) -> str:
    """The example asks for `continuous`, so the motor must state it."""
    return text.replace("continuous_torque: unknown", "continuous_torque: 12 N*m")


def test_the_whole_language() -> None:
    """Every key of the design's example is read, to SI."""
    model = model_of(continuous_known(EVERYTHING))
    legs = model.actuators["legs"]
    assert model.timing.physics_dt is not None and model.timing.physics_dt.value == 0.005
    assert model.motors["a1_joint"].rotor_inertia is not None
    assert model.motors["a1_joint"].rotor_inertia.value == 1e-5
    assert (model.sources["a1_manual"].page, model.sources["a1_manual"].commit) == ("3", "0012")
    assert isinstance(legs.kp, SpecValue) and legs.kp.identified
    assert isinstance(legs.kd, DerivedGain)
    assert legs.effort_limit == "continuous"
    assert legs.randomize["kd"].from_ == "identified"
    assert model.targets["isaaclab"].class_ == "auto"
    assert model.targets["randomization"].for_ == ("isaaclab", "mjlab", "json")


def test_every_key_was_in_the_example() -> None:
    """No model has a key that the example leaves out, but these."""
    text = set(EVERYTHING.replace("{", " ").replace("}", " ").replace(",", " ").split())
    left_out = {
        alias
        for model in (*Strict.__subclasses__(), Target)
        if model.__module__ in (SpecModel.__module__, Linkage.__module__)
        for name, field in model.model_fields.items()
        if f"{(alias := field.alias or name)}:" not in text
    }
    assert left_out == {
        *("note", "include", "kind", "backend", "joint_order", "joint_paths", "root", "cutoff"),
        *("variant", "variants", "packages", "control_dt"),
    }


def test_filter_forms() -> None:
    """A filter is a mapping or one of two words."""
    for written, kind in (("{cutoff: 30 Hz}", CommandFilter), ("none", str)):
        model = model_of(spec_of(f"a: {{joints: [x], level: ideal_pd, command_filter: {written}}}"))
        assert isinstance(model.actuators["a"].command_filter, kind)


def test_listed_joints() -> None:
    """A robot without a model lists joints by name or with kind and range."""
    robot = "name: r, model: none, joints: [a, {name: b, kind: slide, range: [0, 1 m]}]"
    first, second = model_of(spec_of("g: {joints: [x], level: ideal_pd}", robot=robot)).robot.joints
    assert first == "a"
    assert isinstance(second, ListedJoint) and (second.name, second.kind) == ("b", "slide")


def test_only_an_sdks_order_may_have_gaps() -> None:
    """`null` is a number without a joint in `joint_order`, and a forgotten value everywhere else."""
    spec = spec_of("g: {joints: [x], level: ideal_pd}") + "targets: {deploy: {joint_order: [b, null, a]}}\n"
    assert model_of(spec).targets["deploy"].joint_order == ("b", None, "a")
    bad = spec.replace("[b, null, a]", "null").replace("[x]", "[x, null]")
    assert [fault.rpartition(":")[0] for fault in faults_of(bad)] == [
        "SPEC103 actuators.g.joints[1]",
        "SPEC103 targets.deploy.joint_order",
    ]


def test_models_are_frozen_and_strict() -> None:
    """A spec does not change after it was read, and takes no unknown key."""
    model = model_of(continuous_known(EVERYTHING))
    with pytest.raises(ValidationError):
        model.robot.name = "other"
    for part in Strict.__subclasses__():
        assert part.model_config["extra"] == "forbid"
        assert part.model_config["frozen"]


def _fields() -> list[Any]:
    return [
        pytest.param(model, name, id=f"{model.__name__}.{name}")
        for model in (*Strict.__subclasses__(), Target)
        for name in model.__annotations__
        if name in model.model_fields
    ]


@pytest.mark.parametrize(("model", "field"), _fields())
def test_every_field_is_described(model: type[BaseModel], field: str) -> None:
    """A field's docstring ends in a full stop and is no repetition of its name."""
    text = descriptions(model)[field]
    assert text.endswith(".")
    assert text.rstrip(".").lower() != field.replace("_", " ")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        pytest.param(
            "actspec: 2", "SPEC102 actspec: the spec is written for version 2 of the language, this actspec reads "
            "version 1", id="newer",
        ),
        pytest.param("actspec: 0", "SPEC102 actspec: there is no version 0 of the language", id="older"),
        pytest.param('actspec: "1"', "SPEC106 actspec: must be a whole number, got '1'", id="text"),
        pytest.param("actspec: true", "SPEC106 actspec: must be a whole number, got true", id="truth value"),
        pytest.param("actspec: 1.0", "SPEC106 actspec: must be a whole number, got 1.0", id="fraction"),
    ],
)  # fmt: skip
def test_version(text: str, said: str) -> None:
    """The language's version is a whole number that this tool knows."""
    spec = spec_of("a: {joints: [x], level: ideal_pd, kp: 1}").replace("actspec: 1", text)
    assert faults_of(spec) == [said]


def test_a_newer_version_is_the_only_error() -> None:
    """Keys of a later language are not judged by this one."""
    assert len(faults_of("actspec: 7\nunheard_of: {}\n")) == 1


JUNK = (
    None,
    True,
    -1,
    1e400,
    "",
    "x\n",
    [],
    {},
    {"value": []},
    {"derive": {}},
    {"": 0},
)
"""What no key takes, or only some."""


def _paths(node: Any, path: tuple[str | int, ...] = ()) -> list[tuple[str | int, ...]]:
    below = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    return [path, *(found for key, value in below for found in _paths(value, (*path, key)))]


@pytest.mark.slow
@pytest.mark.parametrize("turn", range(4))
def test_junk_anywhere_is_no_crash(turn: int) -> None:
    """Whatever stands in place of any value, validation accepts it or gives diagnostics with places.

    Four of the eleven at each path: with paths as they come, every one stands in place of many kinds of value.
    """
    document = document_from_text(continuous_known(EVERYTHING), "s.yaml")
    for place, path in enumerate(_paths(document.data)[1:]):
        junk = JUNK[(place + 3 * turn) % len(JUNK)]
        data = copy.deepcopy(document.data)
        node: Any = data
        for part in path[:-1]:
            node = node[part]
        node[path[-1]] = copy.deepcopy(junk)
        try:
            validate(replace(document, data=data))
        except SpecError as err:
            assert all(item.span is not None and item.message for item in err.diagnostics)


@pytest.mark.parametrize(
    ("motor", "group", "more", "help"),
    [
        # 60 / (2 pi 100) = 0.095493.
        (
            "kv: 100 rpm/V",
            "kp: 1",
            "",
            "write it as `torque_constant`: a speed constant of 100 rpm/V is a torque constant of 0.095493 N*m/A",
        ),
        (
            "kv: 100",
            "kp: 1",
            "",
            "a motor's speed constant is stated as its inverse, `torque_constant`: 100 rpm/V is 0.0955 N*m/A",
        ),
        ("gear_ratio: 6", "kv: 1", "", "the drive's velocity gain is `kd`"),
        (
            "rated_speed: 3000 rpm",
            "kp: 1",
            "",
            "the speed under load is no key: `no_load_speed` is that without load, which is higher",
        ),
        (
            "gear_ratio: 6",
            "kp: 1",
            "timing: {control_period: 20 ms}",
            "the control period is `timing: {control_dt: ...}`, or `decimation` steps of `physics_dt`",
        ),
        ("gear_ratio: 6", "randomize: {damping: {scale: [0.9, 1.1]}}", "", "did you mean 'kd'?"),
        (
            "gear_ratio: 6",
            "kp: 1",
            "variants: [{name: long, timing: {decimation: 4}}]",
            "write `long: ...` without `- `",
        ),
    ],
)
def test_what_a_word_of_another_world_is_here(motor: str, group: str, more: str, help: str) -> None:
    """Words of datasheets, simulators and lists, each with the language's own."""
    text = (
        f"actspec: 1\nrobot: {{name: leg, model: none, joints: [hip]}}\nmotors: {{m: {{{motor}}}}}\n"
        f"actuators: {{legs: {{joints: [hip], level: ideal_pd, kd: 1, {group}}}}}\n{more}\n"
    )
    with pytest.raises(SpecError) as caught:
        validate(document_from_text(text, "s.yaml"))
    assert [item.help for item in caught.value.diagnostics] == [help]


LEGS = """actspec: 1
robot: {name: leg, model: none, joints: [hip]}
sources:
  servo: {title: "sheet"}
  screw: {title: "sheet"}
motors:
  servo: {side: joint, peak_torque: 3}
  screw: {side: joint, peak_torque: 3}
actuators:
  legs: {joints: ["hip"], level: ideal_pd, kp: 1, kd: 1, delay: {nominal: 3 ms, range: [1 ms, 6 ms]}}
targets: {mujoco: {version: "3.12"}}
"""


@pytest.mark.parametrize(
    ("old", "new", "where", "message", "help"),
    [
        (
            "motors:\n",
            "",
            "sources",
            "`servo`, `screw` are repeated in `sources`",
            "is the line of a section missing above this one? Else keep one of each",
        ),
        ("actspec: 1", "version: 1", "version", "unknown key 'version'", "did you mean 'actspec'?"),
        (
            "[1 ms, 6 ms]",
            "(1 ms, 6 ms)",
            "actuators.legs.delay.6 ms)",
            "stands behind a comma in ( )",
            "write the list in [ ]",
        ),
        ("kd: 1,", "kd: 1, <<: *arms,", "actuators.legs", "the merge key << is not", "use `overrides` for"),
        (
            "kd: 1,",
            "kd: 1, action_scale: 10 rad/s,",
            "actuators.legs.action_scale",
            "10 rad/s is a speed, not a ratio",
            "a ratio is a bare number or in %; write the number alone, in rad, rad/s or N*m",
        ),
        ('["hip"]', '("hip")', "actuators.legs.joints", "must be a list", 'write `["hip"]`'),
        ('["hip"]', "(hip|knee)", "actuators.legs.joints", "must be a list", 'write `["(hip|knee)"]`'),
        ('{version: "3.12"}', "3.12", "targets.mujoco", "must be a mapping", 'write `{version: "3.12"}`'),
        ('{version: "3.12"}', "implicit", "targets.mujoco", "must be a mapping", "its keys: backend, class"),
        (
            "kd: 1,",
            "kd: 1, randomize: {kp: {scale: 10 %}},",
            "actuators.legs.randomize.kp.scale",
            "must be [low, high], each a ratio, got 10 %",
            "write for instance `[0.9, 1.1]`",
        ),
    ],
)  # fmt: skip
def test_one_message_for_one_slip(old: str, new: str, where: str, message: str, help: str) -> None:
    with pytest.raises(SpecError) as caught:
        assert old in LEGS
        validate(document_from_text(LEGS.replace(old, new), "s.yaml"))
    (found,) = caught.value.diagnostics
    assert found.where == where
    assert found.message.startswith(message)
    assert (found.help or "").startswith(help)
