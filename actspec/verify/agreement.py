"""What is verified, and what a verification reports: rows that agree or not, and what was not compared."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from actspec.diagnostics import ActspecError, Span
from actspec.ir import ActuatorSet, JointActuator
from actspec.targets.base import Approximation, TargetOptions

FORMAT = "actspec-verify/1"


class VerifyError(ActspecError):
    """A verification cannot start: a file is missing, or an engine cannot be had."""


@dataclass(frozen=True, slots=True)
class TargetFiles:
    """A target's files, those that are verified and those that actspec writes today.

    Attributes:
        options: Which target.
        folder: Where the files lie that are verified.
        fresh: Where what actspec writes lies; the same unless another folder was named.
        files: Their paths below either, the main one first.
        losses: What the target is known to lose.
    """

    options: TargetOptions
    folder: str
    fresh: str
    files: tuple[str, ...]
    losses: tuple[Approximation, ...]

    @property
    def name(self) -> str:
        """Its name in the spec."""
        return self.options.name

    def path(self, file: str) -> str:
        """Where a file lies that is verified."""
        return os.path.join(self.folder, file)

    def fault(
        self,
        quantity: str,
        code: str,
        message: str,
        *,
        actuator: JointActuator | None = None,
        joints: int | None = None,
        **more: Any,
    ) -> Row:
        """A row that does not agree.

        Args:
            quantity: As in `Row`.
            code: What is wrong.
            message: The same in words.
            actuator: The joint's; None: it concerns the whole target.
            joints: How many; default 1 of a joint.
            more: Other attributes of the row.
        """
        group, joint, count = ("", "", 0) if actuator is None else (actuator.group, actuator.joint, 1)
        many = count if joints is None else joints
        rest: dict[str, Any] = {"unit": "", "max_error": None, "tolerance": 0.0, **more}
        return Row(self.name, group, joint, many, quantity, ok=False, code=code, message=message, **rest)

    def right(self, quantity: str, *, joints: int = 0, **more: Any) -> Row:
        """A row of the whole target that agrees.

        Args: as of `fault`.
        """
        return Row(self.name, "", "", joints, quantity, "", 0.0, 0.0, True, **more)

    def losses_of(self, joint: str, fields: Sequence[str]) -> tuple[Approximation, ...]:
        """What it loses of fields of a joint, by the names of `Approximation.field`."""
        return tuple(loss for loss in self.losses if loss.joint in (joint, "") and loss.field in fields)


@dataclass(frozen=True, slots=True)
class At:
    """Where on the grid of a torque, or on a response, the largest error is.

    Attributes:
        error: Command less measured position, as the engine gets them [rad or m]; None unless the command is
            a position.
        velocity: Of the joint [rad/s or m/s].
        command: [rad or m], [rad/s or m/s] or [N*m or N].
        step: Physics step, from 0.
        time: Of a response: since its start [s]; the state is the law's then.
        torque: Of a response: the engine's torque less the law's then [N*m or N].
    """

    error: float | None
    velocity: float
    command: float
    step: int
    time: float | None = None
    torque: float | None = None


@dataclass(frozen=True, slots=True)
class Row:
    """One quantity of one target and of the joints of a group that have the same numbers.

    Attributes:
        target: Name of the target in the spec.
        group: Group of the spec; "" for what concerns the whole target.
        joint: The joint with the largest error; "" for what concerns the whole target.
        joints: How many joints of the group share the row.
        quantity: `torque`, `torque.step`, `torque.ramp`, of a network `torque.course` (see
            `actspec.simulate.excitation`), `step response` and its like (`actspec.simulate.experiment`), a field such
            as `kp`, or `file`.
        unit: Of `max_error`, `tolerance`, `expected` and `got`.
        max_error: Largest difference, of a network aside from known approximations; None where there is no number
            to compare.
        tolerance: Largest difference that agrees; infinity where an approximation has no size.
        ok: Whether it agrees.
        expected: Of a field at `joint`: the spec's, or of an approximated field what actspec writes.
        got: Of a field at `joint`: the file's; None: the file does not state it.
        at: Of a torque: where the error is.
        approximations: Keys of the known approximations that concern the quantity.
        engine: What was asked, with its version; None: the file was read back.
        code: What is wrong, as in docs/verify.md; None where it agrees.
        message: The same in words; "" where it agrees.
        place: Where a field that is wrong is written; None elsewhere.
        usual_error: Of a torque: the largest difference of all these joints where command and speed are inside their
            ranges (`usual` in `torque`); None: no sample is, or it is no torque.
    """

    target: str
    group: str
    joint: str
    joints: int
    quantity: str
    unit: str
    max_error: float | None
    tolerance: float
    ok: bool
    expected: float | None = None
    got: float | None = None
    at: At | None = None
    approximations: tuple[str, ...] = ()
    engine: str | None = None
    code: str | None = None
    message: str = ""
    place: Span | None = None
    usual_error: float | None = None


@dataclass(frozen=True, slots=True)
class Skip:
    """What was not asked, and why.

    Attributes:
        target: Name of the target.
        group: Group of the spec; "" for the whole target.
        what: `torque`, `responses`, or `fields`.
        reason: Why.
        help: What would change that; None: nothing would.
        setup: Whether something is missing that can be installed: by `actspec verify --setup`, or as `help` says.
    """

    target: str
    group: str
    what: str
    reason: str
    help: str | None = None
    setup: bool = False


@dataclass(frozen=True, slots=True)
class Agreement:
    """Everything that one verification found.

    Attributes:
        rows: By target in the spec's order, then torques, then fields.
        skipped: What was not asked.
        approximations: What the targets are known to lose.
    """

    rows: tuple[Row, ...]
    skipped: tuple[Skip, ...]
    approximations: tuple[Approximation, ...] = field(default=(), repr=False)

    @property
    def ok(self) -> bool:
        """Whether all rows agree."""
        return all(row.ok for row in self.rows)

    @property
    def faults(self) -> tuple[Row, ...]:
        """The rows that do not."""
        return tuple(row for row in self.rows if not row.ok)


def row_record(row: Row) -> dict[str, Any]:
    """A row as machine output has it; no limit is the text `Infinity`, null is unknown."""
    at = row.at
    return {
        "target": row.target,
        "group": row.group or None,
        "joint": row.joint or None,
        "joints": row.joints,
        "quantity": row.quantity,
        "unit": row.unit,
        "max_error": _number(row.max_error),
        "usual_error": _number(row.usual_error),
        "at": None if at is None else asdict(at),
        "tolerance": _number(row.tolerance),
        "ok": row.ok,
        "expected": _number(row.expected),
        "got": _number(row.got),
        "approximation": ", ".join(row.approximations) or None,
        "engine": row.engine,
        "code": row.code,
        "message": row.message or None,
        "file": None if row.place is None else row.place.path,
        "line": None if row.place is None else row.place.line or None,
    }


def skip_record(skip: Skip) -> dict[str, Any]:
    """A skip as machine output has it."""
    return {**asdict(skip), "group": skip.group or None}


def _number(value: float | None) -> float | str | None:
    if value is None or math.isfinite(value):
        return value
    return "NaN" if math.isnan(value) else "Infinity" if value > 0 else "-Infinity"


def keys(losses: Iterable[Approximation]) -> tuple[str, ...]:
    """The keys of losses, each once, in order."""
    return tuple(dict.fromkeys(loss.key for loss in losses))


def worst_of(rows: Iterable[tuple[float, Row]], by: Callable[[Row], object]) -> Iterator[Row]:
    """Rows of joints put together: of those that have the same, the one with the largest error counts for all.

    Args:
        rows: Errors in tolerances, and rows of one joint each.
        by: What rows that are put together have in common.
    """
    merged: dict[object, list[tuple[float, Row]]] = {}
    for share, row in rows:
        merged.setdefault(by(row), []).append((share, row))
    for found in merged.values():
        usual = [row.usual_error for _, row in found if row.usual_error is not None]
        worst = max(found, key=lambda pair: pair[0])[1]
        yield replace(worst, joints=len(found), usual_error=max(usual, default=None))


def alike(actuators: ActuatorSet) -> tuple[tuple[JointActuator, ...], ...]:
    """The joints of each group that have the same numbers, in the robot's order; their pose may differ."""
    found: dict[object, list[JointActuator]] = {}
    for actuator in actuators.joints:
        found.setdefault(_numbers(actuator), []).append(actuator)
    return tuple(tuple(members) for members in found.values())


def _numbers(actuator: JointActuator) -> object:
    delay = actuator.delay
    return (
        actuator.group,
        actuator.kind,
        actuator.level,
        actuator.command,
        tuple((name, q.value) for name, q in actuator.quantities() if name != "default_position"),
        None if delay is None else (delay.low, delay.high, delay.sampling),
        actuator.network,
    )
