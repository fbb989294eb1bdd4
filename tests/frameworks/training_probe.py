"""Run the train.py of an ablation in the frameworks' environment, and look at what it trains.

The job names the script, its arguments and the folder of what training imports; the answer has each variant's
compiled robot, what the trained environment was like after its first reset, and the exit code.
"""

from __future__ import annotations

import json
import runpy
import sys
from pathlib import Path
from typing import Any

import numpy as np
import warp

# Kernels run for seconds, and take minutes to compile.
warp.config.optimization_level = 0

ACTUATOR = ("gainprm", "biasprm", "forcerange", "dyntype", "dynprm", "actearly")
DOF = ("armature", "damping", "frictionloss")


def main(job_path: str, _: str, said_path: str, out_path: str) -> None:
    """Compile the robot of every variant, then train one."""
    job = json.loads(Path(job_path).read_text(encoding="utf-8"))
    sys.path.append(job["packages"])
    said: dict[str, Any] = {"classes": {}, "events": {}}
    out: dict[str, Any] = {}
    script = runpy.run_path(job["script"])
    from mjlab.entity import Entity
    from mjlab.tasks.registry import load_env_cfg

    for variant in script["VARIANTS"]:
        cfg = script["environment"](load_env_cfg(script["TASK"]), variant)
        robot = cfg.scene.entities["robot"]
        said["classes"][variant] = sorted({type(a).__name__ for a in robot.articulation.actuators})
        said["events"][variant] = list(cfg.events)
        said["rates"] = [cfg.sim.mujoco.timestep, cfg.decimation]
        entity = Entity(robot)
        model = entity.compile()
        names = [model.joint(int(i)).name for i in model.actuator_trnid[:, 0]]
        order = np.argsort(names)
        dofs = [int(model.joint(names[k]).dofadr[0]) for k in order]
        out.update({f"{variant}.{key}": getattr(model, f"actuator_{key}")[order] for key in ACTUATOR})
        out.update({f"{variant}.{key}": getattr(model, f"dof_{key}")[dofs] for key in DOF})
    _train(job, said, out)
    Path(said_path).write_text(json.dumps(said), encoding="utf-8")
    np.savez(out_path, **out)


def _train(job: dict[str, Any], said: dict[str, Any], out: dict[str, Any]) -> None:
    from rsl_rl.runners import OnPolicyRunner

    learn = OnPolicyRunner.learn

    def watched(self: Any, *given: Any, **named: Any) -> Any:
        env = self.env.unwrapped
        out["act"] = env.sim.data.act.cpu().numpy().copy()
        model = env.sim.mj_model
        joints = [int(model.actuator_trnid[k, 0]) for k in range(model.nu) if model.actuator_actadr[k] >= 0]
        out["q"] = env.sim.data.qpos.cpu().numpy()[:, [int(model.jnt_qposadr[j]) for j in joints]]
        return learn(self, *given, **named)

    OnPolicyRunner.learn = watched
    sys.argv = [job["script"], *job["arguments"]]
    try:
        runpy.run_path(job["script"], run_name="__main__")
        said["code"] = 0
    except SystemExit as err:
        said["code"] = err.code


if __name__ == "__main__":
    main(*sys.argv[1:])
