"""What the engines are told and where the joints are put: the grid of error, velocity and history.

- `torque`: one step each, from a history that has settled: torque asked for by velocity, with every corner of
  the law among them (limits, knee, no-load speed, over-speed, both signs).
- `torque.step`: the command steps, the joint is held; delay and filter show.
- `torque.ramp`: it ramps, both ways.

The ranges are those that approximations are sized over (`actspec.targets.kit.sizes`), so a known
approximation bounds what is seen here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from actspec.ir import Command, JointActuator
from actspec.laws import TorqueLaw, delay_steps
from actspec.targets.kit.sizes import speed_scale

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SHARES = 25
"""Torques asked for, from -2 L to 2 L: an odd number has 0, and with 4 divisors +-L too."""
SPEEDS = 33
"""Speeds from -2 w0 to 2 w0, beside the corners of the law."""
SWING = 0.05
"""Largest distance of the joint from its place on the grid [rad or m]. Chosen: small, so that an engine in single
precision loses no digits where command and position cancel; not 0, so that a position that is left out shows."""

HELD = 0.03
"""How far from its place the joint is held over time [rad or m]."""
BEFORE = 2
"""Steps before the command changes."""
RAMP = 8
"""Steps that a ramp takes."""
MOST_STEPS = 400
"""Longest history. Chosen: a delay or a filter that takes longer is told by its field alone."""
SETTLED = 5.0
"""Time constants of a filter after which nothing more is to be seen: 0.7 % are left."""

HISTORIES = ("step", "ramp")


@dataclass(frozen=True, slots=True)
class Motion:
    """What the joints are told and do.

    Attributes:
        command: In each joint's own unit, shape (n_step, n_env, n_joint).
        q: Positions [rad or m], likewise; put back before every step.
        qd: Speeds [rad/s or m/s], likewise.
    """

    command: Array
    q: Array
    qd: Array

    def single(self) -> Motion:
        """The same in the digits of single precision, which is what such an engine gets."""
        import numpy as np

        return Motion(*(part.astype(np.float32).astype(float) for part in (self.command, self.q, self.qd)))


def motions(laws: Sequence[TorqueLaw], actuators: Sequence[JointActuator], step: float) -> dict[str, Motion]:
    """All motions by quantity, the joints in columns.

    Args:
        laws: Of the joints.
        actuators: Likewise.
        step: Physics step [s].
    """
    found = {"torque": _stacked([_grid(law) for law in laws])}
    length = min(
        max(_length(law, actuator, step) for law, actuator in zip(laws, actuators, strict=True)), MOST_STEPS
    )
    for kind in HISTORIES:
        found[f"torque.{kind}"] = _stacked([_history(law, kind, length) for law in laws])
    return found


def commands_for(law: TorqueLaw, torque: Any, q: Any, qd: Any) -> Any:
    """Commands for which the drive without its clamp gives a torque [N*m or N]."""
    if law.command is Command.POSITION:
        return q + law.encoder_bias + ((torque + law.kd * qd) / law.kp if law.kp > 0 else 0.0 * torque)
    if law.command is Command.VELOCITY:
        return torque / law.kd + qd if law.kd > 0 else 0.0 * torque
    return torque + 0.0 * qd


def place(law: TorqueLaw) -> float:
    """Where the joint is, roughly: 0, or the middle of what the command is clamped to [rad or m]."""
    if law.command is not Command.POSITION or law.command_range is None:
        return 0.0
    low, high = law.command_range
    if math.isfinite(low) and math.isfinite(high):
        return 0.5 * (low + high)
    return low if math.isfinite(low) else high if math.isfinite(high) else 0.0


def limit_of(law: TorqueLaw) -> float:
    """The effort limit; without one the torque of an error of one radian or metre stands in for it [N*m or N]."""
    if math.isfinite(law.effort_limit):
        return law.effort_limit
    return law.kp if law.kp > 0 else (law.kd if law.kd > 0 else 1.0)


def corners(law: TorqueLaw) -> list[float]:
    """Speeds >= 0 at which the clamp has a corner, in its order: knees, no-load speed, over-speed [rad/s or m/s]."""
    if law.curve is not None:
        drive, brake, knee, no_load = law.curve
        found = [knee, no_load]
        for base in (drive, brake):
            if base > 0 and no_load > knee and law.effort_limit < base:
                found.append(knee + (1.0 - law.effort_limit / base) * (no_load - knee))
        return found
    if law.stall_torque is not None and law.no_load_speed is not None:
        share = law.effort_limit / law.stall_torque if math.isfinite(law.effort_limit) else 0.0
        return [law.no_load_speed * abs(1.0 - share), law.no_load_speed, law.no_load_speed * (1.0 + share)]
    return []


def _grid(law: TorqueLaw) -> tuple[Array, Array, Array]:
    import numpy as np

    width, limit = 2.0 * speed_scale(law), limit_of(law)
    special = [min(speed, width) for speed in corners(law)]
    # Every joint has as many points: a law with fewer corners has 0 among them more often.
    special += [0.0] * (4 - len(special))
    speeds = np.concatenate([np.linspace(-width, width, SPEEDS), special, np.negative(special)])
    torques, qd = (
        part.ravel() for part in np.meshgrid(np.linspace(-2.0, 2.0, SHARES) * limit, speeds, indexing="ij")
    )
    q = place(law) + SWING * np.cos(np.arange(torques.size))
    return commands_for(law, torques, q, qd)[None], q[None], qd[None]


def _history(law: TorqueLaw, kind: str, length: int) -> tuple[Array, Array, Array]:
    """A change of the command that is worth 0.5 L, up and down, at standstill."""
    import numpy as np

    k = np.arange(length)
    share = (k >= BEFORE) * 1.0 if kind == "step" else np.clip((k - BEFORE) / RAMP, 0.0, 1.0)
    torques = 0.5 * limit_of(law) * np.stack([share, -share], axis=1)
    q, qd = np.full_like(torques, place(law) + HELD), np.zeros_like(torques)
    return commands_for(law, torques, q, qd), q, qd


def _length(law: TorqueLaw, actuator: JointActuator, step: float) -> int:
    """Steps until a change of the command has come through."""
    late = max([law.delay, *([actuator.delay.high] if actuator.delay is not None else [])])
    steps = BEFORE + RAMP + 4 + delay_steps(late, step).steps
    if law.filter_cutoff is not None:
        steps += math.ceil(SETTLED / (2.0 * math.pi * law.filter_cutoff * step))
    return steps


def _stacked(parts: Sequence[tuple[Array, Array, Array]]) -> Motion:
    import numpy as np

    command, q, qd = (np.stack(columns, axis=2) for columns in zip(*parts, strict=True))
    return Motion(command, q, qd)


def as_arrays(moves: Mapping[str, Motion]) -> dict[str, Array]:
    """Motions as named arrays, for a probe: `torque.step/command`."""
    return {
        f"{name}/{part}": getattr(motion, part)
        for name, motion in moves.items()
        for part in ("command", "q", "qd")
    }
