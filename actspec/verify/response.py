"""Response agreement: where an engine takes a joint against where the law takes it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import listed, shortened
from actspec.fields import units_of
from actspec.ir import ActuatorSet, Command, JointActuator, Origin, Quantity
from actspec.laws import TorqueLaw
from actspec.simulate.experiment import COURSES, Experiment, design
from actspec.simulate.reference import DrivenJoint, PassiveFriction, Trajectory
from actspec.targets.base import Approximation
from actspec.targets.kit.sizes import lined
from actspec.units import format_quantity
from actspec.verify.agreement import At, Row, Skip, TargetFiles, alike, worst_of
from actspec.verify.engines.asking import BodyFriction, EngineMissing, EngineRefused, EngineResponse, answered
from actspec.verify.joint_laws import JointLaws
from actspec.verify.torque import SLACK

if TYPE_CHECKING:
    from actspec.laws.arrays import Floats as Array

SOFT = "friction.soft"
"""What MuJoCo's dry friction is known to lose: it is a soft constraint, and creeps. It is no key of `accept`."""

CHANGES = 3.0
"""Times the engine's own change from h to h/2 that it may be off the law. An engine of first order is off by twice the
change, to within a few per cent either way (2.00 to 2.02 for a step of the A1, up to 2.4 where a joint comes to stand):
the change itself, and what is left from h/2 on, which is another change. Chosen: that rest is doubled."""
COARSE = 0.5
"""Most change from h to h/2, of how far the law moves the joint. Beyond, the step decides the response. Chosen: an
explicit drive that brakes a joint changes it by h kd / (2 J), so this is a drive that stops its joint within one step;
at twice that it is unstable, and the response changes by all of it and more."""
SMALL = 0.01
"""Of the largest movement of a joint in any course: a course that moves it less is not looked at closer. Chosen."""
DOUBLE, SINGLE = 1e-6, 1e-5
"""Of how far the joint moves: what the reference and rounding may add. Source: measured, 3e-7 for the reference where a
filtered command breaks a joint away, 1e-6 for single precision."""

GONE = 1e12
"""Position from which on a response is no motion, but what the integration makes of a drive that it cannot follow [rad
or m]. Chosen: without any friction 1000 N*m on 1e-5 kg*m^2 make 1e10 of 15 s."""

OWN_BODY = frozenset(("mujoco", "mjlab"))
"""Kinds whose engine moves the joint itself, with its own friction. For the others actspec moves a body by the engine's
torque, semi-implicitly, with the friction that the target was given: PhysX is in no package."""

UNMOVED = frozenset(("delay.range", "delay.sampling", "velocity_limit", "delta_action"))
"""Approximations that change no response: a range is set to its nominal, the speed limit and the
delta action are outside of the drive."""


@dataclass(frozen=True, slots=True)
class ExpectedResponse:
    """Two responses of one joint: what the spec asks for, and what is left of it by what is known to be lost.

    Attributes:
        asked: As the spec has it.
        left: As the target is known to make it.
        losses: Why they differ; empty where they do not.
        sized: Whether `left` is known; else any response is allowed.
    """

    asked: DrivenJoint
    left: DrivenJoint
    losses: tuple[str, ...]
    sized: bool


def expected(target: TargetFiles, experiment: Experiment) -> tuple[ExpectedResponse, ...]:
    """What is expected of each joint of a target."""
    return tuple(
        _expected(target, actuator, law, float(inertia))
        for actuator, law, inertia in zip(experiment.joints, experiment.laws, experiment.inertia, strict=True)
    )


def kept_friction(wanted: Sequence[ExpectedResponse]) -> BodyFriction:
    """Friction of the joints that is left, for a body that actspec moves."""
    found = [want.left.friction for want in wanted]
    return [dry.coulomb for dry in found], [dry.viscous for dry in found]


def _expected(
    target: TargetFiles, actuator: JointActuator, law: TorqueLaw, inertia: float
) -> ExpectedResponse:
    losses = [loss for loss in target.losses if loss.joint in (actuator.joint, "")]
    own_body = target.options.kind in OWN_BODY
    friction = PassiveFriction.of(actuator)
    if own_body:
        dry, viscous = map(_acting, (actuator.friction_coulomb, actuator.friction_viscous))
        friction = replace(friction, coulomb=dry, viscous=viscous)
        inertia += 0.0 if actuator.armature.known else _acting(actuator.armature)
    else:
        # The body's friction is not the engine's: what the target cannot say of it is no loss here.
        friction = PassiveFriction(friction.coulomb, friction.viscous)
    left_law, left, sized, counted = law, friction, True, []
    for loss in losses:
        changed = without_loss(loss, left_law, left)
        if changed is None:
            sized = False
            counted.append(loss.key)
        elif changed != (left_law, left):
            counted.append(loss.key)
            left_law, left = changed
    if own_body and left.coulomb > 0.0:
        left = replace(left, soft=True)
        counted.append(SOFT)
    return ExpectedResponse(
        DrivenJoint(law, friction, inertia), DrivenJoint(left_law, left, inertia), tuple(counted), sized
    )


def _acting(quantity: Quantity) -> float:
    """A figure of a joint's body; where the spec does not state it, the model's own, which the target keeps."""
    if quantity.value is not None:
        return quantity.value
    own = (lost.value for lost in quantity.lost if lost.origin in (Origin.MODEL, Origin.DEFAULT))
    return next(own, None) or 0.0


def without_loss(
    loss: Approximation, law: TorqueLaw, friction: PassiveFriction
) -> tuple[TorqueLaw, PassiveFriction] | None:
    """Law and friction that a loss leaves; None: it does not say."""
    gone = loss.emitted in ("none", "left out")
    if loss.field in UNMOVED or loss.open:
        return law, friction
    if loss.field == "torque_speed_curve":
        if loss.emitted.startswith("line from "):
            return lined(law), friction
        if loss.emitted.startswith("a clip at "):
            return replace(law, stall_torque=None, no_load_speed=None, curve=None), friction
    elif loss.field == "friction.viscous" and loss.emitted.startswith("in damping"):
        return replace(law, kd=law.kd + friction.viscous), replace(friction, viscous=0.0)
    elif loss.field == "friction.static":
        return law, replace(friction, static=None)
    elif loss.field == "delay" and not gone:
        # Rounded to steps, as the law itself is here.
        return law, friction
    elif gone and loss.field in _GONE_LAW:
        return replace(law, **_GONE_LAW[loss.field]), friction
    elif gone and loss.field in _GONE_FRICTION:
        return law, replace(friction, **_GONE_FRICTION[loss.field])
    return None


_GONE_LAW: Mapping[str, dict[str, Any]] = {
    "command_filter": {"filter_cutoff": None},
    "delay": {"delay": 0.0},
    "encoder_bias": {"encoder_bias": 0.0},
    "command_range": {"command_range": None},
}
_GONE_FRICTION: Mapping[str, dict[str, Any]] = {
    "friction.coulomb": {"coulomb": 0.0, "static": None, "stribeck_velocity": None},
    "friction.viscous": {"viscous": 0.0},
    "friction.stribeck_velocity": {"static": None, "stribeck_velocity": None},
}


Moved = Mapping[tuple[int, DrivenJoint], Trajectory]
"""Column of an experiment and what moves it to every course of it."""


def reference(experiment: Experiment, wanted: Iterable[Sequence[ExpectedResponse]]) -> Moved:
    """What the laws make of everything that is expected."""
    driven = list(
        dict.fromkeys((i, one) for each in wanted for i, e in enumerate(each) for one in (e.asked, e.left))
    )
    return dict(zip(driven, experiment.reference(driven), strict=True))


def response_rows(
    target: TargetFiles,
    actuators: ActuatorSet,
    experiment: Experiment,
    wanted: Sequence[ExpectedResponse],
    moved: Moved,
    answer: EngineResponse,
) -> Iterator[Row | Skip]:
    """Rows of an engine's responses, those of joints with the same numbers together, and what the step does not carry.

    Args:
        target: What was asked.
        actuators: What the spec asks for.
        experiment: What its joints were commanded.
        wanted: Of each joint of the experiment.
        moved: From `reference`.
        answer: What the engine made of the experiment.
    """
    place = {name: i for i, name in enumerate(experiment.names)}
    for members in alike(actuators):
        known = [place[a.joint] for a in members if a.joint in place and a.joint not in answer.errors]
        found = [
            [_judge(_Course(target.name, experiment, i, course, answer), wanted[i], moved) for i in known]
            for course in range(len(COURSES))
        ]
        judged = [[row for row in rows if isinstance(row, Row)] for rows in found]
        steps = {experiment.joints[i].joint: _finest(wanted[i].asked) for i in known}
        # Where the spec's own drive is too fast for the spec's own step, the target is not what differs.
        coarse = [
            row
            for rows in judged
            for row in rows
            if row.code == "VFY113" and row.max_error is not None and experiment.step > steps[row.joint]
        ]
        names = {row.joint for row in coarse}
        for rows in judged:
            kept = (row for row in rows if row.ok or row.joint not in names)
            yield from worst_of(((_share(row), row) for row in kept), lambda row: row.code)
        if coarse:
            worst = max(coarse, key=_share)
            yield Skip(
                target.name,
                worst.group,
                "responses",
                f"{listed([name for name in steps if name in names], 4)}: the step of {experiment.step * 1e3:g} ms is "
                f"too coarse for the drive: {worst.message} ({worst.joint}, {worst.quantity})",
                f"timing.physics_dt of at most {min(steps[name] for name in names) * 1e3:.2g} ms, or smaller gains",
            )
        if diverging := [one for rows in found for one in rows if isinstance(one, _Diverging)]:
            first = min(diverging, key=lambda one: one.time)
            lost = listed(dict.fromkeys(one.joint for one in diverging), 4)
            yield Skip(
                target.name,
                first.group,
                "responses",
                f"{lost}: the law's own integration diverges at {first.time:g} s ({first.joint}, {first.quantity}): "
                f"gains or friction are too large for {format_quantity(first.inertia, first.unit, 3)} at a step of "
                f"{experiment.step * 1e3:g} ms",
                "state the armature, or correct kp, kd or friction.viscous",
            )


def _finest(driven: DrivenJoint) -> float:
    """Largest step [s] in which a drive neither stops its joint, J/kd, nor turns it round, sqrt(J/kp)."""
    law, inertia = driven.law, driven.inertia
    damped = inertia / law.kd if law.kd > 0.0 else math.inf
    return min(damped, math.sqrt(inertia / law.kp)) if law.kp > 0.0 else damped


def response_skips(
    target: TargetFiles, experiment: Experiment, answer: EngineResponse | None = None
) -> Iterator[Skip]:
    """Joints that cannot be let move, and those that an engine could not."""
    for group, reason in experiment.skipped.items():
        yield Skip(target.name, group, "responses", reason)
    groups = {actuator.joint: actuator.group for actuator in experiment.joints}
    for joint, reason in ({} if answer is None else answer.errors).items():
        yield Skip(target.name, groups[joint], "responses", shortened(f"{joint}: {reason}", 300))


def broken_response(target: TargetFiles, why: EngineRefused) -> Row:
    """The row of a file that an engine does not let move."""
    message = f"its simulator does not let it move: {why}"
    return target.fault("responses", "VFY111", message)


def _share(row: Row) -> float:
    return math.inf if row.max_error is None else row.max_error / row.tolerance


@dataclass(frozen=True, slots=True)
class _Diverging:
    """One joint in one course whose law's own response is `GONE` from a time on [s]; its inertia, with the unit."""

    group: str
    joint: str
    quantity: str
    time: float
    inertia: float
    unit: str


@dataclass(frozen=True, slots=True)
class _Course:
    """One joint in one course: its command, and what became of it."""

    target: str
    experiment: Experiment
    joint: int
    course: int
    answer: EngineResponse

    @property
    def row(self) -> Row:
        """A row without numbers."""
        actuator = self.experiment.joints[self.joint]
        who = (actuator.group, actuator.joint, 1, COURSES[self.course], units_of(actuator.kind).position)
        return Row(self.target, *who, None, 0.0, False, engine=self.answer.engine)

    @property
    def q(self) -> tuple[Array, Array]:
        """Positions in the engine's steps, and in half of them."""
        whole, halved = (part[:, self.course, self.joint] for part in (self.answer.q, self.answer.halved))
        return whole, halved

    def at(self, law: Trajectory, errors: Array) -> At:
        """Where an error is largest, and the state of a law then."""
        experiment, k = self.experiment, int(errors.argmax())
        now = min(k, len(experiment.command) - 1)
        command, q = float(experiment.command[now, self.course, self.joint]), float(law.q[now, self.course])
        mine = experiment.laws[self.joint]
        torque = self.answer.torque[now, self.course, self.joint] - law.torque[now, self.course]
        return At(
            error=command - (q + mine.encoder_bias) if mine.command is Command.POSITION else None,
            velocity=float(law.qd[now, self.course]),
            command=command,
            step=k,
            time=k * experiment.step,
            torque=float(torque),
        )


def _judge(case: _Course, want: ExpectedResponse, moved: Moved) -> Row | _Diverging:
    """The row of one joint in one course; no row where the law's own response ends."""
    import numpy as np

    row, (q, halved) = case.row, case.q
    if not (np.isfinite(q).all() and np.isfinite(halved).all()):
        return replace(row, code="VFY113", message="the simulation diverges at the physics step")
    asked, left = moved[case.joint, want.asked], moved[case.joint, want.left]
    # Where it is nan, too.
    near = (np.abs(asked.q[:, case.course]) < GONE) & (np.abs(left.q[:, case.course]) < GONE)
    if not near.all():
        time = int(near.argmin()) * case.experiment.step
        unit = units_of(case.experiment.joints[case.joint].kind).inertia
        return _Diverging(row.group, row.joint, row.quantity, time, want.asked.inertia, unit)
    error, rest = (np.abs(q - lane.q[:, case.course]) for lane in (asked, left))
    changes = np.abs(q - halved)
    moves = np.ptp(asked.q, axis=0)
    scale = max(float(moves[case.course]), SMALL * float(moves.max()))
    change, worst = float(changes.max()), float(error.max())
    size = scale + float(np.abs(asked.q[0]).max())
    strict = CHANGES * change + (SINGLE if case.answer.single else DOUBLE) * size
    row = replace(row, max_error=worst, tolerance=strict, ok=True, at=case.at(asked, error))
    if change > COARSE * scale:
        message = (
            f"half the step changes the response by {change:.3g} {row.unit}, "
            f"{change / scale:.0%} of how far the law moves the joint"
        )
        at = case.at(asked, changes)
        return replace(
            row, max_error=change, tolerance=COARSE * scale, ok=False, code="VFY113", message=message, at=at
        )
    if worst <= strict:
        return row
    row = replace(row, approximations=want.losses)
    if not want.sized:
        return replace(row, tolerance=math.inf)
    if float(rest.max()) <= strict:
        return replace(row, tolerance=strict + SLACK * float(np.abs(asked.q - left.q)[:, case.course].max()))
    beside = ", known approximations aside" if want.losses else ""
    message = f"the response is {float(rest.max()):.3g} {row.unit} off the law's{beside}"
    at = case.at(left, rest)
    return replace(row, max_error=float(rest.max()), ok=False, code="VFY112", message=message, at=at)


Ask = Callable[[Experiment, BodyFriction], EngineResponse]
"""An engine's `respond`, which knows its files."""


def responses(
    targets: Sequence[TargetFiles], actuators: ActuatorSet, laws: JointLaws, asks: Mapping[str, Ask]
) -> tuple[dict[str, list[Row]], list[Skip]]:
    """Rows by target, and what could not be asked.

    Args:
        targets: All of them.
        actuators: What the spec asks for.
        laws: Of its joints.
        asks: TargetFiles to its engine, for those that there are.
    """
    from actspec.processes import cores

    mine = [target for target in targets if target.name in asks]
    if not mine or not laws.laws:
        return {}, []
    experiment = design(actuators, laws.laws)
    if not experiment.joints:
        return {}, [skip for target in mine for skip in response_skips(target, experiment)]
    wanted = {target.name: expected(target, experiment) for target in mine}
    with ThreadPoolExecutor(max_workers=cores()) as pool:
        futures = {
            target.name: pool.submit(
                answered, asks[target.name], experiment, kept_friction(wanted[target.name])
            )
            for target in mine
        }
        # Here, while the engines run in processes of their own.
        moved = reference(experiment, wanted.values())
        answers = {name: future.result() for name, future in futures.items()}
    rows: dict[str, list[Row]] = {}
    skipped: list[Skip] = []
    for target in mine:
        answer = answers[target.name]
        skipped += response_skips(target, experiment, answer if isinstance(answer, EngineResponse) else None)
        if isinstance(answer, EngineResponse):
            found = response_rows(target, actuators, experiment, wanted[target.name], moved, answer)
            rows[target.name] = []
            for one in found:
                if isinstance(one, Row):
                    rows[target.name].append(one)
                else:
                    skipped.append(one)
        elif isinstance(answer, EngineMissing):
            skipped.append(answer.skip(target.name, "responses"))
        else:
            rows[target.name] = [broken_response(target, answer)]
    return rows, skipped
