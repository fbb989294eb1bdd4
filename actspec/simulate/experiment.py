"""Joints that are let go: what each is commanded, where it begins, and what its law makes of that.

    experiment = design(actuators, laws)
    moved = experiment.reference([DrivenJoint(law, friction, inertia), ...])

Every joint has a body of its own, J = inertia_held, no gravity, and four courses, sized by its own law:

- `step response`: at rest, the command steps by what is worth 0.5 L.
- `saturated step response`: the same, worth 2 L, so that the limit acts, and at speed the torque-speed line.
- `chirp response`: a sine of 0.25 L that sweeps from a tenth to twice the closed loop's frequency.
- `coast-down`: the command holds the joint where it is, and the joint begins with a speed. A position or velocity
  drive then brakes it too: a file of such drives has no way to switch them off.

A command is one number a physics step. Every joint takes as many steps.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from actspec.ir import ActuatorSet, Command, JointActuator, JointKind
from actspec.laws import TorqueLaw, delay_steps
from actspec.simulate.excitation import BEFORE, chirp, command_for, rest_position, stepped, torque_scale
from actspec.simulate.reference import DrivenJoint, Trajectory, integrate

if TYPE_CHECKING:
    from actspec.laws.arrays import Floats as Array

COURSES = ("step response", "saturated step response", "chirp response", "coast-down")
STEP, SATURATED, CHIRP = 0.5, 2.0, 0.25
"""Of the effort limit. Source: the design's sizes of approximations for the first; chosen for the others: twice the
limit saturates for a while, a quarter leaves the drive linear at resonance unless it is hardly damped."""
PERIODS = 3.0
"""Of the closed loop that a response lasts. Chosen: a drive of damping ratio 0.2 has lost nine tenths of its energy."""
LEAST_STEPS, MOST_STEPS = 100, 300
"""Chosen: enough for a sweep; the reference takes a second and a half of processor time for the most."""
SWEEP = (0.1, 2.0)
"""Of the closed loop's frequency. Source: issue 5 of this project."""
LEAST_CYCLES = 1.5
"""At which the sweep's last frequency would end where it is steady; a slower loop is swept faster. Chosen."""
SAMPLES = 8
"""Least steps in a cycle of the sweep. Chosen: below, a held sine has more of its harmonics than of itself."""
EFFORT_RATE = 2.0 * math.pi * 2.0
"""Stands for the closed loop's frequency where the command is a torque [rad/s]. Chosen: 2 Hz, that of a gait."""
SPEED = 0.5
"""Most of the no-load speed that a coast-down begins with. Chosen."""
PARTS = (1, 2)
"""Into how many steps an engine divides each step, for its two runs."""


@dataclass(frozen=True, slots=True)
class Experiment:
    """Joints, each on a body of its own, and their courses; the joints in columns.

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
    def lags(self) -> list[int]:
        """Nominal delays in steps."""
        return [delay_steps(law.delay, self.step).steps for law in self.laws]

    def job(self) -> dict[str, Any]:
        """What a script in a simulator's environment gets of the joints."""
        commands = [actuator.command.value for actuator in self.joints]
        return {"columns": self.names, "commands": commands, "lags": self.lags, "parts": PARTS}

    def arrays(self) -> dict[str, Array]:
        """The arrays beside it."""
        return {"command": self.command, "q": self.q, "qd": self.qd, "inertia": self.body}

    def reference(self, driven: Sequence[tuple[int, DrivenJoint]]) -> list[Trajectory]:
        """What laws make of all courses, all at once.

        Args:
            driven: Columns, and the law, friction and inertia that take them.

        Returns: One trajectory for each, with the courses in columns.
        """
        import numpy as np

        if not driven:
            return []
        n = len(COURSES)
        command = np.concatenate([self.command[:, :, i] for i, _ in driven], axis=1)
        q, qd = (np.concatenate([part[:, i] for i, _ in driven]) for part in (self.q, self.qd))
        moved = integrate([joint for _, joint in driven for _ in range(n)], command, q, qd, self.step)
        whole = (moved.q, moved.qd, moved.torque)
        return [Trajectory(*(part[:, k * n : (k + 1) * n] for part in whole)) for k in range(len(driven))]


def design(actuators: ActuatorSet, laws: Mapping[str, TorqueLaw]) -> Experiment:
    """The experiment for the joints of a robot.

    Args:
        actuators: Of all joints, with inertia and physics step.
        laws: Of its joints, as far as they have one.
    """
    import numpy as np

    step = actuators.physics_dt.require()
    joints, skipped = [], {}
    for actuator in actuators.joints:
        if actuator.joint not in laws:
            continue
        reason = without_body(actuator)
        if reason is None:
            joints.append(actuator)
        else:
            skipped[actuator.group] = f"{actuator.joint}: {reason}"
    mine = tuple(laws[actuator.joint] for actuator in joints)
    inertia = np.array([_inertia(actuator) for actuator in joints])
    armature = np.array([actuator.armature.value or 0.0 for actuator in joints])
    rates = [closed_loop_rate(law, j) for law, j in zip(mine, inertia, strict=True)]
    length = _length(mine, rates, step)
    courses = [
        _courses(law, actuator, float(j), rate, length, step)
        for law, actuator, j, rate in zip(mine, joints, inertia, rates, strict=True)
    ]
    if not courses:
        nothing = np.empty((len(COURSES), 0))
        return Experiment((), (), inertia, inertia, step, nothing[None], nothing, nothing, skipped)
    command, q, qd = (np.stack(part, axis=-1) for part in zip(*courses, strict=True))
    return Experiment(tuple(joints), mine, inertia, inertia - armature, step, command, q, qd, skipped)


def closed_loop_rate(law: TorqueLaw, inertia: float) -> float:
    """Frequency of the closed loop [rad/s]: natural, or the bandwidth of a velocity drive; of an effort drive 2 Hz."""
    if law.command is Command.POSITION and law.kp > 0.0:
        return math.sqrt(law.kp / inertia)
    if law.command is not Command.EFFORT and law.kd > 0.0:
        return law.kd / inertia
    return EFFORT_RATE


def without_body(actuator: JointActuator) -> str | None:
    """Why a joint cannot be let move on a body of its own; None: it can."""
    held = actuator.inertia_held
    if held is None:
        return "its inertia is unknown without a model"
    armature = actuator.armature.value or 0.0
    if not held.reference > armature:
        return (
            f"its inertia, {held.reference:.4g}, is not more than its armature, {armature:.4g}: "
            "nothing is left for a body"
        )
    return None


def _inertia(actuator: JointActuator) -> float:
    assert actuator.inertia_held is not None
    return actuator.inertia_held.reference


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

    at, limit = rest_position(law), torque_scale(law)
    after = stepped(length)
    end = min(
        max(SWEEP[1] * rate, LEAST_CYCLES * 2.0 * math.pi / (length * step)), 2.0 * math.pi / (SAMPLES * step)
    )
    sweep = chirp(length, step, end * SWEEP[0] / SWEEP[1], end)
    shares = [STEP * after, SATURATED * after, CHIRP * sweep, 0.0 * after]
    command = np.stack(
        [command_for(law, share * limit, np.full(length, at), 0.0 * share) for share in shares], 1
    )
    speeds = np.array([0.0, 0.0, 0.0, _speed(law, actuator, inertia, rate, length * step)])
    return command, np.full(len(COURSES), at), speeds


def _speed(law: TorqueLaw, actuator: JointActuator, inertia: float, rate: float, duration: float) -> float:
    """What a coast-down begins with [rad/s or m/s]."""
    coulomb = actuator.friction_coulomb.value or 0.0
    if law.command is Command.POSITION and law.kp > 0.0:
        # A drive that is not damped would swing as far as a step of 0.5 L goes.
        speed = STEP * torque_scale(law) / law.kp * rate
    elif law.command is not Command.EFFORT and law.kd > 0.0:
        speed = STEP * torque_scale(law) / law.kd
    elif coulomb > 0.0:
        # It stands after half of the time.
        speed = 0.5 * duration * coulomb / inertia
    else:
        speed = 1.0 if actuator.kind is JointKind.HINGE else 0.1
    fastest = law.curve[3] if law.curve is not None else law.no_load_speed
    return speed if fastest is None else min(speed, SPEED * fastest)
