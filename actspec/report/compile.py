"""The summary of a compile: what the robot has, where each target went, what was lost."""

from __future__ import annotations

import os
import textwrap
from collections.abc import Iterable, Iterator, Mapping, Sequence

from actspec.diagnostics import Severity, listed, many, one_line
from actspec.fields import BY_IR
from actspec.ir import ActuatorSet, Delay, JointActuator, JointKind, Level
from actspec.output import MANIFEST, Compilation, Output
from actspec.report.show import number, title
from actspec.report.tables import table
from actspec.resolution.simplified import NEGLIGIBLE
from actspec.targets.base import Approximation, TargetOptions
from actspec.units import format_number, format_quantity

_FIGURES = (
    "kp",
    "kd",
    "effort_limit",
    "no_load_speed",
    "armature",
    "friction_coulomb",
    "friction_viscous",
)

_OF_MUJOCO = frozenset({"mujoco", "mjlab"})
"""Targets that have MuJoCo's default step where nobody states one; Isaac Lab's tasks all state theirs."""

WIDTH = 120
"""Columns of running text. Chosen: as the heads of the written files."""


def summary(compilation: Compilation, files: Sequence[Output], *, written: bool) -> Iterator[str]:
    """Lines of the summary.

    Args:
        compilation: What was compiled.
        files: Its files.
        written: Whether they were written.
    """
    actuators = compilation.actuators
    yield from _robot(actuators, compilation.robot.path, compilation.targets)
    yield ""
    yield from table(list(_files(compilation.targets, files, written)))
    accept = dict(actuators.accept)
    open_ = compilation.unaccepted
    refused = frozenset(open_)
    taken = [loss for loss in compilation.approximations if loss not in refused]
    if taken:
        yield ""
        yield from table(list(_accepted(taken, accept)))
    if open_:
        yield ""
        yield "  approximated"
        yield from _losses(open_, len(actuators.joints))
    yield ""
    warnings = sum(item.severity is Severity.WARNING for item in compilation.diagnostics)
    yield f"{_count(taken, open_)}; {many(warnings, 'warning')}"


def _robot(actuators: ActuatorSet, path: str, targets: Sequence[TargetOptions]) -> Iterator[str]:
    groups = len({a.group for a in actuators.joints})
    step = format_quantity(actuators.physics_dt.require() * 1e3, "ms")
    timing = f"physics {step}"
    if actuators.assumed_step and any(options.kind in _OF_MUJOCO for options in targets):
        timing += f" ({actuators.assumed_step})"
    elif actuators.assumed_step:
        timing = "no physics step stated" + (f", {step} taken" if _counts_steps(actuators) else "")
    if actuators.control_period is not None:
        timing += f", control {format_quantity(1.0 / actuators.control_period, 'Hz')}"
    yield (
        f"{actuators.title}: {many(len(actuators.joints), 'joint')} in {many(groups, 'group')}, "
        f"{path}, {timing}"
    )
    if actuators.unmanaged:
        yield f"  unmanaged: {listed(actuators.unmanaged)}"
    yield from table(list(_rows(actuators.joints)), headings=2)


def _counts_steps(actuators: ActuatorSet) -> bool:
    """Whether a file may have something in physics steps: a delay, a filter or a network."""
    return any(a.delay or a.filter_cutoff or a.level is Level.ACTUATOR_NET for a in actuators.joints)


def _files(
    targets: Sequence[TargetOptions], files: Sequence[Output], written: bool
) -> Iterator[tuple[str, str, str]]:
    """One row a file; the manifests, one beside each target, share a row."""
    yield "target", "file", ""

    def state(some: Iterable[Output]) -> str:
        return ("written" if written else "not written") if any(f.changed for f in some) else "unchanged"

    for options in targets:
        label = options.title
        for file in files:
            if file.target == options.name and os.path.basename(file.path) != MANIFEST:
                yield label, file.path, state([file])
                label = ""
    manifests = [file for file in files if os.path.basename(file.path) == MANIFEST]
    parent = os.path.dirname(targets[0].folder)
    folder = targets[0].folder if len(targets) == 1 else os.path.join(parent, "*")
    yield "", os.path.join(folder, MANIFEST), state(manifests)


def _rows(joints: Sequence[JointActuator]) -> Iterator[tuple[str, ...]]:
    """One row for the joints of a group that have the same numbers."""
    titles, units = map(title, _FIGURES), (BY_IR[name].unit(JointKind.HINGE) for name in _FIGURES)
    yield ("group", "joints", "level", "command", *titles, "filter", "delay")
    yield ("", "", "", "", *units, "", "")
    merged: dict[tuple[str, ...], int] = {}
    for joint in joints:
        # A curve has a speed of its own in place of the line's.
        values = {name: getattr(joint, name) for name in _FIGURES}
        if joint.curve is not None:
            values["no_load_speed"] = joint.curve.no_load_speed
        cutoff = joint.filter_cutoff
        row: tuple[str, ...] = (
            joint.group,
            joint.level.value,
            joint.command.value,
            *map(number, values.values()),
            "-" if cutoff is None else format_quantity(cutoff.value, "Hz"),
            "-" if joint.delay is None else _delay(joint.delay),
            joint.kind.value,
        )
        merged[row] = merged.get(row, 0) + 1
    slides = any(row[-1] == JointKind.SLIDE.value for row in merged)
    for row, count in merged.items():
        group = f"{row[0]} (slide, in N and m)" if slides and row[-1] == JointKind.SLIDE.value else row[0]
        yield (group, str(count), *row[1:-1])


def _delay(delay: Delay) -> str:
    """The nominal delay, or the range where that is all."""
    if delay.nominal.value is not None:
        return format_quantity(delay.nominal.value * 1e3, "ms")
    if delay.low == delay.high:
        return "unknown"
    return f"{format_number(delay.low * 1e3)} to {format_quantity(delay.high * 1e3, 'ms')}"


def _accepted(losses: Sequence[Approximation], accept: Mapping[str, str]) -> Iterator[tuple[str, str, str]]:
    """One row for each key of `accept` that took something; what was lost in detail is in the manifest."""
    yield "approximated, as the spec accepts", "torque error", "because"
    for key in dict.fromkeys(loss.key for loss in losses):
        yield key, worst_error([loss for loss in losses if loss.key == key]) or "-", accept[key]


def _losses(losses: Sequence[Approximation], joints: int) -> Iterator[str]:
    """Each key with what is lost under it; joints that differ in the number alone share a line."""
    merged: dict[tuple[str, str, str], list[Approximation]] = {}
    for loss in losses:
        merged.setdefault((loss.key, loss.emitted, loss.why), []).append(loss)
    said = ""
    for (key, emitted, why), members in merged.items():
        if key != said:
            said = key
            yield f"    {one_line(key)}"
        asked = listed(dict.fromkeys(member.asked for member in members), most=4)
        worst = error_and_place(members)
        size = f"; torque error {worst}" if worst else ""
        named = [member.joint for member in members if member.joint]
        who = f"{len(named)} of {many(joints, 'joint')}: " if 0 < len(named) < joints else ""
        line = one_line(f"{who}{asked} -> {emitted}{size} ({why})")
        yield from textwrap.wrap(
            line, WIDTH, initial_indent=" " * 6, subsequent_indent=" " * 8, break_on_hyphens=False
        )


def worst_error(losses: Iterable[Approximation]) -> str:
    """The largest torque error, with its unit; "" where none has one."""
    sized = [loss for loss in losses if loss.max_torque_error]
    if not sized:
        return ""
    worst = max(sized, key=lambda loss: loss.max_torque_error or 0.0)
    return f"up to {format_quantity(worst.max_torque_error, worst.unit, 4)}"


def error_and_place(losses: Sequence[Approximation]) -> str:
    """The largest torque error and where it is, and that above no-load speed where it is larger; "" where none is."""
    worst = max(losses, key=lambda loss: loss.max_torque_error or 0.0)
    size = worst_error(losses)
    text = f"{size}, {worst.at}" if size and worst.at else size
    beyond = max(losses, key=lambda loss: loss.beyond or 0.0)
    if not beyond.beyond or beyond.beyond <= (worst.max_torque_error or 0.0) * (1.0 + NEGLIGIBLE):
        return text
    more = f"up to {format_quantity(beyond.beyond, beyond.unit, 4)}"
    return f"{text}; above no-load speed {more}" if text else f"none up to no-load speed, above it {more}"


def _count(taken: Sequence[Approximation], open_: Sequence[Approximation]) -> str:
    keys, refused = len({loss.key for loss in (*taken, *open_)}), len({loss.key for loss in open_})
    if not keys:
        return "no approximation"
    text = many(keys, "approximation")
    if taken:
        text += f", {refused} not accepted" if refused else ", accepted"
    worst = worst_error((*taken, *open_))
    return f"{text}, torque error {worst}" if worst else text
