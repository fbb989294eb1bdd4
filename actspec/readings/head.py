"""The head that actspec writes over a configuration: which versions, and which physics step, it was compiled for."""

from __future__ import annotations

import re
from collections.abc import Mapping

_HEAD = re.compile(
    r"# Written by actspec \S+ for Isaac Lab (?P<isaaclab>\d+(?:\.\d+)*) on Isaac Sim (?P<isaac_sim>\d+(?:\.\d+)*) ?"
    r"(?:\((?P<backend>PhysX|OVPhysX|Newton)\))?\. "
)
"""Source: `actspec.targets.isaaclab.text`, and without the backend `actspec.targets.randomization`;
`tests/audit/test_head.py` holds them to each other."""

_WRITTEN = "Written by actspec "
_STEP = re.compile(
    r"^# (?:physics_dt (?P<isaaclab>[0-9.e-]+) s$"
    r"|with SimulationCfg\(mujoco=MujocoCfg\(timestep=(?P<mjlab>[0-9.e-]+)\)\))",
    re.MULTILINE,
)
"""Source: `actspec.targets.isaaclab.text` and `actspec.targets.mjlab.text`; held to them as above."""


def written_for(data: bytes) -> Mapping[str, str]:
    """Versions by the names of `actspec.readings.versions.Versions`' fields; empty without such a head.

    Args:
        data: The file.
    """
    found = _HEAD.match(data[:400].decode("utf-8", "replace"))
    return {name: text.lower() for name, text in found.groupdict().items() if text} if found else {}


def step_of(data: bytes) -> tuple[float, int] | None:
    """The physics step [s] that the lags of a configuration count, and the line that says so; None without such a head.

    Args:
        data: The file.
    """
    text = data[:2000].decode("utf-8", "replace")
    found = _STEP.search(text) if _WRITTEN in text[:400] else None
    if found is None:
        return None
    try:
        step = float(found["isaaclab"] or found["mjlab"])
    except ValueError:
        return None
    return (step, text.count("\n", 0, found.start()) + 1) if 0.0 < step < 1.0 else None
