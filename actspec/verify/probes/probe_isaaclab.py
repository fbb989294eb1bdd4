"""Ask the actuator classes of a real Isaac Lab release: `probe_isaaclab.py JOB.json IN.npz OUT.json OUT.npz`.

Standalone: it runs in the frameworks' environment, with `actspec/simulate/standalone.py` beside it, and imports nothing
else of actspec.

Job, beside what `standalone` says:
    root: folder of the real `isaaclab` package.
    module: the file with a dict of actuator cfgs; it is executed.
    joints: all joints of the robot, in its order.

Answers, likewise: `joints`: per joint its group, class and numbers. Torques are those after a reset, NaN where a joint
is in no group.
"""

from __future__ import annotations

import copy
import importlib.util
import sys
import types
from collections.abc import Callable
from functools import partial
from importlib.machinery import SourceFileLoader
from pathlib import Path
from typing import Any

import numpy as np
import torch
from standalone import Body, Driven, follow, serve  # type: ignore[import-not-found]

NUMBERS = (
    "effort_limit",
    "velocity_limit",
    "effort_limit_sim",
    "velocity_limit_sim",
    "stiffness",
    "damping",
    "armature",
    "friction",
    "dynamic_friction",
    "viscous_friction",
)
"""What an actuator holds of each joint."""

USD = (
    "stiffness",
    "damping",
    "armature",
    "friction",
    "dynamic_friction",
    "viscous_friction",
    "effort_limit",
    "velocity_limit",
)
"""What an actuator is given of the robot's USD."""

PARTS = {"position": "joint_positions", "velocity": "joint_velocities", "effort": "joint_efforts"}
"""Command to the part of an action that it is."""


def stand_in(name: str, **content: object) -> types.ModuleType:
    """A module of the simulator, which is not here: Isaac Lab's actuators import it and use nothing of it."""
    module = types.ModuleType(name)
    module.__dict__.update(content)
    sys.modules[name] = module
    return module


def enable(root: str) -> None:
    """Make `import isaaclab` find the real package, on a machine without Isaac Sim."""
    sys.path.insert(0, root)
    settings = types.SimpleNamespace(get=lambda key: "/nucleus")
    stand_in("carb", settings=types.SimpleNamespace(get_settings=lambda: settings))
    omni: Any = stand_in("omni")
    omni.__path__ = []
    omni.client = stand_in("omni.client")
    omni.log = stand_in("omni.log", warn=print, info=print, error=print)
    if importlib.util.find_spec("toml") is None:
        import tomllib

        stand_in("toml", load=lambda path: tomllib.loads(Path(path).read_text(encoding="utf-8")))
    if importlib.util.find_spec("trimesh") is None:
        stand_in("trimesh", Trimesh=object, creation=None)
    if importlib.util.find_spec("pxr") is None:
        stand_in("pxr", Usd=types.SimpleNamespace(Prim=object), UsdGeom=types.SimpleNamespace())


class Source(SourceFileLoader):
    """Executes a file's own text, whatever compiled code lies beside it."""

    def get_code(self, fullname: str) -> types.CodeType:
        """The text, compiled."""
        code: types.CodeType = self.source_to_code(self.get_data(self.path), self.path)
        return code


def load(path: Path) -> dict[str, Any]:
    """Import a module from its file, as a user would; its names."""
    spec = importlib.util.spec_from_file_location(
        "emitted_cfg", path, loader=Source("emitted_cfg", str(path))
    )
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["emitted_cfg"] = module
    spec.loader.exec_module(module)
    return vars(module)


def cfgs_of(names: dict[str, Any]) -> dict[str, Any]:
    """The dict of actuator cfgs among a module's names."""
    for value in names.values():
        if isinstance(value, dict) and value and all(hasattr(v, "joint_names_expr") for v in value.values()):
            return value
    raise ValueError("the module has no dict of actuator cfgs")


def builder(
    cfg: Any, joints: list[str], n_env: int, usd: float
) -> tuple[list[int], list[str], Callable[[], Any]]:
    """Indices and names of the joints that a cfg selects, and what makes its actuator.

    Args:
        cfg: The cfg.
        joints: All joints of the robot.
        n_env: Environments.
        usd: The number that stands for whatever the USD would say.
    """
    from isaaclab.utils.string import resolve_matching_names

    ids, mine = resolve_matching_names(cfg.joint_names_expr, joints)
    given = {name: torch.full((n_env, len(mine)), usd) for name in USD}

    def build() -> Any:
        # The constructor changes the cfg that it gets.
        return cfg.class_type(
            cfg=copy.deepcopy(cfg),
            joint_names=mine,
            joint_ids=slice(None),
            num_envs=n_env,
            device="cpu",
            **{name: value.clone() for name, value in given.items()},
        )

    return ids, mine, build


def step(
    actuator: Any, parts: dict[str, torch.Tensor], q: torch.Tensor, qd: torch.Tensor
) -> np.ndarray[Any, Any]:
    """Torque of one physics step.

    Args:
        actuator: The actuator.
        parts: The action's `joint_positions`, `joint_velocities` and `joint_efforts`.
        q: Positions.
        qd: Speeds.
    """
    from isaaclab.utils.types import ArticulationActions

    actuator.compute(ArticulationActions(**parts), q, qd)
    found: np.ndarray[Any, Any] = actuator.applied_effort.numpy()
    return found


def numbers(actuator: Any, joints: list[str], group: str) -> dict[str, dict[str, Any]]:
    """What an actuator says of each of its joints."""
    return {
        joint: {
            "group": group,
            "class": type(actuator).__name__,
            "implicit": bool(actuator.is_implicit_model),
            **{name: float(getattr(actuator, name)[0, i]) for name in NUMBERS if hasattr(actuator, name)},
        }
        for i, joint in enumerate(joints)
    }


def run(job: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Every motion in every group of the module."""
    columns = job["columns"]
    joints: dict[str, dict[str, Any]] = {}
    out = {name: np.full(arrays[f"{name}/q"].shape, np.nan) for name in job["motions"]}
    for key, cfg in cfgs_of(load(Path(job["module"]))).items():
        for name in job["motions"]:
            command, q, qd = (arrays[f"{name}/{part}"] for part in ("command", "q", "qd"))
            _, mine, build = builder(cfg, job["joints"], q.shape[1], 0.0)
            there = [i for i, joint in enumerate(mine) if joint in columns]
            if not there:
                # Nobody asks; of a network, which is a program in TorchScript, nothing is loaded then.
                break
            taken = [columns.index(mine[i]) for i in there]
            # Lags that are drawn are the same each time.
            torch.manual_seed(0)
            actuator = build()
            # The nets of Isaac Lab take indices, the others None too.
            actuator.reset(list(range(q.shape[1])))
            kinds = [job["commands"][column] for column in taken]
            for k in range(len(q)):
                now = (part[k][:, taken] for part in (command, q, qd))
                out[name][k][:, taken] = torques(actuator, there, kinds, len(mine), *now)
            twice = set(mine) & set(joints) if name == job["motions"][0] else set()
            if twice:
                raise ValueError(f"{sorted(twice)[0]} is in two groups")
            if name == job["motions"][0]:
                joints.update(numbers(actuator, mine, key))
    return {"joints": joints}, out


def respond(job: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Bodies of one joint each, moved by the classes' torques."""
    columns, (n_step, n_course, n_joint) = job["columns"], arrays["command"].shape
    out = {}
    for parts in job["parts"]:
        out[f"q{parts}"] = np.full((n_step + 1, n_course, n_joint), np.nan)
        out[f"torque{parts}"] = np.full((n_step, n_course, n_joint), np.nan)
        for key, cfg in cfgs_of(load(Path(job["module"]))).items():
            _, mine, _ = builder(cfg, job["joints"], n_course, 0.0)
            there = [i for i, joint in enumerate(mine) if joint in columns]
            taken = [columns.index(mine[i]) for i in there]
            if not taken:
                continue
            _, _, build = builder(divided(cfg, job["lags"][taken[0]], parts), job["joints"], n_course, 0.0)
            actuator = build()
            actuator.reset(list(range(n_course)))
            held = numbers(actuator, mine, key)
            kinds = [job["commands"][column] for column in taken]
            body = Body(
                arrays["inertia"][taken] + [held[mine[i]]["armature"] for i in there],
                arrays["coulomb"][taken],
                arrays["viscous"][taken],
                job["step"] / parts,
                arrays["q"][:, taken],
                arrays["qd"][:, taken],
            )
            drive = partial(torques, actuator, there, kinds, len(mine))
            q, torque = follow(Driven(drive, body), arrays["command"][:, :, taken], parts)
            out[f"q{parts}"][:, :, taken], out[f"torque{parts}"][:, :, taken] = q, torque
    return {}, out


def torques(
    actuator: Any, there: list[int], kinds: list[str], width: int, command: Any, q: Any, qd: Any
) -> np.ndarray[Any, Any]:
    """Torques of one physics step at some joints of an actuator; the others are at 0.

    Args:
        actuator: The actuator.
        there: Its joints that are asked about, the columns of the arrays.
        kinds: What each of them is commanded by.
        width: How many joints it has.
        command: Commands, shape (n_env, n_column).
        q: Positions, likewise.
        qd: Speeds, likewise.
    """
    parts = {name: torch.zeros(len(q), width) for name in PARTS.values()}
    at, speed = (torch.zeros(len(q), width) for _ in range(2))
    command, at[:, there], speed[:, there] = (
        torch.tensor(value, dtype=torch.float32) for value in (command, q, qd)
    )
    for column, (i, kind) in enumerate(zip(there, kinds, strict=True)):
        parts[PARTS[kind]][:, i] = command[:, column]
    return step(actuator, parts, at, speed)[:, there].astype(float)


def divided(cfg: Any, lag: int, parts: int) -> Any:
    """A cfg for steps of a part of the length: the delay nearest to a lag, and the filter, stay as long in seconds."""
    mine = copy.deepcopy(cfg)
    if hasattr(mine, "min_delay"):
        mine.min_delay = mine.max_delay = min(max(lag, mine.min_delay), mine.max_delay) * parts
    if hasattr(mine, "physics_dt"):
        mine.physics_dt /= parts
    return mine


def answer(job: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Motions or responses; what the package refuses is an error."""
    enable(job["root"])
    return (respond if "parts" in job else run)(job, arrays)


if __name__ == "__main__":
    serve(answer)
