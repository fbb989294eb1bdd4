"""Newton's releases: what each reads of an overlay.

Source: the released wheels 1.2.0, 1.3.0, 1.4.0, 1.5.0, 1.6.0, 1.7.0 and 1.8.0, each made to read one overlay
(`add_usd`): 1.0 and 1.1 read no `NewtonActuator`; 1.2 and 1.3 do, and leave a joint's damping and speed limit where
they were. Networks as read in the sources of those wheels, `newton/_src/actuators`.
"""

from __future__ import annotations

from dataclasses import dataclass

from actspec.simulators import UnknownVersion, known_release, release_of, text_of

RELEASES: dict[tuple[int, int], str | None] = {
    (1, 2): None,
    (1, 3): "1.3.0",
    (1, 4): "1.4.0",
    (1, 5): None,
    (1, 6): "1.6.1",
    (1, 7): None,
    (1, 8): "1.8.0",
}
"""Release that can be compiled for to the package that tests and `verify` run it with, None: they do not; oldest first.

The last one is in the environment of `verify`, the others lie beside it: 1.3 is the first that runs on this warp, 1.4
the first that reads a joint's damping, 1.6 the first with drives in place of controllers.
"""

JOINT_DAMPING = (1, 4)
"""First that reads a joint's `newton:damping` and `newton:velocityLimit`."""
NETWORKS = (1, 4)
"""First that runs ONNX; before, a network gets the velocity *error*, target - measured."""


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
        return text_of(self.version)

    @property
    def joint_damping(self) -> bool:
        """See `JOINT_DAMPING`."""
        return self.version >= JOINT_DAMPING

    @property
    def networks(self) -> bool:
        """Whether networks run as the law has them; see `NETWORKS`."""
        return self.version >= NETWORKS

    @property
    def run(self) -> bool:
        """Whether actspec's own tests run what is written for it (tests/frameworks)."""
        return RELEASES[self.version] is not None


def newton_dialect(text: str) -> NewtonDialect:
    """The row of a Newton version: `1.8` or `1.8.0`.

    Raises:
        UnknownVersion: there is no such release, it reads no actuators, or actspec does not know it.
    """
    first, last = min(RELEASES), max(RELEASES)
    if (0, 0) < release_of(text) < first:
        raise UnknownVersion(
            f"Newton {text.strip()} reads no actuators from USD",
            f"known: {text_of(first)} to {text_of(last)}",
        )
    return NewtonDialect(known_release("Newton", text, tuple(RELEASES)))
