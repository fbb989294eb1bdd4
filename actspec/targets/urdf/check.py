"""The written URDF read again: it is the plan, and the author's file in everything else."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import zip_longest

from actspec.diagnostics import RobotError, Span
from actspec.robot.read_urdf import read_urdf
from actspec.robot.view import JointView, ModelFile
from actspec.robot.xml import parse_document
from actspec.robot.xml_tree import XmlDocument
from actspec.targets.urdf.plan import PARTS, UrdfJointEdit, joint_elements, part_of, relative_paths

_TEXT_ALONE = "only the text is compared"


def deviations(
    document: XmlDocument, files: Sequence[ModelFile], edits: Sequence[UrdfJointEdit]
) -> list[str]:
    """Where a written URDF is neither the plan nor the original; nothing when all is well.

    Args:
        document: The original.
        files: What is to be written, by the path that it will have.
        edits: The plan.
    """
    try:
        again = parse_document(files)
        views = read_urdf(files, again, refusal=_TEXT_ALONE).joints
    except RobotError as err:
        return [item.message for item in err.diagnostics]
    by_name = {edit.joint: edit for edit in edits}
    before = read_urdf(document.files, document, refusal=_TEXT_ALONE).joints
    found = [
        (new or old).name
        for old, new in zip_longest(before, views)
        if old is None or new is None or _bare(new) != _bare(_planned(old, by_name.get(old.name)))
    ]
    pairs = zip_longest(_elements(document, edits), _elements(again, edits))
    found += [f"<{(new or old)[0]}>" for old, new in pairs if old != new]
    return found


def _bare(joint: JointView) -> JointView:
    """Without its place in the text."""
    return replace(joint, span=Span(""), places={})


def _planned(joint: JointView, edit: UrdfJointEdit | None) -> JointView:
    """The original's joint with the planned numbers."""
    if edit is None:
        return joint
    limit, dynamics = edit.parts.get("limit", {}), edit.parts.get("dynamics", {})
    effort = limit.get("effort")
    names = {*limit, *("frictionloss" if name == "friction" else name for name in dynamics)}
    return replace(
        joint,
        effort_range=joint.effort_range if effort is None else (0.0 - effort, effort),
        velocity_limit=limit.get("velocity", joint.velocity_limit),
        damping=dynamics.get("damping", joint.damping),
        frictionloss=dynamics.get("friction", joint.frictionloss),
        stated=joint.stated | names,
    )


def _elements(document: XmlDocument, edits: Sequence[UrdfJointEdit]) -> Iterator[tuple[str, dict[str, str]]]:
    """Tag and attributes of every element, without what is planned; paths are from the root of the disk."""
    joints = joint_elements(document)
    planned: dict[int, tuple[str, ...]] = {}
    added: set[int] = set()
    for edit in edits:
        for tag, numbers in edit.parts.items():
            part = part_of(joints[edit.joint], tag) if edit.joint in joints else None
            if part is not None:
                planned[id(part)] = tuple(name for name in PARTS[tag] if name in numbers)
            if part is not None and tag in edit.added:
                added.add(id(part))
    folder = os.path.dirname(os.path.abspath(document.files[0].path))
    paths = {(id(element), name): path for element, name, path in relative_paths(document)}
    for element in document.walk():
        values = {}
        for name, value in element.values.items():
            path = paths.get((id(element), name))
            if name not in planned.get(id(element), ()):
                values[name] = value if path is None else os.path.normpath(os.path.join(folder, path))
        if id(element) not in added or values or element.children:
            yield element.tag, values
