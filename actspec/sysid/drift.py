"""Friction that is another at the end of a log than at its beginning, as while a gear warms up."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span
from actspec.sysid.descent import Fit, Piecewise, block_rows
from actspec.sysid.system import System
from actspec.sysid.work import JointInWork, piecewise
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

LEAST = 9
"""Fewest pieces in which the joint moves: three in each third. Chosen: fewer tell no variance. In 31 logs of 10 s whose
friction stays, wrong masses, coarse encoders and late torques among them, it changed by 2 % and 1.7 standard deviations
at most; where it falls by 29 % in 10 s, 5.4."""
MOVES = 0.3
"""Speed of a piece over that of the fastest, as root mean squares, from which on the joint moves in it."""
ALIKE = 1.5
"""Ratio of the speeds of two thirds up to which their friction is compared: friction follows speed too. Chosen."""
FAR = 0.15
"""Share by which friction must change. Chosen: pose and load change it by less."""
SURE = 4.0
"""Likewise in standard deviations."""


@dataclass(frozen=True, slots=True)
class _Friction:
    """Of a third of a log.

    Attributes:
        coulomb: [N*m or N].
        viscous: [N*m*s/rad or N*s/m].
        covariance: Of both, shape (2, 2).
    """

    coulomb: float
    viscous: float
    covariance: Array

    def at(self, speed: float) -> float:
        """Friction at a speed [N*m or N]."""
        return self.coulomb + self.viscous * speed

    def variance(self, speed: float) -> float:
        """Of that."""
        c = self.covariance
        return float(c[0, 0] + 2.0 * speed * c[0, 1] + speed**2 * c[1, 1])


def judge_drift(joint: JointInWork, system: System, unit: str, out: Collector) -> None:
    """Report friction that changes from the first to the last third of a log.

    Args:
        joint: After its fit.
        system: Residuals where the fit ended, and their derivatives.
        unit: Of friction.
        out: Takes what is found.
    """
    import numpy as np

    fit = joint.fit
    assert fit is not None
    if not fit.arrived or not {"coulomb", "viscous"} <= set(fit.free):
        return
    for index, (part, recording) in enumerate(zip(piecewise(joint), joint.recordings, strict=False)):
        rows = part.starts[:, None] + np.arange(part.rows)
        speeds = np.sqrt(np.mean(recording.velocity[rows] ** 2, axis=1))
        moving = np.flatnonzero(speeds > MOVES * speeds.max())
        if len(moving) < LEAST:
            continue
        third = len(moving) // 3
        first, last = moving[:third], moving[-third:]
        pace = [float(np.sqrt(np.mean(speeds[chosen] ** 2))) for chosen in (first, last)]
        if max(pace) > ALIKE * min(pace):
            continue
        speed = sum(pace) / 2.0
        early, late = (_friction(fit, part, system, index, chosen) for chosen in (first, last))
        change = late.at(speed) - early.at(speed)
        spread = math.sqrt(max(early.variance(speed) + late.variance(speed), 0.0))
        if abs(change) < FAR * abs(early.at(speed)) or abs(change) < SURE * spread:
            continue
        shown = (
            f"friction at {format_number(speed, 2)} {'m/s' if unit == 'N' else 'rad/s'} is "
            f"{format_number(early.at(speed), 3)} {unit} in the first third of the log and "
            f"{format_number(late.at(speed), 3)} {unit} in the last (Coulomb {format_number(early.coulomb, 3)} and "
            f"{format_number(late.coulomb, 3)} {unit})"
        )
        help = "move the joint until it is warm before the log begins, and fit what was logged cold apart"
        out.warning("SYS045", shown, where=joint.actuator.joint, span=Span(recording.log.path), help=help)


def _friction(fit: Fit, part: Piecewise, system: System, index: int, chosen: NDArray[np.intp]) -> _Friction:
    """Friction in some pieces of a log, all else as fitted, to the first order."""
    both = [fit.free.index(name) for name in ("coulomb", "viscous")]
    few = System(
        [
            {
                channel: (r[:, chosen], jac[:, chosen][:, :, both], local[:, chosen])
                for channel, (r, jac, local) in system.logs[index].items()
            }
        ],
        len(both),
    )
    solved = few.solve(fit.noise)
    coulomb, viscous = solved.step(0.0)
    rows = block_rows([replace(part, starts=part.starts[chosen])])
    covariance = solved.sandwich(*few.blocks(fit.noise, solved, rows))
    return _Friction(fit.values["coulomb"] + coulomb, fit.values["viscous"] + viscous, covariance)
