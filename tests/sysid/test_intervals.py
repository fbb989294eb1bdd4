"""Intervals that hold: few blocks, residuals that are alike within each, and what the sidecar says may be off."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from actspec import api
from actspec.diagnostics import Collector
from actspec.logs import Log, Sidecar
from actspec.sysid.fit import prepared, roll
from actspec.sysid.profile import profiled, weak
from actspec.sysid.stand import Stand
from actspec.sysid.system import System
from actspec.sysid.work import FitOptions, JointInWork, ended
from tests.sysid import test_fit
from tests.sysid.test_fit import LINK, TRUE, fitted, logged

pytest.importorskip("scipy")

ROWS, PIECES = 100, 3
ALIKE = 0.8
"""Of a residual and the next."""


def line(random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives over two figures and over a piece's own offset and slope."""
    jac = random.standard_normal((ROWS, PIECES, 2)).cumsum(axis=0) / 10.0
    local = np.stack([np.ones((ROWS, PIECES)), np.arange(ROWS)[:, None] * np.ones(PIECES) / ROWS], axis=2)
    return jac, local


def errors(random: np.random.Generator) -> np.ndarray:
    """Residuals that are alike for about five rows."""
    found = random.standard_normal((ROWS, PIECES))
    for row in range(1, ROWS):
        found[row] = ALIKE * found[row - 1] + math.sqrt(1 - ALIKE**2) * found[row]
    return found


def held(rows: int) -> float:
    """Share of intervals that have the truth, 0, in them."""
    random, inside = np.random.default_rng(1), []
    for _ in range(150):
        jac, local = line(random)
        system = System([{"position": (errors(random), jac, local)}], 2)
        noise = system.noise()
        solved = system.solve(noise)
        std = np.sqrt(np.diag(solved.sandwich(*system.blocks(noise, solved, rows))))
        inside.append(np.abs(solved.step(0.0)) < 1.96 * std)
    return float(np.mean(inside))


@pytest.mark.slow
def test_intervals_of_three_pieces_hold() -> None:
    """Blocks of 15 rows, three times as long as residuals are alike, hold; residuals taken for white do not."""
    assert 0.9 < held(15) < 0.99
    assert held(1) < 0.85


def test_pieces_left_out_are_as_without_them() -> None:
    """The error of pieces that a fit did not see, by a second least squares over the others."""
    random = np.random.default_rng(3)
    jac, local = line(random)
    r = errors(random) + jac @ np.array([2.0, -1.0])
    out = np.array([False, True, False])
    found = System([{"position": (r, jac, local)}], 2).left_out({"position": 1.0}, [out])
    columns, zero = [], np.zeros((ROWS, 2))
    for at, piece in enumerate((0, 2)):
        own = [zero, zero]
        own[at] = local[:, piece]
        columns.append(np.concatenate([jac[:, piece], *own], axis=1))
    best = np.linalg.lstsq(np.concatenate(columns), np.concatenate([r[:, 0], r[:, 2]]), rcond=None)[0][:2]
    left = r[:, 1] - jac[:, 1] @ best
    left = left - local[:, 1] @ np.linalg.lstsq(local[:, 1], left, rcond=None)[0]
    assert found.logs[0]["position"][0][:, 0] == pytest.approx(left, abs=1e-9)


@pytest.mark.slow
def test_what_may_be_off_is_in_the_interval(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A torque of 3 % scales all that it tells; masses of 5 % move the armature beside links of 0.018 kg*m^2."""
    monkeypatch.setattr(test_fit, "MODEL", test_fit.MODEL.replace("1e-9 1e-9 1e-9", f"{LINK} {LINK} {LINK}"))
    accuracy = {"accuracy": {"torque": "3 %", "masses": "5 %"}}
    log = replace(logged(gravity=False), sidecar=Sidecar.model_validate(accuracy))
    joint = fitted(tmp_path, log, axis="0 0 1").joints[0]
    expected = {name: 0.03 * TRUE[name] for name in ("kp", "kd", "friction.coulomb")}
    # 3 % of 0.03 kg*m^2, and 5 % of the links' 0.018.
    expected["armature"] = math.hypot(0.03 * (LINK + TRUE["armature"]), 0.05 * LINK)
    for field, std in expected.items():
        assert joint.parameter(field).std == pytest.approx(std, rel=0.03), field
    alike = {(a, b): r for a, b, r in joint.correlation}
    assert alike[("kp", "kd")] > 0.99


@pytest.mark.slow
def test_a_weak_figure_s_interval_ends_where_the_cost_has_risen(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Coulomb friction of 0: from 0 on, and up to where a fit that holds it costs 1.96 deviations more."""
    monkeypatch.setitem(TRUE, "friction.coulomb", 0.0)
    log = test_fit.bare(logged(gravity=True), "gains")
    free = rolled(tmp_path, log)
    assert free.fit is not None
    assert weak(free, free.fit, "coulomb") and not weak(free, free.fit, "armature")
    low, high = profiled(free, free.fit, ended(free), "coulomb", {})
    assert low == 0.0 and free.fit.values["coulomb"] < high < 0.003
    monkeypatch.setattr(test_fit, "SPEC", test_fit.SPEC.replace("coulomb: 0.1", f"coulomb: {high!r}"))
    held = rolled(tmp_path, log, "friction.coulomb")
    risen = ended(held).cost(free.fit.noise) - ended(free).cost(free.fit.noise)
    i = free.fit.free.index("coulomb")
    white = np.linalg.inv(free.fit.normal)[i, i]
    assert risen == pytest.approx(1.96**2 * free.fit.covariance[i, i] / white, rel=0.1)
    # What goes with a figure ends where it does.
    std, values = np.sqrt(np.diag(free.fit.covariance)), free.fit.values
    as_one, armature = replace(free.fit, covariance=np.outer(std, std)), values["armature"]
    ends = {"coulomb": ({**values, "armature": armature + 2e-3}, {**values, "armature": armature - 1e-3})}
    found = profiled(free, as_one, ended(free), "armature", ends)
    assert found == pytest.approx((armature - 1e-3, armature + 2e-3))


def rolled(folder: Path, log: Log, hold: str = "") -> JointInWork:
    """A joint after its rollouts."""
    (folder / "bench.xml").write_text(test_fit.MODEL.replace("AXIS", "0 1 0"))
    (folder / "spec.yaml").write_text(test_fit.SPEC)
    spec = api.load(folder / "spec.yaml")
    robot, out = api.load_robot(spec), Collector()
    options = FitOptions(hold=frozenset({hold} if hold else ()))
    stand = Stand(robot, api.resolve(spec, robot))
    joints = prepared(stand, [log], ["hip"], options, out)
    roll(stand, [log], joints, options, out)
    return joints["hip"]


def test_a_channel_without_noise_has_a_least_one() -> None:
    """Residuals of 1e-6 of a signal of 2 rad/s: they count as 1e-4 of it, and the cost of a better fit still falls."""
    local = np.zeros((50, 2, 2))
    found = [
        System([{"velocity": (size * np.ones((50, 2)), np.zeros((50, 2, 0)), local)}], 0, {"velocity": 2e-4})
        for size in (2e-6, 1e-6)
    ]
    assert [one.noise()["velocity"] for one in found] == [2e-4, 2e-4]
    assert found[1].likelihood({"velocity": 2e-4}) < found[0].likelihood({"velocity": 2e-4})
