"""Which releases the files are meant for: named, or in the head that actspec writes over a configuration."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

from actspec.readings.artifact import Artifact
from actspec.simulators import Release, before, release, text_of
from actspec.simulators.isaaclab import (
    FrictionUnit,
    IsaacLabRelease,
    clips_at_solvers,
    friction_unit,
    row_of,
)
from actspec.simulators.mjlab import mujoco_taken_by

_HEAD = re.compile(
    r"# Written by actspec \S+ for Isaac Lab (?P<isaaclab>\d+(?:\.\d+)*) on Isaac Sim (?P<isaac_sim>\d+(?:\.\d+)*) ?"
    r"(?:\((?P<backend>PhysX|OVPhysX|Newton)\))?\. "
)
"""Source: `actspec.targets.isaaclab.text`, and without the backend `actspec.targets.randomization`;
`tests/readings/test_versions.py` holds them to each other."""

_WRITTEN = "Written by actspec "
_STEP = re.compile(
    r"^# (?:physics_dt (?P<isaaclab>[0-9.e-]+) s$"
    r"|with SimulationCfg\(mujoco=MujocoCfg\(timestep=(?P<mjlab>[0-9.e-]+)\)\))",
    re.MULTILINE,
)
"""Source: `actspec.targets.isaaclab.text` and `actspec.targets.mjlab.text`; held to them as above."""


@dataclass(frozen=True, slots=True)
class Versions:
    """Which versions the files are meant for; None: not said, and nothing is assumed.

    Attributes:
        mujoco: `3.12`.
        isaaclab: `2.3`.
        isaac_sim: `5.1`.
        backend: Isaac Lab 3's physics: `physx`, `ovphysx` or `newton`.
        mjlab: `1.6`.
    """

    mujoco: str | None = None
    isaaclab: str | None = None
    isaac_sim: str | None = None
    backend: str | None = None
    mjlab: str | None = None


def meant_for(versions: Versions, artifact: Artifact) -> Versions:
    """What an artifact is meant for: as was said, else as actspec wrote it for.

    Args:
        versions: As was said for all files; one of Isaac Lab's speaks for all of it.
        artifact: The artifact.
    """
    config = artifact.config
    said = versions.isaaclab or versions.isaac_sim or versions.backend
    return versions if said or config is None else replace(versions, **config.written_for)


@dataclass(frozen=True, slots=True)
class Meant:
    """A named release.

    Attributes:
        release: Its numbers, as many as were named.
        text: `MuJoCo 3.6`, for a message.
    """

    release: Release
    text: str

    def before(self, other: Release) -> bool:
        """Whether it is older; `3.1` may be any patch release of 3.1, and is not older than 3.1.6."""
        return before(self.release, other)


def mujoco_of(versions: Versions) -> Meant | None:
    """The MuJoCo that the files are meant for: named, or the one that the named mjlab takes."""
    if versions.mujoco is not None:
        return Meant(release(versions.mujoco), f"MuJoCo {versions.mujoco}")
    if versions.mjlab is None:
        return None
    taken = mujoco_taken_by(release(versions.mjlab))
    if taken is None:
        return None
    return Meant(taken, f"MuJoCo {text_of(taken)} (which mjlab {versions.mjlab} takes)")


def isaaclab_row(versions: Versions) -> IsaacLabRelease | None:
    """What the Isaac Lab does that the files are meant for; None: none is named."""
    return row_of(_release(versions.isaaclab))


def is_native(versions: Versions) -> bool:
    """Whether the files are meant for an Isaac Lab whose actuators run natively (3.0)."""
    row = isaaclab_row(versions)
    return row is not None and row.native


def limited_by_solver(versions: Versions) -> bool | None:
    """Whether an explicit Isaac Lab drive without an effort limit of its own clips at the solver's; None: not known."""
    return clips_at_solvers(_release(versions.isaaclab))


def friction_unit_of(versions: Versions) -> FrictionUnit | None:
    """What Isaac Lab's `friction` means; None where the versions do not tell."""
    return friction_unit(_release(versions.isaaclab), _release(versions.isaac_sim), versions.backend)


def has_dynamic(versions: Versions) -> bool:
    """Whether the solver has a kinetic friction beside the static one, as far as the versions tell."""
    unit = FrictionUnit.COEFFICIENT_VISCOUS if versions.backend == "ovphysx" else friction_unit_of(versions)
    return unit in (FrictionUnit.EFFORT, FrictionUnit.COEFFICIENT_VISCOUS)


def _release(text: str | None) -> Release | None:
    return None if text is None else release(text)


def written_for(data: bytes) -> Mapping[str, str]:
    """Versions by the names of `Versions`' fields; empty without such a head.

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
