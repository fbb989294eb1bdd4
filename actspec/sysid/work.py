"""A joint on its way through a fit, and what a user asks of it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from actspec.ir import JointActuator
from actspec.joints import JointKind
from actspec.sysid.course import Course
from actspec.sysid.descent import Fit, Piecewise, Search, linearised
from actspec.sysid.figures import Bounds
from actspec.sysid.gains import GainSets
from actspec.sysid.recording import Recording
from actspec.sysid.system import System

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class FitOptions:
    """What a user asks of a fit.

    Attributes:
        free: Fields that are free beside the usual ones.
        hold: Fields that are held at the spec's.
        joints: Joints that are fitted; none: all that a log moves.
    """

    free: frozenset[str] = frozenset()
    hold: frozenset[str] = frozenset()
    joints: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True)
class Swings:
    """Pieces of a log in which the drive is off and the joint swings free.

    Attributes:
        starts: First rows.
        rows: Length of each.
    """

    starts: NDArray[np.intp]
    rows: int


@dataclass(slots=True)
class JointInWork:
    """A joint in work.

    Attributes:
        actuator: As the spec has it.
        bounds: Of its drive.
        recordings: Its part of every log.
        courses: The links along each, likewise.
        gains: Of each.
        torque: Whether a torque is fitted.
        fit: The last one.
        fitted_to: The courses that it is of.
        scale: Sizes of the values.
        low: Least ones.
        added: Figures that are free unasked.
        swings: Of each recording, once they are found.
        otherwise: The links along each recording, joints that move as read by another filter; empty: there are none.
        unsure: Of each recording, how little is known of when its torque was read [s]; empty: at its rows.
        clipped: Whether the drive is at its limit often enough to tell its kd, which is clipped, from friction, which
            is not; known after a fit.
    """

    actuator: JointActuator
    bounds: Bounds
    recordings: list[Recording]
    courses: list[Course]
    gains: GainSets
    torque: bool
    fit: Fit | None = None
    scale: Mapping[str, float] | None = None
    low: Mapping[str, float] = field(default_factory=dict)
    added: frozenset[str] = frozenset()
    swings: Sequence[Swings] = ()
    otherwise: Sequence[Course] = ()
    unsure: Sequence[float] = ()
    clipped: bool = False
    fitted_to: Sequence[Course] | None = None

    @property
    def kind(self) -> JointKind:
        """By the units of its logs."""
        return self.recordings[0].kind if self.recordings else self.actuator.kind

    @property
    def told(self) -> bool:
        """Whether the scale of all torques is known: a torque was logged, or a kp is what was sent."""
        return self.torque or "kp" in self.gains.held

    @property
    def parted(self) -> bool:
        """Whether kd shows apart from viscous friction."""
        import numpy as np

        fed = any(bool(np.any(recording.speed_command)) for recording in self.recordings)
        swings = any(len(found.starts) for found in self.swings)
        told = "kd" in self.gains.held or self.gains.ratio_tells_kd
        return self.torque or fed or swings or told or self.clipped

    @property
    def sources(self) -> list[Recording]:
        """Where each entry of `piecewise` comes from."""
        swinging = [r for r, found in zip(self.recordings, self.swings, strict=False) if len(found.starts)]
        return [*self.recordings, *swinging]


def piecewise(joint: JointInWork) -> list[Piecewise]:
    """The logs of a joint in pieces, with the course of each; behind them its free swings."""
    found = []
    for index, (recording, course) in enumerate(zip(joint.recordings, joint.courses, strict=True)):
        measured = {
            name: signal for name, signal in recording.measured.items() if name != "torque" or joint.torque
        }
        behind = recording.log.sidecar.torque == "joint"
        own = joint.gains.own(index)
        found.append(
            Piecewise(course, measured, recording.starts, recording.rows, behind, own, recording.ago)
        )
    swings = enumerate(joint.swings)
    return found + [swung(joint, index, mine) for index, mine in swings if len(mine.starts)]


def swung(joint: JointInWork, index: int, swings: Swings) -> Piecewise:
    """Free swings of a recording: whatever the drive is, it does nothing there."""
    recording = joint.recordings[index]
    measured = {name: recording.released[name] for name in recording.released if name in recording.measured}
    own = {name: (name, 0.0) for name in ("kp", "kd", "delay", "lag")}
    return Piecewise(joint.courses[index], measured, swings.starts, swings.rows, own=own)


def ended(joint: JointInWork) -> System:
    """Residuals where a joint's fit ended, and their derivatives."""
    fit, scale = joint.fit, joint.scale
    assert fit is not None and scale is not None
    search = Search(piecewise(joint), joint.bounds, fit.free, scale, joint.low, fit.reading)
    return linearised(search, fit.values, fit.states)
