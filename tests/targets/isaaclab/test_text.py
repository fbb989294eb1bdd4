"""The Isaac Lab module as text: names, groups, patterns, units, what is left out, and that nobody's name runs."""

from __future__ import annotations

import ast
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from actspec.resolution import resolve
from actspec.spec.document import document_from_text
from actspec.spec.validate import validate
from actspec.targets.isaaclab.emit import emit
from tests.compiling import spec_text, view_of
from tests.frameworks.isaaclab_asking import compiled, options
from tests.frameworks.isaaclab_specs import RICH, WHOLE
from tests.targets.isaaclab.emitting import DC, PD, SPEC, cfgs, made


def test_module_and_constant_are_named_after_the_robot() -> None:
    """`Go-1.v2` becomes go_1_v2_cfg.py with GO_1_V2_ACTUATORS."""
    emitted = made(f'all: {{joints: [".*"], {PD}}}', name="Go-1.v2")
    assert emitted.emission.files[0].path == "go_1_v2_cfg.py"
    assert "GO_1_V2_ACTUATORS = {" in emitted.text


def test_limits_are_in_the_version_s_own_names() -> None:
    """2.x: effort_limit, velocity_limit, velocity_limit_sim; 3.0: its new names, and the solver's clamp too."""
    group = f'all: {{joints: [".*"], {DC}, velocity_limit: 12 rad/s}}'
    shared = {
        "joint_names_expr": [".*"],
        "saturation_effort": 45.0,
        "stiffness": 20.0,
        "damping": 0.5,
        "class": "DCMotorCfg",
    }
    assert cfgs(made(group).text)["all"] == {
        **shared,
        "effort_limit": 9.0,
        "velocity_limit": 30.0,
        "velocity_limit_sim": 12.0,
    }
    assert cfgs(made(group, "3.0").text)["all"] == {
        **shared,
        "actuator_effort_limit": 9.0,
        "actuator_velocity_limit": 30.0,
        "joint_effort_limit": 9.0,
        "joint_velocity_limit": 12.0,
    }


@pytest.mark.parametrize(
    "version, names",
    [
        ("2.1", {"effort_limit_sim": 9.0, "velocity_limit_sim": 12.0}),
        ("3.0", {"joint_effort_limit": 9.0, "joint_velocity_limit": 12.0}),
    ],
)
def test_implicit_limits_are_the_solver_s_alone(version: str, names: dict[str, float]) -> None:
    """An implicit group states no limit of a model: 2.x ignores one, early 3.0 refuses it."""
    group = cfgs(made(f'all: {{joints: [".*"], {PD}, velocity_limit: 12 rad/s}}', version, "implicit").text)[
        "all"
    ]
    assert {key: value for key, value in group.items() if "limit" in key} == names


def test_one_stall_torque_a_group_in_2_and_a_dict_in_3() -> None:
    """Joints with different stall torque are apart in 2.x, by the word that tells them apart; together in 3.0."""
    group = f'legs: {{joints: [".*_hip", ".*_knee"], {DC}, overrides: {{".*_knee": {{motor: small}}}}}}'
    two = cfgs(made(group).text)
    assert {
        name: (g["joint_names_expr"], g["saturation_effort"], g["velocity_limit"]) for name, g in two.items()
    } == {
        "legs_hip": ([".*_hip"], 45.0, 30.0),
        "legs_knee": ([".*_knee"], 30.0, 25.0),
    }
    three = cfgs(made(group, "3.0").text)
    assert three["legs"]["saturation_effort"] == {".*_hip": 45.0, ".*_knee": 30.0}


def test_patterns_match_exactly_the_group_s_joints() -> None:
    """The author's pattern where all that it matches is meant; else joint by joint, escaped, each joint once."""
    groups = f'most: {{joints: [".*"], {PD}, overrides: {{"a[.]hip": {{effort_limit: 8 N*m}}}}}}'
    group = cfgs(made(groups, joints="a.hip, axhip, b").text)["most"]
    assert group["joint_names_expr"] == [".*"]
    assert group["effort_limit"] == {"a\\.hip": 8.0, "axhip": 9.0, "b": 9.0}
    for joint, limit in (("a.hip", 8.0), ("axhip", 9.0), ("b", 9.0)):
        assert [v for p, v in group["effort_limit"].items() if re.fullmatch(p, joint)] == [limit]


def test_unmanaged_joints_are_in_no_pattern() -> None:
    """A pattern that would reach an unmanaged joint is not written."""
    emitted = made(
        f'a: {{joints: ["a_.*"], {PD}}}, b: {{joints: ["b_hip"], {PD}}}', robot=', unmanaged: ["b_knee"]'
    )
    assert [g["joint_names_expr"] for g in cfgs(emitted.text).values()] == [["a_.*"], ["b_hip"]]
    assert "b_knee" not in emitted.text


@pytest.mark.parametrize(
    "version, more, friction, viscous, damping",
    [
        ("2.1", {}, {}, None, 0.54),
        ("2.2", {}, {}, None, 0.54),
        ("2.2", {"isaac_sim": "4.5"}, {}, None, 0.54),
        ("2.3", {"isaac_sim": "4.5"}, {}, None, 0.54),
        ("2.3", {"isaac_sim": "5.0"}, {"friction": 0.5, "dynamic_friction": 0.3}, 0.04, 0.5),
        ("3.0", {}, {"friction": 0.5, "dynamic_friction": 0.3}, 0.04, 0.5),
        ("3.0", {"backend": "newton"}, {"friction": 0.3}, 0.04, 0.5),
        ("3.0", {"backend": "ovphysx"}, {}, 0.04, 0.5),
    ],
    ids=["2.1", "2.2", "2.2-sim-4.5", "2.3-sim-4.5", "2.3", "3.0", "3.0-newton", "3.0-ovphysx"],
)
def test_friction_in_the_version_s_unit_or_left_out(
    version: str, more: dict[str, Any], friction: dict[str, float], viscous: float | None, damping: float
) -> None:
    """Coulomb 0.3, static 0.5, viscous 0.04: torques where the solver takes torques, else nothing; never kd twice."""
    friction_spec = "friction: {coulomb: 0.3 N*m, static: 0.5 N*m, viscous: 0.04 N*m*s/rad}"
    emitted = made(f'all: {{joints: [".*"], {PD}, {friction_spec}}}', version, **more)
    group = cfgs(emitted.text)["all"]
    assert {k: group[k] for k in ("friction", "dynamic_friction") if k in group} == friction
    assert group.get("viscous_friction") == viscous
    assert group["damping"] == pytest.approx(damping)
    sizes = {a.field: a.max_torque_error for a in emitted.emission.approximations if a.joint == "a_hip"}
    if not friction:
        # Both are lost, each at its own size, and the text says what to do about it.
        assert (sizes["friction.coulomb"], sizes["friction.static"]) == pytest.approx((0.3, 0.5))
        assert "friction is left out, 0.5 N*m asked for" in " ".join(emitted.text.replace("#", "").split())
    if viscous is None:
        # Speeds to twice L/kd = 18 rad/s; outside of the clamp the law has 0.04 x 36 N*m more.
        assert sizes["friction.viscous"] == pytest.approx(1.44)
    if version == "3.0" and more.get("backend") == "newton":
        assert sizes["friction.static"] == pytest.approx(0.2)


def test_no_friction_is_none_in_every_unit() -> None:
    """A stated 0 is written even where friction is a coefficient, and nothing is lost."""
    emitted = made(
        f'all: {{joints: [".*"], {PD}, friction: {{coulomb: 0 N*m, viscous: 0 N*m*s/rad}}}}', "2.1"
    )
    group = cfgs(emitted.text)["all"]
    assert (group["friction"], group["damping"]) == (0.0, 0.5)
    assert emitted.emission.approximations == ()


def test_speed_command_does_not_follow_a_sum() -> None:
    """With a speed command kd + viscous would follow the command too: viscous is left out, and sized."""
    group = "level: ideal_pd, command: velocity, kd: 2 N*m*s/rad, effort_limit: 9 N*m"
    emitted = made(f'all: {{joints: [".*"], {group}, friction: {{viscous: 0.04 N*m*s/rad}}}}', "2.1")
    assert cfgs(emitted.text)["all"]["damping"] == 2.0
    sizes = {a.field: a.max_torque_error for a in emitted.emission.approximations if a.joint == "a_hip"}
    # 0.04 x 2 x 9/2 rad/s
    assert sizes == {"friction.viscous": pytest.approx(0.36)}


@pytest.mark.parametrize(
    "delay, lags, losses",
    [
        ("10 ms", (2, 2), {}),
        ("12 ms", (2, 2), {"delay": 4.5}),
        ("{nominal: 10 ms, range: [5 ms, 20 ms]}", (1, 4), {}),
        ("{nominal: 10 ms, range: [4 ms, 20 ms]}", (1, 4), {"delay.range": 4.5}),
        ("{nominal: 10 ms, range: [5 ms, 20 ms], sampling: step}", (1, 4), {"delay.sampling": 4.5}),
        ("2 ms", None, {"delay": 4.5}),
    ],
    ids=["steps", "rounded", "range", "range-rounded", "per-step", "under-half-a-step"],
)
def test_delay_in_physics_steps(delay: str, lags: tuple[int, int] | None, losses: dict[str, float]) -> None:
    """Delays become steps of 5 ms; a late step of 0.5 L/kp costs 0.5 x 9 N*m for as long as it is late."""
    emitted = made(f'all: {{joints: [".*"], {PD}, delay: {delay}}}')
    group = cfgs(emitted.text)["all"]
    assert (None if "max_delay" not in group else (group["min_delay"], group["max_delay"])) == lags
    assert group["class"] == ("IdealPDActuatorCfg" if lags is None else "DelayedPDActuatorCfg")
    sizes = {a.field: a.max_torque_error for a in emitted.emission.approximations if a.joint == "a_hip"}
    assert sizes == pytest.approx(losses)


def test_native_actuators_of_3_have_one_delay() -> None:
    """Isaac Lab 3.0 ignores min_delay: the nominal, and the range is lost."""
    emitted = made(f'all: {{joints: [".*"], {PD}, delay: {{nominal: 10 ms, range: [5 ms, 20 ms]}}}}', "3.0")
    group = cfgs(emitted.text)["all"]
    assert (group["min_delay"], group["max_delay"]) == (2, 2)
    (loss,) = {(a.field, a.emitted) for a in emitted.emission.approximations}
    assert loss == ("delay.range", "10 ms (2 steps of 5 ms)")


def test_floating_base_is_in_no_pattern() -> None:
    """A named free joint is no joint of an articulation: `.*` stays `.*`, and the group stays whole."""
    spec = validate(
        document_from_text(spec_text(f'  all: {{joints: [".*"], {PD}}}', timing="{physics_dt: 5 ms}"))
    )
    view = view_of(
        '<mujoco><worldbody><body><freejoint name="root"/><geom size="1"/>'
        '<body><joint name="a"/><geom size="1"/></body></body></worldbody></mujoco>'
    )
    actuators = resolve(spec, view)
    text = emit(actuators, view, options()).files[0].data.decode()
    assert cfgs(text)["all"]["joint_names_expr"] == [".*"]


@pytest.mark.parametrize("version, heading", [("2.1", True), ("2.2", False), ("2.3", False), ("3.0", True)])
def test_what_was_never_run_says_so(version: str, heading: bool) -> None:
    """Only versions whose package can be had are run by the tests; the others say so at the top."""
    top = made(f'all: {{joints: [".*"], {PD}}}', version).text.partition('"""')[0]
    assert ("Text-checked, not run" in top) is heading


def test_unknown_gain_stays_the_usd_s() -> None:
    """`kp: unknown` is None, which takes the USD's, apart from joints whose gain is known; and is warned of."""
    group = PD.replace("kp: 20 N*m/rad", "kp: unknown")
    emitted = made(f'all: {{joints: [".*"], {group}, overrides: {{a_hip: {{kp: 7 N*m/rad}}}}}}')
    found = {tuple(g["joint_names_expr"]): g["stiffness"] for g in cfgs(emitted.text).values()}
    assert found == {("a_hip",): 7.0, ("b_hip", "a_knee", "b_knee"): None}
    assert "ISL031" in [d.code for d in emitted.emission.diagnostics]


HOSTILE = '"\\"\\"\\"\\nimport os; os.system(\'x\') #{{ 7*7 }} \\\\ \\u2028 end"'


@pytest.mark.parametrize("cls", ["auto", "custom"])
def test_names_of_strangers_do_not_run(cls: str) -> None:
    """Quotes, line ends, backslashes and template braces in names and notes stay inside literals and comments."""
    text = SPEC.format(
        name="bot",
        joints='"j\'\\"\\\\"',
        robot="",
        groups=f'{HOSTILE}: {{joints: [".*"], {PD}, delay: {{nominal: {{value: 10 ms, source: {HOSTILE}}}}}}}',
    )
    text += f"sources: {{{HOSTILE}: {{title: {HOSTILE}, url: {HOSTILE}}}}}\n"
    emitted = compiled(text, cls=cls)
    tree = ast.parse(emitted.text)
    calls = {
        node.func.id
        for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    }
    assert calls <= {
        "IdealPDActuatorCfg",
        "DelayedPDActuatorCfg",
        "super",
        "DelayBuffer",
        "isinstance",
        "len",
    } | {
        "setattr",
        "getattr",
    } | {name for name in calls if name.endswith("ActuatorCfg")}
    assert not any(isinstance(node, ast.Import) and node.names[0].name == "os" for node in ast.walk(tree))
    ((name, group),) = cfgs(emitted.text).items()
    assert "os.system" in name
    assert all(re.fullmatch(p, "j'\"\\") for p in group["joint_names_expr"])
    assert "49" not in emitted.text.partition("import")[0]


@pytest.mark.parametrize("cls", ["auto", "implicit", "custom"])
def test_layout_is_black_s(cls: str, tmp_path: Path) -> None:
    """A formatter at 120 columns has nothing to change."""
    ruff = shutil.which("ruff", path=os.path.dirname(sys.executable))
    if ruff is None:
        pytest.skip("ruff is not installed")
    for number, spec in enumerate((RICH, WHOLE)):
        path = tmp_path / f"cfg_{number}.py"
        path.write_text(compiled(spec, cls=cls).text, encoding="utf-8")
        done = subprocess.run(
            [ruff, "format", "--isolated", "--line-length", "120", "--diff", str(path)],
            check=False,
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stdout
        assert all(len(line) <= 120 for line in path.read_text(encoding="utf-8").splitlines())


def test_output_is_deterministic() -> None:
    """The same spec gives the same bytes."""
    assert compiled(WHOLE).emission == compiled(WHOLE).emission
