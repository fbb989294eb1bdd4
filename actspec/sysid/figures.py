"""What a joint and its drive are, as a fit has it: figures in sets, and what clips the torque."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

from actspec.fields import PLACEHOLDER
from actspec.ir import JointActuator, Quantity
from actspec.laws import clip_asymmetric

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Figures:
    """What a joint and its drive are; an array each, one entry a set, shape (n_set,).

    Attributes:
        kp: [N*m/rad or N/m].
        kd: [N*m*s/rad or N*s/m].
        armature: Inertia beside that of the links [kg*m^2 or kg].
        coulomb: Kinetic dry friction [N*m or N].
        viscous: [N*m*s/rad or N*s/m].
        delay: From sending a command to its effect [s].
        bias: q_measured = q + bias [rad or m].
        static: Break-away friction, at least `coulomb` counts [N*m or N].
        stribeck_velocity: [rad/s or m/s].
        lag: Time constant of the command's low-pass; 0: none [s].
    """

    kp: Array
    kd: Array
    armature: Array
    coulomb: Array
    viscous: Array
    delay: Array
    bias: Array
    static: Array
    stribeck_velocity: Array
    lag: Array

    @classmethod
    def names(cls) -> tuple[str, ...]:
        """Of the figures, in order."""
        return tuple(field.name for field in fields(cls))


def time_constant(cutoff: float) -> float:
    """Of a first-order low-pass [s], from its cutoff > 0 [Hz]; and the cutoff from it."""
    return 1.0 / (2.0 * math.pi * cutoff)


def figures_of(actuator: JointActuator) -> dict[str, float]:
    """The figures of a spec's joint, by the names of `Figures`; what is unknown counts as 0."""

    def of(quantity: Quantity | None) -> float:
        return 0.0 if quantity is None or quantity.value is None else quantity.value

    cutoff = of(actuator.filter_cutoff)
    return {
        "kp": of(actuator.kp),
        "kd": of(actuator.kd),
        "armature": of(actuator.armature),
        "coulomb": of(actuator.friction_coulomb),
        "viscous": of(actuator.friction_viscous),
        "delay": 0.0 if actuator.delay is None else of(actuator.delay.nominal),
        "bias": of(actuator.encoder_bias),
        "static": of(actuator.friction_static),
        "stribeck_velocity": of(actuator.stribeck_velocity),
        "lag": time_constant(cutoff) if cutoff > 0 else 0.0,
    }


@dataclass(frozen=True, slots=True)
class Bounds:
    """What clips the drive's torque.

    Attributes:
        limit: [N*m or N]; infinity: none.
        stall: Of the torque-speed line [N*m or N]; infinity: no line.
        no_load: [rad/s or m/s].
        curve: See `TorqueLaw`; None: none.
    """

    limit: float = math.inf
    stall: float = math.inf
    no_load: float = math.inf
    curve: tuple[float, float, float, float] | None = None

    @classmethod
    def of(cls, actuator: JointActuator) -> Bounds:
        """Those of a drive; what is unknown does not bind."""
        limit = actuator.effort_limit.value
        limit = math.inf if limit is None or limit >= PLACEHOLDER else limit
        curve = actuator.curve
        if curve is not None:
            points = (curve.drive_torque, curve.brake_torque, curve.knee_speed, curve.no_load_speed)
            values = [point.value for point in points if point.value is not None]
            return cls(
                limit, curve=(values[0], values[1], values[2], values[3]) if len(values) == 4 else None
            )
        stall, speed = actuator.stall_torque, actuator.no_load_speed
        if stall is None or speed is None or stall.value is None or speed.value is None:
            return cls(limit)
        return cls(limit, stall.value, speed.value)

    def clip(self, torque: Array, speed: Array) -> Array:
        """The torque within the bounds: `TorqueLaw.torque` without what it asks of every library."""
        import numpy as np

        if self.curve is not None:
            drive, brake, knee, no_load = self.curve
            curved: Array = clip_asymmetric(
                torque,
                speed,
                drive_torque=drive,
                brake_torque=brake,
                knee_speed=knee,
                no_load_speed=no_load,
                effort_limit=self.limit,
            )
            return curved
        if not math.isfinite(self.limit) and not math.isfinite(self.stall):
            return torque
        high: Array | float = self.limit
        low: Array | float = -self.limit
        if math.isfinite(self.stall):
            fastest = self.no_load * (1.0 + (self.limit / self.stall if math.isfinite(self.limit) else 0.0))
            line = self.stall / self.no_load * np.minimum(np.maximum(speed, -fastest), fastest)
            low, high = np.maximum(low, -self.stall - line), np.minimum(high, self.stall - line)
        # On arrays of a thousand it takes a sixth of the time of `numpy.clip`.
        found: Array = np.minimum(np.maximum(torque, low), high)
        return found
