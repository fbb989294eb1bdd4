"""Time responses: what one joint is told to do, with J = inertia_held and no gravity.

- `step response`: at rest, the command steps by what is worth 0.5 L.
- `saturated step response`: the same, worth 2 L, so that the limit acts, and at speed the torque-speed line.
- `chirp response`: a sine of 0.25 L that sweeps from a tenth to twice the closed loop's frequency.
- `coast-down`: the command holds the joint where it is, and the joint begins with a speed. A position or velocity
  drive then brakes it too: a file of such drives has no way to switch them off.

A command is one number a physics step. Every joint of a robot takes as many steps.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from actspec.ir import ActuatorSet, Command, JointActuator, JointKind
from actspec.laws import TorqueLaw, delay_steps
from actspec.verify.motion import commands_for, limit_of, place

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

Friction = tuple[Sequence[float], Sequence[float]]
"""Dry and viscous friction of each joint of a plan [N*m or N], [N*m*s/rad or N*s/m]."""

COURSES = ("step response", "saturated step response", "chirp response", "coast-down")
SOFT = "friction.soft"
"""What MuJoCo's dry friction is known to lose: it is a soft constraint, and creeps. It is no key of `accept`."""
STEP, SATURATED, CHIRP = 0.5, 2.0, 0.25
"""Of the effort limit. Source: the design's sizes of approximations for the first; chosen for the others: twice the
limit saturates for a while, a quarter leaves the drive linear at resonance unless it is hardly damped."""
BEFORE = 2
"""Steps before the command changes."""
PERIODS = 3.0
"""Of the closed loop that a response lasts. Chosen: a drive of damping ratio 0.2 has lost nine tenths of its energy."""
LEAST_STEPS, MOST_STEPS = 100, 300
"""Chosen: enough for a sweep; the reference takes a second and a half of processor time for the most."""
SWEEP = (0.1, 2.0)
"""Of the closed loop's frequency. Source: issue 5 of this project."""
PARTS = (1, 2)
"""Into how many steps each step is divided, for the two runs of an engine."""
LEAST_CYCLES = 1.5
"""At which the sweep's last frequency would end where it is steady; a slower loop is swept faster. Chosen."""
SAMPLES = 8
"""Least steps in a cycle of the sweep. Chosen: below, a held sine has more of its harmonics than of itself."""
EFFORT_RATE = 2.0 * math.pi * 2.0
"""Stands for the closed loop's frequency where the command is a torque [rad/s]. Chosen: 2 Hz, that of a gait."""
SPEED = 0.5
"""Most of the no-load speed that a coast-down begins with. Chosen."""


@dataclass(frozen=True, slots=True)
class Plan:
    """What the joints are told, the joints in columns.

    Attributes:
        joints: Those that have a law and an inertia, in the robot's order.
        laws: Theirs.
        inertia: J, with the armature that the spec asks for [kg*m^2 or kg], shape (n_joint,).
        body: J without it, which is what a body beside the file's own armature must have, likewise.
        step: Physics step [s].
        command: In each joint's own unit, shape (n_step, n_course, n_joint); the courses as in `COURSES`.
        q: Positions at the start [rad or m], shape (n_course, n_joint).
        qd: Speeds at the start [rad/s or m/s], likewise.
        skipped: Why other joints move nowhere, by group.
    """

    joints: tuple[JointActuator, ...]
    laws: tuple[TorqueLaw, ...]
    inertia: Array
    body: Array
    step: float
    command: Array
    q: Array
    qd: Array
    skipped: Mapping[str, str]

    @property
    def names(self) -> list[str]:
        """Of the joints."""
        return [actuator.joint for actuator in self.joints]

    @property
    def commands(self) -> list[str]:
        """What each joint is commanded by."""
        return [actuator.command.value for actuator in self.joints]

    @property
    def lags(self) -> list[int]:
        """Nominal delays in steps."""
        return [delay_steps(law.delay, self.step).steps for law in self.laws]

    def job(self) -> dict[str, Any]:
        """What a probe is told of the joints."""
        return {"columns": self.names, "commands": self.commands, "lags": self.lags, "parts": PARTS}

    def arrays(self) -> dict[str, Array]:
        """What they are told."""
        return {"command": self.command, "q": self.q, "qd": self.qd, "inertia": self.body}


def plan(actuators: ActuatorSet, laws: Mapping[str, TorqueLaw]) -> Plan:
    """What the joints of a robot are told.

    Args:
        actuators: What the spec asks for.
        laws: Of its joints, as far as they have one.
    """
    import numpy as np

    step = actuators.physics_dt.require()
    joints, skipped = [], {}
    for actuator in actuators.joints:
        if actuator.joint not in laws:
            continue
        reason = _immovable(actuator)
        if reason is None:
            joints.append(actuator)
        else:
            skipped[actuator.group] = reason
    mine = tuple(laws[actuator.joint] for actuator in joints)
    inertia = np.array([_inertia(actuator) for actuator in joints])
    armature = np.array([actuator.armature.value or 0.0 for actuator in joints])
    rates = [_rate(law, j) for law, j in zip(mine, inertia, strict=True)]
    length = _length(mine, rates, step)
    told = [
        _courses(law, actuator, float(j), rate, length, step)
        for law, actuator, j, rate in zip(mine, joints, inertia, rates, strict=True)
    ]
    if not told:
        nothing = np.empty((len(COURSES), 0))
        return Plan((), (), inertia, inertia, step, nothing[None], nothing, nothing, skipped)
    command, q, qd = (np.stack(part, axis=-1) for part in zip(*told, strict=True))
    return Plan(tuple(joints), mine, inertia, inertia - armature, step, command, q, qd, skipped)


def _immovable(actuator: JointActuator) -> str | None:
    """Why a joint cannot be let move; None: it can."""
    held = actuator.inertia_held
    if held is None:
        return f"{actuator.joint}: no model says its inertia"
    armature = actuator.armature.value or 0.0
    if not held.reference > armature:
        return (
            f"{actuator.joint}: its inertia, {held.reference:.4g}, is not more than its armature, {armature:.4g}: "
            "nothing is left for a body"
        )
    return None


def _inertia(actuator: JointActuator) -> float:
    assert actuator.inertia_held is not None
    return actuator.inertia_held.reference


def _rate(law: TorqueLaw, inertia: float) -> float:
    """Frequency of the closed loop [rad/s]: natural, or the bandwidth of a velocity drive."""
    if law.command is Command.POSITION and law.kp > 0.0:
        return math.sqrt(law.kp / inertia)
    if law.command is not Command.EFFORT and law.kd > 0.0:
        return law.kd / inertia
    return EFFORT_RATE


def _length(laws: Sequence[TorqueLaw], rates: Sequence[float], step: float) -> int:
    """Steps of every course."""
    longest = 0.0
    for law, rate in zip(laws, rates, strict=True):
        late = BEFORE + min(delay_steps(law.delay, step).steps, MOST_STEPS)
        longest = max(longest, late + PERIODS * 2.0 * math.pi / (rate * step))
    return round(min(max(longest, LEAST_STEPS), MOST_STEPS))


def _courses(
    law: TorqueLaw, actuator: JointActuator, inertia: float, rate: float, length: int, step: float
) -> tuple[Array, Array, Array]:
    """Commands (n_step, n_course), and positions and speeds at the start, of one joint."""
    import numpy as np

    at, limit = place(law), limit_of(law)
    k = np.arange(length)
    after = (k >= BEFORE) * 1.0
    shares = [STEP * after, SATURATED * after, CHIRP * _sweep(rate, length, step), 0.0 * after]
    command = np.stack(
        [commands_for(law, share * limit, np.full(length, at), 0.0 * share) for share in shares], 1
    )
    speeds = np.array([0.0, 0.0, 0.0, _speed(law, actuator, inertia, rate, length * step)])
    return command, np.full(len(COURSES), at), speeds


def _sweep(rate: float, length: int, step: float) -> Array:
    """A sine whose frequency grows exponentially, from 0."""
    import numpy as np

    duration = length * step
    highest = 2.0 * math.pi / (SAMPLES * step)
    end = min(max(SWEEP[1] * rate, LEAST_CYCLES * 2.0 * math.pi / duration), highest)
    growth = math.log(SWEEP[1] / SWEEP[0])
    t = np.arange(length) * step
    phase = end * math.exp(-growth) * duration / growth * np.expm1(growth * t / duration)
    found: Array = np.sin(phase)
    return found


def _speed(law: TorqueLaw, actuator: JointActuator, inertia: float, rate: float, duration: float) -> float:
    """What a coast-down begins with [rad/s or m/s]."""
    coulomb = actuator.friction_coulomb.value or 0.0
    if law.command is Command.POSITION and law.kp > 0.0:
        # A drive that is not damped would swing as far as a step of 0.5 L goes.
        speed = STEP * limit_of(law) / law.kp * rate
    elif law.command is not Command.EFFORT and law.kd > 0.0:
        speed = STEP * limit_of(law) / law.kd
    elif coulomb > 0.0:
        # It stands after half of the time.
        speed = 0.5 * duration * coulomb / inertia
    else:
        speed = 1.0 if actuator.kind is JointKind.HINGE else 0.1
    fastest = law.curve[3] if law.curve is not None else law.no_load_speed
    return speed if fastest is None else min(speed, SPEED * fastest)


@dataclass(frozen=True, slots=True)
class Responded:
    """What an engine made of a plan.

    Attributes:
        engine: Its name and version.
        single: Whether it computes in single precision.
        q: Positions at the start of each step and at the end [rad or m], shape (n_step + 1, n_course, n_joint);
            NaN from where the engine gives up.
        halved: The same in steps of half the length, the delay the same in seconds.
        torque: Of the drive at the start of each step [N*m or N], shape (n_step, n_course, n_joint).
        errors: Why joints could not be asked.
    """

    engine: str
    single: bool
    q: Array
    halved: Array
    torque: Array
    errors: Mapping[str, str]


def responded(engine: str, said: Mapping[str, Any], out: Mapping[str, Array], *, single: bool) -> Responded:
    """A probe's arrays as an answer."""
    errors = said.get("errors", {})
    return Responded(engine, single, out["q1"], out["q2"], out["torque1"], errors)
