"""One joint's actuator as the lines of a spec, each with the remark that belongs beside it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from actspec.diagnostics import Span
from actspec.draft.sources import stated
from actspec.draft.text import figure, quantity_text, scalar, sourced, time_text
from actspec.fields import FRICTION, unit_of_kind
from actspec.ir import Command, Delay, JointActuator, Level, Origin, Quantity, Randomization
from actspec.lift.figures import NO_KEY
from actspec.readings.artifact import FileKind
from actspec.spec.rules.groups import RANDOMIZED_KINDS
from actspec.units import Kind, format_number

MUCH_FRICTION = 0.1
"""Joint damping over kd from which the two are told together, where two files state them. Source: the warning of
a compile (DESIGN 4, precedence)."""

RANGE = "command_range"
"""The one row that never decides on a group: every joint has a range of its own."""

THE_FILE = "the file"
"""Begins the reason why a number that a file has is of no use; the row knows where it stands."""

_POSITIVE = frozenset(("effort_limit", "velocity_limit", "stall_torque", "no_load_speed"))
"""What the language takes above 0 only."""

_TOLERANCE = 1e-9
"""Relative; ends of ranges that went through a gear."""


@dataclass(frozen=True, slots=True)
class Lost:
    """What another file says in place of a row's value.

    Attributes:
        span: Where.
        text: The number with its unit.
    """

    span: Span | None
    text: str


@dataclass(frozen=True, slots=True)
class Row:
    """One line of a group.

    Attributes:
        value: YAML behind the key.
        hint: Remark beside it.
        lost: What other files say.
        spans: Where the value is written.
        refused: Whether a file states it, and what it states is of no use.
    """

    value: str
    hint: str = ""
    lost: tuple[Lost, ...] = ()
    spans: tuple[Span, ...] = ()
    refused: bool = False


def rows_of(joint: JointActuator, kinds: Sequence[FileKind], *, speeds: bool) -> dict[str, Row]:
    """Key (`friction.viscous` for a part) to line, in the order of a spec.

    Args:
        joint: With keys of `sources` in its quantities.
        kinds: What the files are: of their silence depends what is remarked.
        speeds: Whether a file states a speed limit of any joint; else none is missed.
    """
    rows: dict[str, Row] = {}
    hints = _hints(joint)

    def add(key: str, quantity: Quantity | None, name: str, *, always: bool = True) -> None:
        if quantity is None or not (always or stated(quantity)):
            return
        hint = hints.get(key, "")
        silent = _silence(key, name, quantity, kinds) or _holds_it(name, quantity, joint)
        rows[key] = _row(quantity, hint) if silent is None else _row(quantity, hint or silent, "unknown")

    add("kp", joint.kp, "kp")
    add("kd", joint.kd, "kd")
    add("effort_limit", joint.effort_limit, "effort_limit")
    add("velocity_limit", joint.velocity_limit, "velocity_limit", always=speeds)
    add("armature", joint.armature, "armature")
    cutoff = joint.filter_cutoff
    if cutoff is not None and cutoff.known:
        rows["command_filter"] = _row(cutoff, value=f"{{cutoff: {sourced(cutoff)}}}")
    if joint.delay is not None:
        nominal = joint.delay.nominal
        hint = "" if nominal.known else nominal.note or "not stated"
        rows["delay"] = _row(nominal, hint, _delay(joint.delay))
    add("encoder_bias", joint.encoder_bias, "encoder_bias", always=False)
    scale = joint.action_scale
    if scale is not None:
        # One that stands in a file and could not be read is told.
        unread = not scale.known and scale.span is not None
        add("action_scale", scale, "action_scale", always=unread)
    for part in FRICTION:
        add(part.spec, getattr(joint, part.ir), part.ir, always=not part.optional)
    return rows


def clamp_of(joint: JointActuator) -> Row | None:
    """The clamp of the command; None without one."""
    if joint.command_range is None:
        return None
    low, high = joint.command_range
    spans = _places(low)
    if joint.command is Command.POSITION and joint.position_range is not None:
        size = max(abs(end) for end in (*joint.position_range, 1e-9))
        ends = zip((low, high), joint.position_range, strict=True)
        if all(abs(end.require() - limit) <= _TOLERANCE * size for end, limit in ends):
            return Row("joint", spans=spans)
    return Row(f"[{sourced(low)}, {sourced(high)}]", spans=spans)


def motor_of(joint: JointActuator) -> dict[str, Row]:
    """Figures of the joint's motor at the joint, `curve.` before those of a curve; none where nobody has any."""
    figures: dict[str, Quantity | None] = {
        "stall_torque": joint.stall_torque,
        "no_load_speed": joint.no_load_speed,
    }
    if joint.curve is not None:
        for part in ("drive_torque", "brake_torque", "knee_speed", "no_load_speed"):
            figures[f"curve.{part}"] = getattr(joint.curve, part)
    for name in ("peak_torque", "continuous_torque", "reflected_inertia"):
        figures[name] = getattr(joint, name)
    return {
        name: _row(quantity) for name, quantity in figures.items() if quantity is not None and quantity.known
    }


def randomize_of(joint: JointActuator) -> tuple[tuple[str, str], ...]:
    """(field, flow mapping) of each range, in the joint's order."""
    return tuple((item.field, range_text(item, joint)) for item in joint.randomize)


def network_of(joint: JointActuator) -> str:
    """The network as a flow mapping; "" without one."""
    if joint.level is not Level.ACTUATOR_NET or joint.network is None:
        return ""
    named = (("file", joint.network.file), ("manifest", joint.network.manifest))
    return "{" + ", ".join(f"{key}: {scalar(path)}" for key, path in named if path is not None) + "}"


def _silence(key: str, name: str, quantity: Quantity, kinds: Sequence[FileKind]) -> str | None:
    """Why a row is `unknown`; None where it has a number that a spec can hold."""
    if quantity.value is None:
        return quantity.note or _SILENT.get(key, "not stated")
    if not stated(quantity):
        if key == "armature" and FileKind.MJCF not in kinds and FileKind.URDF in kinds:
            return _SILENT[key]
        if quantity.note == NO_KEY:
            return NO_KEY
        engine = "MuJoCo takes" if FileKind.MJCF in kinds else "the default is"
        return f"not stated: {engine} {figure(quantity.value, quantity.unit)}"
    value = quantity.value
    if not math.isfinite(value):
        return "no limit" if value > 0.0 else f"{THE_FILE} has {format_number(value)}"
    if value < 0.0 and name not in ("encoder_bias", "action_scale"):
        return f"{THE_FILE} has {quantity_text(quantity)}"
    if value == 0.0 and name in _POSITIVE:
        return f"{THE_FILE} has {quantity_text(quantity)}, which no drive would move with"
    return None


def _holds_it(name: str, friction: Quantity, joint: JointActuator) -> str | None:
    """Why a dry friction is no measurement: the drive could not move the joint. The language refuses it (FRC101)."""
    limit = joint.effort_limit
    if name not in ("friction_coulomb", "friction_static") or limit.value is None:
        return None
    if not 0.0 < limit.value <= friction.require():
        return None
    return f"{THE_FILE} has {quantity_text(friction)}, which the effort limit cannot overcome"


_SILENT = {
    "kp": "no file has gains: they are the controller's",
    "kd": "no file has gains: they are the controller's",
    "effort_limit": "no limit in the file: nothing bounds the drive's torque",
    "armature": "a URDF cannot say it: rotor inertia times gear ratio squared",
}


def _hints(joint: JointActuator) -> dict[str, str]:
    """Remarks on kd and joint damping, which files mix up."""
    viscous = joint.friction_viscous
    if joint.command is Command.EFFORT or joint.kd is None or joint.level is Level.ACTUATOR_NET:
        return {}
    for key, one in (("friction.viscous", viscous), ("kd", joint.kd)):
        if one.origin is Origin.AUTHORED:
            return {key: one.note or ""}
    if joint.kd.origin is Origin.DEFAULT or joint.kd.value in (None, 0.0):
        silent = joint.kd.known and not stated(joint.kd)
        return {"kd": joint.kd.note or ""} if silent else {}
    if viscous.value is None or viscous.value <= 0.0:
        return {}
    together = figure(joint.kd.require() + viscous.require(), viscous.unit, computed=True)
    if joint.kd.source == viscous.source:
        return {
            "friction.viscous": f"joint damping beside the servo's kv: {together} together; the effort limit does not "
            "clamp this part"
        }
    if viscous.require() >= MUCH_FRICTION * joint.kd.require():
        return {
            "friction.viscous": f"{together} together with the kd of another file; put 0 if that kd includes it"
        }
    return {}


def lost_of(quantity: Quantity) -> tuple[Lost, ...]:
    """What other files say in place of a quantity."""
    return tuple(
        Lost(other.span or (Span(other.source) if other.source else None), quantity_text(other))
        for other in quantity.lost
        if other.known and stated(other)
    )


def _row(quantity: Quantity, hint: str = "", value: str | None = None) -> Row:
    """The line of a quantity, which stands there itself where there is no other value."""
    text = sourced(quantity) if value is None else value
    refused = (
        value == "unknown" and quantity.span is not None and (quantity.value is None or stated(quantity))
    )
    return Row(text, hint, lost_of(quantity), _places(quantity), refused)


def _places(quantity: Quantity) -> tuple[Span, ...]:
    return (quantity.span,) if quantity.span is not None and quantity.source is not None else ()


def _delay(delay: Delay) -> str:
    nominal = sourced(delay.nominal) if delay.nominal.known else "unknown"
    # A range of unknown ends is none: 0 to 0 would be no delay.
    if delay.low == delay.high and (delay.sampling == "episode" or not (delay.nominal.known or delay.high)):
        return nominal
    ends = f"[{time_text(delay.low)}, {time_text(delay.high)}]"
    return f"{{nominal: {nominal}, range: {ends}, sampling: {delay.sampling}}}"


def range_text(item: Randomization, joint: JointActuator) -> str:
    """A range as a spec writes it, a flow mapping: `{scale: [0.9, 1.1], when: reset, per: joint}`."""
    kind = Kind.RATIO if item.operation == "scale" else RANDOMIZED_KINDS[item.field]
    unit = "" if kind is Kind.RATIO else unit_of_kind(kind, joint.kind)
    ends = [time_text(end) if unit == "s" else figure(end, unit) for end in (item.low, item.high)]
    parts = [f"{item.operation}: [{', '.join(ends)}]"]
    if item.distribution != "uniform":
        parts.append(f"distribution: {item.distribution}")
    parts.append(f"when: {item.when}")
    if item.every is not None:
        parts.append(f"every: [{time_text(item.every[0])}, {time_text(item.every[1])}]")
    parts.append(f"per: {item.per}")
    return f"{{{', '.join(parts)}}}"


def lost_text(rows: Sequence[Row]) -> str:
    """What other files have in place of rows of one value: `go2.xml:41, 55: 23.7 N*m`."""
    from actspec.draft.sources import places

    found: dict[str, list[Span]] = {}
    for row in rows:
        for lost in row.lost:
            found.setdefault(lost.text, []).extend([lost.span] if lost.span is not None else [])
    return "; ".join(f"{places(spans) or 'another file'} has {text}" for text, spans in found.items())
