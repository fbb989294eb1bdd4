"""A probe in a fork answers as it does in a process of its own, and leaves nothing to the next one."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import pytest

from actspec.verify import environments
from actspec.verify.environments import EngineError
from tests.frameworks.prepare import Frameworks

SCRIPT = """import json, os, sys
import numpy as np
import torch

seen = getattr(torch, "mark", None)
torch.mark = 1
job = json.load(open(sys.argv[1]))
print("said", file=sys.stderr)
if job["exit"]:
    sys.exit(job["exit"])
assert job["exit"] == 0, "no number"
found = {"seen": seen, "name": __name__, "argv": sys.argv[1:], "path": sys.path[0], "folder": os.listdir("."),
         "gl": os.environ["MUJOCO_GL"], "mine": os.environ.get("MINE"), "main": sys.argv[0]}
json.dump(found, open(sys.argv[3], "w"))
np.savez(sys.argv[4], x=torch.tensor(np.load(sys.argv[2])["x"]) * 2)
"""


def _asked(frameworks: Frameworks, script: Path) -> tuple[Any, list[float]]:
    said, arrays = frameworks.run_probe(script, {"exit": 0}, {"x": [1.0, 2.5]})
    said["folder"].sort()
    return said, arrays["x"].tolist()


@pytest.mark.slow
def test_a_fork_is_a_process(frameworks: Frameworks, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Arguments, folder, paths, variables and answer are the same, and what a probe does to a module ends with it."""
    script = tmp_path / "isaaclab_probe.py"
    script.write_text(SCRIPT)
    assert environments.subprocess is not subprocess
    monkeypatch.setenv("MINE", "a")
    forked = _asked(frameworks, script)
    assert forked[0]["mine"] == "a"
    monkeypatch.setenv("MINE", "b")
    again = _asked(frameworks, script)
    assert (again[0]["seen"], again[0]["mine"]) == (None, "b")
    monkeypatch.setattr(environments, "subprocess", subprocess)
    assert _asked(frameworks, script) == again
    assert again[1] == [2.0, 5.0]


@pytest.mark.slow
@pytest.mark.parametrize(
    "status, said", [(3, "exit 3: said"), ("stop", "exit 1: said\nstop"), (None, "no number")]
)
def test_a_probe_that_fails(frameworks: Frameworks, tmp_path: Path, status: object, said: str) -> None:
    """Its exit status and what it said arrive."""
    script = tmp_path / "isaaclab_probe.py"
    script.write_text(SCRIPT)
    with pytest.raises(EngineError) as caught:
        frameworks.run_probe(script, {"exit": status}, {"x": [1.0]})
    assert said in str(caught.value)
