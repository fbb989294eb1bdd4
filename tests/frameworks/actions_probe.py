"""Run by `Frameworks.run_probe`: the real action terms of Isaac Lab and mjlab on a robot that notes its commands.

Job:
    framework: `isaaclab` or `mjlab`.
    root: folder of the real `isaaclab` package; "" for mjlab.
    joints: joint names; pose, now: their default and present positions; low, high: their ranges [rad].
    terms: class and arguments of each term.
    actions: what each is given, (action,), cut to the joints that it has.

Arrays: for each term `position_N`, `velocity_N` and `effort_N`, a command a joint; nan: it gives none.
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


class Robot:
    """Joints, and what they are told."""

    def __init__(self, job: dict[str, Any], match: Any) -> None:
        self.joint_names, self.num_joints, self.match = job["joints"], len(job["joints"]), match
        ranges = torch.tensor([job["low"], job["high"]]).T[None]
        self.data = types.SimpleNamespace(
            default_joint_pos=torch.tensor([job["pose"]]),
            default_joint_vel=torch.zeros(1, self.num_joints),
            joint_pos=torch.tensor([job["now"]]),
            soft_joint_pos_limits=ranges,
            encoder_bias=torch.zeros(1, self.num_joints),
        )
        self.told: dict[str, np.ndarray] = {}

    def find_joints(self, names: Any, preserve_order: bool = False) -> tuple[list[int], list[str]]:
        found: tuple[list[int], list[str]] = self.match(names, self.joint_names, preserve_order)
        return found

    def find_joints_by_actuator_names(self, names: Any) -> tuple[list[int], list[str]]:
        return self.find_joints(names)

    def __getattr__(self, name: str) -> Any:
        kind = name.removeprefix("set_joint_").removesuffix("_target")

        def note(command: torch.Tensor, joint_ids: Any) -> None:
            row = np.full(self.num_joints, np.nan)
            row[joint_ids] = command[0].numpy()
            self.told[kind] = row

        return note


def isaaclab(root: str) -> tuple[Any, Any]:
    """Its configurations of actions, and how it matches names."""
    sys.meta_path.append(Finder())
    sys.path.insert(0, root)
    package("isaaclab", f"{root}/isaaclab")
    for part in ("envs", "envs.mdp", "envs.mdp.actions", "assets", "sensors", "sim", "scene", "terrains", "managers",
                 "controllers", "markers", "envs.utils", "ui", "ui.widgets", "devices"):  # fmt: skip
        package(f"isaaclab.{part}", f"{root}/isaaclab/{part.replace('.', '/')}").__class__ = Anything
    # No stand-in: its modules are looked for in the folder.
    package("isaaclab.envs.mdp.actions", f"{root}/isaaclab/envs/mdp/actions")
    manager = importlib.import_module("isaaclab.managers.action_manager")
    terms = importlib.import_module("isaaclab.managers.manager_term_cfg")
    managers = sys.modules["isaaclab.managers"]
    managers.action_manager = manager
    managers.ActionTerm, managers.ActionTermCfg = manager.ActionTerm, terms.ActionTermCfg
    names = importlib.import_module("isaaclab.utils.string")
    return importlib.import_module("isaaclab.envs.mdp.actions.actions_cfg"), names.resolve_matching_names


def main() -> None:
    job = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    ours = job["framework"] == "isaaclab"
    if ours:
        module, match = isaaclab(job["root"])
    else:
        from mjlab.utils.lab_api.string import resolve_matching_names as match

        module = importlib.import_module("mjlab.envs.mdp.actions")
    arrays = {}
    for at, (cls, arguments) in enumerate(job["terms"]):
        robot = Robot(job, match)
        env = types.SimpleNamespace(scene={"robot": robot}, num_envs=1, device="cpu")
        arguments = {
            key: value for key, value in arguments.items() if key not in ("asset_name", "entity_name")
        }
        cfg = getattr(module, cls)(**{"asset_name" if ours else "entity_name": "robot"}, **arguments)
        term = cfg.class_type(cfg, env) if ours else cfg.build(env)
        term.reset()
        term.process_actions(torch.tensor([job["actions"][: term.action_dim]]))
        term.apply_actions()
        for kind in ("position", "velocity", "effort"):
            arrays[f"{kind}_{at}"] = robot.told.get(kind, np.full(len(job["joints"]), np.nan))
    Path(sys.argv[3]).write_text("{}", encoding="utf-8")
    np.savez(sys.argv[4], **arrays)


main()
