"""What a joint is told to do: courses of its command, and states that it is put to.

- Courses are one number a physics step. `stepped`, `ramped` and `chirp` are shapes between 0 and 1 (a chirp between
  -1 and 1), as wide as an array; a shape times a torque becomes a command with `command_for`.
- `held_motions` are for drives whose joint is put somewhere before every step: every corner of a law (`torque`),
  and the command's history (`torque.step`, `torque.ramp`), which shows delay and filter.
- `network_courses` are for networks, whose torque is that of a history: errors and speeds that change in every step.
- `actspec.simulate.experiment` lets joints go.

The ranges of the grid are those that approximations are sized over (`actspec.targets.kit.sizes`), so a known
approximation bounds what is seen there. Joint side and SI; numpy alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from actspec.ir import Command, JointActuator
from actspec.laws import TorqueLaw, delay_steps
from actspec.laws.network import NetworkDrive

if TYPE_CHECKING:
    from actspec.laws.arrays import Floats as Array

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
"""Longest history. Chosen: a delay or a filter that takes longer shows in its field alone."""
SETTLED = 5.0
"""Time constants of a filter after which nothing more is to be seen: 0.7 % are left."""


def stepped(n_step: int, at: int = BEFORE) -> Array:
    """A step: 0, and 1 from a step on; shape (n_step,)."""
    import numpy as np

    found: Array = np.where(np.arange(n_step) >= at, 1.0, 0.0)
    return found


def ramped(n_step: int, at: int = BEFORE, over: int = RAMP) -> Array:
    """A ramp: 0, and from a step on up to 1 in so many steps; shape (n_step,)."""
    import numpy as np

    found: Array = np.clip((np.arange(n_step) - at) / over, 0.0, 1.0)
    return found


def chirp(n_step: int, step: float, low: float, high: float) -> Array:
    """A sine from 0 whose frequency grows exponentially over the whole time; shape (n_step,).

    Args:
        n_step: Number of samples.
        step: Between two [s].
        low: First frequency > 0 [rad/s].
        high: Last one > low [rad/s]; keep it below pi / step.
    """
    import numpy as np

    duration, growth = n_step * step, math.log(high / low)
    t = np.arange(n_step) * step
    found: Array = np.sin(low * duration / growth * np.expm1(growth * t / duration))
    return found


def command_for(law: TorqueLaw, torque: Any, q: Any, qd: Any) -> Any:
    """Commands for which the drive without its clamp gives a torque.

    Args:
        law: Of the joint.
        torque: [N*m or N].
        q: True positions [rad or m].
        qd: Speeds [rad/s or m/s].

    Returns:
        Commands [rad or m], [rad/s or m/s] or [N*m or N]; 0, with the position, where a gain is 0.
    """
    if law.command is Command.POSITION:
        return q + law.encoder_bias + ((torque + law.kd * qd) / law.kp if law.kp > 0 else 0.0 * torque)
    if law.command is Command.VELOCITY:
        return torque / law.kd + qd if law.kd > 0 else 0.0 * torque
    return torque + 0.0 * qd


def rest_position(law: TorqueLaw) -> float:
    """Where the joint is, roughly: 0, or the middle of what the command is clamped to [rad or m]."""
    if law.command is not Command.POSITION or law.command_range is None:
        return 0.0
    low, high = law.command_range
    if math.isfinite(low) and math.isfinite(high):
        return 0.5 * (low + high)
    return low if math.isfinite(low) else high if math.isfinite(high) else 0.0


def torque_scale(law: TorqueLaw) -> float:
    """The effort limit; without one the torque of an error of one radian or metre stands in for it [N*m or N]."""
    if math.isfinite(law.effort_limit):
        return law.effort_limit
    return law.kp if law.kp > 0 else (law.kd if law.kd > 0 else 1.0)


def own_speed(law: TorqueLaw) -> float | None:
    """w0: the no-load speed, else the speed at which kd alone takes the whole limit; None: neither [rad/s or m/s]."""
    if law.curve is not None:
        return law.curve[3]
    if law.no_load_speed is not None:
        return law.no_load_speed
    return torque_scale(law) / law.kd if law.kd > 0 else None


def speed_scale(law: TorqueLaw) -> float:
    """`own_speed`, or 1 where there is none: such a law is the same at every speed [rad/s or m/s]."""
    return own_speed(law) or 1.0


def corner_speeds(law: TorqueLaw) -> list[float]:
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


@dataclass(frozen=True, slots=True)
class HeldMotion:
    """Commands, and states that joints are put to before every step.

    Attributes:
        command: In each joint's own unit, shape (n_step, n_env, n_joint).
        q: Positions [rad or m], likewise.
        qd: Speeds [rad/s or m/s], likewise.
    """

    command: Array
    q: Array
    qd: Array

    @property
    def arrays(self) -> tuple[Array, Array, Array]:
        """Command, positions, speeds."""
        return self.command, self.q, self.qd

    def single(self) -> HeldMotion:
        """The same in the digits of single precision, which is what such an engine gets."""
        import numpy as np

        return HeldMotion(*(part.astype(np.float32).astype(float) for part in self.arrays))


HeldMotions = Mapping[str, HeldMotion]
"""By quantity: `torque`, `torque.step` and `torque.ramp`, and `COURSES` of networks."""

COURSES = "torque.course"
"""Quantity of a network."""
COURSE = 24
"""Steps of a course beyond its oldest sample and its delay. Chosen: each of its two sines turns in them."""
ERRORS, SPEED_SHARES = (0.1, 0.5, 2.0), (0.0, 0.3, 1.0, 2.0)
"""Of the largest error in the training data, and of w0: far enough for limits and all four quadrants of a line."""
ERROR = 0.5
"""Stands for the largest error where the manifest does not say [rad or m]. Chosen: that of a walking robot."""
SPEED = 10.0
"""Stands for w0 where neither line nor manifest say [rad/s or m/s]."""


def held_motions(
    laws: Sequence[TorqueLaw], actuators: Sequence[JointActuator], step: float
) -> dict[str, HeldMotion]:
    """A grid of states and histories of the command, the joints in columns.

    - `torque`: one step each, from a history that has settled: torque asked for by velocity, with every corner of
      the law among them (limits, knee, no-load speed, over-speed, both signs); shape (1, n_state, n_joint).
    - `torque.step`: the command steps by what is worth 0.5 L, up and down; shape (n_step, 2, n_joint).
    - `torque.ramp`: it ramps, likewise.

    Args:
        laws: Of the joints.
        actuators: Likewise, for the ranges of their delays.
        step: Physics step [s].
    """
    import numpy as np

    length = min(
        max(_length(law, actuator, step) for law, actuator in zip(laws, actuators, strict=True)), MOST_STEPS
    )
    found = {"torque": [_grid(law) for law in laws]}
    for name, shape in (("torque.step", stepped(length)), ("torque.ramp", ramped(length))):
        found[name] = [_history(law, shape) for law in laws]
    return {
        name: HeldMotion(*(np.stack(columns, axis=2) for columns in zip(*parts, strict=True)))
        for name, parts in found.items()
    }


def network_courses(drives: Sequence[NetworkDrive], step: float) -> HeldMotion:
    """Courses of errors and speeds, from small to twice what the training data held, smooth and in jumps.

    Args:
        drives: Of the joints, the columns.
        step: Physics step [s].
    """
    import numpy as np

    reach = max(max(d.network.taps) + delay_steps(d.clip.delay, step).steps for d in drives)
    k = np.arange(min(reach + COURSE, MOST_STEPS))[:, None]
    size, speed, rough = (
        part.ravel() for part in np.meshgrid(ERRORS, SPEED_SHARES, [False, True], indexing="ij")
    )
    phase = np.arange(size.size)
    # Two sines each, of periods that have no common one; a course in jumps has the signs of the first.
    wave, other = np.sin(0.9 * k + phase), np.sin(0.37 * k + 2.0 * phase)
    shape = np.where(rough, np.sign(wave), 0.6 * wave + 0.4 * other)
    turn = np.where(rough, np.sign(other), 0.6 * np.cos(0.55 * k + phase) + 0.4 * np.cos(0.21 * k))
    columns = []
    for drive in drives:
        clip, most = drive.clip, drive.most or (ERROR, SPEED)
        line = own_speed(clip)
        qd = (most[1] if line is None else line) * speed * turn
        q = rest_position(replace(clip, command=Command.POSITION)) + SWING * np.cos(k + phase)
        columns.append((q + clip.encoder_bias + most[0] * size * shape, q, qd))
    return HeldMotion(*(np.stack(part, axis=2) for part in zip(*columns, strict=True)))


def motion_arrays(motions: HeldMotions) -> dict[str, Array]:
    """Motions as named arrays, for a script: `torque.step/command`."""
    return {
        f"{name}/{part}": array
        for name, motion in motions.items()
        for part, array in zip(("command", "q", "qd"), motion.arrays, strict=True)
    }


def _grid(law: TorqueLaw) -> tuple[Array, Array, Array]:
    import numpy as np

    width, limit = 2.0 * speed_scale(law), torque_scale(law)
    special = [min(speed, width) for speed in corner_speeds(law)]
    # Every joint has as many points: a law with fewer corners has 0 among them more often.
    special += [0.0] * (4 - len(special))
    speeds = np.concatenate([np.linspace(-width, width, SPEEDS), special, np.negative(special)])
    torques, qd = (
        part.ravel() for part in np.meshgrid(np.linspace(-2.0, 2.0, SHARES) * limit, speeds, indexing="ij")
    )
    q = rest_position(law) + SWING * np.cos(np.arange(torques.size))
    return command_for(law, torques, q, qd)[None], q[None], qd[None]


def _history(law: TorqueLaw, shape: Array) -> tuple[Array, Array, Array]:
    """A change of the command that is worth 0.5 L, up and down, at standstill."""
    import numpy as np

    torques = 0.5 * torque_scale(law) * np.stack([shape, -shape], axis=1)
    q, qd = np.full_like(torques, rest_position(law) + HELD), np.zeros_like(torques)
    return command_for(law, torques, q, qd), q, qd


def _length(law: TorqueLaw, actuator: JointActuator, step: float) -> int:
    """Steps until a change of the command has come through."""
    late = max([law.delay, *([actuator.delay.high] if actuator.delay is not None else [])])
    steps = BEFORE + RAMP + 4 + delay_steps(late, step).steps
    if law.filter_cutoff is not None:
        steps += math.ceil(SETTLED / (2.0 * math.pi * law.filter_cutoff * step))
    return steps
