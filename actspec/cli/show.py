"""`actspec show`: every value of a joint with unit, origin, source, formula, and what lost to it."""

from __future__ import annotations

import argparse
import math
import sys
from collections.abc import Iterator, Sequence
from typing import Any

from actspec import api
from actspec.cli.options import add_format, describe
from actspec.diagnostics import EXIT_CLEAN, ResolveError, listed
from actspec.ir import ActuatorSet, Approximation, JointActuator, Quantity
from actspec.report.tables import table
from actspec.report.terminal import print_diagnostics, print_json
from actspec.units import format_quantity


def add_arguments(command: argparse.ArgumentParser) -> None:
    """Add the command's arguments and what its help says."""
    describe(
        command,
        "Show the actuators of a spec, fitted to its robot. Without a joint one line a joint; with one every value "
        "with unit, origin, source, place and formula, and the values that it overrides.",
        "actspec show robots/a1.yaml FR_calf_joint",
        "0 shown; 2 could not",
    )
    command.add_argument("spec", metavar="SPEC", help="actuator spec (YAML)")
    command.add_argument("joint", nargs="?", metavar="JOINT", help="joint, or a pattern of joints")
    add_format(command)


def run(arguments: argparse.Namespace) -> int:
    """Show one joint, those that a pattern matches, or all."""
    actuators = api.resolve(arguments.spec)
    joints = actuators.joints if arguments.joint is None else _chosen(actuators, arguments.joint)
    if arguments.output_format == "json":
        print_json({"format": "actspec-actuators/1", "joints": [_record(joint) for joint in joints]})
        return EXIT_CLEAN
    print_diagnostics(actuators.diagnostics)
    detailed = arguments.joint is not None
    for index, joint in enumerate(joints):
        if index and detailed:
            print()
        losses = [loss for loss in actuators.approximations if loss.joint == joint.joint]
        sys.stdout.writelines(line + "\n" for line in (_details(joint, losses) if detailed else ()))
    if not detailed:
        print(
            f"{actuators.robot}: {len(joints)} joints; `actspec show {arguments.spec} JOINT` shows every value"
        )
        sys.stdout.writelines(line + "\n" for line in table(list(_overview(joints))))
    return EXIT_CLEAN


def _chosen(actuators: ActuatorSet, pattern: str) -> tuple[JointActuator, ...]:
    from actspec.patterns import PatternError, match_names, suggest_pattern

    names = [joint.joint for joint in actuators.joints]
    help: str | None = f"joints: {listed(names)}"
    message = f"'{pattern}' matches no joint that the spec manages"
    try:
        found = set(match_names(pattern, names)) or ({pattern} & set(names))
        guess = suggest_pattern(pattern, names)
        help = f"did you mean '{guess}'?" if guess else help
    except PatternError as err:
        found, message, help = {pattern} & set(names), err.message, err.help
    if not found:
        raise ResolveError.of("BIND001", message, where="JOINT", help=help)
    return tuple(joint for joint in actuators.joints if joint.joint in found)


def _details(joint: JointActuator, losses: Sequence[Approximation]) -> Iterator[str]:
    """Every value of a joint; `losses` are what the spec simplifies of it."""
    yield (
        f"{joint.joint}  ({joint.kind.value}, group {joint.group} by '{joint.pattern}', level {joint.level.value}, "
        f"command {joint.command.value}" + (f", motor {joint.motor})" if joint.motor else ")")
    )
    rows: list[tuple[str, ...]] = [("field", "value", "origin", "source", "where", "formula or note")]
    for field, quantity in joint.quantities():
        rows.append((field, *_cells(quantity)))
        for lost in quantity.lost:
            rows.append(("  passed over", *_cells(lost)))
    yield from table(rows)
    if joint.delay is not None and joint.delay.low != joint.delay.high:
        yield (
            f"  delay range {joint.delay.low * 1e3:g} to {joint.delay.high * 1e3:g} ms, drawn each "
            f"{joint.delay.sampling}"
        )
    for entry in joint.randomize:
        yield (
            f"  randomize {entry.field}: {entry.operation} {entry.low:g} to {entry.high:g} "
            f"({entry.distribution}, at {entry.when}, per {entry.per})"
        )
    for loss in losses:
        size = f"; torque error {loss.max_torque_error:.4g} {loss.unit}" if loss.max_torque_error else ""
        yield f"  approximated, {loss.key}: {loss.asked} -> {loss.emitted}{size} ({loss.why})"
    yield from _dynamics(joint)


def _cells(quantity: Quantity) -> tuple[str, str, str, str, str]:
    value = format_quantity(quantity.value, quantity.unit)
    if quantity.std is not None:
        value += f" (std {quantity.std:.3g})"
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
    yield (
        f"  inertia held {format_quantity(held.reference, unit)} ({held.low:.4g} to {held.high:.4g} over the poses), "
        f"free {format_quantity(free.reference, unit)} ({free.low:.4g} to {free.high:.4g})"
    )
    kp = joint.kp.value if joint.kp is not None else None
    kd = joint.kd.value if joint.kd is not None else None
    if kp is None or kp <= 0 or kd is None:
        return
    viscous = joint.friction_viscous.value or 0.0
    frequency = math.sqrt(kp / held.reference)
    scale = 2.0 * math.sqrt(kp * held.reference)
    yield (
        f"  natural frequency {frequency:.4g} rad/s ({frequency / (2 * math.pi):.3g} Hz), damping ratio "
        f"{kd / scale:.3g} by kd alone, {(kd + viscous) / scale:.3g} with viscous friction "
        "(inertia held, reference pose)"
    )


def _overview(joints: tuple[JointActuator, ...]) -> Iterator[tuple[str, ...]]:
    yield ("joint", "group", "level", "kp", "kd", "effort limit", "armature", "coulomb", "viscous")
    for joint in joints:
        numbers = (
            joint.kp,
            joint.kd,
            joint.effort_limit,
            joint.armature,
            joint.friction_coulomb,
            joint.friction_viscous,
        )
        cells = (
            "-" if q is None else "unknown" if q.value is None else f"{q.value:.6g} {q.origin.value}"
            for q in numbers
        )
        yield (joint.joint, joint.group, joint.level.value, *cells)


def _record(joint: JointActuator) -> dict[str, Any]:
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
