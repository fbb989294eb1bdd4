"""The runtime of networks against the bare forward pass of the same networks, in turn, in processor time.

    python benchmarks/runtime.py [--threads 2] [--rounds 30] [--isaaclab FOLDER]

Exit code 1: a budget is exceeded.
"""

from __future__ import annotations

import argparse
import itertools
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import torch

from actspec.laws.network import Dense, Layers, NetworkLaw
from actspec.learn.attach import Attached
from actspec.learn.batch import Networks
from actspec.learn.bundle import Bundle, DrivenGroup, DrivenJoint
from actspec.verify.environments import cache_folder

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
    """Least processor time of each [s], called in turn: other work on the machine only adds. Three rounds warm up."""
    times: list[list[float]] = [[] for _ in functions]
    for k in range(rounds + 3):
        for found, function in zip(times, functions, strict=True):
            begun = time.process_time()
            function()
            if k >= 3:
                found.append(time.process_time() - begun)
    return [min(found) for found in times]


def in_isaaclab(root: Path, bare: Any, taps: int) -> Callable[..., Any]:
    """Isaac Lab's own class with the same network and clamp, from the real package on this machine's processor."""
    here = Path(__file__).resolve().parents[1] / "actspec"
    # Packages that isaaclab imports and this environment lacks, such as warp, lie beside it.
    sys.path += [str(path) for path in root.parents[3].glob("venv/lib/python*/site-packages")]
    sys.path[:0] = [str(here / "verify" / "probes"), str(here / "simulate")]
    import probe_isaaclab as probe  # type: ignore[import-not-found]

    if "isaaclab" not in sys.modules:
        probe.enable(str(root))
    from isaaclab.actuators import ActuatorNetMLPCfg  # type: ignore[import-not-found]

    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "net.pt")
        torch.jit.save(bare, path)
        cfg = ActuatorNetMLPCfg(
            joint_names_expr=[".*"],
            network_file=path,
            pos_scale=1.0,
            vel_scale=1.0,
            torque_scale=1.0,
            input_order="pos_vel",
            input_idx=list(range(taps)),
            effort_limit=30.0,
            saturation_effort=40.0,
            velocity_limit=20.0,
        )
        _, _, build = probe.builder(cfg, [f"j{i}" for i in range(JOINTS)], ENVS, 0.0)
        actuator = build()
    actuator.reset(list(range(ENVS)))

    def run(command: Any, q: Any, qd: Any) -> Any:
        from isaaclab.utils.types import ArticulationActions  # type: ignore[import-not-found]

        actuator.compute(ArticulationActions(command, 0.0 * qd, 0.0 * qd), q, qd)
        return actuator.applied_effort

    return run


def joint_by_joint(bare: Any, taps: int) -> Callable[..., Any]:
    """As it is first written: a loop over joints, each with its history, and the clamp."""
    past = [torch.zeros(ENVS, 2 * taps) for _ in range(JOINTS)]

    def run(command: Any, q: Any, qd: Any) -> Any:
        out = torch.empty(ENVS, JOINTS)
        for j, x in enumerate(past):
            x[:, 1:taps], x[:, taps + 1 :] = x[:, : taps - 1].clone(), x[:, taps:-1].clone()
            x[:, 0], x[:, taps] = command[:, j] - q[:, j], qd[:, j]
            most = (40.0 * (1.0 - qd[:, j] / 20.0)).clamp(-30.0, 30.0)
            least = (40.0 * (-1.0 - qd[:, j] / 20.0)).clamp(-30.0, 30.0)
            out[:, j] = torch.minimum(torch.maximum(bare(x)[:, 0], least), most)
        return out

    return run


def dc_motor(steps: int) -> Callable[..., Any]:
    """What a network stands beside: gains, a delay of whole steps, limit and torque-speed line."""
    past = torch.zeros(steps + 1, ENVS, JOINTS)
    at = 0

    def run(command: Any, q: Any, qd: Any) -> Any:
        nonlocal at
        at = (at + 1) % (steps + 1)
        past[at] = command
        wanted = 25.0 * (past[(at + 1) % (steps + 1)] - q) - 0.5 * qd
        line = 40.0 / 20.0 * qd
        most, least = (40.0 - line).clamp(-30.0, 30.0), (-40.0 - line).clamp(-30.0, 30.0)
        return torch.minimum(torch.maximum(wanted, least), most)

    return run


def many(rounds: int, root: Path | None) -> list[float]:
    """4096 environments: ratios to the bare pass, of ours first; others stand beside and have no budget."""
    ratios = []
    for sizes, activation, taps in CASES:
        bundle, bare = network(sizes, activation, taps)
        x = torch.randn(ENVS * JOINTS, sizes[0])
        given = tuple(torch.randn(ENVS, JOINTS) for _ in range(3))
        ours, arrays = Networks(bundle, ENVS), Networks(bundle, ENVS)
        plain = [part.numpy() for part in given]
        rows: dict[str, Callable[[], object]] = {
            "bare pass": lambda bare=bare, x=x: bare(x),
            "this, torch": lambda ours=ours, given=given: ours.torque(*given),
            "this, numpy": lambda arrays=arrays, plain=plain: arrays.torque(*plain),
        }
        others = {"a loop over joints": joint_by_joint(bare, taps), "DC motor with delay": dc_motor(2)}
        if root is not None:
            others["Isaac Lab's class"] = in_isaaclab(root, bare, taps)
        for name, other in others.items():
            rows[name] = lambda other=other, given=given: other(*given)
        with torch.no_grad():
            times = dict(zip(rows, in_turn(rounds, *rows.values()), strict=True))
        size = "-".join(map(str, sizes))
        for name, found in times.items():
            ratio = found / times["bare pass"]
            own = name.startswith("this")
            ratios += [ratio] * own
            budget = f"{BUDGET:g}" if own else ""
            print(f"| {size}, {name} | {found * 1e3:.2f} | {ratio:.2f} | {budget} |")
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
    print(f"| one simulation, a step: frozen pass | {a / 1e3:.4f} | 1.00 | |")
    print(f"| one simulation, a step: what networks add | {added / 1e3:.4f} | {added / a:.2f} | {budget} |")
    return added, added / a


def main() -> int:
    """Print the table; 1 where a budget is exceeded."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--threads", type=int, default=torch.get_num_threads())
    parser.add_argument("--rounds", type=int, default=30)
    parser.add_argument(
        "--isaaclab", type=Path, help="folder of the isaaclab package; default: that of `verify --setup`"
    )
    options = parser.parse_args()
    torch.set_num_threads(options.threads)
    print(f"{ENVS} x {JOINTS}, history and clamp included; {options.threads} threads")
    print("| | ms | of the bare pass | budget |\n|---|---:|---:|---:|")
    found = sorted(cache_folder().glob("frameworks-*/isaaclab-2.3*/isaaclab/source/isaaclab"))
    root = options.isaaclab or (found[-1] if found else None)
    ratios = many(options.rounds, root)
    added, ratio = one(options.rounds)
    return int(max(ratios) > BUDGET or added > STEP_BUDGET or ratio > STEP_RATIO)


if __name__ == "__main__":
    raise SystemExit(main())
