"""One joint on its way into a cfg: what is asked for, what is written of it, what is lost."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector
from actspec.ir import Command, JointActuator, Level, Quantity
from actspec.laws import TorqueLaw, delay_steps, law_of
from actspec.simulators.isaaclab import FrictionUnit, IsaacLabDialect
from actspec.targets.kit.joint import JointEmission
from actspec.targets.kit.python_text import origin_of, stated
from actspec.targets.kit.sizes import (
    held_step_error,
    summed_viscous_error,
)
from actspec.units import format_quantity

if TYPE_CHECKING:
    from actspec.targets.kit.network import NetworkWithManifest


@dataclass(frozen=True, slots=True)
class CfgField:
    """One keyword of a cfg.

    Attributes:
        name: Keyword.
        value: Number, text or list; None keeps the USD's own number.
        note: What stands behind it: unit and origin.
        scalar: The cfg takes one value a group.
        file: The value is a file beside the module.
    """

    name: str
    value: float | str | list[int] | None
    note: str = ""
    scalar: bool = False
    file: bool = False


class IsaacJoint(JointEmission[IsaacLabDialect]):
    """A joint with the losses and remarks that gather as fields are chosen.

    Attributes:
        network: The network and the physics steps between its taps; None without one.
        limit: Effort limit [N*m or N]; infinity where it is unknown.
        gains_known: Whether the drive has all gains that it is to have.
        remarks: Comments above the fields.

    Raises: ValueError: the law lacks a number; it says which.
    """

    def __init__(
        self,
        actuator: JointActuator,
        dialect: IsaacLabDialect,
        step: float,
        target: str,
        collector: Collector,
        network: tuple[NetworkWithManifest, int] | None,
    ) -> None:
        self.gains_known = all(gain is None or gain.known for gain in (actuator.kp, actuator.kd))
        super().__init__(actuator, dialect, step, target, collector)
        self.network = network
        self.speed_unit = actuator.velocity_limit.unit
        self.limit = actuator.effort_limit.require() if actuator.effort_limit.known else math.inf
        self.remarks: list[str] = []

    def _law(self) -> TorqueLaw:
        """The law; of unknown gains its clamp, as a drive whose command is the torque."""
        if self.learned or self.gains_known:
            return super()._law()
        return law_of(replace(self.actuator, command=Command.EFFORT))

    @property
    def opaque(self) -> bool:
        """Whether the torque of a command is not known here; it is at most from one limit to the other."""
        return self.learned or not self.gains_known

    def known(self, name: str, quantity: Quantity) -> CfgField:
        """A known number as a keyword."""
        return CfgField(name, quantity.require(), self.note(quantity))

    def note(self, quantity: Quantity) -> str:
        """Unit, origin and formula, as a comment has them."""
        return "; ".join(filter(None, (quantity.unit, origin_of(quantity), quantity.formula)))


def lags(joint: IsaacJoint, *, filtered: bool) -> tuple[int, int]:
    """Least and largest lag in physics steps, with what is lost; 0 and 0 without a delay."""
    delay = joint.actuator.delay
    if delay is None or delay.high == 0.0:
        return 0, 0
    ranged = delay.low != delay.high
    if ranged and joint.dialect.lag_range:
        low, high = delay_steps(delay.low, joint.step), delay_steps(delay.high, joint.step)
        worst = max(abs(low.loss), abs(high.loss))
        if worst > 1e-9:
            joint.approximate(
                "delay.range",
                f"{delay.low * 1e3:g} to {delay.high * 1e3:g} ms",
                f"{joint.ms(low.steps)} to {joint.ms(high.steps)}",
                f"a delay is a whole number of physics steps; at most {worst * 1e3:g} ms off",
                held_step_error(joint.law, filtered=filtered, late=worst),
            )
        if delay.sampling != "episode" and low.steps != high.steps:
            joint.approximate(
                "delay.sampling",
                f"drawn each {delay.sampling}",
                "drawn at each reset",
                "Isaac Lab draws lags at a reset",
                held_step_error(joint.law, filtered=filtered, late=delay.high - delay.low),
            )
        return low.steps, high.steps
    why = f"the actuators of Isaac Lab {joint.dialect.text} have one fixed delay"

    def size(late: float) -> float:
        return held_step_error(joint.law, filtered=filtered, late=late)

    steps, _ = joint.one_delay(why, joint.ms, size, steps="physics steps")
    return steps, steps


def lag_fields(joint: IsaacJoint, steps: tuple[int, int]) -> list[CfgField]:
    """Least and largest lag of a class that delays."""
    delay = joint.actuator.delay
    assert delay is not None
    first = f"physics steps of {joint.step * 1e3:g} ms"
    if delay.nominal.known:
        first += f"; {origin_of(delay.nominal)}"
    return [
        CfgField("min_delay", steps[0], first, scalar=True),
        CfgField("max_delay", steps[1], f"{steps[1] * joint.step * 1e3:g} ms", scalar=True),
    ]


def no_delay(joint: IsaacJoint, why: str) -> None:
    """Report the delay as lost, if there is one."""
    delay = joint.actuator.delay
    if delay is None or delay.high == 0.0:
        return
    asked = "unknown" if delay.nominal.value is None else f"{delay.nominal.value * 1e3:g} ms"
    if delay.low != delay.high:
        asked += f" ({delay.low * 1e3:g} to {delay.high * 1e3:g} ms)"
    joint.approximate("delay", asked, "none", why, joint.late)


def no_command_path(joint: IsaacJoint) -> None:
    """Report filter, encoder bias and clamp of the command as lost, where there are any."""
    joint.no_filter("no stock class filters the command")
    joint.no_bias("no stock class has an encoder bias")
    ends = joint.actuator.command_range
    if ends is not None and any(end.known for end in ends):
        low, high = (format_quantity(end.value, end.unit) for end in ends)
        why = "no stock class clamps the command"
        joint.approximate("command_range", f"{low} to {high}", "none", why, joint.range_error())


def gain_fields(joint: IsaacJoint) -> list[CfgField]:
    """Stiffness and damping; passive viscous friction is in the latter where it has no field of its own."""
    actuator = joint.actuator
    stiffness = _gain(joint, "stiffness", actuator.kp, "no position command")
    damping = _gain(joint, "damping", actuator.kd, "no gain on the speed")
    viscous = actuator.friction_viscous
    if joint.dialect.viscous or not stated(viscous) or not viscous.require():
        return [stiffness, damping]
    value, asked = viscous.require(), format_quantity(viscous.value, viscous.unit)
    why = _no_field(joint, "viscous")
    if not viscous_in_damping(actuator, joint.dialect):
        joint.no_viscous(why)
        return [stiffness, damping]
    assert isinstance(damping.value, float)
    total = damping.value + value
    joint.approximate(
        "friction.viscous",
        asked,
        f"in damping, {total:g} in all, inside the torque limit",
        why,
        summed_viscous_error(joint.law, value, joint.speed_limit),
    )
    note = f"{viscous.unit}; kd {damping.value:g} + passive viscous {value:g}"
    return [stiffness, replace(damping, value=total, note=note)]


def viscous_in_damping(actuator: JointActuator, dialect: IsaacLabDialect) -> float:
    """The passive viscous friction that is written as a part of `damping` [N*m*s/rad or N*s/m]."""
    viscous = actuator.friction_viscous
    if dialect.viscous or not stated(viscous) or actuator.level is Level.ACTUATOR_NET:
        return 0.0
    # With a speed command the sum would follow the command too.
    if actuator.command is Command.VELOCITY or (actuator.kd is not None and not actuator.kd.known):
        return 0.0
    return viscous.require()


def _gain(joint: IsaacJoint, name: str, quantity: Quantity | None, absent: str) -> CfgField:
    if quantity is None:
        return CfgField(name, 0.0, absent)
    if quantity.value is None:
        return CfgField(name, None, "unknown: the USD's own", scalar=True)
    return joint.known(name, quantity)


def joint_fields(joint: IsaacJoint, *, summed: bool = True) -> list[CfgField]:
    """Armature and friction of the joint, in the units of the solver.

    Args:
        summed: Whether `gain_fields` takes a viscous friction that has no field; a network's class has none.
    """
    actuator = joint.actuator
    fields = []
    if stated(actuator.armature):
        fields.append(joint.known("armature", actuator.armature))
    fields += _dry_friction(joint)
    viscous = actuator.friction_viscous
    if stated(viscous):
        if joint.dialect.viscous:
            fields.append(joint.known("viscous_friction", viscous))
        elif not summed and viscous.require():
            joint.no_viscous(_no_field(joint, "viscous"))
    return fields


def _dry_friction(joint: IsaacJoint) -> list[CfgField]:
    coulomb, static = joint.actuator.friction_coulomb, joint.actuator.friction_static
    kinetic = coulomb.require() if stated(coulomb) else None
    sticking = static.require() if static is not None and static.known else None
    if kinetic is None and sticking is None:
        return []
    unit = joint.dialect.friction
    stuck = static if sticking is not None else None
    _no_stribeck(joint, sticking, kinetic)
    if unit is FrictionUnit.EFFORT:
        return _effort_friction(joint, coulomb, stuck, kinetic)
    if unit is FrictionUnit.EFFORT_ONE:
        named = stuck if kinetic is None and stuck is not None else coulomb
        value = named.require()
        if sticking is not None and sticking != value:
            joint.approximate(
                "friction.static",
                format_quantity(sticking, joint.unit),
                format_quantity(value, joint.unit),
                "the Newton backend has one dry friction for sticking and sliding",
                sticking - value,
            )
        return [joint.known("friction", named)]
    largest = max(kinetic or 0.0, sticking or 0.0)
    if largest == 0.0 and unit is not FrictionUnit.DEAD:
        # No friction is none in every unit.
        both = ["friction"] + ["dynamic_friction"] * (unit is FrictionUnit.COEFFICIENT_VISCOUS)
        return [CfgField(name, 0.0, "none, in every unit") for name in both]
    if largest > 0.0:
        asked = format_quantity(largest, joint.unit)
        why = _no_field(joint, "dry")
        for name, torque in (("coulomb", kinetic), ("static", sticking)):
            if torque and not (name == "static" and torque == kinetic):
                joint.approximate(
                    f"friction.{name}", format_quantity(torque, joint.unit), "left out", why, torque
                )
        cure = (
            f"raise `friction` until the joint starts to move at {asked}"
            if unit is not FrictionUnit.DEAD
            else "update Isaac Lab, or set it through the PhysX view after the start"
        )
        joint.remarks.append(f"friction is left out, {asked} asked for: {why}. To calibrate: {cure}.")
    return []


def _effort_friction(
    joint: IsaacJoint, coulomb: Quantity, static: Quantity | None, kinetic: float | None
) -> list[CfgField]:
    """Static and dynamic friction as torques; PhysX needs dynamic <= static."""
    first = static if static is not None else coulomb
    fields = [CfgField("friction", first.require(), f"static, {joint.note(first)}")]
    if kinetic is not None:
        fields.append(CfgField("dynamic_friction", kinetic, f"sliding, {joint.note(coulomb)}"))
    else:
        joint.remarks.append("Nobody states the sliding friction: the USD's own.")
    return fields


def _no_stribeck(joint: IsaacJoint, sticking: float | None, kinetic: float | None) -> None:
    """Report the Stribeck effect as lost, if there is one; no solver has it."""
    if sticking is not None and sticking > (kinetic or 0.0):
        effort = joint.dialect.friction is FrictionUnit.EFFORT
        at_once = "the solver goes from static to sliding friction at once"
        joint.no_stribeck(
            at_once if effort else "no solver has a Stribeck effect", sticking - (kinetic or 0.0)
        )


def _no_field(joint: IsaacJoint, kind: str) -> str:
    """Why a friction cannot be written."""
    where = f"Isaac Lab {joint.dialect.text} on Isaac Sim {joint.dialect.sim_text}"
    unit = joint.dialect.friction
    if unit is FrictionUnit.DEAD:
        return f"{where} never writes friction to the solver"
    if kind == "viscous":
        return f"{where} has no viscous friction of a joint"
    return f"in {where} ({joint.dialect.backend_text}) it is a factor on the joint's load, not a torque"
