"""What `actspec show` prints: every value of a joint with unit, origin, source, formula, and what it overrides."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

from actspec.fields import BY_IR
from actspec.ir import Approximation, JointActuator, Quantity
from actspec.report.tables import table
from actspec.units import format_number, format_quantity

_WITHOUT = "; the armature is unknown, and what follows holds for the file's own or none"
_OVERVIEW = ("kp", "kd", "effort_limit", "armature", "friction_coulomb", "friction_viscous")


def details(joint: JointActuator, approximations: Iterable[Approximation]) -> Iterator[str]:
    """Every value of a joint.

    Args:
        joint: The joint.
        approximations: Of the spec itself.
    """
    yield (
        f"{joint.joint}  ({joint.kind.value}, group {joint.group} by '{joint.pattern}', level {joint.level.value}, "
        f"command {joint.command.value}" + (f", motor {joint.motor})" if joint.motor else ")")
    )
    rows: list[tuple[str, ...]] = [("field", "value", "origin", "source", "where", "formula or note")]
    for field, quantity in joint.quantities():
        rows.append((field, *_cells(quantity)))
        for lost in quantity.lost:
            rows.append(("  overridden", *_cells(lost)))
    yield from table(rows)
    if joint.delay is not None and joint.delay.low != joint.delay.high:
        yield (
            f"  delay range {format_number(joint.delay.low * 1e3)} to {format_number(joint.delay.high * 1e3)} ms, "
            f"drawn each {joint.delay.sampling}"
        )
    for entry in joint.randomize:
        yield f"  randomize {entry.field}: {entry.words}"
    for loss in (item for item in approximations if item.joint == joint.joint):
        error = loss.max_torque_error
        size = f"; torque error {format_quantity(error, loss.unit, 4)}" if error else ""
        yield f"  approximated, {loss.key}: {loss.asked} -> {loss.emitted}{size} ({loss.why})"
    yield from _dynamics(joint)


def _cells(quantity: Quantity) -> tuple[str, str, str, str, str]:
    value = format_quantity(quantity.value, quantity.unit)
    if quantity.std is not None:
        value += f" (std {format_number(quantity.std, 3)})"
    remark = "; ".join(part for part in (quantity.formula, quantity.note) if part)
    place = str(quantity.span) if quantity.span is not None else ""
    return value, quantity.origin.value, quantity.source or "", place, remark


def _dynamics(joint: JointActuator) -> Iterator[str]:
    """Natural frequency and damping ratio, with and without passive friction, and the inertias."""
    held, free = joint.inertia_held, joint.inertia_free
    unit = joint.armature.unit
    if held is None or free is None:
        yield "  inertia at the joint: unknown"
        return
    words = [
        f"{name} {format_quantity(inertia.reference, unit)} "
        f"({format_number(inertia.low, 4)} to {format_number(inertia.high, 4)}"
        for name, inertia in (("held", held), ("free", free))
    ]
    known = joint.armature.known
    yield f"  inertia {words[0]} over the poses), {words[1]}){'' if known else _WITHOUT}"
    kp = joint.kp.value if joint.kp is not None else None
    kd = joint.kd.value if joint.kd is not None else None
    if kp is None or kp <= 0 or kd is None:
        return
    frequency = math.sqrt(kp / held.reference)
    scale = 2.0 * math.sqrt(kp * held.reference)
    viscous = joint.friction_viscous.value
    damped = (
        "and more with viscous friction, which is unknown"
        if viscous is None
        else f"{format_number((kd + viscous) / scale, 3)} with viscous friction"
    )
    yield (
        f"  natural frequency {format_number(frequency, 4)} rad/s ({format_number(frequency / (2 * math.pi), 3)} Hz), "
        f"damping ratio {format_number(kd / scale, 3)} by kd alone, {damped} (inertia held, reference pose)"
    )


def overview(joints: Iterable[JointActuator]) -> list[str]:
    """One line a joint."""
    rows: list[tuple[str, ...]] = [("joint", "group", "level", *map(title, _OVERVIEW))]
    for joint in joints:
        values = (getattr(joint, name) for name in _OVERVIEW)
        cells = (
            number(q) if q is None or q.value is None else f"{number(q)} {q.origin.value}" for q in values
        )
        rows.append((joint.joint, joint.group, joint.level.value, *cells))
    return table(rows)


def title(name: str) -> str:
    """What a figure is called over a column of a spec's numbers: as in the spec where it is a part there.

    Args:
        name: Attribute of a joint.
    """
    field = BY_IR[name]
    return field.spec.partition(".")[2] or field.title


def number(quantity: Quantity | None) -> str:
    """A figure for a column: `-` where the joint has none."""
    if quantity is None:
        return "-"
    return "unknown" if quantity.value is None else format_number(quantity.value)


def joint_record(joint: JointActuator) -> dict[str, Any]:
    """A joint of `actspec-actuators/1`."""
    record: dict[str, Any] = {"joint": joint.joint, "group": joint.group, "level": joint.level.value}
    record["command"] = joint.command.value
    for field, quantity in joint.quantities():
        record[field] = _quantity_record(quantity)
    for name in ("inertia_held", "inertia_free"):
        inertia = getattr(joint, name)
        record[name] = (
            None
            if inertia is None
            else {
                "reference": inertia.reference,
                "low": inertia.low,
                "high": inertia.high,
                "unit": joint.armature.unit,
            }
        )
    return record


def _quantity_record(quantity: Quantity) -> dict[str, Any]:
    return {
        "value": quantity.value,
        "unit": quantity.unit,
        "origin": quantity.origin.value,
        "source": quantity.source,
        "std": quantity.std,
        "where": str(quantity.span) if quantity.span is not None else None,
        "formula": quantity.formula,
        "note": quantity.note,
        "passed_over": [_quantity_record(lost) for lost in quantity.lost],
    }
