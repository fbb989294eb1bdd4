"""Emitted events, run by the real mjlab and the real Isaac Lab functions."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from actspec.ir import ActuatorSet
from actspec.resolution import resolve
from actspec.robot.view import RobotView
from actspec.spec.document import document_from_text
from actspec.spec.validate import validate
from actspec.targets.base import Emission, TargetOptions
from actspec.targets.mjlab.emit import emit as emit_mjlab
from actspec.targets.randomization.emit import emit
from tests.compiling import target_options, view_of
from tests.frameworks.prepare import Frameworks

HERE = Path(__file__).parent

ENVS = 400
"""Environments. With three or so joints a range is filled to about 1 % of its width at either end."""

MODEL = """<mujoco model="leg">
  <worldbody>
    <body>
      <inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>
      <joint name="L hip" axis="0 1 0" armature="0.01" frictionloss="0.2" damping="0.05"/>
      <body pos="0 0 -0.2">
        <inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>
        <joint name="L'thigh&quot;#" axis="0 1 0" armature="0.01" frictionloss="0.2" damping="0.05"/>
        <body pos="0 0 -0.2">
          <inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>
          <joint name="L.knee" axis="0 1 0" armature="0.02" frictionloss="0.4" damping="0.1"/>
        </body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""
"""Joints in the order hip, thigh, knee, with names that must be escaped in Python and in patterns."""

NAMES = ("L hip", "L'thigh\"#", "L.knee")

LEG = """actspec: 1
robot: {name: leg, model: robot.xml}
timing: {physics_dt: 5 ms, decimation: 4}
motors:
  m: {side: joint, stall_torque: 30 N*m, no_load_speed: 20 rad/s, peak_torque: 30 N*m}
actuators:
  hips:
    joints: ["L hip", 'L.thigh.*']
    level: ideal_pd
    kp: 20 N*m/rad
    kd: 0.5 N*m*s/rad
    effort_limit: 30 N*m
    armature: 0.01 kg*m^2
    friction: {coulomb: 0.2 N*m, viscous: 0.05 N*m*s/rad}
    encoder_bias: 0.01 rad
    randomize: {%(hips)s}
  knees:
    joints: ['L\\.knee']
    motor: m
    level: dc_motor
    kp: 40 N*m/rad
    kd: 1 N*m*s/rad
    effort_limit: 25 N*m
    armature: 0.02 kg*m^2
    friction: {coulomb: 0.4 N*m, viscous: 0.1 N*m*s/rad}
    randomize: {%(knees)s}
"""


def leg(hips: str, knees: str = "") -> tuple[ActuatorSet, RobotView]:
    """The leg with ranges."""
    spec = validate(document_from_text(LEG % {"hips": hips, "knees": knees}))
    view = view_of(MODEL)
    return resolve(spec, view), view


def options(kind: str, version: str = "", **more: Any) -> TargetOptions:
    """Options of a target."""
    return target_options(kind, version, **more)


def emitted(actuators: ActuatorSet, view: RobotView, stack: str, **more: str) -> tuple[str, Emission]:
    """The one stack's text."""
    made = emit(actuators, view, options("randomization", for_=(stack,), **more))
    return made.files[0].data.decode("utf-8"), made


def filled(array: np.ndarray, low: float, high: float) -> None:
    """A uniform range is filled: everything inside, the ends nearly reached, the mean in the middle."""
    width = high - low
    slack = 1e-6 * max(abs(low), abs(high))
    assert low - slack <= array.min() and array.max() <= high + slack
    # P(no one of 400 in the outer 3 %) = 0.97^400 = 5e-6.
    assert array.min() < low + 0.03 * width and array.max() > high - 0.03 * width
    assert abs(array.mean() - (low + high) / 2) < 5 * width / math.sqrt(12 * array.size)


def run_mjlab(
    frameworks: Frameworks, hips: str, knees: str = ""
) -> tuple[dict[str, np.ndarray], dict[str, object], Emission]:
    """Compile both targets and run their text in mjlab."""
    actuators, view = leg(hips, knees)
    cfg = emit_mjlab(actuators, view, options("mjlab", "1.6")).files[0].data.decode("utf-8")
    text, made = emitted(actuators, view, "mjlab")
    job = {
        "cfg": cfg, "articulation": "LEG_ARTICULATION", "events": text, "dict": "LEG_EVENTS", "model": MODEL,
        "envs": ENVS, "partial": list(range(0, ENVS, 2)),
    }  # fmt: skip
    said, arrays = frameworks.run_probe(HERE / "randomization_mjlab_probe.py", job)
    assert tuple(said["joints"]) == NAMES
    return arrays, said, made


def test_mjlab_ranges(frameworks: Frameworks) -> None:
    """Each field of each group gets its own range, by config index and by name, and only that."""
    arrays, said, made = run_mjlab(
        frameworks,
        "kp: {scale: [0.5, 1.5]}, armature: {add: [-0.005, 0.01], when: startup}, "
        "friction.coulomb: {abs: [0.1, 0.3]}, encoder_bias: {add: [-0.02 rad, 0.04 rad]}, "
        "effort_limit: {scale: [0.5, 2]}",
        "kd: {abs: [0.5, 3]}, friction.viscous: {scale: [0, 2]}, effort_limit: {scale: [0.4, 1]}",
    )
    for when in ("first", "second"):
        at = {key.removeprefix(f"{when}_"): value for key, value in arrays.items() if key.startswith(when)}
        for hip in (0, 1):
            filled(at["kp"][:, hip], 10.0, 30.0)
            filled(at["limit"][:, hip], 15.0, 60.0)
            filled(at["dof_armature"][:, hip], 0.005, 0.02)
            filled(at["dof_frictionloss"][:, hip], 0.1, 0.3)
            # 0.01 − 0.02 and 0.01 + 0.04: the nominal bias is in it.
            filled(at["bias"][:, hip], -0.01, 0.05)
        filled(at["kd"][:, 2], 0.5, 3.0)
        filled(at["limit"][:, 2], 10.0, 25.0)
        filled(at["dof_damping"][:, 2], 0.0, 0.2)
        still = {"kd": (0, 0.5), "dof_damping": (0, 0.05), "kp": (2, 40.0), "dof_armature": (2, 0.02),
                 "dof_frictionloss": (2, 0.4), "bias": (2, 0.0)}  # fmt: skip
        for key, (column, value) in still.items():
            np.testing.assert_allclose(at[key][:, column], value, rtol=1e-6)
        assert not np.any(at["kp"][:, 0] == at["kp"][:, 1])
    # A reset draws anew for its environments alone, from the nominal; what is drawn at start-up stays.
    changed = arrays["first_kp"][:, 0] != arrays["second_kp"][:, 0]
    assert changed[::2].all() and not changed[1::2].any()
    assert np.array_equal(arrays["first_dof_armature"], arrays["second_dof_armature"])
    assert said["terms"] == {
        "reset": ["hips_gains", "knees_gains", "hips_effort_limits", "knees_effort_limits", "hips_friction",
                  "knees_viscous_friction", "hips_encoder_bias"],
        "startup": ["hips_armature"],
    }  # fmt: skip
    assert made.approximations == ()


def test_mjlab_shares_what_a_term_can_share(frameworks: Frameworks) -> None:
    """`per: env` in one term is one number a robot; a gaussian is uniform: mjlab's is one for all."""
    arrays, _, made = run_mjlab(
        frameworks,
        "armature: {scale: [0.5, 2], distribution: log_uniform, per: env}, "
        "friction.coulomb: {abs: [0.2, 0.01], distribution: gaussian, per: group}, "
        "friction.viscous: {scale: [0.5, 2]}",
    )
    for key, shared in (("dof_armature", True), ("dof_frictionloss", True), ("dof_damping", False)):
        assert np.array_equal(arrays[f"first_{key}"][:, 0], arrays[f"first_{key}"][:, 1]) is shared
    # The median of a log_uniform is the geometric mean, 0.01; its logarithm's width is ln 4 = 1.39.
    logs = np.log(arrays["first_dof_armature"][:, 0] / 0.01)
    assert abs(logs.mean()) < 5 * 1.39 / math.sqrt(12 * ENVS)
    # The uniform of the same mean and deviation: 0.2 ∓ √3 · 0.01.
    filled(arrays["first_dof_frictionloss"][:, 0], 0.18267949, 0.21732051)
    assert [(a.joint, a.field) for a in made.approximations] == [
        (joint, "mjlab.friction.coulomb") for joint in NAMES[:2]
    ]


def test_mjlab_factors(frameworks: Frameworks) -> None:
    """`gains` and `strength` become a range each for kp, kd and limit; that they are drawn apart is reported."""
    arrays, _, made = run_mjlab(
        frameworks, "gains: {scale: [0.8, 1.2]}, strength: {scale: [0.5, 1]}", "strength: {scale: [0.9, 1.1]}"
    )
    # 20 · 0.8 · 0.5 to 20 · 1.2 · 1; 0.5 likewise; 30 · 0.5 to 30.
    for hip in (0, 1):
        filled(arrays["first_kp"][:, hip], 8.0, 24.0)
        filled(arrays["first_kd"][:, hip], 0.2, 0.6)
        filled(arrays["first_limit"][:, hip], 15.0, 30.0)
    filled(arrays["first_kp"][:, 2], 36.0, 44.0)
    filled(arrays["first_limit"][:, 2], 22.5, 27.5)
    apart = np.corrcoef(arrays["first_kp"][:, 0], arrays["first_kd"][:, 0])[0, 1]
    assert abs(apart) < 5 / math.sqrt(ENVS)
    assert {(a.joint, a.field) for a in made.approximations} == {
        *((joint, f"mjlab.{field}") for joint in NAMES[:2] for field in ("gains", "strength", "kp", "kd")),
        ("L.knee", "mjlab.strength"),
    }


ISAACLAB = {"2.3": ("2.3.2.post1", "5.1.0"), "2.2": ("2.2.0", "5.0.0")}
"""Version to the wheel that is run, and the Isaac Sim version that its terms are told."""


def run_isaaclab(
    frameworks: Frameworks, hips: str, knees: str = "", version: str = "2.3"
) -> tuple[dict[str, np.ndarray], dict[str, str], Emission]:
    """Run the emitted terms with the real functions of a release."""
    actuators, view = leg(hips, knees)
    text, made = emitted(actuators, view, "isaaclab", version=version)
    wheel, sim = ISAACLAB[version]
    friction, viscous = [0.2, 0.2, 0.4], [0.05, 0.05, 0.1]
    # What the config of the release holds: before 2.3 the viscous friction is a part of the damping.
    beside = viscous if version == "2.2" else [0.0, 0.0, 0.0]
    job = {
        "root": str(frameworks.isaaclab(wheel)), "events": text, "isaac_sim": sim, "joints": list(NAMES), "envs": ENVS,
        "groups": [[0, 1], [2]], "partial": list(range(0, ENVS, 2)),
        "defaults": {"stiffness": [20.0, 20.0, 40.0],
                     "damping": [kd + more for kd, more in zip([0.5, 0.5, 1.0], beside, strict=True)],
                     "friction": friction, "dynamic": friction, "viscous": viscous, "armature": [0.01, 0.01, 0.02]},
    }  # fmt: skip
    said, arrays = frameworks.run_probe(HERE / "randomization_isaaclab_probe.py", job)
    return arrays, said["terms"], made


@pytest.mark.parametrize("version", ISAACLAB)
def test_isaaclab_gains_and_armature(frameworks: Frameworks, version: str) -> None:
    """Gains and armature of each group get their own range by joint name, drawn anew at a reset from the nominal.

    In 2.2 the damping is kd and the passive viscous friction, 0.05 and 0.1, which stays.
    """
    hip_viscous, knee_viscous = (0.05, 0.1) if version == "2.2" else (0.0, 0.0)
    arrays, terms, made = run_isaaclab(
        frameworks,
        "kp: {scale: [0, 1.5]}, kd: {scale: [0.5, 2]}, armature: {add: [-0.005, 0.01], when: startup}",
        "kd: {abs: [0.5, 3], distribution: log_uniform}",
        version,
    )
    for when in ("first", "second"):
        for hip in (0, 1):
            # A stiffness factor of 0 is refused by the term: it is written as abs.
            filled(arrays[f"{when}_stiffness"][:, hip], 0.0, 30.0)
            filled(arrays[f"{when}_damping"][:, hip], 0.25 + hip_viscous, 1.0 + hip_viscous)
            filled(arrays[f"{when}_armature"][:, hip], 0.005, 0.02)
        ends = math.log(0.5 + knee_viscous), math.log(3.0 + knee_viscous)
        filled(np.log(arrays[f"{when}_damping"][:, 2]), *ends)
        np.testing.assert_allclose(arrays[f"{when}_stiffness"][:, 2], 40.0)
        np.testing.assert_allclose(arrays[f"{when}_armature"][:, 2], 0.02)
    changed = arrays["first_damping"][:, 0] != arrays["second_damping"][:, 0]
    assert changed[::2].all() and not changed[1::2].any()
    assert np.array_equal(arrays["first_armature"], arrays["second_armature"])
    # Both as abs are one term.
    hips = ["hips_gains"] if version == "2.2" else ["hips_stiffness", "hips_damping"]
    assert terms == {**dict.fromkeys([*hips, "knees_damping"], "reset"), "hips_armature": "startup"}
    # A log_uniform kd beside a constant is not log_uniform.
    lost = {(loss.joint, loss.field) for loss in made.approximations}
    assert lost == ({("L.knee", "isaaclab.kd")} if version == "2.2" else set())


def test_isaaclab_friction_is_a_factor(frameworks: Frameworks) -> None:
    """abs [0.1, 0.3] on a Coulomb friction of 0.2 is the factor [0.5, 1.5]: viscous 0.05 stays below 0.075.

    Written as abs, Isaac Lab would have drawn a viscous friction of 0.1 to 0.3 N*m*s/rad.
    """
    arrays, terms, made = run_isaaclab(frameworks, "friction.coulomb: {abs: [0.1, 0.3]}")
    for hip in (0, 1):
        filled(arrays["first_friction"][:, hip], 0.1, 0.3)
        filled(arrays["first_viscous"][:, hip], 0.025, 0.075)
        assert np.all(arrays["first_dynamic"][:, hip] <= arrays["first_friction"][:, hip])
    np.testing.assert_allclose(arrays["first_friction"][:, 2], 0.4)
    assert terms == {"hips_friction": "reset"}
    lost = {a.field: a.max_torque_error for a in made.approximations if a.joint == "L hip"}
    # Viscous: 0.05 · 0.5 at twice the speed at which kd takes the limit, 2 · 30/0.5. Dynamic apart: 0.3 − 0.1.
    assert lost == {
        "isaaclab.friction.viscous": pytest.approx(3.0), "isaaclab.friction.coulomb": pytest.approx(0.2),
    }  # fmt: skip


def test_isaaclab_gaussian(frameworks: Frameworks) -> None:
    """A gaussian of gains is written as abs, because `scale` refuses a pair with its second number below the first."""
    arrays, _, made = run_isaaclab(frameworks, "kp: {scale: [1, 0.1], distribution: gaussian}")
    stiffness = arrays["first_stiffness"][:, :2]
    assert abs(stiffness.mean() - 20) < 5 * 2 / math.sqrt(2 * ENVS)
    assert abs(stiffness.std() - 2) < 5 * 2 / math.sqrt(4 * ENVS)
    assert made.approximations == ()
