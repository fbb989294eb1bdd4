"""Run by `Frameworks.run_probe`: real Isaac Lab event terms on a minimal articulation, without a simulator.

The terms, their configs and `configclass` are Isaac Lab's own; the simulator's modules are stand-ins that nothing
here calls, and the articulation holds the tensors that the terms read and write.

Job:
    root: folder of the real `isaaclab` package.
    events: the randomisation target's module.
    isaac_sim: version that the terms are told, e.g. `5.1.0`.
    joints: joint names; envs: number of environments; groups: joint indices of each explicit actuator.
    defaults: name of a tensor to its number a joint.
    partial: environments whose episode ends after the first draw.

Answers: terms; arrays (env, joint) `first_*` and `second_*`: stiffness, damping, friction, dynamic, viscous, armature.
"""

from __future__ import annotations

import importlib
import json
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
import torch

sys.path.insert(0, str(Path(__file__).parent))

from isaaclab_stand_ins import Anything, Finder, package


class Articulation:
    """The tensors and writers that the terms use."""

    def __init__(self, job: dict[str, Any], explicit: type) -> None:
        self.device = "cpu"
        envs = job["envs"]

        def wide(name: str) -> torch.Tensor:
            return torch.tensor(job["defaults"][name]).repeat(envs, 1)

        self.now = {
            name: wide(name)
            for name in ("stiffness", "damping", "friction", "dynamic", "viscous", "armature")
        }
        self.data = types.SimpleNamespace(
            default_joint_stiffness=wide("stiffness"),
            default_joint_damping=wide("damping"),
            default_joint_friction_coeff=wide("friction"),
            default_joint_dynamic_friction_coeff=wide("dynamic"),
            default_joint_viscous_friction_coeff=wide("viscous"),
            default_joint_armature=wide("armature"),
        )
        self.joint_names, self.num_joints = job["joints"], len(job["joints"])
        self.actuators = {
            f"group_{index}": explicit(wide("stiffness")[:, ids], wide("damping")[:, ids], torch.tensor(ids))
            for index, ids in enumerate(job["groups"])
        }

    def find_joints(self, names: Any, preserve_order: bool = False) -> tuple[list[int], list[str]]:
        from isaaclab.utils.string import resolve_matching_names

        return resolve_matching_names(names, self.joint_names, preserve_order)

    def write_joint_friction_coefficient_to_sim(
        self, joint_friction_coeff: Any, joint_dynamic_friction_coeff: Any = None,
        joint_viscous_friction_coeff: Any = None, joint_ids: Any = None, env_ids: Any = None,
    ) -> None:  # fmt: skip
        self.write("friction", joint_friction_coeff, joint_ids, env_ids)
        if joint_dynamic_friction_coeff is not None:
            self.write("dynamic", joint_dynamic_friction_coeff, joint_ids, env_ids)
            self.write("viscous", joint_viscous_friction_coeff, joint_ids, env_ids)

    def write_joint_armature_to_sim(self, armature: Any, joint_ids: Any = None, env_ids: Any = None) -> None:
        self.write("armature", armature, joint_ids, env_ids)

    def write(self, name: str, value: torch.Tensor, joints: Any, envs: torch.Tensor) -> None:
        columns = torch.arange(self.num_joints) if isinstance(joints, slice) else joints
        self.now[name][envs[:, None], columns] = value

    def numbers(self) -> dict[str, np.ndarray]:
        for actuator in self.actuators.values():
            self.now["stiffness"][:, actuator.joint_indices] = actuator.stiffness
            self.now["damping"][:, actuator.joint_indices] = actuator.damping
        return {name: value.numpy().copy() for name, value in self.now.items()}


class Explicit:
    """An explicit actuator's tensors."""

    def __init__(self, stiffness: torch.Tensor, damping: torch.Tensor, joint_indices: torch.Tensor) -> None:
        self.stiffness, self.damping, self.joint_indices = stiffness, damping, joint_indices


class Scene(dict[str, Any]):
    num_envs = 0


def main() -> None:
    job = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    root = job["root"]
    sys.meta_path.append(Finder())
    sys.path.insert(0, root)
    package("isaaclab", f"{root}/isaaclab")
    for part in ("envs", "envs.mdp", "assets", "sensors", "sim", "scene", "terrains"):
        package(f"isaaclab.{part}", f"{root}/isaaclab/{part.replace('.', '/')}").__class__ = Anything
    events = importlib.import_module("isaaclab.envs.mdp.events")
    from packaging.version import Version

    told = Version(job["isaac_sim"])
    if hasattr(events, "get_isaac_sim_version"):  # 2.3
        events.get_isaac_sim_version = lambda: told
    mdp = sys.modules["isaaclab.envs.mdp"]
    for name in ("randomize_actuator_gains", "randomize_joint_parameters"):
        setattr(mdp, name, getattr(events, name))
    sys.modules["isaaclab.envs"].mdp = mdp

    torch.manual_seed(6)
    module: dict[str, Any] = {"__name__": "events_cfg"}
    sys.modules["events_cfg"] = types.ModuleType("events_cfg")
    exec(compile(job["events"], "events.py", "exec"), module)
    cfg = module["EventCfg"]()
    robot = Articulation(job, Explicit)
    scene = Scene(robot=robot)
    scene.num_envs = job["envs"]
    env = types.SimpleNamespace(scene=scene, num_envs=job["envs"], device="cpu", sim=None)

    terms = {}
    for name, term in cfg.__dict__.items():
        if not hasattr(term, "params"):
            continue
        for value in term.params.values():
            if hasattr(value, "resolve"):
                value.resolve(scene)
        # 2.2 has functions, 2.3 classes, which the event manager makes.
        terms[name] = (term, term.func(cfg=term, env=env) if isinstance(term.func, type) else term.func)
    arrays: dict[str, Any] = {}
    for when, envs in (("first", list(range(job["envs"]))), ("second", job["partial"])):
        for term, call in terms.values():
            if when == "first" or term.mode == "reset":
                call(env, torch.tensor(envs), **term.params)
        arrays |= {f"{when}_{key}": value for key, value in robot.numbers().items()}
    with open(sys.argv[3], "w", encoding="utf-8") as stream:
        json.dump({"terms": {name: term.mode for name, (term, _) in terms.items()}}, stream)
    np.savez(sys.argv[4], **arrays)


main()
