"""A joint on its way through a fit, and what a user asks of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from actspec.ir import JointActuator
from actspec.sysid.descent import Fit, Piecewise
from actspec.sysid.motion import Bounds, Course
from actspec.sysid.recording import Recording


@dataclass(frozen=True, slots=True)
class FitOptions:
    """What a user asks of a fit.

    Attributes:
        free: Fields that are free beside the usual ones.
        hold: Fields that are held at the spec's.
    """

    free: frozenset[str] = frozenset()
    hold: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class HeldGains:
    """kp and kd, and who states them; None: they are free."""

    kp: float
    kd: float
    where: str


@dataclass(slots=True)
class JointInWork:
    """A joint in work."""

    actuator: JointActuator
    bounds: Bounds
    recordings: list[Recording]
    courses: list[Course]
    held: HeldGains | None
    torque: bool
    fit: Fit | None = None
    scale: Mapping[str, float] | None = None


def piecewise(joint: JointInWork) -> list[Piecewise]:
    """The logs of a joint in pieces, with the course of each."""
    found = []
    for recording, course in zip(joint.recordings, joint.courses, strict=True):
        measured = {
            name: signal for name, signal in recording.measured.items() if name != "torque" or joint.torque
        }
        behind = recording.log.sidecar.torque == "joint"
        found.append(Piecewise(course, measured, recording.starts, recording.rows, behind))
    return found
