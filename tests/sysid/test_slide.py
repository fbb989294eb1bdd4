"""A slide, in N and m: figures of an independent truth, in the units of a slide."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from actspec import api
from actspec.joints import JointKind
from actspec.logs import JointLog, Log, Sidecar
from actspec.report.sysid import sysid_record
from actspec.sysid.fit import fit_logs
from actspec.sysid.identified import State
from actspec.sysid.results import results_text
from actspec.sysid.work import FitOptions
from tests.sysid.truth import truth

pytest.importorskip("scipy")
pytestmark = pytest.mark.slow

MODEL = """<mujoco model="cart">
  <worldbody>
    <body><joint name="rail" type="slide" axis="1 0 0" range="-0.5 0.5"/><geom size=".1" mass="2"/></body>
  </worldbody>
</mujoco>
"""
SPEC = """actspec: 1
robot: {name: cart, model: cart.xml}
actuators:
  rail:
    joints: [rail]
    level: ideal_pd
    kp: 1000 N/m
    kd: 30 N*s/m
    effort_limit: 200 N
    armature: 0.1 kg
    friction: {coulomb: 1 N, viscous: 1 N*s/m}
    delay: 2 ms
"""
TRUE = {
    "kp": 800.0,
    "kd": 40.0,
    "armature": 0.3,
    "friction.coulomb": 2.0,
    "friction.viscous": 1.5,
    "delay": 0.0043,
}
UNITS = {
    "kp": "N/m",
    "kd": "N*s/m",
    "armature": "kg",
    "friction.coulomb": "N",
    "friction.viscous": "N*s/m",
    "delay": "s",
}


def test_slide(tmp_path: Path) -> None:
    """Every figure within a percent, armature within a percent of the 2.3 kg that move; results in N/m, kg, N."""
    rows, period = 2500, 0.002
    t = np.arange(rows) * period
    random = np.random.default_rng(8)
    frequency = np.geomspace(0.3, 9.0, 25)[:, None]
    shape = (
        np.sin(2 * np.pi * frequency * t + random.uniform(0, 6.28, (25, 1))) / np.sqrt(1 + frequency)
    ).sum(0)
    given = 0.1 * shape / np.abs(shape).max()
    one = {
        "J": 2.3, "kp": TRUE["kp"], "kd": TRUE["kd"], "tc": 2.0, "b": 1.5, "delay": TRUE["delay"], "limit": 200.0,
        "mgl": 0.0, "bias": 0.0,
    }  # fmt: skip
    q, qd, force = (
        part[:, 0] for part in truth({k: np.array([v]) for k, v in one.items()}, given[:, None], period)
    )
    joint = JointLog(
        "rail",
        True,
        command=given,
        position=q + 5e-5 * random.standard_normal(rows),
        velocity=qd + 0.005 * random.standard_normal(rows),
        torque=force + 0.02 * np.sqrt(np.mean(force**2)) * random.standard_normal(rows),
    )
    log = Log("cart.csv", "0" * 64, t, {"rail": joint}, Sidecar())
    (tmp_path / "cart.xml").write_text(MODEL)
    (tmp_path / "spec.yaml").write_text(SPEC)
    spec = api.load(tmp_path / "spec.yaml")
    robot = api.load_robot(spec)
    found = fit_logs(api.resolve(spec, robot), robot, [log], FitOptions())
    for field, value in TRUE.items():
        parameter = found.joints[0].parameter(field)
        assert parameter.state is State.IDENTIFIED and parameter.value is not None, field
        size = 2.3 if field == "armature" else value
        within = 0.05 if field == "friction.viscous" else 0.01
        assert parameter.value == pytest.approx(value, abs=within * size), field
        assert parameter.unit == UNITS[field]
    # A rail that lies level has no gravity that would show its encoder's bias.
    assert found.joints[0].parameter("encoder_bias").state is State.UNIDENTIFIABLE
    written = yaml.safe_load(results_text(found, [log], spec.document))
    assert written["joints"]["rail"]["kp"]["unit"] == "N/m"
    assert written["held_out_rmse"]["unit"] == "m"
    assert sysid_record(found, None)["fit"]["unit"] == "m"
    # A radian is no metre: of both there is no largest.
    hinge = replace(found.joints[0], joint="hip", kind=JointKind.HINGE)
    mixed = sysid_record(replace(found, joints=(*found.joints, hinge)), None)
    assert mixed["fit"]["held_out_rmse"] is None and mixed["fit"]["unit"] is None
    assert [joint["unit"] for joint in mixed["joints"]] == ["m", "rad"]
