"""The emitted `domain_randomize`, run on real MJX models: what it draws, and the torque of a batched step."""

from __future__ import annotations

import os
from dataclasses import replace

import numpy as np
import pytest

from actspec.verify.environments import EngineUnavailableError, prepare_release
from tests.frameworks.playground_asking import dc_motor_faults, faults, job, motors, probed
from tests.frameworks.playground_specs import FACTORS, FIELDS, GROUPS
from tests.frameworks.prepare import RELEASES, Frameworks

pytestmark = pytest.mark.slow

(TORQUE_MJX,) = RELEASES["mujoco-mjx"]
"""MJX of the torque dialect that runs on the environment's warp."""

MUTATIONS: dict[str, tuple[str, tuple[str, str], str]] = {
    "bias-sign": ("fields", (", 1].set(-kp", ", 1].set(kp"), "hip torque"),
    "kd-sign": ("fields", (", 2].set(-kd", ", 2].set(kd"), "hip kd"),
    "kp-slot-kept": (
        "fields",
        ("actuator_gainprm = actuator_gainprm.at[act[SET_1], 0].set(kp[SET_1])", "pass"),
        "hip torque",
    ),
    "encoder-bias-sign": ("fields", ("set(-kp[SET_1] * bias", "set(kp[SET_1] * bias"), "hip bias"),
    "joint-for-degree-of-freedom": (
        "fields",
        ("np.asarray(model.jnt_dofadr)[joints]", "np.array(joints)"),
        "hip armature",
    ),
    "actuator-of-a-tendon": ("fields", ("np.where(onto_joint, np.asarray(model.actuator_trnid)[:, 0], -1)",
                                        "np.asarray(model.actuator_trnid)[:, 0]"), "hip kp"),
    "one-key-for-two": ("fields", ("keys[1]", "keys[0]"), "correlated"),
    "field-not-batched": ("fields", ("dict.fromkeys(drawn, 0)", "dict.fromkeys(list(drawn)[1:], 0)"), "in_axes"),
    "kd-not-scaled": ("factors", ("kd = kd.at[SET_1].multiply(factor)", "pass"), "hip gains"),
    "strength-not-on-the-limit": ("factors", ("limit = limit * strength", "pass"), "hip limit"),
    "half-of-the-limit": ("factors", ("jnp.stack([-limit, limit]", "jnp.stack([-limit / strength, limit]"),
                          "hip torque"),
    "joints-own-range-kept": ("fields", ("jnp.maximum(own[:, 1], limit)", "own[:, 1]"), "toe capped"),
    "one-strength-a-joint": ("factors", ("keys[2], ()", "keys[2], (4,)"), "hip strength"),
}  # fmt: skip


def test_what_the_environments_mjx_takes(frameworks: Frameworks) -> None:
    """Each number is in its range, the others are the model's, the step has the law's torque; mistakes are found.

    One test, not one each: several processes of a run would each compile all of it. MJX steps FIELDS, whose batched
    fields are all that FACTORS has and more; the torque of FACTORS is MuJoCo's.
    """
    jobs = {"fields": job(GROUPS % FIELDS), "factors": job(GROUPS % FACTORS, step=False)}
    mutants = {
        key: replace(jobs[name], mutation=change, step=False) for key, (name, change, _) in MUTATIONS.items()
    }
    ran = probed(frameworks, {**jobs, **mutants, "voltage": motors("3.11", "cpp")})
    assert {name: faults(name, ran[name]) for name in jobs} == {"fields": [], "factors": []}
    # The same comparisons turn red when the function is wrong in one place.
    missed = {}
    for key, (name, _, fault) in MUTATIONS.items():
        found = faults(name, ran[key])
        if not any(item.startswith(fault) for item in found):
            missed[key] = found
    assert missed == {}
    # A dcmotor in volts: drawn by MJX, stepped by MuJoCo, as MJX takes it in its Warp implementation alone.
    run = ran["voltage"]
    assert dc_motor_faults(run, run.arrays["own_force"], voltage=True) == []
    assert run.said["batched"] == run.said["replaced"] == ["actuator_forcerange", "actuator_gainprm"]


def test_dcmotor_in_torque(frameworks: Frameworks) -> None:
    """From MuJoCo 3.12: drawn and stepped by MJX in its Warp implementation."""
    try:
        folders = str(prepare_release("mujoco", TORQUE_MJX)), str(prepare_release("mujoco-mjx", TORQUE_MJX))
    except EngineUnavailableError as err:
        (pytest.fail if os.environ.get("CI") else pytest.skip)(str(err))
    run = probed(frameworks, {"torque": motors("3.17", "warp")}, *folders)["torque"]
    assert dc_motor_faults(run, run.arrays["force"], voltage=False) == []
    np.testing.assert_allclose(run.arrays["force"], run.arrays["own_force"], rtol=1e-4, atol=1e-4)
    assert run.said["batched"] == run.said["replaced"] == ["actuator_forcerange", "actuator_gainprm"]
