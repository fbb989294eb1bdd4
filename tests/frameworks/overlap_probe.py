"""Run by `Frameworks.run_probe`: Isaac Lab's own loop over actuator groups, on a robot that notes what is written.

The loop is the text of `Articulation._process_actuators_cfg`, the classes are the package's; no simulator is there.

Job:
    root: folder of the real `isaaclab` package.
    joints: joint names; usd: the number that stands for whatever the USD says.
    cases: texts of dicts of actuator cfgs.

Answers: for each case, by joint, the last group's `kp`, `kd`, `effort` and `implicit`, and the solver's `effort`,
`speed`, `armature`, `static`, `sliding` and `viscous`.
"""

from __future__ import annotations

import ast
import json
import sys
import types
from pathlib import Path
from typing import Any

import numpy as np
import torch

sys.path.insert(0, str(Path(__file__).parents[2] / "actspec" / "verify" / "probes"))

from probe_isaaclab import enable

WRITTEN = {
    "effort": "write_joint_effort_limit_to_sim",
    "speed": "write_joint_velocity_limit_to_sim",
    "armature": "write_joint_armature_to_sim",
    "static": "write_joint_friction_coefficient_to_sim",
    "sliding": "write_joint_dynamic_friction_coefficient_to_sim",
    "viscous": "write_joint_viscous_friction_coefficient_to_sim",
}
DEFAULTS = (
    "stiffness",
    "damping",
    "armature",
    "friction_coeff",
    "dynamic_friction_coeff",
    "viscous_friction_coeff",
)


class Robot:
    """What the loop reads and writes of an articulation; of the solver's limits both, as the real writers do."""

    num_instances, num_fixed_tendons, device = 1, 0, "cpu"

    def __init__(self, joints: list[str], actuators: dict[str, Any], usd: float) -> None:
        def wide() -> torch.Tensor:
            return torch.full((1, len(joints)), usd)

        self.cfg = types.SimpleNamespace(actuators=actuators, actuator_value_resolution_debug_print=False)
        self.names, self.num_joints = joints, len(joints)
        self.solver = {name: wide() for name in WRITTEN}
        self._data = types.SimpleNamespace(
            joint_effort_limits=self.solver["effort"],
            joint_vel_limits=self.solver["speed"],
            **{f"default_joint_{name}": wide() for name in DEFAULTS},
        )
        for name, writer in WRITTEN.items():
            setattr(self, writer, self.writer(name))

    def find_joints(self, names: list[str]) -> Any:
        from isaaclab.utils.string import resolve_matching_names

        return resolve_matching_names(names, self.names)

    def writer(self, name: str) -> Any:
        def write(value: Any, joint_ids: Any) -> None:
            self.solver[name][:, joint_ids] = value

        return write

    def write_joint_stiffness_to_sim(self, value: Any, joint_ids: Any) -> None: ...

    def write_joint_damping_to_sim(self, value: Any, joint_ids: Any) -> None: ...


def loop(root: str) -> Any:
    """The package's own function."""
    text = Path(root, "isaaclab", "assets", "articulation", "articulation.py").read_text(encoding="utf-8")
    name = "_process_actuators_cfg"
    (node,) = (one for one in ast.walk(ast.parse(text)) if getattr(one, "name", "") == name)
    from isaaclab.actuators import ImplicitActuator

    silent = types.SimpleNamespace(info=lambda text: None, warn=lambda text: None, warning=lambda text: None)
    names: dict[str, Any] = {
        "torch": torch,
        "ImplicitActuator": ImplicitActuator,
        "logger": silent,
        "omni": types.SimpleNamespace(log=silent),
        "get_version": lambda: ("", "", "5"),
        "get_isaac_sim_version": lambda: types.SimpleNamespace(major=5),
    }
    exec("from __future__ import annotations\n" + ast.unparse(node), names)
    return names[name]


def main() -> None:
    job = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
    enable(job["root"])
    process, said = loop(job["root"]), []
    for text in job["cases"]:
        names: dict[str, Any] = {}
        exec("from isaaclab.actuators import *\nfound = " + text, names)
        robot = Robot(job["joints"], names["found"], job["usd"])
        process(robot)
        by_joint: dict[str, dict[str, Any]] = {}
        for actuator in robot.actuators.values():
            for at, joint in enumerate(actuator.joint_names):
                by_joint[joint] = {
                    "kp": float(actuator.stiffness[0, at]),
                    "kd": float(actuator.damping[0, at]),
                    "model": float(actuator.effort_limit[0, at]),
                    "implicit": actuator.is_implicit_model,
                }
        for at, joint in enumerate(job["joints"]):
            by_joint[joint] |= {name: float(value[0, at]) for name, value in robot.solver.items()}
        said.append(by_joint)
    Path(sys.argv[3]).write_text(json.dumps(said), encoding="utf-8")
    np.savez(sys.argv[4])


main()
