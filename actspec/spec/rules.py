"""What a spec must fulfil beyond the type of each field: references, sides, levels, commands."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from actspec.diagnostics import Collector, nearest
from actspec.patterns import PatternError, compile_pattern
from actspec.spec.fields import CommandRange, SpecDelay
from actspec.spec.models import Actuators, CommandFilter, Motor, SpecModel, Tunable
from actspec.spec.values import Fault, Pair, SpecValue, pair_or_fault
from actspec.units import Kind

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
    "friction.stribeck_velocity": Kind.SPEED,
    "encoder_bias": Kind.POSITION,
    "delay": Kind.TIME,
}
"""Quantity kind of `add` and `abs` of each field."""

Path = tuple[str | int, ...]


def check_spec(
    model: SpecModel, document: Document, collector: Collector, left_out: frozenset[Path] = frozenset()
) -> None:
    """Add every breach to the collector.

    Args:
        model: What the spec says.
        document: Where it says it.
        collector: Takes the breaches.
        left_out: Sections (`("robot",)`) and named parts (`("motors", "m")`) that `model` lacks because of
            other faults; nothing is said about them.
    """
    checker = _Checker(model, document, collector, left_out)
    checker.robot()
    if not any(path[0] == "sources" for path in left_out):
        checker.sources()
    for name, motor in model.motors.items():
        checker.motor(name, motor)
    for name, group in model.actuators.items():
        checker.group(name, group)
    checker.targets()


class _Checker:
    def __init__(
        self, model: SpecModel, document: Document, collector: Collector, left_out: frozenset[Path]
    ) -> None:
        self.model = model
        self.document = document
        self.collector = collector
        self.left_out = left_out

    def error(
        self, code: str, message: str, path: Path, help: str | None = None, *, key: bool = False
    ) -> None:
        if path[:1] in self.left_out or path[:2] in self.left_out:
            return
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
        missing = "missing" if motor.gear_ratio is None else "unknown"
        geared = motor.gear_ratio is not None and motor.gear_ratio.value is not None
        if motor.side == "motor" and not geared:
            for field in sided:
                self.error(
                    "SPEC131",
                    f"{field} is quoted at the motor, but `gear_ratio` is {missing}",
                    (*path, field),
                    "state gear_ratio, or quote the figure at the joint with `side: joint`",
                )
        torques = [field for field in sided if field != "no_load_speed"]
        if motor.side == "motor" and torques and motor.efficiency and motor.efficiency.value is None:
            self.error(
                "SPEC131",
                f"{torques[0]} is quoted at the motor, but `efficiency` is unknown",
                (*path, "efficiency"),
                "state it, or remove it to take 1; or quote the torques at the joint with `side: joint`",
            )
        if motor.rotor_inertia is not None and motor.rotor_inertia.value is not None and not geared:
            self.error(
                "SPEC131",
                f"rotor_inertia is at the rotor, but `gear_ratio` is {missing}",
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
            knee, free = motor.curve.knee_speed, motor.curve.no_load_speed
            if knee.value is not None and free.value is not None and knee.value >= free.value:
                self.error(
                    "SPEC134",
                    f"knee_speed {knee.written} is not below no_load_speed {free.written}",
                    (*path, "curve", "knee_speed"),
                    "the full torque ends at the knee, all torque at no_load_speed",
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
            if entry.from_ is not None and group.identified is None:
                self.error(
                    "SPEC146",
                    "asks for the identified range, but the group names no results",
                    (*path, "randomize", field),
                    "add `identified: results/FILE.yaml` to the group",
                )

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
        bandwidth = None if motor is None or motor.bandwidth is None else motor.bandwidth.value
        if fields.command_filter == "from_motor" and bandwidth is None:
            self.error(
                "SPEC143",
                "`command_filter: from_motor` needs the motor's `bandwidth`",
                (*path, "command_filter"),
                "state the motor's bandwidth, or write command_filter: {cutoff: 30 Hz}",
            )
        if isinstance(fields.effort_limit, str):
            if motor is None:
                self.error(
                    "SPEC144",
                    f"`effort_limit: {fields.effort_limit}` needs a motor",
                    (*path, "effort_limit"),
                    "add `motor: NAME`, or write a torque here",
                )
            elif not _states_torque(motor, fields.effort_limit):
                self.error(
                    "SPEC144",
                    f"{fields.effort_limit}_torque of the motor is not known",
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
        if isinstance(fields.command_filter, CommandFilter):
            self.identified((*path, "command_filter", "cutoff"), fields.command_filter.cutoff, group)

    def identified(self, path: Path, value: Any, group: Actuators) -> None:
        if isinstance(value, SpecValue) and value.identified and group.identified is None:
            self.error(
                "SPEC146",
                "asks for the identified value, but the group names no results",
                path,
                "add `identified: results/FILE.yaml` to the group",
            )

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
            if motor is None:
                continue
            holder: Any = motor
            place: Path = ("motors", motor_name)
            fields: tuple[str, ...] = ("stall_torque", "no_load_speed")
            if motor.curve is not None:
                holder, place = motor.curve, (*place, "curve")
                fields = ("drive_torque", "brake_torque", "knee_speed", "no_load_speed")
            for needed in fields:
                value = getattr(holder, needed)
                if value is None or value.value is None:
                    self.error(
                        "SPEC147",
                        f"level dc_motor needs {needed} of the motor '{motor_name}', which is "
                        f"{'not stated' if value is None else 'unknown'}",
                        at if value is None else (*place, needed),
                        "state it (or `curve`), or use level ideal_pd"
                        if motor.curve is None
                        else "state it, or use level ideal_pd",
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
            self.error("SPEC150", "`sigma` goes with `from: identified`", (*path, "sigma"), "remove it")
        if (entry.when == "interval") != (entry.every is not None):
            self.error(
                "SPEC151",
                "`when: interval` needs `every`" if entry.every is None else "`every` needs `when: interval`",
                path,
                "write `when: interval, every: [5 s, 10 s]`, or neither",
            )
        if field in ("gains", "strength", "effort_limit") and given[0] == "from":
            help = "write `scale: [0.9, 1.1]`"
            self.error("SPEC152", f"no identification gives a range of {field}", (*path, "from"), help)
            return
        if given[0] == "from":
            return
        if field in ("gains", "strength") and given[0] != "scale":
            help = f"write `{field}: {{scale: [0.9, 1.1]}}`"
            self.error("SPEC152", f"`{field}` is a factor: only `scale` fits", (*path, given[0]), help)
            return
        pair = range_of(entry, field)
        if isinstance(pair, tuple):
            low, high = pair[0].value, pair[1].value
            if low is None or high is None:
                return
            positive = given[0] in ("scale", "abs") and field != "encoder_bias"
            mean_std = entry.distribution == "gaussian"
            if positive and low < 0:
                what = "mean is" if mean_std else "range goes"
                self.error("SPEC153", f"the {what} below 0: {pair[0].written}", (*path, given[0], 0))
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
                    f"write [{pair[1].written}, {pair[0].written}]",
                )
            if mean_std and high < 0:
                self.error(
                    "SPEC153", f"a standard deviation is >= 0, got {pair[1].written}", (*path, given[0], 1)
                )
        else:
            self.error("SPEC110", pair.message, (*path, given[0], *pair.at), pair.help)

    def targets(self) -> None:
        # Without targets the spec compiles to MuJoCo.
        names = tuple(self.model.targets) or ("mujoco",)
        for name, target in self.model.targets.items():
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
                    f"write TARGET.FIELD; targets: {', '.join(names)}",
                    key=True,
                )
            if not reason.strip():
                self.error(
                    "SPEC162",
                    "an accepted approximation needs its reason",
                    ("accept", entry),
                    "say in a sentence why the loss does not matter here",
                )


def _folder_name(name: str) -> bool:
    """Whether a name is safe as a folder on every system and as part of an identifier."""
    return (
        name != "" and name.isascii() and all(c.isalnum() or c in "-_." for c in name) and name[0] not in ".-"
    )


def _states_torque(motor: Motor, which: str) -> bool:
    """Whether `continuous` or `peak` torque is known; an authored `unknown` says that it is not."""
    stated = motor.continuous_torque if which == "continuous" else motor.peak_torque
    if stated is not None:
        return stated.value is not None
    current = motor.nominal_current if which == "continuous" else motor.peak_current
    return all(part is not None and part.value is not None for part in (motor.torque_constant, current))


def range_of(entry: Any, field: str) -> tuple[SpecValue, SpecValue] | Fault:
    """The range of a randomisation in SI units; a gaussian's pair is (mean, std) and need not be ordered."""
    if entry.scale is not None:
        return entry.scale  # type: ignore[no-any-return]
    given = entry.add if entry.add is not None else entry.abs
    return pair_or_fault(given, Pair(RANDOMIZED_KINDS[field], ordered=False))


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
