"""What each mjlab version can hold.

Source: fields and defaults read in the released wheels 1.0.0, 1.1.0, 1.2.0, 1.3.0, 1.4.0, 1.5.3 and 1.6.0.
"""

from __future__ import annotations

from dataclasses import dataclass

from actspec.diagnostics import nearest
from actspec.targets.versions import UnknownVersion


@dataclass(frozen=True, slots=True)
class MjlabDialect:
    """What one mjlab version can hold.

    Attributes:
        version: Release, e.g. (1, 6).
        mujoco: MuJoCo that it needs.
    """

    version: tuple[int, int]
    mujoco: str

    @property
    def text(self) -> str:
        """`1.6`."""
        return f"{self.version[0]}.{self.version[1]}"

    @property
    def delay_fields(self) -> bool:
        """Whether every actuator has `delay_*` (1.3); before, `DelayedActuatorCfg` wraps one."""
        return self.version >= (1, 3)

    @property
    def keeps_model(self) -> bool:
        """Whether armature and frictionloss may be None and keep the model's (1.3); before, they are 0."""
        return self.version >= (1, 3)

    @property
    def viscous_damping(self) -> bool:
        """Whether actuators have `viscous_damping` (1.3)."""
        return self.version >= (1, 3)

    @property
    def velocity_unclamped(self) -> bool:
        """Whether `BuiltinVelocityActuatorCfg` takes any command (1.3).

        Before, it clamps the speed to the joint's range of *positions*, and a joint without one does not compile.
        """
        return self.version >= (1, 3)

    @property
    def bias_event(self) -> str:
        """Name of the event that sets an encoder bias."""
        return "dr.encoder_bias" if self.version >= (1, 2) else "randomize_encoder_bias"

    @property
    def run(self) -> bool:
        """Whether actspec's own tests run what is written for it (tests/frameworks)."""
        return self.version in ((1, 0), (1, 2), (1, 3), (1, 5), (1, 6))


_MUJOCO = {
    (1, 0): ">=3.4.0",
    (1, 1): ">=3.5.0",
    (1, 2): ">=3.5.0",
    (1, 3): ">=3.7.0",
    (1, 4): "~=3.8.0",
    (1, 5): "~=3.10.0",
    (1, 6): "~=3.11.0",
}

MJLAB_RELEASES: tuple[tuple[int, int], ...] = tuple(_MUJOCO)
"""Releases that can be compiled for, oldest first."""


def mjlab_dialect(text: str) -> MjlabDialect:
    """The row of an mjlab version: `1.6` or `1.6.0`.

    Raises:
        UnknownVersion: there is no such release, or actspec does not know it.
    """
    parts = text.strip().split(".")
    numbers = tuple(int(part) for part in parts if part.isascii() and part.isdigit() and len(part) < 9)
    if len(numbers) != len(parts) or not 2 <= len(numbers) <= 3 or numbers[:2] not in _MUJOCO:
        known = [f"{major}.{minor}" for major, minor in MJLAB_RELEASES]
        guess = nearest(".".join(parts[:2]), known)
        raise UnknownVersion(
            f"actspec does not know mjlab {text!r}",
            f"known: {known[0]} to {known[-1]}" + (f"; did you mean '{guess}'?" if guess else ""),
        )
    version = (numbers[0], numbers[1])
    return MjlabDialect(version, _MUJOCO[version])
