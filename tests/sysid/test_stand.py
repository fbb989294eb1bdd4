"""Joints that a fit does not move: where they are, who says so, and what that makes of the one that is fitted."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from actspec import api
from actspec.cli.main import main
from actspec.diagnostics import Collector
from actspec.logs import JointLog, Log, Sidecar, load_log, write_log
from actspec.sysid.fit import fit_logs
from actspec.sysid.links import links_along
from actspec.sysid.stand import Stand, idle
from actspec.sysid.work import FitOptions
from tests.sysid.test_fit import PERIOD, ROWS, TRUE, command
from tests.sysid.truth import truth

MODEL = """<mujoco model="bench">
  <compiler angle="radian"/>
  <option gravity="0 0 -9.81"/>
  <worldbody>
    <body name="thigh">
      <joint name="hip" axis="0 1 0" range="-2 2"/>
      <inertial pos="0 0 0" mass="1e-6" diaginertia="1e-9 1e-9 1e-9"/>
      <body name="shank" pos="0 0 -0.3">
        <joint name="knee" axis="0 1 0" range="-2 2"/>
        <inertial pos="0 0 -0.2" mass="1" diaginertia="1e-9 1e-9 1e-9"/>
      </body>
    </body>
    <body name="tail" pos="1 0 0">
      <joint name="tail" axis="0 1 0" range="-2 2"/>
      <inertial pos="0 0 -0.2" mass="1" diaginertia="1e-9 1e-9 1e-9"/>
    </body>
  </worldbody>
</mujoco>
"""
"""A point of 1 kg at 0.2 m from the knee, which is 0.3 m from the hip; and a joint that carries neither."""
BENT = 0.3**2 + 0.2**2
"""Inertia at the hip with the knee at 90 degrees [kg*m^2]; straight it is (0.3 + 0.2)^2 = 0.25."""
LOAD = 9.81 * 0.2
"""Gravity there with the thigh straight down: the point is 0.2 m behind the hip [N*m]."""
SPEC = """actspec: 1
robot: {name: bench, model: bench.xml, default_pose: {POSE}}
actuators:
  leg:
    joints: [hip, knee, tail]
    level: ideal_pd
    kp: 40 N*m/rad
    kd: 0.6 N*m*s/rad
    effort_limit: 30 N*m
    armature: 0.02 kg*m^2
    friction: {coulomb: 0.1 N*m, viscous: 0.01 N*m*s/rad}
"""


def stand(folder: Path, pose: str = "knee: 90 deg", model: str = MODEL) -> Stand:
    """The leg; of the knee's encoder the bias is 0.1 rad."""
    (folder / "bench.xml").write_text(model)
    text = SPEC.replace("POSE", pose)
    text += "    overrides: {knee: {encoder_bias: 0.1 rad}}\n"
    (folder / "spec.yaml").write_text(text)
    spec = api.load(folder / "spec.yaml")
    robot = api.load_robot(spec)
    return Stand(robot, api.resolve(spec, robot))


def log_of(
    joints: dict[str, dict[str, np.ndarray]], sidecar: str = "", time: np.ndarray | None = None
) -> Log:
    """A log of these columns; the sidecar may state a pose of the knee."""
    pose = {"pose": {"knee": sidecar}} if sidecar else {}
    made = {name: JointLog(name, False, **columns) for name, columns in joints.items()}
    time = np.arange(ROWS) * PERIOD if time is None else time
    return Log("l.csv", "0" * 64, time, made, Sidecar.model_validate(pose))


EVEN = np.ones(ROWS)
MOVING = {"hip": {"command": command(), "position": command()}}
KEYFRAME = '<keyframe><key qpos="0 -0.4 0"/></keyframe></mujoco>'


@pytest.mark.parametrize(
    ("pose", "model", "sidecar", "column", "expected", "said"),
    [
        # Read, less the encoder's bias: 1.2 - 0.1.
        ("knee: 90 deg", MODEL, "30 deg", 1.2, 1.1, None),
        ("knee: 90 deg", MODEL, "30 deg", None, np.pi / 6, "by the log's sidecar: knee 0.5236 rad"),
        ("knee: 90 deg", MODEL, "", None, np.pi / 2, "by robot.default_pose: knee 1.571 rad"),
        (
            "",
            MODEL.replace("</mujoco>", KEYFRAME),
            "",
            None,
            -0.4,
            "by the model's first keyframe: knee -0.4 rad",
        ),
        ("tail: 1 rad", MODEL, "", None, 0.0, "as the model's file draws it: knee 0 rad"),
    ],
)
def test_who_says_where_a_joint_is(
    pose: str,
    model: str,
    sidecar: str,
    column: float | None,
    expected: float,
    said: str | None,
    tmp_path: Path,
) -> None:
    """The log's own column before its sidecar, the spec and the model; the tail's pose changes nothing at the hip."""
    mine, out = stand(tmp_path, pose, model), Collector()
    knee = {} if column is None else {"knee": {"position": column * EVEN, "command": 1.2 * EVEN}}
    log = log_of({**MOVING, **knee}, sidecar)
    robot, moving = mine.beside(log, ["hip"])
    assert robot.pose["knee"] == pytest.approx(expected) and not moving
    mine.tell({"hip": [(log, command())]}, out)
    told = [(item.severity.value, item.message) for item in out.sorted() if item.code == "SYS038"]
    if said is None:
        assert told == []
    else:
        ((severity, message),) = told
        assert severity == ("warning" if not pose and model == MODEL else "info")
        assert message == f"not in the log, held {said}"


def test_nobody_says_where_a_joint_is(tmp_path: Path) -> None:
    """Without a default pose it is a warning: at 2 rad the inertia is 0.13 + 0.12 cos 2 = 0.08 in place of 0.25."""
    mine, out = stand(tmp_path, ""), Collector()
    log = log_of(MOVING)
    mine.tell({"hip": [(log, command())]}, out)
    (item,) = out.sorted()
    assert (item.code, item.severity.value) == ("SYS038", "warning")
    assert item.message.startswith(
        "not in the log, held as the model's file draws it: knee 0 rad; nothing says that it is there"
    )
    assert "`pose: {knee: ... rad}`" in (item.help or "")


def test_a_bent_knee_makes_another_thigh(tmp_path: Path) -> None:
    mine = stand(tmp_path)
    robot, _ = mine.beside(log_of(MOVING), ["hip"])
    zero = np.zeros((2, 1))
    found = links_along(robot, ["hip"], zero, zero, None)
    assert found.inertia[0, 0, 0] == pytest.approx(BENT, abs=1e-6)
    assert found.load[0, 0] == pytest.approx(LOAD, rel=1e-5)


def test_a_joint_that_moves_is_followed_and_one_that_stands_is_held(tmp_path: Path) -> None:
    """0.04 rad from end to end stand, 0.4 rad do not."""
    sine = np.sin(np.arange(ROWS) * 0.02)
    log = log_of({**MOVING, "knee": {"position": 0.2 * sine}, "tail": {"position": 0.02 * sine}})
    robot, moving = stand(tmp_path).beside(log, ["hip"])
    assert set(moving) == {"knee"} and "knee" not in robot.pose
    assert moving["knee"] == pytest.approx(0.2 * sine - 0.1)
    assert robot.pose["tail"] == pytest.approx(0.0, abs=4e-3)


def test_idle() -> None:
    """No command, or one that does not change; a speed command moves a joint too, and of NaN nothing is known."""
    nan = np.full(ROWS, np.nan)
    assert idle(JointLog("a", position=EVEN)) and idle(JointLog("a", command=0.3 * EVEN))
    assert not idle(JointLog("a", command=command())) and not idle(JointLog("a", command=nan))
    assert not idle(JointLog("a", command=EVEN, velocity_command=command()))


def bent(knee: bool, noise: float = 5e-4) -> Log:
    """The hip by a second implementation, without gravity, the knee at 90 degrees: J = 0.13 + 0.012 kg*m^2."""
    figures = {
        "J": BENT + TRUE["armature"], "kp": TRUE["kp"], "kd": TRUE["kd"], "tc": TRUE["friction.coulomb"],
        "b": TRUE["friction.viscous"], "delay": TRUE["delay"], "limit": 30.0, "mgl": 0.0, "bias": 0.0,
    }  # fmt: skip
    read = truth({name: np.array([value]) for name, value in figures.items()}, command()[:, None], PERIOD)
    random = np.random.default_rng(4)
    q, qd, torque = (part[:, 0] for part in read)
    columns = {"hip": {"command": command(), "position": q + noise * random.standard_normal(ROWS)}}
    columns["hip"] |= {"velocity": qd, "torque": torque + 0.02 * random.standard_normal(ROWS)}
    if knee:
        # Its encoder has a bias of 0.1 rad.
        held = np.pi / 2 + 0.1
        columns["knee"] = {"command": held * EVEN, "position": held + noise * random.standard_normal(ROWS)}
    return log_of(columns)


@pytest.mark.slow
@pytest.mark.parametrize(("pose", "knee"), [("knee: 90 deg", False), ("knee: 0 deg", True)])
def test_the_armature_with_a_bent_knee(pose: str, knee: bool, tmp_path: Path) -> None:
    """By the spec's pose, and by the log's own column against the spec's: with the knee straight the armature would be
    0.142 - 0.25 < 0, at its bound."""
    pytest.importorskip("scipy")
    mine = stand(tmp_path, pose, MODEL.replace("0 0 -9.81", "0 0 0"))
    found = fit_logs(mine.actuators, mine.robot, [bent(knee)], FitOptions())
    (hip,) = found.joints
    value = hip.parameter("armature").value
    assert value is not None and value == pytest.approx(0.012, abs=5e-4)
    assert hip.parameter("kp").value == pytest.approx(TRUE["kp"], rel=2e-3)
    left_out = [item.message for item in found.findings if item.code == "SYS037"]
    assert left_out == (["no figures, as no command moves them: knee stands at 1.571 rad"] if knee else [])


@pytest.mark.slow
def test_a_log_of_the_whole_robot(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """One joint is moved and fitted; asked for the other one, or where none is moved, that is the error."""
    pytest.importorskip("scipy")
    monkeypatch.chdir(tmp_path)
    stand(tmp_path, "knee: 0 deg", MODEL.replace("0 0 -9.81", "0 0 0"))
    log = replace(bent(knee=True), path="whole.csv")
    write_log(log)
    assert main(["sysid", "fit", "spec.yaml", "whole.csv", "-o", "found.yaml"]) == 0
    text = capsys.readouterr()
    assert "knee stands at 1.571 rad" in text.err and "7 figures" not in text.err
    assert "  hip:" in Path("found.yaml").read_text() and "  knee:" not in Path("found.yaml").read_text()
    assert main(["sysid", "fit", "spec.yaml", "whole.csv", "--joint", "knee"]) == 2
    assert "SYS011 knee: the command is 1.671 rad in every row" in capsys.readouterr().err
    assert main(["sysid", "fit", "spec.yaml", "whole.csv", "--joint", "tail"]) == 2
    assert "SYS021 --joint: no log has such a joint" in capsys.readouterr().err
    assert main(["sysid", "fit", "spec.yaml", "whole.csv", "--joint", "tial"]) == 2
    assert "BIND001 --joint: 'tial' matches no joint" in capsys.readouterr().err
    Path("whole.yaml").write_text("format: actspec-log/1\npose: {kneee: 90 deg}\n")
    assert main(["sysid", "fit", "spec.yaml", "whole.csv"]) == 2
    assert "the model has no joint 'kneee'" in capsys.readouterr().err


def test_the_virtual_robot_stands_as_the_spec_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With kp 40 and gravity alone the hip rests 1.962 / 40 = 0.049 rad off; with a straight knee at 0."""
    pytest.importorskip("scipy")
    monkeypatch.chdir(tmp_path)
    stand(tmp_path)
    write_log(replace(log_of({"hip": {"command": 0.0 * EVEN, "position": 0.0 * EVEN}}), path="still.csv"))
    arguments = ["sysid", "simulate", "spec.yaml", "--command", "still.csv", "-o", "log.csv", "--seed", "1"]
    assert main(arguments) == 0
    position = load_log("log.csv").joints["hip"].position
    # Dry friction of 0.1 N*m holds it within 0.0025 rad of that.
    assert position is not None and position[-1] == pytest.approx(-LOAD / 40.0, abs=0.004)
