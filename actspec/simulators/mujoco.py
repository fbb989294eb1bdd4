"""MuJoCo's releases: what each can hold, and the words that changed between them."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from actspec.simulators import known_release, newest_known, text_of

RELEASES: dict[tuple[int, int], str] = {
    (3, 2): "3.2.7",
    (3, 3): "3.3.7",
    (3, 4): "3.4.0",
    (3, 5): "3.5.0",
    (3, 6): "3.6.0",
    (3, 7): "3.7.0",
    (3, 8): "3.8.1",
    (3, 9): "3.9.0",
    (3, 10): "3.10.0",
    (3, 11): "3.11.0",
    (3, 12): "3.12.0",
    (3, 13): "3.13.0",
    (3, 14): "3.14.0",
    (3, 15): "3.15.0",
    (3, 16): "3.16.0",
    (3, 17): "3.17.0",
    (4, 0): "4.0.0",
}
"""Release that can be compiled for to its last patch, which `verify` runs; oldest first."""

NATIVE_DELAY = (3, 5)
"""First with `delay` and `nsample` on actuators."""
DCMOTOR = (3, 7)
"""First with `<dcmotor>`; up to 3.11 its gains are voltages."""
POLYNOMIALS = (3, 7)
"""First with polynomial coefficients of joints, and with damping and armature of an actuator."""
TORQUE_SPACE = (3, 12)
"""First whose `<dcmotor>` takes gains in torque."""
DAMPRATIO_FREE = (3, 15)
"""First that resolves `dampratio` with the inertia of a joint whose neighbours are free; before, they were held."""
GENERAL_INPUT = (3, 16)
"""First in which an actuator says what its control is (`input`), and would inherit it from a class."""
KEYFRAME_ACT = (3, 16)
"""First whose keyframes can hold activations beside a dcmotor; before, such a file does not load."""


class DcMotorDialect(str, Enum):
    """How `<dcmotor>` writes its controller's gains."""

    NONE = "none"
    """There is no `<dcmotor>`."""
    VOLTAGE = "voltage"
    """`input="position"`, gains in volts."""
    TORQUE = "torque"
    """`input="pos"`, gains in torque."""


@dataclass(frozen=True, slots=True)
class MujocoDialect:
    """What one MuJoCo version can hold.

    Attributes:
        version: Release, e.g. (3, 12).
    """

    version: tuple[int, int]

    @property
    def text(self) -> str:
        """`3.12`."""
        return text_of(self.version)

    @property
    def dcmotor(self) -> DcMotorDialect:
        """Dialect of `<dcmotor>`."""
        if self.version < DCMOTOR:
            return DcMotorDialect.NONE
        return DcMotorDialect.VOLTAGE if self.version < TORQUE_SPACE else DcMotorDialect.TORQUE

    @property
    def native_delay(self) -> bool:
        """See `NATIVE_DELAY`."""
        return self.version >= NATIVE_DELAY

    @property
    def polynomials(self) -> bool:
        """See `POLYNOMIALS`."""
        return self.version >= POLYNOMIALS

    @property
    def keyframe_act(self) -> bool:
        """See `KEYFRAME_ACT`."""
        return self.version >= KEYFRAME_ACT

    @property
    def general_input(self) -> bool:
        """See `GENERAL_INPUT`."""
        return self.version >= GENERAL_INPUT

    @property
    def words(self) -> tuple[object, ...]:
        """What two versions have in common that write a plan in the same words."""
        return (self.dcmotor, self.native_delay, self.polynomials, self.keyframe_act, self.general_input)


def mujoco_dialect(text: str) -> MujocoDialect:
    """The row of a MuJoCo version, `3.12` or `3.12.0`.

    Raises:
        UnknownVersion: there is no such release, or actspec does not know it.
    """
    return MujocoDialect(known_release("MuJoCo", text, tuple(RELEASES)))


def installed_dialect() -> MujocoDialect:
    """Dialect of the MuJoCo that is installed here; one that is newer than the table counts as its last row."""
    import mujoco

    return mujoco_dialect(newest_known(mujoco.__version__, tuple(RELEASES)))
