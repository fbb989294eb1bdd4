"""What a step does to a drive whose torque is computed before it: when it rings, and when it diverges."""

from __future__ import annotations

from dataclasses import dataclass

RINGING = 1.9
"""From here a swing of the speed loses a tenth or less with a step, and lasts 44 steps. Chosen: at 1.8 it is gone after
20, which nobody sees."""

LIMIT = 2.0
"""h kd/I + h^2 kp/(2 I) at which semi-implicit Euler with an explicit PD diverges.

Source: v' = v - h (kp x + kd v)/I, x' = x + h v' has characteristic polynomial
z^2 - (2 - a - b) z + (1 - b), a = h^2 kp/I, b = h kd/I; its roots are inside the unit circle
exactly when 0 < b and b + a/2 < 2.
"""


@dataclass(frozen=True, slots=True)
class StepDrive:
    """What a step does to a joint that is let go with some speed.

    Attributes:
        step: h [s].
        kp: Of all drives.
        explicit: Damping that is taken from the speed before the step.
        implicit: Damping that is taken from the speed after it.
    """

    step: float
    kp: float
    explicit: float
    implicit: float

    @property
    def formula(self) -> str:
        """What `figure` is of this drive, in letters: d is the damping that is taken implicitly."""
        damping, inertia = ("h (kd + d)", "(I + h d)") if self.implicit else ("h kd", "I")
        return f"{damping}/{inertia}" + (f" + h^2 kp/2{inertia}" if self.kp else "")

    def figure(self, inertia: float) -> float:
        """h kd/I + h^2 kp/(2 I), with joint damping on both sides where it is implicit; 2 is the limit.

        Source: v' = v - h (kp x + (kd + d) v)/(I + h d), x' = x + h v'; as `LIMIT`, with I + h d for I.
        """
        force = self.step * (self.explicit + self.implicit) + self.step**2 * self.kp / 2.0
        return force / (inertia + self.step * self.implicit)
