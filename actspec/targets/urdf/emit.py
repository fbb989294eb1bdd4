"""The URDF target: limits and joint friction set in the author's text, and the proof that nothing else changed."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING

from actspec.diagnostics import Collector, EmitError, Span, listed, shortened
from actspec.ir import ActuatorSet
from actspec.robot.view import ModelFile, ModelFormat, RobotView
from actspec.targets.base import Emission, EmittedFile, TargetOptions
from actspec.targets.urdf.check import deviations
from actspec.targets.urdf.header import header
from actspec.targets.urdf.losses import format_losses
from actspec.targets.urdf.paths import from_folder, relative_paths
from actspec.targets.urdf.plan import JointEdit, joint_elements, part_of, plan_joints

if TYPE_CHECKING:
    from actspec.robot.xml import Element, XmlDocument
    from actspec.robot.xml_edit import Edit


def emit(actuators: ActuatorSet, robot: RobotView, options: TargetOptions) -> Emission:
    """Write a robot's URDF with the spec's limits and joint friction.

    Args:
        actuators: What the spec asks for, resolved against `robot`.
        robot: The robot, read from a URDF.
        options: Name and output folder.

    Raises:
        EmitError: the robot is no URDF, or one that xacro has yet to expand.
    """
    from actspec.robot.xml import parse_document
    from actspec.robot.xml_edit import InsertBefore, SetAttribute, apply_edits

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
    edits += [
        SetAttribute(element, name, from_folder(path, source, options.folder))
        for element, name, path in relative_paths(document)
    ]
    (edited,) = apply_edits(document, edits)
    name = f"{os.path.splitext(os.path.basename(robot.path))[0]}.urdf"
    file = ModelFile(os.path.join(options.folder, name), "", edited.data)
    strayed = deviations(document, (file,), plan.edits)
    if strayed:
        collector.error(
            "URD090",
            f"the written URDF is not the plan, read again: {listed(strayed, 4)}",
            help="this is an error of the compiler: please report it with the spec and the model",
        )
    collector.raise_if_failed(EmitError)
    return Emission((EmittedFile(name, file.data),), lost, collector.sorted())


def _check_format(robot: RobotView, collector: Collector) -> None:
    """Refuse a robot that is no URDF."""
    if robot.format is ModelFormat.URDF:
        return
    what = "is an MJCF" if robot.format is ModelFormat.MJCF else "is none"
    collector.error(
        "URD001",
        f"the URDF target edits a URDF, and the spec's model {what}",
        where="robot.model",
        help="name the robot's URDF, or leave the target out",
    )
    raise EmitError(collector.sorted())


def _check_expanded(document: XmlDocument, collector: Collector) -> None:
    """Refuse a xacro: its joints are not there yet. An expanded one may still name xacro's namespace."""
    prefixes = {"xacro"}
    for element in document.walk():
        prefixes.update(
            name.partition(":")[2]
            for name, value in element.values.items()
            if name.startswith("xmlns:") and "xacro" in value
        )
        if element.tag.partition(":")[0] in prefixes and ":" in element.tag:
            collector.error(
                "URD002",
                f"<{shortened(element.tag)}> is to be expanded by xacro first",
                where="robot.model",
                span=Span(document.files[0].path, element.line, element.column),
                help="xacro ROBOT.urdf.xacro > ROBOT.urdf, and name that in the spec",
            )
            return


def _text_edits(joint: Element, edit: JointEdit) -> list[Edit]:
    """A joint's edits of the text."""
    from actspec.robot.xml_edit import AppendChild, SetAttribute, format_number

    edits: list[Edit] = []
    for tag, numbers in edit.parts.items():
        part = part_of(joint, tag)
        texts = {name: format_number(value) for name, value in numbers.items()}
        if part is None:
            attributes = "".join(f' {name}="{text}"' for name, text in texts.items())
            edits.append(AppendChild(joint, f"<{tag}{attributes}/>"))
        else:
            edits += [SetAttribute(part, name, text) for name, text in texts.items()]
    return edits
