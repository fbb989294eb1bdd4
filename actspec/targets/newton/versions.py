"""What each Newton version can hold.

Source: the released wheels 1.2.0, 1.3.0, 1.4.0, 1.5.0, 1.6.0, 1.7.0 and 1.8.0, each made to read one overlay
(`add_usd`): 1.0 and 1.1 read no `NewtonActuator`; 1.2 and 1.3 do, and leave a joint's damping and speed limit where
they were. Networks as read in the sources of those wheels, `newton/_src/actuators`.
"""

from __future__ import annotations

from dataclasses import dataclass

from actspec.diagnostics import nearest
from actspec.targets.versions import UnknownVersion


@dataclass(frozen=True, slots=True)
class NewtonDialect:
    """What one Newton version can hold.

    Attributes:
        version: Release, e.g. (1, 8).
    """

    version: tuple[int, int]

    @property
    def text(self) -> str:
        """`1.8`."""
        return f"{self.version[0]}.{self.version[1]}"

    @property
    def joint_damping(self) -> bool:
        """Whether a joint's `newton:damping` and `newton:velocityLimit` are read (1.4)."""
        return self.version >= (1, 4)

    @property
    def networks(self) -> bool:
        """Whether networks run as the law has them (1.4).

        Before, there is no ONNX, and a network gets the velocity *error*, target - measured.
        """
        return self.version >= (1, 4)

    @property
    def run(self) -> bool:
        """Whether actspec's own tests run what is written for it (tests/frameworks)."""
        return self.version in ((1, 3), (1, 4), (1, 6), (1, 8))


NEWTON_RELEASES: tuple[tuple[int, int], ...] = tuple((1, minor) for minor in range(2, 9))
"""Releases that can be compiled for, oldest first."""


def newton_dialect(text: str) -> NewtonDialect:
    """The row of a Newton version: `1.8` or `1.8.0`.

    Raises:
        UnknownVersion: there is no such release, it reads no actuators, or actspec does not know it.
    """
    parts = text.strip().split(".")
    numbers = tuple(int(part) for part in parts if part.isascii() and part.isdigit() and len(part) < 9)
    known = [f"{major}.{minor}" for major, minor in NEWTON_RELEASES]
    if len(numbers) == len(parts) and 2 <= len(numbers) <= 3:
        if numbers[:2] in NEWTON_RELEASES:
            return NewtonDialect((numbers[0], numbers[1]))
        if numbers[:2] < NEWTON_RELEASES[0]:
            raise UnknownVersion(
                f"Newton {text.strip()} reads no actuators from USD", f"known: {known[0]} to {known[-1]}"
            )
    guess = nearest(".".join(parts[:2]), known)
    raise UnknownVersion(
        f"actspec does not know Newton {text!r}",
        f"known: {known[0]} to {known[-1]}" + (f"; did you mean '{guess}'?" if guess else ""),
    )
