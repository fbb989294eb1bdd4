"""Static agreement: what the files say of each joint against what the spec says, field by field."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from actspec.diagnostics import Span
from actspec.fields import FIELDS
from actspec.ir import ActuatorSet, JointActuator, Level
from actspec.readings.compare import NOTHING, Figure, same
from actspec.targets.isaaclab import dialect_for
from actspec.verify.agreement import Row, TargetFiles, alike, keys
from actspec.verify.classify import WrongFigure, classify
from actspec.verify.layout import TOLERANCE, compiled_rows, driven, figure_text, layout_rows
from actspec.verify.readback import ABSENT, OVERLAY_FIELDS, Figures, FileFigures

_DRIVE = ("kp", "kd", "effort_limit", "stall_torque", "no_load_speed", "delay_low", "delay_high")
_PASSIVE = ("joint_damping", "frictionloss", "armature")
_COMMAND = ("filter_cutoff", "command_low", "command_high", "encoder_bias")
_CURVE = ("curve.drive_torque", "curve.brake_torque", "curve.knee_speed")

HELD: Mapping[str, tuple[str, ...]] = {
    "mujoco": (*_DRIVE, *_PASSIVE, *_COMMAND),
    "isaaclab": (*_DRIVE, *_PASSIVE, *_COMMAND, *_CURVE, "velocity_limit", "friction_static"),
    "mjlab": (*_DRIVE, *_PASSIVE, "action_scale", "default_position"),
    "deploy": (
        *("kp", "kd", "effort_limit", "velocity_limit", "delay_nominal", "delay_low", "delay_high"),
        *("command_low", "command_high", "position_low", "position_high", "default_position", "action_scale"),
    ),
    "newton": OVERLAY_FIELDS,
    "urdf": ("effort_limit", "velocity_limit", "joint_damping", "frictionloss"),
}
"""Kind of target to the fields that it can hold, which are held to the spec; all others are held to what actspec
writes. A field is held to that too where it is a known approximation, or where the spec does not know it."""

MORE_LOSSES: Mapping[str, tuple[str, ...]] = {
    "kd": ("friction.viscous",),
    "friction_static": ("friction.coulomb",),
    "effort_limit": ("torque_speed_curve",),
    "delay_low": ("delay",),
    "delay_high": ("delay",),
    "default_position": ("default_position",),
}
"""Field to the names of approximations that change it beside its own, `Field.spec`."""

_REPORTED_ELSEWHERE = frozenset({"total_damping", "actuator_damping", "back_emf", "delay"})
"""Sums and parts of other fields."""

_FACTOR = re.compile(r"[x/] ([0-9.eE+-]+) \((gear_ratio|reduction|stages?|lead|radius|factor)\w*(\^2)?\)")
"""A factor in the formula of a derived number: `x 81 (gear_ratio^2)`."""


@dataclass(frozen=True, slots=True)
class _Compared:
    """One figure of one joint."""

    actuator: JointActuator
    field: str
    expected: float | None
    got: Figure | None
    value: float | None
    unit: str
    approximations: tuple[str, ...]

    @property
    def error(self) -> float | None:
        if self.expected is None or self.value is None:
            return None
        if self.expected == self.value:
            return 0.0
        difference = abs(self.value - self.expected)
        return difference if math.isfinite(difference) else None

    @property
    def tolerance(self) -> float:
        return (
            NOTHING
            if self.expected is None or not math.isfinite(self.expected)
            else max(TOLERANCE * abs(self.expected), NOTHING)
        )

    @property
    def ok(self) -> bool:
        return same(self.value, self.expected, TOLERANCE)


def field_rows(
    target: TargetFiles, actuators: ActuatorSet, asked: Figures, fresh: FileFigures, built: FileFigures
) -> Iterator[Row]:
    """Rows of all fields of a target's file.

    Args:
        target: The target.
        actuators: What the spec asks for.
        asked: The same as figures, of `readback.spec_figures`.
        fresh: What actspec writes.
        built: The file that is verified.
    """
    if built.reason is not None:
        yield broken(target, f"the file cannot be read: {built.reason}", place=built.refused_at)
        return
    if built.refusal is not None and fresh.refusal is None:
        yield broken(target, f"MuJoCo refuses the file: {built.refusal}", place=built.refused_at)
        return
    yield from layout_rows(target, actuators, fresh, built)
    compared = [
        one
        for actuator in actuators.joints
        if actuator.joint in built.figures and driven(actuator.joint, fresh, built)
        for one in _compare(target, actuator, asked, fresh.figures, built.figures[actuator.joint])
    ]
    yield from _rows(target, actuators, asked, built, fresh, compared, None)
    if target.options.kind == "mujoco" and target.folder != target.fresh and built.refusal is None:
        wrong = {one.actuator.joint for one in compared if not one.ok}
        yield from compiled_rows(target, actuators, built.figures, wrong)


def engine_rows(
    target: TargetFiles,
    actuators: ActuatorSet,
    asked: Figures,
    fresh: FileFigures,
    figures: Mapping[str, Mapping[str, float]],
    engine: str,
) -> Iterator[Row]:
    """Rows of what an engine itself reports of the joints; see `field_rows`.

    Args:
        figures: Joint to field to value.
        engine: Its name and version.
    """
    compared = []
    for actuator in actuators.joints:
        said = figures.get(actuator.joint, {})
        found = {
            name: Figure(value, "", Span(target.path(target.files[0])), True) for name, value in said.items()
        }
        compared += [
            one
            for one in _compare(target, actuator, asked, fresh.figures, found)
            # What nobody states the engine takes from elsewhere.
            if one.field in said and one.expected is not None
        ]
    yield from _rows(target, actuators, asked, None, fresh, compared, engine)


def broken(target: TargetFiles, message: str, engine: str | None = None, place: Span | None = None) -> Row:
    """The row of a file that cannot be read, or that an engine refuses."""
    return target.fault("file", "VFY111", message, engine=engine, place=place)


def _compare(
    target: TargetFiles, actuator: JointActuator, asked: Figures, fresh: Figures, built: Mapping[str, Figure]
) -> Iterator[_Compared]:
    held = HELD.get(target.options.kind, ())
    spec, written = asked[actuator.joint], fresh.get(actuator.joint, {})
    for field in dict.fromkeys((*held, *written, *built)):
        if field in _REPORTED_ELSEWHERE:
            continue
        own_key = (FIELDS[field].spec,) if field in FIELDS else ()
        lost = target.losses_of(actuator.joint, (*own_key, *MORE_LOSSES.get(field, ())))
        own = spec.get(field)
        expected = own.value if own is not None and field in held else None
        if own is not None and not own.stated and _value(written.get(field), field, ()) is None:
            # What the spec does not state is not written where a target can keep its own.
            expected = None
        # The torque of a network is its own; gains beside it are the target's to choose.
        network = actuator.level is Level.ACTUATOR_NET and field not in _PASSIVE
        if expected is None or lost or network:
            expected = _value(written.get(field), field, held)
        got = built.get(field)
        value = _value(got, field, held)
        if expected is None and value is None:
            continue
        unit = next((f.unit for f in (own, got, written.get(field)) if f is not None and f.unit), "")
        yield _Compared(actuator, field, expected, got, value, unit, keys(lost))


def _value(figure: Figure | None, field: str, held: Sequence[str]) -> float | None:
    if figure is None or figure.value is None:
        return ABSENT.get(field) if field in held else None
    return figure.value


def _rows(
    target: TargetFiles,
    actuators: ActuatorSet,
    asked: Figures,
    built: FileFigures | None,
    fresh: FileFigures,
    compared: Sequence[_Compared],
    engine: str | None,
) -> Iterator[Row]:
    """One row for the joints of a group that have the same numbers, the field and what is wrong with it."""
    everywhere: dict[str, dict[str, tuple[float | None, float | None]]] = {}
    found: dict[str, dict[str, float | None]] = {}
    for one in compared:
        everywhere.setdefault(one.field, {})[one.actuator.joint] = (one.expected, one.value)
        found.setdefault(one.actuator.joint, {})[one.field] = one.value
    by_joint: dict[str, list[_Compared]] = {}
    for one in compared:
        by_joint.setdefault(one.actuator.joint, []).append(one)
    for members in alike(actuators):
        merged: dict[tuple[str, str | None], list[tuple[_Compared, str]]] = {}
        for one in (one for member in members for one in by_joint.get(member.joint, [])):
            code, reason = None, ""
            if not one.ok:
                own = {name: figure.value for name, figure in asked[one.actuator.joint].items()}
                difference = WrongFigure(
                    field=one.field,
                    expected=one.expected,
                    got=one.value,
                    asked=own,
                    found=found[one.actuator.joint],
                    everywhere=everywhere[one.field],
                    factors=_factors(one.actuator),
                    forgotten=_forgotten(target, one),
                    geared=built is not None and _geared(one.actuator.joint, fresh, built),
                    versioned=_versioned(target),
                )
                code, reason = classify(difference)
            merged.setdefault((one.field, code), []).append((one, reason))
        for (field, code), group in merged.items():
            worst, reason = max(group, key=lambda pair: _size(pair[0]))
            yield _row(target, field, code, worst, reason, [one for one, _ in group], engine)


def _size(one: _Compared) -> float:
    error = one.error
    return math.inf if error is None else error / one.tolerance


def _row(
    target: TargetFiles,
    field: str,
    code: str | None,
    worst: _Compared,
    reason: str,
    group: Sequence[_Compared],
    engine: str | None,
) -> Row:
    place = worst.got.place if worst.got is not None and engine is None else None
    return Row(
        target=target.name,
        group=worst.actuator.group,
        joint=worst.actuator.joint,
        joints=len(group),
        quantity=field,
        unit=worst.unit,
        max_error=worst.error,
        tolerance=worst.tolerance,
        ok=code is None,
        expected=worst.expected,
        got=worst.value,
        approximations=worst.approximations,
        engine=engine,
        code=code,
        message="" if code is None else _message(worst, reason, engine),
        place=place if code is not None else None,
    )


def _message(one: _Compared, reason: str, engine: str | None) -> str:
    noun = FIELDS[one.field].noun if one.field in FIELDS else one.field
    said = figure_text(one.value, one.unit)
    where = f" in {engine}" if engine is not None else ""
    what = "is not stated" if one.value is None else f"is {said}"
    asked = "" if one.expected is None else f", and should be {figure_text(one.expected, one.unit)}"
    return f"the {noun} {what}{where}{asked}: {reason}"


def _factors(actuator: JointActuator) -> tuple[float, ...]:
    """Gears and reductions of a joint, from the formulas of its numbers, and all of them together."""
    single: dict[float, None] = {}
    for _, quantity in actuator.quantities():
        found = []
        for text, _name, square in _FACTOR.findall(quantity.formula or ""):
            value = float(text)
            found.append(math.sqrt(value) if square else value)
        product = math.prod(found)
        single.update(dict.fromkeys([*found, product]))
    return tuple(value for value in single if value not in (0.0, 1.0))


def _forgotten(target: TargetFiles, one: _Compared) -> bool:
    """Whether a mapping of a cfg leaves the joint out: the classes of Isaac Lab take 0 then."""
    got = one.got
    return (
        target.options.kind == "isaaclab"
        and got is not None
        and not got.stated
        and one.value == 0.0
        and bool(one.expected)
        and one.field != "actuator_damping"
    )


def _geared(joint: str, fresh: FileFigures, built: FileFigures) -> bool:
    ours, theirs = fresh.gears.get(joint), built.gears.get(joint)
    return ours is not None and theirs is not None and ours != theirs


def _versioned(target: TargetFiles) -> bool:
    if target.options.kind != "isaaclab":
        return False
    return dialect_for(target.options).friction.torque


def without_repeats(rows: Iterable[Row]) -> tuple[Row, ...]:
    """Rows without what an engine reports of a field that is reported to be wrong in the file already."""
    every = tuple(rows)
    wrong = {(row.target, row.group, row.quantity) for row in every if row.engine is None and not row.ok}
    return tuple(
        row
        for row in every
        if row.ok or row.engine is None or (row.target, row.group, row.quantity) not in wrong
    )
