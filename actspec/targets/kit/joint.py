"""One joint on its way into a target: its law, and what is lost of it, each kind of loss once for all targets."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Collection, Sequence
from dataclasses import replace
from typing import Generic, TypeVar

from actspec.diagnostics import Collector, Place, listed, many, shortened
from actspec.fields import BY_IR, is_placeholder
from actspec.ir import ActuatorSet, Approximation, Command, Delay, JointActuator, Level, Origin, Quantity
from actspec.laws import TorqueLaw, delay_steps, law_of
from actspec.laws.actuator import LackedFigure
from actspec.patterns import resolve_patterns
from actspec.readings.drive import NOT_IN_FILE, largest
from actspec.resolution.quantities import Reports
from actspec.robot.view import JointView, RobotView
from actspec.targets.base import TargetOptions
from actspec.targets.kit.network import network_clip
from actspec.targets.kit.python_text import grouped
from actspec.targets.kit.sizes import (
    Torque,
    command_range_error,
    held_step_error,
    line_error,
    lined,
    static_error,
    viscous_error,
)
from actspec.units import format_number, format_quantity

T = TypeVar("T")


class JointLosses:
    """Collects what a target loses of one joint.

    Attributes:
        actuator: What the spec asks for.
        unit: Unit of a torque here.
        lost: What the target cannot hold.
    """

    def __init__(self, actuator: JointActuator, target: str) -> None:
        self.actuator = actuator
        self.unit = actuator.effort_limit.unit
        self.lost: list[Approximation] = []
        self._target = target

    def approximate(
        self, field: str, asked: str, emitted: str, why: str, error: float | None, unit: str | None = None
    ) -> None:
        """Record a loss; see `Approximation`."""
        self.lost.append(
            Approximation(
                self._target, self.actuator.joint, field, asked, emitted, why, error, unit or self.unit
            )
        )

    def lose_line(self, asked: str, emitted: str, why: str, law: TorqueLaw, torque: Torque) -> None:
        """Record the loss of a torque-speed line or curve.

        Args:
            asked: In words, as the two that follow; see `Approximation`.
            emitted: What is written.
            why: Reason.
            law: What the spec asks for.
            torque: What the target computes.
        """
        size = line_error(law, torque, self.actuator.velocity_limit.unit)
        self.approximate("torque_speed_curve", asked, emitted, why, size.error)
        self.lost[-1] = replace(self.lost[-1], at=size.at, beyond=size.beyond)

    def torque(self, value: float) -> str:
        """A torque with its unit."""
        return format_quantity(value, self.unit)

    @property
    def speed_limit(self) -> float | None:
        """The joint's speed limit [rad/s or m/s]; None: unknown."""
        return self.actuator.velocity_limit.value

    def curve_text(self, law: TorqueLaw, unit: str = "") -> str:
        """A line or curve in words; `unit`: that of a curve's speeds."""
        if law.curve is not None:
            drive, brake, knee, no_load = law.curve
            tail = f" {unit}" if unit else ""
            return (
                f"curve: drive {self.torque(drive)}, brake {self.torque(brake)}, knee {format_number(knee)}, "
                f"no load {format_number(no_load)}{tail}"
            )
        speed = format_quantity(law.no_load_speed, self.actuator.velocity_limit.unit)
        return f"line from {format_quantity(law.stall_torque, self.unit)} to {speed}"

    def no_break_away(self, keeps: str | None, one_number: str, no_effect: str) -> None:
        """Report static friction above the dry one, and its Stribeck effect, as lost, where there are any.

        Args:
            keeps: What acts where the spec states no dry friction; None: nothing is written there, or lost.
            one_number: Why there is one friction.
            no_effect: Why there is no Stribeck effect.
        """
        actuator = self.actuator
        coulomb = actuator.friction_coulomb.value
        static = None if actuator.friction_static is None else actuator.friction_static.value
        if static is None or static <= (coulomb or 0.0) or (coulomb is None and keeps is None):
            return
        error = static - (coulomb or 0.0)
        emitted = str(keeps) if coulomb is None else self.torque(coulomb)
        self.approximate("friction.static", self.torque(static), emitted, one_number, error)
        self.no_stribeck(no_effect, error)

    def no_stribeck(self, why: str, error: float) -> None:
        """Report the Stribeck effect as lost, if there is one."""
        stribeck = self.actuator.stribeck_velocity
        if stribeck is not None and stribeck.known:
            asked = format_quantity(stribeck.value, stribeck.unit)
            self.approximate("friction.stribeck_velocity", asked, "none", why, error)

    def no_velocity_limit(self, why: str, emitted: str = "none") -> None:
        """Report the joint's speed limit as lost, if there is one."""
        limit = self.actuator.velocity_limit
        if limit.known:
            asked = format_quantity(limit.value, limit.unit)
            self.approximate("velocity_limit", asked, emitted, why, None)


class JointEmission(JointLosses, Generic[T]):
    """A joint with its law, on its way into one version of a simulator.

    Attributes:
        dialect: Version that is written.
        step: Physics step [s].
        collector: Takes errors.
        law: What the target is held to; of a network, the clip of its torque.

    Raises: ValueError: the law lacks a number; it says which.
    """

    def __init__(
        self, actuator: JointActuator, dialect: T, step: float, target: str, collector: Collector
    ) -> None:
        super().__init__(actuator, target)
        self.dialect, self.step, self.collector = dialect, step, collector
        self.law: TorqueLaw = self._law()

    def _law(self) -> TorqueLaw:
        return law_of(network_clip(self.actuator) if self.learned else self.actuator)

    @property
    def learned(self) -> bool:
        """Whether a network makes the torque."""
        return self.actuator.level is Level.ACTUATOR_NET

    @property
    def opaque(self) -> bool:
        """Whether the torque of a command is not known here; it is at most from one limit to the other."""
        return self.learned

    @property
    def both_limits(self) -> float | None:
        """From one limit to the other [N*m or N]: what a network answers to a command is not known here."""
        limit = self.law.effort_limit
        return 2.0 * limit if math.isfinite(limit) else None

    @property
    def late(self) -> float | None:
        """Size of a command that comes too early, too late or unfiltered [N*m or N]."""
        return self.both_limits if self.learned else held_step_error(self.law)

    def no_filter(self, why: str) -> None:
        """Report the command filter as lost, if there is one."""
        cutoff = self.law.filter_cutoff
        if cutoff is not None:
            self.approximate("command_filter", f"{format_number(cutoff)} Hz", "none", why, self.late)

    def no_bias(self, why: str) -> None:
        """Report the encoder bias as lost, if it does anything."""
        bias = self.law.encoder_bias
        if bias == 0.0 or not (self.learned or self.actuator.command is Command.POSITION):
            return
        error = (
            self.both_limits
            if self.opaque
            else static_error(self.law, replace(self.law, encoder_bias=0.0).torque)
        )
        asked = format_quantity(bias, self.actuator.encoder_bias.unit)
        self.approximate("encoder_bias", asked, "none", why, error)

    def no_range(self, why: str) -> None:
        """Report the clamp of the command as lost, if there is one."""
        if self.law.command_range is None:
            return
        low, high = self.law.command_range
        unit = {
            Command.POSITION: self.actuator.encoder_bias.unit,
            Command.VELOCITY: self.actuator.velocity_limit.unit,
        }
        asked = f"{format_number(low)} to {format_number(high)} {unit.get(self.actuator.command, self.unit)}"
        self.approximate("command_range", asked, "none", why, self.range_error())

    def range_error(self) -> float | None:
        """Size of a lost clamp of the command [N*m or N]."""
        return (
            self.both_limits if self.opaque else command_range_error(self.law, self.actuator.position_range)
        )

    def no_viscous(self, why: str, emitted: str = "none", kept: float | None = 0.0) -> None:
        """Report the passive viscous friction as lost.

        Args:
            why: Why it cannot be written.
            emitted: What acts in its place.
            kept: How much of it acts all the same [N*m*s/rad or N*s/m]; None: unknown.
        """
        viscous = self.actuator.friction_viscous
        error = None if kept is None else viscous_error(self.law, viscous.require() - kept, self.speed_limit)
        self.approximate(
            "friction.viscous", format_quantity(viscous.value, viscous.unit), emitted, why, error
        )

    def drive_side(self, why: str) -> TorqueLaw:
        """The drive side of an asymmetric curve, as a line through knee and no-load speed, with what it loses."""
        line, number = lined(self.law), format_number
        assert line.stall_torque is not None and line.no_load_speed is not None
        emitted = (
            f"line from {number(line.stall_torque)} to {number(line.no_load_speed)}, "
            f"cut at {number(line.effort_limit)}"
        )
        self.lose_line(self.curve_text(self.law), emitted, why, self.law, line.torque)
        return line

    def one_delay(
        self,
        why: str,
        said: Callable[[int], str],
        size: Callable[[float], float | None],
        *,
        steps: str = "steps",
        off: bool = True,
        none: str = "",
    ) -> tuple[int, float]:
        """The delay as one whole number of steps, with what that loses of it and of its range.

        Args:
            why: Why there is one delay.
            said: A number of steps in words.
            size: How large the loss of being so late is [s to N*m or N].
            steps: What steps are called.
            off: Say how far the ends of the range are off.
            none: Why there is no delay at all; "": there is one.

        Returns: the steps, and the delay that was asked for [s]; 0 and 0 without one, or where it is unknown.
        """
        delay = self.actuator.delay
        if delay is None or delay.high == 0.0:
            return 0, 0.0
        asked_range = f"{_range(delay)}, drawn each {delay.sampling}"
        ranged = delay.low != delay.high
        nominal = delay.nominal.value if ranged else delay.high
        if nominal is None:
            self.approximate(
                "delay.range", asked_range, "none", f"{why}, and the nominal is unknown", size(delay.high)
            )
            return 0, 0.0
        count, loss = delay_steps(nominal, self.step)
        if none and count:
            self.approximate("delay", _ms(nominal), said(0), none, size(count * self.step))
            count = 0
        elif abs(loss) > 1e-9:
            self.approximate(
                "delay",
                _ms(nominal),
                said(count),
                f"a delay is a whole number of {steps}; {_ms(abs(loss))} "
                f"{'more' if loss > 0 else 'less'} than asked",
                size(abs(loss)),
            )
        if ranged:
            reach = max(abs(count * self.step - end) for end in (delay.low, delay.high))
            more = f"; at most {_ms(reach)} off" if off else ""
            self.approximate("delay.range", asked_range, said(count), f"{why}{more}", size(reach))
        return count, nominal

    def ms(self, steps: int) -> str:
        """A number of physics steps in words: `10 ms (2 steps of 5 ms)`."""
        plural = "" if steps == 1 else "s"
        return f"{_ms(steps * self.step)} ({steps} step{plural} of {_ms(self.step)})"

    def count(self, steps: int) -> str:
        """A number of physics steps in words: `2 steps of 5 ms`."""
        return f"{steps} step{'' if steps == 1 else 's'} of {_ms(self.step)}"


def delta_action_loss(actuators: ActuatorSet, target: str, why: str) -> tuple[Approximation, ...]:
    """The robot-wide delta action, which no target holds; empty without one."""
    if actuators.delta_action is None:
        return ()
    asked = os.path.basename(actuators.delta_action.manifest)
    return (Approximation(target, "", "delta_action", asked, "none", why, None),)


def joint_by_joint(
    actuators: ActuatorSet,
    make: Callable[[JointActuator, Collector], T | None],
    shared: Collection[str],
    collector: Collector,
) -> list[T]:
    """What each joint becomes, with the errors of all.

    Args:
        actuators: What the spec asks for.
        make: Makes one joint's part; None after an error. A ValueError names a number that the law lacks, or a
            delay that is too long: it has the first code of `shared`.
        shared: Codes of errors that several joints of a group can have: said once, with their names.
        collector: Takes the errors.
    """
    found = []
    reports = Reports()
    for actuator in actuators.joints:
        # A collector of its own: an error of one joint does not hide the next one's.
        own = Collector()
        part = None
        try:
            part = make(actuator, own)
        except ValueError as err:
            lacked = err if isinstance(err, LackedFigure) and err.span is not None else None
            field, span = ("", actuator.span) if lacked is None else (f".{lacked.field}", lacked.span)
            own.at(f"actuators.{actuator.group}{field}", span).error(next(iter(shared)), str(err))
        for item in own:
            if item.code in shared:
                message = item.message.removeprefix(f"{actuator.joint}: ")
                reports.error(item.code, actuator.joint, message, item.where, item.span, item.help)
            else:
                collector.add(item)
        if part is not None:
            found.append(part)
    reports.tell(collector)
    return found


def unlimited_joints(actuators: ActuatorSet, robot: RobotView) -> frozenset[str]:
    """Joints whose torque neither the spec nor the joint's own limit in the robot's file bounds.

    A torque-speed line bounds it, and so does a clamp of a commanded torque.
    """
    return frozenset(
        actuator.joint
        for actuator in actuators.joints
        if not actuator.effort_limit.known
        and (actuator.stall_torque is None or not actuator.stall_torque.known)
        and actuator.curve is None
        and not (actuator.command is Command.EFFORT and actuator.command_range is not None)
        and not _is_bounded(robot.joint(actuator.joint))
    )


def _is_bounded(joint: JointView | None) -> bool:
    """Whether the file's joint has a limit of its own; 0 and a placeholder are nobody's."""
    limit = largest(joint.effort_range) if joint is not None and joint.effort_range is not None else 0.0
    return limit > 0.0 and not is_placeholder(limit)


def unknown_passive(
    actuators: ActuatorSet,
    target: str,
    simulator: str,
    takes: Callable[[str, str], str],
    fields: Collection[str] = ("armature", "friction_coulomb", "friction_viscous"),
) -> tuple[Approximation, ...]:
    """Where the spec says that armature or friction is unknown, and something acts all the same.

    What the spec does not speak of is not asked for, and nothing is lost.

    Args:
        actuators: What the spec asks for.
        target: Name of the target.
        simulator: What writes no number: `Isaac Lab`.
        takes: Of a joint and an attribute of `JointActuator`, what acts: `the USD's own`.
        fields: The attributes that the target can hold.
    """
    return tuple(
        Approximation(
            target,
            actuator.joint,
            BY_IR[name].spec,
            "unknown",
            takes(actuator.joint, name),
            f"{simulator} has to take a number",
            None,
            actuator.effort_limit.unit,
        )
        for name in fields
        for actuator in actuators.joints
        if _said_unknown(getattr(actuator, name))
    )


def _said_unknown(quantity: Quantity) -> bool:
    """Whether the spec writes `unknown`: not that all are silent, nor that a file hides its own number."""
    return quantity.value is None and quantity.span is not None and quantity.note != NOT_IN_FILE


def own_number(quantity: Quantity, whose: str, default: str) -> str:
    """What acts in place of an unknown, in words: `0.1 N*m*s/rad, the file's`.

    Args:
        quantity: What the robot's file has.
        whose: Of a number that the file states: `the file's`.
        default: Of one that it does not: `MuJoCo's default`.
    """
    if quantity.value is None:
        return whose
    text = format_quantity(quantity.value, quantity.unit)
    return f"{text}, {default if quantity.origin is Origin.DEFAULT else whose}"


def warn_unknown_armature(
    actuators: ActuatorSet, target: str, code: str, simulator: str, collector: Collector
) -> None:
    """Warn where a simulator takes an armature that nobody states, and that `accept` does not name.

    Args:
        actuators: What the spec asks for.
        target: Name of the target.
        code: Of the warning.
        simulator: What it takes: `Isaac Lab takes the USD's`.
        collector: Takes the warning.
    """
    unknown = [actuator for actuator in actuators.joints if actuator.armature.value is None]
    if unknown and f"{target}.armature" not in dict(actuators.accept):
        help = "state armature, or rotor_inertia and gear_ratio of the motor"
        warn_unknown(unknown, ("armature",), code, simulator, collector, help)


def warn_unknown(
    joints: Sequence[JointActuator],
    fields: Sequence[str],
    code: str,
    simulator: str,
    collector: Collector,
    help: str = "",
) -> None:
    """One warning about figures that nobody states, with each group that lacks them and its joints.

    Args:
        joints: Which lack them, at least one.
        fields: Attributes of `JointActuator` that are unknown at each of them.
        code: Of the warning.
        simulator: What it takes: `Isaac Lab takes the USD's`.
        collector: Takes the warning.
        help: What to do; default: state them.
    """
    groups = grouped(joints, lambda actuator: actuator.group)
    stated, alone = " and ".join(BY_IR[name].spec for name in fields), len(fields) == 1
    where = "actuators"
    if len(groups) == 1:
        where += f".{groups[0][0]}" + (f".{fields[0]}" if alone else "")
        names = listed(actuator.joint for actuator in joints)
    else:
        # Eight joints in all, but two of each group.
        most = max(2, 8 // len(groups))
        names = listed(f"{group} ({listed((a.joint for a in members), most)})" for group, members in groups)
    what = f"the {BY_IR[fields[0]].noun}" if alone else stated
    collector.at(where, getattr(joints[0], fields[0]).span or joints[0].span).warning(
        code,
        f"{what} of {many(len(joints), 'joint')} {'is' if alone else 'are'} unknown, and {simulator}: {names}",
        help or f"state {stated}",
    )


def _ms(seconds: float) -> str:
    return f"{format_number(seconds * 1e3)} ms"


def _range(delay: Delay) -> str:
    return f"{format_number(delay.low * 1e3)} to {_ms(delay.high)}"


def pattern_of(
    patterns: Sequence[str],
    names: Sequence[str],
    option: str,
    code: str,
    options: TargetOptions,
    collector: Collector,
) -> dict[str, str]:
    """Joint to the pattern that selects it; one that selects none, or another's joint, is an error.

    Args:
        patterns: Keys of the option, which is a mapping.
        names: All joints.
        option: Its name: `joint_paths`.
        code: Of the errors.
        options: The target's.
        collector: Takes the errors, at the patterns' places.
    """
    matches = resolve_patterns(patterns, names)

    def at(pattern: str) -> Place:
        return collector.at(options.where(f"{option}.{pattern}"), options.span(f"{option}[{pattern}]"))

    for problem in matches.problems:
        at(problem.pattern).error(code, problem.message, problem.help)
    found: dict[str, str] = {}
    for pattern, matched in zip(patterns, matches.by_pattern, strict=True):
        twice = [name for name in matched if found.setdefault(name, pattern) != pattern]
        if twice:
            message = f"{listed(twice)}: matched by '{shortened(found[twice[0]])}' too"
            at(pattern).error(code, message, "let one pattern match each joint")
    return found
