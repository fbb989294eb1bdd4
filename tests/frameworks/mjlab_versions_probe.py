"""Run mjlab_probe.py in another release of mjlab; see `Frameworks.run_probe`.

Job: mjlab: the folder with that release; probe: path of mjlab_probe.py; jobs: what it is asked.
"""

from __future__ import annotations

import json
import runpy
import sys
from pathlib import Path


def main(job_path: str) -> None:
    """Hand the jobs on."""
    job = json.loads(Path(job_path).read_text(encoding="utf-8"))
    sys.path.insert(0, job["mjlab"])
    from mujoco_warp import Option

    # A switch of the solver's line search that mjlab sets before 1.5 and that MuJoCo Warp 3.9 took away.
    for name in ("ls_parallel", "ls_parallel_min_step"):
        setattr(Option, name, None)
    Path(job_path).write_text(json.dumps(job["jobs"]), encoding="utf-8")
    module = runpy.run_path(job["probe"])
    import mjlab

    assert mjlab.__file__.startswith(job["mjlab"]), mjlab.__file__
    module["main"](*sys.argv[1:])


main(sys.argv[1])
