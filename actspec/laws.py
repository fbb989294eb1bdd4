"""The torque laws: the reference that every target is held to.

Pure functions over arrays: numpy, torch, jax or any array-API library in, the same out; Python
floats are computed by numpy. Everything is joint side and SI: torques [N*m] at a hinge and
[N] at a slide, positions [rad or m], speeds [rad/s or m/s]; positive speed and positive torque
point the same way. Shapes broadcast; a result has the broadcast shape of the arguments.

Order of one physics step: command clamp, delay, filter (`step_command`), PD, drive clamp
(`TorqueLaw.torque`); the passive part (`passive_torque`) is added outside of every clamp.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from functools import reduce
from typing import Any, NamedTuple

from actspec.ir import AsymmetricCurve, Command, JointActuator, Level, Quantity

Array = Any
"""An array of any library, or a Python number."""

MAX_DELAY_STEPS = 1_000_000
"""Longest delay line, so that a delay of years in a stranger's file cannot fill the memory. Chosen."""


def array_namespace(*arrays: Array) -> Any:
    """The module whose functions fit the arguments.

    Args:
        arrays: Arrays, or Python numbers, which fit every library.

    Returns:
        What an array's `__array_namespace__` says, `torch` for torch tensors, else `numpy`.

    Raises:
        TypeError: arrays of two libraries.
    """
    found: dict[str, Any] = {}
    for array in arrays:
        if isinstance(array, int | float):
            continue
        namespace: Any = None
        if any(c.__module__.partition(".")[0] == "torch" for c in type(array).__mro__):
            namespace = sys.modules["torch"]  # its tensor is here, so it is imported
        elif hasattr(array, "__array_namespace__"):
            namespace = array.__array_namespace__()
        if namespace is None:
            import numpy as namespace
        found[namespace.__name__] = namespace
    if len(found) > 1:
        raise TypeError(f"arrays of two libraries: {', '.join(sorted(found))}")
    if found:
        return next(iter(found.values()))
    import numpy as np

    return np


def _same(*values: Array) -> tuple[Any, tuple[Array, ...]]:
    """The namespace, and the values as its arrays: numbers take the arrays' float type and device."""
    xp = array_namespace(*values)
    arrays = [v for v in values if not isinstance(v, int | float)]
    # By name, because libraries share no other test that old versions have too.
    floating = [a.dtype for a in arrays if "float" in str(getattr(a, "dtype", ""))]
    promote = getattr(xp, "promote_types", None) or xp.result_type
    options: dict[str, Any] = {"dtype": reduce(promote, floating)} if floating else {}
    if xp.__name__ == "torch":
        if not floating:
            options["dtype"] = xp.get_default_dtype()
        options["device"] = arrays[0].device

    def array(value: Array) -> Array:
        if isinstance(value, int | float):
            return xp.asarray(float(value), **options)
        # Arrays pass untouched: torch's asarray may cut a tensor off its gradient.
        return value if hasattr(value, "dtype") else xp.asarray(value)

    return xp, tuple(array(v) for v in values)


def _out(xp: Any, array: Array) -> Array:
    """The result; numpy's arrays without dimensions become scalars, as from numpy's own functions."""
    return array[()] if xp.__name__ == "numpy" else array


# Drive, before the clamp


def position_pd(
    target: Array,
    q: Array,
    qd: Array,
    *,
    kp: Array,
    kd: Array,
    target_qd: Array = 0.0,
    feedforward: Array = 0.0,
    encoder_bias: Array = 0.0,
) -> Array:
    """Torque of a position drive: kp (a - q_m) + kd (qd* - qd) + tau_ff.

    Args:
        target: Effective command a, after delay and filter [rad or m].
        q: True position [rad or m].
        qd: Speed [rad/s or m/s].
        kp: Drive stiffness [N*m/rad or N/m].
        kd: Drive velocity gain [N*m*s/rad or N*s/m].
        target_qd: Speed command qd* [rad/s or m/s].
        feedforward: Added torque tau_ff [N*m or N].
        encoder_bias: What the encoder adds to the true position, q_m = q + bias [rad or m]:
            a positive bias pulls the joint down, by kp * bias.

    Returns:
        Torque before any clamp [N*m or N], positive towards a target above q.

    Source:
        DESIGN section 5; Isaac Lab 2.3.2 IdealPDActuator has the same sum without the bias,
        MuJoCo `<position>` the same without qd* and tau_ff. Bias as PACE's commit 7e815b6
        (its later commits subtract).
    """
    xp, (a, x, w, p, d, wd, ff, bias) = _same(target, q, qd, kp, kd, target_qd, feedforward, encoder_bias)
    return _out(xp, p * (a - (x + bias)) + d * (wd - w) + ff)


def velocity_pd(target_qd: Array, qd: Array, *, kd: Array, feedforward: Array = 0.0) -> Array:
    """Torque of a velocity drive: kd (qd* - qd) + tau_ff.

    Args:
        target_qd: Effective command, after delay and filter [rad/s or m/s].
        qd: Speed [rad/s or m/s].
        kd: Drive velocity gain [N*m*s/rad or N*s/m].
        feedforward: Added torque [N*m or N].

    Returns:
        Torque before any clamp [N*m or N], positive where the target is faster than the joint.

    Source:
        DESIGN section 5; MuJoCo `<velocity>`.
    """
    xp, (wd, w, d, ff) = _same(target_qd, qd, kd, feedforward)
    return _out(xp, d * (wd - w) + ff)


# Clamps


def clip_effort(tau: Array, *, effort_limit: Array) -> Array:
    """Clip torque to +- the drive's limit, at every speed.

    Args:
        tau: Torque asked for [N*m or N].
        effort_limit: L >= 0 [N*m or N]; infinity: no limit.

    Returns:
        Torque within +- L [N*m or N].

    Source:
        DESIGN section 5, `ideal_pd`; Isaac Lab 2.3.2 IdealPDActuator; MuJoCo `forcerange`.
    """
    xp, (t, limit) = _same(tau, effort_limit)
    return _out(xp, _between(xp, t, -limit, limit))


def clip_dc_motor(
    tau: Array, qd: Array, *, stall_torque: Array, no_load_speed: Array, effort_limit: Array
) -> Array:
    """Clip torque to a DC motor's torque-speed line, in four quadrants.

    w is clipped at +- w0 (1 + L/ts); then hi = min(L, ts (1 - w/w0)), lo = max(-L, ts (-1 - w/w0)).
    Braking has the whole L at hand, and above no-load speed hi is negative: the motor brakes
    whatever is asked. The line only moves the knee where ts > L. (The symmetric
    ts (1 - |w|/w0), seen in the wild, takes the torque away from braking too.)

    Args:
        tau: Torque asked for [N*m or N].
        qd: Speed [rad/s or m/s].
        stall_torque: ts > 0, the line at zero speed [N*m or N].
        no_load_speed: w0 > 0, the line at zero torque [rad/s or m/s].
        effort_limit: L >= 0 [N*m or N]; infinity: the line alone.

    Returns:
        Torque within lo and hi [N*m or N].

    Source:
        DESIGN section 5, `dc_motor`; Isaac Lab >= 2.2 DCMotor, mjlab 1.6 DcMotorActuator and
        Newton ClampingDCMotor compute the same. (Isaac Lab 2.0 and 2.1 have two quadrants.)
    """
    xp, (t, w, ts, w0, limit) = _same(tau, qd, stall_torque, no_load_speed, effort_limit)
    fastest = w0 * (1.0 + limit / ts)
    x = _between(xp, w, -fastest, fastest) / w0
    hi = xp.minimum(limit, ts * (1.0 - x))
    lo = xp.maximum(-limit, ts * (-1.0 - x))
    return _out(xp, _between(xp, t, lo, hi))


def clip_asymmetric(
    tau: Array,
    qd: Array,
    *,
    drive_torque: Array,
    brake_torque: Array,
    knee_speed: Array,
    no_load_speed: Array,
    effort_limit: Array,
) -> Array:
    """Clip torque to a curve with different drive and brake torque.

    base = drive_torque where tau * w > 0, else brake_torque (tau * w = 0: brake); from the knee
    on, base falls linearly to 0 at no-load speed, braking too; then clip to +- min(base, L).

    Args:
        tau: Torque asked for [N*m or N]; its sign, before the clip, chooses the base.
        qd: Speed [rad/s or m/s].
        drive_torque: >= 0 [N*m or N].
        brake_torque: >= 0 [N*m or N].
        knee_speed: Speed up to which the base is whole, >= 0 [rad/s or m/s].
        no_load_speed: Speed from which nothing is left, >= knee_speed [rad/s or m/s]. Equal to
            the knee: a cliff, whole up to and at that speed.
        effort_limit: L >= 0 [N*m or N]; infinity: the curve alone.

    Returns:
        Torque within +- min(base, L) [N*m or N].

    Source:
        DESIGN section 5, asymmetric curve; unitree_rl_lab UnitreeActuator (Y1, Y2, X1, X2), whose
        friction is left out here: it stands outside the clamp.
    """
    xp, (t, w, drive, brake, knee, w0, limit) = _same(
        tau, qd, drive_torque, brake_torque, knee_speed, no_load_speed, effort_limit
    )
    base = xp.where(t * w > 0, drive, brake)
    speed, span = xp.abs(w), w0 - knee
    one, zero = xp.ones_like(span), xp.zeros_like(span)
    slope = 1.0 - (speed - knee) / xp.where(span > 0, span, one)
    cliff = xp.where(speed > knee, zero, one)
    left = xp.where(span > 0, _between(xp, slope, zero, one), cliff)
    bound = xp.minimum(base * left, limit)
    return _out(xp, _between(xp, t, -bound, bound))


def clip_command(command: Array, *, low: Array, high: Array) -> Array:
    """Clamp a command to the spec's `command_range`; before delay and filter.

    Args:
        command: [rad or m], [rad/s or m/s] or [N*m or N].
        low: Least command, in the command's unit.
        high: Largest command, in the command's unit.

    Returns:
        The command within the range.

    Source:
        DESIGN section 5; MuJoCo `ctrlrange`. Before or after the delay is the same.
    """
    xp, (u, lo, hi) = _same(command, low, high)
    return _out(xp, _between(xp, u, lo, hi))


def _between(xp: Any, value: Array, low: Array, high: Array) -> Array:
    # Not `clip`: its arguments differ between the libraries.
    return xp.minimum(xp.maximum(value, low), high)


# Passive part


def passive_torque(
    qd: Array,
    *,
    coulomb: Array,
    viscous: Array,
    static: Array | None = None,
    stribeck_velocity: Array | None = None,
) -> Array:
    """Torque of passive friction on the joint; add it outside of every clamp.

    -(Fc + (Fs - Fc) exp(-(|w|/ws)^2)) sign(w) - b w; without a Stribeck velocity
    -Fc sign(w) - b w. At w = 0 it is 0: holding a joint still is the engine's constraint.

    Args:
        qd: Speed w [rad/s or m/s].
        coulomb: Kinetic dry friction Fc >= 0 [N*m or N].
        viscous: b >= 0 [N*m*s/rad or N*s/m].
        static: Break-away friction Fs [N*m or N]; None: Fc. Used with a Stribeck velocity only.
        stribeck_velocity: ws > 0 [rad/s or m/s]; None: no Stribeck effect.

    Returns:
        Torque against the motion [N*m or N]: negative for positive speed.

    Source:
        DESIGN section 5; B. Armstrong-Helouvry, P. Dupont, C. Canudas de Wit, Automatica 30
        (1994) 1083, the Gaussian form of the Stribeck curve.
    """
    if static is None or stribeck_velocity is None:
        xp, (w, fc, b) = _same(qd, coulomb, viscous)
        return _out(xp, -fc * xp.sign(w) - b * w)
    xp, (w, fc, b, fs, ws) = _same(qd, coulomb, viscous, static, stribeck_velocity)
    dry = fc + (fs - fc) * xp.exp(-((w / ws) ** 2))
    return _out(xp, -dry * xp.sign(w) - b * w)


# Command path


def filter_gain(cutoff: float, step: float) -> float:
    """Share of the way that a first-order low-pass goes in one step.

    alpha = 1 - exp(-h/tau), tau = 1/(2 pi cutoff).

    Args:
        cutoff: -3 dB frequency > 0 [Hz], not [rad/s].
        step: Time step h > 0 [s].

    Returns:
        alpha, above 0 and at most 1.

    Raises:
        ValueError: cutoff or step is not positive and finite.

    Source:
        DESIGN section 5; MuJoCo `dyntype="filterexact"` (`filter` has h/tau, which diverges for h > 2 tau).
    """
    _require_positive("cutoff", cutoff, "Hz")
    _require_positive("step", step, "s")
    return -math.expm1(-2.0 * math.pi * cutoff * step)


class DelaySteps(NamedTuple):
    """A delay in whole steps.

    Attributes:
        steps: Number of steps.
        loss: steps * h - delay [s]; positive: later than asked for.
    """

    steps: int
    loss: float


def delay_steps(delay: float, step: float) -> DelaySteps:
    """Round a delay to the nearest whole number of steps; half a step rounds up.

    Args:
        delay: >= 0 [s].
        step: Time step h > 0 [s].

    Returns:
        The steps, and what the rounding costs [s].

    Raises:
        ValueError: delay negative, not finite or above `MAX_DELAY_STEPS`, or step not positive and finite.

    Source:
        DESIGN section 5, n = delay/h. Half up is chosen: MuJoCo's zero-order hold rounds 2.5 steps up to 3.
    """
    _require_positive("step", step, "s")
    if not (math.isfinite(delay) and delay >= 0):
        raise ValueError(f"delay must be finite and >= 0 s, got {delay:g} s")
    if delay / step > MAX_DELAY_STEPS:
        raise ValueError(f"delay must be at most {MAX_DELAY_STEPS} steps of {step:g} s, got {delay:g} s")
    # The quotient of two decimals may come out a hair below the half, the loss a hair off zero.
    steps = math.floor(delay / step + 0.5 + 1e-9)
    loss = steps * step - delay
    return DelaySteps(steps, 0.0 if abs(loss) < 1e-9 * step else loss)


@dataclass(frozen=True, slots=True)
class CommandState:
    """What the command path remembers between two steps.

    Attributes:
        line: Commands on their way through the delay, oldest first, newest last; as many as delay steps.
        filtered: Filter state a_k, in the command's unit.
    """

    line: tuple[Array, ...]
    filtered: Array


def initial_command_state(first_command: Array, steps: int) -> CommandState:
    """State before the first step: the line is full of the first command, and a_0 is it.

    Args:
        first_command: First command of the episode, in the command's unit.
        steps: Delay in steps, >= 0.

    Returns:
        The state.

    Raises:
        ValueError: steps is negative or above `MAX_DELAY_STEPS`.

    Source:
        DESIGN section 5. (MuJoCo after a bare reset starts both at 0, and the robot jumps.)
    """
    if not 0 <= steps <= MAX_DELAY_STEPS:
        raise ValueError(f"delay must be 0 to {MAX_DELAY_STEPS} steps, got {steps}")
    command = _kept(first_command)
    return CommandState((command,) * steps, command)


def step_command(
    state: CommandState, command: Array, *, steps: int, alpha: Array | None
) -> tuple[Array, CommandState]:
    """One step of the command path: delay, then filter.

    u_k is the command of `steps` steps ago. The torque of step k uses a_k before its update,
    a_(k+1) = a_k + alpha (u_k - a_k); without a filter it uses u_k itself.

    Args:
        state: State before the step.
        command: Command of this step, in the command's unit.
        steps: Delay in steps, as in `initial_command_state`.
        alpha: Share of `filter_gain`; None: no filter.

    Returns:
        The effective command of this step, and the state for the next one.

    Raises:
        ValueError: `steps` is not the length of the state's line.

    Source:
        DESIGN section 5; MuJoCo `filterexact` with `actearly` false, and its native delay.
    """
    if steps != len(state.line):
        raise ValueError(f"the state holds a delay of {len(state.line)} steps, asked for {steps}")
    newest = _kept(command)
    line = (*state.line, newest)
    u, line = line[0], line[1:]
    if alpha is None:
        return u, CommandState(line, u)
    xp, (a, target, share) = _same(state.filtered, u, alpha)
    return state.filtered, CommandState(line, _out(xp, a + share * (target - a)))


def _kept(command: Array) -> Array:
    """A copy: callers reuse their command buffer, and the line must not change with it."""
    copy = getattr(command, "clone", None) or getattr(command, "copy", None)
    return command if copy is None else copy()


# One actuator


@dataclass(frozen=True, slots=True)
class TorqueLaw:
    """The law of one joint's drive, without its passive part; joint side, SI.

    Attributes:
        command: What the command means.
        kp: [N*m/rad or N/m]; 0 unless the command is a position.
        kd: [N*m*s/rad or N*s/m]; 0 for an effort command.
        effort_limit: L [N*m or N]; infinity where it is unknown.
        stall_torque: The line at zero speed [N*m or N]; None without a line.
        no_load_speed: The line at zero torque [rad/s or m/s]; None without a line.
        curve: drive_torque, brake_torque [N*m or N], knee_speed, no_load_speed [rad/s or m/s];
            None without a curve.
        encoder_bias: q_measured = q + bias [rad or m].
        filter_cutoff: [Hz]; None without a filter.
        delay: Nominal delay [s].
        command_range: Low and high, in the command's unit; None: no clamp.
    """

    command: Command
    kp: float
    kd: float
    effort_limit: float
    stall_torque: float | None
    no_load_speed: float | None
    curve: tuple[float, float, float, float] | None
    encoder_bias: float
    filter_cutoff: float | None
    delay: float
    command_range: tuple[float, float] | None = None

    def torque(self, command: Array, q: Array, qd: Array) -> Array:
        """Torque of the drive at one state, clamped; the passive part is not in it.

        Args:
            command: Effective command, after clamp, delay and filter
                [rad or m], [rad/s or m/s] or [N*m or N].
            q: True position [rad or m]; no part unless the command is a position.
            qd: Speed [rad/s or m/s].

        Returns:
            Torque [N*m or N].

        Source:
            DESIGN section 5.
        """
        if self.command is Command.POSITION:
            tau = position_pd(command, q, qd, kp=self.kp, kd=self.kd, encoder_bias=self.encoder_bias)
        elif self.command is Command.VELOCITY:
            tau = velocity_pd(command, qd, kd=self.kd)
        else:
            tau = command
        if self.curve is not None:
            drive, brake, knee, no_load = self.curve
            return clip_asymmetric(
                tau,
                qd,
                drive_torque=drive,
                brake_torque=brake,
                knee_speed=knee,
                no_load_speed=no_load,
                effort_limit=self.effort_limit,
            )
        if self.stall_torque is not None and self.no_load_speed is not None:
            return clip_dc_motor(
                tau,
                qd,
                stall_torque=self.stall_torque,
                no_load_speed=self.no_load_speed,
                effort_limit=self.effort_limit,
            )
        return clip_effort(tau, effort_limit=self.effort_limit)


def law_of(actuator: JointActuator) -> TorqueLaw:
    """The torque law of one joint's actuator.

    What is unknown: the effort limit counts as infinite; filter, delay, encoder bias and an
    end of the command range as not there, as in a target that emits nothing for them. A gain or
    a point of the torque-speed curve has no such reading.

    Args:
        actuator: From `resolve` or `lift`.

    Returns:
        The law.

    Raises:
        ValueError: level `actuator_net`; a gain, line or curve that the level needs is unknown;
            a negative limit, or a line or curve that is none.

    Source:
        DESIGN sections 4 and 5.
    """
    name = actuator.joint
    if actuator.level is Level.ACTUATOR_NET:
        raise ValueError(f"{name}: level actuator_net has no torque law here: its torque is the network's")
    kp = kd = 0.0
    if actuator.command is Command.POSITION:
        kp = _known(actuator, "kp", actuator.kp)
    if actuator.command is not Command.EFFORT:
        kd = _known(actuator, "kd", actuator.kd)
    limit = actuator.effort_limit.value
    if limit is not None and not limit >= 0:
        raise ValueError(f"{name}: effort_limit must be >= 0 {actuator.effort_limit.unit}, got {limit:g}")

    stall = no_load = None
    curve = None
    if actuator.level is Level.DC_MOTOR and actuator.curve is not None:
        curve = _curve(actuator, actuator.curve)
    elif actuator.level is Level.DC_MOTOR:
        stall = _known(actuator, "stall_torque", actuator.stall_torque)
        no_load = _known(actuator, "no_load_speed", actuator.no_load_speed)
        if not (stall > 0 and no_load > 0):
            raise ValueError(
                f"{name}: stall_torque and no_load_speed must be > 0, got {stall:g} and {no_load:g}"
            )

    ends = actuator.command_range
    return TorqueLaw(
        command=actuator.command,
        kp=kp,
        kd=kd,
        effort_limit=math.inf if limit is None else limit,
        stall_torque=stall,
        no_load_speed=no_load,
        curve=curve,
        encoder_bias=_or(actuator.encoder_bias, 0.0),
        filter_cutoff=None if actuator.filter_cutoff is None else actuator.filter_cutoff.value,
        delay=0.0 if actuator.delay is None else _or(actuator.delay.nominal, 0.0),
        command_range=None if ends is None else (_or(ends[0], -math.inf), _or(ends[1], math.inf)),
    )


def _curve(actuator: JointActuator, curve: AsymmetricCurve) -> tuple[float, float, float, float]:
    drive = _known(actuator, "curve.drive_torque", curve.drive_torque)
    brake = _known(actuator, "curve.brake_torque", curve.brake_torque)
    knee = _known(actuator, "curve.knee_speed", curve.knee_speed)
    no_load = _known(actuator, "curve.no_load_speed", curve.no_load_speed)
    if not (drive >= 0 and brake >= 0):
        raise ValueError(
            f"{actuator.joint}: curve.drive_torque and brake_torque must be >= 0, got {drive:g} and {brake:g}"
        )
    if not 0 <= knee <= no_load:
        raise ValueError(
            f"{actuator.joint}: curve.knee_speed must be from 0 to no_load_speed, "
            f"got {knee:g} with no_load_speed {no_load:g}"
        )
    return drive, brake, knee, no_load


def _known(actuator: JointActuator, field: str, quantity: Quantity | None) -> float:
    if quantity is None or quantity.value is None:
        needs = f"level {actuator.level.value} with command {actuator.command.value}"
        raise ValueError(f"{actuator.joint}: {field} is unknown, {needs} needs it")
    return quantity.value


def _or(quantity: Quantity, default: float) -> float:
    return default if quantity.value is None else quantity.value


def _require_positive(name: str, value: float, unit: str) -> None:
    if not (math.isfinite(value) and value > 0):
        raise ValueError(f"{name} must be finite and > 0 {unit}, got {value:g} {unit}")
