"""Step a written MuJoCo model with its networks: `attached.py JOB.json IN.npz OUT.json OUT.npz`.

It runs in actspec's own environment and attaches the networks by `actspec.runtime`, as a user does; else all is as in
`actspec/simulate/rollout.py`, which lies beside it.

Job, beside that of `rollout`:
    networks: folder that `compile` wrote.
"""

from __future__ import annotations

from typing import Any

import mujoco
from rollout import Rig, held_torques, load_model  # type: ignore[import-not-found]
from standalone import serve  # type: ignore[import-not-found]

from actspec.learn.attach import attach


def answer(job: dict[str, Any], arrays: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Torques of every motion."""
    said: dict[str, Any] = {"version": mujoco.__version__, "module": mujoco.__file__}
    try:
        model = load_model(job["path"], contacts=False)
        with attach(model, job["networks"]):
            rig = Rig(model, job["columns"])
            of = ("command", "q", "qd")
            return said, {
                name: held_torques(rig, *(arrays[f"{name}/{part}"] for part in of)) for name in job["motions"]
            }
    except Exception as err:  # whatever the engine says is the answer
        return {**said, "error": str(err) or repr(err)}, {}


if __name__ == "__main__":
    serve(answer)
