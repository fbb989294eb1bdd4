"""The formulas of a drive: torque before the clamp, clamps, passive part."""

from __future__ import annotations

from actspec.laws.arrays import Array, between, out, same


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
    xp, (a, x, w, p, d, wd, ff, bias) = same(target, q, qd, kp, kd, target_qd, feedforward, encoder_bias)
    return out(xp, p * (a - (x + bias)) + d * (wd - w) + ff)


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
    xp, (wd, w, d, ff) = same(target_qd, qd, kd, feedforward)
    return out(xp, d * (wd - w) + ff)


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
    xp, (t, limit) = same(tau, effort_limit)
    return out(xp, between(xp, t, -limit, limit))


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
    xp, (t, w, ts, w0, limit) = same(tau, qd, stall_torque, no_load_speed, effort_limit)
    fastest = w0 * (1.0 + limit / ts)
    x = between(xp, w, -fastest, fastest) / w0
    hi = xp.minimum(limit, ts * (1.0 - x))
    lo = xp.maximum(-limit, ts * (-1.0 - x))
    return out(xp, between(xp, t, lo, hi))


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
    xp, (t, w, drive, brake, knee, w0, limit) = same(
        tau, qd, drive_torque, brake_torque, knee_speed, no_load_speed, effort_limit
    )
    base = xp.where(t * w > 0, drive, brake)
    speed, span = xp.abs(w), w0 - knee
    one, zero = xp.ones_like(span), xp.zeros_like(span)
    slope = 1.0 - (speed - knee) / xp.where(span > 0, span, one)
    cliff = xp.where(speed > knee, zero, one)
    left = xp.where(span > 0, between(xp, slope, zero, one), cliff)
    bound = xp.minimum(base * left, limit)
    return out(xp, between(xp, t, -bound, bound))


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
        xp, (w, fc, b) = same(qd, coulomb, viscous)
        return out(xp, -fc * xp.sign(w) - b * w)
    xp, (w, fc, b, fs, ws) = same(qd, coulomb, viscous, static, stribeck_velocity)
    dry = fc + (fs - fc) * xp.exp(-((w / ws) ** 2))
    return out(xp, -dry * xp.sign(w) - b * w)
