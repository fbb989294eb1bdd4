"""What each Isaac Lab version can hold, by Isaac Sim version and physics backend.

Source: facts of the wheels 2.2.0, 2.3.0 and 2.3.2 (run by tests/frameworks); for 2.1 and 3.0, whose
packages cannot be had, their documentation and changelogs, read.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from actspec.diagnostics import nearest
from actspec.targets.versions import UnknownVersion


class FrictionUnit(str, Enum):
    """What the solver takes `friction` for."""

    EFFORT = "effort"
    """Static and dynamic torque [N*m or N] and viscous coefficient."""
    EFFORT_ONE = "effort_one"
    """One dry torque, held softly, and a viscous coefficient (Newton)."""
    COEFFICIENT = "coefficient"
    """A factor on the joint's load, no viscous term."""
    COEFFICIENT_VISCOUS = "coefficient_viscous"
    """A factor on the joint's load, and a viscous coefficient (OVPhysX)."""
    DEAD = "dead"
    """The fields are there, and nothing reads them."""


class UnknownDialect(UnknownVersion):
    """A combination that there is not; `key` is the target's key that is wrong."""

    def __init__(self, key: str, message: str, help: str) -> None:
        super().__init__(message, help)
        self.key = key


@dataclass(frozen=True, slots=True)
class LimitNames:
    """Names of the limits of an explicit group.

    Attributes:
        effort: Clamp of the actuator model.
        velocity: No-load speed of the actuator model.
        solver_effort: Clamp of the solver's drive.
        solver_velocity: Speed limit of the solver's joint.
    """

    effort: str
    velocity: str
    solver_effort: str
    solver_velocity: str


OLD_NAMES = LimitNames("effort_limit", "velocity_limit", "effort_limit_sim", "velocity_limit_sim")
NEW_NAMES = LimitNames(
    "actuator_effort_limit", "actuator_velocity_limit", "joint_effort_limit", "joint_velocity_limit"
)


@dataclass(frozen=True, slots=True)
class IsaacLabDialect:
    """What one Isaac Lab version on one Isaac Sim version can hold.

    Attributes:
        version: Release, e.g. (2, 3).
        isaac_sim: Release below it, e.g. (5, 1).
        backend: Physics backend.
        limits: Names of the limits.
        solver_limit: Explicit groups must state the solver's effort limit: it clips a second time (3.0).
        four_quadrants: The DC motor brakes with its whole limit (2.2); before, either limit ends at 0.
        dict_saturation: `saturation_effort` may differ inside a group (3.0).
        custom: Classes of one's own run (2.x).
        lag_range: A lag is drawn per environment at reset; else it is `max_delay` (3.0).
        friction: What `friction` means.
        executed: The emitted text was run against the real package.
    """

    version: tuple[int, int]
    isaac_sim: tuple[int, int]
    backend: str
    limits: LimitNames
    solver_limit: bool
    four_quadrants: bool
    dict_saturation: bool
    custom: bool
    lag_range: bool
    friction: FrictionUnit
    executed: bool

    @property
    def text(self) -> str:
        """`2.3`."""
        return f"{self.version[0]}.{self.version[1]}"

    @property
    def sim_text(self) -> str:
        """`5.1`."""
        return f"{self.isaac_sim[0]}.{self.isaac_sim[1]}"

    @property
    def backend_text(self) -> str:
        """`PhysX`."""
        return {"physx": "PhysX", "newton": "Newton", "ovphysx": "OVPhysX"}[self.backend]

    @property
    def viscous(self) -> bool:
        """Whether passive viscous friction has a field of its own that works."""
        return self.friction not in (FrictionUnit.COEFFICIENT, FrictionUnit.DEAD)


SIMS: dict[tuple[int, int], tuple[tuple[int, int], ...]] = {
    (2, 1): ((4, 5),),
    (2, 2): ((4, 5), (5, 0)),
    (2, 3): ((4, 5), (5, 0), (5, 1)),
    (3, 0): ((6, 0), (6, 1), (6, 2)),
}
"""Isaac Lab to the Isaac Sim versions that it runs on, its own the last one.

Source: the installation pages of Isaac Lab 2.1, 2.2 and 2.3; Isaac Sim 6.2's compatibility page for 3.0.
"""

KNOWN = tuple(f"{major}.{minor}" for major, minor in SIMS)
"""Versions that can be compiled for."""


def isaaclab_dialect(version: str, isaac_sim: str | None, backend: str | None) -> IsaacLabDialect:
    """The row of an Isaac Lab version.

    Args:
        version: `2.3`, `2.3.2` or `3.0`.
        isaac_sim: Isaac Sim version; None: the newest that goes with it.
        backend: Physics backend; None: physx.

    Raises:
        UnknownDialect: there is no such release, it does not run on that Isaac Sim, or it has no such backend.
    """
    release = _release(version)
    if release not in SIMS:
        guess = nearest(".".join(version.split(".")[:2]), KNOWN)
        raise UnknownDialect(
            "version",
            f"actspec does not know Isaac Lab '{version}'",
            f"known: {', '.join(KNOWN)}" + (f"; did you mean '{guess}'?" if guess else ""),
        )
    sims = SIMS[release]
    sim = sims[-1] if isaac_sim is None else _release(isaac_sim)
    if sim not in sims:
        raise UnknownDialect(
            "isaac_sim",
            f"Isaac Lab {version} does not run on Isaac Sim '{isaac_sim}'",
            "write isaac_sim: " + " or ".join(f'"{major}.{minor}"' for major, minor in sims),
        )
    backend = backend or "physx"
    new = release >= (3, 0)
    if backend != "physx" and not new:
        raise UnknownDialect(
            "backend",
            f"Isaac Lab {version} has no backend '{backend}'",
            'leave `backend` out, or write version: "3.0"',
        )
    if backend == "newton":
        friction = FrictionUnit.EFFORT_ONE
    elif backend == "ovphysx":
        friction = FrictionUnit.COEFFICIENT_VISCOUS
    elif sim < (5, 0):
        friction = FrictionUnit.COEFFICIENT
    elif release < (2, 3):
        friction = FrictionUnit.DEAD
    else:
        friction = FrictionUnit.EFFORT
    return IsaacLabDialect(
        version=release,
        isaac_sim=sim,
        backend=backend,
        limits=NEW_NAMES if new else OLD_NAMES,
        solver_limit=new,
        four_quadrants=release >= (2, 2),
        dict_saturation=new,
        custom=not new,
        lag_range=not new,
        friction=friction,
        executed=release in ((2, 2), (2, 3)),
    )


def _release(text: str) -> tuple[int, int]:
    """The first two numbers of a version; (0, 0) where it is none."""
    parts = text.strip().split(".")
    numbers = [int(part) for part in parts if part.isascii() and part.isdigit() and len(part) < 6]
    if len(numbers) != len(parts) or not 2 <= len(numbers) <= 3:
        return (0, 0)
    return (numbers[0], numbers[1])
