"""Whether a log's angles are the model's: a zero at the default pose, or a joint whose sign is the other way.

What a policy sees are positions less the default pose, and a drive may count against the model's axis. Command,
position, velocity and torque then agree with each other, and gravity alone contradicts them: a fit would put it into
an encoder's bias, armature and gains. The logged torque is held against what the links need, as read and as meant.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, listed
from actspec.fields import units_of
from actspec.joints import JointKind
from actspec.sysid.identified import JointFit, State
from actspec.sysid.links import links_at
from actspec.sysid.recording import Recording, smooth
from actspec.sysid.stand import Stand, by_log
from actspec.sysid.work import JointInWork
from actspec.units import format_number, format_quantity

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    Array = NDArray[np.float64]

SLOWLY = 0.05
"""Width of the filter through which motion and torque are looked at [s]. Chosen: gravity is slow."""
ROWS = 200
"""Rows that are looked at. Chosen: they tell three figures a joint."""
OFF, FITS = 0.2, 0.25
"""Share of a joint's RMS torque that is left as read, from which on its angle is in question, and that is left as meant
up to which that is what it is. Measured on a leg of four joints: 0.05 to 0.22 with the right angles, the most where
the torque is a third noise; 0.32 and more without the default pose, 0.55 and 0.93 with a joint mirrored."""
FALLS = 0.4
"""What is left as meant over what is left as read, from which on there is no doubt. Measured there: 0.09 to 0.25."""
NO_WORSE = 0.02
"""By how much more may be left at another joint."""
STEPS = (0.8, 1.2)
"""Shares of the default pose with which more must be left, so that the best one is within a tenth of all of it: a base
that is pitched looks like some."""
NONE = 0.05
"""Position by which nothing is told from none [rad or m]. Chosen: gravity's slope over it is a twentieth."""
MOST_BIAS = 0.2
"""Encoder's bias from which on it is one no more [rad]. Chosen: eleven degrees, where zeros are set to one or two and
randomised by up to 0.05 rad; one motor turn behind a gear of 9 is 0.7 rad."""


@dataclass(frozen=True, slots=True)
class Read:
    """A log's moving joints at some rows, in the order of `names`; shape (n, n_joint) each.

    Attributes:
        names: Joints with a position.
        q: [rad or m].
        qd: [rad/s or m/s].
        qdd: [rad/s^2 or m/s^2].
        torque: [N*m or N]; NaN for joints of which none is judged.
    """

    names: tuple[str, ...]
    q: Array
    qd: Array
    qdd: Array
    torque: Array


def judge_zeros(stand: Stand, joints: Mapping[str, JointInWork], out: Collector) -> frozenset[str]:
    """Say of which joints the logged angles are not the model's, by gravity, and return them.

    Args:
        stand: The model and its default pose.
        joints: Before their fit; those with a torque are judged.
        out: Takes it.
    """
    askew: set[str] = set()
    moved = {name: [(r.log, r) for r in joint.recordings] for name, joint in joints.items() if joint.torque}
    for _, here in by_log(moved):
        askew |= _judge_log(stand, here, out)
    return frozenset(askew)


def _judge_log(stand: Stand, here: Mapping[str, Recording], out: Collector) -> set[str]:
    """The joints of one log whose angles are not the model's."""
    import numpy as np

    first = next(iter(here.values()))
    log, seen = first.log, read(stand, first, here)
    base = log.sidecar.base
    at = links_at(stand.beside(log, seen.names)[0], seen.names, None if base is None else base.orientation)
    one, which = np.ones(len(seen.names)), np.arange(len(seen.names))
    as_read = left(seen, at, one, 0.0 * one)

    def tells(sign: Array, add: Array) -> NDArray[np.bool_]:
        """Joints whose torque it explains, none where it makes another one worse."""
        meant = left(seen, at, sign, add)
        found: NDArray[np.bool_] = (as_read > OFF) & (meant < FITS) & (meant < FALLS * as_read)
        return found & ~np.any(meant > as_read + NO_WORSE)

    def least(add: Array) -> float:
        return float(np.nansum(left(seen, at, one, add) ** 2))

    if not np.any(as_read > OFF):
        return set()
    poses = {joint.name: stand.default(joint)[0] for joint in stand.others(())}
    pose = np.array([poses[name] for name in seen.names])
    pose[np.abs(pose) < NONE] = 0.0
    for add in (pose, *(np.where(which == k, pose, 0.0) for k in np.flatnonzero(pose))):
        if add.any() and tells(one, add).any() and all(least(s * add) > least(add) for s in STEPS):
            _tell_shift(stand, seen, first, add, out)
            return set(here)
    turned = {
        k: name
        for k, name in enumerate(seen.names)
        if as_read[k] > OFF and tells(np.where(which == k, -one, one), 0.0 * one)[k]
    }
    # That a position is out of its range asks for what is told now.
    out.forget(("SYS047",), turned.values(), log.path)
    if turned:
        # What one joint's wrong sign does to the others' torques is explained by theirs too: its own is off the most.
        best = max(turned, key=lambda k: float(as_read[k]))
        name = turned[best]
        others = listed([other for other in turned.values() if other != name])
        message = (
            "its sign is the other way than the model's: gravity fits the torque with the joint mirrored, and leaves "
            f"{as_read[best]:.0%} of it as logged"
        )
        if others:
            message += f"; {others} mirrored in its place fits too"
        help = "turn the signs of its position, velocity, command and torque, or the axis in the model"
        out.warning("SYS047", message, where=name, span=Span(log.path), help=help)
    return set(turned.values())


def _tell_shift(stand: Stand, seen: Read, first: Recording, shift: Array, out: Collector) -> None:
    """Name the joints, what to add to them, and whether to their commands too."""
    import numpy as np

    both: list[str] = []
    alone: list[str] = []
    for name, q, add in zip(seen.names, seen.q.T, shift, strict=True):
        if not add:
            continue
        command = first.log.joints[name].command
        joint = stand.robot.joint(name)
        assert joint is not None
        shown = f"{name} {format_quantity(float(add), units_of(joint.kind).position, 4)}"
        ahead = 0.0 if command is None else float(np.nanmedian(command) - np.median(q))
        # Command and position are alike, or one of them is the model's already.
        (alone if abs(ahead - add) < abs(ahead) else both).append(shown)
    # That a position is out of its range asks for what is told now.
    out.forget(
        ("SYS047",), [name for name, add in zip(seen.names, shift, strict=True) if add], first.log.path
    )
    what = "positions and commands are" if both else "positions are"
    help = "add it: " + " and ".join(
        f"to {which} of {listed(some)}"
        for which, some in (("position and command", both), ("the position", alone))
        if some
    )
    message = (
        f"{what} relative to the default pose: gravity fits the torque with it added, and does not as logged"
    )
    out.warning("SYS047", message, span=Span(first.log.path), help=help)


def judge_biases(found: Sequence[JointFit], askew: frozenset[str], out: Collector) -> None:
    """Say where a fit gives an encoder a bias that none has.

    Args:
        found: What the fit says of each joint.
        askew: Joints whose angles are known to be others than the model's.
        out: Takes it.
    """
    for joint in found:
        bias = joint.parameter("encoder_bias")
        if joint.joint in askew or joint.kind is not JointKind.HINGE or bias.state is not State.IDENTIFIED:
            continue
        assert bias.value is not None and bias.low is not None and bias.high is not None
        if bias.low > MOST_BIAS or bias.high < -MOST_BIAS:
            message = (
                f"an encoder's bias of {format_number(bias.value, 3)} {bias.unit} is more than encoders have"
            )
            help = (
                "is it the joint's own angle, with the model's sign and zero? An encoder at the motor may be off by "
                "whole turns of it; a base that is held otherwise than in the model looks alike"
            )
            out.warning("SYS047", message, where=joint.joint, help=help)


def left(seen: Read, at: Callable[[Array, Array], tuple[Array, Array]], sign: Array, add: Array) -> Array:
    """Share of each joint's torque that links, armature and friction leave, NaN where none is known, shape (n_joint,).

    Args:
        seen: The log.
        at: Mass matrix and loads at positions and speeds, see `links_at`.
        sign: By which each joint is turned, shape (n_joint,).
        add: What is added to each position then [rad or m], likewise.
    """
    import numpy as np

    q, qd, qdd = seen.q * sign + add, seen.qd * sign, seen.qdd * sign
    needed = np.array([m @ a + g for (m, g), a in zip(map(at, q, qd), qdd, strict=True)])
    found = np.full(len(seen.names), np.nan)
    for j in range(len(seen.names)):
        torque = seen.torque[:, j] * sign[j]
        rows = np.isfinite(torque)
        if rows.sum() < ROWS // 4:
            continue
        terms = np.stack([qdd[:, j], qd[:, j], np.sign(qd[:, j])], axis=1)[rows]
        wanted = (torque - needed[:, j])[rows]
        solved = np.linalg.lstsq(terms, wanted, rcond=None)[0]
        found[j] = math.sqrt(float(np.mean((wanted - terms @ solved) ** 2) / np.mean(torque[rows] ** 2)))
    return found


def read(stand: Stand, first: Recording, here: Mapping[str, Recording]) -> Read:
    """The joints of a log, of which some have a recording."""
    import numpy as np

    log, time = first.log, first.time
    names = tuple(
        joint.name
        for joint in stand.others(())
        if (columns := log.joints.get(joint.name)) is not None
        and stand.actuators.joint(joint.name) is not None
        and columns.position is not None
        and np.isfinite(columns.position).mean() > 0.5
    )
    rows = np.linspace(0, len(time) - 1, ROWS).astype(int)
    motion: list[list[Array]] = []
    torques = []
    for name in names:
        position, actuator = log.joints[name].position, stand.actuators.joint(name)
        assert position is not None and actuator is not None
        position = position - (actuator.encoder_bias.value or 0.0)
        known = np.isfinite(position)
        whole = np.interp(time, log.time[known], position[known])
        motion.append([smooth(time, whole, SLOWLY, order)[rows] for order in range(3)])
        torque = here[name].measured.get("torque") if name in here else None
        if torque is None or len(torque) != len(time) or np.isfinite(torque).mean() < 0.5:
            torques.append(np.full(len(rows), np.nan))
        else:
            torques.append(np.where(np.isfinite(torque), smooth(time, torque, SLOWLY), np.nan)[rows])
    q, qd, qdd = (np.stack([one[i] for one in motion], axis=1) for i in range(3))
    return Read(names, q, qd, qdd, np.stack(torques, axis=1))
