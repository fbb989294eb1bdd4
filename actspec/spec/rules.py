"""What a spec must fulfil beyond the type of each field: references, sides, levels, commands."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Collector, nearest
from actspec.patterns import PatternError, compile_pattern
from actspec.spec.fields import CommandRange, SpecDelay
from actspec.spec.models import Actuators, Motor, SpecModel, Tunable
from actspec.spec.values import Pair, SpecValue
from actspec.units import Kind, format_quantity

if TYPE_CHECKING:
    from actspec.spec.document import Document

SIDED = ("stall_torque", "no_load_speed", "peak_torque", "continuous_torque", "torque_constant", "curve")
"""Motor figures that differ between rotor and gearbox output."""

TARGETS = ("mujoco", "isaaclab", "mjlab", "deploy", "randomization", "urdf", "newton")
"""Kinds of target that the spec language knows."""

RANDOMIZED_KINDS: Mapping[str, Kind] = {
    "kp": Kind.STIFFNESS,
    "kd": Kind.VELOCITY_GAIN,
    "gains": Kind.RATIO,
    "strength": Kind.RATIO,
    "effort_limit": Kind.TORQUE,
    "armature": Kind.INERTIA,
    "friction.coulomb": Kind.TORQUE,
    "friction.viscous": Kind.VELOCITY_GAIN,
    "friction.static": Kind.TORQUE,
    "encoder_bias": Kind.POSITION,
    "delay": Kind.TIME,
}
"""Quantity kind of `add` and `abs` of each field."""

Path = tuple[str | int, ...]


def check_spec(model: SpecModel, document: Document, collector: Collector) -> None:
    """Add every breach to the collector."""
    checker = _Checker(model, document, collector)
    checker.robot()
    checker.sources()
    for name, motor in model.motors.items():
        checker.motor(name, motor)
    for name, group in model.actuators.items():
        checker.group(name, group)
    checker.targets()


class _Checker:
    def __init__(self, model: SpecModel, document: Document, collector: Collector) -> None:
        self.model = model
        self.document = document
        self.collector = collector

    def error(
        self, code: str, message: str, path: Path, help: str | None = None, *, key: bool = False
    ) -> None:
        spans = self.document.spans
        where = "".join(f"[{p}]" if isinstance(p, int) else f".{p}" for p in path).lstrip(".")
        self.collector.error(
            code, message, where=where, span=spans.key(path) if key else spans.value(path), help=help
        )

    def robot(self) -> None:
        robot = self.model.robot
        if robot.model != "none" and robot.joints:
            self.error("SPEC120", "`joints` are listed only where `model: none`", ("robot", "joints"))
        if robot.model == "none" and not robot.joints:
            self.error(
                "SPEC120",
                "a robot without a model needs its joints",
                ("robot", "model"),
                "write `joints: [name, ...]`, or name a model",
            )
        if not _folder_name(robot.name):
            self.error(
                "SPEC124",
                f"the name {robot.name!r} cannot be a folder's name",
                ("robot", "name"),
                "use letters, digits, '-', '_' and '.'",
            )
        names = [joint if isinstance(joint, str) else joint.name for joint in robot.joints]
        for index, name in enumerate(names):
            if name in names[:index]:
                self.error("SPEC121", f"the joint '{name}' is listed twice", ("robot", "joints", index))
        for index, pattern in enumerate(robot.unmanaged):
            self.pattern(pattern, ("robot", "unmanaged", index))
        for pattern in robot.default_pose:
            self.pattern(pattern, ("robot", "default_pose", pattern), key=True)

    def pattern(self, pattern: str, path: Path, *, key: bool = False) -> None:
        try:
            compile_pattern(pattern)
        except PatternError as err:
            self.error("SPEC122", err.message, path, err.help, key=key)

    def sources(self) -> None:
        known = sorted(self.model.sources)
        for path, key in _source_keys(self.document.data):
            if key not in self.model.sources:
                guess = nearest(key, known)
                self.error(
                    "SPEC123",
                    f"no source is named '{key}'",
                    path,
                    f"did you mean '{guess}'?" if guess else "add it to `sources`",
                )

    def motor(self, name: str, motor: Motor) -> None:
        path: Path = ("motors", name)
        sided = [field for field in SIDED if getattr(motor, field) is not None]
        if sided and motor.side is None:
            self.error(
                "SPEC130",
                f"`side` is missing: is {sided[0]} quoted at the gearbox output or at the rotor?",
                path,
                "write `side: joint` (output) or `side: motor` (rotor, needs gear_ratio)",
            )
        geared = motor.gear_ratio is not None and motor.gear_ratio.value is not None
        if motor.side == "motor" and sided and not geared:
            self.error(
                "SPEC131",
                f"{sided[0]} is quoted at the motor, but `gear_ratio` is missing",
                (*path, sided[0]),
                "state gear_ratio, or quote the figure at the joint with `side: joint`",
            )
        if (
            motor.rotor_inertia is not None
            and motor.rotor_inertia.value is not None
            and motor.gear_ratio is None
        ):
            self.error(
                "SPEC131",
                "rotor_inertia is at the rotor, but `gear_ratio` is missing",
                (*path, "rotor_inertia"),
                "state gear_ratio (1 for a direct drive), or give reflected_inertia at the output",
            )
        if motor.rotor_inertia is not None and motor.reflected_inertia is not None:
            self.error(
                "SPEC132",
                "rotor_inertia and reflected_inertia are both given",
                (*path, "reflected_inertia"),
                "keep the one that was measured; the other follows from gear_ratio",
            )
        if motor.curve is not None and (motor.stall_torque is not None or motor.no_load_speed is not None):
            self.error(
                "SPEC133",
                "an asymmetric `curve` stands in place of stall_torque and no_load_speed",
                (*path, "curve"),
                "remove one of the two",
            )
        if motor.curve is not None:
            knee, free = motor.curve.knee_speed.value, motor.curve.no_load_speed.value
            if knee is not None and free is not None and knee >= free:
                self.error(
                    "SPEC134",
                    f"knee_speed {format_quantity(knee, 'rad/s')} is not below no_load_speed "
                    f"{format_quantity(free, 'rad/s')}",
                    (*path, "curve", "knee_speed"),
                )
        low, high = motor.continuous_torque, motor.peak_torque
        if low and high and low.value is not None and high.value is not None and low.value > high.value:
            self.error(
                "SPEC135",
                f"continuous_torque {low.written} is above peak_torque {high.written}",
                (*path, "continuous_torque"),
                "the thermal limit is the lower one; are the two swapped?",
            )

    def group(self, name: str, group: Actuators) -> None:
        path: Path = ("actuators", name)
        for index, pattern in enumerate(group.joints):
            self.pattern(pattern, (*path, "joints", index))
        self.tunable(path, group, group)
        for pattern, override in group.overrides.items():
            self.pattern(pattern, (*path, "overrides", pattern), key=True)
            self.tunable((*path, "overrides", pattern), override, group)
        if group.level == "actuator_net" and group.network is None:
            self.error(
                "SPEC140",
                "level actuator_net needs `network`",
                path,
                "write network: {file: ..., manifest: ...}",
            )
        if group.level != "actuator_net" and group.network is not None:
            self.error(
                "SPEC140",
                f"`network` is for level actuator_net, this group is {group.level}",
                (*path, "network"),
            )
        if group.level == "dc_motor":
            self.dc_motor(path, group)
        for field, entry in group.randomize.items():
            self.randomize((*path, "randomize", field), field, entry)

    def tunable(self, path: Path, fields: Tunable, group: Actuators) -> None:
        if fields.motor is not None and fields.motor not in self.model.motors:
            guess = nearest(fields.motor, sorted(self.model.motors))
            self.error(
                "SPEC141",
                f"no motor is named '{fields.motor}'",
                (*path, "motor"),
                f"did you mean '{guess}'?" if guess else "add it to `motors`",
            )
        for gain, commands in (("kp", ("velocity", "effort")), ("kd", ("effort",))):
            if getattr(fields, gain) is not None and group.command in commands:
                self.error(
                    "SPEC142",
                    f"`{gain}` has no meaning with `command: {group.command}`",
                    (*path, gain),
                    "remove it"
                    if group.command == "velocity"
                    else "remove it: with `command: effort` the command is the torque, the gains are the caller's",
                )
        motor = self.model.motors.get(fields.motor or group.motor or "")
        if fields.command_filter == "from_motor" and (motor is None or motor.bandwidth is None):
            self.error(
                "SPEC143",
                "`command_filter: from_motor` needs the motor's `bandwidth`",
                (*path, "command_filter"),
                "state the motor's bandwidth, or write command_filter: {cutoff: 30 Hz}",
            )
        if isinstance(fields.effort_limit, str):
            if motor is None:
                self.error(
                    "SPEC144", f"`effort_limit: {fields.effort_limit}` needs a motor", (*path, "effort_limit")
                )
            elif self._motor_torque(motor, fields.effort_limit) is None:
                self.error(
                    "SPEC144",
                    f"the motor has no {fields.effort_limit}_torque",
                    (*path, "effort_limit"),
                    f"state {fields.effort_limit}_torque of the motor, or a torque here",
                )
        friction = fields.friction
        if friction is not None and friction.static is not None and friction.coulomb is not None:
            static, coulomb = friction.static.value, friction.coulomb.value
            if static is not None and coulomb is not None and static < coulomb:
                self.error(
                    "SPEC145",
                    f"static friction {friction.static.written} is below coulomb friction {friction.coulomb.written}",
                    (*path, "friction", "static"),
                    "break-away friction is at least the kinetic one; are the two swapped?",
                )
        limits = fields.command_range
        wanted = {"position": Kind.POSITION, "velocity": Kind.SPEED, "effort": Kind.TORQUE}[group.command]
        if isinstance(limits, CommandRange) and limits.kind not in (None, wanted):
            self.error(
                "SPEC148",
                f"the command is a {wanted.noun} (`command: {group.command}`), its range "
                f"[{limits.low.written}, {limits.high.written}] is not",
                (*path, "command_range"),
                f"a {wanted.noun} is in {wanted.rotary_unit} (hinge) or {wanted.linear_unit} (slide)",
            )
        for field in ("kp", "kd", "armature", "encoder_bias"):
            self.identified((*path, field), getattr(fields, field), group)
        if friction is not None:
            for part in ("coulomb", "viscous", "static", "stribeck_velocity"):
                self.identified((*path, "friction", part), getattr(friction, part), group)
        if isinstance(fields.delay, SpecDelay):
            self.identified((*path, "delay"), fields.delay.nominal, group)

    def identified(self, path: Path, value: Any, group: Actuators) -> None:
        if isinstance(value, SpecValue) and value.identified and group.identified is None:
            self.error(
                "SPEC146",
                "asks for the identified value, but the group names no results",
                path,
                "add `identified: results/FILE.yaml` to the group",
            )

    @staticmethod
    def _motor_torque(motor: Motor, which: str) -> SpecValue | None:
        stated = motor.continuous_torque if which == "continuous" else motor.peak_torque
        if stated is not None and stated.value is not None:
            return stated
        current = motor.nominal_current if which == "continuous" else motor.peak_current
        if motor.torque_constant is not None and current is not None:
            return current
        return None

    def dc_motor(self, path: Path, group: Actuators) -> None:
        for motor_name, at in [(group.motor, path)] + [
            (override.motor, (*path, "overrides", pattern))
            for pattern, override in group.overrides.items()
            if override.motor is not None
        ]:
            if motor_name is None:
                self.error(
                    "SPEC147",
                    "level dc_motor needs a `motor` with its torque-speed line",
                    at,
                    "add a motor with stall_torque and no_load_speed (or curve), or use level ideal_pd",
                )
                continue
            motor = self.model.motors.get(motor_name)
            if motor is None or motor.curve is not None:
                continue
            for needed in ("stall_torque", "no_load_speed"):
                value = getattr(motor, needed)
                if value is None or value.value is None:
                    self.error(
                        "SPEC147",
                        f"level dc_motor needs {needed} of the motor '{motor_name}'",
                        at if value is None else ("motors", motor_name, needed),
                        "state it (or `curve`), or use level ideal_pd",
                    )

    def randomize(self, path: Path, field: str, entry: Any) -> None:
        given = [key for key in ("scale", "add", "abs") if getattr(entry, key) is not None]
        if entry.from_ is not None:
            given.append("from")
        if len(given) != 1:
            self.error(
                "SPEC150",
                "states no range" if not given else f"states {' and '.join(given)} at once",
                path,
                "write exactly one of scale, add, abs: [low, high], or from: identified",
            )
            return
        if entry.from_ is None and entry.sigma is not None:
            self.error("SPEC150", "`sigma` goes with `from: identified`", (*path, "sigma"))
        if (entry.when == "interval") != (entry.every is not None):
            self.error("SPEC151", "`every` goes with `when: interval`, and only with it", path)
        if given[0] == "from":
            return
        if field in ("gains", "strength") and given[0] != "scale":
            self.error("SPEC152", f"`{field}` is a factor: only `scale` fits", (*path, given[0]))
            return
        pair = range_of(entry, field)
        if isinstance(pair, tuple):
            low, high = pair[0].value, pair[1].value
            if low is None or high is None:
                return
            positive = given[0] in ("scale", "abs") and field != "encoder_bias"
            mean_std = entry.distribution == "gaussian"
            if positive and not mean_std and low < 0:
                self.error("SPEC153", f"the range goes below 0: {pair[0].written}", (*path, given[0], 0))
            if entry.distribution == "log_uniform" and low <= 0:
                self.error(
                    "SPEC153",
                    f"log_uniform needs a range above 0, got {pair[0].written}",
                    (*path, given[0], 0),
                )
            if not mean_std and low > high:
                self.error(
                    "SPEC153",
                    f"the range is the wrong way round: {pair[0].written} is above {pair[1].written}",
                    (*path, given[0]),
                )
            if mean_std and high < 0:
                self.error(
                    "SPEC153", f"a standard deviation is >= 0, got {pair[1].written}", (*path, given[0], 1)
                )
        else:
            self.error("SPEC110", pair.message, (*path, given[0], *pair.at), pair.help)

    def targets(self) -> None:
        names = self.model.targets
        for name, target in names.items():
            kind = target.target or name
            if kind not in TARGETS:
                guess = nearest(kind, TARGETS)
                self.error(
                    "SPEC160",
                    f"no target is named '{kind}'",
                    ("targets", name, "target") if target.target else ("targets", name),
                    (f"did you mean '{guess}'? " if guess else "") + f"known targets: {', '.join(TARGETS)}",
                    key=target.target is None,
                )
            if not _folder_name(name):
                self.error(
                    "SPEC161",
                    f"the name '{name}' cannot be a folder's name",
                    ("targets", name),
                    "use letters, digits, '-', '_' and '.'",
                    key=True,
                )
        for entry, reason in self.model.accept.items():
            target_name, dot, _ = entry.partition(".")
            if not dot or target_name not in names:
                self.error(
                    "SPEC162",
                    f"'{entry}' names no target of this spec",
                    ("accept", entry),
                    f"write TARGET.FIELD; targets: {', '.join(names) or 'none'}",
                    key=True,
                )
            if not reason.strip():
                self.error("SPEC162", "an accepted approximation needs its reason", ("accept", entry))


def _folder_name(name: str) -> bool:
    """Whether a name is safe as a folder on every system and as part of an identifier."""
    return name.isascii() and all(c.isalnum() or c in "-_." for c in name) and name[0] not in ".-"


class RangeFault:
    """Why a randomisation's range is none."""

    def __init__(self, message: str, help: str | None, at: Path) -> None:
        self.message, self.help, self.at = message, help, at


def range_of(entry: Any, field: str) -> tuple[SpecValue, SpecValue] | RangeFault:
    """The range of a randomisation in SI units; a gaussian's pair is (mean, std) and need not be ordered."""
    from pydantic_core import PydanticCustomError

    if entry.scale is not None:
        return entry.scale  # type: ignore[no-any-return]
    given = entry.add if entry.add is not None else entry.abs
    kind = RANDOMIZED_KINDS[field]
    try:
        pair = Pair(kind, ordered=False)(given)
    except PydanticCustomError as err:
        context = dict(err.context or {})
        return RangeFault(context["message"], context["help"], tuple(context["at"]))
    assert not isinstance(pair, str)
    return pair


def _source_keys(node: Any, path: Path = ()) -> Iterator[tuple[Path, str]]:
    """Every `source:` that stands beside a `value:`."""
    if isinstance(node, Mapping):
        if "value" in node and isinstance(node.get("source"), str):
            yield (*path, "source"), node["source"]
        for key, value in node.items():
            yield from _source_keys(value, (*path, key))
    elif isinstance(node, list):
        for index, value in enumerate(node):
            yield from _source_keys(value, (*path, index))
