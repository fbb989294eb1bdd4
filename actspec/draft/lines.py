"""The parts of a spec as lines for the template: keys, values, and the remarks beside or above them."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from actspec.diagnostics import listed
from actspec.draft.combine import Combined
from actspec.draft.groups import DraftGroup, DraftMotor, differing
from actspec.draft.names import joint_patterns, one_pattern
from actspec.draft.rows import RANGE, Row, lost_of, lost_text
from actspec.draft.sources import DraftTarget, places, stated
from actspec.draft.text import comment, figure, scalar, sourced
from actspec.fields import units_of
from actspec.ir import ActuatorSet, JointActuator, JointKind, Source
from actspec.units import format_number

_WIDTH = 100
"""Chosen: a list of joints that is longer is written one to a line."""
_COLUMNS = 120
"""Chosen: a remark that would end beyond is written above its line."""
_COMMENT = _COLUMNS - len("    # ")
_MOST_WRAPPED = 500
"""Chosen: characters of a remark over several lines; compile's longest messages with their help are shorter."""


@dataclass(frozen=True, slots=True)
class Line:
    """A line of the text, or a key with lines below it.

    Attributes:
        key: Its key, as YAML.
        value: What stands behind it, as YAML.
        comment: Remark; "" without one.
        above: Whether the remark stands above the line.
        rows: Lines below the key.
    """

    key: str
    value: str = ""
    comment: str = ""
    above: bool = False
    rows: tuple[Line, ...] = ()


def line(key: str, value: str, remark: str = "") -> Line:
    """A line with its remark, which stands above where it would be too far to the right."""
    remark = comment(remark)
    return Line(key, value, remark, len(key) + len(value) + len(remark) + 14 > _COLUMNS)


def nested(lines: Sequence[Line]) -> tuple[Line, ...]:
    """Lines with `friction.` and `curve.` keys put below one key, at the place of the first."""
    found: dict[str, list[Line]] = {}
    for item in lines:
        head, dot, part = item.key.partition(".")
        found.setdefault(head, []).append(Line(part, item.value, item.comment, item.above) if dot else item)
    return tuple(
        rows[0] if rows[0].key == head else Line(head, rows=tuple(rows)) for head, rows in found.items()
    )


def group_lines(group: DraftGroup, motors: Mapping[int, str], combined: Combined) -> dict[str, Any]:
    """One group, ready for the template.

    Args:
        group: The group.
        motors: DraftMotor of each cls.
        combined: What the files say.
    """
    base = group.classes[0]
    first = base.first
    joints = [scalar(pattern, quoted=True) for pattern in group.patterns]
    joined = ", ".join(joints)
    head = [Line("motor", scalar(group.motor))] if group.motor else []
    if base.base is not None:
        head.append(line("reduction", figure(base.ratio, "", computed=True), base.inferred))
    head += [Line("level", first.level.value), Line("command", first.command.value)]
    if base.network:
        head.append(Line("network", base.network))
    rows = [
        line(key, row.value, _remark(row, [r[key] for r in _alike(group, key)]))
        for key, row in base.rows.items()
    ]
    clamps = {name: row for cls in group.classes for name, row in cls.clamps.items()}
    values = {row.value if row is not None else None for row in clamps.values()}
    shared = next(iter(values)) if len(values) == 1 else None
    if shared is not None:
        rows.insert(_before_friction(rows), Line(RANGE, shared))
    overrides = _overrides(group, motors)
    if len(values) > 1:
        _add_clamps(overrides, clamps, group, combined)
    return {
        "name": group.name,
        "comments": [
            row
            for text in _comments(group, combined)
            for row in textwrap.wrap(comment(text, _MOST_WRAPPED), _COMMENT, break_on_hyphens=False)
        ],
        "joints": joints,
        "joints_line": joined if len(joined) <= _WIDTH else "",
        "rows": nested([*head, *rows]),
        "overrides": [
            {"pattern": scalar(pattern, quoted=True), "rows": nested(lines)}
            for pattern, lines in overrides.items()
        ],
        "randomize": base.randomize,
    }


def motor_lines(motor: DraftMotor) -> dict[str, Any]:
    """One motor, ready for the template."""
    rows = [line(key, row.value, _remark(row, [row])) for key, row in motor.rows.items()]
    remark = ""
    if motor.inferred:
        remark = "inferred: its limits have the same power; no file names the motor"
    return {"name": motor.name, "comment": comment(remark), "rows": nested(rows)}


def source_lines(source: Source) -> tuple[Line, ...]:
    """What is known about a source."""
    known = (
        ("title", source.title),
        ("url", source.url),
        ("page", source.page),
        ("commit", source.commit),
        ("accessed", source.accessed),
        ("note", source.note),
    )
    return tuple(Line(key, scalar(comment(text, 1000))) for key, text in known if text)


def left_out_lines(target: DraftTarget) -> list[str]:
    """Comments on a target that cannot be had: what it would be, and why it is none, below it where that is long."""
    head, why = (
        f"{scalar(target.name)}: {target.value}",
        f"left out: {comment(target.left_out, _MOST_WRAPPED)}",
    )
    whole = f"{head}    # {why}"
    if len(whole) <= _COMMENT:
        return [whole]
    return [head, *(f"  {row}" for row in textwrap.wrap(why, _COMMENT - 2, break_on_hyphens=False))]


def timing_lines(actuators: ActuatorSet) -> tuple[list[Line], str]:
    """Lines of `timing`, and a remark where a part of it is not said."""
    step, control = actuators.physics_dt, actuators.control_dt
    rows = []
    uneven = control is not None and control.known and actuators.decimation is None
    if stated(step) and not uneven:
        lost = lost_text([Row("", lost=lost_of(step))])
        rows.append(line("physics_dt", sourced(step), "; ".join(filter(None, (places([step.span]), lost)))))
    if control is None or not control.known:
        return rows, "decimation: 4    # physics steps in one control step; not stated" if rows else _step(
            actuators
        )
    remark = lost_text([Row("", lost=lost_of(control))])
    if actuators.decimation is not None:
        rows.append(line("decimation", str(actuators.decimation), remark))
    else:
        rows.append(
            line("control_dt", sourced(control), "; ".join(filter(None, (places([control.span]), remark))))
        )
    if uneven and stated(step):
        own = f"{format_number(1e3 * step.require())} ms ({places([step.span])})"
        return rows, f"physics_dt is left out, {own}: the control period is no whole number of them"
    return rows, "" if stated(step) else _step(actuators)


def unmanaged_lines(combined: Combined) -> Iterator[tuple[str, str]]:
    """(pattern, reason), one reason after the other."""
    for why, joints in combined.reasons().items():
        for pattern in joint_patterns(joints, combined.names):
            yield scalar(pattern, quoted=True), comment(why)


def pose_lines(combined: Combined) -> list[Line]:
    """The default pose by pattern; joints at 0 are left out."""
    joints: dict[str, list[JointActuator]] = {}
    for joint in combined.actuators.joints:
        if stated(joint.default_position) and joint.default_position.value != 0.0:
            joints.setdefault(sourced(joint.default_position), []).append(joint)
    return [
        line(
            scalar(pattern, quoted=True),
            value,
            lost_text([Row("", lost=lost_of(j.default_position)) for j in own]),
        )
        for value, own in joints.items()
        for pattern in joint_patterns([j.joint for j in own], combined.names)
    ]


def pose_remark(combined: Combined) -> str:
    """Why there are no such lines."""
    poses = [joint.default_position for joint in combined.actuators.joints]
    unread = [
        j for j in combined.actuators.joints if not j.default_position.known and j.default_position.span
    ]
    if unread and any(map(stated, poses)):
        names = listed((joint.joint for joint in unread), 4)
        return comment(f"stated as 0, but for {names}: {unread[0].default_position.note}")
    if any(map(stated, poses)):
        return "stated as 0"
    return comment(next((pose.note for pose in poses if not pose.known and pose.note), "not stated"))


def listed_joints(combined: Combined) -> list[str]:
    """Joints of a robot without a model file, those that are left alone among them."""
    found = []
    driven = {joint.joint: joint for joint in combined.actuators.joints}
    for name in combined.names:
        joint = driven.get(name)
        if joint is None:
            found.append(scalar(name))
            continue
        slide = joint.kind is JointKind.SLIDE
        parts = [f"name: {scalar(name)}"] + ["kind: slide"] * slide
        # A listed joint has room to move; of a file some have none.
        if joint.position_range is not None and joint.position_range[0] < joint.position_range[1]:
            ends = [figure(end, units_of(joint.kind).position) for end in joint.position_range]
            parts.append(f"range: [{', '.join(ends)}]")
        found.append(scalar(name) if len(parts) == 1 else f"{{{', '.join(parts)}}}")
    return found


def _step(actuators: ActuatorSet) -> str:
    step = actuators.physics_dt
    if not step.known:
        return "no file has a time step"
    return f"no file states a time step: MuJoCo takes {format_number(step.require() * 1e3)} ms"


def _remark(row: Row, rows: Sequence[Row]) -> str:
    return "; ".join(filter(None, (lost_text(rows), row.hint)))


def _alike(group: DraftGroup, key: str) -> list[dict[str, Row]]:
    """Rows of the joints of a group that have its own value of a key."""
    value = group.classes[0].rows[key].value
    return [rows for cls in group.classes if cls.rows[key].value == value for rows in cls.all_rows]


def _before_friction(rows: Sequence[Line]) -> int:
    return next((at for at, row in enumerate(rows) if row.key.startswith("friction.")), len(rows))


def _overrides(group: DraftGroup, motors: Mapping[int, str]) -> dict[str, list[Line]]:
    """Pattern to the lines in which its joints differ."""
    found: dict[str, list[Line]] = {}
    base = group.classes[0]
    for cls in group.classes[1:]:
        rows = []
        if motors.get(id(cls), "") != group.motor:
            rows.append(Line("motor", scalar(motors[id(cls)])))
        if cls.ratio != base.ratio:
            rows.append(line("reduction", figure(cls.ratio, "", computed=True), cls.inferred))
        for key in differing(base, cls):
            row = cls.rows[key]
            rows.append(line(key, row.value, _remark(row, [r[key] for r in cls.all_rows])))
        for pattern in one_pattern(cls.names, group.names):
            found.setdefault(pattern, []).extend(rows)
    return found


def _add_clamps(
    overrides: dict[str, list[Line]], clamps: Mapping[str, Row | None], group: DraftGroup, combined: Combined
) -> None:
    """Clamps that are not those of the whole group, as overrides; a joint without one has none."""
    order = {name: place for place, name in enumerate(combined.names)}
    members = sorted(group.names, key=order.__getitem__)
    for value in dict.fromkeys(row.value for row in clamps.values() if row is not None):
        names = [name for name in members if (row := clamps[name]) is not None and row.value == value]
        for pattern in joint_patterns(names, members):
            overrides.setdefault(pattern, []).append(Line(RANGE, value))


def _comments(group: DraftGroup, combined: Combined) -> Iterator[str]:
    """Where the group's numbers stand, then remarks of the files, the joints named that they do not all concern."""
    spans = [
        span for cls in group.classes for rows in cls.all_rows for row in rows.values() for span in row.spans
    ]
    spans += [span for cls in group.classes for row in cls.motor.values() for span in row.spans]
    yield places(spans or [joint.span for cls in group.classes for joint in cls.joints])
    said: dict[str, list[str]] = {}
    for name in group.names:
        for text in combined.notes.get(name, ()):
            said.setdefault(text, []).append(name)
    for text, names in said.items():
        yield text if len(names) == len(group.names) else f"{listed(names, 4)}: {text}"
    for cls in group.classes:
        for own, why in cls.maybe:
            yield f"{listed(joint_patterns(own, group.names), 4)}: {why}"
