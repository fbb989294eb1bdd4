"""The randomisation target's text: what is written, what is reported, what is refused."""

from __future__ import annotations

import ast
import json
import re
from pathlib import Path
from typing import Any

import pytest

from actspec.diagnostics import EmitError, Severity
from actspec.resolution import resolve
from actspec.robot.load import listed_robot
from actspec.spec.document import document_from_text
from actspec.spec.validate import validate
from actspec.targets.base import Emission, TargetOptions
from actspec.targets.randomization.emit import STACKS, emit
from tests.compiling import target_options, view_of
from tests.fitting import spec_of
from tests.schemas import fits

ROOT = Path(__file__).resolve().parents[3]

NUMBERS = "kp: 20, kd: 0.5, effort_limit: 30, armature: 0.01, friction: {coulomb: 0.2, viscous: 0.04}"
LEG = "name: leg, model: none, joints: [hip, calf]"


def made(randomize: str, *stacks: str, more: str = "", level: str = "ideal_pd", **options: Any) -> Emission:
    """One group of two joints with ranges, for some stacks."""
    group = f"legs: {{joints: [hip, calf], level: {level}, {NUMBERS}, randomize: {{{randomize}}} {more}}}"
    motors = "{m: {side: joint, stall_torque: 30 N*m, no_load_speed: 20 rad/s}}"
    return compiled(spec_of(group, robot=LEG, motors=motors), *stacks, **options)


def compiled(text: str, *stacks: str, **options: Any) -> Emission:
    """A spec's emission."""
    spec = validate(document_from_text(text, "s.yaml"))
    robot = listed_robot(spec)
    version = options.pop("version", "")
    chosen = target_options("randomization", version, name="dr", for_=stacks, **options)
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
        # kd 0.45 with the limit at 1.1, against 1.1 throughout: 0.1 · 2 · 33/0.45.
        pytest.param("strength: {scale: [0.9, 1.1]}", "mjlab", {"mjlab.strength": 44 / 3}, id="strength apart"),
        # 30 to 120, of which commands for twice 30 N*m would show but 30.
        pytest.param("effort_limit: {scale: [1, 4]}", "isaaclab", {"isaaclab.effort_limit": 90.0}, id="far limit"),
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
        pytest.param("4.5", None, id="no unit"),
    ],
)
def test_isaaclab_friction_by_simulator(sim: str, words: str | None) -> None:
    """Where friction has no unit the config leaves it out, so nothing is drawn, and that is said."""
    emission = made("friction.coulomb: {add: [-0.1, 0.1]}", "isaaclab", isaac_sim=sim)
    if words is None:
        assert empty_stacks(emission) == [
            "no file for isaaclab is written: none of the spec's ranges can be drawn there"
        ]
    else:
        assert words in body(emission)
    # Coulomb 0.2 → 0.3; else the viscous part that moves along: 0.04 · 0.5 · 2 · 30/0.5.
    lost = {"isaaclab.friction.coulomb": 0.1} if sim == "4.5" else {
        "isaaclab.friction.coulomb": 0.2, "isaaclab.friction.viscous": 2.4}  # fmt: skip
    assert losses(emission) == {key: pytest.approx(value) for key, value in lost.items()}


def test_isaaclab_viscous_without_a_unit() -> None:
    """Viscous friction that stays: 0.04 to 0.08 at twice the speed at which kd takes the limit, 2 · 30/0.5."""
    emission = made("friction.viscous: {scale: [0.5, 2]}", "isaaclab", isaac_sim="4.5")
    assert losses(emission) == {"isaaclab.friction.viscous": pytest.approx(4.8)}


@pytest.mark.parametrize("version, sim", [("2.1", "4.5"), ("2.2", "5.0"), ("2.3", "4.5")])
@pytest.mark.parametrize(
    "randomize, written, lost",
    [
        # damping is 0.5 + 0.04: kd alone moves, from 0.25 to 0.75.
        ("kd: {scale: [0.5, 1.5]}", '(0.29, 0.79),*"operation": "abs",*"distribution": "uniform"', {}),
        ("kd: {add: [-0.1, 0.2]}", '(0.44, 0.74),*"operation": "abs",*"distribution": "uniform"', {}),
        ("kd: {scale: [1, 0.1], distribution: gaussian}", '(0.54, 0.05),*"abs",*"gaussian"', {}),
        (
            "kd: {scale: [0.5, 1.5], distribution: log_uniform}",
            '(0.29, 0.79),*"abs",*"log_uniform"',
            {"isaaclab.kd": None},
        ),
    ],
    ids=["scale", "add", "gaussian", "log_uniform"],
)
def test_isaaclab_kd_beside_a_summed_viscous_friction(
    version: str, sim: str, randomize: str, written: str, lost: dict[str, None]
) -> None:
    """Where the config's damping is kd + viscous, a draw of kd leaves the viscous part alone."""
    emission = made(randomize, "isaaclab", version=version, isaac_sim=sim)
    pattern = ".*".join(re.escape(part) for part in f'"damping_distribution_params": {written}'.split("*"))
    assert re.search(pattern, body(emission), re.DOTALL), body(emission)
    assert "# `damping` holds the passive viscous friction too" in body(emission)
    assert losses(emission) == lost
    # From 2.3 on Isaac Sim 5 it has a field of its own.
    assert '"operation": "abs"' not in body(made("kd: {scale: [0.5, 1.5]}", "isaaclab"))


def test_isaaclab_scales_unknown_friction_too() -> None:
    """A factor on viscous friction moves the dry friction of the USD, which nobody knows: said, without a size."""
    group = "joints: [hip], level: ideal_pd, kp: 20, kd: 1, effort_limit: 9, friction: {coulomb: unknown, viscous: 0.1}"
    text = spec_of(f"legs: {{{group}, randomize: {{friction.viscous: {{scale: [0.5, 2]}}}}}}",
                   robot="name: leg, model: none, joints: [hip]")  # fmt: skip
    assert losses(compiled(text, "isaaclab")) == {"isaaclab.friction.coulomb": None}


@pytest.mark.parametrize(
    "randomize, lost",
    [
        ("kp: {scale: [0.5, 2]}, kd: {scale: [0.5, 2], when: startup}", {("kd", "drawn at reset")}),
        (
            "kp: {scale: [0.5, 2], when: interval, every: [5 s, 9 s]}, kd: {scale: [0.5, 2]}",
            {("kd", "drawn at interval of 5 to 9 s")},
        ),
        (
            "kp: {abs: [10, 40], distribution: log_uniform}, kd: {scale: [0.5, 2]}",
            {("kp", "abs 10 to 40, uniform")},
        ),
        (
            "kp: {scale: [0.5, 2]}, kd: {scale: [0.5, 2], distribution: log_uniform}",
            {("kd", "scale 0.5 to 2, uniform")},
        ),
        ("kp: {scale: [0.5, 2]}, kd: {scale: [0.5, 2]}", set()),
    ],
    ids=["time", "interval", "distribution", "distribution-of-kd", "alike"],
)
def test_mjlab_draws_both_gains_in_one_event(randomize: str, lost: set[tuple[str, str]]) -> None:
    """dr.pd_gains has one time and one distribution: the gain that gives way says so."""
    emission = made(randomize, "mjlab")
    found = {(loss.field, loss.emitted) for loss in emission.approximations if loss.joint == "hip"}
    assert found == {(f"mjlab.{field}", text) for field, text in lost}


BALL = """<mujoco><worldbody><body><freejoint name="root"/><geom size="1"/>
<body><joint name="hip"/><geom size="1"/><body><joint name="toe&#10;b"/><geom size="1"/></body></body>
%s
</body></worldbody></mujoco>"""
"""A floating leg; a name with a line's end."""


@pytest.mark.parametrize("stack", ["isaaclab", "mjlab"])
@pytest.mark.parametrize(
    "joints, more, strays",
    [
        ('"hip", "toe\\nb"', "", []),
        ('"hip", "toe_b"', '<body><joint name="ball" type="ball"/><geom size="1"/></body>', ["ball"]),
        ('"hip"', "", ["toe\nb"]),
    ],
    ids=["all", "ball", "unmanaged"],
)
def test_patterns_reach_the_drawn_joints_alone(stack: str, joints: str, more: str, strays: list[str]) -> None:
    """`.*` stops at a line's end and reaches a ball: each drawn joint is matched, and nothing that is not drawn."""
    numbers = "level: ideal_pd, kp: 20, kd: 1, effort_limit: 9, armature: 0.1"
    text = spec_of(f"legs: {{joints: [{joints}], {numbers}, randomize: {{armature: {{scale: [1, 2]}}}}}}",
                   robot='name: leg, model: robot.xml, unmanaged: ["toe\\nb"]' if "toe" not in joints
                   else "name: leg, model: robot.xml")  # fmt: skip
    view = view_of((BALL % more).replace("&#10;", "_" if "toe_b" in joints else "&#10;"))
    actuators = resolve(validate(document_from_text(text, "s.yaml")), view)
    module = emit(actuators, view, target_options("randomization", name="dr", for_=(stack,)))
    (names,) = (
        ast.literal_eval(keyword.value)
        for node in ast.walk(ast.parse(module.files[0].data))
        if isinstance(node, ast.Call)
        for keyword in node.keywords
        if keyword.arg == "joint_names"
    )
    for actuator in actuators.joints:
        assert any(re.fullmatch(pattern, actuator.joint) for pattern in names)
    for stray in strays:
        assert not any(re.fullmatch(pattern, stray) for pattern in names)


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
    fits("randomization", found)
    assert '"kp": {"value": 20.0, "unit": "N*m/rad"},\n' in emission.files[0].data.decode("utf-8")
    hip = found["joints"][0]
    assert hip["nominal"]["kp"] == {"value": 20.0, "unit": "N*m/rad"}
    assert hip["ranges"] == [
        {"field": "kp", "operation": "scale", "unit": "1", "distribution": "gaussian", "low": 1.0, "high": 0.1,
         "when": "reset", "every": None, "per": "env"},
        {"field": "delay", "operation": "add", "unit": "s", "distribution": "uniform", "low": 0.0, "high": 0.002,
         "when": "reset", "every": None, "per": "joint"},
    ]  # fmt: skip
    assert emission.approximations == ()


def empty_stacks(emission: Emission) -> list[str]:
    """What is said of stacks without a file, of which there is none."""
    assert [file.path for file in emission.files if file.path.endswith(".py")] == []
    return [item.message for item in emission.diagnostics if item.code == "RND015"]


def test_all_stacks_by_default() -> None:
    """Without `for` every stack gets its file."""
    emission = made("kp: {scale: [0.9, 1.1]}")
    assert [file.path for file in emission.files] == [
        "leg_isaaclab_events.py", "leg_mjlab_events.py", "leg_playground_randomize.py", "leg_randomization.json",
    ]  # fmt: skip
    for file in emission.files[:3]:
        ast.parse(file.data)
    assert emission.diagnostics == ()


def test_nothing_to_draw_is_no_file() -> None:
    """Without a range no stack gets a file, and one remark says why; the nominals stay in the JSON."""
    emission = made("")
    assert [file.path for file in emission.files] == ["leg_randomization.json"]
    (said,) = emission.diagnostics
    assert (said.severity, said.where) == (Severity.INFO, "targets.dr")
    assert empty_stacks(emission) == [
        "no file for isaaclab, mjlab, playground is written: the spec has no `randomize`"
    ]
    assert made("", "mjlab").files == ()
    # A delay is in no stack: its range is lost, not forgotten.
    lost = made("delay: {abs: [0 ms, 10 ms]}", "playground")
    assert empty_stacks(lost) == [
        "no file for playground is written: none of the spec's ranges can be drawn there"
    ]
    assert losses(lost) == {"playground.delay": 15.0}


def test_isaaclab_warns_of_implicit_gains_alone() -> None:
    """Gains of implicit groups go through the CPU: said where a sibling is implicit and draws them after the start."""

    def said(randomize: str, cls: str) -> bool:
        other = target_options("isaaclab", "2.3", name="lab", class_=cls)
        text = made(randomize, "isaaclab", siblings=(other,)).files[0].data.decode("utf-8")
        return "through the CPU" in text

    assert said("kp: {scale: [0.9, 1.1]}", "implicit")
    assert not said("kp: {scale: [0.9, 1.1]}", "auto")
    assert not said("kp: {scale: [0.9, 1.1], when: startup}", "implicit")
    assert not said("armature: {scale: [0.9, 1.1]}", "implicit")


def test_mjlab_columns() -> None:
    """Comments keep mjlab's 88 columns, and the other stacks 120."""
    ranges = "strength: {scale: [0.9, 1.1], per: env}, armature: {scale: [0.5, 2], when: interval, every: [1 s, 2 s]}"
    for stack, width in (("mjlab", 88), ("isaaclab", 120)):
        lines = made(ranges, stack).files[0].data.decode("utf-8").splitlines()
        longest = max(len(line) for line in lines if "#" in line)
        assert width - 20 < longest <= width, stack


# --- Playground ---------------------------------------------------------------------------------------


def model_at(version: str, name: str = "mujoco") -> TargetOptions:
    """A MuJoCo target of the same spec."""
    return TargetOptions(name, "mujoco", version, None, "out")


DC = {"more": ", motor: m", "level": "dc_motor"}


@pytest.mark.parametrize(
    ("versions", "version", "voltage"),
    [
        ((), "", False),
        (("3.11",), "", True),
        (("3.12",), "", False),
        (("3.11",), "3.12", False),
        (("3.99", "3.11"), "", True),
        (("3.12", "4.0"), "", False),
    ],
    ids=["default", "volts", "torque", "own-version", "unknown-one", "alike"],
)
def test_playground_is_for_the_specs_own_model(
    versions: tuple[str, ...], version: str, voltage: bool
) -> None:
    """The numbers of a <dcmotor> stand where the spec's MuJoCo target puts them, unless the target has a version."""
    siblings = tuple(model_at(v, f"m{i}") for i, v in enumerate(versions))
    text = body(made("kp: {scale: [0.5, 2]}", "playground", version=version, siblings=siblings, **DC))
    assert ("kp = model.actuator_gainprm[act, 4] * constant / resistance" in text) is voltage
    assert ("resistance" in text) is voltage


def test_playground_for_two_models() -> None:
    """Two models whose motors are in volts and in torque have no common function; without a motor they have."""
    siblings = (model_at("3.11", "old"), model_at("3.12", "new"))
    with pytest.raises(EmitError) as caught:
        made("kp: {scale: [0.5, 2]}", "playground", siblings=siblings, **DC)
    assert [f"{d.code} {d.where}: {d.message}" for d in caught.value.diagnostics] == [
        "RND014 targets.dr.version: Playground's function could be for the model of 'old' (3.11) or 'new' (3.12), "
        "whose motors keep their numbers in other fields"
    ]
    assert "MuJoCo 3.11" in made("kp: {scale: [0.5, 2]}", "playground", siblings=siblings).files[
        0
    ].data.decode("utf-8")


PLAYED = """<mujoco><worldbody><body><geom size="1"/><joint name="hip" %s/></body></worldbody></mujoco>"""


def played(group: str, joint: str = "") -> Emission:
    """A hip's ranges for Playground, on a model."""
    text = spec_of(f"legs: {{joints: [hip], {group}}}", robot="name: leg, model: robot.xml")
    view = view_of(PLAYED % joint)
    actuators = resolve(validate(document_from_text(text, "s.yaml")), view)
    return emit(actuators, view, target_options("randomization", name="dr", for_=("playground",)))


@pytest.mark.parametrize(
    ("friction", "joint", "lost"),
    [
        ("{coulomb: 0 N*m}", "", 0.2),
        ("{coulomb: 0.1 N*m}", "", None),
        ("{coulomb: unknown}", "", 0.0),
        ("{coulomb: unknown}", 'frictionloss="0.1"', None),
    ],
    ids=["nothing", "some", "unknown-and-nothing", "the-models"],
)
def test_playground_friction_of_nothing(friction: str, joint: str, lost: float | None) -> None:
    """MJX's JAX implementation has friction only where the model has some: 0 to 0.2 N*m drawn on none is lost."""
    start = "when: startup"
    emission = played(
        f"level: ideal_pd, kp: 20, kd: 1, effort_limit: 9, friction: {friction}, "
        f"randomize: {{friction.coulomb: {{abs: [0, 0.2], {start}}}}}",
        joint,
    )
    said = [(loss.field, loss.emitted, loss.max_torque_error or 0.0) for loss in emission.approximations]
    assert said == ([] if lost is None else [("playground.friction.coulomb", "without effect in MJX's JAX "
                                              "implementation", lost)])  # fmt: skip
    assert "frictionloss = jax.random.uniform(keys[0], (1,), minval=0.0, maxval=0.2)" in body(emission)


@pytest.mark.parametrize(
    ("group", "joint", "kept", "field"),
    [
        ("kp: 20, kd: 1, effort_limit: unknown, randomize: {effort_limit: {abs: [1, 2], when: startup}}", "", False,
         "playground.effort_limit"),
        ("kp: 20, kd: 1, effort_limit: unknown, randomize: {effort_limit: {abs: [1, 2], when: startup}}",
         'actuatorfrcrange="-3 3"', True, None),
        ("command: effort, effort_limit: unknown, randomize: {strength: {scale: [1, 2], when: startup}}", "", False,
         "playground.strength"),
        ("kp: 20, kd: 1, effort_limit: 3, randomize: {effort_limit: {abs: [1, 3], when: startup}}", "", True, None),
    ],
    ids=["no-limit", "the-joints-limit", "no-limit-of-a-motor", "limit"],
)  # fmt: skip
def test_playground_limit_that_nobody_knows(group: str, joint: str, kept: bool, field: str | None) -> None:
    """A drive without a limit does not mind a drawn one: it is lost, and not written."""
    emission = played(f"level: ideal_pd, {group}", joint)
    assert [loss.field for loss in emission.approximations] == ([field] if field else [])
    assert [("actuator_forcerange" in file.data.decode("utf-8")) for file in emission.files] == [True] * kept


@pytest.mark.parametrize(
    ("ranges", "joint", "widened"),
    [
        ("effort_limit: {scale: [0.5, 1.5]}", 'actuatorfrcrange="-3 3"', True),
        ("strength: {scale: [0.5, 1.5]}", 'actuatorfrcrange="-3 3"', True),
        ("effort_limit: {add: [-1, 1]}", 'actuatorfrcrange="-3 3"', True),
        ("effort_limit: {abs: [1, 9.5]}", 'actuatorfrcrange="-3 3"', True),
        ("effort_limit: {abs: [1, 9]}", 'actuatorfrcrange="-3 3"', False),
        ("strength: {scale: [0.5, 1]}", 'actuatorfrcrange="-3 3"', False),
        ("effort_limit: {scale: [0.5, 1.5]}", "", False),
    ],
    ids=["factor", "strength", "offset", "value", "not-above", "not-stronger", "no-range"],
)
def test_playground_widens_the_joints_own_range(ranges: str, joint: str, widened: bool) -> None:
    """A limit that is raised would be cut at the joint's own force range."""
    text = body(played(f"level: ideal_pd, kp: 20, kd: 1, effort_limit: 9, randomize: {{{ranges}}}", joint))
    assert ('"jnt_actfrcrange": jnt_actfrcrange,' in text) is widened
    assert ("jnt, act = _addresses(model)" in text) is widened


def test_playground_text() -> None:
    """The body as a person writes it: nothing is looked up or read that is not used."""
    text = body(
        made("gains: {scale: [0.9, 1.1], per: env}, encoder_bias: {add: [-0.1 rad, 0.1 rad]}", "playground")
    )
    assert (
        text.partition("def draw(key):\n")[2].partition("        return {")[0]
        == """        keys = jax.random.split(key, 2)
        kp = model.actuator_gainprm[act, 0]
        kd = -model.actuator_biasprm[act, 2]
        bias = jnp.zeros(len(JOINTS))
        bias = bias + jax.random.uniform(keys[0], (2,), minval=-0.1, maxval=0.1)
        factor = jax.random.uniform(keys[1], (), minval=0.9, maxval=1.1)
        kp = kp * factor
        kd = kd * factor
        actuator_gainprm = model.actuator_gainprm
        actuator_biasprm = model.actuator_biasprm
        actuator_gainprm = actuator_gainprm.at[act, 0].set(kp)
        actuator_biasprm = actuator_biasprm.at[act, 1].set(-kp)
        actuator_biasprm = actuator_biasprm.at[act, 0].set(-kp * bias)
        actuator_biasprm = actuator_biasprm.at[act, 2].set(-kd)
"""
    )
    assert "dof" not in text
    passive = body(made("armature: {scale: [1, 0.1], distribution: gaussian}", "playground"))
    assert "    dof = _addresses(model)\n" in passive
    assert "mujoco.mjtTrn" not in passive
    assert "armature = armature * (1.0 + 0.1 * jax.random.normal(keys[0], (2,)))" in passive


def test_playground_numbers_of_many_joints() -> None:
    """A list of numbers breaks between them, and reads back as it is."""
    names = [f"j{i}" for i in range(40)]
    overrides = ", ".join(f"{name}: {{encoder_bias: 0.{i:03d} rad}}" for i, name in enumerate(names))
    group = f"joints: ['j.*'], level: ideal_pd, kp: 20, kd: 1, effort_limit: 9, overrides: {{{overrides}}}"
    ranges = "encoder_bias: {add: [-0.1 rad, 0.1 rad]}"
    text = spec_of(
        f"legs: {{{group}, randomize: {{{ranges}}}}}", robot=f"name: leg, model: none, joints: {names}"
    )
    module = body(compiled(text, "playground"))
    assert max(map(len, module.splitlines())) <= 120
    found = re.search(r"bias = jnp\.array\((.*?)\n        \)", module, re.DOTALL)
    assert found is not None
    assert ast.literal_eval(found[1].strip()) == [i / 1000 for i in range(40)]


@pytest.mark.parametrize(
    "ranges, stacks, options, expected",
    [
        pytest.param("", ("mjlap",), {}, "RND011 targets.dr.for[0]: no randomisation can be written for 'mjlap'",
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
    """An absolute friction on a nominal of 0 has no factor: one error for the group, in place of a wrong term."""
    ranges, zero = "friction.coulomb: {abs: [0, 0.2]}", NUMBERS.replace("coulomb: 0.2", "coulomb: 0")
    group = f"legs: {{joints: [hip, calf], level: ideal_pd, {zero}, randomize: {{{ranges}}}}}"
    with pytest.raises(EmitError) as caught:
        compiled(spec_of(group, robot=LEG), "isaaclab")
    (fault,) = caught.value.diagnostics
    assert (
        str(fault)
        .splitlines()[0]
        .endswith(
            "RND010 actuators.legs.randomize.friction.coulomb: hip, calf: Isaac Sim 5.1 draws static, dynamic and "
            "viscous friction from one range, so only a factor can be written, and the nominal friction.coulomb "
            "is 0 N*m"
        )
    )
    assert compiled(spec_of(group, robot=LEG), "mjlab").approximations == ()
