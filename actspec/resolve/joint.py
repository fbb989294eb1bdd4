"""One joint's actuator from everything that is said about it: spec, results, motor, robot file."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from actspec.diagnostics import Collector, Span
from actspec.ir import (
    Command,
    Delay,
    InertiaRange,
    JointActuator,
    JointKind,
    Level,
    Network,
    Origin,
    Quantity,
    Randomization,
)
from actspec.resolve.model_values import ModelValues
from actspec.resolve.motor import JointMotor, Transmission, joint_motor
from actspec.resolve.quantities import choose, conflict, tidy, unit_of, unknown, written
from actspec.resolve.reports import Reports
from actspec.resolve.stated import Stated
from actspec.spec.derive import DerivedGain
from actspec.spec.fields import CommandRange, SpecDelay
from actspec.spec.models import CommandFilter, Randomize
from actspec.spec.rules import range_of
from actspec.spec.validate import dotted
from actspec.spec.values import SpecValue
from actspec.units import Kind, format_quantity


class JointResolver:
    """Resolves the fields of one joint by the precedence
    authored > identified > derived > model > default."""

    def __init__(self, stated: Stated, model: ModelValues, collector: Collector, reports: Reports) -> None:
        self.stated = stated
        self.model = model
        self.collector = collector
        self.reports = reports
        self.joint = stated.binding.joint
        self.kind = stated.kind
        self.command = Command(stated.group.command)
        self.level = Level(stated.group.level)
        self.motor = self._motor()

    # -- small steps ---------------------------------------------------------------------------

    def error(self, code: str, message: str, field: str, help: str | None = None) -> None:
        self.reports.error(
            code, self.joint.name, message, dotted(self.stated.path(field)), self.span(field), help
        )

    def span(self, field: str) -> Span:
        return self.stated.spec.span(*self.stated.path(field))

    def unit(self, kind: Kind) -> str:
        return unit_of(kind, self.kind)

    def identified(self, field: str, kind: Kind) -> Quantity | None:
        """The fitted value of a field, or None."""
        result = self.stated.result
        if result is None:
            return None
        value = getattr(result.friction, field.partition(".")[2]) if "." in field else getattr(result, field)
        if not isinstance(value, SpecValue) or value.value is None:
            return None
        file = str(self.stated.group.identified)
        span = self.stated.spec.span("actuators", self.stated.binding.group, "identified")
        if value.linear is not None and value.linear is not (self.kind is JointKind.SLIDE):
            self.collector.error(
                "RES001",
                f"'{self.joint.name}' is a {self.kind.value} joint, but {file} gives its {field} as {value.written}",
                where=dotted(("actuators", self.stated.binding.group, "identified")),
                span=span,
                help="a hinge is in rad and N*m, a slide in m and N",
            )
        found = written(value, self.unit(kind), span, Origin.IDENTIFIED)
        return replace(found, source=found.source or file)

    def number(
        self,
        field: str,
        kind: Kind,
        *,
        derived: Quantity | None = None,
        rest: tuple[Quantity | None, ...] = (),
    ) -> Quantity | None:
        """A field by precedence; None when nobody says anything about it."""
        authored = self.stated.authored(field, kind)
        fitted = self.identified(field, kind) if field in FITTED else None
        self.compare(field, self.stated.get(field), authored, fitted)
        return choose(authored, fitted, derived, *rest)

    def compare(
        self,
        field: str,
        value: object,
        authored: Quantity | None,
        fitted: Quantity | None,
        word: str | None = None,
    ) -> None:
        """Report an identified number that is asked for and missing, or far from the authored one."""
        if isinstance(value, SpecValue) and value.identified and fitted is None:
            self.error(
                "RES002",
                f"{field} is to be the identified value, but the results have none",
                field,
                f"see {self.stated.group.identified}, or write the number here",
            )
        apart = conflict(authored, fitted)
        if apart is not None:
            self.collector.warning(
                "RES010",
                f"{self.joint.name}: {field}: {apart}",
                where=dotted(self.stated.path(field)),
                span=self.span(field),
                help="the authored value is used; to use the fitted one write "
                f"`{word or field.split('.')[-1]}: identified`",
            )

    # -- parts ---------------------------------------------------------------------------------

    def _motor(self) -> JointMotor | None:
        if self.stated.motor is None:
            return None
        reduction = self.stated.get("reduction")
        ratio = reduction.value if isinstance(reduction, SpecValue) and reduction.value is not None else 1.0
        motors = self.stated.get("motors_per_joint") or 1
        return joint_motor(
            self.stated.motor,
            str(self.stated.get("motor")),
            Transmission(ratio, motors),
            self.kind,
            self.stated.spec.span,
        )

    def effort_limit(self) -> Quantity:
        """L: authored, else the motor's continuous, else its peak torque, else the file's, else unknown."""
        value = self.stated.get("effort_limit")
        motor = self.motor
        candidates: list[Quantity] = []
        if motor is not None:
            named = {"continuous": motor.continuous_torque, "peak": motor.peak_torque}
            both = ", ".join(f"{name} {format_quantity(q.value, q.unit)}" for name, q in named.items())
            if isinstance(value, str):
                named = {value: named[value]}
            for name, torque in named.items():
                if torque.known:
                    note = torque.note
                    if not isinstance(value, str):
                        note = f"{name} torque of the motor; {both}" + (f"; {note}" if note else "")
                    formula = torque.formula or f"{name}_torque of the motor"
                    candidates.append(replace(torque, origin=Origin.DERIVED, formula=formula, note=note))
            if isinstance(value, str) and not candidates:
                self.error(
                    "RES008",
                    f"the limit is to be the {value} torque of the motor '{self.stated.get('motor')}', "
                    "which is unknown",
                    "effort_limit",
                    f"state {value}_torque of the motor, or a torque here",
                )
            stall = motor.curve.drive_torque if motor.curve is not None else motor.stall_torque
            if not candidates and stall is not None and stall.known:
                candidates.append(
                    replace(
                        stall,
                        origin=Origin.DERIVED,
                        formula=stall.formula or "stall torque of the motor",
                        note="the motor states neither continuous nor peak torque",
                    )
                )
        found = choose(
            self.stated.authored("effort_limit", Kind.TORQUE), *candidates, self.model.effort_limit
        )
        return found if found is not None else unknown(self.unit(Kind.TORQUE))

    def armature(self) -> Quantity:
        derived = None
        if self.motor is not None and self.motor.reflected_inertia.known:
            reflected = self.motor.reflected_inertia
            derived = replace(
                reflected,
                origin=Origin.DERIVED,
                formula=reflected.formula or "reflected inertia of the motor",
            )
        found = self.number("armature", Kind.INERTIA, derived=derived, rest=(self.model.armature,))
        return found if found is not None else unknown(self.unit(Kind.INERTIA))

    def inertia_for_gain(
        self, gain: DerivedGain, armature: Quantity, held: InertiaRange | None, field: str
    ) -> tuple[float, str] | None:
        """Inertia that a derived gain names, with its name for the formula."""
        unit = self.unit(Kind.INERTIA)
        if isinstance(gain.inertia, SpecValue):
            assert gain.inertia.value is not None
            return gain.inertia.value, format_quantity(gain.inertia.value, unit)
        if gain.inertia == "joint":
            if held is None:
                self.error(
                    "RES003",
                    f"{field} is derived from the joint's inertia, which the model does not tell",
                    field,
                    "use `inertia: reflected` or state the inertia",
                )
                return None
            return held.reference, f"{format_quantity(held.reference, unit)} (inertia held, reference pose)"
        if self.motor is not None and self.motor.reflected_inertia.known:
            value = self.motor.reflected_inertia.require()
            return value, f"{format_quantity(value, unit)} (reflected inertia)"
        if armature.known and armature.origin in (Origin.AUTHORED, Origin.IDENTIFIED):
            value = armature.require()
            return value, f"{format_quantity(value, unit)} (armature, {armature.origin.value})"
        self.error(
            "RES003",
            f"{field} is derived from the reflected inertia, which nobody states",
            field,
            "give the motor rotor_inertia and gear_ratio (or reflected_inertia), or name the inertia: "
            "{inertia: 0.01 kg*m^2}",
        )
        return None

    def kp(self, effort: Quantity, armature: Quantity, held: InertiaRange | None) -> Quantity | None:
        if self.command is not Command.POSITION or self.level is Level.ACTUATOR_NET:
            return self.number("kp", Kind.STIFFNESS) if self.command is Command.POSITION else None
        gain = self.stated.get("kp")
        derived = None
        unit = self.unit(Kind.STIFFNESS)
        if isinstance(gain, DerivedGain):
            if gain.method == "torque_at_error":
                fraction, error = gain.numbers["fraction"].value, gain.numbers["error"].value
                assert fraction is not None and error is not None
                if not effort.known:
                    self.error(
                        "RES004",
                        "kp is derived from effort_limit, which is unknown",
                        "kp",
                        "state effort_limit",
                    )
                    return unknown(unit)
                formula = (
                    f"{fraction:g} x {format_quantity(effort.value, effort.unit)} (effort_limit) / "
                    f"{format_quantity(error, self.unit(Kind.POSITION))}"
                )
                derived = Quantity(
                    tidy(fraction * effort.require() / error),
                    unit,
                    Origin.DERIVED,
                    span=self.span("kp"),
                    formula=formula,
                )
            else:
                inertia = self.inertia_for_gain(gain, armature, held, "kp")
                if inertia is None:
                    return unknown(unit)
                frequency = gain.numbers["frequency"].value
                assert frequency is not None
                # As a product: a power of floats raises where a product is infinite.
                omega = 2.0 * math.pi * frequency
                derived = Quantity(
                    tidy(inertia[0] * omega * omega),
                    unit,
                    Origin.DERIVED,
                    span=self.span("kp"),
                    formula=f"{inertia[1]} x (2 pi {format_quantity(frequency, 'Hz')})^2",
                )
        found = self.number("kp", Kind.STIFFNESS, derived=derived, rest=(self.model.kp,))
        if found is None and not (isinstance(gain, SpecValue) and gain.identified):
            self.error(
                "RES005",
                "kp is not stated, and the robot's file has no position servo to take it from",
                "kp",
                "write kp: 25 N*m/rad (or {derive: ...}), or `unknown` to leave the file's actuator alone",
            )
        return unknown(unit) if found is None else found

    def kd(self, kp: Quantity | None, armature: Quantity, held: InertiaRange | None) -> Quantity | None:
        if self.command is Command.EFFORT:
            return None
        if self.level is Level.ACTUATOR_NET:
            return self.number("kd", Kind.VELOCITY_GAIN)
        gain = self.stated.get("kd")
        derived = None
        unit = self.unit(Kind.VELOCITY_GAIN)
        if isinstance(gain, DerivedGain):
            inertia = self.inertia_for_gain(gain, armature, held, "kd")
            if inertia is None:
                return unknown(unit)
            if kp is None or not kp.known:
                why = "unknown" if kp is not None else "not there with `command: velocity`"
                self.error(
                    "RES004",
                    f"kd is derived from kp, which is {why}",
                    "kd",
                    "state kp" if kp is not None else "write kd: 0.5 N*m*s/rad",
                )
                return unknown(unit)
            ratio = gain.numbers["ratio"].value
            assert ratio is not None
            derived = Quantity(
                tidy(2.0 * ratio * math.sqrt(kp.require() * inertia[0])),
                unit,
                Origin.DERIVED,
                span=self.span("kd"),
                formula=f"2 x {ratio:g} x sqrt({format_quantity(kp.value, kp.unit)} (kp) x {inertia[1]})",
            )
        found = self.number("kd", Kind.VELOCITY_GAIN, derived=derived, rest=(self.model.kd,))
        if found is None and not (isinstance(gain, SpecValue) and gain.identified):
            self.error(
                "RES005",
                "kd is not stated, and the robot's file has no servo to take it from",
                "kd",
                "write kd: 0.5 N*m*s/rad (or {derive: ...}), 0, or `unknown` to leave the file's actuator alone",
            )
        return unknown(unit) if found is None else found

    def filter_cutoff(self) -> Quantity | None:
        value = self.stated.get("command_filter")
        if value == "none":
            return None
        fitted = self.identified("bandwidth", Kind.FREQUENCY)
        authored = derived = None
        if isinstance(value, CommandFilter):
            path = (*self.stated.path("command_filter"), "cutoff")
            if not value.cutoff.identified:
                authored = written(value.cutoff, "Hz", self.stated.spec.span(*path))
            self.compare("command_filter", value.cutoff, authored, fitted, word="cutoff")
        elif value == "from_motor":
            bandwidth = None if self.motor is None else self.motor.bandwidth
            if bandwidth is None or not bandwidth.known:
                self.error(
                    "RES008",
                    f"the filter is to be that of the motor '{self.stated.get('motor')}', whose bandwidth is unknown",
                    "command_filter",
                    "state the motor's bandwidth, or write command_filter: {cutoff: 30 Hz}",
                )
            else:
                derived = replace(bandwidth, origin=Origin.DERIVED, formula="bandwidth of the motor")
        return choose(authored, fitted, derived, self.model.filter_cutoff)

    def delay(self) -> Delay | None:
        value = self.stated.get("delay")
        fitted = self.identified("delay", Kind.TIME)
        if not isinstance(value, SpecDelay):
            kept = choose(fitted, self.model.delay)
            return None if kept is None else Delay(kept, kept.require(), kept.require(), "episode")
        authored = None
        if not value.nominal.identified:
            authored = written(value.nominal, "s", self.span("delay"))
        self.compare("delay", value.nominal, authored, fitted)
        nominal = choose(authored, fitted, self.model.delay)
        if nominal is None:
            return None
        low = high = nominal.value or 0.0
        if value.range is not None:
            low, high = (end.value or 0.0 for end in value.range)
            if nominal.value is not None and not low <= nominal.value <= high:
                self.error(
                    "RES009",
                    f"the {nominal.origin.value} delay {format_quantity(nominal.value, 's')} is outside its range "
                    f"[{value.range[0].written}, {value.range[1].written}]",
                    "delay",
                    "widen the range, or state the nominal delay",
                )
        return Delay(nominal, low, high, value.sampling)

    def command_range(self) -> tuple[Quantity, Quantity] | None:
        value = self.stated.get("command_range")
        if value is None or value == "none":
            return None
        unit = self.unit(
            {"position": Kind.POSITION, "velocity": Kind.SPEED, "effort": Kind.TORQUE}[self.command.value]
        )
        span = self.span("command_range")
        if value == "joint":
            if self.joint.range is None or self.command is not Command.POSITION:
                self.error(
                    "RES006",
                    "`command_range: joint` needs a joint with a range and `command: position`",
                    "command_range",
                    "write [low, high], or none",
                )
                return None
            low, high = (
                Quantity(end, unit, Origin.MODEL, source=self.joint.span.path, span=self.joint.span)
                for end in self.joint.range
            )
            return low, high
        assert isinstance(value, CommandRange)
        return written(value.low, unit, span), written(value.high, unit, span)

    def randomize(self) -> tuple[Randomization, ...]:
        found = []
        for field, entry in self.stated.group.randomize.items():
            path = ("actuators", self.stated.binding.group, "randomize", field)
            span = self.stated.spec.document.spans.key(path)
            every = None
            if entry.every is not None:
                every = (float(entry.every[0].value), float(entry.every[1].value))
            if entry.from_ is not None:
                fitted = self.from_identified(field)
                if fitted is None:
                    continue
                operation, low, high = "abs", *_spread(fitted, field, entry)
            else:
                operation = next(key for key in ("scale", "add", "abs") if getattr(entry, key) is not None)
                numbers = range_of(entry, field)
                assert isinstance(numbers, tuple)
                for end in numbers:
                    if end.linear is not None and end.linear is not (self.kind is JointKind.SLIDE):
                        self.collector.error(
                            "RES001",
                            f"'{self.joint.name}' is a {self.kind.value} joint, but the range of {field} has "
                            f"{end.written}",
                            where=dotted((*path, operation)),
                            span=self.stated.spec.span(*path, operation),
                            help="a hinge is in rad and N*m, a slide in m and N",
                        )
                low, high = float(numbers[0].value or 0.0), float(numbers[1].value or 0.0)
            found.append(
                Randomization(
                    field, operation, low, high, entry.distribution, entry.when, every, entry.per, span
                )
            )
        return tuple(found)

    def from_identified(self, field: str) -> Quantity | None:
        """The fitted value that a range is taken from; None after an error."""
        kind = RANDOMIZED_FITTED.get(field)
        fitted = self.identified(field, kind) if kind is not None else None
        if fitted is None or fitted.std is None:
            path = ("actuators", self.stated.binding.group, "randomize", field)
            self.reports.error(
                "RES007",
                self.joint.name,
                f"no identified standard deviation of {field} to take the range from",
                dotted(path),
                self.stated.spec.span(*path),
                "state the range as scale, add or abs",
            )
            return None
        return fitted

    def check_static(self, static: Quantity, coulomb: Quantity) -> None:
        """Break-away friction is at least the kinetic one, wherever the two come from."""
        if static.require() < coulomb.require():
            self.error(
                "RES009",
                f"static friction {format_quantity(static.value, static.unit)} ({static.origin.value}) is below "
                f"coulomb friction {format_quantity(coulomb.value, coulomb.unit)} ({coulomb.origin.value})",
                "friction.static",
                "state both",
            )

    def default_position(self, pattern: str | None) -> Quantity:
        unit = self.unit(Kind.POSITION)
        if pattern is None:
            return Quantity(0.0, unit, Origin.DEFAULT, note="no default_pose names the joint")
        value = self.stated.spec.model.robot.default_pose[pattern]
        span = self.stated.spec.span("robot", "default_pose", pattern)
        if value.linear is not None and value.linear is not (self.kind is JointKind.SLIDE):
            self.collector.error(
                "RES001",
                f"'{self.joint.name}' is a {self.kind.value} joint, but its default position is {value.written}",
                where=dotted(("robot", "default_pose", pattern)),
                span=span,
                help="a hinge is in rad, a slide in m",
            )
        return written(value, unit, span)

    def finish(
        self,
        armature: Quantity,
        held: InertiaRange | None,
        free: InertiaRange | None,
        pose_pattern: str | None,
        network_path: Callable[[str], str],
    ) -> JointActuator:
        """The whole actuator, once its armature and inertia are known."""
        effort = self.effort_limit()
        kp = self.kp(effort, armature, held)
        kd = self.kd(kp, armature, held)
        dc = self.level is not Level.IDEAL_PD and self.motor is not None
        velocity = self.number("velocity_limit", Kind.SPEED, rest=(self.model.velocity_limit,))
        friction = {
            part: self.number(f"friction.{part}", kind, rest=(rest,))
            for part, kind, rest in (
                ("coulomb", Kind.TORQUE, self.model.friction_coulomb),
                ("viscous", Kind.VELOCITY_GAIN, self.model.friction_viscous),
                ("static", Kind.TORQUE, None),
                ("stribeck_velocity", Kind.SPEED, None),
            )
        }
        static, coulomb = friction["static"], friction["coulomb"]
        if static is not None and coulomb is not None and None not in (static.value, coulomb.value):
            self.check_static(static, coulomb)
        bias = self.number("encoder_bias", Kind.POSITION)
        scale = self.stated.get("action_scale")
        network = self.stated.group.network
        group_path = ("actuators", self.stated.binding.group)
        motor = self.motor
        return JointActuator(
            joint=self.joint.name,
            kind=self.kind,
            group=self.stated.binding.group,
            pattern=self.stated.binding.pattern,
            motor=self.stated.get("motor"),
            level=self.level,
            command=self.command,
            kp=kp,
            kd=kd,
            effort_limit=effort,
            velocity_limit=velocity or unknown(self.unit(Kind.SPEED)),
            stall_torque=motor.stall_torque if dc and motor is not None else None,
            no_load_speed=motor.no_load_speed if dc and motor is not None else None,
            curve=motor.curve if dc and motor is not None else None,
            peak_torque=motor.peak_torque if motor is not None else unknown(self.unit(Kind.TORQUE)),
            continuous_torque=motor.continuous_torque
            if motor is not None
            else unknown(self.unit(Kind.TORQUE)),
            armature=armature,
            reflected_inertia=motor.reflected_inertia
            if motor is not None
            else unknown(self.unit(Kind.INERTIA)),
            friction_coulomb=friction["coulomb"] or unknown(self.unit(Kind.TORQUE)),
            friction_static=friction["static"],
            friction_viscous=friction["viscous"] or unknown(self.unit(Kind.VELOCITY_GAIN)),
            stribeck_velocity=friction["stribeck_velocity"],
            filter_cutoff=self.filter_cutoff(),
            command_range=self.command_range(),
            delay=self.delay(),
            encoder_bias=bias
            or Quantity(0.0, self.unit(Kind.POSITION), Origin.DEFAULT, note="no bias is stated"),
            action_scale=written(scale, "", self.span("action_scale"))
            if isinstance(scale, SpecValue)
            else None,
            default_position=self.default_position(pose_pattern),
            position_range=self.joint.range,
            network=None
            if network is None
            else Network(
                network_path(network.file),
                None if network.manifest is None else network_path(network.manifest),
                self.stated.spec.span(*group_path, "network"),
            ),
            randomize=self.randomize(),
            inertia_held=held,
            inertia_free=free,
            span=self.stated.spec.span(*group_path),
        )


def _spread(fitted: Quantity, field: str, entry: Randomize) -> tuple[float, float]:
    """The fitted value -+ sigma std; for a gaussian (mean, sigma std)."""
    sigma = 1.0 if entry.sigma is None else entry.sigma.value or 1.0
    mean, half = fitted.require(), sigma * (fitted.std or 0.0)
    if entry.distribution == "gaussian":
        return mean, half
    return (mean - half if field == "encoder_bias" else max(0.0, mean - half)), mean + half


FITTED = (
    "kp",
    "kd",
    "armature",
    "encoder_bias",
    "friction.coulomb",
    "friction.viscous",
    "friction.static",
    "friction.stribeck_velocity",
)
"""Fields that identification results may hold, beside the delay."""

RANDOMIZED_FITTED = {
    "kp": Kind.STIFFNESS,
    "kd": Kind.VELOCITY_GAIN,
    "armature": Kind.INERTIA,
    "friction.coulomb": Kind.TORQUE,
    "friction.viscous": Kind.VELOCITY_GAIN,
    "friction.static": Kind.TORQUE,
    "friction.stribeck_velocity": Kind.SPEED,
    "encoder_bias": Kind.POSITION,
    "delay": Kind.TIME,
}
"""Fields whose range may come from the identification."""
