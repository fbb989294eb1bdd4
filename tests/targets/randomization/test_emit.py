"""The randomisation target's text: what is written, what is reported, what is refused."""

from __future__ import annotations

import ast
import json
import re
from pathlib import Path

import jsonschema
import pytest

from actspec.diagnostics import EmitError
from actspec.resolution import resolve
from actspec.robot.listed import listed_robot
from actspec.spec.document import document_from_text
from actspec.spec.validate import validate
from actspec.targets.base import Emission, TargetOptions
from actspec.targets.randomization.emit import STACKS, emit
from tests.fitting import spec_of

ROOT = Path(__file__).resolve().parents[3]

NUMBERS = "kp: 20, kd: 0.5, effort_limit: 30, armature: 0.01, friction: {coulomb: 0.2, viscous: 0.04}"
LEG = "name: leg, model: none, joints: [hip, calf]"


def made(randomize: str, *stacks: str, more: str = "", level: str = "ideal_pd", **options: str) -> Emission:
    """One group of two joints with ranges, for some stacks."""
    group = f"legs: {{joints: [hip, calf], level: {level}, {NUMBERS}, randomize: {{{randomize}}} {more}}}"
    motors = "{m: {side: joint, stall_torque: 30 N*m, no_load_speed: 20 rad/s}}"
    return compiled(spec_of(group, robot=LEG, motors=motors), *stacks, **options)


def compiled(text: str, *stacks: str, **options: str) -> Emission:
    """A spec's emission."""
    spec = validate(document_from_text(text, "s.yaml"))
    robot = listed_robot(spec)
    version = options.pop("version", "")
    chosen = TargetOptions("dr", "randomization", version, None, "out", stacks=stacks, **options)  # type: ignore[arg-type]
    return emit(resolve(spec, robot), robot, chosen)


def body(emission: Emission) -> str:
    """The first file without its header."""
    return emission.files[0].data.decode("utf-8").partition("\n\n")[2].strip()


def losses(emission: Emission, joint: str = "hip") -> dict[str, float | None]:
    """Field to size of what one joint loses."""
    return {item.field: item.max_torque_error for item in emission.approximations if item.joint == joint}


def test_isaaclab_text() -> None:
    """The whole class: one term for kp and kd with one setting, `operation` among the params, interval where asked."""
    emission = made(
        "kp: {scale: [0.75, 1.5]}, kd: {scale: [0.3, 3]}, "
        "armature: {abs: [0.005, 0.02], when: interval, every: [5 s, 10 s]}",
        "isaaclab",
    )
    assert emission.files[0].path == "leg_isaaclab_events.py"
    assert (
        body(emission)
        == '''import isaaclab.envs.mdp as mdp
from isaaclab.managers import EventTermCfg as EventTerm
from isaaclab.managers import SceneEntityCfg
from isaaclab.utils import configclass


@configclass
class EventCfg:
    """Domain randomization of the actuators."""

    legs_gains = EventTerm(
        func=mdp.randomize_actuator_gains,
        mode="reset",
        params={
            "asset_cfg": SceneEntityCfg("robot", joint_names=[".*"]),
            "stiffness_distribution_params": (0.75, 1.5),
            "damping_distribution_params": (0.3, 3.0),
            "operation": "scale",
            "distribution": "uniform",
        },
    )

    legs_armature = EventTerm(
        func=mdp.randomize_joint_parameters,
        mode="interval",
        interval_range_s=(5.0, 10.0),
        params={
            "asset_cfg": SceneEntityCfg("robot", joint_names=[".*"]),
            "armature_distribution_params": (0.005, 0.02),
            "operation": "abs",
            "distribution": "uniform",
        },
    )'''
    )
    assert emission.approximations == ()


def test_mjlab_text() -> None:
    """kd, which is not drawn, keeps its nominal: a factor of 1 under scale, the number under abs."""
    scaled = body(made("kp: {scale: [0.5, 2]}", "mjlab"))
    assert '"kp_range": (0.5, 2.0),\n      "kd_range": (1.0, 1.0),' in scaled
    assert '"asset_cfg": SceneEntityCfg("robot"),' in scaled
    absolute = body(made("kp: {abs: [10, 30]}", "mjlab"))
    assert '"kp_range": (10.0, 30.0),\n      "kd_range": (0.5, 0.5),' in absolute
    # 20 − 5 to 20 + 5: dr.pd_gains has no offset.
    assert '"kp_range": (15.0, 25.0)' in body(made("kp: {add: [-5, 5]}", "mjlab"))


def test_mjlab_configs_by_index() -> None:
    """With ranges for one of three configs its index is written, which no actuator name could give."""
    group = "joints: [{0}], level: ideal_pd, kp: {1}, kd: 1, effort_limit: 9"
    text = spec_of(
        f"a: {{{group.format('hip, calf', 10)}, overrides: {{calf: {{kp: 12}}}}}},"
        f"b: {{{group.format('toe', 10)}, randomize: {{kp: {{scale: [0.5, 2]}}}}}}",
        robot="name: leg, model: none, joints: [hip, calf, toe]",
    )
    assert 'SceneEntityCfg("robot", actuator_ids=[2])' in body(compiled(text, "mjlab"))


@pytest.mark.parametrize(
    "randomize, stack, expected",
    [
        # kp 20 · 0.02 rad.
        pytest.param("encoder_bias: {add: [-0.01 rad, 0.02 rad]}", "isaaclab",
                     {"isaaclab.encoder_bias": 0.4}, id="bias"),
        # 30 · 0.4.
        pytest.param("effort_limit: {scale: [0.8, 1.4]}", "isaaclab", {"isaaclab.effort_limit": 12.0}, id="limit"),
        # A step of half the limit, which one has and the other has not.
        pytest.param("delay: {abs: [0 ms, 10 ms]}", "isaaclab", {"isaaclab.delay": 15.0}, id="delay"),
        # kp 18, kd 0.55 against 18 and 0.45, at twice the speed where 0.45 takes the limit: 0.1 · 2 · 30/0.45.
        pytest.param("gains: {scale: [0.9, 1.1]}", "mjlab", {"mjlab.gains": 40 / 3}, id="gains apart"),
        # The same with the limit at 0.9 too: 0.1 · 2 · 27/0.45.
        pytest.param("strength: {scale: [0.9, 1.1]}", "mjlab", {"mjlab.strength": 12.0}, id="strength apart"),
        pytest.param("friction.static: {scale: [1, 1.5]}", "mjlab", {"mjlab.friction.static": 0.1}, id="static"),
        pytest.param("kp: {scale: [0.9, 1.1], per: env}", "mjlab", {"mjlab.kp": None}, id="shared"),
        pytest.param("kp: {scale: [1, 0.1], distribution: gaussian}", "mjlab", {"mjlab.kp": None}, id="gaussian"),
        pytest.param("kp: {scale: [1, 0.1], distribution: gaussian, when: startup, per: env}", "playground", {},
                     id="exact in Playground"),
        pytest.param("strength: {scale: [0.9, 1.1], per: env, when: startup}, armature: {abs: [0, 1], when: startup}",
                     "playground", {}, id="factors exact in Playground"),
        pytest.param("kp: {scale: [0.9, 1.1]}", "playground", {"playground.kp": None}, id="once"),
    ],
)  # fmt: skip
def test_losses_are_sized(randomize: str, stack: str, expected: dict[str, float | None]) -> None:
    """What a stack cannot draw is reported for each joint, with the torque by hand."""
    found = losses(made(randomize, stack))
    assert found == {key: value if value is None else pytest.approx(value) for key, value in expected.items()}
    assert losses(made(randomize, stack), "calf") == found


@pytest.mark.parametrize(
    "sim, words",
    [
        pytest.param("5.1", '"friction_distribution_params": (0.5, 1.5)', id="effort"),
        pytest.param("4.5", "    pass", id="no unit"),
    ],
)
def test_isaaclab_friction_by_simulator(sim: str, words: str) -> None:
    """Where friction has no unit the config leaves it out, so nothing is drawn, and that is said."""
    emission = made("friction.coulomb: {add: [-0.1, 0.1]}", "isaaclab", isaac_sim=sim)
    assert words in body(emission)
    # Coulomb 0.2 → 0.3; else the viscous part that moves along: 0.04 · 0.5 · 2 · 30/0.5.
    lost = {"isaaclab.friction.coulomb": 0.1} if sim == "4.5" else {
        "isaaclab.friction.coulomb": 0.2, "isaaclab.friction.viscous": 2.4}  # fmt: skip
    assert losses(emission) == {key: pytest.approx(value) for key, value in lost.items()}


def test_isaaclab_viscous_without_a_unit() -> None:
    """Viscous friction that stays: 0.04 to 0.08 at twice the speed at which kd takes the limit, 2 · 30/0.5."""
    emission = made("friction.viscous: {scale: [0.5, 2]}", "isaaclab", isaac_sim="4.5")
    assert losses(emission) == {"isaaclab.friction.viscous": pytest.approx(4.8)}


def test_factors_multiply_into_one_range() -> None:
    """kp has its own range and a factor: 0.5 · 0.9 to 2 · 1.1; kd has the factor alone."""
    emission = made("kp: {scale: [0.5, 2]}, gains: {scale: [0.9, 1.1]}", "isaaclab")
    assert '"stiffness_distribution_params": (0.45, 2.2),' in body(emission)
    assert '"damping_distribution_params": (0.9, 1.1),' in body(emission)
    assert losses(emission) == {"isaaclab.kp": None, "isaaclab.gains": pytest.approx(40 / 3)}


HOSTILE = ("a'\"\\n b", "#{{ x }}", 'x"); import os  #', "ünï.*", "{% raw %}")
"""Joint names that end literals, comments, templates and patterns."""


@pytest.mark.parametrize("stack", STACKS)
def test_hostile_names(stack: str) -> None:
    """Names reach the text as literals and comments alone; what is parsed back is what they were."""
    listed = ", ".join(json.dumps(name, ensure_ascii=False) for name in HOSTILE)
    ranges = (
        "gains: {scale: [0.9, 1.1]}, armature: {scale: [0.5, 2]}, encoder_bias: {add: [-0.1 rad, 0.1 rad]},"
        "friction.coulomb: {scale: [0.5, 2]}"
    )
    escaped = ", ".join(json.dumps(re.escape(name), ensure_ascii=False) for name in HOSTILE[:4])
    text = spec_of(
        f"'g\"#': {{joints: [{escaped}], level: ideal_pd, {NUMBERS}, randomize: {{{ranges}}}}},"
        f"rest: {{joints: [{json.dumps(re.escape(HOSTILE[4]))}], level: ideal_pd, {NUMBERS}}}",
        robot=f"name: leg, model: none, joints: [{listed}]",
    )
    data = compiled(text, stack).files[0].data.decode("utf-8")
    if stack == "json":
        assert [joint["joint"] for joint in json.loads(data)["joints"]] == list(HOSTILE)
        return
    tree = ast.parse(data)
    compile(tree, stack, "exec")
    imported = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    assert "os" not in imported
    found = {
        node.value
        for node in ast.walk(tree)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }
    wanted = {name if stack == "playground" else re.escape(name) for name in HOSTILE[:4]}
    assert wanted <= found


def test_json_is_the_spec() -> None:
    """The JSON fits its schema and has the ranges as stated, with the nominals beside them."""
    emission = made(
        "kp: {scale: [1, 0.1], distribution: gaussian, per: env}, delay: {add: [0 ms, 2 ms]}", "json"
    )
    found = json.loads(emission.files[0].data)
    schema = json.loads(
        (ROOT / "schemas" / "actspec-randomization-v1.schema.json").read_text(encoding="utf-8")
    )
    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.Draft202012Validator(schema).validate(found)
    hip = found["joints"][0]
    assert hip["nominal"]["kp"] == {"value": 20.0, "unit": "N*m/rad"}
    assert hip["ranges"] == [
        {"field": "kp", "operation": "scale", "unit": "1", "distribution": "gaussian", "low": 1.0, "high": 0.1,
         "when": "reset", "every": None, "per": "env"},
        {"field": "delay", "operation": "add", "unit": "s", "distribution": "uniform", "low": 0.0, "high": 0.002,
         "when": "reset", "every": None, "per": "joint"},
    ]  # fmt: skip
    assert emission.approximations == ()


def test_all_stacks_by_default() -> None:
    """Without `for` every stack gets its file; nothing to draw is a file too, that parses."""
    for ranges in ("", "kp: {scale: [0.9, 1.1]}"):
        emission = made(ranges)
        assert [file.path for file in emission.files] == [
            "leg_isaaclab_events.py", "leg_mjlab_events.py", "leg_playground_randomize.py", "leg_randomization.json",
        ]  # fmt: skip
        for file in emission.files[:3]:
            ast.parse(file.data)


@pytest.mark.parametrize(
    "ranges, stacks, options, expected",
    [
        pytest.param("", ("mjlap",), {}, "RND011 targets.dr.for: no randomisation can be written for 'mjlap'",
                     id="stack"),
        pytest.param("", ("isaaclab", "mjlab"), {"version": "2.3"},
                     "RND012 targets.dr.version: version '2.3' could be that of isaaclab or mjlab", id="whose version"),
        pytest.param("", ("isaaclab",), {"version": "2.9"},
                     "RND013 targets.dr.version: actspec does not know Isaac Lab '2.9'", id="no such version"),
        pytest.param("", ("mjlab",), {"version": "1.4"},
                     "RND013 targets.dr.version: randomisation for mjlab 1.4 is not written", id="older mjlab"),
        pytest.param("armature: {add: [-1, 1]}", ("json",), {},
                     "RND004 actuators.legs.randomize.armature: hip, calf: armature is drawn below 0: -0.99 kg*m^2",
                     id="range"),
    ],
)  # fmt: skip
def test_refused(ranges: str, stacks: tuple[str, ...], options: dict[str, str], expected: str) -> None:
    """What cannot be written is named with its place."""
    with pytest.raises(EmitError) as caught:
        made(ranges, *stacks, **options)
    assert [f"{d.code} {d.where}: {d.message}" for d in caught.value.diagnostics] == [expected]
    assert all(d.help for d in caught.value.diagnostics)


def test_isaaclab_friction_of_nothing() -> None:
    """An absolute friction on a nominal of 0 has no factor: an error for each joint, in place of a wrong term."""
    ranges, zero = "friction.coulomb: {abs: [0, 0.2]}", NUMBERS.replace("coulomb: 0.2", "coulomb: 0")
    group = f"legs: {{joints: [hip], level: ideal_pd, {zero}, randomize: {{{ranges}}}}}"
    with pytest.raises(EmitError) as caught:
        compiled(spec_of(group, robot="name: leg, model: none, joints: [hip]"), "isaaclab")
    (fault,) = caught.value.diagnostics
    assert (
        str(fault)
        .splitlines()[0]
        .endswith(
            "RND010 actuators.legs.randomize.friction.coulomb: hip: Isaac Sim 5.1 draws static, dynamic and viscous "
            "friction from one range, so only a factor can be written, and the nominal friction.coulomb is 0 N*m"
        )
    )
    assert (
        compiled(spec_of(group, robot="name: leg, model: none, joints: [hip]"), "mjlab").approximations == ()
    )
