"""Rows of configurations: what each framework's classes do with what is written."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from actspec.diagnostics import Span
from actspec.ir import JointKind
from actspec.readings.artifact import ActuatorGroup, Artifact, FileKind, Framework, RobotConfig, Setting
from actspec.readings.config import control_of, lost_keys, rows_of_config
from actspec.readings.ledger import LedgerRow
from actspec.readings.python.read import read_python
from actspec.readings.versions import Versions
from actspec.robot.view import JointView, ModelFormat, PoseInertia, RobotView

AT = Span("cfg.py", 3, 7)


def _model(damping: float = 0.0) -> Artifact:
    """Two hinges of inertia 0.04 and 0.01 in the reference pose, 0.05 and 0.02 in another; uncoupled."""
    joints = tuple(
        JointView(
            name,
            JointKind.HINGE,
            Span("leg.xml", 5 + dof),
            name,
            dof,
            (-1.0, 2.0),
            damping,
            (0.0, 0.0),
            0.0,
            0.0,
            0.3,
            None,
            None,
            frozenset(),
            False,
            None,
            0.0,
        )
        for dof, name in enumerate(("hip", "knee"))
    )
    matrices = np.array([np.diag([0.04, 0.01]), np.diag([0.05, 0.02])])
    view = RobotView(
        "leg",
        "leg.xml",
        ModelFormat.MJCF,
        joints,
        (),
        0.002,
        "Euler",
        (),
        PoseInertia(matrices, np.zeros(2)),
        "",
        (),
    )
    return Artifact("leg.xml", FileKind.MJCF, "leg", robot=view)


def _rows(
    cls: str,
    settings: dict[str, Any],
    *partners: Artifact,
    framework: Framework = Framework.ISAACLAB,
    joints: tuple[str, ...] = (".*",),
    general: dict[str, Any] | None = None,
    versions: Versions | None = None,
) -> dict[str, LedgerRow]:
    def made(values: dict[str, Any]) -> dict[str, Setting]:
        return {k: v if isinstance(v, Setting) else Setting(v, AT) for k, v in values.items()}

    group = ActuatorGroup("legs", cls, AT, joints, made(settings))
    config = RobotConfig(framework, "LEG_CFG", AT, (group,), made(general or {}))
    artifact = Artifact("cfg.py", FileKind.CFG, "LEG_CFG", config=config)
    return {row.joint: row for row in rows_of_config(artifact, 4, partners, versions or Versions())}


def test_a_dict_that_misses_a_joint_is_zero_in_isaac_lab() -> None:
    """Measured on the 2.3.2 classes: a joint that no key matches gets 0, and the row says that nobody wrote it."""
    rows = _rows("DCMotorCfg", {"stiffness": {"hip": 25.0}, "damping": 0.5}, _model())
    assert (rows["hip"].kp, rows["knee"].kp) == (25.0, 0.0)
    assert ("kp" in rows["hip"].stated, "kp" in rows["knee"].stated) == (True, False)
    assert rows["knee"].kd == 0.5


@pytest.mark.parametrize(
    ("named", "joints"),
    [({}, ["hip", "knee"]), ({"model": "robots/short.xml"}, ["hip"])],
    ids=["the one that fits best", "the one that it names"],
)
def test_which_model_names_the_joints(named: dict[str, str], joints: list[str]) -> None:
    """Of two variants the one in which the configuration selects more, whichever comes first, unless it names one."""
    full = _model()
    assert full.robot is not None
    short = replace(full, path="short.xml", robot=replace(full.robot, joints=full.robot.joints[:1]))
    settings = {"stiffness": 25.0, "damping": 0.5}
    for partners in ((short, full), (full, short)):
        assert list(_rows("DCMotorCfg", settings, *partners, general=named)) == joints


@pytest.mark.parametrize(
    ("named", "knee"),
    [
        ({"model": "robots/leg.usd"}, "knee"),
        ({"model": "robots/leg.xml"}, "c_knee"),
        ({"model": "robots/short.usd"}, "knee"),
    ],
    ids=["a USD of the name", "the file itself", "a USD of the other's name"],
)
def test_names_that_do_not_fit_are_another_variants(named: dict[str, str], knee: str) -> None:
    """`.*knee` selects a joint in both, `hip` in one: the other one names none, unless it is the very file that the
    configuration loads; a USD of its name is not.
    """
    short = replace(_model(), path="short.xml")
    assert short.robot is not None
    joints = tuple(replace(joint, name=f"c_{joint.name}") for joint in short.robot.joints)
    leg = replace(short, path="leg.xml", robot=replace(short.robot, joints=joints))
    settings = {"stiffness": 25.0, "damping": 0.5}
    for partners in ((short, leg), (leg, short)):
        rows = _rows("DCMotorCfg", settings, *partners, joints=("hip", ".*knee"), general=named)
        assert list(rows) == (["hip", knee] if knee == "knee" else [knee])


def test_a_drive_is_judged_with_the_models_inertia() -> None:
    """kp 4, kd 0.2, armature 0.01: hip held 0.05, so 8.944 rad/s; free least 0.05; step 5 ms: 0.005*0.2/0.05."""
    settings = {"stiffness": 4.0, "damping": 0.2, "armature": 0.01, "viscous_friction": 0.1}
    hip = _rows("IdealPDActuatorCfg", settings, _model(), general={"physics_dt": 0.005})["hip"]
    assert hip.natural_frequency == pytest.approx(math.sqrt(4.0 / 0.05))
    # (0.2 + 0.1) / (2 sqrt(4 * 0.05)) = 0.3 / 0.8944
    assert hip.damping_ratio == pytest.approx(0.335410, abs=1e-6)
    assert (hip.inertia_min, hip.inertia_max) == pytest.approx((0.05, 0.06))
    assert hip.stability == pytest.approx(0.02)
    assert (hip.kd_implicit, hip.total_damping) == (False, pytest.approx(0.3))
    # Viscous friction is outside of the drive; how PhysX integrates it the configuration does not say.
    assert (hip.joint_damping_clamped, hip.joint_damping_implicit) == (False, None)


def test_what_a_configuration_does_not_say_is_unknown() -> None:
    """Isaac Lab's passive friction is in the USD: the total is not kd alone."""
    row = _rows("ImplicitActuatorCfg", {"stiffness": 4.0, "damping": 0.2}, _model())["hip"]
    assert (row.joint_damping, row.total_damping, row.damping_ratio, row.effort_limit) == (None,) * 4
    assert row.natural_frequency == pytest.approx(10.0)  # sqrt(4 / 0.04)


@pytest.mark.parametrize(
    ("cls", "settings", "effort", "speed", "no_load"),
    [
        ("ImplicitActuatorCfg", {"effort_limit": 5.0, "velocity_limit": 9.0}, 5.0, None, None),
        ("ImplicitActuatorCfg", {"effort_limit_sim": 6.0, "velocity_limit_sim": 8.0}, 6.0, 8.0, None),
        ("ImplicitActuatorCfg", {"joint_effort_limit": 7.0, "joint_velocity_limit": 3.0}, 7.0, 3.0, None),
        ("IdealPDActuatorCfg", {"effort_limit": 5.0, "velocity_limit": 9.0}, 5.0, 9.0, None),
        (
            "DCMotorCfg",
            {"effort_limit": 5.0, "velocity_limit": 9.0, "velocity_limit_sim": 4.0},
            5.0,
            4.0,
            9.0,
        ),
        ("DCMotorCfg", {"actuator_effort_limit": 5.0, "actuator_velocity_limit": 9.0}, 5.0, None, 9.0),
        ("IdealPDActuatorCfg", {"effort_limit_sim": 6.0}, None, None, None),
    ],
    ids=["implicit-2", "implicit-sim", "implicit-3", "ideal", "dc", "dc-3", "explicit-sim-only"],
)
def test_limits_by_class(
    cls: str, settings: dict[str, Any], effort: float | None, speed: float | None, no_load: float | None
) -> None:
    """An implicit `velocity_limit` is ignored, a DC motor's is its no-load speed, an explicit clamp is the model's."""
    row = _rows(cls, settings)[".*"]
    assert (row.effort_limit, row.velocity_limit, row.no_load_speed) == (effort, speed, no_load)


def test_mjlab_drives_act_on_the_xmls_joints() -> None:
    """The XML's joint damping stays and adds to kd, unless the cfg sets its own."""
    cfg = {"stiffness": 4.0, "damping": 0.2, "effort_limit": 5.0}
    row = _rows("BuiltinPositionActuatorCfg", cfg, _model(0.5), framework=Framework.MJLAB)["hip"]
    assert (row.joint_damping, row.total_damping, row.frictionloss) == (0.5, 0.7, 0.3)
    own = _rows(
        "BuiltinPositionActuatorCfg",
        {**cfg, "viscous_damping": 0.1},
        _model(0.5),
        framework=Framework.MJLAB,
    )["hip"]
    assert own.total_damping == pytest.approx(0.3)


@pytest.mark.parametrize(
    ("versions", "friction"),
    [
        (Versions(), None),
        (Versions(isaaclab="2.3", isaac_sim="4.5"), None),
        (Versions(isaaclab="2.2", isaac_sim="5.0"), None),
        (Versions(isaaclab="2.3", isaac_sim="5.1"), 0.1),
        (Versions(isaaclab="3.0", backend="newton"), 0.2),
        (Versions(isaaclab="3.0", backend="ovphysx"), None),
    ],
    ids=["unsaid", "sim-4.5", "2.2", "2.3", "newton", "ovphysx"],
)
def test_friction_is_only_torque_where_it_is(versions: Versions, friction: float | None) -> None:
    """A coefficient is no frictionloss; the kinetic value is, where the solver has both; Newton has one."""
    row = _rows("ImplicitActuatorCfg", {"friction": 0.2, "dynamic_friction": 0.1}, versions=versions)[".*"]
    assert row.frictionloss == friction


def test_without_a_model_each_pattern_is_a_row() -> None:
    """A dict counts where its key is written like the pattern; other keys may or may not cover it."""
    settings = {"stiffness": {".*_hip": 25.0, "l_.*": 9.0}, "damping": 0.5}
    rows = _rows("DCMotorCfg", settings, joints=(".*_hip", ".*_knee"))
    assert (rows[".*_hip"].kp, rows[".*_knee"].kp, rows[".*_knee"].kd) == (25.0, None, 0.5)
    assert "kp" not in rows[".*_knee"].stated or rows[".*_knee"].kp is None


def test_without_a_model_a_pattern_that_is_a_name_is_a_joint() -> None:
    """Keys are matched against it, as `import --joints` does; one that no key selects gets Isaac Lab's 0."""
    settings = {"stiffness": {".*_hip": 25.0, ".*_knee": 40.0}, "damping": {"l_.*": 0.5, "r_hip": 0.7}}
    rows = _rows("DCMotorCfg", settings, joints=("l_hip", "r_hip", "l_knee", r"r\.knee", ".*_ankle"))
    assert {joint: (row.kp, row.kd) for joint, row in rows.items()} == {
        "l_hip": (25.0, 0.5),
        "r_hip": (25.0, 0.7),
        "l_knee": (40.0, 0.5),
        # No key is for `r.knee`.
        "r.knee": (0.0, 0.0),
        ".*_ankle": (None, None),
    }
    assert "kp" in rows["l_hip"].stated and "kp" not in rows["r.knee"].stated


def test_a_key_of_one_joint_that_a_pattern_may_select() -> None:
    """Where no file names the joints, `FL_hip` may be one that `.*_hip` selects, and `FL_hpi` is none of them."""
    group = ActuatorGroup("legs", "DCMotorCfg", AT, (".*_hip", ".*_knee"), {})
    config = RobotConfig(Framework.ISAACLAB, "LEG_CFG", AT, (group,), {})
    setting = Setting({"FL_hip": 25.0, "FL_hpi": 20.0, ".*_knee": 9.0, "FL_.*": 3.0}, AT)
    assert lost_keys(config, group, setting, None) == ["FL_hpi"]
    assert lost_keys(config, group, setting, ["RL_hip", "RL_knee"]) == ["FL_hip", "FL_hpi", "FL_.*"]


def test_a_value_that_could_not_be_folded_is_unknown() -> None:
    """It is not the engine's default either."""
    settings = {"stiffness": Setting(None, AT, "built in a loop"), "damping": 0.5}
    assert _rows("DCMotorCfg", settings, _model())["hip"].kp is None


def test_gains_in_volts_are_none_at_the_joint(tmp_path: Path) -> None:
    """The gains of mjlab's BuiltinDcMotorActuatorCfg are in volts: unknown, and the reading says so."""
    path = tmp_path / "cfg.py"
    path.write_text(
        "from mjlab.actuator import BuiltinDcMotorActuatorCfg, DcMotorDatasheetParams\n"
        'LEG = BuiltinDcMotorActuatorCfg(target_names_expr=("hip",), stiffness=80.0, damping=2.0, effort_limit=20.0,\n'
        "    voltage_limit=24.0, motor_params=DcMotorDatasheetParams(24.0, 20.0, 30.0))\n",
        encoding="utf-8",
    )
    (artifact,) = read_python(str(path)).artifacts
    (row,) = rows_of_config(artifact, 0, (), Versions())
    assert (row.control, row.kp, row.kd, row.effort_limit) == ("dcmotor", None, None, 20.0)
    assert artifact.config is not None
    notes = [(note.where, note.message) for note in artifact.config.notes][:2]
    assert notes == [
        (
            f"LEG.{gain}",
            f"{gain} is unknown at the joint: it is in volts: constant and resistance of the motor make a torque of it",
        )
        for gain in ("stiffness", "damping")
    ]


def test_a_delay_has_one_value_only_when_it_is_fixed() -> None:
    """2 steps of 5 ms are 10 ms; 0 to 4 steps are no number, and steps without a step length neither."""
    fixed = {"min_delay": 2, "max_delay": 2}
    general = {"physics_dt": 0.005}
    assert _rows("DelayedPDActuatorCfg", fixed, general=general)[".*"].delay == pytest.approx(0.01)
    ranged = {"min_delay": 0, "max_delay": 4}
    assert _rows("DelayedPDActuatorCfg", ranged, general=general)[".*"].delay is None
    assert _rows("DelayedPDActuatorCfg", fixed)[".*"].delay is None


@pytest.mark.parametrize(
    ("framework", "cls", "control"),
    [
        (Framework.ISAACLAB, "ImplicitActuatorCfg", "implicit"),
        (Framework.ISAACLAB, "DelayedImplicitActuatorCfg", "implicit"),
        (Framework.ISAACLAB, "PaceDCMotorCfg", "dc_motor"),
        (Framework.ISAACLAB, "RemotizedPDActuatorCfg", "ideal_pd"),
        (Framework.ISAACLAB, "DelayedPDActuatorCfg", "ideal_pd"),
        (Framework.ISAACLAB, "ActuatorNetLSTMCfg", "network"),
        (Framework.ISAACLAB, "UnitreeActuatorCfg", "other"),
        (Framework.MJLAB, "BuiltinDcMotorActuatorCfg", "dcmotor"),
        (Framework.MJLAB, "DcMotorActuatorCfg", "dc_motor"),
        (Framework.MJLAB, "DelayedBuiltinPositionActuatorCfg", "position"),
        (Framework.LEGGED_GYM, "P", "ideal_pd"),
        (Framework.LEGGED_GYM, "T", "motor"),
        (Framework.DEPLOY, "deploy", "ideal_pd"),
    ],
)
def test_classes(framework: Framework, cls: str, control: str) -> None:
    """A class is what it does; one that nobody knows is `other`."""
    assert control_of(framework, cls) == control


def test_a_class_that_nobody_knows_is_what_it_derives_from() -> None:
    """A robot's own class keeps the law of its nearest known base."""
    classes = (
        "UnitreeActuatorCfg_Go2HV",
        "UnitreeActuatorCfg",
        "DelayedPDActuatorCfg",
        "ImplicitActuatorCfg",
    )
    assert control_of(Framework.ISAACLAB, *classes) == "ideal_pd"


@pytest.mark.parametrize(
    ("more", "limit"),
    [
        pytest.param({"Y1": 40.0, "Y2": 45.43}, 45.43, id="it brakes with more"),
        pytest.param({"Y1": 40.0, "Y2": None}, 40.0, id="one torque"),
        pytest.param({"Y1": 40.0, "Y2": 45.43, "effort_limit": 400.0}, 45.43, id="which it does not read"),
        pytest.param({"Y1": 40.0, "Y2": 45.43, "effort_limit_sim": 30.0}, 30.0, id="the solver clips below"),
        pytest.param(
            {"Y1": 40.0, "Y2": 45.43, "effort_limit_sim": 400.0}, 45.43, id="the solver clips above"
        ),
        pytest.param({"Y1": 40.0, "Y2": Setting(None, AT, "not known")}, None, id="unknown"),
    ],
)
def test_a_class_with_a_curve_is_limited_by_it(more: dict[str, Any], limit: float | None) -> None:
    """unitree_rl_lab's `_clip_effort`; as a limit no file states it."""
    row = _rows("UnitreeActuatorCfg", {"stiffness": 25.0, "X1": 7.0, "X2": 15.7, **more})[".*"]
    assert row.effort_limit == limit
    assert "effort_limit" not in row.stated


def test_the_inertia_is_that_of_the_free_base() -> None:
    """A URDF does not say whether the base moves: where both fit alike the MJCF's inertia counts, in any order."""
    mjcf = _model()
    assert mjcf.robot is not None and mjcf.robot.inertia is not None
    heavy = replace(mjcf.robot.inertia, matrices=mjcf.robot.inertia.matrices * 3)
    urdf = replace(
        mjcf, kind=FileKind.URDF, robot=replace(mjcf.robot, format=ModelFormat.URDF, inertia=heavy)
    )
    for partners in ((mjcf, urdf), (urdf, mjcf)):
        # sqrt(4 / 0.04) with the MJCF, sqrt(4 / 0.12) with the URDF.
        assert _rows("ImplicitActuatorCfg", {"stiffness": 4.0}, *partners)[
            "hip"
        ].natural_frequency == pytest.approx(10)
