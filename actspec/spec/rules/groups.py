"""Rules of `actuators`: a group as a whole, the fields that an override may state anew, `randomize`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from actspec.diagnostics import Path
from actspec.fields import COMMANDED, FIELDS, FRICTION
from actspec.spec.document import Breaches
from actspec.spec.fields import CommandRange, SpecDelay
from actspec.spec.models import Actuators, CommandFilter, Friction, Motor, Randomize, SpecModel, Tunable
from actspec.spec.rules.motors import check_stages, may_be_linked
from actspec.spec.rules.robot import check_pattern
from actspec.spec.values import Fault, Pair, SpecValue, pair_or_fault
from actspec.units import Kind


def check_group(name: str, group: Actuators, model: SpecModel, breaches: Breaches) -> None:
    """A group, its overrides and its randomisation."""
    path: Path = ("actuators", name)
    motors = model.motors
    # Whether every joint of the group is in a linkage is seen when its joints are known.
    linked = may_be_linked(group, model)
    for index, pattern in enumerate(group.joints):
        check_pattern(pattern, (*path, "joints", index), breaches)
    check_joint_fields(path, group, group, motors, breaches, linked=linked)
    for pattern, override in group.overrides.items():
        check_pattern(pattern, (*path, "overrides", pattern), breaches, key=True)
        check_joint_fields((*path, "overrides", pattern), override, group, motors, breaches, linked=linked)
    if group.level == "actuator_net" and group.network is None:
        breaches.error(
            "SPEC140",
            "level actuator_net needs `network`",
            path,
            "write network: {manifest: ...}",
        )
    if group.network is not None and group.network.file is None and group.network.manifest is None:
        breaches.error(
            "SPEC140", "`network` names no file", (*path, "network"), "write network: {manifest: ...}"
        )
    if group.level != "actuator_net" and group.network is not None:
        breaches.error(
            "SPEC140",
            f"`network` is for level actuator_net, this group is {group.level}",
            (*path, "network"),
        )
    if group.level == "dc_motor":
        _check_dc_motors(path, group, motors, breaches, linked=linked)
    for field, entry in group.randomize.items():
        at = (*path, "randomize", field)
        check_randomize(at, field, entry, breaches)
        if entry.from_ is not None and group.identified is None:
            breaches.error(
                "SPEC146", "asks for the identified range, but the group names no results", at, IDENTIFY
            )


def _check_dc_motors(
    path: Path, group: Actuators, motors: Mapping[str, Motor], breaches: Breaches, *, linked: bool
) -> None:
    """Level dc_motor needs the torque-speed line of every motor in the group."""
    used = [(group.motor, path)]
    for pattern, override in group.overrides.items():
        if override.motor is not None:
            used.append((override.motor, (*path, "overrides", pattern)))
    for name, at in used:
        if name is None and linked:
            continue
        if name is None:
            breaches.error(
                "SPEC147",
                "level dc_motor needs a `motor` with its torque-speed line",
                at,
                "add a motor with stall_torque and no_load_speed (or curve), or use level ideal_pd",
            )
            continue
        motor = motors.get(name)
        if motor is None:
            continue
        for field, value, place in _line_of(name, motor):
            if value is not None and value.value is not None:
                continue
            breaches.error(
                "SPEC147",
                f"level dc_motor needs {field} of the motor '{name}', which is "
                f"{'not stated' if value is None else 'unknown'}",
                at if value is None else place,
                _way_out(field, motor),
            )


NO_STALL = "docs/spec-language.md, A datasheet without a stall torque"
"""Where the ways out are."""


def _way_out(field: str, motor: Motor) -> str:
    """What to write where a motor lacks a figure of its line."""
    if motor.curve is not None:
        return "state it, or use level ideal_pd"
    peak = motor.peak_torque
    if field == "stall_torque" and peak is not None and peak.value is not None:
        return (
            f"a datasheet without one: `stall_torque: {peak.written}`, its peak torque, gives no more than the motor "
            f"has; nearer ones: {NO_STALL}. Or `curve`, or level ideal_pd"
        )
    return "state it (or `curve`), or use level ideal_pd"


def _line_of(name: str, motor: Motor) -> Iterator[tuple[str, SpecValue | None, Path]]:
    """Figures of a motor's torque-speed line: name, what is stated, where."""
    path: Path = ("motors", name)
    if motor.curve is None:
        for field in ("stall_torque", "no_load_speed"):
            yield field, getattr(motor, field), (*path, field)
    else:
        for field in ("drive_torque", "brake_torque", "knee_speed", "no_load_speed"):
            yield field, getattr(motor.curve, field), (*path, "curve", field)


IDENTIFY = "add `identified: results/FILE.yaml` to the group"
"""What to write where an identified number is asked for."""


def check_joint_fields(
    path: Path,
    fields: Tunable,
    group: Actuators,
    motors: Mapping[str, Motor],
    breaches: Breaches,
    *,
    linked: bool,
) -> None:
    """The fields fit the group's command, its motor and each other.

    Args:
        path: Where they are written.
        fields: The group's own, or an override's.
        group: The group.
        motors: The spec's motors.
        breaches: Takes what is wrong.
        linked: Whether a linkage names motors of some of the group's joints.
    """
    _check_command(path, fields, group.command, breaches)
    _check_gears(path, fields, group, breaches)
    name = fields.motor or group.motor
    motor = motors.get(name or "")
    # That level dc_motor lacks its motor is told of the group.
    lacking = name is None and group.level == "dc_motor"
    if motor is not None or not (linked or lacking):
        _check_from_motor(path, fields, motor, breaches)
    if fields.friction is not None:
        _check_friction((*path, "friction"), fields.friction, breaches)
    if group.identified is None:
        _check_unidentified(path, fields, breaches)


def _check_command(path: Path, fields: Tunable, command: str, breaches: Breaches) -> None:
    """Gains and range mean something with the command."""
    for gain, commands in (("kp", ("velocity", "effort")), ("kd", ("effort",))):
        if getattr(fields, gain) is not None and command in commands:
            breaches.error(
                "SPEC142",
                f"`{gain}` has no meaning with `command: {command}`",
                (*path, gain),
                "remove it"
                if command == "velocity"
                else "remove it: with `command: effort` the command is the torque, the gains are the caller's",
            )
    limits, wanted = fields.command_range, COMMANDED[command]
    if isinstance(limits, CommandRange) and limits.kind is not wanted:
        breaches.error(
            "SPEC148",
            f"the command is a {wanted.noun} (`command: {command}`), its range "
            f"[{limits.low.written}, {limits.high.written}] is not",
            (*path, "command_range"),
            f"a {wanted.noun} is in {wanted.rotary_unit} (hinge) or {wanted.linear_unit} (slide)",
        )


def _check_gears(path: Path, fields: Tunable, group: Actuators, breaches: Breaches) -> None:
    """The way from motor to joint is stated once."""
    if fields.transmission is not None:
        check_stages((*path, "transmission"), fields.transmission, breaches)
        for index, stage in enumerate(fields.transmission):
            if stage.efficiency is not None and stage.efficiency.value is None:
                breaches.error(
                    "SPEC131",
                    "the torque passes this stage, but its `efficiency` is unknown",
                    (*path, "transmission", index, "efficiency"),
                    "state it, or remove it to take 1",
                )
    for key, other in (("transmission", "reduction"), ("reduction", "transmission")):
        stated = getattr(fields, other) is not None or getattr(group, other) is not None
        if getattr(fields, key) is not None and stated:
            breaches.error(
                "SPEC137",
                f"`{key}` and `{other}` both say what is between the motor's output and the joint",
                (*path, key),
                "write the reduction as a stage of the transmission: `{ratio: 2}`",
            )
            return


def _check_from_motor(path: Path, fields: Tunable, motor: Motor | None, breaches: Breaches) -> None:
    """What is to be the motor's is known of the motor."""
    bandwidth = None if motor is None or motor.bandwidth is None else motor.bandwidth.value
    if fields.command_filter == "from_motor" and bandwidth is None:
        breaches.error(
            "SPEC143",
            "`command_filter: from_motor` needs the motor's `bandwidth`",
            (*path, "command_filter"),
            "state the motor's bandwidth, or write command_filter: {cutoff: 30 Hz}",
        )
    if not isinstance(fields.effort_limit, str):
        return
    if motor is None and fields.motor is not None:
        # That there is no such motor is an error of its own.
        return
    if motor is None:
        breaches.error(
            "SPEC144",
            f"`effort_limit: {fields.effort_limit}` needs a motor",
            (*path, "effort_limit"),
            "add `motor: NAME`, or write a torque here",
        )
    elif not _states_torque(motor, fields.effort_limit):
        breaches.error(
            "SPEC144",
            f"{fields.effort_limit}_torque of the motor is not known",
            (*path, "effort_limit"),
            _other_torque(motor, fields.effort_limit),
        )


def _other_torque(motor: Motor, which: str) -> str:
    """What to write where a motor lacks the torque that is to be the limit."""
    stall = motor.stall_torque if motor.curve is None else motor.curve.drive_torque
    if which == "peak" and stall is not None and stall.value is not None:
        name = "stall_torque" if motor.curve is None else "curve's drive_torque"
        return (
            f"state peak_torque of the motor: its {name}, {stall.written}, where the drive has the current for "
            "that, else torque_constant and peak_current; or a torque here"
        )
    return f"state {which}_torque of the motor, or a torque here"


def _states_torque(motor: Motor, which: str) -> bool:
    """Whether `continuous` or `peak` torque is known; an authored `unknown` says that it is not."""
    stated = motor.continuous_torque if which == "continuous" else motor.peak_torque
    if stated is not None:
        return stated.value is not None
    current = motor.nominal_current if which == "continuous" else motor.peak_current
    return all(part is not None and part.value is not None for part in (motor.torque_constant, current))


def _check_friction(path: Path, friction: Friction, breaches: Breaches) -> None:
    if friction.static is None or friction.coulomb is None:
        return
    static, coulomb = friction.static.value, friction.coulomb.value
    if static is not None and coulomb is not None and static < coulomb:
        breaches.error(
            "SPEC145",
            f"static friction {friction.static.written} is below coulomb friction {friction.coulomb.written}",
            (*path, "static"),
            "break-away friction is at least the kinetic one; are the two swapped?",
        )


def _check_unidentified(path: Path, fields: Tunable, breaches: Breaches) -> None:
    """Without results no field is `identified`."""
    values: dict[Path, Any] = {
        (field,): getattr(fields, field) for field in ("kp", "kd", "armature", "encoder_bias")
    }
    if fields.friction is not None:
        for part in FRICTION:
            key = part.spec.partition(".")[2]
            values["friction", key] = getattr(fields.friction, key)
    if isinstance(fields.delay, SpecDelay):
        values["delay",] = fields.delay.nominal
    if isinstance(fields.command_filter, CommandFilter):
        values["command_filter", "cutoff"] = fields.command_filter.cutoff
    for at, value in values.items():
        if isinstance(value, SpecValue) and value.identified:
            breaches.error(
                "SPEC146",
                "asks for the identified value, but the group names no results",
                (*path, *at),
                IDENTIFY,
            )


RANDOMIZED_KINDS: Mapping[str, Kind] = {
    **{field.spec: field.kind for field in FIELDS.values() if field.drawn and field.kind is not None},
    **dict.fromkeys(("gains", "strength"), Kind.RATIO),
}
"""Quantity kind of `add` and `abs` of each field."""
UNFITTED = ("gains", "strength", "effort_limit")
"""Fields of which no identification gives a range."""


def check_randomize(path: Path, field: str, entry: Randomize, breaches: Breaches) -> None:
    """One range, with what belongs to it, of numbers that the field can have."""
    given = [key for key in ("scale", "add", "abs") if getattr(entry, key) is not None]
    if entry.from_ is not None:
        given.append("from")
    if len(given) != 1:
        breaches.error(
            "SPEC150",
            "states no range" if not given else f"states {' and '.join(given)} at once",
            path,
            "write exactly one of scale, add, abs: [low, high], or from: identified",
        )
        return
    operation = given[0]
    if operation != "from" and entry.sigma is not None:
        breaches.error("SPEC150", "`sigma` goes with `from: identified`", (*path, "sigma"), "remove it")
    if (entry.when == "interval") != (entry.every is not None):
        breaches.error(
            "SPEC151",
            "`when: interval` needs `every`" if entry.every is None else "`every` needs `when: interval`",
            path,
            "write `when: interval, every: [5 s, 10 s]`, or neither",
        )
    if operation == "from":
        if field in UNFITTED:
            help = "write `scale: [0.9, 1.1]`"
            breaches.error("SPEC152", f"no identification gives a range of {field}", (*path, "from"), help)
        return
    if field in ("gains", "strength") and operation != "scale":
        help = f"write `{field}: {{scale: [0.9, 1.1]}}`"
        breaches.error("SPEC152", f"`{field}` is a factor: only `scale` fits", (*path, operation), help)
        return
    pair = range_of(entry, field)
    if isinstance(pair, Fault):
        breaches.error("SPEC110", pair.message, (*path, operation, *pair.at), pair.help)
        return
    _check_ends(pair, (*path, operation), field, entry.distribution, breaches)


def _check_ends(
    pair: tuple[SpecValue, SpecValue], path: Path, field: str, distribution: str, breaches: Breaches
) -> None:
    """The ends' signs and order; for a gaussian they are mean and standard deviation."""
    low, high = pair[0].value, pair[1].value
    if low is None or high is None:
        return
    positive = path[-1] in ("scale", "abs") and field != "encoder_bias"
    mean_std = distribution == "gaussian"
    if positive and low < 0:
        what = "mean is" if mean_std else "range goes"
        around = path[-1] == "scale" and not mean_std and low == -high > -1
        help = (
            f"a factor is one of the nominal value: did you mean [{1 + low:g}, {1 + high:g}]?"
            if around
            else None
        )
        breaches.error("SPEC153", f"the {what} below 0: {pair[0].written}", (*path, 0), help)
    if distribution == "log_uniform" and low <= 0:
        breaches.error("SPEC153", f"log_uniform needs a range above 0, got {pair[0].written}", (*path, 0))
    if not mean_std and low > high:
        breaches.error(
            "SPEC153",
            f"the range is the wrong way round: {pair[0].written} is above {pair[1].written}",
            path,
            f"write [{pair[1].written}, {pair[0].written}]",
        )
    if mean_std and high < 0:
        breaches.error("SPEC153", f"a standard deviation is >= 0, got {pair[1].written}", (*path, 1))


def range_of(entry: Randomize, field: str) -> tuple[SpecValue, SpecValue] | Fault:
    """The range of a randomisation in SI units; a gaussian's pair is (mean, std) and need not be ordered."""
    if entry.scale is not None:
        return entry.scale  # type: ignore[no-any-return]
    given = entry.add if entry.add is not None else entry.abs
    return pair_or_fault(given, Pair(RANDOMIZED_KINDS[field], ordered=False))
