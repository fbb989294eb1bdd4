"""Run by `Frameworks.run_probe`: executes a cfg's text in a real Isaac Lab package and asks its actuators.

Job:
    root: folder of the real `isaaclab` package.
    text: the module's text; constant: name of its dict of cfgs.
    joints: all joints of the robot, in its order; the columns of every array.
    usd: the number that stands for whatever the USD would say.
    seed: of torch's generator.
    networks: names of arrays that are files beside the module, as bytes.
    make: instead of all that, networks to make: name to its description.
    live: instead of text and constant, a spec for `actspec.isaaclab`; paths: for sys.path, behind all others.
Arrays: positions, velocities, efforts (the action), q, qd; each (n_step, n_env, n_joint).

Answers: version; per joint its group, class and numbers; array `torque` (n_step, n_env, n_joint) after a reset,
`again` the same motion once more after a reset of the first environment alone, `fresh` without any reset.
"""

from __future__ import annotations

import io
import json
import sys
from pathlib import Path

import numpy as np
import torch

sys.path.insert(0, str(Path(__file__).parents[2] / "actspec" / "verify" / "probes"))

from probe_isaaclab import NUMBERS, PARTS, builder, enable, load, numbers, step


def make(description: dict) -> bytes:
    """A TorchScript network with weights from the test."""
    if description["kind"] == "mlp":
        layer = torch.nn.Linear(len(description["weights"]), 1, bias=False)
        with torch.no_grad():
            layer.weight[:] = torch.tensor([description["weights"]])
        network = torch.jit.script(torch.nn.Sequential(layer))
    else:

        class Recurrent(torch.nn.Module):
            def __init__(self) -> None:
                super().__init__()
                self.lstm = torch.nn.LSTM(2, 3, 1, batch_first=True)
                self.out = torch.nn.Linear(3, 1)

            def forward(
                self, x: torch.Tensor, state: tuple[torch.Tensor, torch.Tensor]
            ) -> tuple[torch.Tensor, tuple[torch.Tensor, torch.Tensor]]:
                y, state = self.lstm(x, state)
                return self.out(y[:, -1]), state

        torch.manual_seed(description["seed"])
        module = Recurrent()
        with torch.no_grad():
            module.out.bias[:] = description["bias"]
        network = torch.jit.script(module)
    stream = io.BytesIO()
    torch.jit.save(network, stream)
    return stream.getvalue()


def run(job: dict, arrays: dict) -> tuple[dict, dict]:
    enable(job["root"])
    for name in job["networks"]:
        Path(name).write_bytes(arrays.pop(f"file:{name}").tobytes())
    module = Path("emitted_cfg.py").resolve()
    module.write_text(job["text"], encoding="utf-8")
    names = job["joints"]
    inputs = {key: torch.tensor(value, dtype=torch.float32) for key, value in arrays.items()}
    n_step, n_env, _ = inputs["q"].shape
    torque = np.full((n_step, n_env, len(names)), np.nan)
    fresh, again = torque.copy(), torque.copy()
    joints: dict[str, dict] = {}
    for key, cfg in load(module)[job["constant"]].items():
        ids, mine, build = builder(cfg, names, n_env, float(job["usd"]))

        def steps(actuator, out, ids=ids):
            for k in range(n_step):
                part = {name: value[k][:, ids].clone() for name, value in inputs.items()}
                commands = (part["positions"], part["velocities"], part["efforts"])
                action = dict(zip(PARTS.values(), commands, strict=True))
                out[k][:, ids] = step(actuator, action, part["q"], part["qd"])

        torch.manual_seed(job["seed"])
        actuator = build()
        # The nets of Isaac Lab take indices, the others None too.
        actuator.reset(list(range(n_env)))
        steps(actuator, torque)
        # The first environment begins anew, the others go on.
        actuator.reset([0])
        steps(actuator, again)
        steps(build(), fresh)
        for joint, found in numbers(actuator, mine, key).items():
            assert joint not in joints, f"{joint} is in two groups"
            joints[joint] = {
                **found,
                "bases": [base.__name__ for base in type(actuator).__mro__],
                "lags": [getattr(cfg, "min_delay", None), getattr(cfg, "max_delay", None)],
            }
    return {"joints": joints}, {"torque": torque, "fresh": fresh, "again": again}


def live(job: dict) -> dict:
    """What `actspec.isaaclab` gives for a spec, in a Python that has both, and the actuators that it makes."""
    enable(job["root"])
    # Behind the package itself, for its metadata; and what actspec imports.
    sys.path += job["paths"]
    from isaaclab.utils.string import callable_to_string, string_to_callable

    from actspec.isaaclab import actuators
    from actspec.testing import compared

    found = {}
    cfgs = actuators(job["live"])
    beside = compared(job["live"], cfgs)
    for key, cfg in cfgs.items():
        _, mine, build = builder(cfg, job["joints"], 1, float(job["usd"]))
        actuator = build()
        found[key] = {
            "cfg": type(cfg).__name__,
            "joints": mine,
            "compared": [beside.count, beside.wrong()],
            "network_file": getattr(cfg, "network_file", None),
            "by_name": string_to_callable(callable_to_string(cfg.class_type)) is cfg.class_type,
            **{name: getattr(actuator, name)[0].tolist() for name in NUMBERS},
        }
    return found


def main() -> None:
    job = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    with np.load(sys.argv[2]) as found:
        arrays = {key: found[key] for key in found.files}
    if "make" in job:
        said: dict = {}
        out = {name: np.frombuffer(make(what), dtype=np.uint8) for name, what in job["make"].items()}
    elif "live" in job:
        said, out = live(job), {}
    else:
        said, out = run(job, arrays)
    Path(sys.argv[3]).write_text(json.dumps(said), encoding="utf-8")
    np.savez(sys.argv[4], **out)


main()
