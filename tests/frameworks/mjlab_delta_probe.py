"""A real environment of mjlab behind a delta action; see `Frameworks.run_probe`.

The job: manifest, model, actions (n_step, n_env, n_joint). Arrays: for each step what the delta action is shown
(`state`), qpos and qvel of the engine before it, and its controls.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np


def main(job_path: str, arrays_path: str, said_path: str, out_path: str) -> None:
    """Run it."""
    job = json.loads(Path(job_path).read_text(encoding="utf-8"))
    sys.path.extend(job["paths"])
    import mujoco
    import torch
    from mjlab.actuator import BuiltinPositionActuatorCfg
    from mjlab.entity import EntityArticulationInfoCfg, EntityCfg
    from mjlab.envs import ManagerBasedRlEnv, ManagerBasedRlEnvCfg, mdp
    from mjlab.envs.mdp.actions import JointPositionActionCfg
    from mjlab.managers.observation_manager import ObservationGroupCfg, ObservationTermCfg
    from mjlab.scene import SceneCfg

    from actspec.mjlab import delta_state, recorder
    from actspec.runtime import delta_action

    drive = BuiltinPositionActuatorCfg(target_names_expr=("hip", "arm"), stiffness=20.0, damping=0.5)
    robot = EntityCfg(
        spec_fn=lambda: mujoco.MjSpec.from_string(job["model"]),
        articulation=EntityArticulationInfoCfg(actuators=(drive,)),
    )
    seen = {"policy": ObservationGroupCfg(terms={"q": ObservationTermCfg(func=mdp.joint_pos_rel)})}
    env = ManagerBasedRlEnv(
        ManagerBasedRlEnvCfg(
            decimation=2,
            scene=SceneCfg(num_envs=2, entities={"robot": robot}),
            actions={
                "joint_pos": JointPositionActionCfg(entity_name="robot", actuator_names=(".*",), scale=0.25)
            },
            observations=seen,
            episode_length_s=10.0,
        ),
        device="cpu",
    )
    env.reset()
    delta = delta_action(job["manifest"])
    state = delta_state(env, delta)
    joints = env.action_manager.get_term("joint_pos").target_names
    wrapped = delta.wrap(env, state=state, joints=joints, action_scale=0.25, default_position=0.0)
    log = recorder(env, environment=1)
    log.add()
    out: dict[str, list[np.ndarray]] = {"state": [], "qpos": [], "qvel": [], "ctrl": []}
    for action in np.array(job["actions"]):
        out["state"].append(state().numpy())
        out["qpos"].append(env.sim.data.qpos.numpy().copy())
        out["qvel"].append(env.sim.data.qvel.numpy().copy())
        wrapped.step(torch.tensor(action, dtype=torch.float32))
        out["ctrl"].append(env.sim.data.ctrl.numpy().copy())
        log.add()
    log.save(job["log"])
    said = {"measured": list(delta.measured), "joints": list(joints), "envs": wrapped.num_envs}
    Path(said_path).write_text(json.dumps(said), encoding="utf-8")
    np.savez(out_path, **{name: np.array(values) for name, values in out.items()})


if __name__ == "__main__":
    main(*sys.argv[1:])
