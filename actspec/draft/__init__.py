"""Draft: a robot file becomes the text of a first spec, one group per distinct set of numbers."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import actspec
from actspec.diagnostics import Diagnostic, RobotError, Severity, Span, listed, one_line
from actspec.draft.facts import Facts, LeftAlone, figure, read_facts
from actspec.draft.names import group_name, joint_patterns
from actspec.draft.text import comment, render, scalar
from actspec.ir import JointKind
from actspec.patterns import PatternError
from actspec.robot.view import ModelFormat, RobotView
from actspec.targets.versions import MUJOCO_RELEASES
from actspec.units import Kind, UnitError, parse_quantity

SOURCE = "model_file"
"""Key of the robot file among the draft's sources."""

EFFORT = "Torque motors: the gains are the caller's. For a servo write `command: position`, kp and kd."

_WIDTH = 100


@dataclass(frozen=True, slots=True)
class Draft:
    """A drafted spec.

    Attributes:
        text: The spec's YAML.
        robot: Name of the robot.
        groups: Name of each group to its number of joints.
        left_alone: Joints that are in no group, with the reason.
        unknown: Fields that the file does not state, to the groups that lack them.
    """

    text: str
    robot: str
    groups: Mapping[str, int]
    left_alone: tuple[LeftAlone, ...]
    unknown: Mapping[str, tuple[str, ...]]


@dataclass(frozen=True, slots=True)
class _Row:
    key: str
    value: str
    comment: str = ""


def starting_spec() -> str:
    """A commented spec that shows the language, with example values."""
    return render("start.yaml.j2", mujoco=_newest())


def draft_spec(robot: RobotView, model: str) -> Draft:
    """Draft a spec from what a robot file says.

    Args:
        robot: The robot.
        model: What the spec is to name it by: a path from the spec's folder, or `package://DIST/path`.

    Raises:
        RobotError: the file has no joint that a spec could describe, or a name is too long.
    """
    facts, alone = read_facts(robot)
    if not facts:
        raise _nothing(robot, alone)
    merged: dict[tuple[object, ...], list[Facts]] = {}
    for fact in facts:
        merged.setdefault(fact.key, []).append(fact)
    names = [j.name for j in robot.joints if j.kind in (JointKind.HINGE, JointKind.SLIDE)]
    groups: list[dict[str, Any]] = []
    motors: list[dict[str, str]] = []
    unknown: dict[str, list[str]] = {}
    counts: dict[str, int] = {}
    explained = False
    try:
        for members in merged.values():
            name = group_name([fact.joint.name for fact in members], counts)
            counts[name] = len(members)
            first = members[0]
            if first.line is not None:
                stall, free = first.line
                motors.append({"name": f"{name}_motor", "stall_torque": stall, "no_load_speed": free})
            for field, value in first.values:
                if value is None:
                    unknown.setdefault(field, []).append(name)
            groups.append(_group(name, members, names))
            if first.command == "effort" and not explained:
                groups[-1]["notes"].append(EFFORT)
                explained = True
        unmanaged = list(_unmanaged(alone, names))
    except PatternError as err:
        raise _error(
            robot, "DRF003", err.message, err.help or "shorten the joint's name in the file"
        ) from err
    file = os.path.basename(robot.path)
    title = f"{file}, the robot file that this spec was drafted from"
    text = render(
        "draft.yaml.j2",
        version=actspec.__version__,
        file=comment(file),
        name=scalar(robot_name(robot)),
        model=scalar(model),
        title=scalar(one_line(title)),
        unmanaged=unmanaged,
        groups=groups,
        motors=motors,
        mujoco=_newest(),
        **_timing(robot),
    )
    return Draft(
        text, robot_name(robot), counts, alone, {key: tuple(names) for key, names in unknown.items()}
    )


def robot_name(robot: RobotView) -> str:
    """The model's name, else its file's, as a folder may be called."""
    stem = os.path.splitext(os.path.basename(robot.path))[0]
    for text in (robot.name, stem):
        name = re.sub(r"[^A-Za-z0-9_.-]+", "_", text).strip("_.-")[:60]
        if name:
            return name
    return "robot"


def _newest() -> str:
    major, minor = MUJOCO_RELEASES[-1]
    return f"{major}.{minor}"


def _group(name: str, members: Sequence[Facts], names: Sequence[str]) -> dict[str, Any]:
    """One group, ready for the template."""
    first = members[0]
    joints = [scalar(p, quoted=True) for p in joint_patterns([f.joint.name for f in members], names)]
    line = ", ".join(joints)
    hints = dict(first.hints)
    rows = [_row(field, value, hints.get(field, "")) for field, value in first.values]
    clamps = {fact.joint.name: fact.clamp for fact in members}
    overrides: list[tuple[str, str]] = []
    if len(set(clamps.values())) == 1:
        if first.clamp is not None:
            rows.append(_Row("command_range", _clamp(first.clamp)))
    else:
        mine = list(clamps)
        for clamp in dict.fromkeys(clamps.values()):
            if clamp is not None:
                same = [joint for joint in mine if clamps[joint] == clamp]
                overrides += [(scalar(p, quoted=True), _clamp(clamp)) for p in joint_patterns(same, mine)]
    return {
        "name": name,
        "places": comment(_places(members)),
        "notes": [comment(note) for note in first.notes],
        "joints": joints,
        "joints_line": line if len(line) <= _WIDTH else "",
        "motor": f"{name}_motor" if first.line is not None else "",
        "level": first.level,
        "command": first.command,
        "rows": [row for row in rows if not row.key.startswith("friction.")],
        "friction": [
            _Row(row.key.removeprefix("friction."), row.value, row.comment)
            for row in rows
            if row.key.startswith("friction.")
        ],
        "overrides": overrides,
    }


def _row(field: str, value: str | None, hint: str) -> _Row:
    if value is None:
        return _Row(field, "unknown", comment(hint or "the file does not say"))
    text = f"{{value: {value}, source: {SOURCE}}}"
    return _Row(field, f"{{cutoff: {text}}}" if field == "command_filter" else text, comment(hint))


def _clamp(clamp: str | tuple[str, str]) -> str:
    if isinstance(clamp, str):
        return clamp
    return "[" + ", ".join(f"{{value: {end}, source: {SOURCE}}}" for end in clamp) + "]"


def _places(members: Sequence[Facts]) -> str:
    """`go2.xml:82, 90 (joints), 223, 224 (actuators)`."""
    joints = [fact.joint.span for fact in members]
    actuators = [actuator.span for fact in members for actuator in fact.actuators]
    text = f"{_lines(joints)} (joint{'s' * (len(joints) > 1)})"
    if not actuators:
        return text
    there = _lines(actuators)
    file = f"{os.path.basename(joints[0].path)}:"
    if all(os.path.basename(span.path) == file[:-1] for span in (*joints, *actuators)):
        there = there.removeprefix(file)
    return f"{text}, {there} (actuator{'s' * (len(actuators) > 1)})"


def _lines(spans: Iterable[Span]) -> str:
    by_file: dict[str, set[int]] = {}
    for span in spans:
        by_file.setdefault(os.path.basename(span.path), set()).update([span.line] if span.line else [])
    return ", ".join(
        f"{file}:{listed(map(str, sorted(lines)))}" if lines else file for file, lines in by_file.items()
    )


def _unmanaged(alone: Sequence[LeftAlone], names: Sequence[str]) -> Iterator[tuple[str, str]]:
    """(pattern, reason), one reason after the other."""
    reasons: dict[str, list[str]] = {}
    for item in alone:
        reasons.setdefault(item.why, []).append(item.joint)
    for why, joints in reasons.items():
        for pattern in joint_patterns(joints, names):
            yield scalar(pattern, quoted=True), comment(why)


def _timing(robot: RobotView) -> dict[str, str]:
    """The file's own time step, if it states one."""
    if robot.timestep is None or robot.format is not ModelFormat.MJCF:
        return {"physics_dt": "", "physics_dt_place": "", "no_physics_dt": "the file has no time step"}
    from actspec.robot.xml import parse_document

    document = parse_document(robot.files)
    stating = [option for option in document.sections("option") if option.get("timestep") is not None]
    if not stating or not robot.timestep > 0.0:
        nothing = f"the file states no time step: MuJoCo takes {robot.timestep * 1e3:g} ms"
        return {"physics_dt": "", "physics_dt_place": "", "no_physics_dt": nothing}
    place = comment(_lines([document.span(stating[-1])]))
    return {"physics_dt": time_text(robot.timestep), "physics_dt_place": place, "no_physics_dt": ""}


def time_text(seconds: float) -> str:
    """`2 ms` where that reads back as the same double, else in seconds."""
    text = figure(seconds * 1e3, "ms", False)
    try:
        return text if parse_quantity(text, Kind.TIME).value == seconds else figure(seconds, "s", True)
    except UnitError:
        return figure(seconds, "s", True)


def _nothing(robot: RobotView, alone: Sequence[LeftAlone]) -> RobotError:
    if alone:
        reasons = dict.fromkeys(f"{item.joint}: {item.why}" for item in alone)
        return _error(
            robot,
            "DRF002",
            f"none of its {len(alone)} joints can go into a group: {listed(reasons, 4)}",
            "a spec describes joints that are driven one by one; `actspec init` alone writes an example",
        )
    return _error(
        robot,
        "DRF001",
        "it has no hinge or slide joint with a name: there is nothing to draft",
        "name the file that holds the robot itself, and give its joints names",
    )


def _error(robot: RobotView, code: str, message: str, help: str) -> RobotError:
    return RobotError([Diagnostic(code, Severity.ERROR, message, "", Span(robot.path), help)])
