"""Compile ranges for Playground, run the function in MJX, and say in what it differs from what is asked."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from actspec.laws import law_of
from actspec.targets.kit.draws import strengthened
from actspec.targets.randomization.emit import emit
from tests.compiling import Compiled, compile_text, target_options
from tests.frameworks.playground_specs import ASKED, BATCHED, HIPS, JOINTS, MODEL, MOTORS, NOMINAL
from tests.frameworks.prepare import Frameworks

PROBE = Path(__file__).with_name("playground_probe.py")

ENVS = 400
"""A uniform range is filled to 3 % of its width at either end: P(no one of 400 in the outer 3 %) = 5e-6."""

SIGMAS = 5.0
"""How far a mean of a sample may be off, in its standard deviations."""

RTOL = 1e-5
"""MJX computes in single precision: 24 bits, a few roundings deep."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Job:
    """A function and its model.

    Attributes:
        compiled: The spec, compiled to MuJoCo.
        text: The function's module.
        impl: MJX's implementation.
        joints: Driven joints, the columns of q and qd.
        step: Whether MJX steps it: seconds to compile.
        mutation: Text to replace in the module, and what by.
    """

    compiled: Compiled
    text: str
    impl: str = "jax"
    step: bool = True
    joints: tuple[str, ...] = JOINTS
    mutation: tuple[str, str] = ("", "")

    def request(self) -> dict[str, Any]:
        """For the probe."""
        old, new = self.mutation
        assert old in self.text, old
        return {
            "text": self.text.replace(old, new) if old else self.text,
            "model": self.compiled.text,
            "impl": self.impl,
            "step": self.step,
            "envs": ENVS,
            "seed": 3,
            "joints": list(self.joints),
        }

    def state(self) -> dict[str, Array]:
        """States, and commands that ask each joint for -3 to 3 times its limit; the first control is the tendon's."""
        rng = np.random.default_rng(5)
        q, qd, share = (rng.uniform(-end, end, (ENVS, len(self.joints))) for end in (0.6, 12.0, 3.0))
        ctrl = np.zeros((ENVS, 1 + len(self.joints)))
        ctrl[:, 0] = rng.uniform(-1.0, 1.0, ENVS)
        for column, name in enumerate(self.joints):
            actuator = self.compiled.actuators.joint(name)
            assert actuator is not None
            law = law_of(actuator)
            asked = share[:, column] * law.effort_limit
            ctrl[:, 1 + column] = {
                "position": q[:, column] + (asked + law.kd * qd[:, column]) / (law.kp or 1.0),
                "velocity": qd[:, column] + asked / (law.kd or 1.0),
                "effort": asked,
            }[actuator.command.value]
        # What reaches MJX is in single precision.
        return {
            key: value.astype(np.float32).astype(float)
            for key, value in (("q", q), ("qd", qd), ("ctrl", ctrl))
        }


def job(groups: str, version: str = "3.11", *, robot: str = "", **more: Any) -> Job:
    """Compile a spec for MuJoCo and its ranges for Playground."""
    compiled = compile_text(groups, MODEL, version, robot=robot)
    options = target_options("randomization", version, name="dr", for_=("playground",))
    text = emit(compiled.actuators, compiled.robot, options).files[0].data.decode("utf-8")
    return Job(compiled, text, **more)


def motors(version: str, impl: str) -> Job:
    """MOTORS for a MuJoCo version."""
    unmanaged = "unmanaged: [rest, toe]"
    return job(MOTORS, version, robot=unmanaged, impl=impl, step=impl != "cpp", joints=JOINTS[1:4])


@dataclass
class Run:
    """One function, run."""

    job: Job
    said: dict[str, Any]
    arrays: dict[str, Array]

    def numbers(self) -> dict[tuple[str, str], Array]:
        """What every environment's model says of every joint, (n_env,)."""
        gain, bias, limit = (self.arrays[f"actuator_{name}"] for name in ("gainprm", "biasprm", "forcerange"))
        found: dict[tuple[str, str], Array] = {}
        for name, dof in zip(self.job.joints, self.said["dofs"], strict=True):
            act = self.said["actuators"].index(name)
            actuator = self.job.compiled.actuators.joint(name)
            assert actuator is not None
            found[name, "limit"] = limit[:, act, 1]
            for key, field in (("armature", "armature"), ("coulomb", "frictionloss"), ("viscous", "damping")):
                found[name, key] = self.arrays[f"dof_{field}"][:, dof]
            if actuator.command.value == "position":
                found[name, "kp"] = gain[:, act, 0]
                found[name, "bias"] = -bias[:, act, 0] / gain[:, act, 0]
            if actuator.command.value != "effort":
                found[name, "kd"] = -bias[:, act, 2]
        return found


def sample_fault(values: Array, distribution: str, low: float, high: float) -> str:
    """In what a sample is not of its distribution; empty: in nothing."""
    if distribution == "gaussian":
        root = math.sqrt(values.size)
        good = abs(values.mean() - low) < SIGMAS * high / root
        good &= abs(values.std() - high) < SIGMAS * high / math.sqrt(2) / root
    else:
        if distribution == "log_uniform":
            if values.min() <= 0.0:
                return f"has {values.min():g}"
            values, low, high = np.log(values), math.log(low), math.log(high)
        width = high - low
        good = low - 1e-5 * width <= values.min() and values.max() <= high + 1e-5 * width
        if distribution != "product":
            good = good and values.min() < low + 0.03 * width and values.max() > high - 0.03 * width
            good = good and abs(values.mean() - (low + high) / 2) < SIGMAS * width / math.sqrt(
                12 * values.size
            )
    return (
        ""
        if good
        else f"{values.min():g} to {values.max():g}, mean {values.mean():g}: not {distribution} {low:g}, {high:g}"
    )


def drawn_faults(numbers: Mapping[tuple[str, str], Array], asked: Mapping[tuple[str, str], Any]) -> list[str]:
    """Numbers that are not in their range, and not the nominal where nothing is drawn."""
    found = []
    for name, values in NOMINAL.items():
        for key, nominal in values.items():
            got = numbers[name, key]
            if (name, key) in asked:
                fault = sample_fault(got, *asked[name, key])
                if fault:
                    found.append(f"{name} {key} {fault}")
            elif not np.allclose(got, nominal, rtol=1e-6, atol=1e-9):
                found.append(
                    f"{name} {key} {got.min():g} to {got.max():g}, nothing draws it from {nominal:g}"
                )
    return found


def shared_faults(numbers: Mapping[tuple[str, str], Array]) -> list[str]:
    """FACTORS: kp and kd have one factor a group, and all torques of a robot one strength."""
    share = {
        key: values / NOMINAL[key[0]][key[1]]
        for key, values in numbers.items()
        if NOMINAL[key[0]].get(key[1])
    }
    strength = share["toe", "limit"]
    found = [
        f"{name} strength"
        for name in (*HIPS, "knee")
        if not np.allclose(share[name, "limit"], strength, rtol=RTOL)
    ]
    if not np.allclose(share["knee", "kd"], strength, rtol=RTOL):
        found.append("knee gains")
    factor = share["hip", "kp"] / strength
    for hip in HIPS:
        for key in ("kp", "kd"):
            if not np.allclose(share[hip, key] / strength, factor, rtol=RTOL) or sample_fault(
                factor, "uniform", 0.8, 1.2
            ):
                found.append(f"{hip} gains")
    if not np.array_equal(numbers[HIPS[0], "viscous"], numbers[HIPS[1], "viscous"]):
        found.append("hip viscous")
    return found


def correlated(columns: list[Array]) -> list[str]:
    """Draws that are not independent."""
    moving = np.array([column for column in columns if np.ptp(column) > 0.0])
    table = np.corrcoef(moving) - np.eye(len(moving))
    worst = float(np.abs(table).max())
    return [f"correlated: {worst:.2f}"] if worst > SIGMAS / math.sqrt(ENVS) else []


def capped(run: Run) -> list[str]:
    """The toe's own force range, -9 to 8 N*m, where it is not widened to a limit above it."""
    toe = run.said["joints"][run.job.joints.index("toe")]
    limit = run.numbers()["toe", "limit"]
    wanted = np.stack([-np.maximum(9.0, limit), np.maximum(8.0, limit)], axis=1)
    return [] if np.allclose(run.arrays["jnt_actfrcrange"][:, toe], wanted, rtol=RTOL) else ["toe capped"]


def torque_faults(run: Run) -> list[str]:
    """Joints whose torque is not the law's with the drawn numbers."""
    found, numbers, state = [], run.numbers(), run.job.state()
    force = run.arrays["force" if run.job.step else "own_force"]
    for column, name in enumerate(run.job.joints):
        actuator = run.job.compiled.actuators.joint(name)
        assert actuator is not None
        law, act = law_of(actuator), run.said["actuators"].index(name)
        q, qd, ctrl = state["q"][:, column], state["qd"][:, column], state["ctrl"][:, act]
        for env in range(ENVS):
            mine = {
                key: float(numbers[name, key][env]) for key in ("kp", "kd", "bias") if (name, key) in numbers
            }
            drawn = replace(
                law,
                kp=mine.get("kp", law.kp),
                kd=mine.get("kd", law.kd),
                encoder_bias=mine.get("bias", law.encoder_bias),
                effort_limit=float(numbers[name, "limit"][env]),
            )
            want = float(drawn.torque(ctrl[env], q[env], qd[env]))
            terms = max(drawn.kp, 1.0) * abs(ctrl[env]) + drawn.kd * abs(qd[env])
            got = float(force[env, act])
            # Terms that cancel leave their rounding: that of the largest.
            if abs(got - want) > RTOL * abs(want) + 1e-6 * terms:
                found.append(f"{name} torque: {got:g}, the law has {want:g}")
                break
    return found


def faults(name: str, run: Run) -> list[str]:
    """Everything in which a run of FIELDS or FACTORS differs from what is asked."""
    if "error" in run.said:
        return [f"error: {run.said['error']}"]
    found = []
    wanted = BATCHED[name]
    if run.said["batched"] != wanted or run.said["replaced"] != wanted or run.said["leaves"] != len(wanted):
        found.append(f"in_axes of {run.said['batched']}, replaced {run.said['replaced']}, asked {wanted}")
    numbers = run.numbers()
    found += drawn_faults(numbers, ASKED[name])
    if name == "factors":
        found += shared_faults(numbers)
    else:
        found += correlated([numbers[key] for key in ASKED[name]])
        found += capped(run)
    found += torque_faults(run)
    # Every number that was drawn acts, the passive ones too: MuJoCo's own step with them ends as MJX's.
    if run.job.step:
        speed = np.abs(run.arrays["own_qvel"]).max()
        if not np.allclose(run.arrays["qvel"], run.arrays["own_qvel"], rtol=0.0, atol=1e-4 * speed):
            found.append("step: not MuJoCo's")
    return found


def probed(
    frameworks: Frameworks, jobs: Mapping[str, Job], mujoco: str = "", mjx: str = ""
) -> dict[str, Run]:
    """Run functions in one process."""
    arrays = {f"{name}.{key}": value for name, one in jobs.items() for key, value in one.state().items()}
    request = {"mujoco": mujoco, "mjx": mjx, "runs": {name: one.request() for name, one in jobs.items()}}
    said, out = frameworks.run_probe(PROBE, request, arrays)
    return {
        name: Run(
            one,
            said[name],
            {k.removeprefix(f"{name}."): v for k, v in out.items() if k.startswith(f"{name}.")},
        )
        for name, one in jobs.items()
    }


def dc_motor_faults(run: Run, force: Array, voltage: bool) -> list[str]:
    """In what drawn dcmotors are not s · clip(f_p kp e − f_d kd w) with the line and the limit at s times theirs."""
    if "error" in run.said:
        return [run.said["error"]]
    found, state = [], run.job.state()
    gain, limit = run.arrays["actuator_gainprm"], run.arrays["actuator_forcerange"]
    strength = limit[:, 1, 1] / 20.0
    numbers = {"strength": ("uniform", 0.5, 1.5, strength)}
    for column, name in enumerate(run.job.joints):
        act = run.said["actuators"].index(name)
        if not np.allclose(limit[:, act], 20.0 * strength[:, None] * [-1.0, 1.0], rtol=RTOL):
            found.append(f"{name} limit")
        kp, kd = gain[:, act, 4], gain[:, act, 6]
        if voltage:
            # Nominal resistance and torque constant of 45 N*m and 30 rad/s at 24 V: K = V/w0, R = K V / stall.
            constant = 24.0 / 30.0
            ratio = (constant * 24.0 / 45.0) / constant
            kp, kd = kp / ratio, (kd + constant) / ratio
        else:
            kp, kd = kp / strength, kd / strength
        numbers |= {f"{name} kp": ("uniform", 12.5, 50.0, kp), f"{name} kd": ("uniform", 0.1, 1.5, kd)}
        actuator = run.job.compiled.actuators.joint(name)
        assert actuator is not None
        for env in range(ENVS):
            law = replace(law_of(actuator), kp=float(kp[env]), kd=float(kd[env]))
            q, qd = state["q"][env, column], state["qd"][env, column]
            want = float(strengthened(law, float(strength[env])).torque(state["ctrl"][env, act], q, qd))
            if abs(force[env, act] - want) > 5e-5 * (1.0 + abs(want)):
                found.append(f"{name} torque: {force[env, act]:g}, the law has {want:g}")
                break
    for name, (distribution, low, high, values) in numbers.items():
        fault = sample_fault(values, distribution, low, high)
        if fault:
            found.append(f"{name} {fault}")
    return found + correlated([values for *_, values in numbers.values()])
