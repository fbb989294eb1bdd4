"""Isaac Lab's releases: what each can hold, by Isaac Sim version and physics backend.

Source: the wheels 2.2.0, 2.3.0 and 2.3.2 (run by tests/frameworks); for 2.1 and 3.0, whose packages cannot be had,
their documentation and changelogs, read. Isaac Sim: the installation pages of Isaac Lab 2.1, 2.2 and 2.3; Isaac Sim
6.2's compatibility page for 3.0. Friction: 2.2.0 and 2.3.2, articulation.py; 3.0, docs/source/concepts/actuators.rst.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from actspec.simulators import Release, UnknownVersion, before, known_release, release_of, text_of


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

    @property
    def torque(self) -> bool:
        """Whether the number is a torque [N*m or N]."""
        return self in (FrictionUnit.EFFORT, FrictionUnit.EFFORT_ONE)

    @property
    def coefficient(self) -> bool:
        """Whether the number is a factor on the joint's load."""
        return self in (FrictionUnit.COEFFICIENT, FrictionUnit.COEFFICIENT_VISCOUS)

    @property
    def viscous(self) -> bool:
        """Whether passive viscous friction has a field of its own that works."""
        return self not in (FrictionUnit.COEFFICIENT, FrictionUnit.DEAD)


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

OLD_NAMES_GONE = (4, 0)
"""First release without the old names, as 3.0's changelog announces."""

_CLIPS_AT_SOLVERS = ((2, 0, 2), (2, 3, 1))
"""First release, and the first no more, whose explicit drives without an effort limit of their own clip at that of the
solver, 1e9 N*m without one; the others clip at the USD's. At its own the solver clips the torque again in all.

Source: actuator_base.py of 2.0.1, 2.0.2 and 2.3.1, read (the second has `effort_limit_sim` as default of
`effort_limit`; isaac-sim/IsaacLab#3522 ends it); the wheels 2.2.0, 2.3.0 and 2.3.2, measured; 3.0,
docs/source/concepts/actuators.rst.
"""

CLIPPING_AT_SOLVERS = "Isaac Lab 2.0.2 to 2.3.0"
"""These releases, in words."""


def clips_at_solvers(named: Release | None) -> bool | None:
    """Whether an explicit drive without an effort limit of its own clips at the solver's; False: at the USD's.

    Args:
        named: Isaac Lab's release, as many numbers as were named; None: not named.

    Returns:
        None where the release does not tell: `2.3` may be 2.3.0 or 2.3.1.
    """
    first, end = _CLIPS_AT_SOLVERS
    if named is None or any(len(named) < len(edge) and edge[: len(named)] == named for edge in (first, end)):
        return None
    return first <= named < end


@dataclass(frozen=True, slots=True)
class IsaacLabRelease:
    """What one Isaac Lab version does.

    Attributes:
        sims: Isaac Sim versions that it runs on, its own the last one.
        friction: What `friction` means to PhysX on Isaac Sim 5 and later.
        four_quadrants: The DC motor brakes with its whole limit; before, either limit ends at 0.
        lstm_standstill: ActuatorNetLSTM clips its torque as if the joint stood still.
        native: Actuators run natively: limits have new names and are dicts throughout, the solver clips a second
            time, a lag is `max_delay`, classes of one's own are refused, a backend is chosen, two groups may not
            share a joint, and a dict that misses a joint raises.
        wheel: The package that tests and `verify` run its text with; None: none can be had.
    """

    sims: tuple[tuple[int, int], ...]
    friction: FrictionUnit
    four_quadrants: bool = True
    lstm_standstill: bool = False
    native: bool = False
    wheel: str | None = None


RELEASES: dict[tuple[int, int], IsaacLabRelease] = {
    (2, 1): IsaacLabRelease(((4, 5),), FrictionUnit.COEFFICIENT, four_quadrants=False),
    (2, 2): IsaacLabRelease(((4, 5), (5, 0)), FrictionUnit.DEAD, lstm_standstill=True, wheel="2.2.0"),
    (2, 3): IsaacLabRelease(
        ((4, 5), (5, 0), (5, 1)), FrictionUnit.EFFORT, lstm_standstill=True, wheel="2.3.2.post1"
    ),
    (3, 0): IsaacLabRelease(((6, 0), (6, 1), (6, 2)), FrictionUnit.EFFORT, native=True),
}
"""Versions that can be compiled for, oldest first."""

FRICTION_IS_TORQUE = (5, 0)
"""First Isaac Sim whose friction may be a torque; below, it is a factor on the joint's load."""

_BACKENDS = {
    "physx": ("PhysX", FrictionUnit.EFFORT),
    "newton": ("Newton", FrictionUnit.EFFORT_ONE),
    "ovphysx": ("OVPhysX", FrictionUnit.COEFFICIENT_VISCOUS),
}
"""Physics backend of a native release: its name, and what `friction` means to it."""

BACKENDS = tuple(_BACKENDS)


@dataclass(frozen=True, slots=True)
class IsaacLabDialect:
    """What one Isaac Lab version on one Isaac Sim version can hold.

    Attributes:
        version: Release, e.g. (2, 3).
        isaac_sim: Release below it, e.g. (5, 1).
        backend: Physics backend.
        row: What the version does.
    """

    version: tuple[int, int]
    isaac_sim: tuple[int, int]
    backend: str
    row: IsaacLabRelease

    @property
    def text(self) -> str:
        """`2.3`."""
        return text_of(self.version)

    @property
    def sim_text(self) -> str:
        """`5.1`."""
        return text_of(self.isaac_sim)

    @property
    def backend_text(self) -> str:
        """`PhysX`."""
        return _BACKENDS[self.backend][0]

    @property
    def friction(self) -> FrictionUnit:
        """What `friction` means."""
        found = friction_unit(self.version, self.isaac_sim, self.backend)
        assert found is not None
        return found

    @property
    def viscous(self) -> bool:
        """Whether passive viscous friction has a field of its own that works."""
        return self.friction.viscous

    @property
    def limits(self) -> LimitNames:
        """Names of the limits."""
        return NEW_NAMES if self.row.native else OLD_NAMES

    @property
    def solver_limit(self) -> bool:
        """Whether explicit groups must state the solver's effort limit: it clips a second time."""
        return self.row.native

    @property
    def four_quadrants(self) -> bool:
        """Whether the DC motor brakes with its whole limit."""
        return self.row.four_quadrants

    @property
    def dict_saturation(self) -> bool:
        """Whether `saturation_effort` may differ inside a group."""
        return self.row.native

    @property
    def custom(self) -> bool:
        """Whether classes of one's own run."""
        return not self.row.native

    @property
    def lag_range(self) -> bool:
        """Whether a lag is drawn per environment at reset; else it is `max_delay`."""
        return not self.row.native

    @property
    def executed(self) -> bool:
        """Whether the emitted text was run against the real package."""
        return self.row.wheel is not None


def isaaclab_dialect(version: str, isaac_sim: str | None, backend: str | None) -> IsaacLabDialect:
    """The row of an Isaac Lab version.

    Args:
        version: `2.3`, `2.3.2` or `3.0`.
        isaac_sim: Isaac Sim version; None: the newest that goes with it.
        backend: Physics backend; None: physx.

    Raises:
        UnknownVersion: there is no such release, it does not run on that Isaac Sim, or it has no such backend.
    """
    release = known_release("Isaac Lab", version, tuple(RELEASES))
    row = RELEASES[release]
    sim = row.sims[-1] if isaac_sim is None else release_of(isaac_sim)
    if sim not in row.sims:
        raise UnknownVersion(
            f"Isaac Lab {version} does not run on Isaac Sim '{isaac_sim}'",
            "write isaac_sim: " + " or ".join(f'"{text_of(one)}"' for one in row.sims),
            "isaac_sim",
        )
    if backend not in (None, "physx") and not row.native:
        native = next(text_of(one) for one, other in RELEASES.items() if other.native)
        raise UnknownVersion(
            f"Isaac Lab {version} has no backend '{backend}'",
            f'leave `backend` out, or write version: "{native}"',
            "backend",
        )
    return IsaacLabDialect(release, sim, backend or "physx", row)


def row_of(named: Release | None) -> IsaacLabRelease | None:
    """What a release does that files are meant for; None: none is named.

    Args:
        named: As many numbers as were named: (3,), (2, 3), (2, 3, 1). The oldest that it could be is taken; one
            that is not in the table counts as the last before it.
    """
    if named is None:
        return None
    same = [row for one, row in RELEASES.items() if one[: len(named)] == named[:2]]
    if same:
        return same[0]
    older = [row for one, row in RELEASES.items() if one < named]
    return older[-1] if older else next(iter(RELEASES.values()))


def friction_unit(lab: Release | None, sim: Release | None, backend: str | None) -> FrictionUnit | None:
    """What `friction` means, as far as the versions tell; None where they do not.

    Args:
        lab: Isaac Lab's release, as many numbers as were named; None: not named.
        sim: Isaac Sim's, likewise.
        backend: Physics backend, of a native release; None: not named.
    """
    row = row_of(lab)
    if row is not None and row.native:
        return _BACKENDS[backend][1] if backend in _BACKENDS else None
    if sim is not None and before(sim, FRICTION_IS_TORQUE):
        return FrictionUnit.COEFFICIENT
    if row is not None and row.friction is FrictionUnit.COEFFICIENT and lab is not None and len(lab) > 1:
        return FrictionUnit.COEFFICIENT
    if lab is None or sim is None or row is None or len(lab) < 2:
        return None
    # 2.2.0 is known to be dead; its patches were not had.
    return None if row.friction is FrictionUnit.DEAD and any(lab[2:]) else row.friction
