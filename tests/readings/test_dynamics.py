"""Effective dynamics of a joint from its rows and its file."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.audit.build import case_of
from actspec.audit.read import read_files
from actspec.readings.dynamics import RobotDynamics, dynamics_of, figure
from actspec.readings.versions import Versions
from tests.audit.making import row
from tests.audit.robots import CFG, LEG, SPEC


def dynamics(tmp_path: Path, name: str, text: str) -> RobotDynamics:
    """Of a file beside the model."""
    (tmp_path / "leg.xml").write_text(LEG)
    (tmp_path / name).write_text(text)
    case = case_of(read_files([str(tmp_path / name)]), Versions(), {})
    return dynamics_of(case.artifacts[0], case.rows_of(0))


def test_actuators_of_a_joint_add_up() -> None:
    """A position and a velocity actuator are one PD; what is the joint's counts once; one unknown makes a sum so."""
    rows = [
        row("a.xml", "knee", kp=100.0, kd=0.0, joint_damping=0.5, stated=frozenset({"kp"})),
        row("a.xml", "knee", kp=0.0, kd=3.0, joint_damping=0.5),
    ]
    assert [figure(rows, name).value for name in ("kp", "kd", "joint_damping")] == [100.0, 3.0, 0.5]
    assert [figure(rows, name).stated for name in ("kp", "kd")] == [True, False]
    assert figure([*rows, row("a.xml", "knee", kp=1.0)], "kd").value is None


@pytest.mark.parametrize("gear, expected", [("1", None), ("-1", -1.0)])
def test_a_motor_with_a_target_and_a_negative_gear(gear: str, expected: float | None, tmp_path: Path) -> None:
    """At rest its torque gear kp (u - gear q) is 0: q = u / gear."""
    motor = f'<dcmotor nominal="24 33.5 1e9" input="pos" controller="25 0 2 0 0 24" gear="{gear}" '
    text = LEG.replace('<position name="knee" joint="knee" kp="100" kv="3" ', f'{motor}joint="knee" ')
    found = dynamics(tmp_path, "a.xml", text).joints["knee"]
    assert found.control == "dcmotor"
    gain = found.figures.get("command_gain")
    assert (None if gain is None else gain.value) == expected


@pytest.mark.parametrize(
    "name, text, settings",
    [
        ("a.xml", LEG, {"physics_dt": 0.002, "integrator": "implicitfast"}),
        ("leg.yaml", SPEC, {"physics_dt": 0.002, "decimation": 10.0, "control_dt": 0.02}),
        ("leg_cfg.py", CFG, {}),
        (
            "b.xml",
            LEG.replace('integrator="implicitfast"/>', '><flag eulerdamp="disable"/></option>'),
            {"physics_dt": 0.002, "integrator": "Euler without eulerdamp"},
        ),
    ],
    ids=["mjcf", "spec", "cfg", "eulerdamp"],
)
def test_settings(name: str, text: str, settings: dict[str, float | str], tmp_path: Path) -> None:
    """Steps, and the control period that follows from them."""
    assert dynamics(tmp_path, name, text).settings == pytest.approx(settings)


def test_what_a_spec_says_beyond_the_ledger(tmp_path: Path) -> None:
    """Break-away friction, the command filter and the ends of a delay's range are in it."""
    text = SPEC.replace("{viscous: 1 N*m*s/rad}", "{viscous: 1 N*m*s/rad, coulomb: 0.2 N*m, static: 0.3 N*m}")
    text += "    command_filter: {cutoff: 30 Hz}\n    delay: {nominal: 4 ms, range: [2 ms, 8 ms]}\n"
    text += "    encoder_bias: 0.01 rad\n"
    found = dynamics(tmp_path, "leg.yaml", text).joints["knee"].figures
    expected = {
        "friction_static": (0.3, "N*m"),
        "filter_cutoff": (30.0, "Hz"),
        "delay": (0.004, "s"),
        "delay_low": (0.002, "s"),
        "delay_high": (0.008, "s"),
        "encoder_bias": (0.01, "rad"),
    }
    assert {name: (found[name].value, found[name].unit) for name in expected} == expected


def test_links_without_armature(tmp_path: Path) -> None:
    """The links' inertia does not move with the armature: a ball of 0.1 m and 1000 kg/m^3 about its centre."""
    found = dynamics(tmp_path, "a.xml", LEG.replace('armature="0.01"', 'armature="0.5"')).joints["knee"]
    # 2/5 * (4/3 pi 0.1^3 * 1000) * 0.1^2 = 0.0167552
    assert found.inertia == pytest.approx((0.0167552, 0.0167552), rel=1e-5)
    assert found.figures["armature"].value == 0.5
