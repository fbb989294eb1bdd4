"""The summary of a compile: what the robot has, what each target got, what was lost."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from actspec.api import Compilation
from actspec.cli.report import table
from actspec.diagnostics import Severity, listed
from actspec.ir import JointActuator, JointKind, Quantity
from actspec.output import Output
from actspec.targets.base import Approximation
from actspec.units import format_quantity


def summary(compilation: Compilation, files: Sequence[Output], *, written: bool) -> Iterator[str]:
    """Lines of the summary.

    Args:
        compilation: What was compiled.
        files: Its files.
        written: Whether they were written.
    """
    actuators, robot = compilation.actuators, compilation.robot
    groups = len({a.group for a in actuators.joints})
    step = actuators.physics_dt
    timing = f"physics {format_quantity(step.require() * 1e3, 'ms')}"
    if actuators.decimation is not None:
        timing += f", control {1.0 / (step.require() * actuators.decimation):g} Hz"
    yield (
        f"{actuators.robot}: {_many(len(actuators.joints), 'joint')} in {_many(groups, 'group')}, "
        f"{robot.path}, {timing}"
    )
    if actuators.unmanaged:
        yield f"  left as they are: {listed(actuators.unmanaged)}"
    yield from table(list(_rows(actuators.joints)), headings=2)
    for options, emission in zip(compilation.targets, compilation.emissions, strict=True):
        yield ""
        yield f"{options.name}: {options.kind} {options.version} -> {options.folder}"
        for file in files:
            if file.target == options.name:
                state = "unchanged" if not file.changed else "written" if written else "not written"
                yield f"  {file.path.removeprefix(options.folder).lstrip('/')}  {state}"
        yield from _losses(emission.approximations, {key for key, _ in actuators.accept})
    warnings = sum(item.severity is Severity.WARNING for item in compilation.diagnostics)
    losses = compilation.approximations
    yield ""
    worst = max((loss.max_torque_error or 0.0 for loss in losses), default=0.0)
    text = "no approximation" if not losses else _many(len({loss.key for loss in losses}), "approximation")
    if worst:
        text += f", largest torque error {worst:.4g} {losses[0].unit}"
    yield f"{text}; {_many(warnings, 'warning')}"


def _rows(joints: Sequence[JointActuator]) -> Iterator[tuple[str, ...]]:
    """One row for the joints of a group that have the same numbers."""
    yield (
        "group",
        "joints",
        "level",
        "command",
        "kp",
        "kd",
        "effort limit",
        "no-load speed",
        "armature",
        "coulomb",
        "viscous",
        "filter",
        "delay",
    )
    yield ("", "", "", "", "N*m/rad", "N*m*s/rad", "N*m", "rad/s", "kg*m^2", "N*m", "N*m*s/rad", "", "")
    merged: dict[tuple[str, ...], int] = {}
    for joint in joints:
        delay = joint.delay
        row: tuple[str, ...] = (
            joint.group,
            joint.level.value,
            joint.command.value,
            _number(joint.kp),
            _number(joint.kd),
            _number(joint.effort_limit),
            _number(joint.no_load_speed if joint.curve is None else joint.curve.no_load_speed),
            _number(joint.armature),
            _number(joint.friction_coulomb),
            _number(joint.friction_viscous),
            "-" if joint.filter_cutoff is None else f"{joint.filter_cutoff.value:g} Hz",
            "-" if delay is None or delay.nominal.value is None else f"{delay.nominal.value * 1e3:g} ms",
            joint.kind.value,
        )
        merged[row] = merged.get(row, 0) + 1
    slides = any(row[-1] == JointKind.SLIDE.value for row in merged)
    for row, count in merged.items():
        group = f"{row[0]} (slide, in N and m)" if slides and row[-1] == JointKind.SLIDE.value else row[0]
        yield (group, str(count), *row[1:-1])


def _number(quantity: Quantity | None) -> str:
    if quantity is None:
        return "-"
    return "unknown" if quantity.value is None else f"{quantity.value:.6g}"


def _losses(losses: Sequence[Approximation], accepted: set[str]) -> Iterator[str]:
    if not losses:
        yield "  nothing is approximated"
        return
    merged: dict[tuple[str, str, str, str, str], list[str]] = {}
    for loss in losses:
        size = "-" if loss.max_torque_error is None else f"{loss.max_torque_error:.4g} {loss.unit}"
        name = f"{loss.field} (accepted)" if loss.key in accepted else loss.field
        merged.setdefault((name, loss.asked, loss.emitted, size, loss.why), []).append(loss.joint)
    rows = [("approximated", "joints", "asked", "emitted", "largest torque error", "why")]
    for (name, asked, emitted, size, why), joints in merged.items():
        rows.append((name, str(sum(bool(joint) for joint in joints)), asked, emitted, size, why))
    yield from table(rows)


def _many(count: int, noun: str) -> str:
    return f"{count} {noun}{'s' * (count != 1)}"
