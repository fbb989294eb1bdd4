"""Run emitted `domain_randomize` functions on real MJX models; see `Frameworks.run_probe`.

Job:
    mujoco, mjx: folders with another MuJoCo and its MJX; "": the environment's own.
    runs: name to its text, model (MJCF), impl (jax, warp, or cpp, which does not step),
        envs, seed, whether MJX steps it, and the joints that q and qd are the columns of.
Arrays: NAME.q, NAME.qd (n_env, n_joint), NAME.ctrl (n_env, n_actuator).

Answers of each run: the fields that in_axes batches, those that were replaced, or its error; arrays of every
field that a function may draw (n_env, ...), `force` and `qvel` of the batched step in MJX, and `own_force` and
`own_qvel` of the same step of MuJoCo with the drawn numbers.
"""

from __future__ import annotations

import json
import os
import runpy
import sys
from pathlib import Path
from typing import Any

import numpy as np

JOB = json.loads(Path(sys.argv[1]).read_text(encoding="utf-8"))
if JOB["mujoco"]:
    sys.path.insert(0, JOB["mujoco"])
os.environ["JAX_PLATFORMS"] = "cpu"
# Most of the time goes into compiling a step that runs once: without optimisation, and kept for the next session.
os.environ["XLA_FLAGS"] = "--xla_backend_optimization_level=0 --xla_llvm_disable_expensive_passes=true"
os.environ["JAX_COMPILATION_CACHE_DIR"] = str(Path(os.environ["WARP_CACHE_PATH"]).with_name("jax"))

import mujoco  # noqa: E402
import warp  # noqa: E402

# Kernels too.
warp.config.optimization_level = 0

if JOB["mjx"]:
    mujoco.__path__.insert(0, str(Path(JOB["mjx"]) / "mujoco"))

import jax  # noqa: E402
from mujoco import mjx  # noqa: E402

FIELDS = (
    "actuator_gainprm",
    "actuator_biasprm",
    "actuator_forcerange",
    "dof_armature",
    "dof_frictionloss",
    "dof_damping",
    "jnt_actfrcrange",
)


def main() -> None:
    """Run every job."""
    with np.load(sys.argv[2]) as found:
        arrays = {key: found[key] for key in found.files}
    said: dict[str, Any] = {}
    out: dict[str, np.ndarray] = {}
    for name, job in JOB["runs"].items():
        state = [arrays[f"{name}.{key}"] for key in ("q", "qd", "ctrl")]
        try:
            said[name], answer = run(name, job, *state)
        except Exception as err:
            said[name], answer = {"error": f"{type(err).__name__}: {err}"}, {}
        out.update({f"{name}.{key}": value for key, value in answer.items()})
    said["versions"] = [mujoco.__version__, jax.__version__]
    Path(sys.argv[3]).write_text(json.dumps(said), encoding="utf-8")
    np.savez(sys.argv[4], **out)  # type: ignore[arg-type]  # numpy's stub takes them for allow_pickle


def run(
    name: str, job: dict[str, Any], q: np.ndarray, qd: np.ndarray, ctrl: np.ndarray
) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """One function on its model."""
    path = Path(f"{name}.py").resolve()
    path.write_text(job["text"], encoding="utf-8")
    domain_randomize = runpy.run_path(str(path))["domain_randomize"]
    host = mujoco.MjModel.from_xml_string(job["model"])
    model = mjx.put_model(host, impl=job["impl"])
    batch, axes = domain_randomize(model, jax.random.split(jax.random.PRNGKey(job["seed"]), job["envs"]))
    names = [key for key in sorted(vars(batch)) if isinstance(getattr(batch, key), jax.Array)]
    batched = [key for key in names if getattr(axes, key) is not None]
    replaced = [key for key in names if getattr(batch, key) is not getattr(model, key)]
    drawn = {key: np.asarray(getattr(batch, key)) for key in batched}
    joints = [host.joint(joint) for joint in job["joints"]]
    qpos = np.tile(host.qpos0, (job["envs"], 1))
    qvel = np.zeros((job["envs"], host.nv))
    qpos[:, [int(joint.qposadr[0]) for joint in joints]] = q
    qvel[:, [int(joint.dofadr[0]) for joint in joints]] = qd
    out = {
        key: drawn.get(key, np.broadcast_to(getattr(host, key), (job["envs"], *getattr(host, key).shape)))
        for key in FIELDS
    }
    if job["step"]:
        out |= step(job["impl"], host, batch, axes, {"qpos": qpos, "qvel": qvel, "ctrl": ctrl})
    out |= own(host, drawn, qpos, qvel, ctrl)
    return {
        "batched": batched,
        "replaced": replaced,
        "leaves": len(jax.tree_util.tree_leaves(axes)),
        "actuators": [host.actuator(i).name for i in range(host.nu)],
        "dofs": [int(joint.dofadr[0]) for joint in joints],
        "joints": [int(joint.id) for joint in joints],
    }, out


def step(impl: str, host: Any, batch: Any, axes: Any, state: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """A step of all environments, mapped as Playground's wrapper does."""
    data = mjx.make_data(host, impl=impl)
    given = {key: jax.numpy.asarray(value, dtype=jax.numpy.float32) for key, value in state.items()}
    datas = jax.vmap(lambda part: data.replace(**part))(given)
    after = jax.jit(jax.vmap(mjx.step, in_axes=(axes, 0)))(batch, datas)
    return {"force": np.asarray(after.actuator_force), "qvel": np.asarray(after.qvel)}


def own(
    host: Any, drawn: dict[str, np.ndarray], qpos: np.ndarray, qvel: np.ndarray, ctrl: np.ndarray
) -> dict[str, np.ndarray]:
    """The same step of MuJoCo itself, one environment after the other."""
    data = mujoco.MjData(host)
    force, after = np.empty((len(qpos), host.nu)), np.empty((len(qpos), host.nv))
    for env in range(len(qpos)):
        for key, values in drawn.items():
            getattr(host, key)[:] = values[env]
        mujoco.mj_resetData(host, data)
        data.qpos[:], data.qvel[:], data.ctrl[:] = qpos[env], qvel[env], ctrl[env]
        mujoco.mj_step(host, data)
        force[env], after[env] = data.actuator_force, data.qvel
    return {"own_force": force, "own_qvel": after}


main()
