"""One joint on its way into a target of one class a joint: its law, and the losses that several targets have alike."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

from actspec.diagnostics import Collector
from actspec.ir import Approximation, Command, JointActuator, Level
from actspec.laws import TorqueLaw, law_of
from actspec.targets.base import EmittedFile
from actspec.targets.kit.sizes import command_range_error, held_step_error
from actspec.units import format_quantity


class LosingJoint:
    """A joint with the losses that gather as its fields are chosen; each target adds its dialect.

    Attributes:
        actuator: What the spec asks for.
        step: Physics step [s].
        collector: Takes errors.
        where: The group's place in the spec.
        unit: Unit of a torque here.
        law: What the target is held to; of a network, the clip of its torque.
        lost: What the target cannot hold.

    Raises: ValueError: the law lacks a number; it says which.
    """

    def __init__(self, actuator: JointActuator, step: float, target: str, collector: Collector) -> None:
        self.actuator = actuator
        self.step = step
        self.collector = collector
        self.where = f"actuators.{actuator.group}"
        self.unit = actuator.effort_limit.unit
        self.law: TorqueLaw = law_of(network_clip(actuator) if self.learned else actuator)
        self.lost: list[Approximation] = []
        self._target = target

    @property
    def learned(self) -> bool:
        """Whether a network makes the torque."""
        return self.actuator.level is Level.ACTUATOR_NET

    def approximate(self, field: str, asked: str, emitted: str, why: str, error: float | None) -> None:
        """Record a loss; see `Approximation`."""
        self.lost.append(
            Approximation(self._target, self.actuator.joint, field, asked, emitted, why, error, self.unit)
        )

    def torque(self, value: float) -> str:
        """A torque with its unit."""
        return format_quantity(value, self.unit)

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
            self.approximate("command_filter", f"{cutoff:g} Hz", "none", why, self.late)

    def no_range(self, why: str) -> None:
        """Report the clamp of the command as lost, if there is one."""
        if self.law.command_range is None:
            return
        low, high = self.law.command_range
        unit = {
            Command.POSITION: self.actuator.encoder_bias.unit,
            Command.VELOCITY: self.actuator.velocity_limit.unit,
        }
        error = self.both_limits
        if not self.learned:
            error = command_range_error(self.law, self.actuator.position_range)
        asked = f"{low:g} to {high:g} {unit.get(self.actuator.command, self.unit)}"
        self.approximate("command_range", asked, "none", why, error)

    def no_break_away(self, keeps: str, one_number: str, no_effect: str) -> None:
        """Report static friction above the dry one, and its Stribeck effect, as lost, where there are any.

        Args:
            keeps: What acts where the spec states no dry friction.
            one_number: Why there is one friction.
            no_effect: Why there is no Stribeck effect.
        """
        actuator = self.actuator
        coulomb = actuator.friction_coulomb.value
        static = None if actuator.friction_static is None else actuator.friction_static.value
        if static is None or static <= (coulomb or 0.0):
            return
        error = static - (coulomb or 0.0)
        emitted = keeps if coulomb is None else self.torque(coulomb)
        self.approximate("friction.static", self.torque(static), emitted, one_number, error)
        stribeck = actuator.stribeck_velocity
        if stribeck is not None and stribeck.known:
            asked = format_quantity(stribeck.value, stribeck.unit)
            self.approximate("friction.stribeck_velocity", asked, "none", no_effect, error)


def network_clip(actuator: JointActuator) -> JointActuator:
    """The clip of a network's torque, as a drive whose command is the torque."""
    line = (actuator.stall_torque, actuator.no_load_speed)
    known = all(part is not None and part.known for part in line)
    level = Level.DC_MOTOR if known or actuator.curve is not None else Level.IDEAL_PD
    return replace(actuator, level=level, command=Command.EFFORT, kp=None, kd=None)


def network_files(
    networks: Iterable[tuple[JointActuator, tuple[str, bytes] | None]],
    code: str,
    differ: str,
    collector: Collector,
) -> list[EmittedFile]:
    """The networks' files, each once.

    Args:
        networks: A joint and the name and bytes of its network; None: it has none.
        code: Of the error for two different networks of one name.
        differ: What such two do: `differ`, and in what.
        collector: Takes that error.
    """
    found: dict[str, bytes] = {}
    for actuator, network in networks:
        if network is None:
            continue
        name, data = network
        if found.setdefault(name, data) != data:
            collector.error(
                code,
                f"two networks are called '{name}' and {differ}",
                where=f"actuators.{actuator.group}.network",
                span=actuator.span,
                help="rename one: both are written into one folder",
            )
    return [EmittedFile(name, data) for name, data in found.items()]
