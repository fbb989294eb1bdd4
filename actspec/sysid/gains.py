"""The gains that a joint's logs were made with: who states them, which logs share them, and which a fit may change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from actspec.diagnostics import Collector, Span, listed
from actspec.ir import JointActuator, Quantity
from actspec.logs import Log
from actspec.logs.sidecar import sidecar_path
from actspec.patterns import match_names
from actspec.spec.sidecar import LogGains
from actspec.units import format_number

GAINS = ("kp", "kd")


@dataclass(frozen=True, slots=True)
class Gains:
    """kp and kd of one or several logs.

    Attributes:
        kp: As sent to the drive [N*m/rad or N/m]; None: nobody states it.
        kd: Likewise [N*m*s/rad or N*s/m].
        logs: Paths of the logs that were made with them.
        stated: Whether a sidecar states them; else they are the spec's.
        of_spec: Whether the spec has the same.
    """

    kp: float | None
    kd: float | None
    logs: tuple[str, ...]
    stated: bool
    of_spec: bool

    def sent(self, name: str) -> float | None:
        """That of a name."""
        return self.kp if name == "kp" else self.kd

    def __str__(self) -> str:
        shown = [f"{name} {format_number(v)}" for name in GAINS if (v := self.sent(name)) is not None]
        return f"{' and '.join(shown) or 'unknown gains'} in {listed(self.logs, 3)}"


@dataclass(frozen=True, slots=True)
class GainSets:
    """The gains of all logs of a joint.

    Attributes:
        sets: Without repetition; first those of the spec, if a log has them and their kd is not 0.
        used: Index into `sets` of every recording.
        held: Which of `kp` and `kd` are taken as they were sent.
        tied: Whether those that are not held have the ratios that were sent: one factor, not a number a set.
    """

    sets: tuple[Gains, ...]
    used: tuple[int, ...]
    held: frozenset[str]
    tied: bool

    def key(self, name: str, index: int) -> tuple[str, float]:
        """Which value of a fit is `kp` or `kd` in a set, and the factor on it."""
        first, mine = self.sets[0].sent(name), self.sets[index].sent(name)
        if self.tied and name not in self.held:
            return name, mine / first if first and mine is not None else 1.0
        same = next(i for i, one in enumerate(self.sets) if one.sent(name) == mine)
        return (name if same == 0 else f"{name}#{same}"), 1.0

    def keys(self, name: str) -> tuple[str, ...]:
        """The values that are `kp` or `kd` in some set."""
        return tuple(dict.fromkeys(self.key(name, index)[0] for index in range(len(self.sets))))

    def own(self, recording: int) -> Mapping[str, tuple[str, float]]:
        """`kp` and `kd` to their value and factor in a recording."""
        return {name: self.key(name, self.used[recording]) for name in GAINS}

    @property
    def ratio_tells_kd(self) -> bool:
        """Whether several kd of known ratio part kd from viscous friction."""
        return self.tied and "kd" not in self.held and self.differ("kd")

    def differ(self, name: str) -> bool:
        """Whether the logs have `kp` or `kd` of their own."""
        return len({self.key(name, index) for index in range(len(self.sets))}) > 1

    def nameless(self, name: str) -> str | None:
        """Why one number cannot stand for `kp` or `kd`; None: that of the first set does."""
        if self.sets[0].of_spec or not self.differ(name):
            return None
        return f"the logs have gains of their own: {_shown(self.sets)}"

    def where(self, name: str, hold: frozenset[str]) -> str:
        """Where a gain is held from."""
        first = self.sets[0]
        by_sidecar = f"as sent to the drive, by the sidecar of {first.logs[0]}"
        text = by_sidecar if first.stated else "held at the spec's"
        return f"{text}, --hold" if name in hold else text


def gains_of(
    actuator: JointActuator,
    logs: Sequence[Log],
    *,
    torque: bool,
    free: frozenset[str],
    hold: frozenset[str],
    out: Collector,
) -> GainSets:
    """The gains of a joint's logs. With torque they are free, else held as they were sent, else at the spec's.

    Args:
        actuator: The joint, as the spec has it.
        logs: Its logs.
        torque: Whether a torque tells the gains.
        free: Fields that the user frees.
        hold: Fields that the user holds.
        out: Takes what is wrong.
    """
    name = actuator.joint
    held = frozenset(gain for gain in GAINS if gain in hold or (not torque and gain not in free))
    spec = (_number(actuator.kp), _number(actuator.kd))
    pairs: list[tuple[float | None, float | None]] = []
    stated: list[bool] = []
    for log in logs:
        mine = _stated(name, log, out)
        stated.append(mine is not None)
        pairs.append(spec if mine is None else (mine.kp.value, mine.kd.value))
    distinct = sorted(dict.fromkeys(pairs), key=lambda pair: (not pair[1], pair != spec))
    sets = tuple(
        Gains(
            *pair,
            tuple(log.path for log, other in zip(logs, pairs, strict=True) if other == pair),
            any(said for said, other in zip(stated, pairs, strict=True) if other == pair),
            pair == spec,
        )
        for pair in distinct
    )
    _check_held(actuator, sets, held, hold, out)
    return GainSets(sets, tuple(distinct.index(pair) for pair in pairs), held, not torque)


def joined(
    gains: GainSets, actuator: JointActuator, logs: Sequence[Log], out: Collector
) -> tuple[GainSets, list[list[int]]]:
    """The gains of logs that a fit has not seen: its sets, and behind them those that it does not know.

    Args:
        gains: Of the fit.
        actuator: The joint, as the spec has it.
        logs: That the fit has not seen.
        out: Takes what is wrong.

    Returns: The sets, and for each log those that it may have been made with, the likeliest first.
    """
    sets, possible = list(gains.sets), []
    every = range(len(sets))
    for log in logs:
        mine = _stated(actuator.joint, log, out)
        pair = (
            (_number(actuator.kp), _number(actuator.kd)) if mine is None else (mine.kp.value, mine.kd.value)
        )
        at = next((i for i, one in enumerate(sets) if (one.kp, one.kd) == pair), None)
        if at is None and (mine is not None or None not in pair):
            at = len(sets)
            sets.append(Gains(*pair, (log.path,), stated=mine is not None, of_spec=mine is None))
        own, unknown = [] if at is None else [at], at not in every
        if mine is not None:
            # The fit may have had the same in a log that did not state them.
            own += [i for i in every if unknown and not sets[i].stated]
        elif unknown:
            own = [*every, *own]
        else:
            own += [i for i in every if i != at]
        possible.append(own)
    return replace(gains, sets=tuple(sets), used=tuple(some[0] for some in possible)), possible


def extended(gains: GainSets, values: Mapping[str, float]) -> dict[str, float]:
    """The values of a fit, and those of sets that it has not seen: its first set's, by the ratio of what was sent."""
    found = dict(values)
    for name in GAINS:
        first = gains.sets[0].sent(name)
        for index, one in enumerate(gains.sets):
            sent = one.sent(name)
            ratio = sent / first if first and sent is not None else 1.0
            found.setdefault(gains.key(name, index)[0], values[name] * ratio)
    return found


def _check_held(
    actuator: JointActuator, sets: Sequence[Gains], held: frozenset[str], hold: frozenset[str], out: Collector
) -> None:
    name = actuator.joint
    lacking = sorted({gain for one in sets for gain in held if one.sent(gain) is None}, reverse=True)
    if lacking:
        cause = "is held" if set(lacking) <= hold else "no torque was logged"
        message = f"{listed(lacking)}: {cause}, and neither the sidecar nor the spec states it"
        help = f"write `gains: {{{name}: {{kp: ..., kd: ...}}}}` beside the log, or give --free {','.join(lacking)}"
        out.error("SYS023", message, where=name, help=help)
        return
    of_spec = next((one for one in sets if not one.stated), None)
    if held and not held <= hold and of_spec is not None:
        shown = [
            f"{gain} {format_number(quantity.value)} {quantity.unit}"
            for gain, quantity in (("kp", actuator.kp), ("kd", actuator.kd))
            if gain in held and quantity is not None and quantity.value is not None
        ]
        where = "" if len(sets) == 1 else f" in {listed(of_spec.logs, 3)}"
        message = f"held at the spec's{where}: {listed(shown)}; the log has no torque, and its sidecar states no gains"
        out.info("SYS024", message, where=name)
    if len(sets) > 1:
        out.info("SYS033", f"the logs have gains of their own: {_shown(sets)}", where=name)


def _shown(sets: Sequence[Gains]) -> str:
    return "; ".join([str(one) for one in sets[:4]] + [f"{len(sets) - 4} more"] * (len(sets) > 4))


def _number(quantity: Quantity | None) -> float | None:
    return None if quantity is None else quantity.value


def _stated(name: str, log: Log, out: Collector) -> LogGains | None:
    """What the sidecar states of a joint: under its name, else under the patterns that match it."""
    gains = log.sidecar.gains
    if name not in gains:
        found = {pattern: entry for pattern, entry in gains.items() if match_names(pattern, [name])}
        if len({(entry.kp.value, entry.kd.value) for entry in found.values()}) > 1:
            message = f"the sidecar states different gains of it: under {listed(repr(pattern) for pattern in found)}"
            help = f"state them under '{name}', or let one pattern match it"
            out.error("SYS025", message, where=name, span=Span(sidecar_path(log.path)), help=help)
    return log.sidecar.gains_of(name)
