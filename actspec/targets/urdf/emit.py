"""The URDF target: limits and joint friction set in the author's text, and the proof that nothing else changed."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import replace

from actspec.diagnostics import Collector, EmitError, Span, listed, shortened
from actspec.ir import ActuatorSet, Origin, Quantity
from actspec.robot.read_urdf import EXPAND, unexpanded
from actspec.robot.view import ModelFile, ModelFormat, RobotView
from actspec.robot.xml import parse_document
from actspec.robot.xml_edit import AppendChild, Edit, InsertBefore, SetAttribute, apply_edits, exact_number
from actspec.robot.xml_tree import Element, XmlDocument
from actspec.targets.base import Approximation, Emission, EmittedFile, PathError, TargetOptions, named_path
from actspec.targets.kit.provenance import sections, with_origin, written_by, xml_head
from actspec.targets.kit.python_text import grouped
from actspec.targets.urdf.plan import (
    UrdfJointEdit,
    deviations,
    format_losses,
    joint_elements,
    part_of,
    plan_joints,
    relative_paths,
    written,
)


def emit(actuators: ActuatorSet, robot: RobotView, options: TargetOptions) -> Emission:
    """Write a robot's URDF with the spec's limits and joint friction; see `choose.Emit`.

    Raises: EmitError: the robot is no URDF, or one that xacro has yet to expand.
    """
    collector = Collector()
    _check_format(robot, collector)
    document = parse_document(robot.files)
    _check_expanded(document, collector)
    collector.raise_if_failed(EmitError)
    plan = plan_joints(actuators, robot, document, options.name, collector)
    driven = frozenset(j.name for j in robot.joints if j.mimic is None)
    lost = (*plan.approximations, *format_losses(actuators, options.name))
    source = os.path.dirname(robot.path)
    edits: list[Edit] = [
        InsertBefore(document.root, header(actuators, driven, lost, os.path.basename(robot.path)))
    ]
    elements = joint_elements(document)
    for edit in plan.edits:
        edits += _text_edits(elements[edit.joint], edit)
    try:
        edits += [
            SetAttribute(element, name, named_path(source, path, options.folder))
            for element, name, path in relative_paths(document)
        ]
        (edited,) = apply_edits(document, edits)
    except ValueError as err:
        message = f"the text cannot be edited: {err}"
        collector.at("", Span(robot.path)).error("URD005", message, PathError.HELP)
        raise EmitError(collector.sorted()) from err
    name = f"{os.path.splitext(os.path.basename(robot.path))[0]}.urdf"
    file = ModelFile(os.path.join(options.folder, name), "", edited.data)
    strayed = deviations(document, (file,), plan.edits)
    if strayed:
        collector.error(
            "URD090",
            f"the written URDF, read again, differs from the plan: {listed(strayed, 4)}",
            help="this is an error of the compiler: please report it with the spec and the model",
        )
    collector.raise_if_failed(EmitError)
    return Emission((EmittedFile(name, file.data),), lost, collector.sorted())


def _check_format(robot: RobotView, collector: Collector) -> None:
    """Refuse a robot that is no URDF."""
    if robot.format is ModelFormat.URDF:
        return
    what = "is an MJCF" if robot.format is ModelFormat.MJCF else "is none"
    collector.at("robot.model").error(
        "URD001",
        f"the URDF target edits a URDF, and the spec's model {what}",
        "name the robot's URDF, or leave the target out",
    )
    raise EmitError(collector.sorted())


def _check_expanded(document: XmlDocument, collector: Collector) -> None:
    """Refuse a xacro, with values that are yet to be computed."""
    element = next(unexpanded(document), None)
    if element is not None:
        collector.at("robot.model", Span(document.files[0].path, element.line, element.column)).error(
            "URD002", f"<{shortened(element.tag)}> has to be expanded by xacro first", EXPAND
        )


def _text_edits(joint: Element, edit: UrdfJointEdit) -> list[Edit]:
    """A joint's edits of the text."""
    edits: list[Edit] = []
    for tag, numbers in edit.parts.items():
        part = part_of(joint, tag)
        texts = {name: exact_number(value) for name, value in numbers.items()}
        if part is None:
            attributes = "".join(f' {name}="{text}"' for name, text in texts.items())
            edits.append(AppendChild(joint, f"<{tag}{attributes}/>"))
        else:
            edits += [SetAttribute(part, name, text) for name, text in texts.items()]
    return edits


def header(actuators: ActuatorSet, driven: frozenset[str], lost: Iterable[Approximation], source: str) -> str:
    """The text of one XML comment.

    Args:
        actuators: What was compiled.
        driven: Joints whose numbers are written.
        lost: What is not in the file.
        source: File name of the robot's model.
    """
    head = [written_by(" as URDF"), *actuators.spec_lines, f"model {source}"]
    if actuators.unmanaged:
        head.append(f"Not managed by the spec: {', '.join(actuators.unmanaged)}")
    joints = [a for a in actuators.joints if a.joint in driven]
    numbers = [
        (f"{group}: {', '.join(member.joint for member in members)}", lines)
        for (group, *lines), members in grouped(joints, lambda a: (a.group, *_entries(written(a))))
    ]
    shown = (q for a in joints for q in written(a).values() if q.known)
    said = sections(actuators, _by_group(actuators, lost), "Not in this format, or not as asked:", shown)
    return xml_head(head, [*numbers, *said])


def _by_group(actuators: ActuatorSet, lost: Iterable[Approximation]) -> Iterator[Approximation]:
    """The losses with a group's name in the place of its joints where all of them lose the same."""
    groups: dict[str, set[str]] = {}
    for actuator in actuators.joints:
        groups.setdefault(actuator.group, set()).add(actuator.joint)
    for loss, members in grouped(lost, lambda one: replace(one, joint="")):
        joints = dict.fromkeys(member.joint for member in members)
        for group, own in groups.items():
            if own <= joints.keys():
                yield replace(loss, joint=group)
                joints = {joint: None for joint in joints if joint not in own}
        for joint in joints:
            yield replace(loss, joint=joint)


def _entries(numbers: dict[str, Quantity]) -> Iterator[str]:
    for attribute, quantity in numbers.items():
        if not quantity.known:
            yield f"{attribute} {with_origin(quantity)}: the file's own, if it has one"
        elif quantity.origin is Origin.DEFAULT:
            yield f"{attribute} {with_origin(quantity, 'not written')}"
        else:
            yield f"{attribute} {with_origin(quantity)}"
