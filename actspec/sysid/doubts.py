"""What contradicts a fit from outside of it: the torque's scale against known masses, and gains against stated ones.

A fit takes the logged torque at its word: where its scale is off, kp, kd and friction are off by the same factor, and
nothing in the fit shows it. Gravity, and what other joints do to this one, are torques that the model knows.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, listed
from actspec.fields import units_of
from actspec.sysid.descent import simulated
from actspec.sysid.drift import judge_drift
from actspec.sysid.identified import Indicator, JointFit, State
from actspec.sysid.judge import GAINS_SENT, UNLIKE, held_gains
from actspec.sysid.system import System
from actspec.sysid.work import JointInWork, piecewise
from actspec.units import format_number

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

MOVES = 0.1
"""Share of the greatest speed above which friction has its sign."""
TOLD = 0.05
"""Standard deviation of a torque's scale above which nothing is reported of it. Chosen."""
FAR = 0.03
"""How far from 1 a scale may be beside twice its standard deviation. Chosen: masses of a model are no better."""
GROSS = (0.6, 1.5)
"""Scales beyond which no figure of a fit means anything. Chosen: see `FILTERED`."""
FILTERED = (0.8, 1.1)
"""What filtered readings alone make of a scale of 1. Measured."""
GONE = 0.25
"""Position error, as a share of the joint's motion, from which on the model moves otherwise. Measured: play, stiction
and a torque twice too large leave less than 0.1; a command that the drive did not get, or columns of another joint,
0.3 to 0.6."""
SAME = 0.05
"""Likewise of a fitted gain from a stated one, beside its interval. Chosen."""
NEAR = 0.06
"""How near a factor must be to one of a unit or a gear. Chosen."""
DRIVE_UNITS = {180.0 / math.pi: "per degree", 2.0 * math.pi: "per turn", 1e3: "in thousandths"}
"""Factors of a gain to what they are the mark of."""
SPEED_UNITS = {30.0 / math.pi: "per rpm", 180.0 / math.pi: "per degree/s", 2.0 * math.pi: "per turn/s"}
"""Likewise of kd alone."""


@dataclass(frozen=True, slots=True)
class Scale:
    """The logged torque over the true one.

    Attributes:
        value: Factor.
        std: Its standard deviation.
        offset: What is logged at no torque [N*m or N].
    """

    value: float
    std: float
    offset: float

    @property
    def shown(self) -> str:
        """The factor with twice its standard deviation."""
        return f"{format_number(self.value, 3)} +- {format_number(2.0 * self.std, 1)}"


def doubted(
    joint: JointInWork, found: JointFit, system: System, out: Collector, askew: bool = False
) -> JointFit:
    """A joint's fit with what speaks against it, by the residuals where it ended.

    Args:
        joint: After its fit.
        found: What is said of it.
        system: Residuals, and their derivatives.
        out: Takes warnings.
        askew: Whether its angles are known to be others than the model's, which makes the torque's scale wrong.
    """
    unit = next(p.unit for p in found.parameters if p.field == "friction.coulomb")
    judge_drift(joint, system, unit, out)
    scale = torque_scale(joint) if joint.torque else None
    if scale is not None:
        # The masses that it is held against are known no better than the sidecar says.
        masses = max(_ratio(recording.log.sidecar.accuracy.masses) for recording in joint.recordings)
        spread = math.hypot(scale.std, masses * scale.value)
        read = (
            Indicator("torque_scale", scale.value, spread, "1"),
            Indicator("torque_offset", scale.offset, None, unit),
        )
        found = replace(found, diagnostics=(*found.diagnostics, *read))
        if not askew:
            _judge_scale(joint, scale, out)
    if joint.torque:
        _judge_gains(joint, found, scale, out)
    _judge_motion(joint, found, out)
    return found


def judge_torques(joints: Iterable[JointInWork], out: Collector) -> None:
    """The logged torques against the masses along the motion that was read, before a fit takes them at their word.

    Those that a gear explains are told once, for it is one mistake.
    """
    behind: list[tuple[JointInWork, Scale]] = []
    for joint in joints:
        solved = _read_scale(joint)
        if solved is None or solved[1] > TOLD or GROSS[0] < solved[0] < GROSS[1]:
            continue
        scale = Scale(*solved, 0.0)
        if _at_motor(scale, joint.actuator.gear):
            behind.append((joint, scale))
        else:
            _judge_scale(joint, scale, out)
    if not behind:
        return
    shown, times = [], []
    for gear in dict.fromkeys(joint.actuator.gear for joint, _ in behind):
        assert gear is not None
        mine = [(joint.actuator.joint, scale) for joint, scale in behind if joint.actuator.gear == gear]
        factor = format_number(gear, 4)
        shown.append(f"1/{factor} ({listed(f'{name}: {scale.shown}' for name, scale in mine)})")
        times.append(f"{listed(name for name, _ in mine)} by {factor}")
    message = (
        f"the torque is about {' and '.join(shown)} of what the model's masses need, as the spec's gear has it: "
        "it is likely that on the motor's side"
    )
    help = (
        f"multiply the torque of {', of '.join(times)}, and by the gear's efficiency where the motor drives"
    )
    first = behind[0][0]
    names = listed(joint.actuator.joint for joint, _ in behind)
    out.error("SYS018", message, where=names, span=Span(first.recordings[0].log.path), help=help)


def _at_motor(scale: Scale, gear: float | None) -> bool:
    """Whether a torque is one over the gear's ratio of that at the joint, as far as readings tell."""
    if gear is None:
        return False
    least, most = FILTERED
    return least <= (scale.value + 2.0 * scale.std) * gear and (scale.value - 2.0 * scale.std) * gear <= most


def _read_scale(joint: JointInWork) -> tuple[float, float] | None:
    """The logged torque over what the masses need along the motion that was read, and its standard deviation."""
    import numpy as np

    blocks = []
    for recording, course in zip(joint.recordings, joint.courses, strict=True):
        if "torque" not in recording.measured:
            continue
        fastest = float(np.abs(recording.velocity).max())
        for start in recording.starts:
            rows = slice(start, start + recording.rows)
            qd, acceleration = recording.velocity[rows], recording.acceleration[rows]
            known = course.inertia[rows] * acceleration + course.load[rows]
            blocks += _block(known, acceleration, qd, recording.measured["torque"][rows], fastest)
    return _regressed(blocks)


def _block(
    known: Array, acceleration: Array, qd: Array, read: Array, fastest: float
) -> list[tuple[Array, Array]]:
    """A piece's terms and its torque, where the joint moves; none where it hardly does."""
    import numpy as np

    terms = np.stack([known, acceleration, np.sign(qd), qd, np.ones_like(qd)], axis=1)
    used = np.isfinite(read) & (np.abs(qd) > MOVES * fastest)
    return [(terms[used], read[used])] if used.sum() > 5 else []


def _judge_motion(joint: JointInWork, found: JointFit, out: Collector) -> None:
    """A fit that does not move as the robot does has no figures."""
    import numpy as np

    spread = math.sqrt(
        float(
            np.mean(
                [
                    np.nanvar(recording.measured["position"][start : start + recording.rows])
                    for recording in joint.recordings
                    for start in recording.starts
                ]
            )
        )
    )
    off = found.position_rmse
    if found.misfit is None or off is None or found.misfit < UNLIKE or off < GONE * spread:
        return
    unit = units_of(joint.kind).position
    message = (
        f"the best fit is off by {format_number(off, 2)} {unit}, and the joint moves by "
        f"{format_number(spread, 2)} {unit} (standard deviation): no figures make the model move as the log does"
    )
    help = (
        "is the command what the drive got, does each column belong to its joint, is the base held as in the model, "
        "and does the drive give the torque that the spec's limit allows?"
    )
    if held := held_gains(found):
        help = f"had the drive {held}, which were held? {GAINS_SENT.capitalize()}; else: {help}"
    place = Span(joint.recordings[0].log.path)
    out.error("SYS031", message, where=joint.actuator.joint, span=place, help=help)


def torque_scale(joint: JointInWork) -> Scale | None:
    """Scale of the logged torque by torques that the model knows; None where they are too small to tell.

    The torque is regressed on what the links need along the path of the fit, s (J q'' + g), beside armature, Coulomb
    and viscous friction and an offset, which are free: only what varies otherwise than these tells the scale.
    """
    import numpy as np

    fit = joint.fit
    assert fit is not None
    blocks: list[tuple[Array, Array]] = []
    offsets = []
    # With the drive off there is no torque to compare: those pieces are behind the others.
    for recording, course, pieces, states in zip(
        joint.recordings, joint.courses, piecewise(joint), fit.states, strict=False
    ):
        if "torque" not in recording.measured:
            continue
        moved = simulated(pieces, fit.values, joint.bounds, states)
        fastest = float(np.abs(moved.qd).max())
        behind = recording.log.sidecar.torque == "joint"
        for piece, start in enumerate(pieces.starts):
            rows = slice(start, start + pieces.rows)
            q, qd = moved.q[:, piece, 0], moved.qd[:, piece, 0]
            torque, friction = moved.torque[:, piece, 0], moved.friction[:, piece, 0]
            load = course.load[rows] + course.slope[rows] * (q - course.path[rows])
            # At the row's moment: a torque jumps where a command arrives, and a difference of speeds does not.
            acceleration = (torque - friction - load) / (course.inertia[rows] + fit.values["armature"])
            known = course.inertia[rows] * acceleration + load
            read = recording.measured["torque"][rows]
            blocks += _block(known, acceleration, qd, read, fastest)
            offsets.append((read - (torque - friction if behind else torque))[np.isfinite(read)])
    solved = _regressed(blocks)
    if solved is None or solved[1] > TOLD:
        return None
    return Scale(solved[0], solved[1], float(np.mean(np.concatenate(offsets))))


def _regressed(blocks: list[tuple[Array, Array]]) -> tuple[float, float] | None:
    """The first coefficient of a regression and its standard deviation, residuals correlated within each block."""
    import numpy as np

    if len(blocks) < 3:
        return None
    a, b = (np.concatenate([block[i] for block in blocks]) for i in range(2))
    size = np.abs(a).max(axis=0)
    a = a[:, size > 0] / size[size > 0]
    if len(b) < 10 * a.shape[1] or size[0] == 0.0:
        return None
    normal = a.T @ a
    if np.linalg.cond(normal) > 1e10:
        return None
    inverse = np.linalg.inv(normal)
    solved = inverse @ (a.T @ b)
    scores = np.stack(
        [
            (part[:, size > 0] / size[size > 0]).T @ (read - part[:, size > 0] / size[size > 0] @ solved)
            for part, read in blocks
        ]
    )
    n = len(blocks)
    spread = inverse @ (scores.T @ scores) @ inverse * n / max(n - a.shape[1], 1)
    plain = inverse[0, 0] * float(np.mean((b - a @ solved) ** 2))
    return float(solved[0] / size[0]), math.sqrt(max(float(spread[0, 0]), plain)) / float(size[0])


def _judge_scale(joint: JointInWork, scale: Scale, out: Collector) -> None:
    stated = [recording.log.sidecar.accuracy for recording in joint.recordings]
    known = max(math.hypot(_ratio(one.torque), _ratio(one.masses)) for one in stated)
    off = abs(scale.value - 1.0)
    if off < FAR + 2.0 * scale.std or off < 2.0 * math.hypot(known, scale.std):
        return
    name, place = joint.actuator.joint, Span(joint.recordings[0].log.path)
    shown = scale.shown
    say = out.warning if GROSS[0] < scale.value < GROSS[1] else out.error
    if scale.value <= 0.0:
        message = (
            f"the torque is {shown} times what the model's masses need: one of the two has the wrong sign"
        )
        say("SYS018", message, where=name, span=place, help="turn the torque's column, or gravity")
        return
    message = (
        f"the torque is {shown} times what the model's masses need: kp, kd and friction may be as wrong as it"
    )
    factor = next((f for f in (1e3, 1e-3) if abs(scale.value / f - 1.0) < 0.2), None)
    if factor is not None:
        help = f"its unit is {'mN*m' if factor > 1 else 'kN*m'}"
    else:
        help = (
            "check the torque constant, the gear's efficiency and the masses in the model; `accuracy: {torque: 3 %, "
            "masses: 5 %}` in the sidecar states how well they are known"
        )
    say("SYS018", message, where=name, span=place, help=help)


def _ratio(value: object) -> float:
    """A stated share; 0 where none is stated."""
    number = getattr(value, "value", None)
    return 0.0 if number is None else float(number)


def _judge_gains(joint: JointInWork, found: JointFit, scale: Scale | None, out: Collector) -> None:
    """Fitted gains against those that the sidecars state."""
    name = joint.actuator.joint
    stated = [recording.log.sidecar.gains_of(name) for recording in joint.recordings]
    pairs = {(gains.kp.value, gains.kd.value) for gains in stated if gains is not None}
    if len(pairs) != 1 or None in stated:
        return
    sent = dict(zip(("kp", "kd"), pairs.pop(), strict=True))
    fitted = {field: found.parameter(field) for field in sent}
    factors, shown = {}, []
    for field, value in sent.items():
        parameter = fitted[field]
        if parameter.state is not State.IDENTIFIED or not value:
            continue
        assert parameter.value is not None and parameter.low is not None and parameter.high is not None
        factors[field] = parameter.value / value
        apart = abs(parameter.value - value)
        if apart > SAME * value and apart > parameter.high - parameter.value:
            shown.append(
                f"{field} is {format_number(parameter.value, 4)} {parameter.unit} by the log and "
                f"{format_number(value)} as sent to the drive ({format_number(factors[field], 3)} times)"
            )
    if not shown:
        return
    help = _cause(factors, scale)
    out.warning("SYS019", "; ".join(shown), where=name, span=Span(joint.recordings[0].log.path), help=help)


def _cause(factors: dict[str, float], scale: Scale | None) -> str:
    """What most likely parts measured gains from stated ones."""
    kp, kd = factors.get("kp"), factors.get("kd")
    both = kp is not None and kd is not None and abs(kd / kp - 1.0) < 2.0 * NEAR
    if (
        kp is not None
        and scale is not None
        and abs(kp / scale.value - 1.0) < NEAR
        and abs(kp - 1.0) > NEAR / 2
    ):
        return f"the torque's scale is {format_number(scale.value, 3)} too: it is the torque that is wrong"
    if kd is not None and (kp is None or abs(kp - 1.0) < NEAR):
        unit = _marked(kd, SPEED_UNITS)
        if unit is not None:
            return f"the drive takes kd {unit}"
        return "kp agrees: the drive's speed is filtered or late, or its kd has a unit of its own"
    if kp is not None and (unit := _marked(kp, DRIVE_UNITS)) is not None:
        return f"the drive takes kp {unit}"
    if both and kp is not None and kp > 4.0:
        gear = format_number(math.sqrt(kp), 3)
        return f"gains at the rotor, behind a gear of {gear}, are {gear}^2 times as large at the joint"
    if both:
        return "both by one factor: the drive's torque constant, or its gains have a unit of their own"
    return "the drive's gains have units of their own, or it limits, filters or shapes its command"


def _marked(factor: float, units: dict[float, str]) -> str | None:
    return next(
        (unit for size, unit in units.items() for f in (size, 1.0 / size) if abs(factor / f - 1.0) < NEAR),
        None,
    )
