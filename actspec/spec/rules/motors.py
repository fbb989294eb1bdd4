"""Rules of `motors`: figures, gearboxes, transmissions and linkages."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress

from actspec.diagnostics import Path, listed, many
from actspec.patterns import PatternError, match_names
from actspec.spec.document import Breaches
from actspec.spec.gears import KINDS_OF_STAGE, Linkage, Stage
from actspec.spec.models import Actuators, Motor, SpecModel
from actspec.spec.values import SpecValue
from actspec.units import format_number, format_quantity

SIDED = ("stall_torque", "no_load_speed", "peak_torque", "continuous_torque", "torque_constant", "curve")
"""Motor figures that differ between rotor and gearbox output."""


def sided_figures(motor: Motor) -> list[str]:
    """Figures that a motor states of one side of its gear."""
    return [field for field in SIDED if getattr(motor, field) is not None]


def check_motor(name: str, motor: Motor, breaches: Breaches) -> None:
    """Side, gear, inertia and curve of a motor fit together."""
    path: Path = ("motors", name)
    sided = sided_figures(motor)
    if sided and motor.side is None:
        breaches.error(
            "SPEC130",
            f"`side` is missing: is {sided[0]} quoted at the gearbox output or at the rotor?",
            path,
            "write `side: joint` (output) or `side: motor` (rotor, needs gear_ratio)",
        )
    check_gearbox(path, motor, breaches)
    missing = "missing" if motor.gear_ratio is None else "unknown"
    geared = motor.gearbox is not None or (
        motor.gear_ratio is not None and motor.gear_ratio.value is not None
    )
    turning = motor.rotor_inertia is not None and motor.rotor_inertia.value is not None
    at_motor = sided if motor.side == "motor" else []
    if at_motor and not geared:
        named = [*at_motor, *["rotor_inertia"] * turning]
        are = "are" if len(named) > 1 else "is"
        breaches.error(
            "SPEC131",
            f"{listed(named, 8)} {are} quoted at the motor, but `gear_ratio` is {missing}",
            (*path, "side" if motor.gear_ratio is None else "gear_ratio"),
            "state gear_ratio or gearbox, or quote the figures at the joint with `side: joint`",
        )
    torques = [field for field in sided if field != "no_load_speed"]
    for at, efficiency in _efficiencies(path, motor):
        if motor.side == "motor" and torques and efficiency is not None and efficiency.value is None:
            breaches.error(
                "SPEC131",
                f"{torques[0]} is quoted at the motor, but `efficiency` is unknown",
                at,
                "state it, or remove it to take 1; or quote the torques at the joint with `side: joint`",
            )
    if turning and not at_motor and not geared:
        breaches.error(
            "SPEC131",
            f"rotor_inertia is at the rotor, but `gear_ratio` is {missing}",
            (*path, "rotor_inertia"),
            "state gear_ratio (1 for a direct drive), or give reflected_inertia at the output",
        )
    if motor.rotor_inertia is not None and motor.reflected_inertia is not None:
        breaches.error(
            "SPEC132",
            "rotor_inertia and reflected_inertia are both given",
            (*path, "reflected_inertia"),
            "keep the one that was measured; the other follows from gear_ratio",
        )
    if motor.curve is not None and (motor.stall_torque is not None or motor.no_load_speed is not None):
        breaches.error(
            "SPEC133",
            "an asymmetric `curve` stands in place of stall_torque and no_load_speed",
            (*path, "curve"),
            "remove one of the two",
        )
    if motor.curve is not None:
        knee, free = motor.curve.knee_speed, motor.curve.no_load_speed
        if knee.value is not None and free.value is not None and knee.value >= free.value:
            there, help = _is_it_rpm(knee, free)
            breaches.error(
                "SPEC134",
                f"knee_speed {knee.written} is not below no_load_speed {free.written}{there}",
                (*path, "curve", "knee_speed"),
                help or "the full torque ends at the knee, all torque at no_load_speed",
            )


def _is_it_rpm(knee: SpecValue, free: SpecValue) -> tuple[str, str | None]:
    """A speed in rpm beside a knee that is in rad/s: what it is there, and whether the knee is in rpm, too."""
    if knee.value is None or knee.linear or "rpm" in knee.written or "rpm" not in free.written:
        return "", None
    size = knee.value * math.pi / 30.0
    there = f", {format_quantity(free.value, 'rad/s', 3)}"
    if size >= (free.value or 0.0):
        return there, None
    return there, f"is it in rpm? {knee.value:g} rpm is {format_quantity(size, 'rad/s', 3)}"


def _efficiencies(path: Path, motor: Motor) -> Iterator[tuple[Path, SpecValue | None]]:
    """Where an efficiency of the gearbox may be stated, and what is."""
    yield (*path, "efficiency"), motor.efficiency
    for index, stage in enumerate(motor.gearbox or ()):
        yield (*path, "gearbox", index, "efficiency"), stage.efficiency


SAME_RATIO = 0.005
"""A stated gear ratio and that of the stages may differ by this much, relative.

Chosen: a ratio rounded to three digits is at most this far off.
"""


def stage_ratio(stage: Stage) -> float | None:
    """Turns at the input of a stage in one turn at its output; None for one that changes turns and travel."""
    if stage.ratio is not None:
        return number(stage.ratio)
    if stage.planetary is not None:
        return 1.0 + number(stage.planetary.ring) / number(stage.planetary.sun)
    if stage.teeth is not None:
        return number(stage.teeth.driven) / number(stage.teeth.driving)
    return None


def stage_speed(stage: Stage, travels: bool) -> float:
    """Speed at the input of a stage per speed at its output [-, rad/m or m/rad].

    Args:
        stage: The stage; it says what it is.
        travels: Its output travels; False: it turns.
    """
    plain = stage_ratio(stage)
    if plain is not None:
        return plain
    length = stage.lead or stage.radius or stage.lever_arm
    assert length is not None
    if stage.lever_arm is not None or (stage.radius is not None and not travels):
        return number(length)
    return 1.0 / number(length)


def number(value: SpecValue) -> float:
    """The number of a field that takes no `unknown`."""
    assert value.value is not None
    return value.value


def check_stages(path: Path, stages: Iterable[Stage], breaches: Breaches) -> None:
    """Every stage is one thing."""
    for index, stage in enumerate(stages):
        at = (*path, index)
        given = [kind for kind in KINDS_OF_STAGE if getattr(stage, kind) is not None]
        if len(given) != 1:
            breaches.error(
                "SPEC136",
                f"a stage is {' and '.join(given)} at once" if given else "the stage does not say what it is",
                at,
                f"write exactly one of {', '.join(KINDS_OF_STAGE)}",
            )
        gears = stage.planetary
        if gears is not None and number(gears.ring) <= number(gears.sun):
            breaches.error(
                "SPEC136",
                f"the ring has {gears.ring.written} teeth, the sun {gears.sun.written}: the ring is round the sun",
                (*at, "planetary", "ring"),
                "are the two swapped?",
            )


def check_gearbox(path: Path, motor: Motor, breaches: Breaches) -> None:
    """A gearbox by stages agrees with what the motor says of it as a whole."""
    if motor.gearbox is None:
        return
    check_stages((*path, "gearbox"), motor.gearbox, breaches)
    if motor.efficiency is not None and any(stage.efficiency is not None for stage in motor.gearbox):
        breaches.error(
            "SPEC137",
            "the efficiency is stated for the gearbox and for its stages",
            (*path, "efficiency"),
            "state it once: that of the gearbox is the product of its stages'",
        )
    _check_ratio(path, motor, motor.gearbox, breaches)
    for index, stage in enumerate(motor.gearbox):
        if stage.inertia is not None and motor.rotor_inertia is None:
            whole = motor.reflected_inertia is not None
            breaches.error(
                "SPEC138",
                "reflected_inertia holds the whole gearbox, and a stage states an inertia"
                if whole
                else "the stage states its inertia, and the motor no rotor_inertia",
                (*path, "gearbox", index, "inertia"),
                "keep one of the two" if whole else "state rotor_inertia: the sum needs both",
            )


def _check_ratio(path: Path, motor: Motor, stages: Sequence[Stage], breaches: Breaches) -> None:
    """gear_ratio is the product of the stages."""
    stated = motor.gear_ratio
    if stated is None or stated.value is None:
        return
    ratios = [stage_ratio(stage) for stage in stages]
    if None in ratios:
        breaches.error(
            "SPEC137",
            "gear_ratio counts turns per turn, and a stage of the gearbox changes turns and travel",
            (*path, "gear_ratio"),
            "remove gear_ratio: the gearbox says it all",
        )
        return
    product = math.prod(ratio for ratio in ratios if ratio is not None)
    if abs(stated.value - product) > SAME_RATIO * product:
        made, several = f"the stage of the gearbox makes {format_number(product)}", len(ratios) > 1
        if several:
            factors = " x ".join(format_quantity(ratio, "") for ratio in ratios)
            made = f"the stages of the gearbox make {factors} = {format_number(product)}"
        breaches.error(
            "SPEC137",
            f"gear_ratio is {stated.written}, {made}",
            (*path, "gear_ratio"),
            "remove gear_ratio: it follows from the stages; or correct the stage that is wrong"
            if several
            else "remove gear_ratio: it follows from the stage; or correct that",
        )


def check_linkages(linkages: Mapping[str, Linkage], breaches: Breaches) -> None:
    """Every linkage has one square Jacobian a pose, and no joint is in two."""
    owner: dict[str, str] = {}
    for name, linkage in linkages.items():
        path: Path = ("linkages", name)
        for index, joint in enumerate(linkage.joints):
            if joint in owner:
                twice = (
                    "twice in the linkage" if owner[joint] == name else f"in the linkage '{owner[joint]}' too"
                )
                breaches.error("SPEC170", f"the joint '{joint}' is {twice}", (*path, "joints", index))
            owner.setdefault(joint, name)
        _check_geometry(path, linkage, breaches)


def _check_geometry(path: Path, linkage: Linkage, breaches: Breaches) -> None:
    """One of Jacobian, table and factor, each of the size that joints and motors have."""
    given = [key for key in ("jacobian", "table", "factor") if getattr(linkage, key) is not None]
    if len(given) != 1:
        breaches.error(
            "SPEC172",
            f"states {' and '.join(given)} at once"
            if given
            else "does not say how motors and joints move together",
            path,
            "write one of jacobian (motor speed per joint speed at a pose), table (at several poses), or "
            "`factor: 1` where nobody has computed it",
        )
    for key, needs in (("at", "jacobian"), ("limits", "jacobian or table")):
        stated = linkage.at is not None if key == "at" else linkage.limits != "alone"
        if stated and not any(part in needs for part in given):
            breaches.error("SPEC172", f"`{key}` goes with {needs}", (*path, key), "remove it")
    size = len(linkage.joints)
    if linkage.factor is None and len(linkage.motors) != size:
        breaches.error(
            "SPEC171",
            f"{many(size, 'joint')} and {many(len(linkage.motors), 'motor')}: a Jacobian needs as many of both",
            (*path, "motors"),
            "name the motor of each rod, the same one several times if need be",
        )
    poses = [((*path, "jacobian"), linkage.jacobian), ((*path, "at"), linkage.at)]
    for index, pose in enumerate(linkage.table or ()):
        poses += [
            ((*path, "table", index, "jacobian"), pose.jacobian),
            ((*path, "table", index, "at"), pose.at),
        ]
    for place, part in poses:
        if part is None or isinstance(part, str):
            continue
        if place[-1] == "at" and len(part) != size:
            breaches.error(
                "SPEC171",
                f"{many(len(part), 'position')} for {many(size, 'joint')}",
                place,
                "write one a joint, in their order",
            )
        if place[-1] == "jacobian" and [len(row) for row in part if isinstance(row, tuple)] != [size] * size:
            breaches.error(
                "SPEC171",
                f"the Jacobian of {many(size, 'joint')} is {size} by {size}",
                place,
                "write a row a motor, in it a column a joint",
            )


def may_be_linked(group: Actuators, model: SpecModel) -> bool:
    """Whether a linkage names the motor of a joint of the group, or of one in no group, which may be meant."""
    names = [joint for linkage in model.linkages.values() for joint in linkage.joints]
    if _matched(group, names):
        return True
    return not {*names} <= {name for other in model.actuators.values() for name in _matched(other, names)}


def _matched(group: Actuators, names: Sequence[str]) -> tuple[str, ...]:
    """Names that a group's patterns match; a pattern that is wrong has an error of its own."""
    found: list[str] = []
    for pattern in group.joints:
        with suppress(PatternError):
            found += match_names(pattern, names)
    return tuple(found)
