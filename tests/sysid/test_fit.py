"""Figures that the logs of a virtual joint hold, found again; and those that they do not, named."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from actspec import api
from actspec.diagnostics import Severity
from actspec.logs import JointLog, Log, LogError, Sidecar
from actspec.sysid.fit import fit_logs
from actspec.sysid.identified import Identification, State
from actspec.sysid.work import FitOptions
from tests.sysid.truth import truth

pytest.importorskip("scipy")
pytestmark = pytest.mark.slow

PERIOD, ROWS = 0.002, 2000
LINK = 0.8 * 0.15**2
"""A point of 0.8 kg at 0.15 m [kg*m^2]."""
TRUE = {
    "kp": 32.0,
    "kd": 0.9,
    "armature": 0.012,
    "friction.coulomb": 0.25,
    "friction.viscous": 0.04,
    "delay": 0.0053,
    "encoder_bias": 0.01,
}
MODEL = """<mujoco model="bench">
  <compiler angle="radian"/>
  <worldbody>
    <body name="arm">
      <joint name="hip" axis="AXIS" range="-1.5 1.5"/>
      <inertial pos="0 0 -0.15" mass="0.8" diaginertia="1e-9 1e-9 1e-9"/>
    </body>
  </worldbody>
</mujoco>
"""
SPEC = """actspec: 1
robot: {name: bench, model: bench.xml}
actuators:
  leg:
    joints: [hip]
    level: ideal_pd
    kp: 40 N*m/rad
    kd: 0.6 N*m*s/rad
    effort_limit: 30 N*m
    armature: 0.02 kg*m^2
    friction: {coulomb: 0.1 N*m, viscous: 0.01 N*m*s/rad}
    delay: 2 ms
"""


def command() -> np.ndarray:
    """Thirty sines, 0.6 rad at most."""
    t = np.arange(ROWS) * PERIOD
    random = np.random.default_rng(5)
    frequency = np.geomspace(0.25, 10.0, 30)[:, None]
    shape = (
        np.sin(2 * np.pi * frequency * t + random.uniform(0, 6.28, (30, 1)))
        / np.sqrt(1 + (frequency / 3) ** 2)
    ).sum(0)
    found: np.ndarray = 0.6 * shape / np.abs(shape).max()
    return found


def logged(
    gravity: bool, rows: int = ROWS, jitter: float = 0.0, share: float = 1.0, true: dict[str, float] = TRUE
) -> Log:
    """What sensors read of the true joint: 0.5 mrad, 0.05 rad/s and 2 % of the torque's RMS of noise.

    `jitter` is the standard deviation of a row's time, in rows; `share` that of the command which is sent.
    """
    mgl = 0.8 * 9.81 * 0.15 if gravity else 0.0
    one = {
        "J": LINK + true["armature"], "kp": true["kp"], "kd": true["kd"], "tc": true["friction.coulomb"],
        "b": true["friction.viscous"], "delay": true["delay"], "limit": true.get("limit", 30.0), "mgl": mgl,
        "bias": true["encoder_bias"] if gravity else 0.0,
    }  # fmt: skip
    given = share * command()[:rows]
    random = np.random.default_rng(11)
    time = np.arange(rows) * PERIOD
    if jitter:
        time += jitter * PERIOD * np.clip(np.random.default_rng(2).standard_normal(rows), -3.0, 3.0)
    read = truth({name: np.array([value]) for name, value in one.items()}, given[:, None], time)
    q, qd, torque = (part[:, 0] for part in read)
    joint = JointLog(
        "hip",
        False,
        command=given,
        position=q + 5e-4 * random.standard_normal(rows),
        velocity=qd + 0.05 * random.standard_normal(rows),
        torque=torque + 0.02 * np.sqrt(np.mean(torque**2)) * random.standard_normal(rows),
    )
    return Log("hip.csv", "0" * 64, time, {"hip": joint}, Sidecar())


@pytest.fixture(scope="module")
def pendulum() -> Log:
    """A log of the joint under gravity."""
    return logged(gravity=True)


def fitted(folder: Path, log: Log, options: FitOptions | None = None, axis: str = "0 1 0") -> Identification:
    """The fit of one log, with a spec that is wrong in every figure."""
    (folder / "bench.xml").write_text(MODEL.replace("AXIS", axis))
    (folder / "spec.yaml").write_text(SPEC)
    spec = api.load(folder / "spec.yaml")
    robot = api.load_robot(spec)
    return fit_logs(api.resolve(spec, robot), robot, [log], options or FitOptions())


def bare(log: Log, sidecar: str | None = None) -> Log:
    """The log without its torque; with gains in its sidecar."""
    stated = {} if sidecar is None else {"gains": {"hip": {"kp": TRUE["kp"], "kd": TRUE["kd"]}}}
    joints = {"hip": replace(log.joints["hip"], torque=None)}
    return replace(log, joints=joints, sidecar=Sidecar.model_validate(stated))


def near(found: Identification, field: str, goal: float) -> None:
    """Within five times the goal of the issue, and within four standard deviations of the truth."""
    parameter = found.joints[0].parameter(field)
    assert parameter.state is State.IDENTIFIED, (field, parameter)
    assert parameter.value is not None and parameter.std is not None
    assert parameter.value == pytest.approx(TRUE[field], abs=5 * goal), field
    assert abs(parameter.value - TRUE[field]) < 4 * parameter.std, field
    # An interval that says nothing is no result.
    assert parameter.std < 8 * goal, field


def test_torque_gives_everything(tmp_path: Path, pendulum: Log) -> None:
    """With torque, gains are fitted; a delay of 2.65 rows is found to a hundredth of a row."""
    found = fitted(tmp_path, pendulum)
    for field, goal in (
        ("kp", 0.05e-2 * 32), ("kd", 0.05e-2 * 0.9), ("armature", 0.2e-2 * 0.03), ("friction.coulomb", 0.2e-2 * 0.25),
        ("friction.viscous", 1.5e-2 * 0.04), ("delay", 2e-5), ("encoder_bias", 5e-4),
    ):  # fmt: skip
        near(found, field, goal)
    assert not any(item.severity is Severity.WARNING for item in found.findings)
    assert 0.9 < found.joints[0].misfit < 1.1


def test_a_clock_that_jitters(tmp_path: Path) -> None:
    """By 15 %: a delay of 2.65 rows ends now within the third row, now within the next one."""
    found = fitted(tmp_path, logged(gravity=True, jitter=0.15))
    for field, goal in (("kp", 0.05e-2 * 32), ("kd", 0.05e-2 * 0.9), ("delay", 2e-5)):
        near(found, field, goal)


def test_a_delay_of_whole_rows_where_the_joint_hardly_moves(tmp_path: Path) -> None:
    """20 mrad either way: two rows of delay are found, not one row and a kp that makes up for it (19.4 of 20)."""
    true = {
        "kp": 20.0, "kd": 0.5, "armature": 0.01, "friction.coulomb": 0.1, "friction.viscous": 0.02, "delay": 0.004,
        "encoder_bias": 0.0,
    }  # fmt: skip
    found = fitted(tmp_path, logged(gravity=True, share=1.0 / 30.0, true=true))
    for field, allowed in (("delay", 2e-4), ("kp", 0.1)):
        parameter = found.joints[0].parameter(field)
        assert parameter.value == pytest.approx(true[field], abs=allowed), field
    assert not found.findings


def test_a_figure_whose_interval_reaches_0_has_no_value(tmp_path: Path) -> None:
    """A delay of 1 us, where it is told to a few: 0 is as good. A viscous friction of 0.01 is told to a few 1e-4."""
    found = fitted(tmp_path, logged(gravity=True, true={**TRUE, "delay": 1e-6, "friction.viscous": 0.01}))
    delay = found.joints[0].parameter("delay")
    assert (delay.state, delay.value, delay.std, delay.low) == (State.AT_BOUND, None, None, 0.0)
    assert delay.high is not None and 1e-6 < delay.high < 4e-5
    assert delay.why == f"anything from 0 to {1e3 * delay.high:.2g} ms fits"
    viscous = found.joints[0].parameter("friction.viscous")
    assert viscous.state is State.IDENTIFIED and viscous.value == pytest.approx(0.01, abs=5 * 6e-4)
    (said,) = [item.message for item in found.findings]
    assert said == "the logs do not tell delay from 0"


def test_stated_gains_give_the_rest(tmp_path: Path, pendulum: Log) -> None:
    """Without torque the sidecar's kp is the scale, and is held."""
    found = fitted(tmp_path, bare(pendulum, "gains"))
    held = found.joints[0].parameter("kp")
    assert (held.state, held.value) == (State.HELD, 32.0) and "sidecar" in held.why
    for field, goal in (("armature", 0.2e-2 * 0.03), ("friction.coulomb", 0.2e-2 * 0.25), ("delay", 2e-5)):
        near(found, field, goal)


def test_gravity_gives_the_scale(tmp_path: Path, pendulum: Log) -> None:
    """Without torque and with free gains gravity is the scale; kd shows with viscous friction alone."""
    found = fitted(tmp_path, bare(pendulum), FitOptions(free=frozenset({"kp", "kd"})))
    near(found, "kp", 0.5e-2 * 32)
    near(found, "armature", 0.5e-2 * 0.03)
    assert {found.joints[0].parameter(f).state for f in ("kd", "friction.viscous")} == {State.UNIDENTIFIABLE}
    (both,) = found.joints[0].combinations
    assert both.name == "kd+friction.viscous"
    assert both.value == pytest.approx(0.94, abs=5 * 0.5e-2 * 0.94)


def test_a_limit_parts_kd_from_viscous_friction(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """At its limit, here in 4 % of the rows, a drive's kd is clipped and friction is not: without torque both show.

    As one sum, all of which the limit clips, they made kp and delay wrong, and the motion too.
    """
    limit = 5.0
    monkeypatch.setattr("tests.sysid.test_fit.SPEC", SPEC.replace("30 N*m", f"{limit} N*m"))
    log = logged(gravity=True, true={**TRUE, "limit": limit})
    torque = log.joints["hip"].torque
    assert torque is not None and 0.03 < float(np.mean(np.abs(torque) > 0.98 * limit)) < 0.05
    found = fitted(tmp_path, bare(log), FitOptions(free=frozenset({"kp", "kd"})))
    near(found, "kp", 0.5e-2 * 32)
    near(found, "kd", 0.5e-2 * 0.9)
    near(found, "friction.viscous", 1e-3)
    near(found, "delay", 2e-5)
    assert found.joints[0].combinations == () and found.joints[0].misfit < 1.1


def test_nothing_gives_the_scale(tmp_path: Path) -> None:
    """A lone vertical joint without torque: no figure of the drive, only ratios; the delay all the same."""
    found = fitted(tmp_path, bare(logged(gravity=False)), FitOptions(free=frozenset({"kp", "kd"})), "0 0 1")
    joint = found.joints[0]
    for field in ("kp", "kd", "armature", "friction.coulomb", "friction.viscous", "encoder_bias"):
        assert joint.parameter(field).state is State.UNIDENTIFIABLE, field
        assert joint.parameter(field).value is None
    near(found, "delay", 2e-5)
    ratio = {item.name: item.value for item in joint.combinations}
    inertia = LINK + TRUE["armature"]
    assert ratio["kp/inertia"] == pytest.approx(32.0 / inertia, rel=0.02)
    assert ratio["(kd+friction.viscous)/inertia"] == pytest.approx(0.94 / inertia, rel=0.02)
    assert ratio["friction.coulomb/inertia"] == pytest.approx(0.25 / inertia, rel=0.02)


@pytest.mark.parametrize(
    ("signal", "change", "words"),
    [
        ("velocity", -1.0, "opposite sign"),
        ("velocity", 180.0 / np.pi, "in degrees"),
        ("velocity", 30.0 / np.pi, "in rpm"),
        ("position", 180.0 / np.pi, "in degrees"),
        ("position", -1.0, "goes against the command"),
        ("command", 0.0, "nothing moves the joint"),
        ("torque", -1.0, "pulls away from the command"),
    ],
)
def test_a_column_that_contradicts_the_others_is_refused(
    tmp_path: Path, pendulum: Log, signal: str, change: float, words: str
) -> None:
    """Signs and units, told from what the readings say of each other; no figure is made of them."""
    joint = pendulum.joints["hip"]
    spoilt = replace(joint, **{signal: change * getattr(joint, signal)})
    with pytest.raises(LogError, match=words) as err:
        fitted(tmp_path, replace(pendulum, joints={"hip": spoilt}))
    assert all(item.where == "hip" for item in err.value.diagnostics if item.severity is Severity.ERROR)


def test_clipping_that_is_not_the_spec_s(tmp_path: Path, pendulum: Log) -> None:
    """A drive that gives 2 N*m at most, where the spec says 30."""
    joint = pendulum.joints["hip"]
    assert joint.torque is not None
    clipped = replace(joint, torque=np.clip(joint.torque, -2.0, 2.0))
    with pytest.raises(LogError, match=r"clipped at 2 N\*m"):
        fitted(tmp_path, replace(pendulum, joints={"hip": clipped}))


def test_spoilt_stretches_are_left_out(tmp_path: Path, pendulum: Log) -> None:
    """Frozen readings for 0.3 s, and none for 0.2 s: reported with their rows, and the rest gives the figures."""
    joint = pendulum.joints["hip"]
    parts = {name: getattr(joint, name).copy() for name in ("position", "velocity", "torque")}
    for values in parts.values():
        values[700:850] = values[700]
        values[1200:1300] = np.nan
    found = fitted(tmp_path, replace(pendulum, joints={"hip": replace(joint, **parts)}))
    said = {item.message for item in found.findings}
    assert any("stand still in 150 rows" in text for text in said)
    assert any("100 rows have no position" in text for text in said)
    frozen = next(item for item in found.findings if "stand still" in item.message)
    assert frozen.span is not None and frozen.span.line == 701
    near(found, "kp", 0.05e-2 * 32 * 2)


@pytest.mark.parametrize(("value", "message", "figures"), [
    (1e300, "the command is 1e300 rad in 1 row", False),
    (3.0, "the command jumps to 3 rad and back in 1 row, further than it goes in all others", True),
])  # fmt: skip
def test_a_command_that_no_joint_follows(
    tmp_path: Path, pendulum: Log, value: float, message: str, figures: bool
) -> None:
    """One cell: beyond all joints it is refused before numpy overflows, among the others' it is named."""
    hip = pendulum.joints["hip"]
    assert hip.command is not None
    given = hip.command.copy()
    given[100] = value
    spoilt = replace(pendulum, joints={"hip": replace(hip, command=given)})
    if figures:
        said = fitted(tmp_path, spoilt).findings
    else:
        with pytest.raises(LogError) as failed:
            fitted(tmp_path, spoilt)
        said = failed.value.diagnostics
    (one,) = (item for item in said if item.code == "SYS017")
    assert one.message == message


@pytest.mark.slow
def test_held_gains_are_named_where_the_joint_moves_otherwise(tmp_path: Path, pendulum: Log) -> None:
    """The spec's kp is far from the drive's 32 N*m/rad, and nothing in the log says so."""
    try:
        said = fitted(tmp_path, bare(pendulum)).findings
    except LogError as failed:
        said = failed.diagnostics
    (one,) = (item for item in said if item.code == "SYS031")
    assert "had" in f"{one.message} {one.help}" and "which were held" in f"{one.message} {one.help}"
    assert "--free kp,kd" in (one.help or "")
