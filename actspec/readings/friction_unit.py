"""What Isaac Lab's friction fields mean, by version, simulator and backend."""

from __future__ import annotations

from enum import Enum

from actspec.readings.versions import Versions, release


class Meaning(Enum):
    """What the solver takes `friction` for."""

    EFFORT = "effort"
    """Torque [N*m or N]."""
    COEFFICIENT = "coefficient"
    """A factor on the joint's load."""
    DEAD = "dead"
    """Nothing: the setter never reaches the solver."""


def friction_meaning(versions: Versions) -> Meaning | None:
    """What Isaac Lab's `friction` means; None where the versions do not tell.

    Source: Isaac Lab 2.2.0 and 2.3.2, articulation.py; 3.0, docs/source/concepts/actuators.rst.
    """
    lab = None if versions.isaaclab is None else release(versions.isaaclab)
    sim = None if versions.isaac_sim is None else release(versions.isaac_sim)
    if lab is not None and lab >= (3,):
        known = {"ovphysx": Meaning.COEFFICIENT, "physx": Meaning.EFFORT, "newton": Meaning.EFFORT}
        return known.get(versions.backend or "")
    if (sim is not None and sim < (5,)) or (lab is not None and lab < (2, 2)):
        return Meaning.COEFFICIENT
    if lab is None or sim is None:
        return None
    if lab >= (2, 3):
        return Meaning.EFFORT
    return Meaning.DEAD if lab in ((2, 2), (2, 2, 0)) else None


def has_dynamic(versions: Versions) -> bool:
    """Whether the solver has a kinetic friction beside the static one, as far as the versions tell."""
    meaning = friction_meaning(versions)
    return versions.backend == "ovphysx" or (meaning is Meaning.EFFORT and versions.backend != "newton")
