"""What the mjlab target writes: classes and fields, names, lags, losses, versions."""

from __future__ import annotations

import ast
import re
from typing import Any

import pytest

from tests.targets.leg import LEG, group
from tests.targets.mjlab.emitting import written

LIMIT = {"effort_limit": "24 N*m"}
DC = {"level": "dc_motor", "motor": "line", **LIMIT}
MODEL = {"armature": 0.003, "frictionloss": 0.04, "viscous_damping": 0.1}
"""What LEG's hip has of its own: origin `model`, so it is written out."""
SAME = {
    "joints": "['.*']",
    "effort_limit": "9 N*m",
    "armature": "0.01 kg*m^2",
    "friction": "{coulomb: 0 N*m, viscous: 0 N*m*s/rad}",
}
"""All joints, with nothing of their own."""
LINE = {"effort_limit": 24.0, "saturation_effort": 45.0, "velocity_limit": 30.0}


@pytest.mark.parametrize(
    "fields, kind, expected",
    [
        (LIMIT, "BuiltinPositionActuatorCfg", {"stiffness": 25.0, "damping": 0.5, "effort_limit": 24.0}),
        ({"effort_limit": "unknown"}, "BuiltinPositionActuatorCfg", {"stiffness": 25.0, "damping": 0.5}),
        (
            {**LIMIT, "command": "velocity", "kp": ""},
            "BuiltinVelocityActuatorCfg",
            {"damping": 0.5, "effort_limit": 24.0},
        ),
        (
            {**LIMIT, "command": "effort", "kp": "", "kd": ""},
            "BuiltinMotorActuatorCfg",
            {"effort_limit": 24.0},
        ),
        # mjlab divides by a position actuator's stiffness.
        (
            {**LIMIT, "kp": "0 N*m/rad"},
            "IdealPdActuatorCfg",
            {"stiffness": 0.0, "damping": 0.5, "effort_limit": 24.0},
        ),
        (DC, "DcMotorActuatorCfg", {"stiffness": 25.0, "damping": 0.5, **LINE}),
        (
            {**DC, "command": "velocity", "kp": ""},
            "DcMotorActuatorCfg",
            {"stiffness": 0.0, "damping": 0.5, **LINE},
        ),
        (
            {**DC, "command": "effort", "kp": "", "kd": ""},
            "DcMotorActuatorCfg",
            {"stiffness": 0.0, "damping": 0.0, **LINE},
        ),
        # The line through the knee: 20 / (1 - 14/30) = 37.5; cut at the drive torque, below L.
        (
            {**DC, "motor": "curve"},
            "DcMotorActuatorCfg",
            {"stiffness": 25.0, "damping": 0.5, **LINE, "effort_limit": 20.0, "saturation_effort": 37.5},
        ),
    ],
    ids=["pd", "no-limit", "velocity", "effort", "no-kp", "dc", "dc-velocity", "dc-effort", "curve"],
)
def test_class_and_fields(fields: dict[str, str], kind: str, expected: dict[str, Any]) -> None:
    """Level and command choose the class; kd and passive friction stay apart."""
    assert written(group(**fields)).cfg == (kind, {**expected, **MODEL})


def test_stated_passive_numbers_replace_the_models() -> None:
    """Armature and friction of the spec are written; what nobody states is left to the model."""
    stated = written(
        group(**LIMIT, armature="0.01 kg*m^2", friction="{coulomb: 0.2 N*m, viscous: 0.02 N*m*s/rad}")
    )
    assert stated.cfg[1] | {"armature": 0.01, "frictionloss": 0.2, "viscous_damping": 0.02} == stated.cfg[1]
    bare = written(group(**LIMIT, joints="[calf]"), robot='unmanaged: ["hip", "rod"]')
    assert bare.cfg[1] == {"stiffness": 25.0, "damping": 0.5, "effort_limit": 24.0}


@pytest.mark.parametrize(
    "delay, expected, loss",
    [
        ("10 ms", {"delay_min_lag": 2, "delay_max_lag": 2}, None),
        # 7 ms are 1.4 steps; the difference can be the half of L that the step asks for.
        ("7 ms", {"delay_min_lag": 1, "delay_max_lag": 1}, ("delay", "7 ms", "1 step of 5 ms", 12.0)),
        ("2 ms", {}, ("delay", "2 ms", "0 steps of 5 ms", 12.0)),
        (
            "{nominal: 5 ms, range: [0 ms, 10 ms], sampling: episode}",
            {
                "delay_min_lag": 0,
                "delay_max_lag": 2,
                "delay_update_period": "10 ** 9",
                "delay_per_env_phase": False,
            },
            None,
        ),
        (
            "{nominal: 5 ms, range: [5 ms, 12 ms], sampling: step}",
            {"delay_min_lag": 1, "delay_max_lag": 2},
            ("delay.range", "5 to 12 ms", "1 to 2 steps of 5 ms", 12.0),
        ),
        # A range inside one step is a fixed lag: nothing is left to draw.
        (
            "{nominal: 5 ms, range: [4 ms, 6 ms], sampling: episode}",
            {"delay_min_lag": 1, "delay_max_lag": 1},
            ("delay.range", "4 to 6 ms", "1 step of 5 ms", 12.0),
        ),
        # Nobody knows the nominal, and nothing of mjlab needs it.
        (
            "{nominal: unknown, range: [5 ms, 15 ms], sampling: step}",
            {"delay_min_lag": 1, "delay_max_lag": 3},
            None,
        ),
    ],
    ids=["whole", "rounded", "to-nothing", "episode", "step", "within-a-step", "unknown-nominal"],
)
def test_delay(delay: str, expected: dict[str, Any], loss: tuple[str, str, str, float] | None) -> None:
    """Seconds become steps of the simulation, drawn as the spec says, and rounding is recorded."""
    found = written(group(**LIMIT, delay=delay))
    assert {name: value for name, value in found.cfg[1].items() if name.startswith("delay")} == expected
    losses = [(a.field, a.asked, a.emitted, a.max_torque_error) for a in found.emission.approximations]
    assert losses == ([loss] if loss else [])


@pytest.mark.parametrize(
    "fields, field, asked, emitted, error",
    [
        # After a step of 0.5 L / kp, half of L is there and should not be: 12 of 24.
        ({"command_filter": "{cutoff: 30 Hz}"}, "command_filter", "30 Hz", "none", 12.0),
        # kp x bias = 25 x 0.02.
        ({"encoder_bias": "0.02 rad"}, "encoder_bias", "0.02 rad", "none", 0.5),
        # At q = 1 a command of 0.2 pulls with 25 x -0.8 = -20, with kd at speed to -24; a far one with +24: 48.
        ({"command_range": "[-0.2 rad, 0.2 rad]"}, "command_range", "-0.2 to 0.2 rad", "none", 48.0),
        ({"friction": "{coulomb: 0.2 N*m, static: 0.3 N*m}"}, "friction.static", "0.3 N*m", "0.2 N*m", 0.1),
        ({"velocity_limit": "20 rad/s"}, "velocity_limit", "20 rad/s", "none", None),
        # Above 30 rad/s the curve has nothing left, and the line still brakes with 20.
        (
            {"level": "dc_motor", "motor": "curve"},
            "torque_speed_curve",
            "curve: drive 20 N*m, brake 25 N*m, knee 14, no load 30",
            "line from 37.5 to 30, cut at 20",
            20.0,
        ),
    ],
    ids=["filter", "bias", "range", "static", "velocity-limit", "curve"],
)
def test_losses(fields: dict[str, str], field: str, asked: str, emitted: str, error: float | None) -> None:
    """What mjlab cannot hold is recorded with its size."""
    found = written(group(**{**LIMIT, **fields}))
    loss = found.lost(field)
    assert (loss.asked, loss.emitted) == (asked, emitted)
    assert loss.max_torque_error == (None if error is None else pytest.approx(error))
    assert [a.field for a in found.emission.approximations] == [field]


@pytest.mark.parametrize(
    "coulomb, emitted, size",
    [("0.2 N*m", "0.2 N*m", 0.1), ("unknown", "the model's own", 0.3)],
    ids=["known", "unknown"],
)
def test_stribeck_effect(coulomb: str, emitted: str, size: float) -> None:
    """Static friction and its fall to the sliding one are two fields, and two losses; unknown is not 0."""
    friction = f"{{coulomb: {coulomb}, static: 0.3 N*m, stribeck_velocity: 0.1 rad/s}}"
    found = written(group(**LIMIT, friction=friction))
    losses = {loss.field: (loss.emitted, loss.max_torque_error) for loss in found.emission.approximations}
    assert losses.pop("friction.coulomb", None) == (
        ("0.04 N*m, the model's own", None) if coulomb == "unknown" else None
    )
    assert losses == {
        "friction.static": (emitted, pytest.approx(size)),
        "friction.stribeck_velocity": ("none", pytest.approx(size)),
    }


def test_distinct_numbers_make_distinct_cfgs() -> None:
    """Fields are scalars: joints of one group with other numbers get a cfg of their own."""
    model = LEG.replace('name="rod" type="slide"', 'name="toe"')
    fields = {**SAME, "overrides": "{calf: {kp: 36 N*m/rad}}"}
    found = written(group(**fields), model, robot="")
    cfgs = {
        name: (fields["target_names_expr"], fields["stiffness"]) for name, (_, fields) in found.cfgs.items()
    }
    assert cfgs == {
        "PROBE_LEG_ACTUATOR_1": (("hip", "toe"), 25.0),
        "PROBE_LEG_ACTUATOR_2": (("calf",), 36.0),
    }
    (_, articulation) = found.constants["PROBE_ARTICULATION"]
    assert articulation == {"actuators": "(PROBE_LEG_ACTUATOR_1, PROBE_LEG_ACTUATOR_2)"}


@pytest.mark.parametrize("unnamed", [False, True], ids=["named", "unnamed"])
def test_pattern_of_the_author(unnamed: bool) -> None:
    """`.*` stands where it is exact; not where it would also match a joint without a name."""
    model = LEG.replace('name="rod" type="slide"', "" if unnamed else 'name="toe"')
    found = written(group(**SAME), model, robot="")
    ((_, fields),) = found.cfgs.values()
    assert fields["target_names_expr"] == (("hip", "calf") if unnamed else (".*",))


def test_names_of_strangers_are_escaped() -> None:
    """A joint's name cannot leave its literal or its comment, and matches only itself."""
    name = 'a"""\\b.c\u2028#('
    model = LEG.replace('name="hip"', f"name='{name}'")
    found = written(group(**LIMIT, joints="['a.*']", velocity_limit="3 rad/s"), model)
    ((_, fields),) = found.cfgs.values()
    assert fields["target_names_expr"] == ("a.*",)
    assert found.lost("velocity_limit").joint == name
    model = model.replace('name="calf"', 'name="x/calf"').replace('name="rod" type="slide"', 'name="x/rod"')
    short = written(group(**SAME), model, robot="")
    ((_, fields),) = short.cfgs.values()
    assert fields["target_names_expr"] == (re.escape(name), "calf", "rod")


def test_older_version_wraps_delay_and_lacks_viscous() -> None:
    """Before 1.3 a delay is a wrapper, viscous friction stays the model's, and its size is that of 60 rad/s."""
    fields = {**DC, "delay": "10 ms", "friction": "{viscous: 0.5 N*m*s/rad}"}
    found = written(group(**fields), version="1.2")
    kind, outer = found.cfg
    assert kind == "DelayedActuatorCfg"
    base, inner = outer.pop("base_cfg")
    assert outer == {"delay_target": "position", "delay_min_lag": 2, "delay_max_lag": 2}
    assert base == "DcMotorActuatorCfg"
    assert inner == {
        "target_names_expr": ("hip",),
        "stiffness": 25.0,
        "damping": 0.5,
        **LINE,
        "armature": 0.003,
        "frictionloss": 0.04,
    }
    loss = found.lost("friction.viscous")
    assert (loss.asked, loss.emitted) == ("0.5 N*m*s/rad", "0.1 N*m*s/rad")
    # (0.5 - 0.1) x 2 x 30 rad/s.
    assert loss.max_torque_error == pytest.approx(24.0)


def test_older_version_keeps_the_models_armature() -> None:
    """Before 1.3 a field that is left out is 0, so a spec's `unknown` is written as the model's number."""
    fields = group(**LIMIT, armature="unknown", friction="{coulomb: unknown}")
    assert written(fields, version="1.6").cfg[1].keys() & MODEL.keys() == {"viscous_damping"}
    old = written(fields, version="1.2").cfg[1]
    assert (old["armature"], old["frictionloss"]) == (0.003, 0.04)


@pytest.mark.parametrize("version", ["1.0", "1.1", "1.2", "1.3", "1.4", "1.5", "1.6", "1.5.3"])
def test_versions(version: str) -> None:
    """Every known release is written, and says whether it is one that the tests run."""
    text = written(group(**DC, delay="10 ms"), version=version).text
    assert ("not run with it" in text) == (version in ("1.1", "1.4"))
    assert ("DelayedActuatorCfg(" in text) == (version in ("1.0", "1.1", "1.2"))
    assert ("viscous_damping=" in text) == (version not in ("1.0", "1.1", "1.2"))


PASSIVE = {"armature", "frictionloss"}
DELAY = {"delay_min_lag", "delay_max_lag", "delay_update_period", "delay_per_env_phase"}
GAINS = {"stiffness", "damping", "effort_limit"}
OWN_FIELDS = {
    "BuiltinPositionActuatorCfg": GAINS,
    "BuiltinVelocityActuatorCfg": {"damping", "effort_limit"},
    "BuiltinMotorActuatorCfg": {"effort_limit"},
    "IdealPdActuatorCfg": GAINS,
    "DcMotorActuatorCfg": {*GAINS, "saturation_effort", "velocity_limit"},
}
"""Fields of each class beside those of its base, read in the wheels of 1.0 to 1.6: the same in all."""


@pytest.mark.parametrize("version", ["1.0", "1.1", "1.2", "1.3", "1.4", "1.5", "1.6"])
@pytest.mark.parametrize(
    "fields",
    [LIMIT, DC, {**LIMIT, "command": "velocity", "kp": ""}, {**LIMIT, "kp": "0 N*m/rad"}],
    ids=["pd", "dc", "velocity", "no-kp"],
)
def test_fields_exist_in_that_version(fields: dict[str, str], version: str) -> None:
    """No field is written that the release's class does not have; 1.3 gave the base viscous_damping and delay_*."""
    old = version in ("1.0", "1.1", "1.2")
    episode = "{nominal: 5 ms, range: [0 ms, 10 ms], sampling: episode}"
    kind, said = written(group(**fields, delay=episode), version=version).cfg
    if old:
        assert kind == "DelayedActuatorCfg"
        kind, inner = said.pop("base_cfg")
        assert said.keys() == {*DELAY, "delay_target"}
        said = inner
    base = PASSIVE | {"target_names_expr"} | (set() if old else {*DELAY, "viscous_damping"})
    assert said.keys() <= base | OWN_FIELDS[kind]


OWN = """
  <actuator><position name="servo" joint="hip" kp="7"/><motor name="other" joint="calf"/></actuator>
</mujoco>"""


def test_prepare_only_where_needed() -> None:
    """A model without actuators is left alone; one with its own, or with a narrower force range, is prepared."""
    assert "prepare_spec" not in written(group(**LIMIT)).text
    own = written(group(**LIMIT), LEG.replace("</mujoco>", OWN))
    assert own.constants["DRIVEN_JOINTS"] == ("hip",)
    assert "def prepare_spec" in own.text
    narrow = LEG.replace('<joint name="hip"', '<joint name="hip" actuatorfrcrange="-23 24"')
    assert 'spec.joint("hip").actfrcrange = (-24.0, 24.0)' in written(group(**LIMIT), narrow).text
    wide = LEG.replace('<joint name="hip"', '<joint name="hip" actuatorfrcrange="-24 25"')
    assert "prepare_spec" not in written(group(**LIMIT), wide).text


def test_scale_and_pose() -> None:
    """Action scale and default pose are dicts of exact patterns; what nobody states is not in them."""
    found = written(
        group(**LIMIT, joints="[hip, calf]", action_scale="0.25"),
        robot='unmanaged: ["rod"], default_pose: {calf: -1.5 rad}',
    )
    assert found.constants["PROBE_ACTION_SCALE"] == {"hip": 0.25, "calf": 0.25}
    assert found.constants["PROBE_JOINT_POS"] == {"calf": -1.5}


def test_pose_in_the_authors_patterns() -> None:
    """A pattern of `default_pose` stands where it names exactly the joints of its value; group patterns do next."""
    rest = 'unmanaged: ["rod"], default_pose: {%s}'
    both = group(**LIMIT, joints='["[hc].*"]')
    found = written(both, robot=rest % '".*(p|lf)": 0.3 rad')
    assert found.constants["PROBE_JOINT_POS"] == {".*(p|lf)": 0.3}
    # The same value by two patterns stays two, and one that reaches an unmanaged joint too is not written.
    found = written(both, robot=rest % 'hi.: 0.3 rad, "ca.*": 0.3 rad')
    assert found.constants["PROBE_JOINT_POS"] == {"hi.": 0.3, "ca.*": 0.3}
    found = written(group(**LIMIT, joints='["[hc].*"]'), robot=rest % '"[hcr].*": 0.1 rad')
    assert found.constants["PROBE_JOINT_POS"] == {"[hc].*": 0.1}


@pytest.mark.parametrize(
    ("fields", "version", "explicit"),
    [
        (LIMIT, "1.6", False),
        ({**LIMIT, "command": "velocity", "kp": ""}, "1.6", False),
        ({**LIMIT, "command": "velocity", "kp": ""}, "1.2", True),
        ({**LIMIT, "kp": "0 N*m/rad"}, "1.6", True),
        (DC, "1.6", True),
    ],
    ids=["position", "velocity", "velocity-before-1.3", "no-kp", "dc"],
)
def test_explicit_drives(fields: dict[str, str], version: str, explicit: bool) -> None:
    """MuJoCo takes kd of a builtin actuator implicitly; the other classes compute a torque before the step."""
    found = written(group(**fields), version=version).emission.explicit
    assert found == (frozenset({"hip"}) if explicit else frozenset())


def test_header_and_layout() -> None:
    """The header names tool, spec and losses; code and comments keep mjlab's 88 columns and two spaces."""
    found = written(group(**LIMIT, delay="7 ms"))
    assert f"# spec sha256 {found.actuators.spec_sha256}\n" in found.text
    assert "# model robot.xml\n" in found.text
    assert "timestep=0.005" in found.text
    assert "decimation=4" in found.text
    assert re.search(r"# - delay: 7 ms -> 1 step of 5 ms; at most 12 N\*m", found.text)
    assert max(map(len, found.text.splitlines())) <= 88
    assert not [line for line in found.text.splitlines() if line.startswith("   ") and line[4] == " "]
    ast.parse(found.text)


def test_same_input_same_bytes() -> None:
    """Two runs write the same bytes, without a time and without a path."""
    first, second = (written(group(**DC, delay="10 ms")).emission.files for _ in range(2))
    assert first == second
    assert [file.path for file in first] == ["probe_cfg.py"]
