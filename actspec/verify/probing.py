"""Runs a probe: a script of another environment, which gets a job and arrays and writes both."""

from __future__ import annotations

import json
import os
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from actspec.verify.releases import EngineError

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

PROBES = Path(__file__).parent / "probes"
"""Scripts that run in the simulators' environments: they import no module of actspec."""


class ProbeAnswer(NamedTuple):
    """What a probe wrote.

    Attributes:
        said: Its JSON.
        arrays: Its arrays by name.
    """

    said: Any
    arrays: dict[str, NDArray[np.float64]]


def run_probe(
    python: Path | str,
    script: Path,
    job: Any,
    arrays: Mapping[str, Any] | None = None,
    *,
    environment: Mapping[str, str],
    timeout: float,
) -> ProbeAnswer:
    """Run a script: `python SCRIPT in.json in.npz out.json out.npz`, in a new folder.

    The script must write both outputs.

    Args:
        python: The interpreter.
        script: The probe.
        job: Anything that JSON can hold.
        arrays: Input arrays by name.
        environment: Variables beside those of this process.
        timeout: [s].

    Raises: EngineError: the script failed; the end of what it wrote to stderr is in the message.
    """
    import numpy as np

    # MuJoCo and warp leave files where they run: here, and they go with the folder.
    with tempfile.TemporaryDirectory(prefix="actspec-probe-") as name:
        work = Path(name)
        (work / "in.json").write_text(json.dumps(job), encoding="utf-8")
        np.savez(work / "in.npz", **{key: np.asarray(value) for key, value in (arrays or {}).items()})  # type: ignore[arg-type]
        variables = {
            **os.environ,
            # Nothing is drawn: without this an import looks for a display library.
            "MUJOCO_GL": "disabled",
            "PYTHONNOUSERSITE": "1",
            "PYTHONDONTWRITEBYTECODE": "1",
            **environment,
        }
        try:
            done = subprocess.run(
                [str(python), str(script.resolve()), "in.json", "in.npz", "out.json", "out.npz"],
                check=False,
                cwd=work,
                env=variables,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=timeout,
                stdin=subprocess.DEVNULL,
            )
        except subprocess.TimeoutExpired as err:
            raise EngineError(f"{script.name}: not done after {timeout:g} s") from err
        if done.returncode:
            raise EngineError(f"{script.name}: exit {done.returncode}: {done.stderr[-4000:]}")
        with np.load(work / "out.npz") as found:
            out = {key: found[key] for key in found.files}
        return ProbeAnswer(json.loads((work / "out.json").read_text(encoding="utf-8")), out)
