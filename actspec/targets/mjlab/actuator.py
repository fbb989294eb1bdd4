"""What one joint's actuator becomes in mjlab: a class, its fields, and what it cannot hold.

- ideal_pd: `BuiltinPositionActuatorCfg`, `BuiltinVelocityActuatorCfg` or `BuiltinMotorActuatorCfg`; exact.
- dc_motor: `DcMotorActuatorCfg`, whose clip is the law's, for every command: a velocity command has no
  stiffness, an effort command no gains at all. `BuiltinDcMotorActuatorCfg` is not used: the gains of its
  MuJoCo are in volts, and mjlab's randomisation of them inverts kd.
- actuator_net: `LearnedMlpActuatorCfg`.
Delays are steps of the simulation; there is no filter, no bias and no clamp of the command.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from actspec.diagnostics import Collector
from actspec.ir import Command, JointActuator, Level, Quantity
from actspec.laws import TorqueLaw, delay_steps, law_of
from actspec.robot.view import JointView
from actspec.targets.approximation import (
    command_range_error,
    held_step_error,
    lined,
    speed_scale,
    static_error,
)
from actspec.targets.base import Approximation
from actspec.targets.mjlab.versions import MjlabDialect
from actspec.targets.network_file import read_network, tap_stride
from actspec.targets.python_text import provenance, py, stated
from actspec.units import format_quantity

NO_LINE = 1e9
"""Stall torque and no-load speed that leave only effort_limit [N*m, rad/s], where a class must have a line."""

HELD = "10**9"
"""Steps between two draws of a lag: longer than any episode, so that it is drawn once after each reset."""


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a cfg.

    Attributes:
        name: Its name.
        text: Its value as Python.
        note: Unit and origin; "" without.
    """

    name: str
    text: str
    note: str = ""


@dataclass(frozen=True, slots=True)
class Cfg:
    """One joint's actuator in mjlab's words.

    Attributes:
        actuator: What it is of.
        kind: Class.
        fields: Without names of joints and delay.
        delay: `delay_*` fields; empty without.
        lost: What the class cannot hold.
        network: Name and bytes of its network file; None without one.
    """

    actuator: JointActuator
    kind: str
    fields: tuple[Field, ...]
    delay: tuple[Field, ...]
    lost: tuple[Approximation, ...]
    network: tuple[str, bytes] | None = None

    @property
    def key(self) -> tuple[object, ...]:
        """What joints that share one cfg have in common."""
        said = tuple((field.name, field.text) for field in (*self.fields, *self.delay))
        return (self.actuator.group, self.kind, said, self.network)


def cfg_of(
    actuator: JointActuator,
    joint: JointView | None,
    dialect: MjlabDialect,
    step: float,
    target: str,
    collector: Collector,
) -> Cfg | None:
    """Choose class and fields for one joint; None after an error.

    Args:
        actuator: What the spec asks for.
        joint: The robot's joint; None where the spec names no model.
        dialect: mjlab version that is written.
        step: Simulation step [s].
        target: Name of the target, for approximations.
        collector: Takes errors.
    """
    try:
        return _Chooser(actuator, joint, dialect, step, target, collector).choose()
    except ValueError as err:
        # The law itself says which number it lacks, or that a delay is too long.
        collector.error("MJL001", str(err), where=f"actuators.{actuator.group}", span=actuator.span)
        return None


class _Chooser:
    def __init__(
        self,
        actuator: JointActuator,
        joint: JointView | None,
        dialect: MjlabDialect,
        step: float,
        target: str,
        collector: Collector,
    ) -> None:
        self.actuator = actuator
        self.joint = joint
        self.dialect = dialect
        self.step = step
        self.target = target
        self.collector = collector
        self.where = f"actuators.{actuator.group}"
        self.lost: list[Approximation] = []
        self.unit = actuator.effort_limit.unit
        self.learned = actuator.level is Level.ACTUATOR_NET
        self.law = _law(actuator)

    def approximate(self, field: str, asked: str, emitted: str, why: str, error: float | None) -> None:
        self.lost.append(
            Approximation(self.target, self.actuator.joint, field, asked, emitted, why, error, self.unit)
        )

    def torque(self, value: float) -> str:
        return format_quantity(value, self.unit)

    def choose(self) -> Cfg | None:
        actuator, law = self.actuator, self.law
        network: tuple[str, bytes] | None = None
        if self.learned:
            found = self.network()
            if found is None:
                return None
            kind = "LearnedMlpActuatorCfg"
            more, network = found
            fields = [*self.line(law), *more]
        elif actuator.level is Level.DC_MOTOR:
            kind, fields = "DcMotorActuatorCfg", [*self.gains(always=True), *self.line(law)]
        elif actuator.command is Command.EFFORT:
            kind, fields = "BuiltinMotorActuatorCfg", self.limit(law.effort_limit, required=True)
        elif actuator.command is Command.VELOCITY:
            kind = "BuiltinVelocityActuatorCfg"
            fields = [*self.gains(), *self.limit(law.effort_limit)]
        elif law.kp > 0.0:
            kind = "BuiltinPositionActuatorCfg"
            fields = [*self.gains(), *self.limit(law.effort_limit)]
        else:
            # mjlab divides by the stiffness of a position actuator.
            kind = "IdealPdActuatorCfg"
            fields = [*self.gains(always=True), *self.limit(law.effort_limit)]
        fields += self.passive(law)
        delay = self.delay(law)
        self.command_path(law)
        if self.collector.failed:
            return None
        return Cfg(actuator, kind, tuple(fields), delay, tuple(self.lost), network)

    def gains(self, *, always: bool = False) -> list[Field]:
        """Stiffness and damping, mjlab's names of kp and kd; `always`: 0 where the law has none."""
        found = []
        for name, quantity in (("stiffness", self.actuator.kp), ("damping", self.actuator.kd)):
            if quantity is not None and quantity.known:
                found.append(_number(name, quantity))
            elif always:
                found.append(Field(name, "0.0"))
        return found

    def limit(self, limit: float, *, required: bool = False) -> list[Field]:
        """`effort_limit`; left out where nobody knows it and the class takes that."""
        asked = self.actuator.effort_limit
        if math.isfinite(limit):
            if asked.value == limit:
                return [_number("effort_limit", asked)]
            return [Field("effort_limit", py(limit), f"{self.unit}, the curve's")]
        if required:
            self.collector.error(
                "MJL002",
                f"{self.actuator.joint}: effort_limit is unknown, and the class that mjlab has for it needs a number",
                where=f"{self.where}.effort_limit",
                span=asked.span or self.actuator.span,
                help="state effort_limit, or peak_torque of the motor",
            )
        return []

    def line(self, law: TorqueLaw) -> list[Field]:
        """Limit and torque-speed line."""
        actuator = self.actuator
        if law.curve is not None:
            return self.curve(law, law.curve)
        limit = self.limit(law.effort_limit, required=True)
        if law.stall_torque is None:
            why = "no torque-speed line: effort_limit alone"
            names = ("saturation_effort", "velocity_limit")
            return [*limit, *(Field(name, py(NO_LINE), why) for name in names)]
        assert actuator.stall_torque is not None and actuator.no_load_speed is not None
        return [
            *limit,
            _number("saturation_effort", actuator.stall_torque, "at standstill"),
            _number("velocity_limit", actuator.no_load_speed, "no-load speed"),
        ]

    def curve(self, law: TorqueLaw, curve: tuple[float, float, float, float]) -> list[Field]:
        """The drive side of an asymmetric curve, as a line through knee and no-load speed."""
        drive, brake, knee, no_load = curve
        line = lined(law)
        assert line.stall_torque is not None
        speed = self.actuator.velocity_limit.unit
        self.approximate(
            "torque_speed_curve",
            f"curve: drive {self.torque(drive)}, brake {self.torque(brake)}, knee {knee:g}, no load {no_load:g}",
            f"line from {line.stall_torque:g} to {no_load:g}, cut at {line.effort_limit:g}",
            "mjlab has one line for driving and braking",
            static_error(law, line.torque),
        )
        return [
            *self.limit(line.effort_limit),
            Field(
                "saturation_effort",
                py(line.stall_torque),
                f"{self.unit}, of the line through the curve's knee",
            ),
            Field("velocity_limit", py(no_load), f"{speed}, no-load speed"),
        ]

    def network(self) -> tuple[list[Field], tuple[str, bytes]] | None:
        """Fields of the network and its file; None after an error."""
        actuator = self.actuator
        where = f"{self.where}.network"
        found = read_network(actuator.network, self.where, actuator.span, self.collector)
        if found is None or actuator.network is None:
            return None
        manifest, span = found.manifest, actuator.network.span
        if actuator.command is not Command.POSITION:
            self.collector.error(
                "MJL003",
                f"{actuator.joint}: mjlab's network takes position errors, got command {actuator.command.value}",
                where=f"{self.where}.command",
                span=span,
            )
        if manifest.kind != "mlp":
            self.collector.error(
                "MJL004",
                f"mjlab has no actuator class for a network of kind {manifest.kind}",
                where=where,
                span=span,
                help="its LearnedMlpActuatorCfg takes an mlp; Isaac Lab has a class for an lstm",
            )
        taps = manifest.taps
        if taps != tuple(range(len(taps))):
            self.collector.error(
                "MJL005",
                f"mjlab gives a network the samples 0 to n - 1 in this order, got taps {list(taps)}",
                where=where,
                span=span,
                help=f"train on taps {list(range(len(taps)))}",
            )
        stride = tap_stride(manifest, self.step, where, span, self.collector)
        if stride is not None and stride != 1 and len(taps) > 1:
            self.collector.error(
                "MJL006",
                f"mjlab samples a network's history at every physics step, {self.step * 1e3:g} ms, and its taps are "
                f"{stride * self.step * 1e3:g} ms apart",
                where=where,
                span=span,
                help=f"train at {self.step * 1e3:g} ms, or set timing.physics_dt to {stride * self.step * 1e3:g} ms",
            )
        if manifest.initial_history != "first_sample" and len(taps) > 1:
            self.approximate(
                "network.initial_history",
                manifest.initial_history,
                "first_sample",
                "mjlab fills a network's history with its first sample after a reset",
                2.0 * self.law.effort_limit if math.isfinite(self.law.effort_limit) else None,
            )
        order = "pos_vel" if manifest.inputs == "position_velocity" else "vel_pos"
        return [
            Field("network_file", f"str(FOLDER / {py(found.name)})"),
            Field("pos_scale", py(manifest.position_scale), "of target - measured"),
            Field("vel_scale", py(manifest.velocity_scale)),
            Field("torque_scale", py(manifest.torque_scale)),
            Field("input_order", py(order)),
            Field("history_length", py(len(taps)), f"every {self.step * 1e3:g} ms"),
        ], (found.name, found.data)

    def passive(self, law: TorqueLaw) -> list[Field]:
        """Armature and friction of the joint; what the spec does not state keeps the model's."""
        actuator, joint = self.actuator, self.joint
        fields = []
        for name, quantity, own in (
            ("armature", actuator.armature, None if joint is None else joint.armature),
            ("frictionloss", actuator.friction_coulomb, None if joint is None else joint.frictionloss),
        ):
            if stated(quantity):
                fields.append(_number(name, quantity))
            elif not self.dialect.keeps_model and own:
                fields.append(Field(name, py(own), f"{quantity.unit}, the model's own, else it would be 0"))
        viscous = actuator.friction_viscous
        if stated(viscous):
            own_viscous = 0.0 if joint is None else joint.damping
            if self.dialect.viscous_damping:
                fields.append(_number("viscous_damping", viscous))
            elif joint is None or viscous.require() != own_viscous:
                difference = abs(viscous.require() - own_viscous)
                self.approximate(
                    "friction.viscous",
                    format_quantity(viscous.value, viscous.unit),
                    "the model's own" if joint is None else format_quantity(own_viscous, viscous.unit),
                    f"mjlab {self.dialect.text} has no viscous_damping (1.3 and later have)",
                    None if joint is None else difference * 2.0 * speed_scale(law),
                )
        coulomb = actuator.friction_coulomb.value or 0.0
        static = actuator.friction_static.value if actuator.friction_static is not None else None
        if static is not None and static != coulomb:
            self.approximate(
                "friction.static",
                self.torque(static),
                self.torque(coulomb),
                "frictionloss is one number for sticking and sliding",
                static - coulomb,
            )
        if actuator.velocity_limit.known:
            limit = actuator.velocity_limit
            self.approximate(
                "velocity_limit",
                format_quantity(limit.value, limit.unit),
                "none",
                "mjlab has no speed limit of a joint; its velocity_limit is the no-load speed",
                None,
            )
        return fields

    def delay(self, law: TorqueLaw) -> tuple[Field, ...]:
        """`delay_*`, in steps of the simulation."""
        delay = self.actuator.delay
        if delay is None or delay.nominal.value is None:
            return ()
        losses: tuple[float, ...]
        if delay.low == delay.high:
            steps, loss = delay_steps(delay.nominal.value, self.step)
            low = high = steps
            asked, losses = f"{delay.nominal.value * 1e3:g} ms", (loss,)
            field, note = "delay", provenance(delay.nominal)
        else:
            (low, late), (high, later) = (delay_steps(end, self.step) for end in (delay.low, delay.high))
            asked, losses = f"{delay.low * 1e3:g} to {delay.high * 1e3:g} ms", (late, later)
            field, note = "delay.range", f"drawn each {delay.sampling}, {provenance(delay.nominal)}"
        got = f"{low}" if low == high else f"{low} to {high}"
        if any(abs(loss) > 1e-9 for loss in losses):
            said = " and ".join(f"{abs(x) * 1e3:g} ms {'more' if x > 0 else 'less'}" for x in losses if x)
            self.approximate(
                field,
                asked,
                f"{got} steps of {self.step * 1e3:g} ms",
                f"a delay is a whole number of steps; {said} than asked",
                held_step_error(law),
            )
        if high == 0:
            return ()
        fields = [
            Field("delay_min_lag", py(low), f"steps of {self.step * 1e3:g} ms: {asked}, {note}"),
            Field("delay_max_lag", py(high)),
        ]
        if low != high and delay.sampling == "episode":
            fields += [
                Field("delay_update_period", HELD, "drawn at a reset, then held"),
                Field("delay_per_env_phase", "False"),
            ]
        return tuple(fields)

    def command_path(self, law: TorqueLaw) -> None:
        """Filter, bias and clamp of the command: no actuator of mjlab has one."""
        actuator = self.actuator
        full = 2.0 * law.effort_limit if math.isfinite(law.effort_limit) else None
        if law.filter_cutoff is not None:
            self.approximate(
                "command_filter",
                f"{law.filter_cutoff:g} Hz",
                "none",
                "mjlab's actuators have no filter on the command",
                held_step_error(law),
            )
        if law.encoder_bias != 0.0 and actuator.command is Command.POSITION:
            bias = format_quantity(law.encoder_bias, actuator.encoder_bias.unit)
            self.approximate(
                "encoder_bias",
                bias,
                "none",
                f"mjlab's actuators have no bias; an event {self.dialect.bias_event} with the range "
                f"({law.encoder_bias:g}, {law.encoder_bias:g}) sets it",
                full if self.learned else static_error(law, replace(law, encoder_bias=0.0).torque),
            )
        if law.command_range is not None:
            low, high = law.command_range
            unit = {
                Command.POSITION: actuator.encoder_bias.unit,
                Command.VELOCITY: actuator.velocity_limit.unit,
            }
            self.approximate(
                "command_range",
                f"{low:g} to {high:g} {unit.get(actuator.command, self.unit)}",
                "none",
                "mjlab's actuators do not clamp the command; its action term can (`clip`)",
                full if self.learned else command_range_error(law, actuator.position_range),
            )


def _law(actuator: JointActuator) -> TorqueLaw:
    """The joint's law; of a network, the clip of its torque, which is then the command."""
    if actuator.level is not Level.ACTUATOR_NET:
        return law_of(actuator)
    level = (
        Level.DC_MOTOR if actuator.curve is not None or actuator.stall_torque is not None else Level.IDEAL_PD
    )
    return law_of(replace(actuator, level=level, command=Command.EFFORT, kp=None, kd=None))


def _number(name: str, quantity: Quantity, what: str = "") -> Field:
    about = [quantity.unit, *([what] if what else []), provenance(quantity)]
    return Field(name, py(quantity.require()), ", ".join(about))
