"""Checks of groups that need no robot: dry friction, effort limits, kp beside kd, ranges."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator
from dataclasses import replace
from typing import Any, NamedTuple

from actspec.diagnostics import Path, Span
from actspec.fields import FRICTION_SHARE
from actspec.joints import JointKind
from actspec.spec.document import SourceMap
from actspec.spec.fields import DerivedGain
from actspec.spec.models import Actuators, Friction, Motor, SpecModel, Tunable
from actspec.spec.plausible.draws import draw_doubts, is_drawn, is_off, off
from actspec.spec.plausible.drive import Drive, Limit, Rub, Train, cut_gearbox, is_one, number, output_of
from actspec.spec.plausible.driven import NEVER_GEARED_UP
from actspec.spec.plausible.gains import STIFF_RETURN, Gains, derived_doubts, gain_words
from actspec.spec.plausible.table import Doubt, Kept, at
from actspec.spec.rules.motors import stage_ratio
from actspec.spec.values import SpecValue
from actspec.units import format_quantity

BREAK_AWAY = 5.0
"""Break-away friction over kinetic friction: below it only what the drive cannot overcome is told. Chosen: 1.1 to 2, of
harmonic drives to 3."""
FRICTION_STOPS = 2.0
"""Times the effort limit: an error."""
MULTIPLIED = 4.0
"""What multiplies a motor may be the wrong number from it on. Published: reductions to 2.2, and 2 motors."""
MULTIPLIERS = {
    "reduction": "reduction is turns of the motor's output in one of the joint",
    "transmission": "transmission is the stages from the motor's output to the joint",
    "motors_per_joint": "motors_per_joint is how many motors drive one joint together",
}
"""What multiplies a motor, in words."""


def layers(model: SpecModel) -> Iterator[tuple[Path, Tunable, Actuators]]:
    """Each group's own fields, then those of each override."""
    for name, group in model.actuators.items():
        path: Path = ("actuators", name)
        yield path, group, group
        for pattern, override in group.overrides.items():
            yield (*path, "overrides", pattern), override, group


def written_numbers(model: SpecModel, spans: SourceMap) -> dict[Span, SpecValue]:
    """The numbers of groups, overrides and the default pose as they are written, by where."""
    poses = model.robot.default_pose
    parts: list[tuple[Path, Any]] = []
    for path, fields, _ in layers(model):
        parts += [(path, fields), ((*path, "friction"), fields.friction)]
    return {spans.value(("robot", "default_pose", key)): pose for key, pose in poses.items()} | {
        spans.value((*path, key)): value
        for path, part in parts
        if part is not None
        for key in part.model_fields_set
        if isinstance(value := getattr(part, key), SpecValue)
    }


def drives_of(model: SpecModel) -> Iterator[Drive]:
    """Every motor, with the limits of the joints that it drives.

    By a reduction that is doubted itself nothing is compared, nor behind a gearbox whose output travels, but for a
    motor whose own figures are the rotor's.
    """
    limits: dict[str, list[Limit]] = {}
    trains: dict[str, dict[Path, Train]] = {}
    reductions: dict[str, list[float]] = {}
    rubs: dict[str, list[Rub]] = {}
    cuts = {name: cut for name, motor in model.motors.items() if (cut := cut_gearbox(motor)) is not None}
    for path, fields, group in layers(model):
        name = fields.motor or group.motor
        if name is None:
            continue
        reduction, count = (
            fields.reduction or group.reduction,
            fields.motors_per_joint or group.motors_per_joint or 1,
        )
        own = path if fields.motors_per_joint is not None else path[:2]
        counted = (*own, "motors_per_joint") if count > 1 else None
        own = path if fields.reduction is not None else path[:2]
        reduced = None if reduction is None else (*own, "reduction")
        stages = fields.transmission or group.transmission
        train: Path | None = None
        if stages is not None:
            motor = model.motors.get(name)
            if motor is None or not turns(motor) or not all(is_one(stage) for stage in stages):
                continue
            train = (*(path if fields.transmission is not None else path[:2]), "transmission")
            trains.setdefault(name, {})[train] = Train(stages, count, train)
        elif name in cuts and reduction is None:
            first, train = cuts[name][1], (*path[:2], "gearbox")
            gearbox = model.motors[name].gearbox or ()
            trains.setdefault(name, {})[train] = Train(
                gearbox[first:], count, ("motors", name, "gearbox"), first
            )
        elif reduction is not None and _is_geared_up(reduction):
            reductions.setdefault(name, [])
            continue
        if train is None:
            reductions.setdefault(name, []).append((reduction and reduction.value) or 1.0)
        word = fields.effort_limit or group.effort_limit
        if not isinstance(word, SpecValue):
            rubs.setdefault(name, []).extend(
                Rub(
                    value,
                    (*path, "friction", key),
                    word,
                    (reduction and reduction.value) or 1.0,
                    count,
                    train,
                )
                for key in ("coulomb", "viscous")
                if (value := getattr(fields.friction, key, None)) is not None and value.value
            )
        for field in ("effort_limit", "velocity_limit"):
            value = getattr(fields, field)
            # What is written as unknown limits nothing that could be compared.
            if isinstance(value, SpecValue) and value.value is not None:
                factor = None if reduction is None else reduction.value
                limit = Limit(value, (*path, field), factor or 1.0, count, train, counted, reduced)
                limits.setdefault(name, []).append(limit)
    linked = {name for linkage in model.linkages.values() for name in linkage.motors}
    commands: dict[str, set[str]] = {}
    for _, fields, group in layers(model):
        if (name := fields.motor or group.motor) is not None:
            commands.setdefault(name, set()).add(group.command)
    for name, motor in model.motors.items():
        motor = cuts[name][0] if name in cuts else motor
        # Of a motor that drives nothing yet its output is a joint's.
        plain = reductions.get(name, [] if name in trains else [1.0])
        yield Drive(
            name,
            motor,
            tuple(limits.get(name, ())),
            trains=trains.get(name, {}),
            reductions=None if name in linked else tuple(plain),
            wheels=commands.get(name) == {"velocity"},
            rubs=tuple(rubs.get(name, ())),
        )


def turns(motor: Motor) -> bool:
    """Whether what a motor gives out turns, by its gearbox and the units of its figures."""
    if any(stage_ratio(stage) is None for stage in motor.gearbox or ()):
        return False
    figures = (motor.stall_torque, motor.peak_torque, motor.continuous_torque, motor.no_load_speed)
    return not any(value is not None and value.linear for value in figures)


def group_doubts(
    model: SpecModel, spans: SourceMap, doubted: Collection[str | Span | None], kept: Kept
) -> Iterator[Doubt]:
    """What can hardly be right about groups; an override's fields are judged with those of its group.

    Args:
        model: What the spec says.
        spans: Where it says it.
        doubted: Numbers that are doubted themselves, and tell nothing of others: where, and their spans.
        kept: What the author is sure of.
    """
    # A target that draws has the same as an error (RND004).
    told_of_draws = is_drawn(model)
    for path, fields, group in layers(model):
        base: Path = path[:2]

        def stated(
            key: str, path: Path = path, base: Path = base, fields: Any = fields, group: Any = group
        ) -> tuple[Any, Path, bool]:
            """A field of the layer, else of the group; where; and whether it is the layer's."""
            own = getattr(fields, key)
            return (
                (own, (*path, key), True) if own is not None else (getattr(group, key), (*base, key), False)
            )

        limit, limit_path, own_limit = stated("effort_limit")
        friction, friction_path, own_friction = stated("friction")
        # What is judged by a wrong limit says nothing.
        told = spans.value(limit_path) in doubted
        if friction is not None and (own_limit or own_friction) and isinstance(limit, SpecValue) and not told:
            yield from _friction(friction, friction_path, limit, limit_path, spans, kept)
        kp, kp_path, own_kp = stated("kp")
        kd, kd_path, own_kd = stated("kd")
        for gain, place, own in ((kp, kp_path, own_kp), (kd, kd_path, own_kd)):
            if own and isinstance(gain, DerivedGain):
                yield from derived_doubts(gain, place, spans)
        if (own_kp or own_kd) and isinstance(kp, SpecValue) and isinstance(kd, SpecValue):
            slide = bool(kp.linear or kd.linear)
            most = _most_of(stated, model, spans, doubted, slide)
            known = None if most is None else most.value
            viscous = 0.0 if friction is None or friction.viscous is None else friction.viscous.value or 0.0
            driven = stated("motor")[0] in model.motors
            kind = JointKind.SLIDE if slide else JointKind.HINGE
            # Without a motor the robot's file may have such a servo, which is read at its joints.
            stiff, soft = (STIFF_RETURN, 1.0) if driven else (0.0, math.inf)
            speed = _speed_of(stated, model)
            armature = stated("armature")[0]
            inertia = (armature.value or 0.0) if isinstance(armature, SpecValue) else 0.0
            gains = Gains(
                kp.value or 0.0, kd.value, viscous, known, driven, stiff, kind, soft, speed, inertia
            )
            paths = {"kp": kp_path, "kd": kd_path}
            found = gain_words(gains, {key: spans.value(path) for key, path in paths.items()})
            if found is not None:
                field, message, help = found
                place = paths.pop(field)
                if most is not None and most.times >= MULTIPLIED and most.place is not None:
                    alone = replace(gains, limit=most.value / most.times)
                    if gain_words(alone, {}) is None:
                        # Without what multiplies the motor the gains are sound.
                        times = format_quantity(most.times, "", 4)
                        message += f", {times} times what the motor gives"
                        words = MULTIPLIERS[str(most.place[-1])]
                        help = (
                            f"one of 2 numbers is wrong. {words}. Or {field} ({spans.value(place)}): {help}"
                        )
                        paths[field], place = place, most.place
                yield at(spans, "SPEC192", message, place, help, *paths.values())
        bias = fields.encoder_bias
        if bias is not None and is_off(bias):
            yield off([bias], (*path, "encoder_bias"), (), spans)
        reduction = fields.reduction
        if reduction is not None and _is_geared_up(reduction):
            yield _geared_up(reduction, (*path, "reduction"), spans)
        if fields is group:
            hinged = _most_of(stated, model, spans, doubted)
            yield from draw_doubts(
                group, path, None if hinged is None else hinged.value, told_of_draws, spans
            )


class _Most(NamedTuple):
    """What a joint has at most.

    Attributes:
        value: [N*m or N].
        times: What its motor gives is so many times less; 1 where it is stated.
        place: Where the larger of what multiplies the motor is written; None: nothing does.
    """

    value: float
    times: float = 1.0
    place: Path | None = None


def _most_of(
    stated: Callable[[str], tuple[Any, Path, bool]],
    model: SpecModel,
    spans: SourceMap,
    doubted: Collection[str | Span | None],
    slide: bool = False,
) -> _Most | None:
    """The effort limit of a hinge or slide, or what its motor gives there; None where it is unknown or doubted."""
    limit, path, _ = stated("effort_limit")
    if spans.value(path) in doubted:
        return None
    if isinstance(limit, SpecValue):
        return None if bool(limit.linear) != slide or not limit.value else _Most(limit.value)
    name, (reduction, reduced, _) = stated("motor")[0], stated("reduction")
    count, counted, _ = stated("motors_per_joint")
    motor = model.motors.get(name)
    if motor is None or (reduction and _is_geared_up(reduction)):
        return None
    if any(isinstance(place, str) and place.startswith(f"motors.{name}.") for place in doubted):
        return None
    between, way, _ = stated("transmission")
    if not {spans.value(reduced), spans.value(counted)}.isdisjoint(doubted):
        return None
    if limit == "continuous":
        motor = motor.model_copy(update={"peak_torque": None, "stall_torque": None, "curve": None})
    if slide:
        force = _force_of(name, motor, model, way if between is not None else (*path[:2], "gearbox"))
        return None if force is None or reduction is not None else _Most(force)
    if between is not None or not turns(motor):
        return None
    torque = output_of(name, motor).torque
    factor = 1.0 if reduction is None else reduction.value
    if not torque or not factor:
        return None
    times = float(factor * (count or 1))
    place = reduced if factor >= (count or 1) else counted
    return _Most(torque * times, times, None if times == 1.0 else place)


def _speed_of(stated: Callable[[str], tuple[Any, Path, bool]], model: SpecModel) -> float | None:
    """What a motor that turns lets a hinge have without load, else its own limit [rad/s]; None: that is unknown."""
    name, reduction = stated("motor")[0], stated("reduction")[0]
    motor = model.motors.get(name)
    if motor is None:
        return number(stated("velocity_limit")[0])
    if stated("transmission")[0] is not None or not turns(motor):
        return None
    speed = output_of(name, motor).speed
    return None if not speed else speed / ((reduction and reduction.value) or 1.0)


def _force_of(name: str, motor: Motor, model: SpecModel, way: Path) -> float | None:
    """What a motor gives behind a screw, a pinion or a belt [N]; `way` is the key of that among its trains."""
    drive = next(drive for drive in drives_of(model) if drive.name == name)
    train = drive.trains.get(way)
    if train is None or not train.slide:
        return None
    cut = cut_gearbox(motor)
    torque = output_of(name, motor if cut is None else cut[0]).torque
    force = (torque or 0.0) * train.torque
    return force if 0.0 < force < math.inf else None


def reduction_of(name: str, group: Actuators) -> tuple[Path, float] | None:
    """Where the reduction of all joints of a group is written, and its size; None: none, or some have another."""
    own = group.reduction
    if (
        own is None
        or own.value is None
        or any(other.reduction or other.motor for other in group.overrides.values())
    ):
        return None
    return ("actuators", name, "reduction"), own.value


def _is_geared_up(reduction: SpecValue) -> bool:
    """Whether the joint turns faster than the output of its motor."""
    return bool(reduction.value) and (reduction.value or 0.0) < 1.0


def _geared_up(reduction: SpecValue, path: Path, spans: SourceMap) -> Doubt:
    """A joint that turns faster than the output of its motor; published: 1.5 (knees of Go1 and Go2)."""
    inverse = format_quantity(1.0 / (reduction.value or 1.0), "", 3)
    return at(
        spans,
        "SPEC182",
        f"{reduction.written} turns of the motor's output in one turn of the joint: the joint turns {inverse} times as "
        "fast",
        path,
        f"did you mean {inverse}? reduction is turns of the motor's output in one turn of the joint",
        error=(reduction.value or 1.0) < NEVER_GEARED_UP,
    )


def _friction(
    friction: Friction, path: Path, limit: SpecValue, limit_path: Path, spans: SourceMap, kept: Kept
) -> Iterator[Doubt]:
    """Dry friction against the effort limit, both stated; break-away friction where the kinetic one may be right."""
    coulomb, static = friction.coulomb, friction.static
    if limit.value is None:
        return
    kinetic = None if coulomb is None else coulomb.value
    most = (limit.value, limit.unit, None if limit_path in kept.paths else spans.value(limit_path))
    found = None if coulomb is None or kinetic is None else friction_words(kinetic, coulomb.unit, *most)
    place = (*path, "coulomb")
    if found is None and static is not None and static.value is not None:
        found, place = static_words(static.value, static.unit, *most, kinetic), (*path, "static")
    if found is not None:
        message, help, error = found
        yield at(spans, "FRC101", message, place, help, limit_path, error=error)


def static_words(
    static: float, unit: str, limit: float, limit_unit: str, place: Span | None, coulomb: float | None
) -> tuple[str, str, bool] | None:
    """As `friction_words`, of the break-away friction beside a kinetic one that may be right; None: that is unknown."""
    if static < limit and static < BREAK_AWAY * (static if coulomb is None else coulomb):
        # The two differ by what is usual.
        return None
    found = friction_words(static, unit, limit, limit_unit, place)
    if found is None:
        return None
    message, help, error = found
    if coulomb:
        meant = static / 10.0 ** max(1, math.floor(math.log10(static / coulomb)))
        if coulomb <= meant:
            own = format_quantity(coulomb, unit)
            help = f"did you mean {format_quantity(meant, unit, 4)}? The kinetic one is {own}"
    return message.replace("dry friction", "break-away friction"), help, error


def friction_words(
    coulomb: float,
    unit: str,
    limit: float,
    limit_unit: str,
    place: Span | None,
    usual: float | None = None,
) -> tuple[str, str, bool] | None:
    """What dry friction implies: message, help, whether it is an error; None where it is a small part of the limit.

    `place` is that of the limit, which may be the wrong one; None: it is written nowhere, or right. `usual` is what the
    robot's file or the other joints have, and tells N*cm from mN*m.
    """
    if coulomb < FRICTION_SHARE * limit:
        return None
    shown, most = format_quantity(coulomb, unit), format_quantity(limit, limit_unit)
    if coulomb < limit:
        message = (
            f"the dry friction of {shown} takes {100 * coulomb / limit:.0f} % of the effort limit of {most}"
        )
    else:
        message = f"the dry friction of {shown} is not below the effort limit of {most}"
        message += ": the drive cannot move the joint"
    slip, times = f"m{unit}", 1000.0
    if unit == "N*m" and usual and math.isclose(coulomb / 100.0, usual, rel_tol=0.03):
        slip, times = "N*cm", 100.0
    help = f"is it in {slip} ({format_quantity(coulomb / times, unit)}), or a dimensionless coefficient?"
    if place is not None:
        help += f" Or is the limit wrong ({place})?"
    return message, help, coulomb >= FRICTION_STOPS * limit
