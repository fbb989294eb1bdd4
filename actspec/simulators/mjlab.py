"""mjlab's releases: what each can hold, and the MuJoCo that it needs.

Source: fields, defaults and requirements read in the released wheels 1.0.0, 1.1.0, 1.2.0, 1.3.0, 1.4.0, 1.5.3 and
1.6.0.
"""

from __future__ import annotations

from dataclasses import dataclass

from actspec.simulators import Release, known_release, release, text_of


@dataclass(frozen=True, slots=True)
class MjlabRelease:
    """One mjlab version.

    Attributes:
        mujoco: MuJoCo that it requires.
        run: actspec's own tests run what is written for it (tests/frameworks).
    """

    mujoco: str
    run: bool


RELEASES: dict[tuple[int, int], MjlabRelease] = {
    (1, 0): MjlabRelease(">=3.4.0", True),
    (1, 1): MjlabRelease(">=3.5.0", False),
    (1, 2): MjlabRelease(">=3.5.0", True),
    (1, 3): MjlabRelease(">=3.7.0", True),
    (1, 4): MjlabRelease("~=3.8.0", False),
    (1, 5): MjlabRelease("~=3.10.0", True),
    (1, 6): MjlabRelease("~=3.11.0", True),
}
"""Versions that can be compiled for, oldest first."""

INSTALLED = "1.6.0"
"""The package that `verify` has in its environment."""

DR_MODULE = (1, 2)
"""First with `mjlab.envs.mdp.dr`."""
COMMON_FIELDS = (1, 3)
"""First in which every actuator has `delay_*` and `viscous_damping`, keeps the model's armature and frictionloss where
they are None, and takes any velocity command. Before, `DelayedActuatorCfg` wraps an actuator, armature and frictionloss
are 0 where they are not stated, and a velocity is clamped to the joint's range of *positions*."""
EVENTS = (1, 6)
"""First that actspec writes randomisation for."""


@dataclass(frozen=True, slots=True)
class MjlabDialect:
    """What one mjlab version can hold.

    Attributes:
        version: Release, e.g. (1, 6).
    """

    version: tuple[int, int]

    @property
    def text(self) -> str:
        """`1.6`."""
        return text_of(self.version)

    @property
    def mujoco(self) -> str:
        """MuJoCo that it requires."""
        return RELEASES[self.version].mujoco

    @property
    def run(self) -> bool:
        """Whether actspec's own tests run what is written for it."""
        return RELEASES[self.version].run

    @property
    def delay_fields(self) -> bool:
        """Whether every actuator has `delay_*`."""
        return self.version >= COMMON_FIELDS

    @property
    def keeps_model(self) -> bool:
        """Whether armature and frictionloss may be None and keep the model's."""
        return self.version >= COMMON_FIELDS

    @property
    def viscous_damping(self) -> bool:
        """Whether actuators have `viscous_damping`."""
        return self.version >= COMMON_FIELDS

    @property
    def velocity_unclamped(self) -> bool:
        """Whether `BuiltinVelocityActuatorCfg` takes any command."""
        return self.version >= COMMON_FIELDS

    @property
    def bias_event(self) -> str:
        """Name of the event that sets an encoder bias."""
        return "dr.encoder_bias" if self.version >= DR_MODULE else "randomize_encoder_bias"


def mjlab_dialect(text: str) -> MjlabDialect:
    """The row of an mjlab version: `1.6` or `1.6.0`.

    Raises:
        UnknownVersion: there is no such release, or actspec does not know it.
    """
    return MjlabDialect(known_release("mjlab", text, tuple(RELEASES)))


def mujoco_taken_by(named: Release) -> Release | None:
    """The one MuJoCo that a release takes; None where it takes several, or is not known."""
    major, minor = (*named, 0)[:2]
    row = RELEASES.get((major, minor))
    if row is None or not row.mujoco.startswith("~="):
        return None
    return release(row.mujoco.removeprefix("~="))[:2]
