"""What changes in a URDF, as data: limits and joint friction of the managed joints; and whether a file is that plan."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest

from actspec.diagnostics import Collector, RobotError, Span, listed
from actspec.ir import ActuatorSet, JointActuator, Level, Origin, Quantity
from actspec.laws import law_of
from actspec.robot.read_urdf import read_urdf
from actspec.robot.view import JointView, ModelFile, RobotView
from actspec.robot.xml import parse_document
from actspec.robot.xml_tree import Element, XmlDocument
from actspec.targets.base import Approximation
from actspec.targets.kit.joint import JointLosses, delta_action_loss
from actspec.targets.kit.sizes import boxed
from actspec.units import format_quantity

PARTS = {"limit": ("effort", "velocity"), "dynamics": ("damping", "friction")}
"""Element of a joint to the attributes of it that are written."""

_FIELDS = {
    "effort": ("effort_limit", "effort"),
    "velocity": ("velocity_limit", "velocity"),
    # kd is the drive's, and has no place in `damping`: readers count it a second time.
    "damping": ("friction_viscous", "damping"),
    "friction": ("friction_coulomb", "frictionloss"),
}
"""Attribute to the field of the actuator and to its name in `JointView.stated`."""

_SPEC_NAMES = {"friction_viscous": "friction.viscous", "friction_coulomb": "friction.coulomb"}


@dataclass(frozen=True, slots=True)
class UrdfJointEdit:
    """New numbers of one joint.

    Attributes:
        joint: Name.
        parts: `limit` and `dynamics` to the attributes that change, with their values
            [N*m, rad/s, N*m*s/rad; N, m/s, N*s/m].
        added: Those of the two elements that the file does not have.
    """

    joint: str
    parts: Mapping[str, Mapping[str, float]]
    added: frozenset[str]


@dataclass(frozen=True, slots=True)
class UrdfPlan:
    """All edits of limits and friction.

    Attributes:
        edits: In the robot's order; only joints that change.
        approximations: Limits for which the file has no place.
    """

    edits: tuple[UrdfJointEdit, ...]
    approximations: tuple[Approximation, ...]


def written(actuator: JointActuator) -> dict[str, Quantity]:
    """Attribute of the URDF to the number that it is made of."""
    return {attribute: getattr(actuator, field) for attribute, (field, _) in _FIELDS.items()}


def joint_elements(document: XmlDocument) -> dict[str, Element]:
    """Joint to its element."""
    return {element.get("name") or "": element for element in document.sections("joint")}


def part_of(joint: Element, tag: str) -> Element | None:
    """A joint's `<limit>` or `<dynamics>`; the first, as every reader takes it."""
    return next((child for child in joint.children if child.tag == tag), None)


def plan_joints(
    actuators: ActuatorSet, robot: RobotView, document: XmlDocument, target: str, collector: Collector
) -> UrdfPlan:
    """Plan the edits; what is unknown keeps the file's own number.

    Args:
        actuators: What the spec asks for.
        robot: The URDF, read.
        document: The same, parsed.
        target: Name of the target.
        collector: Takes warnings and notes.
    """
    elements = joint_elements(document)
    edits: list[UrdfJointEdit] = []
    lost: list[Approximation] = []
    driven: list[JointActuator] = []
    for actuator in actuators.joints:
        joint = robot.joint(actuator.joint)
        assert joint is not None
        if joint.mimic is not None:
            collector.at(joint.name, joint.span).warning(
                "URD003",
                f"follows '{joint.mimic}' (<mimic>): it has no drive of its own, and stays as it is in the file",
                "list it under robot.unmanaged",
            )
            continue
        driven.append(actuator)
        element = elements[joint.name]
        losses = JointLosses(actuator, target)
        parts: dict[str, dict[str, float]] = {}
        for tag, attributes in PARTS.items():
            numbers = written(actuator)
            asked = {
                name: value for name in attributes if (value := _new(name, numbers[name], joint)) is not None
            }
            why = _no_place(element, numbers) if tag == "limit" else ""
            if asked and not why:
                parts[tag] = asked
            elif asked:
                for name, value in asked.items():
                    losses.approximate(
                        _FIELDS[name][0], format_quantity(value, numbers[name].unit), "none", why, None
                    )
        lost += losses.lost
        if parts:
            added = frozenset(tag for tag in parts if part_of(element, tag) is None)
            edits.append(UrdfJointEdit(joint.name, parts, added))
    _tell_unknown(driven, robot, collector)
    return UrdfPlan(tuple(edits), tuple(lost))


def _new(attribute: str, quantity: Quantity, joint: JointView) -> float | None:
    """The number to write; None: the file has it, or nobody says one."""
    if quantity.value is None or quantity.origin is Origin.DEFAULT:
        return None
    stated = _FIELDS[attribute][1] in joint.stated
    return None if stated and own_value(attribute, joint) == quantity.value else quantity.value


def own_value(attribute: str, joint: JointView) -> float | None:
    """The file's number; None: no limit."""
    if attribute == "effort":
        return None if joint.effort_range is None else joint.effort_range[1]
    if attribute == "velocity":
        return joint.velocity_limit
    return joint.damping if attribute == "damping" else joint.frictionloss


def _no_place(element: Element, numbers: Mapping[str, Quantity]) -> str:
    """Why the limits of a joint cannot be written; "" when they can."""
    if part_of(element, "limit") is not None:
        return ""
    if element.get("type") != "continuous":
        # Its range would be 0 to 0 for readers that take the format at its word.
        return "the joint has no <limit>, and one without lower and upper would lock it"
    if all(numbers[name].known for name in PARTS["limit"]):
        return ""
    return "the joint has no <limit>, which needs effort and velocity, and one of them is unknown"


def _tell_unknown(driven: Iterable[JointActuator], robot: RobotView, collector: Collector) -> None:
    """Say where a number of the file is nobody's."""
    for attribute, (field, stated) in _FIELDS.items():
        unknown = [a for a in driven if not getattr(a, field).known]
        kept = [a for a in unknown if (joint := robot.joint(a.joint)) is not None and stated in joint.stated]
        bare = [a for a in unknown if a not in kept]
        for members, what in ((kept, "stays as the file has it"), (bare, "is not in the file either")):
            if not members:
                continue
            name = _SPEC_NAMES.get(field, field)
            collector.at(
                f"actuators.{members[0].group}.{name}", getattr(members[0], field).span or members[0].span
            ).info("URD004", f"{name} is unknown, and {attribute} {what}: {listed(a.joint for a in members)}")


_NO_DRIVE = "a URDF describes joints, not their drives"


def format_losses(actuators: ActuatorSet, target: str) -> Iterator[Approximation]:
    """What of the actuators is not in this format, joint by joint.

    Args:
        actuators: What the spec asks for.
        target: Name of the target.
    """
    for actuator in actuators.joints:
        losses = JointLosses(actuator, target)
        for field in ("kp", "kd"):
            gain = getattr(actuator, field)
            if gain is not None and gain.known:
                losses.approximate(field, format_quantity(gain.value, gain.unit), "none", _NO_DRIVE, None)
        if actuator.level is Level.DC_MOTOR:
            _lose_curve(losses)
        for field, asked in _command_path(actuator):
            losses.approximate(field, asked, "none", _NO_DRIVE, None)
        if actuator.armature.value:
            asked = format_quantity(actuator.armature.value, actuator.armature.unit)
            losses.approximate("armature", asked, "none", "a URDF has no armature of a joint", None)
        losses.no_break_away(
            None, "friction is one number for sticking and sliding", "a URDF has no Stribeck effect"
        )
        yield from losses.lost
    yield from delta_action_loss(actuators, target, _NO_DRIVE)


def _command_path(actuator: JointActuator) -> Iterator[tuple[str, str]]:
    """What of a drive's network and command is not written at all: field, and what is asked for."""
    if actuator.network is not None:
        yield "network", actuator.network.name
    if actuator.filter_cutoff is not None and actuator.filter_cutoff.known:
        yield "command_filter", format_quantity(actuator.filter_cutoff.value, actuator.filter_cutoff.unit)
    if actuator.command_range is not None:
        low, high = (format_quantity(end.value, end.unit) for end in actuator.command_range)
        yield "command_range", f"{low} to {high}"
    delay = actuator.delay
    if delay is not None:
        nominal = delay.nominal.value
        said = "unknown" if nominal is None else f"{nominal * 1e3:g} ms"
        if delay.low != delay.high:
            said += f", range {delay.low * 1e3:g} to {delay.high * 1e3:g} ms"
        yield "delay", said
    if actuator.encoder_bias.value:
        yield "encoder_bias", format_quantity(actuator.encoder_bias.value, actuator.encoder_bias.unit)


def _lose_curve(losses: JointLosses) -> None:
    """The torque-speed line or curve, against a drive with the same gains and the effort limit alone."""
    actuator = losses.actuator
    stall, no_load, kind = actuator.stall_torque, actuator.no_load_speed, "line"
    if actuator.curve is not None:
        stall, no_load, kind = actuator.curve.drive_torque, actuator.curve.no_load_speed, "curve"
    ends = [
        "unknown" if end is None else format_quantity(end.value, unit)
        for end, unit in ((stall, losses.unit), (no_load, actuator.velocity_limit.unit))
    ]
    asked, why = f"{kind} from {ends[0]} to {ends[1]}", "a URDF has one effort limit for all speeds"
    emitted = f"effort {format_quantity(actuator.effort_limit.value, losses.unit)}"
    try:
        law = law_of(actuator)
    except ValueError:
        # It lacks a number.
        losses.approximate("torque_speed_curve", asked, emitted, why, None)
    else:
        losses.lose_line(asked, emitted, why, law, boxed(law).torque)


_KEPT = re.compile(r"[A-Za-z][A-Za-z0-9+.-]*:|[/\\$]")
"""A URL (`package://`, `file:`), a drive, an absolute path or a substitution."""

_FOLDERS = ("meshdir", "texturedir", "assetdir")


def relative_paths(document: XmlDocument) -> Iterator[tuple[Element, str, str]]:
    """Every path that counts from the file's own folder: (element, attribute, path).

    MuJoCo's own `<compiler>` inside a URDF names folders. Where it says `strippath="false"` it joins them with
    the file names, which then count from there.
    """
    joined = False
    own = (child for section in document.sections("mujoco") for child in section.children)
    for compiler in (element for element in own if element.tag == "compiler"):
        folders = [name for name in _FOLDERS if compiler.get(name)]
        joined = joined or (bool(folders) and compiler.get("strippath") == "false")
        yield from _relative(compiler, *folders)
    if not joined:
        for element in document.walk("mesh", "texture"):
            yield from _relative(element, "filename")


def _relative(element: Element, *names: str) -> Iterator[tuple[Element, str, str]]:
    for name in names:
        path = element.get(name)
        if path and not _KEPT.match(path):
            yield element, name, path


# --- the written file, read again -------------------------------------------------------------------------


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
