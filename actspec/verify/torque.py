"""Torque agreement: what an engine computes against the law, over the grid of error, velocity and history."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from actspec.ir import ActuatorSet, Command, JointActuator
from actspec.laws import TorqueLaw, delay_steps
from actspec.simulate.excitation import COURSES, HeldMotion, HeldMotions, own_speed, torque_scale
from actspec.simulate.reference import held_torque
from actspec.targets.base import Approximation
from actspec.targets.isaaclab import dialect_for
from actspec.verify.agreement import At, Row, TargetFiles, alike, keys, worst_of
from actspec.verify.engines.asking import EngineAnswer
from actspec.verify.joint_laws import JointLaws

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from actspec.laws.arrays import Floats as Array

DOUBLE = 1e-9
"""Of the effort limit, in double precision. Source: the design, §10; measured at 1e-16."""
SINGLE = 1e-5
"""Of the effort limit, in single precision. Source: the design, §10; measured at 1e-7."""
ROUNDINGS = 4.0
"""Units in the last place that a sum of large terms may be off beside that, of the largest term."""
SLACK = 1.05
"""Times the size of an approximation. Source: `actspec.targets.kit.sizes`: finer grids than that of its size find
a few per cent more, and this one has the corners of the law."""

CONSTANT = (
    "kp",
    "kd",
    "effort_limit",
    "torque_speed_curve",
    "encoder_bias",
    "command_range",
    "friction.viscous",
)
"""Approximations that change the drive's torque whatever the history."""
HISTORY = ("delay", "command_filter", "delay.range", "delay.sampling")
"""Approximations that change it when the command changes."""
HELD = ("delay.range", "delay.sampling")
"""Of these, those that the comparison allows for itself: the nominal delay, or any of a range, is right."""
NONE = "none"
"""What an approximation emits of a field that is lost whole; a delay that is only rounded is rounded in the law too."""


def torque_rows(
    target: TargetFiles,
    actuators: ActuatorSet,
    laws: JointLaws,
    motions: HeldMotions,
    answer: EngineAnswer,
) -> Iterator[Row]:
    """Rows of an engine's torques.

    Args:
        target: What was asked.
        actuators: What the spec asks for.
        laws: Of its joints.
        motions: What the engine was asked.
        answer: What it made of it.
    """
    step = actuators.physics_dt.require()
    asked = {
        name: motion.single() if answer.single else motion
        for name, motion in motions.items()
        if name != COURSES
    }
    for members in alike(actuators):
        known = [member for member in members if member.joint in laws.laws]
        for quantity, motion in asked.items():
            got = answer.torques[quantity]
            judged = (_judge(target, one, laws, quantity, motion, got, answer, step) for one in known)
            yield from worst_of(judged, lambda row: row.ok)


def _judge(
    target: TargetFiles,
    actuator: JointActuator,
    laws: JointLaws,
    quantity: str,
    motion: HeldMotion,
    torque: Array,
    answer: EngineAnswer,
    step: float,
) -> tuple[float, Row]:
    """The row of one joint, and its error in tolerances."""
    import numpy as np

    law, column = laws.laws[actuator.joint], laws.columns[actuator.joint]
    got = torque[:, :, column]
    unit = actuator.effort_limit.unit
    fields = CONSTANT if quantity == "torque" else (*CONSTANT, *HISTORY)
    lost = target.losses_of(actuator.joint, fields)
    if not np.isfinite(got).all():
        what = "the engine has no drive for the joint"
        row = target.fault(quantity, "VFY109", what, actuator=actuator, unit=unit, engine=answer.engine)
        return math.inf, row
    command, q, qd = (part[:, :, column] for part in motion.arrays)
    right = lags(law, actuator, step, ranged=draws(target))
    error = least_error(got, [held_torque(law, command, q, qd, step, lag) for lag in right], actuator)
    strict = _strict(law, motion, column, single=answer.single)
    tolerance = strict
    if not error.max() <= strict:
        # Only where it shows: an approximation elsewhere on the grid does not hide another fault here.
        tolerance = strict + SLACK * _size(lost)
    return row_of(target, actuator, quantity, error, tolerance, law, motion, column, lost, answer.engine)


def row_of(
    target: TargetFiles,
    actuator: JointActuator,
    quantity: str,
    error: Array,
    tolerance: float,
    law: TorqueLaw,
    motion: HeldMotion,
    column: int,
    lost: Sequence[Approximation],
    engine: str,
    than: str = "the law",
) -> tuple[float, Row]:
    """The row of one joint's torque, and its largest error in tolerances.

    Args:
        target: What was compiled.
        actuator: What the spec asks for.
        quantity: Which torque.
        error: Of the engine [N*m or N], (n_step, n_env).
        tolerance: What of it is let pass.
        law: The clip, for what is usual of the motion.
        motion: What was asked, all joints.
        column: The joint's.
        lost: What the target is known to lose of the joint.
        engine: What was run.
        than: What the engine is held to, for the message.
    """
    import numpy as np

    worst, unit = float(error.max()), actuator.effort_limit.unit
    ok = worst <= tolerance
    inside = usual(law, actuator, motion, column)
    # Of equal errors the one that a joint can meet is shown.
    shown = np.where(inside, error, error * (1.0 - SINGLE))
    k, env = (int(i) for i in np.unravel_index(int(shown.argmax()), error.shape))
    row = Row(
        *(target.name, actuator.group, actuator.joint, 1, quantity, unit, worst, tolerance, ok),
        at=at(law, motion, k, env, column),
        approximations=keys(lost),
        engine=engine,
        code=None if ok else "VFY100",
        message="" if ok else f"the torque differs from {than} by {worst:.4g} {unit}",
        usual_error=float(error[inside].max()) if inside.any() else None,
    )
    return worst / tolerance if tolerance > 0.0 else math.inf, row


def usual(law: TorqueLaw, actuator: JointActuator, motion: HeldMotion, column: int) -> NDArray[np.bool_]:
    """Which samples have a command inside its range and a speed that the drive reaches, shape (n_step, n_env).

    The range of a position is that of the command, else the joint's; of a torque the effort limit; of a speed, and for
    the joint's own, the law's (`own_speed`).

    Args:
        law: Of the joint.
        actuator: Likewise.
        motion: What is asked.
        column: The joint's in it.
    """
    import numpy as np

    command, _, qd = (part[:, :, column] for part in motion.arrays)
    speed = own_speed(law) or math.inf
    ends = law.command_range
    if ends is None and law.command is Command.POSITION:
        ends = actuator.position_range
    if ends is None:
        most = {Command.EFFORT: law.effort_limit, Command.VELOCITY: speed}.get(law.command, math.inf)
        ends = -most, most
    found: NDArray[np.bool_] = (ends[0] <= command) & (command <= ends[1]) & (np.abs(qd) <= speed)
    return found


def least_error(got: Array, expected: Sequence[Array], actuator: JointActuator) -> Array:
    """|torque - law|, shape (n_step, n_env); of a drawn delay, the one that fits counts.

    Args:
        got: What the engine says.
        expected: By the law, one of each delay that is right.
        actuator: Of the joint.
    """
    import numpy as np

    differences = np.stack([np.abs(got - law) for law in expected])
    if actuator.delay is not None and actuator.delay.sampling == "step":
        least: Array = differences.min(axis=0)
        return least
    # One delay an episode: an environment has the same in all its steps.
    best = differences.max(axis=1).argmin(axis=0)
    chosen: Array = np.take_along_axis(differences, best[None, None, :], axis=0)[0]
    return chosen


def lags(law: TorqueLaw, actuator: JointActuator, step: float, *, ranged: bool) -> tuple[int, ...]:
    """Delays that are right, in physics steps.

    Args:
        law: Of the joint.
        actuator: Likewise.
        step: Physics step [s].
        ranged: Whether the engine draws a delay from the range; else it has the nominal one.
    """
    delay = actuator.delay
    if ranged and delay is not None and delay.low != delay.high:
        low, high = (delay_steps(end, step).steps for end in (delay.low, delay.high))
        return tuple(range(low, high + 1))
    return (delay_steps(law.delay, step).steps,)


def draws(target: TargetFiles) -> bool:
    """Whether a target draws delays from a range."""
    options = target.options
    if options.kind == "isaaclab":
        return dialect_for(options).lag_range
    return options.kind == "mjlab"


def _strict(law: TorqueLaw, motion: HeldMotion, column: int, *, single: bool) -> float:
    """Largest error of an engine that computes the law [N*m or N]."""
    import numpy as np

    command, q, qd = (part[:, :, column] for part in motion.arrays)
    terms = law.kd * np.abs(qd)
    if law.command is Command.POSITION:
        terms = terms + law.kp * (np.abs(command) + np.abs(q))
    elif law.command is Command.VELOCITY:
        terms = terms + law.kd * np.abs(command)
    rounding = ROUNDINGS * 2.0 ** (-24 if single else -53) * float(terms.max())
    return (SINGLE if single else DOUBLE) * torque_scale(law) + rounding


def _size(lost: Sequence[Approximation]) -> float:
    """Largest torque of all losses together; infinity where one has no size.

    What the spec says is unknown of the joint's own friction is no part of its drive's torque.
    """
    sizes = [
        loss.max_torque_error if loss.beyond is None else max(loss.max_torque_error or 0.0, loss.beyond)
        for loss in lost
        if loss.field not in HELD and (loss.field != "delay" or loss.emitted == NONE) and not loss.open
    ]
    return math.inf if None in sizes else math.fsum(size for size in sizes if size is not None)


def at(law: TorqueLaw, motion: HeldMotion, k: int, env: int, column: int) -> At:
    """A sample of a motion."""
    command, q, qd = (float(part[k, env, column]) for part in motion.arrays)
    error = command - (q + law.encoder_bias) if law.command is Command.POSITION else None
    return At(error, qd, command, k)
