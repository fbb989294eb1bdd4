"""Capability tables: what each version of a target can hold.

Source: measured with the released wheels; tests/agree runs them again.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from actspec.diagnostics import nearest


class DcMotorDialect(str, Enum):
    """How `<dcmotor>` writes its controller's gains."""

    NONE = "none"
    """No `<dcmotor>` before 3.7."""
    VOLTAGE = "voltage"
    """3.7 to 3.11: `input="position"`, gains in volts."""
    TORQUE = "torque"
    """3.12 and later: `input="pos"`, gains in torque."""


@dataclass(frozen=True, slots=True)
class MujocoDialect:
    """What one MuJoCo version can hold.

    Attributes:
        version: Release, e.g. (3, 12).
        dcmotor: Dialect of `<dcmotor>`.
        native_delay: `delay` and `nsample` on actuators (3.5).
        polynomials: Polynomial joint coefficients and actuator-level damping (3.7).
        authored_save: MjSpec can save the author's form without loss of digits (3.16).
    """

    version: tuple[int, int]
    dcmotor: DcMotorDialect
    native_delay: bool
    polynomials: bool
    authored_save: bool

    @property
    def text(self) -> str:
        """`3.12`."""
        return f"{self.version[0]}.{self.version[1]}"

    @property
    def keyframe_act(self) -> bool:
        """Whether a keyframe can hold activations beside a dcmotor; before 3.16 such a file does not load."""
        return self.version >= (3, 16)

    @property
    def general_input(self) -> bool:
        """Whether `<general>` says what its control is (`input`, 3.16), and would inherit it from a class."""
        return self.version >= (3, 16)


MUJOCO_RELEASES: tuple[tuple[int, int], ...] = (*((3, minor) for minor in range(2, 18)), (4, 0))
"""Releases that can be compiled for."""

DEFAULT_MUJOCO = "3.12"
"""Version when a spec names none. Chosen: the first with torque-space dcmotor gains."""


DEFAULT_VERSIONS = {"mujoco": DEFAULT_MUJOCO, "isaaclab": "2.3", "mjlab": "1.6", "newton": "1.8"}
"""Version of each kind of target when a spec names none; kinds without versions are not in it."""


class UnknownVersion(ValueError):
    """A version that is not known; `help` names the nearest."""

    def __init__(self, message: str, help: str) -> None:
        super().__init__(message)
        self.message, self.help = message, help


def mujoco_dialect(text: str) -> MujocoDialect:
    """The row of a MuJoCo version: `3.12`, `3.12.0`, `v3.12` or `3`-less forms are refused.

    Raises:
        UnknownVersion: there is no such release, or actspec does not know it.
    """
    known = [f"{major}.{minor}" for major, minor in MUJOCO_RELEASES]
    parts = text.strip().split(".")
    numbers = tuple(int(part) for part in parts if part.isascii() and part.isdigit())
    if len(numbers) != len(parts) or not 2 <= len(numbers) <= 3 or numbers[:2] not in MUJOCO_RELEASES:
        guess = nearest(".".join(parts[:2]), known)
        raise UnknownVersion(
            f"actspec does not know MuJoCo {text!r}",
            f"known: {known[0]} to {known[-1]}" + (f"; did you mean '{guess}'?" if guess else ""),
        )
    version = (numbers[0], numbers[1])
    dcmotor = DcMotorDialect.NONE
    if version >= (3, 12):
        dcmotor = DcMotorDialect.TORQUE
    elif version >= (3, 7):
        dcmotor = DcMotorDialect.VOLTAGE
    return MujocoDialect(version, dcmotor, version >= (3, 5), version >= (3, 7), version >= (3, 16))
