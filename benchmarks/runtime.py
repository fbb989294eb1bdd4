"""The runtime of networks against the bare forward pass of the same networks, on the same processor, in turn.

    python benchmarks/runtime.py [--threads 2] [--rounds 30]

Exit code 1: a budget is exceeded.
"""

from __future__ import annotations

import argparse
import itertools
import statistics
import time
from collections.abc import Callable
from typing import Any

import mujoco
import numpy as np
import torch

from actspec.laws.network import Dense, Layers, NetworkLaw
from actspec.learn.attach import Attached
from actspec.learn.batch import Networks
from actspec.learn.bundle import Bundle, DrivenGroup, DrivenJoint

ENVS, JOINTS = 4096, 12
CASES = (((12, 128, 128, 1), "elu", 6), ((6, 32, 32, 1), "softsign", 3))
"""Sizes, activation and taps: those of this project's trainer, and of the network that walk-these-ways published."""
BUDGET, STEP_BUDGET, STEP_RATIO = 1.0, 50.0, 2.0


def network(sizes: tuple[int, ...], activation: str, taps: int) -> tuple[Bundle, Any]:
    """A robot's joints with a network of random weights, and the same network frozen by torch."""
    random = np.random.default_rng(0)
    dense, modules = [], []
    last = len(sizes) - 2
    for i, (a, b) in enumerate(itertools.pairwise(sizes)):
        weight, bias = random.normal(size=(b, a)) / np.sqrt(a), 0.1 * random.normal(size=b)
        dense.append(Dense(weight, bias, activation if i < last else "identity"))
        layer = torch.nn.Linear(a, b)
        layer.weight.data = torch.tensor(weight, dtype=torch.float32)
        layer.bias.data = torch.tensor(bias, dtype=torch.float32)
        modules.append(layer)
        if i < last:
            modules.append(torch.nn.ELU() if activation == "elu" else torch.nn.Softsign())
    law = NetworkLaw(Layers((), tuple(dense)), tuple(range(taps)), 1.0)
    joints = tuple(DrivenJoint(f"j{i}", f"j{i}", 30.0, (40.0, 20.0), None, 0.0) for i in range(JOINTS))
    bare = torch.jit.freeze(torch.jit.script(torch.nn.Sequential(*modules).eval()))
    return Bundle("", 0.005, (DrivenGroup("net.onnx", law, joints, None),)), bare


def in_turn(rounds: int, *functions: Callable[[], object]) -> list[float]:
    """Median of each [s], called in turn; the first three rounds do not count."""
    times: list[list[float]] = [[] for _ in functions]
    for k in range(rounds + 3):
        for found, function in zip(times, functions, strict=True):
            begun = time.perf_counter()
            function()
            if k >= 3:
                found.append(time.perf_counter() - begun)
    return [statistics.median(found) for found in times]


def many(rounds: int) -> list[float]:
    """4096 environments: ratios to the bare pass."""
    ratios = []
    for sizes, activation, taps in CASES:
        bundle, bare = network(sizes, activation, taps)
        x = torch.randn(ENVS * JOINTS, sizes[0])
        command, q, qd = (torch.randn(ENVS, JOINTS) for _ in range(3))
        ours, arrays = Networks(bundle, ENVS), Networks(bundle, ENVS)
        given = [part.numpy() for part in (command, q, qd)]
        with torch.no_grad():
            a, b, c = in_turn(
                rounds,
                lambda bare=bare, x=x: bare(x),
                lambda ours=ours: ours.torque(command, q, qd),  # noqa: B023
                lambda arrays=arrays: arrays.torque(*given),  # noqa: B023
            )
        name = "-".join(map(str, sizes))
        print(f"| {name}, torch | {a * 1e3:.1f} | {b * 1e3:.1f} | {b / a:.2f} | {BUDGET:g} |")
        print(f"| {name}, numpy | {a * 1e3:.1f} | {c * 1e3:.1f} | {c / a:.2f} | {BUDGET:g} |")
        ratios += [b / a, c / a]
    return ratios


def one(rounds: int) -> tuple[float, float]:
    """One simulation: what networks add to a step [us], and its ratio to the frozen pass."""
    sizes, activation, taps = CASES[0]
    bundle, bare = network(sizes, activation, taps)
    bodies = "".join(
        f'<body pos="{i} 0 0"><joint name="j{i}" damping="2"/><geom size=".1" contype="0" conaffinity="0"/></body>'
        for i in range(JOINTS)
    )
    motors = "".join(f'<motor name="j{i}" joint="j{i}"/>' for i in range(JOINTS))
    xml = f'<mujoco><option timestep="0.005"/><worldbody>{bodies}</worldbody><actuator>{motors}</actuator></mujoco>'
    model, without = (mujoco.MjModel.from_xml_string(xml) for _ in range(2))
    data, other = mujoco.MjData(model), mujoco.MjData(without)
    # Short enough for a slice of the processor's time, which other work may take.
    x, n = torch.randn(JOINTS, sizes[0]), 50
    with Attached(model, bundle), torch.no_grad():

        def repeat(function: Callable[[], object]) -> Callable[[], None]:
            def run() -> None:
                for _ in range(n):
                    function()

            return run

        a, b, c = (
            seconds / n * 1e6
            for seconds in in_turn(
                20 * rounds,
                repeat(lambda: bare(x)),
                repeat(lambda: mujoco.mj_step(model, data)),
                repeat(lambda: mujoco.mj_step(without, other)),
            )
        )
    added = b - c
    budget = f"{STEP_BUDGET:g} us, {STEP_RATIO:g}"
    print(f"| one simulation, a step [us] | {a:.1f} | {added:.1f} | {added / a:.2f} | {budget} |")
    return added, added / a


def main() -> int:
    """Print the table; 1 where a budget is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--threads", type=int, default=torch.get_num_threads())
    parser.add_argument("--rounds", type=int, default=30)
    options = parser.parse_args()
    torch.set_num_threads(options.threads)
    print(f"{ENVS} x {JOINTS}, history and clamp included; {options.threads} threads")
    print("| | bare pass [ms] | runtime [ms] | ratio | budget |\n|---|---:|---:|---:|---:|")
    ratios = many(options.rounds)
    added, ratio = one(options.rounds)
    return int(max(ratios) > BUDGET or added > STEP_BUDGET or ratio > STEP_RATIO)


if __name__ == "__main__":
    raise SystemExit(main())
