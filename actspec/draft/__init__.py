"""DraftedSpec: what files say of a robot becomes the text of a spec that a person would have written."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import actspec
from actspec.diagnostics import RobotError, Span, listed, many, one_line
from actspec.draft.combine import Combined
from actspec.draft.damping import question, settled
from actspec.draft.groups import DraftGroup, groups_of, motors_of
from actspec.draft.including import including
from actspec.draft.lines import (
    group_lines,
    left_out_lines,
    line,
    listed_joints,
    motor_lines,
    pose_lines,
    pose_remark,
    source_lines,
    timing_lines,
    unmanaged_lines,
)
from actspec.draft.rows import THE_FILE
from actspec.draft.sources import DraftTarget, places
from actspec.draft.text import comment, render, scalar
from actspec.ir import Command
from actspec.patterns import PatternError
from actspec.robot.view import ModelFormat
from actspec.robot.xml import parse_document
from actspec.robot.xml_tree import Element, XmlDocument
from actspec.simulators.mujoco import RELEASES

EFFORT = "Torque motors: the gains are the caller's. For a servo write `command: position`, kp and kd."


@dataclass(frozen=True, slots=True)
class DraftedSpec:
    """A drafted spec.

    Attributes:
        text: The spec's YAML.
        robot: Name of the robot.
        groups: Name of each group to its number of joints.
        unknown: Fields that no file states, and behind them why what one states is left out, to the groups that lack
            them, with the joints where it is not all.
        inferred: What was taken, or may be taken, for one motor, and why; whose damping may be kd, or is.
    """

    text: str
    robot: str
    groups: Mapping[str, int]
    unknown: Mapping[tuple[str, str], tuple[str, ...]]
    inferred: tuple[str, ...]


def starting_spec() -> str:
    """A commented spec that shows the language, with example values."""
    major, minor = max(RELEASES)
    return render("start.yaml.j2", mujoco=f"{major}.{minor}")


def draft(
    combined: Combined,
    model: str,
    targets: Sequence[DraftTarget],
    damping: str | None = None,
    packages: Mapping[str, str] = MappingProxyType({}),
) -> DraftedSpec:
    """Write the spec of a robot.

    Args:
        combined: What the files say.
        model: What the spec is to name the robot file by: a path from the spec's folder, `package://DIST/path`
            or `none`.
        targets: What the spec is to compile to, and what it cannot.
        damping: What joint damping of drives without kd is, `as-kd` or `as-friction`; None: a comment asks.
        packages: ROS packages that the model names and their folders, from the spec's.

    Raises:
        RobotError: there is no joint that a spec could describe, or a name is too long.
    """
    asked = answered = ""
    if damping is None:
        asked = question(combined.actuators.joints)
    else:
        combined, answered = settled(combined, damping)
    actuators = combined.actuators
    if not actuators.joints:
        raise _nothing(combined)
    try:
        groups = groups_of(actuators.joints, combined.kinds, combined.above, combined.names, actuators.robot)
        unmanaged, pose = list(unmanaged_lines(combined)), pose_lines(combined)
        motors, named = motors_of(groups)
        written = [group_lines(group, named, combined) for group in groups]
    except PatternError as err:
        raise _error(
            combined, "DRF003", err.message, err.help or "shorten the joint's name in the file"
        ) from err
    for group, lines in zip(groups, written, strict=True):
        if group.classes[0].first.command is Command.EFFORT:
            lines["comments"].append(EFFORT)
            break
    timing, untimed = timing_lines(actuators)
    text = render(
        "draft.yaml.j2",
        version=actspec.__version__,
        name=scalar(actuators.robot),
        model=model if model == "none" else scalar(model),
        packages=[(scalar(name), scalar(at)) for name, at in packages.items()],
        remarks=[
            row
            for text in combined.notes.get("", ())
            for row in textwrap.wrap(comment(text, 500), 110, break_on_hyphens=False)
        ],
        joints=listed_joints(combined) if model == "none" else [],
        unmanaged=unmanaged,
        pose=pose,
        pose_remark=pose_remark(combined),
        timing=timing,
        untimed=untimed,
        sources=[{"key": scalar(source.key), "rows": source_lines(source)} for source in actuators.sources],
        motors=[motor_lines(motor) for motor in motors],
        groups=written,
        question=textwrap.wrap(asked[:1].upper() + asked[1:], 110, break_on_hyphens=False),
        targets=[line(scalar(t.name), t.value, t.remark) for t in targets if not t.left_out],
        left_out=[left_out_lines(t) for t in targets if t.left_out],
    )
    return DraftedSpec(
        text,
        actuators.robot,
        {group.name: len(group.names) for group in groups},
        _unknown(groups),
        (*_gears(groups), *filter(None, (asked or answered,))),
    )


def _gears(groups: Sequence[DraftGroup]) -> Iterator[str]:
    """What was taken, or may be taken, for one motor behind two gears."""
    for cls in (cls for group in groups for cls in group.classes):
        if cls.inferred:
            yield f"{cls.label}: {cls.inferred}"
        yield from (f"{listed(names, 4)}: {why}" for names, why in cls.maybe)


def _unknown(groups: Sequence[DraftGroup]) -> dict[tuple[str, str], tuple[str, ...]]:
    """Fields that are unknown, each with why a number of a file is left out or "" where none states one.

    To the groups that lack them: `legs`, and `arms (elbow)` where it is some joints.
    """
    found: dict[tuple[str, str], list[str]] = {}
    spans: dict[tuple[str, str], list[Span]] = {}
    for group in groups:
        lacking: dict[tuple[str, str], list[str]] = {}
        for cls in group.classes:
            for key, row in cls.rows.items():
                # A delay has a row where a file states one, and a note of its own where its steps have no length.
                if row.value == "unknown" and key != "delay":
                    why = row.hint if row.refused else ""
                    lacking.setdefault((key, why), []).extend(map(one_line, cls.names))
                    spans.setdefault((key, why), []).extend(row.spans)
        for missing, names in lacking.items():
            some = f" ({listed(names, 4)})" if len(names) < len(group.names) else ""
            found.setdefault(missing, []).append(group.name + some)
    return {(key, _placed(why, spans[key, why])): tuple(lost) for (key, why), lost in found.items()}


def _placed(why: str, spans: Sequence[Span]) -> str:
    """Why a number is left out, with where it stands: `leg.xml:2 has 5 N*m, which ...`."""
    return places(spans) + why.removeprefix(THE_FILE) if spans and why.startswith(THE_FILE) else why


def _nothing(combined: Combined) -> RobotError:
    alone = combined.left_alone
    whole = including(combined.model.path) if combined.model is not None else None
    instead = f"it is a part of {whole}: import the whole model" if whole else ""
    if alone:
        reasons = [f"{why}: {listed(map(one_line, names), 4)}" for why, names in combined.reasons().items()]
        return _error(
            combined,
            "DRF002",
            f"none of its {many(len(alone), 'joint')} can go into a group: {'; '.join(reasons)}",
            instead
            or "a spec describes joints that are driven one by one; `actspec init` alone writes an example",
        )
    document, lost = _outside(combined)
    if document is not None and lost:
        names = listed([one_line(element.get("name") or "") for element in lost], 4)
        joints = f"joint{'s' * (len(lost) > 1)} {names}"
        return RobotError.of(
            "DRF001",
            f"MuJoCo reads no body outside of <worldbody>, where this file has the {joints}",
            document.span(lost[0]),
            help=instead
            or "put the bodies into <worldbody>, or import the file that includes this one there",
        )
    return _error(
        combined,
        "DRF001",
        "it has no hinge or slide joint with a name: there is nothing to draft",
        instead or "name the file that holds the robot itself, and give its joints names",
    )


def _outside(combined: Combined) -> tuple[XmlDocument | None, list[Element]]:
    """Joints with a name whose bodies stand beside <worldbody>, and their document; of an MJCF."""
    robot = combined.model.artifact.robot if combined.model is not None else None
    if robot is None or robot.format is not ModelFormat.MJCF:
        return None, []
    document = parse_document(robot.files)
    bodies = [replace(document, root=body) for body in document.sections("body")]
    return document, [joint for body in bodies for joint in body.walk("joint") if joint.get("name")]


def _error(combined: Combined, code: str, message: str, help: str) -> RobotError:
    span = Span(combined.model.path) if combined.model is not None else None
    return RobotError.of(code, message, span, help=help)
