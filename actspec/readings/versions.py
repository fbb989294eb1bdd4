"""Which releases the files are meant for."""

from __future__ import annotations

from dataclasses import dataclass, replace

from actspec.readings.artifact import Artifact

Release = tuple[int, ...]

_MJLAB = {(1, 4): (3, 8), (1, 5): (3, 10), (1, 6): (3, 11)}
"""mjlab to the one MuJoCo that it takes. Source: the requirements of mjlab 1.4.0, 1.5.3 and 1.6.0."""


@dataclass(frozen=True, slots=True)
class Versions:
    """Which versions the files are meant for; None: not said, and nothing is assumed.

    Attributes:
        mujoco: `3.12`.
        isaaclab: `2.3`.
        isaac_sim: `5.1`.
        backend: Isaac Lab 3's physics: `physx`, `ovphysx` or `newton`.
        mjlab: `1.6`.
    """

    mujoco: str | None = None
    isaaclab: str | None = None
    isaac_sim: str | None = None
    backend: str | None = None
    mjlab: str | None = None


def meant_for(versions: Versions, artifact: Artifact) -> Versions:
    """What an artifact is meant for: as was said, else as actspec wrote it for.

    Args:
        versions: As was said for all files; one of Isaac Lab's speaks for all of it.
        artifact: The artifact.
    """
    config = artifact.config
    said = versions.isaaclab or versions.isaac_sim or versions.backend
    return versions if said or config is None else replace(versions, **config.written_for)


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


def mujoco_of(versions: Versions) -> Meant | None:
    """The MuJoCo that the files are meant for: named, or the one that the named mjlab takes."""
    if versions.mujoco is not None:
        return Meant(release(versions.mujoco), f"MuJoCo {versions.mujoco}")
    if versions.mjlab is None:
        return None
    major, minor = (*release(versions.mjlab), 0)[:2]
    taken = _MJLAB.get((major, minor))
    if taken is None:
        return None
    return Meant(taken, f"MuJoCo {'.'.join(map(str, taken))} (which mjlab {versions.mjlab} takes)")
