"""Angles that are not the model's, told by gravity: relative to the default pose, mirrored; and sound ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from actspec.diagnostics import Collector, Span
from actspec.ir import JointKind
from actspec.logs import Log
from actspec.sysid.fit import carried, prepared
from actspec.sysid.identified import JointFit, Parameter, State
from actspec.sysid.links import links_at
from actspec.sysid.stand import Stand
from actspec.sysid.work import FitOptions, JointInWork
from actspec.sysid.zeros import judge_biases, judge_zeros
from tests.sysid.test_stand import MODEL, log_of, stand

pytest.importorskip("scipy")

POSE = {"hip": -0.4, "knee": 0.9, "tail": 0.0}
# Beside the shank's line, so that a mirrored knee does not hang as the knee does.
SHANK = '<inertial pos="PLACE" mass="1" diaginertia="1e-9 1e-9 1e-9"/>\n      </body>'
LEG = MODEL.replace(SHANK.replace("PLACE", "0 0 -0.2"), SHANK.replace("PLACE", "0.1 0 -0.2"))
ROWS, PERIOD = 1200, 0.005


def moved(mine: Stand, turned: str = "", away: float = 0.0, command: float = 0.0) -> Log:
    """Sines about the default pose, 0.3 rad at 0.6 to 1 Hz, and the torque that the links need for them.

    Args:
        mine: The leg, whose knee reads 0.1 rad too much.
        turned: Joint that is mirrored as a whole.
        away: What part of the default pose is taken off the positions.
        command: Likewise of the commands.
    """
    assert LEG != MODEL
    t = np.arange(ROWS) * PERIOD
    names = list(POSE)
    rates = 2 * np.pi * np.array([0.6, 0.8, 1.0])
    pose = np.array(list(POSE.values()))
    q = pose + 0.3 * np.sin(t[:, None] * rates)
    qd, qdd = 0.3 * rates * np.cos(t[:, None] * rates), -0.3 * rates**2 * np.sin(t[:, None] * rates)
    at = links_at(mine.robot, names, None)
    torque = np.array([m @ a + g for (m, g), a in zip(map(at, q, qd), qdd, strict=True)]) + 0.02 * qdd
    columns = {}
    for j, name in enumerate(names):
        sign = -1.0 if name == turned else 1.0
        bias = 0.1 if name == "knee" else 0.0
        columns[name] = {
            "command": sign * (q[:, j] + torque[:, j] / 40.0 - command * pose[j]) + bias,
            "position": sign * (q[:, j] - away * pose[j]) + bias,
            "velocity": sign * qd[:, j],
            "torque": sign * torque[:, j],
        }
    return log_of(columns, time=t)


def said(
    folder: Path, turned: str = "", away: float = 0.0, command: float = 0.0
) -> tuple[frozenset[str], list[str]]:
    mine = stand(folder, "hip: -0.4 rad, knee: 0.9 rad", LEG)
    log, out = moved(mine, turned, away, command), Collector()
    joints = prepared(mine, [log], list(POSE), FitOptions(), Collector())
    assert set(joints) == set(POSE)
    return judge_zeros(mine, joints, out), [f"{item.message} | {item.help}" for item in out.sorted()]


def test_sound_angles(tmp_path: Path) -> None:
    """With an encoder's bias of 0.1 rad that the spec has."""
    assert said(tmp_path) == (frozenset(), [])


@pytest.mark.parametrize(("command", "what"), [(1.0, "position and command"), (0.0, "the position")])
def test_relative_to_the_default_pose(command: float, what: str, tmp_path: Path) -> None:
    """All joints' angles are off then; the tail's, whose pose is 0, are not named."""
    askew, (message,) = said(tmp_path, away=1.0, command=command)
    assert askew == set(POSE) and "relative to the default pose" in message
    assert message.startswith("positions and commands are") == (command == 1.0)
    assert message.endswith(f"add it: to {what} of hip -0.4 rad, knee 0.9 rad")


def test_what_asks_for_the_zero_goes_where_it_is_told(tmp_path: Path) -> None:
    """The hip is out of its range by its pose, and that is told once; the tail's pose is 0, and another log another."""
    mine = stand(tmp_path, "hip: -0.4 rad, knee: 0.9 rad", LEG)
    log, out = moved(mine, away=1.0, command=1.0), Collector()
    for joint, path in (("hip", log.path), ("tail", log.path), ("hip", "other.csv")):
        out.warning("SYS047", "the joint's range is 0 to 1 rad", where=joint, span=Span(path, 2, 3))
    judge_zeros(mine, prepared(mine, [log], list(POSE), FitOptions(), Collector()), out)
    left = [(item.where, item.span.path) for item in out if item.span is not None and item.where]
    assert left == [("tail", log.path), ("hip", "other.csv")]
    assert len(out.items) == 3


def test_some_of_the_default_pose_is_not_it(tmp_path: Path) -> None:
    """A base that is pitched looks like this: with all of the pose added less is left, with 0.8 of it least."""
    assert not [
        message for message in said(tmp_path, away=0.85, command=0.85)[1] if "default pose" in message
    ]


def test_a_mirrored_joint(tmp_path: Path) -> None:
    """The knee alone is named, though the thigh's gravity is another too."""
    askew, (message,) = said(tmp_path, turned="knee")
    assert askew == {"knee"} and message.startswith("its sign is the other way than the model's")


@pytest.mark.parametrize(("low", "told"), [(0.19, False), (0.21, True)])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_bias_that_no_encoder_has(low: float, told: bool, sign: float) -> None:
    """0.2 rad is the bound, which the whole interval must be beyond."""
    ends = sorted((sign * low, sign * (low + 0.1)))
    bias = Parameter("encoder_bias", State.IDENTIFIED, sign * (low + 0.05), 0.025, *ends, "rad")
    joint = JointFit("hip", JointKind.HINGE, (bias,), (), (), 0.0, None, 1.0, 1.0, ())
    out = Collector()
    judge_biases([joint], frozenset(), out)
    assert [item.code for item in out.sorted()] == ["SYS047"] * told
    judge_biases([joint], frozenset({"hip"}), out)
    assert len(out.sorted()) == told


def test_which_joints_move_the_one_that_is_asked_for(tmp_path: Path) -> None:
    """The knee carries the hip's point; the tail moves as much and pulls at neither."""
    mine = stand(tmp_path, "hip: -0.4 rad, knee: 0.9 rad", LEG)
    log = moved(mine)
    joints: dict[str, JointInWork] = prepared(mine, [log], ["hip"], FitOptions(), Collector())
    assert list(carried(mine, joints, FitOptions())) == ["knee"]
