"""Rows of robot files: hand-computed models of each shortcut, and real files against the engine's own forces."""

from __future__ import annotations

import math
import os
from functools import cache
from importlib import metadata
from pathlib import Path

import mujoco
import numpy as np
import pytest

from actspec.diagnostics import RobotError
from actspec.ir import JointKind
from actspec.readings.artifact import Artifact, FileKind, FileReading
from actspec.readings.ledger import LedgerRow, rows_of_robot, rows_of_spec
from actspec.readings.read import read_robot
from actspec.robot.mjspec import compile_spec, open_spec, quiet
from actspec.robot.view import ModelFormat
from actspec.robot.xml import open_document

ROOT = Path(__file__).resolve().parents[2]
CORPUS = Path(os.environ.get("ACTSPEC_CORPUS", ROOT.parent / "shared" / "corpus"))
TORQUE_SPACE = hasattr(mujoco.mjtGain, "mjGAIN_PID")
"""MuJoCo 3.12 and later: dcmotor gains are torques, and `pid` is there."""
HUGE = 1e7
"""Far outside every range of a real robot."""
EXACT = 1e-9
"""Relative; a few operations in double precision."""
MEASURED = 1e-6
"""Relative; differences of forces over a step of 1e-3, which are linear but for rounding."""


@pytest.fixture(autouse=True)
def _in_tmp_path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def one_joint(joint: str, actuators: str, head: str = "", tail: str = "") -> str:
    """A model of one body: inertia 1 kg*m^2 about its only joint."""
    return f"""<mujoco>{head}<worldbody><body name="b">{joint}
<inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/><site name="s"/></body></worldbody>
{tail}<actuator>{actuators}</actuator></mujoco>"""


def rows(text: str, name: str = "m.xml") -> tuple[LedgerRow, ...]:
    """The ledger of one robot file."""
    Path(name).write_text(text)
    reading = read_robot(name, keep_matrices=False)
    assert reading.reason is None, reading.reason
    return rows_of_robot(reading.artifacts[0], 0)


def row(actuator: str, joint: str = '<joint name="j"/>', head: str = "") -> LedgerRow:
    """The row of one actuator on `one_joint`."""
    (found,) = rows(one_joint(joint, actuator, head))
    return found


SHORTCUTS = [
    # gear 3: kp 9 * 7, kd 9 * 2, limit 3 * 5; a command of 1.5 at the actuator is 0.5 rad.
    (
        '<position joint="j" gear="3" kp="7" kv="2" forcerange="-5 4" ctrlrange="-1.5 3"/>',
        {"control": "position", "kp": 63.0, "kd": 18.0, "effort_limit": 15.0, "command_range": (-0.5, 1.0)},
    ),
    (
        '<velocity joint="j" gear="2" kv="3"/>',
        {"control": "velocity", "kp": 0.0, "kd": 12.0, "effort_limit": math.inf},
    ),
    # |gear| 2 * 10 is below 2 * 11 of the force range; torques at the joint have the gear's sign.
    (
        '<motor joint="j" gear="-2" ctrlrange="-10 9" forcerange="-11 11"/>',
        {"control": "motor", "kp": 0.0, "kd": 0.0, "effort_limit": 20.0, "command_range": (-18.0, 20.0)},
    ),
    # gain 4 * control 2 + offset 1 = 9; the other end is -7.
    (
        '<general joint="j" gainprm="4" biastype="affine" biasprm="1 0 0" ctrlrange="-2 2"/>',
        {"control": "motor", "kp": 0.0, "kd": 0.0, "effort_limit": 9.0},
    ),
    # A motor with its own damping: the control does not bound the torque.
    (
        '<general joint="j" gainprm="4" biastype="affine" biasprm="0 0 -3" ctrlrange="-2 2"/>',
        {"control": "motor", "kp": 0.0, "kd": 3.0, "effort_limit": math.inf},
    ),
    (
        '<general joint="j" gainprm="50" biastype="affine" biasprm="0 -50 -2" forcerange="-6 6"/>',
        {"control": "position", "kp": 50.0, "kd": 2.0, "effort_limit": 6.0, "kd_clamped": True},
    ),
    # 1 N*m a unit of control, 50 a rad: -100 and 25 are -2 and 0.5 rad.
    (
        '<general joint="j" gainprm="1" biastype="affine" biasprm="0 -50 -2" ctrlrange="-100 25"/>',
        {"control": "position", "kp": 50.0, "command_range": (-2.0, 0.5)},
    ),
    # Of a byte: -120 / 60 = -2 and (0.5 x 255 - 120) / 60 = 0.125 at the actuator, half of that behind a gear of 2.
    (
        '<general joint="j" gear="2" gainprm="0.5" biastype="affine" biasprm="-120 -60 0" ctrlrange="0 255"/>',
        {"control": "position", "kp": 240.0, "command_range": (-1.0, 0.0625)},
    ),
    # (2 x 3 + 4) / 2 = 5 rad/s, and (2 x -3 + 4) / 2 = -1.
    (
        '<general joint="j" gainprm="2" biastype="affine" biasprm="4 0 -2" ctrlrange="-3 3"/>',
        {"control": "velocity", "kd": 2.0, "command_range": (-1.0, 5.0)},
    ),
    # Its activation is the target; its control, here to 9 rad/s, fills that.
    (
        '<intvelocity joint="j" kp="4" kv="1" actrange="-1 2" ctrlrange="-9 9"/>',
        {"control": "other", "kp": 4.0, "kd": 1.0, "command_range": (-1.0, 2.0), "effort_limit": math.inf},
    ),
    # 20 x 2 and 20 x 2 x 3: MuJoCo 4.0 never gives more, whatever is commanded.
    (
        '<general joint="j" dyntype="integrator" actlimited="true" actrange="-1 2" gainprm="20"/>',
        {"control": "other", "kp": 0.0, "kd": 0.0, "effort_limit": 40.0},
    ),
    (
        '<general joint="j" dyntype="integrator" actrange="-1 2" gainprm="20" gear="3"/>',
        {"control": "other", "effort_limit": 120.0},
    ),
    # The control is a rate, and limits no torque.
    (
        '<general joint="j" dyntype="integrator" ctrlrange="-1 1" gainprm="20"/>',
        {"control": "other", "effort_limit": math.inf},
    ),
    # Of a filter both do: the lower is 1.5.
    (
        '<general joint="j" dyntype="filter" dynprm="0.05" actrange="-1 2" ctrlrange="-1.5 1.5" gainprm="20"/>',
        {"control": "motor", "effort_limit": 30.0, "command_range": (-20.0, 30.0)},
    ),
    (
        '<general joint="j" dyntype="filterexact" actlimited="false" actrange="-1 2" gainprm="20"/>',
        {"control": "motor", "effort_limit": math.inf},
    ),
    # How much a damper and a muscle brake, their control decides; what bounds a muscle, it does itself.
    (
        '<damper joint="j" kv="2" ctrlrange="0 1"/>',
        {"control": "other", "kp": 0.0, "kd": None, "total_damping": None, "effort_limit": math.inf},
    ),
    (
        '<muscle joint="j" force="30"/>',
        {"control": "other", "kp": None, "kd": None, "total_damping": None, "effort_limit": None},
    ),
    (
        '<muscle joint="j" force="30" forcerange="-40 0"/>',
        {"control": "other", "kp": None, "effort_limit": 40.0},
    ),
    (
        '<general joint="j" gaintype="affine" gainprm="1 2 3"/>',
        {"control": "other", "kp": None, "kd": None, "effort_limit": None},
    ),
    # 210 bar on 8 cm^2: MuJoCo never gives more than 16,800 N, whatever is commanded.
    (
        '<cylinder joint="j" timeconst="0.05" area="0.0008" ctrlrange="-2.1e7 2.1e7"/>',
        {"control": "motor", "kp": 0.0, "kd": 0.0, "effort_limit": 16800.0},
    ),
    # gear^2 = 4.
    (
        '<cylinder joint="j" area="2" bias="0 -3 -5" gear="2"/>',
        {"control": "other", "kp": 12.0, "kd": 20.0, "effort_limit": math.inf},
    ),
    # K = 24/30 = 0.8, R = 0.8 * 24 / 6 = 3.2; K^2/R = 0.2, at the joint 4 * 0.2.
    (
        '<dcmotor joint="j" gear="2" nominal="24 6 30" saturation="5 0 0"/>',
        {
            "control": "dcmotor",
            "kp": 0.0,
            "kd": 0.8,
            "back_emf": 0.8,
            "effort_limit": 10.0,
            "stall_torque": None,
        },
    ),
    (
        '<motor joint="j" delay="0.01" nsample="5"/>',
        {"control": "motor", "delay": 0.01, "kd_implicit": False, "kd_clamped": False},
    ),
]
if TORQUE_SPACE:
    SHORTCUTS += [
        # Stall torque 0.8 * 24 / 3.2 = 6, at the joint 12; no-load speed 30 / 2.
        (
            '<dcmotor joint="j" gear="2" nominal="24 6 30" input="pos" controller="10 0 1 0 0 24"/>',
            {
                "control": "dcmotor",
                "kp": 40.0,
                "kd": 4.0,
                "back_emf": 0.0,
                "stall_torque": 12.0,
                "no_load_speed": 15.0,
            },
        ),
        ('<pid joint="j" kp="5" kv="2" input="pos"/>', {"control": "pid", "kp": 5.0, "kd": 2.0}),
    ]


@pytest.mark.parametrize(
    ("actuator", "expected"), SHORTCUTS, ids=[a.split('"/')[0][1:60] for a, _ in SHORTCUTS]
)
def test_each_shortcut(actuator: str, expected: dict[str, object]) -> None:
    """Gains have gear^2 in them, limits |gear|, commands 1/gear."""
    found = row(actuator)
    for name, value in expected.items():
        got = getattr(found, name)
        assert got == (pytest.approx(value, rel=EXACT) if isinstance(value, float) else value), name


def test_joint_figures_are_those_of_all_its_actuators() -> None:
    """Two servos and passive damping: each row has its own gains and the joint's sums."""
    text = one_joint(
        '<joint name="j" damping="0.5" armature="0.2" frictionloss="0.3" actuatorfrcrange="-9 8"/>',
        '<position name="p" joint="j" kp="16" forcerange="-4 4"/>'
        '<velocity name="v" joint="j" gear="2" kv="1" forcerange="-3 3" damping="0.25" armature="0.05"/>',
        '<option timestep="0.01"/>',
    )
    p, v = rows(text)
    assert (p.actuator, p.kp, p.kd, p.actuator_damping) == ("p", 16.0, 0.0, 0.0)
    # gear 2: kd 4 * 1, damping 4 * 0.25
    assert (v.actuator, v.kp, v.kd, v.actuator_damping) == ("v", 0.0, 4.0, 1.0)
    for found in (p, v):
        # 0.5 joint + 1 actuator damping + 4 kd
        assert (found.joint_damping, found.total_damping, found.frictionloss) == (0.5, 5.5, 0.3)
        # 4 + 2 * 3 = 10 is above the joint's 9
        assert (found.effort_limit, found.kd_clamped) == (9.0, True)
        # 0.2 + 4 * 0.05
        assert found.armature == pytest.approx(0.4, rel=EXACT)
        assert found.inertia_min == found.inertia_max == pytest.approx(1.4, rel=EXACT)
        assert found.inertia_free_min == pytest.approx(1.4, rel=EXACT)
        assert found.natural_frequency == pytest.approx(math.sqrt(16 / 1.4), rel=EXACT)
        assert found.damping_ratio == pytest.approx(5.5 / (2 * math.sqrt(16 * 1.4)), rel=EXACT)
        # Euler takes kd explicitly and what is passive implicitly: 0.01 * 4 / 1.4
        assert found.stability == pytest.approx(0.04 / 1.4, rel=EXACT)


@pytest.mark.parametrize(
    ("actuators", "limit", "made"),
    [
        ('<motor joint="j" gear="100" forcerange="-39 39"/>', 3900.0, "39 x gear 100"),
        ('<motor joint="j" gear="-2" ctrlrange="-5 4"/>', 10.0, "5 x gear 2"),
        ('<motor joint="j" gear="-1" ctrlrange="-5 4"/>', 5.0, None),
        ('<general joint="j" gear="2" gainprm="3" ctrlrange="-5 5"/>', 30.0, "5 x gear 2 x gain 3"),
        ('<motor joint="j" forcerange="-39 39"/>', 39.0, None),
        (
            '<motor joint="j" gear="2" forcerange="-9 9"/><motor joint="j" forcerange="-4 4"/>',
            22.0,
            "9 x gear 2 + 4",
        ),
    ],
)
def test_a_limit_that_a_gear_makes(actuators: str, limit: float, made: str | None) -> None:
    """The row has what the file states beside the figure at the joint."""
    for found in rows(one_joint('<joint name="j"/>', actuators)):
        assert (found.effort_limit, found.made.get("effort_limit")) == (limit, made)


def test_the_line_of_two_motors() -> None:
    """10 - 10/20 w and 30 - 30/10 w are 40 - 3.5 w together, which ends at 11.43 rad/s."""
    motor = '<dcmotor joint="j" nominal="24 {} {}" input="pos" controller="20 0 1 0 0 24"/>'
    both = rows(one_joint('<joint name="j"/>', motor.format(10, 20) + motor.format(30, 10)))
    for found in both:
        assert found.stall_torque == pytest.approx(40.0)
        assert found.no_load_speed == pytest.approx(40.0 / 3.5)
    (alone,) = rows(one_joint('<joint name="j"/>', motor.format(10, 20)))
    assert (alone.stall_torque, alone.no_load_speed) == pytest.approx((10.0, 20.0))


def test_without_a_joint_limit_the_actuators_limits_add_up() -> None:
    """Two actuators of 4 and 2 * 3 N*m push 10 N*m together; an unlimited one takes the limit away."""
    limited = '<motor joint="j" ctrlrange="-4 4"/><motor joint="j" gear="2" forcerange="-3 3"/>'
    joint = '<joint name="j"/>'
    assert {r.effort_limit for r in rows(one_joint(joint, limited))} == {10.0}
    assert {r.effort_limit for r in rows(one_joint(joint, limited + '<motor joint="j"/>'))} == {math.inf}


@pytest.mark.parametrize(
    ("option", "explicit", "implicit"),
    [
        ("", 3.0, False),
        ('<option><flag eulerdamp="disable"/></option>', 4.75, False),
        ('<option integrator="RK4"/>', 4.75, False),
        ('<option integrator="implicitfast"/>', 0.0, True),
        ('<option integrator="implicit"/>', 0.0, True),
    ],
    ids=["euler", "euler-without-eulerdamp", "rk4", "implicitfast", "implicit"],
)
def test_stability_counts_what_the_engine_takes_explicitly(
    option: str, explicit: float, implicit: bool
) -> None:
    """One step from 5 rad/s loses h * explicit * 5 / I of what is explicit, less of what is implicit."""
    actuator = '<velocity name="v" joint="j" kv="3" damping="1.5"/>'
    text = one_joint('<joint name="j" damping="0.25"/>', actuator, option)
    (found,) = rows(text)
    assert found.stability == pytest.approx(0.002 * explicit, rel=EXACT)
    assert found.kd_implicit is implicit
    # 4.75 is kd with both dampings, so none of them is implicit there.
    passive = explicit != 4.75
    assert (found.joint_damping_implicit, found.actuator_damping_implicit) == (passive, passive)
    if "RK4" in option:
        return  # four stages: no one-step formula
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qvel[0] = 5.0
    mujoco.mj_step(model, data)
    h = 0.002
    # (1 + h * implicit) dv = -h * 4.75 * 5 with inertia 1; implicit part = 4.75 - explicit
    assert data.qvel[0] - 5.0 == pytest.approx(-h * 4.75 * 5.0 / (1.0 + h * (4.75 - explicit)), rel=1e-9)


def test_the_force_range_clamps_kd_and_no_other_damping() -> None:
    """At 10 rad/s a limit of 1 N*m leaves 1 of the 20 N*m of kd, and all of joint and actuator damping."""
    actuator = '<velocity joint="j" kv="2" damping="0.5" forcerange="-1 1"/>'
    text = one_joint('<joint name="j" damping="0.25"/>', actuator)
    (found,) = rows(text)
    assert (found.kd_clamped, found.joint_damping_clamped, found.actuator_damping_clamped) == (
        True,
        False,
        False,
    )
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qvel[0] = 10.0
    mujoco.mj_forward(model, data)
    assert (data.qfrc_actuator[0], data.qfrc_passive[0]) == pytest.approx((-1.0, -7.5), rel=EXACT)


def test_a_urdf_does_not_say_what_becomes_of_its_damping(tmp_path: Path) -> None:
    """One importer makes it passive, another the drive's gain: neither clamped nor implicit is known."""
    text = (
        '<robot name="r"><link name="a"/><link name="b"><inertial><mass value="1"/>'
        '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        '<joint name="j" type="continuous"><parent link="a"/><child link="b"/><dynamics damping="0.5"/></joint>'
        "</robot>"
    )
    path = tmp_path / "r.urdf"
    path.write_text(text, encoding="utf-8")
    (artifact,) = read_robot(str(path), keep_matrices=False).artifacts
    (found,) = rows_of_robot(artifact, 0)
    assert (found.joint_damping, found.joint_damping_clamped, found.joint_damping_implicit) == (
        0.5,
        None,
        None,
    )


def test_a_bare_joint_has_one_row_without_a_drive() -> None:
    """There is no drive, so its gains are not 0 but unknown; nothing limits what is not there."""
    (found,) = rows(one_joint('<joint name="j" damping="0.5" type="slide" range="-1 1"/>', ""))
    assert (found.control, found.kind, found.kp, found.kd) == ("none", JointKind.SLIDE, None, None)
    assert (found.total_damping, found.effort_limit, found.position_range) == (0.5, math.inf, (-1.0, 1.0))
    assert (found.natural_frequency, found.damping_ratio, found.default_position) == (None, None, None)
    assert found.span.line == 1
    assert found.stated == {"joint_damping", "position_range"}


MOVED = [
    # A motor adds no gain: damping stays what it is, and the limit is unknown.
    ('<motor tendon="t" ctrlrange="-3 3"/>', {"total_damping": 0.5, "armature": 0.25}),
    ('<position tendon="t" kp="3" kv="1"/>', {"total_damping": None, "stability": None, "armature": 0.25}),
    (
        '<motor tendon="t" damping="0.1" armature="0.2"/>',
        {"total_damping": None, "stability": None, "armature": None},
    ),
    # Switched off it gives no force, but keeps its rotor.
    (
        '<position tendon="t" kp="3" kv="1" group="3" armature="0.2"/>',
        {"total_damping": 0.5, "armature": None, "effort_limit": math.inf},
    ),
]


@pytest.mark.parametrize(("actuator", "expected"), MOVED, ids=["motor", "servo", "rotor", "off"])
def test_what_a_tendon_does_to_a_joint_is_unknown(actuator: str, expected: dict[str, float | None]) -> None:
    """Nobody says that a joint which only a tendon moves has no limit and no damping but its own."""
    found = rows(
        one_joint(
            '<joint name="j" damping="0.5" armature="0.25"/>',
            actuator,
            head='<option actuatorgroupdisable="3"/>',
            tail='<tendon><fixed name="t"><joint joint="j" coef="2"/></fixed></tendon>',
        )
    )[0]
    assert (found.control, found.joint_damping) == ("none", 0.5)
    wanted = {"effort_limit": None, "stability": 0.0, **expected}
    assert {name: getattr(found, name) for name in wanted} == wanted


def test_a_clamp_of_the_joint_holds_for_tendons_too() -> None:
    """MuJoCo clamps what all actuators do to a joint together, also beside a drive without a limit."""
    joint = '<joint name="j" actuatorfrcrange="-4 3"/>'
    tendon = '<tendon><fixed name="t"><joint joint="j" coef="2"/></fixed></tendon>'
    drives = '<position joint="j" kp="9"/><motor tendon="t"/>'
    assert rows(one_joint(joint, drives, tail=tendon))[0].effort_limit == 4.0
    beside, _ = rows(one_joint('<joint name="j"/>', drives, tail=tendon))
    # kp = 9 at an inertia of 1: the motor adds none.
    assert (beside.effort_limit, beside.natural_frequency) == (None, 3.0)


def test_what_drives_no_joint_has_a_row_without_one() -> None:
    """A tendon's and a site's actuators are told by their control and what they drive, after the joints."""
    text = one_joint(
        '<joint name="j"/>',
        '<position name="t" tendon="t" kp="3"/><motor name="s" site="s" gear="1 0 0 0 0 0"/>',
        tail='<tendon><fixed name="t"><joint joint="j" coef="2"/></fixed></tendon>',
    )
    found = rows(text)
    assert [(r.joint, r.actuator, r.control, r.drives, r.kp) for r in found] == [
        ("j", "", "none", "", None),
        ("", "t", "position", "tendon t", None),
        ("", "s", "motor", "site s", None),
    ]


def test_rows_stand_in_joint_order() -> None:
    """The order is that of the joints, not that of the actuators."""
    text = """<mujoco><worldbody><body><joint name="a"/><geom size="1"/><body><joint name="b"/><geom size="1"/>
</body></body></worldbody><actuator><motor name="mb" joint="b"/><motor name="ma" joint="a"/></actuator></mujoco>"""
    assert [(r.joint, r.actuator) for r in rows(text)] == [("a", "ma"), ("b", "mb")]


def test_places_and_what_is_stated() -> None:
    """A figure from a default class is placed there; an engine's default is not stated."""
    text = """<mujoco>
<default><joint damping="0.5"/>
<default class="leg"><position kp="7" forcerange="-3 3"/></default></default>
<worldbody><body>
<joint name="j" armature="0.1"/>
<geom size="1"/></body></worldbody>
<actuator>
<position class="leg" joint="j" kv="2"/>
</actuator></mujoco>"""
    (found,) = rows(text)
    lines = {
        name: found.place(name).line for name in ("kp", "kd", "effort_limit", "joint_damping", "armature")
    }
    assert lines == {"kp": 3, "kd": 8, "effort_limit": 3, "joint_damping": 2, "armature": 5}
    assert found.stated == {"kp", "kd", "effort_limit", "joint_damping", "armature"}


@pytest.mark.parametrize(
    ("own", "lines", "gains"),
    [
        # The element's biasprm takes the place of what its class's kp and kv make: kp is -30, at its own line.
        (
            '<general class="leg" joint="j" gainprm="30" biastype="affine" biasprm="0 30 -0.8"/>',
            (7, 7),
            (-30, 0.8),
        ),
        ('<position class="leg" joint="j"/>', (2, 2), (7, 0.5)),
        ('<position class="leg" joint="j" kv="2"/>', (2, 7), (7, 2)),
        # Of a class of general actuators, whose biasprm states both.
        ('<position class="arm" joint="j" kp="9"/>', (7, 3), (9, 4)),
    ],
)
def test_a_gain_is_placed_where_it_comes_from(
    own: str, lines: tuple[int, int], gains: tuple[float, float]
) -> None:
    """The element goes before its class, whichever attributes they have it in."""
    text = f"""<mujoco><default>
<default class="leg"><position kp="7" kv="0.5"/></default>
<default class="arm"><general gainprm="6" biastype="affine" biasprm="0 -6 -4"/></default></default>
<worldbody><body>
<joint name="j"/><geom size="1"/></body></worldbody>
<actuator>
{own}
</actuator></mujoco>"""
    (found,) = rows(text)
    assert (found.place("kp").line, found.place("kd").line) == lines
    assert (found.kp, found.kd) == gains


def test_default_position_is_the_keyframes() -> None:
    """qpos0 alone is nobody's default pose."""
    actuator = '<motor joint="j"/>'
    joint = '<joint name="j" ref="10"/>'
    assert rows(one_joint(joint, actuator))[0].default_position is None
    (found,) = rows(one_joint(joint, actuator, tail='<keyframe><key qpos="0.7"/></keyframe>'))
    assert found.default_position == 0.7


def test_a_urdf_keeps_zero_and_says_what_it_states() -> None:
    """Effort 0 stays 0; what is absent is None, damping and friction 0 without being stated."""
    text = """<robot name="r"><link name="a"/><link name="b"/><link name="c"/>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/>
<limit lower="-1" upper="2" effort="0" velocity="0"/><dynamics damping="0.3"/></joint>
<joint name="k" type="continuous"><parent link="b"/><child link="c"/></joint></robot>"""
    j, k = rows(text, "r.urdf")
    assert (j.control, j.effort_limit, j.velocity_limit, j.joint_damping, j.frictionloss) == (
        "none",
        0.0,
        0.0,
        0.3,
        0.0,
    )
    assert (j.total_damping, j.armature, j.position_range) == (0.3, None, (-1.0, 2.0))
    assert j.stated == {"effort_limit", "velocity_limit", "joint_damping", "position_range"}
    assert (k.effort_limit, k.velocity_limit, k.joint_damping, k.stated) == (None, None, 0.0, frozenset())


def test_what_the_text_does_not_tell_is_none() -> None:
    """A file that MuJoCo refuses: dampratio and springdamper need a compilation, the rest is there."""
    text = one_joint(
        '<joint name="j" springdamper="0.1 1" armature="0.2"/>',
        '<position joint="j" kp="7" dampratio="1" forcerange="-3 3"/>',
        head='<option nonsense="1"/>',
    )
    Path("m.xml").write_text(text)
    artifact = read_robot("m.xml", keep_matrices=False).artifacts[0]
    assert artifact.text_only is not None and "nonsense" in artifact.text_only
    (found,) = rows_of_robot(artifact, 0)
    assert (found.kp, found.effort_limit, found.armature) == (7.0, 3.0, 0.2)
    unknown = (
        "kd",
        "joint_damping",
        "total_damping",
        "inertia_min",
        "inertia_free_min",
        "natural_frequency",
        "stability",
    )
    assert [getattr(found, name) for name in unknown] == [None] * len(unknown)


def test_rows_of_a_spec() -> None:
    """The rows of robots/a1.yaml are what the spec says: kp 25, kd 0.5, friction 0.2 and 0.01, line 33.5 at 0."""

    from actspec.audit.read import read_file

    reading = read_file(str(ROOT / "robots" / "a1.yaml"))
    assert (reading.kind, reading.reason) == (FileKind.SPEC, None)
    found = rows_of_spec(reading.artifacts[0], 4)
    assert len(found) == 12
    first = found[0]
    assert (first.artifact, first.control, first.actuator) == (4, "dc_motor", "legs")
    assert (first.kp, first.kd, first.joint_damping, first.frictionloss) == (25.0, 0.5, 0.01, 0.2)
    assert (first.total_damping, first.effort_limit, first.stall_torque) == (0.51, 33.5, 33.5)
    assert (first.delay, first.stability, first.kd_implicit) == (None, None, None)
    assert {"kp", "kd", "effort_limit"} <= first.stated


@cache
def _real() -> list[Path]:
    found = sorted(CORPUS.rglob("*.xml"))
    try:
        wheel = metadata.distribution("mjlab")
    except metadata.PackageNotFoundError:
        return found
    return found + [Path(str(wheel.locate_file(f))) for f in wheel.files or () if str(f).endswith(".xml")]


class Engine:
    """What a compiled model does, by its forces alone."""

    def __init__(self, model: mujoco.MjModel) -> None:
        """Take a model, whose constraints are switched off."""
        self.model = model
        model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        self.data = mujoco.MjData(model)

    def forces(
        self, joint: int, q: float = 0.0, w: float = 0.0, ctrl: float = 0.0
    ) -> tuple[np.ndarray, float, float]:
        """Force of every actuator, and actuator and passive force at a joint, moved away from the origin."""
        m, d = self.model, self.data
        mujoco.mj_resetData(m, d)
        d.qpos[m.jnt_qposadr[joint]] += q
        d.qvel[m.jnt_dofadr[joint]] = w
        d.ctrl[:] = ctrl
        with quiet():
            mujoco.mj_forward(m, d)
        dof = int(m.jnt_dofadr[joint])
        return d.actuator_force.copy(), float(d.qfrc_actuator[dof]), float(d.qfrc_passive[dof])

    def unclamped(self) -> Engine:
        """The same without any clamp of force."""
        import copy

        model = copy.copy(self.model)
        model.actuator_forcelimited[:] = 0
        model.jnt_actfrclimited[:] = 0
        return Engine(model)

    def armature(self, joint: int) -> float:
        """What armature adds to the mass matrix."""
        import copy

        bare = copy.copy(self.model)
        bare.dof_armature[:] = 0
        bare.actuator_armature[:] = 0
        values = []
        for model in (self.model, bare):
            data = mujoco.MjData(model)
            mujoco.mj_setConst(model, data)
            mujoco.mj_forward(model, data)
            dof = int(model.jnt_dofadr[joint])
            values.append(float(data.M[model.M_rowadr[dof] + model.M_rownnz[dof] - 1]))
        return values[0] - values[1]

    def friction(self, joint: int) -> float:
        """The dry friction among the constraints."""
        m, d = self.model, self.data
        flags = m.opt.disableflags
        m.opt.disableflags = flags & ~int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
        m.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
        mujoco.mj_resetData(m, d)
        with quiet():
            mujoco.mj_forward(m, d)
        m.opt.disableflags = flags
        kind = int(mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF)
        dof = int(m.jnt_dofadr[joint])
        return sum(
            float(d.efc_frictionloss[i])
            for i in range(d.nefc)
            if d.efc_type[i] == kind and d.efc_id[i] == dof
        )


SERVO = (
    '<position name="p" joint="j" kp="10" kv="1" damping="0.7" armature="0.5" group="2" forcerange="-3 3"/>'
)
MOTOR = '<motor name="m" joint="j" ctrlrange="-4 4"/>'
DAMPED = '<joint name="j" damping="0.1"/>'


@pytest.mark.parametrize("refused", [False, True], ids=["compiled", "text"])
@pytest.mark.parametrize(
    ("option", "off"),
    [
        ('<option actuatorgroupdisable="1 2"/>', ("p",)),
        ('<option actuatorgroupdisable="0"/>', ("m",)),
        ('<option><flag actuation="disable"/></option>', ("p", "m")),
    ],
    ids=["its-group", "the-other-group", "all"],
)
def test_an_actuator_that_is_switched_off_gives_no_force(
    option: str, off: tuple[str, ...], refused: bool
) -> None:
    """Its gains and limit are in no sum; its damping 0.7 and armature 0.5 stay, as in MuJoCo's own forces."""
    text = one_joint(DAMPED, SERVO + MOTOR, option + ("<nonsense/>" if refused else ""))
    servo, motor = rows(text)
    on = "p" not in off
    assert [row.control for row in (servo, motor)] == [
        "position" if on else "other",
        "motor" if "m" not in off else "other",
    ]
    assert (servo.joint, servo.kp, servo.kd) == ("j", 10.0 if on else 0.0, 1.0 if on else 0.0)
    # 0.1 of the joint, 0.7 of the actuator, and the drive's 1.
    assert servo.total_damping == pytest.approx(1.8 if on else 0.8, rel=EXACT)
    assert (servo.actuator_damping, servo.armature) == (0.7, 0.5)
    # Of a compiled file the inertia is known, 1 + 0.5.
    frequency = math.sqrt(10 / 1.5) if on and not refused else None
    assert servo.natural_frequency == (frequency and pytest.approx(frequency, rel=EXACT))
    # 3 of the servo and 4 of the motor; with neither nothing bounds the joint.
    limit = 3.0 * on + 4.0 * ("m" not in off)
    assert servo.effort_limit == motor.effort_limit == (limit or math.inf)


@pytest.mark.parametrize("refused", [False, True], ids=["compiled", "text"])
def test_without_clampctrl_a_control_range_bounds_nothing(refused: bool) -> None:
    """The motor's range of 4 is no limit then, and a servo's command has none."""
    head = '<option><flag clampctrl="disable"/></option>' + ("<nonsense/>" if refused else "")
    found = row(MOTOR, head=head)
    assert (found.effort_limit, found.command_range) == (math.inf, None)
    found = row('<position joint="j" kp="1" ctrlrange="-1 1"/>', head=head)
    assert found.command_range is None


def _compiled(path: Path) -> mujoco.MjModel | None:
    try:
        document = open_document(str(path))
        if document.root.tag != "mujoco":
            return None
        return compile_spec(open_spec(document.files, format=ModelFormat.MJCF))
    except RobotError:
        return None


@pytest.mark.slow
@pytest.mark.skipif(not _real(), reason="no corpus")
@pytest.mark.parametrize("path", _real(), ids=lambda path: "/".join(path.parts[-2:]))
def test_real_files_agree_with_the_engines_forces(path: Path) -> None:
    """Control, kp, kd, damping, limit, armature and friction of every row are what the compiled model does."""
    model = _compiled(path)
    if model is None:
        pytest.skip("MuJoCo refuses it, or it is no MJCF")
    reading = read_robot(str(path), keep_matrices=False)
    artifact = reading.artifacts[0]
    assert artifact.text_only is None
    found = rows_of_robot(artifact, 0)
    engine = Engine(model)
    linear = engine.unclamped()
    gear = model.actuator_gear[:, 0]
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_ACTUATOR, i) or "" for i in range(len(gear))]
    step = 1e-3
    driven: dict[str, int] = {}
    for row in found:
        joint = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, row.joint)
        rest, total, passive = linear.forces(joint)
        moved, _, _ = linear.forces(joint, q=step)
        fast, fast_total, fast_passive = linear.forces(joint, w=step)
        assert row.total_damping == pytest.approx(
            (total + passive - fast_total - fast_passive) / step, rel=MEASURED, abs=1e-9
        ), row.joint
        assert row.armature == pytest.approx(engine.armature(joint), rel=MEASURED, abs=1e-9), row.joint
        assert row.frictionloss == engine.friction(joint), row.joint
        if row.control == "none":
            continue
        index = next(
            i for i, n in enumerate(names)
            if n == row.actuator and model.actuator_trnid[i, 0] == joint and i not in driven.values()
        )  # fmt: skip
        driven[f"{row.joint} {index}"] = index
        kp = gear[index] * (rest - moved)[index] / step
        kd = gear[index] * (rest - fast)[index] / step
        commanded, _, _ = linear.forces(joint, ctrl=step)
        gain = gear[index] * (commanded - rest)[index] / step
        assert row.kp == pytest.approx(kp, rel=MEASURED, abs=1e-7), row.joint
        assert row.kd == pytest.approx(kd, rel=MEASURED, abs=1e-7), row.joint
        behaves = (
            "position" if abs(kp) > 1e-6 else "velocity" if abs(gain - kd * gear[index]) < 1e-6 else "motor"
        )
        assert row.control == behaves, row.joint
        pushes = [
            abs(engine.forces(joint, q, w, ctrl)[1])
            for ctrl in (-HUGE, HUGE)
            for q, w in (
                (0.0, 0.0),
                (HUGE * (kp != 0.0), HUGE * (kd != 0.0)),
                (-HUGE * (kp != 0.0), -HUGE * (kd != 0.0)),
            )
        ]
        limit = math.inf if max(pushes) > HUGE / 10 else max(pushes)
        assert row.effort_limit == pytest.approx(limit, rel=1e-9), row.joint
    joints = {row.joint for row in found if row.joint}
    hinges = [
        mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, i)
        for i in range(model.njnt)
        if model.jnt_type[i] in (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
    ]
    assert joints == {name for name in hinges if name}


def test_inertia_is_taken_and_the_matrices_dropped() -> None:
    """Only with `keep_matrices` the mass matrices come along; the rows are the same."""
    Path("m.xml").write_text(one_joint('<joint name="j"/>', '<motor joint="j"/>'))

    def artifact(keep: bool) -> Artifact:
        reading: FileReading = read_robot("m.xml", keep_matrices=keep)
        return reading.artifacts[0]

    with_, without = artifact(True), artifact(False)
    assert with_.robot is not None and without.robot is not None
    assert with_.robot.inertia is not None and without.robot.inertia is None
    assert rows_of_robot(with_, 0) == rows_of_robot(without, 0)
    assert rows_of_robot(without, 0)[0].inertia_min == pytest.approx(1.0, rel=EXACT)
