"""The commands of a log given to variants of a robot: how well each joint, alone, follows them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, Span, listed
from actspec.ir import ActuatorSet, Command, JointActuator
from actspec.laws import TorqueLaw
from actspec.logs import Log, LogError
from actspec.simulate.reference import DrivenJoint, PassiveFriction, Trajectory, integrate
from actspec.study.learned import LearnedJoint, respond
from actspec.study.measures import held
from actspec.study.metrics import FULL
from actspec.verify.joint_laws import JointLaws, laws_of

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from actspec.laws.arrays import Floats as Array

FINEST = 1e-3
"""Longest time between two samples of a torque [s]. Chosen: its peaks are where the command changes, at samples."""
UNEVEN = 2.5e-4
"""The same where the rows of a log do not lie at even times: so late may a command be [s]."""
JITTER = 1e-6
"""Share of a period by which even rows may be off. Chosen: what digits of a written time leave."""
FASTEST = 0.25
"""Largest part of a joint's own time in one step of the integration. Chosen: halving it changes less than 1e-5 of the
way."""
MOST = 1e6
"""Largest command [rad, m, rad/s or m/s]. Chosen: no joint is told to go there, and it is not yet lost in digits."""
CELLS = 20_000_000
"""Most samples of all joints that are integrated at once. Chosen: half a gigabyte."""


@dataclass(frozen=True, slots=True)
class Tracking:
    """How one joint of one variant follows the commands.

    Attributes:
        variant: Its name.
        joint: Its name.
        rmse: Command less position (of a velocity drive, less speed) over the log's rows [rad, m, rad/s or m/s].
        peak_torque: Of the drive [N*m or N].
        saturated: Share of the time with at least 0.9 of the effort limit; None: there is no limit.
    """

    variant: str
    joint: str
    rmse: float
    peak_torque: float
    saturated: float | None


@dataclass(frozen=True, slots=True)
class _Column:
    """One joint of one variant, and what it is told."""

    variant: str
    driven: DrivenJoint | LearnedJoint
    actuator: JointActuator
    command: Array

    @property
    def law(self) -> TorqueLaw:
        """Of its drive; of a network the clamps."""
        return self.driven.law if isinstance(self.driven, DrivenJoint) else self.driven.drive.clip

    @property
    def speedy(self) -> bool:
        """Whether it follows a speed."""
        return self.actuator.command is Command.VELOCITY


def replay(
    variants: Mapping[str, ActuatorSet],
    log: Log,
    out: Collector,
) -> tuple[Tracking, ...]:
    """Let every joint of every variant follow a log's commands, each held until the next, from rest at the first.

    A joint is alone on its inertia, without gravity and joint limits, with the spec's friction; by the law, in steps so
    small that smaller ones change nothing. A network is sampled once a physics step, and its torque held.

    Args:
        variants: By name; all with the same joints.
        log: With a command of some of them.
        out: Takes why a joint cannot be shown.

    Raises:
        LogError: no joint of the log can be told anything, or a command is none.
    """
    first = next(iter(variants.values()))
    commands = {a.joint: c for a in first.joints if (c := _command(a, log, out)) is not None}
    out.raise_if_failed(LogError)
    if not commands:
        known = [actuator.joint for actuator in first.joints]
        raise LogError.of(
            "ABL010",
            f"has a command of no joint of the spec: {listed(list(log.joints), 4)}",
            Span(log.path),
            help=f"joints of the spec: {listed(known, 4)}; a column is `{known[0]}.command [rad]`",
        )
    asked: list[_Column] = []
    for name, actuators in variants.items():
        networks = laws_of(actuators)
        for actuator in actuators.joints:
            driven = _driven(name, actuator, networks, log, out) if actuator.joint in commands else None
            if driven is not None:
                asked.append(_Column(name, driven, actuator, commands[actuator.joint]))
    step = first.physics_dt.require()
    shown = _followed(asked, log, step)
    return tuple(Tracking(c.variant, c.actuator.joint, *found) for c, found in zip(asked, shown, strict=True))


def _command(actuator: JointActuator, log: Log, out: Collector) -> Array | None:
    """What a joint is told in each row; None: nothing, or an error."""
    import numpy as np

    if actuator.joint not in log.joints:
        return None
    place = out.at(actuator.joint, Span(log.path))
    if actuator.command is Command.EFFORT:
        place.info("ABL011", "its command is an effort, which nothing follows: it is not replayed")
        return None
    name = "command" if actuator.command is Command.POSITION else "velocity_command"
    unlike = log.joints[actuator.joint].unlike(actuator.kind)
    if unlike is not None:
        place.error("ABL010", unlike, "correct the columns' units")
        return None
    found = getattr(log.joints[actuator.joint], name)
    if found is None or not np.isfinite(found).any():
        place.info("ABL011", f"the log has no {name}: it is not replayed")
        return None
    command = held(found)
    (holes,) = np.nonzero(~np.isfinite(found))
    if len(holes):
        message = f"the {name} is no number in {len(holes)} of {len(found)} rows: the one before is held"
        out.info("ABL011", message, where=actuator.joint, span=log.span(int(holes[0])))
    if np.ptp(command) == 0.0:
        place.info("ABL011", f"the {name} is {command[0]:g} in every row: nothing is to be followed")
    (wild,) = np.nonzero(np.abs(command) > MOST)
    if len(wild):
        row = int(wild[0])
        message = f"the {name} is {command[row]:g}, at most {MOST:g} is replayed"
        out.error("ABL010", message, where=actuator.joint, span=log.span(row))
        return None
    return command


def _driven(
    variant: str, actuator: JointActuator, laws: JointLaws, log: Log, out: Collector
) -> DrivenJoint | LearnedJoint | None:
    """A joint that can be integrated; None, with the reason said, where it cannot."""
    place = out.at(actuator.joint, Span(log.path))
    inertia = actuator.inertia_held
    if inertia is None:
        place.info("ABL011", "its inertia is unknown without a model: it is not replayed")
        return None
    if not inertia.reference > (actuator.armature.value or 0.0):
        place.info("ABL011", "its inertia is not more than its armature: it is not replayed")
        return None
    friction, law = PassiveFriction.of(actuator), laws.laws.get(actuator.joint)
    if law is not None:
        return DrivenJoint(law, friction, inertia.reference)
    drive = laws.networks.get(actuator.joint)
    if drive is not None:
        return LearnedJoint(drive, friction, inertia.reference)
    reason, help = laws.skipped[actuator.group]
    place.info("ABL011", f"not replayed in {variant}: {reason}", help)
    return None


Found = tuple[float, float, float | None]
"""Error, peak and saturation."""


def _followed(columns: Sequence[_Column], log: Log, step: float) -> list[Found]:
    """How each goes; variants that differ in what is drawn alone have one law, and go once."""
    period, index = _grid(log.time)
    distinct = {(c.actuator.joint, c.driven): c for c in columns if isinstance(c.driven, DrivenJoint)}
    todo, most = list(distinct.values()), max(CELLS // len(index), 1)
    parts = [todo[at : at + most] for at in range(0, len(todo), most)]
    shown = [found for part in parts for found in _by_laws(part, log, period, index)]
    laws = dict(zip(distinct, shown, strict=True))
    learned = [column for column in columns if isinstance(column.driven, LearnedJoint)]
    networks = iter(_by_networks(learned, log, step) if learned else ())
    return [
        laws[c.actuator.joint, c.driven] if isinstance(c.driven, DrivenJoint) else next(networks)
        for c in columns
    ]


def _by_laws(columns: Sequence[_Column], log: Log, period: float, index: NDArray[np.intp]) -> list[Found]:
    import numpy as np

    driven = [column.driven for column in columns if isinstance(column.driven, DrivenJoint)]
    rate = max(max(math.sqrt(one.law.kp / one.inertia), one.law.kd / one.inertia) for one in driven)
    substeps = max(math.ceil(period * rate / FASTEST), 1)
    command = np.stack([column.command[index] for column in columns], axis=1)
    start = _start(columns, command)
    moved = integrate(driven, command, start, np.zeros(len(columns)), period, substeps=substeps)
    return _found(columns, log, period, moved)


def _by_networks(columns: Sequence[_Column], log: Log, step: float) -> list[Found]:
    import numpy as np

    learned = [column.driven for column in columns if isinstance(column.driven, LearnedJoint)]
    samples = np.arange(math.ceil(float(log.time[-1]) / step - 1e-9)) * step
    index = np.searchsorted(log.time, samples + 1e-9 * step, "right") - 1
    command = np.stack([column.command[index] for column in columns], axis=1)
    parts = max(math.ceil(step / FINEST - 1e-9), 1)
    return _found(
        columns, log, step / parts, respond(learned, command, _start(columns, command), step, parts)
    )


def _start(columns: Sequence[_Column], command: Array) -> Array:
    """At rest at the first command; a joint that follows a speed at 0."""
    import numpy as np

    return np.array(
        [
            0.0 if column.speedy else first - column.law.encoder_bias
            for column, first in zip(columns, command[0], strict=True)
        ]
    )


def _found(columns: Sequence[_Column], log: Log, period: float, moved: Trajectory) -> list[Found]:
    """What samples show."""
    import numpy as np

    grid = np.arange(len(moved.q)) * period
    found: list[Found] = []
    for k, column in enumerate(columns):
        answer = moved.qd[:, k] if column.speedy else moved.q[:, k] + column.law.encoder_bias
        left = column.command - np.interp(log.time, grid, answer)
        size, limit = np.abs(moved.torque[:, k]), column.law.effort_limit
        saturated = float(np.mean(size >= FULL * limit)) if math.isfinite(limit) else None
        found.append((math.sqrt(float(np.mean(left**2))), float(size.max()), saturated))
    return found


def _grid(time: Array) -> tuple[float, NDArray[np.intp]]:
    """Even samples of a log's time, so near that each row is one of them, or nearly.

    Returns: Their period [s], and the row that is in force at each.
    """
    import numpy as np

    usual = float(time[-1]) / (len(time) - 1)
    if np.abs(time - usual * np.arange(len(time))).max() <= JITTER * len(time) * usual:
        parts = max(math.ceil(usual / FINEST - 1e-9), 1)
        return usual / parts, np.arange(len(time) - 1).repeat(parts)
    count = math.ceil(float(time[-1]) / UNEVEN)
    samples = np.arange(count) * (float(time[-1]) / count)
    return float(time[-1]) / count, np.searchsorted(time, samples, "right") - 1
