"""Which release of an engine the files are meant for."""

from __future__ import annotations

from dataclasses import dataclass

from actspec.audit.case import Case

Release = tuple[int, ...]

_MJLAB = {(1, 4): (3, 8), (1, 5): (3, 10), (1, 6): (3, 11)}
"""mjlab to the one MuJoCo that it takes. Source: the requirements of mjlab 1.4.0, 1.5.3 and 1.6.0."""


@dataclass(frozen=True, slots=True)
class Meant:
    """A named release.

    Attributes:
        release: Its numbers, as many as were named.
        text: `MuJoCo 3.6`, for a message.
    """

    release: Release
    text: str

    def before(self, other: Release) -> bool:
        """Whether it is older; `3.1` may be any patch release of 3.1, and is not older than 3.1.6."""
        count = len(self.release)
        return self.release < (*other, *(0 for _ in range(count)))[:count]


def release(text: str) -> Release:
    """Numbers of a version that the settings have checked."""
    return tuple(int(part) for part in text.split("."))


def mujoco_of(case: Case) -> Meant | None:
    """The MuJoCo that the files are meant for: named, or the one that the named mjlab takes."""
    versions = case.versions
    if versions.mujoco is not None:
        return Meant(release(versions.mujoco), f"MuJoCo {versions.mujoco}")
    if versions.mjlab is None:
        return None
    major, minor = (*release(versions.mjlab), 0)[:2]
    taken = _MJLAB.get((major, minor))
    if taken is None:
        return None
    return Meant(taken, f"MuJoCo {'.'.join(map(str, taken))} (which mjlab {versions.mjlab} takes)")
