"""unitree_rl_lab's class with a curve and a friction of its own, what is made of it, and classes that look like it."""

from __future__ import annotations

from pathlib import Path

import pytest

from actspec.ir import JointActuator, Level
from actspec.lift import lift_config
from actspec.readings.config import rows_of_config
from actspec.readings.read import read_file
from actspec.readings.versions import Versions
from tests.importing import CURVED
from tests.lift.test_lift_config import LAB, artifact_of, joints


def curved(
    folder: Path, fields: str, values: str = "", versions: Versions = LAB, older: str = CURVED
) -> tuple[JointActuator, tuple[str, ...]]:
    """The hip behind a class made of unitree_rl_lab's, with the fields of its own."""
    (folder / "motors.py").write_text(
        f"""{older}
class Noisy(UnitreeActuator):
    pass
@configclass
class UnitreeActuatorCfg_Some(UnitreeActuatorCfg):
    {fields}
""",
        encoding="utf-8",
    )
    text = f"""import motors
from isaaclab.assets import ArticulationCfg
BOT_CFG = ArticulationCfg(actuators={{"g": motors.UnitreeActuatorCfg_Some(
    joint_names_expr=["hip"], stiffness=25.0, damping=0.5, {values})}})
"""
    found = lift_config(artifact_of(folder, text), joints(), versions=versions)
    (hip,) = found.actuators.joints
    return hip, found.notes["hip"]


def test_curve_of_unitrees_class(tmp_path: Path) -> None:
    """Y1 drives, Y2 brakes, X1 is the knee and X2 the end; it clips by nothing else, so the limit is Y2."""
    hip, notes = curved(
        tmp_path, "X1 = 13.5; X2 = 30; Y1 = 20.2; Y2 = 23.4", "effort_limit=7.0, velocity_limit=9.0"
    )
    assert hip.level is Level.DC_MOTOR and hip.curve is not None
    curve = hip.curve
    parts = (curve.drive_torque, curve.brake_torque, curve.knee_speed, curve.no_load_speed)
    assert [part.value for part in parts] == [20.2, 23.4, 13.5, 30.0]
    assert curve.brake_torque.span is not None and curve.brake_torque.span.path.endswith("motors.py")
    assert hip.effort_limit.value == 23.4 and hip.effort_limit.span == curve.brake_torque.span
    # Its friction of 0 adds nothing; what the USD has is not known.
    assert not hip.friction_coulomb.known and not hip.friction_viscous.known
    assert any("effort_limit is the larger torque of its curve, 23.4 N*m" in note for note in notes)
    # Without Y2 it brakes with Y1.
    alike, _ = curved(tmp_path, "X1 = 1.0; X2 = 2.0; Y1 = 5.0")
    assert alike.curve is not None and alike.curve.brake_torque.value == 5.0 == alike.effort_limit.value


def test_unitrees_class_without_speeds(tmp_path: Path) -> None:
    """1e9 rad/s is no speed: a plain clip is left, and what the two torques lose is said. 1e9 N*m is no limit."""
    hip, notes = curved(tmp_path, "Y1 = 5.0; Y2 = 6.0")
    assert hip.level is Level.IDEAL_PD and hip.curve is None and hip.effort_limit.value == 6.0
    assert "its curve ends at no speed, and is left out: it has 5.0 N*m driving and 6.0 N*m braking" in notes
    free, _ = curved(tmp_path, "pass")
    assert free.curve is None and not free.effort_limit.known


@pytest.mark.parametrize(
    ("fields", "values", "coulomb", "static", "viscous"),
    [
        ("Fs = 1.6; Fd = 0.16", "", 1.6, None, 0.16),
        # 1.6 + 0.2 sliding, 1.6 + 0.3 to break away, 0.16 + 0.1.
        (
            "Fs = 1.6; Fd = 0.16",
            "friction=0.3, dynamic_friction=0.2, viscous_friction=0.1",
            1.8,
            1.9,
            0.26,
        ),
        ("Fs = 0.0", "friction=0.3, dynamic_friction=0.2", 0.2, 0.3, None),
        # What slides at the joint depends on the USD, as where nothing is written: the class's own is known.
        ("Fs = 1.6", "friction=0.3", 1.6, 1.9, None),
    ],
)
def test_friction_of_unitrees_class(
    tmp_path: Path,
    fields: str,
    values: str,
    coulomb: float | None,
    static: float | None,
    viscous: float | None,
) -> None:
    """Fs and Fd act outside the clamp, beside the joint's own friction: they add up."""
    hip, _ = curved(tmp_path, f"X1 = 1.0; X2 = 2.0; Y1 = 5.0; {fields}", values)
    assert hip.friction_coulomb.value == (None if coulomb is None else pytest.approx(coulomb))
    found = None if hip.friction_static is None else hip.friction_static.value
    assert found == (None if static is None else pytest.approx(static))
    assert hip.friction_viscous.value == (None if viscous is None else pytest.approx(viscous))


def test_friction_of_an_unknown_unit(tmp_path: Path) -> None:
    """Fs is a torque in every release, whatever the solver's friction is, of which nothing is known."""
    values = "friction=0.01"
    for versions, why in (
        (LAB, "the USD's own sliding friction"),
        (Versions(), "friction 0.01 is no torque: its unit is not known"),
        (Versions(isaaclab="2.2", isaac_sim="5.0"), "this Isaac Lab never writes friction to the solver"),
    ):
        hip, notes = curved(tmp_path, "X1 = 1.0; X2 = 2.0; Y1 = 5.0; Fs = 1.6", values, versions)
        assert hip.friction_coulomb.value == 1.6
        assert (
            f"friction.coulomb is Fs alone, 1.6 N*m: what the joint has beside it is not known ({why})"
            in notes
        )


@pytest.mark.parametrize(
    ("solver", "limit", "remark"),
    [
        # Of 71 N*m driving and 83.3 braking the solver takes what is above its own.
        (
            75.0,
            75.0,
            "effort_limit is effort_limit_sim, 75 N*m, where the solver clips, below the 83.3 N*m of its curve",
        ),
        (
            3.0,
            3.0,
            "effort_limit is effort_limit_sim, 3 N*m, where the solver clips, below the 83.3 N*m of its curve",
        ),
        (
            200.0,
            83.3,
            "effort_limit is the larger torque of its curve, 83.3 N*m: the solver's, 200 N*m (effort_limit_sim), is no "
            "lower",
        ),
        (1e9, 83.3, "effort_limit is the larger torque of its curve, 83.3 N*m: it has no other limit"),
    ],
)
def test_where_the_solver_clips(tmp_path: Path, solver: float, limit: float, remark: str) -> None:
    """It clips what the class gives, and its speed limit is the joint's.

    Source: Isaac Lab 2.3.2, articulation.py writes both to the solver for every class.
    """
    fields, values = (
        "X1 = 22.63; X2 = 35.52; Y1 = 71; Y2 = 83.3",
        f"effort_limit_sim={solver}, velocity_limit_sim=20.0",
    )
    hip, notes = curved(tmp_path, fields, values)
    assert (hip.effort_limit.value, hip.velocity_limit.value) == (limit, 20.0)
    assert hip.curve is not None and hip.curve.brake_torque.value == 83.3
    assert remark in notes


def test_solvers_limit_of_a_curve_without_torques(tmp_path: Path) -> None:
    """1e9 N*m is no torque, so the solver's is the limit."""
    hip, notes = curved(tmp_path, "pass", "effort_limit_sim=9.0")
    assert hip.effort_limit.value == 9.0
    assert "effort_limit is effort_limit_sim, 9 N*m, where the solver clips" in notes


def test_what_the_class_does_not_read(tmp_path: Path) -> None:
    """Its clip knows neither effort_limit nor velocity_limit."""
    fields = "X1 = 13.5; X2 = 30; Y1 = 20.2; Y2 = 23.4"
    hip, notes = curved(tmp_path, fields, "effort_limit=7.0, velocity_limit=9.0")
    assert (hip.effort_limit.value, hip.velocity_limit.value) == (23.4, None)
    why = "is left out: its class clips by X1, X2, Y1, Y2 alone"
    assert f"effort_limit 7 {why}" in notes
    assert f"velocity_limit 9 {why}; the solver's limit is velocity_limit_sim, else the USD's own" in notes


@pytest.mark.parametrize(
    ("speeds", "why"),
    [
        (
            "X2 = 20",
            "X1, 1e9 rad/s, is not below X2, 20 rad/s: its class has its full torque at every speed; it has 71.0 N*m "
            "driving and 83.3 N*m braking",
        ),
        (
            "X1 = 30; X2 = 20",
            "X1, 30 rad/s, is not below X2, 20 rad/s: its class has its full torque at every speed; it has 71.0 N*m "
            "driving and 83.3 N*m braking",
        ),
        ("X1 = 20; X2 = 20", "X1 and X2 are both 20 rad/s, and a torque that ends at once is no curve"),
    ],
)
def test_a_knee_that_is_not_below_the_end(tmp_path: Path, speeds: str, why: str) -> None:
    """Measured on the class (torch): at 10, 25 and 100 rad/s it clips 1000 N*m driving to 71, 71 and 71 with X2 = 20
    alone, to 71, 71 and 568 with X1 = 30 (71 + 71 / 10 * 70), and to 71, 0 and 0 with both 20.
    """
    hip, notes = curved(tmp_path, f"{speeds}; Y1 = 71.0; Y2 = 83.3")
    assert (hip.level, hip.curve, hip.effort_limit.value) == (Level.IDEAL_PD, None, 83.3)
    assert f"its torque-speed line is left out: {why}" in notes


_READ = "is read as unitree_rl_lab's UnitreeActuator: a torque-speed curve (X1, X2, Y1, Y2)"


@pytest.mark.parametrize("older", [CURVED[: CURVED.index("    Fs:")], CURVED])
def test_the_older_class_has_no_friction(tmp_path: Path, older: str) -> None:
    """It has neither Fs nor Fd, and where both are 0 there is none either: nothing is said of them."""
    _, notes = curved(tmp_path, "X1 = 13.5; X2 = 30; Y1 = 20.2; Y2 = 23.4", older=older)
    assert f"UnitreeActuatorCfg_Some {_READ}" in notes


@pytest.mark.parametrize(
    ("fields", "more"),
    [
        ("class_type: type = Noisy", "; what else Noisy does is not known here"),
        (
            "class_type: type = Noisy; noise: float = 0.1",
            "; what else Noisy does with noise is not known here",
        ),
        ("noise: float = 0.1", "; what else UnitreeActuator does with noise is not known here"),
        ("min_delay: int = 0; max_delay: int = 0", ""),
    ],
)
def test_a_class_made_of_it_may_do_more(tmp_path: Path, fields: str, more: str) -> None:
    """One with an actuator of its own, or fields that the class with the curve has not, may add to the torque."""
    _, notes = curved(tmp_path, f"X1 = 13.5; X2 = 30; Y1 = 20.2; Fs = 0.1; {fields}")
    friction = "and friction (Fs, Fd) of its own, which it rounds off near standstill (tanh, Va)"
    assert f"UnitreeActuatorCfg_Some {_READ}, {friction}{more}" in notes


def test_a_port_to_mjlab_is_read_as_the_class_of_mjlab_that_it_is_made_of(tmp_path: Path) -> None:
    """Ports of strangers differ (one clips by `effort_limit` too), so no curve is read, and what is not is named."""
    text = """from dataclasses import dataclass
from mjlab.actuator import BuiltinPositionActuatorCfg
from mjlab.entity import EntityArticulationInfoCfg

@dataclass(kw_only=True)
class UnitreeActuatorCfg(BuiltinPositionActuatorCfg):
    X1: float = 1e9
    X2: float = 1e9
    Y1: float = 0.0
    Fs: float = 0.0

@dataclass(kw_only=True)
class UnitreeActuatorCfg_Some(UnitreeActuatorCfg):
    X1: float = 22.63
    X2: float = 35.52
    Y1: float = 71.0
    Fs: float = 1.6
    armature: float = 0.01

BOT = EntityArticulationInfoCfg(actuators=(UnitreeActuatorCfg_Some(target_names_expr=("hip",), stiffness=70.0,
    damping=2.0, effort_limit=60.0),))
"""
    found = lift_config(artifact_of(tmp_path, text), joints())
    (hip,) = found.actuators.joints
    assert (hip.curve, hip.effort_limit.value, hip.armature.value) == (None, 60.0, 0.01)
    assert (
        "UnitreeActuatorCfg_Some is read as BuiltinPositionActuatorCfg: what else it does with X1, X2, Y1, Fs is not "
        "known here"
    ) in found.notes["hip"]


def test_the_ledger_has_the_solvers_speed(tmp_path: Path) -> None:
    """`velocity_limit` is none of the class's, so that of the solver counts; its effort limit is Y1's, below that."""
    limits = "effort_limit=7.0, velocity_limit=9.0, effort_limit_sim=75.0, velocity_limit_sim=20.0"
    curved(tmp_path, "X1 = 13.5; X2 = 30; Y1 = 20.2", limits)
    (artifact,) = read_file(str(tmp_path / "cfg.py")).artifacts
    (row,) = rows_of_config(artifact, 0, (), LAB)
    assert (row.control, row.effort_limit, row.velocity_limit) == ("ideal_pd", 20.2, 20.0)
    assert (row.more["solver_effort_limit"], row.no_load_speed) == (75.0, 30.0)
