"""STB: is an explicitly integrated drive stable at the simulation's step?"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass

from actspec.diagnostics import Diagnostic, Severity
from actspec.ir import ActuatorSet, JointActuator
from actspec.units import format_quantity

RINGING = 1.5
"""From here a swing of the speed loses half or less with a step. Chosen: below, it is over after a few steps."""

LIMIT = 2.0
"""h kd/I + h^2 kp/(2 I) at which semi-implicit Euler with an explicit PD diverges.

Source: v' = v - h (kp x + kd v)/I, x' = x + h v' has characteristic polynomial
z^2 - (2 - a - b) z + (1 - b), a = h^2 kp/I, b = h kd/I; its roots are inside the unit circle
exactly when 0 < b and b + a/2 < 2.
"""

NEAR = 1.0
"""Reported from here: at b = 1 one step takes the whole velocity away, beyond it rings."""


@dataclass(frozen=True, slots=True)
class Margin:
    """Stability figure of one joint.

    Attributes:
        figure: h kd/I + h^2 kp/(2 I) [-].
        inertia: Least free inertia over the poses [kg*m^2 or kg].
    """

    figure: float
    inertia: float


def explicit_margin(actuator: JointActuator, step: float) -> Margin | None:
    """Stability figure of an explicit PD; None when gain or inertia is unknown.

    Args:
        actuator: The joint's actuator.
        step: Physics step h [s].
    """
    if actuator.inertia_free is None or actuator.kd is None or actuator.kd.value is None:
        return None
    inertia = actuator.inertia_free.low
    if inertia <= 0.0:
        return None
    kp = actuator.kp.value if actuator.kp is not None and actuator.kp.value is not None else 0.0
    return Margin(step * actuator.kd.value / inertia + step**2 * kp / (2.0 * inertia), inertia)


def explicit_stability(
    actuators: ActuatorSet, explicit: Mapping[str, Collection[str]]
) -> Iterator[Diagnostic]:
    """STB001: kd (and kp) too high for the step where the drive is integrated explicitly.

    Args:
        actuators: What is compiled.
        explicit: What it is compiled to, in words, to the joints whose drive is explicit there: those of
            MuJoCo under the Euler integrator, and the torque classes of Isaac Lab and mjlab under any.
    """
    step = actuators.physics_dt.value
    if step is None:
        return
    worst: dict[str, tuple[Margin, JointActuator]] = {}
    for actuator in actuators.joints:
        margin = explicit_margin(actuator, step)
        if margin is None or margin.figure < NEAR:
            continue
        if not any(actuator.joint in joints for joints in explicit.values()):
            continue
        if actuator.group not in worst or margin.figure > worst[actuator.group][0].figure:
            worst[actuator.group] = (margin, actuator)
    for group, (margin, actuator) in worst.items():
        assert actuator.kd is not None
        unstable = margin.figure >= LIMIT
        state = "unstable" if unstable else "near its stability limit"
        concerned = [name for name, joints in explicit.items() if actuator.joint in joints]
        yield Diagnostic(
            "STB001",
            Severity.WARNING,
            f"{actuator.joint}: an explicit drive is {state}: h*kd/I + h^2*kp/(2I) = {margin.figure:.3g} "
            f"(limit {LIMIT:g}) with h {step * 1e3:g} ms, kd {format_quantity(actuator.kd.value, actuator.kd.unit)}, "
            f"free inertia {format_quantity(margin.inertia, actuator.armature.unit)}; concerns {', '.join(concerned)}",
            f"actuators.{group}",
            actuator.kd.span or actuator.span,
            "use the implicitfast integrator (MuJoCo) or `class: implicit` (Isaac Lab), a smaller physics_dt, a lower "
            "kd, or state the true armature",
        )


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

    def figure(self, inertia: float) -> float:
        """h kd/I + h^2 kp/(2 I), with joint damping on both sides where it is implicit; 2 is the limit.

        Source: v' = v - h (kp x + (kd + d) v)/(I + h d), x' = x + h v'; as `stability.LIMIT`, with I + h d for I.
        """
        force = self.step * (self.explicit + self.implicit) + self.step**2 * self.kp / 2.0
        return force / (inertia + self.step * self.implicit)
