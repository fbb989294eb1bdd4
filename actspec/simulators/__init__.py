"""What the releases of each simulator do: one table a simulator, which emit, audit, import and verify read.

A new release is one row of its simulator's `RELEASES`; what a release changed is named there once, and asked by name
everywhere else. A release that is newer than the table counts as its last row where files are read.

Source: measured with the released wheels; tests/agree and tests/frameworks run them again.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from actspec.diagnostics import nearest

Release = tuple[int, ...]
"""Numbers of a version, as many as were named."""

DEFAULT_VERSIONS = {"mujoco": "3.12", "isaaclab": "2.3", "mjlab": "1.6", "newton": "1.8"}
"""Version of each kind of target when a spec names none; kinds without versions are not in it.

MuJoCo chosen: the first with torque-space dcmotor gains.
"""


class UnknownVersion(ValueError):
    """A version that is not known.

    Attributes:
        message: What is wrong.
        help: The known ones, and the nearest.
        key: The target's option that is wrong.
    """

    def __init__(self, message: str, help: str, key: str = "version") -> None:
        super().__init__(message)
        self.message, self.help, self.key = message, help, key


def release(text: str) -> Release:
    """Numbers of a version that has been checked."""
    return tuple(int(part) for part in text.split("."))


def before(named: Release, other: Release) -> bool:
    """Whether a named release is older; `3.1` may be any patch of 3.1, and is not older than 3.1.6."""
    return named < (*other, *(0 for _ in named))[: len(named)]


def release_of(text: str) -> tuple[int, int]:
    """The first two numbers of `3.12` or `3.12.0`; (0, 0) where the text is no such version."""
    parts = text.strip().split(".")
    numbers = [int(part) for part in parts if part.isascii() and part.isdigit() and len(part) < 9]
    if len(numbers) != len(parts) or not 2 <= len(numbers) <= 3:
        return (0, 0)
    return (numbers[0], numbers[1])


def text_of(version: Release) -> str:
    """`3.12` of (3, 12)."""
    return ".".join(map(str, version))


def newest_known(version: str, releases: Sequence[tuple[int, int]]) -> str:
    """`2.3` of an installed `2.3.2.post1`; a release that is newer than every known one counts as the last of them.

    Args:
        version: Of what is installed.
        releases: The known ones, oldest first.
    """
    found = re.match(r"(\d{1,6})\.(\d{1,6})", version)
    return version if found is None else text_of(min((int(found[1]), int(found[2])), tuple(releases)[-1]))


def known_release(simulator: str, text: str, releases: Sequence[tuple[int, int]]) -> tuple[int, int]:
    """The release that a version names.

    Args:
        simulator: Its name, for the message.
        text: As somebody wrote it: `3.12` or `3.12.0`.
        releases: The known ones, oldest first.

    Raises:
        UnknownVersion: it names none of them.
    """
    found = release_of(text)
    if found in releases:
        return found
    known = [text_of(one) for one in releases]
    guess = nearest(".".join(text.strip().split(".")[:2]), known)
    raise UnknownVersion(
        f"actspec does not know {simulator} '{text}'",
        "known: "
        + (", ".join(known) if len(known) < 5 else f"{known[0]} to {known[-1]}")
        + (f"; did you mean '{guess}'?" if guess else ""),
    )
