"""A drive of a MuJoCo model, as data: what the text, the MjSpec and the check all write or read."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from actspec.ir import Command

VOLTAGE = 24.0
"""Voltage of the emitted dcmotor [V]. Chosen: any number gives the same torque, it cancels."""


class Form(str, Enum):
    """MuJoCo element that a drive becomes."""

    POSITION = "position"
    VELOCITY = "velocity"
    MOTOR = "motor"
    DCMOTOR = "dcmotor"


@dataclass(frozen=True, slots=True)
class Line:
    """Torque-speed line of a dcmotor, joint side: torque at zero speed, speed at zero torque."""

    stall_torque: float
    no_load_speed: float


@dataclass(frozen=True, slots=True)
class Drive:
    """One actuator to write; joint side, gear 1, SI.

    Attributes:
        joint: The joint it drives.
        name: Its name.
        form: Element.
        command: What its control means.
        kp: [N*m/rad or N/m]; 0 unless it is a position drive.
        kd: [N*m*s/rad or N*s/m]; 0 for effort.
        offset: Constant force, -kp * encoder bias [N*m or N].
        effort_limit: forcerange is -+ this [N*m or N]; None: no clamp.
        line: Torque-speed line of a dcmotor.
        time_constant: Of the command filter [s]; 0 without.
        delay_steps: Delay of the command in steps; 0 without.
        step: Simulation step [s].
        control_range: For `ctrlrange`; None leaves it empty.
        control_limited: Whether the command is clamped to it.
        group: Actuator group, kept from a replaced actuator.
        user: User data, kept likewise.
    """

    joint: str
    name: str
    form: Form
    command: Command
    kp: float
    kd: float
    offset: float
    effort_limit: float | None
    line: Line | None
    time_constant: float
    delay_steps: int
    step: float
    control_range: tuple[float, float] | None
    control_limited: bool
    group: int = 0
    user: tuple[float, ...] = ()

    @property
    def delay(self) -> float:
        """Delay in seconds, a whole number of steps."""
        return self.delay_steps * self.step
